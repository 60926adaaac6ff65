//! Growing groups of strands on the meshes of a scene.

use crate::{Ground, Group, GroupError, GrowSettings, Maps, Site, area, grow};
use glam::Vec3;
use std::path::Path;
use vellus_scene::{Look, Mesh, Parameter, Scene, Strands, Texture, Value};

/// Bits by which the seeds of groups and of meshes are shifted, so that all are different.
const GROUP_BITS: usize = 32;
const MESH_BITS: usize = 40;

/// A group of strands with its fibre and its images.
#[derive(Clone, Debug)]
pub struct Coat {
    /// The group.
    pub group: Group,
    /// The fibre.
    pub look: Look,
    /// The image [`Group::density_map`].
    pub density: Option<Texture>,
    /// The image [`Group::length_map`].
    pub length: Option<Texture>,
    /// The image [`Group::color`], as reflectances.
    pub color: Option<Texture>,
}

impl Coat {
    fn density(&self, site: &Site) -> f32 {
        let density = self.density.as_ref().map_or(1.0, |map| map.at(site.uv)[0]);
        if self.length(site) > 0.0 { density } else { 0.0 }
    }

    fn length(&self, site: &Site) -> f32 {
        self.length.as_ref().map_or(1.0, |map| map.at(site.uv)[0])
    }

    /// An image of the group, if there is one: it needs uv coordinates.
    fn image(&self) -> Option<&Path> {
        let Group { density_map, length_map, color, .. } = &self.group;
        density_map.as_deref().or(length_map.as_deref()).or(color.as_deref())
    }
}

/// Grows coats on some meshes of a scene, given by their indices. The looks and textures of the coats become part of
/// the scene; the strands are returned. They are the same for the same `seed`.
///
/// # Errors
/// A value of a group out of its range; [`GroupError::NoUv`]; a mesh without area.
pub fn plant(scene: &mut Scene, meshes: &[usize], coats: Vec<Coat>, seed: u64) -> Result<Vec<Strands>, GroupError> {
    let up = if scene.units.is_some_and(|units| units.z_up) { Vec3::Z } else { Vec3::Y };
    let groups = coats.len();
    let mut grown = Vec::new();
    for (i, mut coat) in coats.into_iter().enumerate() {
        let chosen: Vec<&Mesh> = meshes.iter().map(|&m| &scene.meshes[m]).collect();
        if let (Some(image), Some(mesh)) = (coat.image(), chosen.iter().find(|mesh| mesh.uv.is_none())) {
            return Err(GroupError::NoUv { mesh: mesh.name.clone(), image: image.to_owned() });
        }
        let density = |site: &Site| coat.density(site);
        let areas: Vec<f64> = chosen.iter().map(|mesh| area(mesh, &density)).collect::<Result<_, _>>()?;
        let seed = seed.wrapping_add((i as u64) << GROUP_BITS);
        let ground = Ground { area: areas.iter().sum(), groups, up, seed };
        let whole = coat.group.settings(&ground)?;
        let look = scene.looks.len();
        let mut planted = 0.0;
        for (k, mesh) in chosen.iter().enumerate() {
            // Running sums are rounded, so that the numbers for all meshes add up to the count.
            let up_to = |area: f64| (area / ground.area * whole.count as f64).round() as usize;
            let count = up_to(planted + areas[k]) - up_to(planted);
            planted += areas[k];
            if count == 0 {
                continue;
            }
            let name = if chosen.len() > 1 { format!("{} {}", mesh.name, whole.name) } else { whole.name.clone() };
            let seed = whole.seed.wrapping_add((k as u64) << MESH_BITS);
            let settings = GrowSettings { name, count, seed, ..whole.clone() };
            let comb = coat.group.comb(up);
            let maps =
                Maps { density: &density, length: &|site| coat.length(site), comb: &|_| comb, ..Maps::default() };
            grown.push(Strands { look, ..grow(mesh, &settings, &maps)? });
        }
        if let Some(image) = &coat.color {
            let value = Value { texture: scene.textures.len(), scale: [1.0; 3] };
            coat.look.textured.push((Parameter::Reflectance, value));
            scene.textures.push(image.clone());
        }
        scene.looks.push(coat.look);
    }
    Ok(grown)
}
