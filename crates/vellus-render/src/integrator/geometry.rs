//! The parts of a scene that paths use, except for the scattering models of fibres.

use crate::geometry::curves::{CurveHit, Curves};
use crate::geometry::flat::ends;
use crate::geometry::instances::{Hit, Instances};
use crate::geometry::ray::Ray;
use crate::geometry::triangles::{TriangleHit, Triangles};
use crate::integrator::view::View;
use crate::light::Lights;
use crate::light::background::Background;
use crate::shading::colors;
use crate::shading::surface::Scatter;
use crate::shown::Reflectance;
use glam::{Vec2, Vec3};
use vellus::{CoatColors, Fiber, Parameter};
use vellus_scene::{Look, Mesh, Strands, Surface, Texture, Values};

/// Strands, meshes, lights, camera, materials and textures, prepared for rays.
pub struct Geometry {
    pub curves: Curves,
    pub triangles: Triangles,
    pub instances: Instances,
    pub lights: Lights,
    pub background: Option<Background>,
    pub view: View,
    /// Whether anything but the camera moves while the shutter is open.
    pub things_move: bool,
    /// Whether paths see different versions of some instances.
    pub is_simplified: bool,
    /// The group of each light.
    pub groups: Vec<usize>,
    /// The group of the light that meshes emit.
    pub emission_group: usize,
    /// The number of strands in the sets before each set. The sets of a prototype are counted from 0.
    pub strands_before: Vec<u32>,
    pub looks: Vec<Look>,
    /// What a reflectance means for each look.
    pub reflectance: Reflectance,
    /// For each set of strands, the table of its colours, if it needs one.
    pub colors: Vec<Option<CoatColors>>,
    pub surfaces: Vec<Surface>,
    pub textures: Vec<Texture>,
}

impl Geometry {
    /// Gives the strands the sections of their looks.
    pub fn update_sections(&mut self) {
        let of_look = |look: usize| self.looks[look].fiber.aspect_ratio;
        self.curves.set_aspect_ratios(&of_look);
        self.instances.set_aspect_ratios(&of_look);
    }

    /// Finds out again whether anything but the camera moves.
    pub fn update_motion(&mut self) {
        self.things_move = self.curves.moves() || self.triangles.moves() || self.instances.moves();
    }

    /// Whether anything moves while the shutter is open.
    pub fn moves(&self) -> bool {
        self.things_move || self.view.moves()
    }

    /// All sets of strands, in the order of [`CurveHit::set`].
    pub fn all_strands(&self) -> impl Iterator<Item = &Strands> {
        self.curves.strands().iter().chain(self.instances.strands())
    }

    /// All meshes, in the order of [`TriangleHit::mesh`].
    pub fn all_meshes(&self) -> impl Iterator<Item = &Mesh> {
        self.triangles.meshes().iter().chain(self.instances.meshes())
    }

    /// Spheres around the fur, centres and radii: one around the strands in world space, and one around each of at most
    /// `most` instances.
    pub fn spheres(&self, most: usize) -> Vec<(Vec3, f32)> {
        let (instances, count) = (&self.instances, self.instances.len().min(most));
        let placed = (0..count).filter_map(|i| instances.fur_sphere(i * instances.len() / count));
        self.curves.sphere().into_iter().chain(placed).collect()
    }

    /// A sphere around the fur, or around all meshes if there is none: its centre and radius.
    pub fn sphere(&self) -> Option<(Vec3, f32)> {
        let spheres = self.spheres(usize::MAX);
        if let [only] = spheres[..] {
            return Some(only);
        }
        let corners = |(centre, radius)| [centre - Vec3::splat(radius), centre + Vec3::splat(radius)];
        let mut points: Vec<Vec3> = spheres.into_iter().flat_map(corners).collect();
        if points.is_empty() {
            points.extend(self.triangles.meshes().iter().flat_map(|mesh| &mesh.positions));
        }
        let low = points.iter().copied().reduce(Vec3::min)?;
        let high = points.iter().copied().reduce(Vec3::max)?;
        Some((0.5 * (low + high), (0.5 * (high - low).length()).max(f32::MIN_POSITIVE)))
    }

    /// The index of what was hit: sets of strands first, then meshes.
    pub fn thing(&self, hit: &Hit) -> usize {
        match hit {
            Hit::Curve(hit) => hit.set,
            Hit::Triangle(hit) => self.mesh_thing(hit),
        }
    }

    /// The index of the mesh that was hit, after all sets of strands.
    pub fn mesh_thing(&self, hit: &TriangleHit) -> usize {
        self.colors.len() + hit.mesh
    }

    /// A number for what scatters alike at a hit: the look of a strand, or a number after those of all looks for a
    /// mesh. Things that other lights reach have other numbers.
    pub fn alike(&self, hit: &Hit) -> u32 {
        let alike = match hit {
            Hit::Curve(hit) => self.set(hit).look as u32,
            Hit::Triangle(hit) => (self.looks.len() + hit.mesh) as u32,
        };
        // The classes of lights are few. An odd factor keeps their numbers apart.
        alike.wrapping_add((self.lights.class(self.thing(hit)) as u32).wrapping_mul(0x9e37_79b1))
    }

    /// The nearest hit of a ray.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        let triangle = self.triangles.intersect(ray);
        let curve = self.curves.intersect(&Ray { t_max: triangle.map_or(ray.t_max, |hit| hit.t), ..*ray });
        let t = curve.map(|hit| hit.entry.t).or(triangle.map(|hit| hit.t));
        let own = curve.map(Hit::Curve).or(triangle.map(Hit::Triangle));
        if self.instances.is_empty() {
            return own;
        }
        self.instances.intersect(&Ray { t_max: t.unwrap_or(ray.t_max), ..*ray }).or(own)
    }

    /// Whether a ray hits anything within its length.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.curves.occluded(ray)
            || self.triangles.occluded(ray)
            || (!self.instances.is_empty() && self.instances.occluded(ray))
    }

    /// Whether something that casts shadows in the light of a lamp blocks a ray within its length.
    pub fn shadows(&self, ray: &Ray, light: usize) -> bool {
        let Some(casts) = self.lights.casters(light) else { return self.occluded(ray) };
        let meshes = |mesh| casts[self.colors.len() + mesh];
        casts.iter().any(|&casts| casts)
            && (self.curves.occluded_by(ray, |set| casts[set])
                || self.triangles.occluded_by(ray, meshes)
                || (!self.instances.is_empty() && self.instances.occluded_by(ray, |set| casts[set], meshes)))
    }

    /// The set of strands that was hit.
    fn set(&self, hit: &CurveHit) -> &Strands {
        if hit.instance.is_some() { self.instances.set(hit.set) } else { &self.curves.strands()[hit.set] }
    }

    /// The motion of the fibre's axis at a hit while the shutter is open.
    pub fn movement(&self, hit: &CurveHit) -> Vec3 {
        hit.instance.map_or_else(|| self.curves.movement(hit), |instance| self.instances.movement(instance, hit))
    }

    /// Texture coordinates at the root of the strand that was hit. 0 if the strands have none.
    pub fn root_uv(&self, hit: &CurveHit) -> Vec2 {
        self.set(hit).root_uv.as_ref().map_or(Vec2::ZERO, |uv| uv[hit.strand])
    }

    /// The number of the strand that was hit, from 1 over all strands of the scene and of its instances, modulo 2³².
    pub fn strand_number(&self, hit: &CurveHit) -> u32 {
        let before = hit.instance.map_or(0, |instance| self.instances.strands_before(instance));
        before.wrapping_add(self.strands_before[hit.set]).wrapping_add(hit.strand as u32 + 1)
    }

    /// The fibre at a hit. Every value is clamped to its range.
    pub fn fiber(&self, hit: &CurveHit) -> Fiber {
        let strands = self.set(hit);
        self.varied(hit.set, strands, hit.strand, |values| along(strands, values, hit))
    }

    /// The fibre of a strand at one of its control points.
    pub fn fiber_of_point(&self, set: usize, strands: &Strands, strand: usize, point: usize) -> Fiber {
        self.varied(set, strands, strand, |values| values[point])
    }

    /// The fibre of a strand. `at_point` selects among the values of all control points.
    fn varied(
        &self,
        set: usize,
        strands: &Strands,
        strand: usize,
        at_point: impl Fn(&[[f32; 3]]) -> [f32; 3],
    ) -> Fiber {
        let look = &self.looks[strands.look];
        let mut fiber = look.fiber;
        let table = self.colors[set].as_ref();
        let mut replace = |parameter: Parameter, value| {
            let value = match parameter {
                Parameter::Reflectance => self.reflectance.dense(strands.look, value),
                _ => value,
            };
            colors::set(&mut fiber, parameter, value, table);
        };
        let uv = strands.root_uv.as_ref().map_or(Vec2::ZERO, |uv| uv[strand]);
        for (parameter, value) in &look.textured {
            let texel = self.textures[value.texture].at(uv);
            // Textures have angles in degrees, like files.
            let product = std::array::from_fn(|c| parameter.unit().to_stored(texel[c] * value.scale[c]));
            replace(*parameter, product);
        }
        for (parameter, values) in &strands.varying {
            let value = match values {
                Values::Constant(value) => *value,
                Values::PerStrand(values) => values[strand],
                Values::PerPoint(values) => at_point(values),
            };
            replace(*parameter, value);
        }
        if matches!(self.reflectance, Reflectance::Fixed(_)) {
            fiber.wet = 0.0;
        }
        fiber
    }

    /// The scattering of a mesh at a hit, and its emission.
    pub fn scatter(&self, hit: &TriangleHit) -> (Scatter, [f32; 3]) {
        let own = self.triangles.meshes();
        let mesh = own.get(hit.mesh).unwrap_or_else(|| self.instances.mesh(hit.mesh));
        let surface = &self.surfaces[mesh.surface];
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
    let (first, last) = ends(strands.basis, hit.point);
    let u = hit.entry.u;
    std::array::from_fn(|c| values[first][c] + u * (values[last][c] - values[first][c]))
}
