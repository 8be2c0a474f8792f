//! The tubes that show what triangles show.

use super::lamp::Lamp;
use super::picture::{shown, shown_across};
use super::triangle::{Triangle, bounds, longest, moments};
use core::f64::consts::PI;

/// A tube with a shorter middle, in its radii, is a sphere.
const SHORT: f64 = 0.05;

/// The tube that shows what triangles show along the axis in which they are longest, `πr²`, and across it, `2rh + πr²`.
pub(super) fn capsule(triangles: &[&Triangle]) -> Lamp {
    let (middle, spread) = moments(triangles.iter().copied());
    let (axis, bound) = (longest(spread), bounds(triangles.iter().copied(), middle));
    let along = shown(triangles, middle, bound, axis);
    let radius = (along / PI).sqrt();
    let length = (shown_across(triangles, middle, bound, axis) - along) / (2.0 * radius);
    if length > SHORT * radius {
        Lamp::tube(middle, axis, length, radius)
    } else {
        Lamp::tube(middle, axis, 0.0, radius)
    }
}

/// The tube as long as triangles that shows what they show across: of a piece of a ring, to which others are joined at both ends.
pub(super) fn part_of_ring(triangles: &[&Triangle]) -> Lamp {
    let (middle, spread) = moments(triangles.iter().copied());
    let (axis, bound) = (longest(spread), bounds(triangles.iter().copied(), middle));
    let across = shown_across(triangles, middle, bound, axis);
    // Of points all along a length the variance is a twelfth of its square.
    let whole = (12.0 * axis.dot(spread * axis).max(0.0)).sqrt();
    let radius = 0.5 * across / whole;
    // Round ends show `πr²`.
    let length = whole - 0.5 * PI * radius;
    if length > SHORT * radius {
        Lamp::tube(middle, axis, length, radius)
    } else {
        Lamp::tube(middle, axis, 0.0, (across / PI).sqrt())
    }
}
