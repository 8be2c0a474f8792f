use shading::gpu::{GpuBlockers, GpuBuffer};
use visibility_mask::wgsl::CONTOUR;

/// The `rays` strategy for a GPU: what [`RayBlockers`](crate::RayBlockers) is, of the scene whose rays a shader answers.
///
/// ```
/// use shading::gpu::GpuBlockers;
/// assert!(visibility_rays::GpuRays.asks_any_hit());
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct GpuRays;

impl GpuBlockers for GpuRays {
    fn name(&self) -> &'static str {
        "rays"
    }

    fn shared(&self) -> String {
        include_str!("rays.wgsl").to_owned()
    }

    fn coverage(&self) -> String {
        include_str!("rays_coverage.wgsl").to_owned()
    }

    fn splat(&self) -> String {
        include_str!("rays_splat.wgsl").to_owned()
    }

    fn splat_needs(&self) -> Vec<&'static str> {
        vec![CONTOUR]
    }

    fn has_edges(&self) -> bool {
        true
    }

    fn asks_any_hit(&self) -> bool {
        true
    }

    fn buffers(&self) -> Vec<GpuBuffer<'_>> {
        Vec::new()
    }
}
