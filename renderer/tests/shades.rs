//! Lampshades and leaves before lights: each pixel's radiance is right as a part of itself, against Monte Carlo of the same triangles.

use core::sync::atomic::AtomicBool;
use glam::Vec3;
use lighting::{Environment, EnvironmentMap, FlatLight, Light, SphereLight, SunLight, TubeLight};
use lobe_core::Sphere;
use ray_tracing::{GBuffer, PixelSamples, World};
use reference::{Geometry, Reference, ReferenceJob};
use renderer::{Renderer, Settings};
use scene::{Animation, BlockerSet, Mesh, Object, Proxy, Scene, Strategy};
use std::sync::Arc;
use test_scenes::{around_lampshade, below_leaves};

/// Samples of the reference.
const SAMPLES: u32 = 4096;

/// Mean and 99th percentile of the error of pixels as a part of their own radiance, the sum's error, and the mean standard error of the reference.
fn own_errors(scene: &Scene, truth: &[(f32, f32)], strategy: Strategy) -> [f32; 4] {
    let settings = Settings { strategy: Some(strategy), samples: PixelSamples::Uniform(1), ..Settings::default() };
    let renderer = Renderer::new(scene.clone(), Animation::default(), settings);
    let image = renderer.and_then(|mut renderer| renderer.render()).expect("a picture").radiance;
    let mut lit: Vec<f32> = truth.iter().map(|(value, _)| *value).filter(|value| *value > 0.0).collect();
    lit.sort_unstable_by(f32::total_cmp);
    // White is twice the radiance that nine of ten lit pixels stay below.
    let least = 2e-3 * lit[lit.len() * 9 / 10];
    let pairs = || truth.iter().zip(&image).filter(|((value, _), _)| *value > least);
    let mut errors: Vec<f32> = pairs().map(|((value, _), got)| (got.x / value - 1.0).abs()).collect();
    errors.sort_unstable_by(f32::total_cmp);
    let mean = |values: &mut dyn Iterator<Item = f32>| values.sum::<f32>() / errors.len() as f32;
    let [sum, wanted] = pairs().fold([0.0; 2], |[a, b], ((value, _), got)| [a + got.x, b + value]);
    let noise = mean(&mut pairs().map(|((value, noise), _)| noise / value));
    [mean(&mut errors.iter().copied()), errors[errors.len() * 99 / 100], sum / wanted - 1.0, noise]
}

/// Radiance of each pixel and its standard error, by a number of samples for a point and a light.
fn truth(scene: &Scene, samples: u32) -> Vec<(f32, f32)> {
    let world = World::new(scene);
    let gbuffer = GBuffer::new(&world, scene.width, scene.height, 1);
    let blockers = BlockerSet::default();
    let job = ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 3 };
    let mut reference = Reference::new(job);
    reference.advance(samples, &AtomicBool::new(false), &|_| {});
    let estimate = reference.estimate();
    // The sky itself is no shaded point.
    let values = gbuffer.resolve(&estimate.radiance, Vec3::ZERO);
    let noise = gbuffer.resolve(&estimate.std_error, Vec3::ZERO);
    values.iter().zip(noise).map(|(value, noise)| (value.x, noise.x)).collect()
}

/// How far the mean error of rays may be beyond the noise: they miss what is between the cells of a mask.
const RAYS: f32 = 0.015;

/// Prints a scene's errors by silhouettes and rays, of which those by silhouettes are to be at most so much beyond the noise.
fn check(name: &str, scene: &Scene, [most, most_of_99]: [f32; 2]) {
    let truth = truth(scene, SAMPLES);
    for strategy in [Strategy::Silhouettes, Strategy::Rays] {
        let [mean, p99, bias, noise] = own_errors(scene, &truth, strategy);
        println!("{name}, {strategy:?}: own error {mean:.4}, 99 % {p99:.3}, sum {bias:+.4}; noise {noise:.4}");
        let is_right = match strategy {
            Strategy::Rays => mean < noise + RAYS.max(most),
            _ => mean < noise + most && p99 < 10.0 * noise + most_of_99,
        };
        assert!(is_right, "{name}, {strategy:?}: {mean} {p99} {noise}");
    }
}

fn sphere(center: Vec3, radius: f32) -> Light {
    SphereLight::new(Sphere { center, radius }, Vec3::splat(50.0)).into()
}

#[test]
fn lampshades_end_light_above_and_below() {
    const BULB: Vec3 = Vec3::new(0.0, 1.55, 0.0);
    let disc = FlatLight::disc(BULB, Vec3::NEG_Y, 0.1, Vec3::splat(50.0)).expect("a disc");
    let [low, high] = [-0.08, 0.08].map(|y| BULB + Vec3::Y * y);
    let tube = TubeLight { ends: [low, high], radius: 0.03, radiance: Vec3::splat(50.0) };
    for (name, [below, above], light) in [
        ("cone, sphere of 0.03", [0.26, 0.12], sphere(BULB, 0.03)),
        ("cone, sphere of 0.1", [0.26, 0.12], sphere(BULB, 0.1)),
        ("cylinder, sphere of 0.1", [0.18, 0.18], sphere(BULB, 0.1)),
        ("cone, disc", [0.26, 0.12], disc.into()),
        // Points see a tip of it alone, along its axis.
        ("cone, tube", [0.26, 0.12], tube.into()),
    ] {
        check(name, &around_lampshade(below, above, vec![light]), [0.005, 0.05]);
    }
}

/// A tube that comes out of an upright panel at 13°, or is half sunk in it lengthwise.
#[test]
fn tubes_come_out_of_panels() {
    let middle = Vec3::new(0.0, 1.5, 0.0);
    for (name, degrees) in [("tube through a panel", 13.0_f32), ("half sunk in a panel", 0.0)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        for (name, along, across) in [
            (format!("{name} above"), Vec3::new(cos, sin, 0.0), Vec3::Z * 1.5),
            (format!("{name} beside"), Vec3::new(cos, 0.0, sin), Vec3::Y * 1.4),
        ] {
            let tube = TubeLight { ends: [middle - along, middle + along], radius: 0.1, radiance: Vec3::splat(9.0) };
            let mut scene = below_leaves(1, 0.1, vec![tube.into()]);
            scene.objects[1] = Object::mesh("panel", Mesh::quad(middle, Vec3::X * 1.5, across), 0, Proxy::None);
            check(&name, &scene, [0.004, 0.03]);
        }
    }
}

/// A plate 25 mm below an upright tube: in line with the tube a receiver sees its end alone, beside that both in one plane. None of them is lit.
#[test]
fn plates_hide_the_ends_of_tubes() {
    let ends = [1.0, 1.9].map(|height| Vec3::Y * height);
    let tube = TubeLight { ends, radius: 0.02, radiance: Vec3::splat(200.0) };
    let mut scene = below_leaves(1, 0.1, vec![tube.into()]);
    scene.objects[1] =
        Object::mesh("plate", Mesh::quad(Vec3::Y * 0.955, Vec3::X * 0.12, Vec3::Z * 0.12), 0, Proxy::None);
    scene.camera.target = Vec3::ZERO;
    let truth = truth(&scene, SAMPLES);
    let white = truth.iter().fold(0.0_f32, |most, (value, _)| most.max(*value));
    for strategy in [Strategy::Silhouettes, Strategy::Rays] {
        let settings = Settings { strategy: Some(strategy), samples: PixelSamples::Uniform(1), ..Settings::default() };
        let mut renderer = Renderer::new(scene.clone(), Animation::default(), settings).expect("a scene");
        let image = renderer.render().expect("a picture").radiance;
        let dark: Vec<f32> = truth.iter().zip(&image).filter(|((v, _), _)| *v == 0.0).map(|(_, got)| got.x).collect();
        let most = dark.iter().fold(0.0_f32, |most, value| most.max(*value));
        println!("{strategy:?}: {} dark pixels, at most {:.4} of white", dark.len(), most / white);
        assert!(dark.len() > 8 && most < 2e-3 * white, "{strategy:?}: {most} of {white}");
    }
}

/// Few leaves and many, of which several lie in one sample of a sky.
#[test]
fn leaves_hide_what_they_cover() {
    let around = Sphere { center: Vec3::Y, radius: 15.0 };
    let toward = Vec3::new(-0.4, 1.0, 0.3).normalize();
    let sun = SunLight::new(toward, SunLight::HALF_ANGLE, Vec3::splat(3.0), around);
    let panel = FlatLight::rectangle(Vec3::Y * 5.0, Vec3::X * 2.0, Vec3::Z * 2.0, Vec3::ONE).expect("a square");
    for (count, size) in [(300, 0.12), (1500, 0.12)] {
        let scene = |light: Light| below_leaves(count, size, vec![light]);
        check(&format!("{count} leaves, sun"), &scene(sun.into()), [0.005, 0.05]);
        check(&format!("{count} leaves, sphere"), &scene(sphere(Vec3::Y * 5.0, 1.0)), [0.005, 0.05]);
        check(&format!("{count} leaves, square"), &scene(panel.clone().into()), [0.005, 0.05]);
        let sky = Environment::new(EnvironmentMap::uniform(Vec3::ONE), 2, around);
        let mut scene = below_leaves(count, size, sky.lights().to_vec());
        scene.environment = Some(Arc::new(sky));
        check(&format!("{count} leaves, sky"), &scene, [0.005, 0.05]);
    }
}

/// Thousands of leaves, through which points see a lamp in many pieces, or in a few of its hundredths.
#[test]
fn crowns_let_little_light_through() {
    for (count, radius) in [(20_000, 0.1), (6000, 0.6)] {
        let scene = below_leaves(count, 0.06, vec![sphere(Vec3::Y * 5.0, radius)]);
        let truth = truth(&scene, 4 * SAMPLES);
        let [mean, p99, bias, noise] = own_errors(&scene, &truth, Strategy::Silhouettes);
        println!(
            "{count} leaves, lamp of {radius}: own error {mean:.4}, 99 % {p99:.3}, sum {bias:+.4}; noise {noise:.4}"
        );
        assert!(mean < noise + 0.004 && p99 < 8.0 * noise + 0.02, "{count} leaves");
    }
}
