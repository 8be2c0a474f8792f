//! The WGSL of the models: the same lobes in the same order, for materials [packed](crate::PackedMaterials) into words.
//!
//! [`compose`] joins what some models need and writes `brdf_lobe`. All of it needs [`lobe_core::wgsl::GEOMETRY`],
//! [`LOBE`](lobe_core::wgsl::LOBE) and [`SPECIAL`](lobe_core::wgsl::SPECIAL), and of the kernel that it declares
//! `materials`, an `array<u32>`.

use crate::{Models, coat, ggx, neumann, rows};
use core::fmt::Write;

/// Packed materials, and the lobe of diffuse parts.
pub const MATERIAL: &str = include_str!("material.wgsl");
/// [`Lambert`](crate::Lambert). Needs [`MATERIAL`].
pub const LAMBERT: &str = include_str!("lambert.wgsl");
/// `mirrored_view` of both Phong models.
pub const MIRRORED_VIEW: &str = include_str!("mirrored_view.wgsl");
/// [`Phong`](crate::Phong). Needs [`MATERIAL`] and [`MIRRORED_VIEW`].
pub const PHONG: &str = include_str!("phong.wgsl");
/// [`ModifiedPhong`](crate::ModifiedPhong). Needs [`MATERIAL`] and [`MIRRORED_VIEW`].
pub const MODIFIED_PHONG: &str = include_str!("modified_phong.wgsl");
/// [`Lafortune`](crate::Lafortune). Needs [`MATERIAL`].
pub const LAFORTUNE: &str = include_str!("lafortune.wgsl");
/// Lobes of directions from tables. Needs [`MATERIAL`] and [`TURN`].
pub const ROW_LOBE: &str = include_str!("row_lobe.wgsl");
/// Unit vectors and turns.
pub const TURN: &str = include_str!("turn.wgsl");
/// The base of both forms of [`MetallicRoughness`](crate::MetallicRoughness). Needs [`MATERIAL`].
pub const COAT: &str = include_str!("coat.wgsl");
/// [`MetallicRoughness`](crate::MetallicRoughness). Needs [`MATERIAL`], [`COAT`] and [`ROW_LOBE`].
pub const METALLIC_ROUGHNESS: &str = include_str!("metallic_roughness.wgsl");

/// The same by microfacets. Needs [`MATERIAL`] and [`COAT`].
pub const METALLIC_MICROFACETS: &str = include_str!("metallic_microfacets.wgsl");
/// [`HalfVector`](crate::HalfVector). Needs [`MATERIAL`] and [`ROW_LOBE`].
pub const HALF_VECTOR: &str = include_str!("half_vector.wgsl");
/// The same by microfacets. Needs [`MATERIAL`].
pub const HALF_VECTOR_MICROFACETS: &str = include_str!("half_vector_microfacets.wgsl");
/// [`Neumann`](crate::Neumann). Needs [`MATERIAL`] and [`TURN`].
pub const NEUMANN: &str = include_str!("neumann.wgsl");

/// By number: name of the function, pieces.
const MODELS: [(&str, &[&str]); 9] = [
    ("lambert_lobe", &[LAMBERT]),
    ("phong_lobe", &[MIRRORED_VIEW, PHONG]),
    ("modified_phong_lobe", &[MIRRORED_VIEW, MODIFIED_PHONG]),
    ("lafortune_lobe", &[LAFORTUNE]),
    ("metallic_roughness_lobe", &[COAT, TURN, ROW_LOBE, METALLIC_ROUGHNESS]),
    ("metallic_microfacets_lobe", &[COAT, METALLIC_MICROFACETS]),
    ("neumann_lobe", &[TURN, NEUMANN]),
    ("half_vector_lobe", &[TURN, ROW_LOBE, HALF_VECTOR]),
    ("half_vector_microfacets_lobe", &[HALF_VECTOR_MICROFACETS]),
];

/// The code of these models and no other, with `brdf_lobe_count(material: u32) -> u32` and
/// `brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe`: the lobes of `f̃` in the order of
/// [`brdf_lobes`](lobe_core::BrdfLobes::brdf_lobes). A lobe that a receiver does not have has a flux of 0.
///
/// A single model is called without asking which it is.
///
/// ```
/// use brdf::{Material, Models, wgsl};
/// let text = wgsl::compose(Models::of(&[Material::lambert(glam::Vec3::ONE)]));
/// assert!(text.contains("lambert_lobe") && !text.contains("switch"));
/// ```
#[must_use]
pub fn compose(models: Models) -> String {
    let models: Vec<u32> = models.numbers().collect();
    let mut pieces = vec![MATERIAL];
    for piece in models.iter().flat_map(|model| MODELS[*model as usize].1) {
        if !pieces.contains(piece) {
            pieces.push(piece);
        }
    }
    let mut text = pieces.join("\n");
    if pieces.contains(&COAT) {
        let (roughnesses, views) = (coat::ROUGHNESSES, coat::VIEWS);
        let _ = write!(text, "\nconst COAT_ROUGHNESSES = {roughnesses}u;\nconst COAT_VIEWS = {views}u;\n");
    }
    if pieces.contains(&ROW_LOBE) {
        let (rows, words) = (rows::ROWS, 5 * ggx::FAMILY_COUNT);
        let _ = write!(text, "\nconst METAL_ROWS = {rows}u;\nconst METAL_ROW_WORDS = {words}u;\n");
    }
    if pieces.contains(&NEUMANN) {
        let shape = |[a, b, c, d, e, f, g, h]: &[f32; 8]| {
            format!("mat2x4f({a:?}, {b:?}, {c:?}, {d:?}, {e:?}, {f:?}, {g:?}, {h:?})")
        };
        let shapes: Vec<String> = neumann::SHAPES.iter().map(shape).collect();
        let _ = write!(text, "\nconst NEUMANN_STEEPEST = {:?};\n", neumann::STEEPEST);
        let _ = writeln!(text, "const NEUMANN_SHAPES = array<mat2x4f, {}>({});", shapes.len(), shapes.join(", "));
    }
    let call = |model: u32| format!("return {}(material_offset(material), at, k);", MODELS[model as usize].0);
    let body = match models.as_slice() {
        [] => "return diffuse_lobe(at, vec3f(0.0));".to_owned(),
        [only] => call(*only),
        [most @ .., last] => {
            let cases: String =
                most.iter().map(|model| format!("        case {model}u: {{ {} }}\n", call(*model))).collect();
            format!("switch material_model(material) {{\n{cases}        default: {{ {} }}\n    }}", call(*last))
        }
    };
    let _ = write!(text, "\nfn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe {{\n    {body}\n}}\n");
    text
}
