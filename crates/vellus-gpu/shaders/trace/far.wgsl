// The far field at every hit. The first rows of the tables say where each fibre's table begins, in steps of 16 rows.

fn fiber_hit(hit: ptr<function, VellusHit>, record: u32, wo: vec3<f32>, h: f32) {
    let table = 16u * u32(vellus_far_row(record / 4u)[record % 4u]);
    vellus_far_hit(hit, record, table, wo);
}

fn fiber_eval(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> vec4<f32> {
    return vellus_far_eval(hit, wi);
}

fn fiber_lobes(hit: ptr<function, VellusHit>, wi: vec3<f32>) -> VellusLobes {
    return vellus_far_eval_lobes(hit, wi);
}

fn fiber_sample(hit: ptr<function, VellusHit>, u: vec4<f32>) -> VellusSample {
    return vellus_far_sample(hit, u);
}
