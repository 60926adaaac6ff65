//! Grows fur on the meshes of a file.

use crate::mesh::is_obj;
use crate::{Error, Warning, choose_meshes, open_coat, open_mesh};
use std::path::Path;
use vellus_groom::{Coat, Ground, Group, plant};
use vellus_scene::{Look, Scene, Strands, Tint};

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
/// let growth = Growth { groups: vec![(group, look)], meshes: Vec::new(), seed: 1, strands_only: false };
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
    /// Return only the strands that grow, without the other parts of the scene.
    pub strands_only: bool,
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
        let grown = plant(&mut scene, &chosen, coats, self.seed)?;
        let (strands, segments) = (grown.iter().map(Strands::len).sum(), grown.iter().map(Strands::segments).sum());
        if self.strands_only {
            let Scene { looks, textures, units, .. } = scene;
            scene = Scene { strands: grown, looks, textures, units, ..Scene::default() };
        } else {
            scene.strands.extend(grown);
            if let (true, Some(image), [surface]) = (is_obj(mesh.as_ref()), skin, &mut scene.surfaces[..]) {
                surface.color = Tint { color: [0.5; 3], texture: Some(scene.textures.len()) };
                scene.textures.push(image);
            }
        }
        Ok(Grown { scene, strands, segments })
    }
}
