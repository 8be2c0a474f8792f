use core::f32::consts::TAU;
use glam::Vec3;
use lighting::Light;
use lobe_core::Random;
use scene::{Camera, Mesh, Object, Projection, Proxy, Scene};

/// Leaves above a floor: small kites at any place in a box of 3 × 1.2 × 3, turned in any direction, of such a half length.
#[must_use]
pub fn leaves(count: usize, size: f32) -> Mesh {
    let mut random = Random::new(1);
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let mut at = |from: f64, to: f64| random.between(from, to) as f32;
        let middle = Vec3::new(at(-1.5, 1.5), at(1.2, 2.4), at(-1.5, 1.5));
        let along = random.axis();
        let across = 0.5 * random.axis_at(along, 0.5 * core::f64::consts::PI);
        let [u, v] = [along, across].map(|side| side.as_vec3() * size);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([-u, -v, u, v].map(|corner| middle + corner));
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|k| first + k)));
    }
    mesh
}

/// A gray floor below [leaves], seen from below their height.
#[must_use]
pub fn below_leaves(count: usize, size: f32, lights: Vec<Light>) -> Scene {
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 10.0, Vec3::NEG_Z * 10.0);
    let camera = Camera {
        eye: Vec3::new(0.0, 0.8, 3.2),
        target: Vec3::new(0.0, 0.3, 0.0),
        up: Vec3::Y,
        projection: Projection::perspective(0.87),
    };
    let objects = [("floor", floor), ("leaves", leaves(count, size))]
        .map(|(name, mesh)| Object::mesh(name, mesh, 0, Proxy::None));
    plain(camera, objects.into(), lights)
}

/// A gray room of 4 × 2.6 × 4 in whose middle, 1.4 to 1.72 above the floor, a lampshade of paper hangs: a cone that is open above and below, with
/// these radii there.
#[must_use]
pub fn around_lampshade(below: f32, above: f32, lights: Vec<Light>) -> Scene {
    const SIDES: u32 = 48;
    let room = Mesh::cuboid(Vec3::new(0.0, 1.3, 0.0), Vec3::new(4.0, 2.6, 4.0));
    let corner = |k: u32| {
        let (sin, cos) = (TAU * (k / 2) as f32 / SIDES as f32).sin_cos();
        let (radius, height) = if k.is_multiple_of(2) { (below, 1.4) } else { (above, 1.72) };
        Vec3::new(radius * cos, height, radius * sin)
    };
    let side = |k: u32| {
        let [a, b, c, d] = [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1].map(|corner| corner % (2 * SIDES));
        [[a, b, c], [a, c, d]]
    };
    let shade = Mesh {
        positions: (0..2 * SIDES).map(corner).collect(),
        triangles: (0..SIDES).flat_map(side).collect(),
        ..Mesh::default()
    };
    let camera = Camera {
        eye: Vec3::new(0.0, 1.3, 1.9),
        target: Vec3::new(0.0, 1.2, -1.0),
        up: Vec3::Y,
        projection: Projection::perspective(1.4),
    };
    let objects = [("room", room), ("shade", shade)].map(|(name, mesh)| Object::mesh(name, mesh, 0, Proxy::None));
    plain(camera, objects.into(), lights)
}

fn plain(camera: Camera, objects: Vec<Object>, lights: Vec<Light>) -> Scene {
    Scene { camera, width: 36, height: 24, materials: vec![crate::material()], objects, lights, ..Scene::default() }
}
