//! A hit whose lobes are products: energy, density along the fibre, density around it. Eight fill a register.

use crate::azimuthal::Around;
use crate::longitudinal::Along;
use glam::Vec3;
use vellus::parts::{self, Frame, Outgoing};
use vellus::{Lobe, Lobes, Sample, Scattering};
use wide::f32x8;

/// Energies of eight lobes, one row a channel.
pub(crate) type Energies = [[f32; 8]; 3];

/// Eight lobes of one hit.
#[derive(Clone, Copy, Debug)]
pub struct Factored<L, A> {
    pub(crate) frame: Frame<f32>,
    energy: Energies,
    probability: f32x8,
    pub(crate) along: L,
    pub(crate) around: A,
    /// Which of the six each of the eight belongs to.
    names: &'static [Lobe; 8],
}

/// Probabilities in proportion to the largest channel: then no channel's weight exceeds their sum.
#[inline(always)]
pub(crate) fn largest_channel(energy: &Energies) -> [f32; 8] {
    std::array::from_fn(|i| energy[0][i].max(energy[1][i]).max(energy[2][i]))
}

/// The item that `u`, times the sum of the weights, falls to, never one without a weight; and what is left of `u`, again
/// uniform in [0, 1].
#[inline(always)]
pub(crate) fn choose(weights: &[f32], u: f32) -> (usize, f32) {
    let target = u * weights.iter().sum::<f32>();
    parts::choose(weights.iter().copied().enumerate(), target)
        .map_or((0, 0.0), |choice| (choice.item, choice.fraction().clamp(0.0, 1.0)))
}

/// A weight, f·cos θᵢ over the density, 0 where both underflow.
#[inline(always)]
pub(crate) fn weight(total: [f32; 3], pdf: f32) -> [f32; 3] {
    if pdf > f32::MIN_POSITIVE { total.map(|f| f / pdf) } else { [0.0; 3] }
}

impl<L: Along, A: Around> Factored<L, A> {
    #[inline(always)]
    pub(crate) fn new(frame: Frame<f32>, energy: Energies, along: L, around: A, names: &'static [Lobe; 8]) -> Self {
        let probability = f32x8::new(largest_channel(&energy));
        let scale = 1.0 / probability.reduce_add().max(f32::MIN_POSITIVE);
        Factored { frame, energy, probability: probability * f32x8::splat(scale), along, around, names }
    }

    /// The energies of all eight.
    #[inline(always)]
    pub(crate) fn energies(&self) -> &Energies {
        &self.energy
    }

    /// Densities of all eight over solid angle.
    #[inline(always)]
    pub(crate) fn densities(&self, o: &Outgoing<f32>) -> f32x8 {
        self.along.eval(o) * self.around.eval(o.phi)
    }

    /// The density of sampling one of the eight.
    #[inline(always)]
    pub(crate) fn pdf_of(&self, densities: f32x8) -> f32 {
        (densities * self.probability).reduce_add()
    }

    #[inline(always)]
    pub(crate) fn lobes_of(&self, densities: f32x8) -> Lobes {
        let d = densities.to_array();
        let mut lobes = Lobes([[0.0; 3]; 6]);
        for (i, name) in self.names.iter().enumerate() {
            (0..3).for_each(|c| lobes.0[*name as usize][c] += self.energy[c][i] * d[i]);
        }
        lobes
    }

    /// Draws from one of the eight: from `u`, two numbers for θᵢ and one for φ.
    #[inline(always)]
    pub(crate) fn draw(&self, lane: usize, u: [f32; 3]) -> Outgoing<f32> {
        let (sin_i, cos_i) = self.along.sample(lane, [u[0], u[1]]);
        Outgoing { sin_i, cos_i, theta_i: sin_i.atan2(cos_i), phi: self.around.sample(lane, u[2]) }
    }
}

/// The direction of what was drawn.
#[inline(always)]
pub(crate) fn direction(frame: &Frame<f32>, o: &Outgoing<f32>) -> Vec3 {
    Vec3::from_array(frame.direction(o.sin_i, o.cos_i, o.phi.sin_cos()))
}

impl<L: Along, A: Around> Scattering for Factored<L, A> {
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
