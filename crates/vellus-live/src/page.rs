//! The files of the page, embedded in the program.

/// Name, media type and content of each file.
const FILES: [(&str, &str, &str); 8] = [
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

/// Media type and content of a file. `None` if there is no such file.
pub fn file(path: &str) -> Option<(&'static str, &'static str)> {
    if let Some((_, media, content)) = FILES.iter().find(|(name, ..)| *name == path) {
        return Some((media, content));
    }
    // The fibre panel and the views have a style of their own.
    let (name, media) = match path {
        "/fiber-panel.js" | "/fiber-views.js" => (&path[1..], SCRIPT),
        "/views.css" => ("style.css", "text/css; charset=utf-8"),
        _ => return None,
    };
    vellus_views::FILES.iter().find(|(other, _)| *other == name).map(|(_, content)| (media, *content))
}
