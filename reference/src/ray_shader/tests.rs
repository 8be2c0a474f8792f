use super::*;
use crate::test_blockers::blockers;
use crate::{Geometry, Reference, ReferenceJob};
use brdf::{ModifiedPhong, Phong};
use core::sync::atomic::AtomicBool;
use lighting::SphereLight;
use ray_tracing::GBuffer;
use scene::{Object, Scene};
use shading::Accuracy;
use test_scenes::floor_and_sphere;

/// Two more spheres that overlap, and glossy materials of both kinds.
fn busy() -> Scene {
    let mut scene = floor_and_sphere();
    let (kd, ks) = (Vec3::splat(0.3), Vec3::splat(0.4));
    scene.materials.push(ModifiedPhong { kd, ks, exponent: 40.0 }.into());
    scene.materials.push(Phong { kd: 0.3 * kd, ks, exponent: 12.0 }.into());
    scene.objects[0].material = 1;
    let sphere = |x: f32, radius| lobe_core::Sphere { center: Vec3::new(x, 0.4, 0.5), radius };
    scene.objects.push(Object::spheres("pair", vec![sphere(1.0, 0.5), sphere(1.3, 0.4)], 2));
    scene
        .lights
        .push(SphereLight::new(lobe_core::Sphere { center: Vec3::new(-3.0, 2.0, 1.0), radius: 0.2 }, Vec3::ONE).into());
    scene
}

/// All kinds of rays agree with the reference of the same blockers, within the noise of 1024 samples.
#[test]
fn rays_converge_to_the_reference() {
    let scene = busy();
    let world = World::new(&scene);
    let set = blockers(&scene, 5e-4);
    let g = GBuffer::new(&world, 48, 30, 1);
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy { tolerance: 0.0, depth: 1 });
    for (geometry, on_spheres) in [(Geometry::Spheres, true), (Geometry::Mesh, false)] {
        let job = ReferenceJob { world: &world, gbuffer: &g, blockers: &set, geometry, seed: 1 };
        let mut reference = Reference::new(job);
        reference.advance(512, &AtomicBool::new(false), &|_| ());
        let truth = reference.estimate();
        for culled in [false, true] {
            let shader = if on_spheres { RayShader::spheres(&set, 1024) } else { RayShader::surfaces(&world, 1024) };
            let mut shader = shader.culled(culled);
            let mut out = vec![Vec3::ZERO; g.len()];
            shader.shade(&g.points, &frame, &mut out).unwrap();
            let relative = |i: usize| {
                (out[i] - truth.radiance[i]).abs().max_element() / truth.unshadowed[i].max_element().max(1e-9)
            };
            let errors: Vec<f32> = (0..g.len()).map(relative).collect();
            let mean = errors.iter().sum::<f32>() / errors.len() as f32;
            let most = errors.iter().fold(0.0, |a: f32, b| a.max(*b));
            // Stratified samples of an edge: N^-3/4, here 0.55 %; smooth functions far less.
            assert!(mean < 1e-3 && most < 0.02, "{geometry:?} culled {culled}: mean {mean}, most {most}");
            assert!(shader.rays() > 0);
        }
    }
}

/// Culling leaves the samples as they are: only a ray at an edge may fall to the other side.
#[test]
fn culling_changes_no_sample() {
    let scene = busy();
    let world = World::new(&scene);
    let set = blockers(&scene, 5e-4);
    let g = GBuffer::new(&world, 96, 60, 1);
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy { tolerance: 0.0, depth: 1 });
    let shade = |mut shader: RayShader<'_>| {
        let mut out = vec![Vec3::ZERO; g.len()];
        shader.shade(&g.points, &frame, &mut out).unwrap();
        (out, shader.rays())
    };
    for on_spheres in [true, false] {
        let make = || if on_spheres { RayShader::spheres(&set, 13) } else { RayShader::surfaces(&world, 13) };
        let ((plain, all), (culled, some)) = (shade(make()), shade(make().culled(true)));
        assert!(some * 2 < all, "{some} of {all} rays");
        let different = plain.iter().zip(&culled).filter(|(a, b)| (*a - *b).abs().max_element() > 1e-5).count();
        assert!(different * 1000 < g.len(), "{different} of {}", g.len());
    }
}

/// The same radiance but for the order of sums with all kinds of vector instructions.
#[test]
fn instructions_do_not_matter() {
    let scene = busy();
    let set = blockers(&scene, 5e-4);
    let g = GBuffer::new(&World::new(&scene), 90, 70, 1);
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy { tolerance: 0.0, depth: 1 });
    let shade = |level: Level| {
        let mut out = vec![Vec3::ZERO; g.len()];
        RayShader::spheres(&set, 20).at_level(level).culled(true).shade(&g.points, &frame, &mut out).unwrap();
        out
    };
    let best = shade(Level::new());
    let mut levels = vec![Level::baseline()];
    #[cfg(target_arch = "x86_64")]
    levels.extend(Level::new().as_avx2().map(|avx2| avx2.level()));
    for level in levels {
        let out = shade(level);
        assert!(out.iter().zip(&best).all(|(a, b)| (*a - *b).abs().max_element() <= 1e-6 * b.max_element()));
    }
}
