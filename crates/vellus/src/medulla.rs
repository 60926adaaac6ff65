//! The light scattered by the medulla: C^N, C^M and ⟨L⟩ looked up in the compressed tables.

use crate::fiber::Fiber;
use crate::grid;
use crate::lanes::Lanes;
use crate::mixture::{Between, Weights, choose, normaliser, product};
use crate::tables::{AZIMUTHAL, BACKWARD, FORWARD, Mixture, Tables};
use std::f32::consts::{PI, TAU};
use wide::f32x8;

/// The tables with g, and for the longitudinal ones τ, put in: one a fibre.
#[derive(Clone, Debug)]
pub(crate) struct Medulla<'t> {
    tables: &'t Tables,
    azimuthal: Weights<AZIMUTHAL>,
    backward: Weights<BACKWARD>,
    forward: Weights<FORWARD>,
    g: Between,
    /// The integrals of the backward components, the same for every hit.
    backward_integrals: Weights<BACKWARD>,
    /// σ_ms κ
    optical_radius: f32,
}

/// What one hit prepares for all its queries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scattered {
    azimuthal: Weights<AZIMUTHAL>,
    backward: Weights<BACKWARD>,
    forward: Weights<FORWARD>,
    /// What makes each of the three integrate to 1.
    scale: [f32; 3],
    /// |θ_o|: the shift of the forward lobe.
    theta: f32,
    /// −1 where h″ < 0: the profile is mirrored, (h, φ) → (−h, −φ).
    mirror_phi: f32,
    /// −1 where θ_o < 0: (θ_o, θᵢ) → (−θ_o, −θᵢ).
    mirror_theta: f32,
    /// False where the path misses the medulla.
    pub exists: bool,
}

impl Scattered {
    /// A path that misses the medulla.
    pub const NONE: Scattered = Scattered {
        azimuthal: [f32x8::ZERO; AZIMUTHAL],
        backward: [f32x8::ZERO; BACKWARD],
        forward: [f32x8::ZERO; FORWARD],
        scale: [0.0; 3],
        theta: 0.0,
        mirror_phi: 1.0,
        mirror_theta: 1.0,
        exists: false,
    };
}

impl<'t> Medulla<'t> {
    pub fn new(fiber: &Fiber, tables: &'t Tables) -> Self {
        let optical_radius = fiber.sigma_ms * fiber.kappa;
        let g_position = grid::g_position(f64::from(fiber.g)) as f32;
        // D12: C^M is simulated with inclined rays, so that its τ is σ_ms κ; only C^N, simulated in
        // the normal plane, needs the elongation 1/cos θ_t.
        let tau_position = grid::tau_position(f64::from(optical_radius)) as f32;
        let g_rows = &tables.azimuthal.factors[1];
        Medulla {
            tables,
            azimuthal: g_rows.at(on(g_position, g_rows.nodes())),
            backward: collapse(&tables.backward, tau_position, g_position),
            forward: collapse(&tables.forward, tau_position, g_position),
            g: on(g_position, tables.mean_path_nodes[1]),
            backward_integrals: tables.backward.densities.integrals(0.0),
            optical_radius,
        }
    }

    /// Is there anything that scatters?
    pub fn exists(&self) -> bool {
        self.optical_radius > 0.0
    }

    /// ⟨L⟩(τ, g, h″).
    #[inline(always)]
    fn mean_path(&self, tau: Between, h: Between) -> f32 {
        let [_, n_g, n_h] = self.tables.mean_path_nodes;
        let values = &self.tables.mean_path;
        let along_h = |tau: usize, g: usize| {
            let row = &values[(tau * n_g + g) * n_h + h.index..][..2];
            row[0] + h.t * (row[1] - row[0])
        };
        let along_g = |tau: usize| {
            let (a, b) = (along_h(tau, self.g.index), along_h(tau, self.g.index + 1));
            a + self.g.t * (b - a)
        };
        let (a, b) = (along_g(tau.index), along_g(tau.index + 1));
        a + tau.t * (b - a)
    }

    /// Where on the axis of τ, in [0, 1], light of that elongation is: [`grid::tau_position`] in single
    /// precision. 1 + kτ rounds at 6e-8, 1e-8 of the axis.
    #[inline(always)]
    pub fn tau_position<V: Lanes>(&self, elongation: V) -> V {
        let scale = grid::TAU_SCALE as f32 * self.optical_radius;
        (V::splat(1.0) + V::splat(scale) * elongation).ln() * V::splat(1.0 / grid::TAU_GROWTH as f32)
    }

    /// Prepares a hit, with ⟨L⟩ for it: `tau` is [`Medulla::tau_position`], `angle` asin h″ and `theta`
    /// θ_o, with their signs.
    #[inline(always)]
    pub fn at(&self, tau: f32, angle: f32, theta: f32) -> (Scattered, f32) {
        let Tables { azimuthal, backward, forward, .. } = self.tables;
        let [tau_rows, _, h_rows] = &azimuthal.factors;
        let tau = on(tau, tau_rows.nodes());
        let h = on(angle.abs() * std::f32::consts::FRAC_2_PI, h_rows.nodes());
        let w_n = product(&product(&tau_rows.at(tau), &h_rows.at(h)), &self.azimuthal);

        let shift = theta.abs();
        let theta_rows = &forward.factors[2];
        let position = on(shift * (1.0 / grid::THETA_MAX as f32), theta_rows.nodes());
        let w_b = product(&backward.factors[2].at(position), &self.backward);
        let w_f = product(&theta_rows.at(position), &self.forward);
        let scattered = Scattered {
            azimuthal: w_n,
            backward: w_b,
            forward: w_f,
            scale: [
                normaliser(&w_n, &[f32x8::ONE; AZIMUTHAL]),
                normaliser(&w_b, &self.backward_integrals),
                normaliser(&w_f, &forward.densities.integrals(shift)),
            ],
            theta: shift,
            mirror_phi: 1f32.copysign(angle),
            mirror_theta: 1f32.copysign(theta),
            exists: true,
        };
        (scattered, self.mean_path(tau, h))
    }

    /// C^N at azimuth `phi` from straight back, in [−π, π]; a density per radian.
    #[doc(alias = "Eq. 10")]
    #[inline(always)]
    pub fn azimuthal(&self, s: &Scattered, phi: f32) -> f32 {
        let phi = phi * s.mirror_phi;
        s.scale[0] * self.tables.azimuthal.densities.eval(&s.azimuthal, if phi < 0.0 { phi + TAU } else { phi })
    }

    /// C^M of the backward and the forward half at θᵢ; densities in sin θᵢ.
    #[doc(alias = "Eq. 19")]
    #[inline(always)]
    pub fn longitudinal(&self, s: &Scattered, theta_i: f32) -> [f32; 2] {
        let theta_i = theta_i * s.mirror_theta;
        [
            s.scale[1] * self.tables.backward.densities.eval(&s.backward, theta_i),
            s.scale[2] * self.tables.forward.densities.eval(&s.forward, theta_i + s.theta),
        ]
    }

    /// Draws an azimuth from straight back, in [−2π, 2π], from C^N. D10: exact sampling from the tables.
    pub fn sample_azimuth(&self, s: &Scattered, u: f32) -> f32 {
        let (r, u) = choose(&s.azimuthal, &[f32x8::ONE; AZIMUTHAL], u);
        s.mirror_phi * self.tables.azimuthal.densities.invert(r, u, 0.0)
    }

    /// Draws θᵢ from C^M for an azimuth `phi` in [−π, π] from straight back: a half in proportion
    /// to the interpolation weight, then a component, then the angle.
    pub fn sample_inclination(&self, s: &Scattered, phi: f32, u: [f32; 2]) -> f32 {
        let forward = phi.abs() / PI;
        let theta = if u[0] < forward {
            let densities = &self.tables.forward.densities;
            let (r, _) = choose(&s.forward, &densities.integrals(s.theta), u[0] / forward);
            densities.invert(r, u[1], s.theta) - s.theta
        } else {
            let densities = &self.tables.backward.densities;
            let u0 = (u[0] - forward) / (1.0 - forward).max(f32::MIN_POSITIVE);
            let (r, _) = choose(&s.backward, &self.backward_integrals, u0);
            densities.invert(r, u[1], 0.0)
        };
        theta * s.mirror_theta
    }
}

/// The weights of a mixture with τ and g put in.
fn collapse<const C: usize>(mixture: &Mixture<C>, tau: f32, g: f32) -> Weights<C> {
    let [tau_rows, g_rows, _] = &mixture.factors;
    product(&tau_rows.at(on(tau, tau_rows.nodes())), &g_rows.at(on(g, g_rows.nodes())))
}

/// Position in [0, 1] on an axis of that many nodes.
#[inline(always)]
fn on(position: f32, nodes: usize) -> Between {
    Between::new(position * (nodes - 1) as f32, nodes)
}
