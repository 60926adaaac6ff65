//! Yan17 Sec. 4.3: where the light that the medulla scattered leaves the fibre, against the simulated fibre.

use crate::context::Context;
use crate::outcome::NOTHING;
use crate::{Claim, Outcome, Table, Verdict};
use anyhow::Result;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use vellus::{Bcsdf, Exit, Fiber, Hit, Lobe, Species, Window};
use vellus_models::direction;
use vellus_plot::sheet::{DECADES, Sheet};
use vellus_reference::simulate::scattered::{self, Scattered};

/// Cells of θ and φ: 10° × 15°.
const CELLS: [usize; 2] = [18, 24];

/// Points of the models in a cell, over θ and over φ.
const WITHIN: [usize; 2] = [8, 6];

/// The inclination of the picture, degrees.
const SHOWN: f64 = 60.0;

/// The energies of a simulated fibre, and the L1 errors of shapes, relative to the energy.
struct Row {
    /// Scattered light that leaves at its first encounter with the cuticle, and later.
    traced: [f64; 2],
    /// TTˢ + TRTˢ of the open exit.
    open: f64,
    /// Error of TTˢ + TRTˢ of the open exit.
    today: f64,
    /// The same shape, scaled to the traced energy.
    scaled: f64,
    /// Error of the first exits alone, and with the later ones.
    first: f64,
    both: f64,
    /// Error of the later exits alone.
    later: f64,
    /// Light of the reflecting exit, and its error with its own energies.
    reflecting: f64,
    model: f64,
}

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let mut outcome = Outcome::new(
        "Scattered light leaves the fibre without reflection or refraction at the cuticle: C^M has the same angles \
         inside and outside (Sec. 4.3, Eq. 19).",
    );
    let species: &[Species] = context.quality.pick(&[Species::RedFox], &Species::ALL, &Species::ALL);
    let inclinations: &[f64] = context.quality.pick(&[SHOWN], &[0.0, 30.0, 60.0, 75.0], &[0.0, 30.0, 60.0, 75.0]);
    let photons = context.quality.pick(20_000, 1_500_000, 10_000_000);
    let header = [
        "fibre",
        "θ_o",
        "scattered light",
        "first exits",
        "model, open",
        "L1 open",
        "L1 open, scaled",
        "L1 refracted",
        "L1 first exits",
        "L1 later exits",
        "model, reflecting",
        "L1 reflecting",
    ];
    let caption = "Scattered light of the simulated fibre, the part that leaves at its first encounter with the \
                   cuticle, and the light of the open model; L1 errors relative to the light, %, in cells of 10° × \
                   15°. \"Scaled\" and \"refracted\" have the traced energies, so that only shapes are compared";
    let mut table = Table::new("shapes", caption, &header);
    let (mut rows, mut fibers) = (Vec::new(), Vec::new());
    let stage = context.stage((species.len() * inclinations.len()) as u64, "tracing fibres");
    for &theta_o in inclinations {
        for &name in species {
            context.check_interrupted()?;
            // Flat scales: the simulated cuticle is smooth.
            let fiber = Fiber { alpha: 0.0, ..Fiber::published(name) };
            let traced = scattered::scattered(&fiber, theta_o.to_radians(), CELLS, photons, 1, context.progress())?;
            let (row, profiles) = compare(&fiber, theta_o, &traced)?;
            let energies = [row.traced[0] + row.traced[1], row.traced[0], row.open].map(|e| format!("{e:.4}"));
            let errors = [row.today, row.scaled, row.both, row.first, row.later].map(|e| format!("{:.1}", 100.0 * e));
            let model = [format!("{:.4}", row.reflecting), format!("{:.1}", 100.0 * row.model)];
            table.row([name.to_string(), format!("{theta_o}°")].into_iter().chain(energies).chain(errors).chain(model));
            rows.push(row);
            if theta_o == SHOWN {
                fibers.push((name.to_string(), profiles));
            }
            stage.advance(1);
        }
    }
    outcome.tables.push(table);
    let sheet = Sheet {
        title: format!(
            "Scattered light over φ (across) and θ_i (up), degrees, light from θ_o = {SHOWN}°; log scale, {DECADES} \
             decades below each simulated fibre's maximum"
        ),
        columns: ["simulated fibre", "open", "refracted"].map(str::to_owned).to_vec(),
        fibers,
        cells: [CELLS[1] / 2, CELLS[0]],
    };
    let caption = "Left: the simulated fibre. Middle: the open exit. Right: the refracted shape, with the traced \
                   energies of first and later exits.";
    outcome.pictures.push(context.draw(&sheet, "shapes", caption)?);
    claims(&mut outcome, &rows);
    outcome.notes.push(
        "The statistical error of the simulation is part of every L1 error. Later exits are compared with a density \
         ∝ cos θ_i over solid angle."
            .to_owned(),
    );
    Ok(outcome)
}

fn claims(outcome: &mut Outcome, rows: &[Row]) {
    let spread = |of: &dyn Fn(&Row) -> f64| {
        let mean = rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64;
        (mean, rows.iter().map(of).fold(0.0, f64::max))
    };
    let mut claim = |what: &str, paper: &str, ours: &str, (mean, worst): (f64, f64), holds: bool| {
        let measured = format!("L1 error {:.1} % on average", 100.0 * mean);
        let claim = Claim::new(what, measured, mean, Verdict::of(holds)).paper(paper).ours(ours);
        outcome.claims.push(claim.more(format!("{:.1} % at worst", 100.0 * worst)));
    };
    let open = spread(&|row| row.today);
    let what = "Scattered light leaves the fibre as it leaves the medulla";
    claim(what, "the same angles (Eq. 19)", "bound: L1 error 10 % on average", open, open.0 <= 0.1);
    let refracted = spread(&|row| row.both);
    let what = "Our refracted shape with the traced energies follows the whole fibre";
    let holds = refracted.0 <= 0.05 && refracted.1 <= 0.1;
    claim(what, NOTHING, "L1 error at most 5 % on average, 10 % at worst", refracted, holds);
    let model = spread(&|row| row.model);
    let what = "Our reflecting exit with its own energies follows the whole fibre";
    claim(what, NOTHING, "L1 error at most 10 % on average", model, model.0 <= 0.1);
}

/// Errors of the shapes, and the profiles of the picture over φ from 0° to 180°, per solid angle.
fn compare(fiber: &Fiber, theta_o: f64, traced: &Scattered) -> Result<(Row, Vec<Vec<f64>>)> {
    let of = |cells: &[[f64; 3]]| symmetric(cells.iter().map(|rgb| rgb[0]).collect());
    let (first, later) = (of(&traced.first), of(&traced.later));
    let all = add(&first, &later);
    let scattered = [Lobe::Tts, Lobe::Trts];
    let [open, refracted] = Exit::ALL.map(|exit| model(&fiber.with_exit(exit), theta_o, &scattered));
    let (open, refracted) = (open?, refracted?);
    // What the cuticle reflected is the part of the residual lobe that the open exit does not have.
    let [rest, more] = Exit::ALL.map(|exit| model(&fiber.with_exit(exit), theta_o, &[Lobe::Residual]));
    let reflecting: Vec<f64> =
        refracted.iter().zip(more?).zip(rest?).map(|((first, more), rest)| first + more - rest).collect();
    let (sum_first, sum_later) = (sum(&first), sum(&later));
    let (new_first, new_later) = (scale(&refracted, sum_first), scale(&diffuse(), sum_later));
    let new = add(&new_first, &new_later);
    let row = Row {
        traced: [sum_first, sum_later],
        open: sum(&open),
        today: difference(&open, &all),
        scaled: difference(&scale(&open, sum(&all)), &all),
        first: difference(&new_first, &first),
        both: difference(&new, &all),
        later: difference(&new_later, &later),
        reflecting: sum(&reflecting),
        model: difference(&reflecting, &all),
    };
    let half = |cells: &[f64]| {
        let values = |row: usize| cells[row * CELLS[1]..][..CELLS[1] / 2].iter().map(move |x| x / solid_angle(row));
        (0..CELLS[0]).flat_map(values).collect()
    };
    Ok((row, [&all, &open, &new].map(|cells| half(cells)).to_vec()))
}

/// The sum of some lobes of the far field in each cell.
fn model(fiber: &Fiber, theta_o: f64, lobes: &[Lobe]) -> Result<Vec<f64>> {
    let bcsdf = Bcsdf::new(fiber)?;
    let hit = bcsdf.at(direction(theta_o, 0.0), Window::far());
    let cells: Vec<f64> = (0..CELLS[0] * CELLS[1]).into_par_iter().map(|i| cell(&hit, lobes, i)).collect();
    Ok(symmetric(cells))
}

/// The sum of some lobes in one cell, by midpoints.
fn cell(hit: &Hit<'_>, lobes: &[Lobe], index: usize) -> f64 {
    let (row, column) = (index / CELLS[1], index % CELLS[1]);
    let mut sum = 0.0;
    for a in 0..WITHIN[0] {
        let theta = ((row * WITHIN[0] + a) as f64 + 0.5) / (CELLS[0] * WITHIN[0]) as f64 * PI - FRAC_PI_2;
        for b in 0..WITHIN[1] {
            let phi = ((column * WITHIN[1] + b) as f64 + 0.5) / (CELLS[1] * WITHIN[1]) as f64 * TAU;
            let light = hit.eval(direction(theta.to_degrees(), phi.to_degrees())).0;
            sum += theta.cos() * lobes.iter().map(|&lobe| f64::from(light[lobe as usize][0])).sum::<f64>();
        }
    }
    sum * PI * TAU / (CELLS[0] * CELLS[1] * WITHIN[0] * WITHIN[1]) as f64
}

/// θ of the lower border of a row.
fn border(row: usize) -> f64 {
    row as f64 / CELLS[0] as f64 * PI - FRAC_PI_2
}

/// The solid angle of a cell.
fn solid_angle(row: usize) -> f64 {
    (border(row + 1).sin() - border(row).sin()) * TAU / CELLS[1] as f64
}

/// Light whose density over solid angle is ∝ cos θᵢ.
fn diffuse() -> Vec<f64> {
    let below = |theta: f64| theta + theta.sin() * theta.cos();
    let row = |row: usize| below(border(row + 1)) - below(border(row));
    (0..CELLS[0] * CELLS[1]).map(|i| row(i / CELLS[1])).collect()
}

/// The mean of each cell and its mirror image in φ.
fn symmetric(cells: Vec<f64>) -> Vec<f64> {
    let mirror = |i: usize| i - i % CELLS[1] + (CELLS[1] - 1 - i % CELLS[1]);
    (0..cells.len()).map(|i| 0.5 * (cells[i] + cells[mirror(i)])).collect()
}

fn sum(cells: &[f64]) -> f64 {
    cells.iter().sum()
}

fn add(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// The same shape with another energy.
fn scale(cells: &[f64], energy: f64) -> Vec<f64> {
    let factor = energy / sum(cells).max(f64::MIN_POSITIVE);
    cells.iter().map(|x| x * factor).collect()
}

/// The L1 distance, relative to the energy of `exact`.
fn difference(values: &[f64], exact: &[f64]) -> f64 {
    let distance: f64 = values.iter().zip(exact).map(|(a, b)| (a - b).abs()).sum();
    distance / sum(exact).max(f64::MIN_POSITIVE)
}
