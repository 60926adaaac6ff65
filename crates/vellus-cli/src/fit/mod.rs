//! `vellus fit`: fits a fibre to a measured profile, or writes a synthetic measurement.

mod simulate;

use crate::interrupt::Interrupt;
use crate::number::one_of;
use crate::output;
use crate::say::note;
use crate::terminal::Terminal;
use anyhow::{Context, Error, Result, bail};
use std::path::{Path, PathBuf};
use vellus::ScatterExit;
use vellus_fit::{Angles, Axis, Forward, Options, Profile, Quantity, Reading, Requests};
use vellus_io::parse;
use vellus_models::ModelKind;
use vellus_open::FiberFormat;
use vellus_plot::fit::{Measured, Summary, write_report};

/// Fit the parameters of a fibre to its measured profile (Yan17 Sec. 5.1), or write a synthetic measurement.
///
/// PROFILE contains the light that one fibre scatters, averaged over its width. One of camera and light is fixed, the
/// other moves. A .txt file has lines `phi theta value` or `phi theta r g b`, in the coordinates of the gantry of Yan
/// et al. 2015, with `?` for missing values. A .csv file has columns theta, phi, and value or r, g, b, or value_NAME
/// for each of up to 64 channels, such as value_550. An image (.npy, .exr) has rows over theta and columns over phi.
/// The unit of the values is arbitrary. Several profiles are fitted one after the other, or with --joint all together,
/// as measurements of the same fibre. Channels share all but the absorption of cortex and medulla.
///
/// vellus writes no fibre, and the exit code is 2, in three cases: the model is no better than a constant (F-test at
/// 0.1 %); the model explains less than a quarter of the constant's loss, and the residuals are not noise; or the
/// measurements determine no parameter of the fibre. Ctrl-C stops the fit and writes the best result so far, marked as
/// interrupted.
#[derive(clap::Args)]
pub struct Args {
    /// Measured profiles: .txt, .csv, .npy or .exr.
    #[arg(required_unless_present = "simulate", conflicts_with = "simulate", value_name = "PROFILE")]
    profiles: Vec<PathBuf>,
    /// Fit all profiles together: they are measurements of the same fibre, at several inclinations or wavelengths. Each
    /// has its own scale, theta_o and background.
    #[arg(long, conflicts_with = "simulate")]
    joint: bool,
    /// Model to fit, or to measure: vellus, yan2015, chiang2016 or marschner2003. Only yan2015 has the parameter
    /// eta_m. The last two have no medulla.
    #[arg(long, default_value = "vellus", value_name = "NAME")]
    model: ModelKind,
    /// How scattered light leaves the fitted fibre: reflecting (as in a simulated fibre), or open (the cuticle does
    /// not reflect it, as in the paper). Only vellus has both. The written fibre contains it. Default: reflecting.
    #[arg(long, value_parser = one_of::<ScatterExit>(ScatterExit::ALL.map(ScatterExit::name)), value_name = "EXIT")]
    #[arg(conflicts_with = "simulate")]
    exit: Option<ScatterExit>,
    /// File to write: the fibre (.toml), or the synthetic measurement (.txt, .csv). For several profiles without
    /// --joint, a folder: each fibre has the name of its profile.
    #[arg(long, value_name = "FILE|DIR")]
    out: Option<PathBuf>,
    /// Folder for a report with pictures: index.html and profile-1.csv, and absorption.csv for channels. For several
    /// profiles without --joint, it has a folder for each.
    #[arg(long, value_name = "DIR", conflicts_with = "simulate")]
    report: Option<PathBuf>,
    /// Format of the result on standard output.
    #[arg(long, value_parser = one_of::<String>(["table", "json"]), default_value = "table", value_name = "FORMAT")]
    format: String,
    /// Inclination of the fixed direction, degrees: one for all profiles, or one for each. A file can contain it:
    /// `# theta_o = -30`.
    #[arg(long, value_name = "DEG", value_delimiter = ',', allow_hyphen_values = true)]
    theta_o: Vec<f64>,
    /// Full width of the cell over which each value is an average, degrees: the aperture. One width for θ and φ, or
    /// θ,φ. A file can contain it: `# blur = 5,5`. For a round aperture, give 0.87 times its diameter.
    #[arg(long, value_parser = vellus_fit::parse_blur, value_name = "DEG")]
    blur: Option<[f64; 2]>,
    /// Angles of the file: those of the fibre, or of the gantry (theta = 90° - its theta, phi = its phi - 90°).
    /// Default: gantry for .txt, fiber for others.
    #[arg(long, value_parser = one_of::<Angles>(Angles::NAMES), value_name = "ANGLES", conflicts_with = "simulate")]
    angles: Option<Angles>,
    /// What the values are proportional to: f·cos θ (fixed camera, or a moving detector that sees the whole fibre), or
    /// f (radiance at a moving camera). Default: what the file says, or f-cos.
    #[arg(long, value_parser = one_of::<Quantity>(Quantity::NAMES), value_name = "QUANTITY")]
    #[arg(conflicts_with = "simulate")]
    quantity: Option<Quantity>,
    /// θ of the first and the last row of an image or of a synthetic measurement, degrees.
    #[arg(long, allow_hyphen_values = true, value_name = "FIRST:LAST")]
    theta: Option<Axis>,
    /// φ of the first and the last column, degrees.
    #[arg(long, allow_hyphen_values = true, value_name = "FIRST:LAST")]
    phi: Option<Axis>,
    /// Fix a parameter: eta=1.55, sigma_ca=0.1,0.2,0.4 (RGB), or scale=1 for an absolute measurement. May be repeated.
    #[arg(long, value_name = "NAME=VALUE", conflicts_with = "simulate")]
    fix: Vec<String>,
    /// Give the first parameter the value of the second: beta_n=beta_m. May be repeated.
    #[arg(long, value_name = "NAME=NAME", conflicts_with = "simulate")]
    tie: Vec<String>,
    /// Fit a parameter that usually is fixed: theta_o, medulla_air (usually 0), or background (light that does not come
    /// from the fibre, usually 0). May be repeated.
    #[arg(long, value_name = "NAME", conflicts_with = "simulate")]
    free: Vec<String>,
    /// With --joint or channels, give each profile or channel its own value of a parameter, such as sigma_ca for
    /// profiles of different wavelengths. May be repeated.
    #[arg(long, value_name = "NAME", conflicts_with = "simulate")]
    separate: Vec<String>,
    /// With --joint, give all profiles the same scale, theta_o or background; give all channels the same sigma_ca or
    /// sigma_ma. May be repeated.
    #[arg(long, value_name = "NAME", conflicts_with = "simulate")]
    share: Vec<String>,
    /// Number of starts of the search [default: 64].
    #[arg(long, value_name = "N", conflicts_with = "simulate", value_parser = parse::whole::<u32>(1..=10_000))]
    starts: Option<u32>,
    /// Huber's loss: residuals above K times the noise count linearly. inf is plain least squares [default: 4].
    #[arg(long, value_name = "K", conflicts_with = "simulate")]
    huber: Option<f64>,
    /// Write the fibre also if the model does not fit. The fibre and the report are marked NO FIT.
    #[arg(long, conflicts_with = "simulate")]
    allow_bad_fit: bool,
    /// Seed of the starts, or of noise, gaps and photons.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    synthetic: simulate::Gantry,
}

impl Args {
    /// How to read the profile with this index.
    fn reading(&self, index: usize) -> Result<Reading> {
        let theta_o = match self.theta_o[..] {
            [] => None,
            [one] => Some(one),
            _ => match self.theta_o.get(index) {
                Some(one) if self.theta_o.len() == self.profiles.len() => Some(*one),
                _ => bail!("--theta-o has {} values for {} profiles", self.theta_o.len(), self.profiles.len()),
            },
        };
        let axes = match (self.theta, self.phi) {
            (Some(theta), Some(phi)) => Some([theta, phi]),
            (None, None) => None,
            _ => bail!("--theta and --phi must be given together"),
        };
        Ok(Reading { theta_o, angles: self.angles, quantity: self.quantity, axes, blur: self.blur })
    }

    fn options(&self) -> Result<Options> {
        let mut requests = Requests::default();
        for name in &self.free {
            requests.add_free(name).with_context(|| format!("in --free {name}"))?;
        }
        for (names, option, list) in
            [(&self.separate, "--separate", &mut requests.separate), (&self.share, "--share", &mut requests.share)]
        {
            for name in names {
                list.push(name.trim().parse().with_context(|| format!("in {option} {name}"))?);
            }
        }
        for text in &self.fix {
            requests.add_fix(text).with_context(|| format!("in --fix {text}"))?;
        }
        for text in &self.tie {
            requests.add_tie(text).with_context(|| format!("in --tie {text}"))?;
        }
        let default = Options::default();
        let huber = self.huber.unwrap_or(default.huber);
        if huber.is_nan() || huber < 1.0 {
            bail!("--huber {huber} is out of range: it must be at least 1");
        }
        let starts = self.starts.map_or(default.starts, |n| n as usize);
        Ok(Options { requests, starts, seed: self.seed, huber, exit: self.exit })
    }

    /// What to fit and where to write it: one job for each profile, or one for all.
    fn jobs(&self) -> Result<Vec<Job<'_>>> {
        let all = self.profiles.iter().enumerate().map(|(i, path)| Ok((path.as_path(), self.reading(i)?)));
        let all = all.collect::<Result<Vec<_>>>()?;
        if self.joint || all.len() == 1 {
            return Ok(vec![Job { profiles: all, out: self.out.clone(), report: self.report.clone() }]);
        }
        let mut jobs: Vec<Job<'_>> = Vec::new();
        for (path, reading) in all {
            let name = path.file_stem().unwrap_or_default();
            if let Some(job) = jobs.iter().find(|job| job.profiles[0].0.file_stem() == Some(name)) {
                let other = job.profiles[0].0.display();
                bail!("{other} and {} have the same name: their results would be the same files", path.display());
            }
            let mut file = name.to_owned();
            file.push(".toml");
            jobs.push(Job {
                profiles: vec![(path, reading)],
                out: self.out.as_ref().map(|folder| folder.join(&file)),
                report: self.report.as_ref().map(|folder| folder.join(name)),
            });
        }
        if let Some(folder) = &self.out {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot create the folder {}", folder.display()))?;
        }
        Ok(jobs)
    }
}

/// One fit and its files.
struct Job<'a> {
    profiles: Vec<(&'a Path, Reading)>,
    out: Option<PathBuf>,
    report: Option<PathBuf>,
}

impl Job<'_> {
    /// The page of the report.
    fn page(&self) -> Option<PathBuf> {
        self.report.as_ref().map(|folder| folder.join("index.html"))
    }

    /// Checks that the results can be written.
    fn check_files(&self) -> Result<()> {
        if let Some(out) = &self.out {
            output::check_extension(out, &["toml"])?;
            output::writable(out)?;
        }
        if let Some(folder) = self.report.as_ref().filter(|folder| folder.exists() && !folder.is_dir()) {
            bail!("cannot write {}: it is not a folder", folder.display());
        }
        self.page().map_or(Ok(()), |page| output::writable(&page))
    }

    fn run(&self, args: &Args, forward: Forward, options: &Options, interrupt: &Interrupt) -> Result<()> {
        let (mut profiles, mut paths) = (Vec::new(), Vec::new());
        for (path, reading) in &self.profiles {
            if reading.axes.is_some() && path.extension().is_some_and(|e| e == "txt" || e == "csv") {
                bail!("--theta and --phi are the angles of an image: {} has its own", path.display());
            }
            let channels = vellus_fit::read_channels(path, reading)?;
            let names = |profiles: &[Profile]| profiles.iter().map(|p| p.channel.clone()).collect::<Vec<_>>();
            let (own, first) = (names(&channels), names(&profiles[..channels.len().min(profiles.len())]));
            if !profiles.is_empty() && own != first {
                bail!("{} has other channels than {}", path.display(), self.profiles[0].0.display());
            }
            paths.resize(paths.len() + channels.len(), *path);
            profiles.extend(channels);
        }
        let is_alone = profiles.len() == 1 && !args.joint;
        let of_several = [("--separate", &options.requests.separate), ("--share", &options.requests.share)];
        if let Some((option, _)) = of_several.iter().find(|(_, names)| is_alone && !names.is_empty()) {
            bail!("{option} needs --joint, or a profile with several channels (columns value_NAME)");
        }
        let terminal = Terminal::with_interrupt(interrupt);
        // From here on, a signal leaves the best fit so far.
        interrupt.set_immediate(false);
        let fit = vellus_fit::fit(&profiles, forward, options, &terminal);
        terminal.clear();
        let names: Vec<String> = self.profiles.iter().map(|(path, _)| path.display().to_string()).collect();
        let fit = fit.with_context(|| format!("cannot fit {}", names.join(", ")))?;
        let measured = paths.iter().zip(&profiles).map(|(path, profile)| Measured { path, profile });
        let summary = Summary { measured: measured.collect(), fit: &fit };
        if let Some(folder) = &self.report {
            let command = std::env::args().collect::<Vec<_>>().join(" ");
            write_report(&summary, folder, &command)?;
        }
        // More starts might have improved an interrupted fit, so it is not refused.
        if let Some(why) = summary.no_fit().filter(|_| !fit.interrupted && !args.allow_bad_fit) {
            bail!(summary.refusal(&why, self.out.as_deref(), self.page().as_deref()));
        }
        if let Some(out) = &self.out {
            let toml = FiberFormat::Toml.write(&fit.specimen.fiber).map_err(Error::from_boxed)?;
            output::write(Some(out), summary.toml(&toml).as_bytes())?;
        }
        let text = match args.format.as_str() {
            "json" => format!("{}\n", serde_json::to_string_pretty(&summary.json())?),
            _ => summary.table(),
        };
        output::write(None, text.as_bytes())?;
        for warning in summary.warnings() {
            note!("warning: {warning}");
        }
        let written: Vec<String> =
            self.out.iter().cloned().chain(self.page()).map(|p| p.display().to_string()).collect();
        if fit.interrupted {
            bail!(interrupt.error(summary.interruption(&written, options.starts)));
        }
        for path in written {
            note!("wrote {path}");
        }
        Ok(())
    }
}

pub fn run(args: &Args) -> Result<()> {
    if args.profiles.is_empty() {
        return simulate::run(args);
    }
    let forward = Forward::new(args.model)?;
    let interrupt = Interrupt::watch()?;
    interrupt.set_immediate(true);
    let options = args.options()?;
    let jobs = args.jobs()?;
    for job in &jobs {
        job.check_files()?;
    }
    if let [job] = &jobs[..] {
        return job.run(args, forward, &options, &interrupt);
    }
    let mut failed = 0;
    for (i, job) in jobs.iter().enumerate() {
        note!("{} of {}: {}", i + 1, jobs.len(), job.profiles[0].0.display());
        match job.run(args, forward, &options, &interrupt) {
            Err(error) if interrupt.is_set() => return Err(error),
            // The other profiles do not depend on it.
            Err(error) => {
                failed += 1;
                note!("error: {error:#}");
            }
            Ok(()) => {}
        }
    }
    if failed > 0 {
        bail!("{failed} of {} profiles have no fit: see above", jobs.len());
    }
    Ok(())
}
