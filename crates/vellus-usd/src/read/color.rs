//! Reads colours in the colour space that the stage names for them.

use crate::color::{ColorSpace, unknown};
use crate::error::Error;
use crate::image::Encoding;
use crate::read::context::Reader;
use crate::read::primvar::ancestors;
use crate::stage::{Numbers, Stage, When};
use vellus_scene::Parameter;

/// The name of the colour space of an attribute: its own, or that of the nearest prim that has one
/// (UsdColorSpaceAPI) if the attribute inherits it. `None` if there is none, or the file of an image decides.
pub(crate) fn space_name(stage: &Stage, prim: &str, name: &str, inherits: bool) -> Result<Option<String>, Error> {
    let mut found = stage.metadata(prim, name, "colorSpace")?;
    for path in ancestors(prim).filter(|_| inherits) {
        if found.is_some() {
            break;
        }
        found = stage.words(path, "colorSpace:name")?.and_then(|words| words.into_iter().next());
    }
    Ok(found.filter(|name| !["", "auto"].contains(&name.as_str())))
}

/// Whether an attribute has the type of a colour.
pub(crate) fn has_color(stage: &Stage, prim: &str, name: &str) -> Result<bool, Error> {
    Ok(stage.metadata(prim, name, "typeName")?.is_some_and(|kind| kind.starts_with("color")))
}

/// Whether a parameter is a colour. Absorptions are not: no matrix converts them.
fn is_color(parameter: Parameter) -> bool {
    matches!(parameter, Parameter::Reflectance | Parameter::HairReflectance)
}

impl Reader<'_> {
    /// The colour space with a name. A name that is not known is an error where the user named the file, and a warning
    /// where it is a part of a scene.
    pub fn color_space(&mut self, prim: &str, name: &str, space: Option<&str>) -> Result<Option<ColorSpace>, Error> {
        let Some(space) = space else { return Ok(None) };
        let known = ColorSpace::named(space);
        if known.is_none() {
            self.complain(prim, format!("{name}: {} and is ignored", unknown(space)))?;
        }
        Ok(known)
    }

    /// Numbers as [`Stage::numbers`]. Colours become linear Rec. 709.
    pub fn colors(&mut self, prim: &str, name: &str) -> Result<Option<Numbers>, Error> {
        let Some(mut numbers) = self.stage.numbers(prim, name, When::Open)? else { return Ok(None) };
        let space = space_name(self.stage, prim, name, has_color(self.stage, prim, name)?)?;
        self.convert(prim, name, space.as_deref(), &mut numbers)?;
        Ok(Some(numbers))
    }

    /// Converts colours of a space with this name. Numbers that are no colours stay as they are.
    pub fn convert(&mut self, prim: &str, name: &str, space: Option<&str>, numbers: &mut Numbers) -> Result<(), Error> {
        if numbers.lanes < 3 {
            return Ok(());
        }
        if let Some(space) = self.color_space(prim, name, space)?.filter(|space| *space != ColorSpace::LINEAR) {
            let convert = space.converter();
            for row in numbers.values.chunks_exact_mut(numbers.lanes) {
                let color = convert([row[0], row[1], row[2]].map(f64::from));
                row[..3].copy_from_slice(&color.map(|x| x as f32));
            }
        }
        Ok(())
    }

    /// The numbers of a parameter of the fibre.
    pub fn parameter(&mut self, parameter: Parameter, prim: &str, name: &str) -> Result<Option<Numbers>, Error> {
        if is_color(parameter) {
            return self.colors(prim, name);
        }
        let space = space_name(self.stage, prim, name, false)?;
        self.is_plain(parameter, prim, name, space.as_deref())?;
        self.stage.numbers(prim, name, When::Open)
    }

    /// Converts values of a parameter of the fibre in a space with this name.
    pub fn convert_parameter(
        &mut self,
        parameter: Parameter,
        prim: &str,
        name: &str,
        space: Option<&str>,
        numbers: &mut Numbers,
    ) -> Result<(), Error> {
        if is_color(parameter) {
            return self.convert(prim, name, space, numbers);
        }
        self.is_plain(parameter, prim, name, space)
    }

    /// Says that the colour space of a parameter that is no colour is ignored.
    fn is_plain(&mut self, parameter: Parameter, prim: &str, name: &str, space: Option<&str>) -> Result<(), Error> {
        match space {
            Some(space) if ColorSpace::named(space) != Some(ColorSpace::LINEAR) => {
                let what = format!("{name}: {} is no colour, so its colour space is ignored", parameter.name());
                self.complain(prim, what)
            }
            _ => Ok(()),
        }
    }

    /// How the numbers of an image are meant, by the attribute with its path. `is_color` is false for images of
    /// numbers and vectors, which only have a space if the attribute itself has one.
    pub fn encoding(&mut self, prim: &str, name: &str, is_color: bool) -> Result<Encoding, Error> {
        let space = space_name(self.stage, prim, name, is_color)?;
        let known = self.color_space(prim, name, space.as_deref())?;
        let unnamed = if is_color { Encoding::Auto } else { Encoding::Space(ColorSpace::LINEAR) };
        Ok(known.map_or(unnamed, Encoding::Space))
    }

    /// Reports something that is ignored or replaced: an error if the user named the file for this part, otherwise a
    /// warning.
    pub fn complain(&mut self, prim: &str, what: String) -> Result<(), Error> {
        if self.is_named {
            return Err(Error::prim(prim, what));
        }
        self.warnings.add(prim, what);
        Ok(())
    }
}
