//! Writes profiles as text and CSV.

use crate::error::Error;
use crate::profile::{Point, Profile};
use std::collections::BTreeMap;
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

/// Writes CSV with the columns theta, phi, value or r, g, b, and the standard deviations if there are any. A profile
/// with a [`Profile::channel`] has the columns of [`channels_csv`]. `notes` become comments at the head.
pub fn csv(profile: &Profile, notes: &[String]) -> String {
    channels_csv(std::slice::from_ref(profile), notes)
}

/// Writes the profiles of the channels of one measurement as CSV: the columns theta, phi, value_NAME for each channel,
/// and sigma_NAME if there are standard deviations. `notes` become comments at the head. Nothing is written without a
/// profile, and all must have the same directions, values or not.
pub fn channels_csv(profiles: &[Profile], notes: &[String]) -> String {
    let Some(first) = profiles.first() else { return String::new() };
    let has_sigma = profiles.iter().any(|profile| profile.points.iter().any(|p| p.sigma.is_some()));
    let columns = |profile: &Profile, what: &str| match (profile.channel.as_str(), profile.channels, what) {
        ("", 1, _) => what.to_owned(),
        ("", _, "value") => "r,g,b".to_owned(),
        ("", _, _) => "sigma_r,sigma_g,sigma_b".to_owned(),
        (name, ..) => format!("{what}_{name}"),
    };
    let of_all = |what: &str| profiles.iter().map(|profile| columns(profile, what)).collect::<Vec<_>>();
    let names = if has_sigma { [of_all("value"), of_all("sigma")].concat() } else { of_all("value") };
    // What was simulated differs between channels in the absorption.
    let simulated = |(i, profile): (usize, &Profile)| {
        let of = |(name, x): &(String, f64)| match name.starts_with("sigma_ca") || name.starts_with("sigma_ma") {
            true if !profile.channel.is_empty() => Some((format!("{name}[{}]", profile.channel), *x)),
            _ => (i == 0).then(|| (name.clone(), *x)),
        };
        profile.simulated.iter().filter_map(of).collect::<Vec<_>>()
    };
    let simulated = profiles.iter().enumerate().flat_map(simulated).collect();
    let head = header(&Profile { simulated, points: Vec::new(), ..first.clone() }, "fiber", notes);
    let mut text = format!("{head}theta,phi,{}\n", names.join(","));
    let key = |[theta, phi]: [f64; 2]| [theta, phi].map(f64::to_bits);
    let found: Vec<BTreeMap<[u64; 2], &Point>> =
        profiles.iter().map(|p| p.points.iter().map(|p| (key([p.theta, p.phi]), p)).collect()).collect();
    for place in first.points.iter().map(|p| [p.theta, p.phi]).chain(first.missing.iter().copied()) {
        let (mut values, mut sigmas) = (Vec::new(), Vec::new());
        for (profile, found) in profiles.iter().zip(&found) {
            let point = found.get(&key(place));
            let cell = |x: Option<f64>| x.map_or("?".to_owned(), |x| format!("{x:.6e}"));
            values.extend((0..profile.channels).map(|c| cell(point.map(|p| p.value[c]))));
            sigmas.extend((0..profile.channels).map(|c| cell(point.and_then(|p| p.sigma).map(|sigma| sigma[c]))));
        }
        let cells = if has_sigma { [values, sigmas].concat() } else { values };
        text += &format!("{},{},{}\n", tidy(place[0]), tidy(place[1]), cells.join(","));
    }
    text
}
