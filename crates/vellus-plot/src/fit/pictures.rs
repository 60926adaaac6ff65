//! Pictures of a fit: measured and fitted profile, their ratio, and slices (Yan17 Fig. 11).

use super::summary::{Summary, significant};
use crate::Result;
use crate::canvas::{Draw, LOBE_COLORS, Mark, font, legend, titled};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use vellus_fit::{Forward, Part, Profile, Quantity};
use vellus_models::ModelKind;

/// Points of a fitted curve.
const CURVE: usize = 400;

/// Slices of each kind.
const SLICES: usize = 4;

/// A direction with its measured and fitted values: logarithms to base 10, averaged over the channels.
struct Cell {
    theta: f64,
    phi: f64,
    /// `None` if the measurement is missing.
    measured: Option<f64>,
    fitted: f64,
}

fn mean_log(values: &[f64]) -> f64 {
    values.iter().map(|x| x.max(1e-300).log10()).sum::<f64>() / values.len() as f64
}

/// log₁₀ of the fitted model for each θ and φ.
fn model(profile: &Profile, model: ModelKind, part: &Part, angles: &[[f64; 2]]) -> Result<Vec<f64>> {
    let Part { specimen, theta_o, scale, background, .. } = part;
    let values = Forward::new(model)?.averages(specimen, *theta_o, profile, angles)?;
    let log = |value: &[f64; 3]| mean_log(&value.map(|x| x * scale + background)[..profile.channels]);
    Ok(values.iter().map(log).collect())
}

fn cells(profile: &Profile, kind: ModelKind, part: &Part) -> Result<Vec<Cell>> {
    let channels = profile.channels;
    let there = profile.points.iter().map(|p| ([p.theta, p.phi], Some(mean_log(&p.value[..channels]))));
    let missing = profile.missing.iter().map(|&angles| (angles, None));
    let (angles, measured): (Vec<_>, Vec<_>) = there.chain(missing).unzip();
    let fitted = model(profile, kind, part, &angles)?;
    let places = angles.into_iter().zip(measured).zip(fitted);
    Ok(places.map(|(([theta, phi], measured), fitted)| Cell { theta, phi, measured, fitted }).collect())
}

/// The distinct values of one coordinate, sorted.
fn axis(cells: &[Cell], coordinate: impl Fn(&Cell) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = cells.iter().map(coordinate).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The median distance of neighbouring values.
fn spacing(axis: &[f64]) -> f64 {
    let mut steps: Vec<f64> = axis.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(1.0)
}

/// A diverging colour scale over [−1, 1]: blue, white, red.
fn diverging(t: f64) -> RGBColor {
    let t = t.clamp(-1.0, 1.0);
    let end = if t < 0.0 { [33.0, 102.0, 172.0] } else { [178.0, 24.0, 43.0] };
    let mix = |c: f64| (247.0 + (c - 247.0) * t.abs()).round() as u8;
    RGBColor(mix(end[0]), mix(end[1]), mix(end[2]))
}

/// Labels of a logarithmic axis. An axis with fewer powers of ten has more labels for each.
fn key_points(low: f64, high: f64) -> Vec<f64> {
    let steps: &[f64] = match high / low {
        ..12.0 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
        ..40.0 => &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
        ..300.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    (low.log10().floor() as i32..=high.log10().ceil() as i32)
        .flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)))
        .filter(|y| (low..high).contains(y))
        .collect()
}

/// A measured profile, the fitted one, and their ratio: of the profile with this index.
pub struct Profiles<'a>(pub &'a Summary<'a>, pub usize);

impl Draw for Profiles<'_> {
    fn size(&self) -> (u32, u32) {
        (1300, 1180)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (profile, fit, part) = self.0.part(self.1);
        let cells = cells(profile, fit.model, part)?;
        let what = match profile.quantity {
            Quantity::FCos => "f·cos θ",
            Quantity::F => "f",
        };
        let averaged = if profile.channels == 1 { "" } else { ", geometric mean of the channels" };
        let title = format!(
            "{what} in the measurement's unit{averaged}, θ_o = {:.1}°; by {}: NRMSE {:.2} %, of logarithms {:.2} %; \
             grey: missing",
            part.theta_o,
            self.0.model(),
            100.0 * part.nrmse,
            100.0 * part.log_nrmse
        );
        let area = titled(area, &title, 21.0)?;
        let measured = || cells.iter().filter_map(|c| c.measured);
        let (low, high) = (measured().fold(f64::INFINITY, f64::min), measured().fold(f64::NEG_INFINITY, f64::max));
        let mut off: Vec<f64> = cells.iter().filter_map(|c| Some((c.fitted - c.measured?).abs())).collect();
        off.sort_by(f64::total_cmp);
        // The largest hundredth may be outliers. The range is at least a factor of 1.05, because noise would otherwise
        // look like structure.
        let span = off[(off.len() - 1) * 99 / 100].max(1.05f64.log10());
        let light = |x: f64| ViridisRGB.get_color(((x - low) / (high - low).max(1e-9)).clamp(0.0, 1.0));
        let scale = [low, high].map(|x| 10f64.powf(x));
        let ratio = [-span, span].map(|x| 10f64.powf(x));
        let places = area.split_evenly((3, 1));
        let level = |t: f64| ViridisRGB.get_color(t);
        let fold = |t: f64| diverging(2.0 * t - 1.0);
        let off = |c: &Cell| Some(diverging((c.fitted - c.measured?) / span));
        panel(&places[0], "measured", &cells, &|c| c.measured.map(light), scale, &level)?;
        panel(&places[1], "fitted", &cells, &|c| Some(light(c.fitted)), scale, &level)?;
        panel(&places[2], "fitted / measured", &cells, &off, ratio, &fold)
    }
}

/// Draws one profile with its colour bar.
fn panel<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    name: &str,
    cells: &[Cell],
    color: &dyn Fn(&Cell) -> Option<RGBColor>,
    scale: [f64; 2],
    level: &dyn Fn(f64) -> RGBColor,
) -> Result<()>
where
    DB::ErrorType: 'static,
{
    let (thetas, phis) = (axis(cells, |c| c.theta), axis(cells, |c| c.phi));
    let (high, wide) = (0.5 * spacing(&thetas), 0.5 * spacing(&phis));
    let ends = |axis: &[f64], half: f64| (axis[0] - half)..(axis[axis.len() - 1] + half);
    let (width, _) = area.dim_in_pixel();
    let (left, right) = area.split_horizontally(width - 130);
    let mut chart = ChartBuilder::on(&left)
        .margin(10)
        .caption(name, font(22.0))
        .x_label_area_size(46)
        .y_label_area_size(64)
        .build_cartesian_2d(ends(&phis, wide), ends(&thetas, high))?;
    // Missing values stay grey.
    chart.plotting_area().fill(&RGBColor(200, 200, 200))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("φ, degrees")
        .y_desc("θ, degrees")
        .x_labels(12)
        .y_labels(6)
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .label_style(font(16.0))
        .axis_desc_style(font(17.0))
        .draw()?;
    chart.draw_series(cells.iter().filter_map(|c| {
        let corners = [(c.phi - wide, c.theta - high), (c.phi + wide, c.theta + high)];
        Some(Rectangle::new(corners, color(c)?.filled()))
    }))?;
    bar(&right, scale, level)
}

/// Draws a logarithmic colour bar from `scale[0]` to `scale[1]`.
fn bar<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    scale: [f64; 2],
    level: &dyn Fn(f64) -> RGBColor,
) -> Result<()>
where
    DB::ErrorType: 'static,
{
    const STEPS: i32 = 64;
    let (_, height) = area.dim_in_pixel();
    let (top, bottom) = (54, height as i32 - 66);
    let y = |t: f64| bottom - (t * f64::from(bottom - top)) as i32;
    for i in 0..STEPS {
        let [a, b] = [i, i + 1].map(|i| y(f64::from(i) / f64::from(STEPS)));
        area.draw(&Rectangle::new([(4, b), (26, a)], level((f64::from(i) + 0.5) / f64::from(STEPS)).filled()))?;
    }
    for t in [0.0, 0.5, 1.0] {
        let value = (scale[0].ln() * (1.0 - t) + scale[1].ln() * t).exp();
        area.draw_text(&significant(value), &font(16.0), (34, y(t) - 8))?;
    }
    Ok(())
}

/// Slices through a measured profile and the fitted one, over φ at some θ, and over θ at some φ: of the profile with
/// this index.
pub struct Slices<'a>(pub &'a Summary<'a>, pub usize);

impl Draw for Slices<'_> {
    fn size(&self) -> (u32, u32) {
        (1300, 1180)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &format!("points: measured; curves: fitted by {}", self.0.model()), 21.0)?;
        for (over_phi, place) in [true, false].into_iter().zip(area.split_evenly((2, 1))) {
            self.panel(&place, over_phi)?;
        }
        Ok(())
    }
}

impl Slices<'_> {
    fn panel<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, over_phi: bool) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let (profile, fit, part) = self.0.part(self.1);
        let cells = cells(profile, fit.model, part)?;
        let held = |c: &Cell| if over_phi { c.theta } else { c.phi };
        let runs = |c: &Cell| if over_phi { c.phi } else { c.theta };
        let (places, along) = (axis(&cells, held), axis(&cells, runs));
        let chosen: Vec<f64> = (0..SLICES.min(places.len()))
            .map(|i| places[(places.len() - 1) * (2 * i + 1) / (2 * SLICES.min(places.len()))])
            .collect();
        let (first, last) = (along[0], along[along.len() - 1]);
        let mut low = f64::INFINITY;
        let mut high = 0.0f64;
        let mut curves = Vec::new();
        for &place in &chosen {
            let points: Vec<(f64, f64)> = cells
                .iter()
                .filter(|c| held(c) == place)
                .filter_map(|c| Some((runs(c), 10f64.powf(c.measured?))))
                .collect();
            let x: Vec<f64> = (0..=CURVE).map(|i| first + (last - first) * i as f64 / CURVE as f64).collect();
            let angles: Vec<_> = x.iter().map(|&x| if over_phi { [place, x] } else { [x, place] }).collect();
            let y = model(profile, fit.model, part, &angles)?;
            let curve: Vec<(f64, f64)> = x.into_iter().zip(y).map(|(x, y)| (x, 10f64.powf(y))).collect();
            for (_, y) in points.iter().chain(&curve) {
                (low, high) = (low.min(*y), high.max(*y));
            }
            curves.push((points, curve));
        }
        let (what, other) = if over_phi { ("θ", "φ, degrees") } else { ("φ", "θ, degrees") };
        let entries: Vec<(String, Mark)> = chosen
            .iter()
            .zip(LOBE_COLORS)
            .map(|(x, color)| (format!("{what} = {x:.1}°"), Mark::Line(color.stroke_width(4))))
            .collect();
        let area = legend(area, &entries)?;
        let margin = (high / low).powf(0.05).max(1.01);
        let (low, high) = (low / margin, high * margin);
        let mut chart = ChartBuilder::on(&area)
            .margin(10)
            .margin_right(30)
            .x_label_area_size(46)
            .y_label_area_size(84)
            .build_cartesian_2d(first..last, (low..high).log_scale().with_key_points(key_points(low, high)))?;
        chart
            .configure_mesh()
            .x_desc(other)
            .y_desc("value")
            .x_labels(12)
            .y_labels(8)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_label_formatter(&|y| significant(*y))
            .label_style(font(16.0))
            .axis_desc_style(font(17.0))
            .light_line_style(WHITE)
            .draw()?;
        for ((points, curve), color) in curves.into_iter().zip(LOBE_COLORS) {
            chart.draw_series(LineSeries::new(curve, color.stroke_width(3)))?;
            chart.draw_series(points.into_iter().map(|at| Circle::new(at, 3, color.filled())))?;
        }
        Ok(())
    }
}
