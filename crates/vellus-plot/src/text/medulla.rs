//! Tables of the medulla: their sizes and their errors.

use super::{align, header};
use vellus::TableData;
use vellus_reference::simulate::check::{ProfileError, TableKind, summary};

/// Ranks, nodes and bytes of each table.
pub fn table_info(data: &TableData) -> String {
    let mut rows = vec![header(["table", "rank", "τ", "g", "h or θ", "angles", "bytes"])];
    for (name, table) in
        [("C^N azimuthal", &data.azimuthal), ("C^M backward", &data.backward), ("C^M forward", &data.forward)]
    {
        let mut row = vec![name.to_owned(), table.rank.to_string()];
        row.extend(table.factors.iter().map(|f| (f.len() / table.rank).to_string()));
        row.push((2 * table.factors.iter().map(Vec::len).sum::<usize>()).to_string());
        rows.push(row);
    }
    let [tau, g, h] = data.mean_path_nodes.map(|n| n.to_string());
    let bytes = (2 * data.mean_path.len()).to_string();
    rows.push(vec!["⟨L⟩ mean path".to_owned(), String::new(), tau, g, h, String::new(), bytes]);
    align(&rows)
}

/// The error of every profile.
pub fn profile_errors(errors: &[ProfileError]) -> String {
    let mut rows = vec![header(["", "τ", "g", "h or θ°", "L1 %", "noise %"])];
    for e in errors {
        let [tau, g, last] = e.parameters;
        let last = if e.kind == TableKind::Azimuthal { last } else { last.to_degrees() };
        let values = [tau, g, last, 100.0 * e.l1, 100.0 * e.noise];
        rows.push(cells(e.kind.name(), values.map(|x| format!("{x:.3}"))));
    }
    align(&rows)
}

/// Mean, 95th percentile and maximum of the errors of each table.
pub fn table_errors(errors: &[ProfileError]) -> String {
    let mut rows = vec![header(["L1 error, % of the profile", "mean", "95th", "max", "simulation's noise"])];
    let percent = |x: f64| format!("{:.2}", 100.0 * x);
    for kind in TableKind::ALL {
        let of = |f: fn(&ProfileError) -> f64| summary(errors.iter().filter(|e| e.kind == kind).map(f).collect());
        let (l1, noise) = (of(|e| e.l1), of(|e| e.noise));
        rows.push(cells(kind.name(), [l1.mean, l1.p95, l1.max, noise.mean].map(percent)));
    }
    let path = summary(errors.iter().filter_map(|e| e.mean_path).map(f64::abs).collect());
    rows.push(cells("⟨L⟩, relative error %", [path.mean, path.p95, path.max].map(percent)));
    align(&rows)
}

fn cells<const N: usize>(name: &str, values: [String; N]) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(values).collect()
}
