//! Errors of aggregates beside simulated bunches, as tables in Markdown:
//! `cargo run --release -p vellus-aggregate --features simulation --example errors -- [PATHS [TABLE...]]`.
//!
//! PATHS is the number of paths that meet a fibre. Tables are media, bunches, spreads and noise.
//!
//! Azimuth and inclination: Σ |aggregate − bunch| / Σ bunch over 36 cells of 5°. Energy: the same for the energy of
//! light that meets a fibre. All in per cent. They include the noise of the simulation.

use vellus::{Fiber, Model, Species, Window, direction};
use vellus_aggregate::simulation::{Collision, Fibers, Places, Profile};
use vellus_aggregate::{Aggregate, Bunch, Error};

const THETAS: [f64; 4] = [0.0, 30.0, 60.0, 80.0];
const TAUS: [f64; 5] = [0.1, 0.5, 2.0, 6.0, 12.0];

/// Errors over azimuth, over inclination, and of the energy.
type Errors = [f64; 3];

/// Prints a table, from a number of paths.
type Table = fn(u64) -> Result<(), Error>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let paths = arguments.first().map_or(Ok(100_000), |text| text.parse())?;
    let asked = |name: &str| arguments.len() < 2 || arguments[1..].iter().any(|other| other == name);
    let tables: [(&str, Table); 4] = [("noise", noise), ("media", media), ("bunches", bunches), ("spreads", spreads)];
    tables.into_iter().filter(|(name, _)| asked(name)).try_for_each(|(_, table)| table(paths))?;
    Ok(())
}

/// What two simulations of the same bunch differ by, over √2.
fn noise(paths: u64) -> Result<(), Error> {
    let places = Places::Medium(2.0);
    let fibers = Fibers { fiber: Fiber::preset(Species::Dog), places, collision: Collision::Far, spread: 0.0 };
    let [a, b] = [1, 2].map(|seed| fibers.scatter(0.5, seed, paths * 5 / 4));
    let noise = a?.profile.difference(&b?.profile).map(|x| 100.0 * x * 0.5f64.sqrt());
    println!("Noise: {noise:.2?}\n");
    Ok(())
}

fn hair(sigma_ca: [f32; 3]) -> Fiber {
    Fiber::hair().with_absorption(sigma_ca)
}

/// Thin fibres: the errors of the model itself.
fn media(paths: u64) -> Result<(), Error> {
    println!("| fibre | τ = {} |", TAUS.map(|tau| tau.to_string()).join(" | "));
    println!("|---|{}", "---|".repeat(TAUS.len()));
    let mut fibers: Vec<(String, Fiber)> =
        Species::ALL.iter().map(|species| (species.name().to_owned(), Fiber::preset(*species))).collect();
    fibers.push(("cat without pigment".to_owned(), Fiber::preset(Species::Cat).without_absorption()));
    fibers.push(("light hair".to_owned(), hair([0.02, 0.05, 0.1])));
    fibers.push(("dark hair".to_owned(), hair([0.5, 0.8, 1.2])));
    let mut all: Vec<(Errors, String)> = Vec::new();
    for (name, fiber) in fibers {
        print!("| {name} |");
        for tau in TAUS {
            let fibers = Fibers { fiber, places: Places::Medium(tau), collision: Collision::Far, spread: 0.0 };
            let mut errors = Vec::new();
            for theta in THETAS {
                let error = compare(&fibers, Bunch::new(tau)?, theta, paths)?;
                all.push((error, format!("{name}, τ {tau}, θ_o {theta}°")));
                errors.push(error);
            }
            let [azimuth, inclination, energy] = mean(&errors);
            print!(" {azimuth:.1}, {inclination:.1}, {energy:.1} |");
        }
        println!();
    }
    println!("\nMean {:.2?}", mean(&all.iter().map(|(errors, _)| *errors).collect::<Vec<_>>()));
    for (k, what) in ["azimuth", "inclination", "energy"].into_iter().enumerate() {
        if let Some((errors, name)) = all.iter().max_by(|a, b| a.0[k].total_cmp(&b.0[k])) {
            println!("Worst {what}: {:.1} ({name})", errors[k]);
        }
    }
    Ok(())
}

/// Explicit fibres with their near field.
fn bunches(paths: u64) -> Result<(), Error> {
    println!(
        "\n| fibre | n, f | places | passes: bunch, formula | far field | near field |\n|---|---|---|---|---|---|"
    );
    for (name, fiber) in [
        ("dog", Fiber::preset(Species::Dog)),
        ("raccoon", Fiber::preset(Species::Raccoon)),
        ("light hair", hair([0.02, 0.05, 0.1])),
        ("dark hair", hair([0.5, 0.8, 1.2])),
    ] {
        for (count, fill) in [(16, 0.06), (64, 0.06), (256, 0.06), (256, 0.12)] {
            let radius = (fill / f64::from(count)).sqrt();
            for (label, places, bunch) in [
                ("overlapping", Places::Overlapping(count, fill), Bunch::overlapping(count, radius, 1.0)?),
                ("separate", Places::Separate(count, fill), Bunch::separate(count, radius, 1.0)?),
            ] {
                let fibers = |collision| Fibers { fiber, places, collision, spread: 0.0 };
                let text = |collision| -> Result<String, Error> {
                    let [azimuth, inclination, energy] = compare(&fibers(collision), bunch, 30.0, paths)?;
                    Ok(format!("{azimuth:.1}, {inclination:.1}, {energy:.1}"))
                };
                let passes = fibers(Collision::Far).scatter(0.5, 3, paths)?.passes;
                println!(
                    "| {name} | {count}, {fill} | {label} | {passes:.3}, {:.3} | {} | {} |",
                    bunch.mean_passes(),
                    text(Collision::Far)?,
                    text(Collision::Near)?
                );
            }
        }
    }
    Ok(())
}

/// Members that point in different directions.
fn spreads(paths: u64) -> Result<(), Error> {
    println!("\n| fibre | τ | spread | errors | errors with parallel members |\n|---|---|---|---|---|");
    for (name, fiber) in [
        ("dog", Fiber::preset(Species::Dog)),
        ("light hair", hair([0.02, 0.05, 0.1])),
        ("dark hair", hair([0.5, 0.8, 1.2])),
    ] {
        for (tau, spread) in [(0.5, 0.1), (0.5, 0.2), (4.0, 0.1), (4.0, 0.2)] {
            let fibers = Fibers { fiber, places: Places::Medium(tau), collision: Collision::Far, spread };
            let bunch = Bunch::new(tau)?;
            let text = |bunch| -> Result<String, Error> {
                let [azimuth, inclination, energy] = compare(&fibers, bunch, 30.0, paths)?;
                Ok(format!("{azimuth:.1}, {inclination:.1}, {energy:.1}"))
            };
            println!("| {name} | {tau} | {spread} | {} | {} |", text(bunch.with_spread(spread)?)?, text(bunch)?);
        }
    }
    Ok(())
}

/// Errors of an aggregate in per cent.
fn compare(fibers: &Fibers, bunch: Bunch, theta: f64, paths: u64) -> Result<Errors, Error> {
    let aggregate = Aggregate::new(&fibers.fiber, bunch)?;
    let theta = theta.to_radians();
    let modelled = Profile::of(&aggregate.at(direction(theta, 0.0), Window::far()));
    let all = paths as f64 / (1.0 - bunch.mean_passes());
    let simulated = fibers.scatter(theta, 7, all as u64)?.profile;
    let [azimuth, inclination] = modelled.difference(&simulated);
    let (a, b) = (modelled.energy(), simulated.energy());
    let energy = (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f64>() / b.iter().sum::<f64>();
    Ok([azimuth, inclination, energy].map(|x| 100.0 * x))
}

fn mean(errors: &[Errors]) -> Errors {
    std::array::from_fn(|k| errors.iter().map(|e| e[k]).sum::<f64>() / errors.len() as f64)
}
