//! Maps MaterialX's hair nodes (`ND_chiang_hair_bsdf` of MaterialX 1.39 and the nodes that feed it) to a fibre.

use crate::error::Error;
use crate::read::context::Reader;
use crate::read::network::{Input, Shader, input};
use crate::stage::When;
use std::f64::consts::PI;
use vellus::{Fiber, FiberBuilder, Parameter};

/// The output of a material to which MaterialX's surface is connected.
const SURFACE: &str = "outputs:mtlx:surface";
const BSDF: &str = "ND_chiang_hair_bsdf";

/// The node that MaterialX calls `ND_chiang_hair_bsdf`, if the material has one. A surface without it is a warning.
pub(crate) fn hair_bsdf(reader: &mut Reader, material: &str) -> Result<Option<Shader>, Error> {
    let mut node = match input(&reader.stage, material, SURFACE)? {
        Input::Shader(node) => node,
        _ => return Ok(None),
    };
    if node.id == "ND_surface" {
        node = match input(&reader.stage, &node.prim, "inputs:bsdf")? {
            Input::Shader(bsdf) => bsdf,
            _ => return Ok(None),
        };
    }
    if node.id == BSDF {
        return Ok(Some(node));
    }
    reader.warnings.add(&node.prim, format!("a {} is not a fibre and is ignored", node.id));
    Ok(None)
}

/// The fibre of a node `ND_chiang_hair_bsdf`. A warning reports what was mapped.
///
/// [`Options::network_base`](crate::Options::network_base) gives the parameters that MaterialX lacks.
pub(crate) fn fiber(reader: &mut Reader, bsdf: &Shader) -> Result<Fiber, Error> {
    let prim = bsdf.prim.as_str();
    let ior = numbers::<1>(reader, prim, "ior", [1.55])?;
    let cuticle = numbers::<1>(reader, prim, "cuticle_angle", [0.5])?;
    let [variance, _] = roughness(reader, prim, "roughness_R", [0.1, 0.1])?;
    let [_, scale] = roughness(reader, prim, "roughness_TT", [0.05, 0.05])?;
    let absorption = absorption(reader, prim)?;
    if variance < 0.0 || scale < 0.0 {
        return Err(Error::prim(prim, "the roughness must not be negative"));
    }
    // MaterialX's GLSL limits both to this range.
    let [variance, scale] = [variance, scale].map(|x| x.clamp(0.001, 1.0));
    let mut builder = FiberBuilder::new(reader.options.network_base);
    builder.set_value(Parameter::Eta, [ior[0] as f32; 3]);
    builder.set_value(Parameter::BetaM, [variance.sqrt() as f32; 3]);
    builder.set_value(Parameter::BetaN, [azimuthal(scale) as f32; 3]);
    builder.set_value(Parameter::Alpha, [tilt(cuticle[0]) as f32; 3]);
    builder.set_value(Parameter::SigmaCa, absorption.map(|x| x as f32));
    let fiber = builder.build().map_err(|error| Error::prim(prim, error.to_string()))?;
    let mut lost: Vec<&str> = Vec::new();
    for name in ["tint_R", "tint_TT", "tint_TRT"] {
        if numbers::<3>(reader, prim, name, [1.0; 3])? != [1.0; 3] {
            lost.push(name);
        }
    }
    lost.extend(["roughness of TT and TRT along the fibre", "azimuthal roughness of R and TRT"]);
    let what = format!(
        "{BSDF} is read as a fibre: absorption, ior, roughness and cuticle_angle. kappa = {} and the parameters of the \
         medulla are from --fiber, or from hair without it. Not mapped: {}",
        fiber.kappa,
        lost.join(", ")
    );
    reader.warnings.add(prim, what);
    Ok(fiber)
}

/// β_n in radians, of the scale of a logistic distribution. MaterialX multiplies the scale by √(π/8); a logistic
/// distribution of scale s has the variance π² s² / 3, and TT passes the azimuthal roughness twice.
fn azimuthal(scale: f64) -> f64 {
    PI * (PI / 8.0).sqrt() * scale / 6f64.sqrt()
}

/// α in radians, of `cuticle_angle`. MaterialX's GLSL turns R by 2 (180° c − 90°) towards −`curve_direction` if that is
/// positive, as Vellus turns R by α towards the root.
fn tilt(cuticle: f64) -> f64 {
    2.0 * (cuticle - 0.5) * PI
}

/// Variance along the fibre and scale around it, from a value or from `ND_chiang_hair_roughness`.
fn roughness(reader: &mut Reader, prim: &str, name: &str, default: [f64; 2]) -> Result<[f64; 2], Error> {
    match input(&reader.stage, prim, &format!("inputs:{name}"))? {
        Input::Shader(node) if node.id == "ND_chiang_hair_roughness" => {
            let [l] = numbers::<1>(reader, &node.prim, "longitudinal", [0.1])?;
            let [a] = numbers::<1>(reader, &node.prim, "azimuthal", [0.2])?;
            let output = node.output.rsplit('_').next().unwrap_or_default();
            let [k] = match output {
                "TT" => numbers::<1>(reader, &node.prim, "scale_TT", [0.5])?,
                "TRT" => numbers::<1>(reader, &node.prim, "scale_TRT", [2.0])?,
                _ => [1.0],
            };
            let v = (0.726 * l + 0.812 * l * l + 3.7 * l.powi(20)).powi(2) * k * k;
            Ok([v, 0.265 * a + 1.194 * a * a + 5.372 * a.powi(22)])
        }
        _ => numbers::<2>(reader, prim, name, default),
    }
}

/// σ per radius, from a value or from one of the nodes that make it of a colour or of melanin.
fn absorption(reader: &mut Reader, prim: &str) -> Result<[f64; 3], Error> {
    let name = "absorption_coefficient";
    let Input::Shader(node) = input(&reader.stage, prim, &format!("inputs:{name}"))? else {
        return numbers::<3>(reader, prim, name, [0.0; 3]);
    };
    match node.id.as_str() {
        "ND_chiang_hair_absorption_from_color" => {
            let color = numbers::<3>(reader, &node.prim, "color", [1.0; 3])?;
            let [b] = numbers::<1>(reader, &node.prim, "azimuthal_roughness", [0.2])?;
            Ok(color.map(|c| from_color(c, b)))
        }
        "ND_deon_hair_absorption_from_melanin" => {
            let [concentration] = numbers::<1>(reader, &node.prim, "melanin_concentration", [0.25])?;
            let [redness] = numbers::<1>(reader, &node.prim, "melanin_redness", [0.5])?;
            let eu = numbers::<3>(reader, &node.prim, "eumelanin_color", [0.657704, 0.498077, 0.254107])?;
            let pheo = numbers::<3>(reader, &node.prim, "pheomelanin_color", [0.829444, 0.67032, 0.349938])?;
            let melanin = -(1.0 - concentration).max(1e-4).ln();
            let sigma = |c: f64| -c.max(1e-4).ln();
            Ok(std::array::from_fn(|i| melanin * ((1.0 - redness) * sigma(eu[i]) + redness * sigma(pheo[i]))))
        }
        _ => {
            reader.warnings.add(&node.prim, format!("inputs:{name}: a {} is not mapped and is ignored", node.id));
            numbers::<3>(reader, prim, name, [0.0; 3])
        }
    }
}

/// σ of a colour and an azimuthal roughness, by the fit of Chiang et al. 2016.
fn from_color(color: f64, b: f64) -> f64 {
    let fit = 5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
    (color.clamp(1e-3, 1.0).ln() / fit).powi(2)
}

/// A constant input of N numbers. A connection to a node is a warning, and gives the constant or the default.
fn numbers<const N: usize>(reader: &mut Reader, prim: &str, name: &str, default: [f64; N]) -> Result<[f64; N], Error> {
    let key = format!("inputs:{name}");
    let found = match input(&reader.stage, prim, &key)? {
        Input::Unset => None,
        Input::Value(at) => reader.stage.numbers(&at.prim, &at.name, When::Open)?,
        Input::Shader(node) => {
            reader.warnings.add(prim, format!("{key}: a {} is not mapped and is ignored", node.id));
            reader.stage.numbers(prim, &key, When::Open)?
        }
    };
    let Some(found) = found else { return Ok(default) };
    let wrong = || Error::prim(prim, format!("{key} must have {N} finite numbers"));
    if found.len() != 1 {
        return Err(wrong());
    }
    let row: [f32; N] = found.row(0).try_into().map_err(|_| wrong())?;
    if row.iter().all(|x| x.is_finite()) { Ok(row.map(f64::from)) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formulas_give_the_values_of_hand_calculation() {
        // √(π/8) = 0.626657; π · 0.626657 · 0.1 / √6 = 0.0803724.
        assert!((azimuthal(0.1) - 0.0803724).abs() < 1e-6);
        // c = 0.51: 1.8°, twice.
        assert!((tilt(0.51).to_degrees() - 3.6).abs() < 1e-9);
        // ln 0.5 = −0.693147; the polynomial at 0.3 is 5.949…: σ = 0.013576.
        let fit: f64 = 5.969 - 0.0645 + 0.22788 - 0.28971 + 0.0451494 + 0.00059535;
        assert!((from_color(0.5, 0.3) - (0.5f64.ln() / fit).powi(2)).abs() < 1e-7);
    }
}
