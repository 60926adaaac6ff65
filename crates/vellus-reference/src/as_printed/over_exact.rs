//! The exact near field averaged over a window by the paper's segments. It shows the effect of the segments only.

use super::segments::{Medium, Node, Segments, offsets};
use crate::exact::hit::scattered;
use crate::exact::{Exact, ExactPath, Profile};

/// The five lobes of the paper over a window of offsets, by the paper's segments (D9).
#[derive(Clone, Debug)]
pub struct PrintedSegments<'e, 't> {
    unscattered: Segments,
    scattered: Segments,
    /// Paths and profiles at the nodes of the scattered lobes.
    points: Vec<(ExactPath<'e, 't>, Profile)>,
}

impl<'t> Exact<'t> {
    /// Divides the offsets from `h1` to `h2` > `h1` within [−1, 1] as the paper does, at h = √(i/n), with n segments on
    /// each side of h = 0. n is `unscattered` for R, TT, TRT and `scattered` for TTˢ, TRTˢ, both at least 1. `theta_o`
    /// is in radians.
    pub fn printed_segments(
        &self,
        theta_o: f64,
        window: [f64; 2],
        unscattered: usize,
        scattered: usize,
    ) -> PrintedSegments<'_, 't> {
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
        PrintedSegments {
            unscattered: segments(unscattered),
            scattered: segments(scattered),
            points: points.iter().map(|&h| (self.path(theta_o, h), self.azimuthal_profile(theta_o, h))).collect(),
        }
    }
}

impl PrintedSegments<'_, '_> {
    /// N(φ) of R, TT, TRT, TTˢ, TRTˢ at the azimuth φ = φ_i − φ_o (radians), RGB, per radian.
    pub fn azimuthal(&self, phi: f64) -> [[f64; 3]; 5] {
        let distribution: Vec<_> = self
            .points
            .iter()
            .map(|(path, profile)| {
                [1, 2].map(|p| path.scattered.map(|e| e * scattered(profile, path.relative(p, phi), [1.0; 2])))
            })
            .collect();
        let [r, tt, trt] = self.unscattered.unscattered(phi);
        let [tts, trts] = self.scattered.scattered(&distribution);
        [r, tt, trt, tts, trts]
    }
}
