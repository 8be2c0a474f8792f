//! Visible points found on the GPU against `render_cpu::GBuffer`.

use crate::call::trial;
use crate::parity::{View, plain};
use brdf::Material;
use glam::{Mat4, Quat, Vec3};
use libtest_mimic::Trial;
use lighting::{Light, SphereLight};
use lobe_core::{Receiver, Sphere};
use render_cpu::{CpuShader, GBuffer, World};
use render_gpu::{Gpu, GpuGBuffer, GpuShader, Occlusion};
use scene::{Camera, Mesh, Object, Projection, Proxy, Scene, Shade, Shape};
use test_scenes::globe;
use visibility_mask::{LookAgain, MaskVisibility};

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("points_of_the_built_in_scene", gpu, |gpu| same(gpu, &plain(), 240, 136)),
        trial("points_of_many_triangles", gpu, |gpu| same(gpu, &globes(), 160, 90)),
        trial("points_of_one_pixel", gpu, |gpu| same(gpu, &plain(), 1, 1)),
        trial("points_of_windows", gpu, windows),
        trial("points_of_parallel_rays", gpu, parallel),
        trial("points_of_panoramas", gpu, panoramic),
        trial("points_are_shaded_where_they_are", gpu, shaded),
        trial("pictures_are_recorded_for_a_caller", gpu, recorded),
        trial("points_of_nothing", gpu, nothing),
        trial("points_from_inside", gpu, from_inside),
        trial("points_at_all_scales", gpu, scales),
        trial("points_follow_motion", gpu, motion),
        trial("points_have_no_cracks", gpu, no_cracks),
        trial("points_of_a_large_floor", gpu, on_a_large_floor),
    ]
}

/// Meshes of some 20 000 triangles, smooth and flat; one hidden mesh; spheres; a tilted floor.
fn globes() -> Scene {
    let mut scene = plain();
    let tilt = Vec3::new(0.0, -0.2, -3.9);
    scene.objects = vec![
        Object::mesh("floor", Mesh::quad(Vec3::NEG_Y, Vec3::X * 5.0, tilt), 0, Proxy::None),
        Object::mesh("smooth", globe(60, Vec3::new(-1.0, 0.3, 0.0), 1.0, true), 1, Proxy::None),
        Object::mesh("flat", globe(40, Vec3::new(1.2, 0.4, 0.5), 0.9, false), 2, Proxy::None),
        Object { visible: false, ..Object::mesh("veil", globe(9, Vec3::Z * 4.0, 0.5, false), 2, Proxy::Count(1)) },
        Object::spheres("row", (0..30).map(|i| sphere(0.3 * i as f32 - 4.5, 0.12)).collect(), 3),
    ];
    scene.camera = Camera {
        eye: Vec3::new(0.4, 1.8, 6.5),
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::perspective(0.6),
    };
    scene
}

fn sphere(x: f32, radius: f32) -> Sphere {
    Sphere { center: Vec3::new(x, 0.9 + 0.03 * x * x, -1.0), radius }
}

/// A rotated floor of this half size under a light: no plane in f32 contains it exactly.
pub(crate) fn large_floor(half: f32) -> Scene {
    let turn = Mat4::from_quat(Quat::from_xyzw(0.31, -0.22, 0.17, 0.91).normalize());
    let mut floor = Mesh::quad(Vec3::ZERO, Vec3::X * half, Vec3::NEG_Z * half);
    floor.transform(&turn);
    let mut scene = plain();
    scene.objects = vec![Object::mesh("floor", floor, 0, Proxy::Count(8))];
    scene.materials = vec![Material::lambert(Vec3::splat(0.5))];
    let sphere = Sphere { center: turn.transform_point3(Vec3::new(-3.0, 3.4, 1.5)), radius: 0.5 };
    scene.lights = vec![SphereLight::new(sphere, Vec3::splat(90.0)).into()];
    let [eye, target, up] = [Vec3::new(1.0, 1.4, 2.6), Vec3::Y * 0.1, Vec3::Y].map(|v| turn.transform_point3(v));
    scene.camera = Camera { eye, target, up, projection: Projection::perspective(0.6) };
    scene
}

/// Points lie on their triangle to within their own rounding, however far its corners are.
fn on_a_large_floor(gpu: &Gpu) {
    let scene = large_floor(1000.0);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { unreachable!("a mesh") };
    let mut gbuffer = GpuGBuffer::new(gpu, &scene).expect("geometry");
    let (points, _) = gbuffer.read(&scene.camera, 64, 48, 0..64, 0..48).expect("points");
    let mut worst = 0.0_f64;
    for at in &points.receivers {
        let off = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|k| mesh.positions[k as usize].as_dvec3());
            (b - a).cross(c - a).normalize().dot(at.position.as_dvec3() - a).abs()
        });
        // Of the two triangles, whose planes differ by rounding, the one that contains the point.
        let off = off.fold(f64::INFINITY, f64::min);
        worst = worst.max(off / f64::from(at.position.abs().max_element()));
    }
    println!("{} points, off the plane by {worst:.1e} of their largest coordinate", points.receivers.len());
    // Half a last digit of each coordinate.
    assert!(points.receivers.len() > 2000 && worst < 1.1e-7);
}

/// Moves and scales the whole scene.
pub(crate) fn placed(mut scene: Scene, scale: f32, shift: Vec3) -> Scene {
    let place = Mat4::from_translation(shift) * Mat4::from_scale(Vec3::splat(scale));
    let moved = |b: &Sphere| Sphere { center: place.transform_point3(b.center), radius: b.radius * scale };
    for object in &mut scene.objects {
        match &mut object.shape {
            Shape::Mesh(mesh) => mesh.transform(&place),
            Shape::Instances(instances) => *instances = instances.moved(&place).expect("a place"),
            Shape::Spheres(spheres) => spheres.iter_mut().for_each(|b| *b = moved(b)),
        }
    }
    scene.lights.iter_mut().filter_map(Light::as_sphere_mut).for_each(|l| l.sphere = moved(&l.sphere));
    scene.camera.eye = place.transform_point3(scene.camera.eye);
    scene.camera.target = place.transform_point3(scene.camera.target);
    scene
}

/// Differences between the points of two images.
#[derive(Debug, Default)]
struct Differences {
    points: usize,
    /// Pixels where one image sees something and the other nothing, or another object or material.
    other: usize,
    /// Points at another position, or with another normal.
    moved: usize,
    position: f32,
    off_plane: f32,
    normal: f32,
}

/// Compares pixel by pixel: positions to 1e-5 of the scene's size and normals to 1e-4 count as equal.
fn differences(gpu: &mut GpuGBuffer, scene: &Scene, width: u32, height: u32) -> Differences {
    let world = World::new(scene);
    let want = GBuffer::new(&world, width, height, 1);
    let (points, pixels) = gpu.read(&scene.camera, width, height, 0..width, 0..height).expect("points");
    let mut by_pixel: Vec<Vec<(Receiver, u32)>> = vec![Vec::new(); (width * height) as usize];
    for ((at, material), pixel) in points.receivers.iter().zip(&points.materials).zip(&pixels) {
        by_pixel[*pixel as usize].push((*at, *material));
    }
    let mut out = Differences { points: want.len(), ..Differences::default() };
    out.other += points.receivers.len().saturating_sub(want.len());
    let bounds = scene.bounds();
    let size = (bounds.max - bounds.min).length();
    for ((at, material), pixel) in want.points.receivers.iter().zip(&want.points.materials).zip(&want.pixels) {
        let [(found, of)] = by_pixel[*pixel as usize][..] else {
            out.other += 1;
            continue;
        };
        if found.object != at.object || of != *material {
            out.other += 1;
            continue;
        }
        let apart = (found.position - at.position) / size;
        let turned = (found.normal - at.normal).length().max((found.face - at.face).length());
        if apart.length() > 1e-5 || turned > 1e-4 || (found.view - at.view).length() > 1e-4 {
            out.moved += 1;
            continue;
        }
        out.position = out.position.max(apart.length());
        out.off_plane = out.off_plane.max(apart.dot(at.face).abs());
        out.normal = out.normal.max(turned);
    }
    out
}

/// At most one pixel plus one in 10 000 differs.
fn check(gpu: &mut GpuGBuffer, scene: &Scene, width: u32, height: u32) -> Differences {
    let found = differences(gpu, scene, width, height);
    println!("{width}×{height}: {found:?}");
    assert!(found.other + found.moved <= 1 + (width * height) as usize / 10_000, "{found:?}");
    found
}

fn same(gpu: &Gpu, scene: &Scene, width: u32, height: u32) {
    let found = check(&mut GpuGBuffer::new(gpu, scene).expect("geometry"), scene, width, height);
    assert!(found.points > (width * height / 3) as usize, "{found:?}");
    // A few roundings of coordinates as large as the scene.
    assert!(found.off_plane < 3e-7, "{found:?}");
}

/// From near and far, from between the objects, and of a large floor whose corners are far from the picture.
fn parallel(gpu: &Gpu) {
    let (mut scene, eye) = (globes(), Vec3::new(0.4, 1.8, 6.5));
    for (eye, height) in [(eye, 4.0), (eye * 1000.0, 4.0), (Vec3::new(0.1, 0.4, 0.2), 2.0)] {
        scene.camera = Camera { eye, projection: Projection::Orthographic { height }, ..scene.camera };
        same(gpu, &scene, 160, 90);
    }
    let mut scene = large_floor(1000.0);
    scene.camera.projection = Projection::Orthographic { height: 3.0 };
    let found = check(&mut GpuGBuffer::new(gpu, &scene).expect("geometry"), &scene, 64, 48);
    assert!(found.points > 2000);
}

fn panoramic(gpu: &Gpu) {
    let mut scene = globes();
    for eye in [Vec3::new(0.4, 0.8, 3.0), Vec3::new(0.1, 0.4, 0.2)] {
        scene.camera = Camera { eye, projection: Projection::Panoramic, ..scene.camera };
        for (width, height) in [(160, 80), (17, 9)] {
            let found = check(&mut GpuGBuffer::new(gpu, &scene).expect("geometry"), &scene, width, height);
            assert!(found.points > (width * height / 4) as usize, "{found:?}");
        }
    }
}

/// The same points in windows that cut tiles, in `GBuffer`'s order.
fn windows(gpu: &Gpu) {
    let scene = globes();
    let world = World::new(&scene);
    let mut ours = GpuGBuffer::new(gpu, &scene).expect("geometry");
    for (columns, rows) in [(0..90, 0..50), (3..61, 5..44), (40..41, 17..18), (8..64, 8..8)] {
        let want = GBuffer::window(&world, 90, 50, 1, columns.clone(), rows.clone());
        let (points, pixels) = ours.read(&scene.camera, 90, 50, columns, rows).expect("points");
        // At this size no pixel's centre is at an edge.
        assert_eq!(pixels, want.pixels);
        let objects = |p: &[Receiver]| p.iter().map(|r| r.object).collect::<Vec<_>>();
        assert_eq!(objects(&points.receivers), objects(&want.points.receivers));
        assert_eq!(points.materials, want.points.materials);
    }
}

/// All work of a picture in a caller's encoder, in slices of different sizes, gives the same bits as separate submissions.
fn recorded(gpu: &Gpu) {
    let view = View::new(globes(), 1, 1);
    let frame = view.frame(0.003, 5);
    let occlusion = Occlusion { blockers: &[&view.spheres], any_hit: None };
    let mut ours = GpuGBuffer::new(gpu, &view.scene).expect("geometry");
    let mut pictures = Vec::new();
    for is_recorded in [false, true, true] {
        let mut shader = GpuShader::new(gpu, occlusion).expect("a shader").with_slice(1024);
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let points = match is_recorded {
            false => ours.trace(&view.scene.camera, 80, 45, 0..80, 0..45),
            true => ours.record(&view.scene.camera, [80, 45], 0..80, 0..45, &mut encoder),
        }
        .expect("points");
        assert!(points.count > 2 * 1024 && !points.count.is_multiple_of(1024));
        let size = 16 * u64::from(points.count);
        let buffer = |usage| {
            let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
            gpu.device().create_buffer(&descriptor)
        };
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let (radiance, staging) = (buffer(usage), buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST));
        match is_recorded {
            false => shader.submit(&frame, points.buffer, points.count, &radiance),
            true => shader.record(&frame, points.buffer, points.count, &radiance, &mut encoder),
        }
        .expect("the GPU shades");
        encoder.copy_buffer_to_buffer(&radiance, 0, &staging, 0, size);
        gpu.queue().submit([encoder.finish()]);
        staging.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
        gpu.device().poll(wgpu::PollType::wait_indefinitely()).expect("done");
        pictures.push(staging.slice(..).get_mapped_range().expect("mapped").to_vec());
    }
    assert!(pictures[0].iter().any(|byte| *byte != 0));
    assert!(pictures[0] == pictures[1] && pictures[1] == pictures[2]);
}

/// Points found and shaded on the GPU in a window that cuts tiles give the CPU's picture; pixels without a point stay empty.
fn shaded(gpu: &Gpu) {
    let view = View::new(globes(), 1, 1);
    let (columns, rows) = (3..77, 5..44);
    let window = GBuffer::window(&World::new(&view.scene), 80, 45, 1, columns.clone(), rows.clone());
    let frame = view.frame(0.003, 5);
    let mut want = vec![Vec3::ZERO; window.len()];
    let visibility = MaskVisibility::new(view.spheres.clone()).look_again(LookAgain::Never);
    CpuShader::new(visibility).shade(&window.points, &frame, &mut want).expect("room for all lobes");
    let want = window.resolve(&want, Vec3::ZERO);

    let occlusion = Occlusion { blockers: &[&view.spheres], any_hit: None };
    let mut shader = GpuShader::new(gpu, occlusion).expect("a shader");
    let mut ours = GpuGBuffer::new(gpu, &view.scene).expect("geometry");
    let points = ours.trace(&view.scene.camera, 80, 45, columns, rows).expect("points");
    let size = 16 * u64::from(points.count);
    let buffer = |usage| {
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        gpu.device().create_buffer(&descriptor)
    };
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let (radiance, staging) = (buffer(usage), buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST));
    shader.submit(&frame, points.buffer, points.count, &radiance).expect("the GPU shades");
    let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(&radiance, 0, &staging, 0, size);
    gpu.queue().submit([encoder.finish()]);
    staging.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let mapped = staging.slice(..).get_mapped_range().expect("mapped");
    let mut got = vec![Vec3::ZERO; want.len()];
    for (place, [r, g, b, _]) in bytemuck::cast_slice::<u8, [f32; 4]>(&mapped).iter().enumerate() {
        match points.pixel(place as u32) {
            Some(pixel) => got[pixel as usize] = Vec3::new(*r, *g, *b),
            None => assert_eq!([*r, *g, *b], [0.0; 3]),
        }
    }
    let peak = want.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let apart: Vec<f32> = want.iter().zip(&got).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    let (mean, largest) = (apart.iter().sum::<f32>() / apart.len() as f32, apart.iter().copied().fold(0.0, f32::max));
    println!("mean {mean:.1e}, largest {largest:.1e} of the peak");
    // Positions differ by rounding, and narrow lobes amplify it.
    assert!(window.len() < want.len() && mean < 1e-5 && largest < 5e-3);
}

fn nothing(gpu: &Gpu) {
    let mut scene = Scene { objects: Vec::new(), ..plain() };
    let mut ours = GpuGBuffer::new(gpu, &scene).expect("geometry");
    assert!(ours.read(&scene.camera, 33, 17, 0..33, 0..17).expect("points").1.is_empty());
    assert_eq!(ours.trace(&scene.camera, 33, 17, 0..33, 0..17).expect("points").count, 5 * 3 * 64);
    // An object outside the camera's view.
    scene.objects.push(Object::spheres("behind", vec![Sphere { center: Vec3::Z * 30.0, radius: 1.0 }], 0));
    ours.update(&scene).expect("geometry");
    assert!(ours.read(&scene.camera, 33, 17, 0..33, 0..17).expect("points").1.is_empty());
}

/// The eye inside a globe mesh and inside a sphere sees their inner sides.
fn from_inside(gpu: &Gpu) {
    let mut scene = globes();
    for eye in [Vec3::new(-1.0, 0.3, 0.2), Vec3::new(1.2, 0.5, 0.4), sphere(0.0, 0.12).center + 0.01] {
        scene.camera =
            Camera { eye, target: Vec3::new(0.3, 0.1, 3.0), up: Vec3::Y, projection: Projection::perspective(2.2) };
        let found = check(&mut GpuGBuffer::new(gpu, &scene).expect("geometry"), &scene, 100, 60);
        assert_eq!(found.points, 6000);
    }
}

fn scales(gpu: &Gpu) {
    for (scale, shift) in [(1e-4, 0.0), (1e4, 0.0), (1e-12, 0.0), (1.0, 100.0)] {
        let scene = placed(globes(), scale, Vec3::splat(shift));
        println!("scale {scale}, moved by {shift}");
        let found = check(&mut GpuGBuffer::new(gpu, &scene).expect("geometry"), &scene, 100, 60);
        assert!(found.points > 2000);
    }
}

/// After objects have moved, the result is that of a new hierarchy. Only moved data is uploaded.
fn motion(gpu: &Gpu) {
    let mut scene = globes();
    let mut ours = GpuGBuffer::new(gpu, &scene).expect("geometry");
    let all = ours.world().uploaded();
    ours.update(&scene).expect("geometry");
    assert_eq!(ours.world().uploaded(), 0);
    let Shape::Spheres(spheres) = &mut scene.objects[4].shape else { unreachable!("spheres") };
    spheres[0].center.y += 0.2;
    ours.update(&scene).expect("geometry");
    let few = ours.world().uploaded();
    assert!((1..all / 20).contains(&few), "{few} of {all} bytes for one sphere");
    check(&mut ours, &scene, 100, 60);
    for turn in [0.3, 2.0] {
        let Shape::Mesh(mesh) = &mut scene.objects[1].shape else { unreachable!("a mesh") };
        mesh.transform(&(Mat4::from_rotation_y(turn) * Mat4::from_translation(Vec3::Y * 0.1)));
        ours.update(&scene).expect("geometry");
        check(&mut ours, &scene, 100, 60);
    }
    // Different triangles.
    scene.objects.swap(1, 2);
    scene.objects.truncate(3);
    ours.update(&scene).expect("geometry");
    check(&mut ours, &scene, 100, 60);
}

/// No ray enters a closed surface of triangles smaller than pixels, nor passes a grid whose edges are at the rays.
fn no_cracks(gpu: &Gpu) {
    let mut scene = plain();
    scene.camera = Camera {
        eye: Vec3::new(0.3, 0.8, 4.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::perspective(0.45),
    };
    scene.objects = vec![Object::mesh("globe", globe(250, Vec3::ZERO, 1.0, false), 0, Proxy::None)];
    let mut ours = GpuGBuffer::new(gpu, &scene).expect("geometry");
    let (points, _) = ours.read(&scene.camera, 400, 400, 0..400, 0..400).expect("points");
    assert!(points.receivers.len() > 100_000);
    assert_eq!(points.receivers.iter().filter(|r| r.position.dot(r.view) < -0.02).count(), 0);

    let n = 16u32;
    let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
    let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| Vec3::new(at(x), at(y), 0.0))).collect();
    let quads = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
    let triangles = quads.flat_map(|i| [[i, i + 1, i + n + 2], [i, i + n + 2, i + n + 1]]).collect();
    let grid = Mesh { positions, triangles, ..Mesh::default() };
    scene.objects = vec![Object::mesh("grid", grid, 0, Proxy::None)];
    scene.camera =
        Camera { eye: Vec3::Z * 4.0, target: Vec3::ZERO, up: Vec3::Y, projection: Projection::perspective(0.4) };
    ours.update(&scene).expect("geometry");
    for size in [255, 256] {
        let (_, pixels) = ours.read(&scene.camera, size, size, 0..size, 0..size).expect("points");
        assert_eq!(pixels.len() as u32, size * size);
    }
}
