use crate::binding::{
    Access::{Read, Uniform, Write},
    Binding, Slot,
};
use crate::kernel::Kernel;
use crate::memory::Memory;
use crate::module::{self, OwnBuffer, OwnText, Text};
use crate::{Gpu, GpuError, GpuPose, GpuWorld};
use core::num::NonZeroU64;
use core::ops::Range;
use glam::Mat4;
use shading::gpu::{GpuBlockers, GpuContents, GpuPages, GpuPass, GpuRun};
use wgpu::BufferUsages;

const NO_SCENE: &str = "blockers that ask what rays meet need `any_hit`";

/// The blockers that hide lights from points: any of these strategies together; none by default.
///
/// Strategies are the spheres of `visibility-spheres`, the packed maps of `visibility-shadowmap`, silhouettes, rays, and custom
/// ones.
#[derive(Clone, Copy, Debug, Default)]
pub struct Occlusion<'a> {
    /// The strategies.
    pub blockers: &'a [&'a dyn GpuBlockers],
    /// The scene for the rays of these strategies: its objects that block. Pass it again after each of its updates.
    pub any_hit: Option<&'a GpuWorld>,
}

impl<'a> Occlusion<'a> {
    /// Strategies that trace no rays.
    #[must_use]
    pub const fn of(blockers: &'a [&'a dyn GpuBlockers]) -> Self {
        Self { blockers, any_hit: None }
    }
}

/// A buffer of a strategy.
#[derive(Debug)]
struct Part {
    name: &'static str,
    memory: Memory,
    /// Bytes that the buffer holds.
    bytes: u64,
    /// Bytes for each tile of a slice, if the buffer has no fixed size.
    per_tile: u64,
    pages: GpuPages,
    /// The first number of its slots.
    first: u32,
    revision: Option<u64>,
    /// Whether the buffer is new, or its contents have changed since the passes last ran.
    has_changed: bool,
}

impl Part {
    fn new(name: &'static str, is_paged: bool) -> Self {
        let memory = Memory::new(name, BufferUsages::STORAGE | BufferUsages::COPY_DST);
        Self {
            name,
            memory: if is_paged { memory.paged() } else { memory },
            bytes: 0,
            per_tile: 0,
            pages: GpuPages::ONE,
            first: 0,
            revision: None,
            has_changed: true,
        }
    }

    fn hold(&mut self, gpu: &Gpu, contents: &GpuContents<'_>) -> Result<(), GpuError> {
        self.per_tile = 0;
        match contents {
            GpuContents::Words(words) => self.upload(gpu, words)?,
            GpuContents::Pages { words, revision } => {
                if self.revision != Some(*revision) {
                    self.upload(gpu, words)?;
                    self.revision = Some(*revision);
                }
                let most = gpu.device().limits().max_storage_buffer_binding_size;
                self.pages = GpuPages::of(self.bytes, most);
            }
            GpuContents::Room(words) => self.room(gpu, 4 * u64::from(*words))?,
            GpuContents::RoomPerTile(words) => self.per_tile = 4 * u64::from(*words),
            _ => return Err(GpuError::Unsupported(format!("contents of the buffer `{}`", self.name))),
        }
        Ok(())
    }

    fn upload(&mut self, gpu: &Gpu, words: &[u32]) -> Result<(), GpuError> {
        // No revision is valid until the upload succeeds.
        self.revision = None;
        let bytes = size_of_val(words) as u64;
        let uploaded = self.memory.hold(gpu, bytemuck::cast_slice(words))?;
        self.has_changed |= uploaded > 0 || bytes != self.bytes;
        self.bytes = bytes;
        Ok(())
    }

    fn room(&mut self, gpu: &Gpu, bytes: u64) -> Result<(), GpuError> {
        self.memory.sized(gpu, bytes)?;
        // A buffer that grows loses the results of passes.
        self.has_changed |= bytes != self.bytes;
        self.bytes = bytes;
        Ok(())
    }

    /// The binding of a slot: only the bytes that the buffer holds.
    fn binding(&self, page: u32) -> Option<wgpu::BufferBinding<'_>> {
        let Range { start, end } = self.pages.range(page, self.bytes);
        let size = NonZeroU64::new(end.checked_sub(start)?);
        Some(wgpu::BufferBinding { buffer: self.memory.get()?, offset: start, size })
    }

    fn slots(&self) -> Range<u32> {
        self.first..self.first + self.pages.count()
    }
}

/// A pass of a strategy.
#[derive(Debug)]
struct Pass {
    text: Text,
    run: GpuRun,
    kernel: Option<Kernel>,
}

/// Blockers on the GPU.
#[derive(Debug, Default)]
pub(crate) struct Blockers {
    own: Vec<OwnText>,
    parts: Vec<Part>,
    passes: Vec<Pass>,
    /// Size of the rays' stack, and the nodes and primitives of their scene.
    world: Option<(u32, [wgpu::Buffer; 2])>,
}

impl Blockers {
    /// Uploads the blockers. After an error nothing blocks.
    pub(crate) fn hold(&mut self, gpu: &Gpu, occlusion: Occlusion<'_>) -> Result<(), GpuError> {
        let held = self.try_hold(gpu, occlusion);
        if held.is_err() {
            *self = Self::default();
        }
        held
    }

    fn try_hold(&mut self, gpu: &Gpu, occlusion: Occlusion<'_>) -> Result<(), GpuError> {
        let blockers: Vec<_> = occlusion.blockers.iter().filter(|blockers| !blockers.is_empty()).collect();
        for (k, own) in blockers.iter().enumerate() {
            if blockers[..k].iter().any(|other| other.name() == own.name()) {
                return Err(GpuError::Unsupported(format!("blockers called `{}` are there twice", own.name())));
            }
        }
        let asks = blockers.iter().any(|own| own.asks_any_hit());
        let world = occlusion.any_hit.filter(|_| asks);
        if asks && world.is_none() {
            return Err(GpuError::Unsupported(NO_SCENE.to_owned()));
        }
        self.world = world.and_then(|world| Some((world.stack(), world.buffers()?)));
        let (mut old, mut old_passes) = (core::mem::take(&mut self.parts), core::mem::take(&mut self.passes));
        self.own.clear();
        let mut slots = 0;
        for own in blockers {
            let mut buffers = Vec::new();
            for buffer in own.buffers() {
                let is_paged = matches!(buffer.contents, GpuContents::Pages { .. });
                let known = old.iter().position(|part| part.name == buffer.name);
                let part = known.map_or_else(|| Part::new(buffer.name, is_paged), |known| old.swap_remove(known));
                self.parts.push(Part { first: slots, ..part });
                let Some(part) = self.parts.last_mut() else { continue };
                part.hold(gpu, &buffer.contents)?;
                slots += part.pages.count();
                let pages = is_paged.then_some(part.pages);
                buffers.push(OwnBuffer { first: part.first, pages, name: buffer.name, element: buffer.element });
            }
            for pass in own.passes() {
                let text = pass_text(&pass, &buffers)?;
                let known = old_passes.iter().position(|old| old.text == text);
                let kernel = known.and_then(|known| old_passes.swap_remove(known).kernel);
                self.passes.push(Pass { text, run: pass.run, kernel });
            }
            self.own.push(OwnText::new(*own, buffers));
        }
        self.compile(gpu, |run| run != GpuRun::Tiles)
    }

    /// Compiles those passes that have no kernel yet.
    fn compile(&mut self, gpu: &Gpu, which: impl Fn(GpuRun) -> bool) -> Result<(), GpuError> {
        for pass in self.passes.iter_mut().filter(|pass| pass.kernel.is_none() && which(pass.run)) {
            pass.kernel = Some(Kernel::new(gpu, &pass.text)?);
        }
        Ok(())
    }

    /// Allocates the buffers for slices of this many tiles.
    pub(crate) fn prepare(&mut self, gpu: &Gpu, tiles: u64) -> Result<(), GpuError> {
        for part in self.parts.iter_mut().filter(|part| part.per_tile > 0) {
            part.room(gpu, part.per_tile * tiles)?;
        }
        Ok(())
    }

    /// Compiles the passes that run for each light.
    pub(crate) fn compile_all(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        self.compile(gpu, |_| true)
    }

    /// The strategies.
    pub(crate) fn own(&self) -> &[OwnText] {
        &self.own
    }

    /// Size of the stack for the strategies' rays.
    pub(crate) fn stack(&self) -> Option<u32> {
        self.world.as_ref().map(|(stack, _)| *stack)
    }

    /// The most bytes that a strategy needs for a tile.
    pub(crate) fn bytes_per_tile(&self) -> u64 {
        self.parts.iter().map(|part| part.per_tile).max().unwrap_or(0)
    }

    /// Moves the spheres that follow bones.
    pub(crate) fn pose(&mut self, gpu: &Gpu, pose: &mut GpuPose, poses: &[(&[Mat4], &[f32])]) -> Result<(), GpuError> {
        if let Some(part) = self.parts.iter_mut().find(|part| part.name == GpuPose::BUFFER && part.bytes > 0) {
            if let Some(binding) = part.binding(0) {
                pose.submit(gpu, poses, &binding)?;
            }
            part.memory.forget();
            part.has_changed = true;
        }
        Ok(())
    }

    /// The strategies' buffer for a slot.
    pub(crate) fn resource(&self, slot: Slot) -> Option<wgpu::BufferBinding<'_>> {
        let world = self.world.as_ref().map(|(_, buffers)| buffers);
        match slot {
            Slot::Nodes => world.map(|[nodes, _]| nodes.as_entire_buffer_binding()),
            Slot::Primitives => world.map(|[_, all]| all.as_entire_buffer_binding()),
            Slot::Own(number) => {
                let part = self.parts.iter().find(|part| part.slots().contains(&number))?;
                part.binding(number - part.first)
            }
            _ => None,
        }
    }

    /// For each pass, whether it must run because a buffer of it has changed. Clears the changes.
    pub(crate) fn take_changes(&mut self) -> Vec<bool> {
        let parts = &self.parts;
        let is_changed = |slot: Slot| match slot {
            Slot::Own(number) => parts.iter().any(|part| part.has_changed && part.slots().contains(&number)),
            _ => false,
        };
        // Buffers that the pass writes count too: such a buffer may be new.
        let of = |pass: &Pass| pass.text.bindings.iter().any(|(slot, _)| is_changed(*slot));
        let changes = self.passes.iter().map(|pass| pass.run != GpuRun::Tiles && of(pass)).collect();
        self.parts.iter_mut().for_each(|part| part.has_changed = false);
        changes
    }

    /// The kernels of the passes to run again, and their workgroups.
    pub(crate) fn followers(&self, changes: &[bool]) -> impl Iterator<Item = (&Kernel, u64)> {
        let changed = self.passes.iter().zip(changes).filter(|(_, changed)| **changed);
        changed.filter_map(|(pass, _)| match pass.run {
            GpuRun::Changed(groups) => Some((pass.kernel.as_ref()?, groups.into())),
            _ => None,
        })
    }

    /// The kernels that run for each light, with one workgroup a tile.
    pub(crate) fn of_tiles(&self) -> impl Iterator<Item = &Kernel> {
        self.passes.iter().filter(|pass| pass.run == GpuRun::Tiles).filter_map(|pass| pass.kernel.as_ref())
    }
}

/// The text of a pass of a strategy with these buffers.
pub(crate) fn pass_text(pass: &GpuPass, buffers: &[OwnBuffer]) -> Result<Text, GpuError> {
    let mut bindings: Vec<Binding> = vec![(Slot::Frame, Uniform)];
    let mut declarations = String::new();
    let reads = pass.reads.iter().map(|name| (*name, Read));
    for (name, access) in reads.chain(pass.writes.iter().map(|name| (*name, Write))) {
        if (name, access) == ("points", Read) {
            bindings.push((Slot::Points, Read));
            continue;
        }
        let buffer = buffers.iter().find(|buffer| buffer.name == name).ok_or_else(|| {
            GpuError::Unsupported(format!("the pass `{}` of buffers that its strategy has not: `{name}`", pass.entry))
        })?;
        bindings.extend(buffer.slots().map(|slot| (slot, access)));
        declarations.push_str(&buffer.declaration(access));
    }
    Ok(module::pass(pass, &declarations, &bindings))
}
