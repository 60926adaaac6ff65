// The light scattered by the medulla: C^N and C^M (Yan17 Eq. 10 and 19) from tables. Each profile is a mixture of the
// same densities. Its weights are products of one factor per parameter.

// Prepares C^M for the inclination at which light enters. `gain` is that of the backward half, 0 if the exit is open.
fn vellus_prepare_inclination(hit: ptr<function, VellusHit>, fiber: u32, theta: f32, gain: f32) {
    let shift = abs(theta);
    let at = vellus_on(shift * VELLUS_THETA_MAX_INVERSE, VELLUS_FORWARD_OFFSET_NODES);
    (*hit).theta = shift;
    (*hit).inclination_mirror = select(1.0, -1.0, theta < 0.0);
    // The integrals of both halves of the light that leaves, and of all light. Both are equal without refraction.
    var leaves = vec2<f32>(0.0);
    var all = vec2<f32>(0.0);
    for (var c = 0u; c < 4u; c++) {
        let w = vellus_mixed(VELLUS_BACKWARD_OFFSET, at, 4u, c) * vellus_fiber(fiber, VELLUS_BACKWARD_WEIGHTS + c);
        (*hit).backward[c] = w;
        leaves.x += dot(w, vellus_fiber(fiber, VELLUS_BACKWARD_INTEGRALS + c));
        all.x += dot(w, vellus_table(VELLUS_BACKWARD_TOTAL + c));
    }
    let total = vellus_between(shift * (360.0 / VELLUS_PI) + 1.0, VELLUS_FORWARD_INTEGRALS_NODES);
    for (var c = 0u; c < 8u; c++) {
        let w = vellus_mixed(VELLUS_FORWARD_OFFSET, at, 8u, c) * vellus_fiber(fiber, VELLUS_FORWARD_WEIGHTS + c);
        (*hit).forward[c] = w;
        leaves.y += dot(w, vellus_forward_integral(fiber, shift, c));
        all.y += dot(w, vellus_mixed(VELLUS_FORWARD_INTEGRALS, total, 8u, c));
    }
    if gain > 0.0 {
        all.y *= gain;
        // A density in the sine of theta_i, which is eta times that inside.
        (*hit).scale = all.yx * vellus_fiber(fiber, VELLUS_REFRACTION).z;
        (*hit).leaving = all.yx * leaves;
    } else {
        // By component: HLSL 2021 and Slang do not choose by vectors.
        let inverse = 1.0 / leaves;
        (*hit).scale = vec2<f32>(select(inverse.x, 0.0, leaves.x <= 0.0), select(inverse.y, 0.0, leaves.y <= 0.0));
        (*hit).leaving = vec2<f32>(1.0);
    }
}

// The integrals of four forward components of light that leaves, for the inclination `shift`.
fn vellus_forward_integral(fiber: u32, shift: f32, c: u32) -> vec4<f32> {
    if vellus_fiber(fiber, VELLUS_CORTEX).w > 0.0 {
        let cone = vellus_fiber(fiber, VELLUS_CONE);
        let position = vellus_fiber(fiber, VELLUS_CONE_POSITION);
        let along = vellus_on(shift * cone.z, VELLUS_CONE_SHIFTS);
        let low = u32(position.x) * VELLUS_CONE_SHIFTS + along.index;
        let high = low + VELLUS_CONE_SHIFTS;
        let first = vellus_cone_integral(low, along.t, cone.x, c);
        let second = vellus_cone_integral(high, along.t, cone.x, c);
        return max(first + (second - first) * position.y, vec4<f32>(0.0));
    }
    // Cubic interpolation on the nodes -1, 0, 1 and 2.
    let x = min(shift * (360.0 / VELLUS_PI), 180.0);
    let index = min(u32(x), 179u);
    let t = x - f32(index);
    let row = VELLUS_FORWARD_INTEGRALS + 8u * index + c;
    let outer = (t - 2.0) * t * (t - 1.0) * vellus_table(row) - (t + 1.0) * t * (t - 1.0) * vellus_table(row + 24u);
    let inner = (t + 1.0) * (t - 1.0) * (t - 2.0) * vellus_table(row + 8u)
        - (t + 1.0) * t * (t - 2.0) * vellus_table(row + 16u);
    return max(outer * (-1.0 / 6.0) + inner * 0.5, vec4<f32>(0.0));
}

// One node of the cone, between two shifts, with the loss of the cuticle.
fn vellus_cone_integral(node: u32, t: f32, loss: f32, c: u32) -> vec4<f32> {
    let row = VELLUS_CONE_INTEGRALS + 16u * node + c;
    let low = vellus_table(row) - loss * vellus_table(row + 8u);
    let high = vellus_table(row + 16u) - loss * vellus_table(row + 24u);
    return low + (high - low) * t;
}

// Prepares C^N for a path, after C^M. Returns the mean path of scattered light in the medulla.
fn vellus_prepare_azimuth(hit: ptr<function, VellusHit>, fiber: u32, path: VellusPath) -> f32 {
    let radius = vellus_fiber(fiber, VELLUS_MEDULLA).w;
    let tau_position = vellus_log(1.0 + VELLUS_TAU_SCALE * radius * path.elongation) * VELLUS_TAU_GROWTH_INVERSE;
    let tau = vellus_on(tau_position, VELLUS_AZIMUTH_TAU_NODES);
    let angle = abs(path.gamma_m);
    let offset = vellus_on(angle * (2.0 / VELLUS_PI), VELLUS_AZIMUTH_OFFSET_NODES);
    let leaving = (*hit).leaving;
    var sum = 0.0;
    for (var c = 0u; c < 10u; c++) {
        let w = vellus_mixed(VELLUS_AZIMUTH_TAU, tau, 10u, c) * vellus_mixed(VELLUS_AZIMUTH_OFFSET, offset, 10u, c)
            * vellus_fiber(fiber, VELLUS_AZIMUTH_WEIGHTS + c);
        (*hit).azimuth[c] = w;
        sum += dot(w, leaving.x + (leaving.y - leaving.x) * vellus_table(VELLUS_AZIMUTH_AHEAD + c));
    }
    (*hit).azimuth_scale = select(0.0, 1.0 / sum, sum > 0.0);
    (*hit).azimuth_mirror = select(1.0, -1.0, path.gamma_m < 0.0);
    let x = min(angle * VELLUS_MIRROR_REACH_INVERSE, 1.0);
    (*hit).turned = 0.5 * (1.0 - x) * (1.0 - x);
    let g = vellus_fiber(fiber, VELLUS_REFRACTION);
    let row = tau.index * VELLUS_MEAN_PATH_G_NODES + u32(g.x);
    let next = row + VELLUS_MEAN_PATH_G_NODES;
    let first = mix(vellus_mean_path(row, offset), vellus_mean_path(row + 1u, offset), g.y);
    let second = mix(vellus_mean_path(next, offset), vellus_mean_path(next + 1u, offset), g.y);
    return mix(first, second, tau.t);
}

fn vellus_mean_path(row: u32, offset: VellusBetween) -> f32 {
    let index = row * VELLUS_MEAN_PATH_H_NODES + offset.index;
    return mix(vellus_number(VELLUS_MEAN_PATH, index), vellus_number(VELLUS_MEAN_PATH, index + 1u), offset.t);
}

// C^N of a path with h >= 0 at an azimuth from straight back.
fn vellus_profile(hit: ptr<function, VellusHit>, phi: f32) -> f32 {
    let delta = select(phi, phi + VELLUS_TAU, phi < 0.0);
    let position = (delta - VELLUS_AZIMUTH_FIRST) * VELLUS_AZIMUTH_STEP_INVERSE;
    let at = vellus_between(position, VELLUS_AZIMUTH_VALUES_NODES);
    var sum = vec4<f32>(0.0);
    for (var c = 0u; c < 10u; c++) {
        sum += (*hit).azimuth[c] * vellus_mixed(VELLUS_AZIMUTH_VALUES, at, 10u, c);
    }
    return (*hit).azimuth_scale * vellus_sum(sum);
}

// C^N at an azimuth from straight back, in [-pi, pi].
fn vellus_scattered_azimuthal(hit: ptr<function, VellusHit>, phi: f32) -> f32 {
    let turned = phi * (*hit).azimuth_mirror;
    let value = vellus_profile(hit, turned);
    if (*hit).turned == 0.0 {
        return value;
    }
    return value + (*hit).turned * (vellus_profile(hit, -turned) - value);
}

// C^M of both halves, densities in the sine of theta_i. `theta` is the inclination inside the fibre.
fn vellus_leaving(hit: ptr<function, VellusHit>, theta: f32, sin_i: f32) -> vec2<f32> {
    let mirrored = theta * (*hit).inclination_mirror;
    let back_position = (mirrored - VELLUS_BACKWARD_FIRST) * VELLUS_BACKWARD_STEP_INVERSE;
    let back = vellus_between(back_position, VELLUS_BACKWARD_VALUES_NODES);
    let ahead_position = (mirrored + (*hit).theta - VELLUS_FORWARD_FIRST) * VELLUS_FORWARD_STEP_INVERSE;
    let ahead = vellus_between(ahead_position, VELLUS_FORWARD_VALUES_NODES);
    var sum = vec2<f32>(0.0);
    for (var c = 0u; c < 4u; c++) {
        sum.x += dot((*hit).backward[c], vellus_mixed(VELLUS_BACKWARD_VALUES, back, 4u, c));
    }
    for (var c = 0u; c < 8u; c++) {
        sum.y += dot((*hit).forward[c], vellus_mixed(VELLUS_FORWARD_VALUES, ahead, 8u, c));
    }
    let square = sin_i * sin_i;
    let transmittance = max(1.0 - vellus_fiber((*hit).fiber, VELLUS_CONE).x * square * square, 0.0);
    return sum * (*hit).scale * transmittance;
}
