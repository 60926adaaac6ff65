//! Changes of a world that keep what they do not touch: a viewer changes looks, lights and strands while it renders.

use crate::geometry::curves::Curves;
use crate::geometry::instances::Hit;
use crate::integrator::settings::Settings;
use crate::light::Lights;
use crate::shading::colors;
use crate::shown::Reflectance;
use crate::world::World;
use glam::Vec3;
use vellus::{Fiber, Parameter};
use vellus_scene::{Camera, Error, Light, Look, Strands, Values};

/// Parameters that vary over a set of strands: see [`Strands::varying`].
pub type Varying = Vec<(Parameter, Values<[f32; 3]>)>;

/// What the camera sees at a point of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// The point of the surface, in world space.
    pub point: Vec3,
    /// The distance from the camera.
    pub distance: f32,
    /// The name of the set of strands, or of the mesh.
    pub name: String,
    /// The strand. `None` for a mesh.
    pub strand: Option<PickedStrand>,
}

/// A strand that the camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickedStrand {
    /// Its number in the picture, from 1, as in [`Layer::Strand`](crate::Layer::Strand).
    pub number: u32,
    /// Its index in its set of strands.
    pub index: usize,
    /// The index of its look.
    pub look: usize,
    /// The offset of the hit, in [-1, 1].
    pub h: f32,
    /// The inclination of the direction to the camera, in radians.
    pub theta: f32,
    /// The fibre at the hit, with all textures and values that vary.
    pub fiber: Fiber,
}

impl World {
    /// The camera.
    pub fn camera(&self) -> Camera {
        self.geometry.view.camera()
    }

    /// The looks of the strands.
    pub fn looks(&self) -> &[Look] {
        &self.geometry.looks
    }

    /// Replaces the looks, and the parameters that vary over some sets of strands in world space: `varying` has
    /// indices of [`Curves::strands`]. The hierarchies stay.
    ///
    /// # Errors
    /// [`Error`] if a look is invalid, the number of looks or values does not match, or the model refuses a fibre.
    /// Nothing changes then.
    pub fn set_looks(&mut self, looks: Vec<Look>, varying: Vec<(usize, Varying)>) -> Result<(), Error> {
        if looks.len() != self.geometry.looks.len() {
            return Err(invalid("looks", "a change of looks keeps their number"));
        }
        looks.iter().try_for_each(|look| look.validate(self.geometry.textures.len()))?;
        for (set, varying) in &varying {
            let Some(strands) = self.geometry.curves.strands().get(*set) else {
                return Err(invalid("looks", "the strands do not exist"));
            };
            if !varying.iter().all(|(_, values)| fits(values, strands)) {
                return Err(invalid(&strands.name, "the number of values is not that of its strands or points"));
            }
        }
        let varied = self.swap_varying(varying);
        let looked = std::mem::replace(&mut self.geometry.looks, looks);
        self.resolve();
        match self.fibers.rebuilt(&self.geometry) {
            Ok(fibers) => {
                self.fibers = fibers;
                self.geometry.update_sections();
                self.update_colors();
                Ok(())
            }
            Err(error) => {
                self.swap_varying(varied);
                self.geometry.looks = looked;
                Err(error)
            }
        }
    }

    /// Replaces values that vary over sets of strands. Returns those before.
    fn swap_varying(&mut self, varying: Vec<(usize, Varying)>) -> Vec<(usize, Varying)> {
        let curves = &mut self.geometry.curves;
        let swap = |(set, varying)| (set, std::mem::replace(curves.varying_mut(set), varying));
        varying.into_iter().map(swap).collect()
    }

    /// Replaces the lights: as many as before, with the same textures. Groups and links must stay as they are.
    ///
    /// # Errors
    /// [`Error`] if a light is invalid, or their number differs. The lights are then as before.
    pub fn set_lights(&mut self, lights: &[Light]) -> Result<(), Error> {
        let is_linked = lights.iter().any(|light| light.link.is_some());
        if lights.len() != self.geometry.groups.len() || is_linked != self.geometry.lights.is_linked() {
            return Err(invalid("lights", "a change of lights keeps their number and links"));
        }
        let textures = &self.geometry.textures;
        lights.iter().try_for_each(|light| light.validate(textures.len()))?;
        self.geometry.lights = Lights::new(lights, &self.lighting, textures);
        Ok(())
    }

    /// Replaces the strands in world space: as many sets as before, each with the look that it had. `curves` may be
    /// built on another thread while this world is rendered.
    ///
    /// # Errors
    /// [`Error`] if the number of sets or a look differs. The strands are then as before.
    pub fn set_curves(&mut self, curves: Curves) -> Result<(), Error> {
        let looks = |curves: &Curves| curves.strands().iter().map(|set| set.look).collect::<Vec<_>>();
        if looks(&curves) != looks(&self.geometry.curves) {
            return Err(invalid("strands", "a change of strands keeps the number of sets and their looks"));
        }
        let mut before = 0u32;
        for (i, set) in curves.strands().iter().enumerate() {
            self.geometry.strands_before[i] = before;
            before = before.wrapping_add(set.len() as u32);
        }
        self.geometry.curves = curves;
        self.geometry.update_sections();
        self.geometry.update_motion();
        self.geometry.reflectance = Reflectance::Dense;
        self.resolve();
        // The looks are those of before, and the model took them.
        self.fibers = self.fibers.rebuilt(&self.geometry)?;
        self.update_colors();
        Ok(())
    }

    fn update_colors(&mut self) {
        let looks = &self.geometry.looks;
        let colors = self.geometry.all_strands().map(|set| colors::table(set, &looks[set.look])).collect();
        self.geometry.colors = colors;
    }

    /// What the camera sees in the middle of a pixel, through the middle of the lens. `None` if there is no object.
    pub fn pick(&self, settings: &Settings, pixel: [usize; 2]) -> Option<Pick> {
        let geometry = &self.geometry;
        let ray = geometry.view.ray(settings.size, pixel, settings.filter, [0.5; 4], 0.0);
        match geometry.intersect(&ray)? {
            Hit::Triangle(hit) => {
                let name = geometry.all_meshes().nth(hit.mesh).map_or_else(String::new, |mesh| mesh.name.clone());
                Some(Pick { point: ray.at(hit.t), distance: hit.t, name, strand: None })
            }
            Hit::Curve(hit) => {
                let frame = hit.frame();
                let point = ray.at(hit.entry.t);
                let h = frame.offset(point, -ray.direction);
                let theta = frame.to_local(-ray.direction).x.clamp(-1.0, 1.0).asin();
                let set = geometry.all_strands().nth(hit.set)?;
                let strand = PickedStrand {
                    number: geometry.strand_number(&hit),
                    index: hit.strand,
                    look: set.look,
                    h,
                    theta,
                    fiber: geometry.fiber(&hit),
                };
                Some(Pick { point, distance: hit.entry.t, name: set.name.clone(), strand: Some(strand) })
            }
        }
    }
}

fn invalid(place: &str, what: &str) -> Error {
    Error::Invalid { place: place.to_owned(), what: what.to_owned() }
}

fn fits(values: &Values<[f32; 3]>, strands: &Strands) -> bool {
    match values {
        Values::Constant(_) => true,
        Values::PerStrand(values) => values.len() == strands.len(),
        Values::PerPoint(values) => values.len() == strands.points.len(),
    }
}
