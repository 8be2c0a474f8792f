//! An environment that a GPU sums at once, against `SkyShader` with one table.

use crate::call::trial;
use crate::rays::fence;
use brdf::{Material, MetallicRoughness, ModifiedPhong};
use glam::{UVec2, Vec3};
use libtest_mimic::Trial;
use lighting::{Environment, Light};
use lobe_core::Sphere;
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SkyShader, SurfaceHits, World};
use render_gpu::{Gpu, GpuShader, GpuSky, GpuWorld, Occlusion};
use scene::{Frame, Mesh, Object, Proxy, Scene, Shade, ShadingPoints};
use shading::gpu::GpuBlockers;
use shading::{Accuracy, LightLobes as _};
use test_scenes::{below_leaves, environment_map, globe};
use visibility_mask::MaskVisibility;
use visibility_mask::sky::{SkyResolution, SkyTable};
use visibility_silhouettes::{GpuSilhouettes, SilhouetteBlockers};
use visibility_spheres::SphereBlockers;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("skies_at_once", gpu, skies_at_once),
        trial("skies_before_spheres", gpu, before_spheres),
        trial("skies_behind_leaves", gpu, behind_leaves),
    ]
}

/// A smooth sky with a glow and a hard window, and a sphere around the scene.
fn environment() -> Environment {
    let radiance = |v: Vec3| {
        let is_window = v.x > 0.3 && v.x < 0.6 && v.y > 0.5 && v.z < 0.0;
        let glow = v.dot(Vec3::new(-0.6, 0.7, 0.4).normalize()).max(0.0).powi(12);
        let above = Vec3::new(3.0, 2.6, 2.0) * glow + Vec3::splat(if is_window { 9.0 } else { 0.0 });
        Vec3::new(0.4, 0.5, 0.6) + if v.y > 0.0 { above + Vec3::splat(0.3 * v.y) } else { Vec3::ZERO }
    };
    let map = environment_map(UVec2::new(64, 32), radiance);
    Environment::new(map, 1, Sphere { center: Vec3::ZERO, radius: 10.0 })
}

/// The fence, a smooth globe, an open bowl, and a leaf whose one edge lies straight above points of the floor; each on other materials.
fn garden() -> Scene {
    let mut scene = fence();
    let mut bowl = globe(8, Vec3::new(0.9, 0.5, 0.6), 0.3, false);
    bowl.triangles.retain(|corners| corners.iter().all(|k| bowl.positions[*k as usize].y < 0.6));
    scene.objects.push(Object::mesh("globe", globe(10, Vec3::new(-0.6, 0.35, 0.7), 0.3, true), 1, Proxy::None));
    scene.objects.push(Object::mesh("bowl", bowl, 2, Proxy::None));
    let leaf = Mesh::quad(Vec3::new(0.0, 1.2, 0.5), Vec3::new(0.4, 0.0, 0.0), Vec3::new(0.0, 0.3, -0.4));
    scene.objects.push(Object::mesh("leaf", leaf, 3, Proxy::None));
    scene.materials = vec![
        Material::lambert(Vec3::splat(0.5)),
        // A CPU sums exponents from 11 on over finer tables.
        ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.5), exponent: 10.0 }.into(),
        // Wide enough for the first table from all views; a CPU also sums the streaks of others.
        MetallicRoughness::new(Vec3::new(0.9, 0.7, 0.5), 1.0, 0.8).expect("a metal").into(),
        // One lobe is left to the patches.
        ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.5), exponent: 2000.0 }.into(),
    ];
    scene
}

/// The most that a CPU and a GPU differ by that count surfaces alike, in the mean and at all.
const SAME: [f32; 2] = [3e-6, 1e-3];

/// The mean and the largest difference, relative to the largest value; values are numbers.
fn differences(want: &[Vec3], got: &[Vec3]) -> [f32; 2] {
    let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let all = want.iter().zip(got).map(|(want, got)| {
        assert!(got.is_finite(), "{got}");
        (*want - *got).abs().max_element() / peak
    });
    let all: Vec<f32> = all.collect();
    [all.iter().sum::<f32>() / all.len() as f32, all.iter().copied().fold(0.0, f32::max)]
}

fn table(environment: &Environment, resolution: SkyResolution) -> SkyTable {
    let map = environment.sky();
    SkyTable::new(resolution, map.size().x, |v| map.radiance(v))
}

struct Case<'a> {
    points: &'a ShadingPoints,
    frame: &'a Frame<'a>,
    table: &'a SkyTable,
    replaced: Vec<bool>,
}

impl Case<'_> {
    fn on_gpu(&self, shader: &mut GpuShader) -> Vec<Vec3> {
        let mut out = vec![Vec3::NAN; self.points.receivers.len()];
        let stats = shader.shade(self.points, self.frame, &mut out).expect("the GPU shades");
        assert!(stats.counts.lit_points + stats.counts.penumbra_points > 0);
        out
    }

    /// Compares a shader that sums the sky at once with a CPU: the mean and the largest difference.
    fn compare(&self, gpu: &Gpu, want: &[Vec3], shader: &mut GpuShader, [most_mean, most]: [f32; 2]) {
        let packed = GpuSky::new(self.table);
        shader.set_sky(Some((&packed, self.replaced.clone())));
        let got = self.on_gpu(shader);
        let is_sky = |kernel: &render_gpu::CompiledKernel| kernel.name.starts_with("sky (");
        assert!(gpu.kernels().compiled().iter().any(is_sky), "summed by patches");
        let [mean, largest] = differences(want, &got);
        let resolution = self.table.meridians().resolution();
        println!("{resolution:?}: {mean:e} {largest:e}");
        assert!(mean < most_mean && largest < most, "{resolution:?}: {mean:e} {largest:e}");
        assert!(self.on_gpu(shader) == got, "two runs give the same bits");
    }
}

fn skies_at_once(gpu: &Gpu) {
    let scene = garden();
    let environment = environment();
    let lights: Vec<Light> = environment.lights().to_vec();
    let replaced = environment.patches_among(&lights).expect("its patches");
    // Some have one radiance, others an image: their kernels differ.
    let images = lights.iter().filter(|light| light.image().is_some()).count();
    assert!(images > 0 && images < lights.len() && replaced.iter().all(|replaced| *replaced));
    let world = World::new(&scene);
    let points = GBuffer::new(&world, 40, 30, 1).points;
    let frame: Frame<'_> = Frame::new(&scene.materials, &lights, Accuracy::new(0.005));
    let blocks = |object: u32| object > 0;
    let silhouettes = SceneSilhouettes::new(&scene, blocks);
    let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, blocks));
    let rays = GpuWorld::only(gpu, &scene, blocks).expect("geometry");
    let ours = GpuSilhouettes::new(silhouettes.meshes());
    let own: &[&dyn GpuBlockers] = &[&ours];
    let occlusion = Occlusion { blockers: own, any_hit: Some(&rays) };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
    for (rows, samples) in [(64, 64), (256, 128)] {
        let table = table(&environment, SkyResolution::new(rows, samples));
        let mut want = vec![Vec3::ZERO; points.receivers.len()];
        CpuShader::new(MaskVisibility::new(&blockers))
            .with_sky(SkyShader::new([&table], replaced.clone(), &blockers))
            .shade(&points, &frame, &mut want)
            .expect("shaded");
        let case = Case { points: &points, frame: &frame, table: &table, replaced: replaced.clone() };
        case.compare(gpu, &want, &mut shader, SAME);
    }
}

fn before_spheres(gpu: &Gpu) {
    let mut scene = garden();
    // Few kernels to compile.
    scene.materials.fill(Material::lambert(Vec3::splat(0.5)));
    let environment = environment();
    scene.lights = environment.lights().to_vec();
    let replaced = environment.patches_among(&scene.lights).expect("its patches");
    let points = GBuffer::new(&World::new(&scene), 40, 30, 1).points;
    let frame: Frame<'_> = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.005));
    // Around points, beside them, in other spheres, and of the receiver's own object.
    let shapes = [
        Sphere { center: Vec3::new(-0.6, 0.35, 0.7), radius: 0.29 },
        Sphere { center: Vec3::new(0.4, 0.5, 0.6), radius: 0.3 },
        Sphere { center: Vec3::new(0.6, 0.8, 0.2), radius: 0.3 },
        Sphere { center: Vec3::new(0.0, -0.2, -0.4), radius: 0.5 },
    ];
    let few = SphereBlockers::new(&shapes, &[2, 9, 9, 9], &[0.05, 0.0, 0.0, 0.0]);
    // Outlines cross half circles more often than a workgroup lists.
    let crumb = |k: u32| {
        let [x, y, z] = [k % 30, k % 7, k / 30].map(|i| i as f32);
        Sphere { center: Vec3::new(0.15 * x - 2.2, 0.5 + 0.05 * y, 0.15 * z - 2.2), radius: 0.05 }
    };
    let crumbs: Vec<Sphere> = (0..900).map(crumb).collect();
    let many = SphereBlockers::new(&crumbs, &[9; 900], &[0.0; 900]);
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("a shader");
    // The last ones are a crowd, whose samples are divided.
    for (spheres, rows, samples) in [(&few, 32, 64), (&few, 64, 64), (&few, 128, 64), (&many, 64, 64)] {
        let table = table(&environment, SkyResolution::new(rows, samples));
        let mut want = vec![Vec3::ZERO; points.receivers.len()];
        CpuShader::new(MaskVisibility::new(spheres))
            .with_sky(SkyShader::new([&table], replaced.clone(), spheres))
            .shade(&points, &frame, &mut want)
            .expect("shaded");
        let own: &[&dyn GpuBlockers] = &[spheres];
        shader.occlude(Occlusion::of(own)).expect("a shader");
        let case = Case { points: &points, frame: &frame, table: &table, replaced: replaced.clone() };
        case.compare(gpu, &want, &mut shader, SAME);
    }
}

/// The same behind leaves: a CPU puts the crossings of a row in order, a GPU keeps the largest parts of quarters of samples that are certainly open.
const LEAVES: [f32; 2] = [2.5e-3, 1.2e-2];

/// Foliage: several leaves lie in one sample. Of the last ones fewer rows than usual are listed at a time.
fn behind_leaves(gpu: &Gpu) {
    let environment = environment();
    let lights: Vec<Light> = environment.lights().to_vec();
    let replaced = environment.patches_among(&lights).expect("its patches");
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("a shader");
    for (count, size, rows, samples) in [(1500, 0.12, 64, 64), (4000, 0.06, 128, 64), (1000, 0.3, 64, 64)] {
        let mut scene = below_leaves(count, size, lights.clone());
        (scene.width, scene.height) = (18, 12);
        let world = World::new(&scene);
        let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
        let frame: Frame<'_> = Frame::new(&scene.materials, &lights, Accuracy::new(0.005));
        let silhouettes = SceneSilhouettes::new(&scene, |_| true);
        let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |_| true));
        let rays = GpuWorld::only(gpu, &scene, |_| true).expect("geometry");
        let ours = GpuSilhouettes::new(silhouettes.meshes());
        let own: &[&dyn GpuBlockers] = &[&ours];
        shader.occlude(Occlusion { blockers: own, any_hit: Some(&rays) }).expect("a shader");
        let table = table(&environment, SkyResolution::new(rows, samples));
        let mut want = vec![Vec3::ZERO; points.receivers.len()];
        CpuShader::new(MaskVisibility::new(&blockers))
            .with_sky(SkyShader::new([&table], replaced.clone(), &blockers))
            .shade(&points, &frame, &mut want)
            .expect("shaded");
        let case = Case { points: &points, frame: &frame, table: &table, replaced: replaced.clone() };
        case.compare(gpu, &want, &mut shader, LEAVES);
    }
}
