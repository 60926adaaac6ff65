//! What is measured.

use vellus::Fiber;

/// A fibre, and the one parameter that only the model of Yan et al. 2015 has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimen {
    /// The fibre. A model ignores the parameters that it does not have.
    pub fiber: Fiber,
    /// Refractive index of the medulla, in [1, 3], for [`ModelKind::Yan2015`](vellus_models::ModelKind::Yan2015).
    /// Without it, the medulla has the index of the cortex.
    pub eta_m: Option<f32>,
}

impl From<Fiber> for Specimen {
    /// A fibre whose medulla has the index of the cortex.
    fn from(fiber: Fiber) -> Self {
        Specimen { fiber, eta_m: None }
    }
}
