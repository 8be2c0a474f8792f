//! The paper's tables and lobes in WGSL against the same in Rust.

use crate::call::{call_with, trial};
use crate::parity::View;
use brdf::{Lambert, ModifiedPhong, Phong};
use glam::Vec3;
use libtest_mimic::Trial;
use lighting::SphereLight;
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe, PackedLobe, Sphere, wgsl};
use paper::{PaperIntegrator, PaperVisibility, PaperWeights, ProductTable, Resolution, Tables};
use render_cpu::CpuShader;
use render_gpu::{Gpu, GpuShader, Occlusion};
use scene::Shade;
use visibility_mask::{Blockers, Mixture};

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("paper_products", gpu, paper_products),
        trial("paper_caps", gpu, paper_caps),
        trial("parity_of_the_paper", gpu, parity_of_the_paper),
        trial("parity_of_the_paper_with_maps", gpu, parity_of_the_paper_with_maps),
        trial("parity_of_the_printed_table", gpu, parity_of_the_printed_table),
    ]
}

const COUNT: usize = 1 << 13;
const TABLES: &str = "@group(0) @binding(9) var<storage, read> paper_tables: array<vec2f>;";

fn tables() -> Tables {
    Tables::with_products(ProductTable::build_with(Resolution { angles: 33, per_interval: 4 }))
}

fn lobe(random: &mut Random, near: Option<Vec3>) -> Lobe {
    let axis = if let Some(near) = near { random.axis_near(near.as_dvec3()) } else { random.axis() }.as_vec3();
    let exponent = if random.bits().is_multiple_of(16) { f32::INFINITY } else { random.exponent(1e6) as f32 };
    let flux = Vec3::new(random.uniform() as f32, random.log_uniform(1e-6, 1e3) as f32, -random.uniform() as f32);
    Lobe { has_cosine: random.bits() % 2 == 1, ..Lobe::with_flux(axis, exponent, flux) }
}

/// A position in the table is a polynomial's angle, with an error of 5e-7 of a radian (5e-6 of a step between angles) beside its
/// own rounding. A table falls by its whole value in one step for large exponents.
fn paper_products(gpu: &Gpu) {
    let tables = tables();
    let words: Vec<u32> = tables.pack().as_flattened().iter().map(|x| x.to_bits()).collect();
    let mut random = Random::new(6);
    let (mut rows, mut cases) = (Vec::new(), Vec::new());
    for k in 0..COUNT {
        let a = lobe(&mut random, None);
        let near = if k % 16 == 0 { -a.axis } else { a.axis };
        let b = lobe(&mut random, (k % 2 == 0).then_some(near));
        rows.extend_from_slice(bytemuck::cast_slice(&[a, b].map(PackedLobe::from)));
        cases.push((a, b));
    }
    let body = "let c = paper_product(
            Lobe(vec3f(x(0), x(1), x(2)), x(3), vec3f(x(4), x(5), x(6)), x(7)),
            Lobe(vec3f(x(8), x(9), x(10)), x(11), vec3f(x(12), x(13), x(14)), x(15)));
        y(0, c.axis.x); y(1, c.axis.y); y(2, c.axis.z); y(3, c.exponent);
        y(4, c.flux.x); y(5, c.flux.y); y(6, c.flux.z); y(7, c.kind);";
    let got = call_with(gpu, &(wgsl::join(&[&paper::wgsl::TABLES]) + TABLES), body, &rows, [16, 8], &[(9, &words)]);
    let (mut worst, mut sums) = ([0.0_f32; 3], [0.0_f32; 3]);
    for (got, (a, b)) in got.chunks(8).zip(&cases) {
        let want = tables.product(a, b);
        let got = *bytemuck::from_bytes::<PackedLobe>(bytemuck::cast_slice(got));
        assert!(got.flux.is_finite() && got.axis.is_finite() && got.exponent.is_finite(), "{got:?} {a:?} {b:?}");
        assert_eq!(got.kind, PackedLobe::from(want).kind);
        // If the two axes are opposite, the table's value is zero and the direction has no meaning.
        let opposite = (a.axis + b.axis).length() < 1e-3;
        let limit = |e: f32| e.min(1e5) + 1.0;
        // Relative to the product of the scales: the table's interpolated entry.
        let scales = (a.flux * b.flux).abs() * (limit(a.exponent) * limit(b.exponent) / core::f32::consts::TAU.powi(2));
        let entry = ((got.flux * (got.exponent + 1.0) - want.flux * (want.exponent + 1.0)) / core::f32::consts::TAU)
            .abs()
            / scales.max(Vec3::splat(1e-30));
        let differences = [
            entry.max_element(),
            (got.exponent - want.exponent).abs() / (1.0 + want.exponent),
            if opposite {
                0.0
            } else {
                (got.axis - want.axis).length() * a.axis.cross(b.axis).length().clamp(0.02, 1.0)
            },
        ];
        for k in 0..3 {
            worst[k] = worst[k].max(differences[k]);
            sums[k] += differences[k] / cases.len() as f32;
        }
    }
    println!("entry, exponent, axis: mean {sums:?}, worst {worst:?}");
    assert!(worst[0] < 1e-4 && worst[1] < 1e-3 && worst[2] < 3e-6, "{worst:?}");
    assert!(sums.iter().all(|mean| *mean < 3e-6), "{sums:?}");
}

fn paper_caps(gpu: &Gpu) {
    let tables = tables();
    let weights = PaperWeights::solve(5, &tables);
    let mut pairs = tables.pack();
    pairs.extend(weights.pack());
    let words: Vec<u32> = pairs.as_flattened().iter().map(|x| x.to_bits()).collect();
    let mut random = Random::new(7);
    let rows: Vec<f32> = (0..COUNT)
        .flat_map(|k| {
            let level = (random.bits() % 6) as f32;
            let dist = if k % 2 == 0 { random.uniform() * 12.0 } else { random.log_uniform(1e-3, 1e9) };
            [if k % 64 == 0 { 0.0 } else { random.log_uniform(1e-12, 2.0) as f32 }, level, dist as f32]
        })
        .collect();
    let body = "let cone = Cone(vec3f(0.0, 0.0, 1.0), x(0), 1.0);
        let light = paper_light_lobe(cone, vec3f(2.0));
        let occluder = paper_occluder(cone);
        y(0, light.exponent); y(1, light.flux.x); y(2, occluder.exponent); y(3, occluder.flux.x);
        y(4, paper_weight(u32(x(1)), x(2)));";
    let text =
        wgsl::join(&[&paper::wgsl::VISIBILITY, &visibility_mask::wgsl::ROUND]) + &paper::wgsl::header(5) + TABLES;
    let got = call_with(gpu, &text, body, &rows, [3, 5], &[(9, &words)]);
    let mut worst = 0.0_f32;
    for (got, row) in got.chunks(5).zip(rows.chunks(3)) {
        let cone = Cone { axis: Vec3::Z, one_minus_cos: row[0], distance: 1.0 };
        let (light, occluder) = (tables.light_lobe(&cone, Vec3::splat(2.0)), tables.caps.occluder(&cone));
        let weight = weights.weight(row[1] as u32, row[2]);
        let want = [light.exponent, light.flux.x, occluder.exponent, occluder.flux.x, weight];
        for (got, want) in got.iter().zip(want) {
            // Exponents are as large as floats allow, not infinite.
            let far = want > 1e30 && *got > 1e30;
            worst = worst.max(if far { 0.0 } else { (got - want).abs() / want.abs().max(1.0) });
        }
    }
    println!("caps and weights: {worst:.1e}");
    assert!(worst < 3e-6);
}

/// [`compare_blockers`] with the spheres.
fn compare(gpu: &Gpu, view: &View, tables: &Tables, name: &str, depth: u32, threshold: f32) {
    let occlusion = Occlusion { blockers: &[&view.spheres], any_hit: None };
    let frame = scene::Frame { threshold, ..view.frame(0.003, depth) };
    compare_blockers(gpu, view, tables, name, &frame, view.spheres.clone(), occlusion);
}

/// Pictures of both devices: differences relative to the picture's largest value, and points of each class.
fn compare_blockers(
    gpu: &Gpu,
    view: &View,
    tables: &Tables,
    name: &str,
    frame: &scene::Frame<'_>,
    blockers: impl Blockers,
    occlusion: Occlusion<'_>,
) {
    let depth = frame.accuracy.depth;
    let visibility = PaperVisibility::new(blockers, tables);
    let mut want = vec![Vec3::ZERO; view.points.receivers.len()];
    let mut cpu = CpuShader::with_integrator(visibility, PaperIntegrator { tables });
    let w = cpu.shade(&view.points, frame, &mut want).expect("room for all lobes").counts;
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader").with_paper(tables);
    let (got, g) = view.gpu(&mut shader, frame);
    let again = view.gpu(&mut shader, frame);
    assert!((&got, &g) == (&again.0, &again.1), "{name}: two runs differ");
    let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let differences: Vec<f32> = want.iter().zip(&got).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    let largest = differences.iter().copied().fold(0.0, f32::max);
    let mean = differences.iter().map(|x| f64::from(*x)).sum::<f64>() / differences.len() as f64;
    let place = differences.iter().position(|x| *x == largest).unwrap_or(0);
    println!(
        "{name}, depth {depth}: largest {largest:.1e} (point {place}: {} {}), mean {mean:.1e}",
        want[place], got[place]
    );
    println!("    lit {} {}, dark {} {}", w.lit_points, g.lit_points, w.dark_points, g.dark_points);
    println!("    penumbra {} {}, integrals {} {}", w.penumbra_points, g.penumbra_points, w.integrals, g.integrals);
    println!("    pruned {} {}", w.pruned, g.pruned);
    assert!(got.iter().all(|v| v.is_finite()) && peak > 0.0, "{name}");
    assert!(w.penumbra_points > 0 && w.integrals > w.penumbra_points, "{name}: nothing is in shadow");
    assert!(largest <= 1e-3 && mean <= 1e-5, "{name}");
    // Rounding decides whether a leaf is in shadow if its last sample is on its edge.
    let apart = |a: u64, b: u64| a.abs_diff(b) as f64 <= 1.0 + 5e-4 * want.len() as f64;
    assert!(apart(w.lit_points, g.lit_points) && apart(w.penumbra_points, g.penumbra_points), "{name}");
    assert_eq!(w.dark_points, g.dark_points, "{name}");
    for (want, got) in [(w.integrals, g.integrals), (w.pruned, g.pruned)] {
        assert!(want.abs_diff(got) as f64 <= 1.0 + 1e-4 * w.integrals as f64, "{name}: {want} {got}");
    }
}

fn parity_of_the_paper(gpu: &Gpu) {
    let tables = tables();
    let mut view = View::new(scene::builtin(), 48, 27);
    // Each depth is a kernel that takes seconds to compile: 4 and 5 are below.
    for depth in [1, 2, 3, 6] {
        compare(gpu, &view, &tables, "built-in scene", depth, 0.0);
    }
    compare(gpu, &view, &tables, "threshold 0.01", 5, 0.01);
    let kd = Vec3::new(0.5, 0.4, 0.3);
    view.scene.materials.fill(Lambert { albedo: kd }.into());
    compare(gpu, &view, &tables, "lambert", 4, 0.0);
    view.scene.materials.fill(Phong { kd, ks: Vec3::splat(0.3), exponent: 40.0 }.into());
    compare(gpu, &view, &tables, "phong", 4, 0.0);
    view.scene.materials.fill(ModifiedPhong { kd, ks: Vec3::splat(0.4), exponent: 10.0 }.into());
    let light = |k: u32| {
        let center = Vec3::new(4.0 * (2.4 * k as f32).cos(), 3.0, 2.0 + 3.0 * (2.4 * k as f32).sin());
        SphereLight::new(Sphere { center, radius: 0.1 + 0.2 * k as f32 }, Vec3::splat(20.0)).into()
    };
    view.scene.lights = (0..4).map(light).collect();
    compare(gpu, &view, &tables, "modified phong, four lights", 4, 0.0);
}

/// The meshes by shadow maps, alone and with the spheres by sphere blockers.
fn parity_of_the_paper_with_maps(gpu: &Gpu) {
    let tables = tables();
    let view = View::new(scene::builtin(), 64, 36);
    let maps = view.maps();
    let packed = maps.pack();
    // Each is a kernel that takes seconds to compile: by turns.
    for depth in [3, 5] {
        let alone = Occlusion { blockers: &[&packed], any_hit: None };
        compare_blockers(gpu, &view, &tables, "maps", &view.frame(0.003, depth), maps.clone(), alone);
    }
    for depth in [4, 6] {
        let mixture = Mixture::new(maps.clone(), view.spheres.clone());
        let both = Occlusion { blockers: &[&view.spheres, &packed], any_hit: None };
        compare_blockers(gpu, &view, &tables, "maps and spheres", &view.frame(0.003, depth), mixture, both);
    }
}

fn parity_of_the_printed_table(gpu: &Gpu) {
    let view = View::new(scene::builtin(), 64, 36);
    compare(gpu, &view, &Tables::build(), "printed table", 5, 0.0);
}
