//! Grows fur on a mesh.

use crate::body::gradient;
use crate::clumps::{Clumps, hash};
use crate::error::Error;
use crate::roots::{Roots, Site};
use crate::settings::{Draw, GrowSettings, Maps};
use glam::{Quat, Vec3, Vec4};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use vellus_scene::{Basis, Mesh, Strands, Values};

/// Number of strands whose spacing determines the resolution of the mean density.
const FINEST: usize = 1 << 20;

/// Strands are combed fully if the sine of the angle between comb and surface normal is at least this.
const COMBED: f32 = 0.35;

/// Factor of the variation of stray strands.
const STRAY: f32 = 2.5;

/// Grows strands on a mesh.
///
/// Each strand depends on its index and the seed only, so the result is the same with any number of threads. Strands
/// are in spatial order: neighbours in the list are neighbours on the mesh. They have [`Strands::look`] 0.
///
/// # Errors
/// [`Error::Setting`] if a setting is out of range. [`Error::Scene`] if the mesh is not valid, or if the maps give
/// strands that are not valid. [`Error::Nowhere`] if strands cannot grow anywhere.
pub fn grow(mesh: &Mesh, settings: &GrowSettings, maps: &Maps) -> Result<Strands, Error> {
    settings.validate()?;
    let grower = Grower { settings, maps, roots: Roots::new(mesh, maps.density, settings.count)? };
    let clumps = Clumps::new(settings, grower.roots.area_per_strand(settings.count), |i| {
        let mut line = Vec::new();
        let root = grower.line(i, &mut line);
        (root.site.position, line)
    });
    let phantom = if settings.basis == Basis::Linear { 0 } else { 1 };
    let per_strand = settings.segments + 1 + 2 * phantom;
    let mut points = vec![Vec4::ZERO; settings.count * per_strand];
    let roots: Vec<Root> = points
        .par_chunks_mut(per_strand)
        .enumerate()
        .map_init(Vec::new, |line, (i, points)| {
            let root = grower.line(i, line);
            if !settings.is_stray(i) {
                clumps.gather(i, root.site.position, line);
            }
            grower.keep_outside(line);
            for (k, p) in line.iter().enumerate() {
                let s = k as f32 / settings.segments as f32;
                let radius = settings.radius[0] + s * (settings.radius[1] - settings.radius[0]);
                points[phantom + k] = p.extend(radius * root.thickness);
            }
            if phantom == 1 {
                // In both bases, a curve passes through its second point if that is the midpoint of its neighbours.
                let n = points.len();
                let beyond = |end: Vec4, next: Vec4| (2.0 * end - next).truncate().extend(end.w);
                points[0] = beyond(points[1], points[2]);
                points[n - 1] = beyond(points[n - 2], points[n - 3]);
            }
            root
        })
        .collect();
    let color = maps.color.map(|(parameter, color)| {
        (parameter, Values::PerStrand(roots.par_iter().map(|root| color(&root.site, &root.draw)).collect()))
    });
    let strands = Strands {
        name: settings.name.clone(),
        basis: settings.basis,
        starts: (0..=settings.count).map(|i| (i * per_strand) as u32).collect(),
        points,
        moved: None,
        normals: None,
        root_uv: mesh.uv.as_ref().map(|_| roots.iter().map(|root| root.site.uv).collect()),
        look: 0,
        varying: color.into_iter().collect(),
    };
    // Maps may return any value.
    strands.validate()?;
    Ok(strands)
}

/// The integral of a density over a mesh, in units of area. Multiply it by the number of strands per unit of area at
/// density 1 to get [`GrowSettings::count`].
///
/// # Errors
/// [`Error::Scene`] if the mesh is not valid. [`Error::Nowhere`] if it has no area with a positive density.
pub fn area(mesh: &Mesh, density: &(dyn Fn(&Site) -> f32 + Sync)) -> Result<f64, Error> {
    Ok(Roots::new(mesh, density, FINEST)?.area())
}

struct Root {
    site: Site,
    draw: Draw,
    /// Factor of the radius.
    thickness: f32,
}

struct Grower<'a> {
    settings: &'a GrowSettings,
    maps: &'a Maps<'a>,
    roots: Roots<'a>,
}

impl Grower<'_> {
    /// The points of strand `i`, before clumping.
    fn line(&self, i: usize, line: &mut Vec<Vec3>) -> Root {
        let settings = self.settings;
        let up = settings.up.normalize_or(Vec3::Y);
        let seed = settings.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(i as u64));
        let site = self.roots.root(i, settings.count, &mut rng);
        let mut random = || rng.random::<f32>();
        let draw = Draw { guard: random() < settings.guard_share, random: random() };
        let [longer, thicker] = if draw.guard { settings.guard_scale } else { [1.0; 2] };
        let varied = 1.0 + settings.length_variation * (2.0 * random() - 1.0);
        let length = settings.length * longer * varied * (self.maps.length)(&site).max(0.0);

        let n = site.normal;
        let comb = (self.maps.comb)(&site);
        let along = comb - comb.dot(n) * n;
        let laid = along.normalize_or_zero();
        // Where the comb is nearly perpendicular to the surface, strands would lie away from one point, and leave it
        // bald. There they stand up, and their direction varies more.
        let combed = smoothstep(along.length() / (COMBED * comb.length()).max(f32::MIN_POSITIVE));
        // The deviation of this strand in azimuth and elevation (Box–Muller).
        let wild = if settings.is_stray(i) { STRAY } else { 1.0 };
        let (r, phi) = (wild * settings.spread * (-2.0 * (1.0 - random()).ln()).sqrt(), TAU * random());
        // Uncombed strands are upright, and deviate by the same angle in any direction.
        let (laid, lift) = if laid == Vec3::ZERO {
            (Quat::from_axis_angle(n, phi) * n.any_orthonormal_vector(), [FRAC_PI_2 - r; 2])
        } else {
            let turn = (r * phi.cos() / combed.max(0.1)).clamp(-PI, PI);
            let sideways = Quat::from_axis_angle(n, turn) * laid;
            let upright = |angle: f32| FRAC_PI_2 + combed * (angle - FRAC_PI_2);
            (sideways, settings.lift.map(|angle| upright(angle) + r * phi.sin()))
        };
        let wave = Wave::new(settings, length, wild, &mut random);

        line.clear();
        line.push(site.position);
        let step = length / settings.segments as f32;
        let mut p = site.position;
        for k in 0..settings.segments {
            let s = (k as f32 + 0.5) / settings.segments as f32;
            let angle = lift[0] + s * (lift[1] - lift[0]);
            let grown = angle.cos() * laid + angle.sin() * n;
            let hanging = grown - settings.gravity * s * up;
            p += step * hanging.normalize_or(grown);
            p = self.outside(p, settings.clearance * s);
            line.push(p);
        }
        let axis = (p - site.position).normalize_or(n);
        let (u, v) = axis.any_orthonormal_pair();
        for (k, p) in line.iter_mut().enumerate().skip(1) {
            let (x, y) = wave.at(k as f32 / settings.segments as f32);
            *p += x * u + y * v;
        }
        let varied = 1.0 + settings.radius_variation * (2.0 * random() - 1.0);
        Root { site, draw, thickness: thicker * varied }
    }

    /// Moves points out of the body after clumps, curls and waves.
    fn keep_outside(&self, line: &mut [Vec3]) {
        let last = (line.len() - 1) as f32;
        for (k, p) in line.iter_mut().enumerate().skip(1) {
            *p = self.outside(*p, self.settings.clearance * k as f32 / last);
        }
    }

    fn outside(&self, p: Vec3, clearance: f32) -> Vec3 {
        let Some(distance) = self.maps.distance else { return p };
        let inside = clearance - distance(p);
        if inside > 0.0 { p + inside * gradient(distance, p).normalize_or_zero() } else { p }
    }
}

impl GrowSettings {
    /// The central strands of clumps never are.
    fn is_stray(&self, strand: usize) -> bool {
        hash(strand as u32 ^ 0x5bd1_e995) < self.stray && !strand.is_multiple_of(self.clump.strands)
    }
}

/// A smooth step from 0 to 1 over [0, 1].
fn smoothstep(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Displacement of a strand by curls and waves, perpendicular to it.
struct Wave {
    curl: f32,
    turns: f32,
    phase: f32,
    noise: f32,
    frequency: [f32; 2],
    phases: [f32; 2],
}

impl Wave {
    fn new(settings: &GrowSettings, length: f32, wild: f32, random: &mut impl FnMut() -> f32) -> Self {
        let curl_variation = (wild * settings.curl_variation).min(1.0);
        Wave {
            curl: settings.curl_radius * (0.7 + 0.6 * random()),
            turns: settings.curl_turns * (1.0 + curl_variation * (0.3 * random() - 0.15)),
            phase: curl_variation * TAU * random(),
            noise: wild * settings.noise * length,
            // 0.5 to 1.5 waves.
            frequency: [0.5 + random(), 0.5 + random()],
            phases: [TAU * random(), TAU * random()],
        }
    }

    fn at(&self, s: f32) -> (f32, f32) {
        let angle = self.phase + TAU * self.turns * s;
        let curl = self.curl * (4.0 * s).min(1.0);
        let wave = |i: usize| self.noise * s * (TAU * self.frequency[i] * s + self.phases[i]).sin();
        (curl * angle.cos() + wave(0), curl * angle.sin() + wave(1))
    }
}
