//! Karma's `kma_hair` and `kma_fur`.

use crate::error::Error;
use crate::read::shading::hair;
use crate::read::shading::mapping::Mapping;
use crate::read::shading::value::Value;
use vellus::Parameter;

/// Whether an `info:id` is one of Karma's shaders for fibres. Their versions differ in a suffix.
pub(super) fn is_fiber(id: &str) -> bool {
    let id = id.strip_prefix("ND_").unwrap_or(id);
    id.starts_with("kma_hair") || id.starts_with("kma_fur")
}

/// Inputs that are mapped, in lower case.
const MAPPED: [&str; 10] = [
    "basecolor",
    "melanin",
    "melaninredness",
    "thicknessscale",
    "roughness",
    "roughnessazimuthal",
    "ior",
    "shift",
    "medullaradius",
    "medullaphase",
];

/// Reads `kma_hair`, which is Chiang's model, and `kma_fur`, which is Chiang's model with a medulla.
///
/// The documentation gives labels of the inputs and no defaults. So names are compared without case and underscores,
/// and an input that the file lacks leaves the parameter as it is.
pub(super) fn map(mapping: &mut Mapping) -> Result<(), Error> {
    let names = Names::of(mapping)?;
    let along = names.value(mapping, "roughness")?;
    let around = names.value(mapping, "roughnessazimuthal")?.or_else(|| along.clone());
    let color = names.value(mapping, "basecolor")?;
    let melanin = names.value(mapping, "melanin")?;
    if color.is_some() || melanin.is_some() {
        let redness = names.value(mapping, "melaninredness")?.unwrap_or(Value::number(0.5));
        let thickness = names.value(mapping, "thicknessscale")?.unwrap_or(Value::number(1.0));
        let azimuthal = around.clone().unwrap_or(Value::number(0.2));
        let color = color.unwrap_or(Value::number(1.0));
        let sigma = hair::absorption(color, melanin.unwrap_or(Value::number(0.0)), redness, azimuthal);
        let sigma = sigma.with(thickness, |s, k| s.map(|s| s * k[0]));
        mapping.set(Parameter::SigmaCa, sigma, "baseColor, melanin and thicknessScale");
    }
    if let Some(along) = along {
        mapping.set(Parameter::BetaM, hair::limited_beta_m(along.map_each(hair::variance)), "roughness");
    }
    if let Some(around) = around {
        mapping.set(Parameter::BetaN, hair::limited_beta_n(around.map_each(hair::scale)), "roughnessAzimuthal");
    }
    if let Some(ior) = names.value(mapping, "ior")? {
        mapping.set(Parameter::Eta, ior, "ior");
    }
    if let Some(Value::Constant([shift, ..])) = names.value(mapping, "shift")? {
        // −1 to 1 means −90° to 90°.
        mapping.set(Parameter::Alpha, Value::number(hair::alpha(90.0 * shift)), "shift");
    }
    if let Some(radius) = names.value(mapping, "medullaradius")? {
        mapping.set(Parameter::Kappa, radius, "medullaRadius");
    }
    if let Some(phase) = names.value(mapping, "medullaphase")? {
        mapping.set(Parameter::G, phase, "medullaPhase");
    }
    names.others().for_each(|name| mapping.lose(name));
    Ok(())
}

/// The inputs of the shader by their names in lower case without underscores.
struct Names(Vec<(String, String)>);

impl Names {
    fn of(mapping: &Mapping) -> Result<Self, Error> {
        let properties = mapping.reader.stage.properties(&mapping.shader.prim)?;
        let inputs = properties.iter().filter_map(|name| name.strip_prefix("inputs:"));
        Ok(Names(inputs.map(|name| (name.to_lowercase().replace('_', ""), name.to_owned())).collect()))
    }

    /// The value of an input that the file has.
    fn value(&self, mapping: &mut Mapping, key: &str) -> Result<Option<Value>, Error> {
        let Some((_, name)) = self.0.iter().find(|(known, _)| known == key) else { return Ok(None) };
        match key {
            _ if !mapping.has(name)? => Ok(None),
            "thicknessscale" | "ior" | "shift" => mapping.number(name, 0.0).map(Some),
            _ => mapping.share(name, [0.0; 3]).map(Some),
        }
    }

    /// Inputs that are not mapped.
    fn others(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter(|(key, _)| !MAPPED.contains(&key.as_str())).map(|(_, name)| name.as_str())
    }
}
