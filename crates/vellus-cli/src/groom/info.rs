//! `vellus groom info`: what is in a groom.

use crate::output;
use vellus_groom::{bytes, measure};
use vellus_scene::{Scene, Strands, Units};

/// Everything there is to say about the strands of a scene.
pub fn info(scene: &Scene) -> String {
    let mut text = format!("units     {}\n", scene.units.map_or("not said".to_owned(), units));
    for strands in &scene.strands {
        text += &one(strands);
    }
    if scene.strands.len() != 1 {
        let sum = |of: fn(&Strands) -> usize| scene.strands.iter().map(of).sum::<usize>();
        let megabytes = sum(bytes) as f64 * 1e-6;
        let (strands, segments) = (sum(Strands::len), sum(Strands::segments));
        text += &format!("in all    {strands} strands, {segments} segments, {megabytes:.1} MB\n");
    }
    text
}

fn units(units: Units) -> String {
    let known =
        [(1.0, "metres"), (0.1, "decimetres"), (0.01, "centimetres"), (0.001, "millimetres"), (0.0254, "inches")];
    let known = known.into_iter().find(|(meters, _)| (units.meters_per_unit / meters - 1.0).abs() < 1e-6);
    let name = known.map_or(format!("{} metres", units.meters_per_unit), |(_, name)| name.to_owned());
    format!("{name}, {} up", if units.z_up { "z" } else { "y" })
}

fn one(strands: &Strands) -> String {
    let number = |x: f32| output::number(x.into());
    let corner = |v: glam::Vec3| v.to_array().map(number).join(", ");
    let mut rows = vec![
        ("strands", strands.len().to_string()),
        ("segments", strands.segments().to_string()),
        ("points", strands.points.len().to_string()),
        ("curve", format!("{:?}", strands.basis)),
    ];
    if let Some(measures) = measure(strands) {
        let (low, high) = measures.bounds;
        let [thinnest, thickest] = measures.widths.map(number);
        let [shortest, median, longest] = measures.lengths.map(number);
        rows.push(("bounds", format!("({}) to ({})", corner(low), corner(high))));
        rows.push(("widths", format!("{thinnest} to {thickest}")));
        rows.push(("lengths", format!("{shortest} to {longest}, median {median}")));
    }
    let mut has = Vec::new();
    has.extend(strands.root_uv.as_ref().map(|_| "uv of the roots"));
    has.extend(strands.moved.as_ref().map(|_| "motion"));
    has.extend(strands.varying.iter().map(|(parameter, _)| parameter.key()));
    if !has.is_empty() {
        rows.push(("has", has.join(", ")));
    }
    rows.push(("memory", format!("{:.1} MB", bytes(strands) as f64 * 1e-6)));
    let rows: String = rows.iter().map(|(name, value)| format!("  {name:10}{value}\n")).collect();
    format!("{}\n{rows}", strands.name)
}
