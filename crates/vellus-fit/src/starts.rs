//! The starts of descents: the presets, and the best points of a space-filling design.

use crate::cost::Cost;
use crate::least_squares::noise;
use crate::options::Options;
use crate::parameters::{Kind, values_of};
use crate::space::Space;
use rayon::prelude::*;
use vellus::{Exit, Fiber, Species};
use vellus_io::Progress;

/// How many points of the design are tried for each point that is kept.
const TRIED: usize = 16;

/// The length of a scrambled sequence.
const MOST: usize = 1 << 16;

/// The variables of `options.starts` starts. If the fit is cancelled, only the presets. The scale of each start makes
/// its median log-ratio 0.
pub fn starts(space: &Space, cost: &Cost, theta_o: f64, options: &Options, progress: &dyn Progress) -> Vec<Vec<f64>> {
    let (count, seed) = (options.starts, options.seed);
    let scale = space.column_of(Kind::Scale);
    let scaled = |mut u: Vec<f64>| -> (f64, Vec<f64>) {
        let mut residuals = cost.residuals(&u);
        let middle = residuals.len() / 2;
        let median = *residuals.select_nth_unstable_by(middle, f64::total_cmp).1;
        match scale {
            Some(column) => {
                u[column] -= median;
                residuals.iter_mut().for_each(|r| *r -= median);
            }
            None => residuals.retain(|r| r.is_finite()),
        }
        (noise(&residuals), u)
    };
    let base = match space.exit {
        Exit::Open => Fiber::published,
        Exit::Reflecting => Fiber::preset,
    };
    let preset = |fiber: &Fiber| space.variables(&values_of(&space.parameters, fiber, theta_o, 1.0));
    let mut presets: Vec<(f64, Vec<f64>)> =
        Species::ALL.par_iter().map(|&species| scaled(preset(&base(species)))).collect();
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
