//! Runs the attacks in turn until the time is over, and prints a table of the findings.

use crate::attacks::{self, Attack};
use crate::dice::Dice;
use crate::trial::{Bench, Stop, Trial};
use anyhow::{Context, Result, bail};
use clap::Parser;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// The columns of the table. MB is the peak memory of a child.
const HEADER: &str = "attack       inputs  kills      s       MB  findings";
/// The number of findings of one kind whose files are kept.
const EXAMPLES: usize = 3;
/// Larger files of a case are not kept; in bytes.
const LARGEST_KEPT: u64 = 16 << 20;

/// Attack the command `vellus` with signals, full disks, damaged files and invalid input.
///
/// Each case depends only on the seed, the attack and its number, except for the times of signals. Exit code 1: there
/// are findings. A child is limited to 2 GiB of address space, 10 s of processor time and 60 s.
#[derive(Parser)]
#[command(name = "cargo xtask torture")]
struct Cli {
    /// Seed of all choices.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Duration, e.g. 60s, 10m.
    #[arg(long, default_value = "60s", value_parser = duration, value_name = "TIME")]
    time: Duration,
    /// Run only this attack: kill, ranges, damage, disk, files, nonsense, fibres, structure or viewer.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Run only this case of that attack.
    #[arg(long, value_name = "N", requires = "only")]
    case: Option<u64>,
    /// Where to keep the files of findings.
    #[arg(long, default_value = "target/torture", value_name = "DIR")]
    keep: PathBuf,
    /// The command. Default: the one built beside this program.
    #[arg(long, value_name = "PATH")]
    vellus: Option<PathBuf>,
}

fn duration(text: &str) -> Result<Duration, String> {
    let split = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let unit = match &text[split..] {
        "s" | "" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => f64::NAN,
    };
    let seconds = text[..split].parse().unwrap_or(f64::NAN) * unit;
    if (0.0..1e6).contains(&seconds) { Ok(Duration::from_secs_f64(seconds)) } else { Err("e.g. 60s or 10m".to_owned()) }
}

/// The results of an attack.
struct Score {
    attack: Box<dyn Attack>,
    spent: Duration,
    tried: u64,
    kills: u64,
    peak_kb: u64,
    /// How often each kind was found, and the numbers of the first cases.
    findings: BTreeMap<String, (u64, Vec<u64>, String)>,
}

/// Runs the program.
pub fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(e) => {
            eprintln!("error: {e:#}");
            ExitCode::from(2)
        }
    }
}

/// Runs the attacks. True if there are no findings.
fn run(cli: &Cli) -> Result<bool> {
    let beside = std::env::current_exe()?.with_file_name("vellus");
    let vellus = cli.vellus.clone().unwrap_or(beside);
    let vellus = vellus.canonicalize().with_context(|| format!("no command at {}", vellus.display()))?;
    let mut scores: Vec<_> = attacks::all().into_iter().map(Score::new).collect();
    if let Some(only) = &cli.only {
        let names: Vec<_> = scores.iter().map(|score| score.attack.name()).collect();
        if !names.contains(&only.as_str()) {
            bail!("no attack '{only}': there are {}", names.join(", "));
        }
        scores.retain(|score| score.attack.name() == only);
    }
    // A folder in memory if there is one, because the files need not survive a crash.
    let mut work = tempfile::Builder::new();
    work.prefix("vellus-torture-");
    let work = work.tempdir_in("/dev/shm").or_else(|_| work.tempdir())?;
    let began = Instant::now();
    // Panics of the library in this process are findings, not messages.
    std::panic::set_hook(Box::new(|_| {}));
    eprintln!("{HEADER}");
    let count = scores.len();
    for (i, score) in scores.iter_mut().enumerate() {
        // The remaining time is divided equally among the remaining attacks.
        let left = cli.time.saturating_sub(began.elapsed());
        let bench = Bench { vellus: vellus.clone(), deadline: Instant::now() + left / (count - i) as u32 };
        cases(cli, &bench, score, work.path())?;
        eprintln!("{}", score.line());
    }
    drop(std::panic::take_hook());
    report(cli, &scores, began.elapsed());
    Ok(scores.iter().all(|score| score.findings.is_empty()))
}

/// Runs cases of one attack until its time is over.
fn cases(cli: &Cli, bench: &Bench, score: &mut Score, work: &Path) -> Result<()> {
    let began = Instant::now();
    for case in cli.case.unwrap_or(0).. {
        let over = attempt(cli, bench, score, work, case)?;
        if over || cli.case.is_some() || Instant::now() >= bench.deadline {
            break;
        }
    }
    score.spent = began.elapsed();
    Ok(())
}

/// Runs one case. True if the time is over.
fn attempt(cli: &Cli, bench: &Bench, score: &mut Score, work: &Path, case: u64) -> Result<bool> {
    let name = score.attack.name();
    let folder = work.join(format!("{name}-{case}"));
    let dice = Dice::new(cli.seed, name, case);
    let mut trial = match Trial::new(bench, dice, folder.clone()) {
        Ok(trial) => trial,
        Err(stop) => return broken(stop),
    };
    let result = score.attack.case(&mut trial);
    score.tried += trial.tried;
    score.kills += trial.kills;
    score.peak_kb = score.peak_kb.max(trial.peak_kb);
    let mut keep = false;
    for finding in &trial.findings {
        let first = finding.detail.lines().next().unwrap_or("").to_owned();
        let entry = score.findings.entry(finding.kind.clone()).or_insert((0, Vec::new(), first));
        entry.0 += 1;
        if entry.1.len() < EXAMPLES && !entry.1.contains(&case) {
            entry.1.push(case);
            keep = true;
        }
    }
    if keep {
        let kept = cli.keep.join(format!("{name}-{}-{case}", cli.seed));
        copy(&folder, &kept).with_context(|| format!("cannot keep the files in {}", kept.display()))?;
        let again = format!("# cargo xtask torture --seed {} --only {name} --case {case}\n", cli.seed);
        std::fs::write(kept.join("commands.sh"), again + &trial.script)?;
    }
    std::fs::remove_dir_all(&folder).ok();
    match result {
        Ok(()) => Ok(false),
        Err(stop) => broken(stop).with_context(|| format!("{name}, case {case}")),
    }
}

fn broken(stop: Stop) -> Result<bool> {
    match stop {
        Stop::TimeIsOver => Ok(true),
        Stop::Broken(why) => bail!("{why}"),
    }
}

/// Copies a folder: plain files that are not too large, folders and links.
fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let (kind, target) = (entry.file_type()?, to.join(entry.file_name()));
        if kind.is_dir() {
            copy(&entry.path(), &target)?;
        } else if kind.is_file() && entry.metadata()?.len() <= LARGEST_KEPT {
            std::fs::copy(entry.path(), target)?;
        } else if kind.is_symlink() {
            // One may exist from an earlier run.
            std::fs::remove_file(&target).ok();
            std::os::unix::fs::symlink(std::fs::read_link(entry.path())?, target)?;
        }
    }
    Ok(())
}

fn report(cli: &Cli, scores: &[Score], took: Duration) {
    println!("seed {}, {:.0} s", cli.seed, took.as_secs_f64());
    println!("{HEADER}");
    for score in scores {
        println!("{}", score.line());
    }
    for score in scores {
        let name = score.attack.name();
        if let Some(what) = score.attack.left_out() {
            vellus_testing::need("mount", Err::<(), _>(format!("{name} left out {what}")));
        }
        for (kind, (count, cases, detail)) in &score.findings {
            println!("\n{name}: {kind} ({count} times)\n    {detail:.300}");
            for case in cases {
                let kept = cli.keep.join(format!("{name}-{}-{case}", cli.seed));
                println!(
                    "    cargo xtask torture --seed {} --only {name} --case {case}    # {}",
                    cli.seed,
                    kept.join("commands.sh").display()
                );
            }
        }
    }
}

impl Score {
    /// A line of the table.
    fn line(&self) -> String {
        let (name, spent, mb) = (self.attack.name(), self.spent.as_secs(), self.peak_kb / 1024);
        let findings: u64 = self.findings.values().map(|(count, ..)| count).sum();
        format!("{name:10} {:>8} {:>6} {spent:>6} {mb:>8} {findings:>9}", self.tried, self.kills)
    }

    fn new(attack: Box<dyn Attack>) -> Self {
        Score { attack, spent: Duration::ZERO, tried: 0, kills: 0, peak_kb: 0, findings: BTreeMap::new() }
    }
}
