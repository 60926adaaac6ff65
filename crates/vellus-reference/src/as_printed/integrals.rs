//! ∫ Q₁·exp(Q₂) and ∫ C·exp(L) over a segment, for every slope (Yan17 Appendix).
//!
//! The antiderivatives of the Appendix divide differences of nearly equal numbers by powers of the slope, up to the
//! fourth. This module divides the segment, x ∈ [−1, 1], at the maximum of its exponential, which may be at an end. Let
//! z be the distance from the maximum, scaled to [0, 1]. Each side then only needs
//!
//! H_k = ∫ zᵏ exp(−λz − b²z²/2) dz,  λ ≥ 0, k ≤ 3.
//!
//! Integration by parts gives a recurrence: k H_{k−1} = exp(−λ − b²/2) + λ H_k + b² H_{k+1}. All terms are positive, so
//! nothing cancels for decreasing k (D14).

use std::f64::consts::FRAC_PI_2;

/// A quantity that is linear along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    middle: f64,
    half: f64,
}

impl Line {
    /// The line with the given values at both ends.
    pub fn between(first: f64, last: f64) -> Self {
        Line { middle: 0.5 * (first + last), half: 0.5 * (last - first) }
    }

    fn at(self, x: f64) -> f64 {
        self.half.mul_add(x, self.middle)
    }
}

/// ½ ∫ Π `factors` · exp(−`depth` − `distance`²/2) dx over x ∈ [−1, 1]. This is the mean over the segment. There are up
/// to three factors, and none is negative on the segment.
///
/// With a constant `distance` this is C·exp(L) of Eq. 25, otherwise Q₁·exp(Q₂) of Eq. 24. The relative error is at most
/// 1e-12 for slopes up to 1000. It is the sum of the error of [`moments`], the slope times 1e-16 from rounding the
/// largest exponent, and as much from the position of the maximum.
#[doc(alias = "Appendix")]
pub(crate) fn mean(factors: &[Line], depth: Line, distance: Line) -> f64 {
    // The exponent's slope at x is `slope` − b²x.
    let b = distance.half;
    let slope = -(depth.half + distance.middle * b);
    let peak = if slope.abs() < b * b { slope / (b * b) } else { 1f64.copysign(slope) };
    let largest = (-depth.at(peak) - 0.5 * distance.at(peak).powi(2)).exp();
    if largest == 0.0 {
        return 0.0;
    }
    let side = |direction: f64| {
        let length = 1.0 - direction * peak;
        // The slope at the peak: 0 if the peak is between the ends.
        let fall = if peak.abs() < 1.0 { 0.0 } else { direction * (b * b * peak - slope) };
        if length <= 0.0 {
            return 0.0;
        }
        let h = moments(fall * length, (b * length).powi(2));
        let mut polynomial = [1.0, 0.0, 0.0, 0.0];
        for factor in factors {
            let (value, rate) = (factor.at(peak), factor.half * direction * length);
            for k in (0..4).rev() {
                polynomial[k] = value * polynomial[k] + if k > 0 { rate * polynomial[k - 1] } else { 0.0 };
            }
        }
        length * polynomial.iter().zip(h).map(|(c, h)| c * h).sum::<f64>()
    };
    0.5 * largest * (side(-1.0) + side(1.0))
}

/// Up to this λ + b² the recurrence starts from the top.
const SHORT: f64 = 16.0;

/// H₀ to H₃ over [0, 1], for λ ≥ 0 and `bb` = b² ≥ 0, to 1e-13.
///
/// Where λ + b² ≤ 16 the recurrence starts with 0 for H₁₀₀. The error of this start is at most 1e-20, the product of
/// 16/k over every other k from 99 down to 5. Rounding adds at most three units in the last place per step. The errors
/// of early steps are damped in the same way, so the sum is 1e-14. Otherwise, the integral over [1, ∞) is subtracted
/// from the integral over [0, ∞). It is at most 1/300 of the result.
fn moments(lambda: f64, bb: f64) -> [f64; 4] {
    let end = (-lambda - 0.5 * bb).exp();
    if lambda + bb <= SHORT {
        let (mut above, mut h) = (0.0, [0.0; 4]);
        for k in (1..=100).rev() {
            let below = (end + lambda * h[0] + bb * above) / f64::from(k);
            above = h[0];
            h = [below, h[0], h[1], h[2]];
        }
        return h;
    }
    let all = endless(lambda, bb);
    let beyond = endless(lambda + bb, bb);
    std::array::from_fn(|k| {
        // (1 + z)ᵏ by binomials.
        let tail: f64 = [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, 2.0, 1.0, 0.0], [1.0, 3.0, 3.0, 1.0]][k]
            .into_iter()
            .zip(beyond)
            .map(|(c, h)| c * h)
            .sum();
        all[k] - end * tail
    })
}

/// H₀ to H₃ over [0, ∞), where λ + b² > 16.
///
/// For λ ≥ 1.5 b, this uses the continued fraction H_k/H_{k−1} = k/(λ + b² H_{k+1}/H_k). It starts with 0 at k = 200,
/// which gives an error of exp(−2·1.5·√200) = 4e-19. For smaller λ, it starts with the normal distribution and
/// increases k. The differences then lose at most one digit.
fn endless(lambda: f64, bb: f64) -> [f64; 4] {
    let b = bb.sqrt();
    if lambda >= 1.5 * b {
        let mut quotients = [0.0; 4];
        for k in (1..=200).rev() {
            quotients = [f64::from(k) / (lambda + bb * quotients[0]), quotients[0], quotients[1], quotients[2]];
        }
        let h0 = 1.0 / (lambda + bb * quotients[0]);
        let h1 = h0 * quotients[0];
        let h2 = h1 * quotients[1];
        return [h0, h1, h2, h2 * quotients[2]];
    }
    // In standard deviations, where R_{k+1} = k R_{k−1} − x R_k.
    let x = lambda / b;
    let mills = FRAC_PI_2.sqrt() * (0.5 * x * x).exp() * libm::erfc(x * std::f64::consts::FRAC_1_SQRT_2);
    let r1 = 1.0 - x * mills;
    let r2 = mills - x * r1;
    let r3 = 2.0 * r1 - x * r2;
    [mills / b, r1 / bb, r2 / (bb * b), r3 / (bb * bb)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean by 5-point Gauss–Legendre panels. Their length is a twentieth of the shortest scale.
    fn quadrature(factors: &[Line], depth: Line, distance: Line) -> f64 {
        const X: [f64; 5] =
            [-0.906_179_845_938_664, -0.538_469_310_105_683_1, 0.0, 0.538_469_310_105_683_1, 0.906_179_845_938_664];
        const W: [f64; 5] = [
            0.236_926_885_056_189_1,
            0.478_628_670_499_366_5,
            0.568_888_888_888_888_9,
            0.478_628_670_499_366_5,
            0.236_926_885_056_189_1,
        ];
        let panels = 40 * (1.0 + depth.half.abs().max(distance.half.abs())).ceil() as usize;
        let mut sum = 0.0;
        for i in 0..panels {
            for (x, w) in X.iter().zip(W) {
                let x = (2.0 * i as f64 + 1.0 + x) / panels as f64 - 1.0;
                let product: f64 = factors.iter().map(|f| f.at(x)).product();
                sum += 0.5 * w / panels as f64 * product * (-depth.at(x) - 0.5 * distance.at(x).powi(2)).exp();
            }
        }
        sum
    }

    const SLOPES: [f64; 17] =
        [0.0, 1e-8, 1e-6, 1e-4, 1e-3, 0.01, 0.05, 0.2, 0.7, 1.5, 2.9, 4.1, 8.0, 30.0, 100.0, 300.0, 1000.0];

    /// The factors of R, of TT and TRT, and of TTˢ and TRTˢ. One factor is 0 at an end.
    fn factors() -> [Vec<Line>; 3] {
        let [f, g, d] = [(0.05, 1.0), (0.9, 0.0), (0.3, 0.1)].map(|(a, b)| Line::between(a, b));
        [vec![f], vec![f, g], vec![f, g, d]]
    }

    /// Slopes of the Gaussian's centre and of the absorption: 0, and 1e-8 to 1000 with both signs. These are all slopes
    /// that a query can have. The integrand is nowhere negative, so the integral is also that of its magnitude.
    #[test]
    fn gaussians_match_quadrature() {
        let mut worst = 0.0f64;
        for b in SLOPES.into_iter().flat_map(|b| [b, -b]) {
            for depth in [0.0f64, 1e-8, 1e-3, 0.1, 3.0, 40.0].into_iter().flat_map(|t| [t, -t]) {
                for u in [-1.0, -0.7, 0.0, 0.02, 0.5, 1.0] {
                    // Up to eight standard deviations beyond either end.
                    let distance = Line { middle: u * (b.abs() + 8.0), half: -b };
                    let depth = Line { middle: depth.abs(), half: depth };
                    for factors in &factors()[..2] {
                        let (value, exact) = (mean(factors, depth, distance), quadrature(factors, depth, distance));
                        let error = (value / exact - 1.0).abs();
                        worst = worst.max(error);
                        assert!(error < 1e-12, "b {b} u {u} {depth:?}: {value} {exact}");
                    }
                }
            }
        }
        println!("largest relative error: {worst:.1e}");
    }

    /// The same slopes with a constant distance.
    #[test]
    fn exponentials_match_quadrature() {
        let mut worst = 0.0f64;
        for t in SLOPES.into_iter().flat_map(|t| [t, -t]) {
            let (depth, distance) = (Line { middle: t.abs(), half: t }, Line { middle: 0.0, half: 0.0 });
            for factors in &factors() {
                let (value, exact) = (mean(factors, depth, distance), quadrature(factors, depth, distance));
                let error = (value / exact - 1.0).abs();
                worst = worst.max(error);
                assert!(error < 1e-12, "slope {t}: {value} {exact}");
            }
        }
        println!("largest relative error: {worst:.1e}");
    }

    /// D14: the antiderivative of C·exp(L) as printed loses all digits at a slope of 1e-4, in double precision too.
    #[test]
    fn the_appendix_cancels_in_double_precision() {
        let slope = 1e-4f64;
        // ∫ x³ e^(−ax) dx from 0 to 1.
        let a = slope;
        let antiderivative =
            |x: f64| -(-a * x).exp() * (a.powi(3) * x.powi(3) + 3.0 * a * a * x * x + 6.0 * a * x + 6.0) / a.powi(4);
        let printed = antiderivative(1.0) - antiderivative(0.0);
        assert!((printed * 4.0 - 1.0).abs() > 0.1, "{printed}");
        assert!((moments(a, 0.0)[3] * 4.0 - 1.0).abs() < a);
    }
}
