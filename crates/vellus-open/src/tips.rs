//! Tips of another colour.

use rayon::prelude::*;
use vellus::{CoatColors, Parameter};
use vellus_scene::{Look, Scene, Strands, Texture, Values};

/// The colour of the tips of all strands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tips {
    /// A reflectance, linear RGB.
    pub color: [f32; 3],
    /// The share of the length over which the colour changes, in (0, 1].
    pub share: f32,
}

impl Tips {
    /// The share of the length if none is given.
    pub const SHARE: f32 = 0.3;

    /// Colours the tips of a scene. The colours of the strands become reflectances of their control points.
    pub fn apply(self, scene: &mut Scene) {
        let Scene { strands, prototypes, looks, textures, .. } = scene;
        for set in strands.iter_mut().chain(prototypes.iter_mut().flat_map(|prototype| &mut prototype.strands)) {
            let colors = self.colors(set, &looks[set.look], textures);
            set.varying.retain(|(parameter, _)| !is_pigment(*parameter));
            set.varying.push((Parameter::Reflectance, Values::PerPoint(colors)));
        }
        for look in looks {
            look.textured.retain(|(parameter, _)| !is_pigment(*parameter));
        }
    }

    /// The colours of all control points of a set.
    fn colors(self, set: &Strands, look: &Look, textures: &[Texture]) -> Vec<[f32; 3]> {
        let coat = CoatColors::new(&look.fiber).ok();
        let strand = |i: usize| {
            let points = set.starts[i] as usize..set.starts[i + 1] as usize;
            let last = (points.len().max(2) - 1) as f32;
            let color = |(k, point)| {
                let own = own_color(set, look, textures, coat.as_ref(), i, point);
                let t = ((k as f32 / last - 1.0) / self.share + 1.0).clamp(0.0, 1.0);
                let t = t * t * (3.0 - 2.0 * t);
                [0, 1, 2].map(|c| own[c] + t * (self.color[c] - own[c]))
            };
            points.enumerate().map(color).collect::<Vec<_>>()
        };
        (0..set.len()).into_par_iter().flat_map_iter(strand).collect()
    }
}

/// Whether a parameter gives the colour of a strand.
fn is_pigment(parameter: Parameter) -> bool {
    parameter.is_color() || parameter == Parameter::SigmaMa
}

/// The colour of a control point as a reflectance. What replaces others comes last, as in the renderer.
fn own_color(
    set: &Strands,
    look: &Look,
    textures: &[Texture],
    coat: Option<&CoatColors>,
    strand: usize,
    point: usize,
) -> [f32; 3] {
    let dense = |sigma: [f32; 3]| sigma.map(|sigma| coat.map_or(0.5, |coat| coat.color(sigma)));
    let reflectance = |parameter: Parameter, value: [f32; 3]| match parameter {
        Parameter::Reflectance => Some(value),
        Parameter::SigmaCa => Some(dense(value)),
        _ => None,
    };
    let uv = set.root_uv.as_ref().map_or(glam::Vec2::ZERO, |uv| uv[strand]);
    let textured = look.textured.iter().filter_map(|(parameter, value)| {
        let texel = textures[value.texture].at(uv);
        reflectance(*parameter, [0, 1, 2].map(|c| texel[c] * value.scale[c]))
    });
    let varying = set.varying.iter().filter_map(|(parameter, values)| {
        let value = match values {
            Values::Constant(value) => *value,
            Values::PerStrand(values) => values[strand],
            Values::PerPoint(values) => values[point],
        };
        reflectance(*parameter, value)
    });
    textured.chain(varying).last().or(look.fiber.reflectance).unwrap_or_else(|| dense(look.fiber.sigma_ca))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, open};

    /// Roots keep their colour, also that of a pattern; the last points have the colour of the tips.
    #[test]
    fn tips_change_and_roots_stay() {
        let color = [0.02, 0.015, 0.01];
        for (share, half_changes) in [(0.3, false), (0.9, true)] {
            let tips = Some(Tips { color, share });
            let [plain, tipped] = [None, tips]
                .map(|tips| open("cat", &Options { small: true, tips, ..Options::default() }).unwrap().scene);
            let [set, own] = [&tipped.strands[0], &plain.strands[0]];
            let [(Parameter::Reflectance, Values::PerPoint(colors))] = &set.varying[..] else { panic!() };
            let coat = CoatColors::new(&plain.looks[own.look].fiber).unwrap();
            let Some((_, Values::PerStrand(pattern))) = own.varying.iter().find(|(p, _)| p.is_color()) else {
                panic!()
            };
            for i in (0..set.len()).step_by(97) {
                let points = set.starts[i] as usize..set.starts[i + 1] as usize;
                let root = pattern[i].map(|sigma| coat.color(sigma));
                assert_eq!(colors[points.start], root);
                assert!(colors[points.end - 1].iter().zip(color).all(|(a, b)| (a - b).abs() < 1e-6));
                let middle = colors[(points.start + points.end - 1) / 2];
                assert_eq!(middle != root, half_changes, "{root:?} {middle:?}");
            }
        }
    }
}
