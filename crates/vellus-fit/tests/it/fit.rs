//! Fits of measurements whose true parameters are known.

use crate::any_profile;
use std::f64::consts::PI;
use std::sync::atomic::AtomicBool;
use vellus::{Fiber, ScatterExit, Species, TableData, Tables};
use vellus_fit::parameters::{Curve, Kind};
use vellus_fit::space::Space;
use vellus_fit::{
    Error, Estimate, Fit, Forward, Name, Options, Profile, Requests, Specimen, State, Synthetic, fit, simulate,
};
use vellus_models::{Directions, ModelKind};
use vellus_reference::exact::Exact;
use vellus_testing::effort;
use vellus_testing::significance::{FALSE_ALARM, check_largest, check_scores, max_abs_z};

/// A gantry with a quarter of the default directions. A fit then takes a tenth of a second.
fn gantry(seed: u64) -> Synthetic {
    Synthetic { step: [4.0, 4.0], seed, scale: 37.0, ..Synthetic::default() }
}

/// Simulates a measurement of our own model.
fn measured(fiber: &Fiber, gantry: &Synthetic) -> Result<Profile, Error> {
    simulate::from_model(Forward::default(), &Specimen::from(*fiber), gantry)
}

fn fitted(profile: &Profile, options: &Options) -> Fit {
    fit(std::slice::from_ref(profile), Forward::default(), options, &()).unwrap()
}

fn quick() -> Options {
    Options { starts: 12, ..Options::default() }
}

fn truth(fiber: &Fiber, name: &str, scale: f64) -> f64 {
    let value = match name {
        "kappa" => fiber.kappa,
        "eta" => fiber.eta,
        "alpha" => fiber.alpha.to_degrees(),
        "beta_m" => fiber.beta_m.to_degrees(),
        "beta_n" => fiber.beta_n.to_degrees(),
        "sigma_ca" | "sigma_ca.r" => fiber.sigma_ca[0],
        "sigma_ca.g" => fiber.sigma_ca[1],
        "sigma_ca.b" => fiber.sigma_ca[2],
        "sigma_ms" => fiber.sigma_ms,
        "sigma_ma" | "sigma_ma.r" => fiber.sigma_ma[0],
        "sigma_ma.g" => fiber.sigma_ma[1],
        "sigma_ma.b" => fiber.sigma_ma[2],
        "g" => fiber.g,
        "layers" => fiber.layers,
        "medulla_air" => fiber.medulla_air,
        _ => return scale,
    };
    f64::from(value)
}

/// A fibre with the reflecting exit is found again. With the open exit, the fit finds another fibre.
#[test]
fn the_exit_is_kept() {
    let fiber = Fiber::preset(Species::Raccoon);
    let profile = measured(&fiber, &gantry(3)).unwrap();
    let [open, reflecting] = ScatterExit::ALL.map(|exit| fitted(&profile, &Options { exit: Some(exit), ..quick() }));
    assert_eq!([&open, &reflecting].map(|fit| fit.specimen.fiber.exit), ScatterExit::ALL);
    for (name, z) in z_scores(&reflecting, &fiber, 37.0) {
        assert!(z.abs() < 4.0, "{name}: {z} standard errors");
    }
    assert!(reflecting.nrmse < open.nrmse, "{} {}", reflecting.nrmse, open.nrmse);
    let yan2015 = Forward::new(ModelKind::Yan2015).unwrap();
    let options = Options { exit: Some(ScatterExit::Reflecting), ..quick() };
    let error = fit(std::slice::from_ref(&profile), yan2015, &options, &()).unwrap_err().to_string();
    assert_eq!(error, "yan2015 has no exit 'reflecting': only vellus has");
}

/// The errors of the determined parameters, divided by the reported standard errors.
fn z_scores(result: &Fit, fiber: &Fiber, scale: f64) -> Vec<(String, f64)> {
    let fitted = |e: &&Estimate| e.determined && e.state == State::Fitted;
    let z = |e: &Estimate| (e.name.clone(), (e.value - truth(fiber, &e.name, scale)) / e.error.unwrap());
    result.estimates.iter().filter(fitted).map(z).collect()
}

#[test]
fn ten_species_are_recovered_within_their_errors() {
    ten_species(Fiber::preset);
}

#[test]
#[ignore = "full: 30 fits, of the presets that are not the default"]
fn ten_published_species_are_recovered_within_their_errors() {
    ten_species(Fiber::published);
}

fn ten_species(preset: fn(Species) -> Fiber) {
    let mut scores = Vec::new();
    // 110 errors with one seed: a mean square of 1 is found to ± 0.77, with three to ± 0.44 (`check_scores`).
    let seeds = effort(1, 3);
    for (species, seed) in Species::ALL.into_iter().flat_map(|s| (0..seeds).map(move |seed| (s, seed))) {
        let fiber = preset(species);
        let options = Options { exit: Some(fiber.exit), ..quick() };
        let result = fitted(&measured(&fiber, &gantry(seed)).unwrap(), &options);
        assert_eq!(result.no_fit, None, "{species}");
        // Noise of 2 % of the values is at most 2 % of the largest value. The range is a little smaller, so the bound
        // is 2.5 %. The error of the logarithms is smaller.
        assert!(result.nrmse <= 0.025 && result.log_nrmse <= 0.025, "{species}: {} {}", result.nrmse, result.log_nrmse);
        let z = z_scores(&result, &fiber, 37.0);
        scores.extend(z.into_iter().map(|(name, z)| (format!("{species}, seed {seed}: {name}"), z)));
    }
    // There are 110 parameters for each seed.
    assert!(scores.len() as u64 >= 70 * seeds, "only {} are determined", scores.len());
    check_scores("ten species", &scores);
}

/// Reported errors match repeated measurements: the mean square of 16 × 11 errors (40 × 11 in `cargo xtask full`),
/// each divided by its standard error, is 1.
#[test]
fn standard_errors_match_repeated_measurements() {
    let fiber = Fiber { sigma_ca: [0.4; 3], kappa: 0.7, ..Fiber::preset(Species::Raccoon) };
    let mut scores = Vec::new();
    let seeds = effort(16, 40);
    for seed in 0..seeds {
        let result = fitted(&measured(&fiber, &gantry(seed)).unwrap(), &Options { starts: 4, ..quick() });
        scores.extend(z_scores(&result, &fiber, 37.0));
    }
    assert!(scores.len() as u64 > 300 * seeds / 40, "only {} are determined", scores.len());
    check_scores("raccoon", &scores);
}

/// The whole fibre differs from the model, because its cuticle is rough. NRMSE stays within the 8 % that the paper
/// reports on average for real fibres, with both exits. The deer is the worst of the ten.
#[test]
#[ignore = "test: 400,000 photons and two fits"]
fn whole_fibres_are_followed() {
    for species in [Species::Deer, Species::Raccoon].into_iter().take(effort(1, 2)) {
        let synthetic = Synthetic { step: [4.0, 5.0], noise: 0.02, ..Synthetic::default() };
        let profile = simulate::from_reference(&Fiber::published(species), &synthetic, 400_000, &()).unwrap();
        let [open, reflecting] =
            ScatterExit::ALL.map(|exit| fitted(&profile, &Options { exit: Some(exit), ..quick() }));
        for fit in [open, reflecting] {
            assert!(fit.nrmse <= 0.08 && fit.log_nrmse <= 0.08, "{species}: {} {}", fit.nrmse, fit.log_nrmse);
        }
    }
}

/// One direction in thirty is wrong by a factor of 4, up or down, as with glints and dust. With Huber's loss each
/// counts like a residual of 4 times the noise. With least squares, each counts like one of 70 times the noise.
#[test]
fn outliers_hardly_move_the_fit() {
    let fiber = Fiber::preset(Species::Rabbit);
    let mut profile = measured(&fiber, &gantry(3)).unwrap();
    let count = profile.points.len();
    for i in (0..count).step_by(30) {
        profile.points[i].value[0] *= if i % 60 == 0 { 4.0 } else { 0.25 };
    }
    let robust = fitted(&profile, &quick());
    assert_eq!(robust.outliers.clamp(count / 30, count / 25), robust.outliers, "{}", robust.outliers);
    check_largest(&z_scores(&robust, &fiber, 37.0));
    let squares = fitted(&profile, &Options { huber: f64::INFINITY, ..quick() });
    let error = |fit: &Fit, name: &str| fit.estimates.iter().find(|e| e.name == name).and_then(|e| e.error).unwrap();
    assert!(error(&robust, "beta_m") < 0.3 * error(&squares, "beta_m"));
}

#[test]
fn fixed_tied_and_freed_parameters_follow_the_requests() {
    let fiber = Fiber { sigma_ca: [0.2, 0.4, 0.8], sigma_ma: [0.1; 3], ..Fiber::preset(Species::Dog) };
    let fiber = Fiber { beta_n: fiber.beta_m, ..fiber };
    let synthetic = Synthetic { channels: 3, theta_o: -25.0, ..gantry(5) };
    let mut profile = measured(&fiber, &synthetic).unwrap();
    // The gantry is 2° off.
    profile.theta_o = -27.0;
    let name = |x: &str| x.parse::<Name>().unwrap();
    let requests = Requests {
        fix: vec![(name("eta"), vec![f64::from(fiber.eta)])],
        tie: vec![
            (name("beta_n"), name("beta_m")),
            (name("sigma_ma.r"), name("sigma_ma.g")),
            (name("sigma_ma.b"), name("sigma_ma.g")),
        ],
        free: vec![name("theta_o")],
        ..Requests::default()
    };
    let result = fitted(&profile, &Options { requests, ..quick() });
    let of = |name: &str| result.estimates.iter().find(|e| e.name == name).unwrap();
    assert_eq!((of("eta").state.clone(), result.specimen.fiber.eta), (State::Fixed, fiber.eta));
    assert_eq!(of("beta_n").state, State::Tied("beta_m".to_owned()));
    assert_eq!(result.specimen.fiber.beta_n, result.specimen.fiber.beta_m);
    assert_eq!(result.specimen.fiber.sigma_ma, [result.specimen.fiber.sigma_ma[1]; 3]);
    let theta_o = of("theta_o");
    assert!((theta_o.value + 25.0).abs() < max_abs_z(1, FALSE_ALARM) * theta_o.error.unwrap(), "{theta_o:?}");
    let scores: Vec<_> = z_scores(&result, &fiber, 37.0).into_iter().filter(|(name, _)| name != "theta_o").collect();
    check_largest(&scores);
    // An RGB fit has 11 + 4 free parameters, with the scale. Ties remove three, the fixed value removes one, and θ_o is
    // added.
    assert_eq!(result.correlations.names.len(), 11 + 4 - 1 - 3 + 1);
}

/// Air is found where it is asked for. Without it, the fit finds another fibre, and says that it is no fit.
#[test]
fn air_in_the_medulla_is_found() {
    let fiber = Fiber { medulla_air: 0.8, ..Fiber::preset(Species::RedFox) };
    let profile = measured(&fiber, &Synthetic { step: [6.0; 2], ..gantry(6) }).unwrap();
    let requests = Requests { free: vec!["medulla_air".parse().unwrap()], ..Requests::default() };
    let [with, without] =
        [requests, Requests::default()].map(|requests| fitted(&profile, &Options { requests, ..quick() }));
    check_largest(&z_scores(&with, &fiber, 37.0));
    assert_eq!(without.specimen.fiber.medulla_air, 0.0);
    assert!(without.nrmse > 1.5 * with.nrmse, "{} {}", without.nrmse, with.nrmse);
}

#[test]
fn invalid_requests_are_refused() {
    let name = |x: &str| x.parse::<Name>().unwrap();
    let message =
        |requests: Requests| Space::new(Forward::default(), &[any_profile(3)], &requests).unwrap_err().to_string();
    let fix = |n: &str, v: &[f64]| Requests { fix: vec![(name(n), v.to_vec())], ..Requests::default() };
    let tie = |pairs: &[(&str, &str)]| Requests {
        tie: pairs.iter().map(|(a, b)| (name(a), name(b))).collect(),
        ..Requests::default()
    };
    for (requests, parts) in [
        (fix("eta_m", &[1.5]), ["eta_m", "those of"]),
        (fix("eta", &[0.5]), ["eta = 0.5", "[1, 3]"]),
        (fix("eta", &[f64::NAN]), ["eta = NaN", "[1, 3]"]),
        (fix("sigma_ca", &[0.5, 0.2]), ["sigma_ca", "not 2"]),
        (tie(&[("beta_n", "beta_n")]), ["beta_n", "itself"]),
        (tie(&[("beta_n", "beta_m"), ("beta_m", "beta_n")]), ["beta_", "itself"]),
        (tie(&[("sigma_ca", "eta_m")]), ["eta_m", "those of"]),
        (Requests { fix: vec![(name("g"), vec![0.2])], ..tie(&[("g", "kappa")]) }, ["g", "both"]),
    ] {
        let text = message(requests);
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
    for unknown in ["etta", "sigma_xx", "sigma_ca.a", "melanin"] {
        let text = unknown.parse::<Name>().unwrap_err().to_string();
        assert!([unknown, "those of", "beta_m"].iter().all(|part| text.contains(part)), "{text}");
    }
    let all = Forward::default()
        .parameters(1)
        .iter()
        .map(|p| (p.name.parse().unwrap(), vec![p.usual[0].max(p.low)]))
        .collect();
    let nothing =
        Space::new(Forward::default(), &[any_profile(1)], &Requests { fix: all, ..Requests::default() }).unwrap_err();
    assert!(nothing.to_string().contains("nothing to fit"));
}

/// The data do not contain information about a medulla that does not exist.
#[test]
fn a_missing_medulla_is_not_determined() {
    let fiber = Fiber { kappa: 0.0, sigma_ca: [0.3; 3], ..Fiber::hair() };
    let requests = Requests { fix: vec![("kappa".parse().unwrap(), vec![0.0])], ..Requests::default() };
    let result = fitted(&measured(&fiber, &gantry(2)).unwrap(), &Options { requests, ..quick() });
    for e in &result.estimates {
        let medulla = ["sigma_ms", "sigma_ma", "g"].contains(&e.name.as_str());
        assert!(!(medulla && e.determined), "{e:?}");
        assert!(e.value.is_finite() && e.error.is_none_or(|x| !x.is_nan()), "{e:?}");
    }
    assert!(result.estimates.iter().any(|e| e.name == "beta_m" && e.determined));
}

#[test]
fn an_interrupted_fit_returns_its_best_result() {
    let profile = measured(&Fiber::preset(Species::Cat), &gantry(1)).unwrap();
    let result =
        fit(std::slice::from_ref(&profile), Forward::default(), &Options::default(), &AtomicBool::new(true)).unwrap();
    assert!(result.interrupted && result.starts.finished == 0);
    // At least the best preset.
    assert!(result.log_nrmse < 0.2 && result.specimen.fiber.validate().is_ok(), "{}", result.log_nrmse);
    assert!(!fitted(&profile, &Options { starts: 2, ..quick() }).interrupted);
}

#[test]
fn threads_do_not_change_the_fit() {
    let profile = measured(&Fiber::preset(Species::Mouse), &gantry(4)).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", fitted(&profile, &Options { starts: 4, ..quick() })))
    };
    assert!(with(1) == with(3));
}

/// The fit uses difference quotients of the shipped far field in single precision. This test compares them with
/// difference quotients of the f64 model by quadrature, with the same steps. The differences come from rounding (1e-6
/// over a step of 4e-3), from the closed forms of the far field (within 1 % of the values, D9) and from changes of
/// their nodes. The bound is 5 % of the norm of each derivative over 40 directions. The largest difference found is 3
/// %, for η.
#[test]
fn difference_quotients_match_the_oracle() {
    let all = Forward::default().parameters(1);
    let fiber = Fiber { sigma_ca: [0.3; 3], sigma_ma: [0.2; 3], g: 0.45, ..Fiber::preset(Species::Rabbit) };
    let tables = TableData::from_bytes(Tables::SHIPPED).unwrap();
    let places: Vec<(f64, f64)> =
        (0..40).map(|i| (12.0 + f64::from(i % 5) * 8.0, -17.0 + f64::from(i / 5) * 29.0)).collect();
    let theta_o = -30f64.to_radians();
    let exact = |fiber: &Fiber| -> Vec<f64> {
        let oracle = Exact::new(fiber, &tables).unwrap();
        let window = oracle.window(theta_o, [-1.0, 1.0], 1500, 300);
        let value = |&(t, p): &(f64, f64)| {
            window.eval(t.to_radians(), p.to_radians()).iter().map(|lobe| lobe[0]).sum::<f64>().ln()
        };
        places.iter().map(value).collect()
    };
    let fast = |fiber: &Fiber| -> Vec<f64> {
        let directions = Directions::new(&places.iter().map(|&(t, p)| [t, p]).collect::<Vec<_>>());
        let mut out = vec![[0.0; 3]; places.len()];
        Forward::default().values(&Specimen::from(*fiber), -30.0, &directions, &mut out).unwrap();
        out.iter().map(|v| f64::from(v[0]).ln()).collect()
    };
    let moved = |p: &vellus_fit::parameters::Parameter, du: f64| {
        // Air is at the end of its range.
        let mut fiber = if p.name == "medulla_air" { Fiber { medulla_air: 0.5, ..fiber } } else { fiber };
        let shift = |x: &mut f32, unit: f64| {
            let u = p.curve.variable(f64::from(*x) * unit) + du;
            *x = (p.curve.value(u) / unit) as f32;
        };
        let Kind::Fiber(parameter, _) = p.kind else { return fiber };
        let unit = if parameter.is_angle() { 180.0 / PI } else { 1.0 };
        let mut value = parameter.get(&fiber).unwrap();
        value.iter_mut().for_each(|x| shift(x, unit));
        parameter.set(&mut fiber, value).unwrap();
        fiber
    };
    for p in all.iter().filter(|p| !p.kind.is_of_measurement()) {
        let quotient = |values: &dyn Fn(&Fiber) -> Vec<f64>, step: f64| -> Vec<f64> {
            let (up, down) = (values(&moved(p, step)), values(&moved(p, -step)));
            up.iter().zip(&down).map(|(a, b)| (a - b) / (2.0 * step)).collect()
        };
        let (ours, theirs) = (quotient(&fast, p.step), quotient(&exact, p.step));
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
        let off = norm(&mut ours.iter().zip(&theirs).map(|(a, b)| a - b)) / norm(&mut theirs.iter().copied());
        // With air, TT follows the brighter of two paths, and each offset changes its path at another value.
        let allowed = if p.name == "medulla_air" { 0.1 } else { 0.05 };
        assert!(off < allowed, "{}: {off}", p.name);
    }
}

#[test]
fn variables_and_values_are_inverse() {
    for curve in [Curve::Linear, Curve::Log { offset: 0.02 }, Curve::Peak] {
        for x in [0.0, 0.01, 0.3, 0.9] {
            assert!((curve.value(curve.variable(x)) - x).abs() < 1e-12, "{curve:?} {x}");
            let h = 1e-6;
            let slope = (curve.value(curve.variable(x) + h) - curve.value(curve.variable(x) - h)) / (2.0 * h);
            assert!((slope - curve.slope(x)).abs() < 1e-8, "{curve:?} {x}");
        }
    }
}

#[test]
fn synthetic_measurements_have_the_requested_noise_and_gaps() {
    let fiber = Fiber::preset(Species::Deer);
    let clean = measured(&fiber, &Synthetic { noise: 0.0, gaps: 0.0, ..gantry(1) }).unwrap();
    let noisy = measured(&fiber, &Synthetic { noise: 0.03, gaps: 0.25, ..gantry(1) }).unwrap();
    let count = clean.points.len();
    assert_eq!(noisy.points.len() + noisy.missing.len(), count);
    assert_eq!(noisy.missing.len(), (0.25 * count as f64).round() as usize);
    let at = |theta: f64, phi: f64| clean.points.iter().find(|p| p.theta == theta && p.phi == phi).unwrap().value[0];
    let square: f64 = noisy.points.iter().map(|p| (p.value[0] / at(p.theta, p.phi)).ln().powi(2)).sum();
    // For n = 462 values, the relative error of a standard deviation is 1/√(2n) = 3.3 %.
    let rms = (square / noisy.points.len() as f64).sqrt();
    assert!((rms / 0.03 - 1.0).abs() < 0.1, "{rms}");
    for bad in [Synthetic { noise: -0.1, ..gantry(1) }, Synthetic { step: [0.0, 1.0], ..gantry(1) }] {
        assert!(matches!(measured(&fiber, &bad), Err(Error::Profile(_))));
    }
}
