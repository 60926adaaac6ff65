//! Reads subdivision surfaces (UsdGeomMesh): refines them until their edges are short in the picture.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::polygons::Polygons;
use crate::read::primvar::{Interpolation, Primvar};
use crate::read::xform::Place;
use crate::stage::{Numbers, Stage, When};
use crate::subdivide::{Boundary, Cage, FaceVarying, Scheme, Subdivision};
use glam::{BVec3, DVec3};
use vellus_scene::Camera;

/// The length of edges, relative to the height of the picture. It is 4 pixels of 1080.
const IN_PICTURE: f64 = 1.0 / 256.0;

/// The length of edges relative to the diagonal of the mesh, where no camera is known.
const IN_MESH: f64 = 1.0 / 128.0;

/// The length of edges relative to the diagonal of the stage, if it has no camera. It is 2 pixels of 1080 where the
/// stage fills the picture.
const IN_STAGE: f64 = 1.0 / 512.0;

/// The share of edges that are as short. The others are a few large faces of an uneven mesh.
const SHARE: f64 = 0.95;

/// The most levels: each face has at most 4⁶ parts.
const MAX_LEVELS: usize = 6;

/// The largest number of faces of a mesh, and of all meshes, that refinement may bring. A face needs about 310
/// bytes while it is refined, and 120 after that.
const MAX_FACES: usize = 1 << 19;
const MAX_ALL_FACES: usize = 1 << 20;

/// The sharpness from which on a crease is sharp at every level (OpenSubdiv).
const INFINITELY_SHARP: f32 = 10.0;

/// Where no camera is known, all meshes of a stage have the same share, but not less than this.
const LEAST_SHARE: usize = 1 << 12;

/// Replaces the faces of a mesh by those of its limit surface, if it has a scheme. Authored normals are not used, as
/// USD defines.
pub(crate) fn subdivide(
    reader: &mut Reader,
    place: &Place,
    left_handed: bool,
    mut polygons: Polygons,
    base: When,
) -> Result<Polygons, Error> {
    let prim = place.path.as_str();
    // Without a scheme they have no effect.
    reader.stage.know(prim, &TAGS)?;
    let scheme = word(reader.stage, prim, "subdivisionScheme")?.unwrap_or_else(|| "catmullClark".to_owned());
    let scheme = match scheme.as_str() {
        "none" => return Ok(polygons),
        "catmullClark" => Scheme::CatmullClark,
        "loop" if polygons.counts.iter().all(|n| *n == 3) => Scheme::Loop,
        "loop" => {
            let what =
                "the subdivision scheme loop is for triangles, but it has other polygons: they are not subdivided";
            reader.warnings.add(prim, what);
            return Ok(polygons);
        }
        "bilinear" => Scheme::Bilinear,
        other => {
            let known = "catmullClark, loop, bilinear and none";
            let what = format!("the subdivision scheme {other} is not known: known are {known}; it is not subdivided");
            reader.warnings.add(prim, what);
            return Ok(polygons);
        }
    };
    if scheme == Scheme::Bilinear && is_flat(&polygons) {
        polygons.normals = None;
        return Ok(polygons);
    }
    // Refined faces are counted with 32 bits.
    if polygons.indices.len() > u32::MAX as usize / 64 {
        reader.warnings.add(prim, "it has too many corners to be subdivided: at most 67 million");
        return Ok(polygons);
    }
    let mut tags = tags(reader, prim, &polygons, base)?;
    // `Polygons` has checked these numbers.
    let narrow = |values: &[i64]| -> Vec<u32> { values.iter().map(|&x| x as u32).collect() };
    let (counts, corners) = (narrow(&polygons.counts), narrow(&polygons.indices));
    let mut surface = Subdivision::new(&Cage {
        scheme,
        counts: &counts,
        corners: &corners,
        vertices: polygons.open.len(),
        creases: &tags.creases,
        sharp: &tags.corners,
        boundary: tags.boundary,
    });
    let times = levels(reader, place, &surface, &polygons, least_level(scheme, &counts, &tags));
    if times.0 < times.1 {
        let what = format!(
            "it is subdivided {} times instead of {}: its edges may show, because there are too many faces",
            times.0, times.1
        );
        reader.warnings.add(prim, what);
    }
    surface.refine(times.0);
    reader.refined += surface.finest().face_count();
    if tags.boundary == Boundary::None {
        let hidden = surface.cage().at_border();
        tags.holes.extend(hidden.iter().enumerate().filter(|(_, hidden)| **hidden).map(|(face, _)| face as i64));
    }
    Ok(fine(&surface, &tags, polygons, left_handed))
}

/// The faces of the limit surface.
fn fine(surface: &Subdivision, tags: &Tags, polygons: Polygons, left_handed: bool) -> Polygons {
    let refined = surface.refined(&polygons.open);
    let mut normals = surface.normals(&refined);
    if left_handed {
        normals.iter_mut().flatten().for_each(|x| *x = -*x);
    }
    let hidden: std::collections::HashSet<i64> = polygons.holes.iter().chain(&tags.holes).copied().collect();
    let finest = surface.finest();
    let holes = (0..finest.face_count()).filter(|&face| hidden.contains(&(surface.source(face) as i64)));
    let holes = if hidden.is_empty() { Vec::new() } else { holes.map(|face| face as i64).collect() };
    Polygons {
        counts: vec![finest.face(0).len() as i64; finest.face_count()],
        indices: finest.corners().iter().map(|&vertex| i64::from(vertex)).collect(),
        holes,
        parts: if polygons.parts.is_empty() {
            Vec::new()
        } else {
            (0..finest.face_count()).map(|face| polygons.parts[surface.source(face)]).collect()
        },
        open: surface.limit(&refined),
        close: polygons.close.map(|close| surface.limit(&surface.refined(&close))),
        normals: Some(at_corners(normals.into_flattened(), 3)),
        uv: polygons.uv.map(|uv| match uv.values.lanes {
            3 => fine_values::<3>(surface, tags.rule, uv),
            _ => fine_values::<2>(surface, tags.rule, uv),
        }),
    }
}

fn at_corners(values: Vec<f32>, lanes: usize) -> Primvar {
    Primvar { values: Numbers { values, lanes }, interpolation: Interpolation::FaceVarying, space: None }
}

fn fine_values<const N: usize>(surface: &Subdivision, rule: FaceVarying, uv: Primvar) -> Primvar {
    let (rows, _) = uv.values.values.as_chunks::<N>();
    let at =
        |values: Vec<[f32; N]>| Primvar { values: Numbers { values: values.into_flattened(), lanes: N }, ..uv.clone() };
    match uv.interpolation {
        Interpolation::Constant => uv,
        Interpolation::Uniform => {
            at((0..surface.finest().face_count()).map(|face| rows[surface.source(face)]).collect())
        }
        Interpolation::Varying => at(surface.varying(rows)),
        Interpolation::Vertex => at(surface.limit(&surface.refined(rows))),
        Interpolation::FaceVarying => at(surface.face_varying(rows, rule)),
    }
}

/// Whether all faces are plane, to a millionth of the size of the mesh.
fn is_flat(polygons: &Polygons) -> bool {
    let point = |&i: &i64| DVec3::from(polygons.open[i as usize].map(f64::from));
    let bound = 1e-6 * diagonal(polygons.open.iter().map(|p| DVec3::from(p.map(f64::from))));
    let mut rest = &polygons.indices[..];
    polygons.close.is_none()
        && polygons.counts.iter().all(|&count| {
            let (face, after) = rest.split_at(count as usize);
            rest = after;
            let first = point(&face[0]);
            let fan = face[1..].windows(2).map(|pair| (point(&pair[0]) - first).cross(point(&pair[1]) - first));
            let normal = fan.sum::<DVec3>().normalize_or_zero();
            face.iter().all(|i| (point(i) - first).dot(normal).abs() <= bound)
        })
}

/// The diagonal of all meshes by their `extent`, in world space. 0 if it is not known.
pub(crate) fn stage_size(reader: &Reader, places: &[Place]) -> f64 {
    let mut corners = Vec::new();
    for place in places.iter().filter(|place| place.shown && place.type_name == "Mesh") {
        // It is only a hint: one that cannot be read has no effect.
        let Ok(Some(extent)) = reader.stage.numbers(&place.path, "extent", When::Open) else { continue };
        let &[a, b, c, d, e, f] = &extent.values[..] else { continue };
        let (low, high) = (DVec3::from([a, b, c].map(f64::from)), DVec3::from([d, e, f].map(f64::from)));
        let corner = |i: u32| DVec3::select(BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
        corners.extend((0..8).map(|i| place.to_world.transform_point3(corner(i))).filter(|p| p.is_finite()));
    }
    if corners.is_empty() { 0.0 } else { diagonal(corners.into_iter()) }
}

fn diagonal(points: impl Iterator<Item = DVec3>) -> f64 {
    let (low, high) = points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    (high - low).length()
}

/// How many times a mesh is refined, and how many times it would be without a bound on the number of faces.
fn levels(reader: &Reader, place: &Place, surface: &Subdivision, polygons: &Polygons, least: usize) -> (usize, usize) {
    let point = |p: &[f32; 3]| place.to_world.transform_point3(DVec3::from(p.map(f64::from)));
    let in_stage = IN_STAGE * reader.stage_size * reader.local_scale;
    let target = in_stage.max(IN_MESH * diagonal(polygons.open.iter().map(point)));
    let ends = surface.cage().ends().map(|ends| ends.map(|vertex| point(&polygons.open[vertex as usize])));
    let mut lengths: Vec<f64> = ends.map(|ends| relative_length(ends, reader.eye.as_ref(), target)).collect();
    let share = match reader.eye {
        Some(_) => MAX_FACES,
        None => (MAX_ALL_FACES / reader.meshes.max(1)).clamp(LEAST_SHARE, MAX_FACES),
    };
    let finest = share.min(MAX_ALL_FACES.saturating_sub(reader.refined));
    let rank = ((SHARE * lengths.len() as f64) as usize).min(lengths.len().saturating_sub(1));
    let length = if lengths.is_empty() { 0.0 } else { *lengths.select_nth_unstable_by(rank, f64::total_cmp).1 };
    // Infinities and NaN are bounded too.
    let wanted = length.log2().ceil().clamp(least as f64, MAX_LEVELS as f64) as usize;
    // The first level of quads has a face for each corner of the cage.
    let fits = |times: &usize| polygons.indices.len().saturating_mul(4usize.pow(*times as u32)) / 4 <= finest;
    let times = (least..=wanted).rev().find(fits).unwrap_or(least);
    (times, wanted)
}

/// The level at which a surface with too many faces stays. The vertices of the cage move to the limit as they are, if
/// its faces are those of the scheme, and no crease is sharp for some levels only.
fn least_level(scheme: Scheme, counts: &[u32], tags: &Tags) -> usize {
    let sides = if scheme == Scheme::Loop { 3 } else { 4 };
    let is_sharp = |sharpness: f32| sharpness <= 0.0 || sharpness >= INFINITELY_SHARP;
    let is_regular = counts.iter().all(|&count| count == sides)
        && tags.creases.iter().all(|(_, sharpness)| is_sharp(*sharpness))
        && tags.corners.iter().all(|(_, sharpness)| is_sharp(*sharpness));
    usize::from(!is_regular)
}

/// The length of an edge over the length that it may have.
fn relative_length(ends: [DVec3; 2], camera: Option<&Camera>, target: f64) -> f64 {
    let length = ends[0].distance(ends[1]);
    match camera {
        None => length / target,
        Some(camera) => {
            let eye = camera.to_world.w_axis.truncate().as_dvec3();
            let distance = eye.distance(ends[0]).min(eye.distance(ends[1]));
            length / (IN_PICTURE * f64::from(camera.film_height) * distance)
        }
    }
}

/// What a mesh says about its surface.
struct Tags {
    creases: Vec<([u32; 2], f32)>,
    corners: Vec<(u32, f32)>,
    boundary: Boundary,
    rule: FaceVarying,
    /// More faces that are not shown.
    holes: Vec<i64>,
}

fn word(stage: &Stage, prim: &str, name: &str) -> Result<Option<String>, Error> {
    Ok(stage.words(prim, name)?.and_then(|words| words.into_iter().next()))
}

/// The attributes of [`Tags`].
const TAGS: [&str; 8] = [
    "creaseIndices",
    "creaseLengths",
    "creaseSharpnesses",
    "cornerIndices",
    "cornerSharpnesses",
    "interpolateBoundary",
    "faceVaryingLinearInterpolation",
    "triangleSubdivisionRule",
];

/// Reads the tags at the time of the topology.
fn tags(reader: &mut Reader, prim: &str, polygons: &Polygons, base: When) -> Result<Tags, Error> {
    let stage = reader.stage;
    let numbers = |name: &str| Ok::<_, Error>(stage.numbers(prim, name, base)?.map_or(Vec::new(), |n| n.values));
    let integers = |name: &str| Ok::<_, Error>(stage.integers(prim, name, base)?.unwrap_or_default());
    let points = polygons.open.len();
    let creases =
        creases(&integers("creaseIndices")?, &integers("creaseLengths")?, &numbers("creaseSharpnesses")?, points);
    let corners = corners(&integers("cornerIndices")?, &numbers("cornerSharpnesses")?, points);
    let boundary = match word(stage, prim, "interpolateBoundary")?.as_deref() {
        None | Some("edgeAndCorner") => Some(Boundary::EdgesAndCorners),
        Some("edgeOnly") => Some(Boundary::Edges),
        Some("none") => Some(Boundary::None),
        Some(_) => None,
    };
    let rule = match word(stage, prim, "faceVaryingLinearInterpolation")?.as_deref() {
        None | Some("cornersPlus1") => Some(FaceVarying::CornersPlus1),
        Some("none") => Some(FaceVarying::None),
        Some("cornersOnly") => Some(FaceVarying::Corners),
        Some("cornersPlus2") => Some(FaceVarying::CornersPlus2),
        Some("boundaries") => Some(FaceVarying::Boundaries),
        Some("all") => Some(FaceVarying::All),
        Some(_) => None,
    };
    let smooth = word(stage, prim, "triangleSubdivisionRule")?.is_some_and(|rule| rule == "smooth");
    let missing = [
        (creases.is_none(), "its creases are inconsistent and are ignored"),
        (corners.is_none(), "its sharp corners are inconsistent and are ignored"),
        (boundary.is_none(), "interpolateBoundary must be none, edgeOnly or edgeAndCorner: edgeAndCorner is used"),
        (rule.is_none(), "faceVaryingLinearInterpolation has an unknown value: cornersPlus1 is used"),
        (smooth, "triangleSubdivisionRule = smooth is not supported: catmullClark is used"),
    ];
    for (_, what) in missing.iter().filter(|(is_missing, _)| *is_missing) {
        reader.warnings.add(prim, *what);
    }
    Ok(Tags {
        creases: creases.unwrap_or_default(),
        corners: corners.unwrap_or_default(),
        boundary: boundary.unwrap_or(Boundary::EdgesAndCorners),
        rule: rule.unwrap_or(FaceVarying::CornersPlus1),
        holes: Vec::new(),
    })
}

/// The edges of creases with their sharpness. There is one sharpness for each crease, or one for each edge.
fn creases(indices: &[i64], lengths: &[i64], sharpness: &[f32], points: usize) -> Option<Vec<([u32; 2], f32)>> {
    let known = |&i: &i64| u32::try_from(i).ok().filter(|&i| (i as usize) < points);
    let mut rest = indices;
    let mut edges = Vec::new();
    for (crease, &length) in lengths.iter().enumerate() {
        let (own, after) = rest.split_at_checked(usize::try_from(length).ok().filter(|&n| n >= 2)?)?;
        rest = after;
        for pair in own.windows(2) {
            edges.push(([known(&pair[0])?, known(&pair[1])?], crease));
        }
    }
    let of = |(edge, crease): (usize, usize)| match sharpness.len() {
        n if n == lengths.len() => Some(sharpness[crease]),
        n if n == edges.len() => Some(sharpness[edge]),
        _ => None,
    };
    if !rest.is_empty() || sharpness.iter().any(|s| s.is_nan()) {
        return None;
    }
    edges.iter().enumerate().map(|(i, &(ends, crease))| Some((ends, of((i, crease))?))).collect()
}

/// The sharp corners. There is one sharpness for each, or one for all.
fn corners(indices: &[i64], sharpness: &[f32], points: usize) -> Option<Vec<(u32, f32)>> {
    let of = |i: usize| sharpness.get(if sharpness.len() == 1 { 0 } else { i }).filter(|s| !s.is_nan()).copied();
    if ![1, indices.len()].contains(&sharpness.len()) && !indices.is_empty() {
        return None;
    }
    let known = |&i: &i64| u32::try_from(i).ok().filter(|&i| (i as usize) < points);
    indices.iter().enumerate().map(|(i, index)| Some((known(index)?, of(i)?))).collect()
}
