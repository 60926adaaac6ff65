//! The integration tests of `vellus-open`, as one program.

mod alembic;
mod identity;
mod shown;

// The tests of one crate use a part of it.
#[allow(dead_code)]
#[path = "../../../vellus-alembic/tests/it/writer.rs"]
mod writer;
