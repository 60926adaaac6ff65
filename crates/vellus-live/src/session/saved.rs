//! Scenes to write: what is shown, or a part of it.

use super::Session;
use vellus_scene::{Light, LightShape, Look, Scene, Surface, Tint};

impl Session {
    /// A scene with one look or with the camera only, to write it.
    pub fn part(&self, look: Option<usize>) -> Scene {
        let looks = look.and_then(|i| self.now.looks.get(i)).map(|(look, _)| Look { textured: vec![], ..look.clone() });
        let camera = look.is_none().then(|| self.orbit.camera());
        Scene { looks: looks.into_iter().collect(), camera, units: self.rest.units, ..Scene::default() }
    }

    /// The lights, to write them. Lights that the file does not have get the exposure that `vellus render` gives them.
    fn written_lights(&self) -> impl Iterator<Item = Light> {
        self.shown_lights(self.metered.exp2()).into_iter().map(without_image)
    }

    /// The lights alone, without links.
    pub fn lamps(&self) -> Scene {
        let lights = self.written_lights().map(|light| Light { link: None, ..light }).collect();
        Scene { lights, units: self.rest.units, ..Scene::default() }
    }

    /// The whole scene as it is shown, without images.
    pub fn scene(&self) -> Scene {
        let strands = self.world.curves().strands().to_vec();
        let looks = self.now.looks.iter().map(|(look, _)| Look { textured: vec![], ..look.clone() }).collect();
        let lights = self.written_lights().collect();
        Scene { strands, looks, lights, camera: Some(self.orbit.camera()), ..self.rest.clone() }
    }
}

/// What [`Session::rest`] keeps of a scene.
pub(super) fn rest(scene: &Scene) -> Scene {
    let plain = |surface: &Surface| Surface { color: Tint { texture: None, ..surface.color }, ..surface.clone() };
    Scene {
        meshes: scene.meshes.clone(),
        prototypes: scene.prototypes.clone(),
        instances: scene.instances.clone(),
        reflectance: scene.reflectance,
        surfaces: scene.surfaces.iter().map(plain).collect(),
        units: scene.units,
        ..Scene::default()
    }
}

/// A light whose image is replaced by its colour.
fn without_image(mut light: Light) -> Light {
    if let LightShape::Dome { texture, .. } | LightShape::Rect { texture, .. } = &mut light.shape {
        *texture = None;
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::request::Command;
    use std::path::Path;
    use std::time::Instant;
    use vellus_open::Options;

    /// The file has the lights as they are, with the exposure that `vellus render` would give them.
    #[test]
    fn a_saved_scene_has_everything_as_it_is_shown() {
        let folder = tempfile::tempdir().unwrap();
        let mut session = Session::open(Path::new("hair"), true).unwrap();
        session.metered = 1.0;
        session.apply(Command::Azimuth { degrees: 180.0 }, Instant::now()).unwrap();
        session.apply(Command::Light { light: 0, gain: 3.0, shift: [0.0; 3] }, Instant::now()).unwrap();
        let path = folder.path().join("scene.usdc");
        let bytes = crate::save::usd(&session.scene(), vellus_usd::Format::Crate, || false).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let read = vellus_open::open(&path, &Options { instances: true, ..Options::default() }).unwrap().scene;
        let (shown, file) = (session.scene(), &read);
        assert_eq!((file.meshes.len(), file.lights.len()), (shown.meshes.len(), shown.lights.len()));
        assert!(!file.meshes.is_empty() && !file.lights.is_empty());
        assert_eq!(file.strands[0].points, shown.strands[0].points);
        assert!(file.camera.is_some() && file.units == shown.units);
        let emission = |light: &Light| match &light.shape {
            LightShape::Dome { radiance, .. } | LightShape::Rect { radiance, .. } => radiance[0],
            LightShape::Distant { irradiance, .. } => irradiance[0],
            other => panic!("{other:?}"),
        };
        let (before, after) = (emission(&session.lights[0].1), emission(&file.lights[0]));
        // The writer divides by areas and the reader multiplies.
        assert!((after / before - 6.0).abs() < 1e-5, "{before} {after}");
    }
}
