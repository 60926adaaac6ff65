//! The functions, called from Rust, have the bits of the crate `vellus`: ten presets, four windows, many directions.

#![allow(unsafe_code, reason = "calls of the C interface")]

use std::ffi::CStr;
use std::ptr::null_mut;
use vellus::wide::f32x8;
use vellus::{Bcsdf, Fiber, FiberBuilder, FiberFrame, Sample, Species, Tables, Window, packed};
use vellus_c::*;
use vellus_testing::{Query, queries};

/// Not a multiple of eight.
const COUNT: usize = 403;

const OK: VellusStatus = VellusStatus::Ok;

struct Handle(*mut VellusFiber);

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: `handle` made it.
        unsafe { vellus_fiber_free(self.0) }
    }
}

/// The fibre as JSON, through the interface, and Rust's.
fn fiber(species: Species) -> (Handle, Bcsdf<'static>) {
    let fiber = Fiber::preset(species).with_absorption([0.2, 0.4, 0.8]);
    let json = format!("{{\"preset\": \"{species}\", \"sigma_ca\": [0.2, 0.4, 0.8]}}\0");
    let mut handle = null_mut();
    // SAFETY: the text ends with a zero byte.
    assert_eq!(unsafe { vellus_fiber_from_json(json.as_ptr().cast(), &mut handle) }, OK);
    (Handle(handle), Bcsdf::new(&fiber).unwrap())
}

fn windows(q: &Query) -> [Window; 4] {
    [Window::near(q.h), Window::cell(q.h, 0.3, q.u[4]), Window::range(-0.2, 0.9), Window::far()]
}

fn c_window(window: Window) -> VellusWindow {
    let [low, high] = window.ends();
    VellusWindow { low, high }
}

fn c_sample(sample: Option<Sample>) -> VellusSample {
    let nothing = VellusSample { wi: [0.0; 3], pdf: 0.0, weight: [0.0; 3], lobe: -1 };
    sample.map_or(nothing, |s| VellusSample { wi: s.wi.to_array(), pdf: s.pdf, weight: s.weight, lobe: s.lobe as i32 })
}

#[test]
fn single_queries_have_the_bits_of_rust() {
    for species in Species::ALL {
        let (handle, bcsdf) = fiber(species);
        for (q, window) in queries(COUNT / 8).iter().flat_map(|q| windows(q).map(|window| (q, window))) {
            let hit = bcsdf.at(q.wo, window);
            let (lobes, pdf) = hit.eval_pdf(q.wi);
            let (wo, wi, w) = (q.wo.to_array(), q.wi.to_array(), c_window(window));
            let (mut rgb, mut density, mut each) = ([0.0; 3], [0.0; 2], [[0.0; 3]; 6]);
            let mut sample = c_sample(None);
            // SAFETY: all pointers are those of arrays of the documented sizes.
            unsafe {
                let (f, wo, wi) = (handle.0.cast_const(), wo.as_ptr(), wi.as_ptr());
                assert_eq!(vellus_fiber_eval(f, wo, w, wi, rgb.as_mut_ptr()), OK);
                assert_eq!(rgb, lobes.total());
                assert_eq!(vellus_fiber_pdf(f, wo, w, wi, &mut density[0]), OK);
                rgb = [0.0; 3];
                assert_eq!(vellus_fiber_eval_pdf(f, wo, w, wi, rgb.as_mut_ptr(), &mut density[1]), OK);
                assert_eq!((rgb, density), (lobes.total(), [pdf; 2]));
                assert_eq!(vellus_fiber_eval_lobes(f, wo, w, wi, each.as_mut_ptr().cast()), OK);
                assert_eq!(each, lobes.0);
                assert_eq!(vellus_fiber_energy(f, wo, w, each.as_mut_ptr().cast()), OK);
                assert_eq!(each, hit.energy().0);
                assert_eq!(vellus_fiber_sample(f, wo, w, q.u.as_ptr(), &mut sample), OK);
                assert_eq!(sample, c_sample(hit.sample(q.u)));

                let mut h = null_mut();
                assert_eq!(vellus_hit_new(f, wo, w, &mut h), OK);
                let mut probabilities = [0.0; VELLUS_LOBES];
                assert_eq!(vellus_hit_lobe_probabilities(h, probabilities.as_mut_ptr()), OK);
                assert_eq!(probabilities, hit.lobe_probabilities());
                assert_eq!(vellus_hit_eval_pdf(h, wi, rgb.as_mut_ptr(), &mut density[0]), OK);
                assert_eq!((rgb, density[0]), (lobes.total(), pdf));
                assert_eq!(vellus_hit_pdf(h, wi, &mut density[0]), OK);
                assert_eq!(vellus_hit_eval(h, wi, rgb.as_mut_ptr()), OK);
                assert_eq!((rgb, density[0]), (lobes.total(), pdf));
                assert_eq!(vellus_hit_eval_lobes(h, wi, each.as_mut_ptr().cast()), OK);
                assert_eq!(each, lobes.0);
                assert_eq!(vellus_hit_energy(h, each.as_mut_ptr().cast()), OK);
                assert_eq!(each, hit.energy().0);
                assert_eq!(vellus_hit_sample(h, q.u.as_ptr(), &mut sample), OK);
                assert_eq!(sample, c_sample(hit.sample(q.u)));
                vellus_hit_free(h);
            }
        }
    }
}

/// A straight fibre, round and flat.
#[test]
fn frames_have_the_bits_of_rust() {
    let (center, radius) = ([1.0, 2.0, -3.0], 0.25);
    for q in queries(100) {
        let (tangent, wo) = (q.wi.to_array(), q.wo.to_array());
        let c = VellusFrame { tangent, center, radius };
        let rust = FiberFrame::new(q.wi, center.into(), radius);
        let position = rust.center() + rust.outward(rust.to_world(q.wi)) * radius;
        let at = position.to_array();
        let (mut local, mut back, mut outward, mut x) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
        // SAFETY: all pointers are those of arrays of the documented sizes.
        unsafe {
            assert_eq!(vellus_frame_to_local(&c, wo.as_ptr(), local.as_mut_ptr()), OK);
            assert_eq!(vellus_frame_to_world(&c, local.as_ptr(), back.as_mut_ptr()), OK);
            assert_eq!(vellus_frame_outward(&c, wo.as_ptr(), outward.as_mut_ptr()), OK);
            assert_eq!(vellus_frame_offset(&c, at.as_ptr(), wo.as_ptr(), &mut x[0]), OK);
            assert_eq!(vellus_frame_offset_flat(&c, at.as_ptr(), wo.as_ptr(), &mut x[1]), OK);
            assert_eq!(vellus_frame_pixel_width(&c, 0.1, &mut x[2]), OK);
        }
        let w = rust.to_local(q.wo);
        assert_eq!((local, back), (w.to_array(), rust.to_world(w).to_array()));
        assert_eq!(outward, rust.outward(q.wo).to_array());
        assert_eq!(x, [rust.offset(position, q.wo), rust.offset_flat(position, q.wo), rust.pixel_width(0.1)]);
    }
}

/// The fibre's own colour is the nearest one to a reflectance out of reach.
#[test]
fn reflectances_and_species_are_those_of_rust() {
    let mut parameters = Vec::new();
    for i in 0..vellus_species_count() {
        // SAFETY: names are texts of the library, and parameters are plain numbers.
        unsafe {
            let name = CStr::from_ptr(vellus_species_name(i));
            assert_eq!(name.to_str(), Ok(Species::ALL[i].name()));
            let mut p = std::mem::zeroed();
            assert_eq!(vellus_parameters_preset(name.as_ptr(), &mut p), OK);
            parameters.push(p);
        }
    }
    assert_eq!(parameters.len(), Species::ALL.len());
    let (mut p, mut fiber, mut color, mut nearest) = (parameters[7], null_mut(), [0.0; 3], [[0.0f32; 3]; 2]);
    let (dark, fox) = ([0.001, 0.3, 0.001], [0.8, 0.4, 0.2]);
    // SAFETY: all pointers are those of arrays of the documented sizes.
    unsafe {
        assert_eq!(vellus_parameters_nearest_reflectance(&p, dark.as_ptr(), nearest[0].as_mut_ptr()), OK);
        assert_eq!(vellus_parameters_nearest_reflectance(&p, fox.as_ptr(), nearest[1].as_mut_ptr()), OK);
        assert_eq!(vellus_parameters_set(&mut p, c"reflectance".as_ptr(), dark.as_ptr(), 3), OK);
        assert_eq!(vellus_fiber_from_parameters(&p, &mut fiber), OK);
        let fiber = Handle(fiber);
        assert_eq!(vellus_fiber_coat_color(fiber.0, color.as_mut_ptr()), OK);
    }
    let mut builder = FiberBuilder::new(Fiber::preset(Species::RedFox));
    builder.set("reflectance", &dark).unwrap();
    assert_eq!(nearest, [builder.out_of_reach().unwrap().unwrap().nearest, fox]);
    assert_eq!(color, builder.build().unwrap().coat_color().unwrap());
    assert!(nearest[0][0] > 0.001 && color.iter().zip(nearest[0]).all(|(a, b)| (a - b).abs() < 0.01), "{color:?}");
}

/// The rows of a function that copies them: first their number, then they.
fn rows(call: impl Fn(*mut f32, usize, &mut usize) -> VellusStatus) -> Vec<[f32; 4]> {
    let mut count = 0;
    assert_eq!(call(null_mut(), 0, &mut count), VellusStatus::Space);
    let mut rows = vec![[0.0; 4]; count];
    assert_eq!(call(rows.as_mut_ptr().cast(), count, &mut count), OK);
    rows
}

#[test]
fn buffers_of_shaders_have_the_bits_of_rust() {
    let (handle, bcsdf) = fiber(Species::RedFox);
    // A row may hold the bits of an integer, which is NaN as a number.
    let bits = |rows: &[[f32; 4]]| rows.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    // SAFETY: `rows` passes pointers to arrays with the number of rows that it states.
    let (tables, record, color, far) = unsafe {
        (
            rows(|rows, capacity, count| vellus_shader_tables(rows, capacity, count)),
            rows(|rows, capacity, count| vellus_shader_fiber(handle.0, rows, capacity, count)),
            rows(|rows, capacity, count| vellus_shader_color(handle.0, rows, capacity, count)),
            rows(|rows, capacity, count| vellus_shader_far_table(handle.0, rows, capacity, count)),
        )
    };
    assert_eq!(bits(&tables), bits(&packed::tables(Tables::shipped()).rows));
    assert_eq!(bits(&record), bits(&packed::fiber(&bcsdf)));
    assert_eq!(bits(&color), bits(&packed::color(&bcsdf)));
    assert_eq!(bits(&far), bits(&packed::far(&bcsdf).rows));
}

const NO_INPUT: VellusInput = VellusInput { data: std::ptr::null(), stride: 0 };
const NO_OUTPUT: VellusOutput = VellusOutput { data: null_mut(), stride: 0 };

/// Results of arrays, in a layout with gaps.
#[repr(C)]
#[derive(Clone, Copy)]
struct Result {
    rgb: [f32; 3],
    gap: f32,
    lobes: [[f32; 3]; 6],
    pdf: f32,
    sample: VellusSample,
}

const EMPTY: Result = Result {
    rgb: [0.0; 3],
    gap: 7.0,
    lobes: [[0.0; 3]; 6],
    pdf: 0.0,
    sample: VellusSample { wi: [0.0; 3], pdf: 0.0, weight: [0.0; 3], lobe: 0 },
};

/// Calls both functions of arrays. `h` or `window` or neither: then of the hit.
fn arrays(handle: &Handle, hit: *const VellusHit, q: &[Query], h: bool, w: Option<&[[f32; 2]]>) -> Vec<Result> {
    let mut results = vec![EMPTY; q.len()];
    let input = |data: &f32, stride: usize| VellusInput { data, stride };
    let queries = VellusQueries {
        count: q.len(),
        wo: input(&q[0].wo.x, size_of::<Query>()),
        h: if h { input(&q[0].h, size_of::<Query>()) } else { NO_INPUT },
        window: w.map_or(NO_INPUT, |w| VellusInput { data: w.as_ptr().cast(), stride: 8 }),
        wi: input(&q[0].wi.x, size_of::<Query>()),
        u: input(&q[0].u[0], size_of::<Query>()),
    };
    let stride = size_of::<Result>();
    let first = results.as_mut_ptr();
    // SAFETY: the pointers are those of the fields of the first query and of the first result, and the strides are the
    // sizes of the structs.
    unsafe {
        let output = |data: *mut f32| VellusOutput { data, stride };
        let values = VellusValues {
            rgb: output((&raw mut (*first).rgb).cast()),
            pdf: output(&raw mut (*first).pdf),
            lobes: output((&raw mut (*first).lobes).cast()),
        };
        let samples = VellusSamples {
            wi: output((&raw mut (*first).sample.wi).cast()),
            pdf: output(&raw mut (*first).sample.pdf),
            weight: output((&raw mut (*first).sample.weight).cast()),
            lobe: VellusOutputLobes { data: &raw mut (*first).sample.lobe, stride },
        };
        let statuses = if hit.is_null() {
            let fiber = handle.0.cast_const();
            (vellus_fiber_eval_array(fiber, &queries, &values), vellus_fiber_sample_array(fiber, &queries, &samples))
        } else {
            (vellus_hit_eval_array(hit, &queries, &values), vellus_hit_sample_array(hit, &queries, &samples))
        };
        assert_eq!(statuses, (OK, OK));
    }
    assert!(results.iter().all(|result| result.gap == 7.0));
    results
}

#[test]
fn arrays_have_the_bits_of_rust() {
    let q = queries(COUNT);
    for species in Species::ALL {
        let (handle, bcsdf) = fiber(species);
        // The near field: eight at once, whatever else is in the other lanes.
        for (q, result) in q.iter().zip(arrays(&handle, null_mut(), &q, true, None)) {
            let splat = |v: [f32; 3]| v.map(f32x8::splat);
            let hit = bcsdf.at8(splat(q.wo.to_array()), f32x8::splat(q.h));
            let (lobes, pdf) = hit.eval_pdf8(splat(q.wi.to_array()));
            let first = |x: f32x8| x.to_array()[0];
            assert_eq!((result.rgb, result.pdf), (lobes.total().map(first), first(pdf)));
            assert_eq!(result.lobes, lobes.0.map(|lobe| lobe.map(first)));
            let u = [q.u[0], q.u[1], q.u[2], q.u[3]];
            assert_eq!(result.sample, c_sample(hit.sample8(u.map(f32x8::splat))[0]));
        }
        for kind in 0..4 {
            let ends: Vec<[f32; 2]> = q.iter().map(|q| windows(q)[kind].ends()).collect();
            for (q, result) in q.iter().zip(arrays(&handle, null_mut(), &q, false, Some(&ends))) {
                let hit = bcsdf.at(q.wo, windows(q)[kind]);
                let (lobes, pdf) = hit.eval_pdf(q.wi);
                assert_eq!((result.rgb, result.lobes, result.pdf), (lobes.total(), lobes.0, pdf));
                assert_eq!(result.sample, c_sample(hit.sample(q.u)));
            }
            // Many directions of one hit.
            let (wo, window) = (q[5].wo, windows(&q[5])[kind]);
            let mut handle_of_hit = null_mut();
            // SAFETY: `wo` has three numbers.
            let status =
                unsafe { vellus_hit_new(handle.0, wo.as_ref().as_ptr(), c_window(window), &mut handle_of_hit) };
            assert_eq!(status, OK);
            let hit = bcsdf.at(wo, window);
            for (q, result) in q.iter().zip(arrays(&handle, handle_of_hit, &q, false, None)) {
                let (lobes, pdf) = hit.eval_pdf8(q.wi.to_array().map(f32x8::splat));
                assert_eq!(result.rgb, lobes.total().map(|x| x.to_array()[0]));
                assert_eq!(result.pdf, pdf.to_array()[0]);
                assert_eq!(result.sample, c_sample(hit.sample8(q.u.map(f32x8::splat))[0]));
            }
            // SAFETY: it was made above.
            unsafe { vellus_hit_free(handle_of_hit) };
        }
    }
}

/// A single result may be wanted alone.
#[test]
fn unwanted_results_are_left_out() {
    let (handle, bcsdf) = fiber(Species::Cat);
    let q = queries(3);
    let mut pdf = [0.0; 3];
    let queries = VellusQueries {
        count: 3,
        wo: VellusInput { data: &q[0].wo.x, stride: size_of::<Query>() },
        h: NO_INPUT,
        window: VellusInput { data: [-1.0, 1.0].as_ptr(), stride: 0 },
        wi: VellusInput { data: &q[0].wi.x, stride: size_of::<Query>() },
        u: NO_INPUT,
    };
    let output = VellusOutput { data: pdf.as_mut_ptr(), stride: 4 };
    let values = VellusValues { rgb: NO_OUTPUT, pdf: output, lobes: NO_OUTPUT };
    // SAFETY: the strides are those of the arrays, and a stride of 0 repeats the window.
    assert_eq!(unsafe { vellus_fiber_eval_array(handle.0, &queries, &values) }, OK);
    assert_eq!(pdf, [0, 1, 2].map(|i| bcsdf.at(q[i].wo, Window::far()).pdf(q[i].wi)));
}
