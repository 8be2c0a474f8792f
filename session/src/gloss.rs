//! Materials by the two numbers that matter most: how sharp their highlights are, and their colour.

use brdf::{HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, ModifiedPhong, Neumann, Phong};
use glam::Vec3;

/// How sharp highlights are, in the material's own number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gloss {
    /// The exponent of a cosine lobe, of several the first one's.
    Exponent(f32),
    /// Roughness in [0, 1], of several lobes the first one's.
    Roughness(f32),
}

/// The sharpness of a material's highlights; none where it has none, or is not built in.
///
/// ```
/// use session::gloss::{Gloss, of, with};
/// let brass = brdf::MetallicRoughness::new(glam::Vec3::ONE, 1.0, 0.5)?.into();
/// assert_eq!(of(&brass), Some(Gloss::Roughness(0.5)));
/// assert_eq!(of(&with(&brass, 0.2)), Some(Gloss::Roughness(0.2)));
/// # Ok::<(), brdf::MaterialError>(())
/// ```
#[must_use]
pub fn of(material: &Material) -> Option<Gloss> {
    match material {
        Material::Phong(Phong { exponent, .. })
        | Material::ModifiedPhong(ModifiedPhong { exponent, .. })
        | Material::Neumann(Neumann { exponent, .. }) => Some(Gloss::Exponent(*exponent)),
        Material::Lafortune(all) => all.lobes.first().map(|lobe| Gloss::Exponent(lobe.exponent())),
        Material::MetallicRoughness(metal) => Some(Gloss::Roughness(metal.base().2)),
        Material::HalfVector(all) => all.lobes.first().map(|lobe| Gloss::Roughness(lobe.roughness())),
        _ => None,
    }
}

/// The material with another exponent, or another roughness, of its first lobe; the others follow by the same factor. The same material
/// where it has neither, or the number is out of its range.
#[must_use]
pub fn with(material: &Material, number: f32) -> Material {
    let changed: Material = match material {
        Material::Phong(phong) => Phong { exponent: number, ..*phong }.into(),
        Material::ModifiedPhong(phong) => ModifiedPhong { exponent: number, ..*phong }.into(),
        Material::Neumann(metal) => Neumann { exponent: number, ..*metal }.into(),
        Material::Lafortune(all) => {
            let factor = all.lobes.first().map_or(1.0, |first| number / first.exponent().max(1e-3));
            let lobe = |(place, lobe): (usize, &LafortuneLobe)| {
                let exponent = if place == 0 { number } else { lobe.exponent() * factor };
                LafortuneLobe::new(lobe.matrix(), exponent, lobe.scale())
            };
            Lafortune { lobes: all.lobes.iter().enumerate().map(lobe).collect(), ..all.clone() }.into()
        }
        Material::MetallicRoughness(metal) => {
            let (base, metallic, _) = metal.base();
            metal.clone().with_base(base, metallic, number).map_or_else(|_| material.clone(), Into::into)
        }
        Material::HalfVector(all) => {
            let factor = all.lobes.first().map_or(1.0, |first| number / first.roughness().max(1e-3));
            let lobe = |(place, lobe): (usize, &HalfVectorLobe)| {
                let roughness = if place == 0 { number } else { (lobe.roughness() * factor).min(1.0) };
                let [f0, f90] = lobe.reflectances();
                HalfVectorLobe::new(roughness, f0, f90)
            };
            HalfVector { lobes: all.lobes.iter().enumerate().map(lobe).collect(), ..all.clone() }.into()
        }
        _ => return material.clone(),
    };
    if changed.validate().is_ok() { changed } else { material.clone() }
}

/// The colour of the base: of what is reflected diffusely, of a metal that of its highlights. None where it has none.
#[must_use]
pub fn color(material: &Material) -> Option<Vec3> {
    match material {
        Material::Lambert(Lambert { albedo }) => Some(*albedo),
        Material::Phong(Phong { kd, .. }) | Material::ModifiedPhong(ModifiedPhong { kd, .. }) => Some(*kd),
        Material::Neumann(metal) => Some(metal.ks),
        Material::Lafortune(all) => Some(all.diffuse),
        Material::HalfVector(all) => Some(all.diffuse),
        Material::MetallicRoughness(metal) => Some(metal.base().0),
        _ => None,
    }
}

/// The material with another colour of its base; the same where it has none, or the colour is out of range.
#[must_use]
pub fn with_color(material: &Material, color: Vec3) -> Material {
    let changed: Material = match material {
        Material::Lambert(_) => Lambert { albedo: color }.into(),
        Material::Phong(phong) => Phong { kd: color, ..*phong }.into(),
        Material::ModifiedPhong(phong) => ModifiedPhong { kd: color, ..*phong }.into(),
        Material::Neumann(metal) => Neumann { ks: color, ..*metal }.into(),
        Material::Lafortune(all) => Lafortune { diffuse: color, ..all.clone() }.into(),
        Material::HalfVector(all) => HalfVector { diffuse: color, ..all.clone() }.into(),
        Material::MetallicRoughness(metal) => {
            let (_, metallic, roughness) = metal.base();
            metal.clone().with_base(color, metallic, roughness).map_or_else(|_| material.clone(), Into::into)
        }
        _ => return material.clone(),
    };
    if changed.validate().is_ok() { changed } else { material.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_takes_another_sharpness_and_colour() {
        // Exponents of metals begin at 1.
        let metal = Neumann { ks: Vec3::splat(0.5), exponent: 30.0, ..Default::default() };
        let mut all: Vec<Material> = Material::built_in().into_iter().filter(|m| m.validate().is_ok()).collect();
        all.push(metal.into());
        all.push(
            HalfVector { lobes: vec![HalfVectorLobe::new(0.2, Vec3::splat(0.04), Vec3::ONE)], ..Default::default() }
                .into(),
        );
        let lobe = |exponent| LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 1.0), exponent, Vec3::splat(0.1));
        all.push(Lafortune { lobes: vec![lobe(40.0), lobe(8.0)], ..Default::default() }.into());
        for material in all {
            match of(&material) {
                Some(Gloss::Exponent(_)) => assert_eq!(of(&with(&material, 20.0)), Some(Gloss::Exponent(20.0))),
                Some(Gloss::Roughness(_)) => assert_eq!(of(&with(&material, 0.7)), Some(Gloss::Roughness(0.7))),
                None => assert_eq!(with(&material, 0.5), material),
            }
            let blue = Vec3::new(0.1, 0.2, 0.3);
            assert_eq!(color(&with_color(&material, blue)), Some(blue), "{material:?}");
            // Out of range.
            assert_eq!(with(&material, f32::NAN), material);
            assert_eq!(with_color(&material, Vec3::splat(-1.0)), material);
        }
    }

    #[test]
    fn the_other_lobes_follow_the_first() {
        let lobe = |exponent| LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 1.0), exponent, Vec3::splat(0.1));
        let metal = Lafortune { lobes: vec![lobe(40.0), lobe(8.0)], ..Default::default() }.into();
        let Material::Lafortune(after) = with(&metal, 80.0) else { panic!("another model") };
        assert_eq!(after.lobes.iter().map(LafortuneLobe::exponent).collect::<Vec<_>>(), [80.0, 16.0]);
    }
}
