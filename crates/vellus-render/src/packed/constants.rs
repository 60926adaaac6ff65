//! What a tracer in another language shares with this one: numbers of rows, kinds and layers, and of its decisions.

use super::lights::{Kind, ROWS};
use super::{HEADER_ROWS, NONE, SURFACE_ROWS};
use crate::film::Layer;
use crate::integrator::at_fiber::{BESIDE, FIRST_LIGHTS, SHADOW_RAY_THRESHOLD};
use crate::integrator::path::{BEFORE, ROULETTE, SURVIVAL};
use crate::integrator::settings::Mode;
use crate::integrator::window::{CELL, FAINT};

/// Names and values. They are whole numbers with the suffix `u`, or numbers with a point, as WGSL and most languages
/// read them.
pub fn constants() -> Vec<(String, String)> {
    let whole = |name: &str, x: u32| (name.to_owned(), format!("{x}u"));
    let real = |name: &str, x: f32| (name.to_owned(), format!("{x:?}"));
    let header = HEADER_ROWS.iter().zip(0..).map(|(name, row)| whole(name, row));
    let layers =
        Layer::ALL.iter().map(|layer| whole(&format!("LAYER_{}", upper(&format!("{layer:?}"))), *layer as u32));
    let kinds = Kind::ALL.iter().map(|kind| whole(&upper(&format!("{kind:?}")), *kind as u32));
    let [first, later] = SHADOW_RAY_THRESHOLD;
    header
        .chain(layers)
        .chain(kinds)
        .chain(Mode::ALL.map(|mode| whole(&upper(&format!("{mode:?}")), mode as u32)))
        .chain([
            whole("NONE", NONE),
            whole("LAYERS", HEADER_ROWS.len() as u32),
            whole("ROWS_OF_LIGHT", ROWS),
            whole("ROWS_OF_SURFACE", SURFACE_ROWS as u32),
            whole("ROULETTE", ROULETTE),
            real("SURVIVAL", SURVIVAL),
            real("THRESHOLD_FIRST", first),
            real("THRESHOLD_LATER", later),
            whole("FIRST_LIGHTS", FIRST_LIGHTS),
            real("FAINT", FAINT),
            real("CELL", CELL),
            real("BESIDE", BESIDE),
            real("BEFORE", BEFORE),
        ])
        .collect()
}

/// `RootUv` as `ROOT_UV`.
fn upper(name: &str) -> String {
    let word = |(i, c): (usize, char)| {
        let gap = if c.is_uppercase() && i > 0 { "_" } else { "" };
        format!("{gap}{}", c.to_ascii_uppercase())
    };
    name.chars().enumerate().map(word).collect()
}
