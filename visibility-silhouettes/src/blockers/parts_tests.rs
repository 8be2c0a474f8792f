//! Parts between outlines against areas by f64.

use super::cells::Cells;
use super::parts::Bounds;
use super::trapezoids::{Emits, Path, Trapezoid, Trapezoids, open_numbers, sides, slivers};
use glam::{DVec2, Vec2, Vec3};
use lobe_core::oracle::Random;
use visibility_mask::{Mask, UnitSquare};

fn sides_of<T: Copy>(polygon: &[T]) -> impl Iterator<Item = [T; 2]> + '_ {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(p, q)| [*p, *q])
}

/// The area of a convex polygon's part that no other polygon covers, by all heights at which anything changes.
fn open_area(light: &[DVec2], polygons: &[Vec<DVec2>]) -> f64 {
    let all: Vec<[DVec2; 2]> = sides_of(light).chain(polygons.iter().flat_map(|polygon| sides_of(polygon))).collect();
    let mut heights: Vec<f64> = all.iter().map(|[p, _]| p.y).collect();
    for (k, [a, b]) in all.iter().enumerate() {
        for [c, d] in &all[..k] {
            let t = (*c - *a).perp_dot(*d - *c) / (*b - *a).perp_dot(*d - *c);
            heights.extend((t > 0.0 && t < 1.0).then(|| a.lerp(*b, t).y));
        }
    }
    heights.sort_unstable_by(f64::total_cmp);
    let ends_at = |polygon: &[DVec2], y: f64| {
        let met = sides_of(polygon).filter(|[p, q]| (p.y < y) != (q.y < y));
        let places = met.map(|[p, q]| p.x + (q.x - p.x) * (y - p.y) / (q.y - p.y));
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let open_at = |y: f64| {
        let [low, high] = ends_at(light, y);
        let hidden = polygons.iter().map(|polygon| ends_at(polygon, y)).filter(|[left, right]| left < right);
        let mut hidden: Vec<[f64; 2]> = hidden.collect();
        hidden.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut open, mut from) = (0.0, low);
        for [left, right] in hidden {
            open += (left.min(high) - from).max(0.0);
            from = from.max(right);
        }
        open + (high - from).max(0.0)
    };
    heights.windows(2).map(|pair| (pair[1] - pair[0]) * open_at(0.5 * (pair[0] + pair[1]))).sum()
}

/// The part of a convex polygon that is above a line.
fn above(polygon: &[DVec2], line: Vec3) -> Vec<DVec2> {
    let height = |p: DVec2| line.as_dvec3().dot(p.extend(1.0));
    let part = |[p, q]: [DVec2; 2]| {
        let cut = p.lerp(q, height(p) / (height(p) - height(q)));
        let is_cut = (height(p) > 0.0) != (height(q) > 0.0);
        [(height(p) > 0.0).then_some(p), is_cut.then_some(cut)].into_iter().flatten()
    };
    sides_of(polygon).flat_map(part).collect()
}

/// Rectangles and triangles about a window. If they are even, edges are level, upright, on each other and on the lines between cells.
fn random_polygons(random: &mut Random, count: u32, is_even: bool, [low, high]: [Vec2; 2]) -> Vec<Vec<Vec2>> {
    let mut place = |from: f32, to: f32| {
        let x = random.between(f64::from(from), f64::from(to)) as f32;
        if is_even { (32.0 * x).round() / 32.0 } else { x }
    };
    let mut polygon = |k: u32| {
        let at = Vec2::new(place(low.x - 0.25, high.x), place(low.y - 0.25, high.y));
        let [width, height] = [place(0.05, 0.5), place(0.05, 0.5)].map(|size| size.max(1.0 / 32.0));
        if k.is_multiple_of(3) {
            vec![at, at + Vec2::new(width, place(0.0, 0.5)), at + Vec2::new(0.0, height)]
        } else {
            [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]].map(|to| at + Vec2::from(to)).to_vec()
        }
    };
    (0..count).map(&mut polygon).collect()
}

/// Random polygons before a window, or before its part above a line: open parts have their area.
#[test]
fn open_parts_have_their_area() {
    const SLIVERS: f32 = 1e-9;
    let mut random = Random::new(17);
    let square = UnitSquare {
        right: Vec3::X,
        up: Vec3::Y,
        axis: Vec3::Z,
        center: Vec2::new(0.25, -0.125),
        half: Vec2::new(1.0, 0.5),
        disc: 3.0,
    };
    let mut mask = Mask::default();
    mask.reset_to(&square, 5, Vec3::Z, None);
    let [low, high] = [square.center - square.half, square.center + square.half];
    let window = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)].map(|p| p.as_dvec2());
    let (mut worst, mut total) = (0.0_f64, 0.0);
    for case in 0..600 {
        // Cells are finer behind the many.
        let count = if case % 100 == 99 { 120 } else { 1 + case % 40 };
        let polygons = random_polygons(&mut random, count, case % 3 != 0, [low, high]);
        let mut trapezoids = Trapezoids::default();
        for [p, q] in polygons.iter().flat_map(|polygon| sides_of(polygon)) {
            let slope = (q.x - p.x) / (q.y - p.y);
            trapezoids.add([p, q], [p.x - slope * p.y, slope], -1, Path([0.25, 0.1]));
        }
        let line = (case % 2 == 0).then(|| Vec3::new(1.0, 2.0, 0.25));
        let emits = Emits { mask: &mask, outline: None, facet: line };
        let sides = sides(&emits, &[]);
        let (narrowest, slivers) = (1e-6, SLIVERS);
        // Divided by rows as well, or not.
        let is_in_rows = case % 2 == 0;
        let bounds =
            Bounds { emits: &emits, sides: &sides, corners: &[], is_in_rows, low, high, rows: 32, narrowest, slivers };
        let is_in = |polygon: &[Vec2], p: Vec2| sides_of(polygon).all(|[a, b]| (b - a).perp_dot(p - a) > 0.0);
        let mut is_open = |p: Vec2| !polygons.iter().any(|polygon| is_in(polygon, p));
        let mut found = Vec::new();
        assert!(Cells::new(&trapezoids.pieces, &bounds, &mut found).run(&mut trapezoids.cells, &mut is_open));
        let open = open_numbers(&found, SLIVERS, &mut is_open).expect("rays agree");
        let area: f32 = found.iter().filter(|part| open.contains(&Some(part.number))).map(Trapezoid::area).sum();
        let light = line.map_or(window.to_vec(), |line| above(&window, line));
        let wide = |polygon: &Vec<Vec2>| polygon.iter().map(|p| p.as_dvec2()).collect();
        let want = open_area(&light, &polygons.iter().map(wide).collect::<Vec<_>>());
        worst = worst.max((f64::from(area) - want).abs());
        total += want;
    }
    println!("open parts of 600 windows, {total:.1} in all, differ by at most {worst:.1e}");
    assert!(worst < 1e-5 && total > 500.0, "{worst} {total}");
}

/// A floor whose edge is nearly level in a window that is far from the origin. Rounding leaves slivers along the edge with a surface less than there is; the rest is open,
/// although a ray through such a sliver meets the floor.
#[test]
fn slivers_along_a_level_edge_do_not_close_a_window() {
    let mut random = Random::new(5);
    let (mut dark, mut off) = (0, 0.0_f32);
    let mut mask = Mask::default();
    for _ in 0..20_000 {
        let mut between = |low: f64, high: f64| random.between(low, high) as f32;
        let half = Vec2::new(between(0.01, 0.1), between(0.3, 1.0));
        let center = Vec2::new(between(-0.2, 0.2), between(-3.0, 3.0));
        let [right, up, axis] = [Vec3::X, Vec3::Y, Vec3::Z];
        let square = UnitSquare { right, up, axis, center, half, disc: 5.0 };
        mask.reset_to(&square, 5, Vec3::Z, None);
        let (height, slope) = (center.y + half.y * between(-0.9, 0.0), between(-1e-4, 1e-4));
        let edge = |x: f32| Vec2::new(x, height + slope * x);
        let (from, to) = (between(-1.0, -0.4), between(0.4, 1.0));
        let floor = [edge(to), edge(from), Vec2::new(from, -9.0), Vec2::new(to, -9.0)];
        let mut trapezoids = Trapezoids::default();
        for [p, q] in sides_of(&floor) {
            let slope = (q.x - p.x) / (q.y - p.y);
            trapezoids.add([p, q], [p.x - slope * p.y, slope], -2, Path([center.x, 0.0]));
        }
        let emits = Emits { mask: &mask, outline: None, facet: None };
        let sides = sides(&emits, &[]);
        let [low, high] = [center - half, center + half];
        let narrowest = 1.0 / 32768.0 * half.x;
        let slivers = slivers(&square, narrowest);
        let (emits, sides, corners) = (&emits, &sides[..], &[][..]);
        let bounds = Bounds { emits, sides, corners, is_in_rows: false, low, high, rows: 32, narrowest, slivers };
        // Rays meet what they pass within rounding.
        let mut is_open = |p: Vec2| p.y > height + slope * p.x + 1e-6;
        let mut found = Vec::new();
        assert!(Cells::new(&trapezoids.pieces, &bounds, &mut found).run(&mut trapezoids.cells, &mut is_open));
        let open = open_numbers(&found, slivers, &mut is_open).expect("rays agree");
        let area: f32 = found.iter().filter(|part| open.contains(&Some(part.number))).map(Trapezoid::area).sum();
        let want = 2.0 * half.x * (high.y - height);
        dark += u32::from(area == 0.0);
        off = off.max((area / want - 1.0).abs());
    }
    println!("{dark} windows are dark, others off by {off}");
    assert!(dark == 0 && off < 1e-3);
}
