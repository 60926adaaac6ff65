//! The experiments there are.

use super::{
    Context, Outcome, energy, medulla_tables, queries, render_animals, render_closeup, render_convergence, render_hair,
    render_indices, render_lobes, render_zoom, scenes, segments, species,
};
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
    Experiment { name: "closeup", figure: "Fig. 5", title: "Near against far field close up", run: render_closeup::run },
    Experiment { name: "indices", figure: "Fig. 6", title: "One index of refraction against two", run: render_indices::run },
    Experiment { name: "lobes", figure: "Fig. 8", title: "The lock of hair lobe by lobe", run: render_lobes::run },
    Experiment { name: "zoom", figure: "Fig. 12, 13", title: "Near, far and multi-scale from afar and close up", run: render_zoom::run },
    Experiment { name: "convergence", figure: "Fig. 15", title: "Convergence and frame times", run: render_convergence::run },
    Experiment { name: "hair", figure: "Fig. 18", title: "Hair with and without a medulla", run: render_hair::run },
    Experiment { name: "raccoon", figure: "Fig. 1", title: "Raccoon: equal samples, time and quality", run: render_animals::raccoon },
    Experiment { name: "hamster", figure: "Fig. 16", title: "Hamster: equal samples, time and quality", run: render_animals::hamster },
    Experiment { name: "cat", figure: "Fig. 17", title: "Cat: equal samples, time and quality", run: render_animals::cat },
];
