use super::*;
use cosine_lobes::read_exr;
use std::process::Stdio;

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
    for key in ["pose", "spheres", "hierarchy", "silhouettes", "maps"] {
        assert!(stats["update"][key].is_number(), "{key} in {stats}");
    }

    // A frame of a sequence equals the frame alone and the moment alone, after any other frames, by any strategy.
    let same = |a: &str, b: &str| {
        assert_eq!(read_exr(&folder.join(a)).unwrap(), read_exr(&folder.join(b)).unwrap(), "{a}");
    };
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

/// Only a frame that the very command would make counts as made.
#[test]
fn a_sequence_keeps_only_what_it_would_make() {
    let folder = folder();
    let folder = folder.path();
    let scene = rolling().replace("proxy = { spheres = 8 }", "proxy = { file = \"set.json\" }");
    let set = |count: &str| {
        succeed(folder, &["spheres", "box.obj", "--count", count, "--draft", "-o", "set.json", "-q"]);
    };
    // The table's top as a mesh, for a set that fits it.
    let corners = [(-0.6, -0.05, -0.4), (0.6, 0.05, 0.4)];
    let mut mesh = String::new();
    for k in 0..8 {
        let pick = |bit: usize, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
        let [(x0, y0, z0), (x1, y1, z1)] = corners;
        let (x, y, z) = (pick(0, x0, x1) - 1.5, pick(1, y0, y1) + 0.9, pick(2, z0, z1) + 0.5);
        mesh += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
        mesh += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    fs::write(folder.join("box.obj"), mesh).unwrap();
    set("4");
    fs::write(folder.join("roll.toml"), &scene).unwrap();
    let command = ["render", "roll.toml", "-o", "r.png", "-o", "r.exr", "--frames", "0..3", "--json"];
    let made = |options: &[&str]| {
        let stats = json(folder, &[&command[..], options].concat());
        assert_eq!(stats["frames"].as_u64().unwrap() + stats["skipped_frames"].as_u64().unwrap(), 3, "{stats}");
        stats["frames"].as_u64().unwrap()
    };
    assert_eq!(made(&[]), 3);
    assert_eq!(made(&["--threads", "1", "-q"]), 0, "what decides nothing");
    fs::write(folder.join("r.0001.png"), "").unwrap();
    assert_eq!(made(&[]), 1, "an empty file");
    fs::copy(folder.join("r.0000.exr"), folder.join("r.0002.exr")).unwrap();
    assert_eq!(made(&[]), 1, "another moment");
    assert_eq!(made(&["--fps", "5"]), 2, "frame 0 is the same moment at any rate");
    assert_eq!(made(&[]), 2);
    for options in
        [&["--tolerance", "0.01"][..], &["--exposure", "1"], &["--size", "32x32"], &["--visibility", "rays"], &[]]
    {
        assert_eq!(made(options), 3, "{options:?}");
        assert_eq!(made(options), 0, "{options:?}");
    }
    fs::write(folder.join("roll.toml"), scene.replace("radius = 0.6 }", "radius = 0.5 }")).unwrap();
    assert_eq!(made(&[]), 3, "another sphere");
    fs::write(folder.join("roll.toml"), scene.replace("translate = [1, 0, 0]", "translate = [2, 0, 0]")).unwrap();
    assert_eq!(made(&[]), 3, "another motion");
    fs::write(folder.join("roll.toml"), format!("# The same scene.\n{scene}")).unwrap();
    assert_eq!(made(&[]), 3);
    assert_eq!(made(&[]), 0);
    fs::write(folder.join("roll.toml"), &scene).unwrap();
    assert_eq!(made(&[]), 0, "a comment changes nothing");
    set("5");
    assert_eq!(made(&[]), 3, "another sphere set");
}

/// A scene in which nothing moves has one frame, its picture.
#[test]
fn frame_0_of_a_still_scene_is_its_picture() {
    let folder = folder();
    let folder = folder.path();
    let picture = |options: &[&str], name: &str| {
        succeed(folder, &[&["render", "scene.toml", "-o", "a.exr", "-q"], options].concat());
        read_exr(&folder.join(name)).unwrap()
    };
    let still = picture(&[], "a.exr");
    assert_eq!(picture(&["--frame", "0"], "a.exr"), still);
    assert_eq!(picture(&["--time", "0"], "a.exr"), still);
    assert_eq!(picture(&["--frames", "0..1"], "a.0000.exr"), still);
}

#[test]
fn frames_that_there_are_not_are_refused() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("roll.toml"), rolling()).unwrap();
    let frames = |scene: &str, text: &str, what: &str| {
        refuse(folder, &["render", scene, "-o", "r.png", "--frames", text], what);
    };
    let all = "frames 0 to 10 (1 s at 10 a second), all of them by --frames 0..11";
    for beyond in ["0..12", "11..12", "4000000000..4000000001"] {
        frames("roll.toml", beyond, &format!("--frames {beyond}: there are only {all}"));
    }
    frames("roll.toml", "5..2", "no frames from 5 to before 2");
    frames("roll.toml", "3..3", "no frames from 3 to before 3");
    for bad in ["", "3", "..", "1..", "..2", "-1..2", "a..b", "0..=3", "1.5..2", "0..5000000000"] {
        refuse(folder, &["render", "roll.toml", "-o", "r.png", "--frames", bad], "--frames");
    }
    frames("scene.toml", "0..2", "nothing moves");
    refuse(folder, &["render", "roll.toml", "--frame", "11"], &format!("--frame 11: there are only {all}"));
    refuse(folder, &["render", "roll.toml", "--frame", "-1"], "expected a whole number from 0");
    refuse(folder, &["render", "roll.toml", "--time", "1.01"], "ends at 1 s");
    refuse(folder, &["render", "roll.toml", "--time", "nan"], "--time");
    refuse(folder, &["render", "roll.toml", "--fps", "0", "--frame", "1"], "--fps");
    refuse(folder, &["render", "roll.toml", "--fps", "12"], "--fps");
    refuse(folder, &["render", "roll.toml", "--fps", "12", "--time", "0.5"], "--fps");
    refuse(folder, &["render", "roll.toml", "--time", "-1"], "expected a number of at least 0");
    refuse(folder, &["render", "roll.toml", "--frame", "1", "--frames", "0..2"], "--frame");
    refuse(folder, &["render", "scene.toml", "--time", "0.5"], "nothing moves");
    refuse(folder, &["render", "--frame", "1"], "nothing moves");
    refuse(folder, &["reference", "roll.toml", "--frame", "11"], "--frame 11");
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
    let ran = lobes(folder, &["render", "t.gltf", "-o", "r.png", "--frames", "0..2"]);
    let stderr = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.code() == Some(2) && stderr.contains("lobes: error: --frames 0..2: nothing moves"), "{stderr}");
    assert!(!folder.join("r.0000.png").exists());
    // A mesh whose skin has bones that do not exist.
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
    let fox = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/assets/fox.glb");
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

/// Ctrl-C between and within frames: whole files only, and the same command resumes.
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
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130));
    assert_eq!(String::from_utf8_lossy(&ended.stderr), "lobes: interrupted; nothing half-written\n");
    let left = names(folder);
    let whole: Vec<_> = left.iter().filter(|n| n.ends_with(".exr")).collect();
    assert_eq!(left.len(), whole.len() + 2, "{left:?}");
    assert!((1..11).contains(&whole.len()) && whole.iter().all(|n| read_exr(&folder.join(n)).is_ok()), "{left:?}");
}

/// Warnings may come first; the error is one line, and the last.
#[test]
fn an_error_is_the_last_line() {
    let folder = folder();
    let folder = folder.path();
    let bright = "[materials.m]\nmodel = \"lambert\"\nalbedo = 1.5\n\n[[lights]]";
    fs::write(folder.join("bright.toml"), SCENE.replace("[[lights]]", bright)).unwrap();
    let ran = lobes(folder, &["render", "bright.toml", "--frames", "0..1000"]);
    let stderr = String::from_utf8(ran.stderr).unwrap();
    let lines: Vec<&str> = stderr.lines().collect();
    assert!(ran.status.code() == Some(2) && lines.len() == 2, "{stderr}");
    assert!(
        lines[0].starts_with("lobes: warning: ") && lines[1].starts_with("lobes: error: --frames 0..1000"),
        "{stderr}"
    );
}

/// Frames that are cut short or have a flipped bit are noticed and made anew.
#[test]
fn damaged_frames_are_made_anew() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("roll.toml"), rolling()).unwrap();
    let args = ["render", "roll.toml", "-o", "r.exr", "-o", "r.png", "--frames", "0..2", "--visibility", "none"];
    succeed(folder, &args);
    let all = ["r.0000.exr", "r.0001.exr", "r.0000.png", "r.0001.png"];
    let whole: Vec<Vec<u8>> = all.iter().map(|n| fs::read(folder.join(n)).unwrap()).collect();
    for (name, bytes) in all.iter().zip(&whole) {
        let mut flipped = bytes.clone();
        flipped[3 * bytes.len() / 4] ^= 4;
        for damaged in [&flipped[..], &bytes[..bytes.len() - 1]] {
            fs::write(folder.join(name), damaged).unwrap();
            let ran = lobes(folder, &[&args[..], &["--stats", "stats.json"]].concat());
            let told = String::from_utf8(ran.stderr).unwrap();
            assert!(ran.status.success() && told.lines().count() == 1 && told.contains(name), "{told}");
            assert!(fs::read(folder.join(name)).unwrap() == *bytes, "{name}");
            let stats: Value = serde_json::from_slice(&fs::read(folder.join("stats.json")).unwrap()).unwrap();
            assert_eq!((&stats["frames"], &stats["skipped_frames"]), (&1.into(), &1.into()));
        }
    }
}
