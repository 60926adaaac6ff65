//! Variants of the built-in scenes, for the programs in `src/bin`.

use std::error::Error;
use vellus_groom::scene;
use vellus_scene::{LightShape, Scene};

/// A built-in scene with other pigment or light: `SCENE:white` has no pigment, `SCENE:black` much. `SCENE@front` has a
/// sun behind the camera, `SCENE@back` one behind the object, `SCENE@sky` a white sky.
pub fn varied(name: &str) -> Result<Scene, Box<dyn Error>> {
    let (name, light) = name.split_once('@').unwrap_or((name, ""));
    let (name, pigment) = name.split_once(':').unwrap_or((name, ""));
    let mut scene = scene(name, false).ok_or_else(|| format!("there is no scene {name}"))?;
    if !pigment.is_empty() {
        let sigma = if pigment == "white" { [0.0; 3] } else { [4.0; 3] };
        scene.all_strands_mut().filter(|strands| strands.len() > 1000).for_each(|strands| strands.varying.clear());
        scene.looks.iter_mut().for_each(|look| (look.fiber.sigma_ca, look.fiber.sigma_ma) = (sigma, sigma));
    }
    if !light.is_empty() {
        let camera = scene.camera.ok_or("the scene has no camera")?;
        let (away, up) = (camera.to_world.z_axis.truncate(), camera.to_world.y_axis.truncate());
        let direction = (if light == "back" { -away } else { away } + 0.5 * up).normalize();
        // The studio would hide a sun behind the object.
        scene.meshes.retain(|mesh| light != "back" || !["backdrop", "ground"].contains(&mesh.name.as_str()));
        let shape = if light == "sky" {
            LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: glam::Mat3::IDENTITY, ground: None }
        } else {
            LightShape::Distant { direction, half_angle: 0.0047, irradiance: [3.0; 3] }
        };
        scene.lights = vec![shape.into()];
    }
    Ok(scene)
}
