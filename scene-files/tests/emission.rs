//! Objects that emit light the others, exactly or within 2 %, or a warning says why not.

#![expect(clippy::unwrap_used, reason = "a test")]

use glam::Vec3;
use scene::{Animation, Scene, Strategy};
use scene_files::{Emission, LoadOptions, Studio};
use shading::LightLobes;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

struct Loaded {
    scene: Scene,
    animation: Animation,
    warnings: Vec<String>,
}

fn load(file: &Path, emission: Emission) -> Loaded {
    let (scene, animation, warnings) =
        scene_files::load_with(file, &LoadOptions::new().with_emission(emission)).unwrap();
    Loaded { scene, animation, warnings }
}

/// A file of that text in a folder of its own.
fn load_text(name: &str, text: &str, emission: Emission) -> Loaded {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join(name), text).unwrap();
    fs::write(folder.path().join("panel.bin"), panel_bytes()).unwrap();
    load(&folder.path().join(name), emission)
}

/// The corners and triangles of a square, and key frames at 0 and 1 s: a shift by 4 along x and 3 along y, and a scale by 2.
fn panel_bytes() -> Vec<u8> {
    let corners: [[f32; 3]; 4] = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0_u8, 1, 2, 0, 2, 3, 0, 0]);
    let floats = [0.0_f32, 1.0, 0.0, 3.0, 0.0, 4.0, 3.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
    bytes.extend(floats.iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// A glTF of a square of side 2 about the origin, its normal down (−y), and one that reflects only, a unit below. The panel's node, its
/// material and the top level take more keys.
fn panel(node: &str, material: &str, more: &str) -> String {
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0, 1]}}],
"buffers": [{{"byteLength": 112, "uri": "panel.bin"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 6}},
 {{"buffer": 0, "byteOffset": 56, "byteLength": 56}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1]}},
 {{"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}},
 {{"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]}},
 {{"bufferView": 2, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC3"}},
 {{"bufferView": 2, "byteOffset": 32, "componentType": 5126, "count": 2, "type": "VEC3"}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0}}]}},
 {{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 1}}]}}],
"materials": [{{"name": "panel", {material}}}, {{"name": "plain"}}],
"nodes": [{{"name": "panel", "mesh": 0, "translation": [0, 3, 0]{node}}}, {{"name": "floor", "mesh": 1}}]{more}}}"#
    )
}

const BRIGHT: &str =
    r#""emissiveFactor": [1, 0.5, 0.25], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}"#;

#[test]
fn a_panel_of_a_gltf_is_the_only_light() {
    let text = panel("", BRIGHT, "");
    let Loaded { scene, warnings, .. } = load_text("room.gltf", &text, Emission::Lights);
    assert_eq!((scene.lights.len(), scene.lights[0].name()), (1, "flat"));
    assert_eq!(scene.lights[0].full_radiance(), Vec3::new(8.0, 4.0, 2.0));
    assert!(scene.lights[0].bounds().center.distance(Vec3::Y * 3.0) < 1e-5);
    assert!(warnings.is_empty(), "{warnings:?}");
    // Seen only, the model has the light that models without lights get.
    let seen = load_text("room.gltf", &text, Emission::Seen);
    assert_eq!((seen.scene.lights.len(), seen.scene.lights[2].name()), (3, "ambient"));
    assert!(seen.warnings.is_empty(), "{:?}", seen.warnings);
}

/// A lamp that is a thousandth as large as the model, or dim, leaves the model its studio; a studio that is requested comes to all.
#[test]
fn a_faint_panel_leaves_the_studio() {
    let small = panel(r#", "scale": [0.005, 1, 0.005]"#, r#""emissiveFactor": [1, 0, 0]"#, "");
    let dim = panel("", r#""emissiveFactor": [0.09, 0.05, 0]"#, "");
    for text in [small, dim] {
        let Loaded { scene, warnings, .. } = load_text("room.gltf", &text, Emission::Lights);
        let names: Vec<_> = scene.lights.iter().map(lighting::Light::name).collect();
        assert_eq!(names, ["flat", "sphere", "sphere", "ambient"]);
        assert!(warnings.iter().any(|w| w.contains("faint")) && warnings.len() == 1, "{warnings:?}");
    }
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("room.gltf");
    fs::write(&file, panel("", BRIGHT, "")).unwrap();
    fs::write(folder.path().join("panel.bin"), panel_bytes()).unwrap();
    let (scene, _, warnings) = scene_files::load_with(&file, &LoadOptions::new().with_studio(Studio::Key)).unwrap();
    assert_eq!((scene.lights.len(), scene.lights[1].name(), warnings.len()), (2, "sphere", 0));
}

#[test]
fn a_panel_moves_as_its_node_does() {
    let clip = |channel: &str| {
        format!(
            r#", "animations": [{{"samplers": [{{"input": 2, "output": 3}}, {{"input": 2, "output": 4}}],
 "channels": [{{"sampler": {channel}, "target": {{"node": 0, "path": "{}"}}}}]}}]"#,
            if channel == "0" { "translation" } else { "scale" }
        )
    };
    let Loaded { mut scene, animation, warnings } =
        load_text("room.gltf", &panel("", BRIGHT, &clip("0")), Emission::Lights);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(scene.lights[0].name(), "flat");
    for time in [0.0, 0.5, 1.0] {
        animation.seek(time, &mut scene);
        let want = Vec3::new(4.0 * time, 3.0, 0.0);
        assert!(scene.lights[0].bounds().center.distance(want) < 1e-5, "{time}");
    }
    let grows = load_text("room.gltf", &panel("", BRIGHT, &clip("1")), Emission::Lights);
    assert!(grows.warnings.iter().any(|w| w.contains("changes its size")), "{:?}", grows.warnings);
}

#[test]
fn lights_of_the_file_at_the_panel_are_the_panels() {
    let lamp = r#", "extensions": {"KHR_lights_punctual": {"light": 0}}"#;
    let lights = r#", "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}"#;
    let Loaded { scene, warnings, .. } = load_text("room.gltf", &panel(lamp, BRIGHT, lights), Emission::Lights);
    assert_eq!((scene.lights.len(), scene.lights[0].name()), (1, "sphere"));
    assert!(warnings.is_empty(), "{warnings:?}");
}

/// A sphere of latitudes and longitudes about a point, as lines of an OBJ.
fn globe(sides: u32, first: u32, radius: f32, x: f32) -> String {
    let mut text = String::new();
    for j in 0..=sides {
        for i in 0..2 * sides {
            let (sin, cos) = (std::f32::consts::PI * j as f32 / sides as f32).sin_cos();
            let (s, c) = (std::f32::consts::PI * i as f32 / sides as f32).sin_cos();
            let [a, b, d] = [sin * c, cos, sin * s].map(|x| radius * x);
            writeln!(text, "v {} {} {d}", a + x, b + 4.0).unwrap();
        }
    }
    for j in 0..sides {
        for i in 0..2 * sides {
            let corner = |i: u32, j: u32| first + j * 2 * sides + i % (2 * sides);
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
        }
    }
    text
}

/// Curved meshes within 2 % light as spheres that they do not hide; a warning names others.
#[test]
fn curved_meshes_light_within_two_percent() {
    let load_obj = |faces: &str| {
        let folder = TempDir::new().unwrap();
        fs::write(
            folder.path().join("lamp.mtl"),
            "newmtl lamp\nKd 0.5 0.5 0.5\nKe 3 2 1\nnewmtl grey\nKd 0.5 0.5 0.5\n",
        )
        .unwrap();
        let floor = "v -9 0 -9\nv -9 0 9\nv 9 0 9\nv 9 0 -9\n";
        let text = format!("mtllib lamp.mtl\n{floor}o floor\nusemtl grey\nf 1 2 3 4\no lamp\nusemtl lamp\n{faces}");
        fs::write(folder.path().join("lamp.obj"), text).unwrap();
        load(&folder.path().join("lamp.obj"), Emission::Lights)
    };
    let Loaded { scene, warnings, .. } = load_obj(&globe(12, 5, 0.5, 0.0));
    assert_eq!((scene.lights.len(), scene.lights[0].full_radiance().x > 2.8), (1, true), "{warnings:?}");
    let lamp = scene.objects.iter().position(|o| o.name.contains("lamp")).unwrap();
    assert_eq!(scene.objects[lamp].strategy, Some(Strategy::None));
    assert!(warnings.iter().any(|w| w.contains("within 2 %") && w.contains("casts no shadow")), "{warnings:?}");
    // Thirty spheres are more than what stands for one mesh.
    let many: String = (0..30).map(|k| globe(4, 5 + k * 40, 0.2, k as f32)).collect();
    let Loaded { scene, warnings, .. } = load_obj(&many);
    assert_eq!(scene.lights[2].name(), "ambient", "the studio of models without lights");
    assert!(warnings.iter().any(|w| w.contains("lights no other") && w.contains("separate parts")), "{warnings:?}");
}

/// One that is not seen lights nothing by default, which a warning says.
#[test]
fn lamps_that_are_not_seen_are_told() {
    let text = |more: &str| {
        format!(
            "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = 2\n[[objects]]\nname = \"bulb\"\n\
             material = \"lamp\"\nvisible = false\nsphere = {{ center = [0, 3, 0], radius = 0.5 }}\n{more}"
        )
    };
    let told =
        |loaded: &Loaded| loaded.warnings.iter().any(|w| w.contains("\"bulb\" emits") && w.contains("not visible"));
    let dark = load_text("dark.toml", &text(""), Emission::Lights);
    assert!(dark.scene.lights.is_empty() && told(&dark), "{:?}", dark.warnings);
    let lit = load_text("lit.toml", &text("light = true"), Emission::Lights);
    assert!(lit.scene.lights.len() == 1 && !told(&lit), "{:?}", lit.warnings);
}

/// A scene file's objects do by default as well, and `light` decides.
#[test]
fn the_key_of_a_scene_file_decides() {
    let text = |more: &str| {
        format!(
            "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = [2, 1, 0]\n[[objects]]\nmaterial = \"lamp\"\n\
             quad = {{ center = [0, 3, 0], u = [1, 0, 0], v = [0, 0, 1] }}\n{more}"
        )
    };
    let count = |text: &str, emission| load_text("room.toml", text, emission).scene.lights.len();
    assert_eq!(count(&text(""), Emission::Lights), 1);
    assert_eq!(count(&text(""), Emission::Seen), 0);
    assert_eq!(count(&text("light = false\n"), Emission::Lights), 0);
    assert_eq!(count(&text("light = true\n"), Emission::Seen), 1);
    assert_eq!(count(&text("visible = false\n"), Emission::Lights), 0);
    // A light of the file at the panel is shown by it.
    let lamp = "[[lights]]\nkind = \"rectangle\"\ncenter = [0, 2.99, 0]\nu = [1, 0, 0]\nv = [0, 0, 1]\nradiance = 2\n";
    assert_eq!(count(&text(lamp), Emission::Lights), 1);
}

/// So many lights of their own would cost more than anybody means to pay.
#[test]
fn lights_by_emission_are_bounded() {
    let mut text = "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = [2, 1, 0]\n".to_owned();
    for k in 0..40 {
        write!(text, "[[objects]]\nmaterial = \"lamp\"\nbox = {{ center = [{k}, 3, 0], size = [0.5, 0.1, 0.5] }}\n")
            .unwrap();
    }
    let Loaded { scene, warnings, .. } = load_text("room.toml", &text, Emission::Lights);
    assert_eq!(scene.lights.len(), 126);
    assert!(warnings.iter().any(|w| w.contains("and 18 more") && w.contains("128 lights")), "{warnings:?}");
}

/// A mesh for which no lights stand takes as long as one that becomes lights: not each of thousands is tried.
#[test]
fn few_meshes_are_tried_in_vain() {
    let folder = TempDir::new().unwrap();
    let corner = |k: u32| {
        let (sin, cos) = (k as f32 * 0.2).sin_cos();
        format!("v {cos} {} {sin}\n", 0.2 * (k % 2) as f32)
    };
    let ring = (0..31).map(corner).chain((1..30).map(|k| format!("f {k} {} {}\n", k + 1, k + 2)));
    fs::write(folder.path().join("ring.obj"), ring.collect::<String>()).unwrap();
    let lamp = "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = [2, 1, 0]\n";
    let object = |shape: &str| format!("[[objects]]\nmaterial = \"lamp\"\n{shape}\n");
    let lights = |rings: usize| {
        let cube = object("box = { center = [0, 3, 0], size = [0.5, 0.1, 0.5] }");
        let text = lamp.to_owned() + &object("mesh = \"ring.obj\"").repeat(rings) + &cube;
        fs::write(folder.path().join("rings.toml"), text).unwrap();
        load(&folder.path().join("rings.toml"), Emission::Lights).scene.lights.len()
    };
    assert_eq!([lights(2), lights(33)], [6, 0]);
}

/// Each light of a scene of many triangles takes long: a small file has fewer of them.
#[test]
fn small_files_of_many_triangles_have_few_lights() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("globe.obj"), globe(60, 1, 0.2, 0.0)).unwrap();
    let lights = |copies: usize| {
        let mut text = "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = [2, 1, 0]\n".to_owned();
        for k in 0..10 {
            let size = "size = [0.5, 0.1, 0.5]";
            write!(text, "[[objects]]\nmaterial = \"lamp\"\nbox = {{ center = [{k}, 3, 0], {size} }}\n").unwrap();
        }
        for k in 0..copies {
            write!(text, "[[objects]]\nmesh = \"globe.obj\"\ntranslate = [{k}, -5, 0]\n").unwrap();
        }
        fs::write(folder.path().join("room.toml"), text).unwrap();
        load(&folder.path().join("room.toml"), Emission::Lights)
    };
    let few = lights(10);
    assert_eq!(few.scene.lights.len(), 60, "{:?}", few.warnings);
    let many = lights(120);
    assert!((6..=36).contains(&many.scene.lights.len()), "{}", many.scene.lights.len());
    assert!(many.warnings.iter().any(|w| w.contains("as many as so small a file")), "{:?}", many.warnings);
}
