//! The geometry of a scene for rays on the GPU.

mod gather;
mod primitive;
mod tree;

#[cfg(test)]
pub(crate) use self::primitive::GpuPrimitive;
pub use self::primitive::ShadowCasting;
pub(crate) use self::primitive::{BLOCKS, BLOCKS_ALIKE, FLAT, SPHERE, VISIBLE};
#[cfg(test)]
pub(crate) use self::tree::GpuNode;

use self::gather::{Gathered, gather};
use self::tree::Tree;
use crate::memory::Memory;
use crate::{Gpu, GpuError};
use scene::{Bounds, Scene};
use wgpu::BufferUsages;

/// Stacks of kernels are multiples of this.
const STACK_STEP: u32 = 32;

/// The geometry of a scene on a GPU, ready for rays: triangles and exact spheres in one hierarchy of two children a node.
///
/// Holds the same as `render_cpu::World`: the objects that the camera sees and those that block light, without triangles that have
/// no area. Kernels use units in which the scene's size is about 2²⁰.
///
/// Building takes about 1.5 µs a triangle on the CPU, [`update`](Self::update) 0.3 µs, upload included (250 000 triangles). All
/// triangles must fit a binding with 48 bytes each: 2.8 million in 128 MiB.
#[derive(Debug)]
pub struct GpuWorld {
    gpu: Gpu,
    tree: Option<Tree>,
    nodes: Memory,
    primitives: Memory,
    normals: Memory,
    scale: f32,
    uploaded: usize,
    /// For each object the receivers that it casts shadows on; empty if all objects cast on all.
    casting: Vec<ShadowCasting>,
}

impl GpuWorld {
    /// Prepares the scene's objects and uploads them.
    ///
    /// # Errors
    /// [`GpuError::Limits`] when there are too many triangles for the device, [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, GpuError> {
        Self::make(gpu, scene, Vec::new())
    }

    /// As [`new`](Self::new), but only objects whose number `blocks` accepts block light: for the `rays` strategy beside strategies
    /// that take the other objects.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn only(gpu: &Gpu, scene: &Scene, blocks: impl Fn(u32) -> bool) -> Result<Self, GpuError> {
        Self::with_casting(gpu, scene, |o| if blocks(o) { ShadowCasting::All } else { ShadowCasting::None })
    }

    /// As [`new`](Self::new), but `casting` gives for each object's number the receivers that it casts shadows on.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_casting(gpu: &Gpu, scene: &Scene, casting: impl Fn(u32) -> ShadowCasting) -> Result<Self, GpuError> {
        Self::make(gpu, scene, (0..scene.objects.len() as u32).map(casting).collect())
    }

    fn make(gpu: &Gpu, scene: &Scene, casting: Vec<ShadowCasting>) -> Result<Self, GpuError> {
        let memory = |label| Memory::new(label, BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let mut world = Self {
            gpu: gpu.clone(),
            tree: None,
            nodes: memory("the hierarchy's nodes"),
            primitives: memory("the scene's triangles"),
            normals: memory("the triangles' normals"),
            scale: 1.0,
            uploaded: 0,
            casting,
        };
        world.update(scene)?;
        Ok(world)
    }

    /// Updates the geometry to the scene. Boxes are refitted if objects have only moved; the hierarchy is built again if the boxes
    /// have grown to twice their area. Only bytes that differ are uploaded.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn update(&mut self, scene: &Scene) -> Result<(), GpuError> {
        let Gathered { mut primitives, names, normals, scale } = gather(scene, &self.casting)?;
        let old = self.tree.take().filter(|_| self.scale == scale);
        let tree = old
            .and_then(|tree| tree.refitted(&primitives, &names))
            .map_or_else(|| Tree::new(&primitives, names), Ok)?;
        tree.arrange(&mut primitives);
        self.scale = scale;
        self.uploaded = self.nodes.hold(&self.gpu, bytemuck::cast_slice(&tree.packed(scale, &self.casting)))?;
        self.uploaded += self.primitives.hold(&self.gpu, bytemuck::cast_slice(&primitives))?;
        self.uploaded += self.normals.hold(&self.gpu, bytemuck::cast_slice(&normals))?;
        self.tree = Some(tree);
        Ok(())
    }

    /// Bytes that the last [`update`](Self::update) uploaded.
    #[must_use]
    pub const fn uploaded(&self) -> usize {
        self.uploaded
    }

    /// Number of triangles and spheres.
    #[must_use]
    pub fn primitive_count(&self) -> usize {
        self.tree.as_ref().map_or(0, Tree::primitive_count)
    }

    /// Size of a kernel's stack, a multiple of 32.
    pub(crate) fn stack(&self) -> u32 {
        self.tree.as_ref().map_or(1, Tree::depth).max(1).next_multiple_of(STACK_STEP)
    }

    /// Units of the hierarchy a world unit.
    pub(crate) const fn scale(&self) -> f32 {
        self.scale
    }

    /// A box around everything, in world units.
    pub(crate) fn bounds(&self) -> Bounds {
        self.tree.as_ref().map_or(Bounds::EMPTY, |tree| {
            let [min, max] = tree.bounds().map(|corner| corner / self.scale);
            Bounds { min, max }
        })
    }

    pub(crate) const fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    pub(crate) fn nodes(&self) -> Option<wgpu::BufferBinding<'_>> {
        self.nodes.whole()
    }

    pub(crate) fn primitives(&self) -> Option<wgpu::BufferBinding<'_>> {
        self.primitives.whole()
    }

    /// Those of nodes and primitives, to be kept until the next update.
    pub(crate) fn buffers(&self) -> Option<[wgpu::Buffer; 2]> {
        Some([self.nodes.get()?.clone(), self.primitives.get()?.clone()])
    }

    pub(crate) fn normals(&self) -> Option<wgpu::BufferBinding<'_>> {
        self.normals.whole()
    }
}
