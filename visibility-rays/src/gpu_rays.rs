use lobe_core::wgsl::Piece;
use lobe_core::wgsl_numbers;
use shading::gpu::{GpuBlockers, GpuBuffer};
use visibility_mask::Contour;
use visibility_mask::wgsl::{CONTOUR, EDGES, FACET};

static RAYS: Piece = Piece::new(include_str!("rays.wgsl")).needs(&[&FACET]);
static COVERAGE: Piece = Piece::new(include_str!("rays_coverage.wgsl")).needs(&[&RAYS]);
static SPLAT: Piece = Piece::new(include_str!("rays_splat.wgsl"))
    .numbers(wgsl_numbers![GRAZING = Contour::GRAZING])
    .needs(&[&RAYS, &CONTOUR, &EDGES]);

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

    fn coverage(&self) -> &'static Piece {
        &COVERAGE
    }

    fn splat(&self) -> &'static Piece {
        &SPLAT
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
