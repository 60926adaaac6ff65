//! ∫ Q₁·exp(Q₂) and ∫ C·exp(L) over a segment, for every slope (Yan17 Appendix).
//!
//! The antiderivatives of the Appendix divide differences of nearly equal numbers by powers of the slope, up to the
//! fourth. This module divides the segment, x ∈ [−1, 1], where its exponential is largest, at an end or between. With
//! the distance z from there, scaled to [0, 1], each side needs only
//!
//! H_k = ∫ zᵏ exp(−λz − b²z²/2) dz,  λ ≥ 0, k ≤ 3,
//!
//! and integration by parts couples three of them: k H_{k−1} = exp(−λ − b²/2) + λ H_k + b² H_{k+1}. All terms are
//! positive, so nothing cancels when k goes down (D14).

use std::f64::consts::FRAC_PI_2;

/// A quantity that is linear along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    middle: f64,
    half: f64,
}

impl Line {
    /// From its values at both ends.
    pub fn between(first: f64, last: f64) -> Self {
        Line { middle: 0.5 * (first + last), half: 0.5 * (last - first) }
    }

    fn at(self, x: f64) -> f64 {
        self.half.mul_add(x, self.middle)
    }
}

/// ½ ∫ Π `factors` · exp(−`depth` − `distance`²/2) dx over x ∈ [−1, 1]: the mean over the segment of up to three
/// factors, none of them negative on it, and an exponential of a line and of the square of another.
///
/// With a constant `distance` this is C·exp(L) of Eq. 25, otherwise Q₁·exp(Q₂) of Eq. 24. The relative error is at most
/// 1e-12 for slopes up to 1000: that of [`moments`], plus the slope times 1e-16 from rounding the largest exponent, and
/// the same again from locating it.
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
        // 0 where the peak is between the ends.
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
/// Where λ + b² ≤ 16 the recurrence starts with 0 for H₁₀₀. The error of this start is at most the product of 16/k
/// over every other k from 99 down to 5: 1e-20. Rounding adds at most three units per step, and the errors of early
/// steps are damped alike: 1e-14. Elsewhere the integral over [1, ∞), at most a 300th of the result, is subtracted
/// from the one over [0, ∞).
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
/// From λ = 1.5 b on, by the quotients H_k/H_{k−1} = k/(λ + b² H_{k+1}/H_k), a continued fraction. Started with 0 at
/// k = 200, its error is exp(−2·1.5·√200) = 4e-19. Below, from the normal distribution upward, where the differences
/// lose at most one digit.
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

    /// The mean by 5-point Gauss–Legendre panels, a twentieth of the shortest scale long.
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

    /// The products of R, TT and TRT, TTˢ and TRTˢ, one factor vanishing at an end.
    fn factors() -> [Vec<Line>; 3] {
        let [f, g, d] = [(0.05, 1.0), (0.9, 0.0), (0.3, 0.1)].map(|(a, b)| Line::between(a, b));
        [vec![f], vec![f, g], vec![f, g, d]]
    }

    /// Slopes of the Gaussian's centre and of the absorption from 0 and 1e-8 to 1000, with both signs: all that a
    /// query can have. The integrand is nowhere negative, so its integral is that of its magnitude.
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

    /// Slopes as above, in the other form.
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
