//! Metered exposures against those of pictures without noise.

use core::f64::consts::TAU;
use glam::{DVec3, Vec3};
use lighting::{Environment, EnvironmentMap};
use lobe_core::{Receiver, Sphere};
use ray_tracing::{GBuffer, World};
use renderer::{exposure, exposure_of};
use scene::Scene;
use std::sync::Arc;
use test_scenes::{Opening, ROOM, room};

/// A room below a sky of radiance 1, which is seen through an opening alone.
fn below_sky(opening: Opening) -> Scene {
    let world = Sphere { center: Vec3::ZERO, radius: 10.0 };
    let sky = Environment::new(EnvironmentMap::uniform(Vec3::ONE), 2, world);
    let mut scene = room(opening, sky.lights()[0].clone());
    scene.lights = sky.lights().to_vec();
    scene.environment = Some(Arc::new(sky));
    (scene.width, scene.height) = (60, 40);
    scene
}

/// The radiance of a white diffuse point that sees the sky through an opening: J. H. Lambert's formula for polygons.
fn through(at: &Receiver, [left, right, low, high]: Opening) -> f32 {
    let corners = [[left, low], [right, low], [right, high], [left, high]];
    let seen = corners.map(|[x, y]| (Vec3::new(x, y, -ROOM.z) - at.position).as_dvec3().normalize());
    let side = |k: usize| {
        let (a, b) = (seen[k], seen[(k + 1) % 4]);
        a.angle_between(b) * a.cross(b).normalize_or(DVec3::ZERO).dot(at.normal.as_dvec3())
    };
    ((0..4).map(side).sum::<f64>() / TAU).abs() as f32
}

/// Openings of 1 m and less, down to slits through which points see a ten thousandth of the sky.
#[test]
fn rooms_behind_small_openings_are_metered_to_a_tenth_of_a_stop() {
    for opening in [
        [-1.9, 1.9, -1.4, 1.4],
        [-1.9, 1.9, -0.5, 1.4],
        [-1.0, 1.0, -0.7, 1.0],
        [-0.6, 0.6, -0.4, 0.6],
        [-0.3, 0.3, -0.3, 0.3],
        [0.8, 0.9, -1.4, 0.6],
        [-0.5, 0.5, 0.0, 0.02],
        [0.4, 0.41, -1.0, 1.0],
    ] {
        let scene = below_sky(opening);
        let world = World::new(&scene);
        let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
        let wanted = exposure_of(points.receivers.iter().map(|at| Vec3::splat(through(at, opening))));
        let found = exposure(&world);
        println!("{opening:?}: {found} of {wanted}");
        assert!((found - wanted).abs() < 0.11, "{opening:?}: {found}, by the closed form {wanted}");
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        assert_eq!(one.install(|| exposure(&world)), found);
    }
}
