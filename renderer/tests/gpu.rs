//! A renderer on a GPU: the data that it keeps there, and the calls of an interactive program. Ignored without an adapter.

use brdf::Material;
use core::ops::ControlFlow;
use glam::{Mat4, UVec2, Vec3};
use libtest_mimic::{Arguments, Trial};
use lighting::{Environment, EnvironmentMap, FlatLight, Light, SphereLight, TubeLight};
use lobe_core::Sphere;
use ray_tracing::PixelSamples;
use renderer::{Cancel, Device, LayerSet, RenderError, Renderer, Settings, Window};
use scene::{Animation, Instances, Mesh, Object, Proxy, Scene, Shape, Strategy};
use std::sync::Arc;
use test_scenes::{floor_and_sphere, globe};

fn main() {
    let is_there = renderer::Backend::open(Device::Gpu).is_ok();
    let trial = |name: &str, test: fn()| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
        .with_ignored_flag(!is_there)
    };
    let trials = vec![
        trial("rays_follow_only_what_moves", rays_follow_only_what_moves),
        trial("the_first_picture_compiles_nothing", the_first_picture_compiles_nothing),
        trial("parts_make_the_picture", parts_make_the_picture),
        trial("skies_are_summed_at_once", skies_are_summed_at_once),
        trial("glossy_floors_mirror_windows", glossy_floors_mirror_windows),
        trial("instances_block_as_copies", instances_block_as_copies),
        trial("dense_meshes_below_tubes", dense_meshes_below_tubes),
        trial("parts_of_lights_are_the_picture", parts_of_lights_are_the_picture),
        trial("bulbs_hide_other_lights", bulbs_hide_other_lights),
        trial("layers_of_points", layers_of_points),
        trial("requests_to_stop", requests_to_stop),
        trial("nothing_to_see", nothing_to_see),
        trial("pictures_stay_on_the_gpu", pictures_stay_on_the_gpu),
        trial("a_window_lends_its_gpu", a_window_lends_its_gpu),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}

fn stage() -> Scene {
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (48, 27);
    let center = Vec3::new(-0.9, 0.8, 0.5);
    scene.objects.push(Object::mesh("globe", globe(6, center, 0.5, true), 0, Proxy::Count(8)));
    scene
}

fn renderer(settings: Settings) -> Renderer {
    Renderer::new(stage(), Animation::default(), Settings { device: Device::Gpu, ..settings }).expect("a GPU")
}

fn lamp(x: f32) -> Light {
    SphereLight::new(Sphere { center: Vec3::new(x, 4.0, 1.0), radius: 0.5 }, Vec3::splat(4.0)).into()
}

/// By masks of spheres and by rays, as the CPU's pictures.
fn bulbs_hide_other_lights() {
    let bulb = Sphere { center: Vec3::new(-0.3, 1.6, 1.2), radius: 0.3 };
    let mut scene = stage();
    scene.objects.push(Object::spheres("bulb", vec![bulb], 0));
    scene.lights = vec![lamp(0.0), SphereLight::new(bulb, Vec3::splat(0.5)).into()];
    for strategy in [Strategy::Spheres, Strategy::Rays] {
        let [cpu, gpu] = [Device::Cpu, Device::Gpu].map(|device| {
            let settings = Settings { device, strategy: Some(strategy), ..Settings::default() };
            let mut renderer = Renderer::new(scene.clone(), Animation::default(), settings).expect("a scene");
            renderer.render().expect("a picture").radiance
        });
        let white = cpu.iter().map(|c| c.max_element()).fold(0.0, f32::max);
        let off = cpu.iter().zip(&gpu).map(|(a, b)| (*a - *b).abs().max_element());
        let mean = off.sum::<f32>() / cpu.len() as f32;
        assert!(mean < 2e-3 * white, "{strategy:?}: {mean} of {white}");
    }
}

fn rays_follow_only_what_moves() {
    let mut edited = renderer(Settings { strategy: Some(Strategy::Rays), ..Settings::default() });
    let worlds = |edited: &mut Renderer| {
        edited.render().expect("a picture");
        edited.upkeep().ray_worlds
    };
    assert_eq!(worlds(&mut edited), 1);
    assert_eq!(worlds(&mut edited), 1);
    let light = edited.lights().next().expect("a light").0;
    edited.set_light(light, lamp(0.4)).expect("a light");
    assert_eq!(worlds(&mut edited), 1);
    let camera = scene::Camera { eye: Vec3::new(0.5, 3.0, 8.0), ..edited.scene().camera };
    edited.set_camera(camera).expect("a camera");
    assert_eq!(worlds(&mut edited), 1);
    let object = edited.objects().nth(2).expect("the globe").0;
    edited.set_transform(object, Mat4::from_translation(Vec3::X * 0.4)).expect("a shift");
    assert_eq!(worlds(&mut edited), 2);
    // A lamp that shows the light does not hide it: the scene that rays meet has changed.
    let shown = edited.scene().objects[1].clone();
    let scene::Shape::Spheres(spheres) = &shown.shape else { panic!("a sphere") };
    edited.set_light(light, SphereLight::new(spheres[0], Vec3::ONE).into()).expect("a light");
    assert_eq!(worlds(&mut edited), 3);
    edited.set_object_strategy(object, Some(Strategy::None)).expect("a strategy");
    let image = edited.render().expect("a picture").radiance;
    let fresh = Renderer::new(edited.scene().clone(), Animation::default(), edited.settings().clone());
    assert!(image == fresh.expect("a GPU").render().expect("a picture").radiance);
}

fn the_first_picture_compiles_nothing() {
    for strategy in [None, Some(Strategy::Rays)] {
        let mut warm = renderer(Settings { strategy, ..Settings::default() });
        let count = |warm: &Renderer| warm.backend().gpu().expect("a GPU").kernels().compiled().len();
        warm.warm_up(&mut |_| ControlFlow::Continue(())).expect("kernels");
        let before = (count(&warm), warm.upkeep());
        assert!(before.0 > 2);
        let image = warm.render().expect("a picture");
        let after = (count(&warm), renderer::Upkeep { point_bands: 0, ..warm.upkeep() });
        assert_eq!(after, before, "{strategy:?}");
        assert!(image.radiance.iter().any(|pixel| *pixel != Vec3::ZERO));
    }
}

fn parts_make_the_picture() {
    let mut parted = renderer(Settings { strategy: Some(Strategy::Silhouettes), ..Settings::default() });
    let want = parted.render().expect("a picture").radiance;
    let whole = Window::whole(48, 27);
    let (mut picture, mut parts) = (vec![Vec3::NAN; whole.pixels()], whole.parts([16, 8]).collect::<Vec<_>>());
    parts.reverse();
    parted
        .render_parts(&parts, &mut |_| ControlFlow::Continue(()), &mut |band| {
            band.copy_to(&whole, &mut picture);
            ControlFlow::Continue(())
        })
        .expect("a picture");
    assert!(picture == want);
}

/// Ambient light that objects hide, alone and beside an environment: the CPU's picture. Before rays patches are lights.
fn skies_are_summed_at_once() {
    let mut scene = stage();
    scene.materials.fill(Material::lambert(Vec3::splat(0.6)));
    // One radiance everywhere, with a dark side.
    let half = (0..128).map(|texel| Vec3::splat(if texel % 16 < 5 { 0.2 } else { 1.0 })).collect();
    let pictures = [None, Some(EnvironmentMap::new(UVec2::new(16, 8), half).expect("a picture"))];
    let world = Sphere { center: Vec3::ZERO, radius: 12.0 };
    let mut before: Vec<Light> = scene.lights.clone();
    before.truncate(1);
    let mut gpu = None;
    for picture in pictures {
        let environment = Environment::with_ambient(picture, Vec3::new(0.3, 0.4, 0.5), 1, world);
        scene.lights = before.iter().chain(environment.lights()).cloned().collect();
        scene.environment = Some(environment.into());
        let picture = |device: Device| {
            let settings = Settings { device, ..Settings::default() };
            Renderer::new(scene.clone(), Animation::default(), settings).expect("a renderer")
        };
        let want = picture(Device::Cpu).render().expect("a picture").radiance;
        let mut ours = picture(Device::Gpu);
        let got = ours.render().expect("a picture").radiance;
        assert_eq!(ours.upkeep().sky_tables, 1);
        let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
        let all = want.iter().zip(&got).map(|(a, b)| (*a - *b).abs().max_element() / peak);
        let (sum, most) = all.fold((0.0, 0.0_f32), |(sum, most), d| (sum + d, most.max(d)));
        // Points that see little of the sky see patches, whose cut ones a CPU draws in finer masks.
        assert!(sum < 1e-5 * want.len() as f32 && most < 5e-3, "{sum:e} {most:e}");
        gpu = Some(ours);
    }
    let mut ours = gpu.expect("a renderer");
    let skies = |ours: &Renderer| {
        let compiled = ours.backend().gpu().expect("a GPU").kernels().compiled();
        compiled.iter().filter(|kernel| kernel.name.starts_with("sky (")).count()
    };
    assert_eq!(skies(&ours), 1);
    let mut by_rays = Renderer::new(
        ours.scene().clone(),
        Animation::default(),
        Settings { device: Device::Gpu, strategy: Some(Strategy::Rays), ..Settings::default() },
    )
    .expect("a renderer");
    by_rays.render().expect("a picture");
    assert_eq!((skies(&by_rays), by_rays.upkeep().sky_tables), (0, 0));
    // Another picture needs nothing new.
    ours.render().expect("a picture");
    assert_eq!((skies(&ours), ours.upkeep().sky_tables), (1, 1));
}

/// Where a glossy floor reflects little but the window, all of its lobe is seen, but little of the sky: as on a CPU, to 0.3 % in the mean (5 % by the sum over
/// the sky's samples).
fn glossy_floors_mirror_windows() {
    let world = Sphere { center: Vec3::ZERO, radius: 9.0 };
    let sky = Environment::new(EnvironmentMap::uniform(Vec3::ONE), 2, world);
    let mut scene = test_scenes::room([-0.6, 0.6, -0.3, 0.7], lamp(0.0));
    scene.lights = sky.lights().to_vec();
    scene.environment = Some(sky.into());
    scene.materials = vec![brdf::ModifiedPhong { kd: Vec3::ZERO, ks: Vec3::ONE, exponent: 40.0 }.into()];
    (scene.camera.eye, scene.camera.target) = (Vec3::new(0.3, 0.5, 2.2), Vec3::new(0.0, -1.3, 0.0));
    let [want, got] = [Device::Cpu, Device::Gpu].map(|device| {
        let settings = Settings { device, samples: PixelSamples::Uniform(1), ..Settings::default() };
        let renderer = Renderer::new(scene.clone(), Animation::default(), settings);
        renderer.and_then(|mut renderer| renderer.render()).expect("a picture").radiance
    });
    // The window itself is white.
    let floor = || want.iter().zip(&got).filter(|(want, _)| want.x < 1.0);
    let most = floor().map(|(want, _)| want.x).fold(0.0, f32::max);
    let bright = floor().filter(|(want, _)| want.x > 0.2 * most);
    let errors: Vec<f32> = bright.map(|(want, got)| (got.x / want.x - 1.0).abs()).collect();
    let mean = errors.iter().sum::<f32>() / errors.len() as f32;
    assert!(errors.len() > 50 && mean < 0.003, "{mean} of {} pixels", errors.len());
}

fn instances_block_as_copies() {
    let mut scene = stage();
    let Some(Shape::Mesh(mesh)) = scene.objects.last().map(|object| object.shape.clone()) else { panic!() };
    let turned = Mat4::from_translation(Vec3::new(0.4, 0.3, -0.2)) * Mat4::from_rotation_y(0.4);
    let instances = Instances::new(Arc::new(mesh), vec![Mat4::IDENTITY, turned]).expect("instances");
    let picture = |scene: &Scene| {
        let settings = Settings { device: Device::Gpu, ..Settings::default() };
        let mut renderer = Renderer::new(scene.clone(), Animation::default(), settings).expect("a GPU");
        let first = renderer.render().expect("a picture").radiance;
        let builds = renderer.upkeep().silhouette_builds;
        let last = renderer.objects().last().expect("objects").0;
        renderer.set_transform(last, Mat4::from_translation(Vec3::X * 0.2)).expect("moved");
        let second = renderer.render().expect("a picture").radiance;
        assert_eq!((builds, renderer.upkeep().silhouette_builds), (1, 1));
        let compiled = renderer.backend().gpu().expect("a GPU").kernels().compiled();
        assert!(compiled.iter().any(|kernel| kernel.name.contains("silhouettes")));
        [first, second]
    };
    let last = scene.objects.len() - 1;
    scene.objects[last].shape = Shape::Mesh(instances.expanded());
    let want = picture(&scene);
    scene.objects[last].shape = Shape::Instances(instances);
    let have = picture(&scene);
    assert!(have[0] == want[0] && want[0] != want[1]);
    // Corners that are moved twice are rounded twice.
    assert!(have[1].iter().zip(&want[1]).all(|(a, b)| a.abs_diff_eq(*b, 1e-6)));
}

/// A board of many triangles below a long tube, whose plane cuts none of them: a software driver ends loops after 65 535 rounds.
fn dense_meshes_below_tubes() {
    let mut scene = stage();
    (scene.width, scene.height) = (16, 9);
    scene.objects.truncate(1);
    let side = 185;
    let at = |k: u32| Vec3::new((k % side) as f32 / side as f32 - 0.5, 1.0, (k / side) as f32 / side as f32 - 0.5);
    let corners = (0..side - 1).flat_map(|row| (0..side - 1).map(move |column| row * side + column));
    let triangles = corners.flat_map(|k| [[k, k + side, k + 1], [k + 1, k + side, k + side + 1]]).collect();
    let board = Mesh { positions: (0..side * side).map(at).collect(), triangles, ..Mesh::default() };
    scene.objects.push(Object { visible: false, ..Object::mesh("board", board, 0, Proxy::None) });
    scene.materials.fill(Material::lambert(Vec3::splat(0.6)));
    let ends = [-2.0, 2.0].map(|x| Vec3::new(x, 2.2, 0.0));
    scene.lights = vec![TubeLight { ends, radius: 0.02, radiance: Vec3::splat(40.0) }.into()];
    let picture = |device: Device| {
        let settings = Settings { device, ..Settings::default() };
        let mut renderer = Renderer::new(scene.clone(), Animation::default(), settings).expect("a renderer");
        renderer.render().expect("a picture").radiance
    };
    let [want, got] = [Device::Cpu, Device::Gpu].map(picture);
    let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let sum: f32 = want.iter().zip(&got).map(|(a, b)| (*a - *b).abs().max_element()).sum();
    assert!(peak > 0.1 && sum < 1e-3 * peak * want.len() as f32, "{sum} of {peak}");
}

/// A post goes through a panel, which is not the first light.
fn parts_of_lights_are_the_picture() {
    let mut scene = stage();
    let post = Mesh::cuboid(Vec3::new(0.3, 1.6, 0.1), Vec3::new(0.25, 3.0, 0.25));
    scene.objects.push(Object::mesh("post", post, 0, Proxy::None));
    let panel = FlatLight::rectangle(Vec3::Y * 2.5, Vec3::X, Vec3::Z, Vec3::splat(3.0)).expect("a panel");
    scene.lights = vec![lamp(3.0), panel.into()];
    let settings = Settings { device: Device::Gpu, ..Settings::default() };
    let mut renderer = Renderer::new(scene, Animation::default(), settings).expect("a GPU");
    let whole = renderer.render().expect("a picture").radiance;
    let lights: Vec<_> = renderer.lights().map(|(light, _)| light).collect();
    let mut go_on = |_: renderer::Event<'_>| ControlFlow::Continue(());
    let parts = lights.into_iter().map(|light| renderer.render_light(1, light, &mut go_on).expect("a part").radiance);
    let sum = parts.reduce(|a, b| a.into_iter().zip(b).map(|(a, b)| a + b).collect()).expect("lights");
    let white = whole.iter().map(|c| c.max_element()).fold(0.0, f32::max);
    let off = whole.iter().zip(&sum).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(off < 1e-5 * white, "{off} of {white}");
}

fn layers_of_points() {
    let layers = LayerSet { depths: true, normals: true, objects: true, ..LayerSet::NONE };
    let ours = renderer(Settings { layers, ..Settings::default() }).render().expect("a picture").layers;
    let theirs = Settings { layers, ..Settings::default() };
    let theirs = Renderer::new(stage(), Animation::default(), theirs).expect("a scene").render().expect("a picture");
    assert!(ours == theirs.layers && ours.unshadowed.is_empty());
    let all = Settings { layers: LayerSet::ALL, device: Device::Gpu, ..Settings::default() };
    let refused = Renderer::new(stage(), Animation::default(), all);
    assert!(matches!(refused, Err(RenderError::NotOnGpu(_))));
}

fn requests_to_stop() {
    let mut edited = renderer(Settings::default());
    let want = edited.render().expect("a picture").radiance;
    let cancel = Cancel::new();
    edited.set_cancel(cancel.clone());
    let whole = Window::whole(48, 27);
    let parts: Vec<Window> = whole.parts([48, 8]).collect();
    let mut count = 0;
    let stopped = edited.render_parts(&parts, &mut |_| ControlFlow::Continue(()), &mut |_| {
        count += 1;
        cancel.cancel();
        ControlFlow::Continue(())
    });
    assert!(matches!(stopped, Err(RenderError::Cancelled)) && count == 1);
    edited.set_cancel(Cancel::new());
    assert!(edited.render().expect("a picture").radiance == want);
}

fn nothing_to_see() {
    let mut edited = renderer(Settings { strategy: Some(Strategy::Rays), ..Settings::default() });
    edited.render().expect("a picture");
    edited.set_background(Vec3::X).expect("a color");
    for object in edited.objects().map(|(handle, _)| handle).collect::<Vec<_>>() {
        edited.remove_object(object).expect("is there");
    }
    assert!(edited.render().expect("a picture").radiance.iter().all(|pixel| *pixel == Vec3::X));
}

/// As pictures that come to the CPU, to rounding: whole and coarse, at edges, with a background and surfaces that emit; after edits that
/// leave the visible points and edits that move them.
fn pictures_stay_on_the_gpu() {
    let mut scene = stage();
    scene.background = Vec3::new(0.2, 0.3, 0.4);
    scene.surfaces.resize(scene.materials.len(), scene::Surface::default());
    scene.surfaces[0].emission = Vec3::new(0.01, 0.02, 0.0);
    let settings = Settings { device: Device::Gpu, samples: renderer::PixelSamples::Edges(8), ..Settings::default() };
    let mut edited = Renderer::new(scene, Animation::default(), settings).expect("a GPU");
    let go_on = |_: renderer::Event| ControlFlow::Continue(());
    let compare = |edited: &mut Renderer| {
        for divisor in [1, 3, 1] {
            let want = edited.render_reduced(divisor, &mut { go_on }).expect("a picture");
            let got = edited.render_on_gpu(divisor, &mut { go_on }).expect("a picture");
            assert_eq!(got.picture.size().map(|side| side as usize), want.size);
            assert!(!got.picture.is_read());
            let pixels = got.picture.radiance().expect("a GPU");
            let peak = want.radiance.iter().map(|p| p.max_element()).fold(0.0, f32::max);
            let difference = pixels.iter().zip(&want.radiance).map(|(a, b)| (*a - *b).abs().max_element());
            let largest = difference.fold(0.0, f32::max);
            assert!(peak > 0.3 && largest <= 2e-6 * peak, "{largest:e} of {peak}");
            assert_eq!(got.stats.points, want.stats.points);
        }
    };
    compare(&mut edited);
    let light = edited.lights().next().expect("a light").0;
    edited.set_light(light, lamp(0.4)).expect("a light");
    compare(&mut edited);
    let camera = scene::Camera { eye: Vec3::new(0.5, 3.0, 8.0), ..edited.scene().camera };
    edited.set_camera(camera).expect("a camera");
    compare(&mut edited);
    edited.set_layers(LayerSet { depths: true, ..LayerSet::NONE }).expect("layers of points");
    let [on_cpu, on_gpu] = [
        edited.render().expect("a picture").layers,
        edited.render_on_gpu(1, &mut { go_on }).expect("a picture").layers,
    ];
    assert!(on_cpu == on_gpu && on_gpu.depths.len() == 48 * 27);
    // A stop leaves the renderer as it was.
    let cancel = Cancel::new();
    cancel.cancel();
    edited.set_cancel(cancel);
    assert!(matches!(edited.render_on_gpu(1, &mut { go_on }), Err(RenderError::Cancelled)));
    edited.set_cancel(Cancel::new());
    assert_eq!(edited.render().expect("a picture").radiance.len(), 48 * 27);
    compare(&mut edited);
    edited.set_settings(Settings { device: Device::Cpu, ..edited.settings().clone() }).expect("the CPU");
    assert!(matches!(edited.render_on_gpu(1, &mut { go_on }), Err(RenderError::NotOnGpu(_))));
}

/// A renderer takes the GPU that it is given, with its compiled kernels, each time that settings request one.
fn a_window_lends_its_gpu() {
    let own = renderer::Gpu::blocking(&render_gpu::GpuOptions::default()).expect("a GPU");
    let gpu = renderer::Gpu::from_device(own.device().clone(), own.queue().clone());
    let mut edited = Renderer::new(stage(), Animation::default(), Settings::default()).expect("a scene");
    edited.use_gpu(Some(gpu.clone()));
    let mut seen = Vec::new();
    for device in [Device::Gpu, Device::Cpu, Device::Gpu] {
        edited.set_settings(Settings { device, ..edited.settings().clone() }).expect("a device");
        assert_eq!(
            edited.backend().gpu().map(|gpu| gpu.device().clone()),
            (device == Device::Gpu).then(|| gpu.device().clone())
        );
        if device == Device::Gpu {
            let made = edited.render_on_gpu(1, &mut |_| ControlFlow::Continue(())).expect("a picture");
            seen.push((made.picture.radiance().expect("a GPU").to_vec(), gpu.kernels().compiled().len()));
        }
    }
    assert!(seen[0] == seen[1] && seen[0].1 > 0);
}
