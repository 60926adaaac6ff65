//! Limits of values, and normals of the limit surface.

use super::level::{Level, NONE};
use super::refine::{add, combine, loop_weight, valences};
use super::special::Kind;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

impl Level {
    /// The limits of the values of the vertices. All faces must be quads or, for Loop's scheme, triangles.
    pub(super) fn limit<const N: usize>(&self, values: &[[f32; N]]) -> Vec<[f32; N]> {
        let faces = valences(self);
        // For quads, neighbours along edges count four times as much as those across faces.
        let along = if self.triangles { 1.0 } else { 4.0 };
        let mut sums = vec![[0.0f64; N]; self.vertices];
        for [a, b] in self.ends() {
            add(&mut sums[a as usize], &values[b as usize], along);
            add(&mut sums[b as usize], &values[a as usize], along);
        }
        if !self.triangles {
            for (corner, &vertex) in self.corners.iter().enumerate() {
                add(&mut sums[vertex as usize], &values[self.across(corner as u32) as usize], 1.0);
            }
        }
        let smooth = |vertex: usize| {
            let n = f64::from(faces[vertex]);
            let (own, others) = match faces[vertex] {
                0 => (1.0, 0.0),
                _ if self.triangles => {
                    let others = 1.0 / (n + 0.375 / loop_weight(n));
                    (1.0 - n * others, others)
                }
                _ => (n / (n + 5.0), 1.0 / (n * (n + 5.0))),
            };
            let value = |k: usize| (own * f64::from(values[vertex][k]) + others * sums[vertex][k]) as f32;
            std::array::from_fn(value)
        };
        let mut limits: Vec<[f32; N]> = (0..self.vertices).map(smooth).collect();
        for special in &self.specials {
            let own = &values[special.vertex as usize];
            limits[special.vertex as usize] = match special.kind {
                Kind::Smooth => continue,
                Kind::Crease([a, b]) => {
                    combine(&[(2.0 / 3.0, own), (1.0 / 6.0, &values[a as usize]), (1.0 / 6.0, &values[b as usize])])
                }
                Kind::Corner => *own,
            };
        }
        limits
    }

    /// The vertex opposite to a corner in its quad.
    fn across(&self, corner: u32) -> u32 {
        self.corners[self.next(self.next(corner)) as usize]
    }

    /// The normals at all corners.
    pub(super) fn normals(&self, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut normals = vec![[f32::NAN; 3]; self.corners.len()];
        let mut sector = Vec::new();
        for corner in 0..self.corners.len() as u32 {
            if !normals[corner as usize][0].is_nan() {
                continue;
            }
            let vertex = self.corners[corner as usize];
            let special = self.specials.binary_search_by_key(&vertex, |special| special.vertex);
            let kind = special.map_or(Kind::Smooth, |i| self.specials[i].kind);
            let is_closed = self.sector(corner, kind, &mut sector);
            let normal = self.normal(&sector, kind, is_closed, points).normalize_or_zero().as_vec3().to_array();
            sector.iter().for_each(|&corner| normals[corner as usize] = normal);
        }
        normals
    }

    /// Collects the corners at a vertex, counterclockwise, up to the next sharp edges if the vertex is not smooth.
    /// Returns whether they go all around.
    fn sector(&self, corner: u32, kind: Kind, sector: &mut Vec<u32>) -> bool {
        let ends = |edge: u32| kind != Kind::Smooth && self.sharpness[edge as usize] > 0.0;
        let mut first = corner;
        while !ends(self.edges[first as usize]) {
            match self.right(first) {
                NONE => break,
                right if right == corner => break,
                right => first = right,
            }
        }
        sector.clear();
        sector.push(first);
        let mut last = first;
        while !ends(self.edges[self.previous(last) as usize]) {
            match self.left(last) {
                NONE => return false,
                left if left == first => return true,
                left => last = left,
            }
            sector.push(last);
        }
        false
    }

    /// The normal of a sector, of any length.
    fn normal(&self, sector: &[u32], kind: Kind, is_closed: bool, points: &[[f32; 3]]) -> DVec3 {
        let point = |vertex: u32| DVec3::from(points[vertex as usize].map(f64::from));
        let here = point(self.corners[sector[0] as usize]);
        let right = |corner: u32| point(self.corners[self.next(corner) as usize]) - here;
        let left = |corner: u32| point(self.corners[self.previous(corner) as usize]) - here;
        let across = |corner: u32| point(self.across(corner)) - here;
        let n = sector.len() as f64;
        // Weights apply to differences from the vertex: they add up to 0 with its own weight.
        let tangents = match kind {
            Kind::Smooth if is_closed => {
                let step = TAU / n;
                let edge = if self.triangles { 1.0 } else { edge_weight(step) };
                let tangent = |wave: fn(f64) -> f64, sum: DVec3, (i, &corner): (usize, &u32)| {
                    let (a, b) = (wave(step * i as f64), wave(step * (i + 1) as f64));
                    let face = if self.triangles { DVec3::ZERO } else { (a + b) * across(corner) };
                    sum + edge * a * right(corner) + face
                };
                let all = || sector.iter().enumerate();
                let x = all().fold(DVec3::ZERO, |sum, item| tangent(f64::cos, sum, item));
                let y = all().fold(DVec3::ZERO, |sum, item| tangent(f64::sin, sum, item));
                Some([x, y])
            }
            Kind::Crease(_) if !is_closed => {
                let last = left(sector[sector.len() - 1]);
                let step = PI / n;
                let along = right(sector[0]) - last;
                let inner = sector[1..].iter().zip(1..).map(|(&corner, i)| (step * f64::from(i)).sin() * right(corner));
                let inner: DVec3 = inner.sum();
                let ends = right(sector[0]) + last;
                // The left eigenvector of the mode that is 0 on both creases. All weights follow from those inside by
                // λb = a/8 + b/2 + …, for the weight b of the ends, and a of the vertex, which makes the sum 0.
                let (sine, sum) = (step.sin(), 1.0 / (0.5 * step).tan());
                let inward = if sector.len() == 1 {
                    ends
                } else if self.triangles {
                    inner + (sine - sum) / (1.0 + 2.0 * step.cos()) * ends
                } else {
                    let edge = edge_weight(step);
                    let face = |(&corner, i): (&u32, u32)| {
                        let (a, b) = ((step * f64::from(i)).sin(), (step * f64::from(i + 1)).sin());
                        (a + b) * across(corner)
                    };
                    let faces: DVec3 = sector.iter().zip(0..).map(face).sum();
                    edge * inner + faces + (sine * (edge + 4.0) - 2.0 * (edge + 2.0) * sum) / edge * ends
                };
                Some([along, inward])
            }
            _ => None,
        };
        let normal = tangents.map_or(DVec3::ZERO, |[x, y]| x.cross(y));
        // At corners, and where the tangents are parallel, the mean of the faces.
        let faces = || sector.iter().map(|&corner| right(corner).cross(left(corner))).sum();
        if normal.length_squared() > 0.0 { normal } else { faces() }
    }
}

/// The weight of neighbours along edges in the tangents of Catmull–Clark surfaces (Halstead et al.), if those across
/// faces have the weight 1. `step` is the angle of a face: 2π over the number of faces, or π over it at creases.
fn edge_weight(step: f64) -> f64 {
    1.0 + step.cos() + (0.5 * step).cos() * (2.0 * (9.0 + step.cos())).sqrt()
}
