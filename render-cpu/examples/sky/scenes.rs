//! The scenes of the examples that measure skies, on a CPU and on a GPU.

use brdf::Material;
use glam::{UVec2, Vec3};
use lighting::Environment;
use lobe_core::Sphere;
use scene::{Camera, Mesh, Object, Projection, Proxy, Scene};
use scene_files::load_objects;
use std::error::Error;
use std::path::Path;
use test_scenes::environment_map;

/// A mesh of the assets beside this repository, 1.2 high on the floor.
pub(crate) fn file(name: &str) -> Result<Mesh, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets/meshes").join(name);
    let mut objects = load_objects(path, None)?.0;
    let scene::Shape::Mesh(mut mesh) = objects.swap_remove(0).shape else { return Err("no mesh".into()) };
    let bounds = mesh.bounds();
    let scale = 1.2 / (bounds.max.y - bounds.min.y);
    let base = Vec3::new(bounds.center().x, bounds.min.y, bounds.center().z);
    mesh.positions.iter_mut().for_each(|p| *p = (*p - base) * scale);
    mesh.smooth_normals();
    Ok(mesh)
}

pub(crate) fn scene(mesh: Mesh, material: &Material, side: u32) -> Scene {
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 6.0, Vec3::NEG_Z * 6.0);
    Scene {
        camera: Camera {
            eye: Vec3::new(0.8, 1.9, 3.3),
            target: Vec3::new(0.0, 0.5, 0.0),
            up: Vec3::Y,
            projection: Projection::perspective(0.66),
        },
        width: side,
        height: side,
        materials: vec![material.clone()],
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::mesh("mesh", mesh, 0, Proxy::Count(8))],
        ..Scene::default()
    }
}

pub(crate) fn soft(v: Vec3) -> Vec3 {
    let glow = v.dot(Vec3::new(0.6, 0.7, 0.4).normalize()).max(0.0).powi(24);
    let dome = if v.y > 0.0 { 0.25 + 0.75 * v.y.sqrt() } else { 0.2 + 0.05 * v.y };
    Vec3::new(0.7, 0.85, 1.1) * dome + Vec3::new(6.0, 5.4, 4.5) * glow
}

/// A hard window of 16° by 22° in four panes.
pub(crate) fn window(v: Vec3) -> Vec3 {
    let (turn, height) = (v.x.atan2(-v.z).to_degrees(), v.y.asin().to_degrees());
    let place = [(turn - 30.0) / 16.0, (height - 40.0) / 22.0];
    let is_pane = place.iter().all(|x| (0.0..1.0).contains(x) && (x - 0.5).abs() > 0.03);
    Vec3::splat(if is_pane { 20.0 } else { 0.15 })
}

pub(crate) fn environment(radiance: impl Fn(Vec3) -> Vec3) -> Environment {
    let map = environment_map(UVec2::new(512, 256), radiance);
    Environment::new(map, 2, Sphere { center: Vec3::ZERO, radius: 10.0 })
}
