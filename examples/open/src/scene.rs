//! A chair of capsules on a velvet floor under two spots, all of them this crate's.

use crate::{Capsule, Capsules, Spot, Velvet};
use cosine_lobes::brdf::Material;
use cosine_lobes::glam::Vec3;
use cosine_lobes::lighting::Light;
use cosine_lobes::lobe_core::Sphere;
use cosine_lobes::renderer::{Device, RenderError, Renderer, Settings};
use cosine_lobes::scene::{Animation, Camera, Mesh, Object, Projection, Proxy, Scene, Strategy};
use cosine_lobes::shading::Accuracy;
use std::sync::Arc;

pub const MATERIALS: [Velvet; 2] = [
    Velvet { kd: Vec3::new(0.35, 0.08, 0.12), ks: Vec3::new(0.3, 0.12, 0.15), exponent: 6.0 },
    Velvet { kd: Vec3::new(0.4, 0.32, 0.2), ks: Vec3::splat(0.2), exponent: 30.0 },
];

pub fn lights() -> [Spot; 2] {
    let spot = |center: Vec3, radiance: Vec3| {
        let direction = (Vec3::Y * 0.5 - center).normalize();
        Spot { sphere: Sphere { center, radius: 0.35 }, radiance, direction, inner: 0.93, outer: 0.86 }
    };
    [
        spot(Vec3::new(-2.5, 4.0, 1.5), Vec3::new(60.0, 56.0, 50.0)),
        spot(Vec3::new(3.0, 3.5, 2.5), Vec3::new(20.0, 24.0, 32.0)),
    ]
}

pub fn rods() -> Capsules {
    let rod = |a: [f32; 3], b: [f32; 3]| Capsule { ends: [a.into(), b.into()], radius: 0.035 };
    let corners = [[-0.4, -0.4], [0.4, -0.4], [0.4, 0.4], [-0.4, 0.4]];
    let mut rods = Vec::new();
    for i in 0..4 {
        let ([x, z], [u, v]) = (corners[i], corners[(i + 1) % 4]);
        rods.push(rod([x, 0.035, z], [x, 0.8, z]));
        rods.push(rod([x, 0.8, z], [u, 0.8, v]));
        rods.push(rod([x, 0.8, 0.2 * i as f32 - 0.3], [-x, 0.8, 0.2 * i as f32 - 0.3]));
    }
    for i in 0..5 {
        let x = 0.2 * i as f32 - 0.4;
        rods.push(rod([x, 0.8, -0.4], [1.1 * x, 1.7, -0.5]));
    }
    rods.push(rod([-0.44, 1.7, -0.5], [0.44, 1.7, -0.5]));
    Capsules(rods)
}

/// The camera sees meshes and spheres: strings of spheres stand for the rods.
fn shown(capsule: &Capsule) -> Vec<Sphere> {
    let [a, b] = capsule.ends;
    let steps = (a.distance(b) / (0.3 * capsule.radius)).ceil() as u32;
    let sphere = |k: u32| Sphere { center: a.lerp(b, k as f32 / steps as f32), radius: 0.999 * capsule.radius };
    (0..=steps).map(sphere).collect()
}

pub fn scene(width: u32, height: u32) -> Scene {
    let chair = Object::spheres("chair", rods().0.iter().flat_map(shown).collect(), 1);
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 8.0, Vec3::NEG_Z * 8.0);
    Scene {
        camera: Camera {
            eye: Vec3::new(1.6, 1.8, 3.4),
            target: Vec3::Y * 0.6,
            up: Vec3::Y,
            projection: Projection::perspective(0.7),
        },
        width,
        height,
        materials: MATERIALS.map(|material| Material::Custom(Arc::new(material))).into(),
        objects: vec![
            Object::mesh("floor", floor, 0, Proxy::None),
            Object { strategy: Some(Strategy::Custom("capsules")), ..chair },
        ],
        lights: lights().map(|light| Light::Custom(Arc::new(light))).into(),
        ..Scene::default()
    }
}

/// The scene as one renders any other.
///
/// # Errors
/// [`RenderError`] where there is no such device.
pub fn renderer(width: u32, height: u32, device: Device) -> Result<Renderer, RenderError> {
    let settings = Settings { device, accuracy: Accuracy::new(0.003), ..Settings::default() };
    let mut renderer = Renderer::new(scene(width, height), Animation::default(), settings)?;
    renderer.put_strategy(Box::new(rods()));
    Ok(renderer)
}
