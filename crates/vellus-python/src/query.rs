//! Queries of a model for whole arrays, in chunks on all cores.
//!
//! Near-field queries run in groups of eight. Whatever the number of threads, each query has the same neighbours in its
//! chunk, and no query depends on its neighbours: the results are the same bits.

use crate::arrays::Rows;
use crate::output::{Output, split, store};
use crate::threads::{self, Watch};
use crate::varying::Varying;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use vellus::glam::Vec3;
use vellus::wide::f32x8;
use vellus::{Bcsdf, Fiber, Hit, Lobes, Model, NearHit, Sample, Scattering, Window};

/// Queries of a chunk: enough to hide the cost of sharing work, and few enough for the processor's cache.
const CHUNK: usize = 512;

/// From this many queries with the same hit on, the hit is prepared once for all of them.
const SHARED: usize = 8;

/// Fewer near-field queries of a fibre than this are answered one by one.
const FEW: usize = 4;

/// How far the squared length of a unit vector may be from 1, as for `vellus::Bcsdf::at`.
const UNIT: f32 = 1e-3;

/// How far an offset may be outside its range, for rounding. It is then clamped.
pub const SLACK: f32 = 1e-3;

/// A model, and how to make it for another fibre.
pub type Of<'m, B> = (&'m B, &'m (dyn Fn(&Fiber) -> Result<B, vellus::Error> + Sync));

/// A model that prepares eight near-field hits at once.
pub trait Batch: Model {
    /// Eight hits.
    type Hit8<'a>
    where
        Self: 'a;

    fn at8(&self, wo: [f32x8; 3], h: f32x8) -> Self::Hit8<'_>;
    fn eval8(hit: &Self::Hit8<'_>, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8);
    fn energy8(hit: &Self::Hit8<'_>) -> Lobes<f32x8>;
    fn sample8(hit: &Self::Hit8<'_>, u: [f32x8; 5]) -> [Option<Sample>; 8];
    /// Eight queries of one hit.
    fn eval8_of(hit: &Self::Hit<'_>, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8);
}

impl Batch for Bcsdf<'static> {
    type Hit8<'a> = NearHit<'a>;

    #[inline(always)]
    fn at8(&self, wo: [f32x8; 3], h: f32x8) -> NearHit<'_> {
        self.at8(wo, h)
    }

    #[inline(always)]
    fn eval8(hit: &NearHit<'_>, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
        hit.eval_pdf8(wi)
    }

    fn energy8(hit: &NearHit<'_>) -> Lobes<f32x8> {
        hit.energy()
    }

    fn sample8(hit: &NearHit<'_>, [a, b, c, d, _]: [f32x8; 5]) -> [Option<Sample>; 8] {
        hit.sample8([a, b, c, d])
    }

    fn eval8_of(hit: &Hit<'_>, wi: [f32x8; 3]) -> (Lobes<f32x8>, f32x8) {
        hit.eval_pdf8(wi)
    }
}

/// What to compute, and how many numbers it has for each query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// f·cos θᵢ: RGB, or RGB of six lobes.
    Eval { lobes: bool },
    /// The density.
    Pdf,
    /// Both, the density last.
    EvalPdf { lobes: bool },
    /// The energy: RGB, or RGB of six lobes.
    Energy { lobes: bool },
    /// ω_i, the density, the weight, the lobe.
    Sample,
}

impl Task {
    /// Numbers of each result.
    pub fn columns(self) -> usize {
        match self {
            Task::Pdf => 1,
            Task::EvalPdf { lobes } => 1 + colors(lobes),
            Task::Eval { lobes } | Task::Energy { lobes } => colors(lobes),
            Task::Sample => 8,
        }
    }
}

impl Task {
    /// The column of the density.
    fn density(self) -> Option<usize> {
        match self {
            Task::Pdf => Some(0),
            Task::EvalPdf { lobes } => Some(colors(lobes)),
            _ => None,
        }
    }
}

/// Numbers of a value: RGB, or RGB of six lobes.
pub fn colors(lobes: bool) -> usize {
    if lobes { 18 } else { 3 }
}

/// The lobe of a query that drew nothing.
const NOTHING: f32 = -1.0;

/// The arguments of a batch, broadcast to `shape`.
pub struct Batches<'a> {
    pub shape: Vec<usize>,
    pub wo: Rows<'a>,
    /// One offset, or the two ends of a window.
    pub window: Rows<'a>,
    /// What changes from query to query of a hit: ω_i, or the uniform numbers. Nothing for the energy.
    pub query: Option<Rows<'a>>,
    /// Parameters of the fibre that change from query to query.
    pub varying: Option<Varying<'a>>,
    /// Whether to check lengths and ranges.
    pub check: bool,
}

/// A bad number in an array.
pub struct Bad {
    pub position: usize,
    pub message: String,
}

impl Batches<'_> {
    /// Computes all queries into the outputs.
    ///
    /// # Errors
    /// `ValueError` for the first bad number. What a signal handler raises.
    pub fn run<B: Batch>(&self, py: Python<'_>, model: &Of<'_, B>, task: Task, outputs: &[Output<'_>]) -> PyResult<()> {
        let total: usize = self.shape.iter().product();
        if total == 0 {
            return Ok(());
        }
        let mut borrowed = outputs.iter().map(Output::borrow).collect::<PyResult<Vec<_>>>()?;
        let mut slices = Vec::new();
        for (array, output) in borrowed.iter_mut().zip(outputs) {
            slices.push((array.slice()?, output.columns()));
        }
        let bad = if total <= CHUNK {
            let mut work = py.detach(|| self.chunk(model, task, 0, total));
            match &mut work {
                Ok(results) => {
                    store(results, total, &mut slices);
                    None
                }
                Err(_) => work.err(),
            }
        } else {
            let parts = split(slices, total, CHUNK);
            threads::run(py, |watch: &Watch| {
                let parts = parts.into_par_iter().enumerate();
                let bad = parts.filter_map(|(i, mut slices)| {
                    if watch.is_stopped() {
                        return None;
                    }
                    let start = i * CHUNK;
                    let count = CHUNK.min(total - start);
                    match self.chunk(model, task, start, count) {
                        Ok(results) => {
                            store(&results, count, &mut slices);
                            None
                        }
                        Err(bad) => Some(bad),
                    }
                });
                bad.min_by_key(|bad| bad.position)
            })?
        };
        bad.map_or(Ok(()), |bad| Err(PyValueError::new_err(bad.message)))
    }

    /// The results of `count` queries from `start` on, column by column.
    fn chunk<B: Batch>(
        &self,
        (model, remake): &Of<'_, B>,
        task: Task,
        start: usize,
        count: usize,
    ) -> Result<Vec<f32>, Bad> {
        let gather = |rows: &Rows<'_>| {
            let mut columns = vec![0.0f32; rows.width * count];
            rows.gather(&self.shape, start, count, &mut columns);
            columns
        };
        let mut wo = gather(&self.wo);
        let mut window = gather(&self.window);
        let mut query = self.query.as_ref().map(gather).unwrap_or_default();
        if self.check {
            self.check_unit(&self.wo, &wo, start)?;
            self.check_offsets(&window, start)?;
            match (&self.query, task) {
                (Some(rows), Task::Sample) => self.check_uniform(rows, &query, start)?,
                (Some(rows), _) => self.check_unit(rows, &query, start)?,
                (None, _) => {}
            }
        }
        let mut absent = absent(count, &mut wo, &mut window, &mut query);
        if task == Task::Sample {
            // Numbers just below 1 may be rounded to 1.
            query.iter_mut().for_each(|u| *u = u.min(1.0f32.next_down()));
        }
        let mut results = vec![0.0; task.columns() * count];
        let inputs = Inputs { wo: &wo, window: &window, query: &query, count, width: self.window.width };
        match &self.varying {
            None => self.compute(*model, task, &inputs, [0, count], start, &mut results),
            Some(varying) => {
                let varying = varying.gather(&self.shape, start, count);
                let mut first = 0;
                while first < count {
                    let end = varying.end(first);
                    let model = remake(&varying.fiber(first)?);
                    let position = start + first;
                    let model = model.map_err(|error| Bad { position, message: error.to_string() })?;
                    self.compute(&model, task, &inputs, [first, end], start, &mut results);
                    first = end;
                }
                absent.extend(varying.absent());
            }
        }
        for i in absent {
            results.iter_mut().skip(i).step_by(count).for_each(|x| *x = f32::NAN);
            if task == Task::Sample {
                results[7 * count + i] = NOTHING;
            }
        }
        Ok(results)
    }

    /// The queries of one fibre.
    fn compute<B: Batch>(
        &self,
        model: &B,
        task: Task,
        inputs: &Inputs<'_>,
        [mut first, end]: [usize; 2],
        start: usize,
        results: &mut [f32],
    ) {
        let count = inputs.count;
        let run = self.wo.run(&self.shape).min(self.window.run(&self.shape));
        while first < end {
            // Up to where the hit stays the same.
            let same = (run - (start + first) % run).min(end - first);
            match (inputs.width, run >= SHARED) {
                (1, true) => {
                    let hit = model.at8(inputs.splat(first), f32x8::splat(inputs.window[first]));
                    for at in (first..first + same).step_by(8) {
                        inputs.near::<B>(task, &hit, at, (first + same - at).min(8), results);
                    }
                    first += same;
                }
                // Eight lanes for a query or two cost more than single ones.
                (1, false) if end - first < FEW => {
                    let window = Window::near(inputs.window[first]);
                    model.with_hit(inputs.vector(first), window, |hit| {
                        inputs.wide::<B>(task, hit, [first, first + 1], false, results);
                    });
                    first += 1;
                }
                (1, false) => {
                    let lanes = (end - first).min(8);
                    let hit = model.at8(eight(inputs.wo, count, first, lanes), inputs.offsets(first, lanes));
                    inputs.near::<B>(task, &hit, first, lanes, results);
                    first += lanes;
                }
                (_, shared) => {
                    let window = Window::range(inputs.window[first], inputs.window[count + first]);
                    model.with_hit(inputs.vector(first), window, |hit| {
                        inputs.wide::<B>(task, hit, [first, first + same], shared, results);
                    });
                    first += same;
                }
            }
        }
    }

    fn check_unit(&self, rows: &Rows<'_>, columns: &[f32], start: usize) -> Result<(), Bad> {
        let count = columns.len() / 3;
        let [x, y, z] = [0, 1, 2].map(|c| &columns[c * count..][..count]);
        let squared = |i: usize| x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        // Not a number is no error. All lengths are compared without a branch, several at a time.
        let is_bad = |i: usize| (squared(i) - 1.0).abs() >= UNIT;
        if !(0..count).fold(false, |any, i| any | is_bad(i)) {
            return Ok(());
        }
        match (0..count).position(is_bad) {
            None => Ok(()),
            Some(i) => {
                let position = start + i;
                let index = rows.index(&self.shape, position);
                let length = squared(i).sqrt();
                Err(Bad { position, message: format!("{index} has the length {length}: it must be a unit vector") })
            }
        }
    }

    fn check_offsets(&self, columns: &[f32], start: usize) -> Result<(), Bad> {
        self.check_range(&self.window, columns, start, |h| h.abs() > 1.0 + SLACK, "[-1, 1]")
    }

    fn check_uniform(&self, rows: &Rows<'_>, columns: &[f32], start: usize) -> Result<(), Bad> {
        self.check_range(rows, columns, start, |u| !(0.0..=1.0).contains(&u) && !u.is_nan(), "[0, 1)")
    }

    fn check_range(
        &self,
        rows: &Rows<'_>,
        columns: &[f32],
        start: usize,
        is_bad: impl Fn(f32) -> bool,
        range: &str,
    ) -> Result<(), Bad> {
        if !columns.iter().fold(false, |any, x| any | is_bad(*x)) {
            return Ok(());
        }
        let count = columns.len() / rows.width;
        let Some(i) = (0..count).find(|i| (0..rows.width).any(|c| is_bad(columns[c * count + i]))) else {
            return Ok(());
        };
        let position = start + i;
        let index = rows.index(&self.shape, position);
        let value = (0..rows.width).map(|c| columns[c * count + i]).find(|x| is_bad(*x)).unwrap_or(f32::NAN);
        Err(Bad { position, message: format!("{index} = {value} is out of range: it must be in {range}") })
    }
}

/// The queries with a NaN. They get numbers that are safe to compute with.
fn absent(count: usize, wo: &mut [f32], window: &mut [f32], query: &mut [f32]) -> Vec<usize> {
    let is_clean = |columns: &[f32]| columns.iter().fold(true, |all, x| all & x.is_finite());
    if is_clean(wo) && is_clean(window) && is_clean(query) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for i in 0..count {
        let has = |columns: &[f32]| columns.iter().skip(i).step_by(count).any(|x| !x.is_finite());
        if has(wo) || has(window) || has(query) {
            found.push(i);
            for columns in [&mut *wo, &mut *window, &mut *query] {
                columns.iter_mut().skip(i).step_by(count).for_each(|x| *x = 0.0);
            }
            wo[count + i] = 1.0;
            if query.len() == 3 * count {
                query[count + i] = 1.0;
            }
        }
    }
    found
}

/// Numbers of the lanes from `first` on. Lanes without a query repeat the last one.
#[inline(always)]
fn eight<const N: usize>(columns: &[f32], count: usize, first: usize, lanes: usize) -> [f32x8; N] {
    std::array::from_fn(|c| {
        let column = &columns[c * count + first..][..lanes];
        match column.first_chunk::<8>() {
            Some(all) => f32x8::new(*all),
            None => f32x8::new(std::array::from_fn(|i| column[i.min(lanes - 1)])),
        }
    })
}

/// The numbers of a chunk, column by column.
struct Inputs<'a> {
    wo: &'a [f32],
    window: &'a [f32],
    query: &'a [f32],
    count: usize,
    /// 1 for offsets, 2 for windows.
    width: usize,
}

impl Inputs<'_> {
    fn vector(&self, i: usize) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|c| self.wo[c * self.count + i]))
    }

    fn splat(&self, i: usize) -> [f32x8; 3] {
        self.vector(i).to_array().map(f32x8::splat)
    }

    fn offsets(&self, first: usize, lanes: usize) -> f32x8 {
        let [h] = eight(self.window, self.count, first, lanes);
        h
    }

    /// Eight near-field queries.
    #[inline(always)]
    fn near<B: Batch>(&self, task: Task, hit: &B::Hit8<'_>, first: usize, lanes: usize, results: &mut [f32]) {
        let count = self.count;
        match task {
            Task::Eval { lobes: false } => {
                // Without the lobes and the density, which the compiler then leaves out.
                let total = B::eval8(hit, eight(self.query, count, first, lanes)).0.total();
                total.iter().enumerate().for_each(|(c, x)| put(*x, c * count + first, lanes, results));
            }
            Task::Eval { .. } | Task::Pdf | Task::EvalPdf { .. } => {
                let result = B::eval8(hit, eight(self.query, count, first, lanes));
                put_both(task, result, count, first, lanes, results);
            }
            Task::Energy { lobes } => put_values(&B::energy8(hit), lobes, count, first, lanes, results),
            Task::Sample => {
                let drawn = B::sample8(hit, self.uniform(first, lanes));
                drawn.iter().take(lanes).enumerate().for_each(|(i, s)| put_sample(s, count, first + i, results));
            }
        }
    }

    /// Five uniform numbers. The near field may leave out the last.
    fn uniform(&self, first: usize, lanes: usize) -> [f32x8; 5] {
        let [a, b, c, d] = eight(self.query, self.count, first, lanes);
        let e = if self.query.len() > 4 * self.count {
            eight(&self.query[4 * self.count..], self.count, first, lanes)
        } else {
            [f32x8::ZERO]
        };
        [a, b, c, d, e[0]]
    }

    /// The queries of one hit with a window.
    fn wide<B: Batch>(
        &self,
        task: Task,
        hit: &B::Hit<'_>,
        [first, end]: [usize; 2],
        shared: bool,
        results: &mut [f32],
    ) {
        let count = self.count;
        match task {
            Task::Eval { .. } | Task::Pdf | Task::EvalPdf { .. } if shared => {
                for at in (first..end).step_by(8) {
                    let lanes = (end - at).min(8);
                    let result = B::eval8_of(hit, eight(self.query, count, at, lanes));
                    put_both(task, result, count, at, lanes, results);
                }
            }
            Task::Eval { .. } | Task::Pdf | Task::EvalPdf { .. } => {
                for i in first..end {
                    let wi = Vec3::from_array([0, 1, 2].map(|c| self.query[c * count + i]));
                    let (f, pdf) = hit.eval_pdf(wi);
                    if let Task::Eval { lobes } | Task::EvalPdf { lobes } = task {
                        put_one(&f, lobes, count, i, results);
                    }
                    if let Some(column) = task.density() {
                        results[column * count + i] = pdf;
                    }
                }
            }
            Task::Energy { lobes } => {
                let energy = hit.energy();
                (first..end).for_each(|i| put_one(&energy, lobes, count, i, results));
            }
            Task::Sample => {
                for i in first..end {
                    let u = self.uniform(i, 1).map(|u| u.to_array()[0]);
                    put_sample(&hit.sample(u), count, i, results);
                }
            }
        }
    }
}

#[inline(always)]
fn put(x: f32x8, at: usize, lanes: usize, results: &mut [f32]) {
    results[at..at + lanes].copy_from_slice(&x.to_array()[..lanes]);
}

/// Values, density, or both.
#[inline(always)]
fn put_both(
    task: Task,
    (f, pdf): (Lobes<f32x8>, f32x8),
    count: usize,
    first: usize,
    lanes: usize,
    results: &mut [f32],
) {
    if let Task::Eval { lobes } | Task::EvalPdf { lobes } = task {
        put_values(&f, lobes, count, first, lanes, results);
    }
    if let Some(column) = task.density() {
        put(pdf, column * count + first, lanes, results);
    }
}

#[inline(always)]
fn put_values(f: &Lobes<f32x8>, lobes: bool, count: usize, first: usize, lanes: usize, results: &mut [f32]) {
    if lobes {
        f.0.iter().flatten().enumerate().for_each(|(c, x)| put(*x, c * count + first, lanes, results));
    } else {
        f.total().iter().enumerate().for_each(|(c, x)| put(*x, c * count + first, lanes, results));
    }
}

fn put_one(f: &Lobes, lobes: bool, count: usize, i: usize, results: &mut [f32]) {
    if lobes {
        f.0.iter().flatten().enumerate().for_each(|(c, x)| results[c * count + i] = *x);
    } else {
        f.total().iter().enumerate().for_each(|(c, x)| results[c * count + i] = *x);
    }
}

fn put_sample(sample: &Option<Sample>, count: usize, i: usize, results: &mut [f32]) {
    let numbers = match sample {
        Some(Sample { wi, pdf, weight: [r, g, b], lobe }) => {
            [wi.x, wi.y, wi.z, *pdf, *r, *g, *b, f32::from(*lobe as u8)]
        }
        None => [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, NOTHING],
    };
    numbers.into_iter().enumerate().for_each(|(c, x)| results[c * count + i] = x);
}
