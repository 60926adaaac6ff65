//! Intersects a ray with the surface of a disk that is swept along a cubic. This uses Newton's method on the curve's
//! parameter, with a cone as the local model of the curve (after Reshetov and Luebke 2018, Phantom Ray-Hair
//! Intersector). The number of starting points depends on the bend of the curve.
//!
//! The origin of the coordinates is the ray's origin, and their third axis is the ray. Half of the products are then
//! zero.

use crate::geometry::ray::{Ray, orthonormal_basis};
use crate::geometry::segment::Entry;
use glam::{Vec4, Vec4Swizzles};

/// Newton's method ends when a step in the curve's parameter is this small. Over this step, the curve deviates from the
/// cone by half of the square of the step, times the length and the turn of the piece. A piece turns by at most 0.2
/// (see `pieces`). For a piece that is fifteen radii long, the deviation is less than a thousandth of the radius.
const CLOSE: f32 = 0.02;

/// The first entry of a ray from outside, within the ray's length. `points` are Bézier control points with radii.
pub fn enter(points: &[Vec4; 4], ray: &Ray) -> Option<Entry> {
    let curve = Cubic::new(points, ray);
    let pieces = pieces(points);
    let mut best: Option<Entry> = None;
    for i in 0..pieces {
        let range = [i as f32 / pieces as f32, (i + 1) as f32 / pieces as f32];
        // A root outside of this piece is found in the piece that it belongs to.
        if let Some(entry) = curve.newton(ray.t_max, range)
            && best.is_none_or(|b| entry.t < b.t)
        {
            best = Some(entry);
        }
    }
    best
}

/// The number of pieces, such that the tangent turns little in each.
fn pieces(points: &[Vec4; 4]) -> usize {
    let [a, b, c, d] = points.map(Vec4Swizzles::xyz);
    let (x, y, z) = (b - a, c - b, d - c);
    let (xx, yy, zz) = (x.length_squared(), y.length_squared(), z.length_squared());
    // 1 − cos of the two turns of the control polygon. Up to 8° is one piece.
    let bend = 2.0 - (x.dot(y) * zz.sqrt() + y.dot(z) * xx.sqrt()) / (xx * yy * zz).sqrt().max(f32::MIN_POSITIVE);
    if bend < 0.02 {
        1
    } else if bend < 0.2 {
        2
    } else {
        4
    }
}

/// A cubic in the coordinates of the ray: the coefficients of x, y, distance along the ray, and radius.
struct Cubic {
    powers: [Vec4; 4],
}

/// A step of Newton's method.
struct Step {
    /// The step along the curve, in its parameter.
    step: f32,
    /// Distance along the ray.
    t: f32,
    /// Whether the ray hits the cone. If not, this is the closest approach, and the ray may still hit the curve.
    meets: bool,
}

impl Cubic {
    fn new(points: &[Vec4; 4], ray: &Ray) -> Self {
        let (u, v) = orthonormal_basis(ray.direction);
        let d = ray.direction;
        let axes = [Vec4::new(u.x, v.x, d.x, 0.0), Vec4::new(u.y, v.y, d.y, 0.0), Vec4::new(u.z, v.z, d.z, 0.0)];
        let origin = ray.origin.extend(0.0);
        let [a, b, c, d] = points.map(|p| {
            let q = p - origin;
            axes[0] * q.x + axes[1] * q.y + axes[2] * q.z + Vec4::new(0.0, 0.0, 0.0, p.w)
        });
        let (first, second, third) = (b - a, c - b, d - c);
        Cubic { powers: [a, 3.0 * first, 3.0 * (second - first), third - second - second + first] }
    }

    fn at(&self, u: f32) -> Vec4 {
        let [a, b, c, d] = self.powers;
        ((d * u + c) * u + b) * u + a
    }

    fn slope(&self, u: f32) -> Vec4 {
        let [_, b, c, d] = self.powers;
        (d * (3.0 * u) + (c + c)) * u + b
    }

    fn newton(&self, t_max: f32, [low, high]: [f32; 2]) -> Option<Entry> {
        // Start at the ray's closest approach to the piece's chord.
        let (a, b) = (self.at(low).xy(), self.at(high).xy());
        let chord = b - a;
        let s = -a.dot(chord) / chord.length_squared().max(f32::MIN_POSITIVE);
        let mut u = low + (high - low) * s.clamp(0.0, 1.0);
        let slack = 0.05 * (high - low);
        for _ in 0..12 {
            let Step { step, t, meets } = cone_step(self.at(u), self.slope(u))?;
            let next = u + step.clamp(-0.5, 0.5);
            if step.abs() < CLOSE {
                if !meets {
                    return None;
                }
                let inside = next >= low - 1e-4 && next <= high + 1e-4;
                return (inside && t > 0.0 && t < t_max).then_some(Entry { t, u: next.clamp(0.0, 1.0) });
            }
            // The method may leave the piece a little and return.
            if (next < low - slack && u <= low - slack) || (next > high + slack && u >= high + slack) {
                return None;
            }
            u = next.clamp(low - 2.0 * slack, high + 2.0 * slack);
        }
        None
    }
}

/// The entry of the ray into the infinite cone around the tangent at a point. `None` if the ray is nearly parallel to
/// the cone.
fn cone_step(point: Vec4, slope: Vec4) -> Option<Step> {
    let (p, s) = (point.xy(), slope.xy());
    let length2 = (s.length_squared() + slope.z * slope.z).max(f32::MIN_POSITIVE);
    let inverse = 1.0 / length2;
    // Consider the ray's point at the distance of `point` plus t. Its position along the axis is w₀ + w₁ t, in the
    // curve's parameter. The squared distance from the axis minus the squared radius there is qa t² + 2 qb t + qc.
    let (w0, w1) = (-p.dot(s) * inverse, slope.z * inverse);
    let (r0, r1) = (point.w + slope.w * w0, slope.w * w1);
    let qa = 1.0 - slope.z * w1 - r1 * r1;
    let qb = -w0 * slope.z - r0 * r1;
    let qc = p.length_squared() - w0 * w0 * length2 - r0 * r0;
    if qa <= 0.0 {
        return None;
    }
    let discriminant = qb * qb - qa * qc;
    let t = (-qb - discriminant.max(0.0).sqrt()) / qa;
    Some(Step { step: w0 + w1 * t, t: point.z + t, meets: discriminant >= 0.0 })
}
