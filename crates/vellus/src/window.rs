//! Over which part of the fibre's width a query is averaged.

/// The range of azimuthal offsets a hit stands for.
///
/// Only a single offset exists so far: the near field of Yan17 Sec. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub(crate) h: f32,
}

impl Window {
    /// The near field at offset `h` ∈ [−1, 1], sine of the angle between ray and surface normal in
    /// the normal plane. An intersection may round to just outside: it is held to the range.
    pub fn near(h: f32) -> Self {
        debug_assert!(!h.is_nan(), "the offset h is NaN");
        Window { h: h.clamp(-1.0, 1.0) }
    }
}
