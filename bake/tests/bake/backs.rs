//! Double-sided surfaces.

use crate::support::{Baked3, File, WHOLE, bake};
use bake::{BakeSettings, Baker, Form};
use glam::Vec3;
use serde_json::{Value, json};

const MAPS: BakeSettings = BakeSettings { form: Form::Lightmap, page: 64, both_sides: true, ..BakeSettings::DEFAULT };

/// A sheet between two lamps: white light falls on its front, half as much on its back.
fn sheet(square: bool) -> File {
    let mut file = File::new();
    file.quad("sheet", [Vec3::ZERO, Vec3::X, Vec3::NEG_Z], if square { WHOLE } else { None });
    file.json["materials"][0]["doubleSided"] = json!(true);
    file.light(json!({"type": "point", "intensity": 2.0}), Vec3::Y);
    file.light(json!({"type": "point", "intensity": 1.0}), Vec3::NEG_Y);
    file
}

/// Front and back each have the light of their side, in textures of the same coordinates or of new ones, and in colours.
#[test]
fn each_side_has_its_own_light() {
    for square in [true, false] {
        let baked = bake(&sheet(square), MAPS);
        let most = |page: &bake::Map| page.values.iter().map(|v| v.x).fold(0.0, f32::max);
        let lights: Vec<f32> = baked.maps.iter().map(most).collect();
        if square {
            assert!((lights[0] - 2.0).abs() < 0.01 && (lights[1] - 1.0).abs() < 0.01, "{lights:?}");
        } else {
            assert!(lights.len() == 1 && (lights[0] - 2.0).abs() < 0.01, "{lights:?}");
        }
        assert_eq!(baked.surfaces, 2);
        let json = Baked3::new(&baked).json;
        let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
        assert_eq!(primitives.len(), 2);
        for primitive in primitives {
            let material = &json["materials"][primitive["material"].as_u64().unwrap() as usize];
            assert_eq!(material["doubleSided"], json!(false));
        }
        assert_eq!(json["materials"][0]["doubleSided"], json!(true), "the material of the file stays");
    }
    let colors = BakeSettings { form: Form::VertexColors, subdivide: Some(0.05), ..MAPS };
    let baked = bake(&sheet(false), colors);
    let found = Baked3::new(&baked);
    let rows = |primitive: &Value| found.rows(&primitive["attributes"]["COLOR_0"]);
    let sides = [0, 1].map(|k| rows(&found.json["meshes"][0]["primitives"][k]));
    let most = sides.map(|rows| rows.iter().map(|row| row[0]).fold(0.0, f64::max) * std::f64::consts::PI);
    assert!((most[0] - 2.0).abs() < 0.02 && (most[1] - 1.0).abs() < 0.02, "{most:?}");
}

/// A back is what a viewer shows of it: it goes round the other way, and its normals, tangents and those of morph targets are opposite.
#[test]
fn backs_face_the_other_way() {
    let bytes = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|x| x.to_le_bytes()).collect() };
    for (unwrap, mirrored) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut file = sheet(true);
        file.attribute(0, "NORMAL", &[0, 127, 0, 0].repeat(4), (5120, true), "VEC3");
        let view = file.json["bufferViews"].as_array().unwrap().len() - 1;
        file.json["bufferViews"][view]["byteStride"] = json!(4);
        file.attribute(0, "TANGENT", &bytes(&[1.0, 0.0, 0.0, 1.0].repeat(4)), (5126, false), "VEC4");
        file.attribute(0, "MOVED", &bytes(&[0.25, 0.0, 0.0].repeat(4)), (5126, false), "VEC3");
        let moved = file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("MOVED");
        file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"NORMAL": moved}]);
        file.json["meshes"][0]["weights"] = json!([0.0]);
        if mirrored {
            file.json["nodes"][0]["scale"] = json!([-1.0, 1.0, 1.0]);
        }
        let length = file.binary.len();
        let baked = bake(&file, BakeSettings { unwrap, ..MAPS });
        let found = Baked3::new(&baked);
        assert_eq!(&found.binary[..length], &file.binary[..]);
        for (k, side) in [1.0, -1.0].into_iter().enumerate() {
            let primitive = &found.json["meshes"][0]["primitives"][k];
            let rows = |name: &str| found.rows(&primitive["attributes"][name]);
            let indices: Vec<usize> = found.rows(&primitive["indices"]).iter().map(|row| row[0] as usize).collect();
            let places = rows("POSITION");
            for t in indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|k| Vec3::from_array([0, 1, 2].map(|j| places[t[k]][j] as f32)));
                assert!(side * (b - a).cross(c - a).y > 0.0, "in the mesh's own space");
            }
            if k == 1 {
                assert!(rows("NORMAL").iter().all(|row| row[..] == [0.0, -1.0, 0.0]));
                assert!(rows("TANGENT").iter().all(|row| row[..] == [-1.0, 0.0, 0.0, -1.0]));
                let moved = found.rows(&primitive["targets"][0]["NORMAL"]);
                assert!(moved.iter().all(|row| row[..] == [-0.25, 0.0, 0.0]));
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("again.glb");
        std::fs::write(&path, &baked.glb).unwrap();
        let (scene, _) = scene_files::load_with_warnings(&path).unwrap();
        // Without the floor of a model, since its lamp shines from below.
        assert_eq!(scene.triangles(), 4);
    }
}

/// Without the setting a line names double-sided surfaces with a border, and no others.
#[test]
fn sheets_are_named() {
    let notes = |file: &File, both_sides: bool| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.glb");
        std::fs::write(&path, file.glb()).unwrap();
        let settings = BakeSettings { both_sides, ..MAPS };
        let baker = Baker::open(&path, &scene_files::LoadOptions::new(), settings, renderer::Settings::default());
        baker.unwrap().notes().join("\n")
    };
    let mut file = sheet(true);
    // The corners of a block's sides lie in the same places.
    file.block("block", Vec3::NEG_Y * 3.0, Vec3::splat(0.5));
    let found = notes(&file, false);
    assert!(found.contains("both sides of \"sheet\" show the light of the front"), "{found}");
    assert!(!notes(&file, true).contains("sheet"));
    file.json["materials"][0]["doubleSided"] = json!(false);
    assert!(!notes(&file, false).contains("sheet"));
    assert_eq!(bake(&file, MAPS).surfaces, 2);
}

/// Pictures show both sides of surfaces whose normals point against their triangles; viewers show the dark one.
#[test]
fn normals_against_the_triangles_are_named() {
    let notes = |up: f32| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.obj");
        let text = format!("v 0 0 0\nv 0 0 1\nv 1 0 0\nvn 0 {up} 0\nf 1//1 2//1 3//1\n");
        std::fs::write(&path, text).unwrap();
        let baker = Baker::open(&path, &scene_files::LoadOptions::new(), MAPS, renderer::Settings::default());
        baker.unwrap().notes().iter().filter(|note| note.contains("normals of \"m\" point against")).count()
    };
    assert_eq!([1.0, -1.0].map(notes), [0, 1]);
}

/// The inside of a closed room that is drawn on both sides is no inside of a body: where a table hides the lamp its floor stays dark, up to
/// the edge of the shadow.
#[test]
fn rooms_have_shadows() {
    let mut file = File::new();
    // The floor's back is up; so are the backs of all walls inward.
    file.quad("floor", [Vec3::NEG_Y * 2.0, Vec3::X * 2.0, Vec3::Z * 2.0], WHOLE);
    let walls = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::Z, Vec3::NEG_Z];
    for (k, normal) in walls.into_iter().enumerate() {
        let (a, b) = normal.any_orthonormal_pair();
        let (a, b) = if a.cross(b).dot(normal) > 0.0 { (a, b) } else { (b, a) };
        file.quad(&format!("wall {k}"), [2.0 * normal, 2.0 * a, 2.0 * b], WHOLE);
    }
    file.json["materials"][0]["doubleSided"] = json!(true);
    // Its shadow is twice as large.
    file.block("table", Vec3::NEG_Y * 0.01, Vec3::new(0.5, 0.01, 0.5));
    file.light(json!({"type": "point", "intensity": 2.0}), Vec3::Y * 2.0 - Vec3::Y * 1e-3);
    let baked = bake(&file, MAPS);
    let floor = |map: &&bake::Map| {
        let [beside, under] = [0, 32].map(|column| map.values[32 * 64 + column].x);
        map.size == [64, 64] && beside > 0.01 && under == 0.0
    };
    let floor = baked.maps.iter().find(floor).unwrap();
    let row: Vec<f32> = floor.values[32 * 64..33 * 64].iter().map(|v| v.x).collect();
    // 32 texels of the shadow, of which the outermost are cut by the table's lower edge.
    assert!(row[..15].iter().all(|light| *light > 0.01), "{row:?}");
    assert!(row[17..47].iter().all(|light| *light == 0.0), "{row:?}");
}
