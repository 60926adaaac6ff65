//! The published model over a window of offsets (Yan17 Eq. 11, 22, 26), by the paper's segments.

use super::Published;
use super::segments::{Segments, offsets};
use crate::oracle::OracleHit;

/// The published model averaged over a window of offsets.
#[derive(Clone, Debug)]
pub struct PublishedWindow<'p, 't> {
    published: &'p Published<'t>,
    theta_o: f64,
    /// Offsets of the nodes, of the unscattered and of the scattered lobes.
    unscattered: Vec<f64>,
    scattered: Vec<f64>,
    /// The tables at the nodes of the scattered lobes.
    hits: Vec<OracleHit<'p, 't>>,
}

impl<'t> Published<'t> {
    /// Averages over the offsets from `h1` to `h2` > `h1`, within [−1, 1], in so many segments on each side of 0: 5 or
    /// 8 in the paper for R, TT, TRT, and 4 or 5 for the scattered lobes. `theta_o` in radians.
    #[doc(alias = "Eq. 26")]
    pub fn window(
        &self,
        theta_o: f64,
        window: [f64; 2],
        unscattered: usize,
        scattered: usize,
    ) -> PublishedWindow<'_, 't> {
        let scattered = offsets(window, scattered);
        PublishedWindow {
            published: self,
            theta_o,
            unscattered: offsets(window, unscattered),
            hits: scattered.iter().map(|&h| self.oracle.at(theta_o, h)).collect(),
            scattered,
        }
    }
}

impl PublishedWindow<'_, '_> {
    /// S·cos θ of R, TT, TRT, TTˢ, TRTˢ, RGB; angles as for [`Published::eval`].
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
