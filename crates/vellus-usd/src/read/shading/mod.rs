//! Maps the shading networks of other programs to fibres and surfaces.

mod arnold;
mod hair;
mod image;
mod karma;
mod mapping;
mod materialx;
mod nodes;
mod preview;
mod renderman;
mod surface;
mod value;

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::look::Shaded;
use crate::read::network::{Input, Shader, input};
use mapping::Mapping;
pub(crate) use surface::Model;
use vellus_scene::Surface;

/// The outputs of a material at which renderers look for its surface, in the order of preference.
const OUTPUTS: [&str; 6] = [
    "outputs:mtlx:surface",
    "outputs:arnold:surface",
    "outputs:kma:surface",
    "outputs:ri:surface",
    "outputs:ri:bxdf",
    "outputs:surface",
];

/// Reads the inputs of a shader into a fibre.
type Map = fn(&mut Mapping) -> Result<(), Error>;

/// The function that reads a shader, by its `info:id`.
fn map_of(id: &str) -> Option<Map> {
    match id {
        "ND_chiang_hair_bsdf" => Some(materialx::map),
        materialx::OWN => Some(materialx::own),
        "arnold:standard_hair" | "standard_hair" => Some(arnold::map),
        "PxrMarschnerHair" => Some(renderman::map),
        "UsdPreviewSurface" | "ND_UsdPreviewSurface_surfaceshader" => Some(preview::map),
        _ if karma::is_fiber(id) => Some(karma::map),
        _ => None,
    }
}

/// The look of a material of another program, or `None` with a warning if the material has no shader of fibres. A
/// warning reports what was mapped.
///
/// [`Options::network_base`](crate::Options::network_base) gives the parameters that the network lacks.
pub(crate) fn look(reader: &mut Reader, material: &str) -> Result<Option<Shaded>, Error> {
    let mut others: Vec<Shader> = Vec::new();
    for output in OUTPUTS {
        let Some(shader) = surface(reader, material, output)? else { continue };
        let Some(map) = map_of(&shader.id) else {
            others.push(shader);
            continue;
        };
        reader.prim(&shader.prim)?;
        let mut mapping = Mapping::new(reader, shader);
        map(&mut mapping)?;
        return mapping.finish(material);
    }
    for other in others {
        reader.warnings.add(&other.prim, format!("a {} is not a fibre and is ignored", other.id));
    }
    Ok(None)
}

/// The shader at an output of a material. The BSDF if that is a MaterialX surface, which has no inputs that we need.
fn surface(reader: &Reader, material: &str, output: &str) -> Result<Option<Shader>, Error> {
    let mut shader = match input(reader.stage, material, output)? {
        Input::Shader(shader) => shader,
        _ => return Ok(None),
    };
    if shader.id == "ND_surface" {
        shader = match input(reader.stage, &shader.prim, "inputs:bsdf")? {
            Input::Shader(bsdf) => bsdf,
            _ => return Ok(None),
        };
    }
    Ok(Some(shader))
}

/// The first shader of a material that is a surface, and what it calls its inputs.
pub(crate) fn surface_shader(reader: &Reader, material: &str) -> Result<Option<(Shader, Model)>, Error> {
    for output in OUTPUTS {
        let Some(shader) = surface(reader, material, output)? else { continue };
        if let Some(model) = Model::of(&shader.id) {
            return Ok(Some((shader, model)));
        }
    }
    Ok(None)
}

/// Reads a surface. Warnings name inputs that are approximated.
pub(crate) fn read_surface(reader: &mut Reader, name: String, shader: &Shader, of: &Model) -> Result<Surface, Error> {
    reader.prim(&shader.prim)?;
    surface::read(&mut Mapping::new(reader, shader.clone()), name, of)
}

/// Gives a warning for each input of a surface that has an effect and no counterpart.
pub(crate) fn ignore(reader: &mut Reader, shader: &Shader, model: &Model) -> Result<(), Error> {
    surface::ignore(&mut Mapping::new(reader, shader.clone()), model)
}
