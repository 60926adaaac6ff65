//! `vellus render`: a scene becomes a picture.

mod frames;
mod input;
mod job;
mod keep;
mod merge;
mod notes;
mod parse;

use crate::interrupt::Interrupt;
use crate::model_args::ModelArgs;
use crate::number::whole;
use crate::output;
use anyhow::{Context, Result, bail};
use job::Live;
use parse::{Frames, Layers};
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;
use vellus_render::denoise::Denoiser;
use vellus_render::{Filter, MAX_SAMPLES, Mode};

pub use input::{Input, is_built_in, load_usd};
pub use merge::{MergeArgs, merge};

/// The largest number of threads. Many more than there are processors start slowly and render no faster.
fn max_threads() -> u64 {
    std::thread::available_parallelism().map_or(0, |n| 4 * n.get() as u64).max(256)
}

/// Path-trace a scene.
#[derive(clap::Args, Clone)]
pub struct Args {
    /// Write a PNG after the first pass.
    #[arg(skip)]
    pub preview: bool,
    #[command(flatten)]
    input: Input,
    #[command(flatten)]
    model: ModelArgs,
    /// Picture to write: OpenEXR with layers, and a PNG preview beside it. With the extension `.png`, only the PNG is written.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "960x640", value_parser = parse::size, allow_hyphen_values = true, value_name = "WxH")]
    size: [usize; 2],
    /// Render only a part of the picture: left column, top row, width and height, in pixels.
    #[arg(long, value_parser = parse::crop, allow_hyphen_values = true, value_name = "X,Y,W,H")]
    crop: Option<[usize; 4]>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64, value_parser = whole::<u64>(1..=MAX_SAMPLES), value_name = "N")]
    spp: u64,
    /// Stop after rendering this long, e.g. 60s, 5m, 2h.
    #[arg(long, value_parser = parse::duration, allow_hyphen_values = true, value_name = "TIME")]
    time: Option<Duration>,
    /// Stop when the estimated noise of the picture is this low, e.g. 0.01: the root mean square of the pixels' standard
    /// errors, divided by the mean brightness.
    #[arg(long, value_name = "X", value_parser = parse::noise, allow_hyphen_values = true)]
    noise: Option<f64>,
    /// Render only samples A to B of each pixel, B excluded, and write a film for `vellus merge`.
    #[arg(long, value_parser = parse::range, allow_hyphen_values = true, value_name = "A..B", conflicts_with = "spp")]
    samples: Option<Range<u64>>,
    /// Render the frames A to B of a USD file's animation, or every S-th of them: `fur.exr` becomes `fur.0001.exr` and so
    /// on. --time and --noise apply to each frame; --resume skips finished frames.
    #[arg(
        long,
        value_parser = parse::frames,
        allow_hyphen_values = true,
        value_name = "A-B[xS]",
        conflicts_with_all = ["samples", "frame"]
    )]
    frames: Option<Frames>,
    /// Over which part of a fibre's width its reflectance is averaged. Only the model `vellus` knows all three; the other
    /// models are near or far field models, and ignore this option.
    #[arg(long, value_enum, default_value_t = ModeArg::Multiscale)]
    mode: ModeArg,
    /// Pixel filter.
    #[arg(long, value_enum, default_value_t = FilterArg::Tent)]
    filter: FilterArg,
    /// Cut paths after this many scattering events, and report how much light that costs. Without it, only Russian
    /// roulette ends paths.
    #[arg(long, value_name = "N", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    max_depth: Option<u32>,
    /// Make strands at least this many pixels wide, as the camera sees them when the shutter opens and closes. This biases
    /// coverage and colour: fur looks denser. 0.5 to 1 reduces noise and flicker of single thin strands far away; dense
    /// fur becomes thicker without becoming smoother. 0 is off.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse::pixels, value_name = "X")]
    min_pixel_width: f32,
    /// Seed of the random numbers: another seed gives another noise.
    #[arg(long, default_value_t = 0, value_parser = whole::<u32>(0..=u32::MAX.into()), value_name = "N")]
    seed: u32,
    /// Number of threads [default: as many as the processor has]. At most four times that number, or 256. It does not
    /// change the picture.
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=max_threads()))]
    threads: Option<usize>,
    /// Make the PNG brighter by this many stops. The OpenEXR file does not change.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse::exposure, value_name = "STOPS")]
    exposure: f32,
    /// Layers of the OpenEXR file, separated by commas. `all` adds `motion` and `lights`, one layer for each light or light
    /// group. Fewer layers make checkpoints smaller and use less memory.
    #[arg(
        long,
        value_parser = parse::layers,
        default_value = "beauty,alpha,variance,fibers,lobes,albedo,normal,tangent,depth,uv,id",
        value_name = "LAYERS"
    )]
    layers: Layers,
    /// Also write the denoised beauty: as the layer `denoised`, and as the PNG. This needs Intel Open Image Denoise 2:
    /// install it, or set VELLUS_OIDN to the path of its library. The layers albedo and normal guide it.
    #[arg(long, conflicts_with = "samples")]
    denoise: bool,
    /// Store colours in 32 bits instead of 16.
    #[arg(long)]
    float: bool,
    /// Continue from the checkpoint beside the output, if there is one of the same picture.
    #[arg(long)]
    resume: bool,
    /// Write a checkpoint this often. At most this much work is lost if the program is killed.
    #[arg(long, value_parser = parse::duration, allow_hyphen_values = true, default_value = "60s", value_name = "TIME")]
    checkpoint: Duration,
    /// Show the picture while it is rendered, in the viewer tev, which must be running at this address [default port: 14158].
    #[arg(long, value_name = "HOST[:PORT]")]
    tev: Option<String>,
}

/// [`Mode`] on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum ModeArg {
    /// The part that the pixel sees: near field, far field, and everything between.
    Multiscale,
    /// The offset at which the fibre is hit.
    Near,
    /// Always the whole width.
    Far,
}

/// [`Filter`] on the command line.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FilterArg {
    /// One pixel wide, constant: sharper, a little less noise, and what denoisers expect.
    Box,
    /// Two pixels wide, with its peak in the middle: smoother edges.
    Tent,
}

/// Checks the options, and renders.
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
        Denoiser::load()?;
    }
    // Before files are written: a signal would leave temporary ones.
    let interrupt = Interrupt::watch()?;
    output::check_extension(&args.output, &["exr", "png"])?;
    output::writable(&args.output)?;
    let viewer = args.tev.as_deref().map(Live::connect).transpose()?;
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads);
    }
    let pool = pool.build().context("cannot start threads")?;
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
