//! Rectangles, discs, polygons and tubes of light on the GPU: integrals over outlines, and pictures by each strategy.

use crate::call::{call, trial};
use crate::parity::View;
use crate::rays::{RAYS, fence, frame, unshadowed};
use crate::silhouettes::SILHOUETTES;
use core::f32::consts::TAU;
use glam::{DVec3, UVec2, Vec3};
use libtest_mimic::Trial;
use lighting::{AmbientLight, EnclosedLight, Environment, EnvironmentMap, FlatLight, Light, SphereLight, TubeLight};
use lobe_core::oracle::Random;
use lobe_core::wgsl::Piece;
use lobe_core::{
    BrdfLobe, Grain, LightImage, Lobe, Microfacets, Outline, PackedLobe, Receiver, Sphere, outline_integral, wgsl,
};
use paper::{ProductTable, Resolution, Tables};
use render_cpu::{GBuffer, World};
use render_gpu::{Gpu, GpuShader, Occlusion};
use scene::{Scene, Shade, builtin};
use std::sync::Arc;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("outline_integrals", gpu, |gpu| integrals(gpu, &wgsl::OUTLINE_MICROFACETS, false)),
        trial("outline_integrals_of_brushed_lobes", gpu, |gpu| integrals(gpu, &wgsl::OUTLINE_BRUSHED, true)),
        trial("flat_lights_and_spheres", gpu, beside_spheres),
        trial("flat_lights_and_rays", gpu, |gpu| RAYS.compare(gpu, "rays", &lit(fence(), panel()), [48, 36], 0.003, 5)),
        trial("flat_lights_and_silhouettes", gpu, by_silhouettes),
        trial("flat_lights_that_show_an_image", gpu, of_images),
        trial("environments_and_ambient_light", gpu, of_environments),
        trial("flat_lights_are_not_for_the_paper", gpu, refusals),
    ]
}

const ROOM: usize = 8;
/// Numbers of a case: view, lobe's axis, exponent, factor, axis of the light, corners and their number, radius.
const INPUTS: usize = 3 + 3 + 2 + 3 + 2 + 3 * ROOM;

/// A polygon or a disc above the horizon or across it, with its corners (of a disc the centre) relative to the receiver.
fn outline(random: &mut Random) -> Option<(Outline, Vec<Vec3>, f32)> {
    let (toward, normal) = (random.axis().as_vec3(), random.axis().as_vec3());
    let center = toward * random.between(1.0, 2.0) as f32;
    let size = random.log_uniform(1e-3, 2.0) as f32;
    let axis = if normal.dot(center) > 0.0 { normal } else { -normal };
    let (u, v) = axis.any_orthonormal_pair();
    if random.bits().is_multiple_of(4) {
        return Some((Outline::disc(center, size, axis)?, vec![center], size));
    }
    let count = 3 + (random.bits() % 6) as usize;
    let long = random.log_uniform(1.0, 10.0) as f32;
    // Clockwise or counter-clockwise.
    let turn = if random.bits().is_multiple_of(2) { TAU } else { -TAU };
    let corner = |k: usize| {
        let (sin, cos) = (turn * (k as f32 + 0.3) / count as f32).sin_cos();
        center + (u * cos + v * (sin / long)) * size
    };
    let corners: Vec<Vec3> = (0..count).map(corner).collect();
    Some((Outline::new(&corners, axis)?, corners, 0.0))
}

/// The same rules in another order of operations. Errors are relative to the light's integral with a lobe of that size along the
/// axis.
fn integrals(gpu: &Gpu, piece: &'static Piece, is_brushed: bool) {
    let mut random = Random::new(23);
    let (mut rows, mut want) = (Vec::new(), Vec::new());
    while want.len() < 4096 {
        let Some((light, corners, radius)) = outline(&mut random) else { continue };
        let tilt = random.between(0.0, 1.5);
        let view = random.axis_at(DVec3::Z, tilt).as_vec3().normalize();
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        let Some(above) = light.above(at.normal) else { continue };
        let aside = random.axis().as_vec3() * random.log_uniform(0.01, 1.0) as f32;
        let toward = (above.middle().normalize() + aside).normalize();
        let lobe: BrdfLobe = match want.len() % 4 {
            0 => Lobe::new(Vec3::Z, 1.0, Vec3::ONE).into(),
            1 => Lobe::new(toward, random.log_uniform(0.3, 2e4) as f32, Vec3::ONE).times_cosine().into(),
            2 => Lobe::new(toward, random.log_uniform(0.3, 2e4) as f32, Vec3::ONE).into(),
            _ => {
                let alpha = random.log_uniform(0.01, 1.0) as f32;
                let facets = Microfacets::new(view, alpha, [Vec3::ONE; 2])[(random.bits() % 2) as usize];
                let grain = (is_brushed && want.len() % 16 != 3).then(|| {
                    let tangent = random.axis().as_vec3();
                    Grain::new(Vec3::Z, view, tangent, random.uniform() as f32)
                });
                facets.with_grain(grain).into()
            }
        };
        let PackedLobe { axis, exponent, kind, .. } = lobe.into();
        rows.extend(view.to_array().into_iter().chain(axis.to_array()).chain([exponent, kind]));
        rows.extend(light.axis().to_array().into_iter().chain([corners.len() as f32, radius]));
        let points = corners.iter().copied().chain(core::iter::repeat(Vec3::ZERO)).take(ROOM);
        rows.extend(points.flat_map(|p| p.to_array()));
        let (solid, _) = above.moments();
        let scale = (solid * (exponent + 1.0) / TAU).min(1.0);
        want.push((outline_integral(&at, lobe, &light), scale, light.cone()));
    }
    let body = "var at: Receiver;
        at.normal = vec3f(0.0, 0.0, 1.0);
        at.view = vec3f(x(0), x(1), x(2));
        let lobe = Lobe(vec3f(x(3), x(4), x(5)), x(6), vec3f(1.0), x(7));
        let axis = vec3f(x(8), x(9), x(10));
        for (var k = 0u; k < 8u; k++) { outline_corners[k] = vec3f(x(13u + 3u * k), x(14u + 3u * k), x(15u + 3u * k)); }
        if (x(12) > 0.0) { outline_disc(outline_corners[0], x(12), axis); } else { outline_new(u32(x(11)), axis); }
        let cone = outline_cone(vec3f(1.0));
        outline_keep_above(at.normal);
        y(0, light_integral(at, lobe, cone));
        y(1, cone.one_minus_cos);
        y(2, cone.distance);
        y(3, dot(cone.axis, light_middle()));";
    let text = wgsl::join(&[piece, &wgsl::OUTLINE_PLAIN])
        + "fn cap_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 { return 0.0; }";
    let got = call(gpu, &text, body, &rows, INPUTS, 4);
    let (mut sums, mut worst, mut cones) = ([0.0_f64; 4], [0.0_f64; 4], 0.0_f32);
    for (k, (got, (want, scale, cone))) in got.chunks(4).zip(&want).enumerate() {
        assert!(got.iter().all(|x| x.is_finite()), "case {k}: {got:?}");
        let error = f64::from((got[0] - want).abs() / scale.max(1e-6));
        (sums[k % 4], worst[k % 4]) = (sums[k % 4] + error, worst[k % 4].max(error));
        // Rounding makes a cone a hemisphere on one device and a little less on the other.
        if (got[1] < 1.0) == (cone.one_minus_cos < 1.0) {
            cones = cones.max((got[1] - cone.one_minus_cos).abs() / cone.one_minus_cos);
            if cone.distance.is_finite() {
                cones = cones.max((got[2] / cone.distance - 1.0).abs());
            }
        }
    }
    // In millionths.
    let mean = sums.map(|sum| 4e6 * sum / want.len() as f64);
    let worst = worst.map(|worst| 1e6 * worst);
    println!(
        "Lambert, powers with and without cosine, microfacets: mean {mean:.1?}, worst {worst:.1?} (1e-6); cones {cones:.1e}"
    );
    assert!(mean.iter().all(|m| *m < 100.0) && worst.iter().all(|w| *w < 1e4) && cones < 1e-3);
}

fn panel() -> Light {
    let light =
        FlatLight::rectangle(Vec3::new(-1.5, 3.2, 1.8), Vec3::X * 0.5, Vec3::new(0.0, 0.2, -0.4), Vec3::splat(60.0));
    light.expect("a rectangle").on_both_sides().into()
}

fn disc() -> Light {
    FlatLight::disc(Vec3::new(1.0, 2.5, 1.0), Vec3::new(-0.3, -1.0, -0.2), 0.5, Vec3::splat(30.0))
        .expect("a disc")
        .into()
}

/// The floor's horizon cuts it.
fn standing() -> Light {
    let corners = [[-2.1, -0.3, -1.0], [-2.1, -0.3, 1.0], [-2.1, 0.9, 1.2], [-2.1, 1.4, 0.0], [-2.1, 0.9, -1.2]];
    FlatLight::polygon(&corners.map(Vec3::from_array), Vec3::splat(9.0)).expect("a pentagon").on_both_sides().into()
}

fn tube() -> Light {
    TubeLight { ends: [Vec3::new(-1.0, 1.8, 1.5), Vec3::new(1.4, 2.2, 0.8)], radius: 0.06, radiance: Vec3::splat(90.0) }
        .into()
}

fn lit(scene: Scene, light: Light) -> Scene {
    Scene { lights: vec![light], ..scene }
}

/// All shapes of light and a sphere, on all kinds of surfaces.
fn beside_spheres(gpu: &Gpu) {
    let inside = EnclosedLight { light: Box::new(disc()), object: 0 }.into();
    let sphere = SphereLight::new(Sphere { center: Vec3::new(2.0, 3.0, 1.0), radius: 0.3 }, Vec3::splat(20.0)).into();
    let scene = Scene { lights: vec![panel(), disc(), sphere, standing(), inside], ..builtin() };
    // A CPU divides masks of a light that is wide as seen by angle.
    View::new(scene, 64, 36).compare_spheres_but(gpu, "flat lights", [0.003, 0.02], 5, 12);
}

/// Silhouettes with a tube, and with panels whose planes cut the pickets, one of them between the pickets. The edges' directions
/// cancel for these pickets and rails; rounding then decides the mask's rotation, and the masks differ but are equally exact.
fn by_silhouettes(gpu: &Gpu) {
    SILHOUETTES.compare(gpu, "tube", &lit(fence(), tube()), [48, 36], 0.003, 5);
    let panel = |u: f32, v: f32| -> Light {
        let panel = FlatLight::rectangle(Vec3::new(0.2, 0.5, 0.3), Vec3::X * u, Vec3::Z * v, Vec3::splat(9.0));
        panel.expect("a rectangle").on_both_sides().into()
    };
    for (name, light) in [("low", panel(0.4, 0.15)), ("among the pickets", panel(0.05, 0.25))] {
        let scene = lit(fence(), light);
        let world = World::new(&scene);
        let points = GBuffer::new(&world, 48, 36, 1).points;
        let frame = frame(&scene, 0.003, 5);
        let whole = unshadowed(&points, &frame);
        let (want, counts) = (SILHOUETTES.cpu)(&world, &points, &frame);
        let (got, ours) = (SILHOUETTES.gpu)(gpu, &scene, &points, &frame);
        let (mut sum, mut largest) = (0.0, 0.0_f32);
        for ((want, got), whole) in want.iter().zip(&got).zip(&whole).filter(|(_, whole)| **whole > 0.0) {
            let difference = (want.element_sum() - got.element_sum()).abs() / whole;
            (sum, largest) = (sum + f64::from(difference), largest.max(difference));
        }
        let mean = sum / want.len() as f64;
        println!("{name}: mean {mean:.1e}, largest {largest:.1e} of the light; {counts:?} {ours:?}");
        assert!(mean < 4e-4 && largest < 1e-2 && counts.penumbra_points > 300 && counts == ours, "{name}");
    }
}

/// Screens with wave-shaped outlines, one cut by the floor's horizon.
fn of_images(gpu: &Gpu) {
    let size = UVec2::new(64, 32);
    let wave = |place: u32, step: f32| 1.0 + 0.9 * (place as f32 * step).sin();
    let texel = |k: u32| Vec3::new(wave(k % 64, 0.4), wave(k / 64, 0.7), 0.5);
    let texels: Vec<Vec3> = (0..size.x * size.y).map(texel).collect();
    let (image, mean) = LightImage::new(size, &texels).expect("an image");
    let screen = |center: Vec3, u: Vec3, v: Vec3| -> Light {
        let light = FlatLight::rectangle(center, u, v, mean * 12.0).expect("a rectangle").on_both_sides();
        light.showing(Arc::new(image.clone())).expect("right angles").into()
    };
    let above = screen(Vec3::new(-1.0, 3.0, 1.5), Vec3::X * 0.7, Vec3::new(0.0, 0.2, -0.6));
    let standing = screen(Vec3::new(-2.1, 0.4, 0.0), Vec3::Z * 1.2, Vec3::Y * 0.8);
    let scene = Scene { lights: vec![above, standing], ..builtin() };
    // Rounding decides whether the middle of a cell of the image is above the horizon.
    View::new(scene, 48, 27).compare_spheres_but(gpu, "images", [0.003, 2e-3], 5, 12);
}

fn of_environments(gpu: &Gpu) {
    let mut view = View::new(builtin(), 48, 27);
    let world = Sphere { center: Vec3::Y, radius: 6.0 };
    let gray = |p: Vec3| Vec3::new(0.4, 0.5, 0.7) * (1.5 + p.y) + Vec3::splat(0.3 * (4.0 * p.x).sin().abs());
    let texels: Vec<Vec3> = (0..32 * 16)
        .map(|k| {
            let (x, y) = (TAU * (k % 32) as f32 / 32.0, core::f32::consts::PI * ((k / 32) as f32 + 0.5) / 16.0);
            gray(Vec3::new(y.sin() * x.cos(), y.cos(), y.sin() * x.sin()))
        })
        .collect();
    let map = EnvironmentMap::new(UVec2::new(32, 16), texels).expect("a map");
    let ambient = AmbientLight { radiance: Vec3::new(0.2, 0.3, 0.4), world }.into();
    view.scene.lights = vec![ambient];
    view.scene.lights.extend_from_slice(Environment::new(map, 1, world).lights());
    // Patches show their part of the map: as above.
    view.compare_spheres_but(gpu, "environment", [0.003, 2e-3], 5, 12);
}

fn refusals(gpu: &Gpu) {
    let view = View::new(lit(builtin(), panel()), 16, 9);
    let tables = Tables::with_products(ProductTable::build_with(Resolution { angles: 33, per_interval: 4 }));
    let mut shader = GpuShader::new(gpu, Occlusion::default()).expect("a shader").with_paper(&tables);
    let mut out = vec![Vec3::ZERO; view.points.receivers.len()];
    let refused = shader.shade(&view.points, &view.frame(0.003, 5), &mut out).expect_err("no sphere lights");
    assert!(refused.to_string().contains("sphere lights"), "{refused}");
}
