//! Markings: colours that differ along strands, between strands and between back and belly.

use crate::color::reflectance;
use glam::Vec3;
use rayon::prelude::*;
use std::str::FromStr;
use vellus::{CoatColors, Parameter};
use vellus_scene::{Look, Scene, Strands, Texture, Values};

/// Where the surface faces down by this much, the colour of the belly begins and is complete.
const BELLY: [f32; 2] = [0.0, 0.6];

/// Markings of all strands of a scene, in the order in which they replace each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Markings {
    /// Colours from root to tip.
    pub ramp: Option<Ramp>,
    /// The colour where the surface faces down. Linear RGB.
    pub belly: Option<[f32; 3]>,
    /// The colour of the tips.
    pub tips: Option<Tips>,
    /// Strands of another colour, such as white ones among dark ones.
    pub mix: Vec<Mix>,
}

/// Colours from root to tip, linear between its stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// Positions along the strand, in [0, 1] and not falling, and reflectances. There is at least one.
    stops: Vec<(f32, [f32; 3])>,
}

/// A share of the strands, chosen at random, that has another colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// A reflectance, linear RGB.
    pub color: [f32; 3],
    /// The share of the strands, in (0, 1].
    pub share: f32,
}

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
}

impl FromStr for Ramp {
    type Err = String;

    /// Reads two or more colours with spaces between them, from root to tip: `black white@60% white`. A position
    /// follows an @. Without one, the first colour is at the root, the last one at the tip, and others are even between
    /// their neighbours.
    fn from_str(text: &str) -> Result<Self, String> {
        let stop = |word: &str| {
            let (color, at) = word.rsplit_once('@').map_or((word, None), |(color, at)| (color, Some(at)));
            let at = at.map(|at| share(at, 0.0)).transpose()?;
            Ok((at, reflectance(color)?))
        };
        let stops: Vec<(Option<f32>, [f32; 3])> = text.split_whitespace().map(stop).collect::<Result<_, String>>()?;
        let last = stops.len().saturating_sub(1);
        if last == 0 {
            return Err(format!("'{text}': a ramp has two or more colours: root tip, or black white@60% white"));
        }
        let known = |i: usize| stops[i].0.or((i == 0).then_some(0.0)).or((i == last).then_some(1.0));
        let place = |i: usize| {
            // Ends are always known.
            let before = (0..=i).rev().find_map(|k| known(k).map(|at| (k, at))).unwrap_or((0, 0.0));
            let after = (i..=last).find_map(|k| known(k).map(|at| (k, at))).unwrap_or((last, 1.0));
            let step = (after.0 - before.0).max(1) as f32;
            before.1 + (after.1 - before.1) * (i - before.0) as f32 / step
        };
        let placed: Vec<(f32, [f32; 3])> = (0..stops.len()).map(|i| (place(i), stops[i].1)).collect();
        let is_sorted = placed.is_sorted_by_key(|(at, _)| *at);
        is_sorted.then_some(Ramp { stops: placed }).ok_or_else(|| format!("'{text}': positions go from root to tip"))
    }
}

impl Ramp {
    /// The colour at `t` in [0, 1] from root to tip.
    fn at(&self, t: f32) -> [f32; 3] {
        let next = self.stops.partition_point(|(at, _)| *at < t).min(self.stops.len() - 1);
        let [(a, first), (b, second)] = [next.saturating_sub(1), next].map(|k| self.stops[k]);
        mixed(first, second, if b > a { (t - a) / (b - a) } else { 1.0 })
    }
}

impl FromStr for Mix {
    type Err = String;

    /// Reads a colour and a share: `white:30%`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}': write a colour and a share of the strands: white:30%");
        let (color, part) = text.rsplit_once(':').ok_or_else(wrong)?;
        Ok(Mix { color: reflectance(color)?, share: share(part, f32::MIN_POSITIVE)? })
    }
}

/// A share in percent, at least `low`, as a number up to 1.
fn share(text: &str, low: f32) -> Result<f32, String> {
    let percent: f32 = text.strip_suffix('%').unwrap_or(text).parse().unwrap_or(f32::NAN);
    let share = percent / 100.0;
    (low..=1.0).contains(&share).then_some(share).ok_or_else(|| format!("'{text}' is no share from 0% to 100%"))
}

fn mixed(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    [0, 1, 2].map(|c| a[c] + t * (b[c] - a[c]))
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Markings {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Markings::default()
    }

    /// Colours a scene. The colours of the strands become reflectances of their control points.
    pub fn apply(&self, scene: &mut Scene) {
        let up = scene.up();
        let Scene { strands, prototypes, looks, textures, .. } = scene;
        for set in strands.iter_mut().chain(prototypes.iter_mut().flat_map(|prototype| &mut prototype.strands)) {
            let colors = self.colors(set, &looks[set.look], textures, up);
            set.varying.retain(|(parameter, _)| !is_pigment(*parameter));
            set.varying.push((Parameter::Reflectance, Values::PerPoint(colors)));
        }
        for look in looks {
            look.textured.retain(|(parameter, _)| !is_pigment(*parameter));
        }
    }

    /// The colours of all control points of a set.
    fn colors(&self, set: &Strands, look: &Look, textures: &[Texture], up: Vec3) -> Vec<[f32; 3]> {
        let coat = CoatColors::new(&look.fiber).ok();
        let normals = self.belly.map(|color| (color, vellus_groom::root_normals(set)));
        let strand = |i: usize| {
            let points = set.starts[i] as usize..set.starts[i + 1] as usize;
            let last = (points.len().max(2) - 1) as f32;
            // Each strand is in one of the intervals of the mix, or after them.
            let mut rank = Strands::rank(i);
            let mix = self.mix.iter().find(|mix| {
                rank -= mix.share;
                rank < 0.0
            });
            if let Some(mix) = mix {
                return vec![mix.color; points.len()];
            }
            let color = |(k, point)| {
                let t = k as f32 / last;
                let own = || own_color(set, look, textures, coat.as_ref(), i, point);
                let mut color = self.ramp.as_ref().map_or_else(own, |ramp| ramp.at(t));
                if let Some((belly, normals)) = &normals {
                    let down = (-normals[i].dot(up) - BELLY[0]) / (BELLY[1] - BELLY[0]);
                    color = mixed(color, *belly, smooth(down));
                }
                if let Some(tips) = self.tips {
                    color = mixed(color, tips.color, smooth((t - 1.0) / tips.share + 1.0));
                }
                color
            };
            points.enumerate().map(color).collect()
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
            let tips = Markings { tips: Some(Tips { color, share }), ..Markings::default() };
            let [plain, tipped] = [Markings::default(), tips]
                .map(|markings| open("cat", &Options { small: true, markings, ..Options::default() }).unwrap().scene);
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

    #[test]
    fn ramps_and_mixes_are_read() {
        let ramp: Ramp = "0,0,0 0.2,0.2,0.2 0.5,0.5,0.5@60% white".parse().unwrap();
        let grey = |t: f32| ramp.at(t)[0];
        for (t, expected) in [(0.0, 0.0), (0.15, 0.1), (0.3, 0.2), (0.6, 0.5), (0.8, 0.75), (1.0, 1.0)] {
            assert!((grey(t) - expected).abs() < 1e-6, "{t}");
        }
        assert_eq!("white:30%".parse(), Ok(Mix { color: [1.0; 3], share: 0.3 }));
        for wrong in ["black", "black@50% white@40%", "black blurple", "black@-1% white", "2,2,2 black"] {
            assert!(wrong.parse::<Ramp>().is_err(), "{wrong}");
        }
        for wrong in ["white", "white:0%", "white:101%", ":5%"] {
            assert!(wrong.parse::<Mix>().is_err(), "{wrong}");
        }
    }

    /// A ball of fur: its lower side has the colour of the belly, and a third of all strands is white.
    #[test]
    fn bellies_are_below_and_mixes_have_their_share() {
        let point = |i: usize, radius: f32| {
            let y = 1.0 - (2 * i + 1) as f32 / 6000.0;
            let angle = 2.399_963_2 * i as f32;
            let across = (1.0 - y * y).sqrt();
            (radius * Vec3::new(across * angle.cos(), y, across * angle.sin())).extend(0.01)
        };
        let fur = Strands {
            name: "fur".to_owned(),
            basis: vellus_scene::Basis::Linear,
            starts: (0..=6000).map(|i| 2 * i).collect(),
            points: (0..6000).flat_map(|i| [point(i, 1.0), point(i, 1.2)]).collect(),
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        };
        let looks = vec![Look::constant("fur", vellus::Fiber::preset(vellus::Species::Cat))];
        let mut scene = Scene { strands: vec![fur], looks, ..Scene::default() };
        let mix = vec!["white:30%".parse().unwrap()];
        let belly = Some([0.1, 0.2, 0.3]);
        Markings { ramp: "black black".parse().ok(), belly, tips: None, mix }.apply(&mut scene);
        let set = &scene.strands[0];
        let [(_, Values::PerPoint(colors))] = &set.varying[..] else { panic!("colours are per point") };
        let mut white = 0;
        for i in 0..set.len() {
            let (color, height) = (colors[set.starts[i] as usize], set.strand(i)[0].y);
            if color == [1.0; 3] {
                white += 1;
            } else if height > 0.1 {
                assert_eq!(color, [0.0; 3], "{height}");
            } else if height < -0.7 {
                assert_eq!(color, [0.1, 0.2, 0.3], "{height}");
            }
        }
        // Four standard deviations.
        assert!((f64::from(white) - 1800.0).abs() < 4.0 * (6000.0f64 * 0.21).sqrt(), "{white}");
    }
}
