//! Path geometry in the fibre and the energy each lobe carries: everything that depends on ω_o
//! and h only (Yan17 Table 3, Sec. 4.2–4.3).

use crate::cuticle::{Fresnel, fresnel};
use crate::fiber::Fiber;
use crate::lanes::Lanes;
use crate::special;

/// How the light runs through one fibre once it has entered at offset h, lengths in radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path<V> {
    /// h′ = h/η′ = sin γ_t, the offset of the refracted path from the axis.
    pub h_inside: V,
    /// γ_o = asin h.
    pub gamma_o: V,
    /// γ_t = asin h′.
    pub gamma_t: V,
    /// Half the path inside the cortex and half of that inside the medulla, in the normal plane.
    pub s_c: V,
    pub s_m: V,
    /// 1/cos θ_t: how much longer the inclined path is.
    pub elongation: V,
    pub fresnel: Fresnel<V>,
}

impl<V: Lanes> Path<V> {
    /// D2: elongation and η′ from θ_o, not from the half angle θ_d of the paper: the true path
    /// inside the fibre, and independent of ω_i.
    pub fn new(fiber: &Fiber, sin_o: V, cos_o: V, h: V) -> Self {
        let (zero, one) = (V::splat(0.0), V::splat(1.0));
        let eta = fiber.eta;
        let sin_t = sin_o * V::splat(1.0 / eta);
        let cos_t = ((one - sin_t) * (one + sin_t)).max(V::splat(1e-12)).sqrt();
        // 1/η′ = cos θ_o/√(η² − sin²θ_o), written so that neither η → 1 nor grazing light cancels.
        let excess = V::splat((eta - 1.0) * (eta + 1.0));
        let h_inside = h * cos_o / (excess + cos_o * cos_o).max(V::splat(1e-20)).sqrt();
        let cos_gamma_o = ((one - h) * (one + h)).max(zero).sqrt();
        let cos_gamma_t = ((one - h_inside) * (one + h_inside)).max(zero).sqrt();
        let kappa = V::splat(fiber.kappa);
        let offset = h_inside.abs();
        let s_m = ((kappa - offset) * (kappa + offset)).max(zero).sqrt();
        let [gamma_o, gamma_t] = V::each2([h, h_inside], [cos_gamma_o, cos_gamma_t], special::atan2);
        Path {
            h_inside,
            gamma_o,
            gamma_t,
            s_c: (cos_gamma_t - s_m).max(zero),
            s_m,
            elongation: one / cos_t,
            fresnel: fresnel(eta, fiber.layers, cos_o * cos_gamma_o),
        }
    }

    /// Φₚ(h), the exit azimuth of R, TT, TRT relative to ω_o.
    #[doc(alias = "Eq. 15")]
    pub fn exit_azimuth(&self, p: u8) -> V {
        let p = f32::from(p);
        V::splat(2.0 * p) * self.gamma_t - V::splat(2.0) * self.gamma_o + V::splat(p * std::f32::consts::PI)
    }

    /// Φˢₚ(h), the azimuth opposite to the light's travel in its p-th pass (p = 1, 2): where
    /// the tables' φ = 0, straight back, points.
    #[doc(alias = "Eq. 21")]
    pub fn scattered_azimuth(&self, p: u8) -> V {
        let q = f32::from(p - 1);
        self.gamma_t - self.gamma_o + V::splat(q) * (V::splat(std::f32::consts::PI) + V::splat(2.0) * self.gamma_t)
    }

    /// A(h) of the six lobes in RGB, in the order of [`crate::Lobe`]; `mean_path` is ⟨L⟩ of the
    /// light scattered in this pass (used where there is any).
    #[doc(alias = "Table 3")]
    pub fn attenuation(&self, fiber: &Fiber, mean_path: V) -> [[V; 3]; 6] {
        let (zero, one) = (V::splat(0.0), V::splat(1.0));
        let two = V::splat(2.0);
        let Fresnel { reflected: f, transmitted: t } = self.fresnel;
        let sigma_ca = fiber.sigma_ca.map(V::splat);
        let sigma_ma = fiber.sigma_ma.map(V::splat);
        let sigma_ms = V::splat(fiber.sigma_ms);
        let kappa = V::splat(fiber.kappa);
        let minus = -self.elongation;
        let pass = |c: usize| two * (self.s_c * sigma_ca[c] + self.s_m * (sigma_ma[c] + sigma_ms)) * minus;
        // Entry through the cortex, and D7: absorption after scattering over the mean scattered
        // path ⟨L⟩ instead of the paper's fixed κ.
        let escape = |c: usize| {
            ((self.s_c + one - kappa) * sigma_ca[c] + kappa * mean_path * sigma_ma[c]) * minus
        };
        let unscattered = two * self.s_m * sigma_ms * minus;
        let e = V::each([pass(0), pass(1), pass(2), escape(0), escape(1), escape(2), unscattered], special::exp);
        // D5: Q, the scattered fraction of one pass, is explicit; the distributions are densities.
        let q = unscattered_complement(unscattered, e[6]);

        let mut a = [[zero; 3]; 6];
        for c in 0..3 {
            let pass = e[c];
            let again = f * pass;
            // (1−F)/(1−F T): at most 1, and 1 − F T ≥ 1 − F is not formed by cancellation.
            let series = t / (t + f * (one - pass)).max(V::splat(1e-20));
            let tts = t * e[3 + c] * q;
            let trts = tts * again;
            a[0][c] = f;
            a[1][c] = t * t * pass;
            a[2][c] = a[1][c] * again;
            // D4: (1 − F) as in Yan17 Eq. 20; Table 3 prints F.
            a[3][c] = tts;
            a[4][c] = trts;
            // D6: all higher orders in closed form.
            a[5][c] = t * pass * again * again * series + e[3 + c] * q * again * again * series;
        }
        a
    }
}

/// 1 − eˣ for x ≤ 0, given `exp_x` = eˣ, without cancellation near 0.
fn unscattered_complement<V: Lanes>(x: V, exp_x: V) -> V {
    let series = -x * (V::splat(1.0) + x * (V::splat(0.5) + x * V::splat(1.0 / 6.0)));
    // At |x| = 0.02 the series is exact to x³/24 = 3e-7 and the difference to 6e-8/0.02 = 3e-6.
    (-x).select_lt(V::splat(0.02), series, V::splat(1.0) - exp_x)
}
