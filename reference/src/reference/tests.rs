//! The reference against integrals that are known, or computed by independent quadrature.

use super::*;
use crate::test_blockers::blockers;
use core::f64::consts::PI;
use lighting::SphereLight;
use lobe_core::Sphere;
use scene::{Mesh, Object, Proxy, Scene, Shape};
use test_scenes::{floor_and_sphere, material};

/// A G-buffer of points that no camera found.
fn points(receivers: Vec<Receiver>) -> GBuffer {
    let n = receivers.len();
    let mut g = GBuffer { width: n as u32, height: 1, samples: 1, ..GBuffer::default() };
    g.pixels = (0..n as u32).collect();
    g.depths = vec![1.0; n];
    g.points.materials = vec![0; n];
    g.points.receivers = receivers;
    g
}

fn run(scene: &Scene, gbuffer: &GBuffer, geometry: Geometry, samples: u32) -> Estimate {
    let (world, blockers) = (World::new(scene), blockers(scene, 0.0));
    let gbuffer = &GBuffer { materials: scene.materials.clone(), ..gbuffer.clone() };
    let job = ReferenceJob { world: &world, gbuffer, blockers: &blockers, geometry, seed: 5 };
    let mut reference = Reference::new(job);
    reference.advance(samples, &AtomicBool::new(false), &|_| {});
    reference.estimate()
}

fn at(position: Vec3, normal: Vec3, view: Vec3) -> Receiver {
    Receiver::on_surface(position, normal, view.normalize()).on_object(0)
}

fn empty(light: SphereLight, material: Material) -> Scene {
    Scene { objects: Vec::new(), lights: vec![light.into()], materials: vec![material], ..floor_and_sphere() }
}

/// Lambert irradiance of a sphere above the horizon is π·sin²σ·cos β; half below the horizon, at β = 90°, it is
/// asin s − s·√(1 − s²), s = sin σ (the limit of the closed form for a cut sphere, here also ∫ over the half disc).
#[test]
fn lambert_closed_forms() {
    let unit = |radius: f32, center: Vec3| SphereLight::new(Sphere { center, radius }, Vec3::splat(2.0));
    for radius in [0.002, 0.1, 0.5] {
        let g = points(vec![at(Vec3::ZERO, Vec3::Y, Vec3::Y), at(Vec3::ZERO, Vec3::X, Vec3::X)]);
        let e = run(&empty(unit(radius, Vec3::Y), material()), &g, Geometry::None, 4096);
        let s = f64::from(radius);
        let expected = [PI * s * s, s.asin() - s * (1.0 - s * s).sqrt()].map(|e| e * 2.0 * 0.5 / PI);
        for (i, expected) in expected.into_iter().enumerate() {
            let error = (f64::from(e.radiance[i].x) / expected - 1.0).abs();
            assert!(error < 3e-4, "radius {radius}, {i}: {error:e}");
        }
    }
    // Inside the light a Lambert surface reflects its albedo times L: the furnace.
    let e = run(
        &empty(unit(3.0, Vec3::new(0.5, 1.0, 0.0)), material()),
        &points(vec![at(Vec3::ZERO, Vec3::Y, Vec3::X + Vec3::Y)]),
        Geometry::None,
        4096,
    );
    assert!((e.radiance[0].x - 1.0).abs() < 1e-3, "{}", e.radiance[0]);
}

/// A light that has nearly set, down to a sliver of 1e-4 of its radius: irradiance of the small segment of a disc above
/// the horizon is, for a light of half-angle s ≪ 1, `s³·∫ from c to 1 of 2(t − c)√(1 − t²) dt`, c its depth in radii.
#[test]
fn setting_lights() {
    let s = 1e-3f64;
    for depth in [0.0, 0.5, 0.99, 0.9999] {
        let elevation = -depth * s;
        let center = Vec3::new(elevation.cos() as f32, elevation.sin() as f32, 0.0);
        let light = SphereLight::new(Sphere { center, radius: s as f32 }, Vec3::ONE);
        let g = points(vec![at(Vec3::ZERO, Vec3::Y, Vec3::Y)]);
        let e = run(&empty(light, material()), &g, Geometry::Spheres, 1024);
        // The depth after rounding to f32.
        let c = -f64::from(center.y).atan2(f64::from(center.x)) / f64::from(light.sphere.radius).asin();
        let n = 100_000;
        let segment: f64 = (0..n)
            .map(|i| {
                let t = c + (1.0 - c) * (f64::from(i) + 0.5) / f64::from(n);
                2.0 * (t - c) * (1.0 - t * t).sqrt() * (1.0 - c) / f64::from(n)
            })
            .sum();
        let expected = 0.5 / PI * s.powi(3) * segment;
        let error = (f64::from(e.radiance[0].x) / expected - 1.0).abs();
        // Directions are f32 where materials see them: 6e-8 of a height of s·(1 − c).
        assert!(error < 2e-3 + 1e-7 / (s * (1.0 - c)), "depth {depth}: {error:e}");
    }
}

/// `∫ f̃ over the cone` by the midpoint rule in polar angles about the mirrored direction, for a pure specular lobe
/// whose axis is the normal: `(e+2)/2π ∫ cos^(e+1) θ` over the part of the cap seen at angle θ.
fn phong_oracle(exponent: f64, tilt: f64, half_angle: f64) -> f64 {
    let n = 200_000;
    // Beyond that the lobe has fallen below e^−40.
    let end = (80.0 / (exponent + 1.0)).sqrt().min(PI / 2.0);
    (0..n)
        .map(|i| {
            let theta: f64 = (f64::from(i) + 0.5) / f64::from(n) * end;
            // The part of the circle θ inside the cap: spherical law of cosines.
            let cos_phi = (half_angle.cos() - tilt.cos() * theta.cos()) / (tilt.sin() * theta.sin());
            let phi = 2.0 * cos_phi.clamp(-1.0, 1.0).acos();
            (exponent + 2.0) / (2.0 * PI) * theta.cos().powf(exponent + 1.0) * phi * theta.sin()
        })
        .sum::<f64>()
        * end
        / f64::from(n)
}

/// Glossy exponents to 5000 against lights from 0.1° to 25°, in the highlight and at its edge.
#[test]
fn glossy_reflections_of_any_light() {
    let mut worst: f64 = 0.0;
    for exponent in [1.0f32, 20.0, 200.0, 5000.0] {
        for degrees in [0.1f64, 2.0, 25.0] {
            let sigma = degrees.to_radians();
            let one_minus_cos = (1.0 - sigma.cos()) as f32;
            for tilt in [0.3 * sigma, sigma, sigma + 1.0 / f64::from(exponent + 1.0).sqrt()] {
                let center = Vec3::new(tilt.sin() as f32, tilt.cos() as f32, 0.0) * 3.0;
                let sphere = Sphere { center, radius: (3.0 * sigma.sin()) as f32 };
                let m = brdf::ModifiedPhong { kd: Vec3::ZERO, ks: Vec3::ONE, exponent };
                let scene = empty(SphereLight::new(sphere, Vec3::ONE), m.into());
                let e = run(&scene, &points(vec![at(Vec3::ZERO, Vec3::Y, Vec3::Y)]), Geometry::None, 4096);
                let expected = phong_oracle(f64::from(exponent), tilt, sigma);
                // Errors are fractions of the highlight at the light's middle.
                let peak = phong_oracle(f64::from(exponent), 1e-9, sigma);
                let error = (f64::from(e.radiance[0].x) - expected).abs() / peak;
                worst = worst.max(error);
                // A narrow lobe across the light's edge has the error of an indicator function.
                assert!(
                    error < if exponent * one_minus_cos > 100.0 { 2.5e-3 } else { 1e-3 },
                    "e {exponent}, σ {degrees}°, tilt {tilt}: {error:e}, stated {}",
                    e.std_error[0].x
                );
            }
        }
    }
    eprintln!("worst error at 4096 samples, fraction of the highlight: {worst:e}");
}

/// The visible part of a small light behind a sphere is, seen in the plane, a disc less a disc: its area in closed form.
/// The reference is within 0.03 % of it all through the penumbra.
#[test]
fn penumbra_of_a_small_light() {
    let light = SphereLight::new(Sphere { center: Vec3::new(0.0, 100.0, 0.0), radius: 1.0 }, Vec3::ONE);
    let mut scene = empty(light, material());
    let (mut total, mut worst, mut rays) = (0.0, 0.0f64, 0.0);
    let steps = 41;
    for i in 0..steps {
        // The blocker half way: radius 0.4, so that it covers as much as a disc of 0.8 at the light.
        let shift = f64::from(i) / f64::from(steps - 1) * 2.0;
        let sphere = Sphere { center: Vec3::new(0.5 * shift as f32, 50.0, 0.0), radius: 0.4 };
        scene.objects = vec![Object {
            name: "blocker".into(),
            shape: Shape::Spheres(vec![sphere]),
            material: 0,
            proxy: Proxy::Spheres(vec![sphere]),
            visible: false,
            strategy: None,
            terminator: scene::Terminator::Exact,
        }];
        let receiver = Receiver { object: 7, ..at(Vec3::ZERO, Vec3::Y, Vec3::Y) };
        let g = points(vec![receiver]);
        let e = run(&scene, &g, Geometry::Spheres, 4096);
        let mesh = run(&scene, &g, Geometry::Mesh, 4096);
        let fraction = f64::from(e.radiance[0].x) / f64::from(e.unshadowed[0].x);
        // The true sphere is met by rays: their error at an edge through 8 × 512 stratified points is about 0.1 %.
        let by_rays = f64::from(mesh.radiance[0].x / mesh.unshadowed[0].x) - fraction;
        assert!(by_rays.abs() < 6e-3, "{by_rays:e}");
        rays += by_rays.abs() / f64::from(steps);

        let (big, small, d) = (1.0f64, 0.8f64, shift);
        let lens = if d >= big + small {
            0.0
        } else if d <= big - small {
            PI * small * small
        } else {
            let a = ((d * d + big * big - small * small) / (2.0 * d * big)).acos();
            let b = ((d * d + small * small - big * big) / (2.0 * d * small)).acos();
            big * big * (a - a.sin() * a.cos()) + small * small * (b - b.sin() * b.cos())
        };
        let error = fraction - (1.0 - lens / PI);
        worst = worst.max(error.abs());
        total += error.abs() / f64::from(steps);
    }
    eprintln!("mean error {total:e}, largest {worst:e}; by rays {rays:e}");
    // The small-angle oracle itself is good to 1e-4 (curvature of the cap: σ² = 1e-4).
    assert!(total < 1e-4 && worst < 3e-4 && rays < 2e-3, "{total:e} {worst:e} {rays:e}");
}

/// Lit points equal the unshadowed ones to the bit and points in the umbra are exactly 0.
#[test]
fn limits_are_exact() {
    let mut scene = floor_and_sphere();
    scene.lights[0].as_sphere_mut().expect("a sphere").sphere =
        Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 0.2 };
    let receivers = [0.0, 3.5].map(|x| Receiver { object: 0, ..at(Vec3::X * x, Vec3::Y, Vec3::Y) });
    let g = points(receivers.to_vec());
    for geometry in [Geometry::Spheres, Geometry::Mesh] {
        let e = run(&scene, &g, geometry, 64);
        assert_eq!(e.radiance[0], Vec3::ZERO);
        assert_eq!(e.radiance[1], e.unshadowed[1]);
        assert!(e.radiance[1].x > 0.0);
    }
}

/// A receiver on a sphere is not shadowed by that sphere's own proxy where τ forbids it, and the true sphere never shadows
/// itself above its horizon.
#[test]
fn own_skin_stays_lit() {
    let scene = floor_and_sphere();
    let world = World::new(&scene);
    let g = GBuffer::new(&world, 64, 64, 1);
    let mut set = blockers(&scene, 0.0);
    set.self_distances[1] = 1.01;
    for (geometry, set) in [(Geometry::Spheres, &set), (Geometry::Mesh, &set)] {
        let job = ReferenceJob { world: &world, gbuffer: &g, blockers: set, geometry, seed: 0 };
        let mut reference = Reference::new(job);
        reference.advance(64, &AtomicBool::new(false), &|_| {});
        let e = reference.estimate();
        let mut lit = 0;
        for (i, r) in g.points.receivers.iter().enumerate().filter(|(_, r)| r.object == 1) {
            assert_eq!(e.radiance[i], e.unshadowed[i], "{geometry:?} {}", r.position);
            lit += usize::from(e.radiance[i].x > 0.0);
        }
        assert!(lit > 50);
    }
}

/// A wall of triangles with interpolated normals nowhere shadows its own lit side.
#[test]
fn a_mesh_does_not_shadow_itself() {
    let mut scene = floor_and_sphere();
    scene.objects.truncate(1);
    if let Shape::Mesh(Mesh { positions, .. }) = &mut scene.objects[0].shape {
        // Off the origin and slanted, so that rounding has a chance.
        positions.iter_mut().for_each(|p| *p = glam::Quat::from_rotation_z(0.3) * *p + Vec3::new(0.37, 0.11, -0.23));
    }
    let world = World::new(&scene);
    let g = GBuffer::new(&world, 64, 64, 1);
    let e = run(&scene, &g, Geometry::Mesh, 64);
    assert!(!g.is_empty());
    assert_eq!(e.radiance, e.unshadowed);
}

/// The same to the bit on any number of threads, interrupted or not, and through a checkpoint.
#[test]
fn threads_and_interruptions_change_nothing() {
    let scene = floor_and_sphere();
    let (world, blockers) = (World::new(&scene), blockers(&scene, 0.0));
    let g = GBuffer::new(&world, 40, 30, 1);
    let job = ReferenceJob { world: &world, gbuffer: &g, blockers: &blockers, geometry: Geometry::Spheres, seed: 1 };
    let go = AtomicBool::new(false);
    let mut whole = Reference::new(job);
    let threads = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    threads(1).install(|| whole.advance(512, &go, &|_| {}));

    // Stopped after some tiles, saved, restored, finished.
    let stop = AtomicBool::new(false);
    let mut first = Reference::new(job);
    let seen = core::sync::atomic::AtomicU64::new(0);
    threads(3).install(|| {
        first.advance(512, &stop, &|n| {
            if seen.fetch_add(n, Ordering::Relaxed) > 3000 {
                stop.store(true, Ordering::Relaxed);
            }
        });
    });
    assert!(first.samples() < 512);
    let mut file = Vec::new();
    first.save(&mut file).unwrap();
    let mut second = Reference::new(job);
    second.restore(file.as_slice()).unwrap();
    let left = second.work(512);
    let seen = core::sync::atomic::AtomicU64::new(0);
    threads(2).install(|| {
        second.advance(512, &go, &|n| {
            seen.fetch_add(n, Ordering::Relaxed);
        });
    });
    assert_eq!(seen.into_inner(), left);
    assert_eq!(second.samples(), 512);
    assert_eq!(second.estimate(), whole.estimate());

    let mut other = Reference::new(ReferenceJob { seed: 2, ..job });
    assert!(matches!(other.restore(file.as_slice()), Err(CheckpointError::OtherJob)));
    for end in [0, 5, 20, file.len() - 1] {
        assert!(matches!(other.restore(&file[..end]), Err(CheckpointError::Damaged | CheckpointError::OtherJob)));
        assert!(Reference::new(job).restore(&file[..end]).is_err());
    }
    // One flipped bit anywhere, and something behind the end.
    for place in (0..file.len()).step_by(file.len() / 997).chain([file.len() - 1]) {
        let mut damaged = file.clone();
        damaged[place] ^= 1 << (place % 8);
        assert!(Reference::new(job).restore(damaged.as_slice()).is_err(), "byte {place}");
    }
    file.push(0);
    assert!(matches!(Reference::new(job).restore(file.as_slice()), Err(CheckpointError::Damaged)));
}

/// The stated standard error is the true one: against a well sampled picture, and it falls faster than 1/√N.
#[test]
fn the_stated_error_is_true() {
    let scene = floor_and_sphere();
    let g = GBuffer::new(&World::new(&scene), 40, 30, 1);
    let truth = run(&scene, &g, Geometry::Spheres, 16384);
    let rms = |v: &mut dyn Iterator<Item = f32>| {
        let (sum, n) = v.fold((0.0, 0.0), |(s, n), x| (s + f64::from(x * x), n + 1.0));
        (sum / n).sqrt()
    };
    let mut previous = f64::INFINITY;
    for samples in [256, 1024] {
        let e = run(&scene, &g, Geometry::Spheres, samples);
        let actual = rms(&mut e.radiance.iter().zip(&truth.radiance).map(|(a, b)| a.x - b.x));
        let stated = rms(&mut e.std_error.iter().map(|s| s.x));
        assert!((0.5..1.5).contains(&(actual / stated)), "{samples}: actual {actual:e}, stated {stated:e}");
        assert!(actual < previous / 2.4, "{actual:e} after {previous:e}");
        previous = actual;
    }
}
