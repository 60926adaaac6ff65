//! Subdivision surfaces: Catmull–Clark, Loop and bilinear, with semi-sharp creases and corners.
//!
//! A cage is refined uniformly, then its vertices move to the limit surface. The rules are those of OpenSubdiv: DeRose,
//! Kass and Truong, "Subdivision surfaces in character animation" (1998), with uniform creases. Limit positions are
//! from Halstead, Kass and DeRose, "Efficient, fair interpolation using Catmull–Clark surfaces" (1993).

mod build;
mod face_varying;
mod level;
mod limit;
mod refine;
mod special;
#[cfg(test)]
mod tests;

pub(crate) use face_varying::FaceVarying;
pub(crate) use level::Level;

/// How faces are divided, and how values are smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scheme {
    /// A face with n corners becomes n quads.
    CatmullClark,
    /// A triangle becomes four triangles. All faces must be triangles.
    Loop,
    /// As Catmull–Clark, without smoothing.
    Bilinear,
}

/// What happens at the border of a mesh (`interpolateBoundary`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Boundary {
    /// Faces at the border are not shown.
    None,
    /// The surface ends at a smooth curve.
    Edges,
    /// As `Edges`, and corners with a single face are sharp.
    EdgesAndCorners,
}

/// A mesh of control points. The indices of corners must be less than `vertices`, and the sum of `counts` must be the
/// number of corners. Any topology is valid: edges with more than two faces, or with two faces of opposite orientation,
/// are infinitely sharp.
#[derive(Clone, Debug)]
pub(crate) struct Cage<'a> {
    pub scheme: Scheme,
    /// The number of corners of each face, at least 3.
    pub counts: &'a [u32],
    /// The vertex of each corner, face by face.
    pub corners: &'a [u32],
    pub vertices: usize,
    /// Edges by their vertices, and their sharpness. Edges that do not exist are ignored.
    pub creases: &'a [([u32; 2], f32)],
    /// Vertices and their sharpness.
    pub sharp: &'a [(u32, f32)],
    pub boundary: Boundary,
}

/// A cage, refined a number of times.
pub(crate) struct Subdivision {
    scheme: Scheme,
    /// From the cage to the finest level. Face-varying values have the same faces, but other vertices.
    levels: Vec<Level>,
}

impl Subdivision {
    /// The cage itself.
    pub fn new(cage: &Cage) -> Self {
        Subdivision { scheme: cage.scheme, levels: vec![Level::cage(cage)] }
    }

    /// The cage.
    pub fn cage(&self) -> &Level {
        &self.levels[0]
    }

    /// The finest level.
    pub fn finest(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// Refines `times` times. The number of faces grows by a factor of 4 each time, and from the cage to the first
    /// level of a scheme with quads to the number of corners.
    pub fn refine(&mut self, times: usize) {
        for _ in 0..times {
            let finer = self.finest().child();
            self.levels.push(finer);
        }
    }

    /// The face of the cage that a face of the finest level is a part of.
    pub fn source(&self, face: usize) -> usize {
        let coarser = self.levels[..self.levels.len() - 1].iter().rev();
        coarser.fold(face, |face, level| level.parent(face))
    }

    /// Values of the vertices, refined but not moved to the limit. `values` has one for each vertex of the cage.
    pub fn refined<const N: usize>(&self, values: &[[f32; N]]) -> Vec<[f32; N]> {
        let smooth = self.scheme != Scheme::Bilinear;
        refine_through(&self.levels, values.to_vec(), smooth)
    }

    /// The limits of refined values.
    pub fn limit<const N: usize>(&self, refined: &[[f32; N]]) -> Vec<[f32; N]> {
        match self.scheme {
            Scheme::Bilinear => refined.to_vec(),
            _ => self.finest().limit(refined),
        }
    }

    /// The normals of the limit surface at the corners of the finest level, from refined positions. The surface is seen
    /// counterclockwise from their side. They have the length 1, or 0 where there is no normal.
    pub fn normals(&self, refined: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.finest().normals(refined)
    }

    /// The limits of values at the corners of faces. `values` has one for each corner of the cage, the result one for
    /// each corner of the finest level.
    pub fn face_varying<const N: usize>(&self, values: &[[f32; N]], rule: FaceVarying) -> Vec<[f32; N]> {
        let (level, values) = Level::seams(self.cage(), values, rule);
        let smooth = self.scheme != Scheme::Bilinear && rule != FaceVarying::All;
        let mut levels = vec![level];
        for _ in 1..self.levels.len() {
            levels.push(levels[levels.len() - 1].child());
        }
        let refined = refine_through(&levels, values, smooth);
        let finest = &levels[levels.len() - 1];
        let limit = if smooth { finest.limit(&refined) } else { refined };
        finest.corners().iter().map(|&vertex| limit[vertex as usize]).collect()
    }

    /// Values of the vertices that change linearly between them.
    pub fn varying<const N: usize>(&self, values: &[[f32; N]]) -> Vec<[f32; N]> {
        refine_through(&self.levels, values.to_vec(), false)
    }
}

fn refine_through<const N: usize>(levels: &[Level], values: Vec<[f32; N]>, smooth: bool) -> Vec<[f32; N]> {
    levels[..levels.len() - 1].iter().fold(values, |values, level| level.refine(&values, smooth))
}
