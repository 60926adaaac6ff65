//! The integration tests of `vellus-cli`, as one program.

mod command;
mod common;
mod documents;
mod experiment;
mod farm;
mod fibers;
mod fit;
mod grow;
mod input;
mod nonsense;
mod outputs;
mod process;
mod render;
mod shaders;
mod staging;
mod unchanged;
