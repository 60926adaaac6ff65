//! Time of a query of each model, and of the model of 2015 as a baseline: optimised, and as published (Yan17 Sec. 7).

use crate::context::Context;
use crate::shot::profiles;
use crate::{Claim, Outcome, Table, Verdict};
use anyhow::Result;
use glam::Vec3;
use std::hint::black_box;
use std::time::Instant;
use vellus::{Bcsdf, Fiber, Model, Sample, Scattering, Species, Window};
use vellus_models::{Chiang2016, DEon2011, KajiyaKay1989, Marschner2003, Yan2015, ZinkeWeber2007};
use vellus_plot::bars::Bars;

/// Different queries, so that the processor cannot predict branches.
const QUERIES: usize = 1024;
/// Light samples evaluated per prepared hit.
const EACH: usize = 16;

/// The timed operations.
const OPERATIONS: [&str; 3] = ["prepare, evaluate, pdf", "evaluate, pdf (prepared)", "prepare, sample"];

struct Query {
    wo: Vec3,
    wi: Vec3,
    h: f32,
    u: [f32; 5],
}

fn queries() -> Vec<Query> {
    // An R-sequence (Roberts): even coverage without a random generator.
    let unit = |i: usize, k: i32| ((i as f64 + 0.5) * 1.103_0f64.powi(-k)).fract() as f32;
    let direction = |a: f32, b: f32| {
        let (sin, cos) = ((2.0 * a - 1.0) * 1.5).sin_cos();
        let (z, y) = (b * std::f32::consts::TAU).sin_cos();
        Vec3::new(sin, cos * y, cos * z)
    };
    (0..QUERIES)
        .map(|i| Query {
            wo: direction(unit(i, 1), unit(i, 2)),
            wi: direction(unit(i, 3), unit(i, 4)),
            h: 2.0 * unit(i, 5) - 1.0,
            u: [6, 7, 8, 9, 10].map(|k| unit(i, k)),
        })
        .collect()
}

/// Nanoseconds per query of each operation, for one pass through all queries.
type Timer<'a> = Box<dyn Fn() -> [f64; 3] + 'a>;

fn timer<'a, M: Model>(model: &'a M, queries: &'a [Query], window: fn(f32) -> Window) -> Timer<'a> {
    let each = move |f: &dyn Fn() -> f32| {
        let start = Instant::now();
        black_box(f());
        start.elapsed().as_nanos() as f64 / queries.len() as f64
    };
    Box::new(move || {
        let at = |q: &Query| model.at(q.wo, window(q.h));
        let asked = |hit: &M::Hit<'_>, q: &Query| {
            let (f, pdf) = hit.eval_pdf(q.wi);
            f.total()[0] + pdf
        };
        let hits: Vec<_> = queries.iter().step_by(EACH).map(at).collect();
        [
            each(&|| queries.iter().map(|q| asked(&at(black_box(q)), q)).sum()),
            each(&|| {
                hits.iter()
                    .zip(queries.chunks(EACH))
                    .flat_map(|(hit, c)| c.iter().map(move |q| (hit, q)))
                    .map(|(hit, q)| asked(hit, black_box(q)))
                    .sum()
            }),
            each(&|| {
                let weight = |s: Option<Sample>| s.map_or(0.0, |s| s.weight[0] + s.pdf);
                queries.iter().map(|q| weight(at(black_box(q)).sample(q.u))).sum()
            }),
        ]
    })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let mut outcome = Outcome::new(
        "The near field is evaluated twice as fast as Yan et al. 2015, whose paths are traced (frames of the hair \
         lock, Fig. 15b). Far field and multi-scale, which integrate, are slower than the near field and still \
         faster than 2015.",
    );
    let fiber = Fiber::preset(Species::RedFox).with_absorption([0.2, 0.4, 0.8]);
    let (ours, yan, split) = (Bcsdf::new(&fiber)?, Yan2015::new(&fiber)?, Yan2015::with_eta_m(&fiber, 1.3)?);
    let [published, published_split] =
        [&yan, &split].map(|model| model.clone().as_published(profiles(context.quality)));
    let (chiang, zinke, deon) = (Chiang2016::new(&fiber)?, ZinkeWeber2007::new(&fiber)?, DEon2011::new(&fiber)?);
    let (marschner, kajiya) = (Marschner2003::new(&fiber)?, KajiyaKay1989::new(&fiber)?);
    let queries = queries();
    let queries = queries.as_slice();
    let near = Window::near as fn(f32) -> Window;
    let timers: [(&str, Timer); 12] = [
        ("vellus, near", timer(&ours, queries, near)),
        ("vellus, a tenth of the width", timer(&ours, queries, |h| Window::pixel(h, 0.2))),
        ("vellus, far", timer(&ours, queries, |_| Window::far())),
        ("yan2015, η_m = η_c", timer(&yan, queries, near)),
        ("yan2015, η_m = 1.3", timer(&split, queries, near)),
        ("yan2015 as published, η_m = η_c", timer(&published, queries, near)),
        ("yan2015 as published, η_m = 1.3", timer(&published_split, queries, near)),
        ("chiang2016", timer(&chiang, queries, near)),
        ("zinke-weber2007", timer(&zinke, queries, near)),
        ("deon2011 (far)", timer(&deon, queries, near)),
        ("marschner2003 (far)", timer(&marschner, queries, near)),
        ("kajiya-kay1989 (far)", timer(&kajiya, queries, near)),
    ];
    let rounds = context.quality.pick(3, 301, 3001);
    let mut times = vec![[const { Vec::new() }; 3]; timers.len()];
    let stage = context.stage(rounds, "timing");
    for round in 0..rounds {
        context.check_interrupted()?;
        // The models alternate, so that other load of the machine affects all of them. The first round only warms up.
        for ((_, timer), times) in timers.iter().zip(&mut times) {
            let all = timer();
            if round > 0 {
                times.iter_mut().zip(all).for_each(|(times, ns)| times.push(ns));
            }
        }
        stage.advance(1);
    }
    let medians: Vec<[f64; 3]> = times.into_iter().map(|t| t.map(median)).collect();
    let header = ["model", OPERATIONS[0], OPERATIONS[1], OPERATIONS[2], "relative to ours, near"];
    let caption = format!(
        "Nanoseconds per query, six lobes in RGB: medians of {} rounds of {QUERIES} queries; models alternate; one \
         thread",
        rounds - 1
    );
    let mut table = Table::new("queries", caption, &header);
    for ((name, _), ns) in timers.iter().zip(&medians) {
        let ratio = format!("{:.2}", ns[0] / medians[0][0]);
        table.row(std::iter::once((*name).to_owned()).chain(ns.map(|x| format!("{x:.0}"))).chain([ratio]));
    }
    outcome.tables.push(table);
    let bars = Bars {
        title: "Nanoseconds per query, one thread".to_owned(),
        unit: "nanoseconds".to_owned(),
        groups: OPERATIONS.map(str::to_owned).to_vec(),
        // The legend has room for six names.
        series: [0, 1, 2, 3, 5, 7].map(|k| (timers[k].0.to_owned(), medians[k].to_vec())).to_vec(),
        digits: Some(0),
    };
    outcome.pictures.push(context.draw(
        &bars,
        "queries",
        "Time of a query: near fields at one offset, ours also over windows.",
    )?);
    claims(&mut outcome, &medians);
    outcome.notes.push(
        "How we optimised the model of 2015. Its paths are in closed form; they are not traced. The scattered \
         profiles come from our compressed tables, and are prepared once per hit for all three passes. Sampling is \
         exact except for one Fresnel factor; the sampling of 2015 is uniform around the fibre. As published, each \
         path is traced from the offset through both circles, and scattered light comes from four tables of 189 MB, \
         each number interpolated between sixteen. The rest is the same for both: single precision, the eight \
         unscattered lobes in one register of eight lanes, paths traced once per hit, and no memory allocated. The \
         program of the paper is not published. Times are those of this program as compiled; cargo bench reports \
         lower ones, because it links everything as one unit."
            .to_owned(),
    );
    Ok(outcome)
}

fn claims(outcome: &mut Outcome, ns: &[[f64; 3]]) {
    let mut claim = |what: &str, [paper, ours]: [&str; 2], ratio: f64, verdict: Verdict, why: &str| {
        let measured = format!("{ratio:.2} × our near field's time");
        let claim = if cfg!(debug_assertions) {
            Claim::not_judged(what, measured, "This build has debug assertions.")
        } else {
            Claim::new(what, measured, ratio, verdict).because(why)
        };
        outcome.claims.push(claim.paper(paper).ours(ours));
    };
    let [one, split] = [3, 4].map(|k| ns[k][0] / ns[0][0]);
    claim(
        "A query of the model of 2015 takes longer than one of our near field",
        ["frames: 2 ×", "bound: 1 ×"],
        one,
        Verdict::of(one > 1.0),
        "Prepare, evaluate and pdf, with one refractive index. Half of its lobes are dark then, but are computed.",
    );
    claim(
        "Our baseline of 2015 is well optimised",
        ["frames: 2 ×, including rays, so more for queries", "at most 2.2 ×"],
        split,
        Verdict::of(split <= 2.2),
        "With two refractive indices, where all lobes carry light. The bound is 2 and a tenth, for the error of \
         timing.",
    );
    let [published, published_split] = [5, 6].map(|k| ns[k][0]);
    claim(
        "A query of the model of 2015 as published takes twice as long as one of our near field",
        ["frames: 2 ×, including rays, so more for queries", "bound: 2 ×"],
        published / ns[0][0],
        Verdict::of(published >= 2.0 * ns[0][0]),
        &format!(
            "With one refractive index. With two, {:.2} ×. It takes {:.2} × the time of our optimised version, and \
             {:.2} × that of our far field.",
            published_split / ns[0][0],
            published / ns[3][0],
            published / ns[2][0]
        ),
    );
    let far = ns[2][0] / ns[3][0];
    let claim = Claim::not_judged(
        "A query of our far field is still faster than one of the model of 2015",
        format!("{far:.2} × that time"),
        "The paper times frames, where only the hits that the camera sees use a window; see the frame times. This is \
         the time of a query alone.",
    );
    outcome.claims.push(claim.paper("frames: faster (Fig. 15b)"));
}
