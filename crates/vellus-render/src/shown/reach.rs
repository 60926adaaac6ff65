//! Reflectances that are out of reach.

use super::{Reflectance, Shown};
use crate::world::World;
use vellus::{CoatColors, Parameter};
use vellus_scene::Values;

/// The largest difference of a channel that counts as reached. Textures often have a black background, and the
/// darkest coats reflect less than this.
const TOLERANCE: f32 = 0.01;

/// A coat that hides less of its skin than this looks thin.
const CLOSED: f32 = 0.97;

impl World {
    /// What users should know about the reflectances that they ask for: those that no pigment gives, one line for each
    /// look or set of strands. The renderer uses the nearest ones.
    pub fn unreached(&self) -> Vec<String> {
        let geometry = &self.geometry;
        let mut lines = Vec::new();
        let shown = |look: usize| match &geometry.reflectance {
            Reflectance::Shown(all) => all.get(look).and_then(Option::as_ref),
            _ => None,
        };
        let range = |look: usize| match shown(look) {
            Some(shown) => Some(shown.range()),
            None => CoatColors::new(&geometry.looks[look].fiber).ok().map(|table| table.range()),
        };
        for (i, look) in geometry.looks.iter().enumerate() {
            let (Some(asked), Some([low, high])) = (look.fiber.reflectance, range(i)) else { continue };
            let nearest = shown(i).map_or_else(|| asked.map(|c| c.clamp(low, high)), |shown| shown.nearest(asked));
            if is_far(asked, nearest) {
                let [[r, g, b], [x, y, z]] = [asked, nearest];
                let mut line = format!("{}: no pigment gives this coat the reflectance {r}, {g}, {b}: ", look.name);
                line += &format!("the nearest is {x:.3}, {y:.3}, {z:.3}");
                lines.push(line + &reasons(shown(i), asked, [low, high]));
            }
        }
        for strands in geometry.all_strands() {
            let look = &geometry.looks[strands.look];
            let Some(range) = range(strands.look) else { continue };
            let mut count = Count { range, all: 0, far: 0 };
            for (_, value) in look.textured.iter().filter(|(parameter, _)| *parameter == Parameter::Reflectance) {
                let texels = &geometry.textures[value.texture].pixels;
                texels.iter().for_each(|texel| count.add([0, 1, 2].map(|c| texel[c] * value.scale[c])));
            }
            for (_, values) in strands.varying.iter().filter(|(parameter, _)| *parameter == Parameter::Reflectance) {
                match values {
                    Values::Constant(color) => count.add(*color),
                    Values::PerStrand(colors) | Values::PerPoint(colors) => colors.iter().for_each(|&c| count.add(c)),
                }
            }
            if count.far > 0 {
                let ([low, high], share) = (range, 100.0 * count.far as f32 / count.all as f32);
                let line = format!("{}: no pigment gives {share:.2} % of the reflectances: ", strands.name);
                let line = line + &format!("the nearest in [{low:.3}, {high:.3}] are used");
                lines.push(line + &reasons(shown(strands.look), [1.0; 3], range));
            }
        }
        lines
    }
}

/// Why a coat cannot show a colour, and what helps.
fn reasons(shown: Option<&Shown>, asked: [f32; 3], [low, high]: [f32; 2]) -> String {
    let mut reasons = String::new();
    match shown {
        Some(shown) if asked.iter().any(|&c| c > high + TOLERANCE) && shown.cover < CLOSED => {
            let percent = 100.0 * shown.cover;
            reasons +=
                &format!(". It hides {percent:.0} % of its skin: more or wider strands, or a brighter skin, help");
        }
        Some(_) if asked.iter().any(|&c| c > high + TOLERANCE) => {
            reasons += ". Its skin, or shadows between its strands, keep it darker: a brighter skin or denser fur help";
        }
        _ => {}
    }
    if asked.iter().any(|&c| c < low - TOLERANCE) {
        reasons += ". The cuticle reflects light before pigment can absorb it";
    }
    reasons
}

fn is_far(asked: [f32; 3], nearest: [f32; 3]) -> bool {
    asked.iter().zip(nearest).any(|(asked, nearest)| (asked - nearest).abs() > TOLERANCE)
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
        self.far += usize::from(is_far(color, color.map(|c| c.clamp(low, high))));
    }
}
