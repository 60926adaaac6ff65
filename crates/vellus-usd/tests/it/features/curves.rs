//! Widths, bases and end points of curves.

use super::{FOUR, said, scene};
use crate::common::{read_text, with_width};
use glam::Vec3;
use vellus::{Fiber, FiberBuilder};
use vellus_scene::{Basis, Parameter, Values};
use vellus_usd::Options;

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

#[test]
fn loops_are_closed_in_every_basis() {
    for (kind, points, first, last) in [
        ("token type = \"linear\"", 3, 0.0, 0.0),
        ("token basis = \"bspline\"", 4, 0.0, 2.0),
        ("token basis = \"catmullRom\"", 4, 0.0, 2.0),
        ("token basis = \"bezier\"", 6, 0.0, 0.0),
    ] {
        let all: Vec<String> = (0..points).map(|x| format!("({x},0,0)")).collect();
        let (scene, warnings) = scene(&format!(
            "def BasisCurves \"c\" {{ uniform {kind} uniform token wrap = \"periodic\"
                int[] curveVertexCounts = [{points}]
                point3f[] points = [{}] float[] widths = [1] (interpolation = \"constant\") }}",
            all.join(", ")
        ));
        let strand = scene.strands[0].strand(0);
        assert_eq!((strand[0].x, strand[strand.len() - 1].x), (first, last), "{kind}");
        // As many segments as points, or a third for Bézier curves.
        assert_eq!(scene.strands[0].segments(), if points == 6 { 2 } else { points }, "{kind}");
        assert_eq!(said(&warnings), "");
    }
}

/// A Hermite curve from (0, 0) to (3, 0) with the tangents (3, 3) and (3, -3).
#[test]
fn hermite_curves_are_bezier_curves() {
    let (scene, warnings) = scene(
        "def HermiteCurves \"c\" { int[] curveVertexCounts = [2] point3f[] points = [(0,0,0), (3,0,0)]
            vector3f[] tangents = [(3,3,0), (3,-3,0)] float[] widths = [2, 8] }",
    );
    let strands = &scene.strands[0];
    let points: Vec<[f32; 4]> = strands.points.iter().map(|p| p.to_array()).collect();
    assert_eq!((strands.basis, strands.len()), (Basis::Bezier, 1));
    assert_eq!(points, [[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 0.0, 2.0], [2.0, 1.0, 0.0, 3.0], [3.0, 0.0, 0.0, 4.0]]);
    assert_eq!(said(&warnings), "");
}

/// The only colour of many exports. A shader that reads it by a primvar has its own fallback for other curves.
#[test]
fn display_colour_is_the_reflectance_of_the_coat() {
    let plain = |more: &str| scene(&format!("def BasisCurves \"c\" {{ {FOUR} {more} }}"));
    let (read, _) = plain("color3f[] primvars:displayColor = [(0.3, 0.2, 0.1)]");
    assert_eq!(read.strands[0].varying, [(Parameter::Reflectance, Values::Constant([0.3, 0.2, 0.1]))]);
    assert_eq!(plain("").0.strands[0].varying, []);
    let (_, warnings) = plain("float[] primvars:displayOpacity = [0.5]");
    assert!(said(&warnings).contains("strands are opaque"), "{}", said(&warnings));
    assert_eq!(said(&plain("float[] primvars:displayOpacity = [1]").1), "");
    let (read, warnings) = scene(&format!(
        "def Material \"m\" {{ token outputs:surface.connect = </m/s.outputs:surface>
            def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" token outputs:surface
                color3f inputs:diffuseColor.connect = </m/r.outputs:result> }}
            def Shader \"r\" {{ uniform token info:id = \"UsdPrimvarReader_float3\"
                string inputs:varname = \"displayColor\"
                float3 inputs:fallback = (0.25, 0.2, 0.15) float3 outputs:result }} }}
        def BasisCurves \"a\" {{ {FOUR} rel material:binding = </m>
            color3f[] primvars:displayColor = [(0.3, 0.2, 0.1)] }}
        def BasisCurves \"b\" {{ {FOUR} rel material:binding = </m> }}"
    ));
    assert_eq!(read.strands[0].varying, [(Parameter::Reflectance, Values::Constant([0.3, 0.2, 0.1]))]);
    let mut fallback = FiberBuilder::new(Fiber::hair());
    fallback.set_value(Parameter::Reflectance, [0.25, 0.2, 0.15]);
    assert_eq!((read.looks[0].fiber, read.strands[1].varying.len()), (fallback.build().unwrap(), 0));
    assert!(!said(&warnings).contains("not mapped"), "{}", said(&warnings));
}

/// `st1` of one connector, `map1` of another: the shader says which.
#[test]
fn texture_coordinates_have_the_name_that_the_shader_asks_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0]).unwrap();
    std::fs::write(folder.path().join("a.png"), image).unwrap();
    let stage = |reader: &str, uv: &str| {
        let text = format!(
            "#usda 1.0\ndef Material \"m\" {{ token outputs:vellus:surface.connect = </m/f.outputs:surface>
                token outputs:surface.connect = </m/s.outputs:surface>
                def Shader \"f\" {{ uniform token info:id = \"VellusFur\" token outputs:surface
                    color3f inputs:reflectance.connect = </m/t.outputs:rgb> }}
                def Shader \"s\" {{ uniform token info:id = \"UsdPreviewSurface\" token outputs:surface
                    color3f inputs:diffuseColor.connect = </m/t.outputs:rgb> }}
                def Shader \"t\" {{ uniform token info:id = \"UsdUVTexture\" asset inputs:file = @a.png@
                    float2 inputs:st.connect = </m/r.outputs:result> float3 outputs:rgb }}
                def Shader \"r\" {{ {reader} float2 outputs:result }}
                def Shader \"q\" {{ uniform token info:id = \"UsdPrimvarReader_float2\" string inputs:varname = \"map1\"
                    float2 outputs:result }} }}
            def BasisCurves \"c\" {{ {FOUR} rel material:binding = </m> {uv} }}"
        );
        let file = folder.path().join("a.usda");
        std::fs::write(&file, text).unwrap();
        let reading = vellus_usd::read(&file, &Options::default()).unwrap();
        (reading.scene.strands[0].root_uv.as_ref().map(|uv| uv[0].x), said(&reading.warnings))
    };
    let reads =
        |name: &str| format!("uniform token info:id = \"UsdPrimvarReader_float2\" string inputs:varname = \"{name}\"");
    let both = "texCoord2f[] primvars:st = [(0.25, 0)] texCoord2f[] primvars:map1 = [(0.5, 0)]";
    assert_eq!(stage(&reads("map1"), both), (Some(0.5), String::new()));
    assert_eq!(stage(&reads("st"), both), (Some(0.25), String::new()));
    let through = "uniform token info:id = \"UsdTransform2d\" float2 inputs:in.connect = </m/q.outputs:result>";
    assert_eq!(stage(through, both), (Some(0.5), String::new()));
    let (uv, said) = stage(&reads("st1"), "");
    assert!(uv.is_none() && said.contains("/c: its material has textures, but it has no primvars:st1"), "{said}");
}

/// Primvars of OpenUSD's renderer: their names are not in a schema, and values without effect are no news.
#[test]
fn widths_that_are_no_lengths_are_named() {
    for (name, idle, value, said_) in [
        (
            "bool[] primvars:screenSpaceWidths",
            "[0]",
            "[1]",
            "its widths are pixels in other renderers, and are read as",
        ),
        ("bool primvars:screenSpaceWidths", "0", "1", "its widths are pixels in other renderers, and are read as"),
        ("float[] primvars:minScreenSpaceWidths", "[0]", "[2]", "may be thinner than so many pixels"),
        ("float[] primvars:pointSizeScale", "[1]", "[4]", "its widths do not change"),
    ] {
        let warnings = |value: &str| {
            let own = scene(&format!("def BasisCurves \"c\" {{ {FOUR} {name} = {value} }}"));
            let above = scene(&format!("def Xform \"g\" {{ {name} = {value} def BasisCurves \"c\" {{ {FOUR} }} }}"));
            [own, above].map(|(read, warnings)| (read.strands[0].points[0].w, said(&warnings)))
        };
        assert_eq!(warnings(idle), [(0.1, String::new()), (0.1, String::new())], "{name}");
        let field = name.rsplit(' ').next().unwrap();
        for (prim, (radius, said)) in ["/c", "/g/c"].into_iter().zip(warnings(value)) {
            let expected = format!("{prim}: {field} is not supported: ");
            assert!(radius == 0.1 && said.contains(&expected) && said.contains(said_), "{said}");
        }
    }
}

/// A NURBS curve of degree 3 with even knots is a B-spline: it begins at (P0 + 4 P1 + P2) / 6, with the tangent
/// (P2 − P0) / 2. Widths belong to control points.
#[test]
fn nurbs_curves_are_cubic_pieces() {
    let read = |more: &str, widths: &str| {
        scene(&format!(
            "def NurbsCurves \"c\" {{ int[] curveVertexCounts = [5, 4] int[] order = [4, 4] {more}
            double[] knots = [0,1,2,3,4,5,6,7,8, 0,0,0,0,1,1,1,1]
            point3f[] points = [(0,0,0), (6,6,0), (12,0,0), (18,0,0), (24,0,0), (0,0,0), (1,0,0), (2,0,0), (3,0,0)]
            float[] widths = {widths} }}"
        ))
    };
    let (read_, warnings) = read("", "[0, 6, 12, 18, 24, 1, 1, 1, 1]");
    assert_eq!(said(&warnings), "");
    let strands = &read_.strands[0];
    assert_eq!((strands.basis, &strands.starts[..]), (Basis::Bezier, &[0, 7, 11][..]));
    let point = |i: usize| strands.points[i].to_array();
    // The value of 0, 6, 12, … at the knots is 6, 12, …; handles have a third of the difference.
    assert_eq!([point(0), point(1), point(3)], [[6.0, 4.0, 0.0, 3.0], [8.0, 4.0, 0.0, 4.0], [12.0, 1.0, 0.0, 6.0]]);
    // A Bézier curve stays one.
    assert_eq!([8, 9].map(|i| strands.points[i].x), [1.0, 2.0]);
    let (read_, _) = read("double2[] ranges = [(3, 4), (0, 0.5)]", "[1] (interpolation = \"constant\")");
    assert_eq!((&read_.strands[0].starts[..], read_.strands[0].points[7].x), (&[0, 4, 8][..], 1.5));
    let (_, warnings) = scene(
        "def NurbsCurves \"c\" { int[] curveVertexCounts = [2] int[] order = [3] point3f[] points = [(0,0,0), (1,0,0)] }
        def BasisCurves \"good\" { uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1, 1]
        point3f[] points = [(0,0,0), (1,0,0)] }",
    );
    assert!(said(&warnings).contains("/c: the order of curve 0 is 3"), "{}", said(&warnings));
}
