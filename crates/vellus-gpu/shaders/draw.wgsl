// Draws directions of scattered light. Sampling from the tables is exact: it chooses a component of the mixture, and
// inverts its cumulative integral.

// A chosen component, and a new uniform number.
struct VellusChoice {
    component: u32,
    u: f32,
}

// The rows of products from which a component is chosen.
const VELLUS_CHOOSE_BACKWARD = 0u;
const VELLUS_CHOOSE_FORWARD = 1u;
const VELLUS_CHOOSE_AZIMUTH = 2u;
const VELLUS_CHOOSE_AZIMUTH_BACK = 3u;
const VELLUS_CHOOSE_AZIMUTH_AHEAD = 4u;

fn vellus_product(hit: ptr<function, VellusHit>, kind: u32, c: u32) -> vec4<f32> {
    if kind == VELLUS_CHOOSE_BACKWARD {
        return (*hit).backward[c] * vellus_fiber((*hit).fiber, VELLUS_BACKWARD_INTEGRALS + c);
    } else if kind == VELLUS_CHOOSE_FORWARD {
        return (*hit).forward[c] * vellus_forward_integral((*hit).fiber, (*hit).theta, c);
    } else if kind == VELLUS_CHOOSE_AZIMUTH {
        return (*hit).azimuth[c];
    }
    let ahead = vellus_table(VELLUS_AZIMUTH_AHEAD + c);
    return (*hit).azimuth[c] * select(ahead, 1.0 - ahead, kind == VELLUS_CHOOSE_AZIMUTH_BACK);
}

// Chooses a component in proportion to its product. One without weight is never chosen.
fn vellus_choose(hit: ptr<function, VellusHit>, kind: u32, rows: u32, u: f32) -> VellusChoice {
    var total = 0.0;
    for (var c = 0u; c < rows; c++) {
        total += vellus_sum(vellus_product(hit, kind, c));
    }
    var rest = u * total;
    var chosen = VellusChoice(0u, 0.5);
    for (var c = 0u; c < rows; c++) {
        let product = vellus_product(hit, kind, c);
        for (var i = 0u; i < 4u; i++) {
            let weight = product[i];
            if weight > 0.0 {
                chosen = VellusChoice(4u * c + i, clamp(rest / weight, 0.0, 1.0));
                if rest < weight {
                    return chosen;
                }
            }
            rest -= weight;
        }
    }
    return chosen;
}

// A position, the cumulative integral up to it, and the density there.
struct VellusPlace {
    x: f32,
    sum: f32,
    density: f32,
}

// Inverts the cumulative integral between two places. The density is linear between them.
fn vellus_invert(a: VellusPlace, b: VellusPlace, target_sum: f32, u: f32) -> f32 {
    let t = select(u, clamp((target_sum - a.sum) / (b.sum - a.sum), 0.0, 1.0), b.sum > a.sum);
    // The root of the quadratic integral, in the form without cancellation.
    let root = sqrt(max(a.density * a.density + t * (b.density * b.density - a.density * a.density), 0.0));
    let x = select(t, t * (a.density + b.density) / (a.density + root), a.density + root > 0.0);
    return a.x + clamp(x, 0.0, 1.0) * (b.x - a.x);
}

// The share of the forward half of C^M at an azimuth in [0, 2 pi] from straight back.
fn vellus_ahead(phi: f32) -> f32 {
    return max(1.0 - abs(phi / VELLUS_PI - 1.0), 0.0);
}

// A node of component `r` of C^N, under the weight of the whole circle (0), of the backward half (1) or of the forward
// half (2).
fn vellus_azimuth_place(r: u32, j: u32, half: u32) -> VellusPlace {
    let x = VELLUS_AZIMUTH_FIRST + f32(j) * VELLUS_AZIMUTH_STEP;
    let sums = vellus_pair(VELLUS_AZIMUTH_COLUMNS, r * VELLUS_AZIMUTH_VALUES_NODES + j);
    let density = vellus_table(VELLUS_AZIMUTH_VALUES + 10u * j + r / 4u)[r % 4u];
    if half == 0u {
        return VellusPlace(x, sums.x, density);
    } else if half == 1u {
        return VellusPlace(x, sums.x - sums.y, density * (1.0 - vellus_ahead(x)));
    }
    return VellusPlace(x, sums.y, density * vellus_ahead(x));
}

fn vellus_azimuth_sum(r: u32, j: u32, half: u32) -> f32 {
    let sums = vellus_pair(VELLUS_AZIMUTH_COLUMNS, r * VELLUS_AZIMUTH_VALUES_NODES + j);
    return select(select(sums.y, sums.x - sums.y, half == 1u), sums.x, half == 0u);
}

// Inverts component `r` of C^N.
fn vellus_invert_azimuth(r: u32, u: f32, half: u32) -> f32 {
    let last = VELLUS_AZIMUTH_VALUES_NODES - 1u;
    let target_sum = u * vellus_azimuth_sum(r, last, half);
    var a = 0u;
    var size = VELLUS_AZIMUTH_VALUES_NODES;
    while size > 1u {
        let step = size / 2u;
        a = select(a, a + step, vellus_azimuth_sum(r, a + step, half) <= target_sum);
        size -= step;
    }
    a = min(a, last - 1u);
    return vellus_invert(vellus_azimuth_place(r, a, half), vellus_azimuth_place(r, a + 1u, half), target_sum, u);
}

// Draws an azimuth from straight back, of which the share `turned` is mirrored.
fn vellus_draw_azimuth(hit: ptr<function, VellusHit>, r: u32, u: f32, half: u32) -> f32 {
    let turned = (*hit).turned;
    if u < turned {
        return -vellus_invert_azimuth(r, u / turned, half);
    }
    return vellus_invert_azimuth(r, (u - turned) / (1.0 - turned), half);
}

// One half of C^M, for the inversion of its components.
struct VellusHalf {
    forward: bool,
    // The angle around which light leaves, and its sine and cosine.
    shift: f32,
    turn: vec2<f32>,
    // Half the range of angles inside the fibre.
    reach: f32,
    // The density that remains at the ends of the range, and the loss of the cuticle relative to sin^4 inside.
    edge: f32,
    quartic: f32,
    // The factors of the six columns.
    a: vec4<f32>,
    b: vec2<f32>,
    first: f32,
    step: f32,
    nodes: u32,
}

fn vellus_half(hit: ptr<function, VellusHit>, forward: bool) -> VellusHalf {
    var half: VellusHalf;
    half.forward = forward;
    half.shift = select(0.0, (*hit).theta, forward);
    half.turn = vellus_sin_cos(half.shift);
    half.reach = 0.5 * VELLUS_PI;
    let cone = vellus_fiber((*hit).fiber, VELLUS_CONE);
    if vellus_fiber((*hit).fiber, VELLUS_CORTEX).w > 0.0 {
        let eta = vellus_fiber((*hit).fiber, VELLUS_OPTICS).x;
        half.reach = cone.y;
        half.edge = vellus_fiber((*hit).fiber, VELLUS_CONE_POSITION).z;
        half.quartic = cone.x * (eta * eta) * (eta * eta);
    }
    // sin^4 cos is (2 cos - 3 cos of three times + cos of five times the angle)/16.
    let part = half.quartic / 16.0;
    let s = half.turn.x;
    let c = half.turn.y;
    let double = vec2<f32>(2.0 * s * c, (c - s) * (c + s));
    let triple = vec2<f32>(s * double.y + c * double.x, c * double.y - s * double.x);
    let five = vec2<f32>(triple.x * double.y + triple.y * double.x, triple.y * double.y - triple.x * double.x);
    half.a = vec4<f32>((1.0 - 2.0 * part) * half.turn.yx, 3.0 * part * triple.yx);
    half.b = -part * five.yx;
    half.first = select(VELLUS_BACKWARD_FIRST, VELLUS_FORWARD_FIRST, forward);
    half.step = select(VELLUS_BACKWARD_STEP, VELLUS_FORWARD_STEP, forward);
    half.nodes = select(VELLUS_BACKWARD_VALUES_NODES, VELLUS_FORWARD_VALUES_NODES, forward);
    return half;
}

// The value of component `r` at a node.
fn vellus_half_value(half: VellusHalf, r: u32, j: u32) -> f32 {
    if half.forward {
        return vellus_table(VELLUS_FORWARD_VALUES + 8u * j + r / 4u)[r % 4u];
    }
    return vellus_table(VELLUS_BACKWARD_VALUES + 4u * j + r / 4u)[r % 4u];
}

// The cumulative integral of component `r` up to a node, under the weight of light that leaves.
fn vellus_half_sum(half: VellusHalf, r: u32, j: u32) -> f32 {
    let part = select(VELLUS_BACKWARD_CONE_COLUMNS, VELLUS_FORWARD_CONE_COLUMNS, half.forward);
    // Six numbers, a row and a half.
    let index = r * half.nodes + j;
    let row = part + 3u * index / 2u;
    let low = vellus_table(row);
    let high = vellus_table(row + 1u);
    let is_odd = index % 2u == 1u;
    let first = select(low, vec4<f32>(low.zw, high.xy), is_odd);
    return dot(half.a, first) + dot(half.b, select(high.xy, high.zw, is_odd));
}

// The weight of light that leaves at a node.
fn vellus_half_weight(half: VellusHalf, j: u32) -> f32 {
    let turn = vellus_pair(select(VELLUS_BACKWARD_TURNS, VELLUS_FORWARD_TURNS, half.forward), j);
    let s = turn.x * half.turn.y - turn.y * half.turn.x;
    let c = turn.y * half.turn.y + turn.x * half.turn.x;
    let square = s * s;
    return max(c * (1.0 - half.quartic * square * square), 0.0);
}

fn vellus_half_place(half: VellusHalf, r: u32, j: u32) -> VellusPlace {
    let density = vellus_half_value(half, r, j) * vellus_half_weight(half, j);
    return VellusPlace(half.first + f32(j) * half.step, vellus_half_sum(half, r, j), density);
}

// An end of the range, next to the node of `inner`.
fn vellus_half_end(half: VellusHalf, r: u32, x: f32, inner: VellusPlace) -> VellusPlace {
    let at = vellus_between((x - half.first) / half.step, half.nodes);
    let value = mix(vellus_half_value(half, r, at.index), vellus_half_value(half, r, at.index + 1u), at.t);
    let density = value * half.edge;
    return VellusPlace(x, inner.sum + 0.5 * (inner.density + density) * (x - inner.x), density);
}

// Inverts component `r` of one half of C^M: the inclination inside the fibre, relative to that of the entry.
fn vellus_invert_half(half: VellusHalf, r: u32, u: f32) -> f32 {
    let last = half.first + f32(half.nodes - 1u) * half.step;
    let low = clamp(half.shift - half.reach, half.first, last);
    let high = clamp(half.shift + half.reach, half.first, last);
    let start_node = min(u32(ceil((low - half.first) / half.step)), half.nodes - 1u);
    let stop_node = min(u32((high - half.first) / half.step), half.nodes - 1u);
    let start = vellus_half_end(half, r, low, vellus_half_place(half, r, start_node));
    let stop = vellus_half_end(half, r, high, vellus_half_place(half, r, stop_node));
    let target_sum = start.sum + u * (stop.sum - start.sum);
    var a = start_node;
    var size = stop_node + 1u - start_node;
    while size > 1u {
        let step = size / 2u;
        a = select(a, a + step, vellus_half_sum(half, r, a + step) <= target_sum);
        size -= step;
    }
    let at = vellus_half_place(half, r, a);
    if target_sum < at.sum {
        return vellus_invert(start, at, target_sum, u);
    } else if a == stop_node {
        return vellus_invert(at, stop, target_sum, u);
    }
    return vellus_invert(at, vellus_half_place(half, r, a + 1u), target_sum, u);
}

// Draws the sine and cosine of theta_i, and an azimuth from straight back, for scattered light.
fn vellus_draw_scattered(hit: ptr<function, VellusHit>, u: vec3<f32>) -> vec3<f32> {
    let reflects = vellus_fiber((*hit).fiber, VELLUS_CORTEX).w > 0.0;
    var phi: f32;
    var share: f32;
    if reflects {
        // First a half of C^M in proportion to its light that leaves, then the azimuth under the weight of that half.
        var parts = vec2<f32>(0.0);
        for (var c = 0u; c < 10u; c++) {
            parts.x += vellus_sum(vellus_product(hit, VELLUS_CHOOSE_AZIMUTH_BACK, c));
            parts.y += vellus_sum(vellus_product(hit, VELLUS_CHOOSE_AZIMUTH_AHEAD, c));
        }
        parts *= (*hit).leaving;
        share = parts.y / max(parts.x + parts.y, VELLUS_TINY);
        let ahead = u.x < share;
        let kind = select(VELLUS_CHOOSE_AZIMUTH_BACK, VELLUS_CHOOSE_AZIMUTH_AHEAD, ahead);
        let chosen = vellus_choose(hit, kind, 10u, u.z);
        phi = vellus_draw_azimuth(hit, chosen.component, chosen.u, select(1u, 2u, ahead));
    } else {
        let chosen = vellus_choose(hit, VELLUS_CHOOSE_AZIMUTH, 10u, u.z);
        phi = vellus_draw_azimuth(hit, chosen.component, chosen.u, 0u);
        share = abs(vellus_wrap(phi)) / VELLUS_PI;
    }
    let forward = u.x < share;
    let rest = select((u.x - share) / max(1.0 - share, VELLUS_TINY), u.x / share, forward);
    return vec3<f32>(vellus_draw_inclination(hit, forward, rest, u.y), phi);
}

// Draws the sine and cosine of theta_i from one half of C^M. `u` chooses a component, and `v` a place in it.
fn vellus_draw_inclination(hit: ptr<function, VellusHit>, forward: bool, u: f32, v: f32) -> vec2<f32> {
    var chosen: VellusChoice;
    if forward {
        chosen = vellus_choose(hit, VELLUS_CHOOSE_FORWARD, 8u, u);
    } else {
        chosen = vellus_choose(hit, VELLUS_CHOOSE_BACKWARD, 4u, u);
    }
    let half = vellus_half(hit, forward);
    let theta = (vellus_invert_half(half, chosen.component, v) - half.shift) * (*hit).inclination_mirror;
    let turn = vellus_sin_cos(theta);
    if vellus_fiber((*hit).fiber, VELLUS_CORTEX).w > 0.0 {
        let s = clamp(vellus_fiber((*hit).fiber, VELLUS_OPTICS).x * turn.x, -1.0, 1.0);
        return vec2<f32>(s, sqrt((1.0 - s) * (1.0 + s)));
    }
    return turn;
}
