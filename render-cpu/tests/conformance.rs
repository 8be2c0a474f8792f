//! The suite that all visibility strategies keep, for shadow rays.

use brdf::Material;
use conformance::{Limits, Setting, Subject, Visitor, check};
use glam::Vec3;
use lobe_core::Sphere;
use render_cpu::{SceneSilhouettes, SurfaceHits, World};
use scene::{Camera, Mesh, Object, Projection, Scene, Shape};
use test_scenes::globe;
use visibility_mask::{MaskVisibility, Mixture};
use visibility_rays::RayBlockers;
use visibility_silhouettes::SilhouetteBlockers;
use visibility_spheres::SphereBlockers;

fn scene(spheres: &[Sphere]) -> Scene {
    Scene {
        camera: Camera { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, projection: Projection::perspective(0.6) },
        width: 1,
        height: 1,
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: spheres.iter().map(|sphere| Object::spheres("sphere", vec![*sphere], 0)).collect(),
        lights: Vec::new(),
        ..Scene::default()
    }
}

/// Rays that meet the spheres themselves.
struct Rays;

impl Subject for Rays {
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer {
        let scene = scene(setting.spheres);
        let world = World::new(&scene);
        visitor.visit(&MaskVisibility::new(RayBlockers::new(&world)))
    }
}

/// The first sphere by rays, the others as spheres; the world has them all.
struct Mixed;

impl Subject for Mixed {
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer {
        let others = setting.spheres.get(1..).unwrap_or_default();
        let scene = scene(setting.spheres);
        let world = World::new(&scene);
        let spheres = SphereBlockers::new(others, &vec![0; others.len()], &[]);
        visitor.visit(&MaskVisibility::new(Mixture::new(RayBlockers::new(&world).only(|object| object == 0), spheres)))
    }
}

/// A sphere of triangles whose outline has the sphere's area.
fn sphere(of: &Sphere, rings: u32) -> Mesh {
    globe(rings, of.center, of.radius * (1.0 + (core::f32::consts::PI / rings as f32).powi(2) / 12.0), false)
}

/// Spheres of triangles by their silhouettes.
struct Silhouettes;

impl Subject for Silhouettes {
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer {
        let mut scene = scene(setting.spheres);
        let rings = if setting.spheres.len() > 8 { 16 } else { 40 };
        for (object, of) in scene.objects.iter_mut().zip(setting.spheres) {
            object.shape = Shape::Mesh(sphere(of, rings));
        }
        let world = World::new(&scene);
        let kept = SceneSilhouettes::new(&scene, |_| true);
        let blockers = SilhouetteBlockers::new(kept.meshes(), SurfaceHits::new(&world, |_| true));
        visitor.visit(&MaskVisibility::new(blockers))
    }
}

#[test]
fn silhouettes() {
    // Lights are smaller than the triangles of a sphere, so it is none to them; each case builds its meshes.
    let limits = Limits {
        overlap_mean: 0.1,
        overlap: 1.0,
        several_mean: 0.001,
        brighter: 0.005,
        turn: 0.005,
        jump: 0.01,
        jump_several: 0.006,
        cases: 12,
        ..Limits::default()
    };
    let measured = check(&Silhouettes, &limits).unwrap_or_else(|e| panic!("{e}"));
    println!("{measured:?}");
}

#[test]
fn rays() {
    let limits = Limits { several_mean: 0.001, several: 0.01, turn: 0.005, jump: 0.0035, ..Limits::default() };
    let measured = check(&Rays, &limits).unwrap_or_else(|e| panic!("{e}"));
    println!("{measured:?}");
}

#[test]
fn mixture_of_rays_and_spheres() {
    let measured =
        check(&Mixed, &Limits { brighter: 0.005, order: 0.005, turn: 0.005, jump: 0.0035, ..Limits::default() })
            .unwrap_or_else(|e| panic!("{e}"));
    println!("{measured:?}");
}
