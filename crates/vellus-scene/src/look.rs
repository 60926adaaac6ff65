//! What a fibre looks like: constant parameters, and those a texture gives at the strand's root.

use crate::error::{Error, invalid};
use vellus::{Color, Fiber};

/// A parameter of the fibre, as scene files name it (Yan17 Table 1), or one of the ways to give its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Parameter {
    /// η
    Eta,
    /// κ
    Kappa,
    /// α, radians
    Alpha,
    /// β_m, radians
    BetaM,
    /// β_n, radians
    BetaN,
    /// σ_c,a, RGB, per fibre radius
    SigmaCa,
    /// σ_m,s, per fibre radius
    SigmaMs,
    /// σ_m,a, RGB, per fibre radius
    SigmaMa,
    /// g
    G,
    /// l
    Layers,
    /// Colour as the reflectance of an assembly of fibres, RGB ([`Color::Reflectance`]).
    Reflectance,
    /// Colour as concentrations of eumelanin and pheomelanin in the first two channels ([`Color::Melanin`]).
    Melanin,
}

impl Parameter {
    /// All of them. Colours come last: they need β_n.
    pub const ALL: [Parameter; 12] = [
        Parameter::Eta,
        Parameter::Kappa,
        Parameter::Alpha,
        Parameter::BetaM,
        Parameter::BetaN,
        Parameter::SigmaCa,
        Parameter::SigmaMs,
        Parameter::SigmaMa,
        Parameter::G,
        Parameter::Layers,
        Parameter::Reflectance,
        Parameter::Melanin,
    ];

    /// The name in files: eta, kappa, alpha, beta_m, …
    pub fn key(self) -> &'static str {
        [
            "eta",
            "kappa",
            "alpha",
            "beta_m",
            "beta_n",
            "sigma_ca",
            "sigma_ms",
            "sigma_ma",
            "g",
            "layers",
            "reflectance",
            "melanin",
        ][self as usize]
    }

    /// The one of that name.
    pub fn from_key(key: &str) -> Option<Parameter> {
        Parameter::ALL.into_iter().find(|p| p.key() == key)
    }

    /// Is it an angle, which files give in degrees?
    pub fn is_angle(self) -> bool {
        matches!(self, Parameter::Alpha | Parameter::BetaM | Parameter::BetaN)
    }

    /// Its smallest and largest value, angles in degrees. Each channel of a colour is in that range.
    pub fn range(self) -> [f32; 2] {
        match self {
            Parameter::Eta => [1.0, 3.0],
            Parameter::Kappa => [0.0, 0.99],
            Parameter::Alpha => [-45.0, 45.0],
            Parameter::BetaM | Parameter::BetaN => [0.1, 90.0],
            Parameter::SigmaCa | Parameter::SigmaMs | Parameter::SigmaMa => [0.0, 1000.0],
            Parameter::G => [0.0, 0.95],
            Parameter::Layers => [0.0, 20.0],
            Parameter::Reflectance => [0.001, 0.999],
            Parameter::Melanin => [0.0, 100.0],
        }
    }

    /// Puts a value into a fibre. A value outside of [`Parameter::range`] is replaced by the nearest in it:
    /// interpolation between pixels or points, or a texture, may leave the range.
    pub fn set(self, fiber: &mut Fiber, value: [f32; 3]) {
        let [low, high] = self.range().map(|x| if self.is_angle() { x.to_radians() } else { x });
        let value = value.map(|x| x.clamp(low, high));
        let x = value[0];
        let color = |fiber: &Fiber, color: Color| color.absorption(fiber.beta_n).unwrap_or(fiber.sigma_ca);
        match self {
            Parameter::Eta => fiber.eta = x,
            Parameter::Kappa => fiber.kappa = x,
            Parameter::Alpha => fiber.alpha = x,
            Parameter::BetaM => fiber.beta_m = x,
            Parameter::BetaN => fiber.beta_n = x,
            Parameter::SigmaCa => fiber.sigma_ca = value,
            Parameter::SigmaMs => fiber.sigma_ms = x,
            Parameter::SigmaMa => fiber.sigma_ma = value,
            Parameter::G => fiber.g = x,
            Parameter::Layers => fiber.layers = x,
            Parameter::Reflectance => {
                fiber.sigma_ca = color(fiber, Color::Reflectance(value));
            }
            Parameter::Melanin => {
                let [eumelanin, pheomelanin, _] = value;
                fiber.sigma_ca = color(fiber, Color::Melanin { eumelanin, pheomelanin });
            }
        }
    }
}

/// What a texture gives: its RGB value times `scale`, looked up at the root's uv.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// Index of the texture in the scene.
    pub texture: usize,
    /// Multiplies it.
    pub scale: [f32; 3],
}

/// A kind of fibre.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// For messages.
    pub name: String,
    /// Its parameters where nothing else gives them.
    pub fiber: Fiber,
    /// Parameters that a texture gives.
    pub textured: Vec<(Parameter, Value)>,
}

impl Look {
    /// A fibre that is the same everywhere.
    pub fn constant(name: impl Into<String>, fiber: Fiber) -> Self {
        Look { name: name.into(), fiber, textured: Vec::new() }
    }

    /// Checks the constant parameters, and that the textures exist.
    ///
    /// # Errors
    /// [`Error::Fiber`] or [`Error::Invalid`] say what is wrong.
    pub fn validate(&self, textures: usize) -> Result<(), Error> {
        self.fiber.validate().map_err(|what| Error::Fiber { place: self.name.clone(), what })?;
        match self.textured.iter().find(|(_, value)| value.texture >= textures) {
            Some((parameter, _)) => Err(invalid(&self.name, format!("{} has no such texture", parameter.key()))),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_outside_a_range_become_its_ends() {
        for parameter in Parameter::ALL {
            let [low, high] = parameter.range();
            for (given, held) in [(low - 1e4, low), (high + 1e4, high)] {
                let unit = |x: f32| if parameter.is_angle() { x.to_radians() } else { x };
                let [mut fiber, mut expected] = [Fiber::hair(); 2];
                parameter.set(&mut fiber, [unit(given); 3]);
                parameter.set(&mut expected, [unit(held); 3]);
                assert_eq!((fiber, fiber.validate()), (expected, Ok(())), "{parameter:?}");
            }
        }
    }
}
