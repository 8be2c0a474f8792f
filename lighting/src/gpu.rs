//! Lights as GPUs see them.

use crate::{Light, SphereLight};
use lobe_core::gpu::GpuLight;

/// `frame.shape[1].w` says which kind a light is: 0 for a ball.
const SPOT: f32 = 1.0;
const SUN: f32 = 2.0;
const INSIDE: f32 = 3.0;

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

    fn gpu_text(lights: &[Self]) -> Result<[&'static str; 2], &'static str> {
        if lights.iter().all(|light| matches!(light, Self::Sphere(_))) {
            return Ok([SphereLight::NAME, SphereLight::WGSL]);
        }
        let own = |light: &Self| match light {
            Self::Inside(inside) => matches!(*inside.light, Self::Flat(_) | Self::Tube(_)),
            light => matches!(light, Self::Flat(_) | Self::Tube(_)),
        };
        if lights.iter().any(own) {
            return Err("rectangles, discs, polygons and tubes of light are lit by the CPU only");
        }
        if lights.iter().any(|light| matches!(light, Self::Sky(_) | Self::Ambient(_))) {
            return Err("environments and ambient light are lit by the CPU only");
        }
        Ok([Self::NAME, Self::WGSL])
    }

    fn gpu_radiance(&self) -> [f32; 3] {
        self.full_radiance().to_array()
    }

    fn gpu_shape(&self) -> [[f32; 4]; 2] {
        match self {
            Self::Spot(light) => [light.axis.extend(0.0).to_array(), [light.cos[0], light.cos[1], 0.0, SPOT]],
            Self::Sun(light) => {
                let cone = light.seen();
                [light.toward.extend(0.0).to_array(), [cone.one_minus_cos, cone.distance, 0.0, SUN]]
            }
            Self::Inside(light) => [[light.object as f32, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, INSIDE]],
            _ => [[0.0; 4]; 2],
        }
    }
}
