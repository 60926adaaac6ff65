//! The list of experiments.

use crate::context::Context;
use crate::{
    Outcome, animals, closeup, convergence, energy, exit, hair, indices, lobes, medulla_tables, queries, scenes,
    segments, species, zoom,
};
use anyhow::{Result, bail};

/// An experiment.
pub struct Experiment {
    /// Its name on the command line; also the name of its folder.
    pub name: &'static str,
    /// The figure or table of the paper.
    pub figure: &'static str,
    /// What it shows.
    pub title: &'static str,
    pub(crate) run: fn(&Context<'_>) -> Result<Outcome>,
}

const fn experiment(
    name: &'static str,
    figure: &'static str,
    title: &'static str,
    run: fn(&Context<'_>) -> Result<Outcome>,
) -> Experiment {
    Experiment { name, figure, title, run }
}

/// All experiments, in the order of the report.
pub const EXPERIMENTS: &[Experiment] = &[
    experiment("medulla-tables", "Fig. 10", "Medulla profiles, simulated and compressed", medulla_tables::run),
    experiment("species", "Fig. 11, Table 4", "Profiles of the ten species", species::run),
    experiment("segment-error", "Sec. 5.1, Appendix", "Segments of the far field and their error", segments::run),
    experiment("energy", "Table 3, Sec. 4", "Energy of the lobes: models against the whole fibre", energy::run),
    experiment("exit", "Sec. 4.3", "Where scattered light leaves: the model against the whole fibre", exit::run),
    experiment("queries", "Sec. 7", "Time of a query, beside 2015 optimised and as published", queries::run),
    experiment("scenes", "Table 5", "Scenes: strands, segments, memory", scenes::run),
    experiment("closeup", "Fig. 5", "Near field against far field close up", closeup::run),
    experiment("indices", "Fig. 6", "One index of refraction against two", indices::run),
    experiment("lobes", "Fig. 8", "The lobes of the lock of hair", lobes::run),
    experiment("zoom", "Fig. 12, 13", "Near, far and multi-scale from afar and close up", zoom::run),
    experiment("convergence", "Fig. 15", "Convergence and frame times", convergence::run),
    experiment("hair", "Fig. 18", "Hair with and without a medulla", hair::run),
    experiment("raccoon", "Fig. 1", "Raccoon: equal samples, time and quality", animals::raccoon),
    experiment("hamster", "Fig. 16", "Hamster: equal samples, time and quality", animals::hamster),
    experiment("cat", "Fig. 17", "Cat: equal samples, time and quality", animals::cat),
];

/// The experiments with these names, in the order of [`EXPERIMENTS`]. The name `all` means all of them.
///
/// # Errors
/// If there is no experiment with one of the names.
pub fn find(names: &[String]) -> Result<Vec<&'static Experiment>> {
    for name in names {
        if name != "all" && !EXPERIMENTS.iter().any(|e| e.name == name) {
            let known: Vec<_> = EXPERIMENTS.iter().map(|e| e.name).collect();
            bail!("there is no experiment '{name}' (known: {}, all)", known.join(", "));
        }
    }
    let chosen = |e: &&Experiment| names.iter().any(|name| name == "all" || name == e.name);
    Ok(EXPERIMENTS.iter().filter(chosen).collect())
}

/// All experiments as a table: name, figure and title.
pub fn listing() -> String {
    let width = |of: fn(&Experiment) -> &str| EXPERIMENTS.iter().map(|e| of(e).chars().count()).max().unwrap_or(0);
    let (first, second) = (width(|e| e.name), width(|e| e.figure));
    EXPERIMENTS.iter().map(|e| format!("  {:first$}  {:second$}  {}\n", e.name, e.figure, e.title)).collect()
}
