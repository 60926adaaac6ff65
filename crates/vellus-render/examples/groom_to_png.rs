//! Renders a groom to a PNG with as little code as possible.
//!
//! `cargo run -p vellus-render --example groom_to_png -- [GROOM.hair|GROOM.tfx [OUTPUT.png]]`
//!
//! Without a groom, it renders the small built-in lock of hair.

use std::path::Path;
use vellus::{Fiber, Species};
use vellus_render::session::Picture;
use vellus_render::{Film, Layer, Settings, World};
use vellus_scene::{Look, Scene};

/// Reads strands, and gives them one fibre. Lights and a camera are optional. [`World::new`] adds a white dome, and a
/// camera that sees everything.
fn load(path: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    let bytes = vellus_io::read_at_most(Path::new(path), vellus_groom::MAX_FILE_BYTES)?;
    // Files without widths get this diameter, in their own unit.
    let width = Some(0.01);
    let mut strands = if path.ends_with(".tfx") {
        vellus_groom::read_tfx(&bytes, path, width)?
    } else {
        vellus_groom::read_hair(&bytes, path, width)?
    };
    if let Some(broken) = strands.remove_broken() {
        eprintln!("warning: {path}: {broken}");
    }
    let look = Look::constant("brown", Fiber::preset(Species::RedFox));
    Ok(Scene { strands: vec![strands], looks: vec![look], ..Scene::default() })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let scene = match arguments.next() {
        Some(path) => load(&path)?,
        None => vellus_groom::scene("hair-lock", true).ok_or("the built-in scene is missing")?,
    };
    let output = arguments.next().unwrap_or_else(|| "out/groom.png".to_owned());
    let world = World::new(scene)?;
    let settings = Settings::new([480, 320]);
    let mut film = Film::new(settings.size, settings.area(), world.layout(&[Layer::Beauty]));
    let statistics = world.render(&settings, &mut film, 0..16, &())?;
    println!("{} rays", statistics.rays);
    for path in Picture::new(output).write(&film, None)? {
        println!("wrote {}", path.display());
    }
    Ok(())
}
