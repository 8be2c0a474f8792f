//! The WGSL of the materials without a GPU: every choice of models validates, and contains no code of other models.

use crate::validated::with_info;
use brdf::wgsl::{ModelWgsl, compose};
use brdf::{Material, MetallicRoughness};
use lobe_core::wgsl::join;
use naga::valid::Capabilities;

/// The built-in models, one of them with a clear coat, with a grain and with both, by cosine lobes and, where that is another text, by microfacets.
fn models() -> Vec<ModelWgsl> {
    let of = |material: &Material| {
        [material.model().cosine_wgsl(), material.model().wgsl()].map(|text| text.expect("a built-in model"))
    };
    let varnished = MetallicRoughness::default().with_clearcoat(1.0, 0.1).expect("in range");
    let mut all: Vec<ModelWgsl> = Material::built_in().iter().chain([&varnished.clone().into()]).flat_map(of).collect();
    all.dedup();
    for metal in [MetallicRoughness::default(), varnished] {
        let brushed = Material::from(metal.with_anisotropy(0.5).expect("in range"));
        all.push(brushed.model().wgsl().expect("a built-in model"));
    }
    all
}

/// None, one, two, or all.
fn choices() -> Vec<Vec<ModelWgsl>> {
    let all = models();
    let mut choices = vec![Vec::new(), all.clone()];
    for (i, model) in all.iter().enumerate() {
        choices.push(vec![model.clone()]);
        choices.extend(all[..i].iter().map(|other| vec![other.clone(), model.clone()]));
    }
    choices
}

fn text_of(models: &[ModelWgsl]) -> String {
    let (pieces, text) = compose(models);
    join(&pieces) + &text
}

fn names(models: &[ModelWgsl]) -> Vec<&str> {
    models.iter().map(|model| model.name).collect()
}

#[test]
fn every_choice_of_models_validates() {
    let binding = "@group(0) @binding(2) var<storage, read> materials: array<u32>;";
    for models in choices() {
        let text = text_of(&models) + binding;
        with_info(&names(&models).join(" + "), &text, Capabilities::default());
    }
}

#[test]
fn there_is_no_code_of_absent_models() {
    let all = models();
    assert_eq!(all.len(), 13);
    for models in choices() {
        let (text, there) = (text_of(&models), names(&models));
        for name in names(&all) {
            let function = format!("fn {}_lobe(", name.replace('-', "_"));
            // A clear coat and a grain have the material below with them.
            let above: &[&str] = match name {
                "metallic-microfacets" => {
                    &["clearcoat-microfacets", "brushed-microfacets", "clearcoat-brushed-microfacets"]
                }
                "clearcoat-microfacets" => &["clearcoat-brushed-microfacets"],
                "metallic-roughness" => &["clearcoat-directions"],
                _ => &[],
            };
            let is_there = there.contains(&name) || above.iter().any(|above| there.contains(above));
            assert_eq!(text.contains(&function), is_there, "{there:?} {name}");
        }
        let any = |of: &[&str]| of.iter().any(|name| there.contains(name));
        assert_eq!(text.contains("fn mirrored_view("), any(&["phong", "modified-phong"]), "{there:?}");
        assert_eq!(text.contains("fn lafortune_excess("), any(&["lafortune"]), "{there:?}");
        let by_rows = ["metallic-roughness", "clearcoat-directions", "half-vector"];
        assert_eq!(text.contains("fn row_value("), any(&by_rows), "{there:?}");
        assert_eq!(text.contains("fn unit_or("), any(&by_rows) || any(&["neumann"]), "{there:?}");
        let has_grain = any(&["brushed-microfacets", "clearcoat-brushed-microfacets"]);
        assert_eq!(text.contains("fn grain_kind("), has_grain, "{there:?}");
        assert_eq!(text.contains("switch"), models.len() > 1, "{there:?}");
    }
}
