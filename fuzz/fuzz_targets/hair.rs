#![no_main]
//! Cem Yuksel's .hair files.

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(mut strands) = vellus_groom::read_hair(bytes, "fuzz", Some(0.1)) {
        strands.remove_broken();
        assert_eq!(strands.validate(), Ok(()));
        let again = vellus_groom::write_hair(&strands).expect("linear strands of at most 65535 segments");
        assert!(vellus_groom::read_hair(&again, "fuzz", None).is_ok());
    }
});
