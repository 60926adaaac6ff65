//! A fibre whose section is an ellipse (D23), or whose medulla has an index of its own (D24), traced from crossing to
//! crossing in the plane of the section.

use super::formulas::fresnel;
use super::{Exact, ExactHit, ExactPath, mean_path};

/// What is different from a circle.
#[derive(Clone, Debug)]
pub(crate) struct Flat {
    /// The exit azimuths of R, TT and TRT relative to ω_o, then the azimuths opposite to the light in its two passes.
    pub exits: [f64; 5],
    /// h″ with its sign.
    pub offset: f64,
    /// The squares of the cosines of the angles to the normal at which TT and TRT leave. Below 0: total reflection.
    pub squares: [f64; 2],
}

/// One pass through the section: halves of its lengths in cortex and medulla, h″, and where and how it ends.
struct Leg {
    s_c: f64,
    s_m: f64,
    offset: f64,
    point: [f64; 2],
    normal: [f64; 2],
    /// The direction of the light at the end, and in the medulla.
    along: [f64; 2],
    within: [f64; 2],
    /// The reflectance of the medulla's wall, and whether the path follows the reflection.
    wall: f64,
    mirrored: bool,
}

/// The direction after a crossing with a ratio of indices, and cos² of its angle to the normal.
fn refract(d: [f64; 2], n: [f64; 2], ratio: f64) -> ([f64; 2], f64) {
    let along = dot(d, n);
    let aside = [d[0] - along * n[0], d[1] - along * n[1]].map(|x| ratio * x);
    let square = 1.0 - dot(aside, aside);
    let cos = square.max(0.0).sqrt() * along.signum();
    ([aside[0] + cos * n[0], aside[1] + cos * n[1]], square)
}

fn reflect(d: [f64; 2], n: [f64; 2]) -> [f64; 2] {
    let along = dot(d, n);
    [d[0] - 2.0 * along * n[0], d[1] - 2.0 * along * n[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn unit(v: [f64; 2]) -> [f64; 2] {
    v.map(|x| x / v[0].hypot(v[1]))
}

impl ExactHit<'_, '_> {
    /// Whether TT or TRT of a flat fibre leaves at an angle to the normal with a cosine below `cos`, or nearly would.
    pub fn grazes(&self, cos: f64) -> bool {
        self.path.flat.as_ref().is_some_and(|flat| flat.squares.iter().any(|x| x.abs() < cos * cos))
    }
}

impl<'t> Exact<'t> {
    fn axes(&self) -> [f64; 2] {
        [1.0 / self.aspect_ratio.sqrt(), self.aspect_ratio.sqrt()]
    }

    /// The outward normal of a point.
    fn normal(&self, point: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.axes();
        unit([point[0] / (a * a), point[1] / (b * b)])
    }

    /// Both distances at which a line crosses an ellipse with axes `scale` times those of the section.
    fn crossings(&self, from: [f64; 2], along: [f64; 2], scale: f64) -> Option<[f64; 2]> {
        let axes = self.axes().map(|x| x * scale);
        let [p, d] = [from, along].map(|v| [v[0] / axes[0], v[1] / axes[1]]);
        let (a, b, c) = (dot(d, d), dot(p, d), dot(p, p) - 1.0);
        let room = b * b - a * c;
        (room > 0.0).then(|| [(-b - room.sqrt()) / a, (-b + room.sqrt()) / a])
    }

    fn leg(&self, theta_o: f64, from: [f64; 2], along: [f64; 2]) -> Leg {
        if let (true, Some([near, _])) = (self.eta_m < self.eta, self.crossings(from, along, self.kappa)) {
            return self.by_wall(theta_o, from, along, near);
        }
        let length = self.crossings(from, along, 1.0).map_or(0.0, |[_, far]| far);
        let inside = match self.kappa > 0.0 {
            true => self.crossings(from, along, self.kappa).map_or(0.0, |[near, far]| far - near),
            false => 0.0,
        };
        let [a, b] = self.axes();
        let point = [from[0] + length * along[0], from[1] + length * along[1]];
        // The offset is that of the light's way back, on the section drawn as a circle.
        let back = unit([-along[0] / a, -along[1] / b]);
        let on_circle = (from[0] / a) * back[1] - (from[1] / b) * back[0];
        let offset = if self.kappa > 0.0 { (on_circle / self.kappa).clamp(-1.0, 1.0) } else { 0.0 };
        let (s_c, s_m, normal) = (0.5 * (length - inside), 0.5 * inside, self.normal(point));
        Leg { s_c, s_m, offset, point, normal, along, within: along, wall: 0.0, mirrored: false }
    }

    /// A pass that meets the wall of the medulla after `near`. Of the paths along its reflection and through the
    /// medulla it is the brighter one, without absorption.
    fn by_wall(&self, theta_o: f64, from: [f64; 2], along: [f64; 2], near: f64) -> Leg {
        let moved = |p: [f64; 2], d: [f64; 2], t: f64| [p[0] + t * d[0], p[1] + t * d[1]];
        let start = moved(from, along, near);
        let normal = self.normal(start);
        let (cos_t, cos_m) = (1.0 / self.elongation(theta_o), 1.0 / self.medulla_elongation(theta_o));
        let ratio = self.eta * cos_t / (self.eta_m * cos_m);
        let (within, square) = refract(along, normal, ratio);
        let wall = fresnel(self.eta / self.eta_m, 0.5, cos_m * square.max(0.0).sqrt());
        let chord = match square > 0.0 {
            true => self.crossings(start, within, self.kappa).map_or(0.0, |[_, far]| far),
            false => 0.0,
        };
        let passes = (1.0 - wall).powi(2) * (-chord * self.sigma_ms / cos_m).exp();
        let mirrored = square <= 0.0 || wall > passes;
        let leaves = moved(start, within, chord);
        let (from, out) = match mirrored {
            true => (start, reflect(along, normal)),
            false => (leaves, refract(within, self.normal(leaves), 1.0 / ratio).0),
        };
        let after = self.crossings(from, out, 1.0).map_or(0.0, |[_, far]| far);
        let point = moved(from, out, after);
        // The offset is that of the light's way back, on the section drawn as a circle.
        let [a, b] = self.axes();
        let back = unit([-within[0] / a, -within[1] / b]);
        let on_circle = (start[0] / a) * back[1] - (start[1] / b) * back[0];
        let offset = if square > 0.0 { (on_circle / self.kappa).clamp(-1.0, 1.0) } else { on_circle.signum() };
        let (s_c, s_m, normal) = (0.5 * (near + after), 0.5 * chord, self.normal(point));
        Leg { s_c, s_m, offset, point, normal, along: out, within, wall, mirrored }
    }

    /// Prepares the hit of a ray at the inclination and the azimuth `[theta_o, phi_o]` (radians, |θ_o| < π/2) and the
    /// offset `h` in [−1, 1]. The longer axis of the section is at φ = 0.
    pub fn at_flat(&self, [theta_o, phi_o]: [f64; 2], h: f64) -> ExactHit<'_, 't> {
        let longitudinal = self.inclination(theta_o);
        let path = self.flat_path([theta_o, phi_o], h);
        let offset = path.flat.as_ref().map_or(0.0, |flat| flat.offset);
        let azimuthal = self.profile_of_offset(theta_o, offset.abs()).over_leaving(longitudinal.leaving());
        ExactHit { path, azimuthal, longitudinal }
    }

    pub(super) fn flat_path(&self, [theta_o, phi_o]: [f64; 2], h: f64) -> ExactPath<'_, 't> {
        let o = self;
        let ([a, b], (sin, cos)) = (o.axes(), phi_o.sin_cos());
        let (eta, cos_t) = (o.eta_prime(theta_o), 1.0 / o.elongation(theta_o));
        let cos_m = 1.0 / o.medulla_elongation(theta_o);
        let half = (a * sin).hypot(b * cos);
        let start = [10.0 * cos + h * half * sin, 10.0 * sin - h * half * cos];
        // At the silhouette, rounding may miss the fibre.
        let near = o.crossings(start, [-cos, -sin], 1.0).map_or(10.0, |[near, _]| near);
        let entry = [start[0] - near * cos, start[1] - near * sin];
        let normal = o.normal(entry);
        let azimuth = |v: [f64; 2]| v[1].atan2(v[0]) - phi_o;
        let arriving = [-cos, -sin];
        let (inside, _) = refract(arriving, normal, 1.0 / eta);
        let first = o.leg(theta_o, entry, inside);
        let again = reflect(first.along, first.normal);
        let second = o.leg(theta_o, first.point, again);
        let (tt, square_1) = refract(first.along, first.normal, eta);
        let (trt, square_2) = refract(second.along, second.normal, eta);
        let reflectance = |cos: f64| fresnel(o.eta, o.layers, theta_o.cos() * cos);
        let [f, f1, f2] = [-dot(arriving, normal), square_1.max(0.0).sqrt(), square_2.max(0.0).sqrt()].map(reflectance);
        let back = |d: [f64; 2]| azimuth([-d[0], -d[1]]);
        let exits =
            [azimuth(reflect(arriving, normal)), azimuth(tt), azimuth(trt), back(first.within), back(second.within)];

        // Light that only meets the medulla in its second pass has no table.
        let misses = o.kappa == 0.0 || first.offset.abs() >= 1.0;
        let mean = match misses {
            true => 0.0,
            false => mean_path(o.tables, o.sigma_ms * o.kappa / cos_m, o.g, first.offset.abs()),
        };
        let legs = [&first, &second];
        let entries = legs.map(|leg| o.sigma_ca.map(|ca| (-leg.s_c * ca / cos_t).exp()));
        let leaves = [0, 1].map(|k| o.escape_of_offset(theta_o, legs[k].offset, entries[k]));
        let (mut attenuation, mut scattered, mut diffuse) = ([[0.0; 3]; 6], [0.0; 3], [0.0; 3]);
        for c in 0..3 {
            let (ca, ma) = (o.sigma_ca[c], o.sigma_ma[c]);
            // What goes through a pass, and what is scattered and leaves at once, or later.
            let [one, two] = [0, 1].map(|k| {
                let (leg, entry) = (legs[k], entries[k][c]);
                let cortex = (-2.0 * leg.s_c * ca / cos_t).exp();
                let chord = (-2.0 * leg.s_m * (ma + o.sigma_ms) / cos_m).exp();
                // All chords after reflections at the wall from inside.
                let chords = 1.0 / (1.0 - leg.wall * chord).max(1e-300);
                let lens = (1.0 - leg.wall).powi(2) * chord;
                let through = cortex * (leg.wall + lens * chords);
                let along = cortex * if leg.mirrored { leg.wall } else { lens };
                let q = entry * (1.0 - leg.wall) * chords * (1.0 - (-2.0 * leg.s_m * o.sigma_ms / cos_m).exp());
                let [now, late] = match leaves[k] {
                    None => [q * (-o.kappa * mean * ma / cos_m - (1.0 - o.kappa) * ca / cos_m).exp(), 0.0],
                    Some([escape, first]) => [q * escape[c] * first[c], q * escape[c] * (1.0 - first[c])],
                };
                [along, now, late, through]
            });
            let begin = [1.0 - f, (1.0 - f) * one[0] * f1, (1.0 - f) * one[0] * f1 * two[0] * f2];
            // What reaches the cuticle along other paths than those of TT and TRT.
            let aside = begin[0] * (one[3] - one[0]) + begin[1] * (two[3] - two[0]);
            let rest = (begin[2] + f * aside) / (1.0 - f * one[3]).max(1e-300);
            let late = begin[0] * one[2] + begin[1] * two[2] + rest * (one[1] + one[2]);
            let aimless = if misses { begin[1] * two[1] } else { 0.0 };
            diffuse[c] = late + aimless;
            scattered[c] = one[1];
            let higher = (rest * one[3] + aside) * (1.0 - f);
            let lobes = [f, begin[0] * one[0] * (1.0 - f1), begin[1] * two[0] * (1.0 - f2), begin[0] * one[1]];
            (0..4).for_each(|p| attenuation[p][c] = lobes[p]);
            attenuation[4][c] = begin[1] * two[1] - aimless;
            attenuation[5][c] = higher + diffuse[c];
        }
        // The angles of the first exit.
        let angle = |d: [f64; 2]| (d[0] * first.normal[1] - d[1] * first.normal[0]).atan2(dot(d, first.normal));
        let flat = Some(Flat { exits, offset: first.offset, squares: [square_1, square_2] });
        // The wall turns light that leaves the medulla as it turns light that enters.
        let turn = (inside[0] * first.within[1] - inside[1] * first.within[0]).atan2(dot(inside, first.within));
        let (gamma_o, gamma_t) = (angle(tt), angle(first.along) + turn);
        let (s_c, s_m) = (first.s_c, first.s_m);
        ExactPath { exact: self, theta_o, gamma_o, gamma_t, s_c, s_m, scattered, attenuation, diffuse, flat }
    }
}
