//! Several reflectance models of one fibre: light over its whole width, around the fibre and along it.

use crate::canvas::{Draw, LOBE_COLORS, Mark, font, legend, titled};
use crate::{Named, Result};
use plotters::coord::Shift;
use plotters::prelude::*;
use vellus_models::Directions;

/// Cells over φ and over θ_i: half a degree each.
const PHIS: usize = 720;
const THETAS: usize = 360;
/// Decades shown at most below the largest value.
const DECADES: f64 = 4.0;

/// Light of one model, mean of the channels.
struct Curve {
    name: String,
    /// Per radian of φ, from φ = 0.
    around: Vec<f64>,
    /// Per unit of sin θ_i, from −90°.
    along: Vec<f64>,
    energy: f64,
}

/// The curves of several models of one fibre.
pub struct Picture {
    title: String,
    curves: Vec<Curve>,
}

impl Picture {
    /// Computes the curves of models of the fibre called `name`, for ω_o at `theta_o` degrees.
    pub fn new(name: &str, models: &[Named], theta_o: f64) -> Self {
        let curves = models.iter().map(|model| Curve::new(model, theta_o)).collect();
        Picture { title: format!("{name}: models over the fibre's whole width, light from θ_o = {theta_o}°"), curves }
    }
}

impl Curve {
    fn new(model: &Named, theta_o: f64) -> Self {
        let theta = |i: usize| ((i as f64 + 0.5) / THETAS as f64 - 0.5) * 180.0;
        let phi = |j: usize| 360.0 * j as f64 / PHIS as f64;
        let angles: Vec<_> = (0..THETAS * PHIS).map(|k| [theta(k / PHIS), phi(k % PHIS)]).collect();
        let mut values = vec![[0.0; 3]; angles.len()];
        model.model.far_field(theta_o, &Directions::new(&angles), &mut values);
        let mean = |f: &[f32; 3]| f.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0;
        let rows: Vec<Vec<f64>> = values.chunks(PHIS).map(|row| row.iter().map(mean).collect()).collect();
        let step = std::f64::consts::PI / THETAS as f64;
        let sin_step = |i: usize| (((i as f64 + 0.5) / THETAS as f64 - 0.5) * std::f64::consts::PI).cos() * step;
        let around: Vec<f64> = (0..PHIS).map(|j| (0..THETAS).map(|i| rows[i][j] * sin_step(i)).sum()).collect();
        let turn = std::f64::consts::TAU / PHIS as f64;
        let energy = around.iter().sum::<f64>() * turn;
        let along = rows.iter().map(|row| row.iter().sum::<f64>() * turn).collect();
        Curve { name: model.model_name().to_owned(), around, along, energy }
    }
}

/// Draws curves over an angle, with a logarithmic scale.
fn panel<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    curves: &[(Vec<(f64, f64)>, ShapeStyle)],
    range: std::ops::Range<f64>,
    labels: [&str; 2],
) -> Result<()>
where
    DB::ErrorType: 'static,
{
    let largest = curves.iter().flat_map(|(points, _)| points).fold(1e-30f64, |a, p| a.max(p.1));
    let least = curves.iter().flat_map(|(points, _)| points).fold(f64::MAX, |a, p| a.min(p.1));
    let floor = (0.7 * least).max(largest * 10f64.powf(-DECADES));
    let mut chart = ChartBuilder::on(area)
        .margin(15)
        .x_label_area_size(55)
        .y_label_area_size(85)
        .build_cartesian_2d(range, (floor..2.0 * largest).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(labels[0])
        .y_desc(labels[1])
        .x_labels(13)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .label_style(font(18.0))
        .axis_desc_style(font(20.0))
        .light_line_style(WHITE)
        .draw()?;
    for (points, style) in curves {
        // Points below the panel are omitted.
        for run in points.split(|(_, y)| *y < floor) {
            chart.draw_series(LineSeries::new(run.to_vec(), *style))?;
        }
    }
    Ok(())
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        (1840, 860)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &self.title, 28.0)?;
        let colors = LOBE_COLORS.into_iter().chain([BLACK]).cycle();
        // Earlier curves are wider, so that they are visible behind later ones.
        let styles: Vec<ShapeStyle> = colors
            .take(self.curves.len())
            .enumerate()
            .map(|(i, color)| color.stroke_width((2 * (self.curves.len() - i) as u32).clamp(2, 8)))
            .collect();
        let entries: Vec<_> = self
            .curves
            .iter()
            .zip(&styles)
            .map(|(curve, style)| (format!("{}  {:.3}", curve.name, curve.energy), Mark::Line(*style)))
            .collect();
        let area = legend(&area, &entries)?;
        let (left, right) = area.split_horizontally(920);
        let around = |curve: &Curve| {
            (0..=PHIS).map(|j| (360.0 * j as f64 / PHIS as f64, curve.around[j % PHIS])).collect::<Vec<_>>()
        };
        let along = |curve: &Curve| {
            let theta = |i: usize| ((i as f64 + 0.5) / THETAS as f64 - 0.5) * 180.0;
            curve.along.iter().enumerate().map(|(i, &y)| (theta(i), y)).collect::<Vec<_>>()
        };
        let with = |f: &dyn Fn(&Curve) -> Vec<(f64, f64)>| {
            self.curves.iter().zip(&styles).map(|(curve, style)| (f(curve), *style)).collect::<Vec<_>>()
        };
        panel(&left, &with(&around), 0.0..360.0, ["φ, degrees", "light around the fibre, per radian"])?;
        panel(&right, &with(&along), -90.0..90.0, ["θ_i, degrees", "light along the fibre, per sin θ_i"])
    }
}
