//! The integration tests of `vellus-views`, as one program.

mod answers;
