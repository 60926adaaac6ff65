//! A path tracer for the scenes of vellus-render: kernels that follow each sample from the camera to the lights, one
//! ray at a time.

mod source;

use crate::choice::{failed, refused};
use crate::device::Device;
use crate::library::{shader_far_table, shader_fiber, shader_tables};
use bytemuck::NoUninit;
use source::{Array, FIXED, KERNELS, STATE_BYTES};
use std::time::{Duration, Instant};
use vellus::Bcsdf;
use vellus::packed::FIBER_ROWS;
use vellus_render::packed::{PackedScene, SampleTracer};
use vellus_render::{Error, Layout, Mode, Settings, World};

/// Threads in a workgroup of the shader.
const GROUP: u64 = 64;
/// The most samples in one run: 65535 workgroups are the limit of every GPU.
const MOST_SAMPLES: u64 = 65_535 * GROUP;
/// The most bytes of results, and of paths that wait, in one run.
const MOST_BYTES: u64 = 1 << 28;
/// Rays of each path before the tracer asks how many paths are left.
const ROUNDS: usize = 8;
/// The duration of one run that the tracer aims at. Desktop systems reset a GPU that does not answer for seconds.
const RUN: Duration = Duration::from_millis(150);

/// The most different fibres with tables of the far field, which have up to 18 MB each.
const MOST_TABLES: usize = 64;

/// Tables begin at multiples of this number of rows.
const TABLE_STEP: usize = 16;

/// A scene on a GPU, ready to be traced with some settings and layers.
///
/// A hit uses the near field at its offset, or at a random offset of its window: the mean of the window is the same.
/// The whole width is a table of the far field instead, if there are at most 64 different fibres. The random numbers
/// are of the same kind as those of the processor, but not the same numbers. So pictures of both devices agree within
/// their noise, and have different bits. Pictures of the same device and driver have the same bits.
pub struct Tracer {
    device: Device,
    pipelines: [wgpu::ComputePipeline; KERNELS.len()],
    buffers: Vec<wgpu::Buffer>,
    words: u64,
    state_bytes: u64,
    /// The paths that wait, and the lists of them. They grow with the largest run.
    waiting: Option<[wgpu::Buffer; 2]>,
    /// Samples that the last runs traced in [`RUN`].
    pace: u64,
}

impl std::fmt::Debug for Tracer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tracer").field("device", &self.device.name()).field("pace", &self.pace).finish_non_exhaustive()
    }
}

impl Tracer {
    /// Copies a scene to the GPU.
    ///
    /// # Errors
    /// [`Error::Device`] if [`World::packed`] refuses the scene, if it does not fit, or if the GPU refuses the shader.
    pub fn new(device: &Device, world: &World, settings: &Settings, layout: &Layout) -> Result<Self, Error> {
        let scene = world.packed(settings, layout).map_err(refused)?;
        let models = scene.fibers.iter().map(Bcsdf::new).collect::<Result<Vec<_>, _>>();
        let models = models.map_err(|e| device_error(&e.to_string()))?;
        let fibers: Vec<[f32; 4]> = models.iter().flat_map(shader_fiber).collect();
        let far = has_tables(settings.mode, models.len()).then(|| far_tables(&models));
        let limit = device.limit();
        let arrays = arrays(&scene, limit);
        let far_array = far.as_ref().map(|far| Array::new("vellus_far_row", "f32", far.len(), limit));
        let parts = arrays.iter().chain(&far_array).map(Array::parts).sum::<usize>();
        device.check_buffers(FIXED.len() + parts).map_err(failed)?;
        let source = source::shader(&arrays, settings.mode, far_array.as_ref(), &scene.features, scene.stack);
        let writes = [&FIXED[..], &vec![false; parts]].concat();
        let pipelines = device.compile(&source, KERNELS, &writes).map_err(failed)?;
        let mut buffers = vec![device.upload(&shader_tables()).map_err(failed)?];
        let [nodes, chords, triangles, points, data, records] = &arrays;
        upload(device, nodes, &scene.nodes, &mut buffers)?;
        upload(device, chords, &scene.chords, &mut buffers)?;
        upload(device, triangles, &scene.triangles, &mut buffers)?;
        upload(device, points, &scene.points, &mut buffers)?;
        upload(device, data, &scene.data, &mut buffers)?;
        upload(device, records, &fibers, &mut buffers)?;
        if let (Some(array), Some(far)) = (&far_array, &far) {
            upload(device, array, far, &mut buffers)?;
        }
        let words = scene.sample_words as u64;
        device.alive().map_err(failed)?;
        let state_bytes = STATE_BYTES[usize::from(scene.features.contains(&("HAS_LOBES", true)))];
        Ok(Tracer { device: device.clone(), pipelines, buffers, words, state_bytes, waiting: None, pace: 4096 })
    }
}

/// The arrays of a scene, split at `limit` bytes.
fn arrays(scene: &PackedScene, limit: u64) -> [Array; 6] {
    [
        Array::new("node_row", "u32", scene.nodes.len(), limit),
        Array::new("chord_row", "u32", scene.chords.len(), limit),
        Array::new("triangle_row", "u32", scene.triangles.len(), limit),
        Array::new("point_row", "f32", scene.points.len(), limit),
        Array::new("data_row", "u32", scene.data.len(), limit),
        Array::new("vellus_row", "f32", FIBER_ROWS * scene.fibers.len(), limit),
    ]
}

/// The shader with which a [`Tracer`] renders a scene, in WGSL: for compilers that count its registers.
///
/// # Errors
/// [`Error::Device`] if [`World::packed`] refuses the scene.
pub fn tracer_shader(world: &World, settings: &Settings, layout: &Layout) -> Result<String, Error> {
    let scene = world.packed(settings, layout).map_err(refused)?;
    // The limit of most GPUs. The number of rows of the far field changes nothing else.
    let limit = 1 << 30;
    let far = has_tables(settings.mode, scene.fibers.len()).then(|| Array::new("vellus_far_row", "f32", 1, limit));
    Ok(source::shader(&arrays(&scene, limit), settings.mode, far.as_ref(), &scene.features, scene.stack))
}

/// Whether hits take the far field from tables, of this many fibres.
fn has_tables(mode: Mode, fibers: usize) -> bool {
    mode != Mode::Near && fibers <= MOST_TABLES
}

/// The tables of all fibres, after rows with the first row of each.
fn far_tables(models: &[Bcsdf<'_>]) -> Vec<[f32; 4]> {
    let mut rows = vec![[0.0; 4]; models.len().div_ceil(4)];
    for (k, model) in models.iter().enumerate() {
        // Single precision has all whole numbers up to 2²⁴. 64 tables have at most 73 million rows, so their number in
        // steps of 16 rows is exact.
        rows.resize(rows.len().next_multiple_of(TABLE_STEP), [0.0; 4]);
        rows[k / 4][k % 4] = (rows.len() / TABLE_STEP) as f32;
        rows.extend(shader_far_table(model));
    }
    rows
}

fn device_error(what: &str) -> Error {
    Error::Device(what.to_owned())
}

/// Copies an array in its parts.
fn upload<T: NoUninit>(
    device: &Device,
    array: &Array,
    rows: &[[T; 4]],
    buffers: &mut Vec<wgpu::Buffer>,
) -> Result<(), Error>
where
    [T; 4]: NoUninit + Default,
{
    for part in 0..array.parts() {
        let rows = rows.get(array.rows_of(part, rows.len())).unwrap_or(&[]);
        // A buffer must not be empty.
        let buffer = if rows.is_empty() { device.upload(&[<[T; 4]>::default()]) } else { device.upload(rows) };
        buffers.push(buffer.map_err(failed)?);
    }
    Ok(())
}

impl SampleTracer for Tracer {
    fn samples_at_once(&self) -> usize {
        self.pace.min(self.room()) as usize
    }

    fn trace(&mut self, samples: &[[u32; 2]]) -> Result<Vec<u32>, Error> {
        let mut words = Vec::with_capacity(samples.len() * self.words as usize);
        for samples in samples.chunks(self.room() as usize) {
            let start = Instant::now();
            let count = samples.len() as u64;
            let output = self.device.results(4 * count * self.words).map_err(failed)?;
            let [states, lists] =
                match self.waiting.take().filter(|[states, _]| states.size() >= self.state_bytes * count) {
                    Some(waiting) => waiting,
                    None => [
                        self.device.results(self.state_bytes * count).map_err(failed)?,
                        self.device.results(3 * 4 * count).map_err(failed)?,
                    ],
                };
            let counts = self.device.results(4 * 4).map_err(failed)?;
            let work = self.device.upload(samples).map_err(failed)?;
            let mut buffers: Vec<&wgpu::Buffer> = vec![&output, &states, &lists, &counts, &work];
            buffers.extend(&self.buffers);
            let [begin, trace, empty, strands, others] = &self.pipelines;
            let groups = |count: u64| count.div_ceil(GROUP) as u32;
            self.device.run(&[(begin, groups(count))], &buffers);
            let mut left = count;
            while left > 0 {
                let groups = groups(left);
                let round = [(trace, groups), (empty, 1), (strands, groups), (others, groups), (empty, 1)];
                self.device.run(&[round; ROUNDS].concat(), &buffers);
                left = self.device.download::<u32>(&counts).map_err(failed)?[0].into();
            }
            words.extend(self.device.download::<u32>(&output).map_err(failed)?);
            self.waiting = Some([states, lists]);
            let ratio = RUN.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-4);
            self.pace = ((count as f64 * ratio.clamp(0.25, 4.0)) as u64).max(64);
        }
        Ok(words)
    }
}

impl Tracer {
    /// The most samples of one run.
    fn room(&self) -> u64 {
        let bytes = (4 * self.words).max(self.state_bytes);
        MOST_SAMPLES.min(MOST_BYTES.min(self.device.limit()) / bytes).max(1)
    }
}
