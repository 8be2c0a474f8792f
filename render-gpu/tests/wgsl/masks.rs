//! The WGSL of masks and penumbrae without a GPU: every variant validates.

use crate::validated::module;
use crate::{FRAMED, QUEUED, SHADED};
use lighting::SphereLight;
use lobe_core::wgsl::join;
use render_gpu::wgsl::{INTEGRALS, PENUMBRA};
use shading::gpu::GpuLight as _;
use visibility_mask::{Fineness, wgsl};

/// Blockers and reflectance, as the kernel requires them.
const HOOKS: &str = "
    const LOOKS_AGAIN = true;
    const BLOCKERS_ARE_SEVERAL = true;
    fn blockers_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f { return vec4f(0.0); }
    fn blockers_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
        mask_block_span(mask, lane, 0.0, 1.0);
    }
    fn brdf_lobe_count(material: u32) -> u32 { return materials[0]; }
    fn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe { return Lobe(at.normal, 1.0, vec3f(1.0), 0.0); }";

/// All depths, and tolerances for each fineness.
fn variants() -> impl Iterator<Item = (u32, f32)> {
    (1..=visibility_mask::MAX_DEPTH).flat_map(|depth| [0.01, 0.003, 0.001].map(|tolerance| (depth, tolerance)))
}

#[test]
fn pieces_validate_alone() {
    for piece in [&wgsl::ROUND, &wgsl::FLAT, &wgsl::EDGES, &wgsl::FACET] {
        module(&join(&[piece]));
    }
    for (depth, tolerance) in variants() {
        let header = wgsl::header(depth, Fineness::broad(tolerance));
        module(&(join(&[&wgsl::MASK, &wgsl::ROUND]) + &header));
        module(&(join(&[&wgsl::TOTAL]) + &header));
    }
}

/// Among other things: no barrier in non-uniform control flow.
#[test]
fn penumbrae_validate() {
    for (depth, tolerance) in variants() {
        let (broad, narrow) = (Fineness::broad(tolerance), Fineness::narrow(tolerance));
        let headers = [wgsl::header(depth, broad), wgsl::header_of_lobes(depth, broad, narrow, false)];
        for (form, header) in [&wgsl::LAMBERT, &wgsl::ALIKE].into_iter().zip(&headers) {
            let text = join(&[&PENUMBRA, &INTEGRALS, SphereLight::WGSL, &wgsl::ROUND, form])
                + FRAMED
                + QUEUED
                + SHADED
                + HOOKS
                + header;
            let module = module(&text);
            let entry = &module.entry_points[0];
            let lanes = (1 << depth).max(32);
            assert_eq!((entry.name.as_str(), entry.workgroup_size), ("penumbra", [lanes, 1, 1]));
        }
    }
}

#[test]
fn lambert_alone_has_no_code_for_other_lobes() {
    assert!(!join(&[&wgsl::LAMBERT]).contains("glossy") && join(&[&wgsl::LOBES]).contains("glossy"));
}
