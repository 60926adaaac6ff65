//! The report of a fit: a folder with one page, two pictures and the numbers.

use super::pictures::{Profiles, Slices};
use super::summary::{Summary, error, remark, value};
use crate::html::{self, escaped};
use crate::{Result, failure, save};
use std::path::Path;
use vellus_fit::Correlations;

/// Writes `index.html`, `profile.png`, `slices.png` and `profile.csv` to a folder. `origin` is the last line of the
/// page. It describes how the fit was made, such as the command.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write), and the errors of the pictures.
pub fn write_report(summary: &Summary, folder: &Path, origin: &str) -> Result<()> {
    save(&Profiles(summary), &[folder.join("profile.png")])?;
    save(&Slices(summary), &[folder.join("slices.png")])?;
    failure::write(&folder.join("profile.csv"), csv(summary).as_bytes())?;
    failure::write(&folder.join("index.html"), page(summary, origin).as_bytes())
}

/// Measured and fitted values as CSV.
fn csv(summary: &Summary) -> String {
    let names: &[&str] = if summary.profile.channels == 1 { &[""] } else { &[".r", ".g", ".b"] };
    let columns = |what: &str| names.iter().map(|n| format!(",{what}{n}")).collect::<String>();
    let mut text = format!("theta,phi{}{}\n", columns("measured"), columns("fitted"));
    for (p, f) in summary.profile.points.iter().zip(&summary.fit.fitted) {
        let cells = |v: &[f64; 3]| v[..names.len()].iter().map(|x| format!(",{x:.6e}")).collect::<String>();
        text += &format!("{},{}{}{}\n", p.theta, p.phi, cells(&p.value), cells(f));
    }
    text
}

/// The background of a correlation: white at 0, light red at 1, light blue at −1.
fn shade(correlation: f64) -> String {
    let fade = (255.0 * (1.0 - 0.6 * correlation.abs())) as u8;
    if correlation >= 0.0 { format!("rgb(255,{fade},{fade})") } else { format!("rgb({fade},{fade},255)") }
}

fn page(summary: &Summary, origin: &str) -> String {
    let fit = summary.fit;
    let name = summary.path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let title = format!(
        "Fit of {name} by {}{}{}",
        summary.model(),
        if fit.interrupted { " (interrupted: the best so far)" } else { "" },
        if fit.no_fit.is_some() { " (no fit)" } else { "" }
    );
    let row = |cells: &[String]| format!("<tr>{}</tr>\n", cells.concat());
    let cell = |text: &str| format!("<td>{}</td>", escaped(text));
    let synthetic = !summary.profile.simulated.is_empty();
    let heading = if synthetic { "<th>simulated</th>" } else { "" };
    let parameters: String = fit
        .estimates
        .iter()
        .map(|e| {
            let remark = format!("<td class=\"text\">{}</td>", escaped(&remark(e)));
            let simulated = if synthetic { cell(&summary.simulated_text(e)) } else { String::new() };
            row(&[cell(&e.name), cell(&value(e)), cell(&error(e)), simulated, remark])
        })
        .collect();
    let lines: String = summary
        .lines()
        .iter()
        .map(|(name, what)| row(&[cell(name), format!("<td class=\"text\">{}</td>", escaped(what))]))
        .collect();
    let Correlations { names, matrix } = &fit.correlations;
    let head: String = names.iter().map(|n| format!("<th>{}</th>", escaped(n))).collect();
    let correlations: String = names
        .iter()
        .zip(matrix)
        .map(|(name, line)| {
            let cells = line.iter().map(|c| format!("<td style=\"background:{}\">{c:.2}</td>", shade(*c)));
            row(&std::iter::once(cell(name)).chain(cells).collect::<Vec<_>>())
        })
        .collect();
    let body = format!(
        "{}<table>\n<tr><th>parameter</th><th>value</th><th>± 1 s.e.</th>{heading}<th></th></tr>\n\
         {parameters}</table>\n\
         <table>\n{lines}</table>\n<h2>Profiles</h2>\n\
         <p><img src=\"profile.png\" alt=\"measured, fitted, ratio\"></p>\n\
         <h2>Slices</h2>\n<p><img src=\"slices.png\" alt=\"slices over φ and over θ\"></p>\n\
         <h2>Correlations</h2>\n<table>\n<tr><th></th>{head}</tr>\n{correlations}</table>\n\
         <p><small>vellus {} · {} · <a href=\"profile.csv\">measured and fitted values</a></small></p>\n",
        html::warnings(&summary.warnings()),
        env!("CARGO_PKG_VERSION"),
        escaped(origin)
    );
    html::page(&title, &body)
}
