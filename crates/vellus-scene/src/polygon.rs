//! Triangulates polygons.
//!
//! Ears are cut off one after the other (G. Meisters, *Polygons have ears*, 1975). A corner is an ear if the triangle
//! with its neighbours contains no other corner, and only reflex corners can be in it. Existing crates take minutes for
//! polygons of some thousand corners that cross themselves.

use glam::{DVec2, DVec3, Vec3};

/// How many steps the search for ears may take for each corner. Polygons with fewer reflex corners never need more.
const STEPS: usize = 4096;

/// How much of the area of a polygon a triangle may turn the other way, from rounding.
const ROUNDING: f64 = 1e-6;

/// Divides a polygon into triangles, as the indices of their corners, which go around as the polygon does.
///
/// The result is the fan from the first corner where that covers the polygon, as it does for all convex ones. Corners
/// need not be in a plane: a concave polygon is seen along its normal (Newell's). Returns false if triangles turn the
/// other way, because the polygon crosses itself, or has so many reflex corners that the search takes too long.
pub fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) -> bool {
    let count = corners.len();
    let fan = |emit: &mut dyn FnMut([usize; 3])| (2..count).for_each(|i| emit([0, i - 1, i]));
    if count <= 3 {
        fan(&mut emit);
        return true;
    }
    let at = |i: usize| (corners[i] - corners[0]).as_dvec3();
    // Twice the area of each triangle of the fan, as a vector.
    let area = |i: usize| at(i - 1).cross(at(i));
    let normal: DVec3 = (2..count).map(area).sum();
    let size = normal.length_squared();
    if size == 0.0 || !size.is_finite() || (2..count).all(|i| area(i).dot(normal) >= -ROUNDING * size) {
        fan(&mut emit);
        return size.is_finite();
    }
    // The view along the largest component of the normal, from outside.
    let flat = |p: DVec3| match normal.abs() {
        n if n.z >= n.x && n.z >= n.y => DVec2::new(p.x * normal.z.signum(), p.y),
        n if n.y >= n.x => DVec2::new(p.z * normal.y.signum(), p.x),
        _ => DVec2::new(p.y * normal.x.signum(), p.z),
    };
    let points: Vec<DVec2> = (0..count).map(|i| flat(at(i))).collect();
    Ring::new(&points).clip(ROUNDING * size.sqrt(), &mut emit)
}

/// The corners that are left.
struct Ring<'a> {
    points: &'a [DVec2],
    /// The neighbours of each corner.
    before: Vec<usize>,
    after: Vec<usize>,
    /// The corners that may lie in an ear, because they are not convex. Some have become convex since, or are cut off.
    reflex: Vec<usize>,
    is_reflex: Vec<bool>,
    steps: usize,
}

/// Twice the area of a triangle, positive if it turns left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

impl<'a> Ring<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let count = points.len();
        let before = (0..count).map(|i| (i + count - 1) % count).collect();
        let after = (0..count).map(|i| (i + 1) % count).collect();
        let is_reflex = vec![false; count];
        let mut ring = Ring { points, before, after, reflex: Vec::new(), is_reflex, steps: 0 };
        ring.is_reflex = (0..count).map(|i| ring.turn_at(i) <= 0.0).collect();
        ring.reflex = (0..count).filter(|&i| ring.is_reflex[i]).collect();
        ring
    }

    fn turn_at(&self, i: usize) -> f64 {
        turn(self.points[self.before[i]], self.points[i], self.points[self.after[i]])
    }

    /// Cuts off ears until a triangle is left. Returns false if it cannot, or if the last triangle turns right by more
    /// than `rounding`.
    fn clip(mut self, rounding: f64, emit: &mut dyn FnMut([usize; 3])) -> bool {
        let (mut left, mut at, mut missed) = (self.points.len(), 0, 0);
        let most = self.points.len().saturating_mul(STEPS);
        // Whether corners on the edge of a triangle keep it from being an ear.
        let mut closed = true;
        while left > 3 {
            self.steps += 1;
            if self.steps > most || (missed >= left && !closed) {
                self.rest(at, left, emit);
                return false;
            }
            if missed >= left {
                (missed, closed) = (0, false);
            }
            let (before, after) = (self.before[at], self.after[at]);
            if !self.is_ear(at, closed) {
                (at, missed) = (after, missed + 1);
                continue;
            }
            emit([before, at, after]);
            (self.after[before], self.before[after]) = (after, before);
            self.is_reflex[at] = false;
            for corner in [before, after] {
                self.is_reflex[corner] = self.is_reflex[corner] && self.turn_at(corner) <= 0.0;
            }
            let Ring { reflex, is_reflex, .. } = &mut self;
            if reflex.len() > 2 * left {
                reflex.retain(|&i| is_reflex[i]);
            }
            // The next corner but one: neighbours in a row would make a fan of thin triangles.
            (left, at, missed) = (left - 1, self.after[after], 0);
        }
        self.rest(at, left, emit);
        self.turn_at(at) >= -rounding
    }

    /// Whether a corner can be cut off: it is convex and no other corner is in its triangle, or it has no area.
    fn is_ear(&mut self, at: usize, closed: bool) -> bool {
        let corners = [self.before[at], at, self.after[at]];
        let [a, b, c] = corners.map(|i| self.points[i]);
        let area = turn(a, b, c);
        if area <= 0.0 {
            return area == 0.0;
        }
        let is_inside = |i: usize| {
            let p = self.points[i];
            if p == a || p == b || p == c {
                return false;
            }
            let least = turn(a, b, p).min(turn(b, c, p)).min(turn(c, a, p));
            if closed { least >= 0.0 } else { least > 0.0 }
        };
        let mut tested = 0;
        let found = self.reflex.iter().any(|&i| {
            tested += 1;
            self.is_reflex[i] && !corners.contains(&i) && is_inside(i)
        });
        self.steps += tested;
        !found
    }

    /// The remaining corners as a fan.
    fn rest(&self, first: usize, left: usize, emit: &mut dyn FnMut([usize; 3])) {
        let mut at = self.after[first];
        for _ in 2..left {
            emit([first, at, self.after[at]]);
            at = self.after[at];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::{PI, TAU};

    fn triangles(corners: &[Vec3]) -> (Vec<[usize; 3]>, bool) {
        let mut all = Vec::new();
        let is_simple = triangulate(corners, |triangle| all.push(triangle));
        assert_eq!(all.len(), corners.len().max(2) - 2);
        (all, is_simple)
    }

    /// Twice the areas of the triangles, along the polygon's normal.
    fn areas(corners: &[Vec3]) -> (Vec<f32>, bool) {
        let area = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]);
        let normal: Vec3 = (2..corners.len()).map(|i| area([0, i - 1, i])).sum();
        let (all, is_simple) = triangles(corners);
        (all.into_iter().map(|triangle| area(triangle).dot(normal.normalize())).collect(), is_simple)
    }

    /// All triangles turn the same way, and together they have the area of the polygon.
    fn check(corners: &[Vec3], area: f32) {
        let (areas, is_simple) = areas(corners);
        let total: f32 = areas.iter().sum();
        let is_once = areas.iter().all(|area| *area >= -1e-5);
        assert!(is_simple && is_once && (0.5 * total / area - 1.0).abs() < 1e-4, "{areas:?}");
    }

    fn flat(corners: &[[f32; 2]]) -> Vec<Vec3> {
        corners.iter().map(|&[x, y]| Vec3::new(x, y, 0.0)).collect()
    }

    #[test]
    fn convex_polygons_are_fans() {
        let round: Vec<Vec3> = (0..7).map(|i| Vec3::new((i as f32).cos(), (i as f32).sin(), 2.0)).collect();
        assert_eq!(triangles(&round[..6]).0, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
        // A folded quad too, and one with corners on an edge.
        assert_eq!(triangles(&[Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.4), Vec3::Y]).0, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangles(&flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]])).0, [[0, 1, 2], [0, 2, 3]]);
    }

    /// A pentagon with a notch, and a quad with a reflex corner: from each corner, either way round, in any plane.
    #[test]
    fn concave_polygons_are_covered_once() {
        let notch = flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5], [0.0, 2.0]]);
        let dart = flat(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]]);
        for (corners, area) in [(notch, 2.5), (dart, 0.5)] {
            for turn in 0..corners.len() {
                for mirrored in [false, true] {
                    let mut turned = corners.clone();
                    turned.rotate_left(turn);
                    if mirrored {
                        turned.reverse();
                    }
                    for (x, y) in [(Vec3::X, Vec3::Y), (Vec3::Z, Vec3::X), (Vec3::Y, Vec3::Z), (Vec3::ONE, Vec3::X)] {
                        let y = y.reject_from(x).normalize();
                        let place = |p: &Vec3| p.x * x.normalize() + p.y * y + Vec3::new(5.0, -3.0, 8.0);
                        check(&turned.iter().map(place).collect::<Vec<_>>(), area);
                    }
                }
            }
        }
    }

    #[test]
    fn spirals_combs_and_holes_are_covered_once() {
        // A band between two spirals: r = 1 + a and r = 1.3 + a.
        let spiral = |i: usize, inner: bool| {
            let a = 0.1 * i as f32;
            (1.0 + a + if inner { 0.0 } else { 0.3 }) * Vec3::new(a.cos(), a.sin(), 0.0)
        };
        let band: Vec<Vec3> =
            (0..200).map(|i| spiral(i, false)).chain((0..200).rev().map(|i| spiral(i, true))).collect();
        let sectors = (0..199).map(|i| {
            let (a, b) = (1.0 + 0.1 * i as f32, 1.1 + 0.1 * i as f32);
            0.5 * 0.1f32.sin() * ((a + 0.3) * (b + 0.3) - a * b)
        });
        check(&band, sectors.sum());
        // A comb of 500 teeth that are 100 long.
        let mut comb: Vec<[f32; 2]> = (0..1001).map(|i| [i as f32, if i % 2 == 0 { 0.0 } else { 100.0 }]).collect();
        comb.extend([[1000.0, -1.0], [0.0, -1.0]]);
        check(&flat(&comb), 1000.0 * 51.0);
        // A square with a square hole, joined by an edge that is passed twice.
        let keyhole = [
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 3.0],
            [0.0, 3.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
        ];
        check(&flat(&keyhole), 8.0);
    }

    #[test]
    fn polygons_without_an_inside_are_bounded() {
        let star = |count: usize, turns: f32| -> Vec<Vec3> {
            (0..count)
                .map(|i| i as f32 / count as f32 * turns * TAU)
                .map(|a| Vec3::new(a.cos(), a.sin(), 0.0))
                .collect()
        };
        // A bow tie has no area, and another one has two sides.
        assert!(!triangles(&star(5, 2.0)).1);
        assert!(triangles(&flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])).1);
        assert!(!triangles(&flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]])).1);
        assert!(triangles(&[Vec3::ONE; 9]).1);
        assert!(!triangles(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::splat(f32::NAN)]).1);
        // Many corners: a star that crosses itself everywhere, corners in no order, and deep teeth all around.
        let count = 100_000;
        let noise = |i: usize| (i as f32 * 12.9898).sin() * 43758.547 % 1.0;
        let teeth = |i: usize| if i.is_multiple_of(2) { 1.0 } else { 0.25 + 0.1 * noise(i) };
        let around = |i: usize| teeth(i) * glam::Vec2::from_angle(i as f32 / count as f32 * TAU).extend(0.0);
        let started = std::time::Instant::now();
        triangles(&star(count, 40_001.0));
        triangles(&(0..count).map(|i| Vec3::new(noise(i), noise(i + count), PI)).collect::<Vec<_>>());
        triangles(&(0..count).map(around).collect::<Vec<_>>());
        // Three times 4 · 10⁸ steps at most.
        assert!(started.elapsed().as_secs() < 60, "{:?}", started.elapsed());
    }
}
