//! Tests of whole archives, which the tests write.

mod archive;
mod hostile;
mod schemas;
mod write;
mod writer;
