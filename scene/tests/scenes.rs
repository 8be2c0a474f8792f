//! The scene files of the repository load.

use std::path::Path;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");

#[test]
fn self_contained_scenes_load() {
    for name in ["soft_spheres", "glossy_spheres", "lafortune"] {
        let scene = scene::load(Path::new(SCENES).join(name).with_extension("toml")).unwrap();
        assert!(!scene.lights.is_empty(), "{name}");
    }
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn mesh_scenes_load_and_stand_on_their_floor() {
    for (name, triangles) in [("bunny", 6_966), ("armadillo", 86_482)] {
        let scene = scene::load(Path::new(SCENES).join(name).with_extension("toml")).unwrap();
        assert_eq!(scene.triangles(), triangles + 2);
        let model = scene.objects[1].shape.bounds();
        assert!(model.min.y.abs() < 1e-3, "{name}: {model:?}");
        // Half-angle about 6° from the model's middle.
        let light = scene.lights[0].ball;
        let angle = (light.radius / light.center.distance(model.center())).asin().to_degrees();
        assert!((angle - 6.0).abs() < 0.15, "{name}: {angle}");
    }
}
