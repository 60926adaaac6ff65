//! Fits synthetic measurements of the ten species and prints the results: `cargo run --release --bin
//! ten_species [-- SEEDS PHOTONS]` (0 photons: the models alone). It fits each model to measurements of the model
//! itself (2 % noise, 10 % gaps), then our model to the traced whole fibre. For both, it prints how much of the
//! variation each model explains.

use std::time::Instant;
use vellus::{Fiber, Species};
use vellus_fit::{Fit, Forward, Options, Profile, Specimen, State, Synthetic, fit, simulate};

/// User and system time of this process so far, seconds, and its peak memory, MB (Linux).
fn process() -> (f64, f64) {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let stat = read("/proc/self/stat");
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or("").split_whitespace().collect();
    // Clock ticks of 10 ms; fields 14 and 15 of the whole line.
    let ticks = |i: usize| fields.get(i).and_then(|x| x.parse::<f64>().ok()).unwrap_or(0.0);
    let peak = read("/proc/self/status");
    let peak =
        peak.lines().find_map(|l| l.strip_prefix("VmHWM:")?.trim().strip_suffix("kB")?.trim().parse::<f64>().ok());
    ((ticks(11) + ticks(12)) / 100.0, peak.unwrap_or(0.0) / 1000.0)
}

fn run(model: Forward, profile: &Profile) -> (Fit, f64, f64) {
    let (start, cpu) = (Instant::now(), process().0);
    let result = fit(std::slice::from_ref(profile), model, &Options::default(), &()).expect("the profile is valid");
    (result, start.elapsed().as_secs_f64(), process().0 - cpu)
}

/// How much of a profile's variation each model explains, and which models do not fit.
fn explained(profile: &Profile) -> String {
    let of = |model: &Forward| {
        let result = run(*model, profile).0;
        let verdict = if result.no_fit.is_some() { " (no fit)" } else { "" };
        format!("{} {:.1} %{verdict}", model.kind(), 100.0 * result.explained.share)
    };
    Forward::ALL.iter().map(of).collect::<Vec<_>>().join(", ")
}

/// Fits a model to its own measurements.
fn own(model: Forward, seeds: u64) {
    println!("{}, fitted to itself: errors in standard errors; in brackets: not determined", model.kind());
    let (mut squares, mut count, mut worst) = (0.0, 0, 0.0f64);
    let (mut times, mut longest) = (0.0, [0.0f64; 2]);
    for (seed, species) in (1..=seeds).flat_map(|seed| Species::ALL.map(|species| (seed, species))) {
        let truth = Fiber::preset(species);
        // The index of the medulla differs from that of the cortex, if the model has it.
        let eta_m = truth.eta - 0.08;
        let synthetic = Synthetic { seed, scale: 37.0, ..Synthetic::default() };
        let specimen = Specimen { fiber: truth, eta_m: Some(eta_m) };
        let profile = simulate::from_model(model, &specimen, &synthetic).expect("the preset is valid");
        let (result, seconds, cpu) = run(model, &profile);
        times += cpu;
        longest = [longest[0].max(seconds), longest[1].max(cpu)];
        let of = |name: &str| match name {
            "kappa" => truth.kappa,
            "eta" => truth.eta,
            "eta_m" => eta_m,
            "alpha" => truth.alpha.to_degrees(),
            "beta_m" => truth.beta_m.to_degrees(),
            "beta_n" => truth.beta_n.to_degrees(),
            "sigma_ca" => truth.sigma_ca[0],
            "sigma_ms" => truth.sigma_ms,
            "sigma_ma" => truth.sigma_ma[0],
            "g" => truth.g,
            "layers" => truth.layers,
            _ => 37.0,
        };
        let mut cells = String::new();
        for e in result.estimates.iter().filter(|e| e.state != State::Fixed) {
            let off = e.value - f64::from(of(&e.name));
            let z = e.error.map_or(f64::NAN, |error| off / error);
            if e.determined {
                squares += z * z;
                count += 1;
                worst = worst.max(z.abs());
                cells += &format!(" {}{z:+.1}", e.name);
            } else {
                cells += &format!(" ({}{z:+.1})", e.name);
            }
        }
        println!(
            "{:<10} NRMSE {:.2} % log {:.2} %; {seconds:.1} s, {cpu:.1} CPU-s; {:?} starts; widened {:.2};{cells}",
            species.name(),
            100.0 * result.nrmse,
            100.0 * result.log_nrmse,
            result.starts,
            result.widened,
        );
    }
    println!(
        "{count} errors of determined parameters: rms {:.2}, largest {worst:.1}; {:.1} CPU-s a fit, at most {:.1} CPU-s and {:.1} s\n",
        (squares / f64::from(count)).sqrt(),
        times / (10 * seeds) as f64,
        longest[1],
        longest[0]
    );
}

fn main() {
    let argument = |i: usize, default: u64| std::env::args().nth(i).and_then(|x| x.parse().ok()).unwrap_or(default);
    let (seeds, photons) = (argument(1, 1), argument(2, 4_000_000));
    Forward::ALL.into_iter().for_each(|model| own(model, seeds));
    println!("from our model, explained by each");
    for species in Species::ALL {
        let synthetic = Synthetic { step: [4.0, 4.0], ..Synthetic::default() };
        let profile = simulate::from_model(Forward::default(), &Fiber::preset(species).into(), &synthetic);
        println!("{:<10} {}", species.name(), explained(&profile.expect("the preset is valid")));
    }
    println!("\nfrom the whole fibre, {photons} photons");
    for species in Species::ALL.into_iter().filter(|_| photons > 0) {
        let truth = Fiber::published(species);
        let synthetic = Synthetic { step: [4.0, 4.0], ..Synthetic::default() };
        let start = Instant::now();
        let profile = simulate::from_reference(&truth, &synthetic, photons, &()).expect("the preset is valid");
        let traced = start.elapsed().as_secs_f64();
        let (result, seconds, cpu) = run(Forward::default(), &profile);
        let values: Vec<String> = result
            .estimates
            .iter()
            .filter(|e| e.state != State::Fixed)
            .map(|e| format!("{} {:.3}", e.name, e.value))
            .collect();
        println!(
            "{:<10} NRMSE {:.2} % log {:.2} %; traced in {traced:.1} s, {seconds:.1} s, {cpu:.1} CPU-s; noise {:.3}, neighbours {:.2} {:.2}; {}",
            species.name(),
            100.0 * result.nrmse,
            100.0 * result.log_nrmse,
            result.noise,
            result.neighbours[0],
            result.neighbours[1],
            values.join(", ")
        );
        println!("{:<10} explained by {}", "", explained(&profile));
    }
    println!("\nlargest memory {:.0} MB", process().1);
}
