//! Instances of a shared mesh: pictures with the bits of copies.

use brdf::Lambert;
use glam::{Mat4, Quat, UVec2, Vec3};
use lighting::{Environment, EnvironmentMap, FlatLight, Light, SphereLight, SunLight, TubeLight};
use lobe_core::{Random, Sphere};
use renderer::{Renderer, Settings};
use scene::{Animation, Instances, Mesh, Object, Proxy, Scene, Shape, Strategy};
use std::sync::Arc;
use test_scenes::floor_and_sphere;

/// Matrices in a field: turned, some scaled unequally or mirrored.
fn places(random: &mut Random, count: usize, offset: Vec3) -> Vec<Mat4> {
    let place = |k: usize| {
        let turn = Quat::from_axis_angle(random.axis().as_vec3().normalize(), random.between(0.0, 3.0) as f32);
        let mut scale = Vec3::splat(random.between(0.3, 0.6) as f32);
        match k % 4 {
            1 => scale.x = -scale.x,
            2 => scale *= Vec3::new(0.4, 1.5, 1.0),
            _ => {}
        }
        let at = Vec3::new((k % 4) as f32 * 1.1 - 1.7, 0.5 + 0.1 * (k % 3) as f32, (k / 4) as f32 * 1.1 - 1.2);
        Mat4::from_scale_rotation_translation(scale, turn, at + offset)
    };
    (0..count).map(place).collect()
}

/// A ring, a fin, which makes it open, and a box. No two corners are so near to each other that rounding makes them one.
fn shape(smooth: bool) -> Mesh {
    const AROUND: [u32; 2] = [18, 9];
    let mut mesh = Mesh::default();
    for (i, k) in (0..AROUND[0]).flat_map(|i| (0..AROUND[1]).map(move |k| (i, k))) {
        let [u, v] = [i as f32 / AROUND[0] as f32, k as f32 / AROUND[1] as f32].map(|t| t * core::f32::consts::TAU);
        let across = 0.7 + 0.25 * v.cos();
        mesh.positions.push(Vec3::new(across * u.cos(), 0.25 * v.sin() + 0.1 * u.sin(), across * u.sin()));
        let at = |i: u32, k: u32| (i % AROUND[0]) * AROUND[1] + k % AROUND[1];
        let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i, k + 1), at(i + 1, k + 1)];
        mesh.triangles.extend([[a, c, b], [b, c, d]]);
    }
    let fin = vec![Vec3::ZERO, Vec3::new(1.4, 0.2, 0.0), Vec3::new(0.9, 1.1, 0.3)];
    mesh.append(&Mesh { positions: fin, triangles: vec![[0, 1, 2]], ..Mesh::default() });
    mesh.append(&Mesh::cuboid(Vec3::new(-0.9, 0.3, 0.0), Vec3::new(0.5, 0.3, 0.8)));
    if smooth {
        mesh.smooth_normals();
    }
    mesh
}

fn scene(smooth: bool, lights: Vec<Light>, offset: Vec3) -> Scene {
    let mut random = Random::new(11);
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (96, 64);
    scene.materials.push(Lambert { albedo: Vec3::new(0.7, 0.5, 0.3) }.into());
    let mut mesh = shape(smooth);
    mesh.colors = mesh.positions.iter().map(|p| (0.5 + 0.3 * *p).clamp(Vec3::ZERO, Vec3::ONE)).collect();
    let mesh = Arc::new(mesh);
    let all = places(&mut random, 12, offset);
    scene.camera.eye += offset;
    scene.camera.target += offset;
    for object in &mut scene.objects {
        match &mut object.shape {
            Shape::Mesh(mesh) => mesh.positions.iter_mut().for_each(|p| *p += offset),
            Shape::Spheres(spheres) => spheres.iter_mut().for_each(|s| s.center += offset),
            Shape::Instances(_) => {}
        }
    }
    scene.objects[1].proxy = Proxy::None;
    for (name, places) in [("one", &all[..1]), ("some", &all[1..5]), ("more", &all[5..])] {
        let shape = Shape::Instances(Instances::new(Arc::clone(&mesh), places.to_vec()).expect("instances"));
        let object = Object::mesh(name, Mesh::default(), 1, Proxy::None);
        scene.objects.push(Object { shape, ..object });
    }
    scene.lights = lights;
    scene
}

/// The scene with a copy of the mesh for each instance.
fn copied(scene: &Scene) -> Scene {
    let mut copied = scene.clone();
    for object in &mut copied.objects {
        if let Shape::Instances(instances) = &object.shape {
            object.shape = Shape::Mesh(instances.expanded());
        }
    }
    copied
}

fn sphere(offset: Vec3) -> Light {
    SphereLight::new(Sphere { center: Vec3::new(1.0, 4.0, 1.5) + offset, radius: 0.6 }, Vec3::splat(4.0)).into()
}

fn check(scene: &Scene, settings: &Settings, what: &str) {
    let (count, worst) = differing(scene, settings, what);
    assert_eq!(count, 0, "{what}: by {worst} at most");
}

/// How many pixels differ from those of copies, and by how much at most.
fn differing(scene: &Scene, settings: &Settings, what: &str) -> (usize, f32) {
    let picture = |scene: &Scene| {
        let mut renderer = Renderer::new(scene.clone(), Animation::default(), settings.clone()).expect("a scene");
        renderer.render().expect("a picture").radiance
    };
    let (ours, want) = (picture(scene), picture(&copied(scene)));
    let shadowed = want.iter().filter(|p| p.max_element() > 0.0).count();
    assert!(shadowed > want.len() / 10, "{what}: nothing is seen");
    let others = ours.iter().zip(&want).filter(|(a, b)| a != b);
    let worst = others.clone().map(|(a, b)| (*a - *b).length()).fold(0.0, f32::max);
    (others.count(), worst)
}

#[test]
fn instances_have_the_bits_of_copies_in_any_light() {
    let panel = FlatLight::rectangle(Vec3::new(0.0, 4.0, 1.0), Vec3::X, Vec3::Z, Vec3::splat(3.0)).expect("a panel");
    let world = Sphere { center: Vec3::ZERO, radius: 40.0 };
    let sun = SunLight::new(Vec3::new(0.4, 0.8, 0.5).normalize(), 2.0, Vec3::splat(3.0), world);
    let ends = [Vec3::new(-2.0, 3.0, 1.0), Vec3::new(2.0, 3.5, 1.0)];
    let tube = TubeLight { ends, radius: 0.1, radiance: Vec3::splat(9.0) };
    let lights: [(&str, Light); 4] =
        [("sphere", sphere(Vec3::ZERO)), ("panel", panel.into()), ("sun", sun.into()), ("tube", tube.into())];
    for (name, light) in lights {
        for smooth in [false, true] {
            let scene = scene(smooth, vec![light.clone()], Vec3::ZERO);
            check(&scene, &Settings::default(), &format!("{name}, smooth {smooth}"));
        }
    }
}

#[test]
fn instances_have_the_bits_of_copies_by_other_strategies() {
    for strategy in [Strategy::Rays, Strategy::None] {
        let scene = scene(true, vec![sphere(Vec3::ZERO)], Vec3::ZERO);
        check(&scene, &Settings { strategy: Some(strategy), ..Settings::default() }, strategy.name());
    }
}

/// Most boxes of their hierarchy lie between the rays of neighbouring pixels.
#[test]
fn instances_of_the_size_of_a_pixel_have_the_bits_of_copies() {
    let mut scene = scene(false, vec![sphere(Vec3::ZERO)], Vec3::ZERO);
    let Some(Shape::Instances(few)) = scene.objects.pop().map(|object| object.shape) else { panic!() };
    let place = |k: u16| {
        let at = Vec3::new(f32::from(k % 30) - 14.5, 0.3, -f32::from(k / 30) * 2.0);
        Mat4::from_scale_rotation_translation(Vec3::splat(0.4), Quat::from_rotation_y(f32::from(k)), at)
    };
    let many = Instances::new(Arc::clone(few.mesh()), (0..600).map(place).collect()).expect("instances");
    let object = Object::mesh("many", Mesh::default(), 1, Proxy::None);
    scene.objects.push(Object { shape: Shape::Instances(many), ..object });
    scene.camera.eye = Vec3::new(3.0, 9.0, 25.0);
    scene.camera.target = Vec3::new(0.0, 0.0, -25.0);
    check(&scene, &Settings { strategy: Some(Strategy::None), ..Settings::default() }, "of the size of a pixel");
}

#[test]
fn instances_are_copies_to_rounding_under_a_sky() {
    let pixels = (0..16 * 8).map(|k| Vec3::splat(0.2 + (k % 7) as f32 * 0.3)).collect();
    let map = EnvironmentMap::new(UVec2::new(16, 8), pixels).expect("a map");
    let mut scene = scene(true, Vec::new(), Vec3::ZERO);
    let world = Sphere { center: Vec3::ZERO, radius: 40.0 };
    let sky = Environment::new(map, 12, world);
    scene.lights = sky.lights().to_vec();
    scene.environment = Some(Arc::new(sky));
    // A sky sums parts of samples in the order of the list.
    let (count, worst) = differing(&scene, &Settings::default(), "sky");
    assert!(count < 20 && worst < 1e-4, "{count} pixels by {worst} at most");
}

/// A bumpy sphere of `2 n²` triangles.
fn bumpy(n: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for (ring, k) in (0..=n).flat_map(|ring| (0..n).map(move |k| (ring, k))) {
        let [theta, phi] =
            [ring as f32 / n as f32 * core::f32::consts::PI, k as f32 / n as f32 * core::f32::consts::TAU];
        let radius = 1.0 + 0.1 * (5.0 * phi).sin() * theta.sin() + 0.05 * (9.0 * theta).cos();
        let across = if ring == 0 || ring == n { 0.0 } else { radius * theta.sin() };
        mesh.positions.push(Vec3::new(across * phi.cos(), radius * theta.cos(), across * phi.sin()));
        let at = |ring: u32, k: u32| ring * n + k % n;
        let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1)];
        if ring < n {
            mesh.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    mesh.remove_degenerate();
    mesh
}

/// Shared meshes have their simplified forms, copies those of all copies together.
#[test]
fn dense_instances_are_copies_to_their_details_under_a_sky() {
    let pixels = (0..16 * 8).map(|k| Vec3::splat(0.2 + (k % 7) as f32 * 0.3)).collect();
    let map = EnvironmentMap::new(UVec2::new(16, 8), pixels).expect("a map");
    let mut scene = scene(true, Vec::new(), Vec3::ZERO);
    scene.objects.truncate(1);
    let mesh = Arc::new(bumpy(110));
    let all = places(&mut Random::new(3), 4, Vec3::ZERO);
    let instances = Instances::new(mesh, all).expect("instances");
    scene
        .objects
        .push(Object { shape: Shape::Instances(instances), ..Object::mesh("all", Mesh::default(), 1, Proxy::None) });
    let sky = Environment::new(map, 12, Sphere { center: Vec3::ZERO, radius: 40.0 });
    scene.lights = sky.lights().to_vec();
    scene.environment = Some(Arc::new(sky));
    let picture = |scene: &Scene| {
        let renderer = Renderer::new(scene.clone(), Animation::default(), Settings::default());
        renderer.expect("a scene").render().expect("a picture").radiance
    };
    let (ours, want) = (picture(&scene), picture(&copied(&scene)));
    let seen = want.iter().filter(|p| p.max_element() > 0.0).count() as f32;
    let error = |(a, b): (&Vec3, &Vec3)| (*a - *b).length() / b.length().max(1e-3);
    let errors: Vec<f32> = ours.iter().zip(&want).map(error).collect();
    let (mean, most) = (errors.iter().sum::<f32>() / seen, errors.iter().copied().fold(0.0, f32::max));
    println!("{mean} in the mean, {most} at most");
    assert!(mean > 0.0 && mean < 5e-4 && most < 0.02, "{mean} in the mean, {most} at most");
}

/// Rounding of the corners is a thousandth of their triangles there.
#[test]
fn instances_have_the_bits_of_copies_far_from_the_origin() {
    let offset = Vec3::new(3000.0, 0.0, -2000.0);
    check(&scene(false, vec![sphere(offset)], offset), &Settings::default(), "far");
}

#[test]
fn instances_follow_edits() {
    let scene = scene(true, vec![sphere(Vec3::ZERO)], Vec3::ZERO);
    let mut edited = Renderer::new(scene, Animation::default(), Settings::default()).expect("a scene");
    edited.render().expect("a picture");
    let handles: Vec<_> = edited.objects().map(|(handle, _)| handle).collect();
    let moved = *handles.last().expect("objects");
    let builds = edited.upkeep().silhouette_builds;
    edited.set_transform(moved, Mat4::from_translation(Vec3::new(0.3, 0.2, 0.1))).expect("moved");
    let image = edited.render().expect("a picture");
    // The shared mesh stays as it was prepared.
    assert_eq!(edited.upkeep().silhouette_builds, builds);
    check(edited.scene(), &Settings::default(), "moved");
    assert_eq!(image.radiance, {
        let scene = edited.scene().clone();
        Renderer::new(scene, Animation::default(), Settings::default())
            .expect("a scene")
            .render()
            .expect("a picture")
            .radiance
    });
    assert!(edited.set_transform(moved, Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0))).is_err());
    edited.remove_object(handles[2]).expect("removed");
    let image = edited.render().expect("a picture");
    let scene = edited.scene().clone();
    let fresh = Renderer::new(scene, Animation::default(), Settings::default()).expect("a scene").render();
    assert_eq!(image.radiance, fresh.expect("a picture").radiance);
}
