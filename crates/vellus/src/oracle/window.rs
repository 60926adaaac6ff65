//! A window of offsets by brute force: midpoints in the angle (Yan17 Eq. 11, 26).

use super::{Oracle, OraclePath, Profile, halves, scattered};
use std::f64::consts::TAU;

/// The model averaged over a window of offsets.
#[derive(Clone, Debug)]
pub struct OracleWindow<'o, 't> {
    theta_o: f64,
    /// Paths over the window, and the share of its width each stands for.
    paths: Vec<(OraclePath<'o, 't>, f64)>,
    /// Paths over the medulla, their share and profile.
    points: Vec<(OraclePath<'o, 't>, f64, Profile)>,
    longitudinal: [Profile; 2],
}

impl<'t> Oracle<'t> {
    /// Prepares the offsets from `h1` to `h2` > `h1`, with so many `paths`, equidistant in γ = asin h, for all
    /// but the scattered lobes, and so many `points`, equidistant in asin h″, for those.
    pub fn window(&self, theta_o: f64, [h1, h2]: [f64; 2], paths: usize, points: usize) -> OracleWindow<'_, 't> {
        let width = h2 - h1;
        // h = r sin ψ over [low, high]: the offsets, and their dh over the width.
        let midpoints = |low: f64, high: f64, r: f64, n: usize| {
            let [a, b] = [low, high].map(|h| (h / r).clamp(-1.0, 1.0).asin());
            (0..n).map(move |k| {
                let psi = a + (b - a) * (k as f64 + 0.5) / n as f64;
                (r * psi.sin(), r * psi.cos() * (b - a) / (n as f64 * width))
            })
        };
        let r = (self.kappa * self.eta_prime(theta_o)).min(1.0);
        let scatters = self.kappa * self.sigma_ms > 0.0 && h1.max(-r) < h2.min(r);
        OracleWindow {
            theta_o,
            paths: midpoints(h1, h2, 1.0, paths).map(|(h, w)| (self.path(theta_o, h), w)).collect(),
            points: midpoints(h1.max(-r), h2.min(r), r.max(1e-9), if scatters { points } else { 0 })
                .map(|(h, w)| (self.path(theta_o, h), w, self.azimuthal_profile(theta_o, h)))
                .collect(),
            longitudinal: self.longitudinal_profiles(theta_o),
        }
    }
}

impl OracleWindow<'_, '_> {
    /// A of the six lobes averaged over the window, RGB.
    pub fn energy(&self) -> [[f64; 3]; 6] {
        let mut energy = [[0.0; 3]; 6];
        let all = self.paths.iter().map(|(path, w)| (path, w, [0, 1, 2, 5].as_slice()));
        let scattered = self.points.iter().map(|(path, w, _)| (path, w, [3, 4].as_slice()));
        for (path, w, lobes) in all.chain(scattered) {
            for &p in lobes {
                (0..3).for_each(|c| energy[p][c] += w * path.attenuation[p][c]);
            }
        }
        energy
    }

    /// N(φ) of the six lobes, RGB: what leaves at an azimuth, whatever its inclination.
    pub fn azimuthal(&self, phi: f64) -> [[f64; 3]; 6] {
        self.sum(phi, [1.0; 4], [1.0; 2])
    }

    /// f·cos θᵢ of the six lobes, RGB.
    pub fn eval(&self, theta_i: f64, phi: f64) -> [[f64; 3]; 6] {
        let Some((first, _)) = self.paths.first() else { return [[0.0; 3]; 6] };
        let m = first.oracle.longitudinal(self.theta_o, theta_i);
        self.sum(phi, m, halves(&self.longitudinal, self.theta_o, theta_i))
    }

    fn sum(&self, phi: f64, m: [f64; 4], halves: [f64; 2]) -> [[f64; 3]; 6] {
        let mut sum = [[0.0; 3]; 6];
        let mut add = |p: usize, a: &[f64; 3], density: f64| (0..3).for_each(|c| sum[p][c] += a[c] * density);
        for (path, w) in &self.paths {
            let n = path.unscattered(phi);
            (0..3).for_each(|p| add(p, &path.attenuation[p], w * m[p] * n[p]));
            add(5, &path.attenuation[5], w * m[3] / TAU);
        }
        for (path, w, profile) in &self.points {
            for p in [1, 2] {
                add(2 + p, &path.attenuation[2 + p], w * scattered(profile, path.relative(p, phi), halves));
            }
        }
        sum
    }
}
