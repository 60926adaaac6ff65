//! Measures strands.

use crate::flatten::course;
use glam::Vec3;
use rayon::prelude::*;
use vellus_scene::{Basis, Strands, Values};

/// Number of straight pieces per cubic segment.
const STEPS: usize = 4;

/// Bounds, widths and lengths of strands. They are those of the curves, not of the control points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measures {
    /// Smallest and largest coordinates, including the radii.
    pub bounds: (Vec3, Vec3),
    /// Smallest and largest width (diameter).
    pub widths: [f32; 2],
    /// Lengths of the shortest, median and longest strand.
    pub lengths: [f32; 3],
}

/// Measures strands. Returns `None` if there are none.
pub fn measure(strands: &Strands) -> Option<Measures> {
    let one = |points: &mut Vec<_>, i: usize| {
        points.clear();
        course(strands.basis, strands.strand(i), if strands.basis == Basis::Linear { 1 } else { STEPS }, points);
        let mut sizes = ((Vec3::INFINITY, Vec3::NEG_INFINITY), [f32::INFINITY, 0.0]);
        for p in points.iter() {
            let (p, radius) = (p.truncate(), p.w);
            sizes.0 = (sizes.0.0.min(p - radius), sizes.0.1.max(p + radius));
            sizes.1 = [sizes.1[0].min(2.0 * radius), sizes.1[1].max(2.0 * radius)];
        }
        let length: f32 = points.windows(2).map(|pair| pair[0].truncate().distance(pair[1].truncate())).sum();
        (sizes, length)
    };
    let each: Vec<_> = (0..strands.len()).into_par_iter().map_init(Vec::new, one).collect();
    let mut lengths: Vec<f32> = each.iter().map(|(_, length)| *length).collect();
    lengths.par_sort_unstable_by(f32::total_cmp);
    let sizes = each.into_iter().map(|(sizes, _)| sizes);
    let (bounds, widths) =
        sizes.reduce(|(a, v), (b, w)| ((a.0.min(b.0), a.1.max(b.1)), [v[0].min(w[0]), v[1].max(w[1])]))?;
    Some(Measures { bounds, widths, lengths: [lengths[0], lengths[lengths.len() / 2], lengths[lengths.len() - 1]] })
}

/// Memory of strands in bytes, including varying parameters.
pub fn bytes(strands: &Strands) -> usize {
    let varying = strands.varying.iter().map(|(_, values)| match values {
        Values::Constant(value) => size_of_val(value),
        Values::PerStrand(values) | Values::PerPoint(values) => size_of_val(&values[..]),
    });
    size_of_val(&strands.points[..])
        + size_of_val(&strands.starts[..])
        + strands.moved.as_ref().map_or(0, |moved| size_of_val(&moved[..]))
        + strands.root_uv.as_ref().map_or(0, |uv| size_of_val(&uv[..]))
        + varying.sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    /// A quarter circle of radius 1 as a Bézier curve. Its distance from the circle is at most 3e-4. Four chords of
    /// 22.5° are shorter than their arcs by (π/8)²/24 = 0.64 %.
    #[test]
    fn curves_are_measured_not_their_control_points() {
        let k = 0.552_284_8;
        let points = [(1.0, 0.0), (1.0, k), (k, 1.0), (0.0, 1.0)];
        let strands = Strands {
            name: "arc".to_owned(),
            basis: Basis::Bezier,
            starts: vec![0, 4],
            points: points.map(|(x, y)| Vec4::new(x, y, 2.0, 0.05)).to_vec(),
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        };
        let measures = measure(&strands).unwrap();
        let (low, high) = measures.bounds;
        assert!(
            low.abs_diff_eq(Vec3::new(-0.05, -0.05, 1.95), 1e-6) && high.abs_diff_eq(Vec3::new(1.05, 1.05, 2.05), 1e-6)
        );
        assert!(measures.widths.iter().all(|w| (w - 0.1).abs() < 1e-6));
        let arc = std::f32::consts::FRAC_PI_2;
        assert!(measures.lengths.iter().all(|l| (l / arc - (1.0 - 6.4e-3)).abs() < 1e-3), "{measures:?}");
        assert_eq!(bytes(&strands), 4 * 16 + 2 * 4);
        assert_eq!(measure(&Strands { starts: vec![0], points: Vec::new(), ..strands }), None);
    }
}
