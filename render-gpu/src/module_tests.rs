//! Tests of every kernel that can be composed, without a GPU.

use super::*;
use crate::binding::Access;
use crate::layout::GpuFrame;
use crate::occlusion::pass_text;
use crate::{GpuError, inlined, validated};
use brdf::wgsl::ModelWgsl;
use brdf::{Material, MetallicRoughness};
use glam::Vec3;
use lighting::{FlatLight, Light, SphereLight};
use lobe_core::Sphere;
use naga::valid::Capabilities;
use naga::{AddressSpace, StorageAccess, TypeInner};
use shading::gpu::{GpuBlockers, GpuContents};
use visibility_mask::sky::SkyResolution;
use visibility_shadowmap::PackedMaps;
use visibility_silhouettes::{GpuSilhouettes, SilhouetteMesh};
use visibility_spheres::SphereBlockers;

/// Validates a kernel. Its bindings must be exactly the buffers that it declares.
#[track_caller]
fn check(name: &str, text: &Text) -> naga::Module {
    let Text { entry, text, bindings, .. } = text;
    let (module, info) = validated::with_info(name, text, Capabilities::all());
    // The limit that every device has.
    let shared = module.global_variables.iter().filter(|(_, g)| g.space == AddressSpace::WorkGroup);
    let shared: u32 = shared.map(|(_, g)| module.types[g.ty].inner.size(module.to_ctx())).sum();
    assert!(shared <= 16384, "{name}: {shared} bytes of a workgroup's memory");
    let number = module.entry_points.iter().position(|e| e.name == *entry).expect("the entry point");
    let mut declared: Vec<(u32, Access)> = Vec::new();
    for (handle, variable) in module.global_variables.iter() {
        let Some(binding) = &variable.binding else { continue };
        // The frame is always declared with the queue.
        if variable.name.as_deref() != Some("frame") && info.get_entry_point(number)[handle].is_empty() {
            panic!("{name}: {:?} is declared and not used", variable.name);
        }
        let access = match variable.space {
            AddressSpace::Uniform => Access::Uniform,
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Access::Write,
            _ => Access::Read,
        };
        declared.push((binding.binding, access));
    }
    let mut told: Vec<(u32, Access)> = bindings.iter().map(|(slot, access)| (slot.binding(), *access)).collect();
    declared.sort_by_key(|d| d.0);
    told.sort_by_key(|t| t.0);
    assert_eq!(told, declared, "{name}");
    module
}

const LIGHT: GpuText = (SphereLight::NAME, SphereLight::WGSL);

/// Materials of these models.
fn set(models: &[ModelWgsl]) -> MaterialText {
    let name = models.iter().map(|model| model.name).collect::<Vec<_>>().join(" + ");
    let has_microfacets = models.iter().any(|model| model.has_microfacets);
    let has_grain = models.iter().any(|model| model.has_grain);
    let (needs, wgsl) = brdf::wgsl::compose(models);
    MaterialText { is_lambert: name == "lambert", has_microfacets, has_grain, name, wgsl, needs }
}

/// Each model alone, the first two, all, and those with a grain beside others.
fn choices() -> Vec<Vec<ModelWgsl>> {
    let built_in = Material::built_in();
    let mut all: Vec<ModelWgsl> = built_in.iter().filter_map(|material| material.model().cosine_wgsl()).collect();
    let facets = built_in.iter().filter_map(|material| material.model().wgsl());
    all.extend(facets.filter(|model| model.has_microfacets));
    let metal = MetallicRoughness::default().with_anisotropy(0.5).expect("in range");
    let coated = metal.clone().with_clearcoat(1.0, 0.1).expect("in range");
    let brushed = [metal, coated].map(|metal| Material::from(metal).model().wgsl().expect("for a GPU"));
    let brushed = all[..2].iter().chain(&brushed).cloned().collect();
    let alone = all.iter().map(|model| vec![model.clone()]);
    alone.chain([all[..2].to_vec(), all.clone(), brushed]).collect()
}

/// A strategy whose slots begin with this one.
fn own(blockers: &dyn GpuBlockers, mut first: u32, pages: GpuPages) -> OwnText {
    let buffers = blockers.buffers().into_iter().map(|buffer| {
        let pages = matches!(buffer.contents, GpuContents::Pages { .. }).then_some(pages);
        let buffer = OwnBuffer { first, pages, name: buffer.name, element: buffer.element };
        first += pages.map_or(1, GpuPages::count);
        buffer
    });
    let buffers = buffers.collect();
    OwnText::new(blockers, buffers)
}

fn spheres() -> SphereBlockers {
    SphereBlockers::new(&[Sphere { center: Vec3::Y, radius: 0.5 }], &[0], &[])
}

/// Whether a choice of materials, of strategies, of depth and of tolerance is tried. Each three of the four are, in all ways, by a quarter of all kernels. At
/// the depths of patches and of openings every second is: so all materials meet all strategies there beside a tolerance without the paper's tables.
fn is_tried([materials, strategies, depth, tolerance]: [usize; 4]) -> bool {
    let each = if [4, 5].contains(&depth) { 2 } else { 4 };
    (materials + strategies + depth + tolerance) % each == 0
}

/// Variants of the kernels by materials, strategies, depth and tolerance, without [some](is_tried).
fn variants() -> impl Iterator<Item = Variant> {
    let mut all = Vec::new();
    for (number, models) in choices().iter().enumerate() {
        let materials = set(models);
        for (strategies, (has_spheres, has_maps)) in
            [(true, false), (false, true), (true, true), (false, false)].into_iter().enumerate()
        {
            for depth in 1..=6 {
                let pages = if depth % 2 == 0 { GpuPages::ONE } else { GpuPages::of(3 << 27, 1 << 27) };
                let mut parts = vec![match has_spheres {
                    true => own(&spheres(), 0, pages),
                    false => own(&visibility_rays::GpuRays, 0, pages),
                }];
                if has_maps {
                    parts.push(own(&PackedMaps::default(), 3, pages));
                }
                let tolerances = [(0.001, false), (0.003, false), (0.01, false), (0.003, true)].into_iter().enumerate();
                for (_, (tolerance, paper)) in tolerances.filter(|(k, _)| is_tried([number, strategies, depth, *k])) {
                    all.push(Variant {
                        depth: depth as u32,
                        fineness: [Fineness::broad(tolerance), Fineness::narrow(tolerance)],
                        materials: materials.clone(),
                        light: LIGHT,
                        shown: Shown::Cone,
                        own: parts.clone(),
                        stack: (!has_spheres).then_some(64),
                        paper,
                        is_patch: depth == 4 && !paper,
                        looks_again: depth == 5 && !paper,
                    });
                }
            }
        }
    }
    all.into_iter()
}

/// Passes of the blockers that have some.
#[test]
fn passes_are_valid() {
    let spheres = spheres();
    let buffers = own(&spheres, 0, GpuPages::ONE).buffers;
    let passes = spheres.passes();
    assert_eq!(passes.len(), 2);
    for pass in passes {
        let text = pass_text(&pass, &buffers).expect("its buffers are there");
        check(pass.entry, &text);
    }
    let lost = GpuPass { reads: vec!["spheres", "lost"], ..spheres.passes().remove(0) };
    assert!(matches!(pass_text(&lost, &buffers), Err(GpuError::Unsupported(why)) if why.contains("lost")));
}

#[test]
fn every_kernel_is_valid() {
    check("args", &args());
    for variant in variants() {
        check(&format!("classify {variant:?}"), &classify(&variant));
        check(&format!("penumbra {variant:?}"), &penumbra(&variant));
    }
}

fn uses(variant: &Variant, name: &str) -> bool {
    variant.own.iter().any(|own| own.name == name)
}

/// Lights with outlines.
fn flat_variants() -> impl Iterator<Item = Variant> {
    let panel = FlatLight::rectangle(Vec3::Z, Vec3::X, Vec3::Y, Vec3::ONE).expect("a rectangle");
    let light = Light::from(panel).gpu_text(&[]).expect("for a GPU");
    let of = |v: &Variant| !v.paper && !uses(v, "maps") && [1, 5, 6].contains(&v.depth);
    let of_shown =
        move |variant: Variant| [Shown::Outline, Shown::Image].map(|shown| Variant { light, shown, ..variant.clone() });
    variants().filter(of).flat_map(of_shown)
}

#[test]
fn kernels_of_flat_lights_are_valid() {
    for variant in flat_variants() {
        check(&format!("classify {variant:?}"), &classify(&variant));
        check(&format!("penumbra {variant:?}"), &penumbra(&variant));
    }
}

/// The most expressions and statements of a kernel after inlining: drivers take time to compile them, and a software one minutes. Those for openings
/// count in all kernels here; drivers leave them out where a shader does not look again.
const LARGEST: usize = 55_500;

/// A strategy unknown to this crate, with passes and rays of its own.
#[test]
fn kernels_of_silhouettes_are_valid_and_small() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let blockers = GpuSilhouettes::new(&[SilhouetteMesh::new(0, &corners, &[[0, 1, 2]])]);
    let mut own = own(&blockers, 8, GpuPages::ONE);
    // As for ten million edges in a thousand objects.
    own.constants = constant("SILHOUETTES_DEPTH", &12_u32);
    let is_some = |v: &Variant| v.stack.is_none() && [1, 5, 6].contains(&v.depth);
    for variant in variants().chain(flat_variants()).filter(is_some) {
        let all = variant.own.iter().chain([&own]).cloned().collect();
        let variant = Variant { own: all, stack: Some(64), ..variant };
        for text in [classify(&variant), penumbra(&variant)] {
            let size = inlined::size(&check(&text.name, &text));
            assert!(size <= LARGEST, "{}: {size}", text.name);
        }
    }
}

/// Sums of skies, by all materials, before nothing, silhouettes, spheres and both; each device has room for their workgroups.
#[test]
fn kernels_of_skies_are_valid_and_small() {
    check("args of a sky", &sky_args());
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let silhouettes = GpuSilhouettes::new(&[SilhouetteMesh::new(0, &corners, &[[0, 1, 2]])]);
    let mut silhouettes = own(&silhouettes, 8, GpuPages::ONE);
    silhouettes.constants = constant("SILHOUETTES_DEPTH", &12_u32);
    let spheres = own(&spheres(), 0, GpuPages::ONE);
    let both = vec![spheres.clone(), silhouettes.clone()];
    for models in choices() {
        for (own, stack) in [
            (vec![], None),
            (vec![spheres.clone()], None),
            (vec![silhouettes.clone()], Some(64)),
            (both.clone(), Some(64)),
        ] {
            for tolerance in [0.01, 0.005, 0.003, 0.001] {
                let header = masks::sky_header(SkyResolution::of_tolerance(tolerance), 16).expect("room");
                let variant = SkyVariant { header, materials: set(&models), own: own.clone(), stack };
                let text = sky(&variant);
                let size = inlined::size(&check(&text.name, &text));
                assert!(size <= LARGEST, "{}: {size}", text.name);
            }
        }
    }
    // Too fine, or with too many lobes: none.
    assert!(masks::sky_header(SkyResolution::new(1024, 512), 2).is_none());
    assert!(masks::sky_header(SkyResolution::new(64, 64), 17).is_none());
}

/// A strategy's pieces name all that they call: nothing comes from another strategy by chance.
#[test]
fn each_strategy_is_valid_alone() {
    let silhouettes = GpuSilhouettes::new(&[SilhouetteMesh::new(0, &[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]])]);
    let all: [(&dyn GpuBlockers, _); 4] = [
        (&spheres(), None),
        (&PackedMaps::default(), None),
        (&visibility_rays::GpuRays, Some(64)),
        (&silhouettes, Some(64)),
    ];
    for (blockers, stack) in all {
        let own = vec![own(blockers, 0, GpuPages::ONE)];
        // With maps they would be the same kernels once more.
        let is_some = |v: &Variant| v.stack.is_none() && v.depth == 5 && !uses(v, "maps");
        for variant in variants().chain(flat_variants()).filter(is_some) {
            let variant = Variant { own: own.clone(), stack, ..variant };
            check("classify", &classify(&variant));
            check("penumbra", &penumbra(&variant));
        }
    }
}

#[test]
fn a_kernel_has_only_what_its_scene_uses() {
    let lambert = Variant {
        depth: 5,
        fineness: [Fineness::FINE; 2],
        materials: set(&choices()[0]),
        light: LIGHT,
        shown: Shown::Cone,
        own: vec![own(&spheres(), 0, GpuPages::ONE)],
        stack: None,
        paper: false,
        is_patch: false,
        looks_again: true,
    };
    let unshadowed = Variant { own: Vec::new(), ..lambert.clone() };
    let text = classify(&unshadowed).text;
    assert!(!text.contains("slab") && !text.contains("spheres_") && !text.contains("phong"), "one closed integral");
    let text = penumbra(&lambert).text;
    assert!(!text.contains("glossy") && !text.contains("maps_") && !text.contains("lafortune"));
}

#[test]
fn the_frame_is_laid_out_as_in_rust() {
    let module = check("args", &args());
    let (_, frame) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some("Frame")).expect("the struct");
    let TypeInner::Struct { members, span } = &frame.inner else { panic!("a struct") };
    assert_eq!(*span as usize, size_of::<GpuFrame>());
    let named = members.iter().map(|m| (m.name.as_deref().expect("a name"), m.offset));
    let offsets: Vec<(&str, u32)> = named.filter(|(name, _)| !name.starts_with("pad")).collect();
    macro_rules! rust {
        ($($field:ident),*) => { [$((stringify!($field), core::mem::offset_of!(GpuFrame, $field) as u32)),*] };
    }
    let rust = rust!(
        light,
        radiance,
        tolerance,
        threshold,
        point_count,
        queue_stride,
        rounds,
        image,
        number,
        cells,
        look_again,
        shape
    );
    assert_eq!(offsets, rust);
}
