//! Values of the vertices of the next level.

use super::level::Level;
use super::special::Kind;

/// Adds a weighted value.
pub(super) fn add<const N: usize>(sum: &mut [f64; N], value: &[f32; N], weight: f64) {
    for k in 0..N {
        sum[k] += weight * f64::from(value[k]);
    }
}

/// A weighted sum of values.
pub(super) fn combine<const N: usize>(terms: &[(f64, &[f32; N])]) -> [f32; N] {
    let mut sum = [0.0; N];
    terms.iter().for_each(|(weight, value)| add(&mut sum, value, *weight));
    sum.map(|x| x as f32)
}

/// The number of faces at each vertex.
pub(super) fn valences(level: &Level) -> Vec<u32> {
    let mut counts = vec![0; level.vertices];
    level.corners.iter().for_each(|&vertex| counts[vertex as usize] += 1);
    counts
}

/// The weight of a neighbour in Loop's rule for a vertex with n of them (Loop 1987).
pub(super) fn loop_weight(n: f64) -> f64 {
    let a = 0.375 + 0.25 * (std::f64::consts::TAU / n).cos();
    (0.625 - a * a) / n
}

impl Level {
    /// Values of the vertices of the next level. If they are not smooth, they are linear along edges.
    pub(super) fn refine<const N: usize>(&self, values: &[[f32; N]], smooth: bool) -> Vec<[f32; N]> {
        let of = |vertex: u32| &values[vertex as usize];
        let centers: Vec<[f32; N]> = if self.triangles {
            Vec::new()
        } else {
            let center = |face: usize| {
                let range = self.face(face);
                let mut sum = [0.0; N];
                let weight = 1.0 / range.len() as f64;
                range.for_each(|corner| add(&mut sum, of(self.corners[corner]), weight));
                sum.map(|x| x as f32)
            };
            (0..self.face_count()).map(center).collect()
        };
        let mut finer = Vec::with_capacity(self.vertices + self.firsts.len() + centers.len());
        if smooth {
            finer = self.smooth_vertices(values, &centers);
        } else {
            finer.extend_from_slice(values);
        }
        for (edge, &sharpness) in self.sharpness.iter().enumerate() {
            let [a, b] = self.ends_of(edge).map(of);
            let first = self.firsts[edge];
            let sharp = if smooth { f64::from(sharpness.min(1.0)) } else { 1.0 };
            // An edge that is not sharp has two faces.
            let twin = if sharp < 1.0 { self.twins[first as usize] } else { first };
            let soft = 1.0 - sharp;
            finer.push(if self.triangles {
                let [c, d] = [first, twin].map(|corner| of(self.corners[self.previous(corner) as usize]));
                let along = 0.375 * soft + 0.5 * sharp;
                combine(&[(along, a), (along, b), (0.125 * soft, c), (0.125 * soft, d)])
            } else {
                let [c, d] = [first, twin].map(|corner| &centers[self.face_of(corner) as usize]);
                let along = 0.25 * soft + 0.5 * sharp;
                combine(&[(along, a), (along, b), (0.25 * soft, c), (0.25 * soft, d)])
            });
        }
        finer.extend(centers);
        finer
    }

    fn smooth_vertices<const N: usize>(&self, values: &[[f32; N]], centers: &[[f32; N]]) -> Vec<[f32; N]> {
        let faces = valences(self);
        let mut sums = vec![[0.0f64; N]; self.vertices];
        for [a, b] in self.ends() {
            add(&mut sums[a as usize], &values[b as usize], 1.0);
            add(&mut sums[b as usize], &values[a as usize], 1.0);
        }
        if !self.triangles {
            for (corner, &vertex) in self.corners.iter().enumerate() {
                add(&mut sums[vertex as usize], &centers[self.face_of(corner as u32) as usize], 1.0);
            }
        }
        let smooth = |vertex: usize| {
            let n = f64::from(faces[vertex]);
            let (own, others) = match faces[vertex] {
                0 => (1.0, 0.0),
                _ if self.triangles => (1.0 - n * loop_weight(n), loop_weight(n)),
                _ => ((n - 2.0) / n, 1.0 / (n * n)),
            };
            let value = |k: usize| (own * f64::from(values[vertex][k]) + others * sums[vertex][k]) as f32;
            std::array::from_fn(value)
        };
        let mut finer: Vec<[f32; N]> = Vec::with_capacity(self.vertices + self.firsts.len() + centers.len());
        finer.extend((0..self.vertices).map(smooth));
        for special in &self.specials {
            let own = &values[special.vertex as usize];
            let smooth = finer[special.vertex as usize];
            let by = |kind| match kind {
                Kind::Smooth => smooth,
                Kind::Crease([a, b]) => {
                    combine(&[(0.75, own), (0.125, &values[a as usize]), (0.125, &values[b as usize])])
                }
                Kind::Corner => *own,
            };
            let weight = f64::from(special.weight);
            finer[special.vertex as usize] =
                combine(&[(weight, &by(special.kind)), (1.0 - weight, &by(special.after))]);
        }
        finer
    }
}
