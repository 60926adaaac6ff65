// The model of Yan, Jensen and Ramamoorthi 2017 for one fibre hit at the offset h: the near field.
//
// Directions are unit vectors in the fibre's frame. They point away from the fibre. x runs along the fibre from root
// to tip. The normal at the hit has the azimuth of wo minus asin h. Densities are per solid angle.

// Everything that depends on wo and h.
struct VellusHit {
    fiber: u32,
    // Cosine and sine of the azimuth of wo.
    frame: vec2<f32>,
    // The centres of the longitudinal lobes R, TT, TRT and the rest lobe.
    centre_sin: vec4<f32>,
    centre_cos: vec4<f32>,
    // The exit azimuths of R, TT, TRT, and those of light scattered in the first and the second pass.
    exit: vec4<f32>,
    scattered_exit: vec2<f32>,
    // How the cuticle turns it, and light that leaves later: see turn.wgsl. 0 if the exit is open.
    turns: array<vec2<f32>, 2>,
    later: vec2<f32>,
    // The energy of each component, and its probability in w.
    attenuation: array<vec4<f32>, 7>,
    // The rest is about light scattered by the medulla. It is undefined if the path misses the medulla.
    scatters: bool,
    azimuth: array<vec4<f32>, 10>,
    azimuth_scale: f32,
    azimuth_mirror: f32,
    turned: f32,
    backward: array<vec4<f32>, 4>,
    forward: array<vec4<f32>, 8>,
    scale: vec2<f32>,
    leaving: vec2<f32>,
    theta: f32,
    inclination_mirror: f32,
    // Only in the far field: the place in its table.
    far: VellusFar,
}

// The place of an inclination in the table of the far field: see far.wgsl.
struct VellusFar {
    // The first row of the lower of two inclinations, the number of rows of each, and the fraction between them.
    row: u32,
    stride: u32,
    t: f32,
    // The number of azimuths, and those per radian.
    azimuths: u32,
    per_radian: f32,
    // 1 over the sum of the largest channels.
    inverse: f32,
}

// The energy of the six lobes R, TT, TRT, TTs, TRTs and the rest lobe.
struct VellusLobes {
    rgb: array<vec3<f32>, 6>,
}

// A sampled direction. `weight` is f cos over the density. The density is 0 if nothing was drawn.
struct VellusSample {
    wi: vec3<f32>,
    pdf: f32,
    weight: vec3<f32>,
    lobe: u32,
}

// The parts of a hit that do not depend on the offset: the frame and the centres of the longitudinal lobes.
fn vellus_begin(hit: ptr<function, VellusHit>, fiber: u32, wo: vec3<f32>, sin_o: f32, cos_o: f32) {
    (*hit).fiber = fiber;
    (*hit).frame = select(wo.yz / max(cos_o, 1e-12), vec2<f32>(1.0, 0.0), cos_o < 1e-12);
    let shift_sin = vellus_fiber(fiber, VELLUS_SHIFT);
    let shift_cos = vellus_fiber(fiber, VELLUS_SHIFT + 1u);
    (*hit).centre_sin = -(sin_o * shift_cos + cos_o * shift_sin);
    (*hit).centre_cos = abs(cos_o * shift_cos - sin_o * shift_sin);
}

// Prepares a hit, in place: compilers keep a copy of its arrays for each function that returns it. `fiber` is the index
// of a prepared fibre, `offset` is h in [-1, 1].
fn vellus_hit(hit: ptr<function, VellusHit>, fiber: u32, wo: vec3<f32>, offset: f32) {
    let cortex = vellus_fiber(fiber, VELLUS_CORTEX);
    let path = vellus_begin_path(hit, fiber, wo, offset, cortex.w);
    var exits = VellusExits();
    if (*hit).scatters && cortex.w > 0.0 {
        exits = vellus_record_exits(fiber, path);
    }
    let pigment = VellusPigment(cortex.xyz, vellus_fiber(fiber, VELLUS_MEDULLA).xyz);
    vellus_attenuation(hit, fiber, path, pigment, exits);
}

// Everything that does not depend on absorption, except for the gain of the backward half.
fn vellus_begin_path(
    hit: ptr<function, VellusHit>, fiber: u32, wo: vec3<f32>, offset: f32, gain: f32
) -> VellusPath {
    let sin_o = clamp(wo.x, -1.0, 1.0);
    let cos_o = length(wo.yz);
    let h = clamp(offset, -1.0, 1.0);
    vellus_begin(hit, fiber, wo, sin_o, cos_o);
    var path = vellus_path(fiber, sin_o, cos_o, h);
    let twice = 2.0 * path.gamma_t;
    (*hit).exit = vec4<f32>(vec3<f32>(0.0, 1.0, 2.0) * (twice + VELLUS_PI) - 2.0 * path.gamma_o, 0.0);
    let first = path.gamma_t - path.gamma_o;
    (*hit).scattered_exit = vec2<f32>(first, first + VELLUS_PI + twice);
    let optics = vellus_fiber(fiber, VELLUS_OPTICS);
    (*hit).scatters = vellus_fiber(fiber, VELLUS_MEDULLA).w > 0.0 && abs(path.h_inside) < optics.y;
    if (*hit).scatters {
        vellus_prepare_inclination(hit, fiber, path.theta, gain);
        path.mean_path = vellus_prepare_azimuth(hit, fiber, path);
        if gain > 0.0 {
            vellus_prepare_turns(hit, fiber, path, h, cos_o);
        }
    }
    return path;
}

// The share of the light that each lobe carries: the integral of f cos over all wi.
fn vellus_energy(hit: ptr<function, VellusHit>) -> VellusLobes {
    var lobes: VellusLobes;
    for (var p = 0u; p < 6u; p++) {
        lobes.rgb[p] = (*hit).attenuation[p].xyz;
    }
    lobes.rgb[5] += (*hit).attenuation[6].xyz;
    return lobes;
}

// A direction relative to wo.
struct VellusDirection {
    sin_i: f32,
    cos_i: f32,
    // The inclination inside the fibre.
    theta: f32,
    phi: f32,
    // Cosine and sine of phi.
    around: vec2<f32>,
}

// The inclination inside the fibre.
fn vellus_inside(fiber: u32, sin_i: f32, cos2: f32) -> f32 {
    let refraction = vellus_fiber(fiber, VELLUS_REFRACTION);
    return vellus_atan2(sin_i * refraction.z, sqrt(cos2 + sin_i * sin_i * refraction.w));
}

// The densities of the components over solid angle.
fn vellus_densities(hit: ptr<function, VellusHit>, d: VellusDirection) -> array<f32, 7> {
    let specular = vellus_longitudinal(hit, d.sin_i, d.cos_i) * vellus_azimuthal(hit, d.phi);
    var scattered = vec2<f32>(0.0);
    if (*hit).scatters {
        let halves = vellus_leaving(hit, d.theta, d.sin_i);
        for (var p = 0u; p < 2u; p++) {
            let inverse = vellus_turn_inverse((*hit).turns[p], d.around);
            let turned = d.phi - (*hit).scattered_exit[p] + 2.0 * vellus_atan2(inverse.y, inverse.x);
            let psi = vellus_wrap(turned);
            let m = halves.x + (halves.y - halves.x) * (abs(psi) / VELLUS_PI);
            let slope = vellus_turn_slope((*hit).turns[p], inverse);
            scattered[p] = slope * m * vellus_scattered_azimuthal(hit, psi);
        }
    }
    return array<f32, 7>(
        specular.x, specular.y, specular.z, scattered.x, scattered.y, specular.w,
        vellus_diffuse(d.cos_i) * vellus_turn_uniform((*hit).later, d.around)
    );
}

fn vellus_direction(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> VellusDirection {
    let f = (*hit).frame;
    let cos2 = dot(wi.yz, wi.yz);
    let along = vec2<f32>(wi.y * f.x + wi.z * f.y, wi.z * f.x - wi.y * f.y);
    let cos_i = sqrt(cos2);
    let theta = vellus_inside((*hit).fiber, wi.x, cos2);
    return VellusDirection(wi.x, cos_i, theta, vellus_atan2(along.y, along.x), along / max(cos_i, 1e-12));
}

// f cos in xyz, and the density of sampling in w, from the densities of the components.
fn vellus_combine(hit: ptr<function, VellusHit>, densities: array<f32, 7>) -> vec4<f32> {
    var d = densities;
    var sum = vec4<f32>(0.0);
    for (var p = 0u; p < 7u; p++) {
        sum += (*hit).attenuation[p] * d[p];
    }
    return sum;
}

// f cos of each lobe.
fn vellus_eval_lobes(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> VellusLobes {
    var d = vellus_densities(hit, vellus_direction(hit, wi));
    var lobes: VellusLobes;
    for (var p = 0u; p < 6u; p++) {
        lobes.rgb[p] = (*hit).attenuation[p].xyz * d[p];
    }
    lobes.rgb[5] += (*hit).attenuation[6].xyz * d[6];
    return lobes;
}

// f cos of all lobes in xyz, and the density with which vellus_sample draws wi in w.
fn vellus_eval(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> vec4<f32> {
    return vellus_combine(hit, vellus_densities(hit, vellus_direction(hit, wi)));
}

// The density with which vellus_sample draws wi.
fn vellus_pdf(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> f32 {
    return vellus_eval(hit, wi).w;
}

// Chooses a lobe by its probability. One without energy is never chosen.
fn vellus_choose_lobe(hit: ptr<function, VellusHit>, u: f32) -> u32 {
    var lobe = 0u;
    var rest = u;
    for (var p = 0u; p < 6u; p++) {
        let probability = (*hit).attenuation[p].w + select(0.0, (*hit).attenuation[6].w, p == 5u);
        if probability > 0.0 {
            lobe = p;
            if rest < probability {
                break;
            }
        }
        rest -= probability;
    }
    return lobe;
}

// Draws the sine and cosine of theta_i, and an azimuth, from the rest lobe.
fn vellus_sample_rest(hit: ptr<function, VellusHit>, u: vec3<f32>) -> vec3<f32> {
    let diffuse = (*hit).attenuation[6].w;
    let share = diffuse / max(diffuse + (*hit).attenuation[5].w, VELLUS_TINY);
    if u.z < share {
        let even = vellus_wrap(VELLUS_TAU * u.z / share);
        return vec3<f32>(vellus_sample_diffuse(u.xy), vellus_turn_leaving((*hit).later, even));
    }
    let phi = VELLUS_TAU * (u.z - share) / max(1.0 - share, VELLUS_TINY);
    return vec3<f32>(vellus_sample_longitudinal(hit, 3u, u.xy), phi);
}

// The direction with this sine and cosine of theta_i, at an azimuth from wo.
fn vellus_toward(hit: ptr<function, VellusHit>, s: f32, c: f32, phi: f32) -> vec3<f32> {
    let turn = vellus_sin_cos(phi);
    let f = (*hit).frame;
    return vec3<f32>(s, c * (turn.y * f.x - turn.x * f.y), c * (turn.x * f.x + turn.y * f.y));
}

// Draws wi from four uniform numbers in [0, 1).
fn vellus_sample(hit: ptr<function, VellusHit>, u: vec4<f32>) -> VellusSample {
    let lobe = vellus_choose_lobe(hit, u.x);
    var drawn: vec3<f32>;
    if lobe < 3u {
        let width = vellus_fiber((*hit).fiber, VELLUS_AZIMUTHAL + 2u)[lobe];
        let phi = (*hit).exit[lobe] + width * vellus_normal_quantile(u.w);
        drawn = vec3<f32>(vellus_sample_longitudinal(hit, lobe, u.yz), phi);
    } else if lobe < 5u {
        drawn = vellus_draw_scattered(hit, u.yzw);
        let psi = (*hit).azimuth_mirror * drawn.z + (*hit).scattered_exit[lobe - 3u];
        drawn.z = vellus_turn_leaving((*hit).turns[lobe - 3u], vellus_wrap(psi));
    } else {
        drawn = vellus_sample_rest(hit, u.yzw);
    }
    let s = drawn.x;
    let c = max(drawn.y, 0.0);
    let around = vellus_sin_cos(drawn.z).yx;
    let d = VellusDirection(s, c, vellus_inside((*hit).fiber, s, c * c), drawn.z, around);
    let value = vellus_combine(hit, vellus_densities(hit, d));
    return VellusSample(vellus_toward(hit, s, c, drawn.z), value.w, value.xyz / max(value.w, VELLUS_TINY), lobe);
}
