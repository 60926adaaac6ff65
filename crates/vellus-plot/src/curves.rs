//! Curves on two axes.

use crate::Result;
use crate::canvas::{Draw, LOBE_COLORS, Mark, font, legend, titled};
use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

/// The scale of both axes.
#[derive(Clone, Copy, PartialEq)]
pub enum Axes {
    /// Linear; y starts at 0.
    Linear,
    /// Logarithmic. Values that are not positive are omitted.
    Logarithmic,
}

/// Named curves.
pub struct Curves {
    /// The title.
    pub title: String,
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// The scale of both axes.
    pub axes: Axes,
    /// Names and points.
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

impl Draw for Curves {
    fn size(&self) -> (u32, u32) {
        (1200, 740)
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
        let range = |of: fn((f64, f64)) -> f64| {
            let points = (0..self.series.len()).flat_map(|k| self.points(k));
            let (low, high) = points.map(of).fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            if low < high { low..high } else { 1e-12..1.0 }
        };
        let (x, y) = (range(|p| p.0), range(|p| p.1));
        let mut chart = ChartBuilder::on(&area);
        chart.margin(20).x_label_area_size(60).y_label_area_size(90);
        match self.axes {
            Axes::Linear => self.plot(chart.build_cartesian_2d(x, 0.0..1.08 * y.end)?),
            Axes::Logarithmic => {
                let wider = |range: std::ops::Range<f64>| (0.8 * range.start..1.25 * range.end).log_scale();
                self.plot(chart.build_cartesian_2d(wider(x), wider(y))?)
            }
        }
    }
}

impl Curves {
    /// The points of a curve that the axes can show.
    fn points(&self, k: usize) -> impl Iterator<Item = (f64, f64)> {
        let all = self.axes == Axes::Linear;
        self.series[k].1.iter().copied().filter(move |p| all || p.0 > 0.0 && p.1 > 0.0)
    }

    fn plot<DB: DrawingBackend, X, Y>(&self, mut chart: ChartContext<DB, Cartesian2d<X, Y>>) -> Result<()>
    where
        DB::ErrorType: 'static,
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let short = |x: &f64| format!("{}", (x * 1e5).round() / 1e5);
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&short)
            .y_label_formatter(&short)
            .label_style(font(18.0))
            .axis_desc_style(font(20.0))
            .light_line_style(if self.axes == Axes::Linear { TRANSPARENT } else { BLACK.mix(0.06) })
            .bold_line_style(BLACK.mix(0.15))
            .draw()?;
        for (k, color) in (0..self.series.len()).zip(LOBE_COLORS) {
            chart.draw_series(LineSeries::new(self.points(k), color.stroke_width(3)))?;
            if self.axes == Axes::Logarithmic {
                chart.draw_series(self.points(k).map(|p| Circle::new(p, 4, color.filled())))?;
            }
        }
        Ok(())
    }
}
