//! A few paths of light that the medulla scatters, by a random walk with a fixed seed.

use super::{Entry, OUTSIDE, on_circle};
use std::f64::consts::{PI, TAU};
use vellus::Fiber;

/// The most events of a path: scattering, and reflections by the cuticle. A longer path is left out.
const EVENTS: u32 = 200;

/// A path of scattered light, as in the answer to `section`.
pub struct Scattered {
    /// From outside to outside.
    pub points: Vec<[f64; 2]>,
    /// The share of the light that the path stands for, RGB.
    pub weight: [f64; 3],
}

/// Uniform numbers in [0, 1): SplitMix64 (Steele et al. 2014).
struct Uniform(u64);

impl Uniform {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A photon: its place in the cross-section, and its direction in the fibre's frame.
#[derive(Clone, Copy)]
struct Photon {
    place: [f64; 2],
    /// x, y, z of a unit vector.
    direction: [f64; 3],
}

impl Photon {
    /// The distances along the direction to the circle of a radius, the nearer first. `None` if it is missed.
    fn circle(&self, radius: f64) -> Option<[f64; 2]> {
        let ([y, z], [_, dy, dz]) = (self.place, self.direction);
        let a = dy * dy + dz * dz;
        let b = y * dy + z * dz;
        let inside = b * b - a * (y * y + z * z - radius * radius);
        if a < 1e-12 || inside <= 0.0 {
            return None;
        }
        let root = inside.sqrt();
        Some([(-b - root) / a, (-b + root) / a])
    }

    fn advance(&mut self, distance: f64) {
        self.place = [0, 1].map(|i| self.place[i] + distance * self.direction[i + 1]);
    }
}

/// Scattered paths of light that enters at `entry`. There are none if the light misses the medulla, or if it does not
/// scatter.
pub fn scattered(fiber: &Fiber, entry: &Entry, paths: u32, seed: u32) -> Vec<Scattered> {
    let mut uniform = Uniform(u64::from(seed));
    (0..paths).filter_map(|_| walk(fiber, entry, &mut uniform, f64::from(paths))).collect()
}

/// One path. Its first free path ends inside the medulla, and the weight has the probability of that.
fn walk(fiber: &Fiber, entry: &Entry, uniform: &mut Uniform, paths: f64) -> Option<Scattered> {
    let (kappa, sigma_ms) = (f64::from(fiber.kappa), f64::from(fiber.sigma_ms));
    let sin_t = entry.theta.sin() / f64::from(fiber.eta);
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    // The light runs against ω_o, so it goes to −x and to the left.
    let place = on_circle(1.0, entry.azimuth());
    let [dy, dz] = on_circle(cos_t, entry.azimuth() + PI + entry.gamma[1]);
    let mut photon = Photon { place, direction: [-sin_t, dy, dz] };
    let [first, last] = photon.circle(kappa)?;
    let scattered = 1.0 - (-sigma_ms * (last - first)).exp();
    if scattered <= 0.0 || first.is_nan() {
        return None;
    }
    let outside = [place[0] + OUTSIDE, place[1]];
    let mut path = Scattered { points: vec![outside, place], weight: [scattered / paths; 3] };
    let depth = -(1.0 - uniform.next() * scattered).ln() / sigma_ms;
    absorb(&mut path.weight, fiber.sigma_ca, first);
    absorb(&mut path.weight, fiber.sigma_ma, depth);
    photon.advance(first + depth);
    path.points.push(photon.place);
    photon.direction = scatter(photon.direction, f64::from(fiber.g), uniform);
    for _ in 0..EVENTS {
        let free = -(1.0 - uniform.next()).ln() / sigma_ms;
        let radius = photon.place[0].hypot(photon.place[1]);
        // Inside the medulla, the light goes to its edge. In the cortex it goes to the medulla or to the surface.
        let edge = photon.circle(kappa).filter(|[_, far]| *far > 1e-9);
        if let (true, Some([_, far])) = (radius < kappa - 1e-9, edge) {
            let length = free.min(far);
            absorb(&mut path.weight, fiber.sigma_ma, length);
            photon.advance(length);
            if free < far {
                path.points.push(photon.place);
                photon.direction = scatter(photon.direction, f64::from(fiber.g), uniform);
                continue;
            }
        }
        let [_, surface] = photon.circle(1.0)?;
        if let Some([near, far]) = photon.circle(kappa).filter(|[near, far]| *near > 1e-9 && *far < surface) {
            let length = free.min(far - near);
            absorb(&mut path.weight, fiber.sigma_ca, near);
            absorb(&mut path.weight, fiber.sigma_ma, length);
            photon.advance(near + length);
            if free < far - near {
                path.points.push(photon.place);
                photon.direction = scatter(photon.direction, f64::from(fiber.g), uniform);
                continue;
            }
        }
        let [_, surface] = photon.circle(1.0)?;
        absorb(&mut path.weight, fiber.sigma_ca, surface);
        photon.advance(surface);
        path.points.push(photon.place);
        if let Some([dy, dz]) = refract_out(&photon, f64::from(fiber.eta)) {
            let [y, z] = photon.place;
            path.points.push([y + OUTSIDE * dy, z + OUTSIDE * dz]);
            return Some(path);
        }
        photon.direction = reflect(&photon);
    }
    None
}

fn absorb(weight: &mut [f64; 3], sigma: [f32; 3], length: f64) {
    for (weight, sigma) in weight.iter_mut().zip(sigma) {
        *weight *= (-f64::from(sigma) * length.max(0.0)).exp();
    }
}

/// A direction after scattering with the phase function of Henyey and Greenstein.
fn scatter(direction: [f64; 3], g: f64, uniform: &mut Uniform) -> [f64; 3] {
    let [u, v] = [uniform.next(), uniform.next()];
    let cos = if g < 1e-3 {
        1.0 - 2.0 * u
    } else {
        let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
        ((1.0 + g * g - s * s) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let (sin, (sin_phi, cos_phi)) = ((1.0 - cos * cos).max(0.0).sqrt(), (TAU * v).sin_cos());
    // A frame around the direction (Duff et al. 2017).
    let [x, y, z] = direction;
    let sign = 1f64.copysign(z);
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    let (s, t) = ([1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]);
    std::array::from_fn(|i| sin * (cos_phi * s[i] + sin_phi * t[i]) + cos * direction[i])
}

/// The direction in the cross-section of light that leaves the fibre, of unit length. `None` for total reflection, and
/// for light that leaves along the axis.
fn refract_out(photon: &Photon, eta: f64) -> Option<[f64; 2]> {
    let [y, z] = photon.place;
    let [dx, dy, dz] = photon.direction;
    let normal = y * dy + z * dz;
    let tangent = y * dz - z * dy;
    let [along, around] = [eta * dx, eta * tangent];
    let out2 = 1.0 - along * along - around * around;
    if out2 <= 0.0 || normal <= 0.0 {
        return None;
    }
    let out = out2.sqrt();
    let [oy, oz] = [out * y - around * z, out * z + around * y];
    let length = oy.hypot(oz);
    (length > 1e-9).then(|| [oy / length, oz / length])
}

/// The direction after a reflection at the surface.
fn reflect(photon: &Photon) -> [f64; 3] {
    let [y, z] = photon.place;
    let [dx, dy, dz] = photon.direction;
    let normal = y * dy + z * dz;
    [dx, dy - 2.0 * normal * y, dz - 2.0 * normal * z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus::Species;

    fn paths(fiber: &Fiber, h: f64) -> Vec<Scattered> {
        scattered(fiber, &Entry::new(fiber, 0.2, h), 64, 7)
    }

    #[test]
    fn paths_bend_inside_the_medulla_or_at_the_surface_and_their_weights_are_shares() {
        let fiber = Fiber::preset(Species::Rabbit);
        let all = paths(&fiber, 0.3);
        assert!(all.len() > 48, "{}", all.len());
        let kappa = f64::from(fiber.kappa);
        for path in &all {
            let inner = &path.points[2..path.points.len() - 1];
            for [y, z] in inner {
                let radius = y.hypot(*z);
                assert!(radius <= kappa + 1e-6 || (radius - 1.0).abs() < 1e-6, "{radius}");
            }
            assert!(path.weight.iter().all(|w| (0.0..=1.0 / 64.0).contains(w)), "{:?}", path.weight);
        }
    }

    /// A medulla that is absent, missed, or clear scatters nothing.
    #[test]
    fn no_path_scatters_where_nothing_scatters() {
        let fiber = Fiber::preset(Species::Human);
        assert!(paths(&Fiber { kappa: 0.0, ..fiber }, 0.0).is_empty());
        assert!(paths(&Fiber { sigma_ms: 0.0, ..fiber }, 0.0).is_empty());
        assert!(paths(&fiber, 0.99).is_empty());
    }
}
