//! Yan17 Fig. 1, 16, 17: raccoon, hamster and cat at equal samples, equal time and equal quality.

use crate::beside::{Input, slider};
use crate::comparison::{Comparison, METHODS, Measured, our_time, parts, ratio};
use crate::context::Context;
use crate::shot::{MULTI, Method, NEAR, Shot, YAN2015, speedup};
use crate::{Claim, Outcome, Picture, Quality, Verdict};
use anyhow::{Context as _, Result};
use vellus_plot::curves::{Axes, Curves};
use vellus_render::Film;

/// A scene of the paper with its claim.
struct Animal {
    scene: &'static str,
    paper: &'static str,
    /// Upper left corner of the part that is compared, in a picture of 1280 × 720 pixels.
    corner: [usize; 2],
    /// The method that the paper compares with the model of 2015, and the speedup that the paper reports.
    method: Method,
    claimed: f64,
    exposure: f32,
}

pub fn raccoon(context: &Context<'_>) -> Result<Outcome> {
    let paper = "A raccoon under a sky, 1,024 samples per pixel. The insets compare 256 samples, and equal quality: \
                 the multi-scale model is more than 8 times as fast as the model of 2015, and the near field has \
                 significantly less noise.";
    run(context, &Animal { scene: "raccoon", paper, corner: [560, 250], method: MULTI, claimed: 8.0, exposure: 0.0 })
}

pub fn hamster(context: &Context<'_>) -> Result<Outcome> {
    let paper = "A hamster in a studio, 1,024 samples per pixel. At equal quality our near field is 3.5 times as \
                 fast as the model of 2015, which has more noise at equal time.";
    run(context, &Animal { scene: "hamster", paper, corner: [480, 240], method: NEAR, claimed: 3.5, exposure: 0.0 })
}

pub fn cat(context: &Context<'_>) -> Result<Outcome> {
    let paper = "A cat in the light of one area light, free of noise at 256 samples per pixel. At equal quality \
                 multi-scale is 6 times as fast as the model of 2015. Its picture equals that of the far field and \
                 takes about the same time.";
    run(context, &Animal { scene: "cat", paper, corner: [600, 360], method: MULTI, claimed: 6.0, exposure: 0.0 })
}

fn run(context: &Context<'_>, animal: &Animal) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(animal.paper);
    let scene = vellus_groom::published_scene(animal.scene, quality == Quality::Smoke);
    let scene = scene.with_context(|| format!("there is no scene {}", animal.scene))?;
    // No claim is judged by the whole picture. The paper's 1,024 samples would take hours of processor time here.
    let whole = quality.pick([64, 36], [640, 360], [640, 360]);
    let mut shot = Shot::new(context, "whole", scene, whole, [0, 0, whole[0], whole[1]])?;
    let film = shot.render(MULTI, 0, quality.pick(2, 16, 64))?;
    let file = shot.save(&film, "whole", animal.exposure)?;
    let caption = format!("{}, multi-scale, {} samples per pixel", animal.scene, film.samples());
    outcome.pictures.push(Picture::new(file, caption).also("whole.exr"));
    let old = shot.render(YAN2015, 0, film.samples())?;
    let caption = format!("The {}, {} samples per pixel each.", animal.scene, film.samples());
    let sides = [(&film, MULTI), (&old, YAN2015)].map(|(film, method)| Input::new(film, method.name));
    outcome.sliders.push(slider(context, "whole-beside", caption, sides, animal.exposure)?);

    // 4,800 pixels: a squared error of 256 samples has a standard error of about 3 %.
    let [width, height] = quality.pick([12, 8], [80, 60], [80, 60]);
    let crop = [animal.corner[0], animal.corner[1], width, height];
    shot.aim("part", [1280, 720], crop);
    // Two halves of 1,024 samples have an eighth of the squared error of the pictures with 256 samples. Points have
    // this share subtracted.
    let half = quality.pick(8, 192, 1024);
    let comparison = Comparison::new(&mut shot, &METHODS, half, quality.pick(4, 64, 256))?;
    let points = &comparison.of(animal.method)?.points;
    outcome.tables.push(comparison.table()?);
    let series = |m: &Measured| (m.method.name.to_owned(), m.points.iter().map(|p| (p.time, p.rmse())).collect());
    let chart = Curves {
        axes: Axes::Logarithmic,
        title: format!("{}: error over time, each against its own converged picture", animal.scene),
        x: format!("processor time of {width} × {height} pixels, s"),
        y: "RMSE".to_owned(),
        series: comparison.measured.iter().map(series).collect(),
    };
    outcome.pictures.push(context.draw(&chart, "convergence", "RMSE over processor time")?);
    insets(context, &mut shot, &mut outcome, animal, &comparison)?;

    let old = &comparison.of(YAN2015)?.points;
    let factor = speedup(points, old, |p| p.mse);
    let what = format!("{} reaches the same error sooner than the model of 2015", animal.method.sentence());
    let verdict = Verdict::at_least(factor, animal.claimed).beside_our_baseline();
    let claim = Claim::new(what, format!("{factor:.2} × as fast"), factor, verdict).or_because(WHY);
    outcome.claims.push(claim.paper(format!("{} ×", animal.claimed)).more(parts(points, old)));
    outcome.claims.push(comparison.beside_published(animal.method)?);
    let frame = 1.0 / ratio(&comparison.of(NEAR)?.points, &comparison.of(MULTI)?.points, |p| p.time);
    let what = "A multi-scale sample takes at most half as long again as one of the near field";
    let claim = Claim::new(what, format!("{frame:.2} × the time"), frame, Verdict::at_most(frame, 1.5));
    outcome.claims.push(claim.paper("about 1.5 ×"));
    outcome.claims.push(our_time("Here", frame));
    Ok(outcome)
}

/// Why the speedup is smaller than in the paper.
const WHY: &str = "Our baseline is our own, optimised version of the model of 2015. It is sampled as well as ours, and \
                   evaluating it costs only twice as much. Most of the time goes to rays. Most of the noise comes from \
                   which strand a ray meets and which light it sees. Both are the same for both models.";

/// Pictures at equal samples, equal time and equal quality, and the converged pictures.
fn insets(
    context: &Context<'_>,
    shot: &mut Shot<'_>,
    outcome: &mut Outcome,
    animal: &Animal,
    comparison: &Comparison,
) -> Result<()> {
    let old = &comparison.converged(YAN2015)?.film;
    let mut show = |film: &Film, name: &str, caption: String, beside: bool| -> Result<()> {
        let file = shot.save(film, name, animal.exposure)?;
        let picture = Picture::new(file, caption).also(format!("{name}.exr"));
        outcome.pictures.push(if beside { picture.beside() } else { picture });
        Ok(())
    };
    let ours = comparison.of(animal.method)?;
    let samples = ours.film.samples();
    for (i, measured) in comparison.measured.iter().enumerate() {
        let (method, error) = (measured.method, measured.last().rmse());
        let caption = format!("{}, {samples} samples, RMSE {error:.4}", method.name);
        show(&measured.film, &format!("equal-samples-{}", method.key), caption, i > 0)?;
    }
    for (i, (method, converged)) in comparison.all_converged().iter().enumerate() {
        let caption = format!("{}, converged ({} samples)", method.name, converged.film.samples());
        show(&converged.film, &format!("converged-{}", method.key), caption, i > 0)?;
    }
    let (mine, theirs) = (ours.last(), comparison.of(YAN2015)?.last());
    let equal_time = (samples as f64 * mine.time / theirs.time).round().max(1.0) as u64;
    let equal_quality = (samples as f64 * theirs.mse / mine.mse.max(1e-300)).round().clamp(1.0, 16.0 * samples as f64);
    let caption = format!("{}, {samples} samples, {:.2} s", animal.method.name, mine.time);
    show(&ours.film, "equal-ours", caption, false)?;
    for (name, what, count) in
        [("equal-time", "equal time", equal_time), ("equal-quality", "equal quality", equal_quality as u64)]
    {
        let mut film = shot.empty();
        let time = shot.extend(YAN2015, &mut film, count)?;
        let error = comparison.converged(YAN2015)?.error(&film, time).rmse();
        let file = shot.save(&film, name, animal.exposure)?;
        let caption = format!("{}, {what}: {count} samples, {time:.2} s, RMSE {error:.4}", YAN2015.name);
        outcome.pictures.push(Picture::new(file, caption).also(format!("{name}.exr")).beside());
        if name == "equal-time" {
            let caption = "A part at equal time. The maps show the noise of each: what it differs by from the picture \
                           that it converges to.";
            let sides = [
                Input::new(&ours.film, format!("{}, {samples} samples, {:.2} s", animal.method.name, mine.time))
                    .against(&comparison.converged(animal.method)?.film),
                Input::new(&film, format!("{}, {count} samples, {time:.2} s", YAN2015.name)).against(old),
            ];
            outcome.sliders.push(slider(context, "equal-time-beside", caption.to_owned(), sides, animal.exposure)?);
        }
    }
    Ok(())
}
