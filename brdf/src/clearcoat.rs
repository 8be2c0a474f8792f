//! A clear coat over a metallic–roughness material, with a roughness and, where a normal map turns the base alone, a normal of its own.

use crate::coat::MIN_ALPHA;
use crate::rows::{self, RowTable, Rows};
use crate::shape::mirrored_view;
use crate::visible_normals::VisibleNormals;
use crate::wgsl::MATERIAL;
use crate::{Factors, Packer};
use glam::Vec3;
use lobe_core::wgsl::Piece;
use lobe_core::{Facets, Lobe, Microfacets, Receiver};

/// Reflectance at normal incidence, of a refractive index of 1.5.
const F0: f32 = 0.04;

/// A layer of a dielectric over a whole material, as glTF's KHR_materials_clearcoat has it: of what comes in, the part
/// `c·F(n·ω_o)` is reflected by GGX microfacets, and the material below is multiplied by `1 − c·F(n·ω_o)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clearcoat {
    /// `c`.
    pub(crate) weight: f32,
    pub(crate) roughness: f32,
    /// Its normal, where that is not the receiver's.
    pub(crate) normal: Option<Vec3>,
}

impl Clearcoat {
    pub(crate) fn scaled(&self, by: &Factors) -> Self {
        Self { weight: self.weight * by.clearcoat, roughness: self.roughness * by.clearcoat_roughness, ..*self }
    }

    fn alpha(&self) -> f32 {
        (self.roughness * self.roughness).max(MIN_ALPHA)
    }

    /// `c·F`: what it reflects, and what the material below lacks.
    pub(crate) fn reflects(&self, at: &Receiver) -> f32 {
        let x = 1.0 - self.normal.unwrap_or(at.normal).dot(at.view).abs().min(1.0);
        self.weight * (F0 + (1.0 - F0) * x * x * x * x * x)
    }

    /// The eye's direction such that the receiver's normal mirrors it to where the coat's own normal mirrors the eye.
    fn eye(&self, at: &Receiver) -> Vec3 {
        self.normal.map_or(at.view, |own| mirrored_view(at.normal, mirrored_view(own, at.view)))
    }

    /// The flux of its lobes: none where it mirrors the eye to below the receiver's horizon.
    fn flux(&self, at: &Receiver, eye: Vec3) -> f32 {
        if self.normal.is_some() && at.normal.dot(eye) <= 0.0 { 0.0 } else { self.reflects(at) }
    }

    /// Both parts of its microfacets; with equal reflectances they are `D·W` without Schlick's factor.
    pub(crate) fn facets(&self, at: &Receiver) -> [Microfacets; 2] {
        let eye = self.eye(at);
        Microfacets::new(eye, self.alpha(), [Vec3::splat(self.flux(at, eye)); 2])
    }

    pub(crate) fn cosines(&self, at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
        let eye = self.eye(at);
        rows::lobes(self.rows(), [Vec3::splat(self.flux(at, eye)); 2], &Receiver { view: eye, ..*at })
    }

    /// Its reflectance about its own normal, `c·F·D·W`.
    pub(crate) fn eval(&self, at: &Receiver, v: Vec3) -> f32 {
        let normal = self.normal.unwrap_or(at.normal);
        let facets = Microfacets::new(at.view, self.alpha(), [Vec3::ONE; 2]);
        let [f0, f90] = facets[0].at(normal).both(v);
        self.reflects(at) * (f0 + f90)
    }

    pub(crate) fn visible(&self, at: &Receiver) -> VisibleNormals {
        VisibleNormals::new(self.normal.unwrap_or(at.normal), at.view, self.alpha())
    }

    /// Without Schlick's factor all reflectances are one.
    fn rows(&self) -> &'static Rows {
        RowTable::shared(self.roughness, 1.0)
    }

    /// Weight, exponent, its own normal or zero.
    pub(crate) fn pack(&self, out: &mut Packer) {
        let alpha = self.alpha();
        out.push([self.weight, 2.0 / (alpha * alpha) - 2.0]);
        out.push(self.normal.unwrap_or(Vec3::ZERO).to_array());
    }

    /// Where the rows of its cosine lobes begin, their slots, and how many there are.
    pub(crate) fn pack_rows(&self, out: &mut Packer) -> (u32, [u32; 9], u32) {
        let (slots, lobes) = rows::slots(self.rows(), 0);
        (rows::pack(self.rows(), out), slots, lobes)
    }
}

/// The WGSL of a clear coat.
pub(crate) static WGSL: Piece = Piece::new(include_str!("clearcoat.wgsl")).needs(&[&MATERIAL]);
