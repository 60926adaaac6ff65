//! Yan17 Fig. 15: convergence and frame times on the lock of hair.

use crate::comparison::{Comparison, METHODS, parts, ratio};
use crate::context::Context;
use crate::shot::{FAR, MULTI, NEAR, PUBLISHED, Point, Shot, YAN2015, speedup};
use crate::{Claim, Outcome, Quality, Verdict};
use anyhow::{Context as _, Result};
use vellus_plot::bars::Bars;
use vellus_plot::curves::{Axes, Curves};

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "On the central 32 × 32 pixels of the lock of hair, the near field converges twice as fast as the model of \
         2015, and multi-scale an order of magnitude faster. A frame takes half the time of 2015 with the near \
         field, and less time than 2015 with the other modes.",
    );
    let scene =
        vellus_groom::published_scene("hair-lock", quality == Quality::Smoke).context("there is no scene hair-lock")?;
    let side = quality.pick(8, 32, 32);
    let mut shot = Shot::new(context, "patch", scene, [1280, 720], [560, 344, side, side])?;
    let half = quality.pick(8, 1024, 16384);
    let comparison = Comparison::new(&mut shot, &METHODS, half, quality.pick(4, 256, 1024))?;
    outcome.tables.push(comparison.table()?);
    for (name, x, of) in [
        ("over-samples", "samples per pixel", (|p: &Point| p.samples as f64) as fn(&Point) -> f64),
        ("over-time", "processor time, s", |p: &Point| p.time),
    ] {
        let series = comparison.measured.iter();
        let chart = Curves {
            axes: Axes::Logarithmic,
            title: "Lock of hair: error, each against its own converged picture".to_owned(),
            x: x.to_owned(),
            y: "RMSE".to_owned(),
            series: series
                .map(|m| (m.method.name.to_owned(), m.points.iter().map(|p| (of(p), p.rmse())).collect()))
                .collect(),
        };
        outcome.pictures.push(context.draw(&chart, name, format!("RMSE over {x}"))?);
    }
    let pixels = (side * side) as f64;
    let time = |p: &Point| 1e6 * p.time / (p.samples as f64 * pixels);
    let times = comparison.measured.iter().map(|m| m.points.last().map_or(0.0, time)).collect();
    let bars = Bars {
        title: "Lock of hair: time of a sample".to_owned(),
        unit: "processor time of a sample, µs".to_owned(),
        groups: METHODS.iter().map(|m| m.name.to_owned()).collect(),
        series: vec![("total, including rays".to_owned(), times)],
        digits: Some(2),
    };
    outcome.pictures.push(context.draw(&bars, "times", "Total processor time of one sample of a pixel")?);
    let old = &comparison.of(YAN2015)?.points;
    let published = &comparison.of(PUBLISHED)?.points;
    let why = "Our baseline is our own, optimised version of the model of 2015. It is sampled as well as ours. Rays \
               take most of the time of a sample.";
    for (method, claimed, expected) in [(NEAR, 2.0, "2 ×"), (MULTI, 10.0, "10 ×: an order of magnitude")] {
        let points = &comparison.of(method)?.points;
        let factor = speedup(points, old, |p| p.mse);
        let claim = Claim::new(
            format!("{} reaches the same error sooner than the model of 2015", method.sentence()),
            format!("{factor:.2} × as fast"),
            factor,
            Verdict::at_least(factor, claimed).beside_our_baseline(),
        )
        .paper(expected)
        .more(parts(points, old));
        outcome.claims.push(claim.or_because(why));
        outcome.claims.push(comparison.beside_published(method)?);
    }
    for (method, claimed, expected) in [(NEAR, 2.0, "2 ×"), (MULTI, 1.0, "above 1 ×"), (FAR, 1.0, "above 1 ×")] {
        let points = &comparison.of(method)?.points;
        let factor = ratio(old, points, |p| p.time);
        let claim = Claim::new(
            format!("{} renders a frame in less time than the model of 2015", method.sentence()),
            format!("{factor:.2} × as fast"),
            factor,
            Verdict::at_least(factor, claimed).beside_our_baseline(),
        )
        .paper(expected)
        .more(format!("Beside 2015 as published {:.2} ×.", ratio(published, points, |p| p.time)));
        let why = "Rays take most of the time, and both trace the same.";
        outcome.claims.push(claim.or_because(why));
    }
    Ok(outcome)
}
