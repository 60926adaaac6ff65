// The azimuth of scattered light that leaves the fibre: D19 and D20. Inside the fibre the light has the azimuth psi,
// and outside phi. exp(i phi) is a Moebius transformation of exp(i psi) with a complex parameter a.

// The product of two complex numbers.
fn vellus_times(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// Prepares the transformations of a path at the offset h. It shifts the azimuths of scattered light.
fn vellus_prepare_turns(hit: ptr<function, VellusHit>, fiber: u32, path: VellusPath, h: f32, cos_o: f32) {
    let parts = vellus_fiber(fiber, VELLUS_TURN);
    let offset = clamp(path.h_inside / vellus_fiber(fiber, VELLUS_OPTICS).y, -1.0, 1.0);
    let straight = vellus_fiber(fiber, VELLUS_CONE).w * cos_o;
    let more = straight * (path.gamma_o - path.gamma_t - offset * parts.w);
    let shift = -offset * parts.x;
    var a = clamp(
        0.5 * vec2<f32>((1.0 - offset * offset) * parts.z, -(offset * parts.y + more)),
        vec2<f32>(-VELLUS_MOST_TURN), vec2<f32>(VELLUS_MOST_TURN)
    );
    let turn = vellus_sin_cos(shift);
    a = vellus_times(a, turn.yx);
    let cos_o_gamma = sqrt(max((1.0 - h) * (1.0 + h), 0.0));
    let inside = vec2<f32>(sqrt(max((1.0 - path.h_inside) * (1.0 + path.h_inside), 0.0)), path.h_inside);
    let first = vellus_times(inside, vec2<f32>(cos_o_gamma, -h));
    (*hit).scattered_exit += shift;
    (*hit).turns[0] = vellus_times(a, first);
    (*hit).turns[1] = vellus_times(a, -vellus_times(first, vellus_times(inside, inside)));
    let entry = vec2<f32>(sqrt(max((1.0 - offset) * (1.0 + offset), 0.0)), -offset);
    (*hit).later = -vellus_fiber(fiber, VELLUS_CONE_POSITION).w * vellus_times(first, entry);
}

// 1 + a exp(-i phi), from the cosine and the sine of phi. Twice its angle is psi - phi.
fn vellus_turn_inverse(a: vec2<f32>, around: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(1.0 + dot(a, around), a.y * around.x - a.x * around.y);
}

// d psi / d phi.
fn vellus_turn_slope(a: vec2<f32>, inverse: vec2<f32>) -> f32 {
    return (1.0 - dot(a, a)) / dot(inverse, inverse);
}

// The density over the azimuth, times 2 pi, of light that was uniform before.
fn vellus_turn_uniform(a: vec2<f32>, around: vec2<f32>) -> f32 {
    return vellus_turn_slope(a, vellus_turn_inverse(a, around));
}

// phi of psi.
fn vellus_turn_leaving(a: vec2<f32>, psi: f32) -> f32 {
    let around = vellus_sin_cos(psi).yx;
    return psi + 2.0 * vellus_atan2(a.x * around.y - a.y * around.x, 1.0 - dot(a, around));
}
