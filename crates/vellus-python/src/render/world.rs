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

/// Prepares the scene. This takes seconds for large scenes.
///
/// # Errors
/// `ValueError` for an invalid scene.
pub fn new(state: &State, settings: &Settings, lod: Lod) -> PyResult<Prepared> {
    let mut scene = state.scene.clone();
    prepare(&mut scene, settings.size, 0.0, lod);
    let mut world = World::new(scene).map_err(value)?;
    let stops = if state.is_metered { world.metered() } else { None };
    if let Some(stops) = stops {
        world.scale_lights(stops.exp2());
    }
    Ok(Prepared { world, stops })
}
