//! Yan17 Fig. 6: one index of refraction against two, on a polar bear's fibre lit from behind.

use crate::beside::{Input, slider};
use crate::context::Context;
use crate::one_fiber;
use crate::shot::{Method, NEAR, YAN2015};
use crate::{Claim, Outcome, Picture, Verdict};
use anyhow::Result;
use glam::Vec3;
use vellus::{Fiber, ScatterExit};

/// Radius of the medulla relative to the fibre's.
const KAPPA: f32 = 0.7;

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let quality = context.quality;
    let mut outcome = Outcome::new(
        "A polar bear's fibre lit from behind. With an index of 1.45 for the cortex and 1.0 for the medulla, the \
         model of 2015 has dark edges at the interface, which a microscope does not show. Our model, with 1.45 for \
         both, has none. (We may not reproduce the picture of the microscope.)",
    );
    // The polar bear is not in Table 4. Its fibre is white, with a wide medulla full of air.
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
        exit: ScatterExit::Open,
        medulla_pigment: 0.3,
        wet: 0.0,
        aspect_ratio: 1.0,
        medulla_air: 0.0,
        reflectance: None,
    };
    let methods: [(Method, &str); 3] = [
        (Method { name: "2015, indices 1.45 and 1.0", key: "two", eta_m: Some(1.0), ..YAN2015 }, "two"),
        (Method { name: "2015, index 1.45", key: "one", ..YAN2015 }, "one"),
        (Method { name: "ours, index 1.45", key: "ours", ..NEAR }, "ours"),
    ];
    let size = quality.pick([40, 8], [200, 60], [400, 120]);
    let (mut series, mut films) = (Vec::new(), Vec::new());
    for (k, (method, key)) in methods.into_iter().enumerate() {
        // The width of a microscope's condenser.
        let scene = one_fiber::scene(fiber, size, -Vec3::Z, 0.5, 0.02);
        let name = format!("fiber-{key}");
        let one_fiber::Seen { film, file, profile } =
            one_fiber::render(context, &name, scene, size, method, quality.pick(4, 256, 4096))?;
        let picture = Picture::new(file, format!("{}, {} samples", method.name, film.samples()));
        outcome.pictures.push(if k > 0 { picture.beside() } else { picture });
        series.push((method.name.to_owned(), profile));
        films.push(film);
    }
    let caption = "A polar bear's fibre across the picture, lit from behind.".to_owned();
    let sides = [0, 2].map(|k| Input::new(&films[k], methods[k].0.name));
    outcome.sliders.push(slider(context, "beside", caption, sides, one_fiber::EXPOSURE)?);
    // The depth of a dark band between two brighter places; 0 if there is no such band. The bright edge of the
    // cuticle is excluded.
    let band = |profile: &[(f64, f64)]| {
        let side: Vec<f64> = profile.iter().filter(|p| (0.0..0.95).contains(&p.0)).map(|p| p.1).collect();
        let largest = |part: &[f64]| part.iter().fold(0.0f64, |a, &b| a.max(b));
        (1..side.len())
            .map(|i| 1.0 - side[i] / largest(&side[..i]).min(largest(&side[i..])).max(1e-12))
            .fold(0.0f64, f64::max)
    };
    let bands: Vec<f64> = series.iter().map(|(_, profile)| band(profile)).collect();
    one_fiber::show(context, &mut outcome, "A polar bear's fibre lit from behind", series)?;
    let claim = Claim::new(
        "Two indices make the edges of the medulla dark, where one does not",
        format!("a band darker by {:.0} %", 100.0 * bands[0]),
        bands[0],
        Verdict::of(bands[0] > 0.1 && bands[1..].iter().all(|b| *b < 0.2 * bands[0])),
    )
    .paper("dark edges with two, none with one")
    .ours("bound: 10 % with two, a fifth as deep with one")
    .more(format!("With one index {:.0} % (2015) and {:.0} % (ours).", 100.0 * bands[1], 100.0 * bands[2]));
    outcome.claims.push(claim);
    Ok(outcome)
}
