//! What of the light that the medulla has scattered gets out through both interfaces at once.

use std::f32::consts::PI;
use vellus::parts::{Azimuth, Inclination, Weighting};
use vellus::{Tables, fresnel};

/// Nodes over the outgoing inclination.
const NODES: usize = 128;

/// Reflectance of an interface between indices `n1`, `n2` from the cosines on either side.
#[inline(always)]
pub(super) fn interface(n1: f32, n2: f32, c1: f32, c2: f32) -> f32 {
    let (a, b, c, d) = (n1 * c1, n2 * c2, n2 * c1, n1 * c2);
    let (s, p) = ((a - b) / (a + b).max(1e-12), (c - d) / (c + d).max(1e-12));
    (0.5 * (s * s + p * p)).min(1.0)
}

/// Indices and layers, on which alone it depends what gets out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interfaces {
    pub eta_c: f32,
    pub eta_m: f32,
    pub layers: f32,
}

impl Interfaces {
    /// Transmission of both interfaces for light from the axis that leaves at that inclination.
    #[inline(always)]
    pub fn transmission(&self, sin_i: f32, cos_i: f32) -> f32 {
        let inside = |eta: f32| ((eta - sin_i) * (eta + sin_i)).max(0.0).sqrt() / eta;
        let medulla = 1.0 - interface(self.eta_m, self.eta_c, inside(self.eta_m), inside(self.eta_c));
        medulla * fresnel(self.eta_c, self.layers, cos_i).transmitted
    }
}

/// Integrals of the scattering profiles over the inclinations that refract out, one table an `Interfaces`.
#[derive(Clone, Debug)]
pub(super) struct Escape {
    pub interfaces: Interfaces,
    /// All that refracts out, and that times its transmission.
    cone: Weighting,
    through: Weighting,
}

impl Escape {
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

    /// The shares of the scattered light that are in the cone, and that get out of it.
    #[inline(always)]
    pub fn shares(&self, inclination: &Inclination, azimuth: &Azimuth) -> [f32; 2] {
        let forward = self.cone.forward_share(azimuth);
        [&self.cone, &self.through].map(|weighting| {
            let [back, front] = weighting.halves(inclination);
            (back + (front - back) * forward).clamp(0.0, 1.0)
        })
    }
}
