//! Over which part of the fibre's width a hit is averaged (Yan17 Eq. 26, 27).

/// The range of azimuthal offsets a hit stands for.
///
/// The offset h ∈ [−1, 1] is the sine of the angle between ray and surface normal in the normal plane: −1 and
/// 1 are the fibre's silhouettes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window([f32; 2]);

/// What a window asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// One offset.
    Near(f32),
    /// All between two.
    Range([f32; 2]),
}

/// Windows narrower than this, in radians of γ = asin h, are one offset. Exit azimuths then differ by at
/// most 4e-5, a fortieth of the narrowest lobe allowed (0.1°), around the middle: (1/40)²/24 = 3e-5 of it.
const NEAR: f32 = 1e-5;

impl Window {
    /// The near field at offset `h`. An intersection may round to just outside [−1, 1]: it is held to the
    /// range.
    pub fn near(h: f32) -> Self {
        Window::range(h, h)
    }

    /// What a pixel sees: `width` in fibre radii, centred on `h`, cut off at the silhouettes.
    ///
    /// `width` is the pixel's footprint at the hit (its diameter) times the cosine between its direction and the
    /// camera's look-at direction, over the fibre's radius. 0 is the near field, 4 or more the far field.
    #[doc(alias = "Eq. 27")]
    pub fn pixel(h: f32, width: f32) -> Self {
        debug_assert!(width >= 0.0, "a pixel's width is {width}");
        let h = h.clamp(-1.0, 1.0);
        Window::range(h - 0.5 * width, h + 0.5 * width)
    }

    /// What a pixel sees, without bias (D16): `width` as for [`Window::pixel`], and `u` uniform in [0, 1).
    ///
    /// The fibre's width is divided into cells so wide, from a place that `u` chooses; the cell that `h` is in is the window. Hits that lie evenly
    /// over the width then have the far field for their mean, whatever the width of the cells. Windows centred on their hits
    /// (Yan17 Eq. 27) have not: cut off at the silhouettes, they see the middle more often than the edges. Of 2 or more, a fibre's whole
    /// width, all of it is one cell.
    pub fn cell(h: f32, width: f32, u: f32) -> Self {
        debug_assert!(width >= 0.0 && (0.0..1.0).contains(&u), "a cell {width} wide, {u}");
        let h = h.clamp(-1.0, 1.0);
        if width >= 2.0 {
            return Window::far();
        }
        if width < NEAR {
            return Window::near(h);
        }
        let low = -1.0 + width * (((h + 1.0) / width - u).floor() + u);
        Window::range(low, low + width)
    }

    /// All offsets from `h1` to `h2`, in either order, each held to [−1, 1].
    #[doc(alias = "Eq. 26")]
    pub fn range(h1: f32, h2: f32) -> Self {
        debug_assert!(!h1.is_nan() && !h2.is_nan(), "a window from {h1} to {h2}");
        let (h1, h2) = (h1.clamp(-1.0, 1.0), h2.clamp(-1.0, 1.0));
        Window([h1.min(h2), h1.max(h2)])
    }

    /// The whole width: the far field of Yan17 Sec. 5.1.
    #[doc(alias = "Eq. 22")]
    pub fn far() -> Self {
        Window([-1.0, 1.0])
    }

    /// The smallest and the largest offset.
    pub fn ends(&self) -> [f32; 2] {
        self.0
    }

    #[inline(always)]
    pub(crate) fn kind(&self) -> Kind {
        let [h1, h2] = self.0;
        // The angle between the two offsets is at least their difference.
        if h2 - h1 < NEAR && h2.asin() - h1.asin() < NEAR { Kind::Near(0.5 * (h1 + h2)) } else { Kind::Range(self.0) }
    }
}
