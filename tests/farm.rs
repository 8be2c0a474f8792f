//! The scripts of `examples/farm`: pictures in parts and frames, over schedulers that people have. Ignored where these are not there.
#![allow(clippy::unwrap_used, reason = "in a test")]

use libtest_mimic::{Arguments, Failed, Trial};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const SIZE: [&str; 2] = ["--size", "96x64"];

fn lobes(folder: &Path, arguments: &[&str]) {
    let status = Command::new(env!("CARGO_BIN_EXE_lobes")).current_dir(folder).args(arguments).status().unwrap();
    assert!(status.success(), "lobes {arguments:?}");
}

fn script(folder: &Path, name: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(format!("{}/../examples/farm/{name}", env!("CARGO_MANIFEST_DIR")));
    command.current_dir(folder).args(arguments).env("LOBES", env!("CARGO_BIN_EXE_lobes"));
    command
}

fn scene(name: &str) -> String {
    format!("{}/../scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The picture of one run, to the bit.
fn whole(folder: &Path) -> Vec<u8> {
    lobes(folder, &["render", &scene("soft_spheres"), SIZE[0], SIZE[1], "--quiet", "-o", "whole.exr"]);
    fs::read(folder.join("whole.exr")).unwrap()
}

fn tiles() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let (folder, scene) = (folder.path(), scene("soft_spheres"));
    let run = || script(folder, "tiles.sh", &[&scene, "a.exr", "4", SIZE[0], SIZE[1]]);
    // Stopped after the first part, and begun again.
    let mut first = run().stderr(Stdio::null()).spawn()?;
    let start = Instant::now();
    let part = || (1..=4).any(|part| folder.join(format!("a.exr.parts/{part}.exr")).exists());
    while !part() && first.try_wait()?.is_none() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    first.kill()?;
    first.wait()?;
    assert!(run().status()?.success());
    assert!(fs::read(folder.join("a.exr"))? == whole(folder), "the bytes of one run");
    assert!(!folder.join("a.exr.parts").exists(), "nothing is left behind");
    Ok(())
}

fn frames() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let (folder, scene) = (folder.path(), scene("walk"));
    assert!(script(folder, "frames.sh", &[&scene, "w.exr", "1", "4", "--size", "48x32"]).status()?.success());
    lobes(folder, &["render", &scene, "--size", "48x32", "--quiet", "--frames", "1..4", "-o", "one.exr"]);
    for frame in 1..4 {
        let [many, one] = ["w", "one"].map(|name| fs::read(folder.join(format!("{name}.000{frame}.exr"))));
        assert!(many? == one?, "frame {frame}");
    }
    Ok(())
}

fn slurm() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let (folder, scene) = (folder.path(), scene("soft_spheres"));
    assert!(script(folder, "slurm.sh", &[&scene, "a.exr", "4", SIZE[0], SIZE[1]]).status()?.success());
    let start = Instant::now();
    while folder.join("a.exr.parts").exists() && start.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(200));
    }
    assert!(fs::read(folder.join("a.exr"))? == whole(folder), "the bytes of one run");
    Ok(())
}

fn runs(program: &str, arguments: &[&str]) -> bool {
    let command = || Command::new(program).args(arguments).stdin(Stdio::null()).output().ok();
    cfg!(unix) && command().is_some_and(|output| output.status.success())
}

fn main() {
    // Another program has this name as well.
    let has_parallel = runs("parallel", &["--version"]) && runs("parallel", &["--help"]);
    let has_slurm = runs("sinfo", &["--noheader"]);
    let trials = vec![
        Trial::test("tiles_by_gnu_parallel", tiles).with_ignored_flag(!has_parallel),
        Trial::test("frames_by_gnu_parallel", frames).with_ignored_flag(!has_parallel),
        Trial::test("tiles_by_slurm", slurm).with_ignored_flag(!has_slurm),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit();
}
