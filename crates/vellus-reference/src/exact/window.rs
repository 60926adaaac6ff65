//! The average over a window of offsets by the midpoint rule (Yan17 Eq. 11, 22, 26).

use super::exit::diffuse;
use super::formulas::wrapped_cauchy;
use super::hit::scattered;
use super::inclination::Inclination;
use super::{Exact, ExactPath, Profile};
use std::f64::consts::TAU;

/// The model averaged over a window of offsets.
#[derive(Clone, Debug)]
pub struct ExactWindow<'e, 't> {
    theta_o: f64,
    /// Paths over the window, and the share of its width that each represents.
    paths: Vec<(ExactPath<'e, 't>, f64)>,
    /// Paths over the medulla, their share, and C^N, divided so that its product with C^M integrates to 1.
    points: Vec<(ExactPath<'e, 't>, f64, Profile)>,
    longitudinal: Inclination,
    /// The mean of cos φ and sin φ over light that leaves later, in the brightest channel of each path.
    later: [f64; 2],
}

impl<'t> Exact<'t> {
    /// Averages over the offsets from `h1` to `h2` > `h1` within [−1, 1]. `theta_o` is in radians.
    ///
    /// TTˢ and TRTˢ take `points` offsets, equidistant in asin h″. The other lobes take `paths` offsets, equidistant in
    /// γ = asin h. Either number may be 0: those lobes are then 0.
    #[doc(alias = "Eq. 26")]
    pub fn window(&self, theta_o: f64, [h1, h2]: [f64; 2], paths: usize, points: usize) -> ExactWindow<'_, 't> {
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
        let longitudinal = self.inclination(theta_o);
        let leaving = longitudinal.leaving();
        let paths: Vec<_> = midpoints(h1, h2, 1.0, paths).map(|(h, w)| (self.path(theta_o, h), w)).collect();
        ExactWindow {
            theta_o,
            later: later(&paths),
            paths,
            points: midpoints(h1.max(-r), h2.min(r), r.max(1e-9), if scatters { points } else { 0 })
                .map(|(h, w)| (self.path(theta_o, h), w, self.azimuthal_profile(theta_o, h).over_leaving(leaving)))
                .collect(),
            longitudinal,
        }
    }
}

/// See [`ExactWindow::later`].
fn later(paths: &[(ExactPath<'_, '_>, f64)]) -> [f64; 2] {
    let (mut sum, mut light) = ([0.0; 2], 0.0);
    for (path, w) in paths {
        let most = w * path.diffuse.iter().copied().fold(0.0, f64::max);
        light += most;
        sum.iter_mut().zip(path.later()).for_each(|(sum, x)| *sum += most * x);
    }
    sum.map(|x| x / f64::max(light, 1e-300))
}

impl ExactWindow<'_, '_> {
    /// The share of the light that each of the six lobes carries, averaged over the window, RGB, in [0, 1].
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

    /// N(φ) of the six lobes, RGB, per radian: the light that leaves at the azimuth φ = φ_i − φ_o at any inclination.
    #[doc(alias = "Eq. 11")]
    pub fn azimuthal(&self, phi: f64) -> [[f64; 3]; 6] {
        self.sum(phi, [1.0; 4], self.longitudinal.leaving(), 1.0)
    }

    /// f·cos θᵢ of the six lobes at inclination θᵢ and azimuth φ = φ_i − φ_o (radians), RGB. All 0 without `paths`.
    pub fn eval(&self, theta_i: f64, phi: f64) -> [[f64; 3]; 6] {
        let Some((first, _)) = self.paths.first() else { return [[0.0; 3]; 6] };
        let m = first.exact.longitudinal(self.theta_o, theta_i);
        self.sum(phi, m, self.longitudinal.eval(theta_i), diffuse(theta_i))
    }

    /// `diffuse`: the density over sin θᵢ of light that leaves later.
    fn sum(&self, phi: f64, m: [f64; 4], halves: [f64; 2], diffuse: f64) -> [[f64; 3]; 6] {
        let diffuse = diffuse * wrapped_cauchy(self.later, phi);
        let mut sum = [[0.0; 3]; 6];
        let mut add = |p: usize, a: &[f64; 3], density: f64| (0..3).for_each(|c| sum[p][c] += a[c] * density);
        for (path, w) in &self.paths {
            let n = path.unscattered(phi);
            (0..3).for_each(|p| add(p, &path.attenuation[p], w * m[p] * n[p]));
            add(5, &path.attenuation[5], w * m[3] / TAU);
            add(5, &path.diffuse, w * (diffuse - m[3] / TAU));
        }
        for (path, w, profile) in &self.points {
            for p in [1, 2] {
                add(2 + p, &path.attenuation[2 + p], w * scattered(profile, path.relative(p, phi), halves));
            }
        }
        sum
    }
}
