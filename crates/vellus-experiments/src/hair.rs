//! Yan17 Fig. 18: hair with and without a medulla.

use crate::beside::{Input, slider};
use crate::context::Context;
use crate::shot::{MULTI, Shot, colors, difference};
use crate::visible::Visible;
use crate::{Outcome, Picture, Quality, Table};
use anyhow::{Context as _, Result, bail};

/// The paper's medulla.
const KAPPA: f32 = 0.15;

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "Human hair rendered multi-scale, without a medulla and with a medulla of κ = 0.15. The difference is \
         clearly visible: the hair looks more diffuse, even with so small a medulla.",
    );
    let size = quality.pick([24, 36], [320, 360], [640, 720]);
    let mut films = Vec::new();
    let mut table = Table::new("hair", "The same hair with and without a medulla", &["κ", "mean", "samples", "noise"]);
    for kappa in [0.0, KAPPA] {
        let mut scene =
            vellus_groom::published_scene("hair", quality == Quality::Smoke).context("there is no scene hair")?;
        scene.looks.iter_mut().for_each(|look| look.fiber.kappa = kappa);
        let name = if kappa > 0.0 { "medulla" } else { "no-medulla" };
        // The head is in the middle of a wider picture.
        let whole = [16 * size[1] / 9, size[1]];
        let crop = [(whole[0] - size[0]) / 2, 0, size[0], size[1]];
        let mut shot = Shot::new(context, name, scene, whole, crop)?;
        let half = quality.pick(2, 32, 512);
        let halves = [shot.render(MULTI, 0, half)?, shot.render(MULTI, 1, half)?];
        let mut film = halves[0].clone();
        film.merge(&halves[1]);
        let file = shot.save(&film, name, 0.0)?;
        let picture = Picture::new(file, format!("κ = {kappa}")).also(format!("{name}.exr"));
        outcome.pictures.push(if kappa > 0.0 { picture.beside() } else { picture });
        let values = colors(&film);
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        table.row([
            kappa.to_string(),
            format!("{mean:.5}"),
            film.samples().to_string(),
            film.noise().map_or("unknown".to_owned(), |noise| format!("{noise:.4}")),
        ]);
        films.push((film, halves));
    }
    outcome.tables.push(table);
    let caption = "The same hair and the same light, multi-scale.".to_owned();
    let labels = ["no medulla".to_owned(), format!("medulla, κ = {KAPPA}")];
    let [(without, a), (with, b)] = films.as_slice() else { bail!("two pictures are compared") };
    let [left, right] = labels;
    let sides = [Input::new(without, left), Input::new(with, right)];
    outcome.sliders.push(slider(context, "beside", caption, sides, 0.0)?);
    let (_, offset, _) = difference(with, without);
    let visible = Visible::new([&b[0], &b[1]], [&a[0], &a[1]]);
    let more = format!("Brightness of the hair {:+.1} %", 100.0 * offset);
    let what = "A medulla of κ = 0.15 makes a visible difference";
    outcome.claims.push(visible.claim(what, "clearly visible", &more));
    Ok(outcome)
}
