//! A description of the strands of a scene, for people.

use crate::{HairHeader, bytes, measure};
use vellus_scene::{Scene, Strands, Units};

/// Describes the strands of a scene: units, counts, bounds, widths, lengths and memory, one line each. `header` is that
/// of the .hair file that the scene was read from.
pub fn describe(scene: &Scene, header: Option<&HairHeader>) -> String {
    let mut text = format!("units     {}\n", scene.units.map_or("unknown".to_owned(), units));
    for strands in &scene.strands {
        text += &one(strands, header);
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

/// A width for strands without widths, with one digit.
///
/// The strands cover about as much as a coat: the sum of their lengths times the width is 0.7 times half the surface of
/// their bounds. The width is at least that of a human hair (80 µm) if the strands have the size of a head with hair
/// (0.24 m), and at most six times as much: a few guide strands cannot cover a body.
pub fn suggested_width(strands: &Strands) -> f32 {
    let Some(measures) = measure(strands) else { return 1.0 };
    let size = (measures.bounds.1 - measures.bounds.0).as_dvec3();
    let mut total = 0.0;
    for i in 0..strands.len() {
        let points = strands.strand(i);
        total += points.windows(2).map(|p| p[0].truncate().distance(p[1].truncate())).map(f64::from).sum::<f64>();
    }
    let cover = 0.7 * (size.x * size.y + size.y * size.z + size.z * size.x) / total.max(f64::MIN_POSITIVE);
    let hair = size.max_element() / 3000.0;
    let width = cover.clamp(hair, 6.0 * hair);
    if width > 0.0 { format!("{width:.0e}").parse().unwrap_or(1.0) } else { 1.0 }
}

/// A number with six significant digits.
fn number(x: f32) -> String {
    let x = f64::from(x);
    if x == 0.0 {
        return "0".to_owned();
    }
    match x.abs() {
        1e-4..1e5 => format!("{x:.*}", (5 - x.abs().log10().floor() as i32).clamp(0, 9) as usize),
        _ => format!("{x:.4e}"),
    }
}

/// One set of strands.
fn one(strands: &Strands, header: Option<&HairHeader>) -> String {
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
        rows.push((
            "widths",
            match measures.widths {
                [_, 0.0] => format!("none: give one with --width, {} for example", suggested_width(strands)),
                _ if header.is_some_and(|header| header.thickness.is_some()) => {
                    format!("{thinnest} to {thickest} (default of the file)")
                }
                _ => format!("{thinnest} to {thickest}"),
            },
        ));
        rows.push(("lengths", format!("{shortest} to {longest}, median {median}")));
    }
    let mut has = Vec::new();
    has.extend(strands.root_uv.as_ref().map(|_| "uv of the roots"));
    has.extend(strands.moved.as_ref().map(|_| "motion"));
    has.extend(strands.varying.iter().map(|(parameter, _)| parameter.name()));
    if !has.is_empty() {
        rows.push(("has", has.join(", ")));
    }
    if let Some(HairHeader { transparency, color, .. }) = header {
        let transparency = transparency.map_or("of points".to_owned(), |x| x.to_string());
        let color = color.map_or(String::new(), |[r, g, b]| format!(", default colour {r} {g} {b}"));
        rows.push(("not used", format!("transparency {transparency}{color}")));
    }
    rows.push(("memory", format!("{:.1} MB", bytes(strands) as f64 * 1e-6)));
    let rows: String = rows.iter().map(|(name, value)| format!("  {name:10}{value}\n")).collect();
    format!("{}\n{rows}", strands.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;
    use vellus_scene::Basis;

    #[test]
    fn strands_without_widths_are_measured_and_a_width_is_suggested() {
        let strands = Strands {
            name: "guides".to_owned(),
            basis: Basis::Linear,
            starts: vec![0, 2],
            points: vec![Vec4::new(0.0, 0.0, 0.0, 0.0), Vec4::new(0.0, 0.24, 0.1, 0.0)],
            moved: None,
            normals: None,
            root_uv: None,
            look: 0,
            varying: Vec::new(),
        };
        let text = describe(&Scene { strands: vec![strands.clone()], ..Scene::default() }, None);
        assert!(text.contains("(0, 0, 0) to (0, 0.240000, 0.100000)"), "{text}");
        // One strand is a guide.
        assert!(text.contains("none: give one with --width, 0.0005 for example"), "{text}");
        // 100,000 straight strands of 0.24 around a head of this size.
        let ring = |i: usize| {
            let (sin, cos) = (i as f32).sin_cos();
            [0.0, 0.24].map(|y| Vec4::new(0.1 * sin, y, 0.1 * cos, 0.0))
        };
        let dense = Strands {
            starts: (0..=100_000).map(|i| 2 * i).collect(),
            points: (0..100_000).flat_map(ring).collect(),
            ..strands.clone()
        };
        assert_eq!(suggested_width(&dense), 8e-5);
        let none = Strands { starts: vec![0], points: Vec::new(), ..strands.clone() };
        assert_eq!(suggested_width(&none), 1.0);
        let huge = strands.points.iter().map(|p| *p * 4e9).collect();
        assert_eq!(suggested_width(&Strands { points: huge, ..strands }), 2e6);
    }
}
