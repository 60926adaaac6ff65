//! Widths, bases and end points of curves.

use super::{FOUR, scene};
use crate::common::{read_text, with_width};
use glam::Vec3;
use vellus_scene::Basis;

#[test]
fn every_kind_of_width_and_basis() {
    let two = |attributes: &str| {
        let (scene, _) = read_text(
            &format!(
                "def BasisCurves \"b\" {{
    int[] curveVertexCounts = [4, 5]
    point3f[] points = [(0,0,0), (1,0,0), (2,0,0), (3,0,0), (0,1,0), (1,1,0), (2,1,0), (3,1,0), (4,1,0)]
    {attributes}
}}"
            ),
            &with_width(0.5),
        )
        .unwrap();
        scene.strands.into_iter().next().unwrap()
    };
    let radii = |s: &vellus_scene::Strands| s.points.iter().map(|p| p.w).collect::<Vec<_>>();
    let bspline = "uniform token basis = \"bspline\"\n";
    let strands = two(bspline);
    assert_eq!((strands.basis, radii(&strands)), (Basis::BSpline, vec![0.25; 9]));
    let strands = two(&format!("{bspline} float[] widths = [2, 4] (interpolation = \"uniform\")"));
    assert_eq!(radii(&strands), [[1.0; 4].as_slice(), &[2.0; 5]].concat());
    // The two strands have 2 and 3 knots. Pinned curves have 4 and 5.
    let strands = two(&format!("{bspline} float[] widths = [2, 4, 2, 4, 6] (interpolation = \"varying\")"));
    assert_eq!(radii(&strands), [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
    let strands = two("uniform token basis = \"catmullRom\" uniform token wrap = \"pinned\"
    float[] primvars:widths = [2, 4, 6, 4, 0, 0, 0, 0, 2] (interpolation = \"varying\")
    float[] widths = [9] (interpolation = \"constant\")");
    assert_eq!(radii(&strands), [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0]);
    assert_eq!(strands.strand(1)[0].truncate(), Vec3::new(-1.0, 1.0, 0.0));
    // A linear curve with a basis that remains from a cubic type. Its widths are indexed.
    let strands =
        two("uniform token type = \"linear\" uniform token basis = \"bezier\" uniform token wrap = \"pinned\"
    float[] primvars:widths = [2, 4] (interpolation = \"vertex\")
    int[] primvars:widths:indices = [0, 0, 0, 1, 0, 0, 0, 0, 1]");
    assert_eq!((strands.basis, radii(&strands)), (Basis::Linear, vec![1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0, 2.0]));
}

#[test]
fn pinned_b_splines_start_and_end_at_their_points() {
    let (scene, _) = scene(&format!(
        "def BasisCurves \"b\" {{ {FOUR}\n uniform token basis = \"bspline\" uniform token wrap = \"pinned\" }}"
    ));
    let points = scene.strands[0].strand(0);
    assert_eq!(points.len(), 6);
    let end = |a: usize| (points[a] + 4.0 * points[a + 1] + points[a + 2]) / 6.0;
    assert!(
        end(0).truncate().abs_diff_eq(Vec3::ZERO, 1e-6)
            && end(3).truncate().abs_diff_eq(Vec3::new(3.0, 0.0, 0.0), 1e-6)
    );
}
