//! A scene made ready for rays.

use crate::film::Layer;
use crate::film::layout::Layout;
use crate::geometry::curves::{CurveHit, Curves};
use crate::geometry::triangles::{TriangleHit, Triangles};
use crate::integrator::view::View;
use crate::light::Lights;
use crate::shading::fibers::{Fibers, Trace};
use crate::shading::surface::Scatter;
use glam::Vec2;
use vellus::{Bcsdf, Fiber, Model};
use vellus_scene::{Basis, Camera, Error, Look, Scene, Strands, Surface, Texture, Values};

/// What rays need of a scene.
pub struct World {
    /// All strands.
    pub curves: Curves,
    /// All meshes.
    pub triangles: Triangles,
    pub(crate) lights: Lights,
    pub(crate) view: View,
    /// Does anything move while the shutter is open?
    pub(crate) moves: bool,
    /// Names of the light groups, and the group of each light and of what meshes emit.
    group_names: Vec<String>,
    pub(crate) groups: Vec<usize>,
    pub(crate) glow: usize,
    /// Strands in the sets before each.
    strands_before: Vec<u32>,
    looks: Vec<Look>,
    /// How they scatter.
    pub(crate) fibers: Box<dyn Trace>,
    surfaces: Vec<Surface>,
    textures: Vec<Texture>,
}

impl World {
    /// Checks a scene and builds its hierarchies. Without lights it is lit by a white dome, without a camera seen as
    /// [`Scene::framing`] has it, for pictures of 3:2.
    ///
    /// # Errors
    /// [`vellus_scene::Error`]: what [`Scene::validate`] finds, or that there is nothing to see.
    pub fn new(scene: Scene) -> Result<Self, Error> {
        scene.validate()?;
        let camera = scene.camera.or_else(|| scene.framing(1.5));
        let (Some((low, high)), Some(camera)) = (scene.bounds(), camera) else {
            let what = "it has neither strands nor meshes: there is nothing to render".to_owned();
            return Err(Error::Invalid { place: "scene".to_owned(), what });
        };
        let reach = (0.5 * (high - low).length()).max(f32::MIN_POSITIVE);
        let white = vellus_scene::Light::Dome {
            radiance: [1.0; 3],
            texture: None,
            rotation: glam::Mat3::IDENTITY,
            ground: None,
        };
        let names = scene.light_group_names();
        let glows = scene.surfaces.iter().any(|s| s.emission.iter().any(|&e| e > 0.0));
        let lights = if scene.lights.is_empty() { vec![white] } else { scene.lights };
        let names = if names.is_empty() { vec!["dome".to_owned()] } else { names };
        let mut group_names: Vec<String> = Vec::new();
        let mut group = |name: &str| {
            group_names.iter().position(|n| n == name).unwrap_or_else(|| {
                group_names.push(name.to_owned());
                group_names.len() - 1
            })
        };
        let groups = names.iter().map(|name| group(name)).collect();
        let glow = if glows { group("emission") } else { 0 };
        let strands_before = scene.strands.iter().scan(0, |n, s| Some(std::mem::replace(n, *n + s.len() as u32)));
        let strands_before = strands_before.collect();
        let lights = Lights::new(&lights, &scene.textures, reach);
        let fibers = Box::new(Fibers::new(&scene.strands, &scene.looks, Bcsdf::new)?);
        let (curves, triangles, view) = (Curves::new(scene.strands), Triangles::new(scene.meshes), View::new(camera));
        Ok(World {
            moves: curves.moves() || triangles.moves() || view.moves(),
            curves,
            triangles,
            lights,
            view,
            group_names,
            groups,
            glow,
            strands_before,
            looks: scene.looks,
            fibers,
            surfaces: scene.surfaces,
            textures: scene.textures,
        })
    }

    /// Has the strands scatter by another reflectance model, which `make` makes of each set's fibre; where that varies along the
    /// strands, [`Model::with_fiber`] does at each hit. Of a model that knows one [`Field`](vellus::Field) only,
    /// [`Mode`](crate::Mode) chooses nothing.
    ///
    /// # Errors
    /// What `make` says of a fibre; the world is as before.
    pub fn set_model<M: Model + Send + 'static>(
        &mut self,
        make: impl Fn(&Fiber) -> Result<M, vellus::Error>,
    ) -> Result<(), Error> {
        self.fibers = Box::new(Fibers::new(self.curves.strands(), &self.looks, make)?);
        Ok(())
    }

    /// Sees the scene from elsewhere.
    pub fn set_camera(&mut self, camera: Camera) {
        self.view = View::new(camera);
        self.moves = self.curves.moves() || self.triangles.moves() || self.view.moves();
    }

    /// What a film with these layers keeps of a pixel.
    pub fn layout(&self, layers: &[Layer]) -> Layout {
        Layout::new(layers, &self.group_names)
    }

    /// Where the strand that was hit is rooted; 0 where its groom does not say.
    pub(crate) fn root_uv(&self, hit: &CurveHit) -> Vec2 {
        self.curves.strands()[hit.set].root_uv.as_ref().map_or(Vec2::ZERO, |uv| uv[hit.strand])
    }

    /// The number of the strand that was hit, from 1 over all of the scene.
    pub(crate) fn strand_number(&self, hit: &CurveHit) -> u32 {
        self.strands_before[hit.set] + hit.strand as u32 + 1
    }

    /// The fibre at a hit, every value within its range.
    pub(crate) fn fiber(&self, hit: &CurveHit) -> Fiber {
        let strands = &self.curves.strands()[hit.set];
        let look = &self.looks[strands.look];
        let mut fiber = look.fiber;
        let uv = self.root_uv(hit);
        for (parameter, value) in &look.textured {
            let texel = self.textures[value.texture].at(uv);
            // A texture gives angles in degrees, as files do.
            let product = std::array::from_fn(|c| parameter.unit().to_stored(texel[c] * value.scale[c]));
            parameter.set_nearest(&mut fiber, product);
        }
        for (parameter, values) in &strands.varying {
            let value = match values {
                Values::Constant(value) => *value,
                Values::PerStrand(values) => values[hit.strand],
                Values::PerPoint(values) => along(strands, values, hit),
            };
            parameter.set_nearest(&mut fiber, value);
        }
        fiber
    }

    /// The scattering of a mesh.
    pub(crate) fn scatter(&self, hit: &TriangleHit) -> (Scatter, [f32; 3]) {
        let surface = &self.surfaces[self.triangles.meshes()[hit.mesh].surface];
        let texel = surface.color.texture.map_or([1.0; 3], |t| self.textures[t].at(hit.uv));
        let color = std::array::from_fn(|c| (surface.color.color[c] * texel[c]).clamp(0.0, 1.0));
        (Scatter::new(color, surface.roughness, surface.metallic, surface.ior), surface.emission)
    }
}

/// A value given at the control points, at the hit: linear between the two it lies between.
fn along(strands: &Strands, values: &[[f32; 3]], hit: &CurveHit) -> [f32; 3] {
    let (first, last) = match strands.basis {
        Basis::Linear => (hit.point, hit.point + 1),
        Basis::Bezier => (hit.point, hit.point + 3),
        Basis::BSpline | Basis::CatmullRom => (hit.point + 1, hit.point + 2),
    };
    let u = hit.entry.u;
    std::array::from_fn(|c| values[first][c] + u * (values[last][c] - values[first][c]))
}
