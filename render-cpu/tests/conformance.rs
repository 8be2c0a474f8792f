//! The suite that all visibility strategies keep, for shadow rays.

use brdf::Material;
use glam::Vec3;
use lighting::{MaskVisibility, Mixture};
use lobe_core::Sphere;
use lobe_core::conformance::{Limits, Setting, Subject, Visitor, check};
use render_cpu::{RayBlockers, World};
use scene::{Camera, Object, Scene};
use visibility_spheres::SphereBlockers;

fn scene(balls: &[Sphere]) -> Scene {
    Scene {
        camera: Camera { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, vertical_fov: 0.6 },
        width: 1,
        height: 1,
        background: Vec3::ZERO,
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: balls.iter().map(|ball| Object::spheres("ball", vec![*ball], 0)).collect(),
        lights: Vec::new(),
    }
}

/// Rays that meet the balls themselves.
struct Rays;

impl Subject for Rays {
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer {
        let scene = scene(setting.balls);
        let world = World::new(&scene);
        visitor.visit(&MaskVisibility::new(RayBlockers::new(&world), 5))
    }
}

/// The first ball by rays, the others as spheres; the world has them all.
struct Mixed;

impl Subject for Mixed {
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer {
        let others = setting.balls.get(1..).unwrap_or_default();
        let scene = scene(setting.balls);
        let world = World::new(&scene);
        let spheres = SphereBlockers::new(others, &vec![0; others.len()], &[]);
        visitor
            .visit(&MaskVisibility::new(Mixture::new(RayBlockers::new(&world).only(|object| object == 0), spheres), 5))
    }
}

#[test]
fn rays() {
    let measured =
        check(&Rays, &Limits { several_mean: 0.001, several: 0.01, turn: 0.005, jump: 0.0035, ..Limits::default() })
            .unwrap_or_else(|e| panic!("{e}"));
    println!("{measured:?}");
}

#[test]
fn mixture_of_rays_and_spheres() {
    let measured =
        check(&Mixed, &Limits { brighter: 0.005, order: 0.005, turn: 0.005, jump: 0.0035, ..Limits::default() })
            .unwrap_or_else(|e| panic!("{e}"));
    println!("{measured:?}");
}
