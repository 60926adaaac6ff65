//! Motion: the shutter, time samples and velocities.

use super::said;
use crate::common::{read, read_text};
use glam::Vec3;
use vellus_usd::Options;

/// Without a frame there is no motion blur, and a warning reports this.
#[test]
fn motion_without_a_frame_warns() {
    let body = "
def BasisCurves \"b\" {
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    point3f[] points.timeSamples = { 1: [(0,0,0), (1,0,0)], 2: [(0,0,0), (1,2,0)] }
    float[] widths = [1, 1]
}
def Camera \"c\" { double shutter:close = 1 }";
    let (scene, warnings) = read_text(body, &Options::default()).unwrap();
    assert!(scene.strands[0].moved.is_none() && said(&warnings).contains("no startTimeCode"), "{}", said(&warnings));
    let (scene, warnings) = read_text(body, &Options { frame: Some(1.0), ..Options::default() }).unwrap();
    assert!(scene.strands[0].moved.is_some() && !said(&warnings).contains("no startTimeCode"));
}

/// Time samples take precedence over the default value in the same layer. Values of a stage take precedence over the
/// time samples of its references. Both hold with and without a frame.
#[test]
fn time_samples_take_precedence_over_the_default() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.usda");
    let save = |strong: &str, metadata: &str| {
        let curve = "uniform token type = \"linear\" int[] curveVertexCounts = [2] float[] widths = [1, 1]
            point3f[] points = [(9,0,0), (9,1,0)]
            point3f[] points.timeSamples = { 1: [(1,0,0), (1,1,0)], 3: [(3,0,0), (3,1,0)] }
            double3 xformOp:translate = (0, 0, 90)
            double3 xformOp:translate.timeSamples = { 1: (0, 0, 10), 3: (0, 0, 30) }
            uniform token[] xformOpOrder = [\"xformOp:translate\"]";
        let weak = format!("#usda 1.0\ndef BasisCurves \"b\" {{ {curve} }}");
        std::fs::write(folder.path().join("weak.usda"), weak).unwrap();
        let refers = "prepend references = @./weak.usda@</b>";
        let camera = "def Camera \"c\" { double shutter:close = 1 }";
        let stage = format!("#usda 1.0\n( {metadata} )\ndef \"b\" ( {refers} ) {{ {strong} }}\n{camera}");
        std::fs::write(&path, stage).unwrap();
    };
    let read = |frame| {
        let (scene, _) = read(&path, &Options { frame, ..Options::default() }).unwrap();
        let strands = scene.strands.into_iter().next().unwrap();
        (strands.points[0].truncate(), strands.moved.map(|moved| moved[0]))
    };
    save("", "startTimeCode = 2 endTimeCode = 3");
    let (at_1, at_2, at_3) = (Vec3::new(1.0, 0.0, 10.0), Vec3::new(2.0, 0.0, 20.0), Vec3::new(3.0, 0.0, 30.0));
    assert_eq!(read(None), (at_2, Some(at_3)));
    assert_eq!(read(Some(1.0)), (at_1, Some(at_2)));
    assert_eq!(read(Some(3.0)), (at_3, None));
    save("", "");
    assert_eq!(read(None), (at_1, None));
    save("point3f[] points = [(7,0,0), (7,1,0)]", "startTimeCode = 2 endTimeCode = 3");
    assert_eq!(read(None), (Vec3::new(7.0, 0.0, 20.0), Some(Vec3::new(7.0, 0.0, 30.0))));
}

/// Velocities are per second. They start at the last sample before the shutter opens, or at the frame if there are no
/// samples. They take precedence over later samples, which may have other points.
#[test]
fn velocities_move_curves_and_meshes() {
    let read = |points: &str, more: &str, frame| {
        let shape = format!("point3f[] points{points}\n {more}");
        let body = format!(
            "( startTimeCode = 1 endTimeCode = 9 timeCodesPerSecond = 25 )
def BasisCurves \"c\" {{ uniform token type = \"linear\" int[] curveVertexCounts.timeSamples = {{ 1: [2], 3: [3] }} float[] widths = [1]
    {shape} double3 xformOp:translate = (0, 0, 9) uniform token[] xformOpOrder = [\"xformOp:translate\"] }}
def Mesh \"m\" {{ uniform token subdivisionScheme = \"none\" int[] faceVertexCounts = [3] int[] faceVertexIndices = [0, 1, 1] {shape} }}
def Camera \"eye\" {{ double shutter:open = -0.25 double shutter:close = 0.5 }}"
        );
        let (scene, warnings) = read_text(&body, &Options { frame: Some(frame), ..Options::default() }).unwrap();
        let (curve, mesh) = (&scene.strands[0], &scene.meshes[0]);
        let ends = (curve.points[1].truncate(), curve.moved.as_ref().map(|moved| moved[1]));
        let up = |p: Vec3| p + 9.0 * Vec3::Z;
        let of_mesh = (up(mesh.positions[1]), mesh.moved.as_ref().map(|moved| up(moved[1])));
        assert!(ends.0.abs_diff_eq(of_mesh.0, 1e-5), "{ends:?} {of_mesh:?}");
        assert_eq!(ends.1.is_some(), of_mesh.1.is_some());
        (ends.0, ends.1.unwrap_or(ends.0), said(&warnings))
    };
    let expect = |found: (Vec3, Vec3, String), x: [f32; 2]| {
        let at = |x: f32| Vec3::new(x, 1.0, 9.0);
        // The tolerance is two roundings of coordinates near 9 in single precision.
        assert!(found.0.abs_diff_eq(at(x[0]), 4e-6) && found.1.abs_diff_eq(at(x[1]), 4e-6), "{found:?}, not {x:?}");
        assert_eq!(found.2, "");
    };
    let still = " = [(0,0,0), (0,1,0)]";
    // 50 units per second are 2 units per frame.
    expect(read(still, "vector3f[] velocities = [(0,0,0), (50,0,0)]", 2.0), [-0.5, 1.0]);
    let accelerations = "vector3f[] velocities = [(0,0,0), (50,0,0)] vector3f[] accelerations = [(0,0,0), (2500,0,0)]";
    // The acceleration adds ½ · 4 t², with t in frames.
    expect(read(still, accelerations, 2.0), [-0.5 + 0.125, 1.0 + 0.5]);
    let sampled = ".timeSamples = { 1: [(0,0,0), (7,1,0)], 3: [(0,0,0), (8,1,0), (9,1,0)] }";
    let fast = "vector3f[] velocities.timeSamples = { 1: [(0,0,0), (50,0,0)], 3: [(0,0,0), (25,0,0), (0,0,0)] }";
    expect(read(sampled, fast, 1.25), [7.0, 8.5]);
    expect(read(sampled, fast, 2.75), [10.0, 11.5]);
    // After the second sample, its points and velocities apply.
    expect(read(sampled, fast, 3.25), [8.0, 8.75]);
    // Velocities that do not match give a warning, and the samples are used.
    let two = ".timeSamples = { 1: [(0,0,0), (7,1,0)], 3: [(0,0,0), (9,1,0)] }";
    for wrong in ["velocities = [(1,0,0)]", "velocities.timeSamples = { 2: [(0,0,0), (50,0,0)] }"] {
        let (open, close, said) = read(two, &format!("vector3f[] {wrong}"), 1.25);
        assert_eq!((open.x, close.x), (7.0, 7.75));
        assert!(said.contains("/c, /m: its velocities do not match its points"), "{said}");
    }
}

/// Velocities are per second. If the next sample shows that they are per frame, a warning says so.
#[test]
fn velocities_per_frame_are_noticed() {
    let read = |velocity: f64| {
        let body = format!(
            "( startTimeCode = 1 endTimeCode = 2 timeCodesPerSecond = 24 )
def BasisCurves \"b\" {{
    uniform token type = \"linear\"
    int[] curveVertexCounts = [2]
    point3f[] points.timeSamples = {{ 1: [(0,0,0), (1,0,0)], 2: [(0,0.5,0), (1,0.5,0)] }}
    vector3f[] velocities.timeSamples = {{
        1: [(0,{velocity},0), (0,{velocity},0)], 2: [(0,0,0), (0,0,0)] }}
    float[] widths = [1, 1]
}}
def Camera \"c\" {{ double shutter:close = 0.5 }}"
        );
        let (scene, warnings) = read_text(&body, &Options::default()).unwrap();
        (scene.strands[0].moved.as_ref().unwrap()[0].y, said(&warnings))
    };
    // 12 per second are 0.5 per frame.
    assert_eq!(read(12.0), (0.25, String::new()));
    let (moved, said) = read(0.5);
    assert!(moved < 0.02 && said.contains("/b: its velocities fit its points per frame"), "{said}");
    // Velocities that fit neither are not judged.
    assert_eq!(read(-3.0).1, "");
}

/// UsdGeomPointBased, `ComputePointsAtTimes`: the sample at or before the frame is moved, also if the shutter opens
/// before. Its topology counts.
#[test]
fn velocities_start_at_the_sample_of_the_frame() {
    let stage = |samples: [&str; 3]| {
        let [counts, points, velocities] = samples;
        let body = format!(
            "( startTimeCode = 1 timeCodesPerSecond = 1 )
def Camera \"k\" {{ double shutter:open = -0.25 double shutter:close = 0.25 }}
def BasisCurves \"c\" {{ uniform token type = \"linear\" float[] widths = [1] (interpolation = \"constant\")
    int[] curveVertexCounts.timeSamples = {{ {counts} }} point3f[] points.timeSamples = {{ {points} }}
    vector3f[] velocities.timeSamples = {{ {velocities} }} }}"
        );
        read_text(&body, &Options { frame: Some(2.0), ..Options::default() }).unwrap().0.strands.remove(0)
    };
    let moving = stage([
        "1: [2]",
        "1: [(9,0,0), (9,1,0)], 2: [(0,0,0), (0,1,0)]",
        "1: [(1,0,0), (1,0,0)], 2: [(4,0,0), (4,0,0)]",
    ]);
    assert_eq!((moving.points[0].x, moving.moved.unwrap()[0].x), (-1.0, 1.0));
    let more = stage([
        "1: [2], 2: [2, 2]",
        "1: [(9,0,0), (9,1,0)], 2: [(0,0,0), (0,1,0), (1,0,0), (1,1,0)]",
        "1: [(1,0,0), (1,0,0)], 2: [(0,0,0), (0,0,0), (0,0,0), (0,0,0)]",
    ]);
    assert_eq!((more.len(), more.points[0].x, more.points[2].x), (2, 0.0, 1.0));
}

/// Motion is straight between the times of the shutter, which need not be times of samples. A warning names what bends.
#[test]
fn motion_blur_is_straight_and_bends_are_named() {
    let read = |points: &str, turn: &str| {
        let body = format!(
            "def BasisCurves \"b\" {{ uniform token type = \"linear\" int[] curveVertexCounts = [2]
            float[] widths = [1, 1] point3f[] points.timeSamples = {{ {points} }}
            float xformOp:rotateZ.timeSamples = {{ {turn} }}
            uniform token[] xformOpOrder = [\"xformOp:rotateZ\"] }}
            def Camera \"c\" {{ double shutter:open = -0.5 double shutter:close = 0.5 }}"
        );
        let (scene, warnings) = read_text(&body, &Options { frame: Some(1.0), ..Options::default() }).unwrap();
        let strands = &scene.strands[0];
        (strands.points[0].y, strands.moved.as_ref().map_or(strands.points[0].y, |moved| moved[0].y), said(&warnings))
    };
    let samples =
        |middle: f32| format!("0: [(0,0,0), (9,0,0)], 1: [(0,{middle},0), (9,{middle},0)], 2: [(0,8,0), (9,8,0)]");
    let still = "0: 0, 2: 0";
    assert_eq!(read(&samples(4.0), still), (2.0, 6.0, String::new()));
    // 3.5 instead of 4 in the middle of the shutter is an eighth of its motion.
    let (open, close, said) = read(&samples(3.5), still);
    assert!((open, close) == (1.75, 5.75) && said.contains("/b: the path of its points bends"), "{said}");
    // A chord is (1 − cos 5°) = 0.4 % of the radius away from a turn by 10°, which is 2 % of it; and 14 % at 60°.
    let fixed = "0: [(0,1,0), (0,2,0)]";
    assert_eq!(read(fixed, "0: 0, 2: 20").2, "");
    assert!(read(fixed, "0: 0, 2: 120").2.contains("/b: its path bends while the shutter is open"));
}
