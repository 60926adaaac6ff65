//! Materials: which one a prim has, and where the inputs of its shaders take their values from.

use crate::error::Error;
use crate::primvar::ancestors;
use crate::stage::{Property, Stage};

/// Longer chains of connections are taken for a circle.
const LONGEST_CHAIN: usize = 32;

/// The material bound to a prim or to its nearest ancestor that has one.
pub(crate) fn bound_material(stage: &Stage, prim: &str) -> Result<Option<String>, Error> {
    for relationship in ["material:binding:full", "material:binding"] {
        for path in ancestors(prim) {
            if let Some(material) = stage.targets(path, relationship)?.into_iter().next() {
                return Ok(Some(material));
            }
        }
    }
    Ok(None)
}

/// The attribute at the end of the connections of one: an output of a shader, or what holds the value.
fn source(stage: &Stage, prim: &str, name: &str) -> Result<Property, Error> {
    let mut at = Property { prim: prim.to_owned(), name: name.to_owned() };
    for _ in 0..LONGEST_CHAIN {
        match stage.connection(&at.prim, &at.name)? {
            Some(next) => at = next,
            None => return Ok(at),
        }
    }
    Err(Error::prim(prim, format!("{name} is connected in a circle")))
}

/// A shader, the kind it says it is, and one of its outputs.
#[derive(Clone, Debug)]
pub(crate) struct Shader {
    pub prim: String,
    pub id: String,
    pub output: String,
}

/// What gives an input its value.
pub(crate) enum Input {
    /// Nothing.
    Unset,
    /// The value of this attribute.
    Value(Property),
    /// An output of a shader.
    Shader(Shader),
}

/// What gives an input (or the output of a material or node graph) its value.
pub(crate) fn input(stage: &Stage, prim: &str, name: &str) -> Result<Input, Error> {
    let at = source(stage, prim, name)?;
    let id = stage.words(&at.prim, "info:id")?.and_then(|words| words.into_iter().next());
    Ok(match (at.name.strip_prefix("outputs:"), id) {
        (Some(output), Some(id)) => Input::Shader(Shader { output: output.to_owned(), prim: at.prim, id }),
        (Some(_), None) => Input::Unset,
        (None, _) if stage.has_value(&at.prim, &at.name)? => Input::Value(at),
        (None, _) => Input::Unset,
    })
}

/// The shader of a material's surface; one made for us goes before that for all renderers.
pub(crate) fn surface_shader(stage: &Stage, material: &str) -> Result<Option<Shader>, Error> {
    for output in ["outputs:vellus:surface", "outputs:surface"] {
        if let Input::Shader(shader) = input(stage, material, output)? {
            return Ok(Some(shader));
        }
    }
    Ok(None)
}
