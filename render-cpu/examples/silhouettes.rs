//! The price of exact triangles: silhouettes beside shadow rays, per receiver and per frame.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example silhouettes [-- SCENE…]` prints a table in Markdown: meshes × light sizes × where receivers are.
//! Times are of one thread's processor: what the `coverage` of receivers in penumbra takes (tile work, frame of the light, mask,
//! one ray), and what all receivers take, lit and dark ones too. Meshes that are not there are left out.

use brdf::Material;
use glam::Vec3;
use lighting::{Light, SphereLight};
use lobe_core::{Lobe, Receiver, Sphere, Tile, cap_integral};
use render_cpu::{GBuffer, SceneSilhouettes, SurfaceHits, World};
use scene::{GROUP, Mesh, Scene, Shape};
use scene_files::load_animated;
use shading::{
    Accuracy, Coverage, LightCoverage, LightId, LightLobes, LightVisibility, Shaft, Visibility, VisibilityQuery,
};
use std::collections::HashMap;
use std::error::Error;
use std::path::Path;
use std::time::Instant;
use visibility_mask::{Blockers, MaskVisibility};
use visibility_rays::RayBlockers;
use visibility_silhouettes::{SilhouetteBlockers, SilhouetteMesh};

const SIZE: (u32, u32) = (480, 270);
const TOLERANCE: f32 = 0.005;
/// One tile in so many is measured with rays, which take long.
const SPARSE: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    println!(
        "| scene | triangles | light | on | receivers | silhouettes µs | rays µs | × less | all receivers | mean difference | build ms | refit ms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    for name in ["bunny", "bunny111k", "armadillo", "fence", "room", "walk", "tree"] {
        if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
            continue;
        }
        let scene = match name {
            "bunny111k" => file("bunny").map(|mut scene| {
                for object in &mut scene.objects {
                    match &mut object.shape {
                        Shape::Mesh(mesh) if mesh.triangles.len() > 1000 => *mesh = subdivided(&subdivided(mesh)),
                        _ => {}
                    }
                }
                scene
            }),
            "fence" => Ok(fence()),
            "tree" => Ok(tree()),
            name => file(name),
        };
        match scene {
            Ok(scene) => {
                for degrees in [1.0_f32, 6.0, 15.0] {
                    measure(name, scene.clone(), degrees);
                }
            }
            Err(reason) => eprintln!("{name} is left out: {reason}"),
        }
    }
    Ok(())
}

/// A scene of this repository, half a second into its animation.
fn file(name: &str) -> Result<Scene, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name).with_extension("toml");
    let (mut scene, animation, _) = load_animated(path)?;
    if !animation.is_still() {
        animation.seek(0.5, &mut scene);
    }
    Ok(scene)
}

/// Nanoseconds that this thread has run.
fn clock() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|n| n.parse().ok()).unwrap_or_default()
}

fn measure(name: &str, mut scene: Scene, degrees: f32) {
    (scene.width, scene.height) = SIZE;
    scene.lights.truncate(1);
    // Spheres, as of a lamp, are not for this table.
    scene.objects.retain(|o| matches!(o.shape, Shape::Mesh(_)));
    let Some(light) = scene.lights.first_mut().and_then(Light::as_sphere_mut) else { return };
    light.sphere.radius = degrees.to_radians().sin() * light.sphere.center.distance(scene.camera.target);
    let light = *light;
    let world = World::new(&scene);
    let start = Instant::now();
    let mut silhouettes = SceneSilhouettes::new(&scene, |_| true);
    let build = start.elapsed().as_secs_f64();
    let start = Instant::now();
    silhouettes.refit(&scene);
    let refit = start.elapsed().as_secs_f64();
    let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
    let hits = SurfaceHits::new(&world, |_| true);
    let exact = MaskVisibility::new(SilhouetteBlockers::new(silhouettes.meshes(), hits).with_tolerance(TOLERANCE));
    let rays = MaskVisibility::new(RayBlockers::new(&world));
    let groups: Vec<&[Receiver]> = points.receivers.chunks(GROUP).collect();
    let is_mesh = |r: &Receiver| match &scene.objects[r.object as usize].shape {
        Shape::Mesh(mesh) => mesh.triangles.len() > 12 || name == "room",
        _ => false,
    };
    let all = time(&exact, &groups, &light);
    let triangles: usize = silhouettes.meshes().iter().map(SilhouetteMesh::triangle_count).sum();
    for (on, wanted) in [("floor", false), ("mesh", true)] {
        // Tiles of receivers in penumbra alone.
        let partly = |group: &&[Receiver]| -> Vec<Receiver> {
            let mut scratch = exact.scratch();
            let chosen = group.iter().filter(|r| is_mesh(r) == wanted);
            chosen.filter(|at| look(&exact, at, &light, &mut scratch).is_some()).copied().collect()
        };
        let tiles: Vec<Vec<Receiver>> = groups.iter().map(partly).filter(|tile| tile.len() >= 8).collect();
        let tiles: Vec<&[Receiver]> = tiles.iter().map(Vec::as_slice).collect();
        if tiles.len() < 5 {
            continue;
        }
        let few: Vec<&[Receiver]> = tiles.iter().step_by(tiles.len().div_ceil(200 / SPARSE)).copied().collect();
        // Side by side, the least of three.
        let least = |times: [f64; 2]| times.into_iter().fold(f64::INFINITY, f64::min);
        let one = least([(); 2].map(|()| time(&exact, &tiles, &light)));
        let [a, b] =
            [least([(); 2].map(|()| time(&exact, &few, &light))), least([(); 2].map(|()| time(&rays, &few, &light)))];
        let count: usize = tiles.iter().map(|t| t.len()).sum();
        let difference = |at: &Receiver| {
            let [p, q] = [look(&exact, at, &light, &mut exact.scratch()), look(&rays, at, &light, &mut rays.scratch())];
            Some(f64::from((p? - q?).abs()))
        };
        let differences: Vec<f64> = few.iter().flat_map(|tile| tile.iter()).filter_map(difference).collect();
        println!(
            "| {name} | {triangles} | {degrees}° | {on} | {count} | {:.2} | {:.0} | {:.0} | {:.2} µs | {:.2} % | {:.0} | {:.1} |",
            one,
            b,
            b / a,
            all,
            100.0 * differences.iter().sum::<f64>() / differences.len().max(1) as f64,
            1e3 * build,
            1e3 * refit,
        );
    }
}

/// Microseconds a receiver.
fn time<B: Blockers>(visibility: &MaskVisibility<B>, tiles: &[&[Receiver]], light: &SphereLight) -> f64 {
    let (mut scratch, mut bounds) = (visibility.scratch(), Tile::default());
    let start = clock();
    let (mut count, mut spent) = (0, 0.0);
    // The clock has steps of some milliseconds.
    while spent < 6e7 {
        for tile in tiles {
            bounds.set(tile);
            let (sphere, half_extent) = bounds.bounds();
            let shaft = Shaft::new(sphere, light.sphere, LightId(0)).in_box(half_extent);
            let entered = visibility.enter(&shaft, &mut scratch);
            count += tile.len();
            if entered == Coverage::Lit {
                continue;
            }
            for at in *tile {
                let cone = light.cone(at);
                let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(TOLERANCE));
                core::hint::black_box(visibility.coverage(&query, &mut scratch));
            }
        }
        spent = clock() - start;
    }
    spent / 1e3 / count.max(1) as f64
}

/// The visible fraction of the light for a receiver in penumbra, by a Lambert lobe.
fn look<B: Blockers>(
    visibility: &MaskVisibility<B>,
    at: &Receiver,
    light: &SphereLight,
    scratch: &mut <MaskVisibility<B> as Visibility>::Scratch,
) -> Option<f32> {
    let cone = light.cone(at);
    let mut visit = LightVisibility::alone(visibility, LightId(0), Accuracy::new(TOLERANCE), scratch);
    let LightCoverage::Partial(seen) = visit.coverage(at, &cone, None) else { return None };
    let lobe = Lobe::new(at.normal, 1.0, Vec3::ONE);
    let fraction = visit.fraction(&seen, lobe, cap_integral(at, lobe, &cone)).x;
    (0.01..0.99).contains(&fraction).then_some(fraction)
}

/// Loop's scheme without its smoothing: each triangle becomes four, new corners are moved a little along the normals of a lumpy
/// field, so that neighbours are not in one plane.
fn subdivided(mesh: &Mesh) -> Mesh {
    let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
    let mut out = Mesh { positions: mesh.positions.clone(), ..Mesh::default() };
    for t in &mesh.triangles {
        let m = [0, 1, 2].map(|k| {
            let [a, b] = [t[k], t[(k + 1) % 3]];
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let [p, q] = [a, b].map(|i| mesh.positions[i as usize]);
                let [m, n] = [a, b].map(|i| mesh.normals.get(i as usize).copied().unwrap_or(Vec3::ZERO));
                // A round way between the two normals.
                let lift = 0.25 * 0.5 * (q - p).dot(m - n);
                out.positions.push(0.5 * (p + q) + (m + n).normalize_or_zero() * lift.clamp(-0.1, 0.1) * 0.5);
                out.positions.len() as u32 - 1
            })
        });
        out.triangles.extend([[t[0], m[0], m[2]], [m[0], t[1], m[1]], [m[2], m[1], t[2]], m]);
    }
    out.smooth_normals();
    out
}

/// Thirty pickets and five rails over a floor.
fn fence() -> Scene {
    let mut mesh = Mesh::default();
    for k in 0..30 {
        mesh.append(&Mesh::cuboid(Vec3::new(0.12 * k as f32 - 1.74, 0.4, 0.0), Vec3::new(0.07, 0.8, 0.02)));
    }
    for k in 0..5 {
        mesh.append(&Mesh::cuboid(Vec3::new(0.0, 0.1 + 0.15 * k as f32, -0.03), Vec3::new(3.6, 0.03, 0.02)));
    }
    over_floor(mesh, Vec3::new(1.0, 3.0, -3.0))
}

/// A trunk and 900 leaves of two triangles each.
fn tree() -> Scene {
    let mut mesh = Mesh::cuboid(Vec3::Y * 0.5, Vec3::new(0.08, 1.0, 0.08));
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    };
    for _ in 0..900 {
        let at = Vec3::new(random(), random(), random()).normalize_or_zero() * 0.5 * (0.4 + 0.6 * (random() + 0.5))
            + Vec3::Y * 1.2;
        let u = Vec3::new(random(), random(), random()).normalize_or_zero() * 0.04;
        let v = u.cross(Vec3::new(random(), random(), random())).normalize_or_zero() * 0.025;
        mesh.append(&Mesh::quad(at, u, v));
    }
    over_floor(mesh, Vec3::new(2.0, 4.0, 1.5))
}

fn over_floor(mesh: Mesh, light: Vec3) -> Scene {
    use scene::{Camera, Object, Projection, Proxy};
    let mut floor = Mesh::quad(Vec3::ZERO, Vec3::X * 4.0, Vec3::NEG_Z * 4.0);
    floor.remove_degenerate();
    Scene {
        camera: Camera {
            eye: Vec3::new(0.5, 1.8, 4.0),
            target: Vec3::Y * 0.4,
            up: Vec3::Y,
            projection: Projection::perspective(0.7),
        },
        width: SIZE.0,
        height: SIZE.1,
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::mesh("mesh", mesh, 0, Proxy::Count(64))],
        lights: vec![SphereLight::new(Sphere { center: light, radius: 0.3 }, Vec3::ONE).into()],
        ..Scene::default()
    }
}
