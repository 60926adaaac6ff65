#![no_main]
//! USD: text.

libfuzzer_sys::fuzz_target!(init: vellus_fuzz::init(), |bytes: &[u8]| vellus_fuzz::stage("fuzz.usda", bytes));
