//! The path of light in a fibre whose section is an ellipse (D23).
//!
//! In the normal plane, light follows the ray optics of a section with the index η′ (Bravais), whatever its shape. The
//! ray is traced from crossing to crossing. A section is drawn onto the unit circle by dividing each axis by its
//! length: straight rays stay straight, and offsets relative to the projected width stay what they are. The medulla has
//! the same ratio of axes, so that it becomes a circle of radius κ.
//!
//! Lengths are in units of √(ab), the radius of the circle of the same area, and absorption coefficients are per this
//! radius: a flatter fibre keeps its colour.

use crate::cylinder::cuticle::{Fresnel, parts, refracted_cos2};
use crate::cylinder::path::{Pass, Path};
use crate::exit::Entry;
use crate::fiber::Fiber;
use crate::lobe::Component;
use crate::simd::lanes::{Lanes, Quad};
use std::f32::consts::PI;
use wide::f32x8;

/// The semi-axes of a section along y and z of the fibre's frame, in units of √(ab). The first is the longer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ellipse([f32; 2]);

/// What an ellipse changes in a [`Path`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bends<V> {
    /// The exit azimuths of R, TT and TRT relative to ω_o.
    pub exit: [V; 3],
    /// Φˢ₁ and Φˢ₂.
    pub scattered: [V; 2],
    /// The cosine and the sine of Φˢ₁, and those of Φˢ₂.
    pub rotations: [[V; 2]; 2],
    /// The first and the second pass.
    passes: [Leg<V>; 2],
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

impl Ellipse {
    /// The section of a fibre. `None` for a circle.
    pub fn of(fiber: &Fiber) -> Option<Self> {
        let root = fiber.aspect_ratio.sqrt();
        (fiber.aspect_ratio < 1.0).then_some(Ellipse([1.0 / root, root]))
    }

    /// A vector over the axes, component by component, with unit length, and its length before.
    fn over<V: Lanes>(&self, v: [V; 2]) -> ([V; 2], V) {
        let v = [v[0] * V::splat(1.0 / self.0[0]), v[1] * V::splat(1.0 / self.0[1])];
        let length = dot(v, v).sqrt();
        (v.map(|x| x * (V::splat(1.0) / length)), length)
    }

    /// Follows a ray to its next crossing.
    fn crossing<V: Lanes>(&self, ray: &Ray<V>, kappa: f32) -> Crossing<V> {
        let (back, length) = self.over(ray.back);
        let (offset, along) = (cross(ray.point, back), dot(ray.point, back));
        let twice = along + along;
        let point = [ray.point[0] - twice * back[0], ray.point[1] - twice * back[1]];
        let (normal, _) = self.over(point);
        let (kappa, scale) = (V::splat(kappa), V::splat(1.0) / length);
        let half = ((kappa - offset) * (kappa + offset)).max(V::splat(0.0)).sqrt();
        let chord = half * (V::splat(1.0) / kappa.max(V::splat(f32::MIN_POSITIVE)));
        let leg = Leg { s_c: (along - half).max(V::splat(0.0)) * scale, s_m: half * scale, chord };
        let (sin, cos) = (clamped(-cross(ray.back, normal)), (-dot(ray.back, normal)).max(V::splat(0.0)));
        Crossing { point, normal, sin, cos, leg, offset }
    }

    /// The path of light from the azimuth with the cosine and the sine `toward`, in the frame of the axes.
    #[inline(never)]
    pub fn path<V: Lanes>(&self, fiber: &Fiber, [sin_o, cos_o]: [V; 2], toward: [V; 2], h: V) -> Path<V> {
        let path = Path::new(fiber, sin_o, cos_o, h);
        let (from, _) = self.over(toward);
        let point = turned(from, other(h), -h);
        let (normal, _) = self.over(point);
        // γ is the angle from the normal to the ray, outside (o) and inside.
        let sin_o0 = clamped(cross(normal, toward));
        let sin_t0 = sin_o0 * path.inverse_eta;
        let (cos_o0, cos_t0) = (dot(normal, toward).max(V::splat(0.0)), other(sin_t0));
        let ray = Ray { point, back: turned(normal, cos_t0, sin_t0) };
        let first = self.crossing(&ray, fiber.kappa);
        let twice = V::splat(-2.0) * first.cos;
        let again = Ray {
            point: first.point,
            back: [ray.back[0] - twice * first.normal[0], ray.back[1] - twice * first.normal[1]],
        };
        let second = self.crossing(&again, fiber.kappa);
        let eta = V::splat(1.0) / path.inverse_eta.max(V::splat(1e-12));
        // Total reflection where the sine would exceed 1.
        let outside = [first.sin, second.sin].map(|sin| clamped(sin * eta));
        let cosines = outside.map(other);
        let [o0, t0, i1, o1] = V::Quad::new([sin_o0, sin_t0, first.sin, outside[0]])
            .atan2(V::Quad::new([cos_o0, cos_t0, first.cos, cosines[0]]))
            .array();
        let [i2, o2] = V::atan2_pair([second.sin, outside[1]], [second.cos, cosines[1]]);
        let pi = V::splat(PI);
        let back = t0 - o0;
        let reflected = back + pi + i1 + i1;
        let reflectance = |cos: V| {
            let cos = cos * cos_o;
            let [back, through] = parts(fiber.eta, fiber.layers, cos, refracted_cos2(fiber.eta, cos * cos).sqrt());
            let scale = V::splat(1.0) / (back + through);
            Fresnel { reflected: back * scale, transmitted: through * scale }
        };
        let relative = |v: [V; 2]| [dot(toward, v), cross(toward, v)];
        let bends = Bends {
            exit: [-(o0 + o0), back + pi + i1 - o1, reflected + pi + i2 - o2],
            scattered: [back, reflected],
            rotations: [relative(ray.back), relative(again.back)],
            passes: [first.leg, second.leg],
            inside: cosines.map(reflectance),
        };
        let inside =
            ((V::splat(fiber.kappa) - first.offset) * (V::splat(fiber.kappa) + first.offset)).max(V::splat(0.0));
        let [gamma_m, _] = V::atan2_pair([first.offset; 2], [inside.sqrt(); 2]);
        Path {
            h_inside: first.offset,
            gamma_o: o1,
            gamma_t: i1,
            gamma_m,
            fresnel: reflectance(cos_o0),
            bends: Some(bends),
            ..path
        }
    }

    /// The offset h ≥ 0 beyond which light of one direction misses the medulla in its first pass. It is above 1 if
    /// there is no such offset, and `None` if all offsets ≥ 0 miss it.
    pub fn edge(&self, fiber: &Fiber, inclination: [f32; 2], toward: [f32; 2]) -> Option<f32> {
        let (mut low, mut width) = (0.0, 1.0);
        // The offset on the circle grows with h. Each step divides the range by seven.
        for step in 0..4 {
            let h = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].map(|i: f32| (low + width * i / 7.0).min(1.0));
            let path = self.path(fiber, inclination.map(f32x8::splat), toward.map(f32x8::splat), f32x8::new(h));
            let beyond = path.h_inside.to_array().iter().position(|&x| x >= fiber.kappa);
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

impl<V: Lanes> Bends<V> {
    /// A(h) of the components, as [`Path::attenuation`]. R, TT and TRT have the reflectance of their own crossings.
    /// The rest, from the third pass on, goes through a section as the first pass does, and leaves with the
    /// transmittance of the entry. The light of all components together is then 1 without absorption.
    pub fn attenuation(
        &self,
        path: &Path<V>,
        fiber: &Fiber,
        mean_path: V,
        entry: Option<&Entry<V>>,
    ) -> [V::Quad; Component::COUNT] {
        let quad = V::Quad::splat;
        let zero = quad(V::splat(0.0));
        let [one, two] = self.passes.map(|leg| {
            let Leg { s_c, s_m, chord } = leg;
            let pass = Pass::new(fiber, path.elongation, [s_c, s_m, chord], mean_path, entry);
            let [first, late] = match entry {
                Some(entry) => entry.divide(chord, pass.escape),
                None => [pass.escape, zero],
            };
            (pass, first, late)
        });
        let (f, t) = (quad(path.fresnel.reflected), quad(path.fresnel.transmitted));
        let [second, third] = self.inside;
        let (f2, t2) = (quad(second.reflected), quad(second.transmitted));
        let (f3, t3) = (quad(third.reflected), quad(third.transmitted));
        // What begins each pass.
        let e2 = t * one.0.through * f2;
        let e3 = e2 * two.0.through * f3;
        let denominator = (t + f * (quad(V::splat(1.0)) - one.0.through)).max(quad(V::splat(1e-20)));
        let series = e3 * (V::Quad::splat(V::splat(1.0)) / denominator);
        let (q1, q2) = (quad(one.0.scattered), quad(two.0.scattered));
        let (mut a_trts, mut diffuse) =
            (e2 * q2 * two.1, t * q1 * one.2 + e2 * q2 * two.2 + series * q1 * one.0.escape);
        // A path that only meets the medulla in its second pass has no profile: its light is diffuse.
        let misses =
            (V::splat(fiber.kappa) - path.h_inside.abs()).select_lt(V::splat(1e-30), V::splat(1.0), V::splat(0.0));
        diffuse = diffuse + a_trts * quad(misses);
        a_trts = a_trts * quad(V::splat(1.0) - misses);
        [
            f,
            t * one.0.through * t2,
            e2 * two.0.through * t3,
            t * q1 * one.1,
            a_trts,
            series * t * one.0.through,
            diffuse,
        ]
    }
}
