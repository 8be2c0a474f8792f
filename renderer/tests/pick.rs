//! The surface that a pixel shows, and the visible fraction of a light at a point.

use core::ops::ControlFlow;
use glam::Vec3;
use lighting::{EnclosedLight, FlatLight, Light, SphereLight, TubeLight};
use lobe_core::{Random, Receiver, Sphere};
use ray_tracing::World;
use renderer::{LayerSet, LightHandle, Renderer, Settings, Window};
use scene::{Animation, Mesh, Object, Projection, Proxy, Scene, Strategy};
use test_scenes::{floor_and_sphere, globe, material};

/// A floor, a sphere, a mesh, and lamps, two of which are visible.
fn stage() -> Scene {
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (96, 54);
    scene.materials.push(material());
    let center = Vec3::new(-0.9, 0.8, 0.5);
    scene.objects.push(Object::mesh("globe", globe(24, center, 0.5, true), 1, Proxy::None));
    let lamp = Sphere { center: Vec3::new(1.3, 0.6, 1.0), radius: 0.3 };
    scene.objects.push(Object::spheres("lamp", vec![lamp], 0));
    scene.lights.push(SphereLight::new(lamp, Vec3::ONE).into());
    let (middle, u, v) = (Vec3::new(-2.0, 1.0, -1.0), Vec3::X * 0.5, Vec3::Y * 0.4);
    scene
        .objects
        .push(Object { proxy: Proxy::None, ..Object::mesh("panel", Mesh::quad(middle, u, v), 0, Proxy::None) });
    scene.lights.push(FlatLight::rectangle(middle, u, v, Vec3::ONE).expect("a rectangle").into());
    scene
}

fn renderer(scene: Scene, strategy: Option<Strategy>) -> Renderer {
    let settings = Settings { strategy, layers: LayerSet { objects: true, ..LayerSet::NONE }, ..Settings::default() };
    Renderer::new(scene, Animation::default(), settings).expect("a scene")
}

/// The point under a pixel is on that pixel's ray, and its distance is the length of the ray.
#[test]
fn picks_by_other_projections() {
    let mut scene = stage();
    scene.camera.eye = Vec3::new(0.5, 1.5, 3.0);
    for projection in [scene.camera.projection, Projection::Orthographic { height: 4.0 }, Projection::Panoramic] {
        scene.camera.projection = projection;
        let mut edited = renderer(scene.clone(), None);
        let mut seen = 0;
        for (x, y) in [(10, 40), (48, 30), (60, 27), (80, 50)] {
            let Some(pick) = edited.pick(x, y) else { continue };
            let at = [x, y].map(|k| k as f32 + 0.5);
            let start = scene.camera.start(at[0], at[1], 96, 54);
            let ray = scene.camera.direction(at[0], at[1], 96, 54);
            let want = start + pick.distance * ray;
            assert!(
                (pick.receiver.position - want).length() < 1e-4,
                "{projection:?}: {} {want}",
                pick.receiver.position
            );
            assert!((pick.receiver.view + ray).length() < 1e-4);
            assert!(!edited.reflectance(x, y).is_empty());
            seen += 1;
        }
        assert!(seen >= 2, "{projection:?}");
    }
}

#[test]
fn pixels_show_the_objects_of_the_picture() {
    let mut edited = renderer(stage(), None);
    let image = edited.render().expect("a picture");
    let objects: Vec<_> = edited.objects().map(|(handle, object)| (handle, object.clone())).collect();
    let lights: Vec<LightHandle> = edited.lights().map(|(handle, _)| handle).collect();
    let materials: Vec<_> = edited.materials().map(|(handle, _)| handle).collect();
    let points = render_points(&edited);
    let mut seen = vec![0; objects.len()];
    for (i, object) in image.layers.objects.iter().enumerate() {
        let (x, y) = ((i % 96) as u32, (i / 96) as u32);
        let pick = edited.pick(x, y);
        let Some((handle, object)) = objects.get(*object as usize) else {
            assert_eq!(pick, None);
            continue;
        };
        let pick = pick.expect("an object");
        assert_eq!((pick.object, pick.material), (*handle, materials[object.material]));
        assert_eq!(pick.receiver, points[i].expect("a point"));
        assert!((pick.distance - pick.receiver.position.distance(edited.scene().camera.eye)).abs() < 1e-5);
        let want = match object.name.as_str() {
            "lamp" => Some(lights[1]),
            "panel" => Some(lights[2]),
            _ => None,
        };
        assert_eq!(pick.light, want, "{}", object.name);
        seen[pick.receiver.object as usize] += 1;
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
    assert_eq!((edited.pick(96, 0), edited.pick(0, 54)), (None, None));
}

/// The point of each pixel.
fn render_points(renderer: &Renderer) -> Vec<Option<Receiver>> {
    let (scene, mut all) = (renderer.scene(), vec![None; 96 * 54]);
    let found = ray_tracing::GBuffer::new(&World::new(scene), 96, 54, 1);
    found.pixels.iter().zip(&found.points.receivers).for_each(|(pixel, at)| all[*pixel as usize] = Some(*at));
    all
}

/// Handles stay the same while others are added and removed; a light inside an object belongs to the object.
#[test]
fn picks_follow_edits() {
    let mut scene = stage();
    let center = Vec3::new(-0.9, 0.8, 0.5);
    let inner: Light = TubeLight { ends: [center, center + Vec3::X * 0.1], radius: 0.2, radiance: Vec3::ONE }.into();
    scene.lights.push(EnclosedLight { light: Box::new(inner), object: 2 }.into());
    let mut edited = renderer(scene, None);
    let (globe, inside) = (edited.objects().nth(2).expect("the globe").0, edited.lights().nth(3).expect("a light").0);
    let find = |edited: &mut Renderer| {
        let pixels = (0..54).flat_map(|y| (0..96).map(move |x| (x, y)));
        let picks: Vec<_> = pixels.filter_map(|(x, y)| edited.pick(x, y)).filter(|pick| pick.object == globe).collect();
        assert!(picks.len() > 20 && picks.iter().all(|pick| pick.light == Some(inside)));
        picks.iter().map(|pick| pick.receiver.position).sum::<Vec3>() / picks.len() as f32
    };
    let before = find(&mut edited);
    let first = edited.objects().nth(1).expect("a sphere").0;
    edited.remove_object(first).expect("a sphere");
    edited.set_transform(globe, glam::Mat4::from_translation(Vec3::X * 0.5)).expect("a shift");
    let after = find(&mut edited);
    assert!((after - before - Vec3::X * 0.5).length() < 0.1, "{before} {after}");
}

/// The visible fraction by sampling `n` points of the light, as a receiver sees it.
fn sampled(scene: &Scene, at: &Receiver, light: &Light, n: u32) -> f64 {
    let world = World::new(scene);
    let start = world.leave(at.position, at.face);
    let (mut seen, mut all) = (0.0, 0.0);
    let mut random = Random::new(11);
    for k in 0..n * n {
        let s = (f64::from(k % n) + random.uniform()) / f64::from(n);
        let t = (f64::from(k / n) + random.uniform()) / f64::from(n);
        let (direction, distance, weight) = match light {
            Light::Sphere(light) => {
                let to = light.sphere.center - at.position;
                let sin_sq = f64::from(light.sphere.radius * light.sphere.radius / to.length_squared());
                let one_minus_cos = s * (1.0 - (1.0 - sin_sq).sqrt());
                let (cos, sin) = (1.0 - one_minus_cos, (one_minus_cos * (2.0 - one_minus_cos)).sqrt());
                let (axis, phi) = (to.normalize(), core::f64::consts::TAU * t);
                let (u, v) = axis.any_orthonormal_pair();
                let d = axis * cos as f32 + (u * phi.cos() as f32 + v * phi.sin() as f32) * sin as f32;
                // The near surface: points inside the light do not count.
                let along = to.dot(d);
                let near =
                    along - (light.sphere.radius.powi(2) - (to.length_squared() - along * along)).max(0.0).sqrt();
                (d, near, f64::from(at.normal.dot(d)).max(0.0))
            }
            Light::Flat(flat) => {
                let c = flat.corners();
                let to = c[0] + (c[1] - c[0]) * s as f32 + (c[3] - c[0]) * t as f32 - start;
                let d = to.normalize();
                let weight = at.normal.dot(d).max(0.0) * (-flat.normal().dot(d)).max(0.0) / to.length_squared();
                (d, to.length() * 0.9999, f64::from(weight))
            }
            _ => unreachable!("no other kinds here"),
        };
        all += weight;
        if !world.occluded(start, direction, distance) {
            seen += weight;
        }
    }
    if all > 0.0 { seen / all } else { 0.0 }
}

#[test]
fn fractions_are_those_of_ray_tracing() {
    let mut scene = floor_and_sphere();
    let center = Vec3::new(-0.9, 0.8, 0.5);
    scene.objects.push(Object::mesh("globe", globe(24, center, 0.5, false), 0, Proxy::Count(8)));
    let panel = FlatLight::rectangle(Vec3::new(-1.0, 3.0, 0.0), Vec3::X * 0.6, Vec3::Z * 0.4, Vec3::ONE);
    scene.lights.push(panel.expect("a rectangle").into());
    for strategy in [None, Some(Strategy::Rays), Some(Strategy::ShadowMap)] {
        let mut edited = renderer(scene.clone(), strategy);
        let lights: Vec<_> = edited.lights().map(|(handle, light)| (handle, light.clone())).collect();
        let (mut partial, mut error, mut count) = (0, 0.0, 0);
        for k in 0..80 {
            let position = Vec3::new(-2.4 + 0.33 * (k % 10) as f32, 0.0, -1.5 + 0.4 * (k / 10) as f32);
            let at = Receiver { object: 0, ..Receiver::on_surface(position, Vec3::Y, Vec3::Y) };
            for (handle, light) in &lights {
                let got = edited.visible_fraction(&at, *handle).expect("a light");
                assert!(got.x == got.y && got.y == got.z);
                let want = sampled(&scene, &at, light, 48);
                let off = (f64::from(got.x) - want).abs();
                // The error of the mask's cells and the samples together; shadow maps err by their texels near an outline.
                assert!(off <= 0.04, "{strategy:?}: {position}: {got} for {want}");
                partial += usize::from((0.05..0.95).contains(&want));
                (error, count) = (error + off, count + 1);
            }
        }
        assert!(partial > 15, "{partial}");
        assert!(error / f64::from(count) <= 0.004, "{strategy:?}: mean {}", error / f64::from(count));
    }
}

#[test]
fn fractions_at_the_ends() {
    let scene = stage();
    for strategy in [None, Some(Strategy::Spheres), Some(Strategy::None), Some(Strategy::ShadowMap)] {
        let mut edited = renderer(scene.clone(), strategy);
        let light = edited.lights().next().expect("a light").0;
        let mut fraction = |at: Vec3, normal: Vec3| {
            edited.visible_fraction(&Receiver::on_surface(at, normal, normal), light).expect("a light")
        };
        // Beside all blockers, far outside the camera's view; below the horizon; directly under the sphere.
        assert_eq!(fraction(Vec3::new(3.9, 0.0, 3.0), Vec3::Y), Vec3::ONE, "{strategy:?}");
        assert_eq!(fraction(Vec3::new(0.0, 20.0, 0.0), Vec3::NEG_Y), Vec3::ONE, "{strategy:?}");
        assert_eq!(fraction(Vec3::new(0.0, 20.0, 0.0), Vec3::Y), Vec3::ZERO, "{strategy:?}");
        let under = fraction(Vec3::new(-0.1, 0.45, -0.05), Vec3::Y);
        assert_eq!(under, if strategy == Some(Strategy::None) { Vec3::ONE } else { Vec3::ZERO }, "{strategy:?}");
        edited.remove_light(light).expect("a light");
        assert!(edited.visible_fraction(&Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y), light).is_err());
    }
}

/// Queries change no picture.
#[test]
fn pictures_are_the_same_after_questions() {
    let mut edited = renderer(stage(), Some(Strategy::ShadowMap));
    let want = renderer(stage(), Some(Strategy::ShadowMap)).render().expect("a picture").radiance;
    let light = edited.lights().next().expect("a light").0;
    for (x, y) in [(50, 30), (20, 40)] {
        let at = edited.pick(x, y).expect("an object").receiver;
        edited.visible_fraction(&at, light).expect("a light");
    }
    let whole = Window::whole(96, 54);
    let mut pixels = vec![Vec3::ZERO; whole.pixels()];
    edited.render_into(&whole, &mut |_| ControlFlow::Continue(()), &mut pixels).expect("a picture");
    assert!(pixels == want);
}

/// An interactive program renders on a thread of its own.
#[test]
fn renderers_go_to_other_threads() {
    let mut edited = renderer(stage(), None);
    let image = std::thread::spawn(move || edited.render().expect("a picture")).join().expect("a thread");
    assert_eq!(image.size, [96, 54]);
}

/// The lit part of a mask is about the visible fraction, and without blockers the parts of the lights are those of the picture.
#[test]
fn masks_show_the_visible_fraction() {
    let mut renderer = Renderer::new(scene::builtin(), Animation::default(), Settings::default()).expect("a scene");
    let lights: Vec<LightHandle> = renderer.lights().map(|(handle, _)| handle).collect();
    let (mut partial, mut worst) = (0, 0.0_f32);
    for (x, y) in [(695, 371), (300, 470), (250, 490), (640, 360), (700, 380), (400, 500), (480, 430), (760, 395)] {
        let pick = renderer.pick(x, y).expect("a surface");
        let unshadowed = renderer.unshadowed(x, y);
        assert_eq!(unshadowed.len(), lights.len());
        for (light, whole) in lights.iter().zip(&unshadowed) {
            let fraction = renderer.visible_fraction(&pick.receiver, *light).expect("a fraction").x;
            let mask = renderer.light_mask(&pick.receiver, *light).expect("a mask");
            assert_eq!(mask.samples.len(), mask.size[0] * mask.size[1]);
            if *whole == Vec3::ZERO {
                continue;
            }
            match fraction {
                0.0 => assert!(mask.lit() < 0.01, "{x} {y}: {}", mask.lit()),
                1.0 => assert!(mask.lit() > 0.99, "{x} {y}: {}", mask.lit()),
                // One by area, the other by the cosine at the surface.
                _ => {
                    partial += 1;
                    worst = worst.max((mask.lit() - fraction).abs());
                }
            }
        }
    }
    println!("{partial} in penumbra, {worst} apart at most");
    assert!(partial >= 3 && worst < 0.05, "{partial}, {worst}");
    assert!(renderer.unshadowed(5000, 3).is_empty());
}

/// The shadow map of each light is that of the last whole picture; other strategies have none, nor has a light that is gone.
#[test]
fn shadow_maps_of_lights() {
    // Maps are drawn where all lights are spheres.
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (96, 54);
    let globe = globe(24, Vec3::new(0.4, 1.6, 0.2), 0.4, true);
    scene.objects.push(Object::mesh("caster", globe, 0, Proxy::Count(8)));
    let mut mapped = renderer(scene, Some(Strategy::ShadowMap));
    let lights: Vec<LightHandle> = mapped.lights().map(|(handle, _)| handle).collect();
    assert!(lights.iter().all(|light| mapped.shadow_map(*light).is_none()), "before the first picture");
    mapped.render().expect("a picture");
    let map = mapped.shadow_map(lights[0]).expect("a map");
    assert_eq!(Some(map.light()), mapped.scene().lights[0].sphere());
    let nearest = map.images(64).iter().flat_map(|image| image.distances.clone()).fold(f32::INFINITY, f32::min);
    assert!(nearest > 0.5 && nearest < 10.0, "{nearest}");
    let settings = Settings { strategy: Some(Strategy::Silhouettes), ..mapped.settings().clone() };
    mapped.set_settings(settings).expect("a strategy");
    mapped.render().expect("a picture");
    assert!(lights.iter().all(|light| mapped.shadow_map(*light).is_none()));
    mapped.remove_light(lights[0]).expect("a light");
    assert!(mapped.shadow_map(lights[0]).is_none());
}
