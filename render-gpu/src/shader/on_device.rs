//! Pictures that are shaded without leaving the device.

use super::from_host::pack;
use super::{GpuShader, HEADER, Part, Prepared, TILE};
use crate::kernels;
use crate::kernels::queue::CUT;
use crate::resident::{Resident, Resolve};
use crate::{GpuError, GpuPicture, PixelMeans};
use core::time::Duration;
use scene::{Cancel, Frame, ShadeStats, ShadingPoints, Stopwatch};
use shading::gpu::{GpuLight, GpuMaterials};

/// The time that a submission is to take: a window of the same device draws between two of them.
const TURN: Duration = Duration::from_millis(8);
/// The same on a software device: its kernels take as long to begin as to shade some hundred points.
const SOFTWARE_TURN: Duration = Duration::from_millis(250);
/// Points of the first submission, and of the smallest one.
pub(super) const FIRST: u64 = 1 << 15;
const LEAST: u64 = 1 << 11;

impl GpuShader {
    /// A picture of this size on the device, for [`shade_picture`](Self::shade_picture). Its texture may have been that of an older one that
    /// was dropped.
    ///
    /// # Errors
    /// [`GpuError::Limits`] for one that is larger than a texture may be, [`GpuError::OutOfMemory`].
    pub fn picture(&mut self, size: [u32; 2]) -> Result<GpuPicture, GpuError> {
        self.textures.picture(&self.gpu, size)
    }

    /// Shades points, and writes the pixels that are their means into a part of a picture, which stays on the device. Returns `None`, with
    /// the part unfinished, where a stop is requested before a submission. Pixels are in the picture for all that is submitted to the queue
    /// after this call.
    ///
    /// # Method
    /// As [`shade_async`](Self::shade_async), with the same bits for each point, but in submissions of a few milliseconds: others that use the
    /// queue, such as a window, have their turns between them. The pixels' sums are rounded otherwise than on the CPU.
    ///
    /// # Cost
    /// Memory for all points of the part: 88 bytes each. Points that the last call had are not uploaded again. 64 bytes of counts are read
    /// back for each submission, and nothing else.
    ///
    /// # Errors
    /// [`GpuError`]; [`GpuError::Limits`] for more points than a buffer holds.
    ///
    /// # Panics
    /// When there is not one pixel a point.
    pub async fn shade_picture<M: GpuMaterials, L: GpuLight>(
        &mut self,
        points: &ShadingPoints,
        means: &PixelMeans<'_>,
        frame: &Frame<'_, M, L>,
        picture: &GpuPicture,
        cancel: Option<&Cancel>,
    ) -> Result<Option<ShadeStats>, GpuError> {
        assert_eq!(points.receivers.len(), means.pixels.len(), "one pixel a point");
        let watch = Stopwatch::start();
        let mut stats = ShadeStats::default();
        let prepared = self.prepare(frame)?;
        let places = self.hold_points(points, means)?;
        let buffer = self.residents[0].points.sized(&self.gpu, 0)?.clone();
        let radiance = self.radiance.sized(&self.gpu, 16 * places)?.clone();
        let most = self.slice(prepared.stride);
        let mut part = Part { first: 0, count: 0, uniforms: 0, points: &buffer, radiance: &radiance };
        while part.first < places {
            if cancel.is_some_and(Cancel::is_cancelled) {
                return Ok(None);
            }
            let (turn, before) = (Stopwatch::start(), stages(&stats));
            part.count = self.turn.min(most).min(places - part.first);
            let cut = self.shade_part(frame, &prepared, &part, &mut stats).await?;
            if cut > 0 {
                return Err(GpuError::LoopsCut { threads: cut });
            }
            // The device's clock leaves out the work of others.
            let own = stages(&stats) - before;
            let seconds = if own > 0.0 { own } else { turn.seconds() };
            let wanted = if self.gpu.is_software() { SOFTWARE_TURN } else { TURN };
            self.turn = next_turn(self.turn, part.count, seconds / wanted.as_secs_f64());
            part.first += part.count;
        }
        let kernel = match self.resolve.take() {
            Some(kernel) => self.resolve.insert(kernel),
            None => self.resolve.insert(Resolve::new(&self.gpu)?),
        };
        self.residents[0].resolve(&self.gpu, kernel, &radiance, means, picture)?;
        stats.seconds = watch.seconds();
        Ok(Some(stats))
    }

    /// Uploads points and their pixels unless they are there, and makes them the first of those that are; the number of their places.
    fn hold_points(&mut self, points: &ShadingPoints, means: &PixelMeans<'_>) -> Result<u64, GpuError> {
        let known = |resident: &Resident| resident.held.filter(|(stamp, _)| *stamp == means.stamp);
        if known(&self.residents[0]).is_none() {
            self.residents.swap(0, 1);
        }
        let [resident, _] = &mut self.residents;
        if let Some((_, places)) = known(resident) {
            return Ok(places);
        }
        resident.held = None;
        let groups = points.groups();
        pack(&self.gpu, &mut resident.points, points, &groups)?;
        resident.hold_pixels(&self.gpu, means, &groups)?;
        let places = groups.len() as u64 * TILE;
        resident.held = Some((means.stamp, places));
        Ok(places)
    }

    /// Shades a part of the points, and waits for it; the number of threads whose loops the driver has cut.
    async fn shade_part<M: GpuMaterials, L: GpuLight>(
        &mut self,
        frame: &Frame<'_, M, L>,
        prepared: &Prepared,
        part: &Part<'_>,
        stats: &mut ShadeStats,
    ) -> Result<u32, GpuError> {
        let gpu = self.gpu.clone();
        self.hold_uniforms(frame, prepared, &[part.count])?;
        let mut encoder = self.encoder();
        self.write(prepared, part, &mut encoder, true)?;
        let staging = self.staging.sized(&gpu, HEADER)?.clone();
        let queue = self.queue.sized(&gpu, 0)?.clone();
        gpu.scoped("the commands of a slice", || {
            encoder.copy_buffer_to_buffer(&queue, 0, &staging, 0, HEADER);
            if let Some(clock) = &self.clock {
                clock.resolve(&mut encoder);
            }
            gpu.queue().submit([encoder.finish()]);
        })?;
        let (counts, mut cut) = (&mut stats.counts, 0);
        gpu.read(&staging, HEADER, |bytes| {
            let header = bytemuck::cast_slice(bytes);
            *counts += kernels::counts(header);
            cut = kernels::count(header, CUT);
        })
        .await?;
        if let Some(clock) = &self.clock {
            clock.read(&gpu, &mut stats.stages).await?;
        }
        Ok(cut)
    }
}

/// Seconds by the device's clock, if it has one.
fn stages(stats: &ShadeStats) -> f64 {
    stats.stages.lighting + stats.stages.mask
}

/// The points of the next submission, after one of `count` that took `times` as long as it was to take: more or fewer by a factor of
/// two at most.
fn next_turn(turn: u64, count: u64, times: f64) -> u64 {
    let wanted = count as f64 / times.max(1e-6);
    let next = wanted.clamp(0.5 * turn as f64, 2.0 * turn as f64) as u64;
    // A short rest at the end of a picture says little.
    let next = if count < turn { next.min(turn) } else { next };
    (next / TILE * TILE).clamp(LEAST, super::SLICE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn submissions_come_to_take_as_long_as_they_may() {
        // 800 points would be right, no fewer than the least; 8 million would be, but no more than a slice has.
        for (point, want) in [(1.0 / 800.0, LEAST), (1.0 / 8e6, super::super::SLICE)] {
            let mut turn = FIRST;
            for _ in 0..16 {
                turn = next_turn(turn, turn, point * turn as f64);
            }
            assert_eq!(turn, want);
        }
        let mut turn = FIRST;
        for _ in 0..16 {
            turn = next_turn(turn, turn, turn as f64 / 8000.0);
        }
        assert!((7000..=8000).contains(&turn) && turn.is_multiple_of(TILE), "{turn}");
        // Nothing grows by a rest.
        assert_eq!(next_turn(FIRST, 64, 1e-3), FIRST);
    }
}
