//! Yan17 Sec. 4.3: where the light that the medulla scattered leaves the fibre, against the simulated fibre.

use crate::context::Context;
use crate::outcome::NOTHING;
use crate::{Claim, Outcome, Picture, Table, Verdict};
use anyhow::Result;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use vellus::{Bcsdf, Fiber, Hit, Lobe, ScatterExit, Species, Window};
use vellus_models::direction;
use vellus_plot::contact::Contact;
use vellus_plot::save;
use vellus_plot::sheet::{DECADES, Sheet};
use vellus_reference::simulate::azimuth::{BINS, azimuth_error, azimuths};
use vellus_reference::simulate::energies::Offsets;
use vellus_reference::simulate::scattered::{Scattered, scattered};
use vellus_render::Display;

/// Cells of θ and φ: 10° × 15°.
const CELLS: [usize; 2] = [18, 24];

/// Points of the models in a cell, over θ and over φ.
const WITHIN: [usize; 2] = [8, 6];

/// The inclination of the picture, degrees.
const SHOWN: f64 = 60.0;

/// Inclinations of presets, degrees. At 85° the far field has numbers of its own.
const FAR: [f64; 5] = [0.0, 30.0, 60.0, 75.0, GRAZING];
const GRAZING: f64 = 85.0;

/// Inclinations and offsets of the near field of presets.
const NEAR: [f64; 2] = [0.0, SHOWN];
const HITS: [f64; 5] = [0.0, 0.3, 0.6, 0.9, 0.98];

/// Width and height of a picture of one fibre. A pixel has one offset h.
const LIT: [u32; 2] = [96, 40];

/// First exits.
const FIRST: [Lobe; 2] = [Lobe::Tts, Lobe::Trts];

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
            let traced = traced(context, &fiber, theta_o, photons)?;
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
    presets_far(context, &mut outcome, species, photons)?;
    presets_near(context, &mut outcome, species)?;
    presets_near_cells(context, &mut outcome, species)?;
    lit_from_the_side(context, &mut outcome, species)?;
    outcome.notes.push(
        "The statistical error of the simulation is part of every L1 error. Later exits are compared with a density \
         ∝ cos θ_i over solid angle."
            .to_owned(),
    );
    Ok(outcome)
}

fn claims(outcome: &mut Outcome, rows: &[Row]) {
    let spread = |of: &dyn Fn(&Row) -> f64| spread(rows.iter().map(of));
    let open = spread(&|row| row.today);
    let what = "Scattered light leaves the fibre as it leaves the medulla";
    let bound = "bound: L1 error 10 % on average";
    let open = claim(what, bound, open, open[0] <= 0.1).paper("the same angles (Eq. 19)");
    let refracted = spread(&|row| row.both);
    let what = "Our refracted shape with the traced energies follows the whole fibre";
    let holds = refracted[0] <= 0.05 && refracted[1] <= 0.1;
    let refracted = claim(what, "L1 error at most 5 % on average, 10 % at worst", refracted, holds);
    let model = spread(&|row| row.model);
    let what = "Our reflecting exit with its own energies follows the whole fibre";
    let model = claim(what, MODEL, model, model[0] <= 0.1);
    outcome.claims.extend([open, refracted, model]);
}

/// Our bound for the reflecting exit with its own energies.
const MODEL: &str = "L1 error at most 10 % on average";

/// A claim about the mean and the largest L1 error.
fn claim(what: &str, ours: &str, [mean, worst]: [f64; 2], holds: bool) -> Claim {
    let measured = format!("L1 error {:.1} % on average", 100.0 * mean);
    let more = format!("{:.1} % at worst", 100.0 * worst);
    Claim::new(what, measured, mean, Verdict::of(holds)).ours(ours).more(more)
}

/// The mean and the largest of some errors.
fn spread(errors: impl Iterator<Item = f64>) -> [f64; 2] {
    let (count, sum, worst) = errors.fold((0u32, 0.0f64, 0.0f64), |(n, sum, worst), x| (n + 1, sum + x, worst.max(x)));
    [sum / f64::from(count.max(1)), worst]
}

/// The far field of the presets, whose exit reflects.
fn presets_far(context: &Context<'_>, outcome: &mut Outcome, species: &[Species], photons: u64) -> Result<()> {
    let inclinations: &[f64] = context.quality.pick(&[SHOWN], &FAR, &FAR);
    let header = ["preset", "θ_o", "scattered light", "model", "L1"];
    let caption = "Far field of the presets: scattered light of the simulated fibre and of the model, and the L1 \
                   error relative to the light, %, in cells of 10° × 15°";
    let mut table = Table::new("presets", caption, &header);
    let mut errors = Vec::new();
    let stage = context.stage((species.len() * inclinations.len()) as u64, "tracing presets");
    for &theta_o in inclinations {
        for &name in species {
            context.check_interrupted()?;
            let fiber = Fiber { alpha: 0.0, ..Fiber::preset(name) };
            let traced = traced(context, &fiber, theta_o, photons)?;
            let all = add(&grey(&traced.first), &grey(&traced.later));
            let ours = reflecting(&fiber, theta_o, &model(&fiber, theta_o, &FIRST)?)?;
            let error = difference(&ours, &all);
            let numbers = [format!("{:.4}", sum(&all)), format!("{:.4}", sum(&ours)), format!("{:.1}", 100.0 * error)];
            table.row([name.to_string(), format!("{theta_o}°")].into_iter().chain(numbers));
            errors.push((theta_o, error));
            stage.advance(1);
        }
    }
    outcome.tables.push(table);
    let spread = |grazing: bool| spread(errors.iter().filter(|x| (x.0 == GRAZING) == grazing).map(|x| x.1));
    let [usual, grazing] = [false, true].map(spread);
    let what = "The far field of the presets follows the whole fibre, up to 75°";
    outcome.claims.push(claim(what, MODEL, usual, usual[0] <= 0.1));
    outcome.claims.push(claim("The same at 85°", MODEL, grazing, grazing[0] <= 0.1));
    Ok(())
}

/// The azimuth of the scattered light of presets in the near field.
fn presets_near(context: &Context<'_>, outcome: &mut Outcome, species: &[Species]) -> Result<()> {
    let photons = context.quality.pick(20_000, 400_000, 2_000_000);
    let offsets = HITS.map(|h| format!("h = {h}"));
    let header: Vec<&str> = ["preset", "θ_o"].into_iter().chain(offsets.iter().map(String::as_str)).collect();
    let caption = "Near field of the presets at offsets h: L1 errors of the azimuth of scattered light, relative to \
                   the light, %, in 24 bins of 15°. Rays that miss the medulla have none";
    let mut table = Table::new("near", caption, &header);
    let (mut errors, mut noise) = (Vec::new(), Vec::new());
    let stage = context.stage((species.len() * NEAR.len()) as u64, "tracing near fields");
    for theta_o in NEAR {
        for &name in species {
            let mut cells = vec![name.to_string(), format!("{theta_o}°")];
            for h in HITS {
                context.check_interrupted()?;
                let error = azimuth_error(&Fiber::preset(name), theta_o.to_radians(), h, photons, 1)?;
                if error.light[0] > 0.0 {
                    cells.push(format!("{:.1}", 100.0 * error.l1[0]));
                    errors.push(error.l1[0]);
                    noise.push(error.noise[0]);
                } else {
                    cells.push(NOTHING.to_owned());
                }
            }
            table.row(cells);
            stage.advance(1);
        }
    }
    outcome.tables.push(table);
    let [near, noise] = [errors, noise].map(|values| spread(values.into_iter()));
    let what = "The near field of the presets scatters light to the azimuths of the whole fibre";
    outcome.claims.push(claim(what, MODEL, near, near[0] <= 0.1));
    outcome.notes.push(format!(
        "Noise adds at most {:.1} % on average to the L1 errors of the near field: the L1 distance of two halves of \
         the photons, halved.",
        100.0 * noise[0]
    ));
    Ok(())
}

/// The scattered light of presets in the near field, in cells over both angles.
fn presets_near_cells(context: &Context<'_>, outcome: &mut Outcome, species: &[Species]) -> Result<()> {
    let photons = context.quality.pick(20_000, 1_000_000, 10_000_000);
    let offsets = HITS.map(|h| format!("h = {h}"));
    let header: Vec<&str> = ["preset", "θ_o"].into_iter().chain(offsets.iter().map(String::as_str)).collect();
    let caption = "Near field of the presets at offsets h: L1 errors of scattered light in cells of 10° × 15°, \
                   relative to the light, %: of first exits, and of all";
    let mut table = Table::new("near-cells", caption, &header);
    let mut errors = Vec::new();
    let stage = context.stage((species.len() * NEAR.len()) as u64, "tracing cells of near fields");
    for theta_o in NEAR {
        for &name in species {
            let fiber = Fiber { alpha: 0.0, ..Fiber::preset(name) };
            let mut row = vec![name.to_string(), format!("{theta_o}°")];
            for h in HITS {
                context.check_interrupted()?;
                let at = Offsets::At(h);
                let traced = scattered(&fiber, f64::to_radians(theta_o), at, CELLS, photons, 1, &())?;
                let [first, later] = [&traced.first, &traced.later].map(|cells| red(cells));
                let all = add(&first, &later);
                if sum(&all) == 0.0 {
                    row.push(NOTHING.to_owned());
                    continue;
                }
                let window = Window::near(h as f32);
                let [open, ours] =
                    ScatterExit::ALL.map(|exit| cells(&fiber.with_exit(exit), theta_o, window, &[Lobe::Rest]));
                let exits = cells(&fiber, theta_o, window, &FIRST)?;
                let rest: Vec<f64> = ours?.iter().zip(open?).map(|(ours, open)| ours - open).collect();
                let found = [difference(&exits, &first), difference(&add(&exits, &rest), &all)];
                row.push(found.map(|error| format!("{:.1}", 100.0 * error)).join(", "));
                errors.push(found[1]);
            }
            table.row(row);
            stage.advance(1);
        }
    }
    outcome.tables.push(table);
    let found = spread(errors.into_iter());
    let what = "The near field of the presets scatters light into the cells of the whole fibre";
    outcome.claims.push(claim(what, "bound: L1 error 15 % on average", found, found[0] <= 0.15));
    Ok(())
}

/// Fibres across their width under a light from the side, which covers 30° of azimuth and all inclinations.
fn lit_from_the_side(context: &Context<'_>, outcome: &mut Outcome, species: &[Species]) -> Result<()> {
    let photons = context.quality.pick(2_000, 60_000, 1_000_000);
    let quarter = BINS / 4;
    let lit = |bins: &[[f64; 3]]| (quarter - 1..=quarter).fold([0.0; 3], |a, b| [0, 1, 2].map(|c| a[c] + bins[b][c]));
    let mut pictures = Vec::new();
    let stage = context.stage(species.len() as u64, "tracing fibres lit from the side");
    for &name in species {
        context.check_interrupted()?;
        let fiber = Fiber::preset(name);
        let pixel = |x: u32| -> Result<[[f64; 3]; 3]> {
            let h = (f64::from(x) + 0.5) / f64::from(LIT[0]) * 2.0 - 1.0;
            let traced = scattered(&fiber, 0.0, Offsets::At(h), [1, BINS], photons, u64::from(x), &())?;
            let both = traced.first.iter().zip(&traced.later);
            let traced: Vec<[f64; 3]> = both.map(|(a, b)| [0, 1, 2].map(|c| a[c] + b[c])).collect();
            let [open, reflecting] = ScatterExit::ALL.map(|exit| azimuths(&fiber.with_exit(exit), 0.0, h));
            Ok([lit(&traced), lit(&open?), lit(&reflecting?)])
        };
        let row: Vec<[[f64; 3]; 3]> = (0..LIT[0]).into_par_iter().map(pixel).collect::<Result<_>>()?;
        let white = row.iter().flatten().flatten().fold(1e-30, |a, &b| b.max(a));
        pictures.extend((0..3).map(|k| {
            let line = row.iter().map(|pixel| Display::srgb(0.0).encode(pixel[k].map(|x| x / white), 1.0));
            line.collect::<Vec<_>>().repeat(LIT[1] as usize)
        }));
        stage.advance(1);
    }
    let sheet = Contact {
        title: "Scattered light of fibres lit from the left".to_owned(),
        labels: [
            species.iter().map(ToString::to_string).collect(),
            ["simulated", "open", "reflecting"].map(str::to_owned).to_vec(),
        ],
        size: LIT,
        pictures,
    };
    let caption = "Light that the medulla scattered, across the width of a fibre of each preset. A light at the side \
                   covers 30° of azimuth. Left: the simulated fibre. Middle: the open exit, as in the paper. Right: \
                   the default. The brightest pixel of each row is white.";
    save(&sheet, &[context.path("side.png")])?;
    outcome.pictures.push(Picture::new("side.png".to_owned(), caption));
    Ok(())
}

/// The scattered light of the simulated fibre in the far field.
fn traced(context: &Context<'_>, fiber: &Fiber, theta_o: f64, photons: u64) -> Result<Scattered> {
    Ok(scattered(fiber, theta_o.to_radians(), Offsets::Whole, CELLS, photons, 1, context.progress())?)
}

/// The first channel in each cell.
fn red(cells: &[[f64; 3]]) -> Vec<f64> {
    cells.iter().map(|rgb| rgb[0]).collect()
}

/// The first channel in each cell of the far field.
fn grey(cells: &[[f64; 3]]) -> Vec<f64> {
    symmetric(red(cells))
}

/// Errors of the shapes, and the profiles of the picture over φ from 0° to 180°, per solid angle.
fn compare(fiber: &Fiber, theta_o: f64, traced: &Scattered) -> Result<(Row, Vec<Vec<f64>>)> {
    let (first, later) = (grey(&traced.first), grey(&traced.later));
    let all = add(&first, &later);
    let [open, refracted] = ScatterExit::ALL.map(|exit| model(&fiber.with_exit(exit), theta_o, &FIRST));
    let (open, refracted) = (open?, refracted?);
    let reflecting = reflecting(fiber, theta_o, &refracted)?;
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

/// Scattered light of the reflecting exit: its first exits, and what the cuticle reflected. That is the part of the
/// rest lobe that the open exit does not have.
fn reflecting(fiber: &Fiber, theta_o: f64, first: &[f64]) -> Result<Vec<f64>> {
    let [rest, more] = ScatterExit::ALL.map(|exit| model(&fiber.with_exit(exit), theta_o, &[Lobe::Rest]));
    Ok(first.iter().zip(more?).zip(rest?).map(|((first, more), rest)| first + more - rest).collect())
}

/// The sum of some lobes of the far field in each cell.
fn model(fiber: &Fiber, theta_o: f64, lobes: &[Lobe]) -> Result<Vec<f64>> {
    Ok(symmetric(cells(fiber, theta_o, Window::far(), lobes)?))
}

/// The sum of some lobes over a window in each cell.
fn cells(fiber: &Fiber, theta_o: f64, window: Window, lobes: &[Lobe]) -> Result<Vec<f64>> {
    let bcsdf = Bcsdf::new(fiber)?;
    let hit = bcsdf.at(direction(theta_o, 0.0), window);
    Ok((0..CELLS[0] * CELLS[1]).into_par_iter().map(|i| cell(&hit, lobes, i)).collect())
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
