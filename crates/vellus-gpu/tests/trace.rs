//! The path tracer on a GPU against that of the processor.

use vellus::{Bcsdf, Fiber, Species};
use vellus_gpu::{Device, Tracer};
use vellus_render::{Film, Layer, Mode, Settings, World};

#[test]
fn scratch() -> Result<(), Box<dyn std::error::Error>> {
    let Ok(device) = Device::open() else { return Ok(()) };
    let name = std::env::var("SCENE").unwrap_or_else(|_| "hamster".to_owned());
    let scene = vellus_groom::scene(&name, true).ok_or("no scene")?;
    let world = World::with_model(scene, Bcsdf::new)?;
    let depth = std::env::var("DEPTH").ok().and_then(|d| d.parse().ok());
    let settings = Settings { mode: Mode::Near, max_depth: depth, ..Settings::new([48, 32]) };
    let layout = world.layout(&[Layer::Depth, Layer::Lobes, Layer::Albedo, Layer::Normal]);
    let t = std::time::Instant::now();
    let mut tracer = Tracer::new(&device, &world, &settings, &layout)?;
    println!("tracer {:?}", t.elapsed());
    let mut gpu = Film::new(settings.size, settings.area(), layout.clone());
    let t = std::time::Instant::now();
    let s = world.render_packed(&settings, &mut gpu, 0..1, &(), &mut tracer)?;
    println!("gpu {:?} {s:?}", t.elapsed());
    let mut cpu = Film::new(settings.size, settings.area(), layout.clone());
    let t = std::time::Instant::now();
    let s = world.render(&settings, &mut cpu, 0..1, &())?;
    println!("cpu {:?} {s:?}", t.elapsed());
    for layer in [Layer::Beauty, Layer::Alpha, Layer::Fibers, Layer::Depth, Layer::Albedo, Layer::Normal] {
        for c in 0..layer.channels() {
            let mean = |film: &Film| {
                (0..48 * 32).map(|i| f64::from(film.mean(i % 48, i / 48, layer, c))).sum::<f64>() / (48.0 * 32.0)
            };
            println!("{layer:?} {c}: gpu {:.5} cpu {:.5}", mean(&gpu), mean(&cpu));
        }
    }
    Ok(())
}
