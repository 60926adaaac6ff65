//! The colour of a coat as a function of the moments of its fibres.

use crate::coat::moments::Moments;

/// How many numbers a curve has.
pub const NUMBERS: usize = 13;

/// The fitted form R = ((1 − s)/(1 + c s))ᵉ with s = (L/(L + K))ʰ, e = e₀ + e₁ g + e₂ g⁴ and h = h₀ + h₁ g + h₂ g⁴. g
/// is the mean cosine of all scattered light. The terms with g⁴ are 0 for g < 0.
///
/// The theory of isotropic scattering has e = 1, h = 1/2. Without absorption R is 1 exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// w of the six lobes, then c, the three e and the three h.
    pub numbers: [f32; NUMBERS],
}

/// Fitted to the colours of 600 coats, three absorptions each.
pub(crate) const SHIPPED: Curve = Curve {
    numbers: [1.3194, 2.8304, 3.3330, 2.6233, 3.8307, 2.8611, 13.7015, 0.9362, 0.2528, 0.3962, 0.7073, 0.1462, 0.5527],
};

impl Curve {
    /// R.
    pub fn color(&self, moments: &Moments) -> f32 {
        let [weights @ .., c, e0, e1, e2, h0, h1, h2] = self.numbers;
        let [mut kept, mut forward, mut turned] = [0.0f32; 3];
        for ([share, along], weight) in moments.iter().zip(weights) {
            kept += share;
            forward += along;
            turned += weight.abs() * (share - along).max(0.0);
        }
        let loss = (1.0 - kept).max(0.0);
        let g = (forward / kept.max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0);
        let peak = g.max(0.0).powi(4);
        let (e, h) = (e0 + g * e1 + peak * e2, h0 + g * h1 + peak * h2);
        let s = (loss / (loss + turned + f32::MIN_POSITIVE)).powf(h.max(0.05));
        ((1.0 - s) / (1.0 + c.abs() * s)).powf(e.max(0.05))
    }
}
