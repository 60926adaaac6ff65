//! Other absorption at each hit, against the Rust model of a fibre with this absorption. Mesa's lavapipe is enough.

use crate::common::device;
use crate::near_field::{differences, fibers};
use bytemuck::cast_slice;
use vellus::{Bcsdf, CoatColors, Color, Fiber, Window};
use vellus_gpu::{Answer, QUERIES, Query, shader_color, shader_fiber, shader_library, shader_tables};
use vellus_testing::Uniform;

/// Records of fibres, one after another, then their colour records.
fn records(models: &[Bcsdf<'_>]) -> Vec<[f32; 4]> {
    models.iter().flat_map(shader_fiber).chain(models.iter().flat_map(shader_color)).collect()
}

/// The first row of the colour record of fibre `k`, in WGSL.
fn first(fibers: usize, k: &str) -> String {
    format!("{fibers}u * VELLUS_FIBER_ROWS + VELLUS_COLOR_ROWS * {k}")
}

/// The compute shader of the queries, but each has a pigment of its own.
fn shader(fibers: usize) -> String {
    let hit = "vellus_hit(&hit, query.fiber, query.wo, query.h);";
    let colored = format!(
        "let pigment = VellusPigment(pigments[2u * id.x].xyz, pigments[2u * id.x + 1u].xyz);
        vellus_hit_colored(&hit, query.fiber, {}, pigment, query.wo, query.h);",
        first(fibers, "query.fiber")
    );
    let bindings = "@group(0) @binding(3) var<storage, read> pigments: array<vec4<f32>>;\n";
    let queries = QUERIES.replace(hit, &colored).replace("@binding(3)", "@binding(4)");
    assert!(queries.contains("vellus_hit_colored"));
    format!("{}{bindings}{queries}", shader_library())
}

/// Absorption from none to much, often the same in two channels.
fn absorption(random: &mut Uniform) -> [f32; 3] {
    let mut sigma: [f32; 3] = std::array::from_fn(|_| (20.0 * random.next().powi(4)) as f32);
    let k = (random.next() * 9.0) as usize;
    if k < 3 {
        sigma[k] = 0.0;
    } else if k < 6 {
        sigma[k - 3] = sigma[(k - 2) % 3];
    }
    sigma
}

#[test]
fn a_colored_hit_is_that_of_the_fibre_with_this_absorption() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let mut random = Uniform(1);
    let mut fibers = fibers(200);
    fibers.iter_mut().step_by(5).for_each(|fiber| fiber.wet = random.next() as f32);
    let models = fibers.iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let (mut queries, mut pigments, mut colored) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..40_000 {
        let index = k % models.len();
        let (sigma_ca, sigma_ma) = (absorption(&mut random), absorption(&mut random));
        let model = Bcsdf::new(&Fiber { sigma_ca, sigma_ma, ..fibers[index] })?;
        let wo = vellus::direction(random.within(-1.55, 1.55), random.within(-3.1, 3.1));
        let h = random.within(-1.0, 1.0) as f32;
        let wi = random.outgoing(&model.at(wo, Window::near(h)), k / models.len());
        queries.push(Query { wo: wo.to_array(), h, wi: wi.to_array(), fiber: index as u32, u: random.numbers() });
        pigments.extend([sigma_ca, sigma_ma].map(|[r, g, b]| [r, g, b, 0.0]));
        colored.push(model);
    }
    let (tables, records) = (shader_tables(), records(&models));
    let inputs = [cast_slice(&tables), cast_slice(&records), cast_slice(&queries), cast_slice(&pigments)];
    let groups = queries.len().div_ceil(64) as u32;
    let answers: Vec<Answer> = device.compute(&shader(models.len()), "run_queries", &inputs, queries.len(), groups)?;
    let (worst, _) = differences(&queries, &answers, |k| &colored[k]);
    // As for the hits of a record.
    assert!(worst.iter().all(|error| *error < 2e-4), "{worst:?}");
    Ok(())
}

#[test]
fn colors_give_the_absorption_of_the_model() -> Result<(), Box<dyn std::error::Error>> {
    let Some(device) = device() else { return Ok(()) };
    let fibers = fibers(40);
    let models = fibers.iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>()?;
    let mut random = Uniform(2);
    let colors: Vec<[f32; 4]> = (0..4_000).map(|_| random.numbers()).collect();
    let source = format!(
        "{}
        @group(0) @binding(0) var<storage, read> records: array<vec4<f32>>;
        @group(0) @binding(1) var<storage, read> colors: array<vec4<f32>>;
        @group(0) @binding(2) var<storage, read_write> answers: array<array<vec4<f32>, 3>>;
        fn vellus_table(row: u32) -> vec4<f32> {{ return vec4<f32>(); }}
        fn vellus_row(row: u32) -> vec4<f32> {{ return records[row]; }}
        @compute @workgroup_size(1) fn run(@builtin(global_invocation_id) id: vec3<u32>) {{
            let pigment = vellus_coat_pigment({}, colors[id.x].xyz);
            answers[id.x][0] = vec4<f32>(pigment.cortex, 0.0);
            answers[id.x][1] = vec4<f32>(pigment.medulla, 0.0);
            answers[id.x][2] = vec4<f32>(vellus_melanin(colors[id.x].x, colors[id.x].y), 0.0);
        }}",
        shader_library(),
        first(models.len(), &format!("(id.x % {}u)", models.len()))
    );
    let records = records(&models);
    let inputs = [cast_slice(&records), cast_slice(&colors)];
    let answers: Vec<[[f32; 4]; 3]> = device.compute(&source, "run", &inputs, colors.len(), colors.len() as u32)?;
    let coats = fibers.iter().map(CoatColors::new).collect::<Result<Vec<_>, _>>()?;
    for (k, (color, answer)) in colors.iter().zip(&answers).enumerate() {
        let [r, g, b, _] = *color;
        let fiber = &fibers[k % fibers.len()];
        let coat = fiber.with_pigment([r, g, b].map(|c| coats[k % fibers.len()].absorption(c)));
        let melanin = fiber.with_color(Color::Melanin { eumelanin: r, pheomelanin: g })?;
        for (expected, ours) in [coat.sigma_ca, coat.sigma_ma, melanin.sigma_ca].into_iter().zip(answer) {
            let close = expected.iter().zip(ours).all(|(a, b)| (a - b).abs() <= 2e-4 * a);
            assert!(close, "{fiber:?} {color:?}: {expected:?} {ours:?}");
        }
    }
    Ok(())
}
