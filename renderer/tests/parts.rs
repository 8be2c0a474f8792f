//! Parts of pictures in any order, pictures in the caller's memory, layers by choice.

use core::ops::ControlFlow;
use glam::Vec3;
use lighting::SphereLight;
use lobe_core::{Random, Sphere};
use renderer::{Band, Event, LayerSet, Layers, PixelSamples, RenderError, Renderer, Settings, Window};
use scene::{Animation, Object, Proxy, Scene, Strategy};
use test_scenes::{floor_and_sphere, globe};

const SIZE: [usize; 2] = [75, 46];

fn stage() -> Scene {
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (SIZE[0] as u32, SIZE[1] as u32);
    let center = Vec3::new(-0.9, 0.8, 0.5);
    scene.objects.push(Object::mesh("globe", globe(6, center, 0.5, true), 0, Proxy::Count(8)));
    let light = Sphere { center: Vec3::new(-2.0, 4.0, 1.5), radius: 0.4 };
    scene.lights.push(SphereLight::new(light, Vec3::splat(5.0)).into());
    scene
}

fn renderer(settings: Settings) -> Renderer {
    Renderer::new(stage(), Animation::default(), settings).expect("a scene")
}

fn whole() -> Window {
    Window::whole(SIZE[0], SIZE[1])
}

fn go_on(_: Event<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn forget(_: &Band) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn shuffled(mut parts: Vec<Window>, random: &mut Random) -> Vec<Window> {
    for i in (1..parts.len()).rev() {
        parts.swap(i, (random.uniform() * (i + 1) as f64) as usize);
    }
    parts
}

#[test]
fn parts_in_any_order_make_the_picture() {
    let mut random = Random::new(7);
    let sizes = [[8, 8], [75, 8], [16, 46], [13, 5], [1, 46], [100, 100]];
    for strategy in [None, Some(Strategy::Spheres), Some(Strategy::ShadowMap), Some(Strategy::Rays)] {
        for samples in [PixelSamples::Uniform(1), PixelSamples::Uniform(3), PixelSamples::Edges(5)] {
            let settings = Settings { strategy, samples, ..Settings::default() };
            let want = renderer(settings.clone()).render().expect("a picture").radiance;
            let mut parted = renderer(settings);
            for size in sizes {
                let parts = shuffled(whole().parts(size).collect(), &mut random);
                let (mut picture, mut seen) = (vec![Vec3::NAN; whole().pixels()], Vec::new());
                let stats = parted.render_parts(&parts, &mut go_on, &mut |band| {
                    band.copy_to(&whole(), &mut picture);
                    seen.push(band.window.clone());
                    ControlFlow::Continue(())
                });
                assert!(stats.expect("a picture").points > 0);
                assert_eq!(seen, parts);
                assert!(picture == want, "{strategy:?}, {samples:?}, {size:?}");
            }
        }
    }
}

/// Interpolated pictures differ from others by less than the tolerance; parts of whole tiles have their bits. A GPU refuses.
#[test]
fn tiles_of_interpolated_pictures() {
    let mut scene = stage();
    // Meshes alone, by silhouettes.
    scene.objects.truncate(1);
    let center = Vec3::new(-0.4, 1.6, 0.2);
    scene.objects.push(Object::mesh("globe", globe(6, center, 0.5, true), 0, Proxy::None));
    scene.camera.eye = Vec3::new(0.0, 6.0, 2.0);
    scene.camera.target = Vec3::ZERO;
    for k in 0..11 {
        let center = Vec3::new((k % 4) as f32 - 1.5, 4.0, (k / 4) as f32 - 1.0);
        scene.lights.push(SphereLight::new(Sphere { center, radius: 0.9 }, Vec3::splat(2.0)).into());
    }
    for samples in [PixelSamples::Uniform(1), PixelSamples::Edges(5)] {
        let strategy = Some(Strategy::Silhouettes);
        let settings = Settings { strategy, samples, interpolate: true, ..Settings::default() };
        let renderer = |settings| Renderer::new(scene.clone(), Animation::default(), settings).expect("a scene");
        let want = renderer(settings.clone()).render().expect("a picture").radiance;
        let exact = renderer(Settings { interpolate: false, ..settings.clone() }).render().expect("a picture").radiance;
        let error = want.iter().zip(&exact).map(|(a, b)| (*a - *b).abs().max_element() / b.max_element().max(0.05));
        let largest = error.fold(0.0, f32::max);
        assert!(largest > 0.0 && largest < 5.0 * 0.005, "{largest}");
        let mut parted = renderer(settings);
        for size in [[8, 8], [75, 8], [16, 46]] {
            let parts: Vec<Window> = whole().parts(size).collect();
            let mut picture = vec![Vec3::NAN; whole().pixels()];
            let stats = parted.render_parts(&parts, &mut go_on, &mut |band| {
                band.copy_to(&whole(), &mut picture);
                ControlFlow::Continue(())
            });
            assert!(stats.is_ok() && picture == want, "{samples:?}, {size:?}");
        }
    }
    let settings = Settings { interpolate: true, ..Settings::default() };
    assert!(matches!(settings.check_device(renderer::Device::Gpu), Err(RenderError::NotOnGpu(_))));
}

/// The visible points of parts are kept like those of a whole picture, and the box around all of them is found once.
#[test]
fn parts_are_found_once() {
    let mut parted = renderer(Settings { strategy: Some(Strategy::ShadowMap), ..Settings::default() });
    let parts: Vec<Window> = whole().parts([16, 16]).collect();
    let find = |parted: &mut Renderer| {
        let before = parted.upkeep().point_bands;
        parted.render_parts(&parts, &mut go_on, &mut forget).expect("a picture");
        parted.upkeep().point_bands - before
    };
    assert_eq!(find(&mut parted), 1 + parts.len() as u64);
    assert_eq!(find(&mut parted), 0);
    let camera = parted.scene().camera;
    parted.set_camera(camera).expect("a camera");
    assert_eq!(find(&mut parted), 1 + parts.len() as u64);
}

#[test]
fn nothing_is_kept_for_one_picture() {
    for (keep_points, found) in [(true, 0), (false, 1)] {
        let mut once = renderer(Settings { keep_points, ..Settings::default() });
        let first = once.render().expect("a picture").radiance;
        let before = once.upkeep().point_bands;
        assert!(once.render().expect("a picture").radiance == first);
        assert_eq!(once.upkeep().point_bands - before, found, "{keep_points}");
    }
}

#[test]
fn pictures_go_into_memory_of_the_caller() {
    let mut edited = renderer(Settings::default());
    let want = edited.render().expect("a picture").radiance;
    let mut pixels = vec![Vec3::NAN; whole().pixels()];
    edited.render_into(&whole(), &mut go_on, &mut pixels).expect("a picture");
    assert!(pixels == want);
    let part = Window { columns: 11..40, rows: 8..30, ..whole() };
    let mut pixels = vec![Vec3::NAN; part.pixels()];
    edited.render_into(&part, &mut go_on, &mut pixels).expect("a part");
    for (row, line) in part.rows.clone().zip(pixels.chunks_exact(part.columns.len())) {
        assert!(line == &want[row * SIZE[0]..][part.columns.clone()]);
    }
    let refused = |result: Result<_, RenderError>| matches!(result, Err(RenderError::Setting { .. }));
    assert!(refused(edited.render_into(&whole(), &mut go_on, &mut pixels)));
    let outside = Window { columns: 70..80, ..whole() };
    assert!(refused(edited.render_window(&outside, &mut go_on).map(|image| image.stats)));
    assert!(refused(edited.render_into(&Window::whole(8, 8), &mut go_on, &mut [Vec3::ZERO; 64])));
}

fn empty(layers: &Layers) -> [bool; 6] {
    [
        layers.unshadowed.is_empty(),
        layers.lights.is_empty(),
        layers.normals.is_empty(),
        layers.depths.is_empty(),
        layers.objects.is_empty(),
        layers.lobes.is_empty() && layers.products.is_empty(),
    ]
}

#[test]
fn layers_come_one_by_one() {
    let settings = |layers| Settings { layers, samples: 2.into(), ..Settings::default() };
    let want = renderer(settings(LayerSet::ALL)).render().expect("a picture");
    assert_eq!(empty(&want.layers), [false; 6]);
    let none = renderer(settings(LayerSet::NONE)).render().expect("a picture");
    assert_eq!((empty(&none.layers), none.radiance == want.radiance), ([true; 6], true));
    for k in 0..6 {
        let on = |i: usize| i == k;
        let layers =
            LayerSet { unshadowed: on(0), lights: on(1), normals: on(2), depths: on(3), objects: on(4), counts: on(5) };
        let image = renderer(settings(layers)).render().expect("a picture");
        let (one, all) = (&image.layers, &want.layers);
        assert_eq!(empty(one), core::array::from_fn(|i| i != k));
        let same = [
            one.unshadowed == all.unshadowed,
            one.lights == all.lights,
            one.normals == all.normals,
            one.depths == all.depths,
            one.objects == all.objects,
            (&one.lobes, &one.products) == (&all.lobes, &all.products),
        ];
        assert!(same[k] && image.radiance == want.radiance, "{k}");
    }
    let seen: Vec<bool> = want.layers.objects.iter().map(|object| *object != Layers::NO_OBJECT).collect();
    assert!(seen.contains(&true) && seen.contains(&false) && want.layers.objects.contains(&2));
    // The sum of the lights is the picture: nothing emits, and the background is black.
    for (i, radiance) in want.radiance.iter().enumerate() {
        let sum: Vec3 = want.layers.lights.iter().map(|light| light[i]).sum();
        assert!((sum - *radiance).abs().max_element() <= 1e-5 && (seen[i] || sum == Vec3::ZERO), "{i}");
    }
}
