//! The six lobes, and a sampled direction.

use crate::choose::choose;
use crate::simd::lanes::Lanes;
use glam::Vec3;

/// The six lobes, in the order of every array of lobes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lobe {
    /// Reflected by the cuticle, R.
    R,
    /// Transmitted straight through, TT.
    Tt,
    /// Reflected once inside, TRT.
    Trt,
    /// Scattered by the medulla in its first pass, TTˢ.
    Tts,
    /// Scattered by the medulla in its second pass, TRTˢ.
    Trts,
    /// The residual lobe: all higher orders (D6). Its key in files is `rest`.
    Residual,
}

impl Lobe {
    /// All six lobes, in order.
    pub const ALL: [Lobe; 6] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Tts, Lobe::Trts, Lobe::Residual];

    /// The lobe that `u` in [0, 1) selects, given the probabilities of all six. A lobe without energy is never
    /// chosen.
    #[inline(always)]
    pub(crate) fn choose(probability: [f32; 6], u: f32) -> Lobe {
        choose(Lobe::ALL.into_iter().zip(probability), u).map_or(Lobe::R, |choice| choice.item)
    }

    /// The key used in files: R, TT, TRT, TTs, TRTs, rest.
    pub fn key(self) -> &'static str {
        ["R", "TT", "TRT", "TTs", "TRTs", "rest"][self as usize]
    }
}

/// f·cos θᵢ of each lobe, RGB, indexed by `Lobe as usize`. `V` is `f32`, or [`f32x8`](wide::f32x8) for eight queries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobes<V = f32>(pub [[V; 3]; 6]);

impl<V: Lanes> Lobes<V> {
    /// The sum over the lobes.
    pub fn total(&self) -> [V; 3] {
        std::array::from_fn(|c| self.0[1..].iter().fold(self.0[0][c], |sum, lobe| sum + lobe[c]))
    }
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// ω_i, unit length, in the fibre's frame.
    pub wi: Vec3,
    /// The density per solid angle of drawing `wi` from any lobe and offset, as needed for multiple importance
    /// sampling.
    pub pdf: f32,
    /// f·cos θᵢ over the density, RGB. Both include all lobes and the whole window.
    pub weight: [f32; 3],
    /// The lobe it was drawn from.
    pub lobe: Lobe,
}

impl Sample {
    /// The sample, or nothing if its density underflowed to 0, or if one of its numbers is NaN or infinite.
    /// For models in other crates of the repository; yours can fill the fields.
    #[doc(hidden)]
    #[inline(always)]
    pub fn new(wi: Vec3, pdf: f32, weight: [f32; 3], lobe: Lobe) -> Option<Self> {
        // A sum is only finite if all of its terms are: one comparison instead of seven.
        let sum = (wi.x + wi.y + wi.z) + (weight[0] + weight[1] + weight[2]) + pdf;
        (pdf > 0.0 && sum.is_finite()).then_some(Sample { wi, pdf, weight, lobe })
    }
}
