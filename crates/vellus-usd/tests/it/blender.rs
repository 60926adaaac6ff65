//! Curves as exported by Blender 5.0.

use crate::common::{read, sample, with_width};
use glam::Vec3;
use std::f32::consts::PI;
use vellus_scene::{Basis, Light, Values};
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
    let (scene, warnings) = crate::common::read_text(&layer, &Options::default()).unwrap();
    assert_eq!(warnings, []);
    let [(vellus_scene::Parameter::Melanin, Values::PerStrand(melanin))] = &scene.strands[0].varying[..] else {
        panic!("{:?}", scene.strands[0].varying)
    };
    assert_eq!((melanin[0], melanin[49]), ([0.0; 3], [1.0, 0.0, 0.0]));
    assert_eq!(scene.looks[0].fiber, vellus::Fiber::preset(vellus::Species::RedFox));
}

/// All lights of Blender 5.2, hair curves, and particle hair without widths in one file. `make_blender.py` wrote it.
#[test]
fn lights_and_particle_hair_of_blender_5_2_are_read() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/blender_5_2.usda");
    let (scene, warnings) = read(&file, &with_width(0.01)).unwrap();
    let kinds: Vec<_> =
        scene.lights.iter().zip(&scene.light_groups).map(|(l, name)| (name.as_str(), l.kind())).collect();
    let expected = [("Area", "disk"), ("Bulb", "sphere"), ("Point", "point"), ("Spot", "point"), ("Sun", "distant")];
    assert!(expected.iter().all(|light| kinds.contains(light)) && kinds.len() == 5, "{kinds:?}");
    let at = |name: &str| kinds.iter().position(|(group, _)| *group == name).unwrap();
    // 500 W in all directions.
    let Light::Point { intensity, .. } = &scene.lights[at("Point")] else { panic!() };
    assert!((intensity[0] - 500.0 / (4.0 * PI)).abs() < 1e-4, "{intensity:?}");
    let [(spot, shaping)] = scene.shapings[..] else { panic!("{:?}", scene.shapings) };
    assert!(spot == at("Spot") && (shaping.cone.to_degrees() - 20.0).abs() < 1e-4 && shaping.softness == 0.3);
    assert!(shaping.axis.abs_diff_eq(Vec3::NEG_Z, 1e-6));
    let strands: Vec<_> = scene.strands.iter().map(|s| (s.len(), s.points[0].w)).collect();
    // Particles have the width of the option, curves their own.
    assert!(strands.contains(&(4, 0.02)) && strands.contains(&(10, 0.005)), "{strands:?}");
    let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    let one = |text: &str| said.iter().filter(|line| line.contains(text)).count() == 1;
    assert!(one("Hair: it has no VellusFur shader") && one("Blender writes a quarter") && said.len() == 2, "{said:?}");
}
