use super::*;

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

/// A light that a method does not support is named by its line.
#[test]
fn lights_of_a_method_are_refused_by_line() {
    let folder = folder();
    let folder = folder.path();
    let text = fs::read_to_string(folder.join("scene.toml")).unwrap();
    let line = text.lines().count() + 2;
    fs::write(folder.join("sun.toml"), text + "[[lights]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nradiance = 9\n")
        .unwrap();
    let what = format!("sun.toml:{line}:8: kind: method \"paper\" is for sphere lights: light 1 is a sun");
    refuse(folder, &["render", "sun.toml", "--method", "paper", "-o", "out.png"], &what);
}

/// If no triangle of a mesh is left, the message has the number of faces left out and the reason, in correct grammar.
#[test]
fn faces_left_out_are_counted() {
    let folder = folder();
    let folder = folder.path();
    let triangle = |size: &str| format!("v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nf 1 2 3\n");
    for (name, text, what) in [
        ("nan.obj", triangle("nan"), "nan.obj: no triangles: 1 face left out for corners that are NaN, infinite"),
        ("inf.obj", triangle("-inf") + "f 1 2 3\n", "no triangles: 2 faces left out for corners that are NaN"),
        ("over.obj", triangle("4e38") + "f 1 2\n", "1 face left out for fewer than three corners, 1 face left out for"),
        ("huge.obj", triangle("3e38"), "within ±1e9"),
        ("tiny.obj", triangle("1e-20"), "no triangles: 1 triangle left out for having no area"),
        ("none.obj", "v 0 0 0\n".to_owned(), "none.obj: no triangles"),
    ] {
        fs::write(folder.join(name), text).unwrap();
        refuse(folder, &["check", name], what);
        refuse(folder, &["spheres", name], what);
    }
    // With triangles left, the same is a warning, and one triangle is singular.
    fs::write(folder.join("one.obj"), triangle("1") + "v nan 0 0\nf 1 2 4\nf 1 1 2\n").unwrap();
    let ran = lobes(folder, &["check", "one.obj"]);
    let told = String::from_utf8(ran.stderr).unwrap();
    assert!(told.contains("one.obj: 1 face left out") && told.contains("one.obj: 1 triangle left out"), "{told}");
    let told = String::from_utf8(ran.stdout).unwrap();
    assert!(told.contains("(1 triangle, exact") && !told.contains("1 triangles"), "{told}");
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
    refuse(folder, &["render", "--threshold", "-1"], "expected a number of at least 0");
    for (option, what) in [
        ("--size", "expected WIDTHxHEIGHT"),
        ("--samples", "expected a whole number from 1 to 1024"),
        ("--exposure", "expected a number from -32 to 32"),
        ("--tolerance", "expected a number above 0"),
        ("--depth", "expected a whole number from 1 to 6"),
        ("--repeat", "expected a whole number"),
        ("--map-resolution", "16 to 8192"),
        ("--threads", "expected a whole number"),
        ("--fps", "expected a number above 0"),
    ] {
        for bad in ["-99", "-1e9", "--quiet", "1x", ""] {
            refuse(folder, &["render", option, bad], what);
        }
    }
    refuse(folder, &["reference", "--seed", "-1"], "expected a whole number from 0");
    refuse(folder, &["spheres", "x.obj", "--tolerance", "-0.1"], "expected a number above 0");
    refuse(folder, &["compare", "a.exr", "b.exr", "--diff-scale", "-1"], "expected a number above 0");
    refuse(folder, &["render", "scene.toml", "-o", "a.png", "--layers"], "--layers: no .exr file");
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

/// Features that a GPU lacks are refused before the long work, with an alternative; also without a GPU.
#[test]
fn what_a_gpu_lacks_is_refused() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), format!("{SCENE}{TABLE}")).unwrap();
    let gpu = |scene: &str, options: &[&str], what: &str| {
        let args = [&["render", scene, "-o", "a.exr", "--device", "gpu"], options].concat();
        refuse(folder, &args, &format!("--device gpu: {what}"));
    };
    gpu("scene.toml", &["--layers"], "layers are made by the CPU only");
    gpu("table.toml", &["--layers", "--visibility", "spheres"], "layers are made by the CPU only");
    assert!(!folder.with_extension("cache").exists(), "a sphere set was built");
    refuse(folder, &["render", "--device", "tpu"], "cpu, gpu, auto");
    let help = succeed(folder, &["render", "--help"]);
    assert!(help.contains("--device <DEVICE>") && help.contains("Possible values:"), "{help}");
    for word in ["- cpu:", "- gpu:", "- auto:"] {
        assert!(help.contains(word), "{word} in {help}");
    }
}

/// Without a driver `--device gpu` is an error that names the packages to install, and `auto` uses the CPU.
#[cfg(target_os = "linux")]
#[test]
fn a_gpu_that_is_not_there() {
    let folder = folder();
    let folder = folder.path();
    let run = |device: &str, name: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
        command.args(["render", "scene.toml", "-o", name, "--device", device]).current_dir(folder);
        // Of all backends Vulkan, of all its drivers none.
        command.env("WGPU_BACKEND", "vulkan").env("VK_ICD_FILENAMES", "/none").env("VK_DRIVER_FILES", "/none");
        let ran = command.output().unwrap();
        (ran.status.code(), String::from_utf8(ran.stderr).unwrap())
    };
    let (code, told) = run("gpu", "a.exr");
    assert!(code == Some(2) && told.lines().count() == 1, "{told}");
    assert!(told.starts_with("lobes: error: --device gpu: no GPU adapter") && told.contains("install"), "{told}");
    assert_eq!(names(folder), ["scene.toml"]);
    let (code, told) = run("auto", "a.exr");
    assert_eq!((code, told.as_str()), (Some(0), "lobes: note: --device auto: cpu, since there is no GPU adapter\n"));
    assert_eq!(run("cpu", "b.exr"), (Some(0), String::new()));
    assert_eq!(fs::read(folder.join("a.exr")).unwrap(), fs::read(folder.join("b.exr")).unwrap());
}

/// A command does not overwrite its inputs, and a picture needs the ending of a picture.
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

/// A result that could not be printed is a failure; a reader that stops early is none.
#[cfg(unix)]
#[test]
fn standard_output_has_to_take_the_result() {
    use std::process::Stdio;
    let folder = folder();
    let folder = folder.path();
    picture(folder, "a.exr", 2, &[1.0; 4]);
    fs::write(folder.join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        .unwrap();
    let run = |args: &[&str], out: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
        let child = command.current_dir(folder).args(args).stdout(out).stderr(Stdio::piped()).spawn().unwrap();
        let ended = child.wait_with_output().unwrap();
        (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
    };
    let commands = [
        &[][..],
        &["--version"],
        &["render", "--help"],
        &["check"],
        &["check", "--json"],
        &["check", "--schema"],
        &["render", "scene.toml", "--json"],
        &["render", "scene.toml"],
        &["compare", "a.exr", "a.exr"],
        &["compare", "a.exr", "a.exr", "--json"],
        &["reference", "scene.toml", "--spp", "8", "--json"],
        &["spheres", "m.obj", "--count", "2", "--draft", "--json", "-q"],
    ];
    for args in &commands {
        // No reader: the pipe is closed before anything is written.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_eq!(run(args, writer.into()), (Some(0), String::new()), "{args:?}");
    }
    let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") else { return };
    for args in commands {
        let (code, told) = run(args, full.try_clone().unwrap().into());
        assert!(code == Some(2) && told.lines().count() == 1 && told.contains("standard output"), "{args:?}: {told}");
    }
}
