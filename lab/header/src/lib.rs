//! Only a test: `crates/vellus-c/include/vellus.h` belongs to the code.
