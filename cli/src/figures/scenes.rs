//! The paper's scenes by count: points, spheres and lights are the paper's, the rest is made here.
//!
//! Shared with `examples/results_table`.

use super::sets::{Model, add_spheres};
use cosine_lobes::brdf::{Lafortune, LafortuneLobe, Lambert, Material, ModifiedPhong};
use cosine_lobes::lighting::{Light, SphereLight};
use cosine_lobes::lobe_core::Sphere;
use cosine_lobes::render_cpu::{GBuffer, World};
use cosine_lobes::scene::{BlockerSet, Camera, Mesh, Object, Projection, Proxy, Scene, ShadingPoints};
use glam::{Mat4, Vec3};

/// A scene and its blockers, with a model that is given.
type Make = fn(&Model) -> (Scene, BlockerSet);

/// A scene with a number of points.
pub(crate) struct Case {
    /// The number of points, and the image that the first ones are taken from.
    pub(crate) points: usize,
    pub(crate) size: [u32; 2],
    /// The number of spheres of the model.
    pub(crate) spheres: usize,
    make: Make,
    /// Points get one of the materials by a pattern over the surface.
    varying: bool,
}

impl Case {
    /// Fig. 13: a diffuse part and a Lafortune lobe, both varying.
    pub(crate) fn fig13() -> Self {
        let make = |cow: &Model| on_floor(cow, 0.0, key_light(), lafortune());
        Self { points: 89_284, size: [404, 221], spheres: 67, make, varying: true }
    }

    /// Fig. 15: a glossy model on a glossy floor.
    pub(crate) fn fig15() -> Self {
        let make = |cow: &Model| on_floor(cow, 0.0, key_light(), glossy());
        Self { points: 65_536, size: [256, 256], spheres: 64, make, varying: false }
    }

    /// Fig. 16: many models, two lights.
    pub(crate) fn fig16() -> Self {
        Self { points: 642_000, size: [1000, 642], spheres: 64, make: herd, varying: false }
    }

    /// Fig. 18: a model that shadows itself, under a small light or a large one.
    pub(crate) fn fig18(is_large: bool) -> Self {
        let make: Make = if is_large { |cow| close_up(cow, 1.0) } else { |cow| close_up(cow, 0.25) };
        Self { points: 85_558, size: [360, 240], spheres: 484, make, varying: false }
    }

    /// Fig. 22: the model on the floor (0), above it (1), and higher (2).
    pub(crate) fn fig22(step: usize) -> Self {
        let makes: [Make; 3] = [
            |cow| on_floor(cow, 0.0, key_light(), diffuse()),
            |cow| on_floor(cow, 0.7, key_light(), diffuse()),
            |cow| on_floor(cow, 1.4, key_light(), diffuse()),
        ];
        Self { points: 65_536, size: [256, 256], spheres: 64, make: makes[step], varying: false }
    }

    /// The scene, its blockers and the visible points, all that the picture has.
    pub(crate) fn make(&self, model: &Model) -> (Scene, BlockerSet, GBuffer) {
        let (scene, blockers) = (self.make)(model);
        let gbuffer = self.look(&scene, 1);
        (scene, blockers, gbuffer)
    }

    /// The visible points with so many rays a pixel.
    pub(crate) fn look(&self, scene: &Scene, samples: u32) -> GBuffer {
        let mut gbuffer = GBuffer::new(&World::new(scene), self.size[0], self.size[1], samples);
        if self.varying {
            let ShadingPoints { receivers, materials, .. } = &mut gbuffer.points;
            for (at, material) in receivers.iter().zip(materials) {
                let p = at.position * 6.0;
                let wave = (p.x + (2.0 * p.z).sin()).sin() + (p.z + (1.5 * p.y).cos()).cos() + p.y.sin();
                *material = ((wave + 3.0) / 6.0 * 15.99) as u32;
            }
        }
        gbuffer
    }

    /// The first points, as many as the paper has.
    pub(crate) fn counted(&self, mut points: ShadingPoints) -> ShadingPoints {
        points.receivers.truncate(self.points);
        points.materials.truncate(self.points);
        points
    }
}

pub(crate) fn diffuse() -> Vec<Material> {
    vec![Lambert { albedo: Vec3::splat(0.7) }.into()]
}

fn glossy() -> Vec<Material> {
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

/// A sphere light with the same flux for any radius.
pub(crate) fn light(center: Vec3, radius: f32) -> Light {
    SphereLight::new(Sphere { center, radius }, Vec3::splat(30.0 / (radius * radius))).into()
}

/// The light of the model on the floor.
fn key_light() -> Light {
    light(Vec3::new(3.0, 5.5, 1.5), 0.6)
}

/// The visible part of a floor that fills the picture.
pub(crate) fn floor_scene(eye: Vec3, target: Vec3, fov: f32, materials: Vec<Material>, lights: Vec<Light>) -> Scene {
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 400.0, Vec3::NEG_Z * 400.0);
    Scene {
        camera: Camera { eye, target, up: Vec3::Y, projection: Projection::perspective(fov.to_radians()) },
        width: 256,
        height: 256,
        materials,
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None)],
        lights,
        ..Scene::default()
    }
}

/// The model over a floor, its lowest point at `height`.
pub(crate) fn on_floor(cow: &Model, height: f32, light: Light, materials: Vec<Material>) -> (Scene, BlockerSet) {
    let matrix = Mat4::from_translation(Vec3::Y * (0.737 + height)) * Mat4::from_rotation_y(2.3);
    let mut blockers = BlockerSet::default();
    let mesh = cow.place(&matrix, 1, &mut blockers);
    let target = Vec3::new(-0.4, 0.3 + 0.4 * height, -0.2);
    let mut scene = floor_scene(Vec3::new(0.0, 4.0, 5.5), target, 27.0, materials, vec![light]);
    scene.objects.push(Object::mesh("cow", mesh, 0, Proxy::None));
    (scene, blockers)
}

/// 56 models, 3578 spheres, two lights.
fn herd(cow: &Model) -> (Scene, BlockerSet) {
    let lights = vec![light(Vec3::new(9.0, 12.0, 4.0), 1.2), light(Vec3::new(-10.0, 9.0, 6.0), 0.8)];
    let mut scene = floor_scene(Vec3::new(0.0, 9.0, 17.0), Vec3::new(0.0, 0.0, -0.5), 33.0, diffuse(), lights);
    let mut blockers = BlockerSet::default();
    for i in 0..56 {
        let (row, column) = (i / 8, i % 8);
        let place = Vec3::new(column as f32 * 1.9 - 6.6, 0.737, row as f32 * 1.9 - 6.5);
        let matrix = Mat4::from_translation(place) * Mat4::from_rotation_y(i as f32 * 2.4);
        let number = scene.objects.len() as u32;
        let mesh = cow.place(&matrix, number, &mut blockers);
        scene.objects.push(Object::mesh(format!("cow {i}"), mesh, 0, Proxy::None));
    }
    blockers.spheres.truncate(3578);
    blockers.self_shadows.truncate(3578);
    blockers.objects.truncate(3578);
    (scene, blockers)
}

/// The model's head and trunk fill the picture: most points are shadowed by their own object's spheres.
pub(crate) fn close_up(cow: &Model, radius: f32) -> (Scene, BlockerSet) {
    let matrix = Mat4::from_translation(Vec3::Y * 0.737) * Mat4::from_rotation_y(2.6);
    let mut blockers = BlockerSet::default();
    let mesh = cow.place(&matrix, 1, &mut blockers);
    let lights = vec![light(Vec3::new(-3.0, 4.5, 2.5), radius)];
    let mut scene = floor_scene(Vec3::new(0.2, 1.6, 4.6), Vec3::new(0.0, 0.75, 0.0), 19.0, diffuse(), lights);
    scene.objects.push(Object::mesh("cow", mesh, 0, Proxy::None));
    (scene, blockers)
}

/// A cube of 64 spheres over a floor.
pub(crate) fn cube(lights: Vec<Light>) -> (Scene, BlockerSet) {
    // The outer ones touch the faces from inside: a sphere that bulges out would blacken them.
    let at = |i: u32| (i as f32 - 1.5) * 0.22;
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

/// A light of that area, seen as a disc, 20 units from the cube.
pub(crate) fn far_light(area: f32) -> Light {
    light(Vec3::new(9.0, 17.0, 4.0), (area / core::f32::consts::PI).sqrt())
}

/// So many small lights on a golden spiral over the upper half of a sphere.
pub(crate) fn spiral_lights(count: usize) -> Vec<Light> {
    let at = |i: usize| {
        let y = 0.35 + 0.6 * (i as f32 + 0.5) / count as f32;
        let (s, c) = (i as f32 * 2.399_963).sin_cos();
        let across = (1.0 - y * y).sqrt();
        7.0 * Vec3::new(c * across, y, s * across)
    };
    (0..count).map(|i| light(at(i), 0.4)).collect()
}
