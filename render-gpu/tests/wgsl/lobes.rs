//! The WGSL without a GPU: pieces validate, layouts are the same as in Rust.

use crate::validated::module;
use crate::{FRAMED, QUEUED, SHADED};
use lighting::SphereLight;
use lobe_core::wgsl::{self, join};
use render_gpu::wgsl::{PAPER_CLASSIFY, PAPER_PENUMBRA};
use shading::gpu::GpuLight as _;

/// Size and member offsets of a struct.
fn layout(module: &naga::Module, name: &str) -> (u32, Vec<(String, u32)>) {
    for (_, ty) in module.types.iter() {
        if let (Some(found), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner)
            && found == name
        {
            let members = members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset));
            return (*span, members.collect());
        }
    }
    panic!("no struct {name}");
}

#[test]
fn lobe_core_pieces_validate() {
    for piece in
        [&wgsl::SPECIAL, &wgsl::GEOMETRY, &wgsl::LOBE, &wgsl::MICROFACETS, &wgsl::MICROFACETS_GRAIN, &wgsl::OUTLINE]
    {
        module(&join(&[piece]));
    }
}

#[test]
fn a_lobe_has_rusts_layout() {
    use lobe_core::PackedLobe;
    use std::mem::{offset_of, size_of};
    let (size, members) = layout(&module(&join(&[&wgsl::LOBE])), "Lobe");
    assert_eq!(size as usize, size_of::<PackedLobe>());
    let want = [
        ("axis", offset_of!(PackedLobe, axis)),
        ("exponent", offset_of!(PackedLobe, exponent)),
        ("flux", offset_of!(PackedLobe, flux)),
        ("kind", offset_of!(PackedLobe, kind)),
    ];
    assert_eq!(members, want.map(|(name, offset)| (name.to_owned(), offset as u32)));
}

#[test]
fn integrals_validate() {
    for cap in [&wgsl::CAP_LAMBERT, &wgsl::CAP_NO_MICROFACETS, &wgsl::CAP_MICROFACETS] {
        module(&join(&[cap]));
        for outline in [&wgsl::OUTLINE_MICROFACETS, &wgsl::OUTLINE_NO_MICROFACETS] {
            module(&join(&[cap, outline, &wgsl::OUTLINE_PLAIN]));
        }
    }
    module(&join(&[&wgsl::CAP_BRUSHED]));
    module(&join(&[&wgsl::CAP_BRUSHED, &wgsl::OUTLINE_BRUSHED, &wgsl::OUTLINE_PLAIN]));
}

/// The tables, reflectance and blockers, as the paper's kernels require them.
const HOOKS: &str = "
    @group(0) @binding(9) var<storage, read> paper_tables: array<vec2f>;
    fn blockers_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 { return PARTIAL; }
    fn brdf_lobe_count(material: u32) -> u32 { return materials[0]; }
    fn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe { return Lobe(at.normal, 1.0, vec3f(1.0), 0.0); }";

#[test]
fn kernels_of_the_paper_validate() {
    use visibility_mask::wgsl as masks;
    module(&(join(&[&PAPER_CLASSIFY, SphereLight::WGSL, &wgsl::NO_OUTLINE]) + FRAMED + QUEUED + SHADED + HOOKS));
    let splat = "fn blockers_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
        mask_block_span(mask, lane, 0.0, 1.0);
    }";
    for depth in 1..=visibility_mask::MAX_DEPTH {
        let header = paper::wgsl::header(depth);
        let module = module(
            &(join(&[&PAPER_PENUMBRA, SphereLight::WGSL, &masks::ROUND])
                + FRAMED
                + QUEUED
                + SHADED
                + HOOKS
                + splat
                + &header),
        );
        let entry = &module.entry_points[0];
        assert_eq!(entry.workgroup_size, [if depth < 5 { 32 } else { 64 }, 1, 1]);
    }
}

#[test]
fn a_receiver_has_rusts_layout() {
    use render_gpu::GpuReceiver;
    use std::mem::{offset_of, size_of};
    let module =
        module(&(join(&[&wgsl::GEOMETRY]) + "@group(0) @binding(0) var<storage, read> points: array<Receiver>;"));
    let (size, members) = layout(&module, "Receiver");
    assert_eq!(size as usize, size_of::<GpuReceiver>());
    let want = [
        ("position", offset_of!(GpuReceiver, position)),
        ("object", offset_of!(GpuReceiver, object)),
        ("normal", offset_of!(GpuReceiver, normal)),
        ("material", offset_of!(GpuReceiver, material)),
        ("face", offset_of!(GpuReceiver, face)),
        ("pad0", offset_of!(GpuReceiver, pad0)),
        ("view", offset_of!(GpuReceiver, view)),
        ("pad1", offset_of!(GpuReceiver, pad1)),
    ];
    assert_eq!(members, want.map(|(name, offset)| (name.to_owned(), offset as u32)));
}
