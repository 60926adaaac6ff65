//! The quality of an experiment.

use anyhow::{Error, bail};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// The quality of an experiment, which determines its amount of work.
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
    /// All qualities, from the lowest to the highest.
    pub const ALL: [Quality; 3] = [Quality::Smoke, Quality::Draft, Quality::Paper];

    /// Selects one of three values, for smoke, draft and paper.
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

impl FromStr for Quality {
    type Err = Error;

    /// Reads [`Quality::name`].
    fn from_str(name: &str) -> Result<Self, Error> {
        let Some(quality) = Quality::ALL.into_iter().find(|quality| quality.name() == name) else {
            bail!("there is no quality '{name}' (known: {})", Quality::ALL.map(Quality::name).join(", "));
        };
        Ok(quality)
    }
}
