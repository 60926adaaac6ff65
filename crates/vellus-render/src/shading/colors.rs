//! Colours of fibres that vary over the strands.

use vellus::{CoatColors, Fiber, Parameter};
use vellus_scene::{Look, Strands};

/// The parameters on which the table of [`CoatColors`] does not depend: those that give a fibre its colour, and water.
fn is_free(parameter: Parameter) -> bool {
    parameter.is_color() || matches!(parameter, Parameter::SigmaMa | Parameter::Wet)
}

/// The table of colours of a set of strands with the same look, if a reflectance varies over them and nothing else does
/// that the table depends on.
pub(crate) fn table(strands: &Strands, look: &Look) -> Option<CoatColors> {
    let textured = look.textured.iter().map(|(parameter, _)| *parameter);
    let mut varying = textured.chain(strands.varying.iter().map(|(parameter, _)| *parameter));
    let needed = varying.clone().any(|parameter| parameter == Parameter::Reflectance);
    (needed && varying.all(is_free)).then(|| CoatColors::new(&look.fiber).ok()).flatten()
}

/// Sets a parameter to the nearest value in its range. A `table` makes a reflectance a thousand times as fast.
pub(crate) fn set(fiber: &mut Fiber, parameter: Parameter, value: [f32; 3], table: Option<&CoatColors>) {
    match (parameter, table) {
        (Parameter::Reflectance, Some(table)) => {
            let color = value.map(|c| table.absorption(parameter.range().nearest(c)));
            *fiber = fiber.with_pigment(color);
        }
        _ => parameter.set_nearest(fiber, value),
    }
}
