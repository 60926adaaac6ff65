//! The ten species of Yan17 Table 4, and fits to them.

use crate::error::Error;
use crate::fiber::Fiber;
use crate::fiber::MEDULLA_PIGMENT;
use crate::fiber::exit::ScatterExit;
use std::fmt;
use std::str::FromStr;

/// A species of Yan17 Table 4.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum Species {
    Bobcat,
    Cat,
    Deer,
    Dog,
    Mouse,
    Rabbit,
    Raccoon,
    RedFox,
    Springbok,
    Human,
}

/// Columns: κ, η, α°, β_m°, β_n°, σ_ca, σ_ms, σ_ma, g, l, as printed.
#[rustfmt::skip]
#[doc(alias = "Table 4")]
#[allow(clippy::approx_constant, reason = "the rabbit's α is 3.14°")]
const TABLE_4: [(Species, &str, [f32; 10]); 10] = [
    (Species::Bobcat,    "bobcat",    [0.88, 1.69, 5.48, 11.64,  7.49, 0.64, 1.69, 0.17, 0.44, 0.47]),
    (Species::Cat,       "cat",       [0.87, 1.36, 3.65,  5.66,  1.34, 0.06, 2.47, 0.12, 0.60, 0.44]),
    (Species::Deer,      "deer",      [0.91, 1.60, 3.52,  7.00,  4.53, 1.39, 2.51, 0.09, 0.46, 0.45]),
    (Species::Dog,       "dog",       [0.68, 1.58, 2.94,  5.77, 18.94, 0.01, 2.44, 0.00, 0.26, 0.60]),
    (Species::Mouse,     "mouse",     [0.66, 1.35, 0.55,  8.39,  2.80, 0.04, 1.34, 0.06, 0.36, 2.36]),
    (Species::Rabbit,    "rabbit",    [0.79, 1.47, 3.14, 11.91, 10.52, 0.24, 0.78, 0.10, 0.12, 1.03]),
    (Species::Raccoon,   "raccoon",   [0.65, 1.19, 1.81,  7.44,  6.88, 0.25, 2.30, 0.14, 0.08, 2.00]),
    (Species::RedFox,    "red-fox",   [0.86, 1.49, 2.64,  9.45, 17.63, 0.39, 3.15, 0.21, 0.79, 0.68]),
    (Species::Springbok, "springbok", [0.82, 1.48, 4.61,  8.02, 11.46, 0.32, 2.45, 0.31, 0.19, 0.46]),
    (Species::Human,     "human",     [0.36, 1.20, 0.70,  2.05,  3.75, 0.41, 3.49, 0.00, 0.28, 1.79]),
];

/// κ, σ_ca, σ_ms, σ_ma, g of the same species with [`ScatterExit::Reflecting`]. The others are those of Table 4.
///
/// `vellus_fit::refit` fitted them to the far field of Table 4's fibre with [`ScatterExit::Open`], because we had no
/// access to the measurements. `cargo run --release --bin refit` in `lab/` makes this table.
#[rustfmt::skip]
const FITTED: [[f32; 5]; 10] = [
    [0.950, 0.530, 1.563, 0.069, 0.562], // bobcat
    [0.930, 0.054, 2.175, 0.080, 0.669], // cat
    [0.950, 0.902, 2.156, 0.035, 0.421], // deer
    [0.869, 0.007, 1.791, 0.000, 0.198], // dog
    [0.763, 0.035, 1.121, 0.029, 0.492], // mouse
    [0.881, 0.183, 0.788, 0.049, 0.175], // rabbit
    [0.696, 0.231, 1.842, 0.125, 0.016], // raccoon
    [0.924, 0.330, 2.092, 0.118, 0.807], // red-fox
    [0.897, 0.282, 2.041, 0.210, 0.078], // springbok
    [0.403, 0.399, 2.703, 0.000, 0.235], // human
];

/// The end of the name of a preset of Table 4.
const PUBLISHED: &str = "published";

/// A name without spaces and hyphens, in lower case.
fn plain(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase()
}

impl Species {
    /// All species, in the order of Table 4.
    pub const ALL: [Species; 10] = {
        let mut all = [Species::Bobcat; 10];
        let mut i = 0;
        while i < 10 {
            all[i] = TABLE_4[i].0;
            i += 1;
        }
        all
    };

    /// The name in files and on the command line: lower case, with hyphens.
    pub fn name(self) -> &'static str {
        TABLE_4[self as usize].1
    }

    /// [`Fiber::preset`].
    pub(crate) fn fitted(self) -> Fiber {
        let [kappa, sigma_ca, sigma_ms, sigma_ma, g] = FITTED[self as usize];
        let (sigma_ca, sigma_ma, exit) = ([sigma_ca; 3], [sigma_ma; 3], ScatterExit::Reflecting);
        Fiber { kappa, sigma_ca, sigma_ms, sigma_ma, g, exit, ..self.published() }
    }

    /// The fibre of a preset: [`Fiber::preset`] for `red-fox`, [`Fiber::published`] for `red-fox-published`.
    pub(crate) fn named(name: &str) -> Result<Fiber, Error> {
        let species = |plain: &str| plain.parse::<Species>().ok();
        let found = species(name).map(Species::fitted);
        let published = || plain(name).strip_suffix(PUBLISHED).and_then(species).map(Species::published);
        found.or_else(published).ok_or_else(|| Error::UnknownName {
            what: "preset",
            name: name.to_owned(),
            known: format!("{}, and each with -{PUBLISHED}", Species::ALL.map(Species::name).join(", ")),
        })
    }

    /// [`Fiber::published`].
    pub(crate) fn published(self) -> Fiber {
        let [kappa, eta, alpha, beta_m, beta_n, sigma_ca, sigma_ms, sigma_ma, g, layers] = TABLE_4[self as usize].2;
        Fiber {
            eta,
            kappa,
            alpha: alpha.to_radians(),
            beta_m: beta_m.to_radians(),
            beta_n: beta_n.to_radians(),
            sigma_ca: [sigma_ca; 3],
            sigma_ms,
            sigma_ma: [sigma_ma; 3],
            g,
            layers,
            wet: 0.0,
            aspect_ratio: 1.0,
            medulla_air: 0.0,
            exit: ScatterExit::Open,
            medulla_pigment: MEDULLA_PIGMENT,
            reflectance: None,
        }
    }
}

impl fmt::Display for Species {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Species {
    type Err = Error;

    /// Accepts `red-fox`, `red_fox`, `Red Fox`, `RedFox`.
    fn from_str(name: &str) -> Result<Self, Error> {
        Species::ALL.into_iter().find(|s| plain(s.name()) == plain(name)).ok_or_else(|| Error::UnknownName {
            what: "preset",
            name: name.to_owned(),
            known: Species::ALL.map(Species::name).join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_order_is_the_enum_order_and_every_preset_is_valid() {
        for (i, species) in Species::ALL.into_iter().enumerate() {
            assert_eq!(species as usize, i);
            species.published().validate().unwrap();
            species.fitted().validate().unwrap();
            assert_eq!(species.name().parse::<Species>().unwrap(), species);
        }
        assert_eq!(Species::named("red_fox"), Ok(Species::RedFox.fitted()));
        assert_eq!(Species::named("Red Fox published"), Ok(Species::RedFox.published()));
        let unknown = Species::named("published").unwrap_err().to_string();
        assert!(unknown.contains("springbok") && unknown.contains("-published"), "{unknown}");
        assert_eq!("Red Fox".parse::<Species>().unwrap(), Species::RedFox);
        let unknown = "unicorn".parse::<Species>().unwrap_err().to_string();
        assert!(unknown.contains("unicorn") && unknown.contains("springbok"), "{unknown}");
    }
}
