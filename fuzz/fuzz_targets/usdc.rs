#![no_main]
//! USD: binary.

libfuzzer_sys::fuzz_target!(init: vellus_fuzz::init(), |bytes: &[u8]| vellus_fuzz::stage("fuzz.usdc", bytes));
