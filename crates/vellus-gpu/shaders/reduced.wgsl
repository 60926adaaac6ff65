// A reduced model for real time: the far field of a fibre from its parameters, without tables and records. It needs
// special.wgsl alone. Constants that are not explained are fitted to the far field of the model.

// The parameters of a round fibre in air, without air in the medulla, as those of vellus::Fiber. Angles are in radians.
struct VellusFur {
    eta: f32,
    kappa: f32,
    alpha: f32,
    beta_m: f32,
    beta_n: f32,
    layers: f32,
    sigma_ms: f32,
    g: f32,
    pigment: VellusPigment,
}

// Everything that depends on the fibre and wo.
struct VellusReduced {
    wo: vec3<f32>,
    cos_o: f32,
    eta: f32,
    layers: f32,
    // The longitudinal lobes R, TT, TRT and the rest lobe: centres, 1/v, and norms.
    centre_sin: vec4<f32>,
    centre_cos: vec4<f32>,
    inverse_v: vec4<f32>,
    norm: vec4<f32>,
    // How much of the cosine of the azimuth is left in R.
    blur: f32,
    // TT and TRT leave around the azimuths of four offsets, and around their mirror images.
    tt: VellusExitAzimuths,
    trt: VellusExitAzimuths,
    // The energies of the rest lobe and of scattered light, over the norms of their azimuths.
    rest: vec3<f32>,
    scattered: vec3<f32>,
    // The anisotropy of scattered light.
    g: f32,
    energy: vec3<f32>,
}

// Von Mises distributions around four azimuths: their cosines, sines and concentrations, and for each channel the
// energies over their norms.
struct VellusExitAzimuths {
    cosine: vec4<f32>,
    sine: vec4<f32>,
    concentration: vec4<f32>,
    light: array<vec4<f32>, 3>,
}

// The offsets stand for the ranges of asin h of a quarter of the right angle each: sines, angles, and widths.
const VELLUS_H = vec4<f32>(0.1913417, 0.5449, 0.8154934, 0.977);
const VELLUS_H_WEIGHTS = vec4<f32>(0.3826834, 0.3244234, 0.2167728, 0.0761205);
const VELLUS_H_ENDS = vec4<f32>(0.3826834, 0.7071068, 0.9238795, 1.0);
// Inclinations of diffuse light in a fibre, a quarter of the light each: cos^2, and the mean of 1/cos.
const VELLUS_COS2 = vec4<f32>(0.9903305, 0.9105704, 0.735203, 0.401868);
const VELLUS_ELONGATION = vec4<f32>(1.0065924, 1.0508239, 1.1751076, 1.8604332);

// asin x for x in [0, 1], with an error of 7e-5 (Abramowitz and Stegun 4.4.45).
fn vellus_asin4(x: vec4<f32>) -> vec4<f32> {
    let p = ((-0.0187293 * x + 0.074261) * x - 0.2121144) * x + 1.5707288;
    return vec4<f32>(0.5 * VELLUS_PI) - sqrt(max(vec4<f32>(1.0) - x, vec4<f32>(0.0))) * p;
}

fn vellus_bessel4(x: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(
        vellus_bessel_i0e(x.x), vellus_bessel_i0e(x.y), vellus_bessel_i0e(x.z), vellus_bessel_i0e(x.w)
    );
}

// Reflectances at four cosines of incidence.
fn vellus_reflected4(eta: f32, layers: f32, cosine: vec4<f32>) -> vec4<f32> {
    let refracted = vec4<f32>(1.0) - (vec4<f32>(1.0) - cosine * cosine) / (eta * eta);
    return vellus_fresnel(eta, layers, cosine, sqrt(max(refracted, vec4<f32>(0.0)))).reflected;
}

// Exit azimuths with the variance of the azimuthal lobe, for ranges of the azimuth of these widths.
fn vellus_exit_azimuths(azimuth: array<vec4<f32>, 2>, variance: f32, width: vec4<f32>) -> VellusExitAzimuths {
    let spread = 0.45 * width;
    // The mean of the cosine, and the concentration that has this mean (Banerjee et al. 2005).
    let mean = vellus_exp4(-0.5 * (vec4<f32>(variance) + spread * spread));
    let square = mean * mean;
    let concentration = mean * (2.0 - square) / max(1.0 - square, vec4<f32>(1e-6));
    var exits: VellusExitAzimuths;
    exits.cosine = azimuth[0];
    exits.sine = azimuth[1];
    exits.concentration = concentration;
    return exits;
}

// What the channels share: the paths at the four offsets, and the states of diffuse light.
struct VellusReducedPath {
    kappa: f32,
    g: f32,
    elongation: f32,
    // Half of the path in the cortex and in the medulla, in the normal plane, and the exponent of what is unscattered.
    s_c: vec4<f32>,
    s_m: vec4<f32>,
    unscattered: vec4<f32>,
    // The reflected fraction.
    f: vec4<f32>,
    // The transmittance of the cuticle, the paths through cortex and medulla, and the share that the medulla passes.
    through: vec4<f32>,
    cortex: vec4<f32>,
    chord: vec4<f32>,
    passes: vec4<f32>,
}

// The energies of one channel: of TT and TRT at the four offsets, of the rest lobe, of scattered light, and of all.
struct VellusReducedChannel {
    tt: vec4<f32>,
    trt: vec4<f32>,
    rest: f32,
    scattered: f32,
    energy: f32,
}

// The energies for an absorption of cortex and medulla.
fn vellus_reduced_channel(path: VellusReducedPath, sigma_ca: f32, sigma_ma: f32) -> VellusReducedChannel {
    let one = vec4<f32>(1.0);
    let a = sigma_ma * path.kappa;
    // The share of diffuse light that leaves in the end.
    let cortex = vellus_exp4(-sigma_ca * path.cortex);
    let kept = 1.0 / (1.0 + 1.6 * a);
    let returns = (one - path.through) * cortex * cortex;
    let lost = path.through + (one - path.through) * (one - cortex * cortex);
    let absorbed = path.passes * (one - vellus_exp4(-a * path.chord));
    let again = one - path.passes;
    let inverse = one / max(lost + returns * (again + absorbed), vec4<f32>(1e-12));
    let leaves = path.through * cortex * inverse;
    let denominator = dot(again, inverse * (lost + returns * (absorbed + again * (1.0 - kept))));
    let x = dot(again, leaves) / max(denominator, 1e-20);
    let escapes = 0.25 * dot(leaves + returns * again * inverse * (kept * x), one);
    // The lobes at the four offsets.
    let f = path.f;
    let t = one - f;
    let lengths = path.s_c * sigma_ca + path.s_m * sigma_ma;
    let crossed = vellus_exp4(-2.0 * path.elongation * lengths + path.unscattered);
    let reflected = f * crossed;
    let tt = t * t * crossed;
    let trt = tt * reflected;
    let series = reflected * reflected * t / max(t + f * (one - crossed), vec4<f32>(1e-6));
    let weakened = one + a * path.elongation * (5.37 - 0.59 * path.g - 3.61 * path.s_m / max(path.kappa, 1e-6));
    let q = one - vellus_exp4(path.unscattered);
    let escape = vellus_exp4(-path.elongation * sigma_ca * path.s_c) * (q * escapes / weakened);
    let scattered = dot(VELLUS_H_WEIGHTS, escape * (t * (one + reflected) + series));
    let rest = dot(VELLUS_H_WEIGHTS, t * crossed * series);
    return VellusReducedChannel(tt, trt, rest, scattered, dot(VELLUS_H_WEIGHTS, f + tt + trt) + rest + scattered);
}

// Prepares a hit: everything that depends on the fibre and wo, a unit vector in the frame of the fibre.
fn vellus_reduced_hit(hit: ptr<function, VellusReduced>, fur: VellusFur, wo: vec3<f32>) {
    let zero = vec4<f32>(0.0);
    let one = vec4<f32>(1.0);
    let sin_o = clamp(wo.x, -1.0, 1.0);
    let cos_o = length(wo.yz);
    (*hit).wo = wo;
    (*hit).cos_o = cos_o;
    (*hit).eta = fur.eta;
    (*hit).layers = fur.layers;
    let shift = fur.alpha * vec4<f32>(1.0, -0.5, -1.5, -1.5);
    (*hit).centre_sin = -(sin_o * cos(shift) + cos_o * sin(shift));
    (*hit).centre_cos = abs(cos_o * cos(shift) - sin_o * sin(shift));
    let width = fur.beta_m * vec4<f32>(1.0, 0.5, 1.5, 2.0);
    (*hit).inverse_v = one / (width * width);
    (*hit).norm = (*hit).inverse_v / (one - vellus_exp4(-2.0 * (*hit).inverse_v));
    (*hit).blur = exp(-0.125 * fur.beta_n * fur.beta_n);

    // The paths at the four offsets.
    let h = VELLUS_H;
    let sin_t = sin_o / fur.eta;
    let elongation = inverseSqrt(max(1.0 - sin_t * sin_t, 1e-6));
    let inverse_eta = cos_o / sqrt(max(fur.eta * fur.eta - sin_o * sin_o, 1e-6));
    let inside = min(h * inverse_eta, one);
    let cos_h = sqrt(one - h * h);
    let cos_inside = sqrt(one - inside * inside);
    let f = vellus_reflected4(fur.eta, fur.layers, cos_o * cos_h);
    let s_m = sqrt(max(fur.kappa * fur.kappa - inside * inside, zero));
    let s_c = max(cos_inside - s_m, zero);
    let unscattered = -2.0 * elongation * fur.sigma_ms * s_m;

    // The exit azimuths pi + 2 d and 2 (d + gamma_t), d = gamma_t - gamma_o, as complex numbers.
    let d = array<vec4<f32>, 2>(cos_inside * cos_h + inside * h, inside * cos_h - cos_inside * h);
    let twice = array<vec4<f32>, 2>(d[0] * d[0] - d[1] * d[1], 2.0 * d[0] * d[1]);
    let across = array<vec4<f32>, 2>(one - 2.0 * inside * inside, 2.0 * inside * cos_inside);
    let ends = vellus_asin4(min(VELLUS_H_ENDS * inverse_eta, one));
    let steps = ends - vec4<f32>(0.0, ends.xyz);
    let variance = fur.beta_n * fur.beta_n;
    let range = vec4<f32>(0.25 * VELLUS_PI);
    (*hit).tt = vellus_exit_azimuths(
        array<vec4<f32>, 2>(-twice[0], -twice[1]), 2.0 * variance, 2.0 * steps - range
    );
    let last = array<vec4<f32>, 2>(
        twice[0] * across[0] - twice[1] * across[1], twice[0] * across[1] + twice[1] * across[0]
    );
    (*hit).trt = vellus_exit_azimuths(last, 3.0 * variance, 4.0 * steps - range);
    // Two mirror images share the light.
    let norm_tt = VELLUS_H_WEIGHTS / (2.0 * VELLUS_TAU * vellus_bessel4((*hit).tt.concentration));
    let norm_trt = VELLUS_H_WEIGHTS / (2.0 * VELLUS_TAU * vellus_bessel4((*hit).trt.concentration));

    // Diffuse light in the fibre: the transmittance of the cuticle, the path through the cortex, and the share that
    // the medulla scatters again. These are the states of vellus::exit, with means over the offset.
    let kappa2 = fur.kappa * fur.kappa;
    var through = zero;
    for (var k = 0u; k < 3u; k++) {
        let offset2 = vec3<f32>(0.04, 0.3, 0.75)[k];
        let outside2 = one - fur.eta * fur.eta * (one - VELLUS_COS2 * (1.0 - kappa2 * offset2));
        let reflected = vellus_reflected4(fur.eta, fur.layers, sqrt(max(outside2, zero)));
        // Beyond the critical angle all light is reflected.
        through += step(vec4<f32>(1e-9), outside2) * (one - reflected) * (1.0 / 3.0);
    }
    let half_chord = 0.25 * VELLUS_PI;
    let cortex_path = max(sqrt(1.0 - kappa2 / 3.0) - fur.kappa * half_chord, 0.0) * VELLUS_ELONGATION;
    let chord = 2.0 * half_chord * VELLUS_ELONGATION;
    let tau = fur.sigma_ms * fur.kappa;
    let passes = vellus_exp4(-tau * pow(1.0 - fur.g, 0.7) * chord);

    let path = VellusReducedPath(
        fur.kappa, fur.g, elongation, s_c, s_m, unscattered, f, through, cortex_path, chord, passes
    );
    // Without a loop, so that nothing is indexed.
    let red = vellus_reduced_channel(path, fur.pigment.cortex.x, fur.pigment.medulla.x);
    let green = vellus_reduced_channel(path, fur.pigment.cortex.y, fur.pigment.medulla.y);
    let blue = vellus_reduced_channel(path, fur.pigment.cortex.z, fur.pigment.medulla.z);
    (*hit).tt.light = array<vec4<f32>, 3>(red.tt * norm_tt, green.tt * norm_tt, blue.tt * norm_tt);
    (*hit).trt.light = array<vec4<f32>, 3>(red.trt * norm_trt, green.trt * norm_trt, blue.trt * norm_trt);
    (*hit).rest = vec3<f32>(red.rest, green.rest, blue.rest) / VELLUS_TAU;
    (*hit).scattered = vec3<f32>(red.scattered, green.scattered, blue.scattered);
    (*hit).energy = vec3<f32>(red.energy, green.energy, blue.energy);

    // Scattered light: the phase function of Henyey and Greenstein around -wo, times the cosine of theta_i. Its
    // integral is a series of Legendre polynomials.
    let isotropic = tau * (1.0 - fur.g);
    let g = 0.68 * fur.g * exp(-1.3 * isotropic) - 0.55 * isotropic / (isotropic + 15.0);
    let square = sin_o * sin_o;
    let second = 1.5 * square - 0.5;
    let fourth = (4.375 * square - 3.75) * square + 0.375;
    let integral = VELLUS_PI * (0.25 - g * g * (5.0 / 32.0 * second + g * g * (9.0 / 256.0) * fourth));
    (*hit).g = g;
    (*hit).scattered *= (1.0 - g * g) / (2.0 * VELLUS_TAU * integral);
}

// The share of the light that the fibre scatters: the integral of f cos over all wi.
fn vellus_reduced_energy(hit: ptr<function, VellusReduced>) -> vec3<f32> {
    return (*hit).energy;
}

// The densities of four exits and of their mirror images over the azimuth, times the energies.
fn vellus_reduced_azimuth(exits: VellusExitAzimuths, around: vec2<f32>) -> vec3<f32> {
    let cosine = around.x * exits.cosine - vec4<f32>(1.0);
    let sine = around.y * exits.sine;
    let density = vellus_exp4((cosine + sine) * exits.concentration)
        + vellus_exp4((cosine - sine) * exits.concentration);
    return vec3<f32>(dot(exits.light[0], density), dot(exits.light[1], density), dot(exits.light[2], density));
}

// f cos of all lobes, in the far field.
fn vellus_reduced_eval(hit: ptr<function, VellusReduced>, wi: vec3<f32>) -> vec3<f32> {
    let cos_i = length(wi.yz);
    let ds = vec4<f32>(wi.x) - (*hit).centre_sin;
    let dc = vec4<f32>(cos_i) - (*hit).centre_cos;
    let bessel = vellus_bessel4(cos_i * (*hit).centre_cos * (*hit).inverse_v);
    let m = vellus_exp4(-0.5 * (ds * ds + dc * dc) * (*hit).inverse_v) * bessel * (*hit).norm;
    let wo = (*hit).wo;
    let both = max(cos_i * (*hit).cos_o, 1e-12);
    let around = vec2<f32>(dot(wi.yz, wo.yz), wi.z * wo.y - wi.y * wo.z) / both;
    // R of a smooth circle: its density over the azimuth is cos(phi/2)/4.
    let half = sqrt(max(0.5 + 0.5 * (*hit).blur * around.x, 0.0));
    let reflected = vellus_reflected4((*hit).eta, (*hit).layers, vec4<f32>((*hit).cos_o * half)).x;
    let turned = 1.0 + (*hit).g * ((*hit).g + 2.0 * dot(wo, wi));
    return vec3<f32>(0.25 * half * reflected * m.x)
        + vellus_reduced_azimuth((*hit).tt, around) * m.y
        + vellus_reduced_azimuth((*hit).trt, around) * m.z
        + (*hit).rest * m.w
        + (*hit).scattered * (cos_i * inverseSqrt(turned) / turned);
}
