//! `vellus render`: a scene to a picture.

mod denoise;
mod frames;
mod goals;
mod identity;
mod input;
mod job;
mod keep;
mod merge;
mod parse;
mod tev;
mod write;

use crate::interrupt::Interrupt;
use crate::model_args::ModelArgs;
use crate::number::whole;
use crate::output;
use anyhow::{Context, Result, bail};
use parse::{Frames, Layers};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;
use tev::Viewer;
use vellus_render::{Filter, MAX_SAMPLES, Mode};

pub use input::{Input, is_built_in, load_usd};
pub use merge::{MergeArgs, merge};

/// The most threads. Many more than there are processors start slowly and render no faster.
fn max_threads() -> u64 {
    std::thread::available_parallelism().map_or(0, |n| 4 * n.get() as u64).max(256)
}

/// Path-trace a scene.
#[derive(clap::Args, Clone)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    #[command(flatten)]
    model: ModelArgs,
    /// Picture to write, OpenEXR with layers; a PNG to look at is written beside it. `.png` writes that alone.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "960x640", value_parser = parse::size, allow_hyphen_values = true, value_name = "WxH")]
    size: [usize; 2],
    /// Render only a part of the picture: left column, top row, width and height in pixels.
    #[arg(long, value_parser = parse::crop, allow_hyphen_values = true, value_name = "X,Y,W,H")]
    crop: Option<[usize; 4]>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64, value_parser = whole::<u64>(1..=MAX_SAMPLES), value_name = "N")]
    spp: u64,
    /// Stop after rendering for that long in this run, e.g. 60s, 5m, 2h.
    #[arg(long, value_parser = parse::duration, allow_hyphen_values = true, value_name = "TIME")]
    time: Option<Duration>,
    /// Stop when the picture's noise is estimated to be as low as that, e.g. 0.01: root mean square of the pixels' standard errors,
    /// over the mean brightness.
    #[arg(long, value_name = "X", value_parser = parse::noise, allow_hyphen_values = true)]
    noise: Option<f64>,
    /// Only samples A to B of each pixel, B excluded; writes a film for `vellus merge`.
    #[arg(long, value_parser = parse::range, allow_hyphen_values = true, value_name = "A..B", conflicts_with = "spp")]
    samples: Option<Range<u64>>,
    /// Each frame of a USD file's animation, from A to B, or every S-th: `fur.exr` becomes `fur.0001.exr` and so on. --time and --noise
    /// are for each; --resume leaves out those that are done.
    #[arg(long, value_parser = parse::frames, allow_hyphen_values = true, value_name = "A-B[xS]", conflicts_with_all = ["samples", "frame"])]
    frames: Option<Frames>,
    /// Over which part of a fibre's width its reflectance is averaged. Of the models, only ours knows all of them: the others are
    /// near or far whatever is said here.
    #[arg(long, value_enum, default_value_t = ModeArg::Multiscale)]
    mode: ModeArg,
    /// Which part of the picture a pixel's samples see.
    #[arg(long, value_enum, default_value_t = FilterArg::Tent)]
    filter: FilterArg,
    /// Cut paths after that many scattering events, and say how much light that cost. Without it only Russian roulette ends
    /// them.
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    max_depth: Option<u32>,
    /// Make strands at least that many pixels wide as the camera sees them, as the shutter opens and closes, for all rays. A bias: fur
    /// covers more, and its colour changes with that. 0.5 to 1 tames noise and flicker of single thin strands far away; dense fur becomes
    /// thicker, and no smoother. 0 is off.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse::pixels, value_name = "X")]
    min_pixel_width: f32,
    /// Another seed is another noise.
    #[arg(long, default_value_t = 0, value_parser = whole::<u32>(0..=u32::MAX.into()), value_name = "N")]
    seed: u32,
    /// Threads; without it as many as the processor has. At most four times that many, or 256. The picture is the same.
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=max_threads()))]
    threads: Option<usize>,
    /// Stops by which the PNG is brighter; the OpenEXR file is not changed by it.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse::exposure, value_name = "STOPS")]
    exposure: f32,
    /// Layers of the OpenEXR file, with commas between; `all` has `lights` too, one for each light or light group. Memory and
    /// checkpoints hold only these.
    #[arg(
        long,
        value_parser = parse::layers,
        default_value = "beauty,alpha,variance,fibers,lobes,albedo,normal,tangent,depth,uv,id",
        value_name = "LAYERS"
    )]
    layers: Layers,
    /// Denoise the beauty as well: layer `denoised`, which is what the PNG shows. Needs Intel Open Image Denoise 2, installed, or the
    /// path of its library in VELLUS_OIDN; guided by the layers albedo and normal.
    #[arg(long, conflicts_with = "samples")]
    denoise: bool,
    /// Store colours in 32 bit, not 16.
    #[arg(long)]
    float: bool,
    /// Go on from the checkpoint beside the output, if there is one of the same picture.
    #[arg(long)]
    resume: bool,
    /// Write a checkpoint that often: what is lost at most when the program is killed.
    #[arg(long, value_parser = parse::duration, allow_hyphen_values = true, default_value = "60s", value_name = "TIME")]
    checkpoint: Duration,
    /// Show the picture as it is rendered, in the viewer tev, which must be running there (port 14158 without one).
    #[arg(long, value_name = "HOST[:PORT]")]
    tev: Option<String>,
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

/// [`Filter`] on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FilterArg {
    /// The pixel itself: sharper, a little less noise, and what denoisers expect.
    Box,
    /// Two pixels across, most at the middle: smoother edges.
    Tent,
}

/// Runs it.
pub fn run(args: &Args) -> Result<()> {
    if let Some([x, y, w, h]) = args.crop
        && (x.saturating_add(w) > args.size[0] || y.saturating_add(h) > args.size[1])
    {
        bail!("--crop {x},{y},{w},{h} is not within the picture's {}x{}", args.size[0], args.size[1]);
    }
    let mut input = args.input.clone();
    if let Some(frames) = args.frames {
        input.set_frame(f64::from(frames.first));
    }
    input.check()?;
    args.model.check()?;
    if args.denoise {
        denoise::Denoiser::load()?;
    }
    write::check_name(&args.output)?;
    output::writable(&args.output)?;
    let viewer = args.tev.as_deref().map(Viewer::connect).transpose()?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads);
    }
    let pool = pool.build().context("cannot start threads")?;
    let interrupt = Interrupt::watch()?;
    pool.install(|| frames::run(args, &interrupt, viewer))
}

impl From<FilterArg> for Filter {
    fn from(filter: FilterArg) -> Filter {
        match filter {
            FilterArg::Box => Filter::Box,
            FilterArg::Tent => Filter::Tent,
        }
    }
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
