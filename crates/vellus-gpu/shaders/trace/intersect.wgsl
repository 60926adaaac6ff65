// Rays in the hierarchies of vellus-render. A node has eight boxes, a leaf up to eight primitives.

// The inverse of a direction. A tiny number replaces 0, which avoids 0/0.
fn inverse_of(d: vec3<f32>) -> vec3<f32> {
    let tiny = select(vec3<f32>(1e-20), vec3<f32>(-1e-20), d < vec3<f32>(0.0));
    return 1.0 / select(d, tiny, abs(d) < vec3<f32>(1e-20));
}

// A bit for each component that is true.
fn bits_of(b: vec4<bool>) -> u32 {
    let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), b);
    return (bits.x | bits.y) | (bits.z | bits.w);
}

// The distances at which a ray enters four boxes of a node. Those that it misses are infinite.
fn enter_boxes(node: u32, half: u32, origin: vec3<f32>, inverse: vec3<f32>, t_max: f32) -> vec4<f32> {
    var enter = vec4<f32>(0.0);
    var leave = vec4<f32>(t_max);
    var empty = vec4<bool>(false);
    for (var k = 0u; k < 3u; k++) {
        let low = node_at(node * 14u + 2u * k + half);
        let high = node_at(node * 14u + 6u + 2u * k + half);
        empty = empty | (low > high);
        let a = (low - origin[k]) * inverse[k];
        let b = (high - origin[k]) * inverse[k];
        enter = max(enter, min(a, b));
        leave = min(leave, max(a, b));
    }
    // Allows for rounding errors of the slabs (Ize 2013).
    let hit = (enter <= leave * 1.000001) & !empty;
    return select(vec4<f32>(INFINITY), enter, hit);
}

// Nodes that wait, and their distances. The hierarchy of an object uses what that of the instances leaves. The packer
// refuses scenes that need more room.
var<private> stack_nodes: array<u32, STACK>;
var<private> stack_distances: array<f32, STACK>;

// A hierarchy while it is traversed: near children first. Its nodes are on the stack from `base` up to `size`.
struct Walk {
    base: u32,
    size: u32,
    current: u32,
}

// Goes to the next leaf with a box nearer than t_max. Returns NONE at the end.
fn next_leaf(walk: ptr<function, Walk>, origin: vec3<f32>, inverse: vec3<f32>, t_max: f32) -> u32 {
    loop {
        let current = (*walk).current;
        if current == NONE {
            var found = false;
            while (*walk).size > (*walk).base {
                (*walk).size -= 1u;
                if stack_distances[(*walk).size] <= t_max {
                    (*walk).current = stack_nodes[(*walk).size];
                    found = true;
                    break;
                }
            }
            if !found {
                break;
            }
            continue;
        }
        (*walk).current = NONE;
        if (current & LEAF) != 0u {
            return current & ~LEAF;
        }
        let near = enter_boxes(current, 0u, origin, inverse, t_max);
        let far = enter_boxes(current, 1u, origin, inverse, t_max);
        var mask = bits_of(near < vec4<f32>(INFINITY)) | (bits_of(far < vec4<f32>(INFINITY)) << 4u);
        var nearest = INFINITY;
        var chosen = NONE;
        let begin = (*walk).size;
        while mask != 0u {
            let lane = firstTrailingBit(mask);
            mask &= mask - 1u;
            var distance = select(far[lane & 3u], near[lane & 3u], lane < 4u);
            var child = node_row(current * 14u + 12u + lane / 4u)[lane & 3u];
            if distance < nearest {
                // The nearest child is visited next. The one before waits.
                let other = chosen;
                let before = nearest;
                chosen = child;
                nearest = distance;
                child = other;
                distance = before;
            }
            if child != NONE {
                // Insertion: the farthest child is at the bottom.
                var place = (*walk).size;
                while place > begin && stack_distances[place - 1u] < distance {
                    stack_distances[place] = stack_distances[place - 1u];
                    stack_nodes[place] = stack_nodes[place - 1u];
                    place -= 1u;
                }
                stack_distances[place] = distance;
                stack_nodes[place] = child;
                (*walk).size += 1u;
            }
        }
        (*walk).current = chosen;
    }
    return NONE;
}

// Tests the segments of a leaf against a ray, and shortens the ray to the nearest hit.
fn hit_segments(
    leaf: u32, basis: Basis, any: bool, casters: u32, ray: ptr<function, Ray>, hit: ptr<function, Hit>
) {
    let first = near_chords(leaf, 0u, *ray, basis, (*ray).t_max);
    var mask = first | (near_chords(leaf, 1u, *ray, basis, (*ray).t_max) << 4u);
    while mask != 0u {
        let lane = firstTrailingBit(mask);
        mask &= mask - 1u;
        let point = chord_row(leaf * 16u + 14u + lane / 4u)[lane & 3u];
        let margins = chord_row(leaf * 16u + 12u + lane / 4u)[lane & 3u];
        if HAS_LINKS && casters != NONE && data_word(casters + set_of(point)) == 0u {
            continue;
        }
        let entry = enter_segment(segment_of(point), margins, *ray);
        if entry.x > 0.0 {
            (*hit).t = entry.x;
            (*hit).kind = 1u;
            (*hit).index = point;
            (*hit).uv = vec2<f32>(entry.y, 0.0);
            (*ray).t_max = entry.x;
            if any {
                return;
            }
        }
    }
}

// A corner and two edges of four triangles.
struct Corners {
    corner: mat3x4<f32>,
    first: mat3x4<f32>,
    second: mat3x4<f32>,
}

fn triangle_part_of(row: u32) -> mat3x4<f32> {
    return mat3x4<f32>(
        bitcast<vec4<f32>>(triangle_row(row)),
        bitcast<vec4<f32>>(triangle_row(row + 2u)),
        bitcast<vec4<f32>>(triangle_row(row + 4u))
    );
}

fn triangle_part(leaf: u32, half: u32, part: u32) -> mat3x4<f32> {
    let row = leaf * 20u + 6u * part + half;
    let open = triangle_part_of(row);
    if !HAS_MOTION {
        return open;
    }
    let closed = triangle_part_of(row + data_row(CLOSED).z);
    return mat3x4<f32>(at_time(open[0], closed[0]), at_time(open[1], closed[1]), at_time(open[2], closed[2]));
}

// The edges of a triangle, and its corner, when the shutter opens or when it closes.
struct Corner {
    at: vec3<f32>,
    first: vec3<f32>,
    second: vec3<f32>,
}

fn corner_of(leaf: u32, lane: u32, closed: bool) -> Corner {
    let row = leaf * 20u + lane / 4u + select(0u, data_row(CLOSED).z, closed);
    let k = lane % 4u;
    let c = triangle_part_of(row);
    let e = triangle_part_of(row + 6u);
    let f = triangle_part_of(row + 12u);
    return Corner(
        vec3<f32>(c[0][k], c[1][k], c[2][k]), vec3<f32>(e[0][k], e[1][k], e[2][k]), vec3<f32>(f[0][k], f[1][k], f[2][k])
    );
}

// How far a point of a triangle moves while the shutter is open, in its own space.
fn triangle_movement(hit: Hit) -> vec3<f32> {
    let a = corner_of(hit.index, hit.lane, false);
    let b = corner_of(hit.index, hit.lane, true);
    return b.at - a.at + (b.first - a.first) * hit.uv.x + (b.second - a.second) * hit.uv.y;
}

// A normal that moves with its triangle. Its components along the edges and the plane's normal stay the same.
fn carried(n: vec3<f32>, hit: Hit, e: vec3<f32>, f: vec3<f32>) -> vec3<f32> {
    let open = corner_of(hit.index, hit.lane, false);
    let upright = normalize_or(cross(open.first, open.second), vec3<f32>(0.0));
    let m = normalize_or(cross(e, f), vec3<f32>(0.0));
    let sum = dot(open.first, n) * cross(f, m) + dot(open.second, n) * cross(m, e) + dot(upright, n) * cross(e, f);
    return sum / dot(e, cross(f, m));
}

// Whether a triangle lets a ray pass that meets it: because it casts no shadow in the light whose casters these are, or
// by the chance of its opacity, as in `details.rs` of vellus-render.
fn passes(triangle: u32, casters: u32, ray: Ray, at: vec2<f32>) -> bool {
    if !HAS_LINKS && !HAS_OPACITY {
        return false;
    }
    let number = mesh_of(triangle);
    if HAS_LINKS && casters != NONE && data_word(casters + data_row(SETS).x + number) == 0u {
        return true;
    }
    let mesh = data_row(data_row(SETS).w + number);
    let row = surface_row(mesh) + 3u;
    let opacity = data_row(row);
    if !HAS_OPACITY || (opacity.x == bitcast<u32>(1.0) && opacity.y == 0u && opacity.z == 0u) {
        return false;
    }
    var share = bitcast<f32>(opacity.x);
    if opacity.z != 0u {
        share *= texture_at(data_row(TEXTURES).x + opacity.z - 1u, mesh_uv(mesh, triangle - mesh.x, at)).x;
    }
    let threshold = bitcast<f32>(opacity.y);
    if threshold > 0.0 {
        return share < threshold;
    }
    // PCG (O'Neill 2014, as in Jarzynski and Olano 2020). The last word is the time of the ray.
    let words = array<u32, 8>(
        triangle, bitcast<u32>(ray.origin.x), bitcast<u32>(ray.origin.y), bitcast<u32>(ray.origin.z),
        bitcast<u32>(ray.direction.x), bitcast<u32>(ray.direction.y), bitcast<u32>(ray.direction.z),
        bitcast<u32>(path_time)
    );
    var bits = 0u;
    for (var k = 0u; k < 8u; k++) {
        let state = (bits ^ words[k]) * 747796405u + 2891336453u;
        let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
        bits = (word >> 22u) ^ word;
    }
    return share < 1.0 && f32(bits >> 8u) * (1.0 / 16777216.0) >= share;
}

// Tests the triangles of a leaf against a ray, and shortens the ray to the nearest hit.
fn hit_triangles(leaf: u32, casters: u32, ray: ptr<function, Ray>, hit: ptr<function, Hit>) {
    let d = (*ray).direction;
    let o = (*ray).origin;
    for (var half = 0u; half < 2u; half++) {
        let index = triangle_row(leaf * 20u + 18u + half);
        let corner = triangle_part(leaf, half, 0u);
        let e = triangle_part(leaf, half, 1u);
        let f = triangle_part(leaf, half, 2u);
        // Moeller and Trumbore 1997, for four triangles.
        let px = d.y * f[2] - d.z * f[1];
        let py = d.z * f[0] - d.x * f[2];
        let pz = d.x * f[1] - d.y * f[0];
        let determinant = e[0] * px + e[1] * py + e[2] * pz;
        let scale = 1.0 / select(determinant, vec4<f32>(1e-37), determinant == vec4<f32>(0.0));
        let sx = o.x - corner[0];
        let sy = o.y - corner[1];
        let sz = o.z - corner[2];
        let u = (sx * px + sy * py + sz * pz) * scale;
        let qx = sy * e[2] - sz * e[1];
        let qy = sz * e[0] - sx * e[2];
        let qz = sx * e[1] - sy * e[0];
        let v = (d.x * qx + d.y * qy + d.z * qz) * scale;
        let t = (f[0] * qx + f[1] * qy + f[2] * qz) * scale;
        let edge = vec4<f32>(-1e-6);
        let inside = (u >= edge) & (v >= edge) & (u + v <= vec4<f32>(1.000001))
            & (determinant != vec4<f32>(0.0)) & (t > vec4<f32>(0.0)) & (index != vec4<u32>(NONE));
        var mask = bits_of(inside);
        while mask != 0u {
            let lane = firstTrailingBit(mask);
            mask &= mask - 1u;
            let at = vec2<f32>(u[lane], v[lane]);
            if t[lane] < (*ray).t_max && !passes(index[lane], casters, *ray, at) {
                (*ray).t_max = t[lane];
                (*hit).t = t[lane];
                (*hit).kind = 2u;
                (*hit).index = leaf;
                (*hit).lane = 4u * half + lane;
                (*hit).uv = at;
            }
        }
    }
}

// The nearest hit in one object, nearer than the length of the ray. Its nodes are on the stack from `base` up.
fn hit_object(curves: u32, triangles: u32, ray_in: Ray, any: bool, casters: u32, base: u32) -> Hit {
    var hit: Hit;
    hit.t = ray_in.t_max;
    hit.instance = NONE;
    var ray = ray_in;
    let basis = basis_of(ray.direction);
    let inverse = inverse_of(ray.direction);
    // First the meshes, then the strands.
    var walk = Walk(base, base, triangles);
    var strands = false;
    loop {
        let leaf = next_leaf(&walk, ray.origin, inverse, ray.t_max);
        if leaf == NONE {
            if strands {
                break;
            }
            strands = true;
            walk.current = curves;
            continue;
        }
        if strands {
            hit_segments(leaf, basis, any, casters, &ray, &hit);
        } else if HAS_MESHES {
            hit_triangles(leaf, casters, &ray, &hit);
        }
        if any && hit.kind != 0u {
            break;
        }
    }
    return hit;
}

// Three rows of an affine transform.
fn transform_point(row: u32, p: vec3<f32>) -> vec3<f32> {
    let q = vec4<f32>(p, 1.0);
    return vec3<f32>(dot(data_floats(row), q), dot(data_floats(row + 1u), q), dot(data_floats(row + 2u), q));
}

fn transform_vector(row: u32, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        dot(data_floats(row).xyz, v), dot(data_floats(row + 1u).xyz, v), dot(data_floats(row + 2u).xyz, v)
    );
}

fn instance_row(instance: u32) -> u32 {
    return data_row(INSTANCES).x + 7u * instance;
}

// The nearest hit in the scene, or any hit. The objects in world space come first, then the instances on the way.
// `casters` is the first number of those that tell which things block the ray, or NONE if all do.
fn hit_scene(ray_in: Ray, any: bool, casters: u32) -> Hit {
    let roots = data_row(ROOTS);
    var ray = ray_in;
    var best: Hit;
    best.t = ray.t_max;
    best.instance = NONE;
    let inverse = inverse_of(ray.direction);
    var walk = Walk(0u, 0u, select(roots.z, NONE, roots.w == 0u));
    var instance = NONE;
    var objects = roots.xy;
    var inside = ray;
    var unit = 1.0;
    // The instances of the leaf that is being visited.
    var leaf = NONE;
    var lane = 8u;
    loop {
        var hit = hit_object(objects.x, objects.y, inside, any, casters, walk.size);
        if hit.kind != 0u {
            hit.t *= unit;
            hit.instance = instance;
            best = hit;
            ray.t_max = hit.t;
            if any {
                break;
            }
        }
        if !HAS_INSTANCES {
            break;
        }
        // The next instance.
        instance = NONE;
        while instance == NONE {
            if lane == 8u {
                leaf = next_leaf(&walk, ray.origin, inverse, ray.t_max);
                if leaf == NONE {
                    break;
                }
                lane = 0u;
            }
            instance = data_row(data_row(INSTANCES).y + 2u * leaf + lane / 4u)[lane % 4u];
            lane += 1u;
        }
        if instance == NONE {
            break;
        }
        let row = instance_row(instance);
        let local = transform_vector(row, ray.direction);
        unit = 1.0 / length(local);
        objects = data_row(row + 6u).xy;
        inside = Ray(transform_point(row, ray.origin), min(ray.t_max / unit, INFINITY), local * unit);
    }
    return best;
}

// What a path needs to know about a triangle that it hit.
struct Face {
    mesh: u32,
    plane: vec3<f32>,
    normal: vec3<f32>,
    uv: vec2<f32>,
}

// The mesh of a triangle.
fn mesh_of(triangle: u32) -> u32 {
    let sets = data_row(SETS);
    var low = 0u;
    var high = sets.z;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if data_row(sets.w + middle).x <= triangle {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

fn data_pair(index: u32) -> vec2<f32> {
    return vec2<f32>(data_number(index), data_number(index + 1u));
}

// The texture coordinates of a place of a triangle, from its barycentric coordinates.
fn mesh_uv(mesh: vec4<u32>, triangle: u32, at: vec2<f32>) -> vec2<f32> {
    if mesh.w == NONE {
        return at;
    }
    let row = mesh.w + 6u * triangle;
    return data_pair(row) * (1.0 - at.x - at.y) + data_pair(row + 2u) * at.x + data_pair(row + 4u) * at.y;
}

// A normal as the normal map of a mesh bends it, as in `triangles.rs` of vellus-render. Without a map, or where texture
// coordinates do not differ, it stays.
fn bent_normal(
    mesh: vec4<u32>, triangle: u32, first: vec3<f32>, second: vec3<f32>, uv: vec2<f32>, normal: vec3<f32>
) -> vec3<f32> {
    let row = surface_row(mesh) + 3u;
    let map = data_row(row).w;
    if map == 0u || mesh.w == NONE {
        return normal;
    }
    let corner = mesh.w + 6u * triangle;
    let ab = data_pair(corner + 2u) - data_pair(corner);
    let ac = data_pair(corner + 4u) - data_pair(corner);
    let up = select(1.0, -1.0, ab.x * ac.y - ab.y * ac.x < 0.0);
    let grows = normalize_or((first * ac.y - second * ab.y) * up, vec3<f32>(0.0));
    let right = normalize_or(grows - normal * dot(grows, normal), vec3<f32>(0.0));
    if dot(right, right) == 0.0 {
        return normal;
    }
    let texel = texture_at(data_row(TEXTURES).x + map - 1u, uv);
    let n = texel * data_floats(row + 1u).xyz + data_floats(row + 2u).xyz;
    return normalize_or(right * n.x + cross(normal, right) * (up * n.y) + normal * n.z, normal);
}

fn face_of(hit: Hit, ray: Ray) -> Face {
    let half = hit.lane / 4u;
    let lane = hit.lane % 4u;
    let index = triangle_row(hit.index * 20u + 18u + half)[lane];
    let e = triangle_part(hit.index, half, 1u);
    let f = triangle_part(hit.index, half, 2u);
    let first = vec3<f32>(e[0][lane], e[1][lane], e[2][lane]);
    let second = vec3<f32>(f[0][lane], f[1][lane], f[2][lane]);
    var direction = ray.direction;
    if hit.instance != NONE {
        direction = transform_vector(instance_row(hit.instance), direction);
    }
    var face: Face;
    face.mesh = mesh_of(index);
    let mesh = data_row(data_row(SETS).w + face.mesh);
    let triangle = index - mesh.x;
    let front = normalize_or(cross(first, second), vec3<f32>(0.0, 0.0, 1.0));
    var plane = select(front, -front, dot(front, direction) > 0.0);
    let w = 1.0 - hit.uv.x - hit.uv.y;
    face.uv = mesh_uv(mesh, triangle, hit.uv);
    var normal = front;
    if mesh.z != NONE {
        let row = mesh.z + 3u * triangle;
        var smooth_normal = data_floats(row).xyz * w + data_floats(row + 1u).xyz * hit.uv.x
            + data_floats(row + 2u).xyz * hit.uv.y;
        if HAS_MOTION {
            smooth_normal = carried(smooth_normal, hit, first, second);
        }
        normal = normalize_or(smooth_normal, plane);
    }
    if HAS_NORMAL_MAPS {
        normal = bent_normal(mesh, triangle, first, second, face.uv, normal);
    }
    normal = select(normal, -normal, dot(normal, plane) < 0.0);
    // At a silhouette, a shading normal may face away from the ray.
    normal = select(plane, normal, dot(normal, direction) < 0.0);
    if hit.instance != NONE {
        let row = instance_row(hit.instance) + 3u;
        plane = normalize(transform_vector(row, plane));
        normal = normalize(transform_vector(row, normal));
    }
    face.plane = plane;
    face.normal = normal;
    return face;
}
