//! Yan17 Fig. 12–13: near field, far field and multi-scale, from afar, close up and in between.

use crate::beside::{Input, slider};
use crate::comparison::{Comparison, our_time};
use crate::context::Context;
use crate::shot::{FAR, MULTI, Method, NEAR, Shot, colors, difference};
use crate::visible::Visible;
use crate::{Claim, Outcome, Picture, Quality, Table, Verdict};
use anyhow::{Context as _, Result, anyhow};
use glam::Vec3;
use vellus_render::{Display, Film};
use vellus_scene::{Camera, Scene};

const METHODS: [Method; 3] = [NEAR, FAR, MULTI];

/// The magnification of the close-up. At draft quality, a pixel is then a fifth of a hair's radius.
const CLOSE: f32 = 300.0;

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "The same lock seen from afar and close up, at 1,024 and 64 samples per pixel. From afar all three methods \
         give the same picture; far field and multi-scale have much less noise, in 1.5 times the time of the near \
         field. Close up, multi-scale gives the picture of the near field; the far field is flat. Zooming in does \
         not flicker.",
    );
    let scene = || {
        let scene = vellus_groom::published_scene("hair-lock", quality == Quality::Smoke);
        scene.context("there is no scene hair-lock")
    };
    let size = quality.pick([24, 16], [96, 64], [240, 160]);
    let counts = quality.pick([4, 2], [128, 16], [1024, 64]);
    let mut table = Table::new(
        "modes",
        "Time, and error against each method's own converged picture; the methods alternate",
        &["view", "method", "samples", "processor time, s", "RMSE", "relMSE"],
    );
    let mut shot = Shot::new(context, "afar", scene()?, size, [0, 0, size[0], size[1]])?;
    let mut frames = [0.0; 2];
    for (k, view, zoom) in [(0, "afar", 1.0), (1, "close", CLOSE)] {
        shot.aim(view, size, [0, 0, size[0], size[1]]);
        shot.set_camera(zoomed(&scene()?, zoom)?)?;
        let half = quality.pick(8, 256, 4096);
        let comparison = Comparison::new(&mut shot, &METHODS, half, counts[0])?;
        for (measured, first) in comparison.measured.iter().zip([true, false, false]) {
            let (method, film) = (measured.method, &measured.film);
            for count in counts {
                let Some(point) = measured.points.iter().find(|p| p.samples == count) else { continue };
                table.row([
                    view.to_owned(),
                    method.name.to_owned(),
                    count.to_string(),
                    format!("{:.2}", point.time),
                    format!("{:.5}", point.rmse()),
                    format!("{:.5}", point.rel_mse.max(0.0)),
                ]);
            }
            let name = format!("{view}-{}", method.key);
            let file = shot.save(film, &name, 0.0)?;
            let error = measured.last().rmse();
            let caption = format!("{view}: {}, {} samples, RMSE {error:.4}", method.name, film.samples());
            let picture = Picture::new(file, caption).also(format!("{name}.exr"));
            outcome.pictures.push(if first { picture } else { picture.beside() });
        }
        for (method, first) in METHODS.into_iter().zip([true, false, false]) {
            let mut film = shot.empty();
            shot.extend(method, &mut film, counts[1])?;
            let name = format!("{view}-{}-few", method.key);
            let file = shot.save(&film, &name, 0.0)?;
            let picture = Picture::new(file, format!("{view}: {}, {} samples", method.name, counts[1]));
            outcome.pictures.push(if first { picture } else { picture.beside() });
        }
        let (near, multi) = (comparison.of(NEAR)?.last(), comparison.of(MULTI)?.last());
        frames[k] = multi.time / near.time;
        if k == 0 {
            let noise = near.mse / multi.mse;
            let claim = Claim::new(
                "From afar multi-scale has less noise than the near field at equal samples",
                format!("{noise:.2} × less mean square error"),
                noise,
                Verdict::of(noise > 1.2),
            )
            .paper("much less")
            .ours("bound: 1.2 ×");
            outcome.claims.push(claim);
        }
        let near = comparison.converged(NEAR)?;
        let (other, caption) = if k == 0 {
            (MULTI, "From afar, converged: both methods give the same picture.")
        } else {
            (FAR, "Close up, converged: the far field is flat.")
        };
        let sides = [(&near.film, NEAR), (&comparison.converged(other)?.film, other)]
            .map(|(film, method)| Input::new(film, method.name));
        outcome.sliders.push(slider(context, &format!("{view}-beside"), caption.to_owned(), sides, 0.0)?);
        for (method, close) in [(MULTI, true), (FAR, false)] {
            let (name, other) = (method.name, comparison.converged(method)?);
            let (z, offset, spread) = difference(&other.film, &near.film);
            // The same ratio for noise only, because heavy-tailed samples underestimate errors.
            let noise = near.spread.max(other.spread);
            let visible = Visible::new(other.halves(), near.halves());
            let brightness = format!("Brightness of the fur {:+.2} %, z = {z:.1}", 100.0 * offset);
            let same = z.abs() < 3.0 && spread < 1.1 * noise;
            let claim = if k == 0 || close {
                let place = if k == 0 { "From afar" } else { "Close up" };
                let what = format!("{place} {name} gives the picture of the near field");
                let more = format!(
                    "{brightness}; pixels differ by {spread:.2} standard errors (root mean square), halves of one \
                     picture by {noise:.2}; {}.",
                    visible.text()
                );
                Claim::new(what, format!("{:.2} × the noise", spread / noise), spread / noise, Verdict::of(same))
                    .paper("the same picture")
                    .ours("bound: 1.1 × the noise, |z| < 3")
                    .more(more)
            } else {
                visible.claim("Close up the far field differs visibly from the near field", "flat", &brightness)
            };
            let why = "Which parts are hidden depends on the offsets that a far field averages.";
            outcome.claims.push(claim.or_because(why));
        }
    }
    let [afar, close] = frames;
    let [first, second] = frames.map(|time| format!("{time:.2} × the time"));
    let what = "From afar a multi-scale frame takes at most half as long again as one of the near field";
    outcome.claims.push(Claim::new(what, first, afar, Verdict::at_most(afar, 1.5)).paper("about 1.5 ×"));
    let what = "Close up a multi-scale frame takes relatively less time than from afar";
    let claim = Claim::new(what, second, close, Verdict::of(close <= afar)).paper("closer to the near field's time");
    outcome.claims.push(claim.more(format!("From afar {afar:.2} ×.")));
    outcome.claims.extend([our_time("From afar", afar), our_time("Close up", close)]);
    outcome.tables.push(table);
    sequence(context, &mut shot, &scene()?, &mut outcome)?;
    Ok(outcome)
}

/// The scene's camera with a narrower view of the lock's middle.
fn zoomed(scene: &Scene, zoom: f32) -> Result<Camera> {
    let camera = scene.camera.context("the lock has no camera")?;
    let eye = camera.to_world.transform_point3(Vec3::ZERO);
    // The middle of a strand in the middle of the picture.
    let fur = scene.strands.first().context("the lock has no strands")?;
    let strand = fur.strand(fur.len() / 2);
    let target = strand[strand.len() / 2].truncate();
    let aspect = camera.film_width / camera.film_height;
    let angle = 2.0 * (0.5 * camera.film_height / zoom).atan();
    Ok(Camera::look_at(eye, target, Vec3::Y, angle, aspect))
}

/// Zooms from afar to close up in even steps.
fn sequence(context: &Context<'_>, shot: &mut Shot<'_>, scene: &Scene, outcome: &mut Outcome) -> Result<()> {
    let quality = context.quality;
    let steps = quality.pick(2, 13, 49);
    let size = quality.pick([24, 16], [96, 64], [240, 160]);
    let (mut films, mut worst) = (Vec::new(), (0.0f64, 0.0f64));
    let mut table = Table::new(
        "zoom",
        "Multi-scale against the near field while zooming in",
        &["zoom", "near: mean", "multi-scale: mean", "difference, %", "its standard errors"],
    );
    let stage = context.stage(steps as u64, "zooming");
    for k in 0..steps {
        context.check_interrupted()?;
        let zoom = CLOSE.powf(k as f32 / (steps - 1).max(1) as f32);
        shot.aim("zoom", size, [0, 0, size[0], size[1]]);
        shot.set_camera(zoomed(scene, zoom)?)?;
        let mut pair = [shot.empty(), shot.empty()];
        for (film, method) in pair.iter_mut().zip([NEAR, MULTI]) {
            shot.extend(method, film, quality.pick(2, 32, 256))?;
        }
        let (z, offset, _) = difference(&pair[1], &pair[0]);
        if z.abs() > worst.0.abs() {
            worst = (z, offset);
        }
        let mean = |film: &Film| colors(film).iter().sum::<f64>() / (3 * size[0] * size[1]) as f64;
        table.row([
            format!("{zoom:.2}"),
            format!("{:.5}", mean(&pair[0])),
            format!("{:.5}", mean(&pair[1])),
            format!("{:+.2}", 100.0 * offset),
            format!("{z:+.1}"),
        ]);
        films.push(pair[1].clone());
        stage.advance(1);
    }
    context.write("zoom.png", &animated(&films).map_err(|e| anyhow!("cannot encode PNG: {e}"))?)?;
    outcome
        .pictures
        .push(Picture::new("zoom.png", "Zooming in, multi-scale (an animation, if the viewer supports it)"));
    outcome.tables.push(table);
    let claim = Claim::new(
        "The brightness of multi-scale stays that of the near field while zooming in",
        format!("{:+.1} standard errors at worst", worst.0),
        worst.0.abs(),
        Verdict::of(worst.0.abs() < 4.0),
    )
    .paper("no flicker")
    .ours("bound: 4 standard errors in every frame")
    .more(format!("{:+.2} % of the brightness, of {steps} frames.", 100.0 * worst.1));
    outcome.claims.push(claim);
    Ok(())
}

/// An animated PNG, ten pictures a second.
fn animated(films: &[Film]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let [width, height] = films.first().map_or([1, 1], |f| [f.width() as u32, f.height() as u32]);
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_animated(films.len() as u32, 0)?;
    encoder.set_frame_delay(1, 10)?;
    let mut writer = encoder.write_header()?;
    for film in films {
        writer.write_image_data(&film.to_srgb(Display::srgb(0.0)))?;
    }
    writer.finish()?;
    Ok(bytes)
}
