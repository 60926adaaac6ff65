//! Yan17 Fig. 6: one index of refraction against two, on a polar bear's fibre lit from behind.

use super::lines::Lines;
use super::one_fiber;
use super::render_animals::judge;
use super::shot::{Method, NEAR, YAN2015};
use super::{Claim, Context, Outcome, Picture, Table, Verdict};
use anyhow::Result;
use glam::Vec3;
use vellus::Fiber;

/// Share of the radius that is medulla.
const KAPPA: f32 = 0.7;

pub fn run(context: &Context) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "A polar bear's fibre lit from behind: with an index of 1.45 for the cortex and of 1.0 for the medulla, the model of 2015 has dark \
         edges at the interface, which a microscope does not show; ours, with 1.45 for both, has none. (The microscope's \
         picture is not ours to show.)",
    );
    // Of no species of Table 4: white, with a wide medulla full of air.
    let fiber = Fiber {
        eta: 1.45,
        kappa: KAPPA,
        alpha: 0.03,
        beta_m: 0.12,
        beta_n: 0.06,
        sigma_ca: [0.02; 3],
        sigma_ma: [0.02; 3],
        sigma_ms: 0.8,
        g: 0.5,
        layers: 0.5,
    };
    let methods: [(Method, &str); 3] = [
        (Method { name: "2015, indices 1.45 and 1.0", key: "two", eta_m: Some(1.0), ..YAN2015 }, "two"),
        (Method { name: "2015, index 1.45", key: "one", ..YAN2015 }, "one"),
        (Method { name: "ours, index 1.45", key: "ours", ..NEAR }, "ours"),
    ];
    let size = quality.pick([40, 8], [200, 60], [400, 120]);
    let mut series = Vec::new();
    for (k, (method, key)) in methods.into_iter().enumerate() {
        // As wide as a microscope's condenser.
        let scene = one_fiber::scene(fiber, size, -Vec3::Z, 0.5, 0.02);
        let name = format!("fiber-{key}");
        let one_fiber::Seen { film, file, profile } =
            one_fiber::render(context, &name, scene, size, method, quality.pick(4, 256, 4096))?;
        let picture = Picture::new(file, format!("{}, {} samples", method.name, film.samples()));
        outcome.pictures.push(if k > 0 { picture.beside() } else { picture });
        series.push((method.name.to_owned(), profile));
    }
    // How far brightness falls below the line between what is within the medulla and what is outside of it: at its edge as it is seen.
    let dip = |profile: &[(f64, f64)]| {
        let mean = |low: f64, high: f64| {
            let inside: Vec<f64> = profile.iter().filter(|p| (low..high).contains(&p.0.abs())).map(|p| p.1).collect();
            inside.iter().sum::<f64>() / inside.len().max(1) as f64
        };
        let low = (5..90).map(|k| f64::from(k) / 100.0).map(|h| mean(h, h + 0.05)).fold(f64::MAX, f64::min);
        low / mean(0.0, 0.3).min(mean(0.0, 0.95)).max(1e-12)
    };
    let dips: Vec<f64> = series.iter().map(|(_, profile)| dip(profile)).collect();
    let mut table = Table::new(
        "across",
        "Brightness across the fibre",
        &["h", methods[0].0.name, methods[1].0.name, methods[2].0.name],
    );
    for i in 0..series[0].1.len() {
        let value = |k: usize| format!("{:.5}", series[k].1[i].1);
        table.row([format!("{:.3}", series[0].1[i].0), value(0), value(1), value(2)]);
    }
    outcome.tables.push(table);
    let chart = Lines {
        title: "A polar bear's fibre lit from behind".to_owned(),
        x: "offset h".to_owned(),
        y: "brightness".to_owned(),
        series,
    };
    outcome.pictures.push(context.draw(&chart, "across", "Brightness across the fibre, averaged along it")?);
    let claim = Claim::new(
        "Two indices make edges of the medulla dark, one does not",
        "the darkest place is darker with two than with one",
        format!("darkest over middle: 2015 with two {:.2}, 2015 with one {:.2}, ours {:.2}", dips[0], dips[1], dips[2]),
        dips[0] / dips[2],
        Verdict::of(dips[0] < 0.8 * dips[2]),
    );
    outcome.claims.push(judge(quality, claim, ""));
    Ok(outcome)
}
