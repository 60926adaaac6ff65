//! The residuals of a fit: log-ratios of predicted to measured values (Yan17 Sec. 5.1, Validation).

use crate::aperture::Aperture;
use crate::error::Error;
use crate::forward::{Forward, Recent};
use crate::parameters::Setup;
use crate::profile::{Point, Profile};
use crate::space::Space;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use vellus_models::Directions;

/// The least value of a model. It keeps logarithms finite.
const FLOOR: f64 = 1e-30;

/// How many residuals of a part are kept for each thread: more than the variables of a medulla, which change all parts
/// and come between those of the absorption.
const KEPT: usize = 16;

/// Residuals of a part that were computed last, with what they belong to.
type Recently = Mutex<VecDeque<(Setup, Arc<[f64]>)>>;

/// Profiles or parts of them, prepared for comparisons with a model.
pub struct Cost<'a> {
    space: &'a Space,
    forward: Forward,
    recent: Recent,
    parts: Vec<Part>,
    /// For each part of several. A variable of one part does not change the others: most variables of many channels
    /// are absorptions of one.
    known: Vec<Recently>,
    channels: usize,
    /// How many values of the model were computed.
    pub evaluations: AtomicU64,
}

/// One profile, or a part of it.
#[derive(Clone)]
struct Part {
    aperture: Aperture,
    directions: Directions,
    /// The logarithm of each measured value, point by point and channel by channel.
    logs: Vec<f64>,
    /// The factor on each log-ratio. See [`weights`].
    weights: Vec<f64>,
    /// The factor on each value of the model. See [`Cost::corrected`].
    corrections: Vec<f64>,
}

/// Factors on the log-ratios of a profile, point by point and channel by channel: the typical relative standard
/// deviation divided by that of each value. 1 if the profile has none.
pub(crate) fn weights(profile: &Profile) -> Vec<f64> {
    let log = |p: &Point, c: usize| p.sigma.map_or(0.0, |sigma| (sigma[c] / p.value[c]).ln());
    let logs: Vec<f64> = profile.points.iter().flat_map(|p| (0..profile.channels).map(move |c| log(p, c))).collect();
    let mean = logs.iter().sum::<f64>() / logs.len() as f64;
    logs.into_iter().map(|x| (mean - x).exp()).collect()
}

impl Part {
    fn new(profile: &Profile, chosen: &[usize], distance: [f64; 2]) -> Self {
        let channels = profile.channels;
        let weights = weights(profile);
        let centres = chosen.iter().map(|&i| [profile.points[i].theta, profile.points[i].phi]);
        let aperture = Aperture::new(profile.blur, profile.quantity, centres, distance);
        let logs = |&i: &usize| profile.points[i].value.into_iter().take(channels).map(f64::ln);
        Part {
            directions: Directions::new(aperture.angles()),
            aperture,
            logs: chosen.iter().flat_map(logs).collect(),
            weights: chosen.iter().flat_map(|i| &weights[i * channels..(i + 1) * channels]).copied().collect(),
            corrections: vec![1.0; chosen.len() * channels],
        }
    }

    /// The values of the model, averaged over the cell of each point, without scale and background.
    fn averages(&self, channels: usize, values: &[[f32; 3]]) -> Vec<f64> {
        let averages = self.aperture.averages(values);
        averages.into_iter().flat_map(|rgb| rgb.into_iter().take(channels)).collect()
    }
}

impl<'a> Cost<'a> {
    /// Compares with the points of each profile whose indices are `chosen`. `distance` is that of the directions in a
    /// cell over θ and φ, degrees.
    pub fn new(
        profiles: &[Profile],
        chosen: &[Vec<usize>],
        space: &'a Space,
        forward: Forward,
        distance: [f64; 2],
    ) -> Self {
        let part = |(profile, chosen): (&Profile, &Vec<usize>)| Part::new(profile, chosen, distance);
        let parts: Vec<Part> = profiles.iter().zip(chosen).map(part).collect();
        let channels = profiles.first().map_or(1, |profile| profile.channels);
        let known = parts.iter().map(|_| Recently::default()).collect();
        Cost { space, forward, recent: Recent::default(), parts, known, channels, evaluations: AtomicU64::new(0) }
    }

    /// ln(fitted/measured) of each value times its weight: profile by profile, point by point and channel by channel,
    /// for the variables `u`. All are infinite if the model refuses the fibre, which does not happen within the bounds.
    pub fn residuals(&self, u: &[f64]) -> Vec<f64> {
        let values = self.space.values(u);
        let mut residuals = Vec::new();
        for k in 0..self.parts.len() {
            let setup = self.space.setup(k, &values);
            if self.parts.len() == 1 {
                return self.compared(k, &setup);
            }
            // The list is complete even if a thread panicked.
            let lock = || self.known[k].lock().unwrap_or_else(PoisonError::into_inner);
            let find = |known: &mut VecDeque<(Setup, Arc<[f64]>)>| {
                let place = known.iter().position(|(other, _)| *other == setup)?;
                let found = known.remove(place)?;
                known.push_front(found.clone());
                Some(found.1)
            };
            let found = find(&mut lock());
            residuals.extend_from_slice(&found.unwrap_or_else(|| {
                let computed: Arc<[f64]> = self.compared(k, &setup).into();
                let mut known = lock();
                known.truncate(KEPT * rayon::current_num_threads() - 1);
                known.push_front((setup, computed.clone()));
                computed
            }));
        }
        residuals
    }

    /// The residuals of one part.
    fn compared(&self, k: usize, setup: &Setup) -> Vec<f64> {
        let (part, Setup { specimen, theta_o, scale, background }) = (&self.parts[k], setup);
        self.evaluations.fetch_add(part.directions.len() as u64, Ordering::Relaxed);
        let mut out = vec![[0.0; 3]; part.directions.len()];
        if self.forward.values_with(&self.recent, specimen, *theta_o, &part.directions, &mut out).is_err() {
            return vec![f64::INFINITY; part.logs.len()];
        }
        let averages = part.averages(self.channels, &out);
        let fitted = averages.iter().zip(&part.corrections).map(|(f, c)| scale * c * f.max(FLOOR) + background);
        fitted.zip(&part.logs).zip(&part.weights).map(|((f, log), w)| w * (f.ln() - log)).collect()
    }

    /// Splits residuals by profile.
    pub fn parts<'r>(&self, mut residuals: &'r [f64]) -> impl Iterator<Item = &'r [f64]> {
        self.parts.iter().map(move |part| {
            let (first, rest) = residuals.split_at(part.logs.len());
            residuals = rest;
            first
        })
    }

    /// The same, with the values of the model multiplied by their ratio to the values by quadrature at `u`. The values
    /// are then exact at `u`, and nearly exact close to it.
    ///
    /// # Errors
    /// [`Error::Fiber`] if the model refuses the fibre.
    pub fn corrected(&self, u: &[f64]) -> Result<Self, Error> {
        let values = self.space.values(u);
        let mut parts = Vec::new();
        for (k, part) in self.parts.iter().enumerate() {
            let Setup { specimen, theta_o, .. } = self.space.setup(k, &values);
            let mut out = [vec![[0.0; 3]; part.directions.len()], vec![[0.0; 3]; part.directions.len()]];
            self.forward.values_with(&self.recent, &specimen, theta_o, &part.directions, &mut out[0])?;
            self.forward.exact_values(&specimen, theta_o, &part.directions, &mut out[1])?;
            let [fast, exact] = out.map(|values| part.averages(self.channels, &values));
            let corrections = exact.iter().zip(&fast).map(|(e, f)| e.max(FLOOR) / f.max(FLOOR)).collect();
            parts.push(Part { corrections, ..part.clone() });
        }
        let known = parts.iter().map(|_| Recently::default()).collect();
        Ok(Cost { recent: Recent::default(), parts, known, evaluations: AtomicU64::new(0), ..*self })
    }
}
