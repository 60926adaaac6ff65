//! Two versions of the settings, A and B, and the steps of undo and redo.

use crate::request::{Coat, Groom};
use glam::Vec3;
use std::sync::Arc;
use std::time::{Duration, Instant};
use vellus_render_models::Method;
use vellus_scene::Look;

/// The most steps of undo.
const STEPS: usize = 200;

/// Changes of one control are one step if there is less time between them: a slider sends many.
const ONE_STEP: Duration = Duration::from_secs(1);

/// What a page can change of the scene. Camera and picture are not part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Version {
    pub looks: Vec<(Look, Coat)>,
    pub model: Method,
    /// Rotation of all lights about the up axis, degrees.
    pub azimuth: f32,
    /// Factor of the emission, and translation, of each light.
    pub changes: Vec<(f32, Vec3)>,
    pub groom: Groom,
}

/// Versions A and B, and which of them is shown.
#[derive(Clone, Debug)]
struct Pair {
    versions: [Arc<Version>; 2],
    shown: usize,
}

/// A step that shows another version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Back to the state before the last step.
    Undo,
    /// Forward again.
    Redo,
    /// Shows version A (0) or B (1).
    Show(usize),
    /// Copies the version that is shown to the other one.
    Copy,
}

/// Both versions over time.
#[derive(Clone, Debug)]
pub struct History {
    now: Pair,
    past: Vec<Pair>,
    future: Vec<Pair>,
    /// The control of the last change, and its time.
    last: Option<(String, Instant)>,
}

impl History {
    /// Both versions are the same at first.
    pub fn new(version: Version) -> Self {
        let version = Arc::new(version);
        let now = Pair { versions: [Arc::clone(&version), version], shown: 0 };
        History { now, past: Vec::new(), future: Vec::new(), last: None }
    }

    /// Notes that a control has changed the version that is shown.
    pub fn record(&mut self, control: String, version: &Version, at: Instant) {
        if *self.now.versions[self.now.shown] == *version {
            return;
        }
        let same = |(name, time): &(String, Instant)| *name == control && at.duration_since(*time) < ONE_STEP;
        if self.last.as_ref().is_some_and(same) {
            self.future.clear();
        } else {
            self.push();
        }
        self.last = Some((control, at));
        self.now.versions[self.now.shown] = Arc::new(version.clone());
    }

    fn push(&mut self) {
        if self.past.len() == STEPS {
            self.past.remove(0);
        }
        self.past.push(self.now.clone());
        self.future.clear();
        self.last = None;
    }

    /// Makes a step. Returns the version to show.
    ///
    /// # Errors
    /// A message if there is nothing to undo or redo, or no such version.
    pub fn step(&mut self, step: Step) -> Result<Arc<Version>, String> {
        match step {
            Step::Undo => {
                let before = self.past.pop().ok_or("there is nothing to undo")?;
                self.future.push(std::mem::replace(&mut self.now, before));
            }
            Step::Redo => {
                let after = self.future.pop().ok_or("there is nothing to redo")?;
                self.past.push(std::mem::replace(&mut self.now, after));
            }
            Step::Show(index) if index > 1 => return Err("there are two versions: 0 and 1".to_owned()),
            // To look at the other version is no change, so it is no step of undo.
            Step::Show(index) => self.now.shown = index,
            Step::Copy => {
                self.push();
                self.now.versions[1 - self.now.shown] = Arc::clone(&self.now.versions[self.now.shown]);
            }
        }
        self.last = None;
        Ok(Arc::clone(&self.now.versions[self.now.shown]))
    }

    /// 0 for version A, 1 for version B.
    pub fn shown(&self) -> usize {
        self.now.shown
    }

    /// The version that is not shown.
    pub fn other(&self) -> &Version {
        &self.now.versions[1 - self.now.shown]
    }

    /// Whether there is something to undo, and to redo.
    pub fn can(&self) -> [bool; 2] {
        [!self.past.is_empty(), !self.future.is_empty()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_models::ModelKind;

    fn version(azimuth: f32) -> Version {
        let model = Method::from(ModelKind::Vellus);
        Version { looks: vec![], model, azimuth, changes: vec![], groom: Groom::default() }
    }

    #[test]
    fn changes_of_one_control_are_one_step() {
        let start = Instant::now();
        let mut history = History::new(version(0.0));
        let mut change = |control: &str, azimuth: f32, seconds: f32| {
            history.record(control.to_owned(), &version(azimuth), start + Duration::from_secs_f32(seconds));
        };
        change("azimuth", 1.0, 0.0);
        change("azimuth", 2.0, 0.5);
        change("azimuth", 3.0, 1.2);
        change("azimuth", 4.0, 3.0);
        change("groom", 5.0, 3.1);
        change("groom", 5.0, 9.0);
        let undone: Vec<f32> = (0..3).map(|_| history.step(Step::Undo).unwrap().azimuth).collect();
        assert_eq!(undone, [4.0, 3.0, 0.0]);
        assert_eq!((history.step(Step::Undo).is_err(), history.can()), (true, [false, true]));
        assert_eq!(history.step(Step::Redo).unwrap().azimuth, 3.0);
        // A change after undo ends the way forward.
        history.record("azimuth".to_owned(), &version(9.0), start + Duration::from_secs(20));
        assert_eq!(history.can(), [true, false]);
        assert!(history.step(Step::Redo).is_err());
    }

    #[test]
    fn two_versions_keep_their_settings() {
        let start = Instant::now();
        let mut history = History::new(version(0.0));
        history.record("azimuth".to_owned(), &version(1.0), start);
        assert_eq!(history.step(Step::Show(1)).unwrap().azimuth, 0.0);
        // The same control of another version is another step.
        history.record("azimuth".to_owned(), &version(2.0), start);
        assert_eq!((history.step(Step::Show(0)).unwrap().azimuth, history.other().azimuth), (1.0, 2.0));
        history.step(Step::Copy).unwrap();
        assert_eq!(history.step(Step::Show(1)).unwrap().azimuth, 1.0);
        history.step(Step::Undo).unwrap();
        assert_eq!((history.shown(), history.other().azimuth), (0, 2.0));
        assert_eq!(history.step(Step::Undo).unwrap().azimuth, 0.0);
        assert_eq!(history.shown(), 1);
        assert!(history.step(Step::Show(2)).is_err());
    }

    #[test]
    fn the_number_of_steps_is_bounded() {
        let mut history = History::new(version(0.0));
        for i in 1..=2 * STEPS {
            history.record(format!("{i}"), &version(i as f32), Instant::now());
        }
        let undone = std::iter::from_fn(|| history.step(Step::Undo).ok()).count();
        assert_eq!(undone, STEPS);
    }
}
