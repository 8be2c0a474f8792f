//! One lobe of the Lafortune model as constants.

use crate::error::MAX_COEFFICIENT;
use crate::shape::Shape;
use crate::symmetric::eigen;
use glam::{DMat3, DVec3, Mat3, Vec3};
use lobe_core::special::{exp, ln_of};
use lobe_core::{Lobe, orthonormal_basis};

/// A lobe's constants for any matrix, the same numbers on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct LafortuneTerm {
    pub(crate) matrix: Mat3,
    /// Eigenvectors, as columns, and eigenvalues of `MᵀM − 1`.
    vectors: Mat3,
    values: Vec3,
    /// Without the gain.
    flux: Vec3,
    pub(crate) exponent: f32,
}

/// The constants where `M = diag(C, C, C_z)`: a third of the numbers, and no frame.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct IsotropicTerm {
    flux: Vec3,
    exponent: f32,
    /// `C`, `C_z − C`, `C² − 1`, `C_z² − C²`.
    across: f32,
    along: f32,
    across_excess: f32,
    along_excess: f32,
}

impl LafortuneTerm {
    pub(crate) fn new(matrix: Mat3, exponent: f32, flux: Vec3) -> Self {
        let m = as_dmat3(matrix);
        let (vectors, values) = eigen(m.transpose() * m - DMat3::IDENTITY);
        Self { matrix, vectors: vectors.as_mat3(), values: values.as_vec3(), flux, exponent }
    }

    /// The same in fewer numbers, if the matrix has it.
    pub(crate) fn isotropic(&self) -> Option<IsotropicTerm> {
        let (across, up) = (self.matrix.x_axis.x, self.matrix.z_axis.z);
        let excess = |c: f32| f64::from(c) * f64::from(c) - 1.0;
        (self.matrix == Mat3::from_diagonal(Vec3::new(across, across, up))).then(|| IsotropicTerm {
            flux: self.flux,
            exponent: self.exponent,
            across,
            along: up - across,
            across_excess: excess(across) as f32,
            along_excess: (excess(up) - excess(across)) as f32,
        })
    }

    /// Unit axis `Mω_o/|Mω_o|` in world space and `|Mω_o|^e`; 0 where `Mω_o = 0`.
    #[inline(always)]
    fn axis_and_gain(&self, normal: Vec3, view: Vec3) -> (Vec3, f32) {
        let (t, b) = orthonormal_basis(normal);
        let view = Vec3::new(t.dot(view), b.dot(view), normal.dot(view));
        let m = self.matrix * view;
        let axis = |m: Vec3| t * m.x + b * m.y + normal * m.z;
        let along =
            Vec3::new(self.vectors.x_axis.dot(view), self.vectors.y_axis.dot(view), self.vectors.z_axis.dot(view));
        unit_and_power(m, axis, self.values.dot(along * along), self.exponent, normal)
    }
}

/// Unit vector along `axis(m)` and the length of `m` to the power `e`; 0 where there is no length. `excess` is `|m|² − 1`.
///
/// `|Mω|² − 1 = ωᵀ(MᵀM − 1)ω` for a unit ω. By the eigenvectors it loses no digits: a mirror-like lobe (`M² = 1`) has none
/// of it, and where a large exponent makes it matter all eigenvalues are negative, or the lobe would be too high. The
/// rounded length of `Mω` to the power 1e5 would be 1 % off.
#[inline(always)]
fn unit_and_power(m: Vec3, axis: impl Fn(Vec3) -> Vec3, excess: f32, e: f32, normal: Vec3) -> (Vec3, f32) {
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    let largest = larger(larger(m.x.abs(), m.y.abs()), m.z.abs());
    let is_zero = largest < 1e-30;
    let axis = axis(m * (1.0 / if is_zero { 1.0 } else { largest }));
    let square = axis.dot(axis);
    let axis = axis * (1.0 / if is_zero { 1.0 } else { square.sqrt() });
    // Far below 1 the length itself has the digits.
    let short = excess <= -0.5;
    let ln = ln_of(if short { largest } else { 1.0 + excess }, if short { largest - 1.0 } else { excess });
    let ln_length = if short { ln + 0.5 * ln_of(square, square - 1.0) } else { 0.5 * ln };
    let gain = exp(e * ln_length);
    let gain = if gain < MAX_COEFFICIENT { gain } else { MAX_COEFFICIENT };
    (if is_zero { normal } else { axis }, if is_zero { 0.0 } else { gain })
}

impl Shape<25> for LafortuneTerm {
    #[inline(always)]
    fn lobe(&self, normal: Vec3, view: Vec3) -> Lobe {
        let (axis, gain) = self.axis_and_gain(normal, view);
        Lobe { axis, exponent: self.exponent, flux: self.flux * gain, has_cosine: true }
    }
}

impl Shape<8> for IsotropicTerm {
    #[inline(always)]
    fn lobe(&self, normal: Vec3, view: Vec3) -> Lobe {
        let cos = normal.dot(view);
        let m = view * self.across + normal * (self.along * cos);
        let excess = self.across_excess + self.along_excess * (cos * cos);
        let (axis, gain) = unit_and_power(m, |m| m, excess, self.exponent, normal);
        Lobe { axis, exponent: self.exponent, flux: self.flux * gain, has_cosine: true }
    }
}

fn as_dmat3(m: Mat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.as_dvec3(), m.y_axis.as_dvec3(), m.z_axis.as_dvec3())
}

/// Largest singular value of a symmetric matrix, by power iteration on its square.
pub(crate) fn spectral_norm(m: Mat3) -> f64 {
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
