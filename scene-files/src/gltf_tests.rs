use crate::context::Context;
use crate::gltf_file;
use crate::part::Part;
use brdf::{Brdf, Material, MetallicRoughness};
use glam::Vec3;
use scene::{Camera, Projection};
use std::path::Path;

/// A triangle (0,0,0), (1,0,0), (0,1,0) as f32 positions in a data URI, with more top-level keys.
pub(crate) fn triangle(nodes: &str, more: &str) -> String {
    let uri = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset": {{"version": "2.0"}},
"buffers": [{{"byteLength": 36, "uri": "{uri}"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 36}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
"materials": [{{"pbrMetallicRoughness": {{"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0}}}}],
"nodes": {nodes}{more}}}"#
    )
}

fn parse(text: &str) -> Result<(Vec<Part>, Option<Camera>), String> {
    gltf_file::parse(Path::new("m.gltf"), text.as_bytes(), None, &mut Context::default())
        .map(|file| (file.parts, file.camera))
        .map_err(|e| e.to_string())
}

#[test]
fn node_transforms_multiply_from_the_root() {
    let nodes = r#"[{"children": [1], "translation": [0, 0, 5]}, {"mesh": 0, "scale": [2, 2, 2],
        "rotation": [0, 0, 0.70710678, 0.70710678]}]"#;
    let (parts, camera) = parse(&triangle(nodes, "")).unwrap();
    assert!(camera.is_none());
    let got = &parts[0].mesh.positions;
    // Scaled by 2, turned by 90° about z, moved by 5 along z.
    for (p, want) in got.iter().zip([[0.0, 0.0, 5.0], [0.0, 2.0, 5.0], [-2.0, 0.0, 5.0]]) {
        assert!((*p - Vec3::from_array(want)).length() < 1e-5, "{p}");
    }
    let want: Material = MetallicRoughness::new(Vec3::new(0.8, 0.4, 0.2), 0.0, 1.0).unwrap().into();
    assert_eq!(parts[0].material, Some((0, want.into())));
}

#[test]
fn camera_follows_its_node() {
    let camera = r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]"#;
    let nodes = r#"[{"mesh": 0}, {"camera": 0, "translation": [0, 3, 0], "rotation": [0, 0.70710678, 0, 0.70710678]}]"#;
    let camera = parse(&triangle(nodes, camera)).unwrap().1.unwrap();
    assert_eq!((camera.eye, camera.projection), (Vec3::new(0.0, 3.0, 0.0), Projection::perspective(0.7)));
    // Turned by 90° about y, −z becomes −x.
    assert!(((camera.target - camera.eye).normalize() - Vec3::NEG_X).length() < 1e-6);
}

#[test]
fn orthographic_cameras_are_read() {
    let of = |numbers: &str| {
        let camera = format!(r#", "cameras": [{{"type": "orthographic", "orthographic": {{{numbers}}}}}]"#);
        let nodes = r#"[{"mesh": 0}, {"camera": 0, "translation": [0, 3, 0], "scale": [2, 2, 2]}]"#;
        parse(&triangle(nodes, &camera)).map(|read| read.1)
    };
    let camera = of(r#""xmag": 3, "ymag": 1.5, "znear": 0, "zfar": 9"#).unwrap().unwrap();
    // Half of the picture.
    assert_eq!((camera.eye, camera.projection), (Vec3::Y * 3.0, Projection::Orthographic { height: 3.0 }));
    for wrong in [
        r#""xmag": 0, "ymag": 1, "znear": 0, "zfar": 9"#,
        r#""xmag": 1, "ymag": 0, "znear": 0, "zfar": 9"#,
        r#""xmag": 1, "ymag": -2, "znear": 0, "zfar": 9"#,
        r#""xmag": 1, "ymag": 1, "znear": 3, "zfar": 3"#,
        r#""xmag": 1, "ymag": 1, "znear": -1, "zfar": 3"#,
    ] {
        let message = of(wrong).err().unwrap().to_string();
        assert!(message.contains("camera 0: xmag and ymag must be positive, and zfar beyond znear"), "{message}");
    }
    let (nodes, empty) = (r#"[{"mesh": 0}, {"camera": 0}]"#, r#", "cameras": [{"type": "orthographic"}]"#);
    assert_eq!(parse(&triangle(nodes, empty)).unwrap().1, None);
    assert!(
        of(r#""xmag": 1e38, "ymag": 1e38, "znear": 0, "zfar": 9"#)
            .err()
            .unwrap()
            .to_string()
            .contains("camera height is")
    );
}

#[test]
fn faults_are_named() {
    let with = |nodes: &str, more: &str| parse(&triangle(nodes, more)).err().unwrap();
    for (nodes, more, words) in [
        (r#"[{"mesh": 7}]"#, "", "no mesh 7"),
        (r#"[{"children": [0], "mesh": 0}]"#, "", "cycle"),
        (r#"[{"children": [2]}, {"children": [2]}, {"mesh": 0}]"#, "", "two parents"),
        (r#"[{"children": [9]}]"#, "", "node 0: there is no node 9"),
        (r#"[{"children": [9]}]"#, r#", "scenes": [{"nodes": [0]}]"#, "node 0: there is no node 9"),
        (r#"[{"mesh": 0}]"#, r#", "scenes": [{"nodes": [5]}]"#, "the scene names node 5"),
        (r#"[{"mesh": 0, "skin": 0}]"#, "", "no skin 0"),
        (r#"[{"mesh": 0}]"#, r#", "scene": 4"#, "no scene 4"),
        (r#"[{"mesh": 0}]"#, r#", "extensionsRequired": ["KHR_draco_mesh_compression"]"#, "KHR_draco_mesh_compression"),
        (r#"[{"mesh": 0}]"#, r#", "extensionsRequired": ["KHR_materials_sheen"]"#, "KHR_materials_sheen"),
    ] {
        let message = with(nodes, more);
        assert!(message.starts_with("m.gltf: ") && message.contains(words), "{message}");
    }
    // glTF 1.0 has tables where 2.0 has arrays.
    let message = parse(r#"{"asset": {"version": "1.0"}, "scenes": {}}"#).err().unwrap();
    assert!(message.contains("glTF 1.0: only glTF 2.0 is read"), "{message}");
    let shifted = triangle(r#"[{"mesh": 0}]"#, "").replace("\"count\": 3", "\"byteOffset\": 1, \"count\": 2");
    let message = parse(&shifted).err().unwrap();
    assert!(message.contains("accessor 0: begins at byte 1") && message.contains("multiple of 4"), "{message}");
    let message = parse("{\n\"asset\": {\"version\": \"2.0\"},\n}").err().unwrap();
    assert!(message.starts_with("m.gltf:3:"), "{message}");
}

#[test]
fn no_cut_of_a_document_panics() {
    let whole = triangle(r#"[{"mesh": 0}]"#, "");
    for end in 0..whole.len() {
        assert!(parse(&whole[..end]).is_err());
    }
    // A GLB around it, cut everywhere and with every header byte flipped.
    let mut json = whole.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((20 + json.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json);
    let read = |bytes: &[u8]| gltf_file::parse(Path::new("m.glb"), bytes, None, &mut Context::default());
    assert_eq!(read(&glb).unwrap().parts.len(), 1);
    for end in 0..glb.len() {
        assert!(read(&glb[..end]).is_err());
    }
    for i in 0..20 {
        let mut broken = glb.clone();
        broken[i] ^= 0xff;
        assert!(read(&broken).is_err(), "{i}");
    }
}

#[test]
fn what_a_primitive_or_material_names_wrongly_is_told_of_it() {
    let whole = triangle(r#"[{"mesh": 0}]"#, "");
    let fault = |text: &str| parse(text).err().unwrap();
    let message = fault(&whole.replace("\"material\": 0", "\"material\": 3"));
    assert!(message.contains("mesh 0, primitive 0: there is no material 3"), "{message}");
    let with = |key: &str, more: &str| {
        let text = whole.replace("\"materials\": [{", &format!("\"materials\": [{{{key}, "));
        text.replace("\"nodes\"", &format!("{more}\"nodes\""))
    };
    let normal = r#""normalTexture": {"index": 2}"#;
    let message = fault(&with(normal, ""));
    assert!(message.contains("material 0: there is no texture 2"), "{message}");
    let textures = r#""textures": [{}, {}, {"source": 4}], "images": [{"uri": "a.png"}], "#;
    let message = fault(&with(normal, textures));
    assert!(message.contains("texture 2: there is no image 4"), "{message}");
    for textures in [textures.replace('4', "0"), textures.replace(r#"{"source": 4}"#, "{}")] {
        assert_eq!(parse(&with(normal, &textures)).unwrap().0.len(), 1);
    }
    let base = whole.replace("\"metallicFactor\": 0", r#""metallicFactor": 0, "baseColorTexture": {"index": 0}"#);
    assert!(fault(&base).contains("there is no texture 0"));
}

/// A wrong length in the header is reported as such.
#[test]
fn lengths_in_the_header_of_a_binary_file() {
    let uri = triangle(r#"[{"mesh": 0}]"#, "");
    let start = uri.find(", \"uri\"").unwrap();
    let end = start + uri[start..].find("}]").unwrap();
    let mut json = format!("{}{}", &uri[..start], &uri[end..]).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut data = Vec::new();
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        data.extend(x.to_le_bytes());
    }
    let glb = |length: usize| {
        let mut all = b"glTF".to_vec();
        for word in [2, length as u32, json.len() as u32, 0x4e4f_534a] {
            all.extend(word.to_le_bytes());
        }
        all.extend(&json);
        all.extend((data.len() as u32).to_le_bytes());
        all.extend(0x004e_4942_u32.to_le_bytes());
        all.extend(&data);
        all
    };
    let whole = glb(0).len();
    let read = |bytes: &[u8]| {
        let read = gltf_file::parse(Path::new("m.glb"), bytes, None, &mut Context::default());
        read.map(|file| file.parts.len()).map_err(|e| e.to_string())
    };
    assert_eq!(read(&glb(whole)), Ok(1));
    for length in [0, 12, 20, 20 + json.len(), whole - 1] {
        let message = read(&glb(length)).unwrap_err();
        assert!(message.contains(&format!("the header says that the file has {length} bytes")), "{message}");
    }
    assert!(read(&glb(whole + 1)).unwrap_err().contains("file ends early"));
    // Padding after the length in the header is ignored.
    let mut padded = glb(whole);
    padded.extend([0; 16]);
    assert_eq!(read(&padded), Ok(1));
}

/// Also where the texture has no effect: occlusion, and unlit materials.
#[test]
fn textures_that_do_not_exist_are_refused_wherever_they_are_named() {
    let document = |material: &str, more: &str| {
        let own = r#"{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0}}"#;
        triangle(r#"[{"mesh": 0}]"#, more).replace(own, material)
    };
    let unlit = r#"{"extensions": {"KHR_materials_unlit": {}}, "normalTexture": {"index": 0}}"#;
    let coat = r#"{"extensions": {"KHR_materials_specular": {"specularColorTexture": {"index": 0}}}}"#;
    let [weight, normal] = ["clearcoatTexture", "clearcoatNormalTexture"].map(|name| {
        let fields = format!(r#""clearcoatFactor": 1, "{name}": {{"index": 0}}"#);
        format!(r#"{{"extensions": {{"KHR_materials_clearcoat": {{{fields}}}}}}}"#)
    });
    let [occlusion, base] = [r#"{"occlusionTexture": {"index": 0}}"#, r#"{"normalTexture": {"index": 0}}"#];
    for material in [occlusion, base, unlit, coat, &weight, &normal] {
        let message = parse(&document(material, "")).err().expect(material);
        assert!(message.contains("material 0: ") && message.contains("there is no texture 0"), "{message}");
        let message = parse(&document(material, r#", "textures": [{"source": 3}]"#)).err().expect(material);
        assert!(message.contains("material 0: ") && message.contains("texture 0: there is no image 3"), "{message}");
    }
}

/// KHR_materials_specular: alpha is the coat's weight, sRGB colours those of its reflectance at normal incidence.
#[test]
fn textures_of_the_coat_are_its_factors() {
    let folder = tempfile::tempdir().unwrap();
    let image = image::RgbaImage::from_pixel(2, 2, image::Rgba([255, 128, 0, 51]));
    image.save(folder.path().join("s.png")).unwrap();
    let own = r#"{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0}}"#;
    let specular = r#"{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0},
        "extensions": {"KHR_materials_ior": {"ior": 2}, "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": {"index": 0},
        "specularColorFactor": [1, 1, 0.5], "specularColorTexture": {"index": 0}}}}"#;
    let images = r#", "textures": [{"source": 0}], "images": [{"uri": "s.png"}]"#;
    let text = triangle(r#"[{"mesh": 0}]"#, images).replace(own, specular);
    let path = folder.path().join("m.gltf");
    std::fs::write(&path, &text).unwrap();
    let (scene, warnings) = crate::load_with_warnings(&path).unwrap();
    assert!(warnings.iter().all(|w| w.contains("no texture coordinates")), "{warnings:?}");
    let number = scene.objects[1].material;
    let surface = scene.surface(number).unwrap();
    let (color, weight) = (surface.specular.as_ref().unwrap(), surface.coat.as_ref().unwrap());
    assert!(weight.index == 3 && weight.map.texture.is_same(&color.texture), "one image in memory");
    let got = scene.materials[number].scaled(&surface.factors(&|_| scene::TexturePlace::default()));
    // An index of 2 reflects a ninth.
    let (f90, half) = (0.5 * 51.0 / 255.0, 0.215_861);
    let f0 = Vec3::new(1.0, half, 0.0) * f90 / 9.0;
    let want = MetallicRoughness::new(Vec3::new(0.8, 0.4, 0.2), 0.0, 1.0).and_then(|m| m.with_coat(f0, f90)).unwrap();
    let at = lobe_core::Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
    for v in [Vec3::Z, Vec3::new(-0.6, 0.0, 0.8), Vec3::new(0.0, 0.96, 0.28)] {
        let (got, want) = (got.eval(&at, v), want.eval(&at, v));
        assert!((got - want).abs().max_element() < 1e-4 * want.max_element(), "{got} {want}");
    }
    // An image that is not there leaves the factors alone.
    std::fs::write(&path, text.replace("s.png", "none.png")).unwrap();
    let (scene, warnings) = crate::load_with_warnings(&path).unwrap();
    assert!(scene.surface(number).is_none_or(|s| s.specular.is_none() && s.coat.is_none()));
    assert!(warnings.iter().any(|w| w.contains("image 0 is not there")), "{warnings:?}");
}

/// A triangle under a spot, a sun and a point, one of them turned.
#[test]
fn punctual_lights_are_read() {
    let told = |lights: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lit.gltf");
        let positions = "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}}, "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {{"KHR_lights_punctual": {{"lights": [{lights}]}}}},
            "buffers": [{{"uri": "{positions}", "byteLength": 36}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}}],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
            "nodes": [{{"mesh": 0}}, {{"translation": [0, 2, 0], "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}},
                {{"rotation": [-0.70710678, 0, 0, 0.70710678], "extensions": {{"KHR_lights_punctual": {{"light": 1}}}}}}]}}"#
        );
        std::fs::write(&path, text).unwrap();
        crate::load_with_warnings(&path).map(|(s, w)| (s.lights, w)).map_err(|e| e.to_string())
    };
    let lit = |lights: &str| told(lights).map(|(lights, _)| lights);
    let lights = lit(r#"{"type": "point", "intensity": 5, "color": [1, 0.5, 0]},
        {"type": "spot", "intensity": 3, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}}"#)
    .unwrap();
    let [lighting::Light::Sphere(point), lighting::Light::Spot(spot)] = lights[..] else { panic!("{lights:?}") };
    let intensity = point.radiance * std::f32::consts::PI * point.sphere.radius.powi(2);
    assert!((intensity - Vec3::new(5.0, 2.5, 0.0)).length() < 1e-4 && point.sphere.center == Vec3::Y * 2.0);
    assert!((spot.axis - Vec3::NEG_Y).length() < 1e-6, "−z turned by −90° about x: {}", spot.axis);
    assert!((spot.cos[0] - 0.2_f32.cos()).abs() < 1e-6 && (spot.cos[1] - 0.5_f32.cos()).abs() < 1e-6);
    let lights = lit(r#"{"type": "point"}, {"type": "directional", "intensity": 2}"#).unwrap();
    let [_, lighting::Light::Sun(sun)] = lights[..] else { panic!("{lights:?}") };
    assert!((sun.toward - Vec3::Y).length() < 1e-6);
    assert!((sun.radiance.x * std::f32::consts::PI * sun.sin.powi(2) - 2.0).abs() < 1e-4);
    let lights = lit(r#"{"type": "point", "range": 8}, {"type": "spot", "range": 3, "spot": {}}"#).unwrap();
    let [lighting::Light::Spot(point), lighting::Light::Spot(spot)] = lights[..] else { panic!("{lights:?}") };
    assert_eq!((point.range, point.cos, spot.range), (8.0, [-1.0; 2], 3.0));
    for (inner, outer, want, warning) in [
        (0.5, 0.5, [0.5, 0.5], ""),
        (0.9, 0.5, [0.5, 0.5], "light 0: innerConeAngle 0.9 is beyond outerConeAngle 0.5: the cone's edge is hard"),
        (0.5, 2.0, [0.5, 1.570_796_4], "light 0: outerConeAngle 2 is beyond π/2: it is taken as π/2"),
    ] {
        let angles = format!(r#"{{"innerConeAngle": {inner}, "outerConeAngle": {outer}}}"#);
        let (lights, warnings) =
            told(&format!(r#"{{"type": "spot", "spot": {angles}}}, {{"type": "point"}}"#)).unwrap();
        let lighting::Light::Spot(spot) = lights[0] else { panic!("{lights:?}") };
        assert_eq!(spot.cos, want.map(f32::cos));
        assert!(warnings.iter().all(|w| w.ends_with(warning)), "{warnings:?}");
        assert_eq!(warnings.is_empty(), warning.is_empty());
    }
    for (wrong, words) in [
        (r#"{"type": "point", "intensity": -5}, {"type": "point"}"#, "-5"),
        (r#"{"type": "laser"}, {"type": "point"}"#, "\"spot\""),
        (r#"{"type": "point", "range": 0}, {"type": "point"}"#, "range"),
        (r#"{"type": "spot", "spot": {"innerConeAngle": -1.2, "outerConeAngle": 0.3}}, {"type": "point"}"#, "-1.2"),
        (r#"{"type": "point"}"#, "no light 1"),
    ] {
        let message = lit(wrong).unwrap_err();
        assert!(message.contains(words), "{message}");
    }
}

/// The parts of a document, and its warnings.
pub(crate) fn parts_of(text: &str) -> (Vec<Part>, Vec<String>) {
    let mut context = Context::default();
    let file = gltf_file::parse(Path::new("m.gltf"), text.as_bytes(), None, &mut context).unwrap();
    (file.parts, context.warnings)
}

/// A document with a buffer, a view and an accessor of this type more for each list, numbered from 1.
pub(crate) fn with_floats(document: &str, lists: &[(&[f32], &str)]) -> String {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut document = document.to_owned();
    let mut append = |after: &str, text: String| {
        let end = format!("}}],\n\"{after}\"");
        assert!(document.contains(&end));
        document = document.replace(&end, &format!("}}, {text}],\n\"{after}\""));
    };
    for (k, (list, kind)) in lists.iter().enumerate() {
        let bytes: Vec<u8> = list.iter().flat_map(|x| x.to_le_bytes()).collect();
        let of = |c: &[u8]| c.iter().fold(0_usize, |sum, b| sum << 8 | usize::from(*b));
        let four = |c: &[u8]| [18, 12, 6, 0].map(|shift| char::from(DIGITS[of(c) >> shift & 63]));
        assert!(bytes.len().is_multiple_of(3));
        let base64: String = bytes.chunks_exact(3).flat_map(four).collect();
        let width = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|of| of == kind).unwrap() + 1;
        let (n, rows) = (bytes.len(), list.len() / width);
        append("bufferViews", format!("{{\"byteLength\": {n}, \"uri\": \"data:x;base64,{base64}\"}}"));
        append("accessors", format!("{{\"buffer\": {}, \"byteLength\": {n}}}", k + 1));
        let view = format!("{{\"bufferView\": {}, \"componentType\": 5126, ", k + 1);
        append("meshes", format!("{view}\"count\": {rows}, \"type\": \"{kind}\"}}"));
    }
    document
}

#[test]
fn instances_stand_where_nodes_would() {
    let turn = [0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    let places = [1.0, 2.0, 3.0, 0.0, 0.0, 5.0, 0.0, 0.0, 7.0];
    let nodes = r#"[{"translation": [10, 0, 0], "children": [1]}, {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing":
        {"attributes": {"TRANSLATION": 1, "ROTATION": 2, "_ID": 99}}}}]"#;
    let text = with_floats(&triangle(nodes, ""), &[(&places, "VEC3"), (&turn, "VEC4")]);
    let (parts, warnings) = parts_of(&text);
    assert!(warnings.is_empty(), "{warnings:?}");
    let got = &parts[0].mesh;
    assert_eq!((parts.len(), got.triangles.len(), got.positions.len()), (1, 3, 9));
    for (p, want) in got.positions.iter().zip([
        [11.0, 2.0, 3.0],
        [11.0, 3.0, 3.0],
        [10.0, 2.0, 3.0],
        [10.0, 0.0, 5.0],
        [11.0, 0.0, 5.0],
        [10.0, 1.0, 5.0],
        [10.0, 0.0, 7.0],
        [11.0, 0.0, 7.0],
        [10.0, 1.0, 7.0],
    ]) {
        assert!((*p - Vec3::from_array(want)).length() < 1e-5, "{p} {want:?}");
    }
    let other = text.replace("\"TRANSLATION\": 1", "\"TRANSLATION\": 7");
    assert!(parse(&other).err().unwrap().contains("node 1: instances: TRANSLATION: there is no accessor 7"));
    for name in ["COLOR_0", "_COLOR_0"] {
        let (_, warnings) = parts_of(&text.replace("_ID", name));
        let told = format!(" {name} of instances is not read");
        assert!(warnings.len() == 1 && warnings[0].contains(&told), "{warnings:?}");
    }
    let placeless = text.replace("TRANSLATION", "_A").replace("ROTATION", "_B");
    let (parts, warnings) = parts_of(&placeless);
    assert_eq!(parts[0].mesh.triangles.len(), 1);
    assert!(warnings.len() == 1 && warnings[0].contains("instances without a place are one"), "{warnings:?}");
    let uneven = text.replace("\"count\": 3, \"type\": \"VEC4\"", "\"count\": 2, \"type\": \"VEC4\"");
    assert!(parse(&uneven).err().unwrap().contains("different counts"));
}

#[test]
fn nodes_that_are_not_visible_show_nothing_below_them() {
    let hidden = r#""extensions": {"KHR_node_visibility": {"visible": false}}"#;
    let shown = r#""extensions": {"KHR_node_visibility": {"visible": true}}"#;
    let nodes = format!(
        r#"[{{"mesh": 0, {shown}}}, {{{hidden}, "children": [2]}}, {{"mesh": 0, {shown}, "children": [3]}},
        {{"camera": 0, "name": "eye"}}]"#
    );
    let camera = r#", "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]"#;
    let (parts, camera) = parse(&triangle(&nodes, camera)).unwrap();
    assert_eq!(parts.len(), 1);
    assert!(camera.is_some());
    let none = parse(&triangle(&format!(r#"[{{"mesh": 0, {hidden}}}]"#), "")).err().unwrap();
    assert!(none.contains("not visible"), "{none}");
}

#[test]
fn extensions_that_change_the_picture_are_told() {
    for (name, is_told) in [
        ("KHR_materials_clearcoat", false),
        ("KHR_materials_ior", false),
        ("KHR_materials_specular", false),
        ("KHR_materials_volume", true),
        ("KHR_materials_iridescence", true),
        ("KHR_materials_dispersion", true),
        ("KHR_materials_diffuse_transmission", true),
        ("KHR_materials_sheen", true),
        ("KHR_materials_anisotropy", false),
        ("KHR_materials_transmission", true),
        ("EXT_lights_image_based", true),
        ("EXT_lights_area", true),
        ("CESIUM_RTC", true),
        ("KHR_gaussian_splatting", true),
        ("VENDOR_never_heard_of", true),
        ("KHR_xmp_json_ld", false),
        ("KHR_draco_mesh_compression", false),
        ("KHR_node_visibility", false),
    ] {
        let listed = format!(", \"extensionsUsed\": [\"{name}\"]");
        // Some documents use what they do not list.
        let unlisted =
            format!(", \"extras\": {{\"extensions\": {{\"NOT_one\": {{}}}}}}, \"extensions\": {{\"{name}\": {{}}}}");
        for more in [listed, unlisted] {
            let (_, warnings) = parts_of(&triangle(r#"[{"mesh": 0}]"#, &more));
            assert_eq!(warnings.len(), usize::from(is_told), "{name}: {warnings:?}");
            assert!(warnings.iter().all(|line| line.contains(name)), "{warnings:?}");
        }
    }
}

#[test]
fn the_alpha_of_vertex_colours_cuts_all_nodes_of_a_mesh() {
    // Alpha 1, 0 and 1 at the corners: the line of a half leaves three quarters of the triangle.
    let colors = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let document = |nodes: &str, cutoff: &str| {
        let text = with_floats(&triangle(nodes, ""), &[(&colors, "VEC4")]);
        let text = text.replace("\"POSITION\": 0", "\"POSITION\": 0, \"COLOR_0\": 1");
        text.replace(
            "\"materials\": [{",
            &format!("\"materials\": [{{\"alphaMode\": \"MASK\", \"alphaCutoff\": {cutoff}, "),
        )
    };
    for nodes in [r#"[{"mesh": 0}]"#, r#"[{"mesh": 0}, {"mesh": 0, "translation": [0, 0, 3]}]"#] {
        let (parts, warnings) = parts_of(&document(nodes, "0.5"));
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!(parts.iter().all(|part| (part.mesh.area() - 0.375).abs() < 1e-5), "{}", parts[0].mesh.area());
        assert_eq!(parts[0].mesh.positions[0].z, 0.0);
        assert_eq!(parts.last().map(|part| part.mesh.positions[0].z), Some(if parts.len() == 2 { 3.0 } else { 0.0 }));
        let (parts, _) = parts_of(&document(nodes, "1.1"));
        assert!(parts.iter().all(|part| part.mesh.triangles.is_empty()));
    }
}

/// A document that is kept: parts by node, whole triangles where alpha cuts, turned ones named, nothing added.
#[test]
fn documents_are_kept_as_they_are() {
    let nodes = r#"[{"mesh": 0, "name": "plain"}, {"mesh": 0, "scale": [-1, 1, 1], "translation": [5, 0, 0]},
        {"mesh": 0, "scale": [0, 1, 1]}]"#;
    let text = triangle(nodes, r#", "extras": [1.50]"#);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.gltf");
    std::fs::write(&path, &text).unwrap();
    let (scene, animation, document, _) = crate::load_document(&path, &crate::LoadOptions::new()).unwrap();
    assert_eq!((scene.objects.len(), scene.lights.len(), animation.is_still()), (2, 0, true));
    assert_eq!((document.json, document.buffers[0].len()), (text, 36));
    let parts = &document.parts;
    let places: Vec<_> = parts.iter().map(|part| (part.node, part.mesh, part.primitive, part.copies)).collect();
    assert_eq!(places, [(0, 0, 0, 1), (1, 0, 0, 1), (2, 0, 0, 1)]);
    assert_eq!([0, 1, 2].map(|k| parts[k].object), [Some(0), Some(1), None]);
    assert_eq!([0, 1].map(|k| parts[k].is_turned), [false, true]);
    assert_eq!(parts[0].name, "plain");
    assert_eq!(parts[1].geometry.positions[1], Vec3::new(4.0, 0.0, 0.0));
    assert_eq!(parts[1].geometry.triangles, [[0, 2, 1]]);
    assert_eq!(parts[2].geometry.triangles.len(), 1);
    let other = folder.path().join("m.obj");
    std::fs::write(&other, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let fault = crate::load_document(&other, &crate::LoadOptions::new()).unwrap_err().to_string();
    assert!(fault.ends_with("m.obj: unknown kind of file: expected .gltf or .glb"), "{fault}");
}
