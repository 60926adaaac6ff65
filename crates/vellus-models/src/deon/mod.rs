//! E. d'Eon, G. Francois, M. Hill, J. Letteri, J.-M. Aubry 2011, *An Energy-Conserving Hair Reflectance Model*,
//! Computer Graphics Forum 30(4); sampling after d'Eon, Marschner, Hanika 2013.
//!
//! A far-field model: it ignores the window. The longitudinal lobe is the spherical Gaussian M̂, which integrates to 1
//! at every angle. The azimuthal lobe is that of a rough surface: N_p(φ) = ½ ∫ A_p(h) G(φ − Φ_p(h); √(p+1) β_n) dh. It
//! is tabulated over φ and θ_d, by quadrature in asin h with a step that depends on the width of the lobe. This takes
//! about 10 ms per channel. The paper uses 70 Gauss points per query, or a table. If only the colour varies between
//! fibres, they interpolate between shared tables of 32 absorptions. Fresnel reflectance and absorption are those at
//! θ_d, as in the paper.
//!
//! The lobes are R, TT, TRT and TRRT, and TRRT is the rest lobe. The model uses these parameters of a [`Fiber`]: η,
//! σ_c,a, α, β_m and β_n (shifts and widths of Yan17 Table 2). κ, σ_m, g and l are ignored.
//!
//! Limits: below β_n = 0.3° the table is too coarse. The missing orders have (1 − F) F³ T³ of the light. Attenuation is
//! computed at θ_d, which varies over a lobe, so energy is only conserved to second order in β_m. For α = 0, M̂ N is
//! symmetric in the directions.

mod azimuths;
mod channels;

use crate::factored::{choose, direction, weight};
use crate::longitudinal::{Longitudinal, Spherical, SphericalAt};
use azimuths::Azimuths;
use channels::Channels;
use glam::Vec3;
use vellus::parts::{Frame, Outgoing, Polar, wrap};
use vellus::{Error, Fiber, Lobe, Lobes, Model, Sample, Scattering, Window, WindowSupport};

const LOBES: [Lobe; 4] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Rest];

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct DEon2011 {
    longitudinal: Spherical,
    channels: Channels,
}

impl DEon2011 {
    /// The model of a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if [`Fiber::validate`] returns it.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let fiber = &fiber.in_air();
        Ok(DEon2011 { longitudinal: longitudinal(fiber), channels: Channels::new(fiber) })
    }

    /// The energies: means over each lobe at 16 × 8 stratified samples.
    fn energy(&self, theta_o: f32) -> Lobes {
        let (sin, cos) = theta_o.sin_cos();
        let longitudinal = self.longitudinal.at(Polar { sin, cos: cos.max(0.0) });
        let mut lobes = Lobes::default();
        let (n, m) = (16, 8);
        for k in 0..n * m {
            let u = [((k / m) as f32 + 0.5) / n as f32, ((k % m) as f32 + 0.5) / m as f32];
            for p in 0..4 {
                let (sin_i, cos_i) = longitudinal.sample(p, u);
                let theta = Azimuths::theta(0.5 * (sin_i.atan2(cos_i) - theta_o));
                for (sum, channel) in lobes.0[LOBES[p] as usize].iter_mut().zip(&self.channels.rgb) {
                    *sum += channel.energy(p, theta) / (n * m) as f32;
                }
            }
        }
        lobes
    }
}

fn longitudinal(fiber: &Fiber) -> Spherical {
    let lanes = |of: [f32; 4]| std::array::from_fn(|i| of[i.min(3)]);
    Spherical::new(
        lanes([1.0, -0.5, -1.5, -2.5].map(|k| k * fiber.alpha)),
        lanes([1.0, 0.5, 1.5, 2.5].map(|k| k * fiber.beta_m)),
    )
}

/// A hit of the fibre.
#[derive(Clone, Copy, Debug)]
pub struct DEon2011Hit<'m> {
    model: &'m DEon2011,
    frame: Frame<f32>,
    theta_o: f32,
    longitudinal: SphericalAt<'m>,
    probability: [f32; 4],
}

impl Model for DEon2011 {
    type Hit<'a> = DEon2011Hit<'a>;

    #[inline]
    fn at(&self, wo: Vec3, _: Window) -> DEon2011Hit<'_> {
        let wo = wo.to_array();
        let polar = Polar::new(wo);
        let theta_o = polar.sin.atan2(polar.cos);
        // At the centres of the lobes, θ_d is θ_o.
        let brightest = &self.channels.rgb[self.channels.brightest];
        let probability = [0, 1, 2, 3].map(|p| brightest.energy(p, Azimuths::theta(theta_o)));
        let scale = 1.0 / probability.iter().sum::<f32>();
        DEon2011Hit {
            model: self,
            frame: Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12)),
            theta_o,
            longitudinal: self.longitudinal.at(polar),
            probability: probability.map(|p| p * scale),
        }
    }

    fn field(&self) -> WindowSupport {
        WindowSupport::Far
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let shared = self.channels.with_fiber(fiber);
        Ok(DEon2011 { longitudinal: longitudinal(fiber), channels: shared.unwrap_or_else(|| Channels::new(fiber)) })
    }
}

impl DEon2011Hit<'_> {
    #[inline(always)]
    fn eval_outgoing(&self, o: &Outgoing<f32>) -> (Lobes, f32) {
        let channels = &self.model.channels;
        let theta = Azimuths::theta(0.5 * (o.theta_i - self.theta_o));
        let phi = wrap(o.phi);
        let longitudinal = self.longitudinal.eval(o).to_array();
        let mut lobes = Lobes::default();
        let mut pdf = 0.0;
        for p in 0..4 {
            let n = [0, 1, 2].map(|c| channels.rgb[c].eval(p, theta, phi));
            lobes.0[LOBES[p] as usize] = n.map(|n| n * longitudinal[p]);
            let brightest = channels.brightest;
            pdf += self.probability[p] * longitudinal[p] * n[brightest] / channels.rgb[brightest].energy(p, theta);
        }
        (lobes, pdf)
    }
}

impl Scattering for DEon2011Hit<'_> {
    fn energy(&self) -> Lobes {
        self.model.energy(self.theta_o)
    }

    #[inline]
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_outgoing(&self.frame.outgoing(wi.to_array()))
    }

    #[inline]
    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        let (p, _) = choose(&self.probability, u[0]);
        let (sin_i, cos_i) = self.longitudinal.sample(p, [u[1], u[2]]);
        let theta_i = sin_i.atan2(cos_i);
        let channels = &self.model.channels;
        let theta = Azimuths::theta(0.5 * (theta_i - self.theta_o));
        let phi = channels.rgb[channels.brightest].sample(p, theta, [u[3], u[4]]);
        let outgoing = Outgoing { sin_i, cos_i, theta_i, phi };
        let (lobes, pdf) = self.eval_outgoing(&outgoing);
        let weight = weight(lobes.total(), pdf);
        Sample::new(direction(&self.frame, &outgoing), pdf, weight, LOBES[p])
    }
}
