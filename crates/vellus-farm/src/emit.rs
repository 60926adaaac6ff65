//! Jobs for other engines. Every task of a job is `vellus farm task DIR NUMBER`, so a job contains no other command.

use crate::work::picture_name;
use crate::{Error, Plan, Stage, Work};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;
use std::str::FromStr;

/// The largest array of a Slurm job, by default: `MaxArraySize` is 1001.
const SLURM_ARRAY: usize = 1000;

/// An engine that runs jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Open Job Description, the format of AWS Deadline Cloud: a template of the revision 2023-09.
    OpenJd,
    /// Slurm: a shell script that submits an array job for each stage.
    Slurm,
    /// HyperQueue: a script in Python that submits a job.
    HyperQueue,
}

impl Engine {
    /// All engines.
    pub const ALL: [Engine; 3] = [Engine::OpenJd, Engine::Slurm, Engine::HyperQueue];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Engine::OpenJd => "openjd",
            Engine::Slurm => "slurm",
            Engine::HyperQueue => "hyperqueue",
        }
    }

    fn file(self) -> &'static str {
        match self {
            Engine::OpenJd => "openjd.json",
            Engine::Slurm => "slurm.sh",
            Engine::HyperQueue => "hq.py",
        }
    }
}

impl FromStr for Engine {
    type Err = Error;

    /// Reads [`Engine::name`].
    fn from_str(name: &str) -> Result<Self, Error> {
        let known = || Engine::ALL.map(Engine::name).join(", ");
        let engine = Engine::ALL.into_iter().find(|engine| engine.name() == name);
        engine.ok_or_else(|| Error::Options(format!("there is no engine '{name}' (known: {})", known())))
    }
}

/// Writes the job of a plan for an engine to the folder of the plan, and returns its path. Each task is tried `retries`
/// times more if it is killed, or ends with exit code 75.
///
/// # Errors
/// [`Error::Write`].
pub fn emit(plan: &Plan, engine: Engine, retries: u32) -> Result<PathBuf, Error> {
    let text = match engine {
        Engine::OpenJd => format!("{:#}\n", open_jd(plan, retries)),
        Engine::Slurm => slurm(plan, retries),
        Engine::HyperQueue => HYPER_QUEUE.replace("RETRIES", &retries.to_string()),
    };
    let path = plan.dir().join(engine.file());
    vellus_io::write(&path, text.as_bytes()).map_err(|source| Error::Write { path: path.clone(), source })?;
    Ok(path)
}

fn job_name(plan: &Plan) -> String {
    match plan.work() {
        Work::Pictures(pictures) => format!("vellus-{}", picture_name(&pictures.scene)),
        Work::Experiments(_) => "vellus-experiments".to_owned(),
        Work::Tables(_) => "vellus-tables".to_owned(),
    }
}

fn open_jd(plan: &Plan, retries: u32) -> Value {
    let parameter = |name: &str, default: &str, what: &str| {
        let kind = "STRING";
        json!({ "name": name, "type": kind, "default": default, "description": what })
    };
    // The default of a PATH must be relative: to the folder of the template.
    let folder = json!({
        "name": "Plan", "type": "PATH", "objectType": "DIRECTORY", "dataFlow": "INOUT", "default": ".",
        "description": "The folder with plan.json",
    });
    let mut steps = Vec::new();
    for stage in plan.stages() {
        let Stage { name, tasks } = stage;
        let range = format!("{}-{}", tasks.start + 1, tasks.end);
        let mut step = json!({
            "name": name,
            "parameterSpace": { "taskParameterDefinitions": [{ "name": "Task", "type": "INT", "range": range }] },
            "script": { "actions": { "onRun": {
                "command": "{{Param.Vellus}}",
                "args": [
                    "farm", "task", "{{Param.Plan}}", "{{Task.Param.Task}}", "--retries", "{{Param.Retries}}",
                ],
                "cancelation": { "mode": "NOTIFY_THEN_TERMINATE" },
            } } },
        });
        if let Some(before) = steps.last().map(|step: &Value| step["name"].clone()) {
            step["dependencies"] = json!([{ "dependsOn": before }]);
        }
        steps.push(step);
    }
    json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": job_name(plan),
        "parameterDefinitions": [
            folder,
            parameter("Vellus", "vellus", "The command vellus"),
            parameter("Retries", &retries.to_string(), "How often a task is tried again"),
        ],
        "steps": steps,
    })
}

fn slurm(plan: &Plan, retries: u32) -> String {
    let mut text = format!(
        "#!/bin/sh\n\
         # Submits the plan in this folder to Slurm. Arguments are options for sbatch, such as --cpus-per-task=8.\n\
         # The variable VELLUS is the command vellus, if it is not on the PATH.\n\
         # Prints the numbers of the jobs. To repeat failed tasks, submit again: finished tasks are left out.\n\
         set -eu\n\
         CDPATH= cd -- \"$(dirname -- \"$0\")\"\n\
         export VELLUS=\"${{VELLUS:-vellus}}\"\n\
         mkdir -p logs\n\
         after=\"\"\n\n\
         # Usage: submit FIRST_TASK LAST_INDEX OPTION...\n\
         submit() {{\n  \
           first=$1 last=$2\n  \
           shift 2\n  \
           sbatch --parsable --job-name={} --array=0-\"$last\" --output=logs/slurm-%A-%a.log --requeue \\\n    \
             --kill-on-invalid-dep=yes ${{after:+--dependency=afterok$after}} \"$@\" \\\n    \
             --wrap=\"exec \\\"\\$VELLUS\\\" farm task . \\$((SLURM_ARRAY_TASK_ID + $first)) --retries {retries}\"\n\
         }}\n",
        job_name(plan)
    );
    for Stage { name, tasks } in plan.stages() {
        write!(text, "\n# {name}\njobs=\"\"\n").ok();
        for first in tasks.clone().step_by(SLURM_ARRAY) {
            let last = (tasks.end - first).min(SLURM_ARRAY) - 1;
            writeln!(text, "job=$(submit {} {last} \"$@\")\njobs=\"$jobs:${{job%%;*}}\"\necho \"$job\"", first + 1)
                .ok();
        }
        text += "after=\"$jobs\"\n";
    }
    text
}

/// The script for HyperQueue reads the plan, so it is the same for all plans.
const HYPER_QUEUE: &str = r#""""Runs the plan in this folder on HyperQueue.

Usage: python hq.py [SERVER_DIR]. Without SERVER_DIR, it starts a server and a worker on this machine.
The variable VELLUS is the command vellus, if it is not on the PATH. VELLUS_CORES is the number of cores of a task (1).
"""

import json
import os
import shutil
import sys
from pathlib import Path

from hyperqueue import Client, Job, LocalCluster
from hyperqueue.cluster import WorkerConfig
from hyperqueue.ffi.protocol import ResourceRequest

here = Path(__file__).resolve().parent


def main() -> int:
    vellus = shutil.which(os.environ.get("VELLUS", "vellus"))
    if vellus is None:
        print("the command vellus is not there: set VELLUS", file=sys.stderr)
        return 2
    cores = os.environ.get("VELLUS_CORES", "1")
    plan = json.loads((here / "plan.json").read_text())
    logs = here / "logs"
    logs.mkdir(exist_ok=True)
    # HyperQueue does not repeat a task that fails: `vellus farm task` does. The other tasks go on.
    job = Job(default_workdir=here, max_fails=None, name="vellus")
    tasks = {}
    for number, task in enumerate(plan["tasks"], 1):
        tasks[task["name"]] = job.program(
            [str(Path(vellus).resolve()), "farm", "task", str(here), str(number), "--retries", "RETRIES"],
            env={"RAYON_NUM_THREADS": cores},
            stdout=logs / f"hyperqueue-{number}.out",
            stderr=logs / f"hyperqueue-{number}.log",
            deps=[tasks[name] for name in task["needs"]],
            name=task["name"],
            resources=ResourceRequest(cpus=cores),
        )
    if len(sys.argv) > 1:
        return run(Client(Path(sys.argv[1])), job)
    with LocalCluster(worker_config=WorkerConfig()) as cluster:
        return run(cluster.client(), job)


def run(client: Client, job: Job) -> int:
    submitted = client.submit(job)
    if client.wait_for_jobs([submitted], raise_on_error=False):
        return 0
    for number, failed in client.get_failed_tasks(submitted).items():
        print(f"task {number + 1}: {failed.error}", file=sys.stderr)
    return 1


sys.exit(main())
"#;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Experiments, Pictures};
    use vellus_io::Digest;

    fn plan(frames: &str) -> (tempfile::TempDir, Plan) {
        let folder = tempfile::tempdir().unwrap();
        let scene = "a b;$(touch x)'.usda".to_owned();
        let pictures =
            Pictures { scene, frames: Some(frames.to_owned()), samples: 8, per_task: 4, ..Pictures::default() };
        let identity = |_: &[String]| Ok::<_, Error>(Digest::of(b"x"));
        let plan = Plan::new(folder.path(), Work::Pictures(pictures), identity).unwrap();
        (folder, plan)
    }

    #[test]
    fn stages_wait_for_each_other() {
        let (_folder, plan) = plan("1-3");
        let template = open_jd(&plan, 2);
        assert_eq!(template["name"], "vellus-a_b___touch_x__");
        let steps = template["steps"].as_array().unwrap();
        let range = |i: usize| &steps[i]["parameterSpace"]["taskParameterDefinitions"][0]["range"];
        assert_eq!((range(0), range(1)), (&json!("1-6"), &json!("7-9")));
        assert_eq!(steps[1]["dependencies"][0]["dependsOn"], "Render");
    }

    #[test]
    fn long_arrays_are_divided_and_names_are_safe() {
        let (_folder, plan) = plan("1-600");
        let script = slurm(&plan, 2);
        assert!(!script.contains("touch x") && script.contains("--job-name=vellus-a_b___touch_x__"));
        for part in ["submit 1 999 ", "submit 1001 199 ", "submit 1201 599 "] {
            assert!(script.contains(part), "{part}: {script}");
        }
    }

    #[test]
    fn every_engine_has_a_name_and_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let work = Experiments { quality: "smoke".to_owned(), names: vec!["lobes".to_owned()] };
        let identity = |_: &[String]| Err::<Digest, _>(Error::Stopped);
        let plan = Plan::new(folder.path(), Work::Experiments(work), identity).unwrap();
        for engine in Engine::ALL {
            assert_eq!(engine.name().parse::<Engine>().unwrap(), engine);
            let text = std::fs::read_to_string(emit(&plan, engine, 3).unwrap()).unwrap();
            assert!(!text.contains("RETRIES") && text.lines().all(|line| line.chars().count() <= 120), "{text}");
        }
        assert!("dask".parse::<Engine>().is_err());
    }
}
