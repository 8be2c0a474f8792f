//! The WGSL of the materials without a GPU: every choice of models validates, and has no code of the others.

use crate::validated::with_info;
use brdf::{Models, wgsl};
use lobe_core::wgsl::{GEOMETRY, LOBE, SPECIAL};
use naga::valid::Capabilities;

const FUNCTIONS: [&str; 9] = [
    "lambert_lobe",
    "phong_lobe",
    "modified_phong_lobe",
    "lafortune_lobe",
    "metallic_roughness_lobe",
    "metallic_microfacets_lobe",
    "neumann_lobe",
    "half_vector_lobe",
    "half_vector_microfacets_lobe",
];

/// None, one, two, or all.
fn choices() -> impl Iterator<Item = (u16, String)> {
    let all = (1_u16 << FUNCTIONS.len()) - 1;
    let few = (0..=all).filter(move |bits| bits.count_ones() <= 2 || *bits == all);
    few.map(|bits| (bits, wgsl::compose(Models::from_bits(bits))))
}

#[test]
fn every_choice_of_models_validates() {
    let binding = "@group(0) @binding(2) var<storage, read> materials: array<u32>;";
    for (bits, text) in choices() {
        let text = [&text, binding, SPECIAL, GEOMETRY, LOBE].join("\n");
        with_info(&bits.to_string(), &text, Capabilities::default());
    }
}

#[test]
fn there_is_no_code_of_absent_models() {
    for (bits, text) in choices() {
        for (number, name) in FUNCTIONS.iter().enumerate() {
            let there = bits >> number & 1 == 1;
            assert_eq!(text.contains(&format!("fn {name}(")), there, "{bits} {name}");
        }
        assert_eq!(text.contains("fn mirrored_view("), bits & 6 != 0, "{bits}");
        assert_eq!(text.contains("fn lafortune_excess("), bits & 8 != 0, "{bits}");
        assert_eq!(text.contains("fn row_value("), bits & 0x90 != 0, "{bits}");
        assert_eq!(text.contains("fn unit_or("), bits & 0xd0 != 0, "{bits}");
        assert_eq!(text.contains("switch"), bits.count_ones() > 1, "{bits}");
    }
}

#[test]
fn function_names_are_scene_files_names() {
    for (number, name) in FUNCTIONS.iter().enumerate() {
        let model = Models::from_bits(1 << number).names().next().unwrap_or_default();
        assert_eq!(*name, format!("{}_lobe", model.replace('-', "_")));
    }
    assert_eq!(Models::ALL.names().count(), FUNCTIONS.len());
}
