//! The smooth cross section: exit azimuths, densities, and the treatment of caustics.

use std::f64::consts::PI;

/// The cross section at a difference angle θ_d.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// η′ and η″, for light with perpendicular and parallel polarisation.
    pub eta: [f64; 2],
    /// asin 1/η′
    c: f64,
    /// 1/cos θ_t
    pub elongation: f64,
}

/// The exit azimuth of light that enters at γ, as a cubic polynomial.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic {
    linear: f64,
    cube: f64,
}

impl Cubic {
    /// The value at γ.
    pub fn at(&self, gamma: f64) -> f64 {
        gamma * (self.linear + self.cube * gamma * gamma)
    }

    /// The derivative at γ.
    pub fn slope(&self, gamma: f64) -> f64 {
        self.linear + 3.0 * self.cube * gamma * gamma
    }

    /// The largest absolute value within ±90°.
    fn reach(&self) -> f64 {
        let turn = (-self.linear / (3.0 * self.cube)).max(0.0).sqrt().min(0.5 * PI);
        self.at(0.5 * PI).abs().max(self.at(turn).abs())
    }

    /// All γ within ±90° that have this value, up to three.
    pub fn roots(&self, value: f64) -> impl Iterator<Item = f64> {
        let (p, q) = (self.linear / self.cube, -value / self.cube);
        let (half, third) = (0.5 * q, p / 3.0);
        let discriminant = half * half + third * third * third;
        let mut roots = [f64::NAN; 3];
        if discriminant >= 0.0 {
            // Compute the root without cancellation first.
            let u = (half.abs() + discriminant.sqrt()).cbrt() * -half.signum();
            roots[0] = if u == 0.0 { 0.0 } else { u - third / u };
        } else {
            let r = (-third).sqrt();
            let angle = (-half / (r * r * r)).clamp(-1.0, 1.0).acos() / 3.0;
            roots = [0.0, 1.0, 2.0].map(|k| 2.0 * r * (angle - k * 2.0 * PI / 3.0).cos());
        }
        roots.into_iter().filter(|gamma| gamma.abs() <= 0.5 * PI)
    }
}

impl Section {
    /// The cross section at θ_d (radians) for a refractive index.
    pub fn new(eta: f64, theta_d: f64) -> Self {
        let (sin, cos) = theta_d.sin_cos();
        let cos = cos.max(1e-4);
        let along = ((eta - sin) * (eta + sin)).max(1e-12).sqrt();
        let eta_prime = (along / cos).max(1.0 + 1e-9);
        Section { eta: [eta_prime, eta * eta * cos / along], c: (1.0 / eta_prime).asin(), elongation: eta / along }
    }

    /// Φ_p − pπ as a function of γ.
    pub fn cubic(&self, p: f64) -> Cubic {
        Cubic { linear: 6.0 * p * self.c / PI - 2.0, cube: -8.0 * p * self.c / PI.powi(3) }
    }

    /// The attenuation A of path p for light that enters at γ, RGB.
    pub fn attenuation(&self, p: usize, gamma: f64, sigma: [f32; 3]) -> [f64; 3] {
        let cos = gamma.cos().max(0.0);
        let sin_t = gamma.sin() / self.eta[0];
        let cos_t = (1.0 - sin_t * sin_t).max(0.0).sqrt();
        let across = (cos - self.eta[0] * cos_t) / (cos + self.eta[0] * cos_t);
        let along = (self.eta[1] * cos - cos_t) / (self.eta[1] * cos + cos_t);
        let f = (0.5 * (across * across + along * along)).min(1.0);
        if p == 0 {
            return [f; 3];
        }
        let length = 2.0 * p as f64 * cos_t * self.elongation;
        sigma.map(|s| (1.0 - f).powi(2) * f.powi(p as i32 - 1) * (-f64::from(s) * length).exp())
    }

    /// N_p(φ), RGB, for φ in [−π, π], with unsmoothed caustics. The second value is the same without attenuation.
    pub fn smooth(&self, p: usize, phi: f64, sigma: [f32; 3]) -> ([f64; 3], f64) {
        if p == 0 {
            // π in single precision is larger than π, where the cosine is negative.
            let density = 0.25 * (0.5 * phi).cos().max(0.0);
            return (self.attenuation(0, -0.5 * phi, sigma).map(|a| a * density), density);
        }
        let cubic = self.cubic(p as f64);
        let (mut n, mut all) = ([0.0; 3], 0.0);
        let relative = (phi - p as f64 * PI + PI).rem_euclid(2.0 * PI) - PI;
        let reach = cubic.reach();
        for value in [relative, relative - 2.0 * PI, relative + 2.0 * PI] {
            if value.abs() > reach {
                continue;
            }
            for gamma in cubic.roots(value) {
                let density = 0.5 * gamma.cos().max(0.0) / cubic.slope(gamma).abs().max(1e-6);
                let a = self.attenuation(p, gamma, sigma);
                (0..3).for_each(|c| n[c] += a[c] * density);
                all += density;
            }
        }
        (n, all)
    }

    /// The caustics of TRT, smoothed over the width `w` (radians).
    pub fn caustic(&self, w: f64) -> Caustic {
        let cubic = self.cubic(2.0);
        if cubic.linear > 0.0 {
            let gamma = (-cubic.linear / (3.0 * cubic.cube)).sqrt().min(0.5 * PI);
            let curvature = (6.0 * cubic.cube * gamma).abs() / gamma.cos().powi(2).max(1e-9);
            let dh = (2.0 * (2.0 * w / curvature.max(1e-12)).sqrt()).min(0.5);
            return Caustic { gamma, phi: cubic.at(gamma), dh, there: 1.0, w };
        }
        // There are no caustics for η′ > 2. The smoothing fades out over Δη′.
        let x = ((self.eta[0] - 2.0) / 0.2).clamp(0.0, 1.0);
        Caustic { gamma: 0.0, phi: 0.0, dh: 0.5, there: 1.0 - x * x * (3.0 - 2.0 * x), w }
    }

    /// N of TRT with smoothed caustics.
    pub fn trt(&self, phi: f64, sigma: [f32; 3], w: f64) -> [f64; 3] {
        let caustic = self.caustic(w);
        let (n, _) = self.smooth(2, phi, sigma);
        let (kept, back) = (caustic.kept(phi), self.attenuation(2, caustic.gamma, sigma));
        [0, 1, 2].map(|c| n[c] * kept + back[c] * caustic.put_back(phi))
    }
}

/// The two caustics of TRT, at ±φ_c.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caustic {
    /// γ_c
    pub gamma: f64,
    phi: f64,
    /// Δh
    dh: f64,
    /// t
    there: f64,
    w: f64,
}

impl Caustic {
    fn bell(&self, x: f64) -> f64 {
        let d = (x + PI).rem_euclid(2.0 * PI) - PI;
        (-0.5 * (d / self.w).powi(2)).exp()
    }

    /// The fraction of N that remains at φ.
    pub fn kept(&self, phi: f64) -> f64 {
        (1.0 - self.there * self.bell(phi - self.phi)) * (1.0 - self.there * self.bell(phi + self.phi))
    }

    /// The Gaussians that replace the caustics, at φ and without attenuation.
    fn put_back(&self, phi: f64) -> f64 {
        let bells = self.bell(phi - self.phi) + self.bell(phi + self.phi);
        self.there * 0.5 * self.dh * bells / (self.w * (2.0 * PI).sqrt())
    }

    /// The integral of [`Self::put_back`] over the circle.
    pub fn energy(&self) -> f64 {
        self.there * self.dh * libm::erf(PI / (self.w * 2f64.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All roots have the value φ, for every sign of the discriminant.
    #[test]
    fn roots_are_roots() {
        for eta in [1.2, 1.55, 2.4] {
            for p in [1.0, 2.0] {
                let cubic = Section::new(eta, 0.3).cubic(p);
                for k in 0..200 {
                    let gamma = (f64::from(k) / 199.0 - 0.5) * PI;
                    let value = cubic.at(gamma);
                    let nearest = cubic.roots(value).fold(f64::MAX, |a, root| a.min((root - gamma).abs()));
                    // A double root is found to the square root of a rounding.
                    assert!(nearest < 1e-6 || k == 0 || k == 199, "{eta} {p} {gamma}: {nearest}");
                    assert!(cubic.roots(value).all(|root| (cubic.at(root) - value).abs() < 1e-12));
                }
            }
        }
    }

    /// The cubic approximates Φ within 2° for hair at normal incidence, as in the paper's figure.
    #[test]
    fn cubic_stands_for_the_exit_azimuth() {
        let section = Section::new(1.55, 0.0);
        for p in [1.0, 2.0] {
            for k in 0..=100 {
                let gamma: f64 = (f64::from(k) / 50.0 - 1.0) * 0.5 * PI;
                let exact = 2.0 * p * (gamma.sin() / 1.55).asin() - 2.0 * gamma;
                assert!((section.cubic(p).at(gamma) - exact).abs() < p * 2f64.to_radians(), "{p} {gamma}");
            }
        }
    }
}
