//! The report of a fit: a folder with one page, two pictures and the numbers.

use super::pictures::{Profiles, Slices};
use super::summary::{Summary, error, interval, remark, value};
use crate::html::{self, escaped};
use crate::{Result, failure, save};
use std::path::Path;
use vellus_fit::{Absorption, Correlations};

/// Writes `index.html`, and `profile-1.png`, `slices-1.png` and `profile-1.csv` for each profile, to a folder. If the
/// profiles are channels, it also writes `absorption.csv`. `origin` is the last line of the page. It describes how the
/// fit was made, such as the command.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write), and the errors of the pictures.
pub fn write_report(summary: &Summary, folder: &Path, origin: &str) -> Result<()> {
    for k in 0..summary.measured.len() {
        let file = |what: &str, extension: &str| folder.join(format!("{what}-{}.{extension}", k + 1));
        save(&Profiles(summary, k), &[file("profile", "png")])?;
        save(&Slices(summary, k), &[file("slices", "png")])?;
        failure::write(&file("profile", "csv"), csv(summary, k).as_bytes())?;
    }
    let absorptions = summary.absorptions();
    if !absorptions.is_empty() {
        failure::write(&folder.join("absorption.csv"), Absorption::csv(&absorptions).as_bytes())?;
    }
    failure::write(&folder.join("index.html"), page(summary, origin).as_bytes())
}

/// Measured and fitted values as CSV.
fn csv(summary: &Summary, k: usize) -> String {
    let (profile, _, part) = summary.part(k);
    let names: &[&str] = if profile.channels == 1 { &[""] } else { &[".r", ".g", ".b"] };
    let columns = |what: &str| names.iter().map(|n| format!(",{what}{n}")).collect::<String>();
    let mut text = format!("theta,phi{}{}\n", columns("measured"), columns("fitted"));
    for (p, f) in profile.points.iter().zip(&part.fitted) {
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
    let title = format!(
        "Fit of {} by {}{}{}",
        summary
            .files()
            .iter()
            .filter_map(|f| f.file_name())
            .map(|n| n.to_string_lossy())
            .collect::<Vec<_>>()
            .join(", "),
        summary.model(),
        if fit.interrupted { " (interrupted: the best so far)" } else { "" },
        if fit.no_fit.is_some() { " (no fit)" } else { "" }
    );
    let row = |cells: &[String]| format!("<tr>{}</tr>\n", cells.concat());
    let cell = |text: &str| format!("<td>{}</td>", escaped(text));
    let synthetic = summary.is_synthetic();
    let heading = if synthetic { "<th>simulated</th>" } else { "" };
    let parameters: String = fit
        .estimates
        .iter()
        .map(|e| {
            let remark = format!("<td class=\"text\">{}</td>", escaped(&remark(e)));
            let simulated = if synthetic { cell(&summary.simulated_text(e)) } else { String::new() };
            row(&[cell(&e.name), cell(&value(e)), cell(&error(e)), cell(&interval(e)), simulated, remark])
        })
        .collect();
    let lines: String = summary
        .lines()
        .iter()
        .map(|(name, what)| row(&[cell(name), format!("<td class=\"text\">{}</td>", escaped(what))]))
        .collect();
    let picture = |k: usize| {
        let name = escaped(&summary.name(k));
        format!(
            "<h2>{name}</h2>\n<p><img src=\"profile-{0}.png\" alt=\"measured, fitted, ratio\"></p>\n\
             <p><img src=\"slices-{0}.png\" alt=\"slices over φ and over θ\"></p>\n\
             <p><a href=\"profile-{0}.csv\">measured and fitted values</a></p>\n",
            k + 1
        )
    };
    let pictures: String = (0..summary.measured.len()).map(picture).collect();
    let absorptions = match summary.absorptions().len() {
        0 => "",
        _ => "<p><a href=\"absorption.csv\">absorptions of the channels</a></p>\n",
    };
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
        "{}<table>\n<tr><th>parameter</th><th>value</th><th>± 1 s.e.</th><th>95 % interval</th>{heading}<th></th>\
         </tr>\n{parameters}</table>\n\
         <table>\n{lines}</table>\n{absorptions}{pictures}\
         <h2>Correlations</h2>\n<table>\n<tr><th></th>{head}</tr>\n{correlations}</table>\n\
         <p><small>vellus {} · {}</small></p>\n",
        html::warnings(&summary.warnings()),
        env!("CARGO_PKG_VERSION"),
        escaped(origin)
    );
    html::page(&title, &body)
}
