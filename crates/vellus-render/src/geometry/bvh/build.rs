//! Builds a hierarchy from the top down by the surface area heuristic over bins (Wald 2007, On Fast Construction of
//! SAH-Based Bounding Volume Hierarchies).
//!
//! The cost of a part counts leaves of eight instead of primitives. This gives fewer and fuller leaves.

use super::{Bounds, Bvh, EMPTY, LEAF, NONE, Node, WIDTH, half_area, join};
use crate::geometry::memory;
use glam::Vec3;
use rayon::prelude::*;

const BINS: usize = 16;

/// One thread builds parts of at most this many primitives.
const TASK: usize = 1 << 14;

/// Below this level, parts are split into halves of equal count. In the worst case, bins would remove only one
/// primitive at a time.
const DEEPEST: usize = 60;

/// The size of a traversal's stack. Each level adds seven siblings. Splitting 2³² primitives into halves adds eleven
/// levels.
pub(super) const STACK: usize = 7 * (DEEPEST + 11) + 8;

#[derive(Clone, Copy)]
struct Primitive {
    low: Vec3,
    high: Vec3,
    index: u32,
}

impl Primitive {
    fn bounds(&self) -> Bounds {
        (self.low, self.high)
    }

    /// Twice its center.
    fn center(&self) -> Vec3 {
        self.low + self.high
    }
}

/// A part of a node, and the box around it.
type Part<'a> = (&'a mut [Primitive], Bounds);

/// Nodes and leaves. Each node is before its children.
#[derive(Default)]
struct Subtree {
    nodes: Vec<Node>,
    leaves: Vec<[u32; WIDTH]>,
}

/// The upper levels, built in parallel.
enum Top {
    Below(Subtree, u32),
    Node(Vec<(Bounds, Top)>),
}

/// Builds a hierarchy over `count` primitives. Also returns the primitives of each leaf, with [`NONE`] for missing
/// ones.
pub(super) fn build(count: usize, bounds: impl Fn(usize) -> Bounds + Sync) -> (Bvh, Vec<[u32; WIDTH]>) {
    let mut primitives: Vec<Primitive> = (0..count)
        .into_par_iter()
        .map(|i| {
            let (low, high) = bounds(i);
            Primitive { low, high, index: i as u32 }
        })
        .collect();
    let all = primitives.par_iter().map(Primitive::bounds).reduce(|| EMPTY, join);
    let top = top((&mut primitives, all), 0);
    drop(primitives);
    let mut tree = Subtree { nodes: memory::with_capacity(top.nodes()), leaves: Vec::new() };
    let root = tree.take(top);
    (Bvh { nodes: tree.nodes, closed: Vec::new(), root }, tree.leaves)
}

fn top(part: Part<'_>, depth: usize) -> Top {
    if part.0.len() <= TASK {
        let mut below = Subtree::default();
        let root = below.grow(part, depth);
        return Top::Below(below, root);
    }
    Top::Node(divide(part, depth).into_par_iter().map(|part| (part.1, top(part, depth + 1))).collect())
}

impl Top {
    fn nodes(&self) -> usize {
        match self {
            Top::Below(tree, _) => tree.nodes.len(),
            Top::Node(children) => 1 + children.iter().map(|(_, top)| top.nodes()).sum::<usize>(),
        }
    }
}

impl Subtree {
    /// The node or leaf of a part.
    fn grow(&mut self, part: Part<'_>, depth: usize) -> u32 {
        if part.0.len() <= WIDTH {
            let mut leaf = [NONE; WIDTH];
            leaf.iter_mut().zip(part.0.iter()).for_each(|(l, p)| *l = p.index);
            self.leaves.push(leaf);
            return (self.leaves.len() - 1) as u32 | LEAF;
        }
        let parts = divide(part, depth);
        let index = self.nodes.len();
        self.nodes.push(Node::new(parts.iter().map(|part| part.1)));
        for (lane, part) in parts.into_iter().enumerate() {
            self.nodes[index].children[lane] = self.grow(part, depth + 1);
        }
        index as u32
    }

    /// Appends the subtrees that were built in parallel.
    fn take(&mut self, top: Top) -> u32 {
        match top {
            Top::Below(tree, root) => {
                let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
                let moved = |child: u32| if child & LEAF == 0 { child + nodes } else { child + leaves };
                self.leaves.extend(tree.leaves);
                self.nodes
                    .extend(tree.nodes.into_iter().map(|node| Node { children: node.children.map(moved), ..node }));
                moved(root)
            }
            Top::Node(children) => {
                let index = self.nodes.len();
                self.nodes.push(Node::new(children.iter().map(|child| child.0)));
                for (lane, (_, child)) in children.into_iter().enumerate() {
                    self.nodes[index].children[lane] = self.take(child);
                }
                index as u32
            }
        }
    }
}

/// The parts of a node. The part with the largest surface is split until there are eight.
fn divide(part: Part<'_>, depth: usize) -> Vec<Part<'_>> {
    let mut parts = Vec::with_capacity(WIDTH);
    parts.push(part);
    while parts.len() < WIDTH {
        let open = (0..parts.len()).filter(|&i| parts[i].0.len() > WIDTH);
        let Some(i) = open.max_by(|&a, &b| half_area(&parts[a].1).total_cmp(&half_area(&parts[b].1))) else { break };
        let (primitives, _) = parts.swap_remove(i);
        let middle = if depth < DEEPEST { split(primitives) } else { None };
        let middle = middle.unwrap_or(primitives.len() / 2);
        let (left, right) = primitives.split_at_mut(middle);
        for part in [left, right] {
            let bounds = part.iter().map(Primitive::bounds).fold(EMPTY, join);
            parts.push((part, bounds));
        }
    }
    parts
}

/// Moves the primitives left of the cheapest plane to the front, and counts them. `None` if all have the same center.
fn split(primitives: &mut [Primitive]) -> Option<usize> {
    let (low, high) = primitives.iter().fold(EMPTY, |b, p| join(b, (p.center(), p.center())));
    let scale = (high - low).to_array().map(|size| if size > 0.0 { BINS as f32 / size } else { 0.0 });
    let scale = Vec3::from_array(scale);
    let bin = |p: &Primitive| ((p.center() - low) * scale).to_array().map(|x| (x as usize).min(BINS - 1));
    let mut bins = [[(EMPTY, 0usize); BINS]; 3];
    for p in primitives.iter() {
        for (axis, bin) in bin(p).into_iter().enumerate() {
            let (bounds, count) = &mut bins[axis][bin];
            *bounds = join(*bounds, p.bounds());
            *count += 1;
        }
    }
    let cost = |(bounds, count): &(Bounds, usize)| half_area(bounds) * count.div_ceil(WIDTH) as f32;
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        let both = |a: (Bounds, usize), b: (Bounds, usize)| (join(a.0, b.0), a.1 + b.1);
        let mut right = [(EMPTY, 0); BINS + 1];
        for k in (0..BINS).rev() {
            right[k] = both(right[k + 1], bins[axis][k]);
        }
        let mut left = (EMPTY, 0);
        for k in 1..BINS {
            left = both(left, bins[axis][k - 1]);
            if left.1 > 0 && right[k].1 > 0 {
                let cost = cost(&left) + cost(&right[k]);
                if best.is_none_or(|best| cost < best.0) {
                    best = Some((cost, axis, k));
                }
            }
        }
    }
    let (_, axis, plane) = best?;
    let mut middle = 0;
    for i in 0..primitives.len() {
        if bin(&primitives[i])[axis] < plane {
            primitives.swap(i, middle);
            middle += 1;
        }
    }
    Some(middle)
}
