//! Arnold's `standard_hair`.

use crate::error::Error;
use crate::read::shading::hair;
use crate::read::shading::mapping::Mapping;
use crate::read::shading::value::Value;
use vellus::Parameter;

/// Reads `arnold:standard_hair`. Its roughness is that of Chiang et al. 2016, and its pigments are those of d'Eon et
/// al. 2011.
pub(super) fn map(mapping: &mut Mapping) -> Result<(), Error> {
    let along = mapping.share("roughness", [0.2; 3])?;
    let is_anisotropic = mapping.flag("roughness_anisotropic")?;
    let azimuthal = if is_anisotropic { "roughness_azimuthal" } else { "roughness" };
    let around = mapping.share(azimuthal, [0.2; 3])?;

    let base = mapping.share("base", [1.0; 3])?;
    let color = mapping.share("base_color", [1.0; 3])?.with(base, |c, k| c.map(|c| c * k[0]));
    let (concentration, redness) = (mapping.share("melanin", [1.0; 3])?, mapping.share("melanin_redness", [0.5; 3])?);
    let sigma = hair::absorption(color, concentration, redness, around.clone());
    mapping.set(Parameter::SigmaCa, sigma, "base_color and melanin");

    let (variance, scale) = (along.map_each(hair::variance), around.map_each(hair::scale));
    hair::set_roughness(mapping, variance, scale, ["roughness", azimuthal]);
    let ior = mapping.number("ior", 1.55)?;
    mapping.set(Parameter::Eta, ior, "ior");
    let shift = mapping.constant("shift", 3.0)?;
    mapping.set(Parameter::Alpha, Value::number(hair::alpha(shift)), "shift");
    mapping.lose_unless(1.0, &["specular_tint", "specular2_tint", "transmission_tint", "opacity"])?;
    mapping.lose_unless(0.0, &["melanin_randomize", "diffuse", "emission"])
}
