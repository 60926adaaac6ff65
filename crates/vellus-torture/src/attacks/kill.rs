//! Signals at random moments. A resumed run must end with the same pixels as an undisturbed run.

use super::{Attack, picture, same, temporary_files};
use crate::child::When;
use crate::material::{LEANING, STRAIGHT};
use crate::picture::Picture;
use crate::trial::{Stop, Trial};
use rustix::process::Signal;
use std::time::{Duration, Instant};

/// A render to interrupt: a few tenths of a second on one core.
struct Job {
    args: &'static str,
    /// The pictures that it writes; for a film, the picture merged from it.
    pictures: &'static [&'static str],
    film: bool,
}

const JOBS: [Job; 6] = [
    Job {
        args: "hair-lock --small --size 40x30 --spp 400 --layers beauty,alpha,variance",
        pictures: &["k.exr", "k.png"],
        film: false,
    },
    Job { args: "lean.usda --size 40x30 --spp 1000 --float", pictures: &["k.exr", "k.png"], film: false },
    Job {
        args: "lean.usda --size 24x18 --spp 1000 --frames 1-3 --layers beauty,id",
        pictures: &["k.0001.exr", "k.0001.png", "k.0002.exr", "k.0002.png", "k.0003.exr", "k.0003.png"],
        film: false,
    },
    Job { args: "hair-lock --small --size 40x30 --samples 100..500", pictures: &["merged.exr"], film: true },
    Job { args: "lean.hair --width 0.1 --size 40x30 --spp 2000", pictures: &["k.png"], film: false },
    Job { args: "cat --small --size 24x16 --spp 200 --layers all", pictures: &["k.exr", "k.png"], film: false },
];

/// The result of an undisturbed run.
struct Undisturbed {
    pictures: Vec<Picture>,
    took: Duration,
}

#[derive(Default)]
pub struct Kill {
    undisturbed: [Option<Undisturbed>; JOBS.len()],
}

impl Attack for Kill {
    fn name(&self) -> &'static str {
        "kill"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        // The last one grows a scene for a second first, and nothing can be interrupted there.
        let which = if trial.dice.chance(0.05) { JOBS.len() - 1 } else { trial.dice.number(0..JOBS.len() - 1) };
        let job = &JOBS[which];
        std::fs::write(trial.at("lean.usda"), LEANING)?;
        std::fs::write(trial.at("straight.usda"), STRAIGHT)?;
        if !trial.prepare(&trial.vellus("groom convert straight.usda -o lean.hair"))? {
            return Ok(());
        }
        if self.undisturbed[which].is_none() {
            self.undisturbed[which] = undisturbed(trial, job)?;
        }
        let Some(expected) = &self.undisturbed[which] else { return Ok(()) };
        disturb(trial, job, expected)
    }
}

/// Merges the film to a picture, if the job renders a film.
fn merge(trial: &mut Trial, job: &Job) -> Result<bool, Stop> {
    Ok(!job.film || trial.prepare(&trial.vellus("merge k.film --allow-gaps --float -o merged.exr"))?)
}

fn undisturbed(trial: &mut Trial, job: &Job) -> Result<Option<Undisturbed>, Stop> {
    let began = Instant::now();
    if !trial.prepare(&trial.vellus("render -o k.exr").args(job.args))? {
        return Ok(None);
    }
    let took = began.elapsed();
    if !merge(trial, job)? {
        return Ok(None);
    }
    let mut pictures = Vec::new();
    for name in job.pictures {
        let Some(picture) = picture(trial, &trial.at(name), "an undisturbed run") else { return Ok(None) };
        pictures.push(picture);
    }
    for entry in std::fs::read_dir(&trial.folder)? {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("k.") || name == "merged.exr") {
            std::fs::remove_file(path)?;
        }
    }
    Ok(Some(Undisturbed { pictures, took }))
}

fn disturb(trial: &mut Trial, job: &Job, expected: &Undisturbed) -> Result<(), Stop> {
    trial.tried += 1;
    let signals = [Signal::KILL, Signal::KILL, Signal::TERM, Signal::INT, Signal::HUP];
    let most = trial.dice.number(1..7);
    let checkpoint = *trial.dice.pick(&["0s", "0.05s", "0.2s", "1s"]);
    for round in 0.. {
        let mut call = trial.vellus("render -o k.exr --resume --checkpoint").arg(checkpoint).args(job.args);
        // Most of the work may be done already, so later signals come sooner.
        let latest = expected.took.as_secs_f64() * if round == 0 { 1.0 } else { 0.6 };
        let signal = *trial.dice.pick(&signals);
        let after = Duration::from_secs_f64(trial.dice.within(0.0, latest));
        call.signal = (round < most).then_some((When::After(after), signal));
        let outcome = trial.run(&call)?;
        if !outcome.signalled || outcome.code == Some(0) {
            if !trial.ended_with(&outcome, &[0], "a resumed run") {
                return Ok(());
            }
            if !trial.at("k.checkpoint").exists() && (!outcome.signalled || complete(trial, job)) {
                break;
            }
            if !outcome.signalled {
                trial.finding("a complete run leaves a checkpoint", outcome.stderr);
                break;
            }
            trial.finding(format!("exit code 0 after {}", name(signal)), outcome.stderr);
            continue;
        }
        trial.kills += 1;
        if signal != Signal::KILL {
            // A run without a message ended before it watched for signals. It had nothing to keep.
            let early = outcome.signal == Some(signal.as_raw()) && outcome.stderr.is_empty();
            let code = 128 + signal.as_raw();
            if !early && trial.ended_with(&outcome, &[code], &format!("after {}", name(signal))) {
                named(trial, &outcome.stderr);
            }
            if !temporary_files(&trial.folder)?.is_empty() {
                trial.finding(format!("a temporary file is left after {}", name(signal)), "");
            }
        }
        // A killed program cannot clean up. Its temporary files would hide those that the next signal leaves.
        for path in temporary_files(&trial.folder)? {
            std::fs::remove_file(path)?;
        }
        for name in job.pictures {
            if trial.at(name).exists() && !job.film {
                picture(trial, &trial.at(name), "half a file is left after a signal");
            }
        }
        // An interrupted run of --samples leaves its checkpoint. Its samples do not start at 0, which is a gap.
        if job.film && trial.at("k.checkpoint").exists() {
            let outcome = trial.run(&trial.vellus("merge k.checkpoint --allow-gaps --float -o part.exr"))?;
            trial.ended_with(&outcome, &[0], "merge of the checkpoint of an interrupted run");
        }
    }
    if merge(trial, job)? {
        for (name, expected) in job.pictures.iter().zip(&expected.pictures) {
            same(trial, &trial.at(name), expected, "resumed after signals");
        }
    }
    Ok(())
}

/// Whether all outputs exist. A signal after the end of the work changes nothing.
fn complete(trial: &Trial, job: &Job) -> bool {
    if job.film { trial.at("k.film").exists() } else { job.pictures.iter().all(|name| trial.at(name).exists()) }
}

/// The message of an interrupted run must name the kept files, or state that no file was changed.
fn named(trial: &mut Trial, stderr: &str) {
    let kept = ["k.checkpoint", "k.film"].iter().any(|name| trial.at(name).exists());
    let unchanged = stderr.contains("no file was changed");
    if kept && !unchanged && !["k.checkpoint", "k.film"].iter().any(|name| stderr.contains(name)) {
        trial.finding("the message of an interrupted run does not name the kept files", stderr);
    }
}

fn name(signal: Signal) -> &'static str {
    match signal {
        Signal::TERM => "SIGTERM",
        Signal::INT => "SIGINT",
        Signal::HUP => "SIGHUP",
        _ => "SIGKILL",
    }
}
