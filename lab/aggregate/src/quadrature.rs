//! Gauss' rule.

/// Abscissae and weights of Gauss' rule with eight points on [−1, 1], the positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// ∫ f from `low` to `high` by Gauss' rule with eight points in each of `parts` equal parts.
pub(crate) fn gauss(low: f64, high: f64, parts: u32, f: impl Fn(f64) -> f64) -> f64 {
    points(low, high, parts).map(|(x, w)| w * f(x)).sum()
}

/// The abscissae and weights of [`gauss`].
pub(crate) fn points(low: f64, high: f64, parts: u32) -> impl Iterator<Item = (f64, f64)> {
    let half = 0.5 * (high - low) / f64::from(parts);
    (0..parts).flat_map(move |k| {
        let middle = low + half * (2.0 * f64::from(k) + 1.0);
        GAUSS.into_iter().flat_map(move |(x, w)| [(middle - half * x, half * w), (middle + half * x, half * w)])
    })
}
