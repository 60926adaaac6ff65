// What the path tracer asks a fibre, with the near field at one offset, or with the far field for the whole width.

// Whether the hit of this path has the far field.
var<private> is_far: bool;

fn fiber_hit(hit: ptr<function, VellusHit>, record: u32, wo: vec3<f32>, h: f32) {
    is_far = h == WHOLE_WIDTH;
    if is_far {
        let table = 16u * u32(vellus_far_row(record / 4u)[record % 4u]);
        vellus_far_hit(hit, record, table, wo);
    } else {
        vellus_hit(hit, record, wo, h);
    }
}

fn fiber_eval(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> vec4<f32> {
    if is_far {
        return vellus_far_eval(hit, wi);
    }
    return vellus_eval(hit, wi);
}

fn fiber_lobes(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> VellusLobes {
    if is_far {
        return vellus_far_eval_lobes(hit, wi);
    }
    return vellus_eval_lobes(hit, wi);
}

fn fiber_sample(hit: ptr<function, VellusHit>, u: vec4<f32>) -> VellusSample {
    if is_far {
        return vellus_far_sample(hit, u);
    }
    return vellus_sample(hit, u);
}
