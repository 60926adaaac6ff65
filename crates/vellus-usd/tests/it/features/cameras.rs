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

/// The cameras of the frames before, as long as only the camera and what holds it move.
#[test]
fn the_cameras_of_earlier_frames_are_those_of_the_frames() {
    let stage = |points: &str, color: &str| {
        format!(
            "( startTimeCode = 1 endTimeCode = 9 )
            def Xform \"groom\" {{
                double3 xformOp:translate.timeSamples = {{ 3: (0, 0, 0), 4: (1, 0, 0) }}
                uniform token[] xformOpOrder = [\"xformOp:translate\"]
                def BasisCurves \"b\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2]
                    point3f[] points{points} float[] widths = [1, 1] }}
            }}
            def DistantLight \"sun\" {{ color3f inputs:color{color} }}
            def Xform \"rig\" {{
                double3 xformOp:translate.timeSamples = {{ 1: (0, 0, 1), 9: (0, 8, 1) }}
                uniform token[] xformOpOrder = [\"xformOp:translate\"]
                def Camera \"c\" {{ float focalLength.timeSamples = {{ 1: 50, 9: 58 }} double shutter:close = 0.5 }}
            }}"
        )
    };
    let folder = tempfile::tempdir().unwrap();
    let read = |text: &str, frame: Option<f64>| {
        let file = folder.path().join("shot.usda");
        std::fs::write(&file, format!("#usda 1.0\n{text}")).unwrap();
        vellus_usd::read(&file, &Options { frame, earlier: 5, ..Options::default() }).unwrap()
    };
    let one = "= [(0,0,0), (1,0,0)]";
    let still = stage(one, "= (1, 1, 1)");
    // The groom moves from frame 3 to 4.
    for (frame, count) in [(2.0, 5), (3.0, 0), (4.0, 0), (6.0, 2), (8.0, 4), (20.0, 5)] {
        let reading = read(&still, Some(frame));
        assert_eq!((reading.earlier.len(), said(&reading.warnings).as_str()), (count, ""), "{frame}");
        for (k, camera) in reading.earlier.iter().enumerate() {
            assert_eq!(Some(*camera), read(&still, Some(frame - 1.0 - k as f64)).scene.camera, "{frame} {k}");
        }
        assert_eq!(reading.scene.camera, read(&still, Some(frame)).scene.camera);
    }
    let bends = stage(".timeSamples = { 1: [(0,0,0), (1,0,0)], 9: [(0,0,0), (1,1,0)] }", "= (1, 1, 1)");
    let sunset = stage(one, ".timeSamples = { 1: (1, 1, 1), 9: (1, 0, 0) }");
    let timeless = still.split_once(')').unwrap().1.to_owned();
    for (text, frame) in [(bends, Some(8.0)), (sunset, Some(8.0)), (timeless, None)] {
        assert!(read(&text, frame).earlier.is_empty(), "{text}");
    }
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
