// What all parts share: absorption, the cuticle, and special functions. The precision of WGSL's own inverse tangent,
// sine and logarithm is not enough for narrow lobes.

const VELLUS_PI = 3.14159265358979;
const VELLUS_TAU = 6.28318530717959;
const VELLUS_TINY = 1.17549435e-38;

// Absorption of the cortex and of the medulla, RGB, per fibre radius, in [0, 1000].
struct VellusPigment {
    cortex: vec3<f32>,
    medulla: vec3<f32>,
}

// The reflected and the transmitted fraction at four cosines of incidence.
struct VellusFresnel {
    reflected: vec4<f32>,
    transmitted: vec4<f32>,
}

// The cuticle (Yan17 Eq. 4), from the cosines outside and inside.
fn vellus_fresnel(eta: f32, layers: f32, outside: vec4<f32>, inside: vec4<f32>) -> VellusFresnel {
    let b = eta * inside;
    let c = eta * outside;
    let s = outside * outside + b * b;
    let p = c * c + inside * inside;
    let reflected = (outside - b) * (outside - b) * p + (c - inside) * (c - inside) * s;
    // Two numbers with the ratio F : (1 - F), without divisions.
    let back = 0.5 * layers * reflected;
    let through = max(outside * b * p + c * inside * s, vec4<f32>(1e-30));
    return VellusFresnel(back / (back + through), through / (back + through));
}

// e^x for x <= 88. Arguments below -64 count as -64, so that products of tails are not subnormal.
fn vellus_exp(x: f32) -> f32 {
    return exp(max(x, -64.0));
}

fn vellus_exp4(x: vec4<f32>) -> vec4<f32> {
    return exp(max(x, vec4<f32>(-64.0)));
}

// The natural logarithm of x > 0, with a relative error of a few roundings also near 1.
fn vellus_log(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    // The mantissa in [sqrt(1/2), sqrt(2)), and the exponent.
    let shifted = bits + (0x3f800000u - 0x3f3504f3u);
    let exponent = f32(i32(shifted >> 23u) - 127);
    let mantissa = bitcast<f32>((shifted & 0x007fffffu) + 0x3f3504f3u);
    // 2 artanh(s). The next term of the series is 2 s^11/11, below 7e-10.
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let z = s * s;
    let series = s * (2.0 + z * (0.666666667 + z * (0.4 + z * (0.285714286 + z * 0.222222222))));
    return fma(exponent, 0.693147181, series);
}

// atan2(y, x) in (-pi, pi], with an absolute error of 3e-7. 0 for (0, 0). The polynomial is that of Cephes' atanf
// (Moshier), up to tan(pi/8).
fn vellus_atan2(y: f32, x: f32) -> f32 {
    let high = max(abs(x), abs(y));
    let low = min(abs(x), abs(y));
    let far = high * 0.41421357 < low;
    let numerator = select(low, low - high, far);
    let denominator = max(select(high, low + high, far), VELLUS_TINY);
    let t = numerator / denominator;
    let z = t * t;
    let p = ((8.0537445e-2 * z - 1.3877686e-1) * z + 1.997771e-1) * z - 3.333295e-1;
    var angle = fma(p * z, t, t) + select(0.0, 0.25 * VELLUS_PI, far);
    angle = select(angle, 0.5 * VELLUS_PI - angle, abs(x) < abs(y));
    angle = select(angle, VELLUS_PI - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}

// Wraps an angle of a few turns to [-pi, pi]. The first part of 2 pi has few digits, so that its multiples are exact.
fn vellus_wrap(x: f32) -> f32 {
    let turns = round(x * (1.0 / VELLUS_TAU));
    return clamp(fma(turns, -1.9353072e-3, fma(turns, -6.28125, x)), -VELLUS_PI, VELLUS_PI);
}

// (sin x, cos x) for an angle of a few turns, with an absolute error of 2e-7 for |x| <= pi.
fn vellus_sin_cos(x: f32) -> vec2<f32> {
    let quarter = round(x * (2.0 / VELLUS_PI));
    // pi/2 in two parts, as above.
    let r = fma(quarter, -4.8382681e-4, fma(quarter, -1.5703125, x));
    let z = r * r;
    let odd = ((2.6089325e-6 * z - 1.9811113e-4) * z + 8.333088e-3) * z - 1.666666e-1;
    let even = ((-2.6193814e-7 * z + 2.4769304e-5) * z - 1.3888569e-3) * z + 4.1666656e-2;
    let s = fma(odd * z, r, r);
    let c = fma(even * z, z, fma(z, -0.5, 1.0));
    let n = i32(quarter) & 3;
    let swapped = select(vec2<f32>(s, c), vec2<f32>(c, s), (n & 1) == 1);
    return vec2<f32>(select(swapped.x, -swapped.x, (n & 2) != 0), select(swapped.y, -swapped.y, n == 1 || n == 2));
}

// exp(-x) I0(x) for x >= 0, with a relative error of 1.2e-6.
fn vellus_bessel_i0e(x: f32) -> f32 {
    if x < 5.0 {
        let z = x * x;
        let low = ((6.7745964e-6 * z + 4.3406636e-4) * z + 0.015624912) * z + 0.25;
        let high = (3.40594e-12 * z + 4.3296086e-10) * z + 6.852862e-8;
        return vellus_exp(-x) * (1.0 + z * (low + high * z * z * z * z));
    }
    let t = 1.0 / x;
    var p = -1.9657496 * t + 1.5853693;
    p = p * t - 0.2659415;
    p = p * t + 0.05705673;
    p = p * t + 0.02696209;
    p = p * t + 0.04988296;
    p = p * t + 0.39894223;
    return p * sqrt(t);
}

// The standard normal quantile, with an absolute error of 3e-6 up to 5. The polynomials are those of Giles 2010,
// Approximating the erfinv function, GPU Computing Gems.
fn vellus_normal_quantile(uniform_number: f32) -> f32 {
    let u = clamp(uniform_number, 6e-8, 1.0 - 6e-8);
    let w = -vellus_log(4.0 * u * (1.0 - u));
    var p: f32;
    if w < 5.0 {
        let t = w - 2.5;
        p = 2.8102264e-8 * t + 3.4327394e-7;
        p = p * t - 3.5233877e-6;
        p = p * t - 4.3915065e-6;
        p = p * t + 2.1858087e-4;
        p = p * t - 1.253725e-3;
        p = p * t - 4.1776816e-3;
        p = p * t + 2.4664073e-1;
        p = p * t + 1.5014094;
    } else {
        let t = sqrt(w) - 3.0;
        p = -2.0021426e-4 * t + 1.0095056e-4;
        p = p * t + 1.3493432e-3;
        p = p * t - 3.6734285e-3;
        p = p * t + 5.7395077e-3;
        p = p * t - 7.6224613e-3;
        p = p * t + 9.4388705e-3;
        p = p * t + 1.001674;
        p = p * t + 2.8329768;
    }
    return 1.41421356 * p * (2.0 * u - 1.0);
}
