// Segments of strands: the surface of a disk that is swept along a cubic, or the hull of two balls. A ball closes each
// end of a strand of cubics.

// A segment as a cubic Bezier curve of x, y, z and radius.
struct Segment {
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
    d: vec4<f32>,
    linear: bool,
}

// The set of strands of a control point: the index of its first row.
fn set_of(point: u32) -> u32 {
    let sets = data_row(SETS);
    var low = 0u;
    var high = sets.x;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if data_row(sets.y + 2u * middle).x <= point {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

fn segment_of(first: u32) -> Segment {
    let row = data_row(SETS).y + 2u * set_of(first);
    let basis = data_row(row).y;
    let p = point_at(first);
    let q = point_at(first + 1u);
    var s: Segment;
    s.linear = basis == 0u;
    if s.linear {
        s.a = p;
        s.d = q;
        s.b = p + (q - p) / 3.0;
        s.c = q + (p - q) / 3.0;
    } else {
        let r = point_at(first + 2u);
        let t = point_at(first + 3u);
        if basis == 1u {
            s.a = p;
            s.b = q;
            s.c = r;
            s.d = t;
        } else if basis == 2u {
            s.a = (p + 4.0 * q + r) / 6.0;
            s.b = (2.0 * q + r) / 3.0;
            s.c = (q + 2.0 * r) / 3.0;
            s.d = (q + 4.0 * r + t) / 6.0;
        } else {
            s.a = q;
            s.b = q + (r - p) / 6.0;
            s.c = r + (q - t) / 6.0;
            s.d = r;
        }
    }
    s.a.w = max(s.a.w, 0.0);
    s.b.w = max(s.b.w, 0.0);
    s.c.w = max(s.c.w, 0.0);
    s.d.w = max(s.d.w, 0.0);
    return s;
}

// Position and radius.
fn segment_at(s: Segment, u: f32) -> vec4<f32> {
    let v = 1.0 - u;
    return s.a * (v * v * v) + s.b * (3.0 * v * v * u) + s.c * (3.0 * v * u * u) + s.d * (u * u * u);
}

// The unit tangent, toward the tip. The chord replaces it if control points coincide.
fn segment_tangent(s: Segment, u: f32) -> vec3<f32> {
    let v = 1.0 - u;
    let slope = (s.b - s.a) * (v * v) + (s.c - s.b) * (2.0 * v * u) + (s.d - s.c) * (u * u);
    return normalize_or(slope.xyz, normalize_or((s.d - s.a).xyz, vec3<f32>(1.0, 0.0, 0.0)));
}

// Distance along the ray and parameter of the first entry. The distance is negative if there is none. `margins` are
// those of its chord: a bit after each tells whether an end has a cap.
fn enter_segment(s: Segment, margins: u32, ray: Ray) -> vec2<f32> {
    if s.linear {
        return enter_cone(s, ray);
    }
    var best = enter_swept(s, ray);
    if (margins & 0x10000u) != 0u {
        best = nearer(best, enter_ball(s.a, ray), 0.0);
    }
    if (margins & 1u) != 0u {
        best = nearer(best, enter_ball(s.d, ray), 1.0);
    }
    return best;
}

fn nearer(best: vec2<f32>, t: f32, u: f32) -> vec2<f32> {
    if t > 0.0 && (best.x < 0.0 || t < best.x) {
        return vec2<f32>(t, u);
    }
    return best;
}

// Distance to the entry into a ball, or a negative number.
fn enter_ball(ball: vec4<f32>, ray: Ray) -> f32 {
    let origin = ray.origin - ball.xyz;
    let half = dot(origin, ray.direction);
    let beside = origin - half * ray.direction;
    let room = ball.w * ball.w - dot(beside, beside);
    let t = -half - sqrt(max(room, 0.0));
    return select(-1.0, t, room >= 0.0 && t < ray.t_max);
}

// The hull of two balls: the cone that touches both, or one of the balls.
fn enter_cone(s: Segment, ray: Ray) -> vec2<f32> {
    let axis = (s.d - s.a).xyz;
    let rise = s.d.w - s.a.w;
    let origin = ray.origin - s.a.xyz;
    let d = ray.direction;
    // Starts at the point of the ray nearest to the first end, where distances keep their digits.
    let start = -dot(origin, d);
    let begin = origin + d * start;
    let along = dot(axis, d);
    let slant = dot(axis, axis) - rise * rise;
    var best = vec2<f32>(-1.0, 0.0);
    var t_max = ray.t_max;
    if slant > 0.0 {
        let k = dot(begin, axis) + s.a.w * rise;
        let qa = slant - along * along;
        let qb = slant * dot(begin, d) - k * along;
        let qc = slant * (dot(begin, begin) - s.a.w * s.a.w) - k * k;
        let discriminant = qb * qb - qa * qc;
        if qa > 0.0 && discriminant >= 0.0 {
            let t = (-qb - sqrt(discriminant)) / qa;
            let u = (k + along * t) / slant;
            if u >= 0.0 && u <= 1.0 && t + start > 0.0 && t + start < t_max {
                best = vec2<f32>(t + start, u);
                t_max = t + start;
            }
        }
    }
    for (var end = 0u; end < 2u; end++) {
        let u = f32(end);
        let radius = select(s.a.w, s.d.w, end == 1u);
        let q = begin - u * axis;
        let half = dot(q, d);
        let discriminant = half * half - (dot(q, q) - radius * radius);
        if discriminant >= 0.0 {
            let t = start - half - sqrt(discriminant);
            if t > 0.0 && t < t_max {
                best = vec2<f32>(t, u);
                t_max = t;
            }
        }
    }
    return best;
}

// A cubic in the coordinates of the ray: coefficients of x, y, distance along the ray, and radius.
struct Cubic {
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
    d: vec4<f32>,
}

fn in_ray(p: vec4<f32>, ray: Ray, basis: Basis) -> vec4<f32> {
    let q = p.xyz - ray.origin;
    return vec4<f32>(dot(q, basis.x), dot(q, basis.y), dot(q, ray.direction), p.w);
}

// Newton's method with a cone as the local model of the curve (after Reshetov and Luebke 2018).
fn enter_swept(s: Segment, ray: Ray) -> vec2<f32> {
    let basis = basis_of(ray.direction);
    let a = in_ray(s.a, ray, basis);
    let b = in_ray(s.b, ray, basis);
    let c = in_ray(s.c, ray, basis);
    let d = in_ray(s.d, ray, basis);
    let first = b - a;
    let second = c - b;
    let third = d - c;
    let cubic = Cubic(a, 3.0 * first, 3.0 * (second - first), third - second - second + first);
    // The number of pieces, such that the tangent turns little in each.
    let xx = dot(first.xyz, first.xyz);
    let yy = dot(second.xyz, second.xyz);
    let zz = dot(third.xyz, third.xyz);
    let scale = max(sqrt(xx) * sqrt(yy) * sqrt(zz), 1e-37);
    let bend = 2.0 - (dot(first.xyz, second.xyz) * sqrt(zz) + dot(second.xyz, third.xyz) * sqrt(xx)) / scale;
    let pieces = select(select(4u, 2u, bend < 0.2), 1u, bend < 0.02);
    var best = vec2<f32>(-1.0, 0.0);
    for (var i = 0u; i < pieces; i++) {
        let entry = newton(cubic, ray.t_max, f32(i) / f32(pieces), f32(i + 1u) / f32(pieces));
        if entry.x > 0.0 && (best.x < 0.0 || entry.x < best.x) {
            best = entry;
        }
    }
    return best;
}

fn cubic_at(k: Cubic, u: f32) -> vec4<f32> {
    return ((k.d * u + k.c) * u + k.b) * u + k.a;
}

fn newton(k: Cubic, t_max: f32, low: f32, high: f32) -> vec2<f32> {
    let none = vec2<f32>(-1.0, 0.0);
    // Starts at the ray's closest approach to the chord of the piece.
    let a = cubic_at(k, low).xy;
    let chord = cubic_at(k, high).xy - a;
    var u = low + (high - low) * clamp(-dot(a, chord) / max(dot(chord, chord), 1e-37), 0.0, 1.0);
    let slack = 0.05 * (high - low);
    for (var i = 0; i < 12; i++) {
        let p = cubic_at(k, u);
        let s = (k.d * (3.0 * u) + (k.c + k.c)) * u + k.b;
        // The entry into the infinite cone around the tangent: qa t^2 + 2 qb t + qc.
        let length2 = max(dot(s.xyz, s.xyz), 1e-37);
        let w0 = -dot(p.xy, s.xy) / length2;
        let w1 = s.z / length2;
        let r0 = p.w + s.w * w0;
        let r1 = s.w * w1;
        let qa = 1.0 - s.z * w1 - r1 * r1;
        let qb = -w0 * s.z - r0 * r1;
        let qc = dot(p.xy, p.xy) - w0 * w0 * length2 - r0 * r0;
        if qa <= 0.0 {
            return none;
        }
        let discriminant = qb * qb - qa * qc;
        let t = (-qb - sqrt(max(discriminant, 0.0))) / qa;
        let step = w0 + w1 * t;
        let next = u + clamp(step, -0.5, 0.5);
        if abs(step) < 0.02 {
            let inside = next >= low - 1e-4 && next <= high + 1e-4;
            let distance = p.z + t;
            if discriminant < 0.0 || !inside || distance <= 0.0 || distance >= t_max {
                return none;
            }
            return vec2<f32>(distance, clamp(next, 0.0, 1.0));
        }
        // The method may leave the piece a little and return.
        if (next < low - slack && u <= low - slack) || (next > high + slack && u >= high + slack) {
            return none;
        }
        u = clamp(next, low - 2.0 * slack, high + 2.0 * slack);
    }
    return none;
}

// A bit for each of four chords of a leaf that is within reach of the ray.
fn near_chords(leaf: u32, half: u32, ray: Ray, basis: Basis, t_max: f32) -> u32 {
    let row = leaf * 16u + half;
    let ax = chord_at(row) - ray.origin.x;
    let ay = chord_at(row + 2u) - ray.origin.y;
    let az = chord_at(row + 4u) - ray.origin.z;
    let bx = chord_at(row + 6u) - ray.origin.x;
    let by = chord_at(row + 8u) - ray.origin.y;
    let bz = chord_at(row + 10u) - ray.origin.z;
    let margins = chord_row(row + 12u);
    let reach = bitcast<vec4<f32>>(margins & vec4<u32>(0xffff0000u));
    let back = bitcast<vec4<f32>>(margins << vec4<u32>(16u));
    let d = ray.direction;
    let u0 = ax * basis.x.x + ay * basis.x.y + az * basis.x.z;
    let v0 = ax * basis.y.x + ay * basis.y.y + az * basis.y.z;
    let w0 = ax * d.x + ay * d.y + az * d.z;
    let x = bx * basis.x.x + by * basis.x.y + bz * basis.x.z - u0;
    let y = bx * basis.y.x + by * basis.y.y + bz * basis.y.z - v0;
    let rise = bx * d.x + by * d.y + bz * d.z - w0;
    let inverse = 1.0 / max(x * x + y * y, vec4<f32>(1e-37));
    let s = clamp(-(u0 * x + v0 * y) * inverse, vec4<f32>(0.0), vec4<f32>(1.0));
    let px = u0 + s * x;
    let py = v0 + s * y;
    let room = reach * reach - (px * px + py * py);
    let around = sqrt(max(room, vec4<f32>(0.0)) * inverse);
    let near = w0 + max(s - around, vec4<f32>(0.0)) * rise;
    let far = w0 + min(s + around, vec4<f32>(1.0)) * rise;
    let exists = chord_row(row + 14u) != vec4<u32>(NONE);
    return bits_of(exists & (room >= vec4<f32>(0.0)) & (max(near, far) + back >= vec4<f32>(0.0))
        & (min(near, far) - reach <= vec4<f32>(t_max)));
}
