//! Evaluates and samples the model once: `cargo run -p vellus --example minimal`.

use vellus::glam::Vec3;
use vellus::{Bcsdf, Error, Fiber, Lobe, Species, Window};

fn main() -> Result<(), Error> {
    // The fur of a red fox, with a brown absorption per fibre radius.
    let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    let bcsdf = Bcsdf::new(&fiber)?;

    // The direction toward the camera in the fibre's frame, x from root to tip. The ray hits at the offset h = 0.3.
    let wo = Vec3::new(0.2, 0.8, 0.5).normalize();
    let hit = bcsdf.at(wo, Window::near(0.3));

    let wi = Vec3::new(-0.3, -0.9, 0.1).normalize();
    let (f, pdf) = hit.eval_pdf(wi);
    println!("f cos = {:?}, pdf = {pdf}", f.total());
    for lobe in Lobe::ALL {
        println!("  {lobe:>4}: {:?}", f[lobe]);
    }

    // Five uniform random numbers. A sample is missing only if its density underflows.
    if let Some(sample) = hit.sample([0.1, 0.2, 0.3, 0.4, 0.5]) {
        println!("sampled {} with pdf {} and weight {:?}", sample.wi, sample.pdf, sample.weight);
    }

    // The far field: the average over the width of the fibre.
    println!("far field: {:?}", bcsdf.at(wo, Window::far()).eval(wi).total());
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
