//! Everything blocks light unless it says that it does not, and floors that nothing is behind are left out without a change.

#![expect(clippy::unwrap_used, reason = "a test")]

use glam::Vec3;
use lighting::{EnclosedLight, Light, SphereLight};
use lobe_core::Sphere;
use renderer::{Plan, Renderer, Settings};
use scene::{Animation, Camera, Mesh, Object, Projection, Proxy, Scene, Strategy};

const SIZE: u32 = 24;

fn lamp(y: f32) -> Light {
    SphereLight::new(Sphere { center: Vec3::new(0.0, y, 0.0), radius: 0.1 }, Vec3::splat(30.0)).into()
}

/// Seen from above: a floor, and something 1 above it that is not seen or is above the eye.
fn scene(blocker: Object) -> Scene {
    let mut scene = scene::builtin();
    let eye = Vec3::new(0.0, 0.8, 0.0);
    scene.camera = Camera { eye, target: Vec3::ZERO, up: Vec3::NEG_Z, projection: Projection::perspective(0.9) };
    (scene.width, scene.height) = (SIZE, SIZE);
    scene.lights = vec![lamp(6.0)];
    scene.environment = None;
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 10.0, Vec3::NEG_Z * 10.0);
    scene.objects = vec![Object::mesh("floor", floor, 0, Proxy::None), blocker];
    scene
}

fn table() -> Object {
    Object::mesh("table", Mesh::quad(Vec3::Y, Vec3::X * 0.5, Vec3::NEG_Z * 0.5), 0, Proxy::None)
}

fn picture(scene: &Scene, strategy: Option<Strategy>) -> Vec<Vec3> {
    let settings = Settings { strategy, ..Settings::default() };
    Renderer::new(scene.clone(), Animation::default(), settings).unwrap().render().unwrap().radiance
}

fn middle(scene: &Scene, strategy: Option<Strategy>) -> f32 {
    picture(scene, strategy)[(SIZE * SIZE / 2 + SIZE / 2) as usize].max_element()
}

#[test]
fn quads_block_seen_or_not_by_every_strategy() {
    let box_ = Object::mesh("box", Mesh::cuboid(Vec3::Y, Vec3::new(1.0, 0.02, 1.0)), 0, Proxy::Count(8));
    for object in [table(), box_] {
        for visible in [true, false] {
            let lit = |own: Option<Strategy>, all: Option<Strategy>| {
                middle(&scene(Object { visible, strategy: own, ..object.clone() }), all)
            };
            let exact = [Strategy::Silhouettes, Strategy::Rays, Strategy::ShadowMap];
            for strategy in exact.map(Some).into_iter().chain([None]) {
                assert_eq!(lit(strategy, None), 0.0, "{} {visible} {strategy:?}", object.name);
                assert_eq!(lit(None, strategy), 0.0, "{} {visible} {strategy:?}", object.name);
            }
            assert!(lit(Some(Strategy::None), None) > 0.01, "{} {visible}", object.name);
        }
    }
}

/// A sphere that shows a light hides another one, and not its own: below it the floor gets what its light alone gives.
#[test]
fn bulbs_hide_other_lights() {
    let bulb = Sphere { center: Vec3::Y, radius: 0.15 };
    let shown = Object::spheres("bulb", vec![bulb], 0);
    for own in [1.0, 1e-3] {
        let own: Light = SphereLight::new(bulb, Vec3::splat(own)).into();
        let lit_by = |lights: Vec<Light>| Scene { lights, ..scene(shown.clone()) };
        for strategy in [None, Some(Strategy::Spheres), Some(Strategy::Rays), Some(Strategy::Silhouettes)] {
            let [alone, both] = [vec![own.clone()], vec![own.clone(), lamp(6.0)]];
            let [alone, both] = [alone, both].map(|lights| middle(&lit_by(lights), strategy));
            assert!(alone > 0.0 && (both / alone - 1.0).abs() < 1e-3, "{strategy:?}: {alone} {both}");
        }
    }
}

/// With the floor and with a floor that must not block: the same bits where nothing is behind it.
#[test]
fn floors_that_nothing_is_behind_cost_nothing() {
    let whole = scene(table());
    let plan = Plan::new(None, &whole);
    assert_eq!([0, 1].map(|o| plan.of(o)), [Strategy::None, Strategy::Silhouettes]);
    let mut without = whole.clone();
    without.objects[0].strategy = Some(Strategy::None);
    let mut with = whole.clone();
    with.objects[0].strategy = Some(Strategy::Silhouettes);
    assert_eq!(Plan::new(None, &with).of(0), Strategy::Silhouettes);
    assert_eq!(picture(&whole, None), picture(&without, None));
    let most = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(most(&picture(&whole, None), &picture(&with, None)) < 1e-5);
}

/// A light that goes below the floor is hidden from the moment on that it touches it, by edits of one renderer as by a new one.
#[test]
fn floors_block_from_the_moment_that_something_is_behind() {
    let mut base = scene(table());
    // Seen from below the table's height, beside it.
    base.camera = Camera {
        eye: Vec3::new(0.0, 3.0, 6.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::perspective(0.9),
    };
    let mut edited = Renderer::new(base.clone(), Animation::default(), Settings::default()).unwrap();
    let light = edited.lights().next().unwrap().0;
    for (y, below) in [(3.0, false), (-0.5, true), (0.05, true), (2.0, false), (-2.0, true)] {
        edited.set_light(light, lamp(y)).unwrap();
        let image = edited.render().unwrap().radiance;
        assert_eq!(edited.plan().of(0) != Strategy::None, below, "{y}");
        base.lights = vec![lamp(y)];
        assert_eq!(image, picture(&base, None), "{y}");
        if y < -0.1 {
            assert!(image.iter().all(|p| *p == Vec3::ZERO), "{y}");
        }
    }
}

/// A curved emitter hides nothing, whichever strategy all objects take: the lights that stand for it are inside of it.
#[test]
fn an_emitter_does_not_hide_its_own_lights() {
    let shade = Object { strategy: Some(Strategy::None), ..table() };
    let mut scene = scene(shade);
    let number = u32::try_from(scene.objects.len() - 1).expect("few objects");
    for strategy in [Strategy::Rays, Strategy::Silhouettes, Strategy::ShadowMap] {
        assert_eq!(Plan::new(Some(strategy), &scene).of(number as usize), strategy);
    }
    scene.lights = scene
        .lights
        .iter()
        .map(|light| EnclosedLight { light: Box::new(light.clone()), object: number }.into())
        .collect();
    for strategy in [Strategy::Rays, Strategy::Silhouettes, Strategy::Spheres, Strategy::ShadowMap] {
        assert_eq!(Plan::new(Some(strategy), &scene).of(number as usize), Strategy::None);
    }
}
