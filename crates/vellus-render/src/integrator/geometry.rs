//! The parts of a scene that paths use, except for the scattering models of fibres.

use crate::geometry::curves::{CurveHit, Curves};
use crate::geometry::triangles::{TriangleHit, Triangles};
use crate::integrator::view::View;
use crate::light::Lights;
use crate::light::background::Background;
use crate::shading::colors;
use crate::shading::surface::Scatter;
use glam::{Vec2, Vec3};
use vellus::{CoatColors, Fiber};
use vellus_scene::{Basis, Look, Strands, Surface, Texture, Values};

/// Strands, meshes, lights, camera, materials and textures, prepared for rays.
pub struct Geometry {
    pub curves: Curves,
    pub triangles: Triangles,
    pub lights: Lights,
    pub background: Option<Background>,
    pub view: View,
    /// Whether anything moves while the shutter is open.
    pub moves: bool,
    /// The group of each light.
    pub groups: Vec<usize>,
    /// The group of the light that meshes emit.
    pub emission_group: usize,
    /// The number of strands in the sets before each set.
    pub strands_before: Vec<u32>,
    pub looks: Vec<Look>,
    /// For each set of strands, the table of its colours, if it needs one.
    pub colors: Vec<Option<CoatColors>>,
    pub surfaces: Vec<Surface>,
    pub textures: Vec<Texture>,
}

impl Geometry {
    /// Replaces the camera.
    pub fn set_view(&mut self, view: View) {
        self.view = view;
        self.moves = self.curves.moves() || self.triangles.moves() || self.view.moves();
    }

    /// Texture coordinates at the root of the strand that was hit. 0 if the strands have none.
    pub fn root_uv(&self, hit: &CurveHit) -> Vec2 {
        self.curves.strands()[hit.set].root_uv.as_ref().map_or(Vec2::ZERO, |uv| uv[hit.strand])
    }

    /// The number of the strand that was hit, from 1 over all strands of the scene.
    pub fn strand_number(&self, hit: &CurveHit) -> u32 {
        self.strands_before[hit.set] + hit.strand as u32 + 1
    }

    /// The fibre at a hit. Every value is clamped to its range.
    pub fn fiber(&self, hit: &CurveHit) -> Fiber {
        let strands = &self.curves.strands()[hit.set];
        let look = &self.looks[strands.look];
        let mut fiber = look.fiber;
        let table = self.colors[hit.set].as_ref();
        let uv = self.root_uv(hit);
        for (parameter, value) in &look.textured {
            let texel = self.textures[value.texture].at(uv);
            // Textures have angles in degrees, like files.
            let product = std::array::from_fn(|c| parameter.unit().to_stored(texel[c] * value.scale[c]));
            colors::set(&mut fiber, *parameter, product, table);
        }
        for (parameter, values) in &strands.varying {
            let value = match values {
                Values::Constant(value) => *value,
                Values::PerStrand(values) => values[hit.strand],
                Values::PerPoint(values) => along(strands, values, hit),
            };
            colors::set(&mut fiber, *parameter, value, table);
        }
        fiber
    }

    /// The scattering of a mesh at a hit, and its emission.
    pub fn scatter(&self, hit: &TriangleHit) -> (Scatter, [f32; 3]) {
        let surface = &self.surfaces[self.triangles.meshes()[hit.mesh].surface];
        let texel = surface.color.texture.map_or([1.0; 3], |t| self.textures[t].at(hit.uv));
        let color = std::array::from_fn(|c| (surface.color.color[c] * texel[c]).clamp(0.0, 1.0));
        (Scatter::new(color, surface.roughness, surface.metallic, surface.ior), surface.emission)
    }

    /// The motion of a point in the picture while the shutter is open, in pixels to the right and up. `movement` is its
    /// motion in the world.
    pub fn motion(&self, size: [usize; 2], now: Vec3, movement: Vec3, time: f32) -> [f32; 2] {
        let open = self.view.seen(size, now - movement * time, 0.0);
        let closed = self.view.seen(size, now + movement * (1.0 - time), 1.0);
        open.zip(closed).map_or([0.0; 2], |(open, closed)| [closed.x - open.x, open.y - closed.y])
    }
}

/// A value per control point at a hit: interpolated linearly between the two control points around it.
fn along(strands: &Strands, values: &[[f32; 3]], hit: &CurveHit) -> [f32; 3] {
    let (first, last) = match strands.basis {
        Basis::Linear => (hit.point, hit.point + 1),
        Basis::Bezier => (hit.point, hit.point + 3),
        Basis::BSpline | Basis::CatmullRom => (hit.point + 1, hit.point + 2),
    };
    let u = hit.entry.u;
    std::array::from_fn(|c| values[first][c] + u * (values[last][c] - values[first][c]))
}
