// One thread per query in the far field: the energy and the value of each lobe, and a sample.

@group(0) @binding(0) var<storage, read> vellus_tables: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> vellus_fibers: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> queries: array<Query>;
@group(0) @binding(3) var<storage, read_write> answers: array<Answer>;
@group(0) @binding(4) var<storage, read> vellus_far_tables: array<vec4<f32>>;

struct Query {
    wo: vec3<f32>,
    // The first row of the fibre's table.
    table: u32,
    wi: vec3<f32>,
    // The index of the fibre.
    fiber: u32,
    u: vec4<f32>,
}

struct Answer {
    // f cos of all lobes, and the density.
    value: vec4<f32>,
    // The sampled direction and its density.
    direction: vec4<f32>,
    // The weight of the sample, and its lobe.
    weight: vec4<f32>,
    energy: array<vec4<f32>, 6>,
    lobes: array<vec4<f32>, 6>,
}

fn vellus_table(row: u32) -> vec4<f32> {
    return vellus_tables[row];
}

fn vellus_row(row: u32) -> vec4<f32> {
    return vellus_fibers[row];
}

fn vellus_far_row(row: u32) -> vec4<f32> {
    return vellus_far_tables[row];
}

@compute @workgroup_size(64)
fn run_far_queries(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    var hit: VellusHit;
    vellus_far_hit(&hit, query.fiber, query.table, query.wo);
    let drawn = vellus_far_sample(&hit, query.u);
    var energy = vellus_energy(&hit);
    var lobes = vellus_far_eval_lobes(&hit, query.wi);
    var answer: Answer;
    answer.value = vellus_far_eval(&hit, query.wi);
    answer.direction = vec4<f32>(drawn.wi, drawn.pdf);
    answer.weight = vec4<f32>(drawn.weight, f32(drawn.lobe));
    for (var p = 0u; p < 6u; p++) {
        answer.energy[p] = vec4<f32>(energy.rgb[p], 0.0);
        answer.lobes[p] = vec4<f32>(lobes.rgb[p], 0.0);
    }
    answers[id.x] = answer;
}
