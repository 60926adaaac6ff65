//! The experiments there are.

use super::{Context, Outcome, scenes};
use anyhow::Result;

/// One of them.
pub struct Experiment {
    /// On the command line, and of its folder.
    pub name: &'static str,
    /// The paper's figure or table.
    pub figure: &'static str,
    pub title: &'static str,
    pub run: fn(&Context) -> Result<Outcome>,
}

/// All, in the order of the report.
#[rustfmt::skip]
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment { name: "scenes", figure: "Table 5", title: "Scenes: strands, segments, memory", run: scenes::run },
];
