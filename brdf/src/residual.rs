use crate::Brdf;
use core::f64::consts::{FRAC_1_PI, TAU};
use glam::Vec3;
use lobe_core::{BrdfLobe, Receiver};

/// Angles of the views to the normal, in degrees.
const VIEWS: [f32; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];

/// Directions of each view: from the material, and as many from the whole hemisphere.
const DRAWN: u32 = 256;

/// How far a material's lobes are from the material: `√(∫ (f̃ − Σ lobes)² dv / ∫ f̃² dv)`, root mean square over views up to 75° from the
/// normal. No tolerance makes errors of highlights much smaller than this. 0 for a black material; below 1e-3 the lobes are the material.
///
/// # Accuracy
/// A tenth of itself: 512 directions a view, drawn in proportion to the material and to the cosine.
///
/// # Cost
/// A millisecond.
///
/// ```
/// use brdf::{MetallicRoughness, residual, residual_of_cosine_lobes};
/// let gold = MetallicRoughness::new(glam::Vec3::new(1.0, 0.77, 0.34), 1.0, 0.4)?;
/// assert!(residual(&gold) < 1e-3);
/// assert!(residual_of_cosine_lobes(&gold) > 0.05);
/// # Ok::<(), brdf::MaterialError>(())
/// ```
#[must_use]
pub fn residual<B: Brdf>(material: &B) -> f64 {
    residual_of(material, B::brdf_lobes)
}

/// The same of a material's [cosine lobes](shading::BrdfLobes::cosine_lobes).
///
/// # Cost
/// A few milliseconds where these come from tables that are not there yet.
#[must_use]
pub fn residual_of_cosine_lobes<B: Brdf>(material: &B) -> f64 {
    residual_of(material, B::cosine_lobes)
}

fn residual_of<B: Brdf>(material: &B, lobes_of: impl Fn(&B, &Receiver, &mut Vec<BrdfLobe>)) -> f64 {
    let mut lobes = Vec::new();
    let (mut sum, mut views) = (0.0, 0);
    for degrees in VIEWS {
        let (s, c) = degrees.to_radians().sin_cos();
        let view = Vec3::new(s, 0.0, c);
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        lobes.clear();
        lobes_of(material, &at, &mut lobes);
        let (mut error, mut square) = (0.0, 0.0);
        let mut add = |v: Vec3| {
            let pdf = f64::from(material.pdf(&at, v)) + f64::from(v.z) * FRAC_1_PI;
            if v.z > 0.0 && pdf > 0.0 {
                let (want, got) = (material.eval(&at, v).as_dvec3(), BrdfLobe::sum_at(&lobes, Vec3::Z, v).as_dvec3());
                error += (got - want).length_squared() / pdf;
                square += want.length_squared() / pdf;
            }
        };
        for k in 0..DRAWN {
            let [a, b, c] = point(k);
            let (sin, turn) = (a.sqrt(), TAU * b);
            add(Vec3::new((sin * turn.cos()) as f32, (sin * turn.sin()) as f32, (1.0 - a).sqrt() as f32).normalize());
            if let Some(drawn) = material.sample(&at, [c, a, b].map(|x| (x as f32).min(0.999_999_9))) {
                add(drawn.direction);
            }
        }
        if square > 0.0 {
            sum += error / square;
            views += 1;
        }
    }
    if views > 0 { (sum / f64::from(views)).sqrt() } else { 0.0 }
}

/// The fractions of `k·g^-i` of the generalised golden ratio: points that fill the cube evenly.
fn point(k: u32) -> [f64; 3] {
    let g = 1.220_744_084_605_759_5_f64;
    [1, 2, 3].map(|i| (0.5 + f64::from(k) * g.powi(-i)).fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, Neumann};

    #[test]
    fn lobes_that_are_the_material_leave_nothing() {
        let metal = |roughness| MetallicRoughness::new(Vec3::splat(0.8), 1.0, roughness).expect("in range");
        let mirror = LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 0.9), 400.0, Vec3::ONE);
        let exact: [Material; 6] = [
            Lambert { albedo: Vec3::splat(0.5) }.into(),
            Lambert::default().into(),
            Lafortune { diffuse: Vec3::ONE, lobes: vec![mirror] }.into(),
            metal(0.05).into(),
            metal(0.7).into(),
            HalfVector { diffuse: Vec3::ZERO, lobes: vec![HalfVectorLobe::new(0.3, Vec3::ONE, Vec3::ONE)] }.into(),
        ];
        for material in exact {
            let residual = residual(&material);
            assert!(residual < 1e-3, "{material:?}: {residual}");
        }
    }

    /// Against rings about the mirrored view, in f64.
    #[test]
    fn residuals_are_those_of_quadrature() {
        for exponent in [20.0, 100.0, 1000.0] {
            let square = |degrees: f32| crate::neumann::tests::residual(exponent, f64::from(degrees))[0].powi(2);
            let want = (VIEWS.map(square).iter().sum::<f64>() / VIEWS.len() as f64).sqrt();
            let got = residual(&Neumann { kd: Vec3::ZERO, ks: Vec3::ONE, exponent });
            println!("{exponent}: {got:.4} for {want:.4}");
            assert!((got / want - 1.0).abs() < 0.1, "{exponent}: {got} {want}");
        }
        let glossy = |roughness| MetallicRoughness::new(Vec3::splat(0.8), 1.0, roughness).expect("in range");
        let [narrow, broad] = [0.3, 0.9].map(|roughness| residual_of_cosine_lobes(&glossy(roughness)));
        println!("GGX by cosine lobes: {narrow:.3}, {broad:.3}");
        assert!(narrow > broad && narrow < 0.4, "{narrow} {broad}");
    }
}
