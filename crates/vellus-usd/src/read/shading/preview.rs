//! UsdPreviewSurface, which is no shader for fibres.

use crate::error::Error;
use crate::read::shading::mapping::Mapping;
use vellus::Parameter;

/// Inputs that say something about a surface and nothing about a fibre.
const SURFACE: [&str; 8] =
    ["emissiveColor", "metallic", "roughness", "opacity", "clearcoat", "normal", "displacement", "ior"];

/// Reads the diffuse colour of UsdPreviewSurface as the reflectance of the coat. Without that input nothing is mapped.
pub(super) fn map(mapping: &mut Mapping) -> Result<(), Error> {
    if mapping.has("diffuseColor")? && !mapping.set_primvar(Parameter::Reflectance, "diffuseColor")? {
        let color = mapping.value("diffuseColor", [0.18; 3])?;
        mapping.set(Parameter::Reflectance, color, "diffuseColor");
    }
    for name in SURFACE {
        if mapping.has(name)? {
            mapping.lose(name);
        }
    }
    Ok(())
}
