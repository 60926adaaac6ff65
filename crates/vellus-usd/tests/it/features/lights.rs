//! Lights of UsdLux.

use super::{FOUR, said, scene};
use glam::{Mat3, Vec3};
use vellus_scene::{LightShape, Shaping};
use vellus_usd::Options;

#[test]
fn lights_have_the_radiance_of_usdlux() {
    let (scene, warnings) = scene(&format!(
        "( upAxis = \"Z\" )
def BasisCurves \"b\" {{ {FOUR} }}
def RectLight \"rect\" {{ float inputs:width = 2 float inputs:height = 3 float inputs:intensity = 6 float inputs:exposure = 1
    bool inputs:normalize = 1 color3f inputs:color = (1, 0.5, 0)
    float3 xformOp:scale = (2, 1, 1) uniform token[] xformOpOrder = [\"xformOp:scale\"] }}
def DiskLight \"disk\" {{ token vellus:lightGroup = \"key-2\" float intensity = 3
    asset inputs:shaping:ies:file = @a.ies@ }}
def SphereLight \"sphere\" {{ float inputs:radius = 0.5 bool inputs:normalize = 1
    float3 xformOp:scale = (2, 2, 2) uniform token[] xformOpOrder = [\"xformOp:scale\"] }}
def DistantLight \"sun\" {{ float inputs:angle = 60 float inputs:intensity = 2
    float xformOp:rotateX = 90 uniform token[] xformOpOrder = [\"xformOp:rotateX\"] }}
def DistantLight \"parallel\" {{ float inputs:angle = 0 float inputs:intensity = 2 }}
def DomeLight \"sky\" {{ float vellus:groundHeight = 1.5 float vellus:groundRadius = 20
    double3 xformOp:translate = (1, 2, 3) float3 xformOp:scale = (2, 2, 2)
    uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"] }}
def DomeLight_1 \"sky1\" {{ }}
def CylinderLight \"tube\" {{ float inputs:radius = 0.25 float inputs:length = 3 bool inputs:normalize = 1
    float3 xformOp:scale = (2, 2, 2) uniform token[] xformOpOrder = [\"xformOp:scale\"] }}
def PortalLight \"portal\" {{ }}"
    ));
    let said = said(&warnings);
    assert!(
        said.contains("a.ies")
            && said.contains("the light shines without its profile")
            && said.contains("/portal: PortalLight is not")
            && warnings.len() == 2,
        "{said}"
    );
    let shapes: Vec<_> = scene.lights.iter().map(|light| &light.shape).collect();
    let [rect, disk, sphere, sun, parallel, sky, sky1, tube] = shapes[..] else { panic!() };
    assert_eq!(scene.light_group_names()[1..5], ["key-2", "sphere", "sun", "parallel"]);
    // The intensity 6 times 2 for the exposure, over an area of 2 · 2 · 3.
    let LightShape::Rect { radiance, to_world, .. } = rect else { panic!() };
    assert_eq!((*radiance, to_world.x_axis.x, to_world.y_axis.y), ([1.0, 0.5, 0.0], 4.0, 3.0));
    let LightShape::Disk { radiance, to_world } = disk else { panic!() };
    assert_eq!((*radiance, to_world.x_axis.x), ([3.0; 3], 0.5));
    let LightShape::Sphere { radius, radiance, .. } = sphere else { panic!() };
    assert!(*radius == 1.0 && (radiance[0] * 4.0 * std::f32::consts::PI - 1.0).abs() < 1e-6);
    let LightShape::Cylinder { half_axis, radius, radiance, .. } = tube else { panic!() };
    assert_eq!((*half_axis, *radius), (Vec3::new(3.0, 0.0, 0.0), 0.5));
    // The lateral area of the cylinder is 2 π times 0.5 times 6.
    assert!((radiance[0] * 6.0 * std::f32::consts::PI - 1.0).abs() < 1e-6);
    let LightShape::Distant { direction, half_angle, irradiance } = sun else { panic!() };
    // The light travels along −z, which the rotation turns to +y. The irradiance is π sin² 30° times the radiance of 2.
    assert!(direction.abs_diff_eq(-Vec3::Y, 1e-6) && (half_angle.to_degrees() - 30.0).abs() < 1e-5);
    assert!((irradiance[0] - 0.5 * std::f32::consts::PI).abs() < 1e-6);
    let LightShape::Distant { half_angle, irradiance, .. } = parallel else { panic!() };
    assert_eq!((*half_angle, *irradiance), (0.0, [2.0; 3]));
    let axes = |light: &LightShape| match light {
        LightShape::Dome { rotation, .. } => (*rotation * Vec3::Y, *rotation * Vec3::NEG_Z),
        _ => panic!(),
    };
    let LightShape::Dome { ground: Some(ground), .. } = sky else { panic!() };
    assert_eq!((ground.origin, ground.height, ground.radius), (Vec3::new(1.0, 2.0, 3.0), 3.0, 40.0));
    // The directions of the pole and of the middle of the image.
    assert_eq!(axes(sky), (Vec3::Y, Vec3::Z));
    let (pole, middle) = axes(sky1);
    assert!(pole.abs_diff_eq(Vec3::Z, 1e-6) && middle.abs_diff_eq(-Vec3::Y, 1e-6));
    let LightShape::Dome { rotation, .. } = sky1 else { panic!() };
    assert!((*rotation * rotation.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-6));
}

/// A lamp that is bright below, to the left of its light, and a warm one. The texture has candela; the light of a
/// file that is no profile is as bright as without it.
#[test]
fn profiles_tints_and_temperatures_shape_lights() {
    let folder = tempfile::tempdir().unwrap();
    let profile =
        "IESNA:LM-63-1995\nTILT=NONE\n1 -1 1 3 4 1 2 0 0 0 1 1 9\n0 90 180\n0 90 180 270\n9 8 7 9 4 7 9 2 7 9 1 7\n";
    std::fs::write(folder.path().join("lamp.ies"), profile).unwrap();
    std::fs::write(folder.path().join("bad.ies"), "IESNA:LM-63-1995\nTILT=NONE\n1 x").unwrap();
    let ies = "prepend apiSchemas = [\"ShapingAPI\"]";
    let stage = format!(
        "#usda 1.0
def BasisCurves \"b\" {{ {FOUR} }}
def SphereLight \"lamp\" ( {ies} ) {{ asset inputs:shaping:ies:file = @lamp.ies@
    float xformOp:rotateY = 90 uniform token[] xformOpOrder = [\"xformOp:rotateY\"] }}
def RectLight \"even\" ( {ies} ) {{ asset inputs:shaping:ies:file = @lamp.ies@ bool inputs:shaping:ies:normalize = 1 }}
def RectLight \"bad\" ( {ies} ) {{ asset inputs:shaping:ies:file = @bad.ies@ }}
def RectLight \"tinted\" ( {ies} ) {{ float inputs:shaping:focus = 3 color3f inputs:shaping:focusTint = (1, 0.5, 0) }}
def RectLight \"warm\" {{ bool inputs:enableColorTemperature = 1 float inputs:colorTemperature = 3000
    color3f inputs:color = (1, 0.5, 1) float inputs:intensity = 2 }}"
    );
    let file = folder.path().join("a.usda");
    std::fs::write(&file, stage).unwrap();
    let (scene, warnings) =
        vellus_usd::read(&file, &Options::default()).map(|read| (read.scene, read.warnings)).unwrap();
    let said = said(&warnings);
    assert!(warnings.len() == 1 && said.contains("/bad: ") && said.contains("bad.ies: broken profile"), "{said}");
    let shapings: Vec<_> = scene.lights.iter().map(|light| light.shaping.as_ref()).collect();
    let [Some(lamp), Some(even), _, Some(tinted), None] = shapings[..] else { panic!("{shapings:?}") };
    assert_eq!((tinted.tint, tinted.focus), ([1.0, 0.5, 0.0], 3.0));
    let factor = tinted.factor(Vec3::new(0.6, 0.0, -0.8));
    assert!((factor[0] - 1.0).abs() < 1e-6 && (factor[1] - 0.756).abs() < 1e-6 && (factor[2] - 0.512).abs() < 1e-6);
    // hdEmbree looks profiles up in the direction to the light: the first column is at −x, the second at −y.
    let at = |shaping: &Shaping, direction: Vec3| {
        let profile = shaping.profile.unwrap();
        let image = &scene.textures[profile.texture];
        image.at(profile.uv(shaping.axis.normalize(), direction, [image.width, image.height]))[0]
    };
    let turn = Mat3::from_rotation_y(std::f32::consts::FRAC_PI_2);
    for (direction, candela) in
        [(Vec3::NEG_Z, 9.0), (Vec3::NEG_X, 8.0), (Vec3::NEG_Y, 4.0), (Vec3::X, 2.0), (Vec3::Y, 1.0), (Vec3::Z, 7.0)]
    {
        assert!((at(lamp, turn * direction) - candela).abs() < 0.02, "{direction}");
    }
    assert!((at(even, Vec3::NEG_X) / at(even, Vec3::X) - 4.0).abs() < 0.05 && at(even, Vec3::NEG_X) < 4.0);
    // UsdLux.BlackbodyTemperatureAsRgb(3000) of OpenUSD is (1.7710, 0.8443, 0.2720).
    let LightShape::Rect { radiance, .. } = scene.lights[4].shape else { panic!() };
    for (found, expected) in radiance.into_iter().zip([2.0 * 1.7710, 0.8443, 2.0 * 0.2720]) {
        assert!((found - expected).abs() < 0.01, "{radiance:?}");
    }
}

/// UsdLux has no attribute for this, so those of four renderers count. The first one that a light has decides.
#[test]
fn lights_are_invisible_to_the_camera() {
    let (scene, warnings) = scene(&format!(
        "( )
def BasisCurves \"b\" {{ {FOUR} }}
def RectLight \"renderman\" {{ int primvars:ri:attributes:visibility:camera = 0 }}
def RectLight \"arnold\" {{ float primvars:arnold:camera = 0 }}
def RectLight \"karma\" {{ bool karma:light:renderlightgeo = 0 }}
def RectLight \"rtx\" {{ bool visibleInPrimaryRay = 0 }}
def RectLight \"both\" {{ int primvars:ri:attributes:visibility:camera = 1 float primvars:arnold:camera = 0 }}
def RectLight \"none\" {{ }}
def DomeLight \"sky\" {{ float primvars:arnold:camera = 0 }}"
    ));
    let seen: Vec<bool> = scene.lights.iter().map(|light| light.visible).collect();
    assert_eq!((seen, warnings.len()), (vec![false, false, false, false, true, true, false], 0));
}

/// Blender writes points as spheres of radius 0, and spots as points with a shaping.
#[test]
fn points_and_their_shaping_are_read() {
    let (scene, warnings) = scene(&format!(
        "( )
def BasisCurves \"b\" {{ {FOUR} }}
def SphereLight \"point\" {{ float inputs:radius = 0 bool treatAsPoint = 1
    bool inputs:normalize = 1 float inputs:intensity = 8
    double3 xformOp:translate = (1, 2, 3) uniform token[] xformOpOrder = [\"xformOp:translate\"] }}
def SphereLight \"spot\" ( prepend apiSchemas = [\"ShapingAPI\"] ) {{ float inputs:radius = 0 bool treatAsPoint = 1
    float inputs:shaping:cone:angle = 20 float inputs:shaping:cone:softness = 0.3 float inputs:shaping:focus = 2
    float xformOp:rotateX = 90 uniform token[] xformOpOrder = [\"xformOp:rotateX\"] }}
def RectLight \"wide\" {{ float inputs:shaping:cone:angle = 90 }}
def SphereLight \"half\" {{ float inputs:shaping:cone:angle = 90 }}
def DistantLight \"sun\" {{ float inputs:shaping:cone:angle = 20 }}
def DistantLight \"Sun\" {{ custom string userProperties:blender:data_name = \"Sun\" }}"
    ));
    let said = said(&warnings);
    assert!(
        said.contains("/spot: a point has no area")
            && said.contains("/sun: the shaping of domes")
            && warnings.len() == 3,
        "{said}"
    );
    assert!(said.contains("/Sun: Blender writes a quarter"), "{said}");
    // A normalized sphere of radius r has the radiance 8/(4πr²), and a disk of area πr² is seen: 2 per solid angle.
    assert_eq!(scene.lights[0].shape, LightShape::Point { position: Vec3::new(1.0, 2.0, 3.0), intensity: [2.0; 3] });
    assert_eq!(scene.lights[1].shape.kind(), "point");
    let shapings: Vec<_> = scene.lights.iter().map(|light| light.shaping).collect();
    let [None, Some(spot), None, Some(half), ..] = shapings[..] else { panic!("{shapings:?}") };
    // −z, turned about x by 90 degrees.
    assert!(spot.axis.abs_diff_eq(Vec3::Y, 1e-6) && (spot.cone.to_degrees() - 20.0).abs() < 1e-4);
    assert_eq!((spot.softness, spot.focus, half.cone), (0.3, 2.0, std::f32::consts::FRAC_PI_2));
    // A sphere of radius 0 is an error without the hint.
    let bare = "( )\ndef SphereLight \"point\" { float inputs:radius = 0 }";
    let bare = crate::common::read_text(bare, &Options::default()).unwrap_err().to_string();
    assert!(bare.contains("/point: inputs:radius is 0"), "{bare}");
}

/// A mirroring scale mirrors the image of a dome. Of a shear, the nearest rotation counts.
#[test]
fn domes_are_mirrored_and_keep_no_shear() {
    let dome = |op: &str, value: &str| {
        let (scene, warnings) = scene(&format!(
            "( )
def BasisCurves \"b\" {{ {FOUR} }}
def Xform \"x\" {{ {op} = {value} uniform token[] xformOpOrder = [\"{}\"] def DomeLight \"sky\" {{ }} }}",
            op.rsplit(' ').next().unwrap()
        ));
        let LightShape::Dome { rotation, .. } = scene.lights[0].shape else { panic!() };
        assert!((rotation * rotation.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-6));
        // Without the half turn between the frames of the file and of the scene.
        (rotation * Mat3::from_diagonal(Vec3::new(-1.0, 1.0, -1.0)), said(&warnings))
    };
    let scale = |value: &str| dome("float3 xformOp:scale", value);
    let mirror = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
    for (value, expected) in [
        ("(-1, 1, 1)", mirror),
        ("(-3, 3, 3)", mirror),
        ("(-2, -2, -2)", -Mat3::IDENTITY),
        ("(5, 5, 5)", Mat3::IDENTITY),
    ] {
        let (found, said) = scale(value);
        assert!(found.abs_diff_eq(expected, 1e-6) && said.is_empty(), "{value}: {found} {said}");
    }
    let (turned, said) = scale("(-1, 2, 1)");
    assert!(turned.abs_diff_eq(mirror, 1e-6) && said.contains("/x/sky: of the transform of a dome"), "{turned} {said}");
    // y is moved along x by a half. The nearest rotation turns by the angle whose tangent is half of that.
    let (sheared, said) = dome("matrix4d xformOp:transform", "((1,0,0,0), (0.5,1,0,0), (0,0,1,0), (0,0,0,1))");
    assert!(sheared.abs_diff_eq(Mat3::from_rotation_z(-0.25f32.atan()), 1e-6), "{sheared}");
    assert!(said.contains("a shear are ignored"), "{said}");
    let (flat, said) = scale("(1, 0, 1)");
    assert!(flat.is_finite() && said.contains("/x/sky: of the transform"), "{flat} {said}");
}
