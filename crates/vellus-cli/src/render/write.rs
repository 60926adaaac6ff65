//! Pictures and what belongs to them as files.

use super::denoise::Denoiser;
use crate::output;
use crate::say::{note, say};
use anyhow::{Result, anyhow};
use std::path::Path;
use vellus_render::{Depth, Film, Layer, Layout};
use vellus_scene::Scene;

/// A picture to write.
pub struct Picture<'a> {
    /// .exr, and a .png beside it; or .png alone.
    pub path: &'a Path,
    pub layers: &'a [Layer],
    pub depth: Depth,
    pub exposure: f32,
    /// Where the beauty is to be denoised as well: the PNG shows that.
    pub denoiser: Option<Denoiser>,
    /// Names and values in the files' headers.
    pub notes: Vec<(String, String)>,
}

impl Picture<'_> {
    /// Writes it, and says so.
    pub fn write(&self, film: &Film) -> Result<()> {
        let png = self.path.with_extension("png");
        // Noise is better than no picture.
        let denoised = self
            .denoiser
            .as_ref()
            .and_then(|denoiser| denoiser.clean(film).inspect_err(|e| note!("warning: cannot denoise: {e}")).ok());
        let denoised = denoised.as_deref();
        if self.path != png {
            let bytes = film.to_exr(self.layers, denoised, self.depth, &self.notes);
            output::write(Some(self.path), &bytes.map_err(|e| anyhow!("cannot encode OpenEXR: {e}"))?)?;
            say!("wrote {}", self.path.display());
        }
        // Last: where it is, all is.
        let bytes = film.to_png(denoised, self.exposure, &self.notes).map_err(|e| anyhow!("cannot encode PNG: {e}"))?;
        output::write(Some(&png), &bytes)?;
        say!("wrote {}", png.display());
        Ok(())
    }
}

/// Warns of pixels whose sums reached the end of their range. (vellus_render's `Film::full_pixels` says where that is.)
pub fn warn_of_full_pixels(film: &Film) {
    let full = film.full_pixels();
    if full > 0 {
        note!(
            "warning: {full} pixels are brighter or further away than a film can sum: they are too dark in the \
             picture (scale \
             the lights or the scene down, or render fewer samples)"
        );
    }
}

/// Refuses names of pictures that are neither OpenEXR nor PNG.
pub fn check_name(path: &Path) -> Result<()> {
    output::check_extension(path, &["exr", "png"])
}

/// Bytes that the files of one picture take at most: noise does not compress well.
pub fn largest_size(pixels: u64, layout: &Layout, path: &Path, layers: &[Layer], depth: Depth) -> u64 {
    // Three of a denoised beauty.
    let channels = 3 + layers.iter().filter_map(|l| layout.range(*l)).map(|r| r.len()).sum::<usize>();
    // A few channels are 32 bit always.
    let exr = if depth == Depth::Float { 4 * channels } else { 2 * channels + 10 };
    pixels * (3 + if path.extension().is_some_and(|e| e == "exr") { exr as u64 } else { 0 })
}

/// This command, as it was typed.
pub fn command() -> String {
    let arguments = std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    std::iter::once("vellus".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// What a scene's fibres are: a note for each look, in the form `--fiber FILE.json` reads.
pub fn fibers(scene: &Scene) -> Vec<(String, String)> {
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
