//! The parts of glTF files that are left out: each gives a line, and none without effect does.

use crate::context::Context;
use crate::gltf_file;
use crate::gltf_tests::{parts_of, triangle, with_floats};
use std::path::Path;

#[test]
fn textures_by_coordinates_that_the_mesh_lacks_are_told() {
    let folder = tempfile::tempdir().unwrap();
    image::RgbaImage::from_pixel(2, 2, image::Rgba([128; 4])).save(folder.path().join("s.png")).unwrap();
    let path = folder.path().join("m.gltf");
    let images = r#", "textures": [{"source": 0}], "images": [{"uri": "s.png"}]"#;
    let text = with_floats(&triangle(r#"[{"mesh": 0, "name": "leaf"}]"#, images), &[(&[0.0; 6], "VEC2")]);
    let text = text.replace("\"POSITION\": 0", "\"POSITION\": 0, \"TEXCOORD_0\": 1");
    for (material, of) in [
        (r#""pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}"#, "color"),
        (r#""normalTexture": {"index": 0, "texCoord": 1}"#, "normal"),
        (r#""normalTexture": {"index": 0, "texCoord": 0}"#, ""),
        // It shines not.
        (r#""emissiveTexture": {"index": 0, "texCoord": 1}"#, ""),
    ] {
        let own = r#""pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0}"#;
        std::fs::write(&path, text.replace(own, material)).unwrap();
        let (_, warnings) = crate::load_with_warnings(&path).unwrap();
        let told = format!("\"leaf\" has no texture coordinates 1, by which its {of} texture lies");
        assert_eq!(warnings.iter().filter(|w| w.contains(&told)).count(), usize::from(!of.is_empty()), "{warnings:?}");
        assert_eq!(warnings.len(), usize::from(!of.is_empty()), "{warnings:?}");
    }
}

/// Buffers and images by paths that lead out of the document's folder, as MTL's do.
#[test]
fn files_are_found_by_relative_paths_only() {
    let mut image = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(2, 2, image::Rgba([128; 4])).write_to(&mut image, image::ImageFormat::Png).unwrap();
    let positions = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes);
    let read = |folder: &str| {
        let images = format!(r#", "textures": [{{"source": 0}}], "images": [{{"uri": "{folder}x/s.png"}}]"#);
        let text = triangle(r#"[{"mesh": 0}]"#, &images)
            .replace("\"metallicFactor\": 0", r#""baseColorTexture": {"index": 0}"#)
            .replace("data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA", "T");
        let text = text.replace("\"T\"", &format!("\"{folder}x/t.bin\""));
        let files: std::collections::BTreeMap<std::path::PathBuf, Vec<u8>> = [
            ("a/m.gltf".into(), text.into_bytes()),
            ("x/t.bin".into(), positions.concat()),
            ("x/s.png".into(), image.get_ref().clone()),
        ]
        .into();
        crate::load_from(std::sync::Arc::new(files), "a/m.gltf", None).map_err(|e| e.to_string())
    };
    let (scene, _, warnings) = read("../").unwrap();
    assert_eq!(scene.surfaces.iter().filter(|surface| surface.color.is_some()).count(), 1, "{warnings:?}");
    for (folder, words) in [("/", "is an absolute path"), ("http://a/", "only files and data URIs"), ("./", "x/t.bin")]
    {
        let message = read(folder).err().unwrap();
        assert!(message.contains("buffer 0") && message.contains(words), "{message}");
    }
}

#[test]
fn morphs_of_colours_and_spare_indices_are_told() {
    let text = with_floats(&triangle(r#"[{"mesh": 0}]"#, ""), &[(&[0.0; 15], "VEC3")]);
    let morphed =
        text.replace("\"material\": 0", "\"targets\": [{\"POSITION\": 0, \"COLOR_0\": 0, \"TEXCOORD_1\": 0}]");
    let warnings = parts_of(&morphed).1;
    for name in ["COLOR_0", "TEXCOORD_1"] {
        assert_eq!(warnings.iter().filter(|w| w.contains(&format!("targets of {name} are not read"))).count(), 1);
    }
    let (parts, warnings) = parts_of(&text.replace("\"POSITION\": 0", "\"POSITION\": 1"));
    assert_eq!((parts[0].mesh.triangles.len(), warnings.len()), (1, 1), "{warnings:?}");
    assert!(warnings[0].contains("mesh 0, primitive 0: 2 of its indices are no triangle"), "{warnings:?}");
}

#[test]
fn required_extensions_that_change_no_picture_are_fine() {
    let required = r#", "extensionsRequired": ["KHR_materials_variants", "KHR_xmp_json_ld"]"#;
    let (parts, warnings) = parts_of(&triangle(r#"[{"mesh": 0}]"#, required));
    assert_eq!((parts.len(), warnings.len()), (1, 0), "{warnings:?}");
}

/// Programs write a scene in which nothing is without its list of nodes.
#[test]
fn scenes_without_nodes_are_empty() {
    let of = |scene: usize| {
        triangle(r#"[{"mesh": 0}]"#, &format!(r#", "scenes": [{{"name": "a"}}, {{"nodes": [0]}}], "scene": {scene}"#))
    };
    let (parts, warnings) = parts_of(&of(1));
    assert_eq!((parts.len(), warnings.len()), (1, 0), "{warnings:?}");
    assert!(parts_of(&of(0)).0.is_empty());
    // Other faults stay faults.
    let double = triangle(r#"[{"mesh": 0}]"#, r#", "scenes": [{"nodes": [0]}], "scene": 0, "scene": 0"#);
    let mut context = crate::context::Context::default();
    let read = crate::gltf_file::parse("m.gltf".as_ref(), double.as_bytes(), None, &mut context);
    assert!(read.err().is_some_and(|e| e.to_string().contains("duplicate field `scene`")));
}

#[test]
fn texts_may_have_a_mark_before_and_zeros_behind() {
    let text = triangle(r#"[{"mesh": 0}]"#, "");
    let (parts, warnings) = parts_of(&format!("\u{feff}{text}\0\0"));
    assert_eq!((parts.len(), warnings.len()), (1, 0), "{warnings:?}");
}

/// Accessors without data are zeros: a small file may claim many.
#[test]
fn what_accessors_claim_without_data_is_bounded() {
    let of = |count: usize, channels: usize| {
        let times = format!(r#"{{"componentType": 5126, "count": {count}, "type": "SCALAR"}}"#);
        let moves = format!(r#"{{"componentType": 5126, "count": {count}, "type": "VEC3"}}"#);
        let channel = r#"{"sampler": 0, "target": {"node": 0, "path": "translation"}}"#;
        let channels = vec![channel; channels].join(", ");
        let clip =
            format!(r#", "animations": [{{"samplers": [{{"input": 1, "output": 2}}], "channels": [{channels}]}}]"#);
        let text = triangle(r#"[{"mesh": 0}]"#, &clip);
        let text = text.replace("\"type\": \"VEC3\"}]", &format!("\"type\": \"VEC3\"}}, {times}, {moves}]"));
        gltf_file::parse(Path::new("m.gltf"), text.as_bytes(), None, &mut Context::default())
            .map(|read| read.parts.len())
            .map_err(|e| e.to_string())
    };
    assert_eq!(of(2, 1), Ok(1));
    let message = of(6_000_000, 1).unwrap_err();
    assert!(message.contains("6000000 elements without data: at most 5592405 are read"), "{message}");
    let message = of(4_000_000, 40).unwrap_err();
    assert!(message.contains("1 animations: the scene would take 2.6 GB of memory"), "{message}");
}

/// The format demands that integers of colours are normalized; some writers forget to say so.
#[test]
fn colours_of_bytes_are_normalized_whatever_their_accessor_says() {
    let plain = triangle(r#"[{"mesh": 0}]"#, "");
    // The bytes of the first position, 0 0 0, and of 1 as a float.
    let view = r#"{"bufferView": 0, "componentType": 5121, "count": 3, "type": "VEC4", "byteOffset": 12"#;
    let text = plain.replace("\"type\": \"VEC3\"}]", &format!("\"type\": \"VEC3\"}}, {view}}}]"));
    let text = text.replace("\"POSITION\": 0", "\"POSITION\": 0, \"COLOR_0\": 1");
    let said = text.replace("\"byteOffset\": 12", "\"byteOffset\": 12, \"normalized\": true");
    let colors = |text: &str| parts_of(text).0[0].mesh.colors.clone();
    assert_eq!(colors(&text), colors(&said));
    assert_eq!(colors(&text)[0], glam::Vec3::new(0.0, 0.0, 128.0 / 255.0));
}

#[test]
fn transforms_that_the_format_does_not_allow_give_a_line() {
    let warnings = |node: &str| parts_of(&triangle(&format!(r#"[{{"mesh": 0, {node}}}]"#), "")).1;
    let matrix = |last: f32| format!(r#""matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, {last}]"#);
    assert!(warnings(&matrix(1.0)).is_empty() && warnings("\"scale\": [2, 2, 2]").is_empty());
    let both = warnings(&format!("{}, \"scale\": [2, 2, 2]", matrix(1.0)));
    assert!(both.len() == 1 && both[0].contains("1 nodes have a matrix beside a translation"), "{both:?}");
    let uneven = warnings(&matrix(2.0));
    assert!(uneven.len() == 1 && uneven[0].contains("whose last row is not 0 0 0 1"), "{uneven:?}");
}

#[test]
fn numbers_and_cameras_that_are_not_taken_are_told() {
    let camera = r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]"#;
    let text = |nodes: &str| triangle(nodes, camera);
    let one = text(r#"[{"mesh": 0}, {"camera": 0}]"#);
    assert!(parts_of(&one).1.is_empty());
    let (_, two) = parts_of(&text(r#"[{"mesh": 0}, {"camera": 0}, {"camera": 0}]"#));
    assert!(two.len() == 1 && two[0].contains("of its 2 cameras the first is taken"), "{two:?}");
    for (from, to) in [
        (r#""metallicFactor": 0"#, r#""metallicFactor": 1.5"#),
        ("0.8, 0.4", "-0.8, 0.4"),
        (r#""metallicFactor": 0}"#, r#""metallicFactor": 0}, "emissiveFactor": [2, 0, 0]"#),
    ] {
        let (_, told) = parts_of(&one.replace(from, to));
        assert!(told.len() == 1 && told[0].contains("out of range"), "{to}: {told:?}");
    }
}

/// A floor would hide such a light.
#[test]
fn no_floor_is_added_above_a_light() {
    let lights = r#", "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional"}, {"type": "point"}]}}"#;
    let folder = tempfile::tempdir().unwrap();
    let read = |place: &str, light: u32| {
        let of = format!(r#""extensions": {{"KHR_lights_punctual": {{"light": {light}}}}}"#);
        let path = folder.path().join("m.gltf");
        std::fs::write(&path, triangle(&format!(r#"[{{"mesh": 0}}, {{{place}, {of}}}]"#), lights)).unwrap();
        let (scene, warnings) = crate::load_with_warnings(&path).unwrap();
        (scene.objects.len(), warnings.iter().any(|w| w.contains("no floor is added")))
    };
    // Sideways, down and up; beside and below.
    assert_eq!(read(r#""translation": [0, 0, 0]"#, 0), (2, false));
    assert_eq!(read(r#""rotation": [-0.5, 0, 0, 0.8660254]"#, 0), (2, false));
    assert_eq!(read(r#""rotation": [0.5, 0, 0, 0.8660254]"#, 0), (1, true));
    assert_eq!(read(r#""translation": [3, 0.5, 0]"#, 1), (2, false));
    assert_eq!(read(r#""translation": [0, -2, 0]"#, 1), (1, true));
}

/// With a copy of all nodes for each clip they take half a minute.
#[test]
fn many_clips_of_many_nodes_are_read_soon() {
    let begin = std::time::Instant::now();
    let (nodes, clips) = (20_000, 5000);
    let clip = r#"{"samplers": [{"input": 1, "output": 0}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}"#;
    let text = triangle(
        &format!(r#"[{{"mesh": 0}}{}]"#, ", {}".repeat(nodes)),
        &format!(r#", "animations": [{}]"#, vec![clip; clips].join(", ")),
    );
    let times = r#"{"componentType": 5126, "count": 3, "type": "SCALAR"}"#;
    let text = text.replace("\"type\": \"VEC3\"}]", &format!("\"type\": \"VEC3\"}}, {times}]"));
    let (parts, warnings) = parts_of(&text);
    assert_eq!((parts.len(), warnings.len()), (1, 0), "{warnings:?}");
    assert!(begin.elapsed().as_secs_f64() < 10.0, "{:?}", begin.elapsed());
}
