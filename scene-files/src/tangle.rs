//! Polygons that cross themselves, found in a bounded number of steps.

use core::f64::consts::TAU;
use glam::DVec2;

/// Steps for each corner, at most: visits of a cell by a side, and pairs of sides that are compared.
const STEPS: usize = 64;
/// Sides cross if their ends are at least so far beyond each other, as a part of the polygon's size: sides of files that only touch cross
/// by rounding.
const DEPTH: f64 = 1e-6;

/// Whether a polygon surely crosses itself: it turns around more or less often than once, or two of its sides cross. A polygon whose
/// sides are too long for [`STEPS`] and that turns around once is taken as one that does not.
pub(crate) fn is_tangled(flat: &[DVec2]) -> bool {
    turns_otherwise(flat) || has_crossing(flat)
}

/// Whether the sides of a polygon turn around otherwise than once in all, as those of polygons without crossings do.
fn turns_otherwise(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let sides: Vec<DVec2> = (0..n).map(|i| flat[(i + 1) % n] - flat[i]).filter(|side| *side != DVec2::ZERO).collect();
    let (mut sum, mut reversals) = (0.0, 0);
    for (i, side) in sides.iter().enumerate() {
        let next = sides[(i + 1) % sides.len()];
        let (across, along) = (side.perp_dot(next), side.dot(next));
        // A side that goes back on the one before it has turned to the left or to the right.
        if along < 0.0 && across.abs() <= 1e-5 * -along {
            reversals += 1;
        } else {
            sum += across.atan2(along);
        }
    }
    (sum.abs() / TAU - 1.0).abs() > 0.5 + 0.5 * f64::from(reversals)
}

/// Whether two sides cross. Sides are compared with those before them in the cells of a grid that they go through.
fn has_crossing(flat: &[DVec2]) -> bool {
    let n = flat.len();
    let (low, high) = flat.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    let (cells, size) = ((n as f64).sqrt().ceil().max(1.0), (high - low).max(DVec2::splat(f64::MIN_POSITIVE)));
    let depth = DEPTH * size.max_element();
    let scaled = |p: DVec2| (p - low) / size * cells;
    let count = cells as usize;
    let cell = |x: f64| (x.max(0.0) as usize).min(count - 1);
    let mut seen: Vec<Vec<u32>> = vec![Vec::new(); count * count];
    let mut steps = STEPS * n;
    let side = |i: usize| [flat[i], flat[(i + 1) % n]];
    for i in 0..n {
        let [a, b] = side(i).map(scaled);
        let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
        for row in cell(a.y)..=cell(b.y) {
            let at =
                |y: f64| if b.y > a.y { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0) } else { b.x };
            let ends = if b.y > a.y { [at(row as f64), at(row as f64 + 1.0)] } else { [a.x, b.x] };
            for column in cell(ends[0].min(ends[1]))..=cell(ends[0].max(ends[1])) {
                let others = &mut seen[row * count + column];
                let Some(left) = steps.checked_sub(1 + others.len()) else { return false };
                steps = left;
                if others.iter().any(|k| cross(side(i), side(*k as usize), depth)) {
                    return true;
                }
                others.push(i as u32);
            }
        }
    }
    false
}

/// Whether the ends of each of two sides are on both sides of the other one, and so far from it.
fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2], depth: f64) -> bool {
    let are_apart = |from: DVec2, to: DVec2, p: DVec2, q: DVec2| {
        let least = depth * (to - from).length();
        let [p, q] = [p, q].map(|x| (to - from).perp_dot(x - from));
        p.min(q) < -least && p.max(q) > least
    };
    are_apart(a, b, c, d) && are_apart(c, d, a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners at these radii, as many turns around in all.
    fn around(n: usize, turns: usize, radius: impl Fn(f64) -> f64) -> Vec<DVec2> {
        let corner = |i: usize| {
            let part = i as f64 / n as f64;
            DVec2::from_angle(TAU * turns as f64 * part) * radius(part)
        };
        (0..n).map(corner).collect()
    }

    #[test]
    fn outlines_without_crossings_are_none() {
        let star = |part: f64| if ((part * 1000.0).round() as usize).is_multiple_of(2) { 1.0 } else { 0.4 };
        assert!(!is_tangled(&around(1000, 1, star)));
        // A spiral of two sides.
        let mut spiral = around(2000, 20, |part| 1.0 + 20.0 * part);
        spiral.extend(around(2000, 20, |part| 1.5 + 20.0 * part).into_iter().rev());
        assert!(!is_tangled(&spiral));
        // A comb, of longer sides than there are steps for.
        let mut comb: Vec<DVec2> = (0..8000).map(|i| DVec2::new(f64::from(i), f64::from(i % 2) * 8000.0)).collect();
        comb.extend([DVec2::new(7999.0, -1.0), DVec2::new(0.0, -1.0)]);
        assert!(!is_tangled(&comb));
        // A ring, cut once: the two sides of the cut lie on each other.
        let mut ring = around(600, 1, |_| 2.0);
        ring.push(ring[0]);
        let hole = around(600, 1, |_| 1.0);
        ring.push(hole[0]);
        ring.extend(hole.into_iter().rev());
        assert!(!is_tangled(&ring));
        // A spike that has no width, and corners that come twice.
        let spike = [[0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [2.0, 3.0], [2.0, 9.0], [2.0, 3.0]].map(DVec2::from_array);
        assert!(!is_tangled(&spike));
    }

    #[test]
    fn crossings_are_found() {
        let eight = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(DVec2::from_array);
        assert!(is_tangled(&eight));
        for turns in [2, 3, 7] {
            assert!(turns_otherwise(&around(100_000, turns, |part| if part < 0.3 { 0.5 } else { 1.0 })), "{turns}");
        }
        // Two laps that cross each other.
        let laps = around(3000, 2, |part| 1.0 + 0.5 * (3.0 * part).sin());
        assert!(has_crossing(&laps));
    }
}
