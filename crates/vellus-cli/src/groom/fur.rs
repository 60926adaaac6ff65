//! The options of `vellus groom grow` that describe fur.

use crate::number::whole;
use std::path::PathBuf;
use vellus_groom::Group;

/// A group of strands, see [`Group`].
#[derive(clap::Args, Clone, Debug)]
pub struct Fur {
    /// Name of the strands in the scene [default: fur].
    #[arg(long)]
    name: Option<String>,
    /// Strands per square unit of the mesh; above 0.
    #[arg(long, value_name = "N", conflicts_with = "count")]
    density: Option<f32>,
    /// Strands in all [default: 100000].
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=u32::MAX.into()))]
    count: Option<usize>,
    /// Image that multiplies the density, at the uv of the mesh; only its first channel, without colour conversion.
    #[arg(long, value_name = "IMAGE")]
    density_map: Option<PathBuf>,
    /// Length of a strand, in units of the mesh; above 0 [default: in proportion to the mesh].
    #[arg(long, value_name = "L")]
    length: Option<f32>,
    /// Random variation of the length, as a share of it; [0, 1) [default: 0.25].
    #[arg(long, value_name = "X")]
    length_variation: Option<f32>,
    /// Image that multiplies the length, at the uv of the mesh; nothing grows where it is 0.
    #[arg(long, value_name = "IMAGE")]
    length_map: Option<PathBuf>,
    /// Width (diameter) at the root, in units of the mesh; 0 or more [default: such that strands cover the mesh].
    #[arg(long, value_name = "W")]
    width: Option<f32>,
    /// Random variation of the width, as a share of it; [0, 1) [default: 0.15].
    #[arg(long, value_name = "X")]
    width_variation: Option<f32>,
    /// Share of the width that is lost toward the tip; [0, 1] [default: 0.75].
    #[arg(long, value_name = "X")]
    taper: Option<f32>,
    /// Segments of a strand; [1, 65536] [default: 12].
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=65_536))]
    segments: Option<usize>,
    /// Kind of curve: linear, bspline or catmull-rom [default: catmull-rom].
    #[arg(long)]
    basis: Option<String>,
    /// Direction that strands lie in, projected onto the surface [default: down]. 0,0,0: they stand upright.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    comb: Option<[f32; 3]>,
    /// Angle between strand and surface at the root, degrees; [-90, 90] [default: 50].
    #[arg(long, value_name = "DEG")]
    lift: Option<f32>,
    /// How much smaller this angle is at the tip, degrees; [-180, 180] [default: 30].
    #[arg(long, value_name = "DEG")]
    bend: Option<f32>,
    /// Random variation of the direction (standard deviation), degrees; [0, 90] [default: 9].
    #[arg(long, value_name = "DEG")]
    spread: Option<f32>,
    /// How strongly strands hang down toward their tips; 0 or more; 1 is 45° for a level strand [default: 0.15].
    #[arg(long, value_name = "X")]
    gravity: Option<f32>,
    /// Strands in a clump; below 2: no clumps [default: 30].
    #[arg(long, value_name = "N", value_parser = whole::<usize>(0..=u32::MAX.into()))]
    clump: Option<usize>,
    /// How far the tips of a clump come together; [0, 1] [default: 0.5].
    #[arg(long, value_name = "X")]
    clump_strength: Option<f32>,
    /// Whether clumps close near the root (below 1) or near the tip (above 1); above 0 [default: 1.4].
    #[arg(long, value_name = "X")]
    clump_shape: Option<f32>,
    /// Radius of curls, as a share of the length; 0 or more [default: 0].
    #[arg(long, value_name = "X")]
    curl: Option<f32>,
    /// Turns of a curl from root to tip; negative: the other way round [default: 2].
    #[arg(long, value_name = "N")]
    curl_turns: Option<f32>,
    /// Waviness: how far tips deviate, as a share of the length; 0 or more [default: 0.05].
    #[arg(long, value_name = "X")]
    noise: Option<f32>,
    /// Share of guard hairs; [0, 1] [default: 0.15, or 0 with several groups].
    #[arg(long, value_name = "X")]
    guard_share: Option<f32>,
    /// Length of guard hairs relative to the others; above 0 [default: 1.4].
    #[arg(long, value_name = "X")]
    guard_length: Option<f32>,
    /// Width of guard hairs relative to the others; above 0 [default: 1.4].
    #[arg(long, value_name = "X")]
    guard_width: Option<f32>,
    /// Image of the colour of the strands, at the uv of the mesh.
    #[arg(long, value_name = "IMAGE")]
    color: Option<PathBuf>,
}

impl From<Fur> for Group {
    fn from(fur: Fur) -> Group {
        Group {
            fiber: None,
            name: fur.name,
            density: fur.density,
            count: fur.count,
            density_map: fur.density_map,
            length: fur.length,
            length_variation: fur.length_variation,
            length_map: fur.length_map,
            width: fur.width,
            width_variation: fur.width_variation,
            taper: fur.taper,
            segments: fur.segments,
            basis: fur.basis,
            comb: fur.comb,
            lift: fur.lift,
            bend: fur.bend,
            spread: fur.spread,
            gravity: fur.gravity,
            clump: fur.clump,
            clump_strength: fur.clump_strength,
            clump_shape: fur.clump_shape,
            curl: fur.curl,
            curl_turns: fur.curl_turns,
            noise: fur.noise,
            guard_share: fur.guard_share,
            guard_length: fur.guard_length,
            guard_width: fur.guard_width,
            color: fur.color,
        }
    }
}

fn vector(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|x| x.trim().parse().ok()).collect();
    <[f32; 3]>::try_from(numbers).map_err(|_| "a direction is X,Y,Z".to_owned())
}
