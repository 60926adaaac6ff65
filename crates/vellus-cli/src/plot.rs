//! `vellus plot`: plots of the model as PNG and SVG.

use crate::fiber_args::{FiberArgs, Incidence};
use crate::model_args::ModelArgs;
use crate::number::whole;
use crate::output;
use crate::query::{Offsets, Query};
use crate::say::say;
use crate::table;
use crate::terminal::Terminal;
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};
use vellus::Species;
use vellus_models::ModelKind;
use vellus_plot::{Draw, check_names, energy, error, lobes, medulla, models, profile, save, windows};

/// The pictures.
#[derive(clap::Subcommand)]
pub enum Command {
    /// Azimuthal lobes of one hit, as a polar plot and over φ.
    Lobes {
        #[command(flatten)]
        fiber: FiberArgs,
        /// Inclination of ω_o, degrees.
        #[arg(long, default_value_t = 20.0, allow_negative_numbers = true, value_name = "DEG")]
        theta_o: f64,
        /// Offset of the hit, in [-1, 1]. Far-field models average over all offsets.
        #[arg(long, default_value_t = 0.3, allow_negative_numbers = true)]
        h: f64,
        #[command(flatten)]
        model: ModelArgs,
        #[command(flatten)]
        out: Out,
    },
    /// Reflectance of a fibre over θ_i and φ (Yan17 Fig. 11). `--fiber all` shows the ten presets.
    Profile {
        #[command(flatten)]
        incidence: Incidence,
        #[command(flatten)]
        model: ModelArgs,
        #[command(flatten)]
        out: Out,
    },
    /// Compressed and simulated medulla profiles (Yan17 Fig. 10).
    Medulla {
        /// A table file. Default: the tables of this program.
        #[arg(long, value_name = "FILE")]
        table: Option<PathBuf>,
        /// Photons per simulated profile.
        #[arg(long, default_value_t = 400_000, value_parser = whole::<u64>(medulla::PHOTONS), value_name = "N")]
        photons: u64,
        #[command(flatten)]
        out: Out,
    },
    /// Energies of the lobes over the offset, and over the inclination.
    Energy {
        #[command(flatten)]
        incidence: Incidence,
        #[command(flatten)]
        model: ModelArgs,
        #[command(flatten)]
        out: Out,
    },
    /// Several models of one fibre: light around the fibre and along it.
    Models {
        #[command(flatten)]
        incidence: Incidence,
        /// Names of models, with commas between (see --model of `plot lobes`), or `all`.
        #[arg(long, value_delimiter = ',', default_value = "all", value_name = "NAMES")]
        models: Vec<String>,
        #[command(flatten)]
        out: Out,
    },
    /// Azimuthal lobes at five offsets of a window, their average in the model, and by quadrature.
    Windows {
        #[command(flatten)]
        incidence: Incidence,
        /// The window: far (the whole width) or LO:HI, offsets in [-1, 1].
        #[arg(long, default_value = "far", allow_hyphen_values = true, value_name = "far|LO:HI")]
        window: String,
        #[command(flatten)]
        out: Out,
    },
    /// Error of the far field over the number of segments. `--fiber all` shows the ten presets.
    Error {
        #[command(flatten)]
        incidence: Incidence,
        #[command(flatten)]
        out: Out,
    },
}

/// The files to write.
#[derive(clap::Args)]
pub struct Out {
    /// File to write, .png or .svg. May be repeated. Default: a .png and a .svg file in the folder `out`.
    #[arg(long = "out", value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Out {
    /// Checks the names before any work.
    fn check(&self) -> Result<()> {
        check_names(&self.files)?;
        self.files.iter().try_for_each(|file| output::writable(file))
    }

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

/// Runs the command.
pub fn run(command: &Command) -> Result<()> {
    command.out().check()?;
    match command {
        Command::Lobes { fiber, theta_o, h, model, out } => {
            Query::new([*theta_o, *h, 0.0, 0.0])?;
            let loaded = fiber.load()?;
            let picture = lobes::Picture::new(&loaded, &model.load(&fiber.name(), &loaded)?, *theta_o, *h);
            out.save(&picture, &format!("{}-lobes", model.file(&fiber.name())?))
        }
        Command::Profile { incidence: Incidence { fiber, theta_o }, model, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let panel =
                |f: &FiberArgs| -> Result<_> { Ok(profile::Panel::new(&model.load(&f.name(), &f.load()?)?, *theta_o)) };
            let panels = each(fiber).iter().map(panel).collect::<Result<Vec<_>>>()?;
            let name = format!("{}-profile", model.file(&fiber.name())?);
            out.save(&profile::Picture { panels, theta_o: *theta_o }, &name)
        }
        Command::Medulla { table, photons, out } => {
            let (data, bytes) = table::load(table.as_deref())?;
            out.save(&medulla::Picture::new(&data, bytes, *photons, &Terminal::new()), "medulla")
        }
        Command::Energy { incidence: Incidence { fiber, theta_o }, model, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let picture = energy::Picture::new(&model.load(&fiber.name(), &fiber.load()?)?, *theta_o);
            out.save(&picture, &format!("{}-energy", model.file(&fiber.name())?))
        }
        Command::Models { incidence: Incidence { fiber, theta_o }, models, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let loaded = fiber.load()?;
            let all: Vec<String> = ModelKind::ALL.iter().map(|kind| kind.name().to_owned()).collect();
            let names = if models.iter().any(|name| name == "all") { &all } else { models };
            let load = |name: &String| ModelArgs { model: name.clone(), eta_m: None }.load(&fiber.name(), &loaded);
            let models = names.iter().map(load).collect::<Result<Vec<_>>>()?;
            let picture = models::Picture::new(&fiber.name(), &models, *theta_o);
            out.save(&picture, &format!("{}-models", fiber.name()))
        }
        Command::Windows { incidence: Incidence { fiber, theta_o }, window, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let range = match Offsets::parse(window, 0.0)? {
                Offsets::Range(low, high) if low < high => [low, high],
                other => bail!("--window: {other} has no width; expected far or LO:HI, such as -0.5:0.25"),
            };
            let picture = windows::Picture::new(&fiber.name(), &fiber.load()?, *theta_o, range)?;
            out.save(&picture, &format!("{}-windows", fiber.name()))
        }
        Command::Error { incidence: Incidence { fiber, theta_o }, out } => {
            Query::new([*theta_o, 0.0, 0.0, 0.0])?;
            let fibers = each(fiber)
                .iter()
                .map(|f| Ok(error::Errors::new(&f.load()?, *theta_o, error::PATHS)?))
                .collect::<Result<Vec<_>>>()?;
            let name = if fibers.len() > 1 { "the ten presets".to_owned() } else { fiber.name() };
            let picture = error::Picture { name, theta_o: *theta_o, fibers };
            say!("{}", picture.table());
            out.save(&picture, &format!("{}-error", fiber.name()))
        }
    }
}

/// The ten presets for `all`, else the one fibre.
fn each(fiber: &FiberArgs) -> Vec<FiberArgs> {
    if fiber.fiber.as_deref() == Some(Path::new("all")) {
        Species::ALL.iter().map(|s| FiberArgs::new(s.to_string(), &fiber.overrides.set)).collect()
    } else {
        vec![fiber.clone()]
    }
}
