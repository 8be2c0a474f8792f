//! The scene files of the repository load.

use lighting::Light;
use scene::Scene;
use scene_files::{LoadOptions, Studio};
use std::path::Path;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");

#[test]
fn self_contained_scenes_load() {
    for name in ["soft_spheres", "glossy_spheres", "lafortune"] {
        let scene = scene_files::load(Path::new(SCENES).join(name).with_extension("toml")).unwrap();
        assert!(!scene.lights.is_empty(), "{name}");
    }
}

#[test]
fn animated_scenes_move_and_stay_valid() {
    for (name, duration, moving) in [("walk", 2.125, 1), ("toys", 4.0, 7), ("tentacles", 4.0, 4)] {
        let (mut scene, animation, warnings) =
            scene_files::load_animated(Path::new(SCENES).join(name).with_extension("toml")).unwrap();
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        assert_eq!((animation.duration(), animation.fps()), (duration, 24.0), "{name}");
        let first = scene.clone();
        let mut moved = vec![false; scene.objects.len()];
        for i in 1..20 {
            animation.seek(duration * i as f32 / 20.0, &mut scene);
            scene.validate().unwrap();
            for (moved, (a, b)) in moved.iter_mut().zip(scene.objects.iter().zip(&first.objects)) {
                *moved |= a.shape != b.shape;
            }
            assert_ne!(scene.lights, first.lights, "{name}");
            // Nothing sinks into the floor by more than a paw's pad.
            assert!(scene.bounds().min.y > -0.03, "{name}: {}", scene.bounds().min.y);
        }
        assert_eq!(moved.iter().filter(|m| **m).count(), moving, "{name}");
    }
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn mesh_scenes_load_and_stand_on_their_floor() {
    for (name, triangles) in [("bunny", 6_966), ("armadillo", 86_482)] {
        let scene = scene_files::load(Path::new(SCENES).join(name).with_extension("toml")).unwrap();
        assert_eq!(scene.triangles(), triangles + 2);
        let model = scene.objects[1].shape.bounds();
        assert!(model.min.y.abs() < 1e-3, "{name}: {model:?}");
        // Half-angle about 6° from the model's middle.
        let light = scene.lights[0].sphere().expect("a sphere");
        let angle = (light.radius / light.center.distance(model.center())).asin().to_degrees();
        assert!((angle - 6.0).abs() < 0.15, "{name}: {angle}");
    }
}

/// A model that brings no lights stands in the studio; the key light alone is as bright in the middle as all of the studio, within 7 %.
#[test]
fn models_without_lights_stand_in_a_studio() {
    let path = Path::new(SCENES).join("assets/moebius.obj");
    let load = |studio| scene_files::load_with(&path, &LoadOptions::new().with_studio(studio)).unwrap().0;
    let (soft, key) = (load(Studio::default()), load(Studio::Key));
    let names = |scene: &Scene| scene.lights.iter().map(Light::name).collect::<Vec<_>>();
    assert_eq!((names(&soft), names(&key)), (vec!["sphere", "sphere", "ambient"], vec!["sphere"]));
    assert_eq!((&soft.camera, &soft.objects[0]), (&key.camera, &key.objects[0]));
    let middle = soft.objects[1].shape.bounds().center();
    // The irradiance over π of a surface that faces each light; of ambient light its radiance.
    let bright = |scene: &Scene| -> f32 {
        let of = |light: &Light| {
            let sin_sq = light.sphere().map_or(1.0, |s| (s.radius / s.center.distance(middle)).powi(2));
            sin_sq * light.full_radiance().y
        };
        scene.lights.iter().map(of).sum()
    };
    assert!(
        (bright(&key) - 1.0).abs() < 1e-3 && (bright(&soft) - 1.06).abs() < 0.01,
        "{} {}",
        bright(&key),
        bright(&soft)
    );
}
