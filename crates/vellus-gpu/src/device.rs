//! A GPU.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use wgpu::util::DeviceExt;

/// Why a GPU cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// There is no GPU that Vulkan, Metal or DirectX 12 can use.
    #[error("no GPU was found ({0})")]
    Absent(String),
    /// The GPU refused.
    #[error("the GPU {name} cannot be used: {reason}")]
    Refused {
        /// The name of the GPU.
        name: String,
        /// What the driver said.
        reason: String,
    },
    /// A buffer is larger than the GPU allows.
    #[error("a buffer of {needed} bytes is above the limit of the GPU {name}, {limit} bytes")]
    TooSmall {
        /// The name of the GPU.
        name: String,
        /// The size of the buffer.
        needed: u64,
        /// The largest size of a buffer.
        limit: u64,
    },
    /// A scene needs more buffers than a shader of the GPU may have.
    #[error("the scene needs {needed} buffers of at most {limit} bytes, and the GPU {name} allows {most}")]
    TooMany {
        /// The name of the GPU.
        name: String,
        /// The number of buffers.
        needed: usize,
        /// The largest size of a buffer.
        limit: u64,
        /// The largest number of buffers.
        most: usize,
    },
    /// A query names a fibre that does not exist.
    #[error("a query names fibre {index}, but there are {count}")]
    NoFiber {
        /// The index in the query.
        index: u32,
        /// The number of fibres.
        count: usize,
    },
    /// The GPU was lost, or did not answer.
    #[error("the GPU was lost: {0}")]
    Lost(String),
}

/// An open GPU. Its clones are the same GPU.
#[derive(Clone, Debug)]
pub struct Device {
    name: String,
    kind: wgpu::DeviceType,
    device: wgpu::Device,
    queue: wgpu::Queue,
    limit: u64,
    #[cfg(feature = "trace")]
    buffers: usize,
    failure: Failure,
}

/// The first failure that the driver reported outside of a call.
#[derive(Clone, Debug, Default)]
struct Failure(Arc<Mutex<Option<String>>>);

impl Failure {
    fn set(&self, what: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(what);
    }

    fn get(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// The longest time to wait for a batch of work.
const PATIENCE: Duration = Duration::from_secs(600);

impl Device {
    /// Opens the GPU that the system prefers for speed. A software implementation, such as Mesa's lavapipe, counts as a
    /// GPU, but any other has precedence. The variable `WGPU_ADAPTER_NAME` selects a GPU by a part of its name.
    ///
    /// # Errors
    /// [`DeviceError::Absent`] and [`DeviceError::Refused`].
    pub fn open() -> Result<Self, DeviceError> {
        let instance = wgpu::Instance::default();
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        if let Ok(part) = std::env::var("WGPU_ADAPTER_NAME") {
            let part = part.to_lowercase();
            adapters.retain(|adapter| adapter.get_info().name.to_lowercase().contains(&part));
        }
        // Stable: of equal kinds the first has precedence.
        adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        });
        let Some(adapter) = adapters.into_iter().next() else {
            return Err(DeviceError::Absent("no adapter for Vulkan, Metal or DirectX 12".to_owned()));
        };
        let wgpu::AdapterInfo { name, device_type: kind, .. } = adapter.get_info();
        let limits = adapter.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        #[cfg(feature = "trace")]
        let buffers = limits.max_storage_buffers_per_shader_stage as usize;
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        match pollster::block_on(adapter.request_device(&descriptor)) {
            Ok((device, queue)) => {
                let failure = Failure::default();
                let (lost, refused) = (failure.clone(), failure.clone());
                device.set_device_lost_callback(move |_, what| lost.set(what));
                // Without a handler, wgpu panics.
                device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| refused.set(e.to_string())));
                Ok(Device {
                    name,
                    kind,
                    device,
                    queue,
                    limit,
                    #[cfg(feature = "trace")]
                    buffers,
                    failure,
                })
            }
            Err(e) => Err(DeviceError::Refused { name, reason: e.to_string() }),
        }
    }

    /// The name of the GPU.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Is it a program on the processor, such as Mesa's lavapipe? Then the processor itself renders faster.
    pub fn is_software(&self) -> bool {
        self.kind == wgpu::DeviceType::Cpu
    }

    /// Gives the GPU up. All later work on it, and on its clones, fails with [`DeviceError::Lost`].
    pub fn destroy(&self) {
        self.failure.set("it was given up".to_owned());
        self.device.destroy();
    }

    /// The most bytes of a buffer.
    #[cfg(feature = "trace")]
    pub(crate) fn limit(&self) -> u64 {
        self.limit
    }

    /// Checks that a shader may have this number of buffers.
    ///
    /// # Errors
    /// [`DeviceError::TooMany`].
    #[cfg(feature = "trace")]
    pub(crate) fn check_buffers(&self, needed: usize) -> Result<(), DeviceError> {
        if needed <= self.buffers {
            return Ok(());
        }
        Err(DeviceError::TooMany { name: self.name.clone(), needed, limit: self.limit, most: self.buffers })
    }

    /// Runs a compute shader in WGSL on `groups` workgroups, and returns `count` results. The buffers with the bytes
    /// `inputs` have the first bindings of group 0, in their order, and that of the results has the next one.
    ///
    /// # Errors
    /// [`DeviceError::Refused`] with the message of the compiler, [`DeviceError::TooSmall`] and [`DeviceError::Lost`].
    pub fn compute<T: bytemuck::Pod>(
        &self,
        source: &str,
        entry_point: &str,
        inputs: &[&[u8]],
        count: usize,
        groups: u32,
    ) -> Result<Vec<T>, DeviceError> {
        let mut writes = vec![false; inputs.len()];
        writes.push(true);
        let [pipeline] = self.compile(source, [entry_point], &writes)?;
        let mut buffers = inputs.iter().map(|input| self.upload(input)).collect::<Result<Vec<_>, _>>()?;
        buffers.push(self.results((count * size_of::<T>()) as u64)?);
        self.run(&[(&pipeline, groups)], &buffers.iter().collect::<Vec<_>>());
        buffers.last().map_or(Ok(Vec::new()), |results| self.download(results))
    }

    /// Compiles entry points of a shader in WGSL with storage buffers. `writes` says whether it writes to a buffer, in
    /// the order of their bindings.
    ///
    /// # Errors
    /// [`DeviceError::Refused`] with the message of the compiler.
    pub(crate) fn compile<const N: usize>(
        &self,
        source: &str,
        entry_points: [&str; N],
        writes: &[bool],
    ) -> Result<[wgpu::ComputePipeline; N], DeviceError> {
        let entries: Vec<_> = (0..)
            .zip(writes)
            .map(|(binding, &writes)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: !writes },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let group =
            self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries });
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: &[Some(&group)],
            ..Default::default()
        });
        let pipelines = entry_points.map(|entry_point| {
            self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&layout),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        });
        match pollster::block_on(scope.pop()) {
            None => Ok(pipelines),
            Some(error) => Err(DeviceError::Refused { name: self.name.clone(), reason: error.to_string() }),
        }
    }

    /// Copies data into a new buffer.
    ///
    /// # Errors
    /// [`DeviceError::TooSmall`] and [`DeviceError::Lost`].
    pub(crate) fn upload<T: bytemuck::NoUninit>(&self, data: &[T]) -> Result<wgpu::Buffer, DeviceError> {
        let contents: &[u8] = bytemuck::cast_slice(data);
        self.check(contents.len() as u64)?;
        let usage = wgpu::BufferUsages::STORAGE;
        Ok(self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage }))
    }

    /// A buffer for results.
    ///
    /// # Errors
    /// [`DeviceError::TooSmall`] and [`DeviceError::Lost`].
    pub(crate) fn results(&self, size: u64) -> Result<wgpu::Buffer, DeviceError> {
        self.check(size)?;
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        Ok(self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false }))
    }

    fn check(&self, needed: u64) -> Result<(), DeviceError> {
        if needed <= self.limit {
            return self.alive();
        }
        Err(DeviceError::TooSmall { name: self.name.clone(), needed, limit: self.limit })
    }

    /// # Errors
    /// [`DeviceError::Lost`] with what the driver reported since the device was opened: it was lost, or its memory is
    /// full.
    pub(crate) fn alive(&self) -> Result<(), DeviceError> {
        self.failure.get().map_or(Ok(()), |what| Err(DeviceError::Lost(what)))
    }

    /// Runs pipelines of one layout after each other, each on a number of workgroups. They have the same buffers, in
    /// the order of their bindings.
    pub(crate) fn run(&self, steps: &[(&wgpu::ComputePipeline, u32)], buffers: &[&wgpu::Buffer]) {
        let Some((first, _)) = steps.first() else { return };
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = first.get_bind_group_layout(0);
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &entries,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_bind_group(0, &group, &[]);
            for &(pipeline, groups) in steps {
                pass.set_pipeline(pipeline);
                pass.dispatch_workgroups(groups, 1, 1);
            }
        }
        self.queue.submit([encoder.finish()]);
    }

    /// Waits for all work, and copies a buffer back.
    ///
    /// # Errors
    /// [`DeviceError::Lost`].
    pub(crate) fn download<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, DeviceError> {
        self.alive()?;
        let lost = |reason: String| DeviceError::Lost(self.failure.get().unwrap_or(reason));
        let size = buffer.size();
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let copy =
            self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, size);
        let submission_index = Some(self.queue.submit([encoder.finish()]));
        let (sender, receiver) = std::sync::mpsc::channel();
        copy.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver exists until the result is here, or the wait has failed.
            let _ = sender.send(result);
        });
        let wait = wgpu::PollType::Wait { submission_index, timeout: Some(PATIENCE) };
        self.device.poll(wait).map_err(|e| lost(e.to_string()))?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(lost(e.to_string())),
            Err(e) => return Err(lost(e.to_string())),
        }
        self.alive()?;
        let view = copy.slice(..).get_mapped_range().map_err(|e| lost(e.to_string()))?;
        Ok(bytemuck::pod_collect_to_vec(&view[..]))
    }
}
