//! One static page of all results: index.html in the folder of the experiments.

use crate::context::write;
use crate::list::EXPERIMENTS;
use crate::{Claim, Outcome, Picture, Quality, Table, Verdict};
use anyhow::Result;
use std::path::Path;
use vellus_plot::html::{self, escaped};

/// Writes `index.html` in the folder of all experiments, from the outcomes in it.
///
/// # Errors
/// If the page cannot be written.
pub fn write_report(folder: &Path) -> Result<()> {
    let found: Vec<Outcome> = EXPERIMENTS.iter().filter_map(|e| Outcome::read(&folder.join(e.name))).collect();
    write(&folder.join("index.html"), page(&found).as_bytes())
}

/// The verdict in its colour.
fn verdict(verdict: Verdict) -> String {
    format!("<td class=\"v v{}\">{}</td>", verdict as usize, verdict.name())
}

fn page(found: &[Outcome]) -> String {
    let claims = || found.iter().flat_map(|o| &o.claims);
    let counts: Vec<String> = Verdict::ALL
        .into_iter()
        .map(|v| (v, claims().filter(|c| c.verdict == v).count()))
        .filter(|(_, n)| *n > 0)
        .map(|(v, n)| format!("<span class=\"v v{}\">{}</span>", v as usize, v.count(n)))
        .collect();
    let missing: Vec<&str> =
        EXPERIMENTS.iter().map(|e| e.name).filter(|name| !found.iter().any(|o| o.name == *name)).collect();
    let mut warnings = Vec::new();
    if !missing.is_empty() {
        warnings.push(format!("Not run yet: {}.", missing.join(", ")));
    }
    let below: Vec<&str> = found.iter().filter(|o| o.quality != Quality::Paper).map(|o| o.name.as_str()).collect();
    if !below.is_empty() {
        let not_all = if below.len() == found.len() { "All of this is".to_owned() } else { below.join(", ") + ":" };
        warnings.push(format!("{not_all} below paper quality; each section names its quality."));
    }
    let warnings = html::warnings(&warnings);
    let links: String =
        found.iter().map(|o| format!("<a href=\"#{}\">{}</a>\n", o.name, escaped(&heading(o)))).collect();
    let summary: String = found
        .iter()
        .flat_map(|o| o.claims.iter().map(move |c| (o, c)))
        .map(|(o, c)| {
            let place = format!("<td><a href=\"#{}\">{}</a></td>", o.name, escaped(&o.figure));
            format!("<tr>{place}{}</tr>\n", claim(c, false))
        })
        .collect();
    let sections: String = found.iter().map(section).collect();
    let version = env!("CARGO_PKG_VERSION");
    let body = format!(
        "<p>L.-Q. Yan, H. W. Jensen, R. Ramamoorthi 2017, <i>An Efficient and Practical Near and Far Field Fur \
         Reflectance Model</i>: its figures and tables reproduced with vellus {version}, and its claims \
         measured.</p>\n{warnings}<nav>{links}</nav>\n\
         <h2>Claims</h2>\n<p>{}</p>\n<div class=\"wide\"><table class=\"claims\">\n\
         <tr><th></th><th>claim</th><th>expected</th><th>measured here</th><th></th></tr>\n\
         {summary}</table></div>\n{sections}",
        counts.join(" · ")
    );
    html::page("The paper, reproduced", &body)
}

/// The heading of an outcome, "Fig. 11: The ten species".
fn heading(outcome: &Outcome) -> String {
    format!("{}: {}", outcome.figure, outcome.title)
}

/// The cells of a claim. The summary omits the reason; the section includes it.
fn claim(claim: &Claim, whole: bool) -> String {
    let why = if whole && !claim.why.is_empty() {
        format!("<br><small>{}</small>", escaped(&claim.why))
    } else {
        String::new()
    };
    let [what, expected, measured] = [&claim.what, &claim.expected, &claim.measured].map(|text| escaped(text));
    format!("<td>{what}</td><td>{expected}</td><td>{measured}{why}</td>{}", verdict(claim.verdict))
}

fn section(outcome: &Outcome) -> String {
    let name = &outcome.name;
    let mut text = format!(
        "<h2 id=\"{name}\"><span>{}</span> {}</h2>\n<p><b>The paper:</b> {}</p>\n",
        escaped(&outcome.figure),
        escaped(&outcome.title),
        escaped(&outcome.paper)
    );
    text += &pictures(name, &outcome.pictures);
    if !outcome.claims.is_empty() {
        let rows: String = outcome.claims.iter().map(|c| format!("<tr>{}</tr>\n", claim(c, true))).collect();
        text += &format!(
            "<div class=\"wide\"><table class=\"claims\">\n<tr><th>claim</th><th>expected</th><th>measured here</th><th></th></tr>\n\
             {rows}</table></div>\n"
        );
    }
    text += &outcome.tables.iter().map(|t| table(name, t)).collect::<String>();
    text += &outcome.notes.iter().map(|note| format!("<p>{}</p>\n", escaped(note))).collect::<String>();
    let csv = outcome.tables.iter().map(|t| (format!("{}.csv", t.name), format!("{}.csv", t.name)));
    let links: String = std::iter::once(("result.json".to_owned(), "result.json".to_owned()))
        .chain(csv)
        .map(|(file, what)| format!(" · <a href=\"{name}/{}\">{}</a>", escaped(&file), escaped(&what)))
        .collect();
    let (quality, seconds) = (outcome.quality.name(), outcome.seconds);
    let threads = if outcome.threads == 1 { "one thread".to_owned() } else { format!("{} threads", outcome.threads) };
    text += &format!(
        "<p><small>vellus {} · {quality} quality · {seconds:.1} s on {threads}, {}{links}</small></p>\n",
        escaped(&outcome.version),
        escaped(&outcome.processor)
    );
    text
}

/// Rows of pictures.
fn pictures(name: &str, pictures: &[Picture]) -> String {
    let mut text = String::new();
    for (i, picture) in pictures.iter().enumerate() {
        if i == 0 || !picture.beside {
            text += if i == 0 { "<div class=\"row\">\n" } else { "</div>\n<div class=\"row\">\n" };
        }
        let file = format!("{name}/{}", escaped(&picture.file));
        let caption = escaped(&picture.caption);
        let also: String = picture
            .also
            .iter()
            .map(|f| {
                let kind = f.rsplit('.').next().unwrap_or(f).to_uppercase();
                format!(" <a href=\"{name}/{}\">{}</a>", escaped(f), escaped(&kind))
            })
            .collect();
        text += &format!(
            "<figure><a href=\"{file}\"><img src=\"{file}\" alt=\"{caption}\"></a><figcaption>{caption}{also}</figcaption></figure>\n"
        );
    }
    if pictures.is_empty() { text } else { text + "</div>\n" }
}

fn table(name: &str, table: &Table) -> String {
    let cells = |cells: &[String], tag: &str| -> String {
        cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect()
    };
    let rows: String = table.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells(row, "td"))).collect();
    format!(
        "<div class=\"wide\"><table>\n<caption>{} <a href=\"{name}/{}.csv\">CSV</a></caption>\n<tr>{}</tr>\n{rows}</table></div>\n",
        escaped(&table.caption),
        escaped(&table.name),
        cells(&table.header, "th")
    )
}
