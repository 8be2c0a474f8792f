use crate::error::{MAX_COEFFICIENT, check_coefficient, check_exponent};
use crate::lafortune_term::{IsotropicTerm, LafortuneTerm, spectral_norm};
use crate::sampling::{density, draw};
use crate::shape::Diffuse;
use crate::term::Term;
use crate::wgsl::{MATERIAL, ModelWgsl};
use crate::{Brdf, BrdfSample, Factors, Material, MaterialError, Model, Packer};
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::{Mat3, Vec3};
use lobe_core::wgsl::Piece;
use lobe_core::{BrdfLobe, Lobe, Receiver, power};
use shading::BrdfLobes;

/// The Lafortune model: `f̃(v) = (ρ/π + Σ_i k_i·max(v·M_iω_o, 0)^e_i)·max(n·v, 0)` (Eqs. 27–29; E. Lafortune, S. Foo,
/// K. Torrance, D. Greenberg, *Non-Linear Approximation of Reflectance Functions*, SIGGRAPH 1997).
///
/// Reciprocal, since every `M` is symmetric. Not normalised: `k` decides how much energy is reflected.
///
/// # Frame
/// `M` acts in the frame `(t, b, n)` in which `n` is the receiver's normal and `t`, `b` come from
/// [`lobe_core::orthonormal_basis`]. Isotropic lobes (`C_x = C_y`) don't see the choice of `t`; others are [`turned`](Self::turned) to a
/// tangent of the surface's own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lafortune {
    /// Albedo ρ of the diffuse part; black for none.
    pub diffuse: Vec3,
    /// The lobes. A lobe whose matrix depends on the channel is three lobes, each with a scale in one channel only.
    pub lobes: Vec<LafortuneLobe>,
}

/// One term `k·max(v·Mω_o, 0)^e` of the [`Lafortune`] model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LafortuneLobe {
    scale: Vec3,
    /// Right for any matrix; what the GPU takes.
    any: LafortuneTerm,
    /// The cheaper form, where the matrix has it.
    isotropic: Option<IsotropicTerm>,
}

impl LafortuneLobe {
    /// The lobe with the symmetric matrix `M` in the local frame `(t, b, n)`, the exponent `e` in [0, 1e7] and `k` per
    /// channel, in sr⁻¹.
    #[must_use]
    pub fn new(matrix: Mat3, exponent: f32, scale: Vec3) -> Self {
        let any = LafortuneTerm::new(matrix, exponent, scale * (TAU / (exponent + 1.0)));
        Self { scale, any, isotropic: any.isotropic() }
    }

    /// `M`.
    #[must_use]
    pub const fn matrix(&self) -> Mat3 {
        self.any.matrix
    }

    /// `e`.
    #[must_use]
    pub const fn exponent(&self) -> f32 {
        self.any.exponent
    }

    /// `k`.
    #[must_use]
    pub const fn scale(&self) -> Vec3 {
        self.scale
    }

    pub(crate) fn term(&self) -> Term<'_> {
        self.isotropic.as_ref().map_or(Term::Lafortune(&self.any), Term::Isotropic)
    }

    /// The lobe with `M = diag(C_x, C_y, C_z)`.
    ///
    /// # Signs
    /// Both directions point away from the surface, so the mirror direction of `ω_o = (x, y, z)` is `(−x, −y, z)`: a
    /// mirror-like lobe has `C_x = C_y = −1`, `C_z = 1`. Retro-reflection has `C_x = C_y = C_z = 1`, and
    /// `|C_x| > C_z` moves the lobe toward grazing (off-specular).
    ///
    /// ```
    /// use brdf::{Brdf, Lafortune, LafortuneLobe};
    /// use glam::Vec3;
    /// let mirror = LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 1.0), 100.0, Vec3::ONE);
    /// let metal = Lafortune { diffuse: Vec3::ZERO, lobes: vec![mirror] };
    /// let (n, view) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
    /// let at = lobe_core::Receiver::on_surface(Vec3::ZERO, n, view);
    /// let reflected = metal.eval(&at, Vec3::new(-0.6, 0.0, 0.8));
    /// assert!((reflected.x - 0.8).abs() < 1e-5); // k·1^e·(n·v)
    /// ```
    #[must_use]
    pub fn diagonal(c: Vec3, exponent: f32, scale: Vec3) -> Self {
        Self::new(Mat3::from_diagonal(c), exponent, scale)
    }

    /// Checks the parameters: finite, scale not negative, exponent in range, matrix symmetric (to 1e-5 of its largest
    /// entry), peak `k·‖M‖^e` at most 1e12.
    ///
    /// # Errors
    /// [`MaterialError`] that names what is wrong.
    pub fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("scale", self.scale)?;
        check_exponent(self.exponent())?;
        let entries = self.matrix().to_cols_array();
        let largest = entries.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
        if !entries.iter().all(|x| x.abs() <= MAX_COEFFICIENT) {
            return Err(MaterialError::Matrix);
        }
        let skew = self.matrix() - self.matrix().transpose();
        if skew.to_cols_array().iter().any(|x| x.abs() > 1e-5 * largest) {
            return Err(MaterialError::Asymmetric);
        }
        let k = f64::from(self.scale.max_element());
        let ln_peak = k.ln() + f64::from(self.exponent()) * spectral_norm(self.matrix()).ln();
        if ln_peak > f64::from(MAX_COEFFICIENT).ln() {
            return Err(MaterialError::Peak { ln_peak });
        }
        Ok(())
    }
}

impl Lafortune {
    /// Whether a lobe sees the choice of the tangent.
    #[must_use]
    pub fn is_anisotropic(&self) -> bool {
        self.lobes.iter().any(|lobe| lobe.isotropic.is_none())
    }

    /// The model of a point of this normal at which `M` is meant in the frame of another tangent, of any length, which is made perpendicular
    /// to the normal: `RMRᵀ` with the turn R from one to the other. The same where there is no such tangent.
    #[must_use]
    pub fn turned(&self, normal: Vec3, tangent: Vec3) -> Self {
        let (t, b) = lobe_core::orthonormal_basis(normal);
        let Some(tangent) = (tangent - normal * normal.dot(tangent)).try_normalize() else { return self.clone() };
        let (c, s) = (tangent.dot(t), tangent.dot(b));
        let turn = Mat3::from_cols(Vec3::new(c, s, 0.0), Vec3::new(-s, c, 0.0), Vec3::Z);
        let turned = |lobe: &LafortuneLobe| match lobe.isotropic {
            Some(_) => *lobe,
            None => {
                let m = turn * lobe.matrix() * turn.transpose();
                // Symmetric to the bit, as rounding leaves it not.
                LafortuneLobe::new((m + m.transpose()) * 0.5, lobe.exponent(), lobe.scale)
            }
        };
        Self { diffuse: self.diffuse, lobes: self.lobes.iter().map(turned).collect() }
    }

    pub(crate) fn lobes<'a>(&'a self, at: &'a Receiver) -> impl Iterator<Item = Lobe> + Clone + 'a {
        (0..=self.lobes.len()).filter_map(|place| self.term(place)?.lobe(at))
    }

    pub(crate) fn term(&self, place: usize) -> Option<Term<'_>> {
        match place {
            0 => Some(Term::Diffuse(Diffuse(self.diffuse))),
            _ => self.lobes.get(place - 1).map(LafortuneLobe::term),
        }
    }
}

impl BrdfLobes for Lafortune {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at).map(BrdfLobe::Cosine));
    }
}

impl Brdf for Lafortune {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        let term = |l: &LafortuneLobe| {
            let lobe = l.term().lobe(at)?;
            Some(lobe.flux * ((lobe.exponent + 1.0) / TAU * power(lobe.axis, v, lobe.exponent)))
        };
        let specular: Vec3 = self.lobes.iter().filter_map(term).sum();
        (self.diffuse * FRAC_1_PI + specular) * at.normal.dot(v).max(0.0)
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        draw(self.lobes(at), at.normal, u)
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        density(self.lobes(at), at.normal, v)
    }
}

static WGSL: Piece = Piece::new(include_str!("lafortune.wgsl")).needs(&[&MATERIAL]);

/// All parameters are valid; see [`LafortuneLobe::validate`].
impl Model for Lafortune {
    fn name(&self) -> &'static str {
        "lafortune"
    }

    fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("diffuse", self.diffuse)?;
        self.lobes.iter().try_for_each(LafortuneLobe::validate)
    }

    fn lobe_count(&self) -> usize {
        1 + self.lobes.len()
    }

    fn scaled(&self, by: &Factors) -> Option<Material> {
        let scaled =
            |l: &LafortuneLobe| LafortuneLobe::new(l.matrix(), l.exponent() * by.exponent, l.scale() * by.specular);
        Some(Self { diffuse: self.diffuse * by.color, lobes: self.lobes.iter().map(scaled).collect() }.into())
    }

    fn turned(&self, normal: Vec3, tangent: Vec3) -> Option<Material> {
        self.is_anisotropic().then(|| Self::turned(self, normal, tangent).into())
    }

    fn wgsl(&self) -> Option<ModelWgsl> {
        Some(ModelWgsl::new("lafortune", &WGSL))
    }

    fn pack(&self, out: &mut Packer) -> u32 {
        let mut lobes = out.push_diffuse(self.diffuse);
        out.push_word(1 - lobes);
        for lobe in self.lobes.iter().filter(|lobe| lobe.scale != Vec3::ZERO) {
            out.push(bytemuck::cast::<_, [f32; 25]>(lobe.any));
            lobes += 1;
        }
        lobes
    }
}
