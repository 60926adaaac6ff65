//! The starts of descents: the presets, and the best points of a space-filling design.

use crate::cost::Cost;
use crate::least_squares::noise;
use crate::options::Options;
use crate::parameters::Kind;
use crate::space::Space;
use rayon::prelude::*;
use vellus::{Fiber, ScatterExit, Species};
use vellus_io::Progress;

/// How many points of the design are tried for each point that is kept.
const TRIED: usize = 16;

/// The length of a scrambled sequence.
const MOST: usize = 1 << 16;

/// The variables of `options.starts` starts. If the fit is cancelled, only the presets. The scale of each start makes
/// its median log-ratio 0.
pub fn starts(space: &Space, cost: &Cost, options: &Options, progress: &dyn Progress) -> Vec<Vec<f64>> {
    let (count, seed) = (options.starts, options.seed);
    // The profiles of a joint fit have scales of their own, or share one.
    let scales: Vec<Option<usize>> = (0..space.members.len()).map(|k| space.column_of(k, Kind::Scale)).collect();
    let mut columns: Vec<usize> = scales.iter().copied().flatten().collect();
    columns.dedup();
    let scaled = |mut u: Vec<f64>| -> (f64, Vec<f64>) {
        for &column in &columns {
            let residuals = cost.residuals(&u);
            let of_column = |(k, _): &(usize, &[f64])| scales[*k] == Some(column);
            let parts = cost.parts(&residuals).enumerate().filter(of_column);
            let mut logs: Vec<f64> = parts.flat_map(|(_, part)| part).copied().collect();
            let middle = logs.len() / 2;
            if !logs.is_empty() {
                u[column] -= *logs.select_nth_unstable_by(middle, f64::total_cmp).1;
            }
        }
        let mut residuals = cost.residuals(&u);
        residuals.retain(|r| r.is_finite());
        (noise(&residuals), u)
    };
    let base = match space.exit {
        ScatterExit::Open => Fiber::published,
        ScatterExit::Reflecting => Fiber::preset,
    };
    let mut presets: Vec<(f64, Vec<f64>)> =
        Species::ALL.par_iter().map(|&species| scaled(space.variables(&base(species)))).collect();
    presets.sort_by(|a, b| a.0.total_cmp(&b.0));
    presets.truncate(count);
    let rest = count - presets.len();
    // Owen-scrambled Sobol' points in the usual ranges.
    let design = |i: usize| -> Vec<f64> {
        (0..space.leads.len())
            .map(|column| {
                let [low, high] = space.usual(column);
                low + (high - low) * f64::from(sobol_burley::sample(i as u32, column as u32, seed as u32))
            })
            .collect()
    };
    let mut drawn: Vec<(f64, Vec<f64>)> = (0..(rest * TRIED).min(MOST))
        .into_par_iter()
        .filter_map(|i| (!progress.is_cancelled()).then(|| scaled(design(i))))
        .collect();
    drawn.sort_by(|a, b| a.0.total_cmp(&b.0));
    drawn.truncate(rest);
    presets.into_iter().chain(drawn).map(|(_, u)| u).collect()
}
