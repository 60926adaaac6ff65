//! A render job: progress, cancellation, a checkpoint, resumption, and the picture as OpenEXR and PNG.
//!
//! `cargo run -p vellus-render --example session -- [OUTPUT.exr]`

use glam::Vec3;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use vellus::{Fiber, Species};
use vellus_io::Sources;
use vellus_render::session::{End, Event, Identity, Job, Options, Picture};
use vellus_render::{Layer, Lod, Settings, World};
use vellus_scene::{Basis, Camera, LightShape, Look, Scene, Strands};

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
        normals: None,
        root_uv: None,
        look: 0,
        varying: Vec::new(),
    };
    Scene {
        strands: vec![strands],
        looks: vec![Look::constant("red-fox", Fiber::preset(Species::RedFox))],
        lights: vec![LightShape::Sphere { center: Vec3::new(2.0, 4.0, 2.0), radius: 0.8, radiance: [20.0; 3] }.into()],
        camera: Some(Camera::look_at(Vec3::new(0.0, 2.0, 3.0), Vec3::Y * 0.2, Vec3::Y, 0.7, 1.5)),
        ..Scene::default()
    }
}

/// Prints what a job does. A viewer or a farm shows the same events in its own way.
fn print(event: &Event) {
    match event {
        Event::Pass(pass) => println!("{:.0} %: {pass}", 100.0 * pass.goals.done(&pass.state)),
        other => println!("{other}"),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out/session.exr".to_owned()));
    let world = World::new(scene())?;
    let settings = Settings::new([240, 160]);
    let layers = vec![Layer::Beauty, Layer::Alpha, Layer::Normal];
    // This scene is read from no files. An application adds what identifies its scene.
    let identity = Identity {
        settings: &settings,
        layers: &layers,
        model: "vellus",
        eta_m: None,
        min_pixel_width: 0.0,
        lod: Lod::Off,
    };
    let digest = identity.digest(Sources::new().digest()).field("scene", "five hundred strands").finish();
    let notes = identity.notes(digest);
    let options =
        Options { layers: layers.clone(), identity: digest, noise: Some(0.02), notes, ..Options::new(settings, 64) };
    let job = || Job {
        resume: true,
        ..Job::new(options.clone(), Picture { layers: layers.clone(), ..Picture::new(&output) })
    };

    // The first run is cancelled after a few samples. It writes a picture, and keeps a checkpoint.
    let stop = AtomicBool::new(false);
    let outcome = job().run(&world, &stop, |event| {
        if let Event::Pass(pass) = &event {
            stop.store(pass.state.samples >= 4, Ordering::Relaxed);
        }
        print(&event);
    })?;
    assert_eq!(outcome.end, End::Interrupted);
    println!("cancelled with {} samples a pixel", outcome.checkpoint.film.samples());

    // The second run continues from the checkpoint.
    job().run(&world, &(), |event| print(&event))?;
    Ok(())
}
