//! Error of the default settings over exponents and light sizes, in one table.
//!
//! `cargo run --release --example accuracy_table [-- SPP [TOLERANCE]]`. Spheres over a glossy floor, the highlight where
//! two shadows meet; the camera zooms with the light, so that about as many pixels are in penumbra for any size.
//! Reference: Monte Carlo of the same blockers (4096 samples a pixel unless given).

use cosine_lobes::brdf::{Lambert, Material, Phong};
use cosine_lobes::lighting::SphereLight;
use cosine_lobes::lobe_core::Sphere;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Geometry, Reference, ReferenceJob};
use cosine_lobes::render_cpu::CpuShader;
use cosine_lobes::scene::{BlockerSet, Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{Picture, ShadowErrors};
use glam::Vec3;
use std::sync::atomic::AtomicBool;

const EXPONENTS: [f32; 4] = [1.0, 20.0, 200.0, 2000.0];
const HALF_ANGLES: [f32; 4] = [0.1, 1.0, 8.0, 25.0];
const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

fn scene(exponent: f32, half_angle: f32) -> Scene {
    let floor: Material = if exponent == 1.0 {
        Lambert { albedo: Vec3::splat(0.6) }.into()
    } else {
        let ks = Vec3::splat(0.3 * (exponent + 2.0) / core::f32::consts::TAU);
        Phong { kd: Vec3::splat(0.05), ks, exponent }.into()
    };
    // The light in direction (−½, √¾), the eye where the floor mirrors it.
    let up = Vec3::new(-0.5, 0.75_f32.sqrt(), 0.0);
    let (distance, sin) = (20.0, half_angle.to_radians().sin());
    let at = |along: f32, x: f32, z: f32, radius: f32| {
        // Centres on the ray from (x, z) of the floor to the light, so the shadows' centres are known.
        Sphere { center: Vec3::new(x, 0.0, z) + up * along, radius }
    };
    // Extent of the view: some penumbra widths, at most a few units.
    let view = (9.0 * half_angle.to_radians().tan()).min(3.0);
    let spheres = vec![
        at(2.0, 0.30 + 0.1 * view, 0.35, 0.45 * view.max(0.6)),
        at(1.5, -0.1 - 0.45 * view.max(0.6), -0.2, 0.45 * view.max(0.6)),
        at(2.5, 0.1 * view, -0.45 * view, 0.15 * view),
        at(1.2, 0.25 * view, 0.3 * view, 0.06 * view),
    ];
    let eye = Vec3::new(0.5, 0.75_f32.sqrt(), 0.0) * 12.0;
    let floor_mesh = Mesh::quad(Vec3::ZERO, Vec3::X * 40.0, Vec3::NEG_Z * 40.0);
    let mut casters = Object::spheres("spheres", spheres, 0);
    casters.visible = false;
    Scene {
        camera: Camera {
            eye,
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::perspective(2.0 * (0.5 * view / 12.0).atan()),
        },
        width: WIDTH,
        height: HEIGHT,
        materials: vec![floor],
        objects: vec![Object::mesh("floor", floor_mesh, 0, Proxy::None), casters],
        lights: vec![SphereLight::new(Sphere { center: up * distance, radius: distance * sin }, Vec3::ONE).into()],
        ..Scene::default()
    }
}

struct Cell {
    errors: ShadowErrors,
    noise: f64,
}

fn measure(scene: &Scene, samples: u32, tolerance: f32) -> Cell {
    let world = World::new(scene);
    let gbuffer = GBuffer::new(&world, scene.width, scene.height, 1);
    let spheres: Vec<Sphere> = scene
        .objects
        .iter()
        .flat_map(|o| match &o.proxy {
            Proxy::Spheres(s) => s.clone(),
            _ => Vec::new(),
        })
        .collect();
    let blockers = BlockerSet { objects: vec![1; spheres.len()], spheres, ..BlockerSet::default() };

    let spheres = SphereBlockers::new(&blockers.spheres, &blockers.objects, &blockers.self_distances);
    let mut shader = CpuShader::new(MaskVisibility::new(spheres));
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(tolerance));
    let mut radiance = vec![Vec3::ZERO; gbuffer.len()];
    shader.shade(&gbuffer.points, &frame, &mut radiance).expect("room for all lobes");

    let job =
        ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Spheres, seed: 1 };
    let mut reference = Reference::new(job);
    reference.advance(samples, &AtomicBool::new(false), &|_| {});
    let truth = reference.estimate();
    let picture = |values: &[Vec3]| {
        Picture::new(scene.width as usize, scene.height as usize, gbuffer.resolve(values, Vec3::ZERO))
    };
    let unshadowed = picture(&truth.unshadowed);
    let errors = ShadowErrors::of(&picture(&radiance), &picture(&truth.radiance), &unshadowed).expect("equal sizes");
    let noise = truth.std_error.iter().map(|v| f64::from(v.y)).sum::<f64>()
        / truth.unshadowed.iter().map(|v| f64::from(v.y)).sum::<f64>();
    Cell { errors, noise }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mut number = |default: f32| arguments.next().and_then(|a| a.parse().ok()).unwrap_or(default);
    let (samples, tolerance) = (number(4096.0) as u32, number(0.003));
    println!(
        "Error in % of the unshadowed radiance, tolerance {} %: penumbra mean / p99 (lit mean)\n",
        100.0 * tolerance
    );
    println!("| Phong exponent | {} |", HALF_ANGLES.map(|a| format!("{a}°")).join(" | "));
    println!("|---|{}", "---|".repeat(HALF_ANGLES.len()));
    let mut missed = Vec::new();
    for exponent in EXPONENTS {
        let mut row = format!("| {exponent} |");
        for angle in HALF_ANGLES {
            let cell = measure(&scene(exponent, angle), samples, tolerance);
            let [mean, p99] = [cell.errors.penumbra.mean, cell.errors.penumbra.p99].map(|x| 100.0 * x);
            row += &format!(" {mean:.3} / {p99:.2} ({:.3}) |", 100.0 * cell.errors.lit.mean);
            if mean > 0.5 || p99 > 2.0 {
                missed.push(format!("exponent {exponent} at {angle}°"));
            }
            eprintln!(
                "exponent {exponent}, {angle}°: {} pixels in penumbra, {} dark ones of which {} are not 0, noise of the reference {:.4} %",
                cell.errors.penumbra.pixels,
                cell.errors.dark.pixels,
                cell.errors.dark_nonzero,
                100.0 * cell.noise
            );
        }
        println!("{row}");
    }
    let missed = if missed.is_empty() { "none".into() } else { missed.join(", ") };
    println!("\nMissed (mean 0.5 %, p99 2 %): {missed}");
}
