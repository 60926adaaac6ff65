//! Measurements in any number of channels: files, and fits with an absorption for each.

use crate::any_profile;
use std::path::PathBuf;
use vellus::{Fiber, Species};
use vellus_fit::{
    Absorption, Error, Forward, Name, Options, Profile, Reading, Requests, State, Synthetic, channels_csv, csv, fit,
    read, read_channels, simulate,
};
use vellus_testing::significance::check_largest;

const NAMES: [&str; 7] = ["400", "450", "500", "550", "600", "650", "700"];

/// The power law of eumelanin, and a third as much in the medulla.
fn absorptions() -> Vec<Absorption> {
    let of = |name: &&str| {
        let sigma_ca = 0.4 * (name.parse::<f32>().unwrap() / 550.0).powf(-3.33);
        Absorption { channel: (*name).to_owned(), sigma_ca, sigma_ma: sigma_ca / 3.0 }
    };
    NAMES.iter().map(of).collect()
}

/// 161 directions.
fn gantry() -> Synthetic {
    Synthetic { step: [6.0, 10.0], gaps: 0.0, scale: 37.0, ..Synthetic::default() }
}

fn measured(gantry: &Synthetic) -> Vec<Profile> {
    let fiber = Fiber { kappa: 0.5, ..Fiber::preset(Species::Raccoon) };
    simulate::channels(Forward::default(), &fiber.into(), &absorptions(), gantry).unwrap()
}

fn file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

/// All channels share the fibre and the scale, and each has its own absorption.
#[test]
fn seven_absorptions_are_recovered_within_their_errors() {
    let profiles = measured(&gantry());
    let options = Options { starts: 8, ..Options::default() };
    let result = fit(&profiles, Forward::default(), &options, &()).unwrap();
    let named = |part: &str| result.estimates.iter().filter(|e| e.name.starts_with(part)).count();
    assert_eq!(["sigma_ca[", "sigma_ma[", "scale", "kappa", "theta_o"].map(named), [7, 7, 1, 1, 1]);
    let determined = result.estimates.iter().filter(|e| e.determined && e.state == State::Fitted);
    let scores: Vec<(String, f64)> = determined
        .map(|e| {
            let name = e.name.split('[').next().unwrap();
            let truth = profiles[e.profile].simulated.iter().find(|(known, _)| known == name).unwrap().1;
            (e.name.clone(), (e.value - truth) / e.error.unwrap())
        })
        .collect();
    // The absorptions of all channels but the darkest, and half of the other ten parameters.
    assert!(scores.len() >= 17 && scores.iter().filter(|(name, _)| name.contains('[')).count() >= 12, "{scores:?}");
    check_largest(&scores);

    let references: Vec<&Profile> = profiles.iter().collect();
    let found = Absorption::fitted(&references, &result.parts);
    assert_eq!(found.iter().map(|a| a.channel.as_str()).collect::<Vec<_>>(), NAMES);
    for (k, (a, part)) in found.iter().zip(&result.parts).enumerate() {
        let value = result.estimates.iter().find(|e| e.name == format!("sigma_ca[{}]", NAMES[k])).unwrap().value;
        assert!((f64::from(a.sigma_ca) - value).abs() < 1e-6, "{a:?} {value}");
        assert_eq!([part.specimen.fiber.sigma_ma[0], a.sigma_ma], [a.sigma_ma; 2]);
    }
    let (_folder, path) = file("a.csv", &Absorption::csv(&found));
    assert_eq!(Absorption::read(&path).unwrap(), found);
}

#[test]
fn channels_are_written_and_read() {
    let mut profiles = measured(&Synthetic { gaps: 0.1, ..gantry() });
    // A direction without a value in one channel.
    let lost = profiles[2].points.remove(5);
    profiles[2].missing.push([lost.theta, lost.phi]);
    for (k, profile) in profiles.iter_mut().enumerate() {
        profile.points.iter_mut().for_each(|p| p.sigma = Some(p.value.map(|x| 0.01 * (k as f64 + 1.0) * x)));
    }
    let (_folder, path) = file("a.csv", &channels_csv(&profiles, &["a note".to_owned()]));
    let again = read_channels(&path, &Reading::default()).unwrap();
    for (a, b) in again.iter().zip(&profiles) {
        assert_eq!((&a.channel, a.channels, a.simulated.len()), (&b.channel, 1, b.simulated.len()));
        assert!(a.simulated.iter().all(|known| b.simulated.contains(known)), "{a:?} {b:?}");
        let sizes = |p: &Profile| (p.points.len(), p.missing.len());
        assert_eq!(sizes(a), sizes(b));
        for p in &a.points {
            let same = |q: &&vellus_fit::Point| (q.theta - p.theta).abs() + (q.phi - p.phi).abs() < 1e-9;
            let q = b.points.iter().find(same).unwrap();
            // Text has seven digits.
            assert!((p.value[0] / q.value[0] - 1.0).abs() < 6e-7, "{p:?} {q:?}");
            assert!((p.sigma.unwrap()[0] / q.sigma.unwrap()[0] - 1.0).abs() < 6e-7, "{p:?} {q:?}");
        }
    }
    assert_eq!(again.len(), 7);
    let message = read(&path, &Reading::default()).unwrap_err().to_string();
    assert!(message.ends_with("it has 7 channels: expected one profile"), "{message}");
    // One channel is a profile, and keeps its name.
    let (_folder, path) = file("b.csv", &csv(&again[3], &[]));
    assert_eq!(read(&path, &Reading::default()).unwrap().channel, "550");
}

#[test]
fn wrong_files_are_refused() {
    let reading = Reading { theta_o: Some(-30.0), ..Reading::default() };
    let rows = |cells: &str| {
        let row = |i: i32| format!("{},{},{cells}\n", 10 + 2 * (i / 8), 10 * (i % 8));
        (0..64).map(row).collect::<String>()
    };
    let many: Vec<String> = (0..65).map(|i| format!("value_{i}")).collect();
    for (head, cells, part) in [
        ("value_a,value_a", "1,2", "line 1: there are two channels 'a'"),
        ("value_,value_b", "1,2", "line 1: a channel has the name ''"),
        ("value_a,b", "1,2", "line 1: the columns are theta, phi, value_a, b"),
        ("value,value_b", "1,2", "line 1: the columns are theta, phi, value, value_b"),
        ("value_a,value_b,sigma_a", "1,2,3", "line 1: there are 1 columns of sigma for 2 of values"),
        ("value_a,value_b,weight", "1,2,3", "line 1: cannot use the column 'weight': expected theta, phi"),
        ("value_a,value_b", "1,x", "line 2: value_b = 'x' is not a number"),
        ("value_a,value_b", "1,?", "channel b: all 64 measurements are missing"),
        ("value_a,value_b", "1", "line 2: 3 columns: expected 4"),
        (&many.join(","), &["1"; 65].join(","), "at most 64 channels"),
    ] {
        let (_folder, path) = file("a.csv", &format!("theta,phi,{head}\n{}", rows(cells)));
        let message = read_channels(&path, &reading).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    for (text, part) in [
        ("channel,sigma_ca\na,1\n", "the columns are channel, sigma_ca: expected channel, sigma_ca, sigma_ma"),
        ("channel,sigma_ca,sigma_ma\n", "it has 0 channels: expected 1 to 64"),
        ("channel,sigma_ca,sigma_ma\na,x,1\n", "line 2: sigma_ca = 'x' is not a number"),
        ("channel,sigma_ca,sigma_ma\na,1,2\na,1,2\n", "line 3: there are two channels 'a'"),
        ("channel,sigma_ca,sigma_ma\na,1,-2\n", "line 2: sigma_ma = -2 is out of range: it must be in [0, 1000]"),
        ("channel,sigma_ca,sigma_ma\na b,1,2\n", "line 2: a channel has the name 'a b'"),
        ("channel,sigma_ca,sigma_ma\na,1\n", "line 2: 2 columns: expected 3"),
    ] {
        let (_folder, path) = file("a.csv", text);
        let message = Absorption::read(&path).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    let missing = Absorption::read(&PathBuf::from("none.csv")).unwrap_err();
    assert!(matches!(missing, Error::Read { .. }), "{missing}");
}

/// What channels, and measurements at several inclinations, share and name.
#[test]
fn channels_and_measurements_have_their_own_parameters() {
    let profiles: Vec<Profile> =
        ["a", "b", "a", "b"].map(|name| Profile { channel: name.to_owned(), ..any_profile(1) }).to_vec();
    let space = |profiles: &[Profile], requests: &Requests| {
        vellus_fit::space::Space::new(Forward::default(), profiles, requests)
    };
    let names = |requests: &Requests, part: &str| -> Vec<String> {
        let found = space(&profiles, requests).unwrap();
        found.parameters.iter().filter(|p| p.name.starts_with(part)).map(|p| p.name.clone()).collect()
    };
    let plain = Requests::default();
    assert_eq!(names(&plain, "sigma_ca"), ["sigma_ca[a]", "sigma_ca[b]"]);
    assert_eq!(names(&plain, "scale"), ["scale[1]", "scale[2]"]);
    assert_eq!(names(&plain, "eta"), ["eta"]);
    let found = space(&profiles, &plain).unwrap();
    let of = |k: usize, part: &str| {
        let name = |i: &&usize| found.parameters[**i].name.starts_with(part);
        found.parameters[*found.members[k].iter().find(name).unwrap()].name.clone()
    };
    assert_eq!([0, 1, 2, 3].map(|k| of(k, "sigma_ma")), ["sigma_ma[a]", "sigma_ma[b]", "sigma_ma[a]", "sigma_ma[b]"]);
    assert_eq!([0, 1, 2, 3].map(|k| of(k, "scale")), ["scale[1]", "scale[1]", "scale[2]", "scale[2]"]);
    let (shared, own): (Vec<Name>, Vec<Name>) = (vec!["sigma_ma".parse().unwrap()], vec!["eta".parse().unwrap()]);
    let requests = Requests { share: shared, separate: own, ..Requests::default() };
    assert_eq!(names(&requests, "sigma_ma"), ["sigma_ma"]);
    assert_eq!(names(&requests, "eta"), ["eta[a,1]", "eta[b,1]", "eta[a,2]", "eta[b,2]"]);

    let message = |profiles: &[Profile]| space(profiles, &plain).unwrap_err().to_string();
    assert!(message(&profiles[..3]).contains("3 profiles of 2 channels"));
    let swapped = [0, 1, 1, 0].map(|k: usize| profiles[k].clone());
    assert!(message(&swapped).contains("channel 'b' in place of 'a'"));
    let mixed = [profiles[0].clone(), any_profile(1), profiles[0].clone(), profiles[1].clone()];
    assert!(message(&mixed).contains("channel 'b' in place of ''"));
}
