//! Reads the surfaces of meshes: UsdPreviewSurface, and those of [`shading`].

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::network::{Input, Shader, bound_material, input, surface_shader};
use crate::read::primvar::{Interpolation, Primvar, inherited};
use crate::read::shading::{self, Model};
use crate::read::uv_texture::{normal_map, texture_source, uv_texture};
use crate::stage::{Stage, When};
use crate::warning::Fault;
use vellus_scene::{Opacity, Surface, Tint};

/// The index of the surface of a mesh in the scene. Reads the surface if it is new. `None`, with a warning, if the mesh
/// is invisible.
pub(crate) fn surface(reader: &mut Reader, prim: &str) -> Result<Option<usize>, Error> {
    let (material, shader) = match bound(reader, prim) {
        Ok(found) => found,
        Err(error) => {
            reader.fault(Fault::Material, prim, error, INSTEAD)?;
            (None, None)
        }
    };
    if let (Some(material), None) = (&material, &shader) {
        let what = "it has no UsdPreviewSurface, standard_surface or OpenPBR surface";
        reader.warnings.add(material, format!("{what}: {INSTEAD}"));
    }
    if let Some((shader, model)) = &shader
        && is_invisible(reader, &shader.prim, model.opacity)
    {
        reader.warnings.add(prim, format!("inputs:{} of its material is 0: it is left out", model.opacity));
        reader.left_out.insert(prim.to_owned());
        return Ok(None);
    }
    let key = shader.as_ref().and(material).unwrap_or_else(|| prim.to_owned());
    if let Some(&known) = reader.surfaces.get(&key) {
        return Ok(Some(known));
    }
    let surface = match shader.map(|(shader, model)| read(reader, &key, &shader, &model)) {
        Some(Ok(surface)) => surface,
        Some(Err(error)) => {
            reader.fault(Fault::Material, &key, error, INSTEAD)?;
            // Other meshes with the material have a displayColor of their own.
            return add(reader, prim, None).map(Some);
        }
        None => return add(reader, prim, None).map(Some),
    };
    add(reader, &key, Some(surface)).map(Some)
}

/// What happens to meshes whose material cannot be read.
const INSTEAD: &str = "its meshes have their displayColor";

/// A material, and its shader with what that calls its inputs.
type Bound = (Option<String>, Option<(Shader, Model)>);

/// The material of a mesh, and its shader if that is a surface which can be read. A UsdPreviewSurface precedes others.
fn bound(reader: &mut Reader, prim: &str) -> Result<Bound, Error> {
    let Some(material) = bound_material(reader, prim)? else { return Ok((None, None)) };
    let preview = surface_shader(reader.stage, &material)?.filter(|shader| shader.id == PREVIEW);
    let found = match preview.and_then(|shader| Model::of(PREVIEW).map(|model| (shader, model))) {
        None => shading::surface_shader(reader, &material)?,
        found => found,
    };
    Ok((Some(material), found))
}

const PREVIEW: &str = "UsdPreviewSurface";

/// Whether a mesh cannot be seen: its opacity is the same everywhere, and 0.
fn is_invisible(reader: &Reader, prim: &str, opacity: &str) -> bool {
    // What cannot be read gives a warning where the other inputs are read.
    let Ok(Input::Value(at)) = input(reader.stage, prim, &format!("inputs:{opacity}")) else { return false };
    let values = numbers(reader.stage, &at.prim, &at.name).unwrap_or_default();
    !values.is_empty() && values.iter().all(|x| *x <= 0.0)
}

fn read(reader: &mut Reader, material: &str, shader: &Shader, model: &Model) -> Result<Surface, Error> {
    let mut surface = if shader.id == PREVIEW {
        preview(reader, material, &shader.prim)?
    } else {
        let name = reader.name(material)?;
        shading::read_surface(reader, name, shader, model)?
    };
    if surface.emission.iter().any(|x| !(x.is_finite() && *x >= 0.0)) {
        let what = format!("inputs:{} must be finite and not negative", model.emission[1].0);
        return Err(Error::prim(&shader.prim, what));
    }
    shading::ignore(reader, shader, model)?;
    let names = [model.roughness, model.metalness, model.specular[1]].map(|(name, _)| name);
    hold(reader, &shader.prim, &mut surface, names);
    Ok(surface)
}

/// Adds a surface, or that of a mesh without a material, and returns its index.
fn add(reader: &mut Reader, key: &str, surface: Option<Surface>) -> Result<usize, Error> {
    let surface = surface.map_or_else(|| plain(reader, key), Ok)?;
    reader.scene.surfaces.push(surface);
    reader.surfaces.insert(key.to_owned(), reader.scene.surfaces.len() - 1);
    Ok(reader.scene.surfaces.len() - 1)
}

/// A diffuse surface with the displayColor of the mesh, or the mean of it, otherwise with the grey that USD defines.
fn plain(reader: &mut Reader, prim: &str) -> Result<Surface, Error> {
    let name = "primvars:displayColor";
    let mut grey = Surface::diffuse(prim, [0.18; 3]);
    if let Some(found) = inherited(reader.stage, prim, "primvars:displayOpacity", When::Open)? {
        let values = found.values.values;
        if values.iter().any(|x| *x != values[0]) {
            let what = "primvars:displayOpacity varies over the mesh, which is not supported: its mean is used";
            reader.warnings.add(prim, what);
        }
        if !values.is_empty() {
            grey.opacity.value = values.iter().sum::<f32>() / values.len() as f32;
            hold(reader, prim, &mut grey, [""; 3]);
        }
    }
    let Some(Primvar { mut values, space, interpolation }) = inherited(reader.stage, prim, name, When::Open)? else {
        return Ok(grey);
    };
    if values.lanes != 3 || values.len() == 0 || values.values.iter().any(|x| !x.is_finite()) {
        reader.warnings.add(prim, format!("{name} has no finite colour and is ignored"));
        return Ok(grey);
    }
    reader.convert(prim, name, space.as_deref(), &mut values)?;
    let is_constant =
        interpolation == Interpolation::Constant || values.values.chunks(3).all(|c| *c == values.values[..3]);
    // Those of a mesh become an image.
    if !is_constant && reader.stage.type_name(prim)? != "Mesh" {
        reader.warnings.add(prim, format!("{name} varies over the mesh, which is not supported: its mean is used"));
    }
    let count = values.len() as f32;
    // Negative numbers are black, and do not darken the others.
    let channel = |c: usize| values.values.iter().skip(c).step_by(3).map(|x| x.max(0.0) / count).sum::<f32>();
    let mean = std::array::from_fn(channel);
    let color = if is_constant { [values.values[0], values.values[1], values.values[2]] } else { mean };
    let mut surface = Surface { color: Tint { color, texture: None }, ..grey };
    hold(reader, prim, &mut surface, [""; 3]);
    Ok(surface)
}

/// Moves values of a surface to the nearest ones that are valid, with a warning. `names` are those of the inputs for
/// the roughness, the metalness and the refractive index.
fn hold(reader: &mut Reader, prim: &str, surface: &mut Surface, names: [&str; 3]) {
    let Surface { color, roughness, metallic, ior, opacity, .. } = surface;
    let [r, g, b] = &mut color.color;
    let unit = 0.0..=1.0;
    let all = [
        ("its colour".to_owned(), r, unit.clone()),
        ("its colour".to_owned(), g, unit.clone()),
        ("its colour".to_owned(), b, unit.clone()),
        (format!("inputs:{}", names[0]), roughness, unit.clone()),
        (format!("inputs:{}", names[1]), metallic, unit.clone()),
        ("its opacity".to_owned(), &mut opacity.value, unit.clone()),
        ("inputs:opacityThreshold".to_owned(), &mut opacity.threshold, unit),
        (format!("inputs:{}", names[2]), ior, 1.0..=4.0),
    ];
    for (name, value, range) in all {
        if !range.contains(value) {
            let (low, high) = (*range.start(), *range.end());
            let nearest = if value.is_nan() { low } else { value.clamp(low, high) };
            let what = format!("{name} is {value}: it must be in [{low}, {high}], so it is clamped to {nearest}");
            reader.warnings.add(prim, what);
            *value = nearest;
        }
    }
}

/// The attribute of a shader whose surface is skin: see [`Surface::skin`].
pub(crate) const SKIN: &str = "vellus:skin";

fn preview(reader: &mut Reader, material: &str, prim: &str) -> Result<Surface, Error> {
    reader.prim(prim)?;
    let mut surface = Surface {
        name: reader.name(material)?,
        // Default values of the schema.
        color: Tint { color: [0.18; 3], texture: None },
        emission: [0.0; 3],
        roughness: 0.5,
        metallic: 0.0,
        ior: 1.5,
        opacity: Opacity::FULL,
        normals: None,
        skin: reader.prim(prim)?.token(SKIN)?.as_deref() == Some("auto"),
    };
    match input(reader.stage, prim, "inputs:diffuseColor")? {
        Input::Shader(source) if source.id == "UsdUVTexture" => {
            if let Some((texture, color)) = uv_texture(reader, &source, false, true)? {
                surface.color = Tint { color, texture: Some(texture) };
            }
        }
        source => set(reader, prim, "inputs:diffuseColor", source, &mut surface.color.color)?,
    }
    let mut number = |name: &str, target: &mut f32| {
        let mut value = [*target];
        let source = input(reader.stage, prim, name)?;
        set(reader, prim, name, source, &mut value)?;
        *target = value[0];
        Ok::<_, Error>(())
    };
    number("inputs:roughness", &mut surface.roughness)?;
    number("inputs:metallic", &mut surface.metallic)?;
    number("inputs:ior", &mut surface.ior)?;
    number("inputs:opacityThreshold", &mut surface.opacity.threshold)?;
    match input(reader.stage, prim, "inputs:opacity")? {
        Input::Shader(source) if source.id == "UsdUVTexture" => {
            if let Some((texture, factor)) = uv_texture(reader, &source, true, false)? {
                (surface.opacity.value, surface.opacity.texture) = (factor[0], Some(texture));
            }
        }
        source => {
            let mut value = [surface.opacity.value];
            set(reader, prim, "inputs:opacity", source, &mut value)?;
            surface.opacity.value = value[0];
        }
    }
    if let Input::Shader(source) = input(reader.stage, prim, "inputs:normal")? {
        if source.id == "UsdUVTexture" {
            surface.normals = normal_map(reader, &source)?;
        } else {
            reader.warnings.add(prim, format!("inputs:normal by a {} is not supported and is ignored", source.id));
        }
    }
    let source = input(reader.stage, prim, "inputs:emissiveColor")?;
    set(reader, prim, "inputs:emissiveColor", source, &mut surface.emission)?;
    Ok(surface)
}

fn numbers(stage: &Stage, prim: &str, name: &str) -> Result<Vec<f32>, Error> {
    Ok(stage.numbers(prim, name, When::Open)?.map_or(Vec::new(), |n| n.values))
}

fn set<const N: usize>(
    reader: &mut Reader,
    prim: &str,
    name: &str,
    source: Input,
    target: &mut [f32; N],
) -> Result<(), Error> {
    match source {
        Input::Unset => {}
        Input::Value(at) => {
            let values = reader.colors(&at.prim, &at.name)?.map_or(Vec::new(), |n| n.values);
            *target = values.try_into().map_err(|_| Error::prim(prim, format!("{name} must have {N} channels")))?;
        }
        Input::Shader(source) if source.id == "UsdUVTexture" => {
            let image = texture_source(reader, &source, false)
                .and_then(|(source, scale)| Ok((reader.load_texture(prim, &source)?.pixels.mean(), scale)));
            match image {
                Ok((mean, scale)) => {
                    *target = std::array::from_fn(|c| (mean[c] as f32) * scale[c]);
                    let what = format!("{name} has an image, which is not supported: its mean is used");
                    reader.warnings.add(prim, what);
                }
                Err(error) => reader.fault(Fault::Texture, prim, error, "the input has its default value")?,
            }
        }
        Input::Shader(_) => {
            reader.warnings.add(prim, format!("{name} is computed, which is not supported: its default is used"))
        }
    }
    Ok(())
}
