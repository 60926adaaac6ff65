// How meshes scatter: a diffuse base under a rough dielectric coat (GGX), or rough metal. Textures.

// The index of a pixel of an infinite row, or -1 for black. From 4 on, `wrap` is 3 more than the number of tiles.
fn wrapped(i: i32, count: i32, wrap: u32) -> i32 {
    switch wrap {
        case 0u: {
            return ((i % count) + count) % count;
        }
        case 1u: {
            return clamp(i, 0, count - 1);
        }
        case 2u: {
            let k = ((i % (2 * count)) + 2 * count) % (2 * count);
            return min(k, 2 * count - 1 - k);
        }
        case 3u: {
            return select(-1, i, i >= 0 && i < count);
        }
        default: {
            return clamp(i, 0, count - 1);
        }
    }
}

// A coordinate near the image.
fn near_image(x: f32, wrap: u32) -> f32 {
    switch wrap {
        case 0u: {
            return x - floor(x);
        }
        case 2u: {
            return x - 2.0 * floor(0.5 * x);
        }
        default: {
            return clamp(x, -1.0, 2.0);
        }
    }
}

// The position among `count` pixels of an image of tiles, in pixels from the centre of the first. It is between the
// centres of the pixels of one tile.
fn in_tile(x: f32, tiles: u32, count: u32) -> f32 {
    let tile = clamp(floor(x), 0.0, f32(tiles - 1u));
    let size = f32(count / tiles);
    return tile * size + clamp((x - tile) * size - 0.5, 0.0, size - 1.0);
}

fn texel(image: vec4<u32>, column: i32, row: i32) -> vec3<f32> {
    let x = wrapped(column, i32(image.x), image.w & 0xffffu);
    let y = wrapped(row, i32(image.y), image.w >> 16u);
    if x < 0 || y < 0 {
        return vec3<f32>(0.0);
    }
    return data_floats(image.z + u32(y) * image.x + u32(x)).xyz;
}

// A texture with bilinear interpolation. `row` has its size, first pixel and continuation.
fn texture_at(row: u32, uv: vec2<f32>) -> vec3<f32> {
    let image = data_row(row);
    let across = image.w & 0xffffu;
    let along = image.w >> 16u;
    var x = near_image(uv.x, across) * f32(image.x) - 0.5;
    var y = (1.0 - near_image(uv.y, along)) * f32(image.y) - 0.5;
    if across > 3u {
        x = in_tile(uv.x, across - 3u, image.x);
        y = f32(image.y) - 1.0 - in_tile(uv.y, along - 3u, image.y);
    }
    let x0 = floor(x);
    let y0 = floor(y);
    let s = x - x0;
    let t = y - y0;
    let column = i32(x0);
    let line = i32(y0);
    var sum = vec3<f32>(0.0);
    // A loop: compilers insert each call as a copy of the code.
    for (var k = 0; k < 4; k++) {
        let right = k % 2;
        let down = k / 2;
        let weight = select(1.0 - s, s, right == 1) * select(1.0 - t, t, down == 1);
        sum += texel(image, column + right, line + down) * weight;
    }
    return sum;
}

struct Scatter {
    color: vec3<f32>,
    // Reflectance at normal incidence.
    specular: vec3<f32>,
    // The weight of the base.
    diffuse: f32,
    alpha: f32,
    has_coat: bool,
    emission: vec3<f32>,
}

// The first row of the surface of a mesh.
fn surface_row(mesh: vec4<u32>) -> u32 {
    return data_row(LIGHTS).w + ROWS_OF_SURFACE * mesh.y;
}

fn scatter_of(face: Face) -> Scatter {
    let row = surface_row(data_row(data_row(SETS).w + face.mesh));
    let tint = data_row(row);
    var color = bitcast<vec3<f32>>(tint.xyz);
    if HAS_TEXTURES && tint.w != 0u {
        color *= texture_at(data_row(TEXTURES).x + tint.w - 1u, face.uv);
    }
    let rest = data_floats(row + 1u);
    var s: Scatter;
    s.color = clamp(color, vec3<f32>(0.0), vec3<f32>(1.0));
    let r = (rest.z - 1.0) / (rest.z + 1.0);
    s.specular = vec3<f32>(r * r) + (s.color - r * r) * rest.y;
    s.diffuse = 1.0 - rest.y;
    s.alpha = max(rest.x * rest.x, 1e-3);
    s.has_coat = largest(s.specular) > 0.0;
    s.emission = data_floats(row + 2u).xyz;
    return s;
}

fn schlick(s: Scatter, cosine: f32) -> vec3<f32> {
    if !s.has_coat {
        return vec3<f32>(0.0);
    }
    return s.specular + (1.0 - s.specular) * schlick_power(cosine);
}

fn schlick_power(cosine: f32) -> f32 {
    let m = 1.0 - clamp(cosine, 0.0, 1.0);
    let m2 = m * m;
    return m2 * m2 * m;
}

// (1 - F(theta_o)) (1 - F(theta_i)) / (1 - F_mean): see `surface.rs` of vellus-render.
fn through_coat(s: Scatter, cos_o: f32, cos_i: f32) -> vec3<f32> {
    if !s.has_coat {
        return vec3<f32>(1.0);
    }
    return (1.0 - s.specular) * ((1.0 - schlick_power(cos_o)) * (1.0 - schlick_power(cos_i)) * 1.05);
}

fn mean3(c: vec3<f32>) -> f32 {
    return (c.x + c.y + c.z) / 3.0;
}

// The probability of sampling the coat.
fn coat_share(s: Scatter, cos_o: f32) -> f32 {
    let coat = mean3(schlick(s, cos_o));
    let base = (1.0 - coat) * s.diffuse * mean3(s.color);
    return select(clamp(coat / (coat + base), 0.1, 1.0), 0.0, coat <= 0.0);
}

fn smith_lambda(s: Scatter, w: vec3<f32>) -> f32 {
    let tan2 = (w.x * w.x + w.y * w.y) / max(w.z * w.z, 1e-12);
    return 0.5 * (sqrt(1.0 + s.alpha * s.alpha * tan2) - 1.0);
}

// f cos of the base and of the coat, and the density.
struct Scattered {
    base: vec3<f32>,
    coat: vec3<f32>,
    pdf: f32,
}

fn scatter_eval(s: Scatter, wo: vec3<f32>, wi: vec3<f32>) -> Scattered {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return Scattered(vec3<f32>(0.0), vec3<f32>(0.0), 0.0);
    }
    let share = coat_share(s, wo.z);
    let base = wi.z / VELLUS_PI;
    let f = s.diffuse * s.color * through_coat(s, wo.z, wi.z) * base;
    var coat = vec3<f32>(0.0);
    var pdf = (1.0 - share) * base;
    if share > 0.0 {
        let m = normalize_or(wo + wi, vec3<f32>(0.0, 0.0, 1.0));
        let a2 = s.alpha * s.alpha;
        let t = (m.x * m.x + m.y * m.y) / a2 + m.z * m.z;
        let d = 1.0 / (VELLUS_PI * a2 * t * t);
        let lo = smith_lambda(s, wo);
        coat = schlick(s, dot(m, wo)) * (d / (1.0 + lo + smith_lambda(s, wi)) / (4.0 * wo.z));
        pdf += share * d / (1.0 + lo) / (4.0 * wo.z);
    }
    return Scattered(f, coat, pdf);
}

// A point of the unit disk (Shirley and Chiu 1997).
fn concentric(u: vec2<f32>) -> vec2<f32> {
    let a = 2.0 * u.x - 1.0;
    let b = 2.0 * u.y - 1.0;
    if a == 0.0 && b == 0.0 {
        return vec2<f32>(0.0);
    }
    var r = b;
    var phi = 0.5 * VELLUS_PI - 0.25 * VELLUS_PI * a / b;
    if abs(a) > abs(b) {
        r = a;
        phi = 0.25 * VELLUS_PI * b / a;
    }
    return r * vellus_sin_cos(phi).yx;
}

// A direction. It is below the surface if nothing was sampled.
fn scatter_sample(s: Scatter, wo: vec3<f32>, u: vec3<f32>) -> vec3<f32> {
    let disk = concentric(u.xy);
    if u.z >= coat_share(s, wo.z) {
        return vec3<f32>(disk, sqrt(max(1.0 - dot(disk, disk), 0.0)));
    }
    // A visible normal (Heitz 2018).
    let a = s.alpha;
    let v = normalize(vec3<f32>(a * wo.x, a * wo.y, wo.z));
    let across = v.x * v.x + v.y * v.y;
    let t1 = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(-v.y, v.x, 0.0) / sqrt(max(across, 1e-37)), across > 0.0);
    let t2 = cross(v, t1);
    let q = 0.5 * (1.0 + v.z);
    let y = (1.0 - q) * sqrt(max(1.0 - disk.x * disk.x, 0.0)) + q * disk.y;
    let n = t1 * disk.x + t2 * y + v * sqrt(max(1.0 - disk.x * disk.x - y * y, 0.0));
    let m = normalize(vec3<f32>(a * n.x, a * n.y, max(n.z, 1e-6)));
    return m * (2.0 * dot(wo, m)) - wo;
}
