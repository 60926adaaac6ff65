//! Curves, particle hair and lights as Blender 5.2 exports them. `data/make_blender.py` wrote the files.

use crate::common::{blender, read, with_width};
use glam::Vec3;
use std::f32::consts::PI;
use vellus_scene::{Basis, Light, LightShape, Values};
use vellus_usd::Options;

const STRANDS: usize = 24;
/// Points of a strand.
const POINTS: usize = 6;

#[test]
fn samples_have_their_strands_in_both_forms() {
    for (name, basis, points) in
        [("fur_catmull_rom", Basis::CatmullRom, POINTS + 2), ("fur_poly", Basis::Linear, POINTS)]
    {
        let [(text, warnings), (binary, _)] =
            ["usda", "usdc"].map(|form| read(&blender(&format!("{name}.{form}")), &Options::default()).unwrap());
        assert_eq!(warnings, []);
        let [strands] = &text.strands[..] else { panic!("{name}: one prim") };
        assert_eq!((strands.basis, strands.len(), strands.segments()), (basis, STRANDS, STRANDS * (POINTS - 1)));
        assert!((0..STRANDS).all(|i| strands.strand(i).len() == points));
        assert_eq!(strands.name, "/root/fur/fur");
        // Widths are diameters, 0.008 at the root.
        let root = usize::from(basis == Basis::CatmullRom);
        assert_eq!(strands.strand(7)[root].w, 0.004);
        assert_eq!(strands.root_uv.as_ref().unwrap().len(), STRANDS);
        assert_eq!(text.strands, binary.strands);
    }
}

/// Blender 5.0 wrote handles that were not set, and such numbers need not be finite.
#[test]
fn bezier_samples_have_their_knots_and_unset_handles_are_left_out() {
    for form in ["usda", "usdc"] {
        let (scene, _) = read(&blender(&format!("fur_bezier.{form}")), &Options::default()).unwrap();
        let strands = &scene.strands[0];
        let segments = STRANDS * (POINTS - 1);
        assert_eq!((strands.basis, strands.len(), strands.segments()), (Basis::Bezier, STRANDS, segments));
        // Widths are given at the knots, and are linear between them. The last is 0.7 times the first.
        let radii: Vec<f32> = strands.strand(0)[..4].iter().map(|p| p.w).collect();
        assert!(radii[0] == 0.004 && (radii[1] - 0.00392).abs() < 1e-8 && (radii[3] - 0.00376).abs() < 1e-8);
    }
    let text = std::fs::read_to_string(blender("fur_bezier.usda")).unwrap();
    let (before, point) = text.split_once("point3f[] points = [(").unwrap();
    let (_, after) = point.split_once(", ").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("unset.usda");
    std::fs::write(&file, format!("{before}point3f[] points = [(nan, {after}")).unwrap();
    let (scene, warnings) = read(&file, &Options::default()).unwrap();
    assert_eq!(scene.strands[0].len(), STRANDS - 1);
    let said = warnings.iter().map(ToString::to_string).collect::<String>();
    let named = format!("/root/fur/fur: 1 of {STRANDS} strands are left out (strand 0)");
    assert!(said.contains(&named) && said.contains("re-export the curves as Catmull-Rom"), "{said}");
}

#[test]
fn pinned_curves_pass_through_their_end_points() {
    let [cubic, poly] =
        ["catmull_rom", "poly"].map(|kind| read(&blender(&format!("fur_{kind}.usda")), &Options::default()).unwrap().0);
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
    let file = blender("particles.usda");
    let (scene, warnings) = read(&file, &Options::default()).unwrap();
    let said = warnings.iter().map(ToString::to_string).collect::<String>();
    assert!(scene.strands.is_empty() && said.contains("/root/Sphere/hair") && said.contains("--width"), "{said}");
    let (scene, warnings) = read(&file, &with_width(0.02)).unwrap();
    assert_eq!(warnings, []);
    // The file declares pinned cubic curves.
    assert_eq!((scene.strands[0].basis, scene.strands[0].len()), (Basis::CatmullRom, STRANDS));
    assert!(scene.strands[0].points.iter().all(|p| p.w == 0.01));
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions.len(), 8 * 5 + 2);
    // 8 × 6: two fans of 8 triangles, 4 rings of 8 quadrilaterals.
    assert_eq!(mesh.triangles.len(), 2 * 8 + 2 * 4 * 8);
    for (triangle, normals) in mesh.triangles.iter().zip(mesh.normals.as_ref().unwrap()) {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        assert!((b - a).cross(c - a).dot(normals[0]) > 0.0, "outward");
    }
}

#[test]
fn nurbs_are_bezier_curves() {
    for form in ["usda", "usdc"] {
        let (scene, warnings) = read(&blender(&format!("fur_nurbs.{form}")), &Options::default()).unwrap();
        let strands = &scene.strands[0];
        assert_eq!(strands.basis, vellus_scene::Basis::Bezier, "{warnings:?}");
        println!("{} {:?} {:?}", strands.len(), &strands.starts, &strands.points);
        assert!(strands.points.iter().all(|point| point.is_finite()));
    }
}

/// Blender's own attributes drive the fibre through a primvar reader.
#[test]
fn a_material_layered_over_the_export_reads_its_primvars() {
    let file = blender("fur_poly.usdc");
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
    assert_eq!((melanin[0], melanin[STRANDS - 1]), ([0.0; 3], [1.0, 0.0, 0.0]));
    assert_eq!(scene.looks[0].fiber, vellus::Fiber::preset(vellus::Species::RedFox));
}

/// All lights of Blender 5.2, hair curves, and particle hair without widths in one file.
#[test]
fn lights_and_particle_hair_of_blender_5_2_are_read() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/blender_5_2.usda");
    let (scene, warnings) = read(&file, &with_width(0.01)).unwrap();
    let named = |light: &'_ Light| (light.group.clone().unwrap_or_default(), light.shape.kind());
    let kinds: Vec<_> = scene.lights.iter().map(named).collect();
    let expected = [("Area", "disk"), ("Bulb", "sphere"), ("Point", "point"), ("Spot", "point"), ("Sun", "distant")];
    assert!(
        expected.iter().all(|(group, kind)| kinds.contains(&((*group).to_owned(), *kind))) && kinds.len() == 5,
        "{kinds:?}"
    );
    let at = |name: &str| kinds.iter().position(|(group, _)| group == name).unwrap();
    // 500 W in all directions.
    let LightShape::Point { intensity, .. } = &scene.lights[at("Point")].shape else { panic!() };
    assert!((intensity[0] - 500.0 / (4.0 * PI)).abs() < 1e-4, "{intensity:?}");
    let shapings: Vec<_> = scene.lights.iter().filter_map(|light| light.shaping).collect();
    let ([shaping], Some(_)) = (&shapings[..], scene.lights[at("Spot")].shaping) else { panic!("{shapings:?}") };
    assert!((shaping.cone.to_degrees() - 20.0).abs() < 1e-4 && shaping.softness == 0.3);
    assert!(shaping.axis.abs_diff_eq(Vec3::NEG_Z, 1e-6));
    let strands: Vec<_> = scene.strands.iter().map(|s| (s.len(), s.points[0].w)).collect();
    // Particles have the width of the option, curves their own.
    assert!(strands.contains(&(4, 0.02)) && strands.contains(&(10, 0.005)), "{strands:?}");
    let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    let one = |text: &str| said.iter().filter(|line| line.contains(text)).count() == 1;
    assert!(one("Hair: it has no VellusFur shader") && one("Blender writes a quarter") && said.len() == 2, "{said:?}");
}
