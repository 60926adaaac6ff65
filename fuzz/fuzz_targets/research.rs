#![no_main]
//! Strands of research data sets: .data, .ply, .npy and .npz files.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(mut strands) = vellus_groom::read_research(bytes, "fuzz", Some(0.1)) {
        strands.remove_broken();
        assert!(strands.is_empty() || strands.validate() == Ok(()));
    }
});
