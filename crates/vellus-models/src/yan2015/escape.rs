//! The fraction of scattered light that leaves through both interfaces without reflection.

use std::f32::consts::PI;
use vellus::parts::{Azimuth, Inclination, Weighting};
use vellus::{Tables, fresnel};

/// Number of nodes of the outgoing inclination.
const NODES: usize = 128;

/// Fresnel reflectance of an interface between indices `n1` and `n2`, from the cosines on both sides.
#[inline(always)]
pub(super) fn interface(n1: f32, n2: f32, c1: f32, c2: f32) -> f32 {
    let (a, b, c, d) = (n1 * c1, n2 * c2, n2 * c1, n1 * c2);
    let (s, p) = ((a - b) / (a + b).max(1e-12), (c - d) / (c + d).max(1e-12));
    (0.5 * (s * s + p * p)).min(1.0)
}

/// The indices and layers of both interfaces. The escaping fraction depends on nothing else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interfaces {
    pub eta_c: f32,
    pub eta_m: f32,
    pub layers: f32,
}

impl Interfaces {
    /// Transmittance of both interfaces for light from the axis that leaves at this inclination.
    #[inline(always)]
    pub fn transmission(&self, sin_i: f32, cos_i: f32) -> f32 {
        let inside = |eta: f32| ((eta - sin_i) * (eta + sin_i)).max(0.0).sqrt() / eta;
        let medulla = 1.0 - interface(self.eta_m, self.eta_c, inside(self.eta_m), inside(self.eta_c));
        medulla * fresnel(self.eta_c, self.layers, cos_i).transmitted
    }
}

/// Integrals of the scattering profiles over the inclinations that can leave. There is one table per [`Interfaces`].
#[derive(Clone, Debug)]
pub(super) struct Escape {
    pub interfaces: Interfaces,
    /// Integral over all inclinations that can leave.
    cone: Weighting,
    /// The same, weighted by the transmittance.
    through: Weighting,
}

impl Escape {
    /// Computes the tables.
    pub fn new(interfaces: Interfaces, tables: &Tables) -> Self {
        let step = PI / NODES as f32;
        let rule = |weight: &dyn Fn(f32, f32) -> f32| {
            let node = |k: usize| {
                let (sin_i, cos_i) = ((k as f32 + 0.5 - 0.5 * NODES as f32) * step).sin_cos();
                ((sin_i / interfaces.eta_m).asin(), weight(sin_i, cos_i) * cos_i * step / interfaces.eta_m)
            };
            (0..NODES).map(node).collect::<Vec<_>>()
        };
        let cone = Weighting::new(tables, &rule(&|_, _| 1.0));
        let through = Weighting::new(tables, &rule(&|sin_i, cos_i| interfaces.transmission(sin_i, cos_i)));
        Escape { interfaces, cone, through }
    }

    /// The fractions of scattered light that are inside the escape cone, and that leave.
    #[inline(always)]
    pub fn shares(&self, inclination: &Inclination, azimuth: &Azimuth) -> [f32; 2] {
        let forward = self.cone.forward_share(azimuth);
        [&self.cone, &self.through].map(|weighting| {
            let [back, front] = weighting.halves(inclination);
            (back + (front - back) * forward).clamp(0.0, 1.0)
        })
    }
}
