//! A fit: descents from many starts, the best minimum, and its statistics.

use crate::cost::Cost;
use crate::error::Error;
use crate::forward::Forward;
use crate::least_squares::{Difference, Minimum, Problem};
use crate::options::Options;
use crate::outcome::{Combination, Correlations, Estimate, Fit, Rival, Starts, State};
use crate::parameters::{Kind, assemble};
use crate::profile::Profile;
use crate::space::{Source, Space};
use crate::starts::starts;
use crate::statistics::{Place, Statistics, statistics};
use crate::verdict::{explained, judge};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use std::sync::atomic::Ordering;
use vellus::Parameter;
use vellus_io::{Progress, Steps};
use vellus_reference::simulate::medulla::SimRng;

/// The number of points of the profile that the first descents use.
const SAMPLE: usize = 600;

/// The largest number of distinct minima that are refined on all points.
const FOLLOWED: usize = 6;

/// Two values of a variable count as equal if they differ by less than this share of its usual range.
const SAME: f64 = 0.02;

/// The smallest roughness that is fitted, as a share of the sampling step. The samples do not resolve smaller ones.
const UNRESOLVED: f64 = 0.25;

/// The median distance of adjacent values of a sorted axis.
fn spacing(axis: &[f64]) -> f64 {
    let mut steps: Vec<f64> = axis.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

/// Fits a model to a profile. `progress` gets a report after each descent. A cancelled fit returns the best result so
/// far, and [`Fit::interrupted`] is true.
///
/// # Errors
/// [`Error::Profile`] for a profile that has too few points or does not vary, [`Error::Parameter`] for a bad request.
pub fn fit(profile: &Profile, forward: Forward, options: &Options, progress: &dyn Progress) -> Result<Fit, Error> {
    profile.validate()?;
    profile.check_varies()?;
    if options.starts == 0 {
        return Err(Error::Parameter("starts = 0 is out of range: it must be at least 1".to_owned()));
    }
    let space = Space::new(forward, profile.channels, profile.theta_o, &options.requests)?;
    let mut space = match options.exit {
        Some(exit) => space.with_exit(exit)?,
        None => space,
    };
    for (roughness, axis) in
        [(Parameter::BetaM, profile.axis(|p| p.theta)), (Parameter::BetaN, profile.axis(|p| p.phi))]
    {
        space.resolve(Kind::Fiber(roughness, 0), UNRESOLVED * spacing(&axis));
    }
    let mut order: Vec<usize> = (0..profile.points.len()).collect();
    let all = Cost::new(profile, &order, &space, forward);
    order.shuffle(&mut SimRng::seed_from_u64(options.seed));
    order.truncate(SAMPLE);
    let part = Cost::new(profile, &order, &space, forward);

    let steps: Vec<f64> = space.leads.iter().map(|&lead| space.parameters[lead].step).collect();
    let (on_part, on_all) = (|u: &[f64]| part.residuals(u), |u: &[f64]| all.residuals(u));
    let problem =
        |residuals| Problem { bounds: &space.bounds, steps: &steps, residuals, huber: options.huber, progress };
    let (rough, fine) = (problem(&on_part), problem(&on_all));

    let begun = starts(&space, &part, profile.theta_o, options, progress);
    // The last step stands for the work after the descents.
    let steps = Steps::new(progress, begun.len() as u64 + 1, "fitting");
    let mut minima: Vec<Minimum> = begun
        .par_iter()
        .map(|start| {
            let minimum = rough.minimise(start, Difference::Forward, 60);
            steps.advance(1);
            minimum
        })
        .collect();
    let finished = minima.iter().filter(|m| m.converged).count();
    let ends: Vec<Vec<f64>> = minima.iter().map(|m| m.u.clone()).collect();
    rank(&rough, &mut minima);
    let distinct = distinct(&space, &minima);
    let mut followed: Vec<Minimum> =
        distinct.par_iter().map(|m| fine.minimise(&m.u, Difference::Central, 200)).collect();
    rank(&fine, &mut followed);
    let interrupted = progress.is_cancelled();
    let Some(best) = followed.first() else {
        return Err(Error::Profile("no descent ended".to_owned()));
    };
    // The minimum for a part of the points is within a few standard errors of the minimum for all points.
    let statistics = statistics(&fine, &space, profile, best);
    let reached = ends.iter().filter(|u| similar(&space, &statistics, u, &best.u)).count();
    let rival = followed[1..].iter().find(|m| !similar(&space, &statistics, &m.u, &best.u)).map(|m| Rival {
        values: space.values(&m.u),
        chi2: 2.0 * (fine.loss(&m.residuals, best.noise) - fine.loss(&best.residuals, best.noise)),
    });
    steps.advance(1);
    Ok(describe(
        profile,
        &space,
        &fine,
        best,
        &statistics,
        Outside {
            starts: Starts { begun: begun.len(), finished, ended_here: reached },
            rival,
            evaluations: part.evaluations.load(Ordering::Relaxed) + all.evaluations.load(Ordering::Relaxed),
            interrupted,
        },
    ))
}

/// Sorts minima by their loss. All losses use the smallest noise of any minimum.
fn rank(problem: &Problem, minima: &mut [Minimum]) {
    let noise = minima.iter().map(|m| m.noise).fold(f64::INFINITY, f64::min);
    let key = |m: &Minimum| problem.loss(&m.residuals, noise);
    minima.sort_by(|a, b| key(a).total_cmp(&key(b)));
}

/// The best minima that differ from each other. At most [`FOLLOWED`].
fn distinct<'m>(space: &Space, minima: &'m [Minimum]) -> Vec<&'m Minimum> {
    let mut kept: Vec<&Minimum> = Vec::new();
    for m in minima {
        let same = |k: &&Minimum| {
            (0..m.u.len()).all(|j| {
                let [low, high] = space.usual(j);
                (m.u[j] - k.u[j]).abs() <= SAME * (high - low).max(1e-3)
            })
        };
        if kept.len() < FOLLOWED && !kept.iter().any(same) {
            kept.push(m);
        }
    }
    kept
}

/// Whether two minima are the same within the precision of the data, or within a small share of the usual ranges.
fn similar(space: &Space, statistics: &Statistics, a: &[f64], b: &[f64]) -> bool {
    (0..a.len()).all(|j| {
        let [low, high] = space.usual(j);
        // A minimum for only a part of the points has larger errors.
        let error = 10.0 * statistics.covariance[(j, j)].sqrt();
        (a[j] - b[j]).abs() <= error.max(3.0 * SAME * (high - low))
    })
}

/// Results of the search that do not describe the best minimum itself.
struct Outside {
    starts: Starts,
    rival: Option<Rival>,
    evaluations: u64,
    interrupted: bool,
}

fn describe(
    profile: &Profile,
    space: &Space,
    problem: &Problem,
    best: &Minimum,
    statistics: &Statistics,
    outside: Outside,
) -> Fit {
    let values = space.values(&best.u);
    let (specimen, theta_o, scale) = assemble(space.exit, &space.parameters, &values);
    let name = |column: usize| space.lead(column).name.clone();
    let estimate = |i: usize| {
        let p = &space.parameters[i];
        let (error, state, determined) = match space.sources[i] {
            Source::Fixed(_) => (None, State::Fixed, true),
            Source::Free(column) => {
                let lead = space.leads[column];
                let inside = statistics.places[column] == Place::Inside;
                let slope = space.parameters[lead].curve.slope(values[lead]);
                let error = statistics.errors[column].map(|error| error * slope);
                let state = match (lead == i, inside) {
                    (false, _) => State::Tied(name(column)),
                    (true, true) => State::Fitted,
                    (true, false) => State::AtBound,
                };
                (error, state, statistics.determined[column])
            }
        };
        Estimate { name: p.name.clone(), unit: p.unit, value: values[i], error, state, determined }
    };
    let columns = space.leads.len();
    let c = &statistics.covariance;
    let correlation = |i: usize, j: usize| {
        let norm = (c[(i, i)] * c[(j, j)]).sqrt();
        if i == j {
            1.0
        } else if norm > 0.0 {
            c[(i, j)] / norm
        } else {
            0.0
        }
    };
    let ratio = |i: usize, c: usize| best.residuals[i * profile.channels + c].exp();
    let fitted: Vec<[f64; 3]> = profile
        .points
        .iter()
        .enumerate()
        .map(|(i, p)| std::array::from_fn(|c| if c < profile.channels { p.value[c] * ratio(i, c) } else { 0.0 }))
        .collect();
    let (nrmse, log_nrmse) = errors(profile, &fitted);
    let explained = explained(problem, profile, &best.residuals, best.noise, columns);
    let of_fiber = |column: &usize| !matches!(space.lead(*column).kind, Kind::Scale | Kind::ThetaO);
    let known: Vec<bool> = (0..columns).filter(of_fiber).map(|column| statistics.visible[column]).collect();
    let no_fit = judge(&explained, statistics.widened, &known);
    Fit {
        model: space.model.kind(),
        specimen,
        theta_o,
        scale,
        estimates: (0..space.parameters.len()).map(estimate).collect(),
        correlations: Correlations {
            names: (0..columns).map(name).collect(),
            matrix: (0..columns).map(|i| (0..columns).map(|j| correlation(i, j)).collect()).collect(),
        },
        weakest: Combination {
            shares: statistics.weakest.iter().map(|&(j, x)| (name(j), x)).collect(),
            standard_error: statistics.weakest_error,
        },
        fitted,
        nrmse,
        log_nrmse,
        explained,
        no_fit,
        noise: best.noise,
        outliers: best.residuals.iter().filter(|&&r| problem.weight(r, best.noise) < 1.0).count(),
        neighbours: statistics.neighbours,
        widened: statistics.widened,
        starts: outside.starts,
        rival: outside.rival,
        evaluations: outside.evaluations,
        interrupted: outside.interrupted,
    }
}

/// The RMS error of fitted values, divided by the range of the measured values (Yan17 footnote 3), and the same for
/// their logarithms. `fitted` has one RGB value for each point of the profile.
pub fn errors(profile: &Profile, fitted: &[[f64; 3]]) -> (f64, f64) {
    let (mut squares, mut log_squares) = (0.0, 0.0);
    for (p, f) in profile.points.iter().zip(fitted) {
        for c in 0..profile.channels {
            squares += (f[c] - p.value[c]).powi(2);
            log_squares += (f[c] / p.value[c]).ln().powi(2);
        }
    }
    let count = (profile.points.len() * profile.channels) as f64;
    let [low, high] = profile.range();
    ((squares / count).sqrt() / (high - low), (log_squares / count).sqrt() / (high / low).ln())
}
