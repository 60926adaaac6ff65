// The path of one sample, as in vellus_render's integrator, with one offset at every hit.

// Light that reaches the camera unless its shadow ray is blocked.
struct Waiting {
    ray: Ray,
    light: vec3<f32>,
    // The light.
    which: u32,
    // 1 if the light has its own shares of the lobes.
    apart: u32,
    lobes: array<vec3<f32>, LOBES>,
}

struct Path {
    // Where the values of the sample are.
    base: u32,
    pixel: vec2<u32>,
    // The numbers of the camera ray.
    u: vec4<f32>,
    // The number of scattering events so far.
    depth: u32,
    // 1 if there is a next ray.
    goes_on: u32,
    // Shadow rays that are not traced yet.
    shadows: u32,
    waiting: array<Waiting, 2>,
    throughput: vec3<f32>,
    // 1 if the light belongs to a fibre that the camera sees, and the share of each lobe in it.
    apart: u32,
    lobes: array<vec3<f32>, LOBES>,
    // The number of light samples at the last scattering event, and the class of the thing.
    lights: f32,
    class_id: u32,
    // The share of diffuse parts in the last scattering event.
    diffuse: vec3<f32>,
    // The next light that the ray may find behind things that cast no shadow in it.
    through: u32,
    rays: u32,
    cut: f32,
    removed: f32,
    // The next ray, and the density with which it was sampled.
    ray: Ray,
    pdf: f32,
    // The strand that the camera sees: its distance and its number, or 0.
    strand_t: f32,
    strand: u32,
    thing: u32,
}

// The first channel of a layer, or NONE.
fn layer(index: u32) -> u32 {
    return data_row(LAYERS + index / 4u)[index % 4u];
}

fn set_value(path: ptr<function, Path>, channel: u32, value: f32) {
    write_word((*path).base + channel, bitcast<u32>(value));
}

fn set_layer1(path: ptr<function, Path>, index: u32, value: f32) {
    let start = layer(index);
    if start != NONE {
        set_value(path, start, value);
    }
}

fn set_layer3(path: ptr<function, Path>, index: u32, value: vec3<f32>) {
    let start = layer(index);
    if start != NONE {
        set_value(path, start, value.x);
        set_value(path, start + 1u, value.y);
        set_value(path, start + 2u, value.z);
    }
}

fn add_value(path: ptr<function, Path>, channel: u32, value: f32) {
    let at = (*path).base + channel;
    write_word(at, bitcast<u32>(bitcast<f32>(read_word(at)) + value));
}

fn add3(path: ptr<function, Path>, channel: u32, value: vec3<f32>) {
    add_value(path, channel, value.x);
    add_value(path, channel + 1u, value.y);
    add_value(path, channel + 2u, value.z);
}

// Adds light of a light group. It reached the camera after `events` scattering events.
fn add_light(path: ptr<function, Path>, unlimited: vec3<f32>, group: u32, events: u32) {
    var light = unlimited;
    let limit = bitcast<f32>(data_row(OUTPUT).x);
    if limit > 0.0 && events > 1u && largest(light) > limit {
        light *= limit / largest(light);
        (*path).removed += (unlimited.x - light.x) + (unlimited.y - light.y) + (unlimited.z - light.z);
    }
    add3(path, 0u, light);
    let groups = layer(LAYER_LIGHTS);
    if groups != NONE {
        add3(path, groups + 3u * group, light);
    }
    if HAS_LOBES && (*path).apart != 0u {
        for (var p = 0u; p < LOBES; p++) {
            add3(path, layer(LAYER_LOBES) + 3u * p, light * (*path).lobes[p]);
        }
    }
}

// A part over a whole; 0 where the whole is 0.
fn shares_of(part: vec3<f32>, whole: vec3<f32>) -> vec3<f32> {
    return select(part / whole, vec3<f32>(0.0), whole <= vec3<f32>(0.0));
}

fn set_shares(path: ptr<function, Path>, lobes_in: VellusLobes, total: vec3<f32>) {
    var lobes = lobes_in;
    for (var p = 0u; p < LOBES; p++) {
        (*path).lobes[p] = shares_of(lobes.rgb[p], total);
    }
}

// The light of an emitter that a ray hit, as it reaches the camera.
fn light_found(path: ptr<function, Path>, light: u32, emission: Emission, events: u32) -> vec3<f32> {
    var w = 1.0;
    var radiance = emission.radiance;
    if events > 0u {
        w = mis_weight((*path).pdf, emission.pdf * light_share((*path).class_id, light) * (*path).lights);
        if HAS_GAINS {
            let gains = gains_of(light);
            radiance *= gains.y + (gains.x - gains.y) * (*path).diffuse;
        }
    }
    return (*path).throughput * radiance * w;
}

// Adds light later, if its shadow ray is not blocked.
fn wait_for(path: ptr<function, Path>, ray: Ray, light: vec3<f32>, which: u32) {
    let k = (*path).shadows;
    (*path).waiting[k].ray = ray;
    (*path).waiting[k].light = light;
    (*path).waiting[k].which = which;
    if HAS_LOBES {
        (*path).waiting[k].apart = (*path).apart;
        (*path).waiting[k].lobes = (*path).lobes;
    }
    (*path).shadows = k + 1u;
}

// The light of each lobe of a fibre toward a direction, with the gains of a light.
fn gained(lobes_in: VellusLobes, gains: vec2<f32>) -> VellusLobes {
    var lobes = lobes_in;
    for (var p = 0u; p < 6u; p++) {
        lobes.rgb[p] *= select(gains.y, gains.x, p == 3u || p == 4u);
    }
    return lobes;
}

fn sum_of(lobes_in: VellusLobes) -> vec3<f32> {
    var lobes = lobes_in;
    var sum = vec3<f32>(0.0);
    for (var p = 0u; p < 6u; p++) {
        sum += lobes.rgb[p];
    }
    return sum;
}

// The frame of a fibre at a hit, and what belongs to the strand.
struct Place {
    tangent: vec3<f32>,
    across: Basis,
    center: vec3<f32>,
    radius: f32,
    strands: u32,
    strand: u32,
}

fn place_of(hit: Hit) -> Place {
    let s = segment_of(hit.index);
    var point = segment_at(s, hit.uv.x);
    var place: Place;
    place.tangent = segment_tangent(s, hit.uv.x);
    place.center = point.xyz;
    place.radius = point.w;
    if hit.instance != NONE {
        let row = instance_row(hit.instance);
        place.center = transform_point(row + 3u, point.xyz);
        place.tangent = normalize(transform_vector(row + 3u, place.tangent));
        place.radius = point.w * bitcast<f32>(data_row(row + 6u).w);
    }
    place.across = basis_of(place.tangent);
    place.strands = set_of(hit.index);
    let rows = data_row(SETS).y + 2u * place.strands;
    // The strand of a control point: the last one that starts at it or before.
    let index = hit.index - data_row(rows).x;
    let starts = data_row(rows + 1u);
    var low = 0u;
    var high = starts.y;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if data_word(starts.x + middle) <= index {
            low = middle;
        } else {
            high = middle;
        }
    }
    place.strand = low;
    return place;
}

fn to_fiber(place: Place, w: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(w, place.tangent), dot(w, place.across.x), dot(w, place.across.y));
}

// A ray that leaves toward a direction, from the side of the fibre that faces it.
fn leave_fiber(place: Place, direction: vec3<f32>, t_max: f32) -> Ray {
    let out = normalize_or(direction - place.tangent * dot(direction, place.tangent), place.across.x);
    return Ray(place.center + out * (BESIDE * place.radius), t_max, direction);
}

// The fibre's record. Where parameters vary along the strand, it is that of one of the two control points around the
// hit, drawn with the weights of linear interpolation.
fn record_of(place: Place, hit: Hit, sampler: ptr<function, Sampler>) -> u32 {
    let row = data_row(data_row(SETS).y + 2u * place.strands);
    if row.z == NONE {
        return data_word(row.w + place.strand);
    }
    if row.z != PER_POINT {
        return row.z;
    }
    var ends = vec2<u32>(1u, 2u);
    if row.y == 0u {
        ends = vec2<u32>(0u, 1u);
    } else if row.y == 1u {
        ends = vec2<u32>(0u, 3u);
    }
    // Another number than that of Russian roulette.
    (*sampler).count++;
    let end = select(ends.x, ends.y, chance(sampler) < hit.uv.x);
    return data_word(row.w + hit.index - row.x + end);
}

// Sets how far a point moves in the picture while the shutter is open, in pixels to the right and up. `movement` is its
// movement in the world.
fn set_motion(path: ptr<function, Path>, now: vec3<f32>, movement: vec3<f32>) {
    let start = layer(LAYER_MOTION);
    if start == NONE {
        return;
    }
    let open = place_seen(now - movement * path_time, 0.0);
    let closed = place_seen(now + movement * (1.0 - path_time), 1.0);
    if open.z < 0.0 && closed.z < 0.0 {
        set_value(path, start, closed.x - open.x);
        set_value(path, start + 1u, open.y - closed.y);
    }
}

// How far the point of a strand moves while the shutter is open, in the world.
fn strand_movement(hit: Hit) -> vec3<f32> {
    let time = path_time;
    path_time = 0.0;
    let open = segment_at(segment_of(hit.index), hit.uv.x).xyz;
    path_time = 1.0;
    let closed = segment_at(segment_of(hit.index), hit.uv.x).xyz;
    path_time = time;
    if hit.instance == NONE {
        return closed - open;
    }
    return transform_vector(instance_row(hit.instance) + 3u, closed - open);
}

// In place of an offset: the whole width, if there are tables of the far field.
const WHOLE_WIDTH = 2.0;

// The offset at which a fibre scatters: that of the hit, or one by chance within the window of the mode, as in
// `window.rs` of vellus-render.
fn shown_offset(
    path: ptr<function, Path>, sampler: ptr<function, Sampler>, ray: Ray, t: f32, radius: f32, h: f32
) -> f32 {
    if MODE == NEAR {
        return h;
    }
    let u = next4(sampler);
    let any = select(2.0 * u.x - 1.0, WHOLE_WIDTH, HAS_TABLES);
    if MODE == FAR {
        return any;
    }
    if (*path).depth > 0u {
        // The angle over which a direction with this density spreads.
        let spread = sqrt(3.0 / (VELLUS_PI * (*path).pdf));
        let wide = spread * t >= 2.0 * radius && largest((*path).throughput) >= FAINT;
        return select(h, any, wide);
    }
    let frame = frame_at(path_time);
    let pixel = t * -dot(ray.direction, frame.z) * data_floats(CAMERA_X).w / f32(data_row(SIZE).y);
    let width = CELL * min(pixel / max(radius, 1e-30), 4.0);
    if width >= 2.0 {
        return any;
    }
    let low = width * (floor((h + 1.0) / width - u.y) + u.y) - 1.0;
    let ends = clamp(vec2<f32>(low, low + width), vec2<f32>(-1.0), vec2<f32>(1.0));
    return mix(ends.x, ends.y, u.x);
}

// Adds the light that reaches a fibre, and samples the next ray. Returns false if the path ends.
fn at_fiber(path: ptr<function, Path>, sampler: ptr<function, Sampler>, ray: Ray, hit: Hit, depth: u32) -> bool {
    let place = place_of(hit);
    let position = ray.origin + ray.direction * hit.t;
    let out = position - place.center;
    let n = normalize_or(out - place.tangent * dot(out, place.tangent), place.across.x);
    let back = -ray.direction;
    let toward = normalize_or(back - place.tangent * dot(back, place.tangent), n);
    let seen = clamp(dot(place.tangent, cross(n, toward)), -1.0, 1.0);
    let h = shown_offset(path, sampler, ray, hit.t, place.radius, seen);
    let rows = data_row(SETS).y + 2u * place.strands;
    var fiber: VellusHit;
    fiber_hit(&fiber, record_of(place, hit, sampler), to_fiber(place, back), h);
    if depth == 0u {
        set_layer3(path, LAYER_TANGENT, place.tangent);
        set_layer3(path, LAYER_NORMAL, normalize_or(out, vec3<f32>(0.0)));
        set_layer1(path, LAYER_FIBERS, 1.0);
        if HAS_MOTION {
            set_motion(path, place.center, strand_movement(hit));
        }
        let numbers = data_row(rows + 1u);
        let start = layer(LAYER_ROOT_UV);
        if start != NONE && numbers.w != NONE {
            let uv = data_pair(numbers.w + 2u * place.strand);
            set_value(path, start, uv.x);
            set_value(path, start + 1u, uv.y);
        }
        var before = 0u;
        if hit.instance != NONE {
            before = data_row(instance_row(hit.instance) + 6u).z;
        }
        (*path).strand_t = hit.t;
        (*path).strand = before + numbers.z + place.strand + 1u;
        if layer(LAYER_ALBEDO) != NONE {
            set_layer3(path, LAYER_ALBEDO, sum_of(vellus_energy(&fiber)));
        }
    }
    let apart = HAS_LOBES && depth == 0u;
    (*path).class_id = class_of(place.strands);
    let a = next4(sampler);
    let b = next4(sampler);
    let count = select(1u, FIRST_LIGHTS, depth == 0u);
    (*path).lights = f32(count);
    for (var k = 0u; k < count; k++) {
        var u = a;
        if k > 0u {
            u = next4(sampler);
        }
        // Each sample has its own part of the numbers.
        let s = sample_light((*path).class_id, place.center, vec3<f32>((u.x + f32(k)) / (*path).lights, u.yz));
        if s.light == NONE {
            continue;
        }
        let local = to_fiber(place, s.direction);
        let value = fiber_eval(&fiber, local);
        var total = value.xyz;
        if HAS_GAINS {
            total = sum_of(gained(fiber_lobes(&fiber, local), gains_of(s.light)));
        }
        var w = 1.0 / (*path).lights;
        if s.pdf > 0.0 {
            w = mis_weight(s.pdf * (*path).lights, value.w) / (*path).lights;
        }
        let threshold = select(THRESHOLD_LATER, THRESHOLD_FIRST, depth == 0u);
        let asked = min(4.0 * VELLUS_PI / threshold * (*path).lights * largest(total) * w, 1.0);
        let drawn = chance(sampler);
        if drawn >= asked {
            continue;
        }
        let given = select(1.0 / s.pdf, 1.0, s.pdf < 0.0);
        if apart {
            (*path).apart = 1u;
            var gains = vec2<f32>(1.0);
            if HAS_GAINS {
                gains = gains_of(s.light);
            }
            set_shares(path, gained(fiber_lobes(&fiber, local), gains), total);
        }
        let light = (*path).throughput * total * s.radiance * (w * given / asked);
        let shadow = leave_fiber(place, s.direction, s.distance * BEFORE);
        wait_for(path, shadow, light, s.light);
    }
    let drawn = fiber_sample(&fiber, b);
    if drawn.pdf <= 0.0 || largest(drawn.weight) <= 0.0 {
        return false;
    }
    if apart {
        (*path).apart = 1u;
        set_shares(path, fiber_lobes(&fiber, drawn.wi), drawn.weight * drawn.pdf);
    }
    if HAS_GAINS {
        let lobes = fiber_lobes(&fiber, drawn.wi);
        (*path).diffuse = shares_of(sum_of(gained(lobes, vec2<f32>(1.0, 0.0))), sum_of(lobes));
    }
    (*path).throughput *= drawn.weight;
    let direction = place.tangent * drawn.wi.x + place.across.x * drawn.wi.y + place.across.y * drawn.wi.z;
    (*path).ray = leave_fiber(place, direction, INFINITY);
    (*path).pdf = drawn.pdf;
    return true;
}

// Adds the light that a mesh emits and that reaches it, and samples the next ray. Returns false if the path ends.
fn at_surface(path: ptr<function, Path>, sampler: ptr<function, Sampler>, ray: Ray, hit: Hit, depth: u32) -> bool {
    let face = face_of(hit, ray);
    let s = scatter_of(face);
    if largest(s.emission) > 0.0 {
        add_light(path, (*path).throughput * s.emission, data_row(TEXTURES).w, depth);
    }
    let basis = basis_of(face.normal);
    let point = ray.origin + ray.direction * hit.t;
    // Moves the origin off the plane by a few rounding errors of the largest coordinate.
    let start = point + face.plane * (2e-5 * max(largest(abs(point)), hit.t * 0.1));
    let wo = vec3<f32>(dot(-ray.direction, basis.x), dot(-ray.direction, basis.y), dot(-ray.direction, face.normal));
    let a = next4(sampler);
    let b = next4(sampler);
    if depth == 0u {
        set_layer3(path, LAYER_NORMAL, face.normal);
        if HAS_MOTION {
            var movement = triangle_movement(hit);
            if hit.instance != NONE {
                movement = transform_vector(instance_row(hit.instance) + 3u, movement);
            }
            set_motion(path, point, movement);
        }
    }
    (*path).lights = 1.0;
    (*path).class_id = class_of(data_row(SETS).x + face.mesh);
    let l = sample_light((*path).class_id, start, a.xyz);
    if l.light != NONE {
        let wi = vec3<f32>(dot(l.direction, basis.x), dot(l.direction, basis.y), dot(l.direction, face.normal));
        let value = scatter_eval(s, wo, wi);
        var f = value.base + value.coat;
        if HAS_GAINS {
            let gains = gains_of(l.light);
            f = value.base * gains.x + value.coat * gains.y;
        }
        if largest(f) > 0.0 && dot(l.direction, face.plane) > 0.0 {
            var w = 1.0;
            if l.pdf > 0.0 {
                w = mis_weight(l.pdf, value.pdf) / l.pdf;
            }
            let light = (*path).throughput * f * l.radiance * w;
            wait_for(path, Ray(start, l.distance * BEFORE, l.direction), light, l.light);
        }
    }
    if wo.z <= 0.0 {
        return false;
    }
    let wi = scatter_sample(s, wo, b.xyz);
    let value = scatter_eval(s, wo, wi);
    if value.pdf <= 0.0 {
        return false;
    }
    let f = (value.base + value.coat) / value.pdf;
    (*path).diffuse = shares_of(value.base, value.base + value.coat);
    let direction = basis.x * wi.x + basis.y * wi.y + face.normal * wi.z;
    if depth == 0u {
        set_layer3(path, LAYER_ALBEDO, min(f, vec3<f32>(1.0)));
    }
    if dot(direction, face.plane) <= 0.0 {
        return false;
    }
    (*path).throughput *= f;
    (*path).ray = Ray(start, INFINITY, direction);
    (*path).pdf = value.pdf;
    return true;
}

// The offset of a sample from the middle of its pixel, in pixels.
fn filter_offset(u: f32, tent: bool) -> f32 {
    if !tent {
        return u - 0.5;
    }
    if u < 0.5 {
        return sqrt(2.0 * u) - 1.0;
    }
    return 1.0 - sqrt(2.0 - 2.0 * u);
}

// The place of a sample in the picture, in pixels from the upper left corner.
fn film_place(pixel: vec2<u32>, u: vec4<f32>) -> vec2<f32> {
    let tent = data_row(CAMERA_ORIGIN).w == 1u;
    return vec2<f32>(pixel) + 0.5 + vec2<f32>(filter_offset(u.x, tent), filter_offset(u.y, tent));
}

// The axes of the camera and its origin.
struct Frame {
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
    origin: vec3<f32>,
}

fn frame_at(time: f32) -> Frame {
    let frame = Frame(
        data_floats(CAMERA_X).xyz, data_floats(CAMERA_Y).xyz, data_floats(CAMERA_Z).xyz, data_floats(CAMERA_ORIGIN).xyz
    );
    if !HAS_MOTION {
        return frame;
    }
    let turn = data_floats(CAMERA_TURN);
    let by = vellus_sin_cos(turn.w * time);
    return Frame(
        turned(frame.x, turn.xyz, by), turned(frame.y, turn.xyz, by), turned(frame.z, turn.xyz, by),
        frame.origin + data_floats(CAMERA_MOVE).xyz * time
    );
}

// A vector, turned about an axis. `by` are the sine and the cosine of the angle.
fn turned(v: vec3<f32>, axis: vec3<f32>, by: vec2<f32>) -> vec3<f32> {
    return v * by.y + cross(axis, v) * by.x + axis * (dot(axis, v) * (1.0 - by.y));
}

// Where the camera sees a point: pixels from the upper left corner, and the place along its third axis, which is
// negative in front of it.
fn place_seen(point: vec3<f32>, time: f32) -> vec3<f32> {
    let frame = frame_at(time);
    let from_eye = point - frame.origin;
    let p = vec3<f32>(dot(from_eye, frame.x), dot(from_eye, frame.y), dot(from_eye, frame.z));
    let size = vec2<f32>(data_row(SIZE).xy);
    let on_film = p.xy / -p.z - data_floats(SHIFT).xy;
    let pixels = size.y / data_floats(CAMERA_X).w;
    return vec3<f32>(0.5 * size + vec2<f32>(on_film.x, -on_film.y) * pixels, p.z);
}

fn camera_ray(pixel: vec2<u32>, u: vec4<f32>) -> Ray {
    let frame = frame_at(path_time);
    let size = vec2<f32>(data_row(SIZE).xy);
    let place = film_place(pixel, u) / size - 0.5;
    let lens = concentric(u.zw) * data_floats(CAMERA_Z).w;
    let film = vec2<f32>(place.x * size.x / size.y, -place.y) * data_floats(CAMERA_X).w + data_floats(SHIFT).xy;
    let focus = vec3<f32>(film, -1.0) * data_floats(CAMERA_Y).w;
    let d = focus - vec3<f32>(lens, 0.0);
    let direction = normalize(frame.x * d.x + frame.y * d.y + frame.z * d.z);
    let origin = frame.origin + frame.x * lens.x + frame.y * lens.y;
    return Ray(origin, INFINITY, direction);
}

// What the camera sees behind all objects.
fn background(pixel: vec2<u32>, u: vec4<f32>) -> vec3<f32> {
    let color = data_floats(BACKGROUND).xyz;
    let texture = data_row(TEXTURES).y;
    if !HAS_TEXTURES || texture == 0u {
        return color;
    }
    let row = data_row(TEXTURES).x + texture - 1u;
    let size = vec2<f32>(data_row(SIZE).xy);
    let image = vec2<f32>(data_row(row).xy);
    let ratio = (size.x * image.y) / (size.y * image.x);
    let shown = select(vec2<f32>(ratio, 1.0), vec2<f32>(1.0, 1.0 / ratio), ratio > 1.0);
    let place = film_place(pixel, u) / size;
    return color * texture_at(row, (vec2<f32>(place.x, 1.0 - place.y) - 0.5) * shown + 0.5);
}

// Begins a sample.
fn begin_path(path: ptr<function, Path>, sampler: ptr<function, Sampler>, k: u32) {
    let output = data_row(OUTPUT);
    let base = k * output.z;
    for (var word = 0u; word < output.z; word++) {
        write_word(base + word, 0u);
    }
    // The number of the pixel in the area, and the index of the sample.
    let sample = work[k];
    let width = data_row(AREA).x;
    let pixel = data_row(SIZE).zw + vec2<u32>(sample.x % width, sample.x / width);
    *sampler = new_sampler(pixel, sample.y, data_row(AREA).z);
    let u = next4(sampler);
    if HAS_MOTION {
        path_time = next4(sampler).x;
    }
    (*path).base = base;
    (*path).pixel = pixel;
    (*path).u = u;
    (*path).depth = 0u;
    (*path).goes_on = 1u;
    (*path).shadows = 0u;
    (*path).throughput = vec3<f32>(1.0);
    (*path).apart = 0u;
    (*path).lights = 1.0;
    (*path).class_id = 0u;
    (*path).through = NONE;
    (*path).rays = 0u;
    (*path).cut = 0.0;
    (*path).removed = 0.0;
    (*path).ray = camera_ray(pixel, u);
    (*path).strand = 0u;
    (*path).thing = NONE;
}

// Whether a ray may find a light by hitting it. `through` is for rays that pass what casts no shadow in the light.
fn may_find(path: ptr<function, Path>, light: u32, through: bool) -> bool {
    if (*path).depth == 0u {
        return data_row(light_row(light)).z != 0u;
    }
    if !HAS_LINKS {
        return true;
    }
    return (finding((*path).class_id, light) & select(1u, 2u, through)) != 0u;
}

// The nearest light with a shape that a ray finds within its length, and its index, or NONE.
struct Nearest {
    light: u32,
    emission: Emission,
}

fn nearest_light(path: ptr<function, Path>, ray: Ray, through: bool) -> Nearest {
    var best = Nearest(NONE, Emission(ray.t_max, vec3<f32>(0.0), 0.0));
    for (var k = 0u; k < data_row(LIGHTS).x; k++) {
        if !may_find(path, k, through) {
            continue;
        }
        let found = meet_light(light_row(k), Ray(ray.origin, best.emission.t, ray.direction));
        if found.t > 0.0 {
            best = Nearest(k, found);
        }
    }
    if best.light != NONE {
        best.emission.radiance *= shaping(light_row(best.light), -ray.direction);
    }
    return best;
}

// Lets the next light wait that the ray may find behind things that cast no shadow in it.
fn find_through(path: ptr<function, Path>) {
    let ray = (*path).ray;
    let nearest = nearest_light(path, ray, true);
    while (*path).through != NONE {
        let k = (*path).through;
        (*path).through = select(NONE, k + 1u, k + 1u < data_row(LIGHTS).x);
        if casters_of(k) == NONE || !may_find(path, k, true) {
            continue;
        }
        var found = nearest.emission;
        if nearest.light == NONE {
            found = escape_light(light_row(k), ray, false);
        } else if nearest.light != k {
            continue;
        }
        if found.pdf >= 0.0 {
            let light = light_found(path, k, found, (*path).depth);
            wait_for(path, Ray(ray.origin, found.t * BEFORE, ray.direction), light, k);
            return;
        }
    }
}

// Adds what a ray finds of the lights. Returns whether the path ends there.
fn meets_light(path: ptr<function, Path>, ray: Ray, hit: Hit) -> bool {
    let camera = (*path).depth == 0u;
    let nearest = nearest_light(path, Ray(ray.origin, hit.t, ray.direction), false);
    if nearest.light != NONE {
        let light = light_found(path, nearest.light, nearest.emission, (*path).depth);
        add_light(path, light, data_row(light_row(nearest.light)).w, (*path).depth);
        return true;
    }
    if hit.kind != 0u {
        return false;
    }
    if camera && data_row(OUTPUT).w == 1u {
        add_light(path, background((*path).pixel, (*path).u), data_row(TEXTURES).z, 0u);
        return true;
    }
    for (var k = 0u; k < data_row(LIGHTS).x; k++) {
        let row = light_row(k);
        if !may_find(path, k, false) {
            continue;
        }
        let found = escape_light(row, ray, camera);
        if found.pdf >= 0.0 {
            add_light(path, light_found(path, k, found, (*path).depth), data_row(row).w, (*path).depth);
        }
    }
    return true;
}

// Adds the light of the last shadow ray, if nothing blocks it.
fn end_shadow(path: ptr<function, Path>, hit: Hit) {
    let k = (*path).shadows - 1u;
    (*path).shadows = k;
    if hit.kind != 0u {
        return;
    }
    let light = (*path).waiting[k].light;
    let group = data_row(light_row((*path).waiting[k].which)).w;
    // The scattering event has been counted.
    if !HAS_LOBES {
        add_light(path, light, group, (*path).depth);
        return;
    }
    let was = (*path).apart;
    var kept = (*path).lobes;
    (*path).apart = (*path).waiting[k].apart;
    (*path).lobes = (*path).waiting[k].lobes;
    add_light(path, light, group, (*path).depth);
    (*path).apart = was;
    (*path).lobes = kept;
}

// What a path does where it hits something or leaves the scene. `on_strand`: its ray hits a strand.
fn scatter_event(
    path: ptr<function, Path>, sampler: ptr<function, Sampler>, ray: Ray, hit: Hit, on_strand: bool
) {
    let depth = (*path).depth;
    (*path).goes_on = 0u;
    if meets_light(path, ray, hit) {
        return;
    }
    if depth == 0u {
        set_layer1(path, LAYER_ALPHA, 1.0);
        set_layer1(path, LAYER_DEPTH, hit.t);
        if on_strand {
            (*path).thing = set_of(hit.index);
        } else if HAS_MESHES {
            (*path).thing = data_row(SETS).x + face_of(hit, ray).mesh;
        }
    }
    let most = data_row(AREA).w;
    if most != NONE && depth >= most {
        (*path).cut = largest((*path).throughput);
        return;
    }
    if on_strand {
        (*path).goes_on = u32(at_fiber(path, sampler, ray, hit, depth));
    } else if HAS_MESHES {
        (*path).goes_on = u32(at_surface(path, sampler, ray, hit, depth));
    }
    (*path).depth = depth + 1u;
    if (*path).goes_on != 0u && depth >= ROULETTE {
        let survive = min(sqrt(SURVIVAL * largest((*path).throughput)), 1.0);
        (*path).goes_on = u32(next4(sampler).x < survive);
        (*path).throughput /= survive;
    }
    // A throughput that is not a number ends the path too.
    (*path).goes_on *= u32(largest((*path).throughput) > 0.0);
    if HAS_LINKS && (*path).goes_on != 0u {
        (*path).through = 0u;
    }
}

fn end_path(path: ptr<function, Path>) {
    let extra = (*path).base + data_row(OUTPUT).y;
    write_word(extra, bitcast<u32>((*path).strand_t));
    write_word(extra + 1u, (*path).strand);
    write_word(extra + 2u, (*path).thing);
    write_word(extra + 3u, (*path).rays);
    write_word(extra + 4u, bitcast<u32>((*path).cut));
    write_word(extra + 5u, bitcast<u32>((*path).removed));
}
