//! The visibility of the difference between two pictures of fur.
//!
//! Colours are compared as a display shows them, pixel by pixel: ΔE*ab, the distance in CIE 1976 L*a*b*. The result is
//! its root mean square, weighted by the share of each pixel that fibres cover.
//!
//! Sampling noise does not count as a difference. Each picture is therefore given as two halves with independent
//! seeds. The product of the halves' differences, (A₁ − B₁)·(A₂ − B₂), has the mean |A − B|², without the variance of
//! the square of one difference. One bias remains: the mean of a noisy L* is less than the L* of the mean. It is the
//! same for both pictures.

use crate::{Claim, Verdict};
use vellus_render::{Film, Layer};

/// A difference that is just noticeable: ΔE*ab of 2.3 (Mahy, Van Eycken and Oosterlinck 1994).
pub const NOTICEABLE: f64 = 2.3;

/// The normal distribution exceeds this in absolute value with a probability of 0.1 %.
const DEVIATE: f64 = 3.29;

/// Root mean square of ΔE*ab on the fur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visible {
    /// The estimate.
    pub delta: f64,
    /// The interval that contains it with a probability of 99.9 %.
    pub range: [f64; 2],
}

impl Visible {
    /// The difference of two pictures, each given as two halves.
    pub fn new(a: [&Film; 2], b: [&Film; 2]) -> Self {
        let (width, height) = (a[0].width(), a[0].height());
        let pixels: Vec<(f64, f64)> = (0..width * height)
            .map(|i| (i % width, i / width))
            .map(|(x, y)| {
                let difference = |half: usize| {
                    let [p, q] = [a, b].map(|films| lab(color(films[half], x, y)));
                    std::array::from_fn(|c| p[c] - q[c])
                };
                let ([p, q], covered): ([[f64; 3]; 2], f64) = ([0, 1].map(difference), coverage(&[a, b], x, y));
                (covered, p.iter().zip(&q).map(|(p, q)| p * q).sum())
            })
            .collect();
        Visible::of(&pixels)
    }

    /// Computes the result from pairs of a pixel's weight and its unbiased square.
    fn of(pixels: &[(f64, f64)]) -> Self {
        let all = pixels.iter().map(|(w, _)| w).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean = pixels.iter().map(|(w, x)| w * x).sum::<f64>() / all;
        let error = pixels.iter().map(|(w, x)| (w * (x - mean)).powi(2)).sum::<f64>().sqrt() / all;
        let root = |x: f64| x.max(0.0).sqrt();
        Visible { delta: root(mean), range: [root(mean - DEVIATE * error), root(mean + DEVIATE * error)] }
    }

    /// The difference in words.
    pub fn text(&self) -> String {
        format!("ΔE*ab {:.2} ({:.2} to {:.2}) on the fur", self.delta, self.range[0], self.range[1])
    }

    /// The claim that the difference is visible.
    pub fn claim(&self, what: &str, more: &str) -> Claim {
        let expected = format!("root mean square of ΔE*ab on the fur's pixels above {NOTICEABLE}, just noticeable");
        let measured = self.text() + more;
        let [low, high] = self.range;
        if low > NOTICEABLE || high < NOTICEABLE {
            Claim::new(what, expected, measured, self.delta, Verdict::of(low > NOTICEABLE))
        } else {
            Claim::not_judged(what, expected, measured, "The noise is too large to decide: more samples are needed.")
        }
    }
}

/// Mean share of a pixel that fibres cover.
fn coverage(pictures: &[[&Film; 2]; 2], x: usize, y: usize) -> f64 {
    pictures.as_flattened().iter().map(|film| film.mean(x, y, Layer::Fibers, 0)).sum::<f64>() / 4.0
}

fn color(film: &Film, x: usize, y: usize) -> [f64; 3] {
    [0, 1, 2].map(|c| film.mean(x, y, Layer::Beauty, c))
}

/// L*, a*, b* of linear sRGB, clamped to 0 to 1 as a display does (CIE 15:2004, Eq. 8.3 to 8.11; the white point is
/// that of daylight, 6504 K).
pub(crate) fn lab(rgb: [f64; 3]) -> [f64; 3] {
    // IEC 61966-2-1; each row is divided by its sum, the white point.
    const XYZ: [[f64; 3]; 3] = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
    let [x, y, z] = XYZ.map(|row| {
        let t = row.iter().zip(rgb).map(|(m, v)| m * v.clamp(0.0, 1.0)).sum::<f64>() / row.iter().sum::<f64>();
        if t > (6.0f64 / 29.0).powi(3) { t.cbrt() } else { t * (29.0f64 / 6.0).powi(2) / 3.0 + 4.0 / 29.0 }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lab_matches_the_standard() {
        let close = |rgb: [f64; 3], expected: [f64; 3]| {
            let found = lab(rgb);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{found:?} {expected:?}");
        };
        close([1.0; 3], [100.0, 0.0, 0.0]);
        close([0.0; 3], [0.0; 3]);
        // Red has the published values of sRGB, within the digits of the white point.
        close([0.1842; 3], [50.0, 0.0, 0.0]);
        close([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]);
        // A display clamps to white.
        close([9.0, 9.0, 9.0], [100.0, 0.0, 0.0]);
    }

    /// The halves of two pictures differ by noise only. The square of one difference would be 2 σ², but the product is
    /// 0 within its range.
    #[test]
    fn noise_is_no_difference() {
        // Differences of two halves from a congruential generator: uniform with variance 1/12, times 20.
        let mut state = 1u64;
        let mut noise = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            20.0 * ((state >> 11) as f64 * 0.5f64.powi(53) - 0.5)
        };
        let pixels = |difference: f64, noise: &mut dyn FnMut() -> f64| -> Vec<(f64, f64)> {
            (0..20_000).map(|_| (1.0, (difference + noise()) * (difference + noise()))).collect()
        };
        let same = Visible::of(&pixels(0.0, &mut noise));
        assert!(same.range[0] == 0.0 && same.range[1] < NOTICEABLE, "{same:?}");
        assert_eq!(same.claim("", "").verdict, Verdict::DoesNotHold);
        let other = Visible::of(&pixels(4.0, &mut noise));
        assert!(other.range[0] < 4.0 && 4.0 < other.range[1], "{other:?}");
        assert_eq!(other.claim("", "").verdict, Verdict::Holds);
    }

    #[test]
    fn a_difference_within_its_noise_is_not_judged() {
        let found = Visible::of(&[(1.0, 0.0), (1.0, 12.0), (0.0, 1e9)]);
        assert!(found.range[0] < NOTICEABLE && NOTICEABLE < found.range[1], "{found:?}");
        assert_eq!(found.claim("", "").verdict, Verdict::NotJudged);
    }
}
