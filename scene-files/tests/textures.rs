//! Images of scene files, OBJ and glTF: their placement, and the images that are refused.

use brdf::{Material, MetallicRoughness, Phong};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;
use image::{Rgb, RgbImage, Rgba, RgbaImage};
use scene::{Encoding, Shape, Surface, TexturePlace, Wrap};
use scene_files::load_with_warnings;
use std::path::Path;

/// Two by two texels: red, green; blue, white.
fn write_quarters(folder: &Path, name: &str) {
    let texels = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
    let image = RgbImage::from_fn(2, 2, |x, y| Rgb(texels[(2 * y + x) as usize]));
    image.save(folder.join(name)).expect("an image");
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

const QUAD: &str = "[[objects]]\nquad = { center = [0, 0, 0], u = [1, 0, 0], v = [0, 1, 0] }\nmaterial = \"m\"\n";

fn load_material(folder: &Path, material: &str) -> Result<(Material, Surface), String> {
    let path = folder.join("scene.toml");
    std::fs::write(&path, format!("[materials.m]\n{material}\n{QUAD}")).expect("a file");
    let (scene, _) = load_with_warnings(&path).map_err(|e| e.to_string())?;
    Ok((scene.materials[0].clone(), scene.surface(0).cloned().unwrap_or_default()))
}

#[test]
fn a_scene_file_lays_images_on_materials() {
    let folder = folder();
    write_quarters(folder.path(), "a.png");
    let (material, surface) =
        load_material(folder.path(), "model = \"lambert\"\ncolor_map = \"a.png\"").expect("a scene");
    // The image alone is the colour.
    assert_eq!(material, Material::lambert(Vec3::ONE));
    let map = surface.color.expect("a map");
    assert_eq!((map.texture.size(), map.texture.encoding()), ([2, 2], Encoding::Srgb));

    let text = "model = \"metallic-roughness\"\nbase = [0.5, 0.6, 0.7]\nior = 2\n\
         color_map = { file = \"a.png\", scale = [2, 3], offset = [0.5, 0], wrap = \"mirror\", filter = \"nearest\" }\n\
         metallic_map = { file = \"a.png\", channel = \"blue\" }\nroughness_map = \"a.png\"\n\
         specular_map = \"a.png\"\ncoat_map = { file = \"a.png\", channel = \"alpha\" }\n\
         normal_map = { file = \"a.png\", strength = 0.25, rotate = 90 }\n\
         emission = [1, 2, 3]\nemission_map = \"a.png\"";
    let (material, surface) = load_material(folder.path(), text).expect("a scene");
    let want = MetallicRoughness::new(Vec3::new(0.5, 0.6, 0.7), 1.0, 1.0)
        .and_then(|m| m.with_coat(Vec3::splat((1.0_f32 / 3.0).powi(2)), 1.0));
    assert_eq!(material, want.expect("in range").into());
    let map = surface.color.expect("a map");
    assert!(map.is_pixelated && map.wrap == [Wrap::Mirror; 2]);
    assert_eq!(map.transform.transform_point2(glam::Vec2::ONE), glam::Vec2::new(2.5, 3.0));
    let channels = (surface.metallic.expect("a map"), surface.roughness.expect("a map"));
    assert_eq!((channels.0.index, channels.1.index, channels.0.map.texture.encoding()), (2, 0, Encoding::Linear));
    assert_eq!((surface.specular.is_some(), surface.coat.map(|c| c.index)), (true, Some(3)));
    assert!(channels.0.map.texture.is_same(&channels.1.map.texture), "one image in memory");
    assert_eq!(surface.normal.expect("a map").1, 0.25);
    assert_eq!(surface.emission, Vec3::new(1.0, 2.0, 3.0));
    assert!(surface.emission_map.is_some());

    let text = "model = \"metallic-roughness\"\nbase = 0.5\nclearcoat = 0.75\nclearcoat_roughness = 0.5\n\
         clearcoat_map = \"a.png\"\nclearcoat_roughness_map = { file = \"a.png\", channel = \"green\" }\n\
         clearcoat_normal_map = { file = \"a.png\", strength = 0.5 }";
    let (material, surface) = load_material(folder.path(), text).expect("a scene");
    let want = MetallicRoughness::new(Vec3::splat(0.5), 1.0, 1.0).and_then(|m| m.with_clearcoat(0.75, 0.5));
    assert_eq!(material, want.expect("in range").into());
    assert_eq!([surface.clearcoat, surface.clearcoat_roughness].map(|c| c.expect("a map").index), [0, 1]);
    assert_eq!(surface.clearcoat_normal.expect("a map").1, 0.5);

    let text = "model = \"metallic-roughness\"\nbase = 0.5\nroughness = 0.3\nanisotropy = 0.6\nanisotropy_rotation = 90\n\
         anisotropy_map = \"a.png\"";
    let (material, surface) = load_material(folder.path(), text).expect("a scene");
    let want = MetallicRoughness::new(Vec3::splat(0.5), 1.0, 0.3).and_then(|m| m.with_anisotropy(0.6));
    assert_eq!(material, want.expect("in range").into());
    assert!(
        surface.follows_u
            && surface.anisotropy.is_some()
            && (surface.anisotropy_turn - core::f32::consts::FRAC_PI_2).abs() < 1e-4
    );

    let gloss =
        "model = \"phong\"\nkd = 0.2\nks = 0.5\nexponent = 90\nspecular_map = \"a.png\"\nexponent_map = \"a.png\"";
    let (_, surface) = load_material(folder.path(), gloss).expect("a scene");
    assert!(surface.specular.is_some() && surface.exponent.is_some() && surface.color.is_none());
}

#[test]
fn what_is_wrong_with_an_image_is_said_at_its_line() {
    let folder = folder();
    write_quarters(folder.path(), "a.png");
    let whole = std::fs::read(folder.path().join("a.png")).expect("bytes");
    std::fs::write(folder.path().join("short.png"), &whole[..whole.len() / 2]).expect("a file");
    std::fs::write(folder.path().join("text.png"), "no image").expect("a file");
    std::fs::write(folder.path().join("empty.png"), "").expect("a file");
    // Formats that may hold NaN or values outside [0, 1].
    std::fs::write(folder.path().join("nan.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n").expect("a file");
    std::fs::write(folder.path().join("nan.exr"), [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]).expect("a file");
    // A header that promises 16 384 × 16 384 texels, and one beyond.
    for (name, side) in [("lie.png", 16384u32), ("large.png", 20000)] {
        let mut lie = whole.clone();
        lie[16..20].copy_from_slice(&side.to_be_bytes());
        lie[20..24].copy_from_slice(&side.to_be_bytes());
        let crc = crc32(&lie[12..29]);
        lie[29..33].copy_from_slice(&crc.to_be_bytes());
        std::fs::write(folder.path().join(name), lie).expect("a file");
    }
    let lambert = |map: &str| format!("model = \"lambert\"\ncolor_map = {map}");
    let cases = [
        (lambert("\"none.png\""), "none.png"),
        (lambert("\"short.png\""), "image \"short.png\""),
        (lambert("\"text.png\""), "unknown format"),
        (lambert("\"empty.png\""), "unknown format"),
        (lambert("\"nan.hdr\""), "unknown format: expected PNG, JPEG, BMP or TGA"),
        (lambert("\"nan.exr\""), "unknown format: expected PNG, JPEG, BMP or TGA"),
        (lambert("\"lie.png\""), "image \"lie.png\""),
        (lambert("\"large.png\""), "image \"large.png\""),
        (lambert("\".\""), "not a regular file"),
        (lambert("3"), "expected a file's name"),
        (lambert("{ scale = 2 }"), "\"file\" is missing"),
        (lambert("{ file = \"a.png\", wrap = \"tile\" }"), "\"repeat\", \"mirror\" or \"clamp\""),
        (lambert("{ file = \"a.png\", filter = \"none\" }"), "\"linear\" or \"nearest\""),
        (lambert("{ file = \"a.png\", channel = \"red\" }"), "unknown key \"channel\""),
        (lambert("{ file = \"a.png\", scale = [1, nan] }"), "finite"),
        ("model = \"lambert\"\nalbedo = 1\nmetallic_map = \"a.png\"".to_owned(), "unknown key \"metallic_map\""),
        ("model = \"metallic-roughness\"\nbase = 1\nior = 0.5".to_owned(), "at least 1"),
        ("model = \"metallic-roughness\"\nbase = 1\nanisotropy = -1".to_owned(), "anisotropy is -1"),
        ("model = \"metallic-roughness\"\nbase = 1\nclearcoat = 1.5".to_owned(), "clearcoat is 1.5"),
        ("model = \"metallic-roughness\"\nbase = 1\nclearcoat_roughness = 0.5".to_owned(), "\"clearcoat_roughness\""),
        (
            "model = \"metallic-roughness\"\nbase = 1\nmetallic_map = { file = \"a.png\", channel = \"x\" }".to_owned(),
            "\"red\", \"green\", \"blue\" or \"alpha\"",
        ),
        ("model = \"lambert\"\nalbedo = 1\nemission = -1".to_owned(), "must not be negative"),
    ];
    for (text, want) in cases {
        let message = load_material(folder.path(), &text).expect_err(&text);
        assert!(message.contains(want) && message.contains("scene.toml:"), "{text}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

/// Of PNG's chunks.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    };
    !bytes.iter().fold(!0, step)
}

/// One face without coordinates does not take those of the others away.
#[test]
fn faces_of_an_obj_without_coordinates_leave_the_others_theirs() {
    let folder = folder();
    write_quarters(folder.path(), "q.png");
    let path = folder.path().join("m.obj");
    std::fs::write(folder.path().join("m.mtl"), "newmtl a\nmap_Kd q.png\n").expect("a file");
    let text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.2 0.3\nusemtl a\nf 1/1 2/1 3/1\nf 3 2 4\n";
    std::fs::write(&path, text).expect("a file");
    let (scene, warnings) = load_with_warnings(&path).expect("a scene");
    let object = scene.objects.iter().find(|object| object.name == "m").expect("the model");
    let Shape::Mesh(mesh) = &object.shape else { panic!("a mesh") };
    let uvs = |triangle: usize| mesh.triangles[triangle].map(|i| mesh.uv_sets[0][i as usize].to_array());
    assert_eq!((uvs(0), uvs(1)), ([[0.2, 0.7]; 3], [[0.0, 1.0]; 3]));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("1 faces of a have no texture coordinates"), "{warnings:?}");
}

#[test]
fn an_obj_has_the_materials_of_its_library() {
    let folder = folder();
    write_quarters(folder.path(), "with space.png");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write(
        "m.mtl",
        "newmtl red\nKd 0.8 0.1 0.1\nillum 1\nKs 1 1 1\nnewmtl shiny # a comment\nKd .2 .2 .2\nKs 0.5 0.5 0.5\nNs 80\n\
         newmtl picture\nmap_Kd -s 2 3 1 -clamp on with space.png\nnewmtl metal\nKd 1 0.8 0.3\nPr 0.25\nPm 1\n\
         newmtl gone\nKd 0.3 0.3 0.3\nmap_Kd gone.png\nKe 5 5 5\nd 0.5\n",
    );
    let mut obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 0.75\n".to_owned();
    for name in ["red", "shiny", "picture", "metal", "gone", "unknown"] {
        obj += &format!("usemtl {name}\nf 1/1 2/2 3/3\n");
    }
    write("m.obj", &obj);
    let (scene, warnings) = load_with_warnings(folder.path().join("m.obj")).expect("a scene");
    let of = |name: &str| {
        let object = scene.objects.iter().find(|o| o.name == name).unwrap_or_else(|| panic!("no {name}"));
        (&scene.materials[object.material], scene.surface(object.material), &object.shape)
    };
    assert_eq!(*of("red").0, Material::lambert(Vec3::new(0.8, 0.1, 0.1)));
    let phong = Phong { kd: Vec3::splat(0.2) * FRAC_1_PI, ks: Vec3::splat(0.5) * FRAC_1_PI, exponent: 80.0 };
    assert_eq!(*of("shiny").0, phong.into());
    let metal = MetallicRoughness::new(Vec3::new(1.0, 0.8, 0.3), 1.0, 0.25).expect("in range");
    assert_eq!(*of("metal").0, metal.into());
    let (material, surface, shape) = of("picture");
    assert_eq!(*material, Material::lambert(Vec3::ONE));
    let map = surface.and_then(|s| s.color.as_ref()).expect("a map");
    assert_eq!(map.wrap, [Wrap::Clamp; 2]);
    // The format's v counts from below: (0, 0.75) is a quarter from the top, three times over.
    let Shape::Mesh(mesh) = shape else { panic!("a mesh") };
    let uv = map.transform.transform_point2(mesh.uv_sets[0][2]);
    assert!((1.0 - uv.y - 3.0 * 0.75).abs() < 1e-6 && uv.x == 0.0, "{uv}");
    assert_eq!(of("gone").1.map(|s| s.emission), Some(Vec3::splat(5.0)));
    // A material that no library defines is one object with the default material.
    assert!(scene.objects.iter().any(|o| o.name == "m" && o.material == 1), "{:?}", scene.objects.len());
    for part in ["gone.png is not there", "not opaque are cut out"] {
        assert!(warnings.iter().any(|w| w.contains(part)), "{part}: {warnings:?}");
    }
}

/// Alpha cuts boxes out; of spheres a warning says that it does not.
#[test]
fn spheres_stay_whole_and_say_so() {
    let folder = folder();
    let half = RgbaImage::from_fn(16, 16, |x, _| Rgba([200, 9, 9, if x < 8 { 255 } else { 0 }]));
    half.save(folder.path().join("half.png")).expect("an image");
    let load = |shape: &str| {
        let text = format!(
            "[materials.leaf]\nmodel = \"lambert\"\nalbedo = 1\ncolor_map = \"half.png\"\nalpha_cutoff = 0.5\n\
             [[objects]]\nname = \"leaf\"\nmaterial = \"leaf\"\n{shape}\n"
        );
        std::fs::write(folder.path().join("s.toml"), text).expect("a file");
        load_with_warnings(folder.path().join("s.toml")).expect("a scene").1
    };
    let told = |warnings: &[String]| warnings.iter().any(|w| w.contains("\"leaf\" stays whole"));
    let warnings = load("sphere = { center = [0, 1, 0], radius = 1 }");
    assert!(told(&warnings), "{warnings:?}");
    let warnings = load("box = { center = [0, 1, 0], size = [1, 1, 1] }");
    assert!(!told(&warnings), "{warnings:?}");
}

/// Opacity cuts, heights and normals turn, highlights vary: all images of a library.
#[test]
fn a_library_has_images_of_every_kind() {
    let folder = folder();
    let save = |name: &str, image: RgbaImage| image.save(folder.path().join(name)).expect("an image");
    let grey = |g: u8| Rgba([g, g, g, 255]);
    // Opaque on the left, in grey and in alpha.
    save("mask.png", RgbaImage::from_fn(16, 16, |x, _| grey(if x < 8 { 255 } else { 0 })));
    save("alpha.png", RgbaImage::from_fn(16, 16, |x, _| Rgba([9, 200, 9, if x < 8 { 255 } else { 0 }])));
    // Rises by 8 of 255 a texel to the right.
    save("ramp.png", RgbaImage::from_fn(16, 16, |x, _| grey((8 * x) as u8)));
    save("normals.png", RgbaImage::from_pixel(4, 4, Rgba([128, 128, 255, 255])));
    save("gloss.png", RgbaImage::from_pixel(2, 2, Rgba([51, 102, 153, 255])));
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write(
        "m.mtl",
        "newmtl grey\nmap_d mask.png\nnewmtl alpha\nmap_Kd alpha.png\nmap_d alpha.png\n\
         newmtl green\nmap_d -imfchan g alpha.png\nnewmtl clear\nd 0.3\nnewmtl misty\nTr 0.4\n\
         newmtl glass\nTr 0.6\nnewmtl unsure\nTr 1\nd 1\n\
         newmtl rough\nbump -bm 2 -clamp on ramp.png\nnewmtl carved\nmap_Bump -bm 0.5 normals.png\n\
         newmtl both\nbump ramp.png\nnorm normals.png\n\
         newmtl gloss\nKs 0.5 0.5 0.5\nNs 200\nmap_Ns -imfchan b gloss.png\nmap_Ks gloss.png\n\
         newmtl glossy\nKs 1 1 1\nmap_Ns gloss.png\nnewmtl metal\nmap_Pr gloss.png\nmap_Pm -imfchan g gloss.png\n",
    );
    let mut obj = "mtllib m.mtl\nv 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n".to_owned();
    let names = [
        "grey", "alpha", "green", "clear", "misty", "glass", "unsure", "rough", "carved", "both", "gloss", "glossy",
        "metal",
    ];
    for name in names {
        obj += &format!("usemtl {name}\nf 1/1 2/2 3/3 4/4\n");
    }
    write("m.obj", &obj);
    let (scene, warnings) = load_with_warnings(folder.path().join("m.obj")).expect("a scene");
    let object = |name: &str| scene.objects.iter().find(|o| o.name == name);
    let area = |name: &str| match object(name).map(|o| &o.shape) {
        Some(Shape::Mesh(mesh)) => mesh.area(),
        _ => 0.0,
    };
    // The line runs between the middles of two texels.
    assert!((area("grey") - 2.0).abs() < 0.05 && (area("alpha") - 2.0).abs() < 0.05, "{}", area("grey"));
    assert_eq!([area("green"), area("clear"), area("misty")], [4.0, 0.0, 4.0]);
    assert_eq!([area("glass"), area("unsure")], [0.0, 4.0]);
    let surface = |name: &str| scene.surface(object(name).expect(name).material).expect(name);
    let normal = |name: &str| {
        let place = |_| TexturePlace { uv: glam::Vec2::splat(0.45), ..TexturePlace::default() };
        surface(name).normal(&place).expect("a normal").normalize()
    };
    // It falls to the left: by twice 8/255.
    let want = Vec3::new(-2.0 * 8.0 / 255.0, 0.0, 1.0).normalize();
    assert!((normal("rough") - want).length() < 1e-3, "{} {want}", normal("rough"));
    assert_eq!(surface("carved").normal.as_ref().expect("a map").1, 0.5);
    assert!((normal("both") - Vec3::Z).length() < 0.01);
    let factors = |name: &str| surface(name).factors(&|_| TexturePlace::default());
    let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
    assert!(near(factors("gloss").exponent, 0.6) && near(factors("glossy").exponent, 0.2));
    assert!(near(factors("metal").roughness, 0.2) && near(factors("metal").metallic, 0.4));
    assert!(factors("gloss").specular.x > 0.03 && factors("gloss").specular.x < 0.035, "sRGB of 51");
    let phong = Phong { kd: Vec3::splat(0.5) * FRAC_1_PI, ks: Vec3::ONE * FRAC_1_PI, exponent: 1000.0 };
    assert_eq!(scene.materials[object("glossy").expect("an object").material], phong.into());
    for part in ["not opaque are cut out", "normals.png shows normals"] {
        assert_eq!(warnings.iter().filter(|w| w.contains(part)).count(), 1, "{part}: {warnings:?}");
    }
}

#[test]
fn a_lamp_that_lights_is_no_warning() {
    let folder = folder();
    let file = folder.path().join("lamp.toml");
    let lamp = "[[lights]]\nkind = \"sphere\"\ncenter = [0, 0.2, 0]\nradius = 1\nradiance = [1, 1, 1]\n";
    let far = lamp.replace("0.2", "9");
    // An object that lights, an object around a light, an object that is to light nothing.
    for (light, lamp, count) in [(true, "", 0), (false, lamp, 0), (false, far.as_str(), 0)] {
        let text = format!(
            "[materials.lamp]\nmodel = \"lambert\"\nalbedo = 0.5\nemission = [1, 1, 1]\n\
             [[objects]]\nsphere = {{ center = [0, 0, 0], radius = 1 }}\nmaterial = \"lamp\"\nlight = {light}\n{lamp}"
        );
        std::fs::write(&file, text).expect("a file");
        let (_, warnings) = scene_files::load_with_warnings(&file).expect("a scene");
        assert_eq!(warnings.len(), count, "{warnings:?}");
    }
}

#[test]
fn a_broken_library_is_refused_at_its_line() {
    let folder = folder();
    std::fs::write(folder.path().join("m.obj"), "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
        .expect("a file");
    for line in [
        "Kd 1 2",
        "Kd a b c",
        "Ns",
        "Pr x",
        "map_Kd",
        "Kd nan 1 1",
        "map_Kd -s inf 1 1 a.png",
        "map_d -imfchan z a.png",
        "bump",
        "d x",
    ] {
        write_quarters(folder.path(), "a.png");
        std::fs::write(folder.path().join("m.mtl"), format!("newmtl a\n{line}\n")).expect("a file");
        let message = load_with_warnings(folder.path().join("m.obj")).expect_err(line).to_string();
        assert!(message.contains("m.mtl:2"), "{line}: {message}");
    }
}

#[test]
fn colours_of_ply_and_obj_vertices_are_srgb() {
    let folder = folder();
    let half = 0.214_041; // sRGB 0.5
    std::fs::write(folder.path().join("c.obj"), "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 1\nv 0 1 0 9 -1 nan\nf 1 2 3\n")
        .expect("a file");
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n\
         0 0 0 255 128 0 0 0.25\n1 0 0 0 0 255 1 0\n0 1 0 255 255 255 0 1\n3 0 1 2\n";
    std::fs::write(folder.path().join("c.ply"), ply).expect("a file");
    for (name, tolerance) in [("c.obj", 1e-5), ("c.ply", 3e-3)] {
        let (scene, _) = load_with_warnings(folder.path().join(name)).expect("a scene");
        let Shape::Mesh(mesh) = &scene.objects[1].shape else { panic!("a mesh") };
        assert!((mesh.colors[0] - Vec3::new(1.0, half, 0.0)).length() < tolerance, "{name}: {}", mesh.colors[0]);
        assert!(mesh.colors.iter().all(|c| c.min_element() >= 0.0 && c.max_element() <= 1.0));
        // Vertex colours replace the default albedo instead of multiplying it.
        assert_eq!(scene.materials[scene.objects[1].material], Material::lambert(Vec3::ONE));
    }
    let (scene, _) = load_with_warnings(folder.path().join("c.ply")).expect("a scene");
    let Shape::Mesh(mesh) = &scene.objects[1].shape else { panic!("a mesh") };
    assert_eq!(mesh.uv_sets[0][0], glam::Vec2::new(0.0, 0.75));
}

/// All kinds of pixels that a PNG has, and JPEG, BMP and TGA.
#[test]
fn images_of_every_kind_are_read() {
    let folder = folder();
    let color = [200u8, 100, 50, 255];
    let rgba = RgbaImage::from_pixel(5, 3, Rgba(color));
    let dynamic = image::DynamicImage::ImageRgba8(rgba);
    let kinds = [
        ("rgba8.png", dynamic.clone()),
        ("rgb8.png", dynamic.to_rgb8().into()),
        ("rgb16.png", dynamic.to_rgb16().into()),
        ("rgba16.png", dynamic.to_rgba16().into()),
        ("grey8.png", dynamic.to_luma8().into()),
        ("greya8.png", dynamic.to_luma_alpha8().into()),
        ("grey16.png", dynamic.to_luma16().into()),
        ("a.jpg", dynamic.to_rgb8().into()),
        ("a.bmp", dynamic.to_rgb8().into()),
        ("a.tga", dynamic.to_rgb8().into()),
    ];
    for (name, image) in kinds {
        image.save(folder.path().join(name)).expect(name);
        let text = format!("model = \"lambert\"\ncolor_map = \"{name}\"");
        let (_, surface) = load_material(folder.path(), &text).expect(name);
        let texture = surface.color.expect("a map").texture;
        assert_eq!(texture.size(), [5, 3], "{name}");
        let got = texture.sample(glam::Vec2::splat(0.5), [glam::Vec2::ZERO; 2], [Wrap::Repeat; 2], true);
        let grey = name.starts_with("grey");
        let want = if grey { [0.181; 3] } else { [0.577, 0.127, 0.0319] };
        let near = got.iter().zip(want).all(|(a, b)| (a - b).abs() < 0.02);
        assert!(near && got[3] == 1.0, "{name}: {got:?}");
    }
}
