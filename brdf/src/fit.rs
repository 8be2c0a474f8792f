//! Lobes for any reflectance: the paper's way to measured materials.

use crate::{HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Material, MaterialError};
use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};
use glam::Vec3;

/// Lobes found for a reflectance, and how far they are from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted<M = Material> {
    /// The model.
    pub model: M,
    /// `√(Σ w (f − f′)² / Σ w f²)` over the samples and channels: 0 for a perfect fit, 1 for none.
    pub residual: f64,
}

/// The most lobes that are fitted.
pub const MAX_FITTED: usize = 8;

/// Nodes in `√θ_h`, θ_d and φ_d.
const NODES: [usize; 3] = [40, 12, 10];

/// Exponents that a lobe is begun with, from which they change by steps.
const EXPONENTS: [f32; 10] = [1.0, 2.5, 6.0, 15.0, 40.0, 100.0, 250.0, 700.0, 2000.0, 6000.0];
const ANGLES: usize = 48;

/// The same of half-vector lobes, between the least that the samples resolve and 1.
const ALPHAS: usize = 20;
const LEAST_ALPHA: f32 = 3e-3;

/// Fits a diffuse part and so many lobes to a reflectance: those of [`fit_lafortune`] or of [`fit_half_vector`], whichever leave less.
///
/// # Cost
/// Of one lobe some 0.1 s, of three a second.
///
/// # Errors
/// [`MaterialError::Coefficient`] where the reflectance is negative, above 1e12 or NaN.
///
/// # Panics
/// When more than [`MAX_FITTED`] lobes are requested.
///
/// ```
/// use brdf::{Brdf, Material, MetallicRoughness, fit};
/// use glam::Vec3;
/// use lobe_core::{Receiver};
/// let gold: Material = MetallicRoughness::new(Vec3::new(1.0, 0.77, 0.34), 1.0, 0.4)?.into();
/// let measured = |i: Vec3, o: Vec3| {
///     gold.eval(&Receiver::on_surface(Vec3::ZERO, Vec3::Z, o), i) / i.z
/// };
/// let fitted = fit(measured, 1)?;
/// assert!(matches!(fitted.model, Material::HalfVector(_)) && fitted.residual < 1e-3);
/// # Ok::<(), brdf::MaterialError>(())
/// ```
pub fn fit(reflectance: impl Fn(Vec3, Vec3) -> Vec3, lobes: usize) -> Result<Fitted, MaterialError> {
    let samples = Samples::new(reflectance)?;
    let (lafortune, half_vector) = (samples.lafortune(lobes), samples.half_vector(lobes));
    Ok(if half_vector.residual < lafortune.residual {
        Fitted { model: half_vector.model.into(), residual: half_vector.residual }
    } else {
        Fitted { model: lafortune.model.into(), residual: lafortune.residual }
    })
}

/// Fits the diffuse part and so many isotropic lobes of the [`Lafortune`] model to a reflectance `f_r(ω_i, ω_o)` in sr⁻¹, given in the frame
/// whose third axis is the normal: `Σ w (f_r − ρ/π − Σ k·max(ω_i·Mω_o, 0)^e)²` is least, with `w` the measure of the pair of directions
/// times `(cos θ_i cos θ_o)²`.
///
/// The directions are 4800 pairs, dense where half vectors are near the normal (S. Rusinkiewicz, *A New Change of Variables for Efficient
/// BRDF Representation*, 1998); lobes of exponents above some thousand fall between them. Scales are the least squares' own, not
/// negative; shapes are searched, one lobe after the other and then all together. The same input gives the same lobes, on any machine whose
/// arithmetic is IEEE 754.
///
/// # Accuracy
/// A sum of such lobes is found again to within 1 %. A metal of GGX (roughness 0.4) is left with residuals of 0.31, 0.25 and 0.24 by
/// one, two and three lobes, which do not grow toward grazing views as it does: [`fit_half_vector`] is for metals.
///
/// # Errors
/// [`MaterialError::Coefficient`] where the reflectance is negative, above 1e12 or NaN.
///
/// # Panics
/// When more than [`MAX_FITTED`] lobes are requested.
///
/// ```
/// use brdf::fit_lafortune;
/// use glam::Vec3;
/// // Paper with a sheen, as somebody measured it.
/// let measured = |i: Vec3, o: Vec3| {
///     let mirrored = Vec3::new(-o.x, -o.y, o.z);
///     Vec3::splat(0.2) + Vec3::new(0.5, 0.4, 0.3) * i.dot(mirrored).max(0.0).powi(30)
/// };
/// let fitted = fit_lafortune(measured, 1)?;
/// assert!(fitted.residual < 0.01);
/// assert!((fitted.model.lobes[0].exponent() - 30.0).abs() < 1.0);
/// # Ok::<(), brdf::MaterialError>(())
/// ```
pub fn fit_lafortune(
    reflectance: impl Fn(Vec3, Vec3) -> Vec3,
    lobes: usize,
) -> Result<Fitted<Lafortune>, MaterialError> {
    Ok(Samples::new(reflectance)?.lafortune(lobes))
}

/// Fits the diffuse part and so many lobes of the [`HalfVector`] model, by the directions and weights of [`fit_lafortune`]. Roughnesses are
/// searched down to 0.05, which the directions resolve; both reflectances of each lobe are the least squares' own.
///
/// # Accuracy
/// A metal of GGX is found again to a residual below 1e-3. A conductor with Beckmann's distribution of slopes and Fresnel's equations, which
/// the model does not have, is left with 0.16, by two and three lobes as by one; Lafortune's leave 0.35, 0.29 and 0.27.
///
/// # Errors
/// [`MaterialError::Coefficient`] where the reflectance is negative, above 1e12 or NaN.
///
/// # Panics
/// When more than [`MAX_FITTED`] lobes are requested.
pub fn fit_half_vector(
    reflectance: impl Fn(Vec3, Vec3) -> Vec3,
    lobes: usize,
) -> Result<Fitted<HalfVector>, MaterialError> {
    Ok(Samples::new(reflectance)?.half_vector(lobes))
}

/// The shape of a lobe: all that is not linear.
trait Shape: Copy {
    /// Steps of its two numbers to begin with; 0 where it has but one.
    const STEPS: [f32; 2];
    /// Shapes to begin with.
    fn starts() -> impl Iterator<Item = Self>;
    /// Its numbers changed by these steps.
    fn moved(self, by: [f32; 2]) -> Self;
    /// Its values at each pair: a column for each of its scales.
    fn columns(self, samples: &Samples) -> Vec<Vec<f32>>;
}

/// `M = diag(C, C, C_z)` by the angle whose cosine and sine are in the ratio of `C` and `C_z`, the larger of them ±1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Power {
    angle: f32,
    ln_exponent: f32,
}

impl Power {
    fn axes(self) -> [f32; 2] {
        let (s, c) = self.angle.sin_cos();
        let most = s.abs().max(c.abs());
        [c / most, s / most]
    }
}

impl Shape for Power {
    const STEPS: [f32; 2] = [TAU / ANGLES as f32 * 0.5, 0.4];

    fn starts() -> impl Iterator<Item = Self> {
        (0..ANGLES).flat_map(|i| {
            let angle = TAU * (i as f32 + 0.5) / ANGLES as f32;
            EXPONENTS.into_iter().map(move |exponent| Self { angle, ln_exponent: exponent.ln() })
        })
    }

    fn moved(self, [angle, exponent]: [f32; 2]) -> Self {
        Self { angle: self.angle + angle, ln_exponent: (self.ln_exponent + exponent).clamp(-3.0, 12.0) }
    }

    fn columns(self, samples: &Samples) -> Vec<Vec<f32>> {
        let ([across, along], exponent) = (self.axes(), self.ln_exponent.exp());
        let value = |pair: &Pair| (across * pair.across + along * pair.along).max(0.0).powf(exponent) * pair.weight;
        vec![samples.pairs.iter().map(value).collect()]
    }
}

/// GGX's `α`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Facets {
    ln_alpha: f32,
}

impl Shape for Facets {
    const STEPS: [f32; 2] = [0.2, 0.0];

    fn starts() -> impl Iterator<Item = Self> {
        (0..ALPHAS).map(|i| Self { ln_alpha: LEAST_ALPHA.ln() * i as f32 / (ALPHAS - 1) as f32 })
    }

    fn moved(self, [alpha, _]: [f32; 2]) -> Self {
        Self { ln_alpha: (self.ln_alpha + alpha).clamp(LEAST_ALPHA.ln(), 0.0) }
    }

    /// Of `1 − s` and of `s`.
    fn columns(self, samples: &Samples) -> Vec<Vec<f32>> {
        let alpha_sq = (2.0 * self.ln_alpha).exp();
        let mut columns = vec![Vec::new(); 2];
        for pair in &samples.pairs {
            let [l, v] = pair.cosines;
            let spread = alpha_sq * (1.0 - pair.half_sin_sq) + pair.half_sin_sq;
            let d = alpha_sq * FRAC_1_PI / (spread * spread);
            let slope = |cos: f32| (cos * cos * (1.0 - alpha_sq) + alpha_sq).sqrt();
            let value = d * 0.5 / (l * slope(v) + v * slope(l)) * pair.weight;
            columns[0].push(value * (1.0 - pair.schlick));
            columns[1].push(value * pair.schlick);
        }
        columns
    }
}

/// A pair of directions.
struct Pair {
    /// `ω_i·ω_o` within the surface and along the normal.
    across: f32,
    along: f32,
    /// Cosines of both to the normal.
    cosines: [f32; 2],
    /// `|n×h|²` and `(1 − ω_o·h)⁵` of their half vector.
    half_sin_sq: f32,
    schlick: f32,
    /// The root of its weight.
    weight: f32,
}

struct Samples {
    pairs: Vec<Pair>,
    /// Weighted reflectance, channel by channel.
    values: [Vec<f32>; 3],
    /// Weighted 1.
    flat: Vec<f32>,
    /// `Σ w f²`.
    total: f64,
}

/// Least-squares scales for some shapes: of the constant part and of each lobe.
struct Solved {
    scales: Vec<[f64; 3]>,
    residual: f64,
}

impl Samples {
    fn new(reflectance: impl Fn(Vec3, Vec3) -> Vec3) -> Result<Self, MaterialError> {
        let mut samples = Self { pairs: Vec::new(), values: Default::default(), flat: Vec::new(), total: 0.0 };
        let node = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
        for i in 0..NODES[0] {
            let t = node(i, NODES[0]);
            let (hs, hc) = (FRAC_PI_2 * t * t).sin_cos();
            for j in 0..NODES[1] {
                let (ds, dc) = (FRAC_PI_2 * node(j, NODES[1])).sin_cos();
                for k in 0..NODES[2] {
                    let (ps, pc) = (PI * node(k, NODES[2])).sin_cos();
                    // In the frame of the half vector, then turned with it.
                    let d = Vec3::new(ds * pc, ds * ps, dc);
                    let half = Vec3::new(hs, 0.0, hc);
                    let incoming = Vec3::new(d.x * hc + d.z * hs, d.y, d.z * hc - d.x * hs);
                    let outgoing = (2.0 * dc * half - incoming).normalize();
                    let cosines = incoming.z * outgoing.z;
                    if incoming.z <= 0.0 || outgoing.z <= 0.0 {
                        continue;
                    }
                    // dω_i dω_o = 4 cos θ_d sin θ_d sin θ_h dθ_h dφ_h dθ_d dφ_d, dθ_h ∝ t dt.
                    let weight = cosines * (4.0 * dc * ds * hs * t).sqrt();
                    let value = reflectance(incoming, outgoing);
                    crate::error::check_coefficient("reflectance", value)?;
                    let across = incoming.x * outgoing.x + incoming.y * outgoing.y;
                    samples.pairs.push(Pair {
                        across,
                        along: cosines,
                        cosines: [incoming.z, outgoing.z],
                        half_sin_sq: hs * hs,
                        schlick: (1.0 - dc).powi(5),
                        weight,
                    });
                    samples.flat.push(weight);
                    for (channel, value) in samples.values.iter_mut().zip(value.to_array()) {
                        channel.push(value * weight);
                        samples.total += f64::from(value * weight).powi(2);
                    }
                }
            }
        }
        Ok(samples)
    }

    fn lafortune(&self, lobes: usize) -> Fitted<Lafortune> {
        let (shapes, Solved { scales, residual }) = self.search::<Power>(lobes);
        let lobe = |(shape, scale): (&Power, &[f64; 3])| {
            let [across, along] = shape.axes();
            LafortuneLobe::diagonal(Vec3::new(across, across, along), shape.ln_exponent.exp(), color(scale))
        };
        let lobes = shapes.iter().zip(&scales[1..]).map(lobe).collect();
        Fitted { model: Lafortune { diffuse: color(&scales[0]) * PI, lobes }, residual }
    }

    fn half_vector(&self, lobes: usize) -> Fitted<HalfVector> {
        let (shapes, Solved { scales, residual }) = self.search::<Facets>(lobes);
        let lobe = |(shape, pair): (&Facets, &[[f64; 3]])| {
            HalfVectorLobe::new((0.5 * shape.ln_alpha).exp().min(1.0), color(&pair[0]), color(&pair[1]))
        };
        let lobes = shapes.iter().zip(scales[1..].chunks_exact(2)).map(lobe).collect();
        Fitted { model: HalfVector { diffuse: color(&scales[0]) * PI, lobes }, residual }
    }

    /// So many shapes, and their scales, of which the first is the constant part's.
    fn search<S: Shape>(&self, lobes: usize) -> (Vec<S>, Solved) {
        assert!(lobes <= MAX_FITTED, "at most {MAX_FITTED} lobes");
        let (mut shapes, mut columns) = (Vec::new(), Vec::new());
        for _ in 0..lobes {
            if let Some(begun) = self.best_next::<S>(&columns) {
                columns.push(begun.columns(self));
                shapes.push(begun);
                self.refine(&mut shapes, &mut columns);
            }
        }
        let solved = self.solve(&columns);
        (shapes, solved)
    }

    fn solve(&self, columns: &[Vec<Vec<f32>>]) -> Solved {
        let mut all: Vec<&[f32]> = vec![&self.flat];
        all.extend(columns.iter().flatten().map(Vec::as_slice));
        self.solve_columns(&all)
    }

    /// Non-negative least squares from the normal equations, by going down one scale after the other.
    fn solve_columns(&self, columns: &[&[f32]]) -> Solved {
        let n = columns.len();
        let gram: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| if j <= i { dot(columns[i], columns[j]) } else { 0.0 }).collect()).collect();
        let gram = |i: usize, j: usize| if j <= i { gram[i][j] } else { gram[j][i] };
        let (mut scales, mut explained) = (vec![[0.0; 3]; n], 0.0);
        for (channel, values) in self.values.iter().enumerate() {
            let right: Vec<f64> = columns.iter().map(|column| dot(column, values)).collect();
            let mut x = vec![0.0; n];
            for _ in 0..2000 {
                let mut moved = 0.0_f64;
                for i in 0..n {
                    let own = gram(i, i);
                    if own <= 0.0 {
                        continue;
                    }
                    let others: f64 = (0..n).filter(|j| *j != i).map(|j| gram(i, j) * x[j]).sum();
                    let next = ((right[i] - others) / own).max(0.0);
                    moved = moved.max((next - x[i]).abs() * own.sqrt());
                    x[i] = next;
                }
                if moved <= 1e-9 * self.total.sqrt() {
                    break;
                }
            }
            // ‖f‖² − ‖f − Ax‖² = 2 xᵀAᵀf − xᵀAᵀAx.
            for i in 0..n {
                scales[i][channel] = x[i];
                explained += 2.0 * x[i] * right[i] - x[i] * (0..n).map(|j| gram(i, j) * x[j]).sum::<f64>();
            }
        }
        let residual = if self.total > 0.0 { ((self.total - explained).max(0.0) / self.total).sqrt() } else { 0.0 };
        Solved { scales, residual }
    }

    /// The shape that leaves least beside those that are there.
    fn best_next<S: Shape>(&self, columns: &[Vec<Vec<f32>>]) -> Option<S> {
        let mut all = columns.to_vec();
        let mut best = (f64::INFINITY, None);
        for shape in S::starts() {
            all.push(shape.columns(self));
            let residual = self.solve(&all).residual;
            all.pop();
            if residual < best.0 {
                best = (residual, Some(shape));
            }
        }
        best.1
    }

    /// Steps of a lobe's numbers, of one at a time, as long as they gain; then half as long.
    fn refine<S: Shape>(&self, shapes: &mut [S], columns: &mut [Vec<Vec<f32>>]) {
        let mut least = self.solve(columns).residual;
        let [mut first, mut second] = S::STEPS;
        for _ in 0..12 {
            for _ in 0..30 {
                let before = least;
                for k in 0..shapes.len() {
                    for by in [[first, 0.0], [-first, 0.0], [0.0, second], [0.0, -second]] {
                        if by == [0.0; 2] {
                            continue;
                        }
                        let moved = shapes[k].moved(by);
                        let old = core::mem::replace(&mut columns[k], moved.columns(self));
                        let residual = self.solve(columns).residual;
                        if residual < least {
                            (least, shapes[k]) = (residual, moved);
                        } else {
                            columns[k] = old;
                        }
                    }
                }
                if least > before * (1.0 - 1e-4) {
                    break;
                }
            }
            (first, second) = (0.5 * first, 0.5 * second);
        }
    }
}

fn color(scale: &[f64; 3]) -> Vec3 {
    Vec3::from_array(scale.map(|s| s as f32))
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    // By runs: as exact as needed, and in vectors.
    a.chunks(256).zip(b.chunks(256)).map(|(a, b)| f64::from(a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>())).sum()
}
