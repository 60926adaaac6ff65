//! Reads textures (UsdUVTexture).

use crate::color::ColorSpace;
use crate::error::Error;
use crate::image::Encoding;
use crate::read::context::{Reader, TextureSource};
use crate::read::network::{Input, Shader, input};
use crate::stage::{Stage, When};
use crate::warning::Fault;
use vellus_scene::{NormalMap, Texture, Wrap};

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

/// The colour of a texture that cannot be read and has no fallback. Nothing in a picture has it by chance.
const MARKED: [f32; 3] = [1.0, 0.0, 1.0];

/// The index of the texture in the scene, and its scale. `is_number` means that only the first channel is used.
///
/// A texture that cannot be read is replaced by its fallback, or by a marked colour if it `is_color`. `None` if it has
/// neither.
pub(crate) fn uv_texture(
    reader: &mut Reader,
    shader: &Shader,
    is_number: bool,
    is_color: bool,
) -> Result<Option<(usize, [f32; 3])>, Error> {
    let read = texture_source(reader, shader, is_number)
        .and_then(|(source, scale)| Ok((reader.texture(&shader.prim, source)?, scale)));
    let error = match read {
        Ok(found) => return Ok(Some(found)),
        Err(error) => error,
    };
    let fallback = reader.colors(&shader.prim, "inputs:fallback").ok().flatten();
    let fallback = fallback.and_then(|found| match found.values.as_slice() {
        &[r, g, b, ..] if [r, g, b].iter().all(|x| x.is_finite()) => Some([r, g, b]),
        _ => None,
    });
    let (instead, color) = match fallback {
        Some(color) => ("its fallback is used", Some(color)),
        None if is_color => ("it is magenta", Some(MARKED)),
        None => ("the input has its own value, or its default", None),
    };
    reader.fault(Fault::Texture, &shader.prim, error, instead)?;
    Ok(color.map(|color| {
        let channel = ["r", "g", "b"].iter().position(|name| *name == shader.output);
        let pixel = channel.map_or(color, |channel| [color[channel]; 3]);
        let texture = Texture {
            name: shader.prim.clone(),
            width: 1,
            height: 1,
            pixels: vec![pixel].into(),
            wrap: [Wrap::Repeat; 2],
        };
        (reader.add_texture(texture, None), [1.0; 3])
    }))
}

/// Four numbers of a texture: the first three, or the fourth one thrice.
fn four(stage: &Stage, prim: &str, name: &str, fallback: f32, is_alpha: bool) -> Result<[f32; 3], Error> {
    match stage.numbers(prim, name, When::Open)?.map(|n| n.values).as_deref() {
        None => Ok([fallback; 3]),
        Some(&[_, _, _, a]) if is_alpha && a.is_finite() => Ok([a; 3]),
        Some(&[r, g, b, _]) if r.is_finite() && g.is_finite() && b.is_finite() => Ok([r, g, b]),
        Some(_) => Err(Error::prim(prim, format!("{name} must be four finite numbers"))),
    }
}

/// The normal map that a texture is. Without its own scale and bias, they are those that the schema of
/// UsdPreviewSurface asks for.
pub(crate) fn normal_map(reader: &mut Reader, shader: &Shader) -> Result<Option<NormalMap>, Error> {
    let prim = shader.prim.as_str();
    let read = read_source(reader, shader, false).and_then(|(source, scale)| {
        // Numbers, whatever the file says of colours.
        let encoding = match source.encoding {
            Encoding::Auto => Encoding::Space(ColorSpace::LINEAR),
            other => other,
        };
        let has_scale = reader.stage.has_value(prim, "inputs:scale")?;
        let [scale, bias] = if has_scale {
            [scale, four(reader.stage, prim, "inputs:bias", 0.0, false)?]
        } else {
            [[2.0; 3], [-1.0; 3]]
        };
        reader.stage.know(prim, &["inputs:bias"])?;
        Ok(NormalMap { texture: reader.texture(prim, TextureSource { encoding, ..source })?, scale, bias })
    });
    match read {
        Ok(map) => Ok(Some(map)),
        Err(error) => {
            reader.fault(Fault::Texture, prim, error, "the normals are those of the mesh")?;
            Ok(None)
        }
    }
}

/// What the shader reads, and its scale. `is_number` means that only the first channel is used.
pub(crate) fn texture_source(
    reader: &mut Reader,
    shader: &Shader,
    is_number: bool,
) -> Result<(TextureSource, [f32; 3]), Error> {
    let found = read_source(reader, shader, is_number)?;
    let prim = shader.prim.as_str();
    if four(reader.stage, prim, "inputs:bias", 0.0, shader.output == "a")? != [0.0; 3] {
        reader.warnings.add(prim, "inputs:bias is not supported and is ignored");
    }
    Ok(found)
}

fn read_source(reader: &mut Reader, shader: &Shader, is_number: bool) -> Result<(TextureSource, [f32; 3]), Error> {
    let prim = shader.prim.as_str();
    reader.prim(prim)?;
    let stage = reader.stage;
    let missing = || Error::prim(prim, "inputs:file has no path of a file");
    let Input::Value(at) = input(stage, prim, "inputs:file")? else { return Err(missing()) };
    // An error after everything else was asked for.
    let file = stage.asset(&at.prim, &at.name).and_then(|file| file.ok_or_else(missing));
    let channel = match shader.output.as_str() {
        "rgb" => None,
        "r" => (!is_number).then_some(0),
        "g" => Some(1),
        "b" => Some(2),
        "a" => None,
        other => {
            let what = format!("its output {other} is not supported: it must be rgb, r, g, b or a");
            return Err(Error::prim(prim, what));
        }
    };
    let space = match input(stage, prim, "inputs:sourceColorSpace")? {
        Input::Value(at) => stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next()),
        _ => None,
    };
    let is_alpha = shader.output == "a";
    // The colour space of the file counts where the shader leaves it open.
    let encoding = match space.filter(|space| !["", "auto"].contains(&space.as_str())) {
        _ if is_alpha => Encoding::Alpha,
        None => reader.encoding(&at.prim, &at.name, true)?,
        space => {
            let known = reader.color_space(prim, "inputs:sourceColorSpace", space.as_deref())?;
            known.map_or(Encoding::Auto, Encoding::Space)
        }
    };
    let stage = reader.stage;
    let scale = four(stage, prim, "inputs:scale", 1.0, is_alpha)?;
    let [s, t] = WRAP_INPUTS;
    let wrap = [wrap(stage, prim, s)?, wrap(stage, prim, t)?];
    let coordinates = input(stage, prim, "inputs:st")?;
    let uv = match coordinates {
        Input::Shader(source) => coordinate_set(reader, prim, source)?,
        _ => None,
    };
    Ok((TextureSource { file: file?, encoding, channel, wrap, uv }, channel.map_or(scale, |c| [scale[c]; 3])))
}

/// The name of the primvar that a texture is looked up at, without `primvars:`. Transforms are not supported.
fn coordinate_set(reader: &mut Reader, prim: &str, mut source: Shader) -> Result<Option<String>, Error> {
    if matches!(source.id.as_str(), "UsdTransform2d" | "ND_UsdTransform2d") {
        let transform = reader.prim(&source.prim)?;
        for (name, idle) in [("inputs:scale", 1.0), ("inputs:rotation", 0.0), ("inputs:translation", 0.0)] {
            if transform.numbers(name)?.is_some_and(|numbers| numbers.values.iter().any(|x| *x != idle)) {
                reader.warnings.add(&source.prim, format!("{name} of texture coordinates is not supported"));
            }
        }
        let Input::Shader(inner) = transform.input("inputs:in")? else { return Ok(None) };
        source = inner;
    }
    if !matches!(source.id.as_str(), "UsdPrimvarReader_float2" | "ND_UsdPrimvarReader_vector2") {
        let what = format!("texture coordinates of a {} are not supported: the primvar st is used", source.id);
        reader.warnings.add(prim, what);
        return Ok(None);
    }
    reader.prim(&source.prim)?.input_token("inputs:varname")
}
