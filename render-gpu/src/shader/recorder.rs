//! The commands of a slice of points.

use super::{FRAME_STRIDE, GpuShader, HEADER, PATCHES, Part, Prepared};
use crate::clock::{Clock, Stage};
use crate::kernel::Kernel;

/// The most workgroups of a dispatch of one a point along x, as in `queue.wgsl`.
const WIDEST: u64 = 1 << 15;

/// Writes the commands of a slice.
pub(super) struct Recorder<'a> {
    pub(super) shader: &'a GpuShader,
    pub(super) part: &'a Part<'a>,
    pub(super) tiles: u64,
    pub(super) queue: &'a wgpu::Buffer,
    pub(super) indirect: &'a wgpu::Buffer,
    pub(super) clock: Option<&'a mut Clock>,
}

/// The size of a pass's dispatch.
#[derive(Clone, Copy)]
enum Dispatch<'a> {
    Groups(u64),
    /// One workgroup a point.
    Points(u64),
    /// Of these sizes, from a byte on.
    Indirect(&'a wgpu::Buffer, u64),
}

/// A kernel, its buffers, its stage and its dispatch.
type Step<'a> = (&'a Kernel, wgpu::BindGroup, Stage, Dispatch<'a>);

impl<'a> Recorder<'a> {
    fn step(&self, kernel: &'a Kernel, stage: Stage, work: Dispatch<'a>) -> Step<'a> {
        let shader = self.shader;
        (kernel, kernel.bind(&shader.gpu, |slot| shader.resource(slot, self.part)), stage, work)
    }

    /// The passes of a light by the number of its kernels.
    fn steps_of(&self, number: usize) -> Vec<Step<'a>> {
        let (variant, kernels) = &self.shader.kernels[number];
        let of_tiles = match variant.is_patch {
            true => Dispatch::Indirect(self.indirect, PATCHES),
            false => Dispatch::Groups(self.tiles),
        };
        let before = self.shader.blockers.of_tiles().map(|kernel| (Some(kernel), Stage::Cull, of_tiles));
        let own = [
            (Some(&kernels.classify), Stage::Classify, of_tiles),
            (kernels.args.as_ref(), Stage::Classify, Dispatch::Groups(1)),
            (kernels.penumbra.as_ref(), Stage::Penumbra, Dispatch::Indirect(self.indirect, 0)),
        ];
        let all = before.chain(own);
        all.filter_map(|(kernel, stage, work)| kernel.map(|kernel| self.step(kernel, stage, work))).collect()
    }

    pub(super) fn record(mut self, prepared: &Prepared, changes: &[bool], encoder: &mut wgpu::CommandEncoder) {
        let Prepared { kernels, sky, .. } = prepared;
        let mut steps: Vec<(usize, Vec<Step<'_>>)> = Vec::new();
        for number in kernels {
            if steps.iter().all(|(known, _)| known != number) {
                steps.push((*number, self.steps_of(*number)));
            }
        }
        let followers = self.shader.blockers.followers(changes);
        let followers: Vec<Step<'_>> =
            followers.map(|(kernel, groups)| self.step(kernel, Stage::Cull, Dispatch::Groups(groups))).collect();
        let of_sky = sky.as_ref().and_then(|(number, _)| self.shader.sky.kernels(*number)).map(|[kernel, args]| {
            [
                self.step(kernel, Stage::Penumbra, Dispatch::Points(self.part.count)),
                self.step(args, Stage::Classify, Dispatch::Groups(1)),
            ]
        });
        encoder.clear_buffer(self.part.radiance, 16 * self.part.first, Some(16 * self.part.count));
        encoder.clear_buffer(self.queue, 0, Some(HEADER));
        if let Some(clock) = &mut self.clock {
            clock.restart();
        }
        for step in &followers {
            self.pass(encoder, 0, step);
        }
        let patches = sky.as_ref().map_or(&[][..], |(_, patches)| patches);
        // The lobes that the sky leaves to its patches lie in the queue until these are done.
        let others = (0..kernels.len()).filter(|light| !patches.contains(light));
        let mut is_first = true;
        for light in others.chain(patches.iter().copied()) {
            if !core::mem::take(&mut is_first) {
                encoder.clear_buffer(self.queue, 0, Some(4));
            }
            if patches.first() == Some(&light) {
                of_sky.iter().flatten().for_each(|step| self.pass(encoder, light as u64, step));
            }
            let number = kernels[light];
            for step in steps.iter().filter(|(known, _)| *known == number).flat_map(|(_, steps)| steps) {
                self.pass(encoder, light as u64, step);
            }
        }
    }

    fn pass(&mut self, encoder: &mut wgpu::CommandEncoder, light: u64, (kernel, group, stage, work): &Step<'_>) {
        let timestamp_writes = self.clock.as_mut().and_then(|clock| clock.next(*stage));
        let label = Some(kernel.label());
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes });
        pass.set_pipeline(kernel.pipeline());
        let offset = [((self.part.uniforms + light) * FRAME_STRIDE) as u32];
        pass.set_bind_group(0, group, if kernel.has_frame() { &offset } else { &[] });
        match work {
            Dispatch::Groups(count) => pass.dispatch_workgroups(*count as u32, 1, 1),
            Dispatch::Points(count) => {
                pass.dispatch_workgroups((*count).min(WIDEST) as u32, count.div_ceil(WIDEST) as u32, 1);
            }
            Dispatch::Indirect(buffer, from) => pass.dispatch_workgroups_indirect(buffer, *from),
        }
    }
}
