//! J. T. Kajiya, T. L. Kay 1989, *Rendering Fur with Three Dimensional Textures*, SIGGRAPH 89.
//!
//! A far-field model: it ignores the window. Ψ = K_d sin(t, l) + K_s cosⁿ(θᵢ + θ_o): a diffuse cylinder and a specular
//! cone, both uniform in azimuth. With the conventions of [`vellus`], f·cos θᵢ = k_d cos θᵢ/π² + k_s cosⁿ(θᵢ +
//! θ_o)/2πZ. Z = ∫ cosⁿ⁺¹ makes k_d and k_s the albedos at normal incidence.
//!
//! The model has no refraction. n is 1/β_m². k_s is the far-field energy of R in the `vellus` model at normal
//! incidence. k_d is the energy of all other lobes, so brightness and colour match.
//!
//! Limits: no forward scattering (TT), no secondary highlight, no shift of highlights. The specular part is not
//! normalised: at grazing incidence, about cos θ_o of its light remains. The model is not reciprocal.

use crate::factored::{direction, weight};
use crate::longitudinal::{Longitudinal, Plane};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;
use vellus::parts::{Frame, Outgoing, Polar};
use vellus::{Bcsdf, Error, Fiber, Lobe, Lobes, Model, Sample, Scattering, Window, WindowSupport};
use wide::f32x8;

/// Number of nodes of |θ_o| in the table of the specular energy.
const THETAS: usize = 91;
/// Number of points of the integral over θᵢ.
const NODES: usize = 256;

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct KajiyaKay1989 {
    diffuse: [f32; 3],
    specular: [f32; 3],
    exponent: f32,
    sigma: f32,
    /// 1/2πZ
    norm: f32,
    /// Specular energy by |θ_o|, relative to that at 0.
    shares: Arc<[f32]>,
}

impl KajiyaKay1989 {
    /// The model of a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        let fiber = &fiber.in_air();
        let [diffuse, specular] = albedos(fiber)?;
        let exponent = f64::from(fiber.beta_m).powi(-2);
        // ∫ cosⁿ(θᵢ + θ_o) cos θᵢ dθᵢ by the midpoint rule, within ten standard deviations.
        let z = |theta_o: f64| -> f64 {
            let reach = (10.0 * f64::from(fiber.beta_m)).min(FRAC_PI_2);
            let (low, high) = ((-theta_o - reach).max(-FRAC_PI_2), (-theta_o + reach).min(FRAC_PI_2));
            let step = (high - low) / NODES as f64;
            (0..NODES)
                .map(|k| low + (k as f64 + 0.5) * step)
                .map(|theta| (theta + theta_o).cos().max(0.0).powf(exponent) * theta.cos() * step)
                .sum()
        };
        let z0 = z(0.0);
        let share = |k: usize| (z(k as f64 / (THETAS - 1) as f64 * FRAC_PI_2) / z0) as f32;
        Ok(KajiyaKay1989 {
            diffuse,
            specular,
            exponent: exponent as f32,
            sigma: fiber.beta_m,
            norm: (1.0 / (2.0 * PI * z0)) as f32,
            shares: (0..THETAS).map(share).collect(),
        })
    }
}

/// k_d and k_s.
fn albedos(fiber: &Fiber) -> Result<[[f32; 3]; 2], Error> {
    let energy = Bcsdf::new(fiber)?.at(Vec3::Y, Window::far()).energy();
    let (total, specular) = (energy.total(), energy[Lobe::R]);
    Ok([[0, 1, 2].map(|c| total[c] - specular[c]), specular])
}

/// A hit of the fibre.
#[derive(Clone, Copy, Debug)]
pub struct KajiyaKay1989Hit<'m> {
    model: &'m KajiyaKay1989,
    frame: Frame<f32>,
    theta_o: f32,
    /// The Gaussian that samples the specular part. It is an upper bound of cosⁿ, up to scale.
    longitudinal: Plane,
    share: f32,
    /// Probability of sampling the specular part.
    probability: f32,
}

impl Model for KajiyaKay1989 {
    type Hit<'a> = KajiyaKay1989Hit<'a>;

    fn at(&self, wo: Vec3, _: Window) -> KajiyaKay1989Hit<'_> {
        let wo = wo.to_array();
        let polar = Polar::new(wo);
        let theta_o = polar.sin.atan2(polar.cos);
        let x = theta_o.abs() / std::f32::consts::FRAC_PI_2 * (THETAS - 1) as f32;
        let i = (x as usize).min(THETAS - 2);
        let share = self.shares[i] + (x - i as f32) * (self.shares[i + 1] - self.shares[i]);
        let largest = |c: [f32; 3]| c[0].max(c[1]).max(c[2]);
        let (s, d) = (largest(self.specular) * share, largest(self.diffuse));
        KajiyaKay1989Hit {
            model: self,
            frame: Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12)),
            theta_o,
            longitudinal: Plane::new(f32x8::splat(-theta_o), f32x8::splat(self.sigma)),
            share,
            probability: if s + d > 0.0 { s / (s + d) } else { 0.0 },
        }
    }

    fn field(&self) -> WindowSupport {
        WindowSupport::Far
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        if fiber.beta_m != self.sigma {
            return Self::new(fiber);
        }
        let [diffuse, specular] = albedos(fiber)?;
        Ok(KajiyaKay1989 { diffuse, specular, shares: Arc::clone(&self.shares), ..*self })
    }
}

impl KajiyaKay1989Hit<'_> {
    fn eval_outgoing(&self, o: &Outgoing<f32>) -> (Lobes, f32) {
        let model = self.model;
        let specular = (o.theta_i + self.theta_o).cos().max(0.0).powf(model.exponent) * model.norm;
        let diffuse = o.cos_i * (FRAC_1_PI * FRAC_1_PI);
        let mut lobes = Lobes::default();
        lobes[Lobe::R] = model.specular.map(|k| k * specular);
        lobes[Lobe::Rest] = model.diffuse.map(|k| k * diffuse);
        let cone = self.longitudinal.eval(o).to_array()[0] * (0.5 * FRAC_1_PI);
        (lobes, self.probability * cone + (1.0 - self.probability) * diffuse)
    }
}

impl Scattering for KajiyaKay1989Hit<'_> {
    fn energy(&self) -> Lobes {
        let mut lobes = Lobes::default();
        lobes[Lobe::R] = self.model.specular.map(|k| k * self.share);
        lobes[Lobe::Rest] = self.model.diffuse;
        lobes
    }

    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_outgoing(&self.frame.outgoing(wi.to_array()))
    }

    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        let specular = u[0] < self.probability;
        let (sin_i, cos_i) = if specular {
            self.longitudinal.sample(0, [u[1], u[2]])
        } else {
            // sin θᵢ of a Lambertian cylinder is a coordinate of a point in the unit disk.
            let sin_i = u[1].sqrt() * (TAU * u[2]).cos();
            (sin_i, ((1.0 - sin_i) * (1.0 + sin_i)).max(0.0).sqrt())
        };
        let outgoing = Outgoing { sin_i, cos_i, theta_i: sin_i.atan2(cos_i), phi: TAU * u[3] };
        let (lobes, pdf) = self.eval_outgoing(&outgoing);
        let weight = weight(lobes.total(), pdf);
        let lobe = if specular { Lobe::R } else { Lobe::Rest };
        Sample::new(direction(&self.frame, &outgoing), pdf, weight, lobe)
    }
}
