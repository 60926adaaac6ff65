//! The published model averaged over a window of offsets by the paper's segments (Yan17 Eq. 11, 22, 26).

use super::AsPrinted;
use super::segments::{Segments, offsets};
use crate::exact::ExactHit;

/// The published model averaged over a window of offsets.
#[derive(Clone, Debug)]
pub struct PrintedWindow<'p, 't> {
    published: &'p AsPrinted<'t>,
    theta_o: f64,
    /// Offsets of the nodes, of the unscattered and of the scattered lobes.
    unscattered: Vec<f64>,
    scattered: Vec<f64>,
    /// The tables at the nodes of the scattered lobes.
    hits: Vec<ExactHit<'p, 't>>,
}

impl<'t> AsPrinted<'t> {
    /// Averages over the offsets from `h1` to `h2` > `h1` within [−1, 1]. `theta_o` is in radians.
    ///
    /// `unscattered` and `scattered` are the numbers of segments on each side of h = 0, at least 1. The paper takes 5
    /// or 8 for R, TT, TRT, and 4 or 5 for TTˢ, TRTˢ.
    #[doc(alias = "Eq. 26")]
    pub fn window(
        &self,
        theta_o: f64,
        window: [f64; 2],
        unscattered: usize,
        scattered: usize,
    ) -> PrintedWindow<'_, 't> {
        let scattered = offsets(window, scattered);
        PrintedWindow {
            published: self,
            theta_o,
            unscattered: offsets(window, unscattered),
            hits: scattered.iter().map(|&h| self.exact.at(theta_o, h)).collect(),
            scattered,
        }
    }
}

impl PrintedWindow<'_, '_> {
    /// S·cos θ of the five lobes, RGB. Angles are those of [`AsPrinted::eval`].
    pub fn eval(&self, theta_i: f64, phi: f64) -> [[f64; 3]; 5] {
        let published = self.published;
        let theta_d = 0.5 * (theta_i - self.theta_o);
        let segments = |h: &[f64]| Segments {
            nodes: h.iter().map(|&h| published.node(theta_d, h)).collect(),
            medium: published.medium(theta_d),
        };
        let scattered = segments(&self.scattered);
        let escaping = published.escaping(theta_d);
        let distribution: Vec<_> = self
            .hits
            .iter()
            .zip(&scattered.nodes)
            .map(|(hit, node)| {
                let q = published.scattered_fraction(theta_d, node);
                let densities = hit.densities(theta_i, phi);
                [3, 4].map(|p| escaping.map(|t_b| t_b * q * densities[p]))
            })
            .collect();
        let [tts, trts] = scattered.scattered(&distribution);
        let n = segments(&self.unscattered).unscattered(phi);
        let m = published.longitudinal(self.theta_o, theta_i);
        let [r, tt, trt] = std::array::from_fn(|p| n[p].map(|n| n * m[p]));
        [r, tt, trt, tts, trts]
    }
}
