//! Environments that are summed at once.

use crate::binding::{Access, Slot};
use crate::kernel::Kernel;
use crate::memory::Memory;
use crate::module::{self, MaterialText, SkyVariant};
use crate::occlusion::Blockers;
use crate::{Gpu, GpuError};
use std::sync::Arc;
use visibility_mask::sky::{SkyResolution, SkyTable};
use visibility_mask::wgsl::sky_header;
use wgpu::BufferUsages;

/// The table of a sky, as a GPU reads it. Clones are the same one, which is uploaded once.
///
/// # Cost
/// As much memory as the table; once more while it is on a device, and once there.
#[derive(Clone, Debug)]
pub struct GpuSky {
    resolution: SkyResolution,
    words: Arc<[f32]>,
}

impl GpuSky {
    /// Packs a table.
    #[must_use]
    pub fn new(table: &SkyTable) -> Self {
        Self { resolution: table.meridians().resolution(), words: table.packed().into() }
    }

    /// The samples of the table.
    #[must_use]
    pub const fn resolution(&self) -> SkyResolution {
        self.resolution
    }
}

/// A sky on the device, and the lights of a frame that it stands for.
#[derive(Debug)]
pub(crate) struct Sky {
    memory: Memory,
    of: Option<GpuSky>,
    replaced: Vec<bool>,
    kernels: Vec<(SkyVariant, Kernel)>,
    args: Option<Kernel>,
}

impl Default for Sky {
    fn default() -> Self {
        Self {
            memory: Memory::new("sky", BufferUsages::STORAGE | BufferUsages::COPY_DST),
            of: None,
            replaced: Vec::new(),
            kernels: Vec::new(),
            args: None,
        }
    }
}

impl Sky {
    pub(crate) fn set(&mut self, sky: Option<(&GpuSky, Vec<bool>)>) {
        let Some((sky, replaced)) = sky else {
            self.of = None;
            return;
        };
        if self.of.as_ref().is_none_or(|of| !Arc::ptr_eq(&of.words, &sky.words)) {
            self.memory.forget();
        }
        self.of = Some(sky.clone());
        self.replaced = replaced;
    }

    /// Whether a light is a patch of the sky.
    pub(crate) fn replaces(&self, light: usize) -> bool {
        self.of.is_some() && self.replaced.get(light).is_some_and(|replaced| *replaced)
    }

    /// Compiles the kernels and uploads the table, where the sky is summed at once: all blockers draw before skies, and the device has room
    /// for the kernel's buffers. Returns the number of the kernel; elsewhere the sky's patches are lights like others.
    pub(crate) fn prepare(
        &mut self,
        gpu: &Gpu,
        blockers: &Blockers,
        (materials, most_lobes): (&MaterialText, u32),
    ) -> Result<Option<usize>, GpuError> {
        let Some(of) = &self.of else { return Ok(None) };
        let own = blockers.own();
        let Some(header) = sky_header(of.resolution, most_lobes).filter(|_| own.iter().all(|own| own.sky.is_some()))
        else {
            return Ok(None);
        };
        let variant = SkyVariant { header, materials: materials.clone(), own: own.to_vec(), stack: blockers.stack() };
        let known = self.kernels.iter().position(|(known, _)| *known == variant);
        let number = match known {
            Some(known) => known,
            None => {
                let text = module::sky(&variant);
                let most = gpu.device().limits().max_storage_buffers_per_shader_stage as usize;
                // The frame is a storage buffer on Mesa's software driver.
                let buffers = text.bindings.iter().filter(|(slot, access)| {
                    *access != Access::Uniform || (*slot == Slot::Frame && gpu.is_mesa_software())
                });
                if buffers.count() > most {
                    return Ok(None);
                }
                self.kernels.push((variant, Kernel::new(gpu, &text)?));
                self.kernels.len() - 1
            }
        };
        if self.args.is_none() {
            self.args = Some(Kernel::new(gpu, &module::sky_args())?);
        }
        if !self.memory.is_held() {
            self.memory.hold(gpu, bytemuck::cast_slice(&of.words))?;
        }
        Ok(Some(number))
    }

    /// The kernel of a number, and the one that sizes the dispatches of patches.
    pub(crate) fn kernels(&self, number: usize) -> Option<[&Kernel; 2]> {
        Some([&self.kernels.get(number)?.1, self.args.as_ref()?])
    }

    /// The table.
    pub(crate) fn resource(&self) -> Option<wgpu::BufferBinding<'_>> {
        self.memory.whole()
    }
}
