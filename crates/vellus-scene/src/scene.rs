//! The scene.

use crate::camera::Camera;
use crate::custom::Custom;
use crate::error::{Error, invalid};
use crate::instances::{Instance, Prototype};
use crate::light::Light;
use crate::link::MAX_LINKED;
use crate::look::{Look, ReflectanceOf};
use crate::mesh::{Mesh, Opacity, Surface, Tint};
use crate::strands::Strands;
use crate::texture::Texture;
use crate::units::Units;
use glam::Vec3;

/// A scene: strands, meshes, their materials, lights and a camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Hair and fur.
    pub strands: Vec<Strands>,
    /// Skin and other objects.
    pub meshes: Vec<Mesh>,
    /// Strands and meshes that only the instances show.
    pub prototypes: Vec<Prototype>,
    /// The places of the prototypes. Prototypes with many strands need their memory once.
    pub instances: Vec<Instance>,
    /// Looks of strands: [`Strands::look`] is an index.
    pub looks: Vec<Look>,
    /// What the reflectances of looks and strands mean.
    pub reflectance: ReflectanceOf,
    /// Surfaces of meshes: [`Mesh::surface`] is an index.
    pub surfaces: Vec<Surface>,
    /// Images for colours and lights.
    pub textures: Vec<Texture>,
    /// Lights.
    pub lights: Vec<Light>,
    /// What the camera sees where there is no object. If it is `None`, it sees the domes and distant lights there.
    pub background: Option<Tint>,
    /// The camera. If it is `None`, the renderer uses [`Scene::framing`].
    pub camera: Option<Camera>,
    /// The unit of length and the up axis, if known.
    pub units: Option<Units>,
    /// Attributes of strands that rendering does not use. Readers leave them out unless a conversion needs them.
    pub custom: Vec<Custom>,
}

impl Scene {
    /// The smallest and largest coordinates of the points of strands and of the boxes around instances, or of meshes if
    /// there are neither. `None` if the scene is empty.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let instances = self.instance_corners();
        let strands = self.strands.iter().flat_map(|s| &s.points).map(|p| p.truncate()).chain(instances);
        let meshes = self.meshes.iter().flat_map(|m| &m.positions).copied();
        let around = |points: &mut dyn Iterator<Item = Vec3>| {
            points.fold(None, |bounds: Option<(Vec3, Vec3)>, p| {
                Some(bounds.map_or((p, p), |(low, high)| (low.min(p), high.max(p))))
            })
        };
        around(&mut { strands }).or_else(|| around(&mut { meshes }))
    }

    /// The names of all sets of strands, then those of all meshes: those in world space, then those of each prototype.
    pub fn object_names(&self) -> impl Iterator<Item = &str> {
        let meshes = self.meshes.iter().chain(self.prototypes.iter().flat_map(|prototype| &prototype.meshes));
        self.all_strands().map(|strands| &strands.name[..]).chain(meshes.map(|mesh| &mesh.name[..]))
    }

    /// The number of sets of strands and meshes, those of prototypes included.
    pub fn objects(&self) -> usize {
        self.object_names().count()
    }

    /// The group of each light: [`Light::group`], or the kind of the light, with a number from the second of a kind.
    pub fn light_group_names(&self) -> Vec<String> {
        let kinds: Vec<&str> = self.lights.iter().map(|light| light.shape.kind()).collect();
        let numbered = |i: usize| match kinds[..i].iter().filter(|&&kind| kind == kinds[i]).count() {
            0 => kinds[i].to_owned(),
            n => format!("{}{}", kinds[i], n + 1),
        };
        let lights = self.lights.iter().enumerate();
        lights.map(|(i, light)| light.group.clone().unwrap_or_else(|| numbered(i))).collect()
    }

    /// Whether any light has a link.
    pub fn is_linked(&self) -> bool {
        self.lights.iter().any(|light| light.link.is_some())
    }

    /// Checks the whole scene. A renderer accepts every valid scene.
    ///
    /// # Errors
    /// The first problem, with the name of the object.
    pub fn validate(&self) -> Result<(), Error> {
        self.validate_instances()?;
        self.strands.iter().try_for_each(Strands::validate)?;
        self.custom.iter().try_for_each(|custom| custom.validate(&self.strands))?;
        for strands in self.all_strands() {
            if strands.look >= self.looks.len() {
                return Err(invalid(&strands.name, "the look does not exist"));
            }
        }
        self.meshes.iter().try_for_each(Mesh::validate)?;
        for mesh in self.meshes.iter().chain(self.prototypes.iter().flat_map(|prototype| &prototype.meshes)) {
            if mesh.surface >= self.surfaces.len() {
                return Err(invalid(&mesh.name, "the surface does not exist"));
            }
        }
        for surface in &self.surfaces {
            let unit = |x: f32| (0.0..=1.0).contains(&x);
            if !surface.color.color.into_iter().chain([surface.roughness, surface.metallic]).all(unit) {
                return Err(invalid(&surface.name, "colour, roughness and metallic must be in [0, 1]"));
            }
            if !(1.0..=4.0).contains(&surface.ior) {
                return Err(invalid(&surface.name, "ior must be in [1, 4]"));
            }
            let Opacity { value, texture, threshold } = surface.opacity;
            if ![value, threshold].into_iter().all(unit) {
                return Err(invalid(&surface.name, "opacity and its threshold must be in [0, 1]"));
            }
            let map = surface.normals.map(|map| map.texture);
            if surface.normals.is_some_and(|map| map.scale.into_iter().chain(map.bias).any(|x| !x.is_finite())) {
                return Err(invalid(&surface.name, "scale and bias of a normal map must be finite"));
            }
            if [surface.color.texture, texture, map].into_iter().flatten().any(|t| t >= self.textures.len()) {
                return Err(invalid(&surface.name, "the texture does not exist"));
            }
        }
        self.looks.iter().try_for_each(|look| look.validate(self.textures.len()))?;
        self.lights.iter().try_for_each(|light| light.validate(self.textures.len()))?;
        if self.is_linked() && self.lights.len().saturating_mul(self.objects()) > MAX_LINKED {
            let (lights, objects) = (self.lights.len(), self.objects());
            let what =
                format!("{lights} lights times {objects} objects are more than {MAX_LINKED}: too many for links");
            return Err(invalid("lights", what));
        }
        if let Some(Tint { color, texture }) = self.background {
            if !color.iter().all(|c| c.is_finite() && *c >= 0.0) {
                return Err(invalid("background", format!("its colour is {color:?}: no channel may be negative")));
            }
            if texture.is_some_and(|index| index >= self.textures.len()) {
                return Err(invalid("background", "the texture does not exist"));
            }
        }
        self.textures.iter().try_for_each(Texture::validate)?;
        self.units.iter().try_for_each(Units::validate)?;
        self.camera.iter().try_for_each(Camera::validate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{LightShape, Profile, Shaping};
    use crate::link::Link;
    use crate::{Basis, Values};
    use glam::Vec4;
    use vellus::Fiber;

    fn dome() -> Light {
        LightShape::Dome { radiance: [1.0; 3], texture: None, rotation: glam::Mat3::IDENTITY, ground: None }.into()
    }

    fn scene() -> Scene {
        let strands = Strands {
            name: "fur".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, 2, 5],
            points: (0..5).map(|i| Vec4::new(i as f32, 0.5, 0.25, 0.01)).collect(),
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: vec![(crate::Parameter::G, Values::PerStrand(vec![[0.2; 3], [0.3; 3]]))],
        };
        let looks = vec![Look::constant("white", Fiber::hair())];
        Scene { strands: vec![strands], looks, lights: vec![dome()], ..Scene::default() }
    }

    /// Gives κ a texture with a scale in its last channel.
    fn textured(scene: &mut Scene, texture: usize, scale: f32) {
        let black = || Texture {
            name: String::new(),
            width: 1,
            height: 1,
            pixels: vec![[0.0; 3]].into(),
            wrap: Default::default(),
        };
        scene.textures = (0..1 - texture).map(|_| black()).collect();
        let value = crate::Value { texture, scale: [0.0, 0.0, scale] };
        scene.looks[0].textured.push((crate::Parameter::Kappa, value));
    }

    fn aimed(length: f32) -> Shaping {
        Shaping { axis: Vec3::X * length, cone: 0.5, softness: 0.0, focus: 0.0, tint: [0.0; 3], profile: None }
    }

    #[test]
    fn messages_name_the_object_and_the_problem() {
        assert_eq!(scene().validate(), Ok(()));
        assert_eq!(scene().strands[0].segments(), 3);
        type Break = fn(&mut Scene);
        let broken: [(Break, &str); 16] = [
            (|s| s.strands[0].look = 1, "fur: the look does not exist"),
            (|s| s.strands[0].starts[1] = 1, "fur: strand 0 has 1 points"),
            (|s| s.strands[0].starts[1] = 9, "strand 0 ends at point 9, but there are 5 points"),
            (|s| s.strands[0].points[3].w = -1.0, "strand 1, point 1 has the width -2.0"),
            (|s| s.strands[0].points[3].x = f32::NAN, "it must be finite and within ±1e9"),
            (|s| s.strands[0].varying[0].1 = Values::PerStrand(vec![[0.2; 3]]), "g has 1 values: there must be 2"),
            (|s| s.looks[0].fiber.eta = 9.0, "white: eta = 9"),
            (|s| textured(s, 1, 0.5), "white: kappa has the texture 1, but the scene has 0"),
            (|s| textured(s, 0, f32::INFINITY), "white: kappa has a texture with the scale [0.0, 0.0, inf]"),
            (|s| s.lights[0].shaping = Some(aimed(1.0)), "lights: a dome light cannot have a shaping"),
            (|s| s.lights[0].shaping = Some(aimed(0.0)), "shaping of a light: its axis must not be zero"),
            (
                |s| s.lights[0].shaping = Some(Shaping { tint: [0.0, -1.0, 0.0], ..aimed(1.0) }),
                "shaping of a light: no channel of its tint",
            ),
            (
                |s| {
                    let profile = Some(Profile { texture: 0, side: Vec3::Y });
                    s.lights[0].shaping = Some(Shaping { profile, ..aimed(1.0) });
                },
                "its profile is texture 0, but there are only 0",
            ),
            (
                |s| s.lights[0].link = Some(Link { diffuse: -1.0, ..Link::default() }),
                "link of a light: its gains are -1 and",
            ),
            (|s| s.background = Some(Tint { color: [-1.0; 3], texture: None }), "background: its colour is"),
            (|s| s.lights[0].group = Some("key.left".to_owned()), "'key.left': a light group's name"),
        ];
        for (change, message) in broken {
            let mut scene = scene();
            change(&mut scene);
            let error = scene.validate().unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn lights_without_groups_have_the_name_of_their_kind() {
        let ball = Light::from(LightShape::Sphere { center: Vec3::ZERO, radius: 1.0, radiance: [1.0; 3] });
        let key = Light { group: Some("key".to_owned()), ..dome() };
        let scene = Scene { lights: vec![ball.clone(), dome(), ball, key], ..scene() };
        assert_eq!(scene.light_group_names(), ["sphere", "dome", "sphere2", "key"]);
        assert_eq!(scene.validate(), Ok(()));
    }
}
