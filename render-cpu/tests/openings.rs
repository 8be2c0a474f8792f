//! A closed room with one opening: each point sees a small part of a large light, and its radiance is right as a part of itself.

use core::f64::consts::PI;
use glam::{DVec3, Vec3};
use lighting::{FlatLight, Light, SphereLight};
use lobe_core::{Receiver, Sphere};
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SurfaceHits, World};
use scene::{Frame, Shade};
use shading::Accuracy;
use test_scenes::{Opening, ROOM, room};
use visibility_mask::MaskVisibility;
use visibility_silhouettes::SilhouetteBlockers;

const LIGHT: DVec3 = DVec3::new(0.0, 0.3, -12.5);
/// Half a side of squares of light, and the radius of the sphere.
const SQUARES: [f64; 2] = [11.0, 15.0];
const SPHERE: f64 = 6.0;
/// Points of the opening, upward and across, that the integral is over.
const STEPS: [usize; 2] = [192, 192];

/// The radiance of a white diffuse point: an integral over the opening, in f64.
fn oracle(at: &Receiver, [left, right, low, high]: Opening, is_light: impl Fn(DVec3, DVec3) -> bool) -> f64 {
    let [left, right, low, high] = [left, right, low, high].map(f64::from);
    let (x, n) = (at.position.as_dvec3(), at.normal.as_dvec3());
    let mut sum = 0.0;
    for j in 0..STEPS[0] {
        for i in 0..STEPS[1] {
            // Rows are shifted, so that no side of the light runs along the points.
            let shift = ((j as f64 + 0.5) * 0.618_033_988_75).fract();
            let u = left + (right - left) * (i as f64 + shift) / STEPS[1] as f64;
            let v = low + (high - low) * (j as f64 + 0.5) / STEPS[0] as f64;
            let to = DVec3::new(u, v, f64::from(-ROOM.z)) - x;
            let direction = to.normalize();
            if is_light(x, direction) {
                sum += n.dot(direction).max(0.0) * -direction.z / to.length_squared();
            }
        }
    }
    sum * (right - left) * (high - low) / (PI * (STEPS[0] * STEPS[1]) as f64)
}

/// Mean and 99th percentile of the error of each point as a part of its own radiance, and the largest radiance that is not seen at all.
fn own_errors(opening: Opening, light: Light, is_light: impl Fn(DVec3, DVec3) -> bool) -> [f64; 3] {
    let scene = room(opening, light);
    let world = World::new(&scene);
    let mut silhouettes = SceneSilhouettes::new(&scene, |_| true);
    silhouettes.refit(&scene);
    let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |_| true));
    let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let frame =
        Frame { materials: &scene.materials, lights: &scene.lights, accuracy: Accuracy::default(), threshold: 0.0 };
    CpuShader::new(MaskVisibility::new(blockers)).shade(&points, &frame, &mut out).expect("room");
    let truth: Vec<f64> = points.receivers.iter().map(|at| oracle(at, opening, &is_light)).collect();
    let white = truth.iter().copied().fold(0.0, f64::max);
    let bright = truth.iter().zip(&out).filter(|(truth, _)| **truth > 1e-3 * white);
    let mut errors: Vec<f64> = bright.map(|(truth, got)| (f64::from(got.x) / truth - 1.0).abs()).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let dark = truth.iter().zip(&out).filter(|(_, got)| **got == Vec3::ZERO).map(|(truth, _)| truth / white);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    [mean, errors[errors.len() * 99 / 100], dark.fold(0.0, f64::max)]
}

#[test]
fn rooms_behind_openings_are_lit() {
    let center = LIGHT.as_vec3();
    let sphere = || Light::from(SphereLight::new(Sphere { center, radius: SPHERE as f32 }, Vec3::ONE));
    let square = |half: f64| {
        let [u, v] = [Vec3::X, Vec3::Y].map(|side| side * half as f32);
        Light::from(FlatLight::rectangle(center, u, v, Vec3::ONE).expect("a square"))
    };
    let meets_square = |half: f64, x: DVec3, v: DVec3| {
        let met = x + v * ((LIGHT.z - x.z) / v.z) - LIGHT;
        v.z < 0.0 && met.x.abs() < half && met.y.abs() < half
    };
    let meets_sphere = |x: DVec3, v: DVec3| {
        let to = LIGHT - x;
        to.dot(v) > 0.0 && to.reject_from_normalized(v).length_squared() < SPHERE * SPHERE
    };
    // The most of mean and 99th percentile by each light.
    let openings = [
        ("window", [-0.6, 0.6, -0.2, 0.8], [[0.007, 0.04], [0.014, 0.07]]),
        ("small window", [-0.2, 0.2, 0.1, 0.5], [[0.009, 0.05], [0.014, 0.04]]),
    ];
    for (name, opening, most) in openings {
        let by_square = SQUARES.map(|half| own_errors(opening, square(half), |x, v| meets_square(half, x, v)));
        let by_sphere = own_errors(opening, sphere(), meets_sphere);
        let squares = by_square.map(|errors| ("square", errors, most[0]));
        for (light, [mean, p99, dark], most) in squares.into_iter().chain([("sphere", by_sphere, most[1])]) {
            println!("{name}, {light}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
            assert!(mean < most[0] && p99 <= most[1], "{name}, {light}: {mean} {p99}");
        }
    }
}

/// A slit narrower than a sample of the first mask, in front of lights that are long or wide, whose middle it shows to some points.
#[test]
fn slits_between_samples_are_found() {
    let slit = [-0.02, 0.02, -1.3, 0.8];
    let center = DVec3::new(0.0, 0.5, -4.5);
    for half in [DVec3::new(6.0, 0.5, 0.0), DVec3::new(6.0, 2.0, 0.0)] {
        let [u, v] = [Vec3::X * half.x as f32, Vec3::Y * half.y as f32];
        let light = FlatLight::rectangle(center.as_vec3(), u, v, Vec3::ONE).expect("a rectangle");
        let is_light = |x: DVec3, v: DVec3| {
            let met = x + v * ((center.z - x.z) / v.z) - center;
            v.z < 0.0 && met.x.abs() < half.x && met.y.abs() < half.y
        };
        let [mean, p99, dark] = own_errors(slit, light.into(), is_light);
        println!("slit, {half}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
        assert!(dark < 0.01 && mean < 0.05, "{half}: {dark} {mean}");
    }
}
