//! The parameters of one fibre, prepared for its hits.

use crate::cylinder::azimuthal::Azimuthal;
use crate::cylinder::longitudinal::Longitudinal;
use crate::cylinder::section::Section;
use crate::exit::Reflection;
use crate::exit::table::ExitTable;
use crate::exit::turn::Turning;
use crate::fiber::Fiber;
use crate::medulla::Medulla;
use crate::medulla::tables::Tables;
use std::ops::Deref;

/// Everything about a fibre that all its hits need.
#[derive(Clone, Debug)]
pub(crate) struct Prepared<'t> {
    /// The fibre as it was given.
    pub fiber: Fiber,
    /// [`Fiber::in_air`], whose parameters are those of the model.
    pub in_air: Fiber,
    /// The section, unless it is a circle of one index.
    pub section: Option<Section>,
    pub longitudinal: Longitudinal,
    pub azimuthal: Azimuthal,
    pub medulla: Medulla<'t>,
    /// The exit of scattered light, if the cuticle reflects it.
    pub reflection: Option<Reflection>,
    /// How the cuticle turns it in azimuth.
    pub turning: Option<Turning>,
    /// True if a window takes more segments than usual.
    pub fine: bool,
}

/// A fibre that a hit borrows.
pub(crate) type Shared<'b> = &'b Prepared<'b>;

/// A fibre that is a part of its hit.
#[derive(Clone, Debug)]
pub(crate) struct Owned(pub Prepared<'static>);

impl Deref for Owned {
    type Target = Prepared<'static>;

    #[inline(always)]
    fn deref(&self) -> &Prepared<'static> {
        &self.0
    }
}

impl<'t> Prepared<'t> {
    /// Whether the section is no circle, so that offsets h and −h differ.
    #[inline(always)]
    pub fn is_flat(&self) -> bool {
        self.in_air.aspect_ratio < 1.0
    }

    /// The fibre must be valid.
    pub fn new(given: &Fiber, tables: &'t Tables) -> Self {
        let fiber = &given.in_air();
        let section = Section::of(fiber);
        let medulla = Medulla::new(fiber, tables);
        let table = ExitTable::shipped;
        let cone = medulla.cone.as_ref().map(|(cone, _)| cone);
        let reflection = cone.map(|_| Reflection::new(fiber, table()));
        let turning = cone.zip(reflection.as_ref()).map(|(cone, r)| Turning::new(fiber, cone, r.stays, table()));
        Prepared {
            fiber: *given,
            in_air: *fiber,
            section,
            longitudinal: Longitudinal::new(fiber),
            azimuthal: Azimuthal::new(fiber),
            medulla,
            reflection,
            turning,
            fine: fiber.needs_fine_windows() || fiber.aspect_ratio < 1.0,
        }
    }
}
