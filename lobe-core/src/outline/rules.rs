//! How many nodes a lobe over a quadrilateral of light needs.

use super::integral::STEEP;
use crate::microfacets::alpha_sq;
use crate::{PackedLobe, orthonormal_basis};
use glam::Vec3;

/// The number of rules, of 2, 4, 6, 8, 12 and 16 nodes; as a rule's number: more nodes than any would be needed.
pub(super) const NONE: usize = 6;

/// Below all rules' numbers: no node adds anything.
pub(super) const NOTHING: f32 = -1.0;

/// The distances of a pole from both ends of an interval over its length, from which on each rule takes `1/(1 + x²)²` to 5e-4 of its integral.
pub(super) const POLES: [f32; NONE] = [9.0, 2.6, 1.7, 1.37, 1.13, 1.07];

/// The halves of intervals, in standard deviations, up to which each rule takes a Gaussian to 5e-4 of its integral, wherever its peak is.
pub(super) const DEVIATIONS: [f32; NONE] = [0.25, 1.3, 2.6, 3.7, 5.8, 7.8];

/// Those of the rules of four and eight nodes, which parts of a light take.
pub(super) const POLES_OF_PARTS: [f32; 2] = [POLES[1], POLES[3]];
pub(super) const DEVIATIONS_OF_PARTS: [f32; 2] = [DEVIATIONS[1], DEVIATIONS[3]];

/// A receiver and the plane of a light before it: the receiver's normal, that of the plane away from it, and how far the plane is.
#[derive(Clone, Copy)]
pub(super) struct Before {
    pub(super) normal: Vec3,
    pub(super) axis: Vec3,
    pub(super) height: f32,
}

/// A corner before a receiver.
#[derive(Clone, Copy)]
struct Corner {
    from_receiver: Vec3,
    distance: f32,
    /// Its place on the light's plane, in the receiver's distance from that.
    place: Vec3,
    /// Its place in the widths of a lobe: the slope of its half vector in α, or its chord to the axis in standard deviations.
    slope: Vec3,
    /// How far it is along the lobe's axis.
    along: f32,
}

/// A lobe of a receiver before a light's plane.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    before: Before,
    axis: Vec3,
    is_facets: bool,
    is_steep: bool,
    /// Of microfacets two directions of the surface over the `α` along them.
    fine: [Vec3; 2],
    /// Of a power one over its standard deviation.
    narrowness: f32,
}

impl Shape {
    #[inline(always)]
    pub(super) fn new(before: Before, lobe: &PackedLobe) -> Self {
        let (u, v) = orthonormal_basis(before.normal);
        let fine = 1.0 / alpha_sq(lobe.exponent).sqrt();
        Self {
            before,
            axis: lobe.axis,
            is_facets: lobe.kind >= PackedLobe::MICROFACETS_F0,
            is_steep: lobe.exponent >= STEEP,
            fine: [u * fine, v * fine],
            narrowness: (lobe.exponent + 1.0).sqrt(),
        }
    }

    /// Of microfacets with a grain: two directions of the surface over the `α` along them.
    pub(super) const fn with_fine(self, fine: [Vec3; 2]) -> Self {
        Self { fine, ..self }
    }

    #[inline(always)]
    fn slope(&self, direction: Vec3) -> Vec3 {
        let h = direction + self.axis;
        let flat = 1.0 / larger(self.before.normal.dot(h), 1e-4);
        let along = self.axis.dot(direction);
        let chord = (direction - self.axis * along) * (self.narrowness / larger(0.5 + 0.5 * along, 1e-4).sqrt());
        let slope = Vec3::new(self.fine[0].dot(h) * flat, self.fine[1].dot(h) * flat, 0.0);
        if self.is_facets { slope } else { chord }
    }

    #[inline(always)]
    fn corner(&self, p: Vec3) -> Corner {
        let distance = p.length();
        let Before { axis, height, .. } = self.before;
        let place = (p - axis * axis.dot(p)) * (1.0 / larger(height, 1e-30));
        let slope = self.slope(p * (1.0 / distance));
        Corner { from_receiver: p, distance, place, slope, along: self.axis.dot(p) }
    }

    /// The rule along two opposite sides.
    #[inline(always)]
    fn rule(&self, [a, b]: [&Corner; 2], [c, d]: [&Corner; 2], bend: f32) -> f32 {
        let of_plane = poles([a.place, b.place], [c.place, d.place], 0.0);
        let of_facets = poles([a.slope, b.slope], [c.slope, d.slope], bend);
        let root = smaller(root(a.along, b.along), root(c.along, d.along));
        let of_power = if self.is_steep { 1e30 } else { root };
        let half = larger(half(a, b), half(c, d));
        let of_lobe = if self.is_facets { of_facets } else { of_power };
        rule(smaller(of_plane, of_lobe), if self.is_facets { 0.0 } else { half })
    }
}

#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Where a line between two heights is at zero: from its middle, in halves of its length.
#[inline(always)]
fn root(from: f32, to: f32) -> f32 {
    (from + to).abs() / larger((to - from).abs(), 1e-30)
}

/// Half the length of a side in standard deviations, if all of it were as fine as where the lobe is largest: a step of a line turns most where that is near.
#[inline(always)]
fn half(a: &Corner, b: &Corner) -> f32 {
    let turned = b.slope - a.slope;
    let square = turned.length_squared();
    let part = -a.slope.dot(turned) / larger(square, 1e-30);
    let part = smaller(larger(part, 0.0), 1.0);
    let part = part * a.distance / (part * a.distance + (1.0 - part) * b.distance);
    let peak = a.from_receiver + (b.from_receiver - a.from_receiver) * part;
    0.5 * square.sqrt() * a.distance * b.distance / peak.length_squared()
}

/// The numbers of the rules along both sides of a quadrilateral before a receiver, `NONE` where none is enough and [`NOTHING`] where the lobe is nothing. Lobes of an exponent below [`STEEP`] are above
/// their horizon there.
#[inline(always)]
pub(super) fn rules([a, b, c, d]: [Vec3; 4], shape: &Shape) -> [f32; 2] {
    let middle = 0.25 * (a + b + c + d);
    let middle = shape.slope(middle * (1.0 / middle.length()));
    let (a, b, c, d) = (shape.corner(a), shape.corner(b), shape.corner(c), shape.corner(d));
    let bend = 2.0 * (middle - 0.25 * (a.slope + b.slope + c.slope + d.slope)).length();
    // Beyond seven deviations a power is nothing.
    let reach = |corner: &Corner| (corner.slope - middle).length_squared();
    let reach = larger(larger(reach(&a), reach(&b)), larger(reach(&c), reach(&d))).sqrt();
    let is_nothing = !shape.is_facets & shape.is_steep & (middle.length() - 1.5 * reach > 7.0);
    let (u, v) = (shape.rule([&a, &b], [&d, &c], bend), shape.rule([&a, &d], [&b, &c], bend));
    [if is_nothing { NOTHING } else { u }, if is_nothing { NOTHING } else { v }]
}

/// The first rule that is enough.
#[inline(always)]
fn rule(pole: f32, deviations: f32) -> f32 {
    let more = |k: usize| if (pole >= POLES[k]) & (deviations <= DEVIATIONS[k]) { 0.0 } else { 1.0 };
    more(0) + more(1) + more(2) + more(3) + more(4) + more(5)
}

/// The least distances of a pole from both ends of a line over its length, of the lines between two: the pole is at 1 beside the origin, and these lines bend as far
/// as this.
#[inline(always)]
fn poles(one: [Vec3; 2], other: [Vec3; 2], bend: f32) -> f32 {
    let along = |[from, to]: [Vec3; 2]| {
        let along = to - from;
        let square = along.length_squared();
        let length = (if square > 1e-30 { square } else { 1e-30 }).sqrt();
        (along * (1.0 / length), length)
    };
    let ((one_way, one_length), (other_way, other_length)) = (along(one), along(other));
    let aside = |from: Vec3, way: Vec3| from - way * from.dot(way);
    let (one_aside, other_aside) = (aside(one[0], one_way), aside(other[0], other_way));
    let is_between = one_aside.dot(other_aside) <= 0.0;
    let pole = |[from, to]: [Vec3; 2], way: Vec3, length: f32, aside: Vec3| {
        let aside = aside.length() - bend;
        let height = 1.0 + if (aside > 0.0) & !is_between { aside * aside } else { 0.0 };
        let (start, end) = (from.dot(way), to.dot(way));
        ((height + start * start).sqrt() + (height + end * end).sqrt()) / length
    };
    let (a, b) = (pole(one, one_way, one_length, one_aside), pole(other, other_way, other_length, other_aside));
    if a < b { a } else { b }
}
