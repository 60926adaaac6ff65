//! Reads VellusFur, the shader of a fibre. Its inputs have the names of the parameters ([`Parameter::name`]). Angles
//! are in degrees.

use crate::error::Error;
use crate::read::context::{BoundLook, Reader};
use crate::read::network::{Input, Shader, bound_material, input, surface_shader};
use crate::read::shading;
use crate::read::uv_texture::uv_texture;
use crate::stage::When;
use vellus::{Fiber, FiberBuilder};
use vellus_scene::{Look, Parameter, Value};

/// `info:id` of the shader.
pub(crate) const SHADER: &str = "VellusFur";

/// The name of the look with the fibre [`crate::Options::fallback`]. A scene has this look if a strand uses it.
pub const FALLBACK_LOOK: &str = "fallback";

/// Converts a value of a file to three channels: angles from degrees to radians, and a number to three equal channels.
pub(crate) fn channels(parameter: Parameter, row: &[f32]) -> [f32; 3] {
    let unit = |x: f32| if parameter.is_angle() { f64::from(x).to_radians() as f32 } else { x };
    match (parameter, row) {
        (Parameter::Melanin, &[eumelanin]) => [eumelanin, 0.0, 0.0],
        (Parameter::Melanin, &[eumelanin, pheomelanin, ..]) => [eumelanin, pheomelanin, 0.0],
        (_, &[r, g, b, ..]) => [unit(r), unit(g), unit(b)],
        (_, &[x, ..]) => [unit(x); 3],
        (_, []) => [0.0; 3],
    }
}

/// The look of a prim with curves. Reads it if it is new.
pub(crate) fn look(reader: &mut Reader, prim: &str) -> Result<BoundLook, Error> {
    let material = bound_material(reader, prim)?;
    let shader = material.as_ref().map(|m| surface_shader(&reader.stage, m)).transpose()?.flatten();
    let shader = shader.filter(|shader| shader.id == SHADER);
    if let (Some(material), None) = (&material, &shader) {
        if let Some(known) = reader.looks.get(material) {
            return Ok(known.clone());
        }
        if let Some(look) = shading::look(reader, material)? {
            return Ok(add(reader, material.clone(), look, Vec::new()));
        }
        reader.warnings.add(material, format!("it has no {SHADER} shader: curves with it get the fallback fibre"));
    }
    let key = shader.as_ref().and(material).unwrap_or_default();
    if let Some(known) = reader.looks.get(&key) {
        return Ok(known.clone());
    }
    let (look, primvars) = match shader {
        Some(shader) => fur(reader, &key, &shader)?,
        None => (Look::constant(FALLBACK_LOOK, reader.options.fallback), Vec::new()),
    };
    Ok(add(reader, key, look, primvars))
}

fn add(reader: &mut Reader, key: String, look: Look, primvars: Vec<(Parameter, String)>) -> BoundLook {
    reader.scene.looks.push(look);
    let bound = BoundLook { look: reader.scene.looks.len() - 1, primvars };
    reader.looks.insert(key, bound.clone());
    bound
}

fn fur(reader: &mut Reader, material: &str, shader: &Shader) -> Result<(Look, Vec<(Parameter, String)>), Error> {
    let prim = shader.prim.as_str();
    let out_of_range = |error: vellus::Error| Error::prim(prim, error.to_string());
    let mut base = Fiber::hair();
    if let Input::Value(at) = input(&reader.stage, prim, "inputs:preset")? {
        let preset = reader.stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next());
        base = Fiber::named(&preset.unwrap_or_default()).map_err(out_of_range)?;
    }
    let mut fiber = FiberBuilder::new(base);
    if let Input::Value(at) = input(&reader.stage, prim, "inputs:exit")? {
        let exit = reader.stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next());
        fiber.set_exit(exit.unwrap_or_default().parse().map_err(out_of_range)?);
    }
    pigments(reader, prim, &mut fiber)?;
    let (mut textured, mut primvars) = (Vec::new(), Vec::new());
    for parameter in Parameter::ALL {
        let name = format!("inputs:{}", parameter.name());
        let source = input(&reader.stage, prim, &name)?;
        // If an input has a connection and a value, the value applies where the connection gives none.
        let constant = match &source {
            Input::Unset => None,
            Input::Value(at) => reader.parameter(parameter, &at.prim, &at.name)?,
            Input::Shader(_) => reader.parameter(parameter, prim, &name)?,
        };
        if let Some(numbers) = constant {
            if numbers.len() != 1 {
                return Err(Error::prim(prim, format!("{name} must be a number or a colour")));
            }
            fiber.set_value(parameter, channels(parameter, numbers.row(0)));
        }
        match source {
            Input::Unset | Input::Value(_) => {}
            Input::Shader(source) if source.id == "UsdUVTexture" => {
                let (texture, scale) = uv_texture(reader, &source, parameter.channels() == 1)?;
                let scale = match (parameter, source.output.as_str()) {
                    // One channel only gives eumelanin.
                    (Parameter::Melanin, "r" | "g" | "b") => [scale[0], 0.0, 0.0],
                    (Parameter::Melanin, _) => [scale[0], scale[1], 0.0],
                    _ => scale,
                };
                textured.push((parameter, Value { texture, scale }));
            }
            Input::Shader(source) if source.id.starts_with("UsdPrimvarReader_float") => {
                let names = match input(&reader.stage, &source.prim, "inputs:varname")? {
                    Input::Value(at) => reader.stage.words(&at.prim, &at.name)?.unwrap_or_default(),
                    _ => Vec::new(),
                };
                let varname = names.into_iter().next();
                let varname = varname.ok_or_else(|| Error::prim(&source.prim, "inputs:varname must name a primvar"))?;
                primvars.push((parameter, varname));
            }
            Input::Shader(source) => {
                reader.warnings.add(prim, format!("{name}: a {} is not supported and is ignored", source.id));
            }
        }
    }
    for name in reader.stage.properties(prim)?.iter().map(|name| name.as_str()) {
        let known = |key: &str| {
            ["preset", "exit"].contains(&key) || Parameter::from_name(key).is_some() || PIGMENTS.contains(&key)
        };
        if name.strip_prefix("inputs:").is_some_and(|key| !known(key)) {
            reader.warnings.add(prim, format!("{name} is not a parameter of {SHADER} and is ignored"));
        }
    }
    if let Some(color) = fiber.out_of_reach().map_err(out_of_range)? {
        reader.warnings.add(prim, color.to_string());
    }
    let fiber = fiber.build().map_err(out_of_range)?;
    Ok((Look { name: reader.name(material)?, fiber, textured }, primvars))
}

/// The channels of [`Parameter::Melanin`], which are constant inputs of their own in other shaders for hair.
const PIGMENTS: [&str; 2] = ["eumelanin", "pheomelanin"];

/// Sets the concentrations of the pigments where an input gives one of them.
fn pigments(reader: &mut Reader, prim: &str, fiber: &mut FiberBuilder) -> Result<(), Error> {
    for pigment in PIGMENTS {
        let name = format!("inputs:{pigment}");
        match input(&reader.stage, prim, &name)? {
            Input::Unset => {}
            Input::Value(at) => {
                let numbers = reader.stage.numbers(&at.prim, &at.name, When::Open)?.map(|n| n.values);
                let numbers = numbers.unwrap_or_default();
                fiber.set(pigment, &numbers).map_err(|error| Error::prim(prim, format!("inputs:{error}")))?;
            }
            Input::Shader(_) => {
                let what = format!("{name}: a connection is not supported and is ignored; connect inputs:melanin");
                reader.warnings.add(prim, what);
            }
        }
    }
    Ok(())
}
