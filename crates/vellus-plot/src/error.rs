//! Error of the far field over the number of segments, for the paper's scheme and ours (Yan17 Sec. 5.1,
//! Segmentation).

use crate::Result;
use crate::canvas::{Draw, LOBE_COLORS, Mark, font, legend, titled};
use crate::text;
use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;
use rayon::prelude::*;
use std::f64::consts::TAU;
use vellus::{Bcsdf, Fiber, TableData, Tables, Window};
use vellus_models::direction;
use vellus_reference::exact::Exact;

/// Numbers of segments on each side of h = 0. Our scheme needs at least two: one inside the medulla and one outside.
pub const SEGMENTS: [usize; 13] = [2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 20, 24, 32];
/// Segments on each side in the shipped model: their eight ends fill a register.
pub const SHIPPED: usize = 7;
/// Azimuths compared.
const AZIMUTHS: usize = 360;
/// Offsets of the quadrature, in pictures.
pub const PATHS: usize = 20_000;

/// The smallest error shown, percent.
const FLOOR: f64 = 1e-3;

const PAPER: RGBColor = LOBE_COLORS[4];
const OURS: RGBColor = LOBE_COLORS[0];

/// Relative L1 errors of the far field of one fibre, for R + TT + TRT.
pub struct Errors {
    /// Errors of the paper's scheme, one for each of [`SEGMENTS`].
    pub paper: Vec<f64>,
    /// Errors of our scheme, one for each of [`SEGMENTS`].
    pub ours: Vec<f64>,
    /// The error of the shipped model.
    pub shipped: f64,
}

/// Selects one of the two schemes.
type Scheme = fn(&Errors) -> &[f64];

/// R + TT + TRT, mean of the channels, at all azimuths.
fn profile(lobes: impl Fn(f64) -> [[f64; 3]; 3] + Sync) -> Vec<f64> {
    (0..AZIMUTHS)
        .into_par_iter()
        .map(|j| lobes((j as f64 + 0.5) / AZIMUTHS as f64 * TAU).as_flattened().iter().sum::<f64>() / 3.0)
        .collect()
}

fn first<const N: usize>(lobes: [[f64; 3]; N]) -> [[f64; 3]; 3] {
    [lobes[0], lobes[1], lobes[2]]
}

impl Errors {
    /// Compares with a quadrature of `paths` offsets, for ω_o at `theta_o` degrees.
    ///
    /// # Errors
    /// A parameter of the fibre out of its range.
    pub fn new(fiber: &Fiber, theta_o: f64, paths: usize) -> Result<Self> {
        let bcsdf = Bcsdf::new(fiber)?;
        let tables = TableData::from_bytes(Tables::SHIPPED)?;
        let oracle = Exact::new(fiber, &tables)?;
        let (theta, all) = (theta_o.to_radians(), [-1.0, 1.0]);
        let window = oracle.window(theta, all, paths, 0);
        let exact = profile(|phi| first(window.azimuthal(phi)));
        let total: f64 = exact.iter().sum();
        let error = |values: Vec<f64>| values.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum::<f64>() / total;
        let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
        let paper = |n| {
            let segments = oracle.printed_segments(theta, all, n, 1);
            error(profile(|phi| first(segments.azimuthal(phi))))
        };
        let ours = |n| {
            let segments = oracle.segments(theta, all, n);
            error(profile(|phi| segments.azimuthal(phi)))
        };
        Ok(Errors {
            paper: SEGMENTS.map(paper).to_vec(),
            ours: SEGMENTS.map(ours).to_vec(),
            shipped: error(profile(|phi| first(hit.azimuthal(phi as f32).0.map(|n| n.map(f64::from))))),
        })
    }
}

/// Errors of one fibre, or of several and their mean.
pub struct Picture {
    /// The name of the fibre or the fibres.
    pub name: String,
    /// Inclination of ω_o, degrees.
    pub theta_o: f64,
    /// At least one.
    pub fibers: Vec<Errors>,
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    sum / f64::from(count)
}

impl Picture {
    /// The numbers as a table of text, in percent.
    pub fn table(&self) -> String {
        let several = self.fibers.len() > 1;
        // Mean and worst of several fibres, or the error of the only one.
        let cells = |error: &dyn Fn(&Errors) -> f64| {
            let errors = || self.fibers.iter().map(error);
            let worst = errors().fold(0.0f64, f64::max);
            let numbers = if several { vec![mean(errors()), worst] } else { vec![worst] };
            numbers.into_iter().map(|e| format!("{:.3}", 100.0 * e)).collect::<Vec<_>>()
        };
        let names: &[&str] = if several {
            &["segments", "paper: mean", "worst", "ours: mean", "worst"]
        } else {
            &["segments", "paper", "ours"]
        };
        let mut rows = vec![names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>()];
        for (i, n) in SEGMENTS.iter().enumerate() {
            rows.push([vec![n.to_string()], cells(&|f| f.paper[i]), cells(&|f| f.ours[i])].concat());
        }
        let shipped = cells(&|f| f.shipped);
        rows.push([vec![format!("{SHIPPED}, as shipped")], vec![String::new(); shipped.len()], shipped].concat());
        let at = format!("far field of {} at θ_o = {}°", self.name, self.theta_o);
        format!("L1 error of R + TT + TRT in percent, {at}\n\n{}", text::align(&rows))
    }
}

impl Draw for Picture {
    fn size(&self) -> (u32, u32) {
        (1200, 860)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let title = format!("Far field of R + TT + TRT against quadrature: {}, θ_o = {}°", self.name, self.theta_o);
        let area = titled(area, &title, 26.0)?;
        let several = self.fibers.len() > 1;
        let (thin, thick) = (if several { 1 } else { 4 }, 4);
        let shade = |color: RGBColor| if several { color.mix(0.6) } else { color.mix(1.0) };
        let mut entries = vec![
            ("paper: h_i = (i/n)^½".to_owned(), Mark::Line(PAPER.stroke_width(thick))),
            ("ours: γ_o, asin h″".to_owned(), Mark::Line(OURS.stroke_width(thick))),
            (format!("as shipped, n = {SHIPPED}"), Mark::Circle(BLACK.filled())),
        ];
        if several {
            entries.push(("thick: mean; thin and small: each fibre".to_owned(), Mark::Nothing));
        }
        let area = legend(&area, &entries)?;
        let values = self.fibers.iter().flat_map(|f| f.paper.iter().chain(&f.ours).chain([&f.shipped]));
        let (least, most) = values.fold((1.0f64, 0.0f64), |(a, b), &e| (a.min(100.0 * e), b.max(100.0 * e)));
        let floor = 10f64.powf(least.max(FLOOR).log10().floor());
        let powers = (0..9).map(|k| floor * 10f64.powi(k)).filter(|&y| y < 1.5 * most).collect();
        let x = SEGMENTS.map(|n| n as f64);
        let mut chart =
            ChartBuilder::on(&area).margin(20).x_label_area_size(60).y_label_area_size(90).build_cartesian_2d(
                (x[0]..x[x.len() - 1] * 1.02).log_scale().with_key_points(x.to_vec()),
                (floor..1.5 * most).log_scale().with_key_points(powers),
            )?;
        chart
            .configure_mesh()
            .x_desc("segments on each side of h = 0, n")
            .y_desc("L1 error, percent of the profile")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| format!("{}", (y * 1e6).round() / 1e6))
            .label_style(font(18.0))
            .axis_desc_style(font(20.0))
            .bold_line_style(BLACK.mix(0.15))
            .light_line_style(TRANSPARENT)
            .draw()?;
        let schemes: [(Scheme, RGBColor); 2] = [(|f| &f.paper, PAPER), (|f| &f.ours, OURS)];
        for (scheme, color) in schemes {
            let points = |error: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
                x.iter().enumerate().map(|(i, &n)| (n, 100.0 * error(i))).filter(|(_, e)| *e >= floor).collect()
            };
            for fiber in &self.fibers {
                let line = points(&|i| scheme(fiber)[i]);
                chart.draw_series(LineSeries::new(line, shade(color).stroke_width(thin)))?;
            }
            let line = points(&|i| mean(self.fibers.iter().map(|f| scheme(f)[i])));
            chart.draw_series(LineSeries::new(line, color.stroke_width(thick)))?;
        }
        let at = |error: f64| (SHIPPED as f64, 100.0 * error);
        chart.draw_series(self.fibers.iter().map(|f| Circle::new(at(f.shipped), 3, BLACK.filled())))?;
        chart.draw_series([Circle::new(at(mean(self.fibers.iter().map(|f| f.shipped))), 8, BLACK.filled())])?;
        Ok(())
    }
}
