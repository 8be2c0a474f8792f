use crate::error::{check_coefficient, check_exponent};
use crate::phong;
use crate::sampling::{density, draw};
use crate::shape::{Diffuse, Mirror, mirrored_view};
use crate::term::Term;
use crate::wgsl::{MIRRORED_VIEW, ModelWgsl};
use crate::{Brdf, BrdfSample, Factors, Material, MaterialError, Model, Packer};
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::Vec3;
use lobe_core::wgsl::Piece;
use lobe_core::{BrdfLobe, Lobe, Receiver, power};
use shading::BrdfLobes;

/// The normalised Phong model: `f̃(v) = (kd/π + ks·(e+2)/(2π)·max(r·v, 0)^e)·max(n·v, 0)`, `r` the mirrored view
/// (E. Lafortune, Y. Willems, *Using the Modified Phong Reflectance Model for Physically Based Rendering*, 1994; \[26\]
/// of the paper).
///
/// Reciprocal; conserves energy while `kd + ks ≤ 1`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModifiedPhong {
    /// Fraction of light that is reflected diffusely (an albedo; not divided by π).
    pub kd: Vec3,
    /// Fraction that is reflected in the specular lobe at normal incidence; less at others.
    pub ks: Vec3,
    /// Specular exponent, in [0, 1e7].
    pub exponent: f32,
}

impl ModifiedPhong {
    pub(crate) fn lobes(&self, at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
        [0, 1].map(|place| self.term(place).and_then(|term| term.lobe(at))).into_iter().flatten()
    }

    pub(crate) fn term(&self, place: usize) -> Option<Term<'static>> {
        let e = self.exponent;
        match place {
            0 => Some(Term::Diffuse(Diffuse(self.kd))),
            1 => Some(Term::Mirror(Mirror { flux: self.ks * ((e + 2.0) / (e + 1.0)), exponent: e, cosine: 1.0 })),
            _ => None,
        }
    }
}

impl BrdfLobes for ModifiedPhong {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at).map(BrdfLobe::Cosine));
    }
}

impl Brdf for ModifiedPhong {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        let cos = at.normal.dot(v).max(0.0);
        let e = self.exponent;
        (self.kd * FRAC_1_PI + self.ks * ((e + 2.0) / TAU * power(mirrored_view(at.normal, at.view), v, e))) * cos
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        draw(self.lobes(at), at.normal, u)
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        density(self.lobes(at), at.normal, v)
    }
}

static WGSL: Piece = Piece::new(include_str!("modified_phong.wgsl")).needs(&[&MIRRORED_VIEW]);

/// The coefficients are finite and not negative, the exponent in range.
impl Model for ModifiedPhong {
    fn name(&self) -> &'static str {
        "modified-phong"
    }

    fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("kd", self.kd)?;
        check_coefficient("ks", self.ks)?;
        check_exponent(self.exponent)
    }

    fn lobe_count(&self) -> usize {
        2
    }

    fn scaled(&self, by: &Factors) -> Option<Material> {
        let exponent = self.exponent * by.exponent;
        Some(Self { kd: self.kd * by.color, ks: self.ks * by.specular, exponent }.into())
    }

    fn wgsl(&self) -> Option<ModelWgsl> {
        Some(ModelWgsl::new("modified-phong", &WGSL))
    }

    fn pack(&self, out: &mut Packer) -> u32 {
        phong::pack([self.kd, self.ks * ((self.exponent + 2.0) / (self.exponent + 1.0))], self.exponent, out)
    }
}
