use super::*;
use cosine_lobes::{read_exr, read_exr_layer};

#[test]
fn rendering_writes_pictures_and_figures() {
    let folder = folder();
    let folder = folder.path();
    let out = succeed(folder, &["render", "scene.toml", "-o", "a.png", "-o", "a.exr", "--layers", "--stats", "a.json"]);
    assert!(out.contains("48 x 32"), "{out}");
    assert_eq!(names(folder), ["a.exr", "a.json", "a.png", "scene.toml"]);
    let stats: Value = serde_json::from_str(&fs::read_to_string(folder.join("a.json")).unwrap()).unwrap();
    for key in ["points", "frames", "lights", "spheres", "triangles", "seconds", "points_per_second"] {
        assert!(stats[key].as_f64().unwrap() > 0.0, "{key} in {stats}");
    }
    for key in ["reflectance", "lighting", "mask", "visibility_lobes", "integration"] {
        assert!(stats["stages"][key].is_number(), "{key} in {stats}");
    }
    for key in ["lobes", "integrals", "pruned", "lit_points", "dark_points", "penumbra_points"] {
        assert!(stats["counts"][key].is_u64(), "{key} in {stats}");
    }
    assert_eq!(stats["tolerance"], 0.005);
    assert_eq!(
        (&stats["device"], &stats["method"], &stats["visibility"]),
        (&"cpu".into(), &"moments".into(), &"scene".into())
    );

    let beauty = read_exr(&folder.join("a.exr")).unwrap();
    let light = read_exr_layer(&folder.join("a.exr"), "light0").unwrap().unwrap();
    let layer = read_exr_layer(&folder.join("a.exr"), "unshadowed").unwrap().unwrap();
    assert_eq!(beauty, light);
    succeed(folder, &["render", "scene.toml", "-o", "u.exr", "--visibility", "none", "--quiet"]);
    assert_eq!(read_exr(&folder.join("u.exr")).unwrap(), layer);

    // Twice the same, on any number of threads, over the old file; and quiet is quiet.
    let before = fs::read(folder.join("a.png")).unwrap();
    let ran = lobes(folder, &["render", "scene.toml", "-o", "a.png", "--quiet", "--threads", "1"]);
    assert!(ran.status.success() && ran.stdout.is_empty() && ran.stderr.is_empty());
    assert_eq!(fs::read(folder.join("a.png")).unwrap(), before);
}

/// The two ways to the same picture, end to end, with the accuracy that the tolerance asks for.
#[test]
fn render_agrees_with_reference() {
    let folder = folder();
    let folder = folder.path();
    let stated = json(folder, &["reference", "scene.toml", "-o", "ref.exr", "--spp", "1024", "--json"]);
    assert!(stated["stderr"].as_f64().unwrap() < 1e-4 * stated["mean"].as_f64().unwrap(), "{stated}");
    succeed(folder, &["render", "scene.toml", "-o", "a.exr", "--tolerance", "0.005"]);
    let error = json(folder, &["compare", "a.exr", "ref.exr", "--unshadowed", "ref.exr", "--json"]);
    assert!(error["penumbra"]["pixels"].as_u64().unwrap() > 20, "{error}");
    assert!(error["penumbra"]["mean"].as_f64().unwrap() < 0.005, "{error}");
    assert!(error["mae"].as_f64().unwrap() < 0.003 * error["reference_mean"].as_f64().unwrap(), "{error}");
    assert_eq!(error["dark_nonzero"], 0, "{error}");
}

/// Swapping the strategy by one word: shadow rays see the spheres that the spheres strategy splats.
#[test]
fn rays_see_what_spheres_stand_for() {
    let folder = folder();
    let folder = folder.path();
    succeed(
        folder,
        &["render", "scene.toml", "-o", "a.exr", "-o", "a.png", "--visibility", "rays", "--stats", "a.json"],
    );
    succeed(folder, &["reference", "scene.toml", "-o", "mesh.exr", "--geometry", "mesh", "--spp", "1024", "-q"]);
    let error = json(folder, &["compare", "a.exr", "mesh.exr", "--unshadowed", "mesh.exr", "--json"]);
    assert!(error["penumbra"]["mean"].as_f64().unwrap() < 0.005, "{error}");
    let stats: Value = serde_json::from_str(&fs::read_to_string(folder.join("a.json")).unwrap()).unwrap();
    assert_eq!((&stats["visibility"], &stats["spheres"]), (&"rays".into(), &0.into()));
}

/// The third strategy: a depth map of the triangles, the same spheres, no sphere set built.
#[test]
fn shadow_maps_see_the_true_triangles() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE).unwrap();
    let render = |name: &str, further: &[&str]| {
        let args = ["render", "table.toml", "-o", name, "--json", "--visibility"];
        json(folder, &[&args, further].concat())
    };
    let stats = render("map.exr", &["shadow-map"]);
    assert_eq!((&stats["visibility"], &stats["spheres"]), (&"shadow-map".into(), &1.into()), "{stats}");
    assert_eq!(stats["map_resolutions"].as_array().unwrap().len(), 1, "{stats}");
    assert!(stats["map_bytes"].as_u64().unwrap() > 0 && stats["map_seconds"].as_f64().unwrap() > 0.0, "{stats}");
    assert!(!folder.with_extension("cache").exists(), "a sphere set was built");
    let unshadowed = render("none.exr", &["none"]);
    assert_eq!((&unshadowed["map_bytes"], &unshadowed["spheres"]), (&0.into(), &0.into()));
    render("rays.exr", &["rays"]);
    let error = json(folder, &["compare", "map.exr", "rays.exr", "--unshadowed", "none.exr", "--json"]);
    assert!(error["penumbra"]["pixels"].as_u64().unwrap() > 40, "{error}");
    // The strategy's limit on floors is 1 %.
    assert!(error["penumbra"]["mean"].as_f64().unwrap() < 0.01, "{error}");

    // A given resolution is used; one that is too coarse gives a warning with an alternative.
    let coarse = ["render", "table.toml", "-o", "c.exr", "--visibility", "shadow-map", "--map-resolution", "16"];
    let ran = lobes(folder, &coarse);
    let told = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success() && told.contains("light 0") && told.contains("--visibility silhouettes"), "{told}");
    assert_eq!(json(folder, &[&coarse[..], &["--json", "-q"]].concat())["map_resolutions"][0], 16);
    for bad in ["0", "100000", "15", "8193", "1.5", "x"] {
        let args = ["render", "table.toml", "--visibility", "shadow-map", "--map-resolution", bad];
        refuse(folder, &args, "16 to 8192");
    }
    refuse(folder, &["render", "table.toml", "--visibility", "rays", "--map-resolution", "512"], "no shadow map");
    // The floor alone shadows nothing: an empty map, and no fault.
    assert_eq!(json(folder, &["render", "scene.toml", "--visibility", "shadow-map", "--json"])["map_bytes"], 0);
}

/// By the paper's method too.
#[test]
fn shadow_maps_by_the_paper_s_method() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE).unwrap();
    let args = ["render", "table.toml", "-q", "--visibility", "shadow-map", "-o"];
    succeed(folder, &[&args[..], &["paper.exr", "--method", "paper"]].concat());
    succeed(folder, &[&args[..], &["moments.exr"]].concat());
    let error = json(folder, &["compare", "paper.exr", "moments.exr", "--json"]);
    let relative = error["mae"].as_f64().unwrap() / error["reference_mean"].as_f64().unwrap();
    // The paper's light lobe has up to 13.8 % too much flux; the shadows are the same.
    assert!((0.01..0.2).contains(&relative), "{error}");
}

/// A strategy for each object, in the picture and in the reference.
#[test]
fn objects_take_their_own_strategies() {
    let folder = folder();
    let folder = folder.path();
    let with = |sphere: &str, table: &str| {
        let sphere = format!("radius = 0.6 }}\nvisibility = \"{sphere}\"");
        let table = format!("proxy = {{ spheres = 8 }}\nvisibility = \"{table}\"");
        let scene = SCENE.replace("radius = 0.6 }", &sphere) + &TABLE.replace("proxy = { spheres = 8 }", &table);
        fs::write(folder.join("mixed.toml"), scene).unwrap();
    };
    let render = |name: &str, further: &[&str]| {
        json(folder, &[&["render", "mixed.toml", "-o", name, "--json"], further].concat())
    };
    let error = |a: &str, b: &str| {
        let e = json(folder, &["compare", a, b, "--unshadowed", "none.exr", "--json"]);
        assert!(e["penumbra"]["pixels"].as_u64().unwrap() > 40, "{e}");
        e["penumbra"]["mean"].as_f64().unwrap()
    };
    with("spheres", "rays");
    render("none.exr", &["--visibility", "none"]);
    for table in ["silhouettes", "rays", "shadow-map"] {
        with("spheres", table);
        let stats = render("mixed.exr", &[]);
        assert_eq!((&stats["visibility"], &stats["spheres"]), (&"scene".into(), &1.into()));
        assert!(!folder.with_extension("cache").exists(), "a sphere set was built");
        succeed(folder, &["reference", "mixed.toml", "-o", "ref.exr", "--spp", "1024", "-q"]);
        succeed(folder, &["reference", "mixed.toml", "-o", "mesh.exr", "--spp", "1024", "--geometry", "mesh", "-q"]);
        let limit = if table == "shadow-map" { 0.01 } else { 0.005 };
        assert!(error("mixed.exr", "ref.exr") < limit, "{}", error("mixed.exr", "ref.exr"));
        // Spheres as spheres and the table as it is: nothing is approximated.
        assert!(error("ref.exr", "mesh.exr") < 0.002, "{}", error("ref.exr", "mesh.exr"));
    }
    // An object may cast no shadow; a strategy for all overrides this.
    with("none", "none");
    render("mixed.exr", &[]);
    assert_eq!(read_exr(&folder.join("mixed.exr")).unwrap(), read_exr(&folder.join("none.exr")).unwrap());
    assert_eq!(render("all.exr", &["--visibility", "spheres"])["spheres"], 9);
}

/// Meshes block by their silhouettes by default; `--visibility spheres` fits spheres, with a line on the fit.
#[test]
fn meshes_need_no_fit() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("table.toml"), SCENE.to_owned() + TABLE).unwrap();
    let render = |name: &str, options: &[&str]| {
        let ran = lobes(folder, &[&["render", "table.toml", "--json", "-o", name], options].concat());
        assert!(ran.status.success());
        let stats: Value = serde_json::from_slice(&ran.stdout).unwrap();
        (String::from_utf8(ran.stderr).unwrap(), stats["spheres"].as_u64().unwrap())
    };
    assert_eq!(render("usual.exr", &[]), (String::new(), 1));
    assert!(!folder.with_extension("cache").exists(), "a sphere set was built");
    // The sphere as a sphere, the table exact: the picture of rays.
    assert_eq!(render("rays.exr", &["--visibility", "rays"]), (String::new(), 0));
    let error = json(folder, &["compare", "usual.exr", "rays.exr", "--json"]);
    assert!(error["mae"].as_f64().unwrap() < 1e-3 * error["reference_mean"].as_f64().unwrap(), "{error}");

    let (told, spheres) = render("spheres.exr", &["--visibility", "spheres"]);
    assert!(told.lines().any(|l| l.contains("\"table\": 8 spheres fitted in")), "{told}");
    assert_eq!(spheres, 9);
    assert!(!render("spheres.exr", &["--visibility", "spheres"]).0.contains("fitted"), "kept");
    let asked = SCENE.to_owned() + &TABLE.replace("proxy", "visibility = \"spheres\"\nproxy");
    fs::write(folder.join("table.toml"), asked).unwrap();
    assert_eq!(render("asked.exr", &[]).1, 9);
}

/// Sphere files that are none, or another mesh's: named, with the object.
#[test]
fn wrong_sphere_files_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    fs::write(folder.join("m.obj"), obj).unwrap();
    fs::write(folder.join("larger.obj"), obj.replace("v 1 0 0", "v 3 0 0")).unwrap();
    fs::write(folder.join("other.obj"), obj.replace("f 2 3 4\n", "")).unwrap();
    succeed(folder, &["spheres", "m.obj", "--count", "4", "--draft", "-o", "set.json", "-q"]);
    let scene = |mesh: &str, set: &str| {
        let object = format!("\n[[objects]]\nname = \"thing\"\nmesh = \"{mesh}\"\nproxy = {{ file = \"{set}\" }}\n");
        fs::write(folder.join("with.toml"), SCENE.to_owned() + &object).unwrap();
    };
    scene("m.obj", "set.json");
    succeed(folder, &["render", "with.toml", "-q"]);
    fs::remove_file(folder.join("lobes.png")).unwrap();
    let set = fs::read_to_string(folder.join("set.json")).unwrap();
    let first = set.find("    [").unwrap();
    let (start, rest) = set.split_at(first);
    let row = rest.lines().next().unwrap();
    for bad in ["[NaN, 0, 0, 1],", "[1e99, 0, 0, 1],", "[0, 0, 0, -1],", "[null, 0, 0, 1],"] {
        fs::write(folder.join("bad.json"), format!("{start}    {bad}{}", &rest[row.len()..])).unwrap();
        scene("m.obj", "bad.json");
        refuse(folder, &["render", "with.toml"], "bad.json");
        refuse(folder, &["check", "with.toml"], "bad.json");
    }
    fs::create_dir(folder.join("sets")).unwrap();
    scene("m.obj", "sets");
    refuse(folder, &["check", "with.toml"], "a folder or a device, but no file");
    scene("m.obj", "absent.json");
    refuse(folder, &["check", "with.toml"], "there is no file");
    for (mesh, what) in [("larger.obj", "bounding box"), ("other.obj", "triangles")] {
        scene(mesh, "set.json");
        for command in ["render", "reference", "check"] {
            refuse(folder, &[command, "with.toml"], what);
        }
    }
    // Strategies with the true triangles do not read the set.
    succeed(folder, &["render", "with.toml", "-q", "--visibility", "rays"]);
}

/// A material that reflects more light than it receives gives a warning.
#[test]
fn too_bright_materials_are_told() {
    let folder = folder();
    let folder = folder.path();
    for (model, told) in [
        ("model = \"lambert\"\nalbedo = [0.2, 1.5, 0.2]", true),
        ("model = \"lambert\"\nalbedo = 1.0", false),
        ("model = \"modified-phong\"\nkd = 0.7\nks = 0.7\nexponent = 50", true),
        ("model = \"modified-phong\"\nkd = 0.6\nks = 0.4\nexponent = 50", false),
        ("model = \"neumann\"\nks = 1.0\nexponent = 20", false),
        ("model = \"half-vector\"\nlobes = [{ roughness = 0.3, f0 = 1.5 }]", true),
    ] {
        let scene = SCENE.replace("[[lights]]", &format!("[materials.m]\n{model}\n\n[[lights]]"));
        let scene = scene.replace("radius = 0.6 }", "radius = 0.6 }\nmaterial = \"m\"");
        fs::write(folder.join("m.toml"), scene).unwrap();
        let ran = lobes(folder, &["check", "m.toml"]);
        let stderr = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success() && stderr.contains("times the light it gets") == told, "{model}: {stderr}");
    }
}

/// The README's scene is one.
#[test]
fn the_scene_of_the_readme_renders() {
    let folder = folder();
    let folder = folder.path();
    let readme = include_str!("../../README.md");
    let scene = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    fs::write(folder.join("readme.toml"), scene).unwrap();
    fs::write(folder.join("model.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        .unwrap();
    let stats = json(folder, &["render", "readme.toml", "--size", "96x54", "--json", "-o", "readme.png"]);
    assert!(stats["counts"]["penumbra_points"].as_u64().unwrap() > 2, "{stats}");
}

/// Two objects in the same place are one; so is a sphere that an object names a thousand times.
#[test]
fn equal_spheres_are_one() {
    let folder = folder();
    let folder = folder.path();
    let start = SCENE.find("[[objects]]\nname = \"ball\"").unwrap();
    let end = SCENE.find("[[lights]]").unwrap();
    let sphere = &SCENE[start..end];
    fs::write(folder.join("two.toml"), SCENE.replace(sphere, &format!("{sphere}{sphere}"))).unwrap();
    let many = vec!["[0.0, 1.0, 0.0, 0.6]"; 1000].join(", ");
    let list = sphere.replace("sphere = { center = [0.0, 1.0, 0.0], radius = 0.6 }", &format!("spheres = [{many}]"));
    assert_ne!(list, sphere);
    fs::write(folder.join("many.toml"), SCENE.replace(sphere, &list)).unwrap();
    for visibility in ["spheres", "rays", "shadow-map"] {
        for scene in ["scene", "two", "many"] {
            let (file, out) = (format!("{scene}.toml"), format!("{scene}.exr"));
            succeed(folder, &["render", &file, "-o", &out, "--visibility", visibility, "-q"]);
        }
        let picture = |name: &str| fs::read(folder.join(name)).unwrap();
        assert!(picture("two.exr") == picture("scene.exr"), "{visibility}");
        assert!(picture("many.exr") == picture("scene.exr"), "{visibility}: many");
    }
}

#[test]
fn a_scene_without_lights_says_so() {
    let folder = folder();
    let folder = folder.path();
    let floor = "[[objects]]\nplane = { point = [0, 0, 0], normal = [0, 1, 0], size = 4 }\n";
    let told = |light: &str, further: &[&str]| {
        fs::write(folder.join("dark.toml"), format!("{floor}{light}")).unwrap();
        let out = lobes(folder, &[&["render", "dark.toml", "--size", "16x8", "-o", "dark.png"], further].concat());
        assert!(out.status.success());
        String::from_utf8_lossy(&out.stderr).into_owned()
    };
    assert!(told("", &[]).contains("has no light:") && !told("", &["--quiet"]).contains("has no light"));
    let sky = "[[lights]]\nkind = \"environment\"\nradiance = 0\n";
    assert!(told(sky, &[]).contains("has no light but a black sky:"));
}

/// As in a scene file.
#[test]
fn a_crease_angle_is_for_smooth_normals() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for normals in ["file", "face"] {
        let args = ["check", "m.obj", "--crease", "30", "--normals", normals];
        refuse(folder, &args, "--crease is for --normals smooth");
    }
    refuse(folder, &["check", "m.obj", "--crease", "30"], "--crease is for --normals smooth");
    succeed(folder, &["check", "m.obj", "--crease", "30", "--normals", "smooth"]);
}

/// Visibility as lobes gives the picture of visible fractions, within the accuracy of masks.
#[test]
fn lobes_of_visibility_give_the_same_picture() {
    let folder = folder();
    let folder = folder.path();
    for method in ["moments", "lobes"] {
        let output = format!("{method}.exr");
        succeed(folder, &["render", "scene.toml", "--quiet", "--method", method, "-o", &output]);
    }
    let [moments, lobes] = ["moments.exr", "lobes.exr"].map(|name| cosine_lobes::read_exr(&folder.join(name)).unwrap());
    let peak = moments.pixels().iter().map(|p| p.max_element()).fold(0.0, f32::max);
    let pairs = || moments.pixels().iter().zip(lobes.pixels());
    let most = pairs().map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
    assert!(most > 0.0 && most < 0.01 * peak, "{most} of {peak}");
    refuse(folder, &["render", "scene.toml", "--method", "lobes", "--device", "gpu", "-o", "a.png"], "by the CPU only");
}

/// A PNG file without an exposure has the metered one: of twice the light a stop less, the same for a part, a strategy, a frame.
#[test]
fn pictures_are_exposed_by_metering() {
    let folder = folder();
    let folder = folder.path();
    let exposure = |scene: &str, further: &[&str]| {
        json(folder, &[&["render", scene, "-o", "a.png", "--json", "-q"][..], further].concat())["exposure"].as_f64()
    };
    let metered = exposure("scene.toml", &[]).expect("metered");
    let picture = fs::read(folder.join("a.png")).unwrap();
    assert_eq!(exposure("scene.toml", &["--exposure", &metered.to_string()]), Some(metered));
    assert!(fs::read(folder.join("a.png")).unwrap() == picture);
    for further in [&["--visibility", "none"][..], &["--tiles", "1/2"], &["--samples", "4"], &["--tolerance", "0.05"]] {
        assert_eq!(exposure("scene.toml", further), Some(metered), "{further:?}");
    }
    fs::write(folder.join("bright.toml"), SCENE.replace("[20.0, 20.0, 20.0]", "[40.0, 40.0, 40.0]")).unwrap();
    assert_eq!(exposure("bright.toml", &[]), Some(((metered - 1.0) * 10.0).round() / 10.0));
    assert_eq!(exposure("scene.toml", &["--exposure", "-1.5"]), Some(-1.5));
    let linear = ["render", "scene.toml", "-o", "a.exr", "--json", "-q"];
    assert!(json(folder, &linear)["exposure"].is_null());
}

/// Sixteen bits are those of the linear picture; eight are within a level of them; tone maps change what is bright.
#[test]
fn png_files_have_depth_and_tone() {
    let folder = folder();
    let folder = folder.path();
    let at = |exposure: &str, name: &str, further: &[&str]| {
        let args = ["render", "scene.toml", "-q", "--exposure", exposure, "-o", name];
        succeed(folder, &[&args[..], further].concat());
        folder.join(name)
    };
    let render = |name: &str, further: &[&str]| at("1", name, further);
    let linear = cosine_lobes::read_exr(&render("a.exr", &[])).unwrap();
    let fine = image::open(render("a.png", &["--bits", "16", "--tone", "linear"])).unwrap();
    let image::DynamicImage::ImageRgb16(fine) = fine else { panic!("sixteen bits") };
    let [r, g, b] = linear.pixels()[1000].to_array().map(|x| 65535.0 * srgb(2.0 * x.clamp(0.0, 0.5)));
    let there = fine.get_pixel(1000 % fine.width(), 1000 / fine.width()).0.map(f32::from);
    assert!(there.iter().zip([r, g, b]).all(|(a, b)| (a - b).abs() < 1.0), "{there:?} {r} {g} {b}");
    let coarse = image::open(render("a.png", &["--tone", "linear"])).unwrap().into_rgb8();
    let levels = fine.as_raw().iter().zip(coarse.as_raw());
    assert!(levels.clone().all(|(f, c)| (f32::from(*f) / 257.0 - f32::from(*c)).abs() < 1.0));
    assert!(levels.clone().any(|(f, c)| (f32::from(*f) / 257.0).round() != f32::from(*c)), "dithered");
    let bytes = |further: &[&str]| fs::read(at("5", "b.png", further)).unwrap();
    let all = ["linear", "soft", "neutral", "agx"].map(|tone| bytes(&["--tone", tone]));
    assert!(all.iter().enumerate().all(|(i, a)| all[..i].iter().all(|b| a != b)), "four pictures");
    assert!(bytes(&[]) == all[1]);
    refuse(folder, &["render", "scene.toml", "--tone", "filmic", "-o", "c.png"], "--tone");
    refuse(folder, &["render", "scene.toml", "--bits", "12", "-o", "c.png"], "--bits");
}

/// The encoded value of a linear one in [0, 1].
fn srgb(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}
