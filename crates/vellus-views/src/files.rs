//! The web modules of the folder `web`, for servers that embed them.

/// Name and text of each file. All are in one folder. `explorer.html` is the static page; a server that has its own page
/// needs the others alone.
pub const FILES: &[(&str, &str)] = &[
    ("fiber-panel.js", include_str!("../web/fiber-panel.js")),
    ("fiber-views.js", include_str!("../web/fiber-views.js")),
    ("style.css", include_str!("../web/style.css")),
    ("explorer.html", include_str!("../web/explorer.html")),
    ("explorer.js", include_str!("../web/explorer.js")),
];
