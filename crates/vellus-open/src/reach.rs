//! Reflectances that vary over strands and are out of reach.

use crate::Warning;
use vellus::{CoatColors, Parameter};
use vellus_scene::{Scene, Values};

/// The largest difference of a channel that counts as reached. Textures often have a black background, and the
/// darkest coats reflect less than this.
const TOLERANCE: f32 = 0.01;

/// A warning for each set of strands some of whose colours no pigment gives. The renderer uses the nearest ones.
pub fn out_of_reach(scene: &Scene) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for strands in scene.all_strands() {
        let look = &scene.looks[strands.look];
        let textures = look.textured.iter().filter(|(parameter, _)| *parameter == Parameter::Reflectance);
        let values = strands.varying.iter().filter(|(parameter, _)| *parameter == Parameter::Reflectance);
        let (mut textures, mut values) = (textures.peekable(), values.peekable());
        if textures.peek().is_none() && values.peek().is_none() {
            continue;
        }
        let Ok(table) = CoatColors::new(&look.fiber) else { continue };
        let mut count = Count { range: table.range(), all: 0, far: 0 };
        for (_, value) in textures {
            let texels = &scene.textures[value.texture].pixels;
            texels.iter().for_each(|texel| count.add([0, 1, 2].map(|c| texel[c] * value.scale[c])));
        }
        for (_, values) in values {
            match values {
                Values::Constant(color) => count.add(*color),
                Values::PerStrand(colors) | Values::PerPoint(colors) => colors.iter().for_each(|&c| count.add(c)),
            }
        }
        if count.far > 0 {
            let share = count.far as f32 / count.all as f32;
            warnings.push(Warning::OutOfReach { strands: strands.name.clone(), share, range: count.range });
        }
    }
    warnings
}

/// The number of colours, and of those that are out of reach.
struct Count {
    range: [f32; 2],
    all: usize,
    far: usize,
}

impl Count {
    fn add(&mut self, color: [f32; 3]) {
        self.all += 1;
        let [low, high] = self.range;
        self.far += usize::from(color.iter().any(|&c| (c - c.clamp(low, high)).abs() > TOLERANCE));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus::{Fiber, Species};
    use vellus_scene::{Basis, Look, Strands, Texture, Value};

    #[test]
    fn colors_out_of_reach_are_counted() {
        let mut look = Look::constant("fur", Fiber::preset(Species::RedFox));
        look.textured.push((Parameter::Reflectance, Value { texture: 0, scale: [1.0; 3] }));
        let strands = Strands {
            name: "coat".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, 2],
            points: vec![glam::Vec4::ONE; 2],
            moved: None,
            root_uv: None,
            look: 0,
            varying: vec![],
        };
        let pixels = vec![[0.5; 3], [0.4, 0.5, 0.3], [0.5; 3], [1.2, 0.0, 0.5]];
        let texture = Texture { name: "colors".to_owned(), width: 2, height: 2, pixels, wrap: Default::default() };
        let mut scene =
            Scene { strands: vec![strands], looks: vec![look], textures: vec![texture], ..Scene::default() };
        let warned = out_of_reach(&scene);
        let [Warning::OutOfReach { strands, share, range: [low, _] }] = &warned[..] else { panic!("{warned:?}") };
        assert_eq!((strands.as_str(), *share), ("coat", 0.25));
        // A cuticle reflects some light.
        assert!(*low > 0.0 && warned[0].to_string().contains("25.00 %"), "{}", warned[0]);
        scene.textures[0].pixels.truncate(3);
        assert_eq!(out_of_reach(&scene), []);
        let dark = Values::PerStrand(vec![[0.0; 3], [-0.1; 3]]);
        scene.strands[0].varying.push((Parameter::Reflectance, dark));
        assert_eq!(out_of_reach(&scene).len(), 1);
    }
}
