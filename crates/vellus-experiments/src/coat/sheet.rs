//! A contact sheet of coats over two parameters.

use crate::coat::Coat;
use anyhow::{Context, Result, bail};
use std::path::PathBuf;
use std::str::FromStr;
use vellus_io::{Progress, Steps};
use vellus_open::FiberSource;
use vellus_plot::contact::Contact;
use vellus_plot::{check_names, save};
use vellus_render::Display;

/// The largest number of coats, and the largest side of a picture.
const MOST: usize = 1000;
const LARGEST: u32 = 1024;

/// Values of a parameter, or fibres.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    name: String,
    values: Vec<String>,
}

impl FromStr for Axis {
    type Err = String;

    /// Reads `kappa=0.2/0.5/0.8`, `reflectance=0.8,0.16,0.03/0.5` or `fiber=cat/dog`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, values) = text.split_once('=').ok_or("expected NAME=VALUE/VALUE, such as kappa=0.2/0.5/0.8")?;
        let values: Vec<String> = values.split('/').map(|value| value.trim().to_owned()).collect();
        if values.iter().any(String::is_empty) {
            return Err("a value is empty: expected NAME=VALUE/VALUE, such as kappa=0.2/0.5/0.8".to_owned());
        }
        Ok(Axis { name: name.trim().to_owned(), values })
    }
}

impl Axis {
    /// Changes a fibre to one value of this axis.
    fn apply(&self, value: &str, source: &mut FiberSource) {
        match self.name.as_str() {
            "fiber" => source.path = value.into(),
            name => source.set.push(format!("{name}={value}")),
        }
    }
}

/// A contact sheet of coats of fur over two parameters.
///
/// With the feature `clap`, the fields are options of a command line. Their documentation is then the help text.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
pub struct Sheet {
    /// A preset, or a TOML or JSON file [default: red-fox].
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME|FILE"))]
    pub fiber: Option<PathBuf>,
    /// Set a parameter of all fibres. May be repeated.
    #[cfg_attr(feature = "clap", arg(long = "set", value_name = "NAME=VALUE", allow_hyphen_values = true))]
    pub set: Vec<String>,
    /// The rows: a parameter and its values, or fiber and names, such as fiber=cat/dog/human.
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME=V/V", default_value = "kappa=0/0.3/0.6/0.9"))]
    pub rows: Axis,
    /// The columns: another parameter and its values, such as reflectance=0.8,0.16,0.03/0.5.
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NAME=V/V", default_value = "reflectance=0.8/0.8,0.16,0.03/0.35,0.16,0.06/0.05")
    )]
    pub columns: Axis,
    /// Width and height of each picture, in pixels; [1, 1024].
    #[cfg_attr(feature = "clap", arg(long, default_value_t = 64, value_name = "PIXELS"))]
    pub size: u32,
    /// Samples per pixel; 1 or more.
    #[cfg_attr(feature = "clap", arg(long, default_value_t = 16, value_name = "N"))]
    pub samples: u32,
    /// File to write, .png or .svg.
    #[cfg_attr(feature = "clap", arg(short, long, default_value = "out/sheet.png", value_name = "FILE"))]
    pub output: PathBuf,
}

impl Sheet {
    /// Renders the coats and writes [`Sheet::output`]. `warn` is as for [`Sheet::render`].
    ///
    /// # Errors
    /// As [`Sheet::render`], or a file that cannot be written.
    pub fn save(&self, progress: &dyn Progress, warn: impl FnMut(&str)) -> Result<()> {
        let files = [self.output.clone()];
        check_names(&files)?;
        vellus_io::writable(&self.output).with_context(|| format!("cannot write {}", self.output.display()))?;
        Ok(save(&self.render(progress, warn)?, &files)?)
    }

    /// Renders the coats. A warning for each colour that is out of reach goes to `warn`.
    ///
    /// # Errors
    /// A fibre that cannot be read, or a size or a number of samples out of range.
    pub fn render(&self, progress: &dyn Progress, mut warn: impl FnMut(&str)) -> Result<Contact> {
        let Sheet { rows, columns, size, samples, .. } = self;
        if !(1..=LARGEST).contains(size) || *samples == 0 {
            bail!("the size must be in [1, {LARGEST}] and the samples at least 1, not {size} and {samples}");
        }
        if rows.values.len() * columns.values.len() > MOST {
            bail!("the sheet has more than {MOST} coats");
        }
        // All fibres are checked before the first picture.
        let mut fibers = Vec::new();
        for row in &rows.values {
            for column in &columns.values {
                let path = self.fiber.clone().unwrap_or_else(|| FiberSource::default().path);
                let mut source = FiberSource { path, set: self.set.clone() };
                rows.apply(row, &mut source);
                columns.apply(column, &mut source);
                let name = format!("{}={row}, {}={column}", rows.name, columns.name);
                let (fiber, warnings) = source.read_with_warnings().with_context(|| name.clone())?;
                warnings.iter().for_each(|warning| warn(&format!("{name}: {warning}")));
                fibers.push(fiber);
            }
        }
        let mut coat = Coat::new()?;
        let steps = Steps::new(progress, fibers.len() as u64, "rendering coats");
        let mut pictures = Vec::new();
        for fiber in &fibers {
            if progress.is_cancelled() {
                bail!(crate::Interrupted);
            }
            let film = coat.render(fiber, [*size as usize; 2], u64::from(*samples), 1)?;
            pictures.push(film.to_srgb(Display::srgb(0.0)).chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect());
            steps.advance(1);
        }
        Ok(Contact {
            title: format!("{} × {}", rows.name, columns.name),
            labels: [rows.values.clone(), columns.values.clone()],
            size: [*size; 2],
            pictures,
        })
    }
}
