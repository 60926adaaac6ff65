//! `vellus fit`: a synthetic measurement, its fit, the report, and error messages.

use crate::common::{Limited, vellus};
use std::path::Path;
use std::process::{Command, Output};

fn command(folder: &Path, args: &[&str]) -> Command {
    crate::common::command(folder, &[&["fit"], args].concat())
}

fn run(folder: &Path, args: &[&str]) -> Output {
    let output = command(folder, args).run().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Exit code 2, nothing on standard output, no new file, one line that contains all of `parts`.
fn refused(folder: &Path, args: &[&str], parts: &[&str]) {
    let files = || std::fs::read_dir(folder).unwrap().count();
    let before = files();
    let output = command(folder, args).run().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
    assert!(output.stdout.is_empty() && files() == before, "{args:?}");
    for part in parts {
        assert!(message.contains(part), "{args:?}: '{part}' is not in: {message}");
    }
}

#[test]
fn a_measurement_is_fitted_reported_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["--simulate", "red-fox-published", "--step", "5", "--out", "fox.txt"]);
    let output =
        run(folder, &["fox.txt", "--exit", "open", "--starts", "12", "--out", "fox.toml", "--report", "report"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("beta_m") && table.contains("NRMSE: 1."), "{table}");
    let eta = table.lines().find(|line| line.starts_with("eta ")).unwrap();
    assert!(table.lines().next().unwrap().contains("simulated") && eta.trim_end().ends_with("1.49"), "{table}");
    // The cortex of a red fox is only a seventh of the fibre, so its absorption is poorly determined.
    let warnings = String::from_utf8(output.stderr).unwrap();
    assert!(warnings.contains("does not determine") && warnings.contains("sigma_ca"), "{warnings}");
    let toml = std::fs::read_to_string(folder.join("fox.toml")).unwrap();
    assert!(toml.contains("# NRMSE") && toml.contains("± ") && toml.contains("# warning: "), "{toml}");
    // Other commands read the result as a fibre.
    let shown = vellus(folder, &["fiber", "show", "--format", "json", "fox.toml"]);
    let shown: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert!((shown["eta"].as_f64().unwrap() - 1.49).abs() < 0.1 && (shown["g"].as_f64().unwrap() - 0.79).abs() < 0.05);
    for name in ["profile-1.png", "slices-1.png"] {
        let png = std::fs::read(folder.join("report").join(name)).unwrap();
        assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000, "{name}");
    }
    let page = std::fs::read_to_string(folder.join("report/index.html")).unwrap();
    for part in
        ["Fit of fox.txt", "profile-1.png", "slices-1.png", "profile-1.csv", "class=\"warning\"", "Correlations"]
    {
        assert!(page.contains(part), "{part}");
    }
    let values = std::fs::read_to_string(folder.join("report/profile-1.csv")).unwrap();
    assert!(values.starts_with("theta,phi,measured,fitted\n") && values.lines().count() > 300);
}

#[test]
fn the_exit_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["--simulate", "raccoon", "--step", "8", "--out", "raccoon.txt"]);
    let args = ["raccoon.txt", "--starts", "4", "--format", "json", "--out", "raccoon.toml"];
    let json: serde_json::Value = serde_json::from_slice(&run(folder, &args).stdout).unwrap();
    assert_eq!(json["exit"], "reflecting");
    let toml = std::fs::read_to_string(folder.join("raccoon.toml")).unwrap();
    assert!(toml.contains("exit = \"reflecting\"  # given\n"), "{toml}");
    assert!(toml.contains("# model: vellus, reflecting exit\n"), "{toml}");
    let parts = ["yan2015 has no exit 'reflecting'"];
    refused(folder, &["raccoon.txt", "--exit", "reflecting", "--model", "yan2015"], &parts);
}

#[test]
fn programs_get_json() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["--simulate", "dog", "--step", "6", "--rgb", "--scale", "5", "--theta-o", "-25", "--out", "dog.csv"]);
    let args = ["dog.csv", "--starts", "6", "--format", "json", "--fix", "eta=1.58", "--tie", "sigma_ma=sigma_ca"];
    let output = run(folder, &args);
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let parameters = &value["parameters"];
    assert_eq!((parameters["eta"]["state"].as_str(), parameters["eta"]["value"].as_f64()), (Some("fixed"), Some(1.58)));
    assert_eq!(parameters["sigma_ma.g"]["tied_to"], "sigma_ca.g");
    assert_eq!(parameters["theta_o"]["value"], -25.0);
    assert!((parameters["scale"]["value"].as_f64().unwrap() - 5.0).abs() < 0.5);
    let beta_m = &parameters["beta_m"];
    assert!(beta_m["standard_error"].as_f64().unwrap() > 0.0);
    let [low, high] = [0, 1].map(|end| beta_m["interval"][end].as_f64().unwrap());
    assert!((low..high).contains(&beta_m["value"].as_f64().unwrap()), "{beta_m}");
    let profile = &value["profiles"][0];
    assert_eq!((profile["file"].as_str(), profile["channels"].as_u64()), (Some("dog.csv"), Some(3)));
    assert_eq!(value["interrupted"], false);
    assert!(value["no_fit"].is_null() && value["explained"].as_f64().unwrap() > 0.9);
    assert!(value["nrmse"].as_f64().unwrap() < 0.025 && value["log_nrmse"].as_f64().unwrap() < 0.025);
    let names = value["correlations"]["names"].as_array().unwrap().len();
    assert!(names > 8 && value["correlations"]["matrix"].as_array().unwrap().len() == names);
}

/// Each profile has its own fibre and report. One that cannot be read does not keep the others out.
#[test]
fn a_batch_fits_each_profile() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["--simulate", "mouse", "--step", "8", "--out", "mouse.txt"]);
    std::fs::write(folder.join("bad.txt"), "70 40 NaN\n").unwrap();
    let args = ["bad.txt", "mouse.txt", "--theta-o", "-30", "--starts", "4", "--out", "fitted", "--report", "reports"];
    let output = command(folder, &args).run().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for part in
        ["1 of 2: bad.txt\nerror: bad.txt, line 1: ", "2 of 2: mouse.txt\n", "error: 1 of 2 profiles have no fit: "]
    {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("profile: mouse.txt: ") && !table.contains("bad.txt"), "{table}");
    let written: Vec<_> = std::fs::read_dir(folder.join("fitted")).unwrap().map(|f| f.unwrap().file_name()).collect();
    assert_eq!(written, ["mouse.toml"]);
    assert!(vellus(folder, &["fiber", "show", "fitted/mouse.toml"]).status.success());
    assert!(folder.join("reports/mouse/profile-1.png").is_file());
    assert!(!folder.join("reports/bad/index.html").exists());
}

/// Two measurements of one fibre have one result. Each profile has its own scale, unless they share it.
#[test]
fn profiles_of_one_fibre_are_fitted_together() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let measure = ["--simulate", "raccoon", "--step", "8", "--out"];
    run(folder, &[&measure[..], &["a.csv"]].concat());
    run(
        folder,
        &[&measure[..], &["b.csv", "--theta-o", "0", "--theta", "-20:20", "--scale", "3", "--seed", "2"]].concat(),
    );
    let joint = ["a.csv", "b.csv", "--joint", "--theta-o", "-30,0", "--starts", "4", "--format", "json"];
    let output = run(folder, &[&joint[..], &["--out", "raccoon.toml", "--report", "report"]].concat());
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let (parameters, profiles) = (&value["parameters"], value["profiles"].as_array().unwrap());
    assert_eq!(profiles.iter().map(|p| p["file"].as_str().unwrap()).collect::<Vec<_>>(), ["a.csv", "b.csv"]);
    assert!(profiles.iter().all(|p| p["nrmse"].as_f64().unwrap() < 0.025), "{profiles:?}");
    assert_eq!(parameters["theta_o[2]"]["value"], 0.0);
    for (name, truth) in [("scale[1]", 1.0), ("scale[2]", 3.0)] {
        let scale = &parameters[name];
        assert!((scale["value"].as_f64().unwrap() / truth - 1.0).abs() < 0.2 && scale["simulated"] == truth, "{scale}");
    }
    assert!(parameters["eta"].is_object() && parameters["scale"].is_null());
    let toml = std::fs::read_to_string(folder.join("raccoon.toml")).unwrap();
    assert!(toml.contains("# profile: a.csv: ") && toml.contains("# profile: b.csv: "), "{toml}");
    let page = std::fs::read_to_string(folder.join("report/index.html")).unwrap();
    for part in ["Fit of a.csv, b.csv by vellus", "slices-1.png", "profile-2.png", "profile-2.csv"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(folder.join("report/slices-2.png").is_file() && folder.join("report/profile-2.csv").is_file());

    let own = ["--separate", "sigma_ca", "--share", "scale", "--free", "background", "--out", "own.toml"];
    let output = run(folder, &[&joint[..], &own, &["--allow-bad-fit"]].concat());
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for name in ["sigma_ca[1]", "sigma_ca[2]", "scale", "background[2]"] {
        assert!(value["parameters"][name].is_object(), "{name}");
    }
    // The file of the fibre has the values of the first profile, and those of all in a comment.
    let toml = std::fs::read_to_string(folder.join("own.toml")).unwrap();
    let line = toml.lines().find(|line| line.starts_with("sigma_ca = ")).unwrap();
    assert!(line.contains("sigma_ca[1] = ") && line.contains("; sigma_ca[2] = "), "{line}");

    // A wrong inclination hides the highlights of the second profile.
    let wrong = ["a.csv", "b.csv", "--joint", "--theta-o", "-30,60", "--fix", "alpha=1.81", "--starts", "1"];
    let warned = String::from_utf8(run(folder, &[&wrong[..], &["--allow-bad-fit"]].concat()).stderr).unwrap();
    let parts = ["warning: b.csv: the highlight R is outside of the data: theta_o = 60°", "--free theta_o"];
    assert!(parts.iter().all(|part| warned.contains(part)), "{warned}");
}

/// A measurement with an aperture and stray light. The file states the aperture.
#[test]
fn aperture_and_background_are_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let args = ["--simulate", "raccoon", "--step", "8", "--blur", "6,0", "--background", "0.02", "--out", "a.csv"];
    run(folder, &args);
    let text = std::fs::read_to_string(folder.join("a.csv")).unwrap();
    assert!(text.contains("\n# blur = 6,0\n") && text.contains("background 0.02"), "{text}");
    let args = ["a.csv", "--free", "background", "--starts", "4", "--format", "json"];
    let value: serde_json::Value = serde_json::from_slice(&run(folder, &args).stdout).unwrap();
    assert_eq!(value["profiles"][0]["blur"], serde_json::json!([6.0, 0.0]));
    let background = &value["parameters"]["background"];
    let [found, error] = ["value", "standard_error"].map(|name| background[name].as_f64().unwrap());
    assert!((found - 0.02).abs() < 4.0 * error && background["simulated"] == 0.02, "{background}");
}

#[test]
fn other_models_are_measured_fitted_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let model = ["--model", "yan2015", "--eta-m", "1.4"];
    run(folder, &[&["--simulate", "dog", "--step", "6", "--out", "dog.txt"], &model[..]].concat());
    let text = std::fs::read_to_string(folder.join("dog.txt")).unwrap();
    assert!(text.contains("the far field of yan2015, eta_m 1.4"), "{text}");
    let args =
        ["dog.txt", "--model", "Yan", "--starts", "4", "--out", "dog.toml", "--report", "report", "--format", "json"];
    let value: serde_json::Value = serde_json::from_slice(&run(folder, &args).stdout).unwrap();
    assert_eq!(value["model"], "yan2015");
    assert!((value["parameters"]["eta_m"]["value"].as_f64().unwrap() - 1.4).abs() < 0.1);
    let toml = std::fs::read_to_string(folder.join("dog.toml")).unwrap();
    assert!(toml.starts_with("# model: yan2015\n") && toml.contains("\n# eta_m = 1."), "{toml}");
    let page = std::fs::read_to_string(folder.join("report/index.html")).unwrap();
    assert!(page.contains("Fit of dog.txt by yan2015") && page.contains("<td>eta_m</td>"));

    // A model of hair without a medulla. The fit reports its name, and writes a fibre file.
    let output = run(folder, &["dog.txt", "--model", "chiang", "--starts", "4", "--out", "hair.toml"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("model: chiang2016") && !table.contains("kappa"), "{table}");
    assert!(String::from_utf8(output.stderr).unwrap().contains("does not follow the data"));
    let toml = std::fs::read_to_string(folder.join("hair.toml")).unwrap();
    assert!(toml.contains("kappa = 0.0  # chiang2016 has none"), "{toml}");
    assert!(vellus(folder, &["fiber", "show", "hair.toml"]).status.success());
}

/// From absorptions to a measurement, back to absorptions by a fit, and to the energies of the fibre.
#[test]
fn channels_go_through_fit_and_energy() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(
        folder.join("in.csv"),
        "channel,sigma_ca,sigma_ma\n450,0.8,0.3\n550,0.4,0.15\n600,0.3,0.1\n650,0.2,0.05\n",
    )
    .unwrap();
    let measure = ["--simulate", "raccoon", "--set", "kappa=0.5", "--absorption", "in.csv", "--step", "8"];
    run(folder, &[&measure[..], &["--out", "a.csv"]].concat());
    let args = ["a.csv", "--starts", "4", "--out", "a.toml", "--report", "report", "--format", "json"];
    let value: serde_json::Value = serde_json::from_slice(&run(folder, &args).stdout).unwrap();
    for (channel, truth) in [("450", 0.8), ("650", 0.2)] {
        let sigma = &value["parameters"][format!("sigma_ca[{channel}]")];
        assert_eq!(sigma["simulated"], truth);
        // At most five standard errors: chance has 2 of 10 million.
        let [found, error] = ["value", "standard_error"].map(|name| sigma[name].as_f64().unwrap());
        assert!((found - truth).abs() < 5.0 * error && error < 0.3, "{channel}: {sigma}");
    }
    let profiles = value["profiles"].as_array().unwrap();
    assert_eq!(
        profiles.iter().map(|p| p["channel"].as_str().unwrap()).collect::<Vec<_>>(),
        ["450", "550", "600", "650"]
    );
    let toml = std::fs::read_to_string(folder.join("a.toml")).unwrap();
    let line = toml.lines().find(|line| line.starts_with("sigma_ca = ")).unwrap();
    assert!(line.contains("sigma_ca[450] = ") && line.contains("; sigma_ca[650] = "), "{line}");
    let page = std::fs::read_to_string(folder.join("report/index.html")).unwrap();
    for part in ["Fit of a.csv by", "<h2>a.csv, channel 450</h2>", "absorption.csv", "profile-4.png"] {
        assert!(page.contains(part), "{part}");
    }

    let energy = |more: &[&str]| {
        let output = vellus(folder, &[&["energy", "--fiber", "a.toml"], more].concat());
        serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()
    };
    let all = energy(&["--absorption", "report/absorption.csv", "--format", "json"]);
    let channels = all["channels"].as_array().unwrap();
    assert_eq!(channels.len(), 4);
    // The file of the fibre has the absorption of the first channel, with the same digits.
    let first = energy(&["--format", "json"]);
    for lobe in ["R", "TT", "total"] {
        for kind in ["closed_form", "integral"] {
            assert_eq!(channels[0]["lobes"][lobe][kind], first["lobes"][lobe][kind][0], "{lobe} {kind}");
        }
    }
    let total = |k: usize| channels[k]["lobes"]["total"]["closed_form"].as_f64().unwrap();
    assert!((0..3).all(|k| total(k) < total(k + 1)), "less absorption gives more light: {channels:?}");
    let text = |format: &str| {
        let args = ["energy", "--fiber", "a.toml", "--absorption", "in.csv", "--format", format];
        String::from_utf8(vellus(folder, &args).stdout).unwrap()
    };
    assert!(text("csv").starts_with("channel,sigma_ca,sigma_ma,A.R,") && text("csv").lines().count() == 5);
    assert!(text("table").contains("\n450 "), "{}", text("table"));
}

#[test]
fn the_whole_fibre_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["--simulate", "cat", "--from", "reference", "--photons", "20000", "--step", "10", "--out", "cat.txt"];
    run(folder.path(), &args);
    let text = std::fs::read_to_string(folder.path().join("cat.txt")).unwrap();
    assert!(text.contains("the whole fibre, 20000 photons") && text.contains("# theta_o = -30"), "{text}");
    assert!(text.lines().any(|line| line.ends_with(" ?")));
}

#[test]
fn bad_input_is_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("nan.txt"), "70 40 0.1\n72 40 NaN\n").unwrap();
    std::fs::write(folder.join("x.dat"), "70 40 0.1\n").unwrap();
    std::fs::write(folder.join("ok.txt"), values(|theta, phi| f64::from(theta + phi))).unwrap();
    for (name, head) in [("a.csv", "value_a,value_b"), ("b.csv", "value_a,value_c")] {
        let rows = (0..64).map(|i| format!("{},{},1,2\n", 10 + i / 8, 10 * (i % 8)));
        std::fs::write(folder.join(name), format!("theta,phi,{head}\n{}", rows.collect::<String>())).unwrap();
    }
    let all: &[(&[&str], &[&str])] = &[
        (&["nan.txt", "--theta-o", "-30"], &["error: nan.txt, line 2", "'NaN'"]),
        (&["x.dat"], &["x.dat", "unknown format"]),
        (&["no.txt"], &["no.txt", "cannot read"]),
        (&["nan.txt", "--out", "x.json"], &["x.json", ".toml"]),
        (&["nan.txt", "--report", "x.dat"], &["x.dat", "not a folder"]),
        (&["nan.txt", "--fix", "eta"], &["--fix eta", "NAME="]),
        (&["nan.txt", "--fix", "eta=x"], &["--fix eta=x", "'x' is not a number"]),
        (&["nan.txt", "--model", "phong"], &["unknown model 'phong'", "chiang2016"]),
        (&["nan.txt", "--model", "deon"], &["deon2011 cannot be fitted", "yan2015"]),
        (&["nan.txt", "--eta-m", "1.4"], &["--eta-m", "cannot be used with"]),
        (&["--simulate", "cat", "--out", "a.txt", "--model", "phong"], &["unknown model 'phong'"]),
        (&["--simulate", "cat", "--out", "a.txt", "--eta-m", "1.4"], &["--eta-m", "yan2015"]),
        (&["--simulate", "cat", "--out", "a.txt", "--eta-m", "0.4", "--model", "yan2015"], &["eta_m = 0.4", "[1, 3]"]),
        (
            &["--simulate", "cat", "--out", "a.txt", "--model", "chiang", "--from", "reference"],
            &["chiang2016", "--from"],
        ),
        (&["nan.txt", "--huber", "0.5"], &["--huber 0.5", "at least 1"]),
        (&["nan.txt", "--theta-o", "-30,-45"], &["--theta-o has 2 values"]),
        (&["nan.txt", "b.txt", "--theta-o", "1,2,3"], &["--theta-o has 3 values for 2 profiles"]),
        (&["nan.txt", "--theta-o", "-30,x"], &["--theta-o", "'x'"]),
        (&["nan.txt", "--blur", "31"], &["--blur", "blur = 31 is out of range", "[0, 30]"]),
        (&["nan.txt", "--blur", "5,x"], &["--blur", "'x' is not a number"]),
        (&["nan.txt", "a/nan.csv"], &["nan.txt and a/nan.csv have the same name"]),
        (&["nan.txt", "b.txt", "--out", "x.dat"], &["cannot create the folder x.dat"]),
        (&["ok.txt", "--theta-o", "-30", "--separate", "sigma_ca"], &["--separate needs --joint", "value_NAME"]),
        (&["ok.txt", "--theta-o", "-30", "--share", "scale"], &["--share needs --joint"]),
        (&["a.csv", "b.csv", "--theta-o", "-30", "--joint"], &["b.csv has other channels than a.csv"]),
        (&["--simulate", "cat", "--out", "a.txt", "--absorption", "a.csv"], &["--absorption needs --out FILE.csv"]),
        (&["--simulate", "cat", "--out", "c.csv", "--absorption", "a.csv"], &["a.csv: the columns are theta, phi"]),
        (
            &["--simulate", "cat", "--out", "c.csv", "--absorption", "a.csv", "--from", "reference"],
            &["--absorption is only for --from model"],
        ),
        (&["nan.txt", "--joint", "--separate", "etta"], &["--separate etta", "unknown parameter 'etta'"]),
        (&["nan.txt", "--joint", "--share", "etta"], &["--share etta", "unknown parameter 'etta'"]),
        (&["--simulate", "cat", "--joint", "--out", "a.txt"], &["--joint", "cannot be used with"]),
        (&["--simulate", "cat", "--out", "a.txt", "--theta-o", "1,2"], &["one value of --theta-o"]),
        (&["--simulate", "cat", "--out", "a.txt", "--from", "reference", "--blur", "2"], &["--blur", "--from model"]),
        (&["nan.txt", "--theta", "10:50"], &["--theta and --phi"]),
        (&["nan.txt", "--theta", "10:50", "--phi", "0:180"], &["has its own"]),
        (&[], &["PROFILE"]),
        (&["nan.txt", "--simulate", "cat"], &["cannot be used with"]),
        (&["nan.txt", "--noise", "0.1"], &["--noise", "cannot be used with"]),
        (&["--simulate", "cat", "--fix", "eta=1"], &["cannot be used with"]),
        (&["--simulate", "cat"], &["--out"]),
        (&["--simulate", "unicorn", "--out", "a.txt"], &["unicorn", "red-fox"]),
        (&["--simulate", "cat", "--out", "a.png"], &["a.png", ".txt or .csv"]),
        (&["--simulate", "cat", "--out", "a.txt", "--noise", "2"], &["noise = 2", "[0, 1]"]),
        (&["--simulate", "cat", "--out", "a.txt", "--step", "0"], &["steps of 0"]),
        (&["--simulate", "cat", "--out", "a.txt", "--photons", "9"], &["--from reference"]),
        (&["--simulate", "cat", "--out", "a.txt", "--theta", "10:95"], &["theta = 90", "(-90, 90)"]),
    ];
    for (args, parts) in all {
        refused(folder, args, parts);
    }
}

/// Values that no fibre can have, over the directions of a gantry.
fn values(mut value: impl FnMut(i32, i32) -> f64) -> String {
    let rows = (40..=80).step_by(4).flat_map(|theta| (70..=290).step_by(10).map(move |phi| (theta, phi)));
    rows.map(|(theta, phi)| format!("{phi} {theta} {:e}\n", value(theta, phi))).collect()
}

/// Exit code 2 and no fibre. The report shows why. --allow-bad-fit writes the fibre with a mark.
#[test]
fn bad_fits_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut state = 1u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.1 + (state >> 11) as f64 * 0.5f64.powi(53)
    };
    std::fs::write(folder.join("noise.txt"), values(|_, _| noise())).unwrap();
    std::fs::write(folder.join("constant.txt"), values(|_, _| 0.5)).unwrap();
    std::fs::write(folder.join("huge.txt"), values(|theta, phi| 1e38 * (1.0 + 0.01 * f64::from(theta + phi)))).unwrap();
    let with = |name: &'static str| [name, "--theta-o", "-30", "--starts", "2", "--out", "x.toml"];
    refused(folder, &with("constant.txt"), &["constant.txt", "all measurements are the same"]);
    refused(folder, &with("huge.txt"), &["huge.txt", "out of range", "[1e-20, 1e20]"]);

    let output = command(folder, &[&with("noise.txt")[..], &["--report", "report"]].concat()).run().unwrap();
    assert!(output.status.code() == Some(2) && !folder.join("x.toml").exists());
    let said = String::from_utf8_lossy(&output.stderr);
    let parts = ["error: noise.txt: no fit", "constant", "NRMSE", "x.toml was not written", "report/index.html shows"];
    for part in parts.iter().chain(&["--allow-bad-fit", "--angles", "--theta-o"]) {
        assert!(said.contains(part), "{part}: {said}");
    }
    let page = || std::fs::read_to_string(folder.join("report/index.html")).unwrap();
    assert!(page().contains("Fit of noise.txt by vellus, reflecting exit (no fit)"));

    let output = run(folder, &[&with("noise.txt")[..], &["--allow-bad-fit", "--format", "json"]].concat());
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(value["no_fit"].as_str().unwrap().contains("constant") && value["explained"].as_f64().unwrap() < 0.2);
    assert!(String::from_utf8_lossy(&output.stderr).contains("warning: no fit"));
    assert!(std::fs::read_to_string(folder.join("x.toml")).unwrap().starts_with("# NO FIT"));
}

/// Negative values count as missing, and a highlight at an inclination that was not measured is named.
#[test]
fn doubtful_measurements_are_fitted_with_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["--simulate", "raccoon", "--step", "8", "--gaps", "0", "--out", "raccoon.txt"]);
    let text = std::fs::read_to_string(folder.join("raccoon.txt")).unwrap();
    let (head, values): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    let dark = values.iter().take(3).map(|line| format!("{} -0.001", line.rsplit_once(' ').unwrap().0));
    let rest = values.iter().skip(3).map(|line| (*line).to_owned());
    let lines: Vec<String> = head.iter().map(|line| (*line).to_owned()).chain(dark).chain(rest).collect();
    std::fs::write(folder.join("dark.txt"), lines.join("\n")).unwrap();
    let warned = String::from_utf8(run(folder, &["dark.txt", "--starts", "4"]).stderr).unwrap();
    let negative = format!("warning: negative values, which count as missing: 3 of {} directions\n", values.len());
    assert!(warned.contains(&negative) && !warned.contains("highlight"), "{warned}");
    // The wrong sign.
    let parts = ["no fit", "is outside of the data", "--theta-o"];
    refused(folder, &["raccoon.txt", "--theta-o", "30", "--starts", "4"], &parts);
    let wrong = ["raccoon.txt", "--theta-o", "30", "--starts", "4", "--allow-bad-fit"];
    let warned = String::from_utf8(run(folder, &wrong).stderr).unwrap();
    assert!(warned.contains("is outside of the data: theta_o = 30°") && warned.contains("--free theta_o"), "{warned}");
    let freed = String::from_utf8(run(folder, &[&wrong[..], &["--free", "theta_o"]].concat()).stderr).unwrap();
    assert!(!freed.contains("--free theta_o"), "{freed}");
}

/// Ctrl-C during a long fit writes the best fibre so far, marked as interrupted.
#[cfg(unix)]
#[test]
fn an_interrupted_fit_leaves_its_best() {
    use vellus_testing::program::Signal;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["--simulate", "human", "--step", "4", "--out", "human.txt"]);
    let args = ["human.txt", "--starts", "9999", "--out", "human.toml", "--format", "json"];
    let child = command(folder, &args).start().unwrap();
    child.wait_until_it_catches(Signal::INT);
    std::thread::sleep(std::time::Duration::from_secs(2));
    child.send(Signal::INT);
    let output = child.end();
    assert_eq!(output.status.code(), Some(130));
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(value["interrupted"], true);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("warning: interrupted"), "{message}");
    assert!(message.contains("of 9999 starts is in human.toml"), "{message}");
    assert!(std::fs::read_to_string(folder.join("human.toml")).unwrap().starts_with("# INTERRUPTED"));
}
