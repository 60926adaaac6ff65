//! Explicit bunches: each collision is drawn from the member's own model. Slow, and without approximations but those of
//! the member.

use super::Random;
use super::profile::Profile;
use crate::error::{Error, checked};
use rayon::prelude::*;
use vellus::glam::Vec3;
use vellus::{Bcsdf, Fiber, Window, direction};

/// Paths that share one stream of random numbers.
const BATCH: u64 = 2_000;

/// Paths that share one arrangement of fibres.
const SHARED: u64 = 50;

/// Attempts to place one fibre without overlap.
const ATTEMPTS: usize = 10_000;

/// The share of the energy below which a path ends with a probability.
const FAINT: f64 = 0.01;

/// The field of the member's model that a collision uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Collision {
    /// The near field, at the offset where the ray meets the fibre.
    Near,
    /// The far field: the average over all offsets.
    Far,
}

/// Where the fibres are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Places {
    /// Infinitely many thin fibres with this optical diameter of the bunch.
    Medium(f64),
    /// That many fibres at independent random places, which fill this share of the section.
    Overlapping(u32, f64),
    /// The same without overlap, placed one after the other.
    Separate(u32, f64),
}

/// A bunch of fibres in a cylinder of radius 1.
#[derive(Clone, Copy, Debug)]
pub struct Fibers {
    /// The member.
    pub fiber: Fiber,
    /// Where the fibres are.
    pub places: Places,
    /// The field of a collision.
    pub collision: Collision,
    /// The spread of the members' directions in each plane, in radians. [`Places::Medium`] draws a direction for each
    /// collision.
    pub spread: f64,
}

/// What a bunch does with light.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattered {
    /// The share of light that passes without a collision.
    pub passes: f64,
    /// The light that collided: the share of it that leaves, in cells.
    pub profile: Profile,
    /// The mean number of collisions of light that collided, without absorption in the weights.
    pub collisions: f64,
}

/// One fibre: its centre in the section, and the deviation of its axis.
#[derive(Clone, Copy)]
struct Member {
    centre: [f64; 2],
    tilt: [f64; 2],
}

/// Where a ray meets a fibre.
struct Meeting {
    /// The fibre's centre, or the place in a medium.
    centre: [f64; 2],
    offset: f64,
    tilt: [f64; 2],
    radius: f64,
}

#[derive(Default)]
struct Sums {
    profile: Profile,
    collided: f64,
    collisions: f64,
}

impl Fibers {
    /// Follows `paths` paths (rounded up to a multiple of 2,000) that come from ω_o at the inclination `theta_o`, in
    /// radians, at even offsets.
    ///
    /// # Errors
    /// [`Error::Fiber`], and [`Error::OutOfRange`] if fibres without overlap find no place.
    pub fn scatter(&self, theta_o: f64, seed: u64, paths: u64) -> Result<Scattered, Error> {
        let bcsdf = Bcsdf::new(&self.fiber)?;
        let batches: Vec<Sums> = (0..paths.div_ceil(BATCH))
            .into_par_iter()
            .map(|batch| self.batch(&bcsdf, theta_o, &mut Random::new(seed, batch)))
            .collect::<Result<_, _>>()?;
        let mut total = Sums::default();
        for batch in &batches {
            total.profile.sum(&batch.profile);
            total.collided += batch.collided;
            total.collisions += batch.collisions;
        }
        let collided = total.collided.max(1.0);
        Ok(Scattered {
            passes: 1.0 - total.collided / (batches.len() as u64 * BATCH) as f64,
            profile: total.profile.scaled(1.0 / collided),
            collisions: total.collisions / collided,
        })
    }

    /// The radius of a member.
    fn radius(&self) -> f64 {
        match self.places {
            Places::Medium(_) => 0.0,
            Places::Overlapping(count, fill) | Places::Separate(count, fill) => (fill / f64::from(count)).sqrt(),
        }
    }

    fn batch(&self, bcsdf: &Bcsdf<'_>, theta_o: f64, random: &mut Random) -> Result<Sums, Error> {
        let mut sums = Sums::default();
        for _ in 0..BATCH / SHARED {
            let members = self.members(random)?;
            (0..SHARED).for_each(|_| self.path(bcsdf, theta_o, &members, random, &mut sums));
        }
        Ok(sums)
    }

    /// An arrangement of fibres. Their centres are in the unit disc.
    fn members(&self, random: &mut Random) -> Result<Vec<Member>, Error> {
        let (count, apart) = match self.places {
            Places::Medium(_) => (0, 0.0),
            Places::Overlapping(count, _) => (count, 0.0),
            Places::Separate(count, _) => (count, 2.0 * self.radius()),
        };
        let mut members: Vec<Member> = Vec::new();
        for _ in 0..count {
            let mut attempts = 0;
            let centre = loop {
                attempts += 1;
                checked("number of attempts to place a fibre", attempts as f64, 0.0, ATTEMPTS as f64)?;
                let place = [2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0];
                let free = |m: &Member| (m.centre[0] - place[0]).hypot(m.centre[1] - place[1]) >= apart;
                if place[0].hypot(place[1]) <= 1.0 && members.iter().all(free) {
                    break place;
                }
            };
            members.push(Member { centre, tilt: self.tilt(random) });
        }
        Ok(members)
    }

    fn tilt(&self, random: &mut Random) -> [f64; 2] {
        [self.spread * random.normal(), self.spread * random.normal()]
    }

    fn path(&self, bcsdf: &Bcsdf<'_>, theta_o: f64, members: &[Member], random: &mut Random, sums: &mut Sums) {
        // The path comes from ω_o at the azimuth 0, so it travels against it.
        let mut travel = -direction(theta_o, 0.0);
        let offset = 2.0 * random.uniform() - 1.0;
        let mut place = match self.places {
            Places::Medium(_) => [(1.0 - offset * offset).sqrt(), offset],
            _ => [2.0, offset],
        };
        let mut energy = [1.0; 3];
        let mut collisions = 0.0;
        while let Some(meeting) = self.meet(place, travel, members, random) {
            collisions += 1.0;
            let axes = axes(meeting.tilt);
            let wo = Vec3::from_array(axes.map(|axis| axis.dot(-travel))).normalize();
            let window = match self.collision {
                Collision::Near => Window::near(meeting.offset as f32),
                Collision::Far => Window::far(),
            };
            let u = std::array::from_fn(|_| (random.uniform() as f32).min(1.0 - f32::EPSILON / 2.0));
            let Some(sample) = bcsdf.with_hit(wo, window, |hit| hit.sample(u)) else {
                energy = [0.0; 3];
                break;
            };
            energy.iter_mut().zip(sample.weight).for_each(|(e, w)| *e *= f64::from(w));
            travel = (axes[0] * sample.wi.x + axes[1] * sample.wi.y + axes[2] * sample.wi.z).normalize();
            let across = f64::from(travel.y).hypot(travel.z.into()).max(1e-12);
            place = [
                meeting.centre[0] + meeting.radius * f64::from(travel.y) / across,
                meeting.centre[1] + meeting.radius * f64::from(travel.z) / across,
            ];
            let brightest = energy.into_iter().fold(0.0, f64::max);
            if brightest < FAINT {
                if random.uniform() * FAINT >= brightest {
                    energy = [0.0; 3];
                    break;
                }
                energy = energy.map(|e| e * FAINT / brightest);
            }
        }
        if collisions > 0.0 {
            sums.collided += 1.0;
            sums.collisions += collisions;
            sums.profile.add(travel, energy);
        }
    }

    /// The next fibre on the way from `place`.
    fn meet(&self, place: [f64; 2], travel: Vec3, members: &[Member], random: &mut Random) -> Option<Meeting> {
        let across = f64::from(travel.y).hypot(travel.z.into()).max(1e-12);
        let way = [f64::from(travel.y) / across, f64::from(travel.z) / across];
        if let Places::Medium(tau) = self.places {
            let along = place[0] * way[0] + place[1] * way[1];
            let square = place[0] * place[0] + place[1] * place[1];
            let edge = -along + (1.0 - square + along * along).max(0.0).sqrt();
            let free = -2.0 / tau * (1.0 - random.uniform()).ln();
            let centre = [place[0] + free * way[0], place[1] + free * way[1]];
            let offset = 2.0 * random.uniform() - 1.0;
            return (free < edge).then(|| Meeting { centre, offset, tilt: self.tilt(random), radius: 0.0 });
        }
        let radius = self.radius();
        let mut nearest: Option<(f64, &Member, f64)> = None;
        for member in members {
            let to = [member.centre[0] - place[0], member.centre[1] - place[1]];
            let along = to[0] * way[0] + to[1] * way[1];
            // The distance of the centre from the ray, to its left.
            let aside = way[0] * to[1] - way[1] * to[0];
            if along <= 0.0 || aside.abs() >= radius {
                continue;
            }
            let distance = along - (radius * radius - aside * aside).sqrt();
            // A ray that starts inside another fibre is not a new entry.
            if distance > 1e-9 && nearest.is_none_or(|(other, ..)| distance < other) {
                nearest = Some((distance, member, aside));
            }
        }
        // The normal at the hit has the azimuth φ_o − asin h.
        nearest.map(|(_, member, aside)| Meeting {
            centre: member.centre,
            offset: -aside / radius,
            tilt: member.tilt,
            radius,
        })
    }
}

/// The axes of a fibre's frame, in that of the bunch.
fn axes([y, z]: [f64; 2]) -> [Vec3; 3] {
    let x = Vec3::new(1.0, y as f32, z as f32).normalize();
    let side = (Vec3::Y - x * x.y).normalize();
    [x, side, x.cross(side)]
}
