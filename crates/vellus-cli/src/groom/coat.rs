//! How fur grows, on the command line and in a settings file: the same names in both.

use crate::number::whole;
use anyhow::{Context, Result, bail};
use glam::Vec3;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use vellus_groom::{Clump, GrowSettings};
use vellus_scene::Basis;

/// Strands of a mesh where nothing says how many.
const COUNT: f64 = 100_000.0;
/// Their length, against the square root of the area they grow on.
const LENGTH: f64 = 0.035;
/// How many times they would cover that area, laid side by side: what their width follows from.
const COVER: f64 = 1.6;

/// One group of strands.
#[derive(clap::Args, Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Its name in the file that is written; by default fur.
    #[arg(long)]
    pub name: Option<String>,
    /// A preset or file, as --fiber has; only in a settings file.
    #[arg(skip)]
    pub fiber: Option<PathBuf>,
    /// Strands a square unit of the mesh; above 0.
    #[arg(long, value_name = "N", conflicts_with = "count")]
    pub density: Option<f32>,
    /// Strands in all; by default 100000.
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=u32::MAX.into()))]
    pub count: Option<usize>,
    /// Image at the mesh's uv that the density is multiplied by; its first channel, as it is stored.
    #[arg(long, value_name = "IMAGE")]
    pub density_map: Option<PathBuf>,
    /// Length, in units of the mesh; above 0; by default in proportion to the mesh.
    #[arg(long, value_name = "L")]
    pub length: Option<f32>,
    /// Lengths are spread by this share to both sides; [0, 1); by default 0.25.
    #[arg(long, value_name = "X")]
    pub length_variation: Option<f32>,
    /// Image at the mesh's uv that the length is multiplied by; nothing grows where it is 0.
    #[arg(long, value_name = "IMAGE")]
    pub length_map: Option<PathBuf>,
    /// Width (diameter) at the root, in units of the mesh; 0 or more; by default such that strands cover the mesh.
    #[arg(long, value_name = "W")]
    pub width: Option<f32>,
    /// Widths are spread by this share to both sides; [0, 1); by default 0.15.
    #[arg(long, value_name = "X")]
    pub width_variation: Option<f32>,
    /// Share of the width that is lost toward the tip; [0, 1]; by default 0.75.
    #[arg(long, value_name = "X")]
    pub taper: Option<f32>,
    /// Segments a strand; [1, 65536]; by default 12.
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=65_536))]
    pub segments: Option<usize>,
    /// Kind of curve: linear, bspline or catmull-rom; by default catmull-rom.
    #[arg(long)]
    pub basis: Option<String>,
    /// The way strands lie; it is laid onto the surface. 0,0,0 lets them stand upright; by default down.
    #[arg(long, value_parser = vector, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub comb: Option<[f32; 3]>,
    /// Angle between strand and surface at the root, degrees; [-90, 90]; by default 50.
    #[arg(long, value_name = "DEG")]
    pub lift: Option<f32>,
    /// How much nearer to the surface strands point at their tips, degrees; [-180, 180]; by default 30.
    #[arg(long, value_name = "DEG")]
    pub bend: Option<f32>,
    /// Standard deviation of the direction from strand to strand, degrees; [0, 90]; by default 9.
    #[arg(long, value_name = "DEG")]
    pub spread: Option<f32>,
    /// How strongly strands hang down toward their tips; 0 or more, at 1 by 45° from level; by default 0.15.
    #[arg(long, value_name = "X")]
    pub gravity: Option<f32>,
    /// Strands that draw together to a clump; below 2 none do; by default 30.
    #[arg(long, value_name = "N", value_parser = whole::<usize>(0..=u32::MAX.into()))]
    pub clump: Option<usize>,
    /// How far the tips of a clump come together; [0, 1]; by default 0.5.
    #[arg(long, value_name = "X")]
    pub clump_strength: Option<f32>,
    /// Whether clumps close near the root (below 1) or only near the tip (above 1); above 0; by default 1.4.
    #[arg(long, value_name = "X")]
    pub clump_shape: Option<f32>,
    /// Radius of curls, as a share of the length; 0 or more; by default 0.
    #[arg(long, value_name = "X")]
    pub curl: Option<f32>,
    /// Turns of a curl from root to tip; either way round; by default 2.
    #[arg(long, value_name = "N")]
    pub curl_turns: Option<f32>,
    /// Waviness: how far tips stray, as a share of the length; 0 or more; by default 0.05.
    #[arg(long, value_name = "X")]
    pub noise: Option<f32>,
    /// Share of guard hairs among the strands; [0, 1]; by default 0.15, and 0 where the settings file has several groups.
    #[arg(long, value_name = "X")]
    pub guard_share: Option<f32>,
    /// How many times longer guard hairs are than the rest; above 0; by default 1.4.
    #[arg(long, value_name = "X")]
    pub guard_length: Option<f32>,
    /// How many times wider guard hairs are than the rest; above 0; by default 1.4.
    #[arg(long, value_name = "X")]
    pub guard_width: Option<f32>,
    /// Image at the mesh's uv that gives the strands their colour, as a texture of what the fibres absorb.
    #[arg(long, value_name = "IMAGE")]
    pub color: Option<PathBuf>,
}

/// A settings file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    group: Vec<Group>,
}

fn vector(text: &str) -> Result<[f32; 3], String> {
    let numbers: Vec<f32> = text.split(',').filter_map(|x| x.trim().parse().ok()).collect();
    <[f32; 3]>::try_from(numbers).map_err(|_| "a direction is X,Y,Z".to_owned())
}

/// The largest file of settings: 16 MiB.
const MAX_SETTINGS_BYTES: u64 = 16 << 20;

/// The groups of a settings file; images are looked for beside it.
pub fn read(path: &Path) -> Result<Vec<Group>> {
    let text = vellus_io::read_to_string(path, MAX_SETTINGS_BYTES)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let File { mut group } = toml::from_str(&text).with_context(|| format!("in {}", path.display()))?;
    if group.is_empty() {
        bail!("{}: it has no [[group]]", path.display());
    }
    for (i, group) in group.iter_mut().enumerate() {
        group.name.get_or_insert_with(|| format!("group-{}", i + 1));
        for image in [&mut group.density_map, &mut group.length_map, &mut group.color].into_iter().flatten() {
            *image = path.with_file_name("").join(&image);
        }
    }
    Ok(group)
}

/// What a group is planted on.
pub struct Ground {
    /// Area, times the density map.
    pub area: f64,
    /// Groups that share it.
    pub groups: usize,
    /// The way up.
    pub up: Vec3,
    /// Of the command; each group adds its own.
    pub seed: u64,
}

impl Group {
    /// The same where it says something, `other` where not.
    pub fn or(self, other: Group) -> Group {
        let counted = self.density.is_some() || self.count.is_some();
        let (density, count) = if counted { (self.density, self.count) } else { (other.density, other.count) };
        Group {
            density,
            count,
            name: self.name.or(other.name),
            fiber: self.fiber.or(other.fiber),
            density_map: self.density_map.or(other.density_map),
            length: self.length.or(other.length),
            length_variation: self.length_variation.or(other.length_variation),
            length_map: self.length_map.or(other.length_map),
            width: self.width.or(other.width),
            width_variation: self.width_variation.or(other.width_variation),
            taper: self.taper.or(other.taper),
            segments: self.segments.or(other.segments),
            basis: self.basis.or(other.basis),
            comb: self.comb.or(other.comb),
            lift: self.lift.or(other.lift),
            bend: self.bend.or(other.bend),
            spread: self.spread.or(other.spread),
            gravity: self.gravity.or(other.gravity),
            clump: self.clump.or(other.clump),
            clump_strength: self.clump_strength.or(other.clump_strength),
            clump_shape: self.clump_shape.or(other.clump_shape),
            curl: self.curl.or(other.curl),
            curl_turns: self.curl_turns.or(other.curl_turns),
            noise: self.noise.or(other.noise),
            guard_share: self.guard_share.or(other.guard_share),
            guard_length: self.guard_length.or(other.guard_length),
            guard_width: self.guard_width.or(other.guard_width),
            color: self.color.or(other.color),
        }
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or("fur")
    }

    /// The way its strands lie.
    pub fn comb(&self, up: Vec3) -> Vec3 {
        self.comb.map_or(-up, Vec3::from)
    }

    /// Its numbers, in the units of the mesh and of the crate that grows it.
    pub fn settings(&self, ground: &Ground) -> Result<GrowSettings> {
        let checked = |name: &str, given: Option<f32>, fallback: f32, good: fn(f32) -> bool, range: &str| {
            let value = given.unwrap_or(fallback);
            if value.is_finite() && good(value) {
                return Ok(value);
            }
            bail!("{}: {name} = {value} is out of range: it must be {range}", self.name())
        };
        let positive = |name: &str, given, fallback| checked(name, given, fallback, |x| x > 0.0, "above 0");
        let not_negative = |name: &str, given, fallback| checked(name, given, fallback, |x| x >= 0.0, "0 or more");
        let unit =
            |name: &str, given, fallback| checked(name, given, fallback, |x| (0.0..=1.0).contains(&x), "in [0, 1]");
        let spread =
            |name: &str, given, fallback| checked(name, given, fallback, |x| (0.0..1.0).contains(&x), "in [0, 1)");
        let degrees = |name: &str, given, fallback, good, range: &str| {
            checked(name, given, fallback, good, range).map(f32::to_radians)
        };

        let density = self.density.map(|d| positive("density", Some(d), 0.0)).transpose()?;
        if let (None, Some(count)) = (density, self.count)
            && !(1..=u32::MAX as usize).contains(&count)
        {
            bail!("{}: count = {count} is out of range: it must be in [1, {}]", self.name(), u32::MAX);
        }
        let count = match density {
            Some(density) => (f64::from(density) * ground.area).round(),
            None => self.count.map_or(COUNT / ground.groups as f64, |count| count as f64),
        };
        if count < 1.0 {
            bail!(
                "{}: a density of {} on an area of {:.4e} is no strand at all",
                self.name(),
                density.unwrap_or(0.0),
                ground.area
            );
        }
        if count > f64::from(u32::MAX) {
            bail!("{}: {count:.3e} strands are too many: give a lower density", self.name());
        }
        let length = positive("length", self.length, (LENGTH * ground.area.sqrt()) as f32)?;
        let taper = unit("taper", self.taper, 0.75)?;
        let cover = COVER / ground.groups as f64 * ground.area / (count * f64::from(length * (1.0 - 0.5 * taper)));
        let width = not_negative("width", self.width, (cover as f32).min(0.1 * length))?;
        let lift = degrees("lift", self.lift, 50.0, |x| x.abs() <= 90.0, "in [-90, 90] degrees")?;
        let bend = degrees("bend", self.bend, 30.0, |x| x.abs() <= 180.0, "in [-180, 180] degrees")?;
        let basis = match self.basis.as_deref() {
            None | Some("catmull-rom") => Basis::CatmullRom,
            Some("bspline") => Basis::BSpline,
            Some("linear") => Basis::Linear,
            Some(other) => bail!("{}: basis = {other}: it must be linear, bspline or catmull-rom", self.name()),
        };
        if self.comb.is_some_and(|comb| comb.iter().any(|x| !x.is_finite())) {
            bail!("{}: comb must be three finite numbers", self.name());
        }
        let guard_share = if ground.groups > 1 { 0.0 } else { 0.15 };
        let settings = GrowSettings {
            name: self.name().to_owned(),
            count: count as usize,
            segments: self.segments.unwrap_or(12),
            basis,
            seed: ground.seed,
            length,
            length_variation: spread("length_variation", self.length_variation, 0.25)?,
            radius: [0.5 * width, 0.5 * width * (1.0 - taper)],
            radius_variation: spread("width_variation", self.width_variation, 0.15)?,
            guard_share: unit("guard_share", self.guard_share, guard_share)?,
            guard_scale: [
                positive("guard_length", self.guard_length, 1.4)?,
                positive("guard_width", self.guard_width, 1.4)?,
            ],
            lift: [lift, lift - bend],
            spread: degrees("spread", self.spread, 9.0, |x| (0.0..=90.0).contains(&x), "in [0, 90] degrees")?,
            gravity: not_negative("gravity", self.gravity, 0.15)?,
            up: ground.up,
            clump: Clump {
                strands: self.clump.unwrap_or(30),
                strength: unit("clump_strength", self.clump_strength, 0.5)?,
                power: positive("clump_shape", self.clump_shape, 1.4)?,
            },
            curl_radius: length * not_negative("curl", self.curl, 0.0)?,
            curl_turns: checked("curl_turns", self.curl_turns, 2.0, |_| true, "finite")?,
            noise: not_negative("noise", self.noise, 0.05)?,
            clearance: 0.0,
        };
        settings.validate().with_context(|| format!("in {}", self.name()))?;
        Ok(settings)
    }
}
