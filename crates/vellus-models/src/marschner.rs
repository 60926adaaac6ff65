//! S. R. Marschner, H. W. Jensen, M. Cammarano, S. Worley, P. Hanrahan 2003, *Light Scattering from Human Hair Fibers*, ACM TOG 22(3).
//!
//! Far field: the window is ignored. S = Σ M_p N_p/cos²θ_d for R, TT, TRT, with a smooth surface around the fibre: light leaves at φ from
//! the roots of Φ_p(h) = φ, by the paper's cubic in γ, with the density |2 dΦ/dh|⁻¹. Where that is infinite, at the caustics of TRT, the
//! paper takes out a Gaussian's width of light and puts back a Gaussian: the same constants here, Δη′ = 0.2, Δh ≤ 0.5, and k_G = ½,
//! which puts back what was taken out of an isolated caustic.
//!
//! Of a [`Fiber`] it takes η, σ_c,a, α and β_m. The paper's shifts and widths belong to the half angle θ_h and are half of
//! ours; its unit Gaussian in θ_h would hold twice the light, so ours is the unit Gaussian in θᵢ. The caustic's width w_c is √3 β_n, that
//! of our TRT. T is exp(−2σ cos γ_t/cos θ_t), where the paper prints 1 + cos 2γ_t. κ, σ_m, g and l are ignored.
//!
//! Reciprocal for α = 0. Limits: no higher orders; energy is lost, and gained, where Gaussians come near ±90° (cos²θᵢ/cos²θ_d) and at the
//! caustics (TRT of hair, whose two are 40° apart, keeps 0.6 of its light); the tests say how much. Below η = 1.155 the cubic has caustics in TT that nothing smooths. TRT is sampled uniformly around.

use crate::along::{Along, Plane};
use crate::factored::{choose, direction, weight};
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};
use std::f64::consts::PI;
use std::sync::OnceLock;
use vellus::parts::{Frame, Outgoing, Polar, wrap};
use vellus::{Error, Fiber, Field, Lobe, Lobes, Model, Sample, Scattering, Window};
use wide::f32x8;

const LOBES: [Lobe; 3] = [Lobe::R, Lobe::Tt, Lobe::Trt];

/// The cross section at a difference angle θ_d.
#[derive(Clone, Copy, Debug)]
struct Section {
    /// η′ and η″ for light polarised across and along.
    eta: [f64; 2],
    /// asin 1/η′
    c: f64,
    /// 1/cos θ_t
    elongation: f64,
}

/// Where light that enters at γ leaves: the cubic and its slope.
#[derive(Clone, Copy, Debug)]
struct Cubic {
    linear: f64,
    cube: f64,
}

impl Cubic {
    fn at(&self, gamma: f64) -> f64 {
        gamma * (self.linear + self.cube * gamma * gamma)
    }

    fn slope(&self, gamma: f64) -> f64 {
        self.linear + 3.0 * self.cube * gamma * gamma
    }

    /// The largest value it has within ±90°.
    fn reach(&self) -> f64 {
        let turn = (-self.linear / (3.0 * self.cube)).max(0.0).sqrt().min(0.5 * PI);
        self.at(0.5 * PI).abs().max(self.at(turn).abs())
    }

    /// All γ in ±90° with that value, up to three.
    fn roots(&self, value: f64) -> impl Iterator<Item = f64> {
        let (p, q) = (self.linear / self.cube, -value / self.cube);
        let (half, third) = (0.5 * q, p / 3.0);
        let discriminant = half * half + third * third * third;
        let mut roots = [f64::NAN; 3];
        if discriminant >= 0.0 {
            // The sum that does not cancel first.
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
    fn new(eta: f64, theta_d: f64) -> Self {
        let (sin, cos) = theta_d.sin_cos();
        let cos = cos.max(1e-4);
        let along = ((eta - sin) * (eta + sin)).max(1e-12).sqrt();
        let eta_prime = (along / cos).max(1.0 + 1e-9);
        Section { eta: [eta_prime, eta * eta * cos / along], c: (1.0 / eta_prime).asin(), elongation: eta / along }
    }

    /// Φ_p − pπ over γ.
    fn cubic(&self, p: f64) -> Cubic {
        Cubic { linear: 6.0 * p * self.c / PI - 2.0, cube: -8.0 * p * self.c / PI.powi(3) }
    }

    /// A of path p for light entering at γ, RGB.
    fn attenuation(&self, p: usize, gamma: f64, sigma: [f32; 3]) -> [f64; 3] {
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

    /// N_p(φ), RGB, φ in [−π, π], with the caustics as they are; and the same without attenuation.
    fn smooth(&self, p: usize, phi: f64, sigma: [f32; 3]) -> ([f64; 3], f64) {
        if p == 0 {
            // π rounded up to single precision lies beyond the edge.
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

    /// N of TRT with the caustics smoothed over the width `w`.
    fn trt(&self, phi: f64, sigma: [f32; 3], w: f64) -> [f64; 3] {
        let eta_prime = self.eta[0];
        let cubic = self.cubic(2.0);
        // The caustic, while there is one; beyond η′ = 2 it fades over Δη′.
        let (gamma_c, phi_c, dh, t) = if cubic.linear > 0.0 {
            let gamma = (-cubic.linear / (3.0 * cubic.cube)).sqrt().min(0.5 * PI);
            let curvature = (6.0 * cubic.cube * gamma).abs() / gamma.cos().powi(2).max(1e-9);
            (gamma, cubic.at(gamma), (2.0 * (2.0 * w / curvature.max(1e-12)).sqrt()).min(0.5), 1.0)
        } else {
            let x = ((eta_prime - 2.0) / 0.2).clamp(0.0, 1.0);
            (0.0, 0.0, 0.5, 1.0 - x * x * (3.0 - 2.0 * x))
        };
        let (mut n, _) = self.smooth(2, phi, sigma);
        if t > 0.0 {
            let bell = |x: f64| {
                let d = (x + PI).rem_euclid(2.0 * PI) - PI;
                (-0.5 * (d / w).powi(2)).exp()
            };
            let (a, b) = (bell(phi - phi_c), bell(phi + phi_c));
            let back = self.attenuation(2, gamma_c, sigma);
            let glint = t * 0.5 * dh * (a + b) / (w * (2.0 * PI).sqrt());
            (0..3).for_each(|c| n[c] = n[c] * (1.0 - t * a) * (1.0 - t * b) + back[c] * glint);
        }
        n
    }
}

/// Nodes of θ_d over 90° of the table of energies, and of φ it is integrated at.
const THETAS: usize = 46;
const PHIS: usize = 720;

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct Marschner2003 {
    eta: f64,
    sigma_a: [f32; 3],
    shift: f32x8,
    sigma: f32x8,
    caustic: f64,
    /// ∫ N_p dφ over θ_d, when first asked for.
    energies: OnceLock<Vec<[[f64; 3]; 3]>>,
}

impl Marschner2003 {
    /// Prepares a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let lanes = |of: [f32; 3]| f32x8::new(std::array::from_fn(|i| of[i.min(2)]));
        Ok(Marschner2003 {
            eta: fiber.eta.into(),
            sigma_a: fiber.sigma_ca,
            shift: lanes([1.0, -0.5, -1.5].map(|k| k * fiber.alpha)),
            sigma: lanes([1.0, 0.5, 1.5].map(|k| k * fiber.beta_m)),
            caustic: 3f64.sqrt() * f64::from(fiber.beta_n),
            energies: OnceLock::new(),
        })
    }

    fn azimuthal(&self, section: &Section, p: usize, phi: f64) -> [f64; 3] {
        if p == 2 { section.trt(phi, self.sigma_a, self.caustic) } else { section.smooth(p, phi, self.sigma_a).0 }
    }

    /// ∫ N_p dφ of all three at θ_d, RGB.
    fn energy(&self, theta_d: f64) -> [[f64; 3]; 3] {
        let table = self.energies.get_or_init(|| {
            let step = 0.5 * PI / (THETAS - 1) as f64;
            let row = |k: usize| {
                let section = Section::new(self.eta, k as f64 * step);
                std::array::from_fn(|p| {
                    // φ and −φ are alike.
                    let phis = (0..PHIS).map(|j| (j as f64 + 0.5) * PI / PHIS as f64);
                    phis.fold([0.0; 3], |sum: [f64; 3], phi| {
                        let n = self.azimuthal(&section, p, phi);
                        [0, 1, 2].map(|c| sum[c] + n[c] * 2.0 * PI / PHIS as f64)
                    })
                })
            };
            (0..THETAS).map(row).collect()
        });
        let x = theta_d.abs() / (0.5 * PI) * (THETAS - 1) as f64;
        let i = (x as usize).min(THETAS - 2);
        let t = x - i as f64;
        std::array::from_fn(|p| [0, 1, 2].map(|c| table[i][p][c] * (1.0 - t) + table[i + 1][p][c] * t))
    }
}

/// One hit of a fibre.
#[derive(Clone, Copy, Debug)]
pub struct Marschner2003Hit<'m> {
    model: &'m Marschner2003,
    frame: Frame<f32>,
    theta_o: f32,
    along: Plane,
    probability: [f32; 3],
}

impl Model for Marschner2003 {
    type Hit<'a> = Marschner2003Hit<'a>;

    fn at(&self, wo: Vec3, _: Window) -> Marschner2003Hit<'_> {
        let wo = wo.to_array();
        let polar = Polar::new(wo);
        let theta_o = polar.sin.atan2(polar.cos);
        let section = Section::new(self.eta, theta_o.into());
        // Mean of A over h, by four Gauss points in h over one side.
        const GAUSS: [(f64, f64); 4] = [
            (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
            (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
            (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
            (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
        ];
        let mean = |p: usize| -> f32 {
            GAUSS
                .iter()
                .map(|&(h, w)| section.attenuation(p, h.asin(), self.sigma_a).into_iter().fold(0.0, f64::max) * w)
                .sum::<f64>() as f32
        };
        let probability = [mean(0), mean(1), mean(2)].map(|p| p.max(1e-12));
        let scale = 1.0 / probability.iter().sum::<f32>();
        Marschner2003Hit {
            model: self,
            frame: Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12)),
            theta_o,
            along: Plane::new(f32x8::splat(-theta_o) - self.shift, self.sigma),
            probability: probability.map(|p| p * scale),
        }
    }

    fn field(&self) -> Field {
        Field::Far
    }
}

impl Marschner2003Hit<'_> {
    fn section(&self, theta_i: f32) -> (Section, f64) {
        let theta_d = 0.5 * f64::from(theta_i - self.theta_o);
        (Section::new(self.model.eta, theta_d), theta_d)
    }

    fn eval_outgoing(&self, o: &Outgoing<f32>) -> (Lobes, f32) {
        let (section, theta_d) = self.section(o.theta_i);
        let phi = f64::from(wrap(o.phi));
        let (along, inside) = (self.along.eval(o).to_array(), self.along.inside().to_array());
        // M cos θᵢ/cos²θ_d from the normalised density in sin θᵢ, g/(inside·cos θᵢ).
        let geometry = (o.cos_i / theta_d.cos().max(1e-6) as f32).powi(2);
        let mut lobes = Lobes([[0.0; 3]; 6]);
        let mut pdf = 0.0;
        for p in 0..3 {
            let (smooth, all) = if p < 2 { section.smooth(p, phi, self.model.sigma_a) } else { ([0.0; 3], 0.0) };
            let n = if p < 2 { smooth } else { section.trt(phi, self.model.sigma_a, self.model.caustic) };
            let around = if p < 2 { all as f32 } else { 0.5 * FRAC_1_PI };
            let m = along[p] * inside[p] * geometry;
            lobes.0[LOBES[p] as usize] = n.map(|n| m * n as f32);
            pdf += self.probability[p] * along[p] * around;
        }
        (lobes, pdf)
    }
}

impl Scattering for Marschner2003Hit<'_> {
    fn energy(&self) -> Lobes {
        let inside = self.along.inside().to_array();
        let mut lobes = Lobes([[0.0; 3]; 6]);
        let n = 64;
        for k in 0..n {
            let u = (k as f32 + 0.5) / n as f32;
            for p in 0..3 {
                let (sin_i, cos_i) = self.along.sample(p, [u, 0.5]);
                let (_, theta_d) = self.section(sin_i.atan2(cos_i));
                let geometry = (cos_i / theta_d.cos().max(1e-6) as f32).powi(2) * inside[p] / n as f32;
                let energy = self.model.energy(theta_d)[p];
                (0..3).for_each(|c| lobes.0[LOBES[p] as usize][c] += energy[c] as f32 * geometry);
            }
        }
        lobes
    }

    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_outgoing(&self.frame.outgoing(wi.to_array()))
    }

    fn sample(&self, u: [f32; 5]) -> Sample {
        let (p, _) = choose(&self.probability, u[0]);
        let (sin_i, cos_i) = self.along.sample(p, [u[1], u[2]]);
        let theta_i = sin_i.atan2(cos_i);
        // R and TT from a uniform offset, h = sin γ.
        let gamma = f64::from(2.0 * u[3] - 1.0).asin();
        let phi = match p {
            0 => -2.0 * gamma as f32,
            1 => (self.section(theta_i).0.cubic(1.0).at(gamma) + PI) as f32,
            _ => TAU * u[3],
        };
        let outgoing = Outgoing { sin_i, cos_i, theta_i, phi };
        let (lobes, pdf) = self.eval_outgoing(&outgoing);
        let weight = weight(lobes.total(), pdf);
        Sample { wi: direction(&self.frame, &outgoing), pdf, weight, lobe: LOBES[p], h: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All roots, for every sign of the discriminant, lead back to φ.
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

    /// The cubic stands for Φ: within 2° for hair, as the paper's figure has it, at normal incidence.
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
