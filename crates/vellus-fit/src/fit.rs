//! A fit: descents from many starts, the best minimum, and its statistics.

use crate::aperture::{ROUGH, distance};
use crate::cost::{Cost, weights};
use crate::error::Error;
use crate::forward::Forward;
use crate::intervals::Start;
use crate::least_squares::{Difference, Minimum, Problem};
use crate::options::Options;
use crate::outcome::{Combination, Correlations, Estimate, Fit, Part, Rival, Starts, State};
use crate::parameters::{Kind, Setup};
use crate::profile::{FEWEST, Profile};
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

/// How often the far field is corrected by quadrature at the minimum, and the minimum found again.
const CORRECTIONS: usize = 2;

/// The number of minima that are corrected.
const CORRECTED: usize = 4;

/// How often the fit starts again from a better point that was found while errors were computed.
const RESTARTS: usize = 2;

/// Fits a model to one profile, or to several profiles of the same fibre together. `progress` gets a report after each
/// descent. A cancelled fit returns the best result so far, and [`Fit::interrupted`] is true.
///
/// All profiles have the same noise, apart from their [`Point::sigma`](crate::Point::sigma).
///
/// Profiles with a [`Profile::channel`] are measurements in any number of channels: those of the first measurement,
/// then those of the next one, if any, with the same channels in the same order. Each channel has its own absorption
/// of cortex and medulla. All else is the same in all channels of a measurement, also the scale.
///
/// # Errors
/// [`Error::Profile`] for a profile that has too few points or does not vary, [`Error::Parameter`] for a bad request.
pub fn fit(profiles: &[Profile], forward: Forward, options: &Options, progress: &dyn Progress) -> Result<Fit, Error> {
    for profile in profiles {
        let named = |error: Error| match &profile.channel {
            name if name.is_empty() => error,
            name => Error::Profile(format!("channel {name}: {error}")),
        };
        profile.validate().and_then(|()| profile.check_varies()).map_err(named)?;
    }
    if options.starts == 0 {
        return Err(Error::Parameter("starts = 0 is out of range: it must be at least 1".to_owned()));
    }
    let space = Space::new(forward, profiles, &options.requests)?;
    let mut space = match options.exit {
        Some(exit) => space.with_exit(exit)?,
        None => space,
    };
    for (k, profile) in profiles.iter().enumerate() {
        for (roughness, axis) in
            [(Parameter::BetaM, profile.axis(|p| p.theta)), (Parameter::BetaN, profile.axis(|p| p.phi))]
        {
            space.resolve(k, Kind::Fiber(roughness, 0), UNRESOLVED * spacing(&axis));
        }
    }
    let mut rng = SimRng::seed_from_u64(options.seed);
    let mut chosen: Vec<Vec<usize>> = profiles.iter().map(|p| (0..p.points.len()).collect()).collect();
    let everything = chosen.clone();
    for chosen in &mut chosen {
        chosen.shuffle(&mut rng);
        chosen.truncate((SAMPLE / profiles.len()).max(FEWEST));
    }
    let part = Cost::new(profiles, &chosen, &space, forward, ROUGH);

    let steps: Vec<f64> = space.leads.iter().map(|&lead| space.parameters[lead].step).collect();
    let on_part = |u: &[f64]| part.residuals(u);
    let rough = Problem { bounds: &space.bounds, steps: &steps, residuals: &on_part, huber: options.huber, progress };

    let begun = starts(&space, &part, options, progress);
    // The last step stands for the work after the descents.
    let reports = Steps::new(progress, begun.len() as u64 + 1, "fitting");
    let mut minima: Vec<Minimum> = begun
        .par_iter()
        .map(|start| {
            let minimum = rough.minimise(start, Difference::Forward, 60);
            reports.advance(1);
            minimum
        })
        .collect();
    let finished = minima.iter().filter(|m| m.converged).count();
    let ends: Vec<Vec<f64>> = minima.iter().map(|m| m.u.clone()).collect();
    rank(&rough, &mut minima);
    let distinct = distinct(&space, &minima);
    // The narrowest lobes of these minima.
    let distances = distinct.iter().map(|m| distance(&space.setup(0, &space.values(&m.u)).specimen.fiber));
    let distance = distances.fold(ROUGH, |a, b| [a[0].min(b[0]), a[1].min(b[1])]);
    let all = Cost::new(profiles, &everything, &space, forward, distance);
    let on_all = |u: &[f64]| all.residuals(u);
    let fine = Problem { residuals: &on_all, ..rough };
    let mut followed: Vec<Minimum> =
        distinct.par_iter().map(|m| fine.minimise(&m.u, Difference::Central, 200)).collect();
    rank(&fine, &mut followed);
    followed.truncate(CORRECTED);
    followed.truncate(CORRECTED);
    let mut exact = followed.iter().map(|m| corrected(&all, &fine, &m.u)).collect::<Result<Vec<_>, Error>>()?;
    let noise = exact.iter().map(|(m, _)| m.noise).fold(f64::INFINITY, f64::min);
    let loss = |m: &Minimum| fine.loss(&m.residuals, noise);
    exact.sort_by(|(a, _), (b, _)| loss(a).total_cmp(&loss(b)));
    let interrupted = progress.is_cancelled();
    let mut statistics = explore(&fine, &space, profiles, &exact);
    for _ in 0..RESTARTS {
        let Some(better) = statistics.as_ref().and_then(|s| s.better.clone()) else { break };
        exact.insert(0, corrected(&all, &fine, &better)?);
        statistics = explore(&fine, &space, profiles, &exact);
    }
    let (Some((best, cost)), Some(statistics)) = (exact.first(), statistics) else {
        return Err(Error::Profile("no descent ended".to_owned()));
    };
    let residuals = |u: &[f64]| cost.residuals(u);
    let last = Problem { residuals: &residuals, ..fine };
    // The minimum for a part of the points is within a few standard errors of the minimum for all points.
    let reached = ends.iter().filter(|u| similar(&space, &statistics, u, &best.u)).count();
    let rival = exact[1..].iter().find(|(m, _)| !similar(&space, &statistics, &m.u, &best.u)).map(|(m, _)| Rival {
        values: space.values(&m.u),
        chi2: 2.0 * (fine.loss(&m.residuals, best.noise) - fine.loss(&best.residuals, best.noise)),
    });
    reports.advance(1);
    let evaluations = [&part, &all].into_iter().chain(exact.iter().map(|(_, cost)| cost));
    let outside = Outside {
        starts: Starts { begun: begun.len(), finished, ended_here: reached },
        rival,
        evaluations: evaluations.map(|cost| cost.evaluations.load(Ordering::Relaxed)).sum(),
        interrupted,
    };
    Ok(describe(profiles, &space, &last, best, &statistics, outside))
}

/// Descends from `u` with the far field corrected by quadrature.
fn corrected<'c>(all: &Cost<'c>, fine: &Problem, u: &[f64]) -> Result<(Minimum, Cost<'c>), Error> {
    let descend = |u: &[f64]| -> Result<(Minimum, Cost<'c>), Error> {
        let cost = all.corrected(u)?;
        let residuals = |u: &[f64]| cost.residuals(u);
        let minimum = Problem { residuals: &residuals, ..*fine }.minimise(u, Difference::Central, 50);
        Ok((minimum, cost))
    };
    let mut end = descend(u)?;
    for _ in 1..CORRECTIONS {
        end = descend(&end.0.u)?;
    }
    Ok(end)
}

/// The statistics of the first minimum. The others may be as good.
fn explore(fine: &Problem, space: &Space, profiles: &[Profile], exact: &[(Minimum, Cost)]) -> Option<Statistics> {
    let (minimum, cost) = exact.first()?;
    let residuals = |u: &[f64]| cost.residuals(u);
    let problem = Problem { residuals: &residuals, ..*fine };
    let mut statistics = statistics(&problem, space, profiles, minimum);
    let Statistics { covariance, jacobian, variance, .. } = &statistics;
    let start = Start { problem: &problem, minimum, covariance, jacobian, variance: *variance };
    let rivals: Vec<&Minimum> = exact[1..].iter().map(|(m, _)| m).collect();
    let explored = start.explore(&rivals);
    statistics.apply(space, &problem, explored);
    Some(statistics)
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
    profiles: &[Profile],
    space: &Space,
    problem: &Problem,
    best: &Minimum,
    statistics: &Statistics,
    outside: Outside,
) -> Fit {
    let values = space.values(&best.u);
    let parts = parts(profiles, space, &values, &best.residuals);
    let name = |column: usize| space.lead(column).name.clone();
    let estimate = |i: usize| {
        let p = &space.parameters[i];
        let (error, interval, state, determined) = match space.sources[i] {
            Source::Fixed(_) => (None, None, State::Fixed, true),
            Source::Free(column) => {
                let lead = space.leads[column];
                let inside = statistics.places[column] == Place::Inside;
                let slope = space.parameters[lead].curve.slope(values[lead]);
                let error = statistics.errors[column].map(|error| error * slope);
                let range = &space.parameters[lead];
                // Rounding may move an end just out of the range.
                let end = |u: f64| range.curve.value(u).clamp(range.low, range.high);
                let interval = Some(statistics.intervals[column].map(end));
                let state = match (lead == i, inside) {
                    (false, _) => State::Tied(name(column)),
                    (true, true) => State::Fitted,
                    (true, false) => State::AtBound,
                };
                (error, interval, state, statistics.determined[column])
            }
        };
        let profile = space.members.iter().position(|indices| indices.contains(&i)).unwrap_or_default();
        Estimate { name: p.name.clone(), profile, unit: p.unit, value: values[i], error, interval, state, determined }
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
    let count = |k: usize| (profiles[k].points.len() * profiles[k].channels) as f64;
    let total: f64 = (0..profiles.len()).map(count).sum();
    let together = |of: fn(&Part) -> f64| {
        (parts.iter().enumerate().map(|(k, part)| count(k) * of(part).powi(2)).sum::<f64>() / total).sqrt()
    };
    let explained = explained(problem, profiles, &best.residuals, best.noise, columns);
    let of_fiber = |column: &usize| !space.lead(*column).kind.is_of_measurement();
    let known: Vec<bool> = (0..columns).filter(of_fiber).map(|column| statistics.visible[column]).collect();
    let no_fit = judge(&explained, statistics.widened, &known);
    Fit {
        model: space.model.kind(),
        specimen: parts[0].specimen,
        nrmse: together(|part| part.nrmse),
        log_nrmse: together(|part| part.log_nrmse),
        parts,
        estimates: (0..space.parameters.len()).map(estimate).collect(),
        correlations: Correlations {
            names: (0..columns).map(name).collect(),
            matrix: (0..columns).map(|i| (0..columns).map(|j| correlation(i, j)).collect()).collect(),
        },
        weakest: Combination {
            shares: statistics.weakest.iter().map(|&(j, x)| (name(j), x)).collect(),
            standard_error: statistics.weakest_error,
        },
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

/// The result for each profile.
fn parts(profiles: &[Profile], space: &Space, values: &[f64], mut residuals: &[f64]) -> Vec<Part> {
    let part = |(k, profile): (usize, &Profile)| {
        let (own, rest) = residuals.split_at(profile.points.len() * profile.channels);
        residuals = rest;
        let ratios: Vec<f64> = own.iter().zip(weights(profile)).map(|(r, weight)| (r / weight).exp()).collect();
        let fitted: Vec<[f64; 3]> = profile
            .points
            .iter()
            .zip(ratios.chunks(profile.channels))
            .map(|(p, ratios)| std::array::from_fn(|c| ratios.get(c).map_or(0.0, |ratio| p.value[c] * ratio)))
            .collect();
        let (nrmse, log_nrmse) = errors(profile, &fitted);
        let Setup { specimen, theta_o, scale, background } = space.setup(k, values);
        Part { specimen, theta_o, scale, background, fitted, nrmse, log_nrmse }
    };
    profiles.iter().enumerate().map(part).collect()
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
