//! Short grass around the feet of an animal.

use super::noise::noise;
use crate::body::Body;
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f32::consts::TAU;
use vellus_scene::{Mesh, Scene, Surface, Texture, Tint, Wrap};

/// Number of blades.
const BLADES: usize = 100_000;
/// Divisor of the number of blades in a small scene.
const FEWER: usize = 10;
/// The radius of the meadow.
const RADIUS: f32 = 500.0;
/// The radius of the part with the same density everywhere, and the share of its blades.
const NEAR: (f32, f32) = (110.0, 0.6);
/// Width of the texture, whose columns are colours of blades. Its rows are the tip, the middle and the root.
const COLORS: usize = 16;

/// Adds blades of grass on the ground y = 0 around a body. They get sparser and larger with the distance.
pub(super) fn grass(scene: &mut Scene, body: &Body, small: bool) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    let (mut positions, mut triangles, mut uv) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..if small { BLADES / FEWER } else { BLADES } {
        let mut random = || rng.random::<f32>();
        // Beyond, the density falls with the square of the radius.
        let (near, share) = NEAR;
        let at = random();
        let radius = if at < share {
            near * (at / share).sqrt()
        } else {
            near * (RADIUS / near).powf((at - share) / (1.0 - share))
        };
        let (sin, cos) = (TAU * random()).sin_cos();
        let root = radius * Vec3::new(cos, 0.0, sin);
        let [tall, wide, bend, color] = [random(), random(), random(), random()];
        let (z, x) = (TAU * random()).sin_cos();
        // Tufts: blades are taller where the noise is high. They are short near the feet.
        let tuft = 0.5 + 0.5 * noise(0.09 * root) + 0.25 * noise(0.4 * root);
        let near = body.distance(root);
        if near < 0.6 {
            continue;
        }
        let scale = 1.3 + radius / 130.0;
        let height = scale * (0.6 + 1.1 * tuft.max(0.0)) * (0.55 + 0.9 * tall) * (0.45 + 0.05 * near).min(1.0);
        let half = scale * 0.07 * (0.7 + 0.6 * wide);
        let lean = height * (0.25 + 0.75 * bend) * Vec3::new(x, 0.0, z);
        let across = half * Vec3::new(-z, 0.0, x);
        let middle = root + 0.3 * lean + 0.6 * height * Vec3::Y;
        let tip = root + lean + height * (1.0 - 0.25 * bend) * Vec3::Y;
        let first = positions.len() as u32;
        positions.extend([root - across, root + across, middle - 0.7 * across, middle + 0.7 * across, tip]);
        let column = (0.5 + (color * COLORS as f32).floor()) / COLORS as f32;
        let row = |i: usize| Vec2::new(column, [1.0, 1.0, 3.0, 3.0, 5.0][i] / 6.0);
        for triangle in [[0, 1, 3], [0, 3, 2], [2, 3, 4]] {
            triangles.push(triangle.map(|i| first + i as u32));
            uv.push(triangle.map(row));
        }
    }
    let color = |i: usize| {
        let c = (i % COLORS) as f32 / (COLORS - 1) as f32;
        // Blades are green, and parts of some are dry. Tips are brighter.
        let fresh = Vec3::new(0.14, 0.2, 0.05).lerp(Vec3::new(0.25, 0.28, 0.09), c);
        let dry = Vec3::new(0.42, 0.36, 0.2);
        let blade = if i % 5 == 2 { dry } else { fresh };
        (blade * [1.1, 0.95, 0.7][i / COLORS]).to_array()
    };
    scene.meshes.push(Mesh {
        name: "grass".to_owned(),
        positions,
        triangles,
        normals: None,
        uv: Some(uv),
        moved: None,
        surface: scene.surfaces.len(),
    });
    scene.surfaces.push(Surface {
        color: Tint { color: [1.0; 3], texture: Some(scene.textures.len()) },
        ..Surface::diffuse("grass", [0.0; 3])
    });
    let pixels = (0..3 * COLORS).map(color).collect();
    scene.textures.push(Texture {
        name: "grass".to_owned(),
        width: COLORS,
        height: 3,
        pixels,
        wrap: [Wrap::Repeat; 2],
    });
}
