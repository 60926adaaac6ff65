//! What the headers of pictures say about the command and the scene.

use vellus_render::Notes;
use vellus_scene::Scene;

/// This command, as it was typed.
pub fn command() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    std::iter::once("vellus".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// The fibres of a scene: one note for each look, in the form that `--fiber FILE.json` reads.
pub fn fibers(scene: &Scene) -> Notes {
    let mut notes = Vec::new();
    for (i, look) in scene.looks.iter().enumerate() {
        let name: String =
            look.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(40).collect();
        let mut value = serde_json::to_string(&look.fiber).unwrap_or_default();
        let varying = scene.strands.iter().filter(|s| s.look == i).flat_map(|s| s.varying.iter().map(|v| v.0));
        let mut others: Vec<_> = look.textured.iter().map(|t| t.0).chain(varying).map(|p| p.name()).collect();
        others.sort_unstable();
        others.dedup();
        if !others.is_empty() {
            value += &format!(" but {} of textures or primvars", others.join(", "));
        }
        let name = format!("vellus_fiber_{name}");
        let taken = notes.iter().any(|(n, _)| *n == name);
        notes.push((if taken { format!("{name}_{i}") } else { name }, value));
    }
    notes
}
