use crate::{Gpu, GpuError};
use scene::StageSeconds;
use wgpu::BufferUsages;

/// Passes that are timed in one submission; further passes are not timed.
const PASSES: u32 = 512;

/// The stage of shading that a pass belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    Cull,
    Classify,
    Penumbra,
}

/// The GPU's own clock, if it has one.
#[derive(Debug)]
pub(crate) struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    staging: wgpu::Buffer,
    stages: Vec<Stage>,
    period: f64,
}

impl Clock {
    pub(crate) fn new(gpu: &Gpu) -> Option<Self> {
        let device = gpu.device();
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let size = u64::from(2 * PASSES) * 8;
        let buffer = |usage| {
            let label = Some("timestamps");
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
        };
        let queries = device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timestamps"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * PASSES,
        });
        let resolved = buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC);
        let staging = buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let period = f64::from(gpu.queue().get_timestamp_period()) * 1e-9;
        Some(Self { queries, resolved, staging, stages: Vec::new(), period })
    }

    /// Begins a new submission.
    pub(crate) fn restart(&mut self) {
        self.stages.clear();
    }

    /// The timestamps of the next pass.
    pub(crate) fn next(&mut self, stage: Stage) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let pass = self.stages.len() as u32;
        (pass < PASSES).then(|| {
            self.stages.push(stage);
            wgpu::ComputePassTimestampWrites {
                query_set: &self.queries,
                beginning_of_pass_write_index: Some(2 * pass),
                end_of_pass_write_index: Some(2 * pass + 1),
            }
        })
    }

    /// Records the commands that read the timestamps.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let count = 2 * self.stages.len() as u32;
        if count > 0 {
            encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, u64::from(count) * 8);
        }
    }

    /// Adds the seconds of a submission that is done. Culling and penumbrae count as masks, the classification of points as
    /// lighting.
    pub(crate) async fn read(&self, gpu: &Gpu, stages: &mut StageSeconds) -> Result<(), GpuError> {
        let bytes = self.stages.len() as u64 * 16;
        if bytes == 0 {
            return Ok(());
        }
        gpu.read(&self.staging, bytes, |bytes| {
            let times: &[[u64; 2]] = bytemuck::cast_slice(bytes);
            for (stage, [from, to]) in self.stages.iter().zip(times) {
                let seconds = to.saturating_sub(*from) as f64 * self.period;
                match stage {
                    Stage::Classify => stages.lighting += seconds,
                    Stage::Cull | Stage::Penumbra => stages.mask += seconds,
                }
            }
        })
        .await
    }
}
