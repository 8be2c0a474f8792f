use crate::clip::Polygon;
use crate::fit::tangents;
use crate::layer::{EMPTY, Layer, Part};
use crate::polygon_union::PolygonUnion;
use glam::{DVec3, Vec2, Vec3};
use lobe_core::oracle::Random;
use visibility_mask::{Mask, UnitSquare};

fn mask(depth: u32) -> Mask {
    let mut mask = Mask::default();
    mask.reset(&UnitSquare::default(), depth, Vec3::Z);
    mask
}

/// The fraction of the unit disc that the union leaves visible.
fn seen(union: &PolygonUnion, depth: u32) -> f32 {
    let mut mask = mask(depth);
    union.write(&mut mask);
    let (all, seen) = mask.areas();
    seen / all
}

#[test]
fn polygons_cover_their_area() {
    let mut random = Random::new(1);
    for depth in [1, 3, 5, 6] {
        let (mut sum, mut worst) = (0.0_f64, 0.0_f64);
        for _ in 0..200 {
            // A quadrilateral inside the disc: its corners in order around a circle.
            let radius = random.between(0.2, 0.95) as f32;
            let mut turns = [0; 4].map(|_| random.between(0.0, std::f64::consts::TAU) as f32);
            turns.sort_by(f32::total_cmp);
            let mut points = turns.map(|t| Vec2::from_angle(t) * radius);
            let area: f32 = (0..4).map(|k| 0.5 * points[k].perp_dot(points[(k + 1) % 4])).sum();
            let mut union = PolygonUnion::default();
            union.begin(&mask(depth));
            union.polygon(&mut points, [0.0; 4]);
            let error = f64::from(1.0 - seen(&union, depth) - area / std::f32::consts::PI).abs();
            sum += error;
            worst = worst.max(error);
        }
        // Lines are a quarter of a cell apart: an edge along them errs by up to an eighth of a cell.
        let line = 2.0 / f64::from(1 << depth) / 4.0;
        println!("depth {depth}: mean {:.1e}, max {worst:.1e}", sum / 200.0);
        assert!(worst < line && sum / 200.0 < 0.15 * line);
    }
}

#[test]
fn a_tiling_leaves_no_gap_in_any_order() {
    let mut random = Random::new(2);
    for n in [1, 3, 17, 90] {
        // A wavy grid over the window, its quadrilaterals in random order.
        let corner = |i: usize, j: usize| {
            let (x, y) = (i as f32 / n as f32 * 2.6 - 1.3, j as f32 / n as f32 * 2.6 - 1.3);
            Vec2::new(x + 0.1 * (3.0 * y).sin(), y + 0.1 * (2.0 * x).cos())
        };
        let mut tiles: Vec<usize> = (0..n * n).collect();
        for k in (1..tiles.len()).rev() {
            tiles.swap(k, random.bits() as usize % (k + 1));
        }
        let mut union = PolygonUnion::default();
        union.begin(&mask(5));
        for tile in tiles {
            let (i, j) = (tile % n, tile / n);
            union.polygon(&mut [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)], [0.0; 4]);
        }
        assert_eq!(seen(&union, 5), 0.0, "{n}");
        assert!(union.is_covered(Vec2::splat(-1.0), Vec2::splat(1.0)));
    }
}

#[test]
fn covered_is_what_was_drawn() {
    let mut union = PolygonUnion::default();
    union.begin(&mask(4));
    union.polygon(&mut [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| Vec2::new(x, y)), [0.0; 4]);
    assert!(union.is_covered(Vec2::splat(-0.5), Vec2::splat(0.5)));
    assert!(!union.is_covered(Vec2::splat(-0.51), Vec2::splat(0.5)));
    assert!(!union.is_covered(Vec2::splat(0.4), Vec2::new(0.45, 0.55)));
    // Growth of single edges: below, right, above, left.
    for (k, side) in [Vec2::NEG_Y, Vec2::X, Vec2::Y, Vec2::NEG_X].into_iter().enumerate() {
        let mut grow = [0.0; 4];
        grow[k] = 0.1;
        let mut union = PolygonUnion::default();
        union.begin(&mask(4));
        union.polygon(&mut [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| Vec2::new(x, y)), grow);
        let beyond = |at: Vec2| union.is_covered(at - 0.01, at + 0.01);
        for (other, to) in [Vec2::NEG_Y, Vec2::X, Vec2::Y, Vec2::NEG_X].into_iter().enumerate() {
            // An edge along the lines moves only if both its neighbours do: the gap is less than a line.
            assert_eq!(beyond(to * 0.55), other == k && side.x != 0.0, "{k} {other}");
        }
    }
}

#[test]
fn corners_of_a_plane_are_exact_and_its_pyramid_is_flat() {
    let (width, height) = (37, 20);
    let plane = |x: f32, y: f32| 0.01 * x - 0.02 * y + 0.1;
    let q = (0..width * height).map(|k| plane((k % width) as f32 + 0.5, (k / width) as f32 + 0.5)).collect();
    let layer = Layer::new(width, height, 0.1, q).expect("a surface");
    for j in 1..height - 1 {
        for i in 1..width - 1 {
            let (x, y) = (i as f32, j as f32);
            let expected = [plane(x, y), plane(x + 1.0, y), plane(x + 1.0, y + 1.0), plane(x, y + 1.0)];
            for (q, expected) in layer.corners(0, i, j).into_iter().zip(expected) {
                assert!((q - expected).abs() < 1e-6);
            }
        }
    }
    // Away from the rim, where corners equal texels.
    let node = layer.node(3, 1, 1);
    assert!(node.deviation < 1e-6, "{}", node.deviation);
    assert!(layer.node(layer.top(), 0, 0).deviation.is_finite());
}

#[test]
fn the_pyramid_knows_its_own_corners() {
    // A smooth layer, one with steps, one with holes: deviations against the corners of all texels.
    let mut random = Random::new(4);
    let (width, height) = (29, 23);
    for holes in [0.0, 0.02] {
        let q: Vec<f32> = (0..width * height)
            .map(|k| {
                let (x, y) = ((k % width) as f32, (k / width) as f32);
                let step = if x + 0.5 * y > 21.0 { 1.5 } else { 0.0 };
                if random.uniform() < holes { EMPTY } else { (0.2 * x).sin() * 0.3 + 0.01 * y * y * 0.3 + step }
            })
            .collect();
        let layer = Layer::new(width, height, 0.1, q.clone()).expect("a surface");
        for level in 1..=layer.top() {
            let (columns, rows) = layer.size(level);
            for (i, j) in (0..columns * rows).map(|k| (k % columns, k / columns)) {
                let (node, [x0, x1, y0, y1]) = (layer.node(level, i, j), layer.texels(level, i, j));
                let own = layer.corners(level, i, j);
                let mut worst = 0.0_f32;
                for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                    if q[y * width + x] == EMPTY {
                        worst = f32::INFINITY;
                        continue;
                    }
                    let corners = layer.corners(0, x, y);
                    for (q, (x, y)) in corners.into_iter().zip([(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]) {
                        let (s, t) = ((x - x0) as f32 / (x1 - x0) as f32, (y - y0) as f32 / (y1 - y0) as f32);
                        let at = (own[0] * (1.0 - s) + own[1] * s) * (1.0 - t) + (own[3] * (1.0 - s) + own[2] * s) * t;
                        worst = worst.max((q - at).abs());
                        assert!(q >= node.min && q <= node.max);
                    }
                }
                assert!(node.deviation >= worst - 1e-6, "level {level}: {} < {worst}", node.deviation);
                assert_eq!(node.deviation.is_finite(), worst.is_finite());
            }
        }
    }
}

#[test]
fn depth_steps_are_not_bridged() {
    let (width, height) = (8, 8);
    let mut q: Vec<f32> = (0..64).map(|k| if k % width < 4 { 0.0 } else { 1.0 }).collect();
    q[0] = EMPTY;
    let layer = Layer::new(width, height, 0.05, q).expect("a surface");
    assert_eq!(layer.corners(0, 3, 3), [0.0; 4]);
    assert_eq!(layer.corners(0, 4, 3), [1.0; 4]);
    let (left, all) = (layer.node(1, 1, 1), layer.node(3, 0, 0));
    assert_eq!((left.min, left.max, left.deviation), (0.0, 0.0, 0.0));
    assert_eq!((all.min, all.max, all.deviation), (0.0, 1.0, f32::INFINITY));
    const ONE_DEPTH: [f32; 2] = [f32::NEG_INFINITY, 0.1];
    let corner = layer.texels(1, 0, 0);
    // Three of four texels in the corner: three quarters of the area, on the side where they are.
    let Some([Some(part), None]) = layer.parts(corner, 1, ONE_DEPTH, |_, _, _| true) else { panic!("one depth") };
    assert_eq!((area(&part), part.q), (3.0, 0.0));
    assert_eq!(part.corners, [[1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
    // Both sides of the step in the upper half, from 4 × 4 of the texels.
    let all = layer.texels(3, 0, 0);
    let Some([Some(near), Some(far)]) = layer.parts(all, 2, [0.5, 0.1], |_, j, _| j > 4.0) else {
        panic!("two depths")
    };
    assert_eq!((area(&near), near.q, area(&far), far.q), (16.0, 1.0, 16.0, 0.0));
    assert_eq!(layer.parts(all, 2, [0.5, 0.1], |_, _, _| false), Some([None; 2]));
    // Two depths in one part are too many, unless one of them blocks nothing.
    assert_eq!(layer.parts(all, 2, ONE_DEPTH, |_, _, _| true), None);
    assert!(layer.parts(all, 2, ONE_DEPTH, |_, _, q| q > 0.5).is_some());
}

fn area(part: &Part) -> f32 {
    let corners = part.corners.map(Vec2::from_array);
    (0..4).map(|k| 0.5 * corners[k].perp_dot(corners[(k + 1) % 4])).sum()
}

#[test]
fn a_part_is_where_its_texels_are() {
    let (width, height) = (4, 4);
    // Below a slanted line, which leaves through both sides.
    let q =
        (0..16).map(|k| if (k / width) as f32 + 0.5 < 1.0 + 0.5 * ((k % width) as f32 + 0.5) { 0.5 } else { EMPTY });
    let layer = Layer::new(width, height, 0.1, q.collect()).expect("a surface");
    let parts = layer.parts(layer.texels(2, 0, 0), 1, [f32::NEG_INFINITY, 0.1], |_, _, _| true);
    let Some([Some(part), None]) = parts else { panic!("one depth") };
    assert_eq!(area(&part), 8.0);
    let ([left, right], want) = ([part.corners[3][1], part.corners[2][1]], [1.0, 3.0]);
    assert!((left - want[0]).abs() < 0.3 && (right - want[1]).abs() < 0.3, "{left} {right}");
}

#[test]
fn clipping_halves_a_triangle() {
    let triangle = Polygon::new(&[DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 2.0, 0.0)]);
    let part = triangle.clip(|p: DVec3| 1.0 - p.x);
    let corners = part.corners();
    let area: f64 = (0..corners.len()).map(|k| 0.5 * corners[k].cross(corners[(k + 1) % corners.len()]).z).sum();
    assert_eq!((corners.len(), area), (4, 1.5));
    assert!(triangle.clip(|p: DVec3| -1.0 - p.x).corners().is_empty());
}

#[test]
fn tangents_touch_both_discs() {
    let mut random = Random::new(3);
    for _ in 0..500 {
        let (x, z) = (random.between(-3.0, 3.0), random.between(-3.0, 3.0));
        let (radius, spread) = (random.between(0.0, 1.5), random.between(0.0, 1.5));
        let Some(normals) = tangents(x, z, spread, radius) else {
            assert!(x.hypot(z) <= (radius - spread).abs());
            continue;
        };
        for [a, b] in normals {
            assert!((a.hypot(b) - 1.0).abs() < 1e-12);
            assert!((a * x + b * z + spread - radius).abs() < 1e-12);
        }
    }
}
