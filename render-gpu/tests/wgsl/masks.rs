//! The WGSL of masks and penumbrae without a GPU: every variant validates.

use crate::validated::module;
use lighting::SphereLight;
use lobe_core::wgsl::{GEOMETRY, LOBE, NO_OUTLINE, OUTLINE, SPECIAL};
use shading::gpu::GpuLight as _;
use visibility_mask::{Fineness, wgsl};

/// Blockers and reflectance, as the kernel requires them.
const HOOKS: &str = "
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
    for shown in [[wgsl::ROUND, NO_OUTLINE], [wgsl::FLAT, OUTLINE]] {
        module(&[[wgsl::SQUARE, GEOMETRY, LOBE, SPECIAL], [shown[0], shown[1], "", ""]].concat());
    }
    module(&[wgsl::EDGES, GEOMETRY]);
    for (depth, tolerance) in variants() {
        let header = wgsl::header(depth, Fineness::broad(tolerance));
        module(&[&header, wgsl::MASK, wgsl::SQUARE, wgsl::ROUND, NO_OUTLINE, GEOMETRY, LOBE, SPECIAL]);
        module(&[&header, wgsl::TOTAL]);
    }
}

/// Among other things: no barrier in non-uniform control flow.
#[test]
fn penumbrae_validate() {
    let kernel = [
        include_str!("../../src/kernels/frame.wgsl"),
        include_str!("../../src/kernels/queue.wgsl"),
        include_str!("../../src/kernels/integrals.wgsl"),
        include_str!("../../src/kernels/points.wgsl"),
        SphereLight::WGSL,
        include_str!("../../src/kernels/penumbra.wgsl"),
    ];
    let common =
        [wgsl::MASK, wgsl::SQUARE, wgsl::ROUND, NO_OUTLINE, wgsl::EDGES, wgsl::TOTAL, wgsl::FRACTION, wgsl::VISIBILITY];
    let core = [GEOMETRY, LOBE, SPECIAL, HOOKS];
    for (depth, tolerance) in variants() {
        let (broad, narrow) = (Fineness::broad(tolerance), Fineness::narrow(tolerance));
        let headers = [wgsl::header(depth, broad), wgsl::header_of_lobes(depth, broad, narrow, false)];
        let forms = [[wgsl::LAMBERT, ""], [wgsl::LOBES, wgsl::ALIKE]];
        for (form, header) in forms.iter().zip(&headers) {
            let module = module(&[[header.as_str()].as_slice(), &kernel, &common, &core, form].concat());
            let entry = &module.entry_points[0];
            let lanes = (1 << depth).max(32);
            assert_eq!((entry.name.as_str(), entry.workgroup_size), ("penumbra", [lanes, 1, 1]));
        }
    }
}

#[test]
fn lambert_alone_has_no_code_for_other_lobes() {
    assert!(!wgsl::LAMBERT.contains("glossy") && wgsl::LOBES.contains("glossy"));
}
