//! The parameters of a fibre as a plain struct.

use crate::memory::{place, reference, text};
use crate::status::{Failure, VellusStatus, guard};
use std::ffi::{CStr, CString, c_char};
use std::sync::OnceLock;
use vellus::{Fiber, FiberBuilder, Parameter, ScatterExit, Species};

/// How light that the medulla scattered leaves the fibre: the values of VellusParameters.exit.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VellusExit {
    /// The cuticle does not reflect scattered light, as in the paper.
    Open = 0,
    /// The cuticle reflects scattered light from inside, as in a simulated fibre. This is the default.
    Reflecting = 1,
}

/// The parameters of a fibre. Angles are in radians. Absorption and scattering are per fibre radius. Colours are RGB.
/// Start with vellus_parameters_hair() or vellus_parameters_preset(), then change fields.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VellusParameters {
    /// Refractive index of cortex and medulla, in [1, 3].
    pub eta: f32,
    /// Radius of the medulla over that of the fibre, in [0, 0.99]. 0 is a hair without medulla.
    pub kappa: f32,
    /// Shift of the R highlight toward the root, in ±45 degrees. Scales that open toward the tip and are tilted by δ
    /// shift it by 2δ at h = 0, and by about 1.33δ in the far field.
    pub alpha: f32,
    /// Longitudinal roughness: a standard deviation, 0.1 to 90 degrees.
    pub beta_m: f32,
    /// Azimuthal roughness: a standard deviation, 0.1 to 90 degrees.
    pub beta_n: f32,
    /// Absorption in the cortex, in [0, 1000].
    pub sigma_ca: [f32; 3],
    /// Scattering in the medulla, in [0, 1000].
    pub sigma_ms: f32,
    /// Absorption in the medulla, in [0, 1000].
    pub sigma_ma: [f32; 3],
    /// Anisotropy of the scattering in the medulla (Henyey and Greenstein), in [0, 0.95].
    pub g: f32,
    /// Layers of the cuticle, in [0, 20]. 0.5 is nearly one dielectric interface.
    pub layers: f32,
    /// Share of water around the fibre, in [0, 1]. Colours are those of dry fur.
    pub wet: f32,
    /// The shorter axis of the section over the longer one, in [0.4, 1]. The longer axis is y of the fibre's frame.
    pub aspect_ratio: f32,
    /// The share of air in the medulla, in [0, 1]: its index is 1 + (1 - medulla_air)(eta - 1).
    pub medulla_air: f32,
    /// sigma_ma over sigma_ca for a colour given as reflectance or melanin, in [0, 10].
    pub medulla_pigment: f32,
    /// A VellusExit.
    pub exit: i32,
}

impl VellusParameters {
    pub(crate) fn new(fiber: &Fiber) -> Self {
        let Fiber { eta, kappa, alpha, beta_m, beta_n, sigma_ca, sigma_ms, sigma_ma, g, layers, wet, .. } = *fiber;
        let (aspect_ratio, medulla_air) = (fiber.aspect_ratio, fiber.medulla_air);
        let (medulla_pigment, exit) = (fiber.medulla_pigment, fiber.exit as i32);
        VellusParameters {
            eta,
            kappa,
            alpha,
            beta_m,
            beta_n,
            sigma_ca,
            sigma_ms,
            sigma_ma,
            g,
            layers,
            wet,
            aspect_ratio,
            medulla_air,
            medulla_pigment,
            exit,
        }
    }

    /// The fibre. Only `exit` is checked.
    pub(crate) fn fiber(&self) -> Result<Fiber, Failure> {
        let VellusParameters {
            eta, kappa, alpha, beta_m, beta_n, sigma_ca, sigma_ms, sigma_ma, g, layers, wet, ..
        } = *self;
        let exit = ScatterExit::ALL.into_iter().find(|exit| *exit as i32 == self.exit);
        let exit = exit.ok_or_else(|| Failure::range(format!("exit = {} is no VellusExit", self.exit)))?;
        let (aspect_ratio, medulla_air) = (self.aspect_ratio, self.medulla_air);
        let (medulla_pigment, reflectance) = (self.medulla_pigment, None);
        Ok(Fiber {
            eta,
            kappa,
            alpha,
            beta_m,
            beta_n,
            sigma_ca,
            sigma_ms,
            sigma_ma,
            g,
            layers,
            wet,
            aspect_ratio,
            medulla_air,
            exit,
            medulla_pigment,
            reflectance,
        })
    }
}

/// The parameters of a hair without medulla and without absorption.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameters_hair(parameters: *mut VellusParameters) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        *unsafe { place(parameters, "parameters") }? = VellusParameters::new(&Fiber::hair());
        Ok(())
    })
}

/// The names of [`Species::ALL`].
const SPECIES: [&CStr; Species::ALL.len()] =
    [c"bobcat", c"cat", c"deer", c"dog", c"mouse", c"rabbit", c"raccoon", c"red-fox", c"springbok", c"human"];

/// The number of species.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_species_count() -> usize {
    SPECIES.len()
}

/// The name of a species, such as "red-fox". It belongs to the library. Null for an index that is too large.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_species_name(index: usize) -> *const c_char {
    SPECIES.get(index).map_or(std::ptr::null(), |name| name.as_ptr())
}

/// The parameters of a preset: "red-fox" or "red-fox-published". The species are bobcat, cat, deer, dog, mouse, rabbit,
/// raccoon, red-fox, springbok and human: see vellus_species_name().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameters_preset(
    name: *const c_char,
    parameters: *mut VellusParameters,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (name, parameters) = unsafe { (text(name, "name")?, place(parameters, "parameters")?) };
        *parameters = VellusParameters::new(&Fiber::named(name)?);
        Ok(())
    })
}

/// Sets a parameter by its name in files, to `count` numbers in the units of files: angles in degrees. The names are
/// those of the fields, and "reflectance", "melanin", "eumelanin", "pheomelanin" and "hair_reflectance". A
/// channel is "sigma_ca.r". One number sets all channels of a colour. A reflectance depends on the other parameters, so
/// set it last; one that no pigment gives becomes the nearest, see vellus_parameters_nearest_reflectance(). All
/// parameters must be in their ranges.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameters_set(
    parameters: *mut VellusParameters,
    name: *const c_char,
    values: *const f32,
    count: usize,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (parameters, name) = unsafe { (place(parameters, "parameters")?, text(name, "name")?) };
        if values.is_null() {
            return Err(Failure::null("values"));
        }
        // No parameter has more than three numbers, so a wrong count reads no memory.
        if count > 3 {
            return Err(Failure::text(format!("{name} takes at most 3 numbers, not {count}")));
        }
        // SAFETY: the rules of the crate; `values` has `count` numbers.
        let values = unsafe { std::slice::from_raw_parts(values, count) };
        let mut builder = FiberBuilder::new(parameters.fiber()?);
        builder.set(name, values)?;
        *parameters = VellusParameters::new(&builder.build()?);
        Ok(())
    })
}

/// Sets a parameter that is a choice by its name in files, to a word: "exit" to "open" or "reflecting". All parameters
/// must be in their ranges.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameters_set_word(
    parameters: *mut VellusParameters,
    name: *const c_char,
    word: *const c_char,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (parameters, name, word) =
            unsafe { (place(parameters, "parameters")?, text(name, "name")?, text(word, "word")?) };
        let mut builder = FiberBuilder::new(parameters.fiber()?);
        builder.set_word(name, word)?;
        *parameters = VellusParameters::new(&builder.build()?);
        Ok(())
    })
}

/// The number of parameters: those of VellusParameters, then the other ways to give a colour.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_parameter_count() -> usize {
    Parameter::ALL.len()
}

/// A parameter of the table: what an interface shows. The texts belong to the library.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VellusParameter {
    /// The name for vellus_parameters_set() or vellus_parameters_set_word().
    pub name: *const c_char,
    /// The words for it in an interface.
    pub label: *const c_char,
    /// One line of explanation.
    pub description: *const c_char,
    /// The words of a choice, with commas between them. Null for numbers.
    pub words: *const c_char,
    /// The smallest value, angles in degrees.
    pub low: f64,
    /// The largest value.
    pub high: f64,
    /// The numbers of a value: 1, 2 (melanin) or 3 (RGB).
    pub channels: u32,
    /// 1 if it gives the colour: set it after all others.
    pub is_color: i32,
}

/// The texts of each parameter: name, label, description, words.
fn texts() -> &'static [[CString; 4]] {
    static TEXTS: OnceLock<Vec<[CString; 4]>> = OnceLock::new();
    TEXTS.get_or_init(|| {
        let row = |p: Parameter| [p.name(), p.label(), p.description(), &p.choices().join(",")].map(String::from);
        // The table has no text with a zero.
        Parameter::ALL.map(|p| row(p).map(|text| CString::new(text).unwrap_or_default())).into()
    })
}

/// The parameter with this index, in an order in which all can be set: colours come last.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameter(index: usize, parameter: *mut VellusParameter) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let out = unsafe { place(parameter, "parameter") }?;
        let (Some(row), Some(texts)) = (Parameter::ALL.get(index), texts().get(index)) else {
            return Err(Failure::range(format!("index = {index}: there are {} parameters", Parameter::ALL.len())));
        };
        let [name, label, description, words] = texts.each_ref().map(|text| text.as_ptr());
        *out = VellusParameter {
            name,
            label,
            description,
            words: if row.choices().is_empty() { std::ptr::null() } else { words },
            low: row.range().low,
            high: row.range().high,
            channels: row.channels() as u32,
            is_color: i32::from(row.is_color()),
        };
        Ok(())
    })
}

/// The reflectance that vellus_parameters_set() gives a fibre for `reflectance`, to `nearest` (3 numbers each). They
/// differ if no pigment gives the reflectance: the cuticle reflects light before pigment can absorb it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameters_nearest_reflectance(
    parameters: *const VellusParameters,
    reflectance: *const f32,
    nearest: *mut f32,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (parameters, requested, nearest) = unsafe {
            let requested = *reference(reflectance.cast::<[f32; 3]>(), "reflectance")?;
            (reference(parameters, "parameters")?, requested, place(nearest.cast::<[f32; 3]>(), "nearest")?)
        };
        let mut builder = FiberBuilder::new(parameters.fiber()?);
        builder.set("reflectance", &requested)?;
        *nearest = builder.out_of_reach()?.map_or(requested, |out| out.nearest);
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn species_have_the_names_of_rust() {
        assert_eq!(SPECIES.map(|name| name.to_str().unwrap()), Species::ALL.map(Species::name));
    }

    #[test]
    fn exits_have_the_numbers_of_rust() {
        assert_eq!([VellusExit::Open as i32, VellusExit::Reflecting as i32], ScatterExit::ALL.map(|exit| exit as i32));
    }

    #[test]
    fn parameters_there_and_back_are_the_same() {
        for fiber in Species::ALL.into_iter().flat_map(|s| [Fiber::preset(s), Fiber::published(s)]) {
            let fiber = Fiber { medulla_pigment: 0.7, wet: 0.4, aspect_ratio: 0.6, medulla_air: 0.3, ..fiber };
            let fiber = Fiber { sigma_ma: [0.1, 0.2, 0.3], ..fiber };
            assert_eq!(VellusParameters::new(&fiber).fiber().unwrap(), fiber);
        }
        let wrong = VellusParameters { exit: 2, ..VellusParameters::new(&Fiber::hair()) };
        assert!(wrong.fiber().is_err());
    }
}
