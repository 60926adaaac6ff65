//! The errors: the fast path against the model in f64.

use crate::space::Case;
use glam::Vec3;
use std::f64::consts::{PI, TAU};
use vellus::{Bcsdf, Hit, TableData, Window};
use vellus_reference::exact::{Exact, Profile};

/// The resolution of the integration of the f64 model.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Offsets of the unscattered lobes.
    pub paths: usize,
    /// Azimuths per standard deviation of the narrowest lobe.
    pub per_sigma: f64,
    /// Offsets of the scattered lobes.
    pub points: usize,
}

impl Effort {
    /// For the search.
    pub const SEARCH: Effort = Effort { paths: 8000, per_sigma: 4.0, points: 96 };
    /// For the printed numbers.
    pub const FINAL: Effort = Effort { paths: 40_000, per_sigma: 10.0, points: 400 };
    /// To show that the printed numbers have converged.
    pub const CHECK: Effort = Effort { paths: 160_000, per_sigma: 20.0, points: 1600 };
}

/// The error of some lobes, for the worst of the three channels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Error {
    /// Relative to the light of those lobes.
    pub relative: f64,
    /// Relative to all light that leaves the fibre.
    pub of_all: f64,
}

/// The relative error of lobes with a smaller share of all light than this is not measured.
pub const LEAST_SHARE: f64 = 0.01;

/// A channel is black, and not measured, if less than this share of the incident light leaves the fibre.
pub const BLACK: f64 = 0.01;

impl Error {
    /// From the error, the light of the lobes and the light of all lobes, in one channel.
    fn new(error: f64, light: f64, all: f64) -> Error {
        if all < BLACK {
            return Error::default();
        }
        let relative = if light >= LEAST_SHARE * all { error / light } else { 0.0 };
        Error { relative, of_all: error / all }
    }

    fn worst(self, other: Error) -> Error {
        Error { relative: self.relative.max(other.relative), of_all: self.of_all.max(other.of_all) }
    }
}

/// Unit vector at inclination `theta` and azimuth `phi`.
fn direction(theta: f64, phi: f64) -> Vec3 {
    Vec3::new(theta.sin() as f32, (theta.cos() * phi.cos()) as f32, (theta.cos() * phi.sin()) as f32)
}

/// Runs `f` with the hit of the fast path and the f64 model of a case.
fn with<R>(tables: &TableData, case: &Case, f: impl FnOnce(&Hit, &Exact) -> R) -> Option<R> {
    let bcsdf = Bcsdf::new(&case.fiber).ok()?;
    let oracle = Exact::new(&case.fiber, tables).ok()?;
    Some(bcsdf.with_hit(direction(case.theta_o, 0.0), case.window(), |hit| f(hit, &oracle)))
}

/// L1 distance of the profiles of `lobes` from `exact`, at equidistant azimuths from −π.
fn distance(hit: &Hit, lobes: std::ops::Range<usize>, azimuths: usize, exact: impl Fn(usize, usize) -> f64) -> Error {
    let (mut error, mut light) = ([0.0; 3], [0.0; 3]);
    let step = TAU / azimuths as f64;
    for k in 0..azimuths {
        let fast = hit.azimuthal((step * k as f64 - PI) as f32);
        for c in 0..3 {
            let value: f64 = lobes.clone().map(|p| f64::from(fast.0[p][c])).sum();
            let expected = exact(k, c);
            error[c] += (value - expected).abs() * step;
            light[c] += expected * step;
        }
    }
    let all = hit.energy().total().map(f64::from);
    (0..3).map(|c| Error::new(error[c], light[c], all[c])).fold(Error::default(), Error::worst)
}

/// L1 of R + TT + TRT.
pub fn unscattered(tables: &TableData, case: &Case, effort: Effort) -> Error {
    let azimuths = ((TAU * effort.per_sigma / f64::from(case.fiber.beta_n)) as usize).max(720);
    let measured = with(tables, case, |hit, oracle| {
        let exact = oracle.unscattered_grid(case.theta_o, case.window, effort.paths, azimuths);
        distance(hit, 0..3, azimuths, |k, c| exact[k].iter().map(|lobe| lobe[c]).sum())
    });
    measured.unwrap_or_default()
}

/// L1 of TTˢ + TRTˢ.
pub fn scattered(tables: &TableData, case: &Case, effort: Effort) -> Error {
    const AZIMUTHS: usize = 720;
    let measured = with(tables, case, |hit, oracle| {
        // The two halves of the whole width are mirror images.
        let far = case.window == [-1.0, 1.0];
        let window = oracle.window(case.theta_o, if far { [0.0, 1.0] } else { case.window }, 0, effort.points);
        let sum = |phi: f64| {
            let n = window.azimuthal(phi);
            std::array::from_fn(|c| n[3][c] + n[4][c])
        };
        let exact: Vec<[f64; 3]> = (0..AZIMUTHS)
            .map(|k| TAU * k as f64 / AZIMUTHS as f64 - PI)
            .map(|phi| {
                let one: [f64; 3] = sum(phi);
                let other: [f64; 3] = if far { sum(-phi) } else { one };
                std::array::from_fn(|c| 0.5 * (one[c] + other[c]))
            })
            .collect();
        distance(hit, 3..5, AZIMUTHS, |k, c| exact[k][c])
    });
    measured.unwrap_or_default()
}

/// The error of the energy of a lobe, for the worst of the six lobes.
pub fn energy(tables: &TableData, case: &Case, effort: Effort) -> Error {
    let measured = with(tables, case, |hit, oracle| {
        let [first, last] = case.window.map(f64::asin);
        let width = (last - first) / effort.paths as f64;
        let mut exact = [[0.0; 3]; 6];
        for k in 0..effort.paths {
            let gamma = first + width * (k as f64 + 0.5);
            let a = oracle.path(case.theta_o, gamma.sin()).energy();
            let share = gamma.cos() * width / (case.window[1] - case.window[0]);
            (0..6).for_each(|p| (0..3).for_each(|c| exact[p][c] += share * a[p][c]));
        }
        let fast = hit.energy().0;
        let mut worst = Error::default();
        for c in 0..3 {
            let all = exact.iter().map(|lobe| lobe[c]).sum();
            for p in 0..6 {
                worst = worst.worst(Error::new((f64::from(fast[p][c]) - exact[p][c]).abs(), exact[p][c], all));
            }
        }
        worst
    });
    measured.unwrap_or_default()
}

/// The error from single precision in the near field. `relative` is the largest error of f·cos θᵢ of all lobes
/// together, relative to its largest value, over directions that the fibre scatters to. `of_all` is the error of the
/// energies of the lobes, relative to all light.
pub fn near(tables: &TableData, case: &Case, directions: usize) -> Error {
    let (Ok(bcsdf), Ok(oracle)) = (Bcsdf::new(&case.fiber), Exact::new(&case.fiber, tables)) else {
        return Error::default();
    };
    let wo = direction(case.theta_o, 0.0);
    let hit = bcsdf.at(wo, Window::near(case.window[0] as f32));
    // The f64 model gets the same numbers as the fast path.
    let inclination = |w: Vec3| f64::from(w.x).atan2(f64::from(w.y).hypot(w.z.into()));
    let exact = oracle.at(inclination(wo), case.window[0]);
    let mut random = crate::search::Random::new(1);
    let (mut peak, mut error) = ([0.0f64; 3], [0.0f64; 3]);
    for _ in 0..directions {
        let u = std::array::from_fn(|_| (random.uniform() as f32).min(1.0 - f32::EPSILON / 2.0));
        let Some(wi) = hit.sample(u).map(|sample| sample.wi) else { continue };
        let phi = f64::from(wi.z).atan2(wi.y.into());
        let expected = exact.eval(inclination(wi), phi);
        let value = hit.eval(wi).total();
        for c in 0..3 {
            let sum: f64 = expected.iter().map(|lobe| lobe[c]).sum();
            peak[c] = peak[c].max(sum);
            error[c] = error[c].max((f64::from(value[c]) - sum).abs());
        }
    }
    let (fast, exact) = (hit.energy().0, exact.energy());
    let mut worst = Error::default();
    for c in 0..3 {
        let all: f64 = exact.iter().map(|lobe| lobe[c]).sum();
        if all >= BLACK && peak[c] > 0.0 {
            let energy = (0..6).map(|p| (f64::from(fast[p][c]) - exact[p][c]).abs()).fold(0.0, f64::max);
            worst = worst.worst(Error { relative: error[c] / peak[c], of_all: energy / all });
        }
    }
    worst
}

/// The asymmetry of C^N at h″ = 0, where it should be symmetric in the azimuth. The first number is the share of the
/// light that would have to move to make it symmetric. The second is the median over azimuths of the ratio of the
/// larger to the smaller of two mirrored values.
pub fn asymmetry(tables: &TableData, tau: f64, g: f64) -> [f64; 2] {
    let profile = Profile::azimuthal(tables, tau, g, 0.0);
    let n = 720;
    let mut moved = 0.0;
    let mut ratios: Vec<f64> = (0..n)
        .map(|k| (k as f64 + 0.5) / n as f64 * PI)
        .map(|phi| {
            let (a, b) = (profile.eval(phi), profile.eval(TAU - phi));
            moved += 0.5 * (a - b).abs() * PI / n as f64;
            a.max(b) / a.min(b)
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    [2.0 * moved, ratios[n / 2]]
}
