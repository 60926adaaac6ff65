//! `vellus fit`: a measured profile to the parameters of a fibre, and synthetic measurements.

mod simulate;

use crate::interrupt::Interrupt;
use crate::output;
use crate::say::note;
use crate::terminal::Terminal;
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use vellus_fit::{Angles, Axis, Forward, Name, Options, Quantity, Reading, Requests};
use vellus_models::ModelKind;
use vellus_plot::fit::{Summary, write_report};

/// Fit a fibre's parameters to its measured profile (Yan17 Sec. 5.1), or write a synthetic measurement.
///
/// PROFILE is light scattered by one fibre, averaged over its width, while one of camera and light is fixed and the other moves: lines
/// `phi theta value` or `phi theta r g b` (.txt, in the gantry's coordinates of Yan et al. 2015; `?` for missing), CSV with columns
/// theta, phi and value or r, g, b, or an image (.npy, .exr) with rows over theta and columns over phi. Its unit is arbitrary.
/// Ctrl-C leaves the best so far, marked as such.
///
/// Where the model explains the measurements no better than a constant does (an F-test at a false-alarm rate of 0.1
/// %), or less than half of their variation and what it leaves is not noise, or where no parameter of the fibre is
/// determined, there is no fit: exit code 2, and no fibre is written.
///
/// --model chiang2016, marschner2003 or yan2015 fits an earlier model in place of ours. Parameters that it does not have are left out.
#[derive(clap::Args)]
pub struct Args {
    /// The measured profile: .txt, .csv, .npy or .exr.
    #[arg(required_unless_present = "simulate", conflicts_with = "simulate")]
    profile: Option<PathBuf>,
    /// The model to fit, or to measure synthetically: vellus (ours), yan2015 (with a refractive index of the medulla, eta_m), chiang2016,
    /// marschner2003 (both without medulla); or without the years.
    #[arg(long, default_value = "vellus", value_name = "NAME")]
    model: String,
    /// Where to write the fibre (.toml), or the synthetic measurement (.txt or .csv).
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Folder for a report: index.html with pictures of the measured and the fitted profile and their ratio, and profile.csv.
    #[arg(long, value_name = "DIR", conflicts_with = "simulate")]
    report: Option<PathBuf>,
    /// How the result is written to standard output.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// Inclination of the direction that is fixed, degrees; the file may say it: `# theta_o = -30`.
    #[arg(long, allow_negative_numbers = true, value_name = "DEG")]
    theta_o: Option<f64>,
    /// What the file's angles mean: those of the fibre, or of the gantry of Yan et al. 2015 (theta is 90° less its theta, phi its phi
    /// less 90°). Without it: the gantry's in .txt, the fibre's otherwise.
    #[arg(long, value_enum, conflicts_with = "simulate")]
    angles: Option<AnglesArg>,
    /// What the values are proportional to: f·cos θ (a fixed camera and a light that moves, or a moving detector that sees the whole
    /// fibre) or f (a moving camera's radiance). Without it: what the file says, or f-cos.
    #[arg(long, value_enum, conflicts_with = "simulate")]
    quantity: Option<QuantityArg>,
    /// θ of the first and last row of an image, or of a synthetic measurement, degrees.
    #[arg(long, value_parser = range, allow_hyphen_values = true, value_name = "FIRST:LAST")]
    theta: Option<[f64; 2]>,
    /// φ of the first and last column, degrees.
    #[arg(long, value_parser = range, allow_hyphen_values = true, value_name = "FIRST:LAST")]
    phi: Option<[f64; 2]>,
    /// Hold a parameter: eta=1.55, or sigma_ca=0.1,0.2,0.4 of an RGB profile; scale=1 for an absolute measurement. May be repeated.
    #[arg(long, value_name = "NAME=VALUE", conflicts_with = "simulate")]
    fix: Vec<String>,
    /// Give the first parameter the value of the second: beta_n=beta_m, sigma_ma.r=sigma_ma.g. May be repeated.
    #[arg(long, value_name = "NAME=NAME", conflicts_with = "simulate")]
    tie: Vec<String>,
    /// Fit what usually is not: theta_o. May be repeated.
    #[arg(long, value_name = "NAME", conflicts_with = "simulate")]
    free: Vec<String>,
    /// Descents begun: from the presets, and from the best of a space-filling design.
    #[arg(long, value_name = "N", conflicts_with = "simulate", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    starts: Option<u32>,
    /// Residuals above that many times the noise count linearly, not squared (Huber's loss); inf for plain least squares.
    #[arg(long, value_name = "K", conflicts_with = "simulate")]
    huber: Option<f64>,
    /// Accept what is no fit: of measurements that a constant follows as well, or that the model does not follow. The
    /// fibre and the report are marked NO FIT.
    #[arg(long, conflicts_with = "simulate")]
    allow_bad_fit: bool,
    /// Seed of starts, or of noise, gaps and photons.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    synthetic: simulate::Gantry,
}

/// How a result is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// For people.
    Table,
    /// One object.
    Json,
}

/// [`Angles`] on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum AnglesArg {
    Fiber,
    Gantry,
}

/// [`Quantity`] on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum QuantityArg {
    FCos,
    F,
}

fn range(text: &str) -> Result<[f64; 2]> {
    let (first, last) = text.split_once(':').context("expected FIRST:LAST, such as 10:50")?;
    let number = |x: &str| x.trim().parse::<f64>().with_context(|| format!("'{x}' is not a number"));
    Ok([number(first)?, number(last)?])
}

/// NAME=… of an option.
fn pair<'a>(option: &str, text: &'a str) -> Result<(&'a str, &'a str)> {
    let (name, value) = text.split_once('=').with_context(|| format!("--{option} {text}: expected NAME=…"))?;
    Ok((name.trim(), value.trim()))
}

/// The parameter that an option names.
fn named(option: &str, name: &str) -> Result<Name> {
    name.trim().parse().with_context(|| format!("in --{option}"))
}

impl Args {
    fn forward(&self) -> Result<Forward> {
        Ok(Forward::new(self.model.parse::<ModelKind>()?)?)
    }

    fn reading(&self) -> Result<Reading> {
        let axes = match (self.theta, self.phi) {
            (Some(theta), Some(phi)) => Some([theta, phi].map(|[first, last]| Axis { first, last })),
            (None, None) => None,
            _ => bail!("--theta and --phi belong together"),
        };
        Ok(Reading {
            theta_o: self.theta_o,
            angles: self.angles.map(|a| match a {
                AnglesArg::Fiber => Angles::Fiber,
                AnglesArg::Gantry => Angles::Gantry,
            }),
            quantity: self.quantity.map(|q| match q {
                QuantityArg::FCos => Quantity::FCos,
                QuantityArg::F => Quantity::F,
            }),
            axes,
        })
    }

    fn options(&self) -> Result<Options> {
        let mut requests = Requests {
            free: self.free.iter().map(|name| named("free", name)).collect::<Result<_>>()?,
            ..Requests::default()
        };
        for text in &self.fix {
            let (name, values) = pair("fix", text)?;
            let number =
                |x: &str| x.trim().parse::<f64>().with_context(|| format!("--fix {text}: '{x}' is not a number"));
            requests.fix.push((named("fix", name)?, values.split(',').map(number).collect::<Result<_>>()?));
        }
        for text in &self.tie {
            let (name, leader) = pair("tie", text)?;
            requests.tie.push((named("tie", name)?, named("tie", leader)?));
        }
        let default = Options::default();
        let huber = self.huber.unwrap_or(default.huber);
        if huber.is_nan() || huber < 1.0 {
            bail!("--huber {huber} is out of range: it must be at least 1");
        }
        Ok(Options { requests, starts: self.starts.map_or(default.starts, |n| n as usize), seed: self.seed, huber })
    }
}

/// Runs it.
pub fn run(args: &Args) -> Result<()> {
    let Some(path) = &args.profile else {
        return simulate::run(args);
    };
    let forward = args.forward()?;
    let interrupt = Interrupt::watch()?;
    if let Some(out) = &args.out {
        if out.extension().is_none_or(|e| e != "toml") {
            bail!("{}: the fibre's name must end in .toml", out.display());
        }
        output::writable(out)?;
    }
    if let Some(folder) = &args.report {
        if folder.exists() && !folder.is_dir() {
            bail!("cannot write {}: it is not a folder", folder.display());
        }
        output::writable(&folder.join("index.html"))?;
    }
    let reading = args.reading()?;
    if reading.axes.is_some() && path.extension().is_some_and(|e| e == "txt" || e == "csv") {
        bail!("--theta and --phi are the angles of an image: {} has its own", path.display());
    }
    let options = args.options()?;
    let profile = vellus_fit::read(path, &reading)?;
    let terminal = Terminal::with_interrupt(&interrupt);
    let fit = vellus_fit::fit(&profile, forward, &options, &terminal);
    terminal.clear();
    let fit = fit.with_context(|| format!("cannot fit {}", path.display()))?;
    let summary = Summary { path, profile: &profile, fit: &fit };
    if let Some(folder) = &args.report {
        let command = std::env::args().collect::<Vec<_>>().join(" ");
        write_report(&summary, folder, &command)?;
    }
    // Of an interrupted fit it is not known what more starts would have found.
    if let Some(why) = summary.no_fit().filter(|_| !fit.interrupted && !args.allow_bad_fit) {
        bail!(refusal(args, path, &why));
    }
    if let Some(out) = &args.out {
        output::write(Some(out), summary.toml(&toml::to_string(&fit.specimen.fiber)?).as_bytes())?;
    }
    let text = match args.format {
        Format::Table => summary.table(),
        Format::Json => format!("{}\n", serde_json::to_string_pretty(&summary.json())?),
    };
    output::write(None, text.as_bytes())?;
    for warning in summary.warnings() {
        note!("warning: {warning}");
    }
    let written: Vec<String> = written(args).iter().map(|path| path.display().to_string()).collect();
    if fit.interrupted {
        let place =
            if written.is_empty() { "is printed above".to_owned() } else { format!("is in {}", written.join(" and ")) };
        let (begun, finished) = (options.starts, fit.starts.finished);
        bail!(interrupt.error(format!(
            "the best fit after {finished} of {begun} starts {place}; the same command starts from the beginning"
        )));
    }
    for path in written {
        note!("wrote {path}");
    }
    Ok(())
}

/// The files that a fit is kept in.
fn written(args: &Args) -> Vec<PathBuf> {
    args.out.iter().cloned().chain(args.report.iter().map(|folder| folder.join("index.html"))).collect()
}

/// The message where there is no fit: what, why, what to do.
fn refusal(args: &Args, path: &Path, why: &str) -> String {
    let kept = args.out.as_ref().map_or(String::new(), |out| format!("; {} was not written", out.display()));
    let report = args
        .report
        .as_ref()
        .map_or(String::new(), |folder| format!("; {} shows where they differ", folder.join("index.html").display()));
    format!(
        "{}: {why}{kept}{report}. Check the columns of the file, --angles, --quantity and --theta-o, try another \
         --model; \
         --allow-bad-fit accepts it",
        path.display()
    )
}
