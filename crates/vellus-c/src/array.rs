//! Arrays of queries, in the caller's memory.

use crate::fiber::VellusFiber;
use crate::hit::VellusHit;
use crate::memory::{Numbers, Places, VellusInput, VellusOutput, VellusOutputLobes, reference};
use crate::parameters::VellusParameters;
use crate::query::{VELLUS_LOBES, VellusSample, direction, uniform};
use crate::status::{Failure, VellusStatus, guard};
use crate::window::VellusWindow;
use std::ops::Range;
use vellus::wide::f32x8;
use vellus::{Bcsdf, Hit, Lobes, Sample, Window};

/// The input of many queries. Set fields that a function does not need to zero.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VellusQueries {
    /// The number of queries. 0 is allowed.
    pub count: usize,
    /// Unit vectors to where the path came from: 3 numbers. Hits ignore it, because it is theirs.
    pub wo: VellusInput,
    /// Offsets of the near field: 1 number, clamped to [−1, 1]. Give either this or `window`. Hits ignore both.
    pub h: VellusInput,
    /// Windows: 2 numbers, the low and the high offset.
    pub window: VellusInput,
    /// Unit vectors to the light: 3 numbers. Only eval reads it.
    pub wi: VellusInput,
    /// Uniform numbers in [0, 1): 5 numbers. Only sample reads it.
    pub u: VellusInput,
}

/// The results of vellus_*_eval_array(). At least one is wanted.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VellusValues {
    /// f·cos θᵢ, the sum of all lobes: 3 numbers.
    pub rgb: VellusOutput,
    /// The density per solid angle: 1 number.
    pub pdf: VellusOutput,
    /// f·cos θᵢ of each lobe: VELLUS_LOBES × 3 numbers.
    pub lobes: VellusOutput,
}

/// The results of vellus_*_sample_array(), as those of VellusSample. At least one is wanted.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VellusSamples {
    /// Directions: 3 numbers.
    pub wi: VellusOutput,
    /// Densities: 1 number. 0 if no direction was drawn.
    pub pdf: VellusOutput,
    /// Weights: 3 numbers.
    pub weight: VellusOutput,
    /// Lobes: 1 number. −1 if no direction was drawn.
    pub lobe: VellusOutputLobes,
}

/// The message names the query.
fn of_query<T>(i: usize, result: Result<T, Failure>) -> Result<T, Failure> {
    result.map_err(|failure| failure.of_query(i))
}

/// ω_o and the offsets, checked.
enum Hits {
    /// Of the near field.
    Near(Numbers<3>, Numbers<1>),
    /// With windows.
    Windows(Numbers<3>, Numbers<2>),
}

impl Hits {
    /// # Safety
    /// As for [`Numbers::new`].
    unsafe fn new(queries: &VellusQueries) -> Result<Self, Failure> {
        let VellusQueries { count, wo, h, window, .. } = *queries;
        // SAFETY: promised by the caller.
        let wo = unsafe { Numbers::new(wo, "queries.wo", count) }?;
        match (h.data.is_null(), window.data.is_null()) {
            (false, true) => {
                // SAFETY: promised by the caller.
                let h = unsafe { Numbers::new(h, "queries.h", count) }?;
                for i in 0..count {
                    of_query(i, direction(wo.get(i), "wo"))?;
                    let [offset] = h.get(i);
                    if !offset.is_finite() {
                        return of_query(i, Err(Failure::range(format!("h = {offset} is not finite"))));
                    }
                }
                Ok(Hits::Near(wo, h))
            }
            (true, false) => {
                // SAFETY: promised by the caller.
                let window = unsafe { Numbers::new(window, "queries.window", count) }?;
                for i in 0..count {
                    of_query(i, direction(wo.get(i), "wo"))?;
                    of_query(i, checked_window(window.get(i)))?;
                }
                Ok(Hits::Windows(wo, window))
            }
            (true, true) => {
                Err(Failure::new(VellusStatus::Null, "both queries.h and queries.window are null pointers"))
            }
            (false, false) => Err(Failure::range("give either queries.h or queries.window, not both")),
        }
    }
}

#[inline]
fn checked_window([low, high]: [f32; 2]) -> Result<Window, Failure> {
    VellusWindow { low, high }.checked()
}

/// # Safety
/// As for [`Numbers::new`].
unsafe fn directions(queries: &VellusQueries) -> Result<Numbers<3>, Failure> {
    // SAFETY: promised by the caller.
    let wi = unsafe { Numbers::new(queries.wi, "queries.wi", queries.count) }?;
    (0..queries.count).try_for_each(|i| of_query(i, direction(wi.get(i), "wi").map(|_| ())))?;
    Ok(wi)
}

/// # Safety
/// As for [`Numbers::new`].
unsafe fn uniforms(queries: &VellusQueries) -> Result<Numbers<5>, Failure> {
    // SAFETY: promised by the caller.
    let u = unsafe { Numbers::new(queries.u, "queries.u", queries.count) }?;
    (0..queries.count).try_for_each(|i| of_query(i, uniform(u.get(i)).map(|_| ())))?;
    Ok(u)
}

/// The places of [`VellusValues`], checked.
struct Values {
    rgb: Places<f32, 3>,
    pdf: Places<f32, 1>,
    lobes: Places<f32, { 3 * VELLUS_LOBES }>,
}

impl Values {
    /// # Safety
    /// As for [`Places::new`].
    unsafe fn new(values: &VellusValues, count: usize) -> Result<Self, Failure> {
        let VellusValues { rgb, pdf, lobes } = values;
        // SAFETY: promised by the caller.
        let places = unsafe {
            Values {
                rgb: Places::new(rgb.data, rgb.stride, "values.rgb", count)?,
                pdf: Places::new(pdf.data, pdf.stride, "values.pdf", count)?,
                lobes: Places::new(lobes.data, lobes.stride, "values.lobes", count)?,
            }
        };
        if places.rgb.wanted() || places.pdf.wanted() || places.lobes.wanted() {
            return Ok(places);
        }
        Err(Failure::new(VellusStatus::Null, "all pointers of values are null pointers"))
    }

    #[inline]
    fn set(&self, i: usize, lobes: &Lobes, pdf: f32) {
        self.rgb.set(i, lobes.total());
        self.pdf.set(i, [pdf]);
        if self.lobes.wanted() {
            self.lobes.set(i, std::array::from_fn(|k| lobes.0[k / 3][k % 3]));
        }
    }

    #[inline]
    fn set_eight(&self, first: usize, lobes: &Lobes<f32x8>, pdf: f32x8) {
        if self.rgb.wanted() {
            let total = lobes.total().map(f32x8::to_array);
            (0..8).for_each(|lane| self.rgb.set(first + lane, total.map(|channel| channel[lane])));
        }
        if self.pdf.wanted() {
            let pdf = pdf.to_array();
            (0..8).for_each(|lane| self.pdf.set(first + lane, [pdf[lane]]));
        }
        if self.lobes.wanted() {
            let lobes = lobes.0.map(|lobe| lobe.map(f32x8::to_array));
            for lane in 0..8 {
                self.lobes.set(first + lane, std::array::from_fn(|k| lobes[k / 3][k % 3][lane]));
            }
        }
    }
}

/// The places of [`VellusSamples`], checked.
struct Samples {
    wi: Places<f32, 3>,
    pdf: Places<f32, 1>,
    weight: Places<f32, 3>,
    lobe: Places<i32, 1>,
}

impl Samples {
    /// # Safety
    /// As for [`Places::new`].
    unsafe fn new(samples: &VellusSamples, count: usize) -> Result<Self, Failure> {
        let VellusSamples { wi, pdf, weight, lobe } = samples;
        // SAFETY: promised by the caller.
        let places = unsafe {
            Samples {
                wi: Places::new(wi.data, wi.stride, "samples.wi", count)?,
                pdf: Places::new(pdf.data, pdf.stride, "samples.pdf", count)?,
                weight: Places::new(weight.data, weight.stride, "samples.weight", count)?,
                lobe: Places::new(lobe.data, lobe.stride, "samples.lobe", count)?,
            }
        };
        if places.wi.wanted() || places.pdf.wanted() || places.weight.wanted() || places.lobe.wanted() {
            return Ok(places);
        }
        Err(Failure::new(VellusStatus::Null, "all pointers of samples are null pointers"))
    }

    #[inline]
    fn set(&self, i: usize, sample: Option<Sample>) {
        let VellusSample { wi, pdf, weight, lobe } = VellusSample::new(sample);
        self.wi.set(i, wi);
        self.pdf.set(i, [pdf]);
        self.weight.set(i, weight);
        self.lobe.set(i, [lobe]);
    }

    fn set_eight(&self, first: usize, samples: [Option<Sample>; 8]) {
        samples.into_iter().enumerate().for_each(|(lane, sample)| self.set(first + lane, sample));
    }
}

/// The first of every eight queries.
fn eights(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(8)
}

/// The numbers of [`VellusParameters`].
const FIELDS: usize = size_of::<VellusParameters>() / 4;

/// The parameters of each query, checked.
struct Fibers(Numbers<FIELDS>);

impl Fibers {
    /// # Safety
    /// As for [`Numbers::new`].
    unsafe fn new(first: *const VellusParameters, stride: usize, count: usize) -> Result<Self, Failure> {
        // SAFETY: promised by the caller.
        let fibers = Fibers(unsafe { Numbers::new(VellusInput { data: first.cast(), stride }, "parameters", count) }?);
        for i in 0..if stride == 0 { 1 } else { count } {
            let valid = fibers.get(i).fiber().and_then(|fiber| fiber.validate().map_err(Failure::from));
            of_query(i, valid)?;
        }
        Ok(fibers)
    }

    fn get(&self, i: usize) -> VellusParameters {
        // SAFETY: the struct has only numbers of four bytes, any bits are valid for them, and C has filled them in.
        unsafe { std::mem::transmute::<[f32; FIELDS], VellusParameters>(self.0.get(i)) }
    }

    /// Calls `f` with each model and its queries. Neighbours with the same parameters share one.
    fn each(&self, count: usize, mut f: impl FnMut(&Bcsdf, Range<usize>)) -> Result<(), Failure> {
        let mut first = 0;
        while first < count {
            let parameters = self.get(first);
            let end = first + (first..count).take_while(|&i| self.get(i) == parameters).count();
            f(&Bcsdf::new(&parameters.fiber()?)?, first..end);
            first = end;
        }
        Ok(())
    }
}

impl Hits {
    /// Calls `f` with the hit of a query.
    fn with<R>(&self, bcsdf: &Bcsdf, i: usize, f: impl FnOnce(&Hit) -> R) -> R {
        match self {
            Hits::Near(wo, h) => f(&bcsdf.at(wo.get(i).into(), Window::near(h.get(i)[0]))),
            Hits::Windows(wo, windows) => {
                let [low, high] = windows.get(i);
                bcsdf.with_hit(wo.get(i).into(), Window::range(low, high), f)
            }
        }
    }
}

fn eval_each(bcsdf: &Bcsdf, queries: Range<usize>, hits: &Hits, wi: &Numbers<3>, values: &Values) {
    for i in queries {
        let (lobes, pdf) = hits.with(bcsdf, i, |hit| hit.eval_pdf(wi.get(i).into()));
        values.set(i, &lobes, pdf);
    }
}

fn sample_each(bcsdf: &Bcsdf, queries: Range<usize>, hits: &Hits, u: &Numbers<5>, samples: &Samples) {
    for i in queries {
        samples.set(i, hits.with(bcsdf, i, |hit| hit.sample(u.get(i))));
    }
}

fn eval(bcsdf: &Bcsdf, count: usize, hits: &Hits, wi: &Numbers<3>, values: &Values) {
    match hits {
        Hits::Near(wo, h) => {
            for i in eights(count) {
                let [h] = h.eight(i);
                let (lobes, pdf) = bcsdf.at8(wo.eight(i), h).eval_pdf8(wi.eight(i));
                values.set_eight(i, &lobes, pdf);
            }
        }
        Hits::Windows(..) => eval_each(bcsdf, 0..count, hits, wi, values),
    }
}

fn sample(bcsdf: &Bcsdf, count: usize, hits: &Hits, u: &Numbers<5>, samples: &Samples) {
    match hits {
        Hits::Near(wo, h) => {
            for i in eights(count) {
                let ([h], [u0, u1, u2, u3, _]) = (h.eight(i), u.eight(i));
                samples.set_eight(i, bcsdf.at8(wo.eight(i), h).sample8([u0, u1, u2, u3]));
            }
        }
        Hits::Windows(..) => sample_each(bcsdf, 0..count, hits, u, samples),
    }
}

/// f·cos θᵢ and density of many queries of one fibre, each with its own hit. All input is checked before the first
/// result is written. With `h` it takes eight queries at once: the bits are those of Bcsdf::at8 and NearHit::eval_pdf8
/// in Rust, and may differ in the last ones from single queries. They do not depend on a query's place in the array.
/// With `window` they are those of single queries. The call uses one thread; divide an array to use more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_eval_array(
    fiber: *const VellusFiber,
    queries: *const VellusQueries,
    values: *const VellusValues,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (fiber, queries, values) =
            unsafe { (reference(fiber, "fiber")?, reference(queries, "queries")?, reference(values, "values")?) };
        if queries.count == 0 {
            return Ok(());
        }
        // SAFETY: the rules of the crate.
        let (hits, wi, values) =
            unsafe { (Hits::new(queries)?, directions(queries)?, Values::new(values, queries.count)?) };
        eval(&fiber.bcsdf, queries.count, &hits, &wi, &values);
        Ok(())
    })
}

/// Draws a direction for each of many hits of one fibre. As vellus_fiber_eval_array(): with `h` the bits are those of
/// Bcsdf::at8 and NearHit::sample8 in Rust, with `window` those of single samples.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_sample_array(
    fiber: *const VellusFiber,
    queries: *const VellusQueries,
    samples: *const VellusSamples,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (fiber, queries, samples) =
            unsafe { (reference(fiber, "fiber")?, reference(queries, "queries")?, reference(samples, "samples")?) };
        if queries.count == 0 {
            return Ok(());
        }
        // SAFETY: the rules of the crate.
        let (hits, u, samples) =
            unsafe { (Hits::new(queries)?, uniforms(queries)?, Samples::new(samples, queries.count)?) };
        sample(&fiber.bcsdf, queries.count, &hits, &u, &samples);
        Ok(())
    })
}

/// f·cos θᵢ and density of many queries, each with its own fibre and its own hit. `parameters` points to those of the
/// first query, and those of query i are `i * stride` bytes further on. A stride of 0 gives all queries the same. All
/// input is checked before the first result is written. The bits are those of single queries. Neighbours with the same
/// parameters share the work of a fibre, so sort queries by fibre.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameters_eval_array(
    parameters: *const VellusParameters,
    stride: usize,
    queries: *const VellusQueries,
    values: *const VellusValues,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (queries, values) = unsafe { (reference(queries, "queries")?, reference(values, "values")?) };
        let count = queries.count;
        if count == 0 {
            return Ok(());
        }
        // SAFETY: the rules of the crate.
        let (fibers, hits) = unsafe { (Fibers::new(parameters, stride, count)?, Hits::new(queries)?) };
        // SAFETY: the rules of the crate.
        let (wi, values) = unsafe { (directions(queries)?, Values::new(values, count)?) };
        fibers.each(count, |bcsdf, some| eval_each(bcsdf, some, &hits, &wi, &values))
    })
}

/// Draws a direction for each of many hits, each of its own fibre. As vellus_parameters_eval_array().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_parameters_sample_array(
    parameters: *const VellusParameters,
    stride: usize,
    queries: *const VellusQueries,
    samples: *const VellusSamples,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (queries, samples) = unsafe { (reference(queries, "queries")?, reference(samples, "samples")?) };
        let count = queries.count;
        if count == 0 {
            return Ok(());
        }
        // SAFETY: the rules of the crate.
        let (fibers, hits) = unsafe { (Fibers::new(parameters, stride, count)?, Hits::new(queries)?) };
        // SAFETY: the rules of the crate.
        let (u, samples) = unsafe { (uniforms(queries)?, Samples::new(samples, count)?) };
        fibers.each(count, |bcsdf, some| sample_each(bcsdf, some, &hits, &u, &samples))
    })
}

/// f·cos θᵢ and density of many directions `wi` of one hit. The bits are those of Hit::eval_pdf8 in Rust.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_eval_array(
    hit: *const VellusHit,
    queries: *const VellusQueries,
    values: *const VellusValues,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (hit, queries, values) =
            unsafe { (reference(hit, "hit")?, reference(queries, "queries")?, reference(values, "values")?) };
        if queries.count == 0 {
            return Ok(());
        }
        // SAFETY: the rules of the crate.
        let (wi, values) = unsafe { (directions(queries)?, Values::new(values, queries.count)?) };
        for i in eights(queries.count) {
            let (lobes, pdf) = hit.hit.eval_pdf8(wi.eight(i));
            values.set_eight(i, &lobes, pdf);
        }
        Ok(())
    })
}

/// Draws many directions of one hit. The bits are those of Hit::sample8 in Rust.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_sample_array(
    hit: *const VellusHit,
    queries: *const VellusQueries,
    samples: *const VellusSamples,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (hit, queries, samples) =
            unsafe { (reference(hit, "hit")?, reference(queries, "queries")?, reference(samples, "samples")?) };
        if queries.count == 0 {
            return Ok(());
        }
        // SAFETY: the rules of the crate.
        let (u, samples) = unsafe { (uniforms(queries)?, Samples::new(samples, queries.count)?) };
        eights(queries.count).for_each(|i| samples.set_eight(i, hit.hit.sample8(u.eight(i))));
        Ok(())
    })
}
