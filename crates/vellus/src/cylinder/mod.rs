//! The fibre as a dielectric cylinder: directions, paths through it, and the lobes of R, TT and TRT.

pub(crate) mod azimuthal;
pub(crate) mod cuticle;
pub(crate) mod fiber_frame;
pub(crate) mod frame;
pub(crate) mod longitudinal;
pub(crate) mod path;
pub(crate) mod section;
