//! Paths of light through both cylinders: exit azimuths and energies.

use super::escape::interface;
use crate::entry::Entry;
use crate::factored::Energies;
use std::f32::consts::PI;
use vellus::parts::exp;
use vellus::{Fiber, Lanes};
use wide::f32x8;

/// The paths of a ray through the two concentric cylinders. Every refraction and reflection deflects a path by one of a
/// few angles, so exit azimuths are short sums. The paper traces the segments of each path instead: [`Paths::traced`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Paths {
    /// Energies A of the eight unscattered lobes.
    pub unscattered: Energies,
    /// Exit azimuths Φ of the eight unscattered lobes.
    pub exit: [f32; 8],
    /// The ray in the medulla. `None` if the ray misses the medulla or is totally reflected off it.
    pub medulla: Option<InMedulla>,
}

/// A ray in the medulla.
#[derive(Clone, Copy, Debug)]
pub(super) struct InMedulla {
    /// The angle asin h″ of the offset, the same for all passes.
    pub angle: f32,
    /// sin θ in the medulla.
    pub sin_m: f32,
    /// 1/cos θ in the medulla.
    pub elongation: f32,
    /// Azimuth from which light arrives in each of the three passes. This is φ = 0 of the tables.
    pub back: [f32; 3],
    /// Energy that each pass scatters, RGB, before it leaves.
    pub scattered: [[f32; 3]; 3],
}

impl Paths {
    #[inline(always)]
    pub fn new(fiber: &Fiber, eta_m: f32, entry: &Entry) -> Self {
        let kappa = fiber.kappa;
        let (f, t) = (entry.fresnel.reflected, entry.fresnel.transmitted);
        let into = entry.gamma_t - entry.gamma_o;
        let around = PI + 2.0 * entry.gamma_t;
        let mut exit = [0.0; 8];
        exit[0] = -2.0 * entry.gamma_o;
        exit[1] = PI + 2.0 * into;
        exit[2] = exit[1] + around;
        if entry.h_inside.abs() >= kappa {
            let unscattered = entry.pass(fiber.sigma_ca).map(|pass| {
                let tt = t * t * pass;
                [f, tt, tt * f * pass, 0.0, 0.0, 0.0, 0.0, 0.0]
            });
            return Paths { unscattered, exit, medulla: None };
        }

        // At the medulla, γ₁ is the angle outside and γ₂ the angle inside. θ_m is the inclination in the medulla. h″ =
        // sin γ₂ is the offset in units of its radius.
        let eta_c = fiber.eta;
        let (sin_o, sin_m) = (entry.polar.sin, entry.polar.sin / eta_m);
        let normal = |eta: f32| ((eta - sin_o) * (eta + sin_o)).max(1e-12).sqrt();
        let (along_c, along_m) = (normal(eta_c), normal(eta_m));
        let sin_1 = entry.h_inside / kappa;
        let sin_2 = sin_1 * along_c / along_m;
        let cos = |sin: f32| ((1.0 - sin) * (1.0 + sin)).max(0.0).sqrt();
        let (cos_1, cos_2) = (cos(sin_1), cos(sin_2));
        let [gamma_1, gamma_2] = f32::atan2_pair([sin_1, sin_2], [cos_1, cos_2]);
        let enters = sin_2.abs() < 1.0;
        let r = if enters { interface(eta_c, eta_m, along_c / eta_c * cos_1, along_m / eta_m * cos_2) } else { 1.0 };
        let through = 1.0 - r;
        let elongation = eta_m / along_m;

        // One register holds all exponentials: the cortex from cuticle to medulla, one pass of the medulla, and σ_m,s
        // only.
        let cortex = (entry.cos_gamma_t - kappa * cos_1) * entry.elongation;
        let medulla = 2.0 * kappa * cos_2 * elongation;
        let (ca, ma, ms) = (fiber.sigma_ca, fiber.sigma_ma, fiber.sigma_ms);
        let inside = |c: usize| -medulla * (ma[c] + ms);
        let exponents = [-cortex * ca[0], -cortex * ca[1], -cortex * ca[2], inside(0), inside(1), inside(2)];
        let [c0, c1, c2, m0, m1, m2, unscattered, _] = exp(f32x8::new([
            exponents[0],
            exponents[1],
            exponents[2],
            exponents[3],
            exponents[4],
            exponents[5],
            -medulla * ms,
            0.0,
        ]))
        .to_array();
        let (t_c, t_m) = ([c0, c1, c2], [m0, m1, m2]);
        let x = medulla * ms;
        // 1 − e⁻ˣ by its series for small x, to avoid cancellation. The error is x³/24 = 3e-7.
        let q = if x < 0.02 { x * (1.0 - x * (0.5 - x / 6.0)) } else { 1.0 - unscattered };

        let mut energy = [[0.0; 8]; 3];
        let mut scattered = [[0.0; 3]; 3];
        for c in 0..3 {
            let (leg, pass) = (t_c[c], t_m[c]);
            let tt = t * t * leg * leg;
            let back = f * leg * leg;
            let passed = through * through * pass;
            energy[c] = [
                f,
                0.0,
                0.0,
                tt * r,
                tt * r * r * back,
                tt * passed,
                tt * passed * r * pass,
                tt * passed * passed * back,
            ];
            let first = t * leg * through * q;
            scattered[0][c] = first;
            scattered[1][c] = first * r * pass;
            scattered[2][c] = first * passed * back;
        }

        let (refract, off, within) = (gamma_2 - gamma_1, PI - 2.0 * gamma_1, PI + 2.0 * gamma_2);
        exit[3] = exit[1] + off;
        exit[4] = exit[3] + around + off;
        exit[5] = exit[1] + 2.0 * refract;
        exit[6] = exit[5] + within;
        exit[7] = exit[5] + around + 2.0 * refract;
        // Light that travels along Φ + π comes from Φ.
        let first = into + refract;
        let medulla = enters.then_some(InMedulla {
            angle: gamma_2,
            sin_m,
            elongation,
            back: [first, first + within, first + 2.0 * refract + around],
            scattered,
        });
        Paths { unscattered: energy, exit, medulla }
    }
}
