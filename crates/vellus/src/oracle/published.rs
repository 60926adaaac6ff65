//! Our near field over a window by the paper's segments: what those alone do, without its other differences.

use super::{Oracle, OraclePath, Profile};
use crate::published::segments::{Medium, Node, Segments, offsets};

/// The five lobes that the paper has, over a window of offsets.
#[derive(Clone, Debug)]
pub struct PublishedSegments<'o, 't> {
    unscattered: Segments,
    scattered: Segments,
    /// Paths and profiles at the nodes of the scattered lobes.
    points: Vec<(OraclePath<'o, 't>, Profile)>,
}

impl<'t> Oracle<'t> {
    /// The offsets from `h1` to `h2` > `h1` in so many segments, unscattered and scattered, on each side of 0.
    pub fn published_segments(
        &self,
        theta_o: f64,
        window: [f64; 2],
        unscattered: usize,
        scattered: usize,
    ) -> PublishedSegments<'_, 't> {
        let long = self.elongation(theta_o);
        let medium = Medium {
            cortex: self.sigma_ca.map(|ca| ca * long),
            medulla: self.sigma_ma.map(|ma| (ma + self.sigma_ms) * long),
            beta_n: self.beta_n,
        };
        let node = |h: f64| {
            let path = self.path(theta_o, h);
            Node {
                h,
                reflected: path.attenuation[0][0],
                s_c: path.s_c,
                s_m: path.s_m,
                gamma_i: path.gamma_o,
                gamma_t: path.gamma_t,
            }
        };
        let segments = |n| Segments { nodes: offsets(window, n).into_iter().map(node).collect(), medium };
        let points = offsets(window, scattered);
        PublishedSegments {
            unscattered: segments(unscattered),
            scattered: segments(scattered),
            points: points.iter().map(|&h| (self.path(theta_o, h), self.azimuthal_profile(theta_o, h))).collect(),
        }
    }
}

impl PublishedSegments<'_, '_> {
    /// N(φ) of R, TT, TRT, TTˢ, TRTˢ, RGB.
    pub fn azimuthal(&self, phi: f64) -> [[f64; 3]; 5] {
        let distribution: Vec<_> = self
            .points
            .iter()
            .map(|(path, profile)| {
                [1, 2].map(|p| path.scattered.map(|e| e * super::scattered(profile, path.relative(p, phi), [1.0; 2])))
            })
            .collect();
        let [r, tt, trt] = self.unscattered.unscattered(phi);
        let [tts, trts] = self.scattered.scattered(&distribution);
        [r, tt, trt, tts, trts]
    }
}
