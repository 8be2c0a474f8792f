use crate::context::Context;
use crate::{SCHEMA_EXAMPLE, load, load_with_warnings, scene_file};
use brdf::Material;
use glam::Vec3;
use lighting::Light;
use scene::{Projection, Proxy, Scene, SceneError, Shape, Strategy};
use shading::LightLobes;
use std::path::Path;

fn parse(text: &str) -> Result<Scene, SceneError> {
    scene_file::parse(Path::new("test.toml"), text, &mut Context::default()).map(|(scene, _)| scene)
}

/// A scene of one sphere, with something more.
fn with(more: &str) -> String {
    format!("[[objects]]\nsphere = {{ center = [0, 0, 0], radius = 1 }}\n{more}")
}

/// The message, which is one line and names the file and the line.
fn refused(text: &str, line: usize, words: &[&str]) {
    let message = parse(text).expect_err(text).to_string();
    assert!(message.starts_with(&format!("test.toml:{line}:")), "{message}\nfor\n{text}");
    assert!(!message.contains('\n'), "{message}");
    for word in words {
        assert!(message.contains(word), "{message} lacks {word:?}");
    }
}

#[test]
fn the_example_is_a_valid_scene_with_every_key() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.toml"), SCHEMA_EXAMPLE).unwrap();
    std::fs::write(folder.path().join("example.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(folder.path().join("example.spheres.json"), "{}").unwrap();
    image::RgbaImage::from_pixel(2, 2, image::Rgba([200, 100, 50, 255]))
        .save(folder.path().join("example.png"))
        .unwrap();
    let (scene, warnings) = load_with_warnings(folder.path().join("scene.toml")).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!((scene.width, scene.height), (640, 360));
    assert_eq!(scene.objects.len(), 6);
    assert_eq!(scene.lights.len(), 37);
    // Φ = 4π²·L·Σr² of the three spheres.
    let flux = |l: &Light| l.full_radiance().x * l.sphere().expect("a sphere").radius.powi(2);
    let flux: f32 = scene.lights[2..5].iter().map(flux).sum::<f32>();
    assert!((flux * 4.0 * std::f32::consts::PI.powi(2) - 30.0).abs() < 1e-3);
    let crate_box = &scene.objects[4];
    assert_eq!(scene.objects[0].strategy, Some(Strategy::Silhouettes));
    // 0.8·0.9 turned by 30° about y: half-extent 0.36·(cos 30° + sin 30°).
    let size = crate_box.shape.bounds().size();
    assert!((size - Vec3::new(0.983_54, 0.72, 0.983_54)).length() < 1e-4, "{size}");
    assert_eq!(crate_box.proxy, Proxy::Count(32));
    let model = scene.objects[5].shape.bounds();
    assert!((model.min - Vec3::new(-0.4, 0.1, 1.4)).length() < 1e-6, "{model:?}");
    assert!(matches!(scene.objects[5].proxy, Proxy::File { .. }));
}

#[test]
fn projections() {
    let camera = |keys: &str| {
        let text = with(&format!("[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n{keys}"));
        parse(&text).unwrap().camera.projection
    };
    assert_eq!(camera("projection = \"perspective\"\nfov = 90"), Projection::perspective(90_f32.to_radians()));
    assert_eq!(camera("projection = \"perspective\""), camera(""));
    assert_eq!(camera("projection = \"orthographic\"\nheight = 2.5"), Projection::Orthographic { height: 2.5 });
    assert_eq!(camera("projection = \"panoramic\""), Projection::Panoramic);
}

#[test]
fn an_orthographic_height_has_keys() {
    let keys = "keys = [{ time = 0 }, { time = 2, height = 6 }]";
    let text = with(&format!(
        "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nprojection = \"orthographic\"\nheight = 2\n{keys}"
    ));
    let (mut scene, animation) = scene_file::parse(Path::new("test.toml"), &text, &mut Context::default()).unwrap();
    animation.seek(1.0, &mut scene);
    assert_eq!(scene.camera.projection, Projection::Orthographic { height: 4.0 });
    let wrong = |from: &str, to: &str| parse(&text.replace(from, to)).expect_err(to).to_string();
    assert!(wrong("height = 6", "height = -6").contains("at 2 s: camera height is -6"));
    assert!(wrong("height = 6", "fov = 6").contains("fov"));
}

#[test]
fn defaults() {
    let scene = parse(&with("")).unwrap();
    assert_eq!((scene.width, scene.height), (960, 540));
    assert!(scene.lights.is_empty());
    assert_eq!(scene.materials, [Material::lambert(Vec3::splat(0.5))]);
    assert!(matches!(&scene.objects[0].proxy, Proxy::Spheres(s) if s.len() == 1));
    let scene = parse("[[objects]]\nbox = { center = [0, 0, 0], size = [1, 1, 1] }").unwrap();
    assert_eq!(scene.objects[0].proxy, Proxy::Count(64));
    let scene = parse("[[objects]]\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }").unwrap();
    assert_eq!(scene.objects[0].proxy, Proxy::None);
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    assert!((mesh.area() - 1e4).abs() < 1e-2);
}

#[test]
fn each_object_names_its_strategy() {
    for strategy in Strategy::ALL {
        let scene = parse(&with(&format!("visibility = \"{}\"", strategy.name()))).unwrap();
        assert_eq!(scene.objects[0].strategy, Some(strategy));
    }
    assert_eq!(parse(&with("")).unwrap().objects[0].strategy, None);
}

#[test]
fn bad_input_is_refused_in_one_line_with_its_place() {
    refused("a = ", 1, &[]);
    refused("a = 1\na = 2\n", 2, &["duplicate key"]);
    refused("", 1, &["no objects"]);
    refused(&with("colour = 3"), 3, &["unknown key \"colour\"", "\"material\""]);
    refused(&with("[image]\nwidth = 0"), 4, &["width", "1 to 16384"]);
    refused(&with("[image]\nheight = 16385"), 4, &["height"]);
    refused(&with("[image]\nheight = 5.5"), 4, &["whole number"]);
    refused(&with("[image]\nsize = 5"), 4, &["unknown key \"size\"", "\"width\", \"height\""]);
    let camera = |keys: &str| with(&format!("[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n{keys}"));
    refused(&camera("fov = 0"), 6, &["between 0 and 180"]);
    refused(&camera("fov = 180"), 6, &["between 0 and 180"]);
    refused(&camera("fov = nan"), 6, &["finite"]);
    refused(&camera("fov = 0.0005\nup = [0, 1, 0]"), 6, &["field of view", "0.001"]);
    for (height, line, message) in [
        ("0", 7, "more than 0"),
        ("-1", 7, "more than 0"),
        ("nan", 7, "finite"),
        ("inf", 7, "finite"),
        ("\"high\"", 7, "string"),
    ] {
        refused(&camera(&format!("projection = \"orthographic\"\nheight = {height}")), line, &[message]);
    }
    refused(&camera("projection = \"orthographic\""), 3, &["needs a height"]);
    refused(
        &camera("projection = \"orthographic\"\nheight = 2\nfov = 30"),
        8,
        &["another projection", "\"orthographic\""],
    );
    refused(&camera("height = 2"), 6, &["another projection", "\"perspective\""]);
    refused(&camera("projection = \"panoramic\"\nfov = 30"), 7, &["another projection", "\"panoramic\""]);
    refused(&camera("projection = \"fisheye\""), 6, &["fisheye", "\"panoramic\""]);
    refused(&camera("projection = 3"), 6, &["string"]);
    refused(&camera("up = [0, 0, 0]"), 6, &["length zero"]);
    refused(&camera("up = [0, 0, -2]"), 6, &["parallel"]);
    refused(&camera("up = [0, 1]"), 6, &["[x, y, z]", "2 values"]);
    refused(&camera("up = \"y\""), 6, &["found a string"]);
    refused(&with("[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]"), 5, &["same point"]);
    refused(&with("[camera]\neye = [1, inf, 3]\ntarget = [1, 2, 3]"), 4, &["finite"]);
    refused(&with("[camera]\neye = [1, 1e39, 3]\ntarget = [1, 2, 3]"), 4, &["1e39"]);
    refused(&with("[camera]\neye = [1, 2, 3]"), 3, &["\"target\" is missing"]);
    refused(&with("material = \"brass\""), 3, &["[materials.brass]"]);
    refused(&with("visible = 1"), 3, &["true or false"]);
    refused(&with("visibility = \"lasers\""), 3, &["lasers", "\"shadow-map\""]);
    refused(&with("visibility = true"), 3, &["a string"]);
    refused(&with("scale = 0"), 3, &["must not be 0"]);
    refused(&with("scale = [1, 2, 1]"), 3, &["uniformly"]);
    refused(&with("rotate = { axis = [0, 0, 0], degrees = 3 }"), 3, &["length zero"]);
    refused(&with("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]"), 3, &["four rows"]);
    refused(&with("matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]"), 3, &["last row"]);
    refused(&with("scale = 2\nmatrix = 3"), 4, &["not both"]);
    refused(&with("proxy = \"all\""), 3, &["\"none\""]);
    refused(&with("proxy = 7"), 3, &["\"none\""]);
    refused(&with("proxy = { spheres = 0 }"), 3, &["1 to 100000"]);
    refused(&with("proxy = { file = \"absent.json\" }"), 3, &["absent.json"]);
    refused(&with("proxy = { explicit = [] }"), 3, &["at least one"]);
    refused(&with("normals = \"flat\""), 3, &["\"smooth\""]);
    refused("[[objects]]\nname = \"x\"", 1, &["\"quad\"", "\"mesh\""]);
    refused(&with("quad = { center = [0, 0, 0], u = [1, 0, 0], v = [0, 1, 0] }"), 2, &["only one of"]);
    refused("[[objects]]\nsphere = { center = [0, 0, 0], radius = -1 }", 2, &["greater than 0"]);
    refused("[[objects]]\nsphere = { center = [0, 0, 0], radius = 0 }", 2, &["greater than 0"]);
    refused("[[objects]]\nspheres = [[0, 0, 0, 1],\n [0, 0, 0, 0]]", 3, &["greater than 0"]);
    refused("[[objects]]\nspheres = []", 2, &["at least one"]);
    refused("[[objects]]\nquad = { center = [0, 0, 0], u = [1, 0, 0], v = [2, 0, 0] }", 2, &["parallel"]);
    refused("[[objects]]\nquad = { center = [0, 0, 0], u = [1, 0, 0], v = [0, 3e19, 0] }", 2, &["v", "3.000e19"]);
    refused("[[objects]]\nplane = { point = [0, 0, 0], normal = [0, 0, 0] }", 2, &["length zero"]);
    refused("[[objects]]\nbox = { center = [0, 0, 0], size = [1, 0, 1] }", 2, &["greater than 0"]);
    refused("[[objects]]\n\nmesh = \"absent.obj\"", 3, &["absent.obj", "cannot read"]);
    refused("[[objects]]\nmesh = \"mesh.stl\"", 2, &["mesh.stl"]);
    let material = |keys: &str| with(&format!("[materials.m]\n{keys}"));
    refused(&material("albedo = 1"), 3, &["\"model\" is missing"]);
    refused(&material("model = \"wood\""), 4, &["wood", "lafortune"]);
    refused(&material("model = \"lambert\"\nalbedo = [1, -1, 0]"), 5, &["negative"]);
    refused(&material("model = \"lambert\"\nalbedo = 1\nks = 2"), 6, &["unknown key \"ks\""]);
    refused(&material("model = \"phong\"\nkd = 1\nks = 1\nexponent = 2e7"), 3, &["1e7"]);
    refused(&material("model = \"phong\"\nkd = 1"), 3, &["\"exponent\" is missing"]);
    refused(&material("model = \"neumann\"\nks = 1\nexponent = 0.5"), 3, &["[1, 1e7]"]);
    refused(&material("model = \"half-vector\"\nlobes = [{ roughness = 2, f0 = 1 }]"), 5, &["[0, 1]"]);
    refused(&material("model = \"half-vector\"\nlobes = [{ roughness = 0.2 }]"), 5, &["f0"]);
    refused(&material("model = \"lafortune\"\nlobes = [{ c = [1, 1, 1], exponent = 2 }]"), 5, &["scale"]);
    refused(
        &material(
            "model = \"lafortune\"\nlobes = [{ matrix = [[1, 2, 0], [0, 1, 0], [0, 0, 1]], exponent = 2, scale = 1 }]",
        ),
        5,
        &["symmetric"],
    );
    let light = |keys: &str| with(&format!("[[lights]]\n{keys}"));
    refused(&light("kind = \"laser\""), 4, &["laser", "\"sphere\""]);
    refused(&light("kind = \"sphere\"\ncenter = [0, 1, 0]\nradius = 0\nflux = 1"), 6, &["greater than 0"]);
    refused(&light("kind = \"sphere\"\ncenter = [0, 1, 0]\nradius = 1"), 3, &["\"radiance\", \"flux\""]);
    refused(&light("kind = \"sphere\"\ncenter = [0, 1, 0]\nradius = 1\nflux = -1"), 7, &["negative"]);
    refused(&light("kind = \"sphere\"\ncenter = [0, 1, 0]\nradius = 1e-30\nflux = 1"), 7, &["too large"]);
    refused("background = -1", 1, &["negative"]);
}

#[test]
fn faults_of_a_mesh_name_both_files_and_lines() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bad.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    std::fs::write(folder.path().join("flat.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").unwrap();
    for (file, words) in [("bad.obj", "bad.obj:4: face uses vertex 9"), ("flat.obj", "no triangles")] {
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, format!("\n[[objects]]\nmesh = \"{file}\"\n")).unwrap();
        let message = load(&path).unwrap_err().to_string();
        assert!(message.contains("scene.toml:3:") && message.contains(words), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
    let message = load(folder.path().join("absent.toml")).unwrap_err().to_string();
    assert!(message.contains("absent.toml: cannot read"), "{message}");
    let message = load(folder.path()).unwrap_err().to_string();
    assert!(message.contains("not a regular file"), "{message}");
}

/// Names and comments may be in any encoding, numbers may not.
#[test]
fn names_in_any_encoding() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    let mesh = b"# caf\xe9\no caf\xe9\nv 0 0 0\nv 1 0 0 # \xff\nv 0 1 0\nusemtl \xfc\nf 1 2 3\n";
    std::fs::write(&path, mesh).unwrap();
    assert_eq!(load(&path).unwrap().triangles(), 3);
    std::fs::write(&path, b"v 0 0 0\nv 1\xe9 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let message = load(&path).unwrap_err().to_string();
    assert!(message.contains("a.obj:2:") && message.contains("UTF-8"), "{message}");
}

#[test]
fn huge_and_tiny_scenes_are_fine() {
    for scale in ["1e-4", "1e6"] {
        parse(&with(&format!("scale = {scale}"))).unwrap();
    }
    parse(&with("translate = [1e6, -1e6, 1e6]")).unwrap();
    let message = parse(&with("translate = [2e9, 0, 0]")).unwrap_err().to_string();
    assert!(message.contains("1e9"), "{message}");
}

#[test]
fn misspelt_keys_are_named_where_a_required_one_is_missing() {
    refused("[[objects]]\nsphere = { center = [0, 0, 0],\nradus = 1 }", 3, &["\"radius\" is missing", "\"radus\""]);
    refused("[[objects]]\nspere = { center = [0, 0, 0], radius = 1 }", 2, &["\"sphere\"", "unknown key \"spere\""]);
    refused("[materials.a]\nmodel = \"lambert\"\nalbdo = 1", 3, &["\"albedo\" is missing", "\"albdo\""]);
    // Nothing alike: the head of the table, as before.
    refused("[[objects]]\nquad = { center = [0, 0, 0], v = [0, 0, 1] }", 2, &["\"u\" is missing"]);
}

#[test]
fn spheres_too_large_for_single_precision_are_refused() {
    let ground = |radius: &str, height: f32| {
        format!(
            "[camera]\neye = [0, {height}, 6]\ntarget = [0, 0, 0]\n\
             [[objects]]\nname = \"ground\"\nsphere = {{ center = [0, -{radius}, 0], radius = {radius} }}"
        )
    };
    parse(&ground("1e6", 2.0)).unwrap();
    for radius in ["1e7", "1e8", "5e8"] {
        let message = parse(&ground(radius, 2.0)).unwrap_err().to_string();
        assert!(message.contains("ground") && message.contains("or a plane"), "{message}");
    }
    // A thousand times farther away it is as good as the first.
    parse(&ground("1e9", 2e3)).unwrap();
}

#[test]
fn metallic_roughness_materials_are_read_and_checked() {
    let material = |more: &str| format!("[materials.m]\nmodel = \"metallic-roughness\"\n{more}\n");
    let scene = parse(&format!(
        "{}[[objects]]\nbox = {{ center = [0, 0, 0], size = [1, 1, 1] }}\nmaterial = \"m\"",
        material("base = 0.5\nroughness = 0.2")
    ))
    .unwrap();
    let want = brdf::MetallicRoughness::new(Vec3::splat(0.5), 1.0, 0.2).unwrap();
    assert_eq!(scene.materials[0], want.into());
    refused(&material("base = 1.5"), 2, &["base is 1.5"]);
    refused(&material("roughness = 0.5"), 1, &["\"base\" is missing"]);
}

#[test]
fn sets_in_files_do_not_follow_spheres() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("set.json"), "{}").unwrap();
    let path = folder.path().join("scene.toml");
    let sphere = "[[objects]]\nsphere = { center = [0, 0, 0], radius = 1 }\nproxy = { file = \"set.json\" }\n";
    std::fs::write(&path, sphere).unwrap();
    load(&path).unwrap();
    std::fs::write(&path, format!("{sphere}keys = [{{ time = 0 }}, {{ time = 1, translate = [1, 0, 0] }}]\n")).unwrap();
    let message = load(&path).unwrap_err().to_string();
    assert!(message.contains("scene.toml:2:") && message.contains("does not follow them"), "{message}");
}

#[test]
fn sets_in_files_are_scaled_uniformly() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(folder.path().join("set.json"), "{}").unwrap();
    let path = folder.path().join("scene.toml");
    let read = |placed: &str| {
        let object = "[[objects]]\nmesh = \"m.obj\"\nproxy = { file = \"set.json\" }\n";
        std::fs::write(&path, format!("{object}{placed}\n")).unwrap();
        load(&path)
    };
    let scene = read("scale = -2\ntranslate = [1, 2, 3]").unwrap();
    let Proxy::File { placement, .. } = &scene.objects[0].proxy else { panic!() };
    assert_eq!(placement.transform_point3(Vec3::new(1.0, 0.0, 1.0)), Vec3::new(-1.0, 2.0, 1.0));
    let uneven = "matrix = [[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
    for (placed, line) in [("scale = [1, 2, 1]", 4), (uneven, 4), ("keys = [{ time = 0, scale = [1, 2, 1] }]", 3)] {
        let message = read(placed).unwrap_err().to_string();
        assert!(message.contains(&format!("scene.toml:{line}:")) && message.contains("uniformly"), "{message}");
    }
}

#[test]
fn what_lies_too_far_is_told_at_its_line() {
    let sphere = "[[objects]]\nsphere = { center = [0, 0, 0], radius = 1 }\n";
    let camera = |eye: &str, target: &str| {
        format!("[camera]\neye = [{eye}, 0, 5]\nfov = 30\nup = [0, 1, 0]\ntarget = [{target}, 0, 0]\n{sphere}")
    };
    refused(&camera("1e30", "0"), 2, &["eye", "1e9"]);
    refused(&camera("0", "-2e9"), 5, &["target", "1e9"]);
    let light = "[[lights]]\nkind = \"sphere\"\nradiance = 1\nradius = 1\ncenter = [0, 3e9, 0]";
    refused(&format!("{sphere}{light}"), 7, &["1e9"]);
    let lights = "[[lights]]\nkind = \"spheres\"\nradiance = 1\nspheres = [[0, 3e9, 0, 1]]";
    refused(&format!("{sphere}{lights}"), 6, &["1e9"]);
    refused("[[objects]]\nname = \"far\"\nsphere = { center = [2e9, 0, 0], radius = 1 }", 3, &["1e9"]);
    refused("[[objects]]\nname = \"far\"\nspheres = [[0, 0, 0, 2e9]]", 3, &["1e9"]);
    refused("[[objects]]\nname = \"far\"\ntranslate = [2e9, 0, 0]\nspheres = [[0, 0, 0, 1]]", 4, &["1e9"]);
    refused(&format!("{sphere}proxy = {{ explicit = [[0, 0, 2e9, 1]] }}"), 3, &["1e9"]);
}

#[test]
fn lights_of_all_kinds_are_read() {
    let sphere = "[[objects]]\nsphere = { center = [0, 0, 0], radius = 1 }\n";
    let read = |light: &str| parse(&format!("{sphere}[[lights]]\n{light}")).unwrap().lights[0].clone();
    let Light::Flat(panel) = read("kind = \"rectangle\"\ncenter = [0, 3, 0]\nu = [1, 0, 0]\nv = [0, 0, 2]\nflux = 8")
    else {
        panic!()
    };
    assert!((panel.area() - 8.0).abs() < 1e-5 && (panel.normal() - Vec3::NEG_Y).length() < 1e-6);
    // L = Φ/(πA).
    assert!((panel.radiance.x - std::f32::consts::FRAC_1_PI).abs() < 1e-6 && !panel.two_sided);
    let disc = "kind = \"disc\"\ncenter = [0, 3, 0]\nnormal = [0, -2, 0]\nradius = 0.5\nradiance = [1, 2, 3]\ntwo_sided = true";
    let Light::Flat(disc) = read(disc) else { panic!() };
    assert!(disc.two_sided && disc.as_disc() == (Vec3::Y * 3.0, Some(0.5)) && disc.radiance.z == 3.0);
    let Light::Flat(corners) = read("kind = \"polygon\"\ncorners = [[0, 3, 0], [1, 3, 0], [0, 3, 1]]\nradiance = 1")
    else {
        panic!()
    };
    assert_eq!(corners.corners().len(), 3);
    let Light::Tube(tube) = read("kind = \"tube\"\nfrom = [0, 3, 0]\nto = [1, 3, 0]\nradius = 0.1\nflux = 1") else {
        panic!()
    };
    assert!((tube.radiance.x * std::f32::consts::PI * tube.area() - 1.0).abs() < 1e-5);
    let Light::Sphere(point) = read("kind = \"point\"\ncenter = [0, 3, 0]\nintensity = 2") else { panic!() };
    assert!((point.radiance.x * std::f32::consts::PI * point.sphere.radius.powi(2) - 2.0).abs() < 1e-5);
    let spot = "kind = \"spot\"\ncenter = [0, 3, 0]\ndirection = [0, -3, 0]\nangle = 60\ninner = 0\nintensity = 2";
    let Light::Spot(spot) = read(spot) else { panic!() };
    assert!((spot.cos[1] - 0.5).abs() < 1e-6 && spot.axis == Vec3::NEG_Y);
    let Light::Sun(sun) = read("kind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 3") else { panic!() };
    assert!(sun.toward == Vec3::Y && (sun.sin.asin().to_degrees() - 0.265).abs() < 1e-5);
    assert!((sun.radiance.x * std::f32::consts::PI * sun.sin.powi(2) - 3.0).abs() < 1e-4);
    let Light::Ambient(ambient) = read("kind = \"ambient\"\nradiance = 0.5") else { panic!() };
    assert_eq!(ambient.radiance, Vec3::splat(0.5));
    // Hidden by objects, it is a part of the environment, whose lights stand where its first table does.
    let occluded = "[[lights]]\nkind = \"ambient\"\nradiance = 0.5\noccluded = true\n";
    let lamp = "[[lights]]\nkind = \"point\"\ncenter = [0, 3, 0]\nintensity = 2\nkeys = [{ time = 0 }, { time = 1, translate = [0, 1, 0] }]\n";
    let text = format!("{sphere}{occluded}{lamp}{occluded}");
    let (scene, animation) = scene_file::parse(Path::new("test.toml"), &text, &mut Context::default()).unwrap();
    assert_eq!(animation.lights[0].first, 6);
    let environment = scene.environment.unwrap();
    assert_eq!((environment.map().radiance(Vec3::Z), environment.behind()), (Vec3::ONE, None));
    assert!(scene.lights.len() == 7 && matches!(scene.lights[6], Light::Sphere(_)));
    let sky = "kind = \"environment\"\nradiance = [1, 2, 3]\nstrength = 2\npatches = 1";
    let scene = parse(&format!("{sphere}[[lights]]\n{sky}")).unwrap();
    assert!(scene.lights.len() == 6 && scene.environment.unwrap().map().radiance(Vec3::Z) == Vec3::new(2.0, 4.0, 6.0));
    let scene = parse(&format!("{sphere}[[lights]]\n{sky}\n{occluded}")).unwrap();
    let environment = scene.environment.unwrap();
    assert_eq!(environment.map().radiance(Vec3::Z), Vec3::new(2.5, 4.5, 6.5));
    assert_eq!(environment.behind().unwrap().radiance(Vec3::Z), Vec3::new(2.0, 4.0, 6.0));
    // They turn and move as objects do.
    let keys =
        "keys = [{ time = 0 }, { time = 1, rotate = { axis = [1, 0, 0], degrees = 90 }, translate = [0, 1, 0] }]";
    let text = format!(
        "{sphere}[[lights]]\nkind = \"rectangle\"\ncenter = [0, 3, 0]\nu = [1, 0, 0]\nv = [0, 0, 1]\nradiance = 1\n{keys}"
    );
    let (mut scene, animation) = scene_file::parse(Path::new("t.toml"), &text, &mut Context::default()).unwrap();
    animation.seek(1.0, &mut scene);
    let Light::Flat(moved) = &scene.lights[0] else { panic!() };
    assert!((moved.as_disc().0 - Vec3::new(0.0, 1.0, 3.0)).length() < 1e-5);
    assert!((moved.normal() - Vec3::NEG_Z).length() < 1e-5);
}

#[test]
fn lights_that_are_none_are_refused() {
    let sphere = "[[objects]]\nsphere = { center = [0, 0, 0], radius = 1 }\n";
    let light = |text: &str| format!("{sphere}[[lights]]\n{text}");
    refused(&light("kind = \"lamp\"\nradiance = 1"), 4, &["lamp", "\"tube\""]);
    refused(
        &light("kind = \"rectangle\"\ncenter = [0, 3, 0]\nu = [1, 0, 0]\nv = [2, 0, 0]\nradiance = 1"),
        7,
        &["v: u and v are parallel"],
    );
    refused(
        &light("kind = \"rectangle\"\ncenter = [0, 3, 0]\nu = [1e30, 0, 0]\nv = [0, 0, 1]\nradiance = 1"),
        6,
        &["u: half a side is 1.000e30 long: expected at most 1e9"],
    );
    refused(
        &light("kind = \"rectangle\"\ncenter = [0, 3, 0]\nu = [0, 0, 0]\nv = [2, 0, 0]\nradiance = 1"),
        6,
        &["u: vector has length zero"],
    );
    refused(&light("kind = \"disc\"\ncenter = [0, 3, 0]\nnormal = [0, 0, 0]\nradius = 1\nradiance = 1"), 6, &["0"]);
    refused(&light("kind = \"polygon\"\nradiance = 1\ncorners = [[0, 0, 0], [1, 0, 0]]"), 6, &["3 to 24 corners"]);
    refused(
        &light("kind = \"polygon\"\nradiance = 1\ncorners = [[0, 0, 0], [1, 0, 0], [0.2, 0.2, 0], [0, 1, 0]]"),
        6,
        &["not convex"],
    );
    refused(&light("kind = \"tube\"\nfrom = [0, 3, 0]\nto = [0, 3, 0]\nradius = 0.1\nflux = 1"), 6, &["two ends"]);
    refused(&light("kind = \"sun\"\nirradiance = 1\ndirection = [0, -1, 0]\nangle = 190"), 7, &["120 degrees"]);
    refused(
        &light("kind = \"spot\"\ncenter = [0, 3, 0]\ndirection = [0, -1, 0]\nintensity = 1\nangle = 95"),
        8,
        &["90"],
    );
    let inner = "kind = \"spot\"\ncenter = [0, 3, 0]\ndirection = [0, -1, 0]\nintensity = 1\nangle = 20\ninner = 30";
    refused(&light(inner), 9, &["angle"]);
    refused(&light("kind = \"tube\"\nfrom = [0, 3, 0]\nto = [0, 4, 0]\nradius = 0.1\nradiance = -1"), 8, &["-1"]);
    refused(&light("kind = \"ambient\"\nradiance = -1"), 5, &["-1"]);
    refused(&light("kind = \"environment\"\nfile = \"none.hdr\""), 5, &["none.hdr"]);
    refused(&light("kind = \"environment\"\nradiance = 1\npatches = 40"), 6, &["40"]);
    refused(
        &light("kind = \"environment\"\nradiance = 1\n[[lights]]\nkind = \"environment\"\nradiance = 1"),
        7,
        &["already"],
    );
    refused(
        &light(
            "kind = \"rectangle\"\ncenter = [0, 3, 0]\nu = [1, 0, 0]\nv = [0, 0, 1]\nradiance = 1\nimage = \"none.png\"",
        ),
        9,
        &["none.png"],
    );
    refused(
        &light("kind = \"rectangle\"\ncenter = [0, 3e9, 0]\nu = [1e6, 0, 0]\nv = [0, 0, 1e6]\nradiance = 1"),
        4,
        &["1e9"],
    );
}

/// Objects that light the scene: spheres and boxes become exact lights, others are refused at their key.
#[test]
fn emission_lights_where_it_is_asked_for() {
    let text = |shape: &str, emission: &str, more: &str| {
        format!(
            "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = {emission}\n[[objects]]\nmaterial = \"lamp\"\n{shape}\nlight = true\n{more}"
        )
    };
    let cube = "box = { center = [0, 3, 0], size = [1, 0.1, 1] }";
    let lights = |text: &str| parse(text).expect("a scene").lights;
    let faces = lights(&text(cube, "[2, 1, 0]", ""));
    assert_eq!(faces.len(), 6);
    assert!(faces.iter().all(|l| l.name() == "flat" && l.full_radiance() == Vec3::new(2.0, 1.0, 0.0)));
    let sphere = lights(&text("sphere = { center = [0, 3, 0], radius = 0.5 }", "[1, 1, 1]", ""));
    assert_eq!(sphere[0].sphere().map(|b| b.radius), Some(0.5));
    assert!(lights(&text(cube, "[1, 1, 1]", "").replace("true", "false")).is_empty());
    // A sphere at a light shows it only with an emission of its own: the light does not light its surface.
    for (emission, count) in [("[1, 1, 1]", 0), ("[0, 0, 0]", 1)] {
        let lamp = text("sphere = { center = [0, 3, 0], radius = 0.5 }", emission, "").replace("light = true\n", "");
        let lamp = lamp + "[[lights]]\nkind = \"sphere\"\ncenter = [0, 3, 0]\nradius = 0.5\nradiance = 1\n";
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lamp.toml");
        std::fs::write(&path, lamp).expect("a file");
        let (_, warnings) = load_with_warnings(&path).expect("a scene");
        assert_eq!(warnings.iter().filter(|w| w.contains("no `emission`")).count(), count, "{warnings:?}");
    }
    refused(&text(cube, "[0, 0, 0]", ""), 8, &["no emission"]);
    refused(&text(cube, "[1, 1, 1]", "").replace("true", "1"), 8, &["true or false"]);
    let keys = "keys = [{ time = 0 }, { time = 1, translate = [1, 0, 0] }]\n";
    let (mut scene, animation) =
        scene_file::parse(Path::new("test.toml"), &text(cube, "[1, 1, 1]", keys), &mut Context::default())
            .expect("a scene");
    let still = scene.lights.clone();
    animation.seek(0.5, &mut scene);
    for (light, before) in scene.lights.iter().zip(&still) {
        let moved = light.bounds().center - before.bounds().center;
        assert!(moved.abs_diff_eq(Vec3::X * 0.5, 1e-5), "{moved}");
        assert_eq!(light.name(), "flat");
    }
    let grows = "keys = [{ time = 0 }, { time = 1, scale = 2 }]\n";
    refused(&text(cube, "[1, 1, 1]", grows), 8, &["keeps its size"]);
}

/// A ring and a column of an OBJ file, whose walls have so many sides.
fn curved(is_ring: bool, [sides, rows]: [u32; 2]) -> String {
    let turn = |k: u32, n: u32| (std::f32::consts::TAU * k as f32 / n as f32).sin_cos();
    let mut text = String::new();
    for j in 0..rows {
        for i in 0..sides {
            let ((s, c), (sin, cos)) = (turn(i, sides), turn(j, rows));
            let [x, y, z] = if is_ring {
                [(1.0 + 0.2 * c) * cos, 0.2 * s, (1.0 + 0.2 * c) * sin]
            } else {
                [0.1 * c, 2.0 * j as f32 / (rows - 1) as f32, 0.1 * s]
            };
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for j in 0..if is_ring { rows } else { rows - 1 } {
        for i in 0..sides {
            let corner = |i: u32, j: u32| (j % rows) * sides + i % sides + 1;
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

/// Curved meshes that light the scene become spheres and tubes, which the mesh does not hide; a warning states the error.
#[test]
fn curved_meshes_light_as_spheres_and_tubes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("test.toml");
    std::fs::write(folder.path().join("column.obj"), curved(false, [32, 2])).expect("a file");
    std::fs::write(folder.path().join("ring.obj"), curved(true, [16, 48])).expect("a file");
    let text = |mesh: &str, more: &str| {
        format!(
            "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = [2, 1, 0]\n[[objects]]\nmaterial = \"lamp\"\n\
             mesh = \"{mesh}.obj\"\nlight = true\n{more}"
        )
    };
    let read = |text: &str| {
        let mut context = Context::default();
        let (scene, animation) = scene_file::parse(&path, text, &mut context)?;
        Ok::<_, SceneError>((scene, animation, context.warnings))
    };
    let (scene, _, warnings) = read(&text("column", "")).expect("a scene");
    let [Light::Enclosed(light)] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    let Light::Tube(tube) = *light.light else { panic!("{light:?}") };
    assert_eq!(light.object, 0);
    assert!((tube.radius - 0.1).abs() < 0.005 && (tube.radiance / Vec3::new(2.0, 1.0, 1.0)).x > 0.97, "{tube:?}");
    assert_eq!((scene.objects[0].strategy, warnings.len()), (Some(Strategy::None), 0));
    let (ring, _, warnings) = read(&text("ring", "")).expect("a scene");
    assert!(ring.lights.len() > 3 && warnings.len() == 1 && warnings[0].contains("spheres and tubes"), "{warnings:?}");
    let keys = "keys = [{ time = 0 }, { time = 1, translate = [1, 0, 0] }]\n";
    let (mut scene, animation, _) = read(&text("column", keys)).expect("a scene");
    let before = scene.lights[0].bounds().center;
    animation.seek(1.0, &mut scene);
    assert!((scene.lights[0].bounds().center - before).abs_diff_eq(Vec3::X, 1e-5));
    let message =
        read(&text("column", "visibility = \"rays\"")).map(|_| ()).expect_err("it would hide its light").to_string();
    assert!(message.contains(":8:") && message.contains("hides nothing"), "{message}");
}
