//! Lights as GPUs see them: texts that several kinds share, and how those tell the kinds apart.

use crate::{Light, SphereLight};
use glam::Vec3;
use lobe_core::wgsl::{GEOMETRY, OUTLINE, Piece};
use lobe_core::{Sphere, wgsl_numbers};
use shading::gpu::{GpuLight, GpuText};

/// The kinds of lights that are seen as cones: `frame.shape[1].w` says which kind one is; 0 is a sphere.
pub(crate) const SPOT: f32 = 1.0;
pub(crate) const SUN: f32 = 2.0;
/// Inside an object that it does not light.
pub(crate) const INSIDE: f32 = 3.0;
/// The same from everywhere, which is a cone all around.
pub(crate) const AMBIENT: f32 = 4.0;

/// The kinds of lights that are seen as outlines; `frame.shape[1].w` again.
pub(crate) const PLANE_POLYGON: f32 = 0.0;
pub(crate) const PLANE_DISC: f32 = 1.0;
pub(crate) const PLANE_TUBE: f32 = 2.0;
/// Its corners are the same for all receivers.
pub(crate) const PLANE_SKY: f32 = 3.0;
/// Receivers nearer to a tube's middle line than this number of radii see it as from there: its outline would not end nearer to them.
pub(crate) const TUBE_BESIDE: f32 = 1.1;
/// How much less than a radius a tube's surface is before its middle line in the mean, from far away, in radii.
pub(crate) const TUBE_DEPTH: f32 = 1.0 - core::f32::consts::FRAC_PI_4;
/// How long a tube's nearer end looks beside its body for the plane in which both are, and how far out the plane meets that end, in radii: by the least
/// errors of own radiance in rooms where plates, caps, boards, tables and spheres stand before, around and across tubes.
pub(crate) const TUBE_END: f32 = 1.25;
pub(crate) const TUBE_OUT: f32 = 0.6;
/// Parts of a tube farther off than this many times the distance of its nearest point are left out.
pub(crate) const TUBE_FARTHEST: f32 = 1e4;
/// Sides of the arcs of both ends.
pub(crate) const TUBE_STEPS: usize = 12;
/// The number of the object that the light is inside of, where there is none.
pub(crate) const PLANE_OUTSIDE: f32 = -1.0;

static CONES_WGSL: Piece = Piece::new(include_str!("light.wgsl"))
    .numbers(wgsl_numbers![SPOT = SPOT, SUN = SUN, INSIDE = INSIDE, AMBIENT = AMBIENT])
    .needs(&[&GEOMETRY]);
static PLANES_WGSL: Piece = Piece::new(include_str!("plane_lights.wgsl"))
    .numbers(wgsl_numbers![
        PLANE_POLYGON = PLANE_POLYGON,
        PLANE_DISC = PLANE_DISC,
        PLANE_TUBE = PLANE_TUBE,
        PLANE_SKY = PLANE_SKY,
        TUBE_BESIDE = TUBE_BESIDE,
        TUBE_DEPTH = TUBE_DEPTH,
        TUBE_END = TUBE_END,
        TUBE_OUT = TUBE_OUT,
        TUBE_FARTHEST = TUBE_FARTHEST,
        TUBE_STEPS = TUBE_STEPS,
        PLANE_OUTSIDE = PLANE_OUTSIDE,
    ])
    .needs(&[&OUTLINE]);

pub(crate) const CONES: GpuText = ("lights", &CONES_WGSL);
pub(crate) const PLANES: GpuText = ("flat lights", &PLANES_WGSL);

impl GpuLight for Light {
    const NAME: &'static str = "lights";
    const WGSL: &'static Piece = &CONES_WGSL;

    fn gpu_text(&self, frame: &[Self]) -> Result<GpuText, String> {
        let text = |light: &Self| light.kind().wgsl();
        let own = text(self).ok_or_else(|| {
            let name = self.kind().name();
            format!("a GPU cannot shade with the light `{name}`: it has no WGSL")
        })?;
        // Spheres among other cones share their kernels.
        let is_alone = own.0 != SphereLight::NAME || frame.iter().all(|light| text(light) != Some(CONES));
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
