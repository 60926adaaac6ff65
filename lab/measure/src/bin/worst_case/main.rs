//! Finds the worst case of each accuracy statement over all valid fibres, inclinations and windows.
//!
//! ```sh
//! cargo run --release --bin worst_case                            # all quantities, on one core
//! cargo run --release --bin worst_case -- far-scattered --fibers 5000
//! ```
//!
//! The program measures each quantity at random points of the parameter space. It then climbs from the points with the
//! largest errors. There are two kinds of error: relative to the lobes concerned, and relative to all light. The
//! results are measured again with two finer integrations, to show that the integration has converged.
//!
//! Options: `--fibers N` random points, `--starts N` climbs for each kind of error, `--steps N` of each climb, `--seed
//! N`. A part of the space: `--eta LOW:HIGH`, `--beta-n LOW:HIGH` and `--theta-o LOW:HIGH` in degrees, `--g LOW:HIGH`,
//! and `--grey` for absorption that is the same in all channels. `--exit NAME`: reflecting, the default, or open.

mod measure;
mod search;
mod space;

use measure::{Effort, Error};
use search::{Random, climb, distribution};
use space::{Case, Limits, Offsets, Point};
use std::process::ExitCode;
use std::time::Instant;
use vellus::{Error as FiberError, Fiber, ScatterExit, Species, TableData, Tables, grid};

/// The quantities to search.
struct Quantity {
    name: &'static str,
    what: &'static str,
    offsets: Offsets,
    error: fn(&TableData, &Case, Effort) -> Error,
}

const QUANTITIES: [Quantity; 7] = [
    Quantity {
        name: "far-unscattered",
        what: "far field, L1 of R + TT + TRT",
        offsets: Offsets::Far,
        error: measure::unscattered,
    },
    Quantity {
        name: "far-scattered",
        what: "far field, L1 of TTs + TRTs",
        offsets: Offsets::Far,
        error: measure::scattered,
    },
    Quantity {
        name: "far-energy",
        what: "far field, energy of the worst of the six lobes",
        offsets: Offsets::Far,
        error: measure::energy,
    },
    Quantity {
        name: "window-unscattered",
        what: "random windows, L1 of R + TT + TRT",
        offsets: Offsets::Window,
        error: measure::unscattered,
    },
    Quantity {
        name: "window-scattered",
        what: "random windows, L1 of TTs + TRTs",
        offsets: Offsets::Window,
        error: measure::scattered,
    },
    Quantity {
        name: "window-energy",
        what: "random windows, energy of the worst of the six lobes",
        offsets: Offsets::Window,
        error: measure::energy,
    },
    Quantity {
        name: "near",
        what: "near field in single precision: value relative to the hit's peak; energy of a lobe relative to all \
         light",
        offsets: Offsets::Near,
        error: |tables, case, effort| measure::near(tables, case, effort.points / 2),
    },
];

struct Options {
    names: Vec<String>,
    fibers: usize,
    starts: usize,
    steps: usize,
    seed: u64,
    limits: Limits,
    exit: ScatterExit,
}

/// Selects a number of an error.
type Measure = fn(&Error) -> f64;

/// Reads a whole number.
fn number(word: &str, value: Option<String>) -> Result<usize, String> {
    let value = value.ok_or(format!("{word} needs a number"))?;
    value.parse().map_err(|_| format!("{word} needs a number, not {value}"))
}

/// Reads LOW:HIGH.
fn range(word: &str, value: Option<String>) -> Result<[f64; 2], String> {
    let value = value.ok_or(format!("{word} needs LOW:HIGH"))?;
    let ends = value.split_once(':').and_then(|(low, high)| Some([low.parse().ok()?, high.parse().ok()?]));
    ends.filter(|[low, high]| low <= high).ok_or(format!("{word} needs LOW:HIGH, not {value}"))
}

/// Reads the command line.
fn options() -> Result<Options, String> {
    let (names, limits, exit) = (Vec::new(), Limits::NONE, ScatterExit::default());
    let mut options = Options { names, fibers: 4000, starts: 8, steps: 300, seed: 1, limits, exit };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--fibers" => options.fibers = number(&word, words.next())?.max(1),
            "--starts" => options.starts = number(&word, words.next())?,
            "--steps" => options.steps = number(&word, words.next())?,
            "--seed" => options.seed = number(&word, words.next())? as u64,
            "--eta" => options.limits.eta = range(&word, words.next())?,
            "--beta-n" => options.limits.beta_n = range(&word, words.next())?,
            "--g" => options.limits.g = range(&word, words.next())?,
            "--theta-o" => options.limits.theta_o = range(&word, words.next())?,
            "--exit" => {
                options.exit = words.next().unwrap_or_default().parse().map_err(|e: FiberError| e.to_string())?
            }
            "--grey" => options.limits.grey = true,
            name if ["presets", "tables"].contains(&name) || QUANTITIES.iter().any(|q| q.name == name) => {
                options.names.push(word)
            }
            _ => {
                let names = QUANTITIES.map(|q| q.name).join(", ");
                return Err(format!("{word} is not an option, and none of {names}, presets, tables"));
            }
        }
    }
    Ok(options)
}

fn percent(values: [f64; 4]) -> String {
    let [mean, p95, p99, worst] = values.map(|x| format!("{:.4} %", 100.0 * x));
    format!("mean {mean}, 95th percentile {p95}, 99th {p99}, worst {worst}")
}

fn search(tables: &TableData, quantity: &Quantity, options: &Options) {
    let start = Instant::now();
    let case = |x: &Point| Case::at(x, quantity.offsets, options.limits.grey, options.exit);
    // Points outside the limits have no error.
    let measure = |x: &Point, effort| {
        let case = case(x);
        if options.limits.hold(&case) { (quantity.error)(tables, &case, effort) } else { Error::default() }
    };
    let mut random = Random::new(options.seed);
    let mut points: Vec<(Point, Error)> = Vec::new();
    while points.len() < options.fibers {
        let x = random.point();
        if options.limits.hold(&case(&x)) {
            points.push((x, measure(&x, Effort::SEARCH)));
        }
    }
    println!("{}: {}", quantity.name, quantity.what);
    let kinds: [(&str, Measure); 2] =
        [("relative to these lobes", |e| e.relative), ("relative to all light", |e| e.of_all)];
    for (kind, value) in kinds {
        let values: Vec<f64> = points.iter().map(|(_, e)| value(e)).collect();
        println!("  {} random fibres, {kind}: {}", options.fibers, percent(distribution(&values)));
    }
    for (kind, value) in kinds {
        points.sort_by(|a, b| value(&b.1).total_cmp(&value(&a.1)));
        let mut worst: Option<(Point, f64)> = None;
        for (x, e) in points.iter().take(options.starts) {
            let found = climb(*x, value(e), options.steps, &mut random, |x| value(&measure(x, Effort::SEARCH)));
            if worst.is_none_or(|(_, most)| found.1 > most) {
                worst = Some(found);
            }
        }
        if let Some((x, _)) = worst {
            let [fine, check] = [Effort::FINAL, Effort::CHECK].map(|effort| measure(&x, effort));
            println!(
                "  worst {kind}: {:.4} % (these lobes {:.4} %, all light {:.4} %; integrated finer {:.4} %)",
                100.0 * value(&fine),
                100.0 * fine.relative,
                100.0 * fine.of_all,
                100.0 * value(&check)
            );
            println!("    {}", case(&x));
        }
    }
    println!("  {:.0} s", start.elapsed().as_secs_f64());
}

/// C^N at h″ = 0 over a grid of τ and g.
fn tables_at_the_axis(tables: &TableData) {
    const NODES: usize = 47;
    let position = |i: usize| i as f64 / (NODES - 1) as f64;
    let (mut moved, mut ratios, mut worst) = (Vec::new(), Vec::new(), (0.0, 0.0, 0.0));
    for i in 0..NODES {
        for j in 0..NODES {
            let (tau, g) = (grid::tau_at(position(i)), grid::g_at(position(j)));
            let [l1, ratio] = measure::asymmetry(tables, tau, g);
            if l1 > worst.0 {
                worst = (l1, tau, g);
            }
            moved.push(l1);
            ratios.push(ratio);
        }
    }
    println!("tables: C^N at h″ = 0, {NODES} x {NODES} values of τ and g");
    println!("  L1 of what is not symmetric: {}", percent(distribution(&moved)));
    println!("  ratio of mirrored values, median over azimuths: mean, 95th, 99th, worst {:.4?}", distribution(&ratios));
    println!("  worst at τ {:.4}, g {:.4}", worst.1, worst.2);
}

/// The far field of ten species at four inclinations, grey as measured, and with three colours of the cortex.
fn presets(tables: &TableData, exit: ScatterExit) {
    println!("presets, exit {exit}: far field at θ_o = 0°, 30°, 60°, 80°, L1 of R + TT + TRT, and of TTs + TRTs");
    for colour in [None, Some([0.2, 0.4, 0.8]), Some([0.5, 1.0, 3.0])] {
        let (mut unscattered, mut scattered) = (Vec::new(), Vec::new());
        for species in Species::ALL {
            let fiber = if exit == ScatterExit::Open { Fiber::published(species) } else { Fiber::preset(species) };
            let fiber = colour.map_or(fiber, |colour| fiber.with_absorption(colour));
            for degrees in [0.0f64, 30.0, 60.0, 80.0] {
                let case = Case { fiber, theta_o: degrees.to_radians(), window: [-1.0, 1.0] };
                unscattered.push(measure::unscattered(tables, &case, Effort::FINAL).relative);
                scattered.push(measure::scattered(tables, &case, Effort::FINAL).relative);
            }
        }
        println!("  sigma_ca {colour:?}, R + TT + TRT: {}", percent(distribution(&unscattered)));
        println!("  sigma_ca {colour:?}, TTs + TRTs: {}", percent(distribution(&scattered)));
    }
}

fn main() -> ExitCode {
    let options = match options() {
        Ok(options) => options,
        Err(message) => {
            eprintln!("worst_case: {message}");
            return ExitCode::from(2);
        }
    };
    let tables = match TableData::from_bytes(Tables::SHIPPED) {
        Ok(tables) => tables,
        Err(message) => {
            eprintln!("worst_case: {message}");
            return ExitCode::from(2);
        }
    };
    let asked = |name: &str| options.names.is_empty() || options.names.iter().any(|n| n == name);
    for quantity in QUANTITIES.iter().filter(|q| asked(q.name)) {
        search(&tables, quantity, &options);
    }
    if asked("presets") {
        presets(&tables, options.exit);
    }
    if asked("tables") {
        tables_at_the_axis(&tables);
    }
    ExitCode::SUCCESS
}
