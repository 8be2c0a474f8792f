//! The layers of [`CpuShader`] beside the radiance.

#[cfg(doc)]
use crate::CpuShader;
use glam::Vec3;
use scene::Cancel;
use shading::TileContributions;

/// The layers that [`CpuShader::shade_with`] makes on request, and the request that stops it. Nothing by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShadeRequest<'a> {
    /// [`Layers::unshadowed`].
    pub unshadowed: bool,
    /// [`Layers::lights`].
    pub lights: bool,
    /// [`Layers::lobes`] and [`Layers::integrals`].
    pub counts: bool,
    /// Looked at for each group of 64 points and each light.
    pub cancel: Option<&'a Cancel>,
}

/// The layers that [`CpuShader::shade_with`] writes beside the radiance: one entry a point, lights point by point; empty where there was
/// no request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Radiance without blockers.
    pub unshadowed: Vec<Vec3>,
    /// Radiance of each light: `lights[point * light_count + light]`.
    pub lights: Vec<Vec3>,
    /// Visibility lobes made.
    pub lobes: Vec<u32>,
    /// Lobe integrals evaluated.
    pub integrals: Vec<u32>,
}

impl Layers {
    /// Adds the contributions of a light, to those layers that there are.
    pub(crate) fn add(&mut self, lit: &TileContributions, light: usize, lights: usize) {
        for (i, sum) in self.unshadowed.iter_mut().enumerate() {
            *sum += lit.get(i).0.unshadowed;
        }
        for (i, of_lights) in self.lights.chunks_exact_mut(lights).enumerate() {
            of_lights[light] += lit.radiance(i);
        }
        for (i, (lobes, integrals)) in self.lobes.iter_mut().zip(&mut self.integrals).enumerate() {
            let counts = lit.get(i).1;
            (*lobes, *integrals) = (*lobes + counts[0], *integrals + counts[1]);
        }
    }
}
