//! Errors of callers, and very small and very large inputs.

use crate::call::trial;
use crate::parity::{View, assert_same};
use glam::Vec3;
use libtest_mimic::Trial;
use lighting::SphereLight;
use lobe_core::Sphere;
use render_gpu::{Gpu, GpuError, GpuShader, Occlusion};
use scene::{Frame, Shade, ShadingPoints};
use shading::gpu::GpuBlockers;
use visibility_mask::{LookAgain, MaskVisibility};
use visibility_spheres::SphereBlockers;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("nothing_to_shade", gpu, nothing_to_shade),
        trial("one_point", gpu, one_point),
        trial("no_spheres_at_all", gpu, no_spheres_at_all),
        trial("fifty_thousand_spheres", gpu, fifty_thousand_spheres),
        trial("sixty_four_lights", gpu, sixty_four_lights),
        trial("loops_that_are_cut_are_an_error", gpu, loops_that_are_cut_are_an_error),
        trial("points_that_are_not_finite_stay_alone", gpu, points_that_are_not_finite_stay_alone),
        trial("a_lost_device_is_an_error", gpu, a_lost_device_is_an_error),
        trial("small_limits", gpu, small_limits),
        trial("maps_larger_than_a_binding", gpu, maps_larger_than_a_binding),
        trial("kernels_are_named_with_their_time", gpu, kernels_are_named_with_their_time),
        trial("several_at_once", gpu, several_at_once),
    ]
}

fn small() -> View {
    View::new(scene::builtin(), 32, 18)
}

fn nothing_to_shade(gpu: &Gpu) {
    let view = small();
    let mut shader = GpuShader::new(gpu, Occlusion::of(&[&view.spheres])).expect("a shader");
    let none = shader.shade(&ShadingPoints::default(), &view.frame(0.003, 5), &mut []).expect("nothing is fine");
    assert_eq!(none.counts.integrals, 0);
    let dark = Frame { lights: &[], ..view.frame(0.003, 5) };
    assert!(view.gpu(&mut shader, &dark).0.iter().all(|v| *v == Vec3::ZERO), "no light, no radiance");
    let frame = Frame { materials: &[], lights: &[], ..dark };
    let mut other = GpuShader::new(gpu, Occlusion::default()).expect("a shader");
    other.shade(&ShadingPoints::default(), &frame, &mut []).expect("nothing at all is fine");
}

fn one_point(gpu: &Gpu) {
    let view = View::new(scene::builtin(), 1, 1);
    assert_eq!(view.points.receivers.len(), 1);
    view.compare_spheres(gpu, "1×1", 0.003, 5);
}

fn no_spheres_at_all(gpu: &Gpu) {
    let view = small();
    let none = SphereBlockers::new(&[], &[], &[]);
    let frame = view.frame(0.003, 5);
    let want = view.cpu(MaskVisibility::new(none.clone()).look_again(LookAgain::Never), &frame);
    let mut shader = GpuShader::new(gpu, Occlusion::of(&[&none])).expect("a shader");
    assert_same("no spheres", &want, &view.gpu(&mut shader, &frame));
    // And some points after that.
    shader.occlude(Occlusion::of(&[&view.spheres])).expect("room for them");
    let want = view.cpu(MaskVisibility::new(view.spheres.clone()).look_again(LookAgain::Never), &frame);
    assert_same("spheres again", &want, &view.gpu(&mut shader, &frame));
}

/// A cloud of motes between lights and floor: more of them meet a tile's shaft than fit a list.
fn fifty_thousand_spheres(gpu: &Gpu) {
    let mut view = small();
    let fraction = |k: u32, step: f64| (f64::from(k) * step).fract() as f32;
    let mote = |k: u32| Sphere {
        center: Vec3::new(
            8.0 * fraction(k, 0.819_172_513_4) - 5.0,
            0.8 + 3.0 * fraction(k, 0.671_043_606_7),
            6.0 * fraction(k, 0.549_700_477_9) - 3.5,
        ),
        radius: 0.002 + 0.01 * fraction(k, 0.754_877_666_2).powi(4),
    };
    let motes: Vec<Sphere> = (0..50_000).map(mote).collect();
    view.spheres = SphereBlockers::new(&motes, &vec![99; motes.len()], &[]);
    view.compare_spheres(gpu, "50 000 spheres", 0.01, 4);
}

/// Spheres that meet the light: thousands give the right picture. With more than Mesa's software driver allows rounds for a thread,
/// the call returns an error there.
fn loops_that_are_cut_are_an_error(gpu: &Gpu) {
    let mut view = View::new(scene::builtin(), 8, 4);
    let light = view.scene.lights[0].sphere().expect("a sphere");
    let mote = |k: u32| {
        let [x, y, z] =
            [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|step: f64| (f64::from(k) * step).fract() as f32 - 0.5);
        Sphere { center: light.center + 2.0 * light.radius * Vec3::new(x, y, z), radius: 0.01 * light.radius }
    };
    for count in [4000, 40_000] {
        let motes: Vec<Sphere> = (0..count).map(mote).collect();
        view.spheres = SphereBlockers::new(&motes, &vec![99; motes.len()], &[]);
        let frame = view.frame(0.003, 5);
        let mut shader = GpuShader::new(gpu, Occlusion::of(&[&view.spheres])).expect("a shader");
        let mut out = vec![Vec3::NAN; view.points.receivers.len()];
        match shader.shade(&view.points, &frame, &mut out) {
            Err(error) => {
                assert!(matches!(error, GpuError::LoopsCut { .. }) && gpu.is_software() && count > 4000, "{error:?}");
            }
            Ok(stats) => {
                let want = view.cpu(MaskVisibility::new(view.spheres.clone()).look_again(LookAgain::Never), &frame);
                assert_same(&format!("{count} motes in the light"), &want, &(out, stats.counts));
            }
        }
    }
}

fn sixty_four_lights(gpu: &Gpu) {
    let mut view = small();
    let light = |k: u32| {
        let turn = 2.4 * k as f32;
        let center = Vec3::new(5.0 * turn.cos(), 2.0 + 0.08 * k as f32, 2.0 + 4.0 * turn.sin());
        SphereLight::new(Sphere { center, radius: 0.05 + 0.01 * k as f32 }, Vec3::splat(5.0)).into()
    };
    view.scene.lights = (0..64).map(light).collect();
    view.compare_spheres(gpu, "64 lights", 0.003, 5);
}

fn points_that_are_not_finite_stay_alone(gpu: &Gpu) {
    let mut view = small();
    let frame = |view: &View| {
        let mut shader = GpuShader::new(gpu, Occlusion::of(&[&view.spheres])).expect("a shader");
        view.gpu(&mut shader, &view.frame(0.003, 5)).0
    };
    let before = frame(&view);
    let broken = [3, 100, 101, 300];
    view.points.receivers[3].position.x = f32::NAN;
    view.points.receivers[100].normal = Vec3::NAN;
    view.points.receivers[101].position = Vec3::INFINITY;
    view.points.receivers[300].view = Vec3::splat(f32::NEG_INFINITY);
    let after = frame(&view);
    for (i, (before, after)) in before.iter().zip(&after).enumerate() {
        if !broken.contains(&i) {
            // The bounds of a tile change the list, not the visible fraction.
            assert!(
                (*before - *after).abs().max_element() <= 1e-5 * before.max_element(),
                "point {i}: {before} {after}"
            );
        }
    }
}

fn a_lost_device_is_an_error(_: &Gpu) {
    let gpu = Gpu::blocking(&render_gpu::GpuOptions::default()).expect("another device");
    let view = small();
    let frame = view.frame(0.003, 5);
    let mut shader = GpuShader::new(&gpu, Occlusion::of(&[&view.spheres])).expect("a shader");
    let mut out = vec![Vec3::ZERO; view.points.receivers.len()];
    shader.shade(&view.points, &frame, &mut out).expect("still there");
    gpu.device().destroy();
    for _ in 0..2 {
        let error = shader.shade(&view.points, &frame, &mut out).expect_err("the device is gone");
        assert!(matches!(error, GpuError::Lost { .. }), "{error:?}");
    }
    let error =
        GpuShader::new(&gpu, Occlusion::of(&[&view.spheres])).map(|_| ()).expect_err("nor is there a new shader");
    assert!(matches!(error, GpuError::Lost { .. }), "{error:?}");
}

/// A device with limits as small as these, as a caller may have: it gives smaller slices, or a clear message.
fn device(limits: wgpu::Limits) -> Gpu {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default());
    let adapter = pollster::block_on(adapter).expect("an adapter");
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
    Gpu::from_device(device, queue)
}

/// The maps of several lights, larger than a binding: in as many bindings as they need, with the same bits.
fn maps_larger_than_a_binding(gpu: &Gpu) {
    let view = small();
    let (maps, frame) = (view.maps(), view.frame(0.003, 5));
    let bytes = size_of_val(maps.pack().words()) as u64;
    let picture = |gpu: &Gpu| {
        let occlusion = Occlusion { blockers: &[&maps.pack()], any_hit: None };
        view.gpu(&mut GpuShader::new(gpu, occlusion).expect("a shader"), &frame)
    };
    // Two or three pages: the most that leave a kernel the storage buffers of every device.
    let most = bytes / 4 * 3;
    let small = device(wgpu::Limits { max_storage_buffer_binding_size: most, ..wgpu::Limits::default() });
    assert_eq!(small.room_for_pages(), most);
    assert_eq!(picture(&small), picture(gpu));
    // Too many pages for a kernel, and more bytes than a buffer may have.
    let tiny = device(wgpu::Limits { max_storage_buffer_binding_size: bytes / 20, ..wgpu::Limits::default() });
    let narrow = device(wgpu::Limits { max_buffer_size: bytes / 2, ..wgpu::Limits::default() });
    for gpu in [tiny, narrow] {
        assert!(gpu.room_for_pages() < bytes);
        let occlusion = Occlusion { blockers: &[&maps.pack()], any_hit: None };
        let shaded = GpuShader::new(&gpu, occlusion)
            .and_then(|mut shader| shader.shade(&ShadingPoints::default(), &frame, &mut []).map(|_| ()));
        let error = shaded.expect_err("no room");
        assert!(matches!(error, GpuError::Limits { needed, allowed, .. } if needed > allowed), "{error:?}");
    }
}

/// A device of its own: other tests compile at the same time.
fn kernels_are_named_with_their_time(_: &Gpu) {
    let gpu = Gpu::blocking(&render_gpu::GpuOptions::default()).expect("another device");
    let (view, log) = (small(), gpu.kernels().clone());
    let mut shader = GpuShader::new(&gpu, Occlusion::of(&[&view.spheres])).expect("a shader");
    assert_eq!(log.compiled().len(), 1, "the bounds of blocks");
    shader.shade(&ShadingPoints::default(), &view.frame(0.02, 2), &mut []).expect("no points");
    let done = log.compiled();
    for name in ["bounds", "cull", "classify (spheres, ", "penumbra (spheres, ", "args_of_queue"] {
        assert!(done.iter().any(|kernel| kernel.name.starts_with(name)), "{name}: {done:?}");
    }
    assert!(done.is_sorted_by(|a, b| a.time >= b.time) && log.compiling().is_empty(), "{done:?}");
    // No kernel is left to compile for the first points.
    view.gpu(&mut shader, &view.frame(0.02, 2));
    assert_eq!(log.compiled(), done);
}

fn small_limits(_: &Gpu) {
    let view = small();
    let frame = view.frame(0.003, 5);
    let want = view.cpu(MaskVisibility::new(view.spheres.clone()).look_again(LookAgain::Never), &frame);

    // Room for three tiles' points.
    let gpu = device(wgpu::Limits { max_storage_buffer_binding_size: 3 * 64 * 64, ..wgpu::Limits::default() });
    let mut shader = GpuShader::new(&gpu, Occlusion::of(&[&view.spheres])).expect("a shader");
    assert_same("bindings of 12 kB", &want, &view.gpu(&mut shader, &frame));

    let gpu = device(wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..wgpu::Limits::default() });
    let error = GpuShader::new(&gpu, Occlusion::of(&[&view.spheres])).map(|_| ()).expect_err("too few buffers");
    assert!(matches!(error, GpuError::Limits { needed: 8, allowed: 4, .. }), "{error:?}");
    assert!(error.to_string().contains("use the CPU"));

    let gpu = device(wgpu::Limits { max_storage_buffer_binding_size: 3 * 64 * 64, ..wgpu::Limits::default() });
    let many = SphereBlockers::new(&vec![Sphere { center: Vec3::ZERO, radius: 1.0 }; 1000], &vec![0; 1000], &[]);
    let error = GpuShader::new(&gpu, Occlusion::of(&[&many])).map(|_| ());
    assert!(matches!(error, Err(GpuError::Limits { needed: 48_000, .. })), "{error:?}");
    // Blockers that do not fit leave no blockers; the earlier ones fit again.
    let few = SphereBlockers::new(&[Sphere { center: Vec3::Y, radius: 0.5 }], &[99], &[]);
    let few: [&dyn GpuBlockers; 1] = [&few];
    let few = Occlusion::of(&few);
    let mut shader = GpuShader::new(&gpu, few).expect("a shader");
    let counts = |shader: &mut GpuShader| view.gpu(shader, &frame).1;
    let before = counts(&mut shader);
    assert!(shader.occlude(Occlusion::of(&[&many])).is_err() && before.penumbra_points > 0);
    let unshadowed = counts(&mut shader);
    assert_eq!((unshadowed.penumbra_points, unshadowed.dark_points), (0, 0));
    shader.occlude(few).expect("room for it");
    assert_eq!(counts(&mut shader), before);
}

fn several_at_once(gpu: &Gpu) {
    let view = small();
    let frame = view.frame(0.003, 5);
    let alone = view.gpu(&mut GpuShader::new(gpu, Occlusion::of(&[&view.spheres])).expect("a shader"), &frame);
    let all: Vec<_> = std::thread::scope(|scope| {
        let run = || view.gpu(&mut GpuShader::new(gpu, Occlusion::of(&[&view.spheres])).expect("a shader"), &frame);
        let threads: Vec<_> = (0..3).map(|_| scope.spawn(run)).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    assert!(all.iter().all(|picture| *picture == alone));
}
