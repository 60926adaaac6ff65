//! A hit whose lobes are products of energy, longitudinal density and azimuthal density. Eight lobes fill a register.

use crate::azimuthal::Azimuthal;
use crate::longitudinal::Longitudinal;
use glam::Vec3;
use vellus::parts::{self, Frame, Outgoing};
use vellus::{Lobe, Lobes, Sample, Scattering};
use wide::f32x8;

/// Energies of eight lobes, one row per channel.
pub(crate) type Energies = [[f32; 8]; 3];

/// A hit with eight lobes. `L` has the longitudinal and `A` the azimuthal densities.
#[derive(Clone, Copy, Debug)]
pub struct Factored<L, A> {
    pub(crate) frame: Frame<f32>,
    energy: Energies,
    probability: f32x8,
    pub(crate) longitudinal: L,
    pub(crate) azimuthal: A,
    /// The lobe of [`Lobes`] that each of the eight adds to.
    names: &'static [Lobe; 8],
}

/// The largest channel of each lobe. Probabilities in proportion to it bound the weights of all channels.
#[inline(always)]
pub(crate) fn largest_channel(energy: &Energies) -> [f32; 8] {
    std::array::from_fn(|i| energy[0][i].max(energy[1][i]).max(energy[2][i]))
}

/// Selects an item in proportion to its weight, never one with weight 0. Also returns `u` rescaled to a uniform number.
#[inline(always)]
pub(crate) fn choose(weights: &[f32], u: f32) -> (usize, f32) {
    let target = u * weights.iter().sum::<f32>();
    parts::choose(weights.iter().copied().enumerate(), target)
        .map_or((0, 0.0), |choice| (choice.item, choice.fraction().clamp(0.0, 1.0)))
}

/// The sample weight f·cos θᵢ/pdf, or 0 if both underflow.
#[inline(always)]
pub(crate) fn weight(total: [f32; 3], pdf: f32) -> [f32; 3] {
    if pdf > f32::MIN_POSITIVE { total.map(|f| f / pdf) } else { [0.0; 3] }
}

impl<L: Longitudinal, A: Azimuthal> Factored<L, A> {
    #[inline(always)]
    pub(crate) fn new(
        frame: Frame<f32>,
        energy: Energies,
        longitudinal: L,
        azimuthal: A,
        names: &'static [Lobe; 8],
    ) -> Self {
        let probability = f32x8::new(largest_channel(&energy));
        let scale = 1.0 / probability.reduce_add().max(f32::MIN_POSITIVE);
        Factored { frame, energy, probability: probability * f32x8::splat(scale), longitudinal, azimuthal, names }
    }

    /// Energies of all lobes.
    #[inline(always)]
    pub(crate) fn energies(&self) -> &Energies {
        &self.energy
    }

    /// Densities of all lobes per solid angle.
    #[inline(always)]
    pub(crate) fn densities(&self, o: &Outgoing<f32>) -> f32x8 {
        self.longitudinal.eval(o) * self.azimuthal.eval(o.phi)
    }

    /// The pdf of the whole hit.
    #[inline(always)]
    pub(crate) fn pdf_of(&self, densities: f32x8) -> f32 {
        (densities * self.probability).reduce_add()
    }

    #[inline(always)]
    pub(crate) fn lobes_of(&self, densities: f32x8) -> Lobes {
        let d = densities.to_array();
        let mut lobes = Lobes::default();
        for (i, name) in self.names.iter().enumerate() {
            (0..3).for_each(|c| lobes.0[*name as usize][c] += self.energy[c][i] * d[i]);
        }
        lobes
    }

    /// Samples a direction of one lobe. The first two numbers determine θᵢ, the third φ.
    #[inline(always)]
    pub(crate) fn draw(&self, lane: usize, u: [f32; 3]) -> Outgoing<f32> {
        let (sin_i, cos_i) = self.longitudinal.sample(lane, [u[0], u[1]]);
        Outgoing { sin_i, cos_i, theta_i: sin_i.atan2(cos_i), phi: self.azimuthal.sample(lane, u[2]) }
    }
}

/// The unit vector of a sampled direction.
#[inline(always)]
pub(crate) fn direction(frame: &Frame<f32>, o: &Outgoing<f32>) -> Vec3 {
    Vec3::from_array(frame.direction(o.sin_i, o.cos_i, o.phi.sin_cos()))
}

impl<L: Longitudinal, A: Azimuthal> Scattering for Factored<L, A> {
    fn energy(&self) -> Lobes {
        self.lobes_of(f32x8::ONE)
    }

    #[inline]
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        let densities = self.densities(&self.frame.outgoing(wi.to_array()));
        (self.lobes_of(densities), self.pdf_of(densities))
    }

    #[inline]
    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        let (lane, _) = choose(&self.probability.to_array(), u[0]);
        let outgoing = self.draw(lane, [u[1], u[2], u[3]]);
        let densities = self.densities(&outgoing);
        let pdf = self.pdf_of(densities);
        let weight = weight(self.lobes_of(densities).total(), pdf);
        Sample::new(direction(&self.frame, &outgoing), pdf, weight, self.names[lane])
    }
}
