#![no_main]
//! Textures: PNG, JPEG, TIFF, Radiance HDR and OpenEXR, recognised by their first bytes.

libfuzzer_sys::fuzz_target!(init: vellus_fuzz::init(), |bytes: &[u8]| {
    if let Ok((texture, _)) = vellus_usd::load_texture(&vellus_fuzz::file("image", bytes)) {
        assert_eq!(texture.validate(), Ok(()));
    }
});
