//! The integration tests of `vellus-c`, as one program.

mod calls;
mod header;
mod programs;
