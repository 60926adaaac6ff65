//! One path through the fibre: its angles, lengths and attenuations (Yan17 Table 3).

use super::flat::Flat;
use super::formulas::{fresnel, wrap, wrapped_gaussian};
use super::{Exact, ExactExit, mean_path};
use std::f64::consts::PI;
use vellus::parts::MOST_TURN;

/// The path of a ray with inclination θ_o and offset h: everything about its hit except the profiles of the medulla.
#[derive(Clone, Debug)]
pub struct ExactPath<'e, 't> {
    pub(super) exact: &'e Exact<'t>,
    pub(super) theta_o: f64,
    pub(crate) gamma_o: f64,
    pub(crate) gamma_t: f64,
    pub(crate) s_c: f64,
    pub(crate) s_m: f64,
    /// Q·E, RGB.
    pub(crate) scattered: [f64; 3],
    pub(crate) attenuation: [[f64; 3]; 6],
    /// The part of the last lobe that is scattered light which the cuticle reflected, RGB (D17).
    pub(crate) diffuse: [f64; 3],
    /// `None` for a circle. γ_o and γ_t are those of the first exit otherwise.
    pub(super) flat: Option<Flat>,
}

impl<'t> Exact<'t> {
    /// Traces the ray with the inclination `theta_o` (radians, |θ_o| < π/2) and the offset `h` in [−1, 1]. This does
    /// not look up the profiles of the scattered lobes. [`Exact::at`] does.
    pub fn path(&self, theta_o: f64, h: f64) -> ExactPath<'_, 't> {
        let o = self;
        if o.eta_m < o.eta {
            return o.flat_path([theta_o, 0.0], h);
        }
        let h_inside = h / o.eta_prime(theta_o);
        let (gamma_o, gamma_t) = (h.asin(), h_inside.asin());
        let cos_t = 1.0 / o.elongation(theta_o);
        let s_m = (o.kappa * o.kappa - h_inside * h_inside).max(0.0).sqrt();
        let s_c = gamma_t.cos() - s_m;
        let f = fresnel(o.eta, o.layers, theta_o.cos() * gamma_o.cos());
        let q = 1.0 - (-2.0 * s_m * o.sigma_ms / cos_t).exp();

        let path = mean_path(o.tables, o.sigma_ms * o.kappa / cos_t, o.g, o.medulla_offset(theta_o, h).abs());
        let entry = o.sigma_ca.map(|ca| (-s_c * ca / cos_t).exp());
        let reflecting = o.escape(theta_o, h, entry);
        let (mut attenuation, mut scattered, mut diffuse) = ([[0.0; 3]; 6], [0.0; 3], [0.0; 3]);
        for c in 0..3 {
            let (ca, ma) = (o.sigma_ca[c], o.sigma_ma[c]);
            let t = (-2.0 * (s_c * ca + s_m * (ma + o.sigma_ms)) / cos_t).exp();
            let (e, first) = match reflecting {
                None => ((-(o.kappa * path * ma + (1.0 - o.kappa) * ca) / cos_t).exp(), 1.0),
                Some([escape, first]) => (escape[c], first[c]),
            };
            scattered[c] = q * e;
            let tts = (1.0 - f) * entry[c] * q * e;
            let trts = (1.0 - f) * f * (-(3.0 * s_c * ca + 2.0 * s_m * (ma + o.sigma_ms)) / cos_t).exp() * q * e;
            let higher = if f * t < 1.0 { 1.0 / (1.0 - f * t) } else { 0.0 };
            attenuation
                .iter_mut()
                .zip([
                    f,
                    (1.0 - f).powi(2) * t,
                    (1.0 - f).powi(2) * f * t * t,
                    tts * first,
                    trts * first,
                    (1.0 - f).powi(2) * f * f * t.powi(3) * higher + trts * f * t * higher,
                ])
                .for_each(|(a, value)| a[c] = value);
            if reflecting.is_some() {
                diffuse[c] = (tts + trts) * (1.0 - first) + trts * f * t * higher;
                attenuation[5][c] += (tts + trts) * (1.0 - first);
            }
        }
        ExactPath { exact: self, theta_o, gamma_o, gamma_t, s_c, s_m, scattered, attenuation, diffuse, flat: None }
    }
}

impl ExactPath<'_, '_> {
    /// A(h), the share of the light that each of the six lobes carries, RGB, in [0, 1].
    #[doc(alias = "Table 3")]
    pub fn energy(&self) -> [[f64; 3]; 6] {
        self.attenuation
    }

    /// The light of each lobe, RGB, from the densities of the lobes and that of the diffuse light.
    pub(crate) fn lobes(&self, densities: [f64; 6], diffuse: f64) -> [[f64; 3]; 6] {
        let mut light: [[f64; 3]; 6] = std::array::from_fn(|p| self.attenuation[p].map(|a| a * densities[p]));
        (0..3).for_each(|c| light[5][c] += self.diffuse[c] * (diffuse - densities[5]));
        light
    }

    /// Φₚ, the exit azimuth of R, TT, TRT (p = 0, 1, 2), not wrapped.
    pub(crate) fn exit(&self, p: usize) -> f64 {
        if let Some(flat) = &self.flat {
            return flat.exits[p];
        }
        2.0 * p as f64 * self.gamma_t - 2.0 * self.gamma_o + p as f64 * PI
    }

    /// Φˢₚ, the azimuth opposite to the direction of the light in its p-th pass (p = 1, 2).
    fn scattered_exit(&self, p: usize) -> f64 {
        if let Some(flat) = &self.flat {
            return flat.exits[2 + p];
        }
        (self.gamma_t - self.gamma_o) + (p as f64 - 1.0) * (PI + 2.0 * self.gamma_t)
    }

    /// D_p(φ) of R, TT, TRT: densities per radian at the azimuth φ = φ_i − φ_o.
    #[doc(alias = "Eq. 16")]
    pub fn unscattered(&self, phi: f64) -> [f64; 3] {
        std::array::from_fn(|p| wrapped_gaussian(phi - self.exit(p), self.exact.sigma(p)))
    }

    /// The azimuth from straight back in the frame of the tables, in [−π, π], mirrored where h″ < 0, and its derivative
    /// over φ; p = 1, 2.
    pub(crate) fn relative(&self, p: usize, phi: f64) -> (f64, f64) {
        let mirror = if self.medulla_offset() < 0.0 { -1.0 } else { 1.0 };
        let outside = mirror * (phi - self.scattered_exit(p));
        let Some(turning) = self.exact.exit.as_ref().map(ExactExit::turning) else { return (wrap(outside), 1.0) };
        // D19: e^(iψ) = (w + a)/(1 + ā w) with w = e^(i(φ − α)).
        let h = self.medulla_offset().abs();
        let straight =
            turning.straight * self.theta_o.cos() * (mirror * (self.gamma_o - self.gamma_t) - h * turning.slope);
        let [constant, cosine, sine] = turning.parts;
        let limit = |x: f64| x.clamp(-f64::from(MOST_TURN), f64::from(MOST_TURN));
        let [re, im] = [limit(0.5 * (1.0 - h * h) * sine), limit(-0.5 * (h * cosine + straight))];
        let angle = outside + h * constant;
        let (sin, cos) = angle.sin_cos();
        let [x, y] = [1.0 + re * cos + im * sin, im * cos - re * sin];
        (wrap(angle + 2.0 * y.atan2(x)), (1.0 - re * re - im * im) / (x * x + y * y))
    }

    /// h″ with its sign.
    pub(super) fn medulla_offset(&self) -> f64 {
        if let Some(flat) = &self.flat {
            return flat.offset;
        }
        (self.gamma_t.sin() / self.exact.kappa).clamp(-1.0, 1.0)
    }

    /// D20: the mean of cos φ and sin φ over light that leaves later.
    pub(crate) fn later(&self) -> [f64; 2] {
        let Some(turning) = self.exact.exit.as_ref().map(ExactExit::turning) else { return [0.0; 2] };
        let (sin, cos) = (self.scattered_exit(1) - self.medulla_offset().asin()).sin_cos();
        [turning.stays * cos, turning.stays * sin]
    }
}
