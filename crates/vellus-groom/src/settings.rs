//! How fur grows.

use crate::error::Error;
use crate::roots::Site;
use glam::Vec3;
use vellus_scene::{Basis, Parameter};

/// The most segments of a strand: far more than any curve needs.
const MAX_SEGMENTS: usize = 65_536;

/// Numbers of a groom. Lengths are in the scene's unit, angles in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowSettings {
    /// The strands' name.
    pub name: String,
    /// Strands.
    pub count: usize,
    /// Curve segments a strand; [1, 65536].
    pub segments: usize,
    /// [`Basis::Linear`], [`Basis::BSpline`] or [`Basis::CatmullRom`].
    pub basis: Basis,
    /// Other seeds give other fur.
    pub seed: u64,
    /// Length of a strand of the undercoat; positive.
    pub length: f32,
    /// Lengths are spread evenly by this fraction to both sides; [0, 1).
    pub length_variation: f32,
    /// Radius at the root and at the tip; not negative.
    pub radius: [f32; 2],
    /// Radii are spread evenly by this fraction to both sides, strand by strand; [0, 1).
    pub radius_variation: f32,
    /// Share of guard hairs among the strands, [0, 1].
    pub guard_share: f32,
    /// How many times longer and thicker guard hairs are than the undercoat; positive.
    pub guard_scale: [f32; 2],
    /// Angle between strand and surface at the root and at the tip; π/2 stands upright.
    pub lift: [f32; 2],
    /// Standard deviation of the direction from strand to strand.
    pub spread: f32,
    /// How strongly strands hang down: what is added at their tips to a direction of length 1; not negative.
    pub gravity: f32,
    /// Away from where they hang; a direction of any length but 0.
    pub up: Vec3,
    /// Clumps.
    pub clump: Clump,
    /// Radius of the helix that strands curl in; grows from 0 at the root. Not negative.
    pub curl_radius: f32,
    /// Turns of the helix.
    pub curl_turns: f32,
    /// Waviness: deviation at the tip, as a fraction of the length; not negative.
    pub noise: f32,
    /// Distance to keep from the body where [`Maps::distance`] gives it, reached at the tip; not negative.
    pub clearance: f32,
}

/// Strands that draw together toward their tips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clump {
    /// Mean number of strands in one; below 2 there are none.
    pub strands: usize,
    /// How far tips come to the middle one on average, [0, 1]; at 1 all meet it.
    pub strength: f32,
    /// Their profile: strength × (distance from the root / length)^power; positive.
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
            noise: 0.02,
            clearance: 0.0,
        }
    }
}

impl GrowSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::Setting`] names the first that is out of its range.
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
        check("up", self.up.length(), self.up.try_normalize().is_some(), "it must have a finite length, and not 0")?;
        fraction("clump.strength", self.clump.strength)?;
        positive("clump.power", self.clump.power)?;
        not_negative("curl_radius", self.curl_radius)?;
        check("curl_turns", self.curl_turns, true, "it must be finite")?;
        not_negative("noise", self.noise)?;
        not_negative("clearance", self.clearance)
    }
}

/// Gives a strand's value of a parameter from where it grows and what chance gave it.
pub type ColorMap<'a> = &'a (dyn Fn(&Site, &Draw) -> [f32; 3] + Sync);

/// What differs from place to place. Textures are looked up in these closures: `|site| texture.at(site.uv)[0]`.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// Strands a unit of area, relative to elsewhere; below 0 and NaN are 0.
    pub density: &'a (dyn Fn(&Site) -> f32 + Sync),
    /// Multiplies the length.
    pub length: &'a (dyn Fn(&Site) -> f32 + Sync),
    /// The way strands lie, of any length; it is laid onto the surface. Where it is 0 or along the normal they stand
    /// upright.
    pub comb: &'a (dyn Fn(&Site) -> Vec3 + Sync),
    /// A parameter of the fibres by strand, usually a colour.
    pub color: Option<(Parameter, ColorMap<'a>)>,
    /// Distance to the body, negative inside it, for strands to stay outside; its gradient is taken over 0.01.
    pub distance: Option<&'a (dyn Fn(Vec3) -> f32 + Sync)>,
}

/// What chance gave a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Is it a guard hair?
    pub guard: bool,
    /// A number in [0, 1) of its own.
    pub random: f32,
}

impl Default for Maps<'_> {
    fn default() -> Self {
        Maps { density: &|_| 1.0, length: &|_| 1.0, comb: &|_| Vec3::ZERO, color: None, distance: None }
    }
}
