// The far field: the light of the whole width of a fibre (Yan17 Sec. 5). Its integrals over the offset are factors of
// the azimuth, which a table has for inclinations of wo. The longitudinal lobes are those of the near field.
//
// The program that includes this part defines one more function:
//   fn vellus_far_row(row: u32) -> vec4<f32>   reads the buffer of the tables of the far field.

// The components whose factors are in the table: R, TT, TRT, and the backward and forward half of scattered light.
const VELLUS_FAR_FACTORS = 5u;
// The rows of energies before the factors of an inclination.
const VELLUS_FAR_ENERGIES = 8u;

// Prepares a hit. `fiber` is the index of the prepared fibre, and `table` the first row of its table. The lobes 3 and 4
// of such a hit are the backward and the forward half of scattered light, for sampling; their energies are those of
// TTs and TRTs.
fn vellus_far_hit(hit: ptr<function, VellusHit>, fiber: u32, table: u32, wo: vec3<f32>) {
    let sin_o = clamp(wo.x, -1.0, 1.0);
    let cos_o = length(wo.yz);
    vellus_begin(hit, fiber, wo, sin_o, cos_o);
    (*hit).scatters = vellus_fiber(fiber, VELLUS_MEDULLA).w > 0.0;
    if (*hit).scatters {
        let sin_t = sin_o / vellus_fiber(fiber, VELLUS_OPTICS).x;
        let cos_t = sqrt(max((1.0 - sin_t) * (1.0 + sin_t), 1e-12));
        let gain = vellus_fiber(fiber, VELLUS_CORTEX).w;
        let reflects = gain > 0.0;
        let theta = vellus_atan2(select(sin_o, sin_t, reflects), select(cos_o, cos_t, reflects));
        vellus_prepare_inclination(hit, fiber, theta, gain);
    }
    let head = vellus_far_row(table);
    let rest = max(1.0 - vellus_atan2(abs(sin_o), cos_o) * (2.0 / VELLUS_PI), 0.0);
    let at = vellus_on(1.0 - sqrt(rest), u32(head.x));
    let stride = u32(head.w);
    let row = table + 1u + at.index * stride;
    var sum = VELLUS_TINY;
    for (var p = 0u; p < 7u; p++) {
        let energy = mix(vellus_far_row(row + p), vellus_far_row(row + stride + p), at.t);
        (*hit).attenuation[p] = energy;
        sum += energy.w;
    }
    for (var p = 0u; p < 7u; p++) {
        (*hit).attenuation[p].w /= sum;
    }
    (*hit).later = mix(vellus_far_row(row + 7u).xy, vellus_far_row(row + stride + 7u).xy, at.t);
    (*hit).far = VellusFar(row, stride, at.t, u32(head.y), head.z, 1.0 / sum);
}

// Factor `p` at a position between two azimuths.
fn vellus_far_factor(hit: ptr<function, VellusHit>, at: VellusBetween, p: u32) -> vec4<f32> {
    let row = (*hit).far.row + VELLUS_FAR_ENERGIES + at.index * VELLUS_FAR_FACTORS + p;
    let next = row + (*hit).far.stride;
    let low = mix(vellus_far_row(row), vellus_far_row(row + VELLUS_FAR_FACTORS), at.t);
    let high = mix(vellus_far_row(next), vellus_far_row(next + VELLUS_FAR_FACTORS), at.t);
    return mix(low, high, (*hit).far.t);
}

// The azimuths around phi.
fn vellus_far_azimuths(hit: ptr<function, VellusHit>, phi: f32) -> VellusBetween {
    return vellus_between(abs(vellus_wrap(phi)) * (*hit).far.per_radian, (*hit).far.azimuths);
}

// The densities of both halves of scattered light over theta_i. The factors contain the share that leaves the fibre.
fn vellus_far_halves(hit: ptr<function, VellusHit>, d: VellusDirection) -> vec2<f32> {
    return vellus_leaving(hit, d.theta, d.sin_i) / max((*hit).leaving, vec2<f32>(VELLUS_TINY));
}

// f cos of all lobes in xyz, and the density of sampling in w.
fn vellus_far_combine(hit: ptr<function, VellusHit>, d: VellusDirection) -> vec4<f32> {
    let at = vellus_far_azimuths(hit, d.phi);
    let m = vellus_longitudinal(hit, d.sin_i, d.cos_i);
    var sum = vellus_far_factor(hit, at, 0u) * m.x + vellus_far_factor(hit, at, 1u) * m.y
        + vellus_far_factor(hit, at, 2u) * m.z;
    if (*hit).scatters {
        let halves = vellus_far_halves(hit, d);
        sum += vellus_far_factor(hit, at, 3u) * halves.x + vellus_far_factor(hit, at, 4u) * halves.y;
    }
    sum.w *= (*hit).far.inverse;
    let later = vellus_diffuse(d.cos_i) * vellus_turn_uniform((*hit).later, d.around);
    return sum + (*hit).attenuation[5] * (m.w / VELLUS_TAU) + (*hit).attenuation[6] * later;
}

// The part of TTs in the backward (0) or the forward (1) half of scattered light.
fn vellus_far_part(hit: ptr<function, VellusHit>, at: VellusBetween, half: u32) -> vec3<f32> {
    let azimuths = (*hit).far.azimuths;
    let sums = (VELLUS_FAR_FACTORS * azimuths + 3u) / 4u;
    let row = (*hit).far.row + VELLUS_FAR_ENERGIES + VELLUS_FAR_FACTORS * azimuths + sums + 2u * at.index + half;
    let next = row + (*hit).far.stride;
    let low = mix(vellus_far_row(row).xyz, vellus_far_row(row + 2u).xyz, at.t);
    let high = mix(vellus_far_row(next).xyz, vellus_far_row(next + 2u).xyz, at.t);
    return mix(low, high, (*hit).far.t);
}

// f cos of each lobe.
fn vellus_far_eval_lobes(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> VellusLobes {
    let d = vellus_direction(hit, wi);
    let at = vellus_far_azimuths(hit, d.phi);
    let m = vellus_longitudinal(hit, d.sin_i, d.cos_i);
    var lobes: VellusLobes;
    for (var p = 0u; p < 3u; p++) {
        lobes.rgb[p] = vellus_far_factor(hit, at, p).xyz * m[p];
    }
    if (*hit).scatters {
        let halves = vellus_far_halves(hit, d);
        let tts = vellus_far_part(hit, at, 0u) * halves.x + vellus_far_part(hit, at, 1u) * halves.y;
        let both = vellus_far_factor(hit, at, 3u).xyz * halves.x + vellus_far_factor(hit, at, 4u).xyz * halves.y;
        lobes.rgb[3] = tts;
        lobes.rgb[4] = max(both - tts, vec3<f32>(0.0));
    }
    lobes.rgb[5] = (*hit).attenuation[5].xyz * (m.w / VELLUS_TAU)
        + (*hit).attenuation[6].xyz * vellus_diffuse(d.cos_i) * vellus_turn_uniform((*hit).later, d.around);
    return lobes;
}

// f cos of all lobes in xyz, and the density with which vellus_far_sample draws wi in w.
fn vellus_far_eval(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> vec4<f32> {
    return vellus_far_combine(hit, vellus_direction(hit, wi));
}

// The density with which vellus_far_sample draws wi.
fn vellus_far_pdf(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> f32 {
    return vellus_far_eval(hit, wi).w;
}

// The integral of factor `p` from azimuth 0 to that of node `j`, at the inclination that begins at `row`.
fn vellus_far_sum(hit: ptr<function, VellusHit>, row: u32, p: u32, j: u32) -> f32 {
    let azimuths = (*hit).far.azimuths;
    let index = p * azimuths + j;
    return vellus_far_row(row + VELLUS_FAR_ENERGIES + VELLUS_FAR_FACTORS * azimuths + index / 4u)[index % 4u];
}

fn vellus_far_place(hit: ptr<function, VellusHit>, row: u32, p: u32, j: u32) -> VellusPlace {
    let density = vellus_far_row(row + VELLUS_FAR_ENERGIES + j * VELLUS_FAR_FACTORS + p).w;
    return VellusPlace(f32(j) / (*hit).far.per_radian, vellus_far_sum(hit, row, p, j), density);
}

// Draws an azimuth from factor `p`: first one of two inclinations and a side, then a place between two nodes.
fn vellus_far_azimuth(hit: ptr<function, VellusHit>, p: u32, u: f32) -> f32 {
    let last = (*hit).far.azimuths - 1u;
    let t = (*hit).far.t;
    let low = (1.0 - t) * vellus_far_sum(hit, (*hit).far.row, p, last);
    let high = t * vellus_far_sum(hit, (*hit).far.row + (*hit).far.stride, p, last);
    let share = low / max(low + high, VELLUS_TINY);
    let is_low = u < share;
    let row = select((*hit).far.row + (*hit).far.stride, (*hit).far.row, is_low);
    let v = 2.0 * clamp(select((u - share) / max(1.0 - share, VELLUS_TINY), u / share, is_low), 0.0, 1.0);
    let side = select(-1.0, 1.0, v < 1.0);
    let w = select(v - 1.0, v, v < 1.0);
    let target_sum = w * vellus_far_sum(hit, row, p, last);
    var a = 0u;
    var size = last + 1u;
    while size > 1u {
        let step = size / 2u;
        a = select(a, a + step, vellus_far_sum(hit, row, p, a + step) <= target_sum);
        size -= step;
    }
    a = min(a, last - 1u);
    return side * vellus_invert(vellus_far_place(hit, row, p, a), vellus_far_place(hit, row, p, a + 1u), target_sum, w);
}

// Draws wi from four uniform numbers in [0, 1).
fn vellus_far_sample(hit: ptr<function, VellusHit>, u: vec4<f32>) -> VellusSample {
    let lobe = vellus_choose_lobe(hit, u.x);
    var drawn: vec3<f32>;
    if lobe < 3u {
        let phi = vellus_far_azimuth(hit, lobe, u.w);
        drawn = vec3<f32>(vellus_sample_longitudinal(hit, lobe, u.yz), phi);
    } else if lobe < 5u {
        let phi = vellus_far_azimuth(hit, lobe, u.w);
        drawn = vec3<f32>(vellus_draw_inclination(hit, lobe == 4u, u.y, u.z), phi);
    } else {
        drawn = vellus_sample_rest(hit, u.yzw);
    }
    let s = drawn.x;
    let c = max(drawn.y, 0.0);
    let around = vellus_sin_cos(drawn.z).yx;
    let d = VellusDirection(s, c, vellus_inside((*hit).fiber, s, c * c), drawn.z, around);
    let value = vellus_far_combine(hit, d);
    let weight = value.xyz / max(value.w, VELLUS_TINY);
    return VellusSample(vellus_toward(hit, s, c, drawn.z), value.w, weight, lobe);
}
