//! Reads skeletons and their animations, and moves the points that are bound to them (UsdSkel).

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::motion::Points;
use crate::read::polygons::Polygons;
use crate::read::primvar::{Interpolation, ancestors};
use crate::read::skin::{Influences, Rigid, Skin, blend, concatenate, joint, parents};
use crate::read::xform::Place;
use crate::stage::{Stage, When};
use glam::DMat4;
use std::collections::HashMap;
use std::rc::Rc;

/// The schema of prims with a binding.
const BINDING: &str = "SkelBindingAPI";

/// The properties of a binding that are no primvars.
const BINDINGS: [&str; 5] =
    ["skel:skeleton", "skel:animationSource", "skel:joints", "skel:blendShapes", "skel:blendShapeTargets"];

/// When the shutter opens, and when it closes.
const TIMES: [When; 2] = [When::Open, When::Close];

/// The prims below skeleton roots (SkelRoot), and the skeletons that were read.
#[derive(Default)]
pub(crate) struct Skeletons {
    /// The transforms to world space when the shutter opens and closes.
    places: HashMap<String, [DMat4; 2]>,
    poses: HashMap<String, Option<Rc<Pose>>>,
}

/// A skeleton in its pose.
struct Pose {
    joints: Vec<String>,
    /// For each joint, from its place when bound to its place when the shutter opens and closes.
    matrices: [Vec<DMat4>; 2],
    /// The weights of blend shapes when the shutter opens and closes.
    shapes: [HashMap<String, f32>; 2],
    to_world: [DMat4; 2],
}

/// What moves the points of a prim.
struct Binding {
    pose: Rc<Pose>,
    /// `None` if only blend shapes do.
    skin: Option<(Influences, [Skin; 2])>,
}

impl Skeletons {
    /// Finds the prims below skeleton roots.
    pub fn new(places: &[Place]) -> Self {
        let mut root: Option<&str> = None;
        let mut below = HashMap::new();
        for place in places {
            let is_below = |root: &str| place.path.strip_prefix(root).is_some_and(|rest| rest.starts_with('/'));
            root = root.filter(|root| is_below(root));
            if root.is_none() && place.type_name == "SkelRoot" {
                root = Some(&place.path);
            }
            if root.is_some() {
                below.insert(place.path.clone(), [place.to_world, place.moved]);
            }
        }
        Skeletons { places: below, poses: HashMap::new() }
    }
}

/// Moves the points of a prim with its skeleton, if it has one.
pub(crate) fn pose(reader: &mut Reader, prim: &str, points: Points) -> Result<Points, Error> {
    let Some(binding) = binding(reader, prim, points.open.len())? else { return Ok(points) };
    let moves = reader.stage.clock().close != reader.stage.clock().open;
    let close = points.close.as_ref().unwrap_or(&points.open);
    let mut times = [Some(points.open.clone()), moves.then(|| close.clone())];
    for (time, points) in times.iter_mut().enumerate() {
        let Some(points) = points else { continue };
        shape(reader, prim, &binding.pose.shapes[time], points, "offsets")?;
        if let Some((influences, skins)) = &binding.skin {
            *points = skins[time].points(points, influences);
        }
    }
    let is_finite = |point: &[f32; 3]| point.iter().all(|x| x.is_finite());
    // Strands may have points that are not finite already.
    let stays = |posed: &Vec<[f32; 3]>, given: &[[f32; 3]]| {
        posed.iter().zip(given).all(|(posed, given)| is_finite(posed) || !is_finite(given))
    };
    let given = [&points.open, points.close.as_ref().unwrap_or(&points.open)];
    if !times.iter().zip(given).all(|(posed, given)| posed.as_ref().is_none_or(|posed| stays(posed, given))) {
        reader.warnings.add(prim, "its skeleton moves points to infinity: it is not posed");
        return Ok(points);
    }
    let [open, close] = times;
    Ok(Points { open: open.unwrap_or_default(), close, base: points.base })
}

/// Turns the normals of polygons with their skeleton, if they have one.
pub(crate) fn turn(reader: &mut Reader, prim: &str, polygons: &mut Polygons) -> Result<(), Error> {
    let Some(mut normals) = polygons.normals.take() else { return Ok(()) };
    let is_flat = [Interpolation::Constant, Interpolation::Uniform].contains(&normals.interpolation);
    if let Some(binding) = binding(reader, prim, polygons.open.len())?.filter(|_| !is_flat) {
        let at_corners = normals.interpolation == Interpolation::FaceVarying;
        let (rows, _) = normals.values.values.as_chunks::<3>();
        let mut rows = rows.to_vec();
        if !at_corners {
            shape(reader, prim, &binding.pose.shapes[0], &mut rows, "normalOffsets")?;
        }
        if let Some((influences, [skin, _])) = &binding.skin {
            let point = |i: usize| if at_corners { polygons.indices[i] as usize } else { i };
            rows = skin.normals(&rows, (0..rows.len()).map(point), influences);
        }
        normals.values.values = rows.into_flattened();
    }
    polygons.normals = Some(normals);
    Ok(())
}

/// The nearest prim, from a prim upward, that has a property of its binding.
fn bound<'p>(stage: &Stage, prim: &'p str, name: &str) -> Result<Option<&'p str>, Error> {
    let mut nearest = None;
    for path in ancestors(prim) {
        // Those further up count as read too: the nearest one replaces them.
        if stage.has_property(path, name)? && nearest.is_none() && stage.has_api(path, BINDING)? {
            nearest = Some(path);
        }
    }
    Ok(nearest)
}

/// The target of a relationship that the prim has or inherits.
fn target(stage: &Stage, prim: &str, name: &str) -> Result<Option<String>, Error> {
    let Some(owner) = bound(stage, prim, name)? else { return Ok(None) };
    Ok(stage.targets(owner, name)?.into_iter().next())
}

fn words(stage: &Stage, prim: &str, name: &str) -> Result<Option<Vec<String>>, Error> {
    match bound(stage, prim, name)? {
        Some(owner) => stage.words(owner, name),
        None => Ok(None),
    }
}

/// What moves the points of a prim; `None` if nothing does.
fn binding(reader: &mut Reader, prim: &str, points: usize) -> Result<Option<Binding>, Error> {
    let stage = reader.stage;
    let own = stage.has_property(prim, "skel:skeleton")?;
    // A warning says why a binding has no effect.
    for path in ancestors(prim) {
        stage.know(path, &BINDINGS)?;
    }
    let Some(&place) = reader.skeletons.places.get(prim) else {
        if own {
            let what = "it is bound to a skeleton, but it is not below a SkelRoot: it is not posed, as USD defines";
            reader.warnings.add(prim, what);
        }
        return Ok(None);
    };
    let Some(skeleton) = target(stage, prim, "skel:skeleton")? else {
        if own && !stage.has_api(prim, BINDING)? {
            let what = "it is bound to a skeleton, but SkelBindingAPI is not applied: it is not posed, as USD defines";
            reader.warnings.add(prim, what);
        }
        return Ok(None);
    };
    let pose = match reader.skeletons.poses.get(&skeleton) {
        Some(known) => known.clone(),
        None => {
            let read = read(reader, &skeleton)?.map(Rc::new);
            reader.skeletons.poses.insert(skeleton, read.clone());
            read
        }
    };
    let Some(pose) = pose else { return Ok(None) };
    let influences = match influences(reader.stage, prim, points, &pose.joints)? {
        Ok(influences) => influences,
        Err(what) => {
            reader.warnings.add(prim, format!("{what}: its skeleton does not move it"));
            None
        }
    };
    let Some(influences) = influences else { return Ok(Some(Binding { pose, skin: None })) };
    let method = words(reader.stage, prim, "primvars:skel:skinningMethod")?.unwrap_or_default();
    let method = method.first().map_or("classicLinear", String::as_str);
    if !["classicLinear", "dualQuaternion"].contains(&method) {
        reader.warnings.add(prim, format!("the skinning method {method} is not supported: it is linear"));
    }
    let name = "primvars:skel:geomBindTransform";
    let bind = match bound(reader.stage, prim, name)? {
        Some(owner) => reader.stage.precise(owner, name, When::Open)?,
        None => None,
    };
    let bind = bind.map_or(Ok(DMat4::IDENTITY), |numbers| numbers.try_into().map(|m| DMat4::from_cols_array(&m)));
    let back = [0, 1].map(|time| place[time].inverse() * pose.to_world[time]);
    match bind {
        Ok(bind) if back.iter().all(DMat4::is_finite) => {
            let skin = |time: usize| {
                let joints = pose.matrices[time].clone();
                let rigid = (method == "dualQuaternion").then(|| joints.iter().map(Rigid::of).collect());
                Skin { bind, joints, rigid, back: back[time] }
            };
            let skins = [skin(0), skin(1)];
            Ok(Some(Binding { pose, skin: Some((influences, skins)) }))
        }
        _ => {
            let what = "its transform has a scale of 0, or its geomBindTransform is no matrix: it is not posed";
            reader.warnings.add(prim, what);
            Ok(None)
        }
    }
}

/// The influences of a prim by the joints of its skeleton; `None` if it has none. The inner error is a flaw of them.
fn influences(
    stage: &Stage,
    prim: &str,
    points: usize,
    joints: &[String],
) -> Result<Result<Option<Influences>, String>, Error> {
    let names = ["primvars:skel:jointIndices", "primvars:skel:jointWeights"];
    let owners = [bound(stage, prim, names[0])?, bound(stage, prim, names[1])?];
    let [Some(owner), Some(weighted)] = owners else { return Ok(Ok(None)) };
    let indices = stage.integers(owner, names[0], When::Open)?.unwrap_or_default();
    let weights = stage.numbers(weighted, names[1], When::Open)?.map_or(Vec::new(), |weights| weights.values);
    let rigid = stage.metadata(owner, names[0], "interpolation")?.is_none_or(|kind| kind == "constant");
    let elements = if rigid { 1 } else { points };
    if indices.len() != weights.len() || elements == 0 || !indices.len().is_multiple_of(elements) {
        let (a, b) = (indices.len(), weights.len());
        return Ok(Err(format!("it has {a} jointIndices and {b} jointWeights for {points} points")));
    }
    // The joints that the indices mean, if they are not those of the skeleton.
    let order = words(stage, prim, "skel:joints")?;
    let known = |index: i64| -> Option<u32> {
        let index = usize::try_from(index).ok()?;
        let index = match &order {
            Some(order) => joints.iter().position(|joint| Some(joint) == order.get(index))?,
            None => index,
        };
        u32::try_from(index).ok().filter(|&index| (index as usize) < joints.len())
    };
    let mut cache: HashMap<i64, Option<u32>> = HashMap::new();
    let mut found = Vec::with_capacity(indices.len());
    for (i, index) in indices.iter().enumerate() {
        match (*cache.entry(*index).or_insert_with(|| known(*index)), weights[i]) {
            (Some(joint), weight) if weight.is_finite() => found.push(joint),
            // Unused places of a point.
            (None, 0.0) => found.push(0),
            _ => return Ok(Err(format!("jointIndices[{i}] is {index} with the weight {}", weights[i]))),
        }
    }
    Ok(Ok(Some(Influences { joints: found, weights, each: indices.len() / elements, rigid })))
}

/// Reads a skeleton and its animation. `None` with a warning if it has no pose.
fn read(reader: &mut Reader, skeleton: &str) -> Result<Option<Pose>, Error> {
    let stage = reader.stage;
    let Some(&to_world) = reader.skeletons.places.get(skeleton) else {
        reader.warnings.add(skeleton, "there is no such skeleton below a SkelRoot: what is bound to it is not posed");
        return Ok(None);
    };
    reader.prim(skeleton)?;
    let joints = stage.words(skeleton, "joints")?.unwrap_or_default();
    let rest = stage.matrices(skeleton, "restTransforms", When::Open)?.filter(|rest| rest.len() == joints.len());
    let animation = target(stage, skeleton, "skel:animationSource")?;
    let bound = stage.matrices(skeleton, "bindTransforms", When::Open)?.unwrap_or_default();
    if bound.len() != joints.len() || bound.iter().any(|m| !m.inverse().is_finite()) {
        let (a, b) = (joints.len(), bound.len());
        let what = format!("{a} joints and {b} bindTransforms do not match: what is bound to it is not posed");
        reader.warnings.add(skeleton, what);
        return Ok(None);
    }
    if let Some(animation) = &animation {
        reader.prim(animation)?;
        // Without joints they have no effect.
        stage.know(animation, &PARTS.map(|(name, _)| name))?;
    }
    let mut flaws = Vec::new();
    let mut matrices = [Vec::new(), Vec::new()];
    let mut shapes = [HashMap::new(), HashMap::new()];
    for (time, when) in TIMES.into_iter().enumerate() {
        let mut local: Vec<Option<DMat4>> = match &rest {
            Some(rest) => rest.iter().copied().map(Some).collect(),
            None => vec![None; joints.len()],
        };
        if let Some(animation) = &animation {
            match animated(stage, animation, when)? {
                Ok(animated) => {
                    for (name, matrix) in animated {
                        joints.iter().zip(&mut local).filter(|(joint, _)| **joint == name).for_each(|(_, own)| {
                            *own = Some(matrix);
                        });
                    }
                }
                Err(what) => flaws.push((animation.clone(), format!("{what}: the skeleton has its rest pose"))),
            }
            let names = stage.words(animation, "blendShapes")?.unwrap_or_default();
            let weights = stage.numbers(animation, "blendShapeWeights", when)?.map_or(Vec::new(), |n| n.values);
            shapes[time] = names.into_iter().zip(weights).filter(|(_, weight)| weight.is_finite()).collect();
        }
        if local.iter().any(Option::is_none) {
            let what =
                "it has no restTransforms for each joint: joints without an animation stay where they were bound";
            flaws.push((skeleton.to_owned(), what.to_owned()));
        }
        let above = parents(&joints);
        // Where nothing is known, the transform to the parent follows from the places when bound.
        let at_bind = |i: usize| above[i].map_or(DMat4::IDENTITY, |parent| bound[parent].inverse()) * bound[i];
        let local: Vec<DMat4> = (0..joints.len()).map(|i| local[i].unwrap_or_else(|| at_bind(i))).collect();
        let whole = concatenate(&above, &local);
        matrices[time] = whole.iter().zip(&bound).map(|(now, bound)| *now * bound.inverse()).collect();
    }
    for (prim, what) in flaws {
        reader.warnings.add(&prim, what);
    }
    Ok(Some(Pose { joints, matrices, shapes, to_world }))
}

/// The parts of the transforms of joints, and their numbers.
const PARTS: [(&str, usize); 3] = [("translations", 3), ("rotations", 4), ("scales", 3)];

/// The joints of an animation with their transforms. The inner error is a flaw of it.
fn animated(stage: &Stage, prim: &str, when: When) -> Result<Result<Vec<(String, DMat4)>, String>, Error> {
    let joints = stage.words(prim, "joints")?.unwrap_or_default();
    let mut parts = Vec::new();
    for (name, lanes) in PARTS {
        match stage.numbers(prim, name, when)? {
            _ if joints.is_empty() => return Ok(Ok(Vec::new())),
            Some(part) if part.lanes == lanes && part.len() == joints.len() => parts.push(part),
            other => {
                let given = other.map_or(0, |part| part.len());
                return Ok(Err(format!("it has {} joints, but {given} {name}", joints.len())));
            }
        }
    }
    let at = |i: usize| joint(parts[0].row(i), parts[1].row(i), parts[2].row(i));
    let all: Vec<_> = joints.into_iter().enumerate().map(|(i, name)| (name, at(i))).collect();
    match all.iter().find(|(_, matrix)| !matrix.is_finite()) {
        Some((name, _)) => Ok(Err(format!("the joint {name} must be finite"))),
        None => Ok(Ok(all)),
    }
}

/// The offsets that give a shape at a weight, with their own weights: those of the two shapes around it. The points
/// themselves have the weight 0, and the whole shape has 1.
fn between(stage: &Stage, shape: &str, weight: f32, offsets: &str) -> Result<Vec<(String, f32)>, Error> {
    let properties = stage.properties(shape)?;
    let names: Vec<&str> = properties.iter().filter(|name| name.starts_with(INBETWEEN)).collect();
    stage.know(shape, &names)?;
    let mut shapes = vec![(0.0, None), (1.0, Some(offsets.to_owned()))];
    for name in names.iter().filter(|name| !name[INBETWEEN.len()..].contains(':')) {
        let at = stage.metadata_number(shape, name, "weight")?.filter(|at| at.is_finite() && ![0.0, 1.0].contains(at));
        let of_normals = if offsets == "offsets" { String::new() } else { format!(":{offsets}") };
        shapes.extend(at.map(|at| (at, Some(format!("{name}{of_normals}")))));
    }
    shapes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let weight = f64::from(weight);
    let next = shapes.partition_point(|(at, _)| *at <= weight).clamp(1, shapes.len() - 1);
    let [(a, before), (b, behind)] = [shapes[next - 1].clone(), shapes[next].clone()];
    let share = ((weight - a) / (b - a)) as f32;
    let pairs = [(before, 1.0 - share), (behind, share)];
    Ok(pairs.into_iter().filter_map(|(name, share)| Some((name?, share)).filter(|(_, share)| *share != 0.0)).collect())
}

/// How the names of shapes begin that a shape has at other weights than 1.
const INBETWEEN: &str = "inbetweens:";

/// Adds the blend shapes of a prim to its points (`offsets`) or to their normals (`normalOffsets`).
fn shape(
    reader: &mut Reader,
    prim: &str,
    weights: &HashMap<String, f32>,
    points: &mut [[f32; 3]],
    offsets: &str,
) -> Result<(), Error> {
    let stage = reader.stage;
    let names = words(stage, prim, "skel:blendShapes")?.unwrap_or_default();
    let targets = match bound(stage, prim, "skel:blendShapeTargets")? {
        Some(owner) if !names.is_empty() => stage.targets(owner, "skel:blendShapeTargets")?,
        _ => return Ok(()),
    };
    let mut flaws = Vec::new();
    for (name, target) in names.iter().zip(&targets) {
        let Some(&weight) = weights.get(name).filter(|weight| **weight != 0.0) else { continue };
        reader.prim(target)?;
        stage.know(target, &["offsets", "normalOffsets"])?;
        let indices = stage.integers(target, "pointIndices", When::Open)?;
        for (name, weight) in between(stage, target, weight, offsets)? {
            let Some(rows) = stage.numbers(target, &name, When::Open)? else { continue };
            let fits = rows.lanes == 3
                && rows.values.iter().all(|x| x.is_finite())
                && blend(points, rows.values.as_chunks::<3>().0, indices.as_deref(), weight);
            if !fits {
                flaws.push((target, "its offsets do not match the points of the mesh: it is ignored"));
            }
        }
    }
    for (target, what) in flaws {
        reader.warnings.add(target, what);
    }
    Ok(())
}
