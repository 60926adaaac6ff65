//! The topology of a cage.

use super::level::{Faces, Level, NONE};
use super::{Boundary, Cage, Scheme};

/// From this sharpness on, an edge or a vertex is infinitely sharp (UsdGeomMesh).
const INFINITE: f32 = 10.0;

fn sharpness(authored: f32) -> f32 {
    if authored >= INFINITE { f32::INFINITY } else { authored.max(0.0) }
}

/// An edge: its smaller vertex, its larger one, and one of its corners.
type Key = (u32, u32, u32);

impl Level {
    /// The level 0 of a cage.
    pub(super) fn cage(cage: &Cage) -> Level {
        let mut starts = vec![0];
        let mut of = Vec::with_capacity(cage.corners.len());
        for (face, &count) in cage.counts.iter().enumerate() {
            of.resize(of.len() + count as usize, face as u32);
            starts.push(of.len() as u32);
        }
        let count = cage.corners.len();
        let mut level = Level {
            triangles: cage.scheme == Scheme::Loop,
            vertices: cage.vertices,
            faces: Faces::Any { starts, of },
            corners: cage.corners.to_vec(),
            edges: vec![NONE; count],
            twins: vec![NONE; count],
            firsts: Vec::new(),
            sharpness: Vec::new(),
            sharp: Vec::new(),
            specials: Vec::new(),
        };
        let mut keys: Vec<Key> = (0..count as u32)
            .map(|corner| {
                let [a, b] = [corner, level.next(corner)].map(|c| cage.corners[c as usize]);
                (a.min(b), a.max(b), corner)
            })
            .collect();
        keys.sort_unstable();
        let mut sharp = vec![0.0f32; cage.vertices];
        // The number of edges at each vertex without exactly two faces that agree.
        let mut open = vec![0u32; cage.vertices];
        for sides in keys.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (a, b, corner) = sides[0];
            let edge = level.firsts.len() as u32;
            sides.iter().for_each(|side| level.edges[side.2 as usize] = edge);
            level.firsts.push(corner);
            let twin = sides.get(1).map_or(NONE, |side| side.2);
            let agrees = |other: u32| {
                let opposite = level.corners[corner as usize] != level.corners[other as usize];
                opposite && level.face_of(corner) != level.face_of(other)
            };
            if sides.len() == 2 && a != b && agrees(twin) {
                level.twins[corner as usize] = twin;
                level.twins[twin as usize] = corner;
                level.sharpness.push(0.0);
            } else {
                level.sharpness.push(f32::INFINITY);
                open[a as usize] += 1;
                open[b as usize] += 1;
                if a == b {
                    sharp[a as usize] = f32::INFINITY;
                }
            }
        }
        for (ends, authored) in cage.creases {
            let (a, b) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            let Some((_, _, corner)) = keys.get(keys.partition_point(|key| (key.0, key.1) < (a, b))) else { continue };
            let edge = level.edges[*corner as usize] as usize;
            let [c, d] = level.ends_of(edge);
            if (c.min(d), c.max(d)) == (a, b) {
                level.sharpness[edge] = level.sharpness[edge].max(sharpness(*authored));
            }
        }
        for &(vertex, authored) in cage.sharp {
            sharp[vertex as usize] = sharp[vertex as usize].max(sharpness(authored));
        }
        level.sharpen(&mut sharp, &open, cage.boundary == Boundary::EdgesAndCorners);
        level.sharp = sharp.iter().enumerate().filter(|(_, s)| **s > 0.0).map(|(v, s)| (v as u32, *s)).collect();
        level.with_specials()
    }

    /// Makes vertices sharp where faces meet only at this vertex, and at corners with a single face.
    fn sharpen(&self, sharp: &mut [f32], open: &[u32], corners: bool) {
        let mut faces = vec![0u32; self.vertices];
        let mut first = vec![NONE; self.vertices];
        for (corner, &vertex) in self.corners.iter().enumerate() {
            faces[vertex as usize] += 1;
            first[vertex as usize] = corner as u32;
        }
        for vertex in (0..self.vertices).filter(|&vertex| first[vertex] != NONE) {
            if open[vertex] > 0 {
                // A single edge of this kind does not separate the faces.
                if open[vertex] == 1 || (corners && faces[vertex] == 1) {
                    sharp[vertex] = f32::INFINITY;
                }
                continue;
            }
            let (mut corner, mut count) = (self.left(first[vertex]), 1);
            while corner != first[vertex] && corner != NONE {
                (corner, count) = (self.left(corner), count + 1);
            }
            if count != faces[vertex] {
                sharp[vertex] = f32::INFINITY;
            }
        }
    }

    /// Whether each face has a vertex at the border: such faces are not shown if the boundary is not interpolated.
    pub fn at_border(&self) -> Vec<bool> {
        let mut is_border = vec![false; self.vertices];
        for (corner, _) in self.twins.iter().enumerate().filter(|(_, twin)| **twin == NONE) {
            for c in [corner as u32, self.next(corner as u32)] {
                is_border[self.corners[c as usize] as usize] = true;
            }
        }
        (0..self.face_count()).map(|face| self.face(face).any(|c| is_border[self.corners[c] as usize])).collect()
    }
}
