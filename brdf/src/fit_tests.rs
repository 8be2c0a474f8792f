//! Fits of what the models have, and of what they have not.

use crate::{
    Brdf, HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Material, MetallicRoughness, Model as _, fit,
    fit_half_vector, fit_lafortune,
};
use core::f32::consts::{FRAC_1_PI, PI};
use glam::Vec3;
use lobe_core::Receiver;

/// A model's reflectance, without the cosine of the light.
fn of(material: &Material, i: Vec3, o: Vec3) -> Vec3 {
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, o);
    material.eval(&at, i) / i.z
}

#[test]
fn lobes_are_found_again() {
    let lobes = [
        LafortuneLobe::diagonal(Vec3::new(-1.0, -1.0, 0.9), 60.0, Vec3::new(0.8, 0.6, 0.3)),
        LafortuneLobe::diagonal(Vec3::new(0.7, 0.7, 1.0), 6.0, Vec3::new(0.05, 0.1, 0.2)),
    ];
    let want = Lafortune { diffuse: Vec3::new(0.3, 0.2, 0.1), lobes: lobes.to_vec() };
    let material = Material::from(want.clone());
    let fitted = fit_lafortune(|i, o| of(&material, i, o), 2).expect("finite values");
    println!("residual {:.2e}: {:?}", fitted.residual, fitted.model);
    assert!(fitted.residual < 5e-3, "{}", fitted.residual);
    assert!((fitted.model.diffuse - want.diffuse).abs().max_element() < 0.01);
    fitted.model.validate().expect("a model");
    assert_eq!(fit_lafortune(|i, o| of(&material, i, o), 2).expect("finite values"), fitted);
}

#[test]
fn more_lobes_are_nearer_to_ggx() {
    let gold = MetallicRoughness::new(Vec3::new(1.0, 0.77, 0.34), 1.0, 0.4).expect("in range").into();
    let residuals = [0, 1, 2, 3].map(|n| fit_lafortune(|i, o| of(&gold, i, o), n).expect("finite values").residual);
    println!("{residuals:.3?}");
    assert!(residuals.windows(2).all(|w| w[1] <= w[0]), "{residuals:?}");
    // They do not grow toward grazing as it does.
    assert!(residuals[1] < 0.33 && residuals[3] < 0.25, "{residuals:?}");
}

#[test]
fn half_vector_lobes_are_found_again() {
    for (metallic, roughness) in [(1.0, 0.2), (1.0, 0.4), (1.0, 0.9)] {
        let gold = MetallicRoughness::new(Vec3::new(1.0, 0.77, 0.34), metallic, roughness).expect("in range").into();
        let fitted = fit_half_vector(|i, o| of(&gold, i, o), 1).expect("finite values");
        println!("roughness {roughness}: residual {:.2e}: {:?}", fitted.residual, fitted.model);
        fitted.model.validate().expect("a model");
        assert!(fitted.residual < 1e-3, "{}", fitted.residual);
        assert!((fitted.model.lobes[0].roughness() - roughness).abs() < 1e-3, "{fitted:?}");
    }
    let two = HalfVector {
        diffuse: Vec3::splat(0.1),
        lobes: vec![
            HalfVectorLobe::new(0.2, Vec3::new(0.1, 0.2, 0.3), Vec3::splat(0.4)),
            HalfVectorLobe::new(0.6, Vec3::new(0.4, 0.2, 0.1), Vec3::splat(0.3)),
        ],
    };
    let want = Material::from(two);
    let fitted = fit(|i, o| of(&want, i, o), 2).expect("finite values");
    println!("residual {:.2e}: {:?}", fitted.residual, fitted.model);
    assert!(fitted.residual < 0.01 && fitted.model.name() == "half-vector", "{fitted:?}");
}

/// A metal as measured ones are: slopes of another distribution, and Fresnel's equations with absorption.
#[test]
fn half_vector_lobes_are_nearer_to_conductors() {
    let fresnel = |cos: f32, n: f32, k: f32| {
        // R. Cook, K. Torrance, 1982, for n² + k² ≫ 1.
        let (nk, nc) = (n * n + k * k, 2.0 * n * cos);
        let s = (nk - nc + cos * cos) / (nk + nc + cos * cos);
        let p = (nk * cos * cos - nc + 1.0) / (nk * cos * cos + nc + 1.0);
        0.5 * (s + p)
    };
    let measured = |i: Vec3, o: Vec3| {
        let h = (i + o).normalize();
        let (c2, m2) = (h.z * h.z, 0.2_f32 * 0.2);
        let d = ((c2 - 1.0) / (c2 * m2)).exp() / (PI * m2 * c2 * c2);
        let g = (2.0 * h.z * i.z / o.dot(h)).min(2.0 * h.z * o.z / o.dot(h)).min(1.0);
        let channels = [(0.27, 3.6), (0.68, 2.6), (1.3, 2.3)];
        let color = Vec3::from_array(channels.map(|(n, k)| fresnel(o.dot(h), n, k)));
        color * (d * g / (4.0 * i.z * o.z)) + 0.01
    };
    let lafortune = [1, 2, 3].map(|n| fit_lafortune(measured, n).expect("finite values").residual);
    let half_vector = [1, 2, 3].map(|n| fit_half_vector(measured, n).expect("finite values").residual);
    println!("Lafortune {lafortune:.3?}, half-vector {half_vector:.3?}");
    for (lafortune, half_vector) in lafortune.iter().zip(half_vector) {
        assert!(half_vector < 0.65 * lafortune, "{half_vector} {lafortune}");
    }
}

#[test]
fn diffuse_black_and_broken_reflectances() {
    let fitted = fit_lafortune(|_, _| Vec3::splat(0.5 * FRAC_1_PI), 1).expect("finite values");
    assert!(fitted.residual < 1e-3 && (fitted.model.diffuse.x - 0.5).abs() < 1e-3, "{fitted:?}");
    let fitted = fit_half_vector(|_, _| Vec3::splat(0.5 * FRAC_1_PI), 1).expect("finite values");
    assert!(fitted.residual < 1e-3 && (fitted.model.diffuse.x - 0.5).abs() < 1e-2, "{fitted:?}");
    let black = fit_half_vector(|_, _| Vec3::ZERO, 1).expect("finite values");
    assert_eq!((black.residual, black.model.diffuse), (0.0, Vec3::ZERO));
    let black = fit_lafortune(|_, _| Vec3::ZERO, 1).expect("finite values");
    assert_eq!((black.residual, black.model.diffuse), (0.0, Vec3::ZERO));
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        assert!(fit(|_, _| Vec3::splat(bad), 1).is_err());
    }
}
