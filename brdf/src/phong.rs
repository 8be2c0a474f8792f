use crate::error::{check_coefficient, check_exponent};
use crate::sampling::{density, draw};
use crate::shape::{Diffuse, Mirror, mirrored_view};
use crate::term::Term;
use crate::wgsl::{MIRRORED_VIEW, ModelWgsl};
use crate::{Brdf, BrdfSample, Factors, Material, MaterialError, Model, Packer};
use core::f32::consts::{PI, TAU};
use glam::Vec3;
use lobe_core::wgsl::Piece;
use lobe_core::{BrdfLobe, Lobe, Receiver, power};
use shading::BrdfLobes;

/// The Phong model as the paper prints it: `f̃(v) = kd·max(n·v, 0) + ks·max(r·v, 0)^e` (Eqs. 23–26), `r` the mirrored
/// view.
///
/// The specular term has no cosine factor: the model is not reciprocal and, near grazing views, not energy conserving.
/// [`ModifiedPhong`](crate::ModifiedPhong) is both. A receiver reflects at most `π·kd + 2π·ks/(e+1)` of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phong {
    /// Diffuse coefficient in sr⁻¹: the albedo divided by π.
    pub kd: Vec3,
    /// Specular coefficient in sr⁻¹: the value of the specular lobe at its peak.
    pub ks: Vec3,
    /// Specular exponent, in [0, 1e7].
    pub exponent: f32,
}

impl Phong {
    pub(crate) fn lobes(&self, at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
        [0, 1].map(|place| self.term(place).and_then(|term| term.lobe(at))).into_iter().flatten()
    }

    pub(crate) fn term(&self, place: usize) -> Option<Term<'static>> {
        let e = self.exponent;
        match place {
            0 => Some(Term::Diffuse(Diffuse(PI * self.kd))),
            1 => Some(Term::Mirror(Mirror { flux: self.ks * (TAU / (e + 1.0)), exponent: e, cosine: 0.0 })),
            _ => None,
        }
    }
}

impl BrdfLobes for Phong {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at).map(BrdfLobe::Cosine));
    }
}

impl Brdf for Phong {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        let cos = at.normal.dot(v);
        if cos <= 0.0 {
            return Vec3::ZERO;
        }
        self.kd * cos + self.ks * power(mirrored_view(at.normal, at.view), v, self.exponent)
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        draw(self.lobes(at), at.normal, u)
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        density(self.lobes(at), at.normal, v)
    }
}

/// Writes a diffuse flux, then flux and exponent of a highlight; the number of lobes.
pub(crate) fn pack([diffuse, specular]: [Vec3; 2], exponent: f32, out: &mut Packer) -> u32 {
    let lobes = out.push_diffuse(diffuse);
    out.push_word(1 - lobes);
    out.push(specular.to_array());
    out.push([exponent]);
    lobes + u32::from(specular != Vec3::ZERO)
}

static WGSL: Piece = Piece::new(include_str!("phong.wgsl")).needs(&[&MIRRORED_VIEW]);

/// The coefficients are finite and not negative, the exponent in range.
impl Model for Phong {
    fn name(&self) -> &'static str {
        "phong"
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
        Some(ModelWgsl::new("phong", &WGSL))
    }

    fn pack(&self, out: &mut Packer) -> u32 {
        pack([PI * self.kd, self.ks * (TAU / (self.exponent + 1.0))], self.exponent, out)
    }
}
