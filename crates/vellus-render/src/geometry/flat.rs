//! Strands whose section is an ellipse.
//!
//! The radius of a strand is the longer semi-axis. A ray that enters the round strand of this radius is intersected
//! with the elliptical cylinder there. So hits, silhouettes and shadows agree with the projected width.

use crate::geometry::curves::{CurveHit, Curves, strand_of};
use crate::geometry::ray::Ray;
use crate::geometry::segment::{Entry, Segment};
use glam::{Vec2, Vec3, Vec4Swizzles};
use rayon::prelude::*;
use vellus::FiberFrame;
use vellus_scene::{Basis, Strands};

/// The section of a strand at a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// The direction of the longer axis. Its part along the tangent does not count.
    pub longer: Vec3,
    /// The shorter axis over the longer one.
    pub aspect_ratio: f32,
}

impl Section {
    /// The section of the segment that starts at a control point, at its parameter `u`.
    pub fn new(strands: &Strands, strand: usize, point: usize, segment: &Segment, u: f32, aspect_ratio: f32) -> Self {
        let shorter = match &strands.normals {
            Some(normals) => {
                let (first, last) = ends(strands.basis, point);
                normals[first].lerp(normals[last], u)
            }
            None => any_direction(strand),
        };
        Section { longer: segment.tangent(u).cross(shorter), aspect_ratio }
    }

    /// The frame of the fibre at a hit.
    pub fn frame(&self, segment: &Segment, u: f32) -> FiberFrame {
        let point = segment.at(u);
        FiberFrame::flat(segment.tangent(u), self.longer, point.xyz(), point.w, self.aspect_ratio)
    }

    /// Where a ray that enters the round strand enters this one, within the ray's length.
    pub fn enter(&self, segment: &Segment, ray: &Ray, round: Entry) -> Option<Entry> {
        let frame = self.frame(segment, round.u);
        let axes = frame.radius() * Vec2::new(1.0, self.aspect_ratio);
        let across = |w: Vec3| {
            let local = frame.to_local(w);
            Vec2::new(local.y, local.z) / axes
        };
        // From the entry into the round strand, where distances keep their digits.
        let (from, toward) = (across(ray.at(round.t) - frame.center()), across(ray.direction));
        let (a, half, rest) = (toward.length_squared(), from.dot(toward), from.length_squared() - 1.0);
        let room = half * half - a * rest;
        let t = match a > f32::MIN_POSITIVE {
            true if room < 0.0 => return None,
            true => {
                let [enters, leaves] = [-1.0, 1.0].map(|sign| (sign * room.sqrt() - half) / a);
                // The ball at the end of a strand begins later than the cylinder.
                (leaves >= 0.0).then_some(enters.max(0.0))?
            }
            // Along the strand.
            false => (rest < 0.0).then_some(0.0)?,
        };
        let t = round.t + t;
        (t > 0.0 && t < ray.t_max).then_some(Entry { t, u: round.u })
    }
}

/// The control points at both ends of the segment that starts at one.
pub(crate) fn ends(basis: Basis, point: usize) -> (usize, usize) {
    match basis {
        Basis::Linear => (point, point + 1),
        Basis::Bezier => (point, point + 3),
        Basis::BSpline | Basis::CatmullRom => (point + 1, point + 2),
    }
}

/// A direction for each strand, evenly over all directions.
fn any_direction(strand: usize) -> Vec3 {
    // The fractional parts of multiples of these numbers are evenly distributed over the square (Roberts 2018).
    let [u, v] =
        [0.754_877_666_246_693, 0.569_840_290_998_053].map(|x: f64| (x * (strand as f64 + 1.0)).fract() as f32);
    let z = 1.0 - 2.0 * u;
    let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * cos, r * sin, z)
}

impl CurveHit {
    /// The frame of the fibre.
    pub(crate) fn frame(&self) -> FiberFrame {
        let u = self.entry.u;
        match &self.section {
            Some(section) => section.frame(&self.segment, u),
            None => {
                let point = self.segment.at(u);
                FiberFrame::new(self.segment.tangent(u), point.xyz(), point.w)
            }
        }
    }
}

impl Curves {
    /// The same for a segment that is not round. The ray may start inside the round one, so it is followed from before.
    #[cold]
    pub(super) fn enter_flat(&self, first: u32, segment: &Segment, caps: [bool; 2], ray: &Ray) -> Option<Entry> {
        let back = 4.0 * segment.largest_radius() + segment.deviation();
        let longer = Ray { origin: ray.origin - back * ray.direction, t_max: ray.t_max + back, ..*ray };
        let entry = segment.intersect_capped(&longer, caps)?;
        let entry = Entry { t: entry.t - back, ..entry };
        self.section(first, segment, entry.u)?.enter(segment, ray, entry)
    }

    /// The aspect ratio of the fibres of the segment that starts at a control point, unless they are round.
    pub(super) fn aspect_ratio(&self, first: u32) -> Option<f32> {
        self.flat.get(self.points(first).0).copied().filter(|&ratio| ratio < 1.0)
    }

    /// The section at a parameter of the segment that starts at a control point, unless it is a circle.
    pub(super) fn section(&self, first: u32, segment: &Segment, u: f32) -> Option<Section> {
        let aspect_ratio = self.aspect_ratio(first)?;
        let set = self.points(first).0;
        let (strands, point) = (&self.strands[set], first - self.offsets[set]);
        let strand = strand_of(&strands.starts, point);
        Some(Section::new(strands, strand, point as usize, segment, u, aspect_ratio))
    }

    /// Sets the aspect ratio of the fibres of each set from that of its look.
    pub(crate) fn set_aspect_ratios(&mut self, of_look: &impl Fn(usize) -> f32) {
        let flat: Vec<f32> = self.strands.iter().map(|set| of_look(set.look)).collect();
        let flat = if flat.iter().any(|&ratio| ratio < 1.0) { flat } else { Vec::new() };
        if flat == self.flat {
            return;
        }
        self.flat = flat;
        let mut blocks = std::mem::take(&mut self.blocks);
        blocks.par_iter_mut().for_each(|block| block.margins = self.margins(&block.first, self.moves()));
        self.blocks = blocks;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    const RADIUS: f32 = 0.1;
    const RATIO: f32 = 0.5;

    /// A strand along x, whose shorter axis is z.
    fn strand(basis: Basis) -> Curves {
        let points: Vec<Vec4> = (0..4).map(|i| Vec4::new(i as f32 - 1.5, 0.0, 0.0, RADIUS)).collect();
        let normals = Some(vec![Vec3::new(0.3, 0.0, 2.0); points.len()]);
        let name = "flat".to_owned();
        let starts = vec![0, 4];
        let (moved, root_uv, varying) = (None, None, Vec::new());
        let mut curves =
            Curves::new(vec![Strands { name, basis, starts, points, moved, normals, root_uv, look: 0, varying }]);
        curves.set_aspect_ratios(&|_| RATIO);
        curves
    }

    /// Rays from all sides hit it where they would hit the elliptical cylinder, at the offset at which they pass its
    /// axis. They start outside, and between the ellipse and the round strand.
    #[test]
    fn a_strand_is_as_wide_as_its_projection() {
        for basis in [Basis::Linear, Basis::BSpline, Basis::CatmullRom] {
            let curves = strand(basis);
            let (mut hits, mut misses) = (0, 0);
            for i in 0..400 {
                let (sin, cos) = (0.37 * i as f32).sin_cos();
                let along = 0.6 * (1.3 * i as f32).sin();
                let direction = Vec3::new(along, -cos, -sin).normalize();
                let offset = RADIUS * 1.1 * (2.1 * i as f32).sin();
                // The offset is positive on the side of ω_o × tangent.
                let aside = (-direction).cross(Vec3::X).normalize() * offset;
                let half = RADIUS * (sin * sin + (RATIO * cos).powi(2)).sqrt();
                // 1 % of the edge is left out for rounding.
                if (offset.abs() / half - 1.0).abs() < 0.01 {
                    continue;
                }
                let far = Ray::new(aside - 2.0 * direction, direction);
                let (hit, is_hit) = (curves.intersect(&far), offset.abs() < half);
                assert_eq!((hit.is_some(), curves.occluded(&far)), (is_hit, is_hit), "{basis:?} {i} {offset} {half}");
                let Some(hit) = hit else {
                    misses += 1;
                    continue;
                };
                hits += 1;
                let (frame, point) = (hit.frame(), far.at(hit.entry.t));
                let on = Vec2::new(point.y, point.z) / (RADIUS * Vec2::new(1.0, RATIO));
                assert!((on.length() - 1.0).abs() < 1e-3, "{basis:?} {i}: {point}");
                assert!((frame.half_width(-direction) - half).abs() < 1e-6);
                let h = frame.offset(point, -direction);
                assert!((h - offset / half).abs() < 1e-3, "{basis:?} {i}: {h} {offset} {half}");
                // From a point just before the hit, which the round strand may contain.
                let near = Ray::new(far.at(hit.entry.t - 0.02 * RADIUS), direction);
                let again = curves.intersect(&near).map(|hit| hit.entry.t);
                assert!(again.is_some_and(|t| (t - 0.02 * RADIUS).abs() < 2e-3 * RADIUS), "{basis:?} {i}: {again:?}");
                // A ray that leaves does not hit it again.
                let leaves = Ray::new(frame.beside(-direction, 1.001), -direction);
                assert!(curves.intersect(&leaves).is_none() && !curves.occluded(&leaves), "{basis:?} {i}");
            }
            assert!(hits > 150 && misses > 50, "{hits} {misses}");
        }
    }

    #[test]
    fn directions_of_strands_are_spread_evenly() {
        let mean = (0..1000).map(any_direction).sum::<Vec3>() / 1000.0;
        assert!(mean.length() < 0.01 && (any_direction(7).length() - 1.0).abs() < 1e-6, "{mean}");
    }
}
