//! Shadow rays against the truth in f64: the size of a floor does not matter to what stands on it.

mod truth;

use brdf::Material;
use core::f32::consts::{PI, TAU};
use glam::{Mat4, Quat, Vec3};
use lighting::SphereLight;
use lobe_core::{Receiver, Sphere};
use ray_tracing::{GBuffer, World};
use rayon::prelude::*;
use reference::{Geometry, RayShader, Reference, ReferenceJob};
use render_cpu::CpuShader;
use scene::{BlockerSet, Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, ShadingPoints, Shape};
use shading::{Accuracy, Visibility};
use std::collections::HashMap;
use std::sync::atomic::AtomicBool;
use truth::{Light, Truth};
use visibility_mask::MaskVisibility;
use visibility_rays::RayBlockers;
use visibility_spheres::SphereBlockers;

const FLOORS: [f32; 4] = [1.0, 8.0, 80.0, 1000.0];

/// A sphere with bumps, coarse enough that facets are seen at its terminator, and smooth normals.
fn bumpy() -> Mesh {
    let (rings, sides) = (28_u16, 56_u16);
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        let polar = PI * f32::from(i) / f32::from(rings);
        for k in 0..sides {
            let azimuth = TAU * f32::from(k) / f32::from(sides);
            let radius = 0.5 + 0.05 * (5.0 * azimuth).sin() * (7.0 * polar).sin();
            let (s, c) = polar.sin_cos();
            mesh.positions.push(Vec3::Y * 0.56 + radius * Vec3::new(s * azimuth.sin(), c, s * azimuth.cos()));
        }
    }
    let [rings, sides] = [rings, sides].map(u32::from);
    for i in 0..rings {
        for k in 0..sides {
            let [a, b] = [i * sides + k, i * sides + (k + 1) % sides];
            mesh.triangles.extend([[a, a + sides, b], [b, a + sides, b + sides]]);
        }
    }
    mesh.remove_degenerate();
    mesh.smooth_normals();
    mesh
}

/// A mesh on a floor of this half size, all of it turned.
fn scene(mut mesh: Mesh, half: f32, turn: Quat) -> Scene {
    let mut floor = Mesh::quad(Vec3::ZERO, Vec3::X * half, Vec3::NEG_Z * half);
    for mesh in [&mut floor, &mut mesh] {
        mesh.transform(&Mat4::from_quat(turn));
    }
    let light = Sphere { center: turn * Vec3::new(-3.2, 4.4, 2.2), radius: 0.6 };
    Scene {
        camera: Camera {
            eye: turn * Vec3::new(1.4, 1.5, 3.2),
            target: turn * Vec3::new(0.1, 0.45, 0.0),
            up: turn * Vec3::Y,
            projection: Projection::perspective(0.42),
        },
        width: 200,
        height: 150,
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::mesh("mesh", mesh, 0, Proxy::Count(64))],
        lights: vec![SphereLight::new(light, Vec3::ONE).into()],
        ..Scene::default()
    }
}

/// The visible fraction of the light that each point sees.
fn fractions<V: Visibility>(visibility: V, scene: &Scene, points: &ShadingPoints) -> Vec<f64> {
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.003));
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let (_, layers) = CpuShader::new(visibility).shade_layers(points, &frame, &mut out);
    let fraction = |(v, whole): (&Vec3, &Vec3)| f64::from(v.x) / f64::from(whole.x).max(1e-12);
    out.iter().zip(&layers.unshadowed).map(fraction).collect()
}

/// The truth of points that is known already.
#[derive(Default)]
struct Known(HashMap<[u32; 6], Light>);

impl Known {
    fn lights(&mut self, scene: &Scene, receivers: &[Receiver]) -> Vec<Light> {
        let truth = Truth::new(scene);
        let key = |at: &Receiver| {
            let ([x, y, z], [i, j, k]) = (at.position.to_array(), at.face.to_array());
            [x, y, z, i, j, k].map(f32::to_bits)
        };
        let new: Vec<_> = receivers.iter().filter(|at| !self.0.contains_key(&key(at))).collect();
        self.0.par_extend(
            new.par_iter().map(|at| (key(at), truth.light(at, scene.lights[0].sphere().expect("a sphere")))),
        );
        receivers.iter().map(|at| self.0[&key(at)]).collect()
    }
}

/// Errors of the visible fraction.
#[derive(Debug, Default)]
struct Errors {
    /// Sorted.
    penumbra: Vec<f64>,
    /// The most light where there is none, and the most that is missing where nothing hides any.
    umbra: f64,
    lit: f64,
    counts: [usize; 3],
    /// Points whose facet hides a part of the light that the shading normal does not.
    cut: usize,
}

impl Errors {
    fn of(lights: &[Light], fractions: &[f64]) -> Self {
        let most = lights.iter().map(|l| l.whole).fold(0.0, f64::max);
        let mut errors = Self::default();
        // A fraction of next to nothing says nothing.
        for (light, fraction) in lights.iter().zip(fractions).filter(|(l, _)| l.whole > 0.01 * most) {
            let want = light.visible / light.whole;
            let error = fraction - want;
            if want < 1e-6 {
                errors.umbra = errors.umbra.max(error);
                errors.counts[1] += 1;
            } else if want > 1.0 - 1e-6 {
                errors.lit = errors.lit.max(-error);
                errors.counts[2] += 1;
            } else if (0.01..=0.99).contains(&want) {
                errors.penumbra.push(error.abs());
                errors.counts[0] += 1;
                errors.cut += usize::from(light.is_cut);
            }
        }
        errors.penumbra.sort_by(f64::total_cmp);
        errors
    }

    fn quantile(&self, percent: usize) -> f64 {
        self.penumbra[(self.penumbra.len() * percent / 100).min(self.penumbra.len() - 1)]
    }
}

/// Points on the mesh and on the floor about it, the same ones whatever the floor's size.
fn points(world: &World<'_>) -> ShadingPoints {
    let scene = world.scene();
    let all = GBuffer::new(world, scene.width, scene.height, 1).points;
    let mut points = ShadingPoints::default();
    for (at, material) in all.receivers.iter().zip(&all.materials) {
        if at.object == 1 || at.position.length() < 1.0 {
            points.receivers.push(*at);
            points.materials.push(*material);
        }
    }
    points
}

fn check(name: &str, mesh: &Mesh, turn: Quat) {
    let (mut known, mut failures) = (Known::default(), Vec::new());
    for half in FLOORS {
        let scene = scene(mesh.clone(), half, turn);
        let world = World::new(&scene);
        let points = points(&world);
        let lights = known.lights(&scene, &points.receivers);
        let rays = RayBlockers::new(&world);
        let fractions = fractions(MaskVisibility::new(&rays), &scene, &points);
        let errors = Errors::of(&lights, &fractions);
        let [p99, worst, umbra, lit] = [errors.quantile(99), errors.quantile(100), errors.umbra, errors.lit];
        println!(
            "{name}, floor ±{half}: {:?} points in penumbra, umbra, light, {} cut by their facet; p99 {:.2} %, worst {:.2} %, \
             umbra {:.2} %, lit {:.2} %; {:.0} rays a penumbra point",
            errors.counts,
            errors.cut,
            100.0 * p99,
            100.0 * worst,
            100.0 * umbra,
            100.0 * lit,
            rays.rays() as f64 / errors.counts[0] as f64
        );
        assert!(errors.counts.iter().all(|n| *n > 800) && errors.cut > 100, "too few points to tell");
        if p99 > 0.006 || umbra > 0.001 || lit > 0.001 {
            failures.push(format!("±{half}: p99 {p99:.4}, umbra {umbra:.4}, lit {lit:.4}"));
        }
    }
    assert!(failures.is_empty(), "{name}: {failures:#?}");
}

#[test]
fn the_floor_under_a_bumpy_sphere() {
    check("bumpy sphere", &bumpy(), Quat::IDENTITY);
}

/// No plane of the floor is exact in f32.
#[test]
fn the_turned_floor_under_a_bumpy_sphere() {
    check("turned bumpy sphere", &bumpy(), Quat::from_xyzw(0.31, -0.22, 0.17, 0.91).normalize());
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn the_floor_under_the_armadillo() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/armadillo.toml");
    let scene = scene_files::load(path).expect("the armadillo");
    let Shape::Mesh(mesh) = &scene.objects[1].shape else { panic!("a mesh") };
    let mut mesh = mesh.clone();
    mesh.transform(&Mat4::from_scale(Vec3::splat(0.5)));
    check("armadillo", &mesh, Quat::IDENTITY);
}

/// The reference and the shader of plain rays: below the facet nothing is lit, whatever passes beside it.
#[test]
fn sampled_light_stops_at_the_facet() {
    let mut scene = scene(bumpy(), 80.0, Quat::IDENTITY);
    (scene.width, scene.height) = (100, 75);
    let world = World::new(&scene);
    let gbuffer = GBuffer::new(&world, 100, 75, 1);
    let lights = Known::default().lights(&scene, &gbuffer.points.receivers);
    let empty = BlockerSet::default();
    let job = ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &empty, geometry: Geometry::Mesh, seed: 1 };
    let mut reference = Reference::new(job);
    reference.advance(1024, &AtomicBool::new(false), &|_| {});
    let estimate = reference.estimate();
    let fraction = |(v, whole): (&Vec3, &Vec3)| f64::from(v.x) / f64::from(whole.x).max(1e-12);
    let sampled: Vec<_> = estimate.radiance.iter().zip(&estimate.unshadowed).map(fraction).collect();
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.003));
    for (name, culled) in [("reference", None), ("rays", Some(false)), ("culled rays", Some(true))] {
        let fractions = culled.map_or_else(
            || sampled.clone(),
            |culled| {
                let mut out = vec![Vec3::ZERO; gbuffer.len()];
                let Ok(_) = RayShader::surfaces(&world, 4096).culled(culled).shade(&gbuffer.points, &frame, &mut out);
                out.iter().zip(&estimate.unshadowed).map(fraction).collect()
            },
        );
        let errors = Errors::of(&lights, &fractions);
        let mean = errors.penumbra.iter().sum::<f64>() / errors.penumbra.len() as f64;
        let (p99, umbra) = (errors.quantile(99), errors.umbra);
        println!("{name}: mean {:.2} %, p99 {:.2} %, umbra {:.3} %", 100.0 * mean, 100.0 * p99, 100.0 * umbra);
        assert!(errors.cut > 60 && mean < 0.003 && p99 < 0.015 && umbra < 1e-6, "{name}");
    }
}

/// Spheres stand for a mesh, and that hides what is below a facet: the strategy, rays to the same spheres and the reference
/// of these agree.
#[test]
fn spheres_stop_at_the_facet() {
    let mut scene = scene(bumpy(), 8.0, Quat::IDENTITY);
    (scene.width, scene.height) = (100, 75);
    let world = World::new(&scene);
    let gbuffer = GBuffer::new(&world, 100, 75, 1);
    let sphere = Sphere { center: Vec3::Y * 0.56, radius: 0.44 };
    let set = BlockerSet { spheres: vec![sphere], objects: vec![1], ..BlockerSet::default() };
    let job = ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &set, geometry: Geometry::Spheres, seed: 1 };
    let mut reference = Reference::new(job);
    reference.advance(1024, &AtomicBool::new(false), &|_| {});
    let estimate = reference.estimate();
    let fraction = |(v, whole): (&Vec3, &Vec3)| f64::from(v.x) / f64::from(whole.x).max(1e-12);
    let want: Vec<_> = estimate.radiance.iter().zip(&estimate.unshadowed).map(fraction).collect();
    let spheres = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
    let lobes = fractions(MaskVisibility::new(spheres), &scene, &gbuffer.points);
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.003));
    let rays = [false, true].map(|culled| {
        let mut out = vec![Vec3::ZERO; gbuffer.len()];
        let Ok(_) = RayShader::spheres(&set, 4096).culled(culled).shade(&gbuffer.points, &frame, &mut out);
        out.iter().zip(&estimate.unshadowed).map(fraction).collect::<Vec<_>>()
    });
    let lights = Known::default().lights(&scene, &gbuffer.points.receivers);
    let most = lights.iter().map(|l| l.whole).fold(0.0, f64::max);
    let is_cut = |k: &usize| lights[*k].is_cut && lights[*k].whole > 0.01 * most;
    let cut: Vec<_> = (0..gbuffer.len()).filter(is_cut).collect();
    for (name, got) in [("lobes", &lobes), ("rays", &rays[0]), ("culled rays", &rays[1])] {
        let mean = cut.iter().map(|k| (got[*k] - want[*k]).abs()).sum::<f64>() / cut.len() as f64;
        println!("{name}: {} points cut by their facet, {:.2} % from the reference", cut.len(), 100.0 * mean);
        assert!(cut.len() > 60 && mean < 0.006, "{name}: {mean}");
    }
}
