//! `vellus shaders`: the model in shading languages, its tables, and the records of fibres.

use crate::fiber_args::FiberArgs;
use crate::output;
use crate::say::say;
use anyhow::{Context, Result, bail};
use std::collections::BTreeSet;
use std::path::PathBuf;
use vellus::{Bcsdf, Species};
use vellus_gpu::{
    FAR_FIELD, FAR_QUERIES, Field, Functions, Language, QUERIES, converted, glsl_include, hlsl_include,
    reduced_library, shader_color, shader_far_table, shader_fiber, shader_library, shader_tables, shader_tables_half,
};

#[derive(clap::Args)]
pub struct Args {
    /// Preset (see `vellus fiber list`), TOML or JSON file, or MaterialX material (FILE.mtlx#NAME). May be repeated.
    /// Default: all presets.
    #[arg(long, value_name = "NAME|FILE")]
    fiber: Vec<PathBuf>,
    /// Folder for the files. It may exist: other files in it stay.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

pub fn run(args: &Args) -> Result<()> {
    // Check everything before the first file.
    let mut fibers = Vec::new();
    for fiber in sources(args) {
        let place = || fiber.source().path.display().to_string();
        let bcsdf = Bcsdf::new(&fiber.load()?).with_context(place)?;
        vellus::packed::supports(bcsdf.fiber()).with_context(place)?;
        fibers.push((fiber.name(), bcsdf));
    }
    let library = library()?;
    let mut names: BTreeSet<String> = library.iter().map(|(name, _)| name.clone()).collect();
    for name in fibers.iter().flat_map(|(name, _)| ENDINGS.map(|end| format!("{name}{end}"))) {
        // Some file systems do not tell upper and lower case apart.
        if !names.insert(name.to_lowercase()) {
            bail!("--fiber: two files would have the name {name}: rename a file of a fibre");
        }
    }
    let write = |name: &str, contents: &[u8]| -> Result<()> {
        let path = args.folder.join(name);
        output::write(Some(&path), contents)?;
        say!("wrote {}: {} bytes", path.display(), contents.len());
        Ok(())
    };
    for (name, contents) in &library {
        write(name, contents)?;
    }
    for (name, bcsdf) in &fibers {
        let contents = [&shader_fiber(bcsdf)[..], &shader_color(bcsdf), &shader_far_table(bcsdf)];
        for (end, rows) in ENDINGS.iter().zip(contents) {
            write(&format!("{name}{end}"), &bytes(rows))?;
        }
    }
    Ok(())
}

/// The files of a fibre: its record, its colour record, and its far field.
const ENDINGS: [&str; 3] = [".bin", "-color.bin", "-far.bin"];

/// The fibres that were asked for.
fn sources(args: &Args) -> Vec<FiberArgs> {
    if args.fiber.is_empty() {
        return Species::ALL.iter().map(|species| FiberArgs::new(species.name(), &[])).collect();
    }
    args.fiber.iter().map(|fiber| FiberArgs::new(fiber, &[])).collect()
}

/// The files that do not depend on a fibre: names in lower case, and contents.
fn library() -> Result<Vec<(String, Vec<u8>)>> {
    let texts = [
        ("vellus.wgsl", shader_library()),
        ("queries.wgsl", QUERIES.to_owned()),
        ("vellus-far.wgsl", FAR_FIELD.to_owned()),
        ("far-queries.wgsl", FAR_QUERIES.to_owned()),
        ("vellus.glsl", glsl_include(Functions::All)?),
        ("vellus.hlsli", hlsl_include(Functions::All)?),
        ("vellus-reduced.wgsl", reduced_library()),
        ("vellus-reduced.glsl", glsl_include(Functions::Reduced)?),
        ("vellus-reduced.hlsli", hlsl_include(Functions::Reduced)?),
    ];
    let mut files = Vec::from(texts.map(|(name, text)| (name.to_owned(), text.into_bytes())));
    for language in Language::ALL {
        for (name, field) in [("vellus", Field::Near), ("vellus-far", Field::Far)] {
            files.push((format!("{name}.{}", language.extension()), converted(language, field)?));
        }
    }
    files.push(("tables.bin".to_owned(), bytes(&shader_tables())));
    let half = shader_tables_half().as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    files.push(("tables-half.bin".to_owned(), half));
    Ok(files)
}

/// Rows as little-endian bytes, the contents of a buffer.
fn bytes(rows: &[[f32; 4]]) -> Vec<u8> {
    rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect()
}
