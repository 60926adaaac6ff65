//! A hit: evaluates and samples the lobes.

use super::escape::Interfaces;
use super::profiles::Reading;
use super::{NAMES, SCATTERED, Yan2015};
use crate::azimuthal::GaussiansAt;
use crate::factored::{self, Factored, choose, direction, largest_channel};
use crate::far::{AzimuthalSums, LongitudinalFactors, Separable};
use crate::longitudinal::Plane;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use vellus::parts::{Azimuth, Inclination, Outgoing, wrap};
use vellus::{Lobe, Lobes, Sample, Scattering};

/// The three scattered lobes and the diffuse lobe of a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattered {
    pub(super) azimuth: Azimuth,
    pub(super) inclination: Inclination,
    pub(super) back: [f32; 3],
    /// Energy of the scattered lobes before F_t, RGB.
    pub(super) energy: [[f32; 3]; 3],
    /// Energy of the diffuse lobe, RGB.
    pub(super) diffuse: [f32; 3],
    /// Fraction of scattered light that leaves without reflection.
    pub(super) through: f32,
    /// For the model as published.
    pub(super) published: Option<PublishedHit>,
}

/// What the model as published needs of a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct PublishedHit {
    pub(super) reading: Reading,
    /// Energy that each pass scatters, RGB, before it leaves.
    pub(super) entering: [[f32; 3]; 3],
    /// Length of the way out through the cortex, and factor of ⟨L⟩ in the medulla, in fibre radii.
    pub(super) lengths: [f32; 2],
}

/// A hit of the fibre.
#[derive(Clone, Copy, Debug)]
pub struct Yan2015Hit<'m> {
    pub(super) model: &'m Yan2015,
    pub(super) unscattered: Factored<Plane, GaussiansAt<'m>>,
    pub(super) scattered: Option<Scattered>,
    /// Probabilities of the eight unscattered lobes together, of the three scattered lobes, and of the diffuse lobe.
    pub(super) probability: [f32; 5],
    /// Probability of the diffuse lobe, including samples of scattered lobes that cannot leave.
    pub(super) diffuse_probability: f32,
}

/// Energies, RGB, and densities per solid angle of the three scattered lobes before F_t, F_t itself, and the density of
/// the diffuse lobe.
struct ScatteredDensities {
    energy: [[f32; 3]; 3],
    lobes: [f32; 3],
    transmission: f32,
    diffuse: f32,
}

impl PublishedHit {
    /// The energy of a pass after absorption on its way out, RGB.
    fn leaving(&self, pass: usize, mean_path: f32, model: &Yan2015) -> [f32; 3] {
        let [cortex, medulla] = [self.lengths[0], self.lengths[1] * mean_path];
        let depth = |c: usize| cortex * model.fiber.sigma_ca[c] + medulla * model.fiber.sigma_ma[c];
        [0, 1, 2].map(|c| self.entering[pass][c] * (-depth(c)).exp())
    }
}

impl Yan2015Hit<'_> {
    /// The backward and forward C^M in the medulla for light that leaves at θᵢ, and F_t.
    #[inline(always)]
    fn inclined(&self, s: &Scattered, o: &Outgoing<f32>) -> ([f32; 2], f32) {
        let model = self.model;
        let interfaces = Interfaces { eta_c: model.fiber.eta, eta_m: model.eta_m, layers: model.fiber.layers };
        let sin_m = o.sin_i / model.eta_m;
        let theta_m = sin_m.atan2(((1.0 - sin_m) * (1.0 + sin_m)).max(0.0).sqrt());
        let halves = match &s.published {
            None => model.medulla.longitudinal(&s.inclination, theta_m),
            Some(published) => published.reading.along(theta_m),
        };
        (halves, interfaces.transmission(o.sin_i, o.cos_i))
    }

    #[inline(always)]
    fn scattered_densities(&self, s: &Scattered, o: &Outgoing<f32>) -> ScatteredDensities {
        let model = self.model;
        let ([back, front], transmission) = self.inclined(s, o);
        let (mut energy, mut lobes) = (s.energy, [0.0; 3]);
        for i in 0..3 {
            if self.probability[1 + i] > 0.0 {
                let phi = wrap(o.phi - s.back[i]);
                let longitudinal = back + (front - back) * (phi.abs() * FRAC_1_PI);
                let azimuthal = match &s.published {
                    None => model.medulla.azimuthal(&s.azimuth, phi),
                    Some(published) => {
                        let [density, mean_path] = published.reading.around(phi);
                        energy[i] = published.leaving(i, mean_path, model);
                        density
                    }
                };
                lobes[i] = longitudinal * azimuthal / model.eta_m;
            }
        }
        ScatteredDensities { energy, lobes, transmission, diffuse: o.cos_i * (FRAC_1_PI * FRAC_1_PI) }
    }

    #[inline(always)]
    fn eval_outgoing(&self, o: &Outgoing<f32>) -> (Lobes, f32) {
        let densities = self.unscattered.densities(o);
        let mut lobes = self.unscattered.lobes_of(densities);
        let mut pdf = self.unscattered.pdf_of(densities) * self.probability[0];
        if let Some(s) = &self.scattered {
            let d = self.scattered_densities(s, o);
            for i in 0..3 {
                let value = d.lobes[i] * d.transmission;
                (0..3).for_each(|c| lobes.0[SCATTERED[i] as usize][c] += d.energy[i][c] * value);
                pdf += if self.model.original_sampling { 0.0 } else { self.probability[1 + i] * d.lobes[i] };
            }
            (0..3).for_each(|c| lobes.0[Lobe::Rest as usize][c] += s.diffuse[c] * d.diffuse);
            let even = if self.model.original_sampling {
                self.probability[1..].iter().sum()
            } else {
                self.diffuse_probability
            };
            pdf += even * (0.25 * FRAC_1_PI);
        }
        (lobes, pdf)
    }

    /// f·cos θᵢ of the twelve lobes of the model, in the order of [`super::LOBES`], RGB.
    pub fn lobes(&self, wi: Vec3) -> [[f32; 3]; 12] {
        let o = self.unscattered.frame.outgoing(wi.to_array());
        let mut densities = [0.0; 12];
        densities[..8].copy_from_slice(&self.unscattered.densities(&o).to_array());
        let mut energy = self.amplitudes();
        if let Some(s) = &self.scattered {
            let d = self.scattered_densities(s, &o);
            (0..3).for_each(|i| densities[8 + i] = d.lobes[i] * d.transmission);
            densities[11] = d.diffuse;
            energy[8..11].copy_from_slice(&d.energy);
        }
        std::array::from_fn(|i| energy[i].map(|a| a * densities[i]))
    }

    /// Energies of all twelve lobes. Those of the scattered lobes are before F_t.
    fn amplitudes(&self) -> [[f32; 3]; 12] {
        let mut all = [[0.0; 3]; 12];
        for c in 0..3 {
            (0..8).for_each(|i| all[i][c] = self.unscattered.energies()[c][i]);
        }
        if let Some(s) = &self.scattered {
            all[8..11].copy_from_slice(&s.energy);
            all[11] = s.diffuse;
        }
        all
    }

    /// Energies of the twelve lobes of the model, in the order of [`super::LOBES`], RGB.
    pub fn lobe_energies(&self) -> [[f32; 3]; 12] {
        let mut all = self.amplitudes();
        if let Some(s) = &self.scattered {
            all[8..11].iter_mut().flatten().for_each(|a| *a *= s.through);
        }
        all
    }

    /// Samples lobe `i` of the five in `probability`. `left` is the rescaled random number of the selection.
    #[inline(always)]
    fn draw(&self, i: usize, left: f32, u: [f32; 5]) -> (Lobe, Outgoing<f32>) {
        let at = |sin_i: f32, phi: f32| {
            let cos_i = ((1.0 - sin_i) * (1.0 + sin_i)).max(0.0).sqrt();
            Outgoing { sin_i, cos_i, theta_i: sin_i.atan2(cos_i), phi }
        };
        match &self.scattered {
            Some(s) if (1..4).contains(&i) => {
                let medulla = &self.model.medulla;
                let relative = medulla.sample_azimuth(&s.azimuth, u[3]);
                let theta_m = medulla.sample_inclination(&s.inclination, wrap(relative), [u[1], u[2]]);
                let sin_i = self.model.eta_m * theta_m.sin();
                if sin_i.abs() < 1.0 {
                    (SCATTERED[i - 1], at(sin_i, relative + s.back[i - 1]))
                } else {
                    // Under total reflection, samples the diffuse lobe with unused random numbers.
                    (Lobe::Rest, at(2.0 * left - 1.0, TAU * u[4]))
                }
            }
            Some(_) if i == 4 => (Lobe::Rest, at(2.0 * u[1] - 1.0, TAU * u[3])),
            _ => {
                let (lane, _) = choose(&largest_channel(self.unscattered.energies()), left);
                (NAMES[lane], self.unscattered.draw(lane, [u[1], u[2], u[3]]))
            }
        }
    }
}

impl Yan2015Hit<'_> {
    /// Samples as [`Yan2015::with_original_sampling`] describes.
    fn sample_originally(&self, i: usize, left: f32, u: [f32; 5]) -> Option<Sample> {
        let (lobe, o, weight) = match &self.scattered {
            Some(s) if i > 0 => {
                // Uniform over the sphere.
                let sin_i = 2.0 * u[1] - 1.0;
                let cos_i = ((1.0 - sin_i) * (1.0 + sin_i)).max(0.0).sqrt();
                let o = Outgoing { sin_i, cos_i, theta_i: sin_i.atan2(cos_i), phi: TAU * u[3] };
                let d = self.scattered_densities(s, &o);
                let (lobe, energy, density) = match i {
                    4 => (Lobe::Rest, s.diffuse, d.diffuse),
                    _ => (SCATTERED[i - 1], d.energy[i - 1], d.lobes[i - 1] * d.transmission),
                };
                (lobe, o, energy.map(|a| a * density * 4.0 * PI / self.probability[i]))
            }
            _ => {
                let largest = largest_channel(self.unscattered.energies());
                let (lane, _) = choose(&largest, left);
                // The Gaussians cancel: the weight is the energy over the probability of the lobe.
                let share = largest[lane] / largest.iter().sum::<f32>() * self.probability[0];
                let weight = [0, 1, 2].map(|c| self.unscattered.energies()[c][lane] / share.max(f32::MIN_POSITIVE));
                (NAMES[lane], self.unscattered.draw(lane, [u[1], u[2], u[3]]), weight)
            }
        };
        let (_, pdf) = self.eval_outgoing(&o);
        Sample::new(direction(&self.unscattered.frame, &o), pdf, weight, lobe)
    }
}

/// C^M is a blend of its backward and forward half by |φ|. This gives two terms, and the diffuse lobe is a third.
impl Separable for Yan2015Hit<'_> {
    #[inline]
    fn add_lanes(&self, phis: &[f32], weight: f32, sums: &mut [AzimuthalSums]) {
        self.unscattered.add_lanes(phis, weight, sums);
    }

    fn add_others(&self, phis: &[f32], weight: f32, sums: &mut [AzimuthalSums]) {
        let Some(s) = &self.scattered else { return };
        let diffuse = s.diffuse.map(|a| a * weight);
        let lobe = |i: usize| (self.probability[1 + i] > 0.0).then(|| (s.back[i], s.energy[i].map(|a| a * weight)));
        let lobes = [lobe(0), lobe(1), lobe(2)];
        for (phi, sum) in phis.iter().zip(sums) {
            for (back, energy) in lobes.iter().flatten() {
                let relative = wrap(phi - back);
                let density = self.model.medulla.azimuthal(&s.azimuth, relative);
                let forward = density * relative.abs() * FRAC_1_PI;
                for c in 0..3 {
                    sum.others[0][c] += energy[c] * density;
                    sum.others[1][c] += energy[c] * forward;
                }
            }
            (0..3).for_each(|c| sum.others[2][c] += diffuse[c]);
        }
    }

    fn longitudinal(&self, o: &Outgoing<f32>) -> LongitudinalFactors {
        let others = self.scattered.as_ref().map_or([0.0; 3], |s| {
            let ([back, front], transmission) = self.inclined(s, o);
            let out = transmission / self.model.eta_m;
            [back * out, (front - back) * out, o.cos_i * (FRAC_1_PI * FRAC_1_PI)]
        });
        LongitudinalFactors { lanes: self.unscattered.longitudinal(o).lanes, others }
    }

    fn exits(&self) -> [f32; 8] {
        self.unscattered.exits()
    }
}

impl Scattering for Yan2015Hit<'_> {
    fn energy(&self) -> Lobes {
        let mut lobes = self.unscattered.energy();
        let energies = self.lobe_energies();
        let rest = [SCATTERED[0], SCATTERED[1], SCATTERED[2], Lobe::Rest];
        for (name, energy) in rest.into_iter().zip(&energies[8..]) {
            (0..3).for_each(|c| lobes.0[name as usize][c] += energy[c]);
        }
        lobes
    }

    #[inline]
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        self.eval_outgoing(&self.unscattered.frame.outgoing(wi.to_array()))
    }

    #[inline]
    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        let (i, left) = choose(&self.probability, u[0]);
        if self.model.original_sampling {
            return self.sample_originally(i, left, u);
        }
        let (lobe, outgoing) = self.draw(i, left, u);
        let (lobes, pdf) = self.eval_outgoing(&outgoing);
        let weight = factored::weight(lobes.total(), pdf);
        Sample::new(direction(&self.unscattered.frame, &outgoing), pdf, weight, lobe)
    }
}
