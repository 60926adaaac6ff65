//! Yan17 Fig. 5: near field against far field close up.

use crate::beside::{Input, slider};
use crate::context::Context;
use crate::one_fiber;
use crate::shot::{FAR, MULTI, NEAR, Shot};
use crate::{Claim, Outcome, Picture, Verdict};
use anyhow::{Context as _, Result};
use glam::Vec3;
use vellus::{Fiber, Species};
use vellus_scene::Camera;

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "Close up, the far field makes fur look like flat ribbons. The near field shows cylinders and the medulla \
         inside.",
    );
    // The strands of the small scene are thick, so they look like thin strands at a shorter distance.
    let scene = vellus_groom::published_scene("cat", true).context("there is no scene cat")?;
    let eye = scene.camera.context("the cat has no camera")?.to_world.transform_point3(Vec3::ZERO);
    let fur = scene.strands.first().context("the cat has no fur")?;
    // The strand nearest to the camera is fully visible.
    let nearest = (0..fur.len())
        .map(|i| fur.strand(i)[fur.strand(i).len() / 2].truncate())
        .min_by(|a, b| a.distance(eye).total_cmp(&b.distance(eye)))
        .context("the cat has no fur")?;
    let size = quality.pick([24, 16], [240, 160], [720, 480]);
    let camera = Camera::look_at(eye, nearest, Vec3::Y, 0.6f32.to_radians(), 1.5);
    let scene = vellus_scene::Scene { camera: Some(camera), ..scene };
    let mut shot = Shot::new(context, "fur", scene, size, [0, 0, size[0], size[1]])?;
    let mut films = Vec::new();
    for (method, first) in [(NEAR, true), (MULTI, false), (FAR, false)] {
        let film = shot.render(method, 0, quality.pick(2, 64, 1024))?;
        let name = format!("fur-{}", method.key);
        let file = shot.save(&film, &name, 0.0)?;
        let picture = Picture::new(file, format!("Fur close up: {}", method.name)).also(format!("{name}.exr"));
        outcome.pictures.push(if first { picture } else { picture.beside() });
        films.push(film);
    }
    let caption = "Fur close up. The near field shows cylinders; the far field shows flat ribbons.".to_owned();
    let sides = [(0, NEAR), (2, FAR)].map(|(k, method)| Input::new(&films[k], method.name));
    outcome.sliders.push(slider(context, "beside", caption, sides, 0.0)?);
    let size = quality.pick([40, 2], [200, 8], [400, 16]);
    let light = Vec3::new(0.6, 0.3, 0.75);
    let mut series = Vec::new();
    let mut spread = [0.0; 3];
    for (k, method) in [NEAR, MULTI, FAR].into_iter().enumerate() {
        let scene = one_fiber::scene(Fiber::published(Species::Raccoon), size, light, 0.1, 0.05);
        let name = format!("fiber-{}", method.key);
        let profile = one_fiber::render(context, &name, scene, size, method, quality.pick(4, 512, 8192))?.profile;
        let n = profile.len() as f64;
        let mean = profile.iter().map(|p| p.1).sum::<f64>() / n;
        spread[k] = (profile.iter().map(|p| (p.1 - mean).powi(2)).sum::<f64>() / n).sqrt() / mean;
        series.push((method.name.to_owned(), profile));
    }
    one_fiber::show(context, &mut outcome, "A raccoon's fibre across its width, lit from the right", series)?;
    let [near, multi, far] = spread;
    let claim = Claim::new(
        "Close up the far field makes a fibre look flat",
        format!("{:.1} % of the near field's variation", 100.0 * far / near),
        far / near,
        Verdict::of(far < 0.1 * near),
    )
    .paper("like flat ribbons")
    .ours("bound: 10 %")
    .more(format!(
        "Brightness across a fibre varies by {:.1} % of the mean; near field {:.0} %, multi-scale {:.0} %.",
        100.0 * far,
        100.0 * near,
        100.0 * multi
    ));
    outcome.claims.push(claim);
    Ok(outcome)
}
