//! Merging films of sample ranges.

use super::notes::take_layers;
use crate::error::Error;
use crate::film::checkpoint::Checkpoint;
use crate::film::picture::Notes;
use crate::film::{Film, Layer};
use std::ops::Range;

/// Adds films of sample ranges of one picture. The sum has the same bits as a film that was rendered at once.
///
/// Films may come in any order, and only two of them are in memory at once.
#[derive(Debug, Default)]
pub struct Merge {
    sum: Option<Checkpoint>,
    parts: Vec<Part>,
}

/// The samples of one film.
#[derive(Debug)]
struct Part {
    name: String,
    samples: Range<u64>,
    planned: u64,
}

/// A merged film.
#[derive(Debug)]
pub struct Merged {
    /// The sum of all films.
    pub film: Film,
    /// The notes of the film with the first samples.
    pub notes: Notes,
    /// The layers that its picture should have: those that were asked for when the films were rendered.
    pub layers: Vec<Layer>,
    /// The samples that are missing between the films, before the first, or after a film that was stopped early. One
    /// text for each gap; none if the picture is complete.
    pub gaps: Vec<String>,
}

impl Merge {
    /// Begins without films.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a film. Messages call it by its `name`, usually its path.
    ///
    /// # Errors
    /// [`Error::Merge`] if it is not of the same picture as the first film, or was rendered with adaptive sampling.
    pub fn add(&mut self, name: impl Into<String>, mut film: Checkpoint) -> Result<(), Error> {
        let name = name.into();
        let part = Part { name, samples: film.samples.clone(), planned: film.planned };
        if film.film.is_adaptive() {
            let what = "its tiles have different numbers of samples, because it was rendered until a goal of noise";
            return Err(Error::Merge(format!("{}: {what}", part.name)));
        }
        if let Some(sum) = &mut self.sum {
            if sum.identity != film.identity || !sum.film.fits(&film.film) {
                let (first, second) = (&self.parts[0].name, &part.name);
                return Err(Error::Merge(format!("{first} and {second} are not of the same picture")));
            }
            if film.samples.start < sum.samples.start {
                std::mem::swap(sum, &mut film);
            }
            sum.film.merge(&film.film);
        } else {
            self.sum = Some(film);
        }
        self.parts.push(part);
        Ok(())
    }

    /// The merged film.
    ///
    /// # Errors
    /// [`Error::Merge`] if there are no films, or if two of them have samples in common.
    pub fn finish(mut self) -> Result<Merged, Error> {
        let Some(Checkpoint { film, mut notes, .. }) = self.sum else {
            return Err(Error::Merge("no films".to_owned()));
        };
        let layers = take_layers(&mut notes).unwrap_or_else(|| Layer::ALL.to_vec());
        self.parts.sort_by_key(|part| part.samples.start);
        let mut gaps = Vec::new();
        let mut next = 0;
        for (i, Part { name, samples, planned }) in self.parts.iter().enumerate() {
            if samples.start < next {
                let before = &self.parts[i - 1].name;
                return Err(Error::Merge(format!("{before} and {name} have samples in common")));
            }
            if samples.start > next {
                gaps.push(format!("{next}..{} before {name}", samples.start));
            }
            // A gap before another film is found there.
            if samples.end < *planned && i + 1 == self.parts.len() {
                gaps.push(format!("{}..{planned} of {name}, which was stopped early", samples.end));
            }
            next = samples.end;
        }
        Ok(Merged { film, notes, layers, gaps })
    }
}
