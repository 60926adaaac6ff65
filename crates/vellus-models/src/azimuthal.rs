//! Eight lobes around the fibre: densities per radian of the azimuth φ, evaluated together.

use std::f32::consts::{PI, TAU};
use vellus::parts::{exp, normal_quantile, wrap};
use wide::f32x8;

/// Eight densities around their centres.
pub trait Around: Copy {
    fn eval(&self, phi: f32) -> f32x8;
    /// Draws φ of one of them; any turn of the circle.
    fn sample(&self, lane: usize, u: f32) -> f32;
    /// Their centres, each over the distance at which copies of it add up to a constant within 3e-4; 0 where it is uniform.
    fn exits(&self) -> [f32; 8];
}

/// Gaussians wrapped on the circle; a width of `None` is a uniform lobe. Prepared once a fibre.
#[derive(Clone, Debug)]
pub struct Gaussians {
    sigma: [Option<f32>; 8],
    exponent: f32x8,
    norm: f32x8,
    /// Pairs of images beyond the nearest that are summed.
    images: u8,
}

/// The same around the centres of one hit.
#[derive(Clone, Copy, Debug)]
pub struct GaussiansAt<'m> {
    pub widths: &'m Gaussians,
    pub centre: f32x8,
}

impl Gaussians {
    pub fn new(sigma: [Option<f32>; 8]) -> Self {
        let widest = sigma.iter().flatten().fold(0.0f32, |a, &s| a.max(s));
        // What is left out lies (2·images + 1)π away or farther: e⁻¹² of the peak at 0.64, 1.9 and 3.2 rad.
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

impl Around for GaussiansAt<'_> {
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

    /// Copies of a Gaussian at a distance d ripple by 2 exp(−2π²σ²/d²) (Poisson's sum).
    fn exits(&self) -> [f32; 8] {
        let centre = self.centre.to_array();
        std::array::from_fn(|i| self.widths.sigma[i].map_or(0.0, |sigma| centre[i] / (1.5 * sigma)))
    }
}

/// Trimmed logistic densities of one width (Chiang et al. 2016, Sec. 3.3), the lanes of `uniform` excepted.
#[derive(Clone, Debug)]
pub struct Logistics {
    s: f32,
    /// What of the logistic lies in [−π, π].
    inside: f32,
    /// The cumulative logistic at −π.
    below: f32,
    uniform: [bool; 8],
    /// 1/2π in the uniform lanes, and the factor that makes the others integrate to 1.
    floor: f32x8,
    norm: f32x8,
}

/// The same around the centres of one hit.
#[derive(Clone, Copy, Debug)]
pub struct LogisticsAt<'m> {
    pub widths: &'m Logistics,
    pub centre: f32x8,
}

impl Logistics {
    /// `s` is the logistic's scale, √3/π of its standard deviation.
    pub fn new(s: f32, uniform: [bool; 8]) -> Self {
        // F(π) − F(−π) = tanh(π/2s), F the cumulative logistic.
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

impl Around for LogisticsAt<'_> {
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

    /// Copies of a logistic ripple by 2x/sinh x, x = 2π²s/d.
    fn exits(&self) -> [f32; 8] {
        let centre = self.centre.to_array();
        std::array::from_fn(|i| if self.widths.uniform[i] { 0.0 } else { centre[i] / (1.64 * self.widths.s) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integral(around: &impl Around) -> [f64; 8] {
        let n = 40_000;
        let mut sum = [0.0; 8];
        for k in 0..n {
            let phi = (k as f32 + 0.5) / n as f32 * TAU;
            let values = around.eval(phi).to_array();
            (0..8).for_each(|i| sum[i] += f64::from(values[i] * TAU) / f64::from(n));
        }
        sum
    }

    /// The images left out hold e⁻¹² of a lobe; φ rounds at 2e-7, of the narrowest width 2e-3 a ten-thousandth.
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

    /// dφ/du · D(φ) = 1, by central differences: their error is (step/u)², u the distance from either end.
    #[test]
    fn pdf_is_jacobian_of_sample() {
        let (gaussians, logistics) = (Gaussians::new([Some(0.2); 8]), Logistics::new(0.3, [false; 8]));
        let centre = f32x8::splat(0.7);
        fn check(around: &impl Around) {
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
