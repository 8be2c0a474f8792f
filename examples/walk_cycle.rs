//! Accuracy of sphere sets that follow bones, over a cycle of an animation: 24 moments of a clip, with the set fitted
//! once at the first moment and posed, beside a set that is fitted anew at each moment, both against the deformed triangles.
//! Then the change of a point's radiance from frame to frame, in finer and finer steps, to find jumps.
//!
//! `cargo run --release --example walk_cycle [-- FILE CLIP [SPHERES]]` prints tables in Markdown; without arguments the fox
//! and the tentacle of `scenes/assets`. Light of half-angle 6°, mask of depth 5, a floor of 96 × 96 points.

use cosine_lobes::lobe_core::Receiver;
use cosine_lobes::render_cpu::{CpuShader, SceneSpheres, SphereSource, World, blockers};
use cosine_lobes::scene::{self, Animation, BlockerSet, Frame, Proxy, Scene, ShadingPoints, Shape};
use cosine_lobes::shading::{Accuracy, Visibility};
use cosine_lobes::sphere_sets::SphereSet;
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_rays::RayBlockers;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;
use std::error::Error;
use std::ops::ControlFlow;
use std::time::Instant;

const MOMENTS: usize = 24;
/// Moments from one set that is fitted anew to the next.
const EVERY: usize = 4;
const FLOOR: usize = 96;
const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/assets/");

type Fallible<T> = Result<T, Box<dyn Error>>;

fn main() -> Fallible<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match &args[..] {
        [] => {
            study(&format!("{ASSETS}fox.glb"), "Walk", 64)?;
            study(&format!("{ASSETS}fox.glb"), "Walk", 128)?;
            study(&format!("{ASSETS}tentacle.glb"), "wave", 32)
        }
        [file, clip] => study(file, clip, 64),
        [file, clip, count] => study(file, clip, count.parse()?),
        _ => Err("expected nothing or FILE CLIP [SPHERES]".into()),
    }
}

/// The mesh of object 1; object 0 is the floor.
fn mesh(scene: &Scene) -> &scene::Mesh {
    match &scene.objects[1].shape {
        Shape::Mesh(mesh) => mesh,
        Shape::Instances(_) | Shape::Spheres(_) => unreachable!("a mesh file gives meshes"),
    }
}

fn study(file: &str, clip: &str, count: usize) -> Fallible<()> {
    let (mut scene, animation, _) = scene::load_clip(file, clip)?;
    scene.objects[1].proxy = Proxy::Count(count);
    let mut go_on = |_: &str, _| ControlFlow::Continue(());
    let spheres = SceneSpheres::new(&scene, Some(&animation), |_| SphereSource::Proxy, &mut go_on)?;
    let name = file.rsplit('/').next().unwrap_or(file);
    println!("\n{name}, {clip}, {count} spheres, {:.3} s", animation.duration());
    println!("\n| moment | silhouette, posed | silhouette, fitted anew | floor, posed | floor, fitted anew |");
    println!("|---|---|---|---|---|");

    let mut set = BlockerSet::default();
    let (mut silhouettes, mut floors) = (Errors::default(), Errors::default());
    let mut pose_seconds = 0.0;
    for moment in 0..MOMENTS {
        let time = animation.duration() * moment as f32 / MOMENTS as f32;
        animation.seek(time, &mut scene);
        let start = Instant::now();
        spheres.pose(&scene, Some((&animation, time)), &mut set)?;
        pose_seconds += start.elapsed().as_secs_f64();
        let points = floor(&scene);
        let world = World::new(&scene);
        let truth = visible(&scene, &points, MaskVisibility::new(RayBlockers::new(&world).only(|o| o > 0)))?;
        let posed = errors(&scene, &points, &truth, &set)?;
        silhouettes.posed.push(posed.0);
        floors.posed.push(posed.1);
        if moment % EVERY == 0 {
            let anew = errors(&scene, &points, &truth, &blockers(&scene, &mut go_on)?)?;
            silhouettes.anew.push(anew.0);
            floors.anew.push(anew.1);
            let [a, b, c, d] = [posed.0, anew.0, posed.1, anew.1].map(|e| 100.0 * e);
            println!("| {moment} | {a:.2} % | {b:.2} % | {c:.2} % | {d:.2} % |");
        }
    }
    println!(
        "| mean of all {MOMENTS} | {} | {} | {} | {} |",
        silhouettes.mean().0,
        silhouettes.mean().1,
        floors.mean().0,
        floors.mean().1
    );
    println!(
        "| worst | {} | {} | {} | {} |",
        silhouettes.worst().0,
        silhouettes.worst().1,
        floors.worst().0,
        floors.worst().1
    );
    println!("\nPosing takes {:.1} µs.\n", 1e6 * pose_seconds / MOMENTS as f64);
    pops(&mut scene, &animation, &spheres)
}

/// Errors of all moments, of posed and of new sets.
#[derive(Default)]
struct Errors {
    posed: Vec<f64>,
    anew: Vec<f64>,
}

impl Errors {
    fn mean(&self) -> (String, String) {
        let mean = |v: &[f64]| format!("{:.2} %", 100.0 * v.iter().sum::<f64>() / v.len() as f64);
        (mean(&self.posed), mean(&self.anew))
    }

    fn worst(&self) -> (String, String) {
        let worst = |v: &[f64]| format!("{:.2} %", 100.0 * v.iter().copied().fold(0.0, f64::max));
        (worst(&self.posed), worst(&self.anew))
    }
}

/// Silhouette error (mean over 64 directions of the area that differs over the mesh's) and floor error (mean |ΔV| where
/// the mesh casts umbra or penumbra).
fn errors(scene: &Scene, points: &ShadingPoints, truth: &[f32], set: &BlockerSet) -> Fallible<(f64, f64)> {
    let mesh = mesh(scene);
    let quality = SphereSet::measure(&mesh.positions, &mesh.triangles, &set.spheres)?.quality;
    let shadowed = truth.iter().filter(|v| **v < 0.995).count().max(1);
    let got = visible(scene, points, by_spheres(set))?;
    let difference: f64 = truth.iter().zip(&got).map(|(a, b)| f64::from((a - b).abs())).sum();
    Ok((f64::from(quality.silhouette_error), difference / shadowed as f64))
}

fn by_spheres(set: &BlockerSet) -> MaskVisibility<SphereBlockers> {
    let spheres = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
    MaskVisibility::new(spheres.with_self_shadows(&set.self_shadows))
}

/// A square of the floor that holds the shadow.
fn floor(scene: &Scene) -> ShadingPoints {
    let bounds = scene.objects[1].shape.bounds();
    let (light, ground) = (scene.lights[0].sphere().unwrap_or_default().center, scene.objects[0].shape.bounds().max.y);
    // The light's centre projects the corners of the box to these points of the floor.
    let mut region = scene::Bounds::EMPTY;
    for i in 0..8 {
        let corner = Vec3::from_array([0, 1, 2].map(|k| if i >> k & 1 == 0 { bounds.min[k] } else { bounds.max[k] }));
        region = region.with_point(corner + (corner - light) * ((corner.y - ground) / (light.y - corner.y)));
    }
    let (middle, half) = (region.center(), 0.6 * region.size().max_element());
    let at = |i: usize| half * (2.0 * (i as f32 + 0.5) / FLOOR as f32 - 1.0);
    let receiver = |(x, z)| {
        let position = Vec3::new(middle.x + x, ground, middle.z + z);
        Receiver::on_surface(position, Vec3::Y, Vec3::Y).on_object(0)
    };
    let receivers: Vec<_> = (0..FLOOR).flat_map(|z| (0..FLOOR).map(move |x| (at(x), at(z)))).map(receiver).collect();
    ShadingPoints { materials: vec![1; receivers.len()], receivers, ..ShadingPoints::default() }
}

/// The mesh's own vertices, as receivers that go with it.
fn skin(scene: &Scene) -> ShadingPoints {
    let mesh = mesh(scene);
    let vertex = |(p, n): (&Vec3, &Vec3)| Receiver::on_surface(*p, *n, *n).on_object(1);
    let receivers: Vec<_> = mesh.positions.iter().zip(&mesh.normals).map(vertex).collect();
    ShadingPoints { materials: vec![1; receivers.len()], receivers, ..ShadingPoints::default() }
}

/// V of each point, weighted with the cosine: its radiance as a diffuse surface over that without blockers.
fn visible<V: Visibility>(scene: &Scene, points: &ShadingPoints, visibility: V) -> Fallible<Vec<f32>> {
    let share = |(lit, all): (&f32, &f32)| if *all > 0.0 { lit / all } else { 0.0 };
    let (lit, all) = shade(scene, points, visibility)?;
    Ok(lit.iter().zip(&all).map(share).collect())
}

/// The red radiance of each point, and that without blockers.
fn shade<V: Visibility>(scene: &Scene, points: &ShadingPoints, visibility: V) -> Fallible<(Vec<f32>, Vec<f32>)> {
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.003));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let (_, layers) = CpuShader::new(visibility).shade_layers(points, &frame, &mut out);
    Ok((out.iter().map(|l| l.x).collect(), layers.unshadowed.iter().map(|l| l.x).collect()))
}

/// The largest change of a point's radiance in a step of one frame, of 1/8, and of 1/64 and 1/512 where the step before
/// changes most, as a fraction of the brightest point's without blockers. Smooth motion divides it by 8 each time, once a step
/// is shorter than the penumbra is wide; a jump stays. Distances below 0 are inside a sphere.
fn pops(scene: &mut Scene, animation: &Animation, spheres: &SceneSpheres) -> Fallible<()> {
    println!(
        "| points | largest change in a frame | in 1/8 frame | in 1/64, there | in 1/512, there | from the nearest sphere |"
    );
    println!("|---|---|---|---|---|---|");
    animation.seek(0.0, scene);
    let ground = floor(scene);
    for (name, moving) in [("floor", false), ("skin", true)] {
        let mut at = |time: f32| -> Fallible<Vec<f32>> {
            animation.seek(time, scene);
            let mut set = BlockerSet::default();
            spheres.pose(scene, Some((animation, time)), &mut set)?;
            let points = if moving { skin(scene) } else { ground.clone() };
            let (mut lit, all) = shade(scene, &points, by_spheres(&set))?;
            let brightest = all.iter().copied().fold(0.0, f32::max);
            lit.iter_mut().for_each(|l| *l /= brightest);
            Ok(lit)
        };
        let step = animation.duration() / MOMENTS as f32;
        let mut steps = |from: f32, step: f32, count: usize| -> Fallible<(f32, f32, usize)> {
            let mut before = at(from)?;
            let mut worst = (0.0_f32, from, 0);
            for i in 1..=count {
                let start = from + step * (i - 1) as f32;
                let now = at(start + step)?;
                for (point, (a, b)) in before.iter().zip(&now).enumerate() {
                    if (a - b).abs() > worst.0 {
                        worst = ((a - b).abs(), start, point);
                    }
                }
                before = now;
            }
            Ok(worst)
        };
        // A clip starts again after its last key, where its pose may jump: not past that.
        let (frame, ..) = steps(0.0, step, MOMENTS)?;
        let (eighth, worst, _) = steps(0.0, step / 8.0, 8 * MOMENTS)?;
        let (fine, finest, _) = steps(worst, step / 64.0, 8)?;
        let (last, moment, point) = steps(finest, step / 512.0, 8)?;
        animation.seek(moment, scene);
        let mut set = BlockerSet::default();
        spheres.pose(scene, Some((animation, moment)), &mut set)?;
        let place = if moving { skin(scene) } else { ground.clone() }.receivers[point].position;
        let far = set.spheres.iter().map(|s| place.distance(s.center) - s.radius).fold(f32::INFINITY, f32::min);
        let far = far / scene.objects[1].shape.bounds().radius();
        let [a, b, c, d] = [frame, eighth, fine, last].map(|v| 100.0 * v);
        println!("| {name} | {a:.1} % | {b:.2} % | {c:.2} % | {d:.2} % | {far:.4} of the mesh's radius |");
    }
    Ok(())
}
