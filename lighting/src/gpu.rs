//! Lights as GPUs see them.

use crate::{Light, SkyLight, SphereLight};
use glam::Vec3;
use lobe_core::gpu::GpuLight;
use lobe_core::{LightLobes as _, Outline, Sphere};

/// `frame.shape[1].w` says which kind a light is: of those that are cones, 0 for a sphere.
const SPOT: f32 = 1.0;
const SUN: f32 = 2.0;
const INSIDE: f32 = 3.0;
/// Of those in a plane, 0 for a polygon.
const DISC: f32 = 1.0;
const TUBE: f32 = 2.0;
const SKY: f32 = 3.0;
/// Of a light that is the same from everywhere, which is a cone all around.
const AMBIENT: f32 = 4.0;
/// The number of no object.
const NO_OBJECT: f32 = -1.0;

const IN_A_PLANE: [&str; 2] = ["flat lights", include_str!("plane_lights.wgsl")];

impl GpuLight for SphereLight {
    const NAME: &'static str = "sphere lights";
    const WGSL: &'static str = include_str!("sphere_light.wgsl");

    fn gpu_radiance(&self) -> [f32; 3] {
        self.radiance.to_array()
    }
}

impl GpuLight for Light {
    const NAME: &'static str = "lights";
    const WGSL: &'static str = include_str!("light.wgsl");

    fn gpu_text(lights: &[&Self]) -> Result<[&'static str; 2], &'static str> {
        if lights.iter().any(|light| light.gpu_roundness().is_some()) {
            return Ok(IN_A_PLANE);
        }
        let is_sphere = |light: &&Self| matches!(light, Self::Sphere(_));
        Ok(if lights.iter().all(is_sphere) { [SphereLight::NAME, SphereLight::WGSL] } else { [Self::NAME, Self::WGSL] })
    }

    fn gpu_roundness(&self) -> Option<f32> {
        match self {
            Self::Flat(light) => Some(light.roundness()),
            Self::Tube(light) => Some(light.roundness()),
            Self::Sky(SkyLight::Patch(patch)) => Some(patch.roundness()),
            Self::Enclosed(light) => light.light.gpu_roundness(),
            _ => None,
        }
    }

    fn gpu_bounds(&self) -> Sphere {
        match self {
            Self::Flat(_) | Self::Tube(_) => Outline::sphere_around(self.bounds()),
            Self::Enclosed(light) => light.light.gpu_bounds(),
            light => light.bounds(),
        }
    }

    fn gpu_radiance(&self) -> [f32; 3] {
        self.full_radiance().to_array()
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        match self {
            Self::Spot(light) => {
                vec![light.axis.extend(0.0).to_array(), [light.cos[0], light.cos[1], 0.0, SPOT]]
            }
            Self::Sun(light) | Self::Sky(SkyLight::Sun(light)) => {
                let cone = light.seen();
                vec![light.toward.extend(0.0).to_array(), [cone.one_minus_cos, cone.distance, 0.0, SUN]]
            }
            Self::Ambient(_) => vec![[0.0; 4], [0.0, 0.0, 0.0, AMBIENT]],
            Self::Sky(SkyLight::Patch(patch)) => {
                shape_of(patch.axis.extend(0.0).to_array(), [4.0, 1.0, NO_OBJECT, SKY], &patch.corners())
            }
            Self::Enclosed(inside) if inside.light.gpu_roundness().is_some() => {
                let mut shape = inside.light.gpu_shape();
                shape[1][2] = inside.object as f32;
                shape
            }
            Self::Enclosed(inside) => vec![[inside.object as f32, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, INSIDE]],
            Self::Flat(light) => {
                let side = light.normal().extend(f32::from(u8::from(light.two_sided))).to_array();
                match light.as_disc() {
                    (_, Some(radius)) => vec![side, [radius, 0.0, NO_OBJECT, DISC]],
                    _ => {
                        let has_places = f32::from(u8::from(light.image().is_some()));
                        shape_of(side, [light.corners().len() as f32, has_places, NO_OBJECT, 0.0], light.corners())
                    }
                }
            }
            Self::Tube(light) => shape_of([0.0; 4], [light.radius, 0.0, NO_OBJECT, TUBE], &light.ends),
            Self::Sphere(_) => Vec::new(),
        }
    }
}

fn shape_of(first: [f32; 4], second: [f32; 4], points: &[Vec3]) -> Vec<[f32; 4]> {
    let points = points.iter().map(|p| p.extend(0.0).to_array());
    [first, second].into_iter().chain(points).collect()
}
