//! Changes of a scene that must not change its picture, by every strategy, method and device.
//!
//! `cargo test --release --test metamorphic -- --ignored report` prints all of them as a table.
#![allow(clippy::unwrap_used, reason = "in a test")]

mod scene;
#[path = "../cli/support.rs"]
#[allow(dead_code, reason = "shared with the command's tests")]
mod support;

use cosine_lobes::read_exr;
use cosine_lobes::render_gpu::{Gpu, GpuOptions};
use libtest_mimic::{Arguments, Failed, Trial};
use scene::{CHANGES, Change};
use std::fs;
use std::path::Path;
use support::{folder, succeed};

const STRATEGIES: [&str; 4] = ["silhouettes", "spheres", "shadow-map", "rays"];
const METHODS: [&str; 2] = ["moments", "paper"];
const DEVICES: [&str; 2] = ["cpu", "gpu"];

/// A way to make the picture.
#[derive(Clone, Copy)]
struct Way {
    strategy: &'static str,
    method: &'static str,
    device: &'static str,
}

/// Difference of two pictures, as fractions of the brightest value.
#[derive(Clone, Copy, Debug)]
struct Apart {
    mean: f64,
    largest: f32,
}

fn picture(folder: &Path, change: &Change, way: Way) -> Vec<glam::Vec3> {
    fs::write(folder.join("scene.toml"), change.scene(folder)).unwrap();
    let Way { strategy, method, device } = way;
    let options = ["--visibility", strategy, "--method", method, "--device", device, "-q", "-o", "out.exr"];
    succeed(folder, &[&["render", "scene.toml", "--samples", "1"], &options[..]].concat());
    let picture = read_exr(&folder.join("out.exr")).unwrap();
    let rows = picture.pixels().chunks_exact(picture.width());
    rows.flat_map(|row| if change.mirrored { row.iter().rev().copied().collect() } else { row.to_vec() }).collect()
}

fn apart(a: &[glam::Vec3], b: &[glam::Vec3]) -> Apart {
    let peak = a.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    assert!(peak > 0.0, "a black picture");
    let each: Vec<f32> = a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    Apart {
        mean: each.iter().map(|d| f64::from(*d)).sum::<f64>() / each.len() as f64,
        largest: each.iter().copied().fold(0.0, f32::max),
    }
}

/// The differences that changes make.
fn differences(folder: &Path, changes: &[Change], way: Way) -> Vec<(&'static str, Apart)> {
    let whole = picture(folder, &CHANGES[0], way);
    changes.iter().map(|change| (change.name, apart(&whole, &picture(folder, change, way)))).collect()
}

/// The allowed difference of a change. Texels of shadow maps lie elsewhere after a turn. Self-shadow distances of spheres are measured
/// from points on triangles, whose order counts: single pixels at contacts.
fn check(folder: &Path, changes: &[Change], way: Way) -> Result<(), Failed> {
    let Way { strategy, method, device } = way;
    for (name, found) in differences(folder, changes, way) {
        println!("{strategy} {method} {device}, {name}: mean {:.1e}, largest {:.1e}", found.mean, found.largest);
        let (mean, largest) = match (strategy, method) {
            ("shadow-map", _) => (3e-4, 0.03),
            ("spheres", _) => (2e-4, 0.05),
            (_, "paper") => (2e-4, 0.01),
            _ => (3e-5, 2e-3),
        };
        if !(found.mean < mean && found.largest < largest) {
            return Err(format!("{strategy} {method} {device}, {name}: {found:?}").into());
        }
    }
    Ok(())
}

/// Every change by every way, as a table.
fn report(devices: &[&'static str]) {
    println!("| change | strategy | method | device | mean | largest |\n|---|---|---|---|---|---|");
    for &device in devices {
        for method in METHODS {
            for strategy in STRATEGIES {
                for (name, apart) in differences(folder().path(), &CHANGES[1..], Way { strategy, method, device }) {
                    println!(
                        "| {name} | {strategy} | {method} | {device} | {:.1e} | {:.1e} |",
                        apart.mean, apart.largest
                    );
                }
            }
        }
    }
}

fn main() {
    let arguments = Arguments::from_args();
    let there = Gpu::blocking(&GpuOptions::default()).is_ok();
    let mut trials = Vec::new();
    for device in DEVICES {
        let ignored = device == "gpu" && !there;
        // A GPU's kernels take seconds: all changes run at once.
        let changes = if device == "cpu" { &CHANGES[1..] } else { &CHANGES[15..] };
        for strategy in STRATEGIES {
            let way = Way { strategy, method: "moments", device };
            let test = move || check(folder().path(), changes, way);
            trials.push(Trial::test(format!("{strategy}_moments_{device}"), test).with_ignored_flag(ignored));
        }
    }
    // The paper's tables take seconds too, and are kept in the folder: all changes at once, and the one that cannot be combined. With a GPU's kernels they
    // take minutes: the report has both.
    trials.push(Trial::test("paper_cpu", || {
        let folder = folder();
        let ways = STRATEGIES.map(|strategy| Way { strategy, method: "paper", device: "cpu" });
        ways.into_iter().try_for_each(|way| check(folder.path(), &CHANGES[14..], way))
    }));
    let devices = if there { &DEVICES[..] } else { &DEVICES[..1] };
    let table = move || {
        report(devices);
        Ok(())
    };
    trials.push(Trial::test("report", table).with_ignored_flag(true));
    libtest_mimic::run(&arguments, trials).exit();
}
