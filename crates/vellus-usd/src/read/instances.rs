//! Instances: native ones (`instanceable = true`), and those of PointInstancer. Each prototype is read once.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::network::bound_material;
use crate::read::prim::Prim;
use crate::read::primvar::ancestors;
use crate::read::shapes::{self, SHAPES};
use crate::read::xform::{Place, mean_scale, places};
use crate::read::{CURVES, curves, link, mesh, spheres};
use glam::{DMat4, DQuat, DVec3};
use std::collections::HashMap;
use vellus_scene::{Instance, MAX_COPIED, Prototype};

/// What makes instances move while the shutter is open.
const MOTION: [&str; 3] = ["velocities", "angularVelocities", "accelerations"];

/// The prototypes that were read, by their paths.
pub(crate) type Known = HashMap<String, Option<usize>>;

/// The deepest nesting of instancers.
const MOST_NESTED: usize = 8;

/// The largest number of instances of a stage.
const MAX_INSTANCES: usize = 1 << 24;

/// The native instances that share a prototype, by the index of their place. The value is the index of the first one.
pub(crate) struct Shared(HashMap<usize, usize>);

impl Shared {
    /// Finds the instances that are equal except for their transform: they have the same prototype, inherit the same
    /// material and primvars, have the same links of lights, do not move while the shutter is open, and are scaled
    /// uniformly. Instances inside instances are read as a part of these.
    pub fn find(reader: &mut Reader, places: &[Place]) -> Result<Self, Error> {
        let mut groups: HashMap<String, Vec<usize>> = HashMap::new();
        let collections = link::collections(reader.stage, places);
        let mut outer: Option<&str> = None;
        for (i, place) in places.iter().enumerate() {
            if outer.is_some_and(|outer| is_below(&place.path, outer)) {
                continue;
            }
            let Some(prototype) = reader.stage.prototype(&place.path) else { continue };
            outer = Some(&place.path);
            let stays = place.to_world == place.moved;
            if place.shown && !place.swallowed && stays && is_similar(&place.to_world) {
                let linked = link::membership(reader.stage, &collections, &places[i..]);
                let key = format!("{prototype} {} {linked}", inherited(reader, &place.path)?);
                groups.entry(key).or_default().push(i);
            }
        }
        let shared = groups.into_values().filter(|group| group.len() > 1);
        Ok(Shared(shared.flat_map(|group| group.clone().into_iter().map(move |i| (i, group[0]))).collect()))
    }

    /// The first of the instances that share a prototype with the place of this index, if it is one of them.
    pub fn first(&self, place: usize) -> Option<usize> {
        self.0.get(&place).copied()
    }
}

/// Whether a transform only rotates, mirrors, moves and scales uniformly.
fn is_similar(matrix: &DMat4) -> bool {
    mean_scale(matrix).1 && matrix.determinant() != 0.0
}

/// Whether a prim is another prim or a descendant of it.
pub(crate) fn is_below(path: &str, other: &str) -> bool {
    path.strip_prefix(other).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// What the prims of an instance inherit from the instance and its ancestors: a material, primvars, and skeletons.
fn inherited(reader: &mut Reader, path: &str) -> Result<String, Error> {
    let mut text = bound_material(reader, path)?.unwrap_or_default();
    for ancestor in ancestors(path) {
        let inherits = |name: &&str| name.starts_with("primvars:") || name.starts_with("skel:");
        for name in reader.stage.properties(ancestor)?.iter().filter(inherits) {
            text += &format!(" {ancestor}.{name}");
        }
    }
    Ok(text)
}

/// Reads the strands and meshes of places into a prototype. `to_local` transforms from world space. `None` if there are
/// none.
pub(crate) fn prototype<'p>(
    reader: &mut Reader,
    name: &str,
    places: impl Iterator<Item = &'p Place>,
    to_local: [DMat4; 2],
    (all, known): (&[Place], &mut Known),
) -> Result<Option<usize>, Error> {
    let (first_set, first_mesh) = (reader.scene.strands.len(), reader.scene.meshes.len());
    let around = std::mem::replace(&mut reader.local_scale, mean_scale(&to_local[0]).0);
    let eye = reader.eye.take();
    // The path of the PointInstancer inside, whose prototypes are not drawn by themselves.
    let mut inner: Option<&str> = None;
    for place in places.filter(|place| place.shown) {
        inner = inner.filter(|path| is_below(&place.path, path));
        if inner.is_some() {
            continue;
        }
        let [open, close] = to_local;
        let mut local = place.clone();
        (local.to_world, local.moved) = (open * place.to_world, close * place.moved);
        match place.type_name.as_str() {
            kind if CURVES.contains(&kind) => reader.attempt(&place.path, |reader| curves::read(reader, &local))?,
            "Mesh" => reader.attempt(&place.path, |reader| mesh::read(reader, &local))?,
            shape if SHAPES.contains(&shape) => reader.attempt(&place.path, |reader| shapes::read(reader, &local))?,
            // Instances have no instances: these are copied.
            nested @ ("PointInstancer" | "Points") => {
                let first = reader.scene.instances.len();
                reader.nested += 1;
                let read = reader.attempt(&place.path, |reader| match nested {
                    "Points" => spheres::read(reader, &local),
                    _ if reader.nested > MOST_NESTED => {
                        let what = format!("more than {MOST_NESTED} instancers are inside each other");
                        Err(Error::prim(&place.path, what))
                    }
                    _ => point_instancer(reader, &local, all, known),
                });
                reader.nested -= 1;
                read?;
                inner = (nested == "PointInstancer").then_some(&place.path);
                for instance in reader.scene.instances.split_off(first) {
                    copy(reader, &place.path, &instance)?;
                }
            }
            _ => {}
        }
    }
    reader.local_scale = around;
    reader.eye = eye;
    let strands = reader.scene.strands.split_off(first_set);
    let meshes = reader.scene.meshes.split_off(first_mesh);
    if strands.is_empty() && meshes.is_empty() {
        return Ok(None);
    }
    reader.scene.prototypes.push(Prototype { name: name.to_owned(), strands, meshes });
    Ok(Some(reader.scene.prototypes.len() - 1))
}

/// Adds an instance. If its transform is not a similarity, it becomes a copy.
pub(crate) fn add(reader: &mut Reader, prim: &str, prototype: usize, to_world: &DMat4) -> Result<(), Error> {
    if !to_world.is_finite() {
        return Err(Error::prim(prim, "the transform of an instance must be finite"));
    }
    if reader.scene.instances.len() >= MAX_INSTANCES {
        return Err(Error::prim(prim, format!("the stage has more than {MAX_INSTANCES} instances")));
    }
    let instance = Instance::new(prototype, to_world.as_mat4());
    if to_world.determinant() == 0.0 {
        reader.warnings.add(prim, "an instance with the scale 0 is not shown");
    } else if instance.scale().is_some() {
        reader.scene.instances.push(instance);
    } else {
        let what = "instances with another scale in each direction are copied, with the mean scale for widths";
        reader.warnings.add(prim, what);
        copy(reader, prim, &instance)?;
    }
    Ok(())
}

/// Replaces all instances by copies.
pub(crate) fn copy_all(reader: &mut Reader) -> Result<(), Error> {
    for instance in std::mem::take(&mut reader.scene.instances) {
        let name = reader.scene.prototypes[instance.prototype].name.clone();
        copy(reader, &name, &instance)?;
    }
    reader.scene.prototypes.clear();
    Ok(())
}

fn copy(reader: &mut Reader, prim: &str, instance: &Instance) -> Result<(), Error> {
    let scene = &mut reader.scene;
    let prototype = &scene.prototypes[instance.prototype];
    reader.copied += prototype.points();
    if reader.copied > MAX_COPIED {
        let what = format!("copies of its instances would have more than {MAX_COPIED} points");
        return Err(Error::prim(prim, what));
    }
    scene.strands.extend(prototype.strands.iter().map(|strands| strands.transformed(instance.to_world)));
    scene.meshes.extend(prototype.meshes.iter().map(|mesh| mesh.transformed(instance.to_world)));
    Ok(())
}

/// Reads a PointInstancer (UsdGeomPointInstancer). `known` has the prototypes that were read, by their paths.
pub(crate) fn point_instancer(
    reader: &mut Reader,
    instancer: &Place,
    all: &[Place],
    known: &mut Known,
) -> Result<(), Error> {
    let prim = reader.prim(&instancer.path)?;
    let mut prototypes = Vec::new();
    for target in prim.targets("prototypes")? {
        if !known.contains_key(&target) {
            let mut inside: Vec<&Place> = all.iter().filter(|place| is_below(&place.path, &target)).collect();
            // Below an `over`, which keeps prototypes from being drawn by themselves.
            let hidden = if inside.is_empty() { hidden(reader, &target)? } else { Vec::new() };
            inside.extend(&hidden);
            let parent = target.rsplit_once('/').map_or("", |(parent, _)| parent);
            let around = all.iter().find(|place| place.path == parent);
            let to_local =
                around.map_or([DMat4::IDENTITY; 2], |place| [place.to_world, place.moved].map(|m| m.inverse()));
            if !to_local[0].is_finite() {
                return Err(Error::prim(parent, "its transform flattens a prototype: no scale may be 0"));
            }
            let read = prototype(reader, &target, inside.into_iter(), to_local, (all, known))?;
            if read.is_none() {
                reader.warnings.add(&target, "the prototype has no strands and meshes that are shown and can be read");
            }
            known.insert(target.clone(), read);
        }
        prototypes.push(known[&target]);
    }
    let moves = MOTION.iter().any(|name| prim.has_value(name).unwrap_or(false));
    if moves && reader.stage.clock().close != reader.stage.clock().open {
        reader.warnings.add(prim.path, "instances do not move while the shutter is open: their velocities are ignored");
    }
    let points = Points::read(&prim)?;
    if points.count() == 0 {
        reader.warnings.add(prim.path, "it has no positions: it shows nothing");
    }
    for i in 0..points.count() {
        let Some(index) = points.prototype(&prim, i, prototypes.len())? else { continue };
        let Some(prototype) = prototypes[index] else { continue };
        add(reader, prim.path, prototype, &(instancer.to_world * points.matrix(i)))?;
    }
    Ok(())
}

/// A prototype that is not defined on the stage, because an ancestor is an `over`, and what is in it. Its place is
/// relative to its parent.
fn hidden(reader: &mut Reader, target: &str) -> Result<Vec<Place>, Error> {
    let paths = reader.stage.prims_below(target).map_err(|what| Error::prim(target, what))?;
    places(reader, &paths)
}

/// The arrays of a PointInstancer.
struct Points {
    positions: Vec<[f32; 3]>,
    prototypes: Vec<i64>,
    /// x, y, z, w.
    orientations: Option<Vec<[f32; 4]>>,
    scales: Option<Vec<[f32; 3]>>,
    ids: Option<Vec<i64>>,
    invisible: Vec<i64>,
}

impl Points {
    fn read(prim: &Prim) -> Result<Self, Error> {
        let positions = rows::<3>(prim, "positions")?.unwrap_or_default();
        let prototypes = prim.integers("protoIndices")?.unwrap_or_default();
        prim.stage.know(prim.path, &["orientations"])?;
        let orientations = match rows::<4>(prim, "orientationsf")? {
            None => rows::<4>(prim, "orientations")?,
            precise => precise,
        };
        let scales = rows::<3>(prim, "scales")?;
        let ids = prim.integers("ids")?;
        let mut invisible = prim.integers("invisibleIds")?.unwrap_or_default();
        invisible.extend(prim.stage.inactive_ids(prim.path)?);
        invisible.sort_unstable();
        let count = positions.len();
        let lengths = [
            ("protoIndices", Some(prototypes.len())),
            ("orientations", orientations.as_ref().map(Vec::len)),
            ("scales", scales.as_ref().map(Vec::len)),
            ("ids", ids.as_ref().map(Vec::len)),
        ];
        if let Some((name, length)) = lengths.iter().find(|(_, length)| length.is_some_and(|length| length != count)) {
            let length = length.unwrap_or(0);
            return Err(prim.error(format!("{name} has {length} values, but there are {count} positions")));
        }
        let turns = orientations.iter().flatten();
        if let Some(i) = turns.map(|q| q.iter().map(|x| x * x).sum::<f32>()).position(|length| !length.is_finite()) {
            return Err(prim.error(format!("orientations[{i}] must be finite")));
        }
        Ok(Points { positions, prototypes, orientations, scales, ids, invisible })
    }

    fn count(&self) -> usize {
        self.positions.len()
    }

    /// The index of the prototype of an instance, or `None` if it is invisible.
    fn prototype(&self, prim: &Prim, i: usize, prototypes: usize) -> Result<Option<usize>, Error> {
        let id = self.ids.as_ref().map_or(i as i64, |ids| ids[i]);
        if self.invisible.binary_search(&id).is_ok() {
            return Ok(None);
        }
        let index = usize::try_from(self.prototypes[i]).ok().filter(|&index| index < prototypes);
        index.map(Some).ok_or_else(|| {
            let index = self.prototypes[i];
            prim.error(format!("protoIndices[{i}] is {index}, but there are {prototypes} prototypes"))
        })
    }

    fn matrix(&self, i: usize) -> DMat4 {
        let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let scale = self.scales.as_ref().map_or(DVec3::ONE, |scales| vector(scales[i]));
        let turn = self.orientations.as_ref().map_or(DQuat::IDENTITY, |all| {
            let [x, y, z, w] = all[i].map(f64::from);
            let quaternion = DQuat::from_xyzw(x, y, z, w);
            if quaternion.length_squared() > 0.0 { quaternion.normalize() } else { DQuat::IDENTITY }
        });
        DMat4::from_scale_rotation_translation(scale, turn, vector(self.positions[i]))
    }
}

/// An array of vectors with N numbers.
fn rows<const N: usize>(prim: &Prim, name: &str) -> Result<Option<Vec<[f32; N]>>, Error> {
    let Some(found) = prim.numbers(name)? else { return Ok(None) };
    if found.lanes != N {
        return Err(prim.error(format!("{name} must be vectors of {N} numbers")));
    }
    let row = |i: usize| std::array::from_fn(|k| found.row(i)[k]);
    Ok(Some((0..found.len()).map(row).collect()))
}
