//! Polygons as triangles.

use crate::tangle::is_tangled;
use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Larger polygons are cut by `earcut`, whose cost is n log n for most; smaller ones by the search below, which is as quick there.
const MOST_CORNERS: usize = 32;
/// Larger polygons that cross themselves are fans: the time of `earcut` goes with the square of their corners then.
const MOST_TANGLED: usize = 512;

/// Newell's normal, and the corners in its plane, relative to the first. Where parts on both sides cancel, as in a bow tie, the normal is that
/// of the largest part.
fn flattened(corners: &[DVec3]) -> (DVec3, Vec<DVec2>) {
    let (n, p) = (corners.len(), |i: usize| corners[i] - corners[0]);
    let parts = || (0..n).map(|i| p(i).cross(p((i + 1) % n)));
    let (sum, all) = parts().fold((DVec3::ZERO, 0.0), |(sum, all), part| (sum + part, all + part.length()));
    let normal = if sum.length() > 1e-9 * all {
        sum
    } else {
        parts().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(sum)
    };
    let normal = normal.normalize_or(DVec3::Z);
    let (u, v) = normal.any_orthonormal_pair();
    (normal, (0..n).map(p).map(|d| DVec2::new(u.dot(d), v.dot(d))).collect())
}

/// Whether a polygon became triangles that keep its area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cut {
    /// They do.
    Whole,
    /// The polygon crosses itself: they cover it somehow.
    Tangled,
}

/// As triangles from the first corner where these keep the polygon's area, as in convex ones; else as [`ears`].
pub(crate) fn fan_or_ears(corners: &[DVec3], out: &mut impl FnMut([usize; 3])) -> Cut {
    let n = corners.len();
    if n > 3 {
        let (normal, _) = flattened(corners);
        let side = |k: usize| (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]).dot(normal);
        if !(2..n).all(|k| side(k) >= 0.0) {
            return ears(corners, out);
        }
    }
    fan(n, out);
    Cut::Whole
}

fn fan(n: usize, out: &mut impl FnMut([usize; 3])) {
    (2..n).for_each(|k| out([0, k - 1, k]));
}

/// Cuts a polygon of three corners or more into triangles of corner numbers, in the plane of its normal, so that concave ones keep their
/// area. A polygon that crosses itself is covered somehow; a large one becomes triangles from its first corner.
///
/// # Cost
/// About a microsecond a corner; up to 17 where a small polygon crosses itself. Long sides close together cost the square of their number: a comb
/// of 100 000 corners 7 s.
pub(crate) fn ears(corners: &[DVec3], out: &mut impl FnMut([usize; 3])) -> Cut {
    if corners.len() == 3 {
        out([0, 1, 2]);
        return Cut::Whole;
    }
    let (_, flat) = flattened(corners);
    let cut = if is_convex_quad(&flat) || !is_tangled(&flat) { Cut::Whole } else { Cut::Tangled };
    if corners.len() > MOST_TANGLED && cut == Cut::Tangled {
        fan(corners.len(), out);
    } else if corners.len() > MOST_CORNERS {
        let mut triangles: Vec<u32> = Vec::new();
        Earcut::new().earcut(flat.iter().map(|p| p.to_array()), &[], &mut triangles);
        triangles.as_chunks::<3>().0.iter().for_each(|t| out(t.map(|i| i as usize)));
    } else {
        search(&flat, out);
    }
    cut
}

/// Whether a polygon is what most are: four turns to one side are one turn around.
fn is_convex_quad(flat: &[DVec2]) -> bool {
    let turn = |i: usize| (flat[(i + 1) % 4] - flat[i]).perp_dot(flat[(i + 2) % 4] - flat[(i + 1) % 4]);
    flat.len() == 4 && (0..4).all(|i| turn(i) > 0.0)
}

/// Ears one after the other, by a search through all corners.
fn search(flat: &[DVec2], out: &mut impl FnMut([usize; 3])) {
    let side = |a: usize, b: usize, c: usize| (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]);
    let mut left: Vec<usize> = (0..flat.len()).collect();
    while left.len() > 3 {
        let m = left.len();
        let around = |i: usize| (left[(i + m - 1) % m], left[i], left[(i + 1) % m]);
        let is_ear = |i: usize| {
            let (a, b, c) = around(i);
            // An ear turns left and holds no other corner.
            side(a, b, c) > 0.0
                && left.iter().all(|&q| {
                    q == a
                        || q == b
                        || q == c
                        || side(a, b, q) < 0.0
                        || side(b, c, q) < 0.0
                        || side(c, a, q) < 0.0
                        || flat[q] == flat[a]
                        || flat[q] == flat[b]
                        || flat[q] == flat[c]
                })
        };
        // A polygon that crosses itself may have no ear: cut any corner then.
        let ear = (0..m).find(|&i| is_ear(i)).unwrap_or(0);
        let (a, b, c) = around(ear);
        out([a, b, c]);
        left.remove(ear);
    }
    out([left[0], left[1], left[2]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a star, whose area is known, in a tilted plane.
    fn star(n: usize) -> (Vec<DVec3>, f64) {
        let angle = |k: usize| core::f64::consts::TAU * k as f64 / n as f64;
        let radius = |k: usize| if k.is_multiple_of(2) { 1.0 } else { 0.4 };
        let (u, v) = DVec3::new(0.3, -0.5, 0.8).normalize().any_orthonormal_pair();
        let corners = (0..n).map(|k| (u * angle(k).cos() + v * angle(k).sin()) * radius(k)).collect();
        (corners, 0.5 * n as f64 * 0.4 * (core::f64::consts::TAU / n as f64).sin())
    }

    #[test]
    fn concave_polygons_of_all_sizes_keep_their_area_and_their_side() {
        for n in [4, 8, 30, 34, 100, 5000] {
            let (corners, want) = star(n);
            let (normal, _) = flattened(&corners);
            for is_fan in [false, true] {
                let (mut area, mut count) = (0.0, 0);
                let mut out = |[a, b, c]: [usize; 3]| {
                    area += 0.5 * (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(normal);
                    count += 1;
                };
                let cut = if is_fan { fan_or_ears(&corners, &mut out) } else { ears(&corners, &mut out) };
                assert_eq!(cut, Cut::Whole);
                assert!((area / want - 1.0).abs() < 1e-9, "{n}: {area} {want}");
                assert!(count <= n - 2, "{n}: {count}");
            }
        }
    }

    #[test]
    fn small_polygons_that_cross_themselves_are_known() {
        let around = |k: usize| DVec2::from_angle(core::f64::consts::TAU * k as f64 / 5.0);
        let bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(DVec2::from_array);
        let dart = [[0.0, 0.0], [1.0, 1.0], [0.2, 0.0], [1.0, -1.0]].map(DVec2::from_array);
        let (pentagram, pentagon) = ([0, 2, 4, 1, 3].map(around), [0, 1, 2, 3, 4].map(around));
        let shapes: [(&[DVec2], Cut); 4] =
            [(&bow_tie, Cut::Tangled), (&pentagram, Cut::Tangled), (&dart, Cut::Whole), (&pentagon, Cut::Whole)];
        for (shape, want) in shapes {
            for (u, v) in [(DVec3::X, DVec3::Y), (DVec3::X, DVec3::Z), (DVec3::Z, DVec3::X), (DVec3::ONE, DVec3::Y)] {
                let corners: Vec<DVec3> = shape.iter().map(|p| u * p.x + v * p.y + DVec3::splat(7.0)).collect();
                let cuts = [ears(&corners, &mut |_| ()), fan_or_ears(&corners, &mut |_| ())];
                assert_eq!(cuts, [want; 2], "{shape:?} {u} {v}");
            }
        }
    }

    /// As many triangles as cut a polygon of these corners, within a time that cutting it ear by ear takes twenty times.
    fn ends_soon(corners: &[DVec3]) {
        let begin = std::time::Instant::now();
        for cut in [ears(corners, &mut |_| ()), fan_or_ears(corners, &mut |_| ())] {
            assert_eq!(cut, Cut::Tangled);
        }
        let mut count = 0;
        ears(corners, &mut |triangle| {
            assert!(triangle.iter().all(|i| *i < corners.len()));
            count += 1;
        });
        assert_eq!(count, corners.len() - 2);
        assert!(begin.elapsed().as_secs_f64() < 5.0, "{:?}", begin.elapsed());
    }

    #[test]
    fn polygons_of_random_corners_end_soon() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as f64 / f64::from(1_u32 << 31)
        };
        ends_soon(&(0..100_000).map(|_| DVec3::new(random(), random(), random())).collect::<Vec<_>>());
    }

    #[test]
    fn polygons_that_wind_several_times_end_soon() {
        let corner = |k: usize| {
            let angle = core::f64::consts::TAU * 7.0 * k as f64 / 100_000.0;
            DVec3::new(angle.cos(), angle.sin(), 0.0) * if k.is_multiple_of(2) { 0.5 } else { 1.0 }
        };
        ends_soon(&(0..100_000).map(corner).collect::<Vec<_>>());
    }
}
