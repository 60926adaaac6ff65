//! Curves on two logarithmic axes.

use crate::plot::canvas::{Draw, LOBE_COLORS, Mark, font, legend, titled};
use anyhow::Result;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Named curves.
pub struct Curves {
    pub title: String,
    pub x: String,
    pub y: String,
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

impl Draw for Curves {
    fn size(&self) -> (u32, u32) {
        (1200, 760)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &self.title, 24.0)?;
        let marks = self.series.iter().zip(LOBE_COLORS);
        let entries: Vec<_> =
            marks.map(|((name, _), color)| (name.clone(), Mark::Line(color.stroke_width(4)))).collect();
        let area = legend(&area, &entries)?;
        let points = || self.series.iter().flat_map(|(_, points)| points).filter(|p| p.0 > 0.0 && p.1 > 0.0);
        let range = |of: fn(&(f64, f64)) -> f64| {
            let (low, high) = points().map(of).fold((f64::MAX, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
            0.8 * low.min(high)..1.25 * high.max(1e-12)
        };
        let mut chart = ChartBuilder::on(&area)
            .margin(20)
            .x_label_area_size(60)
            .y_label_area_size(90)
            .build_cartesian_2d(range(|p| p.0).log_scale(), range(|p| p.1).log_scale())?;
        let short = |x: &f64| format!("{}", (x * 1e5).round() / 1e5);
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&short)
            .y_label_formatter(&short)
            .label_style(font(18.0))
            .axis_desc_style(font(20.0))
            .light_line_style(BLACK.mix(0.06))
            .bold_line_style(BLACK.mix(0.15))
            .draw()?;
        for ((_, points), color) in self.series.iter().zip(LOBE_COLORS) {
            let seen: Vec<_> = points.iter().copied().filter(|p| p.0 > 0.0 && p.1 > 0.0).collect();
            chart.draw_series(LineSeries::new(seen.clone(), color.stroke_width(3)))?;
            chart.draw_series(seen.into_iter().map(|p| Circle::new(p, 4, color.filled())))?;
        }
        Ok(())
    }
}
