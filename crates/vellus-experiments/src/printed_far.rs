//! The paper's far field as a model for pictures: are five segments "enough in most practical renderings" (Yan17
//! Sec. 5.1)?

use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};
use vellus::parts::{Frame, Polar};
use vellus::{Bcsdf, Error, Fiber, Hit, Lobes, Model, Sample, Scattering, TableData, Tables, Window, WindowSupport};
use vellus_reference::exact::{Exact, longitudinal};

/// Nodes of |θ_o| and of |φ|, every degree and every half degree.
const NODES: [usize; 2] = [91, 361];

/// Largest |θ_o| of the table. At 90° light has no azimuth.
const THETA_MAX: f64 = 0.999 * FRAC_PI_2;

/// N(φ) of R, TT and TRT, RGB.
type Azimuthal = [[f32; 3]; 3];

/// The far field whose R, TT and TRT are averaged over the paper's segments. The other lobes, and samples, are those of
/// [`Bcsdf`].
pub struct PrintedFar {
    bcsdf: Bcsdf<'static>,
    segments: usize,
    /// Shifts and standard deviations of R, TT and TRT along the fibre, in radians (Table 2).
    along: [[f64; 2]; 3],
    table: Vec<Azimuthal>,
}

/// A hit of the fibre.
pub struct PrintedHit<'m> {
    model: &'m PrintedFar,
    hit: Hit<'m>,
    frame: Frame<f32>,
    theta_o: f64,
}

impl PrintedFar {
    /// The model of one fibre, with `segments` on each side of h = 0.
    ///
    /// # Errors
    /// A parameter of the fibre out of its range.
    pub fn new(fiber: &Fiber, segments: usize) -> Result<Self, Error> {
        let tables = TableData::from_bytes(Tables::SHIPPED)?;
        let exact = Exact::new(fiber, &tables)?;
        let row = |i: usize| -> Vec<Azimuthal> {
            let theta_o = i as f64 / (NODES[0] - 1) as f64 * THETA_MAX;
            let window = exact.printed_segments(theta_o, [-1.0, 1.0], segments, 1);
            let at = |j: usize| window.azimuthal(j as f64 / (NODES[1] - 1) as f64 * PI);
            (0..NODES[1]).map(at).map(|n| [n[0], n[1], n[2]].map(|rgb| rgb.map(|x| x as f32))).collect()
        };
        let table = (0..NODES[0]).into_par_iter().flat_map_iter(row).collect();
        let [alpha, beta] = [fiber.alpha, fiber.beta_m].map(f64::from);
        let along = [[alpha, beta], [-0.5 * alpha, 0.5 * beta], [-1.5 * alpha, 1.5 * beta]];
        Ok(PrintedFar { bcsdf: Bcsdf::new(fiber)?, segments, along, table })
    }

    /// N(φ), by bilinear interpolation.
    fn azimuthal(&self, theta_o: f64, phi: f64) -> Azimuthal {
        let on = |x: f64, nodes: usize| {
            let x = (x * (nodes - 1) as f64).clamp(0.0, (nodes - 1) as f64);
            let below = (x as usize).min(nodes - 2);
            (below, (x - below as f64) as f32)
        };
        let ((i, s), (j, t)) = (on(theta_o.abs() / THETA_MAX, NODES[0]), on(phi.abs() / PI, NODES[1]));
        let row = |i: usize| (&self.table[i * NODES[1] + j], &self.table[i * NODES[1] + j + 1]);
        let (low, high) = (row(i), row(i + 1));
        std::array::from_fn(|p| {
            std::array::from_fn(|c| {
                let mix = |(a, b): (&Azimuthal, &Azimuthal)| a[p][c] + t * (b[p][c] - a[p][c]);
                mix(low) + s * (mix(high) - mix(low))
            })
        })
    }
}

impl Model for PrintedFar {
    type Hit<'a> = PrintedHit<'a>;

    fn at(&self, wo: Vec3, _: Window) -> PrintedHit<'_> {
        let hit = self.bcsdf.at(wo, Window::far());
        let wo = wo.to_array();
        let polar = Polar::new(wo);
        let frame = Frame::new(wo, polar.cos, 1.0 / polar.cos.max(1e-12));
        PrintedHit { model: self, hit, frame, theta_o: polar.sin.atan2(polar.cos).into() }
    }

    fn field(&self) -> WindowSupport {
        WindowSupport::Far
    }

    fn with_fiber(&self, fiber: &Fiber) -> Result<Self, Error> {
        PrintedFar::new(fiber, self.segments)
    }
}

impl Scattering for PrintedHit<'_> {
    fn energy(&self) -> Lobes {
        self.hit.energy()
    }

    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        let (mut lobes, pdf) = self.hit.eval_pdf(wi);
        let o = self.frame.outgoing(wi.to_array());
        let azimuthal = self.model.azimuthal(self.theta_o, o.phi.into());
        for (p, [shift, width]) in self.model.along.into_iter().enumerate() {
            let density = longitudinal(-self.theta_o - shift, width * width, o.theta_i.into()) as f32;
            lobes.0[p] = azimuthal[p].map(|n| n * density);
        }
        (lobes, pdf)
    }

    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        let Sample { wi, lobe, .. } = self.hit.sample(u)?;
        let (lobes, pdf) = self.eval_pdf(wi);
        Sample::new(wi, pdf, lobes.total().map(|f| f / pdf), lobe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus::Species;
    use vellus_models::direction;

    /// With many segments it is our far field. A separate program finds 4.6 % for 16 segments at 0.2 rad, and 21 % for
    /// five (R + TT + TRT of a dog, L1).
    #[test]
    fn many_segments_are_our_far_field() {
        let fiber = Fiber::published(Species::Dog);
        let (ours, printed) = (Bcsdf::new(&fiber).unwrap(), PrintedFar::new(&fiber, 16).unwrap());
        for theta_o in [0.2f64, -0.2] {
            let wo = direction(theta_o.to_degrees(), 0.0);
            let (a, b) = (ours.at(wo, Window::far()), printed.at(wo, Window::far()));
            let (mut difference, mut sum) = (0.0, 0.0);
            for i in 0..45 {
                for j in 0..90 {
                    let theta = f64::from(i) * 4.0 - 88.0;
                    let wi = direction(theta, f64::from(j) * 4.0 + 1.0);
                    let light = |lobes: Lobes| (0..3).map(|p| lobes.0[p][1]).sum::<f32>();
                    let (a, b) = (light(a.eval(wi)), light(b.eval(wi)));
                    difference += f64::from((a - b).abs()) * theta.to_radians().cos();
                    sum += f64::from(a) * theta.to_radians().cos();
                }
            }
            let error = difference / sum;
            assert!((0.02..0.06).contains(&error), "{theta_o}: {error}");
        }
    }
}
