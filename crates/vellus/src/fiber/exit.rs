//! How light that the medulla scattered leaves the fibre.

use crate::error::Error;
use std::fmt;
use std::str::FromStr;

/// How light that the medulla scattered leaves the fibre.
///
/// A simulated fibre behaves as [`Exit::Reflecting`], the default. [`Exit::Open`] is the paper's model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Exit {
    /// The cuticle does not reflect scattered light (Yan17 Sec. 4.3). The model then reflects up to 1.5 × the light of
    /// a simulated fibre.
    Open,
    /// The cuticle reflects scattered light from inside, in part totally. This light crosses the cortex and the
    /// medulla again, where it is absorbed or scattered, until it leaves (D17).
    #[default]
    Reflecting,
}

impl Exit {
    /// Both ways.
    pub const ALL: [Exit; 2] = [Exit::Open, Exit::Reflecting];

    /// The name in files and options.
    pub fn name(self) -> &'static str {
        match self {
            Exit::Open => "open",
            Exit::Reflecting => "reflecting",
        }
    }
}

impl fmt::Display for Exit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Exit {
    type Err = Error;

    /// Accepts the name alone, in lower case.
    fn from_str(name: &str) -> Result<Self, Error> {
        Exit::ALL
            .into_iter()
            .find(|exit| exit.name() == name)
            .ok_or_else(|| Error::UnknownExit { name: name.to_owned(), known: Exit::ALL.map(Exit::name).join(", ") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for exit in Exit::ALL {
            assert_eq!(exit.to_string().parse(), Ok(exit));
        }
        let error = "closed".parse::<Exit>().unwrap_err().to_string();
        assert_eq!(error, "unknown exit 'closed': known are open, reflecting");
    }
}
