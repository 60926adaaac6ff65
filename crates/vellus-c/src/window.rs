//! Windows of offsets.

use crate::status::Failure;
use vellus::Window;

/// The range of offsets that a hit is averaged over, from `low` to `high`, both in [−1, 1]. The near field has low =
/// high = h. Make one with the functions vellus_window_*, or fill it in. Every query checks it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VellusWindow {
    /// The smallest offset.
    pub low: f32,
    /// The largest offset.
    pub high: f32,
}

impl VellusWindow {
    /// Queries refuse it.
    const INVALID: Self = VellusWindow { low: f32::NAN, high: f32::NAN };

    fn new(window: Window) -> Self {
        let [low, high] = window.ends();
        VellusWindow { low, high }
    }

    #[inline]
    pub(crate) fn checked(self) -> Result<Window, Failure> {
        let VellusWindow { low, high } = self;
        if -1.0 <= low && low <= high && high <= 1.0 {
            return Ok(Window::range(low, high));
        }
        Err(Failure::range(if low.is_nan() {
            "the window was made from NaN, a negative width, or u outside of [0, 1)".to_owned()
        } else {
            format!("the window from {low} to {high} is not in [-1, 1]")
        }))
    }
}

/// The near field at the offset `h`, clamped to [−1, 1]. Queries refuse the result of NaN.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_window_near(h: f32) -> VellusWindow {
    vellus_window_range(h, h)
}

/// All offsets from `h1` to `h2`, in either order, clamped to [−1, 1]. Queries refuse the result of NaN.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_window_range(h1: f32, h2: f32) -> VellusWindow {
    if h1.is_nan() || h2.is_nan() { VellusWindow::INVALID } else { VellusWindow::new(Window::range(h1, h2)) }
}

/// The whole width of the fibre: the far field.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_window_far() -> VellusWindow {
    VellusWindow::new(Window::far())
}

/// What a pixel sees of the fibre. The fibre's width is divided into cells of `width` fibre radii, shifted by `u`. The
/// window is the cell with the offset `h`. `width` ≥ 0: the diameter of the pixel at the hit in fibre radii; `u`: a
/// uniform number in [0, 1). Queries refuse the result of other numbers.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_window_cell(h: f32, width: f32, u: f32) -> VellusWindow {
    let valid = !h.is_nan() && width >= 0.0 && (0.0..1.0).contains(&u);
    if valid { VellusWindow::new(Window::cell(h, width, u)) } else { VellusWindow::INVALID }
}

/// The window of a pixel as in the paper: `width` ≥ 0 fibre radii, centred on `h`. Its average over hits is not the far
/// field; vellus_window_cell() has no such bias. Queries refuse the result of other numbers.
#[unsafe(no_mangle)]
pub extern "C" fn vellus_window_pixel(h: f32, width: f32) -> VellusWindow {
    let valid = !h.is_nan() && width >= 0.0;
    if valid { VellusWindow::new(Window::pixel(h, width)) } else { VellusWindow::INVALID }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_those_of_the_model_and_nonsense_is_refused() {
        let same = |c: VellusWindow, window: Window| assert_eq!(c.checked().unwrap(), window);
        same(vellus_window_near(0.3), Window::near(0.3));
        same(vellus_window_near(7.0), Window::near(1.0));
        same(vellus_window_range(0.5, -0.25), Window::range(-0.25, 0.5));
        same(vellus_window_far(), Window::far());
        same(vellus_window_cell(0.1, 0.5, 0.3), Window::cell(0.1, 0.5, 0.3));
        same(vellus_window_cell(0.1, f32::INFINITY, 0.3), Window::far());
        same(vellus_window_pixel(0.1, 0.5), Window::pixel(0.1, 0.5));
        let nan = f32::NAN;
        for refused in [
            vellus_window_near(nan),
            vellus_window_range(0.0, nan),
            vellus_window_cell(nan, 0.5, 0.3),
            vellus_window_cell(0.1, -0.5, 0.3),
            vellus_window_cell(0.1, 0.5, 1.0),
            vellus_window_pixel(0.1, nan),
            VellusWindow { low: 0.5, high: 0.4 },
            VellusWindow { low: -1.5, high: 0.4 },
            VellusWindow { low: 0.0, high: f32::INFINITY },
        ] {
            assert!(refused.checked().is_err(), "{refused:?}");
        }
    }
}
