//! Grows fur on the meshes of a file.

use crate::mesh::is_obj;
use crate::{Error, Warning, choose_meshes, color, open_coat, open_mesh};
use std::path::Path;
use std::str::FromStr;
use vellus::Fiber;
use vellus_groom::{Coat, Ground, Group, plant};
use vellus_scene::{Look, SKIN, Scene, Strands, Surface, Tint};

/// Fur that is to grow on the meshes of a file.
///
/// ```
/// use vellus::{Fiber, Species};
/// use vellus_groom::Group;
/// use vellus_open::Growth;
/// use vellus_scene::Look;
/// # let folder = tempfile::tempdir()?;
/// # let mesh = folder.path().join("triangle.obj");
/// # std::fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
///
/// let look = Look::constant("red-fox", Fiber::preset(Species::RedFox));
/// let group = Group { count: Some(100), ..Group::default() };
/// let growth = Growth { groups: vec![(group, look)], meshes: Vec::new(), seed: 1, skin: None, strands_only: false };
/// growth.check()?;
/// let grown = growth.grow(&mesh, |warning| eprintln!("{warning}"))?;
/// assert_eq!((grown.strands, grown.scene.meshes.len()), (100, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Growth {
    /// Groups of strands, and their fibres.
    pub groups: Vec<(Group, Look)>,
    /// The meshes to grow on: see [`choose_meshes`].
    pub meshes: Vec<String>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// The skin under the fur. `None`: a file without colours gets [`Skin::Auto`], others keep theirs.
    pub skin: Option<Skin>,
    /// Return only the strands that grow, without the other parts of the scene.
    pub strands_only: bool,
}

/// The colour of the meshes on which fur grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Skin {
    /// That of the fur, darkened: see [`vellus_scene::Surface::skin`].
    Auto,
    /// A colour, linear RGB in [0, 1].
    Color([f32; 3]),
}

impl FromStr for Skin {
    type Err = String;

    /// Reads `auto` or a [`color`].
    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Skin::Auto);
        }
        let color = color(text).map_err(|error| format!("{error}, or auto"))?;
        if !color.iter().all(|c| (0.0..=1.0).contains(c)) {
            return Err("each channel of a skin's colour must be in [0, 1]".to_owned());
        }
        Ok(Skin::Color(color))
    }
}

/// A scene with fur.
#[derive(Clone, Debug)]
pub struct Grown {
    /// The scene.
    pub scene: Scene,
    /// The number of strands that grew.
    pub strands: usize,
    /// The number of their segments.
    pub segments: usize,
}

impl Growth {
    /// Checks everything that does not need the mesh.
    ///
    /// # Errors
    /// [`Error::Group`] if a value of a group is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        for (group, _) in &self.groups {
            // The area matters only for the number of strands.
            let density = group.density.filter(|density| *density > 0.0);
            let area = density.map_or(1.0, |density| 1000.0 / f64::from(density));
            group.settings(&Ground { area, groups: self.groups.len(), up: glam::Vec3::Y, seed: self.seed })?;
        }
        Ok(())
    }

    /// Reads a file, grows the fur, and adds it to the scene of the file. `warn` gets what a user should know.
    ///
    /// An .obj file has no colours: its meshes get the colour of the fur, if that is an image.
    ///
    /// # Errors
    /// Those of [`open_mesh`], [`choose_meshes`] and [`open_coat`], and [`Error::Group`].
    pub fn grow(self, mesh: impl AsRef<Path>, mut warn: impl FnMut(&Warning)) -> Result<Grown, Error> {
        let opened = open_mesh(&mesh)?;
        opened.warnings.iter().for_each(&mut warn);
        let mut scene = opened.scene;
        let chosen = choose_meshes(&scene, &self.meshes)?;
        let mut coats: Vec<Coat> = Vec::new();
        for (group, look) in self.groups {
            let (coat, warnings) = open_coat(group, look)?;
            warnings.iter().for_each(&mut warn);
            coats.push(coat);
        }
        let skin = coats.iter().find_map(|coat| coat.color.clone());
        let fibers: Vec<Fiber> = coats.iter().map(|coat| coat.look.fiber).collect();
        let grown = plant(&mut scene, &chosen, coats, self.seed)?;
        color_skin(&mut scene, &chosen, self.skin, &fibers);
        let (strands, segments) = (grown.iter().map(Strands::len).sum(), grown.iter().map(Strands::segments).sum());
        if self.strands_only {
            let Scene { looks, textures, units, .. } = scene;
            scene = Scene { strands: grown, looks, textures, units, ..Scene::default() };
        } else {
            scene.strands.extend(grown);
            if let (true, Some(image), [surface]) = (is_obj(mesh.as_ref()), skin, &mut scene.surfaces[..]) {
                surface.color = Tint { color: [SKIN; 3], texture: Some(scene.textures.len()) };
                surface.skin = false;
                scene.textures.push(image);
            }
        }
        Ok(Grown { scene, strands, segments })
    }
}

/// Gives the meshes that have fur their skin. The colour of [`Skin::Auto`] is for other renderers: ours replaces it.
fn color_skin(scene: &mut Scene, meshes: &[usize], skin: Option<Skin>, fibers: &[Fiber]) {
    for &mesh in meshes {
        let own = &scene.surfaces[scene.meshes[mesh].surface];
        let skin = skin.or(own.skin.then_some(Skin::Auto));
        let of_coat = |fiber: &Fiber| fiber.reflectance.or_else(|| fiber.coat_color().ok()).unwrap_or([0.5; 3]);
        let (color, is_auto) = match skin {
            None => continue,
            Some(Skin::Color(color)) => (color, false),
            Some(Skin::Auto) => {
                let colors: Vec<[f32; 3]> = fibers.iter().map(of_coat).collect();
                let mean = |c: usize| colors.iter().map(|color| color[c]).sum::<f32>() / colors.len().max(1) as f32;
                ([0, 1, 2].map(|c| SKIN * mean(c)), true)
            }
        };
        let surface = Surface { color: Tint { color, texture: None }, skin: is_auto, ..own.clone() };
        let index = scene.meshes[mesh].surface;
        if scene.meshes.iter().filter(|other| other.surface == index).count() == 1 {
            scene.surfaces[index] = surface;
        } else {
            scene.meshes[mesh].surface = scene.surfaces.len();
            scene.surfaces.push(surface);
        }
    }
}
