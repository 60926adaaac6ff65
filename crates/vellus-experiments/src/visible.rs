//! The visibility of the difference between two pictures of fur: the mean of [`flip`] on the fur, where each pixel
//! counts by the share that fibres cover.
//!
//! Sampling noise increases FLIP. Each picture is therefore given as two halves with independent seeds, whose
//! difference shows how much. Difference and noise are independent, so their squares add. FLIP grows with the power
//! 0.7 of a difference. So F^(2/0.7) without noise is that of the pictures, minus that of the noise. This is done in
//! each block of the picture, because noise and difference vary over it.

use crate::flip::{PIXELS_PER_DEGREE, Shown, flip};
use crate::{Claim, Verdict};
use vellus_render::{Film, Layer};

/// FLIP of a difference that is just noticeable: that of two even greys, L* = 50, whose ΔE*ab is 2.3 (Mahy, Van Eycken
/// and Oosterlinck 1994).
pub const NOTICEABLE: f64 = 0.10;

/// Of two pictures with independent noise, the difference of the means of their halves has half the variance of the
/// difference of two halves of one picture. FLIP grows with the power 0.7 of the difference, so this is 2^(−0.35).
const MEANS: f64 = 0.785;

/// The power of FLIP that adds for independent differences: 2/0.7.
const ADDS: f64 = 2.0 / 0.7;

/// The side of a block, in pixels.
const BLOCK: usize = 16;

/// The value without noise is known to a tenth (measured by a test).
const KNOWN: f64 = 0.1;

/// Mean FLIP on the fur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visible {
    /// An estimate of the value without noise.
    pub flip: f64,
    /// The value of the two pictures.
    pub noisy: f64,
    /// The value that noise alone would give.
    pub noise: f64,
}

impl Visible {
    /// The difference of two pictures, each given as two halves.
    pub fn new(a: [&Film; 2], b: [&Film; 2]) -> Self {
        let means = [a, b].map(|halves| shown(&halves, 0.0));
        let halves = [a, b].map(|halves| halves.map(|half| shown(&[half], 0.0)));
        Visible::of(a[0].width(), &fur(&[a, b].concat()), &means, &halves)
    }

    /// The difference of the `means` of pairs of `halves`, in pictures of this width.
    fn of(width: usize, weights: &[f64], means: &[Shown; 2], halves: &[[Shown; 2]; 2]) -> Self {
        let map = |[p, q]: &[Shown; 2]| flip(p, q, PIXELS_PER_DEGREE);
        let (noisy, first, second) = (map(means), map(&halves[0]), map(&halves[1]));
        let noise: Vec<f64> = first.iter().zip(&second).map(|(a, b)| MEANS * 0.5 * (a + b)).collect();
        let across = width.div_ceil(BLOCK);
        let block = |i: usize| i / width / BLOCK * across + i % width / BLOCK;
        let mut blocks = vec![[0.0; 3]; if weights.is_empty() { 0 } else { block(weights.len() - 1) + across }];
        for (i, weight) in weights.iter().enumerate() {
            let sums = &mut blocks[block(i)];
            (sums[0], sums[1], sums[2]) = (sums[0] + weight, sums[1] + weight * noisy[i], sums[2] + weight * noise[i]);
        }
        let clean = blocks.iter().filter(|sums| sums[0] > 0.0).map(|&[weight, noisy, noise]| {
            let [noisy, noise] = [noisy, noise].map(|sum| (sum / weight).powf(ADDS));
            weight * (noisy - noise).max(0.0).powf(1.0 / ADDS)
        });
        let flip = clean.sum::<f64>() / weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        Visible { flip, noisy: mean(&noisy, weights), noise: mean(&noise, weights) }
    }

    /// The difference in words.
    pub fn text(&self) -> String {
        format!(
            "FLIP {:.3} on the fur; {:.3} with the noise, which alone gives {:.3}",
            self.flip, self.noisy, self.noise
        )
    }

    /// The claim that the difference is visible. `paper` is what the paper says, and `more` another number.
    pub fn claim(&self, what: &str, paper: &str, more: &str) -> Claim {
        self.judged(what, paper, more, self.flip > NOTICEABLE)
    }

    /// The claim that the difference is not visible, likewise.
    pub fn claim_same(&self, what: &str, paper: &str, more: &str) -> Claim {
        self.judged(what, paper, more, self.flip < NOTICEABLE)
    }

    fn judged(&self, what: &str, paper: &str, more: &str, holds: bool) -> Claim {
        let measured = format!("FLIP {:.2}", self.flip);
        let claim = if (self.flip / NOTICEABLE - 1.0).abs() > KNOWN {
            Claim::new(what, measured, self.flip, Verdict::of(holds))
        } else {
            Claim::not_judged(what, measured, "The value is too close to the bound to decide.")
        };
        let ours = format!("bound: {NOTICEABLE:.2} on the fur, just noticeable");
        claim
            .paper(paper)
            .ours(ours)
            .more(format!("{:.3} with the noise, which alone gives {:.3}. {more}.", self.noisy, self.noise))
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
    fn values_close_to_the_bound_are_not_judged() {
        let visible = |flip: f64| Visible { flip, noisy: 0.5, noise: 0.4 };
        let verdict = |flip: f64| visible(flip).claim("a", "b", "c").verdict;
        assert_eq!([0.12, 0.105, 0.08].map(verdict), [Verdict::Holds, Verdict::NotJudged, Verdict::DoesNotHold]);
        let same = |flip: f64| visible(flip).claim_same("a", "b", "c").verdict;
        assert_eq!([0.12, 0.105, 0.08].map(same), [Verdict::DoesNotHold, Verdict::NotJudged, Verdict::Holds]);
    }

    /// Two pictures whose difference grows from left to right, with independent noise that grows from top to bottom.
    fn noisy(difference: f64, deviation: f64) -> Visible {
        const SIDE: usize = 96;
        let mut state = 1u64;
        let mut noise = |_: usize| -> Vec<f64> {
            let mut uniform = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 * 0.5f64.powi(53) - 0.5
            };
            // The variance of a uniform number is 1/12.
            let size = |i: usize| deviation * 12f64.sqrt() * (i / SIDE) as f64 / SIDE as f64;
            (0..SIDE * SIDE).map(|i| size(i) * uniform()).collect()
        };
        let noise: [Vec<f64>; 4] = std::array::from_fn(&mut noise);
        let picture = |which: usize, parts: &[usize]| {
            Shown::new([SIDE, SIDE], |x, y| {
                let sum: f64 = parts.iter().map(|&k| noise[k][y * SIDE + x]).sum();
                [0.3 + which as f64 * difference * x as f64 / SIDE as f64 + sum / parts.len() as f64; 3]
            })
        };
        let halves = [[picture(0, &[0]), picture(0, &[1])], [picture(1, &[2]), picture(1, &[3])]];
        Visible::of(SIDE, &[1.0; SIDE * SIDE], &[picture(0, &[0, 1]), picture(1, &[2, 3])], &halves)
    }

    /// The estimate is within a tenth of the value without noise, up to noise that alone gives half of it.
    #[test]
    fn noise_is_taken_out() {
        let clean = noisy(0.06, 0.0);
        assert!(clean.noise == 0.0 && (clean.flip / clean.noisy - 1.0).abs() < 1e-9, "{clean:?}");
        for deviation in [0.03, 0.06, 0.12] {
            let found = noisy(0.06, deviation);
            assert!((found.flip / clean.flip - 1.0).abs() < KNOWN, "{found:?} {clean:?}");
        }
        let most = noisy(0.06, 0.12);
        assert!(most.noise > 0.5 * clean.flip, "{most:?} {clean:?}");
    }

    /// Equal pictures with noise differ by the noise alone, and are not judged as different.
    #[test]
    fn noise_is_no_difference() {
        let found = noisy(0.0, 0.1);
        assert!((found.noise / found.noisy - 1.0).abs() < 0.1 && found.flip < 0.5 * found.noise, "{found:?}");
    }
}
