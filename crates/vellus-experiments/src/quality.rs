//! How much work an experiment puts in.

use serde::{Deserialize, Serialize};

/// How much work an experiment puts in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// Seconds for all experiments. Checks that everything runs; no claim is judged.
    Smoke,
    /// About a quarter of an hour for all experiments on two cores.
    #[default]
    Draft,
    /// The quality of the paper: hours.
    Paper,
}

impl Quality {
    /// One of three values: for smoke, draft and paper.
    pub(crate) fn pick<T>(self, smoke: T, draft: T, paper: T) -> T {
        match self {
            Quality::Smoke => smoke,
            Quality::Draft => draft,
            Quality::Paper => paper,
        }
    }

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        self.pick("smoke", "draft", "paper")
    }
}
