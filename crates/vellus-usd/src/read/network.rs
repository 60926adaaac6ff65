//! Finds the material of a prim, and the sources of shader inputs.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::primvar::ancestors;
use crate::stage::{Property, Stage};

/// The largest number of connections between an input and its value.
const MOST_CONNECTIONS: usize = 128;

/// The material bound to a prim (UsdShadeMaterialBindingAPI).
///
/// The nearest binding on the prim or its ancestors applies, unless a binding further up is stronger than its
/// descendants. Bindings for the purpose `full` precede bindings for all purposes.
pub(crate) fn bound_material(reader: &mut Reader, prim: &str) -> Result<Option<String>, Error> {
    for purpose in ["full", ""] {
        let mut bound = None;
        for path in ancestors(prim) {
            if let Some((relationship, material)) = binding(reader, path, prim, purpose)? {
                let strength = reader.stage.metadata(path, &relationship, "bindMaterialAs")?;
                if bound.is_none() || strength.as_deref() == Some("strongerThanDescendants") {
                    bound = Some(material);
                }
            }
        }
        if bound.is_some() {
            return Ok(bound);
        }
    }
    Ok(None)
}

/// The relationship by which `path` binds a material to `prim`, and the material. `path` is `prim` or an ancestor. The
/// first collection that includes the prim precedes the direct binding of `path`.
fn binding(reader: &mut Reader, path: &str, prim: &str, purpose: &str) -> Result<Option<(String, String)>, Error> {
    for name in reader.stage.properties(path)?.iter() {
        let Some(rest) = name.strip_prefix("material:binding:collection:") else { continue };
        // `name`, or `purpose:name`.
        let of = rest.split_once(':').filter(|(_, name)| !name.contains(':')).map_or("", |(purpose, _)| purpose);
        if of != purpose {
            continue;
        }
        let targets = reader.stage.targets(path, name)?;
        let [collection, material] = &targets[..] else {
            let what = format!("{name} must have two targets, a collection and a material: it is ignored");
            reader.warnings.add(path, what);
            continue;
        };
        match reader.stage.includes(collection, prim) {
            Ok(true) => return Ok(Some((name.to_owned(), material.clone()))),
            Ok(false) => {}
            Err(error) => reader.warnings.add(collection, format!("the collection is empty: {error}")),
        }
    }
    // One for a purpose is stronger.
    reader.stage.know(path, &["material:binding"])?;
    let name = if purpose.is_empty() { "material:binding".to_owned() } else { format!("material:binding:{purpose}") };
    let material = reader.stage.targets(path, &name)?.into_iter().next();
    Ok(material.map(|material| (name, material)))
}

/// The way from an input over its connections. It never visits an attribute twice, and it has a limit.
pub(crate) struct Walk {
    /// The attributes so far. The first one is the input.
    visited: Vec<Property>,
}

impl Walk {
    /// A walk that begins at an input, or at an output of a material or node graph.
    pub fn from(prim: &str, name: &str) -> Self {
        Walk { visited: vec![Property { prim: prim.to_owned(), name: name.to_owned() }] }
    }

    /// Goes to an attribute.
    pub fn go(&mut self, next: Property) -> Result<(), Error> {
        let first = &self.visited[0];
        if self.visited.contains(&next) {
            return Err(Error::prim(&first.prim, format!("{} is connected in a circle", first.name)));
        }
        if self.visited.len() > MOST_CONNECTIONS {
            let what = format!("{} has a chain of more than {MOST_CONNECTIONS} connections", first.name);
            return Err(Error::prim(&first.prim, what));
        }
        self.visited.push(next);
        Ok(())
    }

    /// Follows connections to an output of a shader, or to an attribute with a value.
    pub fn end(&mut self, stage: &Stage) -> Result<Input, Error> {
        let at = loop {
            let at = &self.visited[self.visited.len() - 1];
            match stage.connection(&at.prim, &at.name)? {
                Some(next) => self.go(next)?,
                None => break at.clone(),
            }
        };
        let id = stage.words(&at.prim, "info:id")?.and_then(|words| words.into_iter().next());
        Ok(match (at.name.strip_prefix("outputs:"), id) {
            (Some(output), Some(id)) => Input::Shader(Shader { output: output.to_owned(), prim: at.prim, id }),
            (Some(_), None) => Input::Unset,
            (None, _) if stage.has_value(&at.prim, &at.name)? => Input::Value(at),
            (None, _) => Input::Unset,
        })
    }
}

/// A shader prim, its `info:id`, and one of its outputs.
#[derive(Clone, Debug)]
pub(crate) struct Shader {
    pub prim: String,
    pub id: String,
    pub output: String,
}

/// The source of a shader input.
pub(crate) enum Input {
    /// The input has no value.
    Unset,
    /// The value of this attribute.
    Value(Property),
    /// An output of a shader.
    Shader(Shader),
}

/// The source of an input, or of an output of a material or node graph.
pub(crate) fn input(stage: &Stage, prim: &str, name: &str) -> Result<Input, Error> {
    Walk::from(prim, name).end(stage)
}

/// The surface shader of a material. `outputs:vellus:surface` precedes `outputs:surface`.
pub(crate) fn surface_shader(stage: &Stage, material: &str) -> Result<Option<Shader>, Error> {
    for output in ["outputs:vellus:surface", "outputs:surface"] {
        if let Input::Shader(shader) = input(stage, material, output)? {
            return Ok(Some(shader));
        }
    }
    Ok(None)
}
