//! A model with the names that titles need.

use vellus_models::{AnyModel, ModelKind};

/// A model of a fibre, and the names of both.
pub struct Named {
    fiber: String,
    /// Distinguishes the model; `None` for ours.
    variant: Option<String>,
    /// The model.
    pub model: AnyModel,
}

impl Named {
    /// A model of the fibre called `fiber`.
    pub fn new(fiber: impl Into<String>, kind: ModelKind, model: AnyModel) -> Self {
        let variant = (kind != ModelKind::Vellus).then(|| kind.to_string());
        Named { fiber: fiber.into(), variant, model }
    }

    /// Adds another distinction of the model, such as `η_m 1.4`.
    #[must_use]
    pub fn with_detail(mut self, detail: &str) -> Self {
        self.variant = Some(match self.variant {
            Some(variant) => format!("{variant}, {detail}"),
            None => detail.to_owned(),
        });
        self
    }

    /// The fibre and the model: `red-fox` or `red-fox, marschner2003`.
    pub fn title(&self) -> String {
        self.variant.as_ref().map_or_else(|| self.fiber.clone(), |variant| format!("{}, {variant}", self.fiber))
    }

    /// The name of the model: `vellus` or `marschner2003`.
    pub fn model_name(&self) -> &str {
        self.variant.as_deref().unwrap_or(ModelKind::Vellus.name())
    }
}
