//! Notes about a scene, for the headers of pictures, and about a picture, for its films.

use crate::film::Layer;
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

/// The note with the layers that a picture should have. Only films have it: they also keep layers that a picture's
/// noise and preview are computed from.
const LAYERS_NOTE: &str = "vellus_layers";

/// The note with the layers of a picture.
pub(super) fn layers_note(layers: &[Layer]) -> (String, String) {
    (LAYERS_NOTE.to_owned(), layers.iter().map(|layer| layer.name()).collect::<Vec<_>>().join(","))
}

/// Removes the note with the layers from the notes of a film, and returns them. `None` if it has no such note.
pub(super) fn take_layers(notes: &mut Notes) -> Option<Vec<Layer>> {
    let at = notes.iter().position(|(name, _)| name == LAYERS_NOTE)?;
    let (_, names) = notes.remove(at);
    if names.is_empty() { Some(Vec::new()) } else { Layer::list(&names).ok() }
}
