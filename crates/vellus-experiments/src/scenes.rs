//! Yan17 Table 5: sizes of the scenes.

use crate::context::Context;
use crate::{Claim, Outcome, Quality, Table, Verdict};
use anyhow::{Context as _, Result};
use vellus_groom::{bytes, measure, scene};
use vellus_render::World;

/// Scene, the paper's figure, number of strands, segments per strand.
#[doc(alias = "Table 5")]
const TABLE_5: [(&str, &str, usize, usize); 5] = [
    ("hair-lock", "8", 1_000, 210),
    ("raccoon", "1", 260_000, 22),
    ("hamster", "16", 580_000, 15),
    ("cat", "17", 267_000, 9),
    ("hair", "18", 53_000, 64),
];

/// A small scene has one of this number of strands. The lock always has all strands.
const SHARE: usize = 40;

pub fn run(context: &Context<'_>) -> Result<Outcome> {
    let mut outcome = Outcome::new(
        "Table 5 lists five scenes of 1,000 to 580,000 strands with 9 to 210 line segments each. It does not state \
         their memory. The models were not published: code builds ours, with the strand counts of the paper but \
         other looks.",
    );
    let whole = context.quality == Quality::Paper;
    let header = [
        "scene",
        "Fig.",
        "paper: strands",
        "segments",
        "here: strands",
        "segments",
        "segments in all",
        "strands, MB",
        "with hierarchy, MB",
        "bytes per segment",
        "median length, cm",
        "widths, µm",
    ];
    let mut table = Table::new(
        "scenes",
        "The scenes as built here. × marks a small scene with wider strands; its numbers are scaled up",
        &header,
    );
    let (mut worst, mut per_segment) = (Vec::new(), 0.0f64);
    let built: &[_] = context.quality.pick(&[TABLE_5[0], TABLE_5[4]], &TABLE_5, &TABLE_5);
    let stage = context.stage(built.len() as u64, "building scenes");
    for &(name, figure, strands, segments) in built {
        context.check_interrupted()?;
        let scale = if whole || name == "hair-lock" { 1 } else { SHARE };
        let scene = scene(name, scale > 1).with_context(|| format!("there is no scene {name}"))?;
        let fur = scene.strands.first().with_context(|| format!("{name} has no strands"))?;
        let (count, all) = (fur.len(), fur.segments());
        let measures = measure(fur).with_context(|| format!("{name} has no strands"))?;
        let memory = scene.strands.iter().map(bytes).sum::<usize>();
        let world = World::new(scene)?;
        let with_hierarchy = world.curves().bytes() as f64 / world.curves().segments() as f64;
        per_segment = per_segment.max(with_hierarchy);
        if count * scale != strands || all != count * segments {
            worst.push(format!("{name}: {} strands of {} segments", count * scale, all / count));
        }
        let megabytes = |bytes: f64| format!("{:.1}", 1e-6 * bytes * scale as f64);
        let strands_here = if scale > 1 { format!("{count} × {scale}") } else { count.to_string() };
        let [thin, thick] = measures.widths.map(|w| 1e4 * w);
        table.row([
            name.to_owned(),
            figure.to_owned(),
            strands.to_string(),
            segments.to_string(),
            strands_here,
            (all / count).to_string(),
            (all * scale).to_string(),
            megabytes(memory as f64),
            megabytes(world.curves().bytes() as f64),
            format!("{with_hierarchy:.0}"),
            format!("{:.2}", measures.lengths[1]),
            format!("{thin:.0} to {thick:.0}"),
        ]);
        stage.advance(1);
    }
    outcome.tables.push(table);
    let what = "Our scenes have as many strands and segments as those of the paper";
    let measured = format!("{} scenes differ", worst.len());
    let mut counts = Claim::new(what, measured, worst.len() as f64, Verdict::of(worst.is_empty()))
        .paper("the numbers of Table 5")
        .more(worst.join("; "));
    if !whole {
        counts = counts
            .because("Counted in small scenes and multiplied by 40; at paper quality, counted in the full scenes.");
    }
    outcome.claims.push(counts);
    let (what, why) = ("Strands and their hierarchy need little memory", "The paper does not report its memory.");
    outcome.claims.push(Claim::not_judged(what, format!("{per_segment:.0} bytes per segment at most"), why));
    Ok(outcome)
}
