//! Panics of decoders that are not ours.
//!
//! `openusd` indexes by what a binary file says in dozens of places, in tables that are compressed: to check them before would
//! be to decode them. `exr` is fuzzed by its authors, but decodes what comes from anywhere. What cannot be caught (a failed
//! allocation, a stack that is too deep, a loop without end) is checked before instead.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static CAUGHT_HERE: Cell<bool> = const { Cell::new(false) };
}

/// What a call gives; `None` if it panics.
pub(crate) fn catch<T>(call: impl FnOnce() -> T) -> Option<T> {
    let outer = CAUGHT_HERE.replace(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    CAUGHT_HERE.set(outer);
    result.ok()
}

/// Keeps the panic hook from printing panics that this crate catches, and makes errors of: for programs that print the
/// errors. Other panics go to the hook there was.
pub fn quiet_caught_panics() {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !CAUGHT_HERE.get() {
            hook(panic);
        }
    }));
}
