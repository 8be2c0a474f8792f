//! The WGSL of sphere blockers without a GPU: every composed variant validates, layouts are the same as in Rust.

use crate::validated::module;
use crate::{FRAMED, QUEUED, SHADED};
use lighting::SphereLight;
use lobe_core::wgsl::{NO_OUTLINE, join};
use render_gpu::wgsl::{ALL_LOBES, ARGS, CLASSIFY, FRAME, INTEGRALS};
use shading::gpu::GpuLight as _;
use visibility_mask::{Fineness, wgsl as masks};
use visibility_spheres::{BlockerSphere, wgsl};

/// The buffers as in kernels that shade.
const BUFFERS: &str = "@group(0) @binding(16) var<storage, read> spheres: array<BlockerSphere>;
    @group(0) @binding(17) var<storage, read> spheres_bounds: array<vec4f>;
    @group(0) @binding(18) var<storage, read> spheres_lists: array<u32>;";

/// The hook of `classify`, with spheres only.
const HOOK: &str = "fn blockers_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {
    return spheres_coverage(tile, at, cone);
}";

#[test]
fn culling_validates() {
    let points = "@group(0) @binding(1) var<storage, read> points: array<Receiver>;";
    let of_bounds = BUFFERS.replace("read> spheres_bounds", "read_write> spheres_bounds");
    let of_lists = BUFFERS.replace("read> spheres_lists", "read_write> spheres_lists");
    let bounds = module(&(join(&[&wgsl::BOUNDS]) + &of_bounds));
    let cull = module(&(join(&[&wgsl::CULL, &FRAME]) + FRAMED + &of_lists + points));
    let sizes = "@group(0) @binding(5) var<storage, read_write> args: array<u32>;";
    let args = module(&(join(&[&ARGS]) + FRAMED + QUEUED + sizes));
    let groups = [(&bounds, "bounds", 64), (&cull, "cull", 64), (&args, "args_of_queue", 1)];
    for (module, name, threads) in groups {
        assert_eq!((module.entry_points[0].name.as_str(), module.entry_points[0].workgroup_size[0]), (name, threads));
    }
}

#[test]
fn classification_validates() {
    let stub = "fn light_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 { return cone.one_minus_cos; }";
    let lambert = brdf::Material::lambert(glam::Vec3::ONE).model().wgsl().expect("lambert");
    let (materials, reflectance) = brdf::wgsl::compose(&[lambert]);
    let pieces = [&CLASSIFY, &ALL_LOBES, &INTEGRALS, SphereLight::WGSL, &NO_OUTLINE, &wgsl::SPHERES];
    let text = join(&[pieces.as_slice(), &materials].concat())
        + FRAMED
        + QUEUED
        + SHADED
        + BUFFERS
        + HOOK
        + stub
        + &reflectance;
    assert_eq!(module(&text).entry_points[0].workgroup_size, [64, 1, 1]);
}

#[test]
fn splats_validate_at_all_depths() {
    for depth in 1..=visibility_mask::MAX_DEPTH {
        for coarse in [false, true] {
            let header = masks::header(depth, Fineness { coarse, ..Fineness::FINE });
            module(&(join(&[&wgsl::SPHERES_SPLAT, &masks::ROUND, &FRAME]) + FRAMED + &header + BUFFERS));
        }
    }
}

#[test]
fn a_blocker_has_rusts_layout() {
    use std::mem::{offset_of, size_of};
    let module = module(&join(&[&wgsl::PACKED]));
    let found = module.types.iter().find_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some("BlockerSphere") => {
            Some((*span, members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect::<Vec<_>>()))
        }
        _ => None,
    });
    let want = [
        ("center", offset_of!(BlockerSphere, center)),
        ("radius", offset_of!(BlockerSphere, radius)),
        ("own_offset", offset_of!(BlockerSphere, own_offset)),
        ("own_radius", offset_of!(BlockerSphere, own_radius)),
        ("object", offset_of!(BlockerSphere, object)),
        ("own_distance", offset_of!(BlockerSphere, own_distance)),
        ("caster", offset_of!(BlockerSphere, caster)),
        ("pad", offset_of!(BlockerSphere, pad)),
    ];
    let want = want.map(|(name, offset)| (name.to_owned(), offset as u32)).to_vec();
    assert_eq!(found, Some((size_of::<BlockerSphere>() as u32, want)));
}
