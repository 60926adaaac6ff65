//! `ND_chiang_hair_bsdf` of MaterialX 1.39, and the node of Vellus, `ND_vellus_fiber_bsdf`.

use crate::error::Error;
use crate::read::shading::hair;
use crate::read::shading::mapping::Mapping;
use crate::read::shading::value::Value;
use crate::stage::When;
use vellus::Parameter;

/// Reads `ND_chiang_hair_bsdf`.
pub(super) fn map(mapping: &mut Mapping) -> Result<(), Error> {
    let absorption = mapping.value("absorption_coefficient", [0.0; 3])?;
    mapping.set(Parameter::SigmaCa, absorption, "absorption_coefficient");
    let [variance, _] = roughness(mapping, "roughness_R", [0.1, 0.1])?;
    let [_, scale] = roughness(mapping, "roughness_TT", [0.05, 0.05])?;
    hair::set_roughness(mapping, variance, scale, ["roughness_R", "roughness_TT"]);
    let ior = mapping.number("ior", 1.55)?;
    mapping.set(Parameter::Eta, ior, "ior");
    // Values above 0.5 tilt the scales towards the root.
    let cuticle = mapping.constant("cuticle_angle", 0.5)?;
    mapping.set(Parameter::Alpha, Value::number(hair::alpha(180.0 * cuticle - 90.0)), "cuticle_angle");
    mapping.lose_unless(1.0, &["tint_R", "tint_TT", "tint_TRT"])?;
    mapping.lose("roughness of TT and TRT along the fibre");
    mapping.lose("azimuthal roughness of R and TRT");
    mapping.known(&["roughness_TRT", "curve_direction"]);
    Ok(())
}

/// The definition of the node of Vellus: `integrations/materialx/vellus.mtlx`.
pub(super) const OWN: &str = "ND_vellus_fiber_bsdf";

/// Reads `ND_vellus_fiber_bsdf`. Its inputs have the names, units and defaults of the parameters. A colour of 0 is not
/// given, and one that is given replaces sigma_ca.
pub(super) fn own(mapping: &mut Mapping) -> Result<(), Error> {
    let prim = mapping.shader.prim.clone();
    mapping.begin_with_defaults()?;
    let mut is_colored = false;
    // Colours come last.
    for parameter in Parameter::ALL.into_iter().rev() {
        let name = parameter.name();
        if !parameter.choices().is_empty() || !mapping.has(name)? || (parameter == Parameter::SigmaCa && is_colored) {
            mapping.known(&[name]);
            continue;
        }
        let value = match parameter {
            Parameter::Melanin => {
                let [eumelanin, pheomelanin] = pair(mapping, &prim, name, [0.0; 2])?;
                eumelanin.with(pheomelanin, |a, b| [a[0], b[0], 0.0])
            }
            _ => mapping.value(name, [0.0; 3])?,
        };
        if parameter.default_value().is_none() {
            if value == Value::number(0.0) {
                continue;
            }
            is_colored = true;
        }
        let stored = |x: f64| if parameter.is_angle() { x.to_radians() } else { x };
        mapping.set(parameter, value.map_each(stored), name);
    }
    Ok(())
}

/// Variance along the fibre and scale around it, from a value or from `ND_chiang_hair_roughness`.
fn roughness(mapping: &mut Mapping, name: &str, default: [f64; 2]) -> Result<[Value; 2], Error> {
    let prim = mapping.shader.prim.clone();
    let Some(node) = mapping.node(&prim, name)? else { return pair(mapping, &prim, name, default) };
    if node.id != "ND_chiang_hair_roughness" {
        mapping.reader.warnings.add(&prim, format!("inputs:{name}: a {} is not mapped and is ignored", node.id));
        return pair(mapping, &prim, name, default);
    }
    let along = mapping.share_of(&node.prim, "longitudinal", [0.1; 3])?;
    let around = mapping.share_of(&node.prim, "azimuthal", [0.2; 3])?;
    let factor = match node.output.rsplit('_').next() {
        Some("TT") => mapping.value_of(&node.prim, "scale_TT", [0.5; 3])?,
        Some("TRT") => mapping.value_of(&node.prim, "scale_TRT", [2.0; 3])?,
        _ => Value::number(1.0),
    };
    let product = |v: [f64; 3], k: [f64; 3]| std::array::from_fn(|i| v[i] * k[i] * k[i]);
    Ok([along.map_each(hair::variance).with(factor, product), around.map_each(hair::scale)])
}

/// The two numbers of an input of the shader, or the default.
fn pair(mapping: &Mapping, prim: &str, name: &str, default: [f64; 2]) -> Result<[Value; 2], Error> {
    let key = format!("inputs:{name}");
    let found = mapping.reader.stage.numbers(prim, &key, When::Open)?;
    let numbers = match found.as_ref().map(|found| found.values.as_slice()) {
        None => default,
        Some(&[v, s]) if v >= 0.0 && s >= 0.0 && v.is_finite() && s.is_finite() => [v, s].map(f64::from),
        Some(_) => return Err(Error::prim(prim, format!("{key} must be two finite numbers that are not negative"))),
    };
    Ok(numbers.map(Value::number))
}
