//! Tubes along lines, such as lips.

use glam::Vec3;
use std::f32::consts::TAU;
use vellus_scene::{Mesh, Scene, Surface};

/// Adds a tube around a line of points that becomes thin at both ends.
pub(super) fn tube(scene: &mut Scene, line: &[Vec3], radius: f32, surface: Surface) {
    const AROUND: u32 = 10;
    let last = line.len().saturating_sub(1);
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for (i, &p) in line.iter().enumerate() {
        let along = (line[(i + 1).min(last)] - line[i.saturating_sub(1)]).normalize_or(Vec3::X);
        let (u, v) = along.any_orthonormal_pair();
        let s = i as f32 / last.max(1) as f32;
        let thickness = radius * (4.0 * s * (1.0 - s)).sqrt().max(0.15);
        for k in 0..AROUND {
            let (sin, cos) = (TAU * *super::opaque(&k) as f32 / AROUND as f32).sin_cos();
            normals.push(u * cos + v * sin);
            positions.push(p + (u * cos + v * sin) * thickness);
        }
    }
    let quad = |i: u32| {
        let next = i / AROUND * AROUND + (i + 1) % AROUND;
        [[i, next, i + AROUND], [next, next + AROUND, i + AROUND]]
    };
    let triangles: Vec<[u32; 3]> = (0..last as u32 * AROUND).flat_map(quad).collect();
    scene.meshes.push(Mesh {
        name: surface.name.clone(),
        normals: Some(triangles.iter().map(|t| t.map(|v| normals[v as usize])).collect()),
        positions,
        triangles,
        uv: None,
        moved: None,
        surface: scene.surfaces.len(),
    });
    scene.surfaces.push(surface);
}

/// Points of a curve through `points` (Catmull–Rom), moved by `project`.
pub(super) fn curve(points: &[[f32; 3]], project: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    const STEPS: usize = 6;
    let at = |i: isize| Vec3::from(points[i.clamp(0, points.len() as isize - 1) as usize]);
    let last = points.len().saturating_sub(1) * STEPS;
    let point = |k: usize| {
        let (i, t) = ((k / STEPS) as isize, (k % STEPS) as f32 / STEPS as f32);
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        let smooth = b * 2.0 + (c - a) * t + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t);
        0.5 * (smooth + (b * 3.0 - a - c * 3.0 + d) * t.powi(3))
    };
    (0..=last).map(|k| project(point(k))).collect()
}
