//! Every kind of light against Monte Carlo of its true shape: error, and cost beside a sphere's. Makes docs/lights.md:
//!
//! `cargo run --release --example lights [-- SPP] > docs/lights.md`

use core::convert::Infallible;
use cosine_lobes::brdf::{Material, MetallicRoughness, ModifiedPhong};
use cosine_lobes::lighting::{
    Environment, EnvironmentMap, FlatLight, Light, SphereLight, SpotLight, SunLight, TubeLight,
};
use cosine_lobes::lobe_core::{LightImage, Sphere};
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Estimate, Geometry, Reference, ReferenceJob};
use cosine_lobes::render_cpu::{CpuShader, SceneSilhouettes, SurfaceHits};
use cosine_lobes::scene::{BlockerSet, Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, ShadingPoints};
use cosine_lobes::shading::Accuracy;
use cosine_lobes::visibility_mask::{MaskVisibility, Mixture};
use cosine_lobes::visibility_rays::RayBlockers;
use cosine_lobes::visibility_silhouettes::SilhouetteBlockers;
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{Picture, ShadowErrors};
use glam::{Quat, UVec2, Vec3};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const WIDTH: u32 = 160;
const HEIGHT: u32 = 100;
/// Of the picture that a square shows, and of the sky's.
const SIZE: UVec2 = UVec2::splat(128);
const SKY: UVec2 = UVec2::new(512, 256);
/// Lights of different kinds give about this irradiance below them.
const IRRADIANCE: f32 = 2.0;

/// The place of the lights; the blockers are below.
const ABOVE: Vec3 = Vec3::new(-0.2, 2.2, -0.6);

/// A row of the tables.
struct Kind {
    name: &'static str,
    lights: Vec<Light>,
    environment: Option<Arc<Environment>>,
}

fn kinds() -> Vec<Kind> {
    let down = Vec3::new(0.15, -1.0, 0.35).normalize();
    let (u, v) = down.any_orthonormal_pair();
    let height = ABOVE.y;
    // L = E h²/A of a small light.
    let of_area = |area: f32| Vec3::splat(IRRADIANCE * height * height / area);
    let flat = |light: Result<FlatLight, _>| {
        light.map(|light| {
            let radiance = of_area(light.area());
            light.with_radiance(radiance)
        })
    };
    let corners = [0.0, 0.17, 0.41, 0.69, 0.85].map(|turn: f32| {
        let (sin, cos) = (turn * core::f32::consts::TAU).sin_cos();
        ABOVE + (u * cos + v * sin) * 0.6
    });
    let tube = TubeLight { ends: [ABOVE - Vec3::X * 0.6, ABOVE + Vec3::X * 0.6], radius: 0.04, radiance: Vec3::ZERO };
    let world = Sphere { center: Vec3::ZERO, radius: 6.0 };
    let body = Sphere { center: ABOVE, radius: 0.4 };
    let sphere = SphereLight::new(body, of_area(core::f32::consts::PI * 0.16));
    let mut all: Vec<(&str, Option<Light>)> = vec![
        ("sphere, radius 0.4", Some(sphere.into())),
        ("disc, radius 0.5", flat(FlatLight::disc(ABOVE, down, 0.5, Vec3::ONE)).ok().map(Light::from)),
        ("square, 1 × 1", flat(FlatLight::rectangle(ABOVE, u * 0.5, v * 0.5, Vec3::ONE)).ok().map(Light::from)),
        ("rectangle, 2 × 0.2", flat(FlatLight::rectangle(ABOVE, u, v * 0.1, Vec3::ONE)).ok().map(Light::from)),
        ("polygon, 5 corners", flat(FlatLight::polygon(&corners, Vec3::ONE)).ok().map(Light::from)),
        ("tube, 1.2 × 0.08", Some(TubeLight { radiance: of_area(1.2 * 0.08), ..tube }.into())),
        ("sun, 0.53°", Some(SunLight::new(-down, 0.265, Vec3::splat(IRRADIANCE), world).into())),
        ("sun, 6°", Some(SunLight::new(-down, 3.0, Vec3::splat(IRRADIANCE), world).into())),
    ];
    let small = SphereLight::with_intensity(Sphere { radius: 0.1, ..body }, Vec3::splat(IRRADIANCE * height * height));
    all.push((
        "spot, radius 0.1",
        Some(SpotLight { light: small, axis: down, cos: [0.9, 0.75], range: f32::INFINITY }.into()),
    ));
    let screen =
        FlatLight::rectangle(ABOVE, u * 0.5, v * 0.5, Vec3::ONE).map(|light| light.with_radiance(of_area(1.0)));
    let shown = LightImage::new(SIZE, &waves()).map(|(image, _)| Arc::new(image));
    all.push((
        "square that shows an image",
        screen.ok().zip(shown).and_then(|(s, image)| s.showing(image)).map(Light::from),
    ));
    let one = |light| Kind { name: "", lights: vec![light], environment: None };
    let mut kinds: Vec<Kind> =
        all.into_iter().filter_map(|(name, light)| light.map(|light| Kind { name, ..one(light) })).collect();
    // The same waves with a glow around all, dark below, and a sun of 3°.
    let toward = -down;
    for (name, across, sun) in [("sky, 6 patches", 1, 0.0), ("sky, 24 patches", 2, 0.0), ("sky and sun", 2, 300.0)] {
        let Ok(blank) = EnvironmentMap::new(SKY, vec![Vec3::ZERO; (SKY.x * SKY.y) as usize]) else { continue };
        let texels = (0..SKY.x * SKY.y).map(|k| {
            let d = blank.direction((k % SKY.x) as f32 + 0.5, (k / SKY.x) as f32 + 0.5);
            let above = if d.y > 0.0 { 1.0 } else { 0.2 };
            let glow = ((d.dot(toward) - 1.0) * 30.0).exp();
            let sun = if d.dot(toward) > 1.5_f32.to_radians().cos() { sun } else { 0.0 };
            Vec3::new(0.3, 0.45, 0.7) * above * (0.5 + 0.5 * d.y) + Vec3::splat(2.0 * glow + sun)
        });
        if let Ok(map) = EnvironmentMap::new(SKY, texels.collect()) {
            let environment = Arc::new(Environment::new(map, across, world));
            kinds.push(Kind { name, lights: environment.lights().to_vec(), environment: Some(environment) });
        }
    }
    kinds
}

/// Waves of other lengths in each channel.
fn waves() -> Vec<Vec3> {
    (0..SIZE.x * SIZE.y)
        .map(|k| {
            let [x, y] = [k % SIZE.x, k / SIZE.x].map(|k| (k as f32 + 0.5) / SIZE.x as f32 * core::f32::consts::TAU);
            Vec3::new(1.0 + x.sin(), 1.0 + (2.0 * y).sin(), 1.0 - x.sin() * y.cos())
        })
        .collect()
}

/// The paper's rectangle (its Fig. 19): nine spheres of the frontal area and the power of the square.
fn nine_spheres() -> Option<Kind> {
    let square = kinds().into_iter().find(|kind| kind.name.starts_with("square"))?;
    let Some(Light::Flat(square)) = square.lights.first() else { return None };
    let [a, b, _, d] = square.corners() else { return None };
    let radius = (square.area() / (9.0 * core::f32::consts::PI)).sqrt();
    let at = |k: usize| *a + (*b - *a) * ((k % 3) as f32 + 0.5) / 3.0 + (*d - *a) * ((k / 3) as f32 + 0.5) / 3.0;
    let light = |k| SphereLight::new(Sphere { center: at(k), radius }, square.radiance).into();
    Some(Kind { name: "nine spheres for the square", lights: (0..9).map(light).collect(), environment: None })
}

fn materials() -> Vec<(&'static str, Material)> {
    let phong = ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.4), exponent: 50.0 };
    let mut all = vec![("Lambert", Material::lambert(Vec3::splat(0.6))), ("modified Phong, 50", phong.into())];
    if let Ok(metal) = MetallicRoughness::new(Vec3::new(0.9, 0.7, 0.4), 1.0, 0.3) {
        all.push(("GGX metal, roughness 0.3", metal.into()));
    }
    all
}

/// A floor and a wall with a table, slats and spheres.
fn scene(material: &Material, kind: &Kind, blocks: Blocks) -> Scene {
    let cuboid = |name: &str, center: Vec3, half: Vec3, turn: f32| {
        let mut mesh = Mesh::cuboid(Vec3::ZERO, half);
        let turn = Quat::from_rotation_y(turn);
        mesh.positions.iter_mut().for_each(|p| *p = turn * *p + center);
        mesh.normals.iter_mut().for_each(|n| *n = turn * *n);
        Object::mesh(name, mesh, 0, Proxy::None)
    };
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 5.0, Vec3::NEG_Z * 5.0);
    let wall = Mesh::quad(Vec3::new(0.0, 2.0, -1.6), Vec3::X * 5.0, Vec3::Y * 2.0);
    let mut objects = vec![
        Object::mesh("floor", floor, 0, Proxy::None),
        Object::mesh("wall", wall, 0, Proxy::None),
        cuboid("table", Vec3::new(0.6, 0.7, -0.5), Vec3::new(0.6, 0.03, 0.4), 0.0),
        cuboid("leg", Vec3::new(0.6, 0.335, -0.5), Vec3::new(0.05, 0.335, 0.05), 0.3),
        cuboid("crate", Vec3::new(-1.0, 0.35, -0.6), Vec3::splat(0.35), 0.5),
    ];
    for k in 0..4 {
        let x = -0.55 + 0.22 * k as f32;
        objects.push(cuboid("slat", Vec3::new(x, 0.4, 0.55), Vec3::new(0.04, 0.4, 0.015), 0.0));
    }
    let on_floor = |x: f32, z: f32, radius: f32| Sphere { center: Vec3::new(x, radius, z), radius };
    let mut spheres = vec![on_floor(0.75, 0.5, 0.25), on_floor(0.35, 0.85, 0.12)];
    if blocks == Blocks::Spheres {
        // The floor stays. A row of them, and a heap of them that touch.
        objects.truncate(1);
        spheres.extend((0..8).map(|k| on_floor(-1.2 + 0.25 * k as f32, 0.3, 0.09)));
        for k in 0..12 {
            let (sin, cos) = (0.9 * k as f32).sin_cos();
            let center = Vec3::new(-0.8 + 0.3 * cos, 0.2 + 0.06 * k as f32, -0.6 + 0.3 * sin);
            spheres.push(Sphere { center, radius: 0.2 });
        }
    }
    objects.push(Object::spheres("spheres", spheres, 0));
    Scene {
        camera: Camera {
            eye: Vec3::new(0.4, 1.6, 3.2),
            target: Vec3::new(0.0, 0.4, 0.0),
            up: Vec3::Y,
            projection: Projection::perspective(0.9),
        },
        width: WIDTH,
        height: HEIGHT,
        environment: kind.environment.clone(),
        materials: vec![material.clone()],
        objects,
        lights: kind.lights.clone(),
        ..Scene::default()
    }
}

/// The blockers of a scene.
#[derive(Clone, Copy, PartialEq)]
enum Blocks {
    /// Furniture, and two spheres.
    All,
    /// Spheres alone.
    Spheres,
}

/// A scene with its points and its true light.
struct Case {
    scene: Scene,
    truth: Estimate,
}

#[derive(Clone, Copy, PartialEq)]
enum Strategy {
    Silhouettes,
    Spheres,
    Rays,
}

impl Case {
    fn new(material: &Material, kind: &Kind, blocks: Blocks, samples: u32) -> Self {
        let scene = scene(material, kind, blocks);
        let world = World::new(&scene);
        let gbuffer = GBuffer::new(&world, scene.width, scene.height, 1);
        let blockers = BlockerSet::default();
        let job =
            ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed: 1 };
        let mut reference = Reference::new(job);
        reference.advance(samples, &AtomicBool::new(false), &|_| {});
        Self { truth: reference.estimate(), scene }
    }

    /// Shades those points that a choice keeps; radiance, and seconds times threads of the fastest of some runs.
    fn shade(&self, strategy: Strategy, tolerance: f32, keep: impl Fn(usize) -> bool, runs: u32) -> (Vec<Vec3>, f64) {
        let scene = &self.scene;
        let world = World::new(scene);
        let all = GBuffer::new(&world, scene.width, scene.height, 1).points;
        let chosen: Vec<usize> = (0..all.receivers.len()).filter(|k| keep(*k)).collect();
        let points = ShadingPoints {
            receivers: chosen.iter().map(|k| all.receivers[*k]).collect(),
            materials: chosen.iter().map(|k| all.materials[*k]).collect(),
            ..ShadingPoints::default()
        };
        let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(tolerance));
        let list: Vec<Sphere> = scene.objects.iter().filter_map(|o| as_spheres(&o.proxy)).flatten().copied().collect();
        let of = vec![scene.objects.len() as u32 - 1; list.len()];
        let spheres = SphereBlockers::new(&list, &of, &vec![1e-4; scene.objects.len()]);
        let mut silhouettes = SceneSilhouettes::new(scene, |_| true);
        silhouettes.refit(scene);
        let hits = SurfaceHits::new(&world, |o| o as usize + 1 < scene.objects.len());
        let meshes = SilhouetteBlockers::new(silhouettes.meshes(), hits).with_tolerance(tolerance);
        let mut out = vec![Vec3::ZERO; chosen.len()];
        let mut best = f64::INFINITY;
        let mut run = |shader: &mut dyn Shade<Material, Light, Error = Infallible>| {
            for _ in 0..runs {
                let Ok(stats) = shader.shade(&points, &frame, &mut out);
                best = best.min(stats.seconds);
            }
        };
        match strategy {
            Strategy::Rays => run(&mut CpuShader::new(MaskVisibility::new(RayBlockers::new(&world)))),
            Strategy::Spheres => run(&mut CpuShader::new(MaskVisibility::new(spheres))),
            Strategy::Silhouettes => run(&mut CpuShader::new(MaskVisibility::new(Mixture::new(spheres, meshes)))),
        }
        (out, best * rayon::current_num_threads() as f64)
    }

    fn errors(&self, radiance: &[Vec3]) -> Option<ShadowErrors> {
        let world = World::new(&self.scene);
        let gbuffer = GBuffer::new(&world, WIDTH, HEIGHT, 1);
        let picture =
            |values: &[Vec3]| Picture::new(WIDTH as usize, HEIGHT as usize, gbuffer.resolve(values, Vec3::ZERO));
        let (truth, unshadowed) = (picture(&self.truth.radiance), picture(&self.truth.unshadowed));
        ShadowErrors::of(&picture(radiance), &truth, &unshadowed).ok()
    }

    /// Mean standard error of the truth, in % of the unshadowed radiance.
    fn noise(&self) -> f64 {
        let sum = |all: &[Vec3]| all.iter().map(|v| f64::from(v.y)).sum::<f64>();
        100.0 * sum(&self.truth.std_error) / sum(&self.truth.unshadowed)
    }

    /// A point sees this part of the light: 1 all of it, 0 nothing.
    fn visible(&self, k: usize) -> f32 {
        let [lit, all] = [&self.truth.radiance, &self.truth.unshadowed].map(|v| v[k].y);
        if all > 0.0 { lit / all } else { -1.0 }
    }

    /// Nanoseconds of a lit point and of one in penumbra.
    fn cost(&self) -> [f64; 2] {
        let each = |keep: &dyn Fn(usize) -> bool| {
            let (out, seconds) = self.shade(Strategy::Silhouettes, 0.005, keep, 7);
            1e9 * seconds / out.len().max(1) as f64
        };
        [each(&|k| self.visible(k) == 1.0), each(&|k| (0.01..0.99).contains(&self.visible(k)))]
    }
}

fn as_spheres(proxy: &Proxy) -> Option<&Vec<Sphere>> {
    match proxy {
        Proxy::Spheres(spheres) => Some(spheres),
        _ => None,
    }
}

fn main() {
    let samples = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(4096);
    let (mut kinds, materials) = (kinds(), materials());
    // A part of a name: only such kinds.
    if let Some(part) = std::env::args().nth(2) {
        kinds.retain(|kind| kind.name.contains(&part));
    }
    println!(
        "# Lights\n\nEvery kind of light against Monte Carlo of its true shape ({samples} samples a point): a table, slats, a crate and two spheres \
         on a floor before a wall, {WIDTH} × {HEIGHT} points, exact shadows (`silhouettes`, exact spheres). Made by \
         `cargo run --release --example lights`.\n\nErrors are in % of the unshadowed radiance: penumbra mean / 99th percentile \
         (fully lit mean). \"noise\" is the mean standard error of the reference with the first material. In penumbrae it is \
         several times that, which is most of the error at a tolerance of 0.1 %.\n"
    );
    println!("## Tolerance 0.5 %\n");
    let names: Vec<&str> = materials.iter().map(|(name, _)| *name).collect();
    println!("| light | {} | noise |\n|---|{}---|", names.join(" | "), "---|".repeat(names.len()));
    let mut cases = Vec::new();
    for kind in &kinds {
        let mut row = format!("| {} |", kind.name);
        let mut noise = 0.0;
        for (m, (_, material)) in materials.iter().enumerate() {
            let case = Case::new(material, kind, Blocks::All, samples);
            let (radiance, _) = case.shade(Strategy::Silhouettes, 0.005, |_| true, 1);
            row += &case.errors(&radiance).map_or_else(String::new, |e| cell(&e));
            if m == 0 {
                noise = case.noise();
            }
            if m == 1 {
                cases.push((kind.name, case));
            }
            eprintln!("{} {m}", kind.name);
        }
        println!("{row} {noise:.3} |");
    }
    println!("\n## Other tolerances and strategies\n\nModified Phong.\n");
    println!("| light | 1 % | 0.3 % | 0.1 % | rays, 0.5 % |\n|---|---|---|---|---|");
    for (name, case) in &cases {
        let mut row = format!("| {name} |");
        let mut add = |strategy, tolerance| {
            let (radiance, _) = case.shade(strategy, tolerance, |_| true, 1);
            row += &case.errors(&radiance).map_or_else(String::new, |e| cell(&e));
        };
        [0.01, 0.003, 0.001].into_iter().for_each(|tolerance| add(Strategy::Silhouettes, tolerance));
        add(Strategy::Rays, 0.005);
        println!("{row}");
    }
    println!("\n## Spheres by `spheres`\n\n22 spheres, in a row and in a heap, instead. Modified Phong.\n");
    println!("| light | 1 % | 0.5 % | 0.3 % | 0.1 % |\n|---|---|---|---|---|");
    // A sky shines from below as well, where the floor is no sphere.
    for kind in kinds.iter().filter(|kind| kind.environment.is_none()) {
        let case = Case::new(&materials[1].1, kind, Blocks::Spheres, samples);
        let cells = [0.01, 0.005, 0.003, 0.001].map(|tolerance| {
            let (radiance, _) = case.shade(Strategy::Spheres, tolerance, |_| true, 1);
            case.errors(&radiance).map_or_else(String::new, |e| cell(&e))
        });
        println!("| {} |{}", kind.name, cells.concat());
    }
    println!(
        "\n## Cost\n\nNanoseconds of one core a point, modified Phong, tolerance 0.5 %; in parentheses relative to the sphere light.\n"
    );
    println!("| light | lit | penumbra |\n|---|---|---|");
    let mut base = None;
    for (name, case) in &cases {
        let [lit, penumbra] = case.cost();
        let [a, b] = *base.get_or_insert([lit, penumbra]);
        println!("| {name} | {lit:.0} ({:.1} ×) | {penumbra:.0} ({:.1} ×) |", lit / a, penumbra / b);
    }
    let square = cases.iter().find(|(name, _)| name.starts_with("square"));
    if let (Some(nine), Some((_, square))) = (nine_spheres(), square) {
        println!(
            "\n## The paper's rectangle\n\nThe square as nine spheres of its frontal area and radiance (the paper's Fig. 19), against the true square, \
             modified Phong.\n\n| | penumbra mean / p99 | all points, mean | seconds of a core |\n|---|---|---|---|"
        );
        let ours = square.shade(Strategy::Silhouettes, 0.005, |_| true, 5);
        let other = Case { scene: scene(&materials[1].1, &nine, Blocks::All), truth: square.truth.clone() };
        let theirs = other.shade(Strategy::Silhouettes, 0.005, |_| true, 5);
        for (name, (radiance, seconds)) in [("outline", ours), (nine.name, theirs)] {
            let sum = |f: &dyn Fn(usize) -> f32| (0..radiance.len()).map(|k| f64::from(f(k))).sum::<f64>();
            let off =
                sum(&|k| (radiance[k] - square.truth.radiance[k]).y.abs()) / sum(&|k| square.truth.unshadowed[k].y);
            if let Some(e) = square.errors(&radiance) {
                let [mean, p99] = [e.penumbra.mean, e.penumbra.p99].map(|x| 100.0 * x);
                println!("| {name} | {mean:.2} / {p99:.1} | {:.3} % | {seconds:.3} |", 100.0 * off);
            }
        }
    }
}

fn cell(errors: &ShadowErrors) -> String {
    let [mean, p99, lit] = [errors.penumbra.mean, errors.penumbra.p99, errors.lit.mean].map(|x| 100.0 * x);
    format!(" {mean:.3} / {p99:.2} ({lit:.3}) |")
}
