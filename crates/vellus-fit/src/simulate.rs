//! Synthetic measurements of a model, or of a whole fibre that is traced photon by photon, without a model.

use crate::absorption::Absorption;
use crate::aperture::{Aperture, distance};
use crate::error::Error;
use crate::forward::Forward;
use crate::parameters::{Kind, Parameter, values_of};
use crate::profile::{Point, Profile, Quantity, check_angles, check_blur};
use crate::specimen::Specimen;
use rand::{Rng, SeedableRng};
use std::f64::consts::TAU;
use std::fmt;
use vellus::Fiber;
use vellus_io::Progress;
use vellus_models::Directions;
use vellus_reference::simulate::medulla::SimRng;
use vellus_reference::simulate::profile::{Cells, profile};

/// A simulated gantry: its angles, sampling and noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Synthetic {
    /// Inclination of the fixed direction, degrees.
    pub theta_o: f64,
    /// First and last θ, degrees.
    pub theta: [f64; 2],
    /// First and last φ, degrees.
    pub phi: [f64; 2],
    /// Steps over θ and φ, degrees.
    pub step: [f64; 2],
    /// Standard deviation of the logarithm of each value. 0.02 is noise of 2 %.
    pub noise: f64,
    /// Share of missing directions, in [0, 0.9]. They form patches, as if an arm of the gantry hid the light.
    pub gaps: f64,
    /// The factor on the values, because the unit of a gantry is arbitrary.
    pub scale: f64,
    /// Light that does not come from the fibre, in the unit of the scaled values.
    pub background: f64,
    /// Full widths over θ and φ of the cell over which each value is an average, degrees. A traced fibre has cells of
    /// the size of `step` instead.
    pub blur: [f64; 2],
    /// Number of channels: 1 (grey, the red channel of the fibre) or 3 (RGB).
    pub channels: usize,
    /// The random seed of noise, gaps and photons.
    pub seed: u64,
}

impl Default for Synthetic {
    /// The range of the measurements of Yan et al. 2015 in steps of 2°, with 2 % of noise and 10 % of gaps.
    fn default() -> Self {
        Synthetic {
            theta_o: -30.0,
            theta: [10.0, 50.0],
            phi: [-20.0, 200.0],
            step: [2.0, 2.0],
            noise: 0.02,
            gaps: 0.1,
            scale: 1.0,
            background: 0.0,
            blur: [0.0; 2],
            channels: 1,
            seed: 1,
        }
    }
}

impl fmt::Display for Synthetic {
    /// Noise, gaps, scale and seed in words, for the head of a file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Synthetic { noise, gaps, scale, background, seed, .. } = self;
        write!(f, "noise {noise}, gaps {gaps}, scale {scale}, background {background}, seed {seed}")
    }
}

impl Synthetic {
    /// θ and φ of the rows and columns.
    fn axes(&self) -> Result<[Vec<f64>; 2], Error> {
        let wrong = |what: String| Error::Profile(what);
        for (name, x, low, high) in
            [("noise", self.noise, 0.0, 1.0), ("gaps", self.gaps, 0.0, 0.9), ("theta_o", self.theta_o, -89.9, 89.9)]
        {
            if !(low..=high).contains(&x) {
                return Err(wrong(format!("{name} = {x} is out of range: it must be in [{low}, {high}]")));
            }
        }
        if !(self.scale > 0.0 && self.scale.is_finite()) {
            return Err(wrong(format!("scale = {} is out of range: it must be above 0", self.scale)));
        }
        if !(self.background >= 0.0 && self.background.is_finite()) {
            return Err(wrong(format!("background = {} is out of range: it must be at least 0", self.background)));
        }
        check_blur(self.blur)?;
        let axis = |name: &str, [first, last]: [f64; 2], step: f64| {
            if !(step > 0.0 && last > first && (last - first) / step <= 4000.0) {
                return Err(wrong(format!("{name} from {first} to {last} in steps of {step} is no range of angles")));
            }
            let count = ((last - first) / step + 1e-9).floor() as usize + 1;
            Ok((0..count).map(|i| first + i as f64 * step).collect::<Vec<f64>>())
        };
        let axes = [axis("theta", self.theta, self.step[0])?, axis("phi", self.phi, self.step[1])?];
        for &theta in &axes[0] {
            check_angles(theta, 0.0).map_err(wrong)?;
        }
        for &phi in &axes[1] {
            check_angles(0.0, phi).map_err(wrong)?;
        }
        Ok(axes)
    }

    /// Adds background, noise and gaps. `values` are row by row, with θ constant along a row.
    /// Profiles with different `number`s have the same gaps and different noise.
    fn measure(&self, [thetas, phis]: &[Vec<f64>; 2], values: &[[f64; 3]], number: usize) -> Profile {
        let mut rng = SimRng::seed_from_u64(self.seed);
        let mut unit = move || (rng.next_u64() >> 11) as f64 * (0.5f64).powi(53);
        let (rows, columns) = (thetas.len(), phis.len());
        let mut hidden = vec![false; rows * columns];
        // Hides patches of up to a sixth of each side.
        let goal = (self.gaps * hidden.len() as f64).round() as usize;
        let mut count = 0;
        while count < goal {
            let mut side = |n: usize| 1 + (unit() * (n as f64 / 6.0)) as usize;
            let (high, wide) = (side(rows), side(columns));
            let (top, left) = ((unit() * rows as f64) as usize, (unit() * columns as f64) as usize);
            for row in top..rows.min(top + high) {
                for column in left..columns.min(left + wide) {
                    let cell = &mut hidden[row * columns + column];
                    if !*cell && count < goal {
                        *cell = true;
                        count += 1;
                    }
                }
            }
        }
        let mut normal = || (-2.0 * (1.0 - unit()).ln()).sqrt() * (TAU * unit()).cos();
        for _ in 0..3 * values.len() * number {
            normal();
        }
        let (mut points, mut missing) = (Vec::new(), Vec::new());
        for (i, value) in values.iter().enumerate() {
            let (theta, phi) = (thetas[i / columns], phis[i % columns]);
            let value = value.map(|x| (x * self.scale + self.background) * (self.noise * normal()).exp());
            if hidden[i] || value[..self.channels].contains(&0.0) {
                missing.push([theta, phi]);
            } else {
                points.push(Point { theta, phi, value, sigma: None });
            }
        }
        Profile {
            theta_o: self.theta_o,
            quantity: Quantity::FCos,
            channels: self.channels,
            channel: String::new(),
            blur: self.blur,
            points,
            missing,
            negative: 0,
            simulated: Vec::new(),
        }
    }
}

/// The object of a synthetic measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// The far field of a model.
    Model(Forward, Specimen),
    /// A whole fibre, traced with this number of photons. See [`from_reference`].
    Reference(Fiber, u64),
}

impl Source {
    /// Measures with a simulated gantry. A cancelled simulation ends early, and its result means nothing.
    ///
    /// # Errors
    /// As [`from_model`] and [`from_reference`].
    pub fn measure(&self, gantry: &Synthetic, progress: &dyn Progress) -> Result<Profile, Error> {
        match self {
            Source::Model(model, specimen) => from_model(*model, specimen, gantry),
            Source::Reference(fiber, photons) => from_reference(fiber, gantry, *photons, progress),
        }
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Source::Model(model, Specimen { eta_m: Some(eta_m), .. }) => {
                write!(f, "the far field of {}, eta_m {eta_m}", model.kind())
            }
            Source::Model(model, _) => write!(f, "the far field of {}", model.kind()),
            Source::Reference(_, photons) => write!(f, "the whole fibre, {photons} photons"),
        }
    }
}

/// Measures the far field of a model, exactly: [`Forward::exact_values`].
///
/// # Errors
/// [`Error::Fiber`] for a fibre out of range, [`Error::Profile`] for a gantry out of range.
pub fn from_model(model: Forward, specimen: &Specimen, synthetic: &Synthetic) -> Result<Profile, Error> {
    numbered(model, specimen, synthetic, 0)
}

/// The same in any number of channels: one grey profile for each absorption, with the same gaps.
/// [`Synthetic::channels`] does not count.
///
/// # Errors
/// As [`from_model`].
pub fn channels(
    model: Forward,
    specimen: &Specimen,
    absorptions: &[Absorption],
    synthetic: &Synthetic,
) -> Result<Vec<Profile>, Error> {
    let measure = |(number, absorption): (usize, &Absorption)| {
        let specimen = Specimen { fiber: absorption.apply(&specimen.fiber), ..*specimen };
        let profile = numbered(model, &specimen, &Synthetic { channels: 1, ..*synthetic }, number)?;
        Ok(Profile { channel: absorption.channel.clone(), ..profile })
    };
    absorptions.iter().enumerate().map(measure).collect()
}

fn numbered(model: Forward, specimen: &Specimen, synthetic: &Synthetic, number: usize) -> Result<Profile, Error> {
    let axes = synthetic.axes()?;
    let angles = axes[0].iter().flat_map(|&theta| axes[1].iter().map(move |&phi| [theta, phi]));
    let cells = Aperture::new(synthetic.blur, Quantity::FCos, angles, distance(&specimen.fiber));
    let mut values = vec![[0.0f32; 3]; cells.angles().len()];
    model.exact_values(specimen, synthetic.theta_o, &Directions::new(cells.angles()), &mut values)?;
    let simulated = truth(model, specimen, synthetic);
    Ok(Profile { simulated, ..synthetic.measure(&axes, &cells.averages(&values), number) })
}

/// The names and values of a model's parameters.
fn truth(model: Forward, specimen: &Specimen, synthetic: &Synthetic) -> Vec<(String, f64)> {
    let parameters = model.parameters(synthetic.channels);
    let values = values_of(&parameters, &specimen.fiber, synthetic.theta_o, synthetic.scale);
    let value = |(p, x): (Parameter, f64)| match (p.kind, specimen.eta_m) {
        (Kind::EtaM, Some(eta_m)) => (p.name, f64::from(eta_m)),
        // A fibre stores f32. Its shortest digits are those that were given.
        (Kind::Fiber(..), _) => (p.name, rounded(x)),
        (Kind::Background, _) => (p.name, synthetic.background),
        _ => (p.name, x),
    };
    parameters.into_iter().zip(values).map(value).collect()
}

/// A value that was stored as f32, with the digits that an f32 has.
fn rounded(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

/// Measures a whole fibre with a rough cuticle and tilted scales, traced with `photons` photons. The value of a
/// direction is the average over a cell of the size of the steps. A cancelled simulation ends early, and its result
/// means nothing.
///
/// # Errors
/// As [`from_model`].
pub fn from_reference(
    fiber: &Fiber,
    synthetic: &Synthetic,
    photons: u64,
    progress: &dyn Progress,
) -> Result<Profile, Error> {
    let axes = synthetic.axes()?;
    let [theta, phi] = [0, 1].map(|i: usize| axes[i].iter().map(|x| x.to_radians()).collect());
    let cells = Cells { theta, phi, size: synthetic.step.map(f64::to_radians) };
    let values = profile(fiber, synthetic.theta_o.to_radians(), &cells, photons, synthetic.seed, progress)?;
    let simulated = truth(Forward::default(), &(*fiber).into(), synthetic);
    Ok(Profile { simulated, blur: synthetic.step, ..synthetic.measure(&axes, &values, 0) })
}
