//! The integration tests of `vellus-open`, as one program.

mod alembic;
mod identity;
mod shown;
