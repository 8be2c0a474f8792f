//! Empty, tiny and huge scenes.

use crate::parity::{alike, same};
use crate::support::*;
use std::fmt::Write;
use std::fs;

crate::tests![
    nothing_blocks,
    one_pixel,
    a_row_of_tiles,
    many_lights,
    many_spheres,
    nothing_is_seen,
    what_is_wrong_is_refused
];

/// No spheres at all.
fn nothing_blocks() {
    let folder = folder();
    let folder = folder.path();
    let (before, sphere) = SCENE.split_once("[[objects]]\nname = \"ball\"").unwrap();
    let (_, lights) = sphere.split_once("[[lights]]").unwrap();
    let floor = format!("{before}[[lights]]{lights}");
    fs::write(folder.join("floor.toml"), floor).unwrap();
    let stats = same(folder, &["floor.toml", "--visibility", "spheres"]);
    assert_eq!((&stats["spheres"], &stats["counts"]["penumbra_points"]), (&0.into(), &0.into()), "{stats}");
}

fn one_pixel() {
    let folder = folder();
    let stats = same(folder.path(), &["--size", "1x1"]);
    assert_eq!(stats["points"], 1);
}

/// Wider than any picture that is looked at.
fn a_row_of_tiles() {
    let folder = folder();
    same(folder.path(), &["--size", "8192x8", "--quality", "draft"]);
}

fn many_lights() {
    let folder = folder();
    let folder = folder.path();
    let mut scene = SCENE.split("[[lights]]").next().unwrap().to_owned();
    for k in 0..64 {
        let (x, z) = (f64::from(k % 8) - 3.5, f64::from(k / 8) - 3.5);
        write!(
            scene,
            "\n[[lights]]\nkind = \"sphere\"\ncenter = [{x}, 5.0, {z}]\nradius = 0.2\nradiance = [1.0, 2.0, 3.0]\n"
        )
        .unwrap();
    }
    fs::write(folder.join("lights.toml"), scene).unwrap();
    let stats = alike(folder, &["lights.toml", "--size", "24x16"]);
    assert_eq!(stats[0]["lights"], 64);
    // A CPU does not query the faintest of many lights.
    let [cpu, gpu] = stats.map(|stats| {
        let counts = ["lit_points", "dark_points", "penumbra_points"];
        counts.map(|key| stats["counts"][key].as_u64().unwrap()).iter().sum::<u64>()
    });
    assert!(cpu <= gpu && 100 * cpu > 98 * gpu, "{cpu} {gpu}");
}

/// A hundred thousand spheres over the floor, no more than 512 of which a list takes.
fn many_spheres() {
    let folder = folder();
    let folder = folder.path();
    let mut spheres = String::new();
    let mut seed = 1_u64;
    for _ in 0..100_000 {
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f64 / (1_u64 << 24) as f64
        };
        let (x, y, z) = (6.0 * next() - 3.0, 0.05 + 2.0 * next(), 6.0 * next() - 3.0);
        write!(spheres, "[{x:.4}, {y:.4}, {z:.4}, 0.004],").unwrap();
    }
    let sphere = "sphere = { center = [0.0, 1.0, 0.0], radius = 0.6 }";
    let scene = SCENE.replace(sphere, &format!("spheres = [{spheres}]"));
    fs::write(folder.join("dust.toml"), scene).unwrap();
    let stats = same(folder, &["dust.toml", "--size", "24x16"]);
    assert_eq!(stats["spheres"], 100_000);
}

/// The camera looks away.
fn nothing_is_seen() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("away.toml"), SCENE.replace("target = [0.0, 0.6, 0.0]", "target = [0.0, 9.0, 9.0]")).unwrap();
    for device in ["cpu", "gpu"] {
        let stats =
            json(folder, &["render", "away.toml", "--device", device, "--json", "-q", "-o", &format!("{device}.png")]);
        assert_eq!(stats["points"], 0, "{stats}");
    }
    assert_eq!(fs::read(folder.join("cpu.png")).unwrap(), fs::read(folder.join("gpu.png")).unwrap());
}

/// As by the CPU: one line, code 2, no file.
fn what_is_wrong_is_refused() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("nan.toml"), SCENE.replace("radius = 0.6\nradiance", "radius = nan\nradiance")).unwrap();
    refuse(folder, &["render", "nan.toml", "-o", "a.png", "--device", "gpu"], "nan.toml:");
    refuse(folder, &["render", "scene.toml", "-o", "no/a.png", "--device", "gpu"], "no/a.png");
    refuse(folder, &["render", "scene.toml", "-o", "a.jpg", "--device", "gpu"], ".png or .exr");
}
