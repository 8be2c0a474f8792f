use crate::kernel::{Kernel, Slot};
use crate::memory::Memory;
use crate::module::{self, OwnText, Strategies};
use crate::{Gpu, GpuError, GpuPose, GpuWorld};
use core::num::NonZeroU64;
use glam::Mat4;
use lobe_core::LightId;
use lobe_core::gpu::GpuBlockers;
use visibility_shadowmap::{PackedMaps, Pages, ShadowMapBlockers};
use visibility_spheres::{BlockerSphere, SPHERE_BLOCK, SphereBlockers};
use wgpu::BufferUsages;

const NO_SCENE: &str = "blockers that ask what rays meet need `any_hit`";

/// What hides lights from points: any of these together; nothing by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct Occlusion<'a> {
    /// The `spheres` strategy.
    pub spheres: Option<&'a SphereBlockers>,
    /// The `shadow-map` strategy.
    pub maps: Option<&'a ShadowMapBlockers>,
    /// Strategies that this crate does not know.
    pub own: &'a [&'a dyn GpuBlockers],
    /// The scene that rays of those meet: the objects that block there. Given anew after each of its updates.
    pub any_hit: Option<&'a GpuWorld>,
}

/// Blockers on the GPU.
#[derive(Debug)]
pub(crate) struct Blockers {
    strategies: Strategies,
    sphere_count: u32,
    packed: Vec<BlockerSphere>,
    spheres: Memory,
    bounds: Memory,
    /// Nodes and primitives of what shadow rays meet.
    world: Option<[wgpu::Buffer; 2]>,
    /// Makes the bounds; and whether it has to.
    bound: Option<Kernel>,
    moved: bool,
    packed_maps: Option<PackedMaps>,
    maps: Memory,
    own: Vec<OwnText>,
    own_buffers: Vec<Memory>,
}

impl Default for Blockers {
    fn default() -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        Self {
            strategies: Strategies::default(),
            sphere_count: 0,
            packed: Vec::new(),
            spheres: Memory::new("blocker spheres", storage),
            bounds: Memory::new("bounds of blockers", storage),
            world: None,
            bound: None,
            moved: false,
            packed_maps: None,
            maps: Memory::new("shadow maps", storage).paged(),
            own: Vec::new(),
            own_buffers: Vec::new(),
        }
    }
}

impl Blockers {
    /// Takes over what blocks now; after an error nothing does.
    pub(crate) fn hold(&mut self, gpu: &Gpu, occlusion: Occlusion<'_>) -> Result<(), GpuError> {
        let asks = occlusion.own.iter().any(|own| own.asks_any_hit());
        let any_hit = occlusion.any_hit.filter(|_| asks);
        self.strategies = Strategies::default();
        self.own.clear();
        if asks && any_hit.is_none() {
            return Err(GpuError::Unsupported(NO_SCENE.to_owned()));
        }
        let names = |k: usize| occlusion.own[..k].iter().map(|own| own.name());
        if let Some((_, own)) =
            occlusion.own.iter().enumerate().find(|(k, own)| names(*k).any(|name| name == own.name()))
        {
            return Err(GpuError::Unsupported(format!("blockers called `{}` are there twice", own.name())));
        }
        let mut strategies = Strategies { any_hit: any_hit.map(GpuWorld::stack), ..Strategies::default() };
        self.world = any_hit.and_then(GpuWorld::buffers);
        self.packed.clear();
        if let Some(spheres) = occlusion.spheres {
            spheres.pack(&mut self.packed);
        }
        let old_maps = self.packed_maps.take();
        if let Some(maps) = occlusion.maps {
            let mut packed = old_maps.unwrap_or_default();
            if packed.update(maps) > 0 {
                self.maps.hold(gpu, bytemuck::cast_slice(packed.words()))?;
            }
            let most = gpu.device().limits().max_storage_buffer_binding_size;
            strategies.maps = Some(Pages::of(size_of_val(packed.words()) as u64, most));
            self.packed_maps = Some(packed);
        }
        self.sphere_count = self.packed.len() as u32;
        strategies.spheres = self.sphere_count > 0;
        if strategies.spheres {
            self.moved |= self.spheres.hold(gpu, bytemuck::cast_slice(&self.packed))? > 0;
            self.bounds.sized(gpu, 16 * u64::from(self.block_count()))?;
            if self.bound.is_none() {
                self.bound = Some(Kernel::new(gpu, &module::bounds())?);
            }
        }
        self.own = self.hold_own(gpu, occlusion.own)?;
        self.strategies = strategies;
        Ok(())
    }

    /// The texts of somebody's own strategies, whose buffers are uploaded.
    fn hold_own(&mut self, gpu: &Gpu, own: &[&dyn GpuBlockers]) -> Result<Vec<OwnText>, GpuError> {
        let (mut texts, mut count) = (Vec::new(), 0);
        for blockers in own {
            let mut buffers = Vec::new();
            for buffer in blockers.buffers() {
                if count == self.own_buffers.len() {
                    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
                    self.own_buffers.push(Memory::new("own blockers", usage));
                }
                self.own_buffers[count].hold(gpu, bytemuck::cast_slice(&buffer.words))?;
                buffers.push((count as u32, buffer.name, buffer.element));
                count += 1;
            }
            texts.push(OwnText::new(*blockers, buffers));
        }
        Ok(texts)
    }

    /// Somebody's own strategies.
    pub(crate) fn own(&self) -> &[OwnText] {
        &self.own
    }

    /// Moves the spheres that follow bones.
    pub(crate) fn pose(&mut self, gpu: &Gpu, pose: &mut GpuPose, poses: &[(&[Mat4], &[f32])]) -> Result<(), GpuError> {
        if let Some(spheres) = self.spheres.whole().filter(|_| self.strategies.spheres) {
            pose.submit(gpu, poses, &spheres)?;
            self.spheres.forget();
            self.moved = true;
        }
        Ok(())
    }

    pub(crate) const fn strategies(&self) -> Strategies {
        self.strategies
    }

    pub(crate) const fn sphere_count(&self) -> u32 {
        self.sphere_count
    }

    /// Blocks of neighbours, a bound each.
    pub(crate) const fn block_count(&self) -> u32 {
        self.sphere_count.div_ceil(SPHERE_BLOCK as u32)
    }

    /// Where a light's shadow map is.
    pub(crate) fn map_of(&self, light: LightId) -> u32 {
        self.packed_maps.as_ref().map_or(0, |maps| maps.map_of(light))
    }

    /// Its buffer for a slot.
    pub(crate) fn resource(&self, slot: Slot) -> Option<wgpu::BufferBinding<'_>> {
        match slot {
            Slot::Spheres => self.spheres.whole(),
            Slot::Bounds => self.bounds.whole(),
            Slot::Nodes => self.world.as_ref().map(|[nodes, _]| nodes.as_entire_buffer_binding()),
            Slot::Primitives => self.world.as_ref().map(|[_, all]| all.as_entire_buffer_binding()),
            Slot::Maps(page) => self.page(page),
            Slot::Own(number) => self.own_buffers.get(number as usize).and_then(Memory::whole),
            _ => None,
        }
    }

    /// A page of the shadow maps.
    fn page(&self, page: u32) -> Option<wgpu::BufferBinding<'_>> {
        let bytes = size_of_val(self.packed_maps.as_ref()?.words()) as u64;
        let range = self.strategies.maps?.range(page, bytes);
        let size = NonZeroU64::new(range.end - range.start);
        Some(wgpu::BufferBinding { buffer: self.maps.get()?, offset: range.start, size })
    }

    /// Whether spheres have moved since this was asked last.
    pub(crate) fn take_moved(&mut self) -> bool {
        core::mem::take(&mut self.moved)
    }

    /// The kernel that follows moved spheres, and its workgroups.
    pub(crate) fn follower(&self) -> Option<(&Kernel, u64)> {
        self.bound.as_ref().map(|kernel| (kernel, module::bound_groups(self.block_count()).into()))
    }
}
