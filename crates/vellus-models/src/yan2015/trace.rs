//! Paths traced event by event through both circles, as published: "a path p needs to be traced from the starting
//! offset h until it exits the double cylinder" (Yan17 Sec. 3). [`Paths::new`] has the same paths in closed form.

use super::paths::{InMedulla, Paths};
use crate::entry::Entry;
use std::ops::{Add, Div, Mul, Neg, Sub};
use vellus::{Fiber, fresnel};

/// The events of the eight unscattered lobes. The scattered lobes are the light that leaves the last pass of TttT,
/// TtrtT and TttRttT through the medulla.
const EVENTS: [&[u8]; 8] = [b"R", b"TT", b"TRT", b"TrT", b"TrRrT", b"TttT", b"TtrtT", b"TttRttT"];

/// The first of the lobes that pass through the medulla.
const THROUGH: usize = 5;

/// A floating-point number: `f32` in the model, and `f64` in a test.
trait Real:
    Copy
    + PartialOrd
    + From<f32>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    fn sqrt(self) -> Self;
}

impl Real for f32 {
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
}

/// The medulla's radius, and the indices of the cortex and of the medulla.
#[derive(Clone, Copy)]
struct Circles<R> {
    kappa: R,
    eta_c: R,
    eta_m: R,
}

/// A ray on its path.
#[derive(Clone, Copy)]
struct Ray<R> {
    /// Position in the normal plane, in fibre radii.
    p: [R; 2],
    /// Unit vector: along the fibre, and in the normal plane.
    d: [R; 3],
    /// Product of all reflectances and transmittances.
    fresnel: R,
    /// Lengths of the path in the cortex and in the medulla.
    lengths: [R; 2],
}

/// A path that was traced to its end.
struct Traced<R> {
    end: Ray<R>,
    /// The ray where its last pass through the medulla begins, and the length of that pass.
    pass: Option<(Ray<R>, R)>,
}

impl<R: Real> Ray<R> {
    /// A ray that hits the fibre from θ_o at the offset h.
    fn new([sin_o, cos_o]: [R; 2], [h, cos_gamma]: [R; 2]) -> Self {
        let zero = R::from(0.0f32);
        Ray { p: [cos_gamma, -h], d: [-sin_o, -cos_o, zero], fresnel: R::from(1.0f32), lengths: [zero; 2] }
    }

    /// Distance to a circle around the axis: to the first intersection from outside, or to the exit from inside.
    fn distance(&self, radius: R, outside: bool) -> Option<R> {
        let zero = R::from(0.0f32);
        let a = self.d[1] * self.d[1] + self.d[2] * self.d[2];
        let b = self.p[0] * self.d[1] + self.p[1] * self.d[2];
        let c = self.p[0] * self.p[0] + self.p[1] * self.p[1] - radius * radius;
        let square = b * b - a * c;
        let root = (square >= zero).then(|| square.sqrt())?;
        let t = (if outside { -b - root } else { -b + root }) / a;
        // A ray along the axis does not reach the circle: t is infinite or NaN.
        (t < R::from(f32::MAX)).then_some(t)
    }
}

/// Traces the path with these `events`: capital letters at the cuticle, small letters at the medulla. `cuticle` is the
/// cuticle's reflectance, from the cosine outside. `None` if total reflection or a miss makes the path impossible.
fn trace<R: Real>(circles: &Circles<R>, start: Ray<R>, events: &[u8], cuticle: impl Fn(R) -> R) -> Option<Traced<R>> {
    let (zero, one) = (R::from(0.0f32), R::from(1.0f32));
    // Rounding makes some numbers negative that are 0.
    let positive = |x: R| if x > zero { x } else { zero };
    let (mut ray, mut pass) = (start, None);
    // 0 is outside, 1 is in the cortex, 2 is in the medulla.
    let mut place = 0;
    for (i, event) in events.iter().enumerate() {
        let at_cuticle = event.is_ascii_uppercase();
        let radius = if at_cuticle { one } else { circles.kappa };
        if i > 0 {
            let t = ray.distance(radius, place == 1 && !at_cuticle)?;
            if place == 2 {
                pass = Some((ray, t));
            }
            ray.p = [ray.p[0] + t * ray.d[1], ray.p[1] + t * ray.d[2]];
            ray.lengths[place - 1] = ray.lengths[place - 1] + t;
        }
        let inward = place == usize::from(!at_cuticle);
        // Opposite to the ray.
        let scale = if inward { one / radius } else { -one / radius };
        let normal = [scale * ray.p[0], scale * ray.p[1]];
        let (outer, inner) = if at_cuticle { (one, circles.eta_c) } else { (circles.eta_c, circles.eta_m) };
        let (from, to) = if inward { (outer, inner) } else { (inner, outer) };
        let cos = positive(-(ray.d[1] * normal[0] + ray.d[2] * normal[1]));
        let ratio = from / to;
        let sin2_t = ratio * ratio * (one - cos * cos);
        let cos_t = (sin2_t < one).then(|| (one - sin2_t).sqrt());
        let reflected = match cos_t {
            None => one,
            Some(cos_t) if at_cuticle => cuticle(if inward { cos } else { cos_t }),
            Some(cos_t) => {
                let (a, b, c, d) = (from * cos, to * cos_t, to * cos, from * cos_t);
                let (s, p) = ((a - b) / (a + b), (c - d) / (c + d));
                R::from(0.5f32) * (s * s + p * p)
            }
        };
        let [x, y, z] = ray.d;
        if event.eq_ignore_ascii_case(&b'r') {
            let turn = cos + cos;
            ray.d = [x, y + turn * normal[0], z + turn * normal[1]];
            ray.fresnel = ray.fresnel * reflected;
        } else {
            let turn = ratio * cos - cos_t?;
            ray.d = [ratio * x, ratio * y + turn * normal[0], ratio * z + turn * normal[1]];
            ray.fresnel = ray.fresnel * positive(one - reflected);
            place = usize::from(inward) + usize::from(!at_cuticle);
        }
    }
    Some(Traced { end: ray, pass })
}

impl Ray<f32> {
    /// The energy that is left, RGB: the medulla absorbs and scatters.
    fn energy(&self, fiber: &Fiber) -> [f32; 3] {
        let [cortex, medulla] = self.lengths;
        [0, 1, 2].map(|c| {
            let depth = cortex * fiber.sigma_ca[c] + medulla * (fiber.sigma_ma[c] + fiber.sigma_ms);
            self.fresnel * (-depth).exp()
        })
    }
}

impl Paths {
    /// The same as [`Paths::new`], with each path traced from the start. The light that the medulla scatters on a path
    /// is found on the way, so no path is traced twice.
    pub fn traced(fiber: &Fiber, eta_m: f32, entry: &Entry) -> Self {
        let circles = Circles { kappa: fiber.kappa, eta_c: fiber.eta, eta_m };
        let start = Ray::new([entry.polar.sin, entry.polar.cos], entry.gamma_o.sin_cos().into());
        let cuticle = |cos: f32| fresnel(fiber.eta, fiber.layers, cos).reflected;
        let beside = entry.h_inside.abs() >= fiber.kappa;
        let mut paths = Paths { unscattered: [[0.0; 8]; 3], exit: [0.0; 8], medulla: None };
        for (i, events) in EVENTS.iter().enumerate() {
            // A ray either passes beside the medulla or hits it.
            if i > 0 && (i < 3) != beside {
                continue;
            }
            let Some(Traced { end, pass }) = trace(&circles, start, events, cuticle) else { continue };
            let energy = end.energy(fiber);
            (0..3).for_each(|c| paths.unscattered[c][i] = energy[c]);
            paths.exit[i] = end.d[2].atan2(end.d[1]);
            if let Some((ray, length)) = pass {
                paths.scatter(i - THROUGH, fiber, &ray, length);
            }
        }
        paths
    }

    /// Adds a pass through the medulla that begins with this ray.
    fn scatter(&mut self, pass: usize, fiber: &Fiber, ray: &Ray<f32>, length: f32) {
        let [along, y, z] = ray.d;
        let across = y.hypot(z).max(1e-6);
        let offset = (ray.p[1] * y - ray.p[0] * z) / (across * fiber.kappa);
        let medulla = self.medulla.get_or_insert(InMedulla {
            angle: offset.clamp(-1.0, 1.0).asin(),
            sin_m: (-along).clamp(-1.0, 1.0),
            elongation: 1.0 / across,
            back: [0.0; 3],
            scattered: [[0.0; 3]; 3],
        });
        // Light that travels along d comes from −d.
        medulla.back[pass] = (-z).atan2(-y);
        let share = -(-length * fiber.sigma_ms).exp_m1();
        medulla.scattered[pass] = ray.energy(fiber).map(|a| a * share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};
    use vellus::Window;
    use vellus_reference::exact;

    impl Real for f64 {
        fn sqrt(self) -> Self {
            f64::sqrt(self)
        }
    }

    /// The difference of two azimuths.
    fn same_turn(a: impl Into<f64>, b: f64) -> f64 {
        ((a.into() - b + PI).rem_euclid(TAU) - PI).abs()
    }

    /// Calls `check` with the fibre, η_m, θ_o and h of hits. The medulla has the index of the cortex, a lower or a
    /// higher one.
    fn each_hit(mut check: impl FnMut(&Fiber, f32, f64, f64)) {
        let fiber = Fiber {
            kappa: 0.62,
            layers: 0.8,
            sigma_ca: [0.3; 3],
            sigma_ma: [0.2; 3],
            sigma_ms: 0.4,
            g: 0.3,
            ..Fiber::hair()
        };
        for (eta_c, eta_m) in [(1.55, 1.55), (1.45, 1.0), (1.3, 1.7)] {
            for theta_o in [0.0, -0.4, 0.9, 1.35] {
                for h in [-0.97, -0.75, -0.4, -0.01, 0.2, 0.55, 0.9] {
                    check(&Fiber { eta: eta_c, ..fiber }, eta_m, theta_o, h);
                }
            }
        }
    }

    fn entry(fiber: &Fiber, theta_o: f64, h: f64) -> Entry {
        let wo = glam::DVec3::new(theta_o.sin(), theta_o.cos(), 0.0).as_vec3();
        Entry::new(wo, Window::near(h as f32), fiber.eta, Some(fiber.layers))
    }

    /// Compares the closed forms with paths traced in f64, with another implementation of the cuticle.
    #[test]
    fn closed_forms_are_the_traced_paths() {
        let (mut compared, mut total) = (0, 0);
        each_hit(|fiber, eta_m, theta_o, h| {
            let entry = entry(fiber, theta_o, h);
            let paths = Paths::new(fiber, eta_m, &entry);
            let [kappa, eta_c, eta_m] = [fiber.kappa, fiber.eta, eta_m].map(f64::from);
            let circles = Circles { kappa, eta_c, eta_m };
            let start = Ray::new([theta_o.sin(), theta_o.cos()], [h, (1.0 - h * h).sqrt()]);
            let cuticle = |cos: f64| exact::fresnel(eta_c, fiber.layers.into(), cos);
            let [ca, ma, ms] = [fiber.sigma_ca[0], fiber.sigma_ma[0], fiber.sigma_ms].map(f64::from);
            let energy = |ray: &Ray<f64>| ray.fresnel * (-(ray.lengths[0] * ca + ray.lengths[1] * (ma + ms))).exp();
            let beside = entry.h_inside.abs() >= fiber.kappa;
            assert!(!beside || paths.medulla.is_none());
            for (i, events) in EVENTS.iter().enumerate() {
                let name = std::str::from_utf8(events).unwrap();
                let at = format!("{name} η {eta_c} {eta_m} θ {theta_o} h {h}");
                let exists = i == 0 || (i < 3) == beside;
                let ours = f64::from(paths.unscattered[0][i]);
                let Some(traced) = trace(&circles, start, events, cuticle).filter(|_| exists) else {
                    assert_eq!(ours, 0.0, "{at}");
                    assert!(i < THROUGH || beside || paths.medulla.is_none(), "{at}");
                    continue;
                };
                // The tolerance is twenty rounding errors of 6e-8, for cosines as small as 0.1.
                let (end, expected) = (traced.end, energy(&traced.end));
                assert!((ours - expected).abs() < 2e-5 * expected + 1e-8, "{at}: {ours} {expected}");
                let phi = end.d[2].atan2(end.d[1]);
                assert!(ours < 1e-8 || same_turn(paths.exit[i], phi) < 2e-5, "{at}: {} {phi}", paths.exit[i]);
                compared += 1;
                let Some((ray, length)) = traced.pass else { continue };
                let m = paths.medulla.unwrap();
                let pass = i - THROUGH;
                let offset = (ray.p[1] * ray.d[1] - ray.p[0] * ray.d[2]) / ray.d[1].hypot(ray.d[2]) / kappa;
                assert!((offset - f64::from(m.angle).sin()).abs() < 1e-5, "{at}: {offset}");
                assert!((ray.d[0] + f64::from(m.sin_m)).abs() < 1e-6, "{at}");
                assert!(same_turn(m.back[pass], (-ray.d[2]).atan2(-ray.d[1])) < 2e-5, "{at}");
                // The medulla scatters the fraction Q along the chord.
                let expected = energy(&ray) * -(-length * ms).exp_m1();
                let ours = f64::from(m.scattered[pass][0]);
                assert!((ours - expected).abs() < 2e-5 * expected + 1e-8, "{at}: {ours} {expected}");
                total += 1;
            }
        });
        // There are R and two to five other paths at each of 84 hits, and most passes.
        assert!(compared > 250 && total > 100, "{compared} {total}");
    }

    /// The error of a position on a circle is divided by the cosine at the next one, and a path has up to seven events.
    /// Against f64, the errors at these hits are 2.3e-4 of the energy and 7e-5 rad. The tolerances are twice as large.
    #[test]
    fn traced_paths_are_accurate_in_single_precision() {
        each_hit(|fiber, eta_m, theta_o, h| {
            let entry = entry(fiber, theta_o, h);
            let (closed, traced) = (Paths::new(fiber, eta_m, &entry), Paths::traced(fiber, eta_m, &entry));
            let at = format!("{fiber:?} {eta_m} θ {theta_o} h {h}: {closed:?} {traced:?}");
            let close = |a: f32, b: f32| (a - b).abs() < 5e-4 * b + 1e-7;
            let along = |a: f32, b: f32| same_turn(a, b.into()) < 2e-4;
            for i in 0..8 {
                let energy = closed.unscattered[0][i];
                assert!(close(traced.unscattered[0][i], energy), "{at}");
                assert!(energy < 1e-6 || along(traced.exit[i], closed.exit[i]), "{at}");
            }
            assert_eq!(traced.medulla.is_some(), closed.medulla.is_some(), "{at}");
            let (Some(a), Some(b)) = (traced.medulla, closed.medulla) else { return };
            assert!((a.angle.sin() - b.angle.sin()).abs() < 1e-5 && (a.sin_m - b.sin_m).abs() < 1e-6, "{at}");
            assert!((a.elongation / b.elongation - 1.0).abs() < 1e-5, "{at}");
            for pass in 0..3 {
                let scattered = b.scattered[pass][0];
                assert!(close(a.scattered[pass][0], scattered), "{at}");
                assert!(scattered < 1e-6 || along(a.back[pass], b.back[pass]), "{at}");
            }
        });
    }

    /// Rays along the axis, grazing rays, and a medulla that is hardly there.
    #[test]
    fn traced_paths_are_finite() {
        for eta in [1.0f32, 1.0001, 1.55, 3.0] {
            for (eta_m, kappa) in [(1.0, 1e-6), (1.0, 0.999), (1.55, 0.3), (3.0, 0.86), (1.3, 0.0)] {
                let fiber = Fiber { eta, kappa, sigma_ms: 50.0, ..Fiber::hair() };
                for across in [1.0, 1e-4, 1e-8, 1e-19, 1e-30, 0.0] {
                    for h in [-1.0, -0.5, 0.0, 1e-8, 0.3, 0.999_999, 1.0] {
                        let wo = glam::Vec3::new((1.0f32 - across * across).sqrt(), across, 0.0);
                        let entry = Entry::new(wo, Window::near(h), eta, Some(fiber.layers));
                        let paths = Paths::traced(&fiber, eta_m, &entry);
                        let scattered = paths.medulla.map_or([[0.0; 3]; 3], |m| m.scattered);
                        let mut energies = paths.unscattered.iter().flatten().chain(scattered.iter().flatten());
                        assert!(energies.all(|a| (0.0..1.0001).contains(a)), "{paths:?}");
                        assert!(paths.exit.iter().all(|a| a.is_finite()), "{paths:?}");
                    }
                }
            }
        }
    }
}
