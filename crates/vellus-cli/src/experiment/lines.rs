//! Curves on two linear axes, from 0.

use crate::plot::canvas::{Draw, LOBE_COLORS, Mark, font, legend, titled};
use anyhow::Result;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Named curves.
pub struct Lines {
    pub title: String,
    pub x: String,
    pub y: String,
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

impl Draw for Lines {
    fn size(&self) -> (u32, u32) {
        (1200, 700)
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
        let points = || self.series.iter().flat_map(|(_, points)| points);
        let (low, high) = points().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.0), b.max(p.0)));
        let highest = points().fold(1e-12f64, |a, p| a.max(p.1));
        let mut chart = ChartBuilder::on(&area)
            .margin(20)
            .x_label_area_size(60)
            .y_label_area_size(90)
            .build_cartesian_2d(low..high, 0.0..1.08 * highest)?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .label_style(font(18.0))
            .axis_desc_style(font(20.0))
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.15))
            .draw()?;
        for ((_, points), color) in self.series.iter().zip(LOBE_COLORS) {
            chart.draw_series(LineSeries::new(points.iter().copied(), color.stroke_width(3)))?;
        }
        Ok(())
    }
}
