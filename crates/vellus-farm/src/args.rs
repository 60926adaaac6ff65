//! The options of `vellus farm`.

use crate::{Engine, Error, Experiments, Pictures, Plan, Runner, Tables, Work, emit};
use std::num::NonZero;
use std::path::PathBuf;
use vellus_io::{Digest, Progress, parse};
use vellus_render::MAX_SAMPLES;

/// Many tasks, on this machine or on many.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum Command {
    /// Plan tasks: ranges of samples of the frames of a scene, and their merges. Or: all experiments, or the tables.
    Plan(PlanArgs),
    /// Run all tasks of a plan on this machine. Finished tasks are left out.
    Run(RunArgs),
    /// Run one task of a plan. Engines call this.
    Task(TaskArgs),
    /// Show which tasks are finished, from their files, whoever ran them.
    Status(StatusArgs),
    /// Write the job of a plan for another engine, into the plan's folder.
    Emit(EmitArgs),
}

impl Command {
    /// Runs the command, and returns what to print.
    ///
    /// `program` is the command `vellus`. `experiments` are the names of all experiments. For `identity`, see
    /// [`Plan::new`]. `progress` receives the progress of [`Command::Run`], and stops it and [`Command::Task`].
    ///
    /// # Errors
    /// The errors of the plan, and those of `identity`. [`Error::Stopped`] if `progress` cancelled.
    pub fn run<E: From<Error>>(
        &self,
        program: PathBuf,
        experiments: impl Iterator<Item = &'static str>,
        identity: impl FnMut(&[String]) -> Result<Digest, E>,
        progress: &dyn Progress,
    ) -> Result<String, E> {
        Ok(match self {
            Command::Plan(args) => {
                let plan = args.plan(experiments, identity)?;
                format!("{} tasks in {}\n", plan.tasks().len(), plan.dir().display())
            }
            Command::Run(args) => args.run(program, progress)?,
            Command::Task(args) => args.run(program, progress)?,
            Command::Status(args) => args.text()?,
            Command::Emit(args) => {
                let path = emit(&Plan::load(&args.dir)?, args.to, args.retries)?;
                format!("wrote {}\n", path.display())
            }
        })
    }
}

/// Options of `vellus farm plan`.
#[derive(Clone, Debug, clap::Args)]
pub struct PlanArgs {
    /// A scene, as for `vellus render`; `experiments` for all experiments of the paper; `tables` for the tables of the
    /// medulla.
    #[arg(value_name = "SCENE|experiments|tables")]
    scene: String,
    /// Frames of a file: A to B, or every S-th of them. Default: one picture.
    #[arg(long, allow_hyphen_values = true, value_name = "A-B[xS]")]
    frames: Option<String>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64, value_parser = parse::whole::<u64>(1..=MAX_SAMPLES), value_name = "N")]
    samples: u64,
    /// Samples a pixel of one task. Default: all, so that a task is a frame.
    #[arg(long, value_parser = parse::whole::<u64>(1..=MAX_SAMPLES), value_name = "N")]
    per_task: Option<u64>,
    /// Quality of experiments (smoke, draft, paper) or tables (smoke, shipping). Default: the best.
    #[arg(long, value_name = "NAME")]
    quality: Option<String>,
    /// Folder for the plan and all results.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Options of `vellus render` for the picture, after `--`, e.g. -- --size 1920x1080 --light sky --denoise.
    #[arg(last = true, allow_hyphen_values = true, value_name = "OPTION")]
    options: Vec<String>,
}

impl PlanArgs {
    /// Makes the plan and writes it.
    fn plan<E: From<Error>>(
        &self,
        experiments: impl Iterator<Item = &'static str>,
        identity: impl FnMut(&[String]) -> Result<Digest, E>,
    ) -> Result<Plan, E> {
        let quality = |best: &str| self.quality.clone().unwrap_or_else(|| best.to_owned());
        let work = match self.scene.as_str() {
            "experiments" => Work::Experiments(Experiments {
                quality: quality("paper"),
                names: experiments.map(str::to_owned).collect(),
            }),
            "tables" => Work::Tables(Tables { quality: quality("shipping") }),
            scene => Work::Pictures(Pictures {
                scene: scene.to_owned(),
                options: self.options.clone(),
                frames: self.frames.clone(),
                samples: self.samples,
                per_task: self.per_task.unwrap_or(self.samples),
                identities: Vec::new(),
            }),
        };
        let is_scene = matches!(work, Work::Pictures(_));
        if is_scene && self.quality.is_some() {
            return Err(Error::Options("--quality is for experiments and tables".to_owned()).into());
        }
        if !is_scene && (self.frames.is_some() || self.per_task.is_some() || !self.options.is_empty()) {
            let what = "--frames, --per-task and options of `vellus render` are for scenes";
            return Err(Error::Options(what.to_owned()).into());
        }
        let plan = Plan::new(&self.output, work, identity)?;
        plan.save()?;
        Ok(plan)
    }
}

/// Options of `vellus farm run`.
#[derive(Clone, Debug, clap::Args)]
pub struct RunArgs {
    /// Folder of the plan.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Tasks at once. They share the processor's threads. Each needs the memory of one render.
    #[arg(long, default_value_t = 2, value_parser = parse::whole::<usize>(1..=1024), value_name = "N")]
    jobs: usize,
    /// How often a task is tried again if it is killed, or ends with exit code 75.
    #[arg(long, default_value_t = 3, value_parser = parse::whole::<u32>(0..=1_000_000), value_name = "N")]
    retries: u32,
}

impl RunArgs {
    fn run(&self, program: PathBuf, progress: &dyn Progress) -> Result<String, Error> {
        let plan = Plan::load(&self.dir)?;
        let jobs = NonZero::new(self.jobs).unwrap_or(NonZero::<usize>::MIN);
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        // A choice of the user stays.
        let threads = std::env::var_os("RAYON_NUM_THREADS").is_none().then_some((cores / jobs).max(1));
        let runner = Runner { plan: &plan, program, retries: self.retries, threads, log: true, progress };
        let totals = runner.run_all(jobs)?;
        Ok(format!("{} tasks done, {} were done before, {} retries\n", totals.done, totals.kept, totals.retries))
    }
}

/// Options of `vellus farm task`.
#[derive(Clone, Debug, clap::Args)]
pub struct TaskArgs {
    /// Folder of the plan.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// The task: its number from 1, or its name in plan.json, such as 1001.0-64 or 1001.merge.
    #[arg(value_name = "TASK", allow_hyphen_values = true)]
    task: String,
    /// How often it is tried again if it is killed, or ends with exit code 75.
    #[arg(long, default_value_t = 3, value_parser = parse::whole::<u32>(0..=1_000_000), value_name = "N")]
    retries: u32,
}

impl TaskArgs {
    fn run(&self, program: PathBuf, progress: &dyn Progress) -> Result<String, Error> {
        let plan = Plan::load(&self.dir)?;
        let runner = Runner { plan: &plan, program, retries: self.retries, threads: None, log: false, progress };
        let ran = runner.run_one(&self.task)?;
        let name = &plan.tasks()[plan.find(&self.task)?].name;
        Ok(match ran.attempts {
            0 => format!("task {name} was done before\n"),
            1 => format!("task {name} is done\n"),
            n => format!("task {name} is done, attempt {n}\n"),
        })
    }
}

/// Options of `vellus farm status`.
#[derive(Clone, Debug, clap::Args)]
pub struct StatusArgs {
    /// Folder of the plan.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Print JSON, with every task.
    #[arg(long)]
    json: bool,
}

impl StatusArgs {
    fn text(&self) -> Result<String, Error> {
        let status = Plan::load(&self.dir)?.status();
        Ok(if self.json { status.json() } else { format!("{status}\n") })
    }
}

/// Options of `vellus farm emit`.
#[derive(Clone, Debug, clap::Args)]
pub struct EmitArgs {
    /// Folder of the plan.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// The engine.
    #[arg(long, value_parser = clap::builder::TypedValueParser::try_map(
        clap::builder::PossibleValuesParser::new(Engine::ALL.map(Engine::name)),
        |name: String| name.parse::<Engine>(),
    ), value_name = "ENGINE")]
    to: Engine,
    /// How often a task is tried again if it is killed, or ends with exit code 75.
    #[arg(long, default_value_t = 3, value_parser = parse::whole::<u32>(0..=1_000_000), value_name = "N")]
    retries: u32,
}
