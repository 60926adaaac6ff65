//! The identity of scenes.

use crate::{Format, Options, Recolor};
use std::path::Path;
use vellus::Fiber;
use vellus_groom::Interpolation;
use vellus_io::DigestBuilder;
use vellus_scene::ReflectanceOf;

/// Adds everything that identifies a scene to a digest, except for the bytes of its files: see
/// [`Opened::sources`](crate::Opened::sources).
///
/// Two scenes with the same digest and the same sources are equal. The digest does not depend on where files
/// are stored.
pub fn identify(builder: DigestBuilder, scene: impl AsRef<Path>, options: &Options) -> DigestBuilder {
    let scene = scene.as_ref();
    // The name identifies a built-in scene. The content of its files identifies any other scene.
    let built_in = match Format::of(scene) {
        Ok(Format::BuiltIn(name)) => Some(name),
        _ => None,
    };
    let builder = builder
        .field("scene", built_in.unwrap_or(""))
        .field("small", [u8::from(options.small)])
        .field("width", optional(options.width.map(f32::to_le_bytes)))
        .field("strands", optional(options.strands.map(f32::to_le_bytes)))
        .field("camera", options.camera.as_deref().unwrap_or(""))
        .field("frame", optional(options.frame.map(f64::to_le_bytes)));
    let builder = match &options.staging {
        Some(staging) => staging.identify(builder, built_in.is_some()),
        None => builder,
    };
    // Both print all of their fields.
    let builder = match options.markings() {
        markings if markings.is_empty() => builder,
        markings => builder.field("markings", format!("{markings:?}")),
    };
    let builder = match options.wet == 0.0 {
        true => builder,
        false => builder.field("wet", options.wet.to_le_bytes()),
    };
    let builder = match options.interpolation == Interpolation::default() {
        true => builder,
        false => builder.field("interpolation", format!("{:?}", options.interpolation)),
    };
    let builder = match options.shutter {
        Some(times) => builder.field("shutter", times.map(f64::to_le_bytes).concat()),
        None => builder,
    };
    let builder = match options.earlier {
        0 => builder,
        earlier => builder.field("earlier", (earlier as u64).to_le_bytes()),
    };
    let builder = match options.reflectance_of {
        ReflectanceOf::Groom => builder,
        ReflectanceOf::Dense => builder.field("reflectance of", "dense"),
    };
    let builder = match &options.recolor {
        Some(Recolor { fiber: Some((_, fiber)), .. }) => add_fiber(builder.field("recolor", "fiber"), fiber),
        Some(Recolor { fiber: None, set }) => builder.field("recolor", set.join("\n")),
        None => builder,
    };
    // A built-in scene has its own fibres.
    if built_in.is_some() { builder } else { add_fiber(builder, &options.fiber().1) }
}

/// The bytes of a value, or no bytes if it is not set.
fn optional<const N: usize>(bytes: Option<[u8; N]>) -> Vec<u8> {
    bytes.map_or_else(Vec::new, |bytes| bytes.to_vec())
}

/// Adds all parameters of a fibre to a digest.
fn add_fiber(builder: DigestBuilder, fiber: &Fiber) -> DigestBuilder {
    // There is no `..` here, so a parameter that is added later must be added here.
    let Fiber {
        eta,
        kappa,
        alpha,
        beta_m,
        beta_n,
        sigma_ca,
        sigma_ms,
        sigma_ma,
        g,
        layers,
        wet,
        aspect_ratio,
        medulla_air,
        exit,
        medulla_pigment,
        reflectance,
    } = *fiber;
    let [scalars, colors] = [
        &[eta, kappa, alpha, beta_m, beta_n, sigma_ms, g, layers, medulla_pigment][..],
        &[sigma_ca, sigma_ma].concat(),
    ]
    .map(|numbers| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
    let builder = builder.field("fiber", scalars).field("fiber absorption", colors).field("exit", exit.name());
    let builder = if wet == 0.0 { builder } else { builder.field("water", wet.to_le_bytes()) };
    let builder = if aspect_ratio == 1.0 { builder } else { builder.field("aspect ratio", aspect_ratio.to_le_bytes()) };
    let builder = if medulla_air == 0.0 { builder } else { builder.field("medulla air", medulla_air.to_le_bytes()) };
    match reflectance {
        Some(color) => builder.field("reflectance", color.map(f32::to_le_bytes).concat()),
        None => builder,
    }
}
