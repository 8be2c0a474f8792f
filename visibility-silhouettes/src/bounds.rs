//! Bounds of the silhouettes in a window.

use crate::select::Silhouettes;
use glam::{Vec2, Vec3};
use visibility_mask::UnitSquare;

/// Bounds larger than this fraction of a window are not used.
const USEFUL: f32 = 0.5;
/// Bounds are rounded outward to multiples of the window's sides over this number.
const PARTS: f32 = 65536.0;
/// Depths below this fraction of an edge's size are not projected.
const SHALLOW: f32 = 1e-5;

/// Two corners of a box around the silhouettes in a window; `None` if the box is most of the window, or if there are none.
pub(crate) fn bounds(silhouettes: &Silhouettes, window: &UnitSquare) -> Option<[Vec2; 2]> {
    let (origin, size) = (window.center - window.half, 2.0 * window.half);
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for i in 0..silhouettes.len() {
        let end = |c: usize| window.local(Vec3::from_array([c, c + 1, c + 2].map(|c| silhouettes.get(c, i))));
        let Some(edge) = part_in_front([end(0), end(3)]) else { continue };
        let Some([from, to]) = part_within(edge.map(|p| (p.truncate() / p.z - origin) / size)) else { continue };
        low = low.min((from.min(to) * PARTS).floor());
        high = high.max((from.max(to) * PARTS).ceil());
        if (high - low).element_product() > USEFUL * PARTS * PARTS {
            return None;
        }
    }
    let part = size / PARTS;
    (low.x <= high.x).then(|| [origin + part * low, origin + part * high])
}

/// The part of an edge in front of the receiver.
fn part_in_front([a, b]: [Vec3; 2]) -> Option<[Vec3; 2]> {
    let near = SHALLOW * (a.length() + b.length());
    if a.z < near && b.z < near {
        return None;
    }
    let cut = |from: Vec3, to: Vec3| (from + (to - from) * ((near - from.z) / (to.z - from.z))).with_z(near);
    Some([if a.z < near { cut(b, a) } else { a }, if b.z < near { cut(a, b) } else { b }])
}

/// The part of a line between two points that is in the unit square from 0 to 1: Y.-D. Liang and B. A. Barsky, *A New Concept and
/// Method for Line Clipping*, 1984.
fn part_within([start, end]: [Vec2; 2]) -> Option<[Vec2; 2]> {
    let along = end - start;
    let (mut from, mut to) = (0.0_f32, 1.0_f32);
    for k in 0..2 {
        if along[k] == 0.0 {
            if start[k] < 0.0 || start[k] > 1.0 {
                return None;
            }
            continue;
        }
        let [first, last] = [-start[k] / along[k], (1.0 - start[k]) / along[k]];
        from = from.max(first.min(last));
        to = to.min(first.max(last));
    }
    (from <= to).then(|| [start + along * from, start + along * to])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_list::Columns;
    use crate::select::NUMBERS;
    use lobe_core::oracle::Random;

    /// Against many points of random edges, in front of the receiver and behind it, in the window and beside it.
    #[test]
    fn bounds_hold_the_edges_of_the_window() {
        let mut random = Random::new(11);
        let (mut known, mut unknown) = (0, 0);
        for case in 0..500 {
            let half = Vec2::new(random.between(0.1, 1.0) as f32, random.between(0.1, 1.0) as f32);
            let window = UnitSquare { half, ..UnitSquare::default() };
            let mut silhouettes = Silhouettes::default();
            let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            for _ in 0..1 + case % 3 {
                let size = random.log_uniform(0.02, 2.0) as f32;
                let mut at = || Vec3::from_array([0.0; 3].map(|_: f32| random.between(-1.0, 1.0) as f32));
                let a = at() + 0.5 * Vec3::Z;
                let b = a + size * at();
                let mut numbers = [1.0; NUMBERS];
                numbers[..3].copy_from_slice(&a.to_array());
                numbers[3..6].copy_from_slice(&b.to_array());
                Columns::push(&mut silhouettes, numbers);
                for k in 0..=4000 {
                    let p = a + (b - a) * (k as f32 / 4000.0);
                    let on_plane = p.truncate() / p.z;
                    if p.z > 1e-3 && (on_plane.abs() - half).max_element() < 0.0 {
                        (low, high) = (low.min(on_plane), high.max(on_plane));
                    }
                }
            }
            let Some([from, to]) = bounds(&silhouettes, &window) else {
                unknown += 1;
                let all = 4.0 * half.element_product();
                assert!(low.x > high.x || (high - low).element_product() > 0.4 * all, "case {case}");
                continue;
            };
            known += 1;
            if low.x > high.x {
                // A corner that contains no point.
                continue;
            }
            assert!(from.cmple(low + 1e-6).all() && to.cmpge(high - 1e-6).all(), "case {case}");
            let beyond = (low - from).max(to - high).max_element();
            assert!(beyond < 0.02 * half.max_element(), "case {case}: {beyond}");
        }
        assert!(known > 100 && unknown > 50, "{known} {unknown}");
    }
}
