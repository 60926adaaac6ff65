//! Writes strands, meshes, camera and lights.

use crate::read::light::{POINT, SEEN_BY_RENDERMAN};
use crate::read::link::LINKS;
use crate::write::names::{Names, to_file, vellus_name};
use crate::write::text::{Literal, Text, quoted};

use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};
use std::io::{self, Write};
use vellus_scene::{Basis, Camera, Fit, Instance, Light, Link, Mesh, Objects, Shaping, Strands, Values};

/// Metadata of prims with a material.
const BINDS: &str = "prepend apiSchemas = [\"MaterialBindingAPI\"]";

fn extent<W: Write>(text: &mut Text<W>, points: impl Iterator<Item = Vec3>, radius: f32) -> io::Result<()> {
    let (low, high) = points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    if low.is_finite() && high.is_finite() {
        text.array("float3[] extent", [(low - radius).to_array(), (high + radius).to_array()], None)?;
    }
    Ok(())
}

/// Writes strands in the prim `parent`, which is open.
pub(crate) fn strands<W: Write>(text: &mut Text<W>, parent: &str, strands: &Strands, names: &Names) -> io::Result<()> {
    let name = text.name(parent, &strands.name);
    text.open("BasisCurves", &name, BINDS)?;
    let (kind, basis) = match strands.basis {
        Basis::Linear => ("linear", None),
        Basis::BSpline => ("cubic", Some("bspline")),
        Basis::CatmullRom => ("cubic", Some("catmullRom")),
        Basis::Bezier => ("cubic", Some("bezier")),
    };
    text.set("uniform token type", &format!("\"{kind}\""))?;
    if let Some(basis) = basis {
        text.set("uniform token basis", &format!("\"{basis}\""))?;
    }
    text.set("uniform token wrap", "\"nonperiodic\"")?;
    text.array("int[] curveVertexCounts", strands.starts.windows(2).map(|pair| pair[1] - pair[0]), None)?;
    let radius = strands.points.iter().fold(0.0f32, |radius, p| radius.max(p.w));
    let moved = strands.moved.iter().flatten().copied();
    extent(text, strands.points.iter().map(|p| p.truncate()).chain(moved), radius)?;
    let points = || strands.points.iter().map(|p| p.truncate().to_array());
    match &strands.moved {
        Some(moved) => text.moving_array("point3f[] points", points(), moved.iter().map(|p| p.to_array()))?,
        None => text.array("point3f[] points", points(), None)?,
    }
    text.array("float[] widths", strands.points.iter().map(|p| 2.0 * p.w), Some("vertex"))?;
    if let Some(uv) = &strands.root_uv {
        text.array("texCoord2f[] primvars:st", uv.iter().map(|uv| uv.to_array()), Some("uniform"))?;
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
            text.array(&format!("float3[] primvars:vellus:{key}"), in_file, Some(interpolation))?;
        } else {
            text.array(&format!("float[] primvars:vellus:{key}"), in_file.map(|v| v[0]), Some(interpolation))?;
        }
    }
    text.set("rel material:binding", &format!("<{}>", names.looks[strands.look]))?;
    vellus_name(text, &strands.name)?;
    text.close()
}

/// Writes a mesh in the prim `parent`, which is open.
pub(crate) fn mesh<W: Write>(text: &mut Text<W>, parent: &str, mesh: &Mesh, names: &Names) -> io::Result<()> {
    let name = text.name(parent, &mesh.name);
    text.open("Mesh", &name, BINDS)?;
    text.set("uniform token subdivisionScheme", "\"none\"")?;
    text.array("int[] faceVertexCounts", mesh.triangles.iter().map(|_| 3u32), None)?;
    text.array("int[] faceVertexIndices", mesh.triangles.iter().flatten().copied(), None)?;
    extent(text, mesh.positions.iter().chain(mesh.moved.iter().flatten()).copied(), 0.0)?;
    let points = mesh.positions.iter().map(|p| p.to_array());
    match &mesh.moved {
        Some(moved) => text.moving_array("point3f[] points", points, moved.iter().map(|p| p.to_array()))?,
        None => text.array("point3f[] points", points, None)?,
    }
    if let Some(normals) = &mesh.normals {
        text.array("normal3f[] normals", normals.iter().flatten().map(|n| n.to_array()), Some("faceVarying"))?;
    }
    if let Some(uv) = &mesh.uv {
        let uv = uv.iter().flatten().map(|uv| uv.to_array());
        text.array("texCoord2f[] primvars:st", uv, Some("faceVarying"))?;
    }
    text.set("rel material:binding", &format!("<{}>", names.surfaces[mesh.surface]))?;
    vellus_name(text, &mesh.name)?;
    text.close()
}

/// Writes an instance of the class at the path `class`, whose prototype has this name.
pub(crate) fn instance<W: Write>(text: &mut Text<W>, item: &Instance, name: &str, class: &str) -> io::Result<()> {
    let name = text.name("/Scene", name);
    text.open("Xform", &name, &format!("instanceable = true; inherits = <{class}>"))?;
    transform(text, item.to_world.as_dmat4(), None)?;
    text.close()
}

/// The text of a matrix. Numbers of single precision are exact in double precision.
fn matrix(matrix: DMat4) -> String {
    matrix.to_cols_array_2d().text()
}

fn transform<W: Write>(text: &mut Text<W>, to_world: DMat4, moved: Option<DMat4>) -> io::Result<()> {
    match moved {
        None => text.set("matrix4d xformOp:transform", &matrix(to_world))?,
        Some(moved) => {
            let samples = format!("{{ 0: {}, 1: {} }}", matrix(to_world), matrix(moved));
            text.set("matrix4d xformOp:transform.timeSamples", &samples)?;
        }
    }
    text.set("uniform token[] xformOpOrder", "[\"xformOp:transform\"]")
}

/// Writes what a picture of another shape than the camera's film shows.
pub(crate) fn settings<W: Write>(text: &mut Text<W>, fit: Fit) -> io::Result<()> {
    let name = text.name("/Scene", "RenderSettings");
    text.open("RenderSettings", &name, "")?;
    text.set("rel camera", "</Scene/Camera>")?;
    let policy = match fit {
        Fit::Expand => "expandAperture",
        Fit::Crop => "cropAperture",
        Fit::AdjustWidth => "adjustApertureWidth",
        Fit::AdjustHeight => "adjustApertureHeight",
    };
    text.set("uniform token aspectRatioConformPolicy", &format!("\"{policy}\""))?;
    text.close()
}

pub(crate) fn camera<W: Write>(text: &mut Text<W>, camera: &Camera, moves: bool) -> io::Result<()> {
    // A power of two, so that products and quotients are exact. It is near the focal length of a normal lens.
    const FOCAL_LENGTH: f32 = 64.0;
    let name = text.name("/Scene", "Camera");
    text.open("Camera", &name, "")?;
    text.set("float focalLength", &FOCAL_LENGTH.text())?;
    text.set("float horizontalAperture", &(camera.film_width * FOCAL_LENGTH).text())?;
    text.set("float verticalAperture", &(camera.film_height * FOCAL_LENGTH).text())?;
    // Focal lengths are in tenths of a unit.
    let f_stop =
        if camera.lens_radius > 0.0 { 0.05 * f64::from(FOCAL_LENGTH) / f64::from(camera.lens_radius) } else { 0.0 };
    text.set("float fStop", &(f_stop as f32).text())?;
    text.set("float focusDistance", &camera.focus_distance.text())?;
    if moves {
        text.set("double shutter:open", "0")?;
        text.set("double shutter:close", "1")?;
    }
    transform(text, camera.to_world.as_dmat4(), camera.moved.map(|m: Mat4| m.as_dmat4()))?;
    text.close()
}

/// The schema of a light, which is the name of its prim too.
pub(crate) fn kind(light: &Light) -> &'static str {
    match light {
        Light::Dome { .. } => "DomeLight",
        Light::Distant { .. } => "DistantLight",
        Light::Rect { .. } => "RectLight",
        Light::Disk { .. } => "DiskLight",
        Light::Point { .. } | Light::Sphere { .. } => "SphereLight",
        Light::Cylinder { .. } => "CylinderLight",
    }
}

/// Writes the gains of a light, what it lights, and what casts shadows in its light.
fn write_link<W: Write>(text: &mut Text<W>, link: &Link, names: &Names) -> io::Result<()> {
    text.set("float inputs:diffuse", &link.diffuse.text())?;
    text.set("float inputs:specular", &link.specular.text())?;
    for (collection, objects) in LINKS.into_iter().zip([&link.lit, &link.casters]) {
        let (has_root, property, listed) = match objects {
            Objects::Except(listed) => (1, "excludes", listed),
            Objects::Only(listed) => (0, "includes", listed),
        };
        let paths = listed.iter().filter_map(|name| names.objects.get(name)).flatten();
        let paths: Vec<String> = paths.map(|path| format!("<{path}>")).collect();
        text.set(&format!("uniform bool collection:{collection}:includeRoot"), &has_root.to_string())?;
        if !paths.is_empty() {
            text.set(&format!("rel collection:{collection}:{property}"), &format!("[{}]", paths.join(", ")))?;
        }
    }
    Ok(())
}

pub(crate) fn light<W: Write>(
    text: &mut Text<W>,
    light: &Light,
    group: &str,
    seen: bool,
    shaping: Option<&Shaping>,
    link: Option<&Link>,
    names: &Names,
) -> io::Result<()> {
    let (color, texture) = match light {
        Light::Dome { radiance, texture, .. } | Light::Rect { radiance, texture, .. } => (radiance, *texture),
        Light::Distant { irradiance, .. } => (irradiance, None),
        Light::Point { intensity, .. } => (intensity, None),
        Light::Disk { radiance, .. } | Light::Sphere { radiance, .. } | Light::Cylinder { radiance, .. } => {
            (radiance, None)
        }
    };
    let kind = kind(light);
    let name = text.name("/Scene", kind);
    let schemas = if shaping.is_some() { "prepend apiSchemas = [\"ShapingAPI\"]" } else { "" };
    text.open(kind, &name, schemas)?;
    text.set("color3f inputs:color", &color.text())?;
    // A point has a quarter of the intensity of a normalized sphere: see `POINT`.
    let intensity = if matches!(light, Light::Point { .. }) { 1.0 / POINT as f32 } else { 1.0 };
    text.set("float inputs:intensity", &intensity.text())?;
    text.set("token vellus:lightGroup", &quoted(group))?;
    if !seen {
        text.set(&format!("int {SEEN_BY_RENDERMAN}"), "0")?;
    }
    link.map_or(Ok(()), |link| write_link(text, link, names))?;
    if let Some(texture) = texture {
        text.set("asset inputs:texture:file", &format!("@{}@", names.textures[texture]))?;
    }
    let to_world = match light {
        Light::Dome { rotation, ground, .. } => {
            // The middle of the image is at +z for a DomeLight, and at −z for `Light::Dome`.
            text.set("token inputs:texture:format", "\"latlong\"")?;
            let rotation = rotation.as_dmat3() * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
            if let Some(ground) = ground {
                text.set("float vellus:groundHeight", &ground.height.text())?;
                text.set("float vellus:groundRadius", &ground.radius.text())?;
            }
            let origin = ground.map_or(DVec3::ZERO, |ground| ground.origin.as_dvec3());
            DMat4::from_translation(origin) * DMat4::from_mat3(rotation)
        }
        Light::Distant { direction, half_angle, .. } => {
            text.set("float inputs:angle", &((2.0 * f64::from(*half_angle)).to_degrees() as f32).text())?;
            text.set("bool inputs:normalize", "1")?;
            let z = direction.as_dvec3();
            let x = z.normalize().any_orthonormal_vector();
            DMat4::from_mat3(DMat3::from_cols(x, z.cross(x), z))
        }
        Light::Rect { to_world, .. } => {
            text.set("float inputs:width", "1")?;
            text.set("float inputs:height", "1")?;
            to_world.as_dmat4()
        }
        Light::Disk { to_world, .. } => {
            text.set("float inputs:radius", "1")?;
            to_world.as_dmat4()
        }
        Light::Point { position, .. } => {
            text.set("float inputs:radius", "0")?;
            text.set("bool inputs:normalize", "1")?;
            text.set("bool treatAsPoint", "1")?;
            DMat4::from_translation(position.as_dvec3())
        }
        Light::Sphere { center, radius, .. } => {
            text.set("float inputs:radius", &radius.text())?;
            DMat4::from_translation(center.as_dvec3())
        }
        Light::Cylinder { center, half_axis, radius, .. } => {
            text.set("float inputs:radius", &radius.text())?;
            // The axis of a CylinderLight is x.
            let axis = half_axis.as_dvec3();
            text.set("float inputs:length", &((2.0 * axis.length()) as f32).text())?;
            let x = axis.normalize();
            let y = x.any_orthonormal_vector();
            let rotation = DMat3::from_cols(x, y, x.cross(y));
            DMat4::from_translation(center.as_dvec3()) * DMat4::from_mat3(rotation)
        }
    };
    let Some(shaping) = shaping else {
        transform(text, to_world, None)?;
        return text.close();
    };
    text.set("float inputs:shaping:cone:angle", &(f64::from(shaping.cone).to_degrees() as f32).text())?;
    text.set("float inputs:shaping:cone:softness", &shaping.softness.text())?;
    text.set("float inputs:shaping:focus", &shaping.focus.text())?;
    // The axis is −z of the light. Points and spheres have no direction of their own, so they turn to the axis.
    let turned = match light {
        Light::Point { .. } | Light::Sphere { .. } => {
            let z = -shaping.axis.as_dvec3().normalize();
            let x = z.any_orthonormal_vector();
            let rotation = DMat3::from_cols(x, z.cross(x), z);
            DMat4::from_translation(to_world.w_axis.truncate()) * DMat4::from_mat3(rotation)
        }
        Light::Cylinder { half_axis, .. } => {
            // −z is perpendicular to the axis of the cylinder, which is x.
            let x = half_axis.as_dvec3().normalize();
            let across = -shaping.axis.as_dvec3().reject_from_normalized(x);
            let z = across.try_normalize().unwrap_or_else(|| x.any_orthonormal_vector());
            DMat4::from_translation(to_world.w_axis.truncate()) * DMat4::from_mat3(DMat3::from_cols(x, z.cross(x), z))
        }
        _ => to_world,
    };
    transform(text, turned, None)?;
    text.close()
}
