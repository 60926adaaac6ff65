//! The file of a plan.

use crate::Error;
use crate::options::FOLDER;
use crate::work::{Task, Work};
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};
use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};
use vellus_io::Digest;

/// The name of a plan in its folder.
pub const PLAN_FILE: &str = "plan.json";

/// The version of the format.
pub const PLAN_VERSION: u32 = 2;

/// The largest file of a plan, in bytes.
const MAX_BYTES: u64 = 1 << 28;

/// What is read and written in the folder of a plan. The folder may have come from somebody else.
const CONTENTS: [&str; 10] =
    [PLAN_FILE, "films", "pictures", "receipts", "logs", "experiments", "tables", "openjd.json", "slurm.sh", "hq.py"];

/// Refuses links and special files in the folder of a plan.
///
/// # Errors
/// See [`vellus_io::confine`].
pub(crate) fn confine(dir: &Path) -> std::io::Result<()> {
    CONTENTS.iter().try_for_each(|name| vellus_io::confine(&dir.join(name)))
}

/// The version of a plan, without its other fields.
#[derive(Deserialize)]
struct Version {
    version: u32,
}

/// A plan: what is to be done, and the tasks for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    dir: PathBuf,
    file: PlanFile,
    stages: Vec<Stage>,
    index: HashMap<String, usize>,
}

/// The content of [`PLAN_FILE`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    version: u32,
    vellus: String,
    folder: PathBuf,
    work: Work,
    tasks: Vec<Task>,
}

/// Tasks of one kind. They need only tasks of earlier stages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stage {
    /// A name for people and engines: letters only.
    pub name: &'static str,
    /// Positions of its tasks in [`Plan::tasks`].
    pub tasks: Range<usize>,
}

impl Plan {
    /// Plans `work` in the folder `dir`. Relative paths in `work` are relative to the current folder.
    ///
    /// For each frame, `identity` returns the digest of the picture that a command renders: the arguments of `vellus`.
    /// Other work has no frames.
    ///
    /// # Errors
    /// [`Error::Options`] if something is out of range, [`Error::Read`] without a current folder, and the errors of
    /// `identity`.
    pub fn new<E: From<Error>>(
        dir: &Path,
        mut work: Work,
        mut identity: impl FnMut(&[String]) -> Result<Digest, E>,
    ) -> Result<Self, E> {
        if let Work::Pictures(pictures) = &mut work {
            crate::options::check(&pictures.scene, &pictures.options)?;
            let frames = pictures.frames()?;
            let digests = frames.iter().map(|frame| identity(&pictures.render(*frame, &(0..1), "identity")));
            pictures.identities = digests.map(|d| Ok(d?.to_string())).collect::<Result<_, E>>()?;
        }
        let folder = absolute(Path::new("."))?;
        let file = PlanFile {
            version: PLAN_VERSION,
            vellus: env!("CARGO_PKG_VERSION").to_owned(),
            folder,
            work,
            tasks: Vec::new(),
        };
        Ok(Plan::build(dir, file)?)
    }

    /// Derives the tasks.
    fn build(dir: &Path, mut file: PlanFile) -> Result<Self, Error> {
        let (mut tasks, mut stages) = (Vec::new(), Vec::new());
        for (name, part) in file.work.stages(&file.vellus)? {
            stages.push(Stage { name, tasks: tasks.len()..tasks.len() + part.len() });
            tasks.extend(part);
        }
        let index: HashMap<_, _> = tasks.iter().enumerate().map(|(i, task)| (task.name.clone(), i)).collect();
        let outputs: HashSet<_> = tasks.iter().flat_map(|task| &task.outputs).collect();
        if index.len() < tasks.len() || outputs.len() < tasks.iter().map(|task| task.outputs.len()).sum() {
            return Err(Error::Options("two tasks have the same name".to_owned()));
        }
        // Engines address tasks by their numbers.
        if let Some(task) = tasks.iter().find(|task| is_number(&task.name)) {
            return Err(Error::Options(format!("'{}' is a number, not the name of a task", task.name)));
        }
        file.tasks = tasks;
        Ok(Plan { dir: absolute(dir)?, file, stages, index })
    }

    /// Writes [`PLAN_FILE`], and returns its path.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn save(&self) -> Result<PathBuf, Error> {
        let path = self.dir.join(PLAN_FILE);
        confine(&self.dir).map_err(|source| Error::Write { path: path.clone(), source })?;
        let text = serde_json::to_string_pretty(&self.file).map_err(std::io::Error::other);
        let written = text.and_then(|text| vellus_io::write(&path, (text + "\n").as_bytes()));
        written.map_err(|source| Error::Write { path: path.clone(), source })?;
        Ok(path)
    }

    /// Reads the plan of a folder. The tasks are derived again from what the plan is for: a file whose tasks differ is
    /// refused. So no command runs that this version would not have written.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::Plan`] if it is damaged, of another version, or was changed.
    pub fn load(dir: &Path) -> Result<Self, Error> {
        let path = dir.join(PLAN_FILE);
        let read = confine(dir).and_then(|()| vellus_io::read_at_most(&path, MAX_BYTES));
        let bytes = read.map_err(|source| Error::Read { path: path.clone(), source })?;
        let wrong = |what: String| Error::Plan { path: path.clone(), what };
        let version: Version = serde_json::from_slice(&bytes).map_err(|e| wrong(e.to_string()))?;
        if version.version != PLAN_VERSION {
            return Err(wrong(format!("it is no plan of version {PLAN_VERSION}")));
        }
        let file: PlanFile = serde_json::from_slice(&bytes).map_err(|e| wrong(e.to_string()))?;
        // The digest of a picture covers the version of its pixels. Other results have no such version.
        if !matches!(file.work, Work::Pictures(_)) && file.vellus != env!("CARGO_PKG_VERSION") {
            return Err(wrong(format!("vellus {} planned it", vellus_io::visible(&file.vellus))));
        }
        let plan = Plan::build(dir, file.clone()).map_err(|e| wrong(e.to_string()))?;
        if plan.file != file {
            return Err(wrong("its tasks are not those of its work".to_owned()));
        }
        Ok(plan)
    }

    /// What the plan is for.
    pub fn work(&self) -> &Work {
        &self.file.work
    }

    /// The folder of the plan and of all outputs; absolute.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The folder in which the commands run: relative paths of the scene and of its options are relative to it.
    pub fn folder(&self) -> &Path {
        &self.file.folder
    }

    /// All tasks, stage by stage.
    pub fn tasks(&self) -> &[Task] {
        &self.file.tasks
    }

    /// The stages, in their order.
    pub fn stages(&self) -> &[Stage] {
        &self.stages
    }

    /// The position of a task in [`Plan::tasks`]: by its number from 1, or by its name. Digits are always a number.
    ///
    /// # Errors
    /// [`Error::NoTask`].
    pub fn find(&self, name: &str) -> Result<usize, Error> {
        let count = self.tasks().len();
        let number = || name.parse::<usize>().ok().filter(|n| (1..=count).contains(n)).map(|n| n - 1);
        let found = if is_number(name) { number() } else { self.index.get(name).copied() };
        found.ok_or_else(|| Error::NoTask {
            name: name.chars().take(80).collect(),
            count,
            example: self.tasks().first().map(|task| task.name.clone()).unwrap_or_default(),
        })
    }

    /// Positions of the tasks that a task needs.
    pub(crate) fn needs(&self, task: usize) -> impl Iterator<Item = usize> {
        self.tasks()[task].needs.iter().map(|name| self.index[name])
    }

    /// The arguments of a task's command.
    pub fn arguments(&self, task: &Task) -> Vec<OsString> {
        let argument = |word: &String| {
            let Some((before, after)) = word.split_once(FOLDER) else { return word.into() };
            let mut argument = OsString::from(before);
            argument.push(&self.dir);
            argument.push(after);
            argument
        };
        task.command.iter().map(argument).collect()
    }

    /// The path of an output of a task.
    pub fn output(&self, output: &str) -> PathBuf {
        self.dir.join(output)
    }
}

/// Whether a word consists of digits only. It is then the number of a task.
fn is_number(word: &str) -> bool {
    !word.is_empty() && word.bytes().all(|b| b.is_ascii_digit())
}

fn absolute(path: &Path) -> Result<PathBuf, Error> {
    // `components` removes the dot.
    let clean = |path: PathBuf| path.components().collect();
    std::path::absolute(path).map(clean).map_err(|source| Error::Read { path: path.to_owned(), source })
}
