//! Runs a reader on a thread with a large stack.
//!
//! `openusd` is recursive: it parses a prim inside the call that parses its parent, and composes a prim inside the call
//! that composes what refers to it. The limits of [`crate::stage`] bound the depth, but the stack of the caller may be
//! small: 2 MB for threads of Rust, and as little as 0.5 MB in other programs.

use std::io;
use std::panic::resume_unwind;
use std::thread::{Builder, scope};

/// The size of the stack, in bytes. The system only provides the part that is used.
const STACK: usize = 512 << 20;

/// Runs `work` on a thread with a large stack.
pub(crate) fn on_large_stack<T: Send>(work: impl FnOnce() -> T + Send) -> io::Result<T> {
    scope(|scope| {
        let thread = Builder::new().name("vellus-usd".to_owned()).stack_size(STACK).spawn_scoped(scope, work)?;
        Ok(thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
    })
}
