//! Each part through the suite of its kind, and both devices side by side.

use cosine_lobes::brdf::conformance::{BrdfLimits, check as check_brdf};
use cosine_lobes::glam::Vec3;
use cosine_lobes::lobe_core::conformance::{LightLimits, Limits, Setting, check, check_light};
use cosine_lobes::lobe_core::{
    BrdfLobes, FractionIntegrator, Integrator, Interaction, LightId, LightLobes, LightVisibility, Visibility,
};
use cosine_lobes::render_gpu::{Gpu, GpuOptions};
use cosine_lobes::visibility_mask::MaskVisibility;
use libtest_mimic::{Arguments, Trial};
use open::scene::Own;
use open::{Capsule, Capsules};

fn velvet_is_a_material() {
    for material in Own::new(8, 8).materials {
        check_brdf(&material, &BrdfLimits::default()).unwrap();
    }
}

fn spots_are_lights() {
    for light in Own::new(8, 8).lights {
        check_light(&light, &LightLimits::default()).unwrap();
    }
}

/// Capsules without a length are spheres. Their masks are not turned across their edges, so that some err more, and pop.
fn capsules_are_blockers() {
    let capsules = |s: &Setting<'_>| {
        let capsule = |ball: &cosine_lobes::lobe_core::Sphere| Capsule { ends: [ball.center; 2], radius: ball.radius };
        MaskVisibility::new(Capsules(s.spheres.iter().map(capsule).collect()))
    };
    let limits = Limits { overlap: 0.005, jump: 0.008, jump_several: 0.008, ..Limits::default() };
    println!("{:?}", check(&capsules, &limits).unwrap());
}

/// Tiles of points give the bits that the integrator gives of each point alone.
fn tiles_are_single_points() {
    let own = Own::new(96, 60);
    let points = own.points();
    let tiled = own.on_cpu(&points).unwrap();
    let (visibility, frame) = (MaskVisibility::new(own.capsules.clone()), own.frame());
    let mut scratch = visibility.scratch();
    let mut lobes = Vec::new();
    for (i, at) in points.points.receivers.iter().enumerate() {
        lobes.clear();
        frame.materials[points.points.materials[i] as usize].brdf_lobes(at, &mut lobes);
        let mut all = Vec3::ZERO;
        for (number, light) in frame.lights.iter().enumerate() {
            let term = light.seen_from(at);
            let mut visit = LightVisibility::alone(&visibility, LightId(number as u32), frame.accuracy, &mut scratch);
            let call = Interaction { at, brdf: &lobes, light: &term, threshold: 0.0 };
            all += FractionIntegrator.radiance(&call, &mut visit, &mut (), &mut ()).radiance;
        }
        assert_eq!(all, tiled[i], "point {i}");
    }
}

/// The same picture on the GPU, where there is one.
fn both_devices_agree() {
    let gpu = Gpu::blocking(&GpuOptions::default()).unwrap();
    let own = Own::new(96, 60);
    let points = own.points();
    let (cpu, gpu) = (own.on_cpu(&points).unwrap(), own.on_gpu(&gpu, &points).unwrap());
    let peak = cpu.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    let errors: Vec<f32> = cpu.iter().zip(&gpu).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    let mean = errors.iter().sum::<f32>() / errors.len() as f32;
    let most = errors.iter().fold(0.0, |a: f32, b| a.max(*b));
    println!("mean {mean:.2e}, most {most:.2e} of the peak");
    assert!(peak > 0.1 && mean < 1e-4 && most < 5e-3, "mean {mean}, most {most}");
}

/// Tests that need a GPU show as ignored without one.
pub(crate) fn main() {
    let tests: [(&str, fn()); 4] = [
        ("velvet_is_a_material", velvet_is_a_material),
        ("spots_are_lights", spots_are_lights),
        ("capsules_are_blockers", capsules_are_blockers),
        ("tiles_are_single_points", tiles_are_single_points),
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
