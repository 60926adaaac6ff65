//! The azimuthal lobes of one hit: the light of each lobe over the azimuth around the fibre.

use crate::Named;
use crate::Result;
use crate::canvas::{Draw, LOBE_COLORS, LOBE_LABELS, font, titled};
use plotters::coord::Shift;
use plotters::prelude::*;
use vellus::{Fiber, Model, Scattering, Window, WindowSupport};
use vellus_models::direction;

/// The number of azimuths. They are half a degree apart, the resolution of the tables.
const AZIMUTHS: usize = 720;

/// The lobes of one hit, integrated over θ_i.
pub struct Picture {
    title: String,
    /// The offset. `None` for a far field.
    h: Option<f64>,
    /// N(φ) of each lobe, per radian, mean of the channels.
    values: [Vec<f64>; 6],
    /// Integrals of the lobes.
    energies: [f64; 6],
}

impl Picture {
    /// Computes the lobes of a model of `fiber`, for ω_o at `theta_o` degrees and the offset `h` in [−1, 1].
    /// Far-field models ignore `h`.
    pub fn new(fiber: &Fiber, named: &Named, theta_o: f64, h: f64) -> Self {
        let hit = named.model.at(direction(theta_o, 0.0), Window::near(h as f32));
        let h = (named.model.field() != WindowSupport::Far).then_some(h);
        let steps = ((3.0 * 180.0 / (0.5 * f64::from(fiber.beta_m.to_degrees()))).ceil() as usize).clamp(180, 6000);
        let mut values: [Vec<f64>; 6] = std::array::from_fn(|_| vec![0.0; AZIMUTHS]);
        for j in 0..AZIMUTHS {
            let phi = 360.0 * j as f64 / AZIMUTHS as f64;
            for i in 0..steps {
                let theta = ((i as f64 + 0.5) / steps as f64 - 0.5) * 180.0;
                let weight = theta.to_radians().cos() * std::f64::consts::PI / steps as f64;
                for (value, lobe) in values.iter_mut().zip(hit.eval(direction(theta, phi)).0) {
                    value[j] += lobe.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0 * weight;
                }
            }
        }
        let energies = std::array::from_fn(|p| values[p].iter().sum::<f64>() * std::f64::consts::TAU / AZIMUTHS as f64);
        let at = h.map_or_else(|| "over the whole width".to_owned(), |h| format!("h = {h}"));
        let title = format!("{}: azimuthal lobes at θ_o = {theta_o}°, {at}, integrated over θ_i", named.title());
        Picture { title, h, values, energies }
    }

    fn polar<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let mut chart = ChartBuilder::on(area).margin(10).build_cartesian_2d(-1.2..1.2, -1.2..1.2)?;
        let largest = self.values.iter().flatten().fold(1e-30f64, |a, &x| a.max(x));
        // The square root makes areas proportional, and keeps weak lobes visible.
        let radius = |x: f64| 0.16 + 0.84 * (x / largest).sqrt();
        let at = |r: f64, degrees: f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            (-r * c, r * s)
        };
        let circle = |r: f64| (0..=180).map(move |k| at(r, 2.0 * f64::from(k)));
        for share in [0.1, 0.5, 1.0] {
            chart.draw_series(LineSeries::new(circle(radius(share * largest)), RGBColor(215, 215, 215)))?;
        }
        for degrees in (0..360).step_by(30) {
            let degrees = f64::from(degrees);
            chart.draw_series(LineSeries::new([at(0.16, degrees), at(1.0, degrees)], RGBColor(225, 225, 225)))?;
            let label = format!("{degrees}°");
            let style = font(18.0).pos(plotters::style::text_anchor::Pos::new(
                plotters::style::text_anchor::HPos::Center,
                plotters::style::text_anchor::VPos::Center,
            ));
            chart.draw_series([Text::new(label, at(1.09, degrees), style)])?;
        }
        for (values, color) in self.values.iter().zip(LOBE_COLORS) {
            if values.iter().all(|&x| x < 1e-4 * largest) {
                continue;
            }
            let line = (0..=AZIMUTHS).map(|j| at(radius(values[j % AZIMUTHS]), j as f64 / 2.0));
            chart.draw_series([Polygon::new(line.clone().collect::<Vec<_>>(), color.mix(0.12))])?;
            chart.draw_series(LineSeries::new(line, color.stroke_width(3)))?;
        }
        // The fibre, and the ray that hits it at h, coming from φ = 0 on the left.
        let fibre: Vec<_> = circle(0.15).collect();
        chart.draw_series([Polygon::new(fibre.clone(), RGBColor(245, 238, 225))])?;
        chart.draw_series(LineSeries::new(fibre, BLACK.stroke_width(2)))?;
        // A far field is the average over all offsets.
        let offsets = self.h.map_or_else(|| vec![-0.8, -0.4, 0.0, 0.4, 0.8], |h| vec![h]);
        for h in offsets {
            // Azimuth −asin h in the picture's orientation.
            let hit = at(0.15, -h.asin().to_degrees());
            chart.draw_series(LineSeries::new([(-0.98, hit.1), hit], BLACK.stroke_width(2)))?;
            let head = [hit, (hit.0 - 0.05, hit.1 + 0.02), (hit.0 - 0.05, hit.1 - 0.02)];
            chart.draw_series([Polygon::new(head.to_vec(), BLACK)])?;
        }
        Ok(())
    }

    fn cartesian<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let largest = self.values.iter().flatten().fold(1e-30f64, |a, &x| a.max(x));
        let floor = largest * 1e-5;
        let mut chart = ChartBuilder::on(area)
            .margin(15)
            .x_label_area_size(55)
            .y_label_area_size(85)
            .build_cartesian_2d(0.0..360.0, (floor..largest * 2.0).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("φ, degrees")
            .y_desc("N(φ), per radian")
            .x_labels(13)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .label_style(font(18.0))
            .axis_desc_style(font(20.0))
            .light_line_style(WHITE)
            .draw()?;
        for p in 0..6 {
            if self.energies[p] <= 0.0 {
                continue;
            }
            let color = LOBE_COLORS[p];
            let points = (0..=AZIMUTHS).map(|j| (j as f64 / 2.0, self.values[p][j % AZIMUTHS].max(floor)));
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(3)))?
                .label(format!("{}  {:.4}", LOBE_LABELS[p], self.energies[p]))
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], color.stroke_width(4)));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(180, 180, 180))
            .legend_area_size(34)
            .label_font(font(18.0))
            .draw()?;
        Ok(())
    }
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        (1640, 860)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &self.title, 28.0)?;
        let (left, right) = area.split_horizontally(800);
        self.polar(&left)?;
        self.cartesian(&right)
    }
}
