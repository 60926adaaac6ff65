//! Gauss–Legendre quadrature.

use std::sync::OnceLock;

/// Sizes of the rules. There are few, so that an average for a slightly different fibre uses the same rule.
const SIZES: [usize; 13] = [24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536];

static RULES: [OnceLock<Vec<[f32; 2]>>; SIZES.len()] = [const { OnceLock::new() }; SIZES.len()];

/// Points in [−1, 1] and their weights, which sum to 2. The rule has at least `needed` points, or is the largest.
pub(crate) fn rule(needed: f32) -> &'static [[f32; 2]] {
    let i = SIZES.iter().position(|&n| n as f32 >= needed).unwrap_or(SIZES.len() - 1);
    RULES[i].get_or_init(|| gauss_legendre(SIZES[i]).into_iter().map(|p| p.map(|x| x as f32)).collect())
}

/// Points in [−1, 1] and weights, which sum to 2, of the Gauss–Legendre rule with `n` points.
///
/// By Newton's method from Chebyshev-like initial values (Abramowitz and Stegun 1964, 22.16.6). Legendre polynomials
/// come from their recurrence.
pub fn gauss_legendre(n: usize) -> Vec<[f64; 2]> {
    let point = |i: usize| {
        let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..5 {
            let (mut last, mut p) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                (last, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * last) / k);
            }
            slope = n as f64 * (x * p - last) / (x * x - 1.0);
            x -= p / slope;
        }
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..n).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rule of n points is exact for polynomials of degree 2n − 1. The weights sum to 2.
    #[test]
    fn rules_are_exact_for_polynomials() {
        for n in SIZES {
            let rule = gauss_legendre(n);
            for degree in [0, 2, 2 * n - 2] {
                let sum: f64 = rule.iter().map(|[x, w]| w * x.powi(degree as i32)).sum();
                assert!((sum * (degree + 1) as f64 - 2.0).abs() < 1e-10, "{n} {degree}: {sum}");
            }
        }
        assert_eq!((rule(17.0).len(), rule(0.0).len(), rule(1e9).len()), (24, 24, 1536));
    }
}
