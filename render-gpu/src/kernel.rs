use crate::{Gpu, GpuError};

/// The numbers of the bindings, all in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Slot {
    Frame = 0,
    Points = 1,
    Materials = 2,
    Radiance = 3,
    Queue = 4,
    Indirect = 5,
    Spheres = 6,
    Lists = 7,
    Maps = 8,
    Tables = 9,
    Nodes = 10,
    Bounds = 11,
    Rig = 12,
    Bones = 13,
    Primitives = 14,
    Normals = 15,
}

/// How a kernel uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    Uniform,
    Read,
    Write,
}

/// A buffer of a kernel.
pub(crate) type Binding = (Slot, Access);

/// One compiled entry point and the buffers that it wants.
#[derive(Debug)]
pub(crate) struct Kernel {
    label: &'static str,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    slots: Vec<Slot>,
}

impl Kernel {
    /// Compiles the entry point `label` of a module.
    pub(crate) fn new(gpu: &Gpu, label: &'static str, text: &str, bindings: &[Binding]) -> Result<Self, GpuError> {
        let storage = bindings.iter().filter(|(_, access)| *access != Access::Uniform).count() as u64;
        let allowed = gpu.device().limits().max_storage_buffers_per_shader_stage.into();
        if storage > allowed {
            return Err(GpuError::Limits { what: "a kernel's storage buffers", needed: storage, allowed });
        }
        let entries: Vec<_> = bindings.iter().map(|(slot, access)| layout_entry(*slot, *access)).collect();
        gpu.scoped("a kernel", || {
            let device = gpu.device();
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(text.into()),
            });
            let layout = device
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: &[Some(&layout)],
                ..Default::default()
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(label),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(label),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            Self { label, pipeline, layout, slots: bindings.iter().map(|(slot, _)| *slot).collect() }
        })
    }

    /// Its bind group, of the buffers that `resource` has for its slots.
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
                Some(wgpu::BindGroupEntry { binding: *slot as u32, resource })
            })
            .collect();
        gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.label),
            layout: &self.layout,
            entries: &entries,
        })
    }

    /// Submits it alone, with so many workgroups along x and y and its uniform from the beginning; does not wait.
    pub(crate) fn submit(&self, gpu: &Gpu, group: &wgpu::BindGroup, groups: [u32; 2]) {
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let label = Some(self.label);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes: None });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, group, if self.has_frame() { &[0] } else { &[] });
            pass.dispatch_workgroups(groups[0], groups[1], 1);
        }
        gpu.queue().submit([encoder.finish()]);
    }

    /// Whether it reads the frame, whose slot is chosen when it runs.
    pub(crate) fn has_frame(&self) -> bool {
        self.slots.contains(&Slot::Frame)
    }

    pub(crate) const fn pipeline(&self) -> &wgpu::ComputePipeline {
        &self.pipeline
    }

    pub(crate) const fn label(&self) -> &'static str {
        self.label
    }
}

fn layout_entry(slot: Slot, access: Access) -> wgpu::BindGroupLayoutEntry {
    let ty = match access {
        Access::Uniform => wgpu::BufferBindingType::Uniform,
        Access::Read => wgpu::BufferBindingType::Storage { read_only: true },
        Access::Write => wgpu::BufferBindingType::Storage { read_only: false },
    };
    wgpu::BindGroupLayoutEntry {
        binding: slot as u32,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: access == Access::Uniform, min_binding_size: None },
        count: None,
    }
}
