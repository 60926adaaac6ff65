//! Level of detail: fewer, wider strands where they are much thinner than a pixel.
//!
//! This is stochastic simplification (Cook, Halstead, Planck and Ryu 2007, "Stochastic Simplification of Aggregate
//! Detail"). Why fewer strands keep the colour of fur, and what else was tried: `docs/notes/2026-11-level-of-detail.md`.

use crate::integrator::view::View;
use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use vellus_scene::{Instance, Prototype, Scene, Simplified, Strands};

/// The width in pixels up to which strands are widened by default. Thinner fibres cannot be told apart.
pub const LOD_WIDTH: f32 = 0.5;

/// Strands are narrowed before they are left out. This happens to the ranks around the share that is kept, up to this
/// distance relative to the share.
const FADE: f32 = 0.25;

/// The largest width of a strand that is widened, relative to its length. Wider ones no longer look like fur.
const WIDEST: f32 = 0.05;

/// A version of a prototype with more of the strands than this share is not worth its memory.
const WORTH: f32 = 0.9;

/// Keeps fewer strands where they are thinner than `pixels` in a picture of `size` by the scene's camera. The others
/// get wider, up to `pixels`, so that they cover as much. Wider strands do not change.
///
/// A strand's width in pixels depends on its distance from the camera, and not on where the camera looks. The widths
/// are continuous in it: a strand gets narrow before it is left out. All pictures keep the same strands.
///
/// Prototypes get simplified versions, each for pixels twice as wide as those of the one before. Each path finds one of
/// the two versions that are nearest to the pixels at an instance ([`Instance::simplified`]), so nothing pops.
/// Prototypes without an instance are removed.
///
/// `pixels` is at least 0, and 0 changes nothing. A scene without a camera does not change.
pub fn simplify(scene: &mut Scene, size: [usize; 2], pixels: f32) {
    let Some(camera) = scene.camera.filter(|_| pixels > 0.0) else { return };
    let pixel = Pixel::new(&View::new(camera), size);
    for strands in &mut scene.strands {
        if let Some(fewer) = fewer(strands, |point| pixels * pixel.width(point)) {
            *strands = fewer;
        }
    }
    let bounds: Vec<_> = scene.prototypes.iter().map(Prototype::bounds).collect();
    let wanted: Vec<Wanted> = scene.instances.iter().map(|i| Wanted::new(i, bounds[i.prototype], &pixel)).collect();
    let levels: BTreeSet<(usize, i32)> = wanted.iter().flat_map(Wanted::levels).collect();
    let levels: Vec<(usize, i32)> = levels.into_iter().collect();
    let version = |&(prototype, level): &(usize, i32)| {
        let limit = pixels * (level as f32).exp2();
        version(&scene.prototypes[prototype], limit)
    };
    let mut versions: BTreeMap<(usize, i32), Prototype> =
        levels.par_iter().filter_map(|key| Some((*key, version(key)?))).collect();
    // The versions that are used, in a fixed order. A prototype is the version without a level.
    let key = |prototype, level: Option<i32>| {
        (prototype, level.filter(|&level| versions.contains_key(&(prototype, level))))
    };
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

/// What the paths shall find at an instance.
struct Wanted {
    prototype: usize,
    /// The base-2 logarithm of the width of a pixel, in the coordinates of the prototype: the integer below, and the
    /// share of paths that find the next level. `None` for an instance at the camera.
    level: Option<i32>,
    share: f32,
}

impl Wanted {
    fn new(instance: &Instance, bounds: Option<(Vec3, Vec3)>, pixel: &Pixel) -> Self {
        let prototype = instance.prototype;
        let scale = instance.scale().unwrap_or(1.0);
        let local = instance.to_world.inverse();
        // The width at the nearest point of the box around the prototype.
        let eyes = pixel.eyes.map(|eye| local.transform_point3(eye));
        let width = bounds.map_or(0.0, |(low, high)| {
            let center = (0.5 * (eyes[0] + eyes[1])).clamp(low, high);
            let nearest = [eyes[0].clamp(low, high), eyes[1].clamp(low, high), center];
            let near = |point: Vec3| pixel.width(instance.to_world.transform_point3(point)) / scale;
            nearest.into_iter().map(near).fold(f32::INFINITY, f32::min)
        });
        let logarithm = width.log2();
        if !logarithm.is_finite() {
            return Wanted { prototype, level: None, share: 0.0 };
        }
        let level = logarithm.floor();
        Wanted { prototype, level: Some(level as i32), share: logarithm - level }
    }

    /// The levels of the two versions.
    fn pair(&self) -> [Option<i32>; 2] {
        [self.level, self.level.map(|level| level + 1)]
    }

    fn levels(&self) -> impl Iterator<Item = (usize, i32)> {
        let prototype = self.prototype;
        self.pair().into_iter().flatten().map(move |level| (prototype, level))
    }
}

/// A prototype whose strands may be as wide as `limit`. `None` if nearly all of them would be kept.
fn version(prototype: &Prototype, limit: f32) -> Option<Prototype> {
    let fewer = |set: &Strands| fewer(set, |_| limit).unwrap_or_else(|| set.clone());
    let strands: Vec<Strands> = prototype.strands.iter().map(fewer).collect();
    let count = |sets: &[Strands]| sets.iter().map(Strands::len).sum::<usize>() as f32;
    let is_worth = count(&strands) < WORTH * count(&prototype.strands);
    is_worth.then(|| Prototype { name: prototype.name.clone(), strands, meshes: prototype.meshes.clone() })
}

/// Keeps strands that cover as much as all of them, and that are at most as wide as `limit` at each of their points.
/// `None` if all are wider already.
fn fewer(strands: &Strands, limit: impl Fn(Vec3) -> f32 + Sync) -> Option<Strands> {
    let factors: Vec<Option<f32>> =
        (0..strands.len()).into_par_iter().map(|i| factor(Strands::rank(i), share(strands, i, &limit))).collect();
    let is_same = factors.iter().all(|factor| *factor == Some(1.0));
    (!is_same).then(|| strands.select(|i| factors[i]))
}

/// The share of strands like this one that can cover as much, if they may be as wide as `limit`. At least 1 if this one
/// is as wide already.
fn share(strands: &Strands, strand: usize, limit: &impl Fn(Vec3) -> f32) -> f32 {
    let points = strands.strand(strand);
    let moved = strands.moved.as_ref().map(|moved| &moved[strands.starts[strand] as usize..][..points.len()]);
    let of_point = |(i, point): (usize, &Vec4)| {
        let open = limit(point.xyz());
        2.0 * point.w / moved.map_or(open, |moved| open.min(limit(moved[i])))
    };
    let length: f32 = points.windows(2).map(|pair| pair[0].xyz().distance(pair[1].xyz())).sum();
    let widest = points.iter().map(|point| 2.0 * point.w).fold(0.0, f32::max);
    points.iter().enumerate().map(of_point).fold(widest / (WIDEST * length), f32::max)
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
