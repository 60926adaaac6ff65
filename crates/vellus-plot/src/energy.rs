//! Energy of each lobe over the fibre's width, and over inclination.

use crate::Named;
use crate::Result;
use crate::canvas::{Draw, LOBE_COLORS, LOBE_LABELS, font, titled};
use plotters::coord::Shift;
use plotters::prelude::*;
use vellus::{Model, Scattering, Window};
use vellus_models::direction;
use vellus_models::energies;

/// Mean of the channels of each lobe.
type Energies = [f64; 6];

/// Energies of one fibre.
pub struct Picture {
    title: String,
    theta_o: f64,
    /// Over h from −1 to 1.
    over_h: Vec<(f64, Energies)>,
    /// Averaged over h, over θ_o from 0° to 89°.
    over_theta: Vec<(f64, Energies)>,
}

impl Picture {
    /// Computes the energies of a model: over the offset for ω_o at `theta_o` degrees, and averaged over the width
    /// for all inclinations.
    pub fn new(named: &Named, theta_o: f64) -> Self {
        let model = &named.model;
        let over_h = (-200..=200)
            .map(|k| {
                let h = f64::from(k) / 200.0;
                let energy = model.at(direction(theta_o, 0.0), Window::near(h as f32)).energy();
                (h, energy.0.map(|a| a.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0))
            })
            .collect();
        let over_theta = (0..=89)
            .map(|theta| {
                let energy = energies(model, f64::from(theta), None);
                (f64::from(theta), energy.map(|a| a.iter().sum::<f64>() / 3.0))
            })
            .collect();
        Picture { title: format!("{}: energy of the lobes", named.title()), theta_o, over_h, over_theta }
    }
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        (1640, 780)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &self.title, 28.0)?;
        let (left, right) = area.split_horizontally(820);
        let at = format!("offset h, at θ_o = {}°", self.theta_o);
        stack(&left, &self.over_h, -1.0..1.0, &at, true)?;
        stack(&right, &self.over_theta, 0.0..89.0, "θ_o, degrees; averaged over the width", false)
    }
}

/// Draws the lobes stacked on each other. The gap up to 1 is absorbed.
fn stack<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    points: &[(f64, Energies)],
    range: std::ops::Range<f64>,
    label: &str,
    legend: bool,
) -> Result<()>
where
    DB::ErrorType: 'static,
{
    let mut chart = ChartBuilder::on(area)
        .margin(15)
        .x_label_area_size(55)
        .y_label_area_size(70)
        .build_cartesian_2d(range, 0.0..1.0)?;
    let below = |e: &Energies, p: usize| e[..p].iter().sum::<f64>();
    for p in 0..6 {
        let color = LOBE_COLORS[p];
        let upper = points.iter().map(|(x, e)| (*x, below(e, p + 1)));
        let lower = points.iter().rev().map(|(x, e)| (*x, below(e, p)));
        let series = chart.draw_series([Polygon::new(upper.chain(lower).collect::<Vec<_>>(), color.mix(0.85))])?;
        if legend {
            series
                .label(LOBE_LABELS[p])
                .legend(move |(x, y)| Rectangle::new([(x, y - 7), (x + 22, y + 7)], color.mix(0.85).filled()));
        }
    }
    chart
        .configure_mesh()
        .x_desc(label)
        .y_desc("fraction of the light (blank: absorbed)")
        .label_style(font(18.0))
        .axis_desc_style(font(20.0))
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .draw()?;
    if legend {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperMiddle)
            .background_style(WHITE.mix(0.9))
            .border_style(RGBColor(180, 180, 180))
            .legend_area_size(34)
            .label_font(font(18.0))
            .draw()?;
    }
    Ok(())
}
