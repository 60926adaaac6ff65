//! What is finished, from the files.

use crate::{Plan, Task, receipt};
use serde::Serialize;
use std::fmt;
use std::fmt::Write;
use vellus_render::Error as RenderError;
use vellus_render::session::read_film;

/// The state of a task's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// It is complete, of the right inputs, and its checksum is right.
    Done,
    /// It is not there, or not all of it.
    Missing,
    /// It does not have its checksum.
    Damaged,
    /// It is of other inputs.
    Foreign,
}

impl State {
    /// All states.
    pub const ALL: [State; 4] = [State::Done, State::Missing, State::Damaged, State::Foreign];

    /// Its name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            State::Done => "done",
            State::Missing => "missing",
            State::Damaged => "damaged",
            State::Foreign => "foreign",
        }
    }
}

/// The state of one task.
#[derive(Clone, Debug, Serialize)]
pub struct TaskStatus {
    /// The name of the task.
    pub name: String,
    /// Its state.
    pub state: State,
    /// The file and its problem; empty if there is none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub why: String,
}

impl TaskStatus {
    /// The state, with the reason if there is one.
    pub fn what(&self) -> String {
        if self.why.is_empty() { self.state.name().to_owned() } else { format!("{} ({})", self.state.name(), self.why) }
    }
}

/// The state of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct Status {
    /// All tasks, in the order of [`Plan::tasks`].
    pub tasks: Vec<TaskStatus>,
    #[serde(skip)]
    stages: Vec<crate::Stage>,
}

impl Plan {
    /// The state of one task, from its files only.
    pub fn state(&self, task: &Task) -> TaskStatus {
        let (state, why) = match &task.samples {
            Some(_) => self.film_state(task),
            None => receipt::state(self, task),
        };
        TaskStatus { name: task.name.clone(), state, why }
    }

    fn film_state(&self, task: &Task) -> (State, String) {
        let path = self.output(&task.outputs[0]);
        if !path.exists() {
            return (State::Missing, String::new());
        }
        match read_film(&path) {
            Ok(film) if film.identity.to_string() != task.identity => {
                (State::Foreign, format!("{} is of another picture", path.display()))
            }
            Ok(film) if Some(&film.samples) == task.samples.as_ref() => (State::Done, String::new()),
            Ok(film) => {
                let samples =
                    format!("{} has the samples {}..{}", path.display(), film.samples.start, film.samples.end);
                (State::Missing, samples)
            }
            Err(error @ RenderError::Film { .. }) => (State::Damaged, error.to_string()),
            Err(error) => (State::Missing, error.to_string()),
        }
    }

    /// The state of all tasks. Reads all results, to check their checksums.
    ///
    /// The results of a task are not needed any more if all tasks that need them are done: films may be deleted once
    /// their picture is there.
    pub fn status(&self) -> Status {
        let mut tasks: Vec<TaskStatus> = self.tasks().iter().map(|task| self.state(task)).collect();
        let mut open = vec![false; tasks.len()];
        let mut needed = vec![false; tasks.len()];
        // Tasks come after those that they need.
        for i in (0..tasks.len()).rev() {
            if needed[i] && !open[i] && tasks[i].state == State::Missing {
                tasks[i].state = State::Done;
            }
            for need in self.needs(i) {
                needed[need] = true;
                open[need] |= tasks[i].state != State::Done;
            }
        }
        Status { tasks, stages: self.stages().to_vec() }
    }
}

impl Status {
    /// The number of tasks in a state.
    pub fn count(&self, state: State) -> usize {
        self.tasks.iter().filter(|task| task.state == state).count()
    }

    /// The number of tasks in each state, the total, and all tasks, as JSON.
    pub fn json(&self) -> String {
        let mut value = serde_json::json!({ "total": self.tasks.len() });
        for state in State::ALL {
            value[state.name()] = self.count(state).into();
        }
        value["tasks"] = serde_json::to_value(&self.tasks).unwrap_or_default();
        format!("{value:#}\n")
    }
}

impl fmt::Display for Status {
    /// A table with a row for each stage, and a line for each damaged or foreign result.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut text = format!("{:12}{:>8}", "", "tasks");
        State::ALL.iter().try_for_each(|state| write!(text, "{:>10}", state.name()))?;
        for stage in &self.stages {
            let tasks = &self.tasks[stage.tasks.clone()];
            write!(text, "\n{:12}{:8}", stage.name, tasks.len())?;
            for state in State::ALL {
                write!(text, "{:10}", tasks.iter().filter(|task| task.state == state).count())?;
            }
        }
        for task in self.tasks.iter().filter(|task| !task.why.is_empty()) {
            write!(text, "\n{}: {}", task.name, task.what())?;
        }
        f.write_str(&text)
    }
}
