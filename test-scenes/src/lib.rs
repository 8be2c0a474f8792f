//! Small scenes and meshes for the tests of the workspace.

mod opening;
mod shades;

pub use opening::{Opening, ROOM, leaf, openings, room, room_with, with_door};
pub use shades::{around_lampshade, below_leaves, leaves};

use brdf::Material;
use core::f32::consts::PI;
use glam::{UVec2, Vec3};
use lighting::{EnvironmentMap, SphereLight};
use lobe_core::Sphere;
use scene::{Camera, Mesh, Object, Projection, Proxy, Scene, Shape};

/// A gray diffuse material.
#[must_use]
pub fn material() -> Material {
    Material::lambert(Vec3::splat(0.5))
}

/// A horizontal square of half side 4 at height 0, a sphere of radius 0.5 above its middle, one light above both.
#[must_use]
pub fn floor_and_sphere() -> Scene {
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z) * 4.0;
    let mesh = Mesh {
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        normals: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let sphere = Sphere { center: Vec3::Y, radius: 0.5 };
    let object = |name: &str, shape, proxy| Object {
        name: name.into(),
        shape,
        material: 0,
        proxy,
        visible: true,
        strategy: None,
        terminator: scene::Terminator::Exact,
    };
    Scene {
        camera: Camera {
            eye: Vec3::new(0.0, 3.0, 8.0),
            target: Vec3::Y,
            up: Vec3::Y,
            projection: Projection::perspective(0.6),
        },
        width: 50,
        height: 30,
        materials: vec![material()],
        objects: vec![
            object("floor", Shape::Mesh(mesh), Proxy::None),
            object("sphere", Shape::Spheres(vec![sphere]), Proxy::Spheres(vec![sphere])),
        ],
        lights: vec![
            SphereLight::new(Sphere { center: Vec3::new(1.0, 5.0, 0.5), radius: 0.7 }, Vec3::splat(3.0)).into(),
        ],
        ..Scene::default()
    }
}

/// A globe of about `4n²` triangles, smooth or flat.
#[must_use]
pub fn globe(n: u32, center: Vec3, radius: f32, smooth: bool) -> Mesh {
    let at = |i: u32, k: u32| {
        let ((s, c), (x, z)) = ((PI * i as f32 / n as f32).sin_cos(), (PI * k as f32 / n as f32).sin_cos());
        center + radius * Vec3::new(s * x, c, s * z)
    };
    let positions = (0..=n).flat_map(|i| (0..2 * n).map(move |k| at(i, k))).collect();
    let number = |i: u32, k: u32| i * 2 * n + k % (2 * n);
    let quads = (0..n).flat_map(|i| (0..2 * n).map(move |k| [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)]));
    let triangles = quads.flat_map(|q| {
        let [a, b, c, d] = q.map(|(i, k)| number(i, k));
        [[a, b, c], [a, c, d]]
    });
    let mut mesh = Mesh { positions, triangles: triangles.collect(), ..Mesh::default() };
    mesh.remove_degenerate();
    if smooth {
        mesh.smooth_normals();
    }
    mesh
}

/// A picture of all directions, of a radiance by direction.
///
/// # Panics
/// For sizes and radiances that [`EnvironmentMap::new`] refuses.
#[must_use]
pub fn environment_map(size: UVec2, radiance: impl Fn(Vec3) -> Vec3) -> EnvironmentMap {
    let texel = |k: u32| {
        let turn = (((k % size.x) as f32 + 0.5) / size.x as f32 - 0.5) * 2.0 * PI;
        let down = ((k / size.x) as f32 + 0.5) / size.y as f32 * PI;
        radiance(Vec3::new(turn.sin() * down.sin(), down.cos(), -turn.cos() * down.sin()))
    };
    EnvironmentMap::new(size, (0..size.x * size.y).map(texel).collect()).expect("a picture")
}
