//! One hit of the fibre at one offset (Yan17 Eq. 12).

use super::exit::diffuse;
use super::formulas::wrapped_cauchy;
use super::inclination::Inclination;
use super::{ExactPath, Profile};
use std::f64::consts::{PI, TAU};

/// One hit of the fibre, with the profiles of the medulla.
#[derive(Clone, Debug)]
pub struct ExactHit<'e, 't> {
    pub(super) path: ExactPath<'e, 't>,
    /// C^N, divided so that its product with C^M integrates to 1.
    pub(super) azimuthal: Profile,
    pub(super) longitudinal: Inclination,
}

/// C^N at the azimuth `relative` from straight back, times C^M interpolated between its two halves there, and times the
/// derivative of that azimuth.
pub(crate) fn scattered(azimuthal: &Profile, (relative, slope): (f64, f64), [back, front]: [f64; 2]) -> f64 {
    let weight = relative.abs() / PI;
    slope * azimuthal.eval(relative.rem_euclid(TAU)) * ((1.0 - weight) * back + weight * front)
}

impl ExactHit<'_, '_> {
    /// A(h), the share of the light that each of the six lobes carries, RGB, in [0, 1].
    pub fn energy(&self) -> [[f64; 3]; 6] {
        self.path.attenuation
    }

    /// The six lobes at inclination θᵢ and azimuth φ = φ_i − φ_o (radians), each a density over solid angle that
    /// integrates to 1. The last one is that of light that the medulla did not scatter.
    pub fn densities(&self, theta_i: f64, phi: f64) -> [f64; 6] {
        let path = &self.path;
        let m = path.exact.longitudinal(path.theta_o, theta_i);
        let n = path.unscattered(phi);
        let halves = self.longitudinal.eval(theta_i);
        let s = |p| scattered(&self.azimuthal, path.relative(p, phi), halves);
        [m[0] * n[0], m[1] * n[1], m[2] * n[2], s(1), s(2), m[3] / TAU]
    }

    /// N(φ) of the six lobes, RGB, per radian: the light that leaves at the azimuth φ = φ_i − φ_o at any inclination.
    pub fn azimuthal(&self, phi: f64) -> [[f64; 3]; 6] {
        let path = &self.path;
        let n = path.unscattered(phi);
        let s = |p| scattered(&self.azimuthal, path.relative(p, phi), self.longitudinal.leaving());
        let d = [n[0], n[1], n[2], s(1), s(2), 1.0 / TAU];
        path.lobes(d, wrapped_cauchy(path.later(), phi))
    }

    /// f·cos θᵢ of the six lobes at inclination θᵢ and azimuth φ = φ_i − φ_o (radians), RGB.
    pub fn eval(&self, theta_i: f64, phi: f64) -> [[f64; 3]; 6] {
        let diffuse = diffuse(theta_i) * wrapped_cauchy(self.path.later(), phi);
        self.path.lobes(self.densities(theta_i, phi), diffuse)
    }
}
