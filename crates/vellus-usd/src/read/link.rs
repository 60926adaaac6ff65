//! Reads light linking: the collections `lightLink` and `shadowLink` of UsdLuxLightAPI.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::instances::is_below;
use crate::read::xform::Place;
use crate::stage::Stage;
use std::collections::{HashMap, HashSet};
use vellus_scene::{Link, MAX_LINKED, Objects};

/// The collections of a light: of the prims that it lights, and of those that cast shadows in its light.
pub(crate) const LINKS: [&str; 2] = ["lightLink", "shadowLink"];

/// The path of a collection of a light. `None` if it has all prims, as without any property of it.
fn collection(stage: &Stage, prim: &str, name: &str) -> Result<Option<String>, Error> {
    let own = |part: &str| format!("collection:{name}:{part}");
    let prefix = own("");
    let properties = stage.properties(prim)?;
    let all: Vec<&str> = properties.iter().filter(|property| property.starts_with(&prefix)).collect();
    if all.is_empty() {
        return Ok(None);
    }
    stage.know(prim, &all)?;
    let has_root = stage.flag(prim, &own("includeRoot"))? != Some(false);
    let expands =
        stage.words(prim, &own("expansionRule"))?.unwrap_or_default().first().is_none_or(|w| w != "explicitOnly");
    let has_all = has_root && expands && stage.targets(prim, &own("excludes"))?.is_empty();
    Ok((!has_all).then(|| format!("{prim}.collection:{name}")))
}

/// The collections of all lights of a stage that lack some prims.
pub(crate) fn collections(stage: &Stage, places: &[Place]) -> Vec<String> {
    let lights = places.iter().filter(|place| place.type_name.contains("Light") && place.shown);
    // Errors are reported where the links are read.
    let of = |place: &Place| LINKS.map(|name| collection(stage, &place.path, name).ok().flatten());
    lights.flat_map(of).flatten().collect()
}

/// In which collections the prims of an instance are. Instances share a prototype only if this is the same for both.
/// `inside` starts with the instance.
pub(crate) fn membership(stage: &Stage, collections: &[String], inside: &[Place]) -> String {
    let mut text = String::new();
    for collection in collections {
        for place in inside.iter().take_while(|place| is_below(&place.path, &inside[0].path)) {
            // Errors are reported where the links are read.
            let is_member = stage.includes(collection, &place.path).unwrap_or(true);
            text.push(if is_member { '1' } else { '0' });
        }
    }
    text
}

/// Completes the links of all lights after everything else was read.
pub(crate) fn read(reader: &mut Reader, places: &[Place]) -> Result<(), Error> {
    let lights = std::mem::take(&mut reader.linked);
    if lights.is_empty() {
        return Ok(());
    }
    let paths = object_paths(reader, places)?;
    if reader.scene.lights.len().saturating_mul(reader.scene.objects()) > MAX_LINKED {
        for light in lights {
            let what = "links of lights are ignored: the stage has too many lights and objects for them";
            reader.warnings.add(&light.prim, what);
        }
        reader.scene.lights.iter_mut().for_each(|light| light.link = None);
        return Ok(());
    }
    for Linked { index, prim, shadows } in lights {
        let mut link = Link::default();
        for (name, objects) in LINKS.into_iter().zip([&mut link.lit, &mut link.casters]) {
            let own = |part: &str| format!("collection:{name}:{part}");
            let expression = own("membershipExpression");
            if reader.stage.has_property(&prim, &expression)?
                && reader.stage.flag(&prim, &own("includeRoot")).ok().flatten() != Some(false)
            {
                reader.warnings.add(&prim, format!("{expression} has no effect: the collection has the root"));
            }
            match collection(reader.stage, &prim, name) {
                Ok(None) => {}
                Ok(Some(collection)) => {
                    *objects = members(reader, &prim, &collection, &paths);
                    warn_of_instancers(reader, &prim, &collection, places)?;
                }
                Err(error) => reader.ignore(&prim, error)?,
            }
        }
        if !shadows {
            link.casters = Objects::NONE;
        }
        let light = &mut reader.scene.lights[index];
        let Link { diffuse, specular, .. } = light.link.take().unwrap_or_default();
        light.link = Some(Link { diffuse, specular, ..link }).filter(|link| *link != Link::default());
    }
    Ok(())
}

/// A light that may have links.
#[derive(Clone, Debug)]
pub(crate) struct Linked {
    /// Index of the light in the scene.
    pub index: usize,
    pub prim: String,
    /// Whether things cast shadows in its light.
    pub shadows: bool,
}

/// The names of all objects of the scene, each with the path of its prim.
fn object_paths(reader: &Reader, places: &[Place]) -> Result<Vec<(String, String)>, Error> {
    let mut named = HashMap::new();
    for place in places {
        if reader.stage.has_property(&place.path, "vellus:name")? {
            named.insert(reader.name(&place.path)?, place.path.clone());
        }
    }
    let mut seen = HashSet::new();
    let names = reader.scene.object_names().filter(|name| seen.insert(*name));
    Ok(names.map(|name| (name.to_owned(), named.get(name).map_or(name, |path| path).to_owned())).collect())
}

/// The objects in a collection.
fn members(reader: &mut Reader, prim: &str, collection: &str, paths: &[(String, String)]) -> Objects {
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    for (name, path) in paths {
        match reader.stage.includes(collection, path) {
            Ok(true) => inside.push(name.clone()),
            Ok(false) => outside.push(name.clone()),
            Err(error) => {
                let name = collection.rsplit(':').next().unwrap_or_default();
                reader.warnings.add(prim, format!("collection:{name} is not read, and has all prims: {error}"));
                return Objects::ALL;
            }
        }
    }
    if outside.len() <= inside.len() { Objects::Except(outside) } else { Objects::Only(inside) }
}

/// Warns if a collection treats an instancer unlike its prototypes: all instances have the links of the prototypes.
fn warn_of_instancers(reader: &mut Reader, prim: &str, collection: &str, places: &[Place]) -> Result<(), Error> {
    for place in places.iter().filter(|place| place.shown && place.type_name == "PointInstancer") {
        let own = reader.stage.includes(collection, &place.path).ok();
        for prototype in reader.stage.targets(&place.path, "prototypes")? {
            if reader.stage.includes(collection, &prototype).ok() != own {
                let what = "its links of the prototypes of an instancer count, not those of the instancer";
                reader.warnings.add(prim, what);
            }
        }
    }
    Ok(())
}
