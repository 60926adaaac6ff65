//! Batches of queries on a GPU.

use crate::device::{Device, DeviceError};
use crate::library::{Field, shader_far_table, shader_fiber, shader_tables};
use bytemuck::{Pod, Zeroable};
use vellus::Bcsdf;

/// Threads in a workgroup of the shader.
const GROUP: usize = 64;
/// The most queries in one run: 65535 workgroups are the limit of every GPU.
const RUN: usize = 65_535 * GROUP;

/// One query. Directions are unit vectors in the fibre's frame, as in [`vellus::Bcsdf::at`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Query {
    /// ω_o.
    pub wo: [f32; 3],
    /// The offset, in [−1, 1]. The far field does not use it.
    pub h: f32,
    /// ω_i.
    pub wi: [f32; 3],
    /// The index of the fibre.
    pub fiber: u32,
    /// Four uniform numbers in [0, 1), as for [`vellus::NearHit::sample8`].
    pub u: [f32; 4],
}

/// The answer to a [`Query`].
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Answer {
    /// f·cos θᵢ of all lobes, RGB.
    pub value: [f32; 3],
    /// The density per solid angle with which ω_i is drawn.
    pub pdf: f32,
    /// The direction drawn from `u`.
    pub wi: [f32; 3],
    /// Its density. 0 if nothing was drawn.
    pub wi_pdf: f32,
    /// f·cos θᵢ over the density, RGB.
    pub weight: [f32; 3],
    /// The index of the lobe that was drawn. In the far field 3 and 4 are the backward and the forward half of the
    /// light that the medulla scattered.
    pub lobe: f32,
    /// The energy of each lobe, RGB and 0.
    pub energy: [[f32; 4]; 6],
    /// f·cos θᵢ of each lobe, RGB and 0.
    pub lobes: [[f32; 4]; 6],
}

/// Some fibres on a GPU.
#[derive(Debug)]
pub struct Queries<'d> {
    device: &'d Device,
    pipeline: wgpu::ComputePipeline,
    tables: wgpu::Buffer,
    fibers: wgpu::Buffer,
    count: usize,
    far: Option<FarTables>,
}

/// The tables of the far field of all fibres.
#[derive(Debug)]
struct FarTables {
    rows: wgpu::Buffer,
    /// The first row of each fibre.
    first: Vec<u32>,
}

impl<'d> Queries<'d> {
    /// Compiles the shader, and copies the tables and the fibres to the GPU.
    ///
    /// # Errors
    /// [`DeviceError::Refused`] if the GPU cannot compile the shader, and [`DeviceError::TooSmall`] if the fibres do
    /// not fit.
    pub fn new(device: &'d Device, fibers: &[Bcsdf<'_>]) -> Result<Self, DeviceError> {
        Self::with(device, fibers, Field::Near, None)
    }

    fn with(
        device: &'d Device,
        fibers: &[Bcsdf<'_>],
        field: Field,
        far: Option<FarTables>,
    ) -> Result<Self, DeviceError> {
        let rows: Vec<[f32; 4]> = fibers.iter().flat_map(shader_fiber).collect();
        // The tables, the fibres, the queries, the answers, and the tables of the far field.
        let writes = [false, false, false, true, false];
        let writes = &writes[..if far.is_some() { 5 } else { 4 }];
        let [pipeline] = device.compile(&field.shader(), [field.entry()], writes)?;
        Ok(Queries {
            device,
            pipeline,
            tables: device.upload(&shader_tables())?,
            fibers: device.upload(&rows)?,
            count: fibers.len(),
            far,
        })
    }

    /// As [`Queries::new`], but queries are those of the far field: of the whole width of a fibre (Yan17 Sec. 5). It
    /// makes a table for each fibre.
    ///
    /// # Errors
    /// As [`Queries::new`].
    pub fn far_field(device: &'d Device, fibers: &[Bcsdf<'_>]) -> Result<Self, DeviceError> {
        let (mut rows, mut first) = (Vec::new(), Vec::new());
        for fiber in fibers {
            // A buffer has fewer than 2³² rows.
            first.push(rows.len() as u32);
            rows.extend(shader_far_table(fiber));
        }
        let far = FarTables { rows: device.upload(&rows)?, first };
        Self::with(device, fibers, Field::Far, Some(far))
    }

    /// Answers all queries, in their order.
    ///
    /// # Errors
    /// [`DeviceError::NoFiber`] if a query names a fibre that does not exist, and [`DeviceError::Lost`].
    pub fn run(&self, queries: &[Query]) -> Result<Vec<Answer>, DeviceError> {
        if let Some(query) = queries.iter().find(|query| query.fiber as usize >= self.count) {
            return Err(DeviceError::NoFiber { index: query.fiber, count: self.count });
        }
        let mut answers = Vec::with_capacity(queries.len());
        for part in queries.chunks(RUN) {
            let input = match &self.far {
                None => self.device.upload(part)?,
                // The shader reads the first row of the table in the place of the offset.
                Some(far) => {
                    let table = |query: &Query| f32::from_bits(far.first[query.fiber as usize]);
                    let part: Vec<Query> = part.iter().map(|query| Query { h: table(query), ..*query }).collect();
                    self.device.upload(&part)?
                }
            };
            let output = self.device.results(part.len() as u64 * size_of::<Answer>() as u64)?;
            let groups = part.len().div_ceil(GROUP);
            let mut buffers = vec![&self.tables, &self.fibers, &input, &output];
            buffers.extend(self.far.as_ref().map(|far| &far.rows));
            // At most 65535 by the size of a run.
            self.device.run(&[(&self.pipeline, groups as u32)], &buffers);
            answers.extend(self.device.download::<Answer>(&output)?);
        }
        Ok(answers)
    }
}
