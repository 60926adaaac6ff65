//! The visibility of the difference between two pictures of fur: the mean of [`flip`] on the fur, where each pixel counts
//! by the share that fibres cover.
//!
//! Sampling noise increases ꟻLIP. Each picture is therefore given as two halves with independent seeds, whose difference
//! shows how much. For exponents below 1, |s + n|^q ≤ |s|^q + |n|^q. So what two pictures with noise differ by, minus
//! what their noise alone would give, is a lower bound of what the pictures without noise differ by, on average.

use crate::flip::{PIXELS_PER_DEGREE, Shown, flip};
use crate::{Claim, Verdict};
use vellus_render::{Film, Layer};

/// ꟻLIP of a difference that is just noticeable: that of two even greys, L* = 50, whose ΔE*ab is 2.3 (Mahy, Van Eycken
/// and Oosterlinck 1994).
pub const NOTICEABLE: f64 = 0.10;

/// Of two pictures with independent noise, the difference of the means of their halves has half the variance of the
/// difference of two halves of one picture. ꟻLIP grows with the power 0.7 of the difference, so this is 2^(−0.35).
const MEANS: f64 = 0.785;

/// Mean ꟻLIP on the fur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visible {
    /// The value of the two pictures.
    pub flip: f64,
    /// The part of it that noise explains, at most.
    pub noise: f64,
}

impl Visible {
    /// The difference of two pictures, each given as two halves.
    pub fn new(a: [&Film; 2], b: [&Film; 2]) -> Self {
        let weights = fur(&[a, b].concat());
        let of = |p: &[&Film], q: &[&Film]| mean(&flip(&shown(p, 0.0), &shown(q, 0.0), PIXELS_PER_DEGREE), &weights);
        let halves = [a, b].map(|[first, second]| of(&[first], &[second]));
        Visible { flip: of(&a, &b), noise: MEANS * 0.5 * (halves[0] + halves[1]) }
    }

    /// The difference in words.
    pub fn text(&self) -> String {
        format!("FLIP {:.3} on the fur, of which noise explains at most {:.3}", self.flip, self.noise)
    }

    /// The claim that the difference is visible. `paper` is what the paper says, and `more` another number.
    pub fn claim(&self, what: &str, paper: &str, more: &str) -> Claim {
        let measured = format!("FLIP {:.2}", self.flip);
        let claim = if self.flip - self.noise > NOTICEABLE || self.flip < NOTICEABLE {
            Claim::new(what, measured, self.flip, Verdict::of(self.flip > NOTICEABLE))
        } else {
            Claim::not_judged(what, measured, "The noise is too large to decide: more samples are needed.")
        };
        let ours = format!("bound: {NOTICEABLE:.2} on the fur, just noticeable");
        claim.paper(paper).ours(ours).more(format!("Noise explains at most {:.3}. {more}.", self.noise))
    }
}

/// The mean of films as a display shows it, times 2^`exposure`.
pub fn shown(films: &[&Film], exposure: f32) -> Shown {
    let gain = f64::from(exposure).exp2() / films.len().max(1) as f64;
    let size = films.first().map_or([0, 0], |film| [film.width(), film.height()]);
    Shown::new(size, |x, y| [0, 1, 2].map(|c| gain * films.iter().map(|f| f.mean(x, y, Layer::Beauty, c)).sum::<f64>()))
}

/// The mean share of each pixel that fibres cover, row by row.
pub fn fur(films: &[&Film]) -> Vec<f64> {
    let [width, height] = films.first().map_or([0, 0], |film| [film.width(), film.height()]);
    let count = films.len().max(1) as f64;
    let share = |i: usize| films.iter().map(|f| f.mean(i % width, i / width, Layer::Fibers, 0)).sum::<f64>() / count;
    (0..width * height).map(share).collect()
}

/// The mean of values with these weights; 0 if all weights are 0.
pub fn mean(values: &[f64], weights: &[f64]) -> f64 {
    let all: f64 = weights.iter().sum();
    if all > 0.0 { values.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>() / all } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bound is the value of the just noticeable difference that it is derived from.
    #[test]
    fn the_bound_is_a_just_noticeable_difference() {
        // L* of 50 and 52.3 as linear light.
        let grey = |l: f64| Shown::new([9, 9], |_, _| [((l + 16.0) / 116.0f64).powi(3); 3]);
        let found = flip(&grey(50.0), &grey(52.3), PIXELS_PER_DEGREE);
        assert!(found.iter().all(|x| (x - NOTICEABLE).abs() < 0.005), "{}", found[0]);
    }

    /// Only fur counts.
    #[test]
    fn pixels_without_fur_do_not_count() {
        assert_eq!(mean(&[0.2, 0.9, 0.4], &[1.0, 0.0, 0.5]), (0.2 + 0.2) / 1.5);
        assert_eq!(mean(&[0.5], &[0.0]), 0.0);
    }

    #[test]
    fn noise_never_decides() {
        let verdict = |flip: f64, noise: f64| Visible { flip, noise }.claim("a", "b", "c").verdict;
        assert_eq!(verdict(0.3, 0.05), Verdict::Holds);
        assert_eq!(verdict(0.3, 0.25), Verdict::NotJudged);
        assert_eq!(verdict(0.08, 0.07), Verdict::DoesNotHold);
    }

    /// Two pictures of the same grey with independent noise: what they differ by is what noise explains, within a tenth.
    #[test]
    fn noise_is_explained_by_the_halves() {
        let mut state = 1u64;
        let mut noisy = |deviation: f64| -> Vec<f64> {
            let mut uniform = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 * 0.5f64.powi(53) - 0.5
            };
            // The variance of a uniform number is 1/12.
            (0..64 * 64).map(|_| 0.3 + deviation * 12f64.sqrt() * uniform()).collect()
        };
        let halves: [Vec<f64>; 4] = std::array::from_fn(|_| noisy(0.05));
        let grey = |v: &dyn Fn(usize) -> f64| Shown::new([64, 64], |x, y| [v(y * 64 + x); 3]);
        let of = |a: &Shown, b: &Shown| mean(&flip(a, b, PIXELS_PER_DEGREE), &[1.0; 64 * 64]);
        let half = |k: usize| grey(&|i| halves[k][i]);
        let both = |k: usize| grey(&|i| 0.5 * (halves[k][i] + halves[k + 1][i]));
        let noise = MEANS * 0.5 * (of(&half(0), &half(1)) + of(&half(2), &half(3)));
        let found = of(&both(0), &both(2));
        // Features have another exponent, so that noise explains a little more than there is.
        assert!(found < 1.02 * noise && found > 0.8 * noise, "{found} {noise}");
    }
}
