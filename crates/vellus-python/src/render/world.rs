//! A scene, prepared for rays.

use super::scene::State;
use crate::error::value;
use pyo3::prelude::*;
use vellus_render::{Lod, Settings, World, prepare};

/// What a preparation depends on, besides the scene: the size of the picture, the mode and the level of detail.
pub type Setup = ([usize; 2], &'static str, Lod);

/// A scene, prepared for rays.
pub struct Prepared {
    pub world: World,
    /// Stops by which its lights are brighter, if the picture decides that.
    pub stops: Option<f32>,
}

/// The names of the groups of all lights.
pub fn group_names(state: &State) -> Vec<String> {
    let scene = vellus_scene::Scene { lights: state.scene.lights.clone(), ..vellus_scene::Scene::default() };
    let names = scene.light_group_names().into_iter().zip(&state.groups);
    names.map(|(name, group)| group.clone().unwrap_or(name)).collect()
}

/// Prepares the scene. This takes seconds for large scenes.
///
/// # Errors
/// `ValueError` for an invalid scene.
pub fn new(state: &State, settings: &Settings, lod: Lod) -> PyResult<Prepared> {
    let mut scene = state.scene.clone();
    if state.groups.iter().any(Option::is_some) {
        scene.light_groups = group_names(state);
    }
    prepare(&mut scene, settings.size, 0.0, lod);
    let mut world = World::new(scene).map_err(value)?;
    let stops = if state.is_metered { world.metered() } else { None };
    if let Some(stops) = stops {
        world.scale_lights(stops.exp2());
    }
    Ok(Prepared { world, stops })
}
