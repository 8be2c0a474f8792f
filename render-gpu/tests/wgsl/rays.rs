//! The WGSL of rays without a GPU.

use crate::validated::module;
use lobe_core::wgsl::{constant, join};
use render_gpu::wgsl::{ANY_HIT, TRACE};
use shading::gpu::GpuBlockers;
use visibility_rays::GpuRays;

const WORLD: &str = "@group(0) @binding(10) var<storage, read> nodes: array<BvhNode>;
    @group(0) @binding(14) var<storage, read> primitives: array<Primitive>;";

#[test]
fn visible_points_validate() {
    const SEEN: &str = "@group(0) @binding(0) var<uniform> view: View;
        @group(0) @binding(1) var<storage, read_write> points: array<Receiver>;
        @group(0) @binding(15) var<storage, read> normals: array<f32>;";
    for stack in [32_u32, 64, 1024] {
        module(&(join(&[&TRACE]) + WORLD + SEEN + &constant("STACK", &stack)));
    }
}

/// Masks of all sizes; the workgroup's memory is within the limits of every device.
#[test]
fn shadow_rays_validate() {
    const STACK: &str = "const STACK = 32u;";
    module(&(join(&[GpuRays.coverage(), &ANY_HIT]) + WORLD + STACK));
    for (depth, coarse) in (1..=6).flat_map(|depth| [(depth, false), (depth, true)]) {
        let header = visibility_mask::wgsl::header(
            depth,
            visibility_mask::Fineness { coarse, ..visibility_mask::Fineness::FINE },
        );
        let main = "@compute @workgroup_size(LANES) fn main(@builtin(local_invocation_index) lane: u32) {
            let light = Cone(vec3f(0.0, 0.0, 1.0), 0.01, 5.0);
            var at: Receiver;
            let mask = mask_reset(square_facing(light, vec3f(1.0)), lane, light.axis);
            rays_splat(lane, 0u, at, light, mask);
        }";
        module(&(join(&[GpuRays.splat(), &ANY_HIT, &visibility_mask::wgsl::ROUND]) + WORLD + STACK + &header + main));
    }
}
