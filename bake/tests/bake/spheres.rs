//! Spheres of scene files.

use crate::support::{Baked3, bake_file};
use bake::{BakeSettings, Form};
use glam::Vec3;

/// A sphere under a small lamp far above, beside a smaller one and a floor.
const SCENE: &str = r#"
[camera]
eye = [0, 3, 5]
target = [0, 0, 0]
[materials.paint]
model = "lambert"
albedo = [0.5, 0.25, 0.125]
[[lights]]
kind = "sphere"
center = [0, 30, 0]
radius = 0.3
radiance = 10000
[[objects]]
name = "floor"
quad = { center = [0, 0, 0], u = [2, 0, 0], v = [0, 0, -2] }
[[objects]]
name = "spheres"
sphere = { center = [0, 0.6, 0], radius = 0.5 }
material = "paint"
keys = [{ time = 0 }, { time = 1, scale = 0.01 }]
"#;

/// Lit from a point, a sphere has E cos θ above its terminator, up to the lamp's width, and nothing below: at its vertices as between them.
#[test]
fn spheres_are_lit_as_spheres() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, SCENE).unwrap();
    let settings = BakeSettings { form: Form::VertexColors, ..BakeSettings::DEFAULT };
    let baked = bake_file(&path, settings).unwrap();
    let found = Baked3::new(&baked);
    let mesh = found.mesh(1);
    assert!(mesh.triangles.len() >= 1280, "{}", mesh.triangles.len());
    let center = Vec3::new(0.0, 0.6, 0.0);
    for (p, color) in mesh.positions.iter().zip(&mesh.colors) {
        let normal = (*p - center).normalize();
        assert!((p.distance(center) - 0.5).abs() < 1e-5);
        let to = Vec3::Y * 30.0 - *p;
        let cosine = normal.dot(to.normalize());
        // Corners are a fiftieth of a triangle aside.
        if cosine.abs() > 0.02 {
            let want = 1e4 * 0.09 / to.length_squared() * cosine.max(0.0);
            let light = color.x * baked.scale;
            assert!((light - want).abs() < 0.012 * 1e3 / 900.0, "{p}: {light} {want}");
        }
    }
    // Between vertices light is the sphere's, not that of flat triangles: the mean of cos θ, or 0 below, is a quarter.
    let floor = SCENE.split("[[objects]]").nth(1).unwrap();
    std::fs::write(&path, SCENE.replace(&format!("[[objects]]{floor}"), "")).unwrap();
    let settings = BakeSettings { form: Form::Lightmap, page: 128, ..settings };
    let baked = bake_file(&path, settings).unwrap();
    let values = &baked.maps[0].values;
    let most = values.iter().map(|v| v.x).fold(0.0, f32::max);
    let top = core::f32::consts::PI * 1e4 * 0.09 / (30.0_f32 - 1.1).powi(2);
    assert!((most / top - 1.0).abs() < 0.01, "{most} {top}");
    let mean = values.iter().map(|v| v.x).sum::<f32>() / values.len() as f32;
    assert!((mean / top - 0.25).abs() < 0.02, "{}", mean / top);
    let mut each: Vec<f32> = values.iter().map(|v| v.x / top).filter(|light| *light > 0.01).collect();
    each.sort_by(f32::total_cmp);
    // Cosines are even on [0, 1], but for texels that no chart covers.
    for part in [0.25, 0.5, 0.75] {
        let found = each[(part * each.len() as f32) as usize];
        assert!((found - part).abs() < 0.05, "{part}: {found}");
    }
    let json = &found.json;
    let material = &json["materials"][json["meshes"][1]["primitives"][0]["material"].as_u64().unwrap() as usize];
    assert_eq!(material["pbrMetallicRoughness"]["baseColorFactor"], serde_json::json!([0.5, 0.25, 0.125, 1]));
}

/// The triangles are the same at all moments, however large the sphere is then.
#[test]
fn shrinking_spheres_keep_their_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, SCENE).unwrap();
    let settings = BakeSettings { page: 64, both_sides: true, ..BakeSettings::DEFAULT };
    let options = scene_files::LoadOptions::new();
    let mut baker = bake::Baker::open(&path, &options, settings, renderer::Settings::default()).unwrap();
    let mut bake = |time: f32| {
        baker.seek(time).unwrap();
        Baked3::new(&baker.bake(&mut |_, _| core::ops::ControlFlow::Continue(())).unwrap())
    };
    let files = [bake(0.0), bake(1.0)];
    let meshes = files.each_ref().map(|file| file.mesh(1));
    assert_eq!(meshes[0].triangles, meshes[1].triangles);
    let width = meshes.map(|mesh| mesh.positions[0].distance(mesh.positions[9]));
    assert!(width[1] < 0.02 * width[0]);
    assert_eq!(files[1].json["meshes"][1]["primitives"].as_array().unwrap().len(), 1, "its inside is not seen");
}
