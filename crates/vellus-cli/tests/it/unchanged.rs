//! Pictures of the built-in scenes have the pixels that they had before.
//!
//! A change of the code's structure must not change a bit. A change that alters pictures on purpose replaces the hashes
//! and gives the reason in CHANGELOG.md. The hashes are for processors with AVX2 and FMA. Others round differently.
#![cfg(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma"))]

use crate::common::{Picture, run};

/// The hashes of the pictures of some scenes.
fn hashes(scenes: &[(&'static str, &str)], more: &[&str]) -> Vec<(&'static str, String)> {
    let folder = tempfile::tempdir().unwrap();
    let hash = |&(scene, _): &(&'static str, &str)| {
        let usual = ["render", scene, "--size", "64x48", "--spp", "4", "-o", "picture.exr"];
        run(folder.path(), &[&usual[..], more].concat());
        (scene, Picture::read(&folder.path().join("picture.exr")).note("vellus_pixels")[..16].to_owned())
    };
    scenes.iter().map(hash).collect()
}

#[test]
fn small_scenes_have_the_same_pixels_as_before() {
    let expected = [
        ("hair-lock", "f84046c793e8477b"),
        ("raccoon", "a7215d45e627f70b"),
        ("hamster", "a533f1922b57a835"),
        ("cat", "15741233d7d5f4a0"),
        ("hair", "7ed35f526f9f803d"),
        ("polar-bear", "c755bd6bdd51ea7a"),
        ("hamsters", "f09d8b69edcdc70d"),
        ("hair-bob", "0bc2bedb567ad8bb"),
        ("hair-curls", "23576f71b210da54"),
    ];
    assert_eq!(hashes(&expected, &["--small"]), expected.map(|(scene, hash)| (scene, hash.to_owned())));
}

#[test]
#[ignore = "full: seven whole scenes, of which the small versions have a test in `check`"]
fn scenes_have_the_same_pixels_as_before() {
    let expected = [
        ("hair-lock", "544af401fb87f602"),
        ("raccoon", "0dcc0ca5b4ab0dc2"),
        ("hamster", "a40bcfe89e25cf9a"),
        ("cat", "8ccf6216db0cbf9a"),
        ("hair", "66421936b7256733"),
        ("polar-bear", "3eddc95a8b70822e"),
        ("hamsters", "a2f92268fa74ef56"),
    ];
    assert_eq!(hashes(&expected, &[]), expected.map(|(scene, hash)| (scene, hash.to_owned())));
}
