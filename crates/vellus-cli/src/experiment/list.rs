//! The experiments there are.

use super::{Context, Outcome, energy, medulla_tables, queries, render_animals, scenes, segments, species};
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
    Experiment { name: "medulla-tables", figure: "Fig. 10", title: "The medulla's profiles, simulated and compressed", run: medulla_tables::run },
    Experiment { name: "species", figure: "Fig. 11, Table 4", title: "Profiles of the ten species", run: species::run },
    Experiment { name: "segment-error", figure: "Sec. 5.1, Appendix", title: "Segments of the far field and their error", run: segments::run },
    Experiment { name: "energy", figure: "Table 3, Sec. 4", title: "Where the light goes: models beside the whole fibre", run: energy::run },
    Experiment { name: "queries", figure: "Sec. 7", title: "What a query costs, and how the baseline of 2015 was optimised", run: queries::run },
    Experiment { name: "scenes", figure: "Table 5", title: "Scenes: strands, segments, memory", run: scenes::run },
    Experiment { name: "raccoon", figure: "Fig. 1", title: "Raccoon: equal samples, time and quality", run: render_animals::raccoon },
    Experiment { name: "hamster", figure: "Fig. 16", title: "Hamster: equal samples, time and quality", run: render_animals::hamster },
    Experiment { name: "cat", figure: "Fig. 17", title: "Cat: equal samples, time and quality", run: render_animals::cat },
];
