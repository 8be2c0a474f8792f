//! Points of a part of a picture that stay on the device, and the pixels that are their means.

use crate::memory::Memory;
use crate::pipeline::{Pipeline, READ, buffer, entry, written};
use crate::wgsl::RESOLVE;
use crate::{Gpu, GpuError, GpuPicture, TILE};
use bytemuck::{Pod, Zeroable};
use core::ops::Range;
use glam::Vec3;
use lobe_core::wgsl::join;
use wgpu::BufferUsages;

/// Points that a workgroup takes.
const GROUP: usize = (TILE * TILE) as usize;
/// Stands for no place.
pub(crate) const NO_PLACE: u32 = u32::MAX;
/// Marks a place that has a point.
const USED: u32 = 1 << 30;
/// Marks the last point of a pixel.
pub(crate) const LAST: u32 = 1 << 31;
/// The bits of the rays that a point stands for.
pub(crate) const RAYS: u32 = USED - 1;

/// The pixels of a part of a picture as means of points: `pixel = Σ rays·radiance / samples + rest`.
#[derive(Clone, Copy, Debug)]
pub struct PixelMeans<'a> {
    /// A number that these points and no others have: they are uploaded only if the last call had another one.
    pub stamp: u64,
    /// Column and row of the picture where the part begins.
    pub corner: [u32; 2],
    /// Columns and rows of the part.
    pub size: [u32; 2],
    /// For each point the number of its pixel in the part, `row·columns + column`. The points of a pixel lie side by side.
    pub pixels: &'a [u32],
    /// For each point the rays that it stands for, 2³⁰ − 1 at most; empty: one each.
    pub rays: &'a [u32],
    /// Camera rays of a pixel.
    pub samples: u32,
    /// Radiance of each pixel besides its points': emission, background, sky. Empty: none.
    pub rest: &'a [Vec3],
}

/// `Part` of resolve.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Part {
    corner: [u32; 2],
    size: [u32; 2],
    scale: f32,
    has_rest: u32,
    padding: [u32; 2],
}

/// Memory for the points of one part of a picture.
#[derive(Debug)]
pub(crate) struct Resident {
    /// The points that are there, and the number of their places.
    pub(crate) held: Option<(u64, u64)>,
    pub(crate) points: Memory,
    firsts: Memory,
    weights: Memory,
    rest: Memory,
}

impl Resident {
    pub(crate) fn new() -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        Self {
            held: None,
            points: Memory::new("the points of a picture", storage).paged(),
            firsts: Memory::new("the first points of pixels", storage),
            weights: Memory::new("the weights of points", storage),
            rest: Memory::new("radiance besides that of points", storage),
        }
    }

    /// Uploads which points make which pixels. `groups` are the points of each tile of places.
    pub(crate) fn hold_pixels(
        &mut self,
        gpu: &Gpu,
        means: &PixelMeans<'_>,
        groups: &[Range<usize>],
    ) -> Result<(), GpuError> {
        let (firsts, weights) = places(means, groups);
        self.firsts.hold(gpu, bytemuck::cast_slice(&firsts))?;
        self.weights.hold(gpu, bytemuck::cast_slice(&weights))?;
        Ok(())
    }

    /// Writes the pixels of the part into a picture, from the radiance of its points. Submits and does not wait.
    pub(crate) fn resolve(
        &mut self,
        gpu: &Gpu,
        kernel: &mut Resolve,
        radiance: &wgpu::Buffer,
        means: &PixelMeans<'_>,
        picture: &GpuPicture,
    ) -> Result<(), GpuError> {
        let rest: Vec<[f32; 4]> = means.rest.iter().map(|rest| rest.extend(0.0).to_array()).collect();
        self.rest.hold(gpu, bytemuck::cast_slice(&rest))?;
        let part = Part {
            corner: means.corner,
            size: means.size,
            scale: 1.0 / means.samples.max(1) as f32,
            has_rest: u32::from(!rest.is_empty()),
            padding: [0; 2],
        };
        kernel.part.hold(gpu, bytemuck::bytes_of(&part))?;
        let radiance = Some(radiance.as_entire_buffer_binding());
        let [firsts, weights, rest] = [&self.firsts, &self.weights, &self.rest].map(Memory::whole);
        let buffers = [kernel.part.whole(), firsts, weights, radiance, rest];
        gpu.scoped("the pixels of a picture", || {
            let view = picture.texture().create_view(&wgpu::TextureViewDescriptor::default());
            let buffers = (0..).zip(buffers).filter_map(|(binding, buffer)| {
                Some(wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::Buffer(buffer?) })
            });
            let texture = wgpu::BindGroupEntry { binding: 10, resource: wgpu::BindingResource::TextureView(&view) };
            let entries: Vec<_> = buffers.chain([texture]).collect();
            let device = gpu.device();
            let group = kernel.pipeline.group(device, &entries);
            let label = Some(kernel.pipeline.label());
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
            kernel.pipeline.record(&mut encoder, (&group, &[]), means.size.map(|side| side.div_ceil(TILE)));
            gpu.queue().submit([encoder.finish()]);
        })
    }
}

/// The place of each pixel's first point, and the weight of each place.
fn places(means: &PixelMeans<'_>, groups: &[Range<usize>]) -> (Vec<u32>, Vec<u32>) {
    let mut firsts = vec![NO_PLACE; means.size[0] as usize * means.size[1] as usize];
    let mut weights = vec![0; groups.len() * GROUP];
    let pixel_of = |point: usize| means.pixels.get(point);
    for (tile, group) in groups.iter().enumerate() {
        for (place, point) in (tile * GROUP..).zip(group.clone()) {
            let pixel = means.pixels[point];
            let is_last = pixel_of(point + 1) != Some(&pixel);
            let rays = means.rays.get(point).map_or(1, |rays| rays & RAYS);
            weights[place] = rays | USED | if is_last { LAST } else { 0 };
            if point == 0 || pixel_of(point - 1) != Some(&pixel) {
                firsts[pixel as usize] = place as u32;
            }
        }
    }
    (firsts, weights)
}

/// The kernel that makes pixels of points.
#[derive(Debug)]
pub(crate) struct Resolve {
    part: Memory,
    pipeline: Pipeline,
}

impl Resolve {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let binding = "@group(0) @binding(10) var target_texture: texture_storage_2d<rgba32float, write>;\n";
        let text = binding.to_owned() + &join(&[&RESOLVE]);
        let entries = [
            entry(0, buffer(wgpu::BufferBindingType::Uniform)),
            entry(1, READ),
            entry(2, READ),
            entry(3, READ),
            entry(4, READ),
            entry(10, written(wgpu::TextureFormat::Rgba32Float)),
        ];
        gpu.scoped("the kernel of a picture's pixels", || {
            let pipeline = Pipeline::new(gpu.device(), "resolve_pixels", text, &entries);
            let part = Memory::new("a part of a picture", BufferUsages::UNIFORM | BufferUsages::COPY_DST);
            Self { part, pipeline }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pixel whose points lie in two tiles of places: its first place, and marks that lead from the first to the last.
    #[test]
    fn places_lead_from_point_to_point() {
        let means = PixelMeans {
            stamp: 0,
            corner: [0; 2],
            size: [3, 1],
            pixels: &[0, 2, 2, 2],
            rays: &[4, 1, 2, 1],
            samples: 4,
            rest: &[],
        };
        let (firsts, weights) = places(&means, &[0..2, 2..4]);
        assert_eq!(firsts, [0, NO_PLACE, 1]);
        assert_eq!(weights[..3], [4 | USED | LAST, 1 | USED, 0]);
        assert_eq!(weights[GROUP..GROUP + 3], [2 | USED, 1 | USED | LAST, 0]);
    }
}
