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
        ("hair-lock", "56a512771ac6404b"),
        ("raccoon", "ca049cda966440f2"),
        ("hamster", "5de6cf1f785245bd"),
        ("cat", "8c129b97d7ed9f72"),
        ("hair", "eedb040418c37cd5"),
        ("polar-bear", "ca545d6da95b0978"),
        ("hamsters", "e575e4e4df6bcea7"),
        ("hair-bob", "746c7d2f0f63edc0"),
        ("hair-curls", "da9546624eceed31"),
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
