//! Groups of bars: one number for each of several series in several groups.

use crate::Result;
use crate::canvas::{Draw, LOBE_COLORS, Mark, font, legend, titled};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A chart of bars from 0.
pub struct Bars {
    /// The title.
    pub title: String,
    /// Label of the vertical axis.
    pub unit: String,
    /// Labels under the horizontal axis.
    pub groups: Vec<String>,
    /// Name and one height for each group.
    pub series: Vec<(String, Vec<f64>)>,
    /// Decimals of the numbers above the bars. `None` for bars without numbers.
    pub digits: Option<usize>,
}

impl Draw for Bars {
    fn size(&self) -> (u32, u32) {
        (1640, 760)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        // The first of several series is black, so that it stands out.
        let first = if self.series.len() == 1 { LOBE_COLORS[0] } else { BLACK };
        let colors: Vec<RGBColor> =
            [first].into_iter().chain(LOBE_COLORS).chain([RGBColor(150, 150, 150)]).take(self.series.len()).collect();
        let area = titled(area, &self.title, 26.0)?;
        let marks = self.series.iter().zip(&colors);
        let entries: Vec<_> =
            marks.map(|((name, _), color)| (name.clone(), Mark::Line(color.stroke_width(14)))).collect();
        let area = legend(&area, &entries)?;
        let highest = self.series.iter().flat_map(|(_, values)| values).fold(0.0f64, |a, &x| a.max(x));
        let count = self.groups.len() as f64;
        let mut chart = ChartBuilder::on(&area)
            .margin(20)
            .x_label_area_size(44)
            .y_label_area_size(90)
            .build_cartesian_2d(0.0..count, 0.0..1.08 * highest.max(1e-9))?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(0)
            .y_desc(&self.unit)
            .y_label_formatter(&|y| format!("{}", (y * 1e6).round() / 1e6))
            .label_style(font(18.0))
            .axis_desc_style(font(20.0))
            .bold_line_style(BLACK.mix(0.15))
            .light_line_style(TRANSPARENT)
            .draw()?;
        let (gap, width) = (0.12, 0.76 / self.series.len() as f64);
        let (left, top) = area.get_base_pixel();
        let below = font(18.0).pos(Pos::new(HPos::Center, VPos::Top));
        let above = font(15.0).pos(Pos::new(HPos::Center, VPos::Bottom));
        for (i, group) in self.groups.iter().enumerate() {
            for (k, ((_, values), color)) in self.series.iter().zip(&colors).enumerate() {
                let x = i as f64 + gap + k as f64 * width;
                chart.draw_series([Rectangle::new([(x, 0.0), (x + 0.9 * width, values[i])], color.filled())])?;
                if let Some(digits) = self.digits {
                    let (x, y) = chart.backend_coord(&(x + 0.45 * width, values[i]));
                    area.draw_text(&format!("{:.digits$}", values[i]), &above, (x - left, y - top - 3))?;
                }
            }
            let (x, y) = chart.backend_coord(&(i as f64 + 0.5, 0.0));
            area.draw_text(group, &below, (x - left, y - top + 12))?;
        }
        Ok(())
    }
}
