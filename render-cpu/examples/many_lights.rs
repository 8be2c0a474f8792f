//! Many lights: time and error against their number, with [faint lights](CpuShader) added without a query and without.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example many_lights [-- SCENE…]` prints a table in Markdown: a bunny on a floor under up to 50
//! lights, and a street of houses and lamp posts under up to 400. Times are of one thread's processor, the least of three. Errors are those of the sum
//! over all lights against the same picture at a tolerance of 0.05 %, in % of a pixel's radiance without blockers, and of its
//! own, where that is above a thousandth of white.

use brdf::Material;
use glam::Vec3;
use lighting::{Light, SphereLight};
use lobe_core::{Accuracy, Sphere};
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, ShadeRequest, SurfaceHits, World};
use scene::{Camera, Frame, Mesh, Object, Proxy, Scene, ShadingPoints};
use std::error::Error;
use std::path::Path;
use visibility_mask::{LookAgain, MaskVisibility};
use visibility_silhouettes::SilhouetteBlockers;

const TOLERANCE: f32 = 0.005;
/// So few lights at once are never faint.
const FEW: usize = 7;

fn main() -> Result<(), Box<dyn Error>> {
    let (numbers, wanted): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|word| word.parse::<u32>().is_ok());
    let side = numbers.first().and_then(|n| n.parse().ok()).unwrap_or(256);
    let most = numbers.get(1).and_then(|n| n.parse().ok()).unwrap_or(400);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    println!(
        "| scene | lights | ms | × one | ms, all queried | × one | of unshadowed: mean, 99.9 %, largest | of own | all queried, of own |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, counts) in [("bunny", &[1, 4, 16, 50][..]), ("street", &[1, 4, 16, 50, 400])] {
        if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
            continue;
        }
        let scene = if name == "bunny" { bunny() } else { Ok(street()) };
        match scene {
            Ok(scene) => pool.install(|| measure(name, scene, counts, [side, most])),
            Err(reason) => eprintln!("{name} is left out: {reason}"),
        }
    }
    Ok(())
}

/// Nanoseconds that this thread has run.
fn clock() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|n| n.parse().ok()).unwrap_or_default()
}

fn measure(name: &str, mut scene: Scene, counts: &[usize], [side, most]: [u32; 2]) {
    (scene.width, scene.height) = (side, side);
    let world = World::new(&scene);
    let silhouettes = SceneSilhouettes::new(&scene, |_| true);
    let mut picture = GBuffer::new(&world, side, side, 1);
    picture.find_squares();
    let points = picture.points;
    let shader = |tolerance: f32, again, is_between| {
        let hits = SurfaceHits::new(&world, |_| true);
        let blockers = SilhouetteBlockers::new(silhouettes.meshes(), hits).with_tolerance(tolerance);
        CpuShader::new(MaskVisibility::new(blockers).look_again(again)).interpolating(is_between)
    };
    let shade = |tolerance: f32, again, lights: &[Light], at_once: usize, times: usize, is_between: bool| {
        let shader = shader(tolerance, again, is_between);
        let mut out = vec![Vec3::ZERO; points.receivers.len()];
        let mut part = out.clone();
        let mut least = f64::INFINITY;
        for _ in 0..times {
            out.fill(Vec3::ZERO);
            let start = clock();
            for lights in lights.chunks(at_once) {
                let frame = Frame::new(&scene.materials, lights, Accuracy::new(tolerance));
                let _ = shader.shade_with(&points, &frame, &mut part, &ShadeRequest::default());
                out.iter_mut().zip(&part).for_each(|(out, part)| *out += *part);
            }
            least = least.min(clock() - start);
        }
        (out, least * 1e-6)
    };
    let mut one = [f64::NAN; 2];
    for &count in counts.iter().filter(|count| **count <= most as usize) {
        let times = if count < 50 { 3 } else { 1 };
        let lights = match name {
            "bunny" => lamps(count),
            _ => lanterns(count),
        };
        let (all, time_all) = shade(TOLERANCE, LookAgain::Openings, &lights, FEW, times, false);
        let (out, time) = shade(TOLERANCE, LookAgain::Openings, &lights, usize::MAX, times, true);
        let (culled, time_culled) = shade(TOLERANCE, LookAgain::Openings, &lights, usize::MAX, times, false);
        let (truth, _) = match count {
            400 => shade(0.4 * TOLERANCE, LookAgain::Openings, &lights, FEW, 1, false),
            _ => shade(0.1 * TOLERANCE, LookAgain::Everywhere, &lights, FEW, 1, false),
        };
        let unshadowed = unshadowed(&points, &scene, &lights);
        if one[0].is_nan() {
            one = [time, time_all];
        }
        let own = |x: &[Vec3]| errors(x, &truth, &truth);
        println!(
            "| {name} | {count} | {time:.0} | {:.1} | {time_culled:.0} | {time_all:.0} | {:.1} | {} | {} | {} | {} |",
            time / one[0],
            time_all / one[1],
            errors(&out, &truth, &unshadowed),
            own(&out),
            own(&culled),
            own(&all),
        );
    }
}

/// The radiance without blockers.
fn unshadowed(points: &ShadingPoints, scene: &Scene, lights: &[Light]) -> Vec<Vec3> {
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let frame = Frame::new(&scene.materials, lights, Accuracy::new(TOLERANCE));
    let _ = CpuShader::new(lobe_core::Unshadowed).shade_with(points, &frame, &mut out, &ShadeRequest::default());
    out
}

/// Mean, 99.9th percentile and largest difference, in % of a radiance that counts as a thousandth of white at least.
fn errors(out: &[Vec3], truth: &[Vec3], of: &[Vec3]) -> String {
    let mut white: Vec<f32> = truth.iter().map(|x| x.max_element()).filter(|x| *x > 0.0).collect();
    white.sort_by(f32::total_cmp);
    let least = 2e-3 * white[white.len() * 9 / 10];
    let differences = out.iter().zip(truth).zip(of).filter(|(_, of)| of.max_element() > 0.0);
    let mut all: Vec<f32> =
        differences.map(|((a, b), of)| 100.0 * (*a - *b).abs().max_element() / of.max_element().max(least)).collect();
    all.sort_by(f32::total_cmp);
    let mean = all.iter().map(|x| f64::from(*x)).sum::<f64>() / all.len() as f64;
    format!("{mean:.4}, {:.2}, {:.2}", all[(all.len() - 1) * 999 / 1000], all[all.len() - 1])
}

/// The bunny of this repository's scene.
fn bunny() -> Result<Scene, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/bunny.toml");
    let (mut scene, _, _) = scene_files::load_animated(path)?;
    scene.camera.vertical_fov = 30.0_f32.to_radians();
    scene.materials = vec![Material::lambert(Vec3::splat(0.5)); scene.materials.len()];
    Ok(scene)
}

/// Lamps above it, on a spiral.
fn lamps(count: usize) -> Vec<Light> {
    let lamp = |k: usize| {
        let (sin, cos) = (2.4 * k as f32 + 2.2).sin_cos();
        let aside = 0.8 + 5.0 * (((k * 17) % 50) as f32 / 50.0).sqrt();
        let center = Vec3::new(aside * cos, 3.0 + 2.0 * (0.618 * k as f32).fract(), aside * sin);
        SphereLight::new(Sphere { center, radius: 0.3 }, Vec3::splat(400.0 / count as f32)).into()
    };
    (0..count).map(lamp).collect()
}

/// Two rows of lamp posts, nearest ones first.
fn lanterns(count: usize) -> Vec<Light> {
    let lantern = |k: usize| {
        let center = place(k) + Vec3::new(0.0, 4.0, 0.0);
        SphereLight::new(Sphere { center, radius: 0.15 }, Vec3::new(60.0, 50.0, 35.0)).into()
    };
    (0..count).map(lantern).collect()
}

fn place(k: usize) -> Vec3 {
    let side = if k % 2 == 0 { -4.0 } else { 4.0 };
    let (row, back) = (k / 2, k % 4 / 2);
    let along = 6.0 * (row as f32 + 0.5 * (k % 2) as f32) - 60.0 * back as f32 * 0.0;
    Vec3::new(side, 0.0, 2.0 - along)
}

/// Houses, posts, benches and crates along a road.
fn street() -> Scene {
    let mut mesh = Mesh::default();
    for k in 0..400 {
        let at = place(k);
        mesh.append(&Mesh::cuboid(at + Vec3::Y * 1.9, Vec3::new(0.1, 3.8, 0.1)));
        if k % 2 == 0 {
            continue;
        }
        for (side, height) in [(-1.0, 5.0 + (k * 7 % 5) as f32), (1.0, 5.0 + (k * 11 % 6) as f32)] {
            let half = 0.5 * height;
            mesh.append(&Mesh::cuboid(Vec3::new(side * 10.0, half, at.z), Vec3::new(6.0, height, 5.0)));
            mesh.append(&Mesh::cuboid(Vec3::new(side * 5.5, 0.45, at.z + 1.5), Vec3::new(0.5, 0.1, 1.6)));
            for end in [-0.7, 0.7] {
                mesh.append(&Mesh::cuboid(Vec3::new(side * 5.5, 0.2, at.z + 1.5 + end), Vec3::new(0.4, 0.4, 0.06)));
            }
            mesh.append(&Mesh::cuboid(Vec3::new(side * 2.0, 0.5, at.z - 2.0), Vec3::new(1.4, 1.0, 2.8)));
        }
    }
    let floor = Mesh::quad(Vec3::new(0.0, 0.0, -600.0), Vec3::X * 60.0, Vec3::NEG_Z * 660.0);
    let object = |name: &str, mesh: Mesh| Object::mesh(name, mesh, 0, Proxy::None);
    Scene {
        camera: Camera {
            eye: Vec3::new(1.5, 3.0, 12.0),
            target: Vec3::new(0.0, 1.5, -8.0),
            up: Vec3::Y,
            vertical_fov: 0.8,
        },
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: vec![object("road", floor), object("street", mesh)],
        ..Scene::default()
    }
}
