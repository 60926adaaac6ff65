// Lookups in the tables and in prepared fibres. The program that includes this library defines two functions:
//   fn vellus_table(row: u32) -> vec4<f32>   reads the buffer of the tables,
//   fn vellus_row(row: u32) -> vec4<f32>     reads the buffer of the prepared fibres.

// Linear interpolation between the nodes `index` and `index` + 1.
struct VellusBetween {
    index: u32,
    t: f32,
}

// A position on nodes 0 ... nodes - 1, clamped to that range.
fn vellus_between(position: f32, nodes: u32) -> VellusBetween {
    let x = clamp(position, 0.0, f32(nodes - 1u));
    let index = min(u32(x), nodes - 2u);
    return VellusBetween(index, x - f32(index));
}

// A position in [0, 1] on an axis.
fn vellus_on(position: f32, nodes: u32) -> VellusBetween {
    return vellus_between(position * f32(nodes - 1u), nodes);
}

fn vellus_sum(v: vec4<f32>) -> f32 {
    return (v.x + v.y) + (v.z + v.w);
}

// One number of the tables.
fn vellus_number(part: u32, index: u32) -> f32 {
    return vellus_table(part + index / 4u)[index % 4u];
}

// A pair of numbers of the tables.
fn vellus_pair(part: u32, index: u32) -> vec2<f32> {
    let row = vellus_table(part + index / 2u);
    return select(row.xy, row.zw, index % 2u == 1u);
}

// Interpolates row `c` of nodes with `stride` rows each.
fn vellus_mixed(part: u32, at: VellusBetween, stride: u32, c: u32) -> vec4<f32> {
    let low = vellus_table(part + at.index * stride + c);
    let high = vellus_table(part + (at.index + 1u) * stride + c);
    return low + (high - low) * at.t;
}

// Row `k` of a prepared fibre.
fn vellus_fiber(fiber: u32, k: u32) -> vec4<f32> {
    return vellus_row(fiber * VELLUS_FIBER_ROWS + k);
}
