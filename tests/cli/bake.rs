//! `lobes bake`.

use super::*;
use cosine_lobes::read_exr;
use serde_json::json;

/// A floor from −1 to 1 and a smaller table over it, flat and without coordinates, under a point light: as glTF with its buffer in it.
fn room(light: &str) -> String {
    let quad = |y: f32, half: f32| -> Vec<f32> {
        [[-half, half], [half, half], [half, -half], [-half, -half]].iter().flat_map(|[x, z]| [*x, y, *z]).collect()
    };
    let mut bytes: Vec<u8> = Vec::new();
    for value in quad(0.0, 1.0).into_iter().chain(quad(0.5, 0.3)) {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    let base64: String = {
        let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let word = |c: &[u8]| c.iter().fold(0_u32, |w, b| w << 8 | u32::from(*b));
        assert_eq!(bytes.len() % 3, 0);
        bytes.chunks(3).flat_map(|c| [18, 12, 6, 0].map(|s| digits[(word(c) >> s & 63) as usize] as char)).collect()
    };
    let primitive = |positions: u32| json!([{"attributes": {"POSITION": positions}, "indices": 2, "material": 0}]);
    let lights: Value = if light.is_empty() { json!([]) } else { serde_json::from_str(light).unwrap() };
    let light_node = if light.is_empty() {
        json!({})
    } else {
        json!({"translation": [0.3, 1.5, 0.2], "extensions": {"KHR_lights_punctual": {"light": 0}}})
    };
    json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": lights}},
        "nodes": [{"mesh": 0, "name": "floor"}, {"mesh": 1, "name": "table"}, light_node],
        "meshes": [{"primitives": primitive(0)}, {"primitives": primitive(1)}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 0, "byteOffset": 48, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 12}],
        "buffers": [{"byteLength": 108, "uri": format!("data:application/octet-stream;base64,{base64}")}],
    })
    .to_string()
}

const POINT: &str = r#"[{"type": "point", "intensity": 3}]"#;

#[test]
fn a_room_is_baked_in_each_form() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("room.gltf"), room(POINT)).unwrap();
    let small = ["--page", "64", "--json"];
    let bake =
        |more: &[&str]| super::json(folder, &[&["bake", "room.gltf", "-o", "out.glb"], &small[..], more].concat());
    let plain = bake(&[]);
    assert_eq!((&plain["surfaces"], &plain["vertices"], &plain["files"]), (&json!(2), &json!(0), &json!([])));
    assert!(plain["texels"].as_u64().unwrap() > 1500, "{plain}");
    let maps = bake(&["--as", "lightmap", "--per-light"]);
    let names = ["out.lightmap0.exr", "out.lightmap0.png", "out.lightmap0.light0.exr"];
    assert_eq!(maps["files"], json!(names));
    assert!(names.iter().all(|name| folder.join(name).exists()));
    let [all, one] = [names[0], names[2]].map(|name| read_exr(&folder.join(name)).unwrap());
    let [width, height] = [0, 1].map(|k| maps["pages"][0][k].as_u64().unwrap() as usize);
    assert_eq!((all.width(), all.height()), (width, height));
    let most = all.pixels().iter().map(|p| p.x).fold(0.0, f32::max);
    // The brightest place is on the table, one below the light: 3/1².
    assert!((most - 3.0).abs() < 0.1, "{most}");
    assert!(all.pixels().iter().zip(one.pixels()).all(|(a, b)| (*a - *b).length() <= 2e-3 * a.length()));
    // The table's shadow.
    assert!(all.pixels().iter().any(|p| p.x == 0.0));
    let colors = bake(&["--as", "vertex-colors"]);
    assert_eq!((&colors["vertices"], &colors["pages"]), (&json!(8), &json!([])));
    succeed(folder, &["check", "out.glb"]);
    succeed(folder, &["render", "out.glb", "--size", "32x32", "-q", "-o", "out.png"]);
    // The same bytes again, and with one thread.
    let bytes = fs::read(folder.join("out.glb")).unwrap();
    bake(&["--as", "vertex-colors", "--threads", "1"]);
    assert_eq!(fs::read(folder.join("out.glb")).unwrap(), bytes);
}

#[test]
fn what_cannot_be_baked_is_refused() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("room.gltf"), room(POINT)).unwrap();
    fs::write(folder.join("dark.gltf"), room("")).unwrap();
    fs::write(folder.join("room.glb"), "no model").unwrap();
    let cases: [(&[&str], &str); 9] = [
        (&["bake", "dark.gltf", "-o", "out.glb"], "dark.gltf: has no light to bake"),
        (&["bake", "room.gltf", "-o", "room.gltf"], "both read and written"),
        (&["bake", "room.glb", "-o", "room.glb"], "both read and written"),
        (&["bake", "room.gltf", "-o", "out.png"], "out.png: the name must end in .glb"),
        (&["bake", "room.gltf", "-o", "no/out.glb"], "no/out.glb"),
        (&["bake", "missing.glb", "-o", "out.glb"], "missing.glb"),
        (&["bake", "room.gltf", "-o", "out.glb", "--page", "8"], "expected a whole number from 16 to 16384"),
        (&["bake", "room.gltf", "-o", "out.glb", "--page", "16384", "--per-light"], "GB"),
        (&["bake", "room.gltf", "-o", "out.glb", "--density", "1e6"], "GB"),
    ];
    for (args, fault) in cases {
        refuse(folder, args, fault);
    }
}

#[cfg(unix)]
#[test]
fn read_only_folders_are_refused_at_once() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("room.gltf"), room(POINT)).unwrap();
    let closed = folder.join("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    // Root writes anywhere.
    if fs::write(closed.join("x"), "").is_err() {
        refuse(folder, &["bake", "room.gltf", "-o", "closed/out.glb"], "closed/out.glb");
    }
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).unwrap();
}

/// A scene file becomes a new file with its meshes, materials and camera; a sky is one light of it. An OBJ gets the light of its picture.
#[test]
fn scenes_and_models_become_files() {
    let folder = folder();
    let folder = folder.path();
    let sky = "\n[[lights]]\nkind = \"environment\"\nradiance = [0.3, 0.4, 0.5]\n";
    let paint = "\n[materials.paint]\nmodel = \"lambert\"\nalbedo = [0.5, 0.25, 0.125]\n";
    let scene = format!("{SCENE}{TABLE}material = \"paint\"\n{sky}{paint}").replace("size = 20.0", "size = 4.0");
    fs::write(folder.join("sky.toml"), scene).unwrap();
    let args = ["bake", "sky.toml", "-o", "sky.glb", "--page", "128", "--as", "lightmap", "--per-light", "--json"];
    let ran = lobes(folder, &args);
    let stderr = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success() && stderr.is_empty(), "{stderr}");
    let baked: Value = serde_json::from_slice(&ran.stdout).unwrap();
    assert_eq!(baked["surfaces"], json!(3), "a sphere is one, too");
    let parts = ["", ".light0", ".sky"].map(|end| format!("sky.lightmap0{end}.exr"));
    let [all, lamp, sky] = parts.map(|name| read_exr(&folder.join(name)).unwrap());
    for ((all, lamp), sky) in all.pixels().iter().zip(lamp.pixels()).zip(sky.pixels()) {
        // At the seams of the sphere, too; half floats have eleven digits.
        assert!((*all - *lamp - *sky).length() <= 1.5e-3 * all.length(), "{all} {lamp} {sky}");
    }
    // Open floor sees the whole sky: π times its radiance.
    let most = sky.pixels().iter().map(|p| p.x).fold(0.0, f32::max);
    assert!((most / (0.3 * std::f32::consts::PI) - 1.0).abs() < 0.01, "{most}");
    let bytes = fs::read(folder.join("sky.glb")).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let file: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let colors: Vec<&Value> =
        file["materials"].as_array().unwrap().iter().map(|m| &m["pbrMetallicRoughness"]["baseColorFactor"]).collect();
    assert!(colors.contains(&&json!([0.5, 0.25, 0.125, 1])), "{colors:?}");
    assert!((file["cameras"][0]["perspective"]["yfov"].as_f64().unwrap() - 30.0_f64.to_radians()).abs() < 1e-6);
    // Other cameras: an orthographic one is read back as it was, a panoramic one gives a warning.
    for (name, keys) in
        [("flat", "projection = \"orthographic\"\nheight = 4"), ("around", "projection = \"panoramic\"")]
    {
        let (scene, made) = (format!("{name}.toml"), format!("{name}.glb"));
        fs::write(folder.join(&scene), SCENE.replace("fov = 30.0", keys).replace("size = 20.0", "size = 4.0")).unwrap();
        let ran = lobes(folder, &["bake", &scene, "-o", &made, "--page", "32"]);
        let stderr = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success(), "{stderr}");
        let lost = "the panoramic camera is left out: glTF has none";
        assert_eq!(stderr.contains(lost), name == "around", "{stderr}");
        let (was, is) = [&scene, &made].map(|file| cosine_lobes::scene::load(folder.join(file)).unwrap().camera).into();
        assert_eq!(was.projection == is.projection, name == "flat");
        assert!(name == "around" || (was.eye - is.eye).length() < 1e-6);
    }
    fs::write(folder.join("corner.obj"), "v 0 0 0\nv 1 0 0\nv 0 0 -1\nv 0 1 0\nf 1 2 3\nf 1 4 2\n").unwrap();
    let corner = super::json(folder, &["bake", "corner.obj", "-o", "corner.glb", "--page", "32", "--json", "-q"]);
    assert!(corner["texels"].as_u64().unwrap() > 300, "{corner}");
}

/// A card that moves over a floor under a lamp, for two seconds.
const CARD: &str = r#"
[camera]
eye = [0, 3, 5]
target = [0, 0, 0]
[[lights]]
kind = "sphere"
center = [0, 3, 0]
radius = 0.1
radiance = 100
[[objects]]
name = "floor"
quad = { center = [0, 0, 0], u = [2, 0, 0], v = [0, 0, -2] }
[[objects]]
name = "card"
quad = { center = [0, 0.5, 0], u = [0.3, 0, 0], v = [0, 0, -0.3] }
keys = [{ time = 0 }, { time = 2, translate = [1, 0, 0] }]
"#;

/// A file a frame, with its maps; frames that are there are kept if the same command made them.
#[test]
fn frames_are_files_of_their_own() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("card.toml"), CARD).unwrap();
    let args = ["bake", "card.toml", "-o", "f.glb", "--page", "64", "--as", "lightmap", "--json", "-q"];
    let frames = |more: &[&str]| super::json(folder, &[&args[..], &["--fps", "2"], more].concat());
    let made = frames(&["--frames", "1..4"]);
    assert_eq!((made["frames"].as_array().unwrap().len(), &made["skipped_frames"]), (3, &json!(0)));
    assert_eq!(
        (&made["frames"][2]["frame"], &made["frames"][2]["files"][0]),
        (&json!(3), &json!("f.0003.lightmap0.exr"))
    );
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    let before = bytes("f.0002.glb");
    assert_ne!(bytes("f.0001.lightmap0.exr"), bytes("f.0003.lightmap0.exr"));
    // A moment alone has the same light.
    for moment in [&["--time", "1"][..], &["--frame", "2", "--fps", "2"]] {
        let args = ["bake", "card.toml", "-o", "one.glb", "--page", "64", "--as", "lightmap", "--json", "-q"];
        super::json(folder, &[&args[..], moment].concat());
        assert_eq!(bytes("one.lightmap0.exr"), bytes("f.0002.lightmap0.exr"));
    }
    let kept = |more: &[&str]| frames(&[&["--frames", "1..4"], more].concat())["skipped_frames"].clone();
    assert_eq!(kept(&[]), json!(3));
    fs::write(folder.join("f.0001.lightmap0.png"), "").unwrap();
    fs::remove_file(folder.join("f.0003.lightmap0.exr")).unwrap();
    assert_eq!(kept(&["--threads", "1"]), json!(1));
    fs::write(folder.join("f.0002.glb"), &before[..before.len() - 1]).unwrap();
    assert_eq!(kept(&[]), json!(2));
    assert_eq!(bytes("f.0002.glb"), before, "the same bytes again");
    assert_eq!(kept(&["--samples", "1"]), json!(0));
    fs::write(folder.join("card.toml"), CARD.replace("0.5, 0]", "0.6, 0]")).unwrap();
    assert_eq!(kept(&["--samples", "1"]), json!(0));
    for (more, fault) in [
        (&["--frames", "3..6"][..], "--frames 3..6: there are only frames 0 to 4"),
        (&["--time", "3"], "--time 3: the animation ends at 2 s"),
        (&["--frames", "2..2"], "there are no frames from 2 to before 2"),
    ] {
        let more: Vec<&str> = if more[0] == "--time" { more.to_vec() } else { [more, &["--fps", "2"]].concat() };
        refuse(folder, &[&args[..], &more].concat(), fault);
    }
}

/// Starts a bake and ends it by a signal as soon as it has kept some of its work; returns the last line that it printed, or none if the bake
/// was done before the signal came.
#[cfg(unix)]
fn interrupted(folder: &Path, args: &[&str], signal: &str) -> Option<String> {
    let checkpoint = folder.join("out.glb.checkpoint");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lobes"));
    let mut run = command.current_dir(folder).args(args).stderr(std::process::Stdio::piped()).spawn().unwrap();
    // Longer than its header, the coordinates and one band.
    while fs::metadata(&checkpoint).map_or(0, |file| file.len()) < 100_000 {
        if let Some(status) = run.try_wait().unwrap() {
            assert!(status.success());
            return None;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    // A process that ended by itself is still known until it is waited for.
    assert!(Command::new("kill").args([signal, &run.id().to_string()]).status().unwrap().success());
    let ended = run.wait_with_output().unwrap();
    if ended.status.success() {
        return None;
    }
    assert!(checkpoint.exists());
    Some(String::from_utf8(ended.stderr).unwrap().lines().last().unwrap_or_default().to_owned())
}

/// Ctrl-C and a kill leave a checkpoint; the same command goes on and gives the same bytes. Another command, and a damaged checkpoint, begin
/// anew.
#[cfg(unix)]
#[test]
fn interrupted_bakes_go_on() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("room.gltf"), room(POINT)).unwrap();
    let args = |output: &'static str, page: &'static str, samples: &'static str| {
        ["bake", "room.gltf", "-o", output, "--page", page, "--as", "lightmap", "--samples", samples, "--threads", "1"]
    };
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    let checkpoint = folder.join("out.glb.checkpoint");
    // A bake of less than a second keeps nothing: the work grows until this machine is interrupted in it.
    let found = ["256", "384", "768"].into_iter().find_map(|page| {
        let long = args("out.glb", page, "8");
        let last = interrupted(folder, &long, "-INT")?;
        Some((page, last, bytes("out.glb.checkpoint"), interrupted(folder, &long, "-KILL")?))
    });
    let (page, last, kept, _) = found.expect("each bake was done before it was interrupted");
    assert!(last.contains("out.glb.checkpoint; the same command goes on from there"), "{last}");
    let (long, other) = (args("out.glb", page, "8"), args("out.glb", page, "1"));
    // Half of a step at its end.
    let longer = bytes("out.glb.checkpoint");
    assert!(longer.len() > kept.len() - kept.len() / 2);
    fs::write(&checkpoint, &longer[..longer.len() - 1000]).unwrap();
    let ran = lobes(folder, &long);
    let said = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success() && said.contains("goes on from out.glb.checkpoint") && !checkpoint.exists(), "{said}");
    let resumed = [bytes("out.glb"), bytes("out.lightmap0.exr")];
    succeed(folder, &args("whole.glb", page, "8"));
    assert!(resumed == [bytes("whole.glb"), bytes("whole.lightmap0.exr")]);
    // A damaged step is made again; other options are another bake.
    let mut damaged = longer;
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(&checkpoint, &damaged).unwrap();
    succeed(folder, &long);
    assert!(resumed == [bytes("out.glb"), bytes("out.lightmap0.exr")]);
    for (content, fault) in [(&kept[..], "belongs to another bake"), (b"no checkpoint", "is damaged; made anew")] {
        fs::write(&checkpoint, content).unwrap();
        let ran = lobes(folder, &other);
        let said = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success() && said.contains(fault) && !checkpoint.exists(), "{said}");
    }
    succeed(folder, &args("whole.glb", page, "1"));
    assert!(bytes("out.glb") == bytes("whole.glb"));
}
