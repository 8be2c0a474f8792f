//! Strategy × scene: error, time and memory of each visibility strategy, against Monte Carlo of the true mesh.
//!
//! `cargo run --release --example strategies [-- SPP [DIR [SCENE…]]]` prints a table in Markdown and writes a contact sheet
//! to DIR, `strategies.png`: one row a scene (reference, then each strategy), and below each strategy its signed difference
//! (red too bright, blue too dark, full colour from a tenth of the mean radiance on) with its mean error in penumbra.
//!
//! Errors are fractions of the unshadowed radiance over points in penumbra (the reference between 1 % and 99 % of it).
//! They are separate for points on objects that cast shadows ("object"; "terminator" where their facet's plane cuts a light or is turned
//! away from it, which smooth normals hide) and for all others ("floor"). `umbra`: light where there should be none; `lit`: mean
//! darkening where nothing blocks. For spheres, `proxy` is Monte Carlo of the spheres against that of the mesh, `lobes` the
//! strategy against Monte Carlo of the same spheres. Scenes whose meshes are missing are left out.

mod sheet;

use crate::sheet::{Cell, Sheet};
use cosine_lobes::brdf::Material;
use cosine_lobes::lighting::{Light, SphereLight};
use cosine_lobes::lobe_core::Sphere;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Estimate, Geometry, Reference, ReferenceJob};
use cosine_lobes::render_cpu::{CpuShader, SceneSilhouettes, SurfaceHits};
use cosine_lobes::scene::{
    BlockerSet, Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, Shape, Strategy, load_animated,
};
use cosine_lobes::shading::{Accuracy, DynVisibility, LightLobes, Unshadowed};
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_rays::RayBlockers;
use cosine_lobes::visibility_shadowmap::{MapOptions, ReceiverBounds, ShadowMap, ShadowMapBlockers};
use cosine_lobes::visibility_silhouettes::{SilhouetteBlockers, SilhouetteMesh};
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{Picture, luminance, signed_difference, srgb_bytes};
use glam::Vec3;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

const SIZE: (u32, u32) = (240, 135);
const TOLERANCE: f32 = 0.003;
/// The finest map that may be taken.
const TEXELS: u32 = 2048;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let samples = arguments.first().map_or(Ok(1024), |a| a.parse())?;
    let folder = Path::new(arguments.get(1).map_or(".", String::as_str));
    let wanted = |name: &str| arguments.len() < 3 || arguments[2..].iter().any(|a| a == name);
    println!(
        "| scene | strategy | on | points | mean % | p99 % | bias % | umbra % | lit % | proxy % | lobes % | ms | memory |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let names = Strategy::ALL.map(|s| s.name().to_owned());
    let mut sheet = Sheet::new(SIZE, [vec!["Monte Carlo of the mesh".to_owned()], names.to_vec()].concat());
    let files = ["soft_spheres", "bunny", "armadillo", "walk", "room"].map(|name| (name, from_file(name)));
    let mut built: Vec<_> = built().into_iter().map(|(name, scene)| (name, Ok(scene))).collect();
    let failures = built.split_off(2);
    for (name, scene) in built.into_iter().chain(files).chain(failures) {
        if !wanted(name) {
            continue;
        }
        match scene {
            Ok(scene) => measure(name, scene, samples, &mut sheet)?,
            Err(reason) => eprintln!("{name} is left out: {reason}"),
        }
    }
    sheet.write(&folder.join("strategies.png"))
}

/// A scene of this repository, half a second into its animation.
fn from_file(name: &str) -> Result<Scene, Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).with_extension("toml");
    let (mut scene, animation, _) = load_animated(path)?;
    if !animation.is_still() {
        animation.seek(0.5, &mut scene);
    }
    Ok(scene)
}

fn measure(name: &str, mut scene: Scene, samples: u32, sheet: &mut Sheet) -> Result<(), Box<dyn Error>> {
    (scene.width, scene.height) = SIZE;
    let scene = of_triangles(scene);
    let world = World::new(&scene);
    let points = GBuffer::new(&world, scene.width, scene.height, 1);
    let spheres = cosine_lobes::render_cpu::blockers(&scene, &mut |_, _| ControlFlow::Continue(()));
    let empty = BlockerSet::default();
    let set = spheres.as_ref().unwrap_or(&empty);
    let reference = |geometry| {
        let job = ReferenceJob { world: &world, gbuffer: &points, blockers: set, geometry, seed: 1 };
        let mut reference = Reference::new(job);
        reference.advance(samples, &AtomicBool::new(false), &|_| {});
        reference.estimate()
    };
    let truth = reference(Geometry::Mesh);
    let of_spheres = spheres.is_ok().then(|| reference(Geometry::Spheres));
    if let Err(reason) = &spheres {
        eprintln!("{name}: {reason}");
    }
    let picture = |values: &[Vec3]| Picture::new(SIZE.0 as usize, SIZE.1 as usize, points.resolve(values, Vec3::ZERO));
    let mean = truth.unshadowed.iter().map(|v| luminance(*v)).sum::<f64>() / truth.unshadowed.len().max(1) as f64;
    let exposure = (0.35 / mean.max(1e-9)).log2() as f32;
    let target = picture(&truth.radiance);
    let mut row = vec![Some(Cell { picture: srgb_bytes(&target, exposure), difference: None, note: String::new() })];

    let silhouettes = SceneSilhouettes::new(&scene, |_| true);
    for strategy in Strategy::ALL {
        if strategy == Strategy::Spheres && spheres.is_err() {
            println!("| {name} | {} | – | none of the meshes suits | | | | | | | | | |", strategy.name());
            row.push(None);
            continue;
        }
        let start = Instant::now();
        let (visibility, memory): (Box<dyn DynVisibility + '_>, String) = match strategy {
            Strategy::Spheres => {
                let blockers = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances)
                    .with_self_shadows(&set.self_shadows);
                let memory = format!("{:.1} kB", (set.spheres.len() * size_of::<Sphere>()) as f64 / 1e3);
                (Box::new(MaskVisibility::new(blockers)), memory)
            }
            Strategy::ShadowMap => {
                let maps = maps(&scene, &points)?;
                let megabytes = maps.iter().map(ShadowMap::bytes).sum::<usize>() as f64 / 1e6;
                let texels: Vec<String> = maps.iter().map(|m| m.resolution().to_string()).collect();
                let memory = format!("{megabytes:.1} MB ({}²)", texels.join(", "));
                let blockers = ShadowMapBlockers::new(maps).with_casters(vec![true; scene.objects.len()]);
                (Box::new(MaskVisibility::new(blockers)), memory)
            }
            Strategy::Silhouettes => {
                let memory = silhouettes.meshes().iter().map(SilhouetteMesh::bytes).sum::<usize>() as f64 / 1e6;
                let hits = SurfaceHits::new(&world, |_| true);
                let blockers = SilhouetteBlockers::new(silhouettes.meshes(), hits).with_tolerance(TOLERANCE);
                (Box::new(MaskVisibility::new(blockers)), format!("{memory:.1} MB"))
            }
            Strategy::Rays => {
                let memory = format!("{} triangles", world.triangle_count());
                (Box::new(MaskVisibility::new(RayBlockers::new(&world))), memory)
            }
            _ => (Box::new(Unshadowed), "0".into()),
        };
        let building = start.elapsed().as_secs_f64();
        let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(TOLERANCE));
        let mut shader = CpuShader::new(visibility);
        let mut radiance = vec![Vec3::ZERO; points.len()];
        let mut seconds: Vec<f64> = Vec::new();
        // The median of three, or one run if that takes two seconds.
        while seconds.len() < 3 && seconds.first().is_none_or(|s| *s < 2.0) {
            let start = Instant::now();
            shader.shade(&points.points, &frame, &mut radiance)?;
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        let time = match strategy {
            Strategy::ShadowMap => format!("{:.0} + {:.0} map", 1e3 * seconds[seconds.len() / 2], 1e3 * building),
            _ => format!("{:.0}", 1e3 * seconds[seconds.len() / 2]),
        };
        let split = of_spheres.as_ref().filter(|_| strategy == Strategy::Spheres);
        for part in Part::ALL {
            let chosen = |k: usize| Part::of(&scene, &points, k) == part;
            let errors = Errors::of(&radiance, &truth, chosen);
            if errors.penumbra.is_empty() {
                continue;
            }
            let (proxy, lobes) = split.map_or(("".into(), "".into()), |s| {
                let percent = |e: Errors| format!("{:.2}", 100.0 * e.mean());
                (percent(Errors::of(&s.radiance, &truth, chosen)), percent(Errors::of(&radiance, s, chosen)))
            });
            println!(
                "| {name} | {} | {} | {} | {} | {proxy} | {lobes} | {time} | {memory} |",
                strategy.name(),
                part.name(),
                errors.penumbra.len(),
                errors.print()
            );
        }
        let test = picture(&radiance);
        row.push(Some(Cell {
            picture: srgb_bytes(&test, exposure),
            difference: Some(signed_difference(&test, &target, 0.1 * mean)?),
            note: format!("{:.2} %", 100.0 * Errors::of(&radiance, &truth, |_| true).mean()),
        }));
    }
    sheet.push(name, row);
    Ok(())
}

/// Errors as fractions of the unshadowed radiance.
#[derive(Default)]
struct Errors {
    penumbra: Vec<f64>,
    bias: f64,
    umbra: (f64, usize),
    lit: (f64, usize),
}

impl Errors {
    fn of(test: &[Vec3], truth: &Estimate, chosen: impl Fn(usize) -> bool) -> Self {
        let mut errors = Self::default();
        let mean = truth.unshadowed.iter().map(|v| luminance(*v)).sum::<f64>() / truth.unshadowed.len().max(1) as f64;
        for (k, test) in test.iter().enumerate().filter(|(k, _)| chosen(*k)) {
            let whole = luminance(truth.unshadowed[k]);
            // Points that receive almost no light are left out: their relative error says nothing.
            if whole < 0.02 * mean {
                continue;
            }
            let (share, error) =
                (luminance(truth.radiance[k]) / whole, (luminance(*test) - luminance(truth.radiance[k])) / whole);
            if share < 0.01 {
                errors.umbra = (errors.umbra.0 + luminance(*test) / whole, errors.umbra.1 + 1);
            } else if share > 0.99 {
                errors.lit = (errors.lit.0 - error, errors.lit.1 + 1);
            } else {
                errors.penumbra.push(error.abs());
                errors.bias += error;
            }
        }
        errors.penumbra.sort_by(f64::total_cmp);
        errors
    }

    fn mean(&self) -> f64 {
        self.penumbra.iter().sum::<f64>() / self.penumbra.len().max(1) as f64
    }

    fn print(&self) -> String {
        let count = self.penumbra.len();
        let share = |(sum, count): (f64, usize)| 100.0 * sum / count.max(1) as f64;
        format!(
            "{:.2} | {:.1} | {:+.2} | {:.2} | {:.2}",
            100.0 * self.mean(),
            100.0 * self.penumbra[(count * 99).div_ceil(100) - 1],
            100.0 * self.bias / count as f64,
            share(self.umbra),
            share(self.lit)
        )
    }
}

/// The kind of a point's surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Floor,
    Object,
    Terminator,
}

impl Part {
    const ALL: [Self; 3] = [Self::Floor, Self::Object, Self::Terminator];

    fn of(scene: &Scene, points: &GBuffer, k: usize) -> Self {
        let at = &points.points.receivers[k];
        let whole = |l: &Light| {
            let bounds = l.bounds();
            points.points.receivers[k].face.dot(bounds.center - at.position) > bounds.radius
        };
        match scene.objects.get(at.object as usize) {
            Some(object) if !casts(object) => Self::Floor,
            _ if scene.lights.iter().all(whole) => Self::Object,
            _ => Self::Terminator,
        }
    }

    fn name(self) -> &'static str {
        ["floor", "object", "terminator"][self as usize]
    }
}

/// Whether an object casts a shadow: it has a proxy or a strategy.
fn casts(object: &Object) -> bool {
    object.proxy != Proxy::None || object.strategy.is_some_and(|s| s != Strategy::None)
}

/// A map for each light, fitted to the visible points.
fn maps(scene: &Scene, points: &GBuffer) -> Result<Vec<ShadowMap>, Box<dyn Error>> {
    let mut all = Mesh::default();
    for object in &scene.objects {
        if let Shape::Mesh(mesh) = &object.shape {
            all.append(mesh);
        }
    }
    let receivers = ReceiverBounds::of(points.points.receivers.iter().map(|r| r.position));
    let options = MapOptions { resolution: TEXELS, receivers, ..MapOptions::default() };
    let map = |l: &Light| ShadowMap::fitted(&all.positions, &all.triangles, l.bounds(), &options);
    Ok(scene.lights.iter().map(map).collect::<Result<_, _>>()?)
}

/// The same scene with its spheres as triangles, which a map can show; the spheres stay their proxies.
fn of_triangles(mut scene: Scene) -> Scene {
    for object in &mut scene.objects {
        if let Shape::Spheres(spheres) = &object.shape {
            let mut mesh = Mesh::default();
            spheres.iter().for_each(|b| mesh.append(&globe(*b)));
            object.shape = Shape::Mesh(mesh);
        }
    }
    scene
}

/// A sphere of 64 × 128 quadrilaterals that has the sphere's volume within 0.1 %.
fn globe(of: Sphere) -> Mesh {
    const N: u32 = 64;
    let mut mesh = Mesh::default();
    for j in 0..=N {
        for i in 0..2 * N {
            let angle = |k: u32| core::f32::consts::PI * k as f32 / N as f32;
            let ((sin, cos), (s, c)) = (angle(j).sin_cos(), angle(i).sin_cos());
            let out = Vec3::new(sin * c, cos, sin * s);
            mesh.positions.push(of.center + of.radius * out);
            mesh.normals.push(out);
            if j < N {
                let at = |i: u32, j: u32| j * 2 * N + i % (2 * N);
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[1]));
            }
        }
    }
    mesh.remove_degenerate();
    mesh
}

fn boxes(all: &[(Vec3, Vec3)]) -> Mesh {
    let mut mesh = Mesh::default();
    all.iter().for_each(|(center, size)| mesh.append(&Mesh::cuboid(*center, *size)));
    mesh
}

/// Scenes in code: one thing on a floor, one light. After the first two, cases in which strategies fail.
fn built() -> Vec<(&'static str, Scene)> {
    let light = |x: f32, y: f32, z: f32, radius: f32| Sphere { center: Vec3::new(x, y, z), radius };
    let one = |center, radius| {
        let sphere = Sphere { center, radius };
        Object::mesh("globe", globe(sphere), 1, Proxy::Spheres(vec![sphere]))
    };
    let mesh = |mesh, proxy| Object::mesh("object", mesh, 1, proxy);
    let fence = {
        let picket = |k: i16| (Vec3::new(-1.5 + 0.1 * f32::from(k), 0.5, 0.0), Vec3::new(0.05, 1.0, 0.02));
        let rail = |y| (Vec3::new(0.0, y, 0.02), Vec3::new(3.05, 0.06, 0.02));
        boxes(&(0..31).map(picket).chain([rail(0.3), rail(0.7)]).collect::<Vec<_>>())
    };
    let wires = boxes(&[-0.4, 0.0, 0.4].map(|x| (Vec3::new(x, 0.5, 0.0), Vec3::new(0.004, 1.0, 0.004))));
    let plates = boxes(&[0.35, 0.8].map(|y| (Vec3::new(0.0, y, 0.0), Vec3::new(0.7, 0.02, 0.7))));
    let posts: Vec<_> = (0..8)
        .map(|k| {
            let (sin, cos) = (core::f32::consts::TAU * f32::from(k as u8) / 8.0).sin_cos();
            (Vec3::new(0.6 * cos, 0.6, 0.6 * sin), Vec3::new(0.08, 1.2, 0.08))
        })
        .collect();
    let cube = boxes(&[(Vec3::Y * 0.3, Vec3::splat(0.6))]);
    let floor = |object: Object, light: Sphere| {
        let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 20.0, Vec3::NEG_Z * 20.0);
        Scene {
            camera: Camera {
                eye: Vec3::new(0.8, 2.4, 3.6),
                target: Vec3::Y * 0.2,
                up: Vec3::Y,
                projection: Projection::perspective(0.6),
            },
            width: SIZE.0,
            height: SIZE.1,
            materials: vec![Material::lambert(Vec3::splat(0.6)), Material::lambert(Vec3::new(0.7, 0.5, 0.3))],
            objects: vec![Object::mesh("floor", floor, 0, Proxy::None), object],
            lights: vec![SphereLight::new(light, Vec3::ONE).into()],
            ..Scene::default()
        }
    };
    vec![
        ("hard_sphere", floor(one(Vec3::Y * 0.6, 0.5), light(-2.0, 5.0, 1.5, 0.1))),
        ("fence", floor(mesh(fence, Proxy::Count(128)), light(-2.0, 4.0, 3.5, 0.5))),
        ("contact", floor(mesh(cube, Proxy::Count(64)), light(-2.0, 3.0, -2.0, 0.8))),
        ("thin_wires", floor(mesh(wires, Proxy::Count(48)), light(-2.0, 4.0, 1.0, 0.05))),
        ("light_inside_bounds", floor(mesh(boxes(&posts), Proxy::Count(96)), light(0.0, 0.7, 0.0, 0.1))),
        ("stacked_plates", floor(mesh(plates, Proxy::Count(64)), light(-1.0, 5.0, 0.8, 0.6))),
        ("grazing", floor(one(Vec3::new(-0.4, 0.3, 0.0), 0.3), light(-8.0, 0.5, 0.0, 0.4))),
        ("light_touches_blocker", floor(one(Vec3::Y * 0.6, 0.4), light(0.45, 1.25, 0.0, 0.45))),
        ("receiver_in_light", floor(one(Vec3::new(-0.7, 0.3, 0.0), 0.3), light(0.5, 0.1, 0.0, 0.4))),
    ]
}
