#![no_main]
//! USD: packages.

libfuzzer_sys::fuzz_target!(init: vellus_fuzz::init(), |bytes: &[u8]| vellus_fuzz::stage("fuzz.usdz", bytes));
