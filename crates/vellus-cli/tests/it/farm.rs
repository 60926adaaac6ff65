//! Plans that run here and on other engines, and that are killed at any moment: the pictures have the same bits.
#![cfg(target_os = "linux")]

use crate::common::{Limited, Picture, Running, command, ended_by, refused, run, vellus, wait_until};
use std::collections::HashSet;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use vellus_farm::{PER_PLAN, PICTURE_OPTIONS};
use vellus_testing::program::{Signal, kill};
use vellus_testing::{need, succeeds};

const SCENE: &[&str] = &["hair-lock", "--small", "--size", "64x48", "--seed", "5"];

/// Plans a picture of this many samples in `farm`, and renders it at once to `one.exr`.
fn plan(folder: &Path, samples: &str, per_task: &str) {
    let options = [&["--samples", samples, "--per-task", per_task, "-o", "farm", "--"], &SCENE[1..]].concat();
    run(folder, &[&["farm", "plan", SCENE[0]], &options[..]].concat());
    run(folder, &[&["render"], SCENE, &["--spp", samples, "-o", "one.exr"]].concat());
}

/// Checks that the picture of the farm has the bits of the other.
fn assert_same(folder: &Path) {
    let farm = Picture::read(&folder.join("farm/pictures/hair-lock.exr"));
    let one = Picture::read(&folder.join("one.exr"));
    assert!(farm.same(&one));
    assert_eq!((farm.names().len(), farm.note("vellus_identity")), (37, one.note("vellus_identity")));
}

/// The counts of `farm status --json`: done, missing, damaged, foreign.
fn status(folder: &Path) -> [u64; 4] {
    let output = vellus(folder, &["farm", "status", "farm", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let total: u64 = json["total"].as_u64().unwrap();
    let counts = ["done", "missing", "damaged", "foreign"].map(|state| json[state].as_u64().unwrap());
    assert_eq!(counts.iter().sum::<u64>(), total);
    counts
}

/// Random numbers from a seed (Marsaglia's xorshift).
struct Random(u64);

impl Random {
    /// Seeded from the clock. No result may depend on it, and the message of a failure names it.
    fn new() -> Self {
        let seed = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64 | 1;
        eprintln!("seed {seed}");
        Random(seed)
    }

    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % end
    }
}

/// The children of a process.
fn children(pid: u32) -> Vec<u32> {
    let Ok(threads) = std::fs::read_dir(format!("/proc/{pid}/task")) else { return Vec::new() };
    let lists = threads.filter_map(|thread| std::fs::read_to_string(thread.ok()?.path().join("children")).ok());
    lists.flat_map(|list| list.split_whitespace().filter_map(|pid| pid.parse().ok()).collect::<Vec<_>>()).collect()
}

fn start(folder: &Path, args: &[&str]) -> Running {
    command(folder, args).stdout(Stdio::null()).stderr(Stdio::null()).start().unwrap()
}

#[test]
fn kills_at_random_moments_change_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    plan(path, "256", "32");
    let mut random = Random::new();
    let (mut runs, mut kills, mut damaged) = (0, 0, 0);
    loop {
        runs += 1;
        let mut farm = start(path, &["farm", "run", "farm", "--retries", "1"]);
        // Later runs are left alone, so that the test ends.
        while runs <= 6 && farm.ended_within(Duration::ZERO).is_none() {
            std::thread::sleep(Duration::from_millis(random.below(200)));
            let victims = children(farm.id());
            let victim = victims.get(random.below(victims.len().max(1) as u64) as usize);
            match (random.below(6), victim) {
                (0, _) => kills += u32::from(kill(farm.id(), Signal::KILL)),
                (1, _) => kills += u32::from(kill(farm.id(), Signal::INT)),
                (2, Some(&victim)) => kills += u32::from(kill(victim, Signal::TERM)),
                (_, Some(&victim)) => kills += u32::from(kill(victim, Signal::KILL)),
                _ => {}
            }
        }
        let ended = farm.end().status;
        if ended.success() {
            break;
        }
        assert!(runs < 40, "{ended} after {runs} runs");
        assert_ne!(ended.code(), Some(2), "a kill is no bad input");
        // Damage by something else than us, for example a disk.
        let films = std::fs::read_dir(path.join("farm/films")).into_iter().flatten().filter_map(|entry| {
            Some(entry.ok()?.path()).filter(|path| path.extension().is_some_and(|extension| extension == "film"))
        });
        if let Some(film) = films.last().filter(|_| random.below(4) == 0) {
            let bytes = std::fs::read(&film).unwrap();
            std::fs::write(&film, &bytes[..random.below(bytes.len() as u64) as usize]).unwrap();
            damaged += 1;
        }
    }
    eprintln!("{runs} runs, {kills} kills, {damaged} damaged films");
    assert!(kills > 0);
    assert_eq!(status(path), [9, 0, 0, 0]);
    assert_same(path);
}

#[test]
fn a_killed_farm_leaves_no_process() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &[&["farm", "plan", SCENE[0], "--samples", "1000000", "-o", "farm", "--"], &SCENE[1..]].concat());
    for (signal, code) in [(Signal::KILL, None), (Signal::TERM, Some(143)), (Signal::INT, Some(130))] {
        let farm = start(path, &["farm", "run", "farm"]);
        wait_until("a task", || !children(farm.id()).is_empty());
        let child = children(farm.id())[0];
        // Signals work in the program from its first lines on. Give it time to reach them.
        std::thread::sleep(Duration::from_millis(500));
        farm.send(signal);
        assert_eq!(farm.end().status.code(), code, "{signal:?}");
        wait_until(&format!("the end of the task after {signal:?}"), || {
            // It may be a zombie until the system's first process has waited for it.
            std::fs::read_to_string(format!("/proc/{child}/stat")).map_or(true, |stat| stat.contains(") Z "))
        });
    }
    // The last two kept their samples.
    assert!(path.join("farm/films/still.0-1000000.checkpoint").exists());
    assert_eq!(status(path), [0, 2, 0, 0]);
}

#[test]
fn frames_are_those_of_one_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &["scene", "hair-lock", "--small", "-o", "lock.usda"]);
    let options = ["--size", "32x24", "--light", "sun", "--float"];
    let farm =
        ["farm", "plan", "lock.usda", "--frames", "3-5x2", "--samples", "12", "--per-task", "5", "-o", "farm", "--"];
    run(path, &[&farm, &options[..]].concat());
    run(path, &[&["render", "lock.usda", "--frames", "3-5x2", "--spp", "12", "-o", "one.exr"], &options[..]].concat());
    // Whoever runs the tasks, in whatever order, from whatever folder.
    for task in ["6", "0003.5-10", "1", "0003.10-12", "0005.0-5", "5", "0003.merge", "0005.merge"] {
        let output = vellus(Path::new("/"), &["farm", "task", path.join("farm").to_str().unwrap(), task]);
        assert!(output.status.success(), "{task}: {}", String::from_utf8_lossy(&output.stderr));
    }
    for frame in ["0003", "0005"] {
        let [farm, one] = [format!("farm/pictures/lock.{frame}.exr"), format!("one.{frame}.exr")];
        assert!(Picture::read(&path.join(farm)).same(&Picture::read(&path.join(one))), "{frame}");
    }
    // Films may be deleted once their pictures are there.
    std::fs::remove_dir_all(path.join("farm/films")).unwrap();
    assert_eq!(status(path), [8, 0, 0, 0]);
    assert!(String::from_utf8_lossy(&vellus(path, &["farm", "run", "farm"]).stdout).contains("8 were done before"));
    assert!(String::from_utf8_lossy(&vellus(path, &["farm", "task", "farm", "1"]).stdout).contains("done before"));
    // Without its picture, a frame needs them again.
    std::fs::remove_file(path.join("farm/pictures/lock.0003.exr")).unwrap();
    assert_eq!(status(path), [4, 4, 0, 0]);
    ended_by(
        &vellus(path, &["farm", "task", "farm", "0003.merge"]),
        75,
        &["task"],
        &["needs 0003.0-5, and it is missing"],
    );
}

#[test]
fn nothing_is_written_or_read_through_links_and_pipes_in_the_folder() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let broken = "#usda 1.0\ndef \"S\" (references = @./q\ntouch PWNED\n#.usda@) {}\n";
    std::fs::write(path.join("evil.usda"), broken).unwrap();
    run(path, &["farm", "plan", "hair-lock", "--samples", "2", "-o", "clean", "--", "--small", "--size", "8x8"]);
    let folders = ["films", "pictures", "receipts", "logs"];
    let files = [
        "films/still.0-2.png",
        "films/still.0-2.film",
        "films/still.0-2.checkpoint",
        "pictures/hair-lock.exr",
        "pictures/hair-lock.png",
        "receipts/still.merge.json",
        "logs/still.0-2.log",
    ];
    let clean = std::fs::read(path.join("clean/plan.json")).unwrap();
    let limit = Duration::from_secs(60);
    let attack = |name: &str, make: &dyn Fn(&Path)| {
        std::fs::remove_dir_all(path.join("farm")).ok();
        std::fs::create_dir_all(path.join("farm").join(name).parent().unwrap()).unwrap();
        std::fs::write(path.join("farm/plan.json"), &clean).unwrap();
        make(&path.join("farm").join(name));
        let mut status = command(path, &["farm", "status", "farm"]).stdout(Stdio::null()).start().unwrap();
        assert!(status.ended_within(limit).is_some(), "{name}");
        let mut farm = start(path, &["farm", "run", "farm", "--retries", "0"]);
        assert!(farm.ended_within(limit).is_some(), "{name}");
        // A link instead of a checkpoint is removed.
        let code = farm.end().status.code();
        assert_eq!(code, Some(if name.ends_with("checkpoint") { 0 } else { 2 }), "{name}");
        std::fs::read_dir(path.join("victim")).unwrap().map(|e| std::fs::read(e.unwrap().path()).unwrap()).collect()
    };
    let untouched = || vec![b"# mine\n".to_vec()];
    std::fs::create_dir(path.join("victim")).unwrap();
    std::fs::write(path.join("victim/rc"), "# mine\n").unwrap();
    for name in folders {
        let found: Vec<_> = attack(name, &|at| symlink("../victim", at).unwrap());
        assert_eq!(found, untouched(), "{name}");
    }
    for name in files {
        for target in ["../../victim/rc", "../../victim/new"] {
            let found: Vec<_> = attack(name, &|at| symlink(target, at).unwrap());
            assert_eq!(found, untouched(), "{name}");
        }
        let pipe = |at: &Path| succeeds(Command::new("mkfifo").arg(at)).unwrap();
        let found: Vec<_> = attack(name, &pipe);
        assert_eq!(found, untouched(), "{name}");
    }
    // What a file says is one line, so it cannot look like a line of somebody else.
    let output = vellus(path, &["render", "evil.usda"]);
    let lines = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && lines.contains("touch PWNED"), "{lines}");
    assert!(lines.lines().all(|line| line.starts_with("error: ") || line.starts_with("hint: ")), "{lines}");
}

#[test]
fn foreign_films_and_changed_inputs_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    plan(path, "8", "4");
    run(path, &["farm", "run", "farm"]);
    assert_eq!(status(path), [3, 0, 0, 0]);
    // A checkpoint of another picture, and a damaged one, do not stop a task.
    std::fs::copy(path.join("farm/films/still.0-4.film"), path.join("farm/films/still.4-8.checkpoint")).unwrap();
    std::fs::write(path.join("farm/films/still.0-4.checkpoint"), "no film").unwrap();
    // The same folder is planned with another seed.
    let other = ["farm", "plan", "hair-lock", "--samples", "8", "--per-task", "4", "-o", "farm", "--", "--small"];
    run(path, &[&other[..], &["--size", "64x48"]].concat());
    assert_eq!(status(path), [0, 0, 0, 3]);
    ended_by(
        &vellus(path, &["farm", "task", "farm", "still.merge"]),
        75,
        &["task"],
        &["still.0-4", "of another picture", "run that task first"],
    );
    run(path, &["farm", "run", "farm"]);
    assert_eq!(status(path), [3, 0, 0, 0]);

    // The fibre changes after the plan was made.
    let fiber = path.join("fur.toml");
    std::fs::write(&fiber, "preset = \"cat\"\n").unwrap();
    run(path, &[&other[..], &["--size", "64x48", "--fiber", "fur.toml"]].concat());
    std::fs::write(&fiber, "preset = \"dog\"\n").unwrap();
    let args = ["farm", "run", "farm"];
    refused(path, &args, &["2 of 3 tasks failed, and 1 need", "of another picture", "inputs may have changed"]);
    refused(path, &["farm", "status", "nowhere"], &["plan.json"]);
    refused(path, &["farm", "plan", "hair-lock", "-o", "x", "--", "--spp", "3"], &["cannot contain the option --spp"]);
    refused(path, &["farm", "plan", "hair-lock", "-o", "x", "--", "--size", "0x3"], &["--size"]);
    refused(path, &["farm", "plan", "hair-lock", "--frames", "1-2", "-o", "x"], &["--frames are for files"]);
    refused(path, &["farm", "plan", "tables", "--frames", "1-2", "-o", "x"], &["are for scenes"]);
    assert!(!path.join("x").exists());
}

#[test]
fn plans_know_all_options_of_render() {
    let help = String::from_utf8(vellus(Path::new("."), &["render", "--help"]).stdout).unwrap();
    let names = help.lines().filter_map(|line| {
        let line = line.trim_start();
        (line.starts_with("--") || line.starts_with("-o,") || line.starts_with("-h,"))
            .then(|| line.split([' ', ',']).find(|word| word.starts_with("--")))
            .flatten()
    });
    let known = PICTURE_OPTIONS.into_iter().chain(PER_PLAN).collect::<HashSet<_>>();
    assert_eq!(names.collect::<HashSet<_>>(), known);
}

#[test]
fn experiments_run_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    run(path, &["farm", "plan", "experiments", "--quality", "smoke", "-o", "farm"]);
    for attempt in ["is done", "was done before"] {
        let output = vellus(path, &["farm", "task", "farm", "segment-error"]);
        assert!(String::from_utf8_lossy(&output.stdout).contains(attempt));
    }
    assert!(path.join("farm/experiments/segment-error/result.json").exists());
    ended_by(&vellus(path, &["farm", "task", "farm", "report"]), 75, &["task"], &["needs medulla-tables"]);
    refused(path, &["farm", "plan", "experiments", "--quality", "no/such", "-o", "x"], &["no/such"]);
}

/// Writes the job of a plan of a picture for an engine.
fn job(engine: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    plan(folder.path(), "96", "32");
    run(folder.path(), &["farm", "emit", "farm", "--to", engine]);
    folder
}

/// Whether an engine is there.
fn is_there(engine: &str, program: &str, args: &[&str]) -> bool {
    let there = Command::new(program).args(args).run().is_ok_and(|run| run.status.success() && !run.stdout.is_empty());
    let reason = || format!("{engine} is not there ({program} {})", args.join(" "));
    need("engines", there.then_some(()).ok_or_else(reason)).is_some()
}

/// Processes that render films of the plan in `folder`.
fn renders(folder: &Path) -> Vec<u32> {
    let films = folder.join("farm/films").display().to_string();
    let pids = std::fs::read_dir("/proc").unwrap();
    let pids = pids.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    let is_one = |pid: &u32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).into_owned();
        line.split('\0').nth(1) == Some("render") && line.contains(&films)
    };
    pids.filter(is_one).collect()
}

/// An engine starts slowly, and waits before it tries again.
const ENGINE: Duration = Duration::from_secs(600);

/// Runs an engine on a plan in which one film is there already, kills three of its renders, and compares the picture.
fn engine(folder: &Path, program: &str, args: &[&str]) {
    run(folder, &["farm", "task", "farm", "2"]);
    let log = std::fs::File::create(folder.join("engine.log")).unwrap();
    let mut engine = Command::new(program);
    engine.args(args).current_dir(folder).env("VELLUS", env!("CARGO_BIN_EXE_vellus"));
    let mut engine = engine.stdout(log.try_clone().unwrap()).stderr(log).start().unwrap();
    let (mut kills, start) = (0, Instant::now());
    while engine.ended_within(Duration::from_millis(20)).is_none() && start.elapsed() < ENGINE {
        if let Some(&pid) = renders(folder).first().filter(|_| kills < 3) {
            kills += u32::from(kill(pid, Signal::KILL));
        }
    }
    let ended = engine.end_within(Duration::ZERO).status;
    let text = std::fs::read_to_string(folder.join("engine.log")).unwrap();
    assert!(ended.success() && kills > 0, "{kills} kills: {text}");
    assert_eq!(status(folder), [4, 0, 0, 0], "{text}");
    assert_same(folder);
}

#[test]
fn open_jd_runs_a_plan() {
    if is_there("OpenJD", "openjd", &["--version"]) {
        let folder = job("openjd");
        let template = folder.path().join("farm/openjd.json");
        assert_eq!(succeeds(Command::new("openjd").arg("check").arg(template)), Ok(()));
        let program = concat!("Vellus=", env!("CARGO_BIN_EXE_vellus"));
        engine(folder.path(), "openjd", &["run", "farm/openjd.json", "-p", program]);
    }
}

#[test]
fn hyper_queue_runs_a_plan() {
    if is_there("HyperQueue", "python3", &["-c", "import hyperqueue; print(1)"]) {
        engine(job("hyperqueue").path(), "python3", &["farm/hq.py"]);
    }
}

#[test]
fn slurm_runs_a_plan() {
    if is_there("Slurm", "sinfo", &["--noheader", "--states=idle,mixed,allocated"]) {
        let wait =
            "sh farm/slurm.sh && while [ -n \"$(squeue --noheader --name=vellus-hair-lock)\" ]; do sleep 0.2; done";
        engine(job("slurm").path(), "sh", &["-c", wait]);
    }
}
