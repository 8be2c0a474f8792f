//! What shades: the cores of the CPU, or a GPU.

use crate::args::{Device, RenderArgs};
use crate::console::note;
use crate::failure::Failure;
use crate::strategy::Plan;
use cosine_lobes::lobe_core::{Method, VisibilityLobes};
use cosine_lobes::render_cpu::{CpuShader, Layers};
use cosine_lobes::render_gpu::{Gpu, GpuError, GpuOptions, GpuShader, GpuWorld, Occlusion};
use cosine_lobes::scene::{Frame, Scene, Shade, ShadeStats, ShadingPoints};
use cosine_lobes::visibility_shadowmap::ShadowMapBlockers;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;
use std::error::Error;

/// What shades all frames of a command.
pub(crate) enum Backend {
    Cpu,
    Gpu(Box<GpuBackend>),
}

impl Backend {
    /// The device that is asked for. What a GPU lacks is refused, or left to the CPU where the choice is free.
    pub(crate) fn new(args: &RenderArgs) -> Result<Self, Failure> {
        match args.device {
            Device::Cpu => Ok(Self::Cpu),
            Device::Gpu => match lack(args) {
                Some(lack) => Err(Failure::new(format_args!("--device gpu: {lack}"))),
                None => Self::gpu(),
            },
            Device::Auto => {
                let backend = match lack(args) {
                    Some(lack) => Err(lack.to_owned()),
                    None => hardware(open()),
                };
                if !args.view.quiet {
                    match &backend {
                        Ok(gpu) => note(format_args!("lobes: note: --device auto: {}", gpu.name())),
                        Err(reason) => note(format_args!("lobes: note: --device auto: cpu, since {reason}")),
                    }
                }
                Ok(backend.unwrap_or(Self::Cpu))
            }
        }
    }

    /// A GPU, and no other device.
    pub(crate) fn gpu() -> Result<Self, Failure> {
        open().map_err(|error| match error {
            // What wgpu tells of it is a list of all that it was built without.
            GpuError::NoAdapter { .. } => Failure::new(
                "--device gpu: no GPU adapter; install a Vulkan driver (a software one: packages libvulkan1 and \
                 mesa-vulkan-drivers), or take --device cpu",
            ),
            error => Failure::new(format_args!("--device gpu: {error}")),
        })
    }

    /// `cpu`, or what the GPU calls itself.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Cpu => "cpu".to_owned(),
            Self::Gpu(gpu) => gpu.shader.gpu().name(),
        }
    }
}

fn open() -> Result<Backend, GpuError> {
    let gpu = Gpu::blocking(&GpuOptions::default())?;
    let shader = GpuShader::new(&gpu, Occlusion::default())?;
    Ok(Backend::Gpu(Box::new(GpuBackend { shader, world: None })))
}

/// A GPU that is worth choosing: software ones are slower than the CPU's own path.
fn hardware(backend: Result<Backend, GpuError>) -> Result<Backend, String> {
    match backend {
        Ok(Backend::Gpu(gpu)) if gpu.shader.gpu().is_software() => {
            Err(format!("{} is no hardware", gpu.shader.gpu().name()))
        }
        Err(GpuError::NoAdapter { .. }) => Err("there is no GPU adapter".to_owned()),
        other => other.map_err(|error| error.to_string()),
    }
}

/// What is asked for and a GPU does not have.
fn lack(args: &RenderArgs) -> Option<&'static str> {
    args.layers.then_some(LAYERS)
}

const LAYERS: &str = "--layers are made by the CPU only";

/// A GPU's shader, and what its rays meet.
pub(crate) struct GpuBackend {
    shader: GpuShader,
    world: Option<GpuWorld>,
}

impl GpuBackend {
    /// The shader with these blockers; `traced` is the scene, where some of its objects are by rays, and the plan that says
    /// which: the same one with each call.
    pub(crate) fn occluded(
        &mut self,
        method: Method<'_>,
        spheres: Option<&SphereBlockers>,
        maps: Option<&ShadowMapBlockers>,
        traced: Option<(&Scene, &Plan)>,
    ) -> Result<&mut GpuShader, GpuError> {
        match (traced, &mut self.world) {
            (None, world) => *world = None,
            (Some((scene, _)), Some(world)) => world.update(scene)?,
            (Some((scene, plan)), world) => {
                *world = Some(GpuWorld::only(self.shader.gpu(), scene, |o| plan.traces_on_gpu(scene, o))?)
            }
        }
        self.shader.set_method(method);
        self.shader.occlude(Occlusion { spheres, maps, rays: self.world.as_ref() })?;
        Ok(&mut self.shader)
    }
}

/// What shades, whatever it computes on.
pub(crate) trait Shader: Shade<Error: Error> {
    /// Shades, and tells what the picture is made of.
    fn shade_layers(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
    ) -> Result<(ShadeStats, Layers), Failure>;
}

impl<V: VisibilityLobes> Shader for CpuShader<'_, V> {
    fn shade_layers(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_>,
        out: &mut [Vec3],
    ) -> Result<(ShadeStats, Layers), Failure> {
        Ok(CpuShader::shade_layers(self, points, frame, out)?)
    }
}

impl Shader for GpuShader {
    fn shade_layers(
        &mut self,
        _: &ShadingPoints,
        _: &Frame<'_>,
        _: &mut [Vec3],
    ) -> Result<(ShadeStats, Layers), Failure> {
        Err(Failure::new(LAYERS))
    }
}
