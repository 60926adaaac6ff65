//! Bodies as signed distance functions: smooth unions of ellipsoids and round cones, each with the direction of its
//! fur.

use glam::{Mat3, Quat, Vec3};

/// A primitive of a body.
#[derive(Clone, Copy, Debug)]
enum Solid {
    /// An ellipsoid with radii along the axes of its own frame.
    Ellipsoid { center: Vec3, radii: Vec3, to_frame: Mat3 },
    /// The union of spheres around the points of the line from a to b, with radii from `ra` to `rb`.
    Cone { a: Vec3, b: Vec3, ra: f32, rb: f32 },
}

/// The direction of fur, before projection onto the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Flow {
    Along(Vec3),
    AwayFrom(Vec3),
}

#[derive(Clone, Copy, Debug)]
struct Part {
    solid: Solid,
    /// Width of the transition to the previous parts. Negative if the part is subtracted.
    blend: f32,
    flow: Flow,
    /// Length of its fur.
    fur: f32,
}

/// A smooth body. Each part is blended with the previous parts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Body {
    parts: Vec<Part>,
}

impl Body {
    fn push(mut self, solid: Solid, blend: f32, flow: Flow, fur: f32) -> Self {
        self.parts.push(Part { solid, blend, flow, fur });
        self
    }

    /// Adds an ellipsoid. `turn` is the rotation from its own frame to world space.
    pub fn ellipsoid(self, center: [f32; 3], radii: [f32; 3], turn: Quat, blend: f32, flow: Flow, fur: f32) -> Self {
        let (center, radii) = (center.into(), radii.into());
        let to_frame = Mat3::from_quat(turn.inverse());
        self.push(Solid::Ellipsoid { center, radii, to_frame }, blend, flow, fur)
    }

    /// Adds a round cone from `a` with radius `ra` to `b` with radius `rb`. Its fur points from a to b.
    pub fn cone(self, a: [f32; 3], ra: f32, b: [f32; 3], rb: f32, blend: f32, fur: f32) -> Self {
        let (a, b): (Vec3, Vec3) = (a.into(), b.into());
        self.push(Solid::Cone { a, b, ra, rb }, blend, Flow::Along(b - a), fur)
    }

    /// Sets the direction of fur of the last part.
    pub fn flowing(mut self, flow: Flow) -> Self {
        if let Some(part) = self.parts.last_mut() {
            part.flow = flow;
        }
        self
    }

    /// Subtracts the last part instead of adding it.
    pub fn carved(mut self) -> Self {
        if let Some(part) = self.parts.last_mut() {
            part.blend = -part.blend;
        }
        self
    }

    /// Adds copies of all parts from index `first`, mirrored at z = 0.
    pub fn mirrored_z(mut self, first: usize) -> Self {
        let flip = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
        for i in first..self.parts.len() {
            let Part { solid, blend, flow, fur } = self.parts[i];
            let solid = match solid {
                Solid::Ellipsoid { center, radii, to_frame } => {
                    let mirror = Mat3::from_diagonal(Vec3::new(1.0, 1.0, -1.0));
                    Solid::Ellipsoid { center: flip(center), radii, to_frame: mirror * to_frame * mirror }
                }
                Solid::Cone { a, b, ra, rb } => Solid::Cone { a: flip(a), b: flip(b), ra, rb },
            };
            let flow = match flow {
                Flow::Along(v) => Flow::Along(flip(v)),
                Flow::AwayFrom(p) => Flow::AwayFrom(flip(p)),
            };
            self.parts.push(Part { solid, blend, flow, fur });
        }
        self
    }

    /// Number of parts, which is the index of the next part.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Signed distance to the surface, negative inside. It is exact near round parts, and an estimate near ellipsoids.
    pub fn distance(&self, p: Vec3) -> f32 {
        self.parts.iter().fold(f32::INFINITY, |d, part| {
            // Distant parts do not change the distance. Their bounding sphere is faster to compute.
            let own = if part.blend >= 0.0 { d } else { -d };
            let is_far = part.solid.beyond(p) >= own + part.blend.abs();
            if is_far { d } else { part.join(d, part.solid.distance(p)) }
        })
    }

    /// The gradient of the distance: the outward normal on the surface.
    pub fn gradient(&self, p: Vec3) -> Vec3 {
        gradient(&|p| self.distance(p), p)
    }

    /// A point on the surface near `p`.
    pub fn project(&self, mut p: Vec3) -> Vec3 {
        for _ in 0..6 {
            let g = self.gradient(p);
            p -= self.distance(p) * g / g.length_squared().max(1e-6);
        }
        p
    }

    /// Direction and length of fur at `p`: a weighted mean over parts, whose weights fall off with the distance over
    /// `soft`.
    pub fn coat(&self, p: Vec3, soft: f32) -> (Vec3, f32) {
        let nearest = self.solids().map(|part| part.solid.distance(p).abs()).fold(f32::INFINITY, f32::min);
        let (mut flow, mut fur, mut total) = (Vec3::ZERO, 0.0, 0.0);
        for part in self.solids() {
            let weight = ((nearest - part.solid.distance(p).abs()) / soft).exp();
            let way = match part.flow {
                Flow::Along(v) => v,
                Flow::AwayFrom(q) => p - q,
            };
            flow += weight * way.normalize_or_zero();
            fur += weight * part.fur;
            total += weight;
        }
        (flow / total, fur / total)
    }

    fn solids(&self) -> impl Iterator<Item = &Part> {
        self.parts.iter().filter(|part| part.blend >= 0.0)
    }

    /// The bounding box.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.solids().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), part| {
            let (l, h) = part.solid.bounds();
            // Blending expands the body by at most a quarter of the width.
            let swell = Vec3::splat(0.25 * part.blend);
            (low.min(l - swell), high.max(h + swell))
        })
    }
}

impl Part {
    /// The polynomial smooth minimum (Quilez). It differs from the minimum only if the distances differ by less than
    /// `blend`.
    fn join(&self, d: f32, own: f32) -> f32 {
        let k = self.blend.abs().max(1e-6);
        let smooth = |a: f32, b: f32| {
            let h = (1.0 - (a - b).abs() / k).max(0.0);
            a.min(b) - 0.25 * k * h * h
        };
        if self.blend >= 0.0 { if d.is_finite() { smooth(d, own) } else { own } } else { -smooth(-d, own) }
    }
}

impl Solid {
    fn distance(&self, p: Vec3) -> f32 {
        match *self {
            Solid::Ellipsoid { center, radii, to_frame } => {
                let q = to_frame * (p - center) / radii;
                let (k0, k1) = (q.length(), (q / radii).length());
                if k1 > 0.0 { k0 * (k0 - 1.0) / k1 } else { -radii.min_element() }
            }
            Solid::Cone { a, b, ra, rb } => {
                let (along, across) = (b - a, p - a);
                let t = (across.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                (across - t * along).length() - (ra + t * (rb - ra))
            }
        }
    }

    /// A lower bound of the distance, from a bounding sphere.
    fn beyond(&self, p: Vec3) -> f32 {
        match *self {
            Solid::Ellipsoid { center, radii, .. } => p.distance(center) - radii.max_element(),
            Solid::Cone { a, b, ra, rb } => p.distance(0.5 * (a + b)) - 0.5 * a.distance(b) - ra.max(rb),
        }
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        match *self {
            Solid::Ellipsoid { center, radii, .. } => {
                let r = Vec3::splat(radii.max_element());
                (center - r, center + r)
            }
            Solid::Cone { a, b, ra, rb } => {
                let (ra, rb) = (Vec3::splat(ra), Vec3::splat(rb));
                ((a - ra).min(b - rb), (a + ra).max(b + rb))
            }
        }
    }
}

/// The gradient by central differences over 0.01 units. Bodies have no smaller features.
pub(crate) fn gradient(distance: &dyn Fn(Vec3) -> f32, p: Vec3) -> Vec3 {
    let e = 0.01;
    let along = |axis: Vec3| distance(p + e * axis) - distance(p - e * axis);
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)) / (2.0 * e)
}
