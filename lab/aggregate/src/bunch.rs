//! A bunch of parallel fibres in a cylinder: how much light passes between them.

use crate::error::{Error, checked};
use crate::quadrature::gauss;
use std::f64::consts::FRAC_PI_2;

/// The largest optical diameter of a bunch. That of 1,300 fibres which fill 12 % of the section is 16.
pub const MAX_TAU: f64 = 16.0;

/// The largest spread of the members' directions, in radians.
pub const MAX_SPREAD: f64 = 0.5;

/// The largest share of a bunch's section that its fibres fill, and the largest for places without overlap.
const MAX_FILL: [f64; 2] = [10.0, 0.8];

/// How far a collision carries light, in radii of the fibre: it meets the fibre at a mean of π/4 before the axis, and
/// leaves it 1 behind.
const CARRIED: f64 = 1.0 + std::f64::consts::FRAC_PI_4;

/// A bunch of near-parallel fibres at random places in a cylinder.
///
/// Lengths are measured across the axis: the inclination of light changes the path through the bunch and the distance
/// between collisions alike. So one number describes thin fibres: the optical diameter τ, their mean number on a line
/// through the axis. Thick fibres also carry light through themselves, which brings it nearer to the edge of the bunch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bunch {
    tau: f64,
    carried: f64,
    spread: f64,
}

impl Bunch {
    /// A bunch of optical diameter `tau` in [0, [`MAX_TAU`]], with parallel fibres.
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn new(tau: f64) -> Result<Self, Error> {
        let tau = checked("tau", tau, 0.0, MAX_TAU)?;
        Ok(Bunch { tau, carried: 0.0, spread: 0.0 })
    }

    /// `count` fibres of the radius `fiber` at independent random places in a cylinder of the radius `bunch`. They may
    /// overlap. Both radii have the same unit and are above 0.
    ///
    /// τ = 4 n r/(π R). The probability that light passes is within 0.02 of that of simulated bunches of 4 fibres and
    /// more.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a radius, for a share n r²/R² above 10, and for τ above [`MAX_TAU`].
    pub fn overlapping(count: u32, fiber: f64, bunch: f64) -> Result<Self, Error> {
        fill(count, fiber, bunch, MAX_FILL[0])?;
        Ok(Bunch { carried: CARRIED * fiber / bunch, ..Self::new(width(count, fiber, bunch))? })
    }

    /// As [`Bunch::overlapping`], for fibres that do not overlap.
    ///
    /// τ = 4 n r/(π R (1 − f)), with the share f = n r²/R² of the section that the fibres fill. The probability that
    /// light passes is within 0.01 of that of simulated bunches with f up to 0.12.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a radius, for f above 0.8, and for τ above [`MAX_TAU`].
    pub fn separate(count: u32, fiber: f64, bunch: f64) -> Result<Self, Error> {
        let filled = fill(count, fiber, bunch, MAX_FILL[1])?;
        Ok(Bunch { carried: CARRIED * fiber / bunch, ..Self::new(width(count, fiber, bunch) / (1.0 - filled))? })
    }

    /// The same bunch, with members that point in different directions. `spread` is the standard deviation of their
    /// inclination to the axis in each of the two planes across it, in radians, in [0, [`MAX_SPREAD`]].
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn with_spread(self, spread: f64) -> Result<Self, Error> {
        Ok(Bunch { spread: checked("spread", spread, 0.0, MAX_SPREAD)?, ..self })
    }

    /// The optical diameter τ, for light that has not collided.
    pub fn tau(&self) -> f64 {
        self.tau
    }

    /// How far a collision carries light, in radii of the bunch: (1 + π/4) r/R, or 0 for thin fibres.
    pub(crate) fn carried(&self) -> f64 {
        self.carried
    }

    /// The optical diameter for light that has collided. A collision carries it through a fibre, which adds to the
    /// distance to the next collision.
    pub(crate) fn tau_inside(&self) -> f64 {
        self.tau / (1.0 + 0.5 * self.tau * self.carried)
    }

    /// The spread of the members' directions, in radians.
    pub fn spread(&self) -> f64 {
        self.spread
    }

    /// The probability that light which meets the bunch at the offset `h` passes between its fibres. `h` is the
    /// distance from the axis over the bunch's radius, and is clamped to [−1, 1].
    ///
    /// A renderer draws this in its hit test: the ray hits with the probability 1 − `passes(h)`, and otherwise goes on.
    /// The hits then have the distribution of offsets that [`Aggregate`](crate::Aggregate) is averaged over.
    pub fn passes(&self, h: f64) -> f64 {
        let h = h.clamp(-1.0, 1.0);
        (-self.tau * (1.0 - h * h).sqrt()).exp()
    }

    /// The mean of [`Bunch::passes`] over all offsets: 1 + π/2 (L₁(τ) − I₁(τ)), with the functions of Struve and
    /// Bessel. The error is below 1e-12.
    pub fn mean_passes(&self) -> f64 {
        // h = sin γ.
        gauss(0.0, FRAC_PI_2, 4, |gamma| gamma.cos() * (-self.tau * gamma.cos()).exp())
    }
}

/// The share of the section that the fibres fill.
fn fill(count: u32, fiber: f64, bunch: f64, most: f64) -> Result<f64, Error> {
    checked("radius of the fibre", fiber, f64::MIN_POSITIVE, f64::MAX)?;
    checked("radius of the bunch", bunch, f64::MIN_POSITIVE, f64::MAX)?;
    checked("share that the fibres fill", f64::from(count) * (fiber / bunch).powi(2), 0.0, most)
}

/// 2 R σ for σ = 2 r n/(π R²).
fn width(count: u32, fiber: f64, bunch: f64) -> f64 {
    4.0 / std::f64::consts::PI * f64::from(count) * (fiber / bunch)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The series of I₁ and L₁: exact to rounding, which the difference magnifies by I₁(τ)/passes.
    #[test]
    fn mean_is_the_closed_form() {
        for tau in [0.0, 0.1, 1.0, 3.0, 6.0] {
            let half = 0.5 * f64::from(tau as f32);
            let (mut bessel, mut struve, mut gamma) = (0.0, 0.0, [1.0, 1.0]);
            let mut term = [half, half * half / (0.886_226_925_452_758 * 1.329_340_388_179_137)];
            for k in 0..60 {
                bessel += term[0];
                struve += term[1];
                gamma = [f64::from(k) + 1.0, f64::from(k) + 1.5];
                term[0] *= half * half / (gamma[0] * (gamma[0] + 1.0));
                term[1] *= half * half / (gamma[1] * (gamma[1] + 1.0));
            }
            let exact = 1.0 + FRAC_PI_2 * (struve - bessel);
            let mean = Bunch::new(f64::from(tau as f32)).unwrap().mean_passes();
            assert!((mean - exact).abs() < 1e-12, "{tau}: {mean} {exact} {gamma:?}");
        }
    }

    #[test]
    fn bad_numbers_are_named() {
        let message = |result: Result<Bunch, Error>| result.unwrap_err().to_string();
        assert_eq!(message(Bunch::new(17.0)), "tau = 17 is out of range: it must be in [0, 16]");
        assert!(message(Bunch::new(f64::NAN)).contains("NaN"));
        assert!(message(Bunch::overlapping(10, 0.0, 1.0)).contains("radius of the fibre = 0"));
        assert!(message(Bunch::separate(90, 0.1, 1.0)).contains("share that the fibres fill = 0.9"));
        assert!(message(Bunch::new(1.0).and_then(|b| b.with_spread(-0.1))).contains("spread = -0.1"));
    }

    /// The formula of the documentation: 64 fibres that fill 6 % of the section.
    #[test]
    fn optical_diameter_of_a_bunch() {
        let radius = (0.06f64 / 64.0).sqrt();
        let bunch = Bunch::overlapping(64, radius, 1.0).unwrap();
        assert!((bunch.tau() - 4.0 / std::f64::consts::PI * (64.0f64 * 0.06).sqrt()).abs() < 1e-12);
        assert!((bunch.mean_passes() - 0.170).abs() < 1e-3 && bunch.passes(1.0) == 1.0);
        let separate = Bunch::separate(64, radius, 1.0).unwrap();
        assert!((separate.tau() * 0.94 - bunch.tau()).abs() < 1e-12);
    }
}
