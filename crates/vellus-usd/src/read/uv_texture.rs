//! Reads textures (UsdUVTexture).

use crate::error::Error;
use crate::image::Encoding;
use crate::read::context::{Reader, TextureSource};
use crate::read::network::{Input, Shader, input};
use crate::stage::{Stage, When};
use vellus_scene::Wrap;

/// The inputs for the wrap modes along u and v.
pub(crate) const WRAP_INPUTS: [&str; 2] = ["inputs:wrapS", "inputs:wrapT"];

/// The tokens of the wrap modes.
pub(crate) const WRAPS: [(&str, Wrap); 4] =
    [("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror), ("black", Wrap::Black)];

/// The wrap mode of a shader. Metadata of images is not read: `useMetadata`, which is the default, means repeat.
fn wrap(stage: &Stage, prim: &str, name: &str) -> Result<Wrap, Error> {
    let Input::Value(at) = input(stage, prim, name)? else { return Ok(Wrap::default()) };
    let words = stage.words(&at.prim, &at.name)?.unwrap_or_default();
    let word = words.first().map_or("useMetadata", String::as_str);
    let known = WRAPS.iter().find(|(known, _)| *known == word).map(|(_, wrap)| *wrap);
    known.or((word == "useMetadata").then(Wrap::default)).ok_or_else(|| {
        Error::prim(prim, format!("{name} is {word}: it must be repeat, clamp, mirror, black or useMetadata"))
    })
}

/// The index of the texture in the scene, and its scale. `is_number` means that only the first channel is used.
pub(crate) fn uv_texture(reader: &mut Reader, shader: &Shader, is_number: bool) -> Result<(usize, [f32; 3]), Error> {
    let (source, scale) = texture_source(reader, shader, is_number)?;
    Ok((reader.texture(&shader.prim, source)?, scale))
}

/// What the shader reads, and its scale. `is_number` means that only the first channel is used.
pub(crate) fn texture_source(
    reader: &mut Reader,
    shader: &Shader,
    is_number: bool,
) -> Result<(TextureSource, [f32; 3]), Error> {
    let prim = shader.prim.as_str();
    let stage = &reader.stage;
    let missing = || Error::prim(prim, "inputs:file has no path of a file");
    let Input::Value(at) = input(stage, prim, "inputs:file")? else { return Err(missing()) };
    let file = stage.asset(&at.prim, &at.name)?.ok_or_else(missing)?;
    let channel = match shader.output.as_str() {
        "rgb" => None,
        "r" => (!is_number).then_some(0),
        "g" => Some(1),
        "b" => Some(2),
        other => {
            return Err(Error::prim(prim, format!("its output {other} is not supported: it must be rgb, r, g or b")));
        }
    };
    let space = match input(stage, prim, "inputs:sourceColorSpace")? {
        Input::Value(at) => stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next()),
        _ => None,
    };
    // The colour space of the file counts where the shader leaves it open.
    let encoding = match space.filter(|space| !["", "auto"].contains(&space.as_str())) {
        None => reader.encoding(&at.prim, &at.name, true)?,
        space => {
            let known = reader.color_space(prim, "inputs:sourceColorSpace", space.as_deref())?;
            known.map_or(Encoding::Auto, Encoding::Space)
        }
    };
    let stage = &reader.stage;
    let four = |name: &str, fallback: f32| -> Result<[f32; 3], Error> {
        match stage.numbers(prim, name, When::Open)?.map(|n| n.values).as_deref() {
            None => Ok([fallback; 3]),
            Some(&[r, g, b, _]) if r.is_finite() && g.is_finite() && b.is_finite() => Ok([r, g, b]),
            Some(_) => Err(Error::prim(prim, format!("{name} must be four finite numbers"))),
        }
    };
    let scale = four("inputs:scale", 1.0)?;
    let bias = four("inputs:bias", 0.0)?;
    let [s, t] = WRAP_INPUTS;
    let wrap = [wrap(stage, prim, s)?, wrap(stage, prim, t)?];
    let coordinates = input(stage, prim, "inputs:st")?;
    if bias != [0.0; 3] {
        reader.warnings.add(prim, "inputs:bias is not supported and is ignored");
    }
    if let Input::Shader(source) = coordinates {
        let names = reader.stage.words(&source.prim, "inputs:varname")?.unwrap_or_default();
        if source.id != "UsdPrimvarReader_float2" || names.first().is_some_and(|n| n != "st" && n != "uv") {
            reader.warnings.add(prim, "texture coordinates are always the primvar st, without transforms");
        }
    }
    Ok((TextureSource { file, encoding, channel, wrap }, channel.map_or(scale, |c| [scale[c]; 3])))
}
