//! Writes strands, meshes, camera and lights.

use crate::read::light::{POINT, SEEN_BY_RENDERMAN};
use crate::read::link::LINKS;
use crate::write::custom::custom as write_custom;
use crate::write::encoder::{Encoder, Role};
use crate::write::names::{Names, plain, to_file, vellus_name};
use crate::write::value::{Array, Asset, Token};

use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};
use std::io;
use vellus_scene::{Basis, Camera, Custom, Fit, Instance, Light, LightShape, Link, Mesh, Objects, Strands, Values};

/// Prims with a material.
const BINDS: Role = Role::Applies("MaterialBindingAPI");

fn extent(out: &mut dyn Encoder, points: impl Iterator<Item = Vec3>, radius: f32) -> io::Result<()> {
    let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    if low.is_finite() && high.is_finite() {
        out.set("float3[] extent", &Array([(low - radius).to_array(), (high + radius).to_array()].into_iter()))?;
    }
    Ok(())
}

/// Writes strands in the prim `parent`, which is open.
pub(crate) fn strands(
    out: &mut dyn Encoder,
    parent: &str,
    strands: &Strands,
    custom: &[&Custom],
    names: &mut Names,
) -> io::Result<()> {
    let name = names.unused(parent, &strands.name);
    out.open("BasisCurves", &name, BINDS)?;
    let (kind, basis) = match strands.basis {
        Basis::Linear => ("linear", None),
        Basis::BSpline => ("cubic", Some("bspline")),
        Basis::CatmullRom => ("cubic", Some("catmullRom")),
        Basis::Bezier => ("cubic", Some("bezier")),
    };
    out.set("uniform token type", &Token(kind))?;
    if let Some(basis) = basis {
        out.set("uniform token basis", &Token(basis))?;
    }
    out.set("uniform token wrap", &Token("nonperiodic"))?;
    out.set("int[] curveVertexCounts", &Array(strands.starts.windows(2).map(|pair| pair[1] - pair[0])))?;
    let radius = strands.points.iter().fold(0.0f32, |radius, p| radius.max(p.w));
    let moved = strands.moved.iter().flatten().copied();
    extent(out, strands.points.iter().map(|p| p.truncate()).chain(moved), radius)?;
    let points = || strands.points.iter().map(|p| p.truncate().to_array());
    match &strands.moved {
        Some(moved) => out.samples("point3f[] points", &Array(points()), &Array(moved.iter().map(|p| p.to_array())))?,
        None => out.set("point3f[] points", &Array(points()))?,
    }
    out.attribute("float[] widths", &Array(strands.points.iter().map(|p| 2.0 * p.w)), Some("vertex"))?;
    if let Some(normals) = &strands.normals {
        out.attribute("normal3f[] normals", &Array(normals.iter().map(|n| n.to_array())), Some("vertex"))?;
    }
    if let Some(uv) = &strands.root_uv {
        out.attribute("texCoord2f[] primvars:st", &Array(uv.iter().map(|uv| uv.to_array())), Some("uniform"))?;
    }
    for (parameter, values) in &strands.varying {
        let (values, interpolation) = match values {
            Values::Constant(value) => (std::slice::from_ref(value), "constant"),
            Values::PerStrand(values) => (&values[..], "uniform"),
            Values::PerPoint(values) => (&values[..], "vertex"),
        };
        let key = parameter.name();
        let in_file = values.iter().map(|value| to_file(*parameter, *value));
        if parameter.channels() > 1 {
            out.attribute(&format!("float3[] primvars:vellus:{key}"), &Array(in_file), Some(interpolation))?;
        } else {
            out.attribute(
                &format!("float[] primvars:vellus:{key}"),
                &Array(in_file.map(|v| v[0])),
                Some(interpolation),
            )?;
        }
    }
    custom.iter().try_for_each(|custom| write_custom(out, custom))?;
    out.relate("material:binding", &[&names.looks[strands.look]])?;
    vellus_name(out, &strands.name)?;
    out.close()
}

/// Writes a mesh in the prim `parent`, which is open.
pub(crate) fn mesh(out: &mut dyn Encoder, parent: &str, mesh: &Mesh, names: &mut Names) -> io::Result<()> {
    let name = names.unused(parent, &mesh.name);
    out.open("Mesh", &name, BINDS)?;
    out.set("uniform token subdivisionScheme", &Token("none"))?;
    out.set("int[] faceVertexCounts", &Array(mesh.triangles.iter().map(|_| 3u32)))?;
    out.set("int[] faceVertexIndices", &Array(mesh.triangles.iter().flatten().copied()))?;
    extent(out, mesh.positions.iter().chain(mesh.moved.iter().flatten()).copied(), 0.0)?;
    let points = mesh.positions.iter().map(|p| p.to_array());
    match &mesh.moved {
        Some(moved) => out.samples("point3f[] points", &Array(points), &Array(moved.iter().map(|p| p.to_array())))?,
        None => out.set("point3f[] points", &Array(points))?,
    }
    if let Some(normals) = &mesh.normals {
        out.attribute(
            "normal3f[] normals",
            &Array(normals.iter().flatten().map(|n| n.to_array())),
            Some("faceVarying"),
        )?;
    }
    if let Some(uv) = &mesh.uv {
        let uv = uv.iter().flatten().map(|uv| uv.to_array());
        out.attribute("texCoord2f[] primvars:st", &Array(uv), Some("faceVarying"))?;
    }
    out.relate("material:binding", &[&names.surfaces[mesh.surface]])?;
    vellus_name(out, &mesh.name)?;
    out.close()
}

/// Writes an instance of the class at the path `class`, whose prototype has this name.
pub(crate) fn instance(
    out: &mut dyn Encoder,
    item: &Instance,
    prototype: &str,
    class: &str,
    names: &mut Names,
) -> io::Result<()> {
    let name = names.unused("/Scene", prototype);
    out.open("Xform", &name, Role::Instance(class))?;
    transform(out, item.to_world.as_dmat4(), None)?;
    out.close()
}

/// Numbers of single precision are exact in double precision.
fn transform(out: &mut dyn Encoder, to_world: DMat4, moved: Option<DMat4>) -> io::Result<()> {
    let opened = to_world.to_cols_array_2d();
    match moved {
        None => out.set("matrix4d xformOp:transform", &opened)?,
        Some(moved) => out.samples("matrix4d xformOp:transform", &opened, &moved.to_cols_array_2d())?,
    }
    out.set("uniform token[] xformOpOrder", &Array([Token("xformOp:transform")].into_iter()))
}

/// Writes what a picture of another shape than the camera's film shows.
pub(crate) fn settings(out: &mut dyn Encoder, fit: Fit, names: &mut Names) -> io::Result<()> {
    let name = names.unused("/Scene", "RenderSettings");
    out.open("RenderSettings", &name, Role::Plain)?;
    out.relate("camera", &["/Scene/Camera"])?;
    let policy = match fit {
        Fit::Expand => "expandAperture",
        Fit::Crop => "cropAperture",
        Fit::AdjustWidth => "adjustApertureWidth",
        Fit::AdjustHeight => "adjustApertureHeight",
    };
    out.set("uniform token aspectRatioConformPolicy", &Token(policy))?;
    out.close()
}

pub(crate) fn camera(out: &mut dyn Encoder, camera: &Camera, moves: bool, names: &mut Names) -> io::Result<()> {
    // A power of two, so that products and quotients are exact. It is near the focal length of a normal lens.
    const FOCAL_LENGTH: f32 = 64.0;
    let name = names.unused("/Scene", "Camera");
    out.open("Camera", &name, Role::Plain)?;
    out.set("float focalLength", &FOCAL_LENGTH)?;
    out.set("float horizontalAperture", &(camera.film_width * FOCAL_LENGTH))?;
    out.set("float verticalAperture", &(camera.film_height * FOCAL_LENGTH))?;
    for (name, shift) in ["horizontal", "vertical"].iter().zip(camera.shift).filter(|(_, shift)| *shift != 0.0) {
        out.set(&format!("float {name}ApertureOffset"), &(shift * FOCAL_LENGTH))?;
    }
    // Focal lengths are in tenths of a unit.
    let f_stop =
        if camera.lens_radius > 0.0 { 0.05 * f64::from(FOCAL_LENGTH) / f64::from(camera.lens_radius) } else { 0.0 };
    out.set("float fStop", &(f_stop as f32))?;
    out.set("float focusDistance", &camera.focus_distance)?;
    if moves {
        out.set("double shutter:open", &0.0f64)?;
        out.set("double shutter:close", &1.0f64)?;
    }
    transform(out, camera.to_world.as_dmat4(), camera.moved.map(|m: Mat4| m.as_dmat4()))?;
    out.close()
}

/// The schema of a light, which is the name of its prim too.
pub(crate) fn kind(light: &LightShape) -> &'static str {
    match light {
        LightShape::Dome { .. } => "DomeLight",
        LightShape::Distant { .. } => "DistantLight",
        LightShape::Rect { .. } => "RectLight",
        LightShape::Disk { .. } => "DiskLight",
        LightShape::Point { .. } | LightShape::Sphere { .. } => "SphereLight",
        LightShape::Cylinder { .. } => "CylinderLight",
    }
}

/// Writes the gains of a light, what it lights, and what casts shadows in its light.
fn write_link(out: &mut dyn Encoder, link: &Link, names: &Names) -> io::Result<()> {
    out.set("float inputs:diffuse", &link.diffuse)?;
    out.set("float inputs:specular", &link.specular)?;
    for (collection, objects) in LINKS.into_iter().zip([&link.lit, &link.casters]) {
        let (has_root, property, listed) = match objects {
            Objects::Except(listed) => (true, "excludes", listed),
            Objects::Only(listed) => (false, "includes", listed),
        };
        let paths = listed.iter().filter_map(|name| names.objects.get(name)).flatten();
        let paths: Vec<&str> = paths.map(String::as_str).collect();
        out.set(&format!("uniform bool collection:{collection}:includeRoot"), &has_root)?;
        if !paths.is_empty() {
            out.relate(&format!("collection:{collection}:{property}"), &paths)?;
        }
    }
    Ok(())
}

pub(crate) fn light(out: &mut dyn Encoder, light: &Light, group: &str, names: &mut Names) -> io::Result<()> {
    let Light { shape, shaping, link, .. } = light;
    let (color, texture) = match shape {
        LightShape::Dome { radiance, texture, .. } | LightShape::Rect { radiance, texture, .. } => (radiance, *texture),
        LightShape::Distant { irradiance, .. } => (irradiance, None),
        LightShape::Point { intensity, .. } => (intensity, None),
        LightShape::Disk { radiance, .. }
        | LightShape::Sphere { radiance, .. }
        | LightShape::Cylinder { radiance, .. } => (radiance, None),
    };
    let kind = kind(shape);
    let name = names.unused("/Scene", kind);
    out.open(kind, &name, if shaping.is_some() { Role::Applies("ShapingAPI") } else { Role::Plain })?;
    out.set("color3f inputs:color", color)?;
    // A point has a quarter of the intensity of a normalized sphere: see `POINT`.
    let intensity = if matches!(shape, LightShape::Point { .. }) { 1.0 / POINT as f32 } else { 1.0 };
    out.set("float inputs:intensity", &intensity)?;
    out.set("token vellus:lightGroup", &Token(&plain(group)))?;
    if !light.visible {
        out.set(&format!("int {SEEN_BY_RENDERMAN}"), &0u32)?;
    }
    link.iter().try_for_each(|link| write_link(out, link, names))?;
    if let Some(texture) = texture {
        out.set("asset inputs:texture:file", &Asset(&names.textures[texture]))?;
    }
    let to_world = match shape {
        LightShape::Dome { rotation, ground, .. } => {
            // The middle of the image is at +z for a DomeLight, and at −z for `LightShape::Dome`.
            out.set("token inputs:texture:format", &Token("latlong"))?;
            let rotation = rotation.as_dmat3() * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
            if let Some(ground) = ground {
                out.set("float vellus:groundHeight", &ground.height)?;
                out.set("float vellus:groundRadius", &ground.radius)?;
            }
            let origin = ground.map_or(DVec3::ZERO, |ground| ground.origin.as_dvec3());
            DMat4::from_translation(origin) * DMat4::from_mat3(rotation)
        }
        LightShape::Distant { direction, half_angle, .. } => {
            out.set("float inputs:angle", &((2.0 * f64::from(*half_angle)).to_degrees() as f32))?;
            out.set("bool inputs:normalize", &true)?;
            let z = direction.as_dvec3();
            let x = z.normalize().any_orthonormal_vector();
            DMat4::from_mat3(DMat3::from_cols(x, z.cross(x), z))
        }
        LightShape::Rect { to_world, .. } => {
            out.set("float inputs:width", &1.0f32)?;
            out.set("float inputs:height", &1.0f32)?;
            to_world.as_dmat4()
        }
        LightShape::Disk { to_world, .. } => {
            out.set("float inputs:radius", &1.0f32)?;
            to_world.as_dmat4()
        }
        LightShape::Point { position, .. } => {
            out.set("float inputs:radius", &0.0f32)?;
            out.set("bool inputs:normalize", &true)?;
            out.set("bool treatAsPoint", &true)?;
            DMat4::from_translation(position.as_dvec3())
        }
        LightShape::Sphere { center, radius, .. } => {
            out.set("float inputs:radius", radius)?;
            DMat4::from_translation(center.as_dvec3())
        }
        LightShape::Cylinder { center, half_axis, radius, .. } => {
            out.set("float inputs:radius", radius)?;
            // The axis of a CylinderLight is x.
            let axis = half_axis.as_dvec3();
            out.set("float inputs:length", &((2.0 * axis.length()) as f32))?;
            let x = axis.normalize();
            let y = x.any_orthonormal_vector();
            let rotation = DMat3::from_cols(x, y, x.cross(y));
            DMat4::from_translation(center.as_dvec3()) * DMat4::from_mat3(rotation)
        }
    };
    let Some(shaping) = shaping else {
        transform(out, to_world, None)?;
        return out.close();
    };
    out.set("float inputs:shaping:cone:angle", &(f64::from(shaping.cone).to_degrees() as f32))?;
    out.set("float inputs:shaping:cone:softness", &shaping.softness)?;
    out.set("float inputs:shaping:focus", &shaping.focus)?;
    if shaping.tint != [0.0; 3] {
        out.set("color3f inputs:shaping:focusTint", &shaping.tint)?;
    }
    if let Some(profile) = shaping.profile {
        out.set("asset inputs:shaping:ies:file", &Asset(&names.textures[profile.texture]))?;
    }
    // The axis is −z of the light. Points and spheres have no direction of their own, so they turn to the axis.
    let turned = match shape {
        LightShape::Point { .. } | LightShape::Sphere { .. } => {
            let z = -shaping.axis.as_dvec3().normalize();
            let side = shaping.profile.and_then(|p| (-p.side.as_dvec3()).reject_from_normalized(z).try_normalize());
            let x = side.unwrap_or_else(|| z.any_orthonormal_vector());
            let rotation = DMat3::from_cols(x, z.cross(x), z);
            DMat4::from_translation(to_world.w_axis.truncate()) * DMat4::from_mat3(rotation)
        }
        LightShape::Cylinder { half_axis, .. } => {
            // −z is perpendicular to the axis of the cylinder, which is x.
            let x = half_axis.as_dvec3().normalize();
            let across = -shaping.axis.as_dvec3().reject_from_normalized(x);
            let z = across.try_normalize().unwrap_or_else(|| x.any_orthonormal_vector());
            DMat4::from_translation(to_world.w_axis.truncate()) * DMat4::from_mat3(DMat3::from_cols(x, z.cross(x), z))
        }
        _ => to_world,
    };
    transform(out, turned, None)?;
    out.close()
}
