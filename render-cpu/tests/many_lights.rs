//! Many lights: what faint ones and interpolated visible fractions change, and what they leave alone.

use brdf::{Material, Phong};
use core::sync::atomic::{AtomicUsize, Ordering};
use glam::Vec3;
use lighting::{Light, SphereLight};
use lobe_core::{Lobe, Receiver, Sphere};
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, ShadeRequest, SurfaceHits, World};
use scene::{Camera, Frame, GROUP, Mesh, Object, Projection, Proxy, Scene, ShadingPoints};
use shading::{Accuracy, Coverage, Shaft, Visibility, VisibilityQuery};
use visibility_mask::MaskVisibility;
use visibility_silhouettes::SilhouetteBlockers;
use visibility_spheres::SphereBlockers;

const TOLERANCE: f32 = 0.005;
const SIZE: [u32; 2] = [128, 96];

/// A floor under wires of a tenth of the distance of two pixels, from the floor up to a third of the lights' height, and under two crates, one of
/// which stands on the floor.
fn scene(material: Material) -> Scene {
    let mut mesh = Mesh::cuboid(Vec3::new(-1.2, 0.15, 0.4), Vec3::new(0.4, 0.3, 0.4));
    mesh.append(&Mesh::cuboid(Vec3::new(1.2, 0.9, -0.6), Vec3::new(0.7, 0.2, 0.5)));
    for k in 0..9 {
        let at = Vec3::new(0.3 * k as f32 - 1.5, 0.004 + 0.02 * (k * k) as f32, 0.1 * k as f32 - 0.4);
        mesh.append(&Mesh::cuboid(at, Vec3::new(0.004, 0.004, 1.6)));
    }
    let object = |name: &str, mesh: Mesh| Object::mesh(name, mesh, 0, Proxy::None);
    let mut scene = Scene {
        camera: Camera {
            eye: Vec3::new(0.0, 3.5, 2.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::perspective(0.8),
        },
        materials: vec![material],
        objects: vec![object("floor", Mesh::quad(Vec3::ZERO, Vec3::X * 9.0, Vec3::NEG_Z * 9.0)), object("wires", mesh)],
        ..Scene::default()
    };
    [scene.width, scene.height] = SIZE;
    scene
}

/// Lights on a spiral; the strength of each is `fall` times that of the one before.
fn lights(count: usize, fall: f32) -> Vec<Light> {
    let light = |k: usize| {
        let (sin, cos) = (2.4 * k as f32).sin_cos();
        let aside = 2.5 * ((k as f32 + 0.5) / count as f32).sqrt();
        let center = Vec3::new(aside * cos, 3.2 + 0.3 * (k % 3) as f32, aside * sin);
        SphereLight::new(Sphere { center, radius: 0.35 }, Vec3::new(4.0, 3.5, 3.0) * fall.powi(k as i32)).into()
    };
    (0..count).map(light).collect()
}

fn points(world: &World<'_>) -> ShadingPoints {
    let mut g = GBuffer::new(world, SIZE[0], SIZE[1], 1);
    g.find_squares();
    g.points
}

fn shade(shader: &CpuShader<impl Visibility>, points: &ShadingPoints, scene: &Scene, lights: &[Light]) -> Vec<Vec3> {
    let frame = Frame::new(&scene.materials, lights, Accuracy::new(TOLERANCE));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let _ = shader.shade_with(points, &frame, &mut out, &ShadeRequest::default());
    out
}

/// Few lights at once, all of which are queried.
fn few_at_once(
    shader: &CpuShader<impl Visibility>,
    points: &ShadingPoints,
    scene: &Scene,
    lights: &[Light],
) -> Vec<Vec3> {
    let mut sum = vec![Vec3::ZERO; points.receivers.len()];
    for lights in lights.chunks(7) {
        let part = shade(shader, points, scene, lights);
        sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
    }
    sum
}

fn same(a: &[Vec3], b: &[Vec3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.to_array().map(f32::to_bits) == b.to_array().map(f32::to_bits))
}

/// A strategy that counts the receivers that ask, and says what it likes of penumbrae.
struct Watched<'c, V> {
    visibility: V,
    asked: &'c AtomicUsize,
    /// Instead of the strategy's own answer.
    width: Option<f32>,
}

impl<V: Visibility> Visibility for Watched<'_, V> {
    type Scratch = V::Scratch;
    fn scratch(&self) -> V::Scratch {
        self.visibility.scratch()
    }
    fn enter(&self, shaft: &Shaft, scratch: &mut V::Scratch) -> Coverage {
        self.visibility.enter(shaft, scratch)
    }
    fn narrowest_penumbra(&self, at: &Receiver, part: Sphere, scratch: &mut V::Scratch) -> f32 {
        self.width.unwrap_or_else(|| self.visibility.narrowest_penumbra(at, part, scratch))
    }
    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut V::Scratch) -> Coverage {
        self.asked.fetch_add(1, Ordering::Relaxed);
        self.visibility.coverage(query, scratch)
    }
    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut V::Scratch) -> Vec3 {
        self.visibility.fraction(query, brdf, unshadowed, scratch)
    }
}

/// The silhouettes of a scene, kept by the caller.
fn silhouettes<'a>(world: &'a World<'a>, meshes: &'a SceneSilhouettes) -> MaskVisibility<SilhouetteBlockers<'a>> {
    MaskVisibility::new(SilhouetteBlockers::new(meshes.meshes(), SurfaceHits::new(world, |_| true)))
}

/// Faint lights cost no query, and no point more than half the tolerance of its own radiance. Each point decides for itself.
#[test]
fn faint_lights_stay_in_their_budget() {
    let scene = scene(Material::lambert(Vec3::splat(0.5)));
    let (world, meshes) = (World::new(&scene), SceneSilhouettes::new(&scene, |_| true));
    let (points, lights) = (points(&world), lights(40, 0.7));
    let [asked, asked_all] = [AtomicUsize::new(0), AtomicUsize::new(0)];
    let watched = |asked| Watched { visibility: silhouettes(&world, &meshes), asked, width: None };
    let (shader, shader_all) = (CpuShader::new(watched(&asked)), CpuShader::new(watched(&asked_all)));
    let out = shade(&shader, &points, &scene, &lights);
    let all = few_at_once(&shader_all, &points, &scene, &lights);
    let [count, count_all] = [&asked, &asked_all].map(|count| count.load(Ordering::Relaxed));
    assert!(count * 3 < count_all * 2, "{count} of {count_all} queries");
    for (i, (out, all)) in out.iter().zip(&all).enumerate() {
        let error = (*out - *all).max_element().abs();
        assert!(error <= 0.5 * TOLERANCE * 1.001 * all.max_element() + 1e-6, "point {i}: {out} for {all}");
    }
    assert!(!same(&out, &all), "no light was faint");
    // Other groups.
    let few = 7 * GROUP..9 * GROUP + 5;
    let part = ShadingPoints {
        receivers: points.receivers[few.clone()].to_vec(),
        materials: points.materials[few.clone()].to_vec(),
        ends: vec![3, 60, 61],
        ..ShadingPoints::default()
    };
    let part = shade(&CpuShader::new(watched(&asked)), &part, &scene, &lights);
    assert!(same(&part, &out[few]), "a point depends on its group");
}

/// The layers of faint lights: each light's radiance, and the radiance without blockers.
#[test]
fn layers_have_faint_lights() {
    let scene = scene(Material::lambert(Vec3::splat(0.5)));
    let (world, meshes) = (World::new(&scene), SceneSilhouettes::new(&scene, |_| true));
    let (points, lights) = (points(&world), lights(24, 0.5));
    let frame = Frame::new(&scene.materials, &lights, Accuracy::new(TOLERANCE));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let (stats, layers) = CpuShader::new(silhouettes(&world, &meshes)).shade_layers(&points, &frame, &mut out);
    // One lobe, one integral a light, each counted once.
    assert_eq!(stats.counts.integrals, (24 * out.len()) as u64);
    assert!(layers.integrals.iter().all(|n| *n == 24), "{:?}", layers.integrals.iter().max());
    let clear = shade(&CpuShader::new(shading::Unshadowed), &points, &scene, &lights);
    for (i, out) in out.iter().enumerate() {
        let sum: Vec3 = layers.lights[i * lights.len()..][..lights.len()].iter().sum();
        assert!(sum.abs_diff_eq(*out, 1e-5 * out.max_element()), "point {i}: {sum} for {out}");
        assert!(layers.unshadowed[i].abs_diff_eq(clear[i], 1e-5 * clear[i].max_element()), "point {i}");
    }
}

/// Interpolation saves queries, and no pixel errs by more than the tolerance allows: not below contacts, nor below wires that
/// are thinner than the distance of two pixels. A strategy that promises wide penumbrae where there are none errs by many times that.
#[test]
fn no_shadow_hides_between_receivers() {
    let scene = scene(Material::lambert(Vec3::splat(0.5)));
    let (world, meshes) = (World::new(&scene), SceneSilhouettes::new(&scene, |_| true));
    let (points, lights) = (points(&world), lights(16, 1.0));
    let clear = shade(&CpuShader::new(shading::Unshadowed), &points, &scene, &lights);
    let run = |is_interpolated, width| {
        let asked = AtomicUsize::new(0);
        let watched = Watched { visibility: silhouettes(&world, &meshes), asked: &asked, width };
        let out = shade(&CpuShader::new(watched).interpolating(is_interpolated), &points, &scene, &lights);
        (out, asked.into_inner())
    };
    let (each, asked_each) = run(false, None);
    let (out, asked) = run(true, None);
    let largest = |out: &[Vec3]| {
        let error = |((a, b), clear): ((&Vec3, &Vec3), &Vec3)| (*a - *b).abs().max_element() / clear.max_element();
        out.iter().zip(&each).zip(&clear).filter(|(_, clear)| clear.max_element() > 0.0).map(error).fold(0.0, f32::max)
    };
    let (careless, _) = run(true, Some(1e9));
    let [guarded, careless] = [largest(&out), largest(&careless)];
    println!("{asked} of {asked_each} queries; errors of {guarded} and {careless} without a guard");
    assert!(asked * 3 < asked_each * 2, "{asked} of {asked_each} queries");
    assert!(guarded <= TOLERANCE, "{guarded}");
    assert!(careless > 5.0 * TOLERANCE, "{careless}: this scene would not show a missing guard");
}

/// Strategies that do not know their penumbrae, glossy lobes, few lights and points in no squares: the same bits.
#[test]
fn interpolation_stays_off() {
    let glossy = Phong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.4), exponent: 900.0 };
    for (material, count) in
        [(Material::lambert(Vec3::splat(0.5)), 4), (glossy.into(), 12), (Material::lambert(Vec3::splat(0.5)), 12)]
    {
        let is_diffuse = count == 12 && matches!(material, Material::Lambert(_));
        let scene = scene(material);
        let (world, meshes) = (World::new(&scene), SceneSilhouettes::new(&scene, |_| true));
        let (mut points, lights) = (points(&world), lights(count, 1.0));
        if is_diffuse {
            points.squares.clear();
        }
        let shader = CpuShader::new(silhouettes(&world, &meshes));
        let each = shade(&shader, &points, &scene, &lights);
        let out = shade(&shader.interpolating(true), &points, &scene, &lights);
        assert!(same(&each, &out), "{count} lights");
    }
    let scene = scene(Material::lambert(Vec3::splat(0.5)));
    let world = World::new(&scene);
    let (points, lights) = (points(&world), lights(12, 1.0));
    let spheres = [Sphere { center: Vec3::Y, radius: 0.4 }];
    let shader = CpuShader::new(MaskVisibility::new(SphereBlockers::new(&spheres, &[7], &[0.0])));
    let each = shade(&shader, &points, &scene, &lights);
    assert!(same(&each, &shade(&shader.interpolating(true), &points, &scene, &lights)), "spheres");
}

/// Squares are whole tiles of pixels; bands that end at tiles have the bits of the whole picture.
#[test]
fn bands_of_tiles_agree() {
    let scene = scene(Material::lambert(Vec3::splat(0.5)));
    let (world, meshes) = (World::new(&scene), SceneSilhouettes::new(&scene, |_| true));
    let (all, lights) = (points(&world), lights(16, 1.0));
    assert!(all.squares.len() > 100 && all.squares.is_sorted(), "{} squares", all.squares.len());
    let shader = CpuShader::new(silhouettes(&world, &meshes)).interpolating(true);
    let whole = shade(&shader, &all, &scene, &lights);
    let mut bands = Vec::new();
    for rows in [0..40, 40..48, 48..96] {
        let mut g = GBuffer::rows(&world, SIZE[0], SIZE[1], 1, rows);
        g.find_squares();
        bands.extend(shade(&shader, &g.points, &scene, &lights));
    }
    assert!(same(&whole, &bands));
    // A tile that a window cuts is no square.
    let mut cut = GBuffer::window(&world, SIZE[0], SIZE[1], 1, 8..19, 16..24);
    cut.find_squares();
    assert_eq!(cut.points.squares, [0]);
    let mut fine = GBuffer::new(&world, SIZE[0], SIZE[1], 2);
    fine.find_squares();
    assert_eq!(fine.points.squares, [0; 0]);
}
