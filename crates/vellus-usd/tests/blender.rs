//! Curves as exported by Blender 5.0.

mod common;

use common::{read, sample, with_width};
use vellus_scene::{Basis, Values};
use vellus_usd::Options;

const STRANDS: usize = 50;

#[test]
fn samples_have_their_strands_in_both_forms() {
    let kinds = [("fur50_catmull_rom", Basis::CatmullRom, 21 + 2, 20), ("fur50_poly", Basis::Linear, 21, 20)];
    for (name, basis, points, segments) in kinds {
        let forms = ["usda", "usdc"].map(|form| {
            let file = sample(&format!("blender/{name}.{form}"))?;
            Some(read(&file, &Options::default()).unwrap())
        });
        let [Some((text, warnings)), Some((binary, _))] = forms else { return };
        assert_eq!(warnings, []);
        let [strands] = &text.strands[..] else { panic!("{name}: one prim") };
        assert_eq!((strands.basis, strands.len(), strands.segments()), (basis, STRANDS, STRANDS * segments));
        assert!((0..STRANDS).all(|i| strands.strand(i).len() == points));
        assert_eq!(strands.name, "/root/fur/fur");
        // Widths are diameters, 0.008 at the root.
        let root = usize::from(basis == Basis::CatmullRom);
        assert_eq!(strands.strand(7)[root].w, 0.004);
        assert_eq!(strands.root_uv.as_ref().unwrap().len(), STRANDS);
        assert_eq!(text.strands, binary.strands);
    }
}

/// The exporter left the handles of these curves unset. If the handles happen to be finite, the file is read. Otherwise
/// it is an error.
#[test]
fn bezier_samples_have_their_knots_or_are_refused() {
    for form in ["usda", "usdc"] {
        let Some(file) = sample(&format!("blender/fur50_bezier.{form}")) else { return };
        match read(&file, &Options::default()) {
            Ok((scene, _)) => {
                let strands = &scene.strands[0];
                assert_eq!((strands.basis, strands.len(), strands.segments()), (Basis::Bezier, STRANDS, STRANDS * 20));
                // Widths are given at the 21 knots, and are linear between them.
                let radii: Vec<f32> = strands.strand(0)[..4].iter().map(|p| p.w).collect();
                assert!(radii[0] == 0.004 && (radii[1] - 0.00394).abs() < 1e-8 && (radii[3] - 0.00382).abs() < 1e-8);
            }
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains("/root/fur/fur: points[") && error.contains("must be finite"), "{error}");
            }
        }
    }
}

#[test]
fn pinned_curves_pass_through_their_end_points() {
    let (Some(cubic), Some(poly)) = (sample("blender/fur50_catmull_rom.usda"), sample("blender/fur50_poly.usda"))
    else {
        return;
    };
    let (cubic, _) = read(&cubic, &Options::default()).unwrap();
    let (poly, _) = read(&poly, &Options::default()).unwrap();
    for i in 0..STRANDS {
        let (control, points) = (cubic.strands[0].strand(i), poly.strands[0].strand(i));
        // Uniform Catmull–Rom begins at the second control point and ends at the last but one.
        assert_eq!(control[1..control.len() - 1], *points);
        // The curve starts in the direction of the second point, because the phantom point is mirrored.
        let (phantom, first, second) = (control[0].truncate(), points[0].truncate(), points[1].truncate());
        assert!((phantom + second - 2.0 * first).length() < 1e-6);
    }
}

#[test]
fn particles_need_a_width_and_include_their_sphere() {
    let Some(file) = sample("blender/particles50.usda") else { return };
    let error = read(&file, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("/root/Sphere/hair") && error.contains("--width"), "{error}");
    let (scene, warnings) = read(&file, &with_width(0.02)).unwrap();
    assert_eq!(warnings, []);
    // The curves are pinned, but linear, so there are no phantom points.
    assert_eq!((scene.strands[0].basis, scene.strands[0].len()), (Basis::Linear, STRANDS));
    assert!(scene.strands[0].points.iter().all(|p| p.w == 0.01));
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions.len(), 482);
    // 32 × 16: two fans of 32 triangles, 14 rings of 32 quadrilaterals.
    assert_eq!(mesh.triangles.len(), 2 * 32 + 2 * 14 * 32);
    for (triangle, normals) in mesh.triangles.iter().zip(mesh.normals.as_ref().unwrap()) {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        assert!((b - a).cross(c - a).dot(normals[0]) > 0.0, "outward");
    }
}

#[test]
fn nurbs_are_named_if_nothing_else_is_left() {
    for form in ["usda", "usdc"] {
        let Some(file) = sample(&format!("blender/fur50_nurbs.{form}")) else { return };
        let error = read(&file, &Options::default()).unwrap_err().to_string();
        assert!(error.contains("nothing to render (/root/fur/fur: NurbsCurves is not supported"), "{error}");
    }
}

/// Blender's own attributes drive the fibre through a primvar reader.
#[test]
fn a_material_layered_over_the_export_reads_its_primvars() {
    let Some(file) = sample("blender/fur50_poly.usdc") else { return };
    let layer = format!(
        "(
    subLayers = [@{}@]
)
over \"root\" {{
    over \"fur\" {{
        over \"fur\" {{ rel material:binding = </Fur> }}
    }}
}}
def Material \"Fur\" {{
    token outputs:surface.connect = </Fur/Fibre.outputs:surface>
    def Shader \"Fibre\" {{
        uniform token info:id = \"VellusFur\"
        token inputs:preset = \"red-fox\"
        float inputs:melanin.connect = </Fur/Melanin.outputs:result>
        token outputs:surface
    }}
    def Shader \"Melanin\" {{
        uniform token info:id = \"UsdPrimvarReader_float\"
        string inputs:varname = \"melanin\"
        float outputs:result
    }}
}}",
        file.display()
    );
    let (scene, warnings) = common::read_text(&layer, &Options::default()).unwrap();
    assert_eq!(warnings, []);
    let [(vellus_scene::Parameter::Melanin, Values::PerStrand(melanin))] = &scene.strands[0].varying[..] else {
        panic!("{:?}", scene.strands[0].varying)
    };
    assert_eq!((melanin[0], melanin[49]), ([0.0; 3], [1.0, 0.0, 0.0]));
    assert_eq!(scene.looks[0].fiber, vellus::Fiber::preset(vellus::Species::RedFox));
}
