//! A picture in parts. Every division must give the same pixels, and parts of different pictures must be an error.

use super::{Attack, picture, same};
use crate::material::{LEANING, lit_by, png};
use crate::picture::Picture;
use crate::trial::{Stop, Trial};
use ::png::{BitDepth, ColorType};

/// Samples of the complete picture.
const SAMPLES: usize = 24;

const SCENES: [&str; 4] = [
    "hair-lock --small --size 24x16 --layers all",
    "lean.usda --size 24x16",
    "lit.usda --size 24x16 --filter box",
    "lean.usda --frame 2 --size 30x20 --crop 3,4,20,9 --mode far --seed 7",
];

#[derive(Default)]
pub struct Ranges {
    whole: [Option<Picture>; SCENES.len()],
}

impl Attack for Ranges {
    fn name(&self) -> &'static str {
        "ranges"
    }

    fn case(&mut self, trial: &mut Trial) -> Result<(), Stop> {
        let which = trial.dice.number(0..SCENES.len());
        inputs(trial)?;
        if self.whole[which].is_none() {
            let call = trial.vellus("render --float -o whole.exr --spp").arg(SAMPLES.to_string()).args(SCENES[which]);
            if !trial.prepare(&call)? {
                return Ok(());
            }
            self.whole[which] = picture(trial, &trial.at("whole.exr"), "an undisturbed run");
        }
        let Some(whole) = &self.whole[which] else { return Ok(()) };
        trial.tried += 1;
        divide(trial, SCENES[which], whole)
    }
}

/// Writes the scenes to the case's folder, and copies of them to another.
fn inputs(trial: &Trial) -> Result<(), Stop> {
    std::fs::create_dir_all(trial.at("copy"))?;
    for folder in [trial.folder.clone(), trial.at("copy")] {
        std::fs::write(folder.join("lean.usda"), LEANING)?;
        std::fs::write(folder.join("lit.usda"), lit_by("sky.png"))?;
        std::fs::write(folder.join("sky.png"), png(ColorType::Rgb, BitDepth::Eight, 90)?)?;
    }
    Ok(())
}

fn divide(trial: &mut Trial, scene: &str, whole: &Picture) -> Result<(), Stop> {
    // Cuts between 0 and the number of samples.
    let mut cuts: Vec<usize> = (1..SAMPLES).collect();
    trial.dice.shuffle(&mut cuts);
    cuts.truncate(trial.dice.number(1..6));
    cuts.extend([0, SAMPLES]);
    cuts.sort_unstable();
    let (mut films, mut respelled) = (Vec::new(), false);
    for (i, ends) in cuts.windows(2).enumerate() {
        // The same file by another path, and a copy of it.
        let spelled = match trial.dice.number(0..8) {
            _ if scene.starts_with("hair-lock") => scene.to_owned(),
            0 => format!("./{scene}"),
            1 => format!("copy/{scene}"),
            _ => scene.to_owned(),
        };
        respelled |= spelled != scene;
        let threads = trial.dice.number(1..6).to_string();
        if !render(trial, &spelled, ends[0]..ends[1], &format!("part{i}"), &["--threads", &threads])? {
            return Ok(());
        }
        films.push(format!("part{i}.film"));
    }
    trial.dice.shuffle(&mut films);
    merged(
        trial,
        &films,
        whole,
        if respelled { "parts of one scene by several paths" } else { "parts in random order" },
    )?;

    let mut others = films.clone();
    match trial.dice.number(0..6) {
        0 if films.len() > 2 => {
            let middle = films.iter().position(|film| film == "part1.film").unwrap_or(0);
            others.remove(middle);
            refused(trial, &others, "merge with a gap")
        }
        1 => {
            others.push(trial.dice.pick(&films).clone());
            refused(trial, &others, "merge with a part twice")
        }
        2 => {
            let start = trial.dice.number(0..SAMPLES - 1);
            render(trial, scene, start..start + 2, "over", &[])?;
            others.push("over.film".to_owned());
            refused(trial, &others, "merge with an overlap")
        }
        3 => foreign(trial, scene, others),
        4 => changed(trial, scene, others),
        _ => {
            let name = trial.dice.pick(&films).clone();
            let mut bytes = std::fs::read(trial.at(&name))?;
            crate::mutate::damage(&mut bytes, &mut trial.dice);
            std::fs::write(trial.at(&name), bytes)?;
            let outcome = merge(trial, &films)?;
            let what = "merge with a damaged part";
            if trial.ended_with(&outcome, &[0, 2], what) && outcome.code == Some(0) {
                same(trial, &trial.at("merged.exr"), whole, what);
            }
            Ok(())
        }
    }
}

/// Renders samples of a scene to a film.
fn render(
    trial: &mut Trial,
    scene: &str,
    samples: std::ops::Range<usize>,
    name: &str,
    more: &[&str],
) -> Result<bool, Stop> {
    let samples = format!("{}..{}", samples.start, samples.end);
    let call = trial.vellus("render --float -o").arg(format!("{name}.exr")).arg("--samples").arg(samples).args(scene);
    let call = more.iter().fold(call, |call, arg| call.arg(arg));
    trial.prepare(&call)
}

fn merge(trial: &mut Trial, films: &[String]) -> Result<crate::child::Outcome, Stop> {
    std::fs::remove_file(trial.at("merged.exr")).ok();
    let call = films.iter().fold(trial.vellus("merge --float -o merged.exr"), |call, film| call.arg(film));
    trial.run(&call)
}

fn merged(trial: &mut Trial, films: &[String], whole: &Picture, what: &str) -> Result<(), Stop> {
    let outcome = merge(trial, films)?;
    if trial.ended_with(&outcome, &[0], &format!("merge of {what}")) {
        same(trial, &trial.at("merged.exr"), whole, what);
    }
    Ok(())
}

fn refused(trial: &mut Trial, films: &[String], what: &str) -> Result<(), Stop> {
    let outcome = merge(trial, films)?;
    trial.ended_with(&outcome, &[2], what);
    Ok(())
}

/// Merges a part of a picture with another option.
fn foreign(trial: &mut Trial, scene: &str, mut films: Vec<String>) -> Result<(), Stop> {
    let more: &[&str] = match trial.dice.number(0..5) {
        0 => &["--seed", "99"],
        1 => &["--max-depth", "2"],
        2 => &["--model", "kajiya-kay1989"],
        3 => &["--lod", "auto"],
        _ => &["--min-pixel-width", "0.7"],
    };
    let scene = if more[0] == "--seed" { scene.replace(" --seed 7", "") } else { scene.to_owned() };
    render(trial, &scene, SAMPLES..SAMPLES + 3, "foreign", more)?;
    films.push("foreign.film".to_owned());
    refused(trial, &films, &format!("merge with a part of another {}", &more[0][2..]))
}

/// Merges a part of the same files after a change of one file.
fn changed(trial: &mut Trial, scene: &str, mut films: Vec<String>) -> Result<(), Stop> {
    let what = if scene.starts_with("lit") {
        // Only the texture changes.
        std::fs::write(trial.at("sky.png"), png(ColorType::Rgb, BitDepth::Eight, 200)?)?;
        "merge with a part rendered after a texture changed"
    } else if scene.starts_with("lean") {
        std::fs::write(trial.at("lean.usda"), LEANING.replace("intensity = 40", "intensity = 41"))?;
        "merge with a part rendered after the scene changed"
    } else {
        return Ok(());
    };
    render(trial, scene, SAMPLES..SAMPLES + 3, "changed", &[])?;
    films.push("changed.film".to_owned());
    refused(trial, &films, what)
}
