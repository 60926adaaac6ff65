//! Nodes of MaterialX that compute the value of an input from other values.

use crate::error::Error;
use crate::read::network::Shader;
use crate::read::shading::hair;
use crate::read::shading::mapping::Mapping;
use crate::read::shading::value::Value;

/// The value of a node, or `None` if it is not one of those that are mapped.
pub(super) fn value(mapping: &mut Mapping, node: &Shader) -> Result<Option<Value>, Error> {
    let prim = node.prim.as_str();
    let mut of = |name: &str, default: f64| mapping.value_of(prim, name, [default; 3]);
    let value = match node.id.as_str() {
        "ND_chiang_hair_absorption_from_color" => of_color(mapping, prim)?,
        "ND_deon_hair_absorption_from_melanin" => of_melanin(mapping, prim)?,
        id if id.starts_with("ND_multiply_") => of("in1", 0.0)?.with_each(of("in2", 1.0)?, multiply),
        id if id.starts_with("ND_add_") => of("in1", 0.0)?.with_each(of("in2", 0.0)?, add),
        id if id.starts_with("ND_divide_") => of("in1", 0.0)?.with_each(of("in2", 1.0)?, |a, b| a / b),
        id if id.starts_with("ND_power_") => of("in1", 0.0)?.with_each(of("in2", 1.0)?, f64::powf),
        id if id.starts_with("ND_min_") => of("in1", 0.0)?.with_each(of("in2", 0.0)?, f64::min),
        id if id.starts_with("ND_max_") => of("in1", 0.0)?.with_each(of("in2", 0.0)?, f64::max),
        id if id.starts_with("ND_invert_") => of("amount", 1.0)?.with_each(of("in", 0.0)?, |a, b| a - b),
        // The lower limit first, as in MaterialX: the upper one decides where they cross.
        id if id.starts_with("ND_clamp_") => {
            of("in", 0.0)?.with_each(of("low", 0.0)?, f64::max).with_each(of("high", 1.0)?, f64::min)
        }
        // Values of two numbers are not read.
        id if id.starts_with("ND_extract_") && id != "ND_extract_vector2" => {
            let Value::Constant([index, ..]) = of("index", 0.0)? else { return Ok(None) };
            // Alpha is not read.
            let Some(channel) = [0.0, 1.0, 2.0].iter().position(|known| *known == index) else { return Ok(None) };
            of("in", 0.0)?.map(|color| [color[channel]; 3])
        }
        id if id.starts_with("ND_mix_") => {
            let share = of("mix", 0.0)?;
            // A node without effect is not asked for, so that it gives no warning.
            if share == Value::number(0.0) {
                of("bg", 0.0)?
            } else if share == Value::number(1.0) {
                of("fg", 0.0)?
            } else {
                mix(of("bg", 0.0)?, of("fg", 0.0)?, share)
            }
        }
        _ => return Ok(None),
    };
    // A division by 0 gives 0, and so does each result that is no number, as in OSL.
    Ok(Some(value.map_each(|x| if (x as f32).is_finite() { x } else { 0.0 })))
}

/// A share of 0 gives `a`, and one of 1 gives `b`.
pub(super) fn mix(a: Value, b: Value, share: Value) -> Value {
    if a == b {
        return a;
    }
    let rest = share.clone().map_each(|x| 1.0 - x);
    a.with_each(rest, multiply).with_each(b.with_each(share, multiply), add)
}

pub(super) fn multiply(a: f64, b: f64) -> f64 {
    a * b
}

fn add(a: f64, b: f64) -> f64 {
    a + b
}

/// σ per radius of a colour.
fn of_color(mapping: &mut Mapping, prim: &str) -> Result<Value, Error> {
    let color = mapping.share_of(prim, "color", [1.0; 3])?;
    let roughness = mapping.share_of(prim, "azimuthal_roughness", [0.2; 3])?;
    Ok(color.with(roughness, |c, b| c.map(|c| hair::absorption_of_color(c, b[0]))))
}

/// σ per radius of melanin.
fn of_melanin(mapping: &mut Mapping, prim: &str) -> Result<Value, Error> {
    let concentration = mapping.share_of(prim, "melanin_concentration", [0.25; 3])?;
    let redness = mapping.share_of(prim, "melanin_redness", [0.5; 3])?;
    let mut pigment = |name: &str, default: [f64; 3]| -> Result<[f64; 3], Error> {
        let colored = mapping.share_of(prim, name, default)?.map_each(|c| -c.clamp(1e-4, 1.0).ln());
        let Value::Constant(sigma) = colored else {
            return Err(Error::prim(prim, format!("inputs:{name} cannot have an image")));
        };
        Ok(sigma)
    };
    let eumelanin = pigment("eumelanin_color", [0.657704, 0.498077, 0.254107])?;
    let pheomelanin = pigment("pheomelanin_color", [0.829444, 0.67032, 0.349938])?;
    Ok(concentration
        .with(redness, |c, r| hair::absorption_of_melanin(hair::melanin(c[0]), r[0], [eumelanin, pheomelanin])))
}
