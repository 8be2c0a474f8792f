//! A scene that lies far from the origin of its file is the same scene.

#![expect(clippy::unwrap_used, reason = "a test")]

use glam::{DVec3, Vec3};
use lighting::Light;
use scene::{Animation, Proxy, Scene, Shape};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/assets");

/// Everything that can stand in a scene file, moved by `s`; meshes of files both by `translate` and in their own coordinates.
fn text(s: DVec3, far: &str) -> String {
    let at = |x: f64, y: f64, z: f64| format!("[{}, {}, {}]", x + s.x, y + s.y, z + s.z);
    let row4 = |x: f64, y: f64, z: f64, r: f64| format!("[{}, {}, {}, {r}]", x + s.x, y + s.y, z + s.z);
    let row = |x: f64, r: &str| format!("[{r}, {x}]");
    format!(
        r#"
[camera]
eye = {eye}
target = {target}
keys = [{{ time = 0 }}, {{ time = 1, eye = {eye1} }}]
[[objects]]
plane = {{ point = {floor}, normal = [0, 1, 0], size = 20 }}
[[objects]]
quad = {{ center = {quad}, u = [0.3, 0, 0.1], v = [0, 0.7, 0] }}
keys = [{{ time = 0 }}, {{ time = 1, translate = [0.1, 0.2, 0.3] }}]
[[objects]]
box = {{ center = {cuboid}, size = [0.3, 0.1, 0.7] }}
[[objects]]
sphere = {{ center = {sphere}, radius = 0.1 }}
[[objects]]
spheres = [{first}, {second}]
[[objects]]
mesh = "{ASSETS}/spot.obj"
scale = 0.37
rotate = {{ axis = [1, 2, 3], degrees = 40 }}
translate = {spot}
proxy = {{ explicit = [[0.1, 0.2, 0.3, 0.5]] }}
[[objects]]
mesh = "{ASSETS}/spot.obj"
matrix = [{m0}, {m1}, {m2}, [0, 0, 0, 1]]
[[objects]]
mesh = "{ASSETS}/fox.glb"
scale = 0.01
rotate = {{ axis = [0, 1, 0], degrees = 30 }}
translate = {fox}
keys = [{{ time = 0 }}, {{ time = 1, translate = {fox1}, rotate = {{ axis = [0, 1, 0], degrees = 75 }} }}]
[[objects]]
mesh = "{far}"
proxy = {{ explicit = [{proxy}] }}
[[lights]]
kind = "sphere"
center = {light}
radius = 0.3
radiance = 3
[[lights]]
kind = "spheres"
spheres = [{light1}]
radiance = 3
keys = [{{ time = 0 }}, {{ time = 1, translate = [0.1, 0.2, 0.3] }}]
[[lights]]
kind = "sphere"
center = [0.1, 0.2, 0.3]
radius = 0.3
radiance = 3
keys = [{{ time = 0, translate = {go} }}, {{ time = 1, translate = {go1}, rotate = {{ axis = [1, 0, 0], degrees = 50 }} }}]
"#,
        eye = at(0.3, 2.1, 5.7),
        target = at(0.1, 0.7, 0.0),
        eye1 = at(1.3, 2.2, 5.1),
        floor = at(0.01, 0.02, 0.03),
        quad = at(0.1, 1.0, 0.3),
        cuboid = at(-0.7, 0.4, 0.9),
        sphere = at(0.33, 0.44, 0.55),
        first = row4(1.1, 0.3, 0.77, 0.2),
        second = row4(1.2, 0.6, 0.77, 0.2),
        spot = at(0.9, 0.1, -0.4),
        m0 = row(0.7 + s.x, "0.1, 0.2, 0.3"),
        m1 = row(1.7 + s.y, "0.3, 0.2, 0.1"),
        m2 = row(0.2 + s.z, "0.3, -0.2, 0.5"),
        fox = at(-1.2, 0.0, 0.6),
        fox1 = at(-0.2, 0.3, 0.6),
        proxy = row4(0.3, 0.4, 0.5, 0.2),
        light = at(-2.1, 4.2, 1.3),
        light1 = row4(2.1, 4.2, 1.3, 0.2),
        go = at(3.1, 4.2, 0.3),
        go1 = at(3.1, 2.2, 0.3),
    )
}

/// A mesh in the coordinates of the world.
fn obj(s: DVec3) -> String {
    let mut text = String::new();
    for p in [[0.0, 0.0, 0.0], [0.31, 0.02, 0.1], [0.1, 0.57, 0.2], [0.2, 0.3, 0.43]] {
        writeln!(text, "v {} {} {}", p[0] + s.x, p[1] + s.y, p[2] + s.z).unwrap();
    }
    text + "f 1 2 3\nf 1 3 4\nf 2 3 4\n"
}

fn ply(s: DVec3) -> String {
    let body = obj(s).lines().filter_map(|line| line.strip_prefix("v ").map(|p| format!("{p}\n"))).collect::<String>();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
         element face 2\nproperty list uchar int vertex_indices\nend_header\n{body}3 0 1 2\n3 0 2 3\n"
    )
}

/// All positions of a scene, relative to `s` in the world of the file.
fn positions(scene: &Scene, animation: &Animation, s: DVec3) -> Vec<DVec3> {
    let mut all: Vec<Vec3> = vec![scene.camera.eye, scene.camera.target];
    all.extend(scene.lights.iter().filter_map(Light::sphere).map(|sphere| sphere.center));
    for object in &scene.objects {
        match &object.shape {
            Shape::Mesh(mesh) => all.extend(&mesh.positions),
            Shape::Instances(instances) => all.extend(instances.expanded().positions),
            Shape::Spheres(spheres) => all.extend(spheres.iter().map(|b| b.center)),
        }
        if let Proxy::Spheres(spheres) = &object.proxy {
            all.extend(spheres.iter().map(|b| b.center));
        }
    }
    all.iter().map(|p| p.as_dvec3() + (animation.origin() - s)).collect()
}

fn largest_difference(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

fn load(folder: &Path, s: DVec3, mesh: &str, content: &str) -> (Scene, Animation) {
    fs::write(folder.join(mesh), content).unwrap();
    let file = folder.join("far.toml");
    fs::write(&file, text(s, mesh)).unwrap();
    let (scene, animation, warnings) = scene_files::load_animated(&file).unwrap();
    // A PLY whose faces share vertices across edges.
    assert!(warnings.iter().all(|w| w.contains("edges included")), "{warnings:?}");
    (scene, animation)
}

#[test]
fn a_moved_scene_file_is_the_same_scene_at_all_times() {
    let folder = TempDir::new().unwrap();
    for (mesh, content) in [("far.obj", obj as fn(DVec3) -> String), ("far.ply", ply)] {
        let (mut here, still) = load(folder.path(), DVec3::ZERO, mesh, &content(DVec3::ZERO));
        assert_eq!(still.origin(), DVec3::ZERO);
        for s in [DVec3::new(1e3, 0.0, 0.0), DVec3::new(1e5, -2e4, 3e4), DVec3::new(-1e6, 1e6, 3.7e6)] {
            let (mut there, animation) = load(folder.path(), s, mesh, &content(s));
            assert!(animation.origin().distance(s) < 10.0);
            for time in [0.0, 0.3, 1.0] {
                still.seek(time, &mut here);
                animation.seek(time, &mut there);
                let error =
                    largest_difference(&positions(&here, &still, DVec3::ZERO), &positions(&there, &animation, s));
                // The plane's corners are 10 away; 1.2e-7 of that is one step of single precision.
                assert!(error < 4e-6, "{s} at {time}: {error:e}");
            }
        }
    }
}

/// Own coordinates may be far while keys turn about the file's origin: the lever is as long as that is far.
#[test]
fn levers_are_kept_in_double_precision() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("lever.toml");
    let s = DVec3::new(1e6, 0.0, 0.0);
    // Turned by 90° about z a point (x, y) goes to (−y, x).
    let scene = format!(
        r#"
[camera]
eye = [{}, 1.0, 5.0]
target = [{}, 0.0, 0.0]
[[objects]]
sphere = {{ center = [{}, 0.7, 0.1], radius = 0.2 }}
keys = [{{ time = 0 }}, {{ time = 1, translate = [{}, {}, 0], rotate = {{ axis = [0, 0, 1], degrees = 90 }} }}]
"#,
        s.x,
        s.x,
        s.x + 0.3,
        s.x,
        -s.x
    );
    fs::write(&file, scene).unwrap();
    let (mut scene, animation, _) = scene_files::load_animated(&file).unwrap();
    animation.seek(1.0, &mut scene);
    let Shape::Spheres(spheres) = &scene.objects[0].shape else { panic!("spheres") };
    let center = spheres[0].center.as_dvec3() + (animation.origin() - s);
    assert!(center.distance(DVec3::new(-0.7, 0.3, 0.1)) < 1e-6, "{center}");
}

#[test]
fn far_meshes_alone_are_what_they_are_near() {
    let folder = TempDir::new().unwrap();
    let node = |s: DVec3| {
        // Two triangles, their corners in base 64: (0,0,0) (1,0,0) (0,1,0); turned and moved by nodes.
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}],
"nodes": [{{"children": [1, 2], "rotation": [-0.70710677, 0, 0, 0.70710677]}},
 {{"mesh": 0, "translation": [{}, {}, {}]}}, {{"mesh": 0, "translation": [{}, {}, {}]}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
"buffers": [{{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 36}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}]}}"#,
            s.x,
            -s.z,
            s.y,
            s.x + 0.5,
            -s.z,
            s.y + 1.0
        )
    };
    type Text = fn(DVec3) -> String;
    let kinds: [(&str, Text); 3] = [("m.obj", obj), ("m.ply", ply), ("m.gltf", node)];
    for (name, content) in kinds {
        let file = folder.path().join(name);
        let load = |s| {
            fs::write(&file, content(s)).unwrap();
            let (scene, animation, _) = scene_files::load_animated(&file).unwrap();
            let relative = positions(&scene, &animation, s);
            (relative, animation.origin())
        };
        let (here, origin) = load(DVec3::ZERO);
        assert_eq!(origin, DVec3::ZERO, "{name}");
        let s = DVec3::new(1e6, -3e5, 65536.0);
        let (there, origin) = load(s);
        assert!(origin.distance(s) < 10.0, "{name}: {origin}");
        let error = largest_difference(&here, &there);
        // The floor's corners are 70 away.
        assert!(error < 4e-5, "{name}: {error:e}");
    }
}

/// Nodes that are each far away are where their numbers say in double precision, alone and where a scene file moves them back;
/// so are nodes that a node above brings back.
#[test]
fn far_nodes_are_multiplied_in_double_precision() {
    let folder = TempDir::new().unwrap();
    // Single precision has steps of 0.5 at 4.6e6.
    let s = DVec3::new(500_000.25, 12.5, -4_649_776.75);
    let text = |s: DVec3, root: &str| {
        let at = |x: f64| format!("[{}, {}, {}]", s.x + x, s.y + 0.3 * x, s.z - x);
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}],
"nodes": [{{"children": [1, 2, 3]{root}}}, {{"mesh": 0, "translation": {}}},
 {{"mesh": 0, "translation": {}, "rotation": [0, 0.6, 0, 0.8]}},
 {{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, {}, 1]}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
"buffers": [{{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 36}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}]}}"#,
            at(0.1),
            at(0.37),
            at(-0.21).trim_matches(['[', ']'])
        )
    };
    let (model, toml) = (folder.path().join("m.gltf"), folder.path().join("s.toml"));
    let meshes = |file: &Path, s: DVec3| {
        let (scene, animation, _) = scene_files::load_animated(file).unwrap();
        let mesh = |o: &scene::Object| match &o.shape {
            Shape::Mesh(mesh) if o.name != "floor" => mesh.positions.clone(),
            _ => Vec::new(),
        };
        let all = scene.objects.iter().flat_map(mesh);
        all.map(|p| p.as_dvec3() + (animation.origin() - s)).collect::<Vec<_>>()
    };
    fs::write(&model, text(DVec3::ZERO, "")).unwrap();
    let near = meshes(&model, DVec3::ZERO);
    assert_eq!(near.len(), 9);
    fs::write(&model, text(s, "")).unwrap();
    assert!(largest_difference(&near, &meshes(&model, s)) < 2e-6);
    fs::write(&toml, format!("[[objects]]\nmesh = \"m.gltf\"\ntranslate = [{}, {}, {}]\n", -s.x, -s.y, -s.z)).unwrap();
    assert!(largest_difference(&near, &meshes(&toml, DVec3::ZERO)) < 2e-6);
    fs::write(&model, text(s, &format!(r#", "translation": [{}, {}, {}]"#, -s.x, -s.y, -s.z))).unwrap();
    assert!(largest_difference(&near, &meshes(&model, DVec3::ZERO)) < 2e-6);
}

/// A target next to a camera that is far from the scene moves nothing.
#[test]
fn far_cameras_leave_the_scene_where_it_is() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("camera.toml");
    let scene = "[camera]\neye = [0.0, 0.0, 1000.0]\ntarget = [0.0, 0.0, 999.0]\n\
                 [[objects]]\nsphere = { center = [0.1, 0.2, 0.3], radius = 1.0 }\n";
    fs::write(&file, scene).unwrap();
    let (scene, animation, _) = scene_files::load_animated(&file).unwrap();
    assert_eq!((animation.origin(), scene.camera.eye.z), (DVec3::ZERO, 1000.0));
}

/// Where single precision gives all corners of a cube one place, as at 1e7, the cube is still read; so are a scene file that is far, and
/// one without a camera.
#[test]
fn cubes_that_single_precision_collapses_are_read() {
    let folder = TempDir::new().unwrap();
    let area = |scene: &Scene| {
        let of = |o: &scene::Object| match &o.shape {
            Shape::Mesh(mesh) if o.name != "floor" => mesh.area(),
            _ => 0.0,
        };
        scene.objects.iter().map(of).sum::<f64>()
    };
    for far in [1e7, 1e8] {
        let s = DVec3::new(far, 0.3 * far, -far);
        for (name, content) in [("m.obj", obj as fn(DVec3) -> String), ("m.ply", ply)] {
            let file = folder.path().join(name);
            let read = |s| {
                fs::write(&file, content(s)).unwrap();
                area(&scene_files::load_animated(&file).unwrap().0)
            };
            let (near, there) = (read(DVec3::ZERO), read(s));
            assert!((there / near - 1.0).abs() < 1e-6, "{name} at {far}: {there}, not {near}");
        }
        let at = |x: f64, y: f64, z: f64| format!("[{}, {}, {}]", s.x + x, s.y + y, s.z + z);
        let (camera, cube) = (
            format!("[camera]\neye = {}\ntarget = {}\n", at(1.0, 2.0, 3.0), at(0.0, 0.5, 0.0)),
            format!("[[objects]]\nbox = {{ center = {}, size = [1, 1, 1] }}\n", at(0.0, 0.5, 0.0)),
        );
        for text in [cube.clone(), format!("{camera}{cube}")] {
            let file = folder.path().join("s.toml");
            fs::write(&file, &text).unwrap();
            let (scene, animation, _) = scene_files::load_animated(&file).unwrap();
            assert!((area(&scene) - 6.0).abs() < 1e-5 && animation.origin().distance(s) < 10.0, "{text}");
        }
    }
}
