//! Notes about a scene, for the headers of pictures.

use crate::film::picture::Notes;
use vellus_scene::Scene;

/// The fibres of a scene: one note for each look, with its parameters as JSON.
pub fn fiber_notes(scene: &Scene) -> Notes {
    let mut notes = Vec::new();
    for (i, look) in scene.looks.iter().enumerate() {
        let name: String =
            look.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(40).collect();
        let mut value = serde_json::to_string(&look.fiber).unwrap_or_default();
        let varying = scene.all_strands().filter(|s| s.look == i).flat_map(|s| s.varying.iter().map(|v| v.0));
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
