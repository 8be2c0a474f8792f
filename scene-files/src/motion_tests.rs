use crate::context::Context;
use crate::{load_animated, scene_file};
use glam::{Quat, Vec3};
use scene::{Animation, Projection, Proxy, Scene, Shape};
use std::path::Path;

fn parse(text: &str) -> (Scene, Animation) {
    scene_file::parse(Path::new("test.toml"), text, &mut Context::default()).unwrap()
}

fn refused(text: &str, line: usize, words: &[&str]) {
    let result = scene_file::parse(Path::new("test.toml"), text, &mut Context::default());
    let message = result.map(|(scene, _)| scene).expect_err(text).to_string();
    assert!(message.starts_with(&format!("test.toml:{line}:")), "{message}\nfor\n{text}");
    for word in words {
        assert!(message.contains(word), "{message} lacks {word:?}");
    }
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

const SPHERE: &str = "[[objects]]\nsphere = { center = [2, 0, 0], radius = 0.5 }\n";

#[test]
fn an_orbit_is_a_rotation_of_what_lies_aside() {
    let text =
        format!("{SPHERE}keys = [{{ time = 1 }}, {{ time = 3, rotate = {{ axis = [0, 1, 0], degrees = 720 }} }}]");
    let (mut scene, animation) = parse(&text);
    assert!(!animation.is_still() && animation.duration() == 3.0 && animation.fps() == 24.0);
    for (time, degrees) in
        [(0.0, 0.0), (1.0, 0.0), (1.25, 90.0), (1.5, 180.0), (2.0, 0.0), (2.25, 90.0), (9.0, 0.0_f32)]
    {
        animation.seek(time, &mut scene);
        let want = Quat::from_rotation_y(degrees.to_radians()) * Vec3::new(2.0, 0.0, 0.0);
        let (Shape::Spheres(spheres), Proxy::Spheres(proxy)) = (&scene.objects[0].shape, &scene.objects[0].proxy)
        else {
            panic!()
        };
        assert!(close(spheres[0].center, want) && close(proxy[0].center, want), "{time}: {}", spheres[0].center);
        assert!((spheres[0].radius - 0.5).abs() < 1e-6 && (proxy[0].radius - 0.5).abs() < 1e-6);
    }
}

#[test]
fn keys_leave_out_what_does_not_change() {
    let text = "[[objects]]\nbox = { center = [0, 0, 0], size = [2, 2, 2] }\nscale = 3\ntranslate = [0, 1, 0]\n\
        proxy = { explicit = [[0.5, 0, 0, 0.25]] }\n\
        keys = [{ time = 0, rotate = { axis = [0, 0, 1], degrees = 10 } }, { time = 1, translate = [4, 1, 0] },\n\
        { time = 2, rotate = { axis = [0, 0, 1], degrees = 190 }, scale = 1.0 }]\nloop = true";
    let (mut scene, animation) = parse(text);
    // At time 1: moved all the way, turned and shrunk half the way.
    for time in [1.0, 3.0, 101.0] {
        animation.seek(time, &mut scene);
        let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
        let place = |p: Vec3| Vec3::new(4.0, 1.0, 0.0) + Quat::from_rotation_z(100_f32.to_radians()) * (2.0 * p);
        let corner = place(Vec3::ONE);
        assert!(mesh.positions.iter().any(|p| (*p - corner).length() < 1e-4), "{time}: {:?}", mesh.positions);
        let Proxy::Spheres(proxy) = &scene.objects[0].proxy else { panic!() };
        assert!((proxy[0].center - place(Vec3::X * 0.5)).length() < 1e-4 && (proxy[0].radius - 0.5).abs() < 1e-5);
        // The rig says the same.
        let (rig, pose) = (animation.rig(0).unwrap(), animation.pose(0, time));
        assert_eq!((rig.joints.len(), rig.weights[3], pose.joints.len()), (24, [1.0, 0.0, 0.0, 0.0], 1));
        assert!((pose.joints[0].transform_point3(Vec3::ONE) - corner).length() < 1e-4);
    }
    // Values that the first key leaves out are the object's own.
    animation.seek(0.0, &mut scene);
    let size = scene.bounds().size();
    let want = 6.0 * (10_f32.to_radians().cos() + 10_f32.to_radians().sin());
    assert!((size - Vec3::new(want, want, 6.0)).length() < 1e-4, "{size}");
}

#[test]
fn normals_follow_the_inverse_transpose() {
    let text = "[[objects]]\nmesh = \"globe.obj\"\nkeys = [{ time = 0 }, { time = 1, scale = [1, 3, 0.5], \
        rotate = { axis = [1, 1, 0], degrees = 70 } }]";
    let folder = tempfile::tempdir().unwrap();
    let spine: Vec<Vec3> =
        (0..12).map(|i| Quat::from_rotation_y(core::f32::consts::FRAC_PI_6 * i as f32) * Vec3::X).collect();
    let torus = scene::Mesh::closed_tube(&spine, 0.3, 8);
    let mut obj = String::new();
    for (p, n) in torus.positions.iter().zip(&torus.normals) {
        obj += &format!("v {} {} {}\nvn {} {} {}\n", p.x, p.y, p.z, n.x, n.y, n.z);
    }
    for t in &torus.triangles {
        let [a, b, c] = t.map(|i| i + 1);
        obj += &format!("f {a}//{a} {b}//{b} {c}//{c}\n");
    }
    std::fs::write(folder.path().join("globe.obj"), obj).unwrap();
    std::fs::write(folder.path().join("s.toml"), text).unwrap();
    let (mut scene, animation, _) = load_animated(folder.path().join("s.toml")).unwrap();
    let Shape::Mesh(first) = scene.objects[0].shape.clone() else { panic!() };
    animation.seek(1.0, &mut scene);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    // The transform of the mesh itself is the oracle.
    let mut want = first;
    want.transform(&animation.pose(0, 1.0).joints[0]);
    for (p, q) in mesh.positions.iter().zip(&want.positions) {
        assert!(close(*p, *q));
    }
    for (p, q) in mesh.normals.iter().zip(&want.normals) {
        assert!(close(*p, *q), "{p} {q}");
    }
}

#[test]
fn lights_and_the_camera_move() {
    let text = format!(
        "[animation]\nduration = 10\nfps = 30\n[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n\
        keys = [{{ time = 0 }}, {{ time = 2, eye = [2, 0, 5], fov = 55 }}]\n{SPHERE}[[lights]]\nkind = \"spheres\"\n\
        spheres = [[0, 3, 0, 0.1], [1, 3, 0, 0.2]]\nflux = 1\nkeys = [{{ time = 0, translate = [0, 0, 1] }}, \
        {{ time = 1, translate = [0, 0, 3], rotate = {{ axis = [0, 1, 0], degrees = 90 }} }}]"
    );
    let (mut scene, animation) = parse(&text);
    assert_eq!((animation.duration(), animation.fps()), (10.0, 30.0));
    animation.seek(1.0, &mut scene);
    assert!(close(scene.camera.eye, Vec3::new(1.0, 0.0, 5.0)));
    let Projection::Perspective { vertical_fov } = scene.camera.projection else { panic!("{:?}", scene.camera) };
    assert!((vertical_fov - 45_f32.to_radians()).abs() < 1e-6);
    let centers: Vec<Vec3> = scene.lights.iter().map(|l| l.sphere().expect("a sphere").center).collect();
    assert!(close(centers[0], Vec3::new(0.0, 3.0, 3.0)) && close(centers[1], Vec3::new(0.0, 3.0, 2.0)), "{centers:?}");
    assert_eq!(scene.lights[1].sphere().expect("a sphere").radius, 0.2);
    assert!(animation.rig(0).is_none() && animation.rig(7).is_none());
    assert_eq!(animation.pose(0, 1.0).joints, [glam::Mat4::IDENTITY]);
}

#[test]
fn a_scene_without_keys_is_still() {
    let (scene, animation) = parse(SPHERE);
    assert!(animation.is_still() && animation.duration() == 0.0 && animation.clips().is_empty());
    let mut moved = scene.clone();
    animation.seek(3.0, &mut moved);
    assert_eq!(moved, scene);
}

#[test]
fn the_loaded_scene_is_the_first_moment() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.toml");
    std::fs::write(&file, format!("{SPHERE}keys = [{{ time = 1, translate = [1, 2, 3] }}, {{ time = 2, scale = 2 }}]"))
        .unwrap();
    let (scene, animation, _) = load_animated(&file).unwrap();
    let mut moved = scene.clone();
    for time in [2.0, 0.7, f32::NAN, f32::INFINITY, -3.0] {
        animation.seek(time, &mut moved);
        moved.validate().unwrap();
    }
    assert_eq!(moved, scene);
    let Shape::Spheres(spheres) = &scene.objects[0].shape else { panic!() };
    assert_eq!(spheres[0].center, Vec3::new(3.0, 2.0, 3.0));
    assert!(crate::load_clip(&file, "Walk").unwrap_err().to_string().contains("itself"));
}

#[test]
fn bad_keys_are_refused_in_one_line_with_their_place() {
    let with = |more: &str| format!("{SPHERE}{more}");
    refused(&with("keys = []"), 3, &["at least one key"]);
    refused(&with("keys = 3"), 3, &["found a number"]);
    refused(&with("loop = true"), 3, &["loop: there are no keys"]);
    refused(&with("interpolate = \"smooth\""), 3, &["there are no keys"]);
    refused(&with("keys = [{ time = 0 }]\ninterpolate = \"cubic\""), 4, &["cubic", "\"smooth\""]);
    refused(&with("keys = [{ translate = [0, 0, 0] }]"), 3, &["\"time\" is missing"]);
    refused(&with("keys = [{ time = -1 }]"), 3, &["-1", "0 and 1000000"]);
    refused(&with("keys = [{ time = nan }]"), 3, &["finite"]);
    refused(&with("keys = [{ time = 1 },\n{ time = 1 }]"), 4, &["not later"]);
    refused(&with("keys = [{ time = 0, move = [0, 0, 0] }]"), 3, &["unknown key \"move\"", "\"translate\""]);
    refused(&with("keys = [{ time = 0, scale = 0 }]"), 3, &["must not be 0"]);
    refused(&with("keys = [{ time = 0, scale = [1, 2, 1] }]"), 3, &["uniformly"]);
    refused(&with("keys = [{ time = 0, translate = [2e9, 0, 0] }]"), 3, &["1e9"]);
    refused(&with("keys = [{ time = 0, rotate = { axis = [0, 0, 0], degrees = 1 } }]"), 3, &["length zero"]);
    let identity = "matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
    refused(&with(&format!("{identity}\nkeys = [{{ time = 0 }}]")), 4, &["matrix"]);
    let turns = "keys = [{ time = 0 }, { time = 1, rotate = { axis = [0, 1, 0], degrees = 270 } }, \
        { time = 2, rotate = { axis = [1, 0, 0], degrees = 90 } }]";
    parse(&with(turns));
    refused(&with(&format!("{turns}\ninterpolate = \"smooth\"")), 3, &["180°", "add keys"]);
    refused(&with("clip = \"Walk\""), 3, &["only meshes"]);
    refused(&with("[animation]\nduration = 0"), 4, &["greater than 0"]);
    refused(&with("[animation]\nfps = 1e9"), 4, &["10000"]);
    refused(&with("[animation]\nclip = 1"), 4, &["unknown key"]);
    let camera = |keys: &str| with(&format!("[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nkeys = {keys}"));
    refused(&camera("[{ time = 2, target = [0, 0, 5] }]"), 6, &["at 2 s", "same point"]);
    refused(&camera("[{ time = 2, fov = 200 }]"), 6, &["200"]);
    let light = "[[lights]]\nkind = \"sphere\"\ncenter = [0, 1, 0]\nradius = 1\nflux = 1\n";
    refused(&with(&format!("{light}keys = [{{ time = 0, scale = 2 }}]")), 8, &["unknown key \"scale\""]);
}
