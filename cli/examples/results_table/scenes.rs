//! The paper's scenes by count: points, spheres and lights are the paper's, the rest is made here.

use crate::sets::{add, add_spheres, set, spot};
use cosine_lobes::brdf::{Lafortune, LafortuneLobe, Lambert, Material, ModifiedPhong};
use cosine_lobes::lighting::{Light, SphereLight};
use cosine_lobes::lobe_core::Sphere;
use cosine_lobes::render_cpu::{GBuffer, World};
use cosine_lobes::scene::{BlockerSet, Camera, Projection, Mesh, Object, Proxy, Scene};
use glam::{Mat4, Vec3};

/// One line of the table.
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) note: &'static str,
    /// The paper's figure.
    pub(crate) paper: &'static str,
    /// Target in frames a second; 0 without one.
    pub(crate) target: f64,
    /// The paper's number of points, image width and height, and the scene.
    points: usize,
    size: [u32; 2],
    make: fn() -> (Scene, BlockerSet),
    pub(crate) threshold: f32,
    /// Points get one of the materials by a pattern over the surface.
    varying: bool,
}

impl Case {
    /// The scene, its blockers and the visible points.
    pub(crate) fn make(&self) -> (Scene, BlockerSet, GBuffer) {
        let (scene, blockers) = (self.make)();
        let mut gbuffer = GBuffer::new(&World::new(&scene), self.size[0], self.size[1], 1);
        let points = &mut gbuffer.points;
        assert!(points.receivers.len() >= self.points, "{}: {} points", self.name, points.receivers.len());
        points.receivers.truncate(self.points);
        points.materials.truncate(self.points);
        if self.varying {
            for (at, material) in points.receivers.iter().zip(&mut points.materials) {
                let p = at.position * 6.0;
                let wave = (p.x + (2.0 * p.z).sin()).sin() + (p.z + (1.5 * p.y).cos()).cos() + p.y.sin();
                *material = ((wave + 3.0) / 6.0 * 15.99) as u32;
            }
        }
        gbuffer.pixels.truncate(self.points);
        gbuffer.depths.truncate(self.points);
        (scene, blockers, gbuffer)
    }
}

pub(crate) fn all() -> Vec<Case> {
    let case = |name, note, paper, target, points, size, make| Case {
        name,
        note,
        paper,
        target,
        points,
        size,
        make,
        threshold: 0.0,
        varying: false,
    };
    vec![
        Case {
            varying: true,
            ..case(
                "Fig. 13",
                "diffuse + Lafortune lobe, varying",
                "3.01 fps; mask 84.8 %",
                250.0,
                89_284,
                [404, 221],
                || on_floor(67, 0.0, 0.6, lafortune()),
            )
        },
        case("Fig. 15", "glossy, t_i = 0", "products halved, +2 fps", 0.0, 65_536, [256, 256], || {
            on_floor(64, 0.0, 0.6, glossy())
        }),
        Case {
            threshold: 0.005,
            ..case("Fig. 15, t_i", "glossy, t_i = 0.5 %", "", 0.0, 65_536, [256, 256], || {
                on_floor(64, 0.0, 0.6, glossy())
            })
        },
        case("Fig. 16", "56 cows, diffuse", "17.68 s a frame", 1.0 / 0.15, 642_000, [1000, 642], herd),
        case("Fig. 18 left", "self-shadowing, small light", "4.5 fps", 120.0, 85_558, [360, 240], || {
            close_up(0.25, 484)
        }),
        case("Fig. 18 right", "self-shadowing, large light", "2.3 fps", 80.0, 85_558, [360, 240], || {
            close_up(1.0, 484)
        }),
        case("Fig. 22(a)", "diffuse, on the floor", "mask 72.2 %", 300.0, 65_536, [256, 256], || {
            on_floor(64, 0.0, 0.6, diffuse())
        }),
        case("Fig. 22(b)", "diffuse, above the floor", "mask 60.1 %", 300.0, 65_536, [256, 256], || {
            on_floor(64, 0.7, 0.6, diffuse())
        }),
        case("Fig. 22(c)", "diffuse, higher", "mask 52.1 %", 300.0, 65_536, [256, 256], || {
            on_floor(64, 1.4, 0.6, diffuse())
        }),
    ]
}

pub(crate) fn diffuse() -> Vec<Material> {
    vec![Lambert { albedo: Vec3::splat(0.7) }.into()]
}

pub(crate) fn glossy() -> Vec<Material> {
    vec![ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.4), exponent: 100.0 }.into()]
}

/// Sixteen kinds of diffuse part and one lobe, from dull to shiny.
fn lafortune() -> Vec<Material> {
    let one = |i: u8| {
        let t = f32::from(i) / 15.0;
        let (exponent, c) = (8.0 * 25.0_f32.powf(t), 0.98 - 0.05 * t);
        let lobe =
            LafortuneLobe::diagonal(Vec3::new(-c, -c, 1.0), exponent, Vec3::new(0.8, 0.6, 0.4) * (0.1 + 0.4 * t));
        let diffuse = Vec3::new(0.5 - 0.3 * t, 0.35, 0.2 + 0.3 * t);
        Lafortune { diffuse, lobes: vec![lobe] }.into()
    };
    (0..16).map(one).collect()
}

pub(crate) fn light(center: Vec3, radius: f32) -> Light {
    SphereLight::new(Sphere { center, radius }, Vec3::splat(30.0 / (radius * radius))).into()
}

/// The visible part of a floor that fills the picture.
pub(crate) fn floor_scene(eye: Vec3, target: Vec3, fov: f32, materials: Vec<Material>, lights: Vec<Light>) -> Scene {
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 400.0, Vec3::NEG_Z * 400.0);
    Scene { camera: Camera { eye, target, up: Vec3::Y, projection: Projection::perspective(fov.to_radians()) }, width: 256, height: 256, materials, objects: vec![Object::mesh("floor", floor, 0, Proxy::None)], lights, ..Scene::default() }
}

/// The cow over a floor, her lowest point at `height`.
fn on_floor(count: usize, height: f32, radius: f32, materials: Vec<Material>) -> (Scene, BlockerSet) {
    let mut mesh = spot();
    let set = set("spot", &mesh, count);
    let matrix = Mat4::from_translation(Vec3::Y * (0.737 + height)) * Mat4::from_rotation_y(2.3);
    mesh.transform(&matrix);
    let lights = vec![light(Vec3::new(3.0, 5.5, 1.5), radius)];
    let mut scene =
        floor_scene(Vec3::new(0.0, 4.0, 5.5), Vec3::new(-0.4, 0.3 + 0.4 * height, -0.2), 27.0, materials, lights);
    scene.objects.push(Object::mesh("cow", mesh, 0, Proxy::None));
    let mut blockers = BlockerSet::default();
    add(&mut blockers, 1, &set, &matrix, count);
    (scene, blockers)
}

/// 56 cows, 3578 spheres, two lights.
fn herd() -> (Scene, BlockerSet) {
    let mesh = spot();
    let set = set("spot", &mesh, 64);
    let lights = vec![light(Vec3::new(9.0, 12.0, 4.0), 1.2), light(Vec3::new(-10.0, 9.0, 6.0), 0.8)];
    let mut scene = floor_scene(Vec3::new(0.0, 9.0, 17.0), Vec3::new(0.0, 0.0, -0.5), 33.0, diffuse(), lights);
    let mut blockers = BlockerSet::default();
    for i in 0..56 {
        let (row, column) = (i / 8, i % 8);
        let place = Vec3::new(column as f32 * 1.9 - 6.6, 0.737, row as f32 * 1.9 - 6.5);
        let matrix = Mat4::from_translation(place) * Mat4::from_rotation_y(i as f32 * 2.4);
        let mut cow = mesh.clone();
        cow.transform(&matrix);
        let number = scene.objects.len() as u32;
        scene.objects.push(Object::mesh(format!("cow {i}"), cow, 0, Proxy::None));
        let left = 3578 - blockers.spheres.len();
        add(&mut blockers, number, &set, &matrix, left);
    }
    (scene, blockers)
}

/// The cow's head and trunk fill the picture: most points are shadowed by their own object's spheres.
pub(crate) fn close_up(radius: f32, count: usize) -> (Scene, BlockerSet) {
    let mut mesh = spot();
    let set = set("spot", &mesh, count);
    let matrix = Mat4::from_translation(Vec3::Y * 0.737) * Mat4::from_rotation_y(2.6);
    mesh.transform(&matrix);
    let lights = vec![light(Vec3::new(-3.0, 4.5, 2.5), radius)];
    let mut scene = floor_scene(Vec3::new(0.2, 1.6, 4.6), Vec3::new(0.0, 0.75, 0.0), 19.0, diffuse(), lights);
    scene.objects.push(Object::mesh("cow", mesh, 0, Proxy::None));
    let mut blockers = BlockerSet::default();
    add(&mut blockers, 1, &set, &matrix, count);
    (scene, blockers)
}

/// A cube of 64 spheres over a floor.
pub(crate) fn cube(lights: Vec<Light>) -> (Scene, BlockerSet) {
    let at = |i: u32| (i as f32 - 1.5) * 0.25;
    let spheres: Vec<Sphere> = (0..64)
        .map(|i| Sphere { center: Vec3::new(at(i % 4), at(i / 4 % 4) + 0.9, at(i / 16)), radius: 0.17 })
        .collect();
    let mesh = Mesh::cuboid(Vec3::Y * 0.9, Vec3::splat(1.0));
    let mut scene = floor_scene(Vec3::new(0.0, 3.5, 5.5), Vec3::new(0.0, 0.4, 0.0), 36.0, diffuse(), lights);
    scene.objects.push(Object::mesh("cube", mesh, 0, Proxy::None));
    let mut blockers = BlockerSet::default();
    add_spheres(&mut blockers, 1, &spheres);
    (scene, blockers)
}
