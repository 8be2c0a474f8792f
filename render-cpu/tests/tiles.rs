//! Tiles of 64 points give the bits that the integrator gives of each point alone: the packed path of the built-in materials, and
//! models that are called one by one.

use brdf::{Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, ModifiedPhong, Phong};
use glam::Vec3;
use render_cpu::{CpuShader, GBuffer, World, blockers};
use scene::{Frame, Scene, Shade};
use shading::{
    Accuracy, BrdfLobes, FractionIntegrator, Integrator, Interaction, LightId, LightLobes, LightVisibility, Visibility,
};
use std::ops::ControlFlow;
use visibility_mask::MaskVisibility;
use visibility_spheres::SphereBlockers;

fn materials() -> Vec<Material> {
    let (kd, ks) = (Vec3::new(0.4, 0.3, 0.2), Vec3::splat(0.3));
    let lobe = LafortuneLobe::diagonal(Vec3::new(-0.9, -0.7, 0.9), 12.0, ks);
    vec![
        Lambert { albedo: kd }.into(),
        Phong { kd, ks, exponent: 40.0 }.into(),
        ModifiedPhong { kd, ks, exponent: 400.0 }.into(),
        Lafortune { diffuse: kd, lobes: vec![lobe] }.into(),
        MetallicRoughness::new(kd, 0.5, 0.4).expect("a metal").into(),
        MetallicRoughness::new(kd, 0.0, 0.6).and_then(|m| m.with_clearcoat(0.9, 0.15)).expect("a varnish").into(),
        MetallicRoughness::new(kd, 1.0, 0.3).and_then(|m| m.with_anisotropy(0.6)).expect("brushed").into(),
    ]
}

/// The built-in scene, its points with each of these materials in turn.
fn scene() -> (Scene, GBuffer) {
    let mut scene = scene::builtin();
    (scene.width, scene.height) = (160, 90);
    scene.materials = materials();
    for object in &mut scene.objects {
        object.material = 0;
    }
    let mut points = GBuffer::new(&World::new(&scene), 160, 90, 1);
    // Tiles of one material, and tiles of all.
    let count = scene.materials.len() as u32;
    points.points.materials.iter_mut().enumerate().for_each(|(i, m)| {
        *m = if i / 1000 % 2 == 0 { (i / 64) as u32 % count } else { (i % 7) as u32 % count };
    });
    (scene, points)
}

fn check<M: BrdfLobes + Sync>(materials: &[M], scene: &Scene, points: &GBuffer) {
    let set = blockers(scene, &mut |_, _| ControlFlow::Continue(())).expect("blockers");
    let spheres = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
    let visibility = MaskVisibility::new(spheres.with_self_shadows(&set.self_shadows));
    let frame = Frame::new(materials, &scene.lights, Accuracy::new(0.003));
    let mut tiled = vec![Vec3::ZERO; points.len()];
    CpuShader::new(visibility.clone()).shade(&points.points, &frame, &mut tiled).expect("shaded");
    let mut scratch = visibility.scratch();
    let mut lobes = Vec::new();
    let mut partial = 0;
    for (i, at) in points.points.receivers.iter().enumerate() {
        lobes.clear();
        materials[points.points.materials[i] as usize].brdf_lobes(at, &mut lobes);
        let mut all = Vec3::ZERO;
        for (number, light) in scene.lights.iter().enumerate() {
            let term = light.seen_from(at);
            let mut visit = LightVisibility::alone(&visibility, LightId(number as u32), frame.accuracy, &mut scratch);
            let call = Interaction { at, brdf: &lobes, light: &term, threshold: 0.0 };
            let lit = FractionIntegrator.radiance(&call, &mut visit, &mut (), &mut ());
            partial += u32::from(lit.radiance != lit.unshadowed && lit.radiance != Vec3::ZERO);
            all += lit.radiance;
        }
        assert_eq!(all.to_array().map(f32::to_bits), tiled[i].to_array().map(f32::to_bits), "point {i}: {all}");
    }
    assert!(partial > 500, "{partial} in penumbra");
}

#[test]
fn packed_materials() {
    let (scene, points) = scene();
    check(&scene.materials, &scene, &points);
}

#[test]
fn boxed_materials() {
    let (scene, points) = scene();
    let boxed: Vec<Box<dyn BrdfLobes + Sync>> =
        scene.materials.iter().map(|m| Box::new(m.clone()) as Box<dyn BrdfLobes + Sync>).collect();
    check(&boxed, &scene, &points);
}
