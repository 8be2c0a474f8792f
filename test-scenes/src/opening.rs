use glam::Vec3;
use lighting::Light;
use scene::{Camera, Mesh, Object, Projection, Proxy, Scene};

/// Half the sides of a [`room`].
pub const ROOM: Vec3 = Vec3::new(2.0, 1.5, 2.5);

/// An opening in the wall at −z: x from, to, y from, to.
pub type Opening = [f32; 4];

/// The wall around openings: the cells of a grid along all of their sides that are in none.
fn wall(openings: &[Opening]) -> Mesh {
    let lines = |half: f32, sides: [usize; 2]| {
        let inner = openings.iter().flat_map(|opening| sides.map(|side| opening[side]));
        let mut lines: Vec<f32> = inner.chain([-half, half]).collect();
        lines.sort_by(f32::total_cmp);
        lines.dedup();
        lines
    };
    let (x, y) = (lines(ROOM.x, [0, 1]), lines(ROOM.y, [2, 3]));
    let positions = y.iter().flat_map(|y| x.iter().map(|x| Vec3::new(*x, *y, -ROOM.z))).collect();
    let is_open = |i: usize, j: usize| {
        let is_in = |[left, right, low, high]: &Opening| *left <= x[i] && x[i] < *right && *low <= y[j] && y[j] < *high;
        openings.iter().any(is_in)
    };
    let mut triangles = Vec::new();
    for j in 0..y.len() - 1 {
        for i in (0..x.len() - 1).filter(|i| !is_open(*i, j)) {
            let [a, b] = [j, j + 1].map(|j| (j * x.len() + i) as u32);
            triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Rows of openings of the same size, with steps from middle to middle.
#[must_use]
pub fn openings(count: [usize; 2], [width, height]: [f32; 2], [dx, dy]: [f32; 2]) -> Vec<Opening> {
    let place = |k: usize, count: usize, step: f32| (k as f32 - 0.5 * (count as f32 - 1.0)) * step;
    let cell = |k: usize| {
        let [x, y] = [place(k % count[0], count[0], dx), place(k / count[0], count[1], dy) + 0.2];
        [x - 0.5 * width, x + 0.5 * width, y - 0.5 * height, y + 0.5 * height]
    };
    (0..count[0] * count[1]).map(cell).collect()
}

/// A white room of six sheets, seen from beside an opening in the wall at −z, and a light outside.
#[must_use]
pub fn room(opening: Opening, light: Light) -> Scene {
    room_with(&[opening], light)
}

/// The same with any number of openings.
#[must_use]
pub fn room_with(openings: &[Opening], light: Light) -> Scene {
    let Vec3 { x, y, z } = ROOM;
    let sides = [
        Mesh::quad(Vec3::new(0.0, -y, 0.0), Vec3::X * x, Vec3::NEG_Z * z),
        Mesh::quad(Vec3::new(0.0, y, 0.0), Vec3::X * x, Vec3::Z * z),
        Mesh::quad(Vec3::new(0.0, 0.0, z), Vec3::NEG_X * x, Vec3::Y * y),
        Mesh::quad(Vec3::new(-x, 0.0, 0.0), Vec3::NEG_Z * z, Vec3::Y * y),
        Mesh::quad(Vec3::new(x, 0.0, 0.0), Vec3::Z * z, Vec3::Y * y),
        wall(openings),
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
