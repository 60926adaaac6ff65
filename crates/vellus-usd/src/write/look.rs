//! Writes materials: VellusFur for strands, UsdPreviewSurface for meshes.

use crate::read::look::SHADER;
use crate::read::surface::SKIN;
use crate::read::uv_texture::{WRAP_INPUTS, WRAPS};
use crate::write::encoder::{Encoder, Role};
use crate::write::names::{Names, to_file, vellus_name};
use crate::write::value::{Asset, Token, Value, Words};
use std::io;
use vellus_scene::{Look, NormalMap, Opacity, Parameter, Surface};

/// Writes a look as a material. Returns its path.
pub(crate) fn look(out: &mut dyn Encoder, look: &Look, names: &mut Names) -> io::Result<String> {
    let name = names.unused("/Scene/Looks", &look.name);
    let path = format!("/Scene/Looks/{name}");
    out.open("Material", &name, Role::Plain)?;
    vellus_name(out, &look.name)?;
    // In a render context of its own, because other renderers do not know the shader.
    out.connect("token outputs:vellus:surface", &format!("{path}/Fur.outputs:surface"))?;
    out.open("Shader", "Fur", Role::Plain)?;
    out.set("uniform token info:id", &Token(SHADER))?;
    for parameter in Parameter::ALL {
        let name = format!("inputs:{}", parameter.name());
        let kind = if parameter.channels() > 1 { "color3f" } else { "float" };
        if let Some(value) = parameter.get(&look.fiber).filter(|_| parameter.describes(&look.fiber)) {
            if let Some(word) = parameter.word(value[0]) {
                out.set(&format!("token {name}"), &Token(word))?;
                continue;
            }
            let value = to_file(parameter, value);
            let value: &dyn Value = if parameter.channels() > 1 { &value } else { &value[0] };
            out.set(&format!("{kind} {name}"), value)?;
        }
        if look.textured.iter().any(|(p, _)| *p == parameter) {
            let output = if parameter.channels() > 1 { "rgb" } else { "r" };
            let shader = format!("{path}/{}.outputs:{output}", parameter.name());
            out.connect(&format!("{kind} {name}"), &shader)?;
        }
    }
    out.declare("token outputs:surface")?;
    out.close()?;
    for (parameter, value) in &look.textured {
        let output = if parameter.channels() > 1 { "float3 outputs:rgb" } else { "float outputs:r" };
        uv_texture(out, &path, parameter.name(), names, value.texture, [value.scale, [0.0; 3]], output)?;
    }
    coordinates(out, !look.textured.is_empty())?;
    out.close()?;
    Ok(path)
}

/// Writes a surface as a material. Returns its path.
pub(crate) fn surface(out: &mut dyn Encoder, surface: &Surface, names: &mut Names) -> io::Result<String> {
    let name = names.unused("/Scene/Looks", &surface.name);
    let path = format!("/Scene/Looks/{name}");
    out.open("Material", &name, Role::Plain)?;
    vellus_name(out, &surface.name)?;
    out.connect("token outputs:surface", &format!("{path}/Surface.outputs:surface"))?;
    out.open("Shader", "Surface", Role::Plain)?;
    out.set("uniform token info:id", &Token("UsdPreviewSurface"))?;
    match surface.color.texture {
        Some(_) => out.connect("color3f inputs:diffuseColor", &format!("{path}/Color.outputs:rgb"))?,
        None => out.set("color3f inputs:diffuseColor", &surface.color.color)?,
    }
    out.set("color3f inputs:emissiveColor", &surface.emission)?;
    out.set("float inputs:roughness", &surface.roughness)?;
    out.set("float inputs:metallic", &surface.metallic)?;
    out.set("float inputs:ior", &surface.ior)?;
    let Opacity { value, texture, threshold } = surface.opacity;
    match texture {
        Some(_) => out.connect("float inputs:opacity", &format!("{path}/Opacity.outputs:r"))?,
        None => out.set("float inputs:opacity", &value)?,
    }
    out.set("float inputs:opacityThreshold", &threshold)?;
    if surface.normals.is_some() {
        out.connect("normal3f inputs:normal", &format!("{path}/Normal.outputs:rgb"))?;
    }
    if surface.skin {
        out.set(&format!("custom token {SKIN}"), &Token("auto"))?;
    }
    out.declare("token outputs:surface")?;
    out.close()?;
    if let Some(texture) = surface.color.texture {
        uv_texture(out, &path, "Color", names, texture, [surface.color.color, [0.0; 3]], "float3 outputs:rgb")?;
    }
    if let Some(texture) = texture {
        uv_texture(out, &path, "Opacity", names, texture, [[value; 3], [0.0; 3]], "float outputs:r")?;
    }
    if let Some(NormalMap { texture, scale, bias }) = surface.normals {
        uv_texture(out, &path, "Normal", names, texture, [scale, bias], "float3 outputs:rgb")?;
    }
    coordinates(out, surface.color.texture.or(texture).is_some() || surface.normals.is_some())?;
    out.close()?;
    Ok(path)
}

fn uv_texture(
    out: &mut dyn Encoder,
    material: &str,
    name: &str,
    names: &Names,
    texture: usize,
    [scale, bias]: [[f32; 3]; 2],
    output: &str,
) -> io::Result<()> {
    out.open("Shader", name, Role::Plain)?;
    out.set("uniform token info:id", &Token("UsdUVTexture"))?;
    out.set("asset inputs:file", &Asset(&names.textures[texture]))?;
    out.set("token inputs:sourceColorSpace", &Token("raw"))?;
    out.set("float4 inputs:scale", &[scale[0], scale[1], scale[2], 1.0])?;
    if bias != [0.0; 3] {
        out.set("float4 inputs:bias", &[bias[0], bias[1], bias[2], 0.0])?;
    }
    for (input, wrap) in WRAP_INPUTS.into_iter().zip(names.wraps[texture]) {
        let word = WRAPS.iter().find(|(_, known)| *known == wrap).map_or("repeat", |(word, _)| word);
        out.set(&format!("token {input}"), &Token(word))?;
    }
    out.connect("float2 inputs:st", &format!("{material}/St.outputs:result"))?;
    out.declare(output)?;
    out.close()
}

/// Writes the reader of the texture coordinates, which other renderers need.
fn coordinates(out: &mut dyn Encoder, needed: bool) -> io::Result<()> {
    if !needed {
        return Ok(());
    }
    out.open("Shader", "St", Role::Plain)?;
    out.set("uniform token info:id", &Token("UsdPrimvarReader_float2"))?;
    out.set("string inputs:varname", &Words("st"))?;
    out.declare("float2 outputs:result")?;
    out.close()
}
