// The longitudinal lobes of R, TT, TRT and the rest lobe (energy-conserving spherical Gaussians, d'Eon et al. 2011,
// Eq. 7), and their azimuthal lobes (wrapped Gaussians, Yan17 Eq. 7 and 16).

// The densities over the sine of theta_i.
fn vellus_longitudinal(hit: ptr<function, VellusHit>, sin_i: f32, cos_i: f32) -> vec4<f32> {
    let inverse_v = vellus_fiber((*hit).fiber, VELLUS_SHIFT + 3u);
    let ds = vec4<f32>(sin_i) - (*hit).centre_sin;
    let dc = vec4<f32>(cos_i) - (*hit).centre_cos;
    let e = vellus_exp4((ds * ds + dc * dc) * inverse_v * -0.5);
    let x = cos_i * (*hit).centre_cos * inverse_v;
    let bessel = vec4<f32>(
        vellus_bessel_i0e(x.x), vellus_bessel_i0e(x.y), vellus_bessel_i0e(x.z), vellus_bessel_i0e(x.w)
    );
    return e * bessel * vellus_fiber((*hit).fiber, VELLUS_SHIFT + 4u);
}

// Draws (sin, cos) of theta_i from lobe `p`.
fn vellus_sample_longitudinal(hit: ptr<function, VellusHit>, p: u32, u: vec2<f32>) -> vec2<f32> {
    let v = vellus_fiber((*hit).fiber, VELLUS_SHIFT + 2u)[p];
    let least = vellus_fiber((*hit).fiber, VELLUS_SHIFT + 5u)[p];
    let s = (*hit).centre_sin[p];
    let c = (*hit).centre_cos[p];
    // 1 minus the cosine of the angle from the centre, which the cosine itself would round.
    let drop = clamp(-v * vellus_log(max(u.x + (1.0 - u.x) * least, VELLUS_TINY)), 0.0, 2.0);
    let cosine = 1.0 - drop;
    let sine = sqrt(drop * (2.0 - drop));
    let psi = vellus_sin_cos(VELLUS_TAU * (u.y - 0.5));
    // The half turn changes the sign of both.
    let along = cosine * s - sine * psi.y * c;
    let across = vec2<f32>(cosine * c + sine * psi.y * s, -sine * psi.x);
    return vec2<f32>(along, length(across));
}

// The densities over the azimuth. The rest lobe is uniform.
fn vellus_azimuthal(hit: ptr<function, VellusHit>, phi: f32) -> vec4<f32> {
    let exponent = vellus_fiber((*hit).fiber, VELLUS_AZIMUTHAL);
    let norm = vellus_fiber((*hit).fiber, VELLUS_AZIMUTHAL + 1u);
    let images = i32(vellus_fiber((*hit).fiber, VELLUS_AZIMUTHAL + 2u).w);
    let centre = (*hit).exit;
    let d = vec4<f32>(
        vellus_wrap(phi - centre.x), vellus_wrap(phi - centre.y), vellus_wrap(phi - centre.z), 0.0
    );
    var sum = vec4<f32>(0.0);
    for (var image = -images; image <= images; image++) {
        let turned = d + VELLUS_TAU * f32(image);
        sum += vellus_exp4(turned * turned * exponent);
    }
    return sum * norm;
}

// The density over solid angle of scattered light that the cuticle reflected before it left: even in azimuth, and
// proportional to the square of the cosine over theta_i.
fn vellus_diffuse(cos_i: f32) -> f32 {
    return cos_i * (1.0 / (VELLUS_PI * VELLUS_PI));
}

fn vellus_sample_diffuse(u: vec2<f32>) -> vec2<f32> {
    let s = -sqrt(u.x) * vellus_sin_cos(VELLUS_TAU * (u.y - 0.5)).y;
    return vec2<f32>(s, sqrt(max((1.0 - s) * (1.0 + s), 0.0)));
}
