//! Edits: the next picture equals that of a new renderer, and only stale data is computed again.

use brdf::Material;
use core::ops::ControlFlow;
use glam::{Mat4, UVec2, Vec3};
use lighting::{AmbientLight, Environment, EnvironmentMap, FlatLight, Light, SphereLight, SunLight};
use lobe_core::{Random, Sphere};
use renderer::{EditError, Method, RenderError, Renderer, Settings, Upkeep};
use scene::{Animation, Camera, KeyFrame, KeyFrames, Mesh, Object, Proxy, Scene, Strategy, Surface};
use shading::Accuracy;
use std::sync::Arc;
use test_scenes::{floor_and_sphere, globe};

fn lamp(x: f32) -> Light {
    SphereLight::new(Sphere { center: Vec3::new(x, 4.0, 1.0), radius: 0.5 }, Vec3::splat(4.0)).into()
}

fn mesh_object(x: f32) -> Object {
    let center = Vec3::new(x, 0.8, 0.5);
    let spheres = vec![Sphere { center, radius: 0.45 }];
    Object::mesh("globe", globe(6, center, 0.5, true), 0, Proxy::Spheres(spheres))
}

fn stage() -> Scene {
    let mut scene = floor_and_sphere();
    (scene.width, scene.height) = (48, 27);
    scene.objects.push(mesh_object(-1.0));
    scene.objects.push(mesh_object(1.2));
    scene
}

fn renderer(settings: Settings) -> Renderer {
    Renderer::new(stage(), Animation::default(), settings).expect("a scene")
}

fn check_same(edited: &mut Renderer, what: &str) {
    let (scene, settings) = (edited.scene().clone(), edited.settings().clone());
    let fresh = Renderer::new(scene, Animation::default(), settings).expect("a scene").render().expect("a picture");
    let image = edited.render().expect("a picture");
    assert_eq!(image.size, fresh.size, "{what}");
    let differs = image.radiance.iter().zip(&fresh.radiance).position(|(a, b)| a != b);
    assert_eq!(differs, None, "{what}");
}

fn all_strategies() -> impl Iterator<Item = Option<Strategy>> {
    Strategy::ALL.into_iter().map(Some).chain([None])
}

#[test]
fn a_moved_object_takes_its_shadow_with_it() {
    for strategy in all_strategies() {
        let mut edited = renderer(Settings { strategy, ..Settings::default() });
        edited.render().expect("a picture");
        let objects: Vec<_> = edited.objects().map(|(handle, _)| handle).collect();
        for (i, object) in objects.iter().enumerate().skip(1) {
            let shift = Mat4::from_translation(Vec3::new(0.1 * i as f32, 0.0, 0.3));
            edited.set_transform(*object, shift).expect("a shift");
        }
        check_same(&mut edited, &format!("{strategy:?}"));
        for object in &objects[1..] {
            edited.set_transform(*object, Mat4::IDENTITY).expect("back");
        }
        assert_eq!(edited.scene(), &stage());
    }
}

#[test]
fn objects_come_and_go() {
    for strategy in all_strategies() {
        let mut edited = renderer(Settings { strategy, ..Settings::default() });
        edited.render().expect("a picture");
        let added = edited.add_object(mesh_object(0.2)).expect("an object");
        check_same(&mut edited, &format!("{strategy:?}, added"));
        let first = edited.objects().nth(1).expect("a sphere").0;
        edited.remove_object(first).expect("is there");
        check_same(&mut edited, &format!("{strategy:?}, removed"));
        let gone = edited.set_visible(first, false);
        assert!(matches!(gone, Err(RenderError::Edit(EditError::NoObject(_)))));
        edited.set_transform(added, Mat4::from_translation(Vec3::X)).expect("still the same one");
        check_same(&mut edited, &format!("{strategy:?}, moved"));
    }
}

fn work(edited: &mut Renderer, before: Upkeep) -> Upkeep {
    edited.render().expect("a picture");
    let now = edited.upkeep();
    Upkeep {
        hierarchy_builds: now.hierarchy_builds - before.hierarchy_builds,
        hierarchy_refits: now.hierarchy_refits - before.hierarchy_refits,
        silhouette_builds: now.silhouette_builds - before.silhouette_builds,
        silhouette_refits: now.silhouette_refits - before.silhouette_refits,
        sphere_sets: now.sphere_sets - before.sphere_sets,
        sphere_updates: now.sphere_updates - before.sphere_updates,
        point_bands: now.point_bands - before.point_bands,
        maps: now.maps - before.maps,
        sky_tables: now.sky_tables - before.sky_tables,
        ray_worlds: now.ray_worlds - before.ray_worlds,
    }
}

#[test]
fn no_more_is_made_than_must_be() {
    let mut edited = renderer(Settings { strategy: Some(Strategy::Silhouettes), ..Settings::default() });
    edited.render().expect("a picture");
    let nothing = Upkeep::default();
    let light = edited.lights().next().expect("a light").0;
    let before = edited.upkeep();
    edited.set_light(light, lamp(0.3)).expect("a light");
    assert_eq!(work(&mut edited, before), nothing, "a light");
    let material = edited.materials().next().expect("a material").0;
    edited.set_material(material, Material::lambert(Vec3::X), Surface::default()).expect("a material");
    assert_eq!(work(&mut edited, before), nothing, "a material");
    let object = edited.objects().nth(2).expect("a globe").0;
    edited.set_transform(object, Mat4::from_translation(0.05 * Vec3::X)).expect("a shift");
    let once = Upkeep { hierarchy_refits: 1, silhouette_refits: 1, point_bands: 1, ..nothing };
    assert_eq!(work(&mut edited, before), once, "an object");
    let before = edited.upkeep();
    edited.set_accuracy(Accuracy::new(0.02)).expect("a tolerance");
    edited.set_settings(Settings { threshold: 1e-6, ..edited.settings().clone() }).expect("a threshold");
    edited.set_background(Vec3::ONE).expect("a background");
    edited.render_light(1, light, &mut |_| ControlFlow::Continue(())).expect("a part");
    assert_eq!(work(&mut edited, before), nothing, "settings, a background, and the part of a light");
    let points = Upkeep { point_bands: 1, ..nothing };
    edited
        .set_camera(Camera { eye: edited.scene().camera.eye + 0.1 * Vec3::X, ..edited.scene().camera })
        .expect("a camera");
    assert_eq!(work(&mut edited, before), points, "a camera");
    let before = edited.upkeep();
    edited.set_size(40, 30).expect("a size");
    assert_eq!(work(&mut edited, before), points, "a size");
}

#[test]
fn faults_are_refused() {
    let mut edited = renderer(Settings::default());
    let light = edited.lights().next().expect("a light").0;
    let fails =
        |radius: f32, radiance: f32| SphereLight::new(Sphere { center: Vec3::Y, radius }, Vec3::splat(radiance)).into();
    assert!(
        edited.set_light(light, fails(-1.0, 1.0)).is_err() && edited.set_light(light, fails(1.0, f32::NAN)).is_err()
    );
    assert!(edited.set_size(0, 0).is_err());
    assert!(edited.set_accuracy(Accuracy { tolerance: -1.0, depth: 4 }).is_err());
    assert!(edited.add_object(Object { material: 99, ..mesh_object(0.0) }).is_err());
    let bad = Mesh { positions: vec![Vec3::ZERO; 3], triangles: vec![[0, 1, 3]], ..Mesh::default() };
    assert!(edited.add_object(Object::mesh("bad", bad, 0, Proxy::None)).is_err());
    let object = edited.objects().nth(2).expect("a globe").0;
    assert!(edited.set_transform(object, Mat4::from_scale(Vec3::new(1.0, 2.0, 1.0))).is_err());
    assert!(edited.set_transform(object, Mat4::from_translation(Vec3::splat(1e12))).is_err());
    assert_eq!(edited.scene(), &stage());
    edited.set_settings(Settings { method: Method::Paper, ..Settings::default() }).expect("sphere lights");
    let flat = FlatLight::rectangle(Vec3::Y * 3.0, Vec3::X, Vec3::Z, Vec3::ONE).expect("a rectangle");
    assert!(matches!(edited.add_light(flat.into()), Err(RenderError::PaperLight(1, _))));
    let mut scene = stage();
    scene.objects[0].material = 99;
    assert!(Renderer::new(scene, Animation::default(), Settings::default()).is_err());
}

#[test]
fn keys_can_be_given_in_code() {
    let mut edited = renderer(Settings::default());
    let object = edited.objects().nth(2).expect("a globe").0;
    let keys = vec![KeyFrame::at(0.0), KeyFrame { translation: Vec3::X, ..KeyFrame::at(1.0) }];
    edited.set_keys(object, &KeyFrames { keys, ..KeyFrames::default() }).expect("keys");
    assert!(matches!(edited.set_transform(object, Mat4::IDENTITY), Err(RenderError::Edit(EditError::Animated(_)))));
    edited.seek(0.5);
    check_same(&mut edited, "keys");
    assert!(edited.set_keys(object, &KeyFrames::default()).is_err());
}

fn change(edited: &mut Renderer, random: &mut Random) -> Result<(), RenderError> {
    let at = |random: &mut Random, n: usize| ((random.uniform() * n as f64) as usize).min(n - 1);
    let shift = |random: &mut Random| (random.uniform() * 2.0 - 1.0) as f32;
    let objects: Vec<_> = edited.objects().map(|(handle, _)| handle).collect();
    if objects.is_empty() {
        return edited.add_object(mesh_object(shift(random))).map(drop);
    }
    let object = objects[at(random, objects.len())];
    let lights: Vec<_> = edited.lights().map(|(handle, _)| handle).collect();
    match at(random, 13) {
        0 | 1 => {
            let by = Vec3::new(shift(random), 0.0, shift(random));
            edited.set_transform(object, Mat4::from_rotation_y(by.x) * Mat4::from_translation(by)).map(drop)
        }
        2 => edited.add_object(mesh_object(shift(random))).map(drop),
        3 => edited.remove_object(object).map(drop),
        4 => edited.add_light(lamp(shift(random))).map(drop),
        5 if lights.len() > 1 => edited.remove_light(lights[0]).map(drop),
        6 => edited.set_object_strategy(object, all_strategies().nth(at(random, 6)).flatten()).map(drop),
        7 => {
            let (material, _) = edited.materials().next().expect("a material");
            let color = Vec3::splat(random.uniform() as f32);
            edited.set_material(material, Material::lambert(color), Surface::default()).map(drop)
        }
        8 => edited.set_size(40 + at(random, 9) as u32, 27).map(drop),
        9 => {
            let eye = edited.scene().camera.eye + 0.2 * Vec3::new(shift(random), shift(random), 0.0);
            edited.set_camera(Camera { eye, ..edited.scene().camera }).map(drop)
        }
        10 => edited.set_accuracy(Accuracy::new([0.02, 0.003][at(random, 2)])).map(drop),
        11 => {
            let method = [Method::Moments, Method::Lobes][at(random, 2)];
            edited.set_settings(Settings { method, ..edited.settings().clone() }).map(drop)
        }
        _ => edited.set_visible(object, random.uniform() < 0.5).map(drop),
    }
}

#[test]
fn any_edits_give_the_picture_of_a_new_renderer() {
    for (seed, strategy) in all_strategies().enumerate() {
        let mut random = Random::new(seed as u64);
        let mut edited = renderer(Settings { strategy, ..Settings::default() });
        for step in 0..12 {
            // An edit may be refused: nothing changes then.
            let _ = change(&mut edited, &mut random);
            check_same(&mut edited, &format!("{strategy:?}, step {step}"));
        }
    }
}

fn world(scene: &Scene) -> Sphere {
    scene.bounds().sphere()
}

fn environment(world: Sphere, blue: f32) -> Arc<Environment> {
    let texels = (0..32).map(|k| Vec3::new(0.3, 0.01 * k as f32, blue)).collect();
    let map = EnvironmentMap::new(UVec2::new(8, 4), texels).expect("a map");
    Arc::new(Environment::new(map, 1, world))
}

/// A stage under a sun, ambient light and an environment, which fit its objects' places.
fn outdoors() -> Scene {
    let mut scene = stage();
    let (world, toward) = (world(&scene), Vec3::new(0.4, 0.9, 0.1).normalize());
    scene.lights = vec![SunLight::new(toward, 2.0, Vec3::ONE, world).into()];
    scene.lights.push(AmbientLight { radiance: Vec3::splat(0.1), world }.into());
    let environment = environment(world, 0.5);
    scene.lights.extend_from_slice(environment.lights());
    scene.environment = Some(environment);
    scene
}

/// Lights around the scene grow to contain objects that leave it: the picture equals that with lights made for the new places.
#[test]
fn lights_around_the_scene_grow_with_it() {
    for strategy in all_strategies() {
        let settings = Settings { strategy, ..Settings::default() };
        let mut edited = Renderer::new(outdoors(), Animation::default(), settings.clone()).expect("a scene");
        edited.render().expect("a picture");
        assert_eq!(edited.scene(), &outdoors(), "nothing has left");
        let go = |renderer: &mut Renderer| {
            let object = renderer.objects().nth(2).expect("a globe").0;
            // Toward the sun, from a place where the object shades the floor.
            renderer.set_transform(object, Mat4::from_translation(Vec3::new(9.0, 18.0, 2.0))).expect("a shift");
        };
        go(&mut edited);
        let around = world(edited.scene());
        let mut scene = outdoors();
        scene.lights.iter_mut().for_each(|light| light.set_world(around));
        let mut other = Renderer::new(scene.clone(), Animation::default(), settings).expect("a scene");
        other.render().expect("a picture");
        go(&mut other);
        let want = other.render().expect("a picture");
        let image = edited.render().expect("a picture");
        assert_eq!(edited.scene().lights, scene.lights);
        assert!(image.radiance == want.radiance, "{strategy:?}");
    }
}

/// An object that has moved far toward the sun casts its shadow where a ray says.
#[test]
fn what_has_left_the_scene_still_shades_it() {
    let mut scene = outdoors();
    scene.lights.truncate(1);
    scene.environment = None;
    let settings = Settings { strategy: Some(Strategy::Silhouettes), ..Settings::default() };
    let mut edited = Renderer::new(scene, Animation::default(), settings).expect("a scene");
    let toward = Vec3::new(0.4, 0.9, 0.1).normalize();
    let object = edited.objects().nth(2).expect("a globe").0;
    let sun = edited.lights().next().expect("a sun").0;
    // The object's centre was at (-1, 0.8, 0.5); now it hides the sun from (1, 0, 2).
    let at = lobe_core::Receiver {
        object: 0,
        ..lobe_core::Receiver::on_surface(Vec3::new(1.0, 0.0, 2.0), Vec3::Y, Vec3::Y)
    };
    assert_eq!(edited.visible_fraction(&at, sun).expect("a sun"), Vec3::ONE);
    let to = at.position + toward * 30.0;
    edited.set_transform(object, Mat4::from_translation(to - Vec3::new(-1.0, 0.8, 0.5))).expect("a shift");
    // At a distance of 30 units a globe of radius 0.5 is 0.95 degrees wide, of the sun's 2: a fifth of the sun.
    let fraction = edited.visible_fraction(&at, sun).expect("a sun").x;
    let hidden = (0.5_f32 / 30.0).powi(2) / 2.0_f32.to_radians().sin().powi(2);
    assert!((1.0 - fraction - hidden).abs() < 0.03, "{fraction} for {}", 1.0 - hidden);
}

/// The sky's table follows the environment alone.
#[test]
fn a_sky_is_tabulated_once() {
    let mut edited = Renderer::new(outdoors(), Animation::default(), Settings::default()).expect("a scene");
    edited.render().expect("a picture");
    let before = edited.upkeep();
    // For all receivers, and for those that see little of it.
    assert_eq!(before.sky_tables, 2);
    let sun = edited.lights().find(|(_, light)| light.name() == "sun").map(|(handle, _)| handle).expect("a sun");
    edited.remove_light(sun).expect("it is there");
    assert_eq!(work(&mut edited, before).sky_tables, 0);
    let around = world(edited.scene());
    edited.set_environment(Some(environment(around, 0.2))).expect("an environment");
    assert_eq!(work(&mut edited, before).sky_tables, 2);
    // A sky without one of its patches is no sky: its lights stay lights.
    let patch = edited.lights().find(|(_, light)| light.name() == "environment").map(|(handle, _)| handle);
    edited.remove_light(patch.expect("a patch")).expect("it is there");
    assert_eq!(work(&mut edited, before).sky_tables, 2);
}

/// The parts of all lights are the picture, by every strategy; a lamp's part is what it adds to a sky.
#[test]
fn parts_of_lights_are_the_picture() {
    let near = |a: &[Vec3], b: &[Vec3]| {
        let most = b.iter().map(|v| v.max_element()).fold(0.0, f32::max);
        a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / most
    };
    let part = |renderer: &mut Renderer, divisor, light| {
        renderer.render_light(divisor, light, &mut |_| ControlFlow::Continue(())).expect("a part").radiance
    };
    for strategy in all_strategies() {
        let mut edited = renderer(Settings { strategy, ..Settings::default() });
        edited.add_light(lamp(-2.0)).expect("a lamp");
        let lights: Vec<_> = edited.lights().map(|(light, _)| light).collect();
        for divisor in [1, 2] {
            let whole = edited.render_reduced(divisor, &mut |_| ControlFlow::Continue(())).expect("a picture").radiance;
            let background = edited.scene().background;
            let mut sum = vec![Vec3::ZERO; whole.len()];
            for light in &lights {
                sum.iter_mut().zip(part(&mut edited, divisor, *light)).for_each(|(sum, part)| *sum += part);
            }
            assert!(background == Vec3::ZERO && near(&sum, &whole) < 1e-5, "{strategy:?} {divisor}");
        }
        check_same(&mut edited, &format!("{strategy:?}, after the parts"));
    }
    let mut edited = Renderer::new(outdoors(), Animation::default(), Settings::default()).expect("a scene");
    let with = edited.render().expect("a picture").radiance;
    let sun = edited.lights().find(|(_, light)| light.name() == "sun").map(|(handle, _)| handle).expect("a sun");
    let own = part(&mut edited, 1, sun);
    assert!(edited.render().expect("a picture").radiance == with && edited.upkeep().sky_tables == 2);
    edited.remove_light(sun).expect("it is there");
    let without = edited.render().expect("a picture").radiance;
    let sum: Vec<Vec3> = own.iter().zip(&without).map(|(a, b)| *a + *b).collect();
    assert!(near(&own, &with) > 0.1 && near(&sum, &with) < 1e-4, "{}", near(&sum, &with));
}

#[test]
fn environments_come_and_go() {
    for (strategy, start) in [(None, stage()), (Some(Strategy::Spheres), outdoors())] {
        let settings = Settings { strategy, ..Settings::default() };
        let mut edited = Renderer::new(start, Animation::default(), settings).expect("a scene");
        edited.render().expect("a picture");
        let still: Vec<_> = edited.lights().filter(|(_, l)| l.name() != "environment").map(|(h, _)| h).collect();
        let around = world(edited.scene());
        for (k, new) in [Some(environment(around, 1.0)), Some(environment(around, 0.2)), None].into_iter().enumerate() {
            edited.set_environment(new.clone()).expect("an environment");
            let count = new.as_ref().map_or(0, |environment| environment.lights().len());
            assert_eq!(edited.lights().count(), still.len() + count);
            assert!(edited.lights().zip(&still).all(|((handle, _), known)| handle == *known));
            check_same(&mut edited, &format!("{strategy:?}, {k}"));
        }
        edited.set_settings(Settings { method: Method::Lobes, ..edited.settings().clone() }).expect("settings");
    }
    let mut paper = renderer(Settings { method: Method::Paper, ..Settings::default() });
    let new = environment(world(paper.scene()), 1.0);
    assert!(matches!(paper.set_environment(Some(new)), Err(RenderError::PaperLight(1, _))));
    assert_eq!(paper.scene(), &stage());
}

/// Without objects a picture is the background, or the environment; objects can be added again.
#[test]
fn the_last_object_goes() {
    for strategy in all_strategies() {
        let mut edited = renderer(Settings { strategy, ..Settings::default() });
        edited.render().expect("a picture");
        let background = Vec3::new(0.1, 0.2, 0.3);
        edited.set_background(background).expect("a color");
        for object in edited.objects().map(|(handle, _)| handle).collect::<Vec<_>>() {
            edited.remove_object(object).expect("is there");
        }
        let image = edited.render().expect("a picture");
        assert!(
            image.radiance.iter().all(|pixel| *pixel == background) && edited.pick(20, 20).is_none(),
            "{strategy:?}"
        );
        check_same(&mut edited, &format!("{strategy:?}, empty"));
        let light = edited.lights().next().expect("a light").0;
        let at = lobe_core::Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
        assert_eq!(edited.visible_fraction(&at, light).expect("a light"), Vec3::ONE);
        edited.add_object(mesh_object(0.3)).expect("an object");
        check_same(&mut edited, &format!("{strategy:?}, again"));
    }
}
