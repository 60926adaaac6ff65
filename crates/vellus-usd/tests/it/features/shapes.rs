//! Implicit shapes.

use super::{said, scene};
use crate::common::read_text;
use glam::Vec3;
use vellus_scene::Mesh;
use vellus_usd::Options;

/// The corners of the box around a mesh.
fn around(mesh: &Mesh) -> (Vec3, Vec3) {
    let bounds = |(low, high): (Vec3, Vec3), p: &Vec3| (low.min(*p), high.max(*p));
    mesh.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), bounds)
}

/// Each shape fills its box, without authored sizes and with them.
#[test]
fn shapes_have_their_sizes() {
    let table = [
        ("Sphere", "", Vec3::ONE),
        ("Sphere", "double radius = 3", Vec3::splat(3.0)),
        ("Cube", "", Vec3::ONE),
        ("Cube", "double size = 3", Vec3::splat(1.5)),
        ("Cylinder", "", Vec3::ONE),
        ("Cylinder", "uniform token axis = \"X\" double radius = 0.5 double height = 6", Vec3::new(3.0, 0.5, 0.5)),
        ("Cylinder_1", "double radiusTop = 2 double height = 4", Vec3::splat(2.0)),
        ("Cone", "uniform token axis = \"Y\" double radius = 3 double height = 4", Vec3::new(3.0, 2.0, 3.0)),
        ("Capsule", "", Vec3::new(0.5, 0.5, 1.0)),
        ("Plane", "uniform token axis = \"Y\" double width = 4 double length = 6", Vec3::new(2.0, 0.0, 3.0)),
        ("Plane", "uniform token axis = \"X\" double width = 4 double length = 6", Vec3::new(0.0, 3.0, 2.0)),
    ];
    for (kind, more, half) in table {
        let (scene, warnings) = scene(&format!("def {kind} \"s\" {{ {more} }}"));
        let (low, high) = around(&scene.meshes[0]);
        assert!(high.abs_diff_eq(half, 1e-6) && low.abs_diff_eq(-half, 1e-6), "{kind} {more}: {low} {high}");
        assert_eq!(said(&warnings), "", "{kind}");
        assert!(scene.meshes[0].uv.is_some(), "{kind}");
    }
}

#[test]
fn shapes_have_materials_transforms_and_motion() {
    let body = "( startTimeCode = 1 endTimeCode = 2 )
def Sphere \"ball\" {
    double radius.timeSamples = { 1: 1.5, 2: 2.5 }
    color3f[] primvars:displayColor = [(0.1, 0.2, 0.3)]
    double3 xformOp:translate = (0, 0, 10)
    uniform token[] xformOpOrder = [\"xformOp:translate\"]
}
def Camera \"c\" { double shutter:close = 1 }";
    let (scene, warnings) = read_text(body, &Options::default()).unwrap();
    assert_eq!(said(&warnings), "");
    let mesh = &scene.meshes[0];
    assert_eq!(scene.surfaces[mesh.surface].color.color, [0.1, 0.2, 0.3]);
    let size = |points: &[Vec3]| points.iter().map(|p| p.distance(10.0 * Vec3::Z)).fold(0.0, f32::max);
    assert!((size(&mesh.positions) - 1.5).abs() < 1e-5);
    assert!((size(mesh.moved.as_ref().unwrap()) - 2.5).abs() < 1e-5);
    let corners = mesh.triangles.iter().zip(mesh.normals.as_ref().unwrap());
    for (triangle, normals) in corners {
        for (vertex, normal) in triangle.iter().zip(normals) {
            let out = (mesh.positions[*vertex as usize] - 10.0 * Vec3::Z) / 1.5;
            assert!(normal.abs_diff_eq(out, 1e-5));
        }
    }
    let error = read_text("def Sphere \"s\" { double radius = -1 }", &Options::default()).unwrap_err().to_string();
    assert!(error.contains("/s: its size must be finite and not negative"), "{error}");
}
