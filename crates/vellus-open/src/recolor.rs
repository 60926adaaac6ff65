//! Replaces the fibres of a scene.

use crate::fiber::set;
use crate::{FiberError, FiberSource};
use std::path::PathBuf;
use vellus::{Fiber, FiberBuilder, Parameter};
use vellus_scene::{Look, Scene};

/// A change of the fibres that a scene has: another fibre, or other parameters of its own fibres.
///
/// ```
/// use vellus_open::{Options, Recolor, open};
///
/// let recolor = Recolor::new(None, vec!["kappa=0.5".into()])?;
/// let options = Options { small: true, recolor: Some(recolor), ..Options::default() };
/// assert_eq!(open("hair-lock", &options)?.scene.looks[0].fiber.kappa, 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Recolor {
    /// Name and fibre that replace all fibres, with the parameters that are set. Colours that vary are lost.
    pub(crate) fiber: Option<(String, Fiber)>,
    /// Parameters that replace those of all fibres, as in [`FiberSource::set`].
    pub(crate) set: Vec<String>,
}

impl Recolor {
    /// `fiber` replaces all fibres: see [`FiberSource::path`]. `set` then replaces parameters: see
    /// [`FiberSource::set`].
    ///
    /// # Errors
    /// [`FiberError`] if the fibre cannot be read, or a setting is wrong for it (without a fibre: for the preset
    /// `red-fox`).
    pub fn new(fiber: Option<PathBuf>, set: Vec<String>) -> Result<Self, FiberError> {
        let path = fiber.clone().unwrap_or_else(|| FiberSource::default().path);
        let source = FiberSource { path, set: set.clone() };
        let read = source.read()?;
        Ok(Recolor { fiber: fiber.map(|_| (source.name(), read)), set })
    }

    /// Whether the fibres get another colour.
    pub(crate) fn changes_color(&self) -> bool {
        self.fiber.is_some() || self.replaces(Parameter::Reflectance)
    }

    /// Changes all fibres of a scene.
    ///
    /// # Errors
    /// [`FiberError::Settings`] if the settings are wrong for a fibre of the scene.
    pub(crate) fn apply(&self, scene: &mut Scene) -> Result<(), FiberError> {
        if let Some((name, fiber)) = &self.fiber {
            scene.looks = vec![Look::constant(name.clone(), *fiber)];
            for strands in scene.all_strands_mut() {
                strands.look = 0;
                strands.varying.clear();
            }
            return Ok(());
        }
        for look in &mut scene.looks {
            let mut builder = FiberBuilder::new(look.fiber);
            let wrong = |source| FiberError::Settings { option: "", settings: self.set.clone(), source };
            self.set.iter().try_for_each(|setting| set(&mut builder, setting)).map_err(wrong)?;
            look.fiber = builder.build().map_err(|error| wrong(error.into()))?;
            look.textured.retain(|(parameter, _)| !self.replaces(*parameter));
        }
        for strands in scene.all_strands_mut() {
            strands.varying.retain(|(parameter, _)| !self.replaces(*parameter));
        }
        Ok(())
    }

    /// Whether a setting replaces the values of a parameter. A colour replaces every other description of it.
    fn replaces(&self, parameter: Parameter) -> bool {
        let names = self.set.iter().filter_map(|setting| setting.split_once('='));
        let mut set = names.filter_map(|(name, _)| Parameter::parse(name.trim()));
        set.any(|(other, _)| other == parameter || (other.is_color() && parameter.is_color()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, open};
    use vellus::Species;

    fn cat(recolor: Option<Recolor>) -> Scene {
        open("cat", &Options { small: true, recolor, ..Options::default() }).unwrap().scene
    }

    #[test]
    fn built_in_scenes_are_recoloured_and_refurred() {
        let own = cat(None);
        let fiber = own.looks[0].fiber;
        // The coat of the cat has a pattern.
        assert!(own.strands.iter().any(|strands| strands.varying.iter().any(|(p, _)| p.is_color())));
        let wet = cat(Some(Recolor::new(None, vec!["beta_m=3".into()]).unwrap()));
        assert_eq!(wet.strands, own.strands);
        assert_eq!((wet.looks[0].fiber.kappa, wet.looks[0].fiber.eta), (fiber.kappa, fiber.eta));
        assert_ne!(wet.looks[0].fiber.beta_m, fiber.beta_m);
        let red = cat(Some(Recolor::new(None, vec!["sigma_ca=0.1,0.4,1".into()]).unwrap()));
        assert_eq!((red.looks[0].fiber.sigma_ca, red.looks[0].fiber.kappa), ([0.1, 0.4, 1.0], fiber.kappa));
        assert!(red.strands.iter().all(|strands| strands.varying.iter().all(|(p, _)| !p.is_color())));
        let other = cat(Some(Recolor::new(Some("raccoon".into()), Vec::new()).unwrap()));
        assert!(other.looks.len() == 1 && other.strands.iter().all(|strands| strands.varying.is_empty()));
        assert_eq!(other.looks[0].fiber, Fiber::preset(Species::Raccoon));
    }

    #[test]
    fn skin_and_exposure_of_built_in_scenes_follow_a_new_colour() {
        let cat = |set: &str| {
            let recolor = Some(Recolor::new(None, vec![set.to_owned()]).unwrap());
            let opened = open("cat", &Options { small: true, recolor, ..Options::default() }).unwrap();
            let skin = opened.scene.surfaces.iter().find(|surface| surface.name == "cat skin").unwrap();
            (skin.skin, skin.color.texture.is_some(), opened.is_metered)
        };
        assert_eq!(cat("reflectance=ginger"), (true, false, true));
        assert_eq!(cat("beta_m=3"), (false, true, false));
    }

    #[test]
    fn wrong_settings_are_refused_at_once() {
        assert!(matches!(Recolor::new(None, vec!["kapa=1".into()]), Err(FiberError::Settings { .. })));
        assert!(matches!(Recolor::new(Some("unicorn".into()), Vec::new()), Err(FiberError::Preset(_))));
    }
}
