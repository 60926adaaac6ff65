//! Denser grooms: strands between the strands that are there.

mod shape;
mod star;
mod tree;

use crate::error::Error;
use crate::flatten::course;
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use shape::Shapes;
use star::Star;
pub(crate) use tree::Tree;
use vellus_scene::{Strands, Values};

/// The area of a cell counts as at most this multiple of the median, so that a guide alone does not get a heap.
const LARGEST: f32 = 4.0;

/// How strands follow their guides.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Interpolation {
    /// How far tips move to the nearest guide, in [0, 1].
    #[cfg_attr(feature = "clap", arg(long, default_value_t = 0.0, value_name = "X"))]
    pub clump: f32,
    /// Random variation of the length, as a share of it; in [0, 1).
    #[cfg_attr(feature = "clap", arg(long, default_value_t = 0.1, value_name = "X"))]
    pub length_variation: f32,
    /// Seed of the random numbers.
    #[cfg_attr(feature = "clap", arg(long, default_value_t = 1, value_name = "N"))]
    pub seed: u64,
}

impl Default for Interpolation {
    fn default() -> Self {
        Interpolation { clump: 0.0, length_variation: 0.1, seed: 1 }
    }
}

/// Where new strands grow between guides. It belongs to one pose of the guides and is good for all of their poses, so
/// that strands do not flicker in an animation.
struct Binding {
    strands: Vec<Bound>,
}

/// A new strand.
#[derive(Clone, Copy, Debug)]
struct Bound {
    /// The guide that is nearest, and two of its neighbours.
    guides: [u32; 3],
    /// Affine coordinates of the root in the triangle of their roots.
    root: [f32; 3],
    /// The distance of the root from the plane of the triangle, in units of the root of twice its area.
    height: f32,
    /// Weights of the shapes of the guides: not negative, with the sum 1.
    weights: [f32; 3],
    /// A random number in [0, 1).
    random: f32,
}

/// Interpolates between strands: returns them and, after them, about `factor` − 1 new ones for each, for `factor` ≥ 1.
///
/// New roots lie on the surface of the roots that are there, in proportion to area. Each strand has barycentric weights
/// of three guides around it. They give its course and all of its values; waves and curls are those of the nearest
/// guide, because the mean of curls with different phases is straight. Strands that leave the surface in opposite
/// directions do not mix: a parting stays one, and hair does not grow between the two sides of an ear. Widths stay.
///
/// `rest` has the same guides in the pose that says where strands grow, such as the first frame of an animation; its
/// number of strands must be that of `strands`, or `strands` is used instead.
///
/// # Errors
/// [`Error::Setting`] if `factor` or a setting is out of range, or if there would be more than 2³² − 1 points.
pub fn interpolate(
    strands: &Strands,
    rest: Option<&Strands>,
    factor: f32,
    settings: Interpolation,
) -> Result<Strands, Error> {
    let check = |name, value: f32, most, range| {
        let is_good = (0.0..=most).contains(&value);
        is_good.then_some(()).ok_or(Error::Setting { name, value, range })
    };
    check("clump", settings.clump, 1.0, "it must be in [0, 1]")?;
    check("length_variation", settings.length_variation, 0.999, "it must be in [0, 1)")?;
    let points = strands.points.len() as f64 * f64::from(factor);
    if !(factor >= 1.0 && points < f64::from(u32::MAX)) {
        let range = "it must be at least 1, and leave fewer than 2^32 points";
        return Err(Error::Setting { name: "strands", value: factor, range });
    }
    let rest = rest.filter(|rest| rest.len() == strands.len()).unwrap_or(strands);
    Ok(Binding::new(rest, factor, settings.seed).apply(strands, settings))
}

/// The start of each curve, which is not always its first control point.
pub(crate) fn roots(strands: &Strands) -> Vec<Vec3> {
    let root = |points: &mut Vec<_>, i| {
        points.clear();
        course(strands.basis, strands.strand(i), 1, points);
        points.first().map_or(Vec3::ZERO, |p| p.truncate())
    };
    (0..strands.len()).into_par_iter().map_init(Vec::new, root).collect()
}

/// The direction in which each strand leaves the surface.
fn leaving(strands: &Strands, roots: &[Vec3]) -> Vec<Vec3> {
    let direction = |i: usize| {
        let points = strands.strand(i);
        // Beyond the first bends.
        let at = points[points.len() / 3].truncate() - roots[i];
        let tip = points.last().map_or(Vec3::ZERO, |p| p.truncate() - roots[i]);
        at.try_normalize().unwrap_or(tip.normalize_or_zero())
    };
    (0..strands.len()).into_par_iter().map(direction).collect()
}

fn stars(roots: &[Vec3], leaving: &[Vec3]) -> Vec<Star> {
    let tree = Tree::new(roots);
    (0..roots.len()).into_par_iter().map(|i| Star::new(i, &tree, roots, leaving)).collect()
}

/// The normal of the surface on which strands grow, at each root: a unit vector on the side on which they grow. It
/// belongs to the plane that fits the roots around best.
pub fn root_normals(strands: &Strands) -> Vec<Vec3> {
    let roots = roots(strands);
    let leaving = leaving(strands, &roots);
    let stars = stars(&roots, &leaving);
    stars.iter().zip(&leaving).map(|(star, leaving)| star.normal * star.normal.dot(*leaving).signum()).collect()
}

impl Binding {
    /// Distributes about (`factor` − 1) · n strands between n guides.
    fn new(guides: &Strands, factor: f32, seed: u64) -> Self {
        let roots = roots(guides);
        let stars = stars(&roots, &leaving(guides, &roots));
        let mut sorted: Vec<f32> = stars.iter().map(|star| star.area).filter(|area| *area > 0.0).collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let most = sorted.get(sorted.len() / 2).map_or(0.0, |median| LARGEST * median);
        let whole: f64 = sorted.iter().map(|area| f64::from(area.min(most))).sum();
        let wanted = (f64::from(factor) - 1.0) * guides.len() as f64 / whole.max(f64::MIN_POSITIVE);
        // The running sum of fractions decides which guide gets one more.
        let mut sum = 0.0;
        let counts: Vec<usize> = stars
            .iter()
            .map(|star| {
                let before = f64::floor(sum);
                sum += wanted * f64::from(star.area.min(most));
                (sum.floor() - before) as usize
            })
            .collect();
        let bound = |i: usize| {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ i as u64);
            let start: [f32; 2] = [rng.random(), rng.random()];
            let (stars, roots) = (&stars, &roots);
            // The points of a cell follow the R₂ sequence, which keeps them apart.
            let point = move |k: usize| {
                let r2 = |c: usize, a: f64| (f64::from(start[c]) + a * (k + 1) as f64).fract() as f32;
                stars[i].point([r2(0, 0.754_877_666_246_692_8), r2(1, 0.569_840_290_998_053_3)])
            };
            (0..counts[i]).filter_map(move |k| Bound::new(i, point(k), stars, roots, rng.random())).collect::<Vec<_>>()
        };
        Binding { strands: (0..guides.len()).into_par_iter().flat_map_iter(bound).collect() }
    }

    /// The guides and the new strands.
    fn apply(&self, guides: &Strands, settings: Interpolation) -> Strands {
        let old = guides.points.len();
        let lens = self.strands.iter().map(|bound| guides.strand(bound.guides[0] as usize).len() as u32);
        let mut starts = guides.starts.clone();
        starts.extend(lens.scan(old as u32, |end, len| {
            *end += len;
            Some(*end)
        }));
        let shapes = Shapes::new(guides, roots(guides));
        let new: Vec<_> = self.strands.par_iter().flat_map_iter(|bound| shapes.strand(bound, settings)).collect();
        let points = [&guides.points[..], &new].concat();
        let moved = guides.moved.as_ref().map(|moved| {
            let radii = moved.iter().zip(&guides.points).map(|(p, old)| p.extend(old.w)).collect();
            let closed = Strands {
                points: radii,
                moved: None,
                normals: None,
                varying: Vec::new(),
                root_uv: None,
                ..guides.clone()
            };
            let shapes = Shapes::new(&closed, roots(&closed));
            let new = self.strands.par_iter().flat_map_iter(|bound| shapes.strand(bound, settings));
            let new: Vec<Vec3> = new.map(|p| p.truncate()).collect();
            [&moved[..], &new].concat()
        });
        let mixed = |values: &[[f32; 3]], bound: &Bound| {
            let weighted = |c: usize| bound.weighted(|i| values[i as usize][c]);
            [0, 1, 2].map(weighted)
        };
        let varying = guides.varying.iter().map(|(parameter, values)| {
            let values = match values {
                Values::Constant(value) => Values::Constant(*value),
                Values::PerStrand(values) => {
                    let new = self.strands.iter().map(|bound| mixed(values, bound));
                    Values::PerStrand(values.iter().copied().chain(new).collect())
                }
                Values::PerPoint(values) => {
                    let new = self.strands.iter().flat_map(|bound| shape::along(guides, values, bound));
                    Values::PerPoint(values.iter().copied().chain(new).collect())
                }
            };
            (*parameter, values)
        });
        let varying = varying.collect();
        let root_uv = guides.root_uv.as_ref().map(|uv| {
            let new = self.strands.iter().map(|bound| bound.uv(uv));
            uv.iter().copied().chain(new).collect()
        });
        let normals = guides.normals.as_ref().map(|normals| {
            let rows: Vec<[f32; 3]> = normals.iter().map(|n| n.to_array()).collect();
            let new = self.strands.iter().flat_map(|bound| shape::along(guides, &rows, bound));
            normals.iter().copied().chain(new.map(Vec3::from)).collect()
        });
        Strands { starts, points, moved, normals, varying, root_uv, name: guides.name.clone(), ..*guides }
    }
}

impl Bound {
    /// A strand at a point of the cell of guide `i`.
    fn new(i: usize, point: Vec2, stars: &[Star], roots: &[Vec3], random: f32) -> Option<Self> {
        let place = stars[i].place(i, point)?;
        let corners = place.guides.map(|j| roots[j]);
        let flat: Vec3 = corners.iter().zip(place.affine).map(|(corner, w)| w * *corner).sum();
        // The mean of tangent planes is above a surface that is bent by as much as the triangle is below it, to second
        // order.
        let bent = place.guides.iter().zip(place.affine).map(|(&j, w)| {
            let normal = stars[j].normal;
            0.5 * w * (roots[j] - flat).dot(normal) * normal
        });
        let (normal, size) = plane(corners);
        let height = bent.sum::<Vec3>().dot(normal) / size.max(f32::MIN_POSITIVE);
        let weights = place.affine.map(|w| w.max(0.0));
        let sum: f32 = weights.iter().sum();
        Some(Bound {
            guides: place.guides.map(|j| j as u32),
            root: place.affine,
            // Where planes contradict each other, the triangle is the best guess.
            height: height.clamp(-0.5, 0.5),
            weights: weights.map(|w| w / sum),
            random,
        })
    }

    /// The root for the roots of all guides.
    fn at(&self, roots: &[Vec3]) -> Vec3 {
        let corners = self.guides.map(|j| roots[j as usize]);
        let (normal, size) = plane(corners);
        corners.iter().zip(self.root).map(|(corner, w)| w * *corner).sum::<Vec3>() + self.height * size * normal
    }

    /// The weighted mean of a number of each guide.
    fn weighted(&self, number: impl Fn(u32) -> f32) -> f32 {
        self.guides.iter().zip(self.weights).map(|(&i, w)| w * number(i)).sum()
    }

    /// Texture coordinates: those of the nearest guide where neighbours lie beyond a seam.
    fn uv(&self, uv: &[Vec2]) -> Vec2 {
        let [own, a, b] = self.guides.map(|i| uv[i as usize]);
        let [near, far] = [a, b].map(|other| other.distance(own));
        if near.max(far) > 4.0 * near.min(far) {
            own
        } else {
            self.guides.iter().zip(self.weights).map(|(&i, w)| w * uv[i as usize]).sum()
        }
    }
}

/// The normal of a triangle, and the root of twice its area.
fn plane([a, b, c]: [Vec3; 3]) -> (Vec3, f32) {
    let cross = (b - a).cross(c - a);
    (cross.normalize_or_zero(), cross.length().sqrt())
}
