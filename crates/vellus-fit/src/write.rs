//! Writes profiles as text and CSV.

use crate::error::Error;
use crate::profile::{Point, Profile};
use std::path::Path;

/// The start of a comment with a parameter that was simulated.
pub(crate) const SIMULATED: &str = "simulated ";

/// The values as they are written to a file, with seven digits.
fn cells(p: &Point, channels: usize) -> impl Iterator<Item = String> + '_ {
    p.value[..channels].iter().map(|x| format!("{x:.6e}"))
}

/// The comments at the head of a file: the notes, then what a reader needs.
fn header(profile: &Profile, angles: &str, notes: &[String]) -> String {
    let notes: String = notes.iter().map(|note| format!("# {note}\n")).collect();
    let simulated: String = profile.simulated.iter().map(|(name, x)| format!("# {SIMULATED}{name} = {x}\n")).collect();
    let blur = match profile.blur {
        [0.0, 0.0] => String::new(),
        [theta, phi] => format!("# blur = {theta},{phi}\n"),
    };
    format!(
        "{notes}{simulated}# theta_o = {}\n# quantity = {}\n# angles = {angles}\n{blur}",
        profile.theta_o,
        profile.quantity.name()
    )
}

/// Writes a profile as text, with notes as comments.
pub type Writer = fn(&Profile, &[String]) -> String;

/// The writer for a file name: [`gantry_text`] for `.txt`, [`csv()`] for `.csv`.
///
/// # Errors
/// [`Error::File`] for other names.
pub fn writer(path: &Path) -> Result<Writer, Error> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("txt") => Ok(gantry_text),
        Some("csv") => Ok(csv),
        _ => Err(Error::file(path, "the measurement's name must end in .txt or .csv")),
    }
}

/// Removes the rounding error of a subtraction of angles.
fn tidy(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}

/// Writes the text format of the measurements of Yan et al. 2015: `phi theta value` in the gantry's coordinates, `?`
/// for a missing value. `notes` become comments at the head.
pub fn gantry_text(profile: &Profile, notes: &[String]) -> String {
    let mut text = header(profile, "gantry", notes);
    let place = |theta: f64, phi: f64| format!("{} {}", tidy(phi + 90.0), tidy(90.0 - theta));
    for p in &profile.points {
        text += &format!("{} {}\n", place(p.theta, p.phi), cells(p, profile.channels).collect::<Vec<_>>().join(" "));
    }
    for [theta, phi] in &profile.missing {
        text += &format!("{} {}\n", place(*theta, *phi), vec!["?"; profile.channels].join(" "));
    }
    text
}

/// Writes CSV with the columns theta, phi, value or r, g, b, and the standard deviations if there are any. `notes`
/// become comments at the head.
pub fn csv(profile: &Profile, notes: &[String]) -> String {
    let has_sigma = profile.points.iter().any(|p| p.sigma.is_some());
    let names = match (profile.channels, has_sigma) {
        (1, false) => "value",
        (1, true) => "value,sigma",
        (_, false) => "r,g,b",
        (_, true) => "r,g,b,sigma_r,sigma_g,sigma_b",
    };
    let mut text = header(profile, "fiber", notes) + &format!("theta,phi,{names}\n");
    for p in &profile.points {
        let sigma = p.sigma.iter().flat_map(|sigma| &sigma[..profile.channels]).map(|x| format!("{x:.6e}"));
        let cells: Vec<String> = cells(p, profile.channels).chain(sigma).collect();
        text += &format!("{},{},{}\n", tidy(p.theta), tidy(p.phi), cells.join(","));
    }
    let columns = profile.channels * if has_sigma { 2 } else { 1 };
    for [theta, phi] in &profile.missing {
        text += &format!("{},{},{}\n", tidy(*theta), tidy(*phi), vec!["?"; columns].join(","));
    }
    text
}
