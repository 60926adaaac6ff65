//! The paper's near field to the letter, f64: an oracle for what our departures change, not for
//! production.
//!
//! Gaussians in θ with 1/cos²θ (Yan17 Eq. 5, 12), half angle θ_d in η′ and in the attenuation
//! (Eq. 3, 14), two-dimensional Fresnel F(η′, γ), T_b with its fixed path κ (Sec. 4.3), +α_p, five lobes.
//! Where the paper contradicts itself: Eq. 20 over Table 3 (D4), and the tables carry the
//! scattered *energy*, Q times a density (D5).

use crate::fiber::Fiber;
use crate::oracle::{Oracle, fresnel, wrapped_gaussian};
use crate::tables::TableData;
use std::f64::consts::{PI, TAU};

/// The published near-field model of one fibre.
#[derive(Clone, Debug)]
pub struct Published<'t> {
    fiber: Fiber,
    oracle: Oracle<'t>,
}

/// The quantities of Yan17 Table 3 at one θ_d and h.
struct Attenuation {
    gamma_i: f64,
    gamma_t: f64,
    lobes: [[f64; 3]; 5],
}

impl<'t> Published<'t> {
    /// The fibre must be valid; see [`Fiber::validate`].
    pub fn new(fiber: &Fiber, tables: &'t TableData) -> Self {
        Published { fiber: *fiber, oracle: Oracle::new(fiber, tables) }
    }

    #[doc(alias = "Table 3")]
    fn attenuation(&self, theta_d: f64, h: f64) -> Attenuation {
        let f = &self.fiber;
        let [eta, kappa, sigma_ms, layers] = [f.eta, f.kappa, f.sigma_ms, f.layers].map(f64::from);
        let eta_prime = (eta * eta - theta_d.sin().powi(2)).sqrt() / theta_d.cos();
        let (gamma_i, gamma_t) = (h.asin(), (h / eta_prime).asin());
        let reflected = fresnel(eta_prime, layers, gamma_i.cos());
        let s_m = (kappa * kappa - (h / eta_prime).powi(2)).max(0.0).sqrt();
        let s_c = gamma_t.cos() - s_m;
        let inside = if (h / eta_prime).abs() < kappa { 1.0 } else { 0.0 };
        let long = 1.0 / theta_d.cos();
        let q = 1.0 - (-2.0 * s_m * sigma_ms * long).exp();
        let mut lobes = [[0.0; 3]; 5];
        for c in 0..3 {
            let (ca, ma) = (f64::from(f.sigma_ca[c]), f64::from(f.sigma_ma[c]));
            let pass = |p: f64| (-p * (2.0 * s_c * ca + 2.0 * s_m * (ma + sigma_ms)) * long).exp();
            let t_b = (-(kappa * ma + (1.0 - kappa) * ca) * long).exp();
            let t_a = |p: f64| (-((2.0 * p - 1.0) * s_c * ca + 2.0 * (p - 1.0) * s_m * (ma + sigma_ms)) * long).exp();
            let transmitted = 1.0 - reflected;
            let values = [
                reflected,
                transmitted.powi(2) * pass(1.0),
                transmitted.powi(2) * reflected * pass(2.0),
                transmitted * t_a(1.0) * t_b * q * inside,
                transmitted * reflected * t_a(2.0) * t_b * q * inside,
            ];
            lobes.iter_mut().zip(values).for_each(|(lobe, value)| lobe[c] = value);
        }
        Attenuation { gamma_i, gamma_t, lobes }
    }

    /// S·cos θ of R, TT, TRT, TTˢ, TRTˢ, RGB. `theta_o` and `h` belong to the incident direction
    /// of the paper (θ_i, h there), `theta_i` to the other one; φ is the azimuth between them.
    #[doc(alias = "Eq. 12")]
    pub fn eval(&self, theta_o: f64, h: f64, theta_i: f64, phi: f64) -> [[f64; 3]; 5] {
        let f = &self.fiber;
        let [alpha, beta_m, beta_n] = [f.alpha, f.beta_m, f.beta_n].map(f64::from);
        let theta_d = 0.5 * (theta_i - theta_o);
        let a = self.attenuation(theta_d, h);
        let shift = [alpha, -0.5 * alpha, -1.5 * alpha];
        let width = [beta_m, 0.5 * beta_m, 1.5 * beta_m];
        let gaussian = |x: f64, s: f64| (-0.5 * (x / s).powi(2)).exp() / (s * TAU.sqrt());
        // The tables, at the paper's angles: h and the elongation come from θ_d.
        let scattered = self.oracle.at(theta_o, h).densities(theta_i, phi);
        std::array::from_fn(|p| {
            let density = if p < 3 {
                let q = p as f64;
                let centre = 2.0 * q * a.gamma_t - 2.0 * a.gamma_i + q * PI;
                gaussian(theta_i + theta_o - shift[p], width[p])
                    * wrapped_gaussian(phi - centre, (q + 1.0).sqrt() * beta_n)
                    / theta_i.cos()
            } else {
                // The stored profiles are densities in sin θ, M cos θ of the paper over cos²θ.
                scattered[p]
            };
            a.lobes[p].map(|a| a * density)
        })
    }

    /// A of R, TT, TRT, TTˢ, TRTˢ at the specular inclination θ_i = −θ_o, RGB.
    pub fn energy(&self, theta_o: f64, h: f64) -> [[f64; 3]; 5] {
        self.attenuation(-theta_o, h).lobes
    }
}
