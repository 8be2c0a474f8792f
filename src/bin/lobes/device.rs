//! What shades: the cores of the CPU, or a GPU.

use crate::args::{Device, RenderArgs, Visibility};
use crate::console::note;
use crate::failure::Failure;
use crate::strategy::Plan;
use cosine_lobes::lobe_core::VisibilityLobes;
use cosine_lobes::render_cpu::{CpuShader, Layers};
use cosine_lobes::render_gpu::{Gpu, GpuError, GpuOptions, GpuShader, Occlusion};
use cosine_lobes::scene::{Frame, Scene, Shade, ShadeStats, ShadingPoints, Strategy};
use glam::Vec3;
use std::error::Error;

/// What shades all frames of a command.
pub(crate) enum Backend {
    Cpu,
    Gpu(Box<GpuShader>),
}

impl Backend {
    /// The device that is asked for. What a GPU lacks is refused, or left to the CPU where the choice is free.
    pub(crate) fn new(args: &RenderArgs, plan: &Plan, scene: &Scene) -> Result<Self, Failure> {
        let lack = || lack(args, plan, scene);
        match args.device {
            Device::Cpu => Ok(Self::Cpu),
            Device::Gpu => match lack() {
                Some(lack) => Err(Failure::new(format_args!("--device gpu: {lack}"))),
                None => open().map_err(|error| match error {
                    // What wgpu tells of it is a list of all that it was built without.
                    GpuError::NoAdapter { .. } => Failure::new(
                        "--device gpu: no GPU adapter; install a Vulkan driver (a software one: packages libvulkan1 and \
                         mesa-vulkan-drivers), or take --device cpu",
                    ),
                    error => Failure::new(format_args!("--device gpu: {error}")),
                }),
            },
            Device::Auto => {
                let backend = match lack() {
                    Some(lack) => Err(lack),
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

    /// `cpu`, or what the GPU calls itself.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Cpu => "cpu".to_owned(),
            Self::Gpu(shader) => shader.gpu().name(),
        }
    }
}

fn open() -> Result<Backend, GpuError> {
    let gpu = Gpu::blocking(&GpuOptions::default())?;
    Ok(Backend::Gpu(Box::new(GpuShader::new(&gpu, Occlusion::default())?)))
}

/// A GPU that is worth choosing: software ones are slower than the CPU's own path.
fn hardware(backend: Result<Backend, GpuError>) -> Result<Backend, String> {
    match backend {
        Ok(Backend::Gpu(shader)) if shader.gpu().is_software() => {
            Err(format!("{} is no hardware", shader.gpu().name()))
        }
        Err(GpuError::NoAdapter { .. }) => Err("there is no GPU adapter".to_owned()),
        other => other.map_err(|error| error.to_string()),
    }
}

/// What the command or the scene needs and a GPU does not have, and what to do about it.
fn lack(args: &RenderArgs, plan: &Plan, scene: &Scene) -> Option<String> {
    if args.layers {
        return Some("--layers are made by the CPU only".to_owned());
    }
    if args.visibility == Visibility::Rays {
        return Some("--visibility rays is there on the CPU only (spheres, shadow-map and none on both)".to_owned());
    }
    let object = (0..scene.objects.len()).find(|object| plan.of(*object) == Strategy::Rays)?;
    let name = &scene.objects[object].name;
    Some(format!(
        "object \"{name}\" is by rays, which are there on the CPU only (instead its key `visibility`, or --visibility \
         for all objects: spheres, shadow-map or none)"
    ))
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
        Err(Failure::new("--layers are made by the CPU only"))
    }
}
