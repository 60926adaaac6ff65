//! The inclination of light that collides several times, and what absorption leaves of it.
//!
//! Light that no medulla has scattered keeps its inclination up to the widths of the specular lobes. Its distribution
//! is one lobe with the moments of all collisions. Other light is followed from node to node of a table of inclinations.

use crate::longitudinal::density;
use crate::member::{INCLINATIONS, Member, OUTGOING, SPECULAR, inclination, width};

/// Numbers of collisions that are followed. After that, light loses the same share at each collision.
const FOLLOWED: usize = 16;

/// The narrowest lobe that the table of inclinations resolves, in radians: 0.7 steps of 5°.
const NARROWEST: f64 = 0.061;

/// What happens to light in one collision, from one inclination to all others. The tilt of the cuticle's scales is not
/// included.
pub(crate) struct Collision {
    /// Shares of specular light, for each inclination of the light that comes and each lobe.
    specular: Vec<[Vec<f64>; 4]>,
    /// Other light of each channel, for each inclination of the light that comes.
    broad: Vec<[Vec<f64>; 3]>,
}

/// Light of one channel after k collisions.
#[derive(Clone)]
pub(crate) struct After {
    /// The energy of light that no medulla scattered.
    pub specular: f64,
    /// The energy of other light, for each inclination ω_i.
    pub broad: Vec<f64>,
}

impl Collision {
    /// From the members' far fields and their longitudinal roughness in radians.
    pub fn new(members: &[Member], beta_m: f64) -> Self {
        let shares = |values: Vec<f64>| {
            let sum: f64 = values.iter().sum();
            values.into_iter().map(|x| x / sum).collect::<Vec<f64>>()
        };
        let lobe = |from: usize, factor: f64| {
            let v = (factor * beta_m).max(NARROWEST).powi(2);
            shares((0..OUTGOING).map(|k| width(k) * density(inclination(k), inclination(from), v)).collect())
        };
        // Light that travels at the inclination t has ω_o at −t.
        let broad = |from: usize| {
            let member = &members[from.abs_diff(INCLINATIONS - 1)];
            [0, 1, 2].map(|channel| {
                let mut light = member.broad_shares(channel);
                if from >= INCLINATIONS {
                    light.reverse();
                }
                light
            })
        };
        Collision {
            specular: (0..OUTGOING).map(|from| SPECULAR.map(|(_, _, factor)| lobe(from, factor))).collect(),
            broad: (0..OUTGOING).map(broad).collect(),
        }
    }

    /// The energy of one channel after a collision, for each inclination |θ| of a next collision's ω_o.
    pub fn next(&self, members: &[Member], start: usize, channel: usize) -> Vec<f64> {
        let member = &members[start];
        let mut next = vec![0.0; INCLINATIONS];
        for (k, energy) in self.broad[INCLINATIONS - 1 - start][channel].iter().enumerate() {
            next[k.abs_diff(INCLINATIONS - 1)] += energy;
        }
        next[start] += member.specular(channel).iter().sum::<f64>();
        next
    }

    /// The light of one channel after 1, 2, … collisions, [`FOLLOWED`] of them, for ω_o at node `start` ≥ 0.
    fn follow(&self, members: &[Member], start: usize, channel: usize) -> Vec<After> {
        let first = INCLINATIONS - 1 - start;
        let member = &members[start];
        let share: f64 = member.specular(channel).iter().sum();
        let mut light = vec![After { specular: share, broad: self.broad[first][channel].clone() }];
        for _ in 1..FOLLOWED {
            let last = &light[light.len() - 1];
            let mut broad: Vec<f64> = self.broad[first][channel].iter().map(|x| x * last.specular).collect();
            for (from, energy) in last.broad.iter().enumerate() {
                let member = &members[from.abs_diff(INCLINATIONS - 1)];
                let mut add = |row: &[f64], share: f64| {
                    broad.iter_mut().zip(row).for_each(|(sum, x)| *sum += energy * share * x);
                };
                add(&self.broad[from][channel], 1.0);
                self.specular[from].iter().zip(member.specular(channel)).for_each(|(row, share)| add(row, share));
            }
            light.push(After { specular: last.specular * share, broad });
        }
        light
    }
}

/// The light of one channel after any number of collisions, for one inclination of ω_o.
pub(crate) struct Chain {
    light: Vec<After>,
    /// The share that a collision leaves after the last of `light`.
    ratio: f64,
    /// The same for light that no medulla scattered.
    specular_ratio: f64,
}

impl Chain {
    /// For ω_o at node `start` ≥ 0.
    pub fn new(collision: &Collision, members: &[Member], start: usize, channel: usize) -> Self {
        let light = collision.follow(members, start, channel);
        let energy = |after: &After| after.specular + after.broad.iter().sum::<f64>();
        let [before, last] = [&light[FOLLOWED - 2], &light[FOLLOWED - 1]].map(energy);
        let ratio = if before > 0.0 { last / before } else { 0.0 };
        Chain { ratio, specular_ratio: members[start].specular(channel).iter().sum(), light }
    }

    /// The light after `collisions` ≥ 1. If all of it is scattered more often, with shares that fall by `falling` for
    /// each further collision, this is the mean over those.
    pub fn after(&self, collisions: usize, falling: Option<f64>) -> After {
        if let (Some(after), None) = (self.light.get(collisions - 1), falling) {
            return after.clone();
        }
        let last = &self.light[FOLLOWED - 1];
        let more = collisions.saturating_sub(FOLLOWED) as i32;
        let left = |ratio: f64| {
            let sum = falling.map_or(1.0, |share| ratio * (1.0 - share) / (1.0 - share * ratio).max(f64::MIN_POSITIVE));
            ratio.powi(more) * sum
        };
        let broad: f64 = last.broad.iter().sum();
        let specular = last.specular * left(self.specular_ratio);
        let scale = ((last.specular + broad) * left(self.ratio) - specular).max(0.0) / broad.max(f64::MIN_POSITIVE);
        After { specular, broad: last.broad.iter().map(|x| x * scale).collect() }
    }
}
