//! Reads VellusFur, the shader of a fibre. Its inputs have the names of the parameters ([`Parameter::name`]). Angles
//! are in degrees.

use crate::error::Error;
use crate::read::context::{BoundLook, Reader};
use crate::read::network::{Input, Shader, bound_material, input, surface_shader};
use crate::read::shading;
use crate::read::uv_texture::uv_texture;
use crate::stage::When;
use crate::warning::Fault;
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

/// A look, and the parameters that its shader reads from primvars.
pub(crate) type Shaded = (Look, Vec<(Parameter, String)>);

/// What happens to curves whose material cannot be read.
const INSTEAD: &str = "curves with it get the fallback fibre";

/// The look of a prim with curves. Reads it if it is new. Without a material that can be read, it is the fallback.
pub(crate) fn look(reader: &mut Reader, prim: &str) -> Result<BoundLook, Error> {
    let material = match bound_material(reader, prim) {
        Ok(material) => material,
        Err(error) => {
            reader.fault(Fault::Material, prim, error, INSTEAD)?;
            None
        }
    };
    let Some(material) = material else { return Ok(fallback(reader, "")) };
    if let Some(known) = reader.looks.get(&material) {
        return Ok(known.clone());
    }
    match shaded(reader, &material) {
        Ok(Some((look, primvars))) => return Ok(add(reader, &material, look, primvars)),
        Ok(None) => reader.warnings.add(&material, format!("it has no {SHADER} shader: {INSTEAD}")),
        Err(error) => reader.fault(Fault::Material, &material, error, INSTEAD)?,
    }
    Ok(fallback(reader, &material))
}

/// The look of a material, or `None` if it has no shader of fibres.
fn shaded(reader: &mut Reader, material: &str) -> Result<Option<Shaded>, Error> {
    match surface_shader(reader.stage, material)? {
        Some(shader) if shader.id == SHADER => fur(reader, material, &shader).map(Some),
        _ => shading::look(reader, material),
    }
}

/// The fibre of curves without a material. Their displayColor is the reflectance of the coat.
fn fallback(reader: &mut Reader, key: &str) -> BoundLook {
    let known = reader.looks.get("").cloned();
    let bound = known.unwrap_or_else(|| {
        let look = Look::constant(FALLBACK_LOOK, reader.options.fallback);
        add(reader, "", look, vec![(Parameter::Reflectance, DISPLAY_COLOR.to_owned())])
    });
    reader.looks.insert(key.to_owned(), bound.clone());
    bound
}

/// The name of the primvar with the colour of a prim without a material.
pub(crate) const DISPLAY_COLOR: &str = "displayColor";

fn add(reader: &mut Reader, key: &str, look: Look, primvars: Vec<(Parameter, String)>) -> BoundLook {
    let sets: Vec<_> = look.textured.iter().filter_map(|(_, value)| reader.uv_sets.get(&value.texture)).collect();
    let uv = sets.first().map(|&set| set.clone());
    if let Some(other) = sets.iter().find(|other| Some(**other) != uv.as_ref()) {
        let what =
            format!("its textures have several sets of coordinates ({other}, …): all are looked up at the first");
        reader.warnings.add(key, what);
    }
    reader.scene.looks.push(look);
    let bound = BoundLook { look: reader.scene.looks.len() - 1, primvars, uv };
    reader.looks.insert(key.to_owned(), bound.clone());
    bound
}

fn fur(reader: &mut Reader, material: &str, shader: &Shader) -> Result<Shaded, Error> {
    let prim = shader.prim.as_str();
    reader.prim(prim)?;
    let out_of_range = |error: vellus::Error| Error::prim(prim, error.to_string());
    let mut base = Fiber::hair();
    if let Input::Value(at) = input(reader.stage, prim, "inputs:preset")? {
        let preset = reader.stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next());
        base = Fiber::named(&preset.unwrap_or_default()).map_err(out_of_range)?;
    }
    let mut fiber = FiberBuilder::new(base);
    pigments(reader, prim, &mut fiber)?;
    let (mut textured, mut primvars) = (Vec::new(), Vec::new());
    for parameter in Parameter::ALL {
        let name = format!("inputs:{}", parameter.name());
        let source = input(reader.stage, prim, &name)?;
        if !parameter.choices().is_empty() {
            if let Input::Value(at) = source {
                let word = reader.stage.words(&at.prim, &at.name)?.and_then(|words| words.into_iter().next());
                fiber.set_word(parameter.name(), &word.unwrap_or_default()).map_err(out_of_range)?;
            }
            continue;
        }
        // If an input has a connection and a value, the value applies where the connection gives none.
        let constant = match &source {
            Input::Unset => None,
            Input::Value(at) => reader.parameter(parameter, &at.prim, &at.name)?,
            Input::Shader(source) => match reader.parameter(parameter, prim, &name)? {
                None if source.id.starts_with(PRIMVAR_READER) => {
                    reader.parameter(parameter, &source.prim, "inputs:fallback")?
                }
                own => own,
            },
        };
        if let Some(mut numbers) = constant {
            if numbers.len() != 1 {
                return Err(Error::prim(prim, format!("{name} must be a number or a colour")));
            }
            hold(reader, prim, parameter, &name, &mut numbers.values)?;
            fiber.set_value(parameter, channels(parameter, numbers.row(0)));
        }
        match source {
            Input::Unset | Input::Value(_) => {}
            Input::Shader(_) if !parameter.varies() => {
                reader.warnings.add(prim, format!("{name} is one number for all strands: its connection is ignored"));
            }
            Input::Shader(source) if source.id == "UsdUVTexture" => {
                let is_color = matches!(parameter, Parameter::Reflectance | Parameter::HairReflectance);
                let Some((texture, scale)) = uv_texture(reader, &source, parameter.channels() == 1, is_color)? else {
                    continue;
                };
                let scale = match (parameter, source.output.as_str()) {
                    // One channel only gives eumelanin.
                    (Parameter::Melanin, "r" | "g" | "b") => [scale[0], 0.0, 0.0],
                    (Parameter::Melanin, _) => [scale[0], scale[1], 0.0],
                    _ => scale,
                };
                textured.push((parameter, Value { texture, scale }));
            }
            Input::Shader(source) if source.id.starts_with(PRIMVAR_READER) => {
                let varname = reader.prim(&source.prim)?.input_token("inputs:varname")?;
                let varname = varname.ok_or_else(|| Error::prim(&source.prim, "inputs:varname must name a primvar"))?;
                primvars.push((parameter, varname));
            }
            Input::Shader(source) => {
                reader.warnings.add(prim, format!("{name}: a {} is not supported and is ignored", source.id));
            }
        }
    }
    if let Some(color) = fiber.out_of_reach().map_err(out_of_range)? {
        reader.warnings.add(prim, color.to_string());
    }
    let fiber = fiber.build().map_err(out_of_range)?;
    Ok((Look { name: reader.name(material)?, fiber, textured }, primvars))
}

/// The beginning of the ids of shaders that read primvars with numbers.
pub(crate) const PRIMVAR_READER: &str = "UsdPrimvarReader_float";

/// Moves values of an input to the nearest ones in the range of a parameter, with a warning; an error if the user named
/// the file.
fn hold(reader: &mut Reader, prim: &str, parameter: Parameter, name: &str, values: &mut [f32]) -> Result<(), Error> {
    for value in values.iter_mut().take(parameter.channels()) {
        let (range, unit) = (parameter.range(), parameter.unit().suffix());
        if !value.is_finite() {
            return Err(Error::prim(prim, format!("{name} is {value}: it must be finite")));
        }
        if !range.contains(*value) {
            let nearest = range.nearest(*value);
            let what = format!("{name} is {value}: the range is {range}{unit}, so it is clamped to {nearest}");
            reader.complain(prim, what)?;
            *value = nearest;
        }
    }
    Ok(())
}

/// The channels of [`Parameter::Melanin`], which are constant inputs of their own in other shaders for hair.
const PIGMENTS: [&str; 2] = ["eumelanin", "pheomelanin"];

/// Sets the concentrations of the pigments where an input gives one of them.
fn pigments(reader: &mut Reader, prim: &str, fiber: &mut FiberBuilder) -> Result<(), Error> {
    for pigment in PIGMENTS {
        let name = format!("inputs:{pigment}");
        match input(reader.stage, prim, &name)? {
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
