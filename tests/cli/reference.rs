use super::*;
use std::process::Stdio;

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

    // Damaged checkpoints are reported and made anew: a flipped bit, a half, other contents.
    succeed(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "512", "--keep", "-q"]);
    let kept = fs::read(folder.join("ref.exr.checkpoint")).unwrap();
    let mut flipped = kept.clone();
    flipped[kept.len() / 2] ^= 1;
    for damaged in [&flipped[..], &kept[..kept.len() / 2], b"no checkpoint"] {
        fs::write(folder.join("ref.exr.checkpoint"), damaged).unwrap();
        let ran = lobes(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "1024"]);
        let told = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success() && told.contains("ref.exr.checkpoint") && told.contains("made anew"), "{told}");
        assert_eq!(told.lines().count(), 1, "{told}");
        assert_eq!(fs::read(folder.join("ref.exr")).unwrap(), fs::read(folder.join("whole.exr")).unwrap());
    }
}

/// A power cut: at most a few seconds of samples are lost, and the files of the dead process are removed.
#[cfg(unix)]
#[test]
fn a_killed_reference_keeps_its_work() {
    let folder = folder();
    let folder = folder.path();
    let mut child = Command::new(env!("CARGO_BIN_EXE_lobes"))
        .current_dir(folder)
        .args(["reference", "scene.toml", "-o", "ref.exr", "--spp", "16000000", "-q"])
        .spawn()
        .unwrap();
    let start = std::time::Instant::now();
    while !folder.join("ref.exr.checkpoint").exists() {
        assert!(child.try_wait().unwrap().is_none() && start.elapsed().as_secs() < 60);
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(names(folder).iter().any(|n| n.ends_with(".tmp")), "{:?}", names(folder));
    let ran = lobes(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "8"]);
    assert!(ran.status.success());
    assert!(String::from_utf8_lossy(&ran.stderr).contains("goes on from"), "{}", String::from_utf8_lossy(&ran.stderr));
    assert_eq!(names(folder), ["ref.exr", "scene.toml"]);
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
    // Its temporary file shows that it has begun; a little later it samples.
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
