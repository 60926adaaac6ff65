//! Runs a whole plan on this machine.

use crate::{Error, Ran, Runner, State};
use std::num::NonZero;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// What became of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Tasks that were finished before.
    pub kept: usize,
    /// Tasks that were finished now.
    pub done: usize,
    /// Attempts beyond the first of each task.
    pub retries: u32,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Slot {
    Waiting,
    Running,
    Done,
    Failed,
}

/// What the workers share.
struct Board {
    slots: Vec<Slot>,
    totals: Totals,
    errors: Vec<Error>,
    stopped: bool,
}

struct Shared {
    board: Mutex<Board>,
    changed: Condvar,
    /// Tasks that were not done at the start.
    total: usize,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Board> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Runner<'_> {
    /// Runs all tasks that are not done, at most `jobs` at once. A task that fails does not stop the others. `progress`
    /// receives the share of the tasks that were not done.
    ///
    /// # Errors
    /// [`Error::Stopped`] if `progress` cancelled. [`Error::Several`] if a task failed.
    pub fn run_all(&self, jobs: NonZero<usize>) -> Result<Totals, Error> {
        let slot = |state| if state == State::Done { Slot::Done } else { Slot::Waiting };
        let slots: Vec<_> = self.plan.status().tasks.iter().map(|task| slot(task.state)).collect();
        let total = slots.iter().filter(|slot| **slot == Slot::Waiting).count();
        let totals = Totals { kept: slots.len() - total, ..Totals::default() };
        let board = Mutex::new(Board { slots, totals, errors: Vec::new(), stopped: false });
        let shared = Shared { board, changed: Condvar::new(), total };
        self.progress.report(0.0, "tasks");
        std::thread::scope(|scope| {
            for _ in 0..jobs.get().min(total) {
                scope.spawn(|| self.work(&shared));
            }
        });
        let board = shared.board.into_inner().unwrap_or_else(PoisonError::into_inner);
        let waiting = board.slots.iter().filter(|slot| **slot == Slot::Waiting).count();
        let failed = board.errors.len();
        let lasting =
            |error: &Error| !matches!(error, Error::GaveUp { .. } | Error::Needs { .. } | Error::Write { .. });
        let mut errors = board.errors;
        let worst = errors.iter().position(lasting).unwrap_or(0);
        if board.stopped {
            Err(Error::Stopped)
        } else if failed > 0 {
            Err(Error::Several { failed, total, waiting, source: Box::new(errors.swap_remove(worst)) })
        } else {
            Ok(board.totals)
        }
    }

    /// Takes one task after the other.
    fn work(&self, shared: &Shared) {
        let mut board = shared.lock();
        while !board.stopped {
            let Some(next) = self.next(&board) else {
                if !board.slots.contains(&Slot::Running) {
                    break;
                }
                board = shared.changed.wait(board).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            board.slots[next] = Slot::Running;
            drop(board);
            let result = self.attempt(&self.plan.tasks()[next]);
            board = shared.lock();
            self.note(&mut board, next, result, shared.total);
            shared.changed.notify_all();
        }
    }

    /// The next task that can begin. Later stages come first, so that pictures are there soon.
    fn next(&self, board: &Board) -> Option<usize> {
        let ready = |&i: &usize| {
            board.slots[i] == Slot::Waiting && self.plan.needs(i).all(|need| board.slots[need] == Slot::Done)
        };
        let stages = self.plan.stages().iter().rev();
        stages.flat_map(|stage| stage.tasks.clone()).find(ready)
    }

    fn note(&self, board: &mut Board, task: usize, result: Result<Ran, Error>, total: usize) {
        board.slots[task] = match result {
            Ok(ran) => {
                board.totals.done += 1;
                board.totals.retries += ran.attempts.saturating_sub(1);
                Slot::Done
            }
            Err(Error::Stopped) => {
                board.stopped = true;
                Slot::Waiting
            }
            Err(error) => {
                board.errors.push(error);
                Slot::Failed
            }
        };
        self.progress.report(board.totals.done as f64 / total.max(1) as f64, "tasks");
    }
}
