//! C^M of one hit, as a density over the inclination at which light leaves the fibre.

use super::{Exact, Profile, fresnel};
use std::f64::consts::PI;

/// Points of the quadrature over sin θᵢ.
const POINTS: usize = 4000;

/// C^M of the backward and the forward half for one θ_o.
#[derive(Clone, Debug)]
pub(crate) struct Inclination {
    /// −1 if θ_o < 0: (θ_o, θᵢ) → (−θ_o, −θᵢ).
    tilt: f64,
    profiles: [Profile; 2],
    refraction: Option<Refraction>,
    /// The share of each half that leaves the fibre.
    leaving: [f64; 2],
}

/// D18: how the cuticle refracts scattered light.
#[derive(Clone, Copy, Debug)]
struct Refraction {
    /// That of the medulla.
    eta: f64,
    /// b of the transmittance T(s) = 1 − b s⁴.
    loss: f64,
    /// What absorption in the medulla leaves of each half, up to a common factor.
    kept: [f64; 2],
}

impl Refraction {
    /// C^M(θ′) T(sin θᵢ)/η of one half at sin θᵢ, with absorption.
    fn eval(&self, profiles: &[Profile; 2], half: usize, sin_i: f64) -> f64 {
        let inside = (sin_i / self.eta).clamp(-1.0, 1.0).asin();
        self.kept[half] * profiles[half].eval(inside) * (1.0 - self.loss * sin_i.powi(4)).max(0.0) / self.eta
    }
}

impl Inclination {
    /// The shares of the backward and the forward half that leave the fibre.
    pub fn leaving(&self) -> [f64; 2] {
        self.leaving
    }

    /// Densities in sin θᵢ of the backward and the forward half. They integrate to the shares that leave.
    pub fn eval(&self, theta_i: f64) -> [f64; 2] {
        let theta_i = self.tilt * theta_i;
        [0, 1].map(|half| match &self.refraction {
            None => self.profiles[half].eval(theta_i),
            Some(refraction) => refraction.eval(&self.profiles, half, theta_i.sin()),
        })
    }
}

impl Exact<'_> {
    /// C^M of the backward and the forward half. D12: τ without the elongation.
    pub(crate) fn inclination(&self, theta_o: f64) -> Inclination {
        let tilt = if theta_o < 0.0 { -1.0 } else { 1.0 };
        let profiles = |theta: f64| Profile::longitudinal(self.tables, self.sigma_ms * self.kappa, self.g, theta);
        if self.exit.is_none() {
            return Inclination { tilt, profiles: profiles(theta_o.abs()), refraction: None, leaving: [1.0; 2] };
        }
        let profiles = profiles((theta_o.abs().sin() / self.eta_m).asin());
        let refraction = Refraction { eta: self.eta_m, loss: self.loss(), kept: self.kept_by_half() };
        let mut leaving = [0.0; 2];
        // Midpoint rule in t with sin θᵢ = sin t, dense near grazing.
        let step = PI / POINTS as f64;
        for k in 0..POINTS {
            let t = (k as f64 + 0.5) * step - 0.5 * PI;
            for (half, leaving) in leaving.iter_mut().enumerate() {
                *leaving += refraction.eval(&profiles, half, t.sin()) * t.cos() * step;
            }
        }
        Inclination { tilt, profiles, refraction: Some(refraction), leaving }
    }

    /// What absorption in the medulla leaves of the forward half, over what it leaves of the backward half, is the
    /// mean over channels in a formula that `medulla/cone.rs` of `vellus` explains.
    fn kept_by_half(&self) -> [f64; 2] {
        let isotropic = self.sigma_ms * self.kappa * (1.0 - self.g);
        let a = self.sigma_ma.map(|sigma| (sigma * self.kappa).min(2.0)).iter().sum::<f64>() / 3.0;
        let difference = 0.61 + 4.49 * isotropic / (7.06 + isotropic) - 1.46 * self.g + 0.263 * a;
        [1.0, (-a * difference / (1.0 + 0.608 * a * isotropic)).exp()]
    }

    /// b: the least-squares fit of c (1 − b s⁴) over s = sin θᵢ in [0, 1] to the transmittance at four Gauss points,
    /// averaged over offsets that are uniform in the medulla.
    fn loss(&self) -> f64 {
        let (near, far) =
            ((3.0 / 7.0 - 2.0 / 7.0 * 1.2f64.sqrt()).sqrt(), (3.0 / 7.0 + 2.0 / 7.0 * 1.2f64.sqrt()).sqrt());
        let (heavy, light) = ((18.0 + 30f64.sqrt()) / 72.0, (18.0 - 30f64.sqrt()) / 72.0);
        // ∫ T ds and ∫ T s⁴ ds.
        let (mut zeroth, mut fourth) = (0.0, 0.0);
        for (x, weight) in [(-far, light), (-near, heavy), (near, heavy), (far, light)] {
            let s = 0.5 + 0.5 * x;
            let transmittance = self.transmittance(s.asin());
            zeroth += weight * transmittance;
            fourth += weight * transmittance * s.powi(4);
        }
        // The normal equations: c − c b/5 = ∫ T ds and c/5 − c b/9 = ∫ T s⁴ ds.
        let determinant = -1.0 / 9.0 + 1.0 / 25.0;
        let constant = (-zeroth / 9.0 + fourth / 5.0) / determinant;
        let slope = (fourth - zeroth / 5.0) / determinant;
        if constant > 0.0 { (slope / constant).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The share of light that leaves at θᵢ, of all light that the medulla sends toward the cuticle at that inclination
    /// and with offsets uniform in [0, κ], by two Gauss points.
    fn transmittance(&self, theta_i: f64) -> f64 {
        let prime = (self.eta_m * self.eta_m - theta_i.sin().powi(2)).sqrt() / theta_i.cos();
        // The largest offset outside, h = η′ h′.
        let most = (self.kappa * prime).min(1.0);
        let root = 1.0 / 3f64.sqrt();
        let sum: f64 = [0.5 - 0.5 * root, 0.5 + 0.5 * root]
            .into_iter()
            .map(|t| {
                let (h, dh) = (most * t * (2.0 - t), most * 2.0 * (1.0 - t));
                let offset = (h / prime / self.kappa).min(1.0);
                let at_wall = (1.0 - offset * offset).sqrt() / self.medulla_elongation(theta_i);
                let wall = if self.eta_m < self.eta { fresnel(self.eta / self.eta_m, 0.5, at_wall) } else { 0.0 };
                let cuticle = fresnel(self.eta, self.layers, theta_i.cos() * (1.0 - h * h).sqrt());
                (1.0 - cuticle) * (1.0 - wall) * dh * 0.5
            })
            .sum();
        sum / (prime * self.kappa)
    }
}
