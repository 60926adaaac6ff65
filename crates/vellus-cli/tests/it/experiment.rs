//! What `vellus experiment` writes at smoke quality, which only tests that it runs.

use crate::common::{Limited, command, ended_by, refused, run, vellus};
use serde_json::Value;
use std::path::Path;

/// The names of all experiments.
const NAMES: [&str; 16] = [
    "medulla-tables",
    "species",
    "segment-error",
    "energy",
    "exit",
    "queries",
    "scenes",
    "closeup",
    "indices",
    "lobes",
    "zoom",
    "convergence",
    "hair",
    "raccoon",
    "hamster",
    "cat",
];

/// The verdict on every claim at smoke quality.
const NO_VERDICT: &str = "not judged at smoke quality";

fn smoke<'a>(names: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [&["experiment", "--quality", "smoke", "--out", "found"], names, more].concat()
}

fn result(folder: &Path, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("found").join(name).join("result.json")).unwrap()).unwrap()
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("{key} of {value}"))
}

/// A claim is a short sentence without a full stop, and what was measured has exactly one number.
fn one_sentence_and_one_number(what: &str, measured: &str) {
    let words = what.split_whitespace().count();
    assert!((4..=20).contains(&words) && !what.contains([';', ':']) && !what.ends_with('.'), "{what}");
    assert!(what.starts_with(char::is_uppercase), "{what}");
    let numbers = measured.split_whitespace().filter(|word| word.parse::<f64>().is_ok()).count();
    assert_eq!(numbers, 1, "{what}: {measured}");
    assert!(measured.split_whitespace().count() <= 8, "{what}: {measured}");
}

/// Every experiment writes a result that parses, complete tables, pictures, and claims that are not judged and say why.
/// The page lists all experiments. A second run does nothing.
#[test]
fn results_are_complete_reported_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &smoke(&["all"], &[]));
    let page = std::fs::read_to_string(path.join("found/index.html")).unwrap();
    for name in NAMES {
        let (found, place) = (result(path, name), path.join("found").join(name));
        assert_eq!((text(&found, "name"), text(&found, "quality")), (name, "smoke"));
        assert_eq!(text(&found, "version"), env!("CARGO_PKG_VERSION"));
        assert!(found["seconds"].as_f64().unwrap() > 0.0 && !text(&found, "paper").is_empty());
        let claims = found["claims"].as_array().unwrap();
        assert!(!claims.is_empty(), "{name} claims nothing");
        for claim in claims {
            assert_eq!((text(claim, "verdict"), claim["value"].is_null()), (NO_VERDICT, true), "{name}: {claim}");
            let keys = ["what", "paper", "ours", "measured", "why"];
            assert!(keys.iter().all(|key| !text(claim, key).is_empty()), "{name}: {claim}");
            one_sentence_and_one_number(text(claim, "what"), text(claim, "measured"));
        }
        for slider in found["sliders"].as_array().unwrap() {
            let [sides, maps] = ["sides", "maps"].map(|key| slider[key].as_array().unwrap());
            assert!(sides.len() == 2 && !maps.is_empty(), "{name}");
            for file in sides.iter().chain(maps).flat_map(|side| [text(side, "file"), text(side, "zoom")]) {
                assert!(std::fs::read(place.join(file)).unwrap().starts_with(b"\x89PNG"), "{name}: {file}");
                assert!(page.contains(&format!("src=\"{name}/{file}\"")), "{name}: {file}");
            }
        }
        let compared =
            ["closeup", "indices", "zoom", "hair", "raccoon", "hamster", "cat", "segment-error"].contains(&name);
        assert_eq!(compared, !found["sliders"].as_array().unwrap().is_empty(), "{name}");
        for picture in found["pictures"].as_array().unwrap() {
            assert!(std::fs::read(place.join(text(picture, "file"))).unwrap().starts_with(b"\x89PNG"), "{name}");
            for also in picture["also"].as_array().unwrap() {
                let also = place.join(also.as_str().unwrap());
                if also.extension().is_some_and(|e| e == "svg") {
                    let svg = std::fs::read_to_string(&also).unwrap();
                    assert!(svg.contains("<svg") && !svg.contains("NaN"), "{name}");
                } else {
                    assert!(std::fs::read(&also).unwrap().starts_with(b"\x76\x2f\x31\x01"), "{name}: OpenEXR");
                }
            }
            assert!(page.contains(&format!("{name}/{}", text(picture, "file"))), "{name}");
        }
        for table in found["tables"].as_array().unwrap() {
            let rows = table["rows"].as_array().unwrap();
            let mut csv = csv::Reader::from_path(place.join(format!("{}.csv", text(table, "name")))).unwrap();
            // The CSV reader refuses rows of different lengths.
            let records: Vec<_> = csv.records().map(Result::unwrap).collect();
            assert_eq!(records.len(), rows.len(), "{name}");
            for cell in records.iter().flatten() {
                assert!(!cell.is_empty() && !cell.contains("NaN") && !cell.contains("inf"), "{name}: '{cell}'");
            }
        }
        assert!(page.contains(&format!("<h2 id=\"{name}\">")) && page.contains(&format!("href=\"#{name}\"")), "{name}");
    }
    assert!(page.contains(NO_VERDICT) && !page.contains(">holds<") && !page.contains(">does not hold<"));
    let changed =
        |name: &str| std::fs::metadata(path.join("found").join(name).join("result.json")).unwrap().modified().unwrap();
    let before = NAMES.map(changed);
    let said = run(path, &smoke(&["all"], &[]));
    assert_eq!(NAMES.map(changed), before);
    assert_eq!(said.matches("is there").count(), NAMES.len(), "{said}");
    // A result of a better quality is not overwritten. A result states its quality.
    let file = path.join("found/scenes/result.json");
    let better = std::fs::read_to_string(&file).unwrap().replace("\"quality\": \"smoke\"", "\"quality\": \"paper\"");
    std::fs::write(&file, better).unwrap();
    assert!(run(path, &smoke(&["scenes"], &[])).contains("is there, at paper quality"));
    // Results of other versions and incomplete results do not count. --again runs finished experiments again.
    let file = path.join("found/queries/result.json");
    let other = std::fs::read_to_string(&file).unwrap().replace(env!("CARGO_PKG_VERSION"), "0.0.0");
    for content in [&other, &other[..100]] {
        std::fs::write(&file, content).unwrap();
        assert!(!run(path, &smoke(&["queries"], &[])).contains("is there"));
        assert_eq!(text(&result(path, "queries"), "version"), env!("CARGO_PKG_VERSION"));
    }
    assert!(!run(path, &smoke(&["queries"], &["--again"])).contains("is there"));
    // The page still lists all experiments.
    let page = std::fs::read_to_string(path.join("found/index.html")).unwrap();
    assert!(NAMES.iter().all(|name| page.contains(&format!("<h2 id=\"{name}\">"))));
}

/// After an interruption, finished pictures are read. Missing and damaged ones are rendered again and are
/// bit-identical.
#[test]
fn finished_pictures_are_not_rendered_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &smoke(&["zoom"], &[]));
    let place = path.join("found/zoom");
    let mut films: Vec<_> = std::fs::read_dir(&place).unwrap().map(|entry| entry.unwrap().path()).collect();
    films.retain(|file| file.extension().is_some_and(|e| e == "film"));
    films.sort();
    assert!(films.len() > 3, "{films:?}");
    let bytes = || films.iter().map(|file| std::fs::read(file).unwrap()).collect::<Vec<_>>();
    let changed = |file: &Path| std::fs::metadata(file).unwrap().modified().unwrap();
    let (before, times) = (bytes(), films.iter().map(|file| changed(file)).collect::<Vec<_>>());
    let picture = std::fs::read(place.join("zoom.png")).unwrap();
    std::fs::remove_file(place.join("result.json")).unwrap();
    std::fs::remove_file(&films[0]).unwrap();
    std::fs::write(&films[1], &before[1][..before[1].len() / 2]).unwrap();
    run(path, &smoke(&["zoom"], &[]));
    assert!(bytes() == before && std::fs::read(place.join("zoom.png")).unwrap() == picture);
    assert!(films[2..].iter().zip(&times[2..]).all(|(file, time)| changed(file) == *time), "rendered again");
    assert_eq!(text(&result(path, "zoom"), "quality"), "smoke");
}

/// Ctrl-C writes the page of the finished experiments, names it, and exits with the code of the signal.
#[cfg(unix)]
#[test]
fn an_interrupted_experiment_names_what_it_kept() {
    use vellus_testing::program::Signal;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &smoke(&["scenes"], &[]));
    let args = ["experiment", "convergence", "--quality", "paper", "--out", "found"];
    let kept = || std::fs::read_dir(path.join("found/convergence")).unwrap().map(|entry| entry.unwrap().path());
    let has_film = || kept().any(|file| file.extension().is_some_and(|e| e == "film"));
    // At paper quality the experiment takes minutes. A film is kept once it has a sample, which a busy machine may not
    // have computed at first.
    for seconds in [2, 8, 32] {
        let child = command(path, &args).start().unwrap();
        child.wait_until_it_catches(Signal::INT);
        std::thread::sleep(std::time::Duration::from_secs(seconds));
        child.send(Signal::INT);
        ended_by(
            &child.end(),
            130,
            &args,
            &[
                "interrupted: finished experiments are in found/index.html",
                "found/convergence",
                "the same command continues",
            ],
        );
        if has_film() {
            break;
        }
    }
    assert!(std::fs::read_to_string(path.join("found/index.html")).unwrap().contains("<h2 id=\"scenes\">"));
    assert!(has_film() && kept().all(|file| !file.ends_with("result.json")));
}

#[test]
fn experiments_are_listed_and_bad_names_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for args in [&["experiment"][..], &["experiment", "list"]] {
        let listed = String::from_utf8(vellus(path, args).stdout).unwrap();
        assert!(NAMES.iter().all(|name| listed.contains(name)) && listed.contains("Fig. 11"), "{listed}");
    }
    refused(path, &smoke(&["scenes", "fig-99"], &[]), &["no experiment 'fig-99'", "medulla-tables"]);
    assert!(!path.join("found").exists());
    std::fs::write(path.join("found"), "a file").unwrap();
    refused(path, &smoke(&["scenes"], &[]), &["cannot write found", "not a folder"]);
    refused(path, &["experiment", "all", "--quality", "best"], &["draft", "paper"]);
}
