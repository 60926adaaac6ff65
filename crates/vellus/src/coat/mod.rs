//! The colour of a dense coat of fibres in white light, and the pigment that gives a coat a colour.
//!
//! Light in a coat is scattered many times. How much returns depends on the loss L = 1 − Σ A at a scattering and on how
//! far scattered light turns, K = Σ w (A − A⟨cos ψ⟩), summed over the lobes: in theory (van de Hulst's similarity)
//! only on s² = L/(L + K). The form of [`Curve`] and its numbers are fitted to renderings of coats.
//! `cargo run --release --bin coat_colors` in `lab/` makes the renderings and the fit.

mod curve;
pub(crate) mod moments;

use crate::error::Error;
use crate::fiber::Fiber;
use crate::fiber::parameter::Parameter;
use curve::SHIPPED;
use moments::Shape;

#[cfg(feature = "unstable")]
pub use curve::{Curve, NUMBERS};

/// Nodes of the absorption: the first is 0, the others are spaced evenly in its logarithm.
pub(crate) const NODES: usize = 97;
/// Absorption of the second and of the last node.
pub(crate) const LEAST: f32 = 1e-6;
const MOST: f32 = 1000.0;

/// The logarithm of the ratio of two nodes: ln(10⁹)/95.
pub(crate) const STEP: f32 = 20.723_266 / 95.0;

/// The largest change of a channel by which a request still counts as reached.
const TOLERANCE: f32 = 1e-4;

/// Converts between the absorption of a fibre and the colour of a dense coat of such fibres, each channel by itself.
///
/// The coat is `vellus_groom::reference_coat`: bent fur, seen from above in white light. The table of a fibre takes
/// some evaluations of the model to make, and a conversion is a search in it. It depends on all parameters of the fibre
/// except its absorption. Absorption in the cortex σ_c,a comes with σ_m,a = [`Fiber::medulla_pigment`] σ_c,a in the
/// medulla.
///
/// ```
/// use vellus::{CoatColors, Fiber, Species};
/// # fn main() -> Result<(), vellus::Error> {
/// let fox = Fiber::preset(Species::RedFox);
/// let colors = CoatColors::new(&fox)?;
/// let orange = fox.with_pigment([0.8, 0.16, 0.03].map(|c| colors.absorption(c)));
/// assert!(orange.coat_color()?.iter().zip([0.8, 0.16, 0.03]).all(|(a, b)| (a - b).abs() < 0.01));
/// # Ok(()) }
/// ```
#[derive(Clone, Debug)]
pub struct CoatColors {
    /// The colour of the coat at each node, never increasing.
    pub(crate) colors: [f32; NODES],
}

/// The absorption of a node.
fn node(i: usize) -> f32 {
    if i == 0 { 0.0 } else { (LEAST * ((i - 1) as f32 * STEP).exp()).min(MOST) }
}

impl CoatColors {
    /// The table of a fibre, dry. The absorption of the fibre does not matter.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the first parameter out of range.
    pub fn new(fiber: &Fiber) -> Result<Self, Error> {
        fiber.validate()?;
        Ok(Self::of(fiber))
    }

    /// The fibre must be valid.
    pub(crate) fn of(fiber: &Fiber) -> Self {
        let shape = Shape::new(&Fiber { wet: 0.0, ..*fiber });
        let mut colors = [1.0; NODES];
        for first in (1..NODES).step_by(3) {
            let cortex = [0, 1, 2].map(|i| node(first + i));
            let medulla = fiber.with_pigment(cortex).sigma_ma;
            for (i, moments) in shape.moments(cortex, medulla).iter().enumerate() {
                // The fit may rise by a little where it is nearly constant.
                colors[first + i] = SHIPPED.color(moments).min(colors[first + i - 1]);
            }
        }
        CoatColors { colors }
    }

    /// The absorption σ_c,a, per fibre radius, that gives a coat this colour, a reflectance in [0, 1]. The colour is
    /// clamped to [`CoatColors::range`]; NaN gives no absorption.
    pub fn absorption(&self, color: f32) -> f32 {
        // The nodes before `above` have at least this colour.
        let above = self.colors.partition_point(|c| *c >= color);
        if above == 0 || above == NODES {
            return if color <= self.colors[NODES - 1] { self.most() } else { 0.0 };
        }
        let [bright, dark] = [self.colors[above - 1], self.colors[above]];
        let t = (bright - color) / (bright - dark);
        if above == 1 { t * LEAST } else { LEAST * (((above - 2) as f32 + t) * STEP).exp() }
    }

    /// The least absorption that gives the darkest colour.
    pub(crate) fn most(&self) -> f32 {
        node(self.colors.partition_point(|c| *c > self.colors[NODES - 1]))
    }

    /// The colour of a coat whose fibres have this σ_c,a, at least 0: the inverse of [`CoatColors::absorption`].
    pub fn color(&self, absorption: f32) -> f32 {
        let absorption = absorption.clamp(0.0, MOST);
        let at = if absorption < LEAST { absorption / LEAST } else { 1.0 + (absorption / LEAST).ln() / STEP };
        let i = (at as usize).min(NODES - 2);
        self.colors[i] + (at - i as f32).min(1.0) * (self.colors[i + 1] - self.colors[i])
    }

    /// The darkest and the brightest colour that pigment can give to the coat. Light that the cuticle reflects makes
    /// the darkest one.
    pub fn range(&self) -> [f32; 2] {
        [self.colors[NODES - 1], self.colors[0]]
    }

    /// The colour of the coat that is nearest to a request, each channel by itself, if the request is out of reach.
    pub fn nearest(&self, color: [f32; 3]) -> Option<[f32; 3]> {
        let [low, high] = self.range();
        let nearest = color.map(|c| c.clamp(low, high));
        nearest.iter().zip(color).any(|(n, c)| (n - c).abs() > TOLERANCE).then_some(nearest)
    }
}

impl Fiber {
    /// The colour of a dense coat of such fibres in white light, RGB, as a reflectance in [0, 1]. Its absorption may be
    /// of any kind. See [`CoatColors`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for the first parameter out of range.
    pub fn coat_color(&self) -> Result<[f32; 3], Error> {
        self.validate()?;
        let fiber = self.in_air();
        Ok(Shape::new(&fiber).moments(fiber.sigma_ca, fiber.sigma_ma).map(|moments| SHIPPED.color(&moments)))
    }

    /// The same fibre with pigment: absorption `sigma_ca` in the cortex, and [`Fiber::medulla_pigment`] times as much
    /// in the medulla, at most 1000. RGB, per fibre radius. The values are not checked here.
    pub fn with_pigment(self, sigma_ca: [f32; 3]) -> Self {
        let [_, most] = Parameter::SigmaMa.range().ends();
        let sigma_ma = sigma_ca.map(|sigma| (self.medulla_pigment * sigma).min(most));
        Fiber { sigma_ca, sigma_ma, reflectance: None, ..self }
    }
}
