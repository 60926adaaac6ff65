//! The lights and the cyclorama of a studio.

use super::Lighting;
use glam::{Mat3, Mat4, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use vellus_scene::{Camera, Light, LightShape, Mesh, Scene, Surface, Texture, Wrap};

/// The reflectance of the cyclorama.
const CYCLORAMA: [f32; 3] = [0.1; 3];
/// Distance of the wall behind the subject, and horizontal length of the bend between ground and wall, relative to the
/// size of the subject.
const WALL: f32 = 5.0;
const BEND: f32 = 4.6;
/// Straight pieces of the bend, and columns of the cyclorama. Long, thin triangles would be imprecise.
const PIECES: usize = 48;
const COLUMNS: usize = 32;
/// The ground is so far below the subject, relative to its size. It must not coincide with a ground of the file.
const GAP: f32 = 1e-3;

/// Rows and columns of the image of the sky.
const SKY: [usize; 2] = [32, 4];

/// A rectangular light: its direction from the subject (right, up, toward the camera), its distance and its size
/// relative to that of the subject, and its radiance.
struct Panel {
    group: &'static str,
    toward: Vec3,
    distance: f32,
    size: f32,
    radiance: f32,
}

/// A large key light at the left, a weaker and larger fill light at the right, and a rim light high behind the subject.
/// The plane of the rim light meets the wall above the picture: below the plane, it lights the wall evenly.
const PANELS: [Panel; 3] = [
    Panel { group: "key", toward: Vec3::new(-0.75, 0.7, 0.75), distance: 3.2, size: 2.0, radiance: 8.0 },
    Panel { group: "fill", toward: Vec3::new(0.9, 0.35, 0.75), distance: 3.4, size: 2.6, radiance: 1.4 },
    Panel { group: "rim", toward: Vec3::new(0.25, 0.9, -0.36), distance: 4.2, size: 2.0, radiance: 8.0 },
];
/// The radiance of the dome that lightens shadows.
const AMBIENT: f32 = 0.12;

/// The direction of the sun (right, up, toward the camera), half its angle in degrees, and its irradiance.
const SUN: (Vec3, f32, [f32; 3]) = (Vec3::new(-0.6, 0.9, 0.6), 0.27, [3.1, 2.9, 2.6]);
/// The radiance of the sky around the sun.
const BLUE: [f32; 3] = [0.14, 0.19, 0.28];

/// Where a studio is built: around the subject, and turned toward the camera.
pub(super) struct Studio {
    middle: Vec3,
    /// Half the diagonal of the subject's bounds.
    reach: f32,
    /// The same for strands and meshes together.
    extent: f32,
    /// Height of the ground along `up`.
    ground: f32,
    right: Vec3,
    up: Vec3,
    /// The horizontal direction from the subject to the camera.
    back: Vec3,
}

impl Studio {
    /// A studio for the strands and meshes of a scene, seen by a camera.
    pub fn new(scene: &Scene, camera: &Camera) -> Self {
        let up = scene.up();
        let (low, high) = scene.bounds().unwrap_or((Vec3::ZERO, Vec3::ONE));
        let reach = (0.5 * (high - low).length()).max(f32::MIN_POSITIVE);
        let vertices = || scene.meshes.iter().flat_map(|mesh| &mesh.positions).copied();
        let (all_low, all_high) = (vertices().fold(low, Vec3::min), vertices().fold(high, Vec3::max));
        let extent = reach.max(0.5 * (all_high - all_low).length());
        // The right side of the picture is horizontal also for a camera that looks down.
        let right = camera.to_world.x_axis.truncate();
        let right = (right - up * right.dot(up)).normalize_or(up.any_orthonormal_vector());
        let ground = all_low.dot(up) - GAP * reach;
        Studio { middle: 0.5 * (low + high), reach, extent, ground, right, up, back: right.cross(up) }
    }

    /// Adds lights to a scene without lights. The camera does not see them. An image is left to [`Studio::image`].
    pub fn light(&self, scene: &mut Scene, light: &Lighting) {
        let dome = |radiance, texture| LightShape::Dome { radiance, texture, rotation: self.upright(), ground: None };
        let mut add = |group: &str, light| {
            scene.lights.push(Light { group: Some(group.to_owned()), visible: false, ..Light::from(light) });
        };
        match light {
            Lighting::Studio => {
                for panel in &PANELS {
                    add(panel.group, self.panel(panel));
                }
                add("ambient", dome([AMBIENT; 3], None));
            }
            Lighting::Sun => {
                let (toward, half_angle, irradiance) = SUN;
                let half_angle = half_angle.to_radians();
                add("sun", LightShape::Distant { direction: self.place(toward).normalize(), half_angle, irradiance });
                add("sky", dome(BLUE, None));
            }
            Lighting::Sky => {
                add("sky", dome([1.0; 3], Some(scene.textures.len())));
                scene.textures.push(overcast());
            }
            Lighting::Image(_) => {}
        }
    }

    /// Adds a dome with an image. The camera sees it.
    pub fn image(&self, scene: &mut Scene, image: Texture) {
        let texture = Some(scene.textures.len());
        scene.textures.push(image);
        let dome = LightShape::Dome { radiance: [1.0; 3], texture, rotation: self.upright(), ground: None };
        scene.lights.push(Light { group: Some("image".to_owned()), ..dome.into() });
    }

    /// The rotation of a dome whose top is up.
    fn upright(&self) -> Mat3 {
        if self.up == Vec3::Z { Mat3::from_rotation_x(FRAC_PI_2) } else { Mat3::IDENTITY }
    }

    /// A vector in world space from its components to the right, up, and toward the camera.
    fn place(&self, v: Vec3) -> Vec3 {
        self.right * v.x + self.up * v.y + self.back * v.z
    }

    fn panel(&self, panel: &Panel) -> LightShape {
        let z = self.place(panel.toward).normalize();
        let x = self.up.cross(z).normalize();
        let size = panel.size * self.reach;
        let from = self.middle + z * panel.distance * self.reach;
        let to_world =
            Mat4::from_cols((x * size).extend(0.0), (z.cross(x) * size).extend(0.0), z.extend(0.0), from.extend(1.0));
        LightShape::Rect { to_world, radiance: [panel.radiance; 3], texture: None }
    }

    /// Adds a ground that bends up to a wall behind the subject. It fills the picture of the camera, also above and
    /// below, so no edge is visible. `aspect` is width over height of the picture. A camera below the ground would not
    /// see the subject: then there is no ground.
    pub fn add_cyclorama(&self, scene: &mut Scene, camera: &Camera, aspect: f32) {
        let eye = camera.to_world.w_axis.truncate();
        let height = eye.dot(self.up) - self.ground;
        if height <= 0.0 {
            return;
        }
        let distance = (eye - self.middle).dot(self.back).max(0.0);
        let depth = distance.max(height) + WALL * self.extent;
        let [film_width, film_height] = camera.film(aspect);
        let half = depth * film_width.max(camera.film_width) + 6.0 * self.extent;
        let top = height + depth * film_height.max(camera.film_height) + 6.0 * self.extent;
        let bend = bend().map(|(p, n)| (p * BEND * self.extent + Vec2::new((WALL - BEND) * self.extent, 0.0), n));
        let wall = bend[PIECES].0;
        let start = [(Vec2::new(-(distance + depth), 0.0), Vec2::Y)];
        let end = [(Vec2::new(wall.x, top.max(wall.y + self.extent)), Vec2::NEG_X)];
        // Distances behind the subject and heights over the ground, from the front to the top of the wall.
        let profile: Vec<(Vec2, Vec2)> = start.into_iter().chain(bend).chain(end).collect();
        let middle = self.middle - self.up * self.middle.dot(self.up);
        let at =
            |p: Vec2, side: f32| middle - self.back * p.x + self.up * (self.ground + p.y) + self.right * (side * half);
        let side = |i: usize| 2.0 * i as f32 / COLUMNS as f32 - 1.0;
        let positions = profile.iter().flat_map(|(p, _)| (0..=COLUMNS).map(|i| at(*p, side(i)))).collect();
        let row = COLUMNS as u32 + 1;
        let quad = |a: u32| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]];
        let starts = (0..profile.len() as u32 - 1).flat_map(|k| (0..COLUMNS as u32).map(move |i| k * row + i));
        let triangles: Vec<[u32; 3]> = starts.flat_map(quad).collect();
        let normal = |vertex: u32| {
            let (_, n) = profile[(vertex / row) as usize];
            self.up * n.y - self.back * n.x
        };
        scene.meshes.push(Mesh {
            name: "cyclorama".to_owned(),
            normals: Some(triangles.iter().map(|t| t.map(normal)).collect()),
            positions,
            triangles,
            uv: None,
            moved: None,
            surface: scene.surfaces.len(),
        });
        scene.surfaces.push(Surface::diffuse("cyclorama", CYCLORAMA));
    }
}

/// Points and normals of the bend from the ground, at (0, 0), to the wall, at x = 1. The curvature begins and ends at
/// 0: a circular arc would have visible edges.
fn bend() -> [(Vec2, Vec2); PIECES + 1] {
    let angle = |t: f32| FRAC_PI_2 * t * t * (3.0 - 2.0 * t);
    let mut points = [(Vec2::ZERO, Vec2::Y); PIECES + 1];
    for i in 1..=PIECES {
        let along = Vec2::from_angle(angle((i as f32 - 0.5) / PIECES as f32));
        let (sin, cos) = angle(i as f32 / PIECES as f32).sin_cos();
        points[i] = (points[i - 1].0 + along, Vec2::new(-sin, cos));
    }
    let length = points[PIECES].0.x;
    points.map(|(p, normal)| (p / length, normal))
}

/// The CIE standard overcast sky: (1 + 2 sin θ) / 3 at the elevation θ. The ground is dark: the cyclorama reflects.
fn overcast() -> Texture {
    let [height, width] = SKY;
    let row = |y: usize| {
        let elevation = PI * (0.5 - (y as f32 + 0.5) / height as f32);
        if elevation > 0.0 { (1.0 + 2.0 * elevation.sin()) / 3.0 } else { 0.05 }
    };
    let pixels = (0..height).flat_map(|y| std::iter::repeat_n([row(y); 3], width)).collect();
    Texture { name: "overcast".to_owned(), width, height, pixels, wrap: [Wrap::Repeat, Wrap::Clamp] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::staging::stage;
    use crate::{Opened, Staging};
    use vellus::Fiber;
    use vellus_scene::{Basis, Look, Strands, Units, View};

    /// A tuft of strands around a point.
    fn tuft(z_up: bool, size: f32) -> Opened {
        let strand = |i: usize| {
            let (sin, cos) = (i as f32).sin_cos();
            [Vec3::new(sin, 0.2, cos), Vec3::new(1.5 * sin, 1.0 + 0.1 * cos, 1.5 * cos)]
                .map(|p| (if z_up { Vec3::new(p.x, -p.z, p.y) } else { p } * size).extend(0.01 * size))
        };
        let strands = Strands {
            name: "tuft".to_owned(),
            basis: Basis::Linear,
            starts: (0..=40).map(|i| 2 * i).collect(),
            points: (0..40).flat_map(strand).collect(),
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        };
        let units = Some(Units { meters_per_unit: 1.0, z_up });
        let looks = vec![Look::constant("hair", Fiber::hair())];
        Opened { scene: Scene { strands: vec![strands], looks, units, ..Scene::default() }, ..Opened::default() }
    }

    fn staged(mut opened: Opened, staging: &Staging) -> Opened {
        stage(&mut opened, staging, false, None).unwrap();
        assert_eq!(opened.scene.validate(), Ok(()));
        opened
    }

    /// The cyclorama fills the picture: every ray through the border of the picture meets it.
    #[test]
    fn no_edge_of_the_cyclorama_is_visible() {
        for (z_up, size, aspect) in [(false, 1.0, 1.5), (true, 1e-3, 2.4), (false, 1e4, 0.5)] {
            for view in ["35,10", "0,0", "-120,30", "180,80,0.5", "90,89", "10,5,4"] {
                let view: View = view.parse().unwrap();
                let staging = Staging { view: Some(view), ..Staging::new(aspect) };
                let scene = staged(tuft(z_up, size), &staging).scene;
                let camera = scene.camera.unwrap();
                let [mesh] = &scene.meshes[..] else { panic!("no cyclorama for {view:?}") };
                for i in 0..=40 {
                    let t = i as f32 / 20.0 - 1.0;
                    for (x, y) in [(t, -1.0), (t, 1.0), (-1.0, t), (1.0, t)] {
                        let local = Vec3::new(0.5 * x * camera.film_width, 0.5 * y * camera.film_height, -1.0);
                        let direction = camera.to_world.transform_vector3(local);
                        let eye = camera.to_world.w_axis.truncate();
                        assert!(meets(mesh, eye, direction), "{view:?} {aspect}: nothing at {x}, {y}");
                    }
                }
            }
        }
    }

    /// Whether a ray meets a mesh (Möller and Trumbore).
    fn meets(mesh: &Mesh, eye: Vec3, direction: Vec3) -> bool {
        mesh.triangles.iter().any(|t| {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let (e, f) = (b - a, c - a);
            let p = direction.cross(f);
            let scale = 1.0 / e.dot(p);
            let s = eye - a;
            let u = scale * s.dot(p);
            let q = s.cross(e);
            let v = scale * direction.dot(q);
            u >= -1e-5 && v >= -1e-5 && u + v <= 1.0 + 1e-5 && scale * f.dot(q) > 0.0
        })
    }

    #[test]
    fn the_camera_sees_no_light_and_the_subject_faces_all_of_them() {
        for z_up in [false, true] {
            let opened = staged(tuft(z_up, 1.0), &Staging::new(1.5));
            let scene = opened.scene;
            assert!(scene.lights.iter().all(|light| !light.visible));
            assert_eq!(scene.light_group_names(), ["key", "fill", "rim", "ambient"]);
            let (low, high) = scene.bounds().unwrap();
            let up = scene.up();
            for light in &scene.lights[..3] {
                let LightShape::Rect { to_world, .. } = light.shape else { panic!() };
                let from = to_world.w_axis.truncate();
                // It emits toward −z of its frame, and it is above the middle of the subject.
                assert!((0.5 * (low + high) - from).dot(to_world.z_axis.truncate()) < 0.0);
                assert!((from - 0.5 * (low + high)).dot(up) > 0.0);
            }
            let text = opened.staged.unwrap();
            let front = if z_up { "-y" } else { "+z" };
            assert!(text.contains("no camera") && text.contains(&format!("front, {front}")), "{text}");
            assert!(text.contains("no lights: the light is studio") && opened.is_metered, "{text}");
        }
    }

    /// The ground is below the subject, and normals point to the camera.
    #[test]
    fn the_ground_is_below_the_subject_and_faces_it() {
        let scene = staged(tuft(true, 2.0), &Staging::new(1.5)).scene;
        let (low, _) = Scene { meshes: Vec::new(), ..scene.clone() }.bounds().unwrap();
        let mesh = &scene.meshes[0];
        let ground = mesh.positions.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
        assert!(ground < low.z && ground > low.z - 0.02);
        let eye = scene.camera.unwrap().to_world.w_axis.truncate();
        for (t, normals) in mesh.triangles.iter().zip(mesh.normals.as_ref().unwrap()) {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let flat = (b - a).cross(c - a);
            assert!(flat.dot(eye - a) > 0.0 && normals.iter().all(|n| n.dot(flat) > 0.0));
        }
        // From below there is no ground, but a grey background.
        let below = Staging { view: Some("0,-60".parse().unwrap()), ..Staging::new(1.5) };
        let scene = staged(tuft(true, 2.0), &below).scene;
        assert!(scene.meshes.is_empty() && scene.background.is_some());
    }

    #[test]
    fn what_a_scene_has_stays_unless_an_option_replaces_it() {
        let mut opened = tuft(false, 1.0);
        let sun = Light::from(LightShape::Distant { direction: Vec3::Y, half_angle: 0.0, irradiance: [1.0; 3] });
        opened.scene.lights = vec![sun.clone()];
        opened.scene.camera = opened.scene.framing(1.5);
        let own = opened.scene.clone();
        let kept = staged(opened.clone(), &Staging::new(1.5));
        assert_eq!((kept.scene, kept.staged, kept.is_metered), (own.clone(), None, false));
        let sky = Staging { light: Some(Lighting::Sky), ..Staging::new(1.5) };
        let lit = staged(opened.clone(), &sky).scene;
        assert!(lit.lights.len() == 1 && lit.lights[0] != sun && lit.camera == own.camera && lit.meshes.len() == 1);
        let seen = Staging { view: Some(View { zoom: 2.0, ..View::default() }), ..Staging::new(1.5) };
        let seen = staged(opened, &seen).scene;
        assert!(seen.lights == own.lights && seen.camera != own.camera && seen.meshes.is_empty());
        let height = own.camera.unwrap().film_height;
        assert!((seen.camera.unwrap().film_height - 0.5 * height).abs() < 1e-6);
    }
}
