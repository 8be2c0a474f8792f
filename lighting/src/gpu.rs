//! Lights as GPUs see them: texts that several kinds share, and how those tell the kinds apart.

use crate::{Light, SphereLight};
use glam::Vec3;
use lobe_core::Sphere;
use shading::gpu::GpuLight;

macro_rules! shared {
    ($(#[$doc:meta])* $text:ident = $wgsl:expr; $($(#[$of:meta])* $name:ident = $value:literal;)*) => {
        $($(#[$of])* pub(crate) const $name: f32 = $value;)*
        $(#[$doc])*
        const $text: &str = concat!($wgsl, $("const ", stringify!($name), ": f32 = ", stringify!($value), ";\n"),*);
    };
}

shared! {
    /// Lights that are seen as cones. `frame.shape[1].w` says which kind one is; 0 is a sphere.
    CONES_WGSL = include_str!("light.wgsl");
    SPOT = 1.0;
    SUN = 2.0;
    /// Inside an object that it does not light.
    INSIDE = 3.0;
    /// The same from everywhere, which is a cone all around.
    AMBIENT = 4.0;
}

shared! {
    /// Lights that are seen as outlines; `frame.shape[1].w` again.
    PLANES_WGSL = include_str!("plane_lights.wgsl");
    PLANE_POLYGON = 0.0;
    PLANE_DISC = 1.0;
    PLANE_TUBE = 2.0;
    /// Its corners are the same for all receivers.
    PLANE_SKY = 3.0;
    /// Receivers nearer to a tube's middle line than so many radii may see one end before the other.
    TUBE_BESIDE = 1.05;
    /// Tangent of the angle beyond which a tube goes on unseen.
    TUBE_FAR = 60.0;
    /// The number of the object that the light is inside of, where there is none.
    PLANE_OUTSIDE = -1.0;
}

pub(crate) const CONES: [&str; 2] = ["lights", CONES_WGSL];
pub(crate) const PLANES: [&str; 2] = ["flat lights", PLANES_WGSL];

impl GpuLight for Light {
    const NAME: &'static str = "lights";
    const WGSL: &'static str = CONES_WGSL;

    fn gpu_text(&self, frame: &[Self]) -> Result<[&'static str; 2], String> {
        let text = |light: &Self| light.kind().wgsl();
        let own = text(self).ok_or_else(|| {
            let name = self.kind().name();
            format!("a GPU cannot shade with the light `{name}`: it has no WGSL")
        })?;
        // Spheres among other cones share their kernels.
        let is_alone = own[0] != SphereLight::NAME || frame.iter().all(|light| text(light) != Some(CONES));
        Ok(if is_alone { own } else { CONES })
    }

    fn gpu_roundness(&self) -> Option<f32> {
        self.kind().roundness()
    }

    fn gpu_bounds(&self) -> Sphere {
        self.kind().gpu_bounds()
    }

    fn gpu_radiance(&self) -> [f32; 3] {
        self.kind().full_radiance().to_array()
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        self.kind().gpu_shape()
    }
}

/// Two rows and points.
pub(crate) fn shape_of(first: [f32; 4], second: [f32; 4], points: &[Vec3]) -> Vec<[f32; 4]> {
    let points = points.iter().map(|p| p.extend(0.0).to_array());
    [first, second].into_iter().chain(points).collect()
}
