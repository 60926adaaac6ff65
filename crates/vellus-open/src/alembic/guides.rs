//! Guides: they are no hair, and hair without motion follows those that its file names for it.

use super::shape::Shape;
use glam::Vec3;
use std::collections::HashMap;
use vellus_alembic::Attribute;
use vellus_scene::Strands;

/// Attributes of hair: the numbers of its guides, and their weights.
pub(super) const BOUND: [&str; 2] = ["groom_closest_guides", "groom_guide_weights"];
/// The number of a strand, by which hair names guides.
pub(super) const ID: &str = "groom_id";

/// Guides, and where they are without motion.
pub(super) struct Guides {
    pub strands: Strands,
    /// The number of each guide.
    pub ids: Vec<i64>,
    /// Its points at the first sample, by the transforms of both times; `None` if it does not move.
    pub rest: Option<[Vec<Vec3>; 2]>,
}

/// The guides of the strands of a set, and their weights.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bound(Vec<[(i64, f32); 3]>);

impl Bound {
    /// The guides that the attributes of an object name. `None` if they do not fit.
    pub fn new(shape: &Shape, guides: &Attribute, weights: Option<&Attribute>) -> Option<Self> {
        let rows = shape.rows_of_roots(guides.rows())?;
        let weights = match weights {
            Some(weights) => Some((weights, shape.rows_of_roots(weights.rows())?)),
            None => None,
        };
        let of = |strand: usize| {
            std::array::from_fn(|lane| {
                let id = guides.number(rows[strand], lane);
                let weight = match &weights {
                    Some((weights, rows)) => weights.number(rows[strand], lane).unwrap_or(0.0),
                    None => 1.0,
                };
                let weight = if weight.is_finite() { weight.max(0.0) as f32 } else { 0.0 };
                id.map_or((0, 0.0), |id| (id as i64, weight))
            })
        };
        Some(Bound((0..rows.len()).map(of).collect()))
    }

    /// The rows of some of the strands.
    pub fn select(&self, is_own: impl Fn(usize) -> bool) -> Self {
        Bound((0..self.0.len()).filter(|strand| is_own(*strand)).map(|strand| self.0[strand]).collect())
    }

    /// Moves strands as their guides move: at each share of their lengths, by the weighted mean of the guides' motion
    /// since the first sample. Strands whose guides the file does not have stay. Returns how many strands that are.
    pub fn follow(&self, hair: &mut Strands, all: &[Guides]) -> usize {
        let mut known = HashMap::new();
        for (set, guides) in all.iter().enumerate() {
            for (strand, id) in guides.ids.iter().enumerate() {
                known.entry(*id).or_insert((set, strand));
            }
        }
        let is_blurred = all.iter().any(|guides| guides.rest.is_some() && guides.strands.moved.is_some());
        let mut moved = match (&hair.moved, is_blurred) {
            (Some(moved), _) => Some(moved.clone()),
            (None, true) => Some(hair.points.iter().map(|p| p.truncate()).collect::<Vec<_>>()),
            (None, false) => None,
        };
        let mut lost = 0;
        for (strand, bound) in self.0.iter().enumerate() {
            let own: Vec<_> =
                bound.iter().filter(|(_, w)| *w > 0.0).filter_map(|(id, w)| Some((known.get(id)?, *w))).collect();
            let total: f32 = own.iter().map(|(_, weight)| weight).sum();
            if total <= 0.0 {
                lost += 1;
                continue;
            }
            let points = hair.starts[strand] as usize..hair.starts[strand + 1] as usize;
            let (first, last) = (points.start, points.len().saturating_sub(1).max(1));
            for point in points {
                let share = (point - first) as f32 / last as f32;
                let mut shift = [Vec3::ZERO; 2];
                for ((set, guide), weight) in &own {
                    let motion = all[*set].motion(*guide, share);
                    for (shift, motion) in shift.iter_mut().zip(motion) {
                        *shift += motion * (weight / total);
                    }
                }
                hair.points[point] += shift[0].extend(0.0);
                if let Some(moved) = &mut moved {
                    moved[point] += shift[1];
                }
            }
        }
        hair.moved = moved;
        lost
    }
}

impl Guides {
    /// How far a guide has moved when the shutter opens and closes, at a share of its points.
    fn motion(&self, guide: usize, share: f32) -> [Vec3; 2] {
        let Some(rest) = &self.rest else { return [Vec3::ZERO; 2] };
        let (start, end) = (self.strands.starts[guide] as usize, self.strands.starts[guide + 1] as usize);
        let at = share * (end - start - 1) as f32;
        let (i, t) = (start + at as usize, at.fract());
        let j = (i + 1).min(end - 1);
        let open = |i: usize| self.strands.points[i].truncate();
        let close = |i: usize| self.strands.moved.as_ref().map_or(open(i), |moved| moved[i]);
        [(open(i) - rest[0][i]).lerp(open(j) - rest[0][j], t), (close(i) - rest[1][i]).lerp(close(j) - rest[1][j], t)]
    }
}
