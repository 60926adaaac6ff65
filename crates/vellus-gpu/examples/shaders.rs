//! Writes the shader library in all languages, its tables, and the fibres of all presets with their far fields into a
//! folder.
//!
//! `cargo run -p vellus-gpu --features convert --example shaders -- FOLDER`

use std::path::{Path, PathBuf};
use vellus::{Bcsdf, Fiber, Species};
use vellus_gpu::{
    FAR_FIELD, FAR_QUERIES, Field, Language, QUERIES, converted, shader_far_table, shader_fiber, shader_library,
    shader_tables,
};

/// Rows as little-endian bytes, the contents of a buffer.
fn bytes(rows: &[[f32; 4]]) -> Vec<u8> {
    rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Writes the file under another name first, so that no file is ever incomplete.
fn write(folder: &Path, name: &str, contents: &[u8]) -> std::io::Result<()> {
    let (path, part) = (folder.join(name), folder.join(format!("{name}.part")));
    std::fs::write(&part, contents)?;
    std::fs::rename(&part, &path)?;
    println!("{} ({} KB)", path.display(), contents.len().div_ceil(1024));
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        return Err("name a folder for the files".into());
    };
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    write(&folder, "vellus.wgsl", shader_library().as_bytes())?;
    write(&folder, "queries.wgsl", QUERIES.as_bytes())?;
    write(&folder, "vellus-far.wgsl", FAR_FIELD.as_bytes())?;
    write(&folder, "far-queries.wgsl", FAR_QUERIES.as_bytes())?;
    for language in Language::ALL {
        for (name, field) in [("vellus", Field::Near), ("vellus-far", Field::Far)] {
            write(&folder, &format!("{name}.{}", language.extension()), &converted(language, field)?)?;
        }
    }
    write(&folder, "tables.bin", &bytes(&shader_tables()))?;
    for species in Species::ALL {
        let bcsdf = Bcsdf::new(&Fiber::preset(species))?;
        write(&folder, &format!("{species}.bin"), &bytes(&shader_fiber(&bcsdf)))?;
        write(&folder, &format!("{species}-far.bin"), &bytes(&shader_far_table(&bcsdf)))?;
    }
    Ok(())
}
