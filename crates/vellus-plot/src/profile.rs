//! Reflectance of a fibre over θ_i and φ, averaged over its width (Yan17 Fig. 11).

use crate::Named;
use crate::Result;
use crate::canvas::{Draw, font, titled};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use vellus_models::Directions;

/// Cells over φ (2°) and θ_i (2°).
const CELLS: (usize, usize) = (180, 90);

/// Shades of the logarithmic scale, and the decades it spans.
const SHADES: usize = 60;
const DECADES: f64 = 4.0;

/// The profile of one fibre.
pub struct Panel {
    name: String,
    /// f cos θ_i averaged over the width and the channels, row by row from θ_i = −90°.
    values: Vec<f64>,
}

impl Panel {
    /// Computes the profile of a model, for ω_o at `theta_o` degrees.
    pub fn new(model: &Named, theta_o: f64) -> Self {
        let (columns, rows) = CELLS;
        let theta = |i: usize| (i as f64 + 0.5) / rows as f64 * 180.0 - 90.0;
        let phi = |i: usize| (i as f64 + 0.5) / columns as f64 * 360.0;
        let angles: Vec<_> = (0..columns * rows).map(|i| [theta(i / columns), phi(i % columns)]).collect();
        let mut values = vec![[0.0; 3]; angles.len()];
        model.model.far_field(theta_o, &Directions::new(&angles), &mut values);
        let values = values.iter().map(|f| f.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0).collect();
        Panel { name: model.title(), values }
    }
}

/// One panel or several. Each has its own scale.
pub struct Picture {
    /// At least one.
    pub panels: Vec<Panel>,
    /// The inclination of ω_o, degrees.
    pub theta_o: f64,
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        if self.panels.len() == 1 { (1100, 720) } else { (2000, 1760) }
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let title = format!(
            "f·cos θ_i averaged over the fibre's width, light from θ_o = {}°; log scale over {DECADES} decades below \
             each maximum",
            self.theta_o
        );
        let area = titled(area, &title, if self.panels.len() == 1 { 20.0 } else { 28.0 })?;
        let columns = if self.panels.len() == 1 { 1 } else { 3 };
        let places = area.split_evenly((self.panels.len().div_ceil(columns), columns));
        for (panel, place) in self.panels.iter().zip(&places) {
            draw_panel(panel, place)?;
        }
        Ok(())
    }
}

fn draw_panel<DB: DrawingBackend>(panel: &Panel, area: &DrawingArea<DB, Shift>) -> Result<()>
where
    DB::ErrorType: 'static,
{
    let (columns, rows) = CELLS;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(&panel.name, font(24.0))
        .x_label_area_size(48)
        .y_label_area_size(66)
        .build_cartesian_2d(0.0..360.0, -90.0..90.0)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("φ, degrees")
        .y_desc("θ_i, degrees")
        .x_labels(9)
        .y_labels(7)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .label_style(font(16.0))
        .axis_desc_style(font(18.0))
        .draw()?;
    let largest = panel.values.iter().fold(1e-30f64, |a, &x| a.max(x));
    let shade = |x: f64| {
        let t = 1.0 + (x.max(1e-30) / largest).log10() / DECADES;
        (t.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize
    };
    for row in 0..rows {
        let shades: Vec<usize> = (0..columns).map(|c| shade(panel.values[row * columns + c])).collect();
        let (y0, y1) = (row as f64 / rows as f64 * 180.0 - 90.0, (row + 1) as f64 / rows as f64 * 180.0 - 90.0);
        // Neighbours with the same shade become one rectangle. This makes the file ten times smaller.
        let mut start = 0;
        while start < columns {
            let run = shades[start..].iter().take_while(|&&s| s == shades[start]).count();
            let color = ViridisRGB.get_color(shades[start] as f64 / (SHADES - 1) as f64);
            let x = |c: usize| c as f64 / columns as f64 * 360.0;
            chart.draw_series([Rectangle::new([(x(start), y0), (x(start + run), y1)], color.filled())])?;
            start += run;
        }
    }
    Ok(())
}
