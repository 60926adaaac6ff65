//! Reads meshes (UsdGeomMesh) as triangles.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::light;
use crate::read::motion::{Points, points};
use crate::read::paint::paint;
use crate::read::parts::{Parts, parts};
use crate::read::polygons::Polygons;
use crate::read::primvar::{Interpolation, Primvar, primvar};
use crate::read::skeleton::turn;
use crate::read::subdivision::subdivide;
use crate::read::xform::Place;
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3};
use vellus_scene::{Mesh, Surface, Tint, triangulate};

/// A triangle: its face, and for each corner the index of the point and the index among the corners of all faces.
struct Triangle {
    face: usize,
    points: [u32; 3],
    corners: [usize; 3],
}

/// The colour of a mesh without a material.
const DISPLAY_COLOR: &str = "primvars:displayColor";

/// Reads a mesh.
pub(crate) fn read(reader: &mut Reader, place: &Place) -> Result<(), Error> {
    let prim = place.path.as_str();
    let stage = reader.stage;
    let handle = reader.prim(prim)?;
    let word = |name: &str| stage.words(prim, name).map(|words| words.unwrap_or_default().into_iter().next());
    let left_handed = word("orientation")?.as_deref() == Some("leftHanded");
    let Points { open, close, base } = points(reader, handle, &["faceVertexCounts", "faceVertexIndices"])?;
    for points in [Some(&open), close.as_ref()].into_iter().flatten() {
        if let Some(i) = points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(Error::prim(prim, format!("points[{i}] is {:?}: it must be finite", points[i])));
        }
    }
    if open.is_empty() {
        reader.warnings.add(prim, "it has no points");
        return Ok(());
    }
    let counts = stage.integers(prim, "faceVertexCounts", base)?.unwrap_or_default();
    let indices = stage.integers(prim, "faceVertexIndices", base)?.unwrap_or_default();
    let holes = stage.integers(prim, "holeIndices", base)?.unwrap_or_default();
    check(prim, &counts, &indices, open.len())?;
    let Parts { surfaces, faces: parts } = parts(reader, prim, counts.len(), base)?;
    if surfaces.iter().all(Option::is_none) {
        return Ok(());
    }
    let textures = surfaces.iter().flatten().flat_map(|&surface| {
        let Surface { color, opacity, normals, .. } = &reader.scene.surfaces[surface];
        color.texture.into_iter().chain(opacity.texture).chain(normals.map(|map| map.texture))
    });
    let textures: Vec<usize> = textures.collect();
    let texture = textures.first();
    let (points_count, faces, corners) = (open.len(), counts.len(), indices.len());
    let size = |interpolation| match interpolation {
        Interpolation::Constant => 1,
        Interpolation::Uniform => faces,
        Interpolation::Varying | Interpolation::Vertex => points_count,
        Interpolation::FaceVarying => corners,
    };
    let checked = |name: &str, fallback, lanes| -> Result<Option<Primvar>, Error> {
        let Some(primvar) = primvar(stage, prim, name, fallback, base)? else { return Ok(None) };
        let (given, expected) = (primvar.values.len(), size(primvar.interpolation));
        if given != expected || primvar.values.lanes != lanes {
            let kind = primvar.interpolation;
            let what = format!(
                "{name} has {given} values, but with {kind:?} interpolation there must be {expected}, of {lanes} \
                 numbers each"
            );
            return Err(Error::prim(prim, what));
        }
        Ok(Some(primvar))
    };
    stage.know(prim, &["normals"])?;
    // Normals and texture coordinates that cannot be read do not hide the mesh.
    let normals = match checked("primvars:normals", Interpolation::Constant, 3) {
        Ok(None) => checked("normals", Interpolation::Vertex, 3),
        found => found,
    };
    let normals = normals.or_else(|error| reader.ignore(prim, error).map(|()| None))?;
    let asked: Vec<String> = textures
        .iter()
        .filter_map(|texture| reader.uv_sets.get(texture))
        .map(|set| format!("primvars:{set}"))
        .collect();
    if asked.iter().any(|set| *set != asked[0]) {
        let what =
            format!("its materials have several texture coordinates, which is not supported: {} is used", asked[0]);
        reader.warnings.add(prim, what);
    }
    let asked = asked.into_iter().next();
    let mut uv = None;
    for name in asked.iter().map(String::as_str).chain(["primvars:st", "primvars:uv"]) {
        uv = checked(name, Interpolation::Constant, 2).or_else(|error| reader.ignore(prim, error).map(|()| None))?;
        if uv.is_some() {
            break;
        }
    }
    if texture.is_some() && uv.is_none() {
        let name = asked.as_deref().unwrap_or("primvars:st");
        reader.warnings.add(prim, format!("its material has a texture, but it has no {name}: one texel is everywhere"));
    }
    let is_plain = texture.is_none() && surfaces == [reader.surfaces.get(prim).copied()];
    if is_plain && let Some(mut colors) = checked(DISPLAY_COLOR, Interpolation::Constant, 3).unwrap_or(None) {
        reader.convert(prim, DISPLAY_COLOR, colors.space.clone().as_deref(), &mut colors.values)?;
        let first = colors.values.values.first_chunk::<3>();
        let values = colors.values.values.as_chunks::<3>().0;
        // The surface has warned of colours that are not finite.
        if values.iter().any(|color| Some(color) != first) && values.iter().flatten().all(|x| x.is_finite()) {
            uv = Some(colors);
        }
    }
    let mut polygons = Polygons { counts, indices, holes, parts, open, close, normals, uv };
    turn(reader, prim, &mut polygons)?;
    let polygons = subdivide(reader, place, left_handed, polygons, base)?;
    show(reader, place, left_handed, polygons, &surfaces)
}

/// Adds polygons to the scene as triangles, by [`triangulate`]: one mesh for each part. `surfaces` are those of the
/// parts; those without one are left out.
pub(crate) fn show(
    reader: &mut Reader,
    place: &Place,
    left_handed: bool,
    polygons: Polygons,
    surfaces: &[Option<usize>],
) -> Result<(), Error> {
    let prim = place.path.as_str();
    // Left-handed orientation and a mirroring transform both reverse the order of corners.
    let flipped = left_handed != (place.to_world.determinant() < 0.0);
    let (triangles, crossed) = triangles(&polygons, flipped);
    if crossed > 0 {
        let faces = polygons.counts.len();
        let what = format!("{crossed} of its {faces} faces cross themselves: they may be larger than they are");
        reader.warnings.add(prim, what);
    }
    let Polygons { open, close, normals, uv, parts, .. } = polygons;
    // A constant uv has no effect. Neither has one normal for a whole face: triangles are flat anyway.
    let uv = uv.filter(|uv| uv.interpolation != Interpolation::Constant);
    let flat = [Interpolation::Constant, Interpolation::Uniform];
    let normals = normals.filter(|normals| !flat.contains(&normals.interpolation));

    let matrix = place.to_world;
    let is_identity = matrix == DMat4::IDENTITY;
    let to_world = |points: Vec<[f32; 3]>, matrix: &DMat4| -> Vec<Vec3> {
        points.into_iter().map(|p| matrix.transform_point3(DVec3::from(p.map(f64::from))).as_vec3()).collect()
    };
    let mut positions = to_world(open, &matrix);
    let mut moved = close.map(|close| to_world(close, &place.moved)).filter(|closed| *closed != positions);
    let linear = DMat3::from_mat4(matrix);
    let normal_matrix = if linear.determinant() == 0.0 { linear } else { linear.inverse().transpose() };
    let normal = |row: &[f32]| {
        let n = Vec3::from_slice(row);
        if is_identity { n } else { (normal_matrix * n.as_dvec3()).normalize_or_zero().as_vec3() }
    };
    for (part, surface) in surfaces.iter().enumerate() {
        let Some(mut surface) = *surface else { continue };
        let is_last = part + 1 == surfaces.len();
        let own: Vec<&Triangle> = triangles.iter().filter(|t| parts.get(t.face).is_none_or(|p| *p == part)).collect();
        if own.is_empty() && surfaces.len() > 1 {
            continue;
        }
        let color = |row: &[f32]| std::array::from_fn::<f32, 3, _>(|c| row[c].clamp(0.0, 1.0));
        let uv = match &uv {
            Some(colors) if colors.values.lanes == 3 => {
                let colors: Vec<_> = own.iter().map(|t| corners_of(t, colors, color)).collect();
                let (uv, painted) = painted(reader, prim, surface, &colors)?;
                surface = painted;
                Some(uv)
            }
            uv => uv.as_ref().map(|uv| own.iter().map(|t| corners_of(t, uv, Vec2::from_slice)).collect()),
        };
        let mut mesh = Mesh {
            name: prim.to_owned(),
            // Most meshes have one part, and no second copy.
            positions: if is_last { std::mem::take(&mut positions) } else { positions.clone() },
            moved: if is_last { moved.take() } else { moved.clone() },
            normals: normals.as_ref().map(|n| own.iter().map(|t| corners_of(t, n, normal)).collect()),
            uv,
            triangles: own.iter().map(|t| t.points).collect(),
            surface: 0,
        };
        if surfaces.len() > 1 {
            compact(&mut mesh);
        }
        mesh.validate()?;
        let surface = light::of_mesh(reader, prim, &mesh, surface)?;
        let name = reader.name(prim)?;
        reader.scene.meshes.push(Mesh { name, surface, ..mesh });
    }
    Ok(())
}

/// Removes the vertices that no triangle has.
fn compact(mesh: &mut Mesh) {
    let mut kept = Vec::new();
    let mut place = vec![u32::MAX; mesh.positions.len()];
    for vertex in mesh.triangles.iter_mut().flatten() {
        let place = &mut place[*vertex as usize];
        if *place == u32::MAX {
            *place = kept.len() as u32;
            kept.push(*vertex as usize);
        }
        *vertex = *place;
    }
    mesh.positions = kept.iter().map(|&i| mesh.positions[i]).collect();
    mesh.moved = mesh.moved.as_ref().map(|moved| kept.iter().map(|&i| moved[i]).collect());
}

/// A surface with colours that vary: texture coordinates of the triangles, and the index of the new surface.
fn painted(
    reader: &mut Reader,
    prim: &str,
    surface: usize,
    colors: &[[[f32; 3]; 3]],
) -> Result<(Vec<[Vec2; 3]>, usize), Error> {
    let (image, uv) = paint(&reader.name(prim)?, colors);
    reader.images.image(&image, 0).map_err(|what| Error::prim(prim, what))?;
    let texture = reader.add_texture(image, None);
    let color = Tint { color: [1.0; 3], texture: Some(texture) };
    let own = &reader.scene.surfaces[surface];
    reader.scene.surfaces.push(Surface { color, ..own.clone() });
    Ok((uv, reader.scene.surfaces.len() - 1))
}

/// Checks that counts and indices are consistent.
fn check(prim: &str, counts: &[i64], indices: &[i64], points: usize) -> Result<(), Error> {
    let fail = |what: String| Err(Error::prim(prim, what));
    let sum = counts.iter().fold(0i64, |sum, &n| sum.saturating_add(n.max(0)));
    if let Some(face) = counts.iter().position(|&n| n < 3) {
        return fail(format!("faceVertexCounts[{face}] is {}: a face has at least 3 corners", counts[face]));
    }
    if usize::try_from(sum) != Ok(indices.len()) {
        return fail(format!("faceVertexCounts add up to {sum}, but there are {} faceVertexIndices", indices.len()));
    }
    let exists = |index: &i64| usize::try_from(*index).is_ok_and(|index| index < points) && *index <= u32::MAX.into();
    if let Some(i) = indices.iter().position(|index| !exists(index)) {
        return fail(format!("faceVertexIndices[{i}] is {}, but there are {points} points", indices[i]));
    }
    Ok(())
}

/// The triangles, and the number of faces that have none which cover them once.
fn triangles(polygons: &Polygons, flipped: bool) -> (Vec<Triangle>, usize) {
    let Polygons { counts, indices, holes, open, .. } = polygons;
    let holes: std::collections::HashSet<i64> = holes.iter().copied().collect();
    // A face has fewer triangles than corners.
    let mut triangles = Vec::with_capacity(indices.len());
    let (mut polygon, mut crossed) = (Vec::new(), 0);
    let mut first = 0usize;
    for (face, &count) in counts.iter().enumerate() {
        // `check` makes sure that these numbers fit.
        let end = first + count as usize;
        if !holes.contains(&(face as i64)) {
            polygon.clear();
            polygon.extend(indices[first..end].iter().map(|&i| Vec3::from(open[i as usize])));
            let is_simple = triangulate(&polygon, |[a, b, c]| {
                let corners = if flipped { [a, c, b] } else { [a, b, c] }.map(|i| first + i);
                triangles.push(Triangle { face, points: corners.map(|c| indices[c] as u32), corners });
            });
            crossed += usize::from(!is_simple);
        }
        first = end;
    }
    (triangles, crossed)
}

/// The values at the corners of a triangle.
fn corners_of<T>(triangle: &Triangle, primvar: &Primvar, convert: impl Fn(&[f32]) -> T) -> [T; 3] {
    std::array::from_fn(|i| {
        convert(primvar.values.row(match primvar.interpolation {
            Interpolation::Constant => 0,
            Interpolation::Uniform => triangle.face,
            Interpolation::Varying | Interpolation::Vertex => triangle.points[i] as usize,
            Interpolation::FaceVarying => triangle.corners[i],
        }))
    })
}
