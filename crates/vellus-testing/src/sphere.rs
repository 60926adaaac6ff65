//! Densities over the sphere: their integral, and a test that samples follow them.

use crate::direction;
use crate::significance::max_chi_squared;
use glam::Vec3;
use std::f64::consts::{PI, TAU};
use vellus::Fiber;

/// The numbers of midpoints over the inclination and the azimuth that resolve the lobes of a fibre.
///
/// The midpoint rule with step h has the relative error 2 exp(−2π²σ²/h²) for a Gaussian of standard deviation σ. The
/// narrowest lobes are TT over the inclination (β_m/2) and R over the azimuth (β_n). With h = 0.8 σ the error is below
/// 1e-13. Scattered light is as smooth as the tables: their nodes are at least 2° apart.
pub fn nodes(fiber: &Fiber) -> [u32; 2] {
    let step = |sigma: f32, most: f64| (0.8 * f64::from(sigma)).min(most.to_radians());
    [(PI / step(0.5 * fiber.beta_m, 1.0)).ceil() as u32, (TAU / step(fiber.beta_n, 2.0)).ceil() as u32]
}

/// ∫ pdf dω by the midpoint rule with `n_theta` inclinations and `n_phi` azimuths.
pub fn integral([n_theta, n_phi]: [u32; 2], pdf: impl Fn(Vec3) -> f32) -> f64 {
    let mut sum = 0.0;
    for i in 0..n_theta {
        let theta = ((f64::from(i) + 0.5) / f64::from(n_theta) - 0.5) * PI;
        for j in 0..n_phi {
            let pdf = pdf(direction(theta, (f64::from(j) + 0.5) / f64::from(n_phi) * TAU));
            sum += f64::from(pdf) * theta.cos();
        }
    }
    sum * PI / f64::from(n_theta) * TAU / f64::from(n_phi)
}

/// A χ² test of samples in cells of equal area, against the pdf integrated over each cell.
///
/// The false-alarm rate is 0.01 over all tests together: [`max_chi_squared`]. A wrong tilt sign, a lost Jacobian or a
/// wrong lobe probability exceeds the bound by orders of magnitude.
pub struct ChiSquared {
    /// The number of bands in x, and of cells in each band, over the azimuth.
    pub cells: [usize; 2],
    /// The number of samples.
    pub samples: usize,
    /// The number of midpoints for the pdf's integrals, over all inclinations and azimuths: at least this many.
    pub nodes: [u32; 2],
    /// The number of tests that share the false-alarm rate.
    pub tests: usize,
}

impl ChiSquared {
    /// Checks that the samples follow the pdf. The error states χ², its bound and the degrees of freedom.
    pub fn check(&self, mut sample: impl FnMut() -> Vec3, pdf: impl Fn(Vec3) -> f32) -> Result<(), String> {
        let [rows, columns] = self.cells;
        let mut observed = vec![0.0f64; rows * columns];
        for _ in 0..self.samples {
            let wi = sample();
            let row = ((f64::from(wi.x) * 0.5 + 0.5) * rows as f64) as usize;
            let turn = f64::from(wi.z).atan2(wi.y.into()) / TAU;
            let column = (turn.rem_euclid(1.0) * columns as f64) as usize;
            observed[row.min(rows - 1) * columns + column.min(columns - 1)] += 1.0;
        }
        let mut expected = vec![0.0f64; rows * columns];
        let in_cell = (self.nodes[1] as usize).div_ceil(columns);
        let n_phi = in_cell * columns;
        for row in 0..rows {
            let band = [row, row + 1].map(|r| (2.0 * r as f64 / rows as f64 - 1.0).clamp(-1.0, 1.0).asin());
            let n_theta = ((band[1] - band[0]) / PI * f64::from(self.nodes[0])).ceil() as usize;
            for i in 0..n_theta {
                let theta = band[0] + (band[1] - band[0]) * (i as f64 + 0.5) / n_theta as f64;
                let weight = theta.cos() * (band[1] - band[0]) / n_theta as f64 * TAU / n_phi as f64;
                for j in 0..n_phi {
                    let phi = (j as f64 + 0.5) / n_phi as f64 * TAU;
                    let pdf = f64::from(pdf(direction(theta, phi)));
                    expected[row * columns + j / in_cell] += pdf * weight;
                }
            }
        }
        // Cells with fewer than 10 expected samples form one cell.
        let (mut chi2, mut cells, mut pooled) = (0.0, 0, [0.0f64; 2]);
        for (o, e) in observed.iter().zip(&expected) {
            let e = e * self.samples as f64;
            if e < 10.0 {
                pooled[0] += o;
                pooled[1] += e;
            } else {
                chi2 += (o - e).powi(2) / e;
                cells += 1;
            }
        }
        if pooled[1] > 1.0 {
            chi2 += (pooled[0] - pooled[1]).powi(2) / pooled[1];
            cells += 1;
        }
        let df = f64::from(cells - 1);
        let limit = max_chi_squared(df, self.tests, 0.01);
        if chi2 < limit { Ok(()) } else { Err(format!("χ² {chi2} over {limit} with {df} degrees")) }
    }
}
