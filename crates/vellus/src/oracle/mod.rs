//! The model again in f64: slow, obvious, kept apart from the fast code it judges.
//!
//! Written from the formulas as they stand in the paper and in PAPER.md's departures, with none of the
//! fast path's rearrangements: angles instead of sines, the tables interpolated and normalised
//! anew for every query. Use it in tests and where a number must be right rather than quick.

mod collected;
mod published;
mod segments;
mod window;

pub use published::PublishedSegments;
pub use segments::OracleSegments;
pub use window::OracleWindow;

use crate::fiber::Fiber;
use crate::medulla::grid::{self, OutgoingAxis};
use crate::medulla::tables::{FactorTable, TableData};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// One fibre, in f64.
#[derive(Clone, Debug)]
pub struct Oracle<'t> {
    tables: &'t TableData,
    /// η, κ, α, β_m, β_n, σ_ms, g, l
    eta: f64,
    kappa: f64,
    alpha: f64,
    beta_m: f64,
    beta_n: f64,
    sigma_ca: [f64; 3],
    sigma_ms: f64,
    sigma_ma: [f64; 3],
    g: f64,
    layers: f64,
}

/// All that depends on θ_o and h but for the tables' profiles.
#[derive(Clone, Debug)]
pub struct OraclePath<'o, 't> {
    oracle: &'o Oracle<'t>,
    theta_o: f64,
    gamma_o: f64,
    gamma_t: f64,
    s_c: f64,
    s_m: f64,
    /// Q·E, RGB.
    scattered: [f64; 3],
    attenuation: [[f64; 3]; 6],
}

/// All that depends on θ_o and h.
#[derive(Clone, Debug)]
pub struct OracleHit<'o, 't> {
    path: OraclePath<'o, 't>,
    azimuthal: Profile,
    longitudinal: [Profile; 2],
}

impl<'t> Oracle<'t> {
    /// The fibre must be valid; see [`Fiber::validate`].
    pub fn new(fiber: &Fiber, tables: &'t TableData) -> Self {
        let rgb = |c: [f32; 3]| c.map(f64::from);
        Oracle {
            tables,
            eta: fiber.eta.into(),
            kappa: fiber.kappa.into(),
            alpha: fiber.alpha.into(),
            beta_m: fiber.beta_m.into(),
            beta_n: fiber.beta_n.into(),
            sigma_ca: rgb(fiber.sigma_ca),
            sigma_ms: fiber.sigma_ms.into(),
            sigma_ma: rgb(fiber.sigma_ma),
            g: fiber.g.into(),
            layers: fiber.layers.into(),
        }
    }

    /// η′(θ_o).
    fn eta_prime(&self, theta_o: f64) -> f64 {
        (self.eta * self.eta - theta_o.sin().powi(2)).sqrt() / theta_o.cos()
    }

    /// 1/cos θ_t.
    fn elongation(&self, theta_o: f64) -> f64 {
        1.0 / (1.0 - (theta_o.sin() / self.eta).powi(2)).sqrt()
    }

    /// h″, 0 without medulla.
    fn medulla_offset(&self, theta_o: f64, h: f64) -> f64 {
        if self.kappa > 0.0 { (h / self.eta_prime(theta_o) / self.kappa).clamp(-1.0, 1.0) } else { 0.0 }
    }

    /// Prepares θ_o (radians) and h.
    pub fn at(&self, theta_o: f64, h: f64) -> OracleHit<'_, 't> {
        OracleHit {
            path: self.path(theta_o, h),
            azimuthal: self.azimuthal_profile(theta_o, h),
            longitudinal: self.longitudinal_profiles(theta_o),
        }
    }

    fn azimuthal_profile(&self, theta_o: f64, h: f64) -> Profile {
        let tau = self.sigma_ms * self.kappa * self.elongation(theta_o);
        Profile::azimuthal(self.tables, tau, self.g, self.medulla_offset(theta_o, h).abs())
    }

    /// D12: τ of C^M without the elongation.
    fn longitudinal_profiles(&self, theta_o: f64) -> [Profile; 2] {
        Profile::longitudinal(self.tables, self.sigma_ms * self.kappa, self.g, theta_o.abs())
    }

    /// Prepares θ_o (radians) and h, without the profiles of the scattered lobes.
    pub fn path(&self, theta_o: f64, h: f64) -> OraclePath<'_, 't> {
        let o = self;
        let h_inside = h / o.eta_prime(theta_o);
        let (gamma_o, gamma_t) = (h.asin(), h_inside.asin());
        let cos_t = 1.0 / o.elongation(theta_o);
        let s_m = (o.kappa * o.kappa - h_inside * h_inside).max(0.0).sqrt();
        let s_c = gamma_t.cos() - s_m;
        let f = fresnel(o.eta, o.layers, theta_o.cos() * gamma_o.cos());
        let q = 1.0 - (-2.0 * s_m * o.sigma_ms / cos_t).exp();

        let path = mean_path(o.tables, o.sigma_ms * o.kappa / cos_t, o.g, o.medulla_offset(theta_o, h).abs());
        let (mut attenuation, mut scattered) = ([[0.0; 3]; 6], [0.0; 3]);
        for c in 0..3 {
            let (ca, ma) = (o.sigma_ca[c], o.sigma_ma[c]);
            let t = (-2.0 * (s_c * ca + s_m * (ma + o.sigma_ms)) / cos_t).exp();
            let e = (-(o.kappa * path * ma + (1.0 - o.kappa) * ca) / cos_t).exp();
            scattered[c] = q * e;
            let tts = (1.0 - f) * (-s_c * ca / cos_t).exp() * q * e;
            let trts = (1.0 - f) * f * (-(3.0 * s_c * ca + 2.0 * s_m * (ma + o.sigma_ms)) / cos_t).exp() * q * e;
            let higher = if f * t < 1.0 { 1.0 / (1.0 - f * t) } else { 0.0 };
            attenuation
                .iter_mut()
                .zip([
                    f,
                    (1.0 - f).powi(2) * t,
                    (1.0 - f).powi(2) * f * t * t,
                    tts,
                    trts,
                    (1.0 - f).powi(2) * f * f * t.powi(3) * higher + trts * f * t * higher,
                ])
                .for_each(|(a, value)| a[c] = value);
        }
        OraclePath { oracle: self, theta_o, gamma_o, gamma_t, s_c, s_m, scattered, attenuation }
    }
}

impl OraclePath<'_, '_> {
    /// A(h) of the six lobes, RGB.
    pub fn energy(&self) -> [[f64; 3]; 6] {
        self.attenuation
    }

    /// Φₚ.
    fn exit(&self, p: usize) -> f64 {
        2.0 * p as f64 * self.gamma_t - 2.0 * self.gamma_o + p as f64 * PI
    }

    /// Φˢₚ, p = 1, 2.
    fn scattered_exit(&self, p: usize) -> f64 {
        (self.gamma_t - self.gamma_o) + (p as f64 - 1.0) * (PI + 2.0 * self.gamma_t)
    }

    /// D_p(φ) of R, TT, TRT, densities per radian.
    pub fn unscattered(&self, phi: f64) -> [f64; 3] {
        std::array::from_fn(|p| wrapped_gaussian(phi - self.exit(p), self.oracle.sigma(p)))
    }

    /// Azimuth from straight back in the frame of the tables, in [−π, π], mirrored where h″ < 0; p = 1, 2.
    fn relative(&self, p: usize, phi: f64) -> f64 {
        let mirror = if self.gamma_t < 0.0 { -1.0 } else { 1.0 };
        mirror * wrap(phi - self.scattered_exit(p))
    }
}

impl Oracle<'_> {
    /// Standard deviation of the azimuth of R, TT, TRT.
    fn sigma(&self, p: usize) -> f64 {
        (p as f64 + 1.0).sqrt() * self.beta_n
    }

    /// M̂ₚ(θᵢ) of R, TT, TRT and the rest.
    fn longitudinal(&self, theta_o: f64, theta_i: f64) -> [f64; 4] {
        let shift = [self.alpha, -self.alpha / 2.0, -1.5 * self.alpha, -1.5 * self.alpha];
        let width = [self.beta_m, self.beta_m / 2.0, 1.5 * self.beta_m, 2.0 * self.beta_m];
        std::array::from_fn(|p| longitudinal(-theta_o - shift[p], width[p] * width[p], theta_i))
    }
}

/// C^M of the backward and the forward half at θᵢ.
fn halves(profiles: &[Profile; 2], theta_o: f64, theta_i: f64) -> [f64; 2] {
    let tilt = if theta_o < 0.0 { -1.0 } else { 1.0 };
    [profiles[0].eval(tilt * theta_i), profiles[1].eval(tilt * theta_i)]
}

/// C^N at `relative` and C^M interpolated there between its halves.
fn scattered(azimuthal: &Profile, relative: f64, [back, front]: [f64; 2]) -> f64 {
    let weight = relative.abs() / PI;
    azimuthal.eval(relative.rem_euclid(TAU)) * ((1.0 - weight) * back + weight * front)
}

impl OracleHit<'_, '_> {
    /// A(h) of the six lobes, RGB.
    pub fn energy(&self) -> [[f64; 3]; 6] {
        self.path.attenuation
    }

    /// The six densities over solid angle at θᵢ and φ = φ_i − φ_o.
    pub fn densities(&self, theta_i: f64, phi: f64) -> [f64; 6] {
        let path = &self.path;
        let m = path.oracle.longitudinal(path.theta_o, theta_i);
        let n = path.unscattered(phi);
        let halves = halves(&self.longitudinal, path.theta_o, theta_i);
        let s = |p| scattered(&self.azimuthal, path.relative(p, phi), halves);
        [m[0] * n[0], m[1] * n[1], m[2] * n[2], s(1), s(2), m[3] / TAU]
    }

    /// N(φ) of the six lobes, RGB: what leaves at an azimuth, whatever its inclination.
    pub fn azimuthal(&self, phi: f64) -> [[f64; 3]; 6] {
        let path = &self.path;
        let n = path.unscattered(phi);
        let s = |p| scattered(&self.azimuthal, path.relative(p, phi), [1.0; 2]);
        let d = [n[0], n[1], n[2], s(1), s(2), 1.0 / TAU];
        std::array::from_fn(|p| path.attenuation[p].map(|a| a * d[p]))
    }

    /// f·cos θᵢ of the six lobes, RGB.
    pub fn eval(&self, theta_i: f64, phi: f64) -> [[f64; 3]; 6] {
        let d = self.densities(theta_i, phi);
        std::array::from_fn(|p| self.path.attenuation[p].map(|a| a * d[p]))
    }
}

/// F(η, cos, l) of [`crate::fresnel`].
pub fn fresnel(eta: f64, layers: f64, cos: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
    if eta == 1.0 || layers == 0.0 {
        return 0.0;
    }
    let r_s = ((cos - eta * cos_t) / (cos + eta * cos_t)).powi(2);
    let r_p = ((eta * cos - cos_t) / (eta * cos + cos_t)).powi(2);
    let phi = 0.5 * (2.0 * r_s / (1.0 + r_s) + 2.0 * r_p / (1.0 + r_p));
    layers * phi / (1.0 + (layers - 1.0) * phi)
}

/// M̂ with centre `theta_c` and variance `v` (D8), by its definition in log form.
pub fn longitudinal(theta_c: f64, v: f64, theta_i: f64) -> f64 {
    let x = (theta_c.cos() * theta_i.cos() / v).abs();
    let log = (theta_c.sin() * theta_i.sin() - 1.0) / v + x;
    log.exp() * bessel_i0e(x) / (v * -(-2.0 / v).exp_m1())
}

/// e⁻ˣ I₀(x) for x ≥ 0: the power series up to 30, beyond it the asymptotic series, whose terms
/// fall below 1e-17 there.
pub fn bessel_i0e(x: f64) -> f64 {
    if x < 30.0 {
        let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
        while term > 1e-18 * sum {
            term *= (x / (2.0 * k)).powi(2);
            sum += term;
            k += 1.0;
        }
        return sum * (-x).exp();
    }
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..25 {
        let odd = f64::from(2 * k - 1);
        term *= odd * odd / (8.0 * f64::from(k) * x);
        sum += term;
    }
    sum / (TAU * x).sqrt()
}

/// A Gaussian wrapped on the circle; all images within eight standard deviations.
pub fn wrapped_gaussian(d: f64, sigma: f64) -> f64 {
    let d = wrap(d);
    let images = ((8.0 * sigma + PI) / TAU) as i32;
    let sum: f64 = (-images..=images).map(|k| (-0.5 * ((d + TAU * f64::from(k)) / sigma).powi(2)).exp()).sum();
    sum / (sigma * TAU.sqrt())
}

/// The same angle in [−π, π).
fn wrap(x: f64) -> f64 {
    (x + PI).rem_euclid(TAU) - PI
}

/// ⟨L⟩(τ, g, h″ ≥ 0), in radii of the medulla, by trilinear interpolation.
pub fn mean_path(tables: &TableData, tau: f64, g: f64, h: f64) -> f64 {
    let n = tables.mean_path_nodes;
    let [tau, g, h] = [grid::tau_position(tau), grid::g_position(g), grid::offset_position(h)];
    let corners = [between(tau, n[0]), between(g, n[1]), between(h, n[2])];
    let mut sum = 0.0;
    for corner in 0..8usize {
        let mut weight = 1.0;
        let mut index = 0;
        for axis in 0..3 {
            let (i, t) = corners[axis];
            let upper = corner >> axis & 1;
            weight *= if upper == 1 { t } else { 1.0 - t };
            index = index * n[axis] + i + upper;
        }
        sum += weight * f64::from(tables.mean_path[index]);
    }
    sum
}

fn between(position: f64, nodes: usize) -> (usize, f64) {
    let x = (position * (nodes - 1) as f64).clamp(0.0, (nodes - 1) as f64);
    let i = (x as usize).min(nodes - 2);
    (i, x - i as f64)
}

/// One profile taken out of a table, normalised.
#[derive(Clone, Debug)]
pub struct Profile {
    axis: OutgoingAxis,
    /// What is added to the angle before the axis is consulted.
    shift: f64,
    values: Vec<f64>,
}

impl Profile {
    /// C^N(τ, g, h″ ≥ 0, ·): argument φ in [0, 2π] from straight back.
    pub fn azimuthal(tables: &TableData, tau: f64, g: f64, h: f64) -> Self {
        let position = [grid::tau_position(tau), grid::g_position(g), grid::offset_position(h)];
        let mut profile = Profile::new(&tables.azimuthal, position, OutgoingAxis::AZIMUTH, 0.0, |_| 1.0);
        let share = grid::mirrored_share(h);
        if share > 0.0 {
            let mirrored: Vec<f64> = profile.values.iter().rev().copied().collect();
            profile.values.iter_mut().zip(mirrored).for_each(|(x, m)| *x += share * (m - *x));
        }
        profile
    }

    /// C^M(τ, g, θ_o ≥ 0, ·) of the backward and the forward half: argument θᵢ.
    pub fn longitudinal(tables: &TableData, tau: f64, g: f64, theta_o: f64) -> [Self; 2] {
        let position = [grid::tau_position(tau), grid::g_position(g), grid::theta_position(theta_o)];
        let measure = |theta: f64| {
            if theta.abs() < FRAC_PI_2 { theta.cos() } else { 0.0 }
        };
        [
            Profile::new(&tables.backward, position, OutgoingAxis::BACKWARD, 0.0, measure),
            Profile::new(&tables.forward, position, OutgoingAxis::FORWARD, theta_o, measure),
        ]
    }

    fn new(
        table: &FactorTable,
        position: [f64; 3],
        axis: OutgoingAxis,
        shift: f64,
        measure: impl Fn(f64) -> f64,
    ) -> Self {
        let rank = table.rank;
        let factor = |mode: usize, r: usize| {
            let values = &table.factors[mode];
            let (i, t) = between(position[mode], values.len() / rank);
            (1.0 - t) * f64::from(values[i * rank + r]) + t * f64::from(values[(i + 1) * rank + r])
        };
        let weights: Vec<f64> = (0..rank).map(|r| factor(0, r) * factor(1, r) * factor(2, r)).collect();
        let values: Vec<f64> = table.factors[3]
            .chunks_exact(rank)
            .map(|row| row.iter().zip(&weights).map(|(b, w)| f64::from(*b) * w).sum())
            .collect();
        let mut profile = Profile { axis, shift, values };
        // Midpoint rule, 16 points an interval.
        let intervals = 16 * (profile.values.len() - 1);
        let step = (axis.last - axis.first) / intervals as f64;
        let integral: f64 = (0..intervals)
            .map(|k| axis.first + (k as f64 + 0.5) * step - shift)
            .map(|x| profile.eval(x) * measure(x) * step)
            .sum();
        profile.values.iter_mut().for_each(|x| *x /= integral);
        profile
    }

    /// The density at that angle.
    pub fn eval(&self, angle: f64) -> f64 {
        let x = angle + self.shift - self.axis.first;
        let (i, t) = between(x / (self.axis.last - self.axis.first), self.values.len());
        (1.0 - t) * self.values[i] + t * self.values[i + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 50-digit values (mpmath), rounded to double.
    #[test]
    fn bessel_matches_high_precision() {
        for (x, expected) in crate::simd::special::tests::I0E {
            let value = bessel_i0e(x);
            assert!((value / expected - 1.0).abs() < 1e-14, "{x}: {value} {expected}");
        }
    }
}
