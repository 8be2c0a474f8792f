mod from_host;
mod on_device;
mod recorder;

use crate::binding::Slot;
use crate::clock::Clock;
use crate::images::Images;
use crate::kernel::Kernel;
use crate::kernels::queue::QUEUE_HEADER;
use crate::layout::{GpuFrame, GpuReceiver};
use crate::memory::Memory;
use crate::module::{self, MaterialText, Shown, Variant};
use crate::occlusion::{Blockers, Occlusion};
use crate::paper::Paper;
use crate::picture::Textures;
use crate::resident::{Resident, Resolve};
use crate::sky::Sky;
use crate::{Gpu, GpuError, GpuPose, GpuSky};
use core::num::NonZeroU64;
use glam::Mat4;
use paper::Tables;
use recorder::Recorder;
use scene::Frame;
use shading::gpu::{GPU_SHAPE, GpuLight, GpuMaterialSet, GpuMaterials, GpuText};
use shading::{Accuracy, LightLobes};
use visibility_mask::{Fineness, LookAgain, mask_depth};
use wgpu::BufferUsages;

/// Points that are culled together, as in `render-cpu`.
const TILE: u64 = (crate::TILE * crate::TILE) as u64;
/// The most points of a slice. One submission works on a slice, and buffers are sized for it.
const SLICE: u64 = 1 << 20;
/// The same on a software device, whose kernels do not get faster with more points.
const SOFTWARE_SLICE: u64 = 1 << 16;
/// Bytes of the queue before its items.
const HEADER: u64 = 4 * QUEUE_HEADER as u64;
/// Bytes of the sizes of two dispatches: the penumbra kernel's, and those of a sky's patches.
const INDIRECT: u64 = 24;
const PATCHES: u64 = 12;
/// Bytes from one light's uniform to the next: a multiple of the largest alignment that a device may require.
const FRAME_STRIDE: u64 = 512;
const FLAT_BY_PAPER: &str = "the paper's method supports sphere lights only";
const MICROFACETS_BY_PAPER: &str = "the paper's method knows cosine lobes alone: materials need a `gpu_cosine_set`";

/// Shades points with lobe sums on the GPU: the same sums as `render_cpu::CpuShader`, in WGSL.
///
/// # Method
/// Each light takes four kernels. The first culls tiles of 64 points against the blockers. The second computes each point's
/// unshadowed integrals, classifies it as lit, dark or in penumbra, and queues points in penumbra. The third sizes the dispatch of
/// the fourth, which gives each queued point a workgroup: it draws the mask, one thread a row, and sums the visible fractions.
/// Kernels are composed from the pieces that a frame uses (its reflectance models, strategies, depth), compiled at first use, and
/// kept.
///
/// # Accuracy
/// That of the CPU's path to within rounding: rounding may decide whether a sample at the end of a mask's row is blocked.
///
/// # Cost
/// Memory for a slice of at most 2²⁰ points, whatever the frame's size: per point 64 bytes for the point, 16 for its radiance, 4
/// and 4 for each of its lobes in the queue, and 32 for its part of the tile's list. Only bytes that differ from the last call are
/// uploaded.
///
/// ```no_run
/// use shading::Accuracy;
/// use render_gpu::{Gpu, GpuOptions, GpuShader, Occlusion};
/// use scene::{Frame, Shade, ShadingPoints};
/// let gpu = Gpu::blocking(&GpuOptions::default())?;
/// let mut shader = GpuShader::new(&gpu, Occlusion::default())?;
/// let frame: Frame<'_> = Frame::new(&[], &[], Accuracy::new(0.003));
/// shader.shade(&ShadingPoints::default(), &frame, &mut [])?;
/// # Ok::<(), render_gpu::GpuError>(())
/// ```
#[derive(Debug)]
pub struct GpuShader {
    gpu: Gpu,
    slice: u64,
    blockers: Blockers,
    kernels: Vec<(Variant, Kernels)>,
    /// The paper's method, if requested.
    paper: Option<Paper>,
    look_again: LookAgain,
    sky: Sky,
    materials: Memory,
    images: Images,
    /// The most lobes that a material has.
    max_lobes: u32,
    frames: Memory,
    queue: Memory,
    indirect: Memory,
    clock: Option<Clock>,
    /// Points that come from the CPU.
    points: Memory,
    radiance: Memory,
    staging: Memory,
    /// Points of pictures that stay on the device, the latest ones first: of a whole picture and of a coarse one.
    residents: [Resident; 2],
    resolve: Option<Resolve>,
    textures: Textures,
    /// Points of the next submission for such a picture.
    turn: u64,
}

/// The kernels of a frame.
#[derive(Debug)]
struct Prepared {
    /// The number of each light's.
    kernels: Vec<usize>,
    /// Words of a queue item.
    stride: u64,
    /// The number of the sky's, and its patches among the lights.
    sky: Option<(usize, Vec<usize>)>,
}

impl Prepared {
    /// Whether a light is a patch of a sky that is summed at once.
    fn is_patch(&self, light: usize) -> bool {
        self.sky.as_ref().is_some_and(|(_, patches)| patches.contains(&light))
    }
}

/// The kernels of a variant.
#[derive(Debug)]
struct Kernels {
    classify: Kernel,
    args: Option<Kernel>,
    penumbra: Option<Kernel>,
}

impl GpuShader {
    /// A shader with these blockers. The first frame compiles the kernels.
    ///
    /// # Errors
    /// [`GpuError`] where the device is too small for the blockers, or lost.
    pub fn new(gpu: &Gpu, occlusion: Occlusion<'_>) -> Result<Self, GpuError> {
        gpu.check()?;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let mut shader = Self {
            gpu: gpu.clone(),
            slice: if gpu.is_software() { SOFTWARE_SLICE } else { SLICE },
            blockers: Blockers::default(),
            kernels: Vec::new(),
            paper: None,
            look_again: LookAgain::Never,
            sky: Sky::default(),
            materials: Memory::new("materials", storage),
            images: Images::default(),
            max_lobes: 0,
            frames: Memory::new("lights", storage | BufferUsages::UNIFORM),
            queue: Memory::new("queue", storage | BufferUsages::COPY_SRC),
            indirect: Memory::new("dispatch", storage | BufferUsages::INDIRECT),
            clock: Clock::new(gpu),
            points: Memory::new("points", storage),
            radiance: Memory::new("radiance", storage | BufferUsages::COPY_SRC),
            staging: Memory::new("read-back", BufferUsages::MAP_READ | BufferUsages::COPY_DST),
            residents: [Resident::new(), Resident::new()],
            resolve: None,
            textures: Textures::default(),
            turn: on_device::FIRST,
        };
        shader.occlude(occlusion)?;
        Ok(shader)
    }

    /// Replaces the blockers, or moves them: only bytes that differ are uploaded, and shadow maps that are already there are not
    /// packed again.
    ///
    /// # Errors
    /// As [`new`](Self::new); nothing blocks then.
    pub fn occlude(&mut self, occlusion: Occlusion<'_>) -> Result<(), GpuError> {
        self.blockers.hold(&self.gpu, occlusion)
    }

    /// Moves the spheres that follow bones, on the GPU; `pose` must be made from the current blockers. The spheres stay so until
    /// the next pose or [`occlude`](Self::occlude). Uploads only the bones.
    ///
    /// # Errors
    /// [`GpuError::Bind`] for fewer joints or morph weights than the spheres need; no sphere has moved then.
    pub fn pose(&mut self, pose: &mut GpuPose, poses: &[(&[Mat4], &[f32])]) -> Result<(), GpuError> {
        self.blockers.pose(&self.gpu, pose, poses)
    }

    /// The GPU.
    #[must_use]
    pub const fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Uses the paper's method and uploads its tables (4.3 MB): the same as `PaperVisibility` with
    /// [`PaperIntegrator`](paper::PaperIntegrator) on the CPU. The first frame of a depth solves for the weights.
    #[must_use]
    pub fn with_paper(mut self, tables: &Tables) -> Self {
        self.set_paper(Some(tables));
        self
    }

    /// Uses the paper's method from the next frame on, or without tables the default one. Keeps the same tables if they are there.
    pub fn set_paper(&mut self, tables: Option<&Tables>) {
        let known = self.paper.take();
        self.paper =
            tables.map(|tables| known.filter(|known| known.is_of(tables)).unwrap_or_else(|| Paper::new(tables)));
    }

    /// Where masks are drawn again around a small lit part of a light, as [`MaskVisibility::look_again`](visibility_mask::MaskVisibility::look_again)
    /// says, in one window or in up to 16 cells, for lobes that are no narrower than the light. A new shader does so nowhere, and has smaller kernels.
    pub fn set_look_again(&mut self, again: LookAgain) {
        self.look_again = again;
    }

    /// Sums an environment at once from the next frame on: its table, and for each light of the frame whether it is one of its patches. One
    /// kernel, a workgroup a point, does what `SkyShader` of render-cpu does with one table. Patches shine on the lobes that the
    /// table's samples do not resolve, and on points that see less than an eighth of the sky.
    ///
    /// Patches are lights like others where a strategy has no [part for skies](shading::gpu::GpuBlockers::sky), by the paper's method, for materials
    /// of more than [16 lobes](visibility_mask::wgsl::SKY_MOST_LOBES), and on devices with too few storage buffers for the kernel.
    pub fn set_sky(&mut self, sky: Option<(&GpuSky, Vec<bool>)>) {
        self.sky.set(sky);
    }

    /// Shades at most this many points in one submission (made a multiple of 64): for tests and small memories.
    #[must_use]
    pub fn with_slice(self, points: u32) -> Self {
        Self { slice: u64::from(points).max(1).next_multiple_of(TILE).min(SLICE), ..self }
    }

    /// Points that the device's limits allow in a slice.
    fn slice(&self, stride: u64) -> u64 {
        let limits = self.gpu.device().limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let per_point =
            (size_of::<GpuReceiver>() as u64).max(4 * stride).max(self.blockers.bytes_per_tile() / TILE + 1);
        let groups = u64::from(limits.max_compute_workgroups_per_dimension) * TILE;
        let fits = (most.saturating_sub(HEADER) / per_point).min(groups);
        self.slice.min((fits / TILE).max(1) * TILE)
    }

    /// The kernels for a light; compiles them if they are new.
    fn kernels(
        &mut self,
        accuracy: Accuracy,
        materials: MaterialText,
        light: GpuText,
        (shown, roundness, is_patch): (Shown, Option<f32>, bool),
    ) -> Result<usize, GpuError> {
        let tolerance = accuracy.tolerance * roundness.map_or(1.0, visibility_mask::fill_factor);
        let variant = Variant {
            depth: mask_depth(accuracy),
            fineness: match self.paper {
                None => [Fineness::broad(tolerance), Fineness::narrow(tolerance)],
                Some(_) => [Fineness::FINE; 2],
            },
            materials,
            light,
            shown,
            own: self.blockers.own().to_vec(),
            stack: self.blockers.stack(),
            paper: self.paper.is_some(),
            is_patch,
            looks_again: self.paper.is_none() && self.look_again != LookAgain::Never,
        };
        self.blockers.compile_all(&self.gpu)?;
        if let Some(known) = self.kernels.iter().position(|(known, _)| *known == variant) {
            return Ok(known);
        }
        let make = |text: module::Text| Kernel::new(&self.gpu, &text);
        let blocked = variant.is_blocked();
        let kernels = Kernels {
            classify: make(module::classify(&variant))?,
            args: blocked.then(|| make(module::args())).transpose()?,
            penumbra: blocked.then(|| make(module::penumbra(&variant))).transpose()?,
        };
        self.kernels.push((variant, kernels));
        Ok(self.kernels.len() - 1)
    }

    /// Prepares everything that does not depend on the slice: kernels, materials, images.
    fn prepare<M: GpuMaterials, L: GpuLight>(&mut self, frame: &Frame<'_, M, L>) -> Result<Prepared, GpuError> {
        if self.paper.is_some() && frame.lights.iter().any(|light| light.gpu_roundness().is_some()) {
            return Err(GpuError::Unsupported(FLAT_BY_PAPER.to_owned()));
        }
        if let Some(paper) = &mut self.paper {
            paper.hold(&self.gpu, mask_depth(frame.accuracy))?;
        }
        // The paper's products are products of cosine lobes.
        let set = if self.paper.is_some() { M::gpu_cosine_set(frame.materials) } else { M::gpu_set(frame.materials) };
        let set = set.map_err(GpuError::Unsupported)?;
        if self.paper.is_some() && set.has_microfacets {
            return Err(GpuError::Unsupported(MICROFACETS_BY_PAPER.to_owned()));
        }
        let GpuMaterialSet { name, wgsl, needs, words, max_lobes, is_lambert, has_microfacets, has_grain } = set;
        self.materials.hold(&self.gpu, bytemuck::cast_slice(&words))?;
        self.max_lobes = max_lobes;
        let materials = MaterialText { name, wgsl, needs, is_lambert, has_microfacets, has_grain };
        let patches: Vec<usize> = (0..frame.lights.len()).filter(|light| self.sky.replaces(*light)).collect();
        let sky = match self.paper.is_none() && !patches.is_empty() {
            true => self.sky.prepare(&self.gpu, &self.blockers, (&materials, max_lobes))?,
            false => None,
        };
        let mut kernels = Vec::with_capacity(frame.lights.len());
        for (number, light) in frame.lights.iter().enumerate() {
            let is_patch = sky.is_some() && self.sky.replaces(number);
            let text = light.gpu_text(frame.lights).map_err(GpuError::Unsupported)?;
            let form = (Shown::of(light), light.gpu_roundness(), is_patch);
            kernels.push(self.kernels(frame.accuracy, materials.clone(), text, form)?);
        }
        self.images.hold(&self.gpu, frame.lights.iter().map(LightLobes::image))?;
        let words = frame.lights.iter().map(|light| Shown::of(light).words()).max().unwrap_or(1);
        Ok(Prepared { kernels, stride: 1 + words * u64::from(max_lobes), sky: sky.map(|kernel| (kernel, patches)) })
    }

    /// Shades `count` [`GpuReceiver`]s from the beginning of the GPU buffer `points`, and writes each one's radiance (RGB and a
    /// zero) to `radiance`. Submits to the queue and does not wait.
    ///
    /// Both are storage buffers of the same device; the caller ensures that they are large enough. Points whose material is
    /// [`NO_MATERIAL`](crate::NO_MATERIAL) get zero. Numbers of materials and lights are not checked: one out of range gives
    /// another material's lobes.
    ///
    /// # Errors
    /// [`GpuError`], but never [`GpuError::LoopsCut`], since this call does not wait for the kernels.
    pub fn submit<M: GpuMaterials, L: GpuLight>(
        &mut self,
        frame: &Frame<'_, M, L>,
        points: &wgpu::Buffer,
        count: u32,
        radiance: &wgpu::Buffer,
    ) -> Result<(), GpuError> {
        let prepared = self.prepare(frame)?;
        let mut part = Part { first: 0, count: self.slice(prepared.stride), uniforms: 0, points, radiance };
        while part.first < u64::from(count) {
            part.count = part.count.min(u64::from(count) - part.first);
            self.hold_uniforms(frame, &prepared, &[part.count])?;
            let mut encoder = self.encoder();
            self.write(&prepared, &part, &mut encoder, true)?;
            self.gpu.scoped("the commands of a slice", || self.gpu.queue().submit([encoder.finish()]))?;
            part.first += part.count;
        }
        Ok(())
    }

    /// As [`submit`](Self::submit), but writes the commands into the caller's encoder, which the caller submits once and before any
    /// other call of this shader. Lights, materials and blockers are uploaded now, into the buffers of the last call. New kernels
    /// are compiled here; to compile them earlier, call [`shade`](scene::Shade::shade) with such a frame and no points.
    ///
    /// # Errors
    /// As [`submit`](Self::submit). Commands that are then in the encoder are harmless.
    pub fn record<M: GpuMaterials, L: GpuLight>(
        &mut self,
        frame: &Frame<'_, M, L>,
        points: &wgpu::Buffer,
        count: u32,
        radiance: &wgpu::Buffer,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), GpuError> {
        let prepared = self.prepare(frame)?;
        let count = u64::from(count);
        let slice = self.slice(prepared.stride).min(count);
        // All slices but the last one have the same size.
        let last = if slice > 0 { (count - 1) % slice + 1 } else { 0 };
        self.hold_uniforms(frame, &prepared, &[slice, last])?;
        let mut part = Part { first: 0, count: slice, uniforms: 0, points, radiance };
        while part.first < count {
            if part.first + slice >= count {
                (part.count, part.uniforms) = (last, frame.lights.len() as u64);
            }
            self.write(&prepared, &part, encoder, false)?;
            part.first += part.count;
        }
        Ok(())
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Uploads the uniforms for slices of these sizes.
    fn hold_uniforms<M, L: GpuLight>(
        &mut self,
        frame: &Frame<'_, M, L>,
        prepared: &Prepared,
        counts: &[u64],
    ) -> Result<(), GpuError> {
        let bytes: Vec<u8> = counts.iter().flat_map(|count| self.uniforms(frame, prepared, *count)).collect();
        self.frames.sized(&self.gpu, FRAME_STRIDE)?;
        self.frames.hold(&self.gpu, &bytes)?;
        Ok(())
    }

    /// One uniform a light.
    fn uniforms<M, L: GpuLight>(&self, frame: &Frame<'_, M, L>, prepared: &Prepared, points: u64) -> Vec<u8> {
        let mut bytes = vec![0; frame.lights.len() * FRAME_STRIDE as usize];
        for ((number, light), bytes) in (0..).zip(frame.lights).zip(bytes.chunks_exact_mut(FRAME_STRIDE as usize)) {
            let bounds = light.gpu_bounds();
            let mut shape = [[0.0; 4]; GPU_SHAPE];
            shape.iter_mut().zip(light.gpu_shape()).for_each(|(row, of_light)| *row = of_light);
            let uniform = GpuFrame {
                light: bounds.center.extend(bounds.radius).to_array(),
                radiance: light.gpu_radiance(),
                shape,
                tolerance: frame.accuracy.tolerance,
                threshold: frame.threshold,
                point_count: points as u32,
                queue_stride: match prepared.is_patch(number as usize) {
                    // All patches have one length of items, behind which lies what the sky leaves to them.
                    true => prepared.stride as u32,
                    false => 1 + Shown::of(light).words() as u32 * self.max_lobes,
                },
                image: self.images.start(number),
                number,
                cells: (1_u32 << mask_depth(frame.accuracy)) as f32,
                look_again: self.look_again as u32,
                rounds: 2,
            };
            bytes[..size_of::<GpuFrame>()].copy_from_slice(bytemuck::bytes_of(&uniform));
        }
        bytes
    }

    /// Writes the commands for one slice, whose uniforms are uploaded, and times them if `is_timed`.
    fn write(
        &mut self,
        prepared: &Prepared,
        part: &Part<'_>,
        encoder: &mut wgpu::CommandEncoder,
        is_timed: bool,
    ) -> Result<(), GpuError> {
        let gpu = self.gpu.clone();
        let tiles = part.count.div_ceil(TILE);
        // Behind the items are the lobes that a sky leaves of each point.
        let left = u64::from(prepared.sky.is_some());
        let queue = self.queue.sized(&gpu, HEADER + 4 * (prepared.stride + left) * part.count)?.clone();
        let indirect = self.indirect.sized(&gpu, INDIRECT)?.clone();
        self.blockers.prepare(&gpu, tiles)?;
        let (mut clock, changes) = (self.clock.take(), self.blockers.take_changes());
        let timed = clock.as_mut().filter(|_| is_timed);
        let recorder = Recorder { shader: self, part, tiles, queue: &queue, indirect: &indirect, clock: timed };
        let recorded = gpu.scoped("the commands of a slice", || recorder.record(prepared, &changes, encoder));
        self.clock = clock;
        recorded
    }

    fn resource<'b>(&'b self, slot: Slot, part: &Part<'b>) -> Option<wgpu::BufferBinding<'b>> {
        let slice = |buffer: &'b wgpu::Buffer, size: u64| wgpu::BufferBinding {
            buffer,
            offset: part.first * size,
            size: NonZeroU64::new(part.count * size),
        };
        match slot {
            Slot::Frame => self.frames.get().map(|buffer| wgpu::BufferBinding {
                buffer,
                offset: 0,
                size: NonZeroU64::new(size_of::<GpuFrame>() as u64),
            }),
            Slot::Points => Some(slice(part.points, size_of::<GpuReceiver>() as u64)),
            Slot::Radiance => Some(slice(part.radiance, 16)),
            Slot::Materials => self.materials.whole(),
            Slot::Queue => self.queue.whole(),
            Slot::Indirect => self.indirect.whole(),
            Slot::Images => self.images.whole(),
            Slot::Sky => self.sky.resource(),
            Slot::Tables => self.paper.as_ref().and_then(Paper::resource),
            _ => self.blockers.resource(slot),
        }
    }
}

/// A slice of points.
struct Part<'a> {
    first: u64,
    count: u64,
    /// The number of its first uniform.
    uniforms: u64,
    points: &'a wgpu::Buffer,
    radiance: &'a wgpu::Buffer,
}
