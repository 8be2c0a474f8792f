//! Evaluates WGSL functions on rows of numbers, and builds trials.

use libtest_mimic::Trial;
use render_gpu::{Gpu, GpuOptions};
use std::sync::{Mutex, PoisonError};
use wgpu::util::DeviceExt;

/// Idle devices, with their compiled kernels. Each running test has a device of its own, since a software driver compiles all
/// kernels of a device in one thread.
static FREE: Mutex<Vec<Gpu>> = Mutex::new(Vec::new());

fn free() -> std::sync::MutexGuard<'static, Vec<Gpu>> {
    FREE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A test of the GPU, ignored without one.
pub(crate) fn trial(name: &str, gpu: Option<&Gpu>, test: fn(&Gpu)) -> Trial {
    let run = move || {
        let known = free().pop();
        let gpu = known.map_or_else(|| Gpu::blocking(&GpuOptions::default()), Ok)?;
        test(&gpu);
        free().push(gpu);
        Ok(())
    };
    Trial::test(name, run).with_ignored_flag(gpu.is_none())
}

/// Prints the kernels that took longest to compile: nearly all of these tests' time on a software driver.
pub(crate) fn report_kernels() {
    let mut all: Vec<_> = free().iter().flat_map(|gpu| gpu.kernels().compiled()).collect();
    if all.is_empty() {
        return;
    }
    all.sort_by_key(|kernel| core::cmp::Reverse(kernel.time));
    let sum: f32 = all.iter().map(|kernel| kernel.time.as_secs_f32()).sum();
    println!("{} kernels of shaders, {sum:.0} s; the slowest:", all.len());
    for kernel in all.iter().take(8) {
        println!("{:6.1} s {}", kernel.time.as_secs_f32(), kernel.name);
    }
}

/// Evaluates WGSL statements for rows of `inputs` numbers each. `text` is before `body`, which reads `x(0), x(1) …` and
/// calls `y(0, value)`, … up to `outputs`.
pub(crate) fn call(gpu: &Gpu, text: &str, body: &str, rows: &[f32], inputs: usize, outputs: usize) -> Vec<f32> {
    call_with(gpu, text, body, rows, [inputs, outputs], &[])
}

/// [`call`] with further buffers for the text: bindings from 2 on, and the words of each.
pub(crate) fn call_with(
    gpu: &Gpu,
    text: &str,
    body: &str,
    rows: &[f32],
    [inputs, outputs]: [usize; 2],
    words: &[(u32, &[u32])],
) -> Vec<f32> {
    let count = rows.len() / inputs;
    let main = format!(
        "@group(0) @binding(0) var<storage, read> in: array<f32>;
        @group(0) @binding(1) var<storage, read_write> out: array<f32>;
        var<private> row: u32;
        fn x(k: u32) -> f32 {{ return in[row * {inputs}u + k]; }}
        fn y(k: u32, value: f32) {{ out[row * {outputs}u + k] = value; }}
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {{
            row = id.x;
            if (row < {count}u) {{ {body} }}
        }}"
    );
    run(gpu, text, &main, rows, count * outputs, words, count.div_ceil(64))
}

/// [`call`] with a workgroup of LANES threads for each row of `inputs`: all threads run `body`, each with its `lane`.
pub(crate) fn call_groups(gpu: &Gpu, text: &str, body: &str, rows: &[f32], [inputs, outputs]: [usize; 2]) -> Vec<f32> {
    let count = rows.len() / inputs;
    let main = format!(
        "@group(0) @binding(0) var<storage, read> in: array<f32>;
        @group(0) @binding(1) var<storage, read_write> out: array<f32>;
        var<private> row: u32;
        fn x(k: u32) -> f32 {{ return in[row * {inputs}u + k]; }}
        fn y(k: u32, value: f32) {{ out[row * {outputs}u + k] = value; }}
        @compute @workgroup_size(LANES) fn main(
            @builtin(workgroup_id) id: vec3u,
            @builtin(local_invocation_index) lane: u32,
        ) {{
            row = id.x;
            {body}
        }}"
    );
    run(gpu, text, &main, rows, count * outputs, &[], count)
}

/// Dispatches `groups` workgroups of a module that reads `rows` and writes `size` numbers.
fn run(
    gpu: &Gpu,
    text: &str,
    main: &str,
    rows: &[f32],
    size: usize,
    words: &[(u32, &[u32])],
    groups: usize,
) -> Vec<f32> {
    let text = format!("{text}\n{main}");
    let device = gpu.device();
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let filled = |contents| {
        let usage = wgpu::BufferUsages::STORAGE;
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let input = filled(bytemuck::cast_slice(rows));
    let further: Vec<_> =
        words.iter().map(|(binding, words)| (*binding, filled(bytemuck::cast_slice(words)))).collect();
    let size = (4 * size) as u64;
    let buffer =
        |usage| device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let out = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    fn entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
        wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
    }
    let mut entries = vec![entry(0, &input), entry(1, &out)];
    entries.extend(further.iter().map(|(binding, buffer)| entry(*binding, buffer)));
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&out, 0, &read, 0, size);
    gpu.queue().submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let view = read.slice(..).get_mapped_range().expect("mapped");
    bytemuck::cast_slice(&view).to_vec()
}

/// The bytes of a texture, `pixel` of each pixel.
pub(crate) fn texture_bytes(gpu: &Gpu, texture: &wgpu::Texture, pixel: u32) -> Vec<u8> {
    let (width, row) = ((pixel * texture.width()) as usize, (pixel * texture.width()).next_multiple_of(256));
    let read = gpu.device().create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * texture.height()),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &read, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    gpu.queue().submit([encoder.finish()]);
    read.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let view = read.slice(..).get_mapped_range().expect("mapped");
    view.chunks_exact(row as usize).flat_map(|row| &row[..width]).copied().collect()
}
