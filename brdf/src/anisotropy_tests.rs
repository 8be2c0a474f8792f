//! Brushed metals against the formula that KHR_materials_anisotropy prints, in f64.

use crate::{Brdf, Material, MetallicRoughness};
use core::f64::consts::PI;
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{BrdfLobe, Receiver};
use shading::BrdfLobes;

fn brushed(roughness: f32, strength: f32) -> MetallicRoughness {
    MetallicRoughness::new(Vec3::splat(0.7), 1.0, roughness).and_then(|m| m.with_anisotropy(strength)).unwrap()
}

/// Of a white metal with its grain along x, times the cosine.
fn printed(alphas: [f64; 2], view: DVec3, l: DVec3) -> f64 {
    let [t, b] = alphas;
    let h = (view + l).normalize();
    let f = DVec3::new(b * h.x, t * h.y, t * b * h.z);
    let w2 = t * b / f.length_squared();
    let d = t * b * w2 * w2 / PI;
    let smith = |v: DVec3| DVec3::new(t * v.x, b * v.y, v.z).length();
    let v = 0.5 / (l.z * smith(view) + view.z * smith(l));
    let schlick = (1.0 - view.dot(h)).max(0.0).powi(5);
    (0.7 + 0.3 * schlick) * d * v * l.z
}

#[test]
fn brushed_metals_are_the_printed_formula() {
    let mut random = Random::new(4);
    for _ in 0..2000 {
        let (roughness, strength) = (random.between(0.2, 1.0) as f32, random.uniform() as f32);
        let material = Material::from(brushed(roughness, strength)).turned(Vec3::Z, Vec3::X * 3.0 + Vec3::Z).unwrap();
        let [view, l] = [(); 2].map(|()| {
            let tilt = 1.4 * random.uniform();
            random.axis_at(DVec3::Z, tilt).as_vec3().normalize()
        });
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        let alpha = f64::from(roughness * roughness);
        let strength = f64::from(strength);
        let want = printed([alpha + (1.0 - alpha) * strength * strength, alpha], view.as_dvec3(), l.as_dvec3());
        let mut lobes = Vec::new();
        material.brdf_lobes(&at, &mut lobes);
        for got in [material.eval(&at, l).x, BrdfLobe::sum_at(&lobes, Vec3::Z, l).x].map(f64::from) {
            // Eleven bits of the direction and of the strength.
            assert!((got - want).abs() < 0.02 * want + 1e-4, "{roughness} {strength} {view} {l}: {got} {want}");
        }
    }
}

/// Where a mesh has no coordinates the grain follows from the normal, and does not turn with the eye.
#[test]
fn no_tangent_is_as_none() {
    let material = Material::from(brushed(0.4, 0.8));
    for tangent in [Vec3::ZERO, Vec3::Z * 2.0] {
        assert_eq!(material.turned(Vec3::Z, tangent).as_ref(), Some(&material));
    }
    assert_ne!(material.turned(Vec3::Z, Vec3::X).as_ref(), Some(&material));
}

#[test]
fn strengths_are_checked() {
    let plain = MetallicRoughness::new(Vec3::ONE, 1.0, 0.3).unwrap();
    assert_eq!(plain.clone().with_anisotropy(0.0).unwrap(), plain);
    assert!(Material::from(plain.clone()).turned(Vec3::Z, Vec3::X).is_none());
    for strength in [-0.1, 1.1, f32::NAN] {
        let message = plain.clone().with_anisotropy(strength).unwrap_err().to_string();
        assert!(message.contains("anisotropy is") && message.contains("[0, 1]"), "{message}");
    }
    let brushed = brushed(0.3, 0.5).with_base(Vec3::ONE, 1.0, 0.2).unwrap();
    assert_eq!(brushed.anisotropy(), 0.5);
}
