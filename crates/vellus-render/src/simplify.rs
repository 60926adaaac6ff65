//! Level of detail: fewer, wider strands where they are much thinner than a pixel.
//!
//! This is stochastic simplification (Cook, Halstead, Planck and Ryu 2007, "Stochastic Simplification of Aggregate
//! Detail"). What it saves, its errors, and what else was tried: `docs/notes/2026-11-level-of-detail.md`.

use crate::error::Error;
use crate::integrator::view::View;
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;
use vellus_scene::{Instance, Prototype, Scene, Simplified, Strands};

/// The mean width in pixels up to which [`Lod::AUTO`] widens strands. Measured:
/// `docs/notes/2026-11-level-of-detail.md`, "Fewer, wider strands".
const WIDTH: f32 = 0.125;

/// Strands are narrowed before they are left out. This happens to the ranks around the share that is kept, up to this
/// distance relative to the share.
const FADE: f32 = 0.25;

/// The largest mean width up to which [`Lod::AUTO`] widens strands, relative to their mean length. Fur of wider strands
/// is too bright.
const WIDEST: f32 = 0.01;

/// A simplified prototype that would keep more than this share of its strands is not built.
const WORTH: f32 = 0.9;

/// Level of detail: up to which width strands are widened, see [`simplify()`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Lod {
    /// All strands are kept.
    #[default]
    Off,
    /// Strands are widened up to an eighth of a pixel and a hundredth of their length, both times two to the power of
    /// this number. It is in ±[`Lod::MAX_BIAS`].
    Bias(f32),
}

impl Lod {
    /// Strands are widened up to an eighth of a pixel and a hundredth of their length.
    pub const AUTO: Lod = Lod::Bias(0.0);

    /// The largest bias.
    pub const MAX_BIAS: f32 = 8.0;

    /// The limits of the widths. `None` is off.
    fn limits(self) -> Option<Limits> {
        match self {
            Lod::Off => None,
            Lod::Bias(bias) => Some(Limits { pixels: WIDTH * bias.exp2(), lengths: WIDEST * bias.exp2() }),
        }
    }

    /// The width in pixels up to which strands are widened. 0 is off.
    pub fn pixels(self) -> f32 {
        self.limits().map_or(0.0, |limits| limits.pixels)
    }
}

impl FromStr for Lod {
    type Err = Error;

    /// Reads `auto`, `off` or a bias.
    fn from_str(text: &str) -> Result<Self, Error> {
        match text {
            "off" => Ok(Lod::Off),
            "auto" => Ok(Lod::AUTO),
            _ => text.parse().ok().filter(|bias: &f32| bias.abs() <= Lod::MAX_BIAS).map(Lod::Bias).ok_or_else(|| {
                let most = Lod::MAX_BIAS;
                Error::Settings(format!("a level of detail is auto, off, or a number in [-{most}, {most}]"))
            }),
        }
    }
}

impl Display for Lod {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Lod::Off => f.write_str("off"),
            lod if *lod == Lod::AUTO => f.write_str("auto"),
            Lod::Bias(bias) => bias.fmt(f),
        }
    }
}

/// The largest mean width of strands: in pixels, and relative to their mean length.
#[derive(Clone, Copy)]
struct Limits {
    pixels: f32,
    lengths: f32,
}

/// Keeps fewer strands where they are thin in a picture of `size` by the scene's camera. The others get wider, so that
/// they cover as much. Their mean width does not exceed the limits of [`Lod`]. Strands that are wider already do not
/// change.
///
/// A strand's width in pixels depends on its distance from the camera, and not on where the camera looks. The widths
/// are continuous in it: a strand gets narrow before it is left out. All pictures keep the same strands.
///
/// Prototypes get simplified versions, each for pixels twice as wide as those of the one before. Each path finds one of
/// the two versions that are nearest to the pixels at an instance ([`Instance::simplified`]), so nothing pops.
/// Prototypes without an instance are removed.
///
/// [`Lod::Off`] changes nothing. Scenes without a camera do not change, and neither do invalid ones.
pub fn simplify(scene: &mut Scene, size: [usize; 2], lod: Lod) {
    let Some((camera, limits)) = scene.camera.zip(lod.limits()) else { return };
    if scene.validate().is_err() {
        return;
    }
    let pixel = Pixel::new(&View::new(camera), size);
    for strands in &mut scene.strands {
        if let Some(fewer) = fewer(strands, limits.lengths, |point| limits.pixels * pixel.width(point)) {
            *strands = fewer;
        }
    }
    simplify_instances(scene, &pixel, limits);
}

/// Replaces the prototypes by the versions that the instances need.
fn simplify_instances(scene: &mut Scene, pixel: &Pixel, limits: Limits) {
    let extents: Vec<Extent> = scene.prototypes.iter().map(|prototype| Extent::new(prototype, limits)).collect();
    let wanted: Vec<Wanted> = scene.instances.iter().map(|i| Wanted::new(i, &extents[i.prototype], pixel)).collect();
    let levels: BTreeSet<(usize, i32)> = wanted.iter().flat_map(Wanted::versions).collect();
    let levels: Vec<(usize, i32)> = levels.into_iter().collect();
    let version = |&(prototype, level): &(usize, i32)| {
        let limit = limits.pixels * (level as f32).exp2();
        version(&scene.prototypes[prototype], limits.lengths, limit)
    };
    let mut versions: BTreeMap<(usize, i32), Prototype> =
        levels.par_iter().filter_map(|key| Some((*key, version(key)?))).collect();
    // The versions that are used, in a fixed order. A prototype is the version without a level.
    let key =
        |prototype, level: Option<i32>| (prototype, level.filter(|&level| versions.contains_key(&(prototype, level))));
    let pairs: Vec<[(usize, Option<i32>); 2]> =
        wanted.iter().map(|wanted| wanted.pair().map(|level| key(wanted.prototype, level))).collect();
    let used: BTreeSet<(usize, Option<i32>)> = pairs.iter().flatten().copied().collect();
    let mut originals: Vec<Option<Prototype>> = std::mem::take(&mut scene.prototypes).into_iter().map(Some).collect();
    let mut index = BTreeMap::new();
    for (prototype, level) in used {
        let made = match level {
            Some(level) => versions.remove(&(prototype, level)),
            None => originals[prototype].take(),
        };
        index.insert((prototype, level), scene.prototypes.len());
        scene.prototypes.extend(made);
    }
    for (instance, (pair, wanted)) in scene.instances.iter_mut().zip(pairs.iter().zip(&wanted)) {
        let [fine, coarse] = pair.map(|key| index[&key]);
        instance.prototype = fine;
        instance.simplified = (coarse != fine).then_some(Simplified { prototype: coarse, share: wanted.share });
    }
}

/// The widths of pixels, by the distance from the camera.
struct Pixel {
    /// The positions of the camera when the shutter opens and closes.
    eyes: [Vec3; 2],
    /// The width at distance 1 in a corner of the picture, where a distance has the narrowest pixels.
    slope: f32,
}

impl Pixel {
    fn new(view: &View, size: [usize; 2]) -> Self {
        let slope = view.perspective(size).1;
        let [width, height] = size.map(|n| n as f32 * slope);
        let corner = Vec3::new(0.5 * width, 0.5 * height, 1.0).length();
        Pixel { eyes: view.eyes(), slope: slope / corner }
    }

    /// The smallest width of a pixel at a point while the shutter is open.
    fn width(&self, point: Vec3) -> f32 {
        let [open, closed] = self.eyes;
        let path = closed - open;
        let t = ((point - open).dot(path) / path.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        (open + t * path).distance(point) * self.slope
    }
}

/// What the level of detail of an instance depends on, besides its distance.
struct Extent {
    bounds: Option<(Vec3, Vec3)>,
    /// The largest useful level: all strands have the largest width. `None` without strands.
    coarsest: Option<i32>,
}

impl Extent {
    fn new(prototype: &Prototype, limits: Limits) -> Self {
        let longest = prototype.strands.iter().map(|set| Typical::new(set).length).fold(0.0, f32::max);
        let coarsest = (limits.lengths * longest / limits.pixels).log2().ceil();
        Extent { bounds: prototype.bounds(), coarsest: coarsest.is_finite().then_some(coarsest as i32) }
    }
}

/// What the paths shall find at an instance.
struct Wanted {
    prototype: usize,
    /// The base-2 logarithm of the width of a pixel, in the coordinates of the prototype: the integer below, the
    /// integer above, and the share of paths that find the latter. `None` for an instance at the camera.
    levels: Option<[i32; 2]>,
    share: f32,
}

impl Wanted {
    fn new(instance: &Instance, extent: &Extent, pixel: &Pixel) -> Self {
        let prototype = instance.prototype;
        let scale = instance.scale().unwrap_or(1.0);
        let local = instance.to_world.inverse();
        // The width at the nearest point of the box around the prototype.
        let eyes = pixel.eyes.map(|eye| local.transform_point3(eye));
        let width = extent.bounds.map_or(0.0, |(low, high)| {
            let center = (0.5 * (eyes[0] + eyes[1])).clamp(low, high);
            let nearest = [eyes[0].clamp(low, high), eyes[1].clamp(low, high), center];
            let near = |point: Vec3| pixel.width(instance.to_world.transform_point3(point)) / scale;
            nearest.into_iter().map(near).fold(f32::INFINITY, f32::min)
        });
        let logarithm = width.log2();
        let Some(coarsest) = extent.coarsest.filter(|_| logarithm.is_finite()) else {
            return Wanted { prototype, levels: None, share: 0.0 };
        };
        let level = logarithm.floor();
        let levels = [level as i32, level as i32 + 1].map(|level| level.min(coarsest));
        Wanted { prototype, levels: Some(levels), share: logarithm - level }
    }

    /// The levels of the two versions.
    fn pair(&self) -> [Option<i32>; 2] {
        self.levels.map_or([None; 2], |levels| levels.map(Some))
    }

    fn versions(&self) -> impl Iterator<Item = (usize, i32)> {
        let prototype = self.prototype;
        self.levels.into_iter().flatten().map(move |level| (prototype, level))
    }
}

/// A prototype whose strands may be as wide as `limit`. `None` if nearly all of them would be kept.
fn version(prototype: &Prototype, lengths: f32, limit: f32) -> Option<Prototype> {
    let fewer = |set: &Strands| fewer(set, lengths, |_| limit).unwrap_or_else(|| set.clone());
    let strands: Vec<Strands> = prototype.strands.iter().map(fewer).collect();
    let count = |sets: &[Strands]| sets.iter().map(Strands::len).sum::<usize>() as f32;
    let is_worth = count(&strands) < WORTH * count(&prototype.strands);
    is_worth.then(|| Prototype { name: prototype.name.clone(), strands, meshes: prototype.meshes.clone() })
}

/// Keeps strands that cover as much as all of them. Their mean width is at most `limit` at each of their points, and at
/// most `lengths` of their mean length.
/// `None` if all are wider already.
fn fewer(strands: &Strands, lengths: f32, limit: impl Fn(Vec3) -> f32 + Sync) -> Option<Strands> {
    let typical = Typical::new(strands);
    let factors: Vec<Option<f32>> = (0..strands.len())
        .into_par_iter()
        .map(|i| factor(Strands::rank(i), typical.share(strands, i, lengths, &limit)))
        .collect();
    let is_same = factors.iter().all(|factor| *factor == Some(1.0));
    (!is_same).then(|| strands.select(|i| factors[i]))
}

/// The mean strand of a set. All strands of a set are thinned alike: if thin strands were thinned more than wide ones,
/// the picture would change more.
struct Typical {
    /// The largest width along a strand.
    width: f32,
    length: f32,
}

impl Typical {
    fn new(strands: &Strands) -> Self {
        let widest = |points: &[Vec4]| points.iter().map(|point| 2.0 * point.w).fold(0.0, f32::max);
        let mean = |of: &dyn Fn(&[Vec4]) -> f32| {
            let sum: f64 = (0..strands.len()).map(|i| f64::from(of(strands.strand(i)))).sum();
            (sum / strands.len() as f64) as f32
        };
        Typical { width: mean(&widest), length: mean(&length) }
    }

    /// The share of strands at the place of this one that can cover as much, if they may be as wide as `limit` and as
    /// `lengths` of their length on average. At least 1 if they are already.
    fn share(&self, strands: &Strands, strand: usize, lengths: f32, limit: &impl Fn(Vec3) -> f32) -> f32 {
        let range = strands.starts[strand] as usize..strands.starts[strand + 1] as usize;
        let open = strands.points[range.clone()].iter().map(|point| limit(point.xyz()));
        let closed = strands.moved.iter().flat_map(|moved| &moved[range.clone()]).map(|point| limit(*point));
        let narrowest = open.chain(closed).fold(lengths * self.length, f32::min);
        self.width / narrowest
    }
}

/// The length of a strand's control polygon.
fn length(points: &[Vec4]) -> f32 {
    points.windows(2).map(|pair| pair[0].xyz().distance(pair[1].xyz())).sum()
}

/// By what to multiply the width of the strand with this rank, if this share of strands shall cover as much as all.
/// `None` leaves it out. The mean over all ranks is 1.
fn factor(rank: f32, share: f32) -> Option<f32> {
    // Strands without width do not change. Validation rejects invalid ones later.
    if !(share > 0.0 && share < 1.0) {
        return Some(1.0);
    }
    // The last rank that fades is at most 1.
    let fade = FADE.min(1.0 / share - 1.0) * share;
    let kept = ((share + fade - rank) / (2.0 * fade)).min(1.0);
    (kept > 0.0).then(|| kept / share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat4;
    use vellus::Fiber;
    use vellus_scene::{Basis, Camera, Look};

    /// Straight strands of these widths and length 1, one behind the other at distances 2 to 40 from the origin.
    fn strands(count: usize, width: impl Fn(usize) -> f32) -> Strands {
        let root = |i: usize| Vec3::new(0.0, -0.5, -2.0 - 38.0 * i as f32 / count as f32);
        let points = (0..count).flat_map(|i| [0.0, 1.0].map(|y| (root(i) + y * Vec3::Y).extend(0.5 * width(i))));
        Strands {
            name: "fur".to_owned(),
            basis: Basis::Linear,
            starts: (0..=count).map(|i| 2 * i as u32).collect(),
            points: points.collect(),
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: vec![],
        }
    }

    /// A camera at the origin whose pixels at distance 1 are 0.01 wide.
    fn camera() -> Camera {
        Camera { film_height: 1.0, ..Camera::look_at(Vec3::ZERO, -Vec3::Z, Vec3::Y, 0.9, 1.0) }
    }

    const SIZE: [usize; 2] = [100, 100];

    /// Half a pixel, and a twenty-fifth of the length.
    const HALF: Lod = Lod::Bias(2.0);
    const LENGTHS: f32 = 4.0 * WIDEST;

    fn scene(strands: Strands) -> Scene {
        let looks = vec![Look::constant("hair", Fiber::hair())];
        Scene { strands: vec![strands], looks, camera: Some(camera()), ..Scene::default() }
    }

    /// The mean over all ranks is 1, factors are at most 1/share, and change little between similar shares.
    #[test]
    fn factors_keep_the_coverage() {
        const N: usize = 100_000;
        let rank = |i: usize| (i as f32 + 0.5) / N as f32;
        for share in [0.001f32, 0.03, 0.3, 0.79, 0.81, 0.95, 0.999] {
            let mean = (0..N).filter_map(|i| factor(rank(i), share)).map(f64::from).sum::<f64>() / N as f64;
            // The rectangle rule resolves a fade of ±0.25 share, or of 1 − share, by N times that many ranks.
            assert!((mean - 1.0).abs() < 1e-3, "{share}: {mean}");
            for i in (0..N).step_by(97) {
                let [now, next] = [share, share * 1.0001].map(|share| factor(rank(i), share).unwrap_or(0.0));
                assert!(now <= 1.0 / share);
                // A fade takes 2 · 0.25 share of the ranks, or 2 (1 − share).
                let steepest = share / (2.0 * (0.25 * share).min(1.0 - 1.0001 * share));
                assert!((now - next).abs() * share < 1.1e-4 * (2.0 + 2.0 * steepest), "{share} {i}: {now} {next}");
            }
        }
        for share in [1.0, 7.0, f32::INFINITY, f32::NAN, 0.0] {
            assert_eq!(factor(0.999, share), Some(1.0));
        }
    }

    /// Strands that stay cover as much as before, and their mean width is at most half a pixel.
    #[test]
    fn thin_strands_become_fewer_and_wider() {
        let width = |i: usize| 0.004 * (1.0 + (i % 7) as f32);
        let mut before = scene(strands(20_000, width));
        // Five times as long.
        before.strands[0].points.iter_mut().for_each(|point| point.y *= 5.0);
        let mut after = before.clone();
        simplify(&mut after, SIZE, HALF);
        let (all, kept) = (&before.strands[0], &after.strands[0]);
        assert_eq!(after.validate(), Ok(()));
        let pixel = Pixel::new(&View::new(camera()), SIZE);
        let cover = |set: &Strands| set.points.iter().map(|p| f64::from(p.w)).sum::<f64>();
        let typical = Typical::new(all);
        assert!((typical.width - 0.016).abs() < 1e-5 && (typical.length - 5.0).abs() < 1e-5);
        // Sum of the variances of a strand that is kept with the probability p, and then has 1/p of its width.
        let mut variance = 0.0;
        for i in 0..all.len() {
            let share = f64::from(typical.share(all, i, LENGTHS, &|point| 0.5 * pixel.width(point)));
            variance += (2.0 * f64::from(all.strand(i)[0].w)).powi(2) * (1.0 / share - 1.0).max(0.0);
        }
        // A false alarm would be a deviation of five standard deviations. The ranks are fixed, so it happens never or
        // always.
        assert!((cover(kept) - cover(all)).abs() < 5.0 * variance.sqrt(), "{} {}", cover(kept), cover(all));
        assert!(kept.len() < all.len() / 2 && kept.len() > all.len() / 10, "{}", kept.len());
        let (mut wide, mut same) = (0, 0);
        for i in 0..kept.len() {
            let strand = kept.strand(i);
            let narrowest = strand.iter().map(|p| pixel.width(p.xyz())).fold(f32::INFINITY, f32::min);
            let original = all.points.iter().find(|p| p.xyz() == strand[0].xyz()).unwrap();
            let factor = strand[0].w / original.w;
            if factor == 1.0 {
                assert!(typical.width >= 0.5 * narrowest * 0.9999);
                same += 1;
            } else {
                assert!(factor * typical.width <= (0.5 * narrowest).min(5.0 * LENGTHS) * 1.0001);
                wide += 1;
            }
        }
        assert!(wide > 100 && same > 100, "{wide} {same}");
    }

    /// The strands of a picture from farther away are among those of a nearer one.
    #[test]
    fn farther_pictures_have_a_part_of_the_strands() {
        let all = scene(strands(5_000, |_| 0.001));
        let kept = |distance: f32| {
            let mut scene = all.clone();
            let eye = Vec3::Z * distance;
            scene.camera = Some(Camera { film_height: 1.0, ..Camera::look_at(eye, Vec3::ZERO, Vec3::Y, 0.9, 1.0) });
            simplify(&mut scene, SIZE, HALF);
            let strands = scene.strands.remove(0);
            strands.points.iter().map(|p| p.z.to_bits()).collect::<BTreeSet<u32>>()
        };
        let (near, far) = (kept(0.0), kept(3.0));
        assert!(far.is_subset(&near) && far.len() < near.len() && !far.is_empty());
    }

    /// A camera that only turns changes nothing.
    #[test]
    fn directions_of_view_do_not_matter() {
        let all = scene(strands(2_000, |_| 0.001));
        let seen = |target: Vec3| {
            let mut scene = all.clone();
            let camera = Camera::look_at(Vec3::ZERO, target, Vec3::Y, 0.9, 1.0);
            scene.camera = Some(Camera { film_height: 1.0, ..camera });
            simplify(&mut scene, SIZE, HALF);
            scene.strands
        };
        assert_eq!(seen(-Vec3::Z), seen(Vec3::X));
    }

    #[test]
    fn nothing_changes_without_a_width_or_a_camera() {
        let all = scene(strands(500, |_| 0.001));
        let mut same = all.clone();
        simplify(&mut same, SIZE, Lod::Off);
        assert_eq!(same, all);
        let blind = Scene { camera: None, ..all };
        let mut same = blind.clone();
        simplify(&mut same, SIZE, HALF);
        assert_eq!(same, blind);
        // Validation names the problem later.
        let mut invalid = scene(strands(500, |_| 0.001));
        invalid.strands[0].starts[7] = 9_999;
        invalid.instances = vec![Instance::new(3, Mat4::IDENTITY)];
        let mut same = invalid.clone();
        simplify(&mut same, SIZE, HALF);
        assert_eq!(same, invalid);
    }

    /// Instances of a prototype find the two versions around their distance. Near ones keep all strands.
    #[test]
    fn instances_get_versions_by_distance() {
        let fur = strands(4_000, |_| 0.0003);
        // The prototype is 38 long. Its instances are a hundredth of it, around the camera and up to 200 away.
        let prototype = Prototype { name: "fur".to_owned(), strands: vec![fur], meshes: vec![] };
        let place = |z: f32, scale: f32| {
            Mat4::from_translation(Vec3::new(0.0, 0.0, -z)) * Mat4::from_scale(Vec3::splat(0.01 * scale))
        };
        let unused = Prototype { name: "unused".to_owned(), ..Prototype::default() };
        let mut scene = Scene {
            strands: vec![],
            prototypes: vec![prototype.clone(), unused],
            instances: [(-0.1, 1.0), (0.001, 1.0), (1.3, 1.0), (20.0, 1.0), (200.0, 1.0), (20.0, 10.0)]
                .map(|(z, scale)| Instance::new(0, place(z, scale)))
                .to_vec(),
            ..scene(strands(1, |_| 1.0))
        };
        simplify(&mut scene, SIZE, HALF);
        assert_eq!(scene.validate(), Ok(()));
        assert!(scene.prototypes.iter().all(|p| p.name == "fur"));
        let count = |index: usize| scene.prototypes[index].strands[0].len();
        let pairs: Vec<(usize, usize, f32)> = scene
            .instances
            .iter()
            .map(|instance| {
                let simplified =
                    instance.simplified.unwrap_or(Simplified { prototype: instance.prototype, share: 0.0 });
                (count(instance.prototype), count(simplified.prototype), simplified.share)
            })
            .collect();
        assert_eq!(pairs[0], (4_000, 4_000, 0.0), "{pairs:?}");
        // Farther instances have fewer strands, down to those of the largest width.
        assert!(pairs[1..5].windows(2).all(|w| w[1].0 <= w[0].0), "{pairs:?}");
        assert!(pairs.iter().all(|&(fine, coarse, share)| fine >= coarse && (0.0..1.0).contains(&share)));
        assert!(pairs[1].0 < 4_000 && pairs[4].0 > 0 && pairs[4].0 == pairs[4].1, "{pairs:?}");
        // Ten times as large and ten times as far looks the same, but for the depth of the box.
        assert!(pairs[5].0 >= pairs[3].0);
        // No two versions are the same: all levels beyond that of the largest width are one.
        let counts: BTreeSet<usize> = (0..scene.prototypes.len()).map(count).collect();
        assert_eq!(counts.len(), scene.prototypes.len());
    }

    #[test]
    fn levels_have_names() {
        for (text, lod) in [("off", Lod::Off), ("auto", Lod::AUTO), ("1", Lod::Bias(1.0)), ("-2.5", Lod::Bias(-2.5))] {
            assert_eq!((text.parse::<Lod>().unwrap(), lod.to_string().as_str()), (lod, text));
        }
        assert_eq!([Lod::Off, Lod::AUTO, Lod::Bias(1.0)].map(Lod::pixels), [0.0, 0.125, 0.25]);
        for text in ["", "full", "nan", "9", "-inf"] {
            assert!(text.parse::<Lod>().is_err(), "{text}");
        }
    }
}
