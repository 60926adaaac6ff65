//! Converts curves to straight segments.

use glam::{Mat4, Vec4};
use vellus_scene::{Basis, Strands, Values};

/// Converts strands to [`Basis::Linear`]. Each curve segment becomes `steps` ≥ 1 straight segments.
///
/// Motion, normals and values per point are lost, because the points change. Strands that are linear already are
/// returned unchanged.
pub fn flatten(strands: &Strands, steps: usize) -> Strands {
    if strands.basis == Basis::Linear {
        return strands.clone();
    }
    let steps = steps.max(1);
    let mut points = Vec::with_capacity((strands.segments() + strands.len()) * steps);
    let mut starts = vec![0];
    for i in 0..strands.len() {
        course(strands.basis, strands.strand(i), steps, &mut points);
        starts.push(points.len() as u32);
    }
    let varying = strands.varying.iter().filter(|(_, values)| !matches!(values, Values::PerPoint(_))).cloned();
    Strands {
        name: strands.name.clone(),
        basis: Basis::Linear,
        starts,
        points,
        moved: None,
        normals: None,
        root_uv: strands.root_uv.clone(),
        look: strands.look,
        varying: varying.collect(),
    }
}

/// Appends the points of a curve from root to tip, with `steps` ≥ 1 points per segment. Linear strands keep their
/// points.
pub(crate) fn course(basis: Basis, strand: &[Vec4], steps: usize, points: &mut Vec<Vec4>) {
    if basis == Basis::Linear {
        points.extend(strand);
        return;
    }
    let stride = if basis == Basis::Bezier { 3 } else { 1 };
    let segments = basis.segments(strand.len()).unwrap_or(0);
    for (s, four) in strand.windows(4).step_by(stride).take(segments).enumerate() {
        let first = usize::from(s > 0);
        points.extend((first..=steps).map(|k| at(basis, four, k as f32 / steps as f32)));
    }
}

/// The point at `t` in [0, 1] of the segment with these four control points.
fn at(basis: Basis, p: &[Vec4], t: f32) -> Vec4 {
    let (t2, t3) = (t * t, t * t * t);
    let weights = match basis {
        Basis::Linear => Vec4::new(1.0 - t, t, 0.0, 0.0),
        Basis::Bezier => {
            let s = 1.0 - t;
            Vec4::new(s * s * s, 3.0 * s * s * t, 3.0 * s * t2, t3)
        }
        Basis::BSpline => {
            let s = 1.0 - t;
            Vec4::new(s * s * s, 3.0 * t3 - 6.0 * t2 + 4.0, -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0, t3) / 6.0
        }
        Basis::CatmullRom => {
            Vec4::new(-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2) / 2.0
        }
    };
    let point = Mat4::from_cols(p[0], p[1], p[2], p[3]) * weights;
    // Catmull–Rom curves overshoot, so a radius near 0 could become negative.
    point.truncate().extend(point.w.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_basis_keeps_a_straight_line_straight() {
        for basis in [Basis::Bezier, Basis::BSpline, Basis::CatmullRom] {
            let strands = Strands {
                name: "line".to_owned(),
                basis,
                starts: vec![0, 7, 11],
                points: (0..11).map(|i| Vec4::new(i as f32, 2.0 * i as f32, 1.0, 0.1)).collect(),
                moved: None,
                normals: None,
                root_uv: None,
                look: 0,
                varying: Vec::new(),
            };
            let flat = flatten(&strands, 3);
            assert_eq!(flat.validate(), Ok(()));
            assert_eq!(flat.segments(), 3 * strands.segments());
            assert!(flat.points.iter().all(|p| (p.y - 2.0 * p.x).abs() < 1e-5 && (p.w - 0.1).abs() < 1e-6));
            let ends = if basis == Basis::Bezier { (0.0, 6.0) } else { (1.0, 5.0) };
            let first = flat.strand(0);
            assert!((first[0].x - ends.0).abs() < 1e-5 && (first[first.len() - 1].x - ends.1).abs() < 1e-5);
        }
    }
}
