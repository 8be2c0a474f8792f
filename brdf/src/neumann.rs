use crate::error::{check_coefficient, check_metal_exponent};
use crate::sampling::{density, draw};
use crate::shape::mirrored_view;
use crate::wgsl::{ModelWgsl, TURN};
use crate::{Brdf, BrdfSample, Factors, Material, MaterialError, Model, Packer, phong};
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::Vec3;
use lobe_core::wgsl::{Number, Piece};
use lobe_core::wgsl_numbers;
use lobe_core::{BrdfLobe, Lobe, Receiver, orthonormal_basis, power};
use shading::BrdfLobes;

/// Neumann et al.'s *stretched Phong* model of metals: `f_r = kd/π + ks·(e+2)/2π·max(r·v, 0)^e / max(n·v, n·ω_o)`, `r` the mirrored
/// view (L. Neumann, A. Neumann, L. Szirmay-Kalos, *Compact Metallic Reflectance Models*, 1999; \[25\] of the paper).
///
/// Unlike [`ModifiedPhong`](crate::ModifiedPhong)'s its highlight keeps its brightness toward grazing views, as a metal's does, and for
/// `e → ∞` it is an ideal mirror. Reciprocal; conserves energy while `kd + ks ≤ 1`, for exponents from 1.
///
/// # Lobes
/// `f̃` is a lobe about `r` where `n·v > n·ω_o`, and that times `(n·v)/(n·ω_o)` below. With `k = tan θ_o/√(e+1)`, how much the divisor
/// varies over the lobe, two lobes times the receiver's cosine stand for it, beside each other and somewhat narrower; from `k = 0.8` on
/// a third without cosine. Their shapes are least squares over `k` for narrow lobes, their flux is the model's.
///
/// Residuals, the root mean square of the difference over that of the values, by exponent and angle of the view:
///
/// | exponent | 0° | 30° | 50° | 65° | 75° | 82° |
/// |---|---|---|---|---|---|---|
/// | 1 | 0.0 % | 11.3 % | 18.1 % | 26.0 % | 52.6 % | 51.1 % |
/// | 5 | 0.0 % | 5.8 % | 6.9 % | 8.8 % | 9.4 % | 17.6 % |
/// | 20 | 0.0 % | 2.2 % | 2.9 % | 4.3 % | 6.0 % | 6.3 % |
/// | 100 | 0.0 % | 0.6 % | 1.1 % | 1.8 % | 3.0 % | 5.2 % |
/// | 1000 | 0.0 % | 0.1 % | 0.3 % | 0.5 % | 0.9 % | 1.8 % |
/// | 100000 | 0.0 % | 0.0 % | 0.0 % | 0.1 % | 0.1 % | 0.2 % |
///
/// From exponent 10 on their flux is the model's within 0.3 %.
///
/// ```
/// use brdf::{Brdf, Neumann};
/// use glam::Vec3;
/// use lobe_core::{Receiver};
/// let gold = Neumann { kd: Vec3::ZERO, ks: Vec3::new(1.0, 0.77, 0.34), exponent: 60.0 };
/// let at = |view| Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
/// let (steep, grazing) = (Vec3::Z, Vec3::new(0.96, 0.0, 0.28));
/// // As bright in its mirrored direction from everywhere.
/// let mirrored = Vec3::new(-0.96, 0.0, 0.28);
/// let difference = gold.eval(&at(steep), steep) - gold.eval(&at(grazing), mirrored);
/// assert!(difference.abs().max_element() < 1e-3 * gold.eval(&at(steep), steep).x);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Neumann {
    /// Fraction of light that is reflected diffusely; a metal has none.
    pub kd: Vec3,
    /// Fraction that is reflected in the highlight at normal incidence, the metal's colour; a few per cent less at others.
    pub ks: Vec3,
    /// Exponent of the highlight, in [1, 1e7].
    pub exponent: f32,
}

/// Lobes for `k/(1+k) = 0, 1/16 … 15/16`: weight of the lobes with cosine at their axis, relative to the peak; how far they are tilted
/// away from the normal, in lobe widths `1/√(e+1)`; their exponent over `e`; the square of how far each is aside, in lobe widths. Then
/// weight, tilt and exponent of the lobe without cosine; and what the others' weight grows by, times `e + 5`, where lobes are not narrow.
const SHAPES: [[f32; 8]; 16] = [
    [1.0, 0.0, 1.0, 0.0, 0.0, -1.3434, 1.3521, 0.0],
    [1.0105, 0.0310, 1.0359, 0.0340, 0.0, -1.3434, 1.3521, 0.43],
    [1.0216, 0.0618, 1.0738, 0.0663, 0.0, -1.3434, 1.3521, 0.43],
    [1.0328, 0.0931, 1.1131, 0.0962, 0.0, -1.3434, 1.3521, 0.43],
    [1.0428, 0.1259, 1.1523, 0.1228, 0.0, -1.3434, 1.3521, 0.43],
    [1.0494, 0.1640, 1.1857, 0.1434, 0.0, -1.3434, 1.3521, 0.43],
    [1.0516, 0.2137, 1.2045, 0.1544, 0.0, -1.3434, 1.3521, 0.43],
    [1.0490, 0.2914, 1.1902, 0.1461, 0.0, -1.3434, 1.3521, 0.43],
    [1.1553, 0.3457, 1.4697, 0.2796, 0.1233, -1.3434, 1.3521, 0.43],
    [1.1955, 0.4739, 1.3984, 0.2616, 0.1251, -1.3867, 1.4502, 0.22],
    [1.3028, 0.7405, 1.1998, 0.1762, 0.1147, -1.4176, 1.5, 0.0],
    [1.7344, 1.2239, 0.9799, 0.0192, 0.1260, -1.3406, 1.5, 0.0],
    [2.6556, 1.6, 0.9656, 0.0269, 0.1997, -1.1551, 1.4174, 0.0],
    [3.3522, 1.6, 1.2096, 0.2530, 0.3343, -0.9180, 1.3258, 0.0],
    [3.6499, 1.6, 1.4838, 0.3814, 0.4663, -0.7023, 1.2408, 0.0],
    [3.1679, 1.6, 1.8199, 0.4555, 0.5881, -0.5188, 1.1584, 0.0],
];

/// The largest `k`: beyond, the divisor is constant in all of the lobe that is above the horizon.
const STEEPEST: f32 = (SHAPES.len() - 1) as f32;

impl Neumann {
    const LOBES: usize = 4;

    pub(crate) fn lobes(&self, at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
        let n = at.normal;
        let diffuse = Lobe::with_flux(n, 1.0, self.kd);
        // Views below the horizon, which smooth normals have, are taken as at it.
        let along = n * n.dot(at.view) - at.view;
        let length = along.length();
        let forward = if length > 1e-12 { along / length } else { orthonormal_basis(n).0 };
        let sin = if length < 1.0 { length } else { 1.0 };
        let sigma = 1.0 / (self.exponent + 1.0).sqrt();
        let cos = n.dot(at.view).clamp(0.0, 1.0);
        let least = sin * sigma * (1.0 / STEEPEST);
        let divisor = if cos > least { cos } else { least };

        // Even in k/(1 + k), sixteen to 1.
        let place = STEEPEST * (sin * sigma / (divisor + sin * sigma)) * (16.0 / 15.0);
        let first = (place as usize).min(SHAPES.len() - 2);
        let t = place - first as f32;
        let number = |k: usize| SHAPES[first][k] + (SHAPES[first + 1][k] - SHAPES[first][k]) * t;
        let side = n.cross(forward);
        let axis = |tilt: f32, aside: f32| {
            let (s, c) = (tilt * sigma).sin_cos();
            let middle = (n * cos + forward * sin) * c + (forward * cos - n * sin) * s;
            let (s, c) = (aside * sigma).sin_cos();
            (middle * c + side * s).normalize_or(n)
        };
        let lobe = |axis: Vec3, ratio: f32, weight: f32| {
            let exponent = self.exponent * ratio;
            Lobe::with_flux(axis, exponent, self.ks * (weight * (self.exponent + 2.0) / (exponent + 1.0)))
        };
        let weight = 0.5 * number(0) * (1.0 + number(7) / (self.exponent + 5.0)) / divisor;
        let [tilt, ratio, aside] = [number(1), number(2), number(3).sqrt()];
        let pair = [aside, -aside].map(|aside| lobe(axis(tilt, aside), ratio, weight).times_cosine());
        let plain = lobe(axis(number(5), 0.0), number(6), number(4));
        [diffuse, pair[0], pair[1], plain].into_iter().filter(|lobe| lobe.flux != Vec3::ZERO)
    }

    /// Directions are drawn from these: the diffuse part, and the lobe that is divided.
    fn drawn_from(&self, at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
        let highlight = Lobe::with_flux(mirrored_view(at.normal, at.view), self.exponent, self.ks);
        [Lobe::with_flux(at.normal, 1.0, self.kd), highlight].into_iter()
    }
}

impl BrdfLobes for Neumann {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at).map(BrdfLobe::Cosine));
    }
}

impl Brdf for Neumann {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        let (cos, view, e) = (at.normal.dot(v), at.normal.dot(at.view), self.exponent);
        if cos <= 0.0 {
            return Vec3::ZERO;
        }
        let highlight = (e + 2.0) / TAU * power(mirrored_view(at.normal, at.view), v, e) * cos / cos.max(view);
        self.kd * (FRAC_1_PI * cos) + self.ks * highlight
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        draw(self.drawn_from(at), at.normal, u)
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        density(self.drawn_from(at), at.normal, v)
    }
}

/// Eight numbers as a `mat2x4f`.
struct Shape([f32; 8]);

impl Number for Shape {
    fn write(&self, out: &mut String) {
        out.push_str("mat2x4f(");
        for number in self.0 {
            number.write(out);
            out.push_str(", ");
        }
        out.push(')');
    }
}

static WGSL: Piece = Piece::new(include_str!("neumann.wgsl"))
    .numbers(wgsl_numbers![NEUMANN_SHAPES = SHAPES.map(Shape), NEUMANN_STEEPEST = STEEPEST])
    .needs(&[&TURN]);

/// The coefficients are finite and not negative, the exponent in range.
impl Model for Neumann {
    fn name(&self) -> &'static str {
        "neumann"
    }

    fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("kd", self.kd)?;
        check_coefficient("ks", self.ks)?;
        check_metal_exponent(self.exponent)
    }

    fn lobe_count(&self) -> usize {
        Self::LOBES
    }

    fn scaled(&self, by: &Factors) -> Option<Material> {
        let exponent = (self.exponent * by.exponent).max(1.0);
        Some(Self { kd: self.kd * by.color, ks: self.ks * by.specular, exponent }.into())
    }

    fn wgsl(&self) -> Option<ModelWgsl> {
        Some(ModelWgsl::new("neumann", &WGSL))
    }

    fn pack(&self, out: &mut Packer) -> u32 {
        let highlight = phong::pack([self.kd, self.ks * (self.exponent + 2.0)], self.exponent, out);
        // For the one of Phong's.
        highlight + if self.ks == Vec3::ZERO { 0 } else { Self::LOBES as u32 - 2 }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use core::f64::consts::PI;
    use glam::DVec3;

    const EXPONENTS: [f32; 6] = [1.0, 5.0, 20.0, 100.0, 1000.0, 1e5];
    const VIEWS: [f64; 6] = [0.0, 30.0, 50.0, 65.0, 75.0, 82.0];

    /// The printed formula in f64, of `ks` 1 and without a diffuse part.
    fn oracle(e: f64, view: DVec3, v: DVec3) -> f64 {
        let along = DVec3::new(-view.x, -view.y, view.z).dot(v);
        (e + 2.0) / (2.0 * PI) * along.max(0.0).powf(e) * v.z / v.z.max(view.z)
    }

    fn view(degrees: f64) -> DVec3 {
        DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos())
    }

    fn receiver(view: DVec3) -> Receiver {
        let view = view.as_vec3().normalize();
        Receiver::on_surface(Vec3::ZERO, Vec3::Z, view)
    }

    /// `∫ f(v) dv` over what is above the horizon, by rings about the mirrored view as dense as a lobe of exponent `e`.
    fn about_mirror<const N: usize>(e: f64, view: DVec3, mut f: impl FnMut(DVec3) -> [f64; N]) -> [f64; N] {
        let r = DVec3::new(-view.x, -view.y, view.z);
        let (t, b) = r.any_orthonormal_pair();
        let (rings, sectors) = (160, 96);
        let mut sums = [0.0; N];
        for i in 0..rings {
            // 1 − cos = 1 − (1 − u)^(2/(e+1)), to a right angle.
            let u = (f64::from(i) + 0.5) / f64::from(rings);
            let power = 2.0 / (e + 1.0);
            let off = -(power * (-u).ln_1p()).exp_m1();
            let area = power * (1.0 - u).powf(power - 1.0) / f64::from(rings) * 2.0 * PI / f64::from(sectors);
            let (cos, sin) = (1.0 - off, (off * (2.0 - off)).sqrt());
            for j in 0..sectors {
                let (s, c) = ((f64::from(j) + 0.5) / f64::from(sectors) * 2.0 * PI).sin_cos();
                let v = r * cos + (t * c + b * s) * sin;
                if v.z > 0.0 {
                    sums.iter_mut().zip(f(v)).for_each(|(sum, x)| *sum += area * x);
                }
            }
        }
        sums
    }

    /// Of the lobes: root mean square of the difference over that of the values, and their flux over the model's.
    pub(crate) fn residual(exponent: f32, degrees: f64) -> [f64; 2] {
        let model = Neumann { ks: Vec3::ONE, exponent, ..Neumann::default() };
        let (view, at) = (view(degrees), receiver(view(degrees)));
        let mut lobes = Vec::new();
        model.brdf_lobes(&at, &mut lobes);
        let e = f64::from(exponent);
        let [error, square, flux, want] = about_mirror(e, view, |v| {
            let want = oracle(e, view, v);
            let got = f64::from(BrdfLobe::sum_at(&lobes, Vec3::Z, v.as_vec3().normalize()).x);
            [(got - want).powi(2), want * want, got, want]
        });
        [(error / square).sqrt(), flux / want]
    }

    /// The table of the model's documentation.
    #[test]
    fn residuals_are_those_that_are_published() {
        let documentation = include_str!("neumann.rs");
        for exponent in EXPONENTS {
            let row = VIEWS.map(|degrees| residual(exponent, degrees));
            let cells: Vec<String> = row.iter().map(|[error, _]| format!("{:.1} %", 100.0 * error)).collect();
            let line = format!("/// | {exponent} | {} |", cells.join(" | "));
            println!("{line} flux {:.4?}", row.map(|[_, flux]| flux));
            let start = format!("/// | {exponent} |");
            let published = documentation.lines().find(|line| line.starts_with(&start)).expect("a row");
            let published = published[start.len()..].split('|').map(|cell| cell.trim().trim_end_matches(" %").parse());
            for (published, [error, _]) in published.zip(&row) {
                let published: f64 = published.expect("a number");
                assert!((published - 100.0 * error).abs() < 0.06, "{line}");
            }
            assert!(
                row.iter().all(|[_, flux]| (flux - 1.0).abs() < if exponent < 10.0 { 0.25 } else { 3e-3 }),
                "{exponent}: {row:?}"
            );
        }
        // To grazing views, and between the nodes.
        for (exponent, limits) in [(5.0, [0.3, 0.2]), (10.0, [0.15, 0.1]), (300.0, [0.12, 0.03]), (1e7, [0.12, 0.03])] {
            for step in 0..45 {
                let [error, flux] = residual(exponent, 2.0 * f64::from(step));
                let fine = error < limits[0] && (flux - 1.0).abs() < limits[1];
                assert!(fine, "{exponent} {}: {error} {flux}", 2 * step);
            }
        }
    }

    /// A white one gives back no more than it gets: all of it at normal incidence, and as a mirror from everywhere.
    #[test]
    fn white_furnace() {
        for exponent in [1.0, 2.0, 5.0, 30.0, 1000.0, 1e6] {
            let model = Neumann { ks: Vec3::ONE, exponent, ..Neumann::default() };
            for step in 0..45 {
                let view = view(2.0 * f64::from(step));
                let at = receiver(view);
                let e = f64::from(exponent);
                let [albedo, oracle] = about_mirror(e, view, |v| {
                    [f64::from(model.eval(&at, v.as_vec3().normalize()).x), oracle(e, view, v)]
                });
                assert!((albedo - oracle).abs() < 2e-3, "{exponent} {step}: {albedo} {oracle}");
                assert!(albedo < 1.002 && (step > 0 || albedo > 0.998), "{exponent} {step}: {albedo}");
                assert!(exponent < 1e6 || step > 40 || albedo > 0.99, "{step}: {albedo}");
            }
        }
    }

    #[test]
    fn finite_from_everywhere() {
        for exponent in [1.0, 3.0, 1e7] {
            let model = Neumann { kd: Vec3::ONE, ks: Vec3::ONE, exponent };
            model.validate().expect("in range");
            for step in 0..400 {
                let at = receiver(DVec3::new(f64::sin(f64::from(step) * 0.01), 0.0, f64::cos(f64::from(step) * 0.01)));
                for lobe in model.lobes(&at) {
                    assert!(lobe.axis.is_normalized() && lobe.flux.is_finite() && lobe.flux.min_element() > 0.0);
                    assert!((0.0..=2e7).contains(&lobe.exponent), "{lobe:?}");
                }
                assert!(model.eval(&at, Vec3::new(0.6, 0.0, 0.8)).is_finite());
            }
        }
        let bad = Neumann { ks: Vec3::ONE, exponent: 0.9, ..Neumann::default() };
        assert!(bad.validate().expect_err("out of range").to_string().contains("[1, 1e7]"));
    }
}
