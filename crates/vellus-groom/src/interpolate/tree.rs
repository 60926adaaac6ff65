//! The nearest of many points: a k-d tree.

use glam::Vec3;

/// Points that a search looks at, at most. Only a search that rejects nearly all points comes to its end.
const MOST: usize = 4096;

/// A balanced tree: the middle of a slice of `order` divides it, along the axis of its depth.
pub(crate) struct Tree<'a> {
    points: &'a [Vec3],
    order: Vec<u32>,
}

/// A search for the points that are nearest to `at`.
struct Search<'a> {
    tree: &'a Tree<'a>,
    at: Vec3,
    count: usize,
    fits: &'a dyn Fn(usize) -> bool,
    seen: usize,
    /// Squared distances and indices, nearest first.
    found: Vec<(f32, u32)>,
}

impl<'a> Tree<'a> {
    pub fn new(points: &'a [Vec3]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        divide(&mut order, points, 0);
        Tree { points, order }
    }

    /// Up to `count` ≥ 1 of the points that are nearest to point `i`, without those at the same place, nearest first.
    /// Only points for which `fits` is true count.
    pub fn nearest(&self, i: usize, count: usize, fits: &dyn Fn(usize) -> bool) -> Vec<usize> {
        let mut search = Search { tree: self, at: self.points[i], count, fits, seen: 0, found: Vec::new() };
        search.visit(&self.order, 0);
        search.found.into_iter().map(|(_, j)| j as usize).collect()
    }
}

fn divide(order: &mut [u32], points: &[Vec3], axis: usize) {
    if order.len() > 1 {
        let middle = order.len() / 2;
        let along = |i: &u32| points[*i as usize][axis];
        order.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
        let (low, high) = order.split_at_mut(middle);
        divide(low, points, (axis + 1) % 3);
        divide(&mut high[1..], points, (axis + 1) % 3);
    }
}

impl Search<'_> {
    fn visit(&mut self, order: &[u32], axis: usize) {
        if order.is_empty() || self.seen >= MOST {
            return;
        }
        let (low, rest) = order.split_at(order.len() / 2);
        let (index, high) = (rest[0], &rest[1..]);
        let point = self.tree.points[index as usize];
        let distance = point.distance_squared(self.at);
        self.seen += 1;
        if distance > 0.0 && (self.fits)(index as usize) {
            let place = self.found.partition_point(|found| *found < (distance, index));
            self.found.insert(place, (distance, index));
            self.found.truncate(self.count);
        }
        let beyond = self.at[axis] - point[axis];
        let (first, second) = if beyond < 0.0 { (low, high) } else { (high, low) };
        self.visit(first, (axis + 1) % 3);
        if self.found.len() < self.count || self.found.last().is_some_and(|found| beyond * beyond <= found.0) {
            self.visit(second, (axis + 1) % 3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn the_tree_finds_what_a_search_of_all_points_finds() {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(1);
        // Two heaps, one of them much denser, and three points at one place.
        let mut points: Vec<Vec3> = (0..300)
            .map(|i| {
                let at = Vec3::from_array(std::array::from_fn(|_| rng.random::<f32>()));
                if i < 200 { 0.01 * at } else { 5.0 + at }
            })
            .collect();
        points.extend([Vec3::ONE; 3]);
        let tree = Tree::new(&points);
        for i in (0..points.len()).step_by(7).chain([301]) {
            let mut all: Vec<usize> = (0..points.len()).filter(|&j| points[j] != points[i] && j % 3 != 0).collect();
            all.sort_by(|&a, &b| points[a].distance(points[i]).total_cmp(&points[b].distance(points[i])));
            all.truncate(9);
            assert_eq!(tree.nearest(i, 9, &|j| j % 3 != 0), all, "{i}");
        }
    }
}
