//! Static HTML pages that load nothing from other places.

/// The style of all pages.
const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:1300px;margin:2em auto;padding:0 1em;color:#222}\
    h1{margin-bottom:.2em}h2{margin-top:2.2em;padding-top:.6em;border-top:2px solid #222}\
    h2 span{color:#777;font-weight:normal}table{border-collapse:collapse;margin:1em 0}\
    td,th{padding:.25em .8em;text-align:right;border-bottom:1px solid #ddd;vertical-align:top}\
    td:first-child,th:first-child,td.text,.claims td,.claims th{text-align:left}th{border-bottom:2px solid #bbb}\
    caption{text-align:left;color:#555;padding-bottom:.3em}.wide{overflow-x:auto}\
    .row{display:flex;gap:1em;align-items:flex-start;margin:1em 0}figure{margin:0;flex:1 1 0;min-width:0}\
    .row>figure:only-child{flex:0 1 auto}img{max-width:100%;height:auto;border:1px solid #eee}\
    figcaption,small{color:#555;font-size:.9em}.v{white-space:nowrap;font-weight:bold}\
    .v0{color:#1a6e2e}.v1{color:#1f5fa8}.v2{color:#b3261e}.v3,.v4{color:#777}\
    .warning{background:#fff3cd;padding:.5em 1em;margin:.5em 0}nav a{margin-right:1em;white-space:nowrap}\
    a{color:#1f5fa8}";

/// Escapes text for HTML, also inside of attributes.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

/// A page. `title` is text, `body` is HTML.
pub fn page(title: &str, body: &str) -> String {
    page_with(title, "", body, "")
}

/// A page with more CSS and with a script at its end. `title` is text, `body` is HTML.
pub fn page_with(title: &str, style: &str, body: &str, script: &str) -> String {
    let script = if script.is_empty() { String::new() } else { format!("<script>\n{script}</script>\n") };
    let title = escaped(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{title}</title>\
         <style>{STYLE}{style}</style></head>\n\
         <body>\n<h1>{title}</h1>\n{body}{script}</body>\n</html>\n"
    )
}

/// Highlighted paragraphs; each warning is text.
pub fn warnings(warnings: &[String]) -> String {
    warnings.iter().map(|w| format!("<p class=\"warning\">{}</p>\n", escaped(w))).collect()
}
