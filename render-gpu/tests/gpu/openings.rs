//! Rooms that are lit through an opening, on the GPU: each point sees a small part of a large light, and its radiance is right as a part of
//! itself, against the CPU's finest masks.

use crate::call::trial;
use crate::silhouettes::looking_again;
use brdf::{Material, MetallicRoughness, ModifiedPhong};
use glam::{UVec2, Vec3};
use libtest_mimic::Trial;
use lighting::{Environment, EnvironmentMap, FlatLight, Light, SphereLight};
use lobe_core::{LightImage, Sphere};
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SurfaceHits, World};
use render_gpu::Gpu;
use scene::{Camera, Frame, Mesh, Object, Projection, Proxy, Scene, Shade};
use shading::Accuracy;
use std::sync::Arc;
use test_scenes::{Opening, openings, room, room_with, with_door};
use visibility_mask::{LookAgain, MaskVisibility};
use visibility_silhouettes::SilhouetteBlockers;

const WINDOW: Opening = [-0.6, 0.6, -0.2, 0.8];
const SMALL: Opening = [-0.2, 0.2, 0.1, 0.5];
const SLIT: Opening = [-0.3, -0.28, -1.2, 0.8];
/// Of a door that is ajar.
const DOOR: Opening = [-0.45, 0.45, -1.5, 0.5];

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("a_room_behind_a_window", gpu, |gpu| diffuse(gpu, WINDOW, [0.004, 0.015], 0.01)),
        trial("a_room_behind_a_small_window", gpu, |gpu| diffuse(gpu, SMALL, [0.004, 0.015], 0.05)),
        trial("the_sky_behind_a_window", gpu, sky),
        trial("rooms_behind_a_slit_and_a_door", gpu, between_samples),
        trial("rooms_behind_many_openings", gpu, many),
        trial("glossy_walls_behind_a_window", gpu, glossy),
        trial("an_image_behind_a_window", gpu, image),
        trial("where_an_umbra_ends", gpu, where_an_umbra_ends),
    ]
}

fn square() -> FlatLight {
    FlatLight::rectangle(Vec3::new(0.0, 0.3, -12.5), Vec3::X * 11.0, Vec3::Y * 11.0, Vec3::ONE).expect("a square")
}

/// Mean and 99th percentile of the error of each point as a part of its own radiance: by the GPU, and by a CPU's single mask of the whole light.
fn own_errors(gpu: &Gpu, scene: &Scene, again: LookAgain) -> [[f32; 2]; 2] {
    let world = World::new(scene);
    let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
    let frame = |accuracy| Frame { materials: &scene.materials, lights: &scene.lights, accuracy, threshold: 0.0 };
    let (got, _) = looking_again(gpu, scene, (&points, &frame(Accuracy::default())), again);
    let silhouettes = SceneSilhouettes::new(scene, |_| true);
    let by_cpu = |accuracy, again| {
        let blockers = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |_| true));
        let mut out = vec![Vec3::ZERO; got.len()];
        CpuShader::new(MaskVisibility::new(blockers).look_again(again))
            .shade(&points, &frame(accuracy), &mut out)
            .expect("room");
        out
    };
    let want = by_cpu(Accuracy::new(0.0003), LookAgain::Everywhere);
    let white = want.iter().map(|want| want.y).fold(0.0, f32::max);
    [&got, &by_cpu(Accuracy::default(), LookAgain::Never)].map(|got| {
        let seen = want.iter().zip(got).filter(|(want, _)| want.y > 1e-3 * white);
        let mut errors: Vec<f32> = seen.map(|(want, got)| (got.y / want.y - 1.0).abs()).collect();
        errors.sort_unstable_by(f32::total_cmp);
        [errors.iter().sum::<f32>() / errors.len() as f32, errors[errors.len() * 99 / 100]]
    })
}

/// The errors are within bounds, and by one mask of the whole light they are not.
fn check(gpu: &Gpu, name: &str, scene: &Scene, most: [f32; 2], alone: f32) {
    let [with, without] = own_errors(gpu, scene, LookAgain::Openings);
    println!("{name}: {without:?} by one mask, {with:?}");
    assert!(with[0] <= most[0] && with[1] <= most[1], "{name}: {with:?}");
    assert!(without[0] >= alone, "{name}: {without:?}");
}

fn diffuse(gpu: &Gpu, opening: Opening, most: [f32; 2], alone: f32) {
    check(gpu, "square", &room(opening, square().into()), most, alone);
    let sphere = Sphere { center: Vec3::new(0.0, 0.3, -12.5), radius: 6.0 };
    let light = Light::from(SphereLight::new(sphere, Vec3::ONE));
    let scene = room(opening, light);
    let [with, without] = own_errors(gpu, &scene, LookAgain::Everywhere);
    println!("sphere: {without:?} by one mask, {with:?}");
    assert!(with[0] <= 0.003 && with[1] <= 0.01 && without[0] >= alone, "sphere: {with:?} {without:?}");
}

/// In patches, of which a window shows parts of a few.
fn sky(gpu: &Gpu) {
    let world = Sphere { center: Vec3::ZERO, radius: 20.0 };
    for (name, opening, most) in [("window", WINDOW, [0.001, 0.005]), ("small window", SMALL, [0.001, 0.008])] {
        let mut scene = room(opening, square().into());
        scene.lights = Environment::new(EnvironmentMap::uniform(Vec3::ONE), 2, world).lights().to_vec();
        check(gpu, &format!("sky, {name}"), &scene, most, 0.03);
    }
}

/// Openings that few samples of a mask meet, or none.
fn between_samples(gpu: &Gpu) {
    check(gpu, "slit", &room(SLIT, square().into()), [0.006, 0.02], 0.25);
    check(gpu, "door", &with_door(room(DOOR, square().into()), DOOR), [0.008, 0.03], 0.3);
}

/// Of which masks see some and miss others; and a slit before lights that are narrower than 17° to each side.
fn many(gpu: &Gpu) {
    let globe = |radius: f32| -> Light {
        SphereLight::new(Sphere { center: Vec3::new(0.0, 0.3, -12.5), radius }, Vec3::ONE).into()
    };
    let holes = openings([3, 3], [0.03, 0.03], [0.3, 0.27]);
    let slits = openings([20, 1], [0.012, 0.9], [0.06, 0.0]);
    let level = openings([1, 8], [1.2, 0.01], [0.0, 0.11]);
    for (name, openings) in [("9 holes", holes), ("20 slits", slits), ("8 level slits", level)] {
        check(gpu, &format!("{name}, square"), &room_with(&openings, square().into()), [0.006, 0.02], 0.1);
        check(gpu, &format!("{name}, sphere"), &room_with(&openings, globe(6.0)), [0.006, 0.02], 0.1);
    }
    // A CPU divides by the closed integral of the sphere, a GPU by its samples.
    for (radius, degrees) in [(3.2, 15), (1.9, 9)] {
        check(gpu, &format!("slit, sphere of {degrees}°"), &room(SLIT, globe(radius)), [0.006, 0.03], 0.1);
    }
}

/// Masks of the whole light are stored for several lobes.
fn glossy(gpu: &Gpu) {
    let mut scene = room(WINDOW, square().into());
    scene.materials = vec![ModifiedPhong { kd: Vec3::splat(0.5), ks: Vec3::splat(0.1), exponent: 3.0 }.into()];
    check(gpu, "modified Phong", &scene, [0.004, 0.015], 0.01);
    let door = with_door(room(DOOR, square().into()), DOOR);
    for (name, mut beside) in [("slit", room(SLIT, square().into())), ("door", door)] {
        beside.materials.clone_from(&scene.materials);
        check(gpu, &format!("modified Phong, {name}"), &beside, [0.008, 0.03], 0.2);
    }
    let metal: Material = MetallicRoughness::new(Vec3::splat(0.8), 0.0, 1.0).expect("in range").into();
    scene.materials = vec![metal];
    check(gpu, "metallic roughness", &scene, [0.004, 0.015], 0.01);
}

/// By channel, through the same masks.
fn image(gpu: &Gpu) {
    let texels = [Vec3::new(2.0, 1.0, 0.5), Vec3::ONE, Vec3::new(0.5, 1.0, 1.5), Vec3::new(0.5, 1.2, 1.0)];
    let (image, _) = LightImage::new(UVec2::splat(2), &texels).expect("an image");
    let light = square().showing(Arc::new(image)).expect("a rectangle");
    // A CPU divides by the integral that the light takes, whose error then goes; a GPU by the sum over its masks.
    check(gpu, "image", &room(WINDOW, light.into()), [0.009, 0.02], 0.04);
}

/// A crate below a square: where its umbra ends little of the light is seen, on both sides of the crate and at all sides of the light.
fn where_an_umbra_ends(gpu: &Gpu) {
    let light = FlatLight::rectangle(Vec3::Y * 8.0, Vec3::X * 2.0, Vec3::Z * 2.0, Vec3::ONE).expect("a square");
    let mut scene = room(WINDOW, light.into());
    let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 30.0, Vec3::NEG_Z * 30.0);
    let block = Mesh::cuboid(Vec3::new(-0.036_157, 0.2, 9.859_153), Vec3::new(0.15, 0.4, 0.15));
    scene.objects = [("floor", floor), ("crate", block)]
        .into_iter()
        .map(|(name, mesh)| Object::mesh(name, mesh, 0, Proxy::None))
        .collect();
    scene.camera = Camera {
        eye: Vec3::new(-0.036_157, 2.0, 11.5),
        target: Vec3::new(-0.036_157, 0.0, 10.42),
        projection: Projection::perspective(0.105),
        ..scene.camera
    };
    let [with, _] = own_errors(gpu, &scene, LookAgain::Openings);
    println!("umbra: {with:?}");
    assert!(with[0] <= 0.005 && with[1] <= 0.03, "{with:?}");
}
