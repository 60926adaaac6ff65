//! The part of a fibre's width that a hit stands for: departures D15 and D16.

use super::settings::Mode;
use vellus::Window;

/// A path with a lower throughput uses the near field. The far field would take three times as long and hardly reduce
/// the noise. Measured: `docs/notes/2026-11-rendering.md`, "Faint paths".
pub(crate) const FAINT: f32 = 0.1;

/// The width of a cell, in pixels.
pub(crate) const CELL: f32 = 0.5;

/// The window of a hit at the offset `h`.
///
/// `scattered` is `None` for what the camera sees. Otherwise it has whether the last scattering event spread the path
/// over a fibre's width or more, and the path's throughput. `pixel` returns the width of a pixel in fibre radii, and
/// `chance` a number in [0, 1).
pub(super) fn window_for(
    mode: Mode,
    h: f32,
    scattered: Option<(bool, f32)>,
    pixel: impl FnOnce() -> f32,
    chance: impl FnOnce() -> f32,
) -> Window {
    match (mode, scattered) {
        (Mode::Near, _) => Window::near(h),
        (Mode::Far, _) => Window::far(),
        // D16. Samples are already spread over the pixel. A cell of half a pixel keeps the picture as sharp as its
        // filter.
        (Mode::MultiScale, None) => Window::cell(h, CELL * pixel(), chance()),
        // D15.
        (Mode::MultiScale, Some((true, throughput))) if throughput >= FAINT => Window::far(),
        (Mode::MultiScale, Some(_)) => Window::near(h),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_paths_that_are_wide_and_bright_use_the_far_field() {
        let of = |mode, scattered| window_for(mode, 0.25, scattered, || 1.0, || 0.5);
        let near = Window::near(0.25);
        for scattered in [None, Some((true, 1.0)), Some((false, 0.0))] {
            assert_eq!((of(Mode::Near, scattered), of(Mode::Far, scattered)), (near, Window::far()));
        }
        assert_eq!(of(Mode::MultiScale, Some((true, FAINT))), Window::far());
        assert_eq!([(false, 1.0), (true, 0.09)].map(|path| of(Mode::MultiScale, Some(path))), [near; 2]);
        assert_eq!(of(Mode::MultiScale, None), Window::cell(0.25, 0.5, 0.5));
    }
}
