//! The light of texels and vertices.

use crate::support::{File, WHOLE, bake};
use bake::{BakeSettings, Form};
use core::f64::consts::PI;
use glam::{DVec3, Vec2, Vec3};
use serde_json::json;

const MAPS: BakeSettings = BakeSettings { form: Form::Lightmap, page: 32, ..BakeSettings::DEFAULT };

/// Irradiance on a floor at height 0 of a point that shines with an intensity of 1 in all directions: `cos θ/d²`.
fn point(light: DVec3, x: f64, z: f64) -> f64 {
    let to = light - DVec3::new(x, 0.0, z);
    to.y / to.length().powi(3)
}

/// The mean over a rectangle, by 40 × 40 points.
fn mean([x0, x1]: [f64; 2], [z0, z1]: [f64; 2], f: impl Fn(f64, f64) -> f64) -> f64 {
    let n = 40;
    let at = |from: f64, to: f64, k: usize| from + (to - from) * (k as f64 + 0.5) / n as f64;
    (0..n * n).map(|k| f(at(x0, x1, k % n), at(z0, z1, k / n))).sum::<f64>() / (n * n) as f64
}

/// A floor from −2 to 2 whose coordinates are a square of the page, under a point light.
fn floor(square: Option<[Vec2; 2]>) -> File {
    let mut file = File::new();
    // u goes with x, v against z.
    file.quad("floor", [Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], square);
    file.light(json!({"type": "point", "intensity": 5.0, "color": [1.0, 0.5, 0.25]}), Vec3::new(0.5, 1.0, 0.3));
    file
}

const LIGHT: DVec3 = DVec3::new(0.5, 1.0, 0.3);

/// Each texel is the mean over its square, by a closed form; the second-order error of 2 × 2 points is below 0.1 % of the largest.
#[test]
fn texels_are_means() {
    for (samples, most) in [(1, 4e-3), (2, 1e-3), (4, 4e-4)] {
        let baked = bake(&floor(WHOLE), BakeSettings { samples, ..MAPS });
        let map = &baked.maps[0];
        assert_eq!((map.size, baked.texels), ([32, 32], 1024));
        let side = |k: usize| [k as f64, (k + 1) as f64].map(|k| -2.0 + 4.0 * k / 32.0);
        let peak = 5.0 * point(LIGHT, LIGHT.x, LIGHT.z);
        for (place, value) in map.values.iter().enumerate() {
            let [z1, z0] = side(place / 32).map(|z| -z);
            let want = 5.0 * mean(side(place % 32), [z0, z1], |x, z| point(LIGHT, x, z));
            for (k, tint) in [1.0, 0.5, 0.25].into_iter().enumerate() {
                assert!((f64::from(value[k]) - tint * want).abs() < most * peak, "{samples} {place}: {value} {want}");
            }
        }
    }
}

/// A texel that lies half on the floor is the mean over this half: not darker, and not of what lies beyond. Its neighbours beyond the
/// edge repeat it.
#[test]
fn texels_at_edges_are_means_over_the_surface() {
    // From a third of a texel into the page.
    let square = Some([Vec2::splat(4.4 / 32.0), Vec2::splat(27.7 / 32.0)]);
    let baked = bake(&floor(square), MAPS);
    let map = &baked.maps[0];
    let (low, high) = (4.4, 27.7);
    let world = |k: f64| -2.0 + 4.0 * (k.clamp(low, high) - low) / (high - low);
    for (x, y) in [(4, 4), (27, 9), (10, 27), (4, 17), (16, 4)] {
        let sides = [x, y].map(|k: usize| [k as f64, (k + 1) as f64].map(world));
        let want = 5.0 * mean(sides[0], sides[1].map(|z| -z), |x, z| point(LIGHT, x, z));
        let value = f64::from(map.values[y * 32 + x].x);
        assert!((value - want).abs() < 2e-3 * want, "{x} {y}: {value} {want}");
    }
    assert_eq!(baked.texels, 24 * 24);
    let at = |x: usize, y: usize| map.values[y * 32 + x];
    // The mean of the three texels beside it.
    let beside = (at(4, 9) + at(4, 10) + at(4, 11)) / 3.0;
    assert!((at(3, 10) - beside).length() < 1e-6 * beside.length());
}

/// A sphere light of some size: `E = π L (r/d)² cos θ`, exactly.
#[test]
fn vertices_have_the_light_of_their_places() {
    let mut file = File::new();
    let at = |k: u32| Vec3::new((k % 9) as f32 - 4.0, 0.0, (k / 9) as f32 - 4.0);
    let positions: Vec<Vec3> = (0..81).map(at).collect();
    let cell = |k: u32| [[k, k + 9, k + 10], [k, k + 10, k + 1]];
    let triangles: Vec<[u32; 3]> = (0..72).filter(|k| k % 9 < 8).flat_map(cell).collect();
    let mesh = file.mesh("grid", &positions, &triangles, None);
    file.node(json!({"mesh": mesh}));
    file.light(json!({"type": "point", "intensity": 2.0}), Vec3::new(0.0, 3.0, 0.0));
    let baked = bake(&file, BakeSettings { form: Form::VertexColors, ..MAPS });
    assert_eq!((baked.vertices, baked.scale), (81, 1.0));
    let (text, binary) = crate::support::chunks(&baked.glb);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let color = json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"].as_u64().unwrap() as usize;
    let view = &json["bufferViews"][json["accessors"][color]["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    for (k, place) in positions.iter().enumerate() {
        let bytes = &binary[start + 12 * k..start + 12 * k + 4];
        let value = f64::from(f32::from_le_bytes(bytes.try_into().unwrap()));
        let want = 2.0 * point(DVec3::new(0.0, 3.0, 0.0), f64::from(place.x), f64::from(place.z)) / PI;
        // Corners are two hundredths of a triangle inside.
        assert!((value - want).abs() < 0.02 * want, "{place}: {value} {want}");
    }
    assert!(json["materials"][1]["extensions"]["KHR_materials_unlit"].is_object());
}

/// Light is linear: maps of single lights add up to that of all, shadows included.
#[test]
fn single_lights_add_up() {
    let mut file = floor(WHOLE);
    file.block("block", Vec3::new(-0.5, 0.3, -0.2), Vec3::splat(0.3));
    file.light(json!({"type": "directional", "intensity": 1.0, "color": [0.2, 0.4, 1.0]}), Vec3::ZERO);
    file.light(json!({"type": "point", "intensity": 9.0}), Vec3::new(-1.5, 2.0, 1.0));
    file.json["nodes"][3]["rotation"] = json!([-0.5, 0.1, 0.1, 0.7]);
    let baked = bake(&file, BakeSettings { per_light: true, ..MAPS });
    let names: Vec<&str> = baked.maps.iter().map(|map| map.name.as_str()).collect();
    let lights = ["light0", "light1", "light2"].map(|light| format!("lightmap0.{light}"));
    assert_eq!(names[0], "lightmap0");
    assert!(lights.iter().all(|name| names.contains(&name.as_str())) && names.len().is_multiple_of(4), "{names:?}");
    let map = |name: &str| &baked.maps.iter().find(|map| map.name == name).unwrap().values;
    let all = map("lightmap0");
    let mut dark = [0; 3];
    for (place, value) in all.iter().enumerate() {
        let parts = [0, 1, 2].map(|k| map(&lights[k])[place]);
        let sum: Vec3 = parts.iter().sum();
        assert!((sum - *value).length() <= 1e-5 * value.length() + 1e-7, "{place}: {sum} {value}");
        (0..3).for_each(|k| dark[k] += usize::from(parts[k] == Vec3::ZERO));
    }
    assert!(dark.iter().all(|count| *count > 3), "each light casts a shadow: {dark:?}");
}

/// The same bytes by one thread and by three.
#[test]
fn bytes_do_not_depend_on_threads() {
    let mut file = floor(None);
    file.block("block", Vec3::new(-0.5, 0.5, -0.2), Vec3::splat(0.3));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake(&file, BakeSettings { page: 128, ..MAPS }))
    };
    let (one, three) = (with(1), with(3));
    assert_eq!(one.glb, three.glb);
    assert_eq!(one.maps, three.maps);
    assert!(one.texels > 4000);
}

/// A surface that shines shows no lights of a viewer in its coat; one that is lit by a map keeps it.
#[test]
fn coats_stay_where_lights_do() {
    let mut file = floor(WHOLE);
    file.json["extensionsUsed"] = json!(["KHR_materials_clearcoat"]);
    file.json["materials"][0]["extensions"] = json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1}});
    for (form, keeps) in [(Form::Emission, false), (Form::Lightmap, true)] {
        let baked = bake(&file, BakeSettings { form, ..MAPS });
        let json: serde_json::Value = serde_json::from_str(&crate::support::chunks(&baked.glb).0).unwrap();
        let extensions = &json["materials"][1]["extensions"];
        assert!(extensions.is_object() && extensions["KHR_materials_clearcoat"].is_null() != keeps, "{extensions}");
    }
}

/// Baked radiance is colour · E/π, and own light beside it.
#[test]
fn emission_is_reflected_and_own_light() {
    let mut file = floor(WHOLE);
    let material = json!({
        "name": "paint", "alphaCutoff": 0.3, "alphaMode": "MASK", "extras": {"a": 1.50},
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.4, 0.2, 0.8], "metallicFactor": 0.25, "roughnessFactor": 0.3},
        "emissiveFactor": [0.0, 0.0, 0.125],
    });
    file.json["materials"][0] = material;
    let maps = bake(&file, MAPS);
    let shown = bake(&file, BakeSettings { form: Form::Emission, ..MAPS });
    let (text, binary) = crate::support::chunks(&shown.glb);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let new = &json["materials"][1];
    assert_eq!((&new["name"], &new["alphaCutoff"], &new["extras"]), (&json!("paint"), &json!(0.3), &json!({"a": 1.5})));
    assert_eq!(new["pbrMetallicRoughness"]["baseColorFactor"], json!([0, 0, 0, 0.8]));
    assert_eq!(json["meshes"][0]["primitives"][0]["material"], json!(1));
    let scale = new["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"].as_f64().unwrap();
    let image = &json["images"][0];
    let view = &json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
    let start = view["byteOffset"].as_u64().unwrap() as usize;
    let png = &binary[start..start + view["byteLength"].as_u64().unwrap() as usize];
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; 3 * 1024];
    reader.next_frame(&mut bytes).unwrap();
    let decode = |byte: u8| {
        let x = f64::from(byte) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    };
    let mut sums = [[0.0; 2]; 3];
    for (place, value) in maps.maps[0].values.iter().enumerate() {
        for (k, color) in [0.5, 0.4, 0.2].into_iter().enumerate() {
            let own = if k == 2 { 0.125 } else { 0.0 };
            sums[k][0] += color * 0.75 * f64::from(value[k]) / PI + own;
            sums[k][1] += decode(bytes[3 * place + k]) * scale;
        }
    }
    for [want, found] in sums {
        assert!((found / want - 1.0).abs() < 2e-3, "{found} {want}");
    }
}

/// A map of one colour as a data URI.
fn one_color(color: [u8; 3]) -> String {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&color.repeat(4)).unwrap();
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let quad = |c: &[u8]| {
        let word = [0, 1, 2].iter().fold(0_u32, |w, k| w << 8 | u32::from(c.get(*k).copied().unwrap_or(0)));
        [18, 12, 6, 0].map(|s| digits[(word >> s & 63) as usize] as char).into_iter().take(c.len() + 1).collect()
    };
    let mut text: String = bytes.chunks(3).map(|c| -> String { quad(c) }).collect();
    text.push_str(&"=".repeat(text.len().next_multiple_of(4) - text.len()));
    format!("data:image/png;base64,{text}")
}

/// Light of texels is that of the normals of a map, in frames of the coordinates that it lies by, turned and mirrored ones too; vertices have
/// the light of their own normals.
#[test]
fn normal_maps_turn_the_light() {
    // Of u 0.6, of v upward 0, of the normal 0.8.
    let normal = one_color([204, 128, 230]);
    for (square, [x, z]) in [
        ([Vec2::ZERO, Vec2::ONE], [0.6, 0.0]),
        // u grows against x.
        ([Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)], [-0.6, 0.0]),
    ] {
        let mut file = File::new();
        file.quad("floor", [Vec3::ZERO, Vec3::X, Vec3::NEG_Z], Some(square));
        // Down, from where x, y and z are 0.48, 0.8 and 0.36.
        file.light(json!({"type": "directional", "intensity": 2.0}), Vec3::ZERO);
        let toward = Vec3::new(0.48, 0.8, 0.36);
        file.json["nodes"][1]["rotation"] = json!(glam::Quat::from_rotation_arc(Vec3::Z, toward).to_array());
        file.json["images"] = json!([{"uri": normal}]);
        file.json["textures"] = json!([{"source": 0}]);
        file.json["materials"][0]["normalTexture"] = json!({"index": 0});
        let want = 2.0 * Vec3::new(x, 0.8, z).dot(toward);
        let light = bake(&file, MAPS).maps[0].values[16 * 32 + 16].x;
        assert!((light - want).abs() < 0.02, "{light} {want}");
        let colors = bake(&file, BakeSettings { form: Form::VertexColors, ..MAPS });
        let color = crate::support::Baked3::new(&colors).mesh(0).colors[0].x * colors.scale;
        assert!((color * core::f32::consts::PI - 1.6).abs() < 0.01, "{color}");
    }
}

/// Work stops on request, by the listener and by another thread, and begins again.
#[test]
fn baking_stops_on_request() {
    use core::ops::ControlFlow;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("floor.glb");
    std::fs::write(&path, floor(None).glb()).unwrap();
    let open =
        || bake::Baker::open(&path, &scene_files::LoadOptions::new(), MAPS, renderer::Settings::default()).unwrap();
    for stage in [bake::Stage::Coordinates, bake::Stage::Light] {
        let mut baker = open();
        let stopped =
            baker.bake(&mut |at, _| if at == stage { ControlFlow::Break(()) } else { ControlFlow::Continue(()) });
        assert!(stopped.is_err_and(|error| error.is_cancelled()), "{stage:?}");
        assert!(baker.bake(&mut |_, _| ControlFlow::Continue(())).is_ok());
    }
    let mut baker = open();
    let cancel = scene::Cancel::new();
    baker.set_cancel(cancel.clone());
    cancel.cancel();
    assert!(baker.bake(&mut |_, _| ControlFlow::Continue(())).is_err_and(|error| error.is_cancelled()));
}
