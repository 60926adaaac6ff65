//! Yan17 Fig. 8: the lock of hair, one picture for each lobe.

use crate::context::Context;
use crate::shot::{MULTI, Shot, brightness};
use crate::{Claim, Outcome, Picture, Quality, Table, Verdict};
use anyhow::{Context as _, Result};
use vellus::Lobe;
use vellus_render::Layer;

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "With one index of refraction there are five lobes: R, TT, TRT, and TTˢ and TRTˢ, which the medulla \
         scatters. Each picture shows one lobe of a lock of hair, with all light between the hairs. Each lobe \
         carries a significant part of the light.",
    );
    let scene =
        vellus_groom::published_scene("hair-lock", quality == Quality::Smoke).context("there is no scene hair-lock")?;
    let size = quality.pick([32, 48], [240, 360], [480, 720]);
    let shot = Shot::new(context, "lock", scene, size, [0, 0, size[0], size[1]])?;
    let mut shot = shot.with_layers(&[Layer::Fibers, Layer::Lobes]);
    let film = shot.render(MULTI, 0, quality.pick(4, 48, 1024))?;
    let file = shot.save(&film, "lock", 0.0)?;
    let caption = format!("All lobes, multi-scale, {} samples", film.samples());
    outcome.pictures.push(Picture::new(file, caption).also("lock.exr"));
    // All lobes have the same exposure.
    let mut table = Table::new("lobes", "Share of the light that the camera sees from fibres", &["lobe", "share, %"]);
    let light = |layer: Layer, first: usize| -> f64 {
        let (width, height) = (film.width(), film.height());
        let fibers = |x: usize, y: usize| film.mean(x, y, Layer::Fibers, 0) >= film.mean(x, y, Layer::Alpha, 0);
        let pixels = (0..width * height).map(|i| (i % width, i / width)).filter(|&(x, y)| fibers(x, y));
        pixels.map(|(x, y)| (0..3).map(|c| film.mean(x, y, layer, first + c)).sum::<f64>() / 3.0).sum()
    };
    let lobes: Vec<f64> = (0..6).map(|p| light(Layer::Lobes, 3 * p)).collect();
    let all: f64 = lobes.iter().sum();
    for (p, lobe) in Lobe::ALL.into_iter().enumerate() {
        let name = format!("lobe-{}", lobe.key());
        context.write(&format!("{name}.png"), &shot.layer_png(&film, Layer::Lobes, 3 * p, 1.0)?)?;
        let share = 100.0 * lobes[p] / all;
        let picture = Picture::new(format!("{name}.png"), format!("{}, one stop brighter: {share:.1} %", lobe.key()));
        outcome.pictures.push(if p > 0 { picture.beside() } else { picture });
        table.row([lobe.key().to_owned(), format!("{share:.2}")]);
    }
    let smallest = lobes[..5].iter().map(|l| 100.0 * l / all).fold(f64::MAX, f64::min);
    let what = "Each of the five lobes carries a significant part of the light";
    let claim = Claim::new(what, format!("{smallest:.1} % at least"), smallest, Verdict::of(smallest >= 1.0))
        .paper("significant")
        .ours("bound: 1 % of the light");
    outcome.claims.push(claim.more(format!("Higher orders carry {:.1} %.", 100.0 * lobes[5] / all)));
    // If a pixel shows only fibres, one of the lobes scattered each part of its light.
    let (bright, missing) = (0..film.width() * film.height())
        .map(|i| (i % film.width(), i / film.width()))
        .filter(|&(x, y)| film.mean(x, y, Layer::Fibers, 0) == 1.0)
        .map(|(x, y)| {
            let sum: f64 = (0..18).map(|c| film.mean(x, y, Layer::Lobes, c)).sum::<f64>() / 3.0;
            let all = brightness(&film, x, y);
            (all, (all - sum).abs())
        })
        .fold((0.0f64, 0.0f64), |(a, b), (x, y)| (a.max(x), b.max(y)));
    let off = missing / bright.max(1e-12);
    let what = "The lobes sum to the picture where it shows only hair";
    let claim = Claim::new(what, format!("off by {off:.0e}"), off, Verdict::of(off <= 1e-5));
    outcome.claims.push(claim.ours("bound: 1e-5 of the brightest pixel"));
    outcome.tables.push(table);
    Ok(outcome)
}
