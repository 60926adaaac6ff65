//! Scenes and pictures.

mod arrays;
mod lights;
mod picture;
mod run;
mod scene;
pub mod values;
mod world;

use pyo3::prelude::*;

/// Adds the classes of this module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<scene::Scene>()?;
    module.add_class::<picture::Picture>()?;
    module.add_class::<run::State>()
}
