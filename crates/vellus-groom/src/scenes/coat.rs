//! Fur on a body, and its skin.

use crate::body::Body;
use crate::error::Error;
use crate::grow::grow;
use crate::polygonize::polygonize;
use crate::roots::Site;
use crate::scenes::noise::noise;
use crate::settings::{Draw, GrowSettings, Maps};
use glam::{Vec2, Vec3};
use vellus::{Color, Fiber};
use vellus_scene::{Look, Mesh, Parameter, Scene, Strands, Surface, Texture, Tint, Wrap};

/// Divisor of the number of strands in a small scene.
pub(super) const FEWER: usize = 40;
/// Factor of the width of strands in a small scene. It is smaller than the divisor, so that strands still look like
/// strands.
const WIDER: f32 = 6.0;
/// The largest eumelanin and pheomelanin of the texture of the skin, as square roots.
const MOST: f32 = 8.0;

/// A coat of fur.
pub(super) struct Coat<'a> {
    pub body: &'a Body,
    /// Width of the cells of the mesh at full size.
    pub step: f32,
    /// Width of the transition between the coats of two parts.
    pub soft: f32,
    pub settings: GrowSettings,
    pub fiber: Fiber,
    /// Concentrations of eumelanin and pheomelanin that give the colour in a hair without medulla.
    pub melanin: &'a (dyn Fn(Vec3, &Draw) -> [f32; 2] + Sync),
    /// Size of the patches in which the direction and length of the fur deviate.
    pub patch: f32,
    /// Spheres without fur, such as eyes and noses.
    pub bare: Vec<(Vec3, f32)>,
    /// Brightness of the skin relative to fur of the same colour.
    pub skin: f32,
}

impl Coat<'_> {
    /// Adds skin and fur to a scene.
    pub fn add(self, scene: &mut Scene, small: bool) -> Result<(), Error> {
        let look = scene.looks.len();
        let mesh = self.skin(scene, small);
        let strands = self.fur(&mesh, small)?;
        scene.meshes.push(mesh);
        scene.looks.push(Look::constant(self.settings.name.clone(), self.fiber));
        scene.strands.push(Strands { look, ..strands });
        Ok(())
    }

    fn skin(&self, scene: &mut Scene, small: bool) -> Mesh {
        let average = Draw { guard: false, random: 0.5 };
        let uv = |p: Vec3| {
            let [eumelanin, pheomelanin] = (self.melanin)(p, &average);
            // Half a texel inside the border, so that the texture does not repeat.
            let to_texture = |c: f32| (c / MOST).sqrt().clamp(0.5 / 32.0, 31.5 / 32.0);
            Vec2::new(to_texture(eumelanin), to_texture(pheomelanin))
        };
        let step = if small { 1.4 * self.step } else { self.step };
        let mut mesh = polygonize(self.body, step, &format!("{} skin", self.settings.name), &uv);
        mesh.surface = scene.surfaces.len();
        scene.surfaces.push(Surface {
            color: Tint { color: [self.skin; 3], texture: Some(scene.textures.len()) },
            ..Surface::diffuse(mesh.name.clone(), [0.0; 3])
        });
        let texel = |i: usize| {
            let concentration = |x: usize| ((x as f32 + 0.5) / 32.0).powi(2) * MOST;
            let (eumelanin, pheomelanin) = (concentration(i % 32), concentration(31 - i / 32));
            let sigma = absorption(eumelanin, pheomelanin);
            // The inverse of Chiang et al. 2016, Eq. 9, for a smooth hair.
            sigma.map(|sigma| (-5.9 * sigma.sqrt()).exp())
        };
        let pixels = (0..32 * 32).map(texel).collect();
        scene.textures.push(Texture {
            name: mesh.name.clone(),
            width: 32,
            height: 32,
            pixels,
            wrap: [Wrap::Repeat; 2],
        });
        mesh
    }

    fn fur(&self, mesh: &Mesh, small: bool) -> Result<Strands, Error> {
        let coat = |site: &Site| {
            let (way, length) = self.body.coat(site.position, self.soft);
            // Fur is in order on faces and feet, where it is short.
            let uneven = smoothstep(0.3, 1.5, length / self.settings.length);
            let at = |offset: f32| noise(site.position / self.patch + Vec3::splat(offset));
            let turn = 0.4 * uneven * way.length() * Vec3::new(at(0.0), at(5.0), at(11.0));
            (way + turn, length * (1.0 + 0.2 * uneven * at(17.0)))
        };
        // Short fur is denser, so that coverage is the same. Parts with almost no length are bare.
        let density = |site: &Site| {
            let bare = self.bare.iter().any(|(center, radius)| site.position.distance(*center) < *radius);
            let length = coat(site).1;
            if bare { 0.0 } else { smoothstep(0.0, 0.08, length) * length.max(0.1).powf(-0.8) }
        };
        // With a wider medulla, light passes through less cortex. The same colour needs more pigment.
        let pigment = 1.0 / (1.0 - self.fiber.kappa);
        let color = |site: &Site, draw: &Draw| {
            let [eumelanin, pheomelanin] = (self.melanin)(site.position, draw);
            absorption(eumelanin * pigment, pheomelanin * pigment)
        };
        // Animals stand on the ground y = 0, which fur must not enter either.
        let distance = |p: Vec3| self.body.distance(p).min(p.y);
        let white = self.fiber.sigma_ca == [0.0; 3] && self.fiber.sigma_ma == [0.0; 3];
        let maps = Maps {
            density: &density,
            length: &|site| coat(site).1,
            comb: &|site| coat(site).0,
            color: if white { None } else { Some((Parameter::SigmaCa, &color)) },
            distance: Some(&distance),
        };
        grow(mesh, &shrunk(self.settings.clone(), small), &maps)
    }
}

/// The absorption of two concentrations in the cortex, RGB. The medulla keeps its own.
fn absorption(eumelanin: f32, pheomelanin: f32) -> [f32; 3] {
    let pigmented = Fiber::hair().with_color(Color::Melanin { eumelanin, pheomelanin });
    pigmented.map(|fiber| fiber.sigma_ca).unwrap_or_default()
}

/// The settings of a small scene.
fn shrunk(mut settings: GrowSettings, small: bool) -> GrowSettings {
    if small {
        settings.count /= FEWER;
        settings.radius = settings.radius.map(|r| r * WIDER);
        settings.clump.strands /= 4;
    }
    settings
}

/// A smooth step: 0 below `a`, 1 above `b`.
pub(super) fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Interpolates between two colours.
pub(super) fn mix(a: [f32; 2], b: [f32; 2], t: f32) -> [f32; 2] {
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

/// Distance of a point to a segment.
pub(super) fn to_segment(p: Vec3, a: [f32; 3], b: [f32; 3]) -> f32 {
    let (a, b) = (Vec3::from(a), Vec3::from(b));
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t))
}
