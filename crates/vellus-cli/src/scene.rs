//! `vellus scene`: the built-in scenes.

/// Lists them.
pub fn run() {
    let rows: Vec<_> = vellus_groom::SCENES.iter().map(|(name, what)| format!("  {name:12}{what}\n")).collect();
    print!("{}\nvellus render NAME renders one, with --small a version of a fortieth of the strands.\n", rows.concat());
}
