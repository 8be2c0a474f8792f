//! The `lobes` command, run as a user runs it.
#![allow(clippy::unwrap_used, reason = "in a test")]

use cosine_lobes::visibility_spheres::{BoundSet, SphereSet};
use cosine_lobes::{ExrLayer, Output, read_exr, read_exr_layer, write_exr};
use glam::Vec3;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output as Ran, Stdio};
use tempfile::TempDir;

/// A ball over a floor, one light; small enough for a test.
const SCENE: &str = r#"
[image]
width = 48
height = 32

[camera]
eye = [0.0, 3.0, 8.0]
target = [0.0, 0.6, 0.0]
fov = 30.0

[[objects]]
name = "floor"
plane = { point = [0.0, 0.0, 0.0], normal = [0.0, 1.0, 0.0], size = 20.0 }

[[objects]]
name = "ball"
sphere = { center = [0.0, 1.0, 0.0], radius = 0.6 }

[[lights]]
kind = "sphere"
center = [1.5, 5.0, 1.0]
radius = 0.6
radiance = [20.0, 20.0, 20.0]
"#;

fn lobes(folder: &Path, args: &[&str]) -> Ran {
    let cache = folder.with_extension("cache");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
    command.current_dir(folder).args(args).env("XDG_CACHE_HOME", cache).output().unwrap()
}

fn succeed(folder: &Path, args: &[&str]) -> String {
    let ran = lobes(folder, args);
    assert!(ran.status.success(), "{args:?}: {}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).unwrap()
}

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, args)).unwrap()
}

/// A folder with `scene.toml`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let name = |e: Result<fs::DirEntry, _>| e.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<String> = fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

/// Exit code 2, one line on stderr that says `what`, nothing on stdout, no new file, no panic.
fn refuse(folder: &Path, args: &[&str], what: &str) {
    let before = names(folder);
    let ran = lobes(folder, args);
    let stderr = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(2), "{args:?}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{args:?}: {stderr}");
    assert!(stderr.starts_with("lobes: error: ") && stderr.contains(what), "{args:?}: {stderr}");
    assert!(ran.stdout.is_empty(), "{args:?}");
    assert_eq!(names(folder), before, "{args:?}");
}

#[test]
fn bad_scenes_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let cases = [
        ("missing.toml", None, "missing.toml"),
        ("empty.toml", Some(String::new()), "empty.toml"),
        ("unknown.toml", Some(SCENE.replace("fov = 30.0", "fow = 30.0")), "fow"),
        ("nan.toml", Some(SCENE.replace("radius = 0.6\nradiance", "radius = nan\nradiance")), "nan.toml:"),
        ("inf.toml", Some(SCENE.replace("eye = [0.0", "eye = [inf")), "inf.toml:"),
        ("negative.toml", Some(SCENE.replace("radius = 0.6\nradiance", "radius = -0.6\nradiance")), "negative.toml:"),
        ("axis.toml", Some(SCENE.replace("normal = [0.0, 1.0, 0.0]", "normal = [0.0, 0.0, 0.0]")), "axis.toml:"),
        ("view.toml", Some(SCENE.replace("target = [0.0, 0.6, 0.0]", "target = [0.0, 3.0, 8.0]")), "view.toml"),
        ("zero.toml", Some(SCENE.replace("width = 48", "width = 0")), "zero.toml:"),
        ("broken.toml", Some(SCENE.replace("[camera]", "[camera")), "broken.toml:"),
        ("type.toml", Some(SCENE.replace("fov = 30.0", "fov = \"wide\"")), "type.toml:"),
        ("noise.glb", Some("no scene at all".to_owned()), "noise.glb"),
        ("noise.obj", Some("f 1 2 9\n".to_owned()), "noise.obj"),
        ("scene.xyz", Some(String::new()), "scene.xyz"),
    ];
    for (name, text, what) in &cases {
        if let Some(text) = text {
            fs::write(folder.join(name), text).unwrap();
        }
        refuse(folder, &["render", name, "-o", "out.png"], what);
    }
    refuse(folder, &["reference", "nan.toml", "-o", "out.exr"], "nan.toml:");
    refuse(folder, &["check", "negative.toml"], "negative.toml:");
    refuse(folder, &["spheres", "noise.obj", "-o", "set.json"], "noise.obj");
}

#[test]
fn bad_arguments_are_refused() {
    let folder = folder();
    let folder = folder.path();
    for size in ["0x0", "0x5", "12", "1x99999", "axb"] {
        refuse(folder, &["render", "--size", size], "--size");
    }
    refuse(folder, &["render", "--tolerance", "0"], "--tolerance");
    refuse(folder, &["render", "--tolerance", "nan"], "--tolerance");
    refuse(folder, &["render", "--depth", "7"], "--depth");
    refuse(folder, &["render", "--samples", "0"], "--samples");
    refuse(folder, &["render", "--visibility", "magic"], "magic");
    refuse(folder, &["render", "--threshold", "-1"], "-1");
    refuse(folder, &["render", "a.toml", "b.toml"], "b.toml");
    refuse(folder, &["paint"], "paint");
    refuse(folder, &["compare", "a.exr"], "<B>");
    refuse(folder, &["reference", "--spp", "0"], "--spp");
    refuse(folder, &["reference", "--size", "16384x16384"], "too many");
    refuse(folder, &["spheres", "x.obj", "--count", "0"], "--count");
}

#[test]
fn unwritable_outputs_are_refused() {
    let folder = folder();
    let folder = folder.path();
    refuse(folder, &["render", "scene.toml", "-o", "no/such/folder/out.png"], "no/such/folder/out.png");
    refuse(folder, &["render", "scene.toml", "-o", "out.jpg"], ".png or .exr");
    refuse(folder, &["render", "scene.toml", "-o", "out"], ".png or .exr");
    refuse(folder, &["render", "scene.toml", "-o", "a.png", "-o", "a.png"], "twice");
    refuse(folder, &["render", "scene.toml", "-o", "a.png", "--stats", "no/stats.json"], "no/stats.json");
    refuse(folder, &["render", "scene.toml", "-o", "a.png", "-o", "./a.png"], "twice");
    refuse(folder, &["render", "scene.toml", "-o", "a.png", "--stats", "a.png"], "twice");
    fs::create_dir(folder.join("is.png")).unwrap();
    refuse(folder, &["render", "scene.toml", "-o", "is.png"], "is a folder");
    // Refused at once, and not after hours.
    refuse(folder, &["reference", "scene.toml", "--size", "512x512", "--spp", "1000000", "-o", "no/ref.exr"], "no/ref");
}

/// What a command reads it does not replace, and a picture gets a picture's name.
#[test]
fn inputs_are_not_overwritten() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    picture(folder, "a.exr", 2, &[1.0; 4]);
    picture(folder, "b.exr", 2, &[0.5; 4]);
    let before: Vec<_> = names(folder).iter().map(|n| fs::read(folder.join(n)).unwrap()).collect();
    refuse(folder, &["render", "scene.toml", "-o", "a.png", "--stats", "./scene.toml"], "both read and written");
    refuse(folder, &["spheres", "m.obj", "-o", "m.obj"], "both read and written");
    refuse(folder, &["spheres", "m.obj", "-o", "s.png", "--preview", "s.png"], "twice");
    refuse(folder, &["spheres", "m.obj", "--preview", "s.exr"], ".png");
    refuse(folder, &["compare", "a.exr", "b.exr", "--diff", "a.exr"], "both read and written");
    refuse(folder, &["compare", "a.exr", "b.exr", "--diff", "d.png", "--heatmap", "d.png"], "twice");
    refuse(folder, &["compare", "a.exr", "b.exr", "--diff", "d.jpg"], ".png");
    let after: Vec<_> = names(folder).iter().map(|n| fs::read(folder.join(n)).unwrap()).collect();
    assert!(before == after);
}

fn picture(folder: &Path, name: &str, width: usize, values: &[f32]) -> PathBuf {
    let path = folder.join(name);
    let values: Vec<Vec3> = values.iter().map(|v| Vec3::splat(*v)).collect();
    let layers = [ExrLayer::color("beauty", &values)];
    write_exr(Output::create(&path).unwrap(), width, values.len() / width, &layers).unwrap();
    path
}

#[test]
fn bad_pictures_are_refused() {
    let folder = folder();
    let folder = folder.path();
    picture(folder, "a.exr", 2, &[1.0; 4]);
    picture(folder, "wide.exr", 4, &[1.0; 4]);
    picture(folder, "nan.exr", 2, &[1.0, f32::NAN, 1.0, 1.0]);
    fs::write(folder.join("noise.exr"), b"this is no picture").unwrap();
    fs::write(folder.join("empty.exr"), b"").unwrap();
    let bytes = fs::read(folder.join("a.exr")).unwrap();
    fs::write(folder.join("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    refuse(folder, &["compare", "a.exr", "wide.exr"], "sizes differ");
    refuse(folder, &["compare", "a.exr", "a.exr", "--unshadowed", "wide.exr"], "sizes differ");
    for bad in ["noise.exr", "empty.exr", "cut.exr", "nan.exr", "missing.exr", "scene.toml", "."] {
        refuse(folder, &["compare", "a.exr", bad], bad);
        refuse(folder, &["compare", bad, "a.exr"], bad);
        refuse(folder, &["compare", "a.exr", "a.exr", "--unshadowed", bad], bad);
    }
    refuse(folder, &["compare", "a.exr", "a.exr", "--diff", "no/diff.png"], "no/diff.png");
    // Any single damaged byte gives a picture or an error, never a panic.
    for i in (0..bytes.len()).step_by(7) {
        let mut damaged = bytes.clone();
        damaged[i] ^= 0x55;
        fs::write(folder.join("damaged.exr"), &damaged).unwrap();
        let _ = read_exr(&folder.join("damaged.exr"));
    }
}

#[test]
fn comparing_follows_the_contract() {
    let folder = folder();
    let folder = folder.path();
    picture(folder, "a.exr", 2, &[1.0, 0.75, 0.0, 1.0]);
    picture(folder, "b.exr", 2, &[1.0, 0.50, 0.0, 1.0]);
    picture(folder, "u.exr", 2, &[1.0, 1.00, 1.0, 1.0]);
    let keys = ["mae", "rmse", "max", "mean_relative", "bias", "flip", "reference_mean", "pixels"];
    let plain = json(folder, &["compare", "a.exr", "b.exr", "--json"]);
    assert!(keys.iter().all(|k| plain[*k].is_number()), "{plain}");
    assert!(plain.get("penumbra").is_none());
    assert_eq!((plain["mae"].as_f64(), plain["bias"].as_f64()), (Some(0.0625), Some(0.0625)));
    let args =
        ["compare", "a.exr", "b.exr", "--json", "--unshadowed", "u.exr", "--diff", "d.png", "--heatmap", "h.png"];
    let penumbra = &json(folder, &args)["penumbra"];
    assert_eq!(penumbra["pixels"], 1);
    assert!(["mean", "p99", "max"].iter().all(|k| (penumbra[*k].as_f64().unwrap() - 0.25).abs() < 1e-9), "{penumbra}");
    assert!(fs::read(folder.join("d.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(fs::read(folder.join("h.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn rendering_writes_pictures_and_figures() {
    let folder = folder();
    let folder = folder.path();
    let out = succeed(folder, &["render", "scene.toml", "-o", "a.png", "-o", "a.exr", "--layers", "--stats", "a.json"]);
    assert!(out.contains("48 x 32"), "{out}");
    assert_eq!(names(folder), ["a.exr", "a.json", "a.png", "scene.toml"]);
    let stats: Value = serde_json::from_str(&fs::read_to_string(folder.join("a.json")).unwrap()).unwrap();
    for key in ["points", "frames", "lights", "spheres", "triangles", "seconds", "points_per_second"] {
        assert!(stats[key].as_f64().unwrap() > 0.0, "{key} in {stats}");
    }
    for key in ["reflectance", "lighting", "mask", "visibility_lobes", "integration"] {
        assert!(stats["stages"][key].is_number(), "{key} in {stats}");
    }
    for key in ["lobes", "integrals", "pruned", "lit_points", "dark_points", "penumbra_points"] {
        assert!(stats["counts"][key].is_u64(), "{key} in {stats}");
    }
    assert_eq!(stats["tolerance"], 0.005);
    assert_eq!(
        (&stats["device"], &stats["method"], &stats["visibility"]),
        (&"cpu".into(), &"moments".into(), &"scene".into())
    );

    let beauty = read_exr(&folder.join("a.exr")).unwrap();
    let light = read_exr_layer(&folder.join("a.exr"), "light0").unwrap().unwrap();
    let layer = read_exr_layer(&folder.join("a.exr"), "unshadowed").unwrap().unwrap();
    assert_eq!(beauty, light);
    succeed(folder, &["render", "scene.toml", "-o", "u.exr", "--visibility", "none", "--quiet"]);
    assert_eq!(read_exr(&folder.join("u.exr")).unwrap(), layer);

    // Twice the same, on any number of threads, over the old file; and quiet is quiet.
    let before = fs::read(folder.join("a.png")).unwrap();
    let ran = lobes(folder, &["render", "scene.toml", "-o", "a.png", "--quiet", "--threads", "1"]);
    assert!(ran.status.success() && ran.stdout.is_empty() && ran.stderr.is_empty());
    assert_eq!(fs::read(folder.join("a.png")).unwrap(), before);
}

/// The two ways to the same picture, end to end, with the accuracy that the tolerance asks for.
#[test]
fn render_agrees_with_reference() {
    let folder = folder();
    let folder = folder.path();
    let stated = json(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "1024", "--json"]);
    assert!(stated["stderr"].as_f64().unwrap() < 1e-4 * stated["mean"].as_f64().unwrap(), "{stated}");
    succeed(folder, &["render", "scene.toml", "-o", "a.exr", "--tolerance", "0.005"]);
    let error = json(folder, &["compare", "a.exr", "ref.exr", "--unshadowed", "ref.exr", "--json"]);
    assert!(error["penumbra"]["pixels"].as_u64().unwrap() > 20, "{error}");
    assert!(error["penumbra"]["mean"].as_f64().unwrap() < 0.005, "{error}");
    assert!(error["mae"].as_f64().unwrap() < 0.003 * error["reference_mean"].as_f64().unwrap(), "{error}");
    assert_eq!(error["dark_nonzero"], 0, "{error}");
}

/// Swapping the strategy by one word: shadow rays see the balls that the spheres strategy splats.
#[test]
fn rays_see_what_spheres_stand_for() {
    let folder = folder();
    let folder = folder.path();
    succeed(
        folder,
        &["render", "scene.toml", "-o", "a.exr", "-o", "a.png", "--visibility", "rays", "--stats", "a.json"],
    );
    succeed(folder, &["reference", "scene.toml", "-o", "mesh.exr", "--geometry", "mesh", "--spp", "1024", "-q"]);
    let error = json(folder, &["compare", "a.exr", "mesh.exr", "--unshadowed", "mesh.exr", "--json"]);
    assert!(error["penumbra"]["mean"].as_f64().unwrap() < 0.005, "{error}");
    let stats: Value = serde_json::from_str(&fs::read_to_string(folder.join("a.json")).unwrap()).unwrap();
    assert_eq!((&stats["visibility"], &stats["spheres"]), (&"rays".into(), &0.into()));
}

/// A table's top over the floor, as triangles.
const TABLE: &str = r#"
[[objects]]
name = "table"
box = { center = [-1.5, 0.9, 0.5], size = [1.2, 0.1, 0.8] }
proxy = { spheres = 8 }
"#;

/// The third strategy: a depth map of the triangles, the same balls, no sphere set built.
#[test]
fn shadow_maps_see_the_true_triangles() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE).unwrap();
    let render = |name: &str, further: &[&str]| {
        let args = ["render", "table.toml", "-o", name, "--json", "--visibility"];
        json(folder, &[&args, further].concat())
    };
    let stats = render("map.exr", &["shadow-map"]);
    assert_eq!((&stats["visibility"], &stats["spheres"]), (&"shadow-map".into(), &1.into()), "{stats}");
    assert_eq!(stats["map_resolutions"].as_array().unwrap().len(), 1, "{stats}");
    assert!(stats["map_bytes"].as_u64().unwrap() > 0 && stats["map_seconds"].as_f64().unwrap() > 0.0, "{stats}");
    assert!(!folder.with_extension("cache").exists(), "a sphere set was built");
    let unshadowed = render("none.exr", &["none"]);
    assert_eq!((&unshadowed["map_bytes"], &unshadowed["spheres"]), (&0.into(), &0.into()));
    render("rays.exr", &["rays"]);
    let error = json(folder, &["compare", "map.exr", "rays.exr", "--unshadowed", "none.exr", "--json"]);
    assert!(error["penumbra"]["pixels"].as_u64().unwrap() > 40, "{error}");
    // On floors 1 % is what the strategy promises.
    assert!(error["penumbra"]["mean"].as_f64().unwrap() < 0.01, "{error}");

    // A resolution that is asked for is taken; too coarse a one is told, with the way out.
    let coarse = ["render", "table.toml", "-o", "c.exr", "--visibility", "shadow-map", "--map-resolution", "16"];
    let ran = lobes(folder, &coarse);
    let told = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success() && told.contains("light 0") && told.contains("--visibility rays"), "{told}");
    assert_eq!(json(folder, &[&coarse[..], &["--json", "-q"]].concat())["map_resolutions"][0], 16);
    for bad in ["0", "100000", "15", "8193", "1.5", "x"] {
        let args = ["render", "table.toml", "--visibility", "shadow-map", "--map-resolution", bad];
        refuse(folder, &args, "16 to 8192");
    }
    refuse(folder, &["render", "table.toml", "--visibility", "rays", "--map-resolution", "512"], "no shadow map");
    // The floor alone shadows nothing: an empty map, and no fault.
    assert_eq!(json(folder, &["render", "scene.toml", "--visibility", "shadow-map", "--json"])["map_bytes"], 0);
}

/// By the paper's method too.
#[test]
fn shadow_maps_by_the_paper_s_method() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE).unwrap();
    let args = ["render", "table.toml", "-q", "--visibility", "shadow-map", "-o"];
    succeed(folder, &[&args[..], &["paper.exr", "--method", "paper"]].concat());
    succeed(folder, &[&args[..], &["moments.exr"]].concat());
    let error = json(folder, &["compare", "paper.exr", "moments.exr", "--json"]);
    let relative = error["mae"].as_f64().unwrap() / error["reference_mean"].as_f64().unwrap();
    // The paper's light lobe has up to 13.8 % too much flux; the shadows are the same.
    assert!((0.01..0.2).contains(&relative), "{error}");
}

/// The ball of [`SCENE`] rolls for one second, the light goes with it: 11 frames at 10 a second.
fn rolling() -> String {
    let moved = "\nkeys = [{ time = 0 }, { time = 1, translate = [1, 0, 0] }]";
    let (ball, light) = ("radius = 0.6 }", "radiance = [20.0, 20.0, 20.0]");
    let scene = SCENE.replace(ball, &format!("{ball}{moved}")).replace(light, &format!("{light}{moved}"));
    format!("[animation]\nfps = 10\n{scene}{TABLE}")
}

#[test]
fn a_sequence_is_one_file_a_frame() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("roll.toml"), rolling()).unwrap();
    let args = ["render", "roll.toml", "-o", "r.exr", "-o", "r.png", "--frames", "2..5", "--stats", "r.json", "-q"];
    succeed(folder, &args);
    let files = ["r.0002.exr", "r.0002.png", "r.0003.exr", "r.0003.png", "r.0004.exr", "r.0004.png", "r.json"];
    assert_eq!(names(folder), [&files[..], &["roll.toml", "scene.toml"]].concat());
    let stats: Value = serde_json::from_str(&fs::read_to_string(folder.join("r.json")).unwrap()).unwrap();
    assert_eq!((&stats["frames"], &stats["skipped_frames"]), (&3.into(), &0.into()));
    assert!(stats["seconds"].as_f64().unwrap() > 0.0 && stats["update_seconds"].as_f64().unwrap() > 0.0, "{stats}");
    for key in ["pose", "spheres", "hierarchy", "maps"] {
        assert!(stats["update"][key].is_number(), "{key} in {stats}");
    }

    // A frame of a sequence is the frame alone and the moment alone, whatever was rendered before it, by any strategy.
    let same =
        |a: &str, b: &str| assert_eq!(fs::read(folder.join(a)).unwrap(), fs::read(folder.join(b)).unwrap(), "{a}");
    succeed(folder, &["render", "roll.toml", "-o", "one.exr", "--frame", "4", "-q"]);
    same("one.exr", "r.0004.exr");
    succeed(folder, &["render", "roll.toml", "-o", "one.exr", "--time", "0.4", "-q"]);
    same("one.exr", "r.0004.exr");
    succeed(folder, &["render", "roll.toml", "-o", "one.exr", "--frame", "8", "--fps", "20", "-q"]);
    same("one.exr", "r.0004.exr");
    for word in ["rays", "shadow-map"] {
        let sequence = format!("{word}.exr");
        succeed(folder, &["render", "roll.toml", "-o", &sequence, "--frames", "2..5", "--visibility", word, "-q"]);
        succeed(folder, &["render", "roll.toml", "-o", "one.exr", "--frame", "4", "--visibility", word, "-q"]);
        same("one.exr", &format!("{word}.0004.exr"));
    }
    assert_ne!(fs::read(folder.join("r.0002.png")).unwrap(), fs::read(folder.join("r.0004.png")).unwrap());

    // Finished frames are left alone, also if one of two files is missing that one frame is made again.
    let written = |name: &str| fs::metadata(folder.join(name)).unwrap().modified().unwrap();
    let before = [written("r.0002.png"), written("r.0003.png")];
    fs::remove_file(folder.join("r.0003.exr")).unwrap();
    let stats = json(folder, &[&args[..], &["--json"]].concat());
    assert_eq!((&stats["frames"], &stats["skipped_frames"]), (&1.into(), &2.into()));
    let after = [written("r.0002.png"), written("r.0003.png")];
    assert!(after[0] == before[0] && after[1] > before[1]);
    let stats = json(folder, &[&args[..], &["--json"]].concat());
    assert_eq!((&stats["frames"], &stats["skipped_frames"]), (&0.into(), &3.into()));
}

#[test]
fn frames_that_there_are_not_are_refused() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("roll.toml"), rolling()).unwrap();
    let frames = |scene: &str, text: &str, what: &str| {
        refuse(folder, &["render", scene, "-o", "r.png", "--frames", text], what);
    };
    frames("roll.toml", "0..12", "no frame 11: the animation has frames 0 to 10 (1 s at 10 a second)");
    frames("roll.toml", "11..12", "no frame 11");
    frames("roll.toml", "4000000000..4000000001", "no frame 4000000000");
    frames("roll.toml", "5..2", "no frames from 5 to before 2");
    frames("roll.toml", "3..3", "no frames from 3 to before 3");
    for bad in ["", "3", "..", "1..", "..2", "-1..2", "a..b", "0..=3", "1.5..2", "0..5000000000"] {
        let given = format!("--frames={bad}");
        refuse(folder, &["render", "roll.toml", "-o", "r.png", &given], "--frames");
    }
    frames("scene.toml", "0..2", "nothing moves");
    refuse(folder, &["render", "roll.toml", "--frame", "11"], "no frame 11");
    refuse(folder, &["render", "roll.toml", "--time", "1.01"], "ends at 1 s");
    refuse(folder, &["render", "roll.toml", "--time", "nan"], "--time");
    refuse(folder, &["render", "roll.toml", "--fps", "0", "--frame", "1"], "--fps");
    refuse(folder, &["render", "roll.toml", "--fps", "12"], "--fps");
    refuse(folder, &["render", "roll.toml", "--frame", "1", "--frames", "0..2"], "--frame");
    refuse(folder, &["render", "scene.toml", "--time", "0.5"], "nothing moves");
    refuse(folder, &["render", "--frame", "1"], "nothing moves");
    refuse(folder, &["reference", "roll.toml", "--frame", "11"], "no frame 11");
    refuse(folder, &["render", "roll.toml", "-o", "no/r.png", "--frames", "0..2"], "no/r.0000.png");
    // A glTF file whose animation is empty.
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "animations": [{"name": "none", "channels": [], "samplers": []}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "t.bin"}]}"#;
    fs::write(folder.join("t.gltf"), gltf).unwrap();
    let corners = [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    fs::write(folder.join("t.bin"), corners.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    let ran = lobes(folder, &["render", "t.gltf", "-o", "r.png", "--frames", "0..1"]);
    let stderr = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.code() == Some(2) && stderr.contains("lobes: error: "), "{stderr}");
    assert!(!folder.join("r.0000.png").exists());
    // One whose skin has bones that are not there.
    let gltf = gltf
        .replace(r#"{"mesh": 0}"#, r#"{"mesh": 0, "skin": 0}"#)
        .replace(r#""meshes":"#, r#""skins": [{"joints": [99]}], "meshes":"#);
    fs::write(folder.join("t.gltf"), gltf).unwrap();
    refuse(folder, &["render", "t.gltf", "-o", "r.png", "--frames", "0..1"], "t.gltf");
}

#[test]
fn a_clip_is_chosen_by_name_or_number() {
    let folder = folder();
    let folder = folder.path();
    let fox = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/assets/fox.glb");
    let picture = |name: &str, options: &[&str]| {
        let common = ["render", fox, "-o", name, "--size", "32x18", "--visibility", "none", "-q"];
        succeed(folder, &[&common, options].concat());
        fs::read(folder.join(name)).unwrap()
    };
    let walk = picture("walk.exr", &["--clip", "Walk", "--time", "0.3"]);
    assert_eq!(walk, picture("one.exr", &["--clip", "1", "--time", "0.3"]));
    assert_ne!(walk, picture("survey.exr", &["--time", "0.3"]));
    refuse(folder, &["render", fox, "--clip", "Fly"], "Survey");
    refuse(folder, &["render", "--clip", "Walk"], "<FILE>");
    refuse(folder, &["render", "scene.toml", "--clip", "Walk"], "scene file");
}

/// Ctrl-C between and within frames: whole files only, and the same command goes on.
#[cfg(unix)]
#[test]
fn an_interrupted_sequence_leaves_whole_frames() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("roll.toml"), rolling()).unwrap();
    let args =
        ["render", "roll.toml", "-o", "r.exr", "--frames", "0..11", "--size", "1600x900", "--visibility", "rays"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_lobes"))
        .current_dir(folder)
        .args(args)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !folder.join("r.0000.exr").exists() {
        assert!(child.try_wait().unwrap().is_none(), "ended early");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let left = names(folder);
    let whole: Vec<_> = left.iter().filter(|n| n.ends_with(".exr")).collect();
    assert_eq!(left.len(), whole.len() + 2, "{left:?}");
    assert!((1..11).contains(&whole.len()) && whole.iter().all(|n| read_exr(&folder.join(n)).is_ok()), "{left:?}");
}

/// A strategy for each object, in the picture and in the reference.
#[test]
fn objects_take_their_own_strategies() {
    let folder = folder();
    let folder = folder.path();
    let with = |ball: &str, table: &str| {
        let ball = format!("radius = 0.6 }}\nvisibility = \"{ball}\"");
        let table = format!("proxy = {{ spheres = 8 }}\nvisibility = \"{table}\"");
        let scene = SCENE.replace("radius = 0.6 }", &ball) + &TABLE.replace("proxy = { spheres = 8 }", &table);
        fs::write(folder.join("mixed.toml"), scene).unwrap();
    };
    let render = |name: &str, further: &[&str]| {
        json(folder, &[&["render", "mixed.toml", "-o", name, "--json"], further].concat())
    };
    let error = |a: &str, b: &str| {
        let e = json(folder, &["compare", a, b, "--unshadowed", "none.exr", "--json"]);
        assert!(e["penumbra"]["pixels"].as_u64().unwrap() > 40, "{e}");
        e["penumbra"]["mean"].as_f64().unwrap()
    };
    with("spheres", "rays");
    render("none.exr", &["--visibility", "none"]);
    for table in ["rays", "shadow-map"] {
        with("spheres", table);
        let stats = render("mixed.exr", &[]);
        assert_eq!((&stats["visibility"], &stats["spheres"]), (&"scene".into(), &1.into()));
        assert!(!folder.with_extension("cache").exists(), "a sphere set was built");
        succeed(folder, &["reference", "mixed.toml", "-o", "ref.exr", "--spp", "1024", "-q"]);
        succeed(folder, &["reference", "mixed.toml", "-o", "mesh.exr", "--spp", "1024", "--geometry", "mesh", "-q"]);
        let limit = if table == "rays" { 0.005 } else { 0.01 };
        assert!(error("mixed.exr", "ref.exr") < limit, "{}", error("mixed.exr", "ref.exr"));
        // Balls as spheres and the table as it is: nothing is approximated.
        assert!(error("ref.exr", "mesh.exr") < 0.002, "{}", error("ref.exr", "mesh.exr"));
    }
    // An object can be told to cast no shadow; a word for all overrides it.
    with("none", "none");
    render("mixed.exr", &[]);
    assert_eq!(read_exr(&folder.join("mixed.exr")).unwrap(), read_exr(&folder.join("none.exr")).unwrap());
    assert_eq!(render("all.exr", &["--visibility", "spheres"])["spheres"], 9);
    fs::remove_dir_all(folder.with_extension("cache")).unwrap();
}

/// Sphere files that are none, or another mesh's: named, with the object.
#[test]
fn wrong_sphere_files_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.join("m.obj"), obj).unwrap();
    fs::write(folder.join("larger.obj"), obj.replace("v 1 0 0", "v 3 0 0")).unwrap();
    fs::write(folder.join("other.obj"), obj.replace("f 2 3 4\n", "")).unwrap();
    succeed(folder, &["spheres", "m.obj", "--count", "4", "--draft", "-o", "set.json", "-q"]);
    let scene = |mesh: &str, set: &str| {
        let object = format!("\n[[objects]]\nname = \"thing\"\nmesh = \"{mesh}\"\nproxy = {{ file = \"{set}\" }}\n");
        fs::write(folder.join("with.toml"), SCENE.to_owned() + &object).unwrap();
    };
    scene("m.obj", "set.json");
    succeed(folder, &["render", "with.toml", "-q"]);
    fs::remove_file(folder.join("lobes.png")).unwrap();
    let set = fs::read_to_string(folder.join("set.json")).unwrap();
    let first = set.find("    [").unwrap();
    let (start, rest) = set.split_at(first);
    let row = rest.lines().next().unwrap();
    for bad in ["[NaN, 0, 0, 1],", "[1e99, 0, 0, 1],", "[0, 0, 0, -1],", "[null, 0, 0, 1],"] {
        fs::write(folder.join("bad.json"), format!("{start}    {bad}{}", &rest[row.len()..])).unwrap();
        scene("m.obj", "bad.json");
        refuse(folder, &["render", "with.toml"], "bad.json");
        refuse(folder, &["check", "with.toml"], "bad.json");
    }
    for (mesh, what) in [("larger.obj", "bounding box"), ("other.obj", "triangles")] {
        scene(mesh, "set.json");
        for command in ["render", "reference", "check"] {
            refuse(folder, &[command, "with.toml"], what);
        }
    }
    // Nobody who takes the true triangles reads the set.
    succeed(folder, &["render", "with.toml", "-q", "--visibility", "rays"]);
}

#[test]
fn references_go_on_where_they_stopped() {
    let folder = folder();
    let folder = folder.path();
    succeed(folder, &["reference", "scene.toml", "-o", "whole.exr", "--spp", "1024", "-q"]);
    assert_eq!(names(folder), ["scene.toml", "whole.exr"]);
    succeed(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "512", "--keep", "-q"]);
    assert_eq!(names(folder), ["ref.exr", "ref.exr.checkpoint", "scene.toml", "whole.exr"]);
    succeed(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "1024", "-q"]);
    assert_eq!(names(folder), ["ref.exr", "scene.toml", "whole.exr"]);
    assert_eq!(fs::read(folder.join("ref.exr")).unwrap(), fs::read(folder.join("whole.exr")).unwrap());

    fs::write(folder.join("ref.exr.checkpoint"), b"no checkpoint").unwrap();
    refuse(folder, &["reference", "scene.toml", "-o", "ref.exr"], "ref.exr.checkpoint");
}

/// Ctrl-C in the middle: a checkpoint and nothing half done; the next run uses it.
#[cfg(unix)]
#[test]
fn an_interrupted_reference_keeps_its_work() {
    let folder = folder();
    let folder = folder.path();
    let mut child = Command::new(env!("CARGO_BIN_EXE_lobes"))
        .current_dir(folder)
        .args(["reference", "scene.toml", "-o", "ref.exr", "--spp", "16000000"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Its temporary file tells that it has begun; a little later it samples.
    while names(folder).len() < 2 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::thread::sleep(std::time::Duration::from_millis(1000));
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(folder), ["ref.exr.checkpoint", "scene.toml"]);
    let ran = lobes(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "8"]);
    assert!(ran.status.success());
    assert!(String::from_utf8_lossy(&ran.stderr).contains("goes on from"), "{}", String::from_utf8_lossy(&ran.stderr));
    assert_eq!(names(folder), ["ref.exr", "scene.toml"]);
}

#[test]
fn checking_and_help() {
    let folder = folder();
    let folder = folder.path();
    assert!(succeed(folder, &["check", "scene.toml"]).contains("lights     1"));
    assert_eq!(json(folder, &["check", "scene.toml", "--json"])["spheres"], 1);
    // Pictures are made in bands: what a large one takes is the picture itself, 15 bytes a pixel, and a little.
    let large = SCENE.replace("width = 48", "width = 16384").replace("height = 32", "height = 16384");
    fs::write(folder.join("large.toml"), large).unwrap();
    let bytes = json(folder, &["check", "large.toml", "--json"])["memory_bytes"].as_u64().unwrap();
    assert!((15 << 28..16 << 28).contains(&bytes), "{bytes}");
    assert!(succeed(folder, &["check"]).contains("lobes"));
    let schema = succeed(folder, &["check", "--schema"]);
    assert!(schema.contains("[camera]"));
    // A scene but for the files that it names, and its first line names them.
    let first = schema.lines().next().unwrap();
    assert!(first.contains("example.obj") && first.contains("example.spheres.json"), "{first}");
    fs::write(folder.join("schema.toml"), &schema).unwrap();
    refuse(folder, &["check", "schema.toml"], "example.obj");
    for args in [&[][..], &["--help"], &["render", "--help"], &["reference", "-h"], &["--version"]] {
        assert!(!succeed(folder, args).is_empty());
    }
    assert!(succeed(folder, &["render", "--help"]).contains("Examples:"));
}

/// Each object gets a strategy and a reason that follows from its shape.
#[test]
fn checking_advises_for_each_object() {
    let folder = folder();
    let folder = folder.path();
    // A bowl, open above, of 8 × 16 quads; and a pole of as many triangles.
    let (mut bowl, mut pole) = (String::new(), String::new());
    for ring in 0..=8 {
        for step in 0..16 {
            let (a, b) = (ring as f64 / 8.0 * 1.5, step as f64 / 16.0 * std::f64::consts::TAU);
            bowl += &format!("v {} {} {}\n", a.sin() * b.cos(), 1.0 - a.cos(), a.sin() * b.sin());
            let (y, r) = (ring as f64 * 0.5, if ring % 8 == 0 { 0.0 } else { 0.02 });
            pole += &format!("v {} {y} {}\n", r * b.cos(), r * b.sin());
        }
    }
    for ring in 0..8 {
        for step in 0..16 {
            let at = |r: usize, s: usize| r * 16 + s % 16 + 1;
            let (a, b, c, d) = (at(ring, step), at(ring, step + 1), at(ring + 1, step + 1), at(ring + 1, step));
            let faces = format!("f {a} {b} {c}\nf {a} {c} {d}\n");
            bowl += &faces;
            pole += &faces;
        }
    }
    fs::write(folder.join("bowl.obj"), bowl).unwrap();
    fs::write(folder.join("pole.obj"), pole).unwrap();
    let meshes = "\n[[objects]]\nmesh = \"bowl.obj\"\ntranslate = [2, 0, 0]\n\n[[objects]]\nmesh = \"pole.obj\"\n\
                  translate = [-3, 0, 0]\nvisibility = \"rays\"\n";
    fs::write(folder.join("all.toml"), SCENE.to_owned() + TABLE + meshes).unwrap();
    let all = json(folder, &["check", "all.toml", "--json"]);
    let advice = |n: usize| {
        let advice = &all["objects"][n]["advice"];
        (advice["visibility"].as_str().unwrap(), advice["reason"].as_str().unwrap())
    };
    for (n, (word, reason)) in [
        ("none", "backdrop"),
        ("spheres", "balls are exact"),
        ("rays", "12 triangles"),
        ("rays", "open"),
        ("rays", "thin"),
    ]
    .into_iter()
    .enumerate()
    {
        assert!(advice(n).0 == word && advice(n).1.contains(reason), "{n}: {:?}", advice(n));
    }
    assert_eq!(all["objects"][4]["visibility"], "rays");
    assert!(all["animation"].is_null());
    assert!(succeed(folder, &["check", "all.toml"]).contains("advice: visibility = \"rays\""));
    // Seen from below, the floor hides the ball: it is no backdrop any more.
    fs::write(folder.join("below.toml"), SCENE.replace("eye = [0.0, 3.0, 8.0]", "eye = [0.0, -3.0, 8.0]")).unwrap();
    assert_eq!(json(folder, &["check", "below.toml", "--json"])["objects"][0]["advice"]["visibility"], "rays");

    // What moves is told.
    fs::write(folder.join("roll.toml"), rolling()).unwrap();
    let roll = json(folder, &["check", "roll.toml", "--json"]);
    assert_eq!((&roll["animation"]["duration"], &roll["animation"]["frames"]), (&1.0.into(), &11.into()));
    assert!(succeed(folder, &["check", "roll.toml"]).contains("frames 0 to 10"));
}

/// A material that gives more than it gets is taken, and told.
#[test]
fn too_bright_materials_are_told() {
    let folder = folder();
    let folder = folder.path();
    for (model, told) in [
        ("model = \"lambert\"\nalbedo = [0.2, 1.5, 0.2]", true),
        ("model = \"lambert\"\nalbedo = 1.0", false),
        ("model = \"modified-phong\"\nkd = 0.7\nks = 0.7\nexponent = 50", true),
        ("model = \"modified-phong\"\nkd = 0.6\nks = 0.4\nexponent = 50", false),
    ] {
        let scene = SCENE.replace("[[lights]]", &format!("[materials.m]\n{model}\n\n[[lights]]"));
        let scene = scene.replace("radius = 0.6 }", "radius = 0.6 }\nmaterial = \"m\"");
        fs::write(folder.join("m.toml"), scene).unwrap();
        let ran = lobes(folder, &["check", "m.toml"]);
        let stderr = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success() && stderr.contains("times the light it gets") == told, "{model}: {stderr}");
    }
}

/// A mesh's spheres are built once: the second picture is the same and takes them from the cache.
#[test]
fn spheres_are_kept_between_runs() {
    let folder = folder();
    let folder = folder.path();
    let cache = folder.with_extension("cache").join("cosine-lobes");
    let scene =
        SCENE.to_owned() + "\n[[objects]]\nbox = { center = [0, 1, 2], size = [1, 1, 1] }\nproxy = { spheres = 8 }\n";
    fs::write(folder.join("box.toml"), scene).unwrap();
    succeed(folder, &["render", "box.toml", "-o", "a.exr", "-q"]);
    let kept = names(&cache);
    assert_eq!(kept.len(), 1);
    // A spoilt entry is built anew.
    for spoil in [false, true] {
        if spoil {
            fs::write(cache.join(&kept[0]), "{}").unwrap();
        }
        succeed(folder, &["render", "box.toml", "-o", "b.exr", "-q"]);
        assert_eq!(fs::read(folder.join("a.exr")).unwrap(), fs::read(folder.join("b.exr")).unwrap());
    }
    assert_eq!(names(&cache), kept);
    fs::remove_dir_all(folder.with_extension("cache")).unwrap();
}

/// The set of a skinned mesh tells which bones carry each sphere, and stays a set like any other.
#[test]
fn sets_of_skinned_meshes_have_bones() {
    let folder = folder();
    let folder = folder.path();
    let fox = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/assets/fox.glb");
    succeed(folder, &["spheres", fox, "--count", "8", "--draft", "-o", "fox.json", "-q"]);
    let text = fs::read_to_string(folder.join("fox.json")).unwrap();
    let bound = BoundSet::from_json(&text).unwrap();
    assert_eq!((bound.rest().spheres.len(), bound.targets()), (8, 0));
    // Of the model's 24 joints the numbers go up to the last one that carries something.
    assert!((10..=24).contains(&bound.joints()), "{}", bound.joints());
    assert_eq!(SphereSet::from_json(&text).unwrap(), *bound.rest());
}

#[test]
fn sphere_sets_follow_the_contract() {
    let folder = folder();
    let folder = folder.path();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.join("m.obj"), obj).unwrap();
    let args = ["spheres", "m.obj", "--count", "4", "--draft", "-o", "set.json", "--preview", "p.png", "--json", "-q"];
    let figures = json(folder, &args);
    for key in ["count", "seconds", "coverage", "protrusion_volume", "hausdorff_outside", "p95_gap", "silhouette_error"]
    {
        assert!(figures[key].is_number(), "{key} in {figures}");
    }
    assert_eq!(names(folder), ["m.obj", "p.png", "scene.toml", "set.json"]);
    // The stored set serves a scene.
    let scene = SCENE.to_owned() + "\n[[objects]]\nmesh = \"m.obj\"\nproxy = { file = \"set.json\" }\n";
    fs::write(folder.join("with.toml"), scene).unwrap();
    let stats = json(folder, &["render", "with.toml", "-o", "a.png", "--json"]);
    assert_eq!(stats["spheres"], 5);
    // And is looked into when the scene is checked.
    assert_eq!(json(folder, &["check", "with.toml", "--json"])["spheres"], 5);
    fs::write(folder.join("set.json"), "{}").unwrap();
    refuse(folder, &["check", "with.toml"], "set.json");
}
