//! Light at points of the caller's.

use glam::Vec3;
use lighting::{Environment, EnvironmentMap, FlatLight, SphereLight};
use lobe_core::{NO_OBJECT, Random, Receiver, Sphere};
use ray_tracing::{GBuffer, World};
use renderer::{LayerSet, RenderError, Renderer, Settings};
use scene::{Animation, Cancel, Mesh, Object, Proxy, Scene, ShadingPoints, Strategy};
use test_scenes::{floor_and_sphere, globe, material};

const LIGHTS: LayerSet = LayerSet { unshadowed: true, lights: true, ..LayerSet::NONE };

/// A floor, a sphere and a mesh under a sphere light and a rectangle.
fn stage() -> Scene {
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (96, 54);
    scene.materials.push(material());
    let center = Vec3::new(-0.9, 0.8, 0.5);
    scene.objects.push(Object::mesh("globe", globe(24, center, 0.5, true), 1, Proxy::Count(16)));
    let panel = FlatLight::rectangle(Vec3::new(-2.0, 2.5, 0.0), Vec3::X * 0.5, Vec3::Z * 0.4, Vec3::ONE);
    scene.lights.push(panel.expect("a rectangle").into());
    scene
}

fn under_a_sky() -> Scene {
    let mut scene = stage();
    let world = Sphere { center: Vec3::ZERO, radius: 9.0 };
    let environment = Environment::new(EnvironmentMap::uniform(Vec3::new(0.3, 0.4, 0.5)), 2, world);
    scene.lights.extend_from_slice(environment.lights());
    scene.environment = Some(environment.into());
    scene
}

fn renderer(scene: Scene, strategy: Option<Strategy>) -> Renderer {
    let settings = Settings { strategy, layers: LIGHTS, ..Settings::default() };
    Renderer::new(scene, Animation::default(), settings).expect("a scene")
}

/// The points of the picture, in another order, and that order.
fn shuffled(world: &World<'_>) -> (GBuffer, ShadingPoints, Vec<usize>) {
    let scene = world.scene();
    let g = GBuffer::new(world, scene.width, scene.height, 1);
    let mut order: Vec<usize> = (0..g.len()).collect();
    let mut random = Random::new(7);
    (1..order.len()).rev().for_each(|i| order.swap(i, random.bits() as usize % (i + 1)));
    let points = ShadingPoints {
        receivers: order.iter().map(|i| g.points.receivers[*i]).collect(),
        materials: order.iter().map(|i| g.points.materials[*i]).collect(),
        ..ShadingPoints::default()
    };
    (g, points, order)
}

#[test]
fn points_of_the_picture_have_its_light() {
    let cases = [
        (stage(), None),
        (stage(), Some(Strategy::Rays)),
        (stage(), Some(Strategy::Spheres)),
        (stage(), Some(Strategy::ShadowMap)),
        (under_a_sky(), None),
    ];
    for (scene, strategy) in cases {
        let mut renderer = renderer(scene, strategy);
        let image = renderer.render().expect("a picture");
        let (g, points, order) = renderer.with_world(shuffled);
        let light = renderer.shade_points(points, None, LIGHTS).expect("light");
        assert_eq!((light.radiance.len(), light.lights.len()), (g.len(), renderer.scene().lights.len()));
        for (k, i) in order.iter().enumerate() {
            let pixel = g.pixels[*i] as usize;
            let context = format!("{strategy:?}, pixel {pixel}");
            assert_eq!(light.radiance[k], image.radiance[pixel], "{context}");
            assert_eq!(light.unshadowed[k], image.layers.unshadowed[pixel], "{context}");
            for (part, layer) in light.lights.iter().zip(&image.layers.lights) {
                assert_eq!(part[k], layer[pixel], "{context}");
            }
        }
    }
}

/// Under a sphere of radiance L the irradiance is π L (r/d)², whatever the tolerance is.
#[test]
fn white_points_have_the_irradiance_over_pi() {
    let mut scene = floor_and_sphere();
    let lamp = Sphere { center: Vec3::new(7.0, 2.0, 0.0), radius: 0.5 };
    scene.lights = vec![SphereLight::new(lamp, Vec3::splat(3.0)).into()];
    let mut renderer = renderer(scene, None);
    let at = Receiver::on_surface(Vec3::new(7.0, 0.0, 0.0), Vec3::Y, Vec3::Y);
    let points = ShadingPoints { receivers: vec![at], materials: vec![0], ..ShadingPoints::default() };
    let white = [brdf::Material::lambert(Vec3::ONE)];
    let light = renderer.shade_points(points, Some(&white), LayerSet::NONE).expect("light");
    assert!((light.radiance[0].x - 3.0 / 16.0).abs() < 1e-4, "{}", light.radiance[0]);
    assert!(light.unshadowed.is_empty() && light.lights.is_empty());
}

/// Ambient occlusion in closed form: a sphere of radius r at a distance d hides `cos·(r/d)²` of a Lambert point's light, and a point
/// beside a wall without end sees half of it.
#[test]
fn ambient_light_is_hidden() {
    let mut scene = floor_and_sphere();
    let radius = 0.5;
    scene.objects.truncate(1);
    let center = Vec3::new(0.0, 1.5, 0.0);
    scene.objects.push(Object::mesh("globe", globe(96, center, radius, true), 0, Proxy::None));
    let world = Sphere { center: Vec3::ZERO, radius: 9.0 };
    let environment = Environment::with_ambient(None, Vec3::splat(0.8), 1, world);
    scene.lights = environment.lights().to_vec();
    scene.environment = Some(environment.into());
    let mut renderer = renderer(scene, None);
    let at = |x: f32| Receiver::on_surface(Vec3::new(x, 0.0, 0.0), Vec3::Y, Vec3::Y);
    let receivers: Vec<Receiver> = [0.0, 0.3, 0.8, 2.0].map(at).to_vec();
    let points = ShadingPoints { materials: vec![0; receivers.len()], receivers, ..ShadingPoints::default() };
    let white = [brdf::Material::lambert(Vec3::ONE)];
    let light = renderer.shade_points(points.clone(), Some(&white), LayerSet::NONE).expect("light");
    for (at, got) in points.receivers.iter().zip(&light.radiance) {
        let to = center - at.position;
        let hidden = to.normalize().y * (radius * radius / to.length_squared());
        let want = 0.8 * (1.0 - hidden);
        assert!((got.x - want).abs() < 0.003, "{}: {} for {want}", at.position, got.x);
    }
}

#[test]
fn wrong_points_are_refused() {
    let mut renderer = renderer(stage(), None);
    let good = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
    let mut shade = |at: Receiver, materials: Vec<u32>| {
        let points = ShadingPoints { receivers: vec![at], materials, ..ShadingPoints::default() };
        match renderer.shade_points(points, None, LayerSet::NONE) {
            Err(RenderError::Setting { expected, .. }) => Some(expected),
            Err(error) => panic!("{error}"),
            Ok(_) => None,
        }
    };
    assert_eq!(shade(good, vec![0]), None);
    assert_eq!(shade(good, vec![]), Some("one number of a material each"));
    assert_eq!(shade(good, vec![9]), Some("a material that exists"));
    assert_eq!(shade(good.on_object(99), vec![0]), Some("an object of the scene, or none"));
    assert_eq!(shade(Receiver { position: Vec3::NAN, ..good }, vec![0]), Some("finite coordinates"));
    for bad in [Vec3::ZERO, Vec3::Y * 2.0, Vec3::NAN] {
        assert_eq!(shade(Receiver { normal: bad, ..good }, vec![0]), Some("unit vectors"));
        assert_eq!(shade(Receiver { face: bad, ..good }, vec![0]), Some("unit vectors"));
        assert_eq!(shade(Receiver { view: bad, ..good }, vec![0]), Some("unit vectors"));
    }
    assert_eq!(good.object, NO_OBJECT);
}

#[test]
fn shading_points_keeps_what_pictures_keep_and_can_be_stopped() {
    let mut renderer = renderer(stage(), None);
    let before = renderer.render().expect("a picture");
    let upkeep = renderer.upkeep();
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
    let points = || ShadingPoints { receivers: vec![at; 200], materials: vec![0; 200], ..ShadingPoints::default() };
    renderer.shade_points(points(), None, LayerSet::NONE).expect("light");
    let stop = Cancel::new();
    stop.cancel();
    renderer.set_cancel(stop);
    assert!(matches!(renderer.shade_points(points(), None, LayerSet::NONE), Err(RenderError::Cancelled)));
    renderer.set_cancel(Cancel::new());
    renderer.set_layers(LayerSet::NONE).expect("layers");
    let after = renderer.render().expect("a picture");
    assert!(after.layers.lights.is_empty() && after.radiance == before.radiance);
    assert_eq!(renderer.upkeep(), upkeep);
    assert_eq!(renderer.stale().names().count(), 0);
}

/// A plate that nothing stands behind hides light from points behind it all the same.
#[test]
fn points_behind_a_plate_are_in_its_shadow() {
    let mut scene = scene::builtin();
    scene.environment = None;
    let plate = Mesh::quad(Vec3::ZERO, Vec3::X * 4.0, Vec3::Z * 4.0);
    scene.objects = vec![Object::mesh("plate", plate, 0, Proxy::None)];
    scene.lights = vec![SphereLight::new(Sphere { center: Vec3::Y * 3.0, radius: 0.2 }, Vec3::ONE).into()];
    let mut renderer = Renderer::new(scene, Animation::default(), Settings::default()).unwrap();
    let white = [brdf::Material::lambert(Vec3::ONE)];
    let mut light = |y: f32| {
        let receivers = vec![Receiver::on_surface(Vec3::Y * y, Vec3::Y, Vec3::Y)];
        let points = ShadingPoints { receivers, materials: vec![0], ..ShadingPoints::default() };
        renderer.shade_points(points, Some(&white), LayerSet::NONE).unwrap().radiance[0].x
    };
    assert!(light(1.0) > 0.0);
    assert_eq!(light(-1.0), 0.0);
    assert!(light(1.0) > 0.0);
}

/// A wall beside a panel sees a part of it above its own horizon, and of that what a sill along the panel's side leaves: the two cross at right angles, and
/// neither may run along the rows of a mask, which would count whole rows (2 % of the light).
#[test]
fn a_sill_hides_a_panel_that_the_horizon_cuts() {
    let mut scene = scene::builtin();
    scene.environment = None;
    let sill = Mesh::cuboid(Vec3::new(-2.1, 0.45, -0.9), Vec3::new(0.2, 0.9, 1.2));
    scene.objects = vec![Object::mesh("sill", sill, 0, Proxy::None)];
    let (u, v) = (Vec3::Y * 0.5, Vec3::Z * 0.6);
    let panel = FlatLight::rectangle(Vec3::new(-2.2, 1.4, -0.9), u, v, Vec3::ONE).expect("a rectangle");
    scene.lights = vec![panel.into()];
    let mut renderer = renderer(scene, None);
    let places = (0..240).map(|k| Vec3::new(-1.3 + 0.15 * (k % 20) as f32, 0.84 - 0.04 * (k / 20) as f32, -0.8));
    let receivers = places.map(|p| Receiver::on_surface(p, Vec3::Z, Vec3::Z)).collect::<Vec<_>>();
    let points = ShadingPoints { materials: vec![0; receivers.len()], receivers, ..ShadingPoints::default() };
    let white = [brdf::Material::lambert(Vec3::ONE)];
    let light = renderer.shade_points(points.clone(), Some(&white), LIGHTS).expect("light");
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for (k, at) in points.receivers.iter().enumerate() {
        let p = at.position.as_dvec3();
        // Where the line over the sill's inner edge meets the panel.
        let low = p.y + (0.9 - p.y) * (-2.2 - p.x) / (-2.0 - p.x);
        const STEPS: u32 = 300;
        let (mut seen, mut whole) = (0.0, 0.0);
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS).map(move |j| (i, j))) {
            let [s, t] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(STEPS));
            let (y, z) = (0.9 + s, p.z + t * (-0.3 - p.z));
            let d = glam::DVec3::new(-2.2, y, z) - p;
            let part = d.z * -d.x / d.length_squared().powi(2);
            whole += part;
            // The row that the line cuts counts in part.
            seen += part * ((0.9 + (s + 0.5 / f64::from(STEPS)) - low) * f64::from(STEPS)).clamp(0.0, 1.0);
        }
        let scale = (-0.3 - p.z) / f64::from(STEPS * STEPS) * core::f64::consts::FRAC_1_PI;
        assert!((f64::from(light.unshadowed[k].x) - whole * scale).abs() < 1e-3 * whole * scale, "{p}");
        let error = (f64::from(light.radiance[k].x) - seen * scale).abs() / (whole * scale);
        (sum, most) = (sum + error, most.max(error));
    }
    let mean = sum / points.receivers.len() as f64;
    assert!(mean < 0.002 && most < 0.008, "{mean} {most}");
}

/// The floor of a room under a uniform sky has the light of a panel in its window, also where a reflection shows little but the window: all of the
/// lobe is seen there, through few samples of the sky.
#[test]
fn a_window_is_mirrored_as_the_panel_that_fills_it() {
    let (window, outside) = ([-0.6, 0.6, -0.3, 0.7], -test_scenes::ROOM.z - 1e-4);
    let panel = FlatLight::rectangle(Vec3::new(0.0, 0.2, outside), Vec3::X * 0.6, Vec3::Y * 0.5, Vec3::ONE);
    let with_panel = test_scenes::room(window, panel.expect("a rectangle").into());
    let world = Sphere { center: Vec3::ZERO, radius: 9.0 };
    let sky = Environment::new(EnvironmentMap::uniform(Vec3::ONE), 2, world);
    let mut under_sky = Scene { lights: sky.lights().to_vec(), ..with_panel.clone() };
    under_sky.environment = Some(sky.into());
    let floor = |k: u32| Vec3::new(-1.4 + 0.1 * (k % 29) as f32, -test_scenes::ROOM.y, -2.2 + 0.1 * (k / 29) as f32);
    let eye = Vec3::new(0.3, 0.5, 2.2);
    let at = |p: Vec3| Receiver { view: (eye - p).normalize(), ..Receiver::on_surface(p, Vec3::Y, Vec3::Y) };
    let receivers: Vec<Receiver> = (0..29 * 40).map(|k| at(floor(k))).collect();
    let points = ShadingPoints { materials: vec![0; receivers.len()], receivers, ..ShadingPoints::default() };
    let [mut sky, mut panel] = [under_sky, with_panel].map(|scene| renderer(scene, None));
    let phong = |exponent| brdf::ModifiedPhong { kd: Vec3::ZERO, ks: Vec3::ONE, exponent }.into();
    let metal = brdf::MetallicRoughness::new(Vec3::ONE, 1.0, 0.2).expect("a metal").into();
    let diffuse = brdf::Material::lambert(Vec3::ONE);
    for (material, limit) in [(diffuse, 0.02), (phong(8.0), 0.01), (phong(40.0), 0.01), (metal, 0.01)] {
        let materials = [material];
        let [got, want] = [&mut sky, &mut panel].map(|renderer| {
            renderer.shade_points(points.clone(), Some(&materials), LayerSet::NONE).expect("light").radiance
        });
        let most = want.iter().map(|v| v.x).fold(0.0, f32::max);
        let bright = || got.iter().zip(&want).filter(|(_, want)| want.x > 0.05 * most);
        let errors = bright().map(|(got, want)| (got.x / want.x - 1.0).abs());
        let (mean, largest) = (errors.clone().sum::<f32>() / bright().count() as f32, errors.fold(0.0, f32::max));
        println!("{}: {mean} {largest}", materials[0].name());
        assert!(mean < 0.002 && largest < limit, "{}: {mean} {largest}", materials[0].name());
    }
}
