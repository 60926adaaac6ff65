//! Builds a fibre from named values, as files and options contain them.

use crate::coat::CoatColors;
use crate::error::Error;
use crate::fiber::Fiber;
use crate::fiber::color::Color;
use crate::fiber::parameter::Parameter;
use std::fmt;

/// Named values of parameters, and a base fibre for the parameters without a value.
///
/// Values may come in any order: the builder converts a colour at the end, when all others are known, and refuses a
/// second colour. Later values of the same parameter replace earlier ones.
///
/// With the feature `serde`, a builder is read from a map: parameters by name, and `preset`, a name of
/// [`Fiber::named`] ([`Fiber::hair`] without one). `exit` is a word ([`Parameter::choices`]). Unknown names are
/// errors. Ranges are only checked by [`FiberBuilder::build`].
///
/// ```
/// use vellus::{Fiber, FiberBuilder, Species};
/// # fn main() -> Result<(), vellus::Error> {
/// let mut builder = FiberBuilder::new(Fiber::preset(Species::Cat));
/// builder.set("alpha", &[3.0])?;                  // degrees
/// builder.set("melanin", &[1.3, 0.2])?;           // eumelanin, pheomelanin
/// let fiber = builder.build()?;
/// assert_eq!(fiber.alpha, 3_f32.to_radians());
///
/// builder.set("sigma_ca", &[0.1])?;
/// let error = builder.build().unwrap_err().to_string();
/// assert!(error.contains("more than once"));
/// # Ok(()) }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FiberBuilder {
    base: Fiber,
    /// In the units of a fibre, indexed by parameter.
    values: [Option<[f32; 3]>; Parameter::ALL.len()],
}

impl FiberBuilder {
    /// A builder without values. It builds `base`.
    pub fn new(base: Fiber) -> Self {
        FiberBuilder { base, values: [None; Parameter::ALL.len()] }
    }

    /// Sets a parameter by its name ([`Parameter::parse`]) to numbers in the units of files: angles in degrees. One
    /// number sets all channels of an RGB parameter. For melanin it sets only eumelanin.
    ///
    /// # Errors
    /// [`Error::UnknownParameter`] or [`Error::Channels`]. Ranges are checked by [`FiberBuilder::build`].
    pub fn set(&mut self, name: &str, numbers: &[f32]) -> Result<(), Error> {
        let (parameter, channel) = Parameter::parse(name).ok_or_else(|| unknown(name))?;
        let expected = channel.map_or_else(|| expected(parameter), |_| "one number");
        let stored = |x: f32| parameter.unit().to_stored(x);
        let value = match (channel, numbers) {
            (Some(channel), &[x]) => {
                let before = self.values[parameter as usize].or_else(|| parameter.get(&self.base));
                let mut value = before.unwrap_or([0.0; 3]);
                value[channel] = stored(x);
                value
            }
            (None, &[x]) if parameter == Parameter::Melanin => [x, 0.0, 0.0],
            (None, &[x]) => [stored(x); 3],
            (None, &[x, y]) if parameter.channels() == 2 => [stored(x), stored(y), 0.0],
            (None, &[x, y, z]) if parameter.channels() == 3 => [stored(x), stored(y), stored(z)],
            _ => return Err(Error::Channels { name: name.to_owned(), expected, found: numbers.len() }),
        };
        self.set_value(parameter, value);
        Ok(())
    }

    /// Sets a parameter to a value in the units of a fibre (radians), in the form of [`Parameter::set`].
    pub fn set_value(&mut self, parameter: Parameter, value: [f32; 3]) {
        self.values[parameter as usize] = Some(value);
    }

    /// Sets a parameter by its name to a word: a choice, such as `exit` to `open`.
    ///
    /// # Errors
    /// [`Error::UnknownParameter`], [`Error::UnknownName`] for an unknown word, or [`Error::NoWord`] for a parameter
    /// that takes numbers.
    pub fn set_word(&mut self, name: &str, word: &str) -> Result<(), Error> {
        let (parameter, _) = Parameter::parse(name).ok_or_else(|| unknown(name))?;
        if parameter.choices().is_empty() {
            return Err(Error::NoWord { name: name.to_owned(), expected: expected(parameter) });
        }
        self.set_value(parameter, [parameter.value_of(word)?; 3]);
        Ok(())
    }

    /// The colour, if one was given.
    ///
    /// # Errors
    /// [`Error::ColorTwice`] for a second colour.
    pub fn color(&self) -> Result<Option<Color>, Error> {
        let mut colors = self.given().filter(|(parameter, _)| parameter.is_color());
        let Some((first, value)) = colors.next() else { return Ok(None) };
        if let Some((second, _)) = colors.next() {
            return Err(Error::ColorTwice { first: first.name(), second: second.name() });
        }
        let [eumelanin, pheomelanin, _] = value;
        Ok(Some(match first {
            Parameter::Reflectance => Color::Reflectance(value),
            Parameter::HairReflectance => Color::HairReflectance(value),
            Parameter::Melanin => Color::Melanin { eumelanin, pheomelanin },
            _ => Color::Absorption(value),
        }))
    }

    /// The request and the nearest colour of a coat of these fibres, if a reflectance was given that no pigment
    /// reaches.
    ///
    /// # Errors
    /// As [`FiberBuilder::build`].
    pub fn out_of_reach(&self) -> Result<Option<OutOfReach>, Error> {
        let Some(Color::Reflectance(requested)) = self.color()? else { return Ok(None) };
        let nearest = CoatColors::new(&self.build()?)?.nearest(requested);
        Ok(nearest.map(|nearest| OutOfReach { requested, nearest }))
    }

    /// Builds the fibre. A reflectance out of reach gives the nearest colour.
    ///
    /// # Errors
    /// [`Error::ColorTwice`] for a second colour, [`Error::OutOfRange`] for a value out of range.
    pub fn build(&self) -> Result<Fiber, Error> {
        let recolored = self.color()?.is_some();
        let mut fiber = self.base;
        self.given().try_for_each(|(parameter, value)| parameter.set(&mut fiber, value))?;
        // The base keeps its colour if other parameters change.
        if let (Some(color), false) = (fiber.reflectance, recolored || *self == FiberBuilder::new(self.base)) {
            Parameter::Reflectance.set(&mut fiber, color)?;
        }
        fiber.validate()?;
        Ok(fiber)
    }

    /// The values that were given, in the order of [`Parameter::ALL`].
    fn given(&self) -> impl Iterator<Item = (Parameter, [f32; 3])> {
        Parameter::ALL.into_iter().filter_map(|p| self.values[p as usize].map(|value| (p, value)))
    }
}

/// A colour that a coat of fibres cannot have, because the cuticle reflects light before pigment can absorb it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfReach {
    /// The requested reflectance.
    pub requested: [f32; 3],
    /// The nearest reflectance that pigment gives.
    pub nearest: [f32; 3],
}

impl fmt::Display for OutOfReach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [[r, g, b], [x, y, z]] = [self.requested, self.nearest.map(rounded)];
        write!(f, "no pigment gives this fibre the reflectance {r}, {g}, {b}: ")?;
        write!(f, "the nearest is {x}, {y}, {z}, because the cuticle reflects the rest")
    }
}

/// The number with four significant digits. A colour that is out of reach differs from the nearest one by more: see
/// [`CoatColors::nearest`].
fn rounded(x: f32) -> f32 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

impl Default for FiberBuilder {
    /// Builds [`Fiber::hair`].
    fn default() -> Self {
        FiberBuilder::new(Fiber::hair())
    }
}

/// The numbers that a parameter takes, in words.
fn expected(parameter: Parameter) -> &'static str {
    match parameter.channels() {
        1 => "one number",
        2 => "one number or two",
        _ => "one number or three",
    }
}

/// The error for an unknown name.
pub(super) fn unknown(name: &str) -> Error {
    let mut known: Vec<String> = Vec::new();
    for parameter in Parameter::ALL {
        known.push(parameter.name().to_owned());
        if parameter == Parameter::Melanin {
            known.extend((0..parameter.channels()).map(|channel| parameter.channel_name(channel)));
        }
    }
    Error::UnknownParameter { name: name.to_owned(), known: known.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Species;

    fn built(base: Fiber, settings: &[(&str, &[f32])]) -> Result<Fiber, Error> {
        let mut builder = FiberBuilder::new(base);
        settings.iter().try_for_each(|(name, numbers)| builder.set(name, numbers))?;
        builder.build()
    }

    #[test]
    fn values_replace_those_of_the_base() {
        let cat = Fiber::preset(Species::Cat);
        assert_eq!(built(cat, &[]), Ok(cat));
        let expected = Fiber { beta_m: 4f32.to_radians(), sigma_ma: [0.1, 0.3, 0.5], ..cat };
        assert_eq!(
            built(cat, &[("sigma_ma", &[0.1, 0.2, 0.5]), ("sigma_ma.g", &[0.3]), ("beta_m", &[4.0])]),
            Ok(expected)
        );
        assert_eq!(built(cat, &[("sigma_ma.g", &[0.3])]).unwrap().sigma_ma, [cat.sigma_ma[0], 0.3, cat.sigma_ma[2]]);
    }

    #[test]
    fn a_colour_is_converted_with_the_roughness_that_is_given_after_it() {
        let expected = Fiber { beta_n: 20f32.to_radians(), ..Fiber::hair() };
        let expected = expected.with_color(Color::Reflectance([0.5, 0.4, 0.3])).unwrap();
        assert_eq!(built(Fiber::hair(), &[("reflectance", &[0.5, 0.4, 0.3]), ("beta_n", &[20.0])]), Ok(expected));
    }

    /// A fibre knows the reflectance that its pigment comes from, until the absorption is set in another way.
    #[test]
    fn a_reflectance_is_kept_until_another_colour_replaces_it() {
        let color = [0.5, 0.4, 0.3];
        let fiber = built(Fiber::hair(), &[("reflectance", &color)]).unwrap();
        assert_eq!((fiber.reflectance, Parameter::Reflectance.get(&fiber)), (Some(color), Some(color)));
        assert!(Parameter::Reflectance.describes(&fiber) && !Parameter::SigmaMa.describes(&fiber));
        // Another parameter keeps the colour, and needs other pigment.
        let wider = built(fiber, &[("beta_n", &[20.0])]).unwrap();
        assert_eq!(
            wider,
            Fiber { beta_n: 20f32.to_radians(), ..Fiber::hair() }.with_color(Color::Reflectance(color)).unwrap()
        );
        for setting in [("sigma_ca", &[0.1][..]), ("sigma_ma", &[0.1]), ("melanin", &[1.0])] {
            assert_eq!(built(fiber, &[setting]).unwrap().reflectance, None, "{setting:?}");
        }
        assert_eq!(fiber.without_absorption().reflectance, None);
    }

    #[test]
    fn melanin_has_three_spellings() {
        let brown = Fiber::hair().with_color(Color::Melanin { eumelanin: 1.3, pheomelanin: 0.2 });
        let spellings: [&[(&str, &[f32])]; 3] = [
            &[("melanin", &[1.3, 0.2])],
            &[("pheomelanin", &[0.2]), ("eumelanin", &[1.3])],
            &[("melanin", &[1.3]), ("pheomelanin", &[0.2])],
        ];
        for settings in spellings {
            assert_eq!(built(Fiber::hair(), settings), brown);
        }
    }

    /// Dark colours differ in the fourth decimal.
    #[test]
    fn a_colour_out_of_reach_and_the_nearest_have_different_digits() {
        let out = OutOfReach { requested: [0.5, 0.001, 0.001], nearest: [0.5, 0.001_302_4, 0.012_345_6] };
        let expected = "reflectance 0.5, 0.001, 0.001: the nearest is 0.5, 0.001302, 0.01235, because";
        assert!(out.to_string().contains(expected), "{out}");
    }

    #[test]
    fn bad_values_are_named() {
        let error = |settings: &[(&str, &[f32])]| built(Fiber::hair(), settings).unwrap_err().to_string();
        assert!(error(&[("colour", &[1.0])]).contains("unknown parameter 'colour': known are kappa, eta, alpha"));
        assert_eq!(error(&[("kappa", &[0.1; 3])]), "kappa takes one number, not 3");
        assert_eq!(error(&[("sigma_ca", &[0.1; 2])]), "sigma_ca takes one number or three, not 2");
        assert_eq!(error(&[("sigma_ca.r", &[0.1; 2])]), "sigma_ca.r takes one number, not 2");
        assert_eq!(error(&[("melanin", &[])]), "melanin takes one number or two, not 0");
        let mut builder = FiberBuilder::default();
        let mut word = |name, word| builder.set_word(name, word).unwrap_err().to_string();
        assert_eq!(word("exit", "closed"), "unknown exit 'closed': known are open, reflecting");
        assert_eq!(word("kappa", "thin"), "kappa takes one number, not a word");
        assert!(word("colour", "red").contains("unknown parameter 'colour'"));
        assert!(error(&[("melanin", &[1.0]), ("reflectance", &[0.5])]).contains("by reflectance and by melanin"));
        assert!(error(&[("kappa", &[1.0])]).contains("kappa = 1 is out of range: it must be in [0, 0.99]"));
    }
}
