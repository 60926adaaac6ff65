//! Yan17 Fig. 15: convergence and frame times on the lock of hair.

use super::bars::Bars;
use super::curves::{Axes, Curves};
use super::render_animals::{AS_PUBLISHED, METHODS, OLD, beside_published, converge, error_table, pairs, ratio};
use super::shot::{Point, Shot, speedup};
use super::{Claim, Context, Outcome, Quality, Verdict};
use anyhow::{Context as _, Result};

pub fn run(context: &Context) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "On the central 32 × 32 pixels of the lock of hair, the near field converges twice as fast as the model of 2015, multi-scale an order \
         of magnitude faster; a frame takes half the time of 2015 with the near field, and less than it with the others.",
    );
    let scene = vellus_groom::scene("hair-lock", quality == Quality::Smoke).context("there is no scene hair-lock")?;
    let side = quality.pick(8, 32, 32);
    let mut shot = Shot::new(context, "patch", scene, [1280, 720], [560, 344, side, side])?;
    let half = quality.pick(8, 1024, 16384);
    let converged = converge(&mut shot, half)?;
    let pairs = pairs(&converged);
    let found = shot.measure(&pairs, quality.pick(4, 256, 1024))?;
    outcome.tables.push(error_table(&found, &pairs));
    for (name, x, of) in [
        ("over-samples", "samples a pixel", (|p: &Point| p.samples as f64) as fn(&Point) -> f64),
        ("over-time", "processor time, s", |p: &Point| p.time),
    ] {
        let series = METHODS.iter().zip(&found);
        let chart = Curves {
            axes: Axes::Logarithmic,
            title: "Lock of hair: error, each against its own converged picture".to_owned(),
            x: x.to_owned(),
            y: "RMSE".to_owned(),
            series: series
                .map(|(m, (points, _))| (m.name.to_owned(), points.iter().map(|p| (of(p), p.rmse())).collect()))
                .collect(),
        };
        outcome.pictures.push(context.draw(&chart, name, format!("RMSE over {x}"))?);
    }
    let time = |k: usize| found[k].0.last().map_or(0.0, |p| 1e6 * p.time / (p.samples as f64 * (side * side) as f64));
    let bars = Bars {
        title: "Lock of hair: time of a sample".to_owned(),
        unit: "processor time of a sample, µs".to_owned(),
        groups: METHODS.iter().map(|m| m.name.to_owned()).collect(),
        series: vec![("all of it, rays too".to_owned(), (0..METHODS.len()).map(time).collect())],
        digits: Some(2),
    };
    outcome.pictures.push(context.draw(&bars, "times", "Processor time of one sample of a pixel, all of it")?);
    let (old, published) = (&found[OLD].0, &found[AS_PUBLISHED].0);
    let why = "The model of 2015 is sampled here as well as ours, and most of a sample's time goes to rays.";
    for (k, claimed, expected) in [(0, 2.0, "2 ×"), (1, 10.0, "an order of magnitude: 10 ×")] {
        let factor = speedup(&found[k].0, old, |p| p.mse);
        let relative = speedup(&found[k].0, old, |p| p.rel_mse);
        let claim = Claim::new(
            format!("The {} converges faster than the model of 2015 (time to the same error)", METHODS[k].name),
            expected,
            format!("{factor:.2} × (relMSE: {relative:.2} ×)"),
            factor,
            Verdict::at_least(factor, claimed),
        );
        outcome.claims.push(claim.or_because(why));
        outcome.claims.push(beside_published("lock of hair", METHODS[k].name, &found[k].0, published));
    }
    for (k, claimed, expected) in [(0, 2.0, "twice as fast"), (1, 1.0, "faster"), (2, 1.0, "faster")] {
        let factor = ratio(old, &found[k].0, |p| p.time);
        let claim = Claim::new(
            format!("A frame by the {} takes less time than by the model of 2015", METHODS[k].name),
            expected,
            format!("{factor:.2} × as fast"),
            factor,
            Verdict::at_least(factor, claimed),
        );
        outcome.claims.push(claim.or_because("Rays take most of the time, and they are the same."));
    }
    Ok(outcome)
}
