//! Damaged films, checkpoints and finished frames. The command must reject or ignore them.

use super::{Attack, picture};
use crate::material::LEANING;
use crate::mutate;
use crate::picture::Picture;
use crate::trial::{Stop, Trial};
use std::path::Path;
use std::time::{Duration, SystemTime};

const SCENE: &str = "hair-lock --small --size 16x12 --layers beauty,alpha";
/// Samples of the picture that is resumed.
const GOAL: &str = "--spp 600";
const FRAMES: &str = "render lean.usda --size 16x12 --spp 4 --frames 1-2 --float --resume -o f.exr";
const FRAME_FILES: [&str; 4] = ["f.0001.exr", "f.0001.png", "f.0002.exr", "f.0002.png"];

/// Undamaged files, and their pictures.
struct Whole {
    film: Vec<u8>,
    merged: Picture,
    checkpoint: Vec<u8>,
    resumed: Picture,
    frames: Vec<(Vec<u8>, Picture)>,
}

#[derive(Default)]
pub struct Damage {
    whole: Option<Whole>,
}

impl Attack for Damage {
    fn name(&self) -> &'static str {
        "damage"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        if self.whole.is_none() {
            self.whole = prepare(trial)?;
        }
        let Some(whole) = &self.whole else { return Ok(()) };
        trial.tried += 1;
        match trial.dice.number(0..3) {
            0 => film(trial, whole),
            1 => checkpoint(trial, whole),
            _ => frame(trial, whole),
        }
    }
}

fn prepare(trial: &mut Trial) -> Result<Option<Whole>, Stop> {
    scene(trial)?;
    let lines = [
        format!("render {SCENE} --samples 0..4 -o a.exr"),
        "merge a.film --float -o merged.exr".to_owned(),
        format!("render {SCENE} {GOAL} --float -o whole.exr"),
        // Ends when the time is over, and leaves the checkpoint that it was asked for.
        format!("render {SCENE} {GOAL} --time 0.01s --checkpoint 60s --float -o c.exr"),
        FRAMES.to_owned(),
    ];
    for line in lines {
        if !trial.prepare(&trial.vellus(&line))? {
            return Ok(None);
        }
    }
    let read = |trial: &mut Trial, name: &str| picture(trial, &trial.at(name), "an undisturbed run");
    let (Some(merged), Some(resumed)) = (read(trial, "merged.exr"), read(trial, "whole.exr")) else { return Ok(None) };
    let mut frames = Vec::new();
    for name in FRAME_FILES {
        let Some(picture) = read(trial, name) else { return Ok(None) };
        frames.push((std::fs::read(trial.at(name))?, picture));
    }
    let checkpoint = trial.at("c.checkpoint");
    if !checkpoint.exists() {
        trial.finding("no checkpoint after --time ended the run", "");
        return Ok(None);
    }
    Ok(Some(Whole {
        film: std::fs::read(trial.at("a.film"))?,
        merged,
        checkpoint: std::fs::read(checkpoint)?,
        resumed,
        frames,
    }))
}

/// Writes the scene of the frames, with the modification time that it has in all cases.
fn scene(trial: &Trial) -> Result<(), Stop> {
    std::fs::write(trial.at("lean.usda"), LEANING)?;
    let file = std::fs::File::options().write(true).open(trial.at("lean.usda"))?;
    Ok(file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(1_700_000_000))?)
}

/// Writes a damaged copy. The text describes the damage.
fn damaged(trial: &mut Trial, whole: &[u8], path: &Path) -> Result<&'static str, Stop> {
    let mut bytes = whole.to_vec();
    let mut kind = "";
    while bytes == whole {
        kind = mutate::damage(&mut bytes, &mut trial.dice);
    }
    std::fs::write(path, bytes)?;
    Ok(kind)
}

/// Exit code 0 requires the right pixels.
fn right(trial: &mut Trial, path: &Path, expected: &Picture, what: &str, damage: &str) {
    match Picture::read(path) {
        Err(e) => {
            trial.finding(format!("{what}: exit code 0, and a file that cannot be read"), format!("{damage}: {e}"));
        }
        Ok(found) => {
            if let Some(difference) = found.difference(expected) {
                trial.finding(format!("{what}: exit code 0 with wrong pixels"), format!("{damage}: {difference}"));
            }
        }
    }
}

fn film(trial: &mut Trial, whole: &Whole) -> Result<(), Stop> {
    std::fs::remove_file(trial.at("merged.exr")).ok();
    let kind = damaged(trial, &whole.film, &trial.at("a.film"))?;
    let what = "merge of a damaged film";
    let outcome = trial.run(&trial.vellus("merge a.film --float -o merged.exr"))?;
    if trial.ended_with(&outcome, &[0, 2], what) && outcome.code == Some(0) {
        right(trial, &trial.at("merged.exr"), &whole.merged, what, kind);
    }
    Ok(())
}

fn checkpoint(trial: &mut Trial, whole: &Whole) -> Result<(), Stop> {
    std::fs::remove_file(trial.at("c.exr")).ok();
    let kind = damaged(trial, &whole.checkpoint, &trial.at("c.checkpoint"))?;
    let what = "--resume from a damaged checkpoint";
    let outcome = trial.run(&trial.vellus(&format!("render {SCENE} {GOAL} --float --resume -o c.exr")))?;
    if trial.ended_with(&outcome, &[0, 2], what) && outcome.code == Some(0) {
        right(trial, &trial.at("c.exr"), &whole.resumed, what, kind);
    }
    Ok(())
}

/// Damages one finished file of an animation. It must be rendered again, or the run must be refused.
fn frame(trial: &mut Trial, whole: &Whole) -> Result<(), Stop> {
    scene(trial)?;
    for (name, (bytes, _)) in FRAME_FILES.iter().zip(&whole.frames) {
        std::fs::write(trial.at(name), bytes)?;
    }
    let which = trial.dice.number(0..FRAME_FILES.len());
    let kind = damaged(trial, &whole.frames[which].0, &trial.at(FRAME_FILES[which]))?;
    let extension = if FRAME_FILES[which].ends_with("exr") { "exr" } else { "png" };
    let what = format!("--frames --resume with a damaged .{extension}");
    let outcome = trial.run(&trial.vellus(FRAMES))?;
    if trial.ended_with(&outcome, &[0, 2], &what) && outcome.code == Some(0) {
        for (name, (_, expected)) in FRAME_FILES.iter().zip(&whole.frames) {
            right(trial, &trial.at(name), expected, &what, kind);
        }
    }
    Ok(())
}
