//! One static page of all results: index.html in the folder of the experiments.

use crate::context::write;
use crate::list::EXPERIMENTS;
use crate::visible::NOTICEABLE;
use crate::{Claim, NOTHING, Outcome, Picture, Quality, Slider, Table, Verdict};
use anyhow::Result;
use std::cmp::Reverse;
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

/// The style of the claims and of the sliders.
const STYLE: &str = include_str!("style.css");

/// Moves the dividers. Without it, the pictures of a slider are side by side.
const SCRIPT: &str = include_str!("slider.js");

/// Sliders are at most this wide and high, in CSS pixels.
const LARGEST: [f64; 2] = [720.0, 540.0];

/// Pictures that are enlarged by more than this show their pixels as squares.
const SQUARES: f64 = 2.5;

/// Tables with more rows are folded.
const LONG: usize = 12;

/// The scale of the maps.
const SCALE: &str = "0<span class=\"bar\"></span>0.5 and more<span class=\"empty\"></span>no fur";

fn page(found: &[Outcome]) -> String {
    // Pictures first, the largest ones before the others. Experiments without a slider keep the order of the list.
    let mut found: Vec<&Outcome> = found.iter().collect();
    let area = |outcome: &Outcome| outcome.sliders.first().map_or(0, |slider| slider.size[0] * slider.size[1]);
    found.sort_by_key(|outcome| Reverse(area(outcome)));
    let claims = || found.iter().flat_map(|o| &o.claims);
    let counts: String = Verdict::ALL
        .into_iter()
        .map(|v| (v, claims().filter(|c| c.verdict == v).count()))
        .filter(|(_, n)| *n > 0)
        .map(|(v, n)| format!("<span class=\"chip v v{}\">{}</span>\n", v as usize, v.count(n)))
        .collect();
    let missing: Vec<&str> =
        EXPERIMENTS.iter().map(|e| e.name).filter(|name| !found.iter().any(|o| o.name == *name)).collect();
    let mut warnings = Vec::new();
    if !missing.is_empty() {
        warnings.push(format!("Not run yet: {}.", missing.join(", ")));
    }
    let at = |quality: Quality| found.iter().filter(move |o| o.quality == quality).map(|o| o.name.as_str());
    let below = |quality: Quality, what: &str, warnings: &mut Vec<String>| {
        let names: Vec<&str> = at(quality).collect();
        let all = if names.len() == found.len() { "All experiments".to_owned() } else { names.join(", ") };
        if !names.is_empty() {
            warnings.push(format!("{all}: {} quality. {what}", quality.name()));
        }
    };
    below(Quality::Smoke, "It only shows that everything runs. No claim is judged.", &mut warnings);
    below(Quality::Draft, "Pictures are small and have noise.", &mut warnings);
    let warnings = html::warnings(&warnings);
    let links: String =
        found.iter().map(|o| format!("<a href=\"#{}\">{}</a>\n", escaped(&o.name), escaped(&short(o)))).collect();
    let summary: String = found.iter().flat_map(|o| o.claims.iter().map(|c| claim(c, Some(o)))).collect();
    let sections: String = found.iter().map(|outcome| section(outcome)).collect();
    let version = env!("CARGO_PKG_VERSION");
    let body = format!(
        "<header><p>L.-Q. Yan, H. W. Jensen, R. Ramamoorthi 2017, <i>An Efficient and Practical Near and Far Field \
         Fur Reflectance Model</i>: its figures and tables reproduced with vellus {version}, and its claims \
         measured.</p>\n<p>{counts}</p></header>\n{warnings}<nav>{links}<a href=\"#claims\">All claims</a></nav>\n\
         <p>Pictures of a pair are on top of each other: move the divider with the pointer or the arrow keys. The \
         yellow frame marks the place where the fur differs most, which is enlarged. Maps show FLIP, the difference \
         that a viewer sees when the pictures alternate, on the fur only: {SCALE}. On average, {NOTICEABLE:.2} is \
         just noticeable.</p>\n\
         {sections}<h2 id=\"claims\">All claims</h2>\n{}",
        table_of_claims(&summary)
    );
    html::page_with("The paper, reproduced", STYLE, &body, SCRIPT)
}

/// The name of an outcome in lists, "Fig. 11: species".
fn short(outcome: &Outcome) -> String {
    format!("{}: {}", outcome.figure, outcome.name)
}

/// A table with these rows: the claims of the paper and ours have columns of their own.
fn table_of_claims(rows: &str) -> String {
    format!(
        "<div class=\"wide\"><table class=\"claims\">\n<thead><tr><th>claim</th><th>the paper</th><th>Vellus</th>\
         <th>measured</th><th>verdict</th></tr></thead>\n<tbody>{rows}</tbody></table></div>\n"
    )
}

/// The row of a claim: one sentence and one number. The table of all claims names the `origin`; the section of the
/// experiment has the other numbers and the reason.
fn claim(claim: &Claim, origin: Option<&Outcome>) -> String {
    let mut what = escaped(&claim.what);
    if let Some(outcome) = origin {
        what += &format!(" <small><a href=\"#{}\">{}</a></small>", escaped(&outcome.name), escaped(&short(outcome)));
    } else {
        // The top of the page says once why nothing is judged at smoke quality.
        let why = if claim.verdict == Verdict::NotAtSmokeQuality { "" } else { claim.why.as_str() };
        let rest: Vec<String> =
            [claim.more.as_str(), why].iter().filter(|t| !t.is_empty()).map(|t| sentence(&escaped(t))).collect();
        if !rest.is_empty() {
            what += &format!("<details><summary>Details</summary><small>{}</small></details>", rest.join(" "));
        }
    }
    let cell = |name: &str, text: &str| {
        let class = if text == NOTHING { " class=\"none\"" } else { "" };
        format!("<td data-as=\"{name}\"{class}>{}</td>", escaped(text))
    };
    let cells = [cell("the paper", &claim.paper), cell("Vellus", &claim.ours), cell("measured", &claim.measured)];
    let class = if claim.verdict == Verdict::NotAtSmokeQuality { " class=\"smoke\"" } else { "" };
    let (number, verdict) = (claim.verdict as usize, claim.verdict.name());
    format!("<tr{class}><td>{what}</td>{}<td class=\"v v{number}\">{verdict}</td></tr>\n", cells.concat())
}

/// The text as a sentence: a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let stop = if text.ends_with('.') { "" } else { "." };
    let (first, rest) = text.split_at(text.chars().next().map_or(0, char::len_utf8));
    format!("{}{rest}{stop}", first.to_ascii_uppercase())
}

fn section(outcome: &Outcome) -> String {
    let name = escaped(&outcome.name);
    let mut text = format!(
        "<section>\n<h2 id=\"{name}\"><span>{}</span> {}</h2>\n<p class=\"paper\"><b>The paper:</b> {}</p>\n",
        escaped(&outcome.figure),
        escaped(&outcome.title),
        escaped(&outcome.paper)
    );
    text += &outcome.sliders.iter().map(|s| slider(&name, s)).collect::<String>();
    let rows = pictures(&name, &outcome.pictures);
    if outcome.sliders.is_empty() || rows.is_empty() {
        text += &rows;
    }
    if !outcome.claims.is_empty() {
        text += &table_of_claims(&outcome.claims.iter().map(|c| claim(c, None)).collect::<String>());
    }
    if !outcome.sliders.is_empty() && !rows.is_empty() {
        let count = outcome.pictures.len();
        text += &format!("<details><summary>All pictures ({count})</summary>\n{rows}</details>\n");
    }
    text += &outcome.tables.iter().map(|t| table(&name, t)).collect::<String>();
    text += &outcome.notes.iter().map(|note| format!("<p>{}</p>\n", escaped(note))).collect::<String>();
    let files = outcome.tables.iter().map(|t| format!("{}.csv", t.name));
    let links: String = std::iter::once("result.json".to_owned())
        .chain(files)
        .map(|file| format!(" · <a href=\"{name}/{0}\">{0}</a>", escaped(&file)))
        .collect();
    let (quality, seconds) = (outcome.quality.name(), outcome.seconds);
    let threads = if outcome.threads == 1 { "one thread".to_owned() } else { format!("{} threads", outcome.threads) };
    text += &format!(
        "<p><small>vellus {} · {quality} quality · {seconds:.1} s on {threads}, {}{links}</small></p>\n</section>\n",
        escaped(&outcome.version),
        escaped(&outcome.processor)
    );
    text
}

/// Two pictures with a divider, the maps of their difference, and an enlarged part of all.
fn slider(name: &str, slider: &Slider) -> String {
    let [width, height] = slider.size.map(|n| n.max(1) as f64);
    let scale = (LARGEST[0] / width).min(LARGEST[1] / height);
    let squares = if scale > SQUARES { " pixels" } else { "" };
    let percent = |k: usize| 100.0 * slider.zoom[k] as f64 / [width, height][k % 2];
    let place =
        format!("left:{:.2}%;top:{:.2}%;width:{:.2}%;height:{:.2}%", percent(0), percent(1), percent(2), percent(3));
    let image = |file: &str, label: &str, size: &str| {
        format!("<img src=\"{name}/{}\" alt=\"{}\"{size}>", escaped(file), escaped(label))
    };
    let size = format!(" width=\"{width}\" height=\"{height}\"");
    let figure = |file: &str, label: &str| {
        let image = image(file, label, "");
        format!(
            "<figure><a href=\"{name}/{}\">{image}</a><figcaption>{}</figcaption></figure>\n",
            escaped(file),
            escaped(label)
        )
    };
    let [left, right] = &slider.sides;
    let maps: String = slider.maps.iter().map(|map| figure(&map.file, &map.label)).collect();
    let zooms: String = slider
        .sides
        .iter()
        .chain(&slider.maps)
        .map(|side| figure(&side.zoom, &format!("Enlarged: {}", side.label)))
        .collect();
    let (first, second) = (escaped(&left.label), escaped(&right.label));
    format!(
        "<div class=\"pair{squares}\">\n<div class=\"both\">\n\
         <div class=\"stage\" style=\"--w:{:.0}px;--ratio:{width}/{height}\">{}{}\n\
         <input type=\"range\" min=\"0\" max=\"100\" value=\"50\" data-left=\"{first}\" \
         aria-label=\"Divider: {first} on the left, {second} on the right\">\n\
         <span class=\"line\"></span><span class=\"part\" style=\"{place}\"></span>\
         <span class=\"tag l\">{first}</span><span class=\"tag r\">{second}</span></div>\n\
         <div class=\"maps\">\n{maps}</div>\n</div>\n\
         <p>{}</p>\n<div class=\"zooms\">\n{zooms}</div>\n</div>\n",
        scale * width,
        image(&left.file, &left.label, &size),
        image(&right.file, &right.label, &size),
        escaped(&slider.caption)
    )
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
            "<figure><a href=\"{file}\"><img src=\"{file}\" alt=\"{caption}\"></a>\
             <figcaption>{caption}{also}</figcaption></figure>\n"
        );
    }
    if pictures.is_empty() { text } else { text + "</div>\n" }
}

fn table(name: &str, table: &Table) -> String {
    let cells = |cells: &[String], tag: &str| -> String {
        cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect()
    };
    let rows: String = table.rows.iter().map(|row| format!("<tr>{}</tr>\n", cells(row, "td"))).collect();
    let open = if table.rows.len() > LONG { "" } else { " open" };
    format!(
        "<details{open}><summary>{}</summary>\n<div class=\"wide\"><table>\n<caption><a \
         href=\"{name}/{}.csv\">CSV</a></caption>\n<tr>{}</tr>\n{rows}</table></div></details>\n",
        escaped(&table.caption),
        escaped(&table.name),
        cells(&table.header, "th")
    )
}

#[cfg(test)]
mod tests;
