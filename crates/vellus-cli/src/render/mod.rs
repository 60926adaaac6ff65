//! `vellus render`: a scene to a picture.

mod input;
mod job;

use crate::output;
use anyhow::{Context, Result, bail};
use job::Job;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;
use vellus_render::{Depth, Layer, Mode, Part};

pub use input::Input;

/// Path-trace a scene.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    /// Picture to write, OpenEXR with all layers; a PNG to look at is written beside it. `.png` writes that alone.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "960x640", value_parser = size, value_name = "WxH")]
    size: [usize; 2],
    /// Render only a part of the picture: left column, top row, width and height in pixels.
    #[arg(long, value_parser = crop, value_name = "X,Y,W,H")]
    crop: Option<[usize; 4]>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u64).range(1..=1 << 32), value_name = "N")]
    spp: u64,
    /// Stop after that long, e.g. 60s, 5m, 2h.
    #[arg(long, value_parser = duration, value_name = "TIME")]
    time: Option<Duration>,
    /// Stop when the picture's noise, relative to its mean brightness, is estimated to be as low as that, e.g. 0.01.
    #[arg(long, value_name = "X")]
    noise: Option<f64>,
    /// Only samples A to B of each pixel, B excluded; writes a film for `vellus merge`.
    #[arg(long, value_parser = range, value_name = "A..B", conflicts_with_all = ["spp", "resume"])]
    samples: Option<Range<u64>>,
    /// Over which part of a fibre's width its reflectance is averaged.
    #[arg(long, value_enum, default_value_t = ModeArg::Multiscale)]
    mode: ModeArg,
    /// Cut paths after that many scattering events, and say how much light that cost. Without it only Russian roulette ends
    /// them.
    #[arg(long, value_name = "N")]
    max_depth: Option<u32>,
    /// Another seed is another noise.
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// Threads; all there are without it. The picture is the same.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Stops by which the PNG is brighter; the OpenEXR file is not changed by it.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_name = "STOPS")]
    exposure: f32,
    /// Layers of the OpenEXR file, with commas between: beauty, alpha, variance, lobes, albedo, normal, tangent, depth.
    #[arg(long, value_delimiter = ',', value_parser = layer, value_name = "LAYERS")]
    layers: Vec<Layer>,
    /// Store colours in 32 bit, not 16.
    #[arg(long)]
    float: bool,
    /// Go on from the checkpoint beside the output, if there is one of the same picture.
    #[arg(long)]
    resume: bool,
}

/// [`Mode`] on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum ModeArg {
    /// What each pixel sees of it: near and far field, and all between.
    Multiscale,
    /// Where it is hit.
    Near,
    /// The whole width, always.
    Far,
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let parse = || {
        let (w, h) = text.split_once('x')?;
        Some([w.parse().ok()?, h.parse().ok()?])
    };
    match parse() {
        Some(size) if size.iter().all(|n| (1..=32_768).contains(n)) => Ok(size),
        _ => Err("a size is WIDTHxHEIGHT, each in [1, 32768]".to_owned()),
    }
}

fn crop(text: &str) -> Result<[usize; 4], String> {
    let numbers: Vec<usize> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, w, h] if w > 0 && h > 0 && text.split(',').count() == 4 => Ok([x, y, w, h]),
        _ => Err("a crop is X,Y,W,H in pixels, W and H at least 1".to_owned()),
    }
}

fn range(text: &str) -> Result<Range<u64>, String> {
    let parse = || {
        let (a, b) = text.split_once("..")?;
        Some(a.parse().ok()?..b.parse().ok()?)
    };
    match parse() {
        Some(range) if range.start < range.end => Ok(range),
        _ => Err("samples are A..B with A < B".to_owned()),
    }
}

fn duration(text: &str) -> Result<Duration, String> {
    let split = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let unit = match &text[split..] {
        "s" | "" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => f64::NAN,
    };
    let seconds = text[..split].parse().unwrap_or(f64::NAN) * unit;
    if (0.0..1e9).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("a time is e.g. 60s, 5m or 2h".to_owned())
    }
}

fn layer(text: &str) -> Result<Layer, String> {
    let known = ["beauty", "alpha", "variance", "lobes", "albedo", "normal", "tangent", "depth"];
    let i = known.iter().position(|name| *name == text);
    i.map(|i| Layer::ALL[i]).ok_or(format!("unknown layer (known: {})", known.join(", ")))
}

/// Runs it.
pub fn run(args: &Args) -> Result<()> {
    if args.noise.is_some_and(|x| !(x > 0.0 && x.is_finite())) {
        bail!("--noise must be above 0");
    }
    if let Some([x, y, w, h]) = args.crop
        && (x.saturating_add(w) > args.size[0] || y.saturating_add(h) > args.size[1])
    {
        bail!("--crop {x},{y},{w},{h} is not within the picture's {}x{}", args.size[0], args.size[1]);
    }
    if args.threads == Some(0) {
        bail!("--threads must be 1 or more");
    }
    let extension = args.output.extension().and_then(|e| e.to_str()).unwrap_or("");
    if !matches!(extension, "exr" | "png") {
        bail!("{}: the name must end in .exr or .png", args.output.display());
    }
    output::writable(&args.output)?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads);
    }
    let pool = pool.build().context("cannot start threads")?;
    pool.install(|| Job::new(args)?.run())
}

/// Put together what `vellus render --samples` rendered apart: the very picture of one run.
#[derive(clap::Args)]
pub struct MergeArgs {
    /// Films written by `vellus render --samples`.
    #[arg(required = true, value_name = "FILM")]
    films: Vec<PathBuf>,
    /// Picture to write.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    /// Stops by which the PNG is brighter.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_name = "STOPS")]
    exposure: f32,
    /// Store colours in 32 bit, not 16.
    #[arg(long)]
    float: bool,
}

/// Merges.
pub fn merge(args: &MergeArgs) -> Result<()> {
    let mut parts = Vec::new();
    for path in &args.films {
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let part = Part::from_bytes(&bytes).map_err(|e| anyhow::anyhow!("{}: {e}", path.display()))?;
        parts.push((path, part));
    }
    parts.sort_by_key(|(_, part)| part.samples.start);
    for pair in parts.windows(2) {
        let ((a_path, a), (b_path, b)) = (&pair[0], &pair[1]);
        let size = |part: &Part| (part.film.width(), part.film.height());
        if a.fingerprint != b.fingerprint || size(a) != size(b) {
            bail!("{} and {} are not of the same picture", a_path.display(), b_path.display());
        }
        if b.samples.start < a.samples.end {
            bail!("{} and {} have samples in common", a_path.display(), b_path.display());
        }
    }
    let mut parts = parts.into_iter().map(|(_, part)| part.film);
    let Some(mut film) = parts.next() else { bail!("no films") };
    parts.for_each(|part| film.merge(&part));
    let depth = if args.float { Depth::Float } else { Depth::Half };
    job::write_picture(&film, &args.output, &Layer::ALL, depth, args.exposure, &[])
}

impl From<ModeArg> for Mode {
    fn from(mode: ModeArg) -> Mode {
        match mode {
            ModeArg::Multiscale => Mode::MultiScale,
            ModeArg::Near => Mode::Near,
            ModeArg::Far => Mode::Far,
        }
    }
}
