//! S. R. Marschner, H. W. Jensen, M. Cammarano, S. Worley, P. Hanrahan 2003, *Light Scattering from Human Hair Fibers*,
//! ACM TOG 22(3).
//!
//! A far-field model: it ignores the window. S = Σ M_p N_p/cos²θ_d for R, TT and TRT, with a smooth cross section.
//! Light leaves at φ from the roots of Φ_p(h) = φ, with the cubic approximation in γ of the paper and the density |2
//! dΦ/dh|⁻¹. The density is infinite at the caustics of TRT. There, the paper replaces the light within the width of a
//! Gaussian by a Gaussian. The constants are those of the paper, Δη′ = 0.2 and Δh ≤ 0.5, and k_G = ½, which conserves
//! the energy of an isolated caustic.
//!
//! The model uses these parameters of a [`Fiber`]: η, σ_c,a, α and β_m. Shifts and widths in the paper are in the half
//! angle θ_h, so they are half of those here. The paper's unit Gaussian in θ_h would have twice the light, so the
//! Gaussian here is normalised in θᵢ. The width w_c of the caustic is √3 β_n, the width of TRT in `vellus`. T is
//! exp(−2σ cos γ_t/cos θ_t), where the paper prints 1 + cos 2γ_t. κ, σ_m, g and l are ignored.
//!
//! The model is reciprocal for α = 0. Limits: it has no higher orders. Energy is lost or gained where Gaussians are
//! near ±90° (cos²θᵢ/cos²θ_d), and at the caustics: TRT of hair, whose caustics are 40° apart, keeps 0.6 of its light.
//! Tests measure both. Below η = 1.155 the cubic has caustics in TT that are not smoothed. The azimuth of TRT is
//! sampled uniformly.

mod section;

use crate::factored::{choose, direction, weight};
use crate::longitudinal::{Longitudinal, Plane};
use glam::Vec3;
use section::Section;
use std::f32::consts::{FRAC_1_PI, TAU};
use std::f64::consts::PI;
use vellus::parts::{Frame, Outgoing, Polar, wrap};
use vellus::{Error, Fiber, Lobe, Lobes, Model, Sample, Scattering, Window, WindowSupport};
use wide::f32x8;

const LOBES: [Lobe; 3] = [Lobe::R, Lobe::Tt, Lobe::Trt];

/// Number of azimuths of incidence on one side for the sum of energies. It is enough for caustics of 2°.
const GAMMAS: usize = 32;

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct Marschner2003 {
    eta: f64,
    sigma_a: [f32; 3],
    shift: f32x8,
    sigma: f32x8,
    caustic: f64,
}

impl Marschner2003 {
    /// The model of a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let fiber = &fiber.in_air();
        let lanes = |of: [f32; 3]| f32x8::new(std::array::from_fn(|i| of[i.min(2)]));
        Ok(Marschner2003 {
            eta: fiber.eta.into(),
            sigma_a: fiber.sigma_ca,
            shift: lanes([1.0, -0.5, -1.5].map(|k| k * fiber.alpha)),
            sigma: lanes([1.0, 0.5, 1.5].map(|k| k * fiber.beta_m)),
            caustic: 3f64.sqrt() * f64::from(fiber.beta_n),
        })
    }

    /// ∫ N_p dφ at θ_d, RGB. This is a mean over h, because light of each offset leaves at one azimuth.
    fn energy(&self, p: usize, theta_d: f64) -> [f64; 3] {
        let section = Section::new(self.eta, theta_d);
        let (cubic, caustic) = (section.cubic(2.0), section.caustic(self.caustic));
        let put_back = if p == 2 { caustic.energy() } else { 0.0 };
        let mut sum = section.attenuation(p, caustic.gamma, self.sigma_a).map(|a| a * put_back);
        // The midpoint rule in γ. The sides h and −h are the same.
        for k in 0..GAMMAS {
            let step = 0.5 * PI / GAMMAS as f64;
            let gamma = (k as f64 + 0.5) * step;
            let kept = if p == 2 { caustic.kept(cubic.at(gamma)) } else { 1.0 };
            let a = section.attenuation(p, gamma, self.sigma_a);
            (0..3).for_each(|c| sum[c] += a[c] * kept * gamma.cos() * step);
        }
        sum
    }
}

/// A hit of the fibre.
#[derive(Clone, Copy, Debug)]
pub struct Marschner2003Hit<'m> {
    model: &'m Marschner2003,
    frame: Frame<f32>,
    theta_o: f32,
    longitudinal: Plane,
    probability: [f32; 3],
}

impl Model for Marschner2003 {
    type Hit<'a> = Marschner2003Hit<'a>;

    fn at(&self, wo: Vec3, _: Window) -> Marschner2003Hit<'_> {
        let wo = wo.to_array();
        let polar = Polar::new(wo);
        let theta_o = polar.sin.atan2(polar.cos);
        let section = Section::new(self.eta, theta_o.into());
        // The mean of A over h, by four Gauss points on one side.
        const GAUSS: [(f64, f64); 4] = [
            (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
            (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
            (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
            (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
        ];
        let mean = |p: usize| -> f32 {
            GAUSS
                .iter()
                .map(|&(h, w)| section.attenuation(p, h.asin(), self.sigma_a).into_iter().fold(0.0, f64::max) * w)
                .sum::<f64>() as f32
        };
        let longitudinal = Plane::new(f32x8::splat(-theta_o) - self.shift, self.sigma);
        // A lobe whose Gaussian is mostly beyond a pole has little light. Its truncated Gaussian also has few digits.
        let inside = longitudinal.inside().to_array();
        let probability = std::array::from_fn::<f32, 3, _>(|p| mean(p).max(1e-12) * inside[p]);
        let scale = 1.0 / probability.iter().sum::<f32>();
        Marschner2003Hit {
            model: self,
            frame: Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12)),
            theta_o,
            longitudinal,
            probability: probability.map(|p| p * scale),
        }
    }

    fn field(&self) -> WindowSupport {
        WindowSupport::Far
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        Self::new(fiber)
    }
}

impl Marschner2003Hit<'_> {
    fn section(&self, theta_i: f32) -> (Section, f64) {
        let theta_d = 0.5 * f64::from(theta_i - self.theta_o);
        (Section::new(self.model.eta, theta_d), theta_d)
    }

    fn eval_outgoing(&self, o: &Outgoing<f32>) -> (Lobes, f32) {
        let (section, theta_d) = self.section(o.theta_i);
        let phi = f64::from(wrap(o.phi));
        let (longitudinal, inside) = (self.longitudinal.eval(o).to_array(), self.longitudinal.inside().to_array());
        // M cos θᵢ/cos²θ_d from the normalised density with respect to sin θᵢ, g/(inside·cos θᵢ).
        let geometry = (o.cos_i / theta_d.cos().max(1e-6) as f32).powi(2);
        let mut lobes = Lobes::default();
        let mut pdf = 0.0;
        for p in 0..3 {
            let (smooth, all) = if p < 2 { section.smooth(p, phi, self.model.sigma_a) } else { ([0.0; 3], 0.0) };
            let n = if p < 2 { smooth } else { section.trt(phi, self.model.sigma_a, self.model.caustic) };
            let azimuthal = if p < 2 { all as f32 } else { 0.5 * FRAC_1_PI };
            let m = longitudinal[p] * inside[p] * geometry;
            lobes.0[LOBES[p] as usize] = n.map(|n| m * n as f32);
            pdf += self.probability[p] * longitudinal[p] * azimuthal;
        }
        (lobes, pdf)
    }
}

impl Scattering for Marschner2003Hit<'_> {
    fn energy(&self) -> Lobes {
        let inside = self.longitudinal.inside().to_array();
        let mut lobes = Lobes::default();
        let n = 16;
        for k in 0..n {
            let u = (k as f32 + 0.5) / n as f32;
            for p in 0..3 {
                let (sin_i, cos_i) = self.longitudinal.sample(p, [u, 0.5]);
                let (_, theta_d) = self.section(sin_i.atan2(cos_i));
                let geometry = (cos_i / theta_d.cos().max(1e-6) as f32).powi(2) * inside[p] / n as f32;
                let energy = self.model.energy(p, theta_d);
                (0..3).for_each(|c| lobes.0[LOBES[p] as usize][c] += energy[c] as f32 * geometry);
            }
        }
        lobes
    }

    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_outgoing(&self.frame.outgoing(wi.to_array()))
    }

    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        let (p, _) = choose(&self.probability, u[0]);
        let (sin_i, cos_i) = self.longitudinal.sample(p, [u[1], u[2]]);
        let theta_i = sin_i.atan2(cos_i);
        // R and TT are sampled from a uniform offset h = sin γ.
        let gamma = f64::from(2.0 * u[3] - 1.0).asin();
        let phi = match p {
            0 => -2.0 * gamma as f32,
            1 => (self.section(theta_i).0.cubic(1.0).at(gamma) + PI) as f32,
            _ => TAU * u[3],
        };
        let outgoing = Outgoing { sin_i, cos_i, theta_i, phi };
        let (lobes, pdf) = self.eval_outgoing(&outgoing);
        let weight = weight(lobes.total(), pdf);
        Sample::new(direction(&self.frame, &outgoing), pdf, weight, LOBES[p])
    }
}
