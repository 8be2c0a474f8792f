//! Kernels on a device: compiles them, binds their buffers and runs them.

use super::Kernel;
use crate::binding::{Access, Slot};
use crate::module::Text;
use crate::pipeline::{Pipeline, entry};
use crate::{Gpu, GpuError};
use wgpu::{BindingType, BufferUsages};

/// Size in bytes of the buffers for a dispatch without workgroups: at least the fixed part of each buffer.
const EMPTY: u64 = 4096;

impl Kernel {
    /// Compiles a kernel, unless the device has it already.
    pub(crate) fn new(gpu: &Gpu, text: &Text) -> Result<Self, GpuError> {
        gpu.kernel_cache().get(text, || {
            gpu.kernels().compile(&text.name, || {
                let kernel = Self::create(gpu, text)?;
                if gpu.is_mesa_software() {
                    kernel.run_empty(gpu)?;
                }
                Ok(kernel)
            })
        })
    }

    fn create(gpu: &Gpu, Text { entry: label, text, bindings, .. }: &Text) -> Result<Self, GpuError> {
        let label = *label;
        // Mesa's software driver treats numbers in a uniform that decide loops and branches as constants, unrolls the loops, and
        // compiles the kernel again for each light. It does not do so with a storage buffer.
        let is_storage = gpu.is_mesa_software();
        let text = if is_storage { text.replace("var<uniform>", "var<storage, read>") } else { text.clone() };
        let access = |access: Access| if is_storage && access == Access::Uniform { Access::Read } else { access };
        let storage = bindings.iter().filter(|(_, of)| access(*of) != Access::Uniform).count() as u64;
        let allowed = gpu.device().limits().max_storage_buffers_per_shader_stage.into();
        if storage > allowed {
            return Err(GpuError::Limits { what: "a kernel's storage buffers", needed: storage, allowed });
        }
        let entries: Vec<_> = bindings.iter().map(|(slot, of)| layout_entry(*slot, access(*of))).collect();
        gpu.scoped("a kernel", || {
            let pipeline = Pipeline::new(gpu.device(), label, text, &entries);
            Self { pipeline, slots: bindings.iter().map(|(slot, _)| *slot).collect() }
        })
    }

    /// Dispatches no workgroups, and waits. Mesa's software driver compiles a kernel at its first dispatch, not when it is created.
    fn run_empty(&self, gpu: &Gpu) -> Result<(), GpuError> {
        gpu.scoped("a kernel", || {
            let usage = BufferUsages::STORAGE | BufferUsages::UNIFORM;
            let buffer = |_| {
                let descriptor = wgpu::BufferDescriptor { label: None, size: EMPTY, usage, mapped_at_creation: false };
                gpu.device().create_buffer(&descriptor)
            };
            let buffers: Vec<_> = self.slots.iter().map(buffer).collect();
            let all = || self.slots.iter().zip(&buffers);
            let group = self.bind(gpu, |slot| {
                let (_, buffer) = all().find(|(known, _)| **known == slot)?;
                Some(buffer.as_entire_buffer_binding())
            });
            self.submit(gpu, &group, [0, 0]);
        })?;
        gpu.wait()
    }

    /// The kernel's bind group, from the buffers that `resource` returns for its slots.
    pub(crate) fn bind<'b>(
        &self,
        gpu: &Gpu,
        resource: impl Fn(Slot) -> Option<wgpu::BufferBinding<'b>>,
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = self
            .slots
            .iter()
            .filter_map(|slot| {
                let resource = wgpu::BindingResource::Buffer(resource(*slot)?);
                Some(wgpu::BindGroupEntry { binding: slot.binding(), resource })
            })
            .collect();
        self.pipeline.group(gpu.device(), &entries)
    }

    /// Submits the kernel alone, with `groups` workgroups along x and y and the first uniform; does not wait.
    pub(crate) fn submit(&self, gpu: &Gpu, group: &wgpu::BindGroup, groups: [u32; 2]) {
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.record(&mut encoder, group, groups);
        gpu.queue().submit([encoder.finish()]);
    }

    /// Writes the kernel into an encoder, as a pass of its own.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, group: &wgpu::BindGroup, groups: [u32; 2]) {
        self.pipeline.record(encoder, (group, if self.has_frame() { &[0] } else { &[] }), groups);
    }
}

fn layout_entry(slot: Slot, access: Access) -> wgpu::BindGroupLayoutEntry {
    let ty = match access {
        Access::Uniform => wgpu::BufferBindingType::Uniform,
        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Access::Write => wgpu::BufferBindingType::Storage { read_only: false },
    };
    let buffer = BindingType::Buffer { ty, has_dynamic_offset: slot == Slot::Frame, min_binding_size: None };
    entry(slot.binding(), buffer)
}
