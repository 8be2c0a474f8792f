//! Pictures of points on meshes, from CPU and GPU: small lights, thin blockers, a light among its blockers.

use super::{Case, cases, tolerance_for};
use crate::parity::assert_same;
use brdf::{Lambert, Material, Phong};
use glam::Vec3;
use lighting::{Light, SphereLight};
use lobe_core::Sphere;
use lobe_core::oracle::Random;
use render_cpu::CpuShader;
use render_gpu::{Gpu, GpuShader, Occlusion};
use scene::{Counts, Frame, Shade, ShadeStats, ShadingPoints};
use shading::Accuracy;
use visibility_mask::{LookAgain, MaskVisibility};
use visibility_shadowmap::ShadowMapBlockers;

/// Points of a picture.
const POINTS: usize = 1024;

/// Some cases, each with its light, a second light with a map of its own and a third without one; diffuse and glossy points.
pub(super) fn agree(gpu: &Gpu) {
    let glossy = Phong { kd: Vec3::splat(0.1), ks: Vec3::new(0.6, 0.5, 0.4), exponent: 200.0 };
    let materials: [Material; 2] = [Lambert { albedo: Vec3::new(0.5, 0.6, 0.7) }.into(), glossy.into()];
    // A small light at depth 5, thin blockers at depth 6 and, with coarse rows, at 3, and a map with six faces.
    let some = [0, 3, 4, 5];
    for case in cases().into_iter().enumerate().filter_map(|(k, case)| some.contains(&k).then_some(case)) {
        let mut random = Random::new(90);
        let Case { name, mesh, light, resolution, layers, depth } = case;
        let second = Sphere { center: light.center + Vec3::new(0.4, 0.2, -0.3), radius: 1.5 * light.radius };
        let third = Sphere { center: light.center - Vec3::new(0.3, 0.0, 0.4), ..light };
        let maps = [light, second].map(|light| mesh.map(light, resolution, layers));
        let maps = ShadowMapBlockers::new(maps.to_vec()).with_casters(vec![true]);
        let mut receivers = mesh.receivers(&mut random, light, POINTS);
        for at in &mut receivers {
            // Half of the points look along the light's mirror direction.
            if random.bits().is_multiple_of(2) {
                let to = (light.center - at.position).normalize();
                at.view = (2.0 * at.normal.dot(to) * at.normal - to).normalize();
            }
        }
        let points = ShadingPoints {
            receivers,
            materials: (0..POINTS as u32).map(|k| k % 2).collect(),
            ..ShadingPoints::default()
        };
        let lights = [light, second, third].map(|sphere| SphereLight::new(sphere, Vec3::new(3.0, 2.0, 1.0)).into());
        let frame = Frame {
            materials: &materials,
            lights: &lights,
            accuracy: Accuracy { tolerance: tolerance_for(depth), depth },
            threshold: 1e-5,
        };
        let want =
            shade(CpuShader::new(MaskVisibility::new(maps.clone()).look_again(LookAgain::Never)), &points, &frame);
        let occlusion = Occlusion { blockers: &[&maps.pack()], any_hit: None };
        let got = shade(GpuShader::new(gpu, occlusion).expect("a shader"), &points, &frame);
        assert_same(name, &want, &got);
    }
}

fn shade<S: Shade<Material, Light, Error: core::fmt::Debug>>(
    mut shader: S,
    points: &ShadingPoints,
    frame: &Frame<'_>,
) -> (Vec<Vec3>, Counts) {
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let ShadeStats { counts, .. } = shader.shade(points, frame, &mut out).expect("shades");
    (out, counts)
}
