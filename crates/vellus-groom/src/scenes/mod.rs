//! Built-in scenes: those of Yan17 Table 5 and a polar bear, made from nothing but this code. Lengths are centimetres.

mod cat;
mod coat;
mod hair_lock;
mod hamster;
mod human;
mod polar_bear;
mod props;
mod raccoon;
mod sky;

use crate::error::Error;
use vellus_scene::Scene;

/// Names and descriptions of the built-in scenes.
pub const SCENES: [(&str, &str); 6] = [
    ("hair-lock", "a curling lock of brown human hair: 1,000 strands of 210 segments"),
    ("raccoon", "a raccoon under a sunny sky: 260,000 strands of 22 segments"),
    ("hamster", "a golden hamster in a studio: 580,000 strands of 15 segments"),
    ("cat", "a sitting brown tabby in the light of a window: 267,000 strands of 9 segments"),
    ("hair", "long human hair: 53,000 strands of 64 segments"),
    ("polar-bear", "a polar bear cub in soft light, white by scattering alone: 300,000 strands of 16 segments"),
];

/// A built-in scene; `None` if there is none of that name in [`SCENES`].
///
/// At full size strands and segments are as many as in Yan17 Table 5 (which has no polar bear). `small` has a fortieth of the strands
/// (the lock a fifth, with a quarter of the segments) and wider ones, for tests and previews.
pub fn scene(name: &str, small: bool) -> Option<Scene> {
    let make: fn(bool) -> Result<Scene, Error> = match name {
        "hair-lock" => hair_lock::scene,
        "raccoon" => raccoon::scene,
        "hamster" => hamster::scene,
        "cat" => cat::scene,
        "hair" => human::scene,
        "polar-bear" => polar_bear::scene,
        _ => return None,
    };
    // Their settings are constants, which tests run through.
    make(small).ok()
}
