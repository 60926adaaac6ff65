//! Fibres by name or file.

use crate::color;
use std::error::Error;
use std::io;
use std::num::ParseFloatError;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use vellus::{Fiber, FiberBuilder, Parameter, Species};

/// The largest file of a fibre: 1 MiB.
const MAX_FIBER_BYTES: u64 = 1 << 20;

/// The preset of strands whose file defines no fibre.
pub(crate) const DEFAULT: Species = Species::RedFox;

/// A fibre as a user describes it: a preset or a file, and parameters that are set afterwards.
///
/// ```
/// use vellus_open::FiberSource;
///
/// let source = FiberSource { path: "red-fox".into(), set: vec!["kappa=0.5".into(), "sigma_ca=0.1,0.2,0.4".into()] };
/// let fiber = source.read()?;
/// assert_eq!((fiber.kappa, fiber.sigma_ca), (0.5, [0.1, 0.2, 0.4]));
/// assert_eq!(source.name(), "red-fox");
/// # Ok::<(), vellus_open::FiberError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FiberSource {
    /// The name of a preset, a file with the extension `toml` or `json`, or a material of a MaterialX document:
    /// `FILE.mtlx`, or `FILE.mtlx#NAME` if the document has several.
    pub path: PathBuf,
    /// Parameters as `NAME=VALUE`, `NAME=R,G,B` or `NAME=WORD` ([`Parameter::choices`]). They replace those of the
    /// preset or the file.
    pub set: Vec<String>,
}

impl Default for FiberSource {
    /// The preset `red-fox`.
    fn default() -> Self {
        FiberSource { path: DEFAULT.name().into(), set: Vec::new() }
    }
}

impl FiberSource {
    /// The fibre, with all parameters in range.
    ///
    /// # Errors
    /// [`FiberError`] names the file or the parameter.
    pub fn read(&self) -> Result<Fiber, FiberError> {
        self.read_with_warnings().map(|(fiber, _)| fiber)
    }

    /// The fibre, with all parameters in range, and warnings: a reflectance that is out of reach, and what was mapped
    /// of a material.
    ///
    /// # Errors
    /// As [`FiberSource::read`].
    pub fn read_with_warnings(&self) -> Result<(Fiber, Vec<String>), FiberError> {
        let path = &self.path;
        let mut warnings = Vec::new();
        let extension = path.extension().and_then(|extension| extension.to_str());
        let base = match extension.and_then(|extension| extension.parse::<FiberFormat>().ok()) {
            Some(format) => read(path, format)?,
            None => match material(path) {
                Some((file, name)) => {
                    let mapped = vellus_usd::read_material(&file, name.as_deref(), &Fiber::hair());
                    let (fiber, mapped) = mapped.map_err(FiberError::Material)?;
                    warnings.extend(mapped.iter().map(ToString::to_string));
                    FiberBuilder::new(fiber)
                }
                None => FiberBuilder::new(Fiber::named(&path.display().to_string())?),
            },
        };
        let mut builder = base.clone();
        for setting in &self.set {
            set(&mut builder, setting).map_err(|source| FiberError::Settings {
                option: "",
                settings: vec![setting.clone()],
                source,
            })?;
        }
        // If the file is wrong without the settings, too, the error names the file.
        let built = builder.build().and_then(|fiber| Ok((fiber, builder.out_of_reach()?)));
        let (fiber, color) = built.map_err(|error| match base.build() {
            Ok(_) => FiberError::Settings { option: "", settings: self.set.clone(), source: error.into() },
            Err(_) => FiberError::File { path: path.clone(), source: error.into() },
        })?;
        warnings.extend(color.map(|color| color.to_string()));
        Ok((fiber, warnings))
    }

    /// A short name for titles and file names: that of the preset, or of the file without its extension.
    pub fn name(&self) -> String {
        self.path.file_stem().map_or_else(|| "fiber".to_owned(), |stem| stem.to_string_lossy().into_owned())
    }

    /// Whether one of [`FiberSource::set`] sets the colour of the fibre.
    pub fn sets_color(&self) -> bool {
        let names = self.set.iter().filter_map(|setting| setting.split_once('='));
        let mut parameters = names.filter_map(|(name, _)| Parameter::parse(name.trim()));
        parameters.any(|(parameter, _)| parameter.is_color())
    }
}

/// The formats of files of fibres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiberFormat {
    /// TOML.
    Toml,
    /// JSON.
    Json,
}

impl FiberFormat {
    /// The names of all formats. They are also the extensions.
    pub const NAMES: [&str; 2] = ["toml", "json"];

    /// A fibre as text in this format.
    ///
    /// # Errors
    /// What the encoder reports.
    pub fn write(self, fiber: &Fiber) -> Result<String, Box<dyn Error + Send + Sync>> {
        Ok(match self {
            FiberFormat::Toml => toml::to_string(fiber)?,
            FiberFormat::Json => serde_json::to_string_pretty(fiber)? + "\n",
        })
    }
}

impl FromStr for FiberFormat {
    type Err = String;

    /// Reads one of [`FiberFormat::NAMES`].
    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "toml" => Ok(FiberFormat::Toml),
            "json" => Ok(FiberFormat::Json),
            _ => Err(format!("unknown format '{name}': known are {}", FiberFormat::NAMES.join(", "))),
        }
    }
}

/// The document and the name of the material, of `FILE.mtlx` or `FILE.mtlx#NAME`.
fn material(path: &Path) -> Option<(PathBuf, Option<String>)> {
    let is_document = |file: &str| file.to_ascii_lowercase().ends_with(".mtlx");
    let text = path.to_str()?;
    // A folder may have the character in its name.
    if is_document(text) {
        return Some((path.to_owned(), None));
    }
    let (file, name) = text.rsplit_once('#').filter(|(file, _)| is_document(file))?;
    Some((file.into(), Some(name.to_owned())))
}

fn read(path: &Path, format: FiberFormat) -> Result<FiberBuilder, FiberError> {
    let text = vellus_io::read_to_string(path, MAX_FIBER_BYTES);
    let text = text.map_err(|source| FiberError::Read { path: path.to_owned(), source })?;
    let builder = match format {
        FiberFormat::Toml => toml::from_str(&text).map_err(|error| vellus_groom::toml_message(&error).into()),
        FiberFormat::Json => serde_json::from_str(&text).map_err(Into::into),
    };
    builder.map_err(|source| FiberError::File { path: path.to_owned(), source })
}

/// Sets a parameter: `NAME=VALUE`, `NAME=R,G,B`, or `NAME=WORD` for a choice.
pub(crate) fn set(builder: &mut FiberBuilder, setting: &str) -> Result<(), SettingError> {
    let (name, value) = setting.split_once('=').ok_or(SettingError::Syntax)?;
    let name = name.trim();
    if Parameter::from_name(name).is_some_and(|parameter| !parameter.choices().is_empty()) {
        return Ok(builder.set_word(name, value.trim())?);
    }
    let number = |x: &str| x.trim().parse().map_err(|source| SettingError::Number { text: x.to_owned(), source });
    let mut numbers = value.split(',').map(number).collect::<Result<Vec<f32>, _>>();
    if [Parameter::Reflectance, Parameter::HairReflectance].iter().any(|parameter| parameter.name() == name) {
        if numbers.is_err() {
            numbers = Ok(color(value).map_err(SettingError::Color)?.to_vec());
        }
        // Black and white are colours, too. The renderer warns of what is out of reach.
        let nearest = |x: f32| if (0.0..=1.0).contains(&x) { Parameter::Reflectance.range().nearest(x) } else { x };
        numbers = numbers.map(|numbers| numbers.into_iter().map(nearest).collect());
    }
    Ok(builder.set(name, &numbers?)?)
}

/// Why a fibre cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FiberError {
    /// There is no preset of this name.
    #[error(transparent)]
    Preset(#[from] vellus::Error),
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: io::Error,
    },
    /// A material of a MaterialX document cannot be read as a fibre.
    #[error(transparent)]
    Material(vellus_usd::Error),
    /// A file is not a valid fibre.
    #[error("in {}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The problem, with its line if it is one of the syntax.
        source: Box<dyn Error + Send + Sync>,
    },
    /// A setting is wrong, or all of them together.
    #[error("in {}", settings.iter().map(|setting| format!("{option}{setting}")).collect::<Vec<_>>().join(" "))]
    Settings {
        /// The option with its space, such as `--set `, or nothing. It precedes each setting in the message.
        option: &'static str,
        /// One or all of [`FiberSource::set`].
        settings: Vec<String>,
        /// The problem.
        source: SettingError,
    },
}

impl FiberError {
    /// The same error, for settings from an option of a command line.
    pub fn of_option(self, option: &'static str) -> Self {
        match self {
            FiberError::Settings { settings, source, .. } => FiberError::Settings { option, settings, source },
            other => other,
        }
    }
}

/// Why a setting of a fibre is refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// There is no `=`.
    #[error("expected NAME=VALUE")]
    Syntax,
    /// A value is not a number.
    #[error("'{text}' is not a number")]
    Number {
        /// The value.
        text: String,
        /// Why not.
        source: ParseFloatError,
    },
    /// A value is not a colour.
    #[error("{0}")]
    Color(String),
    /// The parameter is unknown, or its value is out of range.
    #[error(transparent)]
    Parameter(#[from] vellus::Error),
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An error and its causes.
    fn chain(error: &dyn Error) -> String {
        let cause = error.source().map(|cause| format!(": {}", chain(cause)));
        format!("{error}{}", cause.unwrap_or_default())
    }

    #[test]
    fn a_material_of_a_document_is_a_fibre() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vellus-usd/tests/data/hair.mtlx");
        let source = |name: &str| FiberSource {
            path: format!("{}{name}", file.display()).into(),
            set: vec!["kappa=0.5".into()],
        };
        let (fiber, warnings) = source("#Plain").read_with_warnings().unwrap();
        assert_eq!((fiber.sigma_ca, fiber.kappa, warnings.len()), ([0.1, 0.2, 0.4], 0.5, 1));
        let error = source("").read().unwrap_err();
        assert!(chain(&error).contains("choose one of Fox, Plain"), "{}", chain(&error));
        // A folder with the character in its name.
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("d#2");
        std::fs::create_dir(&inner).unwrap();
        std::fs::copy(&file, inner.join("h.mtlx")).unwrap();
        for (name, good) in [("h.mtlx", false), ("h.mtlx#Plain", true)] {
            let read = FiberSource { path: inner.join(name), set: vec![] }.read();
            assert_eq!(read.is_ok(), good, "{name}");
            assert!(good || chain(&read.unwrap_err()).contains("choose one of"));
        }
    }

    #[test]
    fn errors_name_the_file_or_the_setting() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let refused = |path: PathBuf, set: &[&str], parts: &[&str]| {
            let source = FiberSource { path, set: set.iter().map(|s| (*s).to_owned()).collect() };
            let text = chain(&source.read().unwrap_err());
            assert!(parts.iter().all(|part| text.contains(part)), "{text}");
        };
        let wrong = file("wrong.toml", "kappa = 2.0");
        refused(wrong.clone(), &[], &["in ", "wrong.toml: kappa = 2"]);
        refused(wrong, &["eta=1.4"], &["wrong.toml: kappa = 2"]);
        refused(file("typo.json", "{\"kapa\": 0.2}"), &[], &["typo.json", "kapa"]);
        refused("missing.json".into(), &[], &["cannot read missing.json"]);
        refused("unicorn".into(), &[], &["unknown preset 'unicorn'"]);
        refused("cat".into(), &["kappa"], &["in kappa: expected NAME=VALUE"]);
        refused("cat".into(), &["kappa=x"], &["in kappa=x: 'x' is not a number: invalid float"]);
        refused("cat".into(), &["kappa=2", "eta=1.4"], &["in kappa=2 eta=1.4: kappa = 2"]);
    }

    #[test]
    fn both_formats_are_read_as_written() {
        let folder = tempfile::tempdir().unwrap();
        let fiber = Fiber::preset(Species::Raccoon);
        for name in FiberFormat::NAMES {
            let path = folder.path().join(format!("raccoon.{name}"));
            std::fs::write(&path, name.parse::<FiberFormat>().unwrap().write(&fiber).unwrap()).unwrap();
            let source = FiberSource { path, set: Vec::new() };
            let read = source.read().unwrap();
            assert_eq!((source.name(), read.kappa, read.g), ("raccoon".to_owned(), fiber.kappa, fiber.g));
            // Angles are in degrees in a file.
            assert!((read.alpha - fiber.alpha).abs() < 1e-6 && !source.sets_color());
        }
    }
}
