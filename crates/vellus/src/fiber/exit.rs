//! How light that the medulla scattered leaves the fibre.

use crate::error::Error;
use crate::fiber::parameter::Parameter;
use std::fmt;
use std::str::FromStr;

/// How light that the medulla scattered leaves the fibre.
///
/// A simulated fibre behaves as [`ScatterExit::Reflecting`], the default. [`ScatterExit::Open`] is the paper's model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ScatterExit {
    /// The cuticle does not reflect scattered light (Yan17 Sec. 4.3). The model then reflects up to 1.5 × the light of
    /// a simulated fibre.
    Open,
    /// The cuticle reflects scattered light from inside, in part totally. This light crosses the cortex and the
    /// medulla again, where it is absorbed or scattered, until it leaves (D17).
    #[default]
    Reflecting,
}

impl ScatterExit {
    /// Both ways.
    pub const ALL: [ScatterExit; 2] = [ScatterExit::Open, ScatterExit::Reflecting];

    /// Their names, in the order of [`ScatterExit::ALL`].
    pub(super) const NAMES: [&str; 2] = ["open", "reflecting"];

    /// The name in files and options.
    pub fn name(self) -> &'static str {
        ScatterExit::NAMES[self as usize]
    }
}

impl fmt::Display for ScatterExit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ScatterExit {
    type Err = Error;

    /// Accepts the name alone, in lower case.
    fn from_str(name: &str) -> Result<Self, Error> {
        Parameter::Exit.value_of(name).map(|value| ScatterExit::ALL[value as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for exit in ScatterExit::ALL {
            assert_eq!(exit.to_string().parse(), Ok(exit));
        }
        let error = "closed".parse::<ScatterExit>().unwrap_err().to_string();
        assert_eq!(error, "unknown exit 'closed': known are open, reflecting");
    }
}
