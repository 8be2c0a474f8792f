use super::*;

/// 8 × 24 quads around the y axis as triangles: radius and height at t in [0, 1].
fn turned(profile: impl Fn(f64) -> (f64, f64)) -> String {
    let (mut vertices, mut faces) = (String::new(), String::new());
    for ring in 0..=8 {
        let (r, y) = profile(ring as f64 / 8.0);
        for step in 0..24 {
            let (s, c) = (step as f64 / 24.0 * std::f64::consts::TAU).sin_cos();
            vertices += &format!("v {} {y} {}\n", r * c, r * s);
            if ring < 8 {
                let at = |r: usize, s: usize| r * 24 + s % 24 + 1;
                let (a, b, c, d) = (at(ring, step), at(ring, step + 1), at(ring + 1, step + 1), at(ring + 1, step));
                faces += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
            }
        }
    }
    vertices + &faces
}

#[test]
fn checking_and_help() {
    let folder = folder();
    let folder = folder.path();
    assert!(succeed(folder, &["check", "scene.toml"]).contains("lights     1"));
    assert_eq!(json(folder, &["check", "scene.toml", "--json"])["spheres"], 1);
    // Pictures are made in bands: a large one takes the picture itself, 15 bytes a pixel, and a little more.
    let large = SCENE.replace("width = 48", "width = 16384").replace("height = 32", "height = 16384");
    fs::write(folder.join("large.toml"), large).unwrap();
    let bytes = json(folder, &["check", "large.toml", "--json"])["memory_bytes"].as_u64().unwrap();
    assert!((15 << 28..16 << 28).contains(&bytes), "{bytes}");
    assert!(succeed(folder, &["check"]).contains("lobes"));
    let schema = succeed(folder, &["check", "--schema"]);
    assert!(schema.contains("[camera]"));
    // A scene but for the files that it names, and its first line names them.
    let first = schema.lines().next().unwrap();
    for name in ["example.obj", "example.png", "example.spheres.json"] {
        assert_eq!(first.matches(name).count(), 1, "{first}");
    }
    fs::write(folder.join("schema.toml"), &schema).unwrap();
    refuse(folder, &["check", "schema.toml"], "example.png");
    for args in [&[][..], &["--help"], &["render", "--help"], &["reference", "-h"], &["--version"]] {
        assert!(!succeed(folder, args).is_empty());
    }
    assert!(succeed(folder, &["render", "--help"]).contains("Examples:"));
}

/// Each object gets a strategy and a reason that follows from its shape.
#[test]
fn checking_advises_for_each_object() {
    let folder = folder();
    let folder = folder.path();
    // A bowl, open above; and a pole of as many triangles.
    let bowl = turned(|t| ((1.5 * t).sin(), 1.0 - (1.5 * t).cos()));
    let pole = turned(|t| (if t % 1.0 == 0.0 { 0.0 } else { 0.02 }, 4.0 * t));
    fs::write(folder.join("bowl.obj"), bowl).unwrap();
    fs::write(folder.join("pole.obj"), pole).unwrap();
    let meshes = "\n[[objects]]\nmesh = \"bowl.obj\"\ntranslate = [2, 0, 0]\n\n[[objects]]\nmesh = \"pole.obj\"\n\
                  translate = [-3, 0, 0]\nvisibility = \"rays\"\n";
    fs::write(folder.join("all.toml"), SCENE.to_owned() + TABLE + meshes).unwrap();
    let all = json(folder, &["check", "all.toml", "--json"]);
    let advice = |n: usize| {
        let advice = &all["objects"][n]["advice"];
        (advice["visibility"].as_str().unwrap(), advice["reason"].as_str().unwrap())
    };
    for (n, (word, reason)) in [
        ("none", "backdrop"),
        ("spheres", "spheres are exact"),
        ("silhouettes", "12 triangles"),
        ("silhouettes", "open"),
        ("silhouettes", "thin"),
    ]
    .into_iter()
    .enumerate()
    {
        assert!(advice(n).0 == word && advice(n).1.contains(reason), "{n}: {:?}", advice(n));
    }
    // The strategy that render uses instead, and the line that follows the advice.
    let told = succeed(folder, &["check", "all.toml"]);
    let line = "render takes \"rays\" unless told so: write visibility = \"silhouettes\" under this object";
    assert_eq!(told.matches("unless told so").count(), 1, "{told}");
    assert!(told.contains(line), "{told}");
    let told = succeed(folder, &["check", "bowl.obj"]);
    assert!(!told.contains("unless told so"), "{told}");
    // Meshes are by their silhouettes, since nothing else was said.
    let takes = |n: usize| (all["objects"][n]["visibility"].as_str().unwrap(), all["objects"][n]["spheres"].as_u64());
    assert_eq!(
        [takes(1), takes(2), takes(3), takes(4)],
        [("spheres", Some(1)), ("silhouettes", Some(0)), ("silhouettes", Some(0)), ("rays", Some(0))]
    );
    assert!(!folder.with_extension("cache").exists(), "checking leaves nothing");
    let of = |scene: &str| json(folder, &["check", scene, "--json"])["map_bytes_at_most"].as_u64().unwrap();
    assert_eq!(of("all.toml"), 0);
    let maps = SCENE.to_owned() + &TABLE.replace("proxy", "visibility = \"shadow-map\"\nproxy");
    fs::write(folder.join("maps.toml"), maps).unwrap();
    assert!(of("maps.toml") > 1 << 20);
    assert!(succeed(folder, &["check", "maps.toml"]).contains("blocks through shadow maps"));
    assert!(all["animation"].is_null());
    assert!(succeed(folder, &["check", "all.toml"]).contains("advice: visibility = \"silhouettes\""));
    // Seen from below, the floor is dark by its own facet: it hides no light from what is seen.
    fs::write(folder.join("below.toml"), SCENE.replace("eye = [0.0, 3.0, 8.0]", "eye = [0.0, -3.0, 8.0]")).unwrap();
    assert_eq!(json(folder, &["check", "below.toml", "--json"])["objects"][0]["advice"]["visibility"], "none");

    // Motion is reported.
    fs::write(folder.join("roll.toml"), rolling()).unwrap();
    let roll = json(folder, &["check", "roll.toml", "--json"]);
    assert_eq!((&roll["animation"]["duration"], &roll["animation"]["frames"]), (&1.0.into(), &11.into()));
    assert!(succeed(folder, &["check", "roll.toml"]).contains("frames 0 to 10 at 10 a second: all by --frames 0..11"));
    let fox = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/assets/fox.glb");
    let of = |options: &[&str]| {
        json(folder, &[&["check", fox, "--json"], options].concat())["animation"]["duration"].clone()
    };
    assert_eq!(of(&["--clip", "0"]), of(&[]));
    assert_ne!(of(&["--clip", "Run"]), of(&[]));
}

/// A backdrop has nothing behind it and does not move; a screen before a part of the floor is none, even where its own key says `none`.
#[test]
fn only_what_has_nothing_behind_it_is_a_backdrop() {
    let folder = folder();
    let folder = folder.path();
    let advice = |file: &str| {
        let all = json(folder, &["check", file, "--json"]);
        let objects = all["objects"].as_array().unwrap();
        let word = |o: &serde_json::Value| o["advice"]["visibility"].as_str().unwrap().to_owned();
        objects.iter().map(word).collect::<Vec<_>>()
    };
    // The floor that is added to a mesh lies behind it as well.
    fs::write(folder.join("quad.obj"), "v -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\nf 1 2 3 4\n").unwrap();
    assert_eq!(advice("quad.obj"), ["none", "silhouettes"]);
    let screen = "\n[[objects]]\nquad = { center = [0, 1, -2], u = [2, 0, 0], v = [0, 1, 0] }\n";
    for (keys, expected) in [
        ("visibility = \"rays\"\n", ["none", "spheres", "silhouettes"]),
        ("visibility = \"none\"\n", ["none", "spheres", "silhouettes"]),
        ("", ["none", "spheres", "silhouettes"]),
        ("keys = [{ time = 0 }, { time = 1, translate = [0, 0, 9] }]\n", ["none", "spheres", "silhouettes"]),
    ] {
        fs::write(folder.join("screen.toml"), format!("{SCENE}{screen}{keys}")).unwrap();
        assert_eq!(advice("screen.toml"), expected, "{keys}");
    }
    // Parallel rays come down to the floor although the eye is below it.
    let below = SCENE
        .replace("eye = [0.0, 3.0, 8.0]", "eye = [0.0, -0.5, 8.0]")
        .replace("[0.0, 0.6, 0.0]", "[0.0, -2.0, 0.0]")
        .replace("size = 20.0 }", "size = 20.0 }\nvisibility = \"rays\"");
    for (keys, floor) in [("projection = \"orthographic\"\nheight = 6", "none"), ("fov = 30.0", "silhouettes")] {
        fs::write(folder.join("below.toml"), below.replace("fov = 30.0", keys)).unwrap();
        assert_eq!(advice("below.toml"), [floor, "spheres"], "{keys}");
    }
    // A sheet below a wide floor is behind it, although the gap is thin beside the size of the floor.
    let cellar = "\n[[objects]]\nquad = { center = [0, -1, 0], u = [1, 0, 0], v = [0, 0, -1] }\n";
    let wide = SCENE.replace("size = 20.0 }", "size = 20000.0 }");
    assert_ne!(wide, SCENE);
    for (below, floor) in [("", "none"), (cellar, "silhouettes")] {
        fs::write(folder.join("wide.toml"), format!("{wide}{below}")).unwrap();
        assert_eq!(advice("wide.toml")[0], floor, "{below}");
    }
}

/// A set that an earlier picture left behind speaks against spheres where it is bad, and for them nowhere.
#[test]
fn advice_does_not_follow_the_cache() {
    let folder = folder();
    let folder = folder.path();
    let cache = folder.with_extension("cache").join("cosine-lobes");
    fs::write(folder.join("pole.obj"), turned(|t| (if t % 1.0 == 0.0 { 0.0 } else { 0.1 }, 4.0 * t))).unwrap();
    fs::write(folder.join("globe.obj"), turned(|t| (3.2 * t * (1.0 - t), 1.6 * t))).unwrap();
    for (mesh, reason) in [("pole.obj", "thin"), ("globe.obj", "compact")] {
        let proxy = "proxy = { spheres = 8 }\nvisibility = \"spheres\"";
        fs::write(folder.join("all.toml"), format!("{SCENE}\n[[objects]]\nmesh = \"{mesh}\"\n{proxy}\n")).unwrap();
        let advice = || {
            let all = json(folder, &["check", "all.toml", "--json"]);
            let advice = &all["objects"][2]["advice"];
            (advice["visibility"].as_str().unwrap().to_owned(), advice["reason"].as_str().unwrap().to_owned())
        };
        let before = advice();
        assert!(before.0 == "silhouettes" && before.1.contains(reason), "{before:?}");
        let _ = fs::remove_dir_all(&cache);
        succeed(folder, &["render", "all.toml", "-q"]);
        let name = names(&cache)[0].clone();
        let mut kept = cache.join(&name);
        let mut set: serde_json::Value = serde_json::from_str(&fs::read_to_string(&kept).unwrap()).unwrap();
        let mut with_error = |error: f64| {
            set["quality"]["silhouette_error"] = error.into();
            // The name has the content's checksum.
            let (key, text) = (name.split('.').next().unwrap(), set.to_string());
            fs::remove_file(&kept).unwrap();
            kept = cache.join(format!("{key}.{}.json", cosine_lobes::checksum(text.as_bytes())));
            fs::write(&kept, text).unwrap();
            advice()
        };
        assert_eq!(with_error(0.0625), before);
        let bad = with_error(0.25);
        assert!(bad.0 == "silhouettes" && bad.1.contains("miss 25.0 %"), "{bad:?}");
    }
}

/// Objects with the same description share their lines.
#[test]
fn equal_objects_are_told_of_once() {
    let folder = folder();
    let folder = folder.path();
    let table = |n: usize| TABLE.replace("\"table\"", &format!("\"table {n}\"")).replace("-1.5", &format!("-{n}.5"));
    let scene = |tables: usize| SCENE.to_owned() + &(1..=tables).map(table).collect::<String>();
    fs::write(folder.join("four.toml"), scene(4)).unwrap();
    fs::write(folder.join("six.toml"), scene(6) + &TABLE.replace("proxy", "visible = false\nproxy")).unwrap();
    let told = succeed(folder, &["check", "four.toml"]);
    assert!(told.contains("object     \"table 1\", \"table 2\", \"table 3\", \"table 4\": 12 triangles"), "{told}");
    let told = succeed(folder, &["check", "six.toml"]);
    assert!(told.contains("object     \"table 1\", \"table 2\", \"table 3\" and 3 more: 12 triangles"), "{told}");
    assert!(told.contains("object     \"table\": 12 triangles, material 0, not seen by the camera"), "{told}");
    assert_eq!((told.matches("object  ").count(), told.matches("advice:").count()), (4, 4), "{told}");
    assert_eq!(json(folder, &["check", "six.toml", "--json"])["objects"].as_array().unwrap().len(), 9);
}

/// A residual is reported with the methods that have it; exact materials have none.
#[test]
fn residuals_of_materials_are_told() {
    let folder = folder();
    let folder = folder.path();
    let mut materials = String::new();
    for (name, keys) in [
        ("paper", "model = \"lambert\"\nalbedo = 0.5"),
        ("metal", "model = \"neumann\"\nks = 0.9\nexponent = 20"),
        ("coat", "model = \"metallic-roughness\"\nbase = 0.5\nroughness = 0.4"),
    ] {
        materials += &format!("[materials.{name}]\n{keys}\n\n");
    }
    let object =
        |name: &str| format!("\n[[objects]]\nmaterial = \"{name}\"\nsphere = {{ center = [9, 9, 9], radius = 1 }}\n");
    let objects: String = ["paper", "metal", "coat"].map(object).concat();
    let scene = SCENE.replace("[[lights]]", &format!("{materials}[[lights]]")) + &objects;
    fs::write(folder.join("materials.toml"), scene).unwrap();
    let told = succeed(folder, &["check", "materials.toml"]);
    let line = |start: &str| told.lines().skip_while(|line| !line.contains(start)).nth(1).unwrap_or_default();
    assert!(!line(": lambert").contains("its lobes"), "{told}");
    assert!(line(": neumann").contains("its lobes are 3.3 % off ("), "{told}");
    assert!(!line(": metallic-roughness").contains("its lobes") && !told.contains("% by the methods"), "{told}");
    let all = json(folder, &["check", "materials.toml", "--json"]);
    let of = |model: &str, key: &str| {
        let materials = all["materials"].as_array().unwrap();
        materials.iter().find(|m| m["model"] == model).unwrap()[key].as_f64().unwrap()
    };
    assert!(of("lambert", "residual") < 1e-3 && of("metallic-roughness", "residual") < 1e-3);
    assert!(of("metallic-roughness", "residual_of_directions") > 0.02 && of("neumann", "residual") > 0.02);
}

/// Neither their tables nor their residuals are computed, which take milliseconds each.
#[test]
fn many_materials_are_checked_soon() {
    let folder = folder();
    let folder = folder.path();
    let material = |k: usize| {
        let roughness = k as f32 / 2000.0;
        format!("[materials.m{k}]\nmodel = \"metallic-roughness\"\nbase = 0.5\nroughness = {roughness}\n\n")
    };
    let all: String = (0..2000).map(material).collect();
    fs::write(folder.join("many.toml"), SCENE.replace("[[lights]]", &format!("{all}[[lights]]"))).unwrap();
    let begin = std::time::Instant::now();
    succeed(folder, &["check", "many.toml"]);
    assert!(begin.elapsed().as_secs_f64() < 4.0, "{:?}", begin.elapsed());
}

/// Each strategy has a price or a reason against it; the exact ones have next to no error.
#[test]
fn checking_prices_strategies() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("priced.toml"), SCENE.to_owned() + TABLE).unwrap();
    let prices = json(folder, &["check", "priced.toml", "--prices", "--json"])["prices"].clone();
    assert!(prices["penumbra_points"].as_u64().unwrap() > 20, "{prices}");
    let all = prices["strategies"].as_array().unwrap();
    assert_eq!(all.len(), 5);
    for price in all {
        let name = price["visibility"].as_str().unwrap();
        if let Some(error) = price["mean_error"].as_f64() {
            assert!(price["shade_seconds"].as_f64().unwrap() > 0.0, "{price}");
            assert!(!["silhouettes", "rays"].contains(&name) || error < 0.005, "{price}");
        } else {
            assert!(price["unsuited"].is_string() && !["silhouettes", "rays", "scene"].contains(&name), "{price}");
        }
    }
    assert!(succeed(folder, &["check", "priced.toml", "--prices"]).contains("silhouettes shading"));
    // Nothing to compare in the dark.
    let dark = SCENE.split("[[lights]]").next().unwrap();
    fs::write(folder.join("dark.toml"), dark).unwrap();
    assert!(succeed(folder, &["check", "dark.toml", "--prices"]).contains("over 0 points"));
}
