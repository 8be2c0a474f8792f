//! Compute pipelines with the layout of their bindings.

use wgpu::{BindGroupEntry, BindGroupLayoutEntry, BindingType, BufferBindingType};

/// One compiled entry point. Clones are the same one.
#[derive(Clone, Debug)]
pub(crate) struct Pipeline {
    label: &'static str,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl Pipeline {
    /// Compiles an entry point of a text.
    pub(crate) fn new(
        device: &wgpu::Device,
        entry: &'static str,
        text: String,
        entries: &[BindGroupLayoutEntry],
    ) -> Self {
        let label = Some(entry);
        let source = wgpu::ShaderSource::Wgsl(text.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: label,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { label: entry, layout, pipeline }
    }

    /// The name of the entry point.
    pub(crate) const fn label(&self) -> &'static str {
        self.label
    }

    pub(crate) const fn pipeline(&self) -> &wgpu::ComputePipeline {
        &self.pipeline
    }

    /// A bind group of its layout.
    pub(crate) fn group(&self, device: &wgpu::Device, entries: &[BindGroupEntry<'_>]) -> wgpu::BindGroup {
        let (label, layout) = (Some(self.label), &self.layout);
        device.create_bind_group(&wgpu::BindGroupDescriptor { label, layout, entries })
    }

    /// Writes it into an encoder, as a pass of its own, with `groups` workgroups along x and y.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (group, offsets): (&wgpu::BindGroup, &[u32]),
        groups: [u32; 2],
    ) {
        let label = Some(self.label);
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes: None });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, offsets);
        pass.dispatch_workgroups(groups[0], groups[1], 1);
    }
}

/// A binding of a kernel.
pub(crate) const fn entry(binding: u32, ty: BindingType) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None }
}

/// A buffer of any size.
pub(crate) const fn buffer(ty: BufferBindingType) -> BindingType {
    BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// A buffer that is read.
pub(crate) const READ: BindingType = buffer(BufferBindingType::Storage { read_only: true });

/// A texture that is written.
pub(crate) const fn written(format: wgpu::TextureFormat) -> BindingType {
    let access = wgpu::StorageTextureAccess::WriteOnly;
    BindingType::StorageTexture { access, format, view_dimension: wgpu::TextureViewDimension::D2 }
}
