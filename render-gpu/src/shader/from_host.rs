//! Points that come from the CPU, and radiance that goes back to it.

use super::{GpuShader, HEADER, Part, TILE};
use crate::kernels;
use crate::kernels::queue::CUT;
use crate::layout::{GpuReceiver, NO_MATERIAL};
use crate::memory::Memory;
use crate::{Gpu, GpuError};
use core::num::NonZeroU64;
use core::ops::Range;
use glam::Vec3;
use rayon::prelude::*;
use scene::{Cancel, Frame, Shade, ShadeStats, ShadingPoints, Stopwatch};
use shading::gpu::{GpuLight, GpuMaterials};

/// A tile of points as the device has it.
type PackedTile = [GpuReceiver; TILE as usize];
/// Tiles that a thread packs or unpacks at once, at least.
const TASK: usize = 64;

/// Packs groups of points into memory of the device, on all threads: each is a tile, whose places left over have no material.
pub(super) fn pack(
    gpu: &Gpu,
    memory: &mut Memory,
    points: &ShadingPoints,
    groups: &[Range<usize>],
) -> Result<wgpu::Buffer, GpuError> {
    let size = (groups.len() * size_of::<PackedTile>()) as u64;
    let buffer = memory.sized(gpu, size)?.clone();
    gpu.scoped("points", || {
        let size = NonZeroU64::new(size)?;
        let mut view = gpu.queue().write_buffer_with(&buffer, 0, size)?;
        let (memory, _) = view.slice(..).into_chunks::<{ size_of::<PackedTile>() }>();
        let memory: Vec<_> = memory.into_iter().collect();
        memory.into_par_iter().zip(groups).with_min_len(TASK).for_each(|(memory, group)| {
            let none = GpuReceiver { material: NO_MATERIAL, ..GpuReceiver::default() };
            let mut packed: PackedTile = [none; TILE as usize];
            let points = points.receivers[group.clone()].iter().zip(&points.materials[group.clone()]);
            for (packed, (at, material)) in packed.iter_mut().zip(points) {
                *packed = GpuReceiver::new(at, *material);
            }
            memory.write(bytemuck::cast(packed));
        });
        Some(())
    })?;
    Ok(buffer)
}

/// Unpacks the radiance of tiles, on all threads.
fn unpack(pixels: &[u8], out: Vec<&mut [Vec3]>) {
    let tiles = pixels.par_chunks_exact(16 * TILE as usize).with_min_len(TASK);
    tiles.zip(out).for_each(|(pixels, out)| {
        for (out, pixel) in out.iter_mut().zip(pixels.chunks_exact(16)) {
            let [r, g, b, _]: [f32; 4] = bytemuck::pod_read_unaligned(pixel);
            *out = Vec3::new(r, g, b);
        }
    });
}

impl GpuShader {
    /// As [`Shade::shade`], but looks before each slice of points whether a stop is requested, and returns `None` then. Not for
    /// browsers: they have [`shade_async`](Self::shade_async).
    ///
    /// # Errors
    /// [`GpuError`].
    ///
    /// # Panics
    /// When `out` is not as long as the points.
    pub fn shade_until<M: GpuMaterials, L: GpuLight>(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
        cancel: Option<&Cancel>,
    ) -> Result<Option<ShadeStats>, GpuError> {
        pollster::block_on(self.shade_async(points, frame, out, cancel))
    }

    /// As [`shade_until`](Self::shade_until), for programs that may not wait: in a browser the future is ready in a later turn.
    /// Natively its first poll waits and makes it ready.
    ///
    /// # Errors
    /// [`GpuError`].
    ///
    /// # Panics
    /// When `out` is not as long as the points.
    pub async fn shade_async<M: GpuMaterials, L: GpuLight>(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
        cancel: Option<&Cancel>,
    ) -> Result<Option<ShadeStats>, GpuError> {
        assert_eq!(points.receivers.len(), out.len(), "one output a point");
        let watch = Stopwatch::start();
        let mut stats = ShadeStats::default();
        let prepared = self.prepare(frame)?;
        let tiles = (self.slice(prepared.stride) / TILE) as usize;
        let gpu = self.gpu.clone();
        let mut rest = out;
        for groups in points.groups().chunks(tiles) {
            if cancel.is_some_and(Cancel::is_cancelled) {
                return Ok(None);
            }
            let cut = |group: &Range<usize>| {
                let (own, after) = core::mem::take(&mut rest).split_at_mut(group.len());
                rest = after;
                own
            };
            let out: Vec<&mut [Vec3]> = groups.iter().map(cut).collect();
            let count = groups.len() as u64 * TILE;
            let buffer = pack(&gpu, &mut self.points, points, groups)?;
            let radiance = self.radiance.sized(&gpu, 16 * count)?.clone();
            let part = Part { first: 0, count, uniforms: 0, points: &buffer, radiance: &radiance };
            self.hold_uniforms(frame, &prepared, &[count])?;
            let mut encoder = self.encoder();
            self.write(&prepared, &part, &mut encoder, true)?;
            let staging = self.staging.sized(&gpu, 16 * count + HEADER)?.clone();
            let queue = self.queue.sized(&gpu, 0)?.clone();
            gpu.scoped("the commands of a slice", || {
                encoder.copy_buffer_to_buffer(&radiance, 0, &staging, 0, 16 * count);
                encoder.copy_buffer_to_buffer(&queue, 0, &staging, 16 * count, HEADER);
                if let Some(clock) = &self.clock {
                    clock.resolve(&mut encoder);
                }
                gpu.queue().submit([encoder.finish()]);
            })?;
            let (counts, mut cut) = (&mut stats.counts, 0);
            gpu.read(&staging, 16 * count + HEADER, |bytes| {
                let (pixels, header) = bytes.split_at(16 * count as usize);
                unpack(pixels, out);
                let header = bytemuck::cast_slice(header);
                *counts += kernels::counts(header);
                cut = kernels::count(header, CUT);
            })
            .await?;
            if cut > 0 {
                return Err(GpuError::LoopsCut { threads: cut });
            }
            if let Some(clock) = &self.clock {
                clock.read(&gpu, &mut stats.stages).await?;
            }
        }
        stats.seconds = watch.seconds();
        Ok(Some(stats))
    }
}

impl<M: GpuMaterials, L: GpuLight> Shade<M, L> for GpuShader {
    type Error = GpuError;

    /// # Panics
    /// When `out` is not as long as the points.
    fn shade(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
    ) -> Result<ShadeStats, GpuError> {
        Ok(self.shade_until(points, frame, out, None)?.unwrap_or_default())
    }
}
