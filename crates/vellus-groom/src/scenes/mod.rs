//! Built-in procedural scenes: those of Yan17 Table 5, a polar bear, and more hairstyles. Lengths are in centimetres.

mod cat;
mod coat;
mod eyes;
mod glow;
mod grass;
mod hair_lock;
mod hairstyle;
mod hamster;
mod herd;
mod human;
mod noise;
mod polar_bear;
mod props;
mod raccoon;
mod sky;
mod toes;
mod tube;
mod whiskers;

use crate::error::Error;
use hairstyle::Hairstyle;
use vellus::{Fiber, Species};
use vellus_scene::{Scene, Units};

/// Names and descriptions of the built-in scenes.
pub const SCENES: [(&str, &str); 9] = [
    ("hair-lock", "a curling lock of brown human hair: 1,000 strands of 210 segments"),
    ("raccoon", "a raccoon on grass under a sunny sky: 260,000 strands of 22 segments"),
    ("hamster", "a golden hamster in a studio: 580,000 strands of 15 segments"),
    ("hamsters", "a hundred golden hamsters on a meadow: 58 million strands, which share the memory of one"),
    ("cat", "a sitting brown tabby in the light of a window: 267,000 strands of 9 segments"),
    ("hair", "long human hair in waves: 53,000 strands of 64 segments"),
    ("hair-bob", "straight black human hair to the chin: 53,000 strands of 32 segments"),
    ("hair-curls", "dark human hair in ringlets to the shoulders: 53,000 strands of 48 segments"),
    ("polar-bear", "a polar bear cub in soft light, white by scattering alone: 300,000 strands of 16 segments"),
];

/// Gives the fibre of a species.
type Preset = fn(Species) -> Fiber;

/// A built-in scene with the fibres of [`Fiber::preset`]; `None` if [`SCENES`] has none of this name.
///
/// At full size, the numbers of strands and segments are those of Yan17 Table 5, which has neither the polar bear nor
/// `hamsters`, `hair-bob` and `hair-curls`. With `small`, there are 1/40 of the strands, and they are wider. The small
/// lock has 1/5 of the strands and 1/4 of the segments. Small scenes are for tests and previews.
pub fn scene(name: &str, small: bool) -> Option<Scene> {
    with_preset(name, small, Fiber::preset)
}

/// The same scene as [`scene()`] with the fibres of [`Fiber::published`], for experiments of the paper.
pub fn published_scene(name: &str, small: bool) -> Option<Scene> {
    with_preset(name, small, Fiber::published)
}

/// The same value, hidden from the optimizer.
///
/// The compiler may compute sines of constants itself, and rounds some of them differently than the system's library.
/// Which ones depends on the build, so pictures would differ between builds.
fn opaque<T>(value: &T) -> &T {
    std::hint::black_box(value)
}

fn with_preset(name: &str, small: bool, preset: Preset) -> Option<Scene> {
    let make: fn(bool, Preset) -> Result<Scene, Error> = match name {
        "hair-lock" => hair_lock::scene,
        "raccoon" => raccoon::scene,
        "hamster" => hamster::scene,
        "hamsters" => herd::scene,
        "cat" => cat::scene,
        "hair" => |small, preset| human::scene(&Hairstyle::waves(), small, preset),
        "hair-bob" => |small, preset| human::scene(&Hairstyle::bob(), small, preset),
        "hair-curls" => |small, preset| human::scene(&Hairstyle::curls(), small, preset),
        "polar-bear" => polar_bear::scene,
        _ => return None,
    };
    // Settings are constants, and tests cover all of them.
    let scene = make(small, preset).ok()?;
    Some(Scene { units: Some(Units::CENTIMETERS), ..scene })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use std::array::from_fn;
    use std::sync::{LazyLock, OnceLock};

    /// The small version of a scene, which all tests share: some take seconds to grow.
    fn small(name: &str) -> &'static Scene {
        static GROWN: LazyLock<[OnceLock<Scene>; SCENES.len()]> = LazyLock::new(|| from_fn(|_| OnceLock::new()));
        let index = SCENES.iter().position(|(scene, _)| *scene == name).unwrap();
        GROWN[index].get_or_init(|| scene(name, true).unwrap())
    }

    #[test]
    fn all_small_scenes_are_valid_and_have_what_a_picture_needs() {
        for (name, _) in SCENES {
            let scene = small(name);
            assert_eq!(scene.validate(), Ok(()), "{name}");
            assert!(scene.camera.is_some() && !scene.lights.is_empty() && !scene.meshes.is_empty(), "{name}");
            for strands in scene.all_strands() {
                // Radii are positive at roots and tips, and shrink toward the tip.
                for i in 0..strands.len() {
                    let strand = strands.strand(i);
                    assert!(strand[0].w > strand[strand.len() - 1].w && strand[strand.len() - 1].w > 0.0, "{name}");
                }
            }
        }
        assert!(scene("unicorn", true).is_none());
    }

    #[test]
    fn small_scenes_have_a_fortieth_of_the_strands() {
        let expected = [
            ("raccoon", 6500, 22),
            ("hamster", 14500, 15),
            ("cat", 6675, 9),
            ("hair", 1325, 64),
            ("polar-bear", 7500, 16),
        ];
        for (name, strands, segments) in expected {
            let fur = &small(name).strands[0];
            assert_eq!((fur.len(), fur.segments()), (strands, strands * segments), "{name}");
        }
    }

    /// Yan17 Table 5. The larger ones are 40 times the small ones, by the test above.
    #[test]
    fn the_lock_has_the_papers_strands_and_segments() {
        let lock = &scene("hair-lock", false).unwrap().strands[0];
        assert_eq!((lock.len(), lock.segments()), (1000, 210_000));
    }

    #[test]
    fn fur_grows_on_bodies_and_stays_outside() {
        type Make = fn() -> Body;
        let bodies: [(&str, Make); 5] = [
            ("raccoon", raccoon::body),
            ("hamster", hamster::body),
            ("cat", cat::body),
            ("polar-bear", polar_bear::body),
            ("hair", human::body),
        ];
        for (name, body) in bodies {
            let body = body();
            let fur = &small(name).strands[0];
            let length = |i: usize| {
                let points = fur.strand(i);
                points.windows(2).map(|p| p[0].truncate().distance(p[1].truncate())).sum::<f32>()
            };
            let longest = (0..fur.len()).map(length).fold(0.0, f32::max);
            // Triangles are chords of a body, so roots are slightly inside: up to a millimetre for large bodies, less
            // for the hamster.
            let near = (0.02 * longest).min(0.1);
            let off = |i: usize| body.distance(fur.strand(i)[1].truncate()).abs() > near;
            let off = (0..fur.len()).filter(|&i| off(i)).count();
            assert!(off * 200 < fur.len(), "{name}: {off} of {} roots are off the surface", fur.len());
            let inner = (0..fur.len()).flat_map(|i| &fur.strand(i)[2..fur.strand(i).len() - 1]);
            let (mut points, mut inside) = (0, 0);
            for p in inner {
                points += 1;
                inside += usize::from(body.distance(p.truncate()) < -0.5 * near);
            }
            assert!(inside * 50 < points, "{name}: {inside} of {points} points are in the body");
        }
    }

    #[test]
    fn hair_falls_beside_the_face() {
        for name in ["hair", "hair-bob", "hair-curls"] {
            let hair = &small(name).strands[0];
            let over = |p: &&glam::Vec4| p.x > 7.0 && p.z.abs() < 3.0 && (-9.0..2.0).contains(&p.y);
            let count = hair.points.iter().filter(over).count();
            assert!(count * 2000 < hair.points.len(), "{name}: {count} of {} points", hair.points.len());
        }
    }

    #[test]
    fn the_bob_has_a_level_edge() {
        let hair = &small("hair-bob").strands[0];
        let mut tips: Vec<f32> = (0..hair.len()).map(|i| hair.strand(i)[hair.strand(i).len() - 2].y).collect();
        tips.sort_by(f32::total_cmp);
        // Strands of equal length would end at heights that differ as much as their roots: by 16.
        let spread = tips[tips.len() * 9 / 10] - tips[tips.len() / 10];
        assert!(spread < 5.0, "{spread}");
    }

    #[test]
    fn grass_stands_on_the_ground_beside_the_feet() {
        let mut scene = Scene::default();
        grass::grass(&mut scene, &raccoon::body(), true);
        assert_eq!(scene.validate(), Ok(()));
        let (body, blades) = (raccoon::body(), &scene.meshes[0]);
        for blade in blades.positions.chunks(5) {
            let root = 0.5 * (blade[0] + blade[1]);
            assert!(root.y == 0.0 && blade[4].y > 0.0 && body.distance(root) > 0.5, "{blade:?}");
        }
    }

    #[test]
    fn eyes_and_noses_are_bare() {
        for name in ["raccoon", "hamster", "cat", "polar-bear"] {
            let scene = small(name);
            let fur = &scene.strands[0];
            for mesh in scene.meshes.iter().filter(|m| ["eye", "iris", "nose"].contains(&m.name.as_str())) {
                let center = mesh.positions.iter().sum::<glam::Vec3>() / mesh.positions.len() as f32;
                let radius = mesh.positions.iter().map(|p| p.distance(center)).fold(f32::INFINITY, f32::min);
                let on = (0..fur.len()).filter(|&i| fur.strand(i)[1].truncate().distance(center) < radius).count();
                assert!(on == 0, "{name}: {on} hairs grow on the {}", mesh.name);
            }
        }
    }
}
