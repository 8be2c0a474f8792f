//! Normals as the formats mean them, and as they are requested.

#![expect(clippy::unwrap_used, reason = "a test")]

use glam::Vec3;
use scene::{Mesh, Scene, Shape};
use scene_files::{LoadOptions, Normals};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const CORNERS: [[f32; 3]; 8] = [
    [-0.5, -0.5, -0.5],
    [-0.5, -0.5, 0.5],
    [-0.5, 0.5, -0.5],
    [-0.5, 0.5, 0.5],
    [0.5, -0.5, -0.5],
    [0.5, -0.5, 0.5],
    [0.5, 0.5, -0.5],
    [0.5, 0.5, 0.5],
];
const FACES: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];

/// The cube's corners and these lines; `{}` is replaced by a face's corners, counted from 1.
fn obj(lines: &str, faces: impl Fn(usize, String) -> String) -> String {
    let mut text = String::new();
    CORNERS.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    text += lines;
    for (k, face) in FACES.iter().enumerate() {
        text += &faces(k, face.map(|i| (i + 1).to_string()).join(" "));
    }
    text
}

fn ply(split: bool) -> String {
    let all: Vec<[f32; 3]> =
        if split { FACES.iter().flatten().map(|&i| CORNERS[i]).collect() } else { CORNERS.to_vec() };
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face 6\n\
         property list uchar int vertex_indices\nend_header\n",
        all.len()
    );
    all.iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    for (k, face) in FACES.iter().enumerate() {
        let face = if split { [4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3] } else { *face };
        writeln!(text, "4 {}", face.map(|i| i.to_string()).join(" ")).unwrap();
    }
    text
}

/// A glTF of the cube, with normals or without.
fn gltf(folder: &Path, normals: Option<[Vec3; 8]>) -> String {
    let mut bytes: Vec<u8> = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    normals.iter().flatten().for_each(|n| bytes.extend(n.to_array().iter().flat_map(|x| x.to_le_bytes())));
    let first = bytes.len();
    for [a, b, c, d] in FACES {
        bytes.extend([a, b, c, a, c, d].map(|i| i as u8));
    }
    fs::write(folder.join("cube.bin"), &bytes).unwrap();
    let normal = if normals.is_some() { r#", "NORMAL": 2"# } else { "" };
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"mesh": 0}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0{normal}}}, "indices": 1}}]}}],
"buffers": [{{"byteLength": {}, "uri": "cube.bin"}}],
"bufferViews": [{{"buffer": 0, "byteLength": {first}}}, {{"buffer": 0, "byteOffset": {first}, "byteLength": 36}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"}},
 {{"bufferView": 1, "componentType": 5121, "count": 36, "type": "SCALAR"}}{}]}}"#,
        bytes.len(),
        if normals.is_some() {
            r#", {"bufferView": 0, "byteOffset": 96, "componentType": 5126, "count": 8, "type": "VEC3"}"#
        } else {
            ""
        }
    )
}

/// All triangles of the model but for the floor.
fn meshes(scene: &Scene) -> Vec<&Mesh> {
    let mesh = |o: &scene::Object| o.name != "floor";
    let shape = |o: &'_ scene::Object| matches!(o.shape, Shape::Mesh(_));
    let models = scene.objects.iter().filter(|o| mesh(o) && shape(o));
    models.filter_map(|o| if let Shape::Mesh(mesh) = &o.shape { Some(mesh) } else { None }).collect()
}

/// The largest angle in degrees between a normal and its face, face by face of the cube: 0 to 5 by its axis and side.
fn tilts(scene: &Scene) -> [f64; 6] {
    let mut most = [0.0f64; 6];
    for mesh in meshes(scene) {
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
            let face = (b - a).cross(c - a).normalize();
            let normals = t.map(|i| mesh.normals.get(i as usize).map_or(face, |n| n.as_dvec3()));
            let axis = (0..3).find(|&k| face[k].abs() > 0.9).unwrap();
            for n in normals {
                let angle = face.dot(n).abs().clamp(0.0, 1.0).acos().to_degrees();
                let side = 2 * axis + usize::from(a[axis] > 0.0);
                most[side] = most[side].max(angle);
            }
        }
    }
    most
}

fn load(folder: &Path, name: &str, text: &str, normals: Normals) -> (Scene, Vec<String>) {
    let file = folder.join(name);
    fs::write(&file, text).unwrap();
    let (scene, _, warnings) = scene_files::load_with(&file, &LoadOptions::new().with_normals(normals)).unwrap();
    scene.validate().unwrap();
    (scene, warnings)
}

const ROUND: f64 = 54.7356;

fn is_flat(tilts: [f64; 6]) -> bool {
    tilts.iter().all(|t| *t < 0.05)
}

fn is_round(tilts: [f64; 6]) -> bool {
    tilts.iter().all(|t| (t - ROUND).abs() < 0.05)
}

#[test]
fn files_without_normals_mean_what_their_formats_say() {
    let folder = TempDir::new().unwrap();
    let read = |name: &str, text: &str| {
        let (scene, warnings) = load(folder.path(), name, text, Normals::File);
        (tilts(&scene), warnings)
    };
    let plain = |_: usize, f: String| format!("f {f}\n");
    for (lines, flat) in [
        ("", true),
        ("s off\n", true),
        ("s 0\n", true),
        ("s\n", true),
        ("s 1\n", false),
        ("s on\n", false),
        ("s -1\n", false),
        ("s 4294967296\n", false),
    ] {
        let (tilts, warnings) = read("c.obj", &obj(lines, plain));
        assert!(if flat { is_flat(tilts) } else { is_round(tilts) }, "{lines:?}: {tilts:?}");
        assert!(warnings.is_empty(), "{warnings:?}");
    }
    let (tilts, _) = read("c.obj", &obj("", |k, f| format!("s {}\nf {f}\n", k + 1)));
    assert!(is_flat(tilts), "{tilts:?}");
    assert!(is_flat(read("c.gltf", &gltf(folder.path(), None)).0));
    assert!(is_flat(read("c.ply", &ply(true)).0));
    let (tilts, warnings) = read("c.ply", &ply(false));
    assert!(is_round(tilts) && warnings.len() == 1 && warnings[0].contains("edges included"), "{tilts:?} {warnings:?}");
}

/// The corners of a face in the other direction.
fn back(face: &str) -> String {
    face.split(' ').rev().collect::<Vec<_>>().join(" ")
}

#[test]
fn faces_that_wind_against_others_are_smooth() {
    let folder = TempDir::new().unwrap();
    for turned in 0_u32..64 {
        let is_turned = |k: usize| turned >> k & 1 == 1;
        let face = |k: usize, f: String| if is_turned(k) { back(&f) } else { f };
        let group = obj("s 1\n", |k, f| format!("f {}\n", face(k, f)));
        let all = obj("", |k, f| format!("f {}\n", face(k, f)));
        for (text, normals) in [(group, Normals::File), (all, Normals::SMOOTH)] {
            let (scene, _) = load(folder.path(), "c.obj", &text, normals);
            let mesh = meshes(&scene)[0];
            let sides: Vec<f32> =
                mesh.positions.iter().zip(&mesh.normals).map(|(p, n)| p.normalize().dot(*n)).collect();
            assert!(sides.iter().all(|side| side * sides[0] > 0.999), "{turned:b}: {sides:?}");
            // The most of the faces say which side is the front.
            let front = turned.count_ones().cast_signed() - 3;
            assert!(front == 0 || (front < 0) == (sides[0] > 0.0), "{turned:b}: {sides:?}");
        }
    }
}

/// −x and +x in one group share no edge; −y and +y, −z and +z are flat or another group.
#[test]
fn groups_end_where_they_end() {
    let folder = TempDir::new().unwrap();
    let read = |text: &str| tilts(&load(folder.path(), "c.obj", text, Normals::File).0);
    // The faces' order is −x, +x, −y, +y, −z, +z: +y and +z meet in one edge.
    let two = read(&obj("", |k, f| format!("s {}\nf {f}\n", usize::from(k == 3 || k == 5))));
    for (k, tilt) in two.into_iter().enumerate() {
        let want = if k == 3 || k == 5 { 45.0 } else { 0.0 };
        assert!((tilt - want).abs() < 0.05, "{two:?}");
    }
    // A group goes on over materials, and a face that is there twice counts once.
    let materials = read(&obj("", |k, f| format!("usemtl m{k}\ns 1\nf {f}\n")));
    assert!(is_round(materials), "{materials:?}");
    let twice = read(&obj("s 1\n", |_, f| format!("f {f}\nf {}\n", back(&f))));
    assert!(is_round(twice), "{twice:?}");
    // A group holds until the next `s`, over objects.
    let objects = read(&obj("s 3\n", |k, f| format!("o part{k}\ng g{k}\nf {f}\n")));
    assert!(is_round(objects), "{objects:?}");
}

#[test]
fn faces_without_normals_beside_others_get_their_own() {
    let folder = TempDir::new().unwrap();
    // Of all faces but one, normals that lean; that one has none. Kept where they are given.
    let lean = Vec3::new(0.6, 0.8, 0.0);
    let lines = format!("vn {} {} {}\nvn 0 0 0\nvn nan 1 0\n", lean.x, lean.y, lean.z);
    let with = |f: &str, n: u32| f.split(' ').map(|i| format!("{i}//{n}")).collect::<Vec<_>>().join(" ");
    let (scene, warnings) = load(
        folder.path(),
        "c.obj",
        &obj(&lines, |k, f| match k {
            3 => format!("f {}\n", with(&f, 1)),
            4 => format!("f {}\n", with(&f, 2)),
            5 => format!("f {}\n", with(&f, 3)),
            _ => format!("f {f}\n"),
        }),
        Normals::File,
    );
    let tilts = tilts(&scene);
    for (k, tilt) in tilts.into_iter().enumerate() {
        let want = if k == 3 { 0.8f64.acos().to_degrees() } else { 0.0 };
        assert!((tilt - want).abs() < 0.05, "{tilts:?}");
    }
    assert!(warnings.len() == 1 && warnings[0].contains("12 corners"), "{warnings:?}");
}

#[test]
fn broken_and_stray_normals_are_mended_and_told() {
    let folder = TempDir::new().unwrap();
    let outward = CORNERS.map(|p| Vec3::from_array(p).normalize());
    for (bad, word) in [(Vec3::ZERO, "no direction"), (Vec3::NAN, "no direction"), (-outward[5], "turned round")] {
        let mut normals = outward;
        normals[5] = bad;
        let (scene, warnings) = load(folder.path(), "c.gltf", &gltf(folder.path(), Some(normals)), Normals::File);
        let mesh = meshes(&scene)[0];
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(p.normalize().dot(*n) > 0.999, "{p} {n} of {bad}");
        }
        assert!(warnings.len() == 1 && warnings[0].contains(word), "{bad}: {warnings:?}");
    }
    // All inward: the other side of every face.
    let inward = outward.map(|n| -n);
    let (_, warnings) = load(folder.path(), "c.gltf", &gltf(folder.path(), Some(inward)), Normals::File);
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn requested_normals_are_those_of_all_formats() {
    let folder = TempDir::new().unwrap();
    let outward = CORNERS.map(|p| Vec3::from_array(p).normalize());
    let plain = |_: usize, f: String| format!("f {f}\n");
    let files = [
        ("c.obj", obj("s 1\n", plain)),
        ("d.obj", obj("", plain)),
        ("c.ply", ply(false)),
        ("d.ply", ply(true)),
        ("c.gltf", gltf(folder.path(), None)),
        ("c.gltf", gltf(folder.path(), Some(outward))),
    ];
    for (number, (name, text)) in files.into_iter().enumerate() {
        // The last glTF's bytes lie beside it.
        gltf(folder.path(), (number == 5).then_some(outward));
        let read = |normals| load(folder.path(), name, &text, normals);
        assert!(is_flat(tilts(&read(Normals::Face).0)), "{name}");
        assert!(is_flat(tilts(&read(Normals::Smooth { crease: 60.0 }).0)), "{name}");
        assert!(is_round(tilts(&read(Normals::SMOOTH).0)), "{name}");
        let (round, warnings) = read(Normals::Smooth { crease: 91.0 });
        assert!(is_round(tilts(&round)), "{name}");
        let told = warnings.iter().any(|w| w.contains("has no normals: they are made smooth"));
        assert_eq!(told, number != 5, "{name}: {warnings:?}");
    }
}

#[test]
fn scene_files_choose_for_each_object() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("c.obj"), obj("", |_, f| format!("f {f}\n"))).unwrap();
    let read = |keys: &str, normals: Normals| {
        let text = format!("[[objects]]\nmesh = \"c.obj\"\n{keys}");
        let file = folder.path().join("s.toml");
        fs::write(&file, text).unwrap();
        scene_files::load_with(&file, &LoadOptions::new().with_normals(normals))
            .map(|(scene, _, warnings)| (tilts(&scene), warnings))
            .map_err(|e| e.to_string())
    };
    assert!(is_flat(read("", Normals::File).unwrap().0) && is_round(read("", Normals::SMOOTH).unwrap().0));
    assert!(is_flat(read("normals = \"file\"", Normals::SMOOTH).unwrap().0));
    assert!(is_flat(read("normals = \"smooth\"\ncrease = 45", Normals::File).unwrap().0));
    let (tilts, warnings) = read("normals = \"smooth\"", Normals::Face).unwrap();
    assert!(is_round(tilts) && warnings.len() == 1 && warnings[0].contains("edges included"), "{warnings:?}");
    for (keys, word) in [
        ("crease = 45", "s.toml:3"),
        ("normals = \"face\"\ncrease = 45", "s.toml:4"),
        ("normals = \"smooth\"\ncrease = 181", "between 0 and 180"),
        ("normals = \"smooth\"\ncrease = 0", "greater than 0"),
        ("normals = \"round\"", "expected \"file\", \"face\" or \"smooth\""),
    ] {
        let error = read(keys, Normals::File).unwrap_err();
        assert!(error.contains(word), "{keys}: {error}");
    }
}
