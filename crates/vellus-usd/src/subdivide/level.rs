//! One level of refinement: its faces, edges and vertices, and those of the next level.

use super::special::{Special, specials};

/// No corner.
pub(super) const NONE: u32 = u32::MAX;

/// A mesh as corners. A corner is a vertex of a face, and it stands for the edge from there to the next corner.
pub(crate) struct Level {
    /// Whether faces become four triangles each. Otherwise they become one quad for each corner.
    pub(super) triangles: bool,
    pub(super) vertices: usize,
    pub(super) faces: Faces,
    /// The vertex of each corner.
    pub(super) corners: Vec<u32>,
    /// The edge of each corner.
    pub(super) edges: Vec<u32>,
    /// The corner of the neighbouring face with the same edge, or [`NONE`] at borders and where there is no single
    /// neighbour.
    pub(super) twins: Vec<u32>,
    /// One corner of each edge.
    pub(super) firsts: Vec<u32>,
    /// The sharpness of each edge.
    pub(super) sharpness: Vec<f32>,
    /// The sharpness of vertices, in their order. Others have 0.
    pub(super) sharp: Vec<(u32, f32)>,
    /// Vertices with another rule than that of smooth surfaces, in their order.
    pub(super) specials: Vec<Special>,
}

/// The corners of faces.
pub(super) enum Faces {
    /// The first corner of each face and the end of the last, and the face of each corner.
    Any { starts: Vec<u32>, of: Vec<u32> },
    /// All faces have this many.
    Equal(u32),
}

/// The sharpness of the parts of an edge, or of a vertex, on the next level.
pub(super) fn blunter(sharpness: f32) -> f32 {
    (sharpness - 1.0).max(0.0)
}

impl Level {
    /// The vertex of each corner, face by face.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// The vertices of all edges.
    pub fn ends(&self) -> impl Iterator<Item = [u32; 2]> {
        (0..self.firsts.len()).map(|edge| self.ends_of(edge))
    }

    pub(super) fn ends_of(&self, edge: usize) -> [u32; 2] {
        let corner = self.firsts[edge];
        [self.corners[corner as usize], self.corners[self.next(corner) as usize]]
    }

    /// The number of faces.
    pub fn face_count(&self) -> usize {
        match &self.faces {
            Faces::Any { starts, .. } => starts.len() - 1,
            Faces::Equal(n) => self.corners.len() / *n as usize,
        }
    }

    /// The corners of a face.
    pub fn face(&self, face: usize) -> std::ops::Range<usize> {
        match &self.faces {
            Faces::Any { starts, .. } => starts[face] as usize..starts[face + 1] as usize,
            Faces::Equal(n) => face * *n as usize..(face + 1) * *n as usize,
        }
    }

    /// The face of a corner.
    pub(super) fn face_of(&self, corner: u32) -> u32 {
        match &self.faces {
            Faces::Any { of, .. } => of[corner as usize],
            Faces::Equal(n) => corner / n,
        }
    }

    /// The face of this level that a face of the next level is a part of.
    pub(super) fn parent(&self, child: usize) -> usize {
        if self.triangles { child / 4 } else { self.face_of(child as u32) as usize }
    }

    /// The next corner of the same face.
    pub(super) fn next(&self, corner: u32) -> u32 {
        let range = self.face(self.face_of(corner) as usize);
        if corner as usize + 1 == range.end { range.start as u32 } else { corner + 1 }
    }

    /// The previous corner of the same face.
    pub(super) fn previous(&self, corner: u32) -> u32 {
        let range = self.face(self.face_of(corner) as usize);
        if corner as usize == range.start { range.end as u32 - 1 } else { corner - 1 }
    }

    /// The next corner at the same vertex, counterclockwise, or [`NONE`].
    pub(super) fn left(&self, corner: u32) -> u32 {
        self.twins[self.previous(corner) as usize]
    }

    /// The next corner at the same vertex, clockwise, or [`NONE`].
    pub(super) fn right(&self, corner: u32) -> u32 {
        let twin = self.twins[corner as usize];
        if twin == NONE { NONE } else { self.next(twin) }
    }

    /// Computes the rules of vertices.
    pub(super) fn with_specials(mut self) -> Self {
        self.specials = specials(&self);
        self
    }

    /// The next level. Its vertices are those of this level, then the points of edges, then those of faces. An edge
    /// becomes the edges 2e and 2e + 1, from its first and from its second vertex. After them there is one edge inside
    /// the face for each corner.
    pub(super) fn child(&self) -> Level {
        let (vertices, edges, count) = (self.vertices as u32, self.firsts.len() as u32, self.corners.len());
        let centers = vertices + edges;
        let size = 4 * count;
        let mut child = Level {
            triangles: self.triangles,
            vertices: self.vertices + self.firsts.len() + if self.triangles { 0 } else { self.face_count() },
            faces: Faces::Equal(if self.triangles { 3 } else { 4 }),
            corners: Vec::with_capacity(size),
            edges: Vec::with_capacity(size),
            twins: Vec::with_capacity(size),
            firsts: vec![NONE; 2 * edges as usize + count],
            sharpness: vec![0.0; 2 * edges as usize + count],
            sharp: self.sharp.iter().map(|&(v, s)| (v, blunter(s))).filter(|(_, s)| *s > 0.0).collect(),
            specials: Vec::new(),
        };
        for (edge, &sharpness) in self.sharpness.iter().enumerate() {
            child.sharpness[2 * edge..2 * edge + 2].fill(blunter(sharpness));
        }
        let inner = 2 * edges;
        for face in 0..self.face_count() {
            let range = self.face(face);
            for corner in range.clone().map(|c| c as u32) {
                let (next, previous) = (self.next(corner), self.previous(corner));
                let [here, there] = [corner, previous].map(|c| self.edges[c as usize]);
                // Which half of an edge begins or ends here. An edge from a vertex to itself begins with the first.
                let half = |edge: u32, begins: bool| {
                    let [a, b] = self.ends_of(edge as usize);
                    let is_first = if a == b { begins } else { a == self.corners[corner as usize] };
                    2 * edge + u32::from(!is_first)
                };
                let [twin, last] = [corner, previous].map(|c| self.twins[c as usize]);
                // The faces of the next level at both ends of an edge with a neighbour.
                let right = if twin == NONE { NONE } else { self.next(twin) };
                let (vertex, out, back) = (self.corners[corner as usize], vertices + here, vertices + there);
                if self.triangles {
                    child.corners.extend([vertex, out, back]);
                    child.edges.extend([half(here, true), inner + corner, half(there, false)]);
                    let middle = 3 * (4 * face as u32 + 3);
                    let across = middle + (previous - range.start as u32);
                    let ends = [at(right, |c| self.triangle(c) + 2), at(last, |c| self.triangle(c))];
                    child.twins.extend([ends[0], across, ends[1]]);
                } else {
                    child.corners.extend([vertex, out, centers + face as u32, back]);
                    child.edges.extend([half(here, true), inner + corner, inner + previous, half(there, false)]);
                    let twins = [at(right, |c| 4 * c + 3), 4 * next + 2, 4 * previous + 1, at(last, |c| 4 * c)];
                    child.twins.extend(twins);
                }
            }
            if self.triangles {
                let first = range.start as u32;
                let corners: [u32; 3] = std::array::from_fn(|k| first + k as u32);
                child.corners.extend(corners.map(|c| vertices + self.edges[c as usize]));
                child.edges.extend(corners.map(|c| inner + self.next(c)));
                child.twins.extend(corners.map(|c| self.triangle(self.next(c)) + 1));
            }
        }
        for (corner, &edge) in child.edges.iter().enumerate() {
            child.firsts[edge as usize] = corner as u32;
        }
        child.with_specials()
    }

    /// The first corner of the triangle of the next level at a corner.
    fn triangle(&self, corner: u32) -> u32 {
        3 * (4 * (corner / 3) + corner % 3)
    }
}

fn at(corner: u32, child: impl Fn(u32) -> u32) -> u32 {
    if corner == NONE { NONE } else { child(corner) }
}
