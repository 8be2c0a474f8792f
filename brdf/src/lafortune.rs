use crate::error::{MAX_COEFFICIENT, check_coefficient, check_exponent};
use crate::sampling::{density, draw};
use crate::symmetric::eigen;
use crate::term::{Diffuse, Shape, Term};
use crate::{Brdf, BrdfSample, MaterialError};
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::{DMat3, DVec3, Mat3, Vec3};
use lobe_core::special::{exp, ln_of};
use lobe_core::{BrdfLobes, Lobe, LobesFull, LobesMut, Receiver, orthonormal_basis, power};

/// The Lafortune model: `f̃(v) = (ρ/π + Σ_i k_i·max(v·M_iω_o, 0)^e_i)·max(n·v, 0)` (Eqs. 27–29; E. Lafortune, S. Foo,
/// K. Torrance, D. Greenberg, *Non-Linear Approximation of Reflectance Functions*, SIGGRAPH 1997).
///
/// Reciprocal, since every `M` is symmetric. Not normalised: energy is the business of whoever chooses `k`.
///
/// # Frame
/// `M` acts in the frame `(t, b, n)` in which `n` is the receiver's normal and `t`, `b` come from
/// [`lobe_core::orthonormal_basis`]. Isotropic lobes (`C_x = C_y`) don't see the choice of `t`.
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
    pub(crate) term: LafortuneTerm,
}

impl LafortuneLobe {
    /// The lobe with the symmetric matrix `M` in the local frame `(t, b, n)`, the exponent `e` in [0, 1e7] and `k` per
    /// channel, in sr⁻¹.
    #[must_use]
    pub fn new(matrix: Mat3, exponent: f32, scale: Vec3) -> Self {
        let m = as_dmat3(matrix);
        let (vectors, values) = eigen(m.transpose() * m - DMat3::IDENTITY);
        let flux = scale * (TAU / (exponent + 1.0));
        let term = LafortuneTerm { matrix, vectors: vectors.as_mat3(), values: values.as_vec3(), flux, exponent };
        Self { scale, term }
    }

    /// `M`.
    #[must_use]
    pub const fn matrix(&self) -> Mat3 {
        self.term.matrix
    }

    /// `e`.
    #[must_use]
    pub const fn exponent(&self) -> f32 {
        self.term.exponent
    }

    /// `k`.
    #[must_use]
    pub const fn scale(&self) -> Vec3 {
        self.scale
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
    /// let at = lobe_core::Receiver { position: Vec3::ZERO, normal: n, face: n, view, object: lobe_core::OWN_NONE };
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

/// A lobe's constants, the same numbers on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct LafortuneTerm {
    matrix: Mat3,
    /// Eigenvectors, as columns, and eigenvalues of `MᵀM − 1`.
    vectors: Mat3,
    values: Vec3,
    /// Without the gain.
    flux: Vec3,
    exponent: f32,
}

impl LafortuneTerm {
    /// Unit axis `Mω_o/|Mω_o|` in world space and `|Mω_o|^e`; 0 where `Mω_o = 0`.
    ///
    /// `|Mω|² − 1 = ωᵀ(MᵀM − 1)ω` for a unit ω. By the eigenvectors it loses no digits: a mirror-like lobe (`M² = 1`) has none
    /// of it, and where a large exponent makes it matter all eigenvalues are negative, or the lobe would be too high. The
    /// rounded length of `Mω` to the power 1e5 would be 1 % off.
    #[inline(always)]
    fn axis_and_gain(&self, normal: Vec3, view: Vec3) -> (Vec3, f32) {
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let (t, b) = orthonormal_basis(normal);
        let view = Vec3::new(t.dot(view), b.dot(view), normal.dot(view));
        let m = self.matrix * view;
        let largest = larger(larger(m.x.abs(), m.y.abs()), m.z.abs());
        let is_zero = largest < 1e-30;
        let scaled = m * (1.0 / if is_zero { 1.0 } else { largest });
        let axis = t * scaled.x + b * scaled.y + normal * scaled.z;
        let square = axis.dot(axis);
        let axis = axis * (1.0 / if is_zero { 1.0 } else { square.sqrt() });
        let along =
            Vec3::new(self.vectors.x_axis.dot(view), self.vectors.y_axis.dot(view), self.vectors.z_axis.dot(view));
        let excess = self.values.dot(along * along);
        // Far below 1 the length itself has the digits.
        let short = excess <= -0.5;
        let ln = ln_of(if short { largest } else { 1.0 + excess }, if short { largest - 1.0 } else { excess });
        let ln_length = if short { ln + 0.5 * ln_of(square, square - 1.0) } else { 0.5 * ln };
        let gain = exp(self.exponent * ln_length);
        let gain = if gain < MAX_COEFFICIENT { gain } else { MAX_COEFFICIENT };
        (if is_zero { normal } else { axis }, if is_zero { 0.0 } else { gain })
    }
}

impl Shape<25> for LafortuneTerm {
    #[inline(always)]
    fn lobe(&self, normal: Vec3, view: Vec3) -> Lobe {
        let (axis, gain) = self.axis_and_gain(normal, view);
        Lobe { axis, exponent: self.exponent, flux: self.flux * gain, cosine: 1.0 }
    }
}

fn as_dmat3(m: Mat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.as_dvec3(), m.y_axis.as_dvec3(), m.z_axis.as_dvec3())
}

/// Largest singular value of a symmetric matrix, by power iteration on its square.
fn spectral_norm(m: Mat3) -> f64 {
    let m = as_dmat3(m);
    // Three starts, so that no eigenvector is missed by being orthogonal to all of them.
    DVec3::AXES
        .iter()
        .map(|&start| {
            let mut v = start;
            for _ in 0..64 {
                let next = m * (m * v);
                let length = next.length();
                if length == 0.0 {
                    return 0.0;
                }
                v = next / length;
            }
            (m * v).length()
        })
        .fold(0.0, f64::max)
}

impl Lafortune {
    /// Checks all parameters; see [`LafortuneLobe::validate`].
    ///
    /// # Errors
    /// [`MaterialError`] that names what is wrong.
    pub fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("diffuse", self.diffuse)?;
        self.lobes.iter().try_for_each(LafortuneLobe::validate)
    }

    pub(crate) fn lobes<'a>(&'a self, at: &'a Receiver) -> impl Iterator<Item = Lobe> + Clone + 'a {
        (0..=self.lobes.len()).filter_map(|place| self.term(place)?.lobe(at))
    }

    pub(crate) fn term(&self, place: usize) -> Option<Term<'_>> {
        match place {
            0 => Some(Term::Diffuse(Diffuse(self.diffuse))),
            _ => self.lobes.get(place - 1).map(|lobe| Term::Lafortune(&lobe.term)),
        }
    }
}

impl BrdfLobes for Lafortune {
    fn max_lobes(&self) -> usize {
        1 + self.lobes.len()
    }

    fn brdf_lobes(&self, at: &Receiver, out: &mut LobesMut<'_>) -> Result<(), LobesFull> {
        self.lobes(at).try_for_each(|lobe| out.push(lobe))
    }
}

impl Brdf for Lafortune {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        let term = |l: &LafortuneLobe| {
            let (axis, gain) = l.term.axis_and_gain(at.normal, at.view);
            l.scale * gain * power(axis, v, l.exponent())
        };
        let specular: Vec3 = self.lobes.iter().map(term).sum();
        (self.diffuse * FRAC_1_PI + specular) * at.normal.dot(v).max(0.0)
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        draw(self.lobes(at), at.normal, u)
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        density(self.lobes(at), at.normal, v)
    }
}
