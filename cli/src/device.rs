//! The choice of the device, and messages about it.

use crate::args::{self, RenderArgs};
use crate::console::note;
use crate::failure::Failure;
use cosine_lobes::brdf::PackedMaterials;
use cosine_lobes::render_gpu::{CompiledKernel, GpuError, KernelLog};
use cosine_lobes::renderer::{Backend, Device, RenderError, Renderer, Settings};
use cosine_lobes::scene::{Animation, Scene, other_light_error};
use std::time::Duration;

/// A renderer on the requested device. Features that a GPU lacks are refused, or left to the CPU where the choice is free.
pub(crate) fn renderer(
    args: &RenderArgs,
    scene: Scene,
    animation: Animation,
    settings: Settings,
) -> Result<Renderer, Failure> {
    let quiet = args.view.console.quiet;
    let backend = match args.device {
        args::Device::Cpu => Backend::Cpu,
        args::Device::Gpu => {
            settings.check_device(Device::Gpu).and_then(|()| Backend::open(Device::Gpu)).map_err(explain)?
        }
        args::Device::Auto => {
            let knows = PackedMaterials::new(&scene.materials).map(|_| ());
            let open = || hardware(settings.check_device(Device::Gpu).and_then(|()| Backend::open(Device::Gpu)));
            let gpu = knows.and_then(|()| open());
            if !quiet {
                match &gpu {
                    Ok(gpu) => note(format_args!("lobes: note: --device auto: {}", gpu.name())),
                    Err(reason) => note(format_args!("lobes: note: --device auto: cpu, since {reason}")),
                }
            }
            gpu.unwrap_or(Backend::Cpu)
        }
    };
    let renderer = Renderer::with_backend(scene, animation, settings, backend).map_err(|error| {
        match (&error, &args.view.file) {
            (RenderError::PaperLight(..), Some(file)) => other_light_error(file, &error.to_string()).into(),
            _ => explain(error),
        }
    })?;
    watch_all(renderer.backend(), quiet);
    Ok(renderer)
}

/// A GPU, and no other device.
pub(crate) fn gpu(quiet: bool) -> Result<Backend, Failure> {
    let backend = Backend::open(Device::Gpu).map_err(explain)?;
    watch_all(&backend, quiet);
    Ok(backend)
}

fn explain(error: RenderError) -> Failure {
    match error {
        // The message of wgpu lists everything that it was built without, so it is replaced.
        RenderError::Gpu(GpuError::NoAdapter { .. }) => Failure::new(
            "--device gpu: no GPU adapter; install a Vulkan driver (a software one: packages libvulkan1 and \
             mesa-vulkan-drivers), or take --device cpu",
        ),
        RenderError::Gpu(_) | RenderError::NotOnGpu(_) => Failure::new(format_args!("--device gpu: {error}")),
        error => Failure::new(error),
    }
}

/// The kernels that were compiled, the slowest first.
pub(crate) fn kernels(backend: &Backend) -> Vec<CompiledKernel> {
    backend.gpu().map(|gpu| gpu.kernels().compiled()).unwrap_or_default()
}

fn watch_all(backend: &Backend, quiet: bool) {
    if let Some(gpu) = backend.gpu().filter(|_| !quiet) {
        watch(gpu.kernels().clone());
    }
}

/// Kernels that compile for longer are reported.
const LONG: Duration = Duration::from_secs(10);

/// Reports kernels that take the driver long, from a thread of its own, because the shading thread waits for the driver meanwhile.
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
    // Without a thread there are no reports.
    let _ = std::thread::Builder::new().name("kernels".to_owned()).spawn(look);
}

/// A line for each kernel that has become slow, and one when it is done; `slow` lists the reported kernels that are not done.
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
fn hardware(backend: Result<Backend, RenderError>) -> Result<Backend, String> {
    match backend {
        Ok(backend) if backend.gpu().is_some_and(|gpu| !gpu.is_software()) => Ok(backend),
        Ok(backend) => Err(format!("{} is no hardware", backend.name())),
        Err(RenderError::Gpu(GpuError::NoAdapter { .. })) => Err("there is no GPU adapter".to_owned()),
        Err(error) => Err(error.to_string()),
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
