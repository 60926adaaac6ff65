//! The colours of coats: renders coats of random fibres, fits [`vellus::parts::Curve`] to them, and checks how well a
//! requested colour is reached.
//!
//! ```sh
//! cargo run --release --bin coat_colors -- fit out/coats.csv
//! cargo run --release --bin coat_colors -- check out/check.csv
//! ```
//!
//! `presets` measures the ten presets and hair with one colour. `fit` prints the numbers in
//! `crates/vellus/src/coat/curve.rs`. The files keep finished coats, so that a run that was interrupted continues. A
//! number after the file is the number of coats; it is 600 for `fit` and 200 for `check`.

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use vellus::parts::{CURVE_NUMBERS, Curve, Moments, Shape};
use vellus::{CoatColors, Color, Fiber, Species};
use vellus_experiments::coat::{Coat, Measured, delta_e2000, random_color, random_fiber};
use vellus_fit::least_squares::{Difference, Problem};

/// Samples of each of the 576 pixels.
const SAMPLES: u64 = 16;
/// The fibres of `check` begin here, so that `fit` has not seen them.
const FIRST_CHECKED: u64 = 100_000;
/// Darker channels are noise.
const DARKEST: f64 = 5e-4;
/// Where the fit starts: the theory of isotropic scattering, roughly.
const START: [f64; CURVE_NUMBERS] = [1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 10.0, 1.0, 0.0, 0.0, 0.5, 0.0, 0.0];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments == ["presets"] {
        return presets();
    }
    let usage = "usage: coat_colors presets, or coat_colors fit|check FILE [COATS]";
    let [task, file, rest @ ..] = &arguments[..] else { bail!(usage) };
    let count = rest.first().map(|text| text.parse::<usize>()).transpose().context(usage)?;
    match task.as_str() {
        "fit" => fit(&PathBuf::from(file), count.unwrap_or(600)),
        "check" => check(&PathBuf::from(file), count.unwrap_or(200)),
        _ => bail!(usage),
    }
}

/// The rows of a file, after those that are missing up to `count` were made and written.
fn rows(path: &Path, count: usize, mut make: impl FnMut(u64) -> Result<Vec<f64>>) -> Result<Vec<Vec<f64>>> {
    let text = if path.exists() { std::fs::read_to_string(path)? } else { String::new() };
    let numbers = |line: &str| line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
    let mut rows: Vec<Vec<f64>> = text.lines().map(numbers).collect::<Result<_, _>>().context("a damaged file")?;
    let mut text = text;
    for number in rows.len()..count {
        let row = make(number as u64)?;
        let fields: Vec<String> = row.iter().map(|x| format!("{x:.6}")).collect();
        writeln!(text, "{}", fields.join(","))?;
        vellus_io::write(path, text.as_bytes())?;
        rows.push(row);
    }
    rows.truncate(count);
    Ok(rows)
}

/// Renders coats and fits the curve to their colours. The residuals are differences of cube roots, which are
/// proportional to differences of lightness.
fn fit(path: &Path, count: usize) -> Result<()> {
    let mut coat = Coat::new()?;
    let rows = rows(path, count, |number| {
        let measured = coat.measure(&random_fiber(number), SAMPLES, number as u32)?;
        Ok([&measured.color[..], &[measured.error]].concat())
    })?;
    let points: Vec<(Moments, f64)> = rows
        .par_iter()
        .enumerate()
        .flat_map_iter(|(i, row)| {
            let fiber = random_fiber(i as u64);
            let moments = Shape::new(&fiber).moments(fiber.sigma_ca, fiber.sigma_ma);
            moments.into_iter().zip(row.clone()).filter(|(_, color)| *color > DARKEST)
        })
        .collect();
    let curve = |u: &[f64]| Curve { numbers: std::array::from_fn(|i| u[i] as f32) };
    let residuals = |u: &[f64]| -> Vec<f64> {
        let curve = curve(u);
        points.iter().map(|(moments, color)| f64::from(curve.color(moments)).cbrt() - color.cbrt()).collect()
    };
    let bounds = [[-10.0, 100.0]; CURVE_NUMBERS];
    let steps = START.map(|x| 1e-3 * f64::max(1.0, x));
    let problem =
        Problem { bounds: &bounds, steps: &steps, residuals: &residuals, huber: f64::INFINITY, progress: &() };
    let best = problem.minimise(&START, Difference::Central, 500);
    let mut errors: Vec<f64> = best.residuals.iter().map(|r| 116.0 * r.abs()).collect();
    errors.sort_by(f64::total_cmp);
    println!("{:.4?}", best.u);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let [worst, most] = [errors.len() - 1, errors.len() * 9 / 10].map(|i| errors[i]);
    println!("{} colours: error of L* {mean:.2} on average, 90 % below {most:.2}, at most {worst:.2}", errors.len());
    Ok(())
}

/// Renders coats of random fibres with random colours within their reach, and the same with the inversion of Chiang et
/// al. 2016.
fn check(path: &Path, count: usize) -> Result<()> {
    let mut coat = Coat::new()?;
    let request = |number: u64| -> Result<(Fiber, [f32; 3])> {
        let fiber = random_fiber(FIRST_CHECKED + number);
        let colors = CoatColors::new(&fiber)?;
        let reachable = |seed: u64| Some(random_color(1000 * number + seed)).filter(|c| colors.nearest(*c).is_none());
        Ok((fiber, (0..1000).find_map(reachable).context("no colour is in reach")?))
    };
    let rows = rows(path, count, |number| {
        let (fiber, color) = request(number)?;
        let mut measure =
            |color| -> Result<Measured> { coat.measure(&fiber.with_color(color)?, SAMPLES, number as u32) };
        let (ours, theirs) = (measure(Color::Reflectance(color))?, measure(Color::HairReflectance(color))?);
        Ok([&ours.color[..], &[ours.error], &theirs.color].concat())
    })?;
    let mut errors = [Vec::new(), Vec::new()];
    for (number, row) in rows.iter().enumerate() {
        let (fiber, color) = request(number as u64)?;
        let error = |row: &[f64]| delta_e2000(color.map(f64::from), [row[0], row[1], row[2]]);
        let both = [error(&row[..3]), error(&row[4..])];
        println!("{number:4} {both:6.2?} {color:.3?} {:.3?} κ {:.2} {:?}", &row[..3], fiber.kappa, fiber.exit);
        errors.iter_mut().zip(both).for_each(|(all, error)| all.push(error));
    }
    for (name, mut errors) in ["reflectance", "hair_reflectance"].into_iter().zip(errors) {
        errors.sort_by(f64::total_cmp);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let [worst, most] = [errors.len() - 1, errors.len() * 9 / 10].map(|i| errors[i]);
        println!("{name}: ΔE2000 {mean:.2} on average, 90 % below {most:.2}, at most {worst:.2}");
    }
    Ok(())
}

/// Prints the colours of coats of the presets, and of hair, for an orange request.
fn presets() -> Result<()> {
    let orange = [0.8, 0.16, 0.03];
    let mut coat = Coat::new()?;
    let presets = Species::ALL.map(|species| (species.name(), Fiber::preset(species)));
    println!("| fibre | `hair_reflectance` | ΔE | `reflectance` | ΔE |\n|---|---|---|---|---|");
    for (name, fiber) in presets.into_iter().chain([("hair", Fiber::hair())]) {
        let mut row = format!("| {name} |");
        for color in [Color::HairReflectance(orange), Color::Reflectance(orange)] {
            let [r, g, b] = coat.measure(&fiber.with_color(color)?, SAMPLES, 1)?.color;
            let error = delta_e2000(orange.map(f64::from), [r, g, b]);
            write!(row, " {r:.2} {g:.2} {b:.2} | {error:.1} |")?;
        }
        println!("{row}");
    }
    Ok(())
}
