//! The light scattered by the medulla: C^N, C^M and ⟨L⟩ looked up in the compressed tables.

pub(crate) mod cone;
#[cfg_attr(not(feature = "unstable"), allow(dead_code, reason = "the tables' makers need all of the grid"))]
pub mod grid;
pub(crate) mod mixture;
pub(crate) mod tables;
#[cfg(feature = "unstable")]
pub(crate) mod weighting;

use crate::cylinder::azimuthal::wrap;
use crate::cylinder::frame::Refraction;
use crate::fiber::Fiber;
use crate::fiber::exit::ScatterExit;
use crate::medulla::cone::{Cone, Cones};
use crate::medulla::mixture::{Between, Weights, choose, dot, normaliser, product};
use crate::medulla::tables::{AZIMUTHAL, BACKWARD, FORWARD, Mixture, OFFSETS, Tables};
use crate::simd::lanes::Lanes;
use std::f32::consts::{PI, TAU};
use wide::bytemuck::cast;
use wide::{f32x8, i32x8, u32x8};

/// The tables for the g of one fibre. The longitudinal tables are also for its τ. Prepared once per fibre.
#[derive(Clone, Debug)]
pub struct Medulla<'t> {
    tables: &'t Tables,
    pub(crate) azimuthal: Weights<AZIMUTHAL>,
    pub(crate) backward: Weights<BACKWARD>,
    pub(crate) forward: Weights<FORWARD>,
    pub(crate) g: Between,
    /// The integrals of the backward components, the same for every hit.
    pub(crate) backward_integrals: Weights<BACKWARD>,
    /// How the cuticle refracts scattered light.
    pub(crate) refraction: Refraction,
    /// b of its transmittance T(s) = 1 − b s⁴, in [0, 1].
    loss: f32,
    /// How scattered light leaves through a cuticle that reflects.
    pub(crate) cone: Option<(Cone, &'t Cones)>,
    /// σ_ms κ
    pub(crate) optical_radius: f32,
    /// g itself.
    anisotropy: f32,
}

/// C^N of one path through the medulla, as the weights of its components.
#[derive(Clone, Copy, Debug)]
pub struct Azimuth {
    pub(crate) weights: Weights<AZIMUTHAL>,
    /// The factor that makes it integrate to 1, or its product with C^M of the light that leaves.
    pub(crate) scale: f32,
    /// −1 if h″ < 0: the profile is mirrored, (h, φ) → (−h, −φ).
    pub(crate) mirror: f32,
    /// The share of the profile that is mirrored, one half at h″ = 0: see [`grid::mirrored_share`].
    pub(crate) turned: f32,
}

/// C^M for one θ_o, as the weights of its components. It is the same for every offset.
#[derive(Clone, Copy, Debug)]
pub struct Inclination {
    pub(crate) backward: Weights<BACKWARD>,
    pub(crate) forward: Weights<FORWARD>,
    /// The factors that make each half integrate to `leaving`.
    pub(crate) scale: [f32; 2],
    /// The shares of the halves that leave the fibre, up to a common factor. They are 1 if the cuticle does not
    /// reflect scattered light.
    pub(crate) leaving: [f32; 2],
    /// The shift of the forward lobe: |θ_o|, or |θ_t| if the cuticle refracts scattered light.
    pub(crate) theta: f32,
    /// −1 if θ_o < 0: (θ_o, θᵢ) → (−θ_o, −θᵢ).
    mirror: f32,
}

impl Azimuth {
    /// No light.
    pub const NONE: Azimuth = Azimuth { weights: [f32x8::ZERO; AZIMUTHAL], scale: 0.0, mirror: 1.0, turned: 0.0 };
}

impl Inclination {
    /// No light.
    pub const NONE: Inclination = Inclination {
        backward: [f32x8::ZERO; BACKWARD],
        forward: [f32x8::ZERO; FORWARD],
        scale: [0.0; 2],
        leaving: [1.0; 2],
        theta: 0.0,
        mirror: 1.0,
    };
}

/// ⟨L⟩ at the nodes of h″.
pub(crate) type MeanPaths = [f32x8; OFFSETS / 8];

/// The azimuthal table for the τ of one elongation.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    weights: Weights<AZIMUTHAL>,
    tau: Between,
}

impl<'t> Medulla<'t> {
    /// The tables that it was made with.
    pub(crate) fn tables(&self) -> &'t Tables {
        self.tables
    }

    /// Interpolates the tables at a fibre's g and σ_m,s κ.
    pub fn new(fiber: &Fiber, tables: &'t Tables) -> Self {
        let optical_radius = fiber.sigma_ms * fiber.kappa;
        let g_position = grid::g_position(f64::from(fiber.g)) as f32;
        // D12: C^M is simulated with inclined rays, so its τ is σ_ms κ. C^N is simulated in the normal plane, so it
        // needs the elongation 1/cos θ_t.
        let tau_position = grid::tau_position(f64::from(optical_radius)) as f32;
        let g_rows = &tables.azimuthal.factors[1];
        let reflects = fiber.exit == ScatterExit::Reflecting && optical_radius > 0.0;
        let cone = reflects.then(|| (Cone::new(fiber), tables.cones()));
        Medulla {
            tables,
            azimuthal: g_rows.at(on(g_position, g_rows.nodes())),
            backward: collapse(&tables.backward, tau_position, g_position),
            forward: collapse(&tables.forward, tau_position, g_position),
            g: on(g_position, tables.mean_path_nodes[1]),
            backward_integrals: match &cone {
                Some((cone, cones)) => cone.backward(cones),
                None => tables.backward.densities.integrals(0.0),
            },
            refraction: cone.map_or(Refraction::NONE, |(cone, _)| Refraction::new(cone.inverse_eta)),
            loss: cone.map_or(0.0, |(cone, _)| cone.loss),
            cone,
            optical_radius,
            anisotropy: fiber.g,
        }
    }

    /// Whether the medulla scatters.
    pub fn exists(&self) -> bool {
        self.optical_radius > 0.0
    }

    /// The half width of the forward peak of C^N, radians. It is about 1 − g for single scattering, and larger for
    /// multiple scattering.
    pub(crate) fn peak_width(&self) -> f32 {
        (1.0 - self.anisotropy) * 0.7f32.mul_add(self.optical_radius, 1.0).min(8.0)
    }

    /// Whether C^N is smooth in the azimuth and in the offset. By experiment, it is up to g = 0.7, and up to g = 0.85
    /// for an optical radius of at least 2.
    pub(crate) fn is_smooth(&self) -> bool {
        self.anisotropy <= 0.7 || (self.anisotropy <= 0.85 && self.optical_radius > 2.0)
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

    /// The position, in [0, 1], on the axis of τ for light with this elongation: [`grid::tau_position`] in single
    /// precision. 1 + kτ rounds at 6e-8, 1e-8 of the axis.
    #[inline(always)]
    pub fn tau_position<V: Lanes>(&self, elongation: V) -> V {
        let scale = grid::TAU_SCALE as f32 * self.optical_radius;
        (V::splat(1.0) + V::splat(scale) * elongation).ln() * V::splat(1.0 / grid::TAU_GROWTH as f32)
    }

    /// Interpolates the azimuthal table at `tau`, a position from [`Medulla::tau_position`].
    #[inline(always)]
    pub fn pass(&self, tau: f32) -> Pass {
        let rows = &self.tables.azimuthal.factors[0];
        let tau = on(tau, rows.nodes());
        Pass { weights: product(&rows.at(tau), &self.azimuthal), tau }
    }

    /// Prepares C^N for a path. `angle` is asin h″ with its sign.
    #[inline(always)]
    #[cfg(any(test, feature = "unstable"))]
    pub fn azimuth(&self, pass: &Pass, angle: f32) -> Azimuth {
        self.azimuth_leaving(pass, angle, [1.0; 2])
    }

    /// The same for light of which only a part leaves the fibre: [`Inclination::leaving`]. The product of C^N and C^M
    /// is then normalised, and its azimuths are those of the light that leaves.
    #[inline(always)]
    pub(crate) fn azimuth_leaving(&self, pass: &Pass, angle: f32, [backward, forward]: [f32; 2]) -> Azimuth {
        let densities = &self.tables.azimuthal.densities;
        let weights = product(&self.tables.azimuthal.factors[2].at(self.offset(angle)), &pass.weights);
        let (backward, more) = (f32x8::splat(backward), f32x8::splat(forward - backward));
        let shares = densities.forward();
        let mut sum = f32x8::ZERO;
        for c in 0..AZIMUTHAL {
            sum = weights[c].mul_add(shares[c].mul_add(more, backward), sum);
        }
        let sum = sum.reduce_add();
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        let x = (angle.abs() * grid::MIRROR_REACH_INVERSE).min(1.0);
        Azimuth { weights, scale, mirror: 1f32.copysign(angle), turned: 0.5 * (1.0 - x) * (1.0 - x) }
    }

    /// ⟨L⟩ of a path.
    #[inline(always)]
    pub fn mean_path_of(&self, pass: &Pass, angle: f32) -> f32 {
        self.mean_path(pass.tau, self.offset(angle))
    }

    /// ⟨L⟩ at the nodes of h″, for many paths.
    #[inline(always)]
    pub(crate) fn mean_paths(&self, pass: &Pass) -> MeanPaths {
        let [_, n_g, _] = self.tables.mean_path_nodes;
        let row = |tau: usize, g: usize| self.tables.mean_path_rows.row(tau * n_g + g);
        let (tau, g) = (pass.tau, self.g);
        let rows = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| row(tau.index + i, g.index + j));
        let weights = [(1.0 - tau.t) * (1.0 - g.t), (1.0 - tau.t) * g.t, tau.t * (1.0 - g.t), tau.t * g.t];
        let mut paths = [f32x8::ZERO; OFFSETS / 8];
        for (row, weight) in rows.into_iter().zip(weights) {
            (0..OFFSETS / 8).for_each(|k| paths[k] = row[k].mul_add(f32x8::splat(weight), paths[k]));
        }
        paths
    }

    /// ⟨L⟩ of eight paths, from [`Medulla::mean_paths`].
    #[inline(always)]
    pub(crate) fn mean_paths_at(&self, paths: &MeanPaths, angle: f32x8) -> f32x8 {
        let last = self.tables.mean_path_nodes[2] - 2;
        let x = angle.abs() * f32x8::splat(std::f32::consts::FRAC_2_PI * (last + 1) as f32);
        // NaN may become any node. The result is then undefined.
        let node = x.fast_min(f32x8::splat(last as f32)).fast_trunc_int();
        let t = x - f32x8::from_i32x8(node);
        let (low, high) = (lookup(paths, node), lookup(paths, node + i32x8::ONE));
        (high - low).mul_add(t, low)
    }

    #[inline(always)]
    fn offset(&self, angle: f32) -> Between {
        on(angle.abs() * std::f32::consts::FRAC_2_PI, self.tables.azimuthal.factors[2].nodes())
    }

    /// Prepares C^M for the inclination at which light enters, with its sign: θ_o, or θ_t if the cuticle refracts
    /// scattered light.
    #[inline(always)]
    pub fn inclination(&self, theta: f32) -> Inclination {
        let Tables { backward, forward, .. } = self.tables;
        let shift = theta.abs();
        let theta_rows = &forward.factors[2];
        let position = on(shift * (1.0 / grid::THETA_MAX as f32), theta_rows.nodes());
        let w_b = product(&backward.factors[2].at(position), &self.backward);
        let w_f = product(&theta_rows.at(position), &self.forward);
        let (scale, leaving) = match &self.cone {
            // D18: with refraction, a density in sin θᵢ = η sin θ′.
            Some((cone, cones)) => {
                let all_b = backward.densities.total_at_0(&w_b);
                let all_f = forward.densities.total(&w_f, shift) * cone.backward_gain;
                let leaving = [dot(&w_b, &self.backward_integrals), dot(&w_f, &cone.forward(cones, shift))];
                // The halves are divided by their totals. The common factor of both totals has no effect.
                ([all_f, all_b].map(|scale| scale * cone.inverse_eta), [all_f * leaving[0], all_b * leaving[1]])
            }
            None => {
                let integrals = forward.densities.integrals(shift);
                ([normaliser(&w_b, &self.backward_integrals), normaliser(&w_f, &integrals)], [1.0; 2])
            }
        };
        Inclination { backward: w_b, forward: w_f, scale, leaving, theta: shift, mirror: 1f32.copysign(theta) }
    }

    /// C^N at azimuth `phi` from straight back, in [−π, π]: a density per radian.
    #[doc(alias = "Eq. 10")]
    #[inline(always)]
    pub fn azimuthal(&self, s: &Azimuth, phi: f32) -> f32 {
        let value = self.azimuthal_plain(s, phi);
        if s.turned > 0.0 { value + s.turned * (self.azimuthal_plain(s, -phi) - value) } else { value }
    }

    /// [`Medulla::azimuthal`] without the mirrored share.
    #[inline(always)]
    pub(crate) fn azimuthal_plain(&self, s: &Azimuth, phi: f32) -> f32 {
        let phi = phi * s.mirror;
        s.scale * self.tables.azimuthal.densities.eval(&s.weights, if phi < 0.0 { phi + TAU } else { phi })
    }

    /// [`Medulla::azimuthal`] of eight paths with h″ ≥ 0, neither scaled nor mirrored.
    #[inline(always)]
    pub(crate) fn azimuthal8(&self, weights: [&Weights<AZIMUTHAL>; 8], phi: f32x8) -> f32x8 {
        let turned = phi.simd_lt(f32x8::ZERO).select(phi + f32x8::splat(TAU), phi);
        self.tables.azimuthal.densities.eval8(weights, turned)
    }

    /// C^M of the backward and the forward half at θᵢ, densities in sin θᵢ.
    #[doc(alias = "Eq. 19")]
    #[inline(always)]
    #[cfg(any(test, feature = "unstable"))]
    pub fn longitudinal(&self, s: &Inclination, theta_i: f32) -> [f32; 2] {
        self.leaving(s, theta_i, 1.0)
    }

    /// [`Medulla::longitudinal`] of light that leaves the fibre with this [`Medulla::transmittance`]. `theta` is θᵢ, or
    /// θ′ inside the fibre if the cuticle refracts scattered light.
    #[inline(always)]
    pub(crate) fn leaving(&self, s: &Inclination, theta: f32, transmittance: f32) -> [f32; 2] {
        let theta = theta * s.mirror;
        [
            s.scale[0] * transmittance * self.tables.backward.densities.eval(&s.backward, theta),
            s.scale[1] * transmittance * self.tables.forward.densities.eval(&s.forward, theta + s.theta),
        ]
    }

    /// T(sin θᵢ), at least 0: the factor of C^M for light that leaves the fibre. It is 1 if the cuticle does not
    /// reflect scattered light.
    #[inline(always)]
    pub(crate) fn transmittance<V: Lanes>(&self, sin_i: V) -> V {
        if self.loss == 0.0 {
            return V::splat(1.0);
        }
        let square = sin_i * sin_i;
        (V::splat(1.0) - V::splat(self.loss) * (square * square)).max(V::splat(0.0))
    }

    /// Draws an azimuth from straight back, in [−2π, 2π], from C^N. D10: sampling from the tables is exact.
    #[cfg(any(test, feature = "unstable"))]
    pub fn sample_azimuth(&self, s: &Azimuth, u: f32) -> f32 {
        s.mirror * self.sample_profile(&s.weights, s.turned, u)
    }

    /// Draws an azimuth, in [−2π, 2π], from C^N with these weights, for a path with h″ ≥ 0. The share `turned` is
    /// mirrored.
    fn sample_profile(&self, weights: &Weights<AZIMUTHAL>, turned: f32, u: f32) -> f32 {
        let (r, u) = choose(weights, &[f32x8::ONE; AZIMUTHAL], u);
        mirrored(turned, u, |u| self.tables.azimuthal.densities.invert(r, u, 0.0))
    }

    /// Draws sin θᵢ and cos θᵢ of light that leaves the fibre, and its azimuth from straight back, in [−2π, 2π], for a
    /// path with h″ ≥ 0. `weights` and `turned`: see [`Azimuth`]. `u`: two numbers for θᵢ, and one for the azimuth.
    #[inline(always)]
    pub(crate) fn sample_leaving(
        &self,
        weights: &Weights<AZIMUTHAL>,
        turned: f32,
        s: &Inclination,
        u: [f32; 3],
    ) -> ((f32, f32), f32) {
        match &self.cone {
            Some((cone, cones)) => self.sample_refracted((cone, cones), weights, turned, s, u),
            None => {
                let phi = self.sample_profile(weights, turned, u[2]);
                (self.sample_inclination(s, wrap(phi), [u[0], u[1]]).sin_cos(), phi)
            }
        }
    }

    /// Draws θᵢ from C^M for an azimuth `phi` in [−π, π] from straight back: first a half, in proportion to the
    /// interpolation weight, then a component, then the angle.
    pub fn sample_inclination(&self, s: &Inclination, phi: f32, u: [f32; 2]) -> f32 {
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
        theta * s.mirror
    }

    /// [`Medulla::sample_leaving`] of light that the cuticle refracts.
    ///
    /// It first draws a half of C^M in proportion to its light that leaves. Then it draws the azimuth under the weight
    /// of that half, and θ′ inside the escape cone. sin θᵢ = η sin θ′.
    #[inline(never)]
    fn sample_refracted(
        &self,
        (cone, cones): (&Cone, &Cones),
        weights: &Weights<AZIMUTHAL>,
        turned: f32,
        s: &Inclination,
        u: [f32; 3],
    ) -> ((f32, f32), f32) {
        let Tables { azimuthal, backward, forward, .. } = self.tables;
        let shares = [azimuthal.densities.backward(), *azimuthal.densities.forward()];
        let [back, ahead] = [0, 1].map(|half| dot(weights, &shares[half]) * s.leaving[half]);
        let share = ahead / (back + ahead).max(f32::MIN_POSITIVE);
        let is_forward = u[0] < share;
        let (r, u2) = choose(weights, &shares[usize::from(is_forward)], u[2]);
        let phi = mirrored(turned, u2, |u| azimuthal.densities.invert_half(r, u, is_forward));
        let theta = if is_forward {
            let (r, _) = choose(&s.forward, &cone.forward(cones, s.theta), u[0] / share);
            cones.forward.invert(&forward.densities, cone, r, u[1], s.theta) - s.theta
        } else {
            let u0 = (u[0] - share) / (1.0 - share).max(f32::MIN_POSITIVE);
            let (r, _) = choose(&s.backward, &self.backward_integrals, u0);
            cones.backward.invert(&backward.densities, cone, r, u[1], 0.0)
        };
        let sin = (cone.eta * theta.sin() * s.mirror).clamp(-1.0, 1.0);
        ((sin, ((1.0 - sin) * (1.0 + sin)).sqrt()), phi)
    }
}

/// An azimuth from an inverted cumulative density, of which the share `turned` is mirrored. `u` decides whether to
/// mirror, and its rest is then scaled to [0, 1).
fn mirrored(turned: f32, u: f32, invert: impl Fn(f32) -> f32) -> f32 {
    if u < turned {
        -invert(u / turned)
    } else if turned > 0.0 {
        invert((u - turned) / (1.0 - turned))
    } else {
        invert(u)
    }
}

/// The weights of a mixture for given τ and g.
fn collapse<const C: usize>(mixture: &Mixture<C>, tau: f32, g: f32) -> Weights<C> {
    let [tau_rows, g_rows, _] = &mixture.factors;
    product(&tau_rows.at(on(tau, tau_rows.nodes())), &g_rows.at(on(g, g_rows.nodes())))
}

/// The values at eight indices.
#[inline(always)]
fn lookup(values: &[f32x8; OFFSETS / 8], index: i32x8) -> f32x8 {
    let index: u32x8 = cast(index);
    let (within, eights) = (index & u32x8::splat(7), index >> u32x8::splat(3));
    let mut found = u32x8::ZERO;
    for (k, eight) in values.iter().enumerate() {
        let here = eights.simd_eq(u32x8::splat(k as u32));
        found |= cast::<f32x8, u32x8>(*eight).shuffle(within) & here;
    }
    cast(found)
}

/// A position in [0, 1] on an axis with this number of nodes.
#[inline(always)]
fn on(position: f32, nodes: usize) -> Between {
    Between::new(position * (nodes - 1) as f32, nodes)
}
