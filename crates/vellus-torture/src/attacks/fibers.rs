//! Random fibres over the whole valid space, through the library.

use super::Attack;
use crate::dice::Dice;
use crate::trial::{Stop, Trial};
use glam::{Quat, Vec3};
use std::panic::{AssertUnwindSafe, catch_unwind};
use vellus::{Bcsdf, Fiber, Lobe, Lobes, ScatterExit, Window};
use wide::f32x8;

/// The amount by which a near-field weight may exceed 1: a dozen roundings of numbers near 1, 12·6e-8, rounded up.
const WEIGHT: f32 = 1e-6;
/// The amount by which a near-field energy may exceed 1, or be below 1 without absorption: six terms of at most eight
/// roundings each, 6·8·6e-8 = 3e-6, and the roundings of the exponentials.
const ENERGY: f32 = 5e-6;
/// The same bound for a window, whose energies are sums over up to 64 Gauss points.
const WINDOW_ENERGY: f32 = 1e-4;
/// The bound for weights of windows: the largest channels of the lobes sum to at most 1, and the points of the
/// scattered lobes add their error.
const WINDOW_WEIGHT: f32 = 1.5;
/// The azimuth from the exit of a path to a direction is the sum of four angles up to π. Each is rounded by half a unit
/// in the last place, 1.2e-7, and two arctangents add as much again. Inclinations have fewer roundings.
const ANGLE_ERROR: f32 = 1e-6;

/// Fibres in one case.
const FIBERS: usize = 200;

pub struct Fibers;

impl Attack for Fibers {
    fn name(&self) -> &'static str {
        "fibres"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        for _ in 0..FIBERS {
            trial.tried += 1;
            let fiber = fiber(&mut trial.dice);
            let hits = Hits::new(&mut trial.dice);
            let checked = catch_unwind(AssertUnwindSafe(|| check(&fiber, &hits)));
            let place = || format!("{fiber:?}\n{hits:?}");
            match checked {
                Ok(Ok(())) => {}
                Ok(Err((kind, detail))) => trial.finding(kind, format!("{detail}\n{}", place())),
                Err(_) => trial.finding("panic in the library", place()),
            }
        }
        Ok(())
    }
}

/// Queries: the offsets and directions of hits.
#[derive(Debug)]
struct Hits {
    wo: [Vec3; 8],
    wi: [Vec3; 8],
    h: [f32; 8],
    width: f32,
    u: [[f32; 5]; 8],
}

impl Hits {
    fn new(dice: &mut Dice) -> Self {
        Hits {
            wo: std::array::from_fn(|_| direction(dice)),
            wi: std::array::from_fn(|_| direction(dice)),
            h: std::array::from_fn(|_| offset(dice)),
            width: *dice.pick(&[1e-6, 1e-4, 0.01, 0.1, 0.5, 1.0, 1.9, 2.0, 4.0]),
            u: std::array::from_fn(|_| std::array::from_fn(|_| uniform(dice))),
        }
    }
}

/// A number in [0, 1), sometimes one of its ends.
fn uniform(dice: &mut Dice) -> f32 {
    let largest = 1.0 - f32::EPSILON / 2.0;
    match dice.number(0..20) {
        0 => 0.0,
        1 => largest,
        2 => f32::MIN_POSITIVE,
        _ => (dice.unit() as f32).min(largest),
    }
}

/// A unit vector, sometimes along the axis or close to it.
fn direction(dice: &mut Dice) -> Vec3 {
    let theta = match dice.number(0..10) {
        0 => *dice.pick(&[-1.0, 1.0]) * std::f64::consts::FRAC_PI_2,
        1 => *dice.pick(&[-1.0, 1.0]) * (std::f64::consts::FRAC_PI_2 - 10f64.powf(dice.within(-8.0, -1.0))),
        2 => 0.0,
        _ => dice.within(-1.57, 1.57),
    };
    let phi = if dice.chance(0.1) { 0.0 } else { dice.within(-3.2, 3.2) };
    Vec3::new(theta.sin() as f32, (theta.cos() * phi.cos()) as f32, (theta.cos() * phi.sin()) as f32)
}

/// An offset in [−1, 1], more often close to the silhouettes and the middle.
fn offset(dice: &mut Dice) -> f32 {
    let sign = *dice.pick(&[-1.0f32, 1.0]);
    match dice.number(0..10) {
        0 => sign,
        1 => sign * (1.0 - 10f64.powf(dice.within(-7.5, -1.0)) as f32),
        2 => sign * 10f64.powf(dice.within(-20.0, -1.0)) as f32,
        3 => 0.0,
        _ => dice.within(-1.0, 1.0) as f32,
    }
}

/// A fibre of the whole valid space, more often at its limits or near a preset.
fn fiber(dice: &mut Dice) -> Fiber {
    fn value(dice: &mut Dice, lo: f64, hi: f64) -> f32 {
        match dice.number(0..8) {
            0 => lo as f32,
            1 => hi as f32,
            2 => (lo + (hi - lo) * 10f64.powf(dice.within(-8.0, 0.0))) as f32,
            _ => dice.within(lo, hi) as f32,
        }
    }
    fn sigma(dice: &mut Dice) -> f32 {
        match dice.number(0..6) {
            0 => 0.0,
            1 => 1000.0,
            2 => 10f64.powf(dice.within(-20.0, 3.0)) as f32,
            _ => 5.0 * dice.unit().powi(3) as f32,
        }
    }
    let degrees = |dice: &mut Dice, lo: f64, hi: f64| value(dice, lo, hi).to_radians();
    let roughness =
        |dice: &mut Dice| if dice.chance(0.3) { degrees(dice, 0.1, 90.0) } else { degrees(dice, 0.5, 20.0) };
    let mut fiber = Fiber {
        eta: value(dice, 1.0, 3.0),
        kappa: value(dice, 0.0, 0.99),
        alpha: degrees(dice, -45.0, 45.0),
        beta_m: roughness(dice),
        beta_n: roughness(dice),
        sigma_ca: std::array::from_fn(|_| sigma(dice)),
        sigma_ms: sigma(dice),
        sigma_ma: std::array::from_fn(|_| sigma(dice)),
        g: value(dice, 0.0, 0.95),
        exit: if dice.chance(0.5) { ScatterExit::Open } else { ScatterExit::Reflecting },
        layers: if dice.chance(0.5) { value(dice, 0.0, 20.0) } else { value(dice, 0.0, 2.0) },
        medulla_pigment: Fiber::hair().medulla_pigment,
        wet: 0.0,
        medulla_air: if dice.chance(0.3) { value(dice, 0.0, 1.0) } else { 0.0 },
        aspect_ratio: if dice.chance(0.3) { value(dice, 0.4, 1.0) } else { 1.0 },
        reflectance: None,
    };
    if dice.chance(0.4) {
        fiber = fiber.without_absorption();
    }
    if dice.chance(0.3) {
        // Most fibres are hair, or have one colour.
        fiber.eta = 1.55;
        fiber.sigma_ca = [fiber.sigma_ca[0]; 3];
        fiber.sigma_ma = [fiber.sigma_ma[0]; 3];
    }
    fiber
}

/// A failure, and its numbers.
type Wrong = (String, String);

fn wrong<T>(kind: &str, detail: impl std::fmt::Debug) -> Result<T, Wrong> {
    Err((kind.to_owned(), format!("{detail:?}")))
}

fn fine(x: f32) -> bool {
    x.is_finite() && x >= 0.0
}

fn check(fiber: &Fiber, hits: &Hits) -> Result<(), Wrong> {
    let bcsdf = Bcsdf::new(fiber).map_err(|e| ("a valid fibre is refused".to_owned(), e.to_string()))?;
    for i in 0..8 {
        let windows = [
            Window::near(hits.h[i]),
            Window::pixel(hits.h[i], hits.width),
            Window::cell(hits.h[i], hits.width, hits.u[i][0]),
            Window::range(hits.h[i], hits.h[(i + 1) % 8]),
            Window::far(),
        ];
        // The near field of every hit, and one of the four other windows, which take longer.
        for (k, window) in windows.into_iter().enumerate() {
            if k == 0 || k == 1 + i % 4 {
                one(&bcsdf, fiber, hits, i, window, k == 0)?;
            }
        }
    }
    eight(&bcsdf, hits)
}

/// Checks one hit: energy, evaluation, density, sampling.
fn one(bcsdf: &Bcsdf, fiber: &Fiber, hits: &Hits, i: usize, window: Window, near: bool) -> Result<(), Wrong> {
    let hit = bcsdf.at(hits.wo[i], window);
    let field = if near { "near field" } else { "window" };
    let energy = hit.energy();
    let tolerance = if near { ENERGY } else { WINDOW_ENERGY };
    let total = energy.total();
    if !energy.0.iter().flatten().all(|x| fine(*x)) {
        return wrong(&format!("{field}: an energy is negative or not finite"), (i, window, energy));
    }
    if total.iter().any(|x| *x > 1.0 + tolerance) {
        return wrong(&format!("{field}: more light leaves than arrives"), (i, window, total));
    }
    if *fiber == fiber.without_absorption() && total.iter().any(|x| (x - 1.0).abs() > tolerance) {
        return wrong(&format!("{field}: a white fibre is not white"), (i, window, total));
    }
    let likely = hit.lobe_probabilities();
    if !likely.iter().all(|x| fine(*x)) || (likely.iter().sum::<f32>() - 1.0).abs() > 1e-5 {
        return wrong(&format!("{field}: probabilities of lobes do not sum to 1"), (i, window, likely));
    }
    for wi in [hits.wi[i], hits.wi[(i + 3) % 8], -hits.wo[i], hits.wo[i], Vec3::X] {
        let (f, pdf) = hit.eval_pdf(wi);
        if !f.0.iter().flatten().chain([&pdf]).all(|x| fine(*x)) {
            return wrong(&format!("{field}: eval or pdf is negative or not finite"), (i, window, wi, f, pdf));
        }
    }
    for k in [i, (i + 5) % 8] {
        let Some(s) = hit.sample(hits.u[k]) else { continue };
        if !s.weight.iter().chain([&s.pdf]).all(|x| fine(*x)) || (s.wi.length() - 1.0).abs() > 1e-4 {
            return wrong(&format!("{field}: a sample is negative, not finite or no direction"), (i, window, s));
        }
        let bound = if near { 1.0 + WEIGHT } else { WINDOW_WEIGHT };
        if s.weight.iter().any(|w| *w > bound) {
            // Rare: numbers so close to the ends of [0, 1) occur once in ten million draws.
            let end = hits.u[k].iter().any(|u| *u < 1e-7 || *u > 1.0 - 1e-7);
            let where_ = if end { " at an end of the unit interval" } else { "" };
            return wrong(&format!("{field}: a weight is too large{where_}"), (i, window, hits.u[k], s));
        }
        let (f, pdf) = hit.eval_pdf(s.wi);
        if !f.0.iter().flatten().chain([&pdf]).all(|x| fine(*x)) {
            return wrong(
                &format!("{field}: eval or pdf of a sample is negative or not finite"),
                (i, window, s, f, pdf),
            );
        }
    }
    Ok(())
}

/// Eight queries at once must give the results of eight single queries.
fn eight(bcsdf: &Bcsdf, hits: &Hits) -> Result<(), Wrong> {
    let lanes = |v: [Vec3; 8]| [0, 1, 2].map(|k| f32x8::new(v.map(|v| v[k])));
    let hit = bcsdf.at8(lanes(hits.wo), f32x8::new(hits.h));
    let (lobes, pdf) = hit.eval_pdf8(lanes(hits.wi));
    let samples = hit.sample8([0, 1, 2, 3].map(|k| f32x8::new(hits.u.map(|u| u[k]))));
    for i in 0..8 {
        let one = bcsdf.at(hits.wo[i], Window::near(hits.h[i]));
        // The same operations in another order: the results are those of angles that are rounded differently, within
        // the tolerances of the crate's tests.
        let wi = hits.wi[i];
        let across = wi.cross(Vec3::X).normalize_or(Vec3::Y);
        let turns = [Vec3::X, -Vec3::X, across, -across].map(|axis| Quat::from_axis_angle(axis, ANGLE_ERROR) * wi);
        let [a, b, c, d] = turns;
        let turned = [wi, a, b, c, d];
        let near = turned.map(|wi| one.eval_pdf(wi));
        let same = |a: f32, of: &dyn Fn(&(Lobes, f32)) -> f32| {
            let (low, high) = near.iter().map(of).fold((f32::MAX, 0.0f32), |(low, high), b| (low.min(b), high.max(b)));
            low - 1e-5 * low - 1e-9 <= a && a <= high + 1e-5 * high + 1e-9
        };
        if !same(pdf.to_array()[i], &|(_, pdf)| *pdf) {
            return wrong("eight at once: another pdf", (i, pdf.to_array()[i], near));
        }
        for lobe in Lobe::ALL {
            for c in 0..3 {
                let a = lobes.0[lobe as usize][c].to_array()[i];
                if !same(a, &|(f, _)| f.0[lobe as usize][c]) {
                    return wrong("eight at once: another eval", (i, lobe, c, a, near));
                }
            }
        }
        let Some(s) = &samples[i] else { continue };
        if !s.weight.iter().chain([&s.pdf]).all(|x| fine(*x)) || s.weight.iter().any(|w| *w > 1.0 + WEIGHT) {
            return wrong("eight at once: a sample is negative, not finite or too large", (i, s));
        }
    }
    Ok(())
}
