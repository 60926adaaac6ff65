//! Compares the closed forms with paths that are traced event by event, in three dimensions and f64.

use super::paths::Paths;
use crate::entry::Entry;
use std::f64::consts::{PI, TAU};
use vellus::{Fiber, Window};
use vellus_reference::exact::fresnel;

/// A ray with its remaining energy (first channel).
#[derive(Clone, Copy)]
struct Ray {
    p: [f64; 2],
    d: [f64; 3],
    energy: f64,
}

/// Reflected and refracted direction at a normal opposite to `d`, and the cosines on both sides.
fn split(d: [f64; 3], normal: [f64; 3], from: f64, to: f64) -> ([f64; 3], Option<[f64; 3]>, f64, f64) {
    let cos = -(d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2]);
    let back: [f64; 3] = std::array::from_fn(|k| d[k] + 2.0 * cos * normal[k]);
    let ratio = from / to;
    let sin2 = ratio * ratio * (1.0 - cos * cos);
    if sin2 >= 1.0 {
        return (back, None, cos, 0.0);
    }
    let cos_t = (1.0 - sin2).sqrt();
    (back, Some(std::array::from_fn(|k| ratio * d[k] + (ratio * cos - cos_t) * normal[k])), cos, cos_t)
}

/// Distance to the circle of radius r: to the first intersection from outside, or to the exit from inside.
fn distance(ray: &Ray, r: f64, outside: bool) -> Option<f64> {
    let a = ray.d[1].powi(2) + ray.d[2].powi(2);
    let b = ray.p[0] * ray.d[1] + ray.p[1] * ray.d[2];
    let c = ray.p[0].powi(2) + ray.p[1].powi(2) - r * r;
    let root = (b * b - a * c).max(0.0).sqrt();
    (b * b - a * c >= 0.0).then_some(if outside { (-b - root) / a } else { (-b + root) / a })
}

/// Traces the path with these `events`. `None` if total reflection or a miss of the medulla makes it impossible.
fn trace(fiber: &Fiber, eta_m: f64, theta_o: f64, h: f64, events: &str) -> Option<Ray> {
    let (eta_c, kappa) = (f64::from(fiber.eta), f64::from(fiber.kappa));
    let (ca, ma) = (f64::from(fiber.sigma_ca[0]), f64::from(fiber.sigma_ma[0] + fiber.sigma_ms));
    let cos_gamma = (1.0 - h * h).sqrt();
    let mut ray = Ray { p: [cos_gamma, -h], d: [-theta_o.sin(), -theta_o.cos(), 0.0], energy: 1.0 };
    // 0 is outside, 1 is in the cortex, 2 is in the medulla.
    let mut place = 0;
    for (i, event) in events.chars().enumerate() {
        if i > 0 {
            let (r, outside) = match (place, event.is_uppercase()) {
                (1, true) => (1.0, false),
                (1, false) => (kappa, true),
                _ => (kappa, false),
            };
            let t = distance(&ray, r, outside)?;
            ray.p = [ray.p[0] + t * ray.d[1], ray.p[1] + t * ray.d[2]];
            ray.energy *= (-t * if place == 2 { ma } else { ca }).exp();
        }
        let cuticle = event.is_uppercase();
        let inward = if cuticle { place == 0 } else { place == 1 };
        let r = ray.p[0].hypot(ray.p[1]);
        let sign = if inward { 1.0 } else { -1.0 };
        let normal = [0.0, sign * ray.p[0] / r, sign * ray.p[1] / r];
        let (outer, inner) = if cuticle { (1.0, eta_c) } else { (eta_c, eta_m) };
        let (from, to) = if inward { (outer, inner) } else { (inner, outer) };
        let (back, through, cos, cos_t) = split(ray.d, normal, from, to);
        let reflected = match through {
            None => 1.0,
            Some(_) if cuticle => fresnel(eta_c, fiber.layers.into(), if inward { cos } else { cos_t }),
            Some(_) => {
                let (a, b) = (from * cos - to * cos_t, to * cos - from * cos_t);
                let (c, d) = (from * cos + to * cos_t, to * cos + from * cos_t);
                0.5 * ((a / c).powi(2) + (b / d).powi(2))
            }
        };
        if event.eq_ignore_ascii_case(&'r') {
            ray.d = back;
            ray.energy *= reflected;
        } else {
            ray.d = through?;
            ray.energy *= 1.0 - reflected;
            place = if cuticle { i32::from(inward) } else { 1 + i32::from(inward) };
        }
    }
    Some(ray)
}

#[test]
fn closed_forms_are_the_traced_paths() {
    let events = ["R", "TT", "TRT", "TrT", "TrRrT", "TttT", "TtrtT", "TttRttT"];
    let fiber = Fiber {
        kappa: 0.62,
        layers: 0.8,
        sigma_ca: [0.3; 3],
        sigma_ma: [0.2; 3],
        sigma_ms: 0.4,
        g: 0.3,
        ..Fiber::hair()
    };
    let same_turn = |a: f64, b: f64| (a - b + PI).rem_euclid(TAU) - PI;
    let (mut compared, mut total) = (0, 0);
    for (eta_c, eta_m) in [(1.55, 1.55), (1.45, 1.0), (1.3, 1.7)] {
        let fiber = Fiber { eta: eta_c, ..fiber };
        for theta_o in [0.0, -0.4, 0.9, 1.35] {
            for h in [-0.97, -0.75, -0.4, -0.01, 0.2, 0.55, 0.9] {
                let wo = glam::DVec3::new(f64::sin(theta_o), f64::cos(theta_o), 0.0).as_vec3();
                let entry = Entry::new(wo, Window::near(h as f32), eta_c, Some(fiber.layers));
                let paths = Paths::new(&fiber, eta_m, &entry);
                let beside = (f64::from(entry.h_inside)).abs() >= f64::from(fiber.kappa);
                for (i, name) in events.iter().enumerate() {
                    // A ray either passes beside the medulla or hits it.
                    let exists = i == 0 || (i < 3) == beside;
                    let ours = f64::from(paths.unscattered[0][i]);
                    let at = format!("{name} η {eta_c} {eta_m} θ {theta_o} h {h}");
                    match trace(&fiber, eta_m.into(), theta_o, h, name) {
                        Some(ray) if exists => {
                            // The tolerance is twenty rounding errors of 6e-8, for cosines as small as 0.1.
                            assert!(
                                (ours - ray.energy).abs() < 2e-5 * ray.energy + 1e-8,
                                "{at}: {ours} {}",
                                ray.energy
                            );
                            let phi = ray.d[2].atan2(ray.d[1]);
                            let turn = same_turn(paths.exit[i].into(), phi);
                            assert!(ours < 1e-8 || turn.abs() < 2e-5, "{at}: {} {phi}", paths.exit[i]);
                            compared += 1;
                        }
                        _ => assert_eq!(ours, 0.0, "{at}"),
                    }
                }
                for (i, name) in ["Tt", "Ttr", "TttRt"].iter().enumerate() {
                    let ray = if beside { None } else { trace(&fiber, eta_m.into(), theta_o, h, name) };
                    let at = format!("{name} η {eta_c} {eta_m} θ {theta_o} h {h}");
                    let (Some(m), Some(ray)) = (paths.medulla, ray) else {
                        assert!(paths.medulla.is_none() && ray.is_none(), "{at}");
                        continue;
                    };
                    let across = ray.d[1].hypot(ray.d[2]);
                    let offset = (ray.p[0] * ray.d[2] - ray.p[1] * ray.d[1]) / across / f64::from(fiber.kappa);
                    assert!((offset.abs() - f64::from(m.angle).sin().abs()).abs() < 1e-5, "{at}: {offset}");
                    assert!((ray.d[0] + f64::from(m.sin_m)).abs() < 1e-6, "{at}");
                    let turn = same_turn(m.back[i].into(), (-ray.d[2]).atan2(-ray.d[1]));
                    assert!(turn.abs() < 2e-5, "{at}: {turn}");
                    // The medulla scatters the fraction Q along the chord.
                    let chord = distance(&ray, fiber.kappa.into(), false).unwrap();
                    let expected = ray.energy * -(-chord * f64::from(fiber.sigma_ms)).exp_m1();
                    let ours = f64::from(m.scattered[i][0]);
                    assert!((ours - expected).abs() < 2e-5 * expected + 1e-8, "{at}: {ours} {expected}");
                    total += 1;
                }
            }
        }
    }
    // There are R and two to five other paths at each of 84 hits, and most passes.
    assert!(compared > 250 && total > 100, "{compared} {total}");
}
