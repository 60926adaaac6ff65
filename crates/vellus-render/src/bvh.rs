//! A bounding volume hierarchy of eight children a node, over leaves of up to eight primitives.
//!
//! Built by parallel locally-ordered clustering (Meister and Bittner 2018; crate obvhs) as a binary tree, of which
//! every subtree of at most eight primitives becomes a leaf, and every node takes in its largest
//! descendants until it has eight children. One register holds a coordinate of all eight boxes.

use crate::memory;
use crate::ray::Ray;
use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use wide::f32x8;

/// Primitives a leaf has room for.
pub const WIDTH: usize = 8;

/// A child that is a leaf has this bit; without children's boxes it is empty.
const LEAF: u32 = 1 << 31;

/// Levels after which what is left is divided evenly: clustering makes a tree as deep as it likes of boxes that are all the same.
const DEEPEST: usize = 60;

/// What a traversal's stack must hold: seven siblings a level, of which even division of 2³² primitives adds eleven.
const STACK: usize = 7 * (DEEPEST + 11) + 8;

/// Eight boxes and what is in them.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Least and largest coordinates: x, y, z.
    bounds: [[f32x8; 3]; 2],
    /// Index of a node, or of a leaf with [`LEAF`].
    children: [u32; WIDTH],
}

/// The hierarchy. Leaves are numbered; what is in them belongs to who built it.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    root: u32,
}

/// The least and the largest corner of a box.
pub type Bounds = (Vec3, Vec3);

impl Bvh {
    /// Builds it over boxes; `leaf` is called with the primitives of each new leaf, numbered from 0.
    pub fn build(boxes: &[Bounds], mut leaf: impl FnMut(&[u32])) -> Self {
        if boxes.is_empty() {
            leaf(&[]);
            return Bvh { nodes: Vec::new(), root: LEAF };
        }
        let aabbs: Vec<Aabb> = boxes.iter().map(|&(low, high)| Aabb::new(low.into(), high.into())).collect();
        let indices = (0..boxes.len() as u32).collect();
        let tree = PlocBuilder::new().build(PlocSearchDistance::Low, &aabbs, indices, SortPrecision::U64, 0);
        drop(aabbs);
        let mut builder = Builder { boxes, counts: counts(&tree), tree, nodes: Vec::new(), leaves: 0 };
        let root = builder.collapse(0, 0, &mut leaf);
        Bvh { nodes: memory::moved(builder.nodes), root }
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>()
    }

    /// Visits the leaves a ray may meet, near ones first. `leaf` gets the number of a leaf and the distance up to
    /// which anything matters, and returns that distance, smaller if it found something; a negative one ends the
    /// search.
    #[inline]
    pub fn traverse(&self, ray: &Ray, soon: impl Fn(u32), mut leaf: impl FnMut(u32, f32) -> f32) {
        let splat = f32x8::splat;
        let d = ray.direction.to_array();
        // A direction's zero becomes tiny: 0/0 never arises.
        let inverse = d.map(|d| 1.0 / if d.abs() < 1e-20 { 1e-20f32.copysign(d) } else { d });
        let origin = ray.origin.to_array();
        let shift: [f32x8; 3] = std::array::from_fn(|k| splat(-origin[k] * inverse[k]));
        let near: [usize; 3] = d.map(|d| usize::from(d.is_sign_negative()));
        let inverse = inverse.map(splat);
        let mut limit = ray.limit;
        let mut stack = [(0u32, 0f32); STACK];
        let mut top = 0;
        let mut current = self.root;
        loop {
            if current & LEAF != 0 {
                limit = leaf(current & !LEAF, limit);
                if limit < 0.0 {
                    return;
                }
            } else {
                let node = &self.nodes[current as usize];
                let mut enter = f32x8::ZERO;
                let mut leave = splat(limit);
                for k in 0..3 {
                    let first = node.bounds[near[k]][k].mul_add(inverse[k], shift[k]);
                    let last = node.bounds[1 - near[k]][k].mul_add(inverse[k], shift[k]);
                    enter = enter.fast_max(first);
                    leave = leave.fast_min(last);
                }
                // A few roundings of the slabs, as Ize 2013, Robust BVH Ray Traversal.
                let hit = enter.simd_le(leave * splat(1.000_000_5));
                let mut mask = hit.to_bitmask();
                if mask != 0 {
                    let distances = enter.to_array();
                    let mut next = || {
                        let i = mask.trailing_zeros() as usize & (WIDTH - 1);
                        mask &= mask - 1;
                        ((node.children[i], distances[i]), mask != 0)
                    };
                    let (mut nearest, mut more) = next();
                    // Mostly there is one.
                    if !more {
                        current = nearest.0;
                        continue;
                    }
                    self.fetch(nearest.0, &soon);
                    let base = top;
                    while more {
                        let mut entry;
                        (entry, more) = next();
                        self.fetch(entry.0, &soon);
                        if entry.1 < nearest.1 {
                            std::mem::swap(&mut entry, &mut nearest);
                        }
                        // Sorted as they come.
                        let mut place = top;
                        while place > base && stack[place - 1].1 < entry.1 {
                            stack[place] = stack[place - 1];
                            place -= 1;
                        }
                        stack[place] = entry;
                        top += 1;
                    }
                    current = nearest.0;
                    continue;
                }
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                if stack[top].1 <= limit {
                    break;
                }
            }
            current = stack[top].0;
        }
    }

    /// Has a child fetched that will be visited soon.
    #[inline(always)]
    fn fetch(&self, child: u32, soon: &impl Fn(u32)) {
        if child & LEAF == 0 {
            memory::fetch(&self.nodes[child as usize]);
        } else {
            soon(child & !LEAF);
        }
    }
}

/// Primitives below each node of a binary tree.
fn counts(tree: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0u32; tree.nodes.len()];
    let mut stack = vec![(0usize, false)];
    while let Some((i, below)) = stack.pop() {
        let node = &tree.nodes[i];
        if node.is_leaf() {
            counts[i] = node.prim_count;
        } else if below {
            counts[i] = counts[node.first_index as usize] + counts[node.first_index as usize + 1];
        } else {
            stack.extend([(i, true), (node.first_index as usize, false), (node.first_index as usize + 1, false)]);
        }
    }
    counts
}

struct Builder<'a> {
    boxes: &'a [Bounds],
    tree: Bvh2,
    counts: Vec<u32>,
    nodes: Vec<Node>,
    leaves: u32,
}

impl Builder<'_> {
    /// The wide node or leaf that stands for binary node `i`.
    fn collapse(&mut self, i: usize, depth: usize, leaf: &mut impl FnMut(&[u32])) -> u32 {
        if self.counts[i] as usize <= WIDTH || depth >= DEEPEST {
            let mut primitives = Vec::with_capacity(WIDTH);
            self.gather(i, &mut primitives);
            return self.divide(&primitives, leaf);
        }
        // Open the largest box until there are eight.
        let mut children = vec![i];
        while children.len() < WIDTH {
            let area = |&i: &usize| self.tree.nodes[i].aabb().half_area();
            let opens = children.iter().enumerate().filter(|&(_, &c)| self.counts[c] as usize > WIDTH);
            let Some((k, &c)) = opens.max_by(|a, b| area(a.1).total_cmp(&area(b.1))) else { break };
            let first = self.tree.nodes[c].first_index as usize;
            children[k] = first;
            children.push(first + 1);
        }
        let boxes = children.iter().map(|&c| {
            let aabb = self.tree.nodes[c].aabb();
            (aabb.min.into(), aabb.max.into())
        });
        let index = self.node(&boxes.collect::<Vec<_>>());
        for (lane, c) in children.into_iter().enumerate() {
            let child = self.collapse(c, depth + 1, leaf);
            self.nodes[index].children[lane] = child;
        }
        index as u32
    }

    /// A new node over up to eight boxes, its children still to be set.
    fn node(&mut self, boxes: &[Bounds]) -> usize {
        let mut bounds = [[[f32::INFINITY; WIDTH]; 3], [[f32::NEG_INFINITY; WIDTH]; 3]];
        for (lane, (low, high)) in boxes.iter().enumerate() {
            for k in 0..3 {
                (bounds[0][k][lane], bounds[1][k][lane]) = (low[k], high[k]);
            }
        }
        self.nodes.push(Node { bounds: bounds.map(|b| b.map(f32x8::new)), children: [LEAF; WIDTH] });
        self.nodes.len() - 1
    }

    /// A leaf or, of more than that holds, nodes over equal parts.
    fn divide(&mut self, primitives: &[u32], leaf: &mut impl FnMut(&[u32])) -> u32 {
        if primitives.len() <= WIDTH {
            leaf(primitives);
            self.leaves += 1;
            return (self.leaves - 1) | LEAF;
        }
        let parts: Vec<&[u32]> = primitives.chunks(primitives.len().div_ceil(WIDTH)).collect();
        let around = |part: &&[u32]| {
            part.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| {
                let (a, b) = self.boxes[p as usize];
                (low.min(a), high.max(b))
            })
        };
        let boxes: Vec<Bounds> = parts.iter().map(around).collect();
        let index = self.node(&boxes);
        for (lane, part) in parts.into_iter().enumerate() {
            let child = self.divide(part, leaf);
            self.nodes[index].children[lane] = child;
        }
        index as u32
    }

    fn gather(&self, i: usize, primitives: &mut Vec<u32>) {
        let mut stack = vec![i];
        while let Some(i) = stack.pop() {
            let node = &self.tree.nodes[i];
            let first = node.first_index as usize;
            if node.is_leaf() {
                primitives.extend(&self.tree.primitive_indices[first..first + node.prim_count as usize]);
            } else {
                stack.extend([first + 1, first]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thousands of boxes in one place are found as well.
    #[test]
    fn boxes_may_coincide() {
        let mut leaves = 0;
        let boxes = vec![(Vec3::ZERO, Vec3::ONE); 5000];
        let bvh = Bvh::build(&boxes, |primitives| leaves += primitives.len());
        assert_eq!(leaves, 5000);
        let mut seen = 0;
        bvh.traverse(&Ray::new(Vec3::new(0.5, 0.5, -1.0), Vec3::Z), |_| {}, |_, limit| {
            seen += 1;
            limit
        });
        assert!(seen * WIDTH >= 5000);
    }

    /// Every leaf whose box a ray meets is visited, and each primitive is in one leaf.
    #[test]
    fn traversal_finds_all_boxes() {
        let noise = |i: usize, k: u32| (i as f32 * 12.9898 + k as f32 * 78.233).sin().rem_euclid(1.0);
        let boxes: Vec<Bounds> = (0..5000)
            .map(|i| {
                let low = Vec3::new(noise(i, 1), noise(i, 2), noise(i, 3));
                (low, low + 0.02 * Vec3::new(noise(i, 4), noise(i, 5), noise(i, 6)))
            })
            .collect();
        let mut leaves: Vec<Vec<u32>> = Vec::new();
        let bvh = Bvh::build(&boxes, |primitives| leaves.push(primitives.to_vec()));
        let mut all: Vec<u32> = leaves.iter().flatten().copied().collect();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..5000) && leaves.iter().all(|l| l.len() <= WIDTH));
        let slab = |ray: &Ray, (low, high): Bounds| {
            let (a, b) = ((low - ray.origin) / ray.direction, (high - ray.origin) / ray.direction);
            a.min(b).max_element().max(0.0) <= a.max(b).min_element()
        };
        for i in 0..200 {
            let origin = Vec3::new(noise(i, 7), noise(i, 8), noise(i, 9)) * 3.0 - 1.0;
            let target = Vec3::new(noise(i, 10), noise(i, 11), noise(i, 12));
            let ray = Ray::new(origin, (target - origin).normalize());
            let mut found: Vec<u32> = Vec::new();
            bvh.traverse(&ray, |_| {}, |leaf, limit| {
                found.extend(leaves[leaf as usize].iter().filter(|&&p| slab(&ray, boxes[p as usize])));
                limit
            });
            found.sort_unstable();
            let expected: Vec<u32> = (0..5000u32).filter(|&p| slab(&ray, boxes[p as usize])).collect();
            assert_eq!(found, expected);
        }
    }
}
