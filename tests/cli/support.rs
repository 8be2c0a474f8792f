//! Helpers for tests of the command.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output as Ran};
use tempfile::TempDir;

/// A sphere over a floor, one light; small enough for a test.
pub(crate) const SCENE: &str = r#"
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

pub(crate) fn lobes(folder: &Path, args: &[&str]) -> Ran {
    let cache = folder.with_extension("cache");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
    command.current_dir(folder).args(args).env("XDG_CACHE_HOME", cache).output().unwrap()
}

pub(crate) fn succeed(folder: &Path, args: &[&str]) -> String {
    let ran = lobes(folder, args);
    assert!(ran.status.success(), "{args:?}: {}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).unwrap()
}

pub(crate) fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&succeed(folder, args)).unwrap()
}

/// A folder to work in, and beside it `work.cache`, where programs keep things; both gone when dropped.
pub(crate) struct Folder {
    _all: TempDir,
    work: PathBuf,
}

impl Folder {
    pub(crate) fn path(&self) -> &Path {
        &self.work
    }
}

/// A folder with `scene.toml`.
pub(crate) fn folder() -> Folder {
    let all = tempfile::tempdir().unwrap();
    let work = all.path().join("work");
    fs::create_dir(&work).unwrap();
    fs::write(work.join("scene.toml"), SCENE).unwrap();
    Folder { _all: all, work }
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    let name = |e: Result<fs::DirEntry, _>| e.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<String> = fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

/// Exit code 2, one line on stderr that contains `what`, nothing on stdout, no new file, no panic.
pub(crate) fn refuse(folder: &Path, args: &[&str], what: &str) {
    let before = names(folder);
    let ran = lobes(folder, args);
    let stderr = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(2), "{args:?}: {stderr}");
    assert_eq!(stderr.lines().count(), 1, "{args:?}: {stderr}");
    assert!(stderr.starts_with("lobes: error: ") && stderr.contains(what), "{args:?}: {stderr}");
    assert!(ran.stdout.is_empty(), "{args:?}");
    assert_eq!(names(folder), before, "{args:?}");
}

/// A table's top over the floor, as triangles.
pub(crate) const TABLE: &str = r#"
[[objects]]
name = "table"
box = { center = [-1.5, 0.9, 0.5], size = [1.2, 0.1, 0.8] }
proxy = { spheres = 8 }
"#;

/// The sphere of [`SCENE`] rolls for one second, the light goes with it: 11 frames at 10 a second.
pub(crate) fn rolling() -> String {
    let moved = "\nkeys = [{ time = 0 }, { time = 1, translate = [1, 0, 0] }]";
    let (sphere, light) = ("radius = 0.6 }", "radiance = [20.0, 20.0, 20.0]");
    let scene = SCENE.replace(sphere, &format!("{sphere}{moved}")).replace(light, &format!("{light}{moved}"));
    format!("[animation]\nfps = 10\n{scene}{TABLE}")
}
