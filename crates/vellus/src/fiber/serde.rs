//! Fibres, colours, species, exits, lobes and windows in files, through serde.

use crate::error::{Error, shortest};
use crate::fiber::Fiber;
use crate::fiber::builder::{FiberBuilder, unknown};
use crate::fiber::color::Color;
use crate::fiber::exit::ScatterExit;
use crate::fiber::parameter::{Parameter, ParameterUnit};
use crate::fiber::species::Species;
use crate::lobe::Lobe;
use crate::window::Window;
use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::collections::BTreeMap;
use std::fmt;

/// A number, one for each channel, or the word of a choice.
enum Given {
    Numbers(Vec<f32>),
    Word(String),
}

impl Given {
    fn set(&self, builder: &mut FiberBuilder, name: &str) -> Result<(), Error> {
        match self {
            Given::Numbers(numbers) => builder.set(name, numbers),
            Given::Word(word) => builder.set_word(name, word),
        }
    }
}

impl<'de> Deserialize<'de> for Given {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct GivenVisitor;

        impl<'de> Visitor<'de> for GivenVisitor {
            type Value = Given;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number, an array of numbers or a word")
            }

            fn visit_f64<E: de::Error>(self, x: f64) -> Result<Given, E> {
                Ok(Given::Numbers(vec![x as f32]))
            }

            fn visit_i64<E: de::Error>(self, x: i64) -> Result<Given, E> {
                Ok(Given::Numbers(vec![x as f32]))
            }

            fn visit_u64<E: de::Error>(self, x: u64) -> Result<Given, E> {
                Ok(Given::Numbers(vec![x as f32]))
            }

            fn visit_str<E: de::Error>(self, word: &str) -> Result<Given, E> {
                Ok(Given::Word(word.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<Given, A::Error> {
                let mut numbers = Vec::new();
                while let Some(x) = values.next_element()? {
                    numbers.push(x);
                }
                Ok(Given::Numbers(numbers))
            }
        }

        deserializer.deserialize_any(GivenVisitor)
    }
}

/// A value in the units of files: one number where all channels are the same, or the word of a choice.
struct InFile(Parameter, [f32; 3]);

impl Serialize for InFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let InFile(parameter, value) = self;
        let value = if parameter.is_angle() { value.map(degrees) } else { *value };
        if let Some(word) = parameter.word(value[0]) {
            return word.serialize(serializer);
        }
        match (parameter.channels(), value) {
            (2, [x, y, _]) => [x, y].serialize(serializer),
            (3, [r, g, b]) if r != g || g != b => value.serialize(serializer),
            (_, [x, ..]) => serializer.serialize_f32(x),
        }
    }
}

/// The shortest number of degrees, with at least four decimals, that converts to this angle in radians: 5.48, not
/// 5.4800005. No number of degrees in single precision converts to some angles. They become one of the two nearest.
fn degrees(radians: f32) -> f32 {
    let exact = ParameterUnit::Degrees.from_stored(radians);
    let rounded = (4..8).map(|decimals| {
        let scale = 10f64.powi(decimals);
        ((shortest(exact) * scale).round() / scale) as f32
    });
    let adjacent = [exact, exact.next_down(), exact.next_up()];
    rounded.chain(adjacent).find(|x| ParameterUnit::Degrees.to_stored(*x) == radians).unwrap_or(exact)
}

impl Serialize for Fiber {
    /// A map of the parameters that a fibre stores, in the order of [`Parameter::ALL`].
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let describing = Parameter::ALL.into_iter().filter(|p| p.describes(self));
        let stored: Vec<_> = describing.filter_map(|p| p.get(self).map(|value| (p, value))).collect();
        let mut map = serializer.serialize_map(Some(stored.len()))?;
        for (parameter, value) in stored {
            map.serialize_entry(parameter.name(), &InFile(parameter, value))?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Fiber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        FiberBuilder::deserialize(deserializer)?.build().map_err(de::Error::custom)
    }
}

impl<'de> Deserialize<'de> for FiberBuilder {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct MapVisitor;

        impl<'de> Visitor<'de> for MapVisitor {
            type Value = FiberBuilder;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a map of the parameters of a fibre")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<FiberBuilder, A::Error> {
                let mut base = Fiber::hair();
                let mut settings: Vec<(String, Given)> = Vec::new();
                let mut has_preset = false;
                while let Some(name) = map.next_key::<String>()? {
                    if settings.iter().any(|(known, _)| *known == name) || (name == "preset" && has_preset) {
                        return Err(de::Error::custom(format!("{name} is given twice")));
                    }
                    if name == "preset" {
                        let preset = map.next_value::<String>()?;
                        (base, has_preset) = (Fiber::named(&preset).map_err(de::Error::custom)?, true);
                    } else if Parameter::parse(&name).is_none() {
                        return Err(de::Error::custom(unknown(&name)));
                    } else {
                        settings.push((name, map.next_value()?));
                    }
                }
                // The preset may follow the channels of a colour, which start with the preset's values.
                let mut builder = FiberBuilder::new(base);
                for (name, given) in &settings {
                    given.set(&mut builder, name).map_err(de::Error::custom)?;
                }
                Ok(builder)
            }
        }

        deserializer.deserialize_map(MapVisitor)
    }
}

/// A colour is a map of one parameter: `sigma_ca`, `reflectance`, `melanin` (or its pigments by name)
/// or `hair_reflectance`.
impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (parameter, value) = self.parameter();
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(parameter.name(), &InFile(parameter, value))?;
        map.end()
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut builder = FiberBuilder::default();
        for (name, given) in BTreeMap::<String, Given>::deserialize(deserializer)? {
            if Parameter::parse(&name).is_none_or(|(parameter, _)| !parameter.is_color()) {
                let known = "sigma_ca, reflectance, melanin, eumelanin, pheomelanin, hair_reflectance";
                return Err(de::Error::custom(Error::UnknownParameter { name, known: known.to_owned() }));
            }
            given.set(&mut builder, &name).map_err(de::Error::custom)?;
        }
        builder.build().map_err(de::Error::custom)?;
        builder.color().map_err(de::Error::custom)?.ok_or_else(|| de::Error::custom("a colour is missing"))
    }
}

macro_rules! names {
    ($($type:ty),*) => {$(
        /// Its name.
        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
            }
        }
    )*};
}

names!(Species, ScatterExit, Lobe);

/// A window is its two ends: `[-0.5, 0.25]`.
impl Serialize for Window {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.ends().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Window {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let [low, high] = <[f32; 2]>::deserialize(deserializer)?;
        for (name, value) in [("window[0]", low), ("window[1]", high)] {
            if !(-1.0..=1.0).contains(&value) {
                let (value, range) = (shortest(value), "an offset must be in [-1, 1]".to_owned());
                return Err(de::Error::custom(Error::OutOfRange { name: name.to_owned(), value, range }));
            }
        }
        if low > high {
            return Err(de::Error::custom(format!(
                "window = [{low}, {high}]: the first end must not be above the second"
            )));
        }
        Ok(Window::range(low, high))
    }
}
