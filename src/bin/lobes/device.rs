//! What shades: the cores of the CPU, or a GPU.

use crate::args::{Device, RenderArgs};
use crate::console::note;
use crate::failure::Failure;
use crate::strategy::Plan;
use cosine_lobes::lobe_core::{Method, VisibilityLobes};
use cosine_lobes::render_cpu::{CpuShader, Layers};
use cosine_lobes::render_gpu::{CompiledKernel, Gpu, GpuError, GpuOptions, GpuShader, GpuWorld, KernelLog, Occlusion};
use cosine_lobes::scene::{Frame, Scene, Shade, ShadeStats, ShadingPoints};
use cosine_lobes::visibility_shadowmap::ShadowMapBlockers;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;
use std::error::Error;
use std::time::Duration;

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
                None => Self::gpu(args.view.quiet),
            },
            Device::Auto => {
                let backend = match lack(args) {
                    Some(lack) => Err(lack.to_owned()),
                    None => hardware(open(args.view.quiet)),
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
    pub(crate) fn gpu(quiet: bool) -> Result<Self, Failure> {
        open(quiet).map_err(|error| match error {
            // What wgpu tells of it is a list of all that it was built without.
            GpuError::NoAdapter { .. } => Failure::new(
                "--device gpu: no GPU adapter; install a Vulkan driver (a software one: packages libvulkan1 and \
                 mesa-vulkan-drivers), or take --device cpu",
            ),
            error => Failure::new(format_args!("--device gpu: {error}")),
        })
    }

    /// The kernels that were compiled, the slowest first.
    pub(crate) fn kernels(&self) -> Vec<CompiledKernel> {
        match self {
            Self::Cpu => Vec::new(),
            Self::Gpu(gpu) => gpu.shader.gpu().kernels().compiled(),
        }
    }

    /// The most bytes of shadow maps that it can use.
    pub(crate) fn room_for_maps(&self) -> u64 {
        match self {
            Self::Cpu => u64::MAX,
            Self::Gpu(gpu) => gpu.shader.gpu().room_for_maps(),
        }
    }

    /// `cpu`, or what the GPU calls itself.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Cpu => "cpu".to_owned(),
            Self::Gpu(gpu) => gpu.shader.gpu().name(),
        }
    }
}

fn open(quiet: bool) -> Result<Backend, GpuError> {
    let gpu = Gpu::blocking(&GpuOptions::default())?;
    if !quiet {
        watch(gpu.kernels().clone());
    }
    let shader = GpuShader::new(&gpu, Occlusion::default())?;
    Ok(Backend::Gpu(Box::new(GpuBackend { shader, world: None })))
}

/// Kernels that compile for longer are told of.
const LONG: Duration = Duration::from_secs(10);

/// Tells of kernels that take the driver long, from a thread of its own: whoever shades waits for the driver meanwhile.
fn watch(log: KernelLog) {
    let mut slow = Vec::new();
    let look = move || {
        loop {
            std::thread::sleep(Duration::from_millis(500));
            for line in news(&mut slow, &log.compiling(), &log.compiled()) {
                note(line);
            }
        }
    };
    // Without a thread nothing is told.
    let _ = std::thread::Builder::new().name("kernels".to_owned()).spawn(look);
}

/// A line for each kernel that has become slow, and one when it is done; `slow` are those that were told of and are not done.
fn news(slow: &mut Vec<String>, compiling: &[CompiledKernel], compiled: &[CompiledKernel]) -> Vec<String> {
    let mut lines = Vec::new();
    slow.retain(|name| {
        let is_running = compiling.iter().any(|kernel| kernel.name == *name);
        if let Some(CompiledKernel { name, time }) = compiled.iter().find(|kernel| kernel.name == *name && !is_running)
        {
            lines.push(format!("lobes: note: the GPU's driver compiled {name} in {:.1} s", time.as_secs_f64()));
        }
        is_running
    });
    for kernel in compiling.iter().filter(|kernel| kernel.time >= LONG) {
        if !slow.contains(&kernel.name) {
            let (name, seconds) = (&kernel.name, kernel.time.as_secs());
            lines.push(format!("lobes: note: the GPU's driver has been compiling {name} for {seconds} s"));
            slow.push(name.clone());
        }
    }
    lines
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
    /// With the objects that are in it.
    world: Option<(GpuWorld, Vec<bool>)>,
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
        if let Some((scene, plan)) = traced {
            let objects: Vec<bool> = (0..scene.objects.len() as u32).map(|o| plan.traces_on_gpu(scene, o)).collect();
            match &mut self.world {
                // What maps show changes as lights move.
                Some((world, kept)) if *kept == objects => world.update(scene)?,
                world => {
                    let traced = GpuWorld::only(self.shader.gpu(), scene, |o| objects[o as usize])?;
                    *world = Some((traced, objects));
                }
            }
        } else {
            self.world = None;
        }
        self.shader.set_method(method);
        self.shader.occlude(Occlusion { spheres, maps, rays: self.world.as_ref().map(|(world, _)| world) })?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_kernels_are_told_of_twice() {
        let kernel =
            |name: &str, seconds: f64| CompiledKernel { name: name.to_owned(), time: Duration::from_secs_f64(seconds) };
        let mut slow = Vec::new();
        assert!(news(&mut slow, &[kernel("cull", 9.9)], &[kernel("trace", 60.0)]).is_empty());
        let (cull, args) = (kernel("cull", 10.4), kernel("args", 1.0));
        assert_eq!(
            news(&mut slow, &[cull.clone(), args], &[]),
            ["lobes: note: the GPU's driver has been compiling cull for 10 s"]
        );
        assert!(news(&mut slow, &[cull], &[]).is_empty());
        let done = [kernel("cull", 25.04), kernel("args", 2.0)];
        assert_eq!(news(&mut slow, &[], &done), ["lobes: note: the GPU's driver compiled cull in 25.0 s"]);
        assert!(news(&mut slow, &[], &done).is_empty());
    }
}
