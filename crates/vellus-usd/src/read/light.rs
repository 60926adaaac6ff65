//! Reads lights (UsdLux).

use crate::color::blackbody;
use crate::error::Error;
use crate::image::{Encoding, Probe, UDIM, Use, not_latlong};
use crate::read::color::space_name;
use crate::read::context::{Reader, TextureSource};
use crate::read::link::Linked;
use crate::read::xform::{Place, is_rigid, mean_scale, rigid};
use crate::stage::{Stage, When};
use crate::warning::Fault;
use glam::{DMat3, DMat4, DVec3};
use std::f64::consts::PI;
use vellus_scene::{Ground, Light, LightShape, Link, Mesh, Profile, Shaping, Surface, Wrap};

/// An attribute of a light. Before USD 21.02, its name had no `inputs:`.
fn get(stage: &Stage, prim: &str, name: &str, fallback: f64) -> Result<f64, Error> {
    let value = match stage.precise(prim, &format!("inputs:{name}"), When::Open)? {
        Some(value) => Some(value),
        None => stage.precise(prim, name, When::Open)?,
    };
    match value.as_deref() {
        None => Ok(fallback),
        Some(&[x]) if x.is_finite() => Ok(x),
        Some(_) => Err(Error::prim(prim, format!("inputs:{name} must be a finite number"))),
    }
}

fn size(stage: &Stage, prim: &str, name: &str, fallback: f64) -> Result<f64, Error> {
    let x = get(stage, prim, name, fallback)?;
    if x > 0.0 { Ok(x) } else { Err(Error::prim(prim, format!("inputs:{name} is {x}: it must be positive"))) }
}

/// The emission, RGB: intensity × 2^exposure × colour.
fn emission(reader: &mut Reader, prim: &str, intensity: f64) -> Result<[f64; 3], Error> {
    let stage = reader.stage;
    let strength = get(stage, prim, "intensity", intensity)? * get(stage, prim, "exposure", 0.0)?.exp2();
    let (name, color) = match stage.precise(prim, "inputs:color", When::Open)? {
        Some(color) => ("inputs:color", Some(color)),
        None => ("color", stage.precise(prim, "color", When::Open)?),
    };
    let space = space_name(stage, prim, name, true)?;
    let mut color = <[f64; 3]>::try_from(color.unwrap_or_else(|| vec![1.0; 3]))
        .map_err(|_| Error::prim(prim, "inputs:color must have three channels"))?;
    if let Some(space) = reader.color_space(prim, name, space.as_deref())? {
        color = space.converter()(color);
    }
    if stage.flag(prim, "inputs:enableColorTemperature")? == Some(true) {
        let warm = blackbody(get(stage, prim, "colorTemperature", 6500.0)?);
        color = std::array::from_fn(|c| color[c] * warm[c]);
    }
    let emission = color.map(|c| c * strength);
    if emission.iter().all(|x| x.is_finite() && *x >= 0.0) {
        Ok(emission)
    } else {
        Err(Error::prim(prim, format!("it emits {emission:?}: no channel may be negative or infinite")))
    }
}

/// The radiant intensity of a point light, divided by the intensity of its prim. A sphere of radius r with normalized
/// power has the radiance 1/(4πr²), and its disk has the area πr².
pub(crate) const POINT: f64 = 0.25;

/// Whether a light is a point: a sphere of radius 0 with `treatAsPoint`.
fn is_point(stage: &Stage, prim: &str) -> Result<bool, Error> {
    Ok(get(stage, prim, "radius", 0.5)? == 0.0 && stage.flag(prim, "treatAsPoint")? == Some(true))
}

/// The shaping of a light (UsdLuxShapingAPI). `None` if it changes nothing.
fn shaping(reader: &mut Reader, place: &Place) -> Result<Option<Shaping>, Error> {
    let prim = place.path.as_str();
    let stage = reader.stage;
    let has_cone = stage.has_value(prim, "inputs:shaping:cone:angle")?;
    // The schema's default of 90 degrees only counts where a file has it: UsdLux has no lights with a default cone.
    let cone = if has_cone { get(stage, prim, "shaping:cone:angle", 90.0)? } else { 180.0 };
    let softness = get(stage, prim, "shaping:cone:softness", 0.0)?;
    let focus = get(stage, prim, "shaping:focus", 0.0)?;
    let flat = matches!(place.type_name.as_str(), "RectLight" | "DiskLight");
    let all = cone >= if flat && softness == 0.0 { 90.0 } else { 180.0 };
    let infinite = place.type_name.starts_with("DomeLight") || place.type_name == "DistantLight";
    let has_profile = stage.has_value(prim, "inputs:shaping:ies:file")?;
    if infinite && !(all && focus == 0.0 && !has_profile) {
        reader.warnings.add(prim, "the shaping of domes and distant lights is not supported and is ignored");
    }
    let profile = if infinite { None } else { profile(reader, place)? };
    if infinite || all && focus == 0.0 && profile.is_none() {
        return Ok(None);
    }
    let tint = <[f64; 3]>::try_from(stage.precise(prim, "inputs:shaping:focusTint", When::Open)?.unwrap_or_default());
    if !(cone > 0.0 && focus >= 0.0) {
        let what = "inputs:shaping:cone:angle must be positive, and inputs:shaping:focus must not be negative";
        return Err(Error::prim(prim, what));
    }
    Ok(Some(Shaping {
        axis: -rigid(&place.to_world).z_axis.truncate().as_vec3(),
        cone: cone.min(180.0).to_radians().min(PI) as f32,
        softness: softness.clamp(0.0, 1.0) as f32,
        focus: focus as f32,
        tint: tint.map_or([0.0; 3], |tint| tint.map(|x| x.max(0.0) as f32)),
        profile,
    }))
}

/// The IES profile of a light. A light whose profile cannot be read shines without it.
fn profile(reader: &mut Reader, place: &Place) -> Result<Option<Profile>, Error> {
    let prim = place.path.as_str();
    match profile_image(reader, prim) {
        Ok(Some(texture)) => {
            // As in hdEmbree: profiles are looked up in the direction from what is lit to the light.
            Ok(Some(Profile { texture, side: -rigid(&place.to_world).x_axis.truncate().as_vec3() }))
        }
        Ok(None) => Ok(None),
        Err(error) => {
            reader.fault(Fault::Texture, prim, error, "the light shines without its profile")?;
            Ok(None)
        }
    }
}

/// The image of the IES profile of a light.
fn profile_image(reader: &mut Reader, prim: &str) -> Result<Option<usize>, Error> {
    let Some(file) = asset(reader.stage, prim, "shaping:ies:file")? else { return Ok(None) };
    let scale = get(reader.stage, prim, "shaping:ies:angleScale", 0.0)? as f32;
    let normalize = reader.stage.flag(prim, "inputs:shaping:ies:normalize")? == Some(true);
    let encoding = Encoding::Profile(Use { normalize, angle_scale: scale.to_bits() });
    let source = TextureSource { file, encoding, channel: None, wrap: [Wrap::Repeat; 2], uv: None };
    reader.texture(prim, source).map(Some)
}

/// Reads a light of any kind.
pub(crate) fn read(reader: &mut Reader, place: &Place) -> Result<(), Error> {
    let prim = place.path.as_str();
    let is_distant = place.type_name == "DistantLight";
    let emitted = emission(reader, prim, if is_distant { 50_000.0 } else { 1.0 })?;
    let stage = reader.stage;
    let normalize = stage.flag(prim, "inputs:normalize")?.unwrap_or(false);
    let shaping = shaping(reader, place)?;
    let stage = reader.stage;
    // With `normalize`, the power does not depend on the size in world space.
    let radiance = |area: f64| emitted.map(|x| (if normalize { x / area } else { x }) as f32);
    let sized = |x: f64, y: f64| place.to_world * DMat4::from_scale(DVec3::new(x, y, 1.0));
    let area = |m: &DMat4| m.x_axis.truncate().cross(m.y_axis.truncate()).length();
    let shape = match place.type_name.as_str() {
        "DomeLight" | "DomeLight_1" => dome(reader, place, emitted.map(|x| x as f32))?,
        "DistantLight" => {
            let half_angle = (0.5 * get(stage, prim, "angle", 0.53)?).to_radians();
            if !(0.0..=PI).contains(&half_angle) {
                return Err(Error::prim(prim, "inputs:angle must be in [0, 360] degrees"));
            }
            // Irradiance of a plane that faces a disk of this angle. An angle of 0 is a single direction, whose value
            // is the irradiance itself.
            let sine = half_angle.min(0.5 * PI).sin();
            let spread = if normalize || half_angle == 0.0 { 1.0 } else { PI * sine * sine };
            if stage.has_value(prim, "userProperties:blender:data_name")? {
                reader.warnings.add(prim, BLENDER_SUN);
            }
            let direction = rigid(&place.to_world).z_axis.truncate().as_vec3();
            LightShape::Distant {
                direction,
                half_angle: half_angle as f32,
                irradiance: emitted.map(|x| (x * spread) as f32),
            }
        }
        "RectLight" => {
            let to_world = sized(size(stage, prim, "width", 1.0)?, size(stage, prim, "height", 1.0)?);
            let texture = light_texture(reader, prim)?;
            LightShape::Rect { to_world: to_world.as_mat4(), radiance: radiance(area(&to_world)), texture }
        }
        "DiskLight" => {
            let radius = size(stage, prim, "radius", 0.5)?;
            let to_world = sized(radius, radius);
            LightShape::Disk { to_world: to_world.as_mat4(), radiance: radiance(PI * area(&to_world)) }
        }
        "CylinderLight" => {
            // The axis is x. If a scale makes the section elliptic, a circle of the same area replaces it.
            let axes = DMat3::from_mat4(place.to_world);
            let half_axis = 0.5 * size(stage, prim, "length", 1.0)? * axes.x_axis;
            let radius = size(stage, prim, "radius", 0.5)? * axes.y_axis.cross(axes.z_axis).length().sqrt();
            let radiance = radiance(4.0 * PI * radius * half_axis.length());
            let center = place.to_world.w_axis.truncate().as_vec3();
            if light_texture(reader, prim)?.is_some() {
                reader.warnings.add(prim, "the texture of a CylinderLight is not supported and is ignored");
            }
            LightShape::Cylinder { center, half_axis: half_axis.as_vec3(), radius: radius as f32, radiance }
        }
        _ if is_point(stage, prim)? => {
            let position = place.to_world.w_axis.truncate().as_vec3();
            if !normalize {
                let what = "a point has no area: its intensity is read as if inputs:normalize were 1";
                reader.warnings.add(prim, what);
            }
            LightShape::Point { position, intensity: emitted.map(|x| (POINT * x) as f32) }
        }
        _ => {
            let (scale, _) = mean_scale(&place.to_world);
            let radius = scale * size(stage, prim, "radius", 0.5)?;
            let center = place.to_world.w_axis.truncate().as_vec3();
            LightShape::Sphere { center, radius: radius as f32, radiance: radiance(4.0 * PI * radius * radius) }
        }
    };
    let group = Some(group(reader, prim)?);
    let link = links(reader, prim)?;
    let visible = seen(reader.stage, prim)?;
    reader.scene.lights.push(Light { shape, group, visible, shaping, link });
    Ok(())
}

/// Reads the gains of a light, and notes its links. UsdLuxShadowAPI and filters change the light too.
fn links(reader: &mut Reader, prim: &str) -> Result<Option<Link>, Error> {
    let index = reader.scene.lights.len();
    let [diffuse, specular] = [get(reader.stage, prim, "diffuse", 1.0)?, get(reader.stage, prim, "specular", 1.0)?];
    if diffuse < 0.0 || specular < 0.0 {
        return Err(Error::prim(prim, "inputs:diffuse and inputs:specular must not be negative"));
    }
    let gains = Link { diffuse: diffuse as f32, specular: specular as f32, ..Link::default() };
    let shadows = reader.stage.flag(prim, "inputs:shadow:enable")? != Some(false);
    reader.linked.push(Linked { index, prim: prim.to_owned(), shadows });
    for (name, idle) in IDLE {
        let value = reader.stage.precise(prim, name, When::Open)?;
        if shadows && value.is_some_and(|value| value != idle) {
            reader.warnings.add(prim, format!("{name} is not supported and is ignored"));
        }
    }
    if !reader.stage.targets(prim, "light:filters")?.is_empty() {
        reader.warnings.add(prim, "light:filters are not supported and are ignored");
    }
    Ok(Some(gains).filter(|gains| *gains != Link::default()))
}

/// Inputs of UsdLuxShadowAPI that are not supported, and the values at which they have no effect.
const IDLE: [(&str, &[f64]); 3] =
    [("inputs:shadow:color", &[0.0; 3]), ("inputs:shadow:distance", &[-1.0]), ("inputs:shadow:falloff", &[-1.0])];

/// The surface of a mesh that is a light (MeshLightAPI): `surface`, with the emission of the light.
pub(crate) fn of_mesh(reader: &mut Reader, prim: &str, mesh: &Mesh, surface: usize) -> Result<usize, Error> {
    if !reader.stage.has_api(prim, "MeshLightAPI")? {
        return Ok(surface);
    }
    let mut emission = emission(reader, prim, 1.0)?;
    if reader.stage.flag(prim, "inputs:normalize")?.unwrap_or(false) {
        let area: f64 = mesh.triangles.iter().map(|corners| triangle_area(mesh, corners)).sum();
        emission = emission.map(|x| if area > 0.0 { x / area } else { 0.0 });
    }
    let what = "a mesh that is a light is found only by the rays that hit it: small ones make noise, for which a \
                RectLight or SphereLight is better. Its links, gains and shaping are ignored";
    reader.warnings.add(prim, what);
    let own = &reader.scene.surfaces[surface];
    let emission = std::array::from_fn(|c| own.emission[c] + emission[c] as f32);
    let surface = Surface { name: reader.name(prim)?, emission, ..own.clone() };
    reader.scene.surfaces.push(surface);
    Ok(reader.scene.surfaces.len() - 1)
}

fn triangle_area(mesh: &Mesh, corners: &[u32; 3]) -> f64 {
    let [a, b, c] = corners.map(|i| mesh.positions[i as usize].as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}

/// What Blender writes for a sun, measured with its 5.2.3. Its own import undoes it.
const BLENDER_SUN: &str = "Blender writes a quarter of the strength and half of the angle of a sun: multiply \
                           inputs:intensity by 4 and inputs:angle by 2 for the light of its own picture";

/// Attributes that hide a light from the camera if they are false or 0: those of RenderMan, of Arnold, of Karma and of
/// NVIDIA RTX. UsdLux itself has no such attribute.
const SEEN: [&str; 4] =
    [SEEN_BY_RENDERMAN, "primvars:arnold:camera", "karma:light:renderlightgeo", "visibleInPrimaryRay"];

/// The attribute of RenderMan: an int, which may be inherited as a primvar. Vellus reads it from the light alone.
pub(crate) const SEEN_BY_RENDERMAN: &str = "primvars:ri:attributes:visibility:camera";

/// Whether the camera sees a light directly: the first of [`SEEN`] that the light has, otherwise true.
fn seen(stage: &Stage, prim: &str) -> Result<bool, Error> {
    for name in SEEN {
        if let Some(seen) = stage.flag(prim, name)? {
            return Ok(seen);
        }
    }
    Ok(true)
}

/// The light group: `vellus:lightGroup`, or the name of the prim.
fn group(reader: &Reader, prim: &str) -> Result<String, Error> {
    if let Some([name]) = reader.stage.words(prim, "vellus:lightGroup")?.as_deref() {
        return Ok(name.clone());
    }
    let name = prim.rsplit('/').next().unwrap_or_default();
    // Names of groups are ASCII, names of prims need not be.
    Ok(name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(64).collect())
}

/// A file of a light. Before USD 21.02, the name of the attribute had no `inputs:`.
fn asset(stage: &Stage, prim: &str, name: &str) -> Result<Option<String>, Error> {
    match stage.asset(prim, &format!("inputs:{name}"))? {
        Some(file) => Ok(Some(file)),
        None => stage.asset(prim, name),
    }
}

/// The image of a light. A light whose image cannot be read shines without it.
fn light_texture(reader: &mut Reader, prim: &str) -> Result<Option<usize>, Error> {
    match image_of(reader, prim) {
        Err(error) => {
            reader.fault(Fault::Texture, prim, error, "the light shines without it")?;
            Ok(None)
        }
        image => image,
    }
}

fn image_of(reader: &mut Reader, prim: &str) -> Result<Option<usize>, Error> {
    let Some(file) = asset(reader.stage, prim, "texture:file")? else { return Ok(None) };
    let encoding = reader.encoding(prim, "inputs:texture:file", true)?;
    let source = TextureSource { file, encoding, channel: None, wrap: [Wrap::Repeat; 2], uv: None };
    if source.file.contains(UDIM) {
        return Err(Error::prim(prim, format!("the image of a light cannot have tiles ({UDIM})")));
    }
    let index = reader.texture(prim, source)?;
    let Reader { images, scene, .. } = reader;
    images.light(&scene.textures[index]).map_err(|what| Error::prim(prim, what))?;
    Ok(Some(index))
}

/// The lat-long image of a dome, which has the image `index`.
fn sky(reader: &mut Reader, prim: &str, index: usize) -> Result<usize, Error> {
    let mut format = reader.stage.words(prim, "inputs:texture:format")?.unwrap_or_default();
    if format.is_empty() {
        format = reader.stage.words(prim, "texture:format")?.unwrap_or_default();
    }
    let format = format.first().map_or("automatic", String::as_str);
    let Reader { images, scene, warnings, .. } = reader;
    let image = &scene.textures[index];
    let probe = match format {
        "angular" => Probe::Angular,
        "mirroredBall" => Probe::MirroredBall,
        "automatic" | "latlong" => {
            not_latlong(image).into_iter().for_each(|what| warnings.add(prim, what));
            return Ok(index);
        }
        _ => {
            warnings.add(prim, format!("texture:format {format} is not supported: the image is read as lat-long"));
            return Ok(index);
        }
    };
    let image = probe.latlong(image);
    images.image(&image, 0).map_err(|what| Error::prim(prim, what))?;
    scene.textures.push(image);
    let what = "USD does not say where a probe points: the middle of its image is where that of a lat-long image is";
    warnings.add(prim, what);
    Ok(scene.textures.len() - 1)
}

/// Reads a dome light. The pole of a DomeLight is +y of its frame, whatever the up axis is. The middle of its image is
/// at +z (as in OpenEXR), while that of [`LightShape::Dome`] is at −z.
fn dome(reader: &mut Reader, place: &Place, radiance: [f32; 3]) -> Result<LightShape, Error> {
    let prim = place.path.as_str();
    let texture = light_texture(reader, prim)?;
    let texture = texture.map(|index| sky(reader, prim, index)).transpose()?;
    let pole = reader.stage.words(prim, "poleAxis")?.unwrap_or_default();
    let z_is_pole = place.type_name == "DomeLight_1"
        && match pole.first().map(String::as_str) {
            Some("Y") => false,
            Some("Z") => true,
            _ => reader.scene.units.is_some_and(|units| units.z_up),
        };
    let upright = if z_is_pole { DMat3::from_rotation_x(0.5 * PI) } else { DMat3::IDENTITY };
    let half_turn = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
    let (turned, is_similar) = nearest_orthogonal(&place.to_world);
    if !is_similar {
        let what = "of the transform of a dome, only the nearest rotation or reflection counts: a scale that differs \
                    between directions and a shear are ignored";
        reader.warnings.add(prim, what);
    }
    let rotation = turned * upright * half_turn;
    let ground = ground(reader, place)?;
    Ok(LightShape::Dome { radiance, texture, rotation: rotation.as_mat3(), ground })
}

/// The rotation or reflection nearest to the linear part of a matrix, and whether the rest is a uniform scale. Newton's
/// iteration for the polar decomposition (Higham 1986, Computing the Polar Decomposition).
fn nearest_orthogonal(matrix: &DMat4) -> (DMat3, bool) {
    let linear = DMat3::from_mat4(*matrix);
    if is_rigid(matrix) {
        return (linear, true);
    }
    let (scale, is_uniform) = mean_scale(matrix);
    let mut turned = linear * scale.recip();
    // Each step halves large scales, and squares the error of those near 1.
    for _ in 0..60 {
        turned = (turned + turned.inverse().transpose()) * 0.5;
    }
    if turned.is_finite() { (turned, is_uniform) } else { (DMat3::from_mat4(rigid(matrix)), false) }
}

/// The ground of a dome: `vellus:groundHeight` and `vellus:groundRadius`, in the units of the light. No schema of USD
/// has them.
fn ground(reader: &Reader, place: &Place) -> Result<Option<Ground>, Error> {
    let (stage, prim) = (reader.stage, place.path.as_str());
    let names = ["vellus:groundHeight", "vellus:groundRadius"];
    let given = [stage.has_value(prim, names[0])?, stage.has_value(prim, names[1])?];
    if given == [false; 2] {
        return Ok(None);
    }
    if given != [true; 2] {
        return Err(Error::prim(
            prim,
            format!("only one of {} and {} is set: the ground needs both", names[0], names[1]),
        ));
    }
    let (scale, _) = mean_scale(&place.to_world);
    let (height, radius) = (scale * size(stage, prim, names[0], 1.0)?, scale * size(stage, prim, names[1], 1.0)?);
    let origin = place.to_world.w_axis.truncate().as_vec3();
    Ok(Some(Ground { origin, height: height as f32, radius: radius as f32 }))
}
