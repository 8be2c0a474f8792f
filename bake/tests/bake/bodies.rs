//! Walls and bodies on surfaces.

use crate::support::{File, WHOLE, bake};
use bake::{BakeSettings, Form};
use glam::{Vec2, Vec3};
use serde_json::json;

const MAPS: BakeSettings = BakeSettings { form: Form::Lightmap, page: 64, ..BakeSettings::DEFAULT };

/// A closed box lets no light in: all of its inner walls are black, at its edges too, whether the coordinates are made or the file's.
#[test]
fn no_light_leaks_into_a_closed_room() {
    let mut file = File::new();
    let sides = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    for (k, normal) in sides.into_iter().enumerate() {
        let (a, b) = normal.any_orthonormal_pair();
        let (a, b) = if a.cross(b).dot(normal) > 0.0 { (a, b) } else { (b, a) };
        let low = Vec2::new((k % 3) as f32, (k / 3) as f32) / 3.0 + 0.04;
        // Inward, and around it a wall.
        file.quad(&format!("inside {k}"), [-normal, a, b], Some([low, low + 0.25]));
        file.block(&format!("wall {k}"), -normal * 1.1, Vec3::splat(1.2) - normal.abs() * 1.1);
    }
    for at in [Vec3::new(0.3, 1.4, 0.2), Vec3::new(-1.5, 0.0, -0.4), Vec3::new(2.0, 2.0, 2.0)] {
        file.light(json!({"type": "point", "intensity": 50.0}), at);
    }
    file.json["materials"].as_array_mut().unwrap().push(json!({"extensions": {"KHR_materials_unlit": {}}}));
    for mesh in file.json["meshes"].as_array_mut().unwrap() {
        if mesh["name"].as_str().unwrap().starts_with("wall") {
            mesh["primitives"][0]["material"] = json!(1);
        }
    }
    for unwrap in [false, true] {
        let baked = bake(&file, BakeSettings { unwrap, ..MAPS });
        assert!(baked.texels > 1000);
        let most = baked.maps.iter().flat_map(|map| &map.values).map(|v| v.max_element()).fold(0.0, f32::max);
        assert_eq!(most, 0.0, "unwrap: {unwrap}");
    }
}

/// A wall that stands on a floor, lit from one side: texels that it divides are of one side, with all of its light or none.
#[test]
fn a_wall_divides_texels() {
    let mut file = File::new();
    file.quad("floor", [Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], WHOLE);
    // In the middle of a column of texels, and a little beside it.
    let wall = 1.3 / 16.0;
    file.quad("wall", [Vec3::new(wall / 2.0, 1.0, 0.0), Vec3::Z * 3.0, Vec3::Y], None);
    file.light(json!({"type": "point", "intensity": 10.0}), Vec3::new(-1.0, 1.0, 0.0));
    let baked = bake(&file, MAPS);
    let map = &baked.maps[0];
    let column = |x: f32| ((x + 2.0) * 16.0) as usize;
    let divided = column(wall / 2.0);
    assert_eq!(divided, 32);
    let value = |x: usize, y: usize| map.values[y * 64 + x].x;
    for y in 2..62 {
        let [lit, half, dark] = [divided - 1, divided, divided + 1].map(|x| value(x, y));
        assert!(lit > 0.1 && dark == 0.0, "{y}: {lit} {dark}");
        assert!(half == 0.0 || (half - lit).abs() < 0.1 * lit, "{y}: {half} beside {lit}");
    }
}

/// Under a block the floor is inside of a body: it makes no dark rim around it, texels that it covers in part are those of the rest.
#[test]
fn bodies_leave_no_dark_rims() {
    let lit = |has_block: bool| {
        let mut file = File::new();
        file.quad("floor", [Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], WHOLE);
        if has_block {
            // Its shadow is as large as it is: the sun is straight above.
            file.block("block", Vec3::new(0.03, 0.25, 0.02), Vec3::new(0.5, 0.25, 0.5));
        }
        let sun = file.light(json!({"type": "directional", "intensity": 2.0}), Vec3::ZERO);
        file.json["nodes"][sun]["rotation"] = json!([-0.707_106_77, 0.0, 0.0, 0.707_106_77]);
        bake(&file, MAPS).maps[0].values.clone()
    };
    let (open, with) = (lit(false), lit(true));
    assert!(open.iter().all(|v| (v.x - 2.0).abs() < 1e-3));
    let inside = |place: usize| {
        let [x, z] = [place % 64, place / 64].map(|k| (k as f32 + 0.5) / 16.0 - 2.0);
        ((x - 0.03).abs() - 0.5).max((-z - 0.02).abs() - 0.5)
    };
    // The sun is a disc of a quarter of a degree: a tenth of a texel of penumbra.
    let at = |from: f32, to: f32| (0..4096).filter(move |k| (from..to).contains(&inside(*k)));
    assert!(at(0.04, 9.0).all(|k| with[k].x > 1.9), "around it");
    assert!(at(-0.03, 0.04).all(|k| with[k].x > 0.9), "{:?}", at(-0.03, 0.04).map(|k| with[k].x).fold(9.0, f32::min));
    assert!(at(-9.0, -0.2).all(|k| with[k].x == 0.0), "far under it");
}

/// Where a floor ends at a wall its edge has the light of the floor, not of beyond the wall: texels that hold nothing but the edge itself, by
/// rounding of coordinates, are those beside it.
#[test]
fn edges_at_walls_are_not_lit_from_behind() {
    let mut file = File::new();
    // From a texel's border, a millionth of a texel into the one before it.
    let square = Some([Vec2::new(7.999_999 / 64.0, 0.25), Vec2::new(0.75, 0.75)]);
    file.quad("floor", [Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0], square);
    file.quad(
        "wall",
        [Vec3::new(-2.0, 1.0, 0.0), Vec3::NEG_Z * 2.0, Vec3::Y],
        Some([Vec2::new(0.8, 0.8), Vec2::new(0.95, 0.95)]),
    );
    file.light(json!({"type": "point", "intensity": 10.0}), Vec3::new(-2.5, 1.0, 0.0));
    file.light(json!({"type": "point", "intensity": 1.0}), Vec3::new(0.0, 1.0, 0.0));
    let baked = bake(&file, BakeSettings { per_light: true, ..MAPS });
    let behind = baked.maps.iter().find(|map| map.name.ends_with("light0")).unwrap();
    let lit: Vec<usize> = (0..4096).filter(|place| behind.values[*place].x > 0.0).collect();
    assert!(lit.is_empty(), "{lit:?}");
    let before = baked.maps.iter().find(|map| map.name.ends_with("light1")).unwrap();
    let [edge, beside] = [7, 8].map(|x| before.values[32 * 64 + x].x);
    assert!((edge - beside).abs() < 0.01 * beside && beside > 0.05, "{edge} {beside}");
}
