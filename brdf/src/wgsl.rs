//! The WGSL of models: the same lobes in the same order, for materials [packed](crate::PackedMaterials) into words.
//!
//! [`compose`] joins what some models need and writes `brdf_lobe`. All of it needs [`lobe_core::wgsl::GEOMETRY`],
//! [`LOBE`](lobe_core::wgsl::LOBE) and [`SPECIAL`](lobe_core::wgsl::SPECIAL), and of the kernel that it declares
//! `materials`, an `array<u32>`.

use core::fmt::Write;

/// Packed materials (`material_f32`, `material_vec3`, which read a word), and the lobe of diffuse parts.
pub const MATERIAL: &str = include_str!("material.wgsl");
/// `mirrored_view` of both Phong models.
pub(crate) const MIRRORED_VIEW: &str = include_str!("mirrored_view.wgsl");
/// Unit vectors and turns.
pub(crate) const TURN: &str = include_str!("turn.wgsl");

/// The WGSL of one model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelWgsl {
    /// Its name, of letters, digits and hyphens; another one for lobes of microfacets than for cosine lobes.
    pub name: &'static str,
    /// Texts that it needs beside [`MATERIAL`], each of which is there once, however many models need it. One defines
    /// `fn NAME_lobe(words: u32, at: Receiver, k: u32) -> Lobe`, with underscores for the hyphens of the name: the lobes of
    /// [`brdf_lobes`](shading::BrdfLobes::brdf_lobes) in the same order, with a flux of 0 where a receiver has less. `words` is where the
    /// material's [packed](crate::Model::pack) numbers begin.
    pub pieces: Vec<&'static str>,
    /// Whether it may give lobes of microfacets.
    pub has_microfacets: bool,
}

impl ModelWgsl {
    /// The WGSL of a model without microfacets.
    #[must_use]
    pub fn new(name: &'static str, pieces: impl Into<Vec<&'static str>>) -> Self {
        Self { name, pieces: pieces.into(), has_microfacets: false }
    }

    /// The same, which may give lobes of microfacets.
    #[must_use]
    pub fn with_microfacets(self) -> Self {
        Self { has_microfacets: true, ..self }
    }
}

/// The code of these models and no other, with `brdf_lobe_count(material: u32) -> u32` and
/// `brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe`: the lobes of `f̃` in the order of
/// [`brdf_lobes`](shading::BrdfLobes::brdf_lobes). A lobe that a receiver does not have has a flux of 0.
///
/// A single model is called without asking which it is.
///
/// ```
/// use brdf::{Material, wgsl};
/// let lambert = Material::lambert(glam::Vec3::ONE).model().wgsl().unwrap();
/// let text = wgsl::compose(&[lambert]);
/// assert!(text.contains("lambert_lobe") && !text.contains("switch"));
/// ```
#[must_use]
pub fn compose(models: &[ModelWgsl]) -> String {
    let mut pieces = vec![MATERIAL];
    for piece in models.iter().flat_map(|model| &model.pieces) {
        if !pieces.contains(piece) {
            pieces.push(piece);
        }
    }
    let mut text = pieces.join("\n");
    let call =
        |model: &ModelWgsl| format!("return {}_lobe(material_offset(material), at, k);", model.name.replace('-', "_"));
    let body = match models {
        [] => "return diffuse_lobe(at, vec3f(0.0));".to_owned(),
        [only] => call(only),
        [most @ .., last] => {
            let cases: String = most
                .iter()
                .enumerate()
                .map(|(k, model)| format!("        case {k}u: {{ {} }}\n", call(model)))
                .collect();
            format!("switch material_model(material) {{\n{cases}        default: {{ {} }}\n    }}", call(last))
        }
    };
    let _ = write!(text, "\nfn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe {{\n    {body}\n}}\n");
    text
}
