//! Fits of several profiles of one fibre, and fits that know how a profile was measured: its cells, its background and
//! the standard deviations of its values.

use crate::any_profile;
use std::f64::consts::TAU;
use std::slice;
use vellus::{Fiber, Species};
use vellus_fit::space::{Source, Space};
use vellus_fit::{Estimate, Fit, Forward, Name, Options, Profile, Requests, State, Synthetic, fit, simulate};
use vellus_testing::Uniform;
use vellus_testing::significance::check_largest;

/// A gantry with 161 directions and an arbitrary unit.
fn gantry(seed: u64) -> Synthetic {
    Synthetic { step: [6.0, 10.0], gaps: 0.0, scale: 37.0, seed, ..Synthetic::default() }
}

fn measured(fiber: &Fiber, gantry: &Synthetic) -> Profile {
    simulate::from_model(Forward::default(), &(*fiber).into(), gantry).unwrap()
}

fn fitted(profiles: &[Profile], requests: Requests) -> Fit {
    let options = Options { starts: 8, requests, ..Options::default() };
    fit(profiles, Forward::default(), &options, &()).unwrap()
}

fn names(names: &[&str]) -> Vec<Name> {
    names.iter().map(|name| name.parse().unwrap()).collect()
}

/// What was simulated. `scale[2]` is that of the second profile.
fn truth(profiles: &[Profile], name: &str) -> f64 {
    let (name, number) = name.split_once('[').unwrap_or((name, "1]"));
    let number: usize = number.trim_end_matches(']').parse().unwrap();
    profiles[number - 1].simulated.iter().find(|(known, _)| known == name).unwrap().1
}

/// Requests that hold these parameters at what was simulated.
fn held(profile: &Profile, names: &[&str]) -> Requests {
    let fix = |name: &&str| (name.parse::<Name>().unwrap(), vec![truth(slice::from_ref(profile), name)]);
    Requests { fix: names.iter().map(fix).collect(), ..Requests::default() }
}

/// The medulla and the scales. A small profile then determines all that is left.
const INSIDE: [&str; 5] = ["kappa", "sigma_ms", "sigma_ma", "g", "layers"];

fn estimate<'f>(result: &'f Fit, name: &str) -> &'f Estimate {
    result.estimates.iter().find(|e| e.name == name).unwrap_or_else(|| panic!("{name} is not in {result:?}"))
}

/// Checks that determined parameters are right within their errors, and that there are at least this many of them.
fn check(result: &Fit, profiles: &[Profile], least: usize) {
    let determined = result.estimates.iter().filter(|e| e.determined && e.state == State::Fitted);
    let score = |e: &Estimate| (e.name.clone(), (e.value - truth(profiles, &e.name)) / e.error.unwrap());
    let scores: Vec<(String, f64)> = determined.map(score).collect();
    assert!(scores.len() >= least, "only {scores:?} are determined");
    check_largest(&scores);
}

/// The geometric mean of the errors of `a` divided by those of `b`, over the parameters that both have fitted.
fn error_ratio(a: &Fit, b: &Fit) -> f64 {
    let fitted = |result: &Fit, name: &str| {
        let found = result.estimates.iter().find(|e| e.name == name && e.state == State::Fitted);
        found.and_then(|e| e.error)
    };
    let log = |e: &Estimate| Some((fitted(a, &e.name)? / fitted(b, &e.name)?).ln());
    let logs: Vec<f64> = a.estimates.iter().filter_map(log).collect();
    assert!(logs.len() >= 4, "{} parameters", logs.len());
    (logs.iter().sum::<f64>() / logs.len() as f64).exp()
}

/// Two inclinations on different sides of the normal plane see as much of the fibre. The errors of both together are
/// then about 1/√2 of those of one. An error that follows from 161 residuals is known to about 10 %.
#[test]
fn two_inclinations_have_smaller_errors_than_one() {
    let fiber = Fiber::preset(Species::Raccoon);
    let profiles = [(-30.0, 1, 37.0), (30.0, 2, 5.0)].map(|(theta_o, seed, scale)| {
        let theta = [-theta_o - 20.0, -theta_o + 20.0];
        measured(&fiber, &Synthetic { theta_o, theta, scale, ..gantry(seed) })
    });
    let joint = fitted(&profiles, Requests::default());
    check(&joint, &profiles, 5);
    for profile in &profiles {
        let ratio = error_ratio(&joint, &fitted(slice::from_ref(profile), Requests::default()));
        assert!(ratio < 0.9, "{ratio}");
    }
    // Each profile has its own scale and its own fitted values.
    for (k, (part, profile)) in joint.parts.iter().zip(&profiles).enumerate() {
        assert_eq!((part.theta_o, part.background), (profile.theta_o, 0.0));
        assert_eq!(part.scale, estimate(&joint, &format!("scale[{}]", k + 1)).value);
        assert_eq!((part.specimen, part.fitted.len()), (joint.specimen, profile.points.len()));
        assert!(part.nrmse < 0.025 && part.log_nrmse < 0.025, "{part:?}");
    }
}

/// A fibre in light of two wavelengths, in the same unit. Only its absorption differs.
#[test]
fn wavelengths_have_their_own_absorption() {
    let profiles = [(0.1, 0.05, 1), (0.8, 0.4, 2)].map(|(sigma_ca, sigma_ma, seed)| {
        let base = Fiber { kappa: 0.5, ..Fiber::preset(Species::Raccoon) };
        measured(&Fiber { sigma_ca: [sigma_ca; 3], sigma_ma: [sigma_ma; 3], ..base }, &gantry(seed))
    });
    let (separate, share) = (names(&["sigma_ca", "sigma_ma"]), names(&["scale"]));
    let result = fitted(&profiles, Requests { separate, share, ..Requests::default() });
    check(&result, &profiles, 5);
    let [light, dark] = ["sigma_ca[1]", "sigma_ca[2]"].map(|name| estimate(&result, name));
    assert!(dark.value - light.value > 3.0 * light.error.unwrap().hypot(dark.error.unwrap()), "{light:?} {dark:?}");
    let [first, second] = [0, 1].map(|k| result.parts[k].specimen.fiber);
    assert!((f64::from(second.sigma_ca[0]) - dark.value).abs() < 1e-6);
    let same = Fiber { sigma_ca: first.sigma_ca, sigma_ma: first.sigma_ma, ..second };
    assert_eq!((first, first), (same, result.specimen.fiber));
    assert_eq!([0, 1].map(|k| result.parts[k].scale), [estimate(&result, "scale").value; 2]);
}

/// Light that does not come from the fibre raises dark directions more than bright ones.
#[test]
fn a_background_is_found() {
    let profile = [measured(&Fiber::preset(Species::Raccoon), &Synthetic { background: 1.5, ..gantry(3) })];
    let requests = held(&profile[0], &INSIDE);
    let with = fitted(&profile, Requests { free: names(&["background"]), ..requests.clone() });
    check(&with, &profile, 4);
    let (background, scale) = (estimate(&with, "background"), estimate(&with, "scale"));
    let error = background.error.unwrap();
    assert!((background.value - 1.5).abs() < 4.0 * error && error < 0.5, "{background:?}");
    assert_eq!(with.parts[0].background, background.value);
    // Without it, the fibre must be brighter.
    let without = fitted(&profile, requests);
    assert!(without.explained.share < with.explained.share);
    assert!(estimate(&without, "scale").value > scale.value + 3.0 * scale.error.unwrap(), "{scale:?}");
    assert_eq!(estimate(&without, "background").state, State::Fixed);
}

/// A detector that sees 5° widens highlights of 2°. A fit that does not know this finds a rougher fibre.
#[test]
fn the_aperture_does_not_count_as_roughness() {
    let fiber = Fiber { beta_m: 2f32.to_radians(), beta_n: 12f32.to_radians(), ..Fiber::preset(Species::Raccoon) };
    let gantry = Synthetic { blur: [5.0; 2], theta: [20.0, 40.0], step: [4.0, 20.0], ..gantry(4) };
    let profile = measured(&fiber, &gantry);
    let requests = held(&profile, &[&INSIDE[..], &["eta", "sigma_ca"]].concat());
    let known = fitted(slice::from_ref(&profile), requests.clone());
    check(&known, slice::from_ref(&profile), 2);
    let unknown = fitted(&[Profile { blur: [0.0; 2], ..profile }], requests);
    let [known, unknown] = [known, unknown].map(|result| estimate(&result, "beta_m").clone());
    let error = known.error.unwrap();
    assert!((known.value - 2.0).abs() < 4.0 * error && unknown.value > 2.0 + 10.0 * error, "{known:?} {unknown:?}");
}

/// Half of the values have ten times the noise. Only the ratios of the standard deviations count, not their unit.
#[test]
fn precise_values_count_more() {
    let clean = measured(&Fiber::preset(Species::Raccoon), &Synthetic { noise: 0.0, ..gantry(5) });
    let mut rng = Uniform(5);
    let mut normal = || (-2.0 * (1.0 - rng.next()).ln()).sqrt() * (TAU * rng.next()).cos();
    let mut profile = clean.clone();
    for (i, p) in profile.points.iter_mut().enumerate() {
        let relative = if i % 2 == 0 { 0.01 } else { 0.1 };
        p.value = [p.value[0] * (relative * normal()).exp(); 3];
        p.sigma = Some(p.value.map(|x| 5.0 * relative * x));
    }
    let requests = held(&profile, &INSIDE);
    let weighted = fitted(slice::from_ref(&profile), requests.clone());
    check(&weighted, slice::from_ref(&profile), 4);
    // The noise is that of a value of typical precision: the geometric mean.
    assert!((weighted.noise / 0.001f64.sqrt() - 1.0).abs() < 0.35, "{}", weighted.noise);
    for (fitted, p) in weighted.parts[0].fitted.iter().zip(&clean.points) {
        assert!((fitted[0] / p.value[0]).ln().abs() < 0.03, "{fitted:?} {p:?}");
    }
    let mut plain = profile.clone();
    plain.points.iter_mut().for_each(|p| p.sigma = None);
    let ratio = error_ratio(&weighted, &fitted(&[plain], requests));
    assert!(ratio < 0.6, "{ratio}");

    profile.points[7].sigma = None;
    let message = profile.validate().unwrap_err().to_string();
    assert!(message.contains("has a sigma: give all of them"), "{message}");
}

#[test]
fn parameters_of_several_profiles_have_numbers() {
    let space = |channels: [usize; 2], requests: &Requests| {
        Space::new(Forward::default(), &channels.map(any_profile), requests)
    };
    let requests = Requests {
        separate: names(&["eta"]),
        share: names(&["background"]),
        fix: vec![(Name::Scale, vec![1.0, 2.0])],
        ..Requests::default()
    };
    let found = space([1, 1], &requests).unwrap();
    let named = |name: &str| found.parameters.iter().position(|p| p.name == name).unwrap();
    for name in ["kappa", "eta[1]", "eta[2]", "theta_o[1]", "theta_o[2]", "background"] {
        named(name);
    }
    assert_eq!(["scale[1]", "scale[2]"].map(|name| found.sources[named(name)]), [1.0, 2.0].map(Source::Fixed));
    let members = [0, 1].map(|k| found.members[k].contains(&named("eta[2]")));
    assert_eq!((members, found.members[1].contains(&named("kappa"))), ([false, true], true));

    let message = |channels, requests: &Requests| space(channels, requests).unwrap_err().to_string();
    let three = Requests { fix: vec![(Name::Scale, vec![1.0; 3])], ..Requests::default() };
    assert!(message([1, 1], &three).contains("scale takes one value or 2, not 3"));
    assert!(message([1, 3], &Requests::default()).contains("one channel, or all three"));
    for requests in [
        Requests { separate: names(&["eta_m"]), ..Requests::default() },
        Requests { share: names(&["eta_m"]), ..Requests::default() },
    ] {
        assert!(message([1, 1], &requests).contains("unknown parameter 'eta_m'"));
    }
    assert!(fit(&[], Forward::default(), &Options::default(), &()).is_err());
}
