//! The inclination of light that collides several times, and what absorption leaves of it.
//!
//! Light that was only in narrow lobes (R, TT, TRT) nearly keeps its inclination. It stays in one lobe with the moments
//! of all its collisions. Other light is followed from node to node of a table of inclinations.

use crate::member::{INCLINATIONS, Member, NARROW, OUTGOING, Roughness, inclination, resolved, width};

/// Numbers of collisions that are followed. After that, light loses the same share at each collision.
const FOLLOWED: usize = 16;

/// What happens to light in one collision, from one inclination to all others. The tilt of the cuticle's scales is not
/// included.
pub(crate) struct Collision {
    /// Shares of light in narrow lobes, for each inclination of the light that comes and each lobe.
    narrow: Vec<[Vec<f64>; NARROW]>,
    /// Other light of each channel, for each inclination of the light that comes.
    broad: Vec<[Vec<f64>; 3]>,
}

/// Light of one channel after k collisions.
#[derive(Clone)]
pub(crate) struct After {
    /// The energy of light that only narrow lobes scattered.
    pub narrow: f64,
    /// The energy of other light, for each inclination ω_i.
    pub broad: Vec<f64>,
}

impl Collision {
    /// From the member's far fields and its roughness.
    pub fn new(members: &[Member], roughness: Roughness) -> Self {
        let lobe = |from: usize, p: usize| {
            let v = members[from.abs_diff(INCLINATIONS - 1)].variance(p, roughness);
            let cell = |k: usize| width(k) * resolved(inclination(k), inclination(from), v);
            let cells: Vec<f64> = (0..OUTGOING).map(cell).collect();
            let sum: f64 = cells.iter().sum();
            cells.into_iter().map(|x| x / sum).collect()
        };
        // Light that travels at the inclination t has ω_o at −t. The table of −ω_o is the mirror image.
        let broad = |from: usize| {
            let node = from.abs_diff(INCLINATIONS - 1);
            [0, 1, 2].map(|channel| {
                let mut light = members[node].broad(channel, inclination(INCLINATIONS - 1 + node), roughness);
                if from >= INCLINATIONS {
                    light.reverse();
                }
                light
            })
        };
        Collision {
            narrow: (0..OUTGOING).map(|from| std::array::from_fn(|p| lobe(from, p))).collect(),
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
        next[start] += member.narrow(channel).iter().sum::<f64>();
        next
    }

    /// The light of one channel after 1, 2, … collisions, [`FOLLOWED`] of them, for ω_o at node `start` ≥ 0.
    fn follow(&self, members: &[Member], start: usize, channel: usize) -> Vec<After> {
        let first = INCLINATIONS - 1 - start;
        let member = &members[start];
        let share: f64 = member.narrow(channel).iter().sum();
        let mut light = vec![After { narrow: share, broad: self.broad[first][channel].clone() }];
        for _ in 1..FOLLOWED {
            let last = &light[light.len() - 1];
            let mut broad: Vec<f64> = self.broad[first][channel].iter().map(|x| x * last.narrow).collect();
            for (from, energy) in last.broad.iter().enumerate() {
                let member = &members[from.abs_diff(INCLINATIONS - 1)];
                let mut add = |row: &[f64], share: f64| {
                    broad.iter_mut().zip(row).for_each(|(sum, x)| *sum += energy * share * x);
                };
                add(&self.broad[from][channel], 1.0);
                self.narrow[from].iter().zip(member.narrow(channel)).for_each(|(row, share)| add(row, share));
            }
            light.push(After { narrow: last.narrow * share, broad });
        }
        light
    }
}

/// The light of one channel after any number of collisions, for one inclination of ω_o.
pub(crate) struct Chain {
    light: Vec<After>,
    /// The share that a collision leaves after the last of `light`.
    ratio: f64,
    /// The same for light in narrow lobes.
    narrow_ratio: f64,
}

impl Chain {
    /// For ω_o at node `start` ≥ 0.
    pub fn new(collision: &Collision, members: &[Member], start: usize, channel: usize) -> Self {
        let light = collision.follow(members, start, channel);
        let energy = |after: &After| after.narrow + after.broad.iter().sum::<f64>();
        let [before, last] = [&light[FOLLOWED - 2], &light[FOLLOWED - 1]].map(energy);
        let ratio = if before > 0.0 { last / before } else { 0.0 };
        Chain { ratio, narrow_ratio: members[start].narrow(channel).iter().sum(), light }
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
        let narrow = last.narrow * left(self.narrow_ratio);
        let scale = ((last.narrow + broad) * left(self.ratio) - narrow).max(0.0) / broad.max(f64::MIN_POSITIVE);
        After { narrow, broad: last.broad.iter().map(|x| x * scale).collect() }
    }
}
