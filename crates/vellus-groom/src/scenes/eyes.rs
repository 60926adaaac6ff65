//! Eyes of animals: an eyeball with iris and pupil, and lids with an almond-shaped opening.

use super::coat::smoothstep;
use super::props;
use super::tube::tube;
use glam::{Mat3, Quat, Vec2, Vec3};
use std::f32::consts::TAU;
use vellus_scene::{Mesh, Scene, Surface, Texture, Tint, Wrap};

/// Width and height of the texture of an eyeball.
const SIZE: usize = 96;

/// Points around the opening of the lids.
const AROUND: u32 = 48;

/// An eye. Angles are in radians, seen from the centre of the eyeball.
#[derive(Clone, Copy)]
pub(super) struct Eye {
    pub center: Vec3,
    pub radius: f32,
    /// The direction in which it looks.
    pub gaze: Vec3,
    /// Half the width of the opening between the lids, and its height above and below the middle.
    pub opening: [f32; 3],
    /// The rotation of the opening about the gaze. A positive angle raises the outer corner of the eye at positive z.
    pub tilt: f32,
    pub iris: [f32; 3],
    /// The radius of the iris.
    pub iris_radius: f32,
    /// Half the width and half the height of the pupil.
    pub pupil: [f32; 2],
    /// The colour of the lids.
    pub lid: [f32; 3],
}

impl Eye {
    /// The mirror image at z = 0.
    pub fn mirrored(self) -> Eye {
        let flip = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
        Eye { center: flip(self.center), gaze: flip(self.gaze), tilt: -self.tilt, ..self }
    }

    /// A frame: to the right of the eye, up, and the direction of the gaze.
    fn frame(&self) -> Mat3 {
        let gaze = self.gaze.normalize_or(Vec3::X);
        let right = Vec3::Y.cross(gaze).normalize_or(Vec3::Z);
        Mat3::from_cols(right, gaze.cross(right), gaze)
    }

    /// Adds the eyeball and its lids.
    pub fn add(&self, scene: &mut Scene) {
        // Sines of constants would differ between builds: see `super::opaque`.
        let eye = super::opaque(self);
        let frame = eye.frame();
        let surface = Surface {
            color: Tint { color: [1.0; 3], texture: Some(scene.textures.len()) },
            // The cornea.
            ior: 1.376,
            ..props::glossy("eye", [0.0; 3], 0.02)
        };
        props::ellipsoid(scene, eye.center, Vec3::splat(eye.radius), Quat::IDENTITY, surface);
        scene.textures.push(eye.texture());
        if let Some(ball) = scene.meshes.last_mut() {
            // The texture is a picture of the eye from the front.
            let uv = |v: u32| {
                let p = frame.transpose() * (ball.positions[v as usize] - eye.center) / eye.radius;
                Vec2::splat(0.5) + 0.48 * p.truncate()
            };
            ball.uv = Some(ball.triangles.iter().map(|t| t.map(uv)).collect());
        }
        let lids = eye.lids(scene.surfaces.len());
        // The tear line, along the edge of the lower lid.
        let edge = lids.positions[AROUND as usize / 2..AROUND as usize].to_vec();
        scene.meshes.push(lids);
        scene.surfaces.push(props::glossy("eyelid", eye.lid, 0.45));
        tube(scene, &edge, 0.06 * eye.radius, props::glossy("tear line", eye.lid, 0.05));
    }

    fn texture(&self) -> Texture {
        let iris_radius = self.iris_radius.sin();
        let pupil = Vec2::from(self.pupil.map(f32::sin));
        let color = |i: usize| {
            let at = |n: usize| ((n as f32 + 0.5) / SIZE as f32 - 0.5) / 0.48;
            // The first row is the top.
            let p = Vec2::new(at(i % SIZE), -at(i / SIZE));
            let r = p.length() / iris_radius;
            let angle = p.y.atan2(p.x);
            let streaks = 0.85 + 0.1 * (23.0 * angle + 4.0 * r).sin() + 0.08 * (37.0 * angle - 7.0 * r).sin();
            // The iris is brighter near the pupil and has a dark rim.
            let iris = Vec3::from(self.iris) * streaks * (1.25 - 0.4 * r) * (1.0 - 0.85 * smoothstep(0.84, 1.0, r));
            let around = Vec3::new(0.035, 0.022, 0.015);
            let ring = iris.lerp(around, smoothstep(0.96, 1.04, r));
            let hole = smoothstep(1.1, 0.92, (p / pupil).length());
            ring.lerp(Vec3::splat(0.003), hole).to_array()
        };
        let pixels = (0..SIZE * SIZE).map(color).collect();
        Texture { name: "eye".to_owned(), width: SIZE, height: SIZE, pixels, wrap: [Wrap::Repeat; 2] }
    }

    /// A shell around the eyeball with an opening in front.
    fn lids(&self, surface: usize) -> Mesh {
        /// Angle beyond the edge of the opening, and distance from the centre relative to the radius.
        const PROFILE: [(f32, f32); 6] =
            [(0.0, 0.98), (0.02, 1.05), (0.07, 1.1), (0.16, 1.11), (0.4, 1.08), (0.9, 1.0)];
        let frame = self.frame();
        let [width, above, below] = self.opening;
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for (k, (beyond, distance)) in PROFILE.into_iter().enumerate() {
            for i in 0..AROUND {
                let (sin, cos) = (TAU * i as f32 / AROUND as f32).sin_cos();
                let height = if sin > 0.0 { above } else { below };
                // The edge of a lid is a parabola: |y| = height × (1 − (x / width)²).
                let (a, b) = (height * (cos / width).powi(2), sin.abs());
                let edge = if a > 1e-6 { ((b * b + 4.0 * a * height).sqrt() - b) / (2.0 * a) } else { height / b };
                let around = Quat::from_rotation_z(-self.tilt) * Vec3::new(cos, sin, 0.0);
                let (s, c) = (edge + beyond).sin_cos();
                let out = around * s + Vec3::Z * c;
                // The edge faces the opening.
                let facing = if k == 0 { out - around } else { out };
                positions.push(self.center + frame * (out * (distance * self.radius)));
                normals.push((frame * facing).normalize_or(self.gaze));
            }
        }
        let quad = |i: u32| {
            let (row, next) = (i / AROUND * AROUND, (i + 1) % AROUND);
            let [a, b] = [i, row + next];
            let [c, d] = [a + AROUND, b + AROUND];
            [[a, c, b], [b, c, d]]
        };
        let triangles: Vec<[u32; 3]> = (0..(PROFILE.len() as u32 - 1) * AROUND).flat_map(quad).collect();
        let normals = Some(triangles.iter().map(|t| t.map(|v| normals[v as usize])).collect());
        Mesh { name: "eyelid".to_owned(), positions, triangles, normals, uv: None, moved: None, surface }
    }
}
