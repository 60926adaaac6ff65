//! Yan17 Table 4 against the presets.

use crate::{Claim, Outcome, Table, Verdict};
use anyhow::{Context, Result};
use vellus::{Fiber, Species};

/// Table 4 as printed, bobcat to human: κ, η, α, β_m, β_n, σ_c,a, σ_m,s, σ_m,a, g, l.
const PRINTED: [(&str, [&str; 10]); 10] = [
    ("κ", ["0.88", "0.87", "0.91", "0.68", "0.66", "0.79", "0.65", "0.86", "0.82", "0.36"]),
    ("η", ["1.69", "1.36", "1.60", "1.58", "1.35", "1.47", "1.19", "1.49", "1.48", "1.20"]),
    ("α", ["5.48", "3.65", "3.52", "2.94", "0.55", "3.14", "1.81", "2.64", "4.61", "0.70"]),
    ("β_m", ["11.64", "5.66", "7.00", "5.77", "8.39", "11.91", "7.44", "9.45", "8.02", "2.05"]),
    ("β_n", ["7.49", "1.34", "4.53", "18.94", "2.80", "10.52", "6.88", "17.63", "11.46", "3.75"]),
    ("σ_c,a", ["0.64", "0.06", "1.39", "0.01", "0.04", "0.24", "0.25", "0.39", "0.32", "0.41"]),
    ("σ_m,s", ["1.69", "2.47", "2.51", "2.44", "1.34", "0.78", "2.30", "3.15", "2.45", "3.49"]),
    ("σ_m,a", ["0.17", "0.12", "0.09", "0.00", "0.06", "0.10", "0.14", "0.21", "0.31", "0.00"]),
    ("g", ["0.44", "0.60", "0.46", "0.26", "0.36", "0.12", "0.08", "0.79", "0.19", "0.28"]),
    ("l", ["0.47", "0.44", "0.45", "0.60", "2.36", "1.03", "2.00", "0.68", "0.46", "1.79"]),
];

/// Adds a table of the presets, and the claim that they equal the paper's.
pub fn presets(outcome: &mut Outcome) -> Result<()> {
    let header: Vec<&str> = std::iter::once("parameter").chain(Species::ALL.iter().map(|s| s.name())).collect();
    let mut table = Table::new("presets", "The presets; angles in degrees (Table 4)", &header);
    let mut off = Vec::new();
    for (k, (parameter, printed)) in PRINTED.iter().enumerate() {
        let mut cells = vec![(*parameter).to_owned()];
        for (species, printed) in Species::ALL.into_iter().zip(printed) {
            let f = Fiber::published(species);
            let degrees = [f.alpha, f.beta_m, f.beta_n].map(f32::to_degrees);
            let all = [
                f.kappa,
                f.eta,
                degrees[0],
                degrees[1],
                degrees[2],
                f.sigma_ca[0],
                f.sigma_ms,
                f.sigma_ma[0],
                f.g,
                f.layers,
            ];
            let value = format!("{:.2}", all[k]);
            let number: f32 = printed.parse().with_context(|| format!("'{printed}'"))?;
            if (all[k] - number).abs() > 1e-5 * number.max(1.0) {
                off.push(format!("{parameter} of {species}"));
            }
            cells.push(value);
        }
        table.row(cells);
    }
    outcome.tables.push(table);
    let (what, measured) = ("The published presets have the numbers of Table 4", format!("{} differ", off.len()));
    let claim = Claim::new(what, measured, off.len() as f64, Verdict::of(off.is_empty()))
        .paper("100 numbers")
        .more(off.join(", "))
        .because("σ is per fibre radius: the caption's unit circle, not the printed diameter⁻¹ (D1).");
    outcome.claims.push(claim);
    Ok(())
}
