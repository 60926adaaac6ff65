//! Pictures of the built-in scenes have the pixels that they had before.
//!
//! A change of the code's structure must not change a bit. A change that alters pictures on purpose replaces the hashes
//! and gives the reason in CHANGELOG.md. The hashes are for processors with AVX2 and FMA. Others round differently.
#![cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]

#[allow(dead_code, reason = "each test uses a part of it")]
use crate::common::{Picture, run};

#[test]
#[ignore = "test: seven whole scenes"]
fn scenes_have_the_same_pixels_as_before() {
    let folder = tempfile::tempdir().unwrap();
    let expected = [
        ("hair-lock", "5ef8abc2195bc969"),
        ("raccoon", "8d171631c3ad93b9"),
        ("hamster", "2094155f39129fdb"),
        ("cat", "b932f7c693086d84"),
        ("hair", "87e338edd225f7f0"),
        ("polar-bear", "cef7b21917a85dce"),
        ("hamsters", "b9ab9f5649dff87a"),
    ];
    let hashes = expected.map(|(scene, _)| {
        run(folder.path(), &["render", scene, "--size", "64x48", "--spp", "4", "-o", "picture.exr"]);
        (scene, Picture::read(&folder.path().join("picture.exr")).note("vellus_pixels")[..16].to_owned())
    });
    assert_eq!(hashes.each_ref().map(|(scene, hash)| (*scene, hash.as_str())), expected);
}
