//! D19 and D20: the azimuth of scattered light that leaves the fibre.
//!
//! Light that leaves the medulla at the azimuth ψ and the offset h‴ is turned by δ = asin h_o − asin h_i where it
//! leaves the fibre. Here h_i = κ h‴ is its offset inside the fibre, and h_o = η′ h_i. In the mean over light of one
//! ψ, h‴ is close to a constant plus a sine of ψ: light that goes straight on has h‴ = h″, and light that a dense
//! medulla sends back leaves close to where it entered. So φ ≈ ψ + α + 2 Re(i a e^(−iψ)).
//!
//! The Möbius transformation of the circle e^(iφ) = e^(iα) (e^(iψ) − a)/(1 − ā e^(iψ)), |a| < 1, does this to first
//! order. It is one to one, its inverse is as simple, and dψ/dφ = (1 − |a|²)/|1 + a e^(−i(φ − α))|². So the density of
//! light stays exact, not negative, and easy to sample.
//!
//! Light that leaves later is uniform in the azimuth if the medulla is thin. A dense medulla keeps it close to where it
//! entered. Its density is that of a wrapped Cauchy distribution: a uniform one under the same kind of transformation.

use crate::cylinder::path::{Path, Route, times};
use crate::exit::table::ExitTable;
use crate::fiber::Fiber;
use crate::medulla::cone::Cone;
use crate::simd::lanes::Lanes;
use wide::f32x8;

/// The largest real and imaginary part of a.
pub const MOST_TURN: f32 = 0.45;

/// How the cuticle of one fibre turns scattered light that leaves at its first encounter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turning {
    /// The angles of the constant, of cos ψ and of sin ψ, radians: per h″, per h″, and per 1 − h″².
    pub parts: [f32; 3],
    /// The slope of δ over h‴.
    pub slope: f32,
    /// The share of light that hardly changed its direction: it is turned as TT is.
    pub straight: f32,
    /// 1/κ.
    inverse_kappa: f32,
    /// What is left of the direction of light that leaves later.
    pub stays: f32,
}

/// A transformation of azimuths, without its rotation: e^(iφ) = (e^(iψ) − a)/(1 − ā e^(iψ)).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn<V> {
    /// The real and the imaginary part of a.
    pub a: [V; 2],
}

/// How the scattered light of one path leaves the fibre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turns<V> {
    /// TTˢ and TRTˢ, as functions of φ.
    pub first: [Turn<V>; 2],
    /// Light that leaves later.
    pub later: Turn<V>,
}

impl Turning {
    /// The medulla must scatter.
    pub fn new(fiber: &Fiber, cone: &Cone, stays: f32, table: &ExitTable) -> Self {
        let tau = fiber.sigma_ms * fiber.kappa;
        Turning {
            parts: table.turns(tau, fiber.g, cone.reach).map(|x| x * cone.slope),
            slope: cone.slope,
            straight: fiber.g.powi(4) * (-tau * (1.0 - fiber.g)).exp(),
            inverse_kappa: 1.0 / fiber.kappa,
            stays,
        }
    }

    /// α and a for a path of offset h″ in the medulla, with its sign.
    #[inline(always)]
    pub fn at<V: Lanes>(&self, cos_o: V, path: &Path<V>) -> (V, [V; 2]) {
        let h = self.offset(path);
        let [constant, cosine, sine] = self.parts.map(V::splat);
        let limit = |x: V| x.max(V::splat(-MOST_TURN)).min(V::splat(MOST_TURN));
        let more = V::splat(self.straight) * cos_o * (path.gamma_o - path.gamma_t - h * V::splat(self.slope));
        let half = V::splat(0.5);
        (-(h * constant), [limit(half * (V::splat(1.0) - h * h) * sine), -limit(half * (h * cosine + more))])
    }

    /// h″, in [−1, 1].
    #[inline(always)]
    fn offset<V: Lanes>(&self, path: &Path<V>) -> V {
        (path.h_inside * V::splat(self.inverse_kappa)).max(V::splat(-1.0)).min(V::splat(1.0))
    }

    /// The transformations of a path of offset `h` on the fibre, with α, which is added to Φˢ, and about the angle by
    /// which light that goes straight on is turned.
    #[inline(always)]
    pub fn all<V: Lanes>(&self, cos_o: V, h: V, route: &impl Route<V>) -> (Turns<V>, [V; 2]) {
        let path = route.path();
        let (shift, a) = self.at(cos_o, path);
        let ahead = shift + a[1] + a[1];
        let [first, second, entry] = route.rotations(h, self.offset(path));
        // |α| is at most 0.3, so the series are exact to single precision.
        let (one, square) = (V::splat(1.0), shift * shift);
        let cos = one - square * (V::splat(0.5) - square * V::splat(1.0 / 24.0));
        let sin = shift * (one - square * (V::splat(1.0 / 6.0) - square * V::splat(1.0 / 120.0)));
        let a = times(a, [cos, sin]);
        let stays = V::splat(-self.stays);
        let first = [first, second].map(|rotation| Turn { a: times(a, rotation) });
        (Turns { first, later: Turn { a: entry.map(|x| stays * x) } }, [shift, ahead])
    }
}

impl<V: Lanes> Turn<V> {
    /// No change.
    pub fn none() -> Self {
        Turn { a: [V::splat(0.0); 2] }
    }

    /// 1 + a e^(−iφ), from the cosine and the sine of φ. Twice its angle is ψ − φ.
    #[inline(always)]
    pub fn inverse(&self, [cos, sin]: [V; 2]) -> [V; 2] {
        let [a, b] = self.a;
        [V::splat(1.0) + (a * cos + b * sin), b * cos - a * sin]
    }

    /// dψ/dφ, from [`Turn::inverse`].
    #[inline(always)]
    pub fn slope(&self, [re, im]: [V; 2]) -> V {
        let [a, b] = self.a;
        (V::splat(1.0) - (a * a + b * b)) / (re * re + im * im)
    }

    /// The density of light over the azimuth, times 2π, if it was uniform before.
    #[inline(always)]
    pub fn of_uniform(&self, around: [V; 2]) -> V {
        self.slope(self.inverse(around))
    }

    /// φ of ψ.
    pub fn leaving(&self, lane: usize, psi: f32) -> f32 {
        let [a, b] = self.a.map(|x| x.lane(lane));
        let (sin, cos) = psi.sin_cos();
        psi + 2.0 * (a * sin - b * cos).atan2(1.0 - (a * cos + b * sin))
    }
}

impl Turn<f32> {
    /// The same in all lanes.
    pub fn repeated(&self) -> Turn<f32x8> {
        Turn { a: self.a.map(f32x8::splat) }
    }
}

impl Turns<f32> {
    /// The same in all lanes.
    pub fn repeated(&self) -> Turns<f32x8> {
        Turns { first: [self.first[0].repeated(), self.first[1].repeated()], later: self.later.repeated() }
    }
}

/// The share of light that stays on the side where it entered, for light that leaves later: its mean of e^(i(φ − φ_c)),
/// where φ_c is the azimuth of the point where it entered the medulla.
///
/// `tau` is the optical radius of isotropic scattering, `keeps` the mean of e^(iδ) of a reflection at the cuticle, and
/// `reflected` its mean reflectance. A pass through the medulla has the factor (τ − 1.15)/(τ + 0.79), by photon
/// tracing. Light that is reflected n times passes the medulla n + 1 times, and leaves around the normal.
pub(crate) fn stays(tau: f32, keeps: f32, reflected: f32) -> f32 {
    let pass = (tau - 1.15).max(0.0) / (tau + 0.79);
    let again = pass * keeps;
    0.68 * pass * again * (1.0 - reflected) / (1.0 - again * reflected)
}
