#![no_main]
//! TressFX' .tfx files.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(mut strands) = vellus_groom::read_tfx(bytes, "fuzz", Some(0.1)) {
        strands.remove_broken();
        assert_eq!(strands.validate(), Ok(()));
    }
});
