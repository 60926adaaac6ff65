//! The paper's integral over the offsets by segments (Yan17 Sec. 5.1, 5.2): nodes at h = √(i/n), and between them
//! (1 − F)², F^(p−1), s_c, s_m, γ_i, γ_t and D^s linear in h.
//!
//! The caller chooses the near field that gives the values at the nodes: the paper's, or the exact one. The exact near
//! field shows the effect of the segments only (D9).

use super::integrals::{Line, mean};
use std::f64::consts::{PI, TAU};

/// Gaussians further than this from a segment's azimuths, in standard deviations, are omitted. They hold 1e-15 of the
/// light. The paper's limit of 3 omits 2.7e-3.
const REACH: f64 = 8.0;

/// The quantities that are linear in h between nodes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Offset.
    pub h: f64,
    /// F.
    pub reflected: f64,
    /// Half of the path in the cortex, and half of the path in the medulla.
    pub s_c: f64,
    pub s_m: f64,
    /// Angles of incidence and refraction in the normal plane.
    pub gamma_i: f64,
    pub gamma_t: f64,
}

/// The quantities that are the same at all offsets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Medium {
    /// σ_ca, and σ_ma + σ_ms, both divided by the cosine of the inclination inside the fibre. RGB.
    pub cortex: [f64; 3],
    pub medulla: [f64; 3],
    /// β_n.
    pub beta_n: f64,
}

/// Offsets of the nodes of a window: its ends, and ±√(i/n) between them.
pub(crate) fn offsets([h1, h2]: [f64; 2], n: usize) -> Vec<f64> {
    let node = |i: i64| (i.unsigned_abs() as f64 / n as f64).sqrt().copysign(i as f64);
    let between = (-(n as i64)..=n as i64).map(node).filter(|&h| h1 < h && h < h2);
    [h1].into_iter().chain(between).chain([h2]).collect()
}

/// A window's segments.
#[derive(Clone, Debug)]
pub(crate) struct Segments {
    pub nodes: Vec<Node>,
    pub medium: Medium,
}

impl Segments {
    /// The indices of each segment's two nodes, and its share of the window's width.
    fn segments(&self) -> impl Iterator<Item = ([usize; 2], f64)> {
        let h = |i: usize| self.nodes[i].h;
        let width = h(self.nodes.len() - 1) - h(0);
        (1..self.nodes.len()).map(move |i| ([i - 1, i], (h(i) - h(i - 1)) / width))
    }

    /// A line through a quantity's values at two nodes.
    fn line(&self, ends: [usize; 2], value: impl Fn(&Node) -> f64) -> Line {
        let [first, last] = ends.map(|i| value(&self.nodes[i]));
        Line::between(first, last)
    }

    /// N(φ) of R, TT, TRT, RGB.
    #[doc(alias = "Eq. 24")]
    pub fn unscattered(&self, phi: f64) -> [[f64; 3]; 3] {
        let mut n = [[0.0; 3]; 3];
        for (ends, share) in self.segments() {
            for p in 0..3 {
                let q = p as f64;
                let sigma = (q + 1.0).sqrt() * self.medium.beta_n;
                // R is F; TT and TRT are (1 − F)² F^(p−1) T^p.
                let factors = match p {
                    0 => vec![self.line(ends, |n| n.reflected)],
                    1 => vec![self.line(ends, |n| (1.0 - n.reflected).powi(2))],
                    _ => vec![self.line(ends, |n| (1.0 - n.reflected).powi(2)), self.line(ends, |n| n.reflected)],
                };
                let depth: [Line; 3] = std::array::from_fn(|c| {
                    let (cortex, medulla) = (self.medium.cortex[c], self.medium.medulla[c]);
                    self.line(ends, |n| 2.0 * q * (n.s_c * cortex + n.s_m * medulla))
                });
                let exits = ends.map(|i| 2.0 * q * self.nodes[i].gamma_t - 2.0 * self.nodes[i].gamma_i + q * PI);
                let reach = REACH * sigma + 0.5 * (exits[1] - exits[0]).abs();
                let middle = 0.5 * (exits[0] + exits[1]);
                // All images of the Gaussian within reach.
                let first = ((middle - reach - phi) / TAU).ceil() as i32;
                let last = ((middle + reach - phi) / TAU).floor() as i32;
                for turn in first..=last {
                    let [a, b] = exits.map(|exit| (phi + TAU * f64::from(turn) - exit) / sigma);
                    for c in 0..3 {
                        n[p][c] += share * mean(&factors, depth[c], Line::between(a, b)) / (sigma * TAU.sqrt());
                    }
                }
            }
        }
        n
    }

    /// N(φ) of TTˢ and TRTˢ, RGB. `distribution` holds D^s of both at every node, RGB. It includes the scattered
    /// fraction, as in the paper's tables (D5), and the absorption after scattering.
    #[doc(alias = "Eq. 25")]
    pub fn scattered(&self, distribution: &[[[f64; 3]; 2]]) -> [[f64; 3]; 2] {
        let mut n = [[0.0; 3]; 2];
        for (ends, share) in self.segments() {
            for p in 0..2 {
                let q = p as f64;
                for c in 0..3 {
                    let [first, last] = ends.map(|i| distribution[i][p][c]);
                    let mut factors = vec![Line::between(first, last), self.line(ends, |n| 1.0 - n.reflected)];
                    if p == 1 {
                        factors.push(self.line(ends, |n| n.reflected));
                    }
                    let (cortex, medulla) = (self.medium.cortex[c], self.medium.medulla[c]);
                    let depth = self.line(ends, |n| (2.0 * q + 1.0) * n.s_c * cortex + 2.0 * q * n.s_m * medulla);
                    n[p][c] += share * mean(&factors, depth, Line::between(0.0, 0.0));
                }
            }
        }
        n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_clipped_to_the_window() {
        assert_eq!(offsets([-1.0, 1.0], 1), [-1.0, 0.0, 1.0]);
        assert_eq!(offsets([-0.5, 0.75], 4), [-0.5, 0.0, 0.5, 0.5f64.sqrt(), 0.75]);
        assert_eq!(offsets([0.1, 0.2], 5), [0.1, 0.2]);
    }
}
