// The near field at every hit.

fn fiber_hit(hit: ptr<function, VellusHit>, record: u32, wo: vec3<f32>, h: f32) {
    vellus_hit(hit, record, wo, h);
}

fn fiber_eval(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> vec4<f32> {
    return vellus_eval(hit, wi);
}

fn fiber_lobes(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> VellusLobes {
    return vellus_eval_lobes(hit, wi);
}

fn fiber_sample(hit: ptr<function, VellusHit>, u: vec4<f32>) -> VellusSample {
    return vellus_sample(hit, u);
}
