//! What geometric optics leaves out: the exact wave solution for a smooth dielectric cylinder, at normal incidence and
//! without polarisation, beside rays. `cargo run --release --bin diffraction`.
//!
//! It prints the scattering efficiency, the full width at half maximum of the forward peak, and the L1 difference of
//! the light beyond 10°, in bins of 10°.

use libm::{jn, yn};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::{Add, Mul};

const ETA: f64 = 1.55;

/// Diameters in micrometres.
const DIAMETERS: [f64; 4] = [10.0, 15.0, 20.0, 80.0];

/// Wavelengths between 0.5 and 0.6 µm. Their mean has no resonances of a single wavelength.
const WAVELENGTHS: usize = 101;

/// Scattering angles between 0° and 180°. The narrowest peak is 0.35° wide.
const ANGLES: usize = 18_000;

/// Width of a bin in degrees. The first one holds the forward peak.
const BIN: f64 = 10.0;

#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Add for Complex {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Complex(self.0 + other.0, self.1 + other.1)
    }
}

impl Mul<f64> for Complex {
    type Output = Self;
    fn mul(self, x: f64) -> Self {
        Complex(self.0 * x, self.1 * x)
    }
}

impl Complex {
    fn square(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
}

/// The coefficients of the scattered wave for the size x = 2πa/λ: the electric field along the fibre, then across it
/// (Bohren and Huffman 1983, Absorption and Scattering of Light by Small Particles, Eq. 8.30 and 8.32).
fn coefficients(x: f64) -> [Vec<Complex>; 2] {
    // Orders beyond x decay faster than exponentially. This is the usual criterion of Wiscombe, with some more.
    let count = (x + 4.05 * x.cbrt() + 10.0) as i32;
    let derivative = |f: fn(i32, f64) -> f64, n: i32, x: f64| 0.5 * (f(n - 1, x) - f(n + 1, x));
    let ratio = |n: i32, inside: [f64; 2]| {
        let [a, b] = inside;
        let real = a * derivative(jn, n, x) - b * jn(n, x);
        let imaginary = a * derivative(yn, n, x) - b * yn(n, x);
        // real / (real + i imaginary)
        let norm = real * real + imaginary * imaginary;
        Complex(real * real / norm, -real * imaginary / norm)
    };
    let of = |factors: [f64; 2]| {
        let inside = |n: i32| [factors[0] * jn(n, ETA * x), factors[1] * derivative(jn, n, ETA * x)];
        (0..=count).map(|n| ratio(n, inside(n))).collect()
    };
    [of([1.0, ETA]), of([ETA, 1.0])]
}

/// The amplitude T at a scattering angle in radians (Eq. 8.35 and 8.36).
fn amplitude(coefficients: &[Complex], angle: f64) -> Complex {
    let rest = coefficients[1..].iter().enumerate();
    let terms = rest.map(|(i, &b)| b * (2.0 * (angle * (i + 1) as f64).cos()));
    terms.fold(coefficients[0], Complex::add)
}

/// Efficiencies of scattering and of extinction: light per width of the fibre. Without absorption they are the same.
fn efficiencies(x: f64, coefficients: &[Complex]) -> [f64; 2] {
    let rest = &coefficients[1..];
    let squares = coefficients[0].square() + 2.0 * rest.iter().map(|b| b.square()).sum::<f64>();
    [2.0 / x * squares, 2.0 / x * amplitude(coefficients, 0.0).0]
}

/// Light per radian of the scattering angle, per width of the fibre, on both sides together. The mean of both
/// polarisations, at the midpoints of `ANGLES` intervals.
fn wave(x: f64) -> Vec<f64> {
    let both = coefficients(x);
    let at = |i: usize| {
        let angle = (i as f64 + 0.5) / ANGLES as f64 * PI;
        both.iter().map(|c| amplitude(c, angle).square()).sum::<f64>() / (PI * x)
    };
    (0..ANGLES).map(at).collect()
}

/// The light of rays in bins of the scattering angle, by paths of up to 12 crossings, per width of the fibre.
fn rays() -> Vec<f64> {
    const OFFSETS: usize = 1_000_000;
    let mut bins = vec![0.0; (180.0 / BIN) as usize];
    for i in 0..OFFSETS {
        let h = (i as f64 + 0.5) / OFFSETS as f64;
        let (cos_i, cos_t) = ((1.0 - h * h).sqrt(), (1.0 - (h / ETA).powi(2)).sqrt());
        let (gamma_i, gamma_t) = (h.asin(), (h / ETA).asin());
        let along = ((cos_i - ETA * cos_t) / (cos_i + ETA * cos_t)).powi(2);
        let across = ((ETA * cos_i - cos_t) / (ETA * cos_i + cos_t)).powi(2);
        for reflectance in [along, across] {
            for p in 0..12 {
                let share = match p {
                    0 => reflectance,
                    _ => (1.0 - reflectance).powi(2) * reflectance.powi(p - 1),
                };
                let p = f64::from(p);
                // Zero for light that goes straight on.
                let turn = 2.0 * (gamma_i - p * gamma_t) + (p - 1.0) * PI;
                let angle = turn.cos().clamp(-1.0, 1.0).acos().to_degrees();
                let last = bins.len() - 1;
                bins[((angle / BIN) as usize).min(last)] += 0.5 * share / OFFSETS as f64;
            }
        }
    }
    bins
}

fn main() {
    let rays = rays();
    for diameter in DIAMETERS {
        let sizes: Vec<f64> =
            (0..WAVELENGTHS).map(|i| PI * diameter / (0.5 + 0.1 * (i as f64 + 0.5) / WAVELENGTHS as f64)).collect();
        let waves: Vec<Vec<f64>> = sizes.par_iter().map(|&x| wave(x)).collect();
        let mean: Vec<f64> =
            (0..ANGLES).map(|i| waves.iter().map(|wave| wave[i]).sum::<f64>() / WAVELENGTHS as f64).collect();
        let step = PI / ANGLES as f64;
        let both = sizes.iter().map(|&x| coefficients(x).map(|c| efficiencies(x, &c)[0]).iter().sum::<f64>());
        let efficiency = 0.5 * both.sum::<f64>() / WAVELENGTHS as f64;
        let half = mean.iter().position(|y| *y < 0.5 * mean[0]).unwrap_or(ANGLES);
        let bins: Vec<f64> = mean.chunks(ANGLES / rays.len()).map(|bin| bin.iter().sum::<f64>() * step).collect();
        let difference: f64 = bins.iter().zip(&rays).skip(1).map(|(a, b)| (a - b).abs()).sum();
        println!(
            "{diameter} µm: Q_sca {efficiency:.3}, peak {:.2}°, beyond {BIN}° L1 {:.1} %",
            2.0 * (half as f64 / ANGLES as f64 * 180.0),
            100.0 * difference / rays[1..].iter().sum::<f64>()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The leading terms of the series for x → 0. The next terms are smaller by about x² ln x.
    #[test]
    fn thin_fibres_have_the_analytic_limit() {
        let (x, m2) = (0.01f64, ETA * ETA);
        let along = PI.powi(2) * x.powi(3) * (m2 - 1.0).powi(2) / 8.0;
        let across = PI.powi(2) * x.powi(3) * ((m2 - 1.0) / (m2 + 1.0)).powi(2) / 4.0;
        for (found, limit) in coefficients(x).iter().zip([along, across]) {
            let [scattering, extinction] = efficiencies(x, found);
            assert!((scattering / limit - 1.0).abs() < 2e-3, "{scattering} {limit}");
            assert!((extinction / scattering - 1.0).abs() < 1e-9, "{extinction} {scattering}");
        }
    }

    /// The optical theorem, for the largest fibre too. The midpoint rule is exact for fewer than 9000 orders.
    #[test]
    fn no_light_is_lost() {
        for x in [50.0, 314.0, 503.0] {
            let both = coefficients(x).map(|c| efficiencies(x, &c));
            let mean = 0.5 * (both[0][1] + both[1][1]);
            let total = wave(x).iter().sum::<f64>() * PI / ANGLES as f64;
            assert!((total / mean - 1.0).abs() < 1e-9, "{total} {mean}");
        }
        assert!((rays().iter().sum::<f64>() - 1.0).abs() < 1e-4);
    }
}
