//! A chair of capsules on a velvet floor under two spots.

use crate::{Capsule, Capsules, Spot, Velvet};
use cosine_lobes::brdf::Material;
use cosine_lobes::glam::Vec3;
use cosine_lobes::lobe_core::{Accuracy, Sphere};
use cosine_lobes::render_cpu::{CpuShader, GBuffer, World};
use cosine_lobes::render_gpu::{Gpu, GpuShader, Occlusion};
use cosine_lobes::scene::{Camera, Frame, Mesh, Object, Proxy, Scene, Shade};
use cosine_lobes::visibility_mask::MaskVisibility;
use std::error::Error;

/// The scene, with own types.
pub struct Own {
    pub scene: Scene,
    pub materials: Vec<Velvet>,
    pub lights: Vec<Spot>,
    pub capsules: Capsules,
}

impl Own {
    pub fn new(width: u32, height: u32) -> Self {
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
        let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 8.0, Vec3::NEG_Z * 8.0);
        // The camera sees meshes: strings of spheres stand for the rods.
        let balls = |c: &Capsule| {
            let [a, b] = c.ends;
            let steps = (a.distance(b) / (0.3 * c.radius)).ceil() as u32;
            let ball = move |k: u32| Sphere { center: a.lerp(b, k as f32 / steps as f32), radius: 0.999 * c.radius };
            (0..=steps).map(ball).collect::<Vec<_>>()
        };
        let chair = Object::spheres("chair", rods.iter().flat_map(balls).collect(), 1);
        let spot = |center: Vec3, radiance: Vec3| {
            let direction = (Vec3::Y * 0.5 - center).normalize();
            Spot { ball: Sphere { center, radius: 0.35 }, radiance, direction, inner: 0.93, outer: 0.86 }
        };
        Self {
            scene: Scene {
                camera: Camera { eye: Vec3::new(1.6, 1.8, 3.4), target: Vec3::Y * 0.6, up: Vec3::Y, vertical_fov: 0.7 },
                width,
                height,
                materials: vec![Material::lambert(Vec3::ONE); 2],
                objects: vec![Object::mesh("floor", floor, 0, Proxy::None), chair],
                lights: Vec::new(),
                ..Scene::default()
            },
            materials: vec![
                Velvet { kd: Vec3::new(0.35, 0.08, 0.12), ks: Vec3::new(0.3, 0.12, 0.15), exponent: 6.0 },
                Velvet { kd: Vec3::new(0.4, 0.32, 0.2), ks: Vec3::splat(0.2), exponent: 30.0 },
            ],
            lights: vec![
                spot(Vec3::new(-2.5, 4.0, 1.5), Vec3::new(60.0, 56.0, 50.0)),
                spot(Vec3::new(3.0, 3.5, 2.5), Vec3::new(20.0, 24.0, 32.0)),
            ],
            capsules: Capsules(rods),
        }
    }

    pub fn frame(&self) -> Frame<'_, Velvet, Spot> {
        Frame::new(&self.materials, &self.lights, Accuracy::new(0.003))
    }

    pub fn points(&self) -> GBuffer {
        GBuffer::new(&World::new(&self.scene), self.scene.width, self.scene.height, 1)
    }

    pub fn on_cpu(&self, points: &GBuffer) -> Result<Vec<Vec3>, Box<dyn Error>> {
        let mut radiance = vec![Vec3::ZERO; points.len()];
        let visibility = MaskVisibility::new(self.capsules.clone());
        CpuShader::new(visibility).shade(&points.points, &self.frame(), &mut radiance)?;
        Ok(radiance)
    }

    pub fn on_gpu(&self, gpu: &Gpu, points: &GBuffer) -> Result<Vec<Vec3>, Box<dyn Error>> {
        let mut radiance = vec![Vec3::ZERO; points.len()];
        let occlusion = Occlusion { blockers: &[&self.capsules], any_hit: None };
        GpuShader::new(gpu, occlusion)?.shade(&points.points, &self.frame(), &mut radiance)?;
        Ok(radiance)
    }
}
