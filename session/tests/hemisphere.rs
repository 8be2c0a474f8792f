//! The hemisphere of a pixel that is taken apart holds its radiance: lobes summed over the drawn lights are the engine's numbers.

#![allow(clippy::unwrap_used, reason = "in tests")]

use brdf::{Lambert, MetallicRoughness, ModifiedPhong};
use core::f32::consts::{FRAC_PI_2, PI};
use glam::{Vec2, Vec3};
use lobe_core::Receiver;
use renderer::{LightMask, MaskSample, Renderer, Settings};
use scene::{Animation, Scene};
use session::{Hemisphere, HemispherePixel, Probe};
use shading::{BrdfLobes, LightLobes};

fn hemisphere(material: &dyn BrdfLobes, view: Vec3) -> Hemisphere {
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, view.normalize());
    let mut lobes = Vec::new();
    material.brdf_lobes(&at, &mut lobes);
    Hemisphere::new(&at, lobes)
}

#[test]
fn the_disc_has_equal_areas_and_every_direction_its_place() {
    let all = hemisphere(&Lambert { albedo: Vec3::new(0.8, 0.5, 0.2) }, Vec3::new(1.0, 2.0, -0.5));
    for (direction, radius) in [(Vec3::Y, 0.0), (Vec3::X, 1.0), (Vec3::new(0.0, 0.5, 0.75_f32.sqrt()), 0.5_f32.sqrt())]
    {
        let place = all.place(direction).unwrap();
        assert!((place.length() - radius).abs() < 1e-6, "{place}");
        assert!(all.direction(place * 0.999_999).unwrap().distance(direction) < 3e-3);
    }
    assert_eq!((all.place(Vec3::NEG_Y), all.direction(Vec2::splat(0.8))), (None, None));
    let [eye, mirror] = all.eye_and_mirror().map(Option::unwrap);
    assert!(eye.x > 0.3 && eye.y.abs() < 1e-6 && (eye + mirror).length() < 1e-6, "{eye} {mirror}");

    // Sums over the disc are integrals over the hemisphere: of a diffuse surface its albedo.
    let side = 200;
    let area = 2.0 * (2.0 / side as f32).powi(2);
    let sum = |all: &Hemisphere, lobe| {
        let value = |pixel: &HemispherePixel| match pixel {
            HemispherePixel::Dark(value) => *value,
            _ => Vec3::ZERO,
        };
        all.picture(side, lobe, &[]).iter().map(value).sum::<Vec3>() * area
    };
    assert!(sum(&all, None).distance(Vec3::new(0.8, 0.5, 0.2)) < 2e-3, "{}", sum(&all, None));
    // A glossy one is the sum of its lobes, brightest at the mirror's reflection.
    let phong = ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.4), exponent: 200.0 };
    let metal = MetallicRoughness::new(Vec3::new(1.0, 0.8, 0.3), 1.0, 0.3).unwrap();
    for material in [&phong as &dyn BrdfLobes, &metal] {
        let all = hemisphere(material, Vec3::new(1.0, 1.0, 0.0));
        let parts: Vec3 = (0..all.lobes().len()).map(|lobe| sum(&all, Some(lobe))).sum();
        assert!(all.lobes().len() > 1 && parts.distance(sum(&all, None)) < 1e-4);
        let section = all.section(None, 181);
        let (angle, most) = section.iter().max_by(|a, b| a.1.x.total_cmp(&b.1.x)).copied().unwrap();
        assert!((angle + 0.25 * PI).abs() < 0.05 && most.x > 1.0, "{angle} {most}");
        assert_eq!((section[0].0, section[180].0, section.len()), (-FRAC_PI_2, FRAC_PI_2, 181));
    }
    assert_eq!(all.value(Some(9), Vec3::Y), Vec3::ZERO);
}

/// The solid angle of a sample, and the direction of its middle.
fn sample(mask: &LightMask, column: usize, row: usize) -> (f32, Vec3) {
    let at = |x: f32, y: f32| mask.direction(column as f32 + x, row as f32 + y);
    ((at(1.0, 0.5) - at(0.0, 0.5)).cross(at(0.5, 1.0) - at(0.5, 0.0)).length(), at(0.5, 0.5))
}

#[test]
fn lobes_over_the_drawn_lights_are_the_radiance() {
    let scene = Scene { width: 160, height: 90, ..scene::builtin() };
    let mut renderer = Renderer::new(scene, Animation::default(), Settings::default()).unwrap();
    let lights: Vec<_> = renderer.lights().map(|(_, light)| light.clone()).collect();
    let (mut penumbrae, mut most) = (0, 0.0_f32);
    for pixel in 0..60 {
        let (x, y) = (8 + 16 * (pixel % 10), 40 + 8 * (pixel / 10));
        let Some(probe) = Probe::new(&mut renderer, x, y, 1).unwrap() else { continue };
        let masks: Vec<&LightMask> = probe.lights.iter().filter_map(|part| part.mask.as_ref()).collect();
        let picture = probe.hemisphere.picture(256, None, &masks);
        for (number, (part, light)) in probe.lights.iter().zip(&lights).enumerate() {
            let mask = part.mask.as_ref().unwrap();
            let radiance = light.radiance(&probe.pick.receiver);
            let [width, rows] = mask.size;
            let [mut lit, mut whole] = [Vec3::ZERO; 2];
            for place in 0..width * rows {
                let (angle, direction) = sample(mask, place % width, place / width);
                assert_eq!(mask.sample(direction), mask.samples[place], "a sample is where its direction is");
                let light = probe.hemisphere.value(None, direction) * radiance * angle;
                whole += if mask.samples[place] == MaskSample::Outside { Vec3::ZERO } else { light };
                lit += if mask.samples[place] == MaskSample::Lit { light } else { Vec3::ZERO };
            }
            let scale = part.unshadowed.max_element();
            if scale < 1e-4 {
                continue;
            }
            let off =
                [(whole, part.unshadowed), (lit, part.radiance)].map(|(a, b)| (a - b).abs().max_element() / scale);
            most = most.max(off[0]).max(off[1]);
            let is_penumbra = (0.1..0.9).contains(&mask.lit());
            penumbrae += usize::from(is_penumbra);
            // The picture shows the same parts.
            let count = |kind: fn(usize, &HemispherePixel) -> bool| picture.iter().filter(|p| kind(number, p)).count();
            let shown = count(|n, p| matches!(p, HemispherePixel::Lit(k, _) if *k == n));
            let hidden = count(|n, p| matches!(p, HemispherePixel::Blocked(k, _) if *k == n));
            if is_penumbra && shown + hidden > 200 {
                let part = shown as f32 / (shown + hidden) as f32;
                assert!((part - mask.lit()).abs() < 0.1, "{part} {}", mask.lit());
            }
            let outline = probe.hemisphere.outline(mask);
            assert!(outline.len() > 8 && outline.iter().all(|place| place.length() < 1.001));
        }
    }
    println!("{penumbrae} penumbrae; sums over the masks are off by {most:.4} of the unshadowed radiance at most");
    assert!(penumbrae >= 8 && most < 0.03, "{penumbrae} {most}");
}
