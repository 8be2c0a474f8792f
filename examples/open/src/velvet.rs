//! A material: diffuse, and bright back toward where the light comes from, as velvet and road signs are.

use core::f32::consts::{PI, TAU};
use cosine_lobes::brdf::wgsl::{MATERIAL, ModelWgsl};
use cosine_lobes::brdf::{Brdf, BrdfSample, Factors, Material, Model, Packer};
use cosine_lobes::glam::Vec3;
use cosine_lobes::lobe_core::wgsl::Piece;
use cosine_lobes::lobe_core::{BrdfLobe, Lobe, Receiver};
use cosine_lobes::shading::BrdfLobes;
use std::sync::Arc;

/// `f_r = kd/π + ks·(n + 2)/2π·max(v·ω_o, 0)ⁿ`.
#[derive(Clone, Copy, Debug)]
pub struct Velvet {
    pub kd: Vec3,
    pub ks: Vec3,
    pub exponent: f32,
}

impl Velvet {
    /// Scale of the retro-reflective lobe.
    fn scale(&self) -> Vec3 {
        self.ks * ((self.exponent + 2.0) / TAU)
    }
}

impl BrdfLobes for Velvet {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.push(Lobe::new(at.normal, 1.0, self.kd / PI).into());
        out.push(Lobe::new(at.view, self.exponent, self.scale()).times_cosine().into());
    }
}

/// For the Monte-Carlo reference.
impl Brdf for Velvet {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        let cos = at.normal.dot(v).max(0.0);
        (self.kd / PI + self.scale() * v.dot(at.view).max(0.0).powf(self.exponent)) * cos
    }

    fn sample(&self, at: &Receiver, [choice, x, y]: [f32; 3]) -> Option<BrdfSample> {
        let (axis, e) = if choice < 0.5 { (at.normal, 1.0) } else { (at.view, self.exponent) };
        let cos = x.powf(1.0 / (e + 1.0));
        let (sin, (t, b)) = ((1.0 - cos * cos).max(0.0).sqrt(), axis.any_orthonormal_pair());
        let (s, c) = (TAU * y).sin_cos();
        let direction = (t * (c * sin) + b * (s * sin) + axis * cos).normalize();
        let above = at.normal.dot(direction) > 0.0;
        above.then(|| BrdfSample { direction, pdf: self.pdf(at, direction) })
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        let lobe = |cos: f32, e: f32| (e + 1.0) / TAU * cos.max(0.0).powf(e);
        0.5 * (lobe(at.normal.dot(v), 1.0) + lobe(at.view.dot(v), self.exponent))
    }
}

static WGSL: Piece = Piece::new(include_str!("velvet.wgsl")).needs(&[&MATERIAL]);

/// For renderers: textures of colours, and seven words for a GPU.
impl Model for Velvet {
    fn name(&self) -> &'static str {
        "velvet"
    }

    fn lobe_count(&self) -> usize {
        2
    }

    fn scaled(&self, by: &Factors) -> Option<Material> {
        Some(Material::Custom(Arc::new(Self { kd: self.kd * by.color, ks: self.ks * by.specular, ..*self })))
    }

    fn wgsl(&self) -> Option<ModelWgsl> {
        Some(ModelWgsl::new("velvet", &WGSL))
    }

    fn pack(&self, out: &mut Packer) -> u32 {
        let flux = self.scale() * (TAU / (self.exponent + 1.0));
        out.push(self.kd.to_array().into_iter().chain(flux.to_array()).chain([self.exponent]));
        2
    }
}
