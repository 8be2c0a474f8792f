//! Triangles that are divided where light changes.

use crate::support::{Baked3, File, bake, chunks, try_bake};
use bake::{BakeSettings, Form};
use glam::{Vec2, Vec3};
use serde_json::{Value, json};
use std::collections::HashMap;

const COLORS: BakeSettings = BakeSettings { form: Form::VertexColors, subdivide: Some(0.02), ..BakeSettings::DEFAULT };

const LIGHT: Vec3 = Vec3::new(0.5, 1.0, 0.3);

/// A floor of two triangles from −2 to 2, and above it a smaller one, under a point light.
fn room() -> File {
    let mut file = File::new();
    file.quad("floor", [Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], None);
    file.light(json!({"type": "point", "intensity": 2.0}), LIGHT);
    file
}

/// The colour of a floor of albedo 1 under the light.
fn want(p: Vec3) -> f32 {
    let to = LIGHT - p;
    2.0 * to.y / to.length().powi(3) * core::f32::consts::FRAC_1_PI
}

/// Light between vertices is as near as requested, with fewer vertices where less is requested.
#[test]
fn interpolated_light_is_near() {
    let mut counts = Vec::new();
    for error in [0.2, 0.05, 0.01] {
        let baked = bake(&room(), BakeSettings { subdivide: Some(error), ..COLORS });
        let made = baked.subdivision.unwrap();
        assert!(!made.is_cut && made.beyond == 0.0, "{made:?}");
        let mesh = Baked3::new(&baked).mesh(0);
        let mut mean = 0.0;
        let mut all = Vec::new();
        for t in &mesh.triangles {
            let [p, c] = [&mesh.positions, &mesh.colors].map(|list| t.map(|i| list[i]));
            for [u, v] in [[0.33, 0.33], [0.5, 0.25], [0.05, 0.9], [0.1, 0.2]] {
                let mix = |a: [Vec3; 3]| a[0] * (1.0 - u - v) + a[1] * u + a[2] * v;
                let area = (p[1] - p[0]).cross(p[2] - p[0]).length();
                mean += 0.25 * area * want(mix(p)) / 32.0;
                all.push((mix(c).x * baked.scale - want(mix(p))).abs());
            }
        }
        let most = all.iter().copied().fold(0.0, f32::max);
        // Points between the tested ones may be a little farther off.
        assert!(most < 1.3 * error * mean + 0.002 * mean, "{error}: {most} of {mean}");
        assert!(made.mean_error < f64::from(error) && mesh.triangles.len() as u64 == made.triangles);
        counts.push(mesh.positions.len());
    }
    assert!(counts[0] < counts[1] && counts[1] < counts[2] && counts[2] < 5000, "{counts:?}");
}

/// Every edge inside of the floor, which is two meshes of a triangle each, has the same ends on both sides; so has every edge of a shadow.
#[test]
fn no_edge_ends_inside_of_another() {
    let mut file = File::new();
    let at = [[-2.0, 2.0], [2.0, 2.0], [2.0, -2.0], [-2.0, -2.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    for corners in [[0, 1, 2], [0, 2, 3]] {
        let mesh = file.mesh("half", &corners.map(|k: usize| at[k]), &[[0, 1, 2]], None);
        file.node(json!({"mesh": mesh}));
    }
    file.block("block", Vec3::new(0.3, 0.5, 0.2), Vec3::splat(0.1));
    file.light(json!({"type": "point", "intensity": 2.0}), LIGHT);
    let baked = bake(&file, BakeSettings { density: Some(16.0), ..COLORS });
    let found = Baked3::new(&baked);
    let mut edges: HashMap<_, usize> = HashMap::new();
    let (mut area, mut shortest) = (0.0, 9.0_f32);
    for mesh in [found.mesh(0), found.mesh(1)] {
        assert!(mesh.triangles.len() > 50, "{}", mesh.triangles.len());
        for t in &mesh.triangles {
            let p = t.map(|i| mesh.positions[i]);
            area += 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).y;
            for k in 0..3 {
                let (a, b) = (p[k], p[(k + 1) % 3]);
                shortest = shortest.min(a.distance(b));
                let on_border = (0..3).any(|axis| a[axis] == b[axis] && a[axis].abs() == 2.0);
                if !on_border {
                    let bits = [a, b].map(|p| (p + 0.0).to_array().map(f32::to_bits));
                    *edges.entry(if bits[0] < bits[1] { bits } else { [bits[1], bits[0]] }).or_default() += 1;
                }
            }
        }
    }
    assert!(edges.values().all(|count| *count == 2));
    assert!((area - 16.0).abs() < 1e-4);
    // Edges of less than 1/16 are not divided.
    assert!((1.0 / 32.0..0.0625).contains(&shortest), "{shortest}");
    assert!(baked.subdivision.unwrap().beyond > 0.0, "the light is a point");
}

/// At most as many vertices as are requested: the largest differences are mended first.
#[test]
fn vertices_are_bounded() {
    let error = |most_vertices: u32| {
        let baked = bake(&room(), BakeSettings { most_vertices, subdivide: Some(0.002), ..COLORS });
        let made = baked.subdivision.unwrap();
        assert!(made.is_cut && baked.vertices <= u64::from(most_vertices.max(4)), "{made:?}");
        assert!(baked.vertices > u64::from(most_vertices) / 2);
        made.mean_error
    };
    let [few, some, many] = [4, 100, 1000].map(error);
    assert!(few > 0.3 && some < 0.2 * few && many < 0.2 * some, "{few} {some} {many}");
}

/// A mesh with everything that a vertex can have, each a linear function of its place: interpolated it still is one. Integers are read as
/// what they stand for.
#[test]
fn attributes_are_interpolated() {
    let mut file = room();
    let places = [[-2.0_f32, 2.0], [2.0, 2.0], [2.0, -2.0], [-2.0, -2.0]];
    let unit = |k: usize| places[k].map(|x| (x + 2.0) / 4.0);
    let bytes = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|x| x.to_le_bytes()).collect() };
    let uv: Vec<u8> = (0..4).flat_map(|k| unit(k).map(|x| (x * 65535.0) as u16)).flat_map(u16::to_le_bytes).collect();
    file.attribute(0, "TEXCOORD_0", &uv, (5123, true), "VEC2");
    let color: Vec<u8> =
        (0..4).flat_map(|k| [255, (255.0 * unit(k)[0]) as u8, 0, (255.0 * unit(k)[1]) as u8]).collect();
    file.attribute(0, "COLOR_0", &color, (5121, true), "VEC4");
    let tilted: Vec<f32> = (0..4).flat_map(|k| [places[k][0] * 0.1, 1.0, 0.0]).collect();
    let normal: Vec<f32> = tilted.chunks_exact(3).flat_map(|n| Vec3::from_slice(n).normalize().to_array()).collect();
    file.attribute(0, "NORMAL", &bytes(&normal), (5126, false), "VEC3");
    file.attribute(0, "TANGENT", &bytes(&[1.0, 0.0, 0.0, -1.0].repeat(4)), (5126, false), "VEC4");
    file.attribute(0, "JOINTS_0", &[0, 1, 2, 3].repeat(4), (5121, false), "VEC4");
    let weight = |k: usize| {
        let [u, v] = unit(k);
        [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v].map(|w| (w * 255.0) as u8)
    };
    file.attribute(0, "WEIGHTS_0", &(0..4).flat_map(weight).collect::<Vec<u8>>(), (5121, true), "VEC4");
    let id: Vec<u8> = (0..4_u16).flat_map(|k| [k, 0]).flat_map(u16::to_le_bytes).collect();
    file.attribute(0, "_ID", &id, (5123, false), "VEC2");
    let moved: Vec<f32> = (0..4).flat_map(|k| [0.0, unit(k)[0], unit(k)[1]]).collect();
    file.attribute(0, "POSITION 0", &bytes(&moved), (5126, false), "VEC3");
    let target = file.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("POSITION 0");
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
    file.json["meshes"][0]["weights"] = json!([0.0]);
    // The joints stand where they are bound.
    file.json["skins"] = json!([{"joints": [2, 3, 4, 5]}]);
    file.json["nodes"][0]["skin"] = json!(0);
    for _ in 0..4 {
        file.node(json!({}));
    }
    let length = file.binary.len();
    let baked = bake(&file, COLORS);
    let found = Baked3::new(&baked);
    assert_eq!(&found.binary[..length], &file.binary[..], "the old bytes stay");
    let mesh = found.mesh(0);
    let rows = |name: &str| found.rows(&found.json["meshes"][0]["primitives"][0]["attributes"][name]);
    let (uvs, normals, tangents) = (rows("TEXCOORD_0"), rows("NORMAL"), rows("TANGENT"));
    let (colors, joints, weights, ids) = (rows("COLOR_0"), rows("JOINTS_0"), rows("WEIGHTS_0"), rows("_ID"));
    let morph = found.rows(&found.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"]);
    assert!(mesh.positions.len() > 100 && morph.len() == mesh.positions.len());
    for (k, p) in mesh.positions.iter().enumerate() {
        let [u, v] = [p.x, p.z].map(|x| f64::from(x + 2.0) / 4.0);
        let near = |row: &[f64], want: &[f64]| {
            let apart = row.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(row.len() == want.len() && apart < 1e-5, "{p}: {row:?} {want:?}");
        };
        near(&uvs[k], &[u, v]);
        near(&morph[k], &[0.0, u, v]);
        near(&colors[k][3..], &[v]);
        let length = normals[k].iter().map(|x| x * x).sum::<f64>();
        assert!((length - 1.0).abs() < 1e-5 && (normals[k][0] / normals[k][1] - 0.1 * f64::from(p.x)).abs() < 1e-5);
        near(&tangents[k], &[1.0, 0.0, 0.0, -1.0]);
        assert!((weights[k].iter().sum::<f64>() - 1.0).abs() < 1e-5);
        // On each triangle three corners are mixed: along the diagonal two.
        let of = |joint: f64| {
            let each = joints[k].iter().zip(&weights[k]).filter(|(j, _)| **j == joint);
            each.map(|(_, weight)| weight).sum::<f64>()
        };
        near(&[of(1.0) + of(3.0), of(2.0) + of(3.0)], &[u, v]);
        assert!(ids[k][1] == 0.0 && [0.0, 1.0, 2.0, 3.0].contains(&ids[k][0]));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("again.glb");
    std::fs::write(&path, &baked.glb).unwrap();
    let (scene, _) = scene_files::load_with_warnings(&path).unwrap();
    // A model gets a floor.
    assert_eq!(scene.triangles(), mesh.triangles.len() + 2);
}

/// A flat block has vertices of its own on each side, so that its edges are sharp; what needs no more vertices is written as it was.
#[test]
fn flat_sides_are_told_apart() {
    let mut file = File::new();
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let mesh = file.mesh("cube", &(0..8).map(corner).collect::<Vec<_>>(), &triangles, None);
    file.node(json!({"mesh": mesh}));
    let normals: Vec<u8> = [0.0_f32, 1.0, 0.0].repeat(4).iter().flat_map(|x| x.to_le_bytes()).collect();
    file.quad("far", [Vec3::new(9.0, 0.0, 0.0), Vec3::X * 0.1, Vec3::NEG_Z * 0.1], None);
    file.attribute(1, "NORMAL", &normals, (5126, false), "VEC3");
    let sun = file.light(json!({"type": "directional", "intensity": 2.0}), Vec3::ZERO);
    file.json["nodes"][sun]["rotation"] = json!([-0.707_106_77, 0.0, 0.0, 0.707_106_77]);
    let baked = bake(&file, BakeSettings { density: Some(100.0), ..COLORS });
    let (text, _) = chunks(&baked.glb);
    let json: Value = serde_json::from_str(&text).unwrap();
    let found = Baked3::new(&baked);
    let cube = found.mesh(0);
    assert_eq!((cube.positions.len(), cube.triangles.len()), (24, 12), "no light changes on it");
    for t in &cube.triangles {
        let p = t.map(|i| cube.positions[i]);
        let is_top = (p[1] - p[0]).cross(p[2] - p[0]).y > 0.5;
        let most = t.map(|i| cube.colors[i].x);
        assert!(most.iter().all(|light| (light - if is_top { 2.0 / core::f32::consts::PI } else { 0.0 }).abs() < 1e-3));
    }
    let far = |json: &Value| json["meshes"][1]["primitives"][0]["attributes"]["POSITION"].clone();
    assert_eq!(far(&json), far(&file.json), "its light is the same everywhere");
}

#[test]
fn other_forms_are_not_subdivided() {
    let mut file = room();
    for (settings, fault) in [
        (BakeSettings { form: Form::Emission, ..COLORS }, "form is Emission: expected colours of vertices"),
        (BakeSettings { subdivide: Some(0.0), ..COLORS }, "difference of subdivision is 0"),
        (BakeSettings { most_vertices: 0, ..COLORS }, "number of vertices is 0"),
        (BakeSettings { most_vertices: 3_000_000, ..COLORS }, "number of vertices is 3000000"),
        (BakeSettings { subdivide: Some(f32::NAN), ..COLORS }, "difference of subdivision is NaN"),
    ] {
        let found = try_bake(&file, settings).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(found.contains(fault), "{found}");
    }
    // Triangles without an area, and a light that lights nothing, are no fault.
    let flat = [Vec3::ZERO, Vec3::X, Vec3::X * 2.0];
    let mesh = file.mesh("flat", &flat, &[[0, 1, 2], [1, 1, 1]], Some(&[Vec2::ZERO; 3]));
    file.node(json!({"mesh": mesh, "translation": [0.0, 0.1, 0.0]}));
    file.json["nodes"][1]["translation"] = json!([0.0, -3.0, 0.0]);
    let baked = bake(&file, COLORS);
    assert!(baked.subdivision.is_some_and(|made| made.mean_error == 0.0) && baked.vertices == 4);
}
