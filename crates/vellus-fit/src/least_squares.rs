//! Least squares between bounds: Levenberg–Marquardt with an active set and Huber's loss.
//!
//! Own code, because no maintained crate has bounds, a robust loss and cancellation. The problems are small (a dozen
//! variables, thousands of residuals); evaluating the model takes nearly all of the time. Nocedal and Wright 2006,
//! *Numerical Optimization*, Sec. 10.3 and 16.7; damping after Nielsen 1999; Huber 1981, *Robust Statistics*, Sec. 7.

use crate::matrix::{Matrix, solve};
use rayon::prelude::*;
use vellus_io::Progress;

/// A function to minimise.
pub struct Problem<'a> {
    /// The bounds of each variable.
    pub bounds: &'a [[f64; 2]],
    /// The step of each difference quotient. A central difference takes it to both sides.
    pub steps: &'a [f64],
    /// The residuals for given variables, which lie within the bounds.
    pub residuals: &'a (dyn Fn(&[f64]) -> Vec<f64> + Sync),
    /// Huber's k: residuals above k times the noise count linearly. Infinity gives plain least squares.
    pub huber: f64,
    /// If this is cancelled, the descent ends and returns the best variables so far.
    pub progress: &'a dyn Progress,
}

/// How difference quotients are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Difference {
    /// One evaluation for each variable: accurate enough far from the minimum.
    Forward,
    /// Two evaluations for each variable.
    Central,
}

/// The result of a descent.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The variables.
    pub u: Vec<f64>,
    /// The residuals at these variables.
    pub residuals: Vec<f64>,
    /// The scale of the noise in Huber's loss.
    pub noise: f64,
    /// The loss divided by noise²: Σ r²/2 in units of the noise, with less weight for outliers.
    pub loss: f64,
    /// The number of steps taken.
    pub iterations: usize,
    /// False if the descent was cancelled or ran out of steps.
    pub converged: bool,
}

/// The precision of a log-ratio that single precision and the quadrature of the far field allow.
pub const LEAST_NOISE: f64 = 1e-4;

/// The standard deviation of the residuals, from their median, so that outliers do not count.
pub fn noise(residuals: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    let middle = sizes.len() / 2;
    let median = if sizes.is_empty() { 0.0 } else { *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 };
    // The median of |r| of a normal distribution is 0.6745 standard deviations.
    (median / 0.6745).max(LEAST_NOISE)
}

impl Problem<'_> {
    /// Huber's loss, divided by noise².
    pub fn loss(&self, residuals: &[f64], noise: f64) -> f64 {
        let k = self.huber;
        let loss = |r: &f64| {
            let x = r.abs() / noise;
            if x <= k { 0.5 * x * x } else { k * (x - 0.5 * k) }
        };
        residuals.iter().map(loss).sum()
    }

    /// The weight of a residual in the normal equations.
    pub fn weight(&self, residual: f64, noise: f64) -> f64 {
        (self.huber * noise / residual.abs()).min(1.0)
    }

    /// Derivatives of the residuals by each variable. The difference quotients stay within the bounds.
    pub fn jacobian(&self, u: &[f64], residuals: &[f64], difference: Difference) -> Vec<Vec<f64>> {
        (0..u.len())
            .into_par_iter()
            .map(|j| {
                let [low, high] = self.bounds[j];
                if low >= high {
                    return vec![0.0; residuals.len()];
                }
                let at = |x: f64| {
                    let mut moved = u.to_vec();
                    moved[j] = x;
                    (self.residuals)(&moved)
                };
                let quotient = |a: &[f64], b: &[f64], h: f64| a.iter().zip(b).map(|(a, b)| (a - b) / h).collect();
                let (up, down) = ((u[j] + self.steps[j]).min(high), (u[j] - self.steps[j]).max(low));
                let one_sided = difference == Difference::Forward || up >= high || down <= low;
                if !one_sided {
                    quotient(&at(up), &at(down), up - down)
                } else if up - u[j] >= u[j] - down {
                    quotient(&at(up), residuals, up - u[j])
                } else {
                    quotient(residuals, &at(down), u[j] - down)
                }
            })
            .collect()
    }

    /// Computes JᵀWJ and JᵀWr.
    pub fn normal_equations(&self, jacobian: &[Vec<f64>], residuals: &[f64], noise: f64) -> (Matrix, Vec<f64>) {
        let n = jacobian.len();
        let weights: Vec<f64> = residuals.iter().map(|&r| self.weight(r, noise)).collect();
        let (mut a, mut g) = (Matrix::zero(n), vec![0.0; n]);
        for i in 0..n {
            let weighted: Vec<f64> = jacobian[i].iter().zip(&weights).map(|(x, w)| x * w).collect();
            let dot = |other: &[f64]| weighted.iter().zip(other).map(|(x, y)| x * y).sum::<f64>();
            for j in 0..=i {
                let x = dot(&jacobian[j]);
                a[(i, j)] = x;
                a[(j, i)] = x;
            }
            g[i] = dot(residuals);
        }
        (a, g)
    }

    /// Descends from `start`, which is clamped to the bounds first.
    pub fn minimise(&self, start: &[f64], difference: Difference, most: usize) -> Minimum {
        self.descend(start, Derivatives::Quotients(difference), most)
    }

    /// Descends with derivatives that each step corrects by what it finds (Broyden 1965), instead of new difference
    /// quotients. `jacobian` holds the derivatives near `start`. A step then takes one evaluation.
    pub fn follow(&self, start: &[f64], jacobian: &[Vec<f64>], most: usize) -> Minimum {
        self.descend(start, Derivatives::Corrected(jacobian.to_vec()), most)
    }

    fn descend(&self, start: &[f64], mut derivatives: Derivatives, most: usize) -> Minimum {
        let mut u: Vec<f64> = start.iter().zip(self.bounds).map(|(x, [low, high])| x.clamp(*low, *high)).collect();
        let mut residuals = (self.residuals)(&u);
        let (mut damping, mut growth) = (1e-2, 2.0);
        let mut converged = false;
        let mut iterations = 0;
        while iterations < most && !converged && !self.progress.is_cancelled() {
            iterations += 1;
            let noise = noise(&residuals);
            let loss = self.loss(&residuals, noise);
            let new;
            let jacobian = match &derivatives {
                Derivatives::Quotients(difference) => {
                    new = self.jacobian(&u, &residuals, *difference);
                    &new
                }
                Derivatives::Corrected(known) => known,
            };
            let (a, g) = self.normal_equations(jacobian, &residuals, noise);
            // The damping grows until a step reduces the loss.
            loop {
                let step = self.step(&a, &g, &u, damping);
                let next: Vec<f64> =
                    (0..u.len()).map(|j| (u[j] + step[j]).clamp(self.bounds[j][0], self.bounds[j][1])).collect();
                let length = (0..u.len()).fold(0.0f64, |m, j| m.max((next[j] - u[j]).abs() / self.steps[j]));
                if length < 1e-3 || self.progress.is_cancelled() {
                    converged = length < 1e-3;
                    break;
                }
                let tried = (self.residuals)(&next);
                let (better, predicted) = (self.loss(&tried, noise), predicted(&a, &g, &step) / (noise * noise));
                let gain = (loss - better) / predicted.max(f64::MIN_POSITIVE);
                let corrected = matches!(derivatives, Derivatives::Corrected(_));
                derivatives.correct(&u, &residuals, &next, &tried, self.steps);
                if better < loss {
                    // Nielsen's rule: the better the prediction was, the smaller the damping becomes.
                    damping = (damping * (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0)).max(1e-12);
                    growth = 2.0;
                    // Stop at a hundredth of the change of the loss for one standard error of one variable.
                    converged = loss - better < 5e-3 && damping < 1e-2 && length < 10.0;
                    (u, residuals) = (next, tried);
                    break;
                }
                damping *= growth;
                growth *= 2.0;
                if damping > 1e12 {
                    converged = true;
                    break;
                }
                if corrected {
                    break;
                }
            }
        }
        let noise = noise(&residuals);
        let loss = self.loss(&residuals, noise);
        Minimum { u, residuals, noise, loss, iterations, converged }
    }

    /// The damped step. A variable that would cross a bound stops on it, and the step of the others is solved again.
    fn step(&self, a: &Matrix, g: &[f64], u: &[f64], damping: f64) -> Vec<f64> {
        let n = u.len();
        let mut held: Vec<Option<f64>> = (0..n)
            .map(|j| {
                let [low, high] = self.bounds[j];
                let outward = (u[j] <= low && g[j] > 0.0) || (u[j] >= high && g[j] < 0.0);
                // A variable without influence on the residuals stays where it is.
                (outward || a[(j, j)] <= 0.0).then_some(0.0)
            })
            .collect();
        loop {
            let free: Vec<usize> = (0..n).filter(|&j| held[j].is_none()).collect();
            let mut reduced = Matrix::zero(free.len());
            let mut right = vec![0.0; free.len()];
            for (p, &i) in free.iter().enumerate() {
                for (q, &j) in free.iter().enumerate() {
                    reduced[(p, q)] = a[(i, j)];
                }
                reduced[(p, p)] += damping * a[(i, i)];
                right[p] = -g[i] - (0..n).filter_map(|j| held[j].map(|x| a[(i, j)] * x)).sum::<f64>();
            }
            let solution = solve(&reduced, &right).unwrap_or_else(|| vec![0.0; free.len()]);
            let mut step: Vec<f64> = held.iter().map(|h| h.unwrap_or(0.0)).collect();
            let mut pushed = false;
            for (p, &j) in free.iter().enumerate() {
                step[j] = solution[p];
                let [low, high] = self.bounds[j];
                if u[j] + solution[p] < low || u[j] + solution[p] > high {
                    held[j] = Some(if solution[p] < 0.0 { low - u[j] } else { high - u[j] });
                    pushed = true;
                }
            }
            if !pushed {
                return step;
            }
        }
    }
}

/// Where derivatives come from.
enum Derivatives {
    Quotients(Difference),
    Corrected(Vec<Vec<f64>>),
}

impl Derivatives {
    /// Changes the derivatives as little as possible so that they explain a step. Changes count in units of `steps`.
    fn correct(&mut self, from: &[f64], before: &[f64], to: &[f64], after: &[f64], steps: &[f64]) {
        let Derivatives::Corrected(jacobian) = self else { return };
        let moved: Vec<f64> = to.iter().zip(from).map(|(a, b)| a - b).collect();
        let share: Vec<f64> = moved.iter().zip(steps).map(|(m, s)| m / (s * s)).collect();
        let norm: f64 = moved.iter().zip(&share).map(|(m, s)| m * s).sum();
        if norm <= 0.0 {
            return;
        }
        for i in 0..before.len() {
            let predicted: f64 = jacobian.iter().zip(&moved).map(|(column, m)| column[i] * m).sum();
            let missing = (after[i] - before[i] - predicted) / norm;
            jacobian.iter_mut().zip(&share).for_each(|(column, s)| column[i] += missing * s);
        }
    }
}

/// The decrease that the quadratic model predicts for a step.
fn predicted(a: &Matrix, g: &[f64], step: &[f64]) -> f64 {
    let n = step.len();
    let curved: f64 = (0..n).map(|i| (0..n).map(|j| step[i] * a[(i, j)] * step[j]).sum::<f64>()).sum();
    -(0..n).map(|i| g[i] * step[i]).sum::<f64>() - 0.5 * curved
}

#[cfg(test)]
mod tests {
    use super::*;

    fn minimise(
        bounds: &[[f64; 2]],
        huber: f64,
        residuals: &(dyn Fn(&[f64]) -> Vec<f64> + Sync),
        start: &[f64],
    ) -> Minimum {
        let steps = vec![1e-6; bounds.len()];
        Problem { bounds, steps: &steps, residuals, huber, progress: &() }.minimise(start, Difference::Central, 400)
    }

    /// Rosenbrock's valley, with its minimum (1, 1) inside the bounds, and cut off by a bound, where x₁ = x₀²
    /// remains.
    #[test]
    fn a_curved_valley_is_followed_to_its_end_or_to_a_bound() {
        let valley = |u: &[f64]| vec![1.0 - u[0], 10.0 * (u[1] - u[0] * u[0])];
        let inside = minimise(&[[-5.0, 5.0]; 2], f64::INFINITY, &valley, &[-1.2, 1.0]);
        assert!(inside.u.iter().all(|x| (x - 1.0).abs() < 1e-3), "{inside:?}");
        let cut = minimise(&[[-5.0, 0.5], [-5.0, 5.0]], f64::INFINITY, &valley, &[-1.2, 1.0]);
        assert!(cut.u[0] == 0.5 && (cut.u[1] - 0.25).abs() < 1e-3, "{cut:?}");
    }

    /// With correlated variables the best point within bounds is not the clamped best point: minimise (x + y − 3)² +
    /// (x − y − 2)²/100 with x ≤ 1. At x = 1, y = (2 − 0.01)/(1.01).
    #[test]
    fn other_variables_adjust_to_a_bound() {
        let plane = |u: &[f64]| vec![u[0] + u[1] - 3.0, 0.1 * (u[0] - u[1] - 2.0)];
        let end = minimise(&[[-9.0, 1.0], [-9.0, 9.0]], f64::INFINITY, &plane, &[-3.0, -3.0]);
        assert!(end.u[0] == 1.0 && (end.u[1] - 1.99 / 1.01).abs() < 1e-5, "{end:?}");
    }

    /// The mean of values of which one in ten is far off. Huber's estimate stays within 2 k σ/10.
    #[test]
    fn outliers_pull_no_more_than_linearly() {
        let data: Vec<f64> = (0..200).map(|i| if i % 10 == 0 { 50.0 } else { f64::from(i % 7 - 3) * 0.1 }).collect();
        let off = |u: &[f64]| data.iter().map(|x| u[0] - x).collect::<Vec<f64>>();
        let [robust, plain] = [1.345, f64::INFINITY].map(|k| minimise(&[[-99.0, 99.0]], k, &off, &[20.0]).u[0]);
        assert!((plain - 5.0).abs() < 0.1 && robust.abs() < 0.1, "{plain} {robust}");
    }

    /// A variable without influence stays where it is and does not disturb the others.
    #[test]
    fn a_variable_without_influence_is_left_alone() {
        let one = |u: &[f64]| vec![u[0] - 2.0, 0.5 * (u[0] - 2.0)];
        let end = minimise(&[[-9.0, 9.0]; 2], 4.0, &one, &[-3.0, 0.7]);
        assert!((end.u[0] - 2.0).abs() < 1e-4 && end.u[1] == 0.7, "{end:?}");
    }
}
