//! The light of moments of an animation.

use crate::support::{Baked3, File, WHOLE, bake};
use bake::{BakeSettings, Baked, Baker, Form};
use core::ops::ControlFlow;
use glam::{Quat, Vec3};
use renderer::Settings;
use scene_files::LoadOptions;
use serde_json::json;

const MAPS: BakeSettings = BakeSettings { form: Form::Lightmap, page: 64, ..BakeSettings::DEFAULT };

/// Bakes a file, of the ending that is given, at several moments, one after the other.
fn at(ending: &str, bytes: &[u8], settings: BakeSettings, times: &[f32]) -> Vec<Baked> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene").with_extension(ending);
    std::fs::write(&path, bytes).unwrap();
    let mut baker = Baker::open(&path, &LoadOptions::new(), settings, Settings::default()).unwrap();
    let bake = |time: &f32| {
        baker.seek(*time).unwrap();
        baker.bake(&mut |_, _| ControlFlow::Continue(())).unwrap()
    };
    times.iter().map(bake).collect()
}

/// A floor, a block and a lamp, of which a clip moves block and lamp over two seconds: from left to right, and up.
fn moving() -> File {
    let mut file = File::new();
    file.quad("floor", [Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], WHOLE);
    file.block("block", Vec3::ZERO, Vec3::splat(0.25));
    file.light(json!({"type": "point", "intensity": 5.0}), Vec3::Y);
    let floats = |file: &mut File, kind: &str, values: &[f32], count: usize| {
        let start = file.binary.len().next_multiple_of(4);
        file.binary.resize(start, 0);
        file.binary.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        let view = json!({"buffer": 0, "byteOffset": start, "byteLength": 4 * values.len()});
        file.json["bufferViews"].as_array_mut().unwrap().push(view);
        let view = file.json["bufferViews"].as_array().unwrap().len() - 1;
        let accessor = json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
        file.json["accessors"].as_array_mut().unwrap().push(accessor);
        file.json["accessors"].as_array().unwrap().len() - 1
    };
    let times = floats(&mut file, "SCALAR", &[0.0, 2.0], 2);
    let block = floats(&mut file, "VEC3", &[-1.0, 0.5, 0.0, 1.0, 0.5, 0.0], 2);
    let turn = Quat::from_rotation_y(0.5).to_array();
    let turns = floats(&mut file, "VEC4", &[&[0.0, 0.0, 0.0, 1.0], &turn[..]].concat(), 2);
    let lamp = floats(&mut file, "VEC3", &[0.0, 1.0, 0.0, 0.0, 2.0, 0.0], 2);
    let channel =
        |sampler: u32, node: u32, path: &str| json!({"sampler": sampler, "target": {"node": node, "path": path}});
    let sampler = |output: usize| json!({"input": times, "output": output});
    file.json["animations"] = json!([{
        "channels": [channel(0, 1, "translation"), channel(1, 1, "rotation"), channel(2, 2, "translation")],
        "samplers": [sampler(block), sampler(turns), sampler(lamp)],
    }]);
    file
}

/// The light of a moment is that of a file which stands still as the moving one does then, in any order; coordinates are the same at all.
#[test]
fn moments_are_those_of_a_file_that_stands_still() {
    let times = [1.5, 0.0, 0.5];
    let baked = at("glb", &moving().glb(), MAPS, &times);
    for (baked, time) in baked.iter().zip(times) {
        let part = time / 2.0;
        let mut still = moving();
        still.json.as_object_mut().unwrap().remove("animations");
        still.json["nodes"][1]["translation"] = json!([2.0 * part - 1.0, 0.5, 0.0]);
        still.json["nodes"][1]["rotation"] = json!(Quat::IDENTITY.slerp(Quat::from_rotation_y(0.5), part).to_array());
        still.json["nodes"][2]["translation"] = json!([0.0, 1.0 + part, 0.0]);
        let want = bake(&still, MAPS);
        // The floor has a page of its own; the block's coordinates are made at the first moment.
        let apart = baked.maps[0].values.iter().zip(&want.maps[0].values).map(|(a, b)| (*a - *b).length());
        assert!(apart.fold(0.0, f32::max) < 1e-3, "{time}");
        let lit = |baked: &Baked| baked.maps[1].values.iter().map(|v| v.x).fold(0.0, f32::max);
        assert!((lit(baked) - lit(&want)).abs() < 0.02 * lit(&want));
    }
    let files: Vec<Baked3> = baked.iter().map(Baked3::new).collect();
    let uvs = |file: &Baked3| file.rows(&file.json["meshes"][1]["primitives"][0]["attributes"]["TEXCOORD_1"]);
    assert!(uvs(&files[0]) == uvs(&files[1]) && uvs(&files[1]) == uvs(&files[2]));
    assert_eq!(files[0].json["animations"], moving().json["animations"]);
    // The same bytes alone, and after other moments.
    let alone = at("glb", &moving().glb(), MAPS, &[0.5]);
    assert!(alone[0].glb == baked[2].glb && alone[0].maps == baked[2].maps);
    assert_ne!(alone[0].maps[0], baked[1].maps[0]);
}

/// Vertices of a morphing, skinned and mirrored body are lit where they stand.
#[test]
fn bodies_are_lit_in_their_poses() {
    let colors = BakeSettings { form: Form::VertexColors, both_sides: true, ..BakeSettings::DEFAULT };
    let mut file = moving();
    file.json["nodes"][1]["scale"] = json!([-1.0, 1.0, 1.0]);
    file.json["materials"][0]["doubleSided"] = json!(true);
    // The block morphs to one that is 0.3 higher, by all of it all the time, and hangs on itself as its only joint.
    let rise: Vec<u8> = [0.0_f32, 0.3, 0.0].repeat(24).iter().flat_map(|x| x.to_le_bytes()).collect();
    file.attribute(1, "RISE", &rise, (5126, false), "VEC3");
    let rise = file.json["meshes"][1]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("RISE");
    file.json["meshes"][1]["primitives"][0]["targets"] = json!([{"POSITION": rise}]);
    file.json["meshes"][1]["weights"] = json!([1.0]);
    let lights = |file: &File, time: f32| {
        let baked = at("glb", &file.glb(), colors, &[0.2, time]);
        let found = Baked3::new(&baked[1]);
        let primitives = found.json["meshes"][1]["primitives"].as_array().unwrap().clone();
        assert_eq!(primitives.len(), 2);
        primitives.iter().map(|p| found.rows(&p["attributes"]["COLOR_0"])).collect::<Vec<_>>()
    };
    let moved = lights(&file, 1.0);
    let mut skinned = file;
    skinned.attribute(1, "JOINTS_0", &[0; 4 * 24], (5121, false), "VEC4");
    skinned.attribute(1, "WEIGHTS_0", &[255, 0, 0, 0].repeat(24), (5121, true), "VEC4");
    skinned.json["skins"] = json!([{"joints": [1]}]);
    skinned.json["nodes"][1]["skin"] = json!(0);
    let carried = lights(&skinned, 1.0);
    let apart = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    for (a, b) in moved.iter().zip(&carried) {
        assert!(apart(a, b) < 1e-3);
    }
    assert!(apart(&lights(&skinned, 2.0)[0], &carried[0]) > 0.01);
    // Half of the sides face the lamp, above the block as it stands.
    let lit = moved[0].iter().filter(|row| row[0] > 0.0).count();
    assert!((4..=16).contains(&lit), "{lit}");
    assert!(moved[1].iter().all(|row| row[0] == 0.0), "its inside is dark");
}

/// The vertices of a scene file are written where they stand, and its camera.
#[test]
fn scenes_are_written_as_they_stand() {
    let scene = r#"
[image]
width = 64
height = 64
[camera]
eye = [0, 3, 5]
target = [0, 0, 0]
[[lights]]
kind = "sphere"
center = [0, 3, 0]
radius = 0.1
radiance = 100
[[objects]]
name = "floor"
quad = { center = [0, 0, 0], u = [2, 0, 0], v = [0, 0, -2] }
[[objects]]
name = "card"
quad = { center = [0, 0.5, 0], u = [0.3, 0, 0], v = [0, 0, -0.3] }
keys = [{ time = 0 }, { time = 1, translate = [1, 0, 0] }]
"#;
    let settings = BakeSettings { both_sides: true, ..MAPS };
    let baked = at("toml", scene.as_bytes(), settings, &[0.0, 1.0]);
    let files: Vec<Baked3> = baked.iter().map(Baked3::new).collect();
    let middle = |file: &Baked3| {
        let places = file.mesh(1).positions;
        places.iter().sum::<Vec3>() / places.len() as f32
    };
    assert!(middle(&files[0]).distance(Vec3::Y * 0.5) < 1e-6);
    assert!(middle(&files[1]).distance(Vec3::new(1.0, 0.5, 0.0)) < 1e-6);
    assert_ne!(baked[0].maps[0], baked[1].maps[0]);
    assert_eq!(baked[1].surfaces, 4);
}
