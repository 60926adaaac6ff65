//! The integration tests of `vellus-experiments`, as one program.

mod coat;
