//! The fibre panel and the views of a fibre for web pages: answers in JSON, and the web modules that ask for them.
//!
//! [`answer`] takes a request in JSON and returns the answer in JSON. It never panics. A bad request gets
//! `{"error": "…"}`. [`FILES`] has the web modules. A server sends them as they are; the fibre explorer, a static page,
//! calls [`answer`] through WebAssembly.
//!
//! A fibre is an object with the parameters of [`vellus::FiberBuilder`], also `preset` and colours. Angles are in
//! degrees. `theta` is the inclination θ_o, in [−89, 89]. A hit is at `h` in [−1, 1], or over `window`, two offsets in
//! that range. Without either, it is the whole width. Lobes are in the order of [`vellus::Lobe`]; colours are RGB.
//!
//! | `ask` | other fields | answer |
//! |---|---|---|
//! | `parameters` | | `parameters`, `presets`, `lobes`, `base` (the fibre that missing parameters come from) |
//! | `check` | `fiber` | `fiber` with every parameter, `coat` (colour of a dense coat), `note` or null |
//! | `color` | `fiber`, and `melanin` or `reflectance` or `hair_reflectance` | as `check` |
//! | `section` | `fiber`, `theta`, `h`, `paths` (0 to 64), `seed` | `medulla` (radius), `rays`, `scattered` |
//! | `polar` | `fiber`, `theta`, hit, `samples` (8 to 720) | `phi` (degrees), `lobes` (6 × samples × 3, per radian) |
//! | `longitudinal` | the same | `theta_i` (degrees), `lobes` (6 × samples × 3, per radian) |
//! | `profile` | `fiber`, `theta`, hit, `rows`, `columns` (2 to 180, 2 to 360) | `values` (rows × columns × 3) |
//! | `values` | `fiber`, `queries` (rows: both ends of the window, ω_o, ω_i) | `values` (RGB, f cos θᵢ), `pdf` |
//! | `energy` | `fiber`, `theta`, `samples` (2 to 401) | `h`, `lobes` (6 × samples × 3), `mean` (6 × 3), `total` (3) |
//!
//! ```
//! let answer = vellus_views::answer(r#"{"ask": "check", "fiber": {"preset": "red-fox", "kappa": 0.5}}"#);
//! assert!(answer.contains(r#""kappa":0.5"#));
//! assert!(vellus_views::answer("{}").contains("error"));
//! ```

mod energy;
mod files;
mod lobes;
mod parameters;
mod request;
mod section;
mod values;
#[cfg(any(test, target_family = "wasm"))]
mod wasm;

pub use files::FILES;
pub use request::builder;

use request::Request;
use serde_json::{Value, json};

/// The requests, for the message about an unknown one.
const ASKS: &str = "parameters, check, color, section, polar, longitudinal, profile, values, energy";

/// Answers a request: JSON in, JSON out. It never panics, and a bad request gets `{"error": "what, where, range"}`.
pub fn answer(request: &str) -> String {
    respond(request).unwrap_or_else(|message| json!({ "error": message })).to_string()
}

fn respond(request: &str) -> Result<Value, String> {
    let request = Request::parse(request)?;
    match request.text("ask")? {
        "parameters" => parameters::table(),
        "check" => parameters::check(&request),
        "color" => parameters::color(&request),
        "section" => section::section(&request),
        "polar" => lobes::polar(&request),
        "longitudinal" => lobes::longitudinal(&request),
        "profile" => lobes::profile(&request),
        "values" => values::values(&request),
        "energy" => energy::energy(&request),
        other => Err(format!("ask = '{other}' is unknown: known are {ASKS}")),
    }
}
