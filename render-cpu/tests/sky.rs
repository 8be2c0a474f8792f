//! A whole sky through one buffer a receiver, against many exact rays.

mod oracle;

use brdf::{Material, MetallicRoughness, ModifiedPhong};
use core::f32::consts::PI;
use glam::{DVec3, Mat3, UVec2, Vec3};
use lighting::{Environment, Light};
use lobe_core::Sphere;
use oracle::{Error, errors};
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SkyShader, SurfaceHits, World};
use scene::{Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade, ShadingPoints};
use shading::Accuracy;
use test_scenes::{environment_map, globe};
use visibility_mask::MaskVisibility;
use visibility_mask::sky::{SkyResolution, SkyTable};
use visibility_silhouettes::SilhouetteBlockers;

/// A smooth sky with a glow, brighter above.
fn sky(v: Vec3) -> Vec3 {
    let glow = v.dot(Vec3::new(0.6, 0.7, 0.4).normalize()).max(0.0).powi(12);
    Vec3::new(0.6, 0.8, 1.0) * (0.6 + 0.4 * v.y) + Vec3::new(3.0, 2.6, 2.0) * glow
}

/// A hard bright patch of 16° by 22° in a dim sky.
fn window(v: Vec3) -> Vec3 {
    let (turn, height) = (v.x.atan2(-v.z).to_degrees(), v.y.asin().to_degrees());
    let is_in = (30.0..46.0).contains(&turn) && (40.0..62.0).contains(&height);
    Vec3::splat(if is_in { 20.0 } else { 0.15 })
}

fn environment(radiance: impl Fn(Vec3) -> Vec3, size: UVec2) -> Environment {
    Environment::new(environment_map(size, radiance), 1, Sphere { center: Vec3::ZERO, radius: 10.0 })
}

fn floor() -> Object {
    Object::mesh("floor", Mesh::quad(Vec3::ZERO, Vec3::X * 6.0, Vec3::NEG_Z * 6.0), 0, Proxy::None)
}

fn scene(things: Vec<Mesh>, material: Material) -> Scene {
    let things = things.into_iter().map(|mesh| Object::mesh("thing", mesh, 0, Proxy::Count(8)));
    Scene {
        camera: Camera {
            eye: Vec3::new(0.4, 3.0, 4.6),
            target: Vec3::new(0.0, 0.5, 0.0),
            up: Vec3::Y,
            projection: Projection::perspective(0.6),
        },
        width: 20,
        height: 16,
        materials: vec![material],
        objects: core::iter::once(floor()).chain(things).collect(),
        ..Scene::default()
    }
}

/// A globe with dents: much like an animal.
fn dented() -> Mesh {
    dented_of(24)
}

/// Of about `4n²` triangles.
fn dented_of(n: usize) -> Mesh {
    let mut mesh = globe(n as u32, Vec3::ZERO, 1.0, false);
    for p in &mut mesh.positions {
        let waves = (5.0 * p.x + 1.0).sin() * (4.0 * p.y).cos() * (6.0 * p.z - 0.5).sin();
        *p = *p * (0.8 + 0.25 * waves) + Vec3::Y * 0.85;
    }
    // The last circle is one point but for rounding: without a hole.
    let south = mesh.positions.len() - 2 * n;
    let last = mesh.positions[south];
    mesh.positions[south..].fill(last);
    mesh.smooth_normals();
    mesh
}

/// The same with an opening below.
fn open() -> Mesh {
    let mut mesh = dented();
    mesh.triangles.truncate(mesh.triangles.len() - 200);
    mesh
}

/// A sheet that hangs over the floor, seen from both sides.
fn sheet() -> Mesh {
    Mesh::quad(Vec3::new(0.0, 0.8, 0.0), Vec3::new(0.9, 0.3, 0.1), Vec3::new(0.1, 0.2, -0.9))
}

/// Shades the points of a scene; the floor blocks nothing.
fn shade(scene: &Scene, environment: &Environment, points: &ShadingPoints, accuracy: Accuracy) -> Vec<Vec3> {
    shade_by(1, scene, environment, points, accuracy)
}

/// The same by so many tables.
fn shade_by(
    levels: usize,
    scene: &Scene,
    environment: &Environment,
    points: &ShadingPoints,
    accuracy: Accuracy,
) -> Vec<Vec3> {
    let world = World::new(scene);
    let silhouettes = SceneSilhouettes::new(scene, |o| o > 0);
    let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |o| o > 0));
    let blockers = blockers.with_tolerance(accuracy.tolerance).under_sky();
    let map = environment.sky();
    let resolutions =
        core::iter::successors(Some(SkyResolution::of_tolerance(accuracy.tolerance)), |last| last.finer()).take(levels);
    let tables: Vec<SkyTable> =
        resolutions.map(|resolution| SkyTable::new(resolution, map.size().x, |v| map.radiance(v))).collect();
    let lights: Vec<Light> = environment.lights().to_vec();
    let replaced = environment.patches_among(&lights).expect("its own lights");
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let frame: Frame<'_> = Frame::new(&scene.materials, &lights, accuracy);
    CpuShader::new(MaskVisibility::new(&blockers))
        .with_sky(SkyShader::new(&tables, replaced, &blockers))
        .shade(points, &frame, &mut out)
        .expect("shaded");
    out
}

fn points(scene: &Scene) -> ShadingPoints {
    GBuffer::new(&World::new(scene), scene.width, scene.height, 1).points
}

fn compare(name: &str, scene: &Scene, environment: &Environment, accuracy: Accuracy) -> Error {
    compare_by(1, name, scene, environment, accuracy)
}

fn compare_by(levels: usize, name: &str, scene: &Scene, environment: &Environment, accuracy: Accuracy) -> Error {
    let points = points(scene);
    let got = shade_by(levels, scene, environment, &points, accuracy);
    let error = errors(scene, environment, &points, &got);
    println!("{name}: {error:?}");
    error
}

fn metal(roughness: f32) -> Material {
    MetallicRoughness::new(Vec3::splat(0.9), 1.0, roughness).expect("a metal").into()
}

fn phong(exponent: f32) -> Material {
    ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.5), exponent }.into()
}

/// `∫ (a + b v.y) n·v dv = π(a + ⅔ b)` on a floor.
#[test]
fn open_floors_see_the_closed_form() {
    let environment = environment(|v| Vec3::new(1.0, 0.5 + v.y, 1.0 - v.y), UVec2::new(256, 128));
    let scene = scene(Vec::new(), Material::lambert(Vec3::ONE));
    for radiance in shade(&scene, &environment, &points(&scene), Accuracy::default()) {
        let want = Vec3::new(1.0, 0.5 + 2.0 / 3.0, 1.0 - 2.0 / 3.0);
        assert!((radiance / want - 1.0).abs().max_element() < 1e-3, "{radiance} for {want}");
    }
}

#[test]
fn meshes_shade_as_many_rays_say() {
    let smooth = environment(sky, UVec2::new(128, 64));
    let lambert = Material::lambert(Vec3::splat(0.8));
    let globe = globe(16, Vec3::new(0.0, 0.7, 0.0), 0.7, true);
    let fine = Accuracy::new(0.003);
    for (name, mesh, material, limits) in [
        ("globe, Lambert", globe.clone(), lambert.clone(), [0.06, 0.5]),
        ("globe, metal", globe.clone(), metal(0.5), [0.15, 1.2]),
        ("dented, Lambert", dented(), lambert.clone(), [0.1, 0.6]),
        ("dented, Phong", dented(), phong(40.0), [0.15, 1.2]),
        ("open, Lambert", open(), lambert.clone(), [0.15, 1.0]),
        ("sheet, Lambert", sheet(), lambert.clone(), [0.06, 0.5]),
    ] {
        let error = compare(name, &scene(vec![mesh], material), &smooth, fine);
        assert!(error.mean < limits[0] && error.largest < 4.0 * limits[1] && error.p99 < limits[1], "{name}");
    }
    let window = environment(window, UVec2::new(256, 128));
    let error = compare("dented, window", &scene(vec![dented()], lambert), &window, fine);
    assert!(error.mean < 0.35 && error.p99 < 3.0);
}

/// Narrow lobes see finer tables through windows, or patches, which blur a picture, and are right there too.
#[test]
fn narrow_lobes_see_windows_or_patches() {
    let smooth = environment(sky, UVec2::new(128, 64));
    let hard = environment(window, UVec2::new(256, 128));
    for (name, material, environment, levels, limits) in [
        ("Phong 2000, patches", phong(2000.0), &smooth, 1, [0.25, 1.5]),
        ("Phong 500", phong(500.0), &smooth, 2, [0.15, 0.8]),
        ("metal 0.1", metal(0.1), &smooth, 3, [0.15, 0.8]),
        ("metal 0.2, window", metal(0.2), &hard, 2, [0.25, 2.0]),
    ] {
        let error = compare_by(levels, name, &scene(vec![dented()], material), environment, Accuracy::default());
        assert!(error.mean < limits[0] && error.p99 < limits[1], "{name}");
    }
}

/// A receiver in a closed box: exactly nothing.
#[test]
fn closed_rooms_are_black() {
    let walls = globe(2, Vec3::new(0.0, 0.5, 0.0), 20.0, false);
    let scene = scene(vec![walls, dented()], phong(20.0));
    let environment = environment(sky, UVec2::new(64, 32));
    let points = points(&scene);
    assert!(points.receivers.len() > 250);
    let got = shade(&scene, &environment, &points, Accuracy::default());
    assert!(got.iter().all(|radiance| *radiance == Vec3::ZERO));
}

/// Bit for bit, in whatever tiles the points lie, and on however many threads.
#[test]
fn tiles_and_threads_do_not_matter() {
    let scene = scene(vec![dented(), sheet()], phong(40.0));
    let environment = environment(sky, UVec2::new(64, 32));
    let points = points(&scene);
    let got = shade(&scene, &environment, &points, Accuracy::default());
    let n = points.receivers.len();
    // 7 has no common factor with the number of points.
    assert!(!n.is_multiple_of(7));
    let order: Vec<usize> = (0..n).map(|k| k * 7 % n).collect();
    let other = ShadingPoints {
        receivers: order.iter().map(|k| points.receivers[*k]).collect(),
        materials: order.iter().map(|k| points.materials[*k]).collect(),
        ..ShadingPoints::default()
    };
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let mixed = alone.install(|| shade(&scene, &environment, &other, Accuracy::default()));
    for (place, k) in order.into_iter().enumerate() {
        assert_eq!(mixed[place].to_array().map(f32::to_bits), got[k].to_array().map(f32::to_bits), "point {k}");
    }
}

/// Quarter turns of everything change which edges pass which samples, and nothing else.
#[test]
fn quarter_turns_do_not_matter() {
    let scene = scene(vec![dented()], metal(0.4));
    let first = points(&scene);
    let plain = shade(&scene, &environment(sky, UVec2::new(256, 128)), &first, Accuracy::default());
    for turn in [Mat3::from_rotation_y(0.5 * PI), Mat3::from_rotation_x(0.5 * PI), Mat3::from_rotation_z(PI)] {
        let turn = Mat3::from_cols_array(&turn.to_cols_array().map(f32::round));
        let back = turn.transpose();
        let mut turned = scene.clone();
        for object in &mut turned.objects {
            if let scene::Shape::Mesh(mesh) = &mut object.shape {
                mesh.positions.iter_mut().chain(&mut mesh.normals).for_each(|v| *v = turn * *v);
            }
        }
        let mut points = first.clone();
        for at in &mut points.receivers {
            (at.position, at.normal) = (turn * at.position, turn * at.normal);
            (at.face, at.view) = (turn * at.face, turn * at.view);
        }
        let environment = environment(|v| sky(back * v), UVec2::new(256, 128));
        let got = shade(&turned, &environment, &points, Accuracy::default());
        let scale = plain.iter().map(|p| p.max_element()).fold(0.0, f32::max);
        let errors: Vec<f32> = got.iter().zip(&plain).map(|(a, b)| (*a - *b).abs().max_element() / scale).collect();
        // Another picture of the same sky, other rows.
        let mean = errors.iter().sum::<f32>() / errors.len() as f32;
        let most = errors.iter().copied().fold(0.0, f32::max);
        println!("mean {mean:.6}, most {most:.6}");
        assert!(mean < 2e-3 && most < 3e-2, "{turn}: {mean}, {most}");
    }
}

/// One thing more never brightens: by what two outlines in one sample share.
#[test]
fn blockers_only_darken() {
    let environment = environment(sky, UVec2::new(64, 32));
    let one = scene(vec![dented()], Material::lambert(Vec3::ONE));
    let two = scene(vec![dented(), sheet()], Material::lambert(Vec3::ONE));
    let points = points(&one);
    let [before, after] = [&one, &two].map(|scene| shade(scene, &environment, &points, Accuracy::default()));
    for (a, b) in before.iter().zip(&after) {
        assert!(b.cmple(*a + 2e-3).all(), "{b} after {a}");
    }
}

/// Corners at the pole, as receivers see them.
#[test]
fn corners_at_the_pole_are_no_traps() {
    let n = 6;
    let mut spike = Mesh::default();
    for (x, z) in (0..n).flat_map(|i| (0..n).map(move |k| (i as f32 * 0.25, k as f32 * 0.25))) {
        let first = spike.positions.len() as u32;
        // Its tip hangs in the direction of the pole from (x, z).
        let tip = visibility_mask::sky::Pole::nearest(Vec3::Y).world(Vec3::Z);
        let corners = [(0.0, 0.0, 0.0), (0.1, 0.6, 0.1), (-0.1, 0.6, 0.1), (0.0, 0.6, -0.1)];
        spike.positions.extend(corners.map(|(dx, dy, dz)| tip + Vec3::new(x + dx, dy, z + dz)));
        spike.triangles.extend([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]].map(|t| t.map(|i| i + first)));
    }
    let scene = scene(vec![spike], Material::lambert(Vec3::ONE));
    let at = |x: f32, z: f32| lobe_core::Receiver::on_surface(Vec3::new(x, 0.0, z), Vec3::Y, Vec3::Y).on_object(0);
    let receivers: Vec<_> = (0..n).flat_map(|i| (0..n).map(move |k| at(i as f32 * 0.25, k as f32 * 0.25))).collect();
    let points = ShadingPoints { materials: vec![0; receivers.len()], receivers, ..ShadingPoints::default() };
    let environment = environment(sky, UVec2::new(128, 64));
    let got = shade(&scene, &environment, &points, Accuracy::new(0.001));
    let error = errors(&scene, &environment, &points, &got);
    println!("{error:?}");
    assert!(error.mean < 0.1 && error.largest < 0.4);
}

/// A window that is hardly wider than samples lights a room: through the finer masks of patches.
#[test]
fn small_windows_light_rooms() {
    let wall = |x: [f32; 2], y: [f32; 2]| {
        let half = Vec3::new(x[1] - x[0], y[1] - y[0], 0.0) * 0.5;
        Mesh::quad(Vec3::new(x[0] + half.x, y[0] + half.y, -4.0), Vec3::X * half.x, Vec3::Y * half.y)
    };
    let mut room = Mesh::default();
    let quads = [
        Mesh::quad(Vec3::new(0.0, 4.0, 0.0), Vec3::X * 4.0, Vec3::Z * 6.0),
        Mesh::quad(Vec3::new(0.0, 2.0, 6.0), Vec3::X * 4.0, Vec3::Y * 2.0),
        Mesh::quad(Vec3::new(-4.0, 2.0, 1.0), Vec3::Z * 5.0, Vec3::Y * 2.0),
        Mesh::quad(Vec3::new(4.0, 2.0, 1.0), Vec3::Z * 5.0, Vec3::Y * 2.0),
        // Around a window of 0.5 × 0.4.
        wall([-4.0, -0.3], [0.0, 4.0]),
        wall([0.2, 4.0], [0.0, 4.0]),
        wall([-0.3, 0.2], [0.0, 1.8]),
        wall([-0.3, 0.2], [2.2, 4.0]),
    ];
    for quad in quads {
        let first = room.positions.len() as u32;
        room.positions.extend(quad.positions);
        room.triangles.extend(quad.triangles.into_iter().map(|t| t.map(|i| i + first)));
    }
    let mut scene = scene(vec![room], Material::lambert(Vec3::ONE));
    scene.camera.eye = Vec3::new(0.0, 2.5, 5.5);
    let environment = environment(|_| Vec3::ONE, UVec2::new(8, 4));
    let mut points = points(&scene);
    let on_floor: Vec<_> =
        points.receivers.iter().copied().filter(|at| at.object == 0 && at.position.z > -3.5).collect();
    points = ShadingPoints { materials: vec![0; on_floor.len()], receivers: on_floor, ..ShadingPoints::default() };
    let got = shade(&scene, &environment, &points, Accuracy::default());
    let world = World::new(&scene);
    let silhouettes = SceneSilhouettes::new(&scene, |o| o > 0);
    let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |o| o > 0));
    let mut by_patches = vec![Vec3::ZERO; points.receivers.len()];
    let frame: Frame<'_> = Frame::new(&scene.materials, environment.lights(), Accuracy::default());
    CpuShader::new(MaskVisibility::new(&blockers)).shade(&points, &frame, &mut by_patches).expect("shaded");
    // All see less than an eighth.
    assert!(points.receivers.len() > 50 && got == by_patches);
    let mut errors: Vec<f64> = Vec::new();
    for (at, got) in points.receivers.iter().zip(&got) {
        let truth = through_window(at.position.as_dvec3());
        if truth > 1e-4 {
            errors.push((f64::from(got.x) / truth - 1.0).abs());
        }
    }
    errors.sort_unstable_by(f64::total_cmp);
    let (mean, largest) = (errors.iter().sum::<f64>() / errors.len() as f64, errors[errors.len() - 1]);
    println!("of own radiance: mean {mean:.4}, largest {largest:.4}");
    assert!(mean < 0.02 && largest < 0.2, "{mean} {largest}");
}

/// The radiance of a white point of the floor under a sky of 1, through the window of the room and below its roof, which ends at z = -6.
fn through_window(x: DVec3) -> f64 {
    const STEPS: usize = 128;
    let mut sum = 0.0;
    for k in 0..STEPS * STEPS {
        let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
        let to = DVec3::new(-0.3 + 0.5 * at(k % STEPS), 1.8 + 0.4 * at(k / STEPS), -4.0) - x;
        let direction = to.normalize();
        let is_below_roof = x.z + to.z * (4.0 / to.y) < -6.0;
        sum += if is_below_roof { direction.y * -direction.z / to.length_squared() } else { 0.0 };
    }
    sum * 0.5 * 0.4 / (core::f64::consts::PI * (STEPS * STEPS) as f64)
}

/// Simplified forms of a large mesh, simpler by the distance, change little, and what a point sees depends on it alone and on where the mesh is now.
#[test]
fn large_meshes_have_forms_before_a_sky() {
    let mut scene = scene(vec![dented_of(90)], Material::lambert(Vec3::splat(0.7)));
    let environment = environment(sky, UVec2::new(64, 32));
    let table = SkyTable::new(SkyResolution::new(64, 64), 64, |v| environment.sky().radiance(v));
    let lights: Vec<Light> = environment.lights().to_vec();
    let shade = |scene: &Scene, silhouettes: &SceneSilhouettes, points: &ShadingPoints, (tolerance, is_under)| {
        let world = World::new(scene);
        let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |o| o > 0));
        let blockers = blockers.with_tolerance(tolerance);
        let blockers = if is_under { blockers.under_sky() } else { blockers };
        let replaced = environment.patches_among(&lights).expect("its own lights");
        let frame: Frame<'_> = Frame::new(&scene.materials, &lights, Accuracy::default());
        let mut out = vec![Vec3::ZERO; points.receivers.len()];
        CpuShader::new(MaskVisibility::new(&blockers))
            .with_sky(SkyShader::new([&table], replaced, &blockers))
            .shade(points, &frame, &mut out)
            .expect("shaded");
        out
    };
    let all = points(&scene);
    let mut silhouettes = SceneSilhouettes::new(&scene, |o| o > 0);
    let exact = shade(&scene, &silhouettes, &all, (0.0, true));
    assert_eq!(exact, shade(&scene, &silhouettes, &all, (0.0, false)));
    let before = shade(&scene, &silhouettes, &all, (0.005, false));
    let forms = shade(&scene, &silhouettes, &all, (0.005, true));
    let most = exact.iter().map(|v| v.element_sum()).fold(0.0, f32::max);
    let sizes: Vec<f32> = exact.iter().zip(&forms).map(|(a, b)| (*a - *b).element_sum().abs() / most).collect();
    let mean = sizes.iter().sum::<f32>() / sizes.len() as f32;
    let largest = sizes.iter().copied().fold(0.0, f32::max);
    let changed = forms.iter().zip(&before).filter(|(a, b)| a != b).count();
    println!("{changed} of {} changed, mean {mean}, largest {largest}", all.receivers.len());
    assert!(changed > all.receivers.len() / 4 && mean < 5e-4 && largest < 1e-2, "{changed} {mean} {largest}");
    // Each point by itself, also where near points share lists.
    let mut closer = scene.clone();
    closer.camera.projection = Projection::perspective(0.15);
    let near = points(&closer);
    let of_near = shade(&scene, &silhouettes, &near, (0.005, true));
    for (all, forms) in [(&all, &forms), (&near, &of_near)] {
        for i in (0..all.receivers.len()).step_by(5) {
            let one = ShadingPoints {
                receivers: vec![all.receivers[i]],
                materials: vec![all.materials[i]],
                ..ShadingPoints::default()
            };
            assert_eq!(shade(&scene, &silhouettes, &one, (0.005, true)), [forms[i]], "{i}");
        }
    }
    // Forms follow the mesh.
    if let scene::Shape::Mesh(mesh) = &mut scene.objects[1].shape {
        mesh.positions.iter_mut().for_each(|p| *p = Vec3::new(1.3 * p.x, p.y, p.z + 0.3 * p.y));
    }
    silhouettes.refit(&scene);
    let moved = points(&scene);
    let fresh = SceneSilhouettes::new(&scene, |o| o > 0);
    let [followed, fresh] = [&silhouettes, &fresh].map(|own| shade(&scene, own, &moved, (0.005, true)));
    let exact = shade(&scene, &silhouettes, &moved, (0.0, true));
    let largest =
        |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| (*a - *b).element_sum().abs() / most).fold(0.0, f32::max);
    assert!(largest(&followed, &fresh) < 1e-2 && largest(&followed, &exact) < 2e-2);
}
