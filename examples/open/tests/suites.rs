//! Each part through the suite of its kind, and both devices side by side.

use core::ops::ControlFlow;
use core::sync::atomic::AtomicBool;
use cosine_lobes::brdf::Material;
use cosine_lobes::conformance::{BrdfLimits, LightLimits, Limits, Setting, check, check_brdf, check_light};
use cosine_lobes::glam::{Mat4, Quat, Vec3};
use cosine_lobes::lighting::{Light, LightKind as _};
use cosine_lobes::pictures::Window;
use cosine_lobes::reference::{Geometry, Reference, ReferenceJob};
use cosine_lobes::render_cpu::{GBuffer, World};
use cosine_lobes::render_gpu::{Gpu, GpuOptions};
use cosine_lobes::renderer::{Device, Renderer, Settings};
use cosine_lobes::scene::{Animation, BlockerSet, Surface};
use cosine_lobes::shading::{
    Accuracy, BrdfLobes, FractionIntegrator, Integrator, Interaction, LightId, LightLobes, LightVisibility, Visibility,
};
use cosine_lobes::visibility_mask::MaskVisibility;
use libtest_mimic::{Arguments, Trial};
use open::scene::MATERIALS;
use open::{Capsule, Capsules, Spot, Velvet};
use std::sync::Arc;

fn velvet_is_a_material() {
    for material in MATERIALS {
        check_brdf(&material, &BrdfLimits::default()).unwrap();
    }
}

fn spots_are_lights() {
    for light in open::scene::lights() {
        check_light(&light, &LightLimits::default()).unwrap();
    }
}

/// Capsules without a length are spheres. Their masks are not turned across their edges, so that some err more, and pop.
fn capsules_are_blockers() {
    let capsules = |s: &Setting<'_>| {
        let capsule =
            |sphere: &cosine_lobes::lobe_core::Sphere| Capsule { ends: [sphere.center; 2], radius: sphere.radius };
        MaskVisibility::new(Capsules(s.spheres.iter().map(capsule).collect()))
    };
    let limits = Limits { overlap: 0.005, jump: 0.008, jump_several: 0.008, ..Limits::default() };
    println!("{:?}", check(&capsules, &limits).unwrap());
}

/// The renderer gives the bits that the integrator gives of each point alone, with this crate's own types.
fn pictures_are_single_points() {
    let scene = open::scene::scene(96, 60);
    let points = GBuffer::new(&World::new(&scene), 96, 60, 1);
    let (visibility, accuracy) = (MaskVisibility::new(open::scene::rods()), Accuracy::new(0.003));
    let mut scratch = visibility.scratch();
    let mut lobes = Vec::new();
    let mut single = vec![Vec3::ZERO; points.len()];
    for (i, at) in points.points.receivers.iter().enumerate() {
        lobes.clear();
        MATERIALS[points.points.materials[i] as usize].brdf_lobes(at, &mut lobes);
        for (number, light) in open::scene::lights().iter().enumerate() {
            let seen = light.seen_from(at);
            let mut visible = LightVisibility::alone(&visibility, LightId(number as u32), accuracy, &mut scratch);
            let interaction = Interaction { at, brdf: &lobes, light: &seen, threshold: 0.0 };
            single[i] += FractionIntegrator.radiance(&interaction, &mut visible, &mut (), &mut ()).radiance;
        }
    }
    assert!(picture(&mut renderer(Device::Cpu)) == points.resolve(&single, Vec3::ZERO));
}

/// The same picture on the GPU, where there is one.
fn both_devices_agree() {
    let (cpu, gpu) = (picture(&mut renderer(Device::Cpu)), picture(&mut renderer(Device::Gpu)));
    let (mean, most) = difference(&cpu, &gpu);
    println!("mean {mean:.2e}, most {most:.2e} of the peak");
    assert!(mean < 1e-4 && most < 5e-3, "mean {mean}, most {most}");
}

/// The reference draws the light's surface, and evaluates the material; the spheres that the camera sees block there.
fn the_reference_agrees() {
    let scene = open::scene::scene(96, 60);
    let world = World::new(&scene);
    let gbuffer = GBuffer::new(&world, 96, 60, 1);
    let (blockers, geometry) = (BlockerSet::default(), Geometry::Mesh);
    let mut reference =
        Reference::new(ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry, seed: 1 });
    reference.advance(256, &AtomicBool::new(false), &|_| {});
    let want = gbuffer.resolve(&reference.estimate().radiance, Vec3::ZERO);
    let (mean, most) = difference(&want, &picture(&mut renderer(Device::Cpu)));
    println!("mean {mean:.2e}, most {most:.2e} of the peak");
    // Noise of the reference, and strings of spheres in place of rods.
    assert!(mean < 3e-3, "mean {mean}, most {most}");
}

/// Edits of own parts give the picture of a new renderer; bands give that of the whole.
fn edits_and_bands() {
    let moved = Mat4::from_rotation_translation(Quat::from_rotation_y(0.4), Vec3::new(0.3, 0.1, 0.0));
    let red = Velvet { kd: Vec3::X * 0.5, ..MATERIALS[1] };
    let fewer = Capsules(open::scene::rods().0.split_off(4));
    let mut edited = renderer(Device::Cpu);
    let before = picture(&mut edited);
    let (light, material) = (edited.lights().next().unwrap().0, edited.materials().nth(1).unwrap().0);
    edited.set_light(light, open::scene::lights()[0].moved(moved)).unwrap();
    edited.set_material(material, Material::Custom(Arc::new(red)), Surface::default()).unwrap();
    edited.put_strategy(Box::new(fewer.clone()));
    let mut scene = open::scene::scene(96, 60);
    scene.lights[0] = open::scene::lights()[0].moved(moved);
    scene.materials[1] = Material::Custom(Arc::new(red));
    let settings = Settings { accuracy: Accuracy::new(0.003), ..Settings::default() };
    let mut new = Renderer::new(scene, Animation::default(), settings).unwrap();
    new.put_strategy(Box::new(fewer));
    let after = picture(&mut new);
    assert!(before != after && picture(&mut edited) == after);
    let window = Window { image: [96, 60], columns: 10..50, rows: 7..31 };
    let part = edited.render_window(&window, &mut |_| ControlFlow::Continue(())).unwrap().radiance;
    let rows = after.chunks(96).skip(7).take(24).flat_map(|row| &row[10..50]);
    assert!(rows.eq(&part));
}

/// A part that is missing is an error that names it.
fn missing_parts_are_named() {
    let scene = open::scene::scene(8, 8);
    let mut without = Renderer::new(scene.clone(), Animation::default(), Settings::default()).unwrap();
    let error = without.render().unwrap_err().to_string();
    assert_eq!(error, "object \"chair\" blocks by `capsules`: the renderer has no such strategy");
    let mut lit = scene;
    lit.lights[1] = Light::Custom(Arc::new(Spot { radiance: Vec3::NAN, ..open::scene::lights()[1] }));
    let error = Renderer::new(lit, Animation::default(), Settings::default()).unwrap_err().to_string();
    assert!(error.starts_with("light 1 has radiance"), "{error}");
}

fn renderer(device: Device) -> Renderer {
    open::scene::renderer(96, 60, device).unwrap()
}

fn picture(renderer: &mut Renderer) -> Vec<Vec3> {
    renderer.render().unwrap().radiance
}

/// The mean and the largest, of the peak.
fn difference(a: &[Vec3], b: &[Vec3]) -> (f32, f32) {
    let peak = a.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    assert!(peak > 0.1);
    let errors: Vec<f32> = a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    (errors.iter().sum::<f32>() / errors.len() as f32, errors.iter().fold(0.0, |a: f32, b| a.max(*b)))
}

/// Tests that need a GPU show as ignored without one.
pub(crate) fn main() {
    let tests: [(&str, fn()); 7] = [
        ("velvet_is_a_material", velvet_is_a_material),
        ("spots_are_lights", spots_are_lights),
        ("capsules_are_blockers", capsules_are_blockers),
        ("pictures_are_single_points", pictures_are_single_points),
        ("the_reference_agrees", the_reference_agrees),
        ("edits_and_bands", edits_and_bands),
        ("missing_parts_are_named", missing_parts_are_named),
    ];
    let trial = |(name, test): (&str, fn())| {
        Trial::test(name, move || {
            test();
            Ok(())
        })
    };
    let mut trials: Vec<Trial> = tests.map(trial).into();
    let no_gpu = Gpu::blocking(&GpuOptions::default()).is_err();
    trials.push(trial(("both_devices_agree", both_devices_agree)).with_ignored_flag(no_gpu));
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
