//! A square patch of dense fur in white light, for measuring and showing the colour of a coat.

use crate::error::Error;
use crate::{GrowSettings, Maps, grow};
use glam::Vec3;
use vellus::Fiber;
use vellus_scene::{Camera, LightShape, Look, Mesh, Scene, Surface};

/// Half the side of the skin.
const HALF: f32 = 1.0;
/// Side of the square that the camera sees. Light hardly travels from the edge of the skin to it.
const SEEN: f32 = 0.5;
/// Strands on the skin. They cover it 13 times.
const STRANDS: usize = 60_000;

/// The reference coat: the patch of fur whose colour [`vellus::Color::Reflectance`] asks for.
///
/// A flat, white skin of 2 × 2 units has 60,000 strands. They are 0.45 units long (± 20 %), with a radius of 0.001 to
/// 0.0006 units. They lie in one direction with a standard deviation of 20°, and rise from the skin by 50° at the root
/// and 20° at the tip. Fibres fill about 6 % of the space of the coat and cover the skin 13 times, so that the skin is
/// hardly seen. A white dome of radiance 1 lights the coat from all sides. The camera looks straight down at the middle
/// 0.5 × 0.5 units, from 20 units. Without absorption the picture is white, with radiance 1 everywhere. The colour of
/// the coat is the mean radiance of the picture.
///
/// # Errors
/// None in practice: the settings are valid.
pub fn reference_coat(fiber: Fiber) -> Result<Scene, Error> {
    let corner = |x: f32, z: f32| Vec3::new(x * HALF, 0.0, z * HALF);
    let skin = Mesh {
        name: "skin".to_owned(),
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        moved: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uv: None,
        surface: 0,
    };
    let settings = GrowSettings {
        count: STRANDS,
        length: 0.45,
        radius: [0.001, 0.0006],
        lift: [50f32.to_radians(), 20f32.to_radians()],
        spread: 20f32.to_radians(),
        noise: 0.05,
        ..GrowSettings::default()
    };
    let strands = grow(&skin, &settings, &Maps { comb: &|_| Vec3::X, ..Maps::default() })?;
    let height = 20.0;
    let angle = 2.0 * (0.5 * SEEN / height).atan();
    Ok(Scene {
        strands: vec![strands],
        meshes: vec![skin],
        surfaces: vec![Surface::diffuse("skin", [1.0; 3])],
        looks: vec![Look::constant("fur", fiber)],
        lights: vec![
            LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: glam::Mat3::IDENTITY, ground: None }.into(),
        ],
        camera: Some(Camera::look_at(Vec3::new(0.0, height, 0.0), Vec3::ZERO, Vec3::Z, angle, 1.0)),
        ..Scene::default()
    })
}
