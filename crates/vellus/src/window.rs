//! The part of the fibre's width that a hit is averaged over (Yan17 Eq. 26, 27).

/// The range of azimuthal offsets that a hit is averaged over.
///
/// The offset h in [−1, 1] is the sine of the angle between ray and surface normal in the normal plane. −1 and 1 are
/// the silhouettes of the fibre. Offsets are clamped to that range. NaN gives results without meaning, and builds with
/// debug assertions panic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window([f32; 2]);

/// The kind of a window.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// A single offset.
    Near(f32),
    /// All offsets between two.
    Range([f32; 2]),
}

/// A window narrower than this, in radians of γ = asin h, counts as one offset. Exit azimuths then differ by at most
/// 4e-5, a fortieth of the narrowest allowed lobe (0.1°), around the middle: an error of (1/40)²/24 = 3e-5.
const NEAR: f32 = 1e-5;

impl Window {
    /// The near field at the offset `h`.
    pub fn near(h: f32) -> Self {
        Window::range(h, h)
    }

    /// The window of a pixel: `width` fibre radii wide, centred on `h`, cut off at the silhouettes.
    ///
    /// `width` ≥ 0 is the diameter of the pixel at the hit, times the cosine between its direction and the camera's
    /// look-at direction, divided by the fibre's radius. [`FiberFrame::pixel_width`](crate::FiberFrame::pixel_width)
    /// computes it. 0 is the near field, 4 or more the far field.
    #[doc(alias = "Eq. 27")]
    pub fn pixel(h: f32, width: f32) -> Self {
        debug_assert!(width >= 0.0, "a pixel's width is {width}");
        let h = h.clamp(-1.0, 1.0);
        Window::range(h - 0.5 * width, h + 0.5 * width)
    }

    /// The window of a pixel, without bias (D16). `width` is that of [`Window::pixel`], and `u` is uniform in [0, 1).
    ///
    /// The fibre's width is divided into cells of this width, shifted by `u`. The window is the cell that contains `h`.
    /// Hits that are spread evenly over the width then average to the far field, for any width of the cells. Windows
    /// that are centred on their hits (Yan17 Eq. 27) do not: cut off at the silhouettes, they cover the middle more
    /// often than the edges. A `width` of 2 or more, the fibre's whole width, gives the far field.
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

    /// All offsets from `h1` to `h2`, in either order.
    #[doc(alias = "Eq. 26")]
    pub fn range(h1: f32, h2: f32) -> Self {
        debug_assert!(!h1.is_nan() && !h2.is_nan(), "a window from {h1} to {h2}");
        Window(sorted(h1.clamp(-1.0, 1.0), h2.clamp(-1.0, 1.0)))
    }

    /// The whole width of the fibre: the far field of Yan17 Sec. 5.1.
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
        // The angle between the two offsets is at least their difference. NaN is the offset NaN, as for eight hits.
        if h2 - h1 >= NEAR || h2.asin() - h1.asin() >= NEAR { Kind::Range(self.0) } else { Kind::Near(0.5 * (h1 + h2)) }
    }
}

/// Two offsets in ascending order. Unlike `f32::min` and `f32::max`, this keeps a NaN.
fn sorted(h1: f32, h2: f32) -> [f32; 2] {
    if h1 > h2 { [h2, h1] } else { [h1, h2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Builds with debug assertions refuse these windows. In the others, no function may take NaN for a number.
    #[test]
    fn nan_stays_nan() {
        for (h1, h2) in [(f32::NAN, f32::NAN), (f32::NAN, 0.5), (0.5, f32::NAN)] {
            let window = Window(sorted(h1, h2));
            assert!(matches!(window.kind(), Kind::Near(h) if h.is_nan()), "{window:?}");
        }
        assert_eq!((sorted(0.5, -0.5), sorted(-0.5, 0.5)), ([-0.5, 0.5], [-0.5, 0.5]));
    }
}
