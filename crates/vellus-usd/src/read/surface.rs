//! Reads the surfaces of meshes (UsdPreviewSurface).

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::network::{Input, bound_material, input, surface_shader};
use crate::read::primvar::{Interpolation, Primvar, inherited};
use crate::read::uv_texture::uv_texture;
use crate::stage::{Stage, When};
use vellus_scene::{Surface, Tint};

/// Unsupported inputs, and the values at which they have no effect.
const IDLE: [(&str, f32); 4] =
    [("opacity", 1.0), ("clearcoat", 0.0), ("displacement", 0.0), ("useSpecularWorkflow", 0.0)];

/// The index of the surface of a mesh in the scene. Reads the surface if it is new.
pub(crate) fn surface(reader: &mut Reader, prim: &str) -> Result<usize, Error> {
    let material = bound_material(reader, prim)?;
    let shader = material.as_ref().map(|m| surface_shader(&reader.stage, m)).transpose()?.flatten();
    let shader = shader.filter(|shader| shader.id == "UsdPreviewSurface");
    if let (Some(material), None) = (&material, &shader) {
        reader.warnings.add(material, "it has no UsdPreviewSurface: its meshes have their displayColor");
    }
    let key = shader.as_ref().and(material).unwrap_or_else(|| prim.to_owned());
    if let Some(&known) = reader.surfaces.get(&key) {
        return Ok(known);
    }
    let surface = match shader {
        Some(shader) => preview(reader, &key, &shader.prim)?,
        None => plain(reader, prim)?,
    };
    reader.scene.surfaces.push(surface);
    reader.surfaces.insert(key, reader.scene.surfaces.len() - 1);
    Ok(reader.scene.surfaces.len() - 1)
}

/// A diffuse surface with the displayColor of the mesh if that is constant, otherwise with the grey that USD defines.
fn plain(reader: &mut Reader, prim: &str) -> Result<Surface, Error> {
    let name = "primvars:displayColor";
    let color = inherited(&reader.stage, prim, name)?;
    let color =
        color.filter(|c| c.interpolation == Interpolation::Constant && c.values.len() >= 1 && c.values.lanes == 3);
    let Some(Primvar { mut values, space, .. }) = color else { return Ok(Surface::diffuse(prim, [0.18; 3])) };
    reader.convert(prim, name, space.as_deref(), &mut values)?;
    Ok(Surface::diffuse(prim, [values.values[0], values.values[1], values.values[2]]))
}

fn preview(reader: &mut Reader, material: &str, prim: &str) -> Result<Surface, Error> {
    let mut surface = Surface {
        name: reader.name(material)?,
        // Default values of the schema.
        color: Tint { color: [0.18; 3], texture: None },
        emission: [0.0; 3],
        roughness: 0.5,
        metallic: 0.0,
        ior: 1.5,
    };
    match input(&reader.stage, prim, "inputs:diffuseColor")? {
        Input::Shader(source) if source.id == "UsdUVTexture" => {
            let (texture, color) = uv_texture(reader, &source, false)?;
            surface.color = Tint { color, texture: Some(texture) };
        }
        source => set(reader, prim, "inputs:diffuseColor", source, &mut surface.color.color)?,
    }
    let mut number = |name: &str, target: &mut f32| {
        let mut value = [*target];
        let source = input(&reader.stage, prim, name)?;
        set(reader, prim, name, source, &mut value)?;
        *target = value[0];
        Ok::<_, Error>(())
    };
    number("inputs:roughness", &mut surface.roughness)?;
    number("inputs:metallic", &mut surface.metallic)?;
    number("inputs:ior", &mut surface.ior)?;
    let source = input(&reader.stage, prim, "inputs:emissiveColor")?;
    set(reader, prim, "inputs:emissiveColor", source, &mut surface.emission)?;
    if surface.emission.iter().any(|x| !(x.is_finite() && *x >= 0.0)) {
        return Err(Error::prim(prim, "inputs:emissiveColor must be finite and not negative"));
    }

    for (name, idle) in IDLE {
        let name = format!("inputs:{name}");
        let works = match input(&reader.stage, prim, &name)? {
            Input::Unset => false,
            Input::Value(at) => numbers(&reader.stage, &at.prim, &at.name)? != [idle],
            Input::Shader(_) => true,
        };
        if works {
            reader.warnings.add(prim, format!("{name} is not supported and is ignored"));
        }
    }
    if let Input::Shader(_) = input(&reader.stage, prim, "inputs:normal")? {
        reader.warnings.add(prim, "inputs:normal is not supported and is ignored");
    }
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
        Input::Shader(_) => {
            reader.warnings.add(prim, format!("{name} cannot have a texture: its default value is used"))
        }
    }
    Ok(())
}
