//! `vellus render`: a scene becomes a picture.

mod display;
mod frames;
mod input;
mod job;
mod merge;
mod screen;

use crate::interrupt::Interrupt;
use crate::model_args::ModelArgs;
use crate::number::one_of;
use crate::output;
use anyhow::{Context, Result, bail};
use display::DisplayArgs;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use vellus_gpu::Choice;
use vellus_io::{Digest, parse};
use vellus_open::{BUILT_IN_SIZE, Format, Staging};
use vellus_render::denoise::Denoiser;
use vellus_render::session::Frames;
use vellus_render::{Filter, Layer, Lod, MAX_SAMPLES, Mode};

pub use input::{Input, explain, warn};
pub use merge::{MergeArgs, merge};

/// A list of layers. The name keeps the parser from reading one layer for each argument.
type Layers = Vec<Layer>;

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
    staging: Staging,
    #[command(flatten)]
    model: ModelArgs,
    /// Picture to write: OpenEXR with layers, and a PNG beside it. With the extension `.png`, only the PNG is written.
    /// `####` and `%04d` become the number of the frame.
    #[arg(short, long, default_value = "out/render.exr", value_name = "FILE")]
    output: PathBuf,
    /// Width and height in pixels [default: the resolution of the file's RenderSettings, or 960 for the longer side of
    /// the camera's film].
    #[arg(long, value_parser = parse::size, allow_hyphen_values = true, value_name = "WxH")]
    size: Option<[usize; 2]>,
    /// Render only a part of the picture: left column, top row, width and height, in pixels [default: the data window
    /// of the file's RenderSettings].
    #[arg(long, value_parser = parse::crop, allow_hyphen_values = true, value_name = "X,Y,W,H")]
    crop: Option<[usize; 4]>,
    /// Samples a pixel.
    #[arg(long, default_value_t = 64, value_parser = parse::whole::<u64>(1..=MAX_SAMPLES), value_name = "N")]
    spp: u64,
    /// Stop after rendering this long, e.g. 60s, 5m, 2h.
    #[arg(long, value_parser = parse::duration, allow_hyphen_values = true, value_name = "TIME")]
    time: Option<Duration>,
    /// Stop when the estimated noise is this low, e.g. 0.01: the root mean square of the pixels' standard errors,
    /// divided by the mean brightness. Noisy parts of the picture get more samples (--device cpu only).
    #[arg(long, value_name = "X", value_parser = parse::positive::<f64>, allow_hyphen_values = true)]
    noise: Option<f64>,
    /// Render only samples A to B of each pixel, B excluded, and write a film for `vellus merge`.
    #[arg(long, value_parser = parse::samples(MAX_SAMPLES), allow_hyphen_values = true)]
    #[arg(value_name = "A..B", conflicts_with = "spp")]
    samples: Option<Range<u64>>,
    /// Render the frames A to B of a file, or every S-th of them: `fur.exr` becomes `fur.0001.exr` and so on, and
    /// `fur_##.exr` becomes `fur_01.exr`. --time and --noise apply to each frame. --resume skips finished frames.
    #[arg(long, allow_hyphen_values = true, value_name = "A-B[xS]", conflicts_with_all = ["samples", "frame"])]
    frames: Option<Frames>,
    /// What renders: the processor, a GPU, or a GPU if there is one that can render the scene (auto). The picture is
    /// the same within its noise.
    #[arg(long, value_parser = one_of::<Choice>(Choice::ALL.map(Choice::name)), default_value = "cpu")]
    device: Choice,
    /// Over which part of a fibre's width its reflectance is averaged: what the pixel sees (multiscale), the point
    /// that is hit (near), or the whole width (far). Only the model `vellus` uses this option.
    #[arg(long, value_parser = one_of::<Mode>(Mode::ALL.map(Mode::name)), default_value = "multiscale")]
    mode: Mode,
    /// Pixel filter: a box is one pixel wide and suits denoisers. A tent is two pixels wide and makes smoother edges.
    #[arg(long, value_parser = one_of::<Filter>(Filter::ALL.map(Filter::name)), default_value = "tent")]
    filter: Filter,
    /// Cut paths after this many scattering events, and report how much light that costs [default: no limit].
    #[arg(long, value_name = "N", value_parser = parse::whole::<u32>(0..=u32::MAX.into()))]
    max_depth: Option<u32>,
    /// Limit the radiance that one scattering event after the first may add to a sample. Removes fireflies, darkens
    /// the picture, and reports by how much. Start with the brightness of white fur in the picture [default: no limit].
    #[arg(long, value_name = "RADIANCE", allow_hyphen_values = true, value_parser = parse::radiance)]
    clamp_indirect: Option<f32>,
    /// End paths at their second hit, and take indirect light from a cache that N samples of each pixel fill before. It
    /// grows to an eighth of the samples. Faster and less noise, with a small error that falls with the samples; 16
    /// suits most pictures. The frames of a USD shot in which only the camera moves share it [default: paths are traced
    /// to their ends].
    #[arg(long, value_name = "N", value_parser = parse::whole::<u32>(1..=65536))]
    radiance_cache: Option<u32>,
    /// Make strands at least this many pixels wide. 0.5 to 1 reduces noise and flicker of thin strands far away, but
    /// dense fur looks denser. 0 is off.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse::pixels, value_name = "X")]
    min_pixel_width: f32,
    /// Level of detail. Keep fewer and wider strands where they are thinner than an eighth of a pixel and a hundredth
    /// of their length (auto). A number N multiplies both limits by 2^N. Saves memory, with a small error.
    #[arg(long, default_value_t = Lod::Off, allow_hyphen_values = true, value_name = "auto|off|BIAS")]
    lod: Lod,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 0, value_parser = parse::whole::<u32>(0..=u32::MAX.into()), value_name = "N")]
    seed: u32,
    /// Number of threads [default: that of the processor]. It does not change the picture.
    #[arg(long, value_name = "N", value_parser = parse::whole::<usize>(1..=max_threads()))]
    threads: Option<usize>,
    #[command(flatten)]
    display: DisplayArgs,
    /// Layers of the OpenEXR file, separated by commas. `all` adds `motion`, `lights` and `crypto-*`.
    #[arg(long, value_parser = Layer::list, value_name = "LAYERS")]
    #[arg(default_value = "beauty,alpha,variance,fibers,lobes,albedo,normal,tangent,depth,uv,id")]
    layers: Layers,
    /// Also write the denoised beauty: as the layer `denoised`, and as the PNG. The lobes and lights of --layers become
    /// layers such as `denoised_light_key`, and add up to it. This needs Intel Open Image Denoise 2: `pip install
    /// pyoidn` installs it. Or set VELLUS_OIDN to the path of its library. The layers albedo and normal guide it.
    #[arg(long, conflicts_with = "samples")]
    denoise: bool,
    /// Store colours in 32 bits instead of 16.
    #[arg(long)]
    float: bool,
    /// Continue from the checkpoint beside the output, if there is one of the same picture.
    #[arg(long)]
    resume: bool,
    /// Write a checkpoint this often [default: 60s]. With this option or --resume, it stays if --time or --noise ends
    /// the run, so that a later run can continue. Otherwise a finished picture has none.
    #[arg(long, value_parser = parse::duration, allow_hyphen_values = true, value_name = "TIME")]
    checkpoint: Option<Duration>,
    /// Show the picture while it is rendered, in the viewer tev at this address [default port: 14158].
    #[arg(long, value_name = "HOST[:PORT]")]
    tev: Option<String>,
}

/// Checks that a part is within the picture.
fn check_crop(size: [usize; 2], crop: Option<[usize; 4]>) -> Result<()> {
    match crop {
        Some([x, y, w, h]) if x.saturating_add(w) > size[0] || y.saturating_add(h) > size[1] => {
            bail!("--crop {x},{y},{w},{h} is not within the picture's {}x{}", size[0], size[1])
        }
        _ => Ok(()),
    }
}

/// Checks the options that can be checked without reading the scene.
fn check(args: &Args) -> Result<()> {
    let built_in = matches!(Format::of(&args.input.scene), Ok(Format::BuiltIn(_)));
    let size = args.size.or(built_in.then_some(BUILT_IN_SIZE));
    size.map_or(Ok(()), |size| check_crop(size, args.crop))?;
    let mut input = args.input.clone();
    if let Some(frames) = args.frames {
        input.frame = Some(f64::from(frames.first()));
    }
    input.options(Some(args.staging()))?;
    args.model.check()?;
    if args.denoise {
        Denoiser::load()?;
    }
    frames::single(args)?;
    output::check_extension(&args.output, &["exr", "png"])
}

/// The identity of the picture with these options: films with the same one can be merged.
pub fn identity(args: &Args) -> Result<Digest> {
    check(args)?;
    Ok(job::Loaded::new(args, Arc::default())?.identity)
}

/// Checks the options, and renders.
pub fn run(args: &Args) -> Result<()> {
    check(args)?;
    args.device.check().map_err(job::on_cpu)?;
    // Before files are written: a signal would leave temporary ones.
    let interrupt = Interrupt::watch()?;
    output::writable(&args.output)?;
    let viewer = args.tev.as_deref().map(screen::connect).transpose()?;
    // 0 is as many threads as the processor has.
    let threads = args.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start threads")?;
    pool.install(|| frames::run(args, &interrupt, viewer))
}
