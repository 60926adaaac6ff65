//! The far field of the member fibre, tabulated over inclination and azimuth.

use crate::longitudinal::density;
use crate::once::AZIMUTHS;
use std::f64::consts::{FRAC_PI_2, PI};
use vellus::{Bcsdf, Fiber, Hit, Lobe, Lobes, Window, direction};

/// Inclinations of ω_o from 0 to 90°, 5° apart.
pub(crate) const INCLINATIONS: usize = 19;

/// Inclinations of ω_i from −90° to 90°, 5° apart.
pub(crate) const OUTGOING: usize = 2 * INCLINATIONS - 1;

/// The lobes with a spherical Gaussian along the fibre, and the factors of α and β_m (Yan17 Table 2).
pub(crate) const SPECULAR: [(Lobe, f64, f64); 4] =
    [(Lobe::R, 1.0, 1.0), (Lobe::Tt, -0.5, 0.5), (Lobe::Trt, -1.5, 1.5), (Lobe::Rest, -1.5, 2.0)];

/// The first lobes of [`SPECULAR`] keep light in one narrow lobe over many collisions: R, TT and TRT.
pub(crate) const NARROW: usize = 3;

/// The lobes of light that the medulla scattered.
pub(crate) const SCATTERED: [Lobe; 2] = [Lobe::Tts, Lobe::Trts];

/// The six lobes, and the diffuse part of the rest lobe: even in azimuth, and 2 cos θᵢ/π in sin θᵢ (D17).
pub(crate) const LOBES: usize = 7;

/// The index of that part.
pub(crate) const DIFFUSE: usize = 6;

/// The far field for one inclination of ω_o ≥ 0.
pub(crate) struct Member {
    /// The energies of all lobes, RGB.
    pub energy: [[f64; 3]; LOBES],
    /// Densities per radian of all lobes, RGB, at equidistant azimuths from 0 (back) to π.
    pub azimuths: Vec<[[f64; 3]; LOBES]>,
    /// The density of scattered light in sin θᵢ, at φ = 0 and φ = π, each with the integral 1.
    pub scattered: [Vec<f64>; 2],
    /// The mean of cos²(φ/2) for each lobe of [`SPECULAR`].
    back: [f64; 4],
}

/// The narrowest lobe that these nodes resolve, in radians: 0.7 steps.
const NARROWEST: f64 = 0.061;

/// The inclination of node `k` of [`OUTGOING`].
pub(crate) fn inclination(k: usize) -> f64 {
    (k as f64 / (OUTGOING - 1) as f64 - 0.5) * PI
}

/// The width in sin θᵢ that node `k` of [`OUTGOING`] stands for: the integral of its hat function.
pub(crate) fn width(k: usize) -> f64 {
    let sine = |k: usize| inclination(k).sin();
    0.5 * (sine((k + 1).min(OUTGOING - 1)) - sine(k.saturating_sub(1)))
}

/// What widens the lobes along the fibre: β_m and the spread of the members' directions, both in radians.
#[derive(Clone, Copy)]
pub(crate) struct Roughness {
    pub beta_m: f64,
    pub spread: f64,
}

/// The variance that a spread adds to light which goes straight back, over the spread's square.
///
/// If a fibre's axis deviates by δ (a vector across the axis), specular light keeps (ω_o + ω_i)·(x + δ) = 0. So θᵢ
/// moves by δ·(e_o + e_i), with the unit vectors of both azimuths. That has 4 cos²(φ/2) times the variance of δ in a
/// plane.
pub(crate) const TILT: f64 = 4.0;

impl Member {
    /// Tabulates all inclinations.
    pub fn all(bcsdf: &Bcsdf<'_>) -> Vec<Self> {
        (0..INCLINATIONS).map(|k| Member::at(bcsdf, inclination(INCLINATIONS - 1 + k))).collect()
    }

    fn at(bcsdf: &Bcsdf<'_>, theta_o: f64) -> Self {
        bcsdf.with_hit(direction(theta_o, 0.0), Window::far(), |hit| {
            let energy = with_diffuse(hit, bcsdf.fiber(), theta_o);
            let mut azimuths = vec![[[0.0; 3]; LOBES]; AZIMUTHS];
            // Two midpoints in each step, divided between its two nodes.
            for step in 0..AZIMUTHS - 1 {
                for share in [0.25, 0.75] {
                    let phi = (step as f64 + share) * PI / (AZIMUTHS - 1) as f64;
                    let values = hit.azimuthal(phi as f32).0;
                    for (lobe, c) in (0..18).map(|i| (i / 3, i % 3)) {
                        let half = 0.5 * f64::from(values[lobe][c]);
                        azimuths[step][lobe][c] += half * (1.0 - share);
                        azimuths[step + 1][lobe][c] += half * share;
                    }
                }
            }
            for end in [0, AZIMUTHS - 1] {
                azimuths[end].iter_mut().flatten().for_each(|x| *x *= 2.0);
            }
            scale(&mut azimuths, &energy);
            let scattered = [0.0, PI].map(|phi| {
                let density = |k: usize| {
                    let f = hit.eval(direction(inclination(k), phi)).0;
                    SCATTERED.iter().flat_map(|lobe| f[*lobe as usize]).map(f64::from).sum::<f64>()
                };
                normalized((0..OUTGOING).map(density).collect())
            });
            Member { back: SPECULAR.map(|(lobe, ..)| mean_back(&azimuths, lobe)), energy, azimuths, scattered }
        })
    }

    /// The sum over all lobes of a channel.
    pub fn albedo(&self, channel: usize) -> f64 {
        self.energy.iter().map(|rgb| rgb[channel]).sum()
    }

    /// The energies of the first [`NARROW`] lobes of [`SPECULAR`], of one channel.
    pub fn narrow(&self, channel: usize) -> [f64; NARROW] {
        std::array::from_fn(|p| self.energy[SPECULAR[p].0 as usize][channel])
    }

    /// The mean variance of lobe `p` of [`SPECULAR`] over its azimuths.
    pub fn variance(&self, p: usize, roughness: Roughness) -> f64 {
        (SPECULAR[p].2 * roughness.beta_m).powi(2) + TILT * self.back[p] * roughness.spread.powi(2)
    }

    /// The light of one channel that is not in [`Member::narrow`], in cells around the nodes of θᵢ. The tilt of the
    /// cuticle's scales is not included.
    pub fn broad(&self, channel: usize, theta_o: f64, roughness: Roughness) -> Vec<f64> {
        let mut light = vec![0.0; OUTGOING];
        let mut add = |energy: f64, density: &dyn Fn(usize) -> f64| {
            let cells: Vec<f64> = (0..OUTGOING).map(|k| density(k) * width(k)).collect();
            let total: f64 = cells.iter().sum();
            light.iter_mut().zip(cells).for_each(|(sum, x)| *sum += energy * x / total);
        };
        let scattered: f64 = SCATTERED.iter().map(|lobe| self.energy[*lobe as usize][channel]).sum();
        add(scattered, &|k| self.scattered[0][k] + self.scattered[1][k]);
        add(self.energy[DIFFUSE][channel], &|k| inclination(k).cos());
        for p in NARROW..SPECULAR.len() {
            let v = self.variance(p, roughness);
            add(self.energy[SPECULAR[p].0 as usize][channel], &|k| resolved(inclination(k), -theta_o, v));
        }
        light
    }

    /// ∫ N(φ) f(node) dφ over the whole circle, for one channel and all lobes.
    pub fn around(&self, channel: usize, f: impl Fn(usize) -> f64) -> f64 {
        let all = |k: usize| self.azimuths[k].iter().map(|rgb| rgb[channel]).sum::<f64>() * f(k);
        circle((0..AZIMUTHS).map(all))
    }
}

/// The density of a lobe, at least so wide that nodes 5° apart resolve it.
pub(crate) fn resolved(theta: f64, centre: f64, v: f64) -> f64 {
    density(theta, centre, v.max(NARROWEST * NARROWEST))
}

/// The integral from −π to π of an even function that is linear between its values at equidistant nodes from 0 to π.
pub(crate) fn circle(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let last = values.len() - 1;
    let sum: f64 = values.enumerate().map(|(k, x)| if k == 0 || k == last { 0.5 * x } else { x }).sum();
    2.0 * PI / last as f64 * sum
}

/// The mean of cos²(φ/2) over the azimuths of a lobe.
fn mean_back(azimuths: &[[[f64; 3]; LOBES]], lobe: Lobe) -> f64 {
    let at = |k: usize| azimuths[k][lobe as usize].iter().sum::<f64>();
    let back = |k: usize| at(k) * (0.5 * PI * k as f64 / (AZIMUTHS - 1) as f64).cos().powi(2);
    circle((0..AZIMUTHS).map(back)) / circle((0..AZIMUTHS).map(at)).max(f64::MIN_POSITIVE)
}

/// Scales each lobe and channel to its energy. A lobe that no node sees becomes even.
fn scale(azimuths: &mut [[[f64; 3]; LOBES]], energy: &[[f64; 3]; LOBES]) {
    for (lobe, c) in (0..3 * LOBES).map(|i| (i / 3, i % 3)) {
        let integral = circle(azimuths.iter().map(|node| node[lobe][c]));
        for node in azimuths.iter_mut() {
            let density = if integral > 0.0 { node[lobe][c] / integral } else { 0.5 / PI };
            node[lobe][c] = density * energy[lobe][c];
        }
    }
}

/// The energies of the lobes, with that of the rest lobe divided into its two parts. Where the specular part has
/// its peak, both have known densities, so the value of the lobe there tells their shares.
fn with_diffuse(hit: &Hit<'_>, fiber: &Fiber, theta_o: f64) -> [[f64; 3]; LOBES] {
    let [_, _, _, (residual, shift, factor)] = SPECULAR;
    let centre = -theta_o - shift * f64::from(fiber.alpha);
    let peak = centre.clamp(-FRAC_PI_2, FRAC_PI_2);
    let specular = density(peak, centre, (factor * f64::from(fiber.beta_m)).powi(2));
    let even = 2.0 / PI * peak.cos();
    let Lobes(values) = hit.eval(direction(peak, 0.5));
    let Lobes(energies) = hit.energy();
    let mut parts = [[0.0; 3]; LOBES];
    for (part, rgb) in parts.iter_mut().zip(energies) {
        *part = rgb.map(f64::from);
    }
    for c in 0..3 {
        let (value, energy) = (2.0 * PI * f64::from(values[residual as usize][c]), parts[residual as usize][c]);
        let share = (value - energy * even) / (specular - even);
        let share = if share.is_finite() { share.clamp(0.0, energy) } else { energy };
        parts[residual as usize][c] = share;
        parts[DIFFUSE][c] = energy - share;
    }
    parts
}

/// A density in sin θᵢ with the integral 1. Without values it is even.
fn normalized(values: Vec<f64>) -> Vec<f64> {
    let integral: f64 = values.iter().enumerate().map(|(k, x)| x * width(k)).sum();
    values.into_iter().map(|x| if integral > 0.0 { x / integral } else { 0.5 }).collect()
}
