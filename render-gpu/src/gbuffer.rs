//! Visible points found on the GPU.

#[cfg(test)]
mod tests;
pub(crate) mod view;

pub use self::view::TILE;

use self::view::GpuView;
use crate::binding::{Access, Slot};
use crate::bvh::GpuWorld;
use crate::kernel::Kernel;
use crate::memory::Memory;
use crate::module::Text;
use crate::wgsl::TRACE;
use crate::{Gpu, GpuError, GpuReceiver, NO_MATERIAL};
use core::ops::Range;
use glam::Vec3;
use lobe_core::Receiver;
use lobe_core::wgsl::constant;
use scene::{Camera, Scene, ShadingPoints};
use wgpu::BufferUsages;

/// The camera's visible points, found on the GPU and left there: the points of `render_cpu::GBuffer` with one ray a pixel, through
/// its centre. (Several rays a pixel are left to the CPU.)
///
/// Each pixel's ray is traced through the hierarchy of a [`GpuWorld`]. Points come tile by tile as in `GBuffer`, but each tile has
/// 64 places: a pixel that sees nothing, or lies outside the window, has a receiver whose material is [`NO_MATERIAL`], which
/// shading skips.
///
/// # Accuracy
/// Positions are off the surface by rounding in f32 of the largest coordinate of the triangle; normals agree with
/// `GBuffer`'s to about 1e-6 (spheres: 1e-7 of the distance over the radius). At edges a pixel in some 10⁵ may see the other
/// side.
#[derive(Debug)]
pub struct GpuGBuffer {
    world: GpuWorld,
    view: Memory,
    points: Memory,
    kernel: Option<(u32, Kernel)>,
}

/// Points of a window of the image in a buffer of the GPU.
#[derive(Clone, Copy, Debug)]
pub struct GpuPoints<'a> {
    /// Array of [`GpuReceiver`]s.
    pub buffer: &'a wgpu::Buffer,
    /// Number of places, those without a point included: a multiple of 64.
    pub count: u32,
    view: GpuView,
}

impl GpuPoints<'_> {
    /// The number of a place's pixel in the window, `row·width + column`; `None` outside the window.
    ///
    /// Place `(tile·8 + row)·8 + column`. Tiles lie from left to right, top to bottom, as in the whole image.
    #[must_use]
    pub fn pixel(&self, place: u32) -> Option<u32> {
        self.view.pixel(place)
    }

    /// Waits for the points and reads them back.
    async fn receivers(&self, gpu: &Gpu) -> Result<Vec<GpuReceiver>, GpuError> {
        let bytes = u64::from(self.count) * size_of::<GpuReceiver>() as u64;
        if bytes == 0 {
            return Ok(Vec::new());
        }
        let mut staging = Memory::new("a copy of the points", BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let staging = staging.sized(gpu, bytes)?;
        gpu.scoped("a copy of the points", || {
            let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(self.buffer, 0, staging, 0, bytes);
            gpu.queue().submit([encoder.finish()]);
        })?;
        let mut receivers = Vec::new();
        gpu.read(staging, bytes, |view| receivers = bytemuck::pod_collect_to_vec(view)).await?;
        Ok(receivers)
    }
}

impl GpuGBuffer {
    /// Prepares a scene's geometry.
    ///
    /// # Errors
    /// As [`GpuWorld::new`].
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, GpuError> {
        let world = GpuWorld::new(gpu, scene)?;
        let view = Memory::new("the view", BufferUsages::STORAGE | BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let points = Memory::new("the visible points", BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        Ok(Self { world, view, points, kernel: None })
    }

    /// Updates the geometry to the scene: [`GpuWorld::update`].
    ///
    /// # Errors
    /// As [`GpuWorld::update`].
    pub fn update(&mut self, scene: &Scene) -> Result<(), GpuError> {
        self.world.update(scene)
    }

    /// The geometry.
    #[must_use]
    pub const fn world(&self) -> &GpuWorld {
        &self.world
    }

    /// Finds the visible points of a window of a `width`×`height` image. They are in the buffer once the queue has run this work;
    /// the next call overwrites them. Trace an image with more points than a buffer holds in several windows.
    ///
    /// # Errors
    /// [`GpuError::Limits`] when the window has too many points for the device, [`GpuError::Refused`],
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    ///
    /// # Panics
    /// When the window is not inside the image.
    pub fn trace(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> Result<GpuPoints<'_>, GpuError> {
        let gpu = self.world.gpu().clone();
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let points = self.record(camera, [width, height], columns, rows, &mut encoder)?;
        gpu.scoped("the search for visible points", || {
            gpu.queue().submit([encoder.finish()]);
        })?;
        Ok(points)
    }

    /// As [`trace`](Self::trace), but writes the commands into the caller's encoder, which the caller submits before the next call.
    /// The points are in the buffer once the queue has run them.
    ///
    /// # Errors
    /// As [`trace`](Self::trace).
    ///
    /// # Panics
    /// As [`trace`](Self::trace).
    pub fn record(
        &mut self,
        camera: &Camera,
        [width, height]: [u32; 2],
        columns: Range<u32>,
        rows: Range<u32>,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<GpuPoints<'_>, GpuError> {
        let inside = |r: &Range<u32>, size: u32| r.start <= r.end && r.end <= size;
        assert!(inside(&columns, width) && inside(&rows, height), "window outside the image");
        let view = GpuView::new(camera, [width, height], [&columns, &rows], &self.world.bounds(), self.world.scale());
        let tiles = view.tiles();
        let count = u64::from(tiles[0]) * u64::from(tiles[1]) * u64::from(TILE * TILE);
        self.points.sized(self.world.gpu(), count * size_of::<GpuReceiver>() as u64)?;
        self.view.hold(self.world.gpu(), bytemuck::bytes_of(&view))?;
        if count > 0 {
            self.dispatch(tiles, encoder)?;
        }
        let buffer = self.points.get().ok_or(GpuError::OutOfMemory)?;
        Ok(GpuPoints { buffer, count: count as u32, view })
    }

    fn dispatch(&mut self, tiles: [u32; 2], encoder: &mut wgpu::CommandEncoder) -> Result<(), GpuError> {
        let (gpu, stack) = (self.world.gpu(), self.world.stack());
        let most = gpu.device().limits().max_compute_workgroups_per_dimension;
        if tiles[0].max(tiles[1]) > most {
            let (needed, allowed) = (tiles[0].max(tiles[1]).into(), most.into());
            return Err(GpuError::Limits { what: "a dispatch's tiles", needed, allowed });
        }
        let kernel = match self.kernel.take() {
            Some((size, kernel)) if size >= stack => self.kernel.insert((size, kernel)),
            _ => self.kernel.insert((stack, Kernel::new(gpu, &trace_text(stack))?)),
        };
        let (world, points, view) = (&self.world, &self.points, &self.view);
        gpu.scoped("the search for visible points", || {
            let group = kernel.1.bind(gpu, |slot| match slot {
                Slot::View => view.whole(),
                Slot::Points => points.whole(),
                Slot::Nodes => world.nodes(),
                Slot::Primitives => world.primitives(),
                Slot::Normals => world.normals(),
                _ => None,
            });
            kernel.1.record(encoder, &group, tiles);
        })
    }

    /// As [`trace`](Self::trace), but waits for the points and reads them back, as `GBuffer` lists them: only places that have a
    /// point, with the number of each one's pixel. Not for browsers: they have [`read_async`](Self::read_async).
    ///
    /// # Errors
    /// As [`trace`](Self::trace).
    ///
    /// # Panics
    /// As [`trace`](Self::trace).
    pub fn read(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> Result<(ShadingPoints, Vec<u32>), GpuError> {
        pollster::block_on(self.read_async(camera, width, height, columns, rows))
    }

    /// As [`read`](Self::read), but a browser does not wait: the points are there in a later turn.
    ///
    /// # Errors
    /// As [`trace`](Self::trace).
    ///
    /// # Panics
    /// As [`trace`](Self::trace).
    pub async fn read_async(
        &mut self,
        camera: &Camera,
        width: u32,
        height: u32,
        columns: Range<u32>,
        rows: Range<u32>,
    ) -> Result<(ShadingPoints, Vec<u32>), GpuError> {
        let gpu = self.world.gpu().clone();
        let points = self.trace(camera, width, height, columns, rows)?;
        let receivers = points.receivers(&gpu).await?;
        let (mut out, mut pixels) = (ShadingPoints::default(), Vec::new());
        for (place, at) in receivers.iter().enumerate() {
            let Some(pixel) = points.pixel(place as u32).filter(|_| at.material != NO_MATERIAL) else { continue };
            let [position, normal, face, view] = [at.position, at.normal, at.face, at.view].map(Vec3::from);
            out.receivers.push(Receiver { position, normal, face, view, object: at.object });
            out.materials.push(at.material);
            pixels.push(pixel);
        }
        Ok((out, pixels))
    }
}

const BINDINGS: &[(Slot, Access)] = &[
    (Slot::View, Access::Uniform),
    (Slot::Points, Access::Write),
    (Slot::Nodes, Access::Read),
    (Slot::Primitives, Access::Read),
    (Slot::Normals, Access::Read),
];

/// The text of the kernel of visible points, for hierarchies that are no deeper than its stack.
#[must_use]
pub(crate) fn trace_text(stack: u32) -> Text {
    Text::new("trace", &[&TRACE], &[&constant("STACK", &stack)], BINDINGS)
}
