//! A folder with all of a fit: one page, two pictures, and the numbers.

use super::pictures::{Profiles, Slices};
use super::tell::{Told, error, remark, value};
use crate::output;
use crate::plot::canvas::save;
use anyhow::Result;
use std::path::Path;

/// The page's style: it needs nothing from elsewhere.
const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:1300px;margin:2em auto;padding:0 1em;color:#222}\
    table{border-collapse:collapse;margin:1em 0}td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #ddd}\
    td:first-child,th:first-child,td.text{text-align:left}.warning{background:#fff3cd;padding:.5em 1em;margin:.5em 0}\
    img{max-width:100%}small{color:#555}";

/// Writes it.
pub fn write(told: &Told, folder: &Path) -> Result<()> {
    save(&Profiles(told), &[folder.join("profile.png")], "profile")?;
    save(&Slices(told), &[folder.join("slices.png")], "slices")?;
    output::write(Some(&folder.join("profile.csv")), csv(told).as_bytes())?;
    output::write(Some(&folder.join("index.html")), html(told).as_bytes())
}

/// What was measured and what was fitted.
fn csv(told: &Told) -> String {
    let names: &[&str] = if told.profile.channels == 1 { &[""] } else { &[".r", ".g", ".b"] };
    let columns = |what: &str| names.iter().map(|n| format!(",{what}{n}")).collect::<String>();
    let mut text = format!("theta,phi{}{}\n", columns("measured"), columns("fitted"));
    for (p, f) in told.profile.points.iter().zip(&told.fit.fitted) {
        let cells = |v: &[f64; 3]| v[..names.len()].iter().map(|x| format!(",{x:.6e}")).collect::<String>();
        text += &format!("{},{}{}{}\n", p.theta, p.phi, cells(&p.value), cells(f));
    }
    text
}

/// Text as HTML shows it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// White at 0, light red at 1, light blue at −1: text stays readable on it.
fn shade(correlation: f64) -> String {
    let fade = (255.0 * (1.0 - 0.6 * correlation.abs())) as u8;
    if correlation >= 0.0 { format!("rgb(255,{fade},{fade})") } else { format!("rgb({fade},{fade},255)") }
}

fn html(told: &Told) -> String {
    let fit = told.fit;
    let name = told.path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let title = escaped(&format!(
        "Fit of {name} by {}{}{}",
        fit.model,
        if fit.interrupted { " (interrupted: the best so far)" } else { "" },
        if fit.no_fit.is_some() { " (no fit)" } else { "" }
    ));
    let row = |cells: &[String]| format!("<tr>{}</tr>\n", cells.concat());
    let cell = |text: &str| format!("<td>{}</td>", escaped(text));
    let warnings: String =
        told.warnings().iter().map(|w| format!("<p class=\"warning\">{}</p>\n", escaped(w))).collect();
    let parameters: String = fit
        .estimates
        .iter()
        .map(|e| {
            let remark = format!("<td class=\"text\">{}</td>", escaped(&remark(e)));
            row(&[cell(&e.name), cell(&value(e)), cell(&error(e)), remark])
        })
        .collect();
    let summary: String = told
        .summary()
        .iter()
        .map(|(name, what)| row(&[cell(name), format!("<td class=\"text\">{}</td>", escaped(what))]))
        .collect();
    let (names, matrix) = &fit.correlations;
    let head: String = names.iter().map(|n| format!("<th>{}</th>", escaped(n))).collect();
    let correlations: String = names
        .iter()
        .zip(matrix)
        .map(|(name, line)| {
            let cells = line.iter().map(|c| format!("<td style=\"background:{}\">{c:.2}</td>", shade(*c)));
            row(&std::iter::once(cell(name)).chain(cells).collect::<Vec<_>>())
        })
        .collect();
    let command = escaped(&std::env::args().collect::<Vec<_>>().join(" "));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}</style></head>\n<body>\n\
         <h1>{title}</h1>\n{warnings}<table>\n<tr><th>parameter</th><th>value</th><th>± 1 s.e.</th><th></th></tr>\n{parameters}</table>\n\
         <table>\n{summary}</table>\n<h2>Profiles</h2>\n<p><img src=\"profile.png\" alt=\"measured, fitted, ratio\"></p>\n\
         <h2>Slices</h2>\n<p><img src=\"slices.png\" alt=\"slices over φ and over θ\"></p>\n\
         <h2>Correlations</h2>\n<table>\n<tr><th></th>{head}</tr>\n{correlations}</table>\n\
         <p><small>vellus {} · {command} · <a href=\"profile.csv\">measured and fitted values</a></small></p>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    )
}
