//! Reflectance of a fibre over θ_i and φ, averaged over its width (Yan17 Fig. 11).

use crate::Named;
use crate::Result;
use crate::canvas::{Draw, font, log_labels, titled};
use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use vellus_models::Directions;

/// Cells over φ and over θ_i.
const CELLS: (usize, usize) = (180, 90);

/// Shades of the logarithmic scale, and the most decades it spans.
const SHADES: usize = 90;
const DECADES: f64 = 4.0;

/// A range of directions, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// First and last θ_i, in [−90, 90].
    pub theta: [f64; 2],
    /// First and last φ.
    pub phi: [f64; 2],
}

impl Area {
    /// All directions.
    pub const SPHERE: Area = Area { theta: [-90.0, 90.0], phi: [0.0, 360.0] };
    /// The directions that the gantry of Yan et al. 2015 measured, as in Yan17 Fig. 11. Its light has θ_o = −30°.
    pub const MEASURED: Area = Area { theta: [10.0, 50.0], phi: [-20.0, 200.0] };

    /// θ_i of row `i` and φ of column `j`, at the middle of the cell if both end in one half.
    fn at(self, i: f64, j: f64) -> [f64; 2] {
        let within = |[low, high]: [f64; 2], t: f64| low + (high - low) * t;
        [within(self.theta, i / CELLS.1 as f64), within(self.phi, j / CELLS.0 as f64)]
    }
}

/// The profile of one fibre.
pub struct Panel {
    name: String,
    area: Area,
    /// f cos θ_i averaged over the width and the channels, row by row from the first θ_i.
    values: Vec<f64>,
}

impl Panel {
    /// Computes the profile of a model, for ω_o at `theta_o` degrees.
    pub fn new(model: &Named, theta_o: f64, area: Area) -> Self {
        let (columns, rows) = CELLS;
        let at = |i: usize| area.at((i / columns) as f64 + 0.5, (i % columns) as f64 + 0.5);
        let angles: Vec<_> = (0..columns * rows).map(at).collect();
        let mut values = vec![[0.0; 3]; angles.len()];
        model.model.far_field(theta_o, &Directions::new(&angles), &mut values);
        let values = values.iter().map(|f| f.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0).collect();
        Panel { name: model.title(), area, values }
    }
}

/// One panel or several, with one scale.
pub struct Picture {
    /// At least one.
    pub panels: Vec<Panel>,
    /// The inclination of ω_o, degrees.
    pub theta_o: f64,
}

/// A logarithmic scale of colours.
#[derive(Clone, Copy)]
struct Scale {
    smallest: f64,
    largest: f64,
}

impl Scale {
    fn new<'a>(values: impl Iterator<Item = &'a f64> + Clone) -> Self {
        let largest = values.clone().fold(1e-30f64, |a, &x| a.max(x));
        let least = values.fold(largest, |a, &x| a.min(x));
        // A profile without contrast gets one decade.
        Scale { smallest: least.clamp(largest * 10f64.powf(-DECADES), 0.1 * largest), largest }
    }

    fn decades(self) -> f64 {
        (self.largest / self.smallest).log10()
    }

    fn shade(self, x: f64) -> usize {
        let t = 1.0 + (x.max(1e-30) / self.largest).log10() / self.decades();
        (t.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize
    }

    fn color(shade: usize) -> RGBColor {
        ViridisRGB.get_color(shade as f64 / (SHADES - 1) as f64)
    }

    /// The bar that explains the colours.
    fn draw<DB: DrawingBackend>(self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let Scale { smallest, largest } = self;
        let mut chart = ChartBuilder::on(area).margin(12).margin_top(40).y_label_area_size(90).build_cartesian_2d(
            0.0..1.0,
            (smallest..largest).log_scale().with_key_points(log_labels(smallest, largest)),
        )?;
        chart
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .y_desc("f·cos θ_i, per steradian")
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .label_style(font(16.0))
            .axis_desc_style(font(18.0))
            .draw()?;
        let value = |i: usize| smallest * 10f64.powf(self.decades() * i as f64 / SHADES as f64);
        let step = |i: usize| Rectangle::new([(0.0, value(i)), (1.0, value(i + 1))], Scale::color(i).filled());
        chart.draw_series((0..SHADES).map(step))?;
        Ok(())
    }
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        if self.panels.len() == 1 { (1180, 720) } else { (2000, 1760) }
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let title = format!("f·cos θ_i averaged over the fibre's width, light from θ_o = {}°", self.theta_o);
        let area = titled(area, &title, if self.panels.len() == 1 { 20.0 } else { 28.0 })?;
        let scale = Scale::new(self.panels.iter().flat_map(|panel| &panel.values));
        let width = area.dim_in_pixel().0;
        let (area, bar) = area.split_horizontally(width - 170);
        // The bar beside many panels is as high as two rows of them.
        scale.draw(&if self.panels.len() == 1 { bar } else { bar.split_evenly((2, 1)).swap_remove(0) })?;
        let columns = if self.panels.len() == 1 { 1 } else { 3 };
        let places = area.split_evenly((self.panels.len().div_ceil(columns), columns));
        for (panel, place) in self.panels.iter().zip(&places) {
            draw_panel(panel, scale, place)?;
        }
        Ok(())
    }
}

fn draw_panel<DB: DrawingBackend>(panel: &Panel, scale: Scale, area: &DrawingArea<DB, Shift>) -> Result<()>
where
    DB::ErrorType: 'static,
{
    let (columns, rows) = CELLS;
    let Area { theta, phi } = panel.area;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(&panel.name, font(24.0))
        .x_label_area_size(48)
        .y_label_area_size(66)
        .build_cartesian_2d(phi[0]..phi[1], theta[0]..theta[1])?;
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
    for row in 0..rows {
        let shades: Vec<usize> = (0..columns).map(|c| scale.shade(panel.values[row * columns + c])).collect();
        // Neighbours with the same shade become one rectangle. This makes the file ten times smaller.
        let mut start = 0;
        while start < columns {
            let run = shades[start..].iter().take_while(|&&s| s == shades[start]).count();
            let corner = |row: usize, column: usize| {
                let [theta, phi] = panel.area.at(row as f64, column as f64);
                (phi, theta)
            };
            let corners = [corner(row, start), corner(row + 1, start + run)];
            chart.draw_series([Rectangle::new(corners, Scale::color(shades[start]).filled())])?;
            start += run;
        }
    }
    Ok(())
}
