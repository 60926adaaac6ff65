// The scene in rows of four numbers, as vellus-render packs it. The accessors node_row, chord_row, triangle_row,
// point_row and data_row are generated, because a large array is split over several buffers.

// In place of a record: the strands have one for each control point.
const PER_POINT = 0xfffffffeu;
const LEAF = 0x80000000u;
const INFINITY = 3.0e38;

fn data_floats(row: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(data_row(row));
}

fn data_word(index: u32) -> u32 {
    return data_row(index / 4u)[index % 4u];
}

// The time of the path: the shutter opens at 0 and closes at 1.
var<private> path_time: f32;

// A row of an array at the time of the path, from its rows when the shutter opens and closes.
fn at_time(open: vec4<f32>, closed: vec4<f32>) -> vec4<f32> {
    return open * (1.0 - path_time) + closed * path_time;
}

fn node_at(row: u32) -> vec4<f32> {
    let open = bitcast<vec4<f32>>(node_row(row));
    if !HAS_MOTION {
        return open;
    }
    return at_time(open, bitcast<vec4<f32>>(node_row(row + data_row(CLOSED).x)));
}

fn chord_at(row: u32) -> vec4<f32> {
    let open = bitcast<vec4<f32>>(chord_row(row));
    if !HAS_MOTION {
        return open;
    }
    return at_time(open, bitcast<vec4<f32>>(chord_row(row + data_row(CLOSED).y)));
}

fn point_at(row: u32) -> vec4<f32> {
    if !HAS_MOTION {
        return point_row(row);
    }
    return at_time(point_row(row), point_row(row + data_row(CLOSED).w));
}

fn data_number(index: u32) -> f32 {
    return bitcast<f32>(data_word(index));
}

struct Ray {
    origin: vec3<f32>,
    t_max: f32,
    direction: vec3<f32>,
}

// What a ray hits: a segment with a parameter along it, or a triangle with barycentric coordinates.
struct Hit {
    t: f32,
    // 0: nothing. 1: a strand. 2: a mesh.
    kind: u32,
    // The first control point, or the leaf and lane of the triangle.
    index: u32,
    lane: u32,
    uv: vec2<f32>,
    // The instance, or NONE.
    instance: u32,
}

// A unit vector and two that complete it to a basis (Duff et al. 2017).
struct Basis {
    x: vec3<f32>,
    y: vec3<f32>,
}

fn basis_of(n: vec3<f32>) -> Basis {
    let s = select(1.0, -1.0, n.z < 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return Basis(vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3<f32>(b, s + n.y * n.y * a, -n.y));
}

fn largest(c: vec3<f32>) -> f32 {
    return max(c.x, max(c.y, c.z));
}

fn normalize_or(v: vec3<f32>, otherwise: vec3<f32>) -> vec3<f32> {
    let l = length(v);
    return select(otherwise, v / l, l > 1e-30);
}

// The power heuristic (Veach 1997). A negative density is infinite.
fn mis_weight(own: f32, other: f32) -> f32 {
    if own < 0.0 {
        return 1.0;
    }
    // Scaled, so that squares stay in range.
    let most = max(own, other);
    if most <= 0.0 {
        return 0.0;
    }
    let a = own / most;
    let b = other / most;
    return a * a / (a * a + b * b);
}
