//! Many lights: time and error against their number.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example many_lights [-- SCENE] [SIDE] [LIGHTS]` prints a table in Markdown: a bunny on a floor under
//! up to 50 lights, and a street of houses, benches and lamp posts under up to 400, SIDE × SIDE points (256), at most LIGHTS lights. For each number
//! three ways: all lights queried; faint ones added without a query (the default); and shadows interpolated as well. Times are of one thread's processor,
//! the least of three, and over that of one light. Errors are of the sum over all lights against the same picture at a tolerance of
//! 0.05 % (for 400 lights against all of them queried), in % of a pixel's own radiance where that is above a thousandth of white, and in parentheses of
//! its radiance without blockers: mean / 99.9 % / largest.

use brdf::Material;
use glam::Vec3;
use lighting::{Light, SphereLight};
use lobe_core::Sphere;
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, ShadeRequest, SurfaceHits, World};
use scene::{Camera, Frame, Mesh, Object, Projection, Proxy, Scene, ShadingPoints};
use shading::Accuracy;
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
    println!("| scene | points | lights | way | ms | × one | error |");
    println!("|---|---|---|---|---|---|---|");
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
    let shade = |tolerance: f32, again, lights: &[Light], (at_once, is_between): (usize, bool)| {
        let shader = shader(tolerance, again, is_between);
        let mut out = vec![Vec3::ZERO; points.receivers.len()];
        let mut part = out.clone();
        let start = clock();
        for lights in lights.chunks(at_once) {
            let frame = Frame::new(&scene.materials, lights, Accuracy::new(tolerance));
            let _ = shader.shade_with(&points, &frame, &mut part, &ShadeRequest::default());
            out.iter_mut().zip(&part).for_each(|(out, part)| *out += *part);
        }
        (out, (clock() - start) * 1e-6)
    };
    let mut one = [f64::NAN; 3];
    for &count in counts.iter().filter(|count| **count <= most as usize) {
        let lights = if name == "bunny" { lamps(count) } else { lanterns(count) };
        let again = LookAgain::Openings;
        let ways = [("all queried", FEW, false), ("default", usize::MAX, false), ("interpolated", usize::MAX, true)];
        let mut least = [f64::INFINITY; 3];
        let mut pictures = Default::default();
        for _ in 0..if count < 400 { 3 } else { 1 } {
            let made = ways.map(|(_, at_once, is_between)| shade(TOLERANCE, again, &lights, (at_once, is_between)));
            least = core::array::from_fn(|k| least[k].min(made[k].1));
            pictures = made.map(|(picture, _)| picture);
        }
        let truth = match count {
            400 => pictures[0].clone(),
            _ => shade(0.1 * TOLERANCE, LookAgain::Everywhere, &lights, (FEW, false)).0,
        };
        let clear = unshadowed(&points, &scene, &lights);
        for (k, (way, ..)) in ways.iter().enumerate() {
            let (time, out) = (least[k], &pictures[k]);
            if one[k].is_nan() {
                one[k] = time;
            }
            let [own, of_all] = [&truth, &clear].map(|of| errors(out, &truth, of));
            println!("| {name} | {side}² | {count} | {way} | {time:.0} | {:.1} | {own} ({of_all}) |", time / one[k]);
        }
    }
}

/// The radiance without blockers.
fn unshadowed(points: &ShadingPoints, scene: &Scene, lights: &[Light]) -> Vec<Vec3> {
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let frame = Frame::new(&scene.materials, lights, Accuracy::new(TOLERANCE));
    let _ = CpuShader::new(shading::Unshadowed).shade_with(points, &frame, &mut out, &ShadeRequest::default());
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
    format!("{mean:.3} / {:.2} / {:.2}", all[(all.len() - 1) * 999 / 1000], all[all.len() - 1])
}

/// The bunny of this repository's scene.
fn bunny() -> Result<Scene, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/bunny.toml");
    let (mut scene, _, _) = scene_files::load_animated(path)?;
    scene.camera.projection = Projection::perspective(30.0_f32.to_radians());
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

/// Where a lamp post stands: on either side of the road, one every three units.
fn place(k: usize) -> Vec3 {
    let side = if k.is_multiple_of(2) { -4.0 } else { 4.0 };
    Vec3::new(side, 0.0, 2.0 - 3.0 * k as f32)
}

/// Houses, posts, benches and crates along a road.
fn street() -> Scene {
    let mut mesh = Mesh::default();
    for k in 0..400 {
        let at = place(k);
        mesh.append(&Mesh::cuboid(at + Vec3::Y * 1.9, Vec3::new(0.1, 3.8, 0.1)));
        if k.is_multiple_of(2) {
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
            projection: Projection::perspective(0.8),
        },
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: vec![object("road", floor), object("street", mesh)],
        ..Scene::default()
    }
}
