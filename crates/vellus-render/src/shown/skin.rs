//! Skin that has the colour of the coat that grows on it.

use crate::integrator::geometry::Geometry;
use std::collections::BTreeSet;
use vellus::Parameter;
use vellus_scene::{SKIN, Values};

/// Gives skin ([`vellus_scene::Surface::skin`]) the colour that dense coats of its fibres have, darkened by [`SKIN`].
/// `looks` are those that grow on each mesh. All reflectances that are asked for are `fixed`, if it is given.
pub(super) fn color(geometry: &mut Geometry, looks: &[BTreeSet<usize>], fixed: Option<[f32; 3]>) {
    let colors: Vec<[f32; 3]> = (0..geometry.looks.len()).map(|look| dense(geometry, look, fixed)).collect();
    for (mesh, looks) in geometry.triangles.meshes().iter().zip(looks) {
        let surface = &mut geometry.surfaces[mesh.surface];
        if surface.skin && !looks.is_empty() {
            let mean = |c: usize| looks.iter().map(|&look| colors[look][c]).sum::<f32>() / looks.len() as f32;
            surface.color.color = [0, 1, 2].map(|c| SKIN * mean(c));
        }
    }
}

/// The colour of a dense coat with the mean pigment of a look.
fn dense(geometry: &Geometry, look: usize, fixed: Option<[f32; 3]>) -> [f32; 3] {
    let fiber = &geometry.looks[look].fiber;
    let varying = geometry.all_strands().filter(|set| set.look == look).flat_map(|set| &set.varying);
    let varying: Vec<&Values<[f32; 3]>> =
        varying.filter(|(parameter, _)| *parameter == Parameter::Reflectance).map(|(_, values)| values).collect();
    let textures = geometry.looks[look].textured.iter().filter(|(parameter, _)| *parameter == Parameter::Reflectance);
    let textures: Vec<_> = textures.map(|(_, value)| value).collect();
    let is_asked = fiber.reflectance.is_some() || !varying.is_empty() || !textures.is_empty();
    if let (Some(fixed), true) = (fixed, is_asked) {
        return fixed;
    }
    let mut mean = Mean::default();
    for values in varying {
        match values {
            Values::Constant(color) => mean.add(*color),
            Values::PerStrand(colors) | Values::PerPoint(colors) => colors.iter().for_each(|color| mean.add(*color)),
        }
    }
    for value in textures {
        let texels = &geometry.textures[value.texture].pixels;
        texels.iter().for_each(|texel| mean.add([0, 1, 2].map(|c| texel[c] * value.scale[c])));
    }
    match mean.value().or(fiber.reflectance) {
        Some(asked) => geometry.reflectance.dense(look, asked),
        None => fiber.coat_color().unwrap_or([0.5; 3]),
    }
    .map(|c| c.clamp(0.0, 1.0))
}

/// The mean of colours.
#[derive(Default)]
struct Mean {
    sum: [f64; 3],
    count: usize,
}

impl Mean {
    fn add(&mut self, color: [f32; 3]) {
        (0..3).for_each(|c| self.sum[c] += f64::from(color[c]));
        self.count += 1;
    }

    fn value(&self) -> Option<[f32; 3]> {
        (self.count > 0).then(|| self.sum.map(|sum| (sum / self.count as f64) as f32))
    }
}
