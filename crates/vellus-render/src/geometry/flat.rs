//! Strands whose section is an ellipse.
//!
//! The radius of a strand is the longer semi-axis. A ray that enters the round strand of this radius is intersected
//! with the elliptical cylinder there. So hits, silhouettes and shadows agree with the projected width.

use crate::geometry::curves::ends;
use crate::geometry::ray::Ray;
use crate::geometry::segment::{Entry, Segment};
use glam::{Vec2, Vec3, Vec4Swizzles};
use vellus::FiberFrame;
use vellus_scene::Strands;

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
