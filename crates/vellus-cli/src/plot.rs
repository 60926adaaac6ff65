//! `vellus plot`: pictures of the model, PNG and SVG.

pub mod canvas;
mod energy;
pub mod error;
mod lobes;
pub mod medulla;
mod models;
mod profile;
mod smooth;
pub mod windows;

use crate::fiber_args::{FiberArgs, Incidence};
use crate::model_args::ModelArgs;
use crate::number::whole;
use crate::output;
use crate::query::{Offsets, Query};
use crate::say::say;
use anyhow::Result;
use canvas::{check_names, save};
use std::path::{Path, PathBuf};
use vellus::Species;
use vellus_models::ModelKind;

/// Which picture.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Azimuthal lobes of one hit, polar and over φ.
    Lobes {
        #[command(flatten)]
        fiber: FiberArgs,
        /// Inclination of ω_o, degrees.
        #[arg(long, default_value_t = 20.0, allow_negative_numbers = true, value_name = "DEG")]
        theta_o: f64,
        /// Offset at which the fibre is hit, in [-1, 1]; far-field models are averaged over all.
        #[arg(long, default_value_t = 0.3, allow_negative_numbers = true)]
        h: f64,
        #[command(flatten)]
        model: ModelArgs,
        #[command(flatten)]
        out: Out,
    },
    /// The whole fibre's reflectance over θ_i and φ, log scale, as in Yan17 Fig. 11; --fiber all for the ten presets.
    Profile {
        #[command(flatten)]
        incidence: Incidence,
        #[command(flatten)]
        model: ModelArgs,
        #[command(flatten)]
        out: Out,
    },
    /// Compressed against simulated medulla profiles, as in Yan17 Fig. 10.
    Medulla {
        /// A table file; without it, the tables inside this program.
        #[arg(long, value_name = "FILE")]
        table: Option<PathBuf>,
        /// Photons a simulated profile.
        #[arg(long, default_value_t = 400_000, value_parser = whole::<u64>(medulla::PHOTONS), value_name = "N")]
        photons: u64,
        #[command(flatten)]
        out: Out,
    },
    /// Energy of the lobes over the fibre's width, and over inclination.
    Energy {
        #[command(flatten)]
        incidence: Incidence,
        #[command(flatten)]
        model: ModelArgs,
        #[command(flatten)]
        out: Out,
    },
    /// The whole fibre's light around it and along it, in several models.
    Models {
        #[command(flatten)]
        incidence: Incidence,
        /// The models, by name (see --model of `plot lobes`); all is all of them.
        #[arg(long, value_delimiter = ',', default_value = "all", value_name = "NAMES")]
        models: Vec<String>,
        #[command(flatten)]
        out: Out,
    },
    /// Azimuthal lobes at five offsets of a window, their average as shipped, and by quadrature.
    Windows {
        #[command(flatten)]
        incidence: Incidence,
        /// What is averaged over: far (the whole width) or LO:HI, offsets in [-1, 1].
        #[arg(long, default_value = "far", allow_hyphen_values = true, value_name = "far|LO:HI")]
        window: String,
        #[command(flatten)]
        out: Out,
    },
    /// Error of the far field over the number of segments, the paper's and ours; --fiber all for the ten presets.
    Error {
        #[command(flatten)]
        incidence: Incidence,
        #[command(flatten)]
        out: Out,
    },
}

/// Where pictures go.
#[derive(clap::Args)]
pub struct Out {
    /// File to write, .png or .svg; may be repeated. Default: both, in the folder `out`.
    #[arg(long = "out", value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Out {
    /// Before any work: a bad name leaves no file behind.
    fn check(&self) -> Result<()> {
        check_names(&self.files)?;
        self.files.iter().try_for_each(|file| output::writable(file))
    }
}

impl Command {
    fn out(&self) -> &Out {
        match self {
            Command::Lobes { out, .. }
            | Command::Profile { out, .. }
            | Command::Medulla { out, .. }
            | Command::Energy { out, .. }
            | Command::Models { out, .. }
            | Command::Windows { out, .. }
            | Command::Error { out, .. } => out,
        }
    }
}

/// Runs it.
pub fn run(command: &Command) -> Result<()> {
    command.out().check()?;
    let written = match command {
        Command::Lobes { fiber, theta_o, h, model, out } => {
            Query::new([*theta_o, *h, 0.0, 0.0])?;
            let loaded = fiber.load()?;
            let picture = lobes::Picture::new(&fiber.name(), &loaded, &model.load(&loaded)?, *theta_o, *h);
            save(&picture, &out.files, &format!("{}-lobes", model.file(&fiber.name())?))?
        }
        Command::Profile { incidence: Incidence { fiber, theta_o }, model, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let panel = |f: &FiberArgs| -> Result<_> {
                let loaded = f.load()?;
                Ok(profile::Panel::new(&f.name(), &model.load(&loaded)?, *theta_o))
            };
            let panels = each(fiber).iter().map(panel).collect::<Result<Vec<_>>>()?;
            let name = format!("{}-profile", model.file(&fiber.name())?);
            save(&profile::Picture { panels, theta_o: *theta_o }, &out.files, &name)?
        }
        Command::Medulla { table, photons, out } => {
            save(&medulla::Picture::new(table.as_deref(), *photons)?, &out.files, "medulla")?
        }
        Command::Energy { incidence: Incidence { fiber, theta_o }, model, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let picture = energy::Picture::new(&fiber.name(), &model.load(&fiber.load()?)?, *theta_o);
            save(&picture, &out.files, &format!("{}-energy", model.file(&fiber.name())?))?
        }
        Command::Models { incidence: Incidence { fiber, theta_o }, models, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let loaded = fiber.load()?;
            let all: Vec<String> = ModelKind::ALL.iter().map(|kind| kind.name().to_owned()).collect();
            let names = if models.iter().any(|name| name == "all") { &all } else { models };
            let load = |name: &String| ModelArgs { model: name.clone(), eta_m: None }.load(&loaded);
            let models = names.iter().map(load).collect::<Result<Vec<_>>>()?;
            let picture = models::Picture::new(&fiber.name(), &models, *theta_o);
            save(&picture, &out.files, &format!("{}-models", fiber.name()))?
        }
        Command::Windows { incidence: Incidence { fiber, theta_o }, window, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let window = Offsets::parse(window, 0.0)?;
            let picture = windows::Picture::new(fiber.name(), &fiber.load()?, *theta_o, window)?;
            save(&picture, &out.files, &format!("{}-windows", fiber.name()))?
        }
        Command::Error { incidence: Incidence { fiber, theta_o }, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let fibers = each(fiber)
                .iter()
                .map(|f| error::Errors::new(&f.load()?, *theta_o, error::PATHS))
                .collect::<Result<Vec<_>>>()?;
            let name = if fibers.len() > 1 { "the ten presets".to_owned() } else { fiber.name() };
            let picture = error::Picture { name, theta_o: *theta_o, fibers };
            let files = save(&picture, &out.files, &format!("{}-error", fiber.name()))?;
            say!("{}", picture.table());
            files
        }
    };
    for path in written {
        say!("wrote {}", path.display());
    }
    Ok(())
}

/// The ten presets for `all`, else the one fibre.
fn each(fiber: &FiberArgs) -> Vec<FiberArgs> {
    if fiber.fiber.as_deref() == Some(Path::new("all")) {
        Species::ALL.iter().map(|s| FiberArgs::new(s.to_string(), &fiber.overrides.set)).collect()
    } else {
        vec![fiber.clone()]
    }
}
