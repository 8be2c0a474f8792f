//! Sequences, parts and files.

use crate::support::*;
use cosine_lobes::read_exr;
use serde_json::Value;
use std::fs;

crate::tests![
    two_runs_give_the_same_files,
    a_sequence_is_the_pictures_of_its_moments,
    parts_make_the_whole_to_the_bit,
    a_time_budget_is_kept,
    auto_says_what_it_takes,
    drivers_say_nothing,
    kernels_are_in_the_figures,
    an_interrupt_leaves_no_file,
];

fn two_runs_give_the_same_files() {
    let folder = folder();
    let folder = folder.path();
    for name in ["a", "b"] {
        let [png, exr] = ["png", "exr"].map(|ending| format!("{name}.{ending}"));
        succeed(folder, &["render", "--size", "64x36", "--device", "gpu", "-q", "-o", &png, "-o", &exr]);
    }
    for ending in ["png", "exr"] {
        let [a, b] = ["a", "b"].map(|name| fs::read(folder.join(format!("{name}.{ending}"))).unwrap());
        assert!(a == b, "{ending}");
    }
}

/// Each frame equals the picture of its moment alone, and the CPU's within the difference of devices; frames of another
/// device are made anew.
fn a_sequence_is_the_pictures_of_its_moments() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("roll.toml"), rolling().replace("spheres = 8", "spheres = 1")).unwrap();
    let base = ["render", "roll.toml", "-o", "r.exr", "--frames", "2..5", "--visibility", "shadow-map", "--json", "-q"];
    let made = |device: &str| {
        let stats = json(folder, &[&base[..], &["--device", device]].concat());
        [&stats["frames"], &stats["skipped_frames"]].map(|n| n.as_u64().unwrap())
    };
    assert_eq!(made("cpu"), [3, 0]);
    let read = |name: &str| read_exr(&folder.join(name)).unwrap();
    let cpu = read("r.0004.exr");
    assert_eq!((made("gpu"), made("gpu")), ([3, 0], [0, 3]));
    let gpu = read("r.0004.exr");
    let one = ["render", "roll.toml", "-o", "one.exr", "--frame", "4", "--visibility", "shadow-map", "-q"];
    succeed(folder, &[&one[..], &["--device", "gpu"]].concat());
    assert_eq!(read("one.exr"), gpu);
    assert_ne!(read("r.0002.exr"), gpu);
    let peak = cpu.pixels().iter().map(|p| p.max_element()).fold(0.0, f32::max);
    let apart = |(a, b): (&glam::Vec3, &glam::Vec3)| (*a - *b).abs().max_element() / peak;
    let largest = cpu.pixels().iter().zip(gpu.pixels()).map(apart).fold(0.0, f32::max);
    assert!(largest <= 1e-3, "{largest}");
    assert_eq!(made("cpu"), [3, 0]);
}

fn parts_make_the_whole_to_the_bit() {
    let folder = folder();
    let folder = folder.path();
    let render = |output: &str, further: &[&str]| {
        succeed(folder, &[&["render", "--size", "48x32", "--device", "gpu", "-q", "-o", output], further].concat());
    };
    render("whole.exr", &[]);
    for part in ["1/3", "2/3", "3/3"] {
        render(&format!("tile{}.exr", &part[..1]), &["--tiles", part]);
    }
    succeed(folder, &["merge", "tile2.exr", "tile1.exr", "tile3.exr", "-o", "tiles.exr", "-q"]);
    for (name, crop) in [("a.exr", "0,0,19,32"), ("b.exr", "19,0,48,5"), ("c.exr", "19,5,48,32")] {
        render(name, &["--crop", crop]);
    }
    succeed(folder, &["merge", "a.exr", "b.exr", "c.exr", "-o", "windows.exr", "-q"]);
    let [whole, tiles, windows] = ["whole.exr", "tiles.exr", "windows.exr"].map(|n| fs::read(folder.join(n)).unwrap());
    assert!(tiles == whole, "tiles");
    assert!(windows == whole, "windows");
}

/// The GPU is measured: without a limit of time the best setting is used.
fn a_time_budget_is_kept() {
    let folder = folder();
    let args = ["render", "scene.toml", "--device", "gpu", "--json", "--time-budget"];
    let depth = |budget: &str| json(folder.path(), &[&args[..], &[budget]].concat())["depth"].as_u64().unwrap();
    assert_eq!((depth("1e6"), depth("1e-6")), (6, 2));
}

/// One line: the GPU where it is hardware, else the CPU, and why.
fn auto_says_what_it_takes() {
    let folder = folder();
    let folder = folder.path();
    let ran = |options: &[&str]| {
        let ran = lobes(folder, &[&["render", "scene.toml", "--device", "auto", "--json"], options].concat());
        assert!(ran.status.success());
        let stats: Value = serde_json::from_slice(&ran.stdout).unwrap();
        (String::from_utf8(ran.stderr).unwrap(), stats["device"].as_str().unwrap().to_owned())
    };
    let (told, device) = ran(&[]);
    assert!(told.lines().count() == 1 && told.contains(&format!("--device auto: {device}")), "{told} {device}");
    assert_eq!(ran(&["-q"]), (String::new(), device));
    // Features that only the CPU has run there.
    let (told, device) = ran(&["--layers", "-o", "a.exr"]);
    assert!(device == "cpu" && told.contains("--device auto: cpu, since layers"), "{told}");
}

/// Without the folder of display servers' sockets, and without the variables of drivers.
fn bare(folder: &std::path::Path, args: &[&str]) -> std::process::Command {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_lobes"));
    for name in ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "LP_NATIVE_VECTOR_WIDTH"] {
        command.env_remove(name);
    }
    // The tests' own kernels may be for vectors of another width.
    command.env("MESA_SHADER_CACHE_DIR", concat!(env!("CARGO_TARGET_TMPDIR"), "/kernels"));
    command.current_dir(folder).args(args);
    command
}

/// Nothing on stderr, with any variable missing; output and exit code are the program's own.
fn drivers_say_nothing() {
    let folder = folder();
    let folder = folder.path();
    let ran = |args: &[&str]| {
        let ran = bare(folder, args).output().unwrap();
        let [told, out] = [ran.stderr, ran.stdout].map(|bytes| String::from_utf8(bytes).unwrap());
        (ran.status.code(), told, out)
    };
    let options = ["render", "scene.toml", "--quality", "draft", "--json", "-o", "name with spaces.png", "--device"];
    for device in ["gpu", "auto"] {
        let (code, told, out) = ran(&[&options[..], &[device, "-q"]].concat());
        assert_eq!((code, told.as_str()), (Some(0), ""), "{device}");
        assert!(serde_json::from_str::<Value>(&out).unwrap()["points"].as_u64() > Some(0), "{device}: {out}");
    }
    assert_eq!(names(folder), ["name with spaces.png", "scene.toml"]);
    let (code, told, out) = ran(&["render", "nowhere.toml", "--device", "gpu"]);
    assert_eq!((code, out.as_str(), told.lines().count()), (Some(2), "", 1), "{told}");
    assert!(told.starts_with("lobes: error: ") && told.contains("nowhere.toml"), "{told}");
}

/// Each with its time, the slowest first; of the CPU none.
fn kernels_are_in_the_figures() {
    let folder = folder();
    let kernels = |device: &str| {
        let args = ["render", "scene.toml", "--quality", "draft", "--json", "-q", "--device", device];
        json(folder.path(), &args)["kernels"].as_array().unwrap().clone()
    };
    assert!(kernels("cpu").is_empty());
    let kernels = kernels("gpu");
    for name in ["cull", "classify (spheres, ", "penumbra (spheres, "] {
        assert!(kernels.iter().any(|kernel| kernel["name"].as_str().unwrap().starts_with(name)), "{name}: {kernels:?}");
    }
    let seconds: Vec<f64> = kernels.iter().map(|kernel| kernel["seconds"].as_f64().unwrap()).collect();
    assert!(seconds.is_sorted_by(|a, b| a >= b) && seconds.iter().all(|s| *s > 0.0), "{seconds:?}");
}

#[cfg(unix)]
fn an_interrupt_leaves_no_file() {
    use std::process::{Command, Stdio};
    let folder = folder();
    let folder = folder.path();
    let args = ["render", "-o", "a.exr", "--size", "640x360", "--repeat", "10000", "--device", "gpu"];
    // Started anew where something is missing: the same process all the same.
    let mut child = bare(folder, &args).stderr(Stdio::piped()).spawn().unwrap();
    // Into shading: outputs are opened before.
    while names(folder).len() == 1 {
        assert!(child.try_wait().unwrap().is_none(), "ended early");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130));
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "lobes: interrupted; nothing half-written\n");
    assert_eq!(names(folder), ["scene.toml"]);
}

#[cfg(not(unix))]
fn an_interrupt_leaves_no_file() {}
