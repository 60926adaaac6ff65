//! Bounds on errors in standard errors, with a stated false-alarm rate.

/// The chance that a correct fit fails one test.
const FALSE_ALARM: f64 = 1e-3;

/// The probability that a normal deviate exceeds `x` in absolute value: Simpson's rule over its tail, of which 12 more
/// contain all but 1e-32.
fn two_sided(x: f64) -> f64 {
    let density = |x: f64| (-0.5 * x * x).exp() * (2.0 / std::f64::consts::PI).sqrt();
    let (steps, width) = (4000, 12.0);
    let h = width / f64::from(steps);
    let weight = |i: i32| if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    (0..=steps).map(|i| weight(i) * density(x + h * f64::from(i))).sum::<f64>() * h / 3.0
}

/// The bound that the largest of `count` normal deviates exceeds with a probability of at most [`FALSE_ALARM`],
/// however they are correlated (Šidák 1967).
pub fn largest(count: usize) -> f64 {
    let each = -((-FALSE_ALARM).ln_1p() / count as f64).exp_m1();
    let (mut low, mut high) = (0.0, 12.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if two_sided(middle) > each { low = middle } else { high = middle }
    }
    high
}

/// No error is larger than [`largest`], and their mean square is 1 to within 3.29 of its standard errors, which is as
/// rare. Errors of one fit are correlated by groups of about three: the mean square of n has the standard error √(6/n).
pub fn check_scores(what: &str, scores: &[(String, f64)]) {
    let n = scores.len() as f64;
    let mean = scores.iter().map(|(_, z)| z * z).sum::<f64>() / n;
    let (name, worst) = scores.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
    println!("{what}: {n} errors, root mean square {:.3}, largest {worst:.2} ({name})", mean.sqrt());
    assert!(worst.abs() <= largest(scores.len()), "{what}: {name} is {worst} standard errors off");
    assert!((mean - 1.0).abs() <= 3.29 * (6.0 / n).sqrt(), "{what}: the mean square of {n} errors is {mean}");
}

#[test]
fn the_bound_is_the_tabulated_quantile() {
    assert!((two_sided(1.959_964) - 0.05).abs() < 1e-7 && (two_sided(4.891_638) - 1e-6).abs() < 1e-11);
    assert!((largest(1) - 3.290_527).abs() < 1e-5, "{}", largest(1));
}
