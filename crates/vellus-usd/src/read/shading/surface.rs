//! Surfaces of meshes: standard_surface of MaterialX and Arnold, OpenPBR, and UsdPreviewSurface in MaterialX.

use crate::error::Error;
use crate::read::shading::mapping::Mapping;
use crate::read::shading::nodes::{mix, multiply};
use crate::read::shading::value::Value;
use vellus_scene::{NormalMap, Opacity, Surface};

/// The name of an input and its default, or an empty name if the shader has no such input.
type Named = (&'static str, f64);

/// What a shader calls the inputs of a surface.
pub(crate) struct Model {
    /// The weight of the base, and its colour.
    base: [Named; 2],
    pub roughness: Named,
    pub metalness: Named,
    /// The weight of the reflection, and the refractive index.
    pub specular: [Named; 2],
    /// Two factors.
    pub emission: [Named; 2],
    /// The weight of subsurface scattering, and the colour that it has in place of the base.
    subsurface: [Named; 2],
    /// The weight of a clear layer, and the tint that it gives what is below.
    coat: [Named; 2],
    pub opacity: &'static str,
    /// Whether there is an `opacityThreshold`.
    has_threshold: bool,
    /// Inputs that are ignored, and the values at which they have no effect.
    ignored: &'static [Named],
    /// Inputs for normals, which are ignored if they are connected.
    normals: &'static [&'static str],
    /// How names of inputs begin that say more about one which is ignored, or not used.
    details: &'static [&'static str],
}

/// Defaults of MaterialX 1.39 (version 1.0.1 of the node). Those of Arnold, which has the same inputs, were not tested.
const STANDARD: Model = Model {
    base: [("base", 1.0), ("base_color", 0.8)],
    roughness: ("specular_roughness", 0.2),
    metalness: ("metalness", 0.0),
    specular: [("specular", 1.0), ("specular_IOR", 1.5)],
    emission: [("emission", 0.0), ("emission_color", 1.0)],
    subsurface: [("subsurface", 0.0), ("subsurface_color", 1.0)],
    coat: [("coat", 0.0), ("coat_color", 1.0)],
    opacity: "opacity",
    has_threshold: false,
    ignored: &[
        ("diffuse_roughness", 0.0),
        ("specular_color", 1.0),
        ("specular_anisotropy", 0.0),
        ("transmission", 0.0),
        ("sheen", 0.0),
        ("thin_film_thickness", 0.0),
        ("thin_walled", 0.0),
    ],
    normals: &["normal"],
    details: &[
        "emission_color",
        "specular_rotation",
        "tangent",
        "transmission_",
        "subsurface_",
        "sheen_",
        "coat_",
        "thin_film_",
    ],
};

/// Defaults of MaterialX 1.39 (OpenPBR 1.1).
const OPEN_PBR: Model = Model {
    base: [("base_weight", 1.0), ("base_color", 0.8)],
    roughness: ("specular_roughness", 0.3),
    metalness: ("base_metalness", 0.0),
    specular: [("specular_weight", 1.0), ("specular_ior", 1.5)],
    emission: [("emission_luminance", 0.0), ("emission_color", 1.0)],
    subsurface: [("subsurface_weight", 0.0), ("subsurface_color", 0.8)],
    coat: [("coat_weight", 0.0), ("coat_color", 1.0)],
    opacity: "geometry_opacity",
    has_threshold: false,
    ignored: &[
        ("base_diffuse_roughness", 0.0),
        ("specular_color", 1.0),
        ("specular_roughness_anisotropy", 0.0),
        ("transmission_weight", 0.0),
        ("fuzz_weight", 0.0),
        ("thin_film_weight", 0.0),
        ("geometry_thin_walled", 0.0),
    ],
    normals: &["geometry_normal"],
    details: &[
        "emission_color",
        "geometry_tangent",
        "geometry_coat_",
        "transmission_",
        "subsurface_",
        "fuzz_",
        "coat_",
        "thin_film_",
    ],
};

const PREVIEW: Model = Model {
    base: [("", 1.0), ("diffuseColor", 0.18)],
    roughness: ("roughness", 0.5),
    metalness: ("metallic", 0.0),
    specular: [("", 1.0), ("ior", 1.5)],
    emission: [("", 1.0), ("emissiveColor", 0.0)],
    subsurface: [("", 0.0); 2],
    coat: [("", 0.0), ("", 1.0)],
    opacity: "opacity",
    has_threshold: true,
    ignored: &[("clearcoat", 0.0), ("displacement", 0.0), ("useSpecularWorkflow", 0.0)],
    normals: &["normal"],
    details: &["clearcoatRoughness", "specularColor", "opacityMode", "occlusion"],
};

impl Model {
    /// What a shader calls its inputs, by its `info:id`.
    pub fn of(id: &str) -> Option<Model> {
        Some(match id {
            "ND_standard_surface_surfaceshader" | "arnold:standard_surface" | "standard_surface" => STANDARD,
            // The first version of the node.
            "ND_standard_surface_surfaceshader_100" => Model { base: [("base", 0.8), ("base_color", 1.0)], ..STANDARD },
            "ND_open_pbr_surface_surfaceshader" => OPEN_PBR,
            "UsdPreviewSurface" | "ND_UsdPreviewSurface_surfaceshader" => PREVIEW,
            _ => return None,
        })
    }
}

/// Reads a surface. Warnings name what is approximated.
pub(super) fn read(mapping: &mut Mapping, name: String, model: &Model) -> Result<Surface, Error> {
    let [base, color] = model.base.map(|input| value(mapping, input));
    let mut color = color?.with_each(base?, multiply);
    let [(subsurface, _), scattered] = model.subsurface;
    let weight = number(mapping, model.subsurface[0])?.clamp(0.0, 1.0);
    if weight > 0.0 {
        color = mix(color, value(mapping, scattered)?, Value::number(weight));
        warn(mapping, format!("inputs:{subsurface} is read as diffuse reflection of the subsurface colour"));
    }
    let [(coat, _), tint] = model.coat;
    let weight = number(mapping, model.coat[0])?.clamp(0.0, 1.0);
    if weight > 0.0 {
        let tint = value(mapping, tint)?;
        color = color.with_each(mix(Value::number(1.0), tint, Value::number(weight)), multiply);
        warn(mapping, format!("inputs:{coat} only tints what is below: a coat has no reflection of its own"));
    }
    let color = mapping.tint(color);
    let [specular, ior] = model.specular.map(|input| number(mapping, input));
    let [factor, emitted] = model.emission;
    let factor = number(mapping, factor)?;
    // A colour without effect is not asked for, so that it gives no warning.
    let emission = if factor == 0.0 { [0.0; 3] } else { mean(mapping, emitted)?.map(|x| (factor * x) as f32) };
    let opacity = value(mapping, (model.opacity, 1.0))?.map(|color| [color.iter().sum::<f64>() / 3.0; 3]);
    let fade = mapping.tint(opacity);
    let opacity = Opacity { value: fade.color[0], texture: fade.texture, threshold: threshold(mapping, model)? };
    Ok(Surface {
        name,
        color,
        emission,
        roughness: number(mapping, model.roughness)? as f32,
        metallic: number(mapping, model.metalness)? as f32,
        ior: weighted(specular?, ior?) as f32,
        opacity,
        normals: normals(mapping, model)?,
        skin: false,
    })
}

/// The normal map of a surface: a node for normal maps with an image, or a UsdPreviewSurface's own image.
fn normals(mapping: &mut Mapping, model: &Model) -> Result<Option<NormalMap>, Error> {
    let prim = mapping.shader.prim.clone();
    for name in model.normals {
        let Some(node) = mapping.node(&prim, name)?.filter(|node| !node.id.starts_with("ND_normal_")) else { continue };
        let is_map = node.id == "ND_normalmap" || node.id.starts_with("ND_normalmap_");
        if is_map && let Some((image, scale)) = mapping.normal_map(&node.prim)? {
            let texture = mapping.tint(Value::Image(image)).texture;
            let [x, y] = scale.map(|x| x as f32);
            let map = |texture| NormalMap { texture, scale: [2.0 * x, 2.0 * y, 2.0], bias: [-x, -y, -1.0] };
            return Ok(texture.map(map));
        }
        warn(mapping, format!("inputs:{name} is not supported and is ignored"));
    }
    Ok(None)
}

/// The opacity from which on a UsdPreviewSurface is opaque, and below which it is not there.
fn threshold(mapping: &mut Mapping, model: &Model) -> Result<f32, Error> {
    let name = "opacityThreshold";
    Ok(if model.has_threshold { number(mapping, (name, 0.0))? as f32 } else { 0.0 })
}

fn warn(mapping: &mut Mapping, what: String) {
    mapping.reader.warnings.add(&mapping.shader.prim, what);
}

/// The refractive index whose reflection at normal incidence is `weight` times that of another one. This is how OpenPBR
/// defines its weight. That of standard_surface differs from it at other angles, but not where it is 0 or 1.
fn weighted(weight: f64, ior: f64) -> f64 {
    if weight == 1.0 {
        return ior;
    }
    let root = (ior - 1.0) / (ior + 1.0) * weight.max(0.0).sqrt();
    if root < 1.0 { (1.0 + root) / (1.0 - root) } else { f64::INFINITY }
}

/// Gives a warning for each input that has no counterpart and an effect.
pub(super) fn ignore(mapping: &mut Mapping, model: &Model) -> Result<(), Error> {
    for (name, idle) in model.ignored.iter().copied() {
        if works(mapping, name, idle)? {
            warn(mapping, format!("inputs:{name} is not supported and is ignored"));
        }
    }
    mapping.know_all(model.details)
}

/// Whether an input is connected to a node, or has another value than the one without effect.
fn works(mapping: &mut Mapping, name: &'static str, idle: f64) -> Result<bool, Error> {
    if !mapping.has(name)? {
        return Ok(false);
    }
    let prim = mapping.shader.prim.clone();
    Ok(match mapping.node(&prim, name)? {
        Some(node) => !node.id.starts_with("ND_constant_") || value(mapping, (name, idle))? != Value::number(idle),
        // Numbers, or true.
        None => match mapping.value(name, [idle; 3]) {
            Ok(value) => value != Value::number(idle),
            Err(error) => mapping.flag(name).map_err(|_| error)?,
        },
    })
}

/// The value of an input.
fn value(mapping: &mut Mapping, (name, default): Named) -> Result<Value, Error> {
    if name.is_empty() { Ok(Value::number(default)) } else { mapping.value(name, [default; 3]) }
}

/// The value of an input that cannot have an image: the mean of the image, with a warning.
fn mean(mapping: &mut Mapping, input: Named) -> Result<[f64; 3], Error> {
    let image = match value(mapping, input)? {
        Value::Constant(value) => return Ok(value),
        Value::Image(image) => image,
    };
    warn(mapping, format!("inputs:{} has an image, which is not supported: its mean is used", input.0));
    Ok(image.pixels.mean())
}

/// As [`mean`], for a number.
fn number(mapping: &mut Mapping, input: Named) -> Result<f64, Error> {
    Ok(mean(mapping, input)?[0])
}
