//! Intervals of parameters by the profile likelihood (Venzon and Moolgavkar 1988).
//!
//! A variable is moved away from the minimum while all others are fitted again, until the loss has risen as much as
//! chance explains. Unlike the curvature at the minimum, this follows curved valleys, and the kinks of interpolated
//! tables do not matter. The walks of all variables share what they find: the ends of a valley that one of them reaches
//! count for all.

use crate::least_squares::{Minimum, Problem};
use crate::matrix::Matrix;
use rayon::prelude::*;

/// The normal deviate that 95 % of random values do not exceed.
pub const DEVIATE: f64 = 1.959_964;

/// How often an end is moved. The loss is nearly quadratic, so a few steps are usually enough.
const STEPS: usize = 8;

/// An end is found if the rise is right to within this share.
const CLOSE: f64 = 0.05;

/// The most steps of a descent with one variable held.
const DESCENT: usize = 30;

/// What is known around a minimum.
pub struct Explored {
    /// The 95 % interval of each variable, within its bounds.
    pub intervals: Vec<[f64; 2]>,
    /// A point whose loss is below that of the minimum by more than a tenth of what chance explains.
    pub better: Option<Vec<f64>>,
}

/// Variables, and how much the loss rises there, as a share of the rise at the end of an interval.
#[derive(Clone)]
struct Found {
    u: Vec<f64>,
    rise: f64,
}

/// A minimum to walk away from.
pub struct Start<'p, 'm> {
    /// The problem.
    pub problem: &'p Problem<'p>,
    /// Its minimum.
    pub minimum: &'m Minimum,
    /// The covariance there.
    pub covariance: &'m Matrix,
    /// The derivatives of the residuals there.
    pub jacobian: &'m [Vec<f64>],
    /// The variance of a residual.
    pub variance: f64,
}

impl Start<'_, '_> {
    /// The intervals of all variables. `others` are other minima. They are within the intervals if chance explains
    /// their loss, and walks go on from there.
    pub fn explore(&self, others: &[&Minimum]) -> Explored {
        let n = self.minimum.u.len();
        let here = Found { u: self.minimum.u.clone(), rise: 0.0 };
        let sides = || (0..n).flat_map(|j| [(j, -1.0), (j, 1.0)]).collect::<Vec<_>>();
        let walks: Vec<Vec<Found>> = sides().into_par_iter().map(|(j, side)| self.walk(&here, j, side)).collect();
        let found = |m: &&Minimum| Found { u: m.u.clone(), rise: self.rise(&m.residuals) };
        let mut all: Vec<Found> = others.iter().map(found).collect();
        all.extend(walks.into_iter().flatten());
        // Other walks may have reached farther. Then the walk goes on from there.
        let again: Vec<Vec<Found>> = sides()
            .into_par_iter()
            .map(|(j, side)| {
                let end = farthest(&all, j, side);
                let beyond = end.filter(|f| side * (f.u[j] - here.u[j]) > 0.0);
                beyond.map_or(Vec::new(), |end| self.walk(end, j, side))
            })
            .collect();
        all.extend(again.into_iter().flatten());
        let end = |j: usize, side: f64| farthest(&all, j, side).map_or(here.u[j], |found| found.u[j]);
        let intervals = (0..n).map(|j| [end(j, -1.0).min(here.u[j]), end(j, 1.0).max(here.u[j])]).collect();
        let lowest = all.iter().min_by(|a, b| a.rise.total_cmp(&b.rise)).filter(|found| found.rise < -0.1);
        Explored { intervals, better: lowest.map(|found| found.u.clone()) }
    }

    /// The rise of the loss at the end of an interval.
    fn goal(&self) -> f64 {
        0.5 * DEVIATE * DEVIATE * self.variance / (self.minimum.noise * self.minimum.noise)
    }

    fn descend(&self, bounds: &[[f64; 2]], u: &[f64]) -> Found {
        let end = Problem { bounds, ..*self.problem }.follow(u, self.jacobian, DESCENT);
        Found { rise: self.rise(&end.residuals), u: end.u }
    }

    /// The rise of the loss for these residuals.
    fn rise(&self, residuals: &[f64]) -> f64 {
        (self.problem.loss(residuals, self.minimum.noise) - self.minimum.loss) / self.goal()
    }

    /// Moves variable `j` from a point to one side until the loss has risen enough, or to its bound. Returns the points
    /// on the way, of which the last that counts is the end of the interval.
    fn walk(&self, from: &Found, j: usize, side: f64) -> Vec<Found> {
        let bound = self.problem.bounds[j][usize::from(side > 0.0)];
        let room = (bound - from.u[j]).abs();
        let error = self.covariance[(j, j)].max(0.0).sqrt();
        let mut found = vec![from.clone()];
        if room <= 0.0 || error <= 0.0 {
            return found;
        }
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let (mut below, mut above) = (from.rise, f64::INFINITY);
        let mut distance = (DEVIATE * error * (1.0 - from.rise.clamp(0.0, 0.9)).sqrt()).min(room);
        for _ in 0..STEPS {
            let held = from.u[j] + side * distance;
            let mut bounds = self.problem.bounds.to_vec();
            bounds[j] = [held; 2];
            // The others go on in the direction of the last step, at first in that of the covariance.
            let last = &found[found.len() - 1].u;
            let moved = held - last[j];
            let along = |i: usize| last[i] + moved * self.covariance[(i, j)] / (error * error);
            let mut start: Vec<f64> = (0..last.len()).map(along).collect();
            start[j] = held;
            let next = self.descend(&bounds, &start);
            let rise = next.rise;
            if rise <= 1.0 {
                (low, below) = (distance, rise);
                found.push(next);
                if distance >= room {
                    break;
                }
            } else {
                (high, above) = (distance, rise);
            }
            if (rise - 1.0).abs() < CLOSE || high - low < CLOSE * distance {
                break;
            }
            distance = if high.is_finite() {
                // The square root of the rise is nearly linear in the distance.
                let [a, b] = [below, above].map(|x| x.max(0.0).sqrt());
                low + (high - low) * ((1.0 - a) / (b - a)).clamp(0.1, 0.9)
            } else {
                (distance * (1.0 / rise.max(0.25)).sqrt().max(1.05)).min(room)
            };
        }
        // Between the last point that counts and the first that does not.
        if high.is_finite() && high > low {
            let [a, b] = [below, above].map(|x| x.max(0.0).sqrt());
            let end = from.u[j] + side * (low + (high - low) * ((1.0 - a) / (b - a)).clamp(0.0, 1.0));
            let mut u = found[found.len() - 1].u.clone();
            u[j] = end;
            found.push(Found { u, rise: 1.0 });
        }
        found
    }
}

/// The point farthest to one side in variable `j`, of those that chance explains.
fn farthest(all: &[Found], j: usize, side: f64) -> Option<&Found> {
    all.iter().filter(|found| found.rise <= 1.0).max_by(|a, b| (side * a.u[j]).total_cmp(&(side * b.u[j])))
}
