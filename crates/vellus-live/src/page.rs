//! The files of the page, embedded in the program.

use serde_json::json;
use vellus::{Fiber, Parameter, Species};

/// Name, media type and content of each file.
pub const FILES: [(&str, &str, &str); 8] = [
    ("/", "text/html; charset=utf-8", include_str!("../web/index.html")),
    ("/style.css", "text/css; charset=utf-8", include_str!("../web/style.css")),
    ("/app.js", SCRIPT, include_str!("../web/app.js")),
    ("/connection.js", SCRIPT, include_str!("../web/connection.js")),
    ("/viewport.js", SCRIPT, include_str!("../web/viewport.js")),
    ("/fiber.js", SCRIPT, include_str!("../web/fiber.js")),
    ("/panels.js", SCRIPT, include_str!("../web/panels.js")),
    ("/controls.js", SCRIPT, include_str!("../web/controls.js")),
];

const SCRIPT: &str = "text/javascript; charset=utf-8";

/// The table of parameters and the presets, as JSON: names, units, ranges and descriptions.
pub fn parameters() -> String {
    let parameter = |parameter: &Parameter| {
        let [min, max] = parameter.range().ends().map(|x| parameter.unit().from_stored(x));
        let names = (0..parameter.channels()).map(|channel| match parameter.channels() {
            1 => String::new(),
            _ => ["R", "G", "B"][channel.min(2)].to_owned(),
        });
        json!({
            "name": parameter.name(),
            "label": parameter.symbol(),
            "channels": names.collect::<Vec<_>>(),
            "min": min,
            "max": max,
            "unit": parameter.unit().sign(),
            "hint": parameter.description(),
        })
    };
    let preset = |species: &Species| json!({ "name": species.name(), "fiber": Fiber::preset(*species) });
    json!({
        "parameters": Parameter::ALL.iter().map(parameter).collect::<Vec<_>>(),
        "presets": Species::ALL.iter().map(preset).collect::<Vec<_>>(),
    })
    .to_string()
}
