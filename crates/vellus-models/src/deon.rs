//! E. d'Eon, G. Francois, M. Hill, J. Letteri, J.-M. Aubry 2011, *An Energy-Conserving Hair Reflectance Model*, Computer Graphics Forum 30(4);
//! sampling after d'Eon, Marschner, Hanika 2013.
//!
//! Far field: the window is ignored. Along the fibre the spherical Gaussian M̂ that integrates to 1 at every angle; around it a rough
//! surface: N_p(φ) = ½ ∫ A_p(h) G(φ − Φ_p(h); √(p+1) β_n) dh over h, here by quadrature in asin h as dense as the lobe is narrow, into a table over φ and θ_d (some
//! 10 ms a fibre; the paper has 70 Gauss points a query, or a table as well). Fresnel and absorption at θ_d, as printed.
//!
//! R, TT, TRT and TRRT, the last as `rest`. Of a [`Fiber`] it takes η, σ_c,a, α, β_m, β_n (shifts and widths of Yan17 Table 2); κ, σ_m, g and
//! l are ignored.
//!
//! Limits: below β_n = 0.3° the table is too coarse. (1 − F) F³ T³ of the light, the orders left out, is lost, and as attenuations belong to θ_d, which varies
//! over a lobe, energy is conserved to second order in β_m only. M̂ N is symmetric in the directions for α = 0.

use crate::along::{Along, Spherical, SphericalAt};
use crate::factored::{choose, direction, weight};
use glam::Vec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;
use vellus::oracle::fresnel;
use vellus::parts::{Frame, Outgoing, Polar, wrap};
use vellus::{Error, Fiber, Field, Lobe, Lobes, Model, Sample, Scattering, Window};

const LOBES: [Lobe; 4] = [Lobe::R, Lobe::Tt, Lobe::Trt, Lobe::Rest];
/// Nodes of θ_d, over [0°, 90°].
const THETAS: usize = 31;

/// N_p over φ in [0, π] for each θ_d.
#[derive(Clone, Debug)]
struct Azimuths {
    phis: usize,
    /// RGB, and the largest channel, by which it is sampled; φ fastest, then p, then θ_d.
    values: Vec<[f32; 4]>,
    /// Cumulative integrals over φ of the largest channel, in the same order.
    cumulative: Vec<f32>,
    /// ∫ N_p dφ over the whole circle, RGB and largest channel; p, then θ_d.
    energies: Vec<[f32; 4]>,
}

/// Φ_p(h) and A_p(h), RGB, of p = 0 … 3.
fn path(fiber: &Fiber, theta_d: f64, gamma: f64) -> [(f64, [f64; 3]); 4] {
    let eta = f64::from(fiber.eta);
    let (sin, cos) = theta_d.sin_cos();
    let along = ((eta - sin) * (eta + sin)).max(1e-12).sqrt();
    let gamma_t = (gamma.sin() * cos / along).clamp(-1.0, 1.0).asin();
    let f = fresnel(eta, 0.5, (cos * gamma.cos()).clamp(0.0, 1.0));
    let length = 2.0 * gamma_t.cos() * eta / along;
    let pass = fiber.sigma_ca.map(|s| (-f64::from(s) * length).exp());
    std::array::from_fn(|p| {
        let q = p as f64;
        let exit = 2.0 * q * gamma_t - 2.0 * gamma + q * PI;
        let a = |c: usize| if p == 0 { f } else { (1.0 - f).powi(2) * f.powi(p as i32 - 1) * pass[c].powi(p as i32) };
        (exit, [a(0), a(1), a(2)])
    })
}

impl Azimuths {
    fn new(fiber: &Fiber) -> Self {
        let beta = f64::from(fiber.beta_n);
        // R, the narrowest: three nodes a deviation, so that linear interpolation is within 1/72 of its peak; Φ moves by up to
        // four radians a radian of γ, of which two fifths of a deviation are sampled.
        let phis = ((3.0 * PI / beta).ceil() as usize).clamp(91, 1801);
        let gammas = ((4.0 * PI / (0.4 * beta)).ceil() as usize).clamp(128, 4000);
        let mut table =
            Azimuths { phis, values: Vec::new(), cumulative: Vec::new(), energies: Vec::with_capacity(4 * THETAS) };
        let step = PI / (phis - 1) as f64;
        let lobes = [1.0f64, 2.0, 3.0, 4.0].map(|k| {
            let sigma = beta * k.sqrt();
            // Images that come within six deviations, e⁻¹⁸, of [0, π].
            (sigma, if sigma < 1.0 { 1 } else { 3 })
        });
        for theta in 0..THETAS {
            let theta_d = theta as f64 / (THETAS - 1) as f64 * FRAC_PI_2;
            let mut rows = [0; 4].map(|_| vec![[0.0f64; 3]; phis]);
            for k in 0..gammas {
                let gamma = ((k as f64 + 0.5) / gammas as f64 - 0.5) * PI;
                let paths = path(fiber, theta_d, gamma);
                for ((row, (exit, a)), (sigma, images)) in rows.iter_mut().zip(paths).zip(lobes) {
                    let exit = (exit + PI).rem_euclid(TAU) - PI;
                    let width = 0.5 * gamma.cos() * PI / gammas as f64 / (sigma * TAU.sqrt());
                    for image in -images..=images {
                        let centre = exit + f64::from(image) * TAU;
                        let first = ((centre - 6.0 * sigma) / step).ceil().max(0.0) as usize;
                        let last = ((centre + 6.0 * sigma) / step).floor().min((phis - 1) as f64);
                        for j in first..(last + 1.0).max(0.0) as usize {
                            let bell = width * (-0.5 * ((j as f64 * step - centre) / sigma).powi(2)).exp();
                            (0..3).for_each(|c| row[j][c] += a[c] * bell);
                        }
                    }
                }
            }
            rows.iter().for_each(|row| table.push(row, step));
        }
        table
    }

    fn push(&mut self, row: &[[f64; 3]], step: f64) {
        let values: Vec<[f64; 4]> =
            row.iter().map(|n| [n[0], n[1], n[2], n[0].max(n[1]).max(n[2]).max(1e-12)]).collect();
        let mut sum = [0.0; 4];
        self.cumulative.push(0.0);
        for pair in values.windows(2) {
            (0..4).for_each(|c| sum[c] += 0.5 * (pair[0][c] + pair[1][c]) * step);
            self.cumulative.push(sum[3] as f32);
        }
        self.values.extend(values.iter().map(|v| v.map(|x| x as f32)));
        self.energies.push(sum.map(|s| 2.0 * s as f32));
    }

    /// The node of θ_d below, and how far it is to the next.
    #[inline(always)]
    fn theta(theta_d: f32) -> (usize, f32) {
        let x = theta_d.abs() * ((THETAS - 1) as f32 / std::f32::consts::FRAC_PI_2);
        let i = (x as usize).min(THETAS - 2);
        (i, x - i as f32)
    }

    /// N_p(φ), RGB and largest channel.
    #[inline(always)]
    fn eval(&self, p: usize, (theta, t): (usize, f32), phi: f32) -> [f32; 4] {
        let x = phi.abs() * ((self.phis - 1) as f32 / std::f32::consts::PI);
        let j = (x as usize).min(self.phis - 2);
        let s = x - j as f32;
        let row = |theta: usize| {
            let at = &self.values[(4 * theta + p) * self.phis + j..][..2];
            [0, 1, 2, 3].map(|c| (1.0 - s) * at[0][c] + s * at[1][c])
        };
        let (a, b) = (row(theta), row(theta + 1));
        // In this form it stays positive where one of them is tiny.
        [0, 1, 2, 3].map(|c| (1.0 - t) * a[c] + t * b[c])
    }

    #[inline(always)]
    fn energy(&self, p: usize, (theta, t): (usize, f32)) -> [f32; 4] {
        let [a, b] = [0, 1].map(|k| self.energies[4 * (theta + k) + p]);
        [0, 1, 2, 3].map(|c| (1.0 - t) * a[c] + t * b[c])
    }

    /// Draws φ by the largest channel: one of the two rows, and its linear density inverted exactly.
    fn sample(&self, p: usize, (theta, t): (usize, f32), u: [f32; 2]) -> f32 {
        let [a, b] = [0, 1].map(|k| self.energies[4 * (theta + k) + p][3]);
        let far = u[1] * ((1.0 - t) * a + t * b) >= (1.0 - t) * a;
        let start = (4 * (theta + usize::from(far)) + p) * self.phis;
        let (cumulative, values) = (&self.cumulative[start..][..self.phis], &self.values[start..][..self.phis]);
        let side = if u[0] < 0.5 { -1.0 } else { 1.0 };
        let v = if u[0] < 0.5 { 2.0 * u[0] } else { 2.0 * u[0] - 1.0 };
        let target = v * cumulative[self.phis - 1];
        let j = (cumulative.partition_point(|&c| c <= target)).clamp(1, self.phis - 1) - 1;
        let (f0, f1) = (values[j][3], values[j + 1][3]);
        let part = ((target - cumulative[j]) / (cumulative[j + 1] - cumulative[j]).max(1e-30)).clamp(0.0, 1.0);
        let root = (f0 * f0 + part * (f1 * f1 - f0 * f0)).max(0.0).sqrt();
        let x = part * (f0 + f1) / (f0 + root).max(1e-30);
        side * (j as f32 + x.clamp(0.0, 1.0)) * std::f32::consts::PI / (self.phis - 1) as f32
    }
}

/// The model of one fibre.
#[derive(Clone, Debug)]
pub struct DEon2011 {
    along: Spherical,
    azimuths: Azimuths,
    /// Energies over θ_o, when first asked for.
    energies: OnceLock<Vec<Lobes>>,
}

impl DEon2011 {
    /// Prepares a fibre.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where [`Fiber::validate`] finds one.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        let lanes = |of: [f32; 4]| std::array::from_fn(|i| of[i.min(3)]);
        Ok(DEon2011 {
            along: Spherical::new(
                lanes([1.0, -0.5, -1.5, -2.5].map(|k| k * fiber.alpha)),
                lanes([1.0, 0.5, 1.5, 2.5].map(|k| k * fiber.beta_m)),
            ),
            azimuths: Azimuths::new(fiber),
            energies: OnceLock::new(),
        })
    }

    /// The mean over each lobe, at 64 × 16 of the numbers it is sampled with.
    fn energy(&self, theta_o: f32) -> Lobes {
        let (sin, cos) = theta_o.sin_cos();
        let along = self.along.at(Polar { sin, cos: cos.max(0.0) });
        let mut lobes = Lobes([[0.0; 3]; 6]);
        let (n, m) = (64, 16);
        for k in 0..n * m {
            let u = [((k / m) as f32 + 0.5) / n as f32, ((k % m) as f32 + 0.5) / m as f32];
            for p in 0..4 {
                let (sin_i, cos_i) = along.sample(p, u);
                let theta = Azimuths::theta(0.5 * (sin_i.atan2(cos_i) - theta_o));
                let energy = self.azimuths.energy(p, theta);
                (0..3).for_each(|c| lobes.0[LOBES[p] as usize][c] += energy[c] / (n * m) as f32);
            }
        }
        lobes
    }
}

/// One hit of a fibre.
#[derive(Clone, Copy, Debug)]
pub struct DEon2011Hit<'m> {
    model: &'m DEon2011,
    frame: Frame<f32>,
    theta_o: f32,
    along: SphericalAt<'m>,
    probability: [f32; 4],
}

impl Model for DEon2011 {
    type Hit<'a> = DEon2011Hit<'a>;

    #[inline]
    fn at(&self, wo: Vec3, _: Window) -> DEon2011Hit<'_> {
        let wo = wo.to_array();
        let polar = Polar::new(wo);
        let theta_o = polar.sin.atan2(polar.cos);
        // In the middle of the lobes θ_d is θ_o.
        let probability = [0, 1, 2, 3].map(|p| self.azimuths.energy(p, Azimuths::theta(theta_o))[3]);
        let scale = 1.0 / probability.iter().sum::<f32>();
        DEon2011Hit {
            model: self,
            frame: Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12)),
            theta_o,
            along: self.along.at(polar),
            probability: probability.map(|p| p * scale),
        }
    }

    fn field(&self) -> Field {
        Field::Far
    }
}

impl DEon2011Hit<'_> {
    #[inline(always)]
    fn eval_outgoing(&self, o: &Outgoing<f32>) -> (Lobes, f32) {
        let azimuths = &self.model.azimuths;
        let theta = Azimuths::theta(0.5 * (o.theta_i - self.theta_o));
        let phi = wrap(o.phi);
        let along = self.along.eval(o).to_array();
        let mut lobes = Lobes([[0.0; 3]; 6]);
        let mut pdf = 0.0;
        for p in 0..4 {
            let [r, g, b, largest] = azimuths.eval(p, theta, phi);
            lobes.0[LOBES[p] as usize] = [r, g, b].map(|n| n * along[p]);
            pdf += self.probability[p] * along[p] * largest / azimuths.energy(p, theta)[3];
        }
        (lobes, pdf)
    }
}

impl Scattering for DEon2011Hit<'_> {
    fn energy(&self) -> Lobes {
        let nodes = 181;
        let degree = 1f32.to_radians();
        let table = self
            .model
            .energies
            .get_or_init(|| (0..nodes).map(|k| self.model.energy((k as f32 - 90.0) * degree)).collect());
        let x = (self.theta_o / degree + 90.0).max(0.0);
        let i = (x as usize).min(nodes - 2);
        let t = x - i as f32;
        Lobes(std::array::from_fn(|p| [0, 1, 2].map(|c| (1.0 - t) * table[i].0[p][c] + t * table[i + 1].0[p][c])))
    }

    #[inline]
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_outgoing(&self.frame.outgoing(wi.to_array()))
    }

    #[inline]
    fn sample(&self, u: [f32; 5]) -> Sample {
        let (p, _) = choose(&self.probability, u[0]);
        let (sin_i, cos_i) = self.along.sample(p, [u[1], u[2]]);
        let theta_i = sin_i.atan2(cos_i);
        let theta = Azimuths::theta(0.5 * (theta_i - self.theta_o));
        let phi = self.model.azimuths.sample(p, theta, [u[3], u[4]]);
        let outgoing = Outgoing { sin_i, cos_i, theta_i, phi };
        let (lobes, pdf) = self.eval_outgoing(&outgoing);
        let weight = weight(lobes.total(), pdf);
        Sample { wi: direction(&self.frame, &outgoing), pdf, weight, lobe: LOBES[p], h: 0.0 }
    }
}
