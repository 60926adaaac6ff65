//! What a plan is for, and its tasks.

use crate::Error;
use crate::options::{FOLDER, check, divide};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::Path;
use vellus_io::DigestBuilder;
use vellus_render::MAX_SAMPLES;
use vellus_render::session::Frames;

/// The largest number of tasks of a plan.
const MAX_TASKS: u64 = 100_000;

/// The largest number of ranges of one frame: the command that merges them must have room for their names.
const MAX_RANGES: u64 = 4096;

/// What a plan is for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Work {
    /// The frames of an animation, or one picture.
    Pictures(Pictures),
    /// The experiments of the paper: a task for each, and a report.
    Experiments(Experiments),
    /// The tables of the medulla: one task, which keeps finished pieces.
    Tables(Tables),
}

/// Frames, each in ranges of samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pictures {
    /// The scene, as for `vellus render`.
    pub scene: String,
    /// Options of `vellus render`: see [`PICTURE_OPTIONS`](crate::PICTURE_OPTIONS).
    pub options: Vec<String>,
    /// The frames, as for [`Frames`]. `None` is one picture of a scene without time.
    pub frames: Option<String>,
    /// Samples a pixel; in [1, 2³¹ − 1].
    pub samples: u64,
    /// Samples a pixel of one task, at least 1. The last task of a frame may have fewer.
    pub per_task: u64,
    /// The digest of everything that determines the picture, for each frame: 64 hexadecimal digits.
    pub identities: Vec<String>,
}

/// Experiments of the paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiments {
    /// Their quality, as for `vellus experiment --quality`.
    pub quality: String,
    /// Their names.
    pub names: Vec<String>,
}

/// Tables of the medulla.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tables {
    /// Their quality, as for `vellus table build --quality`.
    pub quality: String,
}

/// One command and its results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// Its name, unique in the plan.
    pub name: String,
    /// The names of tasks whose results it reads.
    pub needs: Vec<String>,
    /// The digest of what determines its results. For a film, it is that of the film's picture.
    pub identity: String,
    /// The samples of its film; `None` if the result is no film.
    pub samples: Option<Range<u64>>,
    /// The command. At the beginning of an argument, `{dir}` stands for the folder of the plan.
    pub command: Vec<String>,
    /// The files that it writes, relative to the folder of the plan.
    pub outputs: Vec<String>,
}

/// Tasks that may run at the same time, and their name for people.
pub(crate) type Stages = Vec<(&'static str, Vec<Task>)>;

impl Work {
    /// The tasks, those that others need first. `vellus` is the version of the program.
    ///
    /// # Errors
    /// [`Error::Options`] if something is out of range.
    pub(crate) fn stages(&self, vellus: &str) -> Result<Stages, Error> {
        match self {
            Work::Pictures(pictures) => pictures.stages(),
            Work::Experiments(experiments) => experiments.stages(vellus),
            Work::Tables(tables) => tables.stages(vellus),
        }
    }
}

impl Pictures {
    /// Numbers of the frames, or one `None`.
    pub(crate) fn frames(&self) -> Result<Vec<Option<i32>>, Error> {
        let ranges = || self.samples.div_ceil(self.per_task);
        let whole = format!("in [1, {MAX_SAMPLES}]");
        if !(1..=MAX_SAMPLES).contains(&self.samples) || self.per_task == 0 {
            return Err(Error::Options(format!("samples and samples of a task must be {whole}")));
        }
        if ranges() > MAX_RANGES {
            let what = format!("{} ranges of samples: at most {MAX_RANGES} are merged at once", ranges());
            return Err(Error::Options(what));
        }
        let Some(text) = &self.frames else { return Ok(vec![None]) };
        let frames: Frames = text.parse().map_err(|error| Error::Options(format!("{error}")))?;
        let count = frames.count() * (ranges() + 1);
        if count > MAX_TASKS {
            return Err(Error::Options(format!("{count} tasks: a plan has at most {MAX_TASKS}")));
        }
        Ok(frames.iter().map(Some).collect())
    }

    /// The command that renders samples of a frame to `{dir}/films/NAME.film`.
    pub(crate) fn render(&self, frame: Option<i32>, samples: &Range<u64>, name: &str) -> Vec<String> {
        let mut command = vec!["render".to_owned(), self.scene.clone()];
        command.extend(divide(&self.options).0);
        command.extend(frame.map(|frame| format!("--frame={frame}")));
        command.push(format!("--samples={}..{}", samples.start, samples.end));
        // A PNG is cheaper than an OpenEXR file, which nobody needs of a part.
        command.extend(["--resume".to_owned(), format!("--output={FOLDER}/films/{name}.png")]);
        command
    }

    /// The ranges of samples.
    fn ranges(&self) -> impl Iterator<Item = Range<u64>> {
        let ends = |start: u64| start..(start + self.per_task).min(self.samples);
        (0..self.samples.div_ceil(self.per_task)).map(move |i| ends(i * self.per_task))
    }

    fn stages(&self) -> Result<Stages, Error> {
        check(&self.scene, &self.options)?;
        let frames = self.frames()?;
        if self.identities.len() != frames.len() {
            let (digests, frames) = (self.identities.len(), frames.len());
            return Err(Error::Options(format!("{digests} digests for {frames} frames")));
        }
        let (mut films, mut merges) = (Vec::new(), Vec::new());
        for (frame, identity) in frames.iter().zip(&self.identities) {
            let first = films.len();
            let label = label(*frame);
            for samples in self.ranges() {
                let name = format!("{label}.{}-{}", samples.start, samples.end);
                films.push(Task {
                    command: self.render(*frame, &samples, &name),
                    outputs: vec![format!("films/{name}.film")],
                    needs: Vec::new(),
                    identity: identity.clone(),
                    samples: Some(samples),
                    name,
                });
            }
            merges.push(self.merge(*frame, format!("{label}.merge"), identity, &films[first..]));
        }
        Ok(vec![("Render", films), ("Merge", merges)])
    }

    fn merge(&self, frame: Option<i32>, name: String, identity: &str, films: &[Task]) -> Task {
        let picture = format!("pictures/{}.exr", picture_name(&self.scene));
        let file = frame.map_or_else(|| picture.clone(), |frame| file_name(&picture, frame));
        let mut command = vec!["merge".to_owned()];
        command.extend(films.iter().map(|film| format!("{FOLDER}/{}", film.outputs[0])));
        command.push(format!("--output={FOLDER}/{file}"));
        command.extend(divide(&self.options).1);
        let outputs = vec![file.clone(), Path::new(&file).with_extension("png").to_string_lossy().into_owned()];
        let needs = films.iter().map(|film| film.name.clone()).collect();
        Task { name, needs, identity: digest(identity, &command), samples: None, command, outputs }
    }
}

fn label(frame: Option<i32>) -> String {
    frame.map_or_else(
        || "still".to_owned(),
        |frame| format!("{}{:04}", if frame < 0 { "-" } else { "" }, frame.unsigned_abs()),
    )
}

fn file_name(picture: &str, frame: i32) -> String {
    Frames::file(Path::new(picture), frame).to_string_lossy().replace('\\', "/")
}

/// The name of a scene's file without folder and extension, in letters that are safe everywhere.
pub(crate) fn picture_name(scene: &str) -> String {
    let stem = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' };
    let name: String = stem.chars().take(100).map(safe).collect();
    if name.trim_matches('-').is_empty() { "picture".to_owned() } else { name }
}

/// The digest of a task that is no film: of what it reads and of its command.
fn digest(inputs: &str, command: &[String]) -> String {
    command
        .iter()
        .fold(DigestBuilder::new().field("inputs", inputs), |b, word| b.field("word", word))
        .finish()
        .to_string()
}

/// A word that can be the name of an experiment or of a quality.
fn word(text: &str) -> Result<&str, Error> {
    let safe = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let fits = !text.is_empty() && !text.starts_with('-') && text.len() <= 64 && text.chars().all(safe);
    if fits { Ok(text) } else { Err(Error::Options(format!("'{text}' is not the name of an experiment or quality"))) }
}

impl Experiments {
    fn stages(&self, vellus: &str) -> Result<Stages, Error> {
        let quality = format!("--quality={}", word(&self.quality)?);
        let task = |name: &str, experiment: &str, needs: Vec<String>, output: String| {
            let out = format!("--out={FOLDER}/experiments");
            let command = vec!["experiment".to_owned(), experiment.to_owned(), quality.clone(), out];
            let identity = digest(vellus, &command);
            Task { name: name.to_owned(), needs, identity, samples: None, command, outputs: vec![output] }
        };
        let mut tasks = Vec::new();
        for name in &self.names {
            tasks.push(task(word(name)?, name, Vec::new(), format!("experiments/{name}/result.json")));
        }
        // Finished experiments are kept: this only writes the page.
        let report = task("report", "all", self.names.clone(), "experiments/index.html".to_owned());
        Ok(vec![("Experiments", tasks), ("Report", vec![report])])
    }
}

impl Tables {
    fn stages(&self, vellus: &str) -> Result<Stages, Error> {
        let outputs = ["tables/medulla.vellus", "tables/exit.vellus"].map(str::to_owned).to_vec();
        let mut command = vec!["table".to_owned(), "build".to_owned(), format!("--quality={}", word(&self.quality)?)];
        command.extend([format!("--out={FOLDER}/{}", outputs[0]), format!("--exits={FOLDER}/{}", outputs[1])]);
        let (name, identity) = ("tables".to_owned(), digest(vellus, &command));
        let task = Task { name, needs: Vec::new(), identity, samples: None, command, outputs };
        Ok(vec![("Tables", vec![task])])
    }
}
