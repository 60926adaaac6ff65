//! Azimuthal densities of eight lobes, per radian of φ, in one SIMD register.

use std::f32::consts::{PI, TAU};
use vellus::parts::{exp, normal_quantile, wrap};
use wide::f32x8;

/// Azimuthal densities of eight lobes around their centres.
pub trait Azimuthal: Copy {
    /// The densities at `phi` (radians).
    fn eval(&self, phi: f32) -> f32x8;
    /// Samples φ of one lobe, in radians, modulo 2π.
    fn sample(&self, lane: usize, u: f32) -> f32;
    /// The centre of each lobe, divided by a spacing. Copies of the lobe at this spacing add up to a constant within
    /// 3e-4. 0 for uniform lobes.
    fn exits(&self) -> [f32; 8];
}

/// Widths of Gaussians wrapped on the circle. They are prepared once per fibre. `None` is a uniform lobe.
#[derive(Clone, Debug)]
pub struct Gaussians {
    sigma: [Option<f32>; 8],
    exponent: f32x8,
    norm: f32x8,
    /// Number of pairs of images in the sum, in addition to the nearest image.
    images: u8,
}

/// Wrapped Gaussians with the centres of one hit.
#[derive(Clone, Copy, Debug)]
pub struct GaussiansAt<'m> {
    pub widths: &'m Gaussians,
    pub centre: f32x8,
}

impl Gaussians {
    pub fn new(sigma: [Option<f32>; 8]) -> Self {
        let widest = sigma.iter().flatten().fold(0.0f32, |a, &s| a.max(s));
        // Omitted images are at least (2·images + 1)π away. For widths of 0.64, 1.9 and 3.2 rad they are e⁻¹² of the
        // peak.
        let images = if widest < 0.64 {
            0
        } else if widest < 1.9 {
            1
        } else {
            2
        };
        let uniform = 1.0 / (TAU * f32::from(2 * images + 1));
        Gaussians {
            sigma,
            exponent: f32x8::new(sigma.map(|s| s.map_or(0.0, |s| -0.5 / (s * s)))),
            norm: f32x8::new(sigma.map(|s| s.map_or(uniform, |s| 1.0 / (s * TAU.sqrt())))),
            images,
        }
    }
}

impl Azimuthal for GaussiansAt<'_> {
    #[inline(always)]
    fn eval(&self, phi: f32) -> f32x8 {
        let d = wrap(f32x8::splat(phi) - self.centre);
        let mut sum = exp(d * d * self.widths.exponent);
        for image in 1..=self.widths.images {
            for turn in [TAU, -TAU] {
                let d = d + f32x8::splat(turn * f32::from(image));
                sum += exp(d * d * self.widths.exponent);
            }
        }
        sum * self.widths.norm
    }

    #[inline(always)]
    fn sample(&self, lane: usize, u: f32) -> f32 {
        match self.widths.sigma[lane] {
            Some(sigma) => self.centre.to_array()[lane] + sigma * normal_quantile(u),
            None => TAU * u,
        }
    }

    /// The sum of copies of a Gaussian at spacing d has a ripple of 2 exp(−2π²σ²/d²) (Poisson summation).
    fn exits(&self) -> [f32; 8] {
        let centre = self.centre.to_array();
        std::array::from_fn(|i| self.widths.sigma[i].map_or(0.0, |sigma| centre[i] / (1.5 * sigma)))
    }
}

/// Trimmed logistic densities with one scale (Chiang et al. 2016, Sec. 3.3). The lanes of `uniform` are uniform.
#[derive(Clone, Debug)]
pub struct Logistics {
    s: f32,
    /// Probability of [−π, π].
    inside: f32,
    /// The cumulative distribution at −π.
    below: f32,
    uniform: [bool; 8],
    /// 1/2π in uniform lanes, 0 in others.
    floor: f32x8,
    /// The factor that makes the integral 1. It is 0 in uniform lanes.
    norm: f32x8,
}

/// Logistics with the centres of one hit.
#[derive(Clone, Copy, Debug)]
pub struct LogisticsAt<'m> {
    pub widths: &'m Logistics,
    pub centre: f32x8,
}

impl Logistics {
    /// `s` is the scale, √3/π times the standard deviation.
    pub fn new(s: f32, uniform: [bool; 8]) -> Self {
        // F(π) − F(−π) = tanh(π/2s), where F is the cumulative distribution.
        let inside = (0.5 * PI / s).tanh();
        let below = 1.0 / (1.0 + (PI / s).exp());
        Logistics {
            s,
            inside,
            below,
            uniform,
            floor: f32x8::new(uniform.map(|u| if u { 1.0 / TAU } else { 0.0 })),
            norm: f32x8::new(uniform.map(|u| if u { 0.0 } else { 1.0 / (s * inside) })),
        }
    }
}

impl Azimuthal for LogisticsAt<'_> {
    #[inline(always)]
    fn eval(&self, phi: f32) -> f32x8 {
        let widths = self.widths;
        let d = wrap(f32x8::splat(phi) - self.centre).abs();
        let e = exp(d * f32x8::splat(-1.0 / widths.s));
        let one = f32x8::ONE + e;
        (e / (one * one)).mul_add(widths.norm, widths.floor)
    }

    #[inline(always)]
    fn sample(&self, lane: usize, u: f32) -> f32 {
        let Logistics { s, inside, below, .. } = *self.widths;
        if self.widths.uniform[lane] {
            return TAU * u;
        }
        let v = (below + u * inside).clamp(1e-7, 1.0 - 1e-7);
        self.centre.to_array()[lane] + (s * (v / (1.0 - v)).ln()).clamp(-PI, PI)
    }

    /// The sum of copies of a logistic at spacing d has a ripple of 2x/sinh x, x = 2π²s/d.
    fn exits(&self) -> [f32; 8] {
        let centre = self.centre.to_array();
        std::array::from_fn(|i| if self.widths.uniform[i] { 0.0 } else { centre[i] / (1.64 * self.widths.s) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral(around: &impl Azimuthal) -> [f64; 8] {
        let n = 40_000;
        let mut sum = [0.0; 8];
        for k in 0..n {
            let phi = (k as f32 + 0.5) / n as f32 * TAU;
            let values = around.eval(phi).to_array();
            (0..8).for_each(|i| sum[i] += f64::from(values[i] * TAU) / f64::from(n));
        }
        sum
    }

    /// Ignored images have e⁻¹² of a lobe. φ has a rounding error of 2e-7, which is 1e-4 of the narrowest width, 2e-3.
    #[test]
    fn lobes_integrate_to_one() {
        let centre = f32x8::new([0.1, 1.0, -2.0, 3.1, 2.0, 0.0, -3.1, 5.0]);
        for s in [0.002f32, 0.1, 0.6, 0.7, 1.8, 2.0, 2.7] {
            let mut sigma = [Some(s); 8];
            sigma[3] = None;
            let widths = Gaussians::new(sigma);
            for total in integral(&GaussiansAt { widths: &widths, centre }) {
                assert!((total - 1.0).abs() < 1e-4, "{s}: {total}");
            }
            let widths = Logistics::new(s, sigma.map(|s| s.is_none()));
            for total in integral(&LogisticsAt { widths: &widths, centre }) {
                assert!((total - 1.0).abs() < 1e-4, "{s}: {total}");
            }
        }
    }

    /// dφ/du · D(φ) = 1, by central differences. Their error is (step/u)², where u is the distance from the nearer end.
    #[test]
    fn pdf_is_jacobian_of_sample() {
        let (gaussians, logistics) = (Gaussians::new([Some(0.2); 8]), Logistics::new(0.3, [false; 8]));
        let centre = f32x8::splat(0.7);
        fn check(around: &impl Azimuthal) {
            for u in [0.02f32, 0.3, 0.5, 0.81, 0.98] {
                let step = 1e-3;
                let slope = (around.sample(2, u + step) - around.sample(2, u - step)) / (2.0 * step);
                let product = slope * around.eval(around.sample(2, u)).to_array()[2];
                assert!((product - 1.0).abs() < 1e-3 + (step / u.min(1.0 - u)).powi(2), "{u}: {product}");
            }
        }
        check(&GaussiansAt { widths: &gaussians, centre });
        check(&LogisticsAt { widths: &logistics, centre });
    }
}
