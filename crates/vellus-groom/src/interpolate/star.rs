//! The neighbourhood of a guide on the surface that the roots of guides lie on: its Voronoi cell, and the guides with
//! which it shares a border.

use super::tree::Tree;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Neighbours that may share a border. In a plane there are six on average.
const NEAR: usize = 12;

/// A cell reaches this far at most, as a multiple of the mean distance of the four nearest guides. In a square lattice,
/// corners are at 0.71.
const REACH: f32 = 0.8;

/// Corners of a cell without neighbours.
const CORNERS: usize = 8;

/// A guide and its neighbours in the plane that is tangent to the surface. Coordinates are relative to the guide.
pub(super) struct Star {
    /// The guides with which the cell shares a border, by angle.
    pub around: Vec<(usize, Vec2)>,
    /// The corners of the cell, counterclockwise. It is convex.
    pub cell: Vec<Vec2>,
    /// The area of the cell; 0 if there are too few neighbours for [`Star::place`].
    pub area: f32,
    /// The normal of the plane. Its sign has no meaning.
    pub normal: Vec3,
}

/// Where a point of a cell lies: three guides with their weights. The first one is that of the cell.
pub(super) struct Place {
    pub guides: [usize; 3],
    /// Affine coordinates of the point; they add up to 1 and may be negative.
    pub affine: [f32; 3],
}

impl Star {
    /// The star of guide `i`. `leaving` has the direction in which each guide leaves the surface: neighbours that leave
    /// in the opposite direction grow on another surface, or on the other side of a parting.
    pub fn new(i: usize, tree: &Tree<'_>, roots: &[Vec3], leaving: &[Vec3]) -> Self {
        let near = tree.nearest(i, NEAR, &|j| leaving[i].dot(leaving[j]) > 0.0);
        let offsets: Vec<Vec3> = near.iter().map(|&j| roots[j] - roots[i]).collect();
        let normal = normal(&offsets, leaving[i]);
        let (u, v) = normal.any_orthonormal_pair();
        // Distances stay those in space, as on a surface that is bent.
        let flat = |d: &Vec3| Vec2::new(d.dot(u), d.dot(v)).normalize_or_zero() * d.length();
        let flat: Vec<Vec2> = offsets.iter().map(flat).collect();
        let mean = offsets.iter().take(4).map(|d| d.length()).sum::<f32>() / offsets.len().clamp(1, 4) as f32;
        let corner = |k: usize| REACH * mean * Vec2::from_angle(TAU * (k as f32 + 0.5) / CORNERS as f32);
        let mut cell: Vec<Vec2> = (0..CORNERS).map(corner).collect();
        flat.iter().for_each(|&q| clip(&mut cell, q));
        let is_border = |q: Vec2| {
            let beside = |x: &Vec2| (x.dot(q) / q.length_squared() - 0.5).abs() < 1e-3;
            q != Vec2::ZERO && cell.iter().filter(|x| beside(x)).count() >= 2
        };
        let mut around: Vec<(usize, Vec2)> =
            near.into_iter().zip(flat.iter().copied()).filter(|(_, q)| is_border(*q)).collect();
        around.sort_by(|a, b| a.1.to_angle().total_cmp(&b.1.to_angle()));
        let mut star = Star { around, cell, area: 0.0, normal };
        if star.best_pair().is_some() {
            star.area = star.triangles().map(|[_, b, c]| 0.5 * b.perp_dot(c)).sum();
        }
        star
    }

    /// The triangles of the cell; the first corner of each is the guide.
    fn triangles(&self) -> impl Iterator<Item = [Vec2; 3]> + '_ {
        (0..self.cell.len()).map(|k| [Vec2::ZERO, self.cell[k], self.cell[(k + 1) % self.cell.len()]])
    }

    /// A point of the cell for two numbers in [0, 1). Uniform numbers give uniform points.
    pub fn point(&self, [a, b]: [f32; 2]) -> Vec2 {
        let mut left = a * self.area;
        for [_, p, q] in self.triangles() {
            let area = 0.5 * p.perp_dot(q);
            if left < area {
                let (r, s) = (b.sqrt(), left / area);
                return r * ((1.0 - s) * p + s * q);
            }
            left -= area;
        }
        Vec2::ZERO
    }

    /// The triangle of the guide and two of its neighbours that contains a point, or the best one if there is none.
    pub fn place(&self, guide: usize, point: Vec2) -> Option<Place> {
        let pairs = (0..self.around.len()).map(|k| [k, (k + 1) % self.around.len()]);
        let inside = pairs.clone().find(|&[a, b]| {
            let [p, q] = [a, b].map(|k| self.around[k].1);
            is_wide(p, q) && p.perp_dot(point) >= 0.0 && point.perp_dot(q) >= 0.0
        });
        let [a, b] = inside.or_else(|| self.best_pair())?;
        let [(i, p), (j, q)] = [a, b].map(|k| self.around[k]);
        let whole = p.perp_dot(q);
        let (s, t) = (point.perp_dot(q) / whole, p.perp_dot(point) / whole);
        Some(Place { guides: [guide, i, j], affine: [1.0 - s - t, s, t] })
    }

    /// The two neighbours at the angle that is closest to 90°.
    fn best_pair(&self) -> Option<[usize; 2]> {
        let count = self.around.len();
        let pairs = (0..count).flat_map(|a| (0..count).map(move |b| [a, b]));
        let pairs = pairs.filter(|[a, b]| is_wide(self.around[*a].1, self.around[*b].1));
        let sine = |[a, b]: [usize; 2]| self.around[a].1.normalize().perp_dot(self.around[b].1.normalize());
        pairs.max_by(|&a, &b| sine(a).total_cmp(&sine(b)))
    }
}

/// Whether the angle from `p` to `q`, counterclockwise, is between 6° and 174°.
fn is_wide(p: Vec2, q: Vec2) -> bool {
    p.perp_dot(q) > 0.1 * p.length() * q.length()
}

/// Keeps the part of a convex polygon that is nearer to 0 than to `q`.
fn clip(polygon: &mut Vec<Vec2>, q: Vec2) {
    let inside = |p: Vec2| 0.5 * q.length_squared() - p.dot(q);
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let next = polygon[(k + 1) % polygon.len()];
        let (a, b) = (inside(p), inside(next));
        if a >= 0.0 {
            kept.push(p);
        }
        if (a >= 0.0) != (b >= 0.0) {
            kept.push(p.lerp(next, a / (a - b)));
        }
    }
    *polygon = kept;
}

/// The direction in which offsets vary least: the smallest eigenvector of their covariance, by power iteration from
/// `start`.
fn normal(offsets: &[Vec3], start: Vec3) -> Vec3 {
    let trace: f32 = offsets.iter().map(|d| d.length_squared()).sum();
    let start = start.normalize_or(Vec3::Z);
    (0..32).fold(start, |n, _| {
        let next = trace * n - offsets.iter().map(|d| d.dot(n) * *d).sum::<Vec3>();
        next.normalize_or(start)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square lattice: each cell is a unit square, and the weights of a point are those of the triangle around it.
    #[test]
    fn the_cell_of_a_lattice_is_a_square() {
        let roots: Vec<Vec3> = (0..49).map(|k| Vec3::new((k % 7) as f32, 0.5, (k / 7) as f32)).collect();
        let leaving = vec![Vec3::Y; 49];
        let tree = Tree::new(&roots);
        let star = Star::new(24, &tree, &roots, &leaving);
        assert!((star.area - 1.0).abs() < 1e-5 && (star.normal.y.abs() - 1.0).abs() < 1e-5);
        for k in 0..100 {
            let at = star.point([k as f32 / 100.0, (k * 37 % 100) as f32 / 100.0]);
            assert!(at.abs().max_element() <= 0.5 + 1e-5, "{at}");
            let place = star.place(24, at).unwrap();
            let point: Vec3 = place.guides.iter().zip(place.affine).map(|(&i, w)| w * roots[i]).sum();
            assert!((point.distance(roots[24]) - at.length()).abs() < 1e-4);
            assert!(place.affine.iter().all(|w| *w > -1e-4) && (place.affine.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        }
        // At an edge a cell ends.
        let edge = Star::new(3, &tree, &roots, &leaving).area;
        assert!(edge > 0.9 && edge < 1.4, "{edge}");
    }

    #[test]
    fn strands_of_another_surface_are_no_neighbours() {
        // Two layers of an ear: close together, with hair on both sides.
        let roots: Vec<Vec3> =
            (0..50).map(|k| Vec3::new((k % 5) as f32, (k / 25) as f32 * 0.2, (k / 5 % 5) as f32)).collect();
        let leaving: Vec<Vec3> = (0..50).map(|k| if k < 25 { -Vec3::Y } else { Vec3::Y }).collect();
        let tree = Tree::new(&roots);
        let star = Star::new(12, &tree, &roots, &leaving);
        assert!(star.around.iter().all(|(j, _)| *j < 25) && star.around.len() >= 4);
        // A guide alone gets no cell.
        assert_eq!(Star::new(0, &Tree::new(&roots[..1]), &roots[..1], &leaving[..1]).area, 0.0);
    }
}
