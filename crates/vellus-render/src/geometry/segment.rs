//! One segment of a strand, and its intersection with a ray.
//!
//! A curved segment is the surface of a disk that is swept along the curve. The disk is perpendicular to the tangent
//! and has the curve's radius. At the ends of a strand, a ball closes it. A linear segment is the convex hull of the
//! balls at both ends, so neighbours join without a gap.

use crate::geometry::bvh::Bounds;
use crate::geometry::ray::Ray;
use crate::geometry::swept;
use glam::{Vec3, Vec4, Vec4Swizzles};
use vellus_scene::Basis;

/// A segment as a cubic Bézier curve of x, y, z and radius. For a linear segment, the first and the last point are its
/// ends.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Control points.
    pub points: [Vec4; 4],
    /// Whether the segment is linear, with a ball at each end.
    pub linear: bool,
}

/// The point at which a ray enters a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Distance along the ray.
    pub t: f32,
    /// Parameter along the segment, in [0, 1].
    pub u: f32,
}

impl Segment {
    /// The segment with the given control points: two for [`Basis::Linear`], otherwise four.
    pub fn new(basis: Basis, p: &[Vec4]) -> Self {
        let linear = basis == Basis::Linear;
        let points = match basis {
            Basis::Linear => [p[0], p[0] + (p[1] - p[0]) / 3.0, p[1] + (p[0] - p[1]) / 3.0, p[1]],
            Basis::Bezier => [p[0], p[1], p[2], p[3]],
            Basis::BSpline => [
                (p[0] + 4.0 * p[1] + p[2]) / 6.0,
                (2.0 * p[1] + p[2]) / 3.0,
                (p[1] + 2.0 * p[2]) / 3.0,
                (p[1] + 4.0 * p[2] + p[3]) / 6.0,
            ],
            Basis::CatmullRom => [p[1], p[1] + (p[2] - p[0]) / 6.0, p[2] + (p[1] - p[3]) / 6.0, p[2]],
        };
        // The radius of an interpolating spline may overshoot below 0.
        Segment { points: points.map(|p| Vec4::new(p.x, p.y, p.z, p.w.max(0.0))), linear }
    }

    /// Position and radius at `u`.
    pub fn at(&self, u: f32) -> Vec4 {
        let v = 1.0 - u;
        let [a, b, c, d] = self.points;
        a * (v * v * v) + b * (3.0 * v * v * u) + c * (3.0 * v * u * u) + d * (u * u * u)
    }

    /// The derivative of [`Segment::at`] by `u`.
    pub fn slope(&self, u: f32) -> Vec4 {
        let v = 1.0 - u;
        let [a, b, c, d] = self.points;
        ((b - a) * (v * v) + (c - b) * (2.0 * v * u) + (d - c) * (u * u)) * 3.0
    }

    /// The unit tangent, toward the tip.
    pub fn tangent(&self, u: f32) -> Vec3 {
        // The chord replaces the tangent if control points coincide.
        let chord = (self.points[3] - self.points[0]).xyz();
        self.slope(u).xyz().normalize_or(chord.normalize_or(Vec3::X))
    }

    /// An upper bound of the radius.
    pub fn largest_radius(&self) -> f32 {
        self.points.iter().fold(0.0, |r, p| r.max(p.w))
    }

    /// The chord, shifted by half of the curve's offset in the middle. This halves the deviation of a curve that bends
    /// to one side.
    pub fn chord(&self) -> [Vec3; 2] {
        let [a, _, _, d] = self.points.map(Vec4Swizzles::xyz);
        let shift = self.shift();
        [a + shift, d + shift]
    }

    /// Half of the offset of the curve's middle from the middle of the line between the ends.
    fn shift(&self) -> Vec3 {
        let [x, y] = self.offsets();
        (x + y) * (3.0 / 16.0)
    }

    /// The offsets of the inner control points from the points at thirds of the line between the ends.
    fn offsets(&self) -> [Vec3; 2] {
        let [a, b, c, d] = self.points.map(Vec4Swizzles::xyz);
        [b - a.lerp(d, 1.0 / 3.0), c - a.lerp(d, 2.0 / 3.0)]
    }

    /// An upper bound of the distance from the curve to its chord: the largest distance of the control points of both
    /// halves.
    pub fn deviation(&self) -> f32 {
        let [a, d] = self.chord();
        let chord = d - a;
        let off = |p: Vec3| {
            let s = ((p - a).dot(chord) / chord.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
            (a + chord * s).distance(p)
        };
        if self.linear {
            0.0
        } else {
            halves(self.points.map(Vec4Swizzles::xyz)).into_iter().map(off).fold(0.0, f32::max)
        }
    }

    /// An upper bound of the distance from a point of the curve to the chord's point with the same parameter. It is a
    /// convex function of the control points. If these move in straight lines, it is largest at the start or the end of
    /// the motion.
    pub fn stray(&self) -> f32 {
        let ([x, y], shift) = (self.offsets(), self.shift());
        let apart = [-shift, x - shift, y - shift, -shift];
        if self.linear { 0.0 } else { halves(apart).into_iter().map(Vec3::length).fold(0.0, f32::max) }
    }

    /// An upper bound of the change of the radius per length; 1 if no smaller bound is known.
    pub fn taper(&self) -> f32 {
        let [a, b, c, d] = self.points;
        let along = (d - a).xyz().normalize_or_zero();
        let steps = [b - a, c - b, d - c];
        let change = steps.iter().fold(0.0f32, |most, s| most.max(s.w.abs()));
        let length = steps.iter().fold(f32::INFINITY, |least, s| least.min(s.xyz().dot(along)));
        if change < length { change / length } else { 1.0 }
    }

    /// A bounding box: that of its control points and the largest radius.
    pub fn bounds(&self) -> Bounds {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for p in self.points.map(Vec4Swizzles::xyz) {
            (low, high) = (low.min(p), high.max(p));
        }
        let r = self.largest_radius();
        (low - r, high + r)
    }

    /// The first entry of a ray from outside, within the ray's length.
    pub fn intersect(&self, ray: &Ray) -> Option<Entry> {
        if self.linear { self.enter_cone(ray) } else { swept::enter(&self.points, ray) }
    }

    /// The same as [`Segment::intersect`], and the balls at the ends of a strand. `caps` are the ends of this segment
    /// that have one.
    #[inline]
    pub fn intersect_capped(&self, ray: &Ray, caps: [bool; 2]) -> Option<Entry> {
        let entry = self.intersect(ray);
        if caps == [false; 2] { entry } else { self.enter_caps(ray, caps, entry) }
    }

    #[cold]
    fn enter_caps(&self, ray: &Ray, caps: [bool; 2], entry: Option<Entry>) -> Option<Entry> {
        let mut best = entry;
        for (cap, u, ball) in [(caps[0], 0.0, self.points[0]), (caps[1], 1.0, self.points[3])] {
            let from = ray.origin - ball.xyz();
            let half = from.dot(ray.direction);
            // From the point of the ray nearest to the centre, where distances keep their digits.
            let room = ball.w * ball.w - (from - half * ray.direction).length_squared();
            let t = -half - room.max(0.0).sqrt();
            if cap && room >= 0.0 && t > 0.0 && t < ray.t_max && best.is_none_or(|best| t < best.t) {
                best = Some(Entry { t, u });
            }
        }
        best
    }

    /// Intersects the hull of two balls: the cone that touches both, or one of the balls.
    fn enter_cone(&self, ray: &Ray) -> Option<Entry> {
        let (a, b) = (self.points[0], self.points[3]);
        let (axis, rise) = ((b - a).xyz(), b.w - a.w);
        let from = ray.origin - a.xyz();
        let d = ray.direction;
        // Start at the point of the ray nearest to the first end. Distances of many radii would lose all digits.
        let start = -from.dot(d);
        let from = from + d * start;
        let (length2, along) = (axis.length_squared(), axis.dot(d));
        // q is a point relative to the first end, where the surface touches the ball of parameter u. It satisfies
        // q·axis − u (length² − rise²) + r₀ rise = 0 and |q − u axis| = r₀ + u rise. Eliminating u gives a quadratic in
        // the ray's distance.
        let slant = length2 - rise * rise;
        let mut best: Option<Entry> = None;
        let mut offer = |t: f32, u: f32| {
            if t > 0.0 && t < ray.t_max && best.is_none_or(|b| t < b.t) {
                best = Some(Entry { t, u });
            }
        };
        if slant > 0.0 {
            let (k, m) = (from.dot(axis) + a.w * rise, along);
            // |q|² − r₀² = (k + m t)²/slant.
            let qa = slant - m * m;
            let qb = slant * from.dot(d) - k * m;
            let qc = slant * (from.length_squared() - a.w * a.w) - k * k;
            let discriminant = qb * qb - qa * qc;
            if qa > 0.0 && discriminant >= 0.0 {
                let t = (-qb - discriminant.sqrt()) / qa;
                let u = (k + m * t) / slant;
                if (0.0..=1.0).contains(&u) {
                    offer(t + start, u);
                }
            }
        }
        for (u, ball) in [(0.0, a), (1.0, b)] {
            let q = from - u * axis;
            let (half, rest) = (q.dot(d), q.length_squared() - ball.w * ball.w);
            let discriminant = half * half - rest;
            if discriminant >= 0.0 {
                offer(-half - discriminant.sqrt() + start, u);
            }
        }
        best
    }
}

/// The control points of both halves of a cubic (de Casteljau).
fn halves([a, b, c, d]: [Vec3; 4]) -> [Vec3; 7] {
    let (ab, bc, cd) = (a.midpoint(b), b.midpoint(c), c.midpoint(d));
    let (abc, bcd) = (ab.midpoint(bc), bc.midpoint(cd));
    [a, ab, abc, abc.midpoint(bcd), bcd, cd, d]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(i: usize, k: u32) -> f32 {
        ((i as f32 * 12.9898 + k as f32 * 78.233).sin() * 43758.547).rem_euclid(1.0)
    }

    fn vector(i: usize, k: u32) -> Vec3 {
        Vec3::new(noise(i, k), noise(i, k + 1), noise(i, k + 2)) * 2.0 - 1.0
    }

    /// A bent and tapered curve, like a hair.
    fn curve(i: usize, bend: f32, linear: bool) -> Segment {
        let basis = if linear { Basis::Linear } else { Basis::Bezier };
        let step = vector(i, 1).normalize();
        let mut p = vector(i, 4);
        let mut points = Vec::new();
        for k in 0..4 {
            points.push(p.extend(0.05 * (1.0 - 0.2 * k as f32)));
            p += 0.3 * (step + bend * vector(i, 7 + 3 * k)).normalize();
        }
        Segment::new(basis, if linear { &points[..2] } else { &points })
    }

    /// Marches along the ray in small steps, to the first point that is closer to the curve than the radius there.
    fn march(segment: &Segment, ray: &Ray) -> Option<f32> {
        let inside = |p: Vec3| {
            (0..=400).any(|k| {
                let u = k as f32 / 400.0;
                let c = segment.at(u);
                c.xyz().distance(p) < c.w
            })
        };
        (0..2500).map(|k| 0.002 * k as f32).find(|&t| inside(ray.at(t)))
    }

    /// Compares with marching along the ray, which intersects balls instead of disks. The results differ at the ends,
    /// where a curved segment is open, and by the square of the taper.
    #[test]
    #[ignore = "test: marching along 2,400 rays"]
    fn entries_are_where_marching_finds_them() {
        for (linear, bend) in [(true, 0.0), (false, 0.05), (false, 0.4), (false, 0.9)] {
            let (mut both, mut wrong) = (0, 0);
            for i in 0..600 {
                let segment = curve(i, bend, linear);
                let aim = segment.at(0.1 + 0.8 * noise(i, 40));
                let target = aim.xyz() + vector(i, 41) * 1.5 * aim.w;
                let origin = target + vector(i, 44).normalize() * 2.0;
                let ray = Ray::new(origin, (target - origin).normalize());
                match (segment.intersect(&ray), march(&segment, &ray)) {
                    (Some(entry), Some(t)) => {
                        both += 1;
                        wrong += i32::from((entry.t - t).abs() > 0.01);
                        let point = segment.at(entry.u);
                        let normal = ray.at(entry.t) - point.xyz();
                        assert!((normal.length() / point.w - 1.0).abs() < 0.03, "{i} {normal} {point}");
                    }
                    (None, None) => {}
                    _ => wrong += 1,
                }
            }
            println!("linear {linear} bend {bend}: {both} hits, {wrong} differ");
            assert!(both > 200 && wrong * 40 < both, "linear {linear} bend {bend}: {wrong} of {both}");
        }
    }

    /// Rays along a straight strand hit a disc of its radius, and rays at an angle the ball.
    #[test]
    fn a_cap_is_seen_end_on() {
        let point = |x: f32| Vec4::new(x, 0.0, 0.0, 0.1);
        let segment = Segment::new(Basis::Bezier, &[point(0.0), point(1.0), point(2.0), point(3.0)]);
        for i in 0..100 {
            let beside = 0.2 * noise(i, 1);
            let (sin, cos) = (6.3 * noise(i, 2)).sin_cos();
            let from_tip = Ray::new(Vec3::new(5.0, beside * cos, beside * sin), -Vec3::X);
            assert_eq!(segment.intersect_capped(&from_tip, [false; 2]), None);
            let entry = segment.intersect_capped(&from_tip, [false, true]);
            assert_eq!(entry.map(|entry| entry.u), (beside <= 0.1).then_some(1.0), "{beside}");
            if let Some(Entry { t, .. }) = entry {
                assert!((t - (2.0 - (0.01 - beside * beside).sqrt())).abs() < 1e-5, "{t}");
            }
            let from_root =
                Ray { origin: Vec3::new(-4.0, beside * cos, beside * sin), ..Ray::new(Vec3::ZERO, Vec3::X) };
            let entry = segment.intersect_capped(&from_root, [true, false]);
            assert_eq!(entry.map(|entry| entry.u), (beside <= 0.1).then_some(0.0), "{beside}");
        }
        // From the side, the wall is hit as before.
        let side = Ray::new(Vec3::new(1.5, 0.0, 2.0), -Vec3::Z);
        assert_eq!(segment.intersect_capped(&side, [true; 2]), segment.intersect(&side));
    }

    #[test]
    fn bounds_and_deviation_hold_the_curve() {
        for i in 0..200 {
            let segment = curve(i, 0.9, false);
            let (low, high) = segment.bounds();
            let [a, d] = segment.chord();
            for k in 0..=50 {
                let p = segment.at(k as f32 / 50.0);
                assert!((p.xyz() - p.w).cmpge(low - 1e-6).all() && (p.xyz() + p.w).cmple(high + 1e-6).all());
                let s = ((p.xyz() - a).dot(d - a) / (d - a).length_squared()).clamp(0.0, 1.0);
                assert!((a + (d - a) * s).distance(p.xyz()) <= segment.deviation().min(segment.stray()) + 1e-6);
            }
        }
    }
}
