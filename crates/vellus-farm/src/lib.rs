//! Plans of many tasks for the command `vellus`, for one machine or many.
//!
//! A [`Plan`] has a task for each range of samples of each frame, and a task for each frame that merges its ranges. It
//! is a file, `plan.json`, in the folder of all outputs. [`Plan::status`] finds out from the files what is finished.
//! [`Runner`] runs tasks: it leaves out what is finished, and tries again what may pass. [`emit()`] writes the job for
//! another engine, whose tasks are all `vellus farm task`.
//!
//! A task may be killed at any moment, run twice, or run on two machines at once: the result has the same bits. Films
//! carry the digest of all inputs of their picture and a checksum. Other results have a receipt with both.
//!
//! ```
//! use vellus_farm::{Error, Pictures, Plan, State, Work};
//! use vellus_io::Digest;
//! # fn main() -> Result<(), Error> {
//! # let folder = tempfile::tempdir().unwrap();
//! # let folder = folder.path();
//! let pictures = Pictures {
//!     scene: "cat.usda".to_owned(),
//!     frames: Some("1-2".to_owned()),
//!     samples: 128,
//!     per_task: 64,
//!     ..Pictures::default()
//! };
//! // The identity of a picture, from the command line that renders a part of it.
//! let identity = |command: &[String]| Ok::<_, Error>(Digest::of(command.join(" ").as_bytes()));
//! let plan = Plan::new(folder, Work::Pictures(pictures), identity)?;
//! plan.save()?;
//! let names: Vec<_> = plan.tasks().iter().map(|task| task.name.as_str()).collect();
//! assert_eq!(names, ["0001.0-64", "0001.64-128", "0002.0-64", "0002.64-128", "0001.merge", "0002.merge"]);
//! assert!(Plan::load(folder)?.status().tasks.iter().all(|task| task.state == State::Missing));
//! # Ok(()) }
//! ```
#![warn(clippy::print_stdout)]

#[cfg(feature = "clap")]
mod args;
mod child;
mod emit;
mod error;
mod local;
mod options;
mod plan;
mod receipt;
mod runner;
mod status;
mod work;

#[cfg(feature = "clap")]
pub use args::{Command, EmitArgs, PlanArgs, RunArgs, StatusArgs, TaskArgs};
pub use child::begin;
pub use emit::{Engine, emit};
pub use error::Error;
pub use local::Totals;
pub use options::{PER_PLAN, PICTURE_OPTIONS};
pub use plan::{PLAN_FILE, PLAN_VERSION, Plan, Stage};
pub use runner::{Ran, Runner};
pub use status::{State, Status, TaskStatus};
pub use work::{Experiments, Pictures, Tables, Task, Work};
