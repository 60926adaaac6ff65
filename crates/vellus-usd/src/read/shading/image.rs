//! Nodes that read an image: those of MaterialX, UsdPreviewSurface, Arnold and RenderMan.

use crate::error::Error;
use crate::read::context::{Reader, TextureSource};
use crate::read::network::{Input, Shader, input};
use crate::read::uv_texture::{WRAPS, texture_source};
use crate::stage::When;
use vellus_scene::{Texture, Wrap};

/// How a program names what its node for images has.
struct Node {
    file: &'static str,
    /// The inputs for the wrap modes along u and v.
    wrap: [&'static str; 2],
    /// Tokens of wrap modes besides those of UsdUVTexture.
    wraps: &'static [(&'static str, Wrap)],
    /// Inputs that move or scale the image, and the values at which they have no effect.
    place: &'static [(&'static str, f32)],
}

const MATERIALX: Node = Node {
    file: "inputs:file",
    wrap: ["inputs:uaddressmode", "inputs:vaddressmode"],
    wraps: &[("periodic", Wrap::Repeat), ("constant", Wrap::Black)],
    place: &[("inputs:uvtiling", 1.0), ("inputs:uvoffset", 0.0)],
};

const ARNOLD: Node = Node {
    file: "inputs:filename",
    wrap: ["inputs:swrap", "inputs:twrap"],
    wraps: &[("periodic", Wrap::Repeat)],
    place: &[("inputs:sscale", 1.0), ("inputs:tscale", 1.0), ("inputs:soffset", 0.0), ("inputs:toffset", 0.0)],
};

const RENDERMAN: Node = Node { file: "inputs:filename", wrap: ["", ""], wraps: &[], place: &[] };

/// The image of a node, or `None` if the node does not read one.
pub(super) fn read(reader: &mut Reader, node: &Shader) -> Result<Option<Texture>, Error> {
    let is_number = node.id.ends_with("_float");
    let names = match node.id.as_str() {
        "UsdUVTexture" | "ND_UsdUVTexture" | "ND_UsdUVTexture_23" => {
            let (source, scale) = texture_source(reader, node, false)?;
            let mut texture = reader.load_texture(&node.prim, &source)?;
            texture.pixels.iter_mut().for_each(|pixel| *pixel = std::array::from_fn(|c| pixel[c] * scale[c]));
            return Ok(Some(texture));
        }
        "arnold:image" => ARNOLD,
        "PxrTexture" => RENDERMAN,
        id if id.starts_with("ND_image_") || id.starts_with("ND_tiledimage_") => MATERIALX,
        _ => return Ok(None),
    };
    let prim = node.prim.as_str();
    let stage = &reader.stage;
    let missing = || Error::prim(prim, format!("{} has no path of a file", names.file));
    let Input::Value(at) = input(stage, prim, names.file)? else { return Err(missing()) };
    let file = stage.asset(&at.prim, &at.name)?.ok_or_else(missing)?;
    let encoding = reader.encoding(&at.prim, &at.name, !is_number && !node.id.contains("_vector"))?;
    let mut wrap = [Wrap::Repeat; 2];
    for (wrap, name) in wrap.iter_mut().zip(names.wrap) {
        let Input::Value(at) = input(&reader.stage, prim, name)? else { continue };
        let word = reader.stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next());
        let word = word.unwrap_or_default();
        match names.wraps.iter().chain(&WRAPS).find(|(known, _)| *known == word) {
            Some((_, known)) => *wrap = *known,
            None => reader.warnings.add(prim, format!("{name} {word} is not supported: the image repeats")),
        }
    }
    for (name, idle) in names.place {
        let Input::Value(at) = input(&reader.stage, prim, name)? else { continue };
        let numbers = reader.stage.numbers(&at.prim, &at.name, When::Open)?;
        if numbers.is_some_and(|numbers| numbers.values.iter().any(|x| x != idle)) {
            reader.warnings.add(prim, format!("{name} is not supported and is ignored"));
        }
    }
    let channel = match node.output.as_str() {
        "r" | "resultR" => Some(0),
        "g" | "resultG" => Some(1),
        "b" | "resultB" => Some(2),
        _ => is_number.then_some(0),
    };
    reader.load_texture(prim, &TextureSource { file, encoding, channel, wrap }).map(Some)
}
