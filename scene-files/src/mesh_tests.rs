use crate::context::Context;
use crate::files::Source;
use crate::{obj, ply};
use brdf::Lambert;
use glam::Vec3;
use scene::{Encoding, Mesh};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn read_obj(text: &str) -> Result<Mesh, String> {
    obj::parse(Path::new("m.obj"), text, &mut Context::default())
        .map(|mut parts| parts.remove(0).mesh)
        .map_err(|e| e.to_string())
}

fn read_ply(bytes: &[u8]) -> Result<Mesh, String> {
    ply::parse(Path::new("m.ply"), bytes, &mut Context::default())
        .map(|mut parts| parts.remove(0).mesh)
        .map_err(|e| e.to_string())
}

const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\nf 2 3 7 6\n";

#[test]
fn obj_polygons_relative_indices_and_normals() {
    let mesh = read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 2\nf -4//1 -3//1 -2//1 -1//1\n").unwrap();
    assert_eq!((mesh.triangles.len(), mesh.positions.len()), (2, 4));
    assert_eq!(mesh.normals, [Vec3::Z; 4]);
    // An L of area 3: a fan would cover more.
    let mesh = read_obj("v 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nf 1 2 3 4 5 6\n").unwrap();
    assert_eq!(mesh.triangles.len(), 4);
    assert!((mesh.area() - 3.0).abs() < 1e-6);
}

#[test]
fn words_of_obj_have_any_capitals_and_unknown_ones_are_named() {
    let (parts, warnings) = with_library("a", b"newmtl a\nKd 1 0 0\n");
    let files = BTreeMap::from([(PathBuf::from("m.mtl"), b"newmtl a\nKd 1 0 0\n".to_vec())]);
    let mut context = Context { files: Source::new(Arc::new(files)), ..Context::default() };
    let cube = CUBE.replace('v', "V").replace("f ", "fo ");
    let text = format!("MTLLIB m.mtl\nUseMtl a\nlod 1\n{cube}call b.obj\n\u{1b}x 1\n");
    let loud = obj::parse(Path::new("m.obj"), &text, &mut context).unwrap();
    assert_eq!((loud[0].mesh.triangles.len(), warnings.len()), (parts[0].mesh.triangles.len(), 0));
    assert_eq!(loud[0].material, parts[0].material);
    let told = "lines that begin with \"\\u{1b}x\", \"call\" are not read";
    assert_eq!(context.warnings.len(), 1, "{:?}", context.warnings);
    assert!(context.warnings[0].contains(told), "{:?}", context.warnings);
}

#[test]
fn materials_without_any_library_are_told_where_nothing_else_names_them() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), format!("usemtl red\n{CUBE}")).unwrap();
    let scene = folder.path().join("s.toml");
    let start = "[camera]\neye = [4, 3, 5]\ntarget = [0, 0, 0]\n[materials.m]\nmodel = \"lambert\"\nalbedo = 0.5\n\
        [[lights]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n[[objects]]\nmesh = \"m.obj\"\n";
    for (material, count) in [("", 1), ("material = \"m\"\n", 0)] {
        std::fs::write(&scene, format!("{start}{material}")).unwrap();
        let (_, warnings) = crate::load_with_warnings(&scene).unwrap();
        assert_eq!(warnings.len(), count, "{warnings:?}");
        assert!(warnings.iter().all(|w| w.contains("names no library (mtllib) of the material red")), "{warnings:?}");
    }
}

#[test]
fn a_material_library_that_is_not_used_is_told() {
    let mut context = Context::default();
    obj::parse(Path::new("m.obj"), &format!("mtllib no-such.mtl\nusemtl x\n{CUBE}"), &mut context).unwrap();
    assert!(context.warnings.len() == 1 && context.warnings[0].contains("no-such.mtl does not exist"));
}

/// The parts and warnings of a cube whose faces use a material, with the bytes of the library that it names.
fn with_library(name: &str, library: &[u8]) -> (Vec<crate::part::Part>, Vec<String>) {
    let files = BTreeMap::from([(PathBuf::from("m.mtl"), library.to_vec())]);
    let mut context = Context { files: Source::new(Arc::new(files)), ..Context::default() };
    let text = format!("mtllib m.mtl\nusemtl {name}\n{CUBE}");
    (obj::parse(Path::new("m.obj"), &text, &mut context).unwrap(), context.warnings)
}

#[test]
fn materials_that_no_library_has_are_named() {
    let (_, warnings) = with_library("a", b"newmtl a\nKd 1 0 0\n");
    assert!(warnings.is_empty(), "{warnings:?}");
    let (parts, warnings) = with_library("a", b"newmtl A\nKd 1 0 0\n");
    assert!(parts[0].material.is_none());
    assert!(warnings.len() == 1 && warnings[0].contains("no library has the material a"), "{warnings:?}");
    let (_, warnings) = with_library(&format!("x\n{CUBE}usemtl y"), b"newmtl a\n");
    assert!(warnings.len() == 1 && warnings[0].contains("no library has 2 materials (x, …)"), "{warnings:?}");
}

/// A byte order mark, UTF-16 in both orders, lines that continue: the same material.
#[test]
fn libraries_are_read_as_programs_write_them() {
    let text = "newmtl a\nKd 0.5 0.25 1\n";
    let wide = |of: fn(u16) -> [u8; 2]| format!("\u{feff}{text}").encode_utf16().flat_map(of).collect::<Vec<u8>>();
    let libraries = [
        text.as_bytes().to_vec(),
        format!("\u{feff}{text}").into_bytes(),
        wide(u16::to_le_bytes),
        wide(u16::to_be_bytes),
        b"newmtl a\nKd 0.5 \\\n 0.25 \\\r\n 1\n".to_vec(),
    ];
    for library in libraries {
        let (parts, warnings) = with_library("a", &library);
        let (_, appearance) = parts[0].material.as_ref().expect("the material");
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(appearance.material, Lambert { albedo: Vec3::new(0.5, 0.25, 1.0) }.into());
    }
    // A backslash at the end of a name is a part of that.
    let (_, warnings) = with_library("a", b"newmtl a\nmap_Kd C:\\maps\\\nKd 1 0 0\n");
    assert!(warnings.iter().any(|w| w.contains("maps")), "{warnings:?}");
}

#[test]
fn ranges_of_images_that_are_not_read_are_told() {
    let line = |options: &str| with_library("a", format!("newmtl a\nmap_Kd {options} no.png\n").as_bytes()).1;
    assert!(line("-mm 0.2 0.5").iter().any(|w| w.contains("not read: -mm")));
    assert!(line("-mm 0 1").iter().all(|w| !w.contains("-mm")));
}

#[test]
fn numbers_out_of_range_and_materials_of_one_name_are_told() {
    let told = |library: &str| with_library("a", library.as_bytes()).1;
    assert!(told("newmtl a\nKd 1 0 0.5\nNs 50\nd 1\nnewmtl b\nKd 3 0 0\n").is_empty());
    let strange = told("newmtl a\nKd -0.5 0 0.5\nPr 1.5\nNs -1\n");
    assert!(strange.len() == 1 && strange[0].contains("3 numbers are negative or out of range"), "{strange:?}");
    let twice = told("newmtl a\nKd 1 0 0\nnewmtl b\nnewmtl a\nKd 0 1 0\nnewmtl b\nnewmtl b\n");
    assert!(twice.len() == 1 && twice[0].contains("material a (and 1 more) stands there more than once"), "{twice:?}");
    let (parts, _) = with_library("a", b"newmtl a\nKd 1 0 0\nnewmtl a\nKd 0 1 0\n");
    let (_, appearance) = parts[0].material.as_ref().expect("the material");
    assert_eq!(appearance.material, Lambert { albedo: Vec3::Y }.into());
}

#[test]
fn constant_colours_are_told() {
    let warnings = |illum: u32| with_library("a", format!("newmtl a\nKd 1 0 0\nillum {illum}\n").as_bytes()).1;
    assert!(warnings(0).iter().any(|w| w.contains("not read: illum 0")));
    assert!(warnings(1).is_empty());
}

#[test]
fn bad_obj_names_its_line() {
    for (text, line, words) in [
        ("v 0 0 0\nv 1 0 0\nf 1 2 3\n", 3, "vertex 3, there are 2"),
        ("v 0 0\n", 1, "three numbers"),
        ("# x\nv 0,5 0 0\n", 2, "'0,5'"),
        ("v 0 0 0\nf 0 1 1\n", 2, "vertex 0"),
        ("v 0 0 0\nf 1//2 1 1\n", 2, "normal 2"),
        ("v 0 0 0\nf a b c\n", 2, "'a'"),
    ] {
        let message = read_obj(text).unwrap_err();
        assert!(message.starts_with(&format!("m.obj:{line}: ")) && message.contains(words), "{message}");
    }
}

#[test]
fn ply_ascii_and_both_byte_orders_agree() {
    let head = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
    };
    let positions = [0.0_f32, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0, -2.5, 0.0];
    let mut ascii = head("ascii").into_bytes();
    ascii.extend(b"0 0 0\n1.5 0 0\n0 -2.5 0\n3 0 1 2\n");
    let (mut little, mut big) = (head("binary_little_endian").into_bytes(), head("binary_big_endian").into_bytes());
    for x in positions {
        little.extend(x.to_le_bytes());
        big.extend(x.to_be_bytes());
    }
    little.push(3);
    big.push(3);
    for i in 0..3_i32 {
        little.extend(i.to_le_bytes());
        big.extend(i.to_be_bytes());
    }
    let mesh = read_ply(&ascii).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(mesh.positions[2], Vec3::new(0.0, -2.5, 0.0));
    assert_eq!(read_ply(&little).unwrap(), mesh);
    assert_eq!(read_ply(&big).unwrap(), mesh);
    // Every cut gives an error, never a panic.
    for bytes in [&ascii, &little] {
        for end in 0..bytes.len() - 2 {
            assert!(read_ply(&bytes[..end]).is_err(), "{end}");
        }
    }
}

#[test]
fn a_mesh_of_text_is_the_mesh_of_the_file() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/assets/spot.obj");
    let text = std::fs::read_to_string(&file).unwrap();
    let objects = crate::load(&file).unwrap().objects;
    let mesh = crate::obj_mesh("spot.obj", &text).unwrap();
    assert!(objects.iter().any(|o| matches!(&o.shape, scene::Shape::Mesh(read) if *read == mesh)));
    let error = crate::obj_mesh("short", "v 0 0 0\nf 1 2 3\n").unwrap_err().to_string();
    assert!(error.starts_with("short:2:"), "{error}");
}

/// The parts of a PLY text of a square, with these properties and values beside positions and corners, and the warnings.
fn square(header: [&str; 3], vertex: [&str; 4], face: [&str; 2]) -> (Vec<crate::part::Part>, Vec<String>) {
    let [comments, of_vertices, of_faces] = header;
    let places = ["-1 0 1", "1 0 1", "1 0 -1", "-1 0 -1"];
    let vertices: String = places.iter().zip(vertex).map(|(p, more)| format!("{p} {more}\n")).collect();
    let text = format!(
        "ply\nformat ascii 1.0\n{comments}element vertex 4\nproperty float x\nproperty float y\nproperty float z\n{of_vertices}\
         element face 2\nproperty list uchar int vertex_indices\n{of_faces}end_header\n{vertices}3 0 1 2 {}\n3 0 2 3 {}\n",
        face[0], face[1]
    );
    let mut context = Context::default();
    (ply::parse(Path::new("m.ply"), text.as_bytes(), &mut context).unwrap(), context.warnings)
}

#[test]
fn colours_of_ply_are_read_by_all_their_names_and_ranges() {
    let want = [128.0_f32, 64.0, 191.0].map(|x| Encoding::Srgb.linear(x / 255.0));
    let near = |c: Vec3| (c - Vec3::from_array(want)).abs().max_element() < 2e-3;
    for (names, kind, value, notes) in [
        (["red", "green", "blue"], "uchar", "128 64 191", 0),
        (["diffuse_red", "diffuse_green", "diffuse_blue"], "uchar", "128 64 191", 0),
        (["r", "g", "b"], "float", "0.50196 0.25098 0.74902", 0),
        (["red", "green", "blue"], "float", "128 64 191", 1),
        (["red", "green", "blue"], "int", "128 64 191", 1),
    ] {
        let properties: String = names.iter().map(|name| format!("property {kind} {name}\n")).collect();
        let (parts, warnings) = square(["", &properties, ""], [value; 4], [""; 2]);
        assert!(parts[0].mesh.colors.iter().all(|c| near(*c)), "{names:?} {kind}: {:?}", parts[0].mesh.colors);
        assert_eq!(warnings.len(), notes, "{warnings:?}");
        // Of faces: one vertex for each colour.
        let (parts, _) = square(["", "", &properties], [""; 4], [value, "0 0 0"]);
        let mesh = &parts[0].mesh;
        assert_eq!(mesh.positions.len(), 6);
        assert!(mesh.triangles[0].iter().all(|i| near(mesh.colors[*i as usize])));
        assert!(mesh.triangles[1].iter().all(|i| mesh.colors[*i as usize] == Vec3::ZERO));
    }
    let (_, warnings) = square(["", "property uchar alpha\n", ""], ["255", "255", "9", "255"], [""; 2]);
    assert!(warnings.len() == 1 && warnings[0].contains("alpha"), "{warnings:?}");
}

#[test]
fn texture_coordinates_of_ply_faces_part_their_corners() {
    let list = "property list uchar float texcoord\nproperty int texnumber\n";
    let (parts, warnings) =
        square(["comment TextureFile no such.png\n", "", list], [""; 4], ["6 0 0 1 0 1 1 0", "6 0 0 1 1 0.5 1 0"]);
    let mesh = &parts[0].mesh;
    assert!(warnings.len() == 1 && warnings[0].contains("no such.png"), "{warnings:?}");
    // The first two corners of the second triangle are those of the first.
    assert_eq!((mesh.positions.len(), mesh.uv_sets[0][3]), (4, glam::Vec2::new(0.5, 0.0)));
    // Two images are two parts.
    let two = "comment TextureFile a.png\ncomment TextureFile b.png\n";
    let (parts, _) = square([two, "", list], [""; 4], ["6 0 0 1 0 1 1 0", "6 0 0 1 1 0 1 1"]);
    assert_eq!(parts.iter().map(|p| p.mesh.triangles.len()).collect::<Vec<_>>(), [1, 1]);
    let (_, warnings) = square(["comment TextureFile a.png\n", "", ""], [""; 4], [""; 2]);
    assert!(warnings.len() == 1 && warnings[0].contains("no texture coordinates"), "{warnings:?}");
}

#[test]
fn colours_of_obj_vertices_may_be_bytes() {
    let text = "v 0 0 0 128 64 191\nv 1 0 0 128 64 191 255\nv 0 1 0 128 64 191\nf 1 2 3\n";
    let mut context = Context::default();
    let parts = obj::parse(Path::new("m.obj"), text, &mut context).unwrap();
    assert!((parts[0].mesh.colors[1] - Vec3::new(0.2159, 0.0513, 0.5210)).length() < 1e-3);
    assert!(context.warnings.len() == 1 && context.warnings[0].contains("255"), "{:?}", context.warnings);
}

#[test]
fn elements_and_colours_that_are_left_out_are_told() {
    let warnings = |text: &str| {
        let mut context = Context::default();
        obj::parse(Path::new("m.obj"), text, &mut context).unwrap();
        context.warnings
    };
    let told = warnings(&format!("{CUBE}l 1 2\nl 1 2 3\np 1\ncurv 0 1 1 2\nsurf 0 1 0 1 1 2 3 4\n"));
    let words = ["1 point", "2 lines", "1 curve", "1 surface"];
    assert!(told.len() == 1 && words.iter().all(|word| told[0].contains(word)), "{told:?}");
    let told =
        warnings("maplib a.map\nusemap a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt nan 0\nvt 1 inf\nvt 0 1\nf 1/1 2/2 3/3\n");
    assert!(told.iter().any(|line| line.contains("\"maplib\"") && line.contains("\"usemap\"")), "{told:?}");
    assert!(told.iter().any(|line| line.contains(": 2 texture coordinates")), "{told:?}");
    for colors in [["", " 1 0 0", ""], [" 1 0 0", "", ""]] {
        let [a, b, c] = colors;
        let told = warnings(&format!("v 0 0 0{a}\nv 1 0 0{b}\nv 0 1 0{c}\nf 1 2 3\n"));
        assert!(told.len() == 1 && told[0].contains("1 of 3 vertices have colours"), "{told:?}");
    }
    let (_, told) = with_library("a", b"newmtl a\nmap_Kd -t 0.5 0 0 a.png\nmap_Ks -t 0 0 0 a.png\n");
    assert_eq!(told.iter().filter(|line| line.contains("not read: -t")).count(), 1, "{told:?}");
}

#[test]
fn parts_of_ply_files_that_are_left_out_are_told() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nproperty int material_index\nelement tristrips 1\n\
        property list int int vertex_indices\nend_header\n";
    let mut context = Context::default();
    let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 5\n3 0 1 2\n";
    ply::parse(Path::new("m.ply"), format!("{header}{body}").as_bytes(), &mut context).unwrap();
    for words in ["tristrips", "material_index"] {
        assert_eq!(context.warnings.iter().filter(|line| line.contains(words)).count(), 1, "{:?}", context.warnings);
    }
}

#[test]
fn ply_files_with_more_than_their_header_says_are_told() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let told = |body: &str| {
        let mut context = Context::default();
        ply::parse(Path::new("m.ply"), format!("{header}{body}").as_bytes(), &mut context).unwrap();
        context.warnings
    };
    assert!(told("0 0 0\n1 0 0\n0 1 0\n3 0 1 2 \n\n").is_empty());
    let longer = told("0 0 0 7\n1 0 0 7\n0 1 0\n3 0 1 2\n");
    assert!(longer.len() == 1 && longer[0].contains("2 lines have more numbers"), "{longer:?}");
    let behind = told("0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 2 1 0\n");
    assert!(behind.len() == 1 && behind[0].contains("7 bytes behind its last element"), "{behind:?}");
}

#[test]
fn ply_faces_without_area_or_place_are_counted_and_names_have_any_capitals() {
    let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float X\nproperty float y\nproperty float z\n\
        property uchar Red\nproperty uchar Green\nproperty uchar Blue\nelement face 3\n\
        property list uchar int vertex_indices\nend_header\n";
    let body =
        "0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\nnan nan nan 255 0 0\ninf 0 0 255 0 0\n3 0 1 2\n2 0 1\n3 0 1 4\n";
    let mut context = Context::default();
    let parts = ply::parse(Path::new("m.ply"), format!("{header}{body}").as_bytes(), &mut context).unwrap();
    let mesh = &parts[0].mesh;
    assert_eq!((mesh.triangles.len(), mesh.colors[0]), (1, Vec3::X));
    assert!(mesh.validate().is_ok(), "{:?}", mesh.positions);
    let told = "1 face left out for fewer than three corners, 1 face left out for corners that are NaN";
    assert!(context.warnings.iter().any(|line| line.contains(told)), "{:?}", context.warnings);
}

#[test]
fn ply_files_that_are_not_read_say_why() {
    let vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    for (header, body, words) in [
        (format!("{faces}{vertices}"), "3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n", "element vertex before element face"),
        (format!("{vertices}{strips}"), "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "tristrips"),
    ] {
        let text = format!("ply\nformat ascii 1.0\n{header}end_header\n{body}");
        let message = read_ply(text.as_bytes()).unwrap_err();
        assert!(message.contains(words), "{message}");
    }
}

/// A face of many corners that winds three times around.
#[test]
fn large_faces_that_cross_themselves_are_fans_with_a_warning() {
    let n = 6000;
    let corner = |k: usize| {
        let angle = core::f64::consts::TAU * 3.0 * k as f64 / n as f64;
        let radius = if k.is_multiple_of(2) { 0.5 } else { 1.0 };
        format!("{} {} 0\n", radius * angle.cos(), radius * angle.sin())
    };
    let corners: Vec<String> = (0..n).map(corner).collect();
    let numbers = |first: usize| (first..first + n).map(|k| k.to_string()).collect::<Vec<_>>().join(" ");
    let obj = format!("v {}f {}\n", corners.join("v "), numbers(1));
    let header =
        format!("ply\nformat ascii 1.0\nelement vertex {n}\nproperty float x\nproperty float y\nproperty float z\n");
    let list = "element face 1\nproperty list int int vertex_indices\nend_header\n";
    let ply = format!("{header}{list}{}{n} {}\n", corners.concat(), numbers(0));
    let begin = std::time::Instant::now();
    for is_obj in [true, false] {
        let mut context = Context::default();
        let parts = match is_obj {
            true => obj::parse(Path::new("m.obj"), &obj, &mut context),
            false => ply::parse(Path::new("m.ply"), ply.as_bytes(), &mut context),
        };
        assert_eq!(parts.expect("a mesh")[0].mesh.triangles.len(), n - 2);
        assert!(context.warnings.iter().any(|line| line.contains("a face crosses itself")), "{:?}", context.warnings);
    }
    assert!(begin.elapsed().as_secs_f64() < 2.0, "{:?}", begin.elapsed());
}
