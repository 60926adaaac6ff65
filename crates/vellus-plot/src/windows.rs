//! The near field at five offsets of a window, its average as shipped, and the average by quadrature (Yan17
//! Fig. 12a).

use crate::canvas::{Draw, LOBE_COLORS, LOBE_LABELS, Mark, font, legend, log_labels, titled};
use crate::{Error, Result};
use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use rayon::prelude::*;
use vellus::{Bcsdf, Fiber, TableData, Tables, Window};
use vellus_models::direction;
use vellus_reference::exact::Exact;

/// The number of azimuths. They are half a degree apart, the resolution of the tables.
const AZIMUTHS: usize = 720;
/// Offsets of the quadrature: of R, TT, TRT and the rest, and of the scattered lobes.
const PATHS: usize = 20_000;
const POINTS: usize = 400;
/// The scattered lobes are shown as local parabolas over this many azimuths on each side: 6°. The tables have the noise
/// of the photons that they were made of, in steps of half a degree: 0.3 to 0.5 % of a value, root mean square. The
/// lobes have no structure that is so narrow.
const BESIDE: usize = 12;
/// Decades shown at most below the window's largest value.
const DECADES: f64 = 3.5;

/// Offsets at which the near field is shown, as shares of the window's width.
const PLACES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Their colours.
const PLACE_COLORS: [RGBColor; 5] = [LOBE_COLORS[0], LOBE_COLORS[1], LOBE_COLORS[2], LOBE_COLORS[3], LOBE_COLORS[4]];
const AVERAGE: RGBColor = RGBColor(0xbb, 0xbb, 0xbb);
const AVERAGE_WIDTH: u32 = 7;
/// Length of the dashes of the quadrature, and of the gaps, in pixels.
const DASH: [u32; 2] = [9, 6];

/// N(φ) of R, TT, TRT, TTˢ, TRTˢ and the six together, mean of the channels. TTˢ and TRTˢ are without noise.
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
    let mut curves: Curves = std::array::from_fn(|p| values.iter().map(|n| n[p]).collect());
    for p in [3, 4] {
        let smooth = without_noise(&curves[p]);
        for j in 0..AZIMUTHS {
            curves[5][j] += smooth[j] - curves[p][j];
        }
        curves[p] = smooth;
    }
    curves
}

/// Each value replaced by that of the parabola that fits it and its neighbours best (Savitzky and Golay 1964). This
/// keeps the sum, and noise is 0.3 times as large.
fn without_noise(values: &[f64]) -> Vec<f64> {
    let m = BESIDE as f64;
    let weight = |k: f64| 3.0 * (3.0 * m * m + 3.0 * m - 1.0 - 5.0 * k * k);
    let all = (2.0 * m - 1.0) * (2.0 * m + 1.0) * (2.0 * m + 3.0);
    let count = values.len();
    (0..count)
        .map(|j| {
            let near =
                (0..=2 * BESIDE).map(|k| weight(k as f64 - m) * values[(j + count * BESIDE + k - BESIDE) % count]);
            // Where no light leaves, the parabola may be negative.
            (near.sum::<f64>() / all).max(0.0)
        })
        .collect()
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
            title: format!(
                "{name}: near field and its average over h {low} to {high}, θ_o = {theta_o}°; TTˢ and TRTˢ without \
                 the tables' noise"
            ),
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
        // Two averages that agree are both visible: the one as shipped is a wide band, the quadrature has dashes.
        let points = |values: &[f64]| -> Vec<(f64, f64)> {
            (0..=AZIMUTHS).map(|j| (360.0 * j as f64 / AZIMUTHS as f64, values[j % AZIMUTHS])).collect()
        };
        // Points below the panel are omitted.
        let runs = |values: &[f64]| -> Vec<Vec<(f64, f64)>> {
            points(values).split(|(_, y)| *y < floor).filter(|run| run.len() > 1).map(<[_]>::to_vec).collect()
        };
        for run in runs(&self.average[p]) {
            chart.draw_series(LineSeries::new(run, AVERAGE.stroke_width(AVERAGE_WIDTH)))?;
        }
        for (near, color) in self.near.iter().zip(PLACE_COLORS) {
            for run in runs(&near[p]) {
                chart.draw_series(LineSeries::new(run, color.stroke_width(2)))?;
            }
        }
        for run in runs(&self.exact[p]) {
            let dashes = DashedLineSeries::new(run, DASH[0], DASH[1], BLACK.stroke_width(2));
            chart.draw_series(dashes)?;
        }
        if let Some(text) = self.missing(p, floor) {
            let (width, _) = area.dim_in_pixel();
            let right = font(17.0).pos(Pos::new(HPos::Right, VPos::Center));
            area.draw_text(&text, &right, (width as i32 - 22, 56))?;
        }
        Ok(())
    }

    /// Names the curves of the legend that a panel whose smallest value is `floor` does not show.
    fn missing(&self, p: usize, floor: f64) -> Option<String> {
        let named = self.offsets.iter().zip(&self.near).map(|(h, near)| (self.offset(*h), &near[p]));
        let averages = [("average, as shipped", &self.average[p]), ("quadrature", &self.exact[p])];
        let dark: Vec<String> = named
            .chain(averages.map(|(name, curve)| (name.to_owned(), curve)))
            .filter(|(_, curve)| curve.iter().all(|x| *x < floor))
            .map(|(name, _)| name)
            .collect();
        (!dark.is_empty()).then(|| format!("no light: {}", dark.join(", ")))
    }

    /// The name of an offset. Neighbours are a fifth of the window apart.
    fn offset(&self, h: f64) -> String {
        let apart = self.offsets[1] - self.offsets[0];
        let digits = (0.5 - apart.log10()).ceil().max(1.0) as usize;
        format!("h = {h:.digits$}")
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
        let near = self.offsets.iter().zip(PLACE_COLORS);
        let mut entries: Vec<_> = near.map(|(h, color)| (self.offset(*h), Mark::Line(color.stroke_width(3)))).collect();
        entries.push(("average, as shipped".to_owned(), Mark::Line(AVERAGE.stroke_width(AVERAGE_WIDTH))));
        entries.push((format!("average by quadrature, {PATHS} offsets"), Mark::Dashes(BLACK.stroke_width(2), DASH)));
        let area = legend(&area, &entries)?;
        for (p, place) in area.split_evenly((2, 3)).iter().enumerate() {
            self.panel(p, place)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas;
    use vellus::Species;

    /// Shapes as wide as those of the lobes stay, and independent noise becomes 0.3 times as large.
    #[test]
    fn noise_is_left_out_and_shapes_stay() {
        let angle = |j: usize| (360.0 * j as f64 / AZIMUTHS as f64).to_radians();
        let shape: Vec<f64> = (0..AZIMUTHS).map(|j| 2.0 + angle(j).cos() + (3.0 * angle(j)).sin()).collect();
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 * 0.5f64.powi(53) - 0.5
        };
        let noise: Vec<f64> = (0..AZIMUTHS).map(|_| 0.1 * uniform()).collect();
        let found = without_noise(&shape.iter().zip(&noise).map(|(a, b)| a + b).collect::<Vec<_>>());
        let square = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>();
        let left = square(&mut found.iter().zip(&shape).map(|(a, b)| a - b)) / square(&mut noise.iter().copied());
        // 0.3² = 0.09, and the sum of 720 squares has a spread of some percent, which correlation makes larger.
        assert!(left > 0.05 && left < 0.13, "{left}");
        assert!((found.iter().sum::<f64>() - shape.iter().zip(&noise).map(|(a, b)| a + b).sum::<f64>()).abs() < 1e-9);
        let exact = without_noise(&shape);
        // The sine of 3 φ loses m⁴ 81/40 · (0.5°)⁴ of its height, less than 3e-4.
        assert!(exact.iter().zip(&shape).all(|(a, b)| (a - b).abs() < 3e-4));
    }

    /// Every curve of the legend has a line in every panel, or the panel says that there is no light.
    #[test]
    fn what_the_legend_lists_is_drawn_or_named() {
        let fiber = Fiber::published(Species::RedFox);
        // Half of the width: the outer offsets miss a thin medulla.
        let thin = Fiber { kappa: 0.2, ..fiber };
        for (fiber, dark) in [(fiber, false), (thin, true)] {
            let picture = Picture::new("a fibre", &fiber, 0.0, [-1.0, 1.0]).unwrap();
            let folder = std::env::temp_dir().join(format!("vellus-windows-{dark}-{}", std::process::id()));
            std::fs::create_dir_all(&folder).unwrap();
            let file = folder.join("windows.svg");
            canvas::save(&picture, std::slice::from_ref(&file)).unwrap();
            let svg = std::fs::read_to_string(&file).unwrap();
            std::fs::remove_dir_all(&folder).unwrap();
            let lines = |color: RGBColor| {
                let color = format!("stroke=\"#{:02X}{:02X}{:02X}\"", color.0, color.1, color.2);
                svg.lines().filter(|line| line.contains("<polyline") && line.contains(&color)).count()
            };
            let missing = svg.matches("no light: ").count();
            assert_eq!(missing > 0, dark);
            // One line in the legend and one in each of the six panels; TTˢ and TRTˢ lack the outer offsets.
            for (k, color) in PLACE_COLORS.into_iter().enumerate() {
                let panels = if dark && k != 2 { 4 } else { 6 };
                assert!(lines(color) > panels, "{k}: {} {svg}", lines(color));
            }
            assert!(lines(AVERAGE) > 6);
            if dark {
                assert!(svg.contains("no light: h = -0.8, h = -0.4, h = 0.4, h = 0.8"));
            }
        }
    }
}
