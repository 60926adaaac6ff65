//! Catches panics of third-party decoders.
//!
//! `openusd` uses numbers of a binary file as indices in dozens of places. The tables are compressed, so they cannot be
//! checked without decoding them. The authors of `exr` fuzz it, but it decodes untrusted files too. Some failures
//! cannot be caught: failed allocations, stack overflows and endless loops. The checks of [`crate::stage`] prevent
//! those.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static CAUGHT_HERE: Cell<bool> = const { Cell::new(false) };
}

/// Returns the result of a call, or `None` if it panics.
pub(crate) fn catch<T>(call: impl FnOnce() -> T) -> Option<T> {
    let outer = CAUGHT_HERE.replace(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    CAUGHT_HERE.set(outer);
    result.ok()
}

/// Stops the panic hook from printing panics that this crate catches.
///
/// The crate turns these panics into errors. A program that prints errors would report them twice. Other panics go to
/// the previous hook.
pub fn quiet_caught_panics() {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !CAUGHT_HERE.get() {
            hook(panic);
        }
    }));
}
