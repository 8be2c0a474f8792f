//! Errors of an object's shadows on itself by its sphere set, against shadow rays on its mesh.
//!
//! `cargo run --release --example self_shadow [-- COUNTS MESH…]`, counts as `16,64`. Receivers spread evenly over the
//! mesh, where they face a light of half-angle 6° wholly; six lights around and above. V is the lit fraction of the light's
//! disc. Two rules: one distance τ for the set, and a near radius and a distance for each sphere
//! ([`SphereSet::self_shadows`](cosine_lobes::sphere_sets::SphereSet)).

use cosine_lobes::lobe_core::{Cone, Receiver, Sphere};
use cosine_lobes::render_cpu::World;
use cosine_lobes::scene::{self, Mesh, Object, Proxy, Shape};
use cosine_lobes::shading::{Accuracy, Coverage, LightId, VisibilityQuery};
use cosine_lobes::sphere_sets::{BuildOptions, SphereSet};
use cosine_lobes::visibility_mask::{Blockers, Mask, UnitSquare};
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;
use rayon::prelude::*;
use std::time::Instant;

/// Receivers for each light, and rays across the light's disc.
const RECEIVERS: usize = 1000;
const ACROSS: usize = 14;
const LIGHTS: usize = 6;
const HALF_ANGLE: f32 = 6.0;

struct Group {
    light: Sphere,
    receivers: Vec<Receiver>,
    /// Lit fractions by shadow rays.
    truth: Vec<f32>,
}

/// The number `i` of a sequence that fills the unit cube evenly.
fn spread(i: usize) -> [f32; 3] {
    [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|step: f64| (0.5 + (i + 1) as f64 * step).fract() as f32)
}

fn main() {
    let mut args = std::env::args().skip(1);
    let counts = args.next().unwrap_or_else(|| "16,32,64,128".into());
    let counts: Vec<usize> = counts.split(',').map(|n| n.parse().expect("counts as 16,64")).collect();
    let mut files: Vec<String> = args.collect();
    if files.is_empty() {
        let assets = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/assets/");
        files = ["meshes/bunny.obj", "meshes/armadillo.obj", "gltf/RiggedFigure.glb"]
            .map(|f| format!("{assets}{f}"))
            .into();
    }
    for file in files {
        measure(&file, &counts);
    }
}

fn measure(file: &str, counts: &[usize]) {
    let mut scene = scene::load(file).unwrap_or_else(|e| panic!("{e}"));
    // All that is not the floor which loading adds.
    let mut mesh = Mesh::default();
    for object in scene.objects.iter().filter(|o| o.name != "floor") {
        if let Shape::Mesh(part) = &object.shape {
            mesh.append(&Mesh { normals: Vec::new(), ..part.clone() });
        }
    }
    scene.objects = vec![Object::mesh("mesh", mesh.clone(), 0, Proxy::None)];
    scene.lights.clear();
    let world = World::new(&scene);
    let groups: Vec<Group> = (0..LIGHTS).map(|k| group(&world, &mesh, k)).collect();
    println!("{file}: {} triangles", mesh.triangles.len());
    println!(
        "                         |dV| %   bias   p99  dark/white freckles % | leak in the dark  darkening of lit"
    );
    for &count in counts {
        let start = Instant::now();
        let set = SphereSet::build(&mesh.positions, &mesh.triangles, &BuildOptions::new(count));
        let set = set.unwrap_or_else(|e| panic!("{e}"));
        let seconds = start.elapsed().as_secs_f32();
        let one = SphereBlockers::new(&set.spheres, &vec![0; set.spheres.len()], &[set.self_distance]);
        report(&format!("{count:4} one distance"), &groups, &one);
        report(&format!("{count:4} for each sphere"), &groups, &one.with_self_shadows(&set.self_shadows));
        println!("     built in {seconds:.1} s, silhouette error {:.4}", set.quality.silhouette_error);
    }
}

fn group(world: &World<'_>, mesh: &Mesh, number: usize) -> Group {
    let bounds = mesh.bounds();
    let (low, high) = (bounds.min, bounds.max);
    let extent = (high - low).length();
    let height = (number as f32 + 0.5) / LIGHTS as f32;
    let (side, turn) = ((1.0 - height * height).sqrt(), 2.4 * number as f32);
    let direction = Vec3::new(side * turn.cos(), height, side * turn.sin());
    let light = Sphere {
        center: 0.5 * (low + high) + direction * 4.0 * extent,
        radius: 4.0 * extent * HALF_ANGLE.to_radians().sin(),
    };
    let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
    let mut total = 0.0;
    let upto: Vec<f64> = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = corners(t);
            total += f64::from((b - a).cross(c - a).length());
            total
        })
        .collect();
    let facing = (0..).filter_map(|i| {
        let [x, y, z] = spread(i);
        let t = upto.partition_point(|sum| *sum < f64::from(x) * total).min(upto.len() - 1);
        let [a, b, c] = corners(&mesh.triangles[t]);
        let s = y.sqrt();
        let position = a * (1.0 - s) + b * (s * (1.0 - z)) + c * (s * z);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let cone = Cone::of_sphere(position, light);
        let above = normal.dot(cone.axis) > cone.sin_sq().sqrt();
        above.then_some(Receiver::on_surface(position, normal, normal).on_object(0))
    });
    let receivers: Vec<Receiver> = facing.take(RECEIVERS).collect();
    let truth = receivers.par_iter().map(|at| {
        let cone = Cone::of_sphere(at.position, light);
        let (u, v) = cone.axis.any_orthonormal_pair();
        let place = |k: usize| 2.0 * (k as f32 + 0.5) / ACROSS as f32 - 1.0;
        let (mut lit, mut all) = (0, 0);
        for (i, j) in (0..ACROSS * ACROSS).map(|k| (k % ACROSS, k / ACROSS)) {
            let (x, y) = (place(i), place(j));
            if x * x + y * y < 1.0 {
                let toward = (cone.axis + (u * x + v * y) * cone.tan()).normalize();
                all += 1;
                lit += i32::from(!world.occluded(world.leave(at.position, at.normal), toward, cone.distance));
            }
        }
        lit as f32 / all as f32
    });
    let truth = truth.collect();
    Group { light, receivers, truth }
}

/// Lit fraction of the light's disc.
fn share(blockers: &SphereBlockers, at: &Receiver, light: Sphere) -> f32 {
    let cone = Cone::of_sphere(at.position, light);
    let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003));
    let mut scratch = blockers.scratch();
    match blockers.select(&query, &mut scratch) {
        Coverage::Lit => 1.0,
        Coverage::Dark => 0.0,
        Coverage::Partial => {
            let mut mask = Mask::default();
            mask.reset(&UnitSquare::facing(&cone, blockers.across(&query, &scratch)), 5, at.normal);
            blockers.splat(&query, &mut scratch, &mut mask);
            let (all, lit) = mask.areas();
            lit / all
        }
    }
}

fn report(name: &str, groups: &[Group], blockers: &SphereBlockers) {
    let (mut errors, mut dark, mut lit, mut freckles) = (Vec::new(), Vec::new(), Vec::new(), [0.0_f32; 2]);
    for group in groups {
        let shares: Vec<f32> = group.receivers.par_iter().map(|at| share(blockers, at, group.light)).collect();
        for (i, (v, truth)) in shares.iter().zip(&group.truth).enumerate() {
            errors.push(v - truth);
            if *truth < 0.01 {
                dark.push(*v);
            } else if *truth > 0.99 {
                lit.push(1.0 - v);
            }
            if (v - truth).abs() > 0.3 {
                // A freckle differs from its neighbours as well.
                let from = group.receivers[i].position;
                let mut near: Vec<usize> = (0..shares.len()).filter(|j| *j != i).collect();
                let far = |j: usize| group.receivers[j].position.distance_squared(from);
                near.select_nth_unstable_by(7, |a, b| far(*a).total_cmp(&far(*b)));
                let mut near: Vec<f32> = near[..8].iter().map(|j| shares[*j]).collect();
                near.sort_by(f32::total_cmp);
                let median = 0.5 * (near[3] + near[4]);
                freckles[0] += f32::from(u8::from(*v < truth - 0.3 && *v < median - 0.3));
                freckles[1] += f32::from(u8::from(*v > truth + 0.3 && *v > median + 0.3));
            }
        }
    }
    let mean = |list: &[f32]| 100.0 * list.iter().sum::<f32>() / list.len().max(1) as f32;
    let n = errors.len() as f32;
    let bias = mean(&errors);
    let mut sizes: Vec<f32> = errors.iter().map(|e| e.abs()).collect();
    sizes.sort_by(f32::total_cmp);
    println!(
        "{name:22}  {:6.2} {bias:+7.2} {:5.0} {:8.2} /{:5.2} {:>20.1} {:>17.2}",
        mean(&sizes),
        100.0 * sizes[(0.99 * n) as usize],
        100.0 * freckles[0] / n,
        100.0 * freckles[1] / n,
        mean(&dark),
        mean(&lit),
    );
}
