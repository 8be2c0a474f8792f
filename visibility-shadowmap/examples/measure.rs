//! Errors of the shadow map against shadow rays on the mesh, by light size and resolution.
//!
//! `cargo run --release -p cosine-lobes-visibility-shadowmap --example measure [MESH.obj [RESOLUTION…]]`; without a mesh two stacked
//! plates, a picket fence and, where it is present, a bunny.
//!
//! A light four diagonals away; receivers on a floor under the object and on the object itself. `pen`, `p99`: mean and 99th
//! percentile of |ΔV| over receivers with 1 % < V < 99 %, in percent of the light; `bias`: their mean ΔV (positive: too light);
//! `umbra`: mean V of receivers that see less than 1 %; `lit`: mean darkening of receivers that see more than 99 %; `contact`: mean
//! ΔV within 0.03 diagonals of the object; `w`: width of the light in texels at the nearest blocker.

use glam::{Vec3, Vec3A};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Receiver, Sphere};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;
use shading::{Accuracy, Coverage, LightId, Shaft, VisibilityQuery};
use std::time::Instant;
use visibility_mask::{Blockers, Mask, UnitSquare};
use visibility_shadowmap::{MapOptions, ReceiverBounds, ShadowMap, ShadowMapBlockers, ShadowMapScratch};

struct Mesh {
    name: String,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    elevation: f32,
}

fn boxes(name: &str, elevation: f32, boxes: &[(Vec3, Vec3)]) -> Mesh {
    let mut mesh = Mesh { name: name.into(), positions: Vec::new(), triangles: Vec::new(), elevation };
    for (low, high) in boxes {
        let first = mesh.positions.len() as u32;
        mesh.positions
            .extend((0..8).map(|k| Vec3::select(glam::BVec3::new(k & 1 == 1, k & 2 == 2, k & 4 == 4), *high, *low)));
        for [a, b, c, d] in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            mesh.triangles.extend([[first + a, first + b, first + c], [first + a, first + c, first + d]]);
        }
    }
    mesh
}

fn load(path: &std::path::Path) -> Option<Mesh> {
    let (models, _) = tobj::load_obj(path, &tobj::GPU_LOAD_OPTIONS).ok()?;
    let name = path.file_stem()?.to_string_lossy().into_owned();
    let mut mesh = Mesh { name, positions: Vec::new(), triangles: Vec::new(), elevation: 50.0 };
    for model in models {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(model.mesh.positions.chunks_exact(3).map(Vec3::from_slice));
        mesh.triangles.extend(model.mesh.indices.chunks_exact(3).map(|t| [first + t[0], first + t[1], first + t[2]]));
    }
    Some(mesh)
}

struct Rays {
    bvh: CwBvh,
    triangles: Vec<Triangle>,
}

impl Rays {
    fn new(mesh: &Mesh) -> Self {
        let corner = |v: u32| Vec3A::from(mesh.positions[v as usize]);
        let all: Vec<_> =
            mesh.triangles.iter().map(|t| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) }).collect();
        let bvh = build_cwbvh_from_tris(&all, BvhBuildParams::medium_build(), &mut core::time::Duration::default());
        let triangles = bvh.primitive_indices.iter().map(|i| all[*i as usize]).collect();
        Self { bvh, triangles }
    }

    fn blocked(&self, from: Vec3, direction: Vec3, near: f32, far: f32) -> bool {
        let ray = Ray::new(from.into(), direction.into(), near, far);
        !self.bvh.ray_traverse_miss(ray, |r, i| self.triangles[i].intersect(r))
    }
}

/// The visible fraction of the disc, from 64 × 64 rays.
fn truth(rays: &Rays, at: &Receiver, light: Sphere, epsilon: f32) -> f32 {
    let cone = Cone::of_sphere(at.position, light);
    let square = UnitSquare::facing(&cone, Vec3::ZERO);
    let (mut all, mut seen) = (0, 0);
    for k in 0..64 * 64 {
        let at_cell = |k: usize| ((k as f32 + 0.5) / 32.0 - 1.0) * square.half.x;
        let (x, y) = (at_cell(k % 64), at_cell(k / 64));
        let direction = square.world(Vec3::new(x, y, 1.0)).normalize();
        if x * x + y * y <= square.disc * square.disc && direction.dot(at.normal) > 0.0 {
            all += 1;
            let origin = at.position + at.normal * epsilon;
            // The distance along the ray to the light's surface.
            let along = cone.distance * cone.axis.dot(direction);
            let off_sq = (cone.distance * cone.axis - direction * along).length_squared();
            let far = along - (light.radius * light.radius - off_sq).max(0.0).sqrt();
            seen += u32::from(!rays.blocked(origin, direction, 0.0, far));
        }
    }
    seen as f32 / (all as f32).max(1.0)
}

#[derive(Default)]
struct Errors {
    penumbra: Vec<f32>,
    bias: f64,
    umbra: (f64, u32),
    lit: (f64, u32),
    contact: (f64, u32),
}

impl Errors {
    fn add(&mut self, truth: f32, value: f32, contact: bool) {
        let error = value - truth;
        if truth > 0.01 && truth < 0.99 {
            self.penumbra.push(error.abs());
            self.bias += f64::from(error);
        } else if truth <= 0.01 {
            self.umbra = (self.umbra.0 + f64::from(value), self.umbra.1 + 1);
        } else {
            self.lit = (self.lit.0 - f64::from(error), self.lit.1 + 1);
        }
        if contact {
            self.contact = (self.contact.0 + f64::from(error), self.contact.1 + 1);
        }
    }

    fn print(&mut self) -> String {
        self.penumbra.sort_by(f32::total_cmp);
        let n = self.penumbra.len().max(1);
        let mean = 100.0 * self.penumbra.iter().map(|e| f64::from(*e)).sum::<f64>() / n as f64;
        let p99 = 100.0 * self.penumbra.get(n * 99 / 100).copied().unwrap_or(0.0);
        let of = |(sum, n): (f64, u32)| 100.0 * sum / f64::from(n.max(1));
        format!(
            "{mean:5.2} {p99:5.1} {:+5.2} {:5.2} {:5.2} {:+5.2}",
            100.0 * self.bias / n as f64,
            of(self.umbra),
            of(self.lit),
            of(self.contact)
        )
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let resolutions: Vec<u32> = arguments.iter().skip(1).filter_map(|a| a.parse().ok()).collect();
    let resolutions = if resolutions.is_empty() { vec![256, 512, 1024] } else { resolutions };
    let fence = |k: i16| {
        let x = -1.5 + 3.0 * f32::from(k) / 30.0;
        (Vec3::new(x - 0.025, 0.0, -0.01), Vec3::new(x + 0.025, 1.0, 0.01))
    };
    let plate = |y: f32| (Vec3::new(-0.35, y - 0.01, -0.35), Vec3::new(0.35, y + 0.01, 0.35));
    let mut pickets: Vec<_> = (0..31).map(fence).collect();
    pickets.extend([0.3, 0.7].map(|y| (Vec3::new(-1.525, y - 0.03, 0.01), Vec3::new(1.525, y + 0.03, 0.03))));
    let bunny = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets/meshes/bunny.obj");
    let mut meshes = Vec::new();
    match arguments.first().map(String::as_str) {
        Some("plates") => meshes.push(boxes("plates", 65.0, &[plate(0.35), plate(0.8)])),
        Some("fence") => meshes.push(boxes("fence", 40.0, &pickets)),
        Some("bunny") => meshes.extend(load(bunny.as_ref())),
        Some(path) => match load(path.as_ref()) {
            Some(mesh) => meshes.push(mesh),
            None => eprintln!("{path}: no such mesh"),
        },
        None => {
            meshes.push(boxes("plates", 65.0, &[plate(0.35), plate(0.8)]));
            meshes.push(boxes("fence", 40.0, &pickets));
            meshes.extend(load(bunny.as_ref()));
        }
    }
    println!(
        "{:>8} {:>5} {:>5} {:>5} {:>6} {:>5} | pen   p99   bias  umbra lit   contact | nodes lit/pen, quads, µs | build ms, MB, layers",
        "mesh", "on", "light", "texel", "layers", "w"
    );
    for mesh in &meshes {
        measure(mesh, &resolutions);
    }
}

/// The places on the floor around an object's shadow.
fn on_floor(shadow: Vec3, diagonal: f32) -> Vec<Receiver> {
    let side = 44;
    let receiver = |k: usize| {
        let at = |k: usize| (k as f32 + 0.5) / side as f32 * 2.0 - 1.0;
        let position = Vec3::new(shadow.x + at(k % side) * diagonal, shadow.y, shadow.z + at(k / side) * diagonal);
        Receiver::on_surface(position, Vec3::Y, Vec3::Y).on_object(0)
    };
    (0..side * side).map(receiver).collect()
}

/// Random places on an object, even by area.
fn on_mesh(mesh: &Mesh) -> Vec<Receiver> {
    let mut random = Random::new(1);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a)
    };
    let mut sums = Vec::with_capacity(mesh.triangles.len());
    let total = mesh.triangles.iter().fold(0.0_f64, |sum, t| {
        sums.push(sum + f64::from(area(t).length()));
        sum + f64::from(area(t).length())
    });
    let mut receiver = || {
        let pick = random.uniform() * total;
        let t = mesh.triangles[sums.partition_point(|s| *s < pick).min(sums.len() - 1)];
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let (mut u, mut v) = (random.uniform() as f32, random.uniform() as f32);
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let normal = area(&t).normalize();
        Receiver::on_surface(a + (b - a) * u + (c - a) * v, normal, normal).on_object(0)
    };
    (0..3000).map(|_| receiver()).collect()
}

/// A receiver that sees all of the light above its horizon, the visible fraction by rays, and whether something is near.
struct Chosen<'a> {
    at: &'a Receiver,
    truth: f32,
    is_contact: bool,
}

fn choose<'a>(rays: &Rays, receivers: &'a [Receiver], is_floor: bool, light: Sphere, diagonal: f32) -> Vec<Chosen<'a>> {
    let chosen = |at: &'a Receiver| {
        let cone = Cone::of_sphere(at.position, light);
        let whole = at.normal.dot(cone.axis) > cone.sin_sq().sqrt();
        let hidden = is_floor && rays.blocked(at.position, Vec3::Y, -1e-4 * diagonal, 0.005 * diagonal);
        let is_contact = (0..48).any(|k| {
            let (y, a) = ((k as f32 + 0.5) / 48.0, k as f32 * 2.4);
            let r = (1.0 - y * y).sqrt();
            let direction = Vec3::new(r * a.cos(), y, r * a.sin());
            rays.blocked(at.position, direction, 1e-4 * diagonal, 0.03 * diagonal)
        });
        (whole && !hidden).then(|| Chosen { at, truth: truth(rays, at, light, 2e-6 * diagonal), is_contact })
    };
    receivers.iter().filter_map(chosen).collect()
}

fn measure(mesh: &Mesh, resolutions: &[u32]) {
    let Some(bounds) = ReceiverBounds::of(mesh.positions.iter().copied()) else { return };
    let (center, diagonal) = (0.5 * (bounds.min + bounds.max), (bounds.max - bounds.min).length());
    let (sin, cos) = mesh.elevation.to_radians().sin_cos();
    let direction = Vec3::new(0.6 * cos, sin, 0.8 * cos);
    let rays = Rays::new(mesh);
    let mut shadow = center - direction * ((center.y - bounds.min.y) / sin);
    shadow.y = bounds.min.y;
    let (on_floor, on_mesh) = (on_floor(shadow, diagonal), on_mesh(mesh));
    for degrees in [1.0_f32, 6.0, 15.0] {
        let radius = 4.0 * diagonal * degrees.to_radians().sin();
        let light = Sphere { center: center + direction * (4.0 * diagonal), radius };
        for (name, receivers) in [("floor", &on_floor), ("self", &on_mesh)] {
            let chosen = choose(&rays, receivers, name == "floor", light, diagonal);
            let used = ReceiverBounds::of(receivers.iter().map(|r| r.position));
            for &resolution in resolutions {
                for layers in if resolution == 512 && name == "floor" { 1..=4 } else { 4..=4 } {
                    let options = MapOptions { resolution, layers, receivers: used };
                    match row(mesh, light, &options, &chosen) {
                        Ok(row) => {
                            println!("{:>8} {name:>5} {degrees:>4}° {resolution:>5} {layers:>6} {row}", mesh.name)
                        }
                        Err(error) => return eprintln!("{error}"),
                    }
                }
            }
        }
    }
}

/// The errors and costs of one map, as the rest of a row.
fn row(mesh: &Mesh, light: Sphere, options: &MapOptions, chosen: &[Chosen<'_>]) -> Result<String, String> {
    let start = Instant::now();
    let map = ShadowMap::build(&mesh.positions, &mesh.triangles, light, options).map_err(|error| error.to_string())?;
    let build = start.elapsed().as_secs_f64() * 1e3;
    let (bytes, count) = (map.bytes(), map.layers());
    let width = options.receivers.map_or(0.0, |b| map.advice(&b).shaft_texels);
    let blockers = ShadowMapBlockers::new(vec![map]);
    let (mut scratch, mut mask, mut errors) = (blockers.scratch(), Mask::default(), Errors::default());
    let (mut lit, mut pen, mut quads, mut time) = ((0, 0), (0, 0), 0, 0.0);
    for Chosen { at, truth, is_contact } in chosen {
        let cone = Cone::of_sphere(at.position, light);
        let sphere = Sphere { center: at.position, radius: 0.0 };
        blockers.enter(&Shaft::new(sphere, light, LightId(0)), &mut scratch);
        let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003));
        let before = scratch.counts();
        let mut run = |scratch: &mut ShadowMapScratch| {
            if blockers.select(&query, scratch) == Coverage::Partial {
                let square = UnitSquare::facing(&cone, blockers.across(&query, scratch));
                mask.reset(&square, 5, at.normal);
                blockers.splat(&query, scratch, &mut mask);
                let (all, seen) = mask.areas();
                seen / all
            } else {
                1.0
            }
        };
        let value = run(&mut scratch);
        let after = scratch.counts();
        // The fastest of five runs, since other work on the machine disturbs the time.
        let seconds = (0..5).map(|_| {
            let start = Instant::now();
            std::hint::black_box(run(&mut scratch));
            start.elapsed().as_secs_f64()
        });
        let seconds = seconds.fold(f64::INFINITY, f64::min);
        if value < 1.0 {
            time += seconds;
            pen = (pen.0 + after.0 - before.0, pen.1 + 1);
            quads += after.1 - before.1;
        } else {
            lit = (lit.0 + after.0 - before.0, lit.1 + 1);
        }
        errors.add(*truth, value, *is_contact);
    }
    Ok(format!(
        "{width:>5.0} | {} | {:4} {:5} {:5} {:6.1} | {build:6.0} {:5.1} {count}",
        errors.print(),
        lit.0 / lit.1.max(1),
        pen.0 / pen.1.max(1),
        quads / pen.1.max(1),
        1e6 * time / pen.1.max(1) as f64,
        bytes as f64 / 1e6
    ))
}
