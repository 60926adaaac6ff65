//! The model of Yan, Jensen and Ramamoorthi 2017 with the formulas as printed, in f64. It shows what the departures of
//! `vellus` change; see PAPER.md.
//!
//! The formulas that differ from those of `vellus` are:
//! - Gaussians in θ divided by cos²θ (Eq. 5, 12).
//! - The half angle θ_d in η′ and in the attenuation (Eq. 3, 14).
//! - The two-dimensional Fresnel factor F(η′, γ).
//! - T_b with its fixed path κ (Sec. 4.3).
//! - The sign +α_p.
//! - Five lobes instead of six.
//! - Averages over a window by segments at h = √(i/n) (Sec. 5).
//!
//! The paper contradicts itself in two places. This module follows Eq. 20 rather than Table 3 (D4). It interprets the
//! tables as the scattered *energy*, which is Q times a density (D5).
//!
//! Arrays of lobes are in the order R, TT, TRT, TTˢ, TRTˢ.

mod integrals;
mod over_exact;
mod segments;
mod window;

pub use over_exact::PrintedSegments;
pub use window::PrintedWindow;

use crate::exact::{Exact, fresnel, wrapped_gaussian};
use segments::{Medium, Node};
use std::f64::consts::{PI, TAU};
use vellus::{Error, Fiber, ScatterExit, TableData};

/// The published model of one fibre: at one offset, or averaged over a [`window`](AsPrinted::window) of offsets.
#[derive(Clone, Debug)]
pub struct AsPrinted<'t> {
    fiber: Fiber,
    exact: Exact<'t>,
}

impl<'t> AsPrinted<'t> {
    /// Prepares a fibre.
    ///
    /// # Errors
    /// As [`Exact::new`].
    pub fn new(fiber: &Fiber, tables: &'t TableData) -> Result<Self, Error> {
        // In the paper, all scattered light leaves.
        let fiber = fiber.in_air().with_exit(ScatterExit::Open);
        Ok(AsPrinted { fiber, exact: Exact::new(&fiber, tables)? })
    }

    /// F, the paths and the angles at offset `h`.
    fn node(&self, theta_d: f64, h: f64) -> Node {
        let f = &self.fiber;
        let [eta, kappa, layers] = [f.eta, f.kappa, f.layers].map(f64::from);
        let eta_prime = (eta * eta - theta_d.sin().powi(2)).sqrt() / theta_d.cos();
        let (gamma_i, gamma_t) = (h.asin(), (h / eta_prime).asin());
        let s_m = (kappa * kappa - (h / eta_prime).powi(2)).max(0.0).sqrt();
        Node {
            h,
            reflected: fresnel(eta_prime, layers, gamma_i.cos()),
            s_c: gamma_t.cos() - s_m,
            s_m,
            gamma_i,
            gamma_t,
        }
    }

    /// σ over cos θ_d.
    fn medium(&self, theta_d: f64) -> Medium {
        let f = &self.fiber;
        let long = 1.0 / theta_d.cos();
        Medium {
            cortex: f.sigma_ca.map(|ca| f64::from(ca) * long),
            medulla: f.sigma_ma.map(|ma| (f64::from(ma) + f64::from(f.sigma_ms)) * long),
            beta_n: f.beta_n.into(),
        }
    }

    /// Q, the scattered fraction of one pass. It is 0 for a path that misses the medulla, where s_m is 0.
    fn scattered_fraction(&self, theta_d: f64, node: &Node) -> f64 {
        -(-2.0 * node.s_m * f64::from(self.fiber.sigma_ms) / theta_d.cos()).exp_m1()
    }

    /// T_b, the transmittance after scattering, RGB.
    fn escaping(&self, theta_d: f64) -> [f64; 3] {
        let kappa = f64::from(self.fiber.kappa);
        std::array::from_fn(|c| {
            let (ca, ma) = (f64::from(self.fiber.sigma_ca[c]), f64::from(self.fiber.sigma_ma[c]));
            (-(kappa * ma + (1.0 - kappa) * ca) / theta_d.cos()).exp()
        })
    }

    /// A of R, TT, TRT, TTˢ, TRTˢ, RGB.
    #[doc(alias = "Table 3")]
    fn attenuation(&self, theta_d: f64, node: &Node) -> [[f64; 3]; 5] {
        let Node { reflected, s_c, s_m, .. } = *node;
        let medium = self.medium(theta_d);
        let (q, t_b) = (self.scattered_fraction(theta_d, node), self.escaping(theta_d));
        let mut lobes = [[0.0; 3]; 5];
        for c in 0..3 {
            let (cortex, medulla) = (medium.cortex[c], medium.medulla[c]);
            let pass = |p: f64| (-2.0 * p * (s_c * cortex + s_m * medulla)).exp();
            let t_a = |p: f64| (-(2.0 * p - 1.0) * s_c * cortex - 2.0 * (p - 1.0) * s_m * medulla).exp();
            let transmitted = 1.0 - reflected;
            let values = [
                reflected,
                transmitted.powi(2) * pass(1.0),
                transmitted.powi(2) * reflected * pass(2.0),
                transmitted * t_a(1.0) * t_b[c] * q,
                transmitted * reflected * t_a(2.0) * t_b[c] * q,
            ];
            lobes.iter_mut().zip(values).for_each(|(lobe, value)| lobe[c] = value);
        }
        lobes
    }

    /// M cos θ/cos²θ of R, TT, TRT.
    #[doc(alias = "Eq. 5")]
    fn longitudinal(&self, theta_o: f64, theta_i: f64) -> [f64; 3] {
        let [alpha, beta] = [self.fiber.alpha, self.fiber.beta_m].map(f64::from);
        let shift = [alpha, -0.5 * alpha, -1.5 * alpha];
        let width = [beta, 0.5 * beta, 1.5 * beta];
        let gaussian = |x: f64, s: f64| (-0.5 * (x / s).powi(2)).exp() / (s * TAU.sqrt());
        std::array::from_fn(|p| gaussian(theta_i + theta_o - shift[p], width[p]) / theta_i.cos())
    }

    /// S·cos θ of the five lobes, RGB. `theta_o` and `h` belong to the incident direction of the paper (θ_i, h there),
    /// `theta_i` to the other one, and φ is the azimuth between them. Angles are in radians.
    #[doc(alias = "Eq. 12")]
    pub fn eval(&self, theta_o: f64, h: f64, theta_i: f64, phi: f64) -> [[f64; 3]; 5] {
        let theta_d = 0.5 * (theta_i - theta_o);
        let node = self.node(theta_d, h);
        let a = self.attenuation(theta_d, &node);
        let m = self.longitudinal(theta_o, theta_i);
        // The tables, at the paper's angles: h and the elongation come from θ_d. The stored profiles are densities
        // in sin θ, M cos θ of the paper over cos²θ.
        let scattered = self.exact.at(theta_o, h).densities(theta_i, phi);
        std::array::from_fn(|p| {
            let density = if p < 3 {
                let q = p as f64;
                let centre = 2.0 * q * node.gamma_t - 2.0 * node.gamma_i + q * PI;
                m[p] * wrapped_gaussian(phi - centre, (q + 1.0).sqrt() * f64::from(self.fiber.beta_n))
            } else {
                scattered[p]
            };
            a[p].map(|a| a * density)
        })
    }

    /// A of the five lobes at the specular inclination θ_i = −θ_o (radians), RGB, in [0, 1].
    pub fn energy(&self, theta_o: f64, h: f64) -> [[f64; 3]; 5] {
        self.attenuation(-theta_o, &self.node(-theta_o, h))
    }
}
