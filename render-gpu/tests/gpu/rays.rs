//! Shadow rays on the GPU against `RayBlockers`.

use crate::call::trial;
use crate::gbuffer::{large_floor, placed};
use crate::parity::plain;
use crate::silhouettes::SILHOUETTES;
use brdf::Material;
use core::ops::ControlFlow;
use core::sync::atomic::AtomicBool;
use glam::{Mat4, Vec3};
use libtest_mimic::Trial;
use lighting::{Light, SphereLight};
use lobe_core::{Receiver, Sphere};
use paper::{PaperIntegrator, PaperVisibility, ProductTable, Resolution, Tables};
use ray_tracing::{GBuffer, World};
use reference::{Geometry, Reference, ReferenceJob};
use render_cpu::{CpuShader, blockers};
use render_gpu::{Gpu, GpuGBuffer, GpuShader, GpuWorld, Occlusion, ShadowCasting};
use scene::{BlockerSet, Camera, Counts, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, ShadingPoints, Shape};
use shading::{Accuracy, Coverage, LightLobes, Unshadowed};
use test_scenes::globe;
use visibility_mask::{LookAgain, MaskVisibility, Mixture, facet_coverage};
use visibility_rays::{GpuRays, RayBlockers};
use visibility_spheres::SphereBlockers;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("rays_on_the_built_in_scene", gpu, on_the_built_in_scene),
        trial("rays_behind_a_fence", gpu, behind_a_fence),
        trial("rays_through_masks_of_all_depths", gpu, masks_of_all_depths),
        trial("rays_of_tiny_lights", gpu, tiny_lights),
        trial("rays_from_an_edge", gpu, from_an_edge),
        trial("rays_at_all_scales", gpu, at_all_scales),
        trial("rays_under_a_wide_light", gpu, |gpu| RAYS.compare_wide(gpu)),
        trial("rays_at_terminators", gpu, at_terminators),
        trial("rays_from_a_large_floor", gpu, from_a_large_floor),
        trial("rays_follow_motion", gpu, follow_motion),
        trial("rays_near_monte_carlo", gpu, near_monte_carlo),
        trial("rays_of_some_objects", gpu, of_some_objects),
        trial("rays_of_receivers_on_their_like", gpu, of_receivers_on_their_like),
        trial("rays_by_the_papers_method", gpu, by_the_papers_method),
        trial("rays_twice_the_same_bits", gpu, twice_the_same_bits),
    ]
}

/// Thin pickets and two rails on a floor, under a light of half-angle 6°.
pub(crate) fn fence() -> Scene {
    let mut mesh = Mesh::default();
    for i in 0..33 {
        let x = (i as f32 - 16.0) * 0.06;
        mesh.append(&Mesh::cuboid(Vec3::new(x, 0.4, 0.0), Vec3::new(0.025, 0.8, 0.015)));
    }
    for y in [0.2, 0.62] {
        mesh.append(&Mesh::cuboid(Vec3::new(0.0, y, 0.015), Vec3::new(2.0, 0.04, 0.015)));
    }
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 6.0, Vec3::NEG_Z * 6.0);
    let center = 4.0 * Vec3::new(-0.5, 0.9, 0.55).normalize();
    let light = Sphere { center, radius: 4.0 * 6.0_f32.to_radians().sin() };
    let eye = Vec3::new(1.0, 1.4, 2.6);
    Scene {
        camera: Camera {
            eye,
            target: Vec3::new(0.1, 0.2, -0.2),
            up: Vec3::Y,
            projection: Projection::perspective(0.6),
        },
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::mesh("fence", mesh, 0, Proxy::Count(64))],
        lights: vec![SphereLight::new(light, Vec3::splat(90.0)).into()],
        ..plain()
    }
}

pub(crate) fn frame(scene: &Scene, tolerance: f32, depth: u32) -> Frame<'_> {
    Frame::new(&scene.materials, &scene.lights, Accuracy { tolerance, depth })
}

/// The GPU's radiance and counts.
fn from_gpu(gpu: &Gpu, scene: &Scene, points: &ShadingPoints, frame: &Frame<'_>) -> Shaded {
    let world = GpuWorld::new(gpu, scene).expect("geometry");
    let mut shader = GpuShader::new(gpu, Occlusion { blockers: &[&GpuRays], any_hit: Some(&world) }).expect("a shader");
    let mut out = vec![Vec3::NAN; points.receivers.len()];
    let stats = shader.shade(points, frame, &mut out).expect("the GPU shades");

    (out, stats.counts)
}

fn from_cpu(world: &World<'_>, points: &ShadingPoints, frame: &Frame<'_>) -> Shaded {
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let visibility = MaskVisibility::new(RayBlockers::new(world)).look_again(LookAgain::Never);
    let stats = CpuShader::new(visibility).shade(points, frame, &mut out).expect("room for all lobes");
    (out, stats.counts)
}

pub(crate) fn unshadowed(points: &ShadingPoints, frame: &Frame<'_>) -> Vec<f32> {
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    CpuShader::new(Unshadowed).shade(points, frame, &mut out).expect("room for all lobes");
    out.into_iter().map(Vec3::element_sum).collect()
}

/// The shading of a strategy on each device.
#[derive(Clone, Copy)]
pub(crate) struct Ways {
    pub(crate) cpu: fn(&World<'_>, &ShadingPoints, &Frame<'_>) -> Shaded,
    pub(crate) gpu: fn(&Gpu, &Scene, &ShadingPoints, &Frame<'_>) -> Shaded,
}

pub(crate) const RAYS: Ways = Ways { cpu: from_cpu, gpu: from_gpu };

fn compare(gpu: &Gpu, name: &str, scene: &Scene, size: [u32; 2], tolerance: f32, depth: u32) {
    RAYS.compare(gpu, name, scene, size, tolerance, depth);
}

impl Ways {
    /// Errors relative to the unshadowed radiance: mean over penumbrae, mean over all points, largest.
    pub(crate) fn compare(self, gpu: &Gpu, name: &str, scene: &Scene, size: [u32; 2], tolerance: f32, depth: u32) {
        let world = World::new(scene);
        let points = GBuffer::new(&world, size[0], size[1], 1).points;
        let frame = frame(scene, tolerance, depth);
        let whole = unshadowed(&points, &frame);
        check_alike(name, (self.cpu)(&world, &points, &frame), (self.gpu)(gpu, scene, &points, &frame), &whole);
    }

    pub(crate) fn compare_all_depths(self, gpu: &Gpu) {
        for (depth, tolerance) in [(3, 0.003), (4, 0.01), (6, 0.001)] {
            self.compare(gpu, &format!("depth {depth}"), &fence(), [48, 36], tolerance, depth);
        }
    }

    /// Below a light of 70° to 74°, whose masks are bands on a GPU, rays are about as near to the exact silhouettes as on a CPU. They search each
    /// band for blockers by itself and miss fewer, but fewer single cells of a band ask for finer searches.
    pub(crate) fn compare_wide(self, gpu: &Gpu) {
        let light = SphereLight::new(Sphere { center: Vec3::Y * 20.85, radius: 20.0 }, Vec3::ONE).into();
        let scene = Scene { lights: vec![light], ..fence() };
        let world = World::new(&scene);
        let points = GBuffer::new(&world, 32, 24, 1).points;
        let frame = frame(&scene, 0.003, 5);
        let whole = unshadowed(&points, &frame);
        let (exact, _) = (SILHOUETTES.cpu)(&world, &points, &frame);
        let (want, counts) = (self.cpu)(&world, &points, &frame);
        let (got, ours) = (self.gpu)(gpu, &scene, &points, &frame);
        let [want, got] = [want, got].map(|found| {
            let apart = exact.iter().zip(&found).zip(&whole).filter(|(_, whole)| **whole > 0.0);
            apart.map(|((a, b), whole)| f64::from((a.element_sum() - b.element_sum()).abs() / whole)).sum::<f64>()
                / whole.len() as f64
        });
        println!("wide light: {want:.1e} off by CPU, {got:.1e} by GPU; {counts:?} {ours:?}");
        assert!(counts.penumbra_points > 300 && got < 1.12 * want + 1e-5, "{want} off by CPU, {got} by GPU");
    }

    /// Neither the unit of length nor the position matters.
    pub(crate) fn compare_all_scales(self, gpu: &Gpu) {
        for (scale, shift) in [(1e-4, 0.0), (1e4, 0.0), (1.0, 30.0)] {
            let scene = placed(fence(), scale, Vec3::splat(shift));
            self.compare(gpu, &format!("scale {scale}, moved by {shift}"), &scene, [40, 30], 0.003, 5);
        }
    }
}

/// Radiance of points, and the counts.
pub(crate) type Shaded = (Vec<Vec3>, Counts);

/// The pictures agree if their masks agree but for rounding; `whole` is the unshadowed radiance.
pub(crate) fn check_alike(name: &str, (want, counts): Shaded, (got, ours): Shaded, whole: &[f32]) {
    let (mut sum, mut in_penumbra, mut largest, mut n) = (0.0, 0.0, 0.0_f64, 0);
    for ((want, got), whole) in want.iter().zip(&got).zip(whole) {
        assert!(got.is_finite(), "{got}");
        if *whole > 0.0 {
            let share = f64::from(want.element_sum() / whole);
            let difference = (f64::from(got.element_sum() / whole) - share).abs();
            sum += difference;
            largest = largest.max(difference);
            if (0.005..0.995).contains(&share) {
                in_penumbra += difference;
                n += 1;
            }
        }
    }
    let (mean, penumbra) = (sum / want.len() as f64, in_penumbra / f64::from(n.max(1)));
    println!(
        "{name}: {n} of {} in penumbra, mean {penumbra:.1e} there, {mean:.1e} of all, largest {largest:.1e}; {counts:?} {ours:?}",
        want.len()
    );
    // Rounding decides a ray that passes an edge within a few millionths of a triangle's side: a step of a bisection, two samples.
    assert!(n > 30 && penumbra < 1e-5 && mean < 2e-6 && largest < 1e-3, "{name}");
    let apart = |a: u64, b: u64| assert!(a.abs_diff(b) <= 2 + want.len() as u64 / 1000, "{name}: {counts:?} {ours:?}");
    apart(counts.lit_points, ours.lit_points);
    apart(counts.dark_points, ours.dark_points);
    apart(counts.penumbra_points, ours.penumbra_points);
}

fn on_the_built_in_scene(gpu: &Gpu) {
    compare(gpu, "built in", &plain(), [64, 36], 0.003, 5);
}

fn behind_a_fence(gpu: &Gpu) {
    compare(gpu, "fence", &fence(), [64, 48], 0.003, 5);
}

fn masks_of_all_depths(gpu: &Gpu) {
    RAYS.compare_all_depths(gpu);
}

/// Lights whose penumbrae are narrower than pixels: a single ray decides.
fn tiny_lights(gpu: &Gpu) {
    let mut scene = plain();
    for light in scene.lights.iter_mut().filter_map(Light::as_sphere_mut) {
        light.sphere.radius *= 1e-4;
        light.radiance *= 1e8;
    }
    let world = World::new(&scene);
    let points = GBuffer::new(&world, 64, 36, 1).points;
    let frame = frame(&scene, 0.003, 5);
    let ((_, want), (_, got)) = (from_cpu(&world, &points, &frame), from_gpu(gpu, &scene, &points, &frame));
    println!("{want:?} {got:?}");
    assert!(want.lit_points > 1000 && want.dark_points > 300);
    assert!(want.lit_points.abs_diff(got.lit_points) < 4 && want.dark_points.abs_diff(got.dark_points) < 4);
}

/// Points at the upper edge of a box, exactly on its top and slightly inside its back. The top hides nothing from them.
fn from_an_edge(gpu: &Gpu) {
    let mesh = Mesh::cuboid(Vec3::new(0.0, 0.5, 0.0), Vec3::ONE);
    let light = Sphere { center: Vec3::new(0.25, 6.0, 4.5), radius: 0.7 };
    let scene = Scene {
        objects: vec![Object::mesh("box", mesh, 0, Proxy::Count(8))],
        lights: vec![SphereLight::new(light, Vec3::splat(90.0)).into()],
        ..fence()
    };
    let at = |k: i32| Receiver::on_surface(Vec3::new(k as f32 / 16.0, 1.0, -0.5), Vec3::Z, Vec3::Z).on_object(0);
    let receivers: Vec<_> = (-7..8).map(at).collect();
    let points = ShadingPoints { materials: vec![0; receivers.len()], receivers, ..ShadingPoints::default() };
    let world = World::new(&scene);
    let frame = frame(&scene, 0.003, 5);
    let ((want, counts), (got, ours)) = (from_cpu(&world, &points, &frame), from_gpu(gpu, &scene, &points, &frame));
    let whole = unshadowed(&points, &frame);
    for ((want, got), whole) in want.iter().zip(&got).zip(whole) {
        println!("{want} {got} of {whole}");
        assert!(want.element_sum() > 0.99 * whole && (*want - *got).abs().max_element() < 1e-4 * whole);
    }
    assert_eq!((counts.dark_points, ours.dark_points), (0, 0));
}

fn at_all_scales(gpu: &Gpu) {
    RAYS.compare_all_scales(gpu);
}

/// Coarse facets under smooth normals, on a floor whose plane is not exact in f32: facets cut the light of many points.
fn at_terminators(gpu: &Gpu) {
    let mut scene = large_floor(80.0);
    scene.objects.push(Object::mesh("globe", globe(14, Vec3::Y * 0.3, 0.5, true), 0, Proxy::Count(8)));
    scene.lights[0].as_sphere_mut().expect("a sphere").sphere.radius = 1.2;
    scene.camera.projection = Projection::perspective(0.4);
    let world = World::new(&scene);
    let points = GBuffer::new(&world, 64, 48, 1).points;
    let cut = points.receivers.iter().filter(|at| {
        let cone = scene.lights[0].cone(at);
        at.object == 1 && facet_coverage(at, &cone) == Coverage::Partial && at.normal.dot(cone.axis) > 0.0
    });
    let cut = cut.count();
    assert!(cut > 60, "{cut}");
    compare(gpu, "terminators", &scene, [64, 48], 0.003, 5);
}

/// A tilted floor, a thousand times as large as the distance to the visible points, shades none of them, on CPU and GPU.
fn from_a_large_floor(gpu: &Gpu) {
    let scene = large_floor(1000.0);
    let [width, height] = [64, 48];
    let mut gbuffer = GpuGBuffer::new(gpu, &scene).expect("geometry");
    let found = gbuffer.read(&scene.camera, width, height, 0..width, 0..height).expect("points").0;
    let world = World::new(&scene);
    for points in [found, GBuffer::new(&world, width, height, 1).points] {
        let frame = frame(&scene, 0.003, 5);
        let ((_, want), (_, got)) = (from_cpu(&world, &points, &frame), from_gpu(gpu, &scene, &points, &frame));
        println!("{want:?} {got:?}");
        let all = points.receivers.len() as u64;
        assert!(all > 2000 && want.lit_points == all && got.lit_points == all);
    }
}

/// A fence stops only the rays of its own receivers: its receivers see the same as if it stopped all rays; the floor sees the same
/// as without the fence.
fn of_receivers_on_their_like(gpu: &Gpu) {
    let scene = fence();
    let points = GBuffer::new(&World::new(&scene), 40, 30, 1).points;
    let frame = frame(&scene, 0.003, 5);
    let shade = |fence: ShadowCasting| {
        let world = GpuWorld::with_casting(gpu, &scene, |o| if o == 1 { fence } else { ShadowCasting::None })
            .expect("geometry");
        let occlusion = Occlusion { blockers: &[&GpuRays], any_hit: Some(&world) };
        let mut out = vec![Vec3::NAN; points.receivers.len()];
        GpuShader::new(gpu, occlusion).expect("a shader").shade(&points, &frame, &mut out).expect("the GPU shades");
        out
    };
    let [none, all, alike] = [ShadowCasting::None, ShadowCasting::All, ShadowCasting::Alike].map(shade);
    let of = |object: u32| -> Vec<usize> { (0..all.len()).filter(|k| points.receivers[*k].object == object).collect() };
    let (floor, own) = (of(0), of(1));
    assert!(floor.iter().all(|k| alike[*k] == none[*k]) && own.iter().all(|k| alike[*k] == all[*k]));
    // Both have shadows from the fence.
    assert!([floor, own].iter().all(|points| points.iter().any(|k| all[*k] != none[*k])));
}

/// Some objects by rays, the others by spheres: as the CPU's mixture of both.
fn of_some_objects(gpu: &Gpu) {
    let scene = plain();
    let by_rays = |object: u32| object == 2 || object == 4;
    let world = World::new(&scene);
    let points = GBuffer::new(&world, 64, 36, 1).points;
    let mut set = blockers(&scene, &mut |_, _| ControlFlow::Continue(())).expect("exact spheres");
    let keep: Vec<bool> = set.objects.iter().map(|o| !by_rays(*o)).collect();
    let mut kept = keep.iter();
    set.spheres.retain(|_| *kept.next().expect("one a sphere"));
    let mut kept = keep.iter();
    set.objects.retain(|_| *kept.next().expect("one a sphere"));
    let spheres = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
    let frame = frame(&scene, 0.003, 5);
    let (mut want, mut got) = (vec![Vec3::ZERO; points.receivers.len()], vec![Vec3::NAN; points.receivers.len()]);
    let mixture = Mixture::new(spheres.clone(), RayBlockers::new(&world).only(by_rays));
    let visibility = MaskVisibility::new(mixture).look_again(LookAgain::Never);
    let counts = CpuShader::new(visibility).shade(&points, &frame, &mut want).expect("room for all lobes").counts;
    let ours = GpuWorld::only(gpu, &scene, by_rays).expect("geometry");
    let occlusion = Occlusion { blockers: &[&spheres, &GpuRays], any_hit: Some(&ours) };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
    let found = shader.shade(&points, &frame, &mut got).expect("the GPU shades").counts;
    check_picture(&want, &got, 1e-3);
    println!("{counts:?} {found:?}");
    assert!(counts.dark_points.abs_diff(found.dark_points) < 4 && counts.lit_points.abs_diff(found.lit_points) < 4);
}

fn by_the_papers_method(gpu: &Gpu) {
    let tables = Tables::with_products(ProductTable::build_with(Resolution { angles: 33, per_interval: 4 }));
    let scene = fence();
    let world = World::new(&scene);
    let points = GBuffer::new(&world, 40, 30, 1).points;
    let frame = frame(&scene, 0.003, 4);
    let (mut want, mut got) = (vec![Vec3::ZERO; points.receivers.len()], vec![Vec3::NAN; points.receivers.len()]);
    let visibility = PaperVisibility::new(RayBlockers::new(&world), &tables);
    let mut cpu = CpuShader::with_integrator(visibility, PaperIntegrator { tables: &tables });
    let counts = cpu.shade(&points, &frame, &mut want).expect("room for all lobes").counts;
    let ours = GpuWorld::new(gpu, &scene).expect("geometry");
    let occlusion = Occlusion { blockers: &[&GpuRays], any_hit: Some(&ours) };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader").with_paper(&tables);
    let found = shader.shade(&points, &frame, &mut got).expect("the GPU shades").counts;
    check_picture(&want, &got, 1e-3);
    println!("{counts:?} {found:?}");
    assert!(counts.penumbra_points > 50 && counts.penumbra_points.abs_diff(found.penumbra_points) < 3);
}

/// Pictures agree, with differences relative to the largest value.
pub(crate) fn check_picture(want: &[Vec3], got: &[Vec3], limit: f32) {
    let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let apart: Vec<f32> = want.iter().zip(got).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    let (mean, largest) = (apart.iter().sum::<f32>() / apart.len() as f32, apart.iter().copied().fold(0.0, f32::max));
    println!("mean {mean:.1e}, largest {largest:.1e} of the peak");
    assert!(got.iter().all(|v| v.is_finite()) && mean < 1e-5 && largest < limit);
}

/// A scene that moves: a refitted hierarchy gives the same picture as a new one.
fn follow_motion(gpu: &Gpu) {
    let mut scene = fence();
    let points = GBuffer::new(&World::new(&scene), 40, 30, 1).points;
    let mut world = GpuWorld::new(gpu, &scene).expect("geometry");
    let mut shader = GpuShader::new(gpu, Occlusion { blockers: &[&GpuRays], any_hit: Some(&world) }).expect("a shader");
    let shade = |shader: &mut GpuShader, scene: &Scene| {
        let mut out = vec![Vec3::NAN; points.receivers.len()];
        shader.shade(&points, &frame(scene, 0.003, 5), &mut out).expect("the GPU shades");
        out
    };
    let before = shade(&mut shader, &scene);
    let Shape::Mesh(mesh) = &mut scene.objects[1].shape else { unreachable!("a mesh") };
    mesh.transform(&Mat4::from_translation(Vec3::new(0.03, 0.0, -0.1)));
    world.update(&scene).expect("geometry");
    shader.occlude(Occlusion { blockers: &[&GpuRays], any_hit: Some(&world) }).expect("a shader");
    let moved = shade(&mut shader, &scene);
    assert!(before != moved && moved == from_gpu(gpu, &scene, &points, &frame(&scene, 0.003, 5)).0);
}

/// The error of the visible fraction against many shadow rays is that of the CPU.
fn near_monte_carlo(gpu: &Gpu) {
    let scene = plain();
    let world = World::new(&scene);
    let g = GBuffer::new(&world, 72, 40, 1);
    let none = BlockerSet::default();
    let job = ReferenceJob { world: &world, gbuffer: &g, blockers: &none, geometry: Geometry::Mesh, seed: 1 };
    let mut reference = Reference::new(job);
    reference.advance(1024, &AtomicBool::new(false), &|_| {});
    let truth = reference.estimate();
    let frame = frame(&scene, 0.003, 5);
    let whole = unshadowed(&g.points, &frame);
    let error = |out: &[Vec3]| {
        let mut errors = Vec::new();
        for (i, out) in out.iter().enumerate() {
            let sum = |v: Vec3| f64::from(v.element_sum());
            let want = sum(truth.radiance[i]) / sum(truth.unshadowed[i]);
            if whole[i] > 0.0 && (0.01..=0.99).contains(&want) {
                errors.push((sum(*out) / f64::from(whole[i]) - want).abs());
            }
        }
        errors.sort_by(f64::total_cmp);
        (errors.iter().sum::<f64>() / errors.len() as f64, errors[errors.len() * 99 / 100])
    };
    let cpu = error(&from_cpu(&world, &g.points, &frame).0);
    let ours = error(&from_gpu(gpu, &scene, &g.points, &frame).0);
    println!("error against shadow rays, mean and 99th percentile: {ours:?}, of the CPU's masks {cpu:?}");
    assert!(ours.0 < 1.02 * cpu.0 && ours.1 < 1.05 * cpu.1);
}

fn twice_the_same_bits(gpu: &Gpu) {
    let scene = fence();
    let points = GBuffer::new(&World::new(&scene), 40, 30, 1).points;
    let frame = frame(&scene, 0.003, 5);
    let look = || from_gpu(gpu, &scene, &points, &frame);
    assert_eq!(look(), look());
}
