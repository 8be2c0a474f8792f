use super::*;
use cosine_lobes::sphere_sets::{BoundSet, SphereSet};

/// A mesh's spheres are built once: the second picture is the same and takes them from the cache.
#[test]
fn spheres_are_kept_between_runs() {
    let folder = folder();
    let folder = folder.path();
    let cache = folder.with_extension("cache").join("cosine-lobes");
    let scene = SCENE.to_owned()
        + "\n[[objects]]\nbox = { center = [0, 1, 2], size = [1, 1, 1] }\nproxy = { spheres = 8 }\n\
         visibility = \"spheres\"\n";
    fs::write(folder.join("box.toml"), scene).unwrap();
    succeed(folder, &["render", "box.toml", "-o", "a.exr", "-q"]);
    let kept = names(&cache);
    assert_eq!(kept.len(), 1);
    // A spoilt entry is built anew, even if only a digit of it has changed.
    let text = fs::read_to_string(cache.join(&kept[0])).unwrap();
    let place = text.find("\"spheres\"").unwrap();
    let digit = text[place..].find("0.").unwrap() + place + 3;
    let other = if text.as_bytes()[digit] == b'7' { "3" } else { "7" };
    let changed = format!("{}{other}{}", &text[..digit], &text[digit + 1..]);
    SphereSet::from_json(&changed).unwrap();
    for spoilt in [None, Some("{}"), Some(&changed)] {
        if let Some(spoilt) = spoilt {
            fs::write(cache.join(&kept[0]), spoilt).unwrap();
        }
        let ran = lobes(folder, &["render", "box.toml", "-o", "b.exr"]);
        let told = String::from_utf8(ran.stderr).unwrap();
        assert_eq!(told.matches("damaged; made anew").count(), usize::from(spoilt.is_some()), "{told}");
        assert_eq!(fs::read(folder.join("a.exr")).unwrap(), fs::read(folder.join("b.exr")).unwrap());
    }
    assert_eq!(names(&cache), kept);
}

/// So is the paper's table. One that is damaged is made anew, with the same bits by any number of threads.
#[test]
fn the_table_of_the_paper_is_kept_between_runs() {
    let folder = folder();
    let folder = folder.path();
    let cache = folder.with_extension("cache").join("cosine-lobes");
    fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let render = |output: &str, threads: &str| {
        let args = ["render", "scene.toml", "--method", "paper", "--size", "32x24", "--threads", threads, "-o", output];
        String::from_utf8(lobes(folder, &args).stderr).unwrap()
    };
    render("a.exr", "1");
    let kept = names(&cache);
    assert_eq!(kept.len(), 1);
    let whole = fs::read(cache.join(&kept[0])).unwrap();
    for is_damaged in [false, true] {
        if is_damaged {
            let mut damaged = whole.clone();
            damaged[whole.len() / 2] ^= 1;
            fs::write(cache.join(&kept[0]), damaged).unwrap();
        }
        let told = render("b.exr", "16");
        assert_eq!(told.matches("damaged; made anew").count(), usize::from(is_damaged), "{told}");
        assert!(fs::read(folder.join("a.exr")).unwrap() == fs::read(folder.join("b.exr")).unwrap());
    }
    assert_eq!(names(&cache), kept);
}

/// With `--bones` the set of a skinned mesh lists the bones of each sphere, and stays a valid set.
#[test]
fn sets_of_skinned_meshes_have_bones() {
    let folder = folder();
    let folder = folder.path();
    let fox = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/assets/fox.glb");
    let build = |options: &[&str]| {
        succeed(folder, &[&["spheres", fox, "--count", "8", "--draft", "-o", "fox.json", "-q"], options].concat());
        fs::read_to_string(folder.join("fox.json")).unwrap()
    };
    let plain = build(&[]);
    assert!(BoundSet::from_json(&plain).is_err(), "no bones unless asked for");
    let text = build(&["--bones"]);
    let bound = BoundSet::from_json(&text).unwrap();
    assert_eq!((bound.rest().spheres.len(), bound.targets()), (8, 0));
    // The model has 24 joints; the numbers end at the last one that carries a sphere.
    assert!((10..=24).contains(&bound.joints()), "{}", bound.joints());
    assert_eq!(SphereSet::from_json(&text).unwrap(), *bound.rest());
    assert_eq!(SphereSet::from_json(&plain).unwrap(), *bound.rest());
    // Another clip begins in another pose.
    assert_eq!(build(&["--clip", "0"]), plain);
    assert_ne!(build(&["--clip", "Run"]), plain);
    refuse(folder, &["spheres", fox, "--clip", "Fly"], "Fly");
}

/// Wrong options are named, and a bad set is reported with the cause.
#[test]
fn sphere_sets_say_what_is_wrong() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        .unwrap();
    refuse(folder, &["spheres", "m.obj", "-o", "set.png"], "must end in .json");
    refuse(folder, &["spheres", "scene.toml", "-o", "set.json"], ".obj, .ply, .gltf or .glb");
    refuse(folder, &["spheres", "m.obj", "-o", "set.json", "--bones"], "--bones");
    refuse(folder, &["spheres", "m.obj", "--tolerance", "0.1", "--draft"], "--draft");
    let told = |args: &[&str]| {
        let ran = lobes(folder, &[&["spheres", "m.obj"], args].concat());
        assert!(ran.status.success());
        String::from_utf8(ran.stderr).unwrap()
    };
    let few = told(&["--count", "1", "-o", "set.json"]);
    assert!(few.contains("too few spheres (1) for it") && few.lines().count() == 1, "{few}");
    let draft = told(&["--count", "16", "--draft"]);
    assert!(draft.contains("--draft leaves") && draft.contains("-o set.json"), "{draft}");
    assert_eq!(told(&["--count", "1", "--draft", "-q"]), "");
}

#[test]
fn sphere_sets_follow_the_contract() {
    let folder = folder();
    let folder = folder.path();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.join("m.obj"), obj).unwrap();
    let args = ["spheres", "m.obj", "--count", "4", "--draft", "-o", "set.json", "--preview", "p.png", "--json", "-q"];
    let figures = json(folder, &args);
    for key in ["count", "seconds", "coverage", "protrusion_volume", "hausdorff_outside", "p95_gap", "silhouette_error"]
    {
        assert!(figures[key].is_number(), "{key} in {figures}");
    }
    assert_eq!(names(folder), ["m.obj", "p.png", "scene.toml", "set.json"]);
    // The stored set serves a scene.
    let scene = SCENE.to_owned() + "\n[[objects]]\nmesh = \"m.obj\"\nproxy = { file = \"set.json\" }\n";
    fs::write(folder.join("with.toml"), &scene).unwrap();
    let stats = json(folder, &["render", "with.toml", "-o", "a.png", "--json"]);
    assert_eq!(stats["spheres"], 5);
    // Also where the mesh is placed: the set is in the mesh's own coordinates.
    let placed = scene.clone() + "scale = 3\nrotate = { axis = [1, 1, 0], degrees = 50 }\ntranslate = [1, 2, -3]\n";
    fs::write(folder.join("placed.toml"), placed).unwrap();
    assert_eq!(json(folder, &["render", "placed.toml", "-o", "a.png", "--json"])["spheres"], 5);
    fs::write(folder.join("uneven.toml"), scene.clone() + "scale = [1, 2, 1]\n").unwrap();
    refuse(folder, &["render", "uneven.toml"], "uniformly");
    // And is looked into when the scene is checked.
    assert_eq!(json(folder, &["check", "with.toml", "--json"])["spheres"], 5);
    fs::write(folder.join("set.json"), "{}").unwrap();
    refuse(folder, &["check", "with.toml"], "set.json");
}

/// A set needs no floor, no light and no camera: none is made that would be too large.
#[test]
fn sphere_sets_of_large_meshes_are_built() {
    let folder = folder();
    let folder = folder.path();
    let obj =
        |size: &str| format!("v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nv 0 0 {size}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    fs::write(folder.join("large.obj"), obj("9e8")).unwrap();
    let args = ["spheres", "large.obj", "--count", "4", "--draft", "--json", "-q"];
    assert_eq!(json(folder, &args)["triangles"], 4);
    fs::write(folder.join("large.obj"), obj("2e9")).unwrap();
    refuse(folder, &args, "within ±1e9");
}
