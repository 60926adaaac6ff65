//! Yan17 Fig. 1, 16, 17: raccoon, hamster and cat at equal samples, equal time and equal quality.

use super::curves::{Axes, Curves};
use super::shot::{Converged, FAR, MULTI, Method, NEAR, PUBLISHED, Point, Shot, YAN2015, speedup};
use super::{Claim, Context, Outcome, Picture, Quality, Table, Verdict};
use anyhow::{Context as _, Result};
use vellus_render::Film;

/// A scene of the paper and what is said of it.
struct Animal {
    scene: &'static str,
    paper: &'static str,
    /// The part of 1280 × 720 that is compared: the left upper corner.
    corner: [usize; 2],
    /// Which of ours the paper compares with 2015, and how many times as fast it finds that.
    method: Method,
    claimed: f64,
    exposure: f32,
}

pub fn raccoon(context: &Context) -> Result<Outcome> {
    let paper = "A raccoon under a sky, 1,024 samples a pixel; insets at 256 samples, and at equal quality: the multi-scale model \
                 is more than 8 times as fast as that of 2015, the near field has significantly less noise than it.";
    run(context, &Animal { scene: "raccoon", paper, corner: [560, 250], method: MULTI, claimed: 8.0, exposure: 0.0 })
}

pub fn hamster(context: &Context) -> Result<Outcome> {
    let paper = "A hamster in a studio, 1,024 samples a pixel: at equal quality our near field is 3.5 times as fast as the model of \
                 2015; at equal time that shows more noise.";
    run(context, &Animal { scene: "hamster", paper, corner: [480, 240], method: NEAR, claimed: 3.5, exposure: 0.0 })
}

pub fn cat(context: &Context) -> Result<Outcome> {
    let paper = "A cat in the light of one area light, noise-free at 256 samples a pixel: at equal quality multi-scale is 6 times as \
                 fast as the model of 2015; its picture and that of the far field are the same, in about the same time.";
    run(context, &Animal { scene: "cat", paper, corner: [600, 360], method: MULTI, claimed: 6.0, exposure: 0.0 })
}

/// Those that are compared.
pub const METHODS: [Method; 5] = [NEAR, MULTI, FAR, YAN2015, PUBLISHED];
/// Which of them is that of 2015 sampled as well as ours, and which as it was published. They converge to the same picture.
pub const OLD: usize = 3;
pub const AS_PUBLISHED: usize = 4;

/// Converged pictures of all but the last method.
pub fn converge(shot: &mut Shot<'_>, half: u64) -> Result<Vec<Converged>> {
    METHODS[..AS_PUBLISHED].iter().map(|m| shot.converge(*m, half)).collect()
}

/// Each method with the picture it converges to.
pub fn pairs(converged: &[Converged]) -> Vec<(Method, &Converged)> {
    METHODS.into_iter().zip(converged.iter().chain(&converged[OLD..])).collect()
}

fn run(context: &Context, animal: &Animal) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(animal.paper);
    let scene = vellus_groom::scene(animal.scene, quality == Quality::Smoke);
    let scene = scene.with_context(|| format!("there is no scene {}", animal.scene))?;
    // All of it first.
    let whole = quality.pick([64, 36], [640, 360], [1280, 720]);
    let mut shot = Shot::new(context, "whole", scene, whole, [0, 0, whole[0], whole[1]])?;
    let film = shot.render(MULTI, 0, quality.pick(2, 16, 1024))?;
    let file = shot.save(&film, "whole", animal.exposure)?;
    let caption = format!("{}, multi-scale, {} samples a pixel", animal.scene, film.samples());
    outcome.pictures.push(Picture::new(file, caption).also("whole.exr"));

    let [width, height] = quality.pick([12, 8], [80, 60], [160, 120]);
    let crop = [animal.corner[0], animal.corner[1], width, height];
    shot.aim("part", [1280, 720], crop);
    let half = quality.pick(8, 192, 8192);
    let converged = converge(&mut shot, half)?;
    let pairs = pairs(&converged);
    let most = quality.pick(4, 64, 256);
    let found = shot.measure(&pairs, most)?;
    let index = METHODS.iter().position(|m| *m == animal.method).unwrap_or(0);
    let points = &found[index].0;
    outcome.tables.push(error_table(&found, &pairs));
    let series = |(m, (points, _)): (&Method, &(Vec<Point>, Film))| {
        (m.name.to_owned(), points.iter().map(|p| (p.time, p.rmse())).collect())
    };
    let chart = Curves {
        axes: Axes::Logarithmic,
        title: format!("{}: error over time, each against its own converged picture", animal.scene),
        x: format!("processor time of {width} × {height} pixels, s"),
        y: "RMSE".to_owned(),
        series: METHODS.iter().zip(&found).map(series).collect(),
    };
    outcome.pictures.push(context.draw(&chart, "convergence", "RMSE over processor time")?);
    insets(&mut shot, &mut outcome, animal, &pairs, &found, index)?;

    let old = &found[OLD].0;
    let factor = speedup(points, old, |p| p.mse);
    let relative = speedup(points, old, |p| p.rel_mse);
    let (a, b) = (ratio(old, points, |p| p.mse), ratio(old, points, |p| p.time));
    let what = format!("{}: {} beside Yan et al. 2015, speed at equal quality", animal.scene, animal.method.name);
    let measured = format!(
        "{factor:.2} × (relMSE: {relative:.2} ×); of that {a:.2} × by the noise of a sample, {b:.2} × by its time"
    );
    let (expected, verdict) = (format!("{} ×", animal.claimed), Verdict::at_least(factor, animal.claimed));
    outcome.claims.push(Claim::new(what, expected, measured, factor, verdict).or_because(WHY));
    outcome.claims.push(beside_published(animal.scene, animal.method.name, points, &found[AS_PUBLISHED].0));
    let frame = 1.0 / ratio(&found[0].0, &found[1].0, |p| p.time);
    outcome.claims.push(Claim::new(
        format!("{}: time of a multi-scale sample over one of the near field", animal.scene),
        "at most 1.15 (the paper: about 1.5)",
        format!("{frame:.3}"),
        frame,
        Verdict::at_most(frame, 1.15),
    ));
    Ok(outcome)
}

/// Speed at equal quality beside the model of 2015 as it was sampled then: what of the paper's factor is sampling's.
pub fn beside_published(scene: &str, name: &str, points: &[Point], published: &[Point]) -> Claim {
    let [factor, relative] = [|p: &Point| p.mse, |p: &Point| p.rel_mse].map(|of| speedup(points, published, of));
    Claim::not_judged(
        format!("{scene}: {name} beside 2015 sampled as published, speed at equal quality"),
        "more than beside 2015 sampled as well as ours",
        format!("{factor:.2} × (relMSE: {relative:.2} ×)"),
        "Each sample is weighted by its lobe alone; the scattered lobes are sampled evenly over the sphere.",
    )
}

/// What explains that it is less.
const WHY: &str = "Here the model of 2015 is sampled as well as ours, and a query of it costs twice one of ours, not many times: most of \
                   the time goes to rays, most of the noise to which strand a ray meets and which light it sees, and \
                   those are the same for both.";

/// Of the last three points of each, geometric means.
pub fn ratio(a: &[Point], b: &[Point], of: impl Fn(&Point) -> f64) -> f64 {
    let last = a.len().min(b.len()).min(3);
    let log = |p: &Point| of(p).max(1e-300).ln();
    let sum: f64 = (1..=last).map(|k| log(&a[a.len() - k]) - log(&b[b.len() - k])).sum();
    (sum / last.max(1) as f64).exp()
}

/// Of all methods.
pub fn error_table(found: &[(Vec<Point>, Film)], pairs: &[(Method, &Converged)]) -> Table {
    let header = ["method", "samples", "processor time, s", "RMSE", "relMSE", "mean of the converged picture"];
    let mut table = Table::new("errors", "Error and time; methods took turns on the same machine", &header);
    for ((method, converged), (points, _)) in pairs.iter().zip(found) {
        for point in points {
            table.row([
                method.name.to_owned(),
                point.samples.to_string(),
                format!("{:.3}", point.time),
                format!("{:.5}", point.rmse()),
                format!("{:.5}", point.rel_mse.max(0.0)),
                format!("{:.5}", converged.mean()),
            ]);
        }
    }
    table
}

/// Equal samples, equal time, equal quality, and the converged pictures.
fn insets(
    shot: &mut Shot<'_>,
    outcome: &mut Outcome,
    animal: &Animal,
    pairs: &[(Method, &Converged)],
    found: &[(Vec<Point>, Film)],
    index: usize,
) -> Result<()> {
    let mut show = |film: &Film, name: &str, caption: String, beside: bool| -> Result<()> {
        let file = shot.save(film, name, animal.exposure)?;
        let picture = Picture::new(file, caption).also(format!("{name}.exr"));
        outcome.pictures.push(if beside { picture.beside() } else { picture });
        Ok(())
    };
    let samples = found[index].1.samples();
    for (i, (method, (points, film))) in METHODS.iter().zip(found).enumerate() {
        let error = points.last().map_or(0.0, Point::rmse);
        let caption = format!("{}, {samples} samples, RMSE {error:.4}", method.name);
        show(film, &format!("equal-samples-{}", method.key), caption, i > 0)?;
    }
    for (i, (method, converged)) in pairs[..AS_PUBLISHED].iter().enumerate() {
        let caption = format!("{}, converged ({} samples)", method.name, converged.film.samples());
        show(&converged.film, &format!("converged-{}", method.key), caption, i > 0)?;
    }
    let (Some(mine), Some(theirs)) = (found[index].0.last(), found[OLD].0.last()) else { return Ok(()) };
    let equal_time = (samples as f64 * mine.time / theirs.time).round().max(1.0) as u64;
    let equal_quality = (samples as f64 * theirs.mse / mine.mse.max(1e-300)).round().clamp(1.0, 16.0 * samples as f64);
    let caption = format!("{}, {samples} samples, {:.2} s", animal.method.name, mine.time);
    show(&found[index].1, "equal-ours", caption, false)?;
    for (name, what, count) in
        [("equal-time", "equal time", equal_time), ("equal-quality", "equal quality", equal_quality as u64)]
    {
        let mut film = shot.empty();
        let time = shot.extend(YAN2015, &mut film, count)?;
        let error = pairs[OLD].1.error(&film, time).rmse();
        let file = shot.save(&film, name, animal.exposure)?;
        let caption = format!("{}, {what}: {count} samples, {time:.2} s, RMSE {error:.4}", YAN2015.name);
        outcome.pictures.push(Picture::new(file, caption).also(format!("{name}.exr")).beside());
    }
    Ok(())
}
