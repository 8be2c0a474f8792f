use glam::Vec3;
use lighting::Light;
use scene::{Camera, Mesh, Object, Projection, Proxy, Scene};

/// Half the sides of a [`room`].
pub const ROOM: Vec3 = Vec3::new(2.0, 1.5, 2.5);

/// An opening in the wall at −z: x from, to, y from, to.
pub type Opening = [f32; 4];

/// The wall around an opening: its corners and those of the opening, whose sides are the only edges that a ray may pass.
fn wall([left, right, low, high]: Opening) -> Mesh {
    let at = |x: f32, y: f32| Vec3::new(x, y, -ROOM.z);
    let (x, y) = (ROOM.x, ROOM.y);
    let positions = vec![
        at(-x, -y),
        at(x, -y),
        at(x, y),
        at(-x, y),
        at(left, low),
        at(right, low),
        at(right, high),
        at(left, high),
    ];
    let ring = (0..4_u32).flat_map(|k| {
        let next = (k + 1) % 4;
        [[k, next, next + 4], [k, next + 4, k + 4]]
    });
    Mesh { positions, triangles: ring.collect(), ..Mesh::default() }
}

/// A white room of six sheets, seen from beside an opening in the wall at −z, and a light outside.
#[must_use]
pub fn room(opening: Opening, light: Light) -> Scene {
    let Vec3 { x, y, z } = ROOM;
    let sides = [
        Mesh::quad(Vec3::new(0.0, -y, 0.0), Vec3::X * x, Vec3::NEG_Z * z),
        Mesh::quad(Vec3::new(0.0, y, 0.0), Vec3::X * x, Vec3::Z * z),
        Mesh::quad(Vec3::new(0.0, 0.0, z), Vec3::NEG_X * x, Vec3::Y * y),
        Mesh::quad(Vec3::new(-x, 0.0, 0.0), Vec3::NEG_Z * z, Vec3::Y * y),
        Mesh::quad(Vec3::new(x, 0.0, 0.0), Vec3::Z * z, Vec3::Y * y),
        wall(opening),
    ];
    Scene {
        surfaces: Vec::new(),
        camera: Camera {
            eye: Vec3::new(0.0, 0.2, -2.2),
            target: Vec3::new(0.0, -0.4, 2.0),
            up: Vec3::Y,
            projection: Projection::perspective(1.3),
        },
        width: 36,
        height: 24,
        background: Vec3::ZERO,
        environment: None,
        materials: vec![brdf::Material::lambert(Vec3::ONE)],
        objects: sides.into_iter().map(|mesh| Object::mesh("side", mesh, 0, Proxy::None)).collect(),
        lights: vec![light],
    }
}

/// How far the door of [`with_door`] is open, in radians, and how thick its leaf is.
const DOOR: [f32; 2] = [0.105, 0.04];

/// Fills an opening with a door that is ajar: a leaf as wide and as high, hinged at the opening's left side, turned outward by 6°.
#[must_use]
pub fn with_door(mut scene: Scene, opening: Opening) -> Scene {
    let [hinge, up, along, outward] = leaf(opening);
    let mut mesh = Mesh::cuboid(Vec3::splat(0.5), Vec3::ONE);
    for p in &mut mesh.positions {
        *p = hinge + up * p.x + along * p.y + outward * p.z;
    }
    mesh.normals.clear();
    scene.objects.push(Object::mesh("door", mesh, 0, Proxy::None));
    scene
}

/// The leaf of a door: its lower corner at the hinge and its sides, upward, along the leaf and outward.
#[must_use]
pub fn leaf([left, right, low, high]: Opening) -> [Vec3; 4] {
    let [angle, thick] = DOOR;
    let (sin, cos) = angle.sin_cos();
    let along = Vec3::new(cos, 0.0, -sin);
    let outward = Vec3::new(-sin, 0.0, -cos) * thick;
    [Vec3::new(left, low, -ROOM.z), Vec3::Y * (high - low), along * (right - left), outward]
}
