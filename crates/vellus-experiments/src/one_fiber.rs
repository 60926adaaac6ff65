//! One straight fibre under a microscope.

use crate::context::Context;
use crate::shot::{Method, Shot, brightness};
use crate::{Outcome, Table};
use anyhow::Result;
use glam::{Mat3, Vec3, Vec4};
use vellus::Fiber;
use vellus_plot::curves::{Axes, Curves};
use vellus_render::Film;
use vellus_scene::{Basis, Camera, Light, LightShape, Look, Scene, Strands};

/// Radius of the fibre. The camera is so far away that all rays are parallel.
const RADIUS: f32 = 0.1;
const FAR_AWAY: f32 = 100.0;

/// The share of the picture's width that the fibre covers.
const COVERED: f32 = 0.8;

/// A vertical fibre, lit by a light of the given half angle (radians) from the direction `light` and by a dim dome.
/// The camera is on the +z axis.
pub fn scene(fiber: Fiber, [width, height]: [usize; 2], light: Vec3, half_angle: f32, dome: f32) -> Scene {
    let points = (0..4).map(|i| Vec4::new(0.0, 20.0 * (i as f32 - 1.5), 0.0, RADIUS)).collect();
    let strands = Strands {
        name: "fiber".to_owned(),
        basis: Basis::Linear,
        starts: vec![0, 4],
        points,
        moved: None,
        normals: None,
        root_uv: None,
        look: 0,
        varying: vec![],
    };
    let aspect = width as f32 / height as f32;
    let film_width = 2.0 * RADIUS / COVERED / FAR_AWAY;
    let angle = 2.0 * (0.5 * film_width / aspect).atan();
    Scene {
        strands: vec![strands],
        looks: vec![Look::constant("fiber", fiber)],
        lights: [
            LightShape::Distant { direction: light, half_angle, irradiance: [1.0; 3] },
            LightShape::Dome { radiance: [dome; 3], texture: None, rotation: Mat3::IDENTITY, ground: None },
        ]
        .map(Light::from)
        .to_vec(),
        camera: Some(Camera::look_at(Vec3::new(0.0, 0.0, FAR_AWAY), Vec3::ZERO, Vec3::Y, angle, aspect)),
        ..Scene::default()
    }
}

/// Exposure of the pictures.
pub const EXPOSURE: f32 = -0.5;

/// The rendered fibre.
pub struct Seen {
    pub film: Film,
    /// The picture's file.
    pub file: String,
    /// Brightness over h.
    pub profile: Vec<(f64, f64)>,
}

/// Renders a fibre.
pub fn render(
    context: &Context<'_>,
    name: &str,
    scene: Scene,
    size: [usize; 2],
    method: Method,
    samples: u64,
) -> Result<Seen> {
    let mut shot = Shot::new(context, name, scene, size, [0, 0, size[0], size[1]])?;
    let film = shot.render(method, 0, samples)?;
    let file = shot.save(&film, name, EXPOSURE)?;
    let profile = (0..size[0])
        .map(|x| {
            let h = (2.0 * (x as f64 + 0.5) / size[0] as f64 - 1.0) / f64::from(COVERED);
            (h, (0..size[1]).map(|y| brightness(&film, x, y)).sum::<f64>() / size[1] as f64)
        })
        .filter(|(h, _)| h.abs() < 0.98)
        .collect();
    Ok(Seen { film, file, profile })
}

/// Adds a table and a chart of the brightness over h of several methods.
pub fn show(
    context: &Context<'_>,
    outcome: &mut Outcome,
    title: &str,
    series: Vec<(String, Vec<(f64, f64)>)>,
) -> Result<()> {
    let header: Vec<&str> = std::iter::once("h").chain(series.iter().map(|(name, _)| name.as_str())).collect();
    let mut table = Table::new("across", "Brightness across the fibre", &header);
    for (i, (h, _)) in series[0].1.iter().enumerate() {
        let values = series.iter().map(|(_, profile)| format!("{:.5}", profile[i].1));
        table.row(std::iter::once(format!("{h:.3}")).chain(values));
    }
    outcome.tables.push(table);
    let (x, y) = ("offset h".to_owned(), "brightness".to_owned());
    let chart = Curves { axes: Axes::Linear, title: title.to_owned(), x, y, series };
    outcome.pictures.push(context.draw(&chart, "across", "Brightness across the fibre, averaged along it")?);
    Ok(())
}
