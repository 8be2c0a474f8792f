//! Where light ends on coarse smooth meshes: beside the fine mesh that they stand for.

use brdf::Material;
use glam::Vec3;
use lighting::SphereLight;
use lobe_core::Sphere;
use renderer::{Renderer, Settings};
use scene::{Animation, Camera, Object, Projection, Proxy, Scene, Strategy, Terminator};
use test_scenes::globe;

/// A globe with a lamp beside it, so that light ends across the picture's middle.
fn picture(n: u32, terminator: Terminator, strategy: Strategy) -> Vec<Vec3> {
    let globe = Object::mesh("globe", globe(n, Vec3::ZERO, 1.0, true), 0, Proxy::None);
    let lamp = Sphere { center: Vec3::new(9.0, 2.0, 1.0), radius: 0.5 };
    let scene = Scene {
        camera: Camera { eye: Vec3::Z * 6.0, projection: Projection::perspective(0.3), ..Camera::default() },
        width: 96,
        height: 96,
        materials: vec![Material::lambert(Vec3::ONE)],
        objects: vec![Object { terminator, strategy: Some(strategy), ..globe }],
        lights: vec![SphereLight::new(lamp, Vec3::splat(100.0)).into()],
        ..Scene::default()
    };
    let renderer = Renderer::new(scene, Animation::default(), Settings::default());
    renderer.and_then(|mut renderer| renderer.render()).expect("a picture").radiance
}

/// Mean and largest difference from a fine globe, of its brightest pixel, where both are seen.
fn difference(a: &[Vec3], fine: &[Vec3]) -> [f32; 2] {
    let brightest = fine.iter().map(|pixel| pixel.x).fold(0.0, f32::max);
    // Away from the outline, which a coarse globe cuts off.
    let inside = |i: usize| {
        let (x, y) = ((i % 96) as f32 - 47.5, (i / 96) as f32 - 47.5);
        x.hypot(y) < 40.0
    };
    let errors: Vec<f32> =
        (0..a.len()).filter(|i| inside(*i)).map(|i| (a[i].x - fine[i].x).abs() / brightest).collect();
    [errors.iter().sum::<f32>() / errors.len() as f32, errors.iter().copied().fold(0.0, f32::max)]
}

#[test]
fn light_ends_as_on_the_surface_that_is_meant() {
    for strategy in [Strategy::Silhouettes, Strategy::Rays] {
        let fine = picture(192, Terminator::Exact, strategy);
        let exact = difference(&picture(10, Terminator::Exact, strategy), &fine);
        let smooth = difference(&picture(10, Terminator::Smooth, strategy), &fine);
        println!("{strategy:?}: exact {exact:?}, smooth {smooth:?}");
        assert!(exact[1] > 0.05, "{strategy:?}: a coarse globe shows steps of {}", exact[1]);
        assert!(smooth[0] < 0.65 * exact[0] && smooth[1] < 0.35 * exact[1], "{strategy:?}: {exact:?} {smooth:?}");
        // A fine mesh needs nothing of it.
        let fine_smooth = difference(&picture(192, Terminator::Smooth, strategy), &fine);
        assert!(fine_smooth[0] < 1e-3, "{strategy:?}: {fine_smooth:?}");
    }
}

/// Flat meshes and spheres are as they were, to the bit.
#[test]
fn flat_things_stay_as_they_are() {
    let [exact, smooth] = [Terminator::Exact, Terminator::Smooth].map(|terminator| {
        let mut scene = test_scenes::floor_and_sphere();
        let flat = Object::mesh("flat", globe(8, Vec3::new(1.5, 0.7, 0.5), 0.5, false), 0, Proxy::None);
        scene.objects.push(flat);
        scene.objects.iter_mut().for_each(|object| object.terminator = terminator);
        let renderer = Renderer::new(scene, Animation::default(), Settings::default());
        renderer.and_then(|mut renderer| renderer.render()).expect("a picture").radiance
    });
    assert_eq!(exact, smooth);
}
