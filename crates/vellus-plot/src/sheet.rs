//! Profiles of several fibres over θ and φ, with one logarithmic scale for each fibre (Yan17 Fig. 11).

use crate::Result;
use crate::canvas::{Draw, font, titled};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Shades of the scale.
const SHADES: usize = 48;

/// Decades of the scale below the largest value of a fibre's first profile.
pub const DECADES: f64 = 3.0;

/// Fibres in a row.
const ACROSS: usize = 2;

/// Profiles over θ from −90° to 90° (rows) and φ from 0° to 180° (columns).
pub struct Sheet {
    /// The title.
    pub title: String,
    /// Names of the profiles of each fibre.
    pub columns: Vec<String>,
    /// Name and profiles of each fibre; a profile has its cells row by row.
    pub fibers: Vec<(String, Vec<Vec<f64>>)>,
    /// Numbers of cells over φ and over θ.
    pub cells: [usize; 2],
}

impl Draw for Sheet {
    fn size(&self) -> (u32, u32) {
        (1900, 90 + 230 * self.fibers.len().div_ceil(ACROSS) as u32)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &self.title, 22.0)?;
        let (width, _) = area.dim_in_pixel();
        let (area, bar) = area.split_horizontally(width - 70);
        let places = area.split_evenly((self.fibers.len().div_ceil(ACROSS), ACROSS));
        for ((name, profiles), place) in self.fibers.iter().zip(&places) {
            let largest = profiles.first().map_or(1e-30, |p| p.iter().fold(1e-30f64, |a, &x| a.max(x)));
            let panels = place.split_evenly((1, self.columns.len()));
            for (((what, profile), panel), first) in
                self.columns.iter().zip(profiles).zip(&panels).zip([true, false, false])
            {
                let title = if first { format!("{name}: {what}") } else { what.clone() };
                self.panel(panel, &title, profile, largest)?;
            }
        }
        scale(&bar)
    }
}

impl Sheet {
    fn panel<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        title: &str,
        profile: &[f64],
        largest: f64,
    ) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let [columns, rows] = self.cells;
        let mut chart = ChartBuilder::on(area)
            .margin(4)
            .caption(title, font(16.0))
            .x_label_area_size(22)
            .y_label_area_size(36)
            .build_cartesian_2d(0.0..180.0, -90.0..90.0)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(5)
            .y_labels(5)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{y:.0}"))
            .label_style(font(13.0))
            .draw()?;
        let shade = |x: f64| {
            let t = 1.0 + (x.max(1e-30) / largest).log10() / DECADES;
            (t.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize
        };
        let (wide, high) = (180.0 / columns as f64, 180.0 / rows as f64);
        for (row, values) in profile.chunks(columns).enumerate() {
            let shades: Vec<usize> = values.iter().map(|&x| shade(x)).collect();
            let low = row as f64 * high - 90.0;
            // Neighbours of the same shade become one rectangle.
            let mut start = 0;
            while start < columns {
                let run = shades[start..].iter().take_while(|&&s| s == shades[start]).count();
                let corners = [(start as f64 * wide, low), ((start + run) as f64 * wide, low + high)];
                chart.draw_series([Rectangle::new(corners, color(shades[start]).filled())])?;
                start += run;
            }
        }
        Ok(())
    }
}

fn color(shade: usize) -> RGBColor {
    ViridisRGB.get_color(shade as f64 / (SHADES - 1) as f64)
}

/// Draws the colour bar.
fn scale<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>) -> Result<()>
where
    DB::ErrorType: 'static,
{
    let (_, height) = area.dim_in_pixel();
    let (top, high) = (40, (height as i32 - 80).min(420));
    for s in 0..SHADES {
        let y = |s: usize| top + high - (s as i32 * high) / SHADES as i32;
        area.draw(&Rectangle::new([(4, y(s + 1)), (22, y(s))], color(s).filled()))?;
    }
    let style = font(14.0).pos(Pos::new(HPos::Left, VPos::Center));
    for (k, label) in ["1", "0.1", "0.01", "0.001"].into_iter().enumerate() {
        area.draw_text(label, &style, (27, top + (k as f64 * f64::from(high) / DECADES) as i32))?;
    }
    Ok(())
}
