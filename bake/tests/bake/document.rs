//! The rest of a document stays as it is.

use crate::support::{File, WHOLE, bake, bake_file, chunks, glb};
use bake::{BakeSettings, Form};
use glam::Vec3;
use serde_json::{Value, json};

const SMALL: BakeSettings = BakeSettings { page: 32, samples: 1, ..BakeSettings::DEFAULT };

fn room() -> File {
    let mut file = File::new();
    file.quad("floor", [Vec3::ZERO, Vec3::X, Vec3::NEG_Z], WHOLE);
    file.light(json!({"type": "point", "intensity": 5.0}), Vec3::new(0.5, 2.0, 0.3));
    file
}

/// Text with odd numbers, spaces, names and unknown extensions.
const ODD: &str = r#""animations":[ {"name":"sway" , "channels":[{"sampler":0,"target":{"node":1,"path":"translation"}}],"samplers":[{"input":4,"output":5,"interpolation":"LINEAR"}]}],"extras" : {"number": 1.50e+00, "text":"\u00e4, \"]}" },"cameras":[{"type":"perspective","perspective":{"yfov":0.70000,"znear":1e-2}, "name":"eye"}]"#;

/// All bytes of the buffer keep their places, and all JSON that is not touched is as it was written, in each form.
#[test]
fn the_rest_stays_byte_for_byte() {
    let mut file = room();
    let times: Vec<u8> = [0.0_f32, 1.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let places: Vec<u8> = [0.5_f32, 2.0, 0.3, 0.6, 2.0, 0.3].iter().flat_map(|x| x.to_le_bytes()).collect();
    for (bytes, kind, count) in [(times, "SCALAR", 2), (places, "VEC3", 2)] {
        let view = json!({"buffer": 0, "byteOffset": file.binary.len(), "byteLength": bytes.len()});
        file.binary.extend(bytes);
        file.json["bufferViews"].as_array_mut().unwrap().push(view);
        let view = file.json["bufferViews"].as_array().unwrap().len() - 1;
        let accessor = json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
        file.json["accessors"].as_array_mut().unwrap().push(accessor);
    }
    let places = file.json["accessors"].as_array().unwrap().len();
    let odd = ODD.replace("\"input\":4,\"output\":5", &format!("\"input\":{},\"output\":{}", places - 2, places - 1));
    file.json["nodes"][0]["extensions"] = json!({"ACME_unknown": {"deep": [1, {"b": 2}]}});
    file.json["buffers"][0]["byteLength"] = json!(file.binary.len());
    let text = file.json.to_string();
    let text = format!("{},{odd}}}", &text[..text.len() - 1]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.glb");
    std::fs::write(&path, glb(text.as_bytes(), &file.binary)).unwrap();
    for form in [Form::Emission, Form::Lightmap, Form::VertexColors] {
        for unwrap in [false, true] {
            let baked = bake_file(&path, BakeSettings { form, unwrap, ..SMALL }).unwrap();
            let (json, binary) = chunks(&baked.glb);
            assert_eq!(&binary[..file.binary.len()], &file.binary[..]);
            let pieces: Vec<&str> = odd.split("],\"extras\" : ").collect();
            assert!(json.contains(&pieces[0]["\"animations\":[ ".len()..]), "{json}");
            for part in [
                r#"{"number": 1.50e+00, "text":"\u00e4, \"]}" }"#,
                r#"[{"type":"perspective","perspective":{"yfov":0.70000,"znear":1e-2}, "name":"eye"}]"#,
            ] {
                assert!(json.contains(part), "{form:?}: {part} in {json}");
            }
            let (before, after): (Value, Value) =
                (serde_json::from_str(&text).unwrap(), serde_json::from_str(&json).unwrap());
            for field in ["asset", "scene", "scenes", "animations", "cameras", "extras", "extensions"] {
                assert_eq!(before[field], after[field], "{field}");
            }
            assert_eq!(after["nodes"], before["nodes"]);
            for (place, material) in before["materials"].as_array().unwrap().iter().enumerate() {
                assert_eq!(after["materials"][place], *material);
            }
            let known = before["accessors"].as_array().unwrap().len();
            assert_eq!(after["accessors"].as_array().unwrap()[..known], before["accessors"].as_array().unwrap()[..]);
            // The result is a file that loads, and bakes again.
            let again = folder.path().join("again.glb");
            std::fs::write(&again, &baked.glb).unwrap();
            scene_files::load(&again).unwrap();
        }
    }
}

/// A `.gltf` with buffers and images beside it becomes one file.
#[test]
fn files_beside_it_are_taken_in() {
    let mut file = room();
    let folder = tempfile::tempdir().unwrap();
    let half = file.binary.len() / 2 / 4 * 4;
    std::fs::write(folder.path().join("a b.bin"), &file.binary).unwrap();
    std::fs::write(folder.path().join("second.bin"), &file.binary[half..]).unwrap();
    let map = bake(&file, BakeSettings { form: Form::Lightmap, ..SMALL }).maps.swap_remove(0);
    let png = map.linear_png().unwrap();
    std::fs::write(folder.path().join("tile.png"), &png).unwrap();
    file.json["buffers"] = json!([
        {"byteLength": file.binary.len(), "uri": "a%20b.bin"},
        {"byteLength": file.binary.len() - half, "uri": "second.bin", "name": "rest"},
    ]);
    for view in file.json["bufferViews"].as_array_mut().unwrap() {
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        if start >= half {
            view["buffer"] = json!(1);
            view["byteOffset"] = json!(start - half);
        }
    }
    file.json["images"] = json!([{"uri": "tile.png"}]);
    file.json["textures"] = json!([{"source": 0}]);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    let path = folder.path().join("room.gltf");
    std::fs::write(&path, file.json.to_string()).unwrap();
    let baked = bake_file(&path, BakeSettings { form: Form::Lightmap, ..SMALL }).unwrap();
    let (json, binary) = chunks(&baked.glb);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["buffers"], json!([{"byteLength": binary.len()}]));
    let image = &json["images"][0];
    let view = &json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    assert_eq!(
        (&binary[start..start + png.len()], &image["mimeType"], image.get("uri")),
        (&png[..], &json!("image/png"), None)
    );
    // Elsewhere it loads alone.
    let other = tempfile::tempdir().unwrap();
    let path = other.path().join("alone.glb");
    std::fs::write(&path, &baked.glb).unwrap();
    let (scene, warnings) = scene_files::load_with_warnings(&path).unwrap();
    assert!(warnings.iter().all(|line| line.contains("MOZ_lightmap")), "{warnings:?}");
    assert_eq!(scene.lights.len(), 1);
}

/// The light map's texture, its coordinates and its scale, as Hubs and three.js read them: texel · intensity is irradiance.
#[test]
fn light_maps_state_their_scale() {
    let baked = bake(&room(), BakeSettings { form: Form::Lightmap, ..SMALL });
    let (json, _) = chunks(&baked.glb);
    let json: Value = serde_json::from_str(&json).unwrap();
    let map = &json["materials"][1]["extensions"]["MOZ_lightmap"];
    assert_eq!((&map["index"], &map["texCoord"]), (&json!(0), &json!(1)));
    let scale = map["intensity"].as_f64().unwrap();
    assert!((scale - f64::from(baked.maps[0].white)).abs() < 1e-6 * scale);
    assert_eq!(json["materials"][1]["pbrMetallicRoughness"], json["materials"][0]["pbrMetallicRoughness"]);
    assert_eq!(json["extensionsUsed"], json!(["KHR_lights_punctual", "MOZ_lightmap"]));
}

/// Triangles of a mirrored node are written as they were, and light is on the side that is drawn.
#[test]
fn mirrored_nodes_keep_their_front() {
    let mut file = room();
    file.json["nodes"][0]["scale"] = json!([-1.0, 1.0, 1.0]);
    let before = bake(&file, BakeSettings { form: Form::Lightmap, ..SMALL });
    assert!(before.maps[0].values.iter().all(|v| v.x > 0.1), "the front is above");
    let after = bake(&file, BakeSettings { form: Form::Lightmap, unwrap: true, ..SMALL });
    let (json, binary) = chunks(&after.glb);
    let json: Value = serde_json::from_str(&json).unwrap();
    let primitive = &json["meshes"][0]["primitives"][0];
    let view = |accessor: &Value| {
        let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
        json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize]["byteOffset"].as_u64().unwrap() as usize
    };
    let (indices, places) = (view(&primitive["indices"]), view(&primitive["attributes"]["POSITION"]));
    let vertex = |k: usize| {
        let i = u16::from_le_bytes(binary[indices + 2 * k..indices + 2 * k + 2].try_into().unwrap()) as usize;
        let at = |j: usize| {
            f32::from_le_bytes(binary[places + 12 * i + 4 * j..places + 12 * i + 4 * j + 4].try_into().unwrap())
        };
        Vec3::new(at(0), at(1), at(2))
    };
    for t in 0..2 {
        let [a, b, c] = [0, 1, 2].map(|k| vertex(3 * t + k));
        assert!((b - a).cross(c - a).y > 0.0, "in the mesh's own space it is not mirrored");
    }
}
