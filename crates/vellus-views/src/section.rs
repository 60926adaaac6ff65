//! Rays through a cross-section of the fibre, seen along its axis.
//!
//! Points are (y, z) of the fibre's frame, in fibre radii, so that the fibre is the unit circle. The light comes from
//! the right, from the azimuth 0. A ray's last point lies outside and shows its direction.

mod walk;

use crate::request::Request;
use serde_json::{Value, json};
use vellus::{Fiber, Lobe, Window};

/// The length of a ray outside the fibre, in fibre radii.
const OUTSIDE: f64 = 0.45;

/// Light that meets the fibre at an offset, and its refraction in the normal plane.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// θ_o in radians.
    theta: f64,
    /// γ_o = asin h and γ_t = asin(h/η′).
    gamma: [f64; 2],
}

impl Entry {
    fn new(fiber: &Fiber, theta: f64, h: f64) -> Self {
        Entry { theta, gamma: [h.asin(), (h / bravais(fiber, theta)).clamp(-1.0, 1.0).asin()] }
    }

    /// The azimuth where the light enters: that of the surface normal at the hit.
    fn azimuth(&self) -> f64 {
        -self.gamma[0]
    }

    /// The azimuth of the point where the path of the lobe p (0: R, 1: TT, 2: TRT) leaves.
    fn leaves_at(&self, p: u8) -> f64 {
        self.azimuth() + f64::from(p) * (std::f64::consts::PI + 2.0 * self.gamma[1])
    }
}

/// η′, the refractive index in the normal plane, for light at the inclination `theta` (Marschner et al. 2003).
fn bravais(fiber: &Fiber, theta: f64) -> f64 {
    let eta = f64::from(fiber.eta);
    (eta * eta - theta.sin().powi(2)).max(0.0).sqrt() / theta.cos()
}

fn on_circle(radius: f64, azimuth: f64) -> [f64; 2] {
    [radius * azimuth.cos(), radius * azimuth.sin()]
}

/// The point at `length` from a point, in the direction of an azimuth.
fn beyond([y, z]: [f64; 2], azimuth: f64, length: f64) -> [f64; 2] {
    let [dy, dz] = on_circle(length, azimuth);
    [y + dy, z + dz]
}

/// The points of the path of R, TT or TRT (p = 0, 1, 2), from outside to outside.
fn specular(entry: &Entry, p: u8) -> Vec<[f64; 2]> {
    let mut points = vec![beyond(on_circle(1.0, entry.azimuth()), 0.0, OUTSIDE)];
    points.extend((0..=p).map(|i| on_circle(1.0, entry.leaves_at(i))));
    // The ray leaves at γ_o from the normal, on the other side of it than it came.
    let last = entry.leaves_at(p);
    points.push(beyond(on_circle(1.0, last), last - entry.gamma[0], OUTSIDE));
    points
}

/// The answer to `section`.
pub fn section(request: &Request) -> Result<Value, String> {
    let bcsdf = request.bcsdf()?;
    let fiber = bcsdf.fiber().in_air();
    let (theta, h) = (request.theta()?.to_radians(), request.h()?);
    let paths = request.count("paths", 6, [0, 64])?;
    let seed = request.count("seed", 1, [0, u32::MAX])?;
    let entry = Entry::new(&fiber, theta, h);
    let energy = bcsdf.at(request.wo()?, Window::near(h as f32)).energy();
    let rays: Vec<Value> = [Lobe::R, Lobe::Tt, Lobe::Trt]
        .into_iter()
        .zip(0..)
        .map(|(lobe, p)| json!({ "lobe": lobe.key(), "points": specular(&entry, p), "weight": energy[lobe] }))
        .collect();
    let scattered: Vec<Value> = walk::scattered(&fiber, &entry, paths, seed)
        .into_iter()
        .map(|path| json!({ "points": path.points, "weight": path.weight }))
        .collect();
    Ok(json!({
        "medulla": fiber.kappa,
        "h": h,
        "eta": bravais(&fiber, theta),
        "rays": rays,
        "scattered": scattered,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus::{Bcsdf, Species, direction};

    fn angle(a: [f64; 2], b: [f64; 2], normal: f64) -> f64 {
        let [dy, dz] = [b[0] - a[0], b[1] - a[1]];
        let [ny, nz] = on_circle(1.0, normal);
        // The sine of the angle between a leg and a normal.
        (dy * nz - dz * ny) / dy.hypot(dz)
    }

    /// Each leg of R, TT and TRT has the sine h outside and h/η′ inside, at every surface.
    #[test]
    fn rays_obey_snell_and_reflect_at_equal_angles() {
        for (species, theta, h) in [(Species::Cat, 0.0, 0.7), (Species::Human, 0.6, -0.35), (Species::Deer, -1.1, 0.95)]
        {
            let fiber = Fiber::preset(species);
            let entry = Entry::new(&fiber, theta, h);
            for p in 0..3u8 {
                let points = specular(&entry, p);
                assert_eq!(points.len(), usize::from(p) + 3);
                for i in 0..=p {
                    let (at, normal) = (usize::from(i) + 1, entry.leaves_at(i));
                    let before = angle(points[at - 1], points[at], normal);
                    let after = angle(points[at], points[at + 1], normal);
                    let inside = h / bravais(&fiber, theta);
                    let [enters, leaves] = [i == 0, i == p];
                    let expected = [if enters { h } else { inside }, if leaves { h } else { inside }];
                    // Double precision, after about ten operations.
                    assert!((before.abs() - expected[0].abs()).abs() < 1e-12, "{p} {i}: {before} {expected:?}");
                    assert!((after.abs() - expected[1].abs()).abs() < 1e-12, "{p} {i}: {after} {expected:?}");
                    // A reflection keeps the tangential part of the direction, and so does a refraction.
                    assert!(before * after >= 0.0 || h == 0.0, "{p} {i}: {before} {after}");
                }
            }
        }
    }

    /// The direction of each ray is that of its lobe in the model: N(φ) of a narrow lobe is largest there.
    #[test]
    fn rays_leave_where_the_model_has_its_lobes() {
        let fiber = Fiber { beta_n: 1f32.to_radians(), ..Fiber::hair() };
        let bcsdf = Bcsdf::new(&fiber).unwrap();
        let (theta, h) = (0.3, 0.55);
        let entry = Entry::new(&fiber, theta, h);
        let hit = bcsdf.at(direction(theta, 0.0), Window::near(h as f32));
        for (lobe, p) in [(Lobe::R, 0), (Lobe::Tt, 1), (Lobe::Trt, 2)] {
            let points = specular(&entry, p);
            let [a, b] = [points[points.len() - 2], points[points.len() - 1]];
            let phi = (b[1] - a[1]).atan2(b[0] - a[0]) as f32;
            let value = |phi: f32| hit.azimuthal(phi)[lobe][1];
            assert!(value(phi) > value(phi + 0.01) && value(phi) > value(phi - 0.01), "{lobe:?} {phi}");
        }
    }
}
