//! Parts of the model for use in other fibre models. They are directions in the fibre's frame, the tables of the
//! medulla, and special functions in single precision, eight at a time.

pub use crate::choose::{Choice, choose};
pub use crate::coat::moments::{Moments, Shape};
pub use crate::coat::{Curve, NUMBERS as CURVE_NUMBERS};
pub use crate::cylinder::azimuthal::wrap;
pub use crate::cylinder::frame::{Frame, Outgoing, Polar};
pub use crate::exit::states::{INCLINATIONS, OFFSETS, STATES, cell, state};
pub use crate::exit::table::{
    ABSORPTIONS, ENTRIES, ExitData, MAX_SIN2, NODES, REACHES, ROWS, SHIPPED as SHIPPED_EXITS, STEEP, TAU_STEP,
    absorption_at, monomials,
};
pub use crate::exit::turn::MOST_TURN;
pub use crate::fiber::color::{EUMELANIN, PHEOMELANIN};
pub use crate::medulla::weighting::Weighting;
pub use crate::medulla::{Azimuth, Inclination, Medulla, Pass};
pub use crate::simd::special::{Register, bessel_i0e, exp, mills, normal_quantile};
