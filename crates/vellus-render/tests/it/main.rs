//! The integration tests of `vellus-render`, as one program.

mod adaptive;
mod common;
mod cryptomatte;
mod job;
mod links;
mod models;
mod radiance_cache;
mod render;
mod session;
mod simplify;
mod tracer;
