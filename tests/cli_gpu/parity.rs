//! The same picture by `--device cpu` and `--device gpu`.

use crate::support::*;
use cosine_lobes::read_exr;
use serde_json::Value;
use std::fs;
use std::path::Path;

crate::tests![
    strategies,
    settings,
    paper,
    projections,
    shadow_maps,
    walls,
    rays,
    silhouettes,
    samples_and_threshold,
    trade
];

/// Largest and mean difference, as fractions of the picture's largest value. Where little of a light is seen, both look again through different
/// windows.
const LARGEST: f32 = 1.5e-3;
/// Next to nothing of a light is drawn again by the CPU alone: by coarse masks that shows.
const LARGEST_OF_A_DRAFT: f32 = 2e-3;
const MEAN: f64 = 1e-5;

/// Renders by both and compares the pictures; the figures of both.
pub(crate) fn alike(folder: &Path, options: &[&str]) -> [Value; 2] {
    let render = |device: &str, name: &str| {
        json(folder, &[&["render", "--device", device, "-o", name, "--json", "-q"], options].concat())
    };
    let (cpu, gpu) = (render("cpu", "cpu.exr"), render("gpu", "gpu.exr"));
    let [want, got] = ["cpu.exr", "gpu.exr"].map(|name| read_exr(&folder.join(name)).unwrap());
    let peak = want.pixels().iter().map(|p| p.max_element()).fold(0.0, f32::max);
    assert!(peak > 0.0, "{options:?}: a black picture");
    let apart: Vec<f32> =
        want.pixels().iter().zip(got.pixels()).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    let largest = apart.iter().copied().fold(0.0, f32::max);
    let mean = apart.iter().map(|d| f64::from(*d)).sum::<f64>() / apart.len() as f64;
    println!("{options:?}: largest {largest:.1e}, mean {mean:.1e}");
    assert!(got.pixels().iter().all(|p| p.is_finite()), "{options:?}");
    let most = if options.contains(&"draft") { LARGEST_OF_A_DRAFT } else { LARGEST };
    assert!(largest <= most && mean <= MEAN, "{options:?}: largest {largest:.2e}, mean {mean:.2e}");
    for key in ["points", "lights", "spheres", "tolerance", "depth", "visibility", "method", "map_resolutions"] {
        assert_eq!(cpu[key], gpu[key], "{options:?}: {key}");
    }
    assert_eq!(cpu["device"], "cpu");
    assert!(gpu["device"] != "cpu" && gpu["device"].as_str().is_some_and(|name| !name.is_empty()), "{gpu}");
    [cpu, gpu]
}

/// The same, and that both find as many points lit, dark and between; the GPU's figures.
pub(crate) fn same(folder: &Path, options: &[&str]) -> Value {
    let [cpu, gpu] = alike(folder, options);
    for key in ["lit_points", "dark_points", "penumbra_points"] {
        let [a, b] = [&cpu, &gpu].map(|stats| stats["counts"][key].as_u64().unwrap());
        println!("    {key} {a} {b}");
        // Outlines have points on rims, where rounding decides.
        assert!(a.abs_diff(b) <= 2 + cpu["points"].as_u64().unwrap() / 1000, "{options:?}: {key} {a} {b}");
    }
    gpu
}

/// The built-in scene: exact spheres, five materials, two lights.
fn strategies() {
    let folder = folder();
    for visibility in ["scene", "spheres", "none"] {
        same(folder.path(), &["--size", "96x54", "--visibility", visibility]);
    }
}

fn settings() {
    let folder = folder();
    for options in [&["--quality", "draft"][..], &["--quality", "high"], &["--tolerance", "0.02", "--depth", "6"]] {
        same(folder.path(), &[&["--size", "64x36"], options].concat());
    }
}

/// By the paper's method, with all of its tables.
fn paper() {
    let folder = folder();
    same(folder.path(), &["--size", "48x27", "--method", "paper"]);
    // The table is invisible: receivers on it would use silhouettes on the CPU and rays on the GPU, which differ in this method at this depth.
    fs::write(folder.path().join("table.toml"), format!("{SCENE}{TABLE}visible = false\n")).unwrap();
    let maps = ["--visibility", "shadow-map", "--depth", "4", "--threshold", "0.01"];
    same(folder.path(), &[&["table.toml", "--method", "paper"], &maps[..]].concat());
}

/// Cameras without one eye, and around it.
fn projections() {
    let folder = folder();
    for (name, keys) in
        [("orthographic", "projection = \"orthographic\"\nheight = 4"), ("panoramic", "projection = \"panoramic\"")]
    {
        let scene = SCENE.replace("fov = 30.0", keys).replace("[0.0, 3.0, 8.0]", "[0.0, 2.0, 3.0]");
        let file = format!("{name}.toml");
        fs::write(folder.path().join(&file), format!("{scene}{TABLE}")).unwrap();
        for visibility in ["scene", "rays", "shadow-map"] {
            same(folder.path(), &[&file, "--visibility", visibility, "--samples", "1"]);
        }
    }
}

/// A light that moves past a table's side: the side is in the map, by silhouettes or rays and in the map again.
fn walls() {
    let folder = folder();
    let folder = folder.path();
    let side = "[[objects]]\nquad = { center = [1.5, 1.0, 0.0], u = [0.0, 0.8, 0.0], v = [0.0, 0.0, 0.8] }\n";
    let keys = "keys = [{ time = 0 }, { time = 1, translate = [-3.0, 0.0, 0.0] }]\n";
    let scene = SCENE.replace("[[lights]]", &format!("{side}[[lights]]"));
    fs::write(folder.join("walls.toml"), format!("[animation]\nfps = 3\n{scene}{keys}")).unwrap();
    let options = ["render", "walls.toml", "--frames", "0..4", "--visibility", "shadow-map", "-q"];
    for device in ["cpu", "gpu"] {
        succeed(folder, &[&options[..], &["--device", device, "-o", &format!("{device}.exr")]].concat());
    }
    for frame in 0..4 {
        let [want, got] = ["cpu", "gpu"].map(|d| read_exr(&folder.join(format!("{d}.{frame:04}.exr"))).unwrap());
        let peak = want.pixels().iter().map(|p| p.max_element()).fold(0.0, f32::max);
        for (a, b) in want.pixels().iter().zip(got.pixels()) {
            assert!((*a - *b).abs().max_element() <= LARGEST * peak, "frame {frame}");
        }
    }
}

/// A table's top in the map, a sphere near it. Receivers on the table use silhouettes on the CPU and rays on the GPU: the same masks, which
/// are not made for the same receivers.
fn shadow_maps() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE).unwrap();
    let [_, gpu] = alike(folder, &["table.toml", "--visibility", "shadow-map"]);
    assert!(gpu["map_bytes"].as_u64().unwrap() > 0 && gpu["spheres"] == 1, "{gpu}");
    // Coarse, and with an invisible table, so that only maps are used.
    fs::write(folder.join("floor.toml"), format!("{SCENE}{TABLE}visible = false\n")).unwrap();
    same(folder, &["floor.toml", "--visibility", "shadow-map", "--map-resolution", "256"]);
}

/// Some of its smooth normals see a light that its faces do not: the strategies hide that light differently.
const PILLOW: &str = r#"
[[objects]]
name = "pillow"
box = { center = [0.9, 0.35, 1.0], size = [0.7, 0.6, 0.7] }
normals = "smooth"
visibility = "spheres"
proxy = { spheres = 8 }
"#;

/// All by rays, and a mixture: the sphere and the pillow as spheres, the table's top by rays.
fn rays() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE + PILLOW).unwrap();
    assert_eq!(same(folder, &["table.toml", "--visibility", "rays"])["spheres"], 0);
    let table = TABLE.replace("proxy", "visibility = \"rays\"\nproxy");
    fs::write(folder.join("table.toml"), SCENE.to_owned() + &table + PILLOW).unwrap();
    assert_eq!(same(folder, &["table.toml"])["spheres"], 9);
}

/// Whether a GPU's kernels were made for a strategy.
fn has_kernel(stats: &Value, strategy: &str) -> bool {
    stats["kernels"].as_array().unwrap().iter().any(|kernel| kernel["name"].as_str().unwrap().contains(strategy))
}

/// The table's top by its silhouettes beside spheres; by rays where other objects are by rays, or where a light holds a part of a
/// mesh.
fn silhouettes() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE + PILLOW).unwrap();
    let table = same(folder, &["table.toml"]);
    assert_eq!(table["spheres"], 9);
    assert!(has_kernel(&table, "spheres + silhouettes"), "{table}");
    let pillow = PILLOW.replace("\"spheres\"", "\"rays\"");
    let lamp = "[[objects]]\nname = \"shade\"\nbox = { center = [1.5, 5.5, 1.0], size = [1.0, 0.4, 1.0] }\n";
    for more in [&pillow, lamp] {
        fs::write(folder.join("other.toml"), SCENE.to_owned() + TABLE + more).unwrap();
        let render = ["render", "other.toml", "--device", "gpu", "-o", "gpu.exr", "--json", "-q"];
        let other = json(folder, &render);
        assert!(has_kernel(&other, "rays") && !has_kernel(&other, "silhouettes"), "{other}");
    }
}

fn samples_and_threshold() {
    let folder = folder();
    same(folder.path(), &["scene.toml", "--samples", "3"]);
    let pruned = same(folder.path(), &["--size", "64x36", "--threshold", "0.05"])["counts"]["pruned"].as_u64().unwrap();
    assert!(pruned > 0);
}

/// Both in one table: the same errors, at any time.
fn trade() {
    let folder = folder();
    let settings = ["--method", "moments", "--tolerance", "0.003", "--depth", "4,5", "--spp", "1", "--repeat", "3"];
    let sweep = |devices: &str| {
        let devices = ["trade", "scene.toml", "-o", "out", "--reference-spp", "64", "--json", "--device", devices];
        json(folder.path(), &[&devices[..], &settings].concat()).as_array().unwrap().clone()
    };
    let cpu = sweep("cpu");
    let both = sweep("cpu,gpu");
    // Spheres and rays at two depths, and two samplers.
    assert_eq!((cpu.len(), both.len()), (6, 10));
    assert!(cpu.iter().all(|row| row["device"] == "cpu" && both.iter().any(|b| b["seconds"] == row["seconds"])));
    for gpu in both.iter().filter(|row| row["device"] != "cpu") {
        let is_twin = |row: &&Value| ["visibility", "depth"].iter().all(|key| row[key] == gpu[key]);
        let twin = cpu.iter().find(is_twin).unwrap();
        let apart = (twin["mean"].as_f64().unwrap() - gpu["mean"].as_f64().unwrap()).abs();
        assert!(apart < 1e-5 && gpu["seconds"].as_f64().unwrap() > 0.0, "{twin} {gpu}");
    }
    let text = fs::read_to_string(folder.path().join("out/trade.md")).unwrap();
    assert!(text.contains("GPU ") && text.contains("moments / rays / gpu"), "{text}");
}
