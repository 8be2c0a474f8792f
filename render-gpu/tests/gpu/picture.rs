//! Pictures that stay on the device.

use crate::call::{texture_bytes, trial};
use core::ops::ControlFlow;
use glam::Vec3;
use libtest_mimic::Trial;
use lobe_core::Random;
use pictures::{Display, ToneMap, Window};
use render_cpu::{GBuffer, PixelSamples, World, blockers};
use render_gpu::{Gpu, GpuDisplay, GpuPicture, GpuShader, Occlusion, PixelMeans};
use scene::{Cancel, Frame, Scene, Shade, ShadingPoints};
use shading::Accuracy;
use test_scenes::floor_and_sphere;
use visibility_spheres::SphereBlockers;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("pictures_on_the_device_are_those_of_the_cpu", gpu, as_on_the_cpu),
        trial("pictures_that_are_cancelled_can_be_made_again", gpu, cancelled),
        trial("displays_show_the_bytes_of_the_cpu", gpu, displays),
        trial("textures_are_used_again_once_they_are_free", gpu, textures),
        trial("other_threads_submit_while_one_waits", gpu, others_submit),
    ]
}

const SIZE: [u32; 2] = [51, 30];

fn points(scene: &Scene, samples: PixelSamples, rows: core::ops::Range<u32>) -> GBuffer {
    let world = World::new(scene);
    GBuffer::sampled(&world, SIZE, samples, [0..SIZE[0], rows], &Cancel::new()).expect("not cancelled")
}

fn spheres(scene: &Scene) -> SphereBlockers {
    let set = blockers(scene, &mut |_, _| ControlFlow::Continue(())).expect("exact spheres");
    SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances).with_self_shadows(&set.self_shadows)
}

fn means<'a>(g: &'a GBuffer, top: u32, stamp: u64, rest: &'a [Vec3]) -> PixelMeans<'a> {
    PixelMeans {
        stamp,
        corner: [0, top],
        size: [g.width, g.height],
        pixels: &g.pixels,
        rays: &g.rays,
        samples: g.samples,
        rest,
    }
}

/// The picture of points, made on the device.
fn shaded(shader: &mut GpuShader, scene: &Scene, parts: &[(u32, u64, &GBuffer)], rest: Option<Vec3>) -> GpuPicture {
    let picture = shader.picture(SIZE).expect("it fits");
    for (top, stamp, g) in parts {
        let frame =
            Frame { materials: &g.materials, lights: &scene.lights, accuracy: Accuracy::new(0.003), threshold: 0.0 };
        // A picture of nothing but the background.
        let rest = rest.map_or(Vec::new(), |rest| g.resolve(&vec![Vec3::ZERO; g.len()], rest));
        let means = means(g, *top, *stamp, &rest);
        let done = shader.shade_picture(&g.points, &means, &frame, &picture, None);
        pollster::block_on(done).expect("a GPU").expect("not cancelled");
    }
    picture
}

fn largest_difference(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}

/// One ray a pixel, several at edges, several everywhere; in one part and in two; with a background.
fn as_on_the_cpu(gpu: &Gpu) {
    let scene = floor_and_sphere();
    let blockers = spheres(&scene);
    let mut shader = GpuShader::new(gpu, Occlusion::of(&[&blockers])).expect("it fits");
    let mut stamp = 0;
    for samples in [PixelSamples::Uniform(1), PixelSamples::Edges(8), PixelSamples::Uniform(16)] {
        let g = points(&scene, samples, 0..SIZE[1]);
        let frame =
            Frame { materials: &g.materials, lights: &scene.lights, accuracy: Accuracy::new(0.003), threshold: 0.0 };
        let mut radiance = vec![Vec3::ZERO; g.len()];
        shader.shade(&g.points, &frame, &mut radiance).expect("a GPU");
        let [upper, lower] = [0..16, 16..SIZE[1]].map(|rows| points(&scene, samples, rows));
        for background in [None, Some(Vec3::new(0.1, 0.5, 2.0))] {
            let want = g.picture(&radiance, background.unwrap_or_default());
            let peak = want.iter().map(|p| p.max_element()).fold(0.0, f32::max);
            stamp += 3;
            let whole = shaded(&mut shader, &scene, &[(0, stamp, &g)], background);
            let again = shaded(&mut shader, &scene, &[(0, stamp, &g)], background);
            let halves = shaded(&mut shader, &scene, &[(0, stamp + 1, &upper), (16, stamp + 2, &lower)], background);
            let pixels = whole.radiance().expect("a GPU");
            let difference = largest_difference(pixels, &want);
            println!("{samples:?}: {difference:e} of {peak}");
            assert!(difference <= 2e-6 * peak && peak > 0.02, "{samples:?}: {difference:e} of {peak}");
            assert!(pixels == again.radiance().expect("a GPU"), "points that are there already");
            // Rounding aside: a part has other tiles.
            let difference = largest_difference(halves.radiance().expect("a GPU"), &want);
            assert!(difference <= 1e-3 * peak, "{samples:?}: {difference:e} of {peak}");
        }
    }
}

/// A stop before the first submission gives nothing; the next call all.
fn cancelled(gpu: &Gpu) {
    let scene = floor_and_sphere();
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("it fits");
    let g = points(&scene, PixelSamples::Edges(4), 0..SIZE[1]);
    let frame =
        Frame { materials: &g.materials, lights: &scene.lights, accuracy: Accuracy::new(0.003), threshold: 0.0 };
    let picture = shader.picture(SIZE).expect("it fits");
    let cancel = Cancel::new();
    cancel.cancel();
    let means = means(&g, 0, 1, &[]);
    let done = shader.shade_picture(&g.points, &means, &frame, &picture, Some(&cancel));
    assert!(pollster::block_on(done).expect("a GPU").is_none());
    let (first, second) =
        (shaded(&mut shader, &scene, &[(0, 1, &g)], None), shaded(&mut shader, &scene, &[(0, 2, &g)], None));
    assert!(first.radiance().expect("a GPU") == second.radiance().expect("a GPU"));
}

/// A picture of given pixels: nothing but radiance besides that of points.
fn given(shader: &mut GpuShader, size: [u32; 2], pixels: &[Vec3]) -> GpuPicture {
    let picture = shader.picture(size).expect("it fits");
    let means = PixelMeans { stamp: 7, corner: [0; 2], size, pixels: &[], rays: &[], samples: 1, rest: pixels };
    let frame: Frame<'_> = Frame::new(&[], &[], Accuracy::default());
    let points = ShadingPoints::default();
    let done = shader.shade_picture(&points, &means, &frame, &picture, None);
    pollster::block_on(done).expect("a GPU").expect("not cancelled");
    picture
}

/// Every tone map and exposure, over fourteen orders of magnitude, and values that are no radiance.
fn displays(gpu: &Gpu) {
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("it fits");
    let show = GpuDisplay::new(gpu).expect("it fits");
    let size = [130, 77];
    let mut random = Random::new(3);
    let hostile = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, f32::MIN_POSITIVE, f32::MAX, 1.0];
    let mut channel = || match random.uniform() as f32 {
        u if u < 0.02 => hostile[(u * 400.0) as usize % 8],
        u => 10.0_f32.powf(14.0 * u - 9.0),
    };
    let pixels: Vec<Vec3> = (0..size[0] * size[1]).map(|_| Vec3::new(channel(), channel(), channel())).collect();
    let picture = given(&mut shader, size, &pixels);
    for tone in [ToneMap::Linear, ToneMap::Soft, ToneMap::Neutral, ToneMap::Agx] {
        for exposure in [-3.3, 0.0, 1.7] {
            let display = Display { exposure, tone, ..Display::default() };
            let want = display.bytes(&pixels, &Window::whole(size[0] as usize, size[1] as usize));
            let got = texture_bytes(gpu, &show.show(&picture, &display).expect("a GPU"), 4);
            let pairs = || got.as_chunks::<4>().0.iter().zip(want.as_chunks::<3>().0);
            assert!(pairs().all(|(got, _)| got[3] == 255));
            let differences: Vec<u8> =
                pairs().flat_map(|(got, want)| (0..3).map(move |k| got[k].abs_diff(want[k]))).collect();
            let others = differences.iter().filter(|d| **d > 0).count() as f64 / differences.len() as f64;
            println!("{tone:?} {exposure}: {:.3} % of the bytes are others", 100.0 * others);
            assert!(differences.iter().all(|d| *d <= 1) && others < 2e-3, "{tone:?} {exposure}: {others}");
        }
    }
    assert!(!picture.is_read(), "shown without a copy on the CPU");
}

/// A picture that is dropped leaves its texture to the next one; a picture that is looked at keeps it.
fn textures(gpu: &Gpu) {
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("it fits");
    let first = given(&mut shader, [2, 1], &[Vec3::ONE, Vec3::X]);
    let second = given(&mut shader, [2, 1], &[Vec3::Y, Vec3::Z]);
    assert_eq!(first.radiance().expect("a GPU"), [Vec3::ONE, Vec3::X]);
    let texture = first.texture().clone();
    drop(first);
    let third = given(&mut shader, [2, 1], &[Vec3::ZERO, Vec3::ONE]);
    assert!(*third.texture() == texture && *second.texture() != texture);
    assert_eq!(second.radiance().expect("a GPU"), [Vec3::Y, Vec3::Z]);
    assert_eq!(third.radiance().expect("a GPU"), [Vec3::ZERO, Vec3::ONE]);
    let most = gpu.device().limits().max_texture_dimension_2d;
    assert!(shader.picture([most + 1, 1]).is_err());
}

/// Another thread submits without pause, as a window does: a thread that waits for a picture gets it all the same, and neither has the other's
/// pixels.
fn others_submit(own: &Gpu) {
    let gpu = &Gpu::from_device(own.device().clone(), own.queue().clone());
    let is_over = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        let work = scope.spawn(|| {
            let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("it fits");
            let mut count = 0;
            while !is_over.load(std::sync::atomic::Ordering::Relaxed) {
                given(&mut shader, [64, 64], &[Vec3::X; 64 * 64]);
                count += 1;
            }
            count
        });
        let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("it fits");
        for n in 0..20 {
            let value = Vec3::splat(n as f32);
            let picture = given(&mut shader, [9, 5], &[value; 45]);
            assert_eq!(picture.radiance().expect("a GPU"), [value; 45]);
        }
        is_over.store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(work.join().expect("no panic") > 0);
    });
}
