//! How well the data determine the fitted parameters.

use crate::intervals::{DEVIATE, Explored};
use crate::least_squares::{Difference, Minimum, Problem};
use crate::matrix::{Matrix, eigen};
use crate::profile::Profile;
use crate::space::Space;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A variable is not determined if its standard error exceeds this share of its usual range.
const VAGUE: f64 = 0.1;

/// A variable is unknown if its standard error is this many times its usual range.
const UNKNOWN: f64 = 100.0;

/// The first distance, in units of the usual range, by which a variable is moved off its bound. The distance then
/// doubles.
const NEAREST: f64 = 1.0 / 64.0;

/// The largest such distance.
const FARTHEST: f64 = 2.0;

/// How often derivatives are replaced by [`secants`]. Each time, the standard errors set the steps.
const SECANTS: usize = 3;

/// The longest step of a difference quotient along an eigenvector, in units of the usual ranges.
const WIDEST_STEP: f64 = 0.3;

/// Components below this share of a direction's length are not reported.
const NAMED: f64 = 0.25;

/// Where a fitted variable ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Between its bounds.
    Inside,
    /// On its lower bound.
    Low,
    /// On its upper bound.
    High,
}

/// The errors of all variables.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// The variables at the minimum.
    middle: Vec<f64>,
    /// Where each variable ended.
    pub places: Vec<Place>,
    /// Covariance of the variables.
    pub covariance: Matrix,
    /// The derivatives of the residuals.
    pub jacobian: Vec<Vec<f64>>,
    /// The standard error of each variable; `None` if the data do not constrain it at all.
    pub errors: Vec<Option<f64>>,
    /// Whether the standard error is small against the usual range and the variable is inside its bounds.
    pub determined: Vec<bool>,
    /// Whether the standard error would be small if the residuals were noise. This also holds for variables on a
    /// bound.
    pub visible: Vec<bool>,
    /// Correlation of neighbouring residuals, over φ and over θ. It is near 0 if they are noise, and near 1 if the
    /// model cannot match the data.
    pub neighbours: [f64; 2],
    /// The factor by which this correlation widened the standard errors.
    pub widened: f64,
    /// The combination of variables that the data constrain least. It is a unit vector in units of the usual ranges,
    /// as pairs of a variable and its component, the largest component first.
    pub weakest: Vec<(usize, f64)>,
    /// The standard error along this direction, in the same units.
    pub weakest_error: f64,
    /// The variance of a residual, widened for this correlation.
    pub variance: f64,
    /// The 95 % interval of each variable.
    pub intervals: Vec<[f64; 2]>,
    /// A point that fits better than the minimum.
    pub better: Option<Vec<f64>>,
}

impl Statistics {
    /// Takes over intervals. A variable then has the standard error of a normal variable with the same interval, if
    /// that is larger than the one that follows from the derivatives at the minimum.
    pub fn apply(&mut self, space: &Space, problem: &Problem, explored: Explored) {
        for (j, [low, high]) in explored.intervals.iter().enumerate() {
            let width = space.width(j);
            let near = 1e-6 * width;
            let [below, above] = [self.middle[j] - low, high - self.middle[j]];
            let [first, last] = problem.bounds[j];
            // Without the bound, a side that ends there would be at least as long.
            let cut = *low <= first + near || *high >= last - near;
            let interval = if cut { below.max(above) } else { 0.5 * (below + above) } / DEVIATE;
            let error = self.covariance[(j, j)].sqrt().max(interval);
            self.errors[j] = Some(error).filter(|&e| e <= UNKNOWN * width);
            self.determined[j] = self.places[j] == Place::Inside && error <= VAGUE * width;
            self.visible[j] = error <= VAGUE * width * self.widened;
        }
        self.intervals = explored.intervals;
        self.better = explored.better;
    }
}

/// Computes the errors at a minimum.
pub fn statistics(problem: &Problem, space: &Space, profiles: &[Profile], minimum: &Minimum) -> Statistics {
    let Minimum { u, residuals, noise, .. } = minimum;
    let n = u.len();
    let mut jacobian = problem.jacobian(u, residuals, Difference::Central);
    let widths: Vec<f64> = (0..n).map(|j| space.width(j)).collect();
    let place = |j: usize| {
        let [low, high] = problem.bounds[j];
        let near = 1e-6 * widths[j];
        if u[j] <= low + near {
            Place::Low
        } else if u[j] >= high - near {
            Place::High
        } else {
            Place::Inside
        }
    };
    let places: Vec<Place> = (0..n).map(place).collect();

    let neighbours = neighbour_correlation(problem, profiles, residuals, *noise);
    // If neighbours correlate by ρ, the variance of a mean grows by (1 + ρ)/(1 − ρ), to first order. θ and φ are
    // treated separately.
    let inflation: f64 = neighbours.iter().map(|r| r.clamp(0.0, 0.98)).map(|r| (1.0 + r) / (1.0 - r)).product();
    let variance = residual_variance(problem, residuals, *noise, n) * inflation;

    for _ in 0..SECANTS {
        jacobian = secants(problem, u, &widths, &places, &jacobian, variance);
    }
    let scaled = products(&jacobian, &widths);
    let mut covariance = inside_covariance(&scaled, &places, variance);
    let rise = 0.5 * variance / (noise * noise);
    let bound: Vec<usize> = (0..n).filter(|&j| places[j] != Place::Inside).collect();
    let (_, gradient) = problem.normal_equations(&jacobian, residuals, *noise);
    let slopes: Vec<f64> = gradient.iter().map(|g| g.abs() / (noise * noise)).collect();
    let way = |&b: &usize| {
        let least = straight(&scaled, &covariance, b, variance);
        valley(problem, minimum, b, &widths, Reach { rise, slope: slopes[b], least })
    };
    let valleys: Vec<Vec<f64>> = bound.par_iter().map(way).collect();
    for way in &valleys {
        for i in 0..n {
            for j in 0..n {
                covariance[(i, j)] += way[i] * way[j];
            }
        }
    }
    let (values, vectors) = eigen(&covariance);
    for i in 0..n {
        for j in 0..n {
            covariance[(i, j)] *= widths[i] * widths[j];
        }
    }
    let error = |j: usize| covariance[(j, j)].sqrt();
    let determined = (0..n).map(|j| places[j] == Place::Inside && error(j) <= VAGUE * widths[j]).collect();
    let visible = (0..n).map(|j| error(j) <= VAGUE * widths[j] * inflation.sqrt()).collect();
    let errors = (0..n).map(|j| Some(error(j)).filter(|&e| e <= UNKNOWN * widths[j])).collect();
    let mut weakest: Vec<(usize, f64)> = vectors
        .first()
        .map(|v| v.iter().copied().enumerate().filter(|(_, x)| x.abs() >= NAMED).collect())
        .unwrap_or_default();
    weakest.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let weakest_error = values.first().map_or(0.0, |x| x.max(0.0).sqrt());
    Statistics {
        middle: u.clone(),
        places,
        covariance,
        jacobian,
        errors,
        determined,
        visible,
        neighbours,
        widened: inflation.sqrt(),
        weakest,
        weakest_error,
        variance,
        intervals: Vec::new(),
        better: None,
    }
}

/// JᵀJ in units of the usual ranges, so that eigenvalues are comparable.
fn products(jacobian: &[Vec<f64>], widths: &[f64]) -> Matrix {
    let n = jacobian.len();
    let mut scaled = Matrix::zero(n);
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = jacobian[i].iter().zip(&jacobian[j]).map(|(a, b)| a * b).sum();
            scaled[(i, j)] = dot * widths[i] * widths[j];
            scaled[(j, i)] = scaled[(i, j)];
        }
    }
    scaled
}

/// The derivatives as difference quotients over one standard error to both sides, along the eigenvectors of JᵀJ.
///
/// The tables of the model are interpolated, so the values have kinks, whose slopes are steeper than the average slope
/// along a combination of variables that the data hardly constrain. Derivatives over short steps then give standard
/// errors that are too small.
fn secants(
    problem: &Problem,
    u: &[f64],
    widths: &[f64],
    places: &[Place],
    jacobian: &[Vec<f64>],
    variance: f64,
) -> Vec<Vec<f64>> {
    let free: Vec<usize> = (0..u.len()).filter(|&j| places[j] == Place::Inside).collect();
    let scaled = products(jacobian, widths);
    let mut inside = Matrix::zero(free.len());
    for (p, &i) in free.iter().enumerate() {
        for (q, &j) in free.iter().enumerate() {
            inside[(p, q)] = scaled[(i, j)];
        }
    }
    let (values, vectors) = eigen(&inside);
    let slopes: Vec<Vec<f64>> = values
        .par_iter()
        .zip(&vectors)
        .map(|(&value, vector)| {
            let error = (variance / value.max(1e-300)).sqrt().min(WIDEST_STEP);
            let moved = |side: f64| {
                let mut step = error;
                for (&j, x) in free.iter().zip(vector) {
                    let [low, high] = problem.bounds[j];
                    let along = side * x * widths[j];
                    let room = if along > 0.0 { high - u[j] } else { u[j] - low };
                    step = step.min(room / along.abs().max(1e-300));
                }
                let mut moved = u.to_vec();
                for (&j, x) in free.iter().zip(vector) {
                    let [low, high] = problem.bounds[j];
                    moved[j] = (u[j] + side * step * x * widths[j]).clamp(low, high);
                }
                (step, (problem.residuals)(&moved))
            };
            let ((up, above), (down, below)) = (moved(1.0), moved(-1.0));
            above.iter().zip(&below).map(|(a, b)| (a - b) / (up + down).max(1e-12)).collect()
        })
        .collect();
    let mut wide = jacobian.to_vec();
    for (p, &j) in free.iter().enumerate() {
        wide[j].fill(0.0);
        for (vector, slope) in vectors.iter().zip(&slopes) {
            wide[j].iter_mut().zip(slope).for_each(|(x, s)| *x += vector[p] * s / widths[j]);
        }
    }
    wide
}

/// Covariance of the variables inside their bounds, from JᵀJ, in units of the usual ranges.
fn inside_covariance(a: &Matrix, places: &[Place], variance: f64) -> Matrix {
    let free: Vec<usize> = (0..places.len()).filter(|&j| places[j] == Place::Inside).collect();
    let mut inside = Matrix::zero(free.len());
    for (p, &i) in free.iter().enumerate() {
        for (q, &j) in free.iter().enumerate() {
            inside[(p, q)] = a[(i, j)];
        }
    }
    let (values, vectors) = eigen(&inside);
    let least = values.first().map_or(0.0, |x| x * 1e-13).max(1e-300);
    let mut covariance = Matrix::zero(places.len());
    for (value, vector) in values.iter().zip(&vectors) {
        for (p, &i) in free.iter().enumerate() {
            for (q, &j) in free.iter().enumerate() {
                covariance[(i, j)] += variance * vector[p] * vector[q] / value.max(least);
            }
        }
    }
    covariance
}

/// One standard error of variable `b`, as its distance from the bound, in units of the usual ranges. It follows from
/// the curvature at the bound. `inside` is the covariance of the variables inside their bounds.
fn straight(a: &Matrix, inside: &Matrix, b: usize, variance: f64) -> f64 {
    let n = a.rows();
    let follow = |i: usize| (0..n).map(|j| inside[(i, j)] * a[(j, b)]).sum::<f64>() / variance;
    let left = a[(b, b)] - (0..n).map(|i| a[(b, i)] * follow(i)).sum::<f64>();
    if left > 0.0 { (variance / left).sqrt().min(FARTHEST) } else { FARTHEST }
}

/// When to stop moving a variable off its bound.
struct Reach {
    /// The loss must rise by this much, one standard error.
    rise: f64,
    /// The slope of the loss at the bound, per unit of the variable. The rise that it causes is not counted: the
    /// unconstrained minimum lies beyond the bound, and errors are as wide as around that minimum.
    slope: f64,
    /// The smallest distance to move.
    least: f64,
}

/// One standard error of variable `b` from its bound, as a vector of all variables in units of the usual ranges. The
/// other variables are fitted again at each distance (profile likelihood). The derivatives at the bound are not enough,
/// because valleys are curved, and the true value may be half a range away.
fn valley(problem: &Problem, minimum: &Minimum, b: usize, widths: &[f64], reach: Reach) -> Vec<f64> {
    let [low, high] = problem.bounds[b];
    let inward = if minimum.u[b] <= 0.5 * (low + high) { 1.0 } else { -1.0 };
    let way = |u: &[f64]| u.iter().zip(&minimum.u).zip(widths).map(|((x, y), w)| (x - y) / w).collect::<Vec<f64>>();
    let (mut from, mut distance, mut risen) = (minimum.u.clone(), 0.0, 0.0);
    let mut goal = FARTHEST;
    loop {
        let next = if distance == 0.0 { NEAREST } else { 2.0 * distance };
        let held = (minimum.u[b] + inward * next * widths[b]).clamp(low, high);
        let mut bounds = problem.bounds.to_vec();
        bounds[b] = [held; 2];
        let mut start = from.clone();
        start[b] = held;
        let moved = Problem { bounds: &bounds, ..*problem }.minimise(&start, Difference::Forward, 30);
        let straight = reach.slope * (held - minimum.u[b]).abs();
        let rising = problem.loss(&moved.residuals, minimum.noise) - minimum.loss - straight;
        if risen < reach.rise && rising >= reach.rise {
            let share = (reach.rise - risen) / (rising - risen);
            goal = (distance + share * (next - distance)).max(reach.least).min(FARTHEST);
        }
        if next >= goal {
            let share = (goal - distance) / (next - distance);
            return way(&from).iter().zip(way(&moved.u)).map(|(x, y)| x + (y - x) * share).collect();
        }
        (from, distance, risen) = (moved.u, next, rising);
    }
}

/// The variance of the residuals for the errors of the parameters (Huber 1981, Eq. 7.6.9). Without outliers it is the
/// plain variance.
fn residual_variance(problem: &Problem, residuals: &[f64], noise: f64, variables: usize) -> f64 {
    let (n, p) = (residuals.len() as f64, variables as f64);
    let (mut squares, mut inliers) = (0.0, 0.0);
    for &r in residuals {
        let w = problem.weight(r, noise);
        squares += (w * r).powi(2);
        inliers += f64::from(w >= 1.0);
    }
    let m = (inliers / n).max(0.1);
    let correction = 1.0 + p / n * (1.0 - m) / m;
    correction * correction * squares / (n - p).max(1.0) / (m * m)
}

/// Correlation of each residual with the next one in φ at the same θ, and with the next one in θ at the same φ.
fn neighbour_correlation(problem: &Problem, profiles: &[Profile], residuals: &[f64], noise: f64) -> [f64; 2] {
    let (mut products, mut squares) = ([0.0; 2], [0.0; 2]);
    let mut rest = residuals;
    for profile in profiles {
        let residuals;
        (residuals, rest) = rest.split_at(profile.points.len() * profile.channels);
        let (thetas, phis) = (profile.axis(|p| p.theta), profile.axis(|p| p.phi));
        let cell = |theta: f64, phi: f64| {
            let find = |axis: &[f64], x: f64| axis.binary_search_by(|y| y.total_cmp(&x)).unwrap_or(usize::MAX);
            (find(&thetas, theta), find(&phis, phi))
        };
        let cells: BTreeMap<(usize, usize), usize> =
            profile.points.iter().enumerate().map(|(i, p)| (cell(p.theta, p.phi), i)).collect();
        let held = |i: usize, c: usize| {
            let r = residuals[i * profile.channels + c];
            r * problem.weight(r, noise)
        };
        for (k, (dt, dp)) in [(0, 1), (1, 0)].into_iter().enumerate() {
            for (&(t, p), &i) in &cells {
                if let Some(&j) = cells.get(&(t + dt, p + dp)) {
                    for c in 0..profile.channels {
                        products[k] += held(i, c) * held(j, c);
                        squares[k] += 0.5 * (held(i, c).powi(2) + held(j, c).powi(2));
                    }
                }
            }
        }
    }
    [0, 1].map(|k| if squares[k] > 0.0 { products[k] / squares[k] } else { 0.0 })
}
