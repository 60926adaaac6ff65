//! All models behind one type, chosen by name.

use crate::chiang::Chiang2016;
use crate::deon::DEon2011;
use crate::error::Error;
use crate::far::{Directions, average, direction};
use crate::kajiya_kay::KajiyaKay1989;
use crate::marschner::Marschner2003;
use crate::yan2015::Yan2015;
use crate::zinke_weber::ZinkeWeber2007;
use glam::Vec3;
use std::fmt;
use std::str::FromStr;
use vellus::{Bcsdf, Fiber, Lobes, Model, Sample, Scattering, Window, WindowSupport};

/// Defines the enums of names, models and hits.
macro_rules! models {
    ($($kind:ident($model:ty), $name:literal, $make:expr;)*) => {
        /// The name of a model.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[allow(missing_docs, reason = "the crate's page says what they are")]
        pub enum ModelKind {
            $($kind,)*
        }

        impl ModelKind {
            /// All models. `vellus` is the first.
            pub const ALL: &[ModelKind] = &[$(ModelKind::$kind),*];

            /// The name used on the command line and in files.
            pub fn name(self) -> &'static str {
                match self {
                    $(ModelKind::$kind => $name,)*
                }
            }

            /// Creates the model of a fibre.
            ///
            /// # Errors
            /// [`Error::Fiber`] if a parameter of the fibre is out of range.
            pub fn model(self, fiber: &Fiber) -> Result<AnyModel, Error> {
                Ok(match self {
                    $(ModelKind::$kind => {
                        let make: fn(&Fiber) -> Result<$model, vellus::Error> = $make;
                        AnyModel::$kind(make(fiber)?)
                    })*
                })
            }
        }

        /// Any of the models, chosen at run time. Renderers should be generic over [`Model`] instead.
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "the crate's page says what they are")]
        #[allow(clippy::large_enum_variant, reason = "there is one per fibre")]
        pub enum AnyModel {
            $($kind($model),)*
        }

        /// A hit of any of the models.
        #[derive(Clone, Debug)]
        #[allow(missing_docs, reason = "the crate's page says what they are")]
        #[allow(clippy::large_enum_variant, reason = "a query allocates nothing")]
        pub enum AnyHit<'a> {
            $($kind(<$model as Model>::Hit<'a>),)*
        }

        impl Model for AnyModel {
            type Hit<'a> = AnyHit<'a>;

            fn at(&self, wo: Vec3, window: Window) -> AnyHit<'_> {
                match self {
                    $(AnyModel::$kind(model) => AnyHit::$kind(Model::at(model, wo, window)),)*
                }
            }

            fn field(&self) -> WindowSupport {
                match self {
                    $(AnyModel::$kind(model) => model.field(),)*
                }
            }

            fn with_fiber(&self, fiber: &Fiber) -> Result<Self, vellus::Error> {
                Ok(match self {
                    $(AnyModel::$kind(model) => AnyModel::$kind(model.with_fiber(fiber)?),)*
                })
            }
        }

        impl Scattering for AnyHit<'_> {
            fn energy(&self) -> Lobes {
                match self {
                    $(AnyHit::$kind(hit) => Scattering::energy(hit),)*
                }
            }

            fn eval(&self, wi: Vec3) -> Lobes {
                match self {
                    $(AnyHit::$kind(hit) => Scattering::eval(hit, wi),)*
                }
            }

            fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
                match self {
                    $(AnyHit::$kind(hit) => Scattering::eval_pdf(hit, wi),)*
                }
            }

            fn sample(&self, u: [f32; 5]) -> Option<Sample> {
                match self {
                    $(AnyHit::$kind(hit) => Scattering::sample(hit, u),)*
                }
            }
        }
    };
}

models! {
    Vellus(Bcsdf<'static>), "vellus", Bcsdf::new;
    Yan2015(Yan2015), "yan2015", Yan2015::new;
    Chiang2016(Chiang2016), "chiang2016", Chiang2016::new;
    DEon2011(DEon2011), "deon2011", DEon2011::new;
    ZinkeWeber2007(ZinkeWeber2007), "zinke-weber2007", ZinkeWeber2007::new;
    Marschner2003(Marschner2003), "marschner2003", Marschner2003::new;
    KajiyaKay1989(KajiyaKay1989), "kajiya-kay1989", KajiyaKay1989::new;
}

impl AnyModel {
    /// The far field: f·cos θᵢ averaged over the width of the fibre, RGB.
    ///
    /// ω_o is at `theta_o` degrees in [−90, 90] and φ = 0. `out` gets one value for each of `directions`, and must be
    /// as long.
    pub fn far_field(&self, theta_o: f64, directions: &Directions, out: &mut [[f32; 3]]) {
        let wo = direction(theta_o, 0.0);
        match self {
            AnyModel::Chiang2016(m) => average(|h| m.at(wo, Window::near(h)), &[], directions, out),
            AnyModel::ZinkeWeber2007(m) => average(|h| m.at(wo, Window::near(h)), &[], directions, out),
            AnyModel::Yan2015(m) => average(|h| m.at(wo, Window::near(h)), &m.edges(wo), directions, out),
            AnyModel::Vellus(_) | AnyModel::DEon2011(_) | AnyModel::Marschner2003(_) | AnyModel::KajiyaKay1989(_) => {
                debug_assert!(self.field() != WindowSupport::Near);
                let hit = self.at(wo, Window::far());
                for (out, wi) in out.iter_mut().zip(directions.vectors()) {
                    *out = hit.eval(*wi).total();
                }
            }
        }
    }
}

impl ModelKind {
    /// Models by their names, or all models if one of the names is `all`.
    ///
    /// # Errors
    /// [`Error::UnknownModel`] for the first unknown name.
    pub fn list(names: &[String]) -> Result<Vec<ModelKind>, Error> {
        if names.iter().any(|name| name == "all") {
            return Ok(ModelKind::ALL.to_vec());
        }
        names.iter().map(|name| name.parse()).collect()
    }
}

impl fmt::Display for ModelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ModelKind {
    type Err = Error;

    /// Case, spaces and punctuation do not matter, and the year is optional: `yan2015`, `Yan 2015`, `zinke_weber2007`,
    /// `chiang`.
    fn from_str(name: &str) -> Result<Self, Error> {
        let plain = |s: &str| s.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
        let named = |kind: &ModelKind| {
            let known = plain(kind.name());
            plain(name) == known || plain(name) == known.trim_end_matches(|c: char| c.is_ascii_digit())
        };
        ModelKind::ALL.iter().copied().find(named).ok_or_else(|| {
            let known: Vec<_> = ModelKind::ALL.iter().map(|kind| kind.name()).collect();
            Error::UnknownModel { name: name.to_owned(), known: known.join(", ") }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for kind in ModelKind::ALL {
            assert_eq!(kind.name().parse::<ModelKind>().unwrap(), *kind);
            assert_eq!(kind.name().to_uppercase().replace('-', " ").parse::<ModelKind>().unwrap(), *kind);
            let short = kind.name().trim_end_matches(|c: char| c.is_ascii_digit());
            assert_eq!(short.parse::<ModelKind>().unwrap(), *kind);
            assert!(kind.model(&Fiber { eta: 0.5, ..Fiber::hair() }).is_err());
        }
        assert!("yan2016".parse::<ModelKind>().is_err() && "2015".parse::<ModelKind>().is_err());
        let unknown = "phong".parse::<ModelKind>().unwrap_err().to_string();
        assert!(unknown.contains("phong") && unknown.contains("chiang2016"), "{unknown}");
    }
}
