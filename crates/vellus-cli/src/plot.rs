//! `vellus plot`: pictures of the model as PNG and SVG.

use crate::fiber_args::{FiberArgs, Incidence};
use crate::model_args::ModelArgs;
use crate::output;
use crate::say::say;
use crate::terminal::Terminal;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use vellus::Species;
use vellus_io::parse;
use vellus_models::ModelKind;
use vellus_plot::query::{Offsets, Query};
use vellus_plot::{Draw, check_names, energy, error, lobes, medulla, models, profile, save, windows};
use vellus_reference::simulate::read_tables;

#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    picture: Picture,
    /// File to write, .png or .svg. May be repeated. Default: a .png and a .svg file in the folder out.
    #[arg(long = "out", value_name = "FILE", global = true)]
    files: Vec<PathBuf>,
}

#[derive(clap::Subcommand)]
enum Picture {
    /// Azimuthal lobes of one hit, as a polar plot and over φ.
    Lobes {
        #[command(flatten)]
        fiber: FiberArgs,
        /// Inclination of ω_o, the direction toward the camera.
        #[arg(long, default_value_t = 20.0, value_name = "DEG")]
        theta_o: f64,
        /// Offset of the hit, in [-1, 1]. Far-field models do not use it.
        #[arg(long, default_value_t = 0.3)]
        h: f64,
        #[command(flatten)]
        model: ModelArgs,
    },
    /// Reflectance over θ_i and φ (Yan17 Fig. 11). `--fiber all` shows the ten presets.
    Profile {
        #[command(flatten)]
        incidence: Incidence,
        /// Show only the directions that were measured (Yan17 Fig. 11): θ_i 10° to 50°, φ -20° to 200°. The light was
        /// at --theta-o -30.
        #[arg(long)]
        measured: bool,
        #[command(flatten)]
        model: ModelArgs,
    },
    /// Medulla profiles from the tables and from simulations (Yan17 Fig. 10).
    Medulla {
        /// Table file. Default: the tables that vellus contains.
        #[arg(long, value_name = "FILE")]
        table: Option<PathBuf>,
        /// Photons per simulated profile.
        #[arg(long, default_value_t = 400_000, value_parser = parse::whole::<u64>(medulla::PHOTONS), value_name = "N")]
        photons: u64,
    },
    /// Energies of the lobes over the offset and over the inclination.
    Energy {
        #[command(flatten)]
        incidence: Incidence,
        #[command(flatten)]
        model: ModelArgs,
    },
    /// Several models of one fibre, around the fibre and along it.
    Models {
        #[command(flatten)]
        incidence: Incidence,
        /// Models, separated by commas (see --model of `plot lobes`), or all.
        #[arg(long, value_delimiter = ',', default_value = "all", value_name = "NAMES")]
        models: Vec<String>,
    },
    /// Azimuthal lobes averaged over a window: the model, quadrature, and five offsets.
    Windows {
        #[command(flatten)]
        incidence: Incidence,
        /// Offsets to average over: far (the whole width) or LO:HI.
        #[arg(long, default_value = "far", allow_hyphen_values = true, value_name = "far|LO:HI")]
        window: String,
    },
    /// Error of the far field over the number of segments. `--fiber all` shows the ten presets.
    Error {
        #[command(flatten)]
        incidence: Incidence,
    },
}

impl Args {
    /// Draws a picture to the files, or to `out/NAME.png` and `out/NAME.svg`.
    fn save(&self, picture: &impl Draw, name: &str) -> Result<()> {
        let files = match &self.files[..] {
            [] => vec![format!("out/{name}.png").into(), format!("out/{name}.svg").into()],
            files => files.to_vec(),
        };
        save(picture, &files)?;
        files.iter().for_each(|file| say!("wrote {}", file.display()));
        Ok(())
    }
}

pub fn run(args: &Args) -> Result<()> {
    check_names(&args.files)?;
    args.files.iter().try_for_each(|file| output::writable(file))?;
    match &args.picture {
        Picture::Lobes { fiber, theta_o, h, model } => {
            Query::new([*theta_o, *h, 0.0, 0.0])?;
            let loaded = fiber.load()?;
            let picture = lobes::Picture::new(&loaded, &model.load(&fiber.name(), &loaded)?, *theta_o, *h);
            args.save(&picture, &format!("{}-lobes", model.file(&fiber.name())))
        }
        Picture::Profile { incidence, measured, model } => {
            let (fiber, theta_o) = incidence.checked()?;
            let area = if *measured { profile::Area::MEASURED } else { profile::Area::SPHERE };
            let panel = |f: &FiberArgs| -> Result<_> {
                Ok(profile::Panel::new(&model.load(&f.name(), &f.load()?)?, theta_o, area))
            };
            let panels = each(fiber).iter().map(panel).collect::<Result<Vec<_>>>()?;
            args.save(&profile::Picture { panels, theta_o }, &format!("{}-profile", model.file(&fiber.name())))
        }
        Picture::Medulla { table, photons } => {
            let (data, bytes) = read_tables(table.as_deref())?;
            args.save(&medulla::Picture::new(&data, bytes, *photons, &Terminal::new()), "medulla")
        }
        Picture::Energy { incidence, model } => {
            let (fiber, theta_o) = incidence.checked()?;
            let picture = energy::Picture::new(&model.load(&fiber.name(), &fiber.load()?)?, theta_o);
            args.save(&picture, &format!("{}-energy", model.file(&fiber.name())))
        }
        Picture::Models { incidence, models } => {
            let (fiber, theta_o) = incidence.checked()?;
            let loaded = fiber.load()?;
            let load = |model: ModelKind| ModelArgs { model, eta_m: None }.load(&fiber.name(), &loaded);
            let models = ModelKind::list(models)?.into_iter().map(load).collect::<Result<Vec<_>>>()?;
            args.save(&models::Picture::new(&fiber.name(), &models, theta_o), &format!("{}-models", fiber.name()))
        }
        Picture::Windows { incidence, window } => {
            let (fiber, theta_o) = incidence.checked()?;
            let range = Offsets::parse_window(window).context("--window")?;
            let picture = windows::Picture::new(&fiber.name(), &fiber.load()?, theta_o, range)?;
            args.save(&picture, &format!("{}-windows", fiber.name()))
        }
        Picture::Error { incidence } => {
            let (fiber, theta_o) = incidence.checked()?;
            let errors = |f: &FiberArgs| -> Result<_> { Ok(error::Errors::new(&f.load()?, theta_o, error::PATHS)?) };
            let fibers = each(fiber).iter().map(errors).collect::<Result<Vec<_>>>()?;
            let name = if fibers.len() > 1 { "the ten presets".to_owned() } else { fiber.name() };
            let picture = error::Picture { name, theta_o, fibers };
            say!("{}", picture.table());
            args.save(&picture, &format!("{}-error", fiber.name()))
        }
    }
}

/// The ten presets for `all`, otherwise the one fibre.
fn each(fiber: &FiberArgs) -> Vec<FiberArgs> {
    if fiber.fiber.as_deref() == Some(Path::new("all")) {
        Species::ALL.iter().map(|s| FiberArgs::new(s.to_string(), &fiber.overrides.set)).collect()
    } else {
        vec![fiber.clone()]
    }
}
