//! Triangles that cross each other before a window.

use super::{SQUARES, Seen, errors_beside, hull, square, square_seen};
use core::f64::consts::PI;
use glam::{DVec2, DVec3};
use lobe_core::{Random, Receiver};
use scene::{Mesh, Object, Proxy};
use test_scenes::{ROOM, room};

/// The radiance of a white diffuse point that sees a convex light through an opening, beside triangles beyond it: row by row of the openings' plane.
fn beside_triangles(at: &Receiver, [left, right, low, high]: [f64; 4], light: Seen, triangles: &[[DVec3; 3]]) -> f64 {
    const ROWS: u32 = 1500;
    const GAUSS: [[f64; 2]; 3] =
        [[-0.774_596_669_241_483_4, 5.0 / 9.0], [0.0, 8.0 / 9.0], [0.774_596_669_241_483_4, 5.0 / 9.0]];
    let (x, n) = (at.position.as_dvec3(), at.normal.as_dvec3());
    let z = f64::from(-ROOM.z);
    let height = x.z - z;
    if height < 1e-4 {
        return 0.0;
    }
    let on_plane = |p: &DVec3| (x + (p - x) * (-height / (p.z - x.z))).truncate();
    let light = hull(light(x).iter().map(on_plane).collect());
    let hidden: Vec<Vec<DVec2>> = triangles.iter().map(|t| t.iter().map(on_plane).collect()).collect();
    // Where a row crosses a polygon.
    let span = |polygon: &[DVec2], y: f64| {
        let ends = (0..polygon.len()).filter_map(|k| {
            let (p, q) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            ((p.y > y) != (q.y > y)).then(|| p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y)))
        });
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
    };
    let kernel = |p: DVec2| {
        let to = p.extend(z) - x;
        n.dot(to).max(0.0) * height / (PI * to.length_squared().powi(2))
    };
    let of_row = |row: u32| {
        let y = low + (high - low) * (f64::from(row) + 0.5) / f64::from(ROWS);
        let [from, to] = span(&light, y);
        let (mut from, to) = (from.max(left), to.min(right));
        let mut spans: Vec<[f64; 2]> = hidden.iter().map(|polygon| span(polygon, y)).filter(|[a, b]| a < b).collect();
        spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut sum = 0.0;
        for [a, b] in spans.into_iter().chain([[to, f64::INFINITY]]) {
            let (half, middle) = (0.5 * (a.min(to) - from), 0.5 * (a.min(to) + from));
            if half > 0.0 {
                sum += GAUSS
                    .map(|[place, weight]| half * weight * kernel(DVec2::new(middle + half * place, y)))
                    .iter()
                    .sum::<f64>();
            }
            from = from.max(b);
        }
        sum
    };
    (0..ROWS).map(of_row).sum::<f64>() * (high - low) / f64::from(ROWS)
}

/// Blades that stand before a window and cross each other: thousands of heights at which their outlines do.
#[test]
fn blades_before_windows_are_seen() {
    let window = [-0.6, 0.6, -0.2, 0.8];
    let mut random = Random::new(2);
    let mut blade = |k: u32| {
        let base = DVec3::new(
            random.between(-0.7, 0.7),
            random.between(-0.3, -0.2),
            f64::from(-ROOM.z) - 0.02 - 1e-3 * f64::from(k),
        );
        let tip = base + DVec3::new(random.between(-0.3, 0.3), random.between(0.4, 1.1), 0.0);
        [base, base + DVec3::X * random.between(0.01, 0.04), tip]
    };
    let blades: Vec<[DVec3; 3]> = (0..120).map(&mut blade).collect();
    let positions = blades.iter().flatten().map(|p| p.as_vec3()).collect();
    let triangles = (0..120).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    let mut scene = room(window.map(|side| side as f32), square(SQUARES[0]));
    scene.objects.push(Object::mesh("blades", mesh, 0, Proxy::None));
    let [mean, p99, dark] = errors_beside(&scene, None, |at| beside_triangles(at, window, square_seen::<0>, &blades));
    println!("blades: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
    assert!(mean < 0.0004 && p99 < 0.002 && dark < 1e-4, "{mean} {p99} {dark}");
}
