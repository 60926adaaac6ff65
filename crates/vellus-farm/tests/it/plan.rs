//! Plans as files: what they contain, and what is refused.

use std::collections::HashSet;
use std::path::Path;
use tempfile::TempDir;
use vellus_farm::{Error, Experiments, PLAN_FILE, Pictures, Plan, State, Tables, Work};
use vellus_io::Digest;

fn digest(command: &[String]) -> Result<Digest, Error> {
    Ok(Digest::of(command.join(" ").as_bytes()))
}

fn pictures(frames: Option<&str>, samples: u64, per_task: u64) -> Work {
    let options = ["--size", "8x8", "--float"].map(str::to_owned).to_vec();
    let frames = frames.map(str::to_owned);
    Work::Pictures(Pictures {
        scene: "in/cat.usda".to_owned(),
        options,
        frames,
        samples,
        per_task,
        ..Default::default()
    })
}

fn saved(work: Work) -> (TempDir, Plan) {
    let folder = tempfile::tempdir().unwrap();
    let plan = Plan::new(folder.path(), work, digest).unwrap();
    plan.save().unwrap();
    (folder, plan)
}

/// The file of a plan after a replacement, which must change it.
fn changed(folder: &Path, from: &str, to: &str) -> Result<Plan, Error> {
    let path = folder.join(PLAN_FILE);
    let text = std::fs::read_to_string(&path).unwrap();
    let other = text.replacen(from, to, 1);
    assert_ne!(text, other, "{from}");
    std::fs::write(&path, other).unwrap();
    let result = Plan::load(folder);
    std::fs::write(&path, text).unwrap();
    result
}

#[test]
fn samples_are_divided_without_gaps() {
    let (folder, plan) = saved(pictures(Some("-1-3x2"), 10, 4));
    assert_eq!(Plan::load(folder.path()).unwrap(), plan);
    let tasks = plan.tasks();
    assert_eq!(tasks.len(), 3 * 3 + 3);
    let ranges: Vec<_> = tasks[..3].iter().map(|task| task.samples.clone().unwrap()).collect();
    assert_eq!(ranges, [0..4, 4..8, 8..10]);
    let command = "render in/cat.usda --size 8x8 --frame=-1 --samples=8..10 --resume \
                   --output={dir}/films/-0001.8-10.png";
    assert_eq!(tasks[2].command.join(" "), command);
    let merge = &tasks[9];
    assert_eq!(merge.needs, ["-0001.0-4", "-0001.4-8", "-0001.8-10"]);
    let films = "{dir}/films/-0001.0-4.film {dir}/films/-0001.4-8.film {dir}/films/-0001.8-10.film";
    assert_eq!(merge.command.join(" "), format!("merge {films} --output={{dir}}/pictures/cat.-0001.exr --float"));
    assert_eq!(tasks[11].outputs, ["pictures/cat.0003.exr", "pictures/cat.0003.png"]);
    // Frames have identities of their own, and their merges too.
    assert_eq!(tasks.iter().map(|task| &task.identity).collect::<HashSet<_>>().len(), 6);
    let arguments = plan.arguments(&tasks[2]);
    let output = format!("--output={}/films/-0001.8-10.png", folder.path().display());
    assert_eq!(arguments.last().unwrap().to_str(), Some(output.as_str()));
    assert_eq!([("3", 2), ("0001.merge", 10), ("0012", 11)].map(|(name, _)| plan.find(name).unwrap()), [2, 10, 11]);
    for name in ["0", "13", "x", "", "+1", "99999999999999999999"] {
        assert!(matches!(plan.find(name), Err(Error::NoTask { .. })), "{name}");
    }
}

#[test]
fn a_number_is_never_the_name_of_a_frame() {
    for per_task in [1, 4] {
        let (_folder, plan) = saved(pictures(Some("1-1600"), 4, per_task));
        for (i, task) in plan.tasks().iter().enumerate() {
            assert_eq!((plan.find(&(i + 1).to_string()).unwrap(), plan.find(&task.name).unwrap()), (i, i));
        }
    }
    let (folder, _) =
        saved(Work::Experiments(Experiments { quality: "smoke".to_owned(), names: vec!["x1".to_owned()] }));
    assert!(changed(folder.path(), "\"x1\"", "\"11\"").unwrap_err().to_string().contains("is a number"));
}

#[test]
fn a_plan_that_was_changed_is_refused() {
    let (folder, _) = saved(pictures(Some("1-2"), 8, 4));
    let folder = folder.path();
    let refused = |from: &str, to: &str| {
        let error = changed(folder, from, to).unwrap_err();
        assert!(matches!(error, Error::Plan { .. }), "{from} to {to}: {error}");
        error.to_string()
    };
    for (from, to) in [
        ("{dir}/films/0001.0-4.png", "/etc/passwd"),
        ("films/0001.0-4.film", "../../0001.0-4.film"),
        ("\"render\"", "\"table\""),
        ("\"needs\": []", "\"needs\": [\"0001.merge\"]"),
        ("\"end\": 4", "\"end\": 5"),
    ] {
        assert!(refused(from, to).contains("not those of its work"));
    }
    assert!(refused("\"--float\"", "\"-o/etc/x\"").contains("cannot contain the option"));
    assert!(refused("\"--float\"", "\"--tev\"").contains("--tev"));
    assert!(refused("\"version\": 2", "\"version\": 1").contains("version 2"));
    refused("\"in/cat.usda\"", "\"--help\"");
    refused("\"1-2\"", "\"1-99999999\"");
    refused("\"1-2\"", "\"1-3\"");
    refused("\"samples\": 8", "\"samples\": 18446744073709551615");
    refused("\"per_task\": 4", "\"per_task\": 0");
    refused("\"version\"", "\"extra\": 1, \"version\"");
    refused("{", "[");
}

#[test]
fn no_damage_changes_a_task() {
    let (folder, plan) = saved(pictures(None, 8, 4));
    let path = folder.path().join(PLAN_FILE);
    let bytes = std::fs::read(&path).unwrap();
    let load = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        Plan::load(folder.path()).ok()
    };
    let mut accepted = 0;
    for at in (0..bytes.len()).step_by(5) {
        let mut flipped = bytes.clone();
        flipped[at] ^= 1 << (at % 7);
        // Spaces, the version of the program and the folder of inputs may differ.
        let loaded = load(&flipped);
        assert!(loaded.as_ref().is_none_or(|other| other.tasks() == plan.tasks()), "{at}");
        accepted += usize::from(loaded.is_some());
        assert!(at + 2 > bytes.len() || load(&bytes[..at]).is_none(), "{at}");
    }
    assert!(accepted > 0 && accepted < bytes.len() / 20, "{accepted}");
}

#[test]
fn names_of_experiments_cannot_leave_the_folder() {
    for bad in ["../x", "a/b", "", "-x", "a b", "$(x)", "é"] {
        for (quality, name) in [("smoke", bad), (bad, "lobes")] {
            let experiments = Experiments { quality: quality.to_owned(), names: vec![name.to_owned()] };
            let plan = Plan::new(Path::new("x"), Work::Experiments(experiments), digest);
            assert!(matches!(plan, Err(Error::Options(_))), "{bad}");
        }
    }
    let twice = Experiments { quality: "smoke".to_owned(), names: vec!["lobes".to_owned(), "lobes".to_owned()] };
    assert!(Plan::new(Path::new("x"), Work::Experiments(twice), digest).is_err());
}

#[test]
fn work_out_of_range_is_refused() {
    let refused = |work| Plan::new(Path::new("x"), work, digest).unwrap_err().to_string();
    assert!(refused(pictures(Some("1-48"), 1 << 31, 64)).contains("samples"));
    assert!(refused(pictures(Some("1-48"), 1 << 20, 1)).contains("4096"));
    assert!(refused(pictures(Some("1-90000"), 64, 4)).contains("100000"));
    assert!(refused(pictures(Some("2-1"), 64, 4)).contains("frames are"));
}

#[test]
fn tables_and_experiments_are_lists_of_commands() {
    let (folder, plan) = saved(Work::Tables(Tables { quality: "smoke".to_owned() }));
    assert_eq!(plan.tasks().len(), 1);
    let other = changed(folder.path(), "\"vellus\": \"", "\"vellus\": \"9").unwrap_err().to_string();
    assert!(other.contains("vellus 9") && other.contains("planned it"), "{other}");
    let names = ["lobes", "hair"].map(str::to_owned).to_vec();
    let (_folder, plan) = saved(Work::Experiments(Experiments { quality: "paper".to_owned(), names: names.clone() }));
    let tasks = plan.tasks();
    assert_eq!(tasks[0].command, ["experiment", "lobes", "--quality=paper", "--out={dir}/experiments"]);
    assert_eq!((tasks[2].name.as_str(), &tasks[2].needs), ("report", &names));
    let status = plan.status();
    assert_eq!(status.count(State::Missing), 3);
    assert!(status.to_string().contains("Experiments        2         0         2"), "{status}");
    let json: serde_json::Value = serde_json::from_str(&status.json()).unwrap();
    assert_eq!(
        (&json["total"], &json["missing"], &json["tasks"][2]["state"]),
        (&3.into(), &3.into(), &"missing".into())
    );
}
