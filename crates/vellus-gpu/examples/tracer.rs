//! Writes the shader that renders a built-in scene: for `lab/shaders/registers.py`.
//!
//! `cargo run --release -p vellus-gpu --features trace --example tracer -- SCENE FILE.wgsl`

use vellus::Bcsdf;
use vellus_render::{Layer, Settings, World};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, file] = &arguments[..] else { return Err("name a scene and a file".into()) };
    let scene = vellus_groom::scene(scene, false).ok_or_else(|| format!("there is no scene {scene}"))?;
    let world = World::with_model(scene, Bcsdf::new)?;
    let settings = Settings::new([960, 640]);
    std::fs::write(file, vellus_gpu::tracer_shader(&world, &settings, &world.layout(&[Layer::Beauty]))?)?;
    Ok(())
}
