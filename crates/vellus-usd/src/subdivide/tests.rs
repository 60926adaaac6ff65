//! Closed forms, and a plain implementation in double precision.

use super::{Boundary, Cage, FaceVarying, Scheme, Subdivision};
use glam::{DVec3, Vec3};
use std::collections::HashMap;

const CUBE: [[f32; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];
const SIDES: [u32; 24] = [3, 2, 1, 0, 4, 5, 6, 7, 0, 1, 5, 4, 2, 3, 7, 6, 1, 2, 6, 5, 3, 0, 4, 7];

fn cage<'a>(counts: &'a [u32], corners: &'a [u32]) -> Cage<'a> {
    Cage {
        scheme: Scheme::CatmullClark,
        counts,
        corners,
        vertices: corners.iter().max().map_or(0, |&v| v as usize + 1),
        creases: &[],
        sharp: &[],
        boundary: Boundary::EdgesAndCorners,
    }
}

fn refined(cage: &Cage, times: usize) -> Subdivision {
    let mut subdivision = Subdivision::new(cage);
    subdivision.refine(times);
    subdivision
}

fn limit(cage: &Cage, times: usize, values: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let subdivision = refined(cage, times);
    subdivision.limit(&subdivision.refined(values))
}

#[track_caller]
fn near(a: [f32; 3], b: [f32; 3]) {
    // Six levels, and a few roundings of 6e-8 each.
    assert!(Vec3::from(a).abs_diff_eq(Vec3::from(b), 2e-6), "{a:?} {b:?}");
}

/// A grid of n × n quads over [0, n]².
fn grid(n: u32) -> (Vec<u32>, Vec<u32>, Vec<[f32; 3]>) {
    let at = |x: u32, y: u32| y * (n + 1) + x;
    let quads = (0..n * n).flat_map(|i| {
        let (x, y) = (i % n, i / n);
        [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
    });
    let points = (0..(n + 1) * (n + 1)).map(|i| [(i % (n + 1)) as f32, (i / (n + 1)) as f32, 0.0]);
    (vec![4; (n * n) as usize], quads.collect(), points.collect())
}

/// The masks of Halstead et al. for a cube: a corner is (9v + 4Σe + Σf) / 24 = v / 2. The first level has vertices at
/// 5/9, edges at 3/4 and faces at 1, so the middle of a face is (16 + 4·3 + 4·5/9) / 36 = 68/81, and that of an edge
/// (16·(3/4) + 4·(2·(5/9) + 2·(1/2)) + 2·(3/4)·2) / 36, with x and y of the neighbours.
#[test]
fn a_cube_has_its_known_limit() {
    for times in 1..=5 {
        let points = limit(&cage(&[4; 6], &SIDES), times, &CUBE);
        near(points[7], [-0.5, 0.5, 0.5]);
        let highest = points.iter().map(|p| p[2]).fold(0.0, f32::max);
        assert!((highest - 68.0 / 81.0).abs() < 1e-6, "{highest}");
    }
}

/// Infinitely sharp creases and borders are cubic B-splines: (1, 4, 1) / 6 at each point, and (1, 23, 23, 1) / 48
/// between two of them.
#[test]
fn borders_and_creases_are_cubic_b_splines() {
    let (counts, corners, mut points) = grid(4);
    let heights = [0.0, 2.0, -1.0, 3.0, 0.5];
    points.iter_mut().for_each(|p| p[2] = heights[p[0] as usize] * (1.0 + (p[1] - 2.0).abs()));
    // The row y = 2 in the middle.
    let row: Vec<([u32; 2], f32)> = (10..14).map(|v| ([v, v + 1], 10.0)).collect();
    let border = cage(&counts, &corners);
    let creased = Cage { creases: &row, ..border.clone() };
    for (cage, first, scale) in [(&border, 0, 3.0), (&creased, 10, 1.0)] {
        let fine = refined(cage, 3);
        let all = fine.refined(&points);
        let limits = fine.limit(&all);
        let spline = |i: usize| scale * (heights[i - 1] + 4.0 * heights[i] + heights[i + 1]) / 6.0;
        near(limits[first + 2], [2.0, points[first][1], spline(2)]);
        let y = points[first][1];
        let between = scale * (heights[1] + 23.0 * heights[2] + 23.0 * heights[3] + heights[4]) / 48.0;
        let middle = limits.iter().find(|p| (p[0] - 2.5).abs() < 1e-6 && (p[1] - y).abs() < 1e-6).unwrap();
        near(*middle, [2.5, y, between]);
    }
    // Both ends of a border with the corners sharp, and the rounded corner without.
    near(limit(&border, 2, &points)[0], points[0]);
    let smooth = Cage { boundary: Boundary::Edges, ..border };
    near(limit(&smooth, 2, &points)[0], [1.0 / 6.0, 1.0 / 6.0, (2.0 * 3.0 + 0.0) / 6.0]);
}

/// Linear values stay linear inside, and a plane stays a plane with its normal.
#[test]
fn planes_stay_planes() {
    let (counts, corners, points) = grid(5);
    let tilted: Vec<[f32; 3]> = points.iter().map(|p| [p[0], p[1], 0.5 * p[0] - 0.25 * p[1]]).collect();
    let plain = cage(&counts, &corners);
    let fine = refined(&plain, 2);
    let all = fine.refined(&tilted);
    for p in fine.limit(&all) {
        assert!((p[2] - (0.5 * p[0] - 0.25 * p[1])).abs() < 1e-6);
    }
    let expected = Vec3::new(-0.5, 0.25, 1.0).normalize();
    assert!(fine.normals(&all).iter().all(|n| Vec3::from(*n).abs_diff_eq(expected, 1e-5)));
}

/// A mesh in double precision, refined with hash maps.
#[derive(Clone)]
struct Plain {
    points: Vec<DVec3>,
    faces: Vec<Vec<usize>>,
    sharp: HashMap<(usize, usize), f64>,
    corners: HashMap<usize, f64>,
}

fn key(a: usize, b: usize) -> (usize, usize) {
    (a.min(b), a.max(b))
}

impl Plain {
    fn new(cage: &Cage, points: &[[f32; 3]]) -> Self {
        let mut rest = cage.corners;
        let faces = cage.counts.iter().map(|&n| {
            let (face, after) = rest.split_at(n as usize);
            rest = after;
            face.iter().map(|&v| v as usize).collect::<Vec<_>>()
        });
        let faces: Vec<Vec<usize>> = faces.collect();
        let of_edges = cage
            .creases
            .iter()
            .map(|([a, b], s)| (key(*a as usize, *b as usize), if *s < 10.0 { f64::from(*s) } else { f64::INFINITY }));
        let mut sharp: HashMap<_, _> = of_edges.collect();
        let corners = cage.sharp.iter().map(|(v, s)| (*v as usize, f64::from(*s))).collect();
        let mut uses: HashMap<(usize, usize), u32> = HashMap::new();
        for face in &faces {
            (0..face.len()).for_each(|i| *uses.entry(key(face[i], face[(i + 1) % face.len()])).or_default() += 1);
        }
        sharp.extend(uses.iter().filter(|(_, n)| **n == 1).map(|(edge, _)| (*edge, f64::INFINITY)));
        Plain { points: points.iter().map(|p| DVec3::from(p.map(f64::from))).collect(), faces, sharp, corners }
    }

    /// DeRose et al.: the rule of the number of sharp edges, blended while they become smooth.
    fn rule(&self, v: usize, ends: &[usize], age: f64, smooth: DVec3) -> DVec3 {
        let left = |s: f64| (s - age).max(0.0) > 0.0;
        if self.corners.get(&v).is_some_and(|s| left(*s)) {
            return self.points[v];
        }
        let sharp: Vec<usize> =
            ends.iter().copied().filter(|e| self.sharp.get(&key(v, *e)).is_some_and(|s| left(*s))).collect();
        match sharp[..] {
            [] | [_] => smooth,
            [a, b] => 0.75 * self.points[v] + 0.125 * (self.points[a] + self.points[b]),
            _ => self.points[v],
        }
    }

    fn finer(&self) -> Plain {
        let mut points = self.points.clone();
        let centers: Vec<DVec3> = self
            .faces
            .iter()
            .map(|face| face.iter().map(|&v| self.points[v]).sum::<DVec3>() / face.len() as f64)
            .collect();
        let mut beside: HashMap<(usize, usize), Vec<usize>> = HashMap::new();
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); self.points.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for (i, &v) in face.iter().enumerate() {
                beside.entry(key(v, face[(i + 1) % face.len()])).or_default().push(f);
                around[v].push(f);
            }
        }
        let mut ends: Vec<Vec<usize>> = vec![Vec::new(); self.points.len()];
        beside.keys().for_each(|&(a, b)| (ends[a].push(b), ends[b].push(a)).0);
        for v in 0..self.points.len() {
            let n = around[v].len() as f64;
            let sum: DVec3 = ends[v].iter().map(|&e| self.points[e]).sum();
            let faces: DVec3 = around[v].iter().map(|&f| centers[f]).sum();
            let smooth = (n - 2.0) / n * self.points[v] + (sum + faces) / (n * n);
            let (now, after) = (self.rule(v, &ends[v], 0.0, smooth), self.rule(v, &ends[v], 1.0, smooth));
            let all = ends[v].iter().filter_map(|&e| self.sharp.get(&key(v, e))).chain(self.corners.get(&v));
            let fading: Vec<f64> = all.copied().filter(|s| *s > 0.0 && *s <= 1.0).collect();
            let weight = if fading.is_empty() { 1.0 } else { fading.iter().sum::<f64>() / fading.len() as f64 };
            points[v] = if now == after { now } else { weight * now + (1.0 - weight) * after };
        }
        let mut halves: HashMap<(usize, usize), usize> = HashMap::new();
        let mut sharp = HashMap::new();
        for (&(a, b), faces) in &beside {
            let middle = 0.5 * (self.points[a] + self.points[b]);
            let s = self.sharp.get(&(a, b)).copied().unwrap_or(0.0);
            let smooth = || 0.5 * middle + 0.25 * (centers[faces[0]] + centers[faces[1]]);
            let point = if s >= 1.0 { middle } else { s * middle + (1.0 - s) * smooth() };
            halves.insert((a, b), points.len());
            sharp.extend([a, b].map(|v| (key(v, points.len()), (s - 1.0).max(0.0))));
            points.push(point);
        }
        let mut faces = Vec::new();
        for (face, center) in self.faces.iter().zip(&centers) {
            for i in 0..face.len() {
                let half = |i: usize| halves[&key(face[i % face.len()], face[(i + 1) % face.len()])];
                faces.push(vec![face[i], half(i), points.len(), half(i + face.len() - 1)]);
            }
            points.push(*center);
        }
        let corners = self.corners.iter().map(|(v, s)| (*v, (s - 1.0).max(0.0))).collect();
        Plain { points, faces, sharp, corners }
    }
}

/// Semi-sharp creases and corners of a solid with faces of 3, 4 and 5 corners, and an open one: all vertices of the
/// second level are where 8 levels of double precision bring them.
#[test]
fn semi_sharp_creases_agree_with_eight_plain_levels() {
    // A house with five corners in front, and one with triangles instead of the back.
    let points: Vec<[f32; 3]> = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 2.0, 0.0],
        [1.0, 3.0, 0.0],
        [0.0, 2.0, 0.0],
        [0.0, 0.0, -3.0],
        [2.0, 0.0, -3.0],
        [2.0, 2.0, -3.0],
        [1.0, 3.0, -2.0],
        [0.0, 2.0, -3.0],
        [1.0, 1.0, -4.0],
    ]
    .to_vec();
    let counts = [5, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3];
    let corners = [
        0, 1, 2, 3, 4, 1, 0, 5, 6, 2, 1, 6, 7, 3, 2, 7, 8, 4, 3, 8, 9, 0, 4, 9, 5, 6, 5, 10, 7, 6, 10, 8, 7, 10, 9, 8,
        10, 5, 9, 10,
    ];
    // The front is infinitely sharp. Where such a crease ends inside a surface, the limit is not that of a mask.
    let mut creases = vec![([1, 6], 0.4), ([2, 7], 1.5), ([3, 8], 2.7), ([7, 10], 0.6), ([8, 10], 1.2), ([9, 10], 1.9)];
    creases.extend([([6, 5], 1.0)].into_iter().chain((0..5).map(|v| ([v, (v + 1) % 5], 10.0))));
    let sharp = [(6, 0.7), (5, 2.2)];
    // 8 levels leave errors of 4^-7, times the differences of neighbours (2 at most).
    let bound = 2.0 * 4.0f64.powi(-7);
    for open in [false, true] {
        let cage = Cage {
            counts: if open { &counts[..10] } else { &counts },
            corners: if open { &corners[..corners.len() - 3] } else { &corners },
            creases: &creases,
            sharp: &sharp,
            boundary: Boundary::Edges,
            ..cage(&counts, &corners)
        };
        let mut plain = Plain::new(&cage, &points);
        for times in 1..=3 {
            plain = plain.finer();
            // All sharpness below 10 has ended after three levels, so the limit masks are exact.
            let fine = refined(&cage, times);
            let ours = fine.refined(&points);
            let most = |points: &[DVec3], ours: &[[f32; 3]]| {
                let nearest = |p: &[f32; 3]| {
                    let p = DVec3::from(p.map(f64::from));
                    points.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min)
                };
                ours.iter().map(nearest).fold(0.0, f64::max)
            };
            let far = most(&plain.points, &ours);
            assert!(far < 1e-6 && ours.len() == plain.points.len(), "level {times}: {far}");
            if times == 3 {
                // Vertices keep their indices: those of the cage come first.
                let limits = fine.limit(&ours);
                let mut finest = plain.clone();
                (3..8).for_each(|_| finest = finest.finer());
                for (v, ours) in limits.iter().enumerate().take(points.len()) {
                    let there = finest.points[v];
                    assert!(there.distance(DVec3::from(ours.map(f64::from))) < bound, "vertex {v}");
                }
            }
        }
    }
}

/// The tangent planes of vertices with 3 to 9 faces, inside and at borders, are those of the limit after more levels.
#[test]
fn normals_are_those_of_the_limit() {
    let fan = |n: u32, closed: bool, scheme: Scheme| {
        // A vertex, and around it quads or triangles, bent.
        let turn = if closed { std::f32::consts::TAU } else { 0.8 * std::f32::consts::TAU };
        let ring = if closed { n } else { n + 1 };
        let quads = scheme == Scheme::CatmullClark;
        let mut points = vec![[0.0, 0.0, 0.1]];
        let bent = |i: f32, r: f32| {
            let angle = turn * i / n as f32;
            [r * angle.cos(), r * angle.sin(), 0.05 * (3.0 * angle).sin() + 0.15 * r * angle.cos()]
        };
        points.extend((0..ring).map(|i| bent(i as f32, 1.0)));
        points.extend((0..n).map(|i| bent(i as f32 + 0.5, 1.6)));
        let face = |i: u32| {
            let (a, b) = (1 + i, 1 + (i + 1) % ring);
            if quads { vec![0, a, 1 + ring + i, b] } else { vec![0, a, b] }
        };
        let corners: Vec<u32> = (0..n).flat_map(face).collect();
        (vec![if quads { 4 } else { 3 }; n as usize], corners, points)
    };
    for scheme in [Scheme::CatmullClark, Scheme::Loop] {
        for (n, closed) in (3..10).map(|n| (n, true)).chain((2..8).map(|n| (n, false))) {
            let (counts, corners, points) = fan(n, closed, scheme);
            let cage = Cage { scheme, vertices: points.len(), ..cage(&counts, &corners) };
            let normal = |times: usize| {
                let fine = refined(&cage, times);
                let all = fine.refined(&points);
                let corner = fine.finest().corners().iter().position(|&v| v == 0).unwrap();
                (Vec3::from(fine.normals(&all)[corner]), fine.limit(&all), fine)
            };
            let (coarse, ..) = normal(1);
            let (fine, limits, mesh) = normal(6);
            assert!(coarse.abs_diff_eq(fine, 1e-5), "{scheme:?} {n} {closed}: {coarse} {fine}");
            // The limits of neighbours lie near the tangent plane: they are at most 0.6⁶ away, heights below 0.3.
            let here = Vec3::from(limits[0]);
            for ends in mesh.finest().ends().filter(|ends| ends.contains(&0)) {
                let away = Vec3::from(limits[ends[0].max(ends[1]) as usize]) - here;
                assert!(away.normalize().dot(fine).abs() < 0.05, "{scheme:?} {n} {closed}: {away} {fine}");
            }
        }
    }
}

/// The limit of Loop's scheme: an octahedron's vertex has β = (5/8 − (3/8)²) / 4 = 31/256, so its neighbours have the
/// weight 1 / (4 + 3 · 256 / (8 · 31)) and cancel out.
#[test]
fn loop_surfaces_have_their_known_limit() {
    let points: Vec<[f32; 3]> =
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]].map(|p| p.map(|x| x as f32)).to_vec();
    let corners = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5];
    let octahedron = Cage { scheme: Scheme::Loop, ..cage(&[3; 8], &corners) };
    let weight = 1.0 / (4.0 + 0.375 * 256.0 / 31.0);
    // The opposite vertex is no neighbour.
    let expected = 1.0 - 4.0 * weight;
    for times in 0..4 {
        let limits = limit(&octahedron, times, &points);
        near(limits[0], [expected as f32, 0.0, 0.0]);
        let sizes = limits.iter().map(|p| Vec3::from(*p).length());
        assert!(sizes.clone().fold(f32::INFINITY, f32::min) > 0.4 && sizes.fold(0.0, f32::max) < 0.7);
    }
}

#[test]
fn values_at_corners_have_their_own_seams() {
    // Two quads side by side with a seam between them, then without.
    let corners = [0, 1, 4, 3, 1, 2, 5, 4];
    let plain = cage(&[4, 4], &corners);
    let fine = refined(&plain, 1);
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let apart: Vec<[f32; 2]> = square.into_iter().chain(square.map(|uv| [uv[0] + 5.0, uv[1]])).collect();
    let together: Vec<[f32; 2]> = square.into_iter().chain(square.map(|uv| [uv[0] + 1.0, uv[1]])).collect();
    let range = |values: &[[f32; 2]], rule| {
        let all = fine.face_varying(values, rule);
        assert_eq!(all.len(), fine.finest().corners().len());
        all.iter().fold(([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]), |(low, high), uv| {
            ([low[0].min(uv[0]), low[1].min(uv[1])], [high[0].max(uv[0]), high[1].max(uv[1])])
        })
    };
    for rule in [FaceVarying::Corners, FaceVarying::CornersPlus1, FaceVarying::Boundaries, FaceVarying::All] {
        assert_eq!(range(&apart, rule), ([0.0, 0.0], [6.0, 1.0]), "{rule:?}");
    }
    // Without sharp corners of the mesh, the corners of the values are rounded: (1, 4, 1) / 6.
    let smooth = refined(&Cage { boundary: Boundary::Edges, ..plain.clone() }, 1);
    let low = smooth.face_varying(&together, FaceVarying::None)[0];
    assert!((low[0] - 1.0 / 6.0).abs() < 1e-6 && (low[1] - 1.0 / 6.0).abs() < 1e-6, "{low:?}");
    assert_eq!(smooth.face_varying(&together, FaceVarying::CornersPlus1)[0], [0.0, 0.0]);
    // Values that are positions follow the positions where both have the same rules.
    let points: Vec<[f32; 3]> =
        [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]].map(|[x, y]| [x as f32, y as f32, 0.0]).to_vec();
    let limits = fine.limit(&fine.refined(&points));
    for (corner, uv) in fine.face_varying(&together, FaceVarying::CornersPlus1).iter().enumerate() {
        let p = limits[fine.finest().corners()[corner] as usize];
        assert!((p[0] - uv[0]).abs() < 1e-6 && (p[1] - uv[1]).abs() < 1e-6);
    }
}

/// Edges with three faces, faces of opposite orientation, faces that meet at a vertex, repeated corners, and vertices
/// without a face: values stay between those of the cage, and nothing panics.
#[test]
fn any_topology_is_refined() {
    let soups: [(&[u32], &[u32]); 7] = [
        (&[3, 3, 3], &[0, 1, 2, 1, 0, 3, 0, 1, 4]),
        (&[3, 3], &[0, 1, 2, 0, 1, 3]),
        (&[3, 3], &[0, 1, 2, 0, 3, 4]),
        (&[4, 3], &[0, 1, 1, 2, 2, 2, 2]),
        (&[4, 4], &[0, 1, 2, 1, 3, 1, 3, 1]),
        (&[3, 3], &[0, 1, 2, 2, 1, 0]),
        (&[], &[]),
    ];
    for (counts, corners) in soups {
        for scheme in [Scheme::CatmullClark, Scheme::Bilinear, Scheme::Loop] {
            if scheme == Scheme::Loop && counts.iter().any(|n| *n != 3) {
                continue;
            }
            for boundary in [Boundary::None, Boundary::Edges, Boundary::EdgesAndCorners] {
                let creases = [([0, 1], 1.5), ([7, 9], 2.0), ([1, 1], 3.0)];
                let cage = Cage { scheme, vertices: 10, creases: &creases, boundary, ..cage(counts, corners) };
                let points: Vec<[f32; 3]> = (0..10).map(|i| [i as f32, (i * i % 7) as f32, (i % 3) as f32]).collect();
                let fine = refined(&cage, 3);
                let all = fine.refined(&points);
                let limits = fine.limit(&all);
                let inside = |p: &[f32; 3]| (-1e-4..=9.0001).contains(&p[0]) && (-1e-4..=6.0001).contains(&p[1]);
                assert!(all.iter().chain(&limits).all(inside), "{corners:?} {scheme:?}");
                assert!(fine.normals(&all).as_flattened().iter().all(|x| x.is_finite()));
                let values: Vec<[f32; 2]> = (0..corners.len()).map(|i| [i as f32, 0.0]).collect();
                let values = fine.face_varying(&values, FaceVarying::CornersPlus2);
                assert!(values.iter().all(|v| (-1e-4..=corners.len() as f32).contains(&v[0])));
                assert!((0..fine.finest().face_count()).all(|face| fine.source(face) < counts.len().max(1)));
                assert_eq!(cage.counts.len(), fine.cage().at_border().len());
            }
        }
    }
}

/// Bilinear faces are those of their corners, whatever their number.
#[test]
fn bilinear_surfaces_only_divide() {
    let cube = Cage { scheme: Scheme::Bilinear, ..cage(&[4; 6], &SIDES) };
    let limits = limit(&cube, 3, &CUBE);
    assert!(limits.iter().all(|p| p.iter().map(|x| x.abs()).fold(0.0, f32::max) == 1.0));
    assert_eq!(&limits[..8], &CUBE);
}
