//! Monte Carlo simulation of the medulla: an infinite, purely scattering cylinder of radius 1 with the
//! Henyey–Greenstein phase function (Yan17 Sec. 3, Fig. 4).
//!
//! Every photon is forced to scatter at least once, so the profiles are *conditional* densities (D5). The limit of
//! vanishing optical radius, which is single scattering, needs no special case: the first collision is then uniform on
//! the chord.
//!
//! Frame: the axis is x. Light travels along azimuth π, so an exit azimuth of 0 is backward and π is straight through.
//! A ray of offset `h` enters at azimuth −asin h.

use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f32::consts::TAU;

/// The random generator of all simulations. It is small, fast and gives the same numbers on every platform.
pub type SimRng = Xoshiro256PlusPlus;

/// The random generator for a seed and a stream. One stream per batch makes results independent of threads.
pub fn stream(seed: u64, stream: u64) -> SimRng {
    // Two rounds of SplitMix (in `seed_from_u64`) decorrelate neighbouring stream numbers.
    SimRng::seed_from_u64(SimRng::seed_from_u64(seed).next_u64() ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Two uniform numbers in [0, 1) from one 64-bit draw.
pub(crate) fn uniform2(rng: &mut SimRng) -> (f32, f32) {
    const SCALE: f32 = 1.0 / (1 << 24) as f32;
    let bits = rng.next_u64();
    ((bits >> 40) as f32 * SCALE, ((bits >> 8) as u32 & 0xff_ffff) as f32 * SCALE)
}

/// A direction, or a position whose first component is unused.
pub(crate) type Vec3 = [f32; 3];

/// Scatters direction `d` by the Henyey–Greenstein phase function with anisotropy `g`.
pub(crate) fn scatter(d: Vec3, g: f32, rng: &mut SimRng) -> Vec3 {
    let (xi, psi) = uniform2(rng);
    let cos = if g.abs() < 1e-3 {
        // The closed form divides by g; its first-order series is exact to 1e-6 here.
        let u = 2.0 * xi - 1.0;
        u - 1.5 * g * (u * u - 1.0)
    } else {
        let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * xi);
        ((1.0 + g * g - s * s) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (sp, cp) = (psi * TAU).sin_cos();
    // Orthonormal basis around d (Duff et al. 2017, Building an Orthonormal Basis, Revisited).
    let [x, y, z] = d;
    let sign = 1.0f32.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    let (u, v) = (sin * cp, sin * sp);
    let r = [
        u * (1.0 + sign * x * x * a) + v * b + cos * x,
        u * sign * b + v * (sign + y * y * a) + cos * y,
        -u * sign * x - v * y + cos * z,
    ];
    let n = 1.0 / (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]).sqrt();
    [r[0] * n, r[1] * n, r[2] * n]
}

/// Distance along `d` from `p` inside the infinite unit cylinder to its surface.
fn exit_distance(p: Vec3, d: Vec3) -> f32 {
    let a = (d[1] * d[1] + d[2] * d[2]).max(1e-20);
    let b = p[1] * d[1] + p[2] * d[2];
    let c = (p[1] * p[1] + p[2] * p[2] - 1.0).min(0.0);
    (-b + (b * b - a * c).sqrt()) / a
}

/// Light that leaves the medulla: its direction, the last point where it was scattered, and the length of its path
/// inside, in radii.
pub(crate) struct Exit {
    pub direction: Vec3,
    pub from: Vec3,
    pub path: f32,
}

impl Exit {
    /// h″, the distance of the ray from the axis in the normal plane, in [0, 1].
    pub fn offset(&self) -> f32 {
        self.signed_offset().abs() as f32
    }

    /// The offset with its sign, in [−1, 1]: that of the ray that enters, if the light goes straight on.
    pub fn signed_offset(&self) -> f64 {
        let ([_, py, pz], [_, dy, dz]) = (self.from, self.direction);
        f64::from((pz * dy - py * dz) / dy.hypot(dz).max(1e-20)).clamp(-1.0, 1.0)
    }
}

/// Traces one photon that is forced to scatter.
///
/// `tau` is the optical radius, `h` the offset, and the pair is the sine and cosine of the inclination. Returns the
/// exit and the weight of the forced collision: the collision probability of the chord, per unit `tau`.
pub(crate) fn trace(tau: f32, g: f32, h: f32, (sin, cos): (f32, f32), rng: &mut SimRng) -> (Exit, f32) {
    let half = (1.0 - h * h).max(0.0).sqrt();
    let chord = 2.0 * half / cos;
    let mut d = [-sin, -cos, 0.0];
    let (xi, _) = uniform2(rng);
    let x = tau * chord;
    // Below 1e-4, the collision density along the chord is constant to a relative 1e-4.
    let (first, weight) = if x < 1e-4 {
        (xi * chord, chord)
    } else {
        let absorbed = -(-x).exp_m1();
        (-(-xi * absorbed).ln_1p() / tau, absorbed / tau)
    };
    let mut p = [0.0, half - first * cos, -h];
    let mut path = first;
    d = scatter(d, g, rng);
    loop {
        let out = exit_distance(p, d);
        let (xi, _) = uniform2(rng);
        let free = -(1.0 - xi).ln();
        // The comparison of optical depths also works for tau = 0.
        if free >= tau * out {
            path += out;
            return (Exit { direction: d, from: p, path }, weight);
        }
        let s = free / tau;
        p = [0.0, p[1] + s * d[1], p[2] + s * d[2]];
        path += s;
        d = scatter(d, g, rng);
    }
}

/// The azimuthal profile for one (τ, g, h): density over the exit azimuth, and mean path.
#[derive(Clone, Debug, PartialEq)]
pub struct AzimuthalProfile {
    /// Density per radian at φ = 2π j/n: means over bins with these centres.
    pub density: Vec<f64>,
    /// Mean path ⟨L⟩ of scattered light inside the medulla, from entry to exit, in radii.
    pub mean_path: f64,
}

/// Simulates C^N, with `photons` rays in the normal plane and a histogram of `bins` bins.
///
/// `tau` is the optical radius σ_m,s κ of the medulla, `g` the anisotropy in (−1, 1), `h` the offset in [−1, 1].
pub fn azimuthal(tau: f64, g: f64, h: f64, photons: u64, bins: usize, rng: &mut SimRng) -> AzimuthalProfile {
    let mut counts = vec![0u64; bins];
    let mut path = 0.0;
    for _ in 0..photons {
        let (exit, _) = trace(tau as f32, g as f32, h as f32, (0.0, 1.0), rng);
        let phi = exit.direction[2].atan2(exit.direction[1]);
        let j = (phi / TAU * bins as f32).round() as i64;
        counts[j.rem_euclid(bins as i64) as usize] += 1;
        path += f64::from(exit.path);
    }
    let scale = bins as f64 / (std::f64::consts::TAU * photons as f64);
    AzimuthalProfile { density: counts.iter().map(|&c| c as f64 * scale).collect(), mean_path: path / photons as f64 }
}

/// The longitudinal profile for one (τ, g, θ): densities in sin θᵢ of the backward half (|φ| < π/2) and the forward
/// half, each with integral 1.
#[derive(Clone, Debug, PartialEq)]
pub struct LongitudinalProfile {
    /// Backward and forward densities at θ = −90° + 180° j/(n−1): means over bins with these centres.
    pub density: [Vec<f64>; 2],
    /// Fraction of the scattered light in the backward and the forward half.
    pub fraction: [f64; 2],
}

/// sin θ at the borders of the bins with centres θ = −90° + 180° j/(n−1): n + 1 values.
pub fn longitudinal_borders(nodes: usize) -> Vec<f64> {
    let step = std::f64::consts::PI / (nodes - 1) as f64;
    let quarter = std::f64::consts::FRAC_PI_2;
    (0..=nodes).map(|j| ((j as f64 - 0.5) * step - quarter).clamp(-quarter, quarter).sin()).collect()
}

/// Simulates C^M, with `photons` rays at inclination `theta` ≥ 0 (radians) over all offsets, and `nodes` bins for each
/// half.
pub fn longitudinal(tau: f64, g: f64, theta: f64, photons: u64, nodes: usize, rng: &mut SimRng) -> LongitudinalProfile {
    let mut weights = [vec![0.0f64; nodes], vec![0.0f64; nodes]];
    let inclination = (theta.sin() as f32, theta.cos() as f32);
    for k in 0..photons {
        // Offsets are stratified. By symmetry, one side of the fibre is enough.
        let h = ((k as f64 + f64::from(uniform2(rng).0)) / photons as f64) as f32;
        let (exit, weight) = trace(tau as f32, g as f32, h, inclination, rng);
        let half = usize::from(exit.direction[1] < 0.0);
        let theta_i = exit.direction[0].clamp(-1.0, 1.0).asin();
        let j = ((theta_i / std::f32::consts::PI + 0.5) * (nodes - 1) as f32).round() as usize;
        weights[half][j.min(nodes - 1)] += f64::from(weight);
    }
    let borders = longitudinal_borders(nodes);
    let sums: [f64; 2] = [0, 1].map(|half| weights[half].iter().sum());
    let density = [0, 1].map(|half| {
        weights[half]
            .iter()
            .zip(borders.windows(2))
            .map(|(w, b)| w / (sums[half].max(f64::MIN_POSITIVE) * (b[1] - b[0])))
            .collect()
    });
    LongitudinalProfile { density, fraction: sums.map(|s| s / (sums[0] + sums[1])) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a purely scattering body under isotropic light, the mean path is the mean chord 4V/S, whatever the scattering
    /// is (Blanco and Fournier 2003). For the unit cylinder this is 2.
    #[test]
    fn mean_path_under_isotropic_light_is_the_mean_chord() {
        for (tau, g) in [(0.3, 0.0), (2.0, 0.7), (8.0, 0.9)] {
            let mut rng = stream(5, 2);
            let n = 200_000;
            let (mut sum, mut square) = (0.0, 0.0);
            for k in 0..n {
                // Offsets are uniform. Inclinations have density cos², by rejection sampling.
                let h = 2.0 * (k as f32 + 0.5) / n as f32 - 1.0;
                let theta = loop {
                    let (a, b) = uniform2(&mut rng);
                    let theta = (a - 0.5) * std::f32::consts::PI;
                    if b < theta.cos().powi(2) {
                        break theta;
                    }
                };
                let chord = 2.0 * (1.0 - h * h).sqrt() / theta.cos();
                let (exit, _) = trace(tau, g, h, theta.sin_cos(), &mut rng);
                let unscattered = (-tau * chord).exp();
                let path = f64::from(unscattered * chord + (1.0 - unscattered) * exit.path);
                sum += path;
                square += path * path;
            }
            let mean = sum / f64::from(n);
            let error = ((square / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
            assert!((mean - 2.0).abs() < 4.0 * error, "τ {tau} g {g}: {mean} ± {error}");
        }
    }
}
