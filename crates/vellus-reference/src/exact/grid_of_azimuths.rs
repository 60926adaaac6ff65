//! R, TT, TRT over a window, at many equidistant azimuths. This module sums the light of all offsets on a fine grid of
//! azimuths, and convolves the grid with each lobe's Gaussian.
//!
//! [`super::ExactWindow`] adds one Gaussian for each offset and azimuth. A lobe of 0.1° needs 30,000 azimuths and as
//! many offsets: 3·10⁹ Gaussians. This module needs one pass over the offsets and one convolution.

use super::{Exact, wrapped_gaussian};
use std::f64::consts::{PI, TAU};

/// The Gaussian is cut off at this number of standard deviations. This omits 2.6e-12 of the light.
const REACH: f64 = 7.0;

impl Exact<'_> {
    /// N(φ) of R, TT, TRT, RGB, per radian, averaged over the offsets from `h1` to `h2` > `h1` within [−1, 1], at
    /// φ = 2πk/n − π for k = 0 … n − 1, where n is `azimuths`. `theta_o` is in radians.
    ///
    /// It takes `paths` offsets, equidistant in γ = asin h. The light of each is split between the two azimuths of the
    /// grid next to its exit azimuth. This keeps the mean, and adds a variance of δ²/6 on average, where δ is the step
    /// of the grid. The Gaussian is narrower by this variance. With eight steps per standard deviation the error is
    /// below 1e-4 of the light.
    pub fn unscattered_grid(
        &self,
        theta_o: f64,
        [h1, h2]: [f64; 2],
        paths: usize,
        azimuths: usize,
    ) -> Vec<[[f64; 3]; 3]> {
        let step = TAU / azimuths as f64;
        let mut light = vec![[[0.0; 3]; 3]; azimuths];
        let [first, last] = [h1, h2].map(f64::asin);
        let width = (last - first) / paths as f64;
        for k in 0..paths {
            let gamma = first + width * (k as f64 + 0.5);
            let path = self.path(theta_o, gamma.sin());
            let share = gamma.cos() * width / (h2 - h1);
            for p in 0..3 {
                let x = (path.exit(p) + PI).rem_euclid(TAU) / step;
                let (node, t) = (x.floor(), x.fract());
                for (node, t) in [(node as usize, 1.0 - t), (node as usize + 1, t)] {
                    (0..3).for_each(|c| light[node % azimuths][p][c] += share * t * path.attenuation[p][c]);
                }
            }
        }
        let mut spread = vec![[[0.0; 3]; 3]; azimuths];
        for p in 0..3 {
            let sigma = (self.sigma(p).powi(2) - step * step / 6.0).max(1e-3 * step * step).sqrt();
            // The Gaussian is wrapped if the lobe is wider than the circle.
            let reach = ((REACH * sigma / step).ceil() as usize).min(azimuths / 2);
            let taps: Vec<f64> =
                (0..=2 * reach).map(|j| wrapped_gaussian((j as f64 - reach as f64) * step, sigma)).collect();
            // If the kernel covers the whole circle, both of its ends are the same azimuth.
            let taps = &taps[..if 2 * reach == azimuths { 2 * reach } else { 2 * reach + 1 }];
            for c in 0..3 {
                // Unrolled: azimuth k is at k + reach, and its neighbours follow without a break.
                let mut sums = vec![0.0; azimuths + taps.len()];
                for (from, cell) in light.iter().enumerate() {
                    let energy = cell[p][c];
                    if energy > 0.0 {
                        sums[from..from + taps.len()].iter_mut().zip(taps).for_each(|(sum, tap)| *sum += energy * tap);
                    }
                }
                for (k, sum) in sums.into_iter().enumerate() {
                    spread[(k + azimuths - reach) % azimuths][p][c] += sum;
                }
            }
        }
        spread
    }
}
