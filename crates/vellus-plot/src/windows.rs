//! The near field at five offsets of a window, its average as shipped, and the average by quadrature (Yan17
//! Fig. 12a).

use crate::canvas::{Draw, LOBE_COLORS, LOBE_LABELS, Mark, font, legend, log_labels, titled};
use crate::{Error, Result};
use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;
use rayon::prelude::*;
use vellus::{Bcsdf, Fiber, TableData, Tables, Window};
use vellus_models::direction;
use vellus_reference::exact::Exact;

/// The number of azimuths. They are half a degree apart, the resolution of the tables.
const AZIMUTHS: usize = 720;
/// Offsets of the quadrature: of R, TT, TRT and the rest, and of the scattered lobes.
const PATHS: usize = 20_000;
const POINTS: usize = 400;
/// Decades shown at most below the window's largest value.
const DECADES: f64 = 3.5;

/// Offsets at which the near field is shown, as shares of the window's width.
const PLACES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Their colours.
const PLACE_COLORS: [RGBColor; 5] = [LOBE_COLORS[0], LOBE_COLORS[1], LOBE_COLORS[2], LOBE_COLORS[3], LOBE_COLORS[4]];
const AVERAGE: RGBColor = RGBColor(0xbb, 0xbb, 0xbb);

/// N(φ) of R, TT, TRT, TTˢ, TRTˢ and the six together, mean of the channels.
type Curves = [Vec<f64>; 6];

/// The lobes of one fibre over one window.
pub struct Picture {
    title: String,
    offsets: [f64; 5],
    near: Vec<Curves>,
    average: Curves,
    exact: Curves,
}

/// Lobes at all azimuths.
fn curves(lobes: impl Fn(f64) -> [f64; 6] + Sync) -> Curves {
    let values: Vec<[f64; 6]> = (0..AZIMUTHS)
        .into_par_iter()
        .map(|j| lobes((360.0 * j as f64 / AZIMUTHS as f64).to_radians()))
        .map(|n| [n[0], n[1], n[2], n[3], n[4], n.iter().sum()])
        .collect();
    std::array::from_fn(|p| values.iter().map(|n| n[p]).collect())
}

impl Picture {
    /// Computes the lobes of the fibre called `name`, for ω_o at `theta_o` degrees and the window from `low` to
    /// `high`, both in [−1, 1].
    ///
    /// # Errors
    /// [`Error::Window`] unless `low` is below `high`; a parameter of the fibre out of its range.
    pub fn new(name: &str, fiber: &Fiber, theta_o: f64, [low, high]: [f64; 2]) -> Result<Self> {
        if low.is_nan() || high.is_nan() || low >= high {
            return Err(Error::Window { low, high });
        }
        let bcsdf = Bcsdf::new(fiber)?;
        let single = |n: [[f32; 3]; 6]| n.map(|n| n.iter().map(|&x| f64::from(x)).sum::<f64>() / 3.0);
        let over = |window: Window| {
            let hit = bcsdf.at(direction(theta_o, 0.0), window);
            curves(|phi| single(hit.azimuthal(phi as f32).0))
        };
        let offsets = PLACES.map(|place| low + (high - low) * place);
        let tables = TableData::from_bytes(Tables::SHIPPED)?;
        let oracle = Exact::new(fiber, &tables)?;
        let exact = oracle.window(theta_o.to_radians(), [low, high], PATHS, POINTS);
        Ok(Picture {
            title: format!("{name}: near field and its average over h {low} to {high}, θ_o = {theta_o}°"),
            offsets,
            near: offsets.iter().map(|&h| over(Window::near(h as f32))).collect(),
            average: over(Window::range(low as f32, high as f32)),
            exact: curves(|phi| exact.azimuthal(phi).map(|n| n.iter().sum::<f64>() / 3.0)),
        })
    }

    fn panel<DB: DrawingBackend>(&self, p: usize, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let largest = self.average[p].iter().chain(&self.exact[p]).fold(0.0f64, |a, &x| a.max(x));
        let name = if p < 5 { LOBE_LABELS[p] } else { "all six lobes" };
        if largest < 1e-12 {
            titled(area, &format!("{name}: no light"), 22.0)?;
            return Ok(());
        }
        let distance: f64 = self.average[p].iter().zip(&self.exact[p]).map(|(a, b)| (a - b).abs()).sum();
        let error = 100.0 * distance / self.exact[p].iter().sum::<f64>();
        let all = || self.near.iter().flat_map(|near| &near[p]).chain(&self.average[p]);
        let highest = all().fold(largest, |a, &x| a.max(x));
        // Paths that miss the medulla scatter no light. Zeros are omitted.
        let least = all().filter(|x| **x > 0.0).fold(largest, |a, &x| a.min(0.7 * x));
        let floor = least.max(largest * 10f64.powf(-DECADES));
        let mut chart = ChartBuilder::on(area)
            .margin(12)
            .caption(format!("{name}: averages differ by {error:.2} %"), font(22.0))
            .x_label_area_size(50)
            .y_label_area_size(78)
            .build_cartesian_2d(
                0.0..360.0,
                (floor..1.5 * highest).log_scale().with_key_points(log_labels(floor, 1.5 * highest)),
            )?;
        chart
            .configure_mesh()
            .x_desc("φ, degrees")
            .y_desc("N(φ), per radian")
            .x_labels(9)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .label_style(font(17.0))
            .axis_desc_style(font(18.0))
            .light_line_style(WHITE)
            .draw()?;
        let near = self.near.iter().zip(PLACE_COLORS).map(|(near, color)| (&near[p], color.stroke_width(2)));
        let averages = [(&self.average[p], AVERAGE.stroke_width(7)), (&self.exact[p], BLACK.stroke_width(2))];
        for (values, style) in near.chain(averages) {
            let points: Vec<_> =
                (0..=AZIMUTHS).map(|j| (360.0 * j as f64 / AZIMUTHS as f64, values[j % AZIMUTHS])).collect();
            // Points below the panel are omitted.
            for run in points.split(|(_, y)| *y < floor) {
                chart.draw_series(LineSeries::new(run.to_vec(), style))?;
            }
        }
        Ok(())
    }
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        (2000, 1240)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &self.title, 28.0)?;
        // Neighbours are a fifth of the window apart.
        let apart = self.offsets[1] - self.offsets[0];
        let digits = (0.5 - apart.log10()).ceil().max(1.0) as usize;
        let near = self.offsets.iter().zip(PLACE_COLORS);
        let mut entries: Vec<_> =
            near.map(|(h, color)| (format!("h = {h:.digits$}"), Mark::Line(color.stroke_width(3)))).collect();
        entries.push(("average, as shipped".to_owned(), Mark::Line(AVERAGE.stroke_width(7))));
        entries.push((format!("average of {PATHS} offsets"), Mark::Line(BLACK.stroke_width(2))));
        let area = legend(&area, &entries)?;
        for (p, place) in area.split_evenly((2, 3)).iter().enumerate() {
            self.panel(p, place)?;
        }
        Ok(())
    }
}
