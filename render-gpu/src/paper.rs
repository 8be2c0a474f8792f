use crate::memory::Memory;
use crate::{Gpu, GpuError};
use paper::{PaperWeights, Tables};
use wgpu::BufferUsages;

/// The paper's tables on the GPU, followed by the weights of the depth that was last used.
#[derive(Debug)]
pub(crate) struct Paper {
    tables: Tables,
    depth: Option<u32>,
    memory: Memory,
}

impl Paper {
    pub(crate) fn new(tables: &Tables) -> Self {
        let memory = Memory::new("the paper's tables", BufferUsages::STORAGE | BufferUsages::COPY_DST);
        Self { tables: tables.clone(), depth: None, memory }
    }

    /// Whether it was made from these tables.
    pub(crate) fn is_of(&self, tables: &Tables) -> bool {
        self.tables.products == tables.products
    }

    /// Solves for the weights of a depth, if it is not the last one.
    pub(crate) fn hold(&mut self, gpu: &Gpu, depth: u32) -> Result<(), GpuError> {
        if self.depth != Some(depth) {
            let mut pairs = self.tables.pack();
            pairs.extend(PaperWeights::solve(depth, &self.tables).pack());
            self.memory.hold(gpu, bytemuck::cast_slice(&pairs))?;
            self.depth = Some(depth);
        }
        Ok(())
    }

    pub(crate) fn resource(&self) -> Option<wgpu::BufferBinding<'_>> {
        self.memory.whole()
    }
}
