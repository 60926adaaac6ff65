//! A table of N_p(φ) for a rough surface and one channel.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Number of nodes of θ_d in [0°, 90°].
const THETAS: usize = 31;

/// N_p over φ in [0, π] for each θ_d, with the absorption of one channel.
#[derive(Debug)]
pub(super) struct Azimuths {
    phis: usize,
    /// Values of N_p. φ varies fastest, then p, then θ_d.
    values: Vec<f32>,
    /// Cumulative integrals over φ, in the same order.
    cumulative: Vec<f32>,
    /// ∫ N_p dφ over the circle. p varies fastest, then θ_d.
    energies: Vec<f32>,
}

/// The unpolarised reflectance of a smooth interface with the relative index `eta` ≥ 1, at an angle of incidence with
/// the cosine `cos` in [0, 1].
fn interface(eta: f64, cos: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
    let [r_s, r_p] = [(cos, eta * cos_t), (eta * cos, cos_t)].map(|(a, b)| ((a - b) / (a + b)).powi(2));
    if eta == 1.0 { 0.0 } else { 0.5 * (r_s + r_p) }
}

/// Φ_p(h) and A_p(h) for p = 0 … 3.
fn path(eta: f64, sigma: f64, theta_d: f64, gamma: f64) -> [(f64, f64); 4] {
    let (sin, cos) = theta_d.sin_cos();
    let along = ((eta - sin) * (eta + sin)).max(1e-12).sqrt();
    let gamma_t = (gamma.sin() * cos / along).clamp(-1.0, 1.0).asin();
    let f = interface(eta, (cos * gamma.cos()).clamp(0.0, 1.0));
    let pass = (-sigma * 2.0 * gamma_t.cos() * eta / along).exp();
    std::array::from_fn(|p| {
        let q = p as f64;
        let exit = 2.0 * q * gamma_t - 2.0 * gamma + q * PI;
        (exit, if p == 0 { f } else { (1.0 - f).powi(2) * f.powi(p as i32 - 1) * pass.powi(p as i32) })
    })
}

impl Azimuths {
    /// The table for one channel. `sigma` is its σ_c,a.
    pub fn new(eta: f32, beta_n: f32, sigma: f32) -> Self {
        let (eta, beta, absorption) = (f64::from(eta), f64::from(beta_n), f64::from(sigma));
        // R is the narrowest lobe. It has three nodes per standard deviation, so linear interpolation is within 1/72 of
        // its peak. Φ changes by up to four radians per radian of γ, and the step in Φ is at most 0.4 standard
        // deviations.
        let phis = ((3.0 * PI / beta).ceil() as usize).clamp(91, 1801);
        let gammas = ((4.0 * PI / (0.4 * beta)).ceil() as usize).clamp(128, 4000);
        let mut table =
            Azimuths { phis, values: Vec::new(), cumulative: Vec::new(), energies: Vec::with_capacity(4 * THETAS) };
        let step = PI / (phis - 1) as f64;
        let lobes = [1.0f64, 2.0, 3.0, 4.0].map(|k| {
            let sigma = beta * k.sqrt();
            // Number of images within six standard deviations (e⁻¹⁸) of [0, π].
            (sigma, if sigma < 1.0 { 1 } else { 3 })
        });
        for theta in 0..THETAS {
            let theta_d = theta as f64 / (THETAS - 1) as f64 * FRAC_PI_2;
            let mut rows = [0; 4].map(|_| vec![0.0f64; phis]);
            for k in 0..gammas {
                let gamma = ((k as f64 + 0.5) / gammas as f64 - 0.5) * PI;
                let paths = path(eta, absorption, theta_d, gamma);
                for ((row, (exit, a)), (sigma, images)) in rows.iter_mut().zip(paths).zip(lobes) {
                    let exit = (exit + PI).rem_euclid(TAU) - PI;
                    let width = 0.5 * gamma.cos() * PI / gammas as f64 / (sigma * TAU.sqrt());
                    for image in -images..=images {
                        let centre = exit + f64::from(image) * TAU;
                        let first = ((centre - 6.0 * sigma) / step).ceil().max(0.0) as usize;
                        let last = ((centre + 6.0 * sigma) / step).floor().min((phis - 1) as f64);
                        for j in first..(last + 1.0).max(0.0) as usize {
                            let bell = width * (-0.5 * ((j as f64 * step - centre) / sigma).powi(2)).exp();
                            row[j] += a * bell;
                        }
                    }
                }
            }
            rows.iter().for_each(|row| table.push(row, step));
        }
        table
    }

    fn push(&mut self, row: &[f64], step: f64) {
        let mut sum = 0.0;
        self.cumulative.push(0.0);
        for pair in row.windows(2) {
            sum += 0.5 * (pair[0].max(1e-12) + pair[1].max(1e-12)) * step;
            self.cumulative.push(sum as f32);
        }
        self.values.extend(row.iter().map(|v| v.max(1e-12) as f32));
        self.energies.push(2.0 * sum as f32);
    }

    /// The node below θ_d, and the fraction of the way to the next.
    #[inline(always)]
    pub fn theta(theta_d: f32) -> (usize, f32) {
        let x = theta_d.abs() * ((THETAS - 1) as f32 / std::f32::consts::FRAC_PI_2);
        let i = (x as usize).min(THETAS - 2);
        (i, x - i as f32)
    }

    /// N_p(φ).
    #[inline(always)]
    pub fn eval(&self, p: usize, (theta, t): (usize, f32), phi: f32) -> f32 {
        let x = phi.abs() * ((self.phis - 1) as f32 / std::f32::consts::PI);
        let j = (x as usize).min(self.phis - 2);
        let s = x - j as f32;
        let row = |theta: usize| {
            let at = &self.values[(4 * theta + p) * self.phis + j..][..2];
            (1.0 - s) * at[0] + s * at[1]
        };
        // This form stays positive if one of the values is tiny.
        (1.0 - t) * row(theta) + t * row(theta + 1)
    }

    /// ∫ N_p dφ.
    #[inline(always)]
    pub fn energy(&self, p: usize, (theta, t): (usize, f32)) -> f32 {
        let [a, b] = [0, 1].map(|k| self.energies[4 * (theta + k) + p]);
        (1.0 - t) * a + t * b
    }

    /// Samples φ: selects one of the two rows, and inverts its piecewise linear density exactly.
    pub fn sample(&self, p: usize, (theta, t): (usize, f32), u: [f32; 2]) -> f32 {
        let [a, b] = [0, 1].map(|k| self.energies[4 * (theta + k) + p]);
        let far = u[1] * ((1.0 - t) * a + t * b) >= (1.0 - t) * a;
        let start = (4 * (theta + usize::from(far)) + p) * self.phis;
        let (cumulative, values) = (&self.cumulative[start..][..self.phis], &self.values[start..][..self.phis]);
        let side = if u[0] < 0.5 { -1.0 } else { 1.0 };
        let v = if u[0] < 0.5 { 2.0 * u[0] } else { 2.0 * u[0] - 1.0 };
        let target = v * cumulative[self.phis - 1];
        let j = (cumulative.partition_point(|&c| c <= target)).clamp(1, self.phis - 1) - 1;
        let (f0, f1) = (values[j], values[j + 1]);
        let part = ((target - cumulative[j]) / (cumulative[j + 1] - cumulative[j]).max(1e-30)).clamp(0.0, 1.0);
        let root = (f0 * f0 + part * (f1 * f1 - f0 * f0)).max(0.0).sqrt();
        let x = part * (f0 + f1) / (f0 + root).max(1e-30);
        side * (j as f32 + x.clamp(0.0, 1.0)) * std::f32::consts::PI / (self.phis - 1) as f32
    }
}
