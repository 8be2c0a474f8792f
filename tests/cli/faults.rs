//! Faults during a command: it is killed, the disk is full, another command writes to the same place.
#![cfg(unix)]

use super::*;
use std::process::{Child, Stdio};
use std::thread::sleep;
use std::time::Instant;

fn start(folder: &Path, args: &[&str]) -> Child {
    let cache = folder.with_extension("cache");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
    command.current_dir(folder).args(args).env("XDG_CACHE_HOME", cache).stdout(Stdio::null()).spawn().unwrap()
}

/// The contents of a folder's files.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    names(folder).into_iter().map(|name| (name.clone(), fs::read(folder.join(name)).unwrap())).collect()
}

/// A folder with two scenes, two parts of a picture, and a mesh.
fn prepared() -> Folder {
    let folder = folder();
    let path = folder.path();
    fs::write(path.join("rolling.toml"), rolling()).unwrap();
    for (name, tiles) in [("part1.exr", "1/2"), ("part2.exr", "2/2")] {
        succeed(path, &["render", "scene.toml", "--size", "64x64", "-q", "--tiles", tiles, "-o", name]);
    }
    let mut mesh = String::new();
    for k in 0..60 {
        let (a, b) = ((k as f32 * 0.7).sin(), (k as f32 * 1.3).cos());
        mesh += &format!("v {a} {b} {}\nv {} {b} {a}\nv {b} {} {a}\n", a * b, a + 0.3, a + 0.2);
        mesh += &format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3);
    }
    fs::write(path.join("mesh.obj"), mesh).unwrap();
    folder
}

/// Every command that writes files.
const COMMANDS: [&[&str]; 7] = [
    &["render", "scene.toml", "--size", "320x240", "--layers", "-q", "-o", "a.exr", "-o", "a.png"],
    &["render", "rolling.toml", "--size", "160x96", "--frames", "0..8", "-q", "-o", "f.png", "-o", "f.exr"],
    &["merge", "part1.exr", "part2.exr", "-o", "m.exr", "-o", "m.png", "-q"],
    &["compare", "part1.exr", "part1.exr", "--diff", "d.png", "--heatmap", "h.png"],
    &["reference", "scene.toml", "--spp", "4096", "-o", "r.exr", "-q"],
    &["spheres", "mesh.obj", "--count", "6", "-o", "set.json", "-q"],
    &["figures", "2", "-o", ".", "-q"],
];

/// A command that is killed leaves whole files or none, and the next run makes the same files.
#[test]
fn killed_commands_leave_whole_files() {
    for args in COMMANDS {
        let whole = prepared();
        let begin = Instant::now();
        succeed(whole.path(), args);
        let (time, want) = (begin.elapsed(), contents(whole.path()));
        for tenth in [1, 5, 9] {
            let folder = prepared();
            let mut child = start(folder.path(), args);
            sleep(time * tenth / 10);
            // It may be done already.
            let _ = child.kill();
            child.wait().unwrap();
            for (name, bytes) in contents(folder.path()) {
                let expected = want.iter().find(|(n, _)| *n == name);
                let unfinished = name.ends_with(".tmp") || name.ends_with(".checkpoint");
                assert!(unfinished || expected.is_some_and(|(_, w)| *w == bytes), "{args:?} after {tenth}/10: {name}");
            }
            succeed(folder.path(), args);
            assert!(contents(folder.path()) == want, "{args:?} after {tenth}/10: {:?}", names(folder.path()));
        }
    }
}

/// Runs a command that cannot write to any file: the program survives the signal for files that are too large, so that writing fails.
fn on_a_full_disk(folder: &Path, args: &[&str]) -> std::process::Output {
    let line = format!("ulimit -f 0; exec {} {}", env!("CARGO_BIN_EXE_lobes"), args.join(" "));
    let cache = folder.with_extension("cache");
    Command::new("sh").current_dir(folder).args(["-c", &line]).env("XDG_CACHE_HOME", cache).output().unwrap()
}

/// A full disk gives one line and a code; old files stay, and nothing half written does.
#[test]
fn full_disks_are_told_and_old_files_stay() {
    for args in COMMANDS {
        let folder = prepared();
        let folder = folder.path();
        succeed(folder, args);
        let old = contents(folder);
        // Something else was there: it must survive.
        let inputs = ["scene.toml", "rolling.toml", "part1.exr", "part2.exr", "mesh.obj"];
        let outputs: Vec<&String> = old.iter().map(|(n, _)| n).filter(|n| !inputs.contains(&n.as_str())).collect();
        for name in &outputs {
            fs::write(folder.join(name), b"old").unwrap();
        }
        let before = contents(folder);
        let ran = on_a_full_disk(folder, args);
        let stderr = String::from_utf8(ran.stderr).unwrap();
        assert_eq!(ran.status.code(), Some(2), "{args:?}: {stderr}");
        let last = stderr.lines().last().unwrap_or_default();
        assert!(last.starts_with("lobes: error: "), "{args:?}: {stderr}");
        assert!(contents(folder) == before, "{args:?}: {:?}", names(folder));
        // And with room again it works.
        for name in &outputs {
            fs::remove_file(folder.join(name)).unwrap();
        }
        succeed(folder, args);
        assert!(contents(folder) == old, "{args:?}");
    }
}

/// Two commands that write the same files: the last one to finish has written whole ones.
#[test]
fn two_writers_at_one_place_leave_one_whole_file() {
    for args in COMMANDS {
        let folder = prepared();
        let folder = folder.path();
        let alone = prepared();
        succeed(alone.path(), args);
        for _ in 0..2 {
            let children: Vec<Child> = (0..3).map(|_| start(folder, args)).collect();
            for mut child in children {
                assert!(child.wait().unwrap().success(), "{args:?}");
            }
            assert!(contents(folder) == contents(alone.path()), "{args:?}: {:?}", names(folder));
        }
    }
}

/// A sweep on a full disk is one line and leaves nothing; two at once in one folder leave the rows of both.
#[test]
fn sweeps_meet_full_disks_and_each_other() {
    let folder = prepared();
    let folder = folder.path();
    let sweep: &[&str] = &[
        "trade",
        "scene.toml",
        "-o",
        "out",
        "--size",
        "24x16",
        "--visibility",
        "spheres",
        "--method",
        "moments",
        "--tolerance",
        "0.01",
        "--depth",
        "3",
        "--spp",
        "4",
        "--reference-spp",
        "16",
        "--repeat",
        "3",
        "-q",
    ];
    let ran = on_a_full_disk(folder, sweep);
    let stderr = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(2), "{stderr}");
    assert!(stderr.lines().last().unwrap_or_default().starts_with("lobes: error: "), "{stderr}");
    assert_eq!(contents(&folder.join("out")), [], "{stderr}");
    let children: Vec<Child> = (0..2).map(|_| start(folder, sweep)).collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    let rows: Value = serde_json::from_slice(&fs::read(folder.join("out/trade.json")).unwrap()).unwrap();
    assert_eq!(rows.as_array().map(Vec::len), Some(3));
    let left: Vec<String> = names(&folder.join("out")).into_iter().filter(|name| name.ends_with(".tmp")).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// Pictures with flipped bits are read or refused in one line.
#[test]
fn flipped_bits_of_pictures_are_read_or_refused() {
    let folder = prepared();
    let folder = folder.path();
    let whole = fs::read(folder.join("part1.exr")).unwrap();
    for k in 0..60_usize {
        let mut bytes = whole.clone();
        // More of them in the header, which says how large everything is.
        let at = if k % 2 == 0 { k * 7 % 400 } else { k * 7919 % bytes.len() };
        bytes[at] ^= 1 << (k % 8);
        fs::write(folder.join("bad.exr"), bytes).unwrap();
        for args in [&["compare", "bad.exr", "part1.exr"][..], &["merge", "bad.exr", "part2.exr", "-o", "m.exr"]] {
            let ran = lobes(folder, args);
            let stderr = String::from_utf8(ran.stderr).unwrap();
            assert!(matches!(ran.status.code(), Some(0 | 2)), "{args:?}, bit {k}: {stderr}");
            assert!(stderr.lines().count() <= 1, "{args:?}, bit {k}: {stderr}");
        }
    }
}

/// Threads, tiles and reruns change no bit, with any strategy and with layers.
#[test]
fn threads_and_tiles_change_no_bit() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), format!("{SCENE}{TABLE}")).unwrap();
    for strategy in ["silhouettes", "spheres", "shadow-map", "rays"] {
        let render = |output: &str, more: &[&str]| {
            let base = ["render", "table.toml", "--visibility", strategy, "--layers", "-q", "-o", output];
            succeed(folder, &[&base[..], more].concat());
            fs::read(folder.join(output)).unwrap()
        };
        let whole = render("a.exr", &[]);
        for threads in ["1", "2", "3", "5", "8", "16"] {
            assert!(render("b.exr", &["--threads", threads]) == whole, "{strategy}: {threads} threads");
        }
        for part in 1..=4 {
            render(&format!("{part}.exr"), &["--tiles", &format!("{part}/4"), "--threads", &part.to_string()]);
        }
        succeed(folder, &["merge", "1.exr", "2.exr", "3.exr", "4.exr", "-o", "m.exr", "-q"]);
        assert!(fs::read(folder.join("m.exr")).unwrap() == whole, "{strategy}: tiles");
    }
}

/// The same with visibility as lobes.
#[test]
fn threads_and_tiles_change_no_bit_of_lobes() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), format!("{SCENE}{TABLE}")).unwrap();
    for strategy in ["silhouettes", "spheres", "shadow-map", "rays"] {
        let render = |output: &str, more: &[&str]| {
            let base =
                ["render", "table.toml", "--visibility", strategy, "--method", "lobes", "--layers", "-q", "-o", output];
            succeed(folder, &[&base[..], more].concat());
            fs::read(folder.join(output)).unwrap()
        };
        let whole = render("a.exr", &["--threads", "16"]);
        assert!(render("b.exr", &["--threads", "1"]) == whole, "{strategy}");
        for part in ["1", "2", "3"] {
            render(&format!("{part}.exr"), &["--tiles", &format!("{part}/3"), "--threads", part]);
        }
        succeed(folder, &["merge", "1.exr", "2.exr", "3.exr", "-o", "m.exr", "-q"]);
        assert!(fs::read(folder.join("m.exr")).unwrap() == whole, "{strategy}: tiles");
    }
}

/// The same by the paper's method, whose tables take seconds.
#[test]
fn threads_and_tiles_change_no_bit_by_the_paper() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), format!("{SCENE}{TABLE}")).unwrap();
    // Strategies with a common code path in this method are tested once: one that draws, and one that traces.
    for strategy in ["silhouettes", "rays"] {
        let render = |output: &str, more: &[&str]| {
            let base =
                ["render", "table.toml", "--visibility", strategy, "--method", "paper", "--layers", "-q", "-o", output];
            succeed(folder, &[&base[..], more].concat());
            fs::read(folder.join(output)).unwrap()
        };
        let whole = render("a.exr", &["--threads", "16"]);
        for part in ["1", "2"] {
            render(&format!("{part}.exr"), &["--tiles", &format!("{part}/2"), "--threads", part]);
        }
        succeed(folder, &["merge", "1.exr", "2.exr", "-o", "m.exr", "-q"]);
        assert!(fs::read(folder.join("m.exr")).unwrap() == whole, "{strategy}");
    }
}

/// A link stays one, and what it names is replaced; what is no file is refused before the work.
#[test]
fn links_are_followed_and_pipes_refused() {
    let folder = folder();
    let path = folder.path();
    std::os::unix::fs::symlink("real.png", path.join("link.png")).unwrap();
    succeed(path, &["render", "scene.toml", "-q", "-o", "link.png"]);
    assert!(fs::symlink_metadata(path.join("link.png")).unwrap().is_symlink());
    assert!(fs::read(path.join("real.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(Command::new("mkfifo").arg(path.join("pipe.png")).status().unwrap().success());
    let ran = lobes(path, &["render", "scene.toml", "-o", "pipe.png"]);
    let said = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.code() == Some(2) && said.contains("pipe.png: is a pipe"), "{said}");
}
