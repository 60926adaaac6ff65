// Lights: sampling, and what a ray finds.

// A sampled direction toward a light. The density is negative where it is infinite. `light` is NONE if there is none.
struct LightSample {
    light: u32,
    direction: vec3<f32>,
    distance: f32,
    radiance: vec3<f32>,
    pdf: f32,
}

// What a ray finds.
struct Emission {
    t: f32,
    radiance: vec3<f32>,
    pdf: f32,
}

fn light_row(light: u32) -> u32 {
    return data_row(LIGHTS).y + ROWS_OF_LIGHT * light;
}

// The first number of what reaches the things of a class.
fn reaching(class_id: u32) -> u32 {
    return data_row(LIGHTS).z + class_id * (3u * data_row(LIGHTS).x + 1u);
}

// The probability of a light.
fn light_share(class_id: u32, light: u32) -> f32 {
    return data_number(reaching(class_id) + light);
}

// Bit 0: whether a ray that a thing of a class scattered may find a light by hitting it. Bit 1: whether the light
// reaches the thing.
fn finding(class_id: u32, light: u32) -> u32 {
    return data_word(reaching(class_id) + 2u * data_row(LIGHTS).x + 1u + light);
}

// The class of a thing: the same lights reach all things of a class.
fn class_of(thing: u32) -> u32 {
    if !HAS_LINKS {
        return 0u;
    }
    return data_word(data_row(LINKS).x + thing);
}

// The first number of the things that cast shadows in a light, or NONE if all do.
fn casters_of(light: u32) -> u32 {
    return data_row(light_row(light)).y;
}

// The gains of a light, for light that diffuse and specular parts scatter.
fn gains_of(light: u32) -> vec2<f32> {
    let row = light_row(light);
    return vec2<f32>(data_floats(row + 9u).w, data_floats(row + 10u).w);
}

fn cone_pdf(cosine: f32) -> f32 {
    return 1.0 / (VELLUS_TAU * max(1.0 - cosine, 1e-12));
}

fn uniform_cone(axis: vec3<f32>, cos_max: f32, u: vec2<f32>) -> vec3<f32> {
    let c = 1.0 - u.x * (1.0 - cos_max);
    let s = sqrt(max(1.0 - c * c, 0.0));
    let turn = vellus_sin_cos(VELLUS_TAU * (u.y - 0.5));
    let basis = basis_of(axis);
    return normalize(basis.x * (s * turn.y) + basis.y * (s * turn.x) + axis * c);
}

// The interval of a piecewise-constant distribution with `count` intervals, and the position in it.
struct Pick {
    index: u32,
    t: f32,
}

fn pick(sums: u32, count: u32, u: f32) -> Pick {
    var low = 0u;
    var high = count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if data_number(sums + middle) <= u {
            low = middle;
        } else {
            high = middle;
        }
    }
    let begin = data_number(sums + low);
    let width = data_number(sums + low + 1u) - begin;
    return Pick(low, select(0.5, clamp((u - begin) / width, 0.0, 0.99999994), width > 0.0));
}

fn interval(sums: u32, index: u32) -> f32 {
    return data_number(sums + index + 1u) - data_number(sums + index);
}

// The angle and 1 - cos of the edges of a row of a sky: the cosine of the upper edge minus that of the lower edge.
fn band(y: u32, height: u32) -> f32 {
    // cos a - cos b = 2 sin((a + b)/2) sin((b - a)/2)
    let half = 0.5 * VELLUS_PI / f32(height);
    return 2.0 * vellus_sin_cos((2.0 * f32(y) + 1.0) * half).x * vellus_sin_cos(half).x;
}

// The density of a place in a sky.
fn sky_pdf(map: vec4<u32>, uv: vec2<f32>) -> f32 {
    let image = data_row(map.x);
    let x = min(u32((uv.x - floor(uv.x)) * f32(image.x)), image.x - 1u);
    let y = min(u32(max(1.0 - uv.y, 0.0) * f32(image.y)), image.y - 1u);
    let share = interval(map.y, y) * interval(map.z + y * (image.x + 1u), x);
    return share * f32(image.x) / (VELLUS_TAU * band(y, image.y));
}

fn sky_uv(d: vec3<f32>) -> vec2<f32> {
    return vec2<f32>(
        0.5 + vellus_atan2(d.x, -d.z) / VELLUS_TAU, 1.0 - vellus_atan2(length(d.xz), d.y) / VELLUS_PI
    );
}

fn sky_direction(uv: vec2<f32>) -> vec3<f32> {
    let theta = vellus_sin_cos((1.0 - uv.y) * VELLUS_PI);
    let turn = vellus_sin_cos((uv.x - 0.5) * VELLUS_TAU);
    return vec3<f32>(theta.x * turn.x, theta.y, -theta.x * turn.y);
}

fn rotation_of(row: u32) -> mat3x3<f32> {
    return mat3x3<f32>(data_floats(row + 2u).xyz, data_floats(row + 3u).xyz, data_floats(row + 4u).xyz);
}

// The factor of a shaping, for a direction away from the light.
fn shaping(row: u32, direction: vec3<f32>) -> vec3<f32> {
    if !HAS_SHAPING || data_row(row + 1u).w == 0u {
        return vec3<f32>(1.0);
    }
    let axis = data_floats(row + 7u);
    let edges = data_floats(row + 8u);
    let c = clamp(dot(direction, axis.xyz), -1.0, 1.0);
    if c < axis.w {
        return vec3<f32>(0.0);
    }
    let angle = vellus_atan2(sqrt(max((1.0 - c) * (1.0 + c), 0.0)), c);
    if angle > edges.y {
        return vec3<f32>(0.0);
    }
    let start = (1.0 - edges.z) * edges.y;
    let edge = select((angle - start) / max(edges.y - start, 1e-20), 0.0, angle <= start);
    let focus = select(pow(max(abs(c), 1e-20), edges.w), 1.0, edges.w == 0.0);
    let cone = 1.0 - edge * edge * (3.0 - 2.0 * edge);
    let factor = (focus + (1.0 - focus) * data_floats(row + 9u).xyz) * cone;
    let image = data_row(row + 8u).x;
    if !HAS_PROFILES || image == NONE {
        return factor;
    }
    // The place in the image of a profile: rows go away from the axis, columns around it.
    let size = vec2<f32>(data_row(image).xy);
    let side = data_floats(row + 10u).xyz;
    let x = normalize(side - axis.xyz * dot(side, axis.xyz));
    let around = vellus_atan2(dot(direction, cross(x, axis.xyz)), dot(direction, x)) / VELLUS_TAU;
    let down = (angle / VELLUS_PI * (size.y - 1.0) + 0.5) / size.y;
    return factor * texture_at(image, vec2<f32>(around + 0.5 / size.x, 1.0 - down)).x;
}

// The image of a lamp. It stays half a texel inside, because it must not repeat.
fn lamp_texture(row: u32, a: f32, b: f32) -> vec3<f32> {
    let image = data_row(row + 6u).x;
    if !HAS_LAMP_IMAGES || image == NONE {
        return vec3<f32>(1.0);
    }
    let size = vec2<f32>(data_row(image).xy);
    let uv = clamp(0.5 * vec2<f32>(a, b) + 0.5, 0.5 / size, 1.0 - 0.5 / size);
    return texture_at(image, uv);
}

// The cosine of the half angle that a sphere subtends, or 2 from inside.
fn sphere_cos(to: vec3<f32>, radius: f32) -> f32 {
    let sin2 = radius * radius / dot(to, to);
    return select(2.0, sqrt(max(1.0 - sin2, 0.0)), sin2 < 1.0);
}

// The distance at which a ray enters a sphere, or -1.
fn sphere_entry(origin: vec3<f32>, direction: vec3<f32>, center: vec3<f32>, radius: f32) -> f32 {
    let to = center - origin;
    let along = dot(to, direction);
    let off = to - direction * along;
    let off2 = dot(off, off);
    let t = along - sqrt(max(radius * radius - off2, 0.0));
    return select(-1.0, t, off2 <= radius * radius && t > 0.0);
}

// The view of an infinite cylinder from a point: the direction from the axis, and half of the angle that it subtends in
// w. The angle is negative from inside.
fn seen_across(position: vec3<f32>, axis: vec3<f32>, radius: f32) -> vec4<f32> {
    let off = position - axis * dot(position, axis);
    let distance = length(off);
    if distance <= radius {
        return vec4<f32>(0.0, 0.0, 0.0, -1.0);
    }
    let s = radius / distance;
    return vec4<f32>(off / distance, vellus_atan2(s, sqrt(max((1.0 - s) * (1.0 + s), 0.0))));
}

// A direction from a point toward one light, before its probability and shaping.
fn sample_shape(row: u32, point: vec3<f32>, u: vec2<f32>) -> LightSample {
    let kind = data_row(row).x;
    var s: LightSample;
    s.light = 0u;
    s.distance = INFINITY;
    s.radiance = data_floats(row + 1u).xyz;
    let place = data_floats(row + 2u);
    if HAS_DOME && kind == DOME {
        let map = data_row(row + 5u);
        if !HAS_SKY_IMAGES || map.x == NONE {
            s.light = NONE;
            return s;
        }
        let image = data_row(map.x);
        let line = pick(map.y, image.y, u.y);
        let column = pick(map.z + line.index * (image.x + 1u), image.x, u.x);
        // Uniform in the cosine.
        let upper = vellus_sin_cos(f32(line.index) / f32(image.y) * VELLUS_PI).y;
        let c = clamp(upper - line.t * band(line.index, image.y), -1.0, 1.0);
        let theta = vellus_atan2(sqrt(max((1.0 - c) * (1.0 + c), 0.0)), c);
        let uv = vec2<f32>((f32(column.index) + column.t) / f32(image.x), 1.0 - theta / VELLUS_PI);
        s.direction = rotation_of(row) * sky_direction(uv);
        s.radiance *= texture_at(map.x, uv);
        s.pdf = sky_pdf(map, uv);
    } else if HAS_DISTANT && kind == DISTANT {
        s.direction = place.xyz;
        s.pdf = -1.0;
        if place.w > 0.0 {
            let c = data_floats(row + 3u).x;
            s.direction = uniform_cone(place.xyz, c, u);
            s.pdf = cone_pdf(c);
        }
    } else if HAS_FLAT && kind == FLAT {
        let x = data_floats(row + 3u);
        let y = data_floats(row + 4u).xyz;
        let normal = data_floats(row + 5u).xyz;
        let at = select(2.0 * u - 1.0, concentric(u), x.w > 0.0);
        let to = place.xyz + x.xyz * at.x + y * at.y - point;
        s.distance = length(to);
        s.direction = to / max(s.distance, 1e-30);
        let c = -dot(s.direction, normal);
        if c <= 0.0 || s.distance <= 0.0 {
            s.light = NONE;
            return s;
        }
        s.radiance *= lamp_texture(row, at.x, at.y);
        s.pdf = s.distance * s.distance / (c * place.w);
    } else if HAS_POINT && kind == POINT {
        let to = place.xyz - point;
        s.distance = length(to);
        s.direction = to / max(s.distance, 1e-30);
        s.radiance /= max(s.distance * s.distance, 1e-30);
        s.pdf = -1.0;
        s.light = select(NONE, 0u, s.distance > 0.0);
    } else if HAS_SPHERE && kind == SPHERE {
        let to = place.xyz - point;
        let c = sphere_cos(to, place.w);
        if c > 1.0 {
            s.light = NONE;
            return s;
        }
        s.direction = uniform_cone(normalize(to), c, u);
        let t = sphere_entry(point, s.direction, place.xyz, place.w);
        s.distance = select(dot(to, s.direction), t, t > 0.0);
        s.pdf = cone_pdf(c);
    } else if HAS_CYLINDER {
        // Uniform in the angle perpendicular to the axis, and in the length along it.
        let axis = data_floats(row + 3u);
        let origin = point - place.xyz;
        let seen = seen_across(origin, axis.xyz, place.w);
        if seen.w < 0.0 {
            s.light = NONE;
            return s;
        }
        let off = origin - axis.xyz * dot(origin, axis.xyz);
        let distance = length(off);
        let turn = vellus_sin_cos((2.0 * u.x - 1.0) * seen.w);
        let shift = distance * turn.x;
        let across = distance * turn.y - sqrt(max(place.w * place.w - shift * shift, 0.0));
        let along = (2.0 * u.y - 1.0) * axis.w - dot(origin, axis.xyz);
        let to = cross(axis.xyz, seen.xyz) * (turn.x * across) - seen.xyz * (turn.y * across) + axis.xyz * along;
        s.distance = length(to);
        s.direction = to / max(s.distance, 1e-30);
        s.pdf = s.distance * s.distance * s.distance / (across * across * 4.0 * seen.w * axis.w);
        s.light = select(NONE, 0u, across > 0.0);
    }
    return s;
}

// Samples a light and a direction from a point toward it, for a thing of a class.
fn sample_light(class_id: u32, point: vec3<f32>, u: vec3<f32>) -> LightSample {
    let lights = data_row(LIGHTS);
    var s: LightSample;
    s.light = NONE;
    if lights.x == 0u {
        return s;
    }
    let chosen = pick(reaching(class_id) + lights.x, lights.x, u.z).index;
    let row = light_row(chosen);
    let share = light_share(class_id, chosen);
    if share <= 0.0 {
        return s;
    }
    s = sample_shape(row, point, u.xy);
    let factor = shaping(row, -s.direction);
    if s.light == NONE || all(factor <= vec3(0.0)) || s.pdf == 0.0 {
        s.light = NONE;
        return s;
    }
    s.light = chosen;
    s.radiance *= factor;
    if s.pdf < 0.0 {
        s.radiance /= share;
    } else {
        s.pdf *= share;
    }
    return s;
}

// What a ray finds of one light with a shape. The distance is negative if it finds nothing.
fn meet_light(row: u32, ray: Ray) -> Emission {
    let kind = data_row(row).x;
    let place = data_floats(row + 2u);
    var found = Emission(-1.0, data_floats(row + 1u).xyz, 0.0);
    if HAS_FLAT && kind == FLAT {
        let x = data_floats(row + 3u);
        let y = data_floats(row + 4u).xyz;
        let normal = data_floats(row + 5u).xyz;
        let c = -dot(ray.direction, normal);
        if c <= 0.0 {
            return found;
        }
        let t = dot(ray.origin - place.xyz, normal) / c;
        if t <= 0.0 || t >= ray.t_max {
            return found;
        }
        // Coordinates in a frame that may be oblique.
        let p = ray.origin + ray.direction * t - place.xyz;
        let xx = dot(x.xyz, x.xyz);
        let xy = dot(x.xyz, y);
        let yy = dot(y, y);
        let determinant = xx * yy - xy * xy;
        let a = (dot(p, x.xyz) * yy - dot(p, y) * xy) / determinant;
        let b = (dot(p, y) * xx - dot(p, x.xyz) * xy) / determinant;
        let inside = select(abs(a) <= 1.0 && abs(b) <= 1.0, a * a + b * b <= 1.0, x.w > 0.0);
        if inside {
            found.t = t;
            found.radiance *= lamp_texture(row, a, b);
            found.pdf = t * t / (c * place.w);
        }
    } else if HAS_SPHERE && kind == SPHERE {
        let t = sphere_entry(ray.origin, ray.direction, place.xyz, place.w);
        let c = sphere_cos(place.xyz - ray.origin, place.w);
        if t > 0.0 && t < ray.t_max && c <= 1.0 {
            found.t = t;
            found.pdf = cone_pdf(c);
        }
    } else if HAS_CYLINDER && kind == CYLINDER {
        let axis = data_floats(row + 3u);
        let origin = ray.origin - place.xyz;
        let seen = seen_across(origin, axis.xyz, place.w);
        if seen.w < 0.0 {
            return found;
        }
        let off = origin - axis.xyz * dot(origin, axis.xyz);
        let across = ray.direction - axis.xyz * dot(ray.direction, axis.xyz);
        let sin2 = dot(across, across);
        if sin2 <= 0.0 {
            return found;
        }
        let nearest = -dot(off, across) / sin2;
        let closest = off + across * nearest;
        let depth2 = place.w * place.w - dot(closest, closest);
        if depth2 < 0.0 {
            return found;
        }
        let t = nearest - sqrt(depth2 / sin2);
        let along = dot(origin + ray.direction * t, axis.xyz);
        if t > 0.0 && t < ray.t_max && abs(along) <= axis.w {
            found.t = t;
            found.pdf = t / (sin2 * 4.0 * seen.w * axis.w);
        }
    }
    return found;
}

// The direction in a dome's image that a camera ray sees, with the image projected onto a disk of ground.
fn from_ground(row: u32, ray: Ray) -> vec3<f32> {
    let radius = data_floats(row + 2u).w;
    if radius <= 0.0 {
        return ray.direction;
    }
    let ground = data_floats(row + 6u);
    let up = data_floats(row + 3u).xyz;
    let taken = ground.xyz + up * ground.w;
    let origin = ray.origin - taken;
    let radius2 = radius * radius + ground.w * ground.w;
    let above = dot(ray.origin - ground.xyz, up);
    if dot(origin, origin) >= radius2 || above <= 0.0 {
        return ray.direction;
    }
    let sinks = -dot(ray.direction, up);
    if sinks > 0.0 {
        let seen = ray.origin + ray.direction * (above / sinks);
        if dot(seen - ground.xyz, seen - ground.xyz) <= radius * radius {
            return seen - taken;
        }
    }
    let along = dot(origin, ray.direction);
    return origin + ray.direction * (sqrt(along * along - dot(origin, origin) + radius2) - along);
}

// What a ray that leaves the scene finds of one light. The density is negative if it finds nothing.
fn escape_light(row: u32, ray: Ray, camera: bool) -> Emission {
    let kind = data_row(row).x;
    var found = Emission(INFINITY, data_floats(row + 1u).xyz, -1.0);
    if HAS_DOME && kind == DOME {
        found.pdf = 0.0;
        let map = data_row(row + 5u);
        if HAS_SKY_IMAGES && map.x != NONE {
            var seen = ray.direction;
            if camera {
                seen = from_ground(row, ray);
            }
            let uv = sky_uv(transpose(rotation_of(row)) * seen);
            found.radiance *= texture_at(map.x, uv);
            found.pdf = sky_pdf(map, uv);
        }
    } else if HAS_DISTANT && kind == DISTANT {
        let place = data_floats(row + 2u);
        let c = data_floats(row + 3u).x;
        if place.w > 0.0 && dot(ray.direction, place.xyz) >= c {
            found.pdf = cone_pdf(c);
        }
    }
    return found;
}
