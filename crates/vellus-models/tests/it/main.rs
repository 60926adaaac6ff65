//! The integration tests of `vellus-models`, as one program.

mod energy;
mod far;
mod hair;
mod published;
mod sampling;
mod unchanged;
mod yan2015;
