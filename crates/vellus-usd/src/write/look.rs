//! Writes materials: VellusFur for strands, UsdPreviewSurface for meshes.

use crate::read::look::SHADER;
use crate::read::uv_texture::{WRAP_INPUTS, WRAPS};
use crate::write::names::{Names, to_file, vellus_name};
use crate::write::text::{Literal, Text};
use std::io::{self, Write};
use vellus_scene::{Look, Parameter, Surface};

/// Writes a look as a material. Returns its path.
pub(crate) fn look<W: Write>(text: &mut Text<W>, look: &Look, names: &Names) -> io::Result<String> {
    let name = text.name("/Scene/Looks", &look.name);
    let path = format!("/Scene/Looks/{name}");
    text.open("Material", &name, "")?;
    vellus_name(text, &look.name)?;
    // In a render context of its own, because other renderers do not know the shader.
    text.set("token outputs:vellus:surface.connect", &format!("<{path}/Fur.outputs:surface>"))?;
    text.open("Shader", "Fur", "")?;
    text.set("uniform token info:id", &format!("\"{SHADER}\""))?;
    text.set("token inputs:exit", &format!("\"{}\"", look.fiber.exit))?;
    for parameter in Parameter::ALL {
        let name = format!("inputs:{}", parameter.name());
        let kind = if parameter.channels() > 1 { "color3f" } else { "float" };
        // The fibre stores the absorption, however its colour was given.
        let is_default =
            parameter == Parameter::MedullaPigment && parameter.get(&look.fiber) == parameter.default_value();
        if let Some(value) = parameter.get(&look.fiber).filter(|_| !is_default) {
            let value = to_file(parameter, value);
            let value = if parameter.channels() > 1 { value.text() } else { value[0].text() };
            text.set(&format!("{kind} {name}"), &value)?;
        }
        if look.textured.iter().any(|(p, _)| *p == parameter) {
            let output = if parameter.channels() > 1 { "rgb" } else { "r" };
            let shader = format!("<{path}/{}.outputs:{output}>", parameter.name());
            text.set(&format!("{kind} {name}.connect"), &shader)?;
        }
    }
    text.line("token outputs:surface")?;
    text.close()?;
    for (parameter, value) in &look.textured {
        let output = if parameter.channels() > 1 { "float3 outputs:rgb" } else { "float outputs:r" };
        uv_texture(text, &path, parameter.name(), names, value.texture, value.scale, output)?;
    }
    coordinates(text, !look.textured.is_empty())?;
    text.close()?;
    Ok(path)
}

/// Writes a surface as a material. Returns its path.
pub(crate) fn surface<W: Write>(text: &mut Text<W>, surface: &Surface, names: &Names) -> io::Result<String> {
    let name = text.name("/Scene/Looks", &surface.name);
    let path = format!("/Scene/Looks/{name}");
    text.open("Material", &name, "")?;
    vellus_name(text, &surface.name)?;
    text.set("token outputs:surface.connect", &format!("<{path}/Surface.outputs:surface>"))?;
    text.open("Shader", "Surface", "")?;
    text.set("uniform token info:id", "\"UsdPreviewSurface\"")?;
    match surface.color.texture {
        Some(_) => text.set("color3f inputs:diffuseColor.connect", &format!("<{path}/Color.outputs:rgb>"))?,
        None => text.set("color3f inputs:diffuseColor", &surface.color.color.text())?,
    }
    text.set("color3f inputs:emissiveColor", &surface.emission.text())?;
    text.set("float inputs:roughness", &surface.roughness.text())?;
    text.set("float inputs:metallic", &surface.metallic.text())?;
    text.set("float inputs:ior", &surface.ior.text())?;
    text.line("token outputs:surface")?;
    text.close()?;
    if let Some(texture) = surface.color.texture {
        uv_texture(text, &path, "Color", names, texture, surface.color.color, "float3 outputs:rgb")?;
    }
    coordinates(text, surface.color.texture.is_some())?;
    text.close()?;
    Ok(path)
}

fn uv_texture<W: Write>(
    text: &mut Text<W>,
    material: &str,
    name: &str,
    names: &Names,
    texture: usize,
    scale: [f32; 3],
    output: &str,
) -> io::Result<()> {
    text.open("Shader", name, "")?;
    text.set("uniform token info:id", "\"UsdUVTexture\"")?;
    text.set("asset inputs:file", &format!("@{}@", names.textures[texture]))?;
    text.set("token inputs:sourceColorSpace", "\"raw\"")?;
    text.set("float4 inputs:scale", &[scale[0], scale[1], scale[2], 1.0].text())?;
    for (input, wrap) in WRAP_INPUTS.into_iter().zip(names.wraps[texture]) {
        let word = WRAPS.iter().find(|(_, known)| *known == wrap).map_or("repeat", |(word, _)| word);
        text.set(&format!("token {input}"), &format!("\"{word}\""))?;
    }
    text.set("float2 inputs:st.connect", &format!("<{material}/St.outputs:result>"))?;
    text.line(output)?;
    text.close()
}

/// Writes the reader of the texture coordinates, which other renderers need.
fn coordinates<W: Write>(text: &mut Text<W>, needed: bool) -> io::Result<()> {
    if !needed {
        return Ok(());
    }
    text.open("Shader", "St", "")?;
    text.set("uniform token info:id", "\"UsdPrimvarReader_float2\"")?;
    text.set("string inputs:varname", "\"st\"")?;
    text.line("float2 outputs:result")?;
    text.close()
}
