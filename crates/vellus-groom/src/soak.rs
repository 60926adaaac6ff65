//! Wet coats: strands lie down and stick together.

use crate::interpolate::{Tree, root_normals, roots};
use glam::Vec3;
use rayon::prelude::*;
use vellus_scene::Strands;

/// Strands in a clump that is all wet. Published pictures of wet fur have dozens.
const CLUMP: f32 = 40.0;

/// How much of its height above the skin a short strand loses that is all wet. One that is half as long as the body
/// hangs, and loses none.
const FLAT: f32 = 0.5;

/// How far tips move to the middle of their clump if they are all wet.
const GATHERED: f32 = 0.95;

/// How soon, from root to tip, strands come together. Below 1 it is near the root.
const POWER: f32 = 0.6;

/// Makes a coat wet by a share in [0, 1]: strands lie down on the skin, and those around each fortieth strand come
/// together, most of all their tips (the idea is that of Bruderlin 1999, "A method to generate wet and broken-up animal
/// fur"). Roots, widths and lengths along the skin stay.
///
/// `rest` has the same strands in the pose that says which strands stick together, such as the first frame of an
/// animation; its number of strands must be that of `strands`, or `strands` is used instead.
///
/// Fibres in water have another index, too: [`vellus::Fiber::wet`].
pub fn soak(strands: &mut Strands, rest: Option<&Strands>, wet: f32) {
    let wet = wet.clamp(0.0, 1.0);
    if wet == 0.0 || strands.is_empty() {
        return;
    }
    let middles = middles(rest.filter(|rest| rest.len() == strands.len()).unwrap_or(strands));
    let normals = root_normals(strands);
    let roots = roots(strands);
    let [low, high] = [roots.iter().copied().reduce(Vec3::min), roots.iter().copied().reduce(Vec3::max)];
    let size = (high.unwrap_or_default() - low.unwrap_or_default()).max_element();
    let flat = |points: &[Vec3]| FLAT * wet * (1.0 - 2.0 * length(points) / size.max(f32::MIN_POSITIVE)).max(0.0);
    let open: Vec<Vec3> = strands.points.iter().map(|point| point.truncate()).collect();
    let pose = |points: &[Vec3]| -> Vec<Vec3> {
        let range = |i: usize| strands.starts[i] as usize..strands.starts[i + 1] as usize;
        let low = |i: usize| lie_down(&points[range(i)], normals[i], flat(&points[range(i)]));
        let flat: Vec<Vec<Vec3>> = (0..strands.len()).into_par_iter().map(low).collect();
        let gather = |i: usize| gathered(&flat[i], &flat[middles[i]], wet * own(i));
        (0..strands.len()).into_par_iter().flat_map_iter(gather).collect()
    };
    let [open, moved] = [Some(&*open), strands.moved.as_deref()].map(|points| points.map(&pose));
    for (point, place) in strands.points.iter_mut().zip(open.into_iter().flatten()) {
        *point = place.extend(point.w);
    }
    strands.moved = moved;
}

/// The middle of the clump of each strand: one of the strands.
fn middles(strands: &Strands) -> Vec<usize> {
    let roots = roots(strands);
    let tree = Tree::new(&roots);
    let is_middle = |i: usize| Strands::rank(i) < 1.0 / CLUMP;
    let nearest = |i: usize| tree.nearest(i, 1, &is_middle).first().copied().unwrap_or(i);
    (0..roots.len()).into_par_iter().map(|i| if is_middle(i) { i } else { nearest(i) }).collect()
}

/// How strongly a strand holds to its clump, in [½, 1]: all tips would meet in one point otherwise.
fn own(i: usize) -> f32 {
    1.0 - 0.5 * ((i as u32).wrapping_mul(0x9e37_79b9) as f32 / u32::MAX as f32).powi(2)
}

fn length(points: &[Vec3]) -> f32 {
    points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// A strand closer to its skin. Each segment turns toward the skin, and keeps its length.
fn lie_down(points: &[Vec3], normal: Vec3, flat: f32) -> Vec<Vec3> {
    let mut at = points[0];
    let mut low = vec![at];
    for pair in points.windows(2) {
        let segment = pair[1] - pair[0];
        let turned = segment - normal * (flat * segment.dot(normal).max(0.0));
        at += turned.normalize_or_zero() * segment.length();
        low.push(at);
    }
    low
}

/// A strand that holds to another one. No point moves by more than half of the strand's length.
fn gathered(points: &[Vec3], middle: &[Vec3], strength: f32) -> Vec<Vec3> {
    let most = 0.5 * length(points);
    let last = (points.len() - 1).max(1) as f32;
    let place = |(k, point): (usize, &Vec3)| {
        let share = k as f32 / last;
        let at = share * (middle.len() - 1) as f32;
        let (i, t) = (at as usize, at.fract());
        let toward = middle[i].lerp(middle[(i + 1).min(middle.len() - 1)], t) - *point;
        *point + (GATHERED * strength * share.powf(POWER) * toward).clamp_length_max(most * share)
    };
    points.iter().enumerate().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use glam::Vec4;
    use vellus_scene::Basis;

    /// Upright strands on a square, which move by `shift` while the shutter is open.
    fn field(shift: Vec3) -> Strands {
        let strand = |i: usize| {
            let root = Vec3::new((i % 60) as f32, 0.0, (i / 60) as f32) * 0.02;
            (0..4).map(move |k| (root + Vec3::new(0.05, 1.0, 0.0) * 0.1 * k as f32).extend(0.001))
        };
        let points: Vec<Vec4> = (0..3600).flat_map(strand).collect();
        Strands {
            basis: Basis::Linear,
            starts: (0..=3600).map(|i| 4 * i).collect(),
            moved: Some(points.iter().map(|point| point.truncate() + shift).collect()),
            points,
            name: "field".to_owned(),
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        }
    }

    #[test]
    fn wet_strands_are_lower_and_closer_together() {
        let dry = field(Vec3::X);
        let tips =
            |strands: &Strands| -> Vec<Vec3> { (0..strands.len()).map(|i| strands.strand(i)[3].truncate()).collect() };
        // The mean distance of a tip to the nearest other one.
        let gap = |tips: &[Vec3]| {
            let tree = Tree::new(tips);
            let nearest = |i: usize| tree.nearest(i, 1, &|_| true).first().map_or(0.0, |j| tips[i].distance(tips[*j]));
            (0..tips.len()).map(nearest).sum::<f32>() / tips.len() as f32
        };
        let height = |tips: &[Vec3]| tips.iter().map(|tip| tip.y).sum::<f32>() / tips.len() as f32;
        let mut before = tips(&dry);
        for wet in [0.5, 1.0] {
            let mut coat = dry.clone();
            soak(&mut coat, None, wet);
            assert_eq!(coat.validate(), Ok(()));
            let now = tips(&coat);
            assert!(gap(&now) < 0.8 * gap(&before) && height(&now) < height(&before), "{wet}");
            before = now;
            for (i, points) in (0..coat.len()).map(|i| (i, coat.strand(i))) {
                assert_eq!(points[0], dry.strand(i)[0], "roots stay");
            }
            // Both poses are the same coat.
            let moved = coat.moved.as_ref().unwrap();
            assert!(coat.points.iter().zip(moved).all(|(p, m)| (p.truncate() + Vec3::X).distance(*m) < 1e-5));
        }
        let mut same = dry.clone();
        soak(&mut same, None, 0.0);
        assert_eq!(same, dry);
    }

    /// Where strands belong is a matter of the first frame, so that clumps do not flicker.
    #[test]
    fn clumps_belong_to_the_pose_at_rest() {
        let rest = field(Vec3::ZERO);
        let mut bent = rest.clone();
        for point in &mut bent.points {
            point.x *= 1.0 + point.z;
        }
        let [mut own, mut at_rest] = [bent.clone(), bent];
        soak(&mut own, None, 1.0);
        soak(&mut at_rest, Some(&rest), 1.0);
        assert_ne!(own, at_rest);
    }

    #[test]
    fn every_scene_can_be_wet() {
        for name in ["cat", "hair", "hamster"] {
            let mut scene = scene(name, true).unwrap();
            for strands in scene.all_strands_mut() {
                soak(strands, None, 0.8);
                assert_eq!(strands.validate(), Ok(()), "{name}");
            }
        }
    }
}
