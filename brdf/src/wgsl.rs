//! The WGSL of models: the same lobes in the same order, for materials [packed](crate::PackedMaterials) into words.
//!
//! [`compose`] writes `brdf_lobe` for some models, which calls their pieces. All of it needs of the kernel that it declares `materials`, an
//! `array<u32>`.

use core::fmt::Write;
use lobe_core::wgsl::{COS_SIN, LOBE, Piece};

/// Packed materials (`material_f32`, `material_vec3`, which read a word), and the lobe of diffuse parts.
pub static MATERIAL: Piece = Piece::new(include_str!("material.wgsl")).needs(&[&LOBE]);
/// `mirrored_view` of both Phong models.
pub(crate) static MIRRORED_VIEW: Piece = Piece::new(include_str!("mirrored_view.wgsl")).needs(&[&MATERIAL]);
/// Unit vectors and turns.
pub(crate) static TURN: Piece = Piece::new(include_str!("turn.wgsl")).needs(&[&MATERIAL, &COS_SIN]);

/// The WGSL of one model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModelWgsl {
    /// Its name, of letters, digits and hyphens; another one for lobes of microfacets than for cosine lobes.
    pub name: &'static str,
    /// Defines `fn NAME_lobe(words: u32, at: Receiver, k: u32) -> Lobe`, with underscores for the hyphens of the name: the lobes of
    /// [`brdf_lobes`](shading::BrdfLobes::brdf_lobes) in the same order, with a flux of 0 where a receiver has less. `words` is where the
    /// material's [packed](crate::Model::pack) numbers begin. [`MATERIAL`] is there.
    pub piece: &'static Piece,
    /// Whether it may give lobes of microfacets.
    pub has_microfacets: bool,
    /// Whether these may have a [grain](lobe_core::Grain).
    pub has_grain: bool,
}

impl ModelWgsl {
    /// The WGSL of a model without microfacets.
    #[must_use]
    pub const fn new(name: &'static str, piece: &'static Piece) -> Self {
        Self { name, piece, has_microfacets: false, has_grain: false }
    }

    /// The same, which may give lobes of microfacets.
    #[must_use]
    pub const fn with_microfacets(self) -> Self {
        Self { has_microfacets: true, ..self }
    }

    /// The same, which may give lobes of microfacets that have a [grain](lobe_core::Grain).
    #[must_use]
    pub const fn with_grain(self) -> Self {
        Self { has_microfacets: true, has_grain: true, ..self }
    }
}

/// The pieces of these models and no others, and a text that calls them: `brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe`, the lobes of
/// `f̃` in the order of [`brdf_lobes`](shading::BrdfLobes::brdf_lobes). A lobe that a receiver does not have has a flux of 0. Among the
/// pieces is `brdf_lobe_count(material: u32) -> u32`.
///
/// A single model is called without asking which it is.
///
/// ```
/// use brdf::{Material, wgsl};
/// let lambert = Material::lambert(glam::Vec3::ONE).model().wgsl().unwrap();
/// let (pieces, text) = wgsl::compose(&[lambert]);
/// assert!(text.contains("lambert_lobe") && !text.contains("switch"));
/// assert_eq!(pieces.len(), 2);
/// ```
#[must_use]
pub fn compose(models: &[ModelWgsl]) -> (Vec<&'static Piece>, String) {
    let pieces = core::iter::once(&MATERIAL).chain(models.iter().map(|model| model.piece)).collect();
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
    let mut text = String::new();
    let _ = write!(text, "fn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe {{\n    {body}\n}}\n");
    (pieces, text)
}
