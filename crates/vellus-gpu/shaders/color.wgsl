// Other absorption at each hit. `colors` is the first row of the fibre's colour record in the buffer of the records.

// The pigment with this absorption of the cortex. The medulla gets the fibre's share of it.
fn vellus_pigment(colors: u32, cortex: vec3<f32>) -> VellusPigment {
    let share = vellus_coat(colors, VELLUS_COATS + 1u);
    return VellusPigment(cortex, min(cortex * share, vec3<f32>(1000.0)));
}

// The absorption of the cortex with these concentrations of melanin.
fn vellus_melanin(eumelanin: f32, pheomelanin: f32) -> vec3<f32> {
    return eumelanin * VELLUS_EUMELANIN + pheomelanin * VELLUS_PHEOMELANIN;
}

// The pigment with which a dense coat of such fibres has this colour in white light, linear RGB.
fn vellus_coat_pigment(colors: u32, color: vec3<f32>) -> VellusPigment {
    var cortex = vec3<f32>(0.0);
    for (var channel = 0u; channel < 3u; channel++) {
        cortex[channel] = vellus_coat_absorption(colors, color[channel]);
    }
    return vellus_pigment(colors, cortex);
}

// A number of the coats: their colours, which fall, and then others.
fn vellus_coat(colors: u32, index: u32) -> f32 {
    return vellus_row(colors + VELLUS_COLOR_COATS + index / 4u)[index % 4u];
}

// The absorption of the cortex for the colour of one channel.
fn vellus_coat_absorption(colors: u32, color: f32) -> f32 {
    // The number of nodes that have at least this colour.
    var above = 0u;
    for (var size = VELLUS_COATS; size > 0u; size /= 2u) {
        while above + size <= VELLUS_COATS && vellus_coat(colors, above + size - 1u) >= color {
            above += size;
        }
    }
    if above == 0u {
        return 0.0;
    }
    // The number after the colours is the absorption of the darkest.
    if above == VELLUS_COATS {
        return vellus_coat(colors, VELLUS_COATS);
    }
    let bright = vellus_coat(colors, above - 1u);
    let t = (bright - color) / (bright - vellus_coat(colors, above));
    let exponent = (f32(above) - 2.0 + t) * VELLUS_COAT_STEP;
    return VELLUS_COAT_LEAST * select(vellus_exp(exponent), t, above == 1u);
}

// Prepares a hit as vellus_hit does, but with this absorption and not that of the record. Of wet fibres it is that of
// the dry fibre.
fn vellus_hit_colored(
    hit: ptr<function, VellusHit>, fiber: u32, colors: u32, pigment: VellusPigment, wo: vec3<f32>, offset: f32
) {
    // Water keeps light in.
    let water = vellus_coat(colors, VELLUS_COATS + 2u);
    let cortex = min(pigment.cortex * water, vec3<f32>(1000.0));
    let medulla = min(pigment.medulla * water, vec3<f32>(1000.0));
    let kappa = vellus_fiber(fiber, VELLUS_OPTICS).y;
    var gain = 0.0;
    if vellus_fiber(fiber, VELLUS_CORTEX).w > 0.0 {
        let parts = vellus_row(colors + VELLUS_COLOR_GAIN);
        let absorbed = dot(min(medulla * kappa, vec3<f32>(2.0)), vec3<f32>(1.0 / 3.0));
        gain = vellus_exp(absorbed * (parts.x + parts.y * absorbed) / (1.0 + parts.z * absorbed * parts.w));
    }
    let path = vellus_begin_path(hit, fiber, wo, offset, gain);
    var exits = VellusExits();
    if (*hit).scatters && gain > 0.0 {
        let nodes = vellus_entry_nodes(path.s_m / kappa, path.sin2_t / VELLUS_MOST_SIN2);
        for (var channel = 0u; channel < 3u; channel++) {
            let exit = vellus_exit(colors, cortex[channel], medulla[channel] * kappa, nodes);
            exits.escape[channel] = exit.x;
            exits.kept[channel] = exit.y;
            exits.first[channel] = exit.z;
        }
    }
    vellus_attenuation(hit, fiber, path, VellusPigment(cortex, medulla), exits);
}

// Numbers at the eight nodes of the entry.
struct VellusNodes {
    low: vec4<f32>,
    high: vec4<f32>,
}

fn vellus_nodes_dot(a: VellusNodes, b: VellusNodes) -> f32 {
    return dot(a.low, b.low) + dot(a.high, b.high);
}

// The weights of the nodes for a chord and a squared sine, in [0, 1]: the nodes are the corners of a square and the
// middles of its sides, and the weights are those of the quadratic serendipity element.
fn vellus_entry_nodes(c: f32, y: f32) -> VellusNodes {
    let d = 1.0 - c;
    let z = 1.0 - y;
    return VellusNodes(
        vec4<f32>(d * z * (1.0 - 2.0 * (c + y)), 4.0 * c * d * z, c * z * (2.0 * (c - y) - 1.0), 4.0 * d * y * z),
        vec4<f32>(4.0 * c * y * z, d * y * (2.0 * (y - c) - 1.0), 4.0 * c * d * y, c * y * (2.0 * (c + y) - 3.0))
    );
}

// The logarithm of what absorption in the medulla leaves, at four nodes. `low` and `high` are the effective paths of
// the absorptions around `a`, whose position between them is `t`. `next` is the higher one.
fn vellus_ln_kept(low: vec4<f32>, high: vec4<f32>, t: f32, a: f32, next: f32, steep: bool) -> vec4<f32> {
    var path = low + (high - low) * t;
    if steep {
        // The inverse is linear in a dense medulla.
        let ends = VELLUS_STEEP;
        let share = clamp((ends.x - high / low) / (ends.x - ends.y), vec4<f32>(0.0), vec4<f32>(1.0));
        let inverse = 1.0 / low + (1.0 / high - 1.0 / low) * t;
        path = 1.0 / (1.0 / path + (inverse - 1.0 / path) * share);
    }
    return -min(path * a, high * next);
}

// The share of scattered light that leaves without absorption in the medulla on the first path, the logarithm of what
// that absorption leaves, and the share that leaves when it first meets the cuticle. One channel: `cortex` is the
// absorption of the cortex, and `a` that of the medulla per radius of the medulla. See vellus::exit for the theory.
fn vellus_exit(colors: u32, cortex: f32, a: f32, nodes: VellusNodes) -> vec3<f32> {
    var kept_ln = VellusNodes();
    if a > 0.0 {
        let at = vellus_between(vellus_log(1.0 + 4.0 * a) * (1.0 / 1.0986123), VELLUS_PATHS);
        var next = 3.0;
        for (var k = 0u; k < at.index; k++) {
            next *= 3.0;
        }
        next = (next - 1.0) / 4.0;
        let row = colors + VELLUS_COLOR_PATHS + 2u * at.index;
        let steep = at.index == 0u;
        kept_ln.low = vellus_ln_kept(vellus_row(row), vellus_row(row + 2u), at.t, a, next, steep);
        kept_ln.high = vellus_ln_kept(vellus_row(row + 1u), vellus_row(row + 3u), at.t, a, next, steep);
    }
    // Sums over the states, at the nodes: of what absorption leaves, and of light that leaves at once, that leaves
    // before it is scattered again, and that is scattered again.
    var entered = VellusNodes();
    var at_once = VellusNodes();
    var leaves = VellusNodes();
    var stays = VellusNodes();
    var numerator = 0.0;
    var denominator = 0.0;
    for (var state = 0u; state < VELLUS_STATES; state++) {
        let optics = vellus_row(colors + VELLUS_COLOR_STATES + state);
        let shape = vellus_pair(VELLUS_EXIT_STATES, state);
        let entry = VELLUS_EXIT_NODES + 2u * state;
        let ln = vellus_nodes_dot(kept_ln, VellusNodes(vellus_table(entry), vellus_table(entry + 1u)));
        let e = vellus_exp4(vec4<f32>(-optics.y * cortex, 0.5 * min(ln, 0.0), -shape.y * a, 0.0));
        let t = optics.x;
        let scattered = optics.z;
        let leaving = e.y;
        let kept = clamp(e.z + optics.w * (leaving * leaving - e.z), 0.0, 1.0);
        let square = e.x * e.x;
        let returns = (1.0 - t) * square;
        let lost = t + (1.0 - t) * (1.0 - square);
        let absorbed = (1.0 - scattered) * (1.0 - e.z);
        let inverse = 1.0 / max(lost + returns * (scattered + absorbed), 1e-20);
        let once = t * e.x;
        let weight = shape.x * scattered * leaving * inverse;
        numerator += weight * once;
        denominator += weight * (lost + returns * (absorbed + scattered * (1.0 - kept)));
        let row = colors + VELLUS_COLOR_FIRST + 2u * state;
        let low = vellus_row(row) * leaving;
        let high = vellus_row(row + 1u) * leaving;
        entered = VellusNodes(entered.low + low, entered.high + high);
        at_once = VellusNodes(at_once.low + low * once, at_once.high + high * once);
        let left = once * inverse;
        leaves = VellusNodes(leaves.low + low * left, leaves.high + high * left);
        let stayed = returns * scattered * kept * inverse;
        stays = VellusNodes(stays.low + low * stayed, stays.high + high * stayed);
    }
    let x = numerator / max(denominator, VELLUS_TINY);
    let low = vellus_exit_shares(entered.low, at_once.low, leaves.low + stays.low * x);
    let high = vellus_exit_shares(entered.high, at_once.high, leaves.high + stays.high * x);
    return vec3<f32>(
        dot(nodes.low, low.all) + dot(nodes.high, high.all),
        vellus_nodes_dot(nodes, kept_ln),
        dot(nodes.low, low.first) + dot(nodes.high, high.first)
    );
}

// The share of light that leaves, and the part of it that leaves at once, at four nodes.
struct VellusShares {
    all: vec4<f32>,
    first: vec4<f32>,
}

// `entered` is what absorption leaves at the first exits, and the others what of it leaves the fibre.
fn vellus_exit_shares(entered: vec4<f32>, at_once: vec4<f32>, leaving: vec4<f32>) -> VellusShares {
    let inverse = 1.0 / max(entered, vec4<f32>(VELLUS_TINY));
    let zero = vec4<f32>(0.0);
    let one = vec4<f32>(1.0);
    let all = clamp(leaving * inverse, zero, one);
    let first = clamp(at_once * inverse, zero, one);
    return VellusShares(all, min(first / max(all, vec4<f32>(VELLUS_TINY)), one));
}
