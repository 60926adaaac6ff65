//! The path of light in a fibre whose section is an ellipse (D23), or whose medulla has an index of its own (D24).
//!
//! In the normal plane, light follows the ray optics of a section with the index η′ (Bravais), whatever its shape. The
//! ray is traced from crossing to crossing. A section is drawn onto the unit circle by dividing each axis by its
//! length: straight rays stay straight, and offsets relative to the projected width stay what they are. The medulla has
//! the same ratio of axes, so that it becomes a circle of radius κ.
//!
//! Lengths are in units of √(ab), the radius of the circle of the same area, and absorption coefficients are per this
//! radius: a flatter fibre keeps its colour.
//!
//! The wall of a medulla with air reflects a part of the light, all of it beyond the critical angle, and refracts the
//! rest. TT and TRT then follow the brighter of two paths in each pass: along the wall's reflection, or through the
//! medulla. Unscattered light of all other paths is even in azimuth, in the rest lobe.

use crate::cylinder::cuticle::{Fresnel, parts, refracted_cos2};
use crate::cylinder::path::{Pass, Path, Route, inverse_eta, times};
use crate::exit::Entry;
use crate::fiber::Fiber;
use crate::fiber::exit::ScatterExit;
use crate::lobe::Component;
use crate::prepared::Prepared;
use crate::simd::lanes::{Lanes, Quad};
use std::f32::consts::PI;
use wide::f32x8;

/// A section that is not a circle of one index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    /// The semi-axes along y and z of the fibre's frame, in units of √(ab). The first is the longer.
    axes: [f32; 2],
    /// The index of the medulla, if it is not that of the cortex.
    medulla: Option<f32>,
}

/// A path in such a section.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bent<V> {
    path: Path<V>,
    /// The exit azimuths of R, TT and TRT relative to ω_o.
    exit: [V; 3],
    /// Φˢ₁ and Φˢ₂.
    scattered: [V; 2],
    /// The cosine and the sine of Φˢ₁, and those of Φˢ₂.
    rotations: [[V; 2]; 2],
    /// The first and the second pass.
    passes: [Leg<V>; 2],
    /// Whether the medulla has a wall.
    walls: bool,
    /// F at the second and the third crossing.
    inside: [Fresnel<V>; 2],
}

/// A pass through the section. Lengths are halves, in the normal plane.
#[derive(Clone, Copy, Debug)]
struct Leg<V> {
    s_c: V,
    s_m: V,
    /// √(1 − h″²), or 0 if it misses the medulla.
    chord: V,
    /// The reflectance of the medulla's wall, and 1 if the path is the reflected one, or 0.
    wall: [V; 2],
}

/// What depends on the inclination, for a medulla of its own index.
#[derive(Clone, Copy)]
struct Inner<V> {
    /// η over the index of the medulla.
    relative: f32,
    /// The index in the normal plane of the medulla over that of the cortex, at most 1.
    ratio: V,
    /// The cosines of the inclination in cortex and medulla.
    cosines: [V; 2],
    /// σ_ms over the second cosine.
    scattering: V,
}

/// A point of the unit circle and the direction from which the ray came to it.
#[derive(Clone, Copy)]
struct Ray<V> {
    point: [V; 2],
    back: [V; 2],
}

/// A crossing from inside: the point, its normal, the sine and the cosine of the ray's angle to it, and the offset of
/// the pass on the circle.
struct Crossing<V> {
    point: [V; 2],
    normal: [V; 2],
    sin: V,
    cos: V,
    leg: Leg<V>,
    offset: V,
    /// The direction from which light came, at the end and in the medulla.
    back: [V; 2],
    within: [V; 2],
}

fn dot<V: Lanes>(a: [V; 2], b: [V; 2]) -> V {
    a[0] * b[0] + a[1] * b[1]
}

fn cross<V: Lanes>(a: [V; 2], b: [V; 2]) -> V {
    a[0] * b[1] - a[1] * b[0]
}

/// The vector turned by an angle with this cosine and sine.
fn turned<V: Lanes>([x, y]: [V; 2], cos: V, sin: V) -> [V; 2] {
    [x * cos - y * sin, y * cos + x * sin]
}

/// √(1 − x²).
fn other<V: Lanes>(x: V) -> V {
    let one = V::splat(1.0);
    ((one - x) * (one + x)).max(V::splat(0.0)).sqrt()
}

fn clamped<V: Lanes>(x: V) -> V {
    x.max(V::splat(-1.0)).min(V::splat(1.0))
}

/// The direction of light after a surface with this normal: `ratio` is the index before over that after it, and light
/// goes to the side of the normal that `sign` states. Total reflection gives a direction along the surface.
fn refracted<V: Lanes>(d: [V; 2], normal: [V; 2], ratio: V, sign: f32) -> [V; 2] {
    let across = clamped(cross(normal, d) * ratio);
    let along = other(across) * V::splat(sign);
    [normal[0] * along - normal[1] * across, normal[1] * along + normal[0] * across]
}

fn minus<V: Lanes>(v: [V; 2]) -> [V; 2] {
    let zero = V::splat(0.0);
    v.map(|x| zero - x)
}

fn moved<V: Lanes>(from: [V; 2], along: [V; 2], by: V) -> [V; 2] {
    [from[0] + along[0] * by, from[1] + along[1] * by]
}

impl Section {
    /// The section of a fibre. `None` for a circle of one index.
    pub fn of(fiber: &Fiber) -> Option<Self> {
        // The wall of a thinner medulla is not seen, and points on it have no direction in single precision.
        let medulla = (fiber.medulla_air > 0.0 && fiber.kappa > 1e-6).then(|| fiber.medulla_eta());
        if fiber.aspect_ratio == 1.0 && medulla.is_none() {
            return None;
        }
        let root = fiber.aspect_ratio.sqrt();
        Some(Section { axes: [1.0 / root, root], medulla })
    }

    /// A vector over the axes, component by component, with unit length, and its length before.
    fn over<V: Lanes>(&self, v: [V; 2]) -> ([V; 2], V) {
        let v = [v[0] * V::splat(1.0 / self.axes[0]), v[1] * V::splat(1.0 / self.axes[1])];
        let length = dot(v, v).sqrt();
        (v.map(|x| x * (V::splat(1.0) / length)), length)
    }

    /// Follows a ray to its next crossing.
    fn crossing<V: Lanes>(&self, ray: &Ray<V>, kappa: f32, inner: Option<&Inner<V>>) -> Crossing<V> {
        let (back, length) = self.over(ray.back);
        let (offset, along) = (cross(ray.point, back), dot(ray.point, back));
        let twice = along + along;
        let point = [ray.point[0] - twice * back[0], ray.point[1] - twice * back[1]];
        let (normal, _) = self.over(point);
        let (kappa, scale) = (V::splat(kappa), V::splat(1.0) / length);
        let half = ((kappa - offset) * (kappa + offset)).max(V::splat(0.0)).sqrt();
        let chord = half * (V::splat(1.0) / kappa.max(V::splat(f32::MIN_POSITIVE)));
        let s_c = (along - half).max(V::splat(0.0)) * scale;
        let leg = Leg { s_c, s_m: half * scale, chord, wall: [V::splat(0.0); 2] };
        let (sin, cos) = (clamped(-cross(ray.back, normal)), (-dot(ray.back, normal)).max(V::splat(0.0)));
        let straight = Crossing { point, normal, sin, cos, leg, offset, back: ray.back, within: ray.back };
        let Some(inner) = inner else { return straight };
        // Where the ray meets the wall, from its nearest point to the axis: this is as exact as the offset.
        let start = moved([back[1] * offset, -(back[0] * offset)], back, half);
        self.by_wall(ray, &straight, inner, (start, s_c), kappa)
    }

    /// The crossing of a ray that meets the wall of the medulla at `start`, after the length `s_c`. `straight` is that
    /// without a wall.
    fn by_wall<V: Lanes>(
        &self,
        ray: &Ray<V>,
        straight: &Crossing<V>,
        inner: &Inner<V>,
        (start, s_c): ([V; 2], V),
        kappa: V,
    ) -> Crossing<V> {
        let (zero, one) = (V::splat(0.0), V::splat(1.0));
        let (normal, _) = self.over(start);
        let d = minus(ray.back);
        let cos_w = dot(ray.back, normal).max(zero);
        let within = refracted(d, normal, one / inner.ratio, -1.0);
        let sin_m = cross(normal, d) / inner.ratio;
        let [cortex, medulla] = inner.cosines;
        let [mirrored, passed] = parts(inner.relative, 0.5, other(clamped(sin_m)) * medulla, cos_w * cortex);
        let wall = mirrored / (mirrored + passed);
        // Through the medulla.
        let (on_circle, length) = self.over(within);
        let half = (-dot(start, on_circle)).max(zero);
        let leaves = moved(start, on_circle, half + half);
        let (far, _) = self.over(leaves);
        let through = refracted(within, far, inner.ratio, 1.0);
        // Along the reflection, which is all there is beyond the critical angle.
        let turned = moved(d, normal, cos_w + cos_w);
        let s_m = half / length;
        let total = (one - sin_m.abs()).select_lt(V::splat(1e-7), one, zero);
        let [chord, ..] = V::Quad::splat(V::splat(-2.0) * s_m * inner.scattering).exp().array();
        let passes = (one - wall) * (one - wall) * chord;
        let reflects = (passes - wall).select_lt(zero, one, total);
        let choose = |a: [V; 2], b: [V; 2]| [0, 1].map(|k| (zero - reflects).select_lt(V::splat(-0.5), a[k], b[k]));
        let (from, direction) = (choose(start, leaves), choose(turned, through));
        let (along, length) = self.over(direction);
        let b = dot(from, along);
        let reach = (b * b + (one - kappa) * (one + kappa)).max(zero).sqrt() - b;
        let point = moved(from, along, reach);
        let (normal, _) = self.over(point);
        // Cortex before and after the wall, as long as if it were inclined as the medulla is.
        let s_c = V::splat(0.5) * (s_c + reach / length) * medulla / cortex;
        let enters = one - total;
        let chord = half / kappa * enters;
        let leg = Leg { s_c, s_m: s_m * enters, chord, wall: [wall, reflects] };
        let back = minus(direction);
        let (sin, cos) = (clamped(-cross(back, normal)), (-dot(back, normal)).max(zero));
        // h″ in fibre radii. Beyond the critical angle it is κ or more.
        let offset = (zero - enters).select_lt(V::splat(-0.5), cross(on_circle, start), kappa * (zero - sin_m));
        let hit = Crossing { point, normal, sin, cos, leg, offset, back, within: minus(within) };
        // Rays that miss the medulla go straight on.
        let misses = straight.offset.abs();
        let pick = |a: V, b: V| (misses - kappa).select_lt(V::splat(0.0), a, b);
        let pair = |a: [V; 2], b: [V; 2]| [pick(a[0], b[0]), pick(a[1], b[1])];
        let cortex_only = straight.leg.s_c * medulla / cortex;
        Crossing {
            point: pair(hit.point, straight.point),
            normal: pair(hit.normal, straight.normal),
            sin: pick(hit.sin, straight.sin),
            cos: pick(hit.cos, straight.cos),
            leg: Leg {
                s_c: pick(hit.leg.s_c, cortex_only),
                s_m: pick(hit.leg.s_m, zero),
                chord: pick(hit.leg.chord, zero),
                wall: pair(hit.leg.wall, [zero; 2]),
            },
            offset: pick(hit.offset, straight.offset),
            back: pair(hit.back, straight.back),
            within: pair(hit.within, straight.within),
        }
    }

    /// What the inclination changes in a medulla of its own index, with η over that index.
    fn inner<V: Lanes>(&self, fiber: &Fiber, [sin_o, cos_o]: [V; 2]) -> Option<Inner<V>> {
        let index = self.medulla?;
        let cos = |eta: f32| other(sin_o * V::splat(1.0 / eta)).max(V::splat(1e-6));
        let cosines = [cos(fiber.eta), cos(index)];
        // η′ of the medulla over that of the cortex. The cosine of θ_o cancels.
        let prime2 = |eta: f32| (V::splat((eta - 1.0) * (eta + 1.0)) + cos_o * cos_o).max(V::splat(1e-20));
        let ratio = (prime2(index) / prime2(fiber.eta)).sqrt().max(V::splat(1e-6)).min(V::splat(1.0));
        let scattering = V::splat(fiber.sigma_ms) / cosines[1];
        Some(Inner { relative: fiber.eta / index, ratio, cosines, scattering })
    }

    /// The path of light from the azimuth with the cosine and the sine `toward`, in the frame of the axes.
    #[inline(never)]
    pub fn path<V: Lanes>(&self, fiber: &Fiber, [sin_o, cos_o]: [V; 2], toward: [V; 2], h: V) -> Bent<V> {
        let mut path = Path::new(fiber, sin_o, cos_o, h);
        let inner = self.inner(fiber, [sin_o, cos_o]);
        if let (Some(inner), Some(index)) = (&inner, self.medulla) {
            let sin = sin_o * V::splat(1.0 / index);
            let [_, cos] = inner.cosines;
            path.sin2_t = sin * sin;
            path.elongation = V::splat(1.0) / cos;
            if fiber.exit == ScatterExit::Reflecting {
                [path.theta, _] = V::atan2_pair([sin; 2], [cos; 2]);
            }
        }
        let (from, _) = self.over(toward);
        let point = turned(from, other(h), -h);
        let (normal, _) = self.over(point);
        // γ is the angle from the normal to the ray, outside (o) and inside.
        let sin_o0 = clamped(cross(normal, toward));
        let sin_t0 = sin_o0 * path.inverse_eta;
        let (cos_o0, cos_t0) = (dot(normal, toward).max(V::splat(0.0)), other(sin_t0));
        let ray = Ray { point, back: turned(normal, cos_t0, sin_t0) };
        let first = self.crossing(&ray, fiber.kappa, inner.as_ref());
        let twice = V::splat(-2.0) * first.cos;
        let again = Ray {
            point: first.point,
            back: [first.back[0] - twice * first.normal[0], first.back[1] - twice * first.normal[1]],
        };
        let second = self.crossing(&again, fiber.kappa, inner.as_ref());
        let eta = V::splat(1.0) / path.inverse_eta.max(V::splat(1e-12));
        // Total reflection where the sine would exceed 1.
        let outside = [first.sin, second.sin].map(|sin| clamped(sin * eta));
        let cosines = outside.map(other);
        let [o0, t0, i1, o1] = V::Quad::new([sin_o0, sin_t0, first.sin, outside[0]])
            .atan2(V::Quad::new([cos_o0, cos_t0, first.cos, cosines[0]]))
            .array();
        let [i2, o2] = V::atan2_pair([second.sin, outside[1]], [second.cos, cosines[1]]);
        // How far the wall turns the light in each pass, and where the light enters the medulla.
        let (mut turns, mut enters) = ([V::splat(0.0); 2], [V::splat(0.0); 2]);
        if inner.is_some() {
            let angle = |a: [V; 2], b: [V; 2]| (cross(a, b), dot(a, b));
            let pairs = [(&ray, &first), (&again, &second)].map(|(ray, end)| {
                let (a, b) = (angle(ray.back, end.back), angle(ray.back, end.within));
                V::atan2_pair([a.0, b.0], [a.1, b.1])
            });
            (turns, enters) = ([pairs[0][0], pairs[1][0]], [pairs[0][1], pairs[1][1]]);
        }
        let pi = V::splat(PI);
        let back = t0 - o0;
        let reflected = back + turns[0] + pi + i1 + i1;
        let reflectance = |cos: V| {
            let cos = cos * cos_o;
            let [back, through] = parts(fiber.eta, fiber.layers, cos, refracted_cos2(fiber.eta, cos * cos).sqrt());
            let scale = V::splat(1.0) / (back + through);
            Fresnel { reflected: back * scale, transmitted: through * scale }
        };
        let inside =
            ((V::splat(fiber.kappa) - first.offset) * (V::splat(fiber.kappa) + first.offset)).max(V::splat(0.0));
        let [gamma_m, _] = V::atan2_pair([first.offset; 2], [inside.sqrt(); 2]);
        let path = Path {
            h_inside: first.offset,
            gamma_o: o1,
            gamma_t: i1 + enters[0],
            gamma_m,
            fresnel: reflectance(cos_o0),
            ..path
        };
        let relative = |v: [V; 2]| [dot(toward, v), cross(toward, v)];
        Bent {
            path,
            exit: [-(o0 + o0), back + turns[0] + pi + i1 - o1, reflected + turns[1] + pi + i2 - o2],
            scattered: [back + enters[0], reflected + enters[1]],
            rotations: [relative(first.within), relative(second.within)],
            passes: [first.leg, second.leg],
            walls: inner.is_some(),
            inside: cosines.map(reflectance),
        }
    }

    /// The offset h ≥ 0 beyond which light of one direction misses the medulla in its first pass. It is above 1 if
    /// there is no such offset, and `None` if all offsets ≥ 0 miss it.
    pub fn edge(&self, fiber: &Fiber, inclination: [f32; 2], toward: [f32; 2]) -> Option<f32> {
        if let (true, Some(index)) = (self.axes[0] == self.axes[1], self.medulla) {
            return Some(fiber.kappa / inverse_eta(index, inclination[1]).max(f32::MIN_POSITIVE));
        }
        let (mut low, mut width) = (0.0, 1.0);
        // The offset on the circle grows with h. Each step divides the range by seven.
        for step in 0..4 {
            let h = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|i: f32| (low + width * i / 7.0).min(1.0));
            let bent = self.path(fiber, inclination.map(f32x8::splat), toward.map(f32x8::splat), f32x8::new(h));
            let beyond = bent.path.h_inside.to_array().iter().position(|&x| x >= fiber.kappa);
            match beyond {
                Some(0) if step == 0 => return None,
                None if step == 0 => return Some(2.0),
                Some(i) => low = h[i.max(1) - 1],
                None => low = h[6],
            }
            width /= 7.0;
        }
        Some(low + 0.5 * width)
    }
}

impl<V: Lanes> Route<V> for Bent<V> {
    fn trace(prepared: &Prepared, inclination: [V; 2], toward: [V; 2], h: V) -> Self {
        match &prepared.section {
            Some(section) => section.path(&prepared.in_air, inclination, toward, h),
            None => unreachable!("only fibres with such a section have these paths"),
        }
    }

    fn path(&self) -> &Path<V> {
        &self.path
    }

    fn exit_azimuth(&self, p: u8) -> V {
        self.exit[usize::from(p)]
    }

    fn exits_at(&self, prepared: &Prepared, inclination: [V; 2], toward: [V; 2], h: V) -> [V; 3] {
        Self::trace(prepared, inclination, toward, h).exit
    }

    fn scattered_azimuth(&self, p: u8) -> V {
        self.scattered[usize::from(p - 1)]
    }

    fn rotations(&self, _h: V, h_medulla: V) -> [[V; 2]; 3] {
        let [first, second] = self.rotations;
        [first, second, times(first, [other(h_medulla), -h_medulla])]
    }

    /// R, TT and TRT have the reflectance of their own crossings. The rest, from the third pass on, goes through a
    /// section as the first pass does, and leaves with the transmittance of the entry. The light of all components
    /// together is then 1 without absorption.
    fn attenuation(&self, fiber: &Fiber, mean_path: V, entry: Option<&Entry<V>>) -> [V::Quad; Component::COUNT] {
        let path = &self.path;
        let quad = V::Quad::splat;
        let zero = quad(V::splat(0.0));
        let [one, two] = self.passes.map(|leg| {
            let pass = Pass::new(fiber, path.elongation, [leg.s_c, leg.s_m, leg.chord], mean_path, entry);
            let [first, late] = match entry {
                Some(entry) => entry.divide(leg.chord, pass.escape),
                None => [pass.escape, zero],
            };
            let light = match self.walls {
                true => leg.light(fiber, path.elongation, &pass),
                false => Light { through: pass.through, along: pass.through, scattered: quad(pass.scattered) },
            };
            (light, pass.escape, [first, late])
        });
        let ((one, escape, [first, late]), (two, _, second)) = (one, two);
        let (f, t) = (quad(path.fresnel.reflected), quad(path.fresnel.transmitted));
        let [f2, f3] = self.inside.map(|fresnel| quad(fresnel.reflected));
        let [t2, t3] = self.inside.map(|fresnel| quad(fresnel.transmitted));
        // What begins each pass, along the path of TT and TRT, and what arrives at the cuticle along other paths.
        let e2 = t * one.along * f2;
        let e3 = e2 * two.along * f3;
        let other = |pass: Light<V>| (pass.through - pass.along).max(zero);
        let aside = t * other(one) + e2 * other(two);
        let denominator = (t + f * (quad(V::splat(1.0)) - one.through)).max(quad(V::splat(1e-20)));
        let series = (e3 + f * aside) * (V::Quad::splat(V::splat(1.0)) / denominator);
        let mut a_trts = e2 * two.scattered * second[0];
        let mut diffuse = t * one.scattered * late + e2 * two.scattered * second[1] + series * one.scattered * escape;
        // A path that only meets the medulla in its second pass has no profile: its light is diffuse.
        let misses =
            (V::splat(fiber.kappa) - path.h_inside.abs()).select_lt(V::splat(1e-30), V::splat(1.0), V::splat(0.0));
        diffuse = diffuse + a_trts * quad(misses);
        a_trts = a_trts * quad(V::splat(1.0) - misses);
        [
            f,
            t * one.along * t2,
            e2 * two.along * t3,
            t * one.scattered * first,
            a_trts,
            t * (series * one.through + aside),
            diffuse,
        ]
    }
}

/// What becomes of the light of one pass, RGB.
#[derive(Clone, Copy)]
struct Light<V: Lanes> {
    /// What reaches the cuticle unscattered.
    through: V::Quad,
    /// The part of it along the path of TT and TRT.
    along: V::Quad,
    /// The share that is scattered.
    scattered: V::Quad,
}

impl<V: Lanes> Leg<V> {
    /// The light of a pass that meets a wall. The wall reflects the same share each time, from both sides, so all
    /// chords through the medulla sum to a geometric series. Without absorption, the parts sum to 1.
    fn light(&self, fiber: &Fiber, elongation: V, pass: &Pass<V>) -> Light<V> {
        let quad = V::Quad::splat;
        let rgb = |c: [f32; 3]| V::Quad::constant([c[0], c[1], c[2], 0.0]);
        let twice = V::splat(-2.0) * elongation;
        let cortex = (quad(twice * self.s_c) * rgb(fiber.sigma_ca)).exp();
        let chord = (quad(twice * self.s_m) * (rgb(fiber.sigma_ma) + quad(V::splat(fiber.sigma_ms)))).exp();
        let (one, [wall, reflects]) = (quad(V::splat(1.0)), self.wall.map(quad));
        let enters = one - wall;
        let inverse = one / (one - wall * chord).max(quad(V::splat(1e-20)));
        let passes = enters * enters * chord;
        // Above 1 by rounding, it would give light in the series of all passes.
        let lost = (one - (wall + passes * inverse)).max(quad(V::splat(0.0)));
        Light {
            through: cortex * (one - lost),
            // Not 0, so that a black fibre has a lobe to sample.
            along: (cortex * (reflects * wall + (one - reflects) * passes)).max(quad(V::splat(1e-30))),
            scattered: quad(pass.scattered) * enters * inverse,
        }
    }
}
