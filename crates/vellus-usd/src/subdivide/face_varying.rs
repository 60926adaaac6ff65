//! Values at the corners of faces: their own mesh, with seams where neighbouring faces have other values.

use super::level::{Faces, Level, NONE};

/// Which values at seams stay as they are (`faceVaryingLinearInterpolation` of UsdGeomMesh).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FaceVarying {
    /// None: seams are smooth curves.
    None,
    /// Those with a single face.
    Corners,
    /// Also those where three or more regions meet.
    CornersPlus1,
    /// Also those where a seam ends, and those beside a corner with a single face.
    CornersPlus2,
    /// All values at seams.
    Boundaries,
    /// All values: they are linear.
    All,
}

/// The corners around a vertex that share a value.
struct Fan {
    vertex: u32,
    faces: u32,
    /// Whether the fan ends at a seam or at the border.
    is_open: bool,
    /// Whether it ends at a seam and not at the border.
    is_seam: bool,
}

impl Level {
    /// The mesh of values at corners of the faces of a cage, and the value of each of its vertices.
    pub(super) fn seams<const N: usize>(
        cage: &Level,
        values: &[[f32; N]],
        rule: FaceVarying,
    ) -> (Level, Vec<[f32; N]>) {
        let count = cage.corners.len();
        let same = |a: u32, b: u32| values[a as usize] == values[b as usize];
        let twins: Vec<u32> = (0..count as u32)
            .map(|corner| match cage.twins[corner as usize] {
                NONE => NONE,
                twin if same(corner, cage.next(twin)) && same(cage.next(corner), twin) => twin,
                _ => NONE,
            })
            .collect();
        let mut level = Level {
            triangles: cage.triangles,
            vertices: 0,
            faces: match &cage.faces {
                Faces::Any { starts, of } => Faces::Any { starts: starts.clone(), of: of.clone() },
                Faces::Equal(n) => Faces::Equal(*n),
            },
            corners: vec![NONE; count],
            edges: vec![NONE; count],
            twins,
            firsts: Vec::new(),
            sharpness: Vec::new(),
            sharp: Vec::new(),
            specials: Vec::new(),
        };
        for corner in 0..count {
            if level.edges[corner] != NONE {
                continue;
            }
            let edge = level.firsts.len() as u32;
            level.firsts.push(corner as u32);
            level.edges[corner] = edge;
            let twin = level.twins[corner];
            if twin == NONE {
                level.sharpness.push(f32::INFINITY);
            } else {
                level.edges[twin as usize] = edge;
                level.sharpness.push(cage.sharpness[cage.edges[corner] as usize]);
            }
        }
        let (mut fans, mut own) = (Vec::new(), Vec::new());
        for corner in 0..count as u32 {
            if level.corners[corner as usize] == NONE {
                own.push(values[corner as usize]);
                let fan = level.fan(cage, corner, fans.len() as u32);
                fans.push(fan);
            }
        }
        level.vertices = fans.len();
        level.sharp = sharp(cage, &fans, rule);
        (level.with_specials(), own)
    }

    /// Gives all corners of a fan this vertex.
    fn fan(&mut self, cage: &Level, corner: u32, vertex: u32) -> Fan {
        let mut first = corner;
        let is_open = loop {
            match self.right(first) {
                NONE => break true,
                right if right == corner => break false,
                right => first = right,
            }
        };
        let (mut last, mut faces) = (first, 1);
        self.corners[first as usize] = vertex;
        loop {
            match self.left(last) {
                NONE => break,
                left if left == first => break,
                left => last = left,
            }
            self.corners[last as usize] = vertex;
            faces += 1;
        }
        let is_seam = is_open && cage.twins[first as usize] != NONE;
        Fan { vertex: cage.corners[corner as usize], faces, is_open, is_seam }
    }
}

/// The sharpness of values.
fn sharp(cage: &Level, fans: &[Fan], rule: FaceVarying) -> Vec<(u32, f32)> {
    // The number of fans at each vertex, and the number of faces of the smallest one.
    let mut regions = vec![(0u32, u32::MAX); cage.vertices];
    for fan in fans {
        let (count, least) = &mut regions[fan.vertex as usize];
        (*count, *least) = (*count + 1, fan.faces.min(*least));
    }
    let sharpness = |fan: &Fan| {
        let (count, least) = regions[fan.vertex as usize];
        let corner = fan.faces == 1;
        let junction = count > 2;
        let dart = (count == 1 && fan.is_seam) || (count == 2 && least == 1);
        let stays = match rule {
            FaceVarying::None => false,
            FaceVarying::Corners => corner,
            FaceVarying::CornersPlus1 => corner || junction,
            FaceVarying::CornersPlus2 => corner || junction || dart,
            FaceVarying::Boundaries | FaceVarying::All => true,
        };
        if stays && fan.is_open {
            return f32::INFINITY;
        }
        let known = cage.sharp.binary_search_by_key(&fan.vertex, |sharp| sharp.0);
        known.map_or(0.0, |i| cage.sharp[i].1)
    };
    let all = fans.iter().enumerate().map(|(vertex, fan)| (vertex as u32, sharpness(fan)));
    all.filter(|(_, sharpness)| *sharpness > 0.0).collect()
}
