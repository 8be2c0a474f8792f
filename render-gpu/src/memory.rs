use crate::{Gpu, GpuError};
use wgpu::BufferUsages;

/// A buffer that grows and knows its last upload.
#[derive(Debug)]
pub(crate) struct Memory {
    label: &'static str,
    usage: BufferUsages,
    /// Whether it is bound in parts, so that it may be larger than a binding.
    is_paged: bool,
    buffer: Option<wgpu::Buffer>,
    /// The bytes of the last upload; only bytes that differ are uploaded again.
    last: Vec<u8>,
}

/// Bytes that are compared and uploaded as one part.
const CHUNK: usize = 256;

impl Memory {
    pub(crate) const fn new(label: &'static str, usage: BufferUsages) -> Self {
        Self { label, usage, is_paged: false, buffer: None, last: Vec::new() }
    }

    /// The same buffer, bound in parts. The caller ensures that each part fits a binding.
    pub(crate) fn paged(self) -> Self {
        Self { is_paged: true, ..self }
    }

    /// The buffer, with at least this size.
    ///
    /// A buffer that grows loses its contents.
    pub(crate) fn sized(&mut self, gpu: &Gpu, size: u64) -> Result<&wgpu::Buffer, GpuError> {
        let size = size.max(16).next_multiple_of(16);
        if self.buffer.as_ref().is_none_or(|buffer| buffer.size() < size) {
            let limits = gpu.device().limits();
            let bindable = if self.usage.contains(BufferUsages::STORAGE) && !self.is_paged {
                limits.max_storage_buffer_binding_size
            } else {
                u64::MAX
            };
            let allowed = limits.max_buffer_size.min(bindable);
            if size > allowed {
                return Err(GpuError::Limits { what: self.label, needed: size, allowed });
            }
            self.last.clear();
            let descriptor =
                wgpu::BufferDescriptor { label: Some(self.label), size, usage: self.usage, mapped_at_creation: false };
            self.buffer = Some(gpu.scoped(self.label, || gpu.device().create_buffer(&descriptor))?);
        }
        self.buffer.as_ref().ok_or(GpuError::OutOfMemory)
    }

    /// Uploads `bytes` to the buffer's beginning where they differ from the last upload. Returns the number of bytes uploaded.
    pub(crate) fn hold(&mut self, gpu: &Gpu, bytes: &[u8]) -> Result<usize, GpuError> {
        debug_assert!(bytes.len().is_multiple_of(4), "buffers are written by words");
        self.sized(gpu, bytes.len() as u64)?;
        let Some(buffer) = &self.buffer else { return Ok(0) };
        let mut parts = Vec::new();
        let mut at = 0;
        while at < bytes.len() {
            let end = (at + CHUNK).min(bytes.len());
            if self.last.get(at..end) != Some(&bytes[at..end]) {
                match parts.last_mut() {
                    Some((_, last)) if *last == at => *last = end,
                    _ => parts.push((at, end)),
                }
            }
            at = end;
        }
        let uploaded = parts.iter().map(|(from, to)| to - from).sum();
        if uploaded == 0 {
            return Ok(0);
        }
        gpu.scoped(self.label, || {
            for (from, to) in parts {
                gpu.queue().write_buffer(buffer, from as u64, &bytes[from..to]);
            }
        })?;
        self.last.clear();
        self.last.extend_from_slice(bytes);
        Ok(uploaded)
    }

    /// Call this after a kernel has written to the buffer: the next upload sends all bytes.
    pub(crate) fn forget(&mut self) {
        self.last.clear();
    }

    /// Whether anything was uploaded and not [forgotten](Self::forget).
    pub(crate) const fn is_held(&self) -> bool {
        !self.last.is_empty()
    }

    /// The buffer, if there is one.
    pub(crate) fn get(&self) -> Option<&wgpu::Buffer> {
        self.buffer.as_ref()
    }

    /// The whole buffer, as a binding.
    pub(crate) fn whole(&self) -> Option<wgpu::BufferBinding<'_>> {
        self.buffer.as_ref().map(wgpu::Buffer::as_entire_buffer_binding)
    }
}
