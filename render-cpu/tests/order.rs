//! The order of points does not matter to what is shaded.

use brdf::Material;
use glam::Vec3;
use lighting::SphereLight;
use lobe_core::oracle::Random;
use lobe_core::{Receiver, Sphere};
use render_cpu::CpuShader;
use scene::{Frame, Shade, ShadingPoints};
use shading::Accuracy;
use visibility_mask::MaskVisibility;
use visibility_spheres::SphereBlockers;

/// Points of a floor, here and there, under some spheres.
fn floor(random: &mut Random, count: usize) -> ShadingPoints {
    let at = |random: &mut Random| {
        let position = Vec3::new(random.between(-2.0, 2.0) as f32, 0.0, random.between(-2.0, 2.0) as f32);
        let view = (Vec3::new(0.0, 3.0, 4.0) - position).normalize();
        Receiver::on_surface(position, Vec3::Y, view)
    };
    let materials = (0..count as u32).map(|k| k % 3).collect();
    ShadingPoints { receivers: (0..count).map(|_| at(random)).collect(), materials, ..ShadingPoints::default() }
}

fn shade(points: &ShadingPoints, spheres: &[Sphere]) -> Vec<[u32; 3]> {
    let materials = [
        Material::lambert(Vec3::splat(0.7)),
        Material::lambert(Vec3::X),
        brdf::Phong { kd: Vec3::splat(0.2), ks: Vec3::splat(0.3), exponent: 40.0 }.into(),
    ];
    let lights = [SphereLight::new(Sphere { center: Vec3::new(1.0, 4.0, 0.5), radius: 0.6 }, Vec3::splat(3.0))];
    let blockers = SphereBlockers::new(spheres, &vec![0; spheres.len()], &[]);
    let frame = Frame::new(&materials, &lights, Accuracy::new(0.003));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    CpuShader::new(MaskVisibility::new(blockers)).shade(points, &frame, &mut out).expect("shaded");
    out.iter().map(|radiance| radiance.to_array().map(f32::to_bits)).collect()
}

#[test]
fn coherent_points_shade_the_same_bit_for_bit() {
    let mut random = Random::new(4);
    let spheres: Vec<Sphere> = (0..40)
        .map(|_| {
            let center = Vec3::from_array([0, 1, 2].map(|_| random.between(-0.6, 0.6) as f32)) + Vec3::Y;
            Sphere { center, radius: random.between(0.05, 0.3) as f32 }
        })
        .collect();
    for count in [0, 1, 64, 65, 1000, 3333] {
        let points = floor(&mut random, count);
        let want = shade(&points, &spheres);
        assert!(count < 1000 || want.iter().any(|radiance| *radiance != want[0]), "no shadow");
        let mut coherent = points.clone();
        let order = coherent.make_coherent();
        let mut again = points.clone();
        again.reorder(&order);
        assert_eq!(again.receivers, coherent.receivers, "{count}");
        let got = shade(&coherent, &spheres);
        let mut seen = vec![false; count];
        for (new, old) in order.iter().map(|old| *old as usize).enumerate() {
            assert!(!core::mem::replace(&mut seen[old], true), "{count}: {old} twice");
            assert_eq!(coherent.receivers[new], points.receivers[old], "{count}: {new}");
            assert_eq!(coherent.materials[new], points.materials[old], "{count}: {new}");
            assert_eq!(got[new], want[old], "{count}: {new}");
        }
    }
}

/// A group of so many points, evenly spread over a square, cannot be smaller than a square of their part of it.
#[test]
fn coherent_groups_are_compact() {
    let mut points = floor(&mut Random::new(5), 64 * 256);
    points.make_coherent();
    let side = 4.0 / 16.0;
    let mut mean = 0.0;
    for group in points.receivers.chunks(64) {
        let (low, high) = group.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| {
            (low.min(at.position), high.max(at.position))
        });
        mean += (high - low).max_element() / (256.0 * side);
    }
    assert!((0.9..1.5).contains(&mean), "{mean}");
}
