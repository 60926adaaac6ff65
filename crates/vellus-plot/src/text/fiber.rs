//! The presets and the parameters of a fibre.

use super::align;
use vellus::{Fiber, Parameter, Species};

/// The first channel of a parameter in the unit of files, if the fibre stores it.
fn value(parameter: Parameter, fiber: &Fiber) -> Option<f32> {
    parameter.get(fiber).map(|value| parameter.unit().from_stored(value[0]))
}

/// A table of the presets, and of the fibres of Yan17 Table 4. All are grey, so one channel is enough.
pub fn presets() -> String {
    // All presets are dry, without air, and have the same pigment in the medulla. The notes say how light leaves them.
    let alike = [Parameter::Wet, Parameter::MedullaAir, Parameter::MedullaPigment];
    let is_shown = |p: &Parameter| p.default_value().is_some() && p.varies() && !alike.contains(p);
    let stored = || Parameter::ALL.into_iter().filter(is_shown);
    let header = stored().map(|p| format!("{}{}", p.symbol(), p.unit().sign()));
    let mut rows = vec![std::iter::once(String::new()).chain(header).collect::<Vec<_>>()];
    let presets = Species::ALL.map(|species| (species.to_string(), Fiber::preset(species)));
    let published = Species::ALL.map(|species| (format!("{species}-published"), Fiber::published(species)));
    for (name, fiber) in presets.into_iter().chain(published) {
        let values = stored().filter_map(|p| value(p, &fiber)).map(|x| format!("{x:.2}"));
        rows.push(std::iter::once(name).chain(values).collect());
    }
    let notes = "The published fibres are Yan17 Table 4, for exit=open. The others are fitted to them with \
                 exit=reflecting. σ per fibre radius, grey. --fiber also reads files; --set changes a parameter.";
    format!("{}\n{notes}\n", align(&rows))
}

/// All parameters: name, meaning, range, unit, number of channels, and the value without a preset.
pub fn parameters() -> String {
    let hair = Fiber::hair();
    let mut text = String::new();
    for p in Parameter::ALL {
        let shown = |x: f32| p.word(x).map_or_else(|| format!("{x:.2}{}", p.unit().sign()), str::to_owned);
        let default = value(p, &hair).map_or(String::new(), |x| format!("; without a preset {}", shown(x)));
        let channels = match p.channels() {
            1 => "",
            2 => "; one number or two",
            _ => "; one number or three",
        };
        text += &format!("{:16} {}\n", p.name(), p.description());
        let values = match p.choices() {
            [] => format!("in {}{}", p.range(), p.unit().suffix()),
            words => words.join(" or "),
        };
        text += &format!("{:16} {values}{channels}{default}\n", "");
    }
    text + "\nThe colour is one of sigma_ca, reflectance, melanin and hair_reflectance. Single channels are \
            sigma_ca.r,\nsigma_ma.b, eumelanin, pheomelanin and so on.\n"
}
