//! Objects in built-in scenes: eyes, noses, grounds and lights.

use glam::{Mat3, Mat4, Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use vellus_scene::{Light, LightShape, Mesh, Scene, Surface, Tint};

/// A dark, wet surface for eyes and noses.
pub(super) fn glossy(name: &str, color: [f32; 3], roughness: f32) -> Surface {
    Surface { color: Tint { color, texture: None }, roughness, ior: 1.5, ..Surface::diffuse(name, color) }
}

/// Adds an ellipsoid with smooth normals. `turn` is the rotation from its own frame to world space.
pub(super) fn ellipsoid(scene: &mut Scene, center: Vec3, radii: Vec3, turn: Quat, surface: Surface) {
    const AROUND: u32 = 48;
    const DOWN: u32 = 24;
    let unit = |i: u32, j: u32| {
        let (phi, theta) = (TAU * i as f32 / AROUND as f32, PI * j as f32 / DOWN as f32);
        Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos())
    };
    let vertices: Vec<Vec3> = (0..=DOWN).flat_map(|j| (0..AROUND).map(move |i| unit(i, j))).collect();
    let mut triangles = Vec::new();
    for j in 0..DOWN {
        for i in 0..AROUND {
            let [a, b] = [j * AROUND + i, j * AROUND + (i + 1) % AROUND];
            let [c, d] = [a + AROUND, b + AROUND];
            if j + 1 < DOWN {
                triangles.push([a, c, d]);
            }
            if j > 0 {
                triangles.push([a, d, b]);
            }
        }
    }
    let normal = |v: u32| turn * (vertices[v as usize] / radii).normalize();
    scene.meshes.push(Mesh {
        name: surface.name.clone(),
        normals: Some(triangles.iter().map(|t| t.map(normal)).collect()),
        positions: vertices.iter().map(|&v| center + turn * (v * radii)).collect(),
        triangles,
        uv: None,
        moved: None,
        surface: scene.surfaces.len(),
    });
    scene.surfaces.push(surface);
}

/// Adds a horizontal square at y = 0 with this half width.
pub(super) fn ground(scene: &mut Scene, half: f32, color: [f32; 3]) {
    let corner = |x: f32, z: f32| Vec3::new(x * half, 0.0, z * half);
    scene.meshes.push(Mesh {
        name: "ground".to_owned(),
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: None,
        uv: None,
        moved: None,
        surface: scene.surfaces.len(),
    });
    scene.surfaces.push(Surface::diffuse("ground", color));
}

/// The profile of a wall and the floor in front of it, from the top, with a rounded corner. The wall is `far` plus
/// `radius` behind the origin.
pub(super) fn room(far: f32, radius: f32) -> Vec<Vec2> {
    let turn = |i: i32| {
        let (sin, cos) = (FRAC_PI_2 * *super::opaque(&i) as f32 / 16.0).sin_cos();
        Vec2::new(-far - radius * cos, radius * (1.0 - sin))
    };
    let mut profile = vec![Vec2::new(-far - radius, radius + 270.0)];
    profile.extend((0..=16).map(turn));
    profile.push(Vec2::new(400.0, 0.0));
    profile
}

/// Adds a profile, extruded by `half` to both sides of the plane of the y axis and the horizontal vector `forward`.
/// `profile` has distances along `forward` and heights. The surface faces to the left of the profile.
pub(super) fn strip(scene: &mut Scene, profile: &[Vec2], forward: Vec3, half: f32, color: [f32; 3]) {
    let side = Vec3::Y.cross(forward).normalize_or(Vec3::X) * half;
    let point = |p: &Vec2| p.x * forward + p.y * Vec3::Y;
    let positions = profile.iter().flat_map(|p| [point(p) - side, point(p) + side]).collect();
    let quad = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]];
    let smooth: Vec<Vec3> = (0..profile.len())
        .map(|i| {
            let along = profile[(i + 1).min(profile.len() - 1)] - profile[i.saturating_sub(1)];
            point(&along.perp()).normalize_or(Vec3::Y)
        })
        .collect();
    let triangles: Vec<[u32; 3]> = (0..profile.len() as u32 - 1).flat_map(quad).collect();
    scene.meshes.push(Mesh {
        name: "backdrop".to_owned(),
        normals: Some(triangles.iter().map(|t| t.map(|v| smooth[v as usize / 2])).collect()),
        positions,
        triangles,
        uv: None,
        moved: None,
        surface: scene.surfaces.len(),
    });
    scene.surfaces.push(Surface::diffuse("backdrop", color));
}

/// A light from all directions: a radiance, or the factor of a texture of the scene.
pub(super) fn dome(radiance: [f32; 3], texture: Option<usize>) -> Light {
    LightShape::Dome { radiance, texture, rotation: Mat3::IDENTITY, ground: None }.into()
}

/// A rectangular light at `from` that faces `to`, with this width and height.
pub(super) fn window(from: Vec3, to: Vec3, size: Vec2, radiance: [f32; 3]) -> Light {
    let z = (from - to).normalize_or(Vec3::Y);
    let x = Vec3::Y.cross(z).normalize_or(Vec3::X);
    let y = z.cross(x);
    let to_world = Mat4::from_cols((size.x * x).extend(0.0), (size.y * y).extend(0.0), z.extend(0.0), from.extend(1.0));
    LightShape::Rect { to_world, radiance, texture: None }.into()
}
