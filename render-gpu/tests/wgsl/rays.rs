//! The WGSL of rays without a GPU.

use crate::validated::module;
use lobe_core::wgsl::{GEOMETRY, LOBE, NO_OUTLINE, SPECIAL};
use render_gpu::wgsl::{ANY_HIT, BVH, TRACE};
use shading::gpu::GpuBlockers;
use visibility_rays::GpuRays;

#[test]
fn visible_points_validate() {
    module(&[BVH]);
    for stack in [32, 64, 1024] {
        module(&[TRACE, &format!("const STACK = {stack}u;"), BVH, GEOMETRY]);
    }
}

/// Masks of all sizes; the workgroup's memory is within the limits of every device.
#[test]
fn shadow_rays_validate() {
    const STACK: &str = "const STACK = 32u;";
    let [rays, coverage, splat] = [GpuRays.shared(), GpuRays.coverage(), GpuRays.splat()];
    module(&[&rays, &coverage, ANY_HIT, STACK, BVH, GEOMETRY, visibility_mask::wgsl::FACET]);
    for (depth, coarse) in (1..=6).flat_map(|depth| [(depth, false), (depth, true)]) {
        let header = visibility_mask::wgsl::header(
            depth,
            visibility_mask::Fineness { coarse, ..visibility_mask::Fineness::FINE },
        );
        use visibility_mask::wgsl::{CONTOUR, EDGES, FACET, MASK, ROUND, SQUARE};
        let masks = [header.as_str(), SQUARE, ROUND, NO_OUTLINE, MASK, CONTOUR, EDGES, FACET];
        let main = "@compute @workgroup_size(LANES) fn main(@builtin(local_invocation_index) lane: u32) {
            let light = Cone(vec3f(0.0, 0.0, 1.0), 0.01, 5.0);
            var at: Receiver;
            let mask = mask_reset(square_facing(light, vec3f(1.0)), lane, light.axis);
            rays_splat(lane, 0u, at, light, mask);
        }";
        let pieces = [&masks[..], &[&splat, &rays, ANY_HIT, STACK, BVH, GEOMETRY, LOBE, SPECIAL, main]].concat();
        module(&pieces);
    }
}

/// The rim's directions are those of `Contour`: 32 around the light, from half a step on; the text lists the first quadrant.
#[test]
fn rim_is_rusts() {
    for k in 0..8 {
        let (sin, cos) = (core::f64::consts::TAU * (f64::from(k) + 0.5) / 32.0).sin_cos();
        assert!(visibility_mask::wgsl::CONTOUR.contains(&format!("vec2f({cos:.11}, {sin:.11})")), "{cos} {sin}");
    }
}
