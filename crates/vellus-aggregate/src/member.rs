//! The far field of the member fibre, tabulated over inclination and azimuth.

use crate::bunch::Bunch;
use crate::once::AZIMUTHS;
use crate::longitudinal::density;
use std::f64::consts::{FRAC_PI_2, PI};
use vellus::{Bcsdf, Fiber, Hit, Lobe, Lobes, Window, direction};

/// Inclinations of ω_o from 0 to 90°, 5° apart.
pub(crate) const INCLINATIONS: usize = 19;

/// Inclinations of ω_i from −90° to 90°, 5° apart.
pub(crate) const OUTGOING: usize = 2 * INCLINATIONS - 1;

/// The lobes with a spherical Gaussian along the fibre, and the factors of α and β_m (Yan17 Table 2).
pub(crate) const SPECULAR: [(Lobe, f64, f64); 4] =
    [(Lobe::R, 1.0, 1.0), (Lobe::Tt, -0.5, 0.5), (Lobe::Trt, -1.5, 1.5), (Lobe::Residual, -1.5, 2.0)];

/// The lobes of light that the medulla scattered.
pub(crate) const SCATTERED: [Lobe; 2] = [Lobe::Tts, Lobe::Trts];

/// The six lobes, and the diffuse part of the residual lobe: even in azimuth, and 2 cos θᵢ/π in sin θᵢ (D17).
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
}

/// The inclination of node `k` of [`OUTGOING`].
pub(crate) fn inclination(k: usize) -> f64 {
    (k as f64 / (OUTGOING - 1) as f64 - 0.5) * PI
}

/// The width in sin θᵢ that node `k` of [`OUTGOING`] stands for: the integral of its hat function.
pub(crate) fn width(k: usize) -> f64 {
    let sine = |k: usize| inclination(k).sin();
    0.5 * (sine((k + 1).min(OUTGOING - 1)) - sine(k.saturating_sub(1)))
}

/// The member fibre, with its longitudinal roughness widened by the spread of the members' directions.
///
/// A fibre tilted by δ moves the cone of R by δ·(cos φ_o, sin φ_o)·cos θ_o and the same for ω_i, so that the variance of
/// θᵢ grows by 4 cos²(φ/2) times that of δ. R is distributed over φ in proportion to cos(φ/2): its mean is 8/3. TT then
/// gains 2/3 and TRT 6 variances, because their widths are in proportion to that of R. They should gain less.
pub(crate) fn spread_fiber(fiber: &Fiber, bunch: &Bunch) -> Fiber {
    let wider = (f64::from(fiber.beta_m).powi(2) + 8.0 / 3.0 * bunch.spread().powi(2)).sqrt();
    let beta_m = if bunch.spread() > 0.0 { wider.min(FRAC_PI_2) as f32 } else { fiber.beta_m };
    Fiber { beta_m, ..*fiber }
}

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
            Member { energy, azimuths, scattered }
        })
    }

    /// The sum over all lobes of a channel.
    pub fn albedo(&self, channel: usize) -> f64 {
        self.energy.iter().map(|rgb| rgb[channel]).sum()
    }

    /// The energies of the lobes of [`SPECULAR`], of one channel.
    pub fn specular(&self, channel: usize) -> [f64; 4] {
        SPECULAR.map(|(lobe, ..)| self.energy[lobe as usize][channel])
    }

    /// The energy of the lobes of [`SCATTERED`], of one channel.
    pub fn scattered(&self, channel: usize) -> f64 {
        SCATTERED.iter().map(|lobe| self.energy[*lobe as usize][channel]).sum()
    }

    /// The energy of all lobes but those of [`SPECULAR`], of one channel.
    pub fn broad(&self, channel: usize) -> f64 {
        self.scattered(channel) + self.energy[DIFFUSE][channel]
    }

    /// The light of one channel that is not specular, in cells around the nodes of θᵢ.
    pub fn broad_shares(&self, channel: usize) -> Vec<f64> {
        let diffuse: Vec<f64> = (0..OUTGOING).map(|k| inclination(k).cos() * width(k)).collect();
        let total: f64 = diffuse.iter().sum();
        let [scattered, even] = [self.scattered(channel), self.energy[DIFFUSE][channel]];
        let cell = |k: usize| 0.5 * (self.scattered[0][k] + self.scattered[1][k]) * width(k);
        diffuse.iter().enumerate().map(|(k, x)| scattered * cell(k) + even * x / total).collect()
    }

    /// ∫ N(φ) f(node) dφ over the whole circle, for one channel and all lobes.
    pub fn around(&self, channel: usize, f: impl Fn(usize) -> f64) -> f64 {
        let all = |k: usize| self.azimuths[k].iter().map(|rgb| rgb[channel]).sum::<f64>() * f(k);
        circle((0..AZIMUTHS).map(all))
    }
}

/// The integral from −π to π of an even function that is linear between its values at equidistant nodes from 0 to π.
pub(crate) fn circle(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let last = values.len() - 1;
    let sum: f64 = values.enumerate().map(|(k, x)| if k == 0 || k == last { 0.5 * x } else { x }).sum();
    2.0 * PI / last as f64 * sum
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

/// The energies of the lobes, with that of the residual lobe divided into its two parts. Where the specular part has its
/// peak, both have known densities, so the value of the lobe there tells their shares.
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
