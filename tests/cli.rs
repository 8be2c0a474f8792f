//! The `lobes` command, run as a user runs it.
#![allow(clippy::unwrap_used, reason = "in a test")]

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
    assert!(succeed(folder, &["check", "--schema"]).contains("[camera]"));
    for args in [&[][..], &["--help"], &["render", "--help"], &["reference", "-h"], &["--version"]] {
        assert!(!succeed(folder, args).is_empty());
    }
    assert!(succeed(folder, &["render", "--help"]).contains("Examples:"));
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
