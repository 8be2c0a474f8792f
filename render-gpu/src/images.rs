//! The images that the lights of a frame show.

use crate::memory::Memory;
use crate::{Gpu, GpuError};
use lobe_core::LightImage;
use wgpu::BufferUsages;

/// Images on the GPU, and the place where each light's begins.
#[derive(Debug)]
pub(crate) struct Images {
    memory: Memory,
    /// The images that are on the GPU.
    known: Vec<LightImage>,
    starts: Vec<u32>,
}

impl Default for Images {
    fn default() -> Self {
        let memory = Memory::new("images of lights", BufferUsages::STORAGE | BufferUsages::COPY_DST);
        Self { memory, known: Vec::new(), starts: Vec::new() }
    }
}

impl Images {
    /// Uploads the images of the lights of a frame; a light may have none. Uploads nothing if the same images are there.
    pub(crate) fn hold<'i>(
        &mut self,
        gpu: &Gpu,
        images: impl Iterator<Item = Option<&'i LightImage>> + Clone,
    ) -> Result<(), GpuError> {
        let is_known = self.known.iter().eq(images.clone().flatten());
        self.starts.clear();
        let mut start = 0;
        for image in images.clone() {
            self.starts.push(start);
            start += image.map_or(0, LightImage::packed_words) as u32;
        }
        if !is_known {
            self.known.clear();
            let mut words = Vec::with_capacity(start as usize);
            images.clone().flatten().for_each(|image| image.pack(&mut words));
            self.memory.hold(gpu, bytemuck::cast_slice(&words))?;
            self.known = images.flatten().cloned().collect();
        }
        Ok(())
    }

    /// Where a light's image begins.
    pub(crate) fn start(&self, light: u32) -> u32 {
        self.starts.get(light as usize).copied().unwrap_or(0)
    }

    /// The whole buffer, as a binding.
    pub(crate) fn whole(&self) -> Option<wgpu::BufferBinding<'_>> {
        self.memory.whole()
    }
}
