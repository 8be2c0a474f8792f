//! Coordinates: of the file, made, and refused.

use crate::support::{File, WHOLE, bake, chunks, try_bake};
use bake::{BakeSettings, Form};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};

const MAPS: BakeSettings = BakeSettings { form: Form::Lightmap, page: 64, ..BakeSettings::DEFAULT };

const SIDES: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::NEG_Z];

fn lit() -> File {
    let mut file = File::new();
    file.light(json!({"type": "point", "intensity": 5.0}), Vec3::new(0.5, 2.0, 0.3));
    file
}

fn message(file: &File, settings: BakeSettings) -> String {
    try_bake(file, settings).err().map(|e| e.to_string()).unwrap_or_default()
}

/// Halves on the same texels, squares on each other, and coordinates that repeat are refused with the mesh's name; made ones do not
/// overlap. A mirrored chart with texels of its own is as good as any.
#[test]
fn overlaps_are_refused_by_name() {
    let right = [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]].map(Vec2::from_array);
    let cases = [
        // The second triangle lies on the first.
        ([right[0], right[1], right[2], right[1]], "mirrored onto each other"),
        ([right[0], right[1], right[2], Vec2::new(0.1, 1.4)], "leave the page at (0.1, 1.4)"),
        ([right[0], right[1], right[2], Vec2::new(f32::NAN, 0.5)], "leave the page"),
    ];
    for (uvs, fault) in cases {
        let mut file = lit();
        let positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, 0.0, -z));
        let mesh = file.mesh("wing", &positions, &[[0, 1, 2], [0, 2, 3]], Some(&uvs));
        file.node(json!({"mesh": mesh}));
        let found = message(&file, MAPS);
        assert!(found.contains("mesh \"wing\"") && found.contains(fault) && !found.contains('\n'), "{found}");
        assert!(bake(&file, BakeSettings { unwrap: true, ..MAPS }).texels > 2000);
    }
    let mut file = lit();
    let mirrored = Some([Vec2::new(0.9, 0.1), Vec2::new(0.1, 0.9)]);
    file.quad("mirror", SIDES, mirrored);
    assert!(bake(&file, MAPS).texels > 2500);
}

/// Surfaces whose coordinates do not overlap share a page, others do not; the same mesh shown twice has a page each.
#[test]
fn surfaces_share_pages_that_have_room() {
    let mut file = lit();
    let half = |from: f32| Some([Vec2::new(from, 0.0), Vec2::new(from + 0.5, 1.0)]);
    file.quad("a", SIDES, half(0.0));
    file.quad("b", [Vec3::Y * -1.0, Vec3::X, Vec3::NEG_Z], half(0.5));
    let c = file.quad("c", [Vec3::Y * -2.0, Vec3::X, Vec3::NEG_Z], half(0.5));
    let mesh = file.json["nodes"][c]["mesh"].clone();
    let twin = file.node(json!({"name": "twin", "mesh": mesh, "translation": [0.0, -1.0, 0.0]}));
    let baked = bake(&file, MAPS);
    assert_eq!((baked.pages.len(), baked.surfaces), (3, 4));
    let (text, _) = chunks(&baked.glb);
    let json: Value = serde_json::from_str(&text).unwrap();
    let (first, second) = (&json["nodes"][c]["mesh"], &json["nodes"][twin]["mesh"]);
    assert_ne!(first, second);
    let material = |mesh: &Value| json["meshes"][mesh.as_u64().unwrap() as usize]["primitives"][0]["material"].clone();
    assert_ne!(material(first), material(second));
}

/// Made coordinates are at least twice the padding apart, carry the normals and positions of their origins, and have the density that
/// is requested.
#[test]
fn made_coordinates_keep_the_surface() {
    let mut file = lit();
    file.block("block", Vec3::NEG_Y, Vec3::splat(0.5));
    file.quad("floor", [Vec3::Y * -2.0, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], None);
    let baked = bake(&file, BakeSettings { density: Some(8.0), page: 128, ..MAPS });
    let (text, binary) = chunks(&baked.glb);
    let json: Value = serde_json::from_str(&text).unwrap();
    let rows = |accessor: &Value, width: usize| -> Vec<Vec<f32>> {
        let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        let float = |at: usize| f32::from_le_bytes(binary[at..at + 4].try_into().unwrap());
        (0..count).map(|k| (0..width).map(|j| float(start + 4 * (k * width + j))).collect()).collect()
    };
    let mut area = [0.0; 2];
    for mesh in 0..2 {
        let primitive = &json["meshes"][mesh]["primitives"][0];
        let (positions, uvs) =
            (rows(&primitive["attributes"]["POSITION"], 3), rows(&primitive["attributes"]["TEXCOORD_1"], 2));
        assert_eq!(positions.len(), uvs.len());
        assert_eq!(primitive["attributes"]["TEXCOORD_0"], primitive["attributes"]["TEXCOORD_1"]);
        let indices = &json["accessors"][primitive["indices"].as_u64().unwrap() as usize];
        let view = &json["bufferViews"][indices["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        let count = indices["count"].as_u64().unwrap() as usize;
        let index =
            |k: usize| u16::from_le_bytes(binary[start + 2 * k..start + 2 * k + 2].try_into().unwrap()) as usize;
        for t in 0..count / 3 {
            let [a, b, c] = [0, 1, 2].map(|k| index(3 * t + k));
            let p = |i: usize| Vec3::from_slice(&positions[i]);
            let uv = |i: usize| Vec2::from_slice(&uvs[i]);
            area[0] += 0.5 * (p(b) - p(a)).cross(p(c) - p(a)).length();
            area[1] += 0.5 * (uv(b) - uv(a)).perp_dot(uv(c) - uv(a)).abs();
        }
    }
    // 16 of the floor and 6 of the block.
    assert!((area[0] - 22.0).abs() < 1e-4);
    let [width, height] = baked.pages[0].map(|k| k as f32);
    let texels = area[1] * width * height / area[0];
    assert!((texels / 64.0 - 1.0).abs() < 0.02, "{texels} texels a square unit");
}

/// A file of many pieces, fans of some triangles each.
fn chaff(count: u32, triangles: u32) -> File {
    let mut file = lit();
    add_chaff(&mut file, count, triangles);
    file
}

fn add_chaff(file: &mut File, count: u32, triangles: u32) {
    let corner = |k: u32| {
        let (piece, corner) = (k / (triangles + 2), k % (triangles + 2));
        let (i, j) = ((piece % 105) as f32, (piece / 105) as f32);
        let turn = (corner.saturating_sub(1)) as f32 / triangles as f32;
        let arm = if corner == 0 { Vec3::ZERO } else { Vec3::new(turn.cos(), 0.1 * turn, -turn.sin()) };
        Vec3::new(i, 0.0, -j) + 0.5 * arm
    };
    let positions: Vec<Vec3> = (0..(triangles + 2) * count).map(corner).collect();
    let fan = |k: u32| (0..triangles).map(move |t| [0, t + 1, t + 2].map(|i| (triangles + 2) * k + i));
    let triangles: Vec<[u32; 3]> = (0..count).flat_map(fan).collect();
    let mesh = file.mesh("chaff", &positions, &triangles, None);
    file.node(json!({"mesh": mesh}));
}

/// Many pieces in surfaces of few ones are named before the work begins, and more of them than a page holds are refused at once.
#[test]
fn many_pieces_are_named() {
    let mut file = lit();
    (0..26).for_each(|_| add_chaff(&mut file, 1950, 1));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, file.glb()).unwrap();
    let open = |settings| {
        let options = scene_files::LoadOptions::new();
        bake::Baker::open(&path, &options, settings, renderer::Settings::default()).unwrap()
    };
    let notes = |settings| open(settings).notes().join("\n");
    assert!(notes(MAPS).contains("coordinates for 50700 separate pieces"), "{}", notes(MAPS));
    assert!(notes(BakeSettings { form: Form::VertexColors, ..MAPS }).is_empty());
    let start = std::time::Instant::now();
    // Of many triangles each, so that they do not lie in rows.
    let found = message(&chaff(8000, 9), BakeSettings { page: 256, ..MAPS });
    assert!(found.contains("mesh \"chaff\": its 8000 separate pieces do not fit one page of 256"), "{found}");
    assert!(start.elapsed().as_secs() < 5);
}

/// Pieces of few triangles lie in rows: tens of thousands take no minutes, and lie apart.
#[test]
fn small_pieces_lie_in_rows() {
    let file = chaff(30_000, 2);
    let settings = BakeSettings { page: 1024, samples: 1, padding: 1, ..MAPS };
    let start = std::time::Instant::now();
    let baked = bake(&file, settings);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    assert!(baked.pages.len() == 1 && baked.texels > 60_000, "{} texels", baked.texels);
    // Read again, its coordinates are refused if they overlap.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.glb");
    std::fs::write(&path, &baked.glb).unwrap();
    assert_eq!(crate::support::bake_file(&path, settings).unwrap().pages, [[1024; 2]]);
    let found = message(&file, BakeSettings { page: 512, ..settings });
    assert!(found.contains("mesh \"chaff\": its charts do not fit one page of 512"), "{found}");
}

/// Edges of three triangles, triangles that meet in a corner, and the same triangle twice are no fault, in any form.
#[test]
fn odd_surfaces_are_baked() {
    let mut file = lit();
    let book =
        [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.2], [0.3, 0.0, 1.0]].map(Vec3::from_array);
    let mesh = file.mesh("book", &book, &[[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 4]], None);
    file.node(json!({"mesh": mesh}));
    let bow = [[0.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, -1.0, 1.0], [-1.0, -1.0, 0.0], [0.0, -1.0, -1.0]]
        .map(Vec3::from_array);
    let mesh = file.mesh("bow", &bow, &[[0, 2, 1], [0, 4, 3]], None);
    file.node(json!({"mesh": mesh}));
    file.json["materials"][0]["doubleSided"] = json!(true);
    for both_sides in [false, true] {
        for form in [Form::Emission, Form::Lightmap, Form::VertexColors] {
            let subdivide = (form == Form::VertexColors).then_some(0.1);
            let baked = bake(&file, BakeSettings { form, both_sides, subdivide, page: 128, ..MAPS });
            assert_eq!(baked.surfaces, if both_sides { 4 } else { 2 });
        }
    }
}

/// Settings and files that cannot be baked are refused in one line.
#[test]
fn bad_input_is_refused() {
    let mut file = lit();
    file.quad("floor", SIDES, WHOLE);
    for (settings, fault) in [
        (BakeSettings { page: 3, ..MAPS }, "page is 3: expected"),
        (BakeSettings { page: 70_000, ..MAPS }, "page is 70000: expected"),
        (BakeSettings { page: 16_384, per_light: true, ..MAPS }, "GB"),
        (BakeSettings { samples: 0, ..MAPS }, "points along a texel is 0"),
        (BakeSettings { padding: 16, ..MAPS }, "padding is 16"),
        (BakeSettings { density: Some(f32::NAN), ..MAPS }, "density is NaN"),
        (BakeSettings { density: Some(1e4), unwrap: true, ..MAPS }, "GB"),
        (BakeSettings { density: Some(100.0), unwrap: true, ..MAPS }, "a page has 64 x 64"),
    ] {
        let found = message(&file, settings);
        assert!(found.contains(fault) && !found.contains('\n'), "{found}");
    }
    let mut dark = File::new();
    dark.quad("floor", SIDES, WHOLE);
    assert!(message(&dark, MAPS).contains("no light"));
    file.json["materials"][0]["extensions"] = json!({"KHR_materials_unlit": {}});
    assert!(message(&file, MAPS).contains("no surface"));
}

/// Charts without an area, and triangles without one, are no fault: the texel under such a chart has the light of its surface.
#[test]
fn charts_without_an_area_have_light() {
    let mut file = lit();
    file.quad("flat", SIDES, Some([Vec2::splat(0.505); 2]));
    let positions = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, z]| Vec3::new(x, -1.0, z));
    let uvs = [Vec2::splat(0.1), Vec2::splat(0.2), Vec2::splat(0.3), Vec2::new(0.1, 0.3)];
    let mesh = file.mesh("sliver", &positions, &[[0, 1, 2], [0, 2, 3], [1, 1, 1]], Some(&uvs));
    file.node(json!({"mesh": mesh}));
    for unwrap in [false, true] {
        let baked = bake(&file, BakeSettings { unwrap, ..MAPS });
        assert_eq!(baked.surfaces, 2);
        if !unwrap {
            let map = &baked.maps[0];
            let place = 64 * 32 + 32;
            assert!(map.values[place].x > 0.5, "{}", map.values[place]);
        }
    }
}

/// Two surfaces that meet within a plane show the same light along their edge; in radiance they keep their colours.
#[test]
fn surfaces_meet_alike() {
    let mut file = lit();
    let charts = [[0.0, 0.45], [0.55, 0.97]].map(|[low, high]| Some([Vec2::splat(low), Vec2::splat(high)]));
    file.quad("left", [Vec3::NEG_X, Vec3::X, Vec3::NEG_Z], charts[0]);
    let right = file.quad("right", [Vec3::X, Vec3::X, Vec3::NEG_Z], charts[1]);
    file.json["nodes"][0]["translation"] = json!([0.1, 0.3, 0.2]);
    let edge = |values: &[Vec3]| -> (f32, f32) {
        let map = |u: f32, v: f32| {
            let at = Vec2::new(u, v) * 48.0 - 0.5;
            let (low, part) = (at.floor(), at - at.floor());
            let texel = |x: f32, y: f32| values[(low.y + y) as usize * 48 + (low.x + x) as usize].x;
            let row = |y: f32| texel(0.0, y) * (1.0 - part.x) + texel(1.0, y) * part.x;
            row(0.0) * (1.0 - part.y) + row(1.0) * part.y
        };
        let s = |k: u32| (k as f32 + 1.0) / 22.0;
        let pairs: Vec<[f32; 2]> = (0..21).map(|k| [map(0.45, 0.45 * s(k)), map(0.55, 0.55 + 0.42 * s(k))]).collect();
        let light = pairs.iter().map(|[a, _]| a).sum::<f32>();
        (pairs.iter().map(|[a, b]| (a - b).abs()).sum::<f32>() / light, light / 21.0)
    };
    let settings = BakeSettings { page: 48, ..MAPS };
    let (difference, _) = edge(&bake(&file, settings).maps[0].values);
    assert!(difference < 0.01, "{difference}");
    // A black surface beside a white one.
    file.json["materials"]
        .as_array_mut()
        .unwrap()
        .push(json!({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}));
    let mesh = file.json["nodes"][right]["mesh"].as_u64().unwrap() as usize;
    file.json["meshes"][mesh]["primitives"][0]["material"] = json!(1);
    let (text, binary) = chunks(&bake(&file, BakeSettings { form: Form::Emission, ..settings }).glb);
    let json: Value = serde_json::from_str(&text).unwrap();
    let view = &json["bufferViews"][json["images"][0]["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let png = &binary[start..start + view["byteLength"].as_u64().unwrap() as usize];
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; 3 * 48 * 48];
    reader.next_frame(&mut bytes).unwrap();
    let values: Vec<Vec3> = bytes.chunks_exact(3).map(|c| Vec3::splat(f32::from(c[0]) / 255.0)).collect();
    let (difference, light) = edge(&values);
    assert!(difference > 0.95 && light > 0.3, "{difference} {light}");
}

/// Along the seams of charts both sides show the same light, within 1 % in the mean.
#[test]
fn seams_agree() {
    let mut file = lit();
    // A round body: a ring of flat sides with common normals is one surface in many charts.
    let (columns, rows) = (24_u32, 12_u32);
    let at = |i: u32, j: u32| {
        let (turn, rise) =
            (core::f32::consts::TAU * i as f32 / columns as f32, core::f32::consts::PI * j as f32 / rows as f32);
        Vec3::new(turn.cos() * rise.sin(), rise.cos() - 1.0, -turn.sin() * rise.sin())
    };
    let positions: Vec<Vec3> = (0..columns * (rows + 1)).map(|k| at(k % columns, k / columns)).collect();
    let index = |i: u32, j: u32| j * columns + i % columns;
    let cell = |k: u32| {
        let (i, j) = (k % columns, k / columns);
        let corners = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
        [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    };
    let triangles: Vec<[u32; 3]> = (0..columns * rows).flat_map(cell).collect();
    let mesh = file.mesh("body", &positions, &triangles, None);
    let normals: Vec<u8> = positions
        .iter()
        .flat_map(|p| (*p + Vec3::Y).normalize_or(Vec3::Y).to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let start = file.binary.len();
    file.binary.extend(normals);
    let view = json!({"buffer": 0, "byteOffset": start, "byteLength": 12 * positions.len()});
    file.json["bufferViews"].as_array_mut().unwrap().push(view);
    let view = file.json["bufferViews"].as_array().unwrap().len() - 1;
    let accessor = json!({"bufferView": view, "componentType": 5126, "count": positions.len(), "type": "VEC3"});
    file.json["accessors"].as_array_mut().unwrap().push(accessor);
    let accessor = file.json["accessors"].as_array().unwrap().len() - 1;
    file.json["meshes"][mesh]["primitives"][0]["attributes"]["NORMAL"] = json!(accessor);
    file.node(json!({"mesh": mesh}));
    let baked = bake(&file, BakeSettings { page: 256, ..MAPS });
    let (mean, most) = crate::support::seams(&baked);
    println!("seams: {:.2} % in the mean, {:.2} % at most", 100.0 * mean, 100.0 * most);
    assert!(mean < 0.01, "{mean}");
    // Of several lights, of which each ends at some seam, both the whole and the sum.
    file.light(json!({"type": "point", "intensity": 4.0, "color": [0.1, 0.3, 1.0]}), Vec3::new(-1.5, -1.2, 0.8));
    let baked = bake(&file, BakeSettings { page: 256, per_light: true, ..MAPS });
    let (mean, _) = crate::support::seams(&baked);
    assert!(mean < 0.01, "{mean}");
    let [all, one, other] = [0, 1, 2].map(|k| &baked.maps[k].values);
    for (place, ((all, one), other)) in all.iter().zip(one).zip(other).enumerate() {
        assert!((*all - *one - *other).length() <= 1e-5 * all.length(), "{place}: {all} {one} {other}");
    }
}
