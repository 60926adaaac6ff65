//! A hit of an aggregate: what it scatters from ω_o.

use crate::aggregate::Aggregate;
use crate::grid::position;
use crate::longitudinal::{Longitudinal, back};
use crate::member::{DIFFUSE, LOBES, SCATTERED, SPECULAR};
use crate::node::{CHANNELS, Node, PARTS, longitudinal};
use crate::orders::GROUPS;
use crate::{once, orders};
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use vellus::parts::{Frame, Outgoing, Polar, choose};
use vellus::{Lobe, Lobes, Sample, Scattering};

/// All lobes, RGB and the largest channel.
type Values = [[f32; CHANNELS]; 6];

/// One hit of an aggregate. It allocates nothing.
///
/// Lobes of single scattering are those of the member. All multiple scattering is in [`Lobe::Rest`].
#[derive(Clone, Debug)]
pub struct AggregateHit<'a> {
    model: &'a Aggregate,
    frame: Frame<f32>,
    /// Whether ω_o points to the root: the tables are those of its mirror image.
    mirrored: bool,
    nodes: [(&'a Node, f32); 2],
    longitudinal: Longitudinal,
    /// One over the sum of all weights of samples.
    scale: f32,
}

impl<'a> AggregateHit<'a> {
    #[inline]
    pub(crate) fn new(model: &'a Aggregate, wo: Vec3) -> Self {
        let polar = Polar::new(wo.to_array());
        let nodes = model.nodes(polar.sin, polar.cos);
        let total: f32 = nodes.iter().map(|(node, share)| share * node.weights.iter().sum::<f32>()).sum();
        AggregateHit {
            model,
            frame: Frame::new(wo.to_array(), polar.cos, 1.0 / polar.cos),
            mirrored: polar.sin < 0.0,
            longitudinal: longitudinal(model.member(), model.bunch().spread() as f32, [polar.sin, polar.cos], nodes),
            nodes,
            scale: if total > 0.0 { 1.0 / total } else { 0.0 },
        }
    }

    /// All lobes in one direction.
    #[inline(always)]
    fn values(&self, o: &Outgoing<f32>) -> Values {
        let along = self.longitudinal.eval(o.sin_i, o.cos_i, back(o.phi));
        let azimuth = o.phi.abs();
        let (fine, fine_share) = position(azimuth, PI, once::AZIMUTHS);
        let (coarse, coarse_share) = position(azimuth, PI, orders::AZIMUTHS);
        let sign = if self.mirrored { -1.0 } else { 1.0 };
        let (row, row_share) = self.model.grid.along(sign * o.sin_i, sign * o.theta_i);
        let forward = (azimuth / PI).min(1.0);
        let mut values = [[0.0; CHANNELS]; 6];
        for (node, share) in self.nodes {
            let single = blend(&node.single, fine, fine_share);
            let [rear, front] = blend(&node.scattered, row, row_share);
            let scattered = rear + (front - rear) * forward;
            let mut add = |lobe: Lobe, from: &[f32], factor: f32| {
                let sums = values[lobe as usize].iter_mut().zip(from);
                sums.for_each(|(sum, x)| *sum += share * factor * x);
            };
            for (k, (lobe, ..)) in SPECULAR.into_iter().enumerate() {
                add(lobe, &single[lobe as usize * CHANNELS..], along[k]);
            }
            add(Lobe::Rest, &single[DIFFUSE * CHANNELS..], 2.0 / PI * o.cos_i);
            for lobe in SCATTERED {
                add(lobe, &single[lobe as usize * CHANNELS..], scattered);
            }
            let narrow = blend(&node.narrow, coarse, coarse_share);
            let around = blend(&node.around, coarse, coarse_share);
            let broad = blend(&node.broad, row, row_share);
            for group in 0..GROUPS {
                let first = group * CHANNELS;
                add(Lobe::Rest, &narrow[first..], along[SPECULAR.len() + group]);
                let product: [f32; CHANNELS] = std::array::from_fn(|c| around[first + c] * broad[first + c]);
                add(Lobe::Rest, &product, 1.0);
            }
        }
        values
    }

    /// A direction of one part of one node.
    fn draw(&self, node: &Node, part: usize, u: [f32; 4]) -> Outgoing<f32> {
        let grid = &self.model.grid;
        let (side, v) = if u[0] < 0.5 { (-1.0, 2.0 * u[0]) } else { (1.0, 2.0 * u[0] - 1.0) };
        let azimuths = if part < LOBES { &grid.fine } else { &grid.coarse };
        let azimuth = node.sampling.azimuths[part].sample(azimuths, v);
        let lobe = SPECULAR.iter().position(|(lobe, ..)| *lobe as usize == part);
        let lobe = lobe.or_else(|| (LOBES..LOBES + GROUPS).contains(&part).then(|| part - LOBES + SPECULAR.len()));
        let (sin_i, cos_i) = match lobe {
            Some(lobe) => self.longitudinal.sample(lobe, back(azimuth), [u[1], u[2]]),
            None if part == DIFFUSE => {
                let sin = u[1].sqrt() * (TAU * u[2]).cos();
                (sin, ((1.0 - sin) * (1.0 + sin)).max(0.0).sqrt())
            }
            None => {
                let density = match part.checked_sub(LOBES + GROUPS) {
                    Some(group) => &node.sampling.broad[group],
                    None => &node.sampling.scattered[usize::from(u[3] < azimuth / PI)],
                };
                let sin = density.sample(&grid.along, u[1]).clamp(-1.0, 1.0);
                (if self.mirrored { -sin } else { sin }, ((1.0 - sin) * (1.0 + sin)).sqrt())
            }
        };
        Outgoing { sin_i, cos_i, theta_i: sin_i.atan2(cos_i), phi: side * azimuth }
    }
}

/// A row between two others.
#[inline(always)]
fn blend<const N: usize>(rows: &[[f32; N]], k: usize, share: f32) -> [f32; N] {
    let (a, b) = (&rows[k], &rows[k + 1]);
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
}

#[inline(always)]
fn lobes(values: &Values) -> Lobes {
    Lobes(values.map(|[r, g, b, _]| [r, g, b]))
}

impl Scattering for AggregateHit<'_> {
    fn energy(&self) -> Lobes {
        let mut energy = [[0.0; 3]; 6];
        for (node, share) in self.nodes {
            for (lobe, c) in (0..18).map(|i| (i / 3, i % 3)) {
                energy[lobe][c] += share * node.energy.0[lobe][c];
            }
        }
        Lobes(energy)
    }

    #[inline]
    fn eval_pdf(&self, wi: Vec3) -> (Lobes, f32) {
        let values = self.values(&self.frame.outgoing(wi.to_array()));
        (lobes(&values), values.iter().map(|lobe| lobe[CHANNELS - 1]).sum::<f32>() * self.scale)
    }

    #[inline]
    fn sample(&self, u: [f32; 5]) -> Option<Sample> {
        let parts = self
            .nodes
            .iter()
            .flat_map(|(node, share)| (0..PARTS).map(move |part| ((*node, part), share * node.weights[part])));
        let ((node, part), _) = choose(parts, u[0] / self.scale.max(f32::MIN_POSITIVE)).map(|c| (c.item, c.weight))?;
        let outgoing = self.draw(node, part, [u[1], u[2], u[3], u[4]]);
        let values = self.values(&outgoing);
        let sum = values.iter().map(|lobe| lobe[CHANNELS - 1]).sum::<f32>();
        if sum <= f32::MIN_POSITIVE {
            return None;
        }
        let weight = lobes(&values).total().map(|f| f / (sum * self.scale));
        let wi = self.frame.direction(outgoing.sin_i, outgoing.cos_i, outgoing.phi.sin_cos());
        let lobe = Lobe::ALL.get(part).copied().unwrap_or(Lobe::Rest);
        Sample::new(Vec3::from_array(wi), sum * self.scale, weight, lobe)
    }
}
