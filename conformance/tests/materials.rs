//! Built-in models and one that is not pass the suite of models, within what each promises.

use brdf::{Brdf, HalfVector, HalfVectorLobe, Material, MetallicRoughness, Model, Neumann};
use conformance::{BrdfLimits, check_brdf};
use glam::Vec3;
use lobe_core::{BrdfLobe, Lobe, Receiver};
use shading::BrdfLobes;

fn metal(base: f32, metallic: f32, roughness: f32) -> MetallicRoughness {
    MetallicRoughness::new(Vec3::splat(base), metallic, roughness).expect("numbers in range")
}

/// Models whose lobes are measured elsewhere.
#[test]
fn metals_keep_the_properties_of_models() {
    let stretched = Neumann { kd: Vec3::splat(0.2), ks: Vec3::new(0.8, 0.6, 0.3), exponent: 80.0 };
    let measured = check_brdf(&stretched, &BrdfLimits { lobes: 0.12, ..BrdfLimits::default() }).unwrap();
    println!("{measured:?}");
    let lobes = vec![
        HalfVectorLobe::new(0.8, Vec3::new(0.3, 0.1, 0.05), Vec3::splat(0.3)),
        HalfVectorLobe::new(0.55, Vec3::new(0.2, 0.3, 0.4), Vec3::new(0.4, 0.5, 0.2)),
    ];
    let half_vector = HalfVector { diffuse: Vec3::splat(0.1), lobes };
    println!("{:?}", check_brdf(&half_vector, &BrdfLimits::default()).unwrap());
}

/// All but reciprocity, which the printed weight has not.
#[test]
fn coats_keep_the_properties_of_models() {
    for (below, weight, roughness) in [
        (metal(0.9, 1.0, 0.6), 1.0, 0.35),
        (metal(1.0, 0.0, 0.5), 1.0, 0.5),
        (metal(1.0, 0.0, 1.0), 1.0, 1.0),
        (metal(0.0, 0.0, 0.7), 0.6, 0.4),
    ] {
        let coated = below.with_clearcoat(weight, roughness).unwrap();
        let limits = BrdfLimits { reciprocity: f64::INFINITY, ..BrdfLimits::default() };
        println!("{:?}", check_brdf(&Material::from(coated), &limits).unwrap());
    }
}

#[test]
fn brushed_materials_keep_the_properties_of_models() {
    for (metallic, strength, reciprocity) in [(1.0, 0.6, 0.05), (0.0, 0.5, f64::INFINITY), (0.3, 1.0, f64::INFINITY)] {
        let material = MetallicRoughness::new(Vec3::ONE, metallic, 0.6).and_then(|m| m.with_anisotropy(strength));
        let material = Material::from(material.unwrap()).turned(Vec3::Z, Vec3::new(0.9, 0.2, -0.2)).unwrap();
        println!("{:?}", check_brdf(&material, &BrdfLimits { reciprocity, ..BrdfLimits::default() }).unwrap());
    }
}

/// Lobes about the view.
#[derive(Debug)]
struct Retro;

impl BrdfLobes for Retro {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.push(Lobe::new(at.view, 9.0, Vec3::Y).times_cosine().into());
    }
}

impl Brdf for Retro {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        Vec3::Y * (at.view.dot(v).max(0.0).powi(9) * at.normal.dot(v).max(0.0))
    }
}

impl Model for Retro {
    fn name(&self) -> &'static str {
        "retro"
    }

    fn lobe_count(&self) -> usize {
        1
    }
}

/// With what is provided.
#[test]
fn models_of_ones_own_pass() {
    check_brdf(&Retro, &BrdfLimits { energy: 1.0, ..BrdfLimits::default() }).unwrap();
}
