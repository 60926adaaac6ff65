//! A scene prepared for rays.

use crate::film::Layer;
use crate::film::layout::Layout;
use crate::geometry::curves::Curves;
use crate::geometry::details::Details;
use crate::geometry::instances::Instances;
use crate::geometry::triangles::Triangles;
use crate::integrator::geometry::Geometry;
use crate::integrator::path::Trace;
use crate::integrator::view::View;
use crate::light::background::Background;
use crate::light::{Lighting, Lights};
use crate::shading::colors;
use crate::shading::fibers::Fibers;
use crate::shown::{self, Reflectance, Shown};
use std::sync::Arc;
use vellus::{Bcsdf, Fiber, Model};
use vellus_scene::{Camera, Error, LightShape, ReflectanceOf, Scene, Strands};

/// A scene prepared for rays: hierarchies over its strands and meshes, distributions over its lights, and a reflectance
/// model for each of its fibres.
///
/// One world can be rendered from many threads, and with any number of [`Settings`](crate::Settings).
pub struct World {
    pub(crate) geometry: Geometry,
    /// The names of the light groups.
    group_names: Vec<String>,
    pub(crate) fibers: Box<dyn Trace>,
    pub(crate) lighting: Lighting,
    /// Whether the coats show the reflectances that are asked for.
    shows: bool,
}

impl std::fmt::Debug for World {
    /// Prints counts instead of arrays.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (segments, meshes) = (self.segments(), self.triangles().meshes().len());
        f.debug_struct("World").field("segments", &segments).field("meshes", &meshes).finish_non_exhaustive()
    }
}

impl World {
    /// Prepares a scene with [`Bcsdf`] as the reflectance model of its fibres.
    ///
    /// A scene without lights gets a white dome of radiance 1. A scene without a camera gets [`Scene::framing`] for
    /// pictures of 3:2.
    ///
    /// # Errors
    /// [`vellus_scene::Error`] if [`Scene::validate`] finds the scene invalid, if it has neither strands nor meshes,
    /// or if the model refuses a fibre.
    pub fn new(scene: Scene) -> Result<Self, Error> {
        World::with_model(scene, Bcsdf::new)
    }

    /// Prepares a scene with another reflectance model for its fibres.
    ///
    /// `make` builds the model of each look's fibre. Where parameters vary along the strands, [`Model::with_fiber`]
    /// adapts it at each hit. A model that knows only one [`WindowSupport`](vellus::WindowSupport) ignores
    /// [`Settings::mode`](crate::Settings::mode).
    ///
    /// # Errors
    /// As [`World::new`].
    pub fn with_model<M: Model + Send + 'static>(
        scene: Scene,
        make: impl Fn(&Fiber) -> Result<M, vellus::Error>,
    ) -> Result<Self, Error> {
        scene.validate()?;
        let camera = scene.camera.or_else(|| scene.framing(1.5));
        let (Some((low, high)), Some(camera)) = (scene.bounds(), camera) else {
            let what = "it has neither strands nor meshes: there is nothing to render".to_owned();
            return Err(Error::Invalid { place: "scene".to_owned(), what });
        };
        let radius = (0.5 * (high - low).length()).max(f32::MIN_POSITIVE);
        let groups = LightGroups::new(&scene);
        let white =
            LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: glam::Mat3::IDENTITY, ground: None };
        let sets = std::iter::once(&scene.strands).chain(scene.prototypes.iter().map(|prototype| &prototype.strands));
        let before = |sets: &Vec<Strands>| {
            let count = |n: &mut u32, s: &Strands| Some(std::mem::replace(n, n.wrapping_add(s.len() as u32)));
            sets.iter().scan(0, count).collect::<Vec<u32>>()
        };
        let strands_before = sets.flat_map(before).collect();
        let colors = scene.all_strands().map(|strands| colors::table(strands, &scene.looks[strands.look])).collect();
        let own = [scene.strands.len(), scene.meshes.len()];
        let count = scene.strands.iter().fold(0u32, |n, set| n.wrapping_add(set.len() as u32));
        let things = if scene.is_linked() { scene.object_names().map(str::to_owned).collect() } else { Vec::new() };
        let lighting = Lighting { things, reach: radius };
        let lights = if scene.lights.is_empty() { vec![white.into()] } else { scene.lights };
        let mut instances = Instances::new(scene.prototypes, &scene.instances, own, count);
        let lights = Lights::new(&lights, &lighting, &scene.textures);
        let (curves, view) = (Curves::new(scene.strands), View::new(camera));
        let mut triangles = Triangles::new(scene.meshes);
        let details = Arc::new(Details::new(&scene.surfaces, &scene.textures));
        triangles.detail(&details);
        instances.detail(&details);
        let mut geometry = Geometry {
            is_simplified: instances.is_simplified(),
            things_move: curves.moves() || triangles.moves() || instances.moves(),
            curves,
            triangles,
            instances,
            lights,
            background: scene.background.map(|tint| Background { tint, group: groups.of_background }),
            view,
            groups: groups.of_lights,
            emission_group: groups.of_emission,
            strands_before,
            looks: scene.looks,
            reflectance: Reflectance::Dense,
            colors,
            surfaces: scene.surfaces,
            textures: scene.textures,
        };
        geometry.update_sections();
        let shows = scene.reflectance == ReflectanceOf::Groom;
        shown::resolve(&mut geometry, shows);
        let fibers = Box::new(Fibers::new(geometry.all_strands(), &geometry.looks, make)?);
        Ok(World { geometry, group_names: groups.names, fibers, lighting, shows })
    }

    /// Replaces the reflectance model of the fibres: see [`World::with_model`].
    ///
    /// # Errors
    /// [`vellus_scene::Error`] if `make` refuses a fibre. The world is then as before.
    pub fn set_model<M: Model + Send + 'static>(
        &mut self,
        make: impl Fn(&Fiber) -> Result<M, vellus::Error>,
    ) -> Result<(), Error> {
        self.fibers = Box::new(Fibers::new(self.geometry.all_strands(), &self.geometry.looks, make)?);
        Ok(())
    }

    /// Gives the looks the pigment with which the coats show the reflectances that are asked for. Coats are measured
    /// when the first reflectance is asked for, and again after a change of the strands.
    pub(crate) fn resolve(&mut self) {
        shown::resolve(&mut self.geometry, self.shows);
    }

    /// What the look of an index shows for a reflectance. `None` if nobody asks for one, or if the look is hardly seen.
    pub fn shown(&self, look: usize) -> Option<&Shown> {
        match &self.geometry.reflectance {
            Reflectance::Shown(all) => all.get(look)?.as_ref(),
            _ => None,
        }
    }

    /// Replaces the camera.
    ///
    /// # Errors
    /// [`vellus_scene::Error`] if [`Camera::validate`] finds the camera invalid. The world is then as before.
    pub fn set_camera(&mut self, camera: Camera) -> Result<(), Error> {
        camera.validate()?;
        self.geometry.view = View::new(camera);
        Ok(())
    }

    /// Multiplies the emission of all lights by a positive factor. Surfaces that emit light do not change.
    pub fn scale_lights(&mut self, factor: f32) {
        self.geometry.lights.scale(factor);
    }

    /// The names of the light groups, in the order of the channels of [`Layer::Lights`].
    pub fn group_names(&self) -> &[String] {
        &self.group_names
    }

    /// The strands in world space, without those of instances.
    pub fn curves(&self) -> &Curves {
        &self.geometry.curves
    }

    /// Number of instances.
    pub fn instances(&self) -> usize {
        self.geometry.instances.len()
    }

    /// Number of segments of strands. Those of a prototype count once.
    pub fn segments(&self) -> usize {
        self.geometry.curves.segments() + self.geometry.instances.segments()
    }

    /// Bytes in memory: the control points of strands, and the hierarchies over strands and instances.
    pub fn bytes(&self) -> usize {
        self.geometry.curves.bytes() + self.geometry.instances.bytes()
    }

    /// Segments, instances and megabytes, for messages.
    pub fn summary(&self) -> String {
        let instances = match self.instances() {
            0 => String::new(),
            count => format!("{count} instances, "),
        };
        format!("{} segments, {instances}{:.0} MB", self.segments(), self.bytes() as f64 * 1e-6)
    }

    /// The meshes in world space, without those of instances.
    pub fn triangles(&self) -> &Triangles {
        &self.geometry.triangles
    }

    /// The channels of a film that stores these layers of this scene. [`Layer::Lights`] has three channels for each
    /// light group of the scene.
    pub fn layout(&self, layers: &[Layer]) -> Layout {
        Layout::new(layers, &self.group_names).with_things(&self.things())
    }
}

/// The light groups of [`Layer::Lights`], and the group of each light.
struct LightGroups {
    names: Vec<String>,
    of_lights: Vec<usize>,
    of_emission: usize,
    of_background: usize,
}

impl LightGroups {
    /// Lights with the same group name share a group. The emission of meshes is the group `emission`. The dome of a
    /// scene without lights is the group `dome`. What the camera sees behind all objects is the group `background`.
    fn new(scene: &Scene) -> Self {
        let mut names: Vec<String> = Vec::new();
        let mut group = |name: &str| {
            names.iter().position(|n| n == name).unwrap_or_else(|| {
                names.push(name.to_owned());
                names.len() - 1
            })
        };
        let of_scene = scene.light_group_names();
        let of_scene = if of_scene.is_empty() { vec!["dome".to_owned()] } else { of_scene };
        let of_lights = of_scene.iter().map(|name| group(name)).collect();
        let glows = scene.surfaces.iter().any(|s| s.emission.iter().any(|&e| e > 0.0));
        let of_emission = if glows { group("emission") } else { 0 };
        let of_background = scene.background.map_or(0, |_| group("background"));
        LightGroups { names, of_lights, of_emission, of_background }
    }
}
