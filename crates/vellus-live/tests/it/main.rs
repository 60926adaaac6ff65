//! The integration tests of `vellus-live`, as one program.

mod browser;
mod protocol;
