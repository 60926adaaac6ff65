//! RenderSettings: camera, size, part and shape of the picture.

use super::{FOUR, said};
use vellus_scene::Fit;
use vellus_usd::{Options, Reading};

const CAMERAS: &str = "def Camera \"first\" { float horizontalAperture = 40 float verticalAperture = 20
    float fStop = 2 float focusDistance = 3 double shutter:close = 0.5 }
def Camera \"close\" { float focalLength = 200 float horizontalAperture = 40 float verticalAperture = 20
    float fStop = 2 float focusDistance = 3 double shutter:close = 0.5
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (0, 4, 0) }
    uniform token[] xformOpOrder = [\"xformOp:translate\"] }";

fn read(metadata: &str, body: &str, camera: Option<&str>) -> (Reading, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("stage.usda");
    let text = format!(
        "#usda 1.0\n( startTimeCode = 1\n endTimeCode = 2\n {metadata} )\ndef BasisCurves \"b\" {{ {FOUR} }}\n{CAMERAS}
{body}"
    );
    std::fs::write(&file, text).unwrap();
    let reading =
        vellus_usd::read(&file, &Options { camera: camera.map(str::to_owned), ..Options::default() }).unwrap();
    let said = said(&reading.warnings);
    (reading, said)
}

/// The camera's film over its focal length, which tells the cameras apart.
fn width(reading: &Reading) -> f32 {
    reading.scene.camera.unwrap().film_width
}

#[test]
fn settings_choose_the_picture() {
    let (plain, said) = read("", "", None);
    assert_eq!((plain.settings, width(&plain), said.as_str()), (None, 0.8, ""));
    assert_eq!(plain.scene.camera.unwrap().fit, Fit::Expand);

    let settings = |more: &str| {
        format!(
            "def Scope \"Render\" {{ def RenderSettings \"a\" {{ rel camera = </close>
                uniform int2 resolution = (320, 180) {more} }} }}"
        )
    };
    let (found, said) = read("", &settings("uniform float4 dataWindowNDC = (0.25, 0.5, 0.75, 1)"), None);
    let picture = found.settings.unwrap();
    assert_eq!((picture.size, width(&found), said.as_str()), (Some([320, 180]), 0.2, ""));
    // The upper half of the middle half.
    assert_eq!(picture.crop([320, 180]), Some([80, 0, 160, 90]));
    assert_eq!(picture.crop([4, 3]), Some([1, 0, 2, 1]));
    let camera = found.scene.camera.unwrap();
    assert!(camera.moved.is_some() && camera.lens_radius > 0.0);
    // The command line wins.
    assert_eq!(width(&read("", &settings(""), Some("first")).0), 0.8);
    assert_eq!(read("", &settings(""), None).0.settings.unwrap().crop([320, 180]), None);

    for (policy, fit) in [
        ("expandAperture", Fit::Expand),
        ("cropAperture", Fit::Crop),
        ("adjustApertureWidth", Fit::AdjustWidth),
        ("adjustApertureHeight", Fit::AdjustHeight),
    ] {
        let (found, said) =
            read("", &settings(&format!("uniform token aspectRatioConformPolicy = \"{policy}\"")), None);
        assert_eq!((found.scene.camera.unwrap().fit, said.as_str()), (fit, ""));
    }
    let sharp = settings("uniform bool disableMotionBlur = 1 uniform bool disableDepthOfField = 1");
    let (found, said) = read("", &sharp, None);
    let camera = found.scene.camera.unwrap();
    assert_eq!((camera.moved, camera.lens_radius, said.as_str()), (None, 0.0, ""));
}

#[test]
fn the_stage_says_which_settings_count_and_a_product_overrides_them() {
    let two = "def Scope \"Render\" {
        def RenderSettings \"a\" { uniform int2 resolution = (10, 10) }
        def RenderSettings \"b\" { uniform int2 resolution = (20, 20)
            rel camera = </close> rel products = [<../p>, <../q>] }
        def RenderProduct \"p\" { uniform int2 resolution = (30, 30) }
        def RenderProduct \"q\" { uniform int2 resolution = (40, 40) }
    }";
    let (found, said) = read("", two, None);
    assert_eq!((found.settings, width(&found)), (None, 0.8));
    assert!(said.contains("/Render/a, /Render/b: the stage has several RenderSettings"), "{said}");
    let (found, said) = read("renderSettingsPrimPath = \"/Render/b\"", two, None);
    assert_eq!((found.settings.unwrap().size, width(&found)), (Some([30, 30]), 0.2));
    assert!(said.contains("/Render/b: it has several products") && said.lines().count() == 1, "{said}");
    let (found, said) = read("renderSettingsPrimPath = \"/Render\"", two, None);
    assert!(found.settings.is_none() && said.contains("which is no RenderSettings: it is ignored"), "{said}");
}

/// What cannot be used is named, and the rest counts.
#[test]
fn settings_that_are_not_used_give_warnings() {
    let (found, said) = read(
        "",
        "def RenderSettings \"s\" { rel camera = </gone> uniform int2 resolution = (0, 99999)
            uniform float pixelAspectRatio = 2 uniform token aspectRatioConformPolicy = \"adjustPixelAspectRatio\"
            uniform float4 dataWindowNDC = (2, 0, 3, 1) uniform token[] includedPurposes = [\"default\", \"proxy\"] }",
        None,
    );
    for expected in [
        "/gone: the camera of the RenderSettings does not exist",
        "/s: resolution is",
        "/s: pixelAspectRatio is ignored",
        "/s: aspectRatioConformPolicy is adjustPixelAspectRatio",
        "/s: dataWindowNDC is",
        "/s: includedPurposes is ignored",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    assert_eq!((said.lines().count(), width(&found), found.settings.unwrap().size), (6, 0.8, None), "{said}");
    let (found, said) = read("", "def RenderSettings \"s\" { uniform float4 dataWindowNDC = (-0.5, 0, 0.5, 1) }", None);
    assert!(said.contains("reaches beyond the picture"), "{said}");
    assert_eq!(found.settings.unwrap().crop([8, 8]), Some([0, 0, 4, 8]));
}
