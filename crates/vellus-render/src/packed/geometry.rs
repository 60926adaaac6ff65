//! Strands, meshes and instances.

use super::{Lacking, NONE, PackedScene, STACK};
use crate::geometry::bvh::{Bvh, LEAF};
use crate::geometry::curves::Curves;
use crate::geometry::triangles::Triangles;
use crate::integrator::geometry::Geometry;
use std::collections::HashMap;
use vellus::{Fiber, Parameter};
use vellus_scene::{Basis, Strands, Values};
use wide::f32x8;

/// In place of a record: the strands have one for each control point.
const PER_POINT: u32 = NONE - 1;

/// Rows of the header.
pub(super) struct Places {
    /// The roots of strands, meshes and instances in world space, and the number of instances.
    pub roots: [u32; 4],
    /// The number of sets of strands and of meshes, and their rows.
    pub sets: [u32; 4],
    /// The rows of the instances, and of their leaves.
    pub instances: [u32; 4],
    /// The distances in rows of nodes, chords, triangles and points when the shutter closes.
    pub closed: [u32; 4],
}

/// The roots of one object.
#[derive(Clone, Copy)]
struct Roots {
    curves: u32,
    triangles: u32,
}

/// The numbers of what was packed before.
#[derive(Default)]
struct Before {
    points: u32,
    triangles: u32,
}

/// The arrays when the shutter closes. They follow those when it opens, if anything moves.
#[derive(Default)]
struct Closed {
    /// 1, or 2 if anything moves: when the shutter opens and when it closes.
    states: usize,
    nodes: Vec<[u32; 4]>,
    chords: Vec<[u32; 4]>,
    triangles: Vec<[u32; 4]>,
    points: Vec<[f32; 4]>,
}

impl Closed {
    /// Appends them. Returns how many rows after a row that of the closed shutter is, in each array.
    fn append(self, packed: &mut PackedScene) -> [u32; 4] {
        let Closed { nodes, chords, triangles, points, .. } = self;
        let rows = [nodes.len(), chords.len(), triangles.len(), points.len()].map(|rows| rows as u32);
        packed.nodes.extend(nodes);
        packed.chords.extend(chords);
        packed.triangles.extend(triangles);
        packed.points.extend(points);
        rows
    }
}

pub(super) fn pack(packed: &mut PackedScene, geometry: &Geometry) -> Result<Places, Lacking> {
    let mut before = Before::default();
    let mut closed = Closed { states: 1 + usize::from(geometry.moves()), ..Closed::default() };
    let (mut sets, mut meshes) = (Vec::new(), Vec::new());
    let mut fibers = Fibers::default();
    let (mut set, mut waiting) = (0, 0);
    let mut object = |packed: &mut PackedScene, curves: &Curves, triangles: &Triangles| -> Roots {
        waiting = waiting.max(most_waiting(curves.bvh())).max(most_waiting(triangles.bvh()));
        let roots = Roots {
            curves: pack_curves(packed, &mut closed, curves, before.points),
            triangles: pack_triangles(packed, &mut closed, triangles, before.triangles),
        };
        for strands in curves.strands() {
            let records = fibers.records(packed, geometry, set, strands);
            let basis = match strands.basis {
                Basis::Linear => 0,
                Basis::Bezier => 1,
                Basis::BSpline => 2,
                Basis::CatmullRom => 3,
            };
            let starts = packed.numbers(strands.starts.iter().copied());
            let uv = strands
                .root_uv
                .as_ref()
                .map_or(NONE, |uv| packed.numbers(uv.iter().flat_map(|uv| uv.to_array()).map(f32::to_bits)));
            sets.push([before.points, basis, records[0], records[1]]);
            sets.push([starts, strands.len() as u32, geometry.strands_before[set], uv]);
            packed.points.extend(strands.points.iter().map(|p| p.to_array()));
            if geometry.moves() {
                let at = |(i, p): (usize, &glam::Vec4)| strands.moved.as_ref().map_or(*p, |moved| moved[i].extend(p.w));
                closed.points.extend(strands.points.iter().enumerate().map(|point| at(point).to_array()));
            }
            before.points += strands.points.len() as u32;
            set += 1;
        }
        for mesh in triangles.meshes() {
            let corners = |values: [[f32; 3]; 3]| values.map(|[x, y, z]| [x, y, z, 0.0].map(f32::to_bits));
            let normals = mesh.normals.as_ref().map_or(NONE, |normals| {
                let begin = packed.data.len() as u32;
                packed.data.extend(normals.iter().flat_map(|n| corners(n.map(|n| n.to_array()))));
                begin
            });
            let uv = mesh
                .uv
                .as_ref()
                .map_or(NONE, |uv| packed.numbers(uv.iter().flatten().flat_map(|uv| uv.to_array()).map(f32::to_bits)));
            meshes.push([before.triangles, mesh.surface as u32, normals, uv]);
            before.triangles += mesh.triangles.len() as u32;
        }
        roots
    };
    let own = object(packed, &geometry.curves, &geometry.triangles);
    let mut objects = Vec::new();
    for (curves, triangles) in geometry.instances.objects() {
        objects.push(object(packed, curves, triangles));
    }
    packed.fibers = fibers.all;
    let (set_count, mesh_count) = (sets.len() as u32 / 2, meshes.len() as u32);
    let mut append = |rows: Vec<[u32; 4]>| {
        let begin = packed.data.len() as u32;
        packed.data.extend(rows);
        begin
    };
    let (sets, meshes) = (append(sets), append(meshes));
    let mut rows = Vec::new();
    for placed in geometry.instances.placed() {
        for matrix in [placed.to_local, placed.to_world] {
            let (m, t) = (matrix.matrix3.transpose(), matrix.translation);
            let row = |axis: glam::Vec3A, t: f32| [axis.x, axis.y, axis.z, t].map(f32::to_bits);
            rows.extend([row(m.x_axis, t.x), row(m.y_axis, t.y), row(m.z_axis, t.z)]);
        }
        let Roots { curves, triangles } = objects[placed.usual_object()];
        rows.push([curves, triangles, placed.strands_before, placed.scale.to_bits()]);
    }
    let instances = append(rows);
    let (bvh, leaves) = geometry.instances.hierarchy();
    // The hierarchy of an instance is traversed while that of the instances waits.
    packed.stack = waiting + most_waiting(bvh);
    if packed.stack > STACK {
        return Err(Lacking::DeepHierarchies);
    }
    let leaves = append(leaves.iter().flat_map(|l| [[l[0], l[1], l[2], l[3]], [l[4], l[5], l[6], l[7]]]).collect());
    let root = pack_bvh(packed, &mut closed, bvh, 0);
    Ok(Places {
        closed: closed.append(packed),
        roots: [own.curves, own.triangles, root, geometry.instances.len() as u32],
        sets: [set_count, sets, mesh_count, meshes],
        instances: [instances, leaves, 0, 0],
    })
}

fn eight(x: f32x8) -> [[u32; 4]; 2] {
    let [a, b, c, d, e, f, g, h] = x.to_array().map(f32::to_bits);
    [[a, b, c, d], [e, f, g, h]]
}

fn halves(x: [u32; 8]) -> [[u32; 4]; 2] {
    let [a, b, c, d, e, f, g, h] = x;
    [[a, b, c, d], [e, f, g, h]]
}

/// The most nodes that wait while a ray traverses a hierarchy: at each node, all children but one.
fn most_waiting(bvh: &Bvh) -> usize {
    let nodes: Vec<_> = bvh.nodes().collect();
    let mut most = vec![0; nodes.len()];
    // Children come after their node.
    for (i, ([bounds, _], children)) in nodes.iter().enumerate().rev() {
        let [low, high] = [bounds[0][0], bounds[1][0]].map(f32x8::to_array);
        let full = (0..8).filter(|&lane| low[lane] <= high[lane]).map(|lane| children[lane]);
        let count = full.clone().count();
        let below = full.filter(|child| child & LEAF == 0).map(|child| most[child as usize]).max();
        most[i] = count.saturating_sub(1) + below.unwrap_or(0);
    }
    if bvh.root() & LEAF == 0 { most[bvh.root() as usize] } else { 0 }
}

/// Appends the nodes of a hierarchy whose first leaf is `leaves`. Returns its root.
fn pack_bvh(packed: &mut PackedScene, closed: &mut Closed, bvh: &Bvh, leaves: u32) -> u32 {
    let nodes = packed.nodes.len() as u32 / 14;
    let moved = |child: u32| if child & LEAF == 0 { child + nodes } else { child + leaves };
    for (bounds, children) in bvh.nodes() {
        for (nodes, bounds) in [&mut packed.nodes, &mut closed.nodes].into_iter().zip(bounds).take(closed.states) {
            nodes.extend(bounds.iter().flatten().flat_map(|x| eight(*x)));
            nodes.extend(halves(children.map(moved)));
        }
    }
    moved(bvh.root())
}

fn pack_curves(packed: &mut PackedScene, closed: &mut Closed, curves: &Curves, points: u32) -> u32 {
    let leaves = packed.chords.len() as u32 / 16;
    for (ends, margins, first) in curves.blocks() {
        for (chords, ends) in [&mut packed.chords, &mut closed.chords].into_iter().zip(ends).take(closed.states) {
            chords.extend(ends.iter().flatten().flat_map(|x| eight(*x)));
            chords.extend(halves(margins.to_array()));
            chords.extend(halves(first.map(|first| if first == NONE { NONE } else { first + points })));
        }
    }
    pack_bvh(packed, closed, curves.bvh(), leaves)
}

fn pack_triangles(packed: &mut PackedScene, closed: &mut Closed, triangles: &Triangles, before: u32) -> u32 {
    let leaves = packed.triangles.len() as u32 / 20;
    for (shapes, index) in triangles.blocks() {
        for (rows, shape) in [&mut packed.triangles, &mut closed.triangles].into_iter().zip(shapes).take(closed.states)
        {
            rows.extend(shape.iter().flatten().flat_map(|x| eight(*x)));
            rows.extend(halves(index.map(|index| if index == NONE { NONE } else { index + before })));
        }
    }
    pack_bvh(packed, closed, triangles.bvh(), leaves)
}

/// All different fibres.
#[derive(Default)]
struct Fibers {
    all: Vec<Fiber>,
    found: HashMap<Vec<u32>, u32>,
}

impl Fibers {
    fn index(&mut self, fiber: &Fiber) -> u32 {
        let values = Parameter::ALL.into_iter().filter_map(|parameter| parameter.get(fiber)).flatten();
        let key = values.map(f32::to_bits).collect();
        let all = &mut self.all;
        *self.found.entry(key).or_insert_with(|| {
            all.push(*fiber);
            (all.len() - 1) as u32
        })
    }

    /// The record of a set of strands. Or [`NONE`] and the first of one number for each strand. Or [`PER_POINT`] and
    /// the first of one number for each control point.
    fn records(&mut self, packed: &mut PackedScene, geometry: &Geometry, set: usize, strands: &Strands) -> [u32; 2] {
        let look = &geometry.looks[strands.look];
        if look.textured.is_empty() && strands.varying.is_empty() {
            return [self.index(&look.fiber), 0];
        }
        let varies_along = strands.varying.iter().any(|(_, values)| matches!(values, Values::PerPoint(_)));
        let mut numbers = Vec::new();
        for (strand, ends) in strands.starts.windows(2).enumerate() {
            let points = if varies_along { ends[0]..ends[1] } else { ends[0]..ends[0] + 1 };
            let fiber = |point: u32| geometry.fiber_of_point(set, strands, strand, point as usize);
            numbers.extend(points.map(|point| self.index(&fiber(point))));
        }
        [if varies_along { PER_POINT } else { NONE }, packed.numbers(numbers)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// A traversal that enters every box, last child first, has the most nodes waiting. Here the stack is counted.
    #[test]
    fn the_bound_of_waiting_nodes_is_reached() {
        for count in [1, 9, 100, 5000] {
            let place = |i: usize| Vec3::new((i * 37 % 101) as f32, (i * 53 % 97) as f32, (i * i % 89) as f32);
            let (bvh, _) = Bvh::build(count, |i| (place(i), place(i) + 1.0));
            let nodes: Vec<_> = bvh.nodes().collect();
            // The children of a node in all orders: the most that wait below any of them.
            fn most(nodes: &[([&crate::geometry::bvh::Boxes; 2], [u32; 8])], node: u32) -> usize {
                if node & LEAF != 0 {
                    return 0;
                }
                let ([bounds, _], children) = nodes[node as usize];
                let low = bounds[0][0].to_array();
                let full: Vec<u32> = (0..8).filter(|&k| low[k] < f32::MAX).map(|k| children[k]).collect();
                let below = full.iter().map(|&child| most(nodes, child)).max();
                full.len() - 1 + below.unwrap_or(0)
            }
            let waiting = most_waiting(&bvh);
            assert_eq!(waiting, most(&nodes, bvh.root()), "{count} boxes");
            assert!(waiting < STACK, "{count} boxes: {waiting}");
        }
    }
}
