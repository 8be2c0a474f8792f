//! The maths of clips, skins and morph targets, on small documents made here, against closed forms in f64.

#![expect(clippy::unwrap_used, reason = "a test")]

use glam::{DQuat, DVec3, Vec3};
use scene::{Animation, Projection, Proxy, Scene, SceneError, Shape};
use std::f32::consts::FRAC_1_SQRT_2;
use std::fmt::Write as _;

/// A glTF document whose accessors are put together one by one.
#[derive(Default)]
struct Document {
    data: Vec<u8>,
    views: String,
    accessors: String,
    count: usize,
}

impl Document {
    fn add(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize, more: &str) -> usize {
        let comma = if self.count > 0 { ", " } else { "" };
        let (offset, length) = (self.data.len(), bytes.len());
        write!(self.views, r#"{comma}{{"buffer": 0, "byteOffset": {offset}, "byteLength": {length}}}"#).unwrap();
        let n = self.count;
        let accessor = format!(
            r#"{comma}{{"bufferView": {n}, "componentType": {component}, "count": {count}, "type": "{kind}"{more}}}"#
        );
        self.accessors += &accessor;
        self.data.extend(bytes);
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        self.count += 1;
        n
    }

    fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width =
            [("SCALAR", 1), ("VEC3", 3), ("VEC4", 4), ("MAT4", 16)].into_iter().find(|k| k.0 == kind).unwrap().1;
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(&bytes, 5126, kind, values.len() / width, "")
    }

    fn vectors(&mut self, values: &[Vec3]) -> usize {
        self.floats(&values.iter().flat_map(|v| v.to_array()).collect::<Vec<_>>(), "VEC3")
    }

    fn bytes(&mut self, values: &[u8], kind: &str, more: &str) -> usize {
        self.add(values, 5121, kind, values.len() / 4, more)
    }

    /// The text, with the rest of the top-level keys.
    fn text(&self, rest: &str) -> String {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {}, "uri": "data:;base64,{}"}}],
"bufferViews": [{}], "accessors": [{}], {rest}}}"#,
            self.data.len(),
            base64(&self.data),
            self.views,
            self.accessors
        )
    }
}

fn base64(data: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in data.chunks(3) {
        let word = (0..3).fold(0_u32, |w, k| w << 8 | u32::from(*chunk.get(k).unwrap_or(&0)));
        for k in 0..=chunk.len() {
            out.push(char::from(DIGITS[(word >> (18 - 6 * k) & 63) as usize]));
        }
    }
    out
}

fn load(text: &str, clip: Option<&str>) -> Result<(Scene, Animation, Vec<String>), SceneError> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("m.gltf");
    std::fs::write(&file, text).unwrap();
    match clip {
        None => scene_files::load_animated(&file),
        Some(clip) => scene_files::load_clip(&file, clip),
    }
}

fn positions(scene: &Scene) -> &[Vec3] {
    // Object 0 is the floor.
    match &scene.objects[1].shape {
        Shape::Mesh(mesh) => &mesh.positions,
        _ => panic!(),
    }
}

fn normals(scene: &Scene) -> &[Vec3] {
    match &scene.objects[1].shape {
        Shape::Mesh(mesh) => &mesh.normals,
        _ => panic!(),
    }
}

fn near(got: Vec3, want: impl Into<DVec3>) -> bool {
    let want: DVec3 = want.into();
    got.as_dvec3().distance(want) < 2e-6 * want.length().max(1.0)
}

const CORNERS: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

/// A triangle whose node 1 has one channel; node 0 is its parent, moved by (0, 0, 5).
fn one_channel(path: &str, interpolation: &str, times: &[f32], values: &[f32], kind: &str) -> String {
    let mut d = Document::default();
    let p = d.vectors(&CORNERS);
    let (t, v) = (d.floats(times, "SCALAR"), d.floats(values, kind));
    d.text(&format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {p}}}}}]}}],
"nodes": [{{"children": [1], "translation": [0, 0, 5]}}, {{"mesh": 0}}],
"animations": [{{"name": "Go", "channels": [{{"sampler": 0, "target": {{"node": 1, "path": "{path}"}}}}],
"samplers": [{{"input": {t}, "output": {v}, "interpolation": "{interpolation}"}}]}}]"#
    ))
}

#[test]
fn a_cubic_translation_follows_the_hermite_polynomial() {
    let times = [0.25_f32, 1.0, 3.0];
    // (incoming tangent, value, outgoing tangent) a key.
    let keys: Vec<[f32; 9]> = vec![
        [9.0, 9.0, 9.0, 1.0, 2.0, 3.0, 0.5, -1.0, 2.0],
        [-2.0, 0.0, 1.0, 4.0, -2.0, 0.5, 3.0, 1.0, -1.0],
        [0.25, 2.0, -3.0, -1.0, 1.0, 2.0, 9.0, 9.0, 9.0],
    ];
    let text = one_channel("translation", "CUBICSPLINE", &times, &keys.concat(), "VEC3");
    let (mut scene, animation, warnings) = load(&text, None).unwrap();
    assert!(warnings.is_empty() && animation.duration() == 3.0 && animation.clips() == ["Go"]);
    let key = |i: usize, k: usize| Vec3::from_slice(&keys[i][3 * k..3 * k + 3]).as_dvec3();
    for i in 0..=60 {
        let time = 0.05 * i as f32;
        animation.seek(time, &mut scene);
        let k = times.partition_point(|&t| t <= time).clamp(1, 2) - 1;
        let h = f64::from(times[k + 1]) - f64::from(times[k]);
        let x = (f64::from(time) - f64::from(times[k])).clamp(0.0, h);
        // p(x) = p0 + m0 x + c x² + d x³ with p(h) = p1, p'(h) = m1.
        let (p0, m0, p1, m1) = (key(k, 1), key(k, 2), key(k + 1, 1), key(k + 1, 0));
        let c = (3.0 * (p1 - p0) / h - 2.0 * m0 - m1) / h;
        let d = (m1 + m0 - 2.0 * (p1 - p0) / h) / (h * h);
        let want = p0 + x * (m0 + x * (c + x * d)) + DVec3::new(0.0, 0.0, 5.0);
        for (p, corner) in positions(&scene).iter().zip(CORNERS) {
            assert!(near(*p, want + corner.as_dvec3()), "{time}: {p} {want}");
        }
    }
}

#[test]
fn steps_happen_at_their_key_times() {
    let text = one_channel("scale", "STEP", &[0.5, 1.0, 2.0], &[1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0], "VEC3");
    let (mut scene, animation, _) = load(&text, Some("Go")).unwrap();
    for (time, x, y) in [(0.0, 1.0, 1.0), (0.999, 1.0, 1.0), (1.0, 2.0, 3.0), (1.999, 2.0, 3.0), (2.0, 0.0, 0.0)] {
        animation.seek(time, &mut scene);
        assert_eq!(positions(&scene)[1..], [Vec3::new(x, 0.0, 5.0), Vec3::new(0.0, y, 5.0)], "{time}");
        assert!(normals(&scene).iter().all(|n| n.is_normalized()));
    }
    // After its end the clip starts again from its first key: 2.6 is 1.1, 2.25 is 0.75.
    animation.seek(2.6, &mut scene);
    assert_eq!(positions(&scene)[1].x, 2.0);
    animation.seek(2.25, &mut scene);
    assert_eq!(positions(&scene)[1].x, 1.0);
}

#[test]
fn linear_rotations_turn_at_constant_speed_the_shorter_way() {
    // 0°, then 100° about z with its sign flipped, and then back as bytes would not do: as normalised shorts.
    let half = 50_f64.to_radians();
    let q = [0.0, 0.0, -half.sin(), -half.cos()];
    let mut d = Document::default();
    let p = d.vectors(&CORNERS);
    let t = d.floats(&[0.0, 1.0], "SCALAR");
    let shorts: Vec<u8> = [0.0, 0.0, 0.0, 1.0]
        .iter()
        .chain(&q)
        .flat_map(|x: &f64| ((x * 32767.0).round() as i16).to_le_bytes())
        .collect();
    let v = d.add(&shorts, 5122, "VEC4", 2, r#", "normalized": true"#);
    let text = d.text(&format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {p}}}}}]}}], "nodes": [{{"mesh": 0}}],
"animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 0, "path": "rotation"}}}}],
"samplers": [{{"input": {t}, "output": {v}}}]}}]"#
    ));
    let (mut scene, animation, _) = load(&text, None).unwrap();
    for i in 0..=10 {
        animation.seek(0.1 * i as f32, &mut scene);
        let want = DQuat::from_rotation_z(2.0 * half * 0.1 * f64::from(i)) * DVec3::X;
        // Shorts know an angle to 1/32767.
        assert!(positions(&scene)[1].as_dvec3().distance(want) < 5e-5, "{i}");
    }
}

/// A strip along y with two joints, the second at y = 1, turned by 90° about z within a second; the middle vertices
/// hang half on each. The skinned node's own transform is ignored.
fn bent_strip(weights: &[u8], more: &str) -> String {
    let mut d = Document::default();
    let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let p = d.vectors(&[at(-0.5, 0.0), at(0.5, 0.0), at(-0.5, 1.0), at(0.5, 1.0), at(-0.5, 2.0), at(0.5, 2.0)]);
    let n = d.vectors(&[Vec3::X; 6]);
    let j = d.bytes(&[0, 1, 0, 0].repeat(6), "VEC4", "");
    let w = d.bytes(weights, "VEC4", r#", "normalized": true"#);
    let i = d.add(&[0, 0, 1, 0, 3, 0, 0, 0, 3, 0, 2, 0, 2, 0, 3, 0, 5, 0, 2, 0, 5, 0, 4, 0], 5123, "SCALAR", 12, "");
    let mut inverse = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    inverse.extend(glam::Mat4::from_translation(Vec3::NEG_Y).to_cols_array());
    let b = d.floats(&inverse, "MAT4");
    let t = d.floats(&[0.0, 1.0], "SCALAR");
    let r = d.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2], "VEC4");
    d.text(&format!(
        r#""meshes": [{{"primitives": [{{"indices": {i}, "attributes": {{"POSITION": {p}, "NORMAL": {n},
"JOINTS_0": {j}, "WEIGHTS_0": {w}}}}}]}}],
"nodes": [{{"mesh": 0, "skin": 0, "translation": [7, 7, 7]}}, {{"children": [2]}}, {{"translation": [0, 1, 0]}}],
"skins": [{{"joints": [1, 2], "inverseBindMatrices": {b}}}],
"animations": [{{"name": "Bend", "channels": [{{"sampler": 0, "target": {{"node": 2, "path": "rotation"}}}}],
"samplers": [{{"input": {t}, "output": {r}}}]}}]{more}"#
    ))
}

const HALVES: [u8; 24] = [255, 0, 0, 0, 255, 0, 0, 0, 128, 128, 0, 0, 128, 128, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0];

#[test]
fn a_skin_bent_by_a_right_angle() {
    let (mut scene, animation, warnings) = load(&bent_strip(&HALVES, ""), None).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    animation.seek(1.0, &mut scene);
    // Joint 1 turns (x, 1 + y) to (−y, 1 + x).
    let want = [(-0.5, 0.0), (0.5, 0.0), (-0.25, 0.75), (0.25, 1.25), (-1.0, 0.5), (-1.0, 1.5)];
    for (p, (x, y)) in positions(&scene).iter().zip(want) {
        assert!(near(*p, DVec3::new(x, y, 0.0)), "{p}");
    }
    // Normals: the blended matrix of the middle is a turn by 45°, shrunk.
    let diagonal = DVec3::new(1.0, 1.0, 0.0).normalize();
    for (n, want) in normals(&scene).iter().zip([DVec3::X, DVec3::X, diagonal, diagonal, DVec3::Y, DVec3::Y]) {
        assert!(near(*n, want), "{n}");
    }
    let rig = animation.rig(1).unwrap();
    assert_eq!((rig.joints[3], rig.weights[3]), ([0, 1, 0, 0], [0.5, 0.5, 0.0, 0.0]));
    assert!(rig.targets.is_empty() && animation.rig(0).is_none());
    let pose = animation.pose(1, 1.0);
    assert!(near(pose.joints[1].transform_point3(Vec3::new(0.5, 2.0, 0.0)), DVec3::new(-1.0, 1.5, 0.0)));
}

#[test]
fn vertices_without_a_joint_stay_and_sums_are_made_one() {
    let mut weights = HALVES;
    weights[..4].fill(0);
    weights[20..24].copy_from_slice(&[0, 100, 0, 0]);
    let (mut scene, animation, warnings) = load(&bent_strip(&weights, ""), None).unwrap();
    assert!(warnings.len() == 2 && warnings[0].contains("1 vertices do not add up to 1"), "{warnings:?}");
    assert!(warnings[1].contains("1 vertices of a skin have no joint"), "{warnings:?}");
    animation.seek(1.0, &mut scene);
    assert!(near(positions(&scene)[0], DVec3::new(-0.5, 0.0, 0.0)));
    assert!(near(positions(&scene)[5], DVec3::new(-1.0, 1.5, 0.0)));
}

#[test]
fn a_skin_without_weights_is_told() {
    let text = bent_strip(&HALVES, "").replace("\"WEIGHTS_0\"", "\"_W\"");
    let (_, animation, warnings) = load(&text, None).unwrap();
    assert!(animation.is_still() && warnings.len() == 1, "{warnings:?}");
    assert!(warnings[0].contains("has no joints and weights: its node places it"), "{warnings:?}");
}

#[test]
fn of_many_joints_the_four_that_count_most_remain() {
    let mut d = Document::default();
    let p = d.vectors(&CORNERS);
    let (j, k) = (d.bytes(&[0, 1, 2, 3].repeat(3), "VEC4", ""), d.bytes(&[4, 5, 0, 0].repeat(3), "VEC4", ""));
    let w = d.floats(&[0.1, 0.2, 0.3, 0.1].repeat(3), "VEC4");
    let x = d.floats(&[0.25, 0.05, 0.0, 0.0].repeat(3), "VEC4");
    let (t, v) = (d.floats(&[0.0, 1.0], "SCALAR"), d.floats(&[0.0, 0.0, 0.0, 10.0, 0.0, 0.0], "VEC3"));
    let text = d.text(&format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {p}, "JOINTS_0": {j}, "WEIGHTS_0": {w},
"JOINTS_1": {k}, "WEIGHTS_1": {x}}}}}]}}], "nodes": [{{"mesh": 0, "skin": 0}}, {{}}, {{}}, {{}}, {{}}, {{}}, {{}}],
"skins": [{{"joints": [1, 2, 3, 4, 5, 6]}}],
"animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 3, "path": "translation"}}}}],
"samplers": [{{"input": {t}, "output": {v}}}]}}]"#
    ));
    let (mut scene, animation, warnings) = load(&text, None).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("3 vertices have more than 4 joints"), "{warnings:?}");
    animation.seek(1.0, &mut scene);
    // Joint 2 keeps 0.3 of 0.3 + 0.25 + 0.2 + 0.1.
    assert!(near(positions(&scene)[0], DVec3::new(10.0 * 0.3 / 0.85, 0.0, 0.0)));
}

#[test]
fn morph_weights_add_displacements_of_places_and_normals() {
    let mut d = Document::default();
    let (p, n) = (d.vectors(&CORNERS), d.vectors(&[Vec3::Z; 3]));
    let a = d.vectors(&[Vec3::Z, Vec3::ZERO, Vec3::ZERO]);
    let an = d.vectors(&[Vec3::X, Vec3::ZERO, Vec3::ZERO]);
    // The second target is sparse: only vertex 2 moves.
    let (si, sv) = (d.add(&[2, 0], 5123, "SCALAR", 1, ""), d.vectors(&[Vec3::new(0.0, 2.0, 0.0)]));
    let sparse = d.count;
    write!(
        d.accessors,
        r#", {{"componentType": 5126, "count": 3, "type": "VEC3", "sparse": {{"count": 1,
"indices": {{"bufferView": {si}, "componentType": 5123}}, "values": {{"bufferView": {sv}}}}}}}"#
    )
    .unwrap();
    d.count += 1;
    // One more view keeps views and accessors in step.
    d.views += r#", {"buffer": 0, "byteLength": 4}"#;
    let (t, w) = (d.floats(&[0.0, 2.0], "SCALAR"), d.floats(&[0.5, 0.0, 1.0, -1.0], "SCALAR"));
    let text = |weights: &str, animations: &str| {
        d.text(&format!(
            r#""meshes": [{{"weights": [0, 0.25], "primitives": [{{"attributes": {{"POSITION": {p}, "NORMAL": {n}}},
"targets": [{{"POSITION": {a}, "NORMAL": {an}}}, {{"POSITION": {sparse}}}]}}]}}],
"nodes": [{{"mesh": 0, "scale": [2, 1, 1]{weights}}}]{animations}"#
        ))
    };
    let moving = format!(
        r#", "animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 0, "path": "weights"}}}}],
"samplers": [{{"input": {t}, "output": {w}}}]}}]"#
    );
    let (mut scene, animation, warnings) = load(&text("", &moving), None).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    for (time, first, second) in [(0.0, 0.5, 0.0), (1.0, 0.75, -0.5), (2.0, 1.0, -1.0)] {
        animation.seek(time, &mut scene);
        assert!(near(positions(&scene)[0], DVec3::new(0.0, 0.0, first)), "{time}");
        assert!(near(positions(&scene)[1], DVec3::new(2.0, 0.0, 0.0)), "{time}");
        assert!(near(positions(&scene)[2], DVec3::new(0.0, 1.0 + 2.0 * second, 0.0)), "{time}");
        // Under the inverse transpose x shrinks to half.
        assert!(near(normals(&scene)[0], DVec3::new(0.5 * first, 0.0, 1.0).normalize()), "{time}");
        assert_eq!(animation.pose(1, time).morph, [first as f32, second as f32]);
    }
    assert_eq!(animation.rig(1).unwrap().targets[1][2], Vec3::new(0.0, 2.0, 0.0));
    // Without a clip: the node's weights, else the mesh's.
    for (weights, y) in [("", 1.5), (r#", "weights": [0, 1]"#, 3.0)] {
        let (scene, animation, _) = load(&text(weights, ""), None).unwrap();
        assert!(animation.is_still() && near(positions(&scene)[2], DVec3::new(0.0, y, 0.0)));
    }
    let message = load(&text(r#", "weights": [1]"#, ""), None).unwrap_err().to_string();
    assert!(message.contains("1 morph weights for 2 targets"), "{message}");
}

#[test]
fn cameras_move_with_their_nodes() {
    let perspective = r#"{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1}}"#;
    let orthographic = r#"{"type": "orthographic", "orthographic": {"xmag": 4, "ymag": 2, "znear": 0, "zfar": 50}}"#;
    a_camera_moves_with_its_node(perspective, Projection::perspective(0.6));
    a_camera_moves_with_its_node(orthographic, Projection::Orthographic { height: 4.0 });
}

fn a_camera_moves_with_its_node(camera: &str, projection: Projection) {
    let mut d = Document::default();
    let p = d.vectors(&CORNERS);
    let (t, v) = (d.floats(&[0.0, 1.0], "SCALAR"), d.floats(&[0.0, 0.0, 4.0, 3.0, 0.0, 4.0], "VEC3"));
    let text = d.text(&format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {p}}}}}]}}],
"cameras": [{camera}],
"nodes": [{{"mesh": 0}}, {{"camera": 0}}],
"animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 1, "path": "translation"}}}}],
"samplers": [{{"input": {t}, "output": {v}}}]}}]"#
    ));
    let (mut scene, animation, _) = load(&text, None).unwrap();
    assert!(!animation.is_still() && animation.rig(1).is_none());
    animation.seek(0.5, &mut scene);
    let camera = scene.camera;
    assert_eq!((camera.eye, camera.projection), (Vec3::new(1.5, 0.0, 4.0), projection));
    assert!((camera.target - camera.eye).normalize().distance(Vec3::NEG_Z) < 1e-6);
}

#[test]
fn a_scene_file_places_a_skinned_mesh_and_moves_it_on() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("strip.gltf"), bent_strip(&HALVES, "")).unwrap();
    let file = folder.path().join("s.toml");
    let load = |more: &str| {
        std::fs::write(&file, format!("[[objects]]\nname = \"strip\"\nmesh = \"strip.gltf\"\n{more}")).unwrap();
        scene_files::load_animated(&file)
    };
    let (mut scene, animation, _) = load(
        "scale = 2\ntranslate = [0, 0, 1]\nclip = \"Bend\"\nproxy = { explicit = [[0, 0, 0, 0.25], [0, 2, 0, 0.5]] }\n\
        keys = [{ time = 0 }, { time = 4, translate = [0, 0, 9], rotate = { axis = [0, 1, 0], degrees = 360 } }]",
    )
    .unwrap();
    assert_eq!((animation.duration(), animation.clips()), (4.0, &["strip/Bend".to_owned()][..]));
    // The clip repeats each second: at 1 s it is bent, at 1.5 s half bent; the placement is a quarter on its way at 1 s.
    for (time, degrees) in [(1.0_f32, 90.0_f64), (1.5, 45.0), (2.0, 90.0), (0.0, 0.0)] {
        animation.seek(time, &mut scene);
        let bend = DQuat::from_rotation_z(degrees.to_radians());
        let turn = DQuat::from_rotation_y(f64::from(time) * std::f64::consts::FRAC_PI_2);
        let place = |p: DVec3| turn * (2.0 * p) + DVec3::Z * (1.0 + 2.0 * f64::from(time));
        let tip = |x: f64, y: f64| place(DVec3::Y + bend * DVec3::new(x, y, 0.0));
        let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
        // Half-way through a second the clip is at its start again at whole seconds but the first.
        let whole = time > 1.0 && time.fract() == 0.0;
        let want = if whole { place(DVec3::new(0.5, 2.0, 0.0)) } else { tip(0.5, 1.0) };
        assert!(near(mesh.positions[5], want), "{time}: {} {want}", mesh.positions[5]);
        // Explicit spheres go with the nearest vertex: the first with joint 0, the second with joint 1.
        let Proxy::Spheres(spheres) = &scene.objects[0].proxy else { panic!() };
        assert!(near(spheres[0].center, place(DVec3::ZERO)) && (spheres[0].radius - 0.5).abs() < 1e-5);
        let want = if whole { place(DVec3::new(0.0, 2.0, 0.0)) } else { tip(0.0, 1.0) };
        assert!(near(spheres[1].center, want) && (spheres[1].radius - 1.0).abs() < 1e-5, "{time}");
    }
    let message = load("clip = 1").unwrap_err().to_string();
    assert!(
        message.contains("s.toml:4:") && message.contains("no clip \"1\"") && message.contains("\"Bend\""),
        "{message}"
    );
    // Another set of normals: computed anew in each pose, and none.
    let (mut scene, animation, _) = load("normals = \"smooth\"").unwrap();
    animation.seek(1.0, &mut scene);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    assert!(mesh.normals.iter().all(|n| n.z.abs() > 0.999));
    let (mut scene, animation, _) = load("normals = \"face\"").unwrap();
    animation.seek(1.0, &mut scene);
    assert!(matches!(&scene.objects[0].shape, Shape::Mesh(mesh) if mesh.normals.is_empty()));
}

#[test]
fn faults_of_clips_are_refused_and_those_of_others_told() {
    let go = |path: &str, interpolation: &str, times: &[f32], values: &[f32], kind: &str| {
        one_channel(path, interpolation, times, values, kind)
    };
    let v = [0.0; 6];
    for (text, words) in [
        (go("translation", "LINEAR", &[1.0, 0.5], &v, "VEC3"), "not in order"),
        (go("translation", "LINEAR", &[0.0, f32::NAN], &v, "VEC3"), "NaN s"),
        (go("translation", "LINEAR", &[0.0, 1e9], &v, "VEC3"), "1e9 s"),
        (go("translation", "LINEAR", &[0.0, 1.0, 2.0], &v, "VEC3"), "2 values for 3 keys: expected 3"),
        (go("translation", "CUBICSPLINE", &[0.0, 1.0], &v, "VEC3"), "2 values for 2 keys: expected 6"),
        (go("translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, f32::INFINITY, 0.0, 0.0, 0.0], "VEC3"), "value inf"),
        (go("rotation", "LINEAR", &[0.0, 1.0], &v, "VEC3"), "Vec4"),
        (go("translation", "BEZIER", &[0.0, 1.0], &v, "VEC3"), "unknown interpolation"),
        (
            go("translation", "LINEAR", &[0.0, 1.0], &v, "VEC3").replace("\"sampler\": 0", "\"sampler\": 3"),
            "no sampler 3",
        ),
        (go("translation", "LINEAR", &[0.0, 1.0], &v, "VEC3").replace("\"node\": 1", "\"node\": 8"), "no node 8"),
    ] {
        for clip in [None, Some("Go")] {
            let message = load(&text, clip).unwrap_err().to_string();
            assert!(message.contains("m.gltf: animation 0") && message.contains(words), "{message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }
    let text = go("translation", "LINEAR", &[0.0, 1.0], &v, "VEC3");
    for (clip, words) in [("Walk", "no clip \"Walk\": expected one of \"Go\""), ("1", "no clip \"1\"")] {
        let message = load(&text, Some(clip)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    // By number as well.
    load(&text, Some("0")).unwrap();
    let unnamed = text.replace("\"name\": \"Go\", ", "");
    assert_eq!(load(&unnamed, None).unwrap().1.clips(), ["0"]);
    // A broken clip that is not played gives a warning and is not listed.
    let target = "{\"sampler\": 0, \"target\": {\"node\": 1, \"path\": \"translation\"}}";
    let broken = format!("\"animations\": [{{\"channels\": [{target}], \"samplers\": []}}, ");
    let two = text.replace("\"animations\": [", &broken);
    let (_, animation, warnings) = load(&two, Some("Go")).unwrap();
    assert_eq!(animation.clips(), ["Go"]);
    assert!(
        warnings.len() == 1
            && warnings[0].contains("a clip is left out: animation 0, channel 0: there is no sampler 0")
    );
    assert!(load(&two, None).unwrap_err().to_string().contains("no sampler 0"));
    // One without channels is none.
    let empty = text.replace(target, "");
    let (_, animation, warnings) = load(&empty, None).unwrap();
    assert!(
        animation.is_still() && animation.clips().is_empty() && warnings[0].contains("no channels"),
        "{warnings:?}"
    );
    // Of two channels for one thing the later one counts.
    let (_, _, warnings) = load(&text.replace(target, &format!("{target}, {target}")), Some("Go")).unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("channel 1: an earlier one moves the same: it is left out"), "{warnings:?}");
    // Channels that are left out give a warning: a path of an extension, weights without targets.
    for (path, kind) in [("pointer", "VEC3"), ("weights", "SCALAR")] {
        let text = go(path, "LINEAR", &[0.0, 1.0], &v, kind);
        let (_, animation, warnings) = load(&text, None).unwrap();
        assert!(animation.is_still() && warnings.len() == 1 && warnings[0].contains("left out"), "{warnings:?}");
        assert!(animation.clips().is_empty());
        let message = load(&text, Some("Go")).unwrap_err().to_string();
        assert!(message.contains("moves nothing"), "{message}");
    }
    let pointer = text.replace("\"node\": 1, ", "");
    let (_, animation, warnings) = load(&pointer, None).unwrap();
    assert!(animation.is_still() && warnings[0].contains("1 animation channels without a node"), "{warnings:?}");
    let nonsense = text.replace("\"channels\": [", "\"channels\": 3, \"x\": [");
    let message = load(&nonsense, None).unwrap_err().to_string();
    assert!(message.starts_with("m.gltf:") || message.contains("m.gltf"), "{message}");
    let none = bent_strip(&HALVES, "").replace("\"animations\"", "\"extras\"");
    let message = load(&none, Some("Go")).unwrap_err().to_string();
    assert!(message.contains("has no animations"), "{message}");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let message = scene_files::load_clip(folder.path().join("m.obj"), "Go").unwrap_err().to_string();
    assert!(message.contains("only glTF files have clips"), "{message}");
}

#[test]
fn huge_keys_leave_finite_scenes() {
    let big = 1e7;
    let text = one_channel("scale", "LINEAR", &[0.0, 1.0], &[1.0, 1.0, 1.0, big, -big, 1e-30], "VEC3");
    let (mut scene, animation, _) = load(&text, None).unwrap();
    let spin = one_channel("rotation", "CUBICSPLINE", &[0.0, 1.0], &[90.0 * big; 24], "VEC4");
    let (mut other, spinning, _) = load(&spin, None).unwrap();
    for i in 0..=8 {
        animation.seek(i as f32 / 8.0, &mut scene);
        spinning.seek(i as f32 / 8.0, &mut other);
        scene.validate().unwrap();
        other.validate().unwrap();
    }
}

#[test]
fn whatever_the_data_say_scenes_are_valid_or_refused_in_one_line() {
    let text = bent_strip(&HALVES, "");
    let spline = one_channel("rotation", "CUBICSPLINE", &[0.0, 0.5, 1.0], &[0.3; 36], "VEC4");
    let mut loaded = 0;
    for whole in [&text, &spline] {
        let start = whole.find("base64,").unwrap() + 7;
        let end = start + whole[start..].find('"').unwrap();
        // Every third digit of the data becomes another one: huge numbers, NaN, other joints, times out of order.
        for (k, digit) in (start..end).step_by(3).zip(["/", "f", "w", "A"].into_iter().cycle()) {
            let broken = format!("{}{digit}{}", &whole[..k], &whole[k + 1..]);
            match load(&broken, None) {
                Ok((mut scene, animation, _)) => {
                    loaded += 1;
                    for i in 0..=8 {
                        animation.seek(0.15 * i as f32, &mut scene);
                        scene.validate().unwrap_or_else(|e| panic!("{digit} at {k}: {e}"));
                    }
                }
                Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
            }
        }
    }
    assert!(loaded > 100, "{loaded}");
}
