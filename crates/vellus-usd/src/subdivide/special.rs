//! Vertices at creases and corners, and how their rules change from level to level.

use super::level::{Level, blunter};

/// The rule of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// As on a smooth surface. A single sharp edge does not change that: where it ends, the limit is approximate, as in
    /// OpenSubdiv without local refinement (within 3 % of the length of an edge).
    Smooth,
    /// On a curve through these neighbours.
    Crease([u32; 2]),
    /// It does not move.
    Corner,
}

/// A vertex that is not smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Special {
    pub vertex: u32,
    /// Its rule on this level.
    pub kind: Kind,
    /// Its rule on the next level.
    pub after: Kind,
    /// The weight of the first rule against the second one.
    pub weight: f32,
}

/// The vertices of a level that are not smooth, in their order.
pub(super) fn specials(level: &Level) -> Vec<Special> {
    // A vertex, the other end of a sharp edge or the vertex itself, and the sharpness.
    let mut sharp: Vec<(u32, u32, f32)> = Vec::new();
    for (edge, &sharpness) in level.sharpness.iter().enumerate().filter(|(_, s)| **s > 0.0) {
        let [a, b] = level.ends_of(edge);
        if a != b {
            sharp.extend([(a, b, sharpness), (b, a, sharpness)]);
        }
    }
    sharp.extend(level.sharp.iter().map(|&(vertex, sharpness)| (vertex, vertex, sharpness)));
    sharp.sort_unstable_by_key(|&(vertex, other, _)| (vertex, other));
    let groups = sharp.chunk_by(|a, b| a.0 == b.0);
    groups.map(special).filter(|special| special.kind != Kind::Smooth).collect()
}

fn special(around: &[(u32, u32, f32)]) -> Special {
    let kind = |after: fn(f32) -> f32| {
        let mut ends = around.iter().filter(|(_, _, sharpness)| after(*sharpness) > 0.0);
        if ends.clone().any(|(vertex, other, _)| vertex == other) {
            return Kind::Corner;
        }
        match (ends.next(), ends.next(), ends.next()) {
            (Some(a), Some(b), None) => Kind::Crease([a.1, b.1]),
            (Some(_), Some(_), Some(_)) => Kind::Corner,
            _ => Kind::Smooth,
        }
    };
    let (now, after) = (kind(|s| s), kind(blunter));
    // The mean sharpness of what becomes smooth.
    let fading: Vec<f32> = around.iter().map(|a| a.2).filter(|s| blunter(*s) == 0.0).collect();
    let mean = fading.iter().sum::<f32>() / fading.len().max(1) as f32;
    let weight = if now == after { 1.0 } else { mean.min(1.0) };
    Special { vertex: around[0].0, kind: now, after, weight }
}
