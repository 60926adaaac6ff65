//! Settings and maps of a groom.

use crate::error::Error;
use crate::roots::Site;
use glam::Vec3;
use vellus_scene::{Basis, Parameter};

/// The largest number of segments of a strand.
const MAX_SEGMENTS: usize = 65_536;

/// The numbers of a groom. Lengths are in the unit of the scene, angles in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowSettings {
    /// Name of the strands.
    pub name: String,
    /// Number of strands. The total number of points must be below 2³².
    pub count: usize,
    /// Curve segments per strand, in [1, 65536].
    pub segments: usize,
    /// [`Basis::Linear`], [`Basis::BSpline`] or [`Basis::CatmullRom`].
    pub basis: Basis,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Mean length of the undercoat; positive.
    pub length: f32,
    /// Relative variation of lengths, uniform to both sides; in [0, 1).
    pub length_variation: f32,
    /// Radius at the root and at the tip; not negative.
    pub radius: [f32; 2],
    /// Relative variation of radii between strands, uniform to both sides; in [0, 1).
    pub radius_variation: f32,
    /// Fraction of guard hairs, in [0, 1].
    pub guard_share: f32,
    /// Length and thickness of guard hairs relative to the undercoat; positive.
    pub guard_scale: [f32; 2],
    /// Angle between strand and surface at the root and at the tip. π/2 is upright.
    pub lift: [f32; 2],
    /// Standard deviation of the direction between strands; not negative.
    pub spread: f32,
    /// Strength of gravity: length of the downward vector that is added to the unit direction at the tip; not
    /// negative.
    pub gravity: f32,
    /// The up direction, against gravity. Any length except 0.
    pub up: Vec3,
    /// How strands form clumps.
    pub clump: Clump,
    /// Radius of the helix of curls, which grows from 0 at the root; not negative.
    pub curl_radius: f32,
    /// Number of turns of the helix.
    pub curl_turns: f32,
    /// Share of stray strands, in [0, 1]. They are in no clump, and their direction, curls and waves vary more.
    pub stray: f32,
    /// How much the phases and turns of curls vary between strands, in [0, 1]. At 0, neighbours curl together. At 1,
    /// they curl independently.
    pub curl_variation: f32,
    /// Waviness: deviation at the tip relative to the length; not negative.
    pub noise: f32,
    /// Minimum distance of the tip from the body, if [`Maps::distance`] is set. It is 0 at the root and grows
    /// linearly; not negative.
    pub clearance: f32,
}

/// Clumps: strands that converge toward their tips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clump {
    /// Mean number of strands per clump. Below 2 there are no clumps.
    pub strands: usize,
    /// How far tips move toward the central strand on average, in [0, 1]. At 1 they all reach it.
    pub strength: f32,
    /// Exponent of the profile strength × (distance from the root / length)^power; positive.
    pub power: f32,
}

impl Default for GrowSettings {
    fn default() -> Self {
        GrowSettings {
            name: "fur".to_owned(),
            count: 10_000,
            segments: 8,
            basis: Basis::CatmullRom,
            seed: 1,
            length: 1.0,
            length_variation: 0.2,
            radius: [0.004, 0.001],
            radius_variation: 0.15,
            guard_share: 0.0,
            guard_scale: [1.5, 1.5],
            lift: [1.0, 0.5],
            spread: 0.1,
            gravity: 0.0,
            up: Vec3::Y,
            clump: Clump { strands: 0, strength: 0.5, power: 1.0 },
            curl_radius: 0.0,
            curl_turns: 0.0,
            stray: 0.0,
            curl_variation: 1.0,
            noise: 0.02,
            clearance: 0.0,
        }
    }
}

impl GrowSettings {
    /// Checks that all settings are in range.
    ///
    /// # Errors
    /// [`Error::Setting`] for the first setting that is out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let check = |name, value: f32, good: bool, range| {
            if good && value.is_finite() { Ok(()) } else { Err(Error::Setting { name, value, range }) }
        };
        let not_negative = |name, value: f32| check(name, value, value >= 0.0, "it must not be negative");
        let positive = |name, value: f32| check(name, value, value > 0.0, "it must be positive");
        let fraction = |name, value: f32| check(name, value, (0.0..=1.0).contains(&value), "it must be in [0, 1]");
        let points = self.count.saturating_mul(self.segments.saturating_add(3));
        let few = u32::try_from(points).is_ok();
        check(
            "segments",
            self.segments as f32,
            (1..=MAX_SEGMENTS).contains(&self.segments),
            "it must be in [1, 65536]",
        )?;
        check("count", self.count as f32, few, "with these segments there must be fewer than 2^32 points")?;
        let basis = self.basis != Basis::Bezier;
        check("basis", 3.0, basis, "strands grow as linear, B-spline or Catmull–Rom curves")?;
        positive("length", self.length)?;
        let variation = self.length_variation;
        check("length_variation", variation, (0.0..1.0).contains(&variation), "it must be in [0, 1)")?;
        self.radius.iter().try_for_each(|&r| not_negative("radius", r))?;
        let variation = self.radius_variation;
        check("radius_variation", variation, (0.0..1.0).contains(&variation), "it must be in [0, 1)")?;
        fraction("guard_share", self.guard_share)?;
        self.guard_scale.iter().try_for_each(|&s| positive("guard_scale", s))?;
        self.lift.iter().try_for_each(|&angle| check("lift", angle, true, "it must be finite"))?;
        not_negative("spread", self.spread)?;
        not_negative("gravity", self.gravity)?;
        check("up", self.up.length(), self.up.try_normalize().is_some(), "it must have a finite length other than 0")?;
        fraction("clump.strength", self.clump.strength)?;
        positive("clump.power", self.clump.power)?;
        not_negative("curl_radius", self.curl_radius)?;
        check("curl_turns", self.curl_turns, true, "it must be finite")?;
        fraction("stray", self.stray)?;
        fraction("curl_variation", self.curl_variation)?;
        not_negative("noise", self.noise)?;
        not_negative("clearance", self.clearance)
    }
}

/// Returns the value of a parameter of a strand, RGB, from its site and its random numbers.
pub type ColorMap<'a> = &'a (dyn Fn(&Site, &Draw) -> [f32; 3] + Sync);

/// Functions of the position on the mesh. To use a texture, sample it in the closure: `|site| texture.at(site.uv)[0]`.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// Relative number of strands per unit of area. Negative values and NaN count as 0.
    pub density: &'a (dyn Fn(&Site) -> f32 + Sync),
    /// Factor of the length.
    pub length: &'a (dyn Fn(&Site) -> f32 + Sync),
    /// Direction of strands, of any length. It is projected onto the surface. Strands are upright where the projection
    /// is 0, and stand up gradually where its angle to the normal is below 20°.
    pub comb: &'a (dyn Fn(&Site) -> Vec3 + Sync),
    /// A parameter of the fibre for each strand, usually a colour.
    pub color: Option<(Parameter, ColorMap<'a>)>,
    /// Signed distance to the body, negative inside, which keeps strands outside. Its gradient is computed by
    /// differences over 0.01 units.
    pub distance: Option<&'a (dyn Fn(Vec3) -> f32 + Sync)>,
}

/// Random numbers of a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Whether the strand is a guard hair.
    pub guard: bool,
    /// A uniform number in [0, 1).
    pub random: f32,
}

impl Default for Maps<'_> {
    fn default() -> Self {
        Maps { density: &|_| 1.0, length: &|_| 1.0, comb: &|_| Vec3::ZERO, color: None, distance: None }
    }
}
