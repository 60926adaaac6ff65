//! Groups of strands as a settings file describes them, and their defaults.

#[cfg(feature = "clap")]
use crate::argument;
use crate::{Clump, Error, GrowSettings};
use glam::Vec3;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use vellus_scene::Basis;

/// Strands of a mesh if neither density nor count is given.
const COUNT: f64 = 100_000.0;
/// Default length, as a share of the square root of the area.
const LENGTH: f64 = 0.035;
/// Default width: so wide, the default number of strands would cover the area this many times if they lay side by side.
/// They overlap and form clumps, and hide about 98 % of the skin.
const COVER: f64 = 6.0;

/// The largest settings file: 16 MiB.
const MAX_SETTINGS_BYTES: u64 = 16 << 20;

/// A group of strands. Values that are not given have defaults, see [`Group::settings`]. Lengths are in the unit of the
/// mesh, angles in degrees.
///
/// With the feature `clap`, the fields are also options of a command line. Their documentation is then the help text.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Name of the strands in the scene [default: fur].
    #[cfg_attr(feature = "clap", arg(long))]
    pub name: Option<String>,
    /// The fibre: a preset or a file.
    #[cfg_attr(feature = "clap", arg(skip))]
    pub fiber: Option<PathBuf>,
    /// Parameters of the fibre by name, such as `{ reflectance = "ginger", kappa = 0.5 }`.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(default)]
    pub set: BTreeMap<String, toml::Value>,
    /// Strands per square unit of the mesh; above 0.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", conflicts_with = "count"))]
    pub density: Option<f32>,
    /// Strands in all [default: 100000].
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = argument::whole(1..=u32::MAX as usize)))]
    pub count: Option<usize>,
    /// Image that multiplies the density, at the uv of the mesh; only its first channel, without colour conversion.
    #[cfg_attr(feature = "clap", arg(long, value_name = "IMAGE"))]
    pub density_map: Option<PathBuf>,
    /// Length of a strand, in units of the mesh; above 0 [default: in proportion to the mesh].
    #[cfg_attr(feature = "clap", arg(long, value_name = "L"))]
    pub length: Option<f32>,
    /// Random variation of the length, as a share of it; [0, 1) [default: 0.25].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub length_variation: Option<f32>,
    /// Image that multiplies the length, at the uv of the mesh; nothing grows where it is 0.
    #[cfg_attr(feature = "clap", arg(long, value_name = "IMAGE"))]
    pub length_map: Option<PathBuf>,
    /// Width (diameter) at the root, in units of the mesh; 0 or more [default: 100,000 strands of it hide 98 % of the
    /// skin].
    #[cfg_attr(feature = "clap", arg(long, value_name = "W"))]
    pub width: Option<f32>,
    /// Random variation of the width, as a share of it; [0, 1) [default: 0.15].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub width_variation: Option<f32>,
    /// Share of the width that is lost toward the tip; [0, 1] [default: 0.75].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub taper: Option<f32>,
    /// Segments of a strand; [1, 65536] [default: 12].
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = argument::whole(1..=65_536)))]
    pub segments: Option<usize>,
    /// Kind of curve: linear, bspline or catmull-rom [default: catmull-rom].
    #[cfg_attr(feature = "clap", arg(long))]
    pub basis: Option<String>,
    /// Direction that strands lie in, projected onto the surface [default: down]. 0,0,0: they stand upright.
    #[cfg_attr(feature = "clap", arg(long, value_name = "X,Y,Z", value_parser = argument::vector))]
    #[cfg_attr(feature = "clap", arg(allow_hyphen_values = true))]
    pub comb: Option<[f32; 3]>,
    /// Angle between strand and surface at the root, degrees; [-90, 90] [default: 50].
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEG"))]
    pub lift: Option<f32>,
    /// How much smaller this angle is at the tip, degrees; [-180, 180] [default: 30].
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEG"))]
    pub bend: Option<f32>,
    /// Random variation of the direction (standard deviation), degrees; [0, 90] [default: 9].
    #[cfg_attr(feature = "clap", arg(long, value_name = "DEG"))]
    pub spread: Option<f32>,
    /// How strongly strands hang down toward their tips; 0 or more; 1 is 45° for a level strand [default: 0.15].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub gravity: Option<f32>,
    /// Strands in a clump; below 2: no clumps [default: 30].
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = argument::whole(0..=u32::MAX as usize)))]
    pub clump: Option<usize>,
    /// How far the tips of a clump come together; [0, 1] [default: 0.5].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub clump_strength: Option<f32>,
    /// Whether clumps close near the root (below 1) or near the tip (above 1); above 0 [default: 1.4].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub clump_shape: Option<f32>,
    /// Radius of curls, as a share of the length; 0 or more [default: 0].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub curl: Option<f32>,
    /// Turns of a curl from root to tip; negative: the other way round [default: 2].
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub curl_turns: Option<f32>,
    /// Waviness: how far tips deviate, as a share of the length; 0 or more [default: 0.05].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub noise: Option<f32>,
    /// Share of stray strands, which are in no clump and lie in less order; [0, 1] [default: 0.02].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub stray: Option<f32>,
    /// Share of guard hairs; [0, 1] [default: 0.15, or 0 with several groups].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub guard_share: Option<f32>,
    /// Length of guard hairs relative to the others; above 0 [default: 1.4].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub guard_length: Option<f32>,
    /// Width of guard hairs relative to the others; above 0 [default: 1.4].
    #[cfg_attr(feature = "clap", arg(long, value_name = "X"))]
    pub guard_width: Option<f32>,
    /// Image of the colour of the strands, at the uv of the mesh.
    #[cfg_attr(feature = "clap", arg(long, value_name = "IMAGE"))]
    pub color: Option<PathBuf>,
}

/// An invalid group or settings file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GroupError {
    /// A value of a group is out of its range.
    #[error("{group}: {what}")]
    Value {
        /// The group.
        group: String,
        /// The value and its range.
        what: String,
    },
    /// The values of a group do not fit together.
    #[error("in {group}")]
    Settings {
        /// The group.
        group: String,
        /// The problem.
        source: Error,
    },
    /// A settings file that cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system reports.
        source: std::io::Error,
    },
    /// A settings file that is not valid.
    #[error("{}: {what}", path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// The place and the problem.
        what: String,
    },
    /// A settings file without groups.
    #[error("{}: it has no [[group]]", .0.display())]
    Empty(PathBuf),
    /// An image is given, but a mesh has no coordinates for it.
    #[error("{mesh} has no uv, which {} needs", image.display())]
    NoUv {
        /// The mesh.
        mesh: String,
        /// The image.
        image: PathBuf,
    },
    /// The mesh cannot grow strands.
    #[error(transparent)]
    Grow(#[from] Error),
    /// A colour of the fibre out of range.
    #[error(transparent)]
    Fiber(#[from] vellus::Error),
}

/// A settings file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    group: Vec<Group>,
}

/// Reads the groups of a settings file (TOML). Relative paths of images start from the folder of the file.
///
/// # Errors
/// [`GroupError::Read`], [`GroupError::Parse`], [`GroupError::Empty`].
pub fn read_groups(path: &Path) -> Result<Vec<Group>, GroupError> {
    let text = vellus_io::read_to_string(path, MAX_SETTINGS_BYTES);
    let text = text.map_err(|source| GroupError::Read { path: path.to_owned(), source })?;
    let wrong = |error| GroupError::Parse { path: path.to_owned(), what: toml_message(&error) };
    let parsed = toml::from_str(&text).map_err(wrong);
    let File { mut group } = parsed?;
    if group.is_empty() {
        return Err(GroupError::Empty(path.to_owned()));
    }
    for (i, group) in group.iter_mut().enumerate() {
        group.name.get_or_insert_with(|| format!("group-{}", i + 1));
        for image in [&mut group.density_map, &mut group.length_map, &mut group.color].into_iter().flatten() {
            *image = path.with_file_name("").join(&image);
        }
    }
    Ok(group)
}

/// The place and the problem of a TOML file in one line, without the text of the file.
pub fn toml_message(error: &toml::de::Error) -> String {
    let text = error.to_string();
    format!("{}: {}", text.lines().next().unwrap_or_default(), error.message().replace('\n', "; "))
}

/// The ground that a group grows on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Area, weighted by the density map.
    pub area: f64,
    /// Number of groups that share it.
    pub groups: usize,
    /// The direction up.
    pub up: Vec3,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Group {
    /// This group, with the values of `other` where it has none.
    #[must_use]
    pub fn or(self, other: Group) -> Group {
        let counted = self.density.is_some() || self.count.is_some();
        let (density, count) = if counted { (self.density, self.count) } else { (other.density, other.count) };
        Group {
            density,
            count,
            name: self.name.or(other.name),
            fiber: self.fiber.or(other.fiber),
            set: if self.set.is_empty() { other.set } else { self.set },
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
            stray: self.stray.or(other.stray),
            guard_share: self.guard_share.or(other.guard_share),
            guard_length: self.guard_length.or(other.guard_length),
            guard_width: self.guard_width.or(other.guard_width),
            color: self.color.or(other.color),
        }
    }

    /// [`Group::set`] as `NAME=VALUE`, with `R,G,B` for arrays.
    pub fn settings_of_fiber(&self) -> Vec<String> {
        let text = |value: &toml::Value| match value {
            toml::Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        let value = |value: &toml::Value| match value {
            toml::Value::Array(values) => values.iter().map(text).collect::<Vec<_>>().join(","),
            one => text(one),
        };
        self.set.iter().map(|(name, of)| format!("{name}={}", value(of))).collect()
    }

    /// Its name.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or("fur")
    }

    /// The direction that its strands lie in.
    pub fn comb(&self, up: Vec3) -> Vec3 {
        self.comb.map_or(-up, Vec3::from)
    }

    /// The settings that grow the group on `ground`, in the unit of the mesh and in radians.
    ///
    /// # Errors
    /// The first value that is out of its range.
    pub fn settings(&self, ground: &Ground) -> Result<GrowSettings, GroupError> {
        let wrong = |what: String| GroupError::Value { group: self.name().to_owned(), what };
        let checked = |name: &str, given: Option<f32>, fallback: f32, good: fn(f32) -> bool, range: &str| {
            let value = given.unwrap_or(fallback);
            if value.is_finite() && good(value) {
                return Ok(value);
            }
            Err(wrong(format!("{name} = {value} is out of range: it must be {range}")))
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
            return Err(wrong(format!("count = {count} is out of range: it must be in [1, {}]", u32::MAX)));
        }
        let count = match density {
            Some(density) => (f64::from(density) * ground.area).round(),
            None => self.count.map_or(COUNT / ground.groups as f64, |count| count as f64),
        };
        if count < 1.0 {
            let density = density.unwrap_or(0.0);
            let what = format!("a density of {density} on an area of {:.4e} gives no strand at all", ground.area);
            return Err(wrong(what));
        }
        if count > f64::from(u32::MAX) {
            return Err(wrong(format!("{count:.3e} strands are too many: give a lower density")));
        }
        let length = positive("length", self.length, (LENGTH * ground.area.sqrt()) as f32)?;
        let taper = unit("taper", self.taper, 0.75)?;
        // The width does not depend on the number of strands: more of them are denser fur.
        let cover = COVER * ground.area / (COUNT * f64::from(length * (1.0 - 0.5 * taper)));
        let width = not_negative("width", self.width, (cover as f32).min(0.1 * length))?;
        let lift = degrees("lift", self.lift, 50.0, |x| x.abs() <= 90.0, "in [-90, 90] degrees")?;
        let bend = degrees("bend", self.bend, 30.0, |x| x.abs() <= 180.0, "in [-180, 180] degrees")?;
        let basis = match self.basis.as_deref() {
            None | Some("catmull-rom") => Basis::CatmullRom,
            Some("bspline") => Basis::BSpline,
            Some("linear") => Basis::Linear,
            Some(other) => return Err(wrong(format!("basis = {other}: it must be linear, bspline or catmull-rom"))),
        };
        if self.comb.is_some_and(|comb| comb.iter().any(|x| !x.is_finite())) {
            return Err(wrong("comb must be three finite numbers".to_owned()));
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
            stray: unit("stray", self.stray, 0.02)?,
            curl_variation: 1.0,
            noise: not_negative("noise", self.noise, 0.05)?,
            clearance: 0.0,
        };
        settings.validate().map_err(|source| GroupError::Settings { group: self.name().to_owned(), source })?;
        Ok(settings)
    }
}
