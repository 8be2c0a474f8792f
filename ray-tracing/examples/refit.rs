//! Cost of refitting the hierarchy of a moving mesh, beside the cost of building it anew: medians.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example refit`

use glam::Vec3;
use lighting::SphereLight;
use lobe_core::Sphere;
use ray_tracing::Hierarchy;
use scene::{Camera, Mesh, Object, Projection, Proxy, Scene, Shape};
use std::time::Instant;

/// A waving sheet of n × n quads.
fn sheet(n: u32, time: f32) -> Vec<Vec3> {
    let at = |i: u32| i as f32 / n as f32 * 10.0;
    let wave = |x: f32, z: f32| 0.5 * (x + 2.0 * time).sin() * (0.7 * z - time).cos();
    (0..=n).flat_map(|i| (0..=n).map(move |j| Vec3::new(at(i), wave(at(i), at(j)), at(j)))).collect()
}

fn main() {
    println!("triangles   build ms   refit ms   ratio   refit ms a 1000 triangles");
    for n in [16, 64, 208, 512] {
        let quads = (0..n).flat_map(|i| (0..n).map(move |j| i * (n + 1) + j));
        let triangles = quads.flat_map(|k| [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]]).collect();
        let mesh = Mesh { positions: sheet(n, 0.0), triangles, ..Mesh::default() };
        let camera = Camera {
            eye: Vec3::splat(20.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::perspective(0.5),
        };
        let sphere = Sphere { center: Vec3::Y * 20.0, radius: 1.0 };
        let mut scene = Scene {
            camera,
            width: 64,
            height: 64,
            materials: vec![brdf::Material::lambert(Vec3::ONE)],
            objects: vec![Object::mesh("sheet", mesh, 0, Proxy::Count(1))],
            lights: vec![SphereLight { sphere, radiance: Vec3::ONE }.into()],
            ..Scene::default()
        };
        let mut hierarchy = Hierarchy::new(&scene);
        let (mut builds, mut refits) = (Vec::new(), Vec::new());
        for frame in 1..=15 {
            if let Shape::Mesh(mesh) = &mut scene.objects[0].shape {
                mesh.positions = sheet(n, frame as f32 * 0.04);
            }
            let start = Instant::now();
            drop(Hierarchy::new(&scene));
            builds.push(start.elapsed().as_secs_f64());
            let start = Instant::now();
            hierarchy.update(&scene);
            refits.push(start.elapsed().as_secs_f64());
        }
        let median = |times: &mut Vec<f64>| {
            times.sort_by(f64::total_cmp);
            1e3 * times[times.len() / 2]
        };
        let (build, refit) = (median(&mut builds), median(&mut refits));
        let count = 2 * n * n;
        println!(
            "{count:9}   {build:8.3}   {refit:8.3}   {:5.1}   {:.4}",
            build / refit,
            refit / f64::from(count) * 1e3
        );
    }
}
