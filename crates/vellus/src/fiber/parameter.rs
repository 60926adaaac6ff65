//! The table of a fibre's parameters: names, units, ranges. Files, options, fits and messages all read it.

use crate::error::{Error, shortest};
use crate::fiber::Fiber;
use crate::fiber::color::Color;
use crate::fiber::exit::ScatterExit;
use std::fmt;

/// A parameter of a fibre (Yan17 Table 1), or another way to give its colour.
///
/// [`Fiber`] stores all but the last three, which are other ways to give its colour ([`Color`]).
///
/// ```
/// use vellus::{Fiber, Parameter, Species};
/// let fox = Fiber::preset(Species::RedFox);
/// for parameter in Parameter::ALL {
///     if let Some(value) = parameter.get(&fox) {
///         println!("{} = {} ({})", parameter.name(), value[0], parameter.description());
///     }
/// }
/// assert_eq!(Parameter::Kappa.range().to_string(), "[0, 0.99]");
/// ```
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Parameter {
    /// κ, [`Fiber::kappa`].
    Kappa,
    /// η, [`Fiber::eta`].
    Eta,
    /// α, [`Fiber::alpha`].
    Alpha,
    /// β_m, [`Fiber::beta_m`].
    BetaM,
    /// β_n, [`Fiber::beta_n`].
    BetaN,
    /// σ_c,a, RGB, [`Fiber::sigma_ca`].
    SigmaCa,
    /// σ_m,s, [`Fiber::sigma_ms`].
    SigmaMs,
    /// σ_m,a, RGB, [`Fiber::sigma_ma`].
    SigmaMa,
    /// g, [`Fiber::g`].
    G,
    /// l, [`Fiber::layers`].
    Layers,
    /// The share of water around the fibre, [`Fiber::wet`].
    Wet,
    /// The shorter axis of the section over the longer one, [`Fiber::aspect_ratio`].
    AspectRatio,
    /// The share of air in the medulla, [`Fiber::medulla_air`].
    MedullaAir,
    /// Absorption in the medulla over that in the cortex, for colours, [`Fiber::medulla_pigment`].
    MedullaPigment,
    /// The exit of scattered light, [`Fiber::exit`]: a choice. Its number is the place in [`ScatterExit::ALL`].
    Exit,
    /// Absorption from the colour of a coat, RGB ([`Color::Reflectance`]).
    Reflectance,
    /// Absorption from the concentrations of eumelanin and pheomelanin, in this order ([`Color::Melanin`]).
    Melanin,
    /// σ_c,a from the colour of hair without medulla, RGB ([`Color::HairReflectance`]).
    HairReflectance,
}

/// The unit of a parameter in files and options.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ParameterUnit {
    /// A plain number.
    One,
    /// An angle in degrees. [`Fiber`] stores it in radians.
    Degrees,
    /// An absorption or scattering coefficient, per fibre radius (D1).
    PerRadius,
}

impl ParameterUnit {
    /// The unit after a number, in words: `" degrees"`, `" per fibre radius"` or nothing.
    pub fn suffix(self) -> &'static str {
        match self {
            ParameterUnit::One => "",
            ParameterUnit::Degrees => " degrees",
            ParameterUnit::PerRadius => " per fibre radius",
        }
    }

    /// The unit as a sign after a number in a table: `°` or nothing.
    pub fn sign(self) -> &'static str {
        if self == ParameterUnit::Degrees { "°" } else { "" }
    }

    /// A number of a file in the unit that [`Fiber`] stores: radians for an angle.
    pub fn to_stored(self, x: f32) -> f32 {
        if self == ParameterUnit::Degrees { x.to_radians() } else { x }
    }

    /// A number that [`Fiber`] stores in the unit of files: degrees for an angle.
    pub fn from_stored(self, x: f32) -> f32 {
        if self == ParameterUnit::Degrees { x.to_degrees() } else { x }
    }
}

/// The values that a parameter may have: all numbers from `low` to `high`, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterRange {
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

impl ParameterRange {
    /// Whether a value is in the range. The ends are rounded to single precision first, so that `0.99_f32` is in [0,
    /// 0.99].
    pub fn contains(&self, x: f32) -> bool {
        (self.low as f32..=self.high as f32).contains(&x)
    }

    /// The value of the range nearest to `x`; the low end for NaN.
    pub fn nearest(&self, x: f32) -> f32 {
        let [low, high] = self.ends();
        if x.is_nan() { low } else { x.clamp(low, high) }
    }

    /// Both ends in single precision.
    pub fn ends(&self) -> [f32; 2] {
        [self.low as f32, self.high as f32]
    }
}

impl fmt::Display for ParameterRange {
    /// As `[0, 0.99]`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "[{}, {}]", self.low, self.high)
    }
}

/// The row of a parameter in the table.
struct Row {
    parameter: Parameter,
    name: &'static str,
    symbol: &'static str,
    label: &'static str,
    unit: ParameterUnit,
    range: ParameterRange,
    channels: &'static [&'static str],
    choices: &'static [&'static str],
    description: &'static str,
}

const NUMBER: &[&str] = &[""];
const RGB: &[&str] = &["r", "g", "b"];
const MELANIN: &[&str] = &["eumelanin", "pheomelanin"];

const fn row(
    (parameter, name, symbol, label): (Parameter, &'static str, &'static str, &'static str),
    (unit, [low, high]): (ParameterUnit, [f64; 2]),
    channels: &'static [&'static str],
    description: &'static str,
) -> Row {
    let range = ParameterRange { low, high };
    Row { parameter, name, symbol, label, unit, range, channels, choices: &[], description }
}

const fn choice(
    (parameter, name, label): (Parameter, &'static str, &'static str),
    choices: &'static [&'static str],
    description: &'static str,
) -> Row {
    let last = (choices.len() - 1) as f64;
    Row { choices, ..row((parameter, name, name, label), (ParameterUnit::One, [0.0, last]), NUMBER, description) }
}

/// In the order of Yan17 Table 4. Colours come last: [`Color::Reflectance`] depends on all others.
#[rustfmt::skip]
#[doc(alias = "Table 1")]
const TABLE: [Row; 18] = [
    row((Parameter::Kappa, "kappa", "κ", "Medulla radius"), (ParameterUnit::One, [0.0, 0.99]), NUMBER,
        "radius of the medulla over that of the fibre; 0 is a hair without medulla"),
    row((Parameter::Eta, "eta", "η", "Refractive index"), (ParameterUnit::One, [1.0, 3.0]), NUMBER,
        "refractive index of the cortex, and of a medulla without air"),
    row((Parameter::Alpha, "alpha", "α", "Highlight shift"), (ParameterUnit::Degrees, [-45.0, 45.0]), NUMBER,
        "shift of the R highlight toward the root: 2δ at h = 0 for scales tilted by δ, about 1.33δ in the far field"),
    row((Parameter::BetaM, "beta_m", "β_m", "Roughness along"), (ParameterUnit::Degrees, [0.1, 90.0]), NUMBER,
        "longitudinal roughness, a standard deviation"),
    row((Parameter::BetaN, "beta_n", "β_n", "Roughness around"), (ParameterUnit::Degrees, [0.1, 90.0]), NUMBER,
        "azimuthal roughness, a standard deviation"),
    row((Parameter::SigmaCa, "sigma_ca", "σ_ca", "Cortex absorption"), (ParameterUnit::PerRadius, [0.0, 1000.0]), RGB,
        "absorption in the cortex"),
    row((Parameter::SigmaMs, "sigma_ms", "σ_ms", "Medulla scattering"),
        (ParameterUnit::PerRadius, [0.0, 1000.0]), NUMBER,
        "scattering in the medulla"),
    row((Parameter::SigmaMa, "sigma_ma", "σ_ma", "Medulla absorption"), (ParameterUnit::PerRadius, [0.0, 1000.0]), RGB,
        "absorption in the medulla"),
    row((Parameter::G, "g", "g", "Anisotropy"), (ParameterUnit::One, [0.0, 0.95]), NUMBER,
        "anisotropy of the scattering in the medulla (Henyey–Greenstein)"),
    row((Parameter::Layers, "layers", "l", "Cuticle layers"), (ParameterUnit::One, [0.0, 20.0]), NUMBER,
        "layers of the cuticle; 0.5 is nearly one dielectric interface"),
    row((Parameter::Wet, "wet", "wet", "Wetness"), (ParameterUnit::One, [0.0, 1.0]), NUMBER,
        "share of water around the fibre; colours are those of dry fur"),
    row((Parameter::AspectRatio, "aspect_ratio", "b/a", "Aspect ratio"), (ParameterUnit::One, [0.4, 1.0]), NUMBER,
        "shorter axis of the section over the longer one; 1 is a circle"),
    row((Parameter::MedullaAir, "medulla_air", "medulla_air", "Air in the medulla"),
        (ParameterUnit::One, [0.0, 1.0]), NUMBER,
        "share of air in the medulla, whose index is 1 + (1 - medulla_air)(eta - 1)"),
    row((Parameter::MedullaPigment, "medulla_pigment", "medulla_pigment", "Medulla pigment"),
        (ParameterUnit::One, [0.0, 10.0]), NUMBER,
        "sigma_ma over sigma_ca for a colour given as reflectance or melanin"),
    choice((Parameter::Exit, "exit", "Exit of scattered light"), &ScatterExit::NAMES,
        "how scattered light leaves the fibre: open is the paper's model"),
    row((Parameter::Reflectance, "reflectance", "reflectance", "Coat colour"),
        (ParameterUnit::One, [0.001, 0.999]), RGB,
        "sigma_ca and sigma_ma from the colour of a dense coat in white light"),
    row((Parameter::Melanin, "melanin", "melanin", "Melanin"), (ParameterUnit::One, [0.0, 100.0]), MELANIN,
        "sigma_ca and sigma_ma from concentrations of eumelanin and pheomelanin (d'Eon et al. 2011)"),
    row((Parameter::HairReflectance, "hair_reflectance", "hair_reflectance", "Hair colour (Chiang)"),
        (ParameterUnit::One, [0.001, 0.999]), RGB,
        "sigma_ca from the colour of hair without medulla (Chiang et al. 2016)"),
];

impl Parameter {
    /// All parameters: those that [`Fiber`] stores, in the order of Yan17 Table 4, then the other ways to give a
    /// colour. Several parameters can be set in this order, because [`Parameter::Reflectance`] depends on the others.
    pub const ALL: [Parameter; TABLE.len()] = {
        let mut all = [Parameter::Kappa; TABLE.len()];
        let mut i = 0;
        while i < TABLE.len() {
            all[i] = TABLE[i].parameter;
            i += 1;
        }
        all
    };

    fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// The name in files and options: `kappa`, `beta_m`, `sigma_ca`, …
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The symbol in formulas and tables: `κ`, `β_m`, `σ_ca`, …
    pub fn symbol(self) -> &'static str {
        self.row().symbol
    }

    /// The words for it in an interface: `Medulla radius`, …
    pub fn label(self) -> &'static str {
        self.row().label
    }

    /// One line of explanation, without a full stop.
    pub fn description(self) -> &'static str {
        self.row().description
    }

    /// The unit in files and options. [`Fiber`] stores angles in radians.
    pub fn unit(self) -> ParameterUnit {
        self.row().unit
    }

    /// Whether the parameter is an angle, which is in degrees in files and in radians in [`Fiber`].
    pub fn is_angle(self) -> bool {
        self.unit() == ParameterUnit::Degrees
    }

    /// The words that files and options have for the values of a choice. The value is the place of the word. Other
    /// parameters are numbers, and have none.
    pub fn choices(self) -> &'static [&'static str] {
        self.row().choices
    }

    /// Whether the parameter may vary between and along strands, and in a texture: every number, but no choice, and not
    /// the aspect ratio, which is a part of the strands' shape.
    pub fn varies(self) -> bool {
        self.choices().is_empty() && self != Parameter::AspectRatio
    }

    /// The word for a value of a choice. `None` for a number, and for a value that is no choice.
    pub fn word(self, value: f32) -> Option<&'static str> {
        let inside = value >= 0.0 && value.fract() == 0.0;
        inside.then(|| self.choices().get(value as usize).copied()).flatten()
    }

    /// The value of a word of a choice.
    ///
    /// # Errors
    /// [`Error::UnknownName`] has the words. A parameter that is a number has none.
    pub fn value_of(self, word: &str) -> Result<f32, Error> {
        let place = self.choices().iter().position(|known| *known == word);
        place.map(|place| place as f32).ok_or_else(|| Error::UnknownName {
            what: self.name(),
            name: word.to_owned(),
            known: self.choices().join(", "),
        })
    }

    /// The values allowed for each channel, in the unit of files ([`Parameter::unit`]).
    pub fn range(self) -> ParameterRange {
        self.row().range
    }

    /// The value in [`Fiber::hair`], in the form of [`Parameter::get`].
    pub fn default_value(self) -> Option<[f32; 3]> {
        self.get(&Fiber::hair())
    }

    /// How many numbers a value has: 1, 2 (melanin) or 3 (RGB).
    pub fn channels(self) -> usize {
        self.row().channels.len()
    }

    /// Whether the parameter gives the colour of the fibre. Only one such parameter may be given.
    pub fn is_color(self) -> bool {
        use Parameter::{HairReflectance, Melanin, Reflectance, SigmaCa};
        matches!(self, SigmaCa | Reflectance | Melanin | HairReflectance)
    }

    /// The name of a channel, counted from 0: `kappa`, `sigma_ca.r`, `eumelanin`. For a channel that does not exist,
    /// the name of the parameter.
    pub fn channel_name(self, channel: usize) -> String {
        match (self, self.row().channels.get(channel)) {
            (_, None | Some(&"")) => self.name().to_owned(),
            (Parameter::Melanin, Some(pigment)) => (*pigment).to_owned(),
            (_, Some(color)) => format!("{}.{color}", self.name()),
        }
    }

    /// The parameter with this name.
    pub fn from_name(name: &str) -> Option<Parameter> {
        Parameter::ALL.into_iter().find(|p| p.name() == name)
    }

    /// The parameter and the channel of a name from [`Parameter::channel_name`]. For the name of a parameter the
    /// channel is `None`.
    ///
    /// ```
    /// use vellus::Parameter;
    /// assert_eq!(Parameter::parse("sigma_ca"), Some((Parameter::SigmaCa, None)));
    /// assert_eq!(Parameter::parse("sigma_ca.g"), Some((Parameter::SigmaCa, Some(1))));
    /// assert_eq!(Parameter::parse("pheomelanin"), Some((Parameter::Melanin, Some(1))));
    /// ```
    pub fn parse(name: &str) -> Option<(Parameter, Option<usize>)> {
        if let Some(parameter) = Parameter::from_name(name) {
            return Some((parameter, None));
        }
        Parameter::ALL.into_iter().find_map(|parameter| {
            let channel = (0..parameter.channels()).find(|&c| parameter.channel_name(c) == name)?;
            Some((parameter, Some(channel)))
        })
    }

    /// The value in a fibre, in the fibre's units (radians). A single number is repeated in all channels. `None` for
    /// melanin and [`Parameter::HairReflectance`], which a fibre does not store, and for a reflectance that was not
    /// given.
    pub fn get(self, fiber: &Fiber) -> Option<[f32; 3]> {
        Some(match self {
            Parameter::Kappa => [fiber.kappa; 3],
            Parameter::Eta => [fiber.eta; 3],
            Parameter::Alpha => [fiber.alpha; 3],
            Parameter::BetaM => [fiber.beta_m; 3],
            Parameter::BetaN => [fiber.beta_n; 3],
            Parameter::SigmaCa => fiber.sigma_ca,
            Parameter::SigmaMs => [fiber.sigma_ms; 3],
            Parameter::SigmaMa => fiber.sigma_ma,
            Parameter::G => [fiber.g; 3],
            Parameter::Layers => [fiber.layers; 3],
            Parameter::Wet => [fiber.wet; 3],
            Parameter::AspectRatio => [fiber.aspect_ratio; 3],
            Parameter::MedullaAir => [fiber.medulla_air; 3],
            Parameter::MedullaPigment => [fiber.medulla_pigment; 3],
            Parameter::Exit => [f32::from(fiber.exit as u8); 3],
            Parameter::Reflectance => return fiber.reflectance,
            Parameter::Melanin | Parameter::HairReflectance => return None,
        })
    }

    /// Whether a file needs the parameter to describe a fibre: it is stored, and does not follow from the others. With
    /// a [`Fiber::reflectance`] the absorption follows from it.
    pub fn describes(self, fiber: &Fiber) -> bool {
        match self {
            Parameter::SigmaCa | Parameter::SigmaMa => fiber.reflectance.is_none(),
            // They are written only if they were given.
            Parameter::Wet | Parameter::AspectRatio | Parameter::MedullaAir | Parameter::MedullaPigment => {
                self.get(fiber) != self.default_value()
            }
            _ => self.get(fiber).is_some(),
        }
    }

    /// Sets the value in a fibre, in the fibre's units (radians). A single number comes from the first channel,
    /// melanin from the first two.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a value out of range. The fibre then stays unchanged.
    pub fn set(self, fiber: &mut Fiber, value: [f32; 3]) -> Result<(), Error> {
        self.check(value)?;
        self.store(fiber, value);
        Ok(())
    }

    /// The same, clamped to the range, and rounded for a choice. Values from textures, and values between control
    /// points, may be out of range.
    pub fn set_nearest(self, fiber: &mut Fiber, value: [f32; 3]) {
        let [low, high] = self.range().ends().map(|x| self.unit().to_stored(x));
        self.store(fiber, value.map(|x| if x.is_nan() { low } else { x.clamp(low, high) }));
    }

    fn store(self, fiber: &mut Fiber, value: [f32; 3]) {
        let [x, y, _] = value;
        // If another parameter is out of range, the colour stays unchanged, and validation names that parameter.
        let color = |fiber: &Fiber, color: Color| color.apply(*fiber).unwrap_or(*fiber);
        match self {
            Parameter::Kappa => fiber.kappa = x,
            Parameter::Eta => fiber.eta = x,
            Parameter::Alpha => fiber.alpha = x,
            Parameter::BetaM => fiber.beta_m = x,
            Parameter::BetaN => fiber.beta_n = x,
            Parameter::SigmaCa => *fiber = fiber.with_absorption(value),
            Parameter::SigmaMs => fiber.sigma_ms = x,
            Parameter::SigmaMa => *fiber = Fiber { sigma_ma: value, reflectance: None, ..*fiber },
            Parameter::G => fiber.g = x,
            Parameter::Layers => fiber.layers = x,
            Parameter::Wet => fiber.wet = x,
            Parameter::AspectRatio => fiber.aspect_ratio = x,
            Parameter::MedullaAir => fiber.medulla_air = x,
            Parameter::MedullaPigment => fiber.medulla_pigment = x,
            Parameter::Exit => fiber.exit = ScatterExit::ALL[(x.round() as usize).min(ScatterExit::ALL.len() - 1)],
            Parameter::Reflectance => *fiber = color(fiber, Color::Reflectance(value)),
            Parameter::Melanin => *fiber = color(fiber, Color::Melanin { eumelanin: x, pheomelanin: y }),
            Parameter::HairReflectance => *fiber = color(fiber, Color::HairReflectance(value)),
        }
    }

    /// Checks a value in the fibre's units (radians).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] names the first channel out of range, its value and the range in the unit of files.
    pub fn check(self, value: [f32; 3]) -> Result<(), Error> {
        for (channel, x) in value.into_iter().take(self.channels()).enumerate() {
            let x = self.unit().from_stored(x);
            let is_inside = match self.choices() {
                [] if self.is_angle() => self.contains_degrees(x),
                [] => self.range().contains(x),
                _ => self.word(x).is_some(),
            };
            if !is_inside {
                let range = match self.choices() {
                    [] => format!("it must be in {}{}", self.range(), self.unit().suffix()),
                    words => format!("it must be a number from 0, in the order {}", words.join(", ")),
                };
                return Err(Error::OutOfRange { name: self.channel_name(channel), value: shortest(x), range });
            }
        }
        Ok(())
    }

    /// Whether an angle is in its range, with a tolerance of half a millidegree. Rounded to radians, 0.1° and 90° may
    /// be just outside.
    fn contains_degrees(self, x: f32) -> bool {
        const SLACK: f32 = 5e-4;
        let [low, high] = self.range().ends();
        (low - SLACK..=high + SLACK).contains(&x)
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Species;

    #[test]
    fn the_table_has_the_order_of_the_enum_and_every_name_finds_its_parameter() {
        for (i, parameter) in Parameter::ALL.into_iter().enumerate() {
            assert_eq!(parameter as usize, i);
            assert_eq!(Parameter::parse(parameter.name()), Some((parameter, None)));
            assert!(parameter.range().low < parameter.range().high);
            for channel in 0..parameter.channels() {
                let name = parameter.channel_name(channel);
                let expected = (parameter.channels() > 1).then_some(channel);
                assert_eq!(Parameter::parse(&name), Some((parameter, expected)), "{name}");
            }
        }
        assert_eq!((Parameter::parse("colour"), Parameter::parse("sigma_ca.a")), (None, None));
        assert_eq!(Parameter::Melanin.channel_name(0), "eumelanin");
    }

    #[test]
    fn get_returns_the_value_that_was_set() {
        let fox = Fiber::preset(Species::RedFox).with_absorption([0.1, 0.2, 0.3]);
        let mut copy = Fiber::hair();
        for parameter in Parameter::ALL {
            if let Some(value) = parameter.get(&fox) {
                parameter.set(&mut copy, value).unwrap();
                assert_eq!(parameter.get(&copy), Some(value));
            }
        }
        assert_eq!(copy, fox);
    }

    #[test]
    fn values_outside_a_range_become_its_ends() {
        for parameter in Parameter::ALL {
            let [low, high] = parameter.range().ends();
            let unit = parameter.unit();
            for (given, nearest) in [(low - 1e4, low), (high + 1e4, high), (f32::NAN, low), (f32::INFINITY, high)] {
                let [mut fiber, mut expected] = [Fiber::hair(); 2];
                parameter.set_nearest(&mut fiber, [unit.to_stored(given); 3]);
                parameter.set(&mut expected, [unit.to_stored(nearest); 3]).unwrap();
                assert_eq!((fiber, fiber.validate()), (expected, Ok(())), "{parameter:?}");
                assert!(parameter.set(&mut fiber, [unit.to_stored(given); 3]).is_err(), "{parameter:?} {given}");
                assert_eq!(fiber, expected, "a refused value changes nothing");
            }
        }
    }

    #[test]
    fn a_value_out_of_range_is_named_with_the_range() {
        let error = |p: Parameter, value: [f32; 3]| p.check(value).unwrap_err().to_string();
        assert_eq!(error(Parameter::Kappa, [1.0; 3]), "kappa = 1 is out of range: it must be in [0, 0.99]");
        assert_eq!(
            error(Parameter::SigmaMa, [0.0, 0.0, -2.0]),
            "sigma_ma.b = -2 is out of range: it must be in [0, 1000] per fibre radius"
        );
        assert!(error(Parameter::BetaM, [2.0; 3]).ends_with("it must be in [0.1, 90] degrees"));
        assert!(error(Parameter::Melanin, [1.0, 101.0, 0.0]).starts_with("pheomelanin = 101"));
        assert!(error(Parameter::Exit, [0.5; 3]).contains("in the order open, reflecting"));
    }

    #[test]
    fn a_choice_has_the_number_of_its_word() {
        for exit in ScatterExit::ALL {
            let mut fiber = Fiber::hair();
            let number = Parameter::Exit.value_of(exit.name()).unwrap();
            Parameter::Exit.set(&mut fiber, [number; 3]).unwrap();
            assert_eq!((fiber.exit, Parameter::Exit.word(number)), (exit, Some(exit.name())));
        }
        assert_eq!([-1.0, 0.5, 2.0, f32::NAN].map(|x| Parameter::Exit.word(x)), [None; 4]);
        let error = Parameter::Exit.value_of("closed").unwrap_err().to_string();
        assert_eq!(error, "unknown exit 'closed': known are open, reflecting");
        assert!(Parameter::Kappa.varies() && !Parameter::Exit.varies() && !Parameter::AspectRatio.varies());
    }
}
