//! The geometry of the path in the fibre, and the energy of each lobe: everything that depends only on ω_o and h
//! (Yan17 Table 3, Sec. 4.2–4.3).

use crate::cylinder::cuticle::{Fresnel, parts, refracted_cos2};
use crate::exit::Entry;
use crate::fiber::Fiber;
use crate::fiber::exit::ScatterExit;
use crate::lobe::Component;
use crate::prepared::Prepared;
use crate::simd::lanes::{Lanes, Quad};

/// The path of light that entered the fibre at offset h. Lengths are in fibre radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path<V> {
    /// 1/η′.
    pub inverse_eta: V,
    /// h′ = h/η′ = sin γ_t, the offset of the refracted path from the axis.
    pub h_inside: V,
    /// γ_o = asin h.
    pub gamma_o: V,
    /// γ_t = asin h′, the angle of the refracted path.
    pub gamma_t: V,
    /// asin h″, the angle of the path's offset in the medulla. ±90° if the path misses the medulla.
    pub gamma_m: V,
    /// The inclination at which C^M is looked up: θ_o, or θ_t if the cuticle refracts scattered light (D18).
    pub theta: V,
    /// Half of the path inside the cortex and half of the path inside the medulla, in the normal plane.
    pub s_c: V,
    pub s_m: V,
    /// 1/cos θ_t: the length of the inclined path relative to its projection.
    pub elongation: V,
    /// 1/cos θ_o, at most 1e12.
    pub inverse_cos_o: V,
    pub fresnel: Fresnel<V>,
    /// sin²θ_t.
    pub sin2_t: V,
    /// cos γ_o and cos γ_t.
    pub cosines: [V; 2],
}

/// One pass of light through the fibre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass<V: Lanes> {
    /// T, RGB, and the share that is not scattered.
    pub through: V::Quad,
    /// Q, the share that is scattered (D5: Q is explicit, and the distributions are densities).
    pub scattered: V,
    /// What is left of scattered light when it leaves.
    pub escape: V::Quad,
}

impl<V: Lanes> Pass<V> {
    /// A pass with half of `s_c` in the cortex, half of `s_m` in the medulla, whose share of a diameter is `chord`.
    /// `mean_path` is ⟨L⟩ of scattered light. An `entry` replaces it.
    #[inline(always)]
    pub fn new(
        fiber: &Fiber,
        elongation: V,
        [s_c, s_m, chord]: [V; 3],
        mean_path: V,
        entry: Option<&Entry<V>>,
    ) -> Self {
        let quad = V::Quad::splat;
        let rgb = |c: [f32; 3]| V::Quad::constant([c[0], c[1], c[2], 0.0]);
        let (sigma_ca, sigma_ma) = (rgb(fiber.sigma_ca), rgb(fiber.sigma_ma));
        let kappa = V::splat(fiber.kappa);
        let minus = -elongation;
        // There is no absorption in the spare channel, so it is the unscattered fraction.
        let two = V::splat(2.0) * minus;
        let unscattered = two * s_m * V::splat(fiber.sigma_ms);
        let through = quad(two * s_c) * sigma_ca + quad(two * s_m) * sigma_ma + quad(unscattered);
        // Entry through the cortex. D7: absorption after scattering over the mean scattered path ⟨L⟩, not the paper's
        // fixed κ. D17: or the share of scattered light that leaves.
        let (through, escape) = match entry {
            None => {
                let rest = s_c + V::splat(1.0) - kappa;
                let escape = quad(rest * minus) * sigma_ca + quad(kappa * mean_path * minus) * sigma_ma;
                (through.exp(), escape.exp())
            }
            Some(entry) => {
                let [escape, ln_kept] = entry.escape(chord);
                (through.exp(), escape * (quad(s_c * minus) * sigma_ca + ln_kept).exp())
            }
        };
        Pass { through, scattered: unscattered_complement(unscattered, through.array()[3]), escape }
    }
}

impl<V: Lanes> Path<V> {
    /// D2: the elongation and η′ use θ_o, not the paper's half angle θ_d. This is the true path inside the fibre, and
    /// it does not depend on ω_i.
    #[inline(always)]
    pub fn new(fiber: &Fiber, sin_o: V, cos_o: V, h: V) -> Self {
        let (zero, one) = (V::splat(0.0), V::splat(1.0));
        let eta = fiber.eta;
        // Square roots and divisions are the slowest operations. They are computed four at a time.
        let sin_t = sin_o * V::splat(1.0 / eta);
        let cos2 = cos_o * cos_o;
        // 1/η′ = cos θ_o/√(η² − sin²θ_o), in a form without cancellation for η → 1 and for grazing light.
        let excess = V::splat((eta - 1.0) * (eta + 1.0)) + cos2;
        let cos2_gamma_o = ((one - h) * (one + h)).max(zero);
        let roots = V::Quad::new([
            excess.max(V::splat(1e-20)),
            cos2_gamma_o,
            ((one - sin_t) * (one + sin_t)).max(V::splat(1e-12)),
            refracted_cos2(eta, cos2 * cos2_gamma_o),
        ]);
        let [excess, cos_gamma_o, cos_t, cos_refracted] = roots.sqrt().array();
        let [back, through] = parts(eta, fiber.layers, cos_o * cos_gamma_o, cos_refracted);
        let numerators = V::Quad::new([cos_o, one, one, one]);
        let quotients = numerators / V::Quad::new([excess, cos_t, back + through, cos_o.max(V::splat(1e-12))]);
        let [inverse_eta, elongation, fresnel, inverse_cos_o] = quotients.array();

        let h_inside = h * inverse_eta;
        let kappa = V::splat(fiber.kappa);
        let offset = h_inside.abs();
        let roots = V::Quad::new([
            ((one - h_inside) * (one + h_inside)).max(zero),
            ((kappa - offset) * (kappa + offset)).max(zero),
            one,
            one,
        ]);
        let [cos_gamma_t, s_m, ..] = roots.sqrt().array();
        // The cosine of asin h″ is s_m/κ.
        let (sin, cos) = match fiber.exit {
            ScatterExit::Open => (sin_o, cos_o),
            ScatterExit::Reflecting => (sin_t, cos_t),
        };
        let y = V::Quad::new([h, h_inside, h_inside, sin]);
        let x = V::Quad::new([cos_gamma_o, cos_gamma_t, s_m, cos]);
        let [gamma_o, gamma_t, gamma_m, theta] = y.atan2(x).array();
        Path {
            inverse_eta,
            h_inside,
            gamma_o,
            gamma_t,
            gamma_m,
            theta,
            s_c: (cos_gamma_t - s_m).max(zero),
            s_m,
            elongation,
            inverse_cos_o,
            fresnel: Fresnel { reflected: back * fresnel, transmitted: through * fresnel },
            sin2_t: sin_t * sin_t,
            cosines: [cos_gamma_o, cos_gamma_t],
        }
    }
}

/// The path of light in one kind of fibre. Code for all kinds is compiled for each, so that the others do not slow
/// round fibres down.
pub(crate) trait Route<V: Lanes>: Copy {
    /// The path of light that hits at the offset h, from the inclination with this sine and cosine, and from the
    /// azimuth with the cosine and the sine `toward`.
    fn trace(prepared: &Prepared, inclination: [V; 2], toward: [V; 2], h: V) -> Self;

    /// Its angles and lengths. Of other fibres than round ones, γ_o and γ_t are those of the first exit, with what the
    /// wall of the medulla turns in γ_t, and h′ and h″ are the offsets on the unit circle.
    fn path(&self) -> &Path<V>;

    /// Φₚ(h), the exit azimuth of R, TT, TRT relative to ω_o.
    fn exit_azimuth(&self, p: u8) -> V;

    /// The exit azimuths of R, TT and TRT at other offsets, for the ends of segments. `path` has the same ω_o.
    fn exits_at(&self, prepared: &Prepared, inclination: [V; 2], toward: [V; 2], h: V) -> [V; 3];

    /// Φˢₚ(h), the azimuth opposite to the direction of the light in its p-th pass (p = 1, 2). It is φ = 0 of the
    /// tables, straight back.
    #[doc(alias = "Eq. 21")]
    fn scattered_azimuth(&self, p: u8) -> V;

    /// The cosine and the sine of Φˢₚ, p = 1, 2, then those of the azimuth at which the path meets the medulla, for a
    /// path of offset `h` whose offset in the medulla is `h_medulla`.
    fn rotations(&self, h: V, h_medulla: V) -> [[V; 2]; 3];

    /// A(h) of the components in RGB and a spare channel: in the order of [`Component`].
    /// `mean_path` is ⟨L⟩ of the light scattered in this pass, if any. An `entry` replaces it.
    #[doc(alias = "Table 3")]
    fn attenuation(&self, fiber: &Fiber, mean_path: V, entry: Option<&Entry<V>>) -> [V::Quad; Component::COUNT];
}

/// The product of two complex numbers.
#[inline(always)]
pub(crate) fn times<V: Lanes>([a, b]: [V; 2], [c, d]: [V; 2]) -> [V; 2] {
    [a * c - b * d, a * d + b * c]
}

impl<V: Lanes> Route<V> for Path<V> {
    #[inline(always)]
    fn trace(prepared: &Prepared, inclination: [V; 2], _toward: [V; 2], h: V) -> Self {
        Path::new(&prepared.in_air, inclination[0], inclination[1], h)
    }

    #[inline(always)]
    fn path(&self) -> &Path<V> {
        self
    }

    #[inline(always)]
    fn exits_at(&self, _prepared: &Prepared, _inclination: [V; 2], _toward: [V; 2], h: V) -> [V; 3] {
        let [gamma_o, gamma_t] = angles(h, self.inverse_eta);
        [0, 1, 2].map(|p| exit_azimuth(p, gamma_o, gamma_t))
    }

    #[inline(always)]
    fn exit_azimuth(&self, p: u8) -> V {
        exit_azimuth(p, self.gamma_o, self.gamma_t)
    }

    #[inline(always)]
    fn scattered_azimuth(&self, p: u8) -> V {
        let q = f32::from(p - 1);
        self.gamma_t - self.gamma_o + V::splat(q) * (V::splat(std::f32::consts::PI) + V::splat(2.0) * self.gamma_t)
    }

    #[inline(always)]
    fn rotations(&self, h: V, h_medulla: V) -> [[V; 2]; 3] {
        let ([cos_o, cos_t], one) = (self.cosines, V::splat(1.0));
        let cos_medulla = ((one - h_medulla) * (one + h_medulla)).max(V::splat(0.0)).sqrt();
        let meets = |first| times(first, [cos_medulla, -h_medulla]);
        let first = times([cos_t, self.h_inside], [cos_o, -h]);
        let [cos, sin] = times(first, times([cos_t, self.h_inside], [cos_t, self.h_inside]));
        [first, [-cos, -sin], meets(first)]
    }

    #[inline(always)]
    fn attenuation(&self, fiber: &Fiber, mean_path: V, entry: Option<&Entry<V>>) -> [V::Quad; Component::COUNT] {
        let one = V::splat(1.0);
        let quad = V::Quad::splat;
        let Fresnel { reflected: f, transmitted: t } = self.fresnel;
        let chord = self.s_m * V::splat(1.0 / fiber.kappa.max(f32::MIN_POSITIVE));
        let lengths = [self.s_c, self.s_m, chord];
        let Pass { through: pass, scattered: q, escape } = Pass::new(fiber, self.elongation, lengths, mean_path, entry);

        let (f, t) = (quad(f), quad(t));
        let again = f * pass;
        let a_tt = t * t * pass;
        // D4: (1 − F) as in Yan17 Eq. 20; Table 3 prints F.
        let a_tts = t * escape * quad(q);
        // D6: all higher orders in closed form, with (1−F)/(1−F T) ≤ 1, whose denominator is computed without
        // cancellation. The two geometric series start after TRT and TRTˢ.
        let denominator = (t + f * (quad(one) - pass)).max(quad(V::splat(1e-20)));
        let series = again * again * (t / denominator);
        match entry {
            None => {
                let rest = (t * pass + escape * quad(q)) * series;
                [f, a_tt, a_tt * again, a_tts, a_tts * again, rest, quad(V::splat(0.0))]
            }
            // Light that the cuticle reflected after it was scattered, and light scattered in later passes, is diffuse.
            Some(entry) => {
                let [first, late] = entry.divide(chord, escape);
                let entered = t * quad(q);
                let (a_tts, a_late) = (entered * first, entered * late);
                let diffuse = a_late + a_late * again + escape * quad(q) * series;
                [f, a_tt, a_tt * again, a_tts, a_tts * again, t * pass * series, diffuse]
            }
        }
    }
}

/// 1/η′ of light at cos θ_o: cos θ_o/√(η² − sin²θ_o).
pub(crate) fn inverse_eta(eta: f32, cos_o: f32) -> f32 {
    cos_o / ((eta - 1.0) * (eta + 1.0) + cos_o * cos_o).max(1e-20).sqrt()
}

/// Φₚ of a path that enters at γ_o and continues at γ_t.
#[doc(alias = "Eq. 15")]
#[inline(always)]
pub(crate) fn exit_azimuth<V: Lanes>(p: u8, gamma_o: V, gamma_t: V) -> V {
    let p = f32::from(p);
    V::splat(2.0 * p) * gamma_t - V::splat(2.0) * gamma_o + V::splat(p * std::f32::consts::PI)
}

/// asin h and asin h′, h′ = h/η′.
#[inline(always)]
pub(crate) fn angles<V: Lanes>(h: V, inverse_eta: V) -> [V; 2] {
    let one = V::splat(1.0);
    let h_inside = h * inverse_eta;
    let cos = |h: V| ((one - h) * (one + h)).max(V::splat(0.0)).sqrt();
    V::atan2_pair([h, h_inside], [cos(h), cos(h_inside)])
}

/// The probability of each component in sampling, given A(h) of all components.
///
/// It is proportional to the largest channel. No channel of a sample's weight then exceeds the sum of the largest
/// channels, which is at most 1.
#[inline(always)]
pub(crate) fn probabilities<V: Lanes>(attenuation: &[V::Quad; Component::COUNT]) -> [V; Component::COUNT] {
    let mut probability = [V::splat(0.0); Component::COUNT];
    let mut sum = V::splat(f32::MIN_POSITIVE);
    for (p, a) in probability.iter_mut().zip(attenuation) {
        let [r, g, b, _] = a.array();
        *p = r.max(g).max(b);
        sum = sum + *p;
    }
    let inverse = V::splat(1.0) / sum;
    probability.map(|p| p * inverse)
}

/// 1 − eˣ for x ≤ 0, given `exp_x` = eˣ, without cancellation near 0.
#[inline(always)]
fn unscattered_complement<V: Lanes>(x: V, exp_x: V) -> V {
    let series = -x * (V::splat(1.0) + x * (V::splat(0.5) + x * V::splat(1.0 / 6.0)));
    // At |x| = 0.02 the relative error is x³/24 = 3e-7 for the series, and 6e-8/0.02 = 3e-6 for the difference.
    (-x).select_lt(V::splat(0.02), series, V::splat(1.0) - exp_x)
}
