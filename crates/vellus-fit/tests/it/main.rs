//! The integration tests of `vellus-fit`, as one program.

mod files;
mod fit;
mod models;
mod refit;
mod verdict;
