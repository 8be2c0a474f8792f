//! Windows that are wide in angle, in parts of about one angle.

use crate::UnitSquare;
use glam::{UVec2, Vec2};
use lobe_core::Outline;

/// Windows that reach no farther than this, in units of what is seen in them, are not divided.
const NARROW: f32 = 3.0;
/// The same of lights that are not long: their parts are many, and even samples do as far as this.
const WIDE: f32 = 4.0;
/// Of long lights where the first part to either side ends, and where each ends in the units of the one before it.
const LONG: [f32; 2] = [0.4, 2.5];
/// The same of other lights: fewer parts, which lie side by side and one above the other.
const ALL_AROUND: [f32; 2] = [2.0, 6.0];
/// The most parts to either side: what is farther away adds a thousandth.
const MOST: usize = 5;

/// Where the light of a wide window is, in its plane: about a point, as far as a length.
///
/// Samples are even on the plane, and a light far beside the foot of a receiver's perpendicular is hardly seen. So parts of the window are
/// narrow at this point and grow with the distance from it; each has a mask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spread {
    peak: Vec2,
    scale: f32,
    is_long: bool,
}

impl Spread {
    /// Of what a broad lobe sees of an outline in a window; none where even samples do.
    pub(crate) fn of_outline(outline: &Outline, window: &UnitSquare) -> Option<Self> {
        let is_long = outline.roundness() <= SLENDER;
        let about = Self::of_window(window, is_long);
        let least = if is_long { NARROW } else { WIDE };
        let is_even = outline.has_sides() || window.half.max_element() <= least * about.scale;
        (!is_even).then_some(about)
    }

    fn of_window(window: &UnitSquare, is_long: bool) -> Self {
        let (low, high) = (window.center - window.half, window.center + window.half);
        let peak = Vec2::ZERO.clamp(low, high);
        Self { peak, scale: (1.0 + peak.length_squared()).sqrt(), is_long }
    }

    /// About a point of an outline's plane.
    pub(crate) fn about(peak: Vec2, scale: f32, outline: &Outline) -> Self {
        Self { peak, scale, is_long: outline.roundness() <= SLENDER }
    }

    /// Whether a window is so wide that it has parts.
    pub(crate) fn divides(&self, window: &UnitSquare) -> bool {
        window.half.max_element() > NARROW * self.scale
    }

    /// The parts of a window, row by row, and how many are side by side and one above the other.
    pub(crate) fn parts(&self, window: &UnitSquare, grid: UVec2) -> (Vec<UnitSquare>, UVec2) {
        let axis = |axis: usize| {
            let (low, high) = (window.center[axis] - window.half[axis], window.center[axis] + window.half[axis]);
            self.cuts([low, high], self.peak[axis], grid[axis])
        };
        let [columns, rows] = [axis(0), axis(1)];
        let count = UVec2::new(columns.len() as u32 - 1, rows.len() as u32 - 1);
        let part = |y: &[f32], x: &[f32]| {
            let (low, high) = (Vec2::new(x[0], y[0]), Vec2::new(x[1], y[1]));
            UnitSquare { center: 0.5 * (low + high), half: 0.5 * (high - low), ..*window }
        };
        (rows.windows(2).flat_map(|y| columns.windows(2).map(move |x| part(y, x))).collect(), count)
    }

    /// Where an interval is cut, its ends among them; each part is cut into equal ones once more.
    fn cuts(&self, [low, high]: [f32; 2], peak: f32, even: u32) -> Vec<f32> {
        let mut cuts = vec![low, high];
        if high - low > 2.0 * NARROW * self.scale {
            let [first, growth] = if self.is_long { LONG } else { ALL_AROUND };
            let steps = (0..MOST as i32 - 1).map(|k| first * self.scale * growth.powi(k));
            let places = steps.flat_map(|step| [peak - step, peak + step]).chain(self.is_long.then_some(peak));
            // A part that would be next to nothing goes to its neighbour.
            let slack = 0.5 * first * self.scale;
            cuts.extend(places.filter(|x| *x > low + slack && *x < high - slack));
            cuts.sort_by(f32::total_cmp);
        }
        let part = |pair: &[f32]| {
            let [from, to] = [pair[0], pair[1]];
            (0..even).map(move |k| from + (to - from) * (k as f32 / even as f32))
        };
        cuts.windows(2).flat_map(part).chain([high]).collect()
    }
}

/// The direction of rows on a light that is long and wide in angle: along it, but across its diagonal, so that edges along it cross many rows.
/// Of the two diagonals the one that is more `across` the edges; none of other lights.
pub(crate) fn along(outline: &Outline, across: glam::Vec3) -> Option<glam::Vec3> {
    let corners = outline.corners();
    let middle = outline.middle();
    let reach = corners.iter().map(|p| p.distance_squared(middle)).fold(0.0, f32::max).sqrt();
    let is_thread = outline.roundness() < THREAD;
    if outline.has_sides() || !is_thread && reach < NARROW * outline.height() || outline.roundness() > SLENDER {
        return None;
    }
    // Both ways from the farthest corner.
    let far = corners
        .iter()
        .copied()
        .reduce(|a, b| if b.distance_squared(middle) > a.distance_squared(middle) { b } else { a })?;
    let long = (far - middle).normalize();
    let side = outline.axis().cross(long);
    let width = corners.iter().map(|p| side.dot(*p - middle).abs()).fold(0.0, f32::max);
    let tilt = side * (width / reach);
    let [one, other] = [long + tilt, long - tilt];
    Some(if one.dot(across).abs() < other.dot(across).abs() { other } else { one })
}

/// The roundness of a light from which on it is not long.
const SLENDER: f32 = 0.15;
/// Rows go along a light that is as thin as this, however little of the view it takes: rows across it would see steps.
const THREAD: f32 = 0.01;

#[cfg(test)]
mod tests {
    use super::*;

    /// Parts fill the window, and meet.
    #[test]
    fn parts_fill_the_window() {
        for (is_long, half) in
            [(true, Vec2::new(40.0, 2.0)), (false, Vec2::new(40.0, 30.0)), (false, Vec2::splat(900.0))]
        {
            let window = UnitSquare { center: Vec2::new(3.0, 0.2), half, ..UnitSquare::default() };
            let spread = Spread::of_window(&window, is_long);
            assert!(spread.divides(&window));
            for grid in [UVec2::ONE, UVec2::new(2, 2)] {
                let (parts, count) = spread.parts(&window, grid);
                assert_eq!(parts.len() as u32, count.element_product());
                assert!(parts.len() <= 81 * grid.element_product() as usize, "{}", parts.len());
                let area = |part: &UnitSquare| 4.0 * part.half.element_product();
                let sum: f32 = parts.iter().map(area).sum();
                assert!((sum / area(&window) - 1.0).abs() < 1e-5, "{sum}");
                for pair in parts[..count.x as usize].windows(2) {
                    let (end, start) = (pair[0].center.x + pair[0].half.x, pair[1].center.x - pair[1].half.x);
                    assert!((end - start).abs() < 1e-4 * half.x && pair.iter().all(|part| part.half.x > 0.0));
                }
            }
            let narrow = UnitSquare { half: Vec2::splat(2.4), center: Vec2::ZERO, ..window };
            assert!(!Spread::of_window(&narrow, is_long).divides(&narrow));
        }
    }
}
