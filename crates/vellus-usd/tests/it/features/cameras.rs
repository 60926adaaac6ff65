//! Cameras, and the units of the stage.

use super::{FOUR, said, scene};
use crate::common::{read_text, told};
use glam::Vec3;
use vellus_scene::Units;
use vellus_usd::Options;

#[test]
fn cameras_are_chosen_and_move() {
    let body = "( startTimeCode = 1 endTimeCode = 2 )
def BasisCurves \"b\" {
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    point3f[] points.timeSamples = { 1: [(0,0,0), (1,0,0)], 2: [(0,0,0), (1,2,0)] }
    float[] widths = [1, 1]
}
def Camera \"wide\" { float focalLength = 20 float horizontalAperture = 40 float verticalAperture = 20
    double shutter:open = 0 double shutter:close = 0.5 }
def Xform \"rig\" {
    float3 xformOp:scale = (2, 2, 2)
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 1), 2: (0, 4, 1) }
    uniform token[] xformOpOrder = [\"xformOp:scale\", \"xformOp:translate\"]
    def Mesh \"sail\" { uniform token subdivisionScheme = \"none\" int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2] point3f[] points = [(0,0,0), (1,0,0), (0,1,0)] }
    def Camera \"long\" { float focalLength = 80 float fStop = 2 float focusDistance = 3 double shutter:close = 0.25 }
}";
    let (scene, warnings) = read_text(body, &Options::default()).unwrap();
    assert_eq!(said(&warnings), "");
    let camera = scene.camera.unwrap();
    assert_eq!((camera.film_width, camera.film_height, camera.lens_radius, camera.moved), (2.0, 1.0, 0.0, None));
    assert_eq!(scene.strands[0].moved, Some(vec![Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)]));
    // The mesh has the scale and the motion of its parent.
    assert_eq!(scene.meshes[0].positions[1], Vec3::new(2.0, 0.0, 2.0));
    assert_eq!(scene.meshes[0].moved.as_ref().unwrap()[1], Vec3::new(2.0, 4.0, 2.0));
    let by_name = |name: &str, frame| Options { camera: Some(name.to_owned()), frame, ..Options::default() };
    let (scene, _) = read_text(body, &by_name("long", Some(1.5))).unwrap();
    let camera = scene.camera.unwrap();
    // A focal length of 80 tenths of a unit at f/2 is a lens of radius 2.
    assert_eq!((camera.lens_radius, camera.focus_distance), (2.0, 3.0));
    assert_eq!(camera.to_world.w_axis.truncate(), Vec3::new(0.0, 4.0, 2.0));
    assert_eq!(camera.to_world.x_axis.x, 1.0);
    assert_eq!(camera.moved.unwrap().w_axis.truncate(), Vec3::new(0.0, 6.0, 2.0));
    assert_eq!(scene.strands[0].points[1].truncate(), Vec3::new(1.0, 1.0, 0.0));
    let error = told(read_text(body, &by_name("none", None)));
    assert!(error.contains("no camera called none"), "{error}");
}

#[test]
fn units_are_kept_and_unsupported_camera_settings_warn() {
    let with = |metadata: &str| {
        let body =
            format!("( {metadata} )\ndef BasisCurves \"b\" {{ {FOUR} }}\ndef Camera \"c\" {{ float exposure = 1 }}");
        read_text(&body, &Options::default())
    };
    let (scene, warnings) = with("upAxis = \"Z\"\n metersPerUnit = 0.0254").unwrap();
    assert_eq!(scene.units, Some(Units { meters_per_unit: 0.0254, z_up: true }));
    assert!(said(&warnings).contains("/c: the camera's exposure is not supported"), "{}", said(&warnings));
    assert_eq!(with("doc = \"none\"").unwrap().0.units, Some(Units::CENTIMETERS));
    for broken in ["metersPerUnit = 0", "metersPerUnit = -1", "metersPerUnit = nan"] {
        let error = told(with(broken));
        assert!(error.contains("metersPerUnit must be a positive number"), "{error}");
    }
}

/// The film is 2 wide and shifted by a quarter of that to the right, and by a tenth of its height down.
#[test]
fn offsets_of_the_aperture_shift_the_film() {
    let (scene, warnings) = scene(&format!(
        "( )
def BasisCurves \"b\" {{ {FOUR} }}
def Camera \"c\" {{ float focalLength = 10 float horizontalAperture = 20 float verticalAperture = 10
    float horizontalApertureOffset = 5 float verticalApertureOffset = -1 }}"
    ));
    assert_eq!((scene.camera.unwrap().shift, warnings.len()), ([0.5, -0.1], 0));
}
