//! Silhouettes on the GPU, as a strategy that render-gpu does not know, against `SilhouetteBlockers`.

use crate::call::trial;
use crate::gbuffer::large_floor;
use crate::parity::plain;
use crate::rays::{Shaded, Ways, check_alike, check_picture, fence, frame, unshadowed};
use glam::{Mat4, Vec3};
use libtest_mimic::Trial;
use lighting::Light;
use lobe_core::Sphere;
use paper::{PaperIntegrator, PaperVisibility, ProductTable, Resolution, Tables};
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SurfaceHits, World};
use render_gpu::{Gpu, GpuError, GpuShader, GpuWorld, Occlusion};
use scene::{Frame, Mesh, Object, Proxy, Scene, Shade, ShadingPoints, Shape};
use shading::gpu::{GpuBlockers, GpuLight as _};
use test_scenes::globe;
use visibility_mask::{LookAgain, MaskVisibility, Mixture};
use visibility_silhouettes::{AnyHit as _, GpuSilhouettes, SilhouetteBlockers};
use visibility_spheres::SphereBlockers;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("silhouettes_behind_a_fence", gpu, behind_a_fence),
        trial("silhouettes_through_masks_of_all_depths", gpu, masks_of_all_depths),
        trial("silhouettes_at_all_scales", gpu, at_all_scales),
        trial("silhouettes_at_terminators", gpu, at_terminators),
        trial("silhouettes_under_a_wide_light", gpu, |gpu| SILHOUETTES.compare_wide(gpu)),
        trial("silhouettes_more_than_are_kept", gpu, more_than_are_kept),
        trial("silhouettes_follow_motion", gpu, follow_motion),
        trial("silhouettes_beside_spheres", gpu, beside_spheres),
        trial("silhouettes_by_the_papers_method", gpu, by_the_papers_method),
        trial("silhouettes_twice_the_same_bits", gpu, twice_the_same_bits),
        trial("silhouettes_want_any_hit", gpu, want_any_hit),
    ]
}

/// Whether an object's triangles block.
fn is_mesh(scene: &Scene, object: u32) -> bool {
    matches!(scene.objects[object as usize].shape, Shape::Mesh(_))
}

fn from_gpu(gpu: &Gpu, scene: &Scene, points: &ShadingPoints, frame: &Frame<'_>) -> Shaded {
    looking_again(gpu, scene, (points, frame), LookAgain::Never)
}

/// With masks that are drawn again around what is lit.
pub(crate) fn looking_again(
    gpu: &Gpu,
    scene: &Scene,
    (points, frame): (&ShadingPoints, &Frame<'_>),
    again: LookAgain,
) -> Shaded {
    let world = GpuWorld::only(gpu, scene, |o| is_mesh(scene, o)).expect("geometry");
    let blockers = GpuSilhouettes::new(SceneSilhouettes::new(scene, |o| is_mesh(scene, o)).meshes());
    let geometry = World::new(scene);
    let hits = SurfaceHits::new(&geometry, |o| is_mesh(scene, o));
    let cut = |light: &Light| {
        let mut triangles = Vec::new();
        if light.gpu_roundness().is_some() {
            hits.triangles_meeting(light.gpu_bounds(), &mut |corners| triangles.push(corners));
        }
        triangles
    };
    let blockers = blockers.with_clipped(&scene.lights.iter().map(cut).collect::<Vec<_>>());
    let occlusion = Occlusion { blockers: &[&blockers], any_hit: Some(&world) };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
    shader.set_look_again(again);
    let mut out = vec![Vec3::NAN; points.receivers.len()];
    let stats = shader.shade(points, frame, &mut out).expect("the GPU shades");
    (out, stats.counts)
}

fn from_cpu(world: &World<'_>, points: &ShadingPoints, frame: &Frame<'_>) -> Shaded {
    let scene = world.scene();
    let silhouettes = SceneSilhouettes::new(scene, |o| is_mesh(scene, o));
    let hits = SurfaceHits::new(world, |o| is_mesh(scene, o));
    let visibility =
        MaskVisibility::new(SilhouetteBlockers::new(silhouettes.meshes(), hits)).look_again(LookAgain::Never);
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let stats = CpuShader::new(visibility).shade(points, frame, &mut out).expect("room for all lobes");
    (out, stats.counts)
}

pub(crate) const SILHOUETTES: Ways = Ways { cpu: from_cpu, gpu: from_gpu };

fn compare(gpu: &Gpu, name: &str, scene: &Scene, size: [u32; 2]) {
    SILHOUETTES.compare(gpu, name, scene, size, 0.003, 5);
}

fn behind_a_fence(gpu: &Gpu) {
    compare(gpu, "fence", &fence(), [64, 48]);
}

fn masks_of_all_depths(gpu: &Gpu) {
    SILHOUETTES.compare_all_depths(gpu);
}

fn at_all_scales(gpu: &Gpu) {
    SILHOUETTES.compare_all_scales(gpu);
}

/// Coarse facets under smooth normals: facets cut the light of many points that lie slightly in front of their own triangles.
fn at_terminators(gpu: &Gpu) {
    let mut scene = large_floor(80.0);
    scene.objects.push(Object::mesh("globe", globe(14, Vec3::Y * 0.3, 0.5, true), 0, Proxy::None));
    scene.lights[0].as_sphere_mut().expect("a sphere").sphere.radius = 1.2;
    scene.camera.projection = scene::Projection::perspective(0.4);
    compare(gpu, "terminators", &scene, [64, 48]);
}

/// Many objects under one light: a hierarchy over objects, and more silhouettes than a workgroup holds.
fn more_than_are_kept(gpu: &Gpu) {
    let mut scene = fence();
    scene.objects.truncate(1);
    for k in 0..90_usize {
        let (x, z) = (k % 10, k / 10);
        let center = Vec3::new(0.1 * x as f32 - 0.45, 0.5 + 0.003 * k as f32, 0.1 * z as f32 - 0.4);
        let mut mesh = Mesh::cuboid(center, Vec3::new(0.03, 0.02, 0.03));
        mesh.append(&globe(6, center + Vec3::Y * 0.06, 0.03, false));
        scene.objects.push(Object::mesh(format!("crumb {k}"), mesh, 0, Proxy::None));
    }
    scene.lights[0].as_sphere_mut().expect("a sphere").sphere.radius = 1.5;
    compare(gpu, "crumbs", &scene, [40, 30]);
}

/// A scene that moves: a refitted hierarchy gives the same picture as a new one.
fn follow_motion(gpu: &Gpu) {
    let mut scene = fence();
    let points = GBuffer::new(&World::new(&scene), 40, 30, 1).points;
    let mut world = GpuWorld::new(gpu, &scene).expect("geometry");
    let mut meshes = SceneSilhouettes::new(&scene, |_| true);
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("a shader");
    let mut shade = |world: &GpuWorld, meshes: &SceneSilhouettes, scene: &Scene| {
        let blockers = GpuSilhouettes::new(meshes.meshes());
        let occlusion = Occlusion { blockers: &[&blockers], any_hit: Some(world) };
        shader.occlude(occlusion).expect("a shader");
        let mut out = vec![Vec3::NAN; points.receivers.len()];
        shader.shade(&points, &frame(scene, 0.003, 5), &mut out).expect("the GPU shades");
        out
    };
    let before = shade(&world, &meshes, &scene);
    let Shape::Mesh(mesh) = &mut scene.objects[1].shape else { unreachable!("a mesh") };
    mesh.transform(&Mat4::from_translation(Vec3::new(0.03, 0.0, -0.1)));
    world.update(&scene).expect("geometry");
    meshes.refit(&scene);
    let moved = shade(&world, &meshes, &scene);
    assert!(before != moved && moved == from_gpu(gpu, &scene, &points, &frame(&scene, 0.003, 5)).0);
}

/// Glossy lobes, two lights; some objects by spheres, others by silhouettes: as the CPU's mixture of both.
fn beside_spheres(gpu: &Gpu) {
    let scene = plain();
    let by_silhouettes = |object: u32| is_mesh(&scene, object) && object.is_multiple_of(2);
    let world = World::new(&scene);
    let points = GBuffer::new(&world, 64, 36, 1).points;
    let shapes = [
        Sphere { center: Vec3::new(0.4, 0.5, 0.6), radius: 0.3 },
        Sphere { center: Vec3::new(-0.6, 0.8, 0.2), radius: 0.2 },
    ];
    let spheres = SphereBlockers::new(&shapes, &[99, 99], &[0.0, 0.0]);
    let frame = frame(&scene, 0.003, 5);
    let silhouettes = SceneSilhouettes::new(&scene, by_silhouettes);
    let hits = SurfaceHits::new(&world, by_silhouettes);
    let mixture = Mixture::new(spheres.clone(), SilhouetteBlockers::new(silhouettes.meshes(), hits));
    let mut want = vec![Vec3::ZERO; points.receivers.len()];
    let counts = CpuShader::new(MaskVisibility::new(mixture).look_again(LookAgain::Never))
        .shade(&points, &frame, &mut want)
        .expect("room for all lobes")
        .counts;
    let ours = GpuWorld::only(gpu, &scene, by_silhouettes).expect("geometry");
    let blockers = GpuSilhouettes::new(silhouettes.meshes());
    let own: &[&dyn GpuBlockers] = &[&spheres, &blockers];
    let occlusion = Occlusion { blockers: own, any_hit: Some(&ours) };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
    let mut got = vec![Vec3::NAN; points.receivers.len()];
    let found = shader.shade(&points, &frame, &mut got).expect("the GPU shades").counts;
    let whole = unshadowed(&points, &frame);
    check_alike("beside spheres", (want, counts), (got, found), &whole);
}

fn by_the_papers_method(gpu: &Gpu) {
    let tables = Tables::with_products(ProductTable::build_with(Resolution { angles: 33, per_interval: 4 }));
    let scene = fence();
    let world = World::new(&scene);
    let points = GBuffer::new(&world, 40, 30, 1).points;
    let frame = frame(&scene, 0.003, 4);
    let silhouettes = SceneSilhouettes::new(&scene, |_| true);
    let hits = SurfaceHits::new(&world, |_| true);
    let visibility = PaperVisibility::new(SilhouetteBlockers::new(silhouettes.meshes(), hits), &tables);
    let mut want = vec![Vec3::ZERO; points.receivers.len()];
    let mut cpu = CpuShader::with_integrator(visibility, PaperIntegrator { tables: &tables });
    cpu.shade(&points, &frame, &mut want).expect("room for all lobes");
    let ours = GpuWorld::new(gpu, &scene).expect("geometry");
    let blockers = GpuSilhouettes::new(silhouettes.meshes());
    let occlusion = Occlusion { blockers: &[&blockers], any_hit: Some(&ours) };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader").with_paper(&tables);
    let mut got = vec![Vec3::NAN; points.receivers.len()];
    shader.shade(&points, &frame, &mut got).expect("the GPU shades");
    check_picture(&want, &got, 1e-3);
}

fn twice_the_same_bits(gpu: &Gpu) {
    let scene = fence();
    let points = GBuffer::new(&World::new(&scene), 40, 30, 1).points;
    let frame = frame(&scene, 0.003, 5);
    assert_eq!(from_gpu(gpu, &scene, &points, &frame), from_gpu(gpu, &scene, &points, &frame));
}

/// Without a scene for its rays, or with the strategy twice, the shader returns an error.
fn want_any_hit(gpu: &Gpu) {
    let scene = fence();
    let world = GpuWorld::new(gpu, &scene).expect("geometry");
    let blockers = GpuSilhouettes::new(SceneSilhouettes::new(&scene, |_| true).meshes());
    let own: &[&dyn GpuBlockers] = &[&blockers];
    let twice = Occlusion { blockers: &[&blockers, &blockers], any_hit: Some(&world) };
    for (occlusion, word) in [(Occlusion::of(own), "any_hit"), (twice, "twice")] {
        let error = GpuShader::new(gpu, occlusion).map(|_| ());
        assert!(matches!(&error, Err(GpuError::Unsupported(why)) if why.contains(word)), "{error:?}");
    }
}
