//! Bounds on statistical errors with a stated false-alarm rate.
//!
//! A test that compares many estimates with their standard errors must allow for the largest of them. With a bound of
//! 3 standard errors, one of 100 correct estimates fails in 24 % of all runs.

/// The rate at which a correct program fails [`check_scores`] by its largest error.
pub const FALSE_ALARM: f64 = 1e-3;

/// The probability that a normal deviate exceeds `x` ≥ 0 in absolute value.
///
/// Simpson's rule over the density from `x` to `x` + 12. The rest is below 1e-32.
pub fn two_sided(x: f64) -> f64 {
    let density = |x: f64| (-0.5 * x * x).exp() * (2.0 / std::f64::consts::PI).sqrt();
    let (steps, width) = (4000, 12.0);
    let h = width / f64::from(steps);
    let weight = |i: i32| if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=steps).map(|i| weight(i) * density(x + h * f64::from(i))).sum::<f64>() * h / 3.0
}

/// The value that the absolute value of a normal deviate exceeds with this probability, by bisection of [`two_sided`].
fn two_sided_quantile(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 12.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if two_sided(middle) > probability { low = middle } else { high = middle }
    }
    high
}

/// The share of `false_alarm` that each of `count` tests may have (Šidák 1967): 1 − (1 − α)^(1/n).
fn per_test(count: usize, false_alarm: f64) -> f64 {
    -((-false_alarm).ln_1p() / count as f64).exp_m1()
}

/// The bound on |z| for `count` normal deviates that correct code exceeds with a probability of at most `false_alarm`.
///
/// The bound also holds if the deviates are correlated (Šidák 1967).
pub fn max_abs_z(count: usize, false_alarm: f64) -> f64 {
    two_sided_quantile(per_test(count, false_alarm))
}

/// The bound on a mean if `samples` samples in [0, 1] were all zero, for `count` such tests.
///
/// If the mean is m, at least a share m of all samples is not zero. All of n samples are then zero with a probability
/// of at most e^(−mn).
pub fn max_unseen_mean(samples: usize, count: usize, false_alarm: f64) -> f64 {
    -per_test(count, false_alarm).ln() / samples as f64
}

/// The bound on one of `count` χ² values with `degrees` degrees of freedom, for the same meaning of `false_alarm`.
///
/// Approximation of Wilson and Hilferty 1931. With 10 degrees or more it is within 1 % of the exact quantile.
pub fn max_chi_squared(degrees: f64, count: usize, false_alarm: f64) -> f64 {
    // The upper tail only.
    let z = two_sided_quantile(2.0 * per_test(count, false_alarm));
    let w = 2.0 / (9.0 * degrees);
    degrees * (1.0 - w + z * w.sqrt()).powi(3)
}

/// Checks errors of fitted values, each divided by its reported standard error.
///
/// The largest must be within [`max_abs_z`] at a rate of [`FALSE_ALARM`]. The mean square must be 1 to within 3.29 of
/// its standard errors, which has the same rate. The errors of one fit are correlated in groups of about three, so the
/// standard error of the mean square of n errors is √(6/n), not √(2/n).
pub fn check_scores(what: &str, scores: &[(String, f64)]) {
    let n = scores.len() as f64;
    let mean = scores.iter().map(|(_, z)| z * z).sum::<f64>() / n;
    let Some((name, worst)) = scores.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else {
        panic!("{what}: there are no errors to check");
    };
    println!("{what}: {n} errors, root mean square {:.3}, largest {worst:.2} ({name})", mean.sqrt());
    check_largest(scores);
    assert!((mean - 1.0).abs() <= 3.29 * (6.0 / n).sqrt(), "{what}: the mean square of {n} errors is {mean}");
}

/// Checks the largest error only, as [`check_scores`] does.
pub fn check_largest(scores: &[(String, f64)]) {
    let bound = max_abs_z(scores.len(), FALSE_ALARM);
    for (name, z) in scores {
        assert!(z.abs() <= bound, "{name} is off by {z:.2} standard errors, allowed are {bound:.2}");
    }
}

#[cfg(test)]
mod tests {
    use super::{max_abs_z, max_chi_squared, two_sided};

    #[test]
    fn bounds_are_the_tabulated_quantiles() {
        assert!((two_sided(1.959_964) - 0.05).abs() < 1e-7 && (two_sided(4.891_638) - 1e-6).abs() < 1e-11);
        assert!((max_abs_z(1, 1e-3) - 3.290_527).abs() < 1e-5);
        // The 99.9 % quantiles of χ² with 35 and 100 degrees of freedom are 66.619 and 149.449.
        for (degrees, exact) in [(35.0, 66.619), (100.0, 149.449)] {
            assert!((max_chi_squared(degrees, 1, 1e-3) / exact - 1.0).abs() < 2e-3, "{degrees}");
        }
    }
}
