//! Tests of whole archives.
