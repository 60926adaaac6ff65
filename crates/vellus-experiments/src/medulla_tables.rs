//! Yan17 Fig. 10, and the claim of 150 KB: the accuracy and the size of the medulla's tables.

use crate::context::Context;
use crate::{Claim, Outcome, Table, Verdict};
use anyhow::Result;
use vellus::parts::{ENTRIES, ExitData, SHIPPED_EXITS};
use vellus::{TableData, Tables};
use vellus_plot::medulla;
use vellus_reference::simulate::check::{ProfileError, TableKind, check_azimuthal, check_longitudinal, summary};

/// The paper's grid: σ_ms, g, h or θ, directions; and its rank.
const GRID: [usize; 4] = [24, 16, 16, 720];
const RANK: usize = 16;

/// The bound of the tables' mean L1 error.
const BOUND: f64 = 0.03;

const SEED: u64 = 7;

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let mut outcome = Outcome::new(
        "Tensor decomposition of rank 16 compresses the simulated profiles C^M and C^N from more than 600 MB to 150 \
         KB. The compressed profiles match well over a wide range of parameters.",
    );
    let photons = context.quality.pick(4_000, 400_000, 8_000_000);
    let data = TableData::from_bytes(Tables::SHIPPED)?;
    let picture = medulla::Picture::new(&data, Tables::SHIPPED.len(), photons, context.progress());
    let caption = "Light scattered by the medulla, simulated (grey) and from the tables (coloured): around the fibre \
                   (C^N, above) and along it (C^M, below), for a thin, a medium and a thick medulla, between the \
                   nodes of the tables.";
    outcome.pictures.push(context.draw(&picture, "profiles", caption)?);

    let mut sizes = Table::new("sizes", "The tables", &["table", "rank", "τ", "g", "h or θ", "angles", "bytes"]);
    let named = [("C^N", &data.azimuthal), ("C^M backward", &data.backward), ("C^M forward", &data.forward)];
    for (name, table) in named {
        let bytes = 2 * table.factors.iter().map(Vec::len).sum::<usize>();
        let nodes = table.factors.iter().map(|f| f.len() / table.rank);
        table_row(&mut sizes, name, [table.rank].into_iter().chain(nodes).chain([bytes]));
    }
    let [tau, g, h] = data.mean_path_nodes;
    let path =
        ["mean path ⟨L⟩".to_owned(), "–".to_owned(), tau.to_string(), g.to_string(), h.to_string(), "–".to_owned()];
    sizes.row(path.into_iter().chain([(2 * data.mean_path.len()).to_string()]));
    let exits = ExitData::from_bytes(SHIPPED_EXITS)?;
    let [tau, g] = exits.nodes.map(|n| n.to_string());
    let none = || "–".to_owned();
    let bytes = SHIPPED_EXITS.len().to_string();
    sizes.row(["first exits".to_owned(), none(), tau, g, ENTRIES.to_string(), none(), bytes]);
    outcome.tables.push(sizes);
    outcome.claims.extend(size_claims());

    let (profiles, photons) = context.quality.pick((2, 32_000), (10, 2_500_000), (40, 32_000_000));
    let mut errors: Vec<ProfileError> = Vec::new();
    let stage = context.stage(2 * profiles, "simulating");
    for index in 0..profiles {
        context.check_interrupted()?;
        errors.push(check_azimuthal(&data, photons, SEED, index));
        stage.advance(1);
        context.check_interrupted()?;
        errors.extend(check_longitudinal(&data, photons, SEED, index));
        stage.advance(1);
    }
    let caption = format!(
        "L1 error against {profiles} simulations each at random parameters between the nodes, % of the profile"
    );
    let mut table = Table::new(
        "errors",
        caption,
        &["table", "mean", "95th percentile", "worst", "noise of the simulation", "mean without noise"],
    );
    let mut worst = 0.0f64;
    for kind in TableKind::ALL {
        let of = |f: fn(&ProfileError) -> f64| summary(errors.iter().filter(|e| e.kind == kind).map(f).collect());
        let (l1, noise) = (of(|e| e.l1), of(|e| e.noise));
        // The two errors are independent.
        let without = (l1.mean * l1.mean - noise.mean * noise.mean).max(0.0).sqrt();
        worst = worst.max(without);
        let cells = [l1.mean, l1.p95, l1.max, noise.mean, without].map(|x| format!("{:.2}", 100.0 * x));
        table.row([kind.name().to_owned()].into_iter().chain(cells));
    }
    outcome.tables.push(table);
    let measured = format!("L1 error {:.1} %", 100.0 * worst);
    let claim = Claim::new("Compressed profiles match simulated ones", measured, worst, Verdict::of(worst <= BOUND))
        .paper("good matches")
        .ours("bound: L1 error 3 % on average")
        .because("The mean over random parameters, without the noise of the simulation, in the worst of three tables.");
    outcome.claims.push(claim);
    let path = summary(errors.iter().filter_map(|e| e.mean_path).map(f64::abs).collect());
    let what = "The table has the mean path ⟨L⟩ of scattered light (D7)";
    let why = "The paper uses a fixed path κ instead.";
    let claim = Claim::not_judged(what, format!("error {:.2} % on average", 100.0 * path.mean), why);
    outcome.claims.push(claim.more(format!("{:.2} % at worst", 100.0 * path.max)));
    let negative = named.iter().flat_map(|(_, t)| t.factors.iter().flatten()).filter(|x| **x < 0.0).count();
    outcome.claims.push(
        Claim::new(
            "No density in the tables is negative",
            format!("{negative} negative numbers"),
            negative as f64,
            Verdict::of(negative == 0),
        )
        .ours("none, where CP-ALS allows them")
        .because("All factors are non-negative (D13), so sampling is exact. C^N needs rank 40 instead of 16."),
    );
    let raw = 4.0 * GRID.iter().product::<usize>() as f64;
    let three = 3 * 4 * RANK * GRID.iter().sum::<usize>();
    outcome.notes.push(format!(
        "The paper's grid, {} × {} × {} × {}, takes {:.0} MB per table in single precision: the 600 MB must be of \
         finer tables. Three tables of rank {RANK} on it (C^N, and C^M in two halves) take {:.0} KB in single \
         precision, which may be the 150 KB.",
        GRID[0],
        GRID[1],
        GRID[2],
        GRID[3],
        1e-6 * raw,
        1e-3 * three as f64
    ));
    Ok(outcome)
}

/// The sizes of the tables, for the paper's model and for the default, which also needs the first exits.
fn size_claims() -> [Claim; 2] {
    let claim = |what: &str, bytes: usize| {
        let kilobytes = bytes as f64 / 1000.0;
        let verdict = Verdict::at_most(kilobytes, 150.0);
        Claim::new(what, format!("{kilobytes:.1} KB"), kilobytes, verdict).paper("150 KB")
    };
    let [medulla, exits] = [Tables::SHIPPED, SHIPPED_EXITS].map(<[u8]>::len);
    [
        claim("The tables of the medulla are small", medulla).more("All that the paper's model needs, in half floats."),
        claim("The tables of the default are small", medulla + exits)
            .more("With the table of first exits (D17), which the paper lacks."),
    ]
}

fn table_row(table: &mut Table, name: &str, numbers: impl Iterator<Item = usize>) {
    table.row(std::iter::once(name.to_owned()).chain(numbers.map(|n| n.to_string())));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of first exits counts for the default.
    #[test]
    fn all_tables_fit_into_the_150_kilobytes_of_the_paper() {
        let [paper, default] = size_claims();
        assert_eq!((paper.measured.as_str(), paper.verdict), ("118.6 KB", Verdict::Better));
        assert_eq!((default.measured.as_str(), default.verdict), ("145.0 KB", Verdict::Holds));
    }
}
