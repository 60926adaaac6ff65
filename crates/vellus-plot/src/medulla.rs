//! Medulla profiles: compressed to tables, and simulated (Yan17 Fig. 10).

use crate::Result;
use crate::canvas::{Draw, LOBE_COLORS, font, titled};
use plotters::coord::Shift;
use plotters::prelude::SeriesLabelPosition::{UpperLeft, UpperRight};
use plotters::prelude::*;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use vellus::TableData;
use vellus_io::{Progress, Steps};
use vellus_reference::exact::Profile;
use vellus_reference::simulate::medulla::{azimuthal, longitudinal, stream};

/// (τ, g) of the columns: a thin, a medium and a thick medulla, between the nodes of the tables.
const COLUMNS: [(f64, f64); 3] = [(0.25, 0.3), (2.0, 0.6), (9.0, 0.88)];
/// Offsets of the azimuthal curves.
const OFFSETS: [f64; 3] = [0.0, 0.5, 0.9];
/// Inclinations of the longitudinal curves, degrees.
const INCLINATIONS: [f64; 3] = [0.0, 40.0, 75.0];
/// Allowed numbers of photons of a simulated profile.
pub const PHOTONS: RangeInclusive<u64> = 1000..=1_000_000_000;
/// Bins over the circle; half as many over 180°.
const BINS: usize = 360;

/// A simulated curve and the curve of the tables, over degrees.
struct Curve {
    label: String,
    simulated: Vec<(f64, f64)>,
    table: Vec<(f64, f64)>,
}

/// Six panels of curves.
pub struct Picture {
    azimuthal: Vec<Vec<Curve>>,
    longitudinal: Vec<Vec<Curve>>,
    bytes: usize,
}

impl Picture {
    /// Simulates profiles with `photons` photons each and compares them with tables, which have a size of `bytes` as
    /// a file.
    pub fn new(data: &TableData, bytes: usize, photons: u64, progress: &dyn Progress) -> Self {
        let steps = Steps::new(progress, 18, "simulating");
        let azimuthal = COLUMNS
            .par_iter()
            .enumerate()
            .map(|(i, &(tau, g))| {
                let curve = |(k, &h): (usize, &f64)| {
                    let simulated = azimuthal(tau, g, h, photons, BINS, &mut stream(1, (3 * i + k) as u64)).density;
                    let profile = Profile::azimuthal(data, tau, g, h);
                    steps.advance(1);
                    Curve {
                        label: format!("h″ = {h}"),
                        simulated: simulated
                            .iter()
                            .enumerate()
                            .map(|(j, &y)| (j as f64 * 360.0 / BINS as f64, y))
                            .collect(),
                        table: (0..=720)
                            .map(|j| f64::from(j) / 2.0)
                            .map(|x| (x, profile.eval(x.to_radians())))
                            .collect(),
                    }
                };
                OFFSETS.iter().enumerate().map(curve).collect()
            })
            .collect();
        let longitudinal = COLUMNS
            .par_iter()
            .enumerate()
            .map(|(i, &(tau, g))| {
                let nodes = BINS / 2 + 1;
                let curves = |(k, &theta): (usize, &f64)| {
                    let mut rng = stream(2, (3 * i + k) as u64);
                    let simulated = longitudinal(tau, g, theta.to_radians(), photons, nodes, &mut rng);
                    let profiles = Profile::longitudinal(data, tau, g, theta.to_radians());
                    steps.advance(1);
                    // The forward half; the backward one is smooth.
                    let points = simulated.density[1].iter().enumerate();
                    Curve {
                        label: format!("θ_o = {theta}°, forward"),
                        simulated: points.map(|(j, &y)| (j as f64 * 180.0 / (nodes - 1) as f64 - 90.0, y)).collect(),
                        table: (-180..=180)
                            .map(|j| f64::from(j) / 2.0)
                            .map(|x| (x, profiles[1].eval(x.to_radians())))
                            .collect(),
                    }
                };
                INCLINATIONS.iter().enumerate().map(curves).collect()
            })
            .collect();
        Picture { azimuthal, longitudinal, bytes }
    }
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        (2000, 1200)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let title = format!(
            "Light scattered by the medulla: simulated (thin grey) and compressed to {:.0} KB (coloured)",
            self.bytes as f64 / 1000.0
        );
        let area = titled(area, &title, 28.0)?;
        let places = area.split_evenly((2, 3));
        for (i, (tau, g)) in COLUMNS.iter().enumerate() {
            let title = format!("C^N, τ = {tau}, g = {g}");
            panel(&places[i], &self.azimuthal[i], &title, 0.0..360.0, "φ from straight back, degrees", UpperLeft)?;
            let title = format!("C^M, τ = {tau}, g = {g}");
            // The peaks are on the left: θ_i = −θ_o.
            panel(&places[3 + i], &self.longitudinal[i], &title, -90.0..90.0, "θ_i, degrees", UpperRight)?;
        }
        Ok(())
    }
}

fn panel<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    curves: &[Curve],
    title: &str,
    range: std::ops::Range<f64>,
    label: &str,
    legend: SeriesLabelPosition,
) -> Result<()>
where
    DB::ErrorType: 'static,
{
    // From the tables: the last bins of the simulation, at the poles, are noise.
    let top = curves.iter().flat_map(|c| &c.table).fold(0.0f64, |a, p| a.max(p.1)) * 1.15;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(title, font(22.0))
        .x_label_area_size(50)
        .y_label_area_size(66)
        .build_cartesian_2d(range, 0.0..top)?;
    chart
        .configure_mesh()
        .x_desc(label)
        .y_desc("density")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .label_style(font(16.0))
        .axis_desc_style(font(18.0))
        .light_line_style(WHITE)
        .draw()?;
    for (curve, color) in curves.iter().zip([LOBE_COLORS[0], LOBE_COLORS[4], LOBE_COLORS[2]]) {
        let simulated = curve.simulated.iter().map(|&(x, y)| (x, y.min(top)));
        chart.draw_series(LineSeries::new(simulated, RGBColor(120, 120, 120)))?;
        chart
            .draw_series(LineSeries::new(curve.table.iter().copied(), color.stroke_width(2)))?
            .label(&curve.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], color.stroke_width(3)));
    }
    chart
        .configure_series_labels()
        .position(legend)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(180, 180, 180))
        .legend_area_size(32)
        .label_font(font(16.0))
        .draw()?;
    Ok(())
}
