//! A bounding volume hierarchy with eight children per node and up to eight primitives per leaf. One SIMD register
//! holds a coordinate of all eight boxes.
//!
//! If primitives move, each box has one state when the shutter opens and one when it closes. It is interpolated between
//! them.

mod build;

use crate::geometry::memory;
use crate::geometry::ray::Ray;
use arrayvec::ArrayVec;
use glam::Vec3;
use rayon::prelude::*;
use wide::f32x8;

/// Primitives in a leaf, and children of a node.
pub const WIDTH: usize = 8;

/// Marks a missing primitive in a leaf.
pub const NONE: u32 = u32::MAX;

/// The bit of children that are leaves.
pub(crate) const LEAF: u32 = 1 << 31;

/// The lower and the upper corner of a box.
pub type Bounds = (Vec3, Vec3);

/// An empty box. It is finite: infinite corners would give 0 · ∞ for rays parallel to an axis.
pub const EMPTY: Bounds = (Vec3::MAX, Vec3::MIN);

/// The box around two boxes.
pub fn join(a: Bounds, b: Bounds) -> Bounds {
    (a.0.min(b.0), a.1.max(b.1))
}

fn half_area((low, high): &Bounds) -> f32 {
    let d = (*high - *low).max(Vec3::ZERO);
    d.x * d.y + d.y * d.z + d.z * d.x
}

/// Eight boxes: lower and upper x, y and z.
pub(crate) type Boxes = [[f32x8; 3]; 2];

fn boxes(bounds: impl Iterator<Item = Bounds>) -> Boxes {
    let mut all = [[[f32::MAX; WIDTH]; 3], [[f32::MIN; WIDTH]; 3]];
    for (lane, (low, high)) in bounds.enumerate() {
        for k in 0..3 {
            (all[0][k][lane], all[1][k][lane]) = (low[k], high[k]);
        }
    }
    all.map(|corner| corner.map(f32x8::new))
}

/// The box around eight boxes.
fn around(boxes: &Boxes) -> Bounds {
    let low = boxes[0].map(|x| x.to_array().into_iter().fold(f32::MAX, f32::min));
    let high = boxes[1].map(|x| x.to_array().into_iter().fold(f32::MIN, f32::max));
    (low.into(), high.into())
}

/// Eight boxes and their contents.
#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Boxes,
    /// Index of a node, or of a leaf with [`LEAF`]; meaningless if the box is empty.
    children: [u32; WIDTH],
}

impl Node {
    /// A node without its children.
    fn new(bounds: impl Iterator<Item = Bounds>) -> Self {
        Node { bounds: boxes(bounds), children: [LEAF; WIDTH] }
    }
}

/// The hierarchy. It only has the indices of leaves. The caller of [`Bvh::build`] stores their contents.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// The boxes of the nodes when the shutter closes, if anything moves. The nodes contain the boxes when it opens.
    closed: Vec<Boxes>,
    root: u32,
}

impl Bvh {
    /// Builds a hierarchy over `count` boxes. Also returns the primitives of each leaf, with [`NONE`] for missing ones.
    pub fn build(count: usize, bounds: impl Fn(usize) -> Bounds + Sync) -> (Self, Vec<[u32; WIDTH]>) {
        build::build(count, bounds)
    }

    /// Sets the boxes of the leaves for the shutter's opening and closing.
    pub fn set_motion(&mut self, leaf: [&(dyn Fn(usize) -> Bounds + Sync); 2]) {
        let [open, closed] = leaf.map(|leaf| self.fitted(leaf));
        self.nodes.par_iter_mut().zip(open).for_each(|(node, boxes)| node.bounds = boxes);
        self.closed = memory::moved(closed);
    }

    /// The boxes of all nodes, from those of the leaves.
    fn fitted(&self, leaf: &(dyn Fn(usize) -> Bounds + Sync)) -> Vec<Boxes> {
        let child = |node: &Node, lane: usize| {
            let full = node.bounds[0][0].to_array()[lane] <= node.bounds[1][0].to_array()[lane];
            full.then_some(node.children[lane])
        };
        let leaves = |node: &Node| {
            boxes((0..WIDTH).map(|lane| match child(node, lane) {
                Some(child) if child & LEAF != 0 => leaf((child & !LEAF) as usize),
                _ => EMPTY,
            }))
        };
        let mut all: Vec<Boxes> = self.nodes.par_iter().map(leaves).collect();
        // Children come after their node.
        for i in (0..all.len()).rev() {
            for lane in 0..WIDTH {
                if let Some(below) = child(&self.nodes[i], lane).filter(|child| child & LEAF == 0) {
                    let (low, high) = around(&all[below as usize]);
                    for k in 0..3 {
                        all[i][0][k].as_mut_array()[lane] = low[k];
                        all[i][1][k].as_mut_array()[lane] = high[k];
                    }
                }
            }
        }
        all
    }

    /// The boxes of all nodes when the shutter opens and when it closes, and their children.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = ([&Boxes; 2], [u32; WIDTH])> {
        let all = self.nodes.iter().enumerate();
        all.map(|(i, node)| ([&node.bounds, self.closed.get(i).unwrap_or(&node.bounds)], node.children))
    }

    /// The root: a node, or a leaf with [`LEAF`].
    pub(crate) fn root(&self) -> u32 {
        self.root
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.closed[..])
    }

    /// Visits the leaves that a ray may hit, near leaves first. `leaf` gets the index of a leaf and the largest
    /// distance of a hit. It returns the distance of a nearer hit, or the same distance. A negative distance ends the
    /// search. `soon` gets the indices of leaves that will be visited soon, for prefetching.
    #[inline]
    pub fn traverse(&self, ray: &Ray, soon: impl Fn(u32), leaf: impl FnMut(u32, f32) -> f32) {
        if self.closed.is_empty() {
            self.search::<false>(ray, soon, leaf);
        } else {
            self.search::<true>(ray, soon, leaf);
        }
    }

    #[inline]
    fn search<const MOVING: bool>(&self, ray: &Ray, soon: impl Fn(u32), mut leaf: impl FnMut(u32, f32) -> f32) {
        let splat = f32x8::splat;
        let d = ray.direction.to_array();
        // Replaces 0 in the direction by a tiny number, which avoids 0/0.
        let inverse = d.map(|d| 1.0 / if d.abs() < 1e-20 { 1e-20f32.copysign(d) } else { d });
        let origin = ray.origin.to_array();
        let shift: [f32x8; 3] = std::array::from_fn(|k| splat(-origin[k] * inverse[k]));
        let near: [usize; 3] = d.map(|d| usize::from(d.is_sign_negative()));
        let inverse = inverse.map(splat);
        let (early, late) = (splat(1.0 - ray.time), splat(ray.time));
        let mut t_max = ray.t_max;
        let mut stack = ArrayVec::<u64, { build::STACK }>::new();
        let mut current = self.root;
        loop {
            if current & LEAF != 0 {
                t_max = leaf(current & !LEAF, t_max);
                if t_max < 0.0 {
                    return;
                }
            } else {
                let node = &self.nodes[current as usize];
                let between;
                let bounds = if MOVING {
                    let closed = &self.closed[current as usize];
                    between = std::array::from_fn(|i| {
                        std::array::from_fn(|k| node.bounds[i][k].mul_add(early, closed[i][k] * late))
                    });
                    &between
                } else {
                    &node.bounds
                };
                let mut enter = f32x8::ZERO;
                let mut leave = splat(t_max);
                for k in 0..3 {
                    let first = bounds[near[k]][k].mul_add(inverse[k], shift[k]);
                    let last = bounds[1 - near[k]][k].mul_add(inverse[k], shift[k]);
                    enter = enter.fast_max(first);
                    leave = leave.fast_min(last);
                }
                // Allows for rounding errors of the slabs (Ize 2013, Robust BVH Ray Traversal).
                let hit = enter.simd_le(leave * splat(1.000_000_5));
                let mut mask = hit.to_bitmask();
                if mask != 0 {
                    // Distance and child are packed into one number, to compare and move both at once. Distances are
                    // not negative, so their bits have the same order.
                    let distances = enter.to_array();
                    let mut next = || {
                        let i = mask.trailing_zeros() as usize & (WIDTH - 1);
                        mask &= mask - 1;
                        (u64::from(distances[i].to_bits()) << 32 | u64::from(node.children[i]), mask != 0)
                    };
                    let (mut nearest, mut more) = next();
                    // Usually there is only one hit.
                    if !more {
                        current = nearest as u32;
                        continue;
                    }
                    self.fetch(nearest as u32, &soon);
                    let base = stack.len();
                    while more {
                        let entry;
                        (entry, more) = next();
                        self.fetch(entry as u32, &soon);
                        // Insertion sort.
                        stack.push(entry.max(nearest));
                        nearest = entry.min(nearest);
                        let mut place = stack.len() - 1;
                        while place > base && stack[place - 1] < stack[place] {
                            stack.swap(place - 1, place);
                            place -= 1;
                        }
                    }
                    current = nearest as u32;
                    continue;
                }
            }
            current = loop {
                match stack.pop() {
                    None => return,
                    Some(entry) if f32::from_bits((entry >> 32) as u32) <= t_max => break entry as u32,
                    Some(_) => {}
                }
            };
        }
    }

    /// Prefetches a child that will be visited soon.
    #[inline(always)]
    fn fetch(&self, child: u32, soon: &impl Fn(u32)) {
        if child & LEAF == 0 {
            memory::fetch(&self.nodes[child as usize]);
        } else {
            soon(child & !LEAF);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thousands of equal boxes are all found.
    #[test]
    fn boxes_may_coincide() {
        let (bvh, leaves) = Bvh::build(5000, |_| (Vec3::ZERO, Vec3::ONE));
        assert_eq!(leaves.iter().flatten().filter(|&&p| p != NONE).count(), 5000);
        let mut seen = 0;
        let ray = Ray::new(Vec3::new(0.5, 0.5, -1.0), Vec3::Z);
        bvh.traverse(
            &ray,
            |_| {},
            |_, t_max| {
                seen += 1;
                t_max
            },
        );
        assert!(seen * WIDTH >= 5000);
    }

    /// Every leaf whose box a ray hits is visited, and each primitive is in exactly one leaf.
    #[test]
    fn traversal_finds_all_boxes() {
        let noise = |i: usize, k: u32| (i as f32 * 12.9898 + k as f32 * 78.233).sin().rem_euclid(1.0);
        let boxes: Vec<Bounds> = (0..5000)
            .map(|i| {
                let low = Vec3::new(noise(i, 1), noise(i, 2), noise(i, 3));
                (low, low + 0.02 * Vec3::new(noise(i, 4), noise(i, 5), noise(i, 6)))
            })
            .collect();
        let (bvh, leaves) = Bvh::build(boxes.len(), |i| boxes[i]);
        let mut all: Vec<u32> = leaves.iter().flatten().copied().filter(|&p| p != NONE).collect();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..5000));
        let slab = |ray: &Ray, (low, high): Bounds| {
            let (a, b) = ((low - ray.origin) / ray.direction, (high - ray.origin) / ray.direction);
            a.min(b).max_element().max(0.0) <= a.max(b).min_element()
        };
        for i in 0..200 {
            let origin = Vec3::new(noise(i, 7), noise(i, 8), noise(i, 9)) * 3.0 - 1.0;
            let target = Vec3::new(noise(i, 10), noise(i, 11), noise(i, 12));
            let ray = Ray::new(origin, (target - origin).normalize());
            let mut found: Vec<u32> = Vec::new();
            bvh.traverse(
                &ray,
                |_| {},
                |leaf, t_max| {
                    found.extend(leaves[leaf as usize].iter().filter(|&&p| p != NONE && slab(&ray, boxes[p as usize])));
                    t_max
                },
            );
            found.sort_unstable();
            let expected: Vec<u32> = (0..5000u32).filter(|&p| slab(&ray, boxes[p as usize])).collect();
            assert_eq!(found, expected);
        }
    }

    /// Moving boxes are found at any time.
    #[test]
    fn traversal_finds_moving_boxes() {
        let noise = |i: usize, k: u32| (i as f32 * 12.9898 + k as f32 * 78.233).sin().rem_euclid(1.0);
        let place = |i: usize, time: f32| -> Bounds {
            let low = Vec3::new(noise(i, 1), noise(i, 2), noise(i, 3));
            let way = Vec3::new(noise(i, 4), noise(i, 5), noise(i, 6)) - 0.5;
            (low + way * time, low + way * time + 0.02 * (1.0 + time))
        };
        let (mut bvh, leaves) = Bvh::build(3000, |i| place(i, 0.5));
        let leaf = |time: f32| {
            let leaves = &leaves;
            let all = move |l: usize| leaves[l].iter().filter(|&&p| p != NONE).map(move |&p| place(p as usize, time));
            move |l: usize| all(l).fold(EMPTY, join)
        };
        bvh.set_motion([&leaf(0.0), &leaf(1.0)]);
        let mut met = 0;
        for i in 0..300 {
            let origin = Vec3::new(noise(i, 7), noise(i, 8), noise(i, 9)) * 3.0 - 1.0;
            let target = Vec3::new(noise(i, 10), noise(i, 11), noise(i, 12));
            let ray = Ray { time: (i % 11) as f32 / 10.0, ..Ray::new(origin, (target - origin).normalize()) };
            let slab = |(low, high): Bounds| {
                let (a, b) = ((low - ray.origin) / ray.direction, (high - ray.origin) / ray.direction);
                a.min(b).max_element().max(0.0) <= a.max(b).min_element()
            };
            let mut found = vec![false; 3000];
            bvh.traverse(
                &ray,
                |_| {},
                |leaf, t_max| {
                    leaves[leaf as usize].iter().filter(|&&p| p != NONE).for_each(|&p| found[p as usize] = true);
                    t_max
                },
            );
            for p in (0..3000).filter(|&p| slab(place(p, ray.time))) {
                met += 1;
                assert!(found[p], "ray {i} misses box {p}");
            }
        }
        assert!(met > 100);
    }
}
