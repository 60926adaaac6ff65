//! How the colour of a look varies over the strands: the pattern of the scene, and darker or paler tips.

use crate::request::{Coat, within};
use rayon::prelude::*;
use vellus::{CoatColors, Fiber, Parameter};
use vellus_render::Varying;
use vellus_scene::{Strands, Values};

/// The absorption that darker tips of unpigmented fur are multiples of, per radius. Ten times as much gives a dense
/// coat a reflectance of 0.10 (human hair) to 0.21 (cat): dark grey.
const LEAST: f32 = 0.02;

impl Coat {
    /// Checks the ranges.
    pub(crate) fn check(&self) -> Result<(), String> {
        within("tip", self.tip, 0.01, 100.0).map(|_| ())
    }

    /// The parameters that vary over a set of strands. `own` are those of the scene, and `fiber` is that of the look.
    pub(crate) fn varying(&self, strands: &Strands, own: &Varying, fiber: &Fiber) -> Varying {
        let kept = own.iter().filter(|(parameter, _)| self.pattern || !is_pigment(*parameter)).cloned().collect();
        if self.tip == 1.0 {
            return kept;
        }
        let (pigment, mut others): (Varying, Varying) = kept.into_iter().partition(|(p, _)| is_pigment(*p));
        let absorption = Absorption::new(fiber, &pigment);
        let colors: Vec<Vec<[f32; 3]>> = (0..strands.len())
            .into_par_iter()
            .map(|i| {
                let points = strands.starts[i] as usize..strands.starts[i + 1] as usize;
                let last = (points.len().max(2) - 1) as f32;
                let root = absorption.of_strand(i);
                let color = |(k, point): (usize, usize)| {
                    let s = k as f32 / last;
                    // The factor grows toward the tip: half of the strand is nearly unchanged.
                    let factor = self.tip.powf(s * s);
                    grow(root.unwrap_or_else(|| absorption.of_point(i, point)), factor)
                };
                points.enumerate().map(color).collect()
            })
            .collect();
        others.push((Parameter::SigmaCa, Values::PerPoint(colors.concat())));
        others
    }
}

/// An absorption whose largest channels are multiplied by a factor. A factor above 1 also darkens the channels that
/// absorb least: a multiple of nearly nothing would leave the tips of red or white fur as they are.
fn grow(sigma: [f32; 3], factor: f32) -> [f32; 3] {
    let least = (sigma.iter().sum::<f32>() / 3.0).max(LEAST);
    sigma.map(|s| if factor > 1.0 { s + (factor - 1.0) * s.max(least) } else { s * factor })
}

/// Whether a parameter gives the cortex its colour.
pub(crate) fn is_pigment(parameter: Parameter) -> bool {
    parameter.is_color()
}

/// The absorption of the cortex at the points of strands.
struct Absorption<'a> {
    fiber: Fiber,
    table: Option<CoatColors>,
    pigment: &'a Varying,
}

impl<'a> Absorption<'a> {
    fn new(fiber: &Fiber, pigment: &'a Varying) -> Self {
        let needed = pigment.iter().any(|(parameter, _)| *parameter == Parameter::Reflectance);
        let table = needed.then(|| CoatColors::new(fiber).ok()).flatten();
        Absorption { fiber: *fiber, table, pigment }
    }

    fn set(&self, fiber: &mut Fiber, parameter: Parameter, value: [f32; 3]) {
        match (parameter, &self.table) {
            (Parameter::Reflectance, Some(table)) => {
                let color = value.map(|c| table.absorption(parameter.range().nearest(c)));
                *fiber = fiber.with_pigment(color);
            }
            _ => parameter.set_nearest(fiber, value),
        }
    }

    /// The absorption of a strand, if it is the same along the strand.
    fn of_strand(&self, strand: usize) -> Option<[f32; 3]> {
        let along = self.pigment.iter().any(|(_, values)| matches!(values, Values::PerPoint(_)));
        (!along).then(|| self.of_point(strand, 0))
    }

    fn of_point(&self, strand: usize, point: usize) -> [f32; 3] {
        let mut fiber = self.fiber;
        for (parameter, values) in self.pigment {
            let value = match values {
                Values::Constant(value) => *value,
                Values::PerStrand(values) => values[strand],
                Values::PerPoint(values) => values[point],
            };
            self.set(&mut fiber, *parameter, value);
        }
        fiber.sigma_ca
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tips_get_darker_and_the_pattern_stays() {
        let scene = vellus_groom::scene("cat", true).unwrap();
        let (strands, fiber) = (&scene.strands[0], scene.looks[0].fiber);
        let own = strands.varying.clone();
        assert_eq!(Coat::default().varying(strands, &own, &fiber), own);
        assert!(Coat { pattern: false, tip: 1.0 }.varying(strands, &own, &fiber).is_empty());
        let dark = Coat { pattern: true, tip: 4.0 }.varying(strands, &own, &fiber);
        let [(Parameter::SigmaCa, Values::PerPoint(colors))] = &dark[..] else { panic!("{}", dark.len()) };
        let [(Parameter::SigmaCa, Values::PerStrand(roots))] = &own[..] else { panic!("{own:?}") };
        for (i, root) in roots.iter().enumerate() {
            let points = &colors[strands.starts[i] as usize..strands.starts[i + 1] as usize];
            assert_eq!(points[0], *root);
            // The exponent is exactly 1 at the tip; powf rounds to a few units in the last place.
            let (tip, most) = (points[points.len() - 1], root.iter().copied().fold(0.0, f32::max));
            let largest = tip.iter().copied().fold(0.0, f32::max);
            assert!(most < LEAST || (largest / most - 4.0).abs() < 1e-4, "{root:?} {tip:?}");
        }
        // Red and white fur get darker too.
        for sigma in [[1e-4, 3.0, 3.0], [0.0; 3]] {
            let tip = grow(sigma, 8.0);
            assert!(tip.iter().zip(sigma).all(|(tip, root)| *tip >= root + 7.0 * LEAST), "{tip:?}");
            assert_eq!((grow(sigma, 1.0), grow(sigma, 0.5)), (sigma, sigma.map(|s| 0.5 * s)));
        }
        let uniform = Coat { pattern: false, tip: 0.5 }.varying(strands, &own, &fiber);
        let [(_, Values::PerPoint(colors))] = &uniform[..] else { panic!("{}", uniform.len()) };
        assert_eq!(colors[0], fiber.sigma_ca);
    }
}
