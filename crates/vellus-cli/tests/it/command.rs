//! Results, formats and error messages of the command.

use crate::common::LIMIT;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Output, Stdio};

fn vellus(args: &[&str]) -> Output {
    crate::common::vellus(Path::new("."), args)
}

fn stdout(args: &[&str]) -> String {
    let output = vellus(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Exit code 2, nothing on standard output, one message that contains all of `parts`.
fn refused(args: &[&str], parts: &[&str]) {
    let output = vellus(args);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
    assert!(output.stdout.is_empty(), "{args:?}");
    for part in parts {
        assert!(message.contains(part), "{args:?}: '{part}' is not in: {message}");
    }
}

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn bad_input_is_named_with_value_and_range() {
    refused(&["eval", "--fiber", "cat", "--set", "kappa=1"], &["in --set kappa=1", "kappa = 1", "[0, 0.99]"]);
    refused(&["eval", "--set", "eta=0.9"], &["eta = 0.9", "[1, 3]"]);
    refused(&["eval", "--set", "sigma_ca=0.1,-0.2,0.1"], &["sigma_ca.g = -0.2", "[0, 1000]"]);
    refused(&["eval", "--set", "sigma_ms=NaN"], &["sigma_ms = NaN", "[0, 1000]"]);
    refused(&["eval", "--h", "1.5"], &["h = 1.5", "[-1, 1]"]);
    refused(&["eval", "--h", "nan"], &["h = NaN", "[-1, 1]"]);
    refused(&["eval", "--window", "wide"], &["--window wide", "near, far or LO:HI"]);
    refused(&["eval", "--window", "0:2"], &["h_hi = 2", "[-1, 1]"]);
    refused(&["energy", "--window", "0.5:0.2"], &["h_lo = 0.5", "h_hi = 0.2"]);
    refused(&["eval", "--fiber", "unicorn"], &["unicorn", "red-fox", "springbok"]);
    refused(&["eval", "--set", "colour=1"], &["unknown parameter 'colour'", "sigma_ca"]);
    refused(&["eval", "--set", "kappa"], &["NAME=VALUE"]);
    refused(&["eval", "--set", "sigma_ca=1", "--set", "eumelanin=1"], &["more than once"]);
    refused(&["energy", "--theta-o", "91"], &["theta_o = 91", "[-90, 90]"]);
    refused(&["reference", "--theta-o", "90", "--photons", "10"], &["theta_o = 90", "(-90, 90)"]);
    refused(&["eval", "--fiber", "missing.toml"], &["cannot read missing.toml"]);
    refused(&["table", "info", "missing.vellus"], &["missing.vellus"]);
    refused(&["plot", "lobes", "--out", "x.gif"], &["x.gif", ".png or .svg"]);
    refused(&["plot", "lobes", "--model", "phong"], &["unknown model 'phong'", "yan2015", "marschner2003"]);
    refused(&["plot", "models", "--models", "vellus,phong"], &["unknown model 'phong'"]);
    refused(&["plot", "profile", "--model", "chiang2016", "--eta-m", "1.2"], &["--eta-m", "chiang2016", "yan2015"]);
    refused(&["plot", "energy", "--model", "yan2015", "--eta-m", "0.5"], &["eta_m = 0.5", "[1, 3]"]);
    refused(&["plot", "windows", "--window", "near"], &["no width", "far or LO:HI"]);
    refused(&["plot", "windows", "--window", "0.5:0.5"], &["h 0.5 to 0.5", "no width"]);
}

#[test]
fn broken_files_are_named_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.csv");
    let queries = |text: &str, parts: &[&str]| {
        let file = write(folder.path(), "queries.csv", text);
        let out = out.to_str().unwrap();
        refused(&["eval", "--queries", &file, "--format", "csv", "--out", out], parts);
        assert!(!Path::new(out).exists(), "a partial output file was left");
    };
    queries("theta_o,h,theta_i,phi\n0,0,0,0\n10,0.5,abc,0\n", &["queries.csv", "line 3", "theta_i = 'abc'"]);
    queries("theta_o,h,theta_i,phi\n0,0,0,0\n10,0.5,0,0\n10,-1.5,0,0\n", &["line 4", "h = -1.5", "[-1, 1]"]);
    queries("theta_o,h,theta_i,phi\n0,0,0\n", &["line: 2"]);
    queries("theta_o,h,theta_i\n0,0,0\n", &["line 1", "phi"]);
    queries("theta_o,h,theta_i,phi\n", &["no queries"]);
    queries("theta_o,h_lo,theta_i,phi\n0,0,0,0\n", &["line 1", "h_hi"]);
    queries("theta_o,h,h_lo,h_hi,theta_i,phi\n0,0,0,0,0,0\n", &["line 1", "both"]);
    queries("theta_o,h_lo,h_hi,theta_i,phi\n0,-1,1,0,0\n0,-1,1.5,0,0\n", &["line 3", "h_hi = 1.5", "[-1, 1]"]);
    let fiber = write(folder.path(), "fur.toml", "preset = \"cat\"\nkapa = 0.5\n");
    refused(&["eval", "--fiber", &fiber], &["fur.toml", "kapa"]);
    let fiber = write(folder.path(), "fur.json", "{\"kappa\": 2}");
    refused(&["eval", "--fiber", &fiber], &["fur.json", "kappa = 2"]);
    let table = write(folder.path(), "bad.vellus", "VELLUSM1 and no more");
    refused(&["table", "info", &table], &["bad.vellus", "header"]);
    // The folder only contains the inputs.
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 4, "{left:?}");
}

/// `--window far` is the window −1:1, from the command line and from a file.
#[test]
fn windows_are_evaluated() {
    let far = stdout(&["eval", "--fiber", "cat", "--window", "far", "--format", "csv"]);
    assert_eq!(far, stdout(&["eval", "--fiber", "cat", "--window", "-1:1", "--format", "csv"]));
    assert!(far.starts_with("theta_o,h_lo,h_hi,theta_i,phi,R.r"), "{far}");
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "queries.csv", "h_hi,h_lo,theta_o,theta_i,phi\n1,-1,20,-15,150\n");
    assert_eq!(far, stdout(&["eval", "--fiber", "cat", "--queries", &file, "--format", "csv"]));
    assert_ne!(far.lines().last(), stdout(&["eval", "--fiber", "cat", "--format", "csv"]).lines().last());
}

/// A table of any length needs no memory: answers come while queries arrive.
#[test]
fn queries_are_answered_one_after_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["eval", "--queries", "-", "--format", "csv"];
    let mut child = crate::common::command(folder.path(), &args).stdin(Stdio::piped()).spawn().unwrap();
    let mut queries = child.stdin.take().unwrap();
    queries.write_all(format!("theta_o,h,theta_i,phi\n{}", "10,0.5,20,30\n".repeat(1000)).as_bytes()).unwrap();
    let (sender, lines) = std::sync::mpsc::channel();
    let answers = BufReader::new(child.stdout.take().unwrap());
    std::thread::spawn(move || answers.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
    let first = lines.recv_timeout(LIMIT).expect("an answer before the end of the queries");
    assert!(first.starts_with("theta_o,h,theta_i,phi,"), "{first}");
    // One that cannot be read ends the program after the answers to those before.
    queries.write_all(b"10,0.5,20,x\n").unwrap();
    drop(queries);
    assert_eq!(lines.iter().filter(|line| line.starts_with("10,0.5,20,30,")).count(), 1000);
    assert_eq!(child.wait().unwrap().code(), Some(2));
}

#[test]
fn a_query_has_the_same_result_in_every_format() {
    let flags = [
        "eval",
        "--fiber",
        "cat",
        "--set",
        "sigma_ca=0.1,0.2,0.4",
        "--theta-o",
        "-20",
        "--h",
        "0.3",
        "--theta-i",
        "15",
        "--phi",
        "160",
    ];
    let with = |format: &'static str| stdout(&[&flags[..], &["--format", format]].concat());
    let object: serde_json::Value = serde_json::from_str(&with("jsonl")).unwrap();
    for key in ["R", "TT", "TRT", "TTs", "TRTs", "rest", "total"] {
        assert_eq!(object[key].as_array().unwrap().len(), 3, "{key}");
    }
    let csv = with("csv");
    let (header, row) = csv.trim().split_once('\n').unwrap();
    let column = |name: &str| {
        let at = header.split(',').position(|h| h == name).unwrap();
        row.split(',').nth(at).unwrap().parse::<f64>().unwrap()
    };
    assert_eq!(column("TTs.g"), object["TTs"][1].as_f64().unwrap());
    assert_eq!(column("pdf"), object["pdf"].as_f64().unwrap());
    assert!(column("total.r") > column("total.b"), "the fibre is red");
    assert!(with("table").contains("TRTs"));
}

#[test]
fn csv_queries_keep_their_order_and_accept_any_column_order() {
    let folder = tempfile::tempdir().unwrap();
    let file =
        write(folder.path(), "q.csv", "# a comment\nphi, h, theta_i, theta_o\n180, 0.1, -10, 10\n90,-0.5,20,0\n");
    let out = folder.path().join("new/folder/answers.jsonl");
    stdout(&["eval", "--queries", &file, "--format", "jsonl", "--out", out.to_str().unwrap()]);
    let text = std::fs::read_to_string(out).unwrap();
    let lines: Vec<serde_json::Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(lines.len(), 2);
    assert_eq!((lines[0]["phi"].as_f64(), lines[1]["h"].as_f64()), (Some(180.0), Some(-0.5)));
}

#[test]
fn a_shown_fiber_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    for format in ["toml", "json"] {
        let text = stdout(&["fiber", "show", "red-fox", "--set", "alpha=-3.3", "--format", format]);
        let file = write(folder.path(), &format!("fox.{format}"), &text);
        assert_eq!(stdout(&["fiber", "show", &file, "--format", format]), text);
    }
    let brown = write(folder.path(), "brown.toml", "eumelanin = 1.3\n");
    assert!(stdout(&["fiber", "show", &brown]).contains("sigma_ca = [0.5"));
    assert_eq!(stdout(&["fiber", "list"]).lines().filter(|l| l.contains("0.")).count(), 20);
}

#[test]
fn energy_agrees_with_itself() {
    let text = stdout(&["energy", "--fiber", "raccoon", "--theta-o", "30", "--h", "0.3", "--format", "json"]);
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let total = &value["lobes"]["total"];
    let (a, b) = (total["closed_form"][0].as_f64().unwrap(), total["integral"][0].as_f64().unwrap());
    assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
}

#[test]
fn reference_is_json_and_repeatable() {
    let args = ["reference", "--fiber", "cat", "--theta-o", "0", "--photons", "20000", "--format", "json"];
    let text = stdout(&args);
    assert_eq!(text, stdout(&args));
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    for fate in ["R", "TT", "TRT", "higher", "scattered", "guided", "total"] {
        assert!(value["energies"][fate]["standard_error"].is_array(), "{fate}");
    }
}

#[test]
fn pictures_are_written_in_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    for (name, args) in [
        ("lobes", vec!["plot", "lobes", "--fiber", "human", "--h", "-0.4"]),
        ("energy", vec!["plot", "energy", "--fiber", "human"]),
        ("yan2015", vec!["plot", "lobes", "--model", "yan2015", "--eta-m", "1.2"]),
        ("marschner2003", vec!["plot", "energy", "--fiber", "human", "--model", "marschner2003"]),
        ("models", vec!["plot", "models", "--fiber", "dog", "--models", "vellus,deon2011"]),
        ("medulla", vec!["plot", "medulla", "--photons", "2000"]),
        ("profile", vec!["plot", "profile", "--fiber", "dog", "--theta-o", "-20"]),
        ("windows", vec!["plot", "windows", "--fiber", "human", "--window", "-0.5:1"]),
        ("error", vec!["plot", "error", "--fiber", "dog", "--theta-o", "30"]),
    ] {
        let files = ["png", "svg"].map(|e| folder.path().join(format!("{name}.{e}")).to_str().unwrap().to_owned());
        stdout(&[&args[..], &["--out", &files[0], "--out", &files[1]]].concat());
        let (png, svg) = (std::fs::read(&files[0]).unwrap(), std::fs::read_to_string(&files[1]).unwrap());
        assert!(png.starts_with(b"\x89PNG") && png.len() > 5000, "{name}: {} bytes", png.len());
        assert!(svg.starts_with("<svg") && svg.contains("<text"), "{name}");
    }
}

/// The command prints the numbers of the picture. Our errors are below the paper's, and the fast version is as accurate
/// as the f64 version.
#[test]
fn errors_of_the_far_field_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("error.svg").to_str().unwrap().to_owned();
    let text = stdout(&["plot", "error", "--fiber", "bobcat", "--out", &out]);
    let numbers = |name: &str| -> Vec<f64> {
        let row = text.lines().find(|line| line.starts_with(name)).unwrap();
        row[name.len()..].split_whitespace().map(|x| x.parse().unwrap()).collect()
    };
    let (seven, shipped) = (numbers("7 "), numbers("7, as shipped"));
    let [paper, ours] = seven[..] else { panic!("{text}") };
    // Errors are in percent. Single precision and Gaussians for wide lobes add at most 0.1.
    assert!(paper > 10.0 && ours < 1.0 && (shipped[0] - ours).abs() < 0.1, "{text}");
}

/// An interrupted build continues from its pieces. The result is the same, and the pieces are removed.
#[test]
fn a_table_build_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let build = |out: &str| stdout(&["table", "build", "--quality", "smoke", "--photons", "1000", "--out", out]);
    build(&path("a.vellus"));
    // The pieces of an earlier run. One is complete, and one is truncated.
    let work = folder.path().join("b.vellus.work");
    std::fs::create_dir(&work).unwrap();
    std::fs::write(work.join("azimuthal-00-10x7x8x12x180-1000-2017.f32"), b"too short").unwrap();
    build(&path("b.vellus"));
    assert_eq!(std::fs::read(path("a.vellus")).unwrap(), std::fs::read(path("b.vellus")).unwrap());
    assert!(!work.exists());
    assert!(stdout(&["table", "info", &path("a.vellus")]).contains("non-negative"));
    let check = stdout(&["table", "check", &path("a.vellus"), "--profiles", "2", "--photons", "20000", "--all"]);
    assert!(check.contains("azimuthal") && check.contains("forward"), "{check}");
}
