//! Tests that need a GPU, at least a software one: shown as ignored without one.

mod call;
mod flat;
mod functions;
mod gbuffer;
mod maps;
mod masks;
mod materials;
mod openings;
mod paper;
mod parity;
mod picture;
mod pose;
mod rays;
mod robust;
mod silhouettes;
mod sky;
mod spheres;
mod texture_writer;

use render_gpu::{Gpu, GpuOptions};

fn main() {
    let arguments = libtest_mimic::Arguments::from_args();
    let gpu = Gpu::blocking(&GpuOptions::default());
    if let Err(error) = &gpu {
        eprintln!("GPU tests are ignored: {error}");
    }
    let gpu = gpu.ok();
    let mut trials = Vec::new();
    trials.extend(flat::trials(gpu.as_ref()));
    trials.extend(functions::trials(gpu.as_ref()));
    trials.extend(gbuffer::trials(gpu.as_ref()));
    trials.extend(maps::trials(gpu.as_ref()));
    trials.extend(masks::trials(gpu.as_ref()));
    trials.extend(parity::trials(gpu.as_ref()));
    trials.extend(materials::trials(gpu.as_ref()));
    trials.extend(openings::trials(gpu.as_ref()));
    trials.extend(paper::trials(gpu.as_ref()));
    trials.extend(picture::trials(gpu.as_ref()));
    trials.extend(pose::trials(gpu.as_ref()));
    trials.extend(rays::trials(gpu.as_ref()));
    trials.extend(robust::trials(gpu.as_ref()));
    trials.extend(silhouettes::trials(gpu.as_ref()));
    trials.extend(sky::trials(gpu.as_ref()));
    trials.extend(spheres::trials(gpu.as_ref()));
    trials.extend(texture_writer::trials(gpu.as_ref()));
    let conclusion = libtest_mimic::run(&arguments, trials);
    call::report_kernels();
    conclusion.exit();
}
