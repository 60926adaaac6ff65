//! A render session: progress, cancellation, a checkpoint, resumption, and the picture as OpenEXR and PNG.
//!
//! `cargo run -p vellus-render --example session -- [OUTPUT.exr]`

use glam::Vec3;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use vellus::{Fiber, Species};
use vellus_io::{Progress, Sources};
use vellus_render::session::{End, Identity, Options, Picture, Session, Store, end_notes};
use vellus_render::{Error, Layer, Settings, World};
use vellus_scene::{Basis, Camera, Light, Look, Scene, Strands};

/// Prints the progress, and stops the work when it is told to. A viewer or a farm implements the same two methods.
#[derive(Default)]
struct Console {
    stop: AtomicBool,
}

impl Progress for Console {
    fn report(&self, done: f64, what: &str) {
        println!("{what}: {:.0} %", 100.0 * done);
    }

    fn is_cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Five hundred bent strands on a disk, under a lamp.
fn scene() -> Scene {
    let mut points = Vec::new();
    for i in 0..500 {
        // Vogel's spiral spreads the roots evenly.
        let (angle, distance) = (i as f32 * 2.399_963, (i as f32 / 500.0).sqrt());
        let root = Vec3::new(angle.cos(), 0.0, angle.sin()) * distance;
        for k in 0..4 {
            let t = k as f32 / 3.0;
            let point = root + Vec3::new(0.2 * t * t, 0.6 * t, 0.0);
            points.push(point.extend(0.01 * (1.0 - 0.8 * t)));
        }
    }
    let strands = Strands {
        name: "fur".to_owned(),
        basis: Basis::Bezier,
        starts: (0..=500).map(|i| 4 * i).collect(),
        points,
        moved: None,
        root_uv: None,
        look: 0,
        varying: Vec::new(),
    };
    Scene {
        strands: vec![strands],
        looks: vec![Look::constant("red-fox", Fiber::preset(Species::RedFox))],
        lights: vec![Light::Sphere { center: Vec3::new(2.0, 4.0, 2.0), radius: 0.8, radiance: [20.0; 3] }],
        camera: Some(Camera::look_at(Vec3::new(0.0, 2.0, 3.0), Vec3::Y * 0.2, Vec3::Y, 0.7, 1.5)),
        ..Scene::default()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out/session.exr".to_owned()));
    let world = World::new(scene())?;
    let settings = Settings::new([240, 160]);
    let layers = vec![Layer::Beauty, Layer::Alpha, Layer::Normal];
    // This scene is read from no files. An application adds what identifies its scene.
    let identity =
        Identity { settings: &settings, layers: &layers, model: "vellus", eta_m: None, min_pixel_width: 0.0 }
            .digest(Sources::new().digest())
            .field("scene", "five hundred strands")
            .finish();
    let options = Options { layers: layers.clone(), identity, noise: Some(0.02), ..Options::new(settings, 64) };

    // The first run is cancelled after a few samples.
    let mut store = Store::beside(&output);
    let console = Console::default();
    let mut session = Session::new(&world, options.clone())?;
    let end = session.run(&console, |pass| {
        console.stop.store(pass.state.samples >= 4, Ordering::Relaxed);
        store.save(pass.checkpoint)
    })?;
    assert_eq!(end, End::Interrupted);
    println!("cancelled with {} samples a pixel", session.film().samples());

    // The second run continues from the checkpoint.
    let mut session = Session::new(&world, options)?;
    if let Some(kept) = store.find(identity, &(0..u64::MAX))?.checkpoint {
        session.resume(kept)?;
    }
    println!("continuing from {} samples a pixel", session.film().samples());
    let end = session.run(&Console::default(), |_| Ok::<(), Error>(()))?;
    let picture = Picture { layers, notes: end_notes(session.film(), end), ..Picture::new(&output) };
    for path in picture.write(session.film(), None)? {
        println!("wrote {}", path.display());
    }
    store.remove();
    Ok(())
}
