// The path of light that entered the fibre at the offset h, and the energy of each component (Yan17 Table 3).

// The geometry of the path. Lengths are in fibre radii.
struct VellusPath {
    h_inside: f32,
    // The angles of the offset, of the refracted path, and of its offset in the medulla.
    gamma_o: f32,
    gamma_t: f32,
    gamma_m: f32,
    // The inclination at which the tables are read.
    theta: f32,
    // Half of the path in the cortex and half of the path in the medulla, in the normal plane.
    s_c: f32,
    s_m: f32,
    // 1/cos of theta_t.
    elongation: f32,
    // The reflected and the transmitted fraction.
    fresnel: vec2<f32>,
    sin2_t: f32,
    // The mean path of scattered light in the medulla.
    mean_path: f32,
}

// How scattered light leaves a fibre whose cuticle reflects it, RGB: the share that leaves without absorption in the
// medulla on the first path, the logarithm of what that absorption leaves, and the part of it that leaves when it first
// meets the cuticle.
struct VellusExits {
    escape: vec3<f32>,
    kept: vec3<f32>,
    first: vec3<f32>,
}

fn vellus_path(fiber: u32, sin_o: f32, cos_o: f32, h: f32) -> VellusPath {
    let optics = vellus_fiber(fiber, VELLUS_OPTICS);
    let eta = optics.x;
    let kappa = optics.y;
    let sin_t = sin_o / eta;
    let cos2 = cos_o * cos_o;
    let cos2_gamma_o = max((1.0 - h) * (1.0 + h), 0.0);
    let cos_gamma_o = sqrt(cos2_gamma_o);
    let cos_t = sqrt(max((1.0 - sin_t) * (1.0 + sin_t), 1e-12));
    let cos_refracted = sqrt(max(1.0 - (1.0 - cos2 * cos2_gamma_o) / (eta * eta), 0.0));
    let fresnel = vellus_fresnel(eta, optics.w, vec4<f32>(cos_o * cos_gamma_o), vec4<f32>(cos_refracted));
    // 1/eta' without cancellation for eta near 1 and for grazing light.
    let h_inside = h * (cos_o / sqrt(max((eta - 1.0) * (eta + 1.0) + cos2, 1e-20)));
    let offset = abs(h_inside);
    let cos_gamma_t = sqrt(max((1.0 - h_inside) * (1.0 + h_inside), 0.0));
    let s_m = sqrt(max((kappa - offset) * (kappa + offset), 0.0));
    let reflects = vellus_fiber(fiber, VELLUS_CORTEX).w > 0.0;
    var path: VellusPath;
    path.h_inside = h_inside;
    path.gamma_o = vellus_atan2(h, cos_gamma_o);
    path.gamma_t = vellus_atan2(h_inside, cos_gamma_t);
    path.gamma_m = vellus_atan2(h_inside, s_m);
    path.theta = vellus_atan2(select(sin_o, sin_t, reflects), select(cos_o, cos_t, reflects));
    path.s_c = max(cos_gamma_t - s_m, 0.0);
    path.s_m = s_m;
    path.elongation = 1.0 / cos_t;
    path.fresnel = vec2<f32>(fresnel.reflected.x, fresnel.transmitted.x);
    path.sin2_t = sin_t * sin_t;
    return path;
}

// A polynomial of the entry: `c` is the chord, `y` the squared sine of theta_t relative to its largest value.
fn vellus_entry(fiber: u32, part: u32, c: f32, y: f32) -> vec4<f32> {
    let constant = (vellus_fiber(fiber, part + 5u) * y + vellus_fiber(fiber, part + 2u)) * y
        + vellus_fiber(fiber, part);
    let linear = (vellus_fiber(fiber, part + 7u) * y + vellus_fiber(fiber, part + 4u)) * y
        + vellus_fiber(fiber, part + 1u);
    let square = vellus_fiber(fiber, part + 6u) * y + vellus_fiber(fiber, part + 3u);
    return (square * c + linear) * c + constant;
}

// The exits of a prepared fibre.
fn vellus_record_exits(fiber: u32, path: VellusPath) -> VellusExits {
    let chord = path.s_m / max(vellus_fiber(fiber, VELLUS_OPTICS).y, VELLUS_TINY);
    let y = path.sin2_t / VELLUS_MOST_SIN2;
    return VellusExits(
        vellus_entry(fiber, VELLUS_ESCAPE, chord, y).xyz,
        vellus_entry(fiber, VELLUS_KEPT, chord, y).xyz,
        vellus_entry(fiber, VELLUS_FIRST, chord, y).xyz
    );
}

// The energy of each component in xyz, and the probability with which sampling chooses it in w. The components are the
// six lobes and the diffuse part of the rest lobe.
fn vellus_attenuation(
    hit: ptr<function, VellusHit>, fiber: u32, path: VellusPath, pigment: VellusPigment, exits: VellusExits
) {
    let optics = vellus_fiber(fiber, VELLUS_OPTICS);
    let kappa = optics.y;
    let reflects = vellus_fiber(fiber, VELLUS_CORTEX).w > 0.0;
    let sigma_ca = pigment.cortex;
    let sigma_ma = pigment.medulla;
    let length_m = -2.0 * path.elongation * path.s_m;
    let unscattered = length_m * optics.z;
    let crossed = vellus_exp4(vec4<f32>(
        -2.0 * path.elongation * path.s_c * sigma_ca + length_m * sigma_ma + unscattered, unscattered
    ));
    var escape: vec3<f32>;
    if reflects {
        let kept = min(exits.kept, vec3<f32>(0.0));
        escape = clamp(exits.escape, vec3<f32>(0.0), vec3<f32>(1.0));
        escape *= vellus_exp4(vec4<f32>(-path.elongation * path.s_c * sigma_ca + kept, 0.0)).xyz;
    } else {
        let through = -path.elongation * ((path.s_c + 1.0 - kappa) * sigma_ca + kappa * path.mean_path * sigma_ma);
        escape = vellus_exp4(vec4<f32>(through, 0.0)).xyz;
    }
    // The scattered fraction of one pass, without cancellation near 0.
    let small = -unscattered * (1.0 + unscattered * (0.5 + unscattered * (1.0 / 6.0)));
    let q = select(1.0 - crossed.w, small, -unscattered < 0.02);
    let f = path.fresnel.x;
    let t = path.fresnel.y;
    let again = f * crossed.xyz;
    let a_tt = t * t * crossed.xyz;
    // All higher orders are a geometric series, whose denominator does not cancel.
    let denominator = max(t + f * (vec3<f32>(1.0) - crossed.xyz), vec3<f32>(1e-20));
    let series = again * again * (t / denominator);
    var scattered = t * escape * q;
    var rest: vec3<f32>;
    var diffuse = vec3<f32>(0.0);
    if reflects {
        // The light that leaves at its first encounter with the cuticle. No channel has more of it than the channel
        // with the most light.
        let share = clamp(exits.first, vec3<f32>(0.0), vec3<f32>(1.0));
        let most = max(escape.x, max(escape.y, escape.z));
        let squares = escape * escape;
        let limit = most * dot(share, squares) / max(squares.x + squares.y + squares.z, VELLUS_TINY);
        let first = min(max(escape * share, escape - (most - limit)), vec3<f32>(limit));
        let late = t * q * max(escape - first, vec3<f32>(0.0));
        scattered = t * q * first;
        rest = t * crossed.xyz * series;
        diffuse = late + late * again + escape * q * series;
    } else {
        rest = (t * crossed.xyz + escape * q) * series;
    }
    var energy = array<vec3<f32>, 7>(
        vec3<f32>(f), a_tt, a_tt * again, scattered, scattered * again, rest, diffuse
    );
    var sum = VELLUS_TINY;
    for (var p = 0u; p < 7u; p++) {
        let most = max(energy[p].x, max(energy[p].y, energy[p].z));
        (*hit).attenuation[p] = vec4<f32>(energy[p], most);
        sum += most;
    }
    for (var p = 0u; p < 7u; p++) {
        (*hit).attenuation[p].w /= sum;
    }
}
