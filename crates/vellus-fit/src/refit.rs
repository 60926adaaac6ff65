//! Fits a fibre to the far field of another fibre that scattered light leaves in a different way.
//!
//! Yan17 Table 4 was fitted to measurements with the open exit. The same numbers give a darker fibre with the
//! reflecting exit. We had no access to the measurements, so the far field of the published fibre takes their place.

use crate::aperture::ROUGH;
use crate::cost::Cost;
use crate::error::Error;
use crate::fit::errors;
use crate::forward::Forward;
use crate::least_squares::{Difference, Minimum, Problem};
use crate::parameters::{Kind, Name, values_of};
use crate::profile::Profile;
use crate::simulate::{Synthetic, from_model};
use crate::space::{Requests, Space};
use rayon::prelude::*;
use vellus::{Bcsdf, Fiber, Parameter, ScatterExit};
use vellus_io::Progress;
use vellus_models::energies;

/// The inclinations of ω_o whose profiles are fitted, degrees.
const INCLINATIONS: [f64; 3] = [0.0, 30.0, 60.0];

/// The parameters that are fitted. The others describe the cuticle and its highlight, and keep their values.
const FITTED: [Parameter; 5] =
    [Parameter::Kappa, Parameter::SigmaCa, Parameter::SigmaMs, Parameter::SigmaMa, Parameter::G];

/// The largest values that count as those of a fibre.
const LARGEST: [(Parameter, f64); 3] = [(Parameter::Kappa, 0.95), (Parameter::SigmaMs, 6.0), (Parameter::G, 0.9)];

/// The weight of each point of a profile. A residual is a log-ratio times √value, which lies between a log-ratio, for
/// which dark directions count as much as bright ones, and a difference, for which only highlights count.
fn weights(profile: &Profile) -> Vec<f64> {
    let values = || profile.points.iter().map(|p| p.value[0]);
    let mean = values().sum::<f64>() / profile.points.len() as f64;
    values().map(|value| (value / mean).sqrt()).collect()
}

/// The residual of a brightness counts as much as this share of the residuals of a profile.
const BRIGHTNESS: f64 = 1.0;

/// Absorptions of the cortex with which the fibres must have the same brightness, too.
const PIGMENTS: [f32; 4] = [0.0, 0.1, 0.4, 1.2];

/// The share of light that a thick coat of fibres with this albedo reflects, if they scatter light evenly: that of a
/// half space in the two-flux approximation. It is more sensitive to a high albedo than the albedo itself.
fn brightness(albedo: f64) -> f64 {
    let s = (1.0 - albedo.min(1.0)).sqrt();
    (1.0 - s) / (1.0 + s)
}

/// Factors on the three σ and values of g of the starts.
const STARTS: ([f64; 2], [f32; 2]) = ([1.0, 0.3], [0.2, 0.6]);

/// The result of [`refit`].
#[derive(Clone, Debug)]
pub struct Refit {
    /// The fitted fibre.
    pub fiber: Fiber,
    /// The NRMSE of all profiles together, as in [`Fit::nrmse`](crate::Fit::nrmse).
    pub nrmse: f64,
    /// For θ_o = 0°, 30° and 60°, the NRMSE of its profile.
    pub nrmse_at: [f64; 3],
    /// For θ_o = 0°, 30° and 60°, the RMS of the log-ratios of its profile.
    pub log_ratio: [f64; 3],
    /// For θ_o = 0°, 30° and 60°, the total albedo of the target and of the fitted fibre.
    pub albedo: [[f64; 2]; 3],
}

/// The total albedo of a fibre for ω_o at `theta` degrees, averaged over its width. The first channel.
fn albedo(fiber: &Fiber, theta: f64) -> Result<f64, Error> {
    let model = Bcsdf::new(fiber)?;
    Ok(energies(&model, theta, None).iter().map(|lobe| lobe[0]).sum())
}

/// Fits a fibre with the given exit to the far field of `target`. Only the first channel of absorption counts.
///
/// The profiles are absolute and cover the sphere in steps of 8° and 6°, at three inclinations. The brightness of a
/// thick coat must match, too, for the fibre itself and for other absorptions of the cortex. κ, g and the three σ are
/// fitted. The refractive index, the cuticle and the roughness keep their values.
///
/// # Errors
/// [`Error::Fiber`] for a fibre out of range. [`Error::Parameter`] for a fibre whose parameters no fit has.
pub fn refit(target: &Fiber, exit: ScatterExit, progress: &dyn Progress) -> Result<Refit, Error> {
    let forward = Forward::default();
    let mut requests = Requests::default();
    for p in forward.parameters(1) {
        let Kind::Fiber(parameter, _) = p.kind else { continue };
        if !FITTED.contains(&parameter) {
            requests.fix.push((Name::Fiber(parameter, None), vec![values_of(&[p], target, 0.0, 1.0)[0]]));
        }
    }
    requests.fix.push((Name::Scale, vec![1.0]));
    let mut profiles: Vec<(Profile, Space, Vec<f64>)> = Vec::new();
    for theta_o in INCLINATIONS {
        let gantry = Synthetic {
            theta_o,
            theta: [-80.0, 80.0],
            phi: [0.0, 180.0],
            step: [8.0, 6.0],
            noise: 0.0,
            gaps: 0.0,
            ..Synthetic::default()
        };
        let profile = from_model(forward, &(*target).into(), &gantry)?;
        let mut space = Space::new(forward, std::slice::from_ref(&profile), &requests)?.with_exit(exit)?;
        for (parameter, largest) in LARGEST {
            if let Some(column) = space.column_of(0, Kind::Fiber(parameter, 0)) {
                let curve = space.lead(column).curve;
                space.bounds[column][1] = curve.variable(largest);
            }
        }
        let pigments = PIGMENTS.map(|x| target.with_absorption([x; 3]));
        let fibers = std::iter::once(*target).chain(pigments);
        let albedos = fibers.map(|f| albedo(&f, theta_o)).collect::<Result<Vec<f64>, _>>()?;
        profiles.push((profile, space, albedos));
    }
    let all = |profile: &Profile| [(0..profile.points.len()).collect::<Vec<_>>()];
    let costs: Vec<Cost> = profiles
        .iter()
        .map(|(p, space, _)| Cost::new(std::slice::from_ref(p), &all(p), space, forward, ROUGH))
        .collect();
    let space = &profiles[0].1;
    let fiber_at = |u: &[f64]| space.setup(0, &space.values(u)).specimen.fiber;
    let weights: Vec<Vec<f64>> = profiles.iter().map(|(profile, _, _)| weights(profile)).collect();
    let residuals = |u: &[f64]| -> Vec<f64> {
        let fiber = fiber_at(u);
        let parts = costs.iter().zip(&profiles).zip(&weights).map(|((cost, (profile, _, target)), weights)| {
            let mut part = cost.residuals(u);
            part.iter_mut().zip(weights).for_each(|(residual, weight)| *residual *= weight);
            let weight = (BRIGHTNESS * profile.points.len() as f64).sqrt();
            let ratio = |fiber: &Fiber, target: f64| {
                albedo(fiber, profile.theta_o).map_or(f64::INFINITY, |a| weight * (brightness(a) / target).ln())
            };
            part.push(ratio(&fiber, brightness(target[0])));
            for (pigment, target) in PIGMENTS.into_iter().zip(&target[1..]) {
                part.push(ratio(&fiber.with_absorption([pigment; 3]), brightness(*target)));
            }
            part
        });
        parts.flatten().collect()
    };
    let steps: Vec<f64> = space.leads.iter().map(|&lead| space.parameters[lead].step).collect();
    let problem =
        Problem { bounds: &space.bounds, steps: &steps, residuals: &residuals, huber: f64::INFINITY, progress };
    let starts: Vec<Fiber> = STARTS
        .0
        .into_iter()
        .flat_map(|factor| STARTS.1.map(|g| (factor, g)))
        .map(|(factor, g)| {
            let less = |sigma: [f32; 3]| sigma.map(|s| s * factor as f32);
            Fiber { sigma_ca: less(target.sigma_ca), sigma_ma: less(target.sigma_ma), g, ..*target }
        })
        .collect();
    let minima: Vec<Minimum> =
        starts.par_iter().map(|start| problem.minimise(&space.variables(start), Difference::Central, 100)).collect();
    let loss = |m: &Minimum| m.residuals.iter().map(|r| r * r).sum::<f64>();
    let best = minima.iter().min_by(|a, b| loss(a).total_cmp(&loss(b)));
    let Some(best) = best else { return Err(Error::Profile("no descent ended".to_owned())) };
    let fiber = fiber_at(&best.u);
    let mut result = Refit { fiber, nrmse: 0.0, nrmse_at: [0.0; 3], log_ratio: [0.0; 3], albedo: [[0.0; 2]; 3] };
    let (mut all_points, mut all_fitted) = (Vec::new(), Vec::new());
    for (i, ((profile, _, target), cost)) in profiles.iter().zip(&costs).enumerate() {
        let part = cost.residuals(&best.u);
        let fitted: Vec<[f64; 3]> =
            profile.points.iter().zip(&part).map(|(p, r)| p.value.map(|value| value * r.exp())).collect();
        result.nrmse_at[i] = errors(profile, &fitted).0;
        all_points.extend(&profile.points);
        all_fitted.extend(fitted);
        let squares: f64 = part.iter().map(|r| r * r).sum();
        result.log_ratio[i] = (squares / profile.points.len() as f64).sqrt();
        result.albedo[i] = [target[0], albedo(&fiber, INCLINATIONS[i])?];
    }
    let together = Profile { points: all_points, ..profiles[0].0.clone() };
    result.nrmse = errors(&together, &all_fitted).0;
    Ok(result)
}
