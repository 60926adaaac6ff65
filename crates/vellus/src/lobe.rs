//! The six lobes, and a sampled direction.

use crate::choose::choose;
use crate::error::Error;
use crate::simd::lanes::Lanes;
use glam::Vec3;
use std::fmt;
use std::ops::{Add, AddAssign, Index, IndexMut, Mul};
use std::str::FromStr;

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
    /// The rest lobe: all higher orders (D6). Its key in files is `rest`.
    Rest,
}

impl Lobe {
    /// The number of lobes, and the length of every array of lobes.
    pub const COUNT: usize = Lobe::ALL.len();

    /// All six lobes, in order.
    pub const ALL: [Lobe; 6] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Tts, Lobe::Trts, Lobe::Rest];

    /// The lobe that `u` in [0, 1) selects, given the probabilities of all six. A lobe without energy is never
    /// chosen.
    #[inline(always)]
    pub(crate) fn choose(probability: [f32; Lobe::COUNT], u: f32) -> Lobe {
        choose(Lobe::ALL.into_iter().zip(probability), u).map_or(Lobe::R, |choice| choice.item)
    }

    /// The key used in files: R, TT, TRT, TTs, TRTs, rest.
    pub fn key(self) -> &'static str {
        ["R", "TT", "TRT", "TTs", "TRTs", "rest"][self as usize]
    }
}

impl fmt::Display for Lobe {
    /// The key.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.key())
    }
}

impl FromStr for Lobe {
    type Err = Error;

    /// Accepts the key alone.
    fn from_str(name: &str) -> Result<Self, Error> {
        Lobe::ALL.into_iter().find(|lobe| lobe.key() == name).ok_or_else(|| Error::UnknownName {
            what: "lobe",
            name: name.to_owned(),
            known: Lobe::ALL.map(Lobe::key).join(", "),
        })
    }
}

/// A component of the light that leaves a fibre: a lobe, or a part of one that has its own shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(dead_code, reason = "loops over the first components count them")]
pub(crate) enum Component {
    R,
    Tt,
    Trt,
    Tts,
    Trts,
    /// The unscattered part of [`Lobe::Rest`].
    Rest,
    /// The diffuse part of [`Lobe::Rest`]: scattered light that the cuticle reflected before it left (D17).
    Diffuse,
}

impl Component {
    /// The number of components, and the length of every array of components.
    pub const COUNT: usize = Lobe::COUNT + 1;

    /// The components that the medulla scattered in the first and in the second pass.
    pub const SCATTERED: [Component; 2] = [Component::Tts, Component::Trts];
}

/// The place of [`Component::Diffuse`] in arrays of components.
pub(crate) const DIFFUSE: usize = Component::Diffuse as usize;

/// f·cos θᵢ of each lobe, RGB, indexed by [`Lobe`]. `V` is `f32`, or [`f32x8`](wide::f32x8) for eight queries.
///
/// ```
/// use vellus::{Lobe, Lobes};
/// // Light times a weight, added to the layers of a pixel.
/// let (f, light) = (Lobes([[0.5f32; 3]; 6]), [2.0, 1.0, 0.0]);
/// let mut layers: Lobes = Lobes::default();
/// layers += f * light * 0.25;
/// assert_eq!(layers[Lobe::Tt], [0.25, 0.125, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes<V = f32>(pub [[V; 3]; Lobe::COUNT]);

impl<V: Lanes> Lobes<V> {
    /// The sum over the lobes.
    pub fn total(&self) -> [V; 3] {
        std::array::from_fn(|c| self.0[1..].iter().fold(self.0[0][c], |sum, lobe| sum + lobe[c]))
    }
}

impl<V> Index<Lobe> for Lobes<V> {
    type Output = [V; 3];

    #[inline(always)]
    fn index(&self, lobe: Lobe) -> &[V; 3] {
        &self.0[lobe as usize]
    }
}

impl<V> IndexMut<Lobe> for Lobes<V> {
    #[inline(always)]
    fn index_mut(&mut self, lobe: Lobe) -> &mut [V; 3] {
        &mut self.0[lobe as usize]
    }
}

impl<V: Lanes> Add for Lobes<V> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Lobes(std::array::from_fn(|p| std::array::from_fn(|c| self.0[p][c] + other.0[p][c])))
    }
}

impl<V: Lanes> AddAssign for Lobes<V> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<V: Lanes> Mul<V> for Lobes<V> {
    type Output = Self;

    #[inline]
    fn mul(self, factor: V) -> Self {
        self * [factor; 3]
    }
}

/// All lobes times a colour, RGB.
impl<V: Lanes> Mul<[V; 3]> for Lobes<V> {
    type Output = Self;

    #[inline]
    fn mul(self, color: [V; 3]) -> Self {
        Lobes(self.0.map(|lobe| std::array::from_fn(|c| lobe[c] * color[c])))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_read_as_they_are_written() {
        for lobe in Lobe::ALL {
            assert_eq!(lobe.to_string().parse(), Ok(lobe));
        }
        assert_eq!(format!("{:>4}", Lobe::R), "   R");
        let error = "tt".parse::<Lobe>().unwrap_err().to_string();
        assert_eq!(error, "unknown lobe 'tt': known are R, TT, TRT, TTs, TRTs, rest");
    }

    #[test]
    fn lobes_add_and_scale_channel_by_channel() {
        let mut lobes: Lobes = Lobes([[1.0, 2.0, 4.0]; 6]);
        lobes[Lobe::Tts] = [0.0, 1.0, 0.0];
        let sum = lobes * 0.5 + lobes * [1.0, 0.0, 2.0];
        assert_eq!((sum[Lobe::R], sum[Lobe::Tts]), ([1.5, 1.0, 10.0], [0.0, 0.5, 0.0]));
        assert_eq!(sum.0[Lobe::Tts as usize], sum[Lobe::Tts]);
    }
}
