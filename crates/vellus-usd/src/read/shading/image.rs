//! Nodes that read an image: those of MaterialX, UsdPreviewSurface, Arnold and RenderMan.

use crate::error::Error;
use crate::read::context::{Reader, TextureSource};
use crate::read::network::{Input, Shader, input};
use crate::read::uv_texture::{WRAPS, texture_source};
use crate::stage::When;
use crate::warning::Fault;
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

/// An image, and the name of its texture coordinates, without `primvars:`, if the shader names them.
type Found = (Texture, Option<String>);

/// The image of a node, or `None` if the node does not read one, or with a warning if it cannot be read.
pub(super) fn read(reader: &mut Reader, node: &Shader) -> Result<Option<Found>, Error> {
    match image(reader, node) {
        Err(error) => {
            reader.fault(Fault::Texture, &node.prim, error, "the input has its own value, or its default")?;
            Ok(None)
        }
        found => found,
    }
}

fn image(reader: &mut Reader, node: &Shader) -> Result<Option<Found>, Error> {
    let is_number = node.id.ends_with("_float");
    let names = match node.id.as_str() {
        "UsdUVTexture" | "ND_UsdUVTexture" | "ND_UsdUVTexture_23" => {
            let (source, scale) = texture_source(reader, node, false)?;
            let mut texture = reader.load_texture(&node.prim, &source)?;
            texture.pixels.map_each(|c, x| x * scale[c]);
            return Ok(Some((texture, source.uv)));
        }
        "arnold:image" => ARNOLD,
        "PxrTexture" => RENDERMAN,
        id if id.starts_with("ND_image_") || id.starts_with("ND_tiledimage_") => MATERIALX,
        _ => return Ok(None),
    };
    let prim = node.prim.as_str();
    reader.prim(prim)?;
    let stage = reader.stage;
    let missing = || Error::prim(prim, format!("{} has no path of a file", names.file));
    let Input::Value(at) = input(stage, prim, names.file)? else { return Err(missing()) };
    // An error after everything else was asked for.
    let file = stage.asset(&at.prim, &at.name).and_then(|file| file.ok_or_else(missing));
    let encoding = reader.encoding(&at.prim, &at.name, !is_number && !node.id.contains("_vector"))?;
    let mut wrap = [Wrap::Repeat; 2];
    for (wrap, name) in wrap.iter_mut().zip(names.wrap) {
        let Input::Value(at) = input(reader.stage, prim, name)? else { continue };
        let word = reader.stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next());
        let word = word.unwrap_or_default();
        match names.wraps.iter().chain(&WRAPS).find(|(known, _)| *known == word) {
            Some((_, known)) => *wrap = *known,
            None => reader.warnings.add(prim, format!("{name} {word} is not supported: the image repeats")),
        }
    }
    for (name, idle) in names.place {
        let Input::Value(at) = input(reader.stage, prim, name)? else { continue };
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
    let uv = set_of(reader, prim)?;
    let texture = reader.load_texture(prim, &TextureSource { file: file?, encoding, channel, wrap, uv: None })?;
    Ok(Some((texture, uv)))
}

/// The name of the texture coordinates of a node of MaterialX or Arnold. `None` if it takes those of the mesh.
fn set_of(reader: &mut Reader, prim: &str) -> Result<Option<String>, Error> {
    if let Some(set) = reader.prim(prim)?.input_token("inputs:uvset")?.filter(|set| !set.is_empty()) {
        return Ok(Some(set));
    }
    let Input::Shader(source) = input(reader.stage, prim, "inputs:texcoord")? else { return Ok(None) };
    let name = match source.id.as_str() {
        "ND_texcoord_vector2" => return Ok(None),
        id if id.starts_with("ND_geompropvalue_") => "inputs:geomprop",
        id if id.starts_with("ND_UsdPrimvarReader_") => "inputs:varname",
        id => {
            let what = format!("texture coordinates of a {id} are not supported: the default ones are used");
            reader.warnings.add(prim, what);
            return Ok(None);
        }
    };
    reader.prim(&source.prim)?.input_token(name)
}
